"""Moves after the end of a program, which nobody executes (VP051, VP021)."""

import re
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Final

from verne_post.base.long_text import Text, iterate_lines
from verne_post.gcode.languages import report_empty
from verne_post.model.findings import Finding, Remedy, make_finding
from verne_post.model.moves import LINES_OF_A_CALL, Event, Moves

#: So many lines after the end are looked at, and so many bytes at the end of a text.
_LINES: Final = 10_000
_BYTES: Final = 1 << 16
#: A subprogram, or another program of the file: what is written after the end of a program on purpose.
_OTHER_PROGRAM: Final = re.compile(
    rb"[ \t]*+(?:\d+[ \t]++|N\d+[ \t]*+)?(?:O[ \t]*+[<\d]|:\d|%|(?:LBL|PROC|BEGIN|SUB)\b)", re.IGNORECASE
)
_COMMENT: Final = re.compile(rb"\([^()]*\)?|;.*")
#: The number of a program, or a code or word of RS274/NGC, with which its head begins; so many lines make a copy.
_HEAD: Final = re.compile(rb"[A-Z:]", re.IGNORECASE)
_LINES_OF_HEAD: Final = 3
#: A word of X, Y or Z, or a point of a CL file.
_MOVE: Final = re.compile(
    rb"(?<![A-Z_#$\[<])[XYZ][ \t]*+(?:=|[-+]?[ \t]*+[.\d#\[Q])|^[ \t]*+GOTO[ \t]*+/", re.IGNORECASE
)


def find_unexecuted_moves(source: Text, moves: Moves) -> Iterator[Finding]:
    """VP051: lines with axes that stand between the end of the program and the next program or subprogram."""
    end = _find_end(moves)
    lines = [] if end is None or not len(moves) else _find_lines(source, moves, end)
    if end is not None and lines:
        code = end.data["code"]
        text = f"{code} ends the program: {_describe_lines(lines)} axes after it, and nothing executes them; "
        in_file = end.own_line >= LINES_OF_A_CALL
        text += f"delete {code}{' (a file that M98 calls ends with M99)' * (in_file and not moves.language)}"
        line = end.own_line if in_file else end.line
        item = make_finding("VP051", f"{text} if it goes on", line=line, count=1)
        yield moves.called_lines.place(item)
    elif end is not None and len(moves) and (copy := _find_copy(source, end.line)):
        first, line = copy
        text = f"the program begins again, as in line {first}, after its end in line {end.line}, and nothing executes "
        text += "what follows; take one of the two out"
        yield make_finding("VP051", text, line=line, count=1)


def _find_copy(source: Text, end: int) -> tuple[int, int] | None:
    """Where the head of a program, from its ``%`` or its number on, stands, and stands again after its end."""
    after = [line.strip() for line in _list_lines_after(source, end)]
    if len(after) < _LINES_OF_HEAD:
        return None
    head = [line.strip() for line in islice(iterate_lines(source), end)]
    first = next((at for at, line in enumerate(head) if _HEAD.match(line)), None)
    if first is None:
        return None
    begin = head[first : first + _LINES_OF_HEAD]
    if len(begin) < _LINES_OF_HEAD:
        return None
    for at, line in enumerate(after):
        if line == begin[0] and after[at : at + _LINES_OF_HEAD] == begin:
            return first + 1, end + 1 + at
    return None


def report_no_motion(source: Text, moves: Moves) -> Finding:
    """VP021: at the code that ends the program before its motion, where there is one; M30 may be meant for M3."""
    end = _find_end(moves)
    lines = [] if end is None else _find_lines(source, moves, end)
    if (
        end is not None
        and not lines
        and end.data["code"] == "%"
        and b"".join(_list_lines_after(source, end.line)).strip()
    ):
        text = "% ends the program before its first motion, and lines follow it; delete %"
        return make_finding("VP021", text, line=end.line)
    if end is None or not lines:
        return report_empty(source) or make_finding("VP021", "the program contains no motion")
    code, edits = end.data["code"], tuple[Remedy, ...]()
    text = f"{code} ends the program before its first motion: {_describe_lines(lines)} axes after it; delete {code}"
    if code == "M30":
        text += ", or write M3 if the spindle is meant"
        edits = (Remedy("write M3", "3", line=end.line, word=("M", 30.0), is_choice=True),)
    return make_finding("VP021", text, line=end.line, edits=edits)


def _find_end(moves: Moves) -> Event | None:
    return next((one for one in reversed(moves.events) if one.kind == "end"), None)


def _find_lines(source: Text, moves: Moves, end: Event) -> list[int]:
    """Lines with axes between the end of the program and the next program or subprogram, if no jump leads there."""
    after = moves.line[moves.line > end.line]
    # of a label that is jumped to, or of a subprogram, before which nothing else is executed
    executed = int(after.min()) if len(after) else None
    found: list[int] = []
    for number, line in enumerate(_list_lines_after(source, end.line), end.line + 1):
        if _OTHER_PROGRAM.match(line):
            break
        if number == executed:
            return []
        if _MOVE.search(_COMMENT.sub(b"", line)):
            found.append(number)
    return found


def _describe_lines(lines: Sequence[int]) -> str:
    return f"line {lines[0]} moves" if len(lines) == 1 else f"lines {lines[0]} to {lines[-1]} move"


def _list_lines_after(source: Text, line: int) -> Iterator[bytes]:
    """The lines after a line; those of a long text from its end, where it has few more."""
    tail = source[-_BYTES:]
    last = source.count(b"\n") + 1
    begin = last - tail.count(b"\n")  # the number of the line in which the tail begins
    if begin > line + 1:
        yield from islice(iterate_lines(source), line, line + _LINES)
    else:
        yield from tail.split(b"\n")[line + 1 - begin :][:_LINES]
