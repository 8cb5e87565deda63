"""What set-up and program leave open although the program uses it: warnings before anything else is looked at."""

import dataclasses
import math
from collections.abc import Iterable, Iterator
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.app.doubts.arcs import check_arcs, drop_helices
from verne_post.app.doubts.axes import check_axes, check_normals, check_rotary_words
from verne_post.app.doubts.block_ends import check_block_ends
from verne_post.app.doubts.diameters import check_diameters
from verne_post.app.doubts.heights import check_heights
from verne_post.app.doubts.hole_feeds import check_hole_feeds
from verne_post.app.doubts.lengths import check_lengths
from verne_post.app.doubts.pitches import check_pitches
from verne_post.app.doubts.points import check_points
from verne_post.app.doubts.program_end import find_unexecuted_moves
from verne_post.app.doubts.senses import check_senses
from verne_post.app.doubts.spindle import (
    check_direction,
    check_first_tool,
    check_highest_speed,
    check_kept_feed,
    check_kept_speed,
    check_speed,
    check_spindle,
    check_tool_change,
)
from verne_post.app.doubts.tolerances import check_tolerances
from verne_post.base.arrays import Ints, find_used
from verne_post.base.columns import iterate_blocks
from verne_post.base.long_text import Text
from verne_post.base.printable import make_printable
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import DRILL_TILT, LIMIT_SLACK_MM, ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.base.units import DEG_PER_RAD
from verne_post.gcode.machining.watcher import (
    find_plane_tilt,
    place_at_plane,
    report_kept_planes,
    report_left_planes,
    report_plane_at_end,
)
from verne_post.gcode.missing_setup import report_missing_offset
from verne_post.model.codes import IF_DIRECTIONS_ARE_MEANT
from verne_post.model.findings import Finding, InputError, Remedy, make_finding
from verne_post.model.machine import Machine
from verne_post.model.moves import (
    AXES,
    FeedMode,
    MoveKind,
    Moves,
    PathMode,
)
from verne_post.model.options import Options, spell_flag
from verne_post.model.part_setup import Box, describe_tool_number, list_setup_names, name_system
from verne_post.model.plausibility import PLAUSIBLE, compare_largest
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.model.verdict import find_worst
from verne_post.model.work_systems import find_placer
from verne_post.toolpath.table_turns import report_table_turns

#: A feed rate below it, mm/min, that other cuts of the program exceed so many times, mostly is in m/min: read so, it is
#: at most twice as fast as they are.
_SLOW_FEED: Final = 5.0
_TIMES_FASTER: Final = 500.0
#: What VP037 finds missing, but for a length that the control has cancelled.
_NO_TCP: Final = "no code turns on tool-centre-point control"


def check_setup(
    source: Text, moves: Moves, path: ToolPath, machine: Machine, options: Options, from_move: int = 0
) -> tuple[Finding, ...]:
    """Report work systems without a place, tools without a length, directions without a meaning, and odd sizes.

    With them come the warnings of the interpreter. ``from_move`` is the first move of a restart: sizes of moves before
    it are not judged.

    Raises
    ------
    InputError
        VP033: the set-up marks the place of a work system that is used as still to be measured, or gives others and not
        this one. VP034: a tool comes down with a length that is not the one that the set-up gives it. VP049: so
        does one with the length, or the diameter, of another tool of the program.
    """
    called = moves.called_lines
    try:
        found = [called.place(one) for one in _find_all(moves.count_own_lines(), path, machine, options, from_move)]
    except InputError as error:
        raise InputError(*(called.place(one) for one in error.findings)) from None
    found = [
        *_check_machine_of_setup(machine, options),
        *found,
        *check_normals(source, moves, machine.coordinates, from_move),
        *check_diameters(source, moves, options),
        *check_block_ends(source, options),
        *map(called.place, check_pitches(source, moves, options, from_move)),
        *check_rotary_words(source, moves, machine.coordinates, options, from_move),
        *check_points(source, moves, machine.coordinates, options, from_move),
        *check_tolerances(source, moves, path, from_move),
        *report_table_turns(path, moves, machine),
        *find_unexecuted_moves(source, moves),
        *drop_helices(moves, from_move),
    ]
    return tuple(place_at_plane(source, item) for item in found)


def _check_machine_of_setup(machine: Machine, options: Options) -> Iterator[Finding]:
    """Warn of a set-up that was written for another machine (VP505): places and lengths may count from other points."""
    if options.setup_machine not in ("", make_printable(machine.name)):
        yield make_finding(
            "VP505",
            f"the set-up was written for {options.setup_machine}, and the machine in use is {machine.name}; give "
            "--machine, as the remark in the set-up says",
            advice="If the set-up is right for this machine too, delete the remark.",
        )


def _find_all(moves: Moves, path: ToolPath, machine: Machine, options: Options, from_move: int) -> list[Finding]:
    """The same, of moves that have the lines of their own files."""
    systems: dict[int, int] = {}  # index of a frame -> first move that uses it
    cut_frames: set[int] = set()
    for begin, end in iterate_blocks(len(path)):
        move = path.move[begin:end]
        of_program = move[move >= 0]
        firsts = of_program[np.flatnonzero(np.diff(moves.frame[of_program], prepend=-1))]
        for frame, at in zip(moves.frame[firsts].tolist(), firsts.tolist(), strict=True):
            systems.setdefault(frame, at)
        cut_frames.update(find_used(moves.frame[move[(move >= 0) & (path.feed_time[begin:end] > 0)]]).tolist())
    unplaced: dict[int, int] = {}  # system -> first move that uses it
    cut_systems: set[int] = set()
    for index, at in sorted(systems.items(), key=lambda item: item[1]):
        frame = moves.frames[index]
        if find_placer(frame, machine, options, moves.placed_systems) == "nobody":
            unplaced.setdefault(frame.system, at)
            cut_systems |= {frame.system} if index in cut_frames else set()
    found = [
        report_missing_offset(
            moves,
            system,
            at,
            options.unmeasured_wcs.get(system, ""),
            machine.coordinates.zero_point,
            # a program that moves in rapids until it calls its first work system does not mean the one before
            options.wcs if system in cut_systems or system != moves.start_frame.system else (),
        )
        for system, at in unplaced.items()
    ]
    changes = check_tool_change(moves, path)
    if options.tool_length is None:
        found += check_lengths(moves, path, options, changes, machine.table_radius)
    called = moves.list_called_tools()  # as a diameter of wear nobody takes that of a tool which cuts too
    cutters = [item for item in moves.findings if item.quantity == "diameter" and item.tool in called]
    found += [dataclasses.replace(item, severity="error") for item in cutters]
    if find_worst(found) == "error":  # what follows would be about a part or a tip that is somewhere else
        raise InputError(*(item for item in found if item.severity == "error"))
    planes = [*_check_planes(moves, path, machine)]
    found = [
        *(make_finding("VP505", text) for text in _find_implausible(options)),
        *found,
        # twice in turn: the numbers of all cuts would need as much memory as a column
        *_check_feeds(moves, _iterate_cuts(path, from_move)),
        *_check_slow_feed(moves, _iterate_cuts(path, from_move)),
        *check_hole_feeds(moves, path, machine, from_move),
        *_find_idle_tolerances(moves, path, options),
        *_check_directions(moves, path, machine),
        *(planes or report_left_planes(moves, machine.coordinates)),
        *check_spindle(moves, path),
        *check_speed(moves, path),
        *check_highest_speed(moves, machine),
        *check_direction(moves, path),
        *check_kept_speed(moves, path),
        *check_kept_feed(moves, path),
        *(changes or check_first_tool(moves, path, options)),
        *report_kept_planes(moves, machine.coordinates),
        *_check_uncalled_tools(moves, options),
        *_check_uncalled_shapes(moves, options),
        *check_senses(moves, machine),
        *check_arcs(moves, from_move),
        *check_axes(moves, from_move),
        *check_heights(moves, from_move),
    ]
    return [*found, *report_plane_at_end(moves, found)]


def _check_feeds(moves: Moves, cuts: Iterable[Ints]) -> Iterator[Finding]:
    """VP505: the first cut at a feed rate, or a feed a turn, that is larger than any cut has; one finding a program.

    F that was meant as mm/min under G93 leads to such a rate where the move is long.
    """
    rate, turn = PLAUSIBLE["feed rate"], PLAUSIBLE["feed per turn"]
    for move in cuts:
        feed, mode = moves.feed[move], moves.feed_mode[move]
        per_turn = mode == FeedMode.PER_REVOLUTION
        inverse = (mode == FeedMode.INVERSE) & (moves.kind[move] == MoveKind.FEED)
        beyond = (((mode == FeedMode.PER_MINUTE) | inverse) & (feed > rate.high)) | (per_turn & (feed > turn.high))
        for at in np.flatnonzero(beyond)[:1].tolist():
            line, plausible = int(moves.line[move[at]]), turn if per_turn[at] else rate
            text = (
                f"{_name_feed(moves)} is {feed[at]:.10g} {plausible.unit} here: no {plausible.whose} has more than "
                f"{plausible.high:g} {plausible.unit}; "
            )
            right, edits = _propose_feed_a_minute(moves, int(move[at])) if per_turn[at] else ("", ())
            text += right or "is a decimal point missing?"
            if inverse[at]:
                seconds = float(moves.seconds[move[at]])
                text = (
                    f"F{60.0 / seconds:.6g} is a time in G93, {seconds:.3g} s for this move, which is {feed[at]:.6g} "
                    f"{rate.unit}: no {rate.whose} has more than {rate.high:g}; if mm/min were meant, write G94 before"
                )
                edits = (Remedy("write G94", "G94", line=line, way="before", is_choice=True),)
            # ten times as much is no cut at all: the machining time would be that of the machine's own limits
            severity = "error" if per_turn[at] and feed[at] >= 10.0 * turn.high else "warning"
            yield make_finding("VP505", text, severity=severity, edits=edits, line=line)
            return


def _name_feed(moves: Moves) -> str:
    """The word of the feed rate."""
    return "FEDRAT" if moves.language == "aptcl" else "F"


def _iterate_cuts(path: ToolPath, first: int) -> Iterator[Ints]:
    """Numbers of the moves from ``first`` on, block by block, that carry the tip at a feed rate."""
    for begin, end in iterate_blocks(len(path)):
        ways = measure_rows(path.end[begin:end, :3] - path.start[begin:end, :3])
        move = path.move[begin:end]
        yield move[(path.feed_time[begin:end] > 0) & (move >= max(first, 0)) & (ways > 0)]


def _check_slow_feed(moves: Moves, cuts: Iterable[Ints]) -> Iterator[Finding]:
    """VP505: the first cut at a feed rate that is mostly in m/min: others are so many times faster; or in mm a turn.

    A tool may plunge along Z as slowly as some m/min are read, and no cut is as slow as mm a turn.
    """
    first, first_below, fastest = -1, -1, 0.0
    plausible = PLAUSIBLE["feed rate"]
    for move in cuts:
        move = move[moves.feed_mode[move] == FeedMode.PER_MINUTE]
        beside = (moves.end[move, :2] != moves.end[np.maximum(move - 1, 0), :2]).any(axis=1)
        slow = move[beside & (moves.feed[move] < _SLOW_FEED)]
        first = int(slow[0]) if first < 0 and len(slow) else first
        below = move[moves.feed[move] < plausible.low]
        first_below = int(below[0]) if first_below < 0 and len(below) else first_below
        fastest = max(fastest, float(moves.feed[move].max(initial=0.0)))
    if first_below >= 0:
        line = int(moves.line[first_below])
        code = {"heidenhain": "M136", "aptcl": ""}.get(moves.language, "G95")
        text = (
            f"{_name_feed(moves)} is {moves.feed[first_below]:.10g} {plausible.unit} here: no {plausible.whose} has "
            f"less than {plausible.low:g} {plausible.unit}; if mm a turn were meant, "
            f"{f'write {code} before' if code else 'write MMPR in FEDRAT'}"
        )
        edits = (Remedy(f"write {code}", code, line=line, way="before", is_choice=True),) if code else ()
        yield make_finding("VP505", text, line=line, edits=edits)
        return
    if first < 0 or fastest < _TIMES_FASTER * moves.feed[first]:
        return
    line, feed = int(moves.line[first]), moves.feed[first]
    text = (
        f"{_name_feed(moves)} is {feed:.10g} mm/min here, and up to {fastest:.10g} mm/min in other cuts: "
        f"if it is in m/min, it must be {1e3 * feed:.10g} mm/min"
    )
    yield make_finding("VP505", text, line=line)


def _propose_feed_a_minute(moves: Moves, cut: int) -> tuple[str, tuple[Remedy, ...]]:
    """What to write where F a turn was meant as F a minute, also as edits: in place of G95, or before the cut."""
    code, line = {"heidenhain": "M137", "aptcl": ""}.get(moves.language, "G94"), int(moves.line[cut])
    if not code:
        return "if mm/min were meant, write MMPM in its FEDRAT", ()
    before = Remedy(f"write {code}", code, line=line, way="before", is_choice=True)
    active, first = next((one for one in reversed(moves.turn_feeds) if one[1] <= cut), (0, 0))
    if not active:
        return f"if mm/min were meant, write {code} before", (before,)
    word = ("M", 136.0) if code == "M137" else ("G", 95.0)
    instead = Remedy(f"write {code}", code[1:], line=active, word=word, is_choice=True)
    why = f"{word[0]}{word[1]:g} of line {active} is active: if mm/min were meant, write {code}"
    # a cut or a tapped hole that has taken F a turn already may be why it was written
    if np.any(np.isfinite(moves.feed[first:cut]) & (moves.kind[first:cut] != MoveKind.DWELL)):
        return f"{why} before this cut", (before, instead)
    return f"{why} in its place", (instead,)


def _find_idle_tolerances(moves: Moves, path: ToolPath, options: Options) -> Iterator[Finding]:
    """VP040: tolerances of the options that no corner takes, or only a part of the cuts.

    Whoever compares several would compare equal results.
    """
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
    first_cut: dict[int, int] = {}
    for begin, end in iterate_blocks(len(path)):
        move = path.move[begin:end]
        move = move[move >= 0]
        for into, among in ((first, move), (first_cut, move[np.isfinite(moves.feed[move])])):
            used, at = np.unique(moves.control[among], return_index=True)
            for number, place in zip(used.tolist(), at.tolist(), strict=True):
                into.setdefault(number, int(among[place]))
    # G64 P0 asks for the exact path
    rounding, cuts = (
        [
            (at, control)
            for number, at in found.items()
            for control in [moves.controls[number]]
            if control.mode == PathMode.BLEND and control.tolerance != 0.0
        ]
        for found in (first, first_cut)
    )
    for name, value, unit in given:
        # programs set theirs after the first rapids, which take that of the option
        chosen, chosen_by_cuts = (
            [(at, control.tolerance if unit == "mm" else control.axis_deg) for at, control in found]
            for found in (rounding, cuts)
        )
        own = sorted({one for _at, one in chosen if one is not None})
        line: int | None = None
        effect = "has no effect"
        if options.smoothing == "off":
            why = "with --smoothing off the tool stops at each corner"
        elif not rounding:
            why = "the program stops at each corner: it has no G64, nor what means the same in its language"
        elif not own:
            continue
        else:
            line = int(moves.line[min(at for at, one in chosen if one is not None)])
            size = f"{own[0]:g}" if len(own) == 1 else f"{own[0]:g} to {own[-1]:g}"
            why = f"the program gives its own where it rounds corners, {size} {unit}"
            if any(one is None for _at, one in chosen_by_cuts):
                effect = "has an effect on some cuts, and none on others"
            elif any(one is None for _at, one in chosen):
                effect = "has an effect on rapids, and none on cuts"
        text = f"{spell_flag(name)} {value:g} {effect}: {why}"
        yield make_finding("VP040", text, line=line)


def _check_uncalled_tools(moves: Moves, options: Options) -> Iterator[Finding]:
    """VP041: the set-up gives this program alone a tool that no line of it calls: a tool call may be missing."""
    if _may_call_others(options):
        return
    called = set(moves.list_called_tools()) | moves.read_tools
    keys = [tool.key for number, tool in (options.tools or {}).items() if tool.key and number not in called]
    if keys:
        it, them = ("it", "its call") if len(keys) == 1 else ("them", "their calls")
        text = f"{', '.join(keys)} of the set-up: no line of the program calls {it}; write {them}, or take {it} out"
        yield make_finding("VP041", text, advice="")


def _check_uncalled_shapes(moves: Moves, options: Options) -> Iterator[Finding]:
    """VP018: of the tools that the program calls none has a shape, and others have: it may have the number of another.

    A file of shapes may serve many programs: where one shape is used, the others mean nothing.
    """
    called, shapes = [number for number in moves.list_called_tools() if number], options.tool_shapes
    is_used = bool(options.keep_out) or options.stock is not None
    if not (is_used and called and shapes and shapes.keys().isdisjoint(called)) or _may_call_others(options):
        return
    names = moves.name_tools()
    cutters = ", ".join(describe_tool_number(number, names) for number in called)
    it, have = "it" if len(shapes) == 1 else "a tool of them", "has" if len(called) == 1 else "have"
    text = (
        f"tool.{next(iter(shapes))} of the tool shapes: no line calls {it}, and {cutters} of the program {have} no "
        "shape: shank and holder are not checked"
    )
    meant = f"; did you mean tool.{called[0]}?" if len(shapes) == len(called) == 1 else ""
    advice = "Write the number of the tool that the program calls into the file of tool shapes."
    yield make_finding("VP018", text + meant, severity="warning", advice=advice)


def _may_call_others(options: Options) -> bool:
    """Whether a line before or a block that is skipped may call a tool."""
    return options.from_line is not None or bool(options.block_delete)


def _find_implausible(options: Options) -> Iterator[str]:
    """Sizes of the set-up that are accepted but cannot be meant; keys as the set-up and the Python API have them."""
    for key, value, name in (
        ("cycle", options.cycle, "cycle"),
        ("tolerance", options.tolerance, "tip tolerance"),
        ("orientation_tolerance_deg", options.orientation_tolerance_deg, "axis tolerance"),
        ("tool_length", options.tool_length, "tool length"),
    ):
        yield from compare_largest(key, () if value is None else (value,), name, "")
    if options.tool_length is None:
        names = list_setup_names(options.control)
        for number, tool in (options.tools or {}).items():
            yield from compare_largest(
                describe_tool_number(number, names), tool.offset[2:3], "tool length", "a length of "
            )
    for system, offset in options.wcs.items():
        yield from compare_largest(f"wcs {name_system(system)}", offset.origin_mm, "work offset")
    for box in (*options.keep_out, options.stock):
        if isinstance(box, Box):
            yield from compare_largest(box.name, np.subtract(box.high, box.low).tolist(), "box", "a size of ")


def is_retracted(moves: Moves, machine: Machine, last: int) -> bool:
    """Whether the last move is a rapid that ends higher along the tool axis than any feed move since the tilt.

    A place of the machine, as of G53, counts by its height too. Without a tool length it is the gauge line that is
    known, so that both must be higher.
    """
    coordinates = machine.coordinates
    is_motion, is_rapid = moves.kind != MoveKind.DWELL, np.isnan(moves.feed)
    done = np.flatnonzero(is_motion[: last + 1])
    if not len(done):
        return True
    if not is_rapid[done[-1]]:
        return False
    rotary = list(coordinates.rotary)
    turned = np.abs(np.diff(moves.end[done][:, rotary], axis=0, prepend=moves.start[None, rotary])) > ZERO_ANGLE
    tilts = done[is_rapid[done] & turned.any(axis=1)]
    ends = done[(~is_rapid[done] & (done >= (tilts[-1] if len(tilts) else 0))) | (done == done[-1])]
    tips, gauges = np.empty(len(ends)), np.empty(len(ends))
    axis = None
    for index in dict.fromkeys(moves.frame[ends[::-1]].tolist()):  # that of the last move first
        frame, own = moves.frames[index], moves.frame[ends] == index
        tip, angles = coordinates.map_to_table(moves.end[ends[own]], frame)
        axis = find_axis_of_angles(*angles[-1]) if axis is None else axis
        tips[own] = tip @ axis
        gauges[own] = tips[own] + frame.tool_length
    return all(bool((one[:-1] < one[-1] - LIMIT_SLACK_MM).all()) for one in (tips, gauges))


def _check_directions(moves: Moves, path: ToolPath, machine: Machine) -> list[Finding]:
    """VP037: moves under a table that stands turned, where no code in force says in which directions X Y Z count.

    On a control of RS274/NGC the kinematics hold the tip, and no code asks for it. So a program that turns the table
    while the tip cuts has no other reading there; for a Fanuc control it lacks G43.4. A Siemens control has another
    reading: its own directions, while the table stands as TRAORI or CYCLE800 has left it. Rapids count for Fanuc alone,
    behind a code that has ended, and where the table stays turned: those before the first one only lead to it.
    """
    if moves.tcp_changes == (0,):
        return []
    first, rapid, is_turning, (tilt, turn) = -1, -1, False, machine.coordinates.rotary
    named_move, in_machine = _find_naming_move(moves), moves.find_in_machine()
    for begin, end in iterate_blocks(len(path)):
        start, finish, move = path.start[begin:end], path.end[begin:end], path.move[begin:end]
        travel = np.linalg.norm(finish[:, :3] - start[:, :3], axis=1)
        # arcs and splines have a length also where they end where they begin
        goes = (
            (move >= 0)
            & ~moves.find_said_tcp(move)
            & (move >= named_move)
            & (moves.kind[move] != MoveKind.TURN)  # the axes of the machine go there, as on a control
            & ((travel > ZERO_LENGTH_MM) | (path.kind[begin:end] != SegmentKind.LINE))
        )
        cuts = goes & (path.feed_time[begin:end] > 0)
        turns = (np.abs(finish[:, 3:] - start[:, 3:]) > ZERO_ANGLE).any(axis=1)
        if (cuts & turns).any() and not moves.needs_tcp_code:
            return []
        tilted = np.abs(np.sin(finish[:, 3] - machine.coordinates.home_tilt)) > ZERO_ANGLE
        # under a vertical tool C matters where the tip is off the centre of the table
        turned = np.abs(np.remainder(moves.end[move, turn] + 180.0, 360.0) - 180.0) > ZERO_ANGLE * DEG_PER_RAD
        away = np.maximum(np.hypot(*start[:, :2].T), np.hypot(*finish[:, :2].T)) > ZERO_LENGTH_MM
        tilts = np.abs(finish[:, 3] - start[:, 3]) > ZERO_ANGLE
        differs = goes & (tilted | tilts | ((turned | turns) & away))
        at = np.flatnonzero(differs & cuts)
        if first < 0 and len(at):
            first, is_turning = int(move[at[0]]), at[0] in np.flatnonzero(turns)
        if rapid < 0 and moves.needs_tcp_code:
            ended = move >= (moves.tcp_changes[0] if moves.tcp_changes else len(moves))
            stays = goes & (tilted | (turned & away))  # one that turns back ends where a control does
            at = np.flatnonzero(stays & ended & (moves.kind[move] == MoveKind.RAPID) & ~in_machine[move])
            rapid = int(move[at[0]]) if len(at) else -1
    if first < 0 and rapid >= 0:
        return [_report_rapid(moves, rapid, machine)]
    if first < 0:
        return []
    line, (a, c) = int(moves.line[first]), moves.end[first, [tilt, turn]] + 0.0  # no -0
    left = next((one for one in reversed(moves.tcp_ends) if one.before <= first), None)
    if left is not None and left.word != "G49":  # after which nothing says how they count
        letters = " and ".join(AXES[axis] for axis in (tilt, turn))
        is_out = is_retracted(moves, machine, left.before - 1)
        text = (
            f"X Y Z cut in the machine's directions with the {machine.rotary_side} at {AXES[tilt]}{a:.6g} "
            f"{AXES[turn]}{c:.6g}, where {left.word} in line {left.line} has left it; "
            f"{'' if is_out else 'retract the tool, and '}name {letters} before the cut: "
            f"{AXES[tilt]}0 {AXES[turn]}0 if the tool is to be upright"
        )
        level = Remedy(f"name {letters}", f"G0 {AXES[tilt]}0 {AXES[turn]}0", line=left.line, way="below", turns=True)
        edits = (level,) if is_out and moves.kind[left.before] == MoveKind.RAPID else ()  # a cut may rely on its G1
        return [make_finding("VP037", text, line=line, edits=edits, advice="")]
    lack = _name_lack(moves, first)
    by_time = is_turning and moves.feed_mode[first] == FeedMode.INVERSE
    kept = "on LinuxCNC, change nothing if its kinematics keep the tip (ignore VP037 then); otherwise "
    kept = "" if moves.needs_tcp_code else kept
    text = (
        f"X Y Z cut {'in a turn of' if is_turning else 'with'} the {machine.rotary_side} "
        f"{'to' if is_turning else 'at'} {AXES[tilt]}{a:.6g} "
        f"{AXES[turn]}{c:.6g}, and {lack}: they are read as points of the part, "
        "but a control would "
        f"read them in the machine's directions; {kept}write G43.4 before the cut, in place of any G43, if the part is "
        "meant"
        f"{'; if the post has computed them for the machine (as many do with G93), post again' if by_time else ''}"
    )
    instead = Remedy("write G43.4 instead of G43", "43.4", line=line, word=("G", 43.0), is_above=True, is_choice=True)
    shown = (instead,) if lack == _NO_TCP else ()
    return [make_finding("VP037", text, line=line, edits=shown, advice=IF_DIRECTIONS_ARE_MEANT)]


def _name_lack(moves: Moves, at: int) -> str:
    """Why no code says, at a move, in which directions X Y Z count."""
    is_cancelled = bool(moves.find_cancelled_length(np.array(at)))
    return "G53, G28 or G30 has cancelled the tool length" if is_cancelled else _NO_TCP


def _report_rapid(moves: Moves, at: int, machine: Machine) -> Finding:
    """VP037 of a rapid."""
    line, rotary, lack = int(moves.line[at]), machine.coordinates.rotary, _name_lack(moves, at)
    place = " ".join(f"{AXES[axis]}{moves.end[at, axis] + 0.0:.6g}" for axis in rotary)
    turn = f"turn {AXES[rotary[0]]} and {AXES[rotary[1]]} before"
    text = f"X Y Z go in rapid traverse with the {machine.rotary_side} at {place}, and {lack}: they are read as points "
    if lack == _NO_TCP:
        text += (
            "of the part, but a control would move the axes of the machine to them, so that after a turn of the "
            f"{machine.rotary_side} X Y Z that are not named again differ too; retract with G53, or {turn}"
        )
    else:
        text += (
            "of the part, by the length that has been cancelled, and the axes that are not named move too, but a "
            "control would move the named axes of the machine alone; write the next G43.4 H before, in the block that "
            f"names X Y Z, or {turn}"
        )
    return make_finding("VP037", text, line=line, advice=IF_DIRECTIONS_ARE_MEANT)


def _check_planes(moves: Moves, path: ToolPath, machine: Machine) -> Iterator[Finding]:
    """VP042: cuts in a tilted plane to which nothing has turned the table, each plane once.

    Under a plane in which the tool is tilted anywhere, the program knows what it does: G53.1, A and C words, G43.4.
    Posts may move a retracted head at feed rate before the table turns, so that holds for the whole plane.
    """
    normals = np.array([find_plane_tilt(frame) for frame in moves.frames])
    if not (moves.needs_tcp_code or moves.planes) or (normals >= 1.0 - DRILL_TILT).all():
        return
    runs: list[_Plane] = []
    for begin, end in iterate_blocks(len(path)):
        rows = begin + np.flatnonzero(path.move[begin:end] >= 0)
        move = path.move[rows]
        tools = [find_axis_of_angles(place[rows, 3], place[rows, 4])[:, 2] for place in (path.start, path.end)]
        is_upright = np.minimum(*tools) >= 1.0 - DRILL_TILT
        cuts = path.feed_time[rows] > 0
        normal = normals[moves.frame[move]]
        firsts = np.flatnonzero(np.append(True, np.diff(normal) != 0)) if len(rows) else np.empty(0, int)
        for first, last in zip(firsts.tolist(), [*firsts.tolist()[1:], len(rows)], strict=True):
            if not runs or runs[-1].normal != normal[first]:
                runs.append(_Plane(float(normal[first])))
            run, cut = runs[-1], np.flatnonzero(cuts[first:last])
            run.is_upright &= bool(is_upright[first:last].all())
            if len(cut) and run.cut < 0:
                run.cut = int(move[first + cut[0]])
    for run in runs:
        if run.cut >= 0 and run.is_upright and run.normal < 1.0 - DRILL_TILT:
            line, angle = int(moves.line[run.cut]), math.degrees(math.acos(run.normal))
            axes = " and ".join(AXES[axis] for axis in machine.coordinates.rotary)
            call = next((one for one in reversed(moves.planes) if one.before <= run.cut), None)
            turn = call.turn if call is not None and call.turn else f"turn {axes} to it"
            text = (
                f"the tool cuts upright in a plane that is tilted by {angle:.6g} deg: nothing turns the "
                f"{machine.rotary_side} to it; {turn}"
            )
            edits = (Remedy("write G53.1", "G53.1", line=line, word=("G", 68.2), way="below", is_above=True),)
            yield make_finding("VP042", text, line=line, edits=edits)


def _find_naming_move(moves: Moves) -> int:
    """The first move that names A or C where cuts before it have that angle, as VP036 says; else 0."""
    if not moves.assumed_axes:
        return 0
    at = np.flatnonzero(moves.line == min(moves.assumed_axes.values()))
    return int(at[0]) if len(at) else 0


class _Plane(Struct):
    """Moves in a row whose X Y Z are those of one plane."""

    normal: float  #: Its Z along the Z of the table.
    cut: int = -1  #: The first move at feed rate.
    is_upright: bool = True  #: The tool, in all of them.
