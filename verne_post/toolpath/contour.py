"""ToolPath -> Contour: where the tool flows, where it stops, and the poses along it."""

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.model.contour import Contour, Corners, Feeds
from verne_post.model.moves import Moves, PathControl, PathMode
from verne_post.model.toolpath import PieceKind, ToolPath
from verne_post.toolpath import corners as rounding
from verne_post.toolpath.blend import STRETCH, blend_distances, tangent
from verne_post.toolpath.build import ROTARY_METRIC_MM
from verne_post.toolpath.evaluate import bernstein, bernstein_slope, pose
from verne_post.toolpath.fairing import faired

Array = NDArray[np.float64]
Ints = NDArray[np.integer]
Mask = NDArray[np.bool_]

#: Vertices of finely divided curves move by at most this share of their tolerance; the rest is for rounding corners.
FAIRING_SHARE: Final = 0.35
#: A segment shorter than this share of the bumps that bound it is given to its neighbour: only there does the contour
#: bend so little on it that it is smooth across both. Bumps narrower than ``NARROW_MM`` are over within a few control
#: cycles: they need no segment of less than this share of their piece, and the time law does better without.
MIN_SHARE: Final = 1e-3
NARROW_MM: Final = 0.01


@dataclass(frozen=True)
class Smoothing:
    """What may be done to corners.

    Attributes
    ----------
    overlap : bool
        Corners of finely divided curves may reach over each other.
    tip, axis : float
        Tolerances of a G64 without P, mm and rad.
    """

    overlap: bool
    tip: float
    axis: float


def exact_contour(path: ToolPath) -> Contour:
    """The pieces as they are, with a stop at every corner: one segment a piece."""
    n = len(path)
    return Contour(
        path=path,
        shape=path,
        piece=np.arange(n, dtype=np.int32),
        curve=np.full(n, -1, dtype=np.int32),
        low=np.zeros(n),
        high=np.ones(n),
        length=path.length,
        turn=_turn(path),
        run=path.run,
        corners=None,
        bumped=np.zeros(n, dtype=bool),
        feeds=feeds_of(path),
        controls=np.empty((0, 8, 5)),
        tip_tolerance=np.zeros(n),
        axis_tolerance=np.zeros(n),
        dwell_run=path.dwell_run,
    )


def smooth_contour(path: ToolPath, moves: Moves, smoothing: Smoothing) -> Contour:
    """Round every corner that may be rounded; the others stay stops.

    Parameters
    ----------
    path : ToolPath
    moves : Moves
        For the G61 and G64 in force.
    smoothing : Smoothing
    """
    n = len(path)
    if n < 2:
        return exact_contour(path)
    allowed, tip_tolerance, axis_tolerance = _may_be_rounded(path, moves, smoothing)
    joined = np.zeros(n + 1, dtype=bool)
    joined[1:-1] = path.run[1:] == path.run[:-1]
    straight = (path.kind == PieceKind.LINE) & (path.circle < 0)
    lines = np.zeros(n + 1, dtype=bool)
    lines[1:-1] = straight[1:] & straight[:-1]

    if smoothing.overlap:  # vertices between collinear pieces may move like their neighbours
        joined &= ~(allowed & lines)
    curved = allowed & ~lines & ~joined
    curved[1:-1] &= (
        np.sum(tangent(path, np.arange(n - 1), 1.0) * tangent(path, np.arange(1, n), 0.0), axis=1) > rounding.REVERSAL
    )
    s = np.append(0.0, np.cumsum(path.length))
    shape, tip_left, axis_left = path, tip_tolerance, axis_tolerance
    moved: Mask = np.zeros(n - 1, dtype=bool)
    if smoothing.overlap:
        programmed = rounding.polyline_slopes(path.start, path.end, path.length)
        movable = allowed & lines & ~joined & ~rounding.turning_back(programmed)
        del programmed  # here and below: what is as large as the path is given up before the next such thing is made
        # a piece that runs on into another, or into a blend, keeps its direction, which was matched as programmed
        kept = joined | curved
        movable[1:-1] &= ~(kept[2:] | kept[:-2])
        bounds = _fairing_bounds(path, moves, tip_tolerance), FAIRING_SHARE * axis_tolerance
        shape = _faired(path, s, movable & (bounds[0] > 0), *bounds)
        shift = shape.end[:-1] - path.end[:-1]
        moved = np.asarray(shift.any(axis=1))
        tip_left = tip_tolerance - rounding.largest_around(np.linalg.norm(shift[:, :3], axis=1))
        axis_left = axis_tolerance - rounding.largest_around(np.linalg.norm(shift[:, 3:], axis=1))
        del shift
    slope = rounding.polyline_slopes(shape.start, shape.end, shape.length)
    bend = rounding.bends(slope)
    bend[~lines] = 0.0
    bumps = allowed & lines & ~joined & ~rounding.turning_back(slope)
    del slope
    wanted = np.where(bumps, rounding.room(bend, tip_left, axis_left), 0.0)
    wanted = np.where(curved, np.inf, wanted)
    reach = rounding.shared(wanted, path.length)
    most = reach[curved]
    if smoothing.overlap:
        walls = ~(bumps | (joined & lines))
        over = rounding.overlapping(np.where(bumps, wanted, 0.0), s, walls, curved)
        over = rounding.narrowed(over, bend, s, tip_left, axis_left)
        reach = np.where(bumps, np.maximum(over, 0.0), reach)
    reach = np.where(bumps, reach, 0.0)
    # bumps that reach over a corner take from a blend behind it what that corner leaves it
    most = np.minimum(most, rounding.clearance(reach, s)[curved])

    corner = np.flatnonzero(curved) - 1
    d, controls = blend_distances(path, corner, most, tip_left[corner + 1], axis_left[corner + 1])
    made = d > 0
    corner, d, controls = corner[made], d[made], controls[made]
    flows = joined | (reach > 0)
    flows[corner + 1] = True
    run = np.append(0, np.cumsum(~flows[1:-1])).astype(np.int32)
    used = flows & ~joined
    used[1:-1] |= moved  # also where a corner has become a stop
    tip_of_piece, axis_of_piece = (
        _of_pieces(np.where(used, bound, 0.0), reach, s) for bound in (tip_tolerance, axis_tolerance)
    )
    parts = _segments(path, s, reach, corner, d)
    piece = parts["piece"]
    share = np.where(parts["curve"] >= 0, 0.5, parts["high"] - parts["low"])
    corners = Corners(s, reach, bend)
    bumped = (parts["curve"] < 0) & rounding.bumped(
        corners, piece, *(s[piece] + parts[end] * path.length[piece] for end in ("low", "high"))
    )
    return Contour(
        path=path, shape=shape, turn=_turn(path)[piece] * share, run=run[piece],
        corners=corners if bumped.any() else None, bumped=bumped, feeds=feeds_of(path), controls=controls,
        tip_tolerance=tip_of_piece, axis_tolerance=axis_of_piece, dwell_run=path.dwells_among(run), **parts,
    )  # fmt: skip


def _fairing_bounds(path: ToolPath, moves: Moves, tip_tolerance: Array) -> Array:
    """How far vertices (n + 1,) may be moved: a share of the tolerance, and the Q of G64 where it is said."""
    merge = np.array([np.inf if control.merge is None else control.merge for control in moves.controls])
    control = np.where(path.move >= 0, moves.control[path.move], 0)
    bound = FAIRING_SHARE * tip_tolerance
    bound[1:-1] = np.minimum(bound[1:-1], np.minimum(merge[control[:-1]], merge[control[1:]]))
    return np.asarray(bound)


def _faired(path: ToolPath, s: Array, movable: Mask, tip_bound: Array, axis_bound: Array) -> ToolPath:
    """The path with the vertices of finely divided feed moves faired."""
    fed = path.feed_time > 0
    movable = movable.copy()
    movable[1:-1] &= fed[1:] & fed[:-1]
    vertex = np.concatenate([path.start[:1], path.end])
    moved = faired(vertex, s, movable, tip_bound, axis_bound)
    start, end = path.start.copy(), path.end.copy()
    rows = np.flatnonzero(movable)
    start[rows], end[rows - 1] = moved[rows], moved[rows]
    return replace(path, start=start, end=end)


def _may_be_rounded(path: ToolPath, moves: Moves, smoothing: Smoothing) -> tuple[Mask, Array, Array]:
    """Corners (n + 1,) between programmed pieces under G64, and their tolerances."""
    n = len(path)
    tip, axis = corner_tolerance(moves.controls, smoothing)
    control = np.where(path.move >= 0, moves.control[path.move], 0)
    own = (path.move >= 0) & (path.kind != PieceKind.JOINT)
    allowed = np.zeros(n + 1, dtype=bool)
    tip_tolerance, axis_tolerance = np.zeros(n + 1), np.zeros(n + 1)
    tip_tolerance[1:-1] = np.minimum(tip[control[:-1]], tip[control[1:]])
    axis_tolerance[1:-1] = np.minimum(axis[control[:-1]], axis[control[1:]])
    contact = np.abs(path.start[1:] - path.end[:-1]).max(axis=1) == 0.0
    # two motions of one source line (G28 with a via point) stay apart: their rows could not be told from one another
    other_line = path.line[1:] != path.line[:-1]
    same_tool = path.tool_length[1:] == path.tool_length[:-1]
    allowed[1:-1] = own[:-1] & own[1:] & (tip_tolerance[1:-1] > 0) & contact & other_line & same_tool
    allowed[path.run_begins[path.dwell_run]] = False
    return allowed, tip_tolerance, axis_tolerance


def corner_tolerance(controls: tuple[PathControl, ...], smoothing: Smoothing) -> tuple[Array, Array]:
    """Tip (mm) and axis (rad) tolerance of each path control; 0 where corners are not rounded.

    A P of 0 asks for an exact path. The axis tolerance goes with the default.
    """
    rounded = np.array([control.mode == PathMode.BLEND for control in controls])
    tip = np.array([smoothing.tip if control.tolerance is None else control.tolerance for control in controls])
    tip = np.where(rounded, tip, 0.0)
    return tip, np.where(tip > 0, smoothing.axis, 0.0)


def _of_pieces(bound: Array, reach: Array, s: Array) -> Array:
    """Largest bound (n,) among the corners that touch each piece, those of bumps that reach it included."""
    n = len(s) - 1
    found = np.maximum(bound[:-1], bound[1:])
    for shift in range(2, rounding.PIECES + 1):
        for side in (-1, 1):
            corner = np.arange(n) + (1 - shift if side < 0 else shift)
            inside = (corner >= 0) & (corner <= n)
            near = np.clip(corner, 0, n)
            away = (s[:-1] - s[near]) if side < 0 else (s[near] - s[1:])
            found = np.where(inside & (away < reach[near]), np.maximum(found, bound[near]), found)
    return found


def _segments(path: ToolPath, s: Array, reach: Array, corner: Ints, d: Array) -> dict[str, Any]:
    """Segments of all pieces in order: parts between breakpoints of bumps, and halves of the curves at their ends."""
    n = len(path)
    at_start, at_end = np.zeros(n), np.zeros(n)
    at_end[corner] = d / path.length[corner]
    at_start[corner + 1] = d / path.length[corner + 1]
    row_at_end, row_at_start = np.full(n, -1, dtype=np.int32), np.full(n, -1, dtype=np.int32)
    row_at_end[corner] = row_at_start[corner + 1] = np.arange(len(corner))
    index = np.arange(n, dtype=np.int32)
    inner, at, width = rounding.breakpoints(reach, s)
    u = (at - s[inner]) / path.length[inner]
    least = MIN_SHARE * np.where(width < NARROW_MM, 1.0, width / path.length[inner])
    inside = (u > at_start[inner] + least) & (u < 1.0 - at_end[inner] - least)
    inner, u, least = inner[inside], u[inside], least[inside]
    # begin of every part: the piece's own start, then its breakpoints; a part too short joins the one before
    piece = np.concatenate([index, inner])
    low, least = np.concatenate([at_start, u]), np.concatenate([np.zeros(n), least])
    order = np.lexsort((low, piece))
    piece, low, least = piece[order], low[order], least[order]
    near = np.append(False, (piece[1:] == piece[:-1]) & (np.diff(low) < np.minimum(least[1:], least[:-1])))
    piece, low = piece[~near], low[~near]
    last = np.append(piece[1:] != piece[:-1], True)
    high = np.where(last, 1.0 - at_end[piece], np.append(low[1:], 1.0))
    kept = high - low > 1e-9  # a piece that its curves use up has no part of its own left, up to rounding
    piece, low, high = piece[kept].astype(np.int32), low[kept], high[kept]
    before, after = np.flatnonzero(row_at_start >= 0).astype(np.int32), np.flatnonzero(row_at_end >= 0).astype(np.int32)
    half = 0.5 * STRETCH * d
    every = {
        "piece": np.concatenate([piece, before, after]),
        "curve": np.concatenate([np.full(len(piece), -1, dtype=np.int32), row_at_start[before], row_at_end[after]]),
        "low": np.concatenate([low, np.full(len(before), 0.5), np.zeros(len(after))]),
        "high": np.concatenate([high, np.ones(len(before)), np.full(len(after), 0.5)]),
        "length": np.concatenate(
            [(high - low) * path.length[piece], half[row_at_start[before]], half[row_at_end[after]]]
        ),
    }
    place = np.concatenate([low, np.full(len(before), -1.0), np.full(len(after), 2.0)])
    order = np.lexsort((place, every["piece"]))
    return {name: column[order] for name, column in every.items()}


def _turn(path: ToolPath) -> Array:
    """Rotation of each piece: table angles and the sweep of arcs, rad."""
    turn = np.abs(path.end[:, 3:] - path.start[:, 3:]).sum(axis=1)
    curved = path.arc >= 0
    turn[curved] += np.abs(path.arcs.sweep[path.arc[curved]])
    joint = path.kind == PieceKind.JOINT
    if joint.any():
        ends = path.joints[path.joint[joint]]
        turn[joint] = np.abs(ends[:, 1, -2:] - ends[:, 0, -2:]).sum(axis=1)
    return turn


def feeds_of(path: ToolPath) -> Feeds:
    """The feed of the tip along lines and arcs, of the table angles where the tip stands."""
    delta = path.end - path.start
    turn = np.linalg.norm(delta[:, 3:], axis=1)
    tip = np.linalg.norm(delta[:, :3], axis=1)
    arc = path.arc >= 0
    tip[arc] = np.sqrt(np.maximum(path.length[arc] ** 2 - (ROTARY_METRIC_MM * turn[arc]) ** 2, 0.0))
    by_tip = tip > ZERO_LENGTH_MM
    fed = path.feed_time > 0
    seconds = np.where(fed, path.feed_time, 1.0)
    rate = np.where(fed, np.where(by_tip, tip, turn) / seconds, np.inf)
    return Feeds(rate, by_tip, np.where(fed, path.length / seconds, np.inf))


def contour_pose(contour: Contour, segment: Ints, w: Array) -> tuple[Array, Array]:
    """Tip (n, 3) and nominal angles (n, 2) at parameter w (n,) of segments (n,)."""
    at = _along(contour, segment, w)
    piece = contour.piece[segment]
    tip, angles = pose(contour.shape, piece, at)
    bumped = np.flatnonzero(contour.bumped[segment])
    if contour.corners is not None and len(bumped):
        own = piece[bumped]
        corner = own + contour.corners.shift
        s = contour.corners.s[corner] + at[bumped] * contour.shape.length[own]
        off = rounding.displacement(contour.corners, corner, s)
        tip[bumped] += off[:, :3]
        angles[bumped] += off[:, 3:]
    curve = contour.curve[segment]
    curved = np.flatnonzero(curve >= 0)
    if len(curved):
        point = bernstein(contour.controls[curve[curved]], at[curved])
        tip[curved], angles[curved] = point[:, :3], point[:, 3:]
    return tip, angles


def _along(contour: Contour, segment: Ints, w: Array) -> Array:
    """Parameter (n,) of the piece or curve at parameter w (n,) of segments (n,)."""
    low = contour.low[segment]
    return np.asarray(low + w * (contour.high[segment] - low))


def speed_cap(contour: Contour, segment: Ints, w: Array) -> Array:
    """Largest ds/dt (n,) at which the tool keeps to the programmed feed, mm/s; infinite for rapids.

    On a piece the tip moves evenly with s. In a corner it moves slower than s, by how much follows from the derivative of
    the curve; for pieces whose tip stands still the table angles count.
    """
    feeds, shape = contour.feeds, contour.shape
    piece = contour.piece[segment]
    cap = feeds.even[piece]
    rate = feeds.rate[piece]
    uneven = np.flatnonzero((contour.bumped[segment] | (contour.curve[segment] >= 0)) & np.isfinite(rate))
    if not len(uneven):
        return cap
    row, own = segment[uneven], piece[uneven]
    at = _along(contour, row, w[uneven])
    length = shape.length[own]
    slope = (shape.end[own] - shape.start[own]) / length[:, None]
    if contour.corners is not None:
        corner = own + contour.corners.shift
        off = rounding.displacement_slope(
            contour.corners, corner, contour.corners.s.take(corner, mode="clip") + at * length
        )
        slope += off
    curved = np.flatnonzero(contour.curve[row] >= 0)
    if len(curved):
        some = row[curved]
        slope[curved] = bernstein_slope(contour.controls[contour.curve[some]], at[curved])
        slope[curved] *= ((contour.high[some] - contour.low[some]) / contour.length[some])[:, None]
    square = slope * slope
    of_tip = square[:, 0] + square[:, 1] + square[:, 2]
    with np.errstate(divide="ignore"):
        cap[uneven] = rate[uneven] / np.sqrt(np.where(feeds.by_tip[own], of_tip, square[:, 3] + square[:, 4]))
    return cap
