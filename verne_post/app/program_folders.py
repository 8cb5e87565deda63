"""Programs in folders: by which endings they are known, where none are looked for, and how their rows are named."""

import re
from collections.abc import Sequence
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
_BEGIN: Final = re.compile(rb"\s*+(?:%[ \t]*+\r?\n|[O:]\d++\s|(?:0[ \t]++)?BEGIN PGM\b)")
_HEAD: Final = 400
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


def find_passed_over(folder: Path) -> list[Path]:
    """Files of a folder that begin as programs do, and whose ending is not one of programs: ``O1001``, ``a.eia``."""
    files = sorted(folder.rglob("*"))
    others = (one for one in files if one.suffix.lower() not in PROGRAMS and lies_in(folder, one) and one.is_file())
    return [one for one in others if not _is_hidden(one.relative_to(folder)) and _is_like_program(one)]


def _is_like_program(file: Path) -> bool:
    try:
        with file.open("rb") as opened:
            return _BEGIN.match(opened.read(_HEAD)) is not None
    except OSError:
        return False


def _is_hidden(folder: Path) -> bool:
    """Whether the name of a folder or of one above it begins with a dot: those of tools, with C headers (.h) or old
    copies.
    """
    return any(part.startswith(".") for part in folder.parts)
