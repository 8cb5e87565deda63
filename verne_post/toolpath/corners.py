"""Corner blends of polylines: each adds a displacement to the path, and several may overlap.

With s the metric length along the path, the pose of a polyline is piecewise linear in s. Its second derivative is a sum of
peaks, one a corner: the change ``bend`` of the unit tangent. Averaging with a kernel of half width ``reach`` spreads the
peak. This is the same as adding

    bend reach G(x),   x = (s - s of the corner) / reach,   G(x) = integral of (x - v)+ k(v) dv - x+,

for |x| < 1 and nothing elsewhere. With k = 15/16 (1 - v^2)^2 the pose is three times continuously differentiable by s,
the corner is passed at a distance of ``APEX |bend| reach``, and the parameter s stays what it was along the polyline.
Where the corner blends of a finely divided curve overlap, their sum is that curve with its facets averaged out.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import row_norm
from verne_post.base.tolerances import NO_REACH_MM
from verne_post.base.units import ROTARY_METRIC_MM
from verne_post.model.contour import Corners

#: G(0): distance from the corner over |bend| reach.
APEX: Final = 5.0 / 32.0
#: A corner blend reaches over at most so many segments on each side; evaluation looks at twice as many corners.
SEGMENTS: Final = 2
#: The share of the tolerance that is used; the rest is for the rounding of the written numbers.
USED_SHARE: Final = 0.97
#: Overlapping corner blends that leave the tolerance together are narrowed by no more than this at a time, and so often.
NARROWING: Final = 0.6
NARROWINGS: Final = 12
#: The contour beside a segment depends on no more than so many segments on each side: on those that a corner blend reaches,
#: and on as many again in each round of narrowing.
NEIGHBOURS: Final = (NARROWINGS + 4) * (2 * SEGMENTS + 1)
#: A corner that turns back this sharply (cosine of the angle between the tangents) is a stop: blending it would not be
#: faster, and the curve would all but come back on itself.
REVERSAL: Final = -0.9


def blend_shape(x: Array) -> Array:
    """G at x, zero outside (-1, 1)."""
    y = np.minimum(np.abs(x), 1.0)
    z = y * y
    return np.asarray(15.0 / 16.0 * (((z / 30 - 1.0 / 6) * z + 0.5) * z + 1.0 / 6) - 0.5 * y)


def blend_shape_slope(x: Array) -> Array:
    """Derivative of G by x, the mean of both sides at 0."""
    y = np.clip(x, -1.0, 1.0)
    z = y * y
    return np.asarray(15.0 / 16.0 * (((z / 5 - 2.0 / 3) * z + 1.0) * y) - 0.5 * np.sign(y))


def find_slopes(start: Array, end: Array, length: Array) -> Array:
    """Derivatives (n, 5) of tip and nominal angles by s along straight segments."""
    return np.asarray((end - start) / length[:, None])


def find_bends(slope: Array) -> Array:
    """Change (n + 1, 5) of the derivative at the corners of n segments; 0 at the ends of the path."""
    bend = np.zeros((len(slope) + 1, 5))
    bend[1:-1] = slope[1:] - slope[:-1]
    return bend


def find_reversals(slope: Array) -> Mask:
    """Find corners (n + 1,) that turn back too sharply to be blended."""
    metric = slope * np.array([1.0, 1.0, 1.0, ROTARY_METRIC_MM, ROTARY_METRIC_MM])
    with np.errstate(invalid="ignore"):  # a full circle has no chord, and no corner of straight segments
        unit = metric / np.linalg.norm(metric, axis=1, keepdims=True)
    reversal = np.zeros(len(slope) + 1, dtype=bool)
    reversal[1:-1] = np.sum(unit[1:] * unit[:-1], axis=1) < REVERSAL
    return reversal


def find_widest(bend: Array, tip_tolerance: Array, axis_tolerance: Array) -> Array:
    """Largest reach (n,) of single corner blends inside their tolerances (mm, rad); infinite without a corner."""
    tip, angle = row_norm(bend[:, :3]), row_norm(bend[:, 3:])
    with np.errstate(divide="ignore", invalid="ignore"):
        by_tip = np.where(tip > 0, USED_SHARE * tip_tolerance / (APEX * tip), np.inf)
        by_axis = np.where(angle > 0, USED_SHARE * axis_tolerance / (APEX * angle), np.inf)
    return np.minimum(by_tip, by_axis)


def share_segments(wanted: Array, length: Array) -> Array:
    """Reaches (n + 1,) that do not overlap: half of a segment for each of its corners, more where the other needs less.

    Parameters
    ----------
    wanted : ndarray, shape (n + 1,)
        0 at corners that are not blended.
    length : ndarray, shape (n,)
    """
    half = 0.5 * length
    at_end = np.maximum(half, length - wanted[:-1])  # what a segment leaves to the corner at its end
    at_start = np.maximum(half, length - wanted[1:])
    reach = wanted.copy()
    reach[1:] = np.minimum(reach[1:], at_end)
    reach[:-1] = np.minimum(reach[:-1], at_start)
    return reach


def limit_overlap(wanted: Array, s: Array, wall: Mask, tight: Mask) -> Array:
    """Reaches (n + 1,) over at most ``SEGMENTS`` segments on each side, and never over a wall.

    Parameters
    ----------
    wanted : ndarray, shape (n + 1,)
    s : ndarray, shape (n + 1,)
        Where the corners are.
    wall : ndarray of bool, shape (n + 1,)
        Corners that no blend may reach over.
    tight : ndarray of bool, shape (n + 1,)
        Walls that need half of the segments beside them for themselves.
    """
    n = len(s) - 1
    index = np.arange(n + 1)
    length = np.diff(s)
    left = np.maximum.accumulate(np.where(wall, index, 0))
    right = np.minimum.accumulate(np.where(wall, index, n)[::-1])[::-1]
    low, high = np.maximum(left, index - SEGMENTS), np.minimum(right, index + SEGMENTS)
    reach_left, reach_right = s - s[low], s[high] - s
    padded = np.append(length, 0.0)
    reach_left = reach_left - np.where(tight[low] & (low < index), 0.5 * padded[low], 0.0)
    reach_right = reach_right - np.where(tight[high] & (high > index), 0.5 * padded[np.maximum(high - 1, 0)], 0.0)
    return np.where(wall, 0.0, np.minimum(wanted, np.minimum(reach_left, reach_right)))


def measure_gaps(reach: Array, s: Array) -> Array:
    """Distance (n + 1,) from each corner to the nearest blend of another corner within ``SEGMENTS`` segments, mm."""
    gap = np.full(len(s), np.inf)
    for shift in range(1, min(SEGMENTS, len(s) - 1) + 1):
        apart = s[shift:] - s[:-shift]
        gap[:-shift] = np.minimum(gap[:-shift], apart - reach[shift:])
        gap[shift:] = np.minimum(gap[shift:], apart - reach[:-shift])
    return gap


def spread_largest(moved: Array) -> Array:
    """For all corners (n + 1,) the largest of the values (n - 1,) of inner corners that a corner blend can reach."""
    padded = np.pad(moved, SEGMENTS + 1)
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, 2 * SEGMENTS + 1).max(axis=1))


def narrow_blends(reach: Array, bend: Array, s: Array, tip_tolerance: Array, axis_tolerance: Array) -> Array:
    """Narrow overlapping corner blends until their sum stays within the tolerance at corners and in the middle of segments.

    Parameters
    ----------
    reach, tip_tolerance, axis_tolerance, s : ndarray, shape (n + 1,)
        The tolerance of a point between two corners is the smaller of theirs.
    bend : ndarray, shape (n + 1, 5)
    """
    reach = reach.copy()
    n = len(s) - 1
    for _ in range(NARROWINGS):
        worst = np.zeros(n + 1)
        for at, owner in ((s, np.arange(n + 1)), (0.5 * (s[1:] + s[:-1]), np.arange(n))):
            off = displacement(Corners(s, reach, bend), owner, at)
            tip_bound, axis_bound = (
                np.minimum(bound[owner], bound[np.minimum(owner + (len(at) == n), n)])
                for bound in (tip_tolerance, axis_tolerance)
            )
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio = np.maximum(row_norm(off[:, :3]) / tip_bound, row_norm(off[:, 3:]) / axis_bound)
            ratio = np.where(np.isfinite(ratio), ratio / USED_SHARE, 0.0)
            for shift in range(-SEGMENTS, SEGMENTS + 2):
                near = np.clip(owner + shift, 0, n)
                covers = np.abs(at - s[near]) < reach[near]
                np.maximum.at(worst, near[covers], ratio[covers])
        beyond = worst > 1.0
        if not beyond.any():
            return reach
        reach[beyond] *= np.maximum(1.0 / worst[beyond], NARROWING)
    return reach


def displacement(corners: Corners, segment: Ints, at: Array) -> Array:
    """Displacement (m, 5) of the pose by all corner blends at path parameters ``at`` (m,) on segments (m,), mm and rad."""
    total = np.zeros((len(at), 5))
    for corner, width, x in _find_near(corners, segment, at):
        bend = corners.bend.take(corner, axis=0, mode="clip")
        bend *= (width * blend_shape(x))[:, None]
        total += bend
    return total


def displacement_slope(corners: Corners, segment: Ints, at: Array) -> Array:
    """Derivative of :func:`displacement` by s."""
    total = np.zeros((len(at), 5))
    for corner, _width, x in _find_near(corners, segment, at):
        bend = corners.bend.take(corner, axis=0, mode="clip")
        bend *= blend_shape_slope(x)[:, None]
        total += bend
    return total


def _find_near(corners: Corners, segment: Ints, at: Array) -> Iterator[tuple[Ints, Array, Array]]:
    """Corners whose blends may reach points ``at`` of segments: index, reach, and x of the points on each.

    An index beyond the path means the corner at its end, where ``bend`` is 0.
    """
    for shift in range(1 - SEGMENTS, SEGMENTS + 1):
        corner = segment + shift
        width = np.maximum(corners.reach.take(corner, mode="clip"), NO_REACH_MM)
        yield corner, width, (at - corners.s.take(corner, mode="clip")) / width


def find_blended(corners: Corners, segment: Ints, low: Array, high: Array) -> Mask:
    """Find where a corner blend reaches between ``low`` and ``high`` (m,), by s, on segments (m,)."""
    blended = np.zeros(len(segment), dtype=bool)
    for shift in range(1 - SEGMENTS, SEGMENTS + 1):
        width, middle = (column.take(segment + shift, mode="clip") for column in (corners.reach, corners.s))
        blended |= (middle - width < high) & (middle + width > low) & (width > 0)
    return blended


def find_breakpoints(reach: Array, s: Array) -> tuple[Ints, Array, Array]:
    """Find where corner blends begin and end: the segment of each such point, its s, and the reach of its blend."""
    n = len(s) - 1
    corner = np.flatnonzero(reach > 0)
    at, width = np.concatenate([s[corner] - reach[corner], s[corner] + reach[corner]]), np.tile(reach[corner], 2)
    inside = (at > s[0]) & (at < s[-1])
    at, width = at[inside], width[inside]
    segment = np.clip(np.searchsorted(s, at, side="right") - 1, 0, n - 1)
    return segment, at, width
