"""Where on its programmed segment a measured pose is, and how far off: projections, in closed form but for splines."""

from functools import cached_property
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import measure_rows, sum_rows
from verne_post.model.poses import JointPoses
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.verification.linear_joints import find_lines
from verne_post.verification.programmed import (
    RADIAN_MM,
    evaluate_arcs,
    evaluate_turns,
    find_on_circles,
    find_programmed_pose,
    find_tool_axis,
    measure_own_splines,
    span_great_circles,
)
from verne_post.verification.splines import project

#: Near a corner, the nearest pose of a segment is searched at so many points of a stretch, each round so many times
#: finer: to a millionth of a stretch that is a few tolerances long.
NEARBY_POINTS: Final = 17
NEARBY_ROUNDS: Final = 7
#: A rotary angle this far off (rad) is one of another turn. The other branch of the table, half a turn away, needs no
#: such bound: it counts by the tool axis' motion over half a turn, except at the pole, where both branches are one.
OTHER_TURN: Final = 1.5 * np.pi
#: Refinements of the projection on an arc whose rotary axes turn too: quadratic from a close start.
ARC_STEPS: Final = 2


class Measured(JointPoses, frozen=True, eq=False, dict=True):
    """Poses that the joint values as written really have.

    With ``by_axis`` the joints tell the tool axis alone: C counts by what it moves the axis, at the pole nothing.
    ``told`` are then the tool axes (n, 3) that they tell, and ``angles`` words that hold them within the tolerance.
    """

    by_axis: bool = False
    told: Array | None = None

    @cached_property
    def axis(self) -> Array:
        """Unit tool axes (n, 3), table frame: those of the nominal angles, or as the joints tell them."""
        return find_tool_axis(self.angles) if self.told is None else self.told

    def select(self, rows: Ints) -> "Measured":
        """The poses of some rows."""
        told = None if self.told is None else self.told[rows]
        return Measured(self.q[rows], self.tip[rows], self.angles[rows], self.by_axis, told)

    def weigh(self, radian_mm: Array | float) -> Array:
        """Weights of a radian against a mm for A and C, (n, 2) or broadcastable; ``radian_mm`` one or (n,)."""
        weight = np.reshape(radian_mm, (-1, 1))
        if not self.by_axis:
            return weight
        sine = np.abs(np.sin(self.angles[:, 0]))
        return np.asarray(weight * np.stack([np.ones_like(sine), sine], axis=1))


def project_unwrapped(
    path: ToolPath, segment: Ints, measured: Measured, fresh: Mask, u_before: float, bounds: tuple[Array, Array] | None
) -> Array:
    """Parameter u of the nearest point of the segment, not limited to [0, 1].

    Parameters
    ----------
    segment : ndarray of int, shape (n,)
        Consecutive rows of one segment stand together.
    fresh : ndarray of bool, shape (n,)
        True where a row is the first one of its segment.
    u_before : float
        u of the row before the first, where that row is on the same segment (arcs of several turns, splines).
    bounds : two ndarrays, shape (n,), or None
        How far tip (mm) and angles (rad) of rows may be from their places, where a spline comes near itself. None: each
        row is matched by itself.
    """
    u = project_onto_straight(path, segment, measured, RADIAN_MM)
    arc = np.flatnonzero(path.kind[segment] == SegmentKind.ARC)
    if len(arc):
        u[arc] = _project_on_arcs(path, segment[arc], measured.select(arc), _find_first_rows(arc, fresh), u_before)
    turn = np.flatnonzero(path.turn[segment] >= 0)
    if len(turn):
        u[turn] = _project_on_turns(path, segment[turn], measured.select(turn))
    spline = np.flatnonzero(path.spline[segment] >= 0)
    if len(spline):
        first, some = (
            _find_first_rows(spline, fresh),
            None if bounds is None else (bounds[0][spline], bounds[1][spline]),
        )
        u[spline] = _project_on_splines(path, segment[spline], measured.select(spline), first, u_before, some)
    joint = np.flatnonzero(path.kind[segment] == SegmentKind.JOINT)
    if len(joint):
        ends = path.joints[path.joint[segment[joint]]]
        span = ends[:, 1] - ends[:, 0]
        scale = np.array([1.0] * (span.shape[1] - 2) + [RADIAN_MM, RADIAN_MM])
        away = (measured.q[joint] - ends[:, 0]) * scale
        u[joint] = np.sum(away * span * scale, axis=1) / np.sum((span * scale) ** 2, axis=1)
    return u


def project_onto_straight(path: ToolPath, segment: Ints, measured: Measured, radian_mm: Array | float) -> Array:
    """Parameter u (n,) of the nearest point of straight segments, whose tool axis may follow a great circle.

    ``radian_mm`` is the weight of a radian against a millimetre, one or (n,). Results of other segments mean nothing.
    """
    start, tip, angles = path.start[segment], measured.tip, measured.angles
    delta, now = path.end[segment] - start, np.concatenate([tip, angles], axis=1) - start
    angles_now, angles_start, delta[:, 3:] = find_lines(path, segment, angles)
    now[:, 3:] = angles_now - angles_start
    weighted = delta.copy()
    weighted[:, 3:] *= measured.weigh(radian_mm) ** 2
    with np.errstate(invalid="ignore", divide="ignore"):
        u = sum_rows(now * weighted) / sum_rows(delta * weighted)
    on_circle = find_on_circles(path, segment)
    if len(on_circle):
        each = np.broadcast_to(radian_mm, len(segment))[on_circle]
        u[on_circle] = _project_on_great_circles(
            path, segment[on_circle], tip[on_circle], measured.axis[on_circle], each
        )
    return np.asarray(u)


def _find_first_rows(rows: Ints, fresh: Mask) -> Mask:
    """First rows of segments among a selection: marked, or after a gap in the selection."""
    return fresh[rows] | (np.diff(rows, prepend=rows[0]) > 1)


def project_tips(
    path: ToolPath, segment: Ints, measured: Measured, fresh: Mask, u_before: float
) -> tuple[Array, Array]:
    """As :func:`project_unwrapped`, by the tip alone, and the way (n,) of the tip along the segment, mm.

    0 both where the tip does not say, as on turns, splines, and where it stands.
    """
    u, way = np.zeros(len(segment)), np.zeros(len(segment))
    plain = (path.turn[segment] < 0) & (path.spline[segment] < 0)
    line = np.flatnonzero((path.kind[segment] == SegmentKind.LINE) & plain)
    along = path.end[segment[line], :3] - path.start[segment[line], :3]
    square = sum_rows(along**2)
    moved = sum_rows((measured.tip[line] - path.start[segment[line], :3]) * along)
    u[line], way[line] = np.divide(moved, square, out=np.zeros(len(line)), where=square > 0), np.sqrt(square)
    arc = np.flatnonzero(path.kind[segment] == SegmentKind.ARC)
    if len(arc):
        row = path.arc[segment[arc]]
        u[arc] = _project_on_arcs(
            path, segment[arc], measured.select(arc), _find_first_rows(arc, fresh), u_before, by_tip=True
        )
        way[arc] = np.abs(path.arcs.sweep[row]) * path.arcs.r0[row]
    return u, way


def _project_on_arcs(
    path: ToolPath, segment: Ints, measured: Measured, fresh: Mask, u_before: float, *, by_tip: bool = False
) -> Array:
    """As :func:`project_unwrapped`, on arcs; ``by_tip`` alone if so."""
    weight = measured.weigh(0.0 if by_tip else RADIAN_MM) ** 2
    arcs, row = path.arcs, path.arc[segment]
    away = measured.tip - arcs.center[row]
    sweep = arcs.sweep[row]
    x, y = np.sum(away * arcs.e1[row], axis=1), np.sum(away * arcs.e2[row], axis=1)
    angle = np.arctan2(y, x) * np.sign(sweep)
    # add the small steps from row to row, so that full turns and several turns count
    step = np.diff(angle, prepend=angle[0])
    step = (step + np.pi) % (2 * np.pi) - np.pi
    begin = (angle + np.pi / 2) % (
        2 * np.pi
    ) - np.pi / 2  # the first row may be far ahead, or a little before the start
    if not fresh[0]:
        expected = u_before * abs(sweep[0])
        begin[0] = expected + (angle[0] - expected + np.pi) % (2 * np.pi) - np.pi
    step[fresh] = 0.0
    total = np.cumsum(step)
    first = np.flatnonzero(fresh | (np.arange(len(fresh)) == 0))
    owner = np.searchsorted(first, np.arange(len(fresh)), side="right") - 1
    u = (begin[first[owner]] + total - total[first[owner]]) / np.abs(sweep)
    now, start, turn = find_lines(path, segment, measured.angles)
    for _ in range(ARC_STEPS):
        at, slope = evaluate_arcs(arcs, row, u)
        rest = measured.tip - at
        rest_turn = weight * (now - start - u[:, None] * turn)
        square = np.sum(slope**2, axis=1) + np.sum(weight * turn**2, axis=1)
        u = u + (np.sum(rest * slope, axis=1) + np.sum(rest_turn * turn, axis=1)) / square
    return u


def _project_on_turns(path: ToolPath, segment: Ints, measured: Measured) -> Array:
    """As :func:`project_unwrapped`, on turns of the table: A and C go linearly, and the tip refines what they say."""
    now, start, turn = find_lines(path, segment, measured.angles)
    turned, square = np.sum((now - start) * turn, axis=1), np.sum(turn**2, axis=1)
    u = np.divide(turned, square, out=np.zeros_like(turned), where=square > 0)  # none at a pole: the tip says it
    for _ in range(ARC_STEPS):
        at, slope = evaluate_turns(path.turns, path.turn[segment], u)
        rest = RADIAN_MM**2 * (now - start - u[:, None] * turn)
        square = np.sum(slope**2, axis=1) + RADIAN_MM**2 * np.sum(turn**2, axis=1)
        u = u + (np.sum((measured.tip - at) * slope, axis=1) + np.sum(rest * turn, axis=1)) / square
    return u


def _project_on_splines(
    path: ToolPath, segment: Ints, measured: Measured, fresh: Mask, u_before: float, bounds: tuple[Array, Array] | None
) -> Array:
    """As :func:`project_unwrapped`, on splines."""
    splines, piece = measure_own_splines(path, segment)
    pose = np.concatenate([measured.tip, measured.angles - path.start[segment, 3:]], axis=1)
    return project(splines, piece, pose, fresh, u_before, RADIAN_MM, bounds)


def _project_on_great_circles(path: ToolPath, segment: Ints, tip: Array, axis: Array, radian_mm: Array) -> Array:
    """Nearest u on straight segments whose tool axis follows a great circle."""
    start, delta = path.start[segment, :3], path.end[segment, :3] - path.start[segment, :3]
    k0, k1, angle = span_great_circles(path, segment)
    across = np.cross(np.cross(k0, k1), k0)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    turned = np.arctan2(np.sum(axis * across, axis=1), np.sum(axis * k0, axis=1)) / angle
    # both estimates are exact on the segment; each counts by the length that it stands for
    weight_tip, weight_axis = np.sum(delta**2, axis=1), (radian_mm * angle) ** 2
    moved = np.sum((tip - start) * delta, axis=1)
    return np.asarray((moved + weight_axis * turned) / (weight_tip + weight_axis))


def measure_off_segment(path: ToolPath, segment: Ints, u: Array, measured: Measured) -> tuple[Array, Array, Array]:
    """Distance from the programmed segment at u: tip (mm), tool axis (rad), rotary angle (rad).

    Along a great circle, and of poses ``by_axis``, the rotary angle counts by the motion of the tool axis: near the
    pole C turns fast there, and the smallest error of u is large in C. A C that is a turn off counts in full. For JOINT
    segments: sliders (mm), and twice the larger table angle.
    """
    tip, angles = find_programmed_pose(path, segment, u)
    tip_off = measure_rows(measured.tip - tip)
    axis_off = measure_rows(measured.axis - find_tool_axis(angles))
    rotary_off = np.abs(measured.angles[:, 1] - angles[:, 1])
    on_circle = np.flatnonzero((path.circle[segment] >= 0) | measured.by_axis)
    rotary_off[on_circle] = count_by_axis(rotary_off[on_circle], angles[on_circle, 0])
    joint = np.flatnonzero(path.kind[segment] == SegmentKind.JOINT)
    if len(joint):
        ends = path.joints[path.joint[segment[joint]]]
        off = np.abs(measured.q[joint] - ends[:, 0] - u[joint, None] * (ends[:, 1] - ends[:, 0]))
        tip_off[joint] = off[:, :-2].max(axis=1)
        axis_off[joint] = rotary_off[joint] = off[:, -2:].max(axis=1)
    return tip_off, axis_off, rotary_off


def count_by_axis(rotary_off: Array, tilt: Array) -> Array:
    """Deviations (n,) of C as motions of the tool axis with A at ``tilt`` (n,); a C that is a turn off in full."""
    return np.where(rotary_off < OTHER_TURN, rotary_off * np.abs(np.sin(tilt)), rotary_off)


def measure_deviation_nearby(
    path: ToolPath, segment: Ints, u: Array, measured: Measured, tip_bound: Array, angle_bound: Array, reach: Array
) -> tuple[Array, Array, Array]:
    """As :func:`measure_off_segment`, at the best pose within ``reach`` (n,) of u.

    The best pose is the one whose larger share of the two bounds (mm, rad) is smallest.

    A projection weighs millimetres against radians; a tolerance is kept where one pose is near enough in both.
    """
    low, high = np.clip(u - reach, 0.0, 1.0), np.clip(u + reach, 0.0, 1.0)
    row = np.arange(len(segment))
    rows = np.repeat(row, NEARBY_POINTS)
    many = measured.select(rows)
    for _ in range(NEARBY_ROUNDS):
        at = low[:, None] + np.linspace(0.0, 1.0, NEARBY_POINTS) * (high - low)[:, None]
        tip, axis, rotary = measure_off_segment(path, segment[rows], at.ravel(), many)
        share = np.maximum(tip / tip_bound[rows], np.maximum(axis, rotary) / angle_bound[rows]).reshape(at.shape)
        best = np.argmin(share, axis=1)
        low, high = at[row, np.maximum(best - 1, 0)], at[row, np.minimum(best + 1, NEARBY_POINTS - 1)]
    chosen = row * NEARBY_POINTS + best
    return tip[chosen], axis[chosen], rotary[chosen]
