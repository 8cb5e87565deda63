"""A conversion cut at its stops: one setpoint file a part, and an index that says what a person does between them."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import numpy as np

from verne_post.model.findings import InputError, finding
from verne_post.model.machine import Column
from verne_post.model.setpoints import SetpointBlock
from verne_post.model.summary import Part, Summary
from verne_post.output.setpoints import read_csv


def part_path(output: Path, number: int) -> Path:
    """``axes.csv`` -> ``axes.1.csv``."""
    return output.with_name(f"{output.stem}.{number}{output.suffix}")


def index_path(output: Path) -> Path:
    """``axes.csv`` -> ``axes.index.json``."""
    return output.with_name(f"{output.stem}.index.json")


def part_rows(spool: IO[str], header: str, part: Part, summary: Summary) -> Iterator[str]:
    """Text of one part, from a spool that stands at its first row; its time begins at 0."""
    fmt = summary.format
    yield header
    for row in range(part.last_row - part.first_row + 1):
        _time, _comma, rest = spool.readline().partition(",")  # two parts share no row: a stop lasts one cycle
        yield f"{row * fmt.cycle:.{fmt.time_decimals}f},{rest}"


def index(output: Path, summary: Summary) -> str:
    """The index as JSON: each part with its file, and what happens behind it."""
    parts = [
        {
            "file": part_path(output, number).name,
            "rows": part.last_row - part.first_row + 1,
            "duration_s": round((part.last_row - part.first_row) * summary.format.cycle, summary.format.time_decimals),
            "then": [{"line": event.line, "kind": event.kind, **event.data} for event in part.then],
        }
        for number, part in enumerate(summary.parts, start=1)
    ]
    data = {"schema": 1, "program": summary.options.source_name, "cycle_s": summary.format.cycle, "parts": parts}
    return json.dumps(data, indent=2, allow_nan=False) + "\n"


def read_parts(path: Path, columns: tuple[Column, ...], cycle: float) -> Iterator[SetpointBlock]:
    """Rows of all parts of an index, one behind the other.

    Raises
    ------
    InputError
        VP020: not an index, a part that cannot be read, or one that does not begin where the last one ended.
    """
    try:
        names = [str(part["file"]) for part in json.loads(path.read_text("utf-8"))["parts"]]
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(finding("VP020", f"{path}: not an index of parts: {error}")) from None
    first, last = 0, None
    for name in names:
        file = path.parent / Path(name).name
        try:
            stream = file.open(encoding="utf-8")
        except OSError as error:
            raise InputError(finding("VP020", f"{file}: {error.strerror}")) from None
        begin = first
        with stream:
            for block in read_csv(stream, str(file), columns, cycle):
                if block.first == 0 and last is not None and not np.array_equal(last, block.values[0]):
                    raise InputError(finding("VP020", f"{file}: does not begin where the part before it ended"))
                last, first = block.values[-1], begin + block.first + len(block.values)
                yield SetpointBlock(begin + block.first, block.values, block.line, block.format)
