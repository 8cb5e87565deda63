"""The metadata file of ``--meta``: what a setpoint file was made from, its quality, and whether it is up to date."""

import json
import math
import re
from collections.abc import Iterator
from typing import Any, Final

from msgspec import structs

from verne_post.base.long_text import Text, compute_sha256
from verne_post.base.printable import format_json
from verne_post.base.tolerances import ROUNDING_SHARES
from verne_post.base.units import DEG_PER_RAD
from verne_post.model.findings import Finding, make_finding, make_input_error
from verne_post.model.machine import Machine
from verne_post.model.options import OPTIONS, Changes, Options, find_about, find_key
from verne_post.model.summary import FreeTurn, Summary
from verne_post.model.verification import Verification
from verne_post.output.cells import blank_nonfinite
from verne_post.output.feed_hold import find_hold
from verne_post.output.formats import FORMATS
from verne_post.output.spool import WrittenRows

#: Version of the layout.
SIDE_CAR_SCHEMA: Final = 2
#: Names of options in messages, where the key does not say it.
_NAMES = {"wcs": "work offset", "tools": "tool"}
#: A SHA-256, and what is shown of it.
_SHA256: Final = re.compile(r"\b([0-9a-f]{12})[0-9a-f]{52}\b")


def describe_rows(summary: Summary) -> dict[str, str]:
    """What the rows of a conversion were made of, for formats that have a place for it."""
    from verne_post import __version__

    machine = summary.machine
    return {
        "version": __version__,
        "program": summary.options.source_name,
        "program_sha256": compute_sha256(summary.source),
        "machine": machine.name,
        "machine_sha256": machine.sha256,
        "cycle_s": repr(summary.format.cycle),
        "options": json.dumps(summary.options.record(), allow_nan=False),
    }


def format_side_car(summary: Summary, format_name: str, rows: WrittenRows) -> str:
    """Write the facts of a conversion as JSON. The same input gives the same bytes.

    Parameters
    ----------
    rows : WrittenRows
        As the format has them: those of joints that no drive follows, the last ones, may be missing.
    """
    from verne_post import __version__

    machine = summary.machine
    data: dict[str, object] = {
        "schema": SIDE_CAR_SCHEMA,
        "version": __version__,
        "program": {
            "name": summary.options.source_name,
            "sha256": compute_sha256(summary.source),
            "dialect": summary.language,
        },
        "machine": {"name": machine.name, "sha256": machine.sha256, "provenance": machine.provenance},
        "options": summary.options.record(),
        "format": format_name,
        "columns": {
            "names": list(FORMATS[format_name].name_columns(rows)),
            "decimals": list(rows.format.decimals),
            "rounding_jerk_share": ROUNDING_SHARES[2],
        },
        "cycle_s": summary.format.cycle,
        "rows": summary.n_rows,
        "machining_time_s": summary.cycle_time,
        "motion_s": summary.motion_time,
        "dwells_s": summary.dwell_time,
        "stops_s": summary.stop_time,
        "segments": summary.n_segments,
        "stops": summary.n_stops,
        "stops_within_lines": summary.stops_within.count,
        "corners_blended": summary.n_blended,
        "continuous_motion_s": summary.continuous_time,
        "second_order_bound_s": summary.second_order_bound_s,
        "second_order_bound_toppra_s": summary.toppra_bound_s,
        "tolerance": {"tip_mm": summary.tolerance[0], "axis_deg": DEG_PER_RAD * summary.tolerance[1]},
        "first_row": list(summary.start[: len(rows.columns)]),
        "feed_hold": _describe_hold(rows, machine),
        "feed_moves": {"all": summary.feed_segments, "feed_reached": summary.feed_reached},
    }
    if summary.shaped is not None:
        data["vibration"] = {
            "shaper": summary.shaped.shaper,
            "rest_s": summary.shaped.rest,
            "modes": [{"frequency_hz": frequency, "left": left} for frequency, left in summary.shaped.left],
        }
    if summary.arc_feeds:
        data["feed_on_arcs"] = [use.record() for use in summary.arc_feeds]
    if summary.stock is not None:
        data["stock"] = summary.stock.record()
    if summary.compared:
        data["part"] = list(summary.compared)
    if summary.free_turn is not None:
        data["free_c"] = _describe_free_turn(summary.free_turn, machine)
    if summary.verification is not None:
        data["verification"] = _record_verification(summary.verification, machine)
    return format_json(data, 2) + "\n"


def _describe_hold(rows: WrittenRows, machine: Machine) -> dict[str, float]:
    """How a player may stop: T of its curve in whole milliseconds, its ends, seconds of the clock and the file."""
    hold = find_hold(rows.take_driven(), machine.limits)
    seconds = math.ceil(1e3 * hold.seconds) / 1e3
    stop, ahead = (round(share * seconds, 3) for share in (hold.before + hold.after, hold.before))
    return {"T_s": seconds, "before_T": hold.before, "after_T": hold.after, "stop_s": stop, "runs_on_s": ahead}


def _describe_free_turn(turn: FreeTurn, machine: Machine) -> dict[str, object]:
    """What ``--free-c`` chose, in the sense of the machine file."""
    factor = machine.columns[-1].factor
    return {
        "c_deg_before": turn.before * factor,
        "c_deg": turn.chosen * factor,
        "margin_before": blank_nonfinite(turn.margin_before),
        "margin": turn.margin,
        "nearest": turn.nearest,
    }


def _record_verification(verdict: Verification, machine: Machine) -> dict[str, object]:
    """Ratios to the limits by joint, and deviations from the programmed path."""
    ratios = {
        name: dict(zip([column.joint for column in machine.columns], ratio.tolist(), strict=True))
        for name, ratio in (
            ("velocity_ratio", verdict.velocity_ratio),
            ("acceleration_ratio", verdict.acceleration_ratio),
            ("jerk_ratio", verdict.jerk_ratio),
        )
    }
    return {
        **ratios,
        "feed_ratio": verdict.feed_ratio,
        "feed_line": verdict.feed_line,
        "below_feed_s": dict(sorted(verdict.slow.items())),
        "timed_blocks": verdict.timed_blocks,
        "late_blocks": verdict.late_blocks,
        "latest_block": None if verdict.latest_block is None else structs.asdict(verdict.latest_block),
        "tip_deviation_mm": verdict.tip_deviation_mm,
        "axis_deviation_deg": verdict.axis_deviation_deg,
        "axis_error_deg": verdict.axis_error_deg,
    }


def read_side_car(text: str, name: str) -> dict[str, Any]:
    """Read what ``--meta`` wrote.

    Raises
    ------
    InputError
        VP020: not such a file.
    """
    why = "it is no JSON"
    try:
        data = json.loads(text)
        why = "it is JSON without schema, program.sha256, machine.sha256 or options"
        schema, _ = data["schema"], (data["program"]["sha256"], data["machine"]["sha256"], data["options"].items())
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        text = f"{name}: not a metadata file: {why}; give the file that --meta of convert wrote"
        raise make_input_error("VP020", text) from None
    if schema != SIDE_CAR_SCHEMA:
        text = (
            f"{name}: a metadata file of layout {schema}; this version reads layout {SIDE_CAR_SCHEMA}: convert the "
            "program again"
        )
        raise make_input_error("VP020", text)
    return dict(data)


def report_changes(side_car: dict[str, Any], source: Text, machine: Machine, options: Options) -> list[Finding]:
    """Report each difference from the time when the metadata file was written as VP414.

    Options that change the tool's motion are compared. The message has both values.
    """
    texts = []
    if side_car["program"]["sha256"] != compute_sha256(source):
        texts.append(f"the program is not the one that it was made from ({side_car['program'].get('name')})")
    if side_car["machine"]["sha256"] != machine.sha256:
        texts.append(f"the machine file is not the one that it was made with ({side_car['machine'].get('name')})")
    now = options.record()
    for name in OPTIONS:
        key = find_key(name)
        if find_about(name).changes == Changes.MOTION and key in now:
            before, after = side_car["options"].get(key), now[key]
            # a program that may call itself is among them
            if isinstance(before, dict) and isinstance(after, dict) and name == "subroutines":
                before = {file: sha for file, sha in before.items() if sha != side_car["program"]["sha256"]}
                after = {file: sha for file, sha in after.items() if sha != compute_sha256(source)}
            texts += _describe_differences(_NAMES.get(name, key), before, after)
    return [make_finding("VP414", f"the setpoint file is out of date: {text}") for text in texts]


def _describe_differences(name: str, before: object, now: object) -> Iterator[str]:
    """Say what changed in one option, key by key."""
    if before == now:
        return
    if isinstance(before, dict) and isinstance(now, dict):
        for key in sorted({*before, *now}):
            if before.get(key) != now.get(key):
                yield f"{name} {key} was {_show(before.get(key))}, and is {_show(now.get(key))}"
    else:
        yield f"{name} was {_show(before)}, and is {_show(now)}"


def _show(value: object) -> str:
    return "not given" if value is None else _SHA256.sub(r"\1", json.dumps(value))
