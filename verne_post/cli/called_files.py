"""Which texts are subprograms, and which files of a run only its other programs call."""

import re
from collections.abc import Collection, Iterable
from contextlib import suppress
from pathlib import Path
from typing import Final

from verne_post.base.program_lines import find_end, remove_remarks, split_lines
from verne_post.config.subprograms import find_named, list_callable_files, names_file
from verne_post.gcode.dialects import find_dialect_name
from verne_post.gcode.words import read_whole_lines
from verne_post.model.findings import UsageError

#: A longer file is checked by itself too: bytes.
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
    """Whether a file is a subprogram, or may be one in Klartext, and has no set-up of its own."""
    source = b"" if Path(f"{path}.toml").exists() else _read(path, LARGEST_CALLED)
    if not source.strip():
        return False
    dialect = find_dialect_name("auto", source, path.name) or LANGUAGES.get(path.suffix.lower(), "rs274")
    judge = may_be_called if dialect == "heidenhain" else is_subprogram
    return judge(source.decode("utf-8", errors="replace"), dialect, path.name)


def find_callers(programs: Iterable[Path], asked: Collection[Path], folders: tuple[str, ...]) -> dict[Path, Path]:
    """The files of a run that are only called, each with a program of the run whose check covers it.

    Parameters
    ----------
    programs : iterable of Path
        Resolved.
    asked : collection of Path
        Those of them that are checked by themselves all the same.
    folders : tuple of str
        As ``--subroutine-path``.
    """
    programs = list(programs)
    may_be = {path for path in programs if path not in asked and is_only_called(path)}
    calls = {path: _list_called(path, may_be - {path}, folders) if may_be else [] for path in programs}
    top = {path: path for path in programs if path not in may_be}
    waiting = list(top)
    for path in waiting:  # it grows; files that only call each other stay programs
        new = [one for one in calls[path] if one not in top]
        top |= dict.fromkeys(new, top[path])
        waiting += new
    return {path: top[path] for path in may_be & top.keys()}


def _list_called(path: Path, may_be: Collection[Path], folders: tuple[str, ...]) -> list[Path]:
    """Those of some files that the program of a file calls, where it finds them."""
    with suppress(UsageError, OSError):  # whoever checks the program says what is wrong with --subroutine-path
        known = {one.stem.lower(): one for one in list_callable_files(path.parent, folders) if one in may_be}
        source = _read(path) if known else b""
        named = dict.fromkeys(name for name in find_named(source, known) if name in known)
        return [known[name] for name in named if has_call(source, path, known[name])]
    return []


def _read(path: Path, most: int | None = None) -> bytes:
    """The text of a file; empty where it is longer or cannot be read, which its own check says."""
    with suppress(OSError):
        return path.read_bytes() if most is None or path.stat().st_size <= most else b""
    return b""
