"""Errors of the pose at which a program starts, at the line that names it: no motion leads there."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from verne_post.app.assemble import Program
from verne_post.app.remedies.lines import find_turn_to_plane
from verne_post.base.arrays import Array
from verne_post.base.long_text import Text, take_line
from verne_post.base.program_lines import find_word
from verne_post.base.tolerances import LIMIT_SLACK, LIMIT_SLACK_MM
from verne_post.model.findings import Finding
from verne_post.model.moves import Moves
from verne_post.model.verdict import Family, find_family

#: Another height, mm, may bring the start within limits: then Z is what is wrong with it, else X or Y.
_HEIGHTS: Final = tuple(float(step) for step in range(-2000, 2001, 25))
_OF_ROTARY_AXES: Final = ("VP102", "VP103")
#: So many lines before the first motion are looked at.
_OPENING: Final = 200


def quote_start(source: Text, program: Program, findings: Sequence[Finding]) -> list[Finding]:
    """The findings, of which those that begin where the program starts have the line that names this place.

    The first naming of an axis says where it stands from the beginning, so its line moves nothing, and the first motion
    would be blamed. An angle of the table is first named by the block that turns it to a plane, where no words do. A
    program that is restarted elsewhere keeps its lines.
    """
    path, moves = program.path, program.moves
    first = int(path.moves_with_length[0])
    line = int(moves.line[first])
    if program.options.from_line is not None or not any(_is_at(item, line) for item in findings):
        return list(findings)
    begin = int(np.flatnonzero(path.move[: path.move.searchsorted(first) + 1] == first)[0])
    tip, angles, length = path.start[begin, :3], path.start[begin, 3:], float(path.tool_length[begin])
    if _are_legal(program, tip[None], angles, length).any():
        return list(findings)
    heights = tip + np.outer(_HEIGHTS, (0.0, 0.0, 1.0))
    letters = "Z" if _are_legal(program, heights, angles, length).any() else "XY"
    end = min(first, _OPENING)
    at_zero = {  # each rotary axis at 0
        letter: np.where(np.arange(2) == one, 0, angles) for one, letter in enumerate(program.machine.rotary_letters)
    }
    within = [letter for letter, tilt in at_zero.items() if _are_legal(program, heights, tilt, length).any()]
    is_angle = letters == "XY" and bool(within)  # no height is within limits, but with another angle one is
    turned_letters = within if is_angle else _find_beyond(program, tip, angles, at_zero, length)
    rotary = dict(zip(program.machine.rotary_letters, program.machine.coordinates.rotary, strict=True))
    turns = (find_turn_to_plane(moves, first, rotary[letter]) for letter in turned_letters)
    turn = next(filter(None, turns), None)  # the plane has the angles, and no place
    if turn is None and letters == "XY" and turned_letters:
        letters, end = "".join(turned_letters), first + _OPENING  # the first naming of A may come after the first move
    at = line
    for number in dict.fromkeys(moves.line[:end].tolist()):
        text = (take_line(source, number) or b"").decode("utf-8", errors="replace")
        if (number < line or end > first) and any(find_word(text, letter) is not None for letter in letters):
            at = number
            break

    def move(item: Finding) -> Finding:
        if not _is_at(item, line):
            return item
        if turn is not None and (is_angle or item.code in _OF_ROTARY_AXES):
            return _move_to_row(item, moves, turn[1])
        return item if at == line else dataclasses.replace(_move_to(item, at), called=None)

    return list(map(move, findings))


def _move_to(item: Finding, line: int) -> Finding:
    """A finding with its line, and with no line before it."""
    last, worst = (max(one or line, line) for one in (item.last_line, item.worst_line))
    return dataclasses.replace(item, line=line, last_line=last, worst_line=worst)


def _move_to_row(item: Finding, moves: Moves, row: int) -> Finding:
    """A finding with the line of a move, which may be one of a called file."""
    own = int(moves.called_lines.number_moves(moves.line[row : row + 1], np.array([row]))[0])
    there = moves.called_lines.place(dataclasses.replace(item, line=own, last_line=own, column=None, called=None))
    return _move_to(dataclasses.replace(there, last_line=item.last_line, worst_line=item.worst_line), there.line or 0)


def _find_beyond(program: Program, tip: Array, angles: Array, at_zero: Mapping[str, Array], length: float) -> list[str]:
    """The letters of rotary axes of which each, at 0, would bring all rotary joints of a pose within their travel."""
    machine = program.machine
    rotary = np.array([column.unit != "mm" for column in machine.columns])
    lower, upper = machine.limits.lower[rotary] - LIMIT_SLACK, machine.limits.upper[rotary] + LIMIT_SLACK

    def is_within(tilt: Array) -> bool:
        q, _platform, ok = machine.five_axis.solve(tip[None], tilt[None], length)
        return bool(ok[0] and (q[0, rotary] >= lower).all() and (q[0, rotary] <= upper).all())

    return [] if is_within(angles) else [letter for letter, tilt in at_zero.items() if is_within(tilt)]


def _is_at(item: Finding, line: int) -> bool:
    return item.line == line and item.severity == "error" and find_family(item.code) == Family.POSITION


def _are_legal(program: Program, tip: Array, angles: Array, length: float) -> Array:
    """Which poses (n,) are within reach and travel."""
    machine = program.machine
    q, _platform, ok = machine.five_axis.solve(tip, np.broadcast_to(angles, (len(tip), 2)), length)
    slack = np.array([LIMIT_SLACK_MM if column.unit == "mm" else LIMIT_SLACK for column in machine.columns])
    within = (q >= machine.limits.lower - slack) & (q <= machine.limits.upper + slack)
    return np.asarray(ok & within.all(axis=-1))
