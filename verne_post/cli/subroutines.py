"""Files of subroutines that a program calls, from its own folder and below: read before the program is."""

import re
from pathlib import Path
from typing import Final

import click

#: Endings under which a file is looked for.
ENDINGS: Final = (".ngc", ".nc")
_NAMED: Final = re.compile(rb"O\s*<([^<>\n]+)>\s*CALL", re.IGNORECASE)
_NUMBERED: Final = re.compile(
    rb"(?:O\s*([0-9]+)\s*CALL)|(?:M98[^\n]*?P\s*([0-9]+))|(?:P\s*([0-9]+)[^\n]*?M98)", re.IGNORECASE
)
_COMPUTED: Final = re.compile(rb"O\s*[#\[][^\n]*CALL|P\s*[#\[][^\n]*M98|M98[^\n]*P\s*[#\[]", re.IGNORECASE)


def gather(source: bytes, folder: Path, paths: tuple[str, ...]) -> dict[str, bytes]:
    """Text of every file that the program, or a file that it calls, may call.

    Parameters
    ----------
    source : bytes
        The program.
    folder : Path
        Its folder; nothing outside is read.
    paths : tuple of str
        Further folders, below that one.

    Raises
    ------
    click.UsageError
        For a path that leaves the folder, or does not exist.
    """
    known = _files(folder, paths)
    found: dict[str, bytes] = {}
    waiting = [source]
    while waiting:
        text = waiting.pop()
        for name in _called(text, known):
            if name in known and name not in found:
                found[name] = known[name].read_bytes()
                waiting.append(found[name])
    return found


def _called(text: bytes, known: dict[str, Path]) -> list[str]:
    """Names without ending of the files that a text may call."""
    if not re.search(rb"CALL|M98", text, re.IGNORECASE):
        return []
    if _COMPUTED.search(text):
        return list(known)
    names = [re.sub(rb"[ \t]", b"", found.group(1)).decode("latin-1").lower() for found in _NAMED.finditer(text)]
    for found in _NUMBERED.finditer(text):
        number = int(next(group for group in found.groups() if group is not None)) % 10_000_000
        names += [
            f"{form}{value}"
            for value in (number, f"{number:04d}", number % 10_000, f"{number % 10_000:04d}")
            for form in ("", "o")
        ]
    return names


def _files(folder: Path, paths: tuple[str, ...]) -> dict[str, Path]:
    """Files by name without ending, in lower case; the first folder that has one counts."""
    root = folder.resolve()
    found: dict[str, Path] = {}
    for path in (".", *paths):
        place = (root / path).resolve()
        if not place.is_relative_to(root):
            raise click.UsageError(f"--subroutine-path {path}: lies outside the folder of the program, {folder}")
        if not place.is_dir():
            raise click.UsageError(f"--subroutine-path {path}: there is no such folder in {folder}")
        for ending in ENDINGS:
            for file in sorted(place.glob("*")):
                inside = file.is_file() and file.resolve().is_relative_to(root)
                if inside and file.suffix.lower() == ending:
                    found.setdefault(file.stem.lower(), file)
    return found
