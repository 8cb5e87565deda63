"""Quintic splines through samples, and sliding windows: scipy's modules for both take longer to import."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.lapack import gbsv

#: Degree of the splines; through fewer than six samples it is that of the polynomial.
_DEGREE: Final = 5


def interpolate(x: Array, y: Array, at: Array) -> Array:
    """Values at ``at`` (m,) of the quintic spline through y (n,) at x (n,), which rises; its third knots are no knots.

    Outside x the first and last pieces go on.
    """
    degree = min(_DEGREE, len(x) - 1)
    inner = x[3:-3] if len(x) > _DEGREE + 1 else x[:0]
    knots = np.concatenate([x[:1].repeat(degree + 1), inner, x[-1:].repeat(degree + 1)])
    piece, weights = _evaluate_basis(knots, degree, x)
    band = np.zeros((3 * degree + 1, len(x)), order="F")
    for k, weight in enumerate(weights):
        column = piece - degree + k
        band[2 * degree + np.arange(len(x)) - column, column] = weight
    coefficients = gbsv(degree, degree, band, y, overwrite_ab=1)[2].reshape(-1)
    piece, weights = _evaluate_basis(knots, degree, at)
    total = np.zeros(len(at))
    for k, weight in enumerate(weights):
        total += coefficients[piece - degree + k] * weight
    return total


def resample_rows(rows: Array, at: Array, held: int = 1) -> Array:
    """Rows (..., m) at places ``at`` (..., m) among rising ``rows`` (n,); ``held`` rows at both ends stay exactly."""
    found = interpolate(np.arange(len(rows), dtype=float), rows, at.ravel()).reshape(at.shape)
    found[..., :held], found[..., -held:] = rows[:held], rows[-held:]
    return np.asarray(np.maximum.accumulate(np.clip(found, rows[0], rows[-1]), axis=-1))


def _evaluate_basis(knots: Array, degree: int, x: Array) -> tuple[Ints, list[Array]]:
    """The knot (n,) at or before each x (n,), and values there of the degree + 1 B-splines that are not 0 after it."""
    piece = np.clip(np.searchsorted(knots, x, side="right") - 1, degree, len(knots) - degree - 2)
    values = [np.ones(len(x))]
    for step in range(1, degree + 1):
        last, values = values, [np.zeros(len(x))]
        for k in range(step):
            after, before = knots[piece + k + 1], knots[piece + k + 1 - step]
            share = last[k] / (after - before)
            values[k] += share * (after - x)
            values.append(share * (x - before))
    return piece, values


def hold_ends(values: Array, before: int, after: int) -> Array:
    """Values (before + n + after,), constant beyond both ends: ``numpy.pad`` in a fifth of its time on short ones."""
    return np.concatenate([values[:1].repeat(before), values, values[-1:].repeat(after)])


def find_lowest_around(values: Array, reach: int) -> Array:
    """The least of values (n,) from ``reach`` before to ``reach`` after each; beyond both ends they stay."""
    lowest, width = hold_ends(values, reach, reach), 1
    while width < 2 * reach + 1:  # windows grow by overlapping ones
        step = min(width, 2 * reach + 1 - width)
        lowest = np.minimum(lowest[:-step], lowest[step:])
        width += step
    return lowest


def average_around(values: Array, reach: int) -> Array:
    """Mean of values (n,) from ``reach`` before to ``reach`` after each; beyond both ends they stay."""
    width = 2 * reach + 1
    padded = hold_ends(values, reach, reach)
    first = padded[:width].cumsum()[-1]
    return np.asarray(np.cumsum(np.append(first, padded[width:] - padded[:-width])) / width)
