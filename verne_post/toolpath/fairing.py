"""Fairing: vertices of finely divided curves moved a little, so that their decimals do not shake the machine.

CAM systems write points with three or four decimals. At 0.2 mm from point to point that is an error of several
thousandths in direction at every vertex, which costs jerk. A smoothing spline through tip and table angles takes out
what is shorter than a dozen points; no vertex moves by more than a share of its tolerance, and sharp corners, stops
and the ends of a stretch do not move at all.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.columns import Growing
from verne_post.base.rows import row_norm

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Waves shorter than so many points are taken out.
POINTS: Final = 12.0
#: A stretch has at least so many vertices that may move.
SHORTEST: Final = 8
#: A vertex where the tip turns by more than this (rad) is a feature of the part.
FEATURE: Final = np.radians(15.0)
#: A segment so many times longer than the median of its stretch does not divide a curve finely.
LONG_SEGMENT: Final = 4.0
#: So many vertices of a stretch are faired at a time, and so many more on both sides, over which what holds the last one
#: dies away: by a factor of e in three vertices.
LONGEST: Final = 1 << 15
OVERLAP: Final = 256
#: Vertices are found to be features in so many rounds at most; a stretch that has hardly others is left as it is.
ROUNDS: Final = 8
MOSTLY_HELD: Final = 0.5


def fair(vertex: Array, s: Array, soft: Mask, tip_bound: Array, axis_bound: Array) -> Array:
    """Vertices (n + 1, 5), moved within bounds.

    Parameters
    ----------
    vertex : ndarray, shape (n + 1, 5)
        Tip (mm) and nominal angles (rad) at the corners of a path.
    s : ndarray, shape (n + 1,)
        Metric length at the corners, mm.
    soft : ndarray of bool, shape (n + 1,)
        Corners between straight feed moves that may be rounded, and are no :func:`features`.
    tip_bound, axis_bound : ndarray, shape (n + 1,)
        How far each may move, mm and rad; above 0 where it is soft.
    """
    moved = Growing(float, 5)
    for first, last, begin, end in _stretches(soft):
        moved.copy(vertex[moved.count : begin])
        rows = slice(first, last)
        moved.extend(_stretch(vertex[rows], s[rows], tip_bound[rows], axis_bound[rows])[begin - first : end - first])
    moved.copy(vertex[moved.count :])
    return moved.column()


def _stretches(soft: Mask) -> Iterator[tuple[int, int, int, int]]:
    """Stretches of soft vertices, with those at both ends, which hold still: (first, last + 1, first and last + 1 to keep).

    Of a long one so many are faired at a time, with others on both sides that are given up.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], soft, [False]]).astype(np.int8)))
    for first, last in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        if last - first < SHORTEST:
            continue
        for begin in range(first, last, LONGEST):
            end = min(begin + LONGEST, last)
            yield max(begin - OVERLAP, first) - 1, min(end + OVERLAP, last) + 1, begin, end


def features(vertex: Array, s: Array) -> Mask:
    """Vertices that are sharp corners of the part, or stand beside a segment far longer than its neighbours."""
    found = np.zeros(len(s), dtype=bool)
    way = np.diff(vertex[:, :3], axis=0)
    size = row_norm(way)
    cosine = np.sum(way[1:] * way[:-1], axis=1)
    sine = row_norm(np.cross(way[1:], way[:-1]))
    found[1:-1] = (np.arctan2(sine, cosine) > FEATURE) & (size[1:] > 0) & (size[:-1] > 0)
    length = np.diff(s)
    longer = np.maximum(length[1:], length[:-1]) > LONG_SEGMENT * np.minimum(length[1:], length[:-1])
    found[1:-1] |= longer
    return found


def _stretch(vertex: Array, s: Array, tip_bound: Array, axis_bound: Array) -> Array:
    """One stretch, its ends held. Vertices that would have to move too far are features, and are held as well."""
    held = np.zeros(len(s), dtype=bool)
    held[[0, -1]] = True
    # a cubic smoothing spline passes waves of length L by 1 / (1 + lam h (2 pi / L)^4)
    spacing = float(np.median(np.diff(s)))
    lam = (POINTS / (2 * np.pi)) ** 4 * spacing**3
    for _ in range(ROUNDS):
        change = _smoothing(vertex, s, held, lam)
        soft = np.flatnonzero(~held)
        ratio = np.maximum(
            row_norm(change[soft, :3]) / tip_bound[soft],
            row_norm(change[soft, 3:]) / axis_bound[soft],
        )
        far = soft[ratio > 1.0]
        if not len(far):
            return np.asarray(vertex + change)
        held[far] = True
        if held.mean() > MOSTLY_HELD:
            break
    return vertex


def _smoothing(values: Array, s: Array, held: Mask, lam: float) -> Array:
    """What the cubic spline that makes the sum of squared changes plus ``lam`` times its squared bending least changes.

    Values (n, k) at s (n,); those held do not change. With the second differences D of values over uneven steps and the
    Gram matrix G of the hat functions that second derivatives are made of, these are ``g = (G + lam D M D^T)^-1 D y``, M
    being 1 where a value may move, and the change is ``-lam M D^T g`` (Reinsch 1967). scipy's spline of this kind makes a
    basis point by point, which takes 20 times as long.
    """
    from scipy.linalg import solveh_banded

    h = np.diff(s)
    steps = np.stack([1.0 / h[:-1], -1.0 / h[:-1] - 1.0 / h[1:], 1.0 / h[1:]])  # D, row i over values i to i + 2
    moves = np.where(held, 0.0, lam)
    n = len(s) - 2
    band = np.zeros((3, n))  # the lower triangle, diagonal first
    band[0] = (h[:-1] + h[1:]) / 3 + sum(steps[k] ** 2 * moves[k : k + n] for k in range(3))
    band[1, :-1] = h[1:-1] / 6 + sum(steps[k + 1, :-1] * steps[k, 1:] * moves[k + 1 : k + n] for k in range(2))
    band[2, :-2] = steps[2, :-2] * steps[0, 2:] * moves[2:n]
    bends = sum(steps[k][:, None] * values[k : k + n] for k in range(3))
    bends = solveh_banded(band, bends, lower=True)
    change = np.zeros_like(values)
    for k in range(3):
        change[k : k + n] -= steps[k][:, None] * bends
    return change * moves[:, None]
