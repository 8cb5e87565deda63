"""Corner blends of some neighbouring segments, and the elements that follow."""

from typing import Any, Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import measure_rows
from verne_post.model.contour import Corners
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath import corners as blends
from verne_post.toolpath.compensation import limit_chain_reach
from verne_post.toolpath.corner_rules import CornerRules, Smoothing
from verne_post.toolpath.corner_shapes import OUTSIDE, shape_value
from verne_post.toolpath.curved_corners import blend_curved_corners
from verne_post.toolpath.deviations import find_bend_shares, narrow_blends
from verne_post.toolpath.elements import find_feeds, measure_rotation, split_into_elements
from verne_post.toolpath.spline_corners import put_curves
from verne_post.toolpath.straighten import Straightened

#: Places of blends where the travel of joints is checked, as shares of the reach: the swing has one lobe there.
_SWING_PLACES: Final = np.linspace(0.0, 1.0, 33)


class RoundedSegments(Struct, frozen=True):
    """Neighbouring segments (n,) with their corners (n + 1,) blended."""

    #: Columns of the elements of a Contour by name, but for the sections; segments are counted from 0.
    elements: dict[str, Any]
    #: reach, bend, shape (n + 1,), (n + 1, 5) and (n + 1,): As in :class:`~verne_post.model.contour.Corners`.
    reach: Array
    bend: Array
    shape: Ints
    stops: Mask  #: (n + 1,): The motion stops at the corner.
    #: curved, jump, curve, controls (m,), (m, 2, 5), (m,) and (k, 8, 5): As there; corners and curves are counted
    #: from 0.
    curved: Ints
    jump: Array
    curve: Ints
    controls: Array
    #: tip_tolerance, axis_tolerance (n,): How far the contour may be from each segment, mm and rad.
    tip_tolerance: Array
    axis_tolerance: Array

    def take_part(self, first: int, last: int) -> "RoundedSegments":
        """Segments ``first`` to ``last`` (excluded), counted from 0."""
        mine = slice(*np.searchsorted(self.elements["segment"], [first, last]))
        elements = {name: column[mine] for name, column in self.elements.items()}
        curved = slice(*np.searchsorted(self.curved, [first, last]))
        begin, end = (int((self.curve[:row] >= 0).sum()) for row in (curved.start, curved.stop))
        corners = slice(first, last + 1)
        return replace(
            self,
            elements=elements | {"segment": elements["segment"] - first},
            reach=self.reach[corners],
            bend=self.bend[corners],
            shape=self.shape[corners],
            stops=self.stops[corners],
            curved=self.curved[curved] - first,
            jump=self.jump[curved],
            curve=np.where(self.curve[curved] < 0, -1, self.curve[curved] - begin),
            controls=self.controls[begin:end],
            tip_tolerance=self.tip_tolerance[first:last],
            axis_tolerance=self.axis_tolerance[first:last],
        )


def _find_swung_out(path: ToolPath, slope: Array, bend: Array, kind: Ints, reach: Array, smoothing: Smoothing) -> Ints:
    """Corners whose wide shapes (n + 1,) swing beyond the travel of a joint.

    Where the programmed corner itself is beyond it, no shape helps. Where the corner moved by the whole swing keeps the
    travel, so does the blend; the others are checked all along.
    """
    wide = np.flatnonzero(kind)
    wide = wide[smoothing.keeps_travel(path.end[wide - 1], path.tool_length[wide - 1])]
    swing = bend[wide] * (reach[wide] * shape_value(kind[wide], OUTSIDE[kind[wide]]))[:, None]
    wide = wide[~smoothing.keeps_travel(path.end[wide - 1] + swing, path.tool_length[wide - 1])]
    places = np.tile(_SWING_PLACES, (len(wide), 1))
    value = shape_value(np.repeat(kind[wide], len(_SWING_PLACES)), places.ravel()).reshape(places.shape)
    moved = path.end[wide - 1, None] + bend[wide, None] * (reach[wide, None] * value)[..., None]
    kept = np.ones(len(wide), dtype=bool)
    for side, along in ((-1.0, slope[wide - 1]), (1.0, slope[wide])):
        poses = moved + (side * reach[wide, None] * places)[..., None] * along[:, None]
        tool = np.repeat(path.tool_length[wide - 1], len(_SWING_PLACES))
        kept &= smoothing.keeps_travel(poses.reshape(-1, 5), tool).reshape(places.shape).all(axis=1)
    return np.asarray(wide[~kept])


def round_corners(
    path: ToolPath, left: Straightened, shape: ToolPath, s: Array, chain: Mask, rules: CornerRules, smoothing: Smoothing
) -> RoundedSegments:
    """Blend the corners of some segments, whose vertices have been moved to those of ``shape``.

    Parameters
    ----------
    path, shape : ToolPath
        n segments as programmed, but for curves that are followed as straight segments, and as they are followed.
    left : Straightened
        How far the former are from the programmed curves.
    s : ndarray, shape (n + 1,)
        Metric length at the corners, mm.
    chain : ndarray of bool, shape (n + 1,)
        Vertices of compensated curves.
    """
    shift = np.zeros((len(s), 5))
    shift[1:-1] = shape.end[:-1] - path.end[:-1]
    alone = np.where(chain[:, None], 0.0, shift)
    tip_left, axis_left = (
        np.maximum(bound - measure_rows(moved), 0.0)
        for bound, moved in ((rules.tip_tolerance, alone[:, :3]), (rules.axis_tolerance, alone[:, 3:]))
    )
    slope = blends.find_slopes(shape.start, shape.end, shape.length)
    bend = blends.find_bends(slope)
    bend[~rules.straight] = 0.0
    blended = rules.allowed_corners & rules.straight & ~rules.smooth & ~blends.find_reversals(slope)
    share = np.where(blended, find_bend_shares(bend, slope, tip_left, axis_left), 0.0)
    feed = blends.find_smaller_beside(find_feeds(path).cap)
    kind = blends.choose_shapes(
        share,
        blends.find_smaller_beside(path.length) * (blends.ROOM_OVERLAPPING if smoothing.overlap else blends.ROOM_ALONE),
        feed,
        lambda corner: smoothing.jerk_limit(shape.end[corner - 1], bend[corner], shape.tool_length[corner - 1]),
        smoothing.cycle,
    )
    kind[_find_swung_out(shape, slope, bend, kind, blends.find_widest(kind, share), smoothing)] = 0
    wanted = np.where(blended, blends.find_widest(kind, share), 0.0)
    wanted = np.where(rules.curved_corners, np.inf, wanted)
    reach = blends.share_segments(wanted, path.length)
    most = reach[rules.curved_corners]
    if smoothing.overlap:
        walls = ~(blended | (rules.smooth & rules.straight))
        reach = blends.limit_overlap(np.where(blended, wanted, 0.0), s, walls, rules.curved_corners)
        kind[chain] = 0
        reach[chain] = limit_chain_reach(chain, blends.find_widest(kind, share), s)[chain]
        bounds = rules.tip_tolerance, rules.axis_tolerance
        reach = narrow_blends(Corners(s, reach, bend, kind), chain, slope, shift, left.chords, *bounds)
    reach = np.where(blended, reach, 0.0)
    curved = np.flatnonzero(rules.curved_corners)
    # corner blends that reach over a corner leave less to the curve after it
    most = np.minimum(most, blends.measure_gaps(reach, s)[curved])
    # blends of curved corners are measured from chords: shapes with lobes may add to what those are off
    sag = measure_rows(left.chords.sag)
    beside = np.maximum(sag[curved - 1], sag[curved])
    bounds = tip_left[curved] - beside, axis_left[curved]

    def find_allowed_jerk(corner: Ints, along: Array) -> Array:
        return smoothing.jerk_limit(path.start[corner], along, path.tool_length[corner - 1])

    blend = blend_curved_corners(
        path, curved, most, bounds, feed[curved], find_allowed_jerk, smoothing.cycle, smoothing.keeps_travel
    )
    reach[curved], curve, controls = put_curves(path, curved, most, bounds, blend, feed[curved], find_allowed_jerk)
    _reach, kind[curved], jump = blend
    bend[curved] = jump[:, 0]
    corners = Corners(s, reach, bend, kind, curved=curved, jump=jump[:, 1:], curve=curve, controls=controls)
    stops = ~rules.smooth & (reach <= 0)
    used = ~stops & ~rules.smooth
    used |= shift.any(axis=1)  # also where a corner has become a stop
    whole = rules.axis_tolerance.copy()
    whole[1:-1] += np.maximum(left.swing[1:], left.swing[:-1])
    tip, axis = (_spread_to_segments(np.where(used, bound, 0.0), reach, s) for bound in (rules.tip_tolerance, whole))
    elements = split_into_elements(path, corners)
    segment = elements["segment"]
    elements["rotation"] = measure_rotation(path)[segment] * (elements["high"] - elements["low"])
    begin, end = (s[segment] + elements[side] * path.length[segment] for side in ("low", "high"))
    elements["blended"] = blends.find_blended(corners, segment, begin, end)
    return RoundedSegments(
        elements,
        reach,
        bend,
        kind,
        stops,
        curved,
        jump[:, 1:],
        curve,
        controls,
        np.maximum(tip, sag / blends.USED_SHARE),
        np.maximum(axis, left.swing / blends.USED_SHARE),
    )


def _spread_to_segments(bound: Array, reach: Array, s: Array) -> Array:
    """Largest bound (n,) among the corners (n + 1,) at both ends of each segment, and those whose blends reach it."""
    n = len(s) - 1
    largest = np.maximum(bound[:-1], bound[1:])
    for shift in range(2, blends.SEGMENTS + 1):
        for side in (-1, 1):
            corner = np.arange(n) + (1 - shift if side < 0 else shift)
            inside = (corner >= 0) & (corner <= n)
            near = np.clip(corner, 0, n)
            away = (s[:-1] - s[near]) if side < 0 else (s[near] - s[1:])
            largest = np.where(inside & (away < reach[near]), np.maximum(largest, bound[near]), largest)
    return largest
