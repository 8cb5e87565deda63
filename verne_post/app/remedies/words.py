"""One word of a refused program that is wrong: a code, a feed rate, a decimal point, a sign, an end of a line.

The whole program is checked with each before it is reported.
"""

import re
from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np

from verne_post.app.assemble import Program, build_interpreter_setup
from verne_post.app.explain_numbers import format_number
from verne_post.app.remedies.contacts import find_shallow_depth
from verne_post.app.remedies.lines import (
    Line,
    meets_in_rapid,
    propose_depth,
    propose_ends,
)
from verne_post.app.remedies.trials import (
    CURING_OPTIONS,
    ROUND_MM,
    find_code_of_line,
    find_line,
    is_right_with,
    is_short,
    list_errors,
    try_program,
)
from verne_post.base.arrays import Array
from verne_post.base.long_text import Text
from verne_post.base.program_lines import (
    change_number,
    find_coordinate,
    find_word,
    find_word_of,
    flip_component,
    name_component,
    read_number,
)
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.inch_words import is_in_inches
from verne_post.kinematics.checks.remedies import (
    ROTARY_CODES,
    is_straight,
)
from verne_post.model.findings import (
    Finding,
    Remedy,
    has_line,
    join_lines,
)
from verne_post.model.moves import FeedMode, MoveKind
from verne_post.model.protocols import turn_from_setup
from verne_post.output.causes import find_excess

#: In a program in inches.
_ROUND_INCH: Final = 0.005
#: What a hole that is too deep breaks: the travel of a joint, the table, fixtures, stock.
_OF_DEPTH: Final = ("VP101", "VP210", "VP215", "VP216")
#: A number of a letter with a point or a comma (1), of words and of CL files.
_POINTED_WORD: Final = r"(?<![A-Z_$]){}[ \t]*=?[ \t]*[-+]?\d*(\.|,(?=\d))"
_POINTED: Final = {"aptcl": r"(?<=\d)(\.)(?=\d)"}
#: So many places of a lost point are tried, each as long as a check.
_POINTS_TRIED: Final = 3
#: Cosine between a tool axis and the one before it where its sign was wrong: 60 degrees.
_NEAR_AXIS: Final = 0.5


def find_forgotten_g91(source: Text, program: Program, errors: Sequence[Finding]) -> Remedy | None:
    """G90 in place of the G91 above the first error, or below its line where it is for G28; checked with it."""
    lines = bytes(source).split(b"\n")
    for number in range(min(item.line or 0 for item in errors), 0, -1):
        text = lines[number - 1].decode("utf-8", errors="replace")
        word = find_word_of(text, "G", 91.0)
        if find_word_of(text, "G", 90.0) is not None:
            return None
        if word is not None:
            break
    else:
        return None
    is_for_retract = bool(find_code_of_line(source, program, number))
    if is_for_retract:
        said, lines[number - 1] = f"G90 stands below line {number}, whose G91", lines[number - 1] + b"\nG90"
    else:
        said = f"line {number} has G90 instead of G91, which"
        lines[number - 1] = change_number(text, word, "90").encode()
    if not is_right_with(b"\n".join(lines), program):
        return None
    text = f"within limits if {said} makes the values from there on distances"
    return Remedy(text) if is_for_retract else Remedy(text, "90", line=number, word=("G", 91.0))


def find_forgotten_feed(source: Text, program: Program, errors: Sequence[Finding]) -> Remedy | None:
    """A feed rate in the first line of errors, a rapid at the height of the cuts beside it; checked with it.

    The line has F, cuts precede and follow it in one frame, or a plunge at a feed rate to its height precedes it. No
    line after it becomes a cut.
    """
    moves, number = program.moves, min(item.line or 0 for item in errors)
    rows = np.flatnonzero(moves.line == number)
    if len(rows) != 1 or not 0 < rows[0] < len(moves) - 1 or moves.kind[rows[0]] != MoveKind.RAPID:
        return None
    row = int(rows[0])
    around = np.array([row - 1, row, row + 1])
    lines = bytes(source).split(b"\n")
    text = lines[number - 1].decode("utf-8", errors="replace")
    cuts = np.isfinite(moves.feed[around]) & (moves.kind[around] != MoveKind.DWELL)
    level = around[: 2 + int(cuts[2])]
    is_level = bool((moves.frame[level] == moves.frame[row]).all() and np.ptp(moves.end[level, 2]) < LIMIT_SLACK_MM)
    touches = any(item.code == "VP216" and item.line == number for item in errors)
    down = moves.end[row - 1, :3] - moves.end[row - 2, :3] if row > 1 else np.zeros(3)
    plunges = down[2] < 0.0 and np.abs(down[:2]).max() < LIMIT_SLACK_MM
    if not touches or not cuts[0] or not is_level or not (cuts[2] or plunges or find_word(text, "F")):
        return None
    if moves.feed_mode[row - 1] != FeedMode.PER_MINUTE:
        return None
    rate, word = f"F{format_number(float(moves.feed[row - 1]))}", find_word_of(text, "G", 0.0)
    setup = build_interpreter_setup(program.machine, program.options)
    if moves.language != "heidenhain" and word is not None:
        said, right, in_force = word[0], "G1", "" if find_word(text, "F") else f" ({rate} mm/min is in force)"
    elif moves.language == "heidenhain" and "FMAX" in text and not is_in_inches(source, setup, number):
        said, right, in_force = "FMAX", rate, f" ({rate} is in force)"
    else:
        return None
    lines[number - 1] = text.replace(said, right, 1).encode()
    tried = try_program(b"\n".join(lines), program, only_first=True)
    if tried is None or tried[1] or len(tried[0].moves) != len(moves):
        return None
    is_other = moves.line != number
    if not np.array_equal(np.isnan(tried[0].moves.feed)[is_other], np.isnan(moves.feed)[is_other]):
        return None
    told = f"within limits if line {number} cuts at a feed rate: write {right} in place of {said}{in_force}"
    return Remedy(told, right, line=number, misspelt=said, is_choice=True)


def find_wrong_word(source: Text, program: Program, joints: Any, errors: Sequence[Finding]) -> Remedy | None:
    """The word that alone is at fault: X, Y or Z of the first line of errors, where all of them are in one stretch.

    Of several words the one that changes least; of a line that drills, Z. The program was checked with it.
    """
    first = min(errors, key=lambda item: item.line or 0)
    start, end = first.line or 0, first.last_line or 0
    line = find_line(program, joints, start, source)
    lines = bytes(source).split(b"\n")
    if line is None or any(item.code in (*ROTARY_CODES, *CURING_OPTIONS) for item in errors):
        return None
    is_hole = not is_straight(line.exact)  # a cycle drills the next ones too, as deep
    if not is_hole and any(not start <= (item.line or 0) <= end for item in errors):
        return None
    text = lines[start - 1].decode("utf-8", errors="replace")
    ends = sorted(propose_ends(line, errors, warnings=False), key=lambda one: abs(float(one.value) - one.word[1]))
    depth = find_word(text, "Z")
    if depth is not None and is_hole:
        ends = list(propose_depth(line, read_number(depth[2])))
    for one in ends:
        letter, now = one.word
        word = find_word_of(text, letter, now)
        if word is None:
            continue
        # the line alone was checked as programmed: a blended corner may take the tool a little farther
        step = ROUND_MM if line.unit[1] == 1.0 else _ROUND_INCH
        # the number of a machine coordinate is that of its limit, and the line alone was checked a little inside it
        least = -1.0 if line.move in program.moves.machine_moves else 0.0
        steps = np.ceil(np.round(abs(float(one.value) - now) / step, 6)) + np.arange(least, 2.0)
        for then in now + np.sign(float(one.value) - now) * steps * step:
            value = format_number(then)
            changed = change_number(text, word, value)
            if is_right_with(b"\n".join([*lines[: start - 1], changed.encode(), *lines[start:]]), program):
                there = "has" if is_hole else "ends at"
                said = f"within limits if line {start} {there} {letter} {value} instead of {word[2].rstrip('.')}"
                return Remedy(said, value, line=start, word=one.word)
    return None


def find_flipped_axis(source: Text, program: Program, findings: Sequence[Finding]) -> Remedy | None:
    """The tool axis of the first line of errors with the sign of one component that it may have lost; checked with it.

    It leads away from the axis before by more than a right angle, and with the other sign by less than 60 degrees.
    """
    errors = list_errors(findings)
    moves, number = program.moves, min((item.line or 0 for item in errors), default=0)
    own = np.flatnonzero(moves.line == number)
    if not is_short(program) or not len(own) or not np.isfinite(moves.tool_axis[own[-1]]).all():
        return None
    axis, before = moves.tool_axis[own[-1]], _find_axis(program, int(own[0]) - 1)
    lines = bytes(source).split(b"\n")
    for component in range(3) if axis @ before < 0.0 else ():
        other = np.where(np.arange(3) == component, -axis, axis)
        text = lines[number - 1].decode("utf-8", errors="replace")
        flipped = flip_component(text, moves.language, component)
        if flipped is None or other @ before < _NEAR_AXIS:
            continue
        said, right, value = flipped
        alike = [at for at in range(number, len(lines) + 1) if said.encode() in lines[at - 1]]
        changed = [one.replace(said.encode(), right.encode()) for one in lines[number - 1 :]]
        if is_right_with(b"\n".join([*lines[: number - 1], *changed]), program):
            name = name_component(moves.language, component)
            told = f"within limits with {name} {value} in {join_lines(alike)}: is the sign wrong?"
            if len(alike) > 1:  # an edit is of one line
                return Remedy(told, line=number)
            return Remedy(told, right, line=number, misspelt=said, turns=True, is_choice=True)
    return None


def _find_axis(program: Program, row: int) -> Array:
    """The tool axis (3,) at the end of a move, program directions; upright before the first one."""
    moves = program.moves
    if row < 0:
        return np.array([0.0, 0.0, 1.0])
    if np.isfinite(moves.tool_axis[row]).all():
        return moves.tool_axis[row]
    frame = moves.frames[moves.frame[row]]
    axis = program.machine.coordinates.find_tool_axis(moves.end[row].tolist(), frame)
    return np.array([0.0, 0.0, 1.0]) if axis is None else axis


def find_too_deep(source: Text, program: Program, errors: Sequence[Finding]) -> Remedy | None:
    """The depth of the cycle of the first line of errors, with its point one place to the left; checked with it."""
    number = min(item.line or 0 for item in errors)
    excess = [find_excess(item) for item in errors if item.code in _OF_DEPTH]
    if not excess or not np.isfinite(max(excess)):
        return None
    setup = build_interpreter_setup(program.machine, program.options)
    scale = MM_PER_INCH if is_in_inches(source, setup, number) else 1.0
    found = find_shallow_depth(source, program, number, max(excess) / scale)
    return found[1] if found is not None and is_right_with(found[0], program) else None


def find_lost_point(source: Text, program: Program, errors: Sequence[Finding]) -> Remedy | None:
    """X, Y or Z of the first line of errors with the decimal point that it may have lost; checked with it.

    With the point it is between the numbers of this letter before and behind it, or has as many decimals as they have;
    others of it have a point. In a CL file X, Y and Z are the numbers of GOTO.
    """
    language = program.moves.language
    number = min(item.line or 0 for item in errors)
    lines = bytes(source).split(b"\n")
    text = lines[number - 1].decode("utf-8", errors="replace")
    left = _POINTS_TRIED
    for letter in "XYZ":
        word = find_coordinate(text, letter, language)
        digits = "" if word is None else word[2].lstrip("+-")
        if word is None or len(digits) < len("10") or not digits.isdecimal():
            continue
        others = re.search(_POINTED.get(language, _POINTED_WORD.format(letter)).encode(), source[:], re.IGNORECASE)
        if others is None:
            continue
        around = (_find_nearest(one, letter, language) for one in (reversed(lines[: number - 1]), lines[number:]))
        texts = [one for one in around if one is not None]
        beside = [read_number(one) for one in texts]
        sign = word[2].removesuffix(digits)
        if len(beside) != 2:
            continue
        point = others[1].decode()
        values = [f"{sign}{digits[:at] or '0'}{point}{digits[at:]}".removeprefix("+") for at in range(len(digits))]
        between = [one for one in values[::-1] if min(beside) <= read_number(one) <= max(beside)]
        decimals = {len(one.partition(point)[2]) for one in texts}
        alike = [one for one in values if {len(one.partition(point)[2])} == decimals]
        for value in (between or alike)[:left]:
            left -= 1
            changed = change_number(text, word, value).encode()
            if is_right_with(b"\n".join([*lines[: number - 1], changed, *lines[number:]]), program):
                name = f"{letter.lower()} " if language == "aptcl" else letter
                said = f"{name}{value} may be meant in line {number}, its point is missing: within limits with it"
                if language == "aptcl":
                    return Remedy(said, word[1] + value, line=number, misspelt=word[0], is_choice=True)
                return Remedy(said, value, line=number, word=(letter, float(word[2])), is_choice=True)
    return None


def _find_nearest(lines: Iterable[bytes], letter: str, language: str) -> str | None:
    """The number of a letter in the first of some lines that has it, as it is written."""
    words = (find_coordinate(one.decode("utf-8", errors="replace"), letter, language) for one in lines)
    return next((one[2] for one in words if one is not None), None)


def find_end_before_contact(source: Text, program: Program, line: Line) -> str | None:
    """Where a line along one axis ends before it touches what is left of the stock; the program was checked with it.

    Other ends are sought beside the whole stock: of a pocket, which lines before have cut, these find none.
    """
    touches = [item for item in line.findings if item.code == "VP216" and item.contact and item.line == line.number]
    if line.move < 0 or line.move in program.moves.machine_moves or not touches or not is_straight(line.exact):
        return None
    machine, (unit, scale) = program.machine, line.unit
    tip, angles = line.exact.pose(line.exact.contour, np.zeros(2, dtype=int), np.array([0.0, 1.0]))
    begin, end = (machine.coordinates.map_from_table(*ends, line.frame) for ends in zip(tip, angles, strict=True))
    moved = np.flatnonzero(np.abs(end - begin) > ROUND_MM)
    if len(moved) != 1 or moved[0] > 2 or (moved[0] < 2 and meets_in_rapid(line, touches)):
        return None
    axis, way = int(moved[0]), float(np.sign(end - begin)[moved[0]])
    contacts = turn_from_setup(machine.coordinates, np.array([one.contact for one in touches]))
    places = [machine.coordinates.map_from_table(tip, angles[1], line.frame) for tip in contacts]
    at = [float(place[axis]) for place in places]
    step = ROUND_MM if scale == 1.0 else _ROUND_INCH
    # half a step or more before the contact: bodies do not rub
    first = way * np.ceil(round(min(way * place for place in at) / scale / step, 6) - 1.5) * step
    lines = bytes(source).split(b"\n")
    said = lines[line.number - 1].decode("utf-8", errors="replace")
    word = find_word_of(said, "XYZ"[axis], float(end[axis]) / scale)
    if word is None:
        return None
    for then in first - way * step * np.arange(3):  # a contact begins within one cell
        if way * (then * scale - float(begin[axis])) < ROUND_MM:
            return None
        changed = change_number(said, word, format_number(then))
        text = b"\n".join([*lines[: line.number - 1], changed.encode(), *lines[line.number :]])
        tried = try_program(text, program, only_lines=True)
        if tried is None:
            return None
        if not any(has_line(item, line.number) for item in tried[1]):
            return f"the line ended elsewhere: {'XYZ'[axis]} {format_number(then)} in place of {word[2]} {unit}"
    return None
