"""What commands say in plain sentences: the summary of a conversion, the verdict on a file, the evaluation of a log."""

import textwrap

import numpy as np
from numpy.typing import NDArray

from verne_post.base.units import DEG_PER_RAD
from verne_post.model.machine import Machine
from verne_post.model.part_setup import SYSTEM_NAMES
from verne_post.model.summary import Summary
from verne_post.model.verification import Verification
from verne_post.output.rounding import rounding_noise
from verne_post.output.setpoints import column_names
from verne_post.verification.following import Following

#: A work offset of the program differs from the one of ``--wcs`` when it is farther off than this, mm: noise of two sums.
_OFFSET_NOISE = 1e-9
#: A true axis nearer to the nominal one than this is the same: rounding of the written numbers turns it by less.
_NO_AXIS_ERROR_DEG = 1e-5
#: Limits that are named as reasons for a speed below the feed rate.
_REASONS = 3


def remarks(summary: Summary) -> list[str]:
    """What a person must compare with the machine: tools, offsets, bodies."""
    return [_tools(summary), _offsets(summary), *_stock(summary), *_keep_out(summary)]


def paragraph(summary: Summary) -> str:
    """One paragraph of sentences, wrapped at 100 columns."""
    sentences = [
        _motion(summary), _first_row(summary), *_restart(summary), *_dry_run(summary), *_bound(summary),
        *_verification(summary), *_axis_error(summary), *_feed(summary), *_free_turn(summary), *remarks(summary), *_manual_stops(summary),
        *_rounding(summary), *_provisional(summary),
    ]  # fmt: skip
    return _wrap(" ".join(sentences))


def verdict_line(name: str, verdict: Verification, machine: Machine) -> str:
    """Say in one sentence what ``verify`` found in a file."""
    word = "passes" if verdict.ok else "FAILS"
    return (
        f"{name} {word}: {verdict.n_rows} rows; worst of the limits: {_worst_ratios(verdict, machine)}, "
        f"feed {verdict.feed_ratio:.4f}; tip {verdict.tip_deviation_mm:.6f} mm and axis {verdict.axis_deviation_deg:.6f} deg "
        f"from the programmed path{_true_axis(verdict)}."
    )


def _true_axis(verdict: Verification) -> str:
    """How far the true axis of an as-built machine is off, where it is."""
    if verdict.axis_error_deg < _NO_AXIS_ERROR_DEG:
        return ""
    return f"; as built, the tool axis is up to {verdict.axis_error_deg:.4f} deg off that of A and C"


def following_text(name: str, following: Following, lines: NDArray[np.int32], cycle: float, machine: Machine) -> str:
    """Say in sentences how a log differs from the setpoints."""
    size = [abs(column.factor) for column in machine.columns]
    joints = ", ".join(
        f"{column.joint} {worst * factor:.6f} {column.unit} (rms {rms * factor:.6f})"
        for column, worst, rms, factor in zip(
            machine.columns, following.joint_worst, following.joint_rms, size, strict=True
        )
    )

    def at(row: int) -> str:
        return f"line {lines[row]}, {row * cycle:.3f} s"

    delay = following.delay
    return _wrap(
        f"{name}: {following.rows} rows, {delay} rows ({delay * cycle:g} s) later than the setpoints. "
        f"Following error of the joints at most: {joints}. "
        f"The tip was at most {following.tip_worst:.6f} mm from the position commanded for that time ({at(following.tip_row)}), "
        f"and {following.path_worst:.6f} mm from the commanded path ({at(following.path_row)}); "
        f"the axis at most {DEG_PER_RAD * following.axis_worst:.6f} deg ({at(following.axis_row)})."
    )


def _wrap(text: str) -> str:
    return textwrap.fill(text, width=100, break_on_hyphens=False) + "\n"


# --- sentences about the motion ----------------------------------------------------------------------


def _motion(summary: Summary) -> str:
    tip, axis = summary.tolerance
    within = f" within {tip:g} mm and {DEG_PER_RAD * axis:g} deg" if summary.n_blended else ""
    return (
        f"{summary.options.source_name} on {summary.machine.name}: {summary.cycle_time:.3f} s, {summary.n_rows} rows at "
        f"{1e3 * summary.format.cycle:g} ms, {summary.n_segments} segments, {summary.n_blended} corners blended{within}, "
        f"{summary.n_stops} stops between them."
    )


def _first_row(summary: Summary) -> str:
    names = column_names(summary.machine.columns, summary.format.drives)[1:-1]
    values = [
        f"{name} {value:.{min(decimals, 4)}f}"
        for name, value, decimals in zip(names, summary.start, summary.format.decimals, strict=True)
    ]
    return f"The machine must stand at the first row: {', '.join(values)}."


def _restart(summary: Summary) -> list[str]:
    """Where a restart begins, and what must be as the skipped blocks would have left it."""
    if summary.options.from_line is None:
        return []
    forms = {"tool": "tool {number}", "spindle": "spindle {direction} at {speed:g}/min", "coolant": "coolant {state}",
             "override": "overrides switched off by M48 to M53", "signal": "output {output} as line {line} sets it",
             "remapped": "{code} of line {line}"}  # fmt: skip
    states = [forms[event.kind].format(line=event.line, **event.data) for event in summary.switched]
    needed = f"; before the start there must be: {', '.join(states)}" if states else ""
    return [f"Taken up at line {summary.options.from_line}{needed}."]


def _dry_run(summary: Summary) -> list[str]:
    options, sentences = summary.options, []
    if options.air:
        along = "the tool axis" if options.air_along == "tool" else "the table's normal"
        sentences.append(f"Dry run: everything is lifted by {options.air:g} mm along {along}.")
    if options.override != 1.0:
        sentences.append(f"Feed override: all motion is executed at {100 * options.override:g} % of the planned speed.")
    if options.slow_start:
        sentences.append(f"Slow start: a tenth of the speed at first, the whole of it after {options.slow_start:g} s.")
    return sentences


def _is_as_planned(summary: Summary) -> bool:
    """Whether the motion is executed at the planned speed."""
    return summary.options.override == 1.0 and summary.options.slow_start == 0.0


def _bound(summary: Summary) -> list[str]:
    """How near continuous motion is to the shortest time without jerk limits."""
    bound = summary.second_order_bound_s
    if bound <= 0 or not _is_as_planned(summary):
        return []
    gap = 100 * (summary.continuous_time / bound - 1)
    text = f"Continuous motion takes {summary.continuous_time:.3f} s, {gap:.1f} % more than without jerk limits"
    if summary.toppra_bound_s is not None:
        text += f" ({bound:.4f} s; toppra finds the same to {summary.toppra_bound_s / bound - 1:+.1e})"
    return [text + "."]


def _worst_ratios(verdict: Verification, machine: Machine) -> str:
    """The largest ratio to a limit of each kind, with its joint."""
    return ", ".join(
        f"{name} {ratio.max():.4f} ({machine.columns[int(np.argmax(ratio))].joint})"
        for name, ratio in (("velocity", verdict.velocity_ratio), ("acceleration", verdict.acceleration_ratio),
                            ("jerk", verdict.jerk_ratio))
    )  # fmt: skip


def _verification(summary: Summary) -> list[str]:
    verdict = summary.verification
    if verdict is None:
        return []
    return [
        f"Worst of the limits in the written numbers: {_worst_ratios(verdict, summary.machine)}; "
        f"feed {verdict.feed_ratio:.4f}.",
        f"Farthest from the programmed path: tip {verdict.tip_deviation_mm:.6f} mm, "
        f"axis {verdict.axis_deviation_deg:.6f} deg.",
    ]


def _axis_error(summary: Summary) -> list[str]:
    """What the as-built machine cannot correct."""
    if summary.axis_error_deg is None:
        return []
    if summary.machine.five_axis.corrects_axis:  # type: ignore[attr-defined]
        why = "where the tool is too upright for C to take its share"
    else:
        why = "because C stays as programmed (--correct-axis)"
    if summary.axis_error_deg < _NO_AXIS_ERROR_DEG:
        return ["As built, tip and tool axis are exact."]
    return [f"As built, the tool axis is up to {summary.axis_error_deg:.4f} deg off, {why}; the tip is exact."]


def _feed(summary: Summary) -> list[str]:
    """How often the programmed feed rate is reached, and which limits are near where it is not."""
    if not summary.feed_segments or not _is_as_planned(summary):
        return []
    text = f"The programmed feed rate is reached on {summary.feed_reached} of {summary.feed_segments} feed moves"
    slow = summary.verification.slow if summary.verification is not None else {}
    if slow:
        longest = sorted(slow.items(), key=lambda item: -item[1])[:_REASONS]
        reasons = ", ".join(f"{name} {seconds:.3f} s" for name, seconds in longest)
        text += f"; {sum(slow.values()):.3f} s are below it, nearest limits there: {reasons}"
    return [text + "."]


def _free_turn(summary: Summary) -> list[str]:
    turn = summary.free_turn
    if turn is None:
        return []
    factor = summary.machine.columns[-1].factor
    if turn.chosen == turn.before:
        return [
            f"C stays at {turn.before * factor:.3f} deg: no other C has a larger smallest margin than "
            f"{turn.margin:.3f} ({turn.nearest})."
        ]
    old = f"{turn.margin_before:.3f}" if np.isfinite(turn.margin_before) else "out of reach"
    return [
        f"C stands at {turn.chosen * factor:.3f} deg: the smallest margin is {turn.margin:.3f} ({turn.nearest}), "
        f"in place of {old} at C {turn.before * factor:.3f} (0 at a limit, 1 in the middle of a travel)."
    ]


# --- sentences about the set-up ----------------------------------------------------------------------


def _tools(summary: Summary) -> str:
    """Lengths of the tools, and where they are from when nobody may have given one."""
    lengths = [(f"tool {number} " if number else "") + f"{length:g} mm" for number, length in summary.tools]
    source = " (--tool-length)" if summary.options.tool_length is not None else ""
    if any(length == 0 for _number, length in summary.tools) and summary.options.tool_length != 0:
        source = " (no length is in force: G49, or none was given)"
    return f"Tool length: {', '.join(lengths)}{source}."


def _offsets(summary: Summary) -> str:
    """Where the work systems in use are on the table, and who put them there."""
    places: dict[str, None] = {}
    for frame in summary.frames:
        name = SYSTEM_NAMES[frame.system]
        x, y, z = summary.machine.origin_on_table(frame)
        turn = f", part turned {frame.part_turn:g} deg" if frame.part_turn else ""
        place = f"{name} at ({x:g}, {y:g}, {z:g}) mm on the table{turn}"
        given = summary.options.wcs.get(frame.system)
        if given is None:
            if (x, y, z) == (0.0, 0.0, 0.0) and not frame.part_turn:
                place = f"{name} at the rotary centre on the table face (no offset was given)"
        elif max(abs(a - b) for a, b in zip((x, y, z), given.origin_mm, strict=True)) > _OFFSET_NOISE:
            place += " (the program sets it with G10: --wcs does not hold)"
        places[place] = None
    return f"Work offset: {'; '.join(places)}."


def _keep_out(summary: Summary) -> list[str]:
    """The boxes that are kept out of, and the bodies whose size is not known."""
    options, bodies = summary.options, summary.machine.bodies
    names = [box.name for box in options.keep_out] + ([options.stock.name] if options.stock else [])
    if not names:
        return []
    used = {int(str(event.data["number"])) for event in summary.events if event.kind in ("tool", "tool number")} or {0}
    tools = options.tools or {}
    thin = [f"tool {number}" if number else "the tool" for number in sorted(used)
            if number not in options.tool_shapes and not (number in tools and tools[number].diameter > 0)]  # fmt: skip
    unknown = [body for body, size in (("spindle", bodies and bodies.spindle_radius), ("platform", bodies and bodies.platform))
               if not size]  # fmt: skip
    text = f"Kept out of: {', '.join(names)}"
    if thin:
        text += f"; without a diameter, checked as a thin line: {', '.join(thin)}"
    if unknown:
        text += f"; without a size in the machine file, not checked: {', '.join(unknown)}"
    return [text + "."]


def _stock(summary: Summary) -> list[str]:
    """The stock of the program, and that it is not checked."""
    stock = summary.stock
    if stock is None:
        return []
    x, y, z = stock.size
    shape = f"a cylinder of {x:g} by {z:g}" if stock.round else f"{x:g} x {y:g} x {z:g}"
    low = ", ".join(f"{value:g}" for value in stock.low)
    checked = "" if summary.options.stock else "; it is not checked, --stock does that"
    return [f"Stock of the program: {shape} mm from ({low}) in {SYSTEM_NAMES[stock.frame.system]}{checked}."]


def _manual_stops(summary: Summary) -> list[str]:
    """What a person must do before the start, between the parts, and at the end."""
    skipped = {id(event) for event in summary.switched}
    stops = [
        event
        for event in summary.events
        if id(event) not in skipped and event.waits(optional_stop=summary.options.optional_stop)
    ]
    forms = {"tool": "tool {number}", "input": "wait for input {input}", "stop": "{stop} stop"}
    between = {id(event) for part in summary.parts[:-1] for event in part.then}
    last = {id(event) for part in summary.parts[-1:] for event in part.then}
    groups: dict[str, list[str]] = {
        "For a person to do before the start": [],
        f"Cut into {len(summary.parts)} parts; for a person to do between them": [],
        "For a person to do at the end": [],
    }
    heads = list(groups)
    for event in stops:
        head = heads[1 if id(event) in between else 2 if id(event) in last else 0]
        groups[head].append(f"line {event.line} {forms[event.kind].format(**event.data)}")
    return [f"{head}: {'; '.join(texts)}." for head, texts in groups.items() if texts]


def _rounding(summary: Summary) -> list[str]:
    """What rounding may add, where it was not chosen by the limits."""
    if summary.options.decimals is None and not any(drive.integer for drive in summary.format.drives):
        return []
    parts = [
        f"{column.joint} {acceleration:.3g} {column.unit}/s2 and {jerk:.3g} {column.unit}/s3"
        for column, acceleration, jerk in zip(
            summary.machine.columns, *rounding_noise(summary.machine, summary.format), strict=True
        )
    ]
    return [f"Rounding of the written numbers may add {'; '.join(parts)} to the differences."]


def _provisional(summary: Summary) -> list[str]:
    assumed = [group for group, source in summary.machine.provenance.items() if source.startswith("assumed")]
    return [f"Assumed values of the machine file, not measured ones: {', '.join(assumed)}."] if assumed else []
