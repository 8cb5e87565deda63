"""Poses along segments, evaluated exactly."""

from math import comb
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.rotations import wrap_angle
from verne_post.model.toolpath import ArcSegments, SegmentKind, ToolPath
from verne_post.toolpath.splines import spline_derivatives, spline_poses


def pose(path: ToolPath, segment: Ints, u: Array) -> tuple[Array, Array]:
    """Tip (n, 3) in mm and nominal angles (n, 2) in rad, as :func:`coordinates`."""
    both = coordinates(path, segment, u)
    return both[:, :3], both[:, 3:]


def coordinates(path: ToolPath, segment: Ints, u: Array) -> Array:
    """Tip and nominal angles at parameter u of segments (LINE, ARC and SPLINE).

    Parameters
    ----------
    segment : ndarray of int, shape (n,)
    u : ndarray, shape (n,)
        0 to 1.

    Returns
    -------
    ndarray, shape (n, 5)
        Tip in the table frame, mm; nominal A and C, rad, workpiece sense.
    """
    start = path.start.take(segment, axis=0)
    poses = path.end.take(segment, axis=0)
    poses -= start
    poses *= u[:, None]
    poses += start
    if len(path.arcs.sweep):
        curved = np.flatnonzero(path.kind[segment] == SegmentKind.ARC)
        poses[curved, :3] = arc_tip(path.arcs, path.arc[segment[curved]], u[curved])
    if len(path.splines):
        curved = np.flatnonzero(path.kind[segment] == SegmentKind.SPLINE)
        poses[curved] = spline_poses(path.splines, path.spline[segment[curved]], u[curved])
        poses[curved, 3:] += start[curved, 3:]
    if len(path.circles.angle):
        swung = np.flatnonzero(path.circle[segment] >= 0)
        poses[swung, 3:] = circle_angles(path, segment[swung], u[swung])
    return poses


def coordinate_slope(path: ToolPath, segment: Ints, u: Array) -> Array:
    """Derivative (n, 5) of :func:`coordinates` by u."""
    slope = path.end.take(segment, axis=0)
    slope -= path.start.take(segment, axis=0)
    if len(path.arcs.sweep) or len(path.splines) or len(path.circles.angle):
        curved = np.flatnonzero((path.kind[segment] != SegmentKind.LINE) | (path.circle[segment] >= 0))
        slope[curved] = pose_derivatives(path, segment[curved], u[curved])[0]
    return slope


def circle_axis(path: ToolPath, segment: Ints, u: Array) -> Array:
    """Tool axis (n, 3) at parameter u (n,) of segments on which it follows a great circle."""
    circles, row = path.circles, path.circle[segment]
    turn = u * circles.angle[row]
    return np.asarray(np.cos(turn)[:, None] * circles.first[row] + np.sin(turn)[:, None] * circles.side[row])


def circle_angles(path: ToolPath, segment: Ints, u: Array) -> Array:
    """Nominal angles (n, 2) at parameter u (n,) of segments whose tool axis follows a great circle."""
    axis = circle_axis(path, segment, u)
    start, end = path.start[segment, 3:], path.end[segment, 3:]
    # a great circle that avoids the pole keeps to one side of the tilt
    side = np.where(start[:, 0] + end[:, 0] < 0, -1.0, 1.0)
    tilt = side * np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])
    direction = np.arctan2(side * axis[:, 0], side * axis[:, 1])
    # its azimuth changes by less than half a turn from end to end
    return np.stack([tilt, start[:, 1] + wrap_angle(direction - start[:, 1])], axis=1)


def arc_tip(arcs: ArcSegments, row: Ints, u: Array) -> Array:
    """Tip (n, 3) at parameter u (n,) of the arcs in ``row`` (n,)."""
    angle = u * arcs.sweep[row]
    radius = arcs.r0[row] + u * (arcs.r1[row] - arcs.r0[row])
    return (
        arcs.center[row]
        + (radius * np.cos(angle))[:, None] * arcs.e1[row]
        + (radius * np.sin(angle))[:, None] * arcs.e2[row]
        + u[:, None] * arcs.rise[row]
    )


#: Step of the differences on great circles, of u: the error of the sixth-order formula is then below 1e-10.
_STEP: Final = 1e-2
_OFFSETS: Final = np.arange(-4, 5) * _STEP
#: Values at the offsets -> first three derivatives, exact for polynomials of degree 8.
_STENCIL: Final = (
    np.linalg.inv(np.vander(_OFFSETS, increasing=True)) * np.array([1, 1, 2, 6, 1, 1, 1, 1, 1])[:, None]
)[1:4]


def pose_derivatives(path: ToolPath, segment: Ints, u: Array) -> tuple[Array, Array, Array]:
    """First three derivatives by u of tip and nominal angles, each shape (n, 5)."""
    first = path.end[segment] - path.start[segment]
    second, third = np.zeros_like(first), np.zeros_like(first)
    curved = np.flatnonzero(path.kind[segment] == SegmentKind.ARC)
    if len(curved):
        row = path.arc[segment[curved]]
        first[curved, :3], second[curved, :3], third[curved, :3] = arc_derivatives(path.arcs, row, u[curved])
    curved = np.flatnonzero(path.kind[segment] == SegmentKind.SPLINE)
    if len(curved):
        row = path.spline[segment[curved]]
        first[curved], second[curved], third[curved] = spline_derivatives(path.splines, row, u[curved])
    swung = np.flatnonzero(path.circle[segment] >= 0)
    if len(swung):
        around = u[swung, None] + _OFFSETS
        values = circle_angles(path, np.repeat(segment[swung], len(_OFFSETS)), around.ravel())
        derivatives = np.einsum("dk,nkj->dnj", _STENCIL, values.reshape(len(swung), len(_OFFSETS), 2))
        first[swung, 3:], second[swung, 3:], third[swung, 3:] = derivatives
    return first, second, third


def arc_derivatives(arcs: ArcSegments, row: Ints, u: Array) -> tuple[Array, Array, Array]:
    """First three derivatives of the tip by u, each shape (n, 3)."""
    w = arcs.sweep[row][:, None]
    phi = u[:, None] * w
    radial = np.cos(phi) * arcs.e1[row] + np.sin(phi) * arcs.e2[row]
    tangent = np.cos(phi) * arcs.e2[row] - np.sin(phi) * arcs.e1[row]
    grow = (arcs.r1 - arcs.r0)[row][:, None]
    radius = arcs.r0[row][:, None] + u[:, None] * grow
    return (
        radius * w * tangent + grow * radial + arcs.rise[row],
        -radius * w**2 * radial + 2 * grow * w * tangent,
        -radius * w**3 * tangent - 3 * grow * w**2 * radial,
    )


#: Binomial coefficients of the degrees 6 and 7.
_BINOMIALS: Final = {n: np.array([comb(n, k) for k in range(n + 1)], dtype=float) for n in (6, 7)}


def bernstein(controls: Array, v: Array) -> Array:
    """Points (n, k) at parameters v (n,) of curves with control points (n, 8, k)."""
    return np.einsum("nc,nck->nk", _weights(v, 7), controls)


def bernstein_slope(controls: Array, v: Array) -> Array:
    """Derivatives by v of :func:`bernstein`, (n, k)."""
    return np.einsum("nc,nck->nk", 7 * _weights(v, 6), np.diff(controls, axis=1))


def _weights(v: Array, degree: int) -> Array:
    """Bernstein polynomials (n, degree + 1) at parameters v (n,)."""
    powers = np.arange(degree + 1)
    return np.asarray(_BINOMIALS[degree] * v[:, None] ** powers * (1.0 - v[:, None]) ** (degree - powers))
