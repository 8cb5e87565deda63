"""Corners beside splines that curves pass faster than displacements do.

A displacement keeps every bend of a spline beside the corner: :mod:`verne_post.toolpath.curved_corners`. Where a spline
begins with a bend that is narrower than the tolerance, that bend sets the jerk. A curve of degree 7 from one end of the
reach to the other replaces it. Pose and three derivatives by s are those of the segments at both ends, and s stays the
same. Each pose of the program is passed within root 2 of the tolerances, so no bend is left out.
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import NO_REACH_MM
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath.corners import METRIC
from verne_post.toolpath.curved_corners import Displaced, JerkLimitAt, displace, find_beside, shorten_blends
from verne_post.toolpath.evaluate import differentiate_pose, evaluate_bernstein, evaluate_coordinates

#: Where both are compared, over the wider of both reaches.
_PLACES: Final = np.linspace(-1.0, 1.0, 65)


def put_curves(
    path: ToolPath,
    corner: Ints,
    most: Array,
    tolerances: tuple[Array, Array],
    blend: tuple[Array, Ints, Array],
    feed: Array,
    jerk_limit: JerkLimitAt,
) -> tuple[Array, Ints, Array]:
    """Replace blends at corners (m,) by curves where these are faster.

    Parameters are those of :func:`~verne_post.toolpath.curved_corners.blend_curved_corners`, ``blend`` is its result.

    Returns
    -------
    reach : ndarray, shape (m,)
    curve : ndarray of int, shape (m,)
        Row of the control points; -1 where there is no curve.
    controls : ndarray, shape (k, 8, 5)
    """
    reach, shape, jump = blend
    reach, curve = reach.copy(), np.full(len(corner), -1, dtype=np.int32)
    some = np.flatnonzero((path.spline[corner - 1] >= 0) | (path.spline[corner] >= 0))
    if not len(some):
        return reach, curve, np.empty((0, 8, 5))
    here, narrow, own, jumps = corner[some], reach[some], shape[some], jump[some]

    def follow_curves(which: Ints, wide: Array) -> Displaced:
        controls = find_controls(path, here[which], wide)
        return lambda row, x: _leave_path(path, here[which][row], x * wide[row], x, controls[row])

    wide = shorten_blends(path, here, most[some], follow_curves, (tolerances[0][some], tolerances[1][some]))
    size = np.stack([measure_rows(jumps[:, order] * METRIC) for order in range(3)])
    limits = np.stack([jerk_limit(here, jumps[:, order]) for order in range(3)])
    with np.errstate(invalid="ignore"):  # nothing limits what is not there
        limit = np.fmin.reduce(np.where(size > 0, limits * size, np.inf))
    every, way = np.arange(len(some)), np.maximum(narrow, wide)
    follow = follow_curves(every, np.maximum(wide, NO_REACH_MM))
    thirds = [
        _measure_thirds(path, here, way, part, displaced, limit / feed[some] ** 3)
        for part, displaced in ((narrow, lambda row, x: displace(jumps[row], narrow[row], own[row], x)), (wide, follow))
    ]
    faster = (wide > 0) & (thirds[1] < thirds[0])
    chosen = some[faster]
    reach[chosen], curve[chosen] = wide[faster], np.arange(len(chosen))
    return reach, curve, find_controls(path, here[faster], wide[faster])


def find_controls(path: ToolPath, corner: Ints, reach: Array) -> Array:
    """Control points (m, 8, 5) of curves that match pose and three derivatives by s at both ends of reaches (m,)."""
    controls = np.empty((len(corner), 8, 5))
    for first, sign in ((0, 1.0), (7, -1.0)):
        segment, u = find_beside(path, corner, -sign * reach, -sign)
        start = evaluate_coordinates(path, segment, u)
        one, two, three = (
            derivative * ((2.0 * sign * reach / path.length[segment]) ** order)[:, None]
            for order, derivative in enumerate(differentiate_pose(path, segment, u), start=1)
        )
        step = int(sign)
        controls[:, first] = start
        controls[:, first + step] = start + one / 7
        controls[:, first + 2 * step] = start + 2 * one / 7 + two / 42
        controls[:, first + 3 * step] = start + 3 * one / 7 + two / 14 + three / 210
    return controls


def _leave_path(path: ToolPath, corner: Ints, way: Array, x: Array, controls: Array) -> Array:
    """From the path to curves (n, 5), at x (n,) of their reaches."""
    return evaluate_bernstein(controls, 0.5 * (1.0 + x)) - evaluate_coordinates(
        path, *find_beside(path, corner, way, way)
    )


def _measure_thirds(
    path: ToolPath, corner: Ints, way: Array, reach: Array, displaced: Displaced, floor: Array
) -> Array:
    """Mean metric third derivative (m,) of blends within ``way`` (m,) of their corners, at least ``floor`` (m,).

    Of differences of poses. With blends that take equally long a bend counts by its width as well as by its size.
    """
    row, x = np.repeat(np.arange(len(corner)), len(_PLACES)), np.tile(_PLACES, len(corner))
    at = x * way[row]
    pose = evaluate_coordinates(path, *find_beside(path, corner[row], at, at))
    inside = np.flatnonzero(np.abs(at) < reach[row])
    pose[inside] += displaced(row[inside], at[inside] / reach[row[inside]])
    step = way * (_PLACES[1] - _PLACES[0])
    third = np.diff((pose * METRIC).reshape(len(corner), len(_PLACES), 5), 3, axis=1) / step[:, None, None] ** 3
    return np.asarray(np.maximum(np.linalg.norm(third, axis=2), floor[:, None]).mean(axis=1))
