"""Position-velocity-time: lines ``dt,d1,v1,d2,v2,...``, each a cubic of every joint by its displacement and final velocity."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.output.file_format import FileFormat
from verne_post.output.spool import CHUNK_ROWS, WrittenRows
from verne_post.output.velocities import velocities_at

#: Cycles from knot to knot that are tried, the longest first.
KNOT_CYCLES: Final = (50, 20, 10, 5, 2, 1)
#: The cubics between knots may be so far from the rows, mm or degrees: a tenth of what verification allows the tip.
CUBIC_ERROR: Final = 1e-4


def write(rows: WrittenRows) -> Iterator[bytes]:
    """Write one line for each cubic; the last one ends at rest."""
    step, _error = choose_knots(rows)
    knots = _knots(len(rows.line), step)
    for first in range(0, len(knots) - 1, CHUNK_ROWS):
        chunk = knots[first : first + CHUNK_ROWS + 1]
        durations = np.diff(chunk) * rows.format.cycle
        # a displacement is the difference of rounded positions: it has their decimals, and adds up without an error
        displacements = np.diff(np.array(rows.numbers[chunk]), axis=0).tolist()
        velocities = velocities_at(rows, chunk)[1:].tolist()
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
    step, error = choose_knots(rows)
    errors = [f"{column.joint} {value:.1e} {column.unit}" for column, value in zip(rows.columns, error, strict=True)]
    return (
        "knots",
        f"every {step * rows.format.cycle:g} s; the cubics between them are off the rows by at most {', '.join(errors)}",
    )


def choose_knots(rows: WrittenRows) -> tuple[int, Array]:
    """Choose the longest of ``KNOT_CYCLES`` whose cubics keep ``CUBIC_ERROR``, or the shortest.

    Returns
    -------
    step : int
        Cycles from knot to knot.
    error : ndarray, shape (n_joints,)
        Largest distance of the cubics from the rows, mm or degrees.
    """
    scale = np.array([drive.scale for drive in rows.format.drives] or [1.0] * len(rows.columns))
    error = np.zeros(len(rows.columns))
    for step in KNOT_CYCLES:
        error = _cubic_error(rows, step) / scale
        if error.max() <= CUBIC_ERROR:
            break
    return step, error


def _knots(n: int, step: int) -> NDArray[np.intp]:
    """Rows that are knots: every ``step``-th of ``n``, and the last."""
    return np.append(np.arange(0, n - 1, step), n - 1)


def _cubic_error(rows: WrittenRows, step: int) -> Array:
    """Largest distance (n_joints,) of the cubics between knots from the rows, in units of the rows."""
    n = len(rows.line)
    knots, error = _knots(n, step), np.zeros(len(rows.columns))
    for first in range(0, n - 1, CHUNK_ROWS):
        at = np.arange(first, min(first + CHUNK_ROWS, n - 1))
        begin = np.searchsorted(knots, at, side="right") - 1
        low, high = knots[begin], knots[begin + 1]
        width = ((high - low) * rows.format.cycle)[:, None]
        f = ((at - low) / (high - low))[:, None]
        p0, p1 = np.array(rows.numbers[low]), np.array(rows.numbers[high])
        v0, v1 = velocities_at(rows, low) * width, velocities_at(rows, high) * width
        cubic = (
            (1 + 2 * f) * (1 - f) ** 2 * p0 + f * (1 - f) ** 2 * v0 + f * f * (3 - 2 * f) * p1 + f * f * (f - 1) * v1
        )
        error = np.maximum(error, np.abs(cubic - rows.numbers[at]).max(axis=0))
    return error


FORMAT: Final = FileFormat(write, ".pvt", describe=describe)
