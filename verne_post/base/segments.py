"""Distances of points, line segments and triangles from each other, exact."""

from itertools import product
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.base.rows import measure_rows, sum_rows

#: Squared length (mm2) below which a line segment counts as a point: its direction would be noise.
POINT: Final = 1e-18


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
    least = np.full(len(a), np.inf)
    for i, j in product(range(3), range(3)):
        a0, a1, b0, b1 = a[:, i], a[:, (i + 1) % 3], b[:, j], b[:, (j + 1) % 3]
        corners = np.minimum(measure_point_to_segment(a0, b0, b1), measure_point_to_segment(b0, a0, a1))
        least = np.minimum(least, np.minimum(corners, _measure_inside(a0, a1, b0, b1)))
    for one, other in ((a, b), (b, a)):
        normal = np.cross(other[:, 1] - other[:, 0], other[:, 2] - other[:, 0])
        normal /= measure_rows(normal)[:, None]
        inward = [np.cross(normal, other[:, (k + 1) % 3] - other[:, k]) for k in range(3)]
        height = [sum_rows((one[:, k] - other[:, 0]) * normal) for k in range(3)]
        for k in range(3):
            start, end = height[k], height[(k + 1) % 3]
            foot = one[:, k] - start[:, None] * normal
            least = np.where(_is_inside(foot, other, inward), np.minimum(least, np.abs(start)), least)
            opposite = start * end < 0
            share = np.where(opposite, start, 0.0) / np.where(opposite, start - end, 1.0)
            point = one[:, k] + share[:, None] * (one[:, (k + 1) % 3] - one[:, k])
            least[opposite & _is_inside(point, other, inward)] = 0.0
    return least


def _is_inside(point: Array, triangle: Array, inward: list[Array]) -> Mask:
    """Whether points (n, 3) in the planes of triangles are inside these; ``inward`` are normals of the three sides."""
    inside = np.ones(len(point), dtype=bool)
    for k, normal in enumerate(inward):
        inside &= sum_rows((point - triangle[:, k]) * normal) >= 0
    return inside
