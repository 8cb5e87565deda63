"""Moves -> ToolPath: every motion becomes a piece, pieces that continue each other become a run."""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.rotations import axis_of_angles
from verne_post.base.tolerances import CONTINUATION, ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.base.units import DEG_PER_RAD, SECONDS_PER_MINUTE
from verne_post.model.moves import FeedMode, Frame, MoveKind, Moves, PathMode
from verne_post.model.protocols import TableCoordinates
from verne_post.model.toolpath import ArcPieces, PieceKind, ToolPath
from verne_post.toolpath.evaluate import arc_derivatives

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Millimetres of path that one radian of rotation counts for in the metric length of a piece:
#: a typical distance of the tip from the table's axes, so that pure rotations have length too.
ROTARY_METRIC_MM: Final = 50.0
#: Normal of the planes XY, ZX, YZ in program coordinates.
_NORMALS: Final = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])


def build_path(moves: Moves, coordinates: TableCoordinates) -> ToolPath:
    """Turn moves into pieces in the table frame.

    Parameters
    ----------
    moves : Moves
    coordinates : TableCoordinates
        What program coordinates mean on this machine.

    Returns
    -------
    ToolPath
        Moves of no length are dropped; every other move is one piece.
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
    arc_rows = np.flatnonzero(moves.kind[row] == MoveKind.ARC)
    arcs = _arcs(moves, row[arc_rows], start[arc_rows], end_kept[arc_rows], coordinates)
    arc = np.full(len(row), -1, dtype=np.int32)
    arc[arc_rows] = np.arange(len(arc_rows))

    delta = end_kept - start
    tip_length = np.linalg.norm(delta[:, :3], axis=1)
    tip_length[arc_rows] = _arc_lengths(arcs)
    angle = np.linalg.norm(delta[:, 3:], axis=1)
    kind = np.full(len(row), PieceKind.LINE, dtype=np.int8)
    kind[arc_rows] = PieceKind.ARC
    length = np.hypot(tip_length, ROTARY_METRIC_MM * angle)
    feed_time = _feed_times(moves, row, tip_length, angle)

    dwell = np.flatnonzero((moves.kind == MoveKind.DWELL) & (moves.feed > 0))
    dwell_before = np.searchsorted(row, dwell)
    joined = _joined(moves, row, kind, start, end_kept, arcs, arc, length, feed_time)
    joined[dwell_before[(dwell_before > 0) & (dwell_before < len(row))]] = False
    run = np.cumsum(~joined).astype(np.int32) - 1
    return ToolPath(
        line=moves.line[row],
        kind=kind,
        start=start,
        end=end_kept,
        tool_length=frame_length[row],
        feed_time=feed_time,
        length=length,
        arc=arc,
        arcs=arcs,
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


def _poses(coordinates: TableCoordinates, program: Array, frame: Frame) -> Array:
    tip, angles = coordinates.to_table(program, frame)
    return np.concatenate([tip, angles], axis=-1)


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
        center[mine] = coordinates.to_table(program, frame)[0]
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


def _joined(
    moves: Moves, row: NDArray[np.intp], kind: NDArray[np.int8], start: Array, end: Array,
    arcs: ArcPieces, arc: NDArray[np.int32], length: Array, feed_time: Array,
) -> Mask:  # fmt: skip
    """True where a piece continues the one before without a stop, in shape, rate and feed."""
    joined = np.zeros(len(row), dtype=bool)
    if len(row) < 2:
        return joined
    leaving = np.zeros((len(row), 3, 5))
    arriving = np.zeros((len(row), 3, 5))
    rate = (end - start) / length[:, None]
    leaving[:, 0] = arriving[:, 0] = rate
    curved = np.flatnonzero(kind == PieceKind.ARC)
    for target, u in ((leaving, 0.0), (arriving, 1.0)):
        rows = np.arange(len(curved))
        at = np.full(len(curved), u)
        for order, derivative in enumerate(arc_derivatives(arcs, rows, at), start=1):
            target[curved, order - 1, :3] = derivative / length[curved, None] ** order
    jump = leaving[1:] - arriving[:-1]
    jump[..., 3:] *= ROTARY_METRIC_MM
    smooth = (np.abs(jump) < CONTINUATION).all(axis=(1, 2))
    same_kind = kind[1:] == kind[:-1]
    pace = feed_time / length
    same_pace = np.abs(pace[1:] - pace[:-1]) <= CONTINUATION * pace[1:]
    tool = np.array([frame.tool_length for frame in moves.frames])[moves.frame[row]]
    exact_stop = np.array([control.mode == PathMode.EXACT_STOP for control in moves.controls])[moves.control[row]]
    contact = np.abs(start[1:] - end[:-1]).max(axis=1) == 0.0
    joined[1:] = smooth & same_kind & same_pace & (tool[1:] == tool[:-1]) & ~exact_stop[:-1] & contact
    return joined
