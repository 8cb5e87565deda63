"""A conversion cut at its stops: one setpoint file a part, and an index that says what a person does between them."""

import json
import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from verne_post.base.bounded import read_bounded
from verne_post.base.printable import format_json
from verne_post.model.drives import Drive
from verne_post.model.findings import InputError, make_input_error
from verne_post.model.machine import Column
from verne_post.model.moves import Event
from verne_post.model.setpoints import SetpointBlock
from verne_post.model.summary import Summary
from verne_post.output.setpoints import read_csv


def name_part(output: Path, number: int) -> Path:
    """``axes.csv`` -> ``axes.1.csv``."""
    return output.with_name(f"{output.stem}.{number}{output.suffix}")


def index_path(output: Path) -> Path:
    """``axes.csv`` -> ``axes.index.json``."""
    return output.with_name(f"{output.stem}.index.json")


def index_text(output: Path, summary: Summary) -> str:
    """Write the index as JSON: each part with its file, and what happens after it."""
    parts = [
        {
            "file": name_part(output, number).name,
            "rows": part.last_row - part.first_row + 1,
            "duration_s": round((part.last_row - part.first_row) * summary.format.cycle, summary.format.time_decimals),
            "then": _list_events(part.then),
        }
        for number, part in enumerate(summary.parts, start=1)
    ]
    data = {
        "schema": 1,
        "program": summary.options.source_name,
        "cycle_s": summary.format.cycle,
        "before": _list_events(summary.before),
        "parts": parts,
    }
    return format_json(data, 2) + "\n"


def _list_events(events: tuple[Event, ...]) -> list[dict[str, object]]:
    return [{"line": event.line, "kind": event.kind, **event.data} for event in events]


def is_derived(path: Path, output: Path) -> bool:
    """True for a name that a part, or the index, of ``output`` may have."""
    if os.path.realpath(path.parent) != os.path.realpath(output.parent):
        return False
    stem, suffix = re.escape(output.stem), re.escape(output.suffix)
    return re.fullmatch(rf"{stem}\.(?:index\.json|[0-9]+{suffix})", path.name) is not None


def list_parts(index_file: Path) -> list[Path]:
    """Files of the parts that an index names.

    Raises
    ------
    InputError
        VP020: not an index.
    """
    try:
        with index_file.open("rb") as file:
            names = [str(part["file"]) for part in json.loads(read_bounded(file))["parts"]]
        if any("\0" in name for name in names):
            raise ValueError("a name has a zero byte")
        return [index_file.parent / Path(name).name for name in names]
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise make_input_error("VP020", f"{index_file}: not an index of parts: {error}") from None


def find_index(part: Path) -> Path | None:
    """The index beside a setpoint file that names it as one of several parts."""
    index = part.with_name(f"{re.sub(r'[.][0-9]+$', '', part.stem)}.index.json")
    try:
        listed = list_parts(index)
    except InputError:
        return None
    return index if len(listed) > 1 and part in listed else None


def _read_text(blocks: Iterator[SetpointBlock], file: Path) -> Iterator[SetpointBlock]:
    try:
        yield from blocks
    except UnicodeDecodeError:
        raise make_input_error("VP020", f"{file}: no csv file; parts in another --format are not read") from None


def read_parts(
    path: Path, columns: tuple[Column, ...], cycle: float, stop_lines: Sequence[int], drives: tuple[Drive, ...]
) -> Iterator[SetpointBlock]:
    """Read the rows of all parts of an index, one after the other; ``stop_lines`` are where the program is to be cut.

    Raises
    ------
    InputError
        VP020: not an index, a part that cannot be read, or one that does not begin where the part before it ended.
    """
    files = list_parts(path)
    if len(files) != len(stop_lines) + 1:
        raise make_input_error("VP020", f"{path}: {len(files)} parts, and the program has {len(stop_lines)} stops")
    first, last = 0, None
    for number, file in enumerate(files):
        try:
            stream = file.open(encoding="utf-8-sig")
        except (OSError, ValueError) as error:
            raise make_input_error("VP020", f"{file}: {error}") from None
        begin, line = first, None
        with stream:
            for block in _read_text(read_csv(stream, str(file), columns, cycle, drives), file):
                if block.first == 0 and last is not None and not np.array_equal(last, block.values[0]):
                    raise make_input_error("VP020", f"{file}: does not begin where the part before it ended")
                last, first, line = block.values[-1], begin + block.first + len(block.values), int(block.line[-1])
                yield replace(block, first=begin + block.first)
        if number < len(stop_lines) and line != stop_lines[number]:
            raise make_input_error(
                "VP020", f"{file}: ends in line {line}, and the program stops in line {stop_lines[number]}"
            )
