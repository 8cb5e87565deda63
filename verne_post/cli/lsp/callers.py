"""Which texts are subprograms, and the program that calls a file: its own run alone tells what is wrong in it."""

import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Final

from verne_post.base.program_lines import find_end, remove_remarks
from verne_post.cli.lsp.places import split_lines
from verne_post.cli.program_folders import PROGRAMS
from verne_post.config.subprograms import names_file
from verne_post.gcode.dialects import find_dialect_name

#: Files beside a subprogram in which its call is sought; bytes of each, and of all: they are read while it is typed.
MOST_NEIGHBOURS: Final = 1_000
LARGEST_NEIGHBOUR: Final = 2_000_000
MOST_SEARCHED: Final = 100_000_000
_SUB: Final = re.compile(r"O\s*(<[^<>]+>|\d+)\s*SUB\b", re.IGNORECASE)
_ENDSUB: Final = re.compile(r"O\s*(?:<[^<>]+>|\d+)\s*ENDSUB\b", re.IGNORECASE)
#: An O number that heads a program, and is no statement of LinuxCNC.
NUMBER: Final = re.compile(r"[O:]\s*(\d+)(?!\d)(?!\s*[A-Z]{2})", re.IGNORECASE)
_M99: Final = re.compile(r"(?<![A-Z_])M0*99(?!\d)", re.IGNORECASE)
_PROC: Final = re.compile(r"(?:N\d+\s*)?PROC\b", re.IGNORECASE)
#: Where Siemens has the name of a subprogram, or of a variable that is called alike, and does not call it.
_NO_CALL: Final = re.compile(
    r"^[ \t]*(?:N\d+[ \t]*)?(?:DEF|PROC|EXTERN|GOTO[BFC]?|REPEATB?|IF|WHILE|UNTIL|FOR|CASE)\b.*"
    r'|(?<!CALL)(?<!CALL )"[^"]*"|\b\w+[ \t]*(?:=.*|:)',
    re.IGNORECASE,
)
#: Languages by the endings of files that no other one calls; G-code has all other endings.
_LANGUAGES: Final = {".spf": "siemens", ".mpf": "siemens", ".h": "heidenhain"}
#: Lines that lead elsewhere: a branch, a loop, a jump, and an end.
_FLOW: Final = re.compile(
    r"[ \t/]*(?:N\d+[ \t]*)?(?:O[ \t]*(?:<[^<>]+>|\d+)[ \t]*(?:DO|RETURN|BREAK|CONTINUE|ELSE|(?:END|ELSE)?IF"
    r"|(?:END)?(?:WHILE|REPEAT))"
    r"|IF|ELSE|WHILE|FOR|LOOP|REPEATB?|UNTIL|CASE|END(?:IF|WHILE|FOR|LOOP|[ \t]*\d)|DO[ \t]*\d|GOTO[BFCS]?"
    r"|M0*(?:99|17)|RET|\d*[ \t]*FN[ \t]*(?:9|1[0-2])[ \t]*:)(?![A-Z_]).*",
    re.IGNORECASE,
)
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
        heads = [number for number, line in enumerate(code) if _PROC.match(line)]
        return name.lower().endswith(".spf") or heads[:1] == [0] or (not heads and _RET.match(code[-1]) is not None)
    if dialect in ("rs274", "fanuc"):
        if _SUB.match(code[0]) and _ENDSUB.match(code[-1]):
            return True
        # behind another program, whose end is missing, it is none
        is_alone = not any(map(NUMBER.match, code[1:]))
        return is_alone and any(map(_M99.search, code))
    return False


def is_head(line: str) -> bool:
    """Whether a line begins a subprogram; a call leads to the line below it."""
    return any(head.match(line.lstrip()) for head in (_SUB, _PROC))


def add_call(text: str, dialect: str) -> str:
    """The text of a subprogram that ends with ``o<name> endsub``, and a call of it, so that its lines are executed."""
    code = list_code(text, dialect)
    head = _SUB.match(code[0]) if code else None
    if head is None:
        return text
    return re.sub(r"\n%\s*$", "\n", text).rstrip() + f"\no{head[1]} call\nM2\n"


def straighten(text: str, dialect: str) -> str:
    """The text of a subprogram without its branches, loops and jumps, so that the words of every line are read."""
    lines = split_lines(add_call(text, dialect))
    last = max((number for number, line in enumerate(lines) if remove_remarks(line, dialect).strip(" \t%")), default=0)
    return "\n".join(_FLOW.sub("", line) if number < last else line for number, line in enumerate(lines))


class Callers:
    """Finds the program that calls a file: an open one first, else one in the same folder."""

    def __init__(self) -> None:
        self._known: dict[tuple[Path, Path], tuple[object, bool]] = {}

    def find(self, path: Path, texts: Mapping[Path, str], seen: set[Path] | None = None) -> Path | None:
        """The program at the top of the calls that lead to a file; None where none is known.

        Parameters
        ----------
        texts : mapping
            What the editor shows, by files.
        seen : set of Path, optional
            Files that the search has met, which do not count again.
        """
        first, seen = None, {path} if seen is None else seen
        for one in self._list_candidates(path, texts):
            if one in seen or not self.names(one, path, texts):
                continue
            seen.add(one)
            if (found := self.find(one, texts, seen)) is not None:
                return found
            if first is None and not is_subprogram(self.read(one, texts), self._find_language(one), one.name):
                first = one
        return first

    def _find_language(self, path: Path) -> str:
        """The language of a caller by its ending: what G-code, Siemens and Klartext write at the end differs."""
        return _LANGUAGES.get(path.suffix.lower(), "rs274")

    def read(self, path: Path, texts: Mapping[Path, str]) -> str:
        """The text of a file, as the editor shows it, or from the disk; empty where it cannot be read."""
        return texts[path] if path in texts else self._read_bytes(path, texts).decode("utf-8", errors="replace")

    def _read_bytes(self, path: Path, texts: Mapping[Path, str]) -> bytes:
        if path in texts:
            return texts[path].encode()
        with suppress(OSError):
            return path.read_bytes()
        return b""

    def _list_candidates(self, path: Path, texts: Mapping[Path, str]) -> Iterator[Path]:
        endings = (*PROGRAMS, ".spf")
        near = (one for one in texts if one.suffix.lower() in endings and path.is_relative_to(one.parent))
        yield from (one for one in near if one != path)
        with suppress(OSError):
            beside = sorted(one for one in path.parent.iterdir() if one.suffix.lower() in endings and one not in texts)
            left = MOST_SEARCHED
            for one in beside[:MOST_NEIGHBOURS]:
                size = one.stat().st_size if one.exists() else 0
                left -= size if size <= LARGEST_NEIGHBOUR else 0
                if left < 0:
                    return
                if one != path and size <= LARGEST_NEIGHBOUR:
                    yield one

    def find_stamp(self, path: Path, texts: Mapping[Path, str]) -> object:
        """What changes with the text of a file; None where it cannot be read."""
        if path in texts:
            return texts[path]
        with suppress(OSError):
            found = path.stat()
            return found.st_mtime_ns, found.st_size
        return None

    def names(self, one: Path, path: Path, texts: Mapping[Path, str]) -> bool:
        """Whether a file has a call of another one, in the language of that; known until it changes."""
        stamp = self.find_stamp(one, texts)
        if stamp is None:
            return False
        if (one, path) not in self._known or self._known[one, path][0] != stamp:
            self._known[one, path] = stamp, _has_call(self._read_bytes(one, texts), one, path)
        return self._known[one, path][1]


def _has_call(source: bytes, one: Path, path: Path) -> bool:
    """Whether the text of a file has a statement, outside remarks, that calls another file in the language of that."""
    own = _LANGUAGES.get(path.suffix.lower(), "rs274")
    if not names_file(source, path):
        return False
    dialect = find_dialect_name("auto", source, one.name) or own
    if ("rs274" if dialect == "fanuc" else dialect) != own:
        return False
    lines = (remove_remarks(line, dialect) for line in split_lines(source.decode("utf-8", errors="replace")))
    if dialect == "siemens":
        lines = (_NO_CALL.sub("", line) for line in lines)
    return names_file("\n".join(lines).encode(), path)
