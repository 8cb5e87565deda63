"""A retract that is missing before the table turns or the tool is changed: it is tried before it is reported."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.app.assemble import Program, assemble, build_interpreter_setup
from verne_post.app.constraints import check_program
from verne_post.app.explain_numbers import format_number
from verne_post.app.remedies.lines import CONTACTS
from verne_post.app.remedies.trials import is_short, list_errors, name_left
from verne_post.base.arrays import Ints
from verne_post.base.long_text import Text
from verne_post.base.tolerances import LIMIT_SLACK_MM, ZERO_ANGLE
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.inch_words import is_in_inches
from verne_post.model.findings import Finding, InputError, Remedy, join_lines, list_lines
from verne_post.model.moves import LINES_OF_A_CALL, MoveKind, Moves

#: How a tool is retracted, by dialect; a number without a point may mean micrometres on a Fanuc control.
_RETRACTS: Final = {
    "heidenhain": "L Z{:+} R0 FMAX",
    "siemens": "G0 Z{}",
    "fanuc": "G0 Z{}.",
    "rs274": "G0 Z{}",
}
#: Travel and reach, the table, bodies beside it, fixtures and stock: what a higher tool may keep clear of.
_CODES: Final = ("VP101", "VP110", "VP210", "VP212", "VP213", "VP215", "VP216")
#: Heights that are tried are whole multiples of the first, mm and inch, and so many of them above the tool.
_STEPS: Final = (50, 2)
_STEPS_ABOVE: Final = (1, 2, 4)
#: Retracts before so many turns are added one by one, as each shows the next one.
_MOST_TURNS: Final = 8


class _Turn(Struct, frozen=True):
    """A move with an error that turns the table or the head, or comes after a turn or another tool."""

    line: int  #: Of the error.
    before: int  #: The line before which the tool is retracted: that of the plane, where the table turns to one.
    z: float  #: Where the tool stands before it, mm.
    cause: int  #: The line that turns, or changes the tool.
    changes_tool: bool = False


class Retract(Struct, frozen=True):
    """What a retract before each turn cures."""

    remedy: Remedy
    cured: frozenset[tuple[str, str | None, int | None]]  #: Code, axis and first line of each.
    cures_all: bool  #: No error is left.


def find_turn(program: Program, item: Finding) -> _Turn | None:
    """The turn of the table from which an error about a place comes; None for others.

    The first line of the error turns, and cuts nothing. Or it is a contact in a rapid, and no retract lies between it
    and the turn, or the change of tools.
    """
    moves, path = program.moves, program.path
    if item.severity != "error" or item.code not in _CODES or not 0 < (item.line or 0) < LINES_OF_A_CALL:
        return None
    turns = (np.abs(path.end[:, 3:5] - path.start[:, 3:5]) > ZERO_ANGLE).any(axis=1)
    turns &= np.isnan(moves.feed[path.move]) | (path.turn >= 0)
    rows = path.move[turns & (path.move > 0)]
    own = rows[moves.line[rows] == item.line]
    tools = [(one.line, one.before) for one in moves.events if one.kind == "tool"]
    row, line = (int(own[0]) if len(own) else -1), 0
    if row < 0 and item.code in CONTACTS:
        row, line = _find_change_before(moves, item.line or 0, rows, tools)
    if row < 1 or not np.isfinite(moves.end[row - 1, 2]):
        return None
    z, number = float(moves.end[row - 1, 2]), item.line or 0
    if line:
        return _Turn(number, line, z, line, changes_tool=True)
    last, cause = int(moves.line[row - 1]), int(moves.line[row])
    said = [*((one.line, one.before) for one in (*moves.planes, *moves.tcp_ends)), *tools]
    between = [line for line, before in said if before == row and last < line]
    return _Turn(number, min((*between, cause)), z, cause)


def _find_change_before(moves: Moves, number: int, turns: Ints, tools: Sequence[tuple[int, int]]) -> tuple[int, int]:
    """The last turn, or change of tools, before a rapid: its row, and the line of a change of tools, else 0.

    The row is -1 where there is none, or where a rapid leads up after it.
    """
    own = np.flatnonzero(moves.line == number)
    if not len(own) or moves.kind[own[0]] != MoveKind.RAPID:
        return -1, 0
    row = int(own[0])
    begin = max((int(one) for one in turns[turns < row]), default=-1)
    line, changed = max(((line, at) for line, at in tools if at <= row), key=lambda one: one[1], default=(0, -1))
    last = max(begin, changed - 1)
    rows = np.arange(max(last, 0) + 1, row)
    rapid, z = moves.kind[rows] == MoveKind.RAPID, moves.end[:, 2]
    is_up = (z[rows] > z[rows - 1] + LIMIT_SLACK_MM) & (moves.frame[rows] == moves.frame[rows - 1])
    if last < 0 or (rapid & (is_up | moves.find_in_machine()[rows])).any():
        return -1, 0
    return (begin, 0) if begin >= changed else (changed, line)


def _list_turns(program: Program, errors: Sequence[Finding]) -> list[_Turn]:
    found = (find_turn(program, item) for item in errors)
    return list({turn.line: turn for turn in found if turn is not None}.values())


def find_missing_retract(source: Text, program: Program, findings: Sequence[Finding]) -> Retract | None:
    """The first of some heights that keeps the tool clear where a refused program turns the table; checked with it.

    Parameters
    ----------
    findings : sequence of Finding
        Of the whole program.
    """
    dialect = choose_dialect_name(program.options.dialect, source, program.options.source_name)
    errors = list_errors(findings)
    turns = _list_turns(program, errors)
    if not turns or dialect not in _RETRACTS or not is_short(program):
        return None
    inches = is_in_inches(source, build_interpreter_setup(program.machine, program.options), turns[0].before)
    for height in _list_heights(program, max(turn.z for turn in turns), in_inches=inches):
        code = _RETRACTS[dialect].format(height)
        retract = _try_retract(source, program, errors, turns, code, height * (MM_PER_INCH if inches else 1.0))
        if retract is not None:
            return retract
    return None


def _list_heights(program: Program, z: float, *, in_inches: bool) -> list[int]:
    """Whole numbers of the unit above a Z, mm: the height of the program's own highest rapid first."""
    moves, scale, step = program.moves, (MM_PER_INCH if in_inches else 1.0), _STEPS[in_inches]
    level = np.array([frame.feature is None for frame in moves.frames])[moves.frame] & ~moves.find_in_machine()
    # a height that a retract in machine coordinates has left, or another tool, is none of the program
    leads_there = (np.diff(moves.end[:, 2], prepend=z) != 0.0) & (np.diff(moves.frame, prepend=-1) == 0)
    own = moves.end[level & leads_there & (moves.kind == MoveKind.RAPID), 2]
    highest = math.ceil(round(float(own.max(initial=z)) / scale, 6))
    begin = math.floor(z / scale / step)
    above = [(begin + 1 + count) * step for count in _STEPS_ABOVE]
    return list(dict.fromkeys([*([highest] if highest * scale >= z + step * scale else []), *above]))


def _try_retract(
    source: Text,
    program: Program,
    errors: Sequence[Finding],
    turns: Sequence[_Turn],
    code: str,
    height: float,
    *,
    seeks: bool = True,
) -> Retract | None:
    """A line before some turns, where it removes their errors and makes no others; of some of them, those that it does.

    ``height`` in mm is where the line has to lead. With ``seeks`` it stands before other turns with errors too.
    """
    places = sorted({turn.before for turn in turns})
    lines = bytes(source).split(b"\n")
    end = b"\r" if lines[places[0] - 1].endswith(b"\r") else b""
    for place in reversed(places):
        lines.insert(place - 1, code.encode() + end)
    added = [place + count for count, place in enumerate(places)]
    try:
        tried = assemble(b"\n".join(lines), program.machine, program.options, program.team)
        moves, before = tried.moves, program.moves
        own = np.isin(moves.line, added)
        leads_up = np.isin(added, moves.line[own]).all() and np.abs(moves.end[own, 2] - height).max() < LIMIT_SLACK_MM
        # a code that holds from line to line makes no rapid of a cut
        if not leads_up or not np.array_equal(np.isnan(moves.feed[~own]), np.isnan(before.feed)):
            return None
        left = [one for one in check_program(tried, only_lines=True)[1] if one.severity == "error"]
    except InputError:
        return None

    def number(line: int) -> int:
        """The line of the program; 0 for a retract."""
        return 0 if line in added else line - sum(one < line for one in added)

    remaining = {(one.code, one.axis, number(line)) for one in left for line in list_lines(one)}
    cured = [item for item in errors if not remaining & _list_places(item)]
    later = [
        replace(one, line=number(one.line), before=number(one.before), cause=number(one.cause))
        for one in _list_turns(tried, left)
    ]
    new = [
        one for one in later if one.line and one.before and one.cause and one.line not in {turn.line for turn in turns}
    ]
    if new and seeks and len(turns) < _MOST_TURNS:  # the same limit is broken again, which was one finding
        return _try_retract(source, program, errors, [*turns, *new], code, height)
    wrong = {line for _code, _axis, line in remaining}
    right = [turn for turn in turns if turn.line not in wrong]
    if right and len(right) < len(turns):  # what is told is what was tried
        return _try_retract(source, program, errors, right, code, height, seeks=False)
    if not right or not remaining <= set().union(*map(_list_places, errors)):
        return None
    return Retract(
        _make_remedy(program, right, code, [one.code for one in left]), frozenset(map(_get_key, cured)), not left
    )


def add_retract(findings: Sequence[Finding], retract: Retract) -> list[Finding]:
    """Findings of which those that a retract cures have it as their remedy."""
    remedy = retract.remedy
    edits = (remedy,) if remedy.value else ()
    return [
        dataclasses.replace(one, remedies=(remedy.text,), edits=edits) if _get_key(one) in retract.cured else one
        for one in findings
    ]


def _get_key(item: Finding) -> tuple[str, str | None, int | None]:
    return item.code, item.axis, item.line


def _list_places(item: Finding) -> set[tuple[str, str | None, int]]:
    return {(item.code, item.axis, line) for line in list_lines(item)}


def _make_remedy(program: Program, turns: Sequence[_Turn], code: str, left: Sequence[str]) -> Remedy:
    """The retract in words, and as an edit where it is one line."""
    places, first = sorted({turn.before for turn in turns}), min(turns, key=lambda turn: turn.line)
    does = "changes the tool" if first.changes_tool else f"turns the {program.machine.rotary_side}"
    why = f"the tool is at Z {format_number(first.z)} mm when line {first.cause} {does}"
    what = f"removes this error; {name_left(left)}" if left else "within limits"
    text = f"retract the tool before {join_lines(places)}: {code} ({why}): {what}"
    if len(places) > 1:
        return Remedy(text, line=places[0])
    return Remedy(text, code, line=places[0], way="before")
