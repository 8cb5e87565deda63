"""Moves after the end of a program, which nobody executes (VP051)."""

import re
from collections.abc import Iterator
from itertools import islice
from typing import Final

from verne_post.base.long_text import Text, iterate_lines
from verne_post.model.findings import Finding, make_finding
from verne_post.model.moves import Moves

#: So many lines after the end are looked at, and so many bytes at the end of a text.
_LINES: Final = 10_000
_BYTES: Final = 1 << 16
#: A subprogram, or another program of the file: what is written after the end of a program on purpose.
_OTHER_PROGRAM: Final = re.compile(
    rb"[ \t]*+(?:\d+[ \t]++|N\d+[ \t]*+)?(?:O[ \t]*+[<\d]|:\d|%|(?:LBL|PROC|BEGIN|SUB)\b)", re.IGNORECASE
)
_COMMENT: Final = re.compile(rb"\([^()]*\)?|;.*")
#: A word of X, Y or Z, or a point of a CL file.
_MOVE: Final = re.compile(
    rb"(?<![A-Z_#$\[<])[XYZ][ \t]*+(?:=|[-+]?[ \t]*+[.\d#\[Q])|^[ \t]*+GOTO[ \t]*+/", re.IGNORECASE
)


def find_unexecuted_moves(source: Text, moves: Moves) -> Iterator[Finding]:
    """VP051: lines with axes that stand between the end of the program and the next program or subprogram."""
    end = next((one for one in reversed(moves.events) if one.kind == "end"), None)
    if end is None or not len(moves):
        return
    after = moves.line[moves.line > end.line]
    # of a label that is jumped to, or of a subprogram, before which nothing else is executed
    executed = int(after.min()) if len(after) else None
    found: list[int] = []
    for number, line in enumerate(_list_lines_after(source, end.line), end.line + 1):
        if _OTHER_PROGRAM.match(line):
            break
        if number == executed:
            return
        if _MOVE.search(_COMMENT.sub(b"", line)):
            found.append(number)
    if found:
        which = f"line {found[0]} moves" if len(found) == 1 else f"lines {found[0]} to {found[-1]} move"
        code = end.data["code"]
        text = f"{code} ends the program: {which} axes after it, and nothing executes them; delete {code} if it goes on"
        yield make_finding("VP051", text, line=end.line, last_line=end.line, worst_line=end.line, count=1)


def _list_lines_after(source: Text, line: int) -> Iterator[bytes]:
    """The lines after a line; those of a long text from its end, where it has few more."""
    tail = source[-_BYTES:]
    last = source.count(b"\n") + 1
    begin = last - tail.count(b"\n")  # the number of the line in which the tail begins
    if begin > line + 1:
        yield from islice(iterate_lines(source), line, line + _LINES)
    else:
        yield from tail.split(b"\n")[line + 1 - begin :][:_LINES]
