"""A conversion cut at its stops: one setpoint file a part, and an index that says what a person does between them."""

import json
import os
import re
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import IO, Any, Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.bounded import read_bounded
from verne_post.base.numbers import format_count
from verne_post.base.printable import format_json
from verne_post.model.findings import Finding, InputError, make_finding, make_input_error
from verne_post.model.moves import Event
from verne_post.model.options import OPTIONS
from verne_post.model.setpoints import UNKNOWN_LINE, SetpointBlock
from verne_post.model.summary import Summary
from verne_post.output.expected import Expected
from verne_post.output.rounding import choose_time_decimals
from verne_post.output.setpoint_files import read_setpoints

#: What a part is called, and what opens it.
PartFile = tuple[str, Callable[[], IO[bytes]]]
#: What a program from a pipe is called.
STDIN: Final = "<stdin>"
#: What programs without a name are called: from a pipe, or as text in Python.
_NAMELESS: Final = frozenset({STDIN, OPTIONS["source_name"].default()})
_FOLDERS: Final = re.compile(r"[/\\]")
#: Characters of a value that a message shows.
_SHOWN: Final = 120


def name_part(output: Path, number: int) -> Path:
    """``axes.csv`` -> ``axes.1.csv``."""
    return output.with_name(f"{output.stem}.{number}{output.suffix}")


def index_path(output: Path) -> Path:
    """``axes.csv`` -> ``axes.index.json``."""
    return output.with_name(f"{output.stem}.index.json")


def index_text(output: Path, summary: Summary) -> str:
    """Write the index as JSON: each part with its file, and what happens after it."""
    rows = [part.last_row - part.first_row + 1 for part in summary.parts]
    files = [name_part(output, number).name for number in range(1, len(rows) + 1)]
    events = (summary.before, *(part.then for part in summary.parts))
    return format_json(_make_index(summary.options.source_name, summary.format.cycle, files, rows, events), 2) + "\n"


def _make_index(
    program: str, cycle: float, files: Sequence[str], rows: Sequence[int], events: Sequence[tuple[Event, ...]]
) -> dict[str, object]:
    """Make the index of parts; ``events`` come before the first one, and after each."""
    decimals = choose_time_decimals(cycle)
    parts = [
        {"file": file, "rows": n, "duration_s": round((n - 1) * cycle, decimals), "then": _list_events(then)}
        for file, n, then in zip(files, rows, events[1:], strict=True)
    ]
    return {"schema": 1, "program": program, "cycle_s": cycle, "before": _list_events(events[0]), "parts": parts}


def compare_index(
    path: Path, program: str, cycle: float, rows: Sequence[int], events: Sequence[tuple[Event, ...]]
) -> list[Finding]:
    """Report as VP414 each field of an index that a conversion would write otherwise.

    Files may have other names, and the program may be in another folder. It has no name from a pipe, and as text in
    Python.
    """
    index = _read_index(path)
    written, name = str(index.get("program")), _FOLDERS.split(program)[-1]
    if not _NAMELESS.isdisjoint((written, program)) or _FOLDERS.split(written)[-1] == name:
        name = written
    files = [part["file"] for part in index["parts"]]
    right = json.loads(format_json(_make_index(name, cycle, files, rows, events), 2))
    return [
        make_finding("VP414", f"{path.name} is not what a conversion writes: {text}")
        for text in _compare(index, right, "")
    ]


def _compare(found: object, right: object, place: str) -> Iterator[str]:
    """Say where two values of JSON differ, field by field; events of two lists only where there are as many."""
    if isinstance(found, dict) and isinstance(right, dict):
        for key in (*right, *(key for key in found if key not in right)):
            where = f"{place}.{key}" if place else str(key)
            if key not in found or key not in right:
                yield f"{where} is {'missing' if key in right else 'no field of an index'}"
            else:
                yield from _compare(found[key], right[key], where)
    elif isinstance(found, list) and isinstance(right, list) and len(found) == len(right):
        for number, (one, other) in enumerate(zip(found, right, strict=True)):
            yield from _compare(one, other, f"{place}[{number}]")
    elif found != right or isinstance(found, bool) != isinstance(right, bool):
        yield f"{place} is {_show(found)}; right is {_show(right)}"


def _show(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def _list_events(events: tuple[Event, ...]) -> list[dict[str, object]]:
    return [{"line": event.line, "kind": event.kind, **event.data} for event in events]


def is_derived(path: Path, output: Path) -> bool:
    """True for a name that a part, or the index, of ``output`` may have."""
    if os.path.realpath(path.parent) != os.path.realpath(output.parent):
        return False
    stem, suffix = re.escape(output.stem), re.escape(output.suffix)
    return re.fullmatch(rf"{stem}\.(?:index\.json|[0-9]+{suffix})", path.name) is not None


def find_derived(output: Path) -> list[Path]:
    """What is there with a name that a part, or the index, of ``output`` may have."""
    names = os.listdir(output.parent) if output.parent.is_dir() else []
    near = [output.with_name(name) for name in sorted(names) if name.startswith(f"{output.stem}.")]
    return [path for path in near if is_derived(path, output)]


def _read_index(index_file: Path) -> dict[str, Any]:
    """An index, whose parts have names of files.

    Raises
    ------
    InputError
        VP020: not an index.
    """
    try:
        with index_file.open("rb") as file:
            index = json.loads(read_bounded(file))
        names = [str(part["file"]) for part in index["parts"]]
        if any("\0" in name for name in names):
            raise ValueError("a name has a zero byte")
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise make_input_error("VP020", f"{index_file}: not an index of parts: {error}") from None
    return dict(index)


def list_parts(index_file: Path) -> list[Path]:
    """Files of the parts that an index names (VP020: not an index)."""
    return [index_file.parent / Path(str(part["file"])).name for part in _read_index(index_file)["parts"]]


def find_index(part: Path) -> tuple[Path, int, int] | None:
    """The index beside a setpoint file that names it as one of several parts; its number, and how many there are."""
    index = part.with_name(f"{re.sub(r'[.][0-9]+$', '', part.stem)}.index.json")
    try:
        listed = list_parts(index)
    except InputError:
        return None
    return (index, listed.index(part) + 1, len(listed)) if len(listed) > 1 and part in listed else None


def _open(file: Path) -> IO[bytes]:
    try:
        return file.open("rb")
    except (OSError, ValueError) as error:
        raise make_input_error("VP020", f"{file}: {error}") from None


def open_parts(index_file: Path) -> list[PartFile]:
    """The parts that an index names, for :func:`read_parts`."""
    return [(str(file), partial(_open, file)) for file in list_parts(index_file)]


def read_parts(
    parts: Sequence[PartFile],
    expected: Expected,
    stop_lines: Sequence[int],
    lines_around: Sequence[Sequence[int]],
    counts: list[int] | None = None,
) -> Iterator[SetpointBlock]:
    """Read the rows of all parts, one after the other; ``stop_lines`` are where the program is to be cut.

    A part without lines may end in any of ``lines_around`` its stop: at the place of the stop, all of them are.

    The name of ``expected`` is what all parts together are called. ``counts`` gets the number of rows of each part.

    Raises
    ------
    InputError
        VP020: other parts than the program has, a part that cannot be read, or one that does not begin where the part
        before it ended.
    """
    if len(parts) != len(stop_lines) + 1:
        has = f"{format_count(len(parts), 'part')}, and the program has {format_count(len(stop_lines), 'stop')}"
        raise make_input_error("VP020", f"{expected.name}: {has}")
    first, last = 0, None
    for number, (part, open_part) in enumerate(parts):
        begin, line, has_lines = first, None, True
        with open_part() as stream:
            for block in read_setpoints(stream, replace(expected, name=part)):
                if block.first == 0 and last is not None and not np.array_equal(last, block.values[0]):
                    raise make_input_error("VP020", f"{part}: does not begin where the part before it ended")
                last, first = block.values[-1], begin + block.first + len(block.values)
                has_lines = block.line[-1] != UNKNOWN_LINE
                yield replace(block, first=begin + block.first)
                line = int(block.line[-1])  # in a file without lines, as found by who has taken the block
        if counts is not None:
            counts.append(first - begin)
        if number == len(stop_lines) or line == stop_lines[number]:
            continue
        if has_lines or line not in (*lines_around[number], UNKNOWN_LINE):
            raise make_input_error(
                "VP020", f"{part}: ends in line {line}, and the program stops in line {stop_lines[number]}"
            )
