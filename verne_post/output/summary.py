"""What commands say: the summary of a conversion as keys and values, the verdict on a file, the evaluation of a log."""

import math
import re
import textwrap
from collections.abc import Iterator, Sequence
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from verne_post.base.long_text import take_line
from verne_post.base.numbers import format_count, format_fixed
from verne_post.base.printable import make_printable
from verne_post.base.tolerances import ACCELERATION_RATIO, FEED_RATIO, JERK_RATIO, VELOCITY_RATIO
from verne_post.base.units import DEG_PER_RAD
from verne_post.model.findings import join_lines
from verne_post.model.machine import Machine
from verne_post.model.moves import IGNORED, Event, Stock, describe_tool, list_tool_changes, name_tools
from verne_post.model.options import Options
from verne_post.model.part_setup import choose_number_or_name, describe_tool_number, name_system
from verne_post.model.summary import Summary
from verne_post.model.verdict import Verdict
from verne_post.model.verification import Verification
from verne_post.model.work_systems import find_placer
from verne_post.output.rounding import estimate_rounding_noise
from verne_post.output.setpoints import name_joints
from verne_post.verification.following import Following

#: A true axis nearer to the nominal one than this is the same: rounding of the written numbers turns it by less.
_NO_AXIS_ERROR_DEG = 1e-5
#: Limits that are named as reasons for a speed below the feed rate.
_REASONS = 3

#: The number of a block: of an N word (1), of Klartext (2).
_BLOCK_NUMBER: Final = re.compile(r"\s*(?:(?:/\d*\s*)?N\s*(\d+)|/?\s*(\d+)\s+(?=[A-Z]))", re.IGNORECASE)
#: The blank between a number and its unit or joint, where no line ends; what stands there while lines are made.
_UNIT: Final = re.compile(r"(?<=\d) (?=(?:%|s|ms|mm|deg)\b|%)|(?:(?<=_mm)|(?<=_deg)) (?=[-\d])")
_JOINED: Final = "\N{NO-BREAK SPACE}"

#: Between the lines of a value that has several, such as one for each kind of limit.
LINE_OF_FACT: Final = "\n"
#: Said of a stock that the program defines while nothing asks for its check.
NOT_CHECKED_STOCK = "not checked (--stock program checks it)"

#: A number of a tool, or one and a name.
_Tool = TypeVar("_Tool", int, int | str)

#: Keys and values.
Facts = Sequence[tuple[str, str]]


def list_remarks(summary: Summary) -> list[str]:
    """What a person must compare with the machine: tools, offsets, bodies."""
    slow = _describe_feed(summary) if summary.feed_reached < summary.feed_segments else ()
    return [
        f"{key}: {text}"
        for key, text in (
            *list_unchecked(summary.machine, summary.options, summary.events),
            *slow,
            *_describe_setup(summary),
        )
    ]


def format_summary(summary: Summary, added: Facts = ()) -> str:
    """The verdict, and the facts below it: aligned keys, values wrapped at 100 columns.

    Parameters
    ----------
    added : sequence of (str, str)
        What a setpoint format has to say.
    """
    pairs = [*list_facts(summary), *added]
    width = 2 + max(len(key) for key, _text in pairs)
    lines = [f"{summary.options.source_name}: {name_verdict(summary)}"]
    for key, text in pairs:
        head, blank = f"  {key:<{width}}", " " * (width + 2)
        for each in text.split(LINE_OF_FACT):
            is_command = each.startswith("verne-post ")  # which is pasted: it stays in one line
            shown = make_printable(each)
            lines += textwrap.wrap(
                shown.replace(" ", _JOINED) if is_command else _UNIT.sub(_JOINED, shown),
                width=100,
                break_long_words=not is_command,
                break_on_hyphens=False,
                initial_indent=head,
                subsequent_indent=blank,
            )
            head = blank
    return "".join(line.replace(_JOINED, " ") + "\n" for line in lines)


def name_verdict(summary: Summary) -> str:
    """What became of the program, in a few words."""
    verified = "" if summary.verification is None else ", every row verified"
    return f"{Verdict.CAN_RUN} on {summary.machine.name}, {summary.cycle_time:.3f} s{verified}"


def list_facts(summary: Summary) -> list[tuple[str, str]]:
    """Facts of a conversion by key: start position, time, tolerance, limits, assumed values, and what to do."""
    return [
        *list_unchecked(summary.machine, summary.options, summary.events),
        ("start position", _describe_first_row(summary)),
        *_restart(summary),
        *_describe_dry_run(summary),
        *([("time", describe_time(summary))] if summary.motion_time < summary.cycle_time else []),
        ("rows", _describe_rows(summary)),
        *_bound(summary),
        *_describe_feed(summary),
        *_describe_free_turn(summary),
        *_describe_tolerance(summary),
        *_describe_vibration(summary),
        *_describe_axis_error(summary),
        *_describe_limits(summary),
        *_describe_rounding(summary),
        *_describe_setup(summary),
        *([("not limited", summary.machine.unlimited)] if summary.machine.unlimited else []),
        *([("changed", f"not as in the machine file: {changes}")] if (changes := summary.machine.changes) else []),
        *_describe_provisional(summary),
        *_describe_manual_stops(summary),
    ]


def format_verdict(name: str, verdict: Verification, machine: Machine, *, passes: bool) -> str:
    """Say in one sentence what ``verify`` found in a file, which passes or not: the program is checked too."""
    word = "passes" if passes else "FAILS, do not run it"
    worst = _describe_worst_ratios(verdict, machine)
    said = f"{name} {word}: {verdict.n_rows} rows; highest values (1 is the limit): {worst}"
    if not verdict.n_followed:
        return f"{said}; no row was compared with the program."
    whole = verdict.n_followed == verdict.n_rows
    rest = "" if whole else f"; from row {verdict.n_followed} on the rows do not match it, and were not compared"
    return (
        f"{said}, feed {verdict.feed_ratio:.4f}; tip {_round_up(verdict.tip_deviation_mm)} mm and axis "
        f"{_round_up(verdict.axis_deviation_deg)} deg from the programmed path{rest}"
        f"{_describe_true_axis(verdict)}{_describe_block_times(verdict)}."
    )


def _round_up(deviation: float) -> str:
    """A deviation that is not exceeded, mm or degrees, with as many decimals as people read.

    A hundredth of the last one is rounding of the rows.
    """
    return f"{max(math.ceil(deviation * 1e4 - 1e-2), 0) / 1e4:.4f}"


def _describe_block_times(verdict: Verification) -> str:
    """Whether blocks whose feed rate is a time take that time, and which takes longer most."""
    if not verdict.timed_blocks:
        return ""
    latest = verdict.latest_block
    if latest is None:
        if verdict.timed_blocks == 1:
            return "; the one block with a programmed time takes it"
        return f"; all {verdict.timed_blocks} blocks with a programmed time take it"
    take = "takes" if verdict.late_blocks == 1 else "take"
    return (
        f"; {verdict.late_blocks} of {verdict.timed_blocks} blocks with a programmed time {take} longer; "
        f"line {latest.line} is the worst: "
        f"{latest.spent_s:.3f} s for {latest.asked_s:.3f} s (nearest limit: {latest.reason})"
    )


def _describe_true_axis(verdict: Verification) -> str:
    """How far the true axis of an as-built machine is off, where it is."""
    if verdict.axis_error_deg < _NO_AXIS_ERROR_DEG:
        return ""
    return f"; as built, the tool axis is up to {verdict.axis_error_deg:.4f} deg off that of A and C"


def describe_following(
    name: str, following: Following, lines: NDArray[np.int32], cycle: float, machine: Machine
) -> str:
    """Say in sentences how a log differs from the setpoints."""
    size = [abs(column.factor) for column in machine.columns]
    joints = ", ".join(
        f"{column.joint} {worst * factor:.6f} {column.unit} (rms {rms * factor:.6f})"
        for column, worst, rms, factor in zip(
            machine.columns, following.joint_worst, following.joint_rms, size, strict=True
        )
    )

    def describe_row(row: int) -> str:
        return f"line {lines[row]}, {row * cycle:.3f} s"

    delay = following.delay
    return _wrap(
        f"{name}: {following.rows} rows, {delay} rows ({delay * cycle:g} s) later than the setpoints. Following error "
        f"of the joints at most: {joints}. The tip was at most {following.tip_worst:.6f} mm from the position "
        f"commanded for that time ({describe_row(following.tip_row)}), and {following.path_worst:.6f} mm from the "
        f"commanded path ({describe_row(following.path_row)}); the axis at most "
        f"{DEG_PER_RAD * following.axis_worst:.6f} deg ({describe_row(following.axis_row)})."
    )


def _wrap(text: str) -> str:
    return textwrap.fill(text, width=100, break_on_hyphens=False) + "\n"


# --- the motion ----------------------------------------------------------------------


def _describe_rows(summary: Summary) -> str:
    within = summary.stops_within
    if not within.count:
        where = ""
    elif within.count == within.most:
        where = f", of which {within.count} {'is' if within.count == 1 else 'are'} inside line {within.line}"
    else:
        where = f", of which {within.count} are inside a line ({within.most} in line {within.line})"
    return (
        f"{summary.n_rows} at {1e3 * summary.format.cycle:g} ms; {format_count(summary.n_segments, 'path segment')}; "
        f"{format_count(summary.n_stops, 'stop')}{where}"
    )


def describe_time(summary: Summary) -> str:
    """The machining time; where not all of it is motion, with its parts, which add up to it."""
    rests = {"dwells": summary.dwell_time, "stops": summary.stop_time}
    parts = [f"{seconds:.3f} s {name}" for name, seconds in rests.items() if seconds]
    whole = f"{summary.cycle_time:.3f} s"
    return f"{whole} = {summary.motion_time:.3f} s motion + {' + '.join(parts)}" if parts else whole


def _describe_first_row(summary: Summary) -> str:
    names = name_joints(summary.machine.columns, summary.format.drives)
    values = [
        f"{name} {format_fixed(value, min(decimals, 4))}"
        for name, value, decimals in zip(names, summary.start, summary.format.decimals, strict=True)
    ]
    return f"the machine must be at {', '.join(values)}"


def _restart(summary: Summary) -> Facts:
    """Where a restart begins, and what must be as the skipped blocks would have left it."""
    if summary.options.from_line is None:
        return []
    forms = {
        "spindle": "spindle {direction} at {speed:g}{per}",
        "coolant": "coolant {state}",
        "override": "override switches (M48 to M53): {switches}",
        "spindle mode": "{code}{most}",
        "orient": "spindle stopped at {angle:g} degrees",
        "signal": "{what} output {output} as line {line} sets it",
    }
    states, executed = list[str](), list[str]()
    for event in summary.switched:
        data = event.data
        if event.kind in ("remapped", "auxiliary"):
            words = "".join(f" {key}{value:g}" for key, value in data.items() if isinstance(value, float))
            executed.append(f"{data['code']}{words} of line {event.line}")
        elif event.kind == "tool":
            states.append(describe_tool(event))
        else:
            more = {
                "per": f" {data['unit']}" if "unit" in data else "/min",
                "most": f" (at most {data['most_per_minute']:g}/min)" if "most_per_minute" in data else "",
                "what": "digital" if "on" in data else "analog",
                "switches": ", ".join(f"{name} {'on' if on else 'off'}" for name, on in data.items()),
            }
            states.append(forms[event.kind].format(line=event.line, **more, **data))
    needed = f"; before the start there must be: {', '.join(states)}" if states else ""
    done = f"; the program has executed, in this order: {', '.join(executed)}" if executed else ""
    return [("restart", f"starts at line {summary.options.from_line}{needed}{done}")]


def _describe_dry_run(summary: Summary) -> Facts:
    options, texts = summary.options, []
    if options.air:
        along = "the tool axis" if options.air_along == "tool" else "the table's normal"
        texts.append(("dry run", f"everything is lifted by {options.air:g} mm along {along}"))
    if options.override != 1.0:
        texts.append(("feed override", f"all motion at {100 * options.override:g} % of the planned speed"))
    if options.slow_start:
        texts.append(("slow start", f"a tenth of the speed at first, full speed after {options.slow_start:g} s"))
    return texts


def _is_as_planned(summary: Summary) -> bool:
    """Whether the motion is executed at the planned speed."""
    return summary.options.override == 1.0 and summary.options.slow_start == 0.0


def _bound(summary: Summary) -> Facts:
    """How near continuous motion is to the shortest time without jerk limits."""
    bound = summary.second_order_bound_s
    if bound <= 0 or not _is_as_planned(summary):
        return []
    gap = 100 * (summary.continuous_time / bound - 1)
    whole = abs(summary.continuous_time - summary.motion_time) < 0.5 * summary.format.cycle
    part = "" if whole else f"sections with blended corners take {summary.continuous_time:.3f} s, "
    text = f"{part}{gap:.1f} % more than without jerk limits"
    if summary.toppra_bound_s is not None:
        text += f" ({bound:.4f} s; toppra finds the same to {summary.toppra_bound_s / bound - 1:+.1e})"
    return [("motion", text)]


def _describe_worst_ratios(verdict: Verification, machine: Machine) -> str:
    """The largest ratio to a limit of each kind, with its joint."""
    return ", ".join(f"{name} {share:.4f} ({joint})" for name, share, joint in _list_worst_ratios(verdict, machine))


def _list_worst_ratios(verdict: Verification, machine: Machine) -> Iterator[tuple[str, float, str]]:
    """Kind, largest ratio to a limit of this kind, and the joint that has it."""
    for name, ratio in (
        ("velocity", verdict.velocity_ratio),
        ("acceleration", verdict.acceleration_ratio),
        ("jerk", verdict.jerk_ratio),
    ):
        if name != "jerk" or np.isfinite(machine.limits.jerk).any():
            yield name, float(ratio.max()), machine.columns[int(np.argmax(ratio))].joint


def _describe_limits(summary: Summary) -> Facts:
    """Worst shares of the limits in the numbers as written, and what is allowed above 1 and why."""
    verdict = summary.verification
    if verdict is None:
        return []
    allowed = {"velocity": VELOCITY_RATIO, "acceleration": ACCELERATION_RATIO, "jerk": JERK_RATIO, "feed": FEED_RATIO}
    shares = [*_list_worst_ratios(verdict, summary.machine), ("feed", verdict.feed_ratio, "")]
    width = max(len(name) for name, _share, _joint in shares)
    rows = [
        f"{name + ':':<{width + 1}} {share:.4f}"
        + (f" ({joint})" if joint else "")
        + (f", allowed up to {allowed[name]:g}" if share > 1.0 else "")
        for name, share, joint in shares
    ]
    beyond = any(share > 1.0 for _name, share, _joint in shares)
    why = ", which blended corners and rounding may exceed a little" if beyond else ""
    return [("limits", LINE_OF_FACT.join((f"highest values; 1 is the limit{why}", *rows)))]


def _describe_tolerance(summary: Summary) -> Facts:
    tip, axis = summary.tolerance
    texts = (
        [("tolerance", f"{summary.n_blended} corners blended within {tip:g} mm and {DEG_PER_RAD * axis:g} deg")]
        if summary.n_blended
        else []
    )
    if (verdict := summary.verification) is not None:
        texts.append(
            (
                "path",
                f"at most {_round_up(verdict.tip_deviation_mm)} mm and {_round_up(verdict.axis_deviation_deg)} deg "
                "from the programmed one",
            )
        )
    return texts


def _describe_vibration(summary: Summary) -> Facts:
    """The input shaper, and what it leaves of each mode."""
    if (shaped := summary.shaped) is None:
        return []
    left = ", ".join(f"{100.0 * share:.1f} % at {frequency:g} Hz" for frequency, share in shaped.left)
    rest = f"{1e3 * shaped.rest:g} ms of rest before and after each motion"
    return [("vibration", f"input shaper {shaped.shaper}, {rest}; of the modes' vibration it leaves {left}")]


def _describe_axis_error(summary: Summary) -> Facts:
    """What the as-built machine cannot correct."""
    if summary.axis_error_deg is None:
        return []
    if summary.machine.five_axis.corrects_axis:  # type: ignore[attr-defined]
        why = "where the tool is too near the vertical for C to correct its share"
    else:
        why = "because C stays as programmed (--correct-axis)"
    if summary.axis_error_deg < _NO_AXIS_ERROR_DEG:
        return [("as built", "tip and tool axis are exact")]
    return [("as built", f"the tool axis is up to {summary.axis_error_deg:.4f} deg off, {why}; the tip is exact")]


def _describe_feed(summary: Summary) -> Facts:
    """How often the programmed feed rate is reached, and which limits are near where it is not."""
    if not summary.feed_segments or not _is_as_planned(summary):
        return []
    reach = "reaches" if summary.feed_reached == 1 else "reach"
    text = f"{summary.feed_reached} of {summary.feed_segments} feed moves {reach} the programmed feed rate"
    if summary.feed_missed:
        text += f"; line {summary.feed_missed} is the first that does not"
    slow = summary.verification.slow if summary.verification is not None else {}
    if slow:
        longest = sorted(slow.items(), key=lambda item: -item[1])[:_REASONS]
        reasons = ", ".join(f"{name} {seconds:.3f} s" for name, seconds in longest)
        text += f"{LINE_OF_FACT}slower for {sum(slow.values()):.3f} s, nearest limits there: {reasons}"
    if summary.verification is not None:
        text += _describe_block_times(summary.verification)
    return [("feed rate", text)]


def _describe_free_turn(summary: Summary) -> Facts:
    turn = summary.free_turn
    if turn is None:
        return []
    factor = summary.machine.columns[-1].factor
    if turn.chosen == turn.before:
        text = (
            f"C stays at {format_fixed(turn.before * factor, 3)} deg: no other C has a larger smallest margin than "
            f"{format_fixed(turn.margin, 3)} ({turn.nearest})"
        )
    else:
        old = format_fixed(turn.margin_before, 3) if np.isfinite(turn.margin_before) else "out of reach"
        text = (
            f"C is at {format_fixed(turn.chosen * factor, 3)} deg: the smallest margin is "
            f"{format_fixed(turn.margin, 3)} ({turn.nearest}), "
            f"instead of {old} at C {format_fixed(turn.before * factor, 3)} (0 at a limit, 1 in the middle of a travel)"
        )
    return [("free C", text)]


# --- the set-up ----------------------------------------------------------------------


def _describe_setup(summary: Summary) -> Facts:
    """What a person must compare with the machine."""
    source = [("set-up", f"from {summary.options.setup_source}")] if summary.options.setup_source else []
    # the dialect matters most where a dwell is a thousand times as long
    is_doubtful = summary.language_is_assumed and summary.dwell_time > 0
    language = "RS274/NGC, as nothing shows another: dwells in s (--dialect fanuc: in ms)"
    return [
        *source,
        *([("language", language)] if is_doubtful else []),
        ("tool length", _describe_tools(summary)),
        ("work offset", _describe_offsets(summary)),
        *_describe_arc_feeds(summary),
        *_describe_stock(summary),
        *_keep_out(summary),
        *(("part", text) for text in summary.compared),
    ]


def _describe_tools(summary: Summary) -> str:
    """Lengths of each tool in the order of their use, and where they are from when nobody may have given one."""
    names = name_tools(summary.events)
    tools = ", ".join(
        (f'tool "{tool}": ' if isinstance(tool, str) else f"{describe_tool_number(tool, names)}: " if tool else "")
        + f"{used} mm"
        for tool, used in join_lengths(summary.tools).items()
    )
    source = " (one length for the program)" if summary.options.tool_length is not None else ""
    listed = (summary.options.tools or {}).items()
    meant = {choose_number_or_name(number, names) for number, tool in listed if tool.ends_at_gauge_line}
    if summary.options.tool_length != 0 and any(not length and number not in meant for number, length in summary.tools):
        zero = "" if len(summary.tools) == 1 else "0 mm: "
        source = f" ({zero}no length is in force, or none was given)"
    if summary.bare_lines:
        source += f"; 0 mm in rapids of {join_lines(summary.bare_lines)}, where no length is active"
    if summary.carried:
        source += f"; rapids of {join_lines(summary.carried_lines)} still have the length of the tool before"
    return f"{tools}{source}"


def join_lengths(tools: Sequence[tuple[_Tool, float]]) -> dict[_Tool, str]:
    """Number or name of each tool -> its lengths in mm, ``80`` or ``80 then 95``."""
    lengths: dict[_Tool, list[str]] = {}
    for number, length in tools:
        lengths.setdefault(number, []).append(f"{length:g}")
    return {number: " then ".join(used) for number, used in lengths.items()}


def _describe_offsets(summary: Summary) -> str:
    """Where the work systems in use are on the table, and who put them there."""
    places: dict[str, None] = {}
    for frame in summary.frames:
        name = name_system(frame.system)
        x, y, z = summary.machine.find_origin_on_table(frame)
        turn = f", part turned {frame.part_turn:g} deg" if frame.part_turn else ""
        place = f"{name} at ({x:g}, {y:g}, {z:g}) mm on the table{turn}"
        who = find_placer(frame, summary.machine, summary.options, summary.placed_systems)
        if who == "machine":
            place = f"{name} is machine zero, ({x:g}, {y:g}, {z:g}) mm on the table"
        elif who == "nobody":
            place = f"{name} at {summary.machine.coordinates.zero_point} (no offset was given)"
        elif who == "program" and frame.system in summary.options.wcs:
            place += " (the program sets it: --wcs has no effect)"
        places[place] = None
    return "; ".join(places)


def _describe_arc_feeds(summary: Summary) -> Facts:
    """Where F holds on arcs beside the contour, and what says so."""
    texts = []
    for use in summary.arc_feeds:
        rule = use.rule
        where = "on the contour" if rule.most > 1 else "on the contour of inside arcs"
        why = f"{rule.name}, assumed: neither the program nor the settings file says so" if rule.assumed else rule.name
        shares = " to ".join(dict.fromkeys(f"{share:.4g}" for share in (use.slowest, use.fastest)))
        arcs = format_count(use.arcs, "arc")
        texts.append(f"F applies {where} ({why}): the tool's centre goes at {shares} times F on {arcs}")
    return [("feed on arcs", "; ".join(texts))] if texts else []


def _keep_out(summary: Summary) -> Facts:
    """What is kept out of."""
    options = summary.options
    cut = f" (as the lines before {options.from_line} have cut it)" if options.stock and options.from_line else ""
    return [("kept out of", ", ".join(summary.bodies) + " on the table" + cut)] if summary.bodies else []


def list_absent_bodies(options: Options) -> list[str]:
    """What is not checked for contact because the set-up gives none; nothing where it gives fixtures and stock."""
    missing = {"fixtures": ("[keep_out.NAME]", options.keep_out), "stock": ("[stock]", options.stock)}
    absent = {body: table for body, (table, given) in missing.items() if not given}
    return [f"contact with {' and '.join(absent)}: no {' and no '.join(absent.values())} given"] if absent else []


def _list_ignored(events: Sequence[Event]) -> list[str]:
    """Codes and names that [remap] ignores: what they do, or were meant to do, is not known."""
    lines: dict[str, dict[int, None]] = {}
    for event in events:
        if event.data.get("why") == IGNORED:
            lines.setdefault(str(event.data["word"]), {})[event.line] = None
    more = {name: f" and {len(at) - 1} more" if len(at) > 1 else "" for name, at in lines.items()}
    shown = ", ".join(f"{name} in line {next(iter(at))}{more[name]}" for name, at in lines.items())
    return [f"{IGNORED}: {shown}"] if shown else []


def list_unchecked(machine: Machine, options: Options, events: Sequence[Event]) -> Facts:
    """Codes and names that [remap] ignores, and bodies that nothing is known of.

    These are fixtures and stock, and those of machine and tools whose size is not known.
    """
    bodies, none = machine.bodies, [*_list_ignored(events), *list_absent_bodies(options)]
    if not options.keep_out and options.stock is None:
        return [("NOT CHECKED", "; ".join(none))]
    used = {number for _change, number in list_tool_changes(events)} - {0} or {0}  # T0 empties the spindle
    tools = options.tools or {}
    named = name_tools(events)
    shapeless = {
        number: describe_tool_number(number, named) if number else "the tool"
        for number in sorted(used)
        if number not in options.tool_shapes
    }
    thin = [name for number, name in shapeless.items() if not (number in tools and tools[number].diameter > 0)]
    has_rods = machine.has_rods
    unknown = ["spindle"] if bodies is None or bodies.spindle_radius is None else []
    unknown += ["platform"] if has_rods and (bodies is None or bodies.platform is None) else []
    unknown += ["rods"] if has_rods and (bodies is None or bodies.rod_radius is None) else []
    missing = [f"{', '.join(unknown)}: the machine file has no size"] if unknown else []
    missing += [f"the width of {', '.join(thin)}: without a diameter it is a line"] if thin else []
    if bare := _name_bare_parts(shapeless, used - set(shapeless), options, named):
        missing.append(f"{bare}: not among the tool shapes")
    return [("NOT CHECKED", "; ".join([*none, *missing]))] if none or missing else []


def _name_bare_parts(shapeless: dict[int, str], shaped: set[int], options: Options, named: dict[int, str]) -> str:
    """Shanks and holders without a size: those of tools without a shape, and holders that shapes lack."""
    none = [
        describe_tool_number(number, named)
        for number in sorted(shaped)
        if all(one.part != "holder" for one in options.tool_shapes[number])
    ]
    groups = {"shank and holder": [*shapeless.values()], "holder": none}
    return ", ".join(f"{part} of {', '.join(tools)}" for part, tools in groups.items() if tools)


def _describe_stock(summary: Summary) -> Facts:
    """The stock of the program, and that it is not checked."""
    stock = summary.stock
    if stock is None:
        return []
    place = f"{describe_own_stock(stock)} in {name_system(stock.frame.system)}"
    return [("stock", f"of the program: {place}" + ("" if summary.options.stock else f"; {NOT_CHECKED_STOCK}"))]


def describe_own_stock(stock: Stock) -> str:
    """Size and lower corner of the stock that a program defines, mm, in its work system."""
    x, y, z = stock.size
    shape = f"a cylinder of {x:g} by {z:g}" if stock.round else f"{x:g} x {y:g} x {z:g}"
    return f"{shape} mm from ({', '.join(f'{value:g}' for value in stock.low)})"


def _name_block(summary: Summary, line: int) -> str:
    """``, N250`` or ``, block 25``: the number that the control shows for a line; empty where it has none."""
    text = (take_line(summary.source, line) or b"").decode("utf-8", errors="replace")
    found = _BLOCK_NUMBER.match(text)
    if found is None:
        return ""
    return f", N{found[1]}" if found[1] else f", block {found[2]}"


def _describe_manual_stops(summary: Summary) -> Facts:
    """What a person must do before the start, between the parts, and at the end."""
    skipped = {id(event) for event in summary.switched}
    stops = [
        event
        for event in summary.events
        if id(event) not in skipped and event.waits(optional_stop=summary.options.optional_stop)
    ]
    forms = {"input": "wait for input {input}", "stop": "{stop} stop"}
    between = {id(event) for part in summary.parts[:-1] for event in part.then}
    last = {id(event) for part in summary.parts[-1:] for event in part.then}
    groups: dict[str, list[str]] = {
        "before the start: ": [],
        f"between the {len(summary.parts)} parts into which the file is cut: ": [],
        "at the end: ": [],
    }
    heads, loaded = list(groups), ""
    for event in stops:
        head = heads[1 if id(event) in between else 2 if id(event) in last else 0]
        tool = f"load {describe_tool(event)}" if event.kind == "tool" else ""
        if tool and tool == loaded and head == heads[0]:
            continue  # it is in the spindle already
        loaded = tool or loaded
        what = tool or forms[event.kind].format(**event.data)
        groups[head].append(f"{what} (line {event.line}{_name_block(summary, event.line)})")
    return [("operator", head + "; ".join(texts)) for head, texts in groups.items() if texts]


def _describe_rounding(summary: Summary) -> Facts:
    """What rounding may add, where it was not chosen by the limits."""
    if summary.options.decimals is None and not any(drive.integer for drive in summary.format.drives):
        return []
    parts = [
        f"{column.joint} {acceleration:.3g} {column.unit}/s2 and {jerk:.3g} {column.unit}/s3"
        for column, acceleration, jerk in zip(
            summary.machine.columns, *estimate_rounding_noise(summary.format), strict=True
        )
    ]
    return [("rounding", f"may add {'; '.join(parts)} to the differences")]


def _describe_provisional(summary: Summary) -> Facts:
    assumed = summary.machine.assumed
    return [("assumed", f"not measured (machine file): {', '.join(assumed)}")] if assumed else []
