"""Geometry of segments: lines, arcs and great circles, their time at the feed, and which continue each other."""

from typing import Any, Final

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints, Mask, find_used
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import CONTINUATION, OPPOSITE, POLE_SINE, POSE_DECIMALS_MM, ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.base.units import DEG_PER_RAD, ROTARY_METRIC_MM, SECONDS_PER_MINUTE
from verne_post.model.findings import InputError, make_input_error
from verne_post.model.moves import FeedMode, MoveKind, Moves, PathMode
from verne_post.model.nutation import Nutation
from verne_post.model.protocols import TableCoordinates
from verne_post.model.toolpath import ArcSegments, GreatCircles, SegmentKind, SplineSegments, TurnSegments
from verne_post.toolpath.evaluate import differentiate_arc, turn_derivatives
from verne_post.toolpath.splines import differentiate_splines, make_spline_segments, place_pieces, turn_pieces

Rows = NDArray[np.intp]

#: Where the speed of the tip along a turn is looked at, as shares.
_PLACES_OF_TURN: Final = np.linspace(0.0, 1.0, 33).tolist()

#: A great circle is refused if it brings the tilting joint of a nutating pair nearer to its fold than this, rad: there
#: the joint turns 230 times as fast as the tool axis, and faster beyond. At 45 degrees the tool is then 0.001 degrees
#: from lying flat.
_NEAR_FOLD: Final = np.radians(0.5)

#: Normal of the planes XY, ZX, YZ in program coordinates.
_NORMALS: Final = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])


class PlacedMoves(Struct, frozen=True, eq=False):
    """Moves that have a length, in the table frame."""

    moves: Moves  #: All moves of the program.
    row: Rows  #: (n,): Numbers of the moves that have a length.
    #: start, end (n, 5): Their poses: tip (mm) and nominal angles (rad).
    start: Array
    end: Array

    def __len__(self) -> int:
        return len(self.row)

    def select(self, rows: slice | Mask) -> "PlacedMoves":
        """Some of them."""
        return PlacedMoves(self.moves, self.row[rows], self.start[rows], self.end[rows])

    @property
    def tool_length(self) -> Array:
        """Gauge line to tip (n,), mm."""
        return np.array([frame.tool_length for frame in self.moves.frames])[self.moves.frame[self.row]]


class Segments(Struct, frozen=True):
    """Neighbouring segments."""

    columns: dict[str, NDArray[Any]]  #: Columns of a ToolPath (n,) by name, but for the sections.
    #: arcs, splines, turns, circles SplineSegments, TurnSegments, GreatCircles: Those of these segments.
    arcs: ArcSegments
    splines: SplineSegments
    turns: TurnSegments
    circles: GreatCircles
    continues: Mask  #: (n,): The segment continues the one before without a stop.

    def drop_first(self) -> "Segments":
        """All but the first; the table of splines keeps what only that one has."""
        arc, turn, circle = (self.columns[name] for name in ("arc", "turn", "circle"))
        arcs, turns, circles = (int(column[0] >= 0) for column in (arc, turn, circle))
        rest = {name: column[1:] for name, column in self.columns.items()}
        return Segments(
            rest | {"arc": arc[1:] - arcs, "turn": turn[1:] - turns, "circle": circle[1:] - circles},
            ArcSegments(**{name: column[arcs:] for name, column in asdict(self.arcs).items()}),
            self.splines,
            TurnSegments(**{name: column[turns:] for name, column in asdict(self.turns).items()}),
            GreatCircles(**{name: column[circles:] for name, column in asdict(self.circles).items()}),
            self.continues[1:],
        )


def make_segments(placed: PlacedMoves, coordinates: TableCoordinates, orientation: str) -> Segments:
    """Turn neighbouring moves (n,) into segments.

    Raises
    ------
    InputError
        VP007 and VP031, as :func:`~verne_post.toolpath.build.build_path`.
    """
    moves, row = placed.moves, placed.row
    curved = np.flatnonzero(moves.kind[row] == MoveKind.ARC)
    arcs = _place_arcs(placed, curved, coordinates)
    arc = np.full(len(row), -1, dtype=np.int32)
    arc[curved] = np.arange(len(curved))
    kind = np.full(len(row), SegmentKind.LINE, dtype=np.int8)
    kind[curved] = SegmentKind.ARC
    splined = np.flatnonzero(moves.kind[row] == MoveKind.SPLINE)
    pieces = turn_pieces(place_pieces(moves, row[splined], coordinates), placed.start[splined], placed.end[splined])
    splines = make_spline_segments(pieces, moves.line[row[splined]])
    spline = np.full(len(row), -1, dtype=np.int32)
    spline[splined] = np.arange(len(splined))
    kind[splined] = SegmentKind.SPLINE
    carried = np.flatnonzero((moves.kind[row] == MoveKind.TURN) | (moves.kind[row] == MoveKind.SWING))
    turns = _place_turns(placed, carried, coordinates)
    turn = np.full(len(row), -1, dtype=np.int32)
    turn[carried] = np.arange(len(carried))
    kind[carried] = SegmentKind.TURN
    free = np.isfinite(moves.tool_axis[row, 0])
    fed = moves.kind[row] == MoveKind.FEED
    by_axis = {"auto": free, "vector": free | fed, "angles": np.zeros(len(row), dtype=bool)}[orientation]
    if (nutation := coordinates.nutation) is not None:
        by_axis = by_axis & ~np.isnan(moves.feed[row])  # of a rapid the way is that of the joints
    circle, circles = _find_great_circles(placed, free, by_axis)
    if nutation is not None:
        _check_reach(placed, nutation, by_axis, circle, circles)
        which, linear = _find_linear_joints(placed, nutation, by_axis)
        circle[which] = len(circles.angle) + np.arange(len(which))
        order = circle[used := np.flatnonzero(circle >= 0)]
        columns = {name: np.concatenate([column, getattr(linear, name)]) for name, column in asdict(circles).items()}
        circle[used], circles = (
            np.arange(len(used)),
            GreatCircles(**{k: column[order] for k, column in columns.items()}),
        )
    delta = placed.end - placed.start
    tip_length = np.linalg.norm(delta[:, :3], axis=1)
    tip_length[curved] = _measure_arcs(arcs)
    tip_length[splined] = splines.length
    tip_length[carried] = _measure_turns(turns)
    angle = np.linalg.norm(delta[:, 3:], axis=1)
    axis_angle = angle.copy()
    axis_angle[circle >= 0] = circles.angle
    length = np.hypot(tip_length, ROTARY_METRIC_MM * angle)
    length[splined] = splines.length  # so that one length counts for neighbouring pieces, however the table turns
    feed_time, timed = _find_feed_times(moves, row, tip_length, axis_angle)
    columns = {
        "line": moves.line[row],
        "kind": kind,
        "start": placed.start,
        "end": placed.end,
        "tool_length": placed.tool_length,
        "feed_time": feed_time,
        "timed": timed,
        "length": length,
        "arc": arc,
        "spline": spline,
        "turn": turn,
        "circle": circle,
        "free": free,
        "joint": np.full(len(row), -1, dtype=np.int32),
        "move": row,
    }
    return Segments(columns, arcs, splines, turns, circles, _find_continuations(placed, columns, arcs, splines))


def _find_great_circles(placed: PlacedMoves, free: Mask, wanted: Mask) -> tuple[NDArray[np.int32], GreatCircles]:
    """Which segments (n,) follow a great circle that is not linear in A and C, by its row, and those circles."""
    moves, row, start, end = placed.moves, placed.row, placed.start, placed.end
    circle = np.full(len(row), -1, dtype=np.int32)
    turning = np.abs(end[:, 4] - start[:, 4]) > ZERO_ANGLE
    upright = (np.abs(np.sin(start[:, 3])) <= POLE_SINE) | (np.abs(np.sin(end[:, 3])) <= POLE_SINE)
    if (bad := np.flatnonzero(wanted & ~free & turning & (upright | (start[:, 3] * end[:, 3] < 0)))).size:
        raise _refuse_circle(moves, row[bad[0]], "passes the pole, where C turns")
    if (bad := np.flatnonzero(wanted & free & _are_opposite(start, end))).size:
        raise _refuse_circle(moves, row[bad[0]], "is not defined between opposite tool axes")
    which = np.flatnonzero(wanted & turning & ~upright & (start[:, 3] * end[:, 3] > 0))
    if not len(which):
        return circle, GreatCircles(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty((0, 6)))
    k0, k1 = (find_axis_of_angles(angles[which, 3], angles[which, 4]) for angles in (start, end))
    cosine = np.sum(k0 * k1, axis=1)
    across = k1 - cosine[:, None] * k0
    sine = np.linalg.norm(across, axis=1)
    if (bad := np.flatnonzero(_are_opposite(start[which], end[which]))).size:
        raise _refuse_circle(moves, row[which[bad[0]]], "is not defined between opposite tool axes")
    if (bad := np.flatnonzero(np.abs(end[which, 4] - start[which, 4]) >= np.pi)).size:
        why = "does not lead to the programmed C, which turns by half a turn or more"
        raise _refuse_circle(moves, row[which[bad[0]]], why)
    which, k0, across, sine, cosine = (a[sine > ZERO_ANGLE] for a in (which, k0, across, sine, cosine))
    circle[which] = np.arange(len(which))
    return circle, GreatCircles(k0, across / sine[:, None], np.arctan2(sine, cosine), np.full((len(which), 6), np.nan))


def _find_linear_joints(
    placed: PlacedMoves, nutation: Nutation, by_axis: Mask
) -> tuple[NDArray[np.intp], GreatCircles]:
    """Segments of a nutating pair whose joints go linearly, so that A and C do not: where no great circle is meant.

    Beyond the folds A goes on with the joint, and the check of its travel says so.

    Raises
    ------
    InputError
        VP031 for splines that turn.
    """
    moves, row = placed.moves, placed.row
    start, end = (nutation.find_turns(pose[:, 3:]) for pose in (placed.start, placed.end))
    turning = (np.abs(end - start) > ZERO_ANGLE).any(axis=1)
    if (bad := np.flatnonzero(turning & (moves.kind[row] == MoveKind.SPLINE))).size:
        text = (
            "a spline that turns the rotary axes is not executed on a nutating pair, because its joints would not "
            "follow a spline"
        )
        raise _refuse(moves, row[bad[0]], "VP031", text)
    tilting = np.abs(end[:, 0] - start[:, 0]) > ZERO_ANGLE
    between_folds = (np.abs([start[:, 0], end[:, 0]]) <= np.pi).all(axis=0)
    if nutation.near != nutation.far:
        between_folds &= start[:, 0] * end[:, 0] >= 0.0
    which = np.flatnonzero(~by_axis & tilting & between_folds)
    none = np.zeros((len(which), 3))
    start, end = start[which], end[which]
    joints = np.column_stack([start, end, np.tile([nutation.near, nutation.far], (len(which), 1))])
    return which, GreatCircles(none, none, measure_rows(end - start), joints)


def _check_reach(placed: PlacedMoves, nutation: Nutation, by_axis: Mask, circle: Ints, circles: GreatCircles) -> None:
    """Refuse great circles that leave the reach of a nutating pair (VP110) or come near its fold (VP202)."""
    row = np.flatnonzero(by_axis & (np.abs(placed.end - placed.start)[:, 3:] > ZERO_ANGLE).any(axis=1))
    tilts = np.abs([placed.start[row, 3], placed.end[row, 3]])
    curved = np.flatnonzero(circle[row] >= 0)
    number = circle[row[curved]]
    first, side, angle = circles.first[number, 2], circles.side[number, 2], circles.angle[number]
    highest = np.arctan2(side, first)  # where on the great circle the axis is nearest z, and opposite it is farthest
    for at in (highest, highest + np.pi, highest - np.pi):
        there = (at > 0.0) & (at < angle)
        tilt = np.arccos(np.clip(np.cos(at) * first + np.sin(at) * side, -1.0, 1.0))
        more = tilts[0].copy()
        more[curved[there]] = tilt[there]
        tilts = np.vstack([tilts, more])
    miss = nutation.measure_miss(tilts).max(axis=0, initial=0.0)
    if len(bad := np.flatnonzero(miss)):
        text = (
            f"the tool axis leaves the reach of the rotary axes by {DEG_PER_RAD * miss[bad[0]]:.4f} degrees on its "
            "great circle"
        )
        raise _refuse(placed.moves, placed.row[row[bad[0]]], "VP110", text)
    joint = nutation.find_joints(np.stack([tilts, 0.0 * tilts], axis=-1))[..., 0]
    left = nutation.measure_fold(joint).min(axis=0, initial=np.inf)
    if len(bad := np.flatnonzero(left < _NEAR_FOLD)):
        text = (
            f"the tool axis comes within {DEG_PER_RAD * max(left[bad[0]], 0.0):.4f} degrees of the fold of the tilting "
            "joint, where both table solutions meet and the joint speeds would have no bound; go there by words of the "
            "rotary axes or as a rapid"
        )
        raise _refuse(placed.moves, placed.row[row[bad[0]]], "VP202", text)


def _are_opposite(start: Array, end: Array) -> Mask:
    """Where the tool axes at both ends point in opposite directions."""
    k0, k1 = find_axis_of_angles(start[:, 3], start[:, 4]), find_axis_of_angles(end[:, 3], end[:, 4])
    return np.asarray(np.linalg.norm(k0 + k1, axis=1) < OPPOSITE)


def _refuse_circle(moves: Moves, move: np.intp, why: str) -> InputError:
    return _refuse(
        moves,
        move,
        "VP007",
        f"the great circle from tool axis to tool axis {why}; use --orientation angles, or smaller steps",
    )


def _refuse(moves: Moves, move: np.intp, code: str, text: str) -> InputError:
    line = int(moves.line[move])
    return make_input_error(code, text, severity="error", line=line)


def _place_arcs(placed: PlacedMoves, curved: Rows, coordinates: TableCoordinates) -> ArcSegments:
    """Arcs of the moves ``curved`` in the table frame, from centre, plane and sweep in program coordinates."""
    moves, row, start, end = placed.moves, placed.row[curved], placed.start[curved], placed.end[curved]
    center, normal = _place_centers(moves, row, coordinates), np.empty((len(row), 3))
    for index in find_used(moves.frame[row]):
        in_frame = np.flatnonzero(moves.frame[row] == index)
        arc = moves.arc[row[in_frame]]
        normal[in_frame] = coordinates.turn_displacement(_NORMALS[moves.arcs.plane[arc]], moves.frames[index])
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


def _place_centers(moves: Moves, row: Rows, coordinates: TableCoordinates) -> Array:
    """Centres (m, 3) of the moves ``row`` in the table frame."""
    center = np.empty((len(row), 3))
    for index in find_used(moves.frame[row]):
        in_frame = np.flatnonzero(moves.frame[row] == index)
        program = moves.end[row[in_frame]].copy()
        program[:, :3] = moves.arcs.center[moves.arc[row[in_frame]]]
        center[in_frame] = np.round(coordinates.map_to_table(program, moves.frames[index])[0], POSE_DECIMALS_MM)
    return center


def _measure_arcs(arcs: ArcSegments) -> Array:
    """Largest derivative of the tip path by u, mm: the tip speed follows from it."""
    around = np.maximum(arcs.r0, arcs.r1) * np.abs(arcs.sweep)
    return np.sqrt(around**2 + (arcs.r1 - arcs.r0) ** 2 + np.sum(arcs.rise**2, axis=1))


def _place_turns(placed: PlacedMoves, carried: Rows, coordinates: TableCoordinates) -> TurnSegments:
    """Turns of the moves ``carried`` in the table frame: what goes linearly from end to end.

    In a TURN that is the tip on the nominal machine. In a SWING a point of the tool axis stands still on the part.
    """
    start, end = placed.start[carried], placed.end[carried]
    turns = coordinates.carry_tips(start, end, placed.tool_length[carried])
    swings = np.flatnonzero(placed.moves.kind[placed.row[carried]] == MoveKind.SWING)
    if len(swings):
        centre = _place_centers(placed.moves, placed.row[carried[swings]], coordinates)
        axis = find_axis_of_angles(start[swings, 3], start[swings, 4])
        distance = np.sum((start[swings, :3] - centre) * axis, axis=1)
        turns.shift[swings] = centre
        turns.first[swings] = turns.last[swings] = distance[:, None] * (
            [0.0, 0.0, 1.0] if (pair := coordinates.nutation) is None else [np.cos(pair.far), 0.0, np.sin(pair.far)]
        )
        turns.offset[swings] = turns.slide[swings] = turns.drift[swings] = 0.0
    return turns


def _measure_turns(turns: TurnSegments) -> Array:
    """Largest derivative (m,) of the tip by u, mm, at so many places that none between is larger by more than 0.1 %."""
    row = np.arange(len(turns.first))
    largest = np.zeros(len(row))
    if not len(row):  # most programs have none, and each place costs operations on arrays
        return largest
    for share in _PLACES_OF_TURN:
        largest = np.maximum(largest, measure_rows(turn_derivatives(turns, row, np.full(len(row), share))[0]))
    return largest


def _find_feed_times(moves: Moves, row: Rows, tip_length: Array, angle: Array) -> tuple[Array, Mask]:
    """Seconds (n,) that each segment takes at its feed rate, 0 for rapids; and where the feed rate is a time (n,)."""
    feed = moves.feed[row].copy()
    per_revolution = moves.feed_mode[row] == FeedMode.PER_REVOLUTION
    feed[per_revolution] *= moves.spindle[row][per_revolution]
    carried = (moves.kind[row] == MoveKind.TURN) | (moves.kind[row] == MoveKind.SWING)
    stands = ((tip_length <= ZERO_LENGTH_MM) & (angle != 0.0)) | carried
    distance = np.where(stands, DEG_PER_RAD * angle, tip_length)
    seconds, fed = moves.seconds[row], ~np.isnan(feed)
    given = np.isfinite(seconds)
    return np.where(fed, np.where(given, seconds, SECONDS_PER_MINUTE * distance / feed), 0.0), fed & (given | stands)


def _find_continuations(
    placed: PlacedMoves, columns: dict[str, NDArray[Any]], arcs: ArcSegments, splines: SplineSegments
) -> Mask:
    """Which segments (n,) continue the one before without a stop: in shape, in rotation per length and in feed.

    Beside splines the third derivative may differ: a spline of degree 3 has no more between its own pieces.
    """
    continues = np.zeros(len(placed), dtype=bool)
    if len(placed) < 2:
        return continues
    moves, row, start, end = placed.moves, placed.row, placed.start, placed.end
    kind, length, circle, tool = (columns[name] for name in ("kind", "length", "circle", "tool_length"))
    slope = (end - start) / length[:, None]
    slope[:, 3:] *= ROTARY_METRIC_MM
    jump = slope[1:] - slope[:-1]
    smooth = np.asarray((np.abs(jump) < CONTINUATION).all(axis=1))
    curved, splined = kind == SegmentKind.ARC, kind == SegmentKind.SPLINE
    # segments with an arc or a spline on one side of the corner at their end
    beside = np.flatnonzero((curved | splined)[1:] | (curved | splined)[:-1])
    leaving, arriving = (_differentiate(slope, columns, arcs, splines, beside + k, u) for k, u in ((1, 0.0), (0, 1.0)))
    fits = np.asarray((np.abs(leaving - arriving) < CONTINUATION).all(axis=2))
    smooth[beside] = fits[:, :2].all(axis=1) & (fits[:, 2] | (splined[beside] | splined[beside + 1]))
    same_kind = (kind[1:] == kind[:-1]) | splined[1:] | splined[:-1]
    even = (circle < 0) & (kind != SegmentKind.TURN)
    same_kind &= even[1:] & even[:-1]
    pace = columns["feed_time"] / length
    same_pace = np.abs(pace[1:] - pace[:-1]) <= CONTINUATION * pace[1:]
    exact_stop = np.array([control.mode == PathMode.EXACT_STOP for control in moves.controls])[moves.control[row]]
    contact = np.abs(start[1:] - end[:-1]).max(axis=1) == 0.0
    continues[1:] = smooth & same_kind & same_pace & (tool[1:] == tool[:-1]) & ~exact_stop[:-1] & contact
    return continues


def _differentiate(
    slope: Array, columns: dict[str, NDArray[Any]], arcs: ArcSegments, splines: SplineSegments, segment: Rows, u: float
) -> Array:
    """First to third derivative (m, 3, 5) of tip and angles by metric length at parameter u of segments (m,), in mm."""
    derivatives = np.zeros((len(segment), 3, 5))
    derivatives[:, 0] = slope[segment]
    for name, width in (("arc", 3), ("spline", 5)):
        curved = np.flatnonzero(columns[name][segment] >= 0)
        row, length = columns[name][segment[curved]], columns["length"][segment[curved], None]
        at = np.full(len(curved), u)
        by_u = differentiate_arc(arcs, row, at) if name == "arc" else differentiate_splines(splines, row, at)
        for order, derivative in enumerate(by_u, start=1):
            derivatives[curved, order - 1, :width] = derivative / length**order
        if name == "spline":
            derivatives[curved, :, 3:] *= ROTARY_METRIC_MM
    return derivatives
