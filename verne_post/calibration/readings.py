"""Files of readings, sliders and platform poses: CSV -> Readings. Every error names line, column and what is right."""

import csv
import difflib
import io
import math
from typing import Final

import numpy as np
from pydantic import ValidationError

from verne_post.base.tolerances import LARGEST_READING_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.calibration.data import Readings
from verne_post.config.kinds import KINDS
from verne_post.model.findings import Finding, InputError, finding

#: Columns of a pose besides those of the actuators; the tilt comes in one of two units, or not at all.
POSITION: Final = ("x_mm", "y_mm", "z_mm")
TILTS: Final = {"alpha_deg": RAD_PER_DEG, "alpha_rad": 1.0}
#: Rows with the same text here share one reading of the sliders.
SETTING: Final = "setting"
#: Text for people, not read.
REMARKS: Final = ("case", "remark")


def read_readings(raw: bytes, actuators: tuple[str, ...]) -> Readings:
    """Read a file of measured poses.

    A header line names the columns in any order; blank lines and lines that begin with # are skipped.

    Parameters
    ----------
    raw : bytes
        UTF-8 text.
    actuators : tuple of str
        Names of the actuated joints; their columns are ``name_mm``.

    Raises
    ------
    InputError
        With one finding (VP502) a mistake: line, column, value, and what would be right.
    """
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise InputError(finding("VP502", "not UTF-8 text; expected a CSV file", line=line)) from None
    rows = _rows(text)
    sliders = tuple(f"{name}_mm" for name in actuators)
    if not rows:
        raise InputError(finding("VP502", f"no header line; expected the columns {', '.join((*sliders, *POSITION))}"))
    head_line, header = rows[0]
    header = [name.strip() for name in header]
    _check_header(header, head_line, sliders)
    mistakes: list[Finding] = []
    values, settings, lines = [], [], []
    wanted = [*sliders, *POSITION]
    tilt = next((name for name in TILTS if name in header), None)
    for line, cells in rows[1:]:
        if len(cells) != len(header):
            text = f"{len(cells)} values; expected {len(header)}, as many as the header in line {head_line} names"
            mistakes.append(finding("VP502", text, line=line))
            continue
        row = dict(zip(header, (cell.strip() for cell in cells), strict=True))
        numbers = [_number(row[name], name, line, mistakes) for name in wanted]
        alpha = math.nan
        if tilt and row[tilt]:
            alpha = TILTS[tilt] * _number(row[tilt], tilt, line, mistakes)
        if SETTING in row and not row[SETTING]:
            mistakes.append(
                finding("VP502", f"{SETTING} is blank; expected a name or number of the setting", line=line)
            )
        values.append([*numbers, alpha])
        settings.append(row.get(SETTING) or f"line {line}")
        lines.append(line)
    if not values and not mistakes:
        mistakes.append(finding("VP502", "no row of values after the header", line=head_line))
    if mistakes:
        raise InputError(*mistakes)
    table = np.array(values)
    which = np.unique(settings, return_inverse=True)[1]
    data = Readings(table[:, : len(sliders)], table[:, len(sliders) :], which, np.array(lines))
    _check_settings(data, settings, sliders)
    return data


def _rows(text: str) -> list[tuple[int, list[str]]]:
    """Line number and cells of every line that is neither blank nor a comment."""
    rows = []
    for line, content in enumerate(text.splitlines(), start=1):
        if content.strip() and not content.lstrip().startswith("#"):
            rows.append((line, next(csv.reader(io.StringIO(content)))))
    return rows


def _check_header(header: list[str], line: int, sliders: tuple[str, ...]) -> None:
    needed = (*sliders, *POSITION)
    known = (*needed, *TILTS, SETTING, *REMARKS)
    mistakes = []
    for column, name in enumerate(header):
        if name not in known:
            close = difflib.get_close_matches(name, known, n=1)
            hint = f"did you mean {close[0]}?" if close else f"known are {', '.join(known)}"
            mistakes.append(finding("VP502", f"column {name!r} is not known; {hint}", line=line))
        elif name in header[:column]:
            mistakes.append(finding("VP502", f"column {name} stands twice in the header", line=line))
    mistakes += [
        finding("VP502", f"column {name} is missing in the header; needed are {', '.join(needed)}", line=line)
        for name in needed
        if name not in header
    ]
    if all(name in header for name in TILTS):
        mistakes.append(finding("VP502", f"both {' and '.join(TILTS)} are given; keep one of them", line=line))
    if mistakes:
        raise InputError(*mistakes)


def _number(cell: str, name: str, line: int, mistakes: list[Finding]) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        what = "is blank" if not cell else f"= {cell!r} is not a finite number"
        unit = "radians" if name.endswith("_rad") else "degrees" if name.endswith("_deg") else "millimetres"
        mistakes.append(finding("VP502", f"{name} {what}; expected {unit} with a decimal point", line=line))
    elif abs(value) > LARGEST_READING_MM:
        text = f"{name} = {value:g} is beyond {LARGEST_READING_MM:g}; no machine is so large"
        mistakes.append(finding("VP502", text, line=line))
    return value


def _check_settings(data: Readings, settings: list[str], sliders: tuple[str, ...]) -> None:
    """Rows of one setting repeat its slider values."""
    mistakes = []
    first: dict[str, int] = {}
    for row, name in enumerate(settings):
        start = first.setdefault(name, row)
        for column in np.flatnonzero(data.rho[row] != data.rho[start]):
            text = (
                f"{sliders[column]} = {data.rho[row, column]:g}, but setting {name!r} has {data.rho[start, column]:g} in "
                f"line {data.line[start]}; rows of one setting share one reading of the sliders"
            )
            mistakes.append(finding("VP502", text, line=int(data.line[row])))
    if mistakes:
        raise InputError(*mistakes)


def refused_lengths(kind: str, lengths: dict[str, float]) -> str | None:
    """Why a machine file of a kind would refuse these lengths as its [module]; None when it takes them."""
    try:
        KINDS[kind].schema.model_validate(lengths)
    except ValidationError as error:
        first = error.errors()[0]
        return ".".join(str(part) for part in first["loc"]) + (": " if first["loc"] else "") + first["msg"]
    return None
