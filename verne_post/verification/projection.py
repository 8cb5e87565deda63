"""Where on its programmed segment a measured pose is, and how far off: projections, in closed form but for splines.

The evaluation of the segments is independent of the tool path's, so that an error there shows as a deviation.
"""

from functools import cached_property
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import measure_rows, sum_rows
from verne_post.model.poses import JointPoses
from verne_post.model.toolpath import ArcSegments, SegmentKind, ToolPath, TurnSegments
from verne_post.verification.linear_joints import find_angles, find_lines, find_rows
from verne_post.verification.splines import (
    MeasuredSplines,
    evaluate_spline_points,
    find_parameters_at,
    measure_lengths_at,
    measure_splines,
    project,
)

#: Weight of a radian against a millimetre in the projection.
RADIAN_MM: Final = 50.0
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
    """

    by_axis: bool = False

    @cached_property
    def axis(self) -> Array:
        """Unit tool axes (n, 3) of the nominal angles, table frame."""
        return find_tool_axis(self.angles)

    def select(self, rows: Ints) -> "Measured":
        """The poses of some rows."""
        return Measured(self.q[rows], self.tip[rows], self.angles[rows], self.by_axis)

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
        u[turn] = _turn_u(path, segment[turn], measured.select(turn))
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
    on_circle = _find_on_circles(path, segment)
    if len(on_circle):
        each = np.broadcast_to(radian_mm, len(segment))[on_circle]
        u[on_circle] = _project_on_great_circles(
            path, segment[on_circle], tip[on_circle], find_tool_axis(angles[on_circle]), each
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
        at, slope = _evaluate_arcs(arcs, row, u)
        rest = measured.tip - at
        rest_turn = weight * (now - start - u[:, None] * turn)
        square = np.sum(slope**2, axis=1) + np.sum(weight * turn**2, axis=1)
        u = u + (np.sum(rest * slope, axis=1) + np.sum(rest_turn * turn, axis=1)) / square
    return u


def _turn_u(path: ToolPath, segment: Ints, measured: Measured) -> Array:
    """As :func:`project_unwrapped`, on turns of the table: A and C go linearly, and the tip refines what they say."""
    now, start, turn = find_lines(path, segment, measured.angles)
    turned, square = np.sum((now - start) * turn, axis=1), np.sum(turn**2, axis=1)
    u = np.divide(turned, square, out=np.zeros_like(turned), where=square > 0)  # none at a pole: the tip says it
    for _ in range(ARC_STEPS):
        at, slope = _turn_point(path.turns, path.turn[segment], u)
        rest = RADIAN_MM**2 * (now - start - u[:, None] * turn)
        square = np.sum(slope**2, axis=1) + RADIAN_MM**2 * np.sum(turn**2, axis=1)
        u = u + (np.sum((measured.tip - at) * slope, axis=1) + np.sum(rest * turn, axis=1)) / square
    return u


def _turn_point(turns: TurnSegments, row: Ints, u: Array) -> tuple[Array, Array]:
    """Points (n, 3) of turns and their derivatives by u, in components.

    A place in the machine turns back by A about x, comes to the rotary centre, and turns back by C; linear motions add.
    """
    delta = turns.last[row] - turns.first[row]
    (x, y, z), (dx, dy, dz) = (turns.first[row] + u[:, None] * delta).T, delta.T
    rate_a, rate_c = (turns.last_angles[row] - turns.angles[row]).T
    a, c = turns.angles[row, 0] + u * rate_a, turns.angles[row, 1] + u * rate_c
    sin_a, cos_a, sin_c, cos_c = np.sin(a), np.cos(a), np.sin(c), np.cos(c)
    tilted_y, tilted_z = cos_a * y + sin_a * z, cos_a * z - sin_a * y
    slide, drift = turns.slide[row], turns.drift[row]
    tilted = np.stack([x, tilted_y, tilted_z])
    rate = np.stack([dx, cos_a * dy + sin_a * dz + rate_a * tilted_z, cos_a * dz - sin_a * dy - rate_a * tilted_y])
    if turns.lean.any():  # of a nutating pair: back from the frame of its tilting joint
        sin_l, cos_l = np.sin(turns.lean[row]), np.cos(turns.lean[row])
        tilted, rate = (np.stack([cos_l * a - sin_l * c, b, sin_l * a + cos_l * c]) for a, b, c in (tilted, rate))
    px, py, pz = tilted + (u[:, None] * slide - turns.offset[row]).T
    vx, vy, vz = rate + slide.T
    point = (
        turns.shift[row] + u[:, None] * drift + np.stack([cos_c * px + sin_c * py, cos_c * py - sin_c * px, pz], axis=1)
    )
    slope_x = cos_c * vx + sin_c * vy + rate_c * (cos_c * py - sin_c * px)
    slope_y = cos_c * vy - sin_c * vx - rate_c * (cos_c * px + sin_c * py)
    return point, np.stack([slope_x, slope_y, vz], axis=1) + drift


#: Places and weights of Gauss's rule over 0 to 1.
_GAUSS_PLACES, _GAUSS_WEIGHTS = (
    0.5 * (part + shift) for part, shift in zip(np.polynomial.legendre.leggauss(24), (1.0, 0.0), strict=True)
)


def _turn_lengths(path: ToolPath, segment: Ints, u: Array) -> Array:
    """As :func:`measure_lengths_to`, on turns of the table, whose tip does not move evenly."""
    row, even = path.turn[segment], RADIAN_MM * measure_rows(find_lines(path, segment, path.start[segment, 3:])[2])
    length = np.zeros(len(segment))
    for place, weight in zip(_GAUSS_PLACES, _GAUSS_WEIGHTS, strict=True) if len(segment) else ():
        slope = _turn_point(path.turns, row, place * u)[1]
        length += weight * u * np.hypot(measure_rows(slope), even)
    return length


def _measure(path: ToolPath, segment: Ints) -> tuple[MeasuredSplines, Ints]:
    """The splines among segments (n,), measured, and the piece of each."""
    pieces, piece = np.unique(path.spline[segment], return_inverse=True)
    return measure_splines(path.splines.pieces.select(pieces), RADIAN_MM), piece


def _project_on_splines(
    path: ToolPath, segment: Ints, measured: Measured, fresh: Mask, u_before: float, bounds: tuple[Array, Array] | None
) -> Array:
    """As :func:`project_unwrapped`, on splines."""
    splines, piece = _measure(path, segment)
    pose = np.concatenate([measured.tip, measured.angles - path.start[segment, 3:]], axis=1)
    return project(splines, piece, pose, fresh, u_before, RADIAN_MM, bounds)


def _project_on_great_circles(path: ToolPath, segment: Ints, tip: Array, axis: Array, radian_mm: Array) -> Array:
    """Nearest u on straight segments whose tool axis follows a great circle."""
    start, delta = path.start[segment, :3], path.end[segment, :3] - path.start[segment, :3]
    k0, k1, angle = _span_great_circle(path, segment)
    across = np.cross(np.cross(k0, k1), k0)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    turned = np.arctan2(np.sum(axis * across, axis=1), np.sum(axis * k0, axis=1)) / angle
    # both estimates are exact on the segment; each counts by the length that it stands for
    weight_tip, weight_axis = np.sum(delta**2, axis=1), (radian_mm * angle) ** 2
    moved = np.sum((tip - start) * delta, axis=1)
    return np.asarray((moved + weight_axis * turned) / (weight_tip + weight_axis))


def _find_on_circles(path: ToolPath, segment: Ints) -> Ints:
    """Which of segments (n,) follow a great circle."""
    on_circle = (path.circle[segment] >= 0) & (path.spline[segment] < 0)
    on_circle[find_rows(path, segment)] = False
    return np.flatnonzero(on_circle)


def _span_great_circle(path: ToolPath, segment: Ints) -> tuple[Array, Array, Array]:
    """Tool axes at both ends of segments, and the angle between them."""
    k0, k1 = find_tool_axis(path.start[segment, 3:]), find_tool_axis(path.end[segment, 3:])
    return k0, k1, np.arctan2(measure_rows(np.cross(k0, k1)), np.sum(k0 * k1, axis=1))


def measure_metric_lengths(path: ToolPath) -> Array:
    """Metric length (n,) of each segment: of tip and tool axis together, or of tip and A, C where they are linear; mm.

    0 for JOINT segments, whose tip follows from the joints: there the velocity limits keep rows from being left out.
    """
    length = np.where(path.kind == SegmentKind.JOINT, 0.0, path.length)
    arc = np.flatnonzero(path.arc >= 0)
    length[arc] = _measure_arc_lengths(path, arc, np.ones(len(arc)))
    turn = np.flatnonzero(path.turn >= 0)
    length[turn] = _turn_lengths(path, turn, np.ones(len(turn)))
    spline = np.flatnonzero(path.spline >= 0)
    if len(spline):
        splines, piece = _measure(path, spline)
        length[spline] = splines.measure_total_metric(piece)
    linear = find_rows(path, straight := np.flatnonzero(path.kind == SegmentKind.LINE))
    linear = straight[linear]
    turns = find_lines(path, linear, path.start[linear, 3:])[2]
    length[linear] = np.hypot(
        measure_rows(path.end[linear, :3] - path.start[linear, :3]), RADIAN_MM * measure_rows(turns)
    )
    on_circle = _find_on_circles(path, np.arange(len(path)))
    tip = measure_rows(path.end[on_circle, :3] - path.start[on_circle, :3])
    length[on_circle] = np.hypot(tip, RADIAN_MM * _span_great_circle(path, on_circle)[2])
    return length


def measure_progress_lengths(path: ToolPath, metric_length: Array) -> Array:
    """Length (n,) that u is a share of: of the tip alone on splines, else the metric length (n,), mm."""
    length = metric_length.copy()
    spline = np.flatnonzero(path.spline >= 0)
    if len(spline):
        splines, piece = _measure(path, spline)
        length[spline] = splines.measure_lengths(piece)
    return length


def measure_lengths_to(path: ToolPath, segment: Ints, u: Array, metric_length: Array) -> Array:
    """Metric length (n,) from the start of segments to their u (n,), mm; ``metric_length`` of all segments."""
    length = u * metric_length[segment]
    arc = np.flatnonzero(path.arc[segment] >= 0)
    length[arc] = _measure_arc_lengths(path, segment[arc], u[arc])
    turn = np.flatnonzero(path.turn[segment] >= 0)
    length[turn] = _turn_lengths(path, segment[turn], u[turn])
    spline = np.flatnonzero(path.spline[segment] >= 0)
    if len(spline):
        splines, piece = _measure(path, segment[spline])
        inside = np.clip(u[spline], 0.0, 1.0)
        at = find_parameters_at(splines, piece, inside, RADIAN_MM)
        beyond = (u[spline] - inside) * splines.measure_total_metric(piece)
        length[spline] = measure_lengths_at(splines, piece, at, RADIAN_MM)[1] + beyond
    return np.asarray(length)


def _measure_arc_lengths(path: ToolPath, segment: Ints, u: Array) -> Array:
    """As :func:`measure_lengths_to`, on arcs: length is not linear in u where the radius changes."""
    arcs, row = path.arcs, path.arc[segment]
    grow = arcs.r1[row] - arcs.r0[row]
    around = arcs.sweep[row] * u * (arcs.r0[row] + 0.5 * u * grow)
    turn = measure_rows(find_lines(path, segment, path.start[segment, 3:])[2])
    even = grow**2 + np.sum(arcs.rise[row] ** 2, axis=1) + (RADIAN_MM * turn) ** 2
    return np.asarray(np.sign(u) * np.sqrt(around**2 + u**2 * even))


def find_tip_paces(path: ToolPath) -> Array:
    """Seconds (n,) at the feed per mm of the tip, of each segment; 0 where the feed rate is a time, and for rapids."""
    delta = path.end - path.start
    turn, tip = measure_rows(delta[:, 3:]), measure_rows(delta[:, :3])
    arc = np.flatnonzero(path.arc >= 0)
    tip[arc] = np.sqrt(np.maximum(path.length[arc] ** 2 - (RADIAN_MM * turn[arc]) ** 2, 0.0))
    spline = np.flatnonzero(path.spline >= 0)
    if len(spline):
        splines, piece = _measure(path, spline)
        tip[spline] = splines.measure_lengths(piece)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(path.timed | (path.feed_time == 0.0), 0.0, path.feed_time / tip)


def _interpolate_great_circle(path: ToolPath, segment: Ints, u: Array) -> Array:
    """Nominal angles on a great circle: spherical interpolation between the tool axes at both ends."""
    k0, k1, angle = _span_great_circle(path, segment)
    share0, share1 = np.sin((1 - u) * angle) / np.sin(angle), np.sin(u * angle) / np.sin(angle)
    axis = share0[:, None] * k0 + share1[:, None] * k1
    start, end = path.start[segment, 3:], path.end[segment, 3:]
    negative = (start[:, 0] < 0) | (end[:, 0] < 0)
    tilt = np.where(negative, -1.0, 1.0) * np.arccos(np.clip(axis[:, 2], -1.0, 1.0))
    c = np.arctan2(axis[:, 0], axis[:, 1]) + np.where(negative, np.pi, 0.0)
    middle = 0.5 * (start[:, 1] + end[:, 1])  # C stays within half a turn of it
    return np.stack([tilt, c - 2 * np.pi * np.round((c - middle) / (2 * np.pi))], axis=1)


def _evaluate_arcs(arcs: ArcSegments, row: Ints, u: Array) -> tuple[Array, Array]:
    """Points (n, 3) of arcs, and their derivatives by u."""
    phi = (u * arcs.sweep[row])[:, None]
    grow = (arcs.r1 - arcs.r0)[row][:, None]
    radius = arcs.r0[row][:, None] + u[:, None] * grow
    toward = np.cos(phi) * arcs.e1[row] + np.sin(phi) * arcs.e2[row]
    across = np.cos(phi) * arcs.e2[row] - np.sin(phi) * arcs.e1[row]
    point = arcs.center[row] + radius * toward + u[:, None] * arcs.rise[row]
    return point, grow * toward + radius * arcs.sweep[row][:, None] * across + arcs.rise[row]


def find_programmed_pose(path: ToolPath, segment: Ints, u: Array) -> tuple[Array, Array]:
    """Tip (n, 3) and nominal angles (n, 2) at u of segments that are no JOINT segments."""
    programmed = path.start[segment] + u[:, None] * (path.end[segment] - path.start[segment])
    tip, angles = programmed[:, :3], programmed[:, 3:]
    arc = np.flatnonzero(path.kind[segment] == SegmentKind.ARC)
    if len(arc):
        tip[arc] = _evaluate_arcs(path.arcs, path.arc[segment[arc]], u[arc])[0]
    turn = np.flatnonzero(path.turn[segment] >= 0)
    if len(turn):
        tip[turn] = _turn_point(path.turns, path.turn[segment[turn]], u[turn])[0]
    spline = np.flatnonzero(path.spline[segment] >= 0)
    if len(spline):
        mine = segment[spline]
        splines, piece = _measure(path, mine)
        point = evaluate_spline_points(
            splines.pieces, piece, find_parameters_at(splines, piece, np.clip(u[spline], 0.0, 1.0), RADIAN_MM)
        )
        tip[spline], angles[spline] = point[:, :3], path.start[mine, 3:] + point[:, 3:]
    if len(linear := find_rows(path, segment)):
        angles[linear] = find_angles(path, segment[linear], u[linear])
    on_circle = _find_on_circles(path, segment)
    if len(on_circle):
        angles[on_circle] = _interpolate_great_circle(path, segment[on_circle], u[on_circle])
    return tip, angles


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
    moved = rotary_off[on_circle] * np.abs(np.sin(angles[on_circle, 0]))
    rotary_off[on_circle] = np.where(rotary_off[on_circle] < OTHER_TURN, moved, rotary_off[on_circle])
    joint = np.flatnonzero(path.kind[segment] == SegmentKind.JOINT)
    if len(joint):
        ends = path.joints[path.joint[segment[joint]]]
        off = np.abs(measured.q[joint] - ends[:, 0] - u[joint, None] * (ends[:, 1] - ends[:, 0]))
        tip_off[joint] = off[:, :-2].max(axis=1)
        axis_off[joint] = rotary_off[joint] = off[:, -2:].max(axis=1)
    return tip_off, axis_off, rotary_off


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


def find_tool_axis(angles: Array) -> Array:
    """Unit tool axes (n, 3) of nominal angles (n, 2), table frame."""
    a, c = angles[:, 0], angles[:, 1]
    tilted = np.sin(a)
    return np.stack([tilted * np.sin(c), tilted * np.cos(c), np.cos(a)], axis=1)
