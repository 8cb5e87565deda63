"""Distances of points, line segments and triangles from each other, exact."""

from itertools import product
from typing import Final

import numpy as np

from verne_post.base.arrays import Array

#: Squared length (mm2) below which a line segment counts as a point: its direction would be noise.
POINT: Final = 1e-18


def measure_between_segments(a0: Array, a1: Array, b0: Array, b1: Array) -> Array:
    """Distance of two line segments, each given by its ends (n, 3): (n,), mm.

    The squared distance is convex in both parameters: the unconstrained optimum, if it is inside, and otherwise the
    best of the four edges, each a point against a line segment.
    """
    u, v, w = a1 - a0, b1 - b0, a0 - b0
    uu, uv, vv = (u * u).sum(-1), (u * v).sum(-1), (v * v).sum(-1)
    uw, vw = (u * w).sum(-1), (v * w).sum(-1)
    best = np.minimum(
        np.minimum(measure_point_to_segment(a0, b0, b1), measure_point_to_segment(a1, b0, b1)),
        np.minimum(measure_point_to_segment(b0, a0, a1), measure_point_to_segment(b1, a0, a1)),
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = uu * vv - uv**2
        s, t = (uv * vw - vv * uw) / determinant, (uu * vw - uv * uw) / determinant
        inside = (determinant > 0) & (s > 0) & (s < 1) & (t > 0) & (t < 1)
        crossing = np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=-1)
    return np.where(inside, np.minimum(crossing, best), best)


def measure_point_to_segment(point: Array, start: Array, end: Array) -> Array:
    """Distance of points from line segments, all (n, 3): (n,), mm."""
    along = end - start
    square = (along * along).sum(-1)
    share = ((point - start) * along).sum(-1) / np.where(square > POINT, square, 1.0)
    share = np.where(square > POINT, np.clip(share, 0.0, 1.0), 0.0)
    return np.linalg.norm(point - start - share[:, None] * along, axis=-1)


def measure_between_triangles(a: Array, b: Array) -> Array:
    """Distance (n,) of triangles (n, 3, 3), mm; 0 where they cross or touch."""
    least = np.full(len(a), np.inf)
    for i, j in product(range(3), range(3)):
        ends = a[:, i], a[:, (i + 1) % 3], b[:, j], b[:, (j + 1) % 3]
        least = np.minimum(least, measure_between_segments(*ends))
    for one, other in ((a, b), (b, a)):
        normal = np.cross(other[:, 1] - other[:, 0], other[:, 2] - other[:, 0])
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        height = ((one - other[:, :1]) * normal[:, None]).sum(2)
        for k in range(3):
            foot = one[:, k] - height[:, k, None] * normal
            least = np.where(_is_inside(foot, other, normal), np.minimum(least, np.abs(height[:, k])), least)
            start, end = height[:, k], height[:, (k + 1) % 3]
            opposite = start * end < 0
            share = np.where(opposite, start, 0.0) / np.where(opposite, start - end, 1.0)
            point = one[:, k] + share[:, None] * (one[:, (k + 1) % 3] - one[:, k])
            least[opposite & _is_inside(point, other, normal)] = 0.0
    return least


def _is_inside(point: Array, triangle: Array, normal: Array) -> Array:
    """Whether points (n, 3) in the planes of triangles are inside these, seen along the normals."""
    inside = np.ones(len(point), dtype=bool)
    for k in range(3):
        side = triangle[:, (k + 1) % 3] - triangle[:, k]
        inside &= (np.cross(side, point - triangle[:, k]) * normal).sum(1) >= 0
    return inside
