"""Events beside the setpoints (``--events``): spindle, coolant, tools, stops, messages, dwells, with time and axes."""

import csv
import io

from verne_post.base.printable import format_json
from verne_post.model.summary import Summary, TimedEvent
from verne_post.output.setpoints import name_joints


def format_events(summary: Summary, suffix: str) -> str:
    """Write all events of a conversion as CSV or JSON; time counts from the beginning of the file that has the row."""
    names = name_joints(summary.machine.columns, summary.format.drives)
    placed = [(*_locate(summary, timed), timed) for timed in summary.timed]
    if suffix == ".csv":
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(["t_s", "row", "part", "line", "kind", "data", *names])
        for part, row, timed in placed:
            data = format_json(timed.event.data)
            table.writerow(
                [
                    _format_time(summary, row),
                    row,
                    part,
                    timed.event.line,
                    timed.event.kind,
                    data,
                    *_format_joints(summary, timed),
                ]
            )
        return text.getvalue()
    events = [
        {
            "t_s": float(_format_time(summary, row)),
            "row": row,
            "part": part,
            "line": timed.event.line,
            "kind": timed.event.kind,
            **timed.event.data,
            "axes": {name: float(text) for name, text in zip(names, _format_joints(summary, timed), strict=True)},
        }
        for part, row, timed in placed
    ]
    whole = {"schema": 1, "program": summary.options.source_name, "cycle_s": summary.format.cycle, "events": events}
    return format_json(whole, 2) + "\n"


def _locate(summary: Summary, timed: TimedEvent) -> tuple[int, int]:
    """Find the part of an event, from 1, and its row there; at a stop that is the end of the part before."""
    for number, part in enumerate(summary.parts, start=1):
        if timed.row <= part.last_row:
            return number, timed.row - part.first_row
    raise AssertionError("an event after the last row")


def _format_time(summary: Summary, row: int) -> str:
    """Time of a row as the setpoint file has it."""
    return f"{row * summary.format.cycle:.{summary.format.time_decimals}f}"


def _format_joints(summary: Summary, timed: TimedEvent) -> list[str]:
    """The joints as the rows have them."""
    return [f"{value:.{d}f}" for value, d in zip(timed.numbers, summary.format.decimals, strict=True)]
