"""What of the set-up is wrong where a program is refused: the place of its part, a sign, a decimal point.

The whole program is checked with each before it is reported.
"""

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from verne_post.app.assemble import Program
from verne_post.app.constraints import guard_joints
from verne_post.app.explain_numbers import format_list
from verne_post.app.remedies.trials import (
    CURING_OPTIONS,
    ROUND_MM,
    find_codes_with,
    find_line,
    find_line_in_machine,
    is_right_with,
    is_short,
    list_errors,
    name_left,
    try_program,
)
from verne_post.base.arrays import Array
from verne_post.base.long_text import Text
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.kinematics.checks.remedies import (
    FARTHEST_MM,
    ROTARY_CODES,
    find_smallest_shift,
)
from verne_post.model.codes import CODES
from verne_post.model.findings import (
    NOT_TRIED,
    NOTHING_FOUND,
    Finding,
    Remedy,
)
from verne_post.model.moves import find_tool_of_moves
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset, describe_tool_number, name_system
from verne_post.model.protocols import turn_to_setup
from verne_post.output.causes import find_excess
from verne_post.output.commands import find_run

#: A part that would have to stand farther off than this, mm, is not clamped in a wrong place: the unit is looked at.
FAR_MM: Final = 300.0
#: Offsets that are tried, each moved so that the worst line of the one before is within limits.
OFFSETS: Final = 4
#: A part that is raised by no more than this, mm, is not moved along other axes; nor for less than half of the way.
NEAR_MM: Final = 10.0
RAISED: Final = 2.0
#: A component of a move that is no larger than this share of the largest one is left out where nothing needs it.
TRACE: Final = 0.1
#: A work offset so far below the table face, mm, and to the negative side of X and Y, is no place of a part.
DEEP_MM: Final = 100.0
#: So many of the places that were tried in vain are named.
_NAMED_PLACES: Final = 4


def find_offset_of_control(program: Program, errors: Sequence[Finding]) -> Remedy | None:
    """A work offset that no part can have, and that a control's offset page may: it counts from the machine's zero.

    The origin is deep below the table face and has negative X and Y. Where the machine file has another zero than the
    table, the message says where that origin is on the table.
    """
    moves, options = program.moves, program.options
    at = np.flatnonzero(moves.line == min((item.line or 0 for item in errors), default=0))
    if not len(at) or program.machine.table_radius <= 0:
        return None
    frame = moves.frames[moves.frame[at[0]]]
    offset = options.wcs.get(frame.system)
    if offset is None or max(offset.origin_mm[:2]) >= 0 or offset.origin_mm[2] > -DEEP_MM:
        return None
    if not np.allclose(offset.origin_mm, program.machine.find_origin_on_table(frame), atol=LIMIT_SLACK_MM):
        return None  # the program sets its offset itself
    name, zero = name_system(frame.system), -np.array(program.machine.coordinates.work_origin((0.0, 0.0, 0.0)))
    text = (
        f"{NOT_TRIED}{name} = {format_list(offset.origin_mm)} is {-offset.origin_mm[2]:.6g} mm below the table face: "
        "these look like the machine coordinates of a control's offset page, and [wcs] is the place of the part on the "
        "table; "
    )
    if np.abs(zero).max() <= LIMIT_SLACK_MM:
        return Remedy(f"{text}measure it from the rotary centre on the table face")
    place = np.round(zero + np.array(offset.origin_mm), 6)
    return Remedy(
        f"{text}the machine zero of the machine file, {format_list(zero)}, plus these numbers is {name} = "
        f"{format_list(place)}: use it if the control counts from that zero, else measure it"
    )


def find_slip_of_setup(source: Text, program: Program, errors: Sequence[Finding], *, is_far: bool) -> Remedy | None:
    """A sign of the work offset, or a point of it or of the tool length, that alone is at fault; checked with it.

    Parameters
    ----------
    is_far : bool
        No work offset near this one brings the program within limits: a number may be ten times too large or small.
    """
    moves, options = program.moves, program.options
    at = np.flatnonzero(moves.line == min((item.line or 0 for item in errors), default=0))
    if not len(at):
        return None
    system = moves.frames[moves.frame[at[0]]].system
    number = int(find_tool_of_moves(at[:1], 0, moves)[0])
    tool, offset = (options.tools or {}).get(number), options.wcs.get(system)
    factors = (0.1, 10.0) if is_far else ()
    if tool is not None and tool.offset[2] and options.tool_length is None:
        x, y, now, a, b, c, u, v, w = tool.offset
        for length in (now * factor for factor in factors):
            tools = {
                **(options.tools or {}),
                number: dataclasses.replace(tool, offset=(x, y, length, a, b, c, u, v, w)),
            }
            if is_right_with(source, program, tools=tools):
                tool_name = describe_tool_number(number, moves.name_tools())
                text = (
                    f"within limits if the set-up gives {tool_name} the length {length:.6g} instead of {now:.6g}: is "
                    "a decimal point missing, or another unit meant?"
                )
                return Remedy(text, f"{length:.6g}", key=("tools", str(number), "length"))
    if offset is None or offset.source.startswith("--"):  # who gives an option has just looked at it
        return None
    for axis, value in enumerate(offset.origin_mm):
        for right in [*([-value] if axis == 2 and value < 0 else []), *(value * factor for factor in factors if value)]:
            x, y, z = (right if one == axis else float(now) for one, now in enumerate(offset.origin_mm))
            wcs = {**options.wcs, system: dataclasses.replace(offset, origin_mm=(x, y, z))}
            if is_right_with(source, program, wcs=wcs):
                name, turn = name_system(system), [offset.turn_deg] if offset.turn_deg else []
                given, then = (format_list((*one, *turn)) for one in (offset.origin_mm, (x, y, z)))
                source_name = f" of {offset.source}" if offset.source else ""
                what = "a sign" if right == -value else "a decimal point"
                text = f"within limits if {name} = {then} instead of {given}{source_name}: is {what} wrong there?"
                return Remedy(text, f"[{then}]", key=("wcs", name))
    return None


def say_no_offset(options: Options, tried: Sequence[WorkOffset]) -> Remedy:
    """That no move of the part was found, and which were tried."""
    named = "; ".join(format_list(one.origin_mm) for one in list(dict.fromkeys(tried))[:_NAMED_PLACES])
    with_them = f" (tried: {named})" if named else ""
    fit = find_run(options).spell("fit", options.source_name)
    return Remedy(
        f"{NOTHING_FOUND} was found that brings the program within limits{with_them}; `{fit}` "
        "seeks one over the whole table"
    )


def find_offset(
    source: Text, program: Program, errors: Sequence[Finding], tried: list[WorkOffset], farthest: float
) -> tuple[Remedy, float] | None:
    """A work offset, as an option, with which the whole program was checked, and how far it moves the part, mm.

    Those that did not help are added to ``tried``.
    """
    best: tuple[int, float] = (len(CODES), np.inf)
    for one in find_legal_offsets(source, program, errors, tried=tried, farthest=farthest):
        given = program.options.wcs.get(one[0])
        moved_there = np.array(one[1].origin_mm) - np.array(given.origin_mm if given else (0.0, 0.0, 0.0))
        distance = float(np.linalg.norm(moved_there))
        if (len(one[2]), RAISED * distance) < best:
            best, moved_mm, (system, offset, left) = (len(one[2]), distance), moved_there, one
        if distance <= NEAR_MM:
            break
    if not np.isfinite(best[1]):
        return None
    offset, moved_mm = _leave_out_traces(source, program, system, offset, moved_mm, left)
    name = name_system(system)
    then = format_list((*offset.origin_mm, *([offset.turn_deg] if offset.turn_deg else [])))
    moved = f"if the part is moved by {format_list(moved_mm)} mm (then {name} = {then})"
    none_given = "no work offset was given; " if given is None else ""
    what = f"the other errors are gone {moved}; {name_left(left)}" if left else f"within limits {moved}"
    return Remedy(f"{none_given}{what}", f"[{then}]", key=("wcs", name)), best[1]


def _leave_out_traces(
    source: Text, program: Program, system: int, offset: WorkOffset, moved: Array, left: Sequence[str]
) -> tuple[WorkOffset, Array]:
    """A work offset, and its move (3,), mm, without small components that the program does not need."""
    for axis in np.argsort(np.abs(moved))[:2].tolist():
        if not 0.0 < abs(moved[axis]) <= TRACE * np.abs(moved).max():
            continue
        less = np.where(np.arange(3) == axis, 0.0, moved)
        x, y, z = (round(float(value), 6) for value in np.array(offset.origin_mm) - moved + less)
        there = dataclasses.replace(offset, origin_mm=(x, y, z))
        found = find_codes_with(source, program, wcs={**program.options.wcs, system: there})
        if found is not None and set(found) <= set(left):
            offset, moved = there, less
    return offset, moved


def find_legal_offsets(
    source: Text,
    program: Program,
    errors: Sequence[Finding],
    free: str = "xyz",
    tried: list[WorkOffset] | None = None,
    farthest: float = FARTHEST_MM,
) -> Iterator[tuple[int, WorkOffset, tuple[str, ...]]]:
    """Work offsets with no errors left but tilt and rotary travel: the system, the offset, the codes that are left.

    The part is moved along its z first, then along all of the axes in ``free``. ``tried`` grows by every place.
    """
    tried = [] if tried is None else tried
    concerned = _select_movable_errors(program, list_errors(errors))
    first = find_line(program, guard_joints(program), concerned[0].line) if concerned else None
    if first is None or not is_short(program):
        return
    system, turn = first.frame.system, first.frame.part_turn
    given = program.options.wcs.get(system)
    origin = np.array(given.origin_mm if given else (0.0, 0.0, 0.0))
    if np.abs(origin - np.array(program.machine.find_origin_on_table(first.frame))).max() > LIMIT_SLACK_MM:
        return  # the program sets its offset itself: no option moves it
    axes = ["xyz".index(letter) for letter in free if letter in "xyz"]
    for moved in dict.fromkeys((tuple({2}.intersection(axes)), tuple(axes))):
        basis = program.machine.coordinates.part_frame.T[list(moved)]
        where = (origin, system, turn, concerned, basis, tried, farthest)
        found = _find_legal_origin(source, program, *where) if moved else None
        if found is not None:
            (x, y, z), left = found
            yield system, WorkOffset((float(x), float(y), float(z)), turn), left


def _find_legal_origin(
    source: Text,
    program: Program,
    origin: Array,
    system: int,
    turn: float,
    errors: Sequence[Finding],
    basis: Array,
    tried: list[WorkOffset],
    farthest: float,
) -> tuple[Array, tuple[str, ...]] | None:
    """An origin (3,) with no errors left but tilt and rotary travel, and their codes; None if none is found."""
    there, place, concerned = program, origin, list(errors)
    for _ in range(OFFSETS):
        worst = max(concerned, key=find_excess)
        line = find_line(there, guard_joints(there), worst.worst_line or worst.line)
        shift = None if line is None else find_smallest_shift(line.joints, basis, farthest=farthest)
        if shift is None:
            return None
        step = turn_to_setup(program.machine.coordinates, np.array(shift.vector))
        if not step.any():  # the line alone is within limits: a corner beside it, which is rounded, is not
            step = ROUND_MM * np.sign(place - origin)
            step = step if step.any() else ROUND_MM * np.array([0.0, 0.0, float(worst.code == "VP210")])
        moved = place + step - origin
        place = origin + np.sign(moved) * np.ceil(np.round(np.abs(moved) / ROUND_MM, 6)) * ROUND_MM
        if np.linalg.norm(place - origin) > farthest:
            return None
        x, y, z = (round(float(value), 6) for value in place)
        tried.append(WorkOffset((x, y, z), turn))
        wcs = {**program.options.wcs, system: tried[-1]}
        made = try_program(source, program, wcs=wcs)
        if made is None:
            return None
        there, found = made
        concerned = _select_movable_errors(there, found)
        if not concerned:
            return place, tuple(dict.fromkeys(item.code for item in found))
    return None


def _select_movable_errors(program: Program, errors: Sequence[Finding]) -> list[Finding]:
    """Errors that a move of the part may cure."""
    others = (*ROTARY_CODES, *CURING_OPTIONS)
    return [
        item for item in errors if item.code not in others and item.line and not find_line_in_machine(program, item)
    ]
