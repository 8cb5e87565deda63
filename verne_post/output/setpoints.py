"""Setpoint files in the default format: comma separated text, written and read."""

from collections.abc import Iterable, Iterator, Sequence
from typing import IO, Any, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.model.drives import Drive
from verne_post.model.findings import make_input_error
from verne_post.model.machine import Column
from verne_post.model.setpoints import UNKNOWN_LINE, SetpointBlock, SetpointFormat
from verne_post.output.cells import describe_first_wrong
from verne_post.output.expected import Expected
from verne_post.output.fixed_point import format_rows
from verne_post.output.rounding import MAX_DECIMALS, choose_time_decimals, convert_positions, name_column

#: Joints (n, n_joints), and times and lines (n,), or None where a file has none of them.
ExactTable = tuple[Array, NDArray[Any] | None, NDArray[Any] | None]
#: Rows of a block that is read.
READ_ROWS: Final = 8192
#: Characters: no row has so many, and a file without line ends is not read into memory as one.
_LONGEST_LINE = 1 << 16
#: Blocks at rest that wait for motion, which shows their decimals: a quarter of an hour in rows of a millisecond.
_AT_REST: Final = 128
#: Rows of a text that show its decimals.
_SEEN: Final = 64
#: Characters of a wrong header that a message quotes.
_SHOWN = 200
#: Behind a message about a file of another format.
READS: Final = "verify reads the rows of every --format but pvt and ros2"


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


def read_csv(stream: IO[str], file: Expected) -> Iterator[SetpointBlock]:
    """Read comma separated rows block by block.

    Raises
    ------
    InputError
        VP020: wrong columns, something that is not a number, a row out of time.
    """
    name = file.name
    expected = write_csv_header(file.columns, file.drives).strip()
    header = stream.readline(_LONGEST_LINE).strip()
    if header != expected:
        shown = header if len(header) <= _SHOWN else header[:_SHOWN] + "..."
        if not header:
            raise make_input_error("VP020", f"the file is empty, expected the columns {expected!r}", file=name)
        cells, names = header.split(","), expected.split(",")
        joints = [[cell.partition("_")[0] for cell in line] for line in (cells, names)]
        if is_row(cells) and len(cells) == len(names):
            raise make_input_error("VP020", f"the header row {expected!r} is missing", file=name, file_line=1)
        if cells[0] != names[0] and set(joints[0]).isdisjoint(joints[1]):
            text = f"this is no setpoint file: its first line is {shown!r}, expected the columns {expected!r}; {READS}"
            raise make_input_error("VP020", text, file=name, file_line=1)
        raise make_input_error("VP020", _describe_names(cells, names, shown), file=name, file_line=1)
    fmt = None
    for first, lines, table in read_tables(stream, name, ",", len(file.columns) + 2, 1):
        if fmt is None:
            cells_seen = [line.strip().split(",") for line in lines[:_SEEN]]
            times = max(len(cell[0].partition(".")[2]) for cell in cells_seen)
            fmt = _see_format([cell[1:-1] for cell in cells_seen], file, 1, times)
        _check_time(table[:, 0], name, first, fmt)
        yield make_block(first, table[:, 1:-1], table[:, -1], fmt, file)


def _describe_names(cells: list[str], names: list[str], shown: str) -> str:
    """Say how the names of columns differ from those that are expected."""
    expected = ",".join(names)
    joints = [[cell.partition("_")[0] for cell in line] for line in (cells, names)]
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
    return text


def check_names(cells: list[str], names: Sequence[str], file: str) -> None:
    """Refuse columns of other names (VP020)."""
    if cells != list(names):
        shown = ",".join(map(str, cells))[:_SHOWN]
        raise make_input_error("VP020", _describe_names([str(one) for one in cells], list(names), shown), file=file)


def read_tables(
    stream: IO[str], name: str, separator: str | None, width: int, header_lines: int
) -> Iterator[tuple[int, list[str], Array]]:
    """Index of the first row, lines and numbers (n, width) of each block of a text, after its header."""
    first = 0
    while lines := [line for _, line in zip(range(READ_ROWS), _split_lines(stream), strict=False)]:
        yield first, lines, _parse_numbers(lines, separator, width, name, first + header_lines + 1)
        first += len(lines)


def make_block(
    first: int, numbers: Array, line: NDArray[Any] | None, fmt: SetpointFormat, file: Expected
) -> SetpointBlock:
    """A block of numbers as written (n, n_driven or n_joints) and their lines (n,), or None where the file has none.

    The values of joints that no drive follows are 0 where the file has none: they count for nothing there.
    """
    head = fmt.header_lines
    if line is None:
        line = np.full(len(numbers), UNKNOWN_LINE)
    else:
        bad = (line != np.round(line)) | (line < 0) | (line > np.iinfo(np.int32).max)
        if bad.any():
            row = int(np.argmax(bad))
            where = f"row {first + row}: " if head is None else ""
            at = None if head is None else first + row + head + 1
            raise make_input_error("VP020", f"{where}{line[row]:g} is not a line number", file=file.name, file_line=at)
    if missing := len(file.columns) - numbers.shape[1]:
        numbers = np.concatenate([numbers, np.zeros((len(numbers), missing))], axis=1)
    return SetpointBlock(first, convert_positions(numbers, fmt), line.astype(np.int32), fmt, numbers)


def read_exact_blocks(
    tables: Iterable[ExactTable], file: Expected, header_lines: int | None = None
) -> Iterator[SetpointBlock]:
    """Blocks of tables; the decimals of their joints are seen in motion."""
    fmt, waiting = None, list[ExactTable]()
    time_decimals, first = choose_time_decimals(file.cycle), 0
    for table in _check_tables(tables, file):
        waiting.append(table)
        if fmt is None and (len(waiting) == _AT_REST or not (table[0] == waiting[0][0][0]).all()):
            fmt = _fill_format(_find_decimals(table[0]), time_decimals, file, header_lines)
        while fmt is not None and waiting:
            yield _make_exact_block(first, *waiting[0], fmt, file)
            first += len(waiting.pop(0)[0])
    for table in waiting:  # at rest from the first row to the last
        fmt = _fill_format(_find_decimals(table[0]), time_decimals, file, header_lines)
        yield _make_exact_block(first, *table, fmt, file)
        first += len(table[0])


def _make_exact_block(
    first: int,
    numbers: Array,
    t: NDArray[Any] | None,
    line: NDArray[Any] | None,
    fmt: SetpointFormat,
    file: Expected,
) -> SetpointBlock:
    if t is not None:
        _check_time(t, file.name, first, fmt)
    return make_block(first, numbers, line, fmt, file)


def _check_tables(tables: Iterable[ExactTable], file: Expected) -> Iterator[ExactTable]:
    """Refuse (VP020) tables that have not the joints of the machine, one time and one line a row, or numbers."""
    first = 0
    for numbers, t, line in tables:
        if numbers.ndim != 2 or numbers.shape[1] not in (len(file.columns), file.driven):
            raise make_input_error("VP020", f"the rows have not {len(file.columns)} joints", file=file.name)
        if any(one is not None and one.shape != numbers.shape[:1] for one in (t, line)):
            raise make_input_error("VP020", "the rows have not one time and one line each", file=file.name)
        bad = np.flatnonzero(~np.isfinite(numbers).all(axis=1))
        if len(bad):
            raise make_input_error("VP020", f"row {first + bad[0]} has no finite numbers", file=file.name)
        yield numbers, t, line
        first += len(numbers)


def _find_decimals(numbers: Array) -> list[int]:
    """Decimals that numbers (n, k) have; of a column at rest, which tells nothing, the most of the others."""
    found = []
    for column in numbers.T:
        if (column == column[0]).all():
            found.append(-1)
            continue
        fits = (d for d in range(MAX_DECIMALS) if (np.round(column, d) == column).all())
        found.append(next(fits, MAX_DECIMALS))
    most = max(found)
    return [(most if most >= 0 else MAX_DECIMALS) if one < 0 else one for one in found]


def is_row(cells: list[str]) -> bool:
    """Whether cells are numbers, as of a row."""
    try:
        return bool([float(cell) for cell in cells])
    except ValueError:
        return False


def _split_lines(stream: IO[str]) -> Iterator[str]:
    """Lines of a file; one without an end comes in pieces, which are no rows."""
    while line := stream.readline(_LONGEST_LINE):
        yield line


def _parse_numbers(lines: list[str], separator: str | None, width: int, name: str, file_line: int) -> Array:
    """Parse rows (n, width), the first of which is a line of the file."""
    try:
        table = np.loadtxt(lines, delimiter=separator, ndmin=2, comments=None)
        if table.shape == (len(lines), width) and np.isfinite(table).all():
            return table
    except ValueError:
        pass
    numbered = enumerate(lines, start=file_line)
    raise describe_first_wrong(name, numbered, separator, width) or make_input_error(
        "VP020", f"rows {file_line} to {file_line + len(lines) - 1} cannot be read", file=name, file_line=file_line
    )


def _see_format(rows: list[list[str]], file: Expected, header_lines: int, time_decimals: int = 0) -> SetpointFormat:
    """The format of a text: decimals as written, the most that a column has in the first rows."""
    counts = [max(len(cell.partition(".")[2]) for cell in column) for column in zip(*rows[:_SEEN], strict=True)]
    return _fill_format(counts, time_decimals, file, header_lines)


def _fill_format(decimals: list[int], time_decimals: int, file: Expected, header_lines: int | None) -> SetpointFormat:
    """A format of all columns: those that the file has not are exact."""
    whole = [min(d, MAX_DECIMALS) for d in decimals] + [MAX_DECIMALS] * (len(file.columns) - len(decimals))
    return SetpointFormat(file.cycle, tuple(whole), time_decimals, file.drives, header_lines)


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
            file_line=None if fmt.header_lines is None else first + row + fmt.header_lines + 1,
        )
