"""Files of readings, sliders and platform poses: CSV -> Readings. Every error names line, column and what is right."""

import math
from typing import Final

import numpy as np

from verne_post.base.units import RAD_PER_DEG
from verne_post.calibration.data import Readings
from verne_post.calibration.table import read_number, read_table, refuse_mistakes
from verne_post.config.kinds import KINDS
from verne_post.config.sentences import WrongTableError, check_table
from verne_post.model.findings import Finding, InputError, make_finding, make_input_error

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
    actuators : tuple of str
        Names of the actuated joints; their columns are ``name_mm``.

    Raises
    ------
    InputError
        With one finding (VP502) a mistake: line, column, value, and what would be right.
    """
    sliders = tuple(f"{name}_mm" for name in actuators)
    mistakes: list[Finding] = []
    table = read_table(raw, (*sliders, *POSITION), (*TILTS, SETTING, *REMARKS), mistakes)
    if all(name in table.header for name in TILTS):
        text = f"both {' and '.join(TILTS)} are given; keep one of them"
        raise make_input_error("VP502", text, line=table.header_line)
    values, settings, lines = [], [], []
    tilt = next((name for name in TILTS if name in table.header), None)
    for line, row in table.rows:
        numbers = [read_number(row[name], name, line, mistakes) for name in (*sliders, *POSITION)]
        alpha = math.nan
        if tilt and row[tilt]:
            alpha = TILTS[tilt] * read_number(row[tilt], tilt, line, mistakes)
        if SETTING in row and not row[SETTING]:
            mistakes.append(
                make_finding("VP502", f"{SETTING} is blank; expected a name or number of the setting", line=line)
            )
        values.append([*numbers, alpha])
        settings.append(row.get(SETTING) or f"line {line}")
        lines.append(line)
    if not values and not mistakes:
        mistakes.append(make_finding("VP502", "no row of values after the header", line=table.header_line))
    refuse_mistakes(mistakes)
    numbers_of = np.array(values)
    which = np.unique(settings, return_inverse=True)[1]
    data = Readings(numbers_of[:, : len(sliders)], numbers_of[:, len(sliders) :], which, np.array(lines))
    _check_settings(data, settings, sliders)
    return data


def _check_settings(data: Readings, settings: list[str], sliders: tuple[str, ...]) -> None:
    """Rows of one setting repeat its slider values."""
    mistakes = []
    first: dict[str, int] = {}
    for row, name in enumerate(settings):
        start = first.setdefault(name, row)
        for column in np.flatnonzero(data.rho[row] != data.rho[start]):
            text = (
                f"{sliders[column]} = {data.rho[row, column]:g}, but setting {name!r} has {data.rho[start, column]:g} "
                f"in line {data.line[start]}; rows of one setting share one reading of the sliders"
            )
            mistakes.append(make_finding("VP502", text, line=int(data.line[row])))
    if mistakes:
        raise InputError(*mistakes)


def explain_refused_lengths(kind: str, lengths: dict[str, float]) -> str | None:
    """Why a machine file of a kind would refuse these lengths as its [module]; None when it takes them."""
    try:
        check_table(KINDS[kind].schema, lengths, f"[module] of kind {kind!r}")
    except WrongTableError as error:
        return error.sentences[0]
    return None
