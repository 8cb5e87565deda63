"""Where an input shaper needs motion to be slower, so that the tool stays within tolerance and feed rate.

A shaper displaces the motion by half the variance of its weights times the acceleration. Corners leave a share of their
tolerance to it. Where that does not do, on tight arcs and fast corners, and where the feed rate falls, speed limits along the
path are lowered until the shaped rows themselves keep tolerance and feed rate.
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.app.assemble import Program
from verne_post.base.arrays import Array, Ints
from verne_post.base.columns import running_sums
from verne_post.base.rows import row_norm
from verne_post.base.tolerances import PATH_AXIS_DEG, PATH_TIP_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.contour import Contour
from verne_post.model.protocols import SpeedFunction
from verne_post.model.toolpath import SegmentKind
from verne_post.toolpath.contour_pose import contour_pose, speed_cap
from verne_post.trajectory import tuning
from verne_post.trajectory.plan import MotionProfiles
from verne_post.trajectory.sample import Rows, RowSampler, Timeline
from verne_post.trajectory.shaper import shape_rows

#: Of what verification allows where the path has no tolerance, so much is used: the rest is for rounding.
EXACT_SHARE: Final = 0.9


class SpeedLimits(Struct, frozen=True, eq=False):
    """Largest speed ds/dt along a path, a step function: ``speed`` (m,), mm/s, from ``begin`` (m,) on, mm; infinite before."""

    begin: Array
    speed: Array

    def at(self, s: Array) -> Array:
        """The limits (n,) at path lengths s (n,)."""
        return np.append(np.inf, self.speed)[np.searchsorted(self.begin, s, side="right")]

    def lower(self, other: "SpeedLimits") -> "SpeedLimits":
        """The lower one of both everywhere."""
        begin = np.union1d(self.begin, other.begin)
        return SpeedLimits(begin, np.minimum(self.at(begin), other.at(begin)))

    def applied_to(self, contour: Contour, speed: SpeedFunction) -> SpeedFunction:
        """A feed cap that keeps them too."""
        starts = running_sums(contour.length)

        def limit_speed(contour: Contour, element: Ints, w: Array) -> Array:
            return np.minimum(speed(contour, element, w), self.at(starts[element] + w * contour.length[element]))

        return limit_speed


NO_LIMITS: Final = SpeedLimits(np.empty(0), np.empty(0))


def find_slowdown(program: Program, profiles: MotionProfiles, laid_out: Timeline) -> tuple[SpeedLimits, Array]:
    """Speed limits along the path that let shaped rows keep tolerance and feed rate, and by which factor sections are too fast.

    The factors (n_sections,) are 1 where nothing is to be done. The limits count for continuous sections, the factors for
    those from stop to stop.
    """
    contour = program.contour
    starts, sampler = running_sums(contour.length), RowSampler(contour, profiles, laid_out)
    limits, too_fast = NO_LIMITS, np.ones(contour.n_sections)
    for sampled in map(sampler.rows, sampler.blocks()):
        factor = _measure_excess(program, sampled, laid_out)
        if (factor <= 1.0).all():
            continue
        # a shaped row is made of all rows under its weights
        reach = len(laid_out.weights) - 1
        around = np.lib.stride_tricks.sliding_window_view(np.pad(factor, reach), reach + 1).max(axis=1)
        np.maximum.at(too_fast, contour.section[sampled.element], around)
        s = starts[sampled.element] + sampled.w * contour.length[sampled.element]
        limits = limits.lower(_make_slower_limits(s, around, laid_out.cycle))
    return limits, too_fast


def _measure_excess(program: Program, sampled: Rows, laid_out: Timeline) -> Array:
    """By which factor (n,) the motion around each shaped row is too fast."""
    contour, weights = program.contour, laid_out.weights
    shaped = shape_rows(program.joints().q(sampled.element, sampled.w), weights)
    segment = contour.segment[sampled.shown]
    tip, angles, _ok = program.machine.five_axis.nominal(shaped, contour.path.tool_length[segment])
    meant_tip, meant_angles = contour_pose(contour, sampled.shown, sampled.shown_w)
    tip_bound = _compute_remaining_tolerances(contour.tip_tolerance[segment], PATH_TIP_MM)
    axis_bound = _compute_remaining_tolerances(contour.axis_tolerance[segment], PATH_AXIS_DEG * RAD_PER_DEG)
    off = np.maximum(row_norm(tip - meant_tip) / tip_bound, np.abs(angles - meant_angles).max(axis=1) / axis_bound)
    off[contour.path.kind[segment] == SegmentKind.JOINT] = 0.0  # straight in the joints: means of rows stay on it
    factor = np.sqrt(off)  # displacement goes with the square of the speed
    cap = laid_out.cycle * speed_cap(contour, sampled.shown, sampled.shown_w)
    by_feed = np.diff(sampled.at) / (np.minimum(cap[1:], cap[:-1]) * tuning.ACCEPTED_RATIOS[0])
    factor[1:] = np.maximum(factor[1:], by_feed)
    return np.asarray(factor)


def _compute_remaining_tolerances(tolerance: Array, exact: float) -> Array:
    """What corners leave of the tolerances (n,) to the shaper; of what verification allows ``exact`` paths, where that is more."""
    by_corners = (1.0 - tuning.SHAPER_SHARE) * tolerance
    return np.maximum(tolerance, EXACT_SHARE * exact) - by_corners


def _make_slower_limits(s: Array, factor: Array, cycle: float) -> SpeedLimits:
    """Limits that make the steps between rows s (n,) slower by ``factor`` (n,) where it is above 1."""
    step, needed = np.diff(s), np.maximum(factor[1:], factor[:-1])
    moving = np.flatnonzero(step > 0)
    speed = np.where(needed > 1.0, step / (cycle * tuning.SHAPER_MARGIN * np.maximum(needed, 1.0)), np.inf)
    begin, speed = np.append(s[moving], s[-1]), np.append(speed[moving], np.inf)
    changes = speed != np.append(np.inf, speed[:-1])
    return SpeedLimits(begin[changes], speed[changes])
