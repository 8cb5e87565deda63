"""Files of subroutines that a program calls, from its own folder and below: read before the program is."""

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Final

from verne_post.base.long_text import Text
from verne_post.base.suggestions import find_meant
from verne_post.gcode.calls import list_near_programs, spell_program
from verne_post.gcode.words import read_whole_lines
from verne_post.model.findings import UsageError

#: Endings under which a file is looked for.
ENDINGS: Final = (".ngc", ".nc", ".h", ".spf", ".mpf")
#: Endings of files that are called by their bare names (Siemens).
_CALLED_BY_NAME: Final = (".spf", ".mpf")
#: In lower case: a text is searched for letters of one case ten times as fast as for those of both.
_CALL_WORDS: Final = (b"call", b"m98")
_MACRO_CALL: Final = re.compile(rb"g0*6[56]")
_NAMED: Final = re.compile(rb"O\s*<([^<>\n]+)>\s*CALL", re.IGNORECASE)
_NUMBERED: Final = re.compile(
    rb"(?:O\s*([0-9]+)\s*CALL)|(?:(?:M98|G0*6[56](?![0-9]))[^\n]*?P\s*([0-9]+))|(?:P\s*([0-9]+)[^\n]*?M98)",
    re.IGNORECASE,
)
#: A word that may be the name of a file, and bytes of a text in which names that are nearly one are looked for.
_FIRST_WORD: Final = re.compile(rb"^[ \t]*+(?:N\d+[ \t]*+)?([A-Z_][A-Z0-9_]{2,}+)(?=[ \t]*+[(;\r\n])", re.I | re.M)
_LONGEST_SEARCHED: Final = 1_000_000
#: A file with the number of a program; one that has no ending, as controls store it, keeps a point in its place.
_PROGRAM_NUMBER: Final = re.compile(r"o?0*[1-9]\d{0,6}|o0*[1-9]\d{0,6}\.")
#: CALL PGM of Klartext, perhaps with a path of the control.
_PROGRAM: Final = re.compile(rb"CALL[ \t]+PGM[ \t]+\"?(?:[^\"\n;~]*[\\/:])?([^\"\n;~\\/:]+)", re.IGNORECASE)
_COMPUTED: Final = re.compile(rb"O\s*[#\[][^\n]*CALL|P\s*[#\[][^\n]*M98|M98[^\n]*P\s*[#\[]", re.IGNORECASE)


def collect_subprograms(
    source: Text, folder: Path, paths: tuple[str, ...], read: Callable[[Path, str], bytes]
) -> tuple[dict[str, bytes], dict[str, str]]:
    """Text of every file that the program, or a file that it calls, may call; and its path below the folder.

    Parameters
    ----------
    folder : Path
        Its folder; nothing outside is read.
    paths : tuple of str
        Further folders, below that one.
    read : callable
        Reads a file, given its path and its name in calls.

    Raises
    ------
    UsageError
        For a path that leaves the folder, or does not exist.
    """
    root = folder.resolve()
    places = _list_folders(folder, root, paths)
    texts: dict[str, bytes] = {}
    known = _find_files(root, places)
    waiting: list[Text] = [source]
    while waiting:
        text = waiting.pop()
        for name in _find_called(text, known):
            if name in known and name not in texts:
                texts[name] = read(known[name], name)
                waiting.append(texts[name])
    return texts, {name: known[name].relative_to(root).as_posix() for name in texts}


def list_callable_files(folder: Path, paths: tuple[str, ...]) -> list[Path]:
    """Every file that a program of a folder may call.

    Raises
    ------
    UsageError
        As :func:`collect_subprograms`.
    """
    root = folder.resolve()
    return list(_find_files(root, _list_folders(folder, root, paths)).values())


def names_file(text: Text, path: Path) -> bool:
    """Whether a text calls a file by its name or number; not where it computes what it calls.

    The lines that have it at all are few, and are found fast; blanks may stand inside a name.
    """
    name = path.stem.lower()
    letters = os.fsencode(name.lstrip("o0") if _PROGRAM_NUMBER.fullmatch(name) else name)
    for chunk in map(bytes.lower, read_whole_lines(text)):
        if letters in chunk.translate(None, b" \t"):
            lines = (line for line in chunk.split(b"\n") if letters in line.translate(None, b" \t"))
            if name in _find_named(b"\n".join(lines), {name: path}):
                return True
    return False


def _find_called(text: Text, known: dict[str, Path]) -> list[str]:
    """Names, without ending, of the files that a text may call."""
    if _may_call(text) and _COMPUTED.search(text):
        return list(known)
    called_by_name = [name for name, path in known.items() if path.suffix.lower() in _CALLED_BY_NAME]
    return [*_find_named(text, known), *_find_meant_names(text, called_by_name), *_find_meant_numbers(text, known)]


def _find_meant_numbers(text: Text, known: dict[str, Path]) -> list[str]:
    """Those of the files with a number of which a number in a call without a file is a slip."""
    numbers = {name.lstrip("o0").rstrip("."): name for name in known if _PROGRAM_NUMBER.fullmatch(name)}
    if not numbers or not _may_call(text):
        return []
    called = {str(one) for one in _list_numbers(text)} - numbers.keys()
    return [numbers[near] for one in sorted(called) for near in list_near_programs(one, numbers)]


def _list_numbers(text: Text) -> list[int]:
    """The numbers in the calls of a text."""
    found = (next(group for group in one.groups() if group is not None) for one in _NUMBERED.finditer(text))
    return [int(number) % 10_000_000 for number in found]


def _find_named(text: Text, known: dict[str, Path]) -> list[str]:
    """Names, without ending, in the calls of a text, and in Siemens the names of files that it has."""
    by_name = _find_names(text, [name for name, path in known.items() if path.suffix.lower() in _CALLED_BY_NAME])
    if not _may_call(text):
        return by_name
    names = [re.sub(rb"[ \t]", b"", found.group(1)).decode("latin-1").lower() for found in _NAMED.finditer(text)]
    names += [name.strip().decode("latin-1").lower().removesuffix(".h") for name in _PROGRAM.findall(text)]
    names += by_name
    for number in _list_numbers(text):
        names += [*spell_program(number), *spell_program(number % 10_000)]
    return names


def _may_call(text: Text) -> bool:
    """Whether a text has letters that every call has."""
    return any(
        any(word in lines for word in _CALL_WORDS) or _MACRO_CALL.search(lines)
        for lines in map(bytes.lower, read_whole_lines(text))
    )


def _find_names(text: Text, names: list[str]) -> list[str]:
    """Those of the names of files, in lower case, that a text has as words."""
    missing = {
        name: (letters := os.fsencode(name), re.compile(rb"(?<![a-z0-9_])" + re.escape(letters) + rb"(?![a-z0-9])"))
        for name in names
    }
    chunks = map(bytes.lower, read_whole_lines(text))
    while missing and (lines := next(chunks, None)) is not None:
        missing = {name: one for name, one in missing.items() if not (one[0] in lines and one[1].search(lines))}
    return [name for name in names if name not in missing]


def _find_meant_names(text: Text, names: list[str]) -> list[str]:
    """Those of the names of files of which the first word of a line is a slip: a message then says what is meant."""
    if not names or len(text) > _LONGEST_SEARCHED:
        return []
    words = {word.decode().lower() for word in _FIRST_WORD.findall(bytes(text))}
    return [near for word in sorted(words) if word not in names and (near := find_meant(word, names, slip_alone=True))]


def _list_folders(folder: Path, root: Path, paths: tuple[str, ...]) -> list[Path]:
    """The folders to look in, in their order."""
    places = []
    for path in (".", *paths):
        place = (root / path).resolve()
        if not place.is_relative_to(root):
            raise UsageError("--subroutine-path", f"{path}: lies outside the folder of the program, {folder}")
        if not place.is_dir():
            raise UsageError("--subroutine-path", f"{path}: there is no such folder in {folder}")
        places.append(place)
    return places


def _find_files(root: Path, places: list[Path]) -> dict[str, Path]:
    """Files by name without ending, in lower case; the first folder that has one counts.

    ``O2000`` as controls store it is "o2000.": beside O2000.nc it is another one.
    """
    by_name: dict[str, Path] = {}
    for place in places:
        with os.scandir(place) as entries:
            # only a link can lead out of a folder that lies inside
            files = sorted(
                Path(entry.path)
                for entry in entries
                if os.path.isfile(entry.path)  # False for a circle of links
                and (not entry.is_symlink() or Path(entry.path).resolve().is_relative_to(root))
            )
        for ending in ENDINGS:
            for file in files:
                if file.suffix.lower() == ending:
                    by_name.setdefault(file.stem.lower(), file)
        for file in files:
            if not file.suffix and _PROGRAM_NUMBER.fullmatch(stored := f"{file.name.lower()}."):
                by_name.setdefault(stored, file)
    return by_name
