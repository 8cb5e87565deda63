"""What may happen at each corner of a tool path: whether it may be blended, how, and within which tolerance."""

from collections.abc import Callable
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import WHOLE_CYCLE, ZERO_ANGLE
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.moves import Moves, PathMode
from verne_post.model.nutation import Nutation
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.toolpath.corners import REVERSAL
from verne_post.toolpath.curved_corners import find_tangents

#: Moves of one source line are blended with each other where their tips move by so many tolerances: their rows do not
#: distinguish shorter ones. With 4, 1 in 100 random programs of one line fails its verification; with 8, none of 240.
_DISTINCT: Final = 8.0
#: The axis tolerance of 0.05 degrees is 3.4 degrees of the tilting joint at the fold of a pair at 45 degrees; rad.
_FOLD_CORNER: Final = np.radians(5.0)
#: A segment lasts long that takes more than this times the root of its speed in mm/s; s. It is not blended: stops
#: at its ends take less than a thousandth of that where the jerk may be 1 m/s3. From stop to stop it is planned in one
#: step, and through its corners by its time, which is hours at a mistyped feed rate.
_LONG_LASTING: Final = 60.0
#: Largest third derivative by time (n,) that the joints allow at poses (n, 5) along directions (n, 5), with tool
#: lengths (n,); mm/s3 along unit vectors. It is not a number where a pose is out of reach.
JerkLimit = Callable[[Array, Array, Array], Array]


class Smoothing(Struct, frozen=True):
    """What may be done to corners."""

    overlap: bool  #: Corner blends of finely divided curves may overlap.
    #: tip, axis: Tolerances of a G64 without P, mm and rad.
    tip: float
    axis: float
    jerk_limit: JerkLimit  #: What the joints allow.
    #: Whether poses (n, 5) with tool lengths (n,) keep the travel of every joint.
    keeps_travel: Callable[[Array, Array], Mask]
    cycle: float  #: Control cycle, s.
    share: float = 1.0  #: Of every tolerance, that corners may use.
    nutation: Nutation | None = None  #: Of a rotary pair that is not at right angles.


class CornerRules(Struct, frozen=True):
    """What may happen at the corners (n + 1,) of n segments; never anything at both ends."""

    allowed_corners: Mask  #: G64 holds, and the segments meet.
    smooth: Mask  #: The segments continue each other without a corner.
    straight: Mask  #: Both segments are straight: a corner is blended as in :mod:`verne_post.toolpath.corners`.
    curved_corners: Mask  #: It may be blended as in :mod:`verne_post.toolpath.curved_corners`.
    #: tip_tolerance, axis_tolerance: mm and rad.
    tip_tolerance: Array
    axis_tolerance: Array


def find_corner_rules(
    path: ToolPath, off: Array, first: int, last: int, moves: Moves, smoothing: Smoothing
) -> CornerRules:
    """Find the rules of segments ``first`` to ``last`` (excluded); ``off`` (n,) is used of the axis tolerance."""
    part, dwells = path.take_part(first, last), path.dwell_segment - first
    n = last - first
    tip_tolerance, axis_tolerance = _find_tolerances(part, moves, smoothing)
    axis_tolerance[1:-1] -= np.maximum(off[first + 1 : last], off[first : last - 1])
    allowed = np.zeros(n + 1, dtype=bool)
    allowed[1:-1] = _may_blend(part, tip_tolerance[1:-1], smoothing.cycle) & (tip_tolerance[1:-1] > 0)
    if smoothing.nutation is not None:
        allowed[1:-1] &= ~_find_folds(part, smoothing.nutation)
    lasting = part.feed_time**1.5 > _LONG_LASTING * np.sqrt(part.length)
    allowed[1:-1] &= ~(lasting[1:] | lasting[:-1])
    allowed[dwells[(dwells >= 0) & (dwells <= n)]] = False
    smooth, straight = np.zeros(n + 1, dtype=bool), np.zeros(n + 1, dtype=bool)
    smooth[1:-1] = part.section[1:] == part.section[:-1]
    line = (part.kind == SegmentKind.LINE) & (part.circle < 0)
    straight[1:-1] = line[1:] & line[:-1]
    if smoothing.overlap:  # vertices between collinear segments may move like their neighbours
        smooth &= ~(allowed & straight)
    curved = allowed & ~straight & ~smooth
    arriving, leaving = find_tangents(part, np.arange(n - 1), 1.0), find_tangents(part, np.arange(1, n), 0.0)
    curved[1:-1] &= np.sum(arriving * leaving, axis=1) > REVERSAL
    return CornerRules(allowed, smooth, straight, curved, tip_tolerance, axis_tolerance)


def _find_folds(path: ToolPath, nutation: Nutation) -> Mask:
    """Corners (n - 1,) where the rotary axes turn so near to a fold that blending A would be a jerk of the joint."""
    turns = np.asarray((np.abs(path.end - path.start)[:, 3:] > ZERO_ANGLE).any(axis=1))
    left = nutation.measure_fold(nutation.find_joints(path.end[:-1, 3:])[:, 0])
    return np.asarray((turns[1:] | turns[:-1]) & (left < _FOLD_CORNER))


def _may_blend(path: ToolPath, tip_tolerance: Array, cycle: float) -> Mask:
    """Corners (n - 1,), with tip tolerances in mm, between programmed segments that meet, with one tool.

    Loops cut many feed moves by one source line. Rows name only their line, so their places must distinguish such
    moves, and a row stands on each. Rapids in one line (G28 with a via point, canned cycles) only position, from stop
    to stop.
    """
    programmed = (path.move >= 0) & (path.kind != SegmentKind.JOINT)
    contact = np.abs(path.start[1:] - path.end[:-1]).max(axis=1) == 0.0
    tip = np.where(path.kind == SegmentKind.LINE, measure_rows(path.end[:, :3] - path.start[:, :3]), path.length)
    distinct = np.ones(len(path) - 1, dtype=bool)
    for segment in (slice(None, -1), slice(1, None)):
        distinct &= tip[segment] >= _DISTINCT * tip_tolerance
        distinct &= path.feed_time[segment] >= cycle * (1.0 - WHOLE_CYCLE)
    other_line = path.line[1:] != path.line[:-1]
    same_tool = path.tool_length[1:] == path.tool_length[:-1]
    return np.asarray(programmed[:-1] & programmed[1:] & contact & (other_line | distinct) & same_tool)


def _find_tolerances(path: ToolPath, moves: Moves, smoothing: Smoothing) -> tuple[Array, Array]:
    """Tip (mm) and axis (rad) tolerance of corners (n + 1,): the smaller of both moves; 0 without G64, and for P 0."""
    tip, axis = (
        smoothing.share * _choose_smaller_of_both(path, moves, one)
        for one in _list_control_tolerances(moves, smoothing)
    )
    return tip, np.where(tip > 0, axis, 0.0)


def _list_control_tolerances(moves: Moves, smoothing: Smoothing) -> tuple[Array, Array]:
    """Tip (mm) and axis (rad) tolerance of every path control; tip 0 without G64.

    The axis tolerance is that of the program (OTOL of Siemens programs), else of the options.
    """
    given = [smoothing.tip if control.tolerance is None else control.tolerance for control in moves.controls]
    blends = [control.mode == PathMode.BLEND for control in moves.controls]
    axes = [
        smoothing.axis if control.axis_deg is None else RAD_PER_DEG * control.axis_deg for control in moves.controls
    ]
    return np.where(blends, np.array(given), 0.0), np.array(axes)


def find_segment_tolerances(path: ToolPath, moves: Moves, smoothing: Smoothing) -> tuple[Array, Array]:
    """Tip (mm) and axis (rad) tolerance of segments (n,) as the program has it, without ``share``; 0 without G64."""
    tip_of, axis_of = _list_control_tolerances(moves, smoothing)
    control = np.where(path.move >= 0, moves.control[path.move], 0)
    tip = np.where(path.move >= 0, tip_of[control], 0.0)
    return tip, np.where(tip > 0, axis_of[control], 0.0)


def limit_fairing(path: ToolPath, moves: Moves, tip_bound: Array) -> Array:
    """How far vertices (n + 1,) may be moved, mm: by ``tip_bound`` (n + 1,), and by no more than the Q of G64."""
    merge = np.array([np.inf if control.merge is None else control.merge for control in moves.controls])
    bound = tip_bound.copy()
    bound[1:-1] = np.minimum(bound[1:-1], _choose_smaller_of_both(path, moves, merge)[1:-1])
    return bound


def _choose_smaller_of_both(path: ToolPath, moves: Moves, of_control: Array) -> Array:
    """The smaller value (n + 1,) of the moves on both sides of a corner, by their path controls; 0 at both ends."""
    control = np.where(path.move >= 0, moves.control[path.move], 0)
    smaller = np.zeros(len(path) + 1)
    smaller[1:-1] = np.minimum(of_control[control[:-1]], of_control[control[1:]])
    return smaller
