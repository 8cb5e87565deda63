"""Which texts are subprograms, and which files of a run are only executed by its other programs."""

import re
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from verne_post.base.printable import escape_unprinted
from verne_post.base.program_lines import find_end, remove_remarks, split_lines
from verne_post.config.subprograms import names_file
from verne_post.gcode.dialects import find_dialect_name
from verne_post.gcode.words import read_whole_lines
from verne_post.model.verdict import find_exit_status

if TYPE_CHECKING:
    from verne_post.config.settings import Settings
    from verne_post.output.findings import Report

#: A longer file is no subprogram: bytes.
LARGEST_CALLED: Final = 1 << 25
SUB: Final = re.compile(r"O\s*(<[^<>]+>|\d+)\s*SUB\b", re.IGNORECASE)
_ENDSUB: Final = re.compile(r"O\s*(?:<[^<>]+>|\d+)\s*ENDSUB\b", re.IGNORECASE)
#: An O number that heads a program, and is no statement of LinuxCNC.
NUMBER: Final = re.compile(r"[O:]\s*(\d+)(?!\d)(?!\s*[A-Z]{2})", re.IGNORECASE)
_M99: Final = re.compile(r"(?<![A-Z_])M0*99(?!\d)", re.IGNORECASE)
PROC: Final = re.compile(r"(?:N\d+\s*)?PROC\b", re.IGNORECASE)
#: Where Siemens has the name of a subprogram, or of a variable that is called alike, and does not call it.
_NO_CALL: Final = re.compile(
    r"^[ \t]*(?:N\d+[ \t]*)?(?:DEF|PROC|EXTERN|GOTO[BFC]?|REPEATB?|IF|WHILE|UNTIL|FOR|CASE)\b.*"
    r'|(?<!CALL)(?<!CALL )"[^"]*"|\b\w+[ \t]*(?:=.*|:)',
    re.IGNORECASE,
)
#: Languages by the endings of files that no other one calls; G-code has all other endings.
LANGUAGES: Final = {".spf": "siemens", ".mpf": "siemens", ".h": "heidenhain"}
_BEGIN: Final = re.compile(r"(?:\d+\s+)?BEGIN\s+PGM\b", re.IGNORECASE)
_RET: Final = re.compile(r"(?:N\d+\s*)?(?:RET\b|M17(?!\d))", re.IGNORECASE)


def list_code(text: str, dialect: str) -> list[str]:
    """The lines of a text that have words, without remarks and lines of %."""
    lines = (remove_remarks(line, dialect).strip() for line in split_lines(text))
    return [line for line in lines if line and not line.startswith("%")]


def may_be_called(text: str, dialect: str, name: str) -> bool:
    """Whether a text may be a subprogram: it does not end the program, which in Siemens leads back from an SPF file."""
    if dialect == "aptcl":
        return False
    return name.lower().endswith(".spf") or find_end(reversed(split_lines(text))) is None


def is_subprogram(text: str, dialect: str, name: str) -> bool:
    """Whether a text is a subprogram and nothing else, whoever calls it. Klartext writes both in one way."""
    if not may_be_called(text, dialect, name) or not (code := list_code(text, dialect)):
        return False
    if dialect == "siemens":
        heads = [number for number, line in enumerate(code) if PROC.match(line)]
        return name.lower().endswith(".spf") or heads[:1] == [0] or (not heads and _RET.match(code[-1]) is not None)
    if dialect in ("rs274", "fanuc"):
        if SUB.match(code[0]) and _ENDSUB.match(code[-1]):
            return True
        # behind another program, whose end is missing, it is none
        is_alone = not any(map(NUMBER.match, code[1:]))
        return is_alone and any(map(_M99.search, code))
    return False


def has_call(source: bytes, one: Path, path: Path) -> bool:
    """Whether the text of a file has a statement, outside remarks, that calls another file in the language of that."""
    own = LANGUAGES.get(path.suffix.lower(), "rs274")
    dialect = find_dialect_name("auto", source, one.name) or own
    if ("rs274" if dialect == "fanuc" else dialect) != own:
        return False
    for chunk in read_whole_lines(source):
        if names_file(chunk, path):
            text = chunk.decode("utf-8", errors="replace")
            lines = (remove_remarks(line, dialect) for line in split_lines(text))
            if dialect == "siemens":
                lines = (_NO_CALL.sub("", line) for line in lines)
            if names_file("\n".join(lines).encode(), path):
                return True
    return False


def is_only_called(path: Path) -> bool:
    """Whether a file is a subprogram and nothing else, and has no set-up beside it."""
    source = b"" if Path(f"{path}.toml").exists() else _read(path)
    if not source.strip():
        return False
    dialect = find_dialect_name("auto", source, path.name) or LANGUAGES.get(path.suffix.lower(), "rs274")
    text = source.decode("utf-8", errors="replace")
    if dialect == "heidenhain" and may_be_called(text, dialect, path.name):
        return any(_BEGIN.match(line) for line in list_code(text, dialect)[:1])
    return is_subprogram(text, dialect, path.name)


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
