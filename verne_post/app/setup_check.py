"""What set-up and program leave open although the program uses it: warnings before anything else is looked at."""

from collections.abc import Iterator

import numpy as np

from verne_post.app.spindle_check import check_speed, check_spindle, check_tool_change
from verne_post.base.columns import iterate_blocks
from verne_post.base.tolerances import ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.base.units import DEG_PER_RAD
from verne_post.gcode.missing_setup import report_missing_offset
from verne_post.model.findings import Finding, InputError, make_finding
from verne_post.model.machine import Machine
from verne_post.model.moves import AXES, FeedMode, MoveKind, Moves, PathMode, find_tool_of_moves, name_tools
from verne_post.model.options import Options, spell_flag
from verne_post.model.part_setup import SYSTEM_NAMES, Box, describe_tool_number
from verne_post.model.plausibility import PLAUSIBLE, compare_largest
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.model.verdict import find_worst
from verne_post.model.work_systems import find_placer


def check_setup(moves: Moves, path: ToolPath, machine: Machine, options: Options) -> list[Finding]:
    """Report work systems without a place, tools without a length, directions without a meaning, and odd sizes.

    The codes are VP033, VP034 (in feed motion: no length, or that of another tool), VP037, VP040, VP041, VP050 and
    VP505.

    Raises
    ------
    InputError
        VP033: the set-up marks the place of a work system that is used as still to be measured.
    """
    systems: dict[int, int] = {}  # index of a frame -> first move that uses it
    bare = -1
    for begin, end in iterate_blocks(len(path)):
        move = path.move[begin:end]
        used, first = np.unique(moves.frame[move[move >= 0]], return_index=True)
        for frame, at in zip(used.tolist(), move[move >= 0][first].tolist(), strict=True):
            systems.setdefault(frame, at)
        cutting = np.flatnonzero(
            (path.tool_length[begin:end] == 0.0) & (path.feed_time[begin:end] > 0) & (move >= moves.first_cut)
        )
        if bare < 0 and len(cutting):
            bare = int(move[cutting[0]])
    unplaced: dict[int, int] = {}  # system -> first move that uses it
    for index, at in sorted(systems.items(), key=lambda item: item[1]):
        frame = moves.frames[index]
        if find_placer(frame, machine, options, moves.placed_systems) == "nobody":
            unplaced.setdefault(frame.system, at)
    found = [
        report_missing_offset(
            system, int(moves.line[at]), options.unmeasured_wcs.get(system, ""), calls_presets=moves.calls_presets
        )
        for system, at in unplaced.items()
    ]
    if find_worst(found) == "error":  # what follows would be about a part that is somewhere else
        raise InputError(*found)
    if options.tool_length is None:
        texts_by_move = [(bare, _describe_bare_tool(moves, bare, options))] if bare >= 0 else []
        for at, text in [*texts_by_move, *_find_mistaken_lengths(moves, path, options)]:
            line = int(moves.line[at])
            found.append(make_finding("VP034", text, line=line, last_line=line, worst_line=line))
    texts = _find_implausible(options)
    found += [*_check_tolerances(moves, path), *_find_idle_tolerances(moves, path, options)]
    found += [*_check_directions(moves, path, machine), *check_spindle(moves, path)]
    found += [*check_speed(moves, path), *check_tool_change(moves, path)]
    return [*(make_finding("VP505", text) for text in texts), *found]


def _check_tolerances(moves: Moves, path: ToolPath) -> Iterator[Finding]:
    """VP505: cuts with a programmed corner tolerance that is larger than any machine tool has."""
    for number, control in enumerate(moves.controls):
        for value, name in ((control.tolerance, "tip"), (control.axis_deg, "axis")):
            plausible = PLAUSIBLE[f"{name} tolerance"]
            if value is None or value <= plausible.high or control.mode != PathMode.BLEND:
                continue
            for begin, end in iterate_blocks(len(path)):
                move = path.move[begin:end]
                cut = move[(path.feed_time[begin:end] > 0) & (move >= 0)]
                cut = cut[moves.control[cut] == number]
                if len(cut):
                    line = int(moves.line[cut[0]])
                    text = (
                        f"corners may be off by {value:g} {plausible.unit} here, because the program says so: no "
                        f"{plausible.whose} has a tolerance of the {name} above {plausible.high:g} {plausible.unit}"
                    )
                    yield make_finding("VP505", text, line=line, last_line=line, worst_line=line)
                    break


def _find_idle_tolerances(moves: Moves, path: ToolPath, options: Options) -> Iterator[Finding]:
    """VP040: tolerances of the options that no corner takes. Whoever compares several would compare equal results."""
    given = [
        (name, value, what)
        for name, value, what in (
            ("tolerance", options.tolerance, "mm"),
            ("orientation_tolerance_deg", options.orientation_tolerance_deg, "deg"),
        )
        if value is not None
    ]
    if not given:
        return
    first: dict[int, int] = {}  # path control -> its first move
    for begin, end in iterate_blocks(len(path)):
        move = path.move[begin:end]
        used, at = np.unique(moves.control[move[move >= 0]], return_index=True)
        for number, place in zip(used.tolist(), at.tolist(), strict=True):
            first.setdefault(number, int(move[move >= 0][place]))
    # G64 P0 asks for the exact path
    rounding = [
        (at, control)
        for number, at in first.items()
        for control in [moves.controls[number]]
        if control.mode == PathMode.BLEND and control.tolerance != 0.0
    ]
    for name, value, unit in given:
        chosen = [control.tolerance if unit == "mm" else control.axis_deg for _at, control in rounding]
        own = sorted({one for one in chosen if one is not None})
        line: int | None = None
        if options.smoothing == "off":
            why = "with --smoothing off the tool stops at each corner"
        elif not rounding:
            why = "the program stops at each corner: it has no G64, nor what means the same in its language"
        elif None in chosen:
            continue
        else:
            line = int(moves.line[rounding[0][0]])
            size = f"{own[0]:g}" if len(own) == 1 else f"{own[0]:g} to {own[-1]:g}"
            why = f"the program gives its own where it rounds corners, {size} {unit}"
        text = f"{spell_flag(name)} {value:g} has no effect: {why}"
        yield make_finding("VP040", text, line=line, last_line=line, worst_line=line)


def _describe_bare_tool(moves: Moves, move: int, options: Options) -> str:
    """Why a move cuts with a tool of length 0, and what to do if that is not meant."""
    loaded = [event for event in moves.events if event.kind == "tool" and event.before <= move]
    number = int(str(loaded[-1].data["number"])) if loaded else 0
    if number in (options.tools or {}) and (options.tools or {})[number].ends_at_gauge_line:
        name = describe_tool_number(number, name_tools(loaded))
        return (
            f"{name} has the length 0 in the tool table: its tip is the gauge line of the spindle; if that is not "
            "meant, write its length there"
        )
    return (
        "the tool has no length: its tip is the gauge line of the spindle; activate its length before (G43, TOOL "
        "CALL), or give --tool-length"
    )


def _find_mistaken_lengths(moves: Moves, path: ToolPath, options: Options) -> Iterator[tuple[int, str]]:
    """First cuts of tools with the length of a tool that was in the spindle before, and what to do about each.

    A length that no tool before has may be meant: a second offset of the same tool, or wear.
    """
    lengths = {number: tool.offset[2] for number, tool in (options.tools or {}).items() if not tool.unmeasured}
    if len(lengths) < 2:
        return
    first: dict[tuple[int, float], int] = {}  # (tool, length in force) -> first move that cuts so
    for begin, end in iterate_blocks(len(path)):
        cuts = (path.feed_time[begin:end] > 0) & (path.move[begin:end] >= 0)
        move, length = path.move[begin:end][cuts], path.tool_length[begin:end][cuts]
        number = find_tool_of_moves(move, 0, moves)
        pairs, at = np.unique(np.stack([number, length]), axis=1, return_index=True)
        for (tool, value), index in zip(pairs.T.tolist(), at.tolist(), strict=True):
            first.setdefault((int(tool), value), int(move[index]))
    names = name_tools(moves.events)
    named = [item.line for item in moves.findings if item.code == "VP049" and item.line is not None]
    for (tool, value), begin in sorted(first.items(), key=lambda item: item[1]):
        change = max((one.line for one in moves.events if one.kind == "tool" and one.before <= begin), default=0)
        if any(change <= line <= moves.line[begin] for line in named):
            continue  # an H of another tool since then has its own warning
        before = [one for (one, _length), other in first.items() if other < begin and one != tool]
        owner = next((one for one in before if lengths.get(one) == value), None)
        if value and owner is not None and lengths.get(tool, value) != value:
            mine, other = (describe_tool_number(one, names) for one in (tool, owner))
            text = (
                f"{mine} cuts with a length of {value:g} mm, which is that of {other}; its own is {lengths[tool]:g} "
                f"mm: activate it before (G43 H, D1), or the tip is {abs(value - lengths[tool]):g} mm off"
            )
            yield begin, text


def _find_implausible(options: Options) -> Iterator[str]:
    """Sizes of the set-up that are legal but cannot be meant; keys as the set-up and the Python API have them."""
    for key, value, name in (
        ("cycle", options.cycle, "cycle"),
        ("tolerance", options.tolerance, "tip tolerance"),
        ("orientation_tolerance_deg", options.orientation_tolerance_deg, "axis tolerance"),
        ("tool_length", options.tool_length, "tool length"),
    ):
        yield from compare_largest(key, () if value is None else (value,), name, "")
    if options.tool_length is None:
        for number, tool in (options.tools or {}).items():
            yield from compare_largest(f"tool {number}", tool.offset[2:3], "tool length", "a length of ")
    for system, offset in options.wcs.items():
        yield from compare_largest(f"wcs {SYSTEM_NAMES[system]}", offset.origin_mm, "work offset")
    for box in (*options.keep_out, options.stock):
        if isinstance(box, Box):
            yield from compare_largest(box.name, np.subtract(box.high, box.low).tolist(), "box", "a size of ")


def _check_directions(moves: Moves, path: ToolPath, machine: Machine) -> list[Finding]:
    """VP037: cuts under a table that stands turned, where no code in force says in which directions X Y Z count.

    On a control of RS274/NGC the kinematics hold the tip, and no code asks for it. So a program that turns the table
    while the tip cuts has no other reading there; for a Fanuc control it lacks G43.4.
    """
    if moves.tcp_changes == (0,):
        return []
    first, is_turning, (tilt, turn) = -1, False, machine.coordinates.rotary
    for begin, end in iterate_blocks(len(path)):
        start, finish, move = path.start[begin:end], path.end[begin:end], path.move[begin:end]
        travel = np.linalg.norm(finish[:, :3] - start[:, :3], axis=1)
        # arcs and splines have a length also where they end where they begin
        cuts = (
            (path.feed_time[begin:end] > 0)
            & (move >= 0)
            & ~moves.find_said_tcp(move)
            & (moves.kind[move] != MoveKind.TURN)  # the axes of the machine go there, as on a control
            & ((travel > ZERO_LENGTH_MM) | (path.kind[begin:end] != SegmentKind.LINE))
        )
        turns = (np.abs(finish[:, 3:] - start[:, 3:]) > ZERO_ANGLE).any(axis=1)
        if (cuts & turns).any() and not moves.needs_tcp_code:
            return []
        tilted = np.abs(np.sin(finish[:, 3] - machine.coordinates.home_tilt)) > ZERO_ANGLE
        # under a vertical tool C matters where the tip is off the centre of the table
        turned = np.abs(np.remainder(moves.end[move, turn] + 180.0, 360.0) - 180.0) > ZERO_ANGLE * DEG_PER_RAD
        away = np.maximum(np.hypot(*start[:, :2].T), np.hypot(*finish[:, :2].T)) > ZERO_LENGTH_MM
        tilts = np.abs(finish[:, 3] - start[:, 3]) > ZERO_ANGLE
        at = np.flatnonzero(cuts & (tilted | tilts | ((turned | turns) & away)))
        if first < 0 and len(at):
            first, is_turning = int(move[at[0]]), at[0] in np.flatnonzero(turns)
    if first < 0:
        return []
    line, (a, c) = int(moves.line[first]), moves.end[first, [tilt, turn]] + 0.0  # no -0
    by_time = is_turning and moves.feed_mode[first] == FeedMode.INVERSE
    text = (
        f"X Y Z cut while the table {'turns to' if is_turning else 'is at'} {AXES[tilt]}{a:.6g} {AXES[turn]}{c:.6g}, "
        "and no code asks for tool-centre-point control: they are read as places of the part, but a control would "
        "read them in the machine's directions; write G43.4 instead of G43 if the part is meant"
        f"{'; if the post has computed them for the machine (as many do with G93), post again' if by_time else ''}"
    )
    return [make_finding("VP037", text, line=line, last_line=line, worst_line=line)]
