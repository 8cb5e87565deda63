"""One line of a program: what is wrong, what would bring it within limits, its pose, and the steps to that."""

import dataclasses
import math
import re
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.app.explain_numbers import format_degrees, format_joint, format_mm, format_number
from verne_post.app.explain_solutions import SAME, explain_solutions, explain_table_solution, find_travel_margins
from verne_post.app.remedies.lines import (
    Line,
    Trial,
    describe_kept_angle,
    describe_plane,
    find_words,
    is_carried_along,
    is_of_cycle,
    propose,
)
from verne_post.base.arrays import Array
from verne_post.base.numbers import format_fixed
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.tolerances import UPRIGHT_DEG, ZERO_LENGTH_MM
from verne_post.gcode.block import read_block
from verne_post.gcode.machining.state import State, name_unit_of_speed
from verne_post.gcode.program_error import ProgramError
from verne_post.kinematics.checks import remedies
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.codes import CODES
from verne_post.model.findings import NOT_TRIED, Finding, name_lines
from verne_post.model.machine import Machine
from verne_post.model.moves import AXES, FeedMode, MoveKind, PathMode
from verne_post.model.part_setup import name_system
from verne_post.model.protocols import AxisCorrecting, name_solution, turn_to_setup
from verne_post.model.toolpath import SegmentKind
from verne_post.model.verdict import find_worst, is_about_pose
from verne_post.output.commands import find_run
from verne_post.output.findings import describe_remedy
from verne_post.output.summary import list_unchecked
from verne_post.toolpath.margins import list_margin_functions

#: Decimals of mm and degrees where a pose is told in a few lines.
_FEW: Final = 3
#: Shares of F that differ by less are the same.
_SAME_SHARE: Final = 1e-6


def find_lines_near(joints: JointPath, line: int) -> list[int]:
    """The nearest source lines before and after ``line`` that have motion."""
    lines = np.unique(joints.contour.find_lines())
    lines = lines[lines > 0]
    return [int(near[at]) for near, at in ((lines[lines < line], -1), (lines[lines > line], 0)) if len(near)]


def explain_line(line: Line) -> Iterator[str]:
    """What is asked, what is wrong by how much and where, what would settle it, and the pose at the end of the line."""
    joints, machine = line.exact, line.exact.machine
    tip, angles, tool = _find_end(line)
    yield from explain_findings(line)
    yield from _describe_remedies(line, line.findings)
    unchecked = [text for _key, text in list_unchecked(machine, line.options, line.moves.events)]
    if (part := line.options.part) is not None:  # that takes seconds to a minute, a line less than two
        check = find_run(line.options).spell("check", line.options.source_name)
        unchecked.insert(0, f"cuts into the nominal part {part.name}, and what stays on it: `{check}` compares it")
    if unchecked:
        yield f"NOT CHECKED: {'; '.join(unchecked)}"
    yield ""
    n_moves = len(np.unique(line.rows[: line.last + 1]))
    which = f", the last of {n_moves} moves" if n_moves > 1 else ""
    yield f"pose at the end of the motion{which}{', as programmed' if _has_blended_corner(line) else ''}"
    yield from _describe_end(line)
    yield from _describe_nearest_limit(machine, tip, angles, tool)
    yield from _describe_time(line)
    for name, pair, is_own in _list_table_solutions(line, angles):
        yield f"  {next(explain_table_solution(machine, name, tip, pair, tool, joints.lift, is_programmed=is_own))}"


def explain_findings(line: Line) -> Iterator[str]:
    """The first part of :func:`explain_line`: what is asked, and what is wrong, without what would settle it."""
    yield from _describe_words(line, _find_end(line)[2] - line.exact.lift)
    yield f"  machine              {line.exact.machine.name}"
    if line.planned:
        yield f"  motion               {line.planned}"
    yield ""
    yield from _describe_findings(line, line.findings)


def work_through(line: Line) -> Iterator[str]:
    """Every step from words to joints, all margins of both table solutions, and every solution of the machine."""
    joints, machine = line.exact, line.exact.machine
    tip, angles, tool = _find_end(line)
    yield "from words to joints, at the end of the motion"
    yield from _describe_program_step(line, angles)
    yield from _describe_machine_steps(machine, tip, angles, tool)
    yield ""
    for name, pair, is_own in _list_table_solutions(line, angles):
        yield from explain_table_solution(machine, name, tip, pair, tool, joints.lift, is_programmed=is_own)
    if machine.columns[-1].driven:
        q = machine.five_axis.solve(tip, angles, tool)[0]
        yield ""
        yield from explain_solutions(machine, tip, angles, q, tool, joints.lift)


def _find_end(line: Line) -> tuple[Array, Array, float]:
    """Tip (3,), angles (2,) and tool length at the end of a line as programmed."""
    solved = line.exact.solve(np.array([line.last]), np.array([1.0]))
    tool = float(line.exact.contour.find_tool_lengths(np.array([line.last]))[0])
    return solved.tip[0], solved.angles[0], tool


def _list_table_solutions(line: Line, angles: Array) -> list[tuple[str, Array, bool]]:
    """The table solution of a line and the other one, and whether it is the line's own.

    Legs alone follow from the tool axis, however words name it.
    """
    if not line.exact.machine.columns[-1].driven:
        return [("as programmed", angles, True)]
    return [
        (_name_own_solution(line, angles), angles, True),
        (f"other {name_solution(line.exact.machine.coordinates)}", np.array([-angles[0], angles[1] + np.pi]), False),
    ]


def describe_pose(line: Line) -> Iterator[str]:
    """The words of a line, and the pose at the end of its motion in a few lines: joints, and how far they may go."""
    joints, machine = line.exact, line.exact.machine
    tip, angles, tool = _find_end(line)
    yield from _describe_words(line, tool - joints.lift)
    yield from _describe_end(line)
    yield f"  {next(explain_table_solution(machine, 'pose', tip, angles, tool, joints.lift))}"


def _describe_end(line: Line) -> Iterator[str]:
    """Place and joints at the end of a line, how far they may go, the nearest limit, and the time of the line."""
    machine = line.exact.machine
    tip, angles, tool = _find_end(line)
    yield f"  tip on the table     {format_mm(turn_to_setup(machine.coordinates, tip), _FEW)}{_name_centre(line)}"
    yield f"  words                {machine.name_angles(angles, _FEW)} deg"
    q, _platform, ok = machine.five_axis.solve(tip, angles, tool)
    if not ok:
        return
    yield f"  joints               {', '.join(format_joint(machine, k, value, _FEW) for k, value in enumerate(q))}"
    margins = ", ".join(
        f"{column.joint} {f'{format_fixed(margin, _FEW)} {column.unit}' if np.isfinite(margin) else 'unlimited'}"
        for column, margin in zip(machine.columns, find_travel_margins(machine, q), strict=True)
    )
    yield f"  margin to travel     {margins}"


def _describe_nearest_limit(machine: Machine, tip: Array, angles: Array, tool: float) -> Iterator[str]:
    measure, names = list_margin_functions(machine)
    table = measure(tip[None], angles[None], np.array([tool]))[0]
    if np.isfinite(table).any():
        least = int(table.argmin())
        left = f"{100 * table[least]:.0f} % left" if table[least] >= 0 else "exceeded"
        yield f"  nearest limit        {names[least]}, {left}"


def _describe_time(line: Line) -> Iterator[str]:
    """What a line takes at the feed rate, or at the speeds of the joints where these are too slow, over all passes."""
    contour, machine = line.exact.contour, line.exact.machine
    element = np.arange(len(contour))
    begin, end = (line.exact.solve(element, np.full(len(element), w)) for w in (0.0, 1.0))
    at_feed = contour.path.feed_time[contour.segment] * (contour.high - contour.low) / line.options.override
    seconds = np.column_stack([np.abs(end.q - begin.q) / machine.limits.velocity, at_feed])
    if np.isfinite(seconds).all():
        needed = seconds.max(axis=1)
        # what sets the pace of most of the time
        most = int(np.bincount(seconds.argmax(axis=1), needed, seconds.shape[1]).argmax())
        pace = [*(f"the largest speed of {column.joint}" for column in machine.columns), "the feed rate"][most]
        yield f"  time                 {needed.sum():.3f} s at {pace}, without acceleration"


# --- words -------------------------------------------------------------------------------------


def _describe_words(line: Line, tool: float) -> Iterator[str]:
    if line.state is None or line.move < 0:
        yield f"line {line.number}: the approach (--from), in no words of the program; tool length {tool:g} mm"
        return
    yield f"line {line.number}: {line.text.strip()}"
    if line.is_repeated:
        yield "  runs several times: pose and values are those of the first pass, times and findings those of all"
    state, moves, machine = line.state, line.moves, line.exact.machine
    feed_mode, path_mode = FeedMode(moves.feed_mode[line.move]), moves.controls[moves.control[line.move]].mode
    modal = list_modes(state, machine, feed_mode, path_mode, tool)
    feed = float(moves.feed[line.move])
    if np.isfinite(feed):
        share = "" if line.options.override == 1.0 else f" at an override of {100 * line.options.override:g} %"
        modal.append(f"feed {feed:g} {_name_feed_unit(line)}{share}{_explain_arc_feed(line, state)}")
    yield f"  in force             {', '.join(modal)}"


def _name_centre(line: Line) -> str:
    """What leads the tip beside the programmed place; empty where it is there."""
    if line.contour_end is None or line.state is None or line.state.compensation is None:
        return ""
    return f", tool centre, {line.state.compensation.describe_side()}"


def _explain_arc_feed(line: Line, state: State) -> str:
    """Why the feed rate of an arc beside the contour is not F; empty where it is."""
    is_arc = line.moves.kind[line.move] == MoveKind.ARC
    share = float(line.moves.feed[line.move]) / state.feed if state.feed else 1.0
    if state.compensation is None or not is_arc or abs(share - 1.0) <= _SAME_SHARE:
        return ""
    rule, number = state.arc_feed, format_number(state.feed_angular, _FEW)
    is_bound = min(abs(share - rule.least), abs(share - rule.most)) <= _SAME_SHARE
    where = (
        f"{share:.4g} times F{number} on the arc ({rule.name})" if is_bound else f"F{number} at the contour of the arc"
    )
    return f" of the tool centre: {where}"


def list_modes(state: State, machine: Machine, feed_mode: FeedMode, path_mode: PathMode, tool: float) -> list[str]:
    """What holds, in words of the program: codes, work system, plane, cutter compensation, tool length (mm)."""
    return [
        *state.modes.show(feed_mode, path_mode),
        name_system(state.frame.system),
        *_describe_plane(state, machine),
        *([] if state.compensation is None else [state.compensation.describe_offset()]),
        f"tool length cancelled by {state.length_end} (a tip is shown for {tool:g} mm)"
        if state.length_end
        else f"tool length {tool:g} mm",
    ]


def describe_modes(state: State, machine: Machine, *, with_values: bool = False) -> str:
    """What holds after a line without motion.

    ``with_values``: those of F, S and T too, of which some are assumed past an error.
    """
    modal = list_modes(state, machine, state.feed_mode, state.control.mode, state.frame.tool_length)
    if with_values:
        modal += _list_values(state)
    return f"in force: {', '.join(modal)}"


def _list_values(state: State) -> Iterator[str]:
    """The feed rate, spindle and tool that hold; an F of G93 holds for its own block alone."""
    if state.feed and state.feed_mode != FeedMode.INVERSE:
        unit = "mm per turn of the spindle" if state.feed_mode == FeedMode.PER_REVOLUTION else "mm/min"
        yield f"feed {format_number(state.feed, _FEW)} {unit}"
    if state.spindle_speed:
        unit = str(name_unit_of_speed(state).get("unit", "1/min"))
        yield f"spindle {'on' if state.spindle_on else 'off'}, S {state.spindle_speed:g} {unit}"
    tools = {"tool": state.loaded_tool, "next tool": state.selected_tool}
    for what, number in tools.items():
        if number is not None and (what == "tool" or number != state.loaded_tool):
            yield f"{what} {state.tool_names.get(number, number)}"


def _describe_plane(state: State, machine: Machine) -> Iterator[str]:
    """The tilted plane in force; else how X, Y, Z are turned and shifted against the work system, where they are."""
    plane, shifts = state.frame.feature, zip(AXES, state.frame.g92, strict=True)
    if shown := ", ".join(f"{at} {format_number(by)} {'deg' if at in 'ABC' else 'mm'}" for at, by in shifts if by):
        yield f"zero shifted by {shown} (G52, G92)"
    if plane is None:
        return
    if not plane.is_programmed:
        axes = list(zip(machine.rotary_letters, machine.coordinates.rotary, strict=True))
        angles = " ".join(f"{letter}{format_number(state.position[axis], 4)}" for letter, axis in axes)
        assumed = "" if any(state.named_axes[axis] for _letter, axis in axes) else " (assumed)"
        yield f"no tilted plane: X, Y, Z along the axes of the machine, at {angles}{assumed}"
        return
    if not plane.is_level:
        yield f"tilted work plane, its Z along {_show_direction(plane.rotation[2::3])}"
    if max(map(abs, plane.origin)) > ZERO_LENGTH_MM:
        yield f"zero shifted by {_show_direction(plane.origin)} mm"
    turn = math.degrees(math.atan2(plane.rotation[3], plane.rotation[0]))
    if plane.is_level and abs(turn) > UPRIGHT_DEG:
        yield f"turned by {format_number(turn, 4)} deg about Z"


def _show_direction(axis: Sequence[float]) -> str:
    return f"({', '.join(f'{value + 0.0:.4g}' for value in axis)})"


def _name_feed_unit(line: Line) -> str:
    if line.moves.feed_mode[line.move] == FeedMode.PER_REVOLUTION:
        return "mm per turn of the spindle"
    path = line.exact.contour.path
    segment = line.exact.contour.segment[line.last]
    still = np.linalg.norm(path.end[segment, :3] - path.start[segment, :3]) < ZERO_LENGTH_MM
    return "deg/min" if path.turn[segment] >= 0 or (still and path.kind[segment] == SegmentKind.LINE) else "mm/min"


def _describe_program_step(line: Line, angles: Array) -> Iterator[str]:
    """Words -> program coordinates -> place on the table."""
    if line.state is None or line.move < 0:
        return
    machine, frame = line.exact.machine, line.frame
    try:
        block = read_block(line.text, line.number)
    except ProgramError:  # values to compute, an O word, another dialect
        block = None
    named = {} if block is None else block.words
    machine_words = (
        []
        if block is None
        else [f" of G{number:g}" for letter, number, _column in block.codes if letter == "G" and number in (28, 30, 53)]
    )
    centre = line.moves.end[line.move]
    end = centre if line.contour_end is None else line.contour_end
    word = "control point" if line.moves.kind[line.move] == MoveKind.SPLINE else "word"
    by_vector = bool(np.isfinite(line.moves.tool_axis[line.move]).all())
    parts = []
    for letter in machine.coordinates.axes:
        unit = "deg" if letter in "ABC" else "mm"
        if by_vector and letter in "ABC":
            how = "of the tool axis"
        elif letter in named:
            scale = " in" if line.state.modes.inch and letter not in "ABC" else ""
            how = f"{word} {letter}{format_number(named[letter])}{scale}{''.join(machine_words)}"
        elif block is not None:
            how = "kept"
        else:  # by a rotated plane or a polar end, a line also moves axes that it does not name
            how = "as the line says" if is_axis_named(line.text, letter) else ""
        value = f"{letter} {format_number(end[AXES.index(letter)])} {unit}"
        parts.append(f"{value} ({how})" if how else value)
    yield f"  program coordinates  {', '.join(parts)}"
    if beside := _name_centre(line):
        place = ", ".join(f"{AXES[axis]} {format_number(centre[axis])}" for axis in range(3))
        yield f"  tool centre          {place} mm{beside.removeprefix(', tool centre')}; p is this place"
    shift = np.asarray(frame.g92)
    if shift.any():
        shown = ", ".join(f"{letter} {format_number(shift[AXES.index(letter)])}" for letter in machine.coordinates.axes)
        yield f"  G92, G52             p = program coordinates + ({shown})"
    origin = np.array(machine.find_origin_on_table(frame))
    turn = frame.turn + frame.part_turn
    yield (
        f"  work offset          {name_system(frame.system)}: o = {format_mm(origin)}, c = {format_number(turn)} deg; "
        "tip = o + Rz(c) p"
    )
    wanted = machine.coordinates.map_to_table(centre, frame)[1]
    if np.abs(wanted - angles).max() > SAME:
        yield (
            f"  {machine.rotary_side:<20} {' and '.join(machine.rotary_letters)} are on another branch than the words "
            "name"
        )


#: Comments, texts and values of functions, in which letters name nothing.
_NO_WORDS = re.compile(r'\([^()]*\)|;.*|"[^"]*"')
#: A statement of CL files that gives X, Y and Z by their order.
_BY_ORDER = re.compile(r"\s*(?:GOTO|GODLTA|FROM)\s*/", re.IGNORECASE)


def is_axis_named(text: str, letter: str) -> bool:
    """Whether a line has a word of the axis: the letter, also after Klartext's I, before a value that may be computed.

    Letters inside other words (SPA+10, FMAX, P1X+0) are none.
    """
    if letter in "XYZ" and _BY_ORDER.match(text):
        return True
    word = rf"(?<![A-Z_])(?<!P\d)I?{letter}\s*[-+.\d\[#=Q]"
    return re.search(word, _NO_WORDS.sub(" ", text), re.IGNORECASE) is not None


def _describe_machine_steps(machine: Machine, tip: Array, angles: Array, tool: float) -> Iterator[str]:
    """Place on the table -> gauge point -> platform -> joints, with the names of docs/conventions.md."""
    if machine.module is None:
        yield from _describe_chain_steps(machine, tip, angles, tool)
        return
    axis = find_axis_of_angles(angles[0], angles[1])
    gauge = machine.five_axis.find_platform_gauge(tip, angles, tool)
    yield f"  tip on the table     {format_mm(turn_to_setup(machine.coordinates, tip))}"
    yield (
        f"  tool axis            k = (sin A sin C, sin A cos C, cos A) = "
        f"({', '.join(format_fixed(value, 6) for value in axis)})"
    )
    yield (
        f"  nominal angles       A {format_degrees(angles[0])} deg, C {format_degrees(angles[1])} deg (workpiece sense)"
    )
    yield f"  gauge point          g = Rx(A) (rotary_offset + Rz(C) tip) + (0, 0, l) = {format_mm(gauge)}"
    q, platform, ok = machine.five_axis.solve(tip, angles, tool)
    if not ok:
        (code,) = machine.five_axis.explain_unreachable(tip[None], angles[None], tool)
        yield (
            f"  platform             no platform tilt alpha closes the legs in the working mode: {code} "
            f"{CODES[code].title}"
        )
        return
    if isinstance(machine.five_axis, AxisCorrecting):
        yield from _describe_as_built_steps(machine, machine.five_axis, tip, angles, tool)
        return
    yield (
        f"  platform             P = pivot + F Rx(alpha) g = {format_mm(platform.position)}, "
        f"platform tilt alpha {format_degrees(float(platform.alpha))} deg"
    )
    names = ", ".join(machine.actuators)
    a, c = (
        f"-({text})" if column.factor < 0 else text
        for column, text in zip(machine.columns[-2:], ("A + alpha", "C"), strict=True)
    )
    yield f"  joints               {names} from P; a = {a}, c = {c}:"
    shown = ", ".join(format_joint(machine, k, value) for k, value in enumerate(q))
    yield f"                       {shown}"


def _describe_chain_steps(machine: Machine, tip: Array, angles: Array, tool: float) -> Iterator[str]:
    """Place on the part -> joints of a machine of one chain."""
    q = machine.five_axis.find_joints(tip, angles, tool)
    on_part, axis, _ok = machine.forward(q, tool)
    yield f"  tip on the part      {format_mm(on_part)}"
    yield f"  tool axis            k = ({', '.join(format_fixed(value, 6) for value in axis)})"
    yield f"  words                {machine.name_angles(angles, 6)} deg"
    yield f"  joints               {', '.join(format_joint(machine, k, value) for k, value in enumerate(q))}"


def _describe_as_built_steps(
    machine: Machine, as_built: AxisCorrecting, tip: Array, angles: Array, tool: float
) -> Iterator[str]:
    """The last steps on an as-built machine."""
    q, platform, _ok = machine.five_axis.solve(tip, angles, tool)
    turned = ", ".join(format_degrees(float(angle)) for angle in platform.angles)
    error = float(as_built.measure_axis_error(q, angles, platform))
    share = "C takes its share" if as_built.corrects_axis else "C stays as programmed (--correct-axis)"
    yield (
        f"  platform             P = {format_mm(platform.position)}, turned by alpha, beta, gamma = {turned} deg (six "
        "rods, as built)"
    )
    yield f"  tool axis left over  {format_degrees(error)} deg along the tilt axis, which A cannot correct; {share}"
    shown = ", ".join(format_joint(machine, k, value) for k, value in enumerate(q))
    yield f"  joints               {shown}"


# --- findings and remedies -----------------------------------------------------------------------


def _has_blended_corner(line: Line) -> bool:
    """Whether the tool leaves the programmed path beside a corner of the line."""
    return len(line.joints.contour) != len(line.exact.contour)


def _describe_findings(line: Line, findings: Sequence[Finding]) -> Iterator[str]:
    if not findings:
        also = "" if line.options.part is None else "; it was not compared with the nominal part"
        yield f"findings: none, the whole line is within limits{also}"
        return
    driven = (
        ", its corners as they are blended (check adds the rest of the corner at its end)"
        if _has_blended_corner(line)
        else ""
    )
    yield f"findings, worst over the whole line{driven}"
    places = [remedies.place_of(line.joints, item) for item in findings]
    shown = [
        "" if one is None else _place(line, one, first=item.value is None)
        for one, item in zip(places, findings, strict=True)
    ]
    for item, where, after in zip(findings, shown, [*shown[1:], ""], strict=True):
        same = f" ({name_lines(item)}; the numbers are those of line {item.line})" if item.lines else ""
        yield f"  {item.code} {item.severity}: {item.full_message}{same}"
        if where and where != after:  # what is broken at one place has it once, below
            yield f"    {where}"


def _place(line: Line, place: remedies.Place, first: bool) -> str:
    joints = line.joints
    tip, angles = joints.pose(joints.contour, np.array([place.element]), np.array([place.w]))
    n = len(joints.contour)
    from_ = "first at" if first else "at"
    share, lengths = place.w, joints.contour.length
    if n > 1 and lengths.sum() > 0:
        share = float(lengths[: place.element].sum() + place.w * lengths[place.element]) / float(lengths.sum())
    which = " of all passes" if line.is_repeated else ""
    there = format_mm(turn_to_setup(joints.machine.coordinates, tip[0]))
    return (
        f"{from_} {100 * share:.4g} % of the way{which}: tip {there} on the table, "
        f"words {joints.machine.name_angles(angles[0], 6)} deg"
    )


def add_line_remedies(line: Line, holds: Trial) -> Line:
    """A line whose gravest findings about numbers have what would bring it within limits, where anything does."""
    asked = [item for item in line.findings if is_about_pose(item.code)]
    if not asked or not remedies.is_movable(line.joints):
        return line
    gravest, found = find_worst(asked), list(propose(line, asked, holds))
    planes = (describe_plane(line.moves, line.joints.machine, item, line.number) for item in asked)
    if found and (plane := next(filter(None, planes), "")):
        found.insert(0, f"{NOT_TRIED}{plane}")
    told = (
        dataclasses.replace(one, remedies=tuple(found)) if is_about_pose(one.code) and one.severity == gravest else one
        for one in line.findings
    )
    return replace(line, findings=tuple(told))


def _describe_remedies(line: Line, findings: Sequence[Finding]) -> Iterator[str]:
    """What would bring the line within limits, in numbers; every proposal has been checked along the whole line."""
    remedied = [item for item in findings if not is_about_pose(item.code)]
    for item in {item.code: item for item in remedied}.values():
        if remedy := describe_remedy(item, line.options.source_name, find_run(line.options)):
            yield f"{item.code}, remedy: {remedy}"
    findings = [item for item in findings if is_about_pose(item.code)]  # those about the text have no numbers
    if not findings:
        return
    gravest = find_worst(findings)
    found = list(dict.fromkeys(text for item in findings for text in item.remedies))
    if not found and not remedies.is_movable(line.joints):
        machine = line.joints.machine
        planes = (describe_plane(line.moves, machine, item, line.number) for item in findings)
        causes = (*planes, *(_describe_kept_angle(line, item) for item in findings))
        yield next(filter(None, causes), "") or "the line is no motion of the part alone: nothing is proposed"
        return
    what = "what would bring the line within limits" if gravest == "error" else "what would remove the warnings"
    if not found:
        if all(item.code == "VP301" for item in findings):  # its message has what helps
            return
        yield f"{what}: {_say_nothing_found(line, [item for item in findings if item.severity == gravest])}"
        return
    yield f"{what}:" if found[0].startswith(NOT_TRIED) else f"{what}; each was checked along the whole line"
    yield from (f"  {text}" for text in found)


def _say_nothing_found(line: Line, asked: Sequence[Finding]) -> str:
    """What was tried in vain, and what was not: no more than :func:`propose` and its like have tried."""
    machine, options = line.joints.machine, line.options
    carried = [item for item in asked if is_carried_along(options, item, line.frame.system)]
    rotary = all(item.code in remedies.ROTARY_CODES for item in asked)
    in_machine, tried, left = bool(line.moves.find_in_machine()[line.move]), [], []
    if len(carried) < len(asked) and any(item.severity == "error" for item in asked):
        tried.append(f"no other {name_solution(machine.coordinates)}")
    if not carried and not rotary and not in_machine:
        tried.append(f"no move within {remedies.FARTHEST_MM:g} mm")
    if carried and remedies.is_straight(line.exact):
        tried.append("no other end of the line")
    left += _say_where_reach_ends(line, asked)
    left += dict.fromkeys(filter(None, (_describe_kept_angle(line, one) for one in asked)))
    if rotary and machine.module is not None and not in_machine and any(item.code == "VP102" for item in asked):
        fit = f"`{find_run(options).spell('fit', options.source_name)}`"
        left.append(f"the part was not moved, which changes the tilt of the platform: {fit} does")
    if any(item.code == "VP216" for item in carried) and is_of_cycle(line):
        left.append(
            f"higher values of {line.tried_heights} were tried too"
            if line.tried_heights
            else f"retraction and clearance of the cycle that line {line.number} executes were not tried"
        )
    return "; ".join([f"{' and '.join(tried) or 'nothing'} was found", *left])


def _describe_kept_angle(line: Line, item: Finding) -> str:
    at_start = remedies.is_beyond_at_start(line.exact, item)
    return describe_kept_angle(line.moves, line.joints.machine, item, line.number, at_start=at_start)


def _say_where_reach_ends(line: Line, asked: Sequence[Finding]) -> list[str]:
    """The place of a straight line from which on the machine does not reach it (VP110)."""
    item = next((item for item in asked if item.code == "VP110"), None)
    place = None if item is None else remedies.place_of(line.joints, item)
    if place is None or len(line.joints.contour) != 1 or not remedies.is_straight(line.exact):
        return []
    words, scale = find_words(line, w=place.w), line.unit[1]
    if place.w <= 0.0:
        return ["its start is out of reach"]
    there = " ".join(f"{letter}{format_number(float(words[AXES.index(letter)]) / scale, 3)}" for letter in "XYZ")
    return [f"the machine reaches the line up to about {there}, {100 * place.w:.4g} % of the way"]


def _name_own_solution(line: Line, angles: Array) -> str:
    """The table solution in use: the programmed one, or what was chosen in its place."""
    if line.move < 0:
        return "as driven"
    wanted = line.joints.machine.coordinates.map_to_table(line.moves.end[line.move], line.frame)[1]
    return "as programmed" if np.abs(wanted - angles).max() <= SAME else "as driven"
