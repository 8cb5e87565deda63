"""Moves -> ToolPath: every motion becomes a piece, pieces that continue each other become a run."""

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.rotations import axis_of_angles
from verne_post.base.tolerances import (
    CONTINUATION,
    OPPOSITE,
    POLE_CROSSING,
    POLE_SINE,
    POSE_DECIMALS_MM,
    POSE_DECIMALS_RAD,
    ZERO_ANGLE,
    ZERO_LENGTH_MM,
)
from verne_post.base.units import DEG_PER_RAD, SECONDS_PER_MINUTE
from verne_post.model.findings import InputError, finding
from verne_post.model.moves import FeedMode, Frame, MoveKind, Moves, PathMode
from verne_post.model.protocols import TableCoordinates
from verne_post.model.toolpath import ArcPieces, GreatCircles, PieceKind, ToolPath
from verne_post.toolpath.evaluate import arc_derivatives

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Millimetres of path that one radian of rotation counts for in the metric length of a piece:
#: a typical distance of the tip from the table's axes, so that pure rotations have length too.
ROTARY_METRIC_MM: Final = 50.0
#: Normal of the planes XY, ZX, YZ in program coordinates.
_NORMALS: Final = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])


#: Chooses branches for a path: angles at start and end of every piece, or None to leave them as they are.
BranchPlanner = Callable[[ToolPath], "tuple[Array, Array] | None"]


def build_path(
    moves: Moves, coordinates: TableCoordinates, orientation: str = "auto", planner: BranchPlanner | None = None
) -> ToolPath:
    """Turn moves into pieces in the table frame.

    Parameters
    ----------
    moves : Moves
    coordinates : TableCoordinates
        What program coordinates mean on this machine.
    orientation : str
        How the tool axis goes between two poses of a feed move: "vector" along the great circle, "angles" linear in A
        and C, "auto" along the great circle between tool axes and linear between A and C words.
    planner : callable, optional
        Chooses other angles for the same tool axes.

    Returns
    -------
    ToolPath
        Moves of no length are dropped; every other move is one piece.

    Raises
    ------
    InputError
        VP007 where a great circle is not defined, or does not lead to the programmed angles.
    """
    length_of = np.array([frame.tool_length for frame in moves.frames])
    frame_length = length_of[moves.frame] if len(moves) else np.empty(0)
    first = _poses(coordinates, moves.start[None], moves.start_frame)[0]
    if len(moves):
        first = _on_gauge_line(first[None], moves.start_frame.tool_length - frame_length[:1])[0]
    end = np.empty((len(moves), 5))
    for index, frame in enumerate(moves.frames):
        rows = np.flatnonzero(moves.frame == index)
        end[rows] = _poses(coordinates, moves.end[rows], frame)

    motion = moves.kind != MoveKind.DWELL
    start = _starts(first, end, frame_length)
    kept = motion & (_moving(end - start) | (moves.kind == MoveKind.ARC))
    start = _starts_after_kept(first, end, frame_length, kept)
    row = np.flatnonzero(kept)
    start, end_kept = start[row], end[row]
    free = np.isfinite(moves.vector[row, 0])
    if free.any():
        across_the_pole(start, end_kept, free)
    arc_rows = np.flatnonzero(moves.kind[row] == MoveKind.ARC)
    arcs = _arcs(moves, row[arc_rows], start[arc_rows], end_kept[arc_rows], coordinates)
    path = _assembled(moves, row, start, end_kept, arcs, first, frame_length, orientation)
    chosen = planner(path) if planner is not None and len(row) else None
    if chosen is None:
        return path
    start = np.concatenate([start[:, :3], chosen[0]], axis=1)
    end_kept = np.concatenate([end_kept[:, :3], chosen[1]], axis=1)
    first = np.concatenate([first[:3], start[0, 3:]])
    still = _moving(end_kept - start) | (moves.kind[row] == MoveKind.ARC)  # a turn may have become superfluous
    row, start, end_kept = row[still], start[still], end_kept[still]
    return _assembled(moves, row, start, end_kept, arcs, first, frame_length, orientation)


def across_the_pole(start: Array, end: Array, free: Mask) -> None:
    """Angles of free pieces that touch or cross the pole: C stays, and A goes through zero. Changes both in place.

    The pieces arrive with the tilt on one side of the pole and C less than half a turn away from the piece before.
    """
    vertical_start, vertical_end = (np.abs(np.sin(angles[:, 3])) <= POLE_SINE for angles in (start, end))
    leaving = free & vertical_start & ~vertical_end
    start[leaving, 4] = end[leaving, 4]
    arriving = free & vertical_end & ~vertical_start
    end[arriving, 4] = start[arriving, 4]
    k0, k1 = axis_of_angles(start[:, 3], start[:, 4]), axis_of_angles(end[:, 3], end[:, 4])
    normal = np.cross(k0, k1)
    size = np.linalg.norm(normal, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        away = np.abs(normal[:, 2]) / size  # sine of the great circle's distance from the pole
    opposite_sides = k0[:, 0] * k1[:, 0] + k0[:, 1] * k1[:, 1] < 0
    crossing = free & ~vertical_start & ~vertical_end & opposite_sides & (away < POLE_CROSSING)
    end[crossing, 3] *= -1.0
    end[crossing, 4] += np.where(end[crossing, 4] > start[crossing, 4], -np.pi, np.pi)


def _assembled(
    moves: Moves, row: NDArray[np.intp], start: Array, end: Array, arcs: ArcPieces, first: Array,
    frame_length: Array, orientation: str,
) -> ToolPath:  # fmt: skip
    """The tool path of pieces whose poses are known."""
    arc_rows = np.flatnonzero(moves.kind[row] == MoveKind.ARC)
    arc = np.full(len(row), -1, dtype=np.int32)
    arc[arc_rows] = np.arange(len(arc_rows))
    free = np.isfinite(moves.vector[row, 0])
    delta = end - start
    tip_length = np.linalg.norm(delta[:, :3], axis=1)
    tip_length[arc_rows] = _arc_lengths(arcs)
    angle = np.linalg.norm(delta[:, 3:], axis=1)
    del delta  # the largest array here, and what follows needs as much again
    kind = np.full(len(row), PieceKind.LINE, dtype=np.int8)
    kind[arc_rows] = PieceKind.ARC
    circle, circles = _great_circles(moves, row, start, end, free, orientation)
    swing = angle.copy()
    swing[circle >= 0] = circles.angle
    length = np.hypot(tip_length, ROTARY_METRIC_MM * angle)
    feed_time = _feed_times(moves, row, tip_length, swing)

    dwell = np.flatnonzero((moves.kind == MoveKind.DWELL) & (moves.feed > 0))
    dwell_before = np.searchsorted(row, dwell)
    joined = _joined(moves, row, kind, start, end, arcs, arc, length, feed_time)
    joined[1:] &= (circle[1:] < 0) & (circle[:-1] < 0)
    joined[dwell_before[(dwell_before > 0) & (dwell_before < len(row))]] = False
    run = np.cumsum(~joined).astype(np.int32) - 1
    return ToolPath(
        line=moves.line[row],
        kind=kind,
        start=start,
        end=end,
        tool_length=frame_length[row],
        feed_time=feed_time,
        length=length,
        arc=arc,
        arcs=arcs,
        circle=circle,
        circles=circles,
        free=free,
        joints=np.empty((0, 2, 0)),
        joint=np.full(len(row), -1, dtype=np.int32),
        move=row.astype(np.int32),
        run=run,
        dwell_run=np.append(run, run[-1] + 1 if len(run) else 0)[dwell_before].astype(np.int32),
        dwell_seconds=moves.feed[dwell],
        dwell_line=moves.line[dwell],
        first_pose=first,
        first_tool_length=float(frame_length[0]) if len(moves) else moves.start_frame.tool_length,
    )


def _great_circles(
    moves: Moves, row: NDArray[np.intp], start: Array, end: Array, free: Mask, orientation: str
) -> tuple[NDArray[np.int32], GreatCircles]:
    """Which pieces swing along a great circle that is not linear in A and C, and those circles."""
    circle = np.full(len(row), -1, dtype=np.int32)
    none = GreatCircles(np.empty((0, 3)), np.empty((0, 3)), np.empty(0))
    fed = moves.kind[row] == MoveKind.FEED
    wanted = {"auto": free, "vector": free | fed, "angles": np.zeros(len(row), dtype=bool)}[orientation]
    turning = np.abs(end[:, 4] - start[:, 4]) > ZERO_ANGLE
    upright = (np.abs(np.sin(start[:, 3])) <= POLE_SINE) | (np.abs(np.sin(end[:, 3])) <= POLE_SINE)
    if (bad := np.flatnonzero(wanted & ~free & turning & (upright | (start[:, 3] * end[:, 3] < 0)))).size:
        raise _no_circle(moves, row[bad[0]], "passes the pole, where C turns")
    if (bad := np.flatnonzero(wanted & free & _opposite(start, end))).size:
        raise _no_circle(moves, row[bad[0]], "is not defined between opposite tool axes")
    which = np.flatnonzero(wanted & turning & ~upright & (start[:, 3] * end[:, 3] > 0))
    if not len(which):
        return circle, none
    k0, k1 = (axis_of_angles(angles[which, 3], angles[which, 4]) for angles in (start, end))
    cosine = np.sum(k0 * k1, axis=1)
    across = k1 - cosine[:, None] * k0
    sine = np.linalg.norm(across, axis=1)
    if (bad := np.flatnonzero(_opposite(start[which], end[which]))).size:
        raise _no_circle(moves, row[which[bad[0]]], "is not defined between opposite tool axes")
    if (bad := np.flatnonzero(np.abs(end[which, 4] - start[which, 4]) >= np.pi)).size:
        raise _no_circle(
            moves, row[which[bad[0]]], "does not lead to the programmed C, which turns by half a turn or more"
        )
    which, k0, across, sine, cosine = (a[sine > ZERO_ANGLE] for a in (which, k0, across, sine, cosine))
    circle[which] = np.arange(len(which))
    return circle, GreatCircles(k0, across / sine[:, None], np.arctan2(sine, cosine))


def _opposite(start: Array, end: Array) -> Mask:
    """Where the tool axes at both ends point opposite ways."""
    k0, k1 = axis_of_angles(start[:, 3], start[:, 4]), axis_of_angles(end[:, 3], end[:, 4])
    return np.asarray(np.linalg.norm(k0 + k1, axis=1) < OPPOSITE)


def _no_circle(moves: Moves, move: np.intp, why: str) -> InputError:
    line = int(moves.line[move])
    text = f"the great circle from tool axis to tool axis {why}; use --orientation angles, or smaller steps"
    return InputError(finding("VP007", text, line=line, last_line=line, worst_line=line))


def _poses(coordinates: TableCoordinates, program: Array, frame: Frame) -> Array:
    """Tip and angles in the table frame, without the noise of how they were computed: planning would magnify it."""
    tip, angles = coordinates.to_table(program, frame)
    return np.concatenate([np.round(tip, POSE_DECIMALS_MM), np.round(angles, POSE_DECIMALS_RAD)], axis=-1)


def _on_gauge_line(pose: Array, shorter_by: Array) -> Array:
    """The same place of the gauge line with a tool that is shorter: the tip moves up the tool axis."""
    moved = pose.copy()
    moved[:, :3] += shorter_by[:, None] * axis_of_angles(pose[:, 3], pose[:, 4])
    return moved


def _starts(first: Array, end: Array, tool_length: Array) -> Array:
    """Where each move starts: the end of the move before, with its own tool length."""
    if not len(end):
        return end
    before = np.vstack([first[None], end[:-1]])
    shorter = np.append(0.0, tool_length[:-1] - tool_length[1:])
    changed = np.flatnonzero(shorter)
    before[changed] = _on_gauge_line(before[changed], shorter[changed])
    return before


def _moving(delta: Array) -> Mask:
    tip = np.linalg.norm(delta[:, :3], axis=1) > ZERO_LENGTH_MM
    return tip | (np.abs(delta[:, 3:]) > ZERO_ANGLE).any(axis=1)


def _starts_after_kept(first: Array, end: Array, tool_length: Array, kept: Mask) -> Array:
    """Starts measured from the end of the last move that was kept, so that no gap opens between pieces."""
    if not len(end):
        return end
    last = np.where(kept, np.arange(len(end)), -1)
    last = np.append(-1, np.maximum.accumulate(last)[:-1])
    poses = np.vstack([end, first[None]])  # row -1: the first pose
    lengths = np.append(tool_length, tool_length[0])
    return _on_gauge_line(poses[last], lengths[last] - tool_length)


def _arcs(moves: Moves, row: NDArray[np.intp], start: Array, end: Array, coordinates: TableCoordinates) -> ArcPieces:
    """Arc geometry in the table frame, from centre, plane and sweep in program coordinates."""
    center, normal = np.empty((len(row), 3)), np.empty((len(row), 3))
    for index in np.unique(moves.frame[row]):
        mine = np.flatnonzero(moves.frame[row] == index)
        frame = moves.frames[index]
        program = moves.end[row[mine]].copy()
        arc = moves.arc[row[mine]]
        program[:, :3] = moves.arcs.center[arc]
        center[mine] = np.round(coordinates.to_table(program, frame)[0], POSE_DECIMALS_MM)
        normal[mine] = coordinates.displacement(_NORMALS[moves.arcs.plane[arc]], frame)
    to_start = start[:, :3] - center
    to_end = end[:, :3] - center
    height = np.sum(to_start * normal, axis=1, keepdims=True)
    center = center + height * normal  # the centre at the height of the start
    to_start = to_start - height * normal
    rise = np.sum((end - start)[:, :3] * normal, axis=1, keepdims=True) * normal
    to_end = to_end - np.sum(to_end * normal, axis=1, keepdims=True) * normal
    r0, r1 = np.linalg.norm(to_start, axis=1), np.linalg.norm(to_end, axis=1)
    e1 = to_start / r0[:, None]
    sweep = np.radians(moves.arcs.sweep[moves.arc[row]])
    return ArcPieces(center, e1, np.cross(normal, e1), rise, r0, r1, sweep)


def _arc_lengths(arcs: ArcPieces) -> Array:
    """Longest path length per unit of u, mm: what the tip speed follows from."""
    around = np.maximum(arcs.r0, arcs.r1) * np.abs(arcs.sweep)
    return np.sqrt(around**2 + (arcs.r1 - arcs.r0) ** 2 + np.sum(arcs.rise**2, axis=1))


def _feed_times(moves: Moves, row: NDArray[np.intp], tip_length: Array, angle: Array) -> Array:
    """Seconds that each piece takes at its feed; 0 for rapids."""
    feed = moves.feed[row].copy()
    per_revolution = moves.feed_mode[row] == FeedMode.PER_REVOLUTION
    feed[per_revolution] *= moves.spindle[row][per_revolution]
    distance = np.where(tip_length > ZERO_LENGTH_MM, tip_length, DEG_PER_RAD * angle)
    return np.where(moves.kind[row] == MoveKind.RAPID, 0.0, SECONDS_PER_MINUTE * distance / feed)


def _tip_derivatives(
    rate: Array, arcs: ArcPieces, arc: NDArray[np.int32], length: Array, piece: NDArray[np.intp], u: float
) -> Array:
    """First to third derivative (m, 3, 3) of the tip by metric length at parameter u of pieces (m,)."""
    found = np.zeros((len(piece), 3, 3))
    found[:, 0] = rate[piece, :3]
    curved = np.flatnonzero(arc[piece] >= 0)
    at = np.full(len(curved), u)
    for order, derivative in enumerate(arc_derivatives(arcs, arc[piece[curved]], at), start=1):
        found[curved, order - 1] = derivative / length[piece[curved], None] ** order
    return found


def _joined(
    moves: Moves, row: NDArray[np.intp], kind: NDArray[np.int8], start: Array, end: Array,
    arcs: ArcPieces, arc: NDArray[np.int32], length: Array, feed_time: Array,
) -> Mask:  # fmt: skip
    """True where a piece continues the one before without a stop, in shape, rate and feed."""
    joined = np.zeros(len(row), dtype=bool)
    if len(row) < 2:
        return joined
    rate = (end - start) / length[:, None]
    jump = rate[1:] - rate[:-1]
    curved = kind == PieceKind.ARC
    beside = np.flatnonzero(curved[1:] | curved[:-1])  # pieces with an arc on one side of the corner behind them
    leaving, arriving = (_tip_derivatives(rate, arcs, arc, length, beside + k, u) for k, u in ((1, 0.0), (0, 1.0)))
    bent = leaving - arriving
    jump[beside, :3] = bent[:, 0]
    jump[:, 3:] *= ROTARY_METRIC_MM
    smooth = np.asarray((np.abs(jump) < CONTINUATION).all(axis=1))
    smooth[beside] &= (np.abs(bent[:, 1:]) < CONTINUATION).all(axis=(1, 2))
    del jump  # as large as the path
    same_kind = kind[1:] == kind[:-1]
    pace = feed_time / length
    same_pace = np.abs(pace[1:] - pace[:-1]) <= CONTINUATION * pace[1:]
    tool = np.array([frame.tool_length for frame in moves.frames])[moves.frame[row]]
    exact_stop = np.array([control.mode == PathMode.EXACT_STOP for control in moves.controls])[moves.control[row]]
    contact = np.abs(start[1:] - end[:-1]).max(axis=1) == 0.0
    joined[1:] = smooth & same_kind & same_pace & (tool[1:] == tool[:-1]) & ~exact_stop[:-1] & contact
    return joined
