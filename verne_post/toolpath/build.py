"""Moves -> ToolPath: every motion becomes a segment, and segments that continue each other become a section."""

from collections.abc import Callable
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Mask, find_used
from verne_post.base.columns import GrowingTable, iterate_blocks
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.tolerances import (
    POLE_CROSSING,
    POLE_SINE,
    POSE_DECIMALS_MM,
    POSE_DECIMALS_RAD,
    ZERO_ANGLE,
    ZERO_LENGTH_MM,
)
from verne_post.model.moves import Frame, MoveKind, Moves
from verne_post.model.protocols import TableCoordinates
from verne_post.model.toolpath import SEGMENT_COLUMNS, ArcSegments, GreatCircles, ToolPath, TurnSegments, find_sections
from verne_post.toolpath.segments import PlacedMoves, make_segments
from verne_post.toolpath.splines import GrowingSplineSegments, find_ends, place_pieces

#: Columns of the arcs and great circles of a tool path.
_ARCS: Final = {
    "center": (float, 3),
    "e1": (float, 3),
    "e2": (float, 3),
    "rise": (float, 3),
    "r0": (float,),
    "r1": (float,),
    "sweep": (float,),
}
_TURNS: Final = {
    "first": (float, 3), "last": (float, 3), "angles": (float, 2), "last_angles": (float, 2), "offset": (float, 3),
    "shift": (float, 3),
    "slide": (float, 3), "drift": (float, 3), "lean": (float,),
}  # fmt: skip
_CIRCLES: Final = {"first": (float, 3), "side": (float, 3), "angle": (float,), "joints": (float, 6)}

#: Chooses branches for a path: nominal angles (n, 2) at start and end of every segment, or None to keep them.
BranchPlanner = Callable[[ToolPath], "tuple[Array, Array] | None"]


class _ToolPose(Struct, frozen=True, eq=False):
    """Where a tool is: pose (1, 5) of its tip, and its length (1,), mm."""

    pose: Array
    length: Array

    def add_length(self, length: Array) -> Array:
        """Poses (n, 5) of tools of other lengths (n,) with the gauge line at the same place."""
        return _keep_gauge_line(self.pose, self.length - length)


def build_path(
    moves: Moves, coordinates: TableCoordinates, orientation: str = "auto", planner: BranchPlanner | None = None
) -> ToolPath:
    """Turn moves into segments in the table frame.

    Parameters
    ----------
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
        Moves of no length are dropped; every other move is one segment.

    Raises
    ------
    InputError
        VP007: a great circle is not defined, or misses the programmed angles; VP031: a spline stops at a point.
    """
    first = _ToolPose(
        _place(coordinates, moves.start[None], moves.start_frame), np.array([moves.start_frame.tool_length])
    )
    if len(moves):
        length = np.array([moves.frames[moves.frame[0]].tool_length])
        first = _ToolPose(first.add_length(length), length)
    placed = _place_moves(moves, coordinates, first)
    path = _assemble_path(placed, first, coordinates, orientation)
    chosen = planner(path) if planner is not None and len(placed) else None
    if chosen is None:
        return path
    start, end = (
        np.concatenate([poses[:, :3], angles], axis=1)
        for poses, angles in zip((placed.start, placed.end), chosen, strict=True)
    )
    first = _ToolPose(np.concatenate([first.pose[:, :3], start[:1, 3:]], axis=1), first.length)
    # a turn of the table may have become superfluous
    needed = _is_motion(end - start) | _is_curved(moves.kind[placed.row])
    return _assemble_path(PlacedMoves(moves, placed.row, start, end).select(needed), first, coordinates, orientation)


def _place_moves(moves: Moves, coordinates: TableCoordinates, first: _ToolPose) -> PlacedMoves:
    """Find the moves that have a length, and the poses at which they start and end."""
    placed = GrowingTable(row=(np.intp,), start=(float, 5), end=(float, 5))
    length_of = np.array([frame.tool_length for frame in moves.frames])
    last = last_kept = first  # at the end of the last move of the blocks before, and of the last one that was kept
    for begin, stop in iterate_blocks(len(moves)):
        rows = np.arange(begin, stop)
        number, kind = moves.frame[begin:stop], moves.kind[begin:stop]
        length = length_of[number]
        end = np.empty((len(rows), 5))
        for index in find_used(number):
            in_frame = np.flatnonzero(number == index)
            end[in_frame] = _place(coordinates, moves.end[rows[in_frame]], moves.frames[index])
        splined = np.flatnonzero(kind == MoveKind.SPLINE)
        end[splined] = find_ends(place_pieces(moves, rows[splined], coordinates))  # where the placed curves really end
        kept = _find_kept(end - _find_starts(last, end, length), kind, end, length, last_kept)
        start = _find_starts_after_kept(last_kept, end, length, kept)
        last = _ToolPose(end[-1:], length[-1:])
        if kept.any():
            at = np.flatnonzero(kept)[-1:]
            last_kept = _ToolPose(end[at], length[at])
        row, start, end = rows[kept], start[kept], end[kept]
        free = np.isfinite(moves.tool_axis[row, 0])
        if free.any():
            end = end.copy()
            _cross_pole(start, end, free)
        placed.extend(row=row, start=start, end=end)
    return PlacedMoves(moves, **placed.freeze())


def _cross_pole(start: Array, end: Array, free: Mask) -> None:
    """Let free segments touch or cross the pole: C stays, and A goes through zero. Changes the poses (n, 5) in place.

    Tool axes arrive with the tilt on one side of the pole and C less than half a turn away from the segment before; A
    and C words may arrive on both sides, and cross it as they are.
    """
    vertical_start, vertical_end = (np.abs(np.sin(angles[:, 3])) <= POLE_SINE for angles in (start, end))
    leaving = free & vertical_start & ~vertical_end
    start[leaving, 4] = end[leaving, 4]
    arriving = free & vertical_end & ~vertical_start
    end[arriving, 4] = start[arriving, 4]
    k0, k1 = find_axis_of_angles(start[:, 3], start[:, 4]), find_axis_of_angles(end[:, 3], end[:, 4])
    normal = np.cross(k0, k1)
    size = np.linalg.norm(normal, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        away = np.abs(normal[:, 2]) / size  # sine of the great circle's distance from the pole
    opposite_sides = k0[:, 0] * k1[:, 0] + k0[:, 1] * k1[:, 1] < 0
    one_side = start[:, 3] * end[:, 3] > 0
    crossing = free & ~vertical_start & ~vertical_end & one_side & opposite_sides & (away < POLE_CROSSING)
    end[crossing, 3] *= -1.0
    end[crossing, 4] += np.where(end[crossing, 4] > start[crossing, 4], -np.pi, np.pi)


def _assemble_path(placed: PlacedMoves, first: _ToolPose, coordinates: TableCoordinates, orientation: str) -> ToolPath:
    """Make the tool path of moves that have been placed, block by block."""
    moves = placed.moves
    dwell = moves.dwells
    dwell_before = np.searchsorted(placed.row, dwell)
    segments, arcs, circles = GrowingTable(**SEGMENT_COLUMNS), GrowingTable(**_ARCS), GrowingTable(**_CIRCLES)
    splines, turns = GrowingSplineSegments(), GrowingTable(**_TURNS)
    section = n_arcs = n_turns = n_circles = 0
    for begin, stop in iterate_blocks(len(placed)):
        seen = max(begin - 1, 0)  # whether a segment continues depends on the one before
        block = make_segments(placed.select(slice(seen, stop)), coordinates, orientation)
        if seen < begin:
            block = block.drop_first()
        at = dwell_before[(dwell_before > 0) & (dwell_before >= begin) & (dwell_before < stop)]
        block.continues[at - begin] = False
        sections = np.cumsum(~block.continues) + section
        before = {"arc": n_arcs, "spline": splines.count, "turn": n_turns, "circle": n_circles}
        numbers = {name: np.where((row := block.columns[name]) < 0, -1, row + n) for name, n in before.items()}
        segments.extend(**block.columns | numbers, section=sections - 1)
        arcs.extend(**asdict(block.arcs))
        splines.extend(block.splines)
        turns.extend(**asdict(block.turns))
        circles.extend(**asdict(block.circles))
        section = int(sections[-1])
        n_arcs, n_circles = n_arcs + len(block.arcs.sweep), n_circles + len(block.circles.angle)
        n_turns += len(block.turns.first)
    columns = segments.freeze()
    return ToolPath(
        **columns,
        arcs=ArcSegments(**arcs.freeze()),
        splines=splines.freeze(),
        turns=TurnSegments(**turns.freeze()),
        circles=GreatCircles(**circles.freeze()),
        joints=np.empty((0, 2, 0)),
        dwell_section=find_sections(columns["section"], dwell_before),
        dwell_seconds=moves.feed[dwell],
        dwell_line=moves.line[dwell],
        first_pose=first.pose[0],
        first_tool_length=float(first.length[0]),
        called_lines=moves.called_lines,
    )


def _place(coordinates: TableCoordinates, program: Array, frame: Frame) -> Array:
    """Tip and angles in the table frame, without the noise of how they were computed: planning would magnify it."""
    tip, angles = coordinates.map_to_table(program, frame)
    return np.concatenate([np.round(tip, POSE_DECIMALS_MM), np.round(angles, POSE_DECIMALS_RAD)], axis=-1)


def _keep_gauge_line(pose: Array, shorter_by: Array) -> Array:
    """Poses (n, 5) of a tool that is shorter by (n,) mm, the gauge line where it is: the tip moves up the tool axis."""
    moved = pose.copy()
    moved[:, :3] += shorter_by[:, None] * find_axis_of_angles(pose[:, 3], pose[:, 4])
    return moved


def _find_starts(before: _ToolPose, end: Array, length: Array) -> Array:
    """Where each move starts: at the end of the move before, but with its own tool length."""
    start = np.concatenate([before.pose, end[:-1]])
    shorter = np.concatenate([before.length, length[:-1]]) - length
    changed = np.flatnonzero(shorter)
    start[changed] = _keep_gauge_line(start[changed], shorter[changed])
    return start


def _is_motion(delta: Array) -> Mask:
    """Which differences (n, 5) of poses count as motion."""
    tip = np.linalg.norm(delta[:, :3], axis=1) > ZERO_LENGTH_MM
    return tip | (np.abs(delta[:, 3:]) > ZERO_ANGLE).any(axis=1)


def _is_curved(kind: NDArray[np.int8]) -> Mask:
    """Moves that have a length even where they end where they begin."""
    return np.asarray((kind == MoveKind.ARC) | (kind == MoveKind.SPLINE))


def _find_kept(delta: Array, kind: NDArray[np.int8], end: Array, length: Array, before: _ToolPose) -> Mask:
    """Moves (n,) that become segments: curves, and moves that end away from the end of the last segment.

    However short such a move is, it becomes one.

    ``delta`` leads from move to move; ``before`` is the end of the last segment before these moves.
    """
    curved = _is_curved(kind)
    kept = (kind != MoveKind.DWELL) & (_is_motion(delta) | curved)
    # what has been left out since the last segment is no longer than the bound: only short moves depend on it
    short = (delta != 0).any(axis=1) & ~_is_motion(delta / 2) & (kind != MoveKind.DWELL) & ~curved
    if not short.any():
        return kept
    last = -1  # the last segment; row -1: the one before these
    poses, lengths = np.concatenate([end, before.pose]), np.append(length, before.length)
    surely = np.maximum.accumulate(np.where(kept & ~short, np.arange(len(kept)), -1))
    for row in np.flatnonzero(short).tolist():
        last = max(last, int(surely[row]))
        start = _keep_gauge_line(poses[[last]], lengths[[last]] - length[row])
        kept[row] = _is_motion(end[[row]] - start)[0]
        if kept[row]:
            last = row
    return kept


def _find_starts_after_kept(before: _ToolPose, end: Array, length: Array, kept: Mask) -> Array:
    """Starts measured from the end of the last move that was kept, so that no gap opens between segments."""
    last = np.where(kept, np.arange(len(end)), -1)
    last = np.append(-1, np.maximum.accumulate(last)[:-1])
    poses = np.concatenate([end, before.pose])  # row -1: the last one kept before these
    lengths = np.append(length, before.length)
    return _keep_gauge_line(poses[last], lengths[last] - length)
