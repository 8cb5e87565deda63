"""Which texts are subprograms, and which files of a run are only executed by its other programs."""

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from verne_post.base.printable import escape_unprinted
from verne_post.base.program_lines import remove_remarks, split_lines
from verne_post.config.subprograms import names_file
from verne_post.gcode.dialects import find_dialect_name
from verne_post.gcode.subprograms import LARGEST_CALLED, find_sign
from verne_post.gcode.words import read_whole_lines
from verne_post.model.verdict import find_exit_status

if TYPE_CHECKING:
    from verne_post.config.settings import Settings
    from verne_post.output.findings import Report

#: Where Siemens has the name of a subprogram, or of a variable that is called alike, and does not call it.
_NO_CALL: Final = re.compile(
    r"^[ \t]*(?:N\d+[ \t]*)?(?:DEF|PROC|EXTERN|GOTO[BFC]?|REPEATB?|IF|WHILE|UNTIL|FOR|CASE)\b.*"
    r'|(?<!CALL)(?<!CALL )"[^"]*"|\b\w+[ \t]*(?:=.*|:)',
    re.IGNORECASE,
)
#: Languages by the endings of files that no other one calls; G-code has all other endings.
LANGUAGES: Final = {".spf": "siemens", ".mpf": "siemens", ".h": "heidenhain"}


def has_call(source: bytes, one: Path, path: Path) -> bool:
    """Whether the text of a file has a statement, outside remarks, that calls another file in the language of that."""
    own = LANGUAGES.get(path.suffix.lower(), "rs274")
    for chunk in read_whole_lines(source):
        if names_file(chunk, path):
            dialect = find_dialect_name("auto", source, one.name) or own
            if ("rs274" if dialect == "fanuc" else dialect) != own:
                return False
            text = chunk.decode("utf-8", errors="replace")
            lines = (remove_remarks(line, dialect) for line in split_lines(text))
            if dialect == "siemens":
                lines = (_NO_CALL.sub("", line) for line in lines)
            if names_file("\n".join(lines).encode(), path):
                return True
    return False


def find_callers(names: Collection[str]) -> dict[str, str]:
    """Of each subprogram among files: the first program whose text calls it, perhaps through other subprograms."""
    called = {name: Path(name).resolve() for name in names if is_only_called(Path(name))}
    callers: dict[str, str] = {}
    for name in sorted(names, key=called.__contains__) if called else ():
        one = Path(name).resolve()
        below = {sub: path for sub, path in called.items() if path != one and path.is_relative_to(one.parent)}
        source = b""
        with suppress(OSError):
            source = one.read_bytes() if below.keys() - callers.keys() else b""
        callers |= {sub: name for sub, path in below.items() if sub not in callers and has_call(source, one, path)}
    for sub in callers:
        seen = {sub}
        while (above := callers.get(callers[sub])) is not None and above not in seen:
            seen.add(above)
            callers[sub] = above
    # files that only call each other are called by no program
    return {sub: name for sub, name in callers.items() if name not in callers}


def has_call_to_any(name: str, called: Iterable[str]) -> bool:
    """Whether the text of a program calls one of some subprograms."""
    one, source = Path(name).resolve(), b""
    with suppress(OSError):
        source = one.read_bytes()
    paths = (Path(sub).resolve() for sub in called)
    return any(has_call(source, one, path) for path in paths if path.is_relative_to(one.parent))


def is_only_called(path: Path) -> bool:
    """Whether a file is a subprogram and nothing else, and has no set-up beside it."""
    source = b"" if Path(f"{path}.toml").exists() else _read(path)
    if not source.strip():
        return False
    dialect = find_dialect_name("auto", source, path.name) or LANGUAGES.get(path.suffix.lower(), "rs274")
    return find_sign(source.decode("utf-8", errors="replace"), dialect, path.name) is not None


def drop_called(
    reports: Mapping[str, "Report"], named: Collection[str], find_settings: Callable[[str], "Settings | None"]
) -> dict[str, "Report"]:
    """The reports of a run by program, without those of subprograms that are refused alone and executed by another one.

    ``called`` of a report has the files that its program has executed, as seen from its folder; then those of them
    whose own reports are left out. ``uncertain`` has those that it may call; then those of them that are refused alone.
    Those ``named`` stay, and those with a set-up of their name in the settings.
    """

    def may_be_dropped(name: str) -> bool:
        if name in named or not is_only_called(Path(name)):
            return False
        settings = find_settings(name)
        return settings is None or Path(name).name not in settings.setups

    refused = (name for name, one in reports.items() if find_exit_status(one.findings, one.fail_level))
    waiting = {name: Path(name).resolve() for name in refused if may_be_dropped(name)}
    callers, doubts = dict[Path, list[str]](), dict[Path, list[str]]()
    for name, one in reports.items() if waiting else ():
        path = Path(name).resolve()
        for files, found in ((one.called, callers), (one.uncertain, doubts)):
            for called in {(path.parent / file).resolve() for file in files} - {path}:
                found.setdefault(called, []).append(name)
    # of files that only call each other none is called by a program
    programs = {name for name in reports if name not in waiting or waiting[name] not in callers}
    own: dict[str, list[str]] = {name: [] for name in reports}
    may_call: dict[str, list[str]] = {name: [] for name in reports}
    for name, path in waiting.items():
        if (caller := next((one for one in callers.get(path, ()) if one in programs), None)) is not None:
            own[caller].append(name)
            del own[name]
        else:
            for doubtful in doubts.get(path, ()):
                may_call[doubtful].append(name)

    def spell(names: list[str]) -> tuple[str, ...]:
        return tuple(map(escape_unprinted, names))

    return {
        name: replace(reports[name], called=spell(called), uncertain=spell(may_call[name]))
        for name, called in own.items()
    }


def _read(path: Path) -> bytes:
    """The text of a file; empty where it is longer or cannot be read, which its own check says."""
    with suppress(OSError):
        return path.read_bytes() if path.stat().st_size <= LARGEST_CALLED else b""
    return b""
