"""The programmed segments at their parameter u: poses, and lengths along them.

This evaluation is independent of the tool path's, so that an error there shows as a deviation.
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.rows import measure_rows
from verne_post.model.toolpath import ArcSegments, SegmentKind, ToolPath, TurnSegments
from verne_post.verification.linear_joints import find_angles, find_lines, find_rows
from verne_post.verification.splines import (
    MeasuredSplines,
    evaluate_spline_points,
    find_parameters_at,
    measure_lengths_at,
    measure_splines,
)

#: Weight of a radian against a millimetre, in lengths and in projections.
RADIAN_MM: Final = 50.0
#: Places and weights of Gauss's rule over 0 to 1.
_GAUSS_PLACES, _GAUSS_WEIGHTS = (
    0.5 * (part + shift) for part, shift in zip(np.polynomial.legendre.leggauss(24), (1.0, 0.0), strict=True)
)


def find_programmed_pose(path: ToolPath, segment: Ints, u: Array) -> tuple[Array, Array]:
    """Tip (n, 3) and nominal angles (n, 2) at u of segments that are no JOINT segments."""
    programmed = path.start[segment] + u[:, None] * (path.end[segment] - path.start[segment])
    tip, angles = programmed[:, :3], programmed[:, 3:]
    arc = np.flatnonzero(path.kind[segment] == SegmentKind.ARC)
    if len(arc):
        tip[arc] = evaluate_arcs(path.arcs, path.arc[segment[arc]], u[arc])[0]
    turn = np.flatnonzero(path.turn[segment] >= 0)
    if len(turn):
        tip[turn] = evaluate_turns(path.turns, path.turn[segment[turn]], u[turn])[0]
    spline = np.flatnonzero(path.spline[segment] >= 0)
    if len(spline):
        mine = segment[spline]
        splines, piece = measure_own_splines(path, mine)
        point = evaluate_spline_points(
            splines.pieces, piece, find_parameters_at(splines, piece, np.clip(u[spline], 0.0, 1.0), RADIAN_MM)
        )
        tip[spline], angles[spline] = point[:, :3], path.start[mine, 3:] + point[:, 3:]
    if len(linear := find_rows(path, segment)):
        angles[linear] = find_angles(path, segment[linear], u[linear])
    on_circle = find_on_circles(path, segment)
    if len(on_circle):
        angles[on_circle] = _interpolate_great_circle(path, segment[on_circle], u[on_circle])
    return tip, angles


def measure_metric_lengths(path: ToolPath) -> Array:
    """Metric length (n,) of each segment: of tip and tool axis together, or of tip and A, C where they are linear; mm.

    0 for JOINT segments, whose tip follows from the joints: there the velocity limits keep rows from being left out.
    """
    length = np.where(path.kind == SegmentKind.JOINT, 0.0, path.length)
    arc = np.flatnonzero(path.arc >= 0)
    length[arc] = _measure_arc_lengths(path, arc, np.ones(len(arc)))
    turn = np.flatnonzero(path.turn >= 0)
    length[turn] = _measure_turn_lengths(path, turn, np.ones(len(turn)))
    spline = np.flatnonzero(path.spline >= 0)
    if len(spline):
        splines, piece = measure_own_splines(path, spline)
        length[spline] = splines.measure_total_metric(piece)
    linear = find_rows(path, straight := np.flatnonzero(path.kind == SegmentKind.LINE))
    linear = straight[linear]
    turns = find_lines(path, linear, path.start[linear, 3:])[2]
    length[linear] = np.hypot(
        measure_rows(path.end[linear, :3] - path.start[linear, :3]), RADIAN_MM * measure_rows(turns)
    )
    on_circle = find_on_circles(path, np.arange(len(path)))
    tip = measure_rows(path.end[on_circle, :3] - path.start[on_circle, :3])
    length[on_circle] = np.hypot(tip, RADIAN_MM * span_great_circles(path, on_circle)[2])
    return length


def measure_progress_lengths(path: ToolPath, metric_length: Array) -> Array:
    """Length (n,) that u is a share of: of the tip alone on splines, else the metric length (n,), mm."""
    length = metric_length.copy()
    spline = np.flatnonzero(path.spline >= 0)
    if len(spline):
        splines, piece = measure_own_splines(path, spline)
        length[spline] = splines.measure_lengths(piece)
    return length


def measure_lengths_to(path: ToolPath, segment: Ints, u: Array, metric_length: Array) -> Array:
    """Metric length (n,) from the start of segments to their u (n,), mm; ``metric_length`` of all segments."""
    length = u * metric_length[segment]
    arc = np.flatnonzero(path.arc[segment] >= 0)
    length[arc] = _measure_arc_lengths(path, segment[arc], u[arc])
    turn = np.flatnonzero(path.turn[segment] >= 0)
    length[turn] = _measure_turn_lengths(path, segment[turn], u[turn])
    spline = np.flatnonzero(path.spline[segment] >= 0)
    if len(spline):
        splines, piece = measure_own_splines(path, segment[spline])
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


def _measure_turn_lengths(path: ToolPath, segment: Ints, u: Array) -> Array:
    """As :func:`measure_lengths_to`, on turns of the table, whose tip does not move evenly."""
    row, even = path.turn[segment], RADIAN_MM * measure_rows(find_lines(path, segment, path.start[segment, 3:])[2])
    length = np.zeros(len(segment))
    for place, weight in zip(_GAUSS_PLACES, _GAUSS_WEIGHTS, strict=True) if len(segment) else ():
        slope = evaluate_turns(path.turns, row, place * u)[1]
        length += weight * u * np.hypot(measure_rows(slope), even)
    return length


def find_tip_paces(path: ToolPath) -> Array:
    """Seconds (n,) at the feed per mm of the tip, of each segment; 0 where the feed rate is a time, and for rapids."""
    delta = path.end - path.start
    turn, tip = measure_rows(delta[:, 3:]), measure_rows(delta[:, :3])
    arc = np.flatnonzero(path.arc >= 0)
    tip[arc] = np.sqrt(np.maximum(path.length[arc] ** 2 - (RADIAN_MM * turn[arc]) ** 2, 0.0))
    spline = np.flatnonzero(path.spline >= 0)
    if len(spline):
        splines, piece = measure_own_splines(path, spline)
        tip[spline] = splines.measure_lengths(piece)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(path.timed | (path.feed_time == 0.0), 0.0, path.feed_time / tip)


def evaluate_arcs(arcs: ArcSegments, row: Ints, u: Array) -> tuple[Array, Array]:
    """Points (n, 3) of arcs, and their derivatives by u."""
    phi = (u * arcs.sweep[row])[:, None]
    grow = (arcs.r1 - arcs.r0)[row][:, None]
    radius = arcs.r0[row][:, None] + u[:, None] * grow
    toward = np.cos(phi) * arcs.e1[row] + np.sin(phi) * arcs.e2[row]
    across = np.cos(phi) * arcs.e2[row] - np.sin(phi) * arcs.e1[row]
    point = arcs.center[row] + radius * toward + u[:, None] * arcs.rise[row]
    return point, grow * toward + radius * arcs.sweep[row][:, None] * across + arcs.rise[row]


def evaluate_turns(turns: TurnSegments, row: Ints, u: Array) -> tuple[Array, Array]:
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


def _interpolate_great_circle(path: ToolPath, segment: Ints, u: Array) -> Array:
    """Nominal angles on a great circle: spherical interpolation between the tool axes at both ends."""
    k0, k1, angle = span_great_circles(path, segment)
    share0, share1 = np.sin((1 - u) * angle) / np.sin(angle), np.sin(u * angle) / np.sin(angle)
    axis = share0[:, None] * k0 + share1[:, None] * k1
    start, end = path.start[segment, 3:], path.end[segment, 3:]
    negative = (start[:, 0] < 0) | (end[:, 0] < 0)
    tilt = np.where(negative, -1.0, 1.0) * np.arccos(np.clip(axis[:, 2], -1.0, 1.0))
    c = np.arctan2(axis[:, 0], axis[:, 1]) + np.where(negative, np.pi, 0.0)
    middle = 0.5 * (start[:, 1] + end[:, 1])  # C stays within half a turn of it
    return np.stack([tilt, c - 2 * np.pi * np.round((c - middle) / (2 * np.pi))], axis=1)


def find_on_circles(path: ToolPath, segment: Ints) -> Ints:
    """Which of segments (n,) follow a great circle."""
    on_circle = (path.circle[segment] >= 0) & (path.spline[segment] < 0)
    on_circle[find_rows(path, segment)] = False
    return np.flatnonzero(on_circle)


def span_great_circles(path: ToolPath, segment: Ints) -> tuple[Array, Array, Array]:
    """Tool axes at both ends of segments, and the angle between them."""
    k0, k1 = find_tool_axis(path.start[segment, 3:]), find_tool_axis(path.end[segment, 3:])
    return k0, k1, np.arctan2(measure_rows(np.cross(k0, k1)), np.sum(k0 * k1, axis=1))


def measure_own_splines(path: ToolPath, segment: Ints) -> tuple[MeasuredSplines, Ints]:
    """The splines among segments (n,), measured, and the piece of each."""
    pieces, piece = np.unique(path.spline[segment], return_inverse=True)
    return measure_splines(path.splines.pieces.select(pieces), RADIAN_MM), piece


def find_tool_axis(angles: Array) -> Array:
    """Unit tool axes (n, 3) of nominal angles (n, 2), table frame."""
    a, c = angles[:, 0], angles[:, 1]
    tilted = np.sin(a)
    return np.stack([tilted * np.sin(c), tilted * np.cos(c), np.cos(a)], axis=1)
