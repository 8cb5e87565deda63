"""Setpoint files in the default format: comma separated text, written and read."""

from collections.abc import Iterator
from typing import IO, Any, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.model.drives import Drive
from verne_post.model.findings import make_input_error
from verne_post.model.machine import Column
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.output.cells import describe_first_wrong
from verne_post.output.fixed_point import format_rows
from verne_post.output.rounding import MAX_DECIMALS, choose_time_decimals, convert_positions, name_column

_READ_ROWS: Final = 8192
#: Characters: no row has so many, and a file without line ends is not read into memory as one.
_LONGEST_LINE = 1 << 16
#: Characters of a wrong header that a message quotes.
_SHOWN = 200
#: Behind a message about a file of another format.
READS: Final = "verify reads what --format csv writes"


def name_joints(columns: tuple[Column, ...], drives: tuple[Drive, ...]) -> tuple[str, ...]:
    """Names of the columns of the joints, with what their numbers are: ``rho1_mm``."""
    return tuple(name_column(column, drives, index) for index, column in enumerate(columns))


def name_columns(columns: tuple[Column, ...], drives: tuple[Drive, ...]) -> tuple[str, ...]:
    """Names of all columns of a file, in the order of :func:`take_columns`."""
    return ("t_s", *name_joints(columns, drives), "line")


def take_columns(block: SetpointBlock) -> tuple[NDArray[Any], ...]:
    """The columns of a block, each of shape (rows,): time in s, joints as written, source line."""
    time = (block.first + np.arange(len(block.line))) * block.format.cycle
    return (time, *block.written.T, block.line)


def write_csv_header(columns: tuple[Column, ...], drives: tuple[Drive, ...]) -> str:
    """``t_s,rho1_mm,...,line``."""
    return ",".join(name_columns(columns, drives)) + "\n"


def write_csv_rows(block: SetpointBlock) -> str:
    """Rows of a block as text."""
    fmt = block.format
    return format_rows(list(take_columns(block)), [fmt.time_decimals, *fmt.decimals, 0], ",")


def read_csv(
    stream: IO[str], name: str, columns: tuple[Column, ...], cycle: float, drives: tuple[Drive, ...]
) -> Iterator[SetpointBlock]:
    """Read a setpoint file block by block.

    Parameters
    ----------
    columns : tuple of Column
        What the machine needs.
    cycle : float
        Control cycle in s; row k must stand at k * cycle.
    drives : tuple of Drive
        How the numbers count; empty for mm and degrees.

    Raises
    ------
    InputError
        VP020: wrong columns, something that is not a number, a row out of time.
    """
    expected = write_csv_header(columns, drives).strip()
    header = stream.readline(_LONGEST_LINE).strip()
    if header != expected:
        shown = header if len(header) <= _SHOWN else header[:_SHOWN] + "..."
        if not header:
            raise make_input_error("VP020", f"the file is empty, expected the columns {expected!r}", file=name)
        cells, names = header.split(","), expected.split(",")
        joints = [[cell.partition("_")[0] for cell in line] for line in (cells, names)]
        if _is_row(cells) and len(cells) == len(names):
            raise make_input_error("VP020", f"the header row {expected!r} is missing", file=name, file_line=1)
        if cells[0] != names[0] and set(joints[0]).isdisjoint(joints[1]):
            text = f"this is no setpoint file: its first line is {shown!r}, expected the columns {expected!r}; {READS}"
            raise make_input_error("VP020", text, file=name, file_line=1)
        text = f"the columns are {shown!r}, expected {expected!r}"
        if joints[0] == joints[1]:
            text += "; these joints are in other units, see --units"
        elif sorted(joints[0]) == sorted(joints[1]):
            text += "; they are in another order"
        elif set(cells) < set(names):
            missing = [one for one in names if one not in cells]
            are = "column is" if len(missing) == 1 else "columns are"
            text = f"{len(missing)} {are} missing: {', '.join(missing)}; expected {expected!r}"
        elif len(cells) == 1:
            text += "; write commas between them"
        else:
            text += "; give the --machine with which the file was made"
        raise make_input_error("VP020", text, file=name, file_line=1)
    first, fmt = 0, None
    while lines := [line for _, line in zip(range(_READ_ROWS), _split_lines(stream), strict=False)]:
        table = _parse_numbers(lines, len(columns) + 2, name, first)
        if fmt is None:
            fmt = _format_of(lines, cycle, drives)
        _check_time(table[:, 0], name, first, fmt)
        line = table[:, -1]
        bad = (line != np.round(line)) | (line < 0) | (line > np.iinfo(np.int32).max)
        if bad.any():
            row = int(np.argmax(bad))
            raise make_input_error("VP020", f"{line[row]:g} is not a line number", file=name, file_line=first + row + 2)
        numbers = table[:, 1:-1]
        yield SetpointBlock(first, convert_positions(numbers, fmt), line.astype(np.int32), fmt, numbers)
        first += len(lines)


def _is_row(cells: list[str]) -> bool:
    """Whether cells are numbers, as of a row."""
    try:
        return bool([float(cell) for cell in cells])
    except ValueError:
        return False


def _split_lines(stream: IO[str]) -> Iterator[str]:
    """Lines of a file; one without an end comes in pieces, which are no rows."""
    while line := stream.readline(_LONGEST_LINE):
        yield line


def _parse_numbers(lines: list[str], width: int, name: str, first: int) -> Array:
    """Parse rows (n, width), the first of which is row ``first`` of the file."""
    try:
        table = np.loadtxt(lines, delimiter=",", ndmin=2, comments=None)
        if table.shape == (len(lines), width) and np.isfinite(table).all():
            return table
    except ValueError:
        pass
    numbered = enumerate(lines, start=first + 2)
    raise describe_first_wrong(name, numbered, ",", width) or make_input_error(
        "VP020", f"rows {first + 2} to {first + len(lines) + 1} cannot be read", file=name, file_line=first + 2
    )


def _format_of(lines: list[str], cycle: float, drives: tuple[Drive, ...]) -> SetpointFormat:
    """Decimals as written: the most that a column has in the first rows."""
    counts = np.array([[len(cell.partition(".")[2]) for cell in line.strip().split(",")] for line in lines[:64]]).max(
        axis=0
    )
    return SetpointFormat(cycle, tuple(int(min(d, MAX_DECIMALS)) for d in counts[1:-1]), int(counts[0]), drives)


def _check_time(t: Array, name: str, first: int, fmt: SetpointFormat) -> None:
    """Refuse rows that are not at their time."""
    expected = (first + np.arange(len(t))) * fmt.cycle
    # half a unit of the last decimal that the cycle has; a time that leaves it out cannot tell rows apart
    allowed = (
        0.51 * 10.0 ** -max(choose_time_decimals(fmt.cycle), 3)
        if fmt.time_decimals >= choose_time_decimals(fmt.cycle)
        else 0.0
    )
    allowed = min(allowed, 0.05 * fmt.cycle)
    bad = np.flatnonzero(~(np.abs(t - expected) <= allowed))
    if len(bad):
        row = int(bad[0])
        raise make_input_error(
            "VP020",
            f"t_s is {t[row]:g} s, expected {expected[row]:g} s (row {first + row} at a cycle of {fmt.cycle:g} s)",
            file=name,
            file_line=first + row + 2,
        )
