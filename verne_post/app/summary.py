"""The facts of a conversion, collected from its plan."""

from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct, structs

from verne_post.app.assemble import Program, build_interpreter_setup, choose_shaper
from verne_post.app.plan import Plan
from verne_post.base.arrays import Ints, find_used
from verne_post.base.columns import iterate_blocks
from verne_post.base.long_text import Text
from verne_post.gcode.dialects import choose_dialect_name, find_dialect_name
from verne_post.model.contour import Contour
from verne_post.model.moves import Event, find_tool_of_moves
from verne_post.model.part_setup import choose_number_or_name
from verne_post.model.protocols import AxisCorrecting
from verne_post.model.setpoints import SetpointFormat
from verne_post.model.summary import Part, StopsWithin, Summary
from verne_post.model.verification import NO_LIMIT_NEAR, Verification
from verne_post.model.vibration import Shaped
from verne_post.output.rounding import round_setpoints
from verne_post.output.summary import format_summary, format_verdict
from verne_post.trajectory.shaper import predict_vibration

if TYPE_CHECKING:
    from verne_post.part.verdict import Machined


def list_events_of_parts(program: Program) -> tuple[tuple[Event, ...], ...]:
    """What happens before the first part, and after each.

    That is what stands between the last motion before a stop and the first motion after it. Of several stops there, a
    dwell stands between two: what comes before it belongs to the first one.
    """
    moves, kept, stops = program.moves, program.path.moves_with_length, program.stops
    timed = find_used(np.concatenate([kept, moves.dwells]))
    timed = timed[~np.isin(timed, stops)]
    before = [event.before for event in moves.events]
    gap, place = np.searchsorted(kept, before), np.searchsorted(timed, before)
    # a part ends in its gap and place; the last one ends after the last motion
    gaps = np.append(np.searchsorted(kept, stops), len(kept))
    places = np.append(np.searchsorted(timed, stops), len(timed))
    owner = np.searchsorted(places, place)
    owner -= (gaps[owner] != gap) & (owner > 0)  # after the last stop of the gap
    listed: list[list[Event]] = [[] for _ in range(len(gaps) + 1)]
    for event, here, there, number in zip(moves.events, gap.tolist(), place.tolist(), owner.tolist(), strict=True):
        if there and gaps[number] == here:
            listed[number + 1].append(event)
        elif not here:
            listed[0].append(event)
    return tuple(tuple(events) for events in listed)


def _list_parts(plan: Plan) -> tuple[tuple[Event, ...], tuple[Part, ...]]:
    """What happens before the first motion; and the rows between stops, with what happens after them."""
    times, items = plan.timeline, _find_stop_items(plan)
    begins = [0, *times.first_row[items + 1].tolist()]
    ends = [*times.first_row[items].tolist(), times.n_rows - 1]
    before, *then = list_events_of_parts(plan.program)
    return before, tuple(Part(*one) for one in zip(begins, ends, then, strict=True))


def _summarise_shaper(plan: Plan) -> Shaped | None:
    """What the input shaper does; None without one."""
    machine, times = plan.program.machine, plan.timeline
    shaper = choose_shaper(machine, plan.program.options)
    if shaper is None or machine.vibration is None:
        return None
    left = [(mode.frequency, predict_vibration(times.weights, mode, times.cycle)) for mode in machine.vibration.modes]
    return Shaped(shaper, times.rest * times.cycle, tuple(left))


def _name_shaper(verdict: Verification | None) -> Verification | None:
    """Where no limit of a joint is near, the shaper is what takes the time."""
    if verdict is None:
        return None
    slow = {"input shaper" if reason == NO_LIMIT_NEAR else reason: seconds for reason, seconds in verdict.slow.items()}
    latest = verdict.latest_block
    if latest is not None and latest.reason == NO_LIMIT_NEAR:
        latest = structs.replace(latest, reason="input shaper")
    return replace(verdict, slow=slow, latest_block=latest)


def _count_stops_within(contour: Contour) -> StopsWithin:
    """Stops between two motions of one line of the program, without a dwell there."""
    counts: Counter[int] = Counter()
    for begin, end in iterate_blocks(len(contour), 1):
        element = np.arange(begin - 1, end)
        line, section = contour.find_lines(element), contour.section[element]
        inside = (line[1:] == line[:-1]) & (line[1:] > 0) & (section[1:] != section[:-1])
        inside &= ~np.isin(section[1:], contour.dwell_section)
        lines, numbers = np.unique(line[1:][inside], return_counts=True)
        counts.update(dict(zip(lines.tolist(), numbers.tolist(), strict=True)))
    worst, most = max(counts.items(), key=lambda item: item[1], default=(0, 0))
    return StopsWithin(sum(counts.values()), worst, most)


def _measure_rests(plan: Plan) -> tuple[float, float]:
    """Seconds of dwells, and of all other rests: stops of the program, and what a shaper rests at each motion."""
    times = plan.timeline
    cycles = np.diff(times.first_row)
    at_stops = cycles[_find_stop_items(plan)].sum()
    dwells = cycles[times.section < 0].sum() - at_stops
    shaper = 2 * times.rest * int((times.section >= 0).sum())
    return float(dwells) * times.cycle, float(at_stops + shaper) * times.cycle


def _find_stop_items(plan: Plan) -> Ints:
    """Items of the timeline (n_stops,) at which the file is cut."""
    dwells = plan.program.moves.dwells
    return np.flatnonzero(plan.timeline.section < 0)[np.searchsorted(dwells, plan.program.stops)]


class ToolLengths(Struct, frozen=True):
    """Numbers of tools and lengths, mm, in the order of their use."""

    own: tuple[tuple[int, float], ...]  #: With which each tool works.
    carried: tuple[tuple[int, float], ...]  #: Of the tool before, which rapids have until the tool's own is active.
    carried_lines: tuple[int, ...]  #: The lines of these rapids.
    bare_lines: tuple[int, ...]  #: Of rapids that have no length, although their tool has one in other moves.


def list_tool_lengths(program: Program) -> ToolLengths:
    """Which lengths each tool has.

    Programs go to a tool change and come from it without a length, or with that of the tool before, until the next G43.
    Where a tool does not feed with that and has another length, it is none of its own. So 0 is a length where the tool
    feeds with it or has no other. Turns of the table alone do not count, nor moves after the control has cancelled the
    length: no word of theirs says where the tip goes.
    """
    path, moves = program.path, program.moves
    feeds: dict[tuple[int, float], bool] = {}
    before, taken_over = (0, 0.0), set()
    lines: dict[tuple[int, float], set[int]] = {}  # of what is taken over, or has no length
    for begin, end in iterate_blocks(len(path)):
        move = path.move_reached[begin:end]
        number = find_tool_of_moves(move, path.first_move, moves)
        length = np.round(path.tool_length[begin:end] - program.options.lift, 6)
        feeding = path.feed_time[begin:end] > 0
        counts = ~moves.find_cancelled_length(move) & (path.turn[begin:end] < 0)
        rows = np.column_stack([number, length, feeding])[counts]
        if not len(rows):
            continue
        starts = np.flatnonzero(np.append(True, np.any(rows[1:] != rows[:-1], axis=1)))
        stretches = zip(rows[starts].tolist(), np.split(path.line[begin:end][counts], starts[1:]), strict=True)
        for (one, mm, has_feed), of_stretch in stretches:
            key = int(one), mm
            feeds[key] = feeds.get(key, False) or bool(has_feed)
            if key[0] != before[0] and key[1] == before[1]:
                taken_over.add(key)
            if (key in taken_over or not mm) and not feeds[key]:
                lines.setdefault(key, set()).update(of_stretch[of_stretch > 0].tolist())  # 0: an approach
            before = key
    measured = {number for number, length in feeds if length != 0}
    bare = {key for key, fed in feeds.items() if key[1] == 0 and not fed and key[0] in measured}
    others = {number for number, length in feeds if length != 0 and (number, length) not in taken_over}
    carried = {key for key in taken_over - bare if not feeds[key] and key[0] in others}
    return ToolLengths(
        tuple(key for key in feeds if key not in bare | carried),
        tuple(key for key in feeds if key in carried),
        tuple(sorted({line for key in carried for line in lines[key]})),
        tuple(sorted({line for key in bare for line in lines.get(key, ())})),
    )


def summarise(
    source: Text, plan: Plan, fmt: SetpointFormat, verdict: Verification | None, part: "Machined | None" = None
) -> Summary:
    """The facts of a conversion, for the paragraph and the metadata file."""
    program = plan.program
    path, contour, moves = program.path, program.contour, program.moves
    if verdict is not None:
        verdict.text = format_verdict(program.options.source_name, verdict, program.machine, passes=verdict.ok)
    before, parts = _list_parts(plan)
    shaped = _summarise_shaper(plan)
    dwelling, standing = _measure_rests(plan)
    feeds = reached = missed = 0
    used: set[int] = set()
    for begin, end in iterate_blocks(len(path)):
        feeding = path.feed_time[begin:end] > 0
        feeds += int(feeding.sum())
        at_feed = plan.profiles.reached_segments[begin:end]
        reached += int((feeding & at_feed).sum())
        late = np.flatnonzero(feeding & ~at_feed)
        missed = missed or (int(path.line[begin + late[0]]) if len(late) else 0)
        move = path.move[begin:end]
        used.update(find_used(moves.frame[move[move >= 0]]).tolist())
    lengths, names = list_tool_lengths(program), moves.name_tools()
    q_start = program.build_joint_path().find_joints(np.array([0]), np.array([0.0]))
    places, numbers = round_setpoints(q_start, program.machine, fmt)
    start = (places if numbers is None else numbers)[0]
    systems = sorted({moves.frames[index] for index in used}, key=lambda frame: frame.system)
    options = program.options
    return Summary(
        source=source,
        machine=program.machine,
        options=options,
        language=choose_dialect_name(options.dialect, source, options.source_name),
        language_is_assumed=not find_dialect_name(options.dialect, source, options.source_name),
        describe=format_summary,
        cycle_time=round(float(plan.timeline.first_row[-1] * plan.timeline.cycle), fmt.time_decimals),
        n_rows=plan.timeline.n_rows,
        n_segments=len(path),
        n_stops=contour.n_sections - 1,
        stops_within=_count_stops_within(contour),
        n_blended=contour.n_blended,
        dwell_time=dwelling,
        stop_time=standing,
        continuous_time=float(plan.profiles.cycles[plan.profiles.continuous_first >= 0].sum()) * plan.timeline.cycle,
        second_order_bound_s=plan.profiles.second_order_bound_s,
        toppra_bound_s=plan.profiles.toppra_bound_s,
        tolerance=(float(contour.tip_tolerance.max()), float(contour.axis_tolerance.max())),
        feed_segments=feeds,
        feed_reached=reached,
        feed_missed=missed,
        start=tuple(float(value) for value in start),
        frames=tuple(systems),
        placed_systems=moves.placed_systems,
        arc_feeds=moves.arc_feeds,
        events=moves.events,
        format=fmt,
        verification=_name_shaper(verdict) if shaped else verdict,
        free_turn=program.free_turn,
        parameters=moves.parameters,
        before=before,
        parts=parts,
        switched=program.restored,
        tools=tuple((choose_number_or_name(number, names), length) for number, length in lengths.own),
        carried=tuple((choose_number_or_name(number, names), length) for number, length in lengths.carried),
        carried_lines=lengths.carried_lines,
        bare_lines=lengths.bare_lines,
        stock=moves.stock,
        bodies=_describe_bodies(program),
        compared=() if part is None else _describe_part(part),
        shaped=shaped,
        axis_error_deg=plan.axis_error_deg if isinstance(program.machine.five_axis, AxisCorrecting) else None,
    )


def _describe_bodies(program: Program) -> tuple[str, ...]:
    """Each fixture and the stock, with size and place: what is given in another unit shows."""
    options = program.options
    if not options.keep_out and options.stock is None:
        return ()
    from verne_post.kinematics.checks.keep_out import place_bodies  # for programs with bodies around them alone

    frames = build_interpreter_setup(program.machine, options).frames
    placed = place_bodies(program.machine, program.moves, options, frames)
    return tuple(f"{one.name} ({one.describe_extent()})" for one in placed)


def _describe_part(part: "Machined") -> tuple[str, ...]:
    """What the comparison with the nominal part came to, line by line."""
    from verne_post.output.machined import describe_judged  # for programs with a part alone

    return (*part.notes, *describe_judged(part))
