"""Position-velocity-time: lines ``dt,d1,v1,...``, cubics of every joint by displacement and final velocity."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.output.expected import Expected
from verne_post.output.file_format import FileFormat
from verne_post.output.setpoints import is_row
from verne_post.output.spool import CHUNK_ROWS, WrittenRows

#: Most cycles from knot to knot.
LONGEST: Final = 50
#: Rows whose knots are chosen at a time, whole numbers of the longest distance.
_STRETCH: Final = LONGEST * 160
#: The cubics between knots may be so far from the rows, mm or degrees: a tenth of what verification allows the tip.
CUBIC_ERROR: Final = 1e-4


def write(rows: WrittenRows) -> Iterator[bytes]:
    """Write one line for each cubic; the last one ends at rest."""
    knots, _error = choose_knots(rows)
    for first in range(0, len(knots) - 1, CHUNK_ROWS):
        chunk = knots[first : first + CHUNK_ROWS + 1]
        durations = np.diff(chunk) * rows.format.cycle
        # a displacement is the difference of rounded positions: it has their decimals, and adds up without an error
        displacements = np.diff(np.array(rows.numbers[chunk]), axis=0).tolist()
        velocities = estimate_velocities(rows, chunk)[1:].tolist()
        lines = []
        for dt, displacement, velocity in zip(durations, displacements, velocities, strict=True):
            cells = [f"{dt:.{max(rows.format.time_decimals, 1)}f}"]
            for d, v, decimals in zip(displacement, velocity, rows.format.decimals, strict=True):
                # rounded before 0 is added, which takes the sign off a zero
                cells += [f"{round(number, decimals) + 0.0:.{decimals}f}" for number in (d, v)]
            lines.append(",".join(cells))
        yield ("\n".join(lines) + "\n").encode()


def describe(rows: WrittenRows) -> tuple[str, str]:
    """Say how far apart the knots are, and how far the cubics are from the rows."""
    knots, error = choose_knots(rows)
    errors = [f"{column.joint} {value:.1e} {column.unit}" for column, value in zip(rows.columns, error, strict=True)]
    apart = np.diff(knots) * rows.format.cycle if len(knots) > 1 else np.zeros(1)
    return (
        "knots",
        f"{len(knots)}, {apart.min():g} to {apart.max():g} s apart; the cubics between them are off the "
        f"rows by at most {', '.join(errors)}",
    )


def choose_knots(rows: WrittenRows) -> tuple[NDArray[np.intp], Array]:
    """Choose rows as knots, ``LONGEST`` cycles apart or as near as their cubics need.

    They keep ``CUBIC_ERROR``, and no cubic accelerates more than the rows do anywhere, as long as knots can be nearer.

    Returns
    -------
    knots : ndarray, shape (k,)
        Rows, the first and the last among them.
    error : ndarray, shape (n_joints,)
        Largest distance of the cubics from the rows, mm or degrees.
    """
    scale = np.array([drive.scale for drive in rows.format.drives] or [1.0] * len(rows.columns))
    peaks = _find_peak_accelerations(rows)
    last, error = len(rows.line) - 1, np.zeros(len(rows.columns))
    found = [np.zeros(1, dtype=np.intp)]
    for first in range(0, last, _STRETCH):
        knots = np.append(np.arange(first, min(first + _STRETCH, last), LONGEST), min(first + _STRETCH, last))
        while True:
            errors, accelerations = _measure_cubics(rows, knots)
            off = errors / scale
            wrong = (off.max(axis=1) > CUBIC_ERROR) | (accelerations > peaks).any(axis=1)
            coarse = np.flatnonzero(wrong & (np.diff(knots) > 1))
            if not len(coarse):
                break
            knots = np.sort(np.append(knots, (knots[coarse] + knots[coarse + 1]) // 2))
        error = np.maximum(error, off.max(axis=0))
        found.append(knots[1:])
    return np.concatenate(found), error


def _find_peak_accelerations(rows: WrittenRows) -> Array:
    """Largest second difference of the rows over the cycle (n_joints,), in units of the rows."""
    peaks = np.zeros(len(rows.columns))
    for first in range(0, len(rows.line), CHUNK_ROWS):
        part = np.array(rows.numbers[first : first + CHUNK_ROWS + 2])
        if len(part) > 2:
            peaks = np.maximum(peaks, np.abs(np.diff(part, n=2, axis=0)).max(axis=0))
    return np.asarray(peaks / rows.format.cycle**2)


def _measure_cubics(rows: WrittenRows, knots: NDArray[np.intp]) -> tuple[Array, Array]:
    """Largest distance from the rows, and largest acceleration, of each cubic between knots: (k - 1, n_joints) each."""
    at = np.arange(knots[0], knots[-1])
    begin = np.searchsorted(knots, at, side="right") - 1
    low, high = knots[begin], knots[begin + 1]
    width = ((high - low) * rows.format.cycle)[:, None]
    f = ((at - low) / (high - low))[:, None]
    places, speeds = np.array(rows.numbers[knots]), estimate_velocities(rows, knots)
    p0, p1, v0, v1 = places[begin], places[begin + 1], speeds[begin] * width, speeds[begin + 1] * width
    cubic = (1 + 2 * f) * (1 - f) ** 2 * p0 + f * (1 - f) ** 2 * v0 + f * f * (3 - 2 * f) * p1 + f * f * (f - 1) * v1
    off = np.abs(cubic - rows.numbers[knots[0] : knots[-1]])
    errors = np.asarray(np.maximum.reduceat(off, knots[:-1] - knots[0], axis=0))
    seconds = (np.diff(knots) * rows.format.cycle)[:, None]
    secant = np.diff(places, axis=0) / seconds
    # the acceleration of a cubic is linear: it is largest at an end
    at_ends = [6 * secant - 4 * speeds[:-1] - 2 * speeds[1:], -6 * secant + 2 * speeds[:-1] + 4 * speeds[1:]]
    return errors, np.maximum(*(np.abs(end) for end in at_ends)) / seconds


def name_columns(rows: WrittenRows) -> tuple[str, ...]:
    """``dt_s``, and displacement and final velocity of every joint: ``d_rho1_mm``, ``v_rho1_mm_per_s``."""
    return ("dt_s", *(cell for name in rows.name_joints() for cell in (f"d_{name}", f"v_{name}_per_s")))


def recognize(head: bytes, expected: Expected) -> bool:
    """A time, and two numbers for each joint."""
    cells = head.partition(b"\n")[0].decode("utf-8", "replace").split(",")
    return len(cells) == 1 + 2 * expected.driven and is_row(cells)


FORMAT: Final = FileFormat(write, ".pvt", name_columns, describe=describe, recognize=recognize)


def estimate_velocities(rows: WrittenRows, at: NDArray[np.intp]) -> Array:
    """Velocities of some rows by central differences of fourth order.

    Parameters
    ----------
    at : ndarray of int, shape (n,)
        Indices of rows.

    Returns
    -------
    ndarray, shape (n, n_joints)
        Units of the rows a second; 0 at the first and the last row, where the machine is at rest.
    """
    last = len(rows.numbers) - 1

    def shift_rows(rows_later: int) -> Array:
        return np.array(rows.numbers[np.clip(at + rows_later, 0, last)])

    velocities = (8.0 * (shift_rows(1) - shift_rows(-1)) - (shift_rows(2) - shift_rows(-2))) / (
        12.0 * rows.format.cycle
    )
    velocities[(at == 0) | (at == last)] = 0.0
    return np.asarray(velocities)
