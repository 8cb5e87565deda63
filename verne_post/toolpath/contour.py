"""ToolPath -> Contour: where the tool flows, where it stops, and the poses along it."""

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.columns import Growing, GrowingTable, blocks, running_sums
from verne_post.base.rows import row_norm
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.model.contour import Contour, Corners, Feeds
from verne_post.model.moves import Moves, PathControl, PathMode
from verne_post.model.toolpath import SegmentKind, ToolPath, sections_at
from verne_post.toolpath import corners as rounding
from verne_post.toolpath.blend import STRETCH, blend_distances, tangent
from verne_post.toolpath.build import ROTARY_METRIC_MM
from verne_post.toolpath.fairing import fair, features

Array = NDArray[np.float64]
Ints = NDArray[np.integer]
Mask = NDArray[np.bool_]

#: Vertices of finely divided curves move by at most this share of their tolerance; the rest is for rounding corners.
FAIRING_SHARE: Final = 0.35
#: A element shorter than this share of the bumps that bound it is given to its neighbour: only there does the contour
#: bend so little on it that it is smooth across both. Bumps narrower than ``NARROW_MM`` are over within a few control
#: cycles: they need no element of less than this share of their segment, and the time law does better without.
MIN_SHARE: Final = 1e-3
NARROW_MM: Final = 0.01
#: What becomes of a segment depends on no more than so many on each side: a bump on those it reaches, and so on in each round
#: of narrowing.
NEIGHBOURS: Final = (rounding.NARROWINGS + 4) * (2 * rounding.SEGMENTS + 1)


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
    """The segments as they are, with a stop at every corner: one element a segment."""
    elements, segments = GrowingTable(**_ELEMENTS), GrowingTable(**_SEGMENTS)
    for begin, end in blocks(len(path)):
        part, zero = path.part(begin, end), np.zeros(end - begin)
        elements.extend(
            segment=np.arange(begin, end), curve=zero - 1, low=zero, high=zero + 1, length=part.length, turn=_turn(part),
            section=part.section, blended=zero,
        )  # fmt: skip
        segments.extend(tip_tolerance=zero, axis_tolerance=zero, **vars(feeds_of(part)))
    return _contour(path, path, elements, segments, None, np.empty((0, 8, 5)), path.dwell_section)


#: Columns of a contour for every element and every segment, as they are made block by block.
_ELEMENTS: Final = {
    "segment": (np.int32,), "curve": (np.int32,), "low": (float,), "high": (float,), "length": (float,), "turn": (float,),
    "section": (np.int32,), "blended": (bool,),
}  # fmt: skip
_SEGMENTS: Final = {
    "tip_tolerance": (float,), "axis_tolerance": (float,), "rate": (float,), "by_tip": (bool,), "even": (float,)
}  # fmt: skip


def _contour(
    path: ToolPath, shape: ToolPath, elements: GrowingTable, segments: GrowingTable, corners: Corners | None, controls: Array,
    dwell_section: NDArray[np.int32],
) -> Contour:  # fmt: skip
    of_segment = segments.columns()
    feeds = Feeds(*(of_segment.pop(name) for name in ("rate", "by_tip", "even")))
    return Contour(
        path=path, shape=shape, corners=corners, controls=controls, feeds=feeds, dwell_section=dwell_section, **of_segment, **elements.columns()
    )  # fmt: skip


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
    s = running_sums(path.length)
    shape = _faired(path, s, moves, smoothing) if smoothing.overlap else path
    elements, segments, controls = GrowingTable(**_ELEMENTS), GrowingTable(**_SEGMENTS), Growing(float, 8, 5)
    corners = GrowingTable(reach=(float,), bend=(float, 5))
    section = n_curves = 0
    blended = False
    for begin, end in blocks(n):
        first, last = max(begin - NEIGHBOURS, 0), min(end + NEIGHBOURS, n)
        seen = path.part(first, last)
        made = _rounded(
            seen, shape.part(first, last), s[first : last + 1], _marks(path, first, last, moves, smoothing), smoothing
        )
        own = slice(begin - first, end - first)
        flows = made.flows[own]
        if not begin:
            flows[0] = True
        sections = np.cumsum(~flows) + section
        mine = slice(*np.searchsorted(made.elements["segment"], [own.start, own.stop]))
        some = {name: column[mine] for name, column in made.elements.items()}
        before, behind = np.searchsorted(made.corner, [own.start, own.stop])
        curve = np.where(some["curve"] < 0, -1, some["curve"] - before + n_curves)
        elements.extend(
            **some
            | {"segment": some["segment"] + first, "curve": curve, "section": sections[some["segment"] - own.start]}
        )
        segments.extend(
            tip_tolerance=made.tip_tolerance[own], axis_tolerance=made.axis_tolerance[own],
            **{name: column[own] for name, column in vars(feeds_of(seen)).items()},
        )  # fmt: skip
        with_end = slice(own.start, own.stop + (end == n))
        corners.extend(reach=made.reach[with_end], bend=made.bend[with_end])
        controls.extend(made.controls[before:behind])
        section, n_curves, blended = (
            int(sections[-1]),
            n_curves + int(behind - before),
            blended or bool(some["blended"].any()),
        )
    found = _contour(
        path, shape, elements, segments, Corners(s, **corners.columns()) if blended else None, controls.column(), path.dwell_section
    )  # fmt: skip
    return replace(found, dwell_section=sections_at(found.section, np.searchsorted(found.segment, path.dwell_segment)))


@dataclass(frozen=True)
class _Marks:
    """What may happen at the corners (n + 1,) of segments; never anything at both ends.

    Attributes
    ----------
    allowed : ndarray of bool
        G64 holds, and the segments meet.
    joined, lines, curved : ndarray of bool
        The segments go on without a corner; both are straight; a blend is made where there is room.
    tip_tolerance, axis_tolerance : ndarray
        mm and rad.
    """

    allowed: Mask
    joined: Mask
    lines: Mask
    curved: Mask
    tip_tolerance: Array
    axis_tolerance: Array


def _marks(path: ToolPath, first: int, last: int, moves: Moves, smoothing: Smoothing) -> _Marks:
    """Those of segments ``first`` to ``last`` (excluded)."""
    part, dwells = path.part(first, last), path.dwell_segment - first
    n = last - first
    allowed, tip_tolerance, axis_tolerance = _may_be_rounded(
        part, moves, smoothing, dwells[(dwells >= 0) & (dwells <= n)]
    )
    joined = np.zeros(n + 1, dtype=bool)
    joined[1:-1] = part.section[1:] == part.section[:-1]
    straight = (part.kind == SegmentKind.LINE) & (part.circle < 0)
    lines = np.zeros(n + 1, dtype=bool)
    lines[1:-1] = straight[1:] & straight[:-1]
    if smoothing.overlap:  # vertices between collinear segments may move like their neighbours
        joined &= ~(allowed & lines)
    curved = allowed & ~lines & ~joined
    curved[1:-1] &= (
        np.sum(tangent(part, np.arange(n - 1), 1.0) * tangent(part, np.arange(1, n), 0.0), axis=1) > rounding.REVERSAL
    )
    return _Marks(allowed, joined, lines, curved, tip_tolerance, axis_tolerance)


def _faired(path: ToolPath, s: Array, moves: Moves, smoothing: Smoothing) -> ToolPath:
    """The path with the vertices of finely divided feed moves faired."""
    n = len(path)
    vertex, table = Growing(float, 5), GrowingTable(soft=(bool,), tip=(float,), axis=(float,))
    vertex.extend(path.start[:1])
    for begin, end in blocks(n):
        vertex.extend(path.end[begin:end])
        first, last = max(begin - NEIGHBOURS, 0), min(end + NEIGHBOURS, n)
        part, marks = path.part(first, last), _marks(path, first, last, moves, smoothing)
        straight = ~rounding.turning_back(rounding.polyline_slopes(part.start, part.end, part.length))
        soft = marks.allowed & marks.lines & ~marks.joined & straight
        # a segment that runs on into another, or into a blend, keeps its direction, which was matched as programmed
        kept = marks.joined | marks.curved
        soft[1:-1] &= ~(kept[2:] | kept[:-2])
        tip = _fairing_bounds(part, moves, marks.tip_tolerance)
        fed = part.feed_time > 0
        soft[1:-1] &= fed[1:] & fed[:-1]
        soft &= (tip > 0) & ~features(np.concatenate([part.start[:1], part.end]), s[first : last + 1])
        own = slice(begin - first, end - first + (end == n))
        table.extend(soft=soft[own], tip=tip[own], axis=FAIRING_SHARE * marks.axis_tolerance[own])
    columns = table.columns()
    moved = fair(vertex.column(), s, columns["soft"], columns["tip"], columns["axis"])
    places = GrowingTable(start=(float, 5), end=(float, 5))
    for begin, end in blocks(n):
        soft = columns["soft"][begin : end + 1, None]
        places.extend(
            start=np.where(soft[:-1], moved[begin:end], path.start[begin:end]),
            end=np.where(soft[1:], moved[begin + 1 : end + 1], path.end[begin:end]),
        )
    return replace(path, **places.columns())


@dataclass(frozen=True)
class _Rounded:
    """Some neighbouring segments (n,), rounded: their elements, corners (n + 1,) and curves.

    ``flows`` says whether a corner is none any more, ``corner`` (m,) before which segment each of the curves lies.
    """

    elements: dict[str, Any]
    reach: Array
    bend: Array
    flows: Mask
    corner: Ints
    controls: Array
    tip_tolerance: Array
    axis_tolerance: Array


def _rounded(path: ToolPath, shape: ToolPath, s: Array, marks: _Marks, smoothing: Smoothing) -> _Rounded:
    """Round the corners of some segments, whose vertices have been moved to those of ``shape``."""
    allowed, joined, lines, curved = marks.allowed, marks.joined, marks.lines, marks.curved
    tip_tolerance, axis_tolerance = marks.tip_tolerance, marks.axis_tolerance
    shift = shape.end[:-1] - path.end[:-1]
    moved = np.asarray(shift.any(axis=1))
    tip_left = tip_tolerance - rounding.largest_around(row_norm(shift[:, :3]))
    axis_left = axis_tolerance - rounding.largest_around(row_norm(shift[:, 3:]))
    slope = rounding.polyline_slopes(shape.start, shape.end, shape.length)
    bend = rounding.bends(slope)
    bend[~lines] = 0.0
    bumps = allowed & lines & ~joined & ~rounding.turning_back(slope)
    wanted = np.where(bumps, rounding.free_length(bend, tip_left, axis_left), 0.0)
    wanted = np.where(curved, np.inf, wanted)
    reach = rounding.shared(wanted, path.length)
    most = reach[curved]
    if smoothing.overlap:
        walls = ~(bumps | (joined & lines))
        over = rounding.overlapping(np.where(bumps, wanted, 0.0), s, walls, curved)
        over = rounding.narrow(over, bend, s, tip_left, axis_left)
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
    used = flows & ~joined
    used[1:-1] |= moved  # also where a corner has become a stop
    tip_of_segment, axis_of_segment = (
        _of_segments(np.where(used, bound, 0.0), reach, s) for bound in (tip_tolerance, axis_tolerance)
    )
    parts = _elements(path, s, reach, corner, d)
    segment = parts["segment"]
    share = np.where(parts["curve"] >= 0, 0.5, parts["high"] - parts["low"])
    parts["turn"] = _turn(path)[segment] * share
    parts["blended"] = (parts["curve"] < 0) & rounding.blend_at(
        Corners(s, reach, bend), segment, *(s[segment] + parts[end] * path.length[segment] for end in ("low", "high"))
    )
    return _Rounded(parts, reach, bend, flows, corner + 1, controls, tip_of_segment, axis_of_segment)


def _fairing_bounds(path: ToolPath, moves: Moves, tip_tolerance: Array) -> Array:
    """How far vertices (n + 1,) may be moved: a share of the tolerance, and the Q of G64 where it is said."""
    merge = np.array([np.inf if control.merge is None else control.merge for control in moves.controls])
    control = np.where(path.move >= 0, moves.control[path.move], 0)
    bound = FAIRING_SHARE * tip_tolerance
    bound[1:-1] = np.minimum(bound[1:-1], np.minimum(merge[control[:-1]], merge[control[1:]]))
    return np.asarray(bound)


def _may_be_rounded(path: ToolPath, moves: Moves, smoothing: Smoothing, dwells: Ints) -> tuple[Mask, Array, Array]:
    """Corners (n + 1,) between programmed segments under G64 but for those with dwells, and their tolerances."""
    n = len(path)
    tip, axis = corner_tolerance(moves.controls, smoothing)
    control = np.where(path.move >= 0, moves.control[path.move], 0)
    own = (path.move >= 0) & (path.kind != SegmentKind.JOINT)
    allowed = np.zeros(n + 1, dtype=bool)
    tip_tolerance, axis_tolerance = np.zeros(n + 1), np.zeros(n + 1)
    tip_tolerance[1:-1] = np.minimum(tip[control[:-1]], tip[control[1:]])
    axis_tolerance[1:-1] = np.minimum(axis[control[:-1]], axis[control[1:]])
    contact = np.abs(path.start[1:] - path.end[:-1]).max(axis=1) == 0.0
    # two motions of one source line (G28 with a via point) stay apart: their rows could not be told from one another
    other_line = path.line[1:] != path.line[:-1]
    same_tool = path.tool_length[1:] == path.tool_length[:-1]
    allowed[1:-1] = own[:-1] & own[1:] & (tip_tolerance[1:-1] > 0) & contact & other_line & same_tool
    allowed[dwells] = False
    return allowed, tip_tolerance, axis_tolerance


def corner_tolerance(controls: tuple[PathControl, ...], smoothing: Smoothing) -> tuple[Array, Array]:
    """Tip (mm) and axis (rad) tolerance of each path control; 0 where corners are not rounded.

    A P of 0 asks for an exact path. The axis tolerance goes with the default.
    """
    rounded = np.array([control.mode == PathMode.BLEND for control in controls])
    tip = np.array([smoothing.tip if control.tolerance is None else control.tolerance for control in controls])
    tip = np.where(rounded, tip, 0.0)
    return tip, np.where(tip > 0, smoothing.axis, 0.0)


def _of_segments(bound: Array, reach: Array, s: Array) -> Array:
    """Largest bound (n,) among the corners that touch each segment, those of bumps that reach it included."""
    n = len(s) - 1
    found = np.maximum(bound[:-1], bound[1:])
    for shift in range(2, rounding.SEGMENTS + 1):
        for side in (-1, 1):
            corner = np.arange(n) + (1 - shift if side < 0 else shift)
            inside = (corner >= 0) & (corner <= n)
            near = np.clip(corner, 0, n)
            away = (s[:-1] - s[near]) if side < 0 else (s[near] - s[1:])
            found = np.where(inside & (away < reach[near]), np.maximum(found, bound[near]), found)
    return found


def _elements(path: ToolPath, s: Array, reach: Array, corner: Ints, d: Array) -> dict[str, Any]:
    """Elements of all segments in order: parts between breakpoints of bumps, and halves of the curves at their ends."""
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
    # begin of every part: the segment's own start, then its breakpoints; a part too short joins the one before
    segment = np.concatenate([index, inner])
    low, least = np.concatenate([at_start, u]), np.concatenate([np.zeros(n), least])
    order = np.lexsort((low, segment))
    segment, low, least = segment[order], low[order], least[order]
    near = np.append(False, (segment[1:] == segment[:-1]) & (np.diff(low) < np.minimum(least[1:], least[:-1])))
    segment, low = segment[~near], low[~near]
    last = np.append(segment[1:] != segment[:-1], True)
    high = np.where(last, 1.0 - at_end[segment], np.append(low[1:], 1.0))
    kept = high - low > 1e-9  # a segment that its curves use up has no part of its own left, up to rounding
    segment, low, high = segment[kept].astype(np.int32), low[kept], high[kept]
    before, after = np.flatnonzero(row_at_start >= 0).astype(np.int32), np.flatnonzero(row_at_end >= 0).astype(np.int32)
    half = 0.5 * STRETCH * d
    every = {
        "segment": np.concatenate([segment, before, after]),
        "curve": np.concatenate([np.full(len(segment), -1, dtype=np.int32), row_at_start[before], row_at_end[after]]),
        "low": np.concatenate([low, np.full(len(before), 0.5), np.zeros(len(after))]),
        "high": np.concatenate([high, np.ones(len(before)), np.full(len(after), 0.5)]),
        "length": np.concatenate(
            [(high - low) * path.length[segment], half[row_at_start[before]], half[row_at_end[after]]]
        ),
    }
    place = np.concatenate([low, np.full(len(before), -1.0), np.full(len(after), 2.0)])
    order = np.lexsort((place, every["segment"]))
    return {name: column[order] for name, column in every.items()}


def _turn(path: ToolPath) -> Array:
    """Rotation of each segment: table angles and the sweep of arcs, rad."""
    turn = np.abs(path.end[:, 3:] - path.start[:, 3:]).sum(axis=1)
    curved = path.arc >= 0
    turn[curved] += np.abs(path.arcs.sweep[path.arc[curved]])
    joint = path.kind == SegmentKind.JOINT
    if joint.any():
        ends = path.joints[path.joint[joint]]
        turn[joint] = np.abs(ends[:, 1, -2:] - ends[:, 0, -2:]).sum(axis=1)
    return turn


def feeds_of(path: ToolPath) -> Feeds:
    """The feed of the tip along lines and arcs, of the table angles where the tip stands."""
    delta = path.end - path.start
    turn = row_norm(delta[:, 3:])
    tip = row_norm(delta[:, :3])
    arc = path.arc >= 0
    tip[arc] = np.sqrt(np.maximum(path.length[arc] ** 2 - (ROTARY_METRIC_MM * turn[arc]) ** 2, 0.0))
    by_tip = (tip > ZERO_LENGTH_MM) | (turn == 0.0)
    fed = path.feed_time > 0
    seconds = np.where(fed, path.feed_time, 1.0)
    rate = np.where(fed, np.where(by_tip, tip, turn) / seconds, np.inf)
    return Feeds(rate, by_tip, np.where(fed, path.length / seconds, np.inf))
