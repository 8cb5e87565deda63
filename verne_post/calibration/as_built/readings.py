"""Files of readings of the tool on the table, and of measured lengths: CSV -> ToolReadings, LengthReadings.

The same columns are written, with blank cells to fill in, for poses that are still to be measured.
"""

import difflib
import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.tolerances import VECTOR_LENGTH
from verne_post.base.units import MILLI
from verne_post.calibration.as_built.data import LengthReading, ToolReadings
from verne_post.calibration.table import read_number, read_table, refuse_mistakes
from verne_post.model.deviations import RODS
from verne_post.model.findings import Finding, make_finding, make_input_error
from verne_post.model.machine import Machine

LENGTH: Final = "tool_length_mm"
TIP: Final = ("x_mm", "y_mm", "z_mm")
AXIS: Final = ("i", "j", "k")
SIGMAS: Final = ("sigma_mm", "sigma_mrad")
#: Rows with the same text in one of these share an unknown place; those of a frame share unknown directions too.
STATIONS: Final = ("sphere", "frame")
#: Text for people, not read.
REMARKS: Final = ("case", "remark")
#: Columns of a file of measured lengths.
LENGTHS: Final = ("length", "value_mm", "sigma_mm")


def read_tool_readings(raw: bytes, machine: Machine, sigma_mm: float, sigma_mrad: float) -> tuple[ToolReadings, int]:
    """Read a file of measured tools, and how many of its rows have no measured value yet; those are left out.

    Parameters
    ----------
    machine : Machine
        Its columns are the joints, in the units and senses of its setpoint files.
    sigma_mm, sigma_mrad : float
        Standard uncertainties of rows that state none.

    Raises
    ------
    InputError
        With one finding (VP502) a mistake.
    """
    joints = tuple(column.header for column in machine.columns)
    mistakes: list[Finding] = []
    table = read_table(raw, (*joints, LENGTH, *TIP), (*AXIS, *SIGMAS, *STATIONS, *REMARKS), mistakes)
    if 0 < len(set(AXIS) & set(table.header)) < len(AXIS):
        text = "a tool axis has three columns, i, j and k; some of them are missing in the header"
        raise make_input_error("VP502", text, line=table.header_line)
    stations: dict[tuple[str, str], int] = {}
    rows: list[tuple[list[float], Array, Array, tuple[float, float], tuple[int, bool], int]] = []
    blank = 0
    for line, row in table.rows:

        def number(name: str, line: int = line, row: dict[str, str] = row) -> float:
            return read_number(row[name], name, line, mistakes)

        place = [number(name) for name in (*joints, LENGTH)]
        tip = np.array([number(name) if row[name] else math.nan for name in TIP])
        axis = np.full(3, math.nan)
        if any(row.get(name) for name in AXIS):
            axis = _normalise_axis(np.array([number(name) for name in AXIS]), line, mistakes)
        if not (np.isfinite(tip).any() or np.isfinite(axis).any()):
            blank += 1
            continue
        sigmas = [
            default if not row.get(name) else number(name)
            for name, default in zip(SIGMAS, (sigma_mm, sigma_mrad), strict=True)
        ]
        for name, value in zip(SIGMAS, sigmas, strict=True):
            if value <= 0:
                mistakes.append(
                    make_finding("VP502", f"{name} = {value:g}: an uncertainty must be greater than 0", line=line)
                )
        named = [(kind, row[kind]) for kind in STATIONS if row.get(kind)]
        if len(named) > 1:
            mistakes.append(
                make_finding("VP502", "both sphere and frame are given; a row is measured from one of them", line=line)
            )
        station = stations.setdefault(named[0], len(stations)) if named else -1
        rows.append((place, tip, axis, (sigmas[0], sigmas[1]), (station, bool(named) and named[0][0] == "frame"), line))
    if not rows and not mistakes:
        mistakes.append(make_finding("VP502", "no row has a measured value", line=table.header_line))
    refuse_mistakes(mistakes)
    places = np.array([row[0] for row in rows])
    sigma = np.array([row[3] for row in rows])
    return ToolReadings(
        joints=places[:, :-1] / [column.factor for column in machine.columns],
        length=places[:, -1],
        tip=np.array([row[1] for row in rows]),
        axis=np.array([row[2] for row in rows]),
        sigma_tip=sigma[:, 0],
        sigma_axis=MILLI * sigma[:, 1],
        station=np.array([row[4][0] for row in rows]),
        turned=np.array([row[4][1] for row in rows]),
        line=np.array([row[5] for row in rows]),
    ), blank


def _normalise_axis(axis: Array, line: int, mistakes: list[Finding]) -> Array:
    length = float(np.linalg.norm(axis))
    if math.isfinite(length) and abs(length - 1.0) > VECTOR_LENGTH:
        text = f"i, j, k has the length {length:.6f}; expected a unit vector from the tip to the spindle"
        mistakes.append(make_finding("VP502", text, line=line))
    return axis / length if length else axis


def read_length_readings(raw: bytes) -> tuple[LengthReading, ...]:
    """Read a file of measured lengths: "rod 3", "platform 1-2" or "slider 1-2", value and uncertainty in mm.

    Raises
    ------
    InputError
        With one finding (VP502) a mistake.
    """
    mistakes: list[Finding] = []
    table = read_table(raw, LENGTHS, REMARKS, mistakes)
    found = []
    for line, row in table.rows:
        name = row["length"]
        value, sigma = (read_number(row[key], key, line, mistakes) for key in LENGTHS[1:])
        if name not in _LENGTH_NAMES:
            close = difflib.get_close_matches(name, _LENGTH_NAMES, n=1)
            hint = (
                f"did you mean {close[0]!r}?" if close else "known are 'rod 1' to 'rod 6', 'platform 1-2', 'slider 3-4'"
            )
            mistakes.append(make_finding("VP502", f"length {name!r} is not known; {hint}", line=line))
            continue
        if value <= 0 or sigma <= 0:
            text = f"{name}: a length and its uncertainty must be greater than 0, got {value:g} and {sigma:g}"
            mistakes.append(make_finding("VP502", text, line=line))
        part, rods = _LENGTH_NAMES[name]
        found.append(LengthReading(part, rods, value, sigma, line))
    if not found and not mistakes:
        mistakes.append(make_finding("VP502", "no row of values after the header", line=table.header_line))
    refuse_mistakes(mistakes)
    return tuple(found)


def _list_length_names() -> dict[str, tuple[str, tuple[int, ...]]]:
    """Lengths by name. Ends of two legs stand on sliders of their own, so their distance is none of the machine's."""
    n = len(RODS)
    names: dict[str, tuple[str, tuple[int, ...]]] = {f"rod {rod + 1}": ("rod", (rod,)) for rod in range(n)}
    names |= {f"platform {a + 1}-{b + 1}": ("platform", (a, b)) for a in range(n) for b in range(a + 1, n)}
    names |= {f"slider {a + 1}-{a + 2}": ("slider", (a, a + 1)) for a in (0, 2, 4)}
    return names


_LENGTH_NAMES: Final = _list_length_names()


def format_readings(machine: Machine, joints: Array, length: Array, tip: Array) -> Iterator[str]:
    """Lines of a file of readings for joints (n, 5); tips (n, 3) that are NaN are blank cells, to be measured."""
    yield ",".join((*(column.header for column in machine.columns), LENGTH, *TIP, "remark")) + "\n"
    for row, (place, tool, measured) in enumerate(zip(joints, length, tip, strict=True), start=1):
        numbers = [f"{value * column.factor:.6f}" for value, column in zip(place, machine.columns, strict=True)]
        cells = ["" if math.isnan(value) else f"{value:.4f}" for value in measured]
        yield ",".join((*numbers, f"{tool:.10g}", *cells, f"pose {row}")) + "\n"
