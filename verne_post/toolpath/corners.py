"""Corner blends of polylines: each adds a displacement to the path, and several may overlap.

With s the metric length along the path, the pose of a polyline is piecewise linear in s. Its second derivative is a sum
of peaks, one at each corner: the change ``bend`` of the unit tangent. Averaging with a kernel of half width ``reach``
spreads the peak. This is the same as adding

    bend reach G(x),   x = (s - s of the corner) / reach,   G(x) = integral of (x - v)+ k(v) dv - x+,

for |x| < 1 and nothing elsewhere. With k = 15/16 (1 - v^2)^2 the pose is three times continuously differentiable by s,
and the parameter s stays the same as along the polyline. Where the corner blends of a finely divided curve overlap,
their sum is that curve with its facets averaged out. Corners that would slow the tool down have other shapes G
(:mod:`verne_post.toolpath.corner_shapes`), which belong to no kernel and need more length.
"""

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.tolerances import NO_REACH_MM
from verne_post.base.units import ROTARY_METRIC_MM
from verne_post.model.contour import Corners
from verne_post.toolpath.corner_shapes import (
    KNEE,
    PEAK,
    SHAPES,
    THIRD,
    jump_slopes,
    jump_values,
    shape_slope,
    shape_value,
)

#: A corner blend reaches over at most so many segments on each side; evaluation looks at twice as many corners.
SEGMENTS: Final = 2
#: The corners whose blends may reach onto a segment, from the one at its beginning on.
_NEAR: Final = np.arange(1 - SEGMENTS, SEGMENTS + 1)[:, None]
#: A wide shape needs so many times the shorter segment beside its corner, where blends may overlap and where they may
#: not. Measured from 0.5 to 2.0: the cycle time of zigzags and polygons of 5 to 60 degrees falls up to 1.7; at 1.8
#: those of 20 degrees lose 8 %, at 2.0 finely divided waves up to 15 %.
ROOM_OVERLAPPING: Final = 1.7
ROOM_ALONE: Final = 0.5
#: Half of a wide shape lasts at least so many control cycles: motion profiles could not follow it in fewer.
LEAST_CYCLES: Final = 4.0
#: The share of the tolerance that is used; the rest is for the rounding of the written numbers.
USED_SHARE: Final = 0.97
#: mm of metric length of a unit of each coordinate of a pose.
METRIC: Final = np.array([1.0, 1.0, 1.0, ROTARY_METRIC_MM, ROTARY_METRIC_MM])
#: A corner that turns back this sharply (cosine of the angle between the tangents, 172 degrees) is a stop. Single
#: corners of 150 to 173 degrees take 0.978 of the time of a stop with -0.9, 0.894 with -0.99, and 0.887 with -0.995,
#: where one of 400 random programs is slower by 12 %.
REVERSAL: Final = -0.99


def find_slopes(start: Array, end: Array, length: Array) -> Array:
    """Derivatives (n, 5) of tip and nominal angles by s along straight segments."""
    return np.asarray((end - start) / length[:, None])


def find_bends(slope: Array) -> Array:
    """Change (n + 1, 5) of the derivative at the corners of n segments; 0 at the ends of the path."""
    bend = np.zeros((len(slope) + 1, 5))
    bend[1:-1] = slope[1:] - slope[:-1]
    return bend


def find_smaller_beside(value: Array) -> Array:
    """The smaller value (n + 1,) of both segments (n,) at each corner."""
    padded = np.concatenate([value[:1], value, value[-1:]])
    return np.minimum(padded[1:], padded[:-1])


def find_reversals(slope: Array) -> Mask:
    """Find corners (n + 1,) that turn back too sharply to be blended."""
    metric = slope * METRIC
    with np.errstate(invalid="ignore"):  # a full circle has no chord, and no corner of straight segments
        unit = metric / np.linalg.norm(metric, axis=1, keepdims=True)
    reversal = np.zeros(len(slope) + 1, dtype=bool)
    reversal[1:-1] = np.sum(unit[1:] * unit[:-1], axis=1) < REVERSAL
    return reversal


def choose_shapes(
    bend_share: Array, longest: Array, feed: Array, jerk_limit: Callable[[Ints], Array], cycle: float
) -> Ints:
    """The shape (n + 1,) of each corner: the narrowest that is passed at the feed rate, else the widest that fits.

    Parameters
    ----------
    bend_share : ndarray, shape (n + 1,)
        As of :func:`find_bend_shares`; 0 where a corner is not blended.
    longest : ndarray, shape (n + 1,)
        What the reach may be, mm.
    feed : ndarray, shape (n + 1,)
        ds/dt at the programmed feed rate, mm/s.
    jerk_limit : callable
        Largest third derivative by time (m,) that the joints allow a displacement along the bends of corners (m,).
    cycle : float
        Control cycle, s.
    """
    shape = np.zeros(len(bend_share), dtype=np.int8)
    bent = np.flatnonzero(bend_share * longest >= USED_SHARE / PEAK[1])  # no wide shape fits the others
    if not len(bent):
        return shape
    reach = (USED_SHARE / PEAK) / bend_share[bent, None]
    # the third derivative by time of reach G(s / reach), at constant speed v, is the third of G times v^3 / reach^2
    speed = np.cbrt(jerk_limit(bent)[:, None] * reach**2 / THIRD)
    passed = speed >= feed[bent, None]
    fits = (reach <= longest[bent, None]) & (reach >= LEAST_CYCLES * cycle * np.minimum(speed, feed[bent, None]))
    fits[:, 0] = True
    fast = passed & fits
    widest = SHAPES - 1 - fits[:, ::-1].argmax(axis=1)
    shape[bent] = np.where(fast.any(axis=1), fast.argmax(axis=1), widest)
    return shape


def find_widest(shape: Ints, bend_share: Array) -> Array:
    """Largest reach (n + 1,) of single corner blends inside their tolerances, mm; infinite without a corner."""
    with np.errstate(divide="ignore"):
        return np.asarray(USED_SHARE / (PEAK[shape] * bend_share))


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


def find_displacement(corners: Corners, segment: Ints, at: Array) -> Array:
    """Displacement (m, 5) of poses by all corner blends, mm and rad, at parameters ``at`` (m,) on segments (m,)."""
    near, width, x = _find_near(corners, segment, at)
    total = _sum_bends(corners, near, width * shape_value(corners.shape.take(near, mode="clip"), x))
    for points, row, width, x in _find_curved(corners, segment, at):
        jump, shape = corners.jump[row], corners.shape[corners.curved[row]]
        odd, even = jump_values(shape, x)
        total[points] += (width**2 * odd)[:, None] * jump[:, 0] + (width**3 * even)[:, None] * jump[:, 1]
    return total


def differentiate_displacement(corners: Corners, segment: Ints, at: Array) -> Array:
    """Derivative of :func:`displacement` by s."""
    near, _width, x = _find_near(corners, segment, at)
    total = _sum_bends(corners, near, shape_slope(corners.shape.take(near, mode="clip"), x))
    for points, row, width, x in _find_curved(corners, segment, at):
        jump, shape = corners.jump[row], corners.shape[corners.curved[row]]
        odd, even = jump_slopes(shape, x)
        total[points] += (width * odd)[:, None] * jump[:, 0] + (width**2 * even)[:, None] * jump[:, 1]
    return total


def _find_near(corners: Corners, segment: Ints, at: Array) -> tuple[Ints, Array, Array]:
    """Corners (k, m) whose blends may reach points ``at`` (m,) of segments (m,), their reaches, and x of the points.

    An index beyond the path means the corner at its end, where ``bend`` is 0.
    """
    near = segment + _NEAR
    width = np.maximum(corners.reach.take(near, mode="clip"), NO_REACH_MM)
    return near, width, (at - corners.s.take(near, mode="clip")) / width


def _sum_bends(corners: Corners, near: Ints, factor: Array) -> Array:
    """Sum (m, 5) of the bends of corners (k, m), each times a factor."""
    return np.einsum("km,kmj->mj", factor, corners.bend.take(near, axis=0, mode="clip"))


def find_replaced(corners: Corners, segment: Ints, at: Array) -> Iterator[tuple[Ints, Array, Array, Array]]:
    """For points at ``at`` (m,) of segments (m,) on curves: places, control points, parameters and reaches."""
    if len(corners.controls):
        for points, row, width, x in _find_curved(corners, segment, at):
            on = np.flatnonzero((corners.curve[row] >= 0) & (np.abs(x) <= 1.0))
            yield points[on], corners.controls[corners.curve[row[on]]], 0.5 * (1.0 + x[on]), width[on]


def _find_curved(corners: Corners, segment: Ints, at: Array) -> Iterator[tuple[Ints, Ints, Array, Array]]:
    """For points beside curved corners, which have only one blend: places among (m,), corner rows, reaches, and x."""
    if not len(corners.curved) or not len(segment):
        return
    first, last = np.searchsorted(corners.curved, [segment.min(), segment.max() + 2])
    if first == last:
        return
    for corner in (segment, segment + 1):
        row = first + np.minimum(np.searchsorted(corners.curved[first:last], corner), last - first - 1)
        points = np.flatnonzero(corners.curved[row] == corner)
        near = corner[points]
        width = np.maximum(corners.reach[near], NO_REACH_MM)
        yield points, row[points], width, (at[points] - corners.s[near]) / width


def find_blended(corners: Corners, segment: Ints, low: Array, high: Array) -> Mask:
    """Find where a corner blend reaches between ``low`` and ``high`` (m,), by s, on segments (m,)."""
    width, middle = (column.take(segment + _NEAR, mode="clip") for column in (corners.reach, corners.s))
    return np.asarray(((middle - width < high) & (middle + width > low) & (width > 0)).any(axis=0))


def find_breakpoints(corners: Corners) -> tuple[Ints, Array, Array]:
    """Find where corner blends begin and end, and where their polynomials meet.

    Returns the segment of each such point, its s, and the reach of its blend.
    """
    s, reach = corners.s, corners.reach
    corner = np.flatnonzero(reach > 0)
    wide = corner[corners.shape[corner] > 0]
    owner = np.concatenate([corner, corner, wide, wide])
    at = s[owner] + reach[owner] * np.repeat([-1.0, 1.0, -KNEE, KNEE], [len(corner)] * 2 + [len(wide)] * 2)
    inside = (at > s[0]) & (at < s[-1])
    at, width = at[inside], reach[owner[inside]]
    segment = np.clip(np.searchsorted(s, at, side="right") - 1, 0, len(s) - 2)
    return segment, at, width
