"""Which short arcs are followed as their chords: where that is predicted to cost less speed at the corners.

A corner beside an arc is blended over half a segment at most; corners of chords over two segments on each side. But chords make
corners where tangent arcs have none, and between a chord and an arc there is one as well. So every corner has four predicted losses
of speed, for each of its segments as a curve or as a straight segment, and the cheapest sequence is found by dynamic programming
(Viterbi). Lines are straight in any case, and arcs too high for their chords are curves.
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import row_norm
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.toolpath.corner_rules import Smoothing
from verne_post.toolpath.corner_shapes import PEAK, THIRD
from verne_post.toolpath.corners import METRIC, SEGMENTS, find_slopes, smaller_beside
from verne_post.toolpath.curved_corners import find_derivatives
from verne_post.toolpath.elements import find_feeds

#: What a corner between a chord and an arc costs besides, as a share of the feed rate. Braking for one slow corner takes longer than
#: passing it. Of 400 random programs 16 take over 1 % longer than with arcs alone at 0, 8 at 0.1, 2 from 0.3 to 1.
MIXING: Final = 0.3
#: The choice depends on so many segments on each side, or on fewer.
OVERLAP: Final = 64
#: What a way of following a segment costs that it cannot have: more than all corners that the choice depends on.
_NEVER: Final = 1e6


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
    feed = smaller_beside(find_feeds(path).cap)[corner + 1]
    loss = np.empty((len(corner), 2, 2))
    for chord_before in (0, 1):
        for chord_after in (0, 1):
            bend = after[chord_after] - before[chord_before]
            overlaps = (straight[corner] | bool(chord_before)) & (straight[corner + 1] | bool(chord_after))
            with np.errstate(divide="ignore", invalid="ignore"):
                reach = tolerance / (PEAK[0] * row_norm(bend * METRIC))
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
    """What is left of bends (m, 5) without that of the corners beside: overlapping blends of even bends are an even curve."""
    every = np.zeros((len(slope) + 1, 5))
    every[1:-1] = slope[1:] - slope[:-1]
    rest = bend - 0.5 * (every[corner] + every[corner + 2])
    return np.where((row_norm(rest) < row_norm(bend))[:, None], rest, bend)


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
