"""Poses along segments, evaluated exactly."""

from collections.abc import Callable
from math import comb
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.rotations import find_axis_of_angles, rotate_x, rotate_y, rotate_z, wrap_angle
from verne_post.model.nutation import find_shift, find_tilt
from verne_post.model.toolpath import ArcSegments, SegmentKind, ToolPath, TurnSegments
from verne_post.toolpath.splines import differentiate_splines, evaluate_splines

#: A quarter of a turn, rad.
_QUARTER: Final = 0.5 * np.pi


def evaluate_pose(path: ToolPath, segment: Ints, u: Array) -> tuple[Array, Array]:
    """Tip (n, 3) in mm and nominal angles (n, 2) in rad, as :func:`evaluate_coordinates`."""
    both = evaluate_coordinates(path, segment, u)
    return both[:, :3], both[:, 3:]


def evaluate_coordinates(path: ToolPath, segment: Ints, u: Array) -> Array:
    """Tip and nominal angles at parameter u of segments (LINE, ARC, SPLINE and TURN).

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
        poses[curved, :3] = evaluate_arc(path.arcs, path.arc[segment[curved]], u[curved])
    if len(path.splines):
        curved = np.flatnonzero(path.kind[segment] == SegmentKind.SPLINE)
        poses[curved] = evaluate_splines(path.splines, path.spline[segment[curved]], u[curved])
        poses[curved, 3:] += start[curved, 3:]
    if len(path.turns.first):
        carried = np.flatnonzero(path.turn[segment] >= 0)
        poses[carried, :3] = turn_tip(path.turns, path.turn[segment[carried]], u[carried])
    if len(path.circles.angle):
        swung = np.flatnonzero(path.circle[segment] >= 0)
        poses[swung, 3:] = find_circle_angles(path, segment[swung], u[swung])
    return poses


def differentiate_coordinates(path: ToolPath, segment: Ints, u: Array) -> Array:
    """Derivative (n, 5) of :func:`evaluate_coordinates` by u."""
    slope = path.end.take(segment, axis=0)
    slope -= path.start.take(segment, axis=0)
    if len(path.arcs.sweep) or len(path.splines) or len(path.turns.first) or len(path.circles.angle):
        curved = np.flatnonzero((path.kind[segment] != SegmentKind.LINE) | (path.circle[segment] >= 0))
        slope[curved] = differentiate_pose(path, segment[curved], u[curved])[0]
    return slope


def find_circle_axis(path: ToolPath, segment: Ints, u: Array) -> Array:
    """Tool axis (n, 3) at parameter u (n,) of segments on which A and C are not linear."""
    circles, row = path.circles, path.circle[segment]
    linear = np.isfinite(circles.joints[row, 0])
    if linear.any():
        angles = find_circle_angles(path, segment, u)
        return find_axis_of_angles(angles[:, 0], angles[:, 1])
    turn = u * circles.angle[row]
    return np.asarray(np.cos(turn)[:, None] * circles.first[row] + np.sin(turn)[:, None] * circles.side[row])


def find_circle_angles(path: ToolPath, segment: Ints, u: Array) -> Array:
    """Nominal angles (n, 2) at parameter u (n,) of segments on which they are not linear."""
    linear = np.isfinite(path.circles.joints[path.circle[segment], 0])
    if linear.any():
        angles = np.empty((len(segment), 2))
        angles[linear] = _find_linear_angles(path, segment[linear], u[linear])
        angles[~linear] = find_circle_angles(path, segment[~linear], u[~linear]) if not linear.all() else 0.0
        return angles
    axis = find_circle_axis(path, segment, u)
    start, end = path.start[segment, 3:], path.end[segment, 3:]
    # a great circle that avoids the pole keeps to one side of the tilt
    side = np.where(start[:, 0] + end[:, 0] < 0, -1.0, 1.0)
    tilt = side * np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])
    direction = np.arctan2(side * axis[:, 0], side * axis[:, 1])
    # its azimuth changes by less than half a turn from end to end
    return np.stack([tilt, start[:, 1] + wrap_angle(direction - start[:, 1])], axis=1)


def _find_linear_angles(path: ToolPath, segment: Ints, u: Array) -> Array:
    """The same where the joints of a nutating pair are linear."""
    d0, t0, d1, t1, near, far = path.circles.joints[path.circle[segment]].T
    d = d0 + u * (d1 - d0)
    angles = np.stack([find_tilt(d, near, far), t0 + u * (t1 - t0) + find_shift(d, near, far)], axis=1)
    # by whole turns of C, and at folds, as the ends of the segment say
    start, end = path.start[segment, 3:], path.end[segment, 3:]
    return np.where((u == 0.0)[:, None], start, np.where((u == 1.0)[:, None], end, angles))


def evaluate_arc(arcs: ArcSegments, row: Ints, u: Array) -> Array:
    """Tip (n, 3) at parameter u (n,) of the arcs in ``row`` (n,)."""
    angle = u * arcs.sweep[row]
    radius = arcs.r0[row] + u * (arcs.r1[row] - arcs.r0[row])
    return (
        arcs.center[row]
        + (radius * np.cos(angle))[:, None] * arcs.e1[row]
        + (radius * np.sin(angle))[:, None] * arcs.e2[row]
        + u[:, None] * arcs.rise[row]
    )


def turn_tip(turns: TurnSegments, row: Ints, u: Array) -> Array:
    """Tip (n, 3) at parameter u (n,) of the turns in ``row`` (n,)."""
    place = turns.first[row] + u[:, None] * (turns.last - turns.first)[row]
    angles = turns.angles[row] + u[:, None] * (turns.last_angles - turns.angles)[row]
    inner = (
        _turn_by_lean(turns, row, rotate_x(place, -angles[:, 0])) - turns.offset[row] + u[:, None] * turns.slide[row]
    )
    return np.asarray(turns.shift[row] + u[:, None] * turns.drift[row] + rotate_z(inner, -angles[:, 1]))


def _turn_by_lean(turns: TurnSegments, row: Ints, vector: Array) -> Array:
    """Vectors (n, 3) seen from the tilting joint's direction, in the table frame."""
    return rotate_y(vector, -turns.lean[row]) if turns.lean.any() else vector


def turn_derivatives(turns: TurnSegments, row: Ints, u: Array) -> tuple[Array, Array, Array]:
    """First three derivatives of :func:`turn_tip` by u, each (n, 3), by differentiating rotation after rotation."""
    step = (turns.last - turns.first)[row]
    place = turns.first[row] + u[:, None] * step
    rate = (turns.last_angles - turns.angles)[row]
    angles = turns.angles[row] + u[:, None] * rate
    still = np.zeros_like(place)
    # each list holds a vector and its first three derivatives by u
    tilted = _derive_turned([place, step, still, still], rotate_x, 0, -angles[:, 0], -rate[:, 0])
    tilted = [_turn_by_lean(turns, row, vector) for vector in tilted]
    tilted[0] = tilted[0] - turns.offset[row] + u[:, None] * turns.slide[row]
    tilted[1] = tilted[1] + turns.slide[row]
    _tip, first, second, third = _derive_turned(tilted, rotate_z, 2, -angles[:, 1], -rate[:, 1])
    return first + turns.drift[row], second, third


def _derive_turned(
    vector: list[Array], rotate: Callable[[Array, Array], Array], axis: int, angle: Array, rate: Array
) -> list[Array]:
    """A vector and its first three derivatives (each (n, 3)) after a rotation whose angle (n,) has a constant rate.

    The m-th derivative of a rotation by its angle is the part across the axis, turned by m quarter turns more.
    """
    turned: list[Array] = []
    for order in range(4):
        total = np.zeros_like(vector[0])
        for of_rotation in range(order + 1):
            part = rotate(vector[order - of_rotation], angle + of_rotation * _QUARTER)
            if of_rotation:
                part[:, axis] = 0.0
            total += comb(order, of_rotation) * rate[:, None] ** of_rotation * part
        turned.append(total)
    return turned


#: Step of the differences on great circles, of u: the error of the sixth-order formula is then below 1e-10.
_STEP: Final = 1e-2
_OFFSETS: Final = np.arange(-4, 5) * _STEP
#: Values at the offsets -> first three derivatives, exact for polynomials of degree 8.
_STENCIL: Final = (
    np.linalg.inv(np.vander(_OFFSETS, increasing=True)) * np.array([1, 1, 2, 6, 1, 1, 1, 1, 1])[:, None]
)[1:4]


def differentiate_pose(path: ToolPath, segment: Ints, u: Array) -> tuple[Array, Array, Array]:
    """First three derivatives by u of tip and nominal angles, each shape (n, 5)."""
    first = path.end[segment] - path.start[segment]
    second, third = np.zeros_like(first), np.zeros_like(first)
    curved = np.flatnonzero(path.kind[segment] == SegmentKind.ARC)
    if len(curved):
        row = path.arc[segment[curved]]
        first[curved, :3], second[curved, :3], third[curved, :3] = differentiate_arc(path.arcs, row, u[curved])
    curved = np.flatnonzero(path.kind[segment] == SegmentKind.SPLINE)
    if len(curved):
        row = path.spline[segment[curved]]
        first[curved], second[curved], third[curved] = differentiate_splines(path.splines, row, u[curved])
    carried = np.flatnonzero(path.kind[segment] == SegmentKind.TURN)
    if len(carried):
        row = path.turn[segment[carried]]
        first[carried, :3], second[carried, :3], third[carried, :3] = turn_derivatives(path.turns, row, u[carried])
    swung = np.flatnonzero(path.circle[segment] >= 0)
    if len(swung):
        around = u[swung, None] + _OFFSETS
        values = find_circle_angles(path, np.repeat(segment[swung], len(_OFFSETS)), around.ravel())
        derivatives = np.einsum("dk,nkj->dnj", _STENCIL, values.reshape(len(swung), len(_OFFSETS), 2))
        first[swung, 3:], second[swung, 3:], third[swung, 3:] = derivatives
    return first, second, third


def differentiate_arc(arcs: ArcSegments, row: Ints, u: Array) -> tuple[Array, Array, Array]:
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


def evaluate_bernstein(controls: Array, v: Array) -> Array:
    """Points (n, k) at parameters v (n,) of curves with control points (n, 8, k)."""
    return np.einsum("nc,nck->nk", _evaluate_bernstein(v, 7), controls)


def differentiate_bernstein(controls: Array, v: Array) -> Array:
    """Derivatives by v of :func:`evaluate_bernstein`, (n, k)."""
    return np.einsum("nc,nck->nk", 7 * _evaluate_bernstein(v, 6), np.diff(controls, axis=1))


def _evaluate_bernstein(v: Array, degree: int) -> Array:
    """Bernstein polynomials (n, degree + 1) at parameters v (n,)."""
    powers = np.arange(degree + 1)
    return np.asarray(_BINOMIALS[degree] * v[:, None] ** powers * (1.0 - v[:, None]) ** (degree - powers))
