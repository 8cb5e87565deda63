"""The program that calls a file, whose own run alone tells what is wrong in it, and texts that execute that file."""

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Final

from verne_post.app.called_files import LANGUAGES, has_call
from verne_post.app.program_folders import PROGRAMS
from verne_post.base.program_lines import remove_remarks, split_lines
from verne_post.cli.files import show_name
from verne_post.gcode.program_error import CHECK_CALLER, IS_SUBPROGRAM
from verne_post.gcode.subprograms import PROC, SUB, is_subprogram, keep_one, list_code
from verne_post.model.findings import Finding

#: Files beside a subprogram in which its call is sought; bytes of each, and of all: they are read while it is typed.
MOST_NEIGHBOURS: Final = 1_000
LARGEST_NEIGHBOUR: Final = 2_000_000
MOST_SEARCHED: Final = 100_000_000
#: Lines that lead elsewhere: a branch, a loop, a jump, and an end.
_FLOW: Final = re.compile(
    r"[ \t/]*(?:N\d+[ \t]*)?(?:O[ \t]*(?:<[^<>]+>|\d+)[ \t]*(?:DO|RETURN|BREAK|CONTINUE|ELSE|(?:END|ELSE)?IF"
    r"|(?:END)?(?:WHILE|REPEAT))"
    r"|IF|ELSE|WHILE|FOR|LOOP|REPEATB?|UNTIL|CASE|END(?:IF|WHILE|FOR|LOOP|[ \t]*\d)|DO[ \t]*\d|GOTO[BFCS]?"
    r"|M0*(?:99|17)|RET|\d*[ \t]*FN[ \t]*(?:9|1[0-2])[ \t]*:)(?![A-Z_]).*",
    re.IGNORECASE,
)


def is_head(line: str) -> bool:
    """Whether a line begins a subprogram; a call leads to the line below it."""
    return any(head.match(line.lstrip()) for head in (SUB, PROC))


def add_call(text: str, dialect: str) -> str:
    """The text of a subprogram that ends with ``o<name> endsub``, and a call of it, so that its lines are executed."""
    code = list_code(text, dialect)
    head = SUB.match(code[0]) if code else None
    if head is None:
        return text
    return re.sub(r"\n%\s*$", "\n", text).rstrip() + f"\no{head[1]} call\nM2\n"


def straighten(text: str, dialect: str) -> str:
    """The text of a subprogram without its branches, loops and jumps, so that the words of every line are read."""
    lines = split_lines(add_call(text, dialect))
    last = max((number for number, line in enumerate(lines) if remove_remarks(line, dialect).strip(" \t%")), default=0)
    return "\n".join(_FLOW.sub("", line) if number < last else line for number, line in enumerate(lines))


def name_caller(findings: Iterable[Finding], program: str) -> tuple[Finding, ...]:
    """The findings of a program: where they doubt that it is one, and a program beside it calls it, they are one."""
    found = tuple(findings)
    told = next((item for item in found if item.message.endswith(CHECK_CALLER)), None)
    if told is None or not Path(program).is_file() or (caller := Callers().find(Path(program), {})) is None:
        return found
    is_one = told.message.startswith(IS_SUBPROGRAM)
    why = told.message.removesuffix(CHECK_CALLER) if is_one else f"{IS_SUBPROGRAM}; "
    message, code = f"{why}check {show_name(str(caller))}, which calls it", told.code if is_one else "VP010"
    return tuple(keep_one(found, replace(told, code=code, message=message, settled_by=(), edits=(), advice="")))


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
        return LANGUAGES.get(path.suffix.lower(), "rs274")

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
            self._known[one, path] = stamp, has_call(self._read_bytes(one, texts), one, path)
        return self._known[one, path][1]
