"""How far poses are from the segments that they belong to, and how far they may be."""

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.verification.programmed import RADIAN_MM
from verne_post.verification.projection import Measured, measure_deviation_nearby, measure_off_segment
from verne_post.verification.reference import Reference


class Deviation(Struct, frozen=True, eq=False):
    """Distances of n poses from their segments, and what is allowed; (n,) each."""

    #: tip, tip_bound: mm.
    tip: Array
    #: axis, rotary, angle_bound: Of the tool axis and of the rotary angle, rad; the bound of both.
    axis: Array
    rotary: Array
    tip_bound: Array
    angle_bound: Array

    @property
    def within(self) -> Mask:
        """True (n,) where nothing is farther than allowed."""
        return np.asarray(
            (self.tip <= self.tip_bound) & (self.axis <= self.angle_bound) & (self.rotary <= self.angle_bound)
        )


def measure_deviation(reference: Reference, segment: Ints, u: Array, pose: Measured) -> Deviation:
    """Measure how far poses (n,) are from one pose of their segments near ``u``."""
    path, measures = reference.path, reference.measures
    found = Deviation(*measure_off_segment(path, segment, np.clip(u, 0.0, 1.0), pose), *reference.find_bounds(segment))
    # a projection weighs tip against angles; where both may be off, another pose of the segment may be nearer
    doubtful = np.flatnonzero((measures.has_tolerance[segment] | (path.circle[segment] >= 0)) & ~found.within)
    if len(doubtful):
        on, tip_allowed, angle_allowed = segment[doubtful], found.tip_bound[doubtful], found.angle_bound[doubtful]
        # by metric length: near the pole C turns far over a small part of a great circle
        length = np.where(path.spline[on] >= 0, measures.motion_length[on], measures.metric_length[on])
        reach = np.maximum(2.0 * (tip_allowed + RADIAN_MM * angle_allowed) / length, measures.blend_u[on])
        found.tip[doubtful], found.axis[doubtful], found.rotary[doubtful] = measure_deviation_nearby(
            path, on, u[doubtful], pose.select(doubtful), tip_allowed, angle_allowed, reach
        )
    return found
