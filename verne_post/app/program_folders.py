"""Programs in folders: by which endings they are known, where none are looked for, and how their rows are named."""

import re
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import Final

from verne_post.config.beside import lies_in

#: Endings of programs that are looked for in folders.
PROGRAMS: Final = (
    ".nc",
    ".ngc",
    ".tap",
    ".gcode",
    ".cnc",
    ".mpf",
    ".h",
    ".cls",
    ".clsf",
    ".apt",
    ".aptsource",
    ".ncl",
    ".cl",
)
#: So programs begin: with % alone in its line, O and a number, or BEGIN PGM. So many bytes are read for that.
_BEGIN: Final = re.compile(rb"\s*+(?:%[ \t]*+\r?\n|[O:]\d++[\s(]|(?:0[ \t]++)?BEGIN PGM\b)")
_HEAD: Final = 1000
#: Other programs begin with blocks, beside remarks: letters and numbers, and soon a G word.
_REMARK: Final = re.compile(rb"\([^()]*+\)|;.*+")
_BLOCK: Final = re.compile(rb"/?(?:[A-Z][-+]?+(?:\d++\.?\d*+|\.\d++))++")
_G_WORD: Final = re.compile(rb"(?:N\d++)?G\d")
_N_BLOCKS: Final = 3
_N_NAMED: Final = 5  #: Files that a line names; it counts the others.
LOOKED_FOR: Final = f"looked for {', '.join(PROGRAMS)}, but not in hidden folders"


def find_programs_inside(folder: Path, but_in: Path | None, wrong: list[str]) -> list[tuple[str, Path]]:
    """The programs of a folder and those below it, without hidden ones; links that lead out are `wrong`."""
    left_out = None if but_in is None else but_in.resolve()
    files = sorted(
        one
        for one in folder.rglob("*")
        if one.suffix.lower() in PROGRAMS and not _is_hidden(one.relative_to(folder).parent) and one.is_file()
    )
    wrong += [
        f"{one}: is a link that leads out of {folder}, which is searched; name it by itself"
        for one in files
        if not lies_in(folder, one)
    ]
    own = [one for one in files if left_out is None or left_out not in one.resolve().parents]
    return [(str(one), one.relative_to(folder)) for one in own]


def name_rows(place: Path, suffix: str) -> tuple[Path, Path]:
    """The names that the rows of a program may have: part.csv; part.nc.csv where part.h is there too."""
    return place.with_suffix(suffix), place.with_name(place.name + suffix)


def choose_names(programs: Sequence[tuple[str, Path]], suffix: str) -> list[Path]:
    """The name that the rows of each program have, by its place in the structure of its folder."""
    sharing: dict[Path, set[str]] = {}
    for program, place in programs:
        sharing.setdefault(name_rows(place, suffix)[0], set()).add(program)
    names = [name_rows(place, suffix) for _program, place in programs]
    return [bare if len(sharing[bare]) == 1 else whole for bare, whole in names]


def describe_passed_over(folders: Iterable[Path], but_in: Path | None = None, called: Collection[str] = ()) -> str:
    """One line that names files which begin as programs do, and whose endings are not those of programs: ``O1001``.

    Those are left out that a program calls. Empty where there is none.
    """
    left_out = None if but_in is None else but_in.resolve()
    found = [
        one
        for folder in folders
        for one in sorted(folder.rglob("*"))
        if one.suffix.lower() not in PROGRAMS
        and one.name not in called
        and not _is_hidden(one.relative_to(folder))
        and lies_in(folder, one)
        and one.is_file()
        and (left_out is None or left_out not in one.resolve().parents)
        and _is_like_program(one)
    ]
    if not found:
        return ""
    more = f" and {len(found) - _N_NAMED} more" if len(found) > _N_NAMED else ""
    shown = ", ".join(map(str, found[:_N_NAMED]))
    return f"{shown}{more}: their endings are none of programs; name each file, as {found[0]}"


def describe_lack(folder: Path, but_in: Path | None = None) -> str:
    """What was looked for in a folder without programs, and which of its files may be some."""
    passed = describe_passed_over([folder], but_in)
    return f"{LOOKED_FOR}{f'; not taken: {passed}' if passed else ''}"


def _is_like_program(file: Path) -> bool:
    try:
        with file.open("rb") as opened:
            head = opened.read(_HEAD).removeprefix(b"\xef\xbb\xbf")
    except OSError:
        return False
    return _BEGIN.match(head) is not None or _is_like_blocks(head)


def _is_like_blocks(head: bytes) -> bool:
    """Whether the first lines of a text that are no remarks are two or three blocks, one of them with a G word.

    A tool table (T1 P1 Z80) has no G word, and prose has no line of words with numbers alone.
    """
    lines = head.splitlines(keepends=True)
    if len(head) >= _HEAD - 3:
        lines.pop()  # may be cut
    bare = [b"".join(_REMARK.sub(b"", line).upper().split()) for line in lines]
    blocks = [line for line in bare if line][:_N_BLOCKS]
    return (
        len(blocks) > 1
        and all(_BLOCK.fullmatch(line) for line in blocks)
        and any(_G_WORD.match(line) for line in blocks)
    )


def _is_hidden(folder: Path) -> bool:
    """Whether the name of a folder or of one above it begins with a dot: those of tools, with C headers (.h) or old
    copies.
    """
    return any(part.startswith(".") for part in folder.parts)
