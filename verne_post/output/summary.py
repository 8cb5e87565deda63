"""The paragraph that a conversion prints, and the side-car file of `--meta`."""

import json
import textwrap
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.long_text import sha256
from verne_post.base.tolerances import ROUNDING_SHARES
from verne_post.base.units import DEG_PER_RAD
from verne_post.model.machine import Machine
from verne_post.model.part_setup import SYSTEM_NAMES
from verne_post.model.summary import Summary
from verne_post.model.verification import Verification
from verne_post.output.rounding import rounding_noise
from verne_post.output.setpoints import column_names
from verne_post.verify.following import Following

#: Version of the layout of the side-car file.
SIDE_CAR_SCHEMA: Final = 2


def remarks(summary: Summary) -> list[str]:
    """What a person must compare with the machine in front of him: tools, offsets, bodies."""
    return [*_tools(summary), *_offsets(summary), *_keep_out(summary)]


def paragraph(summary: Summary) -> str:
    """One paragraph of plain sentences, wrapped at 100 columns."""
    machine, options = summary.machine, summary.options
    joints = [column.joint for column in machine.columns]
    names = column_names(machine.columns, summary.format.drives)
    start = ", ".join(
        f"{name} {value:.{min(d, 4)}f}"
        for name, value, d in zip(names[1:-1], summary.start, summary.format.decimals, strict=True)
    )
    parts = [
        f"{options.source_name} on {machine.name}: {summary.cycle_time:.3f} s, {summary.n_rows} rows at "
        f"{1e3 * summary.format.cycle:g} ms, {summary.n_segments} segments, {summary.n_blended} corners rounded"
        + (
            f" within {summary.tolerance[0]:g} mm and {DEG_PER_RAD * summary.tolerance[1]:g} deg"
            if summary.n_blended
            else ""
        )
        + f", {summary.n_stops} stops between them.",
        f"The machine must stand at the first row: {start}.",
    ]
    as_planned = options.override == 1.0 and options.slow_start == 0.0
    parts += _taken_up(summary)
    parts += _dry_run(summary)
    if summary.second_order_bound_s > 0 and as_planned:
        gap = 100 * (summary.continuous_time / summary.second_order_bound_s - 1)
        text = f"Motion with rounded corners takes {summary.continuous_time:.3f} s, {gap:.1f} % more than without jerk limits"
        if summary.toppra_bound_s is not None:
            apart = summary.toppra_bound_s / summary.second_order_bound_s - 1
            text += f" ({summary.second_order_bound_s:.4f} s; toppra finds the same to {apart:+.1e})"
        parts.append(text + ".")
    verdict = summary.verification
    if verdict is not None:
        worst = []
        for name, ratios in (("velocity", verdict.velocity_ratio), ("acceleration", verdict.acceleration_ratio),
                             ("jerk", verdict.jerk_ratio)):  # fmt: skip
            at = int(np.argmax(ratios))
            worst.append(f"{name} {ratios[at]:.4f} ({joints[at]})")
        parts.append(f"Worst of the limits in the written numbers: {', '.join(worst)}; feed {verdict.feed_ratio:.4f}.")
        parts.append(
            f"Farthest from the programmed path: tip {verdict.tip_deviation_mm:.6f} mm, "
            f"axis {verdict.axis_deviation_deg:.6f} deg."
        )
    if summary.feed_segments and as_planned:
        text = f"The programmed feed is reached on {summary.feed_reached} of {summary.feed_segments} feed moves"
        if verdict is not None and verdict.slow:
            first = sorted(verdict.slow.items(), key=lambda item: -item[1])[:3]
            why = ", ".join(f"{kind} of {joint} {seconds:.3f} s" for (kind, joint), seconds in first)
            text += f"; {sum(verdict.slow.values()):.3f} s are below it, nearest to its limit then: {why}"
        parts.append(text + ".")
    parts += _free_turn(summary)
    parts += remarks(summary)
    parts += _stops(summary)
    if options.decimals is not None or any(drive.integer for drive in summary.format.drives):
        parts.append(_rounding(summary))
    assumed = [group for group, source in machine.provenance.items() if source.startswith("assumed")]
    if assumed:
        parts.append(f"Assumed values of the machine file, not measured ones: {', '.join(assumed)}.")
    return textwrap.fill(" ".join(parts), width=100, break_on_hyphens=False) + "\n"


def _taken_up(summary: Summary) -> list[str]:
    """Where a restart begins, and what must be as the skipped blocks would have left it."""
    if summary.options.from_line is None:
        return []
    shown = {"tool": "tool {number}", "spindle": "spindle {direction} at {speed:g}/min", "coolant": "coolant {state}",
             "override": "overrides switched off by M48 to M53", "signal": "output {output} as line {line} sets it",
             "remapped": "{code} of line {line}"}  # fmt: skip
    on = [shown[event.kind].format(line=event.line, **event.data) for event in summary.switched]
    said = f"; before the start there must be: {', '.join(on)}" if on else ""
    return [f"Taken up at line {summary.options.from_line}{said}."]


def _dry_run(summary: Summary) -> list[str]:
    options, said = summary.options, []
    if options.air:
        along = "the tool axis" if options.air_along == "tool" else "the table's normal"
        said.append(f"Dry run: everything is lifted by {options.air:g} mm along {along}.")
    if options.override != 1.0:
        said.append(f"All motion is played at {100 * options.override:g} % of its planned speed.")
    if options.slow_start:
        said.append(f"It begins at a tenth of its speed, and reaches it within {options.slow_start:g} s.")
    return said


def _keep_out(summary: Summary) -> list[str]:
    """What was kept out of, and which bodies nobody has told the size of."""
    options, bodies = summary.options, summary.machine.bodies
    names = [box.name for box in options.keep_out] + ([options.stock.name] if options.stock else [])
    if not names:
        return []
    used = {int(str(event.data["number"])) for event in summary.events if event.kind in ("tool", "tool number")} or {0}
    tools = options.tools or {}
    thin = [f"tool {number}" if number else "the tool" for number in sorted(used)
            if number not in options.tool_shapes and not (number in tools and tools[number].diameter > 0)]  # fmt: skip
    unknown = [what for what, known in (("spindle", bodies and bodies.spindle_radius), ("platform", bodies and bodies.platform))
               if not known]  # fmt: skip
    said = f"Kept out of: {', '.join(names)}"
    if thin:
        said += f"; without a diameter, and so taken as a thin line: {', '.join(thin)}"
    if unknown:
        said += f"; without a size in the machine file, and so not looked at: {', '.join(unknown)}"
    return [said + "."]


def _tools(summary: Summary) -> list[str]:
    """Lengths of the tools: nobody may have said one."""
    said = [(f"tool {number} " if number else "") + f"{length:g} mm" for number, length in summary.tools]
    where = " (--tool-length)" if summary.options.tool_length is not None else ""
    if any(length == 0 for _number, length in summary.tools):
        where = (
            " (--tool-length)"
            if summary.options.tool_length == 0
            else " (no length is in force: G49, or none was said)"
        )
    return [f"Tool length: {', '.join(said)}{where}."]


def _offsets(summary: Summary) -> list[str]:
    said = []
    for frame in summary.frames:
        name = SYSTEM_NAMES[frame.system]
        x, y, z = (value - origin for value, origin in zip(
            frame.origin[:3], summary.machine.coordinates.work_origin((0.0, 0.0, 0.0)), strict=True))  # fmt: skip
        turn = f", part turned {frame.part_turn:g} deg" if frame.part_turn else ""
        place = f"{name} at ({x:g}, {y:g}, {z:g}) mm on the table{turn}"
        given = summary.options.wcs.get(frame.system)
        if given is not None and max(abs(a - b) for a, b in zip((x, y, z), given.origin_mm, strict=True)) > 1e-9:
            place += " (the program sets it with G10: --wcs does not hold)"
        if (x, y, z) == (0.0, 0.0, 0.0) and not frame.part_turn and given is None:
            place = f"{name} at the rotary centre on the table face (no offset was said)"
        if place not in said:
            said.append(place)
    return [f"Work offset: {'; '.join(said)}."]


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


def _stops(summary: Summary) -> list[str]:
    skipped = {id(event) for event in summary.switched}
    stops = [
        event
        for event in summary.events
        if id(event) not in skipped and event.waits(optional_stop=summary.options.optional_stop)
    ]
    if not stops:
        return []
    shown = {"tool": "tool {number}", "input": "wait for input {input}", "stop": "{stop} stop"}
    names = [f"line {event.line} {shown[event.kind].format(**event.data)}" for event in stops]
    between = {id(event) for part in summary.parts[:-1] for event in part.then}
    behind = {id(event) for part in summary.parts[-1:] for event in part.then}
    groups: tuple[list[str], list[str], list[str]] = ([], [], [])
    for event, text in zip(stops, names, strict=True):
        groups[1 if id(event) in between else 2 if id(event) in behind else 0].append(text)
    heads = (
        "For a person to do before the start", f"Cut into {len(summary.parts)} parts; for a person to do between them",
        "For a person to do at the end",
    )  # fmt: skip
    return [f"{head}: {'; '.join(texts)}." for head, texts in zip(heads, groups, strict=True) if texts]


def _rounding(summary: Summary) -> str:
    acceleration, jerk = rounding_noise(summary.machine, summary.format)
    parts = [
        f"{column.joint} {a:.3g} {column.unit}/s2 and {j:.3g} {column.unit}/s3"
        for column, a, j in zip(summary.machine.columns, acceleration, jerk, strict=True)
    ]
    return f"Rounding of the written numbers may add {'; '.join(parts)} to the differences."


def meta(summary: Summary) -> str:
    """Side-car JSON: what was made from what, and how well. The same input gives the same bytes."""
    from verne_post import __version__

    machine, verdict = summary.machine, summary.verification
    joints = [column.joint for column in machine.columns]
    data: dict[str, object] = {
        "schema": SIDE_CAR_SCHEMA,
        "version": __version__,
        "program": {"name": summary.options.source_name, "sha256": sha256(summary.source)},
        "machine": {"name": machine.name, "sha256": machine.sha256, "provenance": machine.provenance},
        "options": summary.options.record(),
        "columns": {
            "names": list(column_names(machine.columns, summary.format.drives)),
            "decimals": list(summary.format.decimals),
            "rounding_jerk_share": ROUNDING_SHARES[2],
        },
        "cycle_s": summary.format.cycle,
        "rows": summary.n_rows,
        "machining_time_s": summary.cycle_time,
        "segments": summary.n_segments,
        "stops": summary.n_stops,
        "corners_rounded": summary.n_blended,
        "flowing_s": summary.continuous_time,
        "second_order_bound_s": summary.second_order_bound_s,
        "second_order_bound_toppra_s": summary.toppra_bound_s,
        "tolerance": {"tip_mm": summary.tolerance[0], "axis_deg": DEG_PER_RAD * summary.tolerance[1]},
        "first_row": list(summary.start),
        "feed_moves": {"all": summary.feed_segments, "feed_reached": summary.feed_reached},
    }
    if (turn := summary.free_turn) is not None:
        factor = machine.columns[-1].factor
        data["free_c"] = {
            "c_deg_before": turn.before * factor,
            "c_deg": turn.chosen * factor,
            "margin_before": turn.margin_before if np.isfinite(turn.margin_before) else None,
            "margin": turn.margin,
            "nearest": turn.nearest,
        }
    if verdict is not None:
        data["verification"] = {
            "velocity_ratio": dict(zip(joints, verdict.velocity_ratio.tolist(), strict=True)),
            "acceleration_ratio": dict(zip(joints, verdict.acceleration_ratio.tolist(), strict=True)),
            "jerk_ratio": dict(zip(joints, verdict.jerk_ratio.tolist(), strict=True)),
            "feed_ratio": verdict.feed_ratio,
            "feed_line": verdict.feed_line,
            "below_feed_s": {f"{kind} of {joint}": seconds for (kind, joint), seconds in sorted(verdict.slow.items())},
            "tip_deviation_mm": verdict.tip_deviation_mm,
            "axis_deviation_deg": verdict.axis_deviation_deg,
        }
    return json.dumps(data, indent=2, allow_nan=False) + "\n"


def verdict_line(name: str, verdict: Verification, machine: Machine) -> str:
    """What `verify` says of a file."""
    word = "passes" if verdict.ok else "FAILS"
    ratios = [
        f"{what} {ratio.max():.4f} ({machine.columns[int(np.argmax(ratio))].joint})"
        for what, ratio in (("velocity", verdict.velocity_ratio), ("acceleration", verdict.acceleration_ratio),
                            ("jerk", verdict.jerk_ratio))
    ]  # fmt: skip
    return (
        f"{name} {word}: {verdict.n_rows} rows; worst of the limits: {', '.join(ratios)}, feed {verdict.feed_ratio:.4f}; "
        f"tip {verdict.tip_deviation_mm:.6f} mm and axis {verdict.axis_deviation_deg:.6f} deg from the programmed path."
    )


def following_text(name: str, found: Following, lines: NDArray[np.int32], cycle: float, machine: Machine) -> str:
    """What a log says, in plain sentences."""
    size = [abs(column.factor) for column in machine.columns]
    joints = ", ".join(
        f"{column.joint} {worst * factor:.6f} {column.unit} (rms {rms * factor:.6f})"
        for column, worst, rms, factor in zip(machine.columns, found.joint_worst, found.joint_rms, size, strict=True)
    )

    def at(row: int) -> str:
        return f"line {lines[row]}, {row * cycle:.3f} s"

    text = (
        f"{name}: {found.rows} rows, {found.delay} rows ({found.delay * cycle:g} s) behind the setpoints. Following error of the joints at "
        f"most: {joints}. The tip was at most {found.tip_worst:.6f} mm from where it was told to be at that time ({at(found.tip_row)}), and "
        f"{found.path_worst:.6f} mm from the commanded path ({at(found.path_row)}); the axis at most "
        f"{DEG_PER_RAD * found.axis_worst:.6f} deg ({at(found.axis_row)})."
    )
    return textwrap.fill(text, width=100, break_on_hyphens=False) + "\n"
