"""Corner blends beside arcs and swinging tool axes: curves of degree 7 that join two segments with continuous third derivative.

A curve leaves segment i a distance d before the corner and reaches segment i + 1 a distance d after it, measured in
metric length (tip path and rotation together). It takes tip and table angles along in one five-dimensional curve.
At both ends its derivatives by s match those of the segments up to the third. For two straight segments its control points
are P - d t1, P - 2d/3 t1, P - d/3 t1, P and their mirror images, ``APEX d |t2 - t1|`` from the corner; for others the
deviation is measured, and d shortened until it fits. Corners between straight segments are blended in ``corners``.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.units import ROTARY_METRIC_MM
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath.corners import USED_SHARE
from verne_post.toolpath.evaluate import bernstein, pose, pose_derivatives

#: Distance of the middle of a curve from the corner, over d |t2 - t1|: (1 + 7 2/3 + 21/3) / 128.
APEX: Final = (1.0 + 14.0 / 3.0 + 7.0) / 128.0
#: Length of a curve by s over d: with it the end derivatives of the control polygon above are unit tangents.
STRETCH: Final = 7.0 / 3.0
#: A curve is measured at so many points of each half, and shortened by a factor so often until it fits.
CHECKS: Final = 9
#: Beside splines, which may turn the table many times as far as the tip goes, in so many.
SPLINE_CHECKS: Final = 33
#: A spline turns by less than this (cosine of 60 degrees) in the part of it that a curve replaces.
MOST_BEND: Final = 0.5
SHORTENING: Final = 0.7
SHORTENINGS: Final = 24
#: Points that are measured at a time: enough that calls cost little, few enough that memory stays small.
AT_A_TIME: Final = 1 << 14
#: Gauss-Newton steps to the nearest point of a segment.
NEAREST: Final = 4


def find_curves(
    path: ToolPath, corner: Ints, most: Array, tip_tolerance: Array, axis_tolerance: Array
) -> tuple[Array, Array]:
    """Largest distance d for curves at the ends of segments ``corner``, and their control points.

    Parameters
    ----------
    corner : ndarray of int, shape (m,)
        The corner lies between this segment and the next.
    most : ndarray, shape (m,)
        Largest d that the segments allow, mm.
    tip_tolerance, axis_tolerance : ndarray, shape (m,)
        mm and rad.

    Returns
    -------
    d : ndarray, shape (m,)
        mm of metric length; 0 where the corner must be a stop.
    controls : ndarray, shape (m, 8, 5)
    """
    bend = find_tangents(path, corner + 1, 0.0) - find_tangents(path, corner, 1.0)
    tip_bend = np.linalg.norm(bend[:, :3], axis=1)
    angle_bend = np.linalg.norm(bend[:, 3:], axis=1) / ROTARY_METRIC_MM
    with np.errstate(divide="ignore"):
        widest = np.minimum(
            USED_SHARE * tip_tolerance / (APEX * tip_bend), USED_SHARE * axis_tolerance / (APEX * angle_bend)
        )
    d = np.minimum(widest, most)
    controls = find_controls(path, corner, d)
    doubtful = np.flatnonzero(d > 0)
    for _ in range(SHORTENINGS):
        if not len(doubtful):
            break
        controls[doubtful] = find_controls(path, corner[doubtful], d[doubtful])
        tip_off, axis_off = np.empty(len(doubtful)), np.empty(len(doubtful))
        splined = (path.spline[corner[doubtful]] >= 0) | (path.spline[corner[doubtful] + 1] >= 0)
        for some, measure in ((~splined, _measure_deviation), (splined, _measure_beside_splines)):
            these = doubtful[some]
            tip_off[some], axis_off[some] = measure(path, corner[these], d[these], controls[these])
        bad = (tip_off > USED_SHARE * tip_tolerance[doubtful]) | (axis_off > USED_SHARE * axis_tolerance[doubtful])
        doubtful = doubtful[bad]
        d[doubtful] *= SHORTENING
    d[doubtful] = 0.0
    return d, controls


def find_tangents(path: ToolPath, segment: Ints, u: float) -> Array:
    """Unit tangents (m, 5) by metric length at parameter u of segments."""
    slope = pose_derivatives(path, segment, np.full(len(segment), u))[0] / path.length[segment, None]
    slope[:, 3:] *= ROTARY_METRIC_MM
    return slope / np.linalg.norm(slope, axis=1, keepdims=True)


def _measure_beside_splines(path: ToolPath, corner: Ints, d: Array, controls: Array) -> tuple[Array, Array]:
    """As :func:`_measure_deviation`; the corner itself must be near too, and no bend of a spline may be left out.

    A spline may turn the table far over little of its length: poses of a curve may then be near its sides and far from
    where they meet.
    """
    tip_off, angle_off = _measure_deviation(path, corner, d, controls, SPLINE_CHECKS)
    away = bernstein(controls, np.full(len(corner), 0.5)) - path.start[corner + 1]
    tip_off = np.maximum(tip_off, np.linalg.norm(away[:, :3], axis=1))
    angle_off = np.maximum(angle_off, np.linalg.norm(away[:, 3:], axis=1))
    tip_off[_bends_within(path, corner, d)] = np.inf
    return tip_off, angle_off


def _bends_within(path: ToolPath, corner: Ints, d: Array) -> Mask:
    """Corners (m,) whose curves would cut off a bend of a spline: each of its poses may be near, and the bend left out."""
    bends = np.zeros(len(corner), dtype=bool)
    for segment, at_corner, sign in ((corner, 1.0, -1.0), (corner + 1, 0.0, 1.0)):
        wanted = find_tangents(path, segment, at_corner)
        for row, share in _places(len(corner), np.linspace(0.0, 1.0, SPLINE_CHECKS)[1:]):
            on = segment[row]
            u = np.clip(at_corner + sign * share * d[row] / path.length[on], 0.0, 1.0)
            slope = pose_derivatives(path, on, u)[0] / path.length[on, None]
            slope[:, 3:] *= ROTARY_METRIC_MM
            along = np.sum(slope * wanted[row], axis=1)
            bent = (path.spline[on] >= 0) & (along < MOST_BEND * np.linalg.norm(slope, axis=1))
            bends[row[bent]] = True
    return bends


def find_controls(path: ToolPath, corner: Ints, d: Array) -> Array:
    """Find control points (m, 8, 5) of the Hermite curves that match position and three derivatives at both ends."""
    controls = np.empty((len(corner), 8, 5))
    reach = STRETCH * d
    for side, segment, sign in ((0, corner, 1.0), (7, corner + 1, -1.0)):
        length = path.length[segment]
        u = 1.0 - d / length if side == 0 else d / length
        tip, angles = pose(path, segment, u)
        start = np.concatenate([tip, angles], axis=1)
        first, second, third = (
            derivative * ((reach / length) ** order)[:, None]
            for order, derivative in enumerate(pose_derivatives(path, segment, u), start=1)
        )
        step = int(sign)
        controls[:, side] = start
        controls[:, side + step] = start + sign * first / 7
        controls[:, side + 2 * step] = start + sign * 2 * first / 7 + second / 42
        controls[:, side + 3 * step] = start + sign * 3 * first / 7 + second / 14 + sign * third / 210
    return controls


def _measure_deviation(
    path: ToolPath, corner: Ints, d: Array, controls: Array, checks: int = CHECKS
) -> tuple[Array, Array]:
    """Largest distance of each curve from its two segments, tip (mm) and angles (rad)."""
    tip_off, angle_off = np.zeros(len(corner)), np.zeros(len(corner))
    for segment, at_corner, half in (
        (corner, 1.0, np.linspace(0.0, 0.5, checks)),
        (corner + 1, 0.0, np.linspace(0.5, 1.0, checks)),
    ):
        begin = 1.0 - d / path.length[segment] if at_corner else np.zeros(len(corner))
        for row, v in _places(len(corner), half):
            point = bernstein(controls[row], v)
            on, u = segment[row], begin[row]
            for _ in range(NEAREST):  # Gauss-Newton
                tip, angles = pose(path, on, u)
                slope = pose_derivatives(path, on, u)[0]
                rest = point - np.concatenate([tip, angles], axis=1)
                rest[:, 3:] *= ROTARY_METRIC_MM
                slope[:, 3:] *= ROTARY_METRIC_MM
                u = np.clip(u + np.sum(rest * slope, axis=1) / np.sum(slope**2, axis=1), 0.0, 1.0)
            tip, angles = pose(path, on, u)
            np.maximum.at(tip_off, row, np.linalg.norm(point[:, :3] - tip, axis=1))
            np.maximum.at(angle_off, row, np.linalg.norm(point[:, 3:] - angles, axis=1))
    return tip_off, angle_off


def _places(corners: int, parameters: Array) -> Iterator[tuple[Ints, Array]]:
    """Every corner with every parameter, a bounded number at a time: the rows of the corners, and the parameters."""
    together = max(1, AT_A_TIME // max(corners, 1))
    for first in range(0, len(parameters), together):
        some = parameters[first : first + together]
        yield np.tile(np.arange(corners), len(some)), np.repeat(some, corners)
