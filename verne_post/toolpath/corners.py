"""Corner blends of polylines: each adds a displacement to the path, and several may overlap.

With s the metric length along the path, the pose of a polyline is piecewise linear in s. Its second derivative is a sum of
peaks, one a corner: the change ``bend`` of the unit tangent. Averaging with a kernel of half width ``reach`` spreads the
peak. This is the same as adding

    bend reach G(x),   x = (s - s of the corner) / reach,   G(x) = integral of (x - v)+ k(v) dv - x+,

for |x| < 1 and nothing elsewhere. With k = 15/16 (1 - v^2)^2 the pose is three times continuously differentiable by s,
and the parameter s stays what it was along the polyline. Where the corner blends of a finely divided curve overlap, their
sum is that curve with its facets averaged out. Corners that would slow the tool down have other shapes G
(:mod:`verne_post.toolpath.corner_shapes`), which belong to no kernel and need more length.

What counts for the tolerance is the distance from the path, not from the corner: the part of a displacement that lies along
a segment only says that the nearest pose of the segment is another one (:func:`find_share_used`).
"""

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import row_norm, row_sum
from verne_post.base.tolerances import NO_REACH_MM
from verne_post.base.units import ROTARY_METRIC_MM
from verne_post.model.contour import Corners
from verne_post.toolpath.corner_shapes import (
    KNEE,
    OUTSIDE,
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
#: A wide shape needs so many times the shorter segment beside its corner, where blends may overlap and where they may not.
#: Measured from 0.5 to 2.0: the cycle time of zigzags and polygons of 5 to 60 degrees falls up to 1.7; at 1.8 those of 20 degrees
#: lose 8 %, at 2.0 finely divided waves up to 15 %.
ROOM_OVERLAPPING: Final = 1.7
ROOM_ALONE: Final = 0.5
#: Half of a wide shape lasts at least so many control cycles: motion profiles could not follow it in fewer.
LEAST_CYCLES: Final = 4.0
#: The share of the tolerance that is used; the rest is for the rounding of the written numbers.
USED_SHARE: Final = 0.97
#: Overlapping corner blends that leave the tolerance together are narrowed by no more than this at a time, and so often.
NARROWING: Final = 0.6
NARROWINGS: Final = 12
#: Where segments near wide shapes, and chords of arcs, are looked at besides their middle: lobes of two blends, or a blend and an
#: arc's height, add up anywhere.
_PLACES: Final = (0.1, 0.2, 0.3, 0.4, 0.6, 0.7, 0.8, 0.9)
#: The contour beside a segment depends on no more than so many segments on each side: on those that a corner blend reaches,
#: and on as many again in each round of narrowing.
NEIGHBOURS: Final = (NARROWINGS + 4) * (2 * SEGMENTS + 1)
#: mm of metric length of a unit of each coordinate of a pose.
METRIC: Final = np.array([1.0, 1.0, 1.0, ROTARY_METRIC_MM, ROTARY_METRIC_MM])
#: A corner that turns back this sharply (cosine of the angle between the tangents) is a stop: blending it would not be
#: faster, and the curve would all but come back on itself.
REVERSAL: Final = -0.9


class Chords(Struct, frozen=True):
    """How far n straight segments are from the arcs for which they stand.

    Attributes
    ----------
    sag : ndarray, shape (n, 3)
        From the middle of the arc to that of its chord, mm; 0 for segments that stand for none.
    cosine : ndarray, shape (n,)
        Of half the angle of the arc, which is below pi; 1 for segments that stand for none.
    """

    sag: Array
    cosine: Array

    def take(self, segment: Ints | slice) -> "Chords":
        """Those of some segments."""
        return Chords(self.sag[segment], self.cosine[segment])

    def height(self, part: Array) -> Array:
        """From the arcs to the segments (n, 3), mm, at shares ``part`` (n,) of their chords."""
        from_middle = (2.0 * part - 1.0) ** 2
        root = np.sqrt(1.0 - (1.0 - self.cosine**2) * from_middle)
        share = (1.0 - from_middle) * (1.0 + self.cosine) / (root + self.cosine)
        return np.asarray(share[:, None] * self.sag)


def find_slopes(start: Array, end: Array, length: Array) -> Array:
    """Derivatives (n, 5) of tip and nominal angles by s along straight segments."""
    return np.asarray((end - start) / length[:, None])


def find_bends(slope: Array) -> Array:
    """Change (n + 1, 5) of the derivative at the corners of n segments; 0 at the ends of the path."""
    bend = np.zeros((len(slope) + 1, 5))
    bend[1:-1] = slope[1:] - slope[:-1]
    return bend


def smaller_beside(value: Array) -> Array:
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


def find_share_used(
    off: Array,
    slope: Array,
    ends: tuple[Array, Array],
    tip_tolerance: Array,
    axis_tolerance: Array,
    chords: Chords | None = None,
) -> Array:
    """What displacements use of the tolerance (n,): 1 where all of it, 0 where there is neither displacement nor tolerance.

    A displaced pose is near the pose with its s; where the table stands still, near the pose whose tip is nearest. The
    programmed pose itself must stay near either: it stays within root 2 of both tolerances together, which cuts the
    tips of corners of more than 90 degrees less than they would allow.

    Parameters
    ----------
    off : ndarray, shape (n, 5)
        Displacement of poses on a straight segment, mm and rad.
    slope : ndarray, shape (n, 5)
        Derivative of the segment by s.
    ends : tuple of ndarray, shape (n,)
        From the poses to both ends of their segment, mm: the nearest pose lies between.
    tip_tolerance, axis_tolerance : ndarray, shape (n,)
        mm and rad.
    chords : Chords, optional
        How far the segments are from what was programmed.
    """
    square = np.where(slope[:, 3:].any(axis=1), 0.0, row_sum(slope[:, :3] ** 2))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        along = np.where(square > 0, row_sum(off[:, :3] * slope[:, :3]) / square, 0.0).clip(*ends)
        same, nearest = (
            (
                row_norm(away[:, :3] + _find_heights(chords, ends, by)) / tip_tolerance,
                row_norm(away[:, 3:]) / axis_tolerance,
            )
            for by, away in ((0.0, off), (along, off - along[:, None] * slope))
        )
        used = np.fmax(np.fmin(np.fmax(*same), np.fmax(*nearest)), np.hypot(*np.nan_to_num(same)) / np.sqrt(2.0))
    return np.where(np.isfinite(used), used, 0.0)


def _find_heights(chords: Chords | None, ends: tuple[Array, Array], along: Array | float) -> Array | float:
    """From arcs to their chords (n, 3), mm, ``along`` (n,) mm beyond poses that are ``ends`` from the ends."""
    return 0.0 if chords is None else chords.height((along - ends[0]) / (ends[1] - ends[0]))


def find_bend_shares(bend: Array, slope: Array, tip_tolerance: Array, axis_tolerance: Array) -> Array:
    """Share of the tolerance (n + 1,) that a displacement by ``bend`` times 1 mm uses, of the worse of both segments."""
    zero, far = np.zeros(len(bend)), np.full(len(bend), np.inf)
    before = find_share_used(bend, np.concatenate([slope[:1], slope]), (-far, zero), tip_tolerance, axis_tolerance)
    after = find_share_used(bend, np.concatenate([slope, slope[-1:]]), (zero, far), tip_tolerance, axis_tolerance)
    return np.maximum(before, after)


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


def find_deviations(
    corners: Corners, slope: Array, shift: Array, chords: Chords, tip_tolerance: Array, axis_tolerance: Array
) -> Array:
    """The largest share of the tolerance (n + 1,) that the contour uses anywhere where the blend of a corner reaches.

    Looked at are corners and the middle of segments; near wide shapes and on chords of arcs also places in between, and where each
    wide shape swings out.

    Parameters
    ----------
    corners : Corners
    slope : ndarray, shape (n, 5)
        Derivative of the segments by s.
    shift : ndarray, shape (n + 1, 5)
        How far vertices have been moved before.
    chords : Chords
        How far the segments are from what was programmed.
    tip_tolerance, axis_tolerance : ndarray, shape (n + 1,)
        The tolerance of a point between two corners is the smaller of theirs.
    """
    s, reach = corners.s, corners.reach
    n = len(s) - 1
    wide = np.flatnonzero((corners.shape > 0) & (reach > 0))
    near_wide = np.zeros(n + 2 * SEGMENTS, dtype=bool)
    for step in range(2 * SEGMENTS):
        near_wide[wide + step] = True
    bent = chords.sag.any(axis=1)
    looked = np.flatnonzero(near_wide[SEGMENTS:-SEGMENTS] | bent)
    between = np.concatenate([np.arange(n), np.repeat(looked, len(_PLACES))])
    share = np.concatenate([np.full(n, 0.5), np.tile(_PLACES, len(looked))])
    outside = OUTSIDE[corners.shape[wide]] * reach[wide]
    swings = np.concatenate([s[wide] - outside, s[wide] + outside])
    on = np.clip(np.searchsorted(s, swings, side="right") - 1, 0, n - 1)
    inner = np.concatenate([between, on])
    inner_at = np.concatenate([s[between] + share * (s[between + 1] - s[between]), swings])
    every = np.arange(n + 1)
    largest = np.zeros(n + 1)
    at_corners = displacement(corners, np.minimum(every, n - 1), s)
    for at, off, owner, low, high in (
        (s, at_corners, np.append(0, every[:-1]), every, every),
        (s, at_corners, np.append(every[:-1], n - 1), every, every),
        (inner_at, displacement(corners, inner, inner_at), inner, inner, inner + 1),
    ):
        ends = s[owner] - at, s[owner + 1] - at
        part = (-ends[0] / (ends[1] - ends[0]))[:, None]
        away = off + shift[owner] + part * (shift[owner + 1] - shift[owner])
        tip, axis = (np.minimum(bound[low], bound[high]) for bound in (tip_tolerance, axis_tolerance))
        used = find_share_used(away, slope[owner], ends, tip, axis, chords.take(owner) if bent.any() else None)
        for step in range(-SEGMENTS, SEGMENTS + 2):
            near = np.clip(owner + step, 0, n)
            covers = np.abs(at - s[near]) < reach[near]
            np.maximum.at(largest, near[covers], used[covers])
    return largest


def narrow_blends(
    corners: Corners,
    kept: Mask,
    slope: Array,
    shift: Array,
    chords: Chords,
    tip_tolerance: Array,
    axis_tolerance: Array,
) -> Array:
    """Reaches (n + 1,) of overlapping corner blends, narrowed until their sum stays within the tolerance.

    Parameters are those of :func:`find_deviations`; the reaches of corners ``kept`` (n + 1,) stay as they are.
    """
    reach = corners.reach.copy()
    for _ in range(NARROWINGS):
        corners = replace(corners, reach=reach)
        worst = find_deviations(corners, slope, shift, chords, tip_tolerance, axis_tolerance) / USED_SHARE
        beyond = (worst > 1.0) & ~kept
        if not beyond.any():
            return reach
        reach[beyond] *= np.maximum(1.0 / worst[beyond], NARROWING)
    return reach


def displacement(corners: Corners, segment: Ints, at: Array) -> Array:
    """Displacement (m, 5) of the pose by all corner blends at path parameters ``at`` (m,) on segments (m,), mm and rad."""
    total = np.zeros((len(at), 5))
    for corner, width, x in _find_near(corners, segment, at):
        bend = corners.bend.take(corner, axis=0, mode="clip")
        bend *= (width * shape_value(corners.shape.take(corner, mode="clip"), x))[:, None]
        total += bend
    for points, row, width, x in _find_curved(corners, segment, at):
        jump, shape = corners.jump[row], corners.shape[corners.curved[row]]
        odd, even = jump_values(shape, x)
        total[points] += (width**2 * odd)[:, None] * jump[:, 0] + (width**3 * even)[:, None] * jump[:, 1]
    return total


def displacement_slope(corners: Corners, segment: Ints, at: Array) -> Array:
    """Derivative of :func:`displacement` by s."""
    total = np.zeros((len(at), 5))
    for corner, _width, x in _find_near(corners, segment, at):
        bend = corners.bend.take(corner, axis=0, mode="clip")
        bend *= shape_slope(corners.shape.take(corner, mode="clip"), x)[:, None]
        total += bend
    for points, row, width, x in _find_curved(corners, segment, at):
        jump, shape = corners.jump[row], corners.shape[corners.curved[row]]
        odd, even = jump_slopes(shape, x)
        total[points] += (width * odd)[:, None] * jump[:, 0] + (width**2 * even)[:, None] * jump[:, 1]
    return total


def _find_near(corners: Corners, segment: Ints, at: Array) -> Iterator[tuple[Ints, Array, Array]]:
    """Corners whose blends may reach points ``at`` of segments: index, reach, and x of the points on each.

    An index beyond the path means the corner at its end, where ``bend`` is 0.
    """
    for shift in range(1 - SEGMENTS, SEGMENTS + 1):
        corner = segment + shift
        width = np.maximum(corners.reach.take(corner, mode="clip"), NO_REACH_MM)
        yield corner, width, (at - corners.s.take(corner, mode="clip")) / width


def find_replaced(corners: Corners, segment: Ints, at: Array) -> Iterator[tuple[Ints, Array, Array, Array]]:
    """Points at ``at`` (m,) of segments (m,) that lie on curves: places among them, control points, parameters and reaches."""
    if len(corners.controls):
        for points, row, width, x in _find_curved(corners, segment, at):
            on = np.flatnonzero((corners.curve[row] >= 0) & (np.abs(x) <= 1.0))
            yield points[on], corners.controls[corners.curve[row[on]]], 0.5 * (1.0 + x[on]), width[on]


def _find_curved(corners: Corners, segment: Ints, at: Array) -> Iterator[tuple[Ints, Ints, Array, Array]]:
    """Points beside curved corners, which no other blend reaches over: places among (m,), rows of these corners, reaches, and x."""
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
    blended = np.zeros(len(segment), dtype=bool)
    for shift in range(1 - SEGMENTS, SEGMENTS + 1):
        width, middle = (column.take(segment + shift, mode="clip") for column in (corners.reach, corners.s))
        blended |= (middle - width < high) & (middle + width > low) & (width > 0)
    return blended


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
