"""Corner blends: curves of degree 7 that join two pieces with continuous third derivative.

A blend leaves piece i a distance d before the corner and reaches piece i + 1 a distance d behind it,
measured in metric length (tip path and rotation together), and takes tip and table angles along in
one five-dimensional curve. At both ends its derivatives by s match those of the pieces up to the third.
For two straight pieces the control points are P - d t1, P - 2d/3 t1, P - d/3 t1, P and their mirror images;
the curve then stays within ``APEX d |t2 - t1|`` of the pieces, tip and angles alike.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.model.moves import Moves, PathControl, PathMode
from verne_post.model.toolpath import PieceKind, ToolPath
from verne_post.toolpath.build import ROTARY_METRIC_MM
from verne_post.toolpath.evaluate import pose, pose_derivatives

Array = NDArray[np.float64]
Ints = NDArray[np.integer]
Mask = NDArray[np.bool_]

#: Distance of the middle of a blend from the corner, over d |t2 - t1|: (1 + 7 2/3 + 21/3) / 128.
APEX: Final = (1.0 + 14.0 / 3.0 + 7.0) / 128.0
#: Length of a blend by s over d: with it the end derivatives of the control polygon above are unit tangents.
STRETCH: Final = 7.0 / 3.0
#: A corner that turns back this sharply (cosine of the angle between the tangents) is a stop: a blend would not be
#: faster, and its curve would nearly come back on itself.
REVERSAL: Final = -0.9
#: The share of the tolerance that is used; the rest is for the rounding of the written numbers.
USED_SHARE: Final = 0.97
#: At most this share of a piece's length goes to the blend at each of its ends.
SHARE: Final = 0.5
#: A blend next to a curved piece is checked at so many points of each half, and shortened until it fits.
CHECKS: Final = 9
SHORTENINGS: Final = 24


def corner_tolerance(controls: tuple[PathControl, ...], tip_default: float, axis_default: float) -> tuple[Array, Array]:
    """Tip (mm) and axis (rad) tolerance of each path control; 0 where corners are not blended.

    A P of 0 asks for an exact path. The axis tolerance goes with the machine's default.
    """
    blended = np.array([control.mode == PathMode.BLEND for control in controls])
    tip = np.array([tip_default if control.tolerance is None else control.tolerance for control in controls])
    tip = np.where(blended, tip, 0.0)
    return tip, np.where(tip > 0, axis_default, 0.0)


def blend_distances(path: ToolPath, corner: Ints, tip_tolerance: Array, axis_tolerance: Array) -> tuple[Array, Array]:
    """Largest distance d for blends at the ends of pieces ``corner``, and their control points.

    Parameters
    ----------
    path : ToolPath
    corner : ndarray of int, shape (m,)
        The corner lies between this piece and the next.
    tip_tolerance, axis_tolerance : ndarray, shape (m,)
        mm and rad.

    Returns
    -------
    d : ndarray, shape (m,)
        mm of metric length; 0 where the corner must be a stop.
    controls : ndarray, shape (m, 8, 5)
    """
    before, after = corner, corner + 1
    t1 = _tangent(path, before, 1.0)
    t2 = _tangent(path, after, 0.0)
    bend = t2 - t1
    tip_bend = np.linalg.norm(bend[:, :3], axis=1)
    angle_bend = np.linalg.norm(bend[:, 3:], axis=1) / ROTARY_METRIC_MM
    with np.errstate(divide="ignore"):
        room = np.minimum(
            USED_SHARE * tip_tolerance / (APEX * tip_bend), USED_SHARE * axis_tolerance / (APEX * angle_bend)
        )
    d = np.minimum(room, SHARE * np.minimum(path.length[before], path.length[after]))
    d[np.sum(t1 * t2, axis=1) < REVERSAL] = 0.0
    controls = blend_controls(path, corner, d)
    curved = (path.kind[before] == PieceKind.ARC) | (path.kind[after] == PieceKind.ARC)
    doubtful = np.flatnonzero(curved & (d > 0))
    for _ in range(SHORTENINGS):
        if not len(doubtful):
            break
        controls[doubtful] = blend_controls(path, corner[doubtful], d[doubtful])
        tip_off, axis_off = _deviation(path, corner[doubtful], d[doubtful], controls[doubtful])
        bad = (tip_off > USED_SHARE * tip_tolerance[doubtful]) | (axis_off > USED_SHARE * axis_tolerance[doubtful])
        doubtful = doubtful[bad]
        d[doubtful] *= 0.7
    d[doubtful] = 0.0
    return d, controls


def _tangent(path: ToolPath, piece: Ints, u: float) -> Array:
    """Unit metric tangents (m, 5) at parameter u of pieces."""
    slope = pose_derivatives(path, piece, np.full(len(piece), u))[0] / path.length[piece, None]
    slope[:, 3:] *= ROTARY_METRIC_MM
    return slope / np.linalg.norm(slope, axis=1, keepdims=True)


def blend_controls(path: ToolPath, corner: Ints, d: Array) -> Array:
    """Control points (m, 8, 5) of the Hermite curves that match position and three derivatives at both ends."""
    controls = np.empty((len(corner), 8, 5))
    reach = STRETCH * d
    for side, piece, sign in ((0, corner, 1.0), (7, corner + 1, -1.0)):
        length = path.length[piece]
        u = 1.0 - d / length if side == 0 else d / length
        tip, angles = pose(path, piece, u)
        start = np.concatenate([tip, angles], axis=1)
        first, second, third = (
            derivative * ((reach / length) ** order)[:, None]
            for order, derivative in enumerate(pose_derivatives(path, piece, u), start=1)
        )
        step = int(sign)
        controls[:, side] = start
        controls[:, side + step] = start + sign * first / 7
        controls[:, side + 2 * step] = start + sign * 2 * first / 7 + second / 42
        controls[:, side + 3 * step] = start + sign * 3 * first / 7 + second / 14 + sign * third / 210
    return controls


def _deviation(path: ToolPath, corner: Ints, d: Array, controls: Array) -> tuple[Array, Array]:
    """Largest distance of each blend from its two pieces, tip (mm) and angles (rad)."""
    tip_off, angle_off = np.zeros(len(corner)), np.zeros(len(corner))
    for piece, half in ((corner, np.linspace(0.0, 0.5, CHECKS)), (corner + 1, np.linspace(0.5, 1.0, CHECKS))):
        for v in half:
            point = bernstein(controls, np.full(len(corner), v))
            u = (1.0 - d / path.length[piece]) if piece is corner else np.zeros(len(corner))
            for _ in range(4):  # Gauss-Newton on the nearest point
                tip, angles = pose(path, piece, u)
                slope = pose_derivatives(path, piece, u)[0]
                rest = point - np.concatenate([tip, angles], axis=1)
                rest[:, 3:] *= ROTARY_METRIC_MM
                slope[:, 3:] *= ROTARY_METRIC_MM
                u = np.clip(u + np.sum(rest * slope, axis=1) / np.sum(slope**2, axis=1), 0.0, 1.0)
            tip, angles = pose(path, piece, u)
            tip_off = np.maximum(tip_off, np.linalg.norm(point[:, :3] - tip, axis=1))
            angle_off = np.maximum(angle_off, np.linalg.norm(point[:, 3:] - angles, axis=1))
    return tip_off, angle_off


_BINOMIAL: Final = np.array([1.0, 7.0, 21.0, 35.0, 35.0, 21.0, 7.0, 1.0])


def bernstein(controls: Array, v: Array) -> Array:
    """Points (n, k) at parameters v (n,) of curves with control points (n, 8, k)."""
    powers = np.arange(8)
    weights = _BINOMIAL * v[:, None] ** powers * (1.0 - v[:, None]) ** (7 - powers)
    return np.einsum("nc,nck->nk", weights, controls)


def bernstein_slope(controls: Array, v: Array) -> Array:
    """Derivatives by v of :func:`bernstein`, (n, k)."""
    powers = np.arange(7)
    weights = (
        np.array([1.0, 6.0, 15.0, 20.0, 15.0, 6.0, 1.0]) * v[:, None] ** powers * (1.0 - v[:, None]) ** (6 - powers)
    )
    return np.einsum("nc,nck->nk", 7 * weights, np.diff(controls, axis=1))


def blended_corners(path: ToolPath, moves: Moves, tip_default: float, axis_default: float) -> tuple[Mask, Array, Array]:
    """Which joints between neighbouring pieces may be blended, and their tolerances.

    Returns
    -------
    allowed : ndarray of bool, shape (n - 1,)
    tip_tolerance, axis_tolerance : ndarray, shape (n - 1,)
    """
    n = len(path)
    tip, axis = corner_tolerance(moves.controls, tip_default, axis_default)
    control = np.where(path.move >= 0, moves.control[path.move], 0)
    own = (path.move >= 0) & (path.kind != PieceKind.JOINT)
    tip_tolerance = np.minimum(tip[control[:-1]], tip[control[1:]])
    axis_tolerance = np.minimum(axis[control[:-1]], axis[control[1:]])
    contact = np.abs(path.start[1:] - path.end[:-1]).max(axis=1, initial=0.0) == 0.0
    allowed = own[:-1] & own[1:] & (tip_tolerance > 0) & contact & (path.tool_length[1:] == path.tool_length[:-1])
    begins = np.append(np.flatnonzero(np.diff(path.run, prepend=-1)), n)
    rests = begins[path.dwell_run]
    allowed[rests[(rests > 0) & (rests < n)] - 1] = False
    return allowed, tip_tolerance, axis_tolerance
