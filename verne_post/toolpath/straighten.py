"""Curves followed as straight segments: short arcs, and short steps between tool vectors, within tolerance.

CAM systems fit arcs to curves, and cut the swing of a tool axis into steps of a degree or so. A short arc is almost its
chord; along a short step the great circle from axis to axis is almost linear in A and C. Followed linearly, each is a
straight segment: it is faired, and its corners are blended with those around, over several segments, as if it had been
programmed so. The distance of the contour from the curve counts in its deviation. The programmed path keeps its curves,
and verification measures from them.

A corner beside an arc is blended over half a segment at most, corners of chords over two segments on each side. But
chords make corners where tangent arcs have none, and between a chord and an arc there is one as well. So every corner
has four predicted losses of speed, for each of its segments as a curve or as a straight segment. Dynamic programming
(Viterbi) finds the cheapest sequence. Lines are always straight, and arcs too high for their chords are curves.
"""

from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import GrowingTable, iterate_blocks
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.rows import measure_rows
from verne_post.model.moves import Moves
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.toolpath.corner_rules import Smoothing, find_segment_tolerances
from verne_post.toolpath.corner_shapes import PEAK, THIRD
from verne_post.toolpath.corners import METRIC, SEGMENTS, find_slopes, find_smaller_beside
from verne_post.toolpath.curved_corners import find_derivatives
from verne_post.toolpath.deviations import Chords
from verne_post.toolpath.elements import find_feeds
from verne_post.toolpath.evaluate import evaluate_arc, find_circle_axis

#: Extra cost of a corner between a chord and an arc, as a share of the feed rate: braking for one slow corner takes
#: longer than passing it. Of 400 random programs 16 take over 1 % longer than with arcs alone at 0, 8 at 0.1, 2 from
#: 0.3 to 1.
MIXING: Final = 0.3
#: The choice depends on so many segments on each side, or on fewer.
OVERLAP: Final = 64
#: What a way of following a segment costs that it cannot have: more than all corners that the choice depends on.
_NEVER: Final = 1e6

#: Share of the axis tolerance that following a great circle linearly may use. The corners have the rest. Over 600
#: random programs with coarse steps the time is 0.909 of that between great circles with a quarter, 0.897 with half;
#: single programs lose 3 %.
CIRCLE_SHARE: Final = 0.5
#: Chords stand for arcs that are off them by no more than this share of the tip tolerance. 400 random programs take
#: 0.943 of the time between arcs with 0.65, 0.941 with 0.8, 0.938 with 0.95. The rest is for the corners.
ARC_SHARE: Final = 0.9
#: Arcs of no larger angle may have chords. 133 random programs with arcs take 0.981 of the time between arcs with 60
#: degrees, 0.973 with 80, 0.969 with 90, 0.943 with nearly 180: along such arcs the tool does not go to and fro inside
#: its tolerance.
SHARPEST: Final = 0.9 * np.pi
#: Places, as shares of a step, where the distance between great circle and linear A and C is measured. It is largest
#: near the middle, and between the places at most 2 % larger than at them: less than corners leave of the tolerance.
_PLACES: Final = (1 / 8, 2 / 8, 3 / 8, 4 / 8, 5 / 8, 6 / 8, 7 / 8)


class Straightened(Struct, frozen=True):
    """How far n straight segments are from the curves in whose place they are; 0 for the others."""

    chords: Chords  #: From arcs.
    swing: Array  #: (n,): Largest angle between the tool axes, rad.

    def take_part(self, first: int, last: int) -> "Straightened":
        """Segments ``first`` to ``last`` (excluded)."""
        return Straightened(self.chords.take(slice(first, last)), self.swing[first:last])


def straighten(path: ToolPath, moves: Moves, smoothing: Smoothing) -> tuple[ToolPath, Straightened]:
    """Take arcs and great circles that are nearly straight for straight segments, where G64 holds and the tip moves.

    Arcs only where blends may overlap: else chords gain nothing.
    """
    n = len(path)
    if not len(path.circles.angle) and not len(path.arcs.sweep):
        zero, one = np.broadcast_to(0.0, (n, 3)), np.broadcast_to(1.0, n)
        return path, Straightened(Chords(zero, one), zero[:, 0])
    followed = GrowingTable(kind=(np.int8,), arc=(np.int32,), circle=(np.int32,))
    left = GrowingTable(sag=(float, 3), cosine=(float,), swing=(float,))
    for begin, end in iterate_blocks(n):
        first, last = max(begin - OVERLAP, 0), min(end + OVERLAP, n)
        part, mine = path.take_part(first, last), slice(begin - first, end - first)
        tip, axis = (smoothing.share * bound for bound in find_segment_tolerances(part, moves, smoothing))
        allowed = (tip > 0) & (part.start[:, :3] != part.end[:, :3]).any(axis=1)
        swing = _measure_swings(part, np.flatnonzero(allowed & (part.circle >= 0)))
        linear = swing <= CIRCLE_SHARE * axis
        part = replace(part, circle=np.where(linear, -1, part.circle))
        chords = _find_chords(part, np.flatnonzero(allowed & (part.arc >= 0)))
        chord = (measure_rows(chords.sag) <= ARC_SHARE * _find_smallest_around(tip)) & smoothing.overlap
        if chord.any():
            chord = choose_chords(part, chord, tip, smoothing)
        followed.extend(
            kind=np.where(chord, SegmentKind.LINE, part.kind)[mine],
            arc=np.where(chord, -1, part.arc)[mine],
            circle=part.circle[mine],
        )
        left.extend(
            sag=np.where(chord[:, None], chords.sag, 0.0)[mine],
            cosine=np.where(chord, chords.cosine, 1.0)[mine],
            swing=np.where(linear, swing, 0.0)[mine],
        )
    sag, cosine, swing = left.freeze().values()
    return replace(path, **followed.freeze()), Straightened(Chords(sag, cosine), swing)


def _find_smallest_around(tolerance: Array) -> Array:
    """The smallest tolerance (n,) of segments and those beside them that have any: the corners between have it."""
    padded = np.pad(np.where(tolerance > 0, tolerance, np.inf), 1, constant_values=np.inf)
    return np.minimum(np.minimum(padded[:-2], padded[2:]), tolerance)


def _find_chords(path: ToolPath, segment: Ints) -> Chords:
    """Chords (n,) of the arcs on some segments (m,); infinitely far off for the others."""
    sag, cosine = np.full((len(path), 3), np.inf), np.ones(len(path))
    sweep = np.abs(path.arcs.sweep[path.arc[segment]])
    flat, cosine[segment] = segment[sweep <= SHARPEST], np.cos(0.5 * sweep)
    middle = evaluate_arc(path.arcs, path.arc[flat], np.full(len(flat), 0.5))
    sag[flat] = 0.5 * (path.start[flat, :3] + path.end[flat, :3]) - middle
    return Chords(sag, cosine)


def _measure_swings(path: ToolPath, segment: Ints) -> Array:
    """Largest angle (n,), rad, between great circles on segments (m,) and linear A and C; infinite for others."""
    start, end = path.start[segment, 3:], path.end[segment, 3:]
    swing = np.full(len(path), np.inf)
    off = np.zeros(len(segment))
    for share in _PLACES:
        axis = find_circle_axis(path, segment, np.full(len(segment), share))
        angles = start + share * (end - start)
        off = np.maximum(off, measure_rows(axis - find_axis_of_angles(angles[:, 0], angles[:, 1])))
    by_joints = np.isfinite(
        path.circles.joints[path.circle[segment], 0]
    )  # which linear A and C would bend, at folds without bound
    swing[segment] = np.where(by_joints, np.inf, off)
    return swing


def choose_chords(path: ToolPath, fits: Mask, tolerance: Array, smoothing: Smoothing) -> Mask:
    """Choose arcs (n,) that are followed as chords.

    Parameters
    ----------
    fits : ndarray of bool, shape (n,)
        Arcs whose chords are near enough.
    tolerance : ndarray, shape (n,)
        Of the tip, mm; where it is 0 on one side of a corner, the tool stops there in any case.
    """
    least = np.minimum(tolerance[1:], tolerance[:-1])
    corner = np.flatnonzero((fits[1:] | fits[:-1]) & (least > 0))
    straight = (path.kind == SegmentKind.LINE) & (path.circle < 0)
    loss = np.zeros((max(len(path) - 1, 0), 2, 2))
    loss[corner] = _predict_losses(path, corner, least[corner], straight, smoothing)
    return fits & find_cheapest_sequence(loss, straight, ~(fits | straight))


def _predict_losses(path: ToolPath, corner: Ints, tolerance: Array, straight: Mask, smoothing: Smoothing) -> Array:
    """Shares of the feed rate (m, 2, 2) that are lost at corners between segments ``corner`` and ``corner + 1``.

    The second index tells whether the segment before is followed as a straight one, the third the one after.
    """
    slope = find_slopes(path.start, path.end, path.length)
    before = find_derivatives(path, corner, 1.0)[:, 0], slope[corner]
    after = find_derivatives(path, corner + 1, 0.0)[:, 0], slope[corner + 1]
    length = np.minimum(path.length[corner], path.length[corner + 1])
    feed = find_smaller_beside(find_feeds(path).cap)[corner + 1]
    loss = np.empty((len(corner), 2, 2))
    for chord_before in (0, 1):
        for chord_after in (0, 1):
            bend = after[chord_after] - before[chord_before]
            overlaps = (straight[corner] | bool(chord_before)) & (straight[corner + 1] | bool(chord_after))
            with np.errstate(divide="ignore", invalid="ignore"):
                reach = tolerance / (PEAK[0] * measure_rows(bend * METRIC))
                reach = np.minimum(reach, np.where(overlaps, SEGMENTS, 0.5) * length)
                if chord_before and chord_after:
                    bend = _leave_common_bends(slope, corner, bend)
                jerk = smoothing.jerk_limit(path.end[corner], bend, path.tool_length[corner])
                speed = np.cbrt(jerk * reach**2 / THIRD[0])
                loss[:, chord_before, chord_after] = np.nan_to_num(1.0 - np.minimum(speed / feed, 1.0))
    arcs = ~straight[corner] & ~straight[corner + 1]
    loss[arcs, 0, 1] += MIXING
    loss[arcs, 1, 0] += MIXING
    return loss


def _leave_common_bends(slope: Array, corner: Ints, bend: Array) -> Array:
    """Bends (m, 5) without the mean of those beside: overlapping blends of even bends are an even curve."""
    every = np.zeros((len(slope) + 1, 5))
    every[1:-1] = slope[1:] - slope[:-1]
    rest = bend - 0.5 * (every[corner] + every[corner + 2])
    return np.where((measure_rows(rest) < measure_rows(bend))[:, None], rest, bend)


def find_cheapest_sequence(loss: Array, never_curved: Mask, never_straight: Mask) -> Mask:
    """Segments (n,) that are straight in the cheapest sequence, by the losses (n - 1, 2, 2) at the corners between.

    The second index of the losses tells whether the segment before is straight, the third whether the one after is.
    """
    barred = (_NEVER * never_straight - _NEVER * never_curved).tolist()
    # what it costs more so far if the segment is straight; whether the one before is, for both ways
    more, came = barred[0], []
    for (curved, to_straight, to_curved, both), bar in zip(loss.reshape(-1, 4).tolist(), barred[1:], strict=True):
        came.append((more + to_curved < curved, more + both < to_straight))
        more = min(to_straight, more + both) - min(curved, more + to_curved) + bar
    straight = [more < 0.0]
    for choice in reversed(came):
        straight.append(choice[straight[-1]])
    return np.array(straight[::-1])
