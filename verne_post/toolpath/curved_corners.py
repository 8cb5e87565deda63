"""Corners beside arcs, splines and great circles: their jumps, and the shape and reach of each blend.

At such a corner the pose, as a function of metric length, jumps in its first three derivatives. The displacement

    J1 reach G(x) + J2 reach^2 G2(x) + J3 reach^3 G3(x),   x = (s - s of the corner) / reach,

takes all three out; the functions are those of :mod:`verne_post.toolpath.corner_shapes`. Between straight segments J2
and J3 are 0. Here a reach is in no proportion to the tolerance. So the reach of every shape is sought, then the shape
by the speed that the jerk limits allow; what the blend really uses of the tolerance is measured along the segments.
"""

from collections.abc import Callable
from functools import partial
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import measure_rows, sum_rows
from verne_post.base.units import ROTARY_METRIC_MM
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath.corner_shapes import (
    BRAKING,
    EVEN_PEAK,
    EVEN_THIRD,
    ODD_PEAK,
    ODD_THIRD,
    PEAK,
    SHAPES,
    THIRD,
    jump_values,
    shape_value,
)
from verne_post.toolpath.corners import LEAST_CYCLES, METRIC, USED_SHARE
from verne_post.toolpath.deviations import find_share_used
from verne_post.toolpath.evaluate import differentiate_pose, evaluate_coordinates

#: Where blends are measured, on each side: while a reach is sought, and at last.
_COARSE: Final = np.linspace(0.0, 0.875, 8)
_FINE: Final = np.linspace(0.0, 1.0, 33)[:-1]
#: Steps towards the reach of a shape. Each at least halves the distance that is left in the logarithm; the first guess
#: is at most three times the reach.
STEPS: Final = 5
#: Share of the feed rate. On 240 random programs 0.3 saves 0.13 % of the time, 0.5 and more 0.1 %.
BRAKED: Final = 0.3
#: A blend that leaves the tolerance is shortened by no more than this at a time, and so often.
SHORTENING: Final = 0.5
SHORTENINGS: Final = 24
#: Corners that are worked on at a time: enough that calls cost little, few enough that memory stays small.
AT_A_TIME: Final = 256
#: A blend with a smaller reach, mm, is a stop: the joints pass a corner of 1 rad blended so at 0.01 mm/s. Beside the
#: pole of the table, where C turns far over a few nanometres, planning fails on shorter ones.
LEAST_REACH: Final = 1e-5
#: Gauss-Newton steps to the nearest pose of a segment.
NEAREST: Final = 4

#: As of :func:`verne_post.toolpath.corners.choose_shapes`, along directions (m, 5) at corners (m,).
JerkLimitAt = Callable[[Ints, Array], Array]
#: Displacements (n, 5) at x (n,) of the blends in rows (n,).
Displaced = Callable[[Ints, Array], Array]
#: The same of some blends (m,) with reaches (m,).
Blend = Callable[[Ints, Array], Displaced]


def find_tangents(path: ToolPath, segment: Ints, u: float) -> Array:
    """Unit tangents (m, 5) by metric length at parameter u of segments."""
    slope = differentiate_pose(path, segment, np.full(len(segment), u))[0] / path.length[segment, None]
    slope[:, 3:] *= ROTARY_METRIC_MM
    return slope / np.linalg.norm(slope, axis=1, keepdims=True)


def find_derivatives(path: ToolPath, segment: Ints, u: float) -> Array:
    """First three derivatives (m, 3, 5) of tip and nominal angles by s, at parameter u of segments (m,)."""
    by_u = np.stack(differentiate_pose(path, segment, np.full(len(segment), u)), axis=1)
    return np.asarray(by_u / path.length[segment, None, None] ** np.arange(1, 4)[:, None])


def blend_curved_corners(
    path: ToolPath,
    corner: Ints,
    most: Array,
    tolerances: tuple[Array, Array],
    feed: Array,
    jerk_limit: JerkLimitAt,
    cycle: float,
    keeps_travel: Callable[[Array, Array], Mask],
) -> tuple[Array, Ints, Array]:
    """Choose the blends of corners between segments ``corner - 1`` and ``corner`` (m,).

    Parameters
    ----------
    most : ndarray, shape (m,)
        Largest reach that the segments allow, mm.
    tolerances : tuple of ndarray, shape (m,)
        Of tip and axis, mm and rad.
    feed : ndarray, shape (m,)
        ds/dt at the programmed feed rate, mm/s.
    cycle : float
        Control cycle, s.
    keeps_travel : callable
        As of :class:`~verne_post.toolpath.corner_rules.Smoothing`.

    Returns
    -------
    reach : ndarray, shape (m,)
        mm; 0 where the corner must be a stop.
    shape : ndarray of int, shape (m,)
    jump : ndarray, shape (m, 3, 5)
        Jumps of the first three derivatives by s.
    """
    reach, shape, jump = np.zeros(len(corner)), np.zeros(len(corner), dtype=np.int8), np.empty((len(corner), 3, 5))
    for first in range(0, len(corner), AT_A_TIME):
        some = slice(first, first + AT_A_TIME)
        here = corner[some]
        bounds = tolerances[0][some], tolerances[1][some]
        before, after = find_derivatives(path, here - 1, 1.0), find_derivatives(path, here, 0.0)
        jump[some] = after - before
        reaches = find_reaches(jump[some], (before[:, 0], after[:, 0]), most[some], bounds)
        limits = np.stack([jerk_limit(here, jump[some][:, order]) for order in range(3)])
        shape[some] = choose_curved_shapes(reaches, feed[some], limits, cycle)
        reach[some] = np.take_along_axis(reaches, shape[some, None], axis=1)[:, 0]
        swung = find_swung_out(path, here, jump[some], reach[some], shape[some], keeps_travel)
        shape[some][swung], reach[some][swung] = 0, reaches[swung, 0]
        reach[some] = shorten_blends(path, here, reach[some], partial(_displace_some, jump[some], shape[some]), bounds)
        if swung.any():
            reach[some][find_swung_out(path, here, jump[some], reach[some], shape[some], keeps_travel)] = 0.0
    reach[reach < LEAST_REACH] = 0.0
    return reach, shape, jump


def find_swung_out(
    path: ToolPath, corner: Ints, jump: Array, reach: Array, shape: Ints, keeps_travel: Callable[[Array, Array], Mask]
) -> Mask:
    """Corners (m,) that keep the travel of every joint, while their blends leave it."""
    tool = path.tool_length[corner - 1]
    swung = np.zeros(len(corner), dtype=bool)
    for side in (-1.0, 1.0):
        for x in side * _COARSE:
            point = evaluate_coordinates(path, *find_beside(path, corner, x * reach, side))
            swung |= ~keeps_travel(point + displace(jump, reach, shape, np.full(len(corner), x)), tool)
    rows = np.flatnonzero(swung)
    swung[rows] = keeps_travel(path.end[corner[rows] - 1], tool[rows])
    return swung


def displace(jump: Array, reach: Array, shape: Ints, x: Array) -> Array:
    """Displacements (n, 5) at x (n,) of blends with jumps (n, 3, 5), reaches (n,) and shapes (n,)."""
    odd, even = jump_values(shape, x)
    weights = np.stack([reach * shape_value(shape, x), reach**2 * odd, reach**3 * even], axis=1)
    return np.asarray(np.einsum("no,noc->nc", weights, jump))


def _displace_some(jump: Array, shape: Ints, which: Ints, reach: Array) -> Displaced:
    return lambda row, x: displace(jump[which[row]], reach[row], shape[which[row]], x)


def find_reaches(jump: Array, slopes: tuple[Array, Array], most: Array, tolerances: tuple[Array, Array]) -> Array:
    """Largest reach (m, SHAPES) of each shape inside both tolerances, ``most`` (m,) at most, for straight segments.

    ``slopes`` are the derivatives (m, 5) by s before and after the corners.
    """
    m, places = len(jump), len(_COARSE)
    far = np.full(m, np.inf)

    def share_of(off: Array) -> Array:
        """The largest share of the tolerance on both sides (m,)."""
        return np.maximum(*(find_share_used(off, slope, (-far, far), *tolerances) for slope in slopes))

    with np.errstate(divide="ignore"):
        alone = [USED_SHARE / share_of(jump[:, order])[:, None] for order in range(3)]
        guess = np.minimum(alone[0] / PEAK, np.minimum(np.sqrt(alone[1] / ODD_PEAK), np.cbrt(alone[2] / EVEN_PEAK)))
    reach = np.minimum(most[:, None], guess)
    row = np.repeat(np.arange(m), SHAPES * places)
    shape = np.tile(np.repeat(np.arange(SHAPES), places), m)
    ends = np.full(len(row), -np.inf), np.full(len(row), np.inf)
    tip, axis = (bound[row] for bound in tolerances)
    for _ in range(STEPS):
        wide = np.repeat(reach.ravel(), places)
        used = np.maximum(
            *(
                find_share_used(
                    displace(jump[row], wide, shape, side * np.tile(_COARSE, m * SHAPES)), slope[row], ends, tip, axis
                )
                for side, slope in zip((-1.0, 1.0), slopes, strict=True)
            )
        )
        used = np.maximum(used.reshape(m, SHAPES, places).max(axis=2), np.finfo(float).tiny)
        reach = np.minimum(most[:, None], reach * np.sqrt(USED_SHARE / used))
    return reach


def choose_curved_shapes(reaches: Array, feed: Array, limits: Array, cycle: float) -> Ints:
    """The shape (m,) of each corner: the narrowest that is passed at the feed rate, else the fastest one.

    Where the tool has to brake much for the corner, only shapes count that were found for such corners, and shape 0.

    Parameters
    ----------
    reaches : ndarray, shape (m, SHAPES)
    feed : ndarray, shape (m,)
    limits : ndarray, shape (3, m)
        Largest third derivative by time along the jumps of the three derivatives.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        slowness = (
            THIRD / (reaches**2 * limits[0][:, None])
            + ODD_THIRD / (reaches * limits[1][:, None])
            + EVEN_THIRD / limits[2][:, None]
        )
        speed = np.minimum(np.cbrt(1.0 / slowness), feed[:, None])
    speed[:, 1:][reaches[:, 1:] < LEAST_CYCLES * cycle * speed[:, 1:]] = 0.0
    speed = np.nan_to_num(speed)
    speed[speed.max(axis=1) < BRAKED * feed, 1:BRAKING] = 0.0
    return speed.argmax(axis=1).astype(np.int8)


def shorten_blends(path: ToolPath, corner: Ints, reach: Array, blend: Blend, tolerances: tuple[Array, Array]) -> Array:
    """Reaches (m,) with which blends stay inside both tolerances (:func:`measure_blends`), 0 where none does."""
    reach = reach.copy()
    doubtful = np.flatnonzero(reach > 0)
    for _ in range(SHORTENINGS):
        bounds = tolerances[0][doubtful], tolerances[1][doubtful]
        displaced = blend(doubtful, reach[doubtful])
        used = measure_blends(path, corner[doubtful], reach[doubtful], displaced, bounds)
        beyond = used > USED_SHARE
        doubtful = doubtful[beyond]
        if not len(doubtful):
            return reach
        reach[doubtful] *= np.clip(np.sqrt(USED_SHARE / used[beyond]) * 0.99, SHORTENING, 0.99)
    reach[doubtful] = 0.0
    return reach


def measure_blends(
    path: ToolPath, corner: Ints, reach: Array, displaced: Displaced, tolerances: tuple[Array, Array]
) -> Array:
    """What blends use of the tolerance (m,), measured from curved segments.

    The nearest pose by length is to be within both tolerances, and the programmed one within root 2 of both.
    """
    worst = np.zeros(len(corner))
    row, x = np.repeat(np.arange(len(corner)), len(_FINE)), np.tile(_FINE, len(corner))
    tip_tolerance, axis_tolerance = (bound[row] for bound in tolerances)
    for side in (-1.0, 1.0):
        segment, u = find_beside(path, corner[row], side * x * reach[row], side)
        off = displaced(row, side * x)
        point = evaluate_coordinates(path, segment, u) + off
        for _ in range(NEAREST):
            slope = differentiate_pose(path, segment, u)[0] * METRIC
            rest = (point - evaluate_coordinates(path, segment, u)) * METRIC
            u = np.clip(u + sum_rows(rest * slope) / sum_rows(slope * slope), 0.0, 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            same, nearest = (
                (measure_rows(away[:, :3]) / tip_tolerance, measure_rows(away[:, 3:]) / axis_tolerance)
                for away in (off, point - evaluate_coordinates(path, segment, u))
            )
        used = np.fmax(np.fmax(*nearest), np.hypot(*np.nan_to_num(same)) / np.sqrt(2.0))
        np.maximum.at(worst, row, np.nan_to_num(used, posinf=0.0))
    return worst


def find_beside(path: ToolPath, corner: Ints, way: Array, side: Array | float) -> tuple[Ints, Array]:
    """Segments (n,) and their u at metric lengths ``way`` (n,) after corners; ``side`` is below 0 before them."""
    before = np.broadcast_to(np.less(side, 0.0), len(corner))
    segment = corner - before
    return segment, np.clip(before + way / path.length[segment], 0.0, 1.0)
