"""Causes before consequences: a refused motion of which a warning says that another one is meant.

To move the part would bring the wrong motion within limits.
"""

import dataclasses
import re
from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.app.assemble import Program, assemble
from verne_post.app.constraints import check_program
from verne_post.app.doubts.setup import is_retracted
from verne_post.app.remedies.trials import is_short
from verne_post.base.long_text import Text
from verne_post.base.program_lines import find_word
from verne_post.base.tolerances import DRILL_TILT, ZERO_ANGLE
from verne_post.model.codes import IF_DIRECTIONS_ARE_MEANT
from verne_post.model.findings import NOT_TRIED, Finding, InputError, Remedy
from verne_post.model.moves import AXES, MoveKind, PlaneCall
from verne_post.model.verdict import is_about_pose

#: Warnings that the directions, the plane or the sense of a turn are others than the program means.
_DOUBTS: Final = ("VP037", "VP042", "VP043", "VP054", "VP056")
#: A code that says how the axes of its block go.
_MOTION_CODE: Final = re.compile(rb"(?<![A-Za-z_])G0*[0-3](?![\d.])", re.IGNORECASE)


def find_meant_motion(source: Text, program: Program, findings: Sequence[Finding]) -> Remedy | None:
    """What is to be settled before a refused motion is given another place: a table left turned, or a warning.

    The first has the words that turn the table back, and the program was checked with them.

    Parameters
    ----------
    findings : sequence of Finding
        Those of poses with the severity "error" are asked about.
    """
    doubts = [item for item in program.findings if item.code in _DOUBTS and _is_about_meaning(program, item)]
    errors = [item for item in findings if item.severity == "error" and is_about_pose(item.code) and item.line]
    for item in errors:
        at = _find_move(program, item)
        if at < 0:
            continue
        if (turn := _find_turn_back(source, program, item, at, doubts)) is not None:
            return turn
        if (doubt := next((one for one in doubts if _is_about_same_place(program, one, item, at)), None)) is not None:
            text = f"{NOT_TRIED}correct {doubt.code} of line {doubt.line} first: the program may mean another motion"
            begins_before = (item.line or 0) < (doubt.line or 0)
            return Remedy(
                f"{text}{'' if begins_before else '. A move of the part does not help'}", line=doubt.line or 0
            )
    return None


def _is_about_meaning(program: Program, item: Finding) -> bool:
    """Whether a doubt says that the motion is another one: LinuxCNC may well hold the tip without a code (VP037)."""
    return program.moves.needs_tcp_code or item.advice != IF_DIRECTIONS_ARE_MEANT


def _find_move(program: Program, item: Finding) -> int:
    """The first move of a finding that the part may follow; -1 without one."""
    moves = program.moves
    own = (moves.line == item.line) & ~moves.find_in_machine() & (moves.kind != MoveKind.DWELL)
    return int(np.flatnonzero(own)[0]) if own.any() else -1


def _is_about_same_place(program: Program, doubt: Finding, item: Finding, at: int) -> bool:
    """Whether a doubt is about a line of an error, or about one before it in the same plane and place of the table."""
    line, last = item.line or 0, item.last_line or item.line or 0
    if any(line <= (one or 0) <= last for one in (doubt.line, doubt.last_line)):
        return True
    moves, said = program.moves, _find_move(program, doubt)
    same_place = moves.frame[said] == moves.frame[at] and np.array_equal(moves.end[said, 3:6], moves.end[at, 3:6])
    return 0 <= said <= at and bool(same_place)


def _find_turn_back(source: Text, program: Program, item: Finding, at: int, doubts: Sequence[Finding]) -> Remedy | None:
    """Words that turn the table back before the first move after the end of a plane or of tool-centre-point control."""
    moves, rotary = program.moves, program.machine.coordinates.rotary
    left = _find_end(program, at)
    lines = bytes(source).split(b"\n")
    if left is None or not left.line < (item.line or 0) <= len(lines):
        return None
    letters = [AXES[axis] for axis in rotary]
    between = [text.decode("utf-8", errors="replace") for text in lines[left.line : item.line]]
    if any(find_word(text, letter) is not None for text in between for letter in letters):
        return None
    in_machine = moves.find_in_machine()
    goes = np.flatnonzero(~in_machine[left.before : at + 1] & (moves.line[left.before : at + 1] > left.line))
    first = int(moves.line[left.before + goes[0]]) if len(goes) else item.line or 0
    words = " ".join(f"{letter}0" for letter in letters)
    value = f"L {words} R0 FMAX" if moves.language == "heidenhain" else f"G0 {words}"
    place = " ".join(f"{AXES[axis]}{moves.end[at, axis] + 0.0:.6g}" for axis in rotary)
    why = f"the {program.machine.rotary_side} stands at {place}, where {left.word} in line {left.line} has left it"
    is_doubted = any(one.code == "VP037" and (one.line or 0) > left.line for one in doubts)
    cure = f"{words} before line {first}"
    is_out = is_retracted(moves, program.machine, left.before + int(goes[0]) - 1 if len(goes) else at - 1)
    is_kept = moves.language == "heidenhain" or _MOTION_CODE.search(lines[first - 1]) is not None
    remaining: Sequence[Finding] = ()
    if is_tried := is_short(program):
        try:
            changed = b"\n".join([*lines[: first - 1], value.encode(), *lines[first - 1 :]])
            tried = assemble(changed, program.machine, program.options, program.team)
            remaining = [one for one in check_program(tried)[1] if one.severity == "error"]
            feeds = tried.moves.feed[tried.moves.line != first]
            is_kept = np.array_equal(np.isnan(feeds), np.isnan(moves.feed))  # no cut has become a rapid
        except InputError as error:
            remaining = [one for one in error.findings if one.severity == "error"]
    if not is_doubted and (remaining or not is_tried):
        return None
    if not is_kept:
        cure = f"name G0 or G1 in line {first}, then {cure}"
    if not is_out:  # else the table turns by rapid with the tool in the part
        cure = f"retract the tool first, then {cure}"
    remedy = Remedy("", line=first)
    if is_kept and is_out:
        remedy = Remedy("", value, line=first, way="before", turns=True)
    if not (is_tried and remedy.value):
        return dataclasses.replace(remedy, text=f"{NOT_TRIED}{cure}, because {why}")
    if not remaining:
        return dataclasses.replace(remedy, text=f"within limits with {cure}: {why}")
    codes = list(dict.fromkeys(one.code for one in remaining))
    what = f"{cure} comes first, because {why}; with it {', '.join(codes)} of line "
    at_line = min(one.line or 0 for one in remaining)  # of the changed program
    return dataclasses.replace(remedy, text=f"{what}{at_line - (at_line > first)} is left")


def _find_end(program: Program, at: int) -> PlaneCall | None:
    """What ended before a move and left the table tilted as it still stands; None where a plane is in force."""
    moves, coordinates = program.moves, program.machine.coordinates
    planes = [one for one in moves.planes if one.before <= at]
    if planes and planes[-1].word:
        return None
    ends = [one for one in moves.tcp_ends if one.word != "G49" and one.before <= at]
    if len(planes) > 1:
        ends.append(replace(planes[-1], word=planes[-2].end))
    left = max(ends, key=lambda one: one.before, default=None)
    if left is None:
        return None
    stood = moves.end[left.before - 1] if left.before else moves.start
    rotary = list(coordinates.rotary)
    if (np.abs(moves.end[left.before : at + 1, rotary] - stood[rotary]) > ZERO_ANGLE).any():
        return None
    axis = coordinates.find_tool_axis(moves.end[at].tolist(), replace(moves.frames[moves.frame[at]], feature=None))
    return left if axis is not None and axis[2] < 1.0 - DRILL_TILT else None
