"""Events beside the setpoints: spindle, coolant, tools, stops, messages, dwells, with time, line and axes (``--events``)."""

import csv
import io
import json

from verne_post.model.summary import Summary, TimedEvent
from verne_post.output.setpoints import column_names

#: Endings of file names, each a format.
SUFFIXES = (".csv", ".json")


def events_text(summary: Summary, suffix: str) -> str:
    """All events of a conversion as CSV or JSON; time counts from the beginning of the file that the row stands in."""
    names = column_names(summary.machine.columns, summary.format.drives)[1:-1]
    placed = [(*_place(summary, one), one) for one in summary.timed]
    if suffix == ".csv":
        text = io.StringIO()
        table = csv.writer(text, lineterminator="\n")
        table.writerow(["t_s", "row", "part", "line", "kind", "data", *names])
        for part, row, one in placed:
            data = json.dumps(one.event.data, allow_nan=False)
            table.writerow(
                [_time(summary, row), row, part, one.event.line, one.event.kind, data, *_numbers(summary, one)]
            )
        return text.getvalue()
    events = [
        {
            "t_s": float(_time(summary, row)), "row": row, "part": part, "line": one.event.line, "kind": one.event.kind,
            **one.event.data, "axes": {name: float(text) for name, text in zip(names, _numbers(summary, one), strict=True)},
        }
        for part, row, one in placed
    ]  # fmt: skip
    whole = {"schema": 1, "program": summary.options.source_name, "cycle_s": summary.format.cycle, "events": events}
    return json.dumps(whole, indent=2, allow_nan=False) + "\n"


def _place(summary: Summary, one: TimedEvent) -> tuple[int, int]:
    """Number of the part that an event falls into, from 1, and its row there; at a stop, the end of the part before."""
    for number, part in enumerate(summary.parts, start=1):
        if one.row <= part.last_row:
            return number, one.row - part.first_row
    raise AssertionError("an event behind the last row")


def _time(summary: Summary, row: int) -> str:
    return f"{row * summary.format.cycle:.{summary.format.time_decimals}f}"


def _numbers(summary: Summary, one: TimedEvent) -> list[str]:
    """The joints as the rows have them."""
    return [f"{value:.{d}f}" for value, d in zip(one.numbers, summary.format.decimals, strict=True)]
