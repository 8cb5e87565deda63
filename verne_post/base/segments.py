"""Distances of points, line segments and triangles from each other, exact."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.base.rows import find_row_min, measure_rows, sum_rows

#: Squared length (mm2) below which a line segment counts as a point: its direction would be noise.
POINT: Final = 1e-18
#: Pairs of triangles that are measured at a time: what lies between then stays in the processor's cache.
TOGETHER: Final = 1024
#: The corner after each of a triangle, and the sides of two triangles by pairs of them.
_NEXT: Final = np.array([1, 2, 0])
_SIDES: Final = np.divmod(np.arange(9), 3)


def measure_between_segments(a0: Array, a1: Array, b0: Array, b1: Array) -> Array:
    """Distance of two line segments, each given by its ends (n, 3): (n,), mm.

    The squared distance is convex in both parameters: the unconstrained optimum, if it is inside, and otherwise the
    best of the four edges, each a point against a line segment.
    """
    best = np.minimum(
        np.minimum(measure_point_to_segment(a0, b0, b1), measure_point_to_segment(a1, b0, b1)),
        np.minimum(measure_point_to_segment(b0, a0, a1), measure_point_to_segment(b1, a0, a1)),
    )
    return np.minimum(_measure_inside(a0, a1, b0, b1), best)


def _measure_inside(a0: Array, a1: Array, b0: Array, b1: Array) -> Array:
    """Distance (n,) of two line segments where both are nearest to each other between their ends; else infinite."""
    u, v, w = a1 - a0, b1 - b0, a0 - b0
    uu, uv, vv, uw, vw = (sum_rows(one * other) for one, other in ((u, u), (u, v), (v, v), (u, w), (v, w)))
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = uu * vv - uv**2
        s, t = (uv * vw - vv * uw) / determinant, (uu * vw - uv * uw) / determinant
        inside = (determinant > 0) & (s > 0) & (s < 1) & (t > 0) & (t < 1)
        return np.where(inside, measure_rows(w + s[:, None] * u - t[:, None] * v), np.inf)


def measure_point_to_segment(point: Array, start: Array, end: Array) -> Array:
    """Distance of points from line segments, all (n, 3): (n,), mm."""
    along = end - start
    square = sum_rows(along * along)
    share = sum_rows((point - start) * along) / np.where(square > POINT, square, 1.0)
    share = np.where(square > POINT, np.clip(share, 0.0, 1.0), 0.0)
    return measure_rows(point - start - share[:, None] * along)


def measure_between_triangles(a: Array, b: Array) -> Array:
    """Distance (n,) of triangles (n, 3, 3), mm; 0 where they cross or touch."""
    if len(a) <= TOGETHER:
        return _measure_some_triangles(a, b)
    parts = (slice(first, first + TOGETHER) for first in range(0, len(a), TOGETHER))
    return np.concatenate([_measure_some_triangles(a[part], b[part]) for part in parts])


def _measure_some_triangles(a: Array, b: Array) -> Array:
    n = len(a)
    if not n:
        return np.empty(0)
    # every side with every other: nine rows a pair of triangles
    a0, a1 = (one.reshape(-1, 3) for one in (a[:, _SIDES[0]], a[:, _NEXT[_SIDES[0]]]))
    b0, b1 = (one.reshape(-1, 3) for one in (b[:, _SIDES[1]], b[:, _NEXT[_SIDES[1]]]))
    corners = np.minimum(measure_point_to_segment(a0, b0, b1), measure_point_to_segment(b0, a0, a1))
    least = find_row_min(np.minimum(corners, _measure_inside(a0, a1, b0, b1)).reshape(n, 9))
    # the corners and sides of each against the plane of the other: three rows (2n, 3) a triangle
    one, other = np.concatenate([a, b]), np.concatenate([b, a])
    side = other[:, _NEXT] - other
    normal = _cross(side[:, 0], other[:, 2] - other[:, 0])
    normal = (normal / measure_rows(normal)[:, None])[:, None]
    inward = _cross(normal, side)
    start = sum_rows((one - other[:, :1]) * normal)
    end = start[:, _NEXT]
    inside = _is_inside(one - start[..., None] * normal, other, inward)
    height = find_row_min(np.where(inside, np.abs(start), np.inf))
    least = np.minimum(least, np.minimum(height[:n], height[n:]))
    opposite = start * end < 0
    share = np.where(opposite, start, 0.0) / np.where(opposite, start - end, 1.0)
    crossing = opposite & _is_inside(one + share[..., None] * (one[:, _NEXT] - one), other, inward)
    crosses = np.asarray(crossing.any(axis=1))
    least[crosses[:n] | crosses[n:]] = 0.0
    return least


def _cross(one: Array, other: Array) -> Array:
    """``np.cross`` of vectors (..., 3), which takes three times as long for a few of them."""
    x, y, z = (one[..., k] for k in range(3))
    u, v, w = (other[..., k] for k in range(3))
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)


def _is_inside(point: Array, triangle: Array, inward: Array) -> Mask:
    """Whether points (n, 3, 3), three in the plane of each triangle, are inside it; ``inward`` (n, 3, 3) are normals of
    its sides.
    """
    inside = np.ones(point.shape[:2], dtype=bool)
    for k in range(3):
        inside &= sum_rows((point - triangle[:, k : k + 1]) * inward[:, k : k + 1]) >= 0
    return inside
