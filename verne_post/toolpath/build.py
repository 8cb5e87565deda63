"""Moves -> ToolPath: every motion becomes a segment, segments that continue each other become a run."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.columns import GrowingTable, blocks
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
from verne_post.model.toolpath import SEGMENT_COLUMNS, ArcSegments, GreatCircles, SegmentKind, ToolPath, sections_at
from verne_post.toolpath.evaluate import arc_derivatives

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]

#: Millimetres of path that one radian of rotation counts for in the metric length of a segment:
#: a typical distance of the tip from the table's axes, so that pure rotations have length too.
ROTARY_METRIC_MM: Final = 50.0
#: Normal of the planes XY, ZX, YZ in program coordinates.
_NORMALS: Final = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])


#: Chooses branches for a path: angles at start and end of every segment, or None to leave them as they are.
BranchPlanner = Callable[[ToolPath], "tuple[Array, Array] | None"]


def build_path(
    moves: Moves, coordinates: TableCoordinates, orientation: str = "auto", planner: BranchPlanner | None = None
) -> ToolPath:
    """Turn moves into segments in the table frame.

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
        Moves of no length are dropped; every other move is one segment.

    Raises
    ------
    InputError
        VP007 where a great circle is not defined, or does not lead to the programmed angles.
    """
    first = _poses(coordinates, moves.start[None], moves.start_frame)[0]
    first_length = moves.start_frame.tool_length
    if len(moves):
        length = moves.frames[moves.frame[0]].tool_length
        first, first_length = _on_gauge_line(first[None], np.array([first_length - length]))[0], length
    row, start, end = _kept_moves(moves, coordinates, first, first_length)
    path = _assembled(moves, row, start, end, coordinates, first, first_length, orientation)
    chosen = planner(path) if planner is not None and len(row) else None
    if chosen is None:
        return path
    start = np.concatenate([start[:, :3], chosen[0]], axis=1)
    end = np.concatenate([end[:, :3], chosen[1]], axis=1)
    first = np.concatenate([first[:3], start[0, 3:]])
    still = _moving(end - start) | (moves.kind[row] == MoveKind.ARC)  # a turn may have become superfluous
    return _assembled(moves, row[still], start[still], end[still], coordinates, first, first_length, orientation)


def _kept_moves(
    moves: Moves, coordinates: TableCoordinates, first: Array, first_length: float
) -> tuple[Rows, Array, Array]:
    """Moves (n,) that have a length, and the poses (n, 5) at which they start and end."""
    kept_moves = GrowingTable(row=(np.intp,), start=(float, 5), end=(float, 5))
    length_of = np.array([frame.tool_length for frame in moves.frames])
    before = after_kept = (
        first[None],
        np.array([first_length]),
    )  # pose and tool length behind the last move, and the last kept
    for begin, stop in blocks(len(moves)):
        rows = np.arange(begin, stop)
        number = moves.frame[begin:stop]
        length = length_of[number]
        end = np.empty((len(rows), 5))
        for index in np.unique(number):
            mine = np.flatnonzero(number == index)
            end[mine] = _poses(coordinates, moves.end[rows[mine]], moves.frames[index])
        kind = moves.kind[begin:stop]
        start = _starts(*before, end, length)
        kept = _kept(end - start, kind, end, length, *after_kept)
        start = _starts_after_kept(*after_kept, end, length, kept)
        before = end[-1:], length[-1:]
        if kept.any():
            last = np.flatnonzero(kept)[-1:]
            after_kept = end[last], length[last]
        row, start, end = rows[kept], start[kept], end[kept]
        free = np.isfinite(moves.vector[row, 0])
        if free.any():
            end = end.copy()
            across_the_pole(start, end, free)
        kept_moves.extend(row=row, start=start, end=end)
    return tuple(kept_moves.columns().values())


def across_the_pole(start: Array, end: Array, free: Mask) -> None:
    """Angles of free segments that touch or cross the pole: C stays, and A goes through zero. Changes both in place.

    The segments arrive with the tilt on one side of the pole and C less than half a turn away from the segment before.
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
    moves: Moves, row: Rows, start: Array, end: Array, coordinates: TableCoordinates, first: Array, first_length: float,
    orientation: str,
) -> ToolPath:  # fmt: skip
    """The tool path of segments whose poses are known."""
    dwell = np.flatnonzero((moves.kind == MoveKind.DWELL) & (moves.feed > 0))
    dwell_before = np.searchsorted(row, dwell)
    segments, arcs, circles = GrowingTable(**SEGMENT_COLUMNS), GrowingTable(**_ARCS), GrowingTable(**_CIRCLES)
    section = n_arcs = n_circles = 0
    for begin, stop in blocks(len(row)):
        seen = max(begin - 1, 0)  # whether a segment goes on depends on the one before
        made = _segments(moves, row[seen:stop], start[seen:stop], end[seen:stop], coordinates, orientation)
        if seen < begin:
            made = made.behind_the_first()
        at = dwell_before[(dwell_before > 0) & (dwell_before >= begin) & (dwell_before < stop)]
        made.joined[at - begin] = False
        sections = np.cumsum(~made.joined) + section
        made.columns["section"] = sections - 1
        made.columns["arc"] = np.where(made.columns["arc"] < 0, -1, made.columns["arc"] + n_arcs)
        made.columns["circle"] = np.where(made.columns["circle"] < 0, -1, made.columns["circle"] + n_circles)
        segments.extend(**made.columns)
        arcs.extend(**vars(made.arcs))
        circles.extend(**vars(made.circles))
        section, n_arcs, n_circles = (
            int(sections[-1]),
            n_arcs + len(made.arcs.sweep),
            n_circles + len(made.circles.angle),
        )
    columns = segments.columns()
    return ToolPath(
        **columns,
        arcs=ArcSegments(**arcs.columns()),
        circles=GreatCircles(**circles.columns()),
        joints=np.empty((0, 2, 0)),
        dwell_section=sections_at(columns["section"], dwell_before),
        dwell_seconds=moves.feed[dwell],
        dwell_line=moves.line[dwell],
        first_pose=first,
        first_tool_length=first_length,
    )


#: Columns of the arcs and great circles of a tool path.
_ARCS: Final = {
    "center": (float, 3), "e1": (float, 3), "e2": (float, 3), "rise": (float, 3), "r0": (float,), "r1": (float,), "sweep": (float,),
}  # fmt: skip
_CIRCLES: Final = {"first": (float, 3), "side": (float, 3), "angle": (float,)}


@dataclass(frozen=True)
class _Segments:
    """Some neighbours: columns by name but for the runs, arcs and great circles, and which segments go on without a stop."""

    columns: dict[str, NDArray[Any]]
    arcs: ArcSegments
    circles: GreatCircles
    joined: Mask

    def behind_the_first(self) -> "_Segments":
        """All but the first."""
        arc, circle = self.columns["arc"], self.columns["circle"]
        arcs, circles = int(arc[0] >= 0), int(circle[0] >= 0)
        return _Segments(
            {name: column[1:] for name, column in self.columns.items()} | {"arc": arc[1:] - arcs, "circle": circle[1:] - circles},
            ArcSegments(**{name: column[arcs:] for name, column in vars(self.arcs).items()}),
            GreatCircles(**{name: column[circles:] for name, column in vars(self.circles).items()}),
            self.joined[1:],
        )  # fmt: skip


def _segments(
    moves: Moves, row: Rows, start: Array, end: Array, coordinates: TableCoordinates, orientation: str
) -> _Segments:
    """Neighbouring segments of moves (n,) with poses that are known."""
    arc_rows = np.flatnonzero(moves.kind[row] == MoveKind.ARC)
    arcs = _arcs(moves, row[arc_rows], start[arc_rows], end[arc_rows], coordinates)
    arc = np.full(len(row), -1, dtype=np.int32)
    arc[arc_rows] = np.arange(len(arc_rows))
    free = np.isfinite(moves.vector[row, 0])
    delta = end - start
    tip_length = np.linalg.norm(delta[:, :3], axis=1)
    tip_length[arc_rows] = _arc_lengths(arcs)
    angle = np.linalg.norm(delta[:, 3:], axis=1)
    kind = np.full(len(row), SegmentKind.LINE, dtype=np.int8)
    kind[arc_rows] = SegmentKind.ARC
    circle, circles = _great_circles(moves, row, start, end, free, orientation)
    swing = angle.copy()
    swing[circle >= 0] = circles.angle
    length = np.hypot(tip_length, ROTARY_METRIC_MM * angle)
    feed_time = _feed_times(moves, row, tip_length, swing)
    joined = _joined(moves, row, kind, start, end, arcs, arc, length, feed_time)
    joined[1:] &= (circle[1:] < 0) & (circle[:-1] < 0)
    columns = {
        "line": moves.line[row],
        "kind": kind,
        "start": start,
        "end": end,
        "tool_length": np.array([frame.tool_length for frame in moves.frames])[moves.frame[row]],
        "feed_time": feed_time,
        "length": length,
        "arc": arc,
        "circle": circle,
        "free": free,
        "joint": np.full(len(row), -1, dtype=np.int32),
        "move": row,
    }
    return _Segments(columns, arcs, circles, joined)


def _great_circles(
    moves: Moves, row: Rows, start: Array, end: Array, free: Mask, orientation: str
) -> tuple[NDArray[np.int32], GreatCircles]:
    """Which segments swing along a great circle that is not linear in A and C, and those circles."""
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


def _starts(before: Array, before_length: Array, end: Array, tool_length: Array) -> Array:
    """Where each move starts: the end of the move before, that of the first being given (1, 5), with its own tool length."""
    start = np.concatenate([before, end[:-1]])
    shorter = np.concatenate([before_length, tool_length[:-1]]) - tool_length
    changed = np.flatnonzero(shorter)
    start[changed] = _on_gauge_line(start[changed], shorter[changed])
    return start


def _moving(delta: Array) -> Mask:
    tip = np.linalg.norm(delta[:, :3], axis=1) > ZERO_LENGTH_MM
    return tip | (np.abs(delta[:, 3:]) > ZERO_ANGLE).any(axis=1)


def _kept(delta: Array, kind: NDArray[np.int8], end: Array, length: Array, before: Array, before_length: Array) -> Mask:
    """Moves (n,) that become segments: those that end away from the end of the last segment, however short each is, and arcs.

    ``delta`` leads from move to move; ``before`` and its tool length (1,) are the end of the last segment before.
    """
    kept = (kind != MoveKind.DWELL) & (_moving(delta) | (kind == MoveKind.ARC))
    # what has been left out since the last segment is no longer than the bound: only short moves depend on it
    short = (delta != 0).any(axis=1) & ~_moving(delta / 2) & (kind != MoveKind.DWELL) & (kind != MoveKind.ARC)
    if not short.any():
        return kept
    last = -1  # the last segment; row -1: the one before these
    poses, lengths = np.concatenate([end, before]), np.append(length, before_length)
    surely = np.maximum.accumulate(np.where(kept & ~short, np.arange(len(kept)), -1))
    for row in np.flatnonzero(short).tolist():
        last = max(last, int(surely[row]))
        start = _on_gauge_line(poses[[last]], lengths[[last]] - length[row])
        kept[row] = _moving(end[[row]] - start)[0]
        if kept[row]:
            last = row
    return kept


def _starts_after_kept(before: Array, before_length: Array, end: Array, tool_length: Array, kept: Mask) -> Array:
    """Starts measured from the end of the last move that was kept, so that no gap opens between segments."""
    last = np.where(kept, np.arange(len(end)), -1)
    last = np.append(-1, np.maximum.accumulate(last)[:-1])
    poses = np.concatenate([end, before])  # row -1: the last one kept before these
    lengths = np.append(tool_length, before_length)
    return _on_gauge_line(poses[last], lengths[last] - tool_length)


def _arcs(moves: Moves, row: Rows, start: Array, end: Array, coordinates: TableCoordinates) -> ArcSegments:
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
    return ArcSegments(center, e1, np.cross(normal, e1), rise, r0, r1, sweep)


def _arc_lengths(arcs: ArcSegments) -> Array:
    """Longest path length per unit of u, mm: what the tip speed follows from."""
    around = np.maximum(arcs.r0, arcs.r1) * np.abs(arcs.sweep)
    return np.sqrt(around**2 + (arcs.r1 - arcs.r0) ** 2 + np.sum(arcs.rise**2, axis=1))


def _feed_times(moves: Moves, row: Rows, tip_length: Array, angle: Array) -> Array:
    """Seconds that each segment takes at its feed; 0 for rapids."""
    feed = moves.feed[row].copy()
    per_revolution = moves.feed_mode[row] == FeedMode.PER_REVOLUTION
    feed[per_revolution] *= moves.spindle[row][per_revolution]
    distance = np.where((tip_length > ZERO_LENGTH_MM) | (angle == 0.0), tip_length, DEG_PER_RAD * angle)
    return np.where(moves.kind[row] == MoveKind.RAPID, 0.0, SECONDS_PER_MINUTE * distance / feed)


def _tip_derivatives(
    rate: Array, arcs: ArcSegments, arc: NDArray[np.int32], length: Array, segment: Rows, u: float
) -> Array:
    """First to third derivative (m, 3, 3) of the tip by metric length at parameter u of segments (m,)."""
    found = np.zeros((len(segment), 3, 3))
    found[:, 0] = rate[segment, :3]
    curved = np.flatnonzero(arc[segment] >= 0)
    at = np.full(len(curved), u)
    for order, derivative in enumerate(arc_derivatives(arcs, arc[segment[curved]], at), start=1):
        found[curved, order - 1] = derivative / length[segment[curved], None] ** order
    return found


def _joined(
    moves: Moves, row: Rows, kind: NDArray[np.int8], start: Array, end: Array,
    arcs: ArcSegments, arc: NDArray[np.int32], length: Array, feed_time: Array,
) -> Mask:  # fmt: skip
    """True where a segment continues the one before without a stop, in shape, rate and feed."""
    joined = np.zeros(len(row), dtype=bool)
    if len(row) < 2:
        return joined
    rate = (end - start) / length[:, None]
    jump = rate[1:] - rate[:-1]
    curved = kind == SegmentKind.ARC
    beside = np.flatnonzero(curved[1:] | curved[:-1])  # segments with an arc on one side of the corner behind them
    leaving, arriving = (_tip_derivatives(rate, arcs, arc, length, beside + k, u) for k, u in ((1, 0.0), (0, 1.0)))
    bent = leaving - arriving
    jump[beside, :3] = bent[:, 0]
    jump[:, 3:] *= ROTARY_METRIC_MM
    smooth = np.asarray((np.abs(jump) < CONTINUATION).all(axis=1))
    smooth[beside] &= (np.abs(bent[:, 1:]) < CONTINUATION).all(axis=(1, 2))
    same_kind = kind[1:] == kind[:-1]
    pace = feed_time / length
    same_pace = np.abs(pace[1:] - pace[:-1]) <= CONTINUATION * pace[1:]
    tool = np.array([frame.tool_length for frame in moves.frames])[moves.frame[row]]
    exact_stop = np.array([control.mode == PathMode.EXACT_STOP for control in moves.controls])[moves.control[row]]
    contact = np.abs(start[1:] - end[:-1]).max(axis=1) == 0.0
    joined[1:] = smooth & same_kind & same_pace & (tool[1:] == tool[:-1]) & ~exact_stop[:-1] & contact
    return joined
