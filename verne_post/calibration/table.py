"""Files of readings as tables: header, rows, numbers; every error names line, column and what is right."""

import csv
import difflib
import io
import math
from collections.abc import Sequence
from dataclasses import replace

from msgspec import Struct

from verne_post.base.file_kinds import describe_kind
from verne_post.base.long_text import count_line
from verne_post.base.numbers import read_number as read_plain
from verne_post.base.printable import join_names
from verne_post.base.text_marks import decode_text
from verne_post.base.tolerances import LARGEST_READING_MM
from verne_post.model.findings import Finding, InputError, make_finding, make_input_error, merge_same


class Table(Struct, frozen=True):
    """A CSV file: names of the columns, and each row's line and cells by name."""

    header: tuple[str, ...]
    header_line: int
    rows: tuple[tuple[int, dict[str, str]], ...]


#: What a column's number counts, by the end of its name.
_UNITS = {"_rad": "radians", "_deg": "degrees", "_mrad": "milliradians", "_mm": "millimetres"}


def read_table(raw: bytes, needed: Sequence[str], optional: Sequence[str], mistakes: list[Finding]) -> Table:
    """Read a table whose header names its columns in any order; blank lines and lines with # first are skipped.

    Rows with another number of cells are left out, with a mistake each.

    Raises
    ------
    InputError
        VP502: no text, or a header that is not right.
    """
    try:
        text = decode_text(raw)
    except UnicodeDecodeError as error:
        line = count_line(raw, error.start)
        raise make_input_error("VP502", "not UTF-8 text; expected a CSV file", line=line) from None
    rows = _read_rows(text)
    if not rows:
        raise make_input_error("VP502", f"no header line; expected the columns {', '.join(needed)}")
    head_line, cells = rows[0]
    header = tuple(name.strip() for name in cells)
    _check_header(header, head_line, needed, optional)
    found = []
    for line, cells in rows[1:]:
        if len(cells) != len(header):
            message = f"{len(cells)} values; expected {len(header)}, as many as the header in line {head_line} names"
            mistakes.append(make_finding("VP502", message, line=line))
            continue
        found.append((line, dict(zip(header, (cell.strip() for cell in cells), strict=True))))
    return Table(header, head_line, tuple(found))


def _read_rows(text: str) -> list[tuple[int, list[str]]]:
    """Line number and cells of every line that is neither blank nor a comment."""
    rows = []
    for line, content in enumerate(text.splitlines(), start=1):
        if content.strip() and not content.lstrip().startswith("#"):
            try:
                rows.append((line, next(csv.reader(io.StringIO(content)))))
            except csv.Error as error:
                raise make_input_error("VP502", f"not a row of cells: {error}", line=line) from None
    return rows


def _check_header(header: tuple[str, ...], line: int, needed: Sequence[str], optional: Sequence[str]) -> None:
    known = (*needed, *optional)
    if other := describe_kind(",".join(header).encode(), "a file of readings"):
        raise make_input_error("VP502", other, line=line)
    if len(header) == 1 and (mark := next((one for one in ";\t" if one in header[0]), "")):
        text = f"the names in its first line have {'a tab' if mark == chr(9) else mark} between them; write commas"
        raise make_input_error("VP502", text, line=line)
    if not any(name in known or difflib.get_close_matches(name, known, n=1) for name in header):
        text = f"no file of readings: no column of {', '.join(needed)} is named in its first line"
        raise make_input_error("VP502", text, line=line)
    mistakes, strange, meant = [], [], set()
    for column, name in enumerate(header):
        close = [] if name in known else difflib.get_close_matches(name, known, n=1)
        stem = f"{name.partition('_')[0]}_"  # x_inch is x_mm in a wrong unit
        close = close or [one for one in needed if name not in known and one not in header and one.startswith(stem)]
        if close:
            meant.add(close[0])
            text = f"column {name!r} is not known; did you mean {close[0]}?"
            mistakes.append(make_finding("VP502", text, line=line))
        elif name not in known:
            strange.append(repr(name))
        elif name in header[:column]:
            mistakes.append(make_finding("VP502", f"column {name} appears twice in the header", line=line))
    if strange:
        columns = f"column {strange[0]} is" if len(strange) == 1 else f"columns {join_names(strange)} are"
        mistakes.append(make_finding("VP502", f"{columns} not known; known are {', '.join(known)}", line=line))
    missing = [name for name in needed if name not in (*header, *meant)]  # a misspelt one is told above
    if missing:
        columns = f"column {missing[0]} is" if len(missing) == 1 else f"columns {join_names(missing)} are"
        text = f"{columns} missing in the header; expected {', '.join(needed)}"
        mistakes.append(make_finding("VP502", text, line=line))
    refuse_mistakes(mistakes)


def refuse_mistakes(mistakes: list[Finding]) -> None:
    """Raise InputError with all mistakes in the order of their lines, the same one once, if there are any."""
    if mistakes:
        merged = merge_same(sorted(mistakes, key=lambda item: item.line or 0))
        raise InputError(*(replace(item, worst_line=None) for item in merged))  # no line of a table is the worst


def read_number(cell: str, name: str, line: int, mistakes: list[Finding]) -> float:
    """The number of a cell; NaN, with a mistake, where it is none."""
    try:
        value = read_plain(cell)
    except ValueError:
        value = math.nan
    if math.isnan(value):
        what = "is blank" if not cell else f"= {cell!r} is not a finite number"
        unit = next((unit for end, unit in _UNITS.items() if name.endswith(end)), "a number")
        mistakes.append(make_finding("VP502", f"{name} {what}; expected {unit} with a decimal point", line=line))
    elif abs(value) > LARGEST_READING_MM:
        text = f"{name} = {value:g} is beyond {LARGEST_READING_MM:g}; no machine is so large"
        mistakes.append(make_finding("VP502", text, line=line))
    return value
