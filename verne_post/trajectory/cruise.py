"""Stretches where the tool keeps its feed rate, far from joint limits and slow places: nothing to solve there.

They are found once, on the grid of the second-order optimum, and kept as ranges of the path. Passes follow the feed
rate in them and solve what lies between.
"""

from collections.abc import Iterator

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.ragged import find_runs
from verne_post.model.machine import Limits
from verne_post.trajectory import tuning
from verne_post.trajectory.interpolation import average_around, find_lowest_around, hold_ends
from verne_post.trajectory.reachability import limit_jerk
from verne_post.trajectory.section_path import Grid, SectionTask
from verne_post.trajectory.spline_profile import Profile
from verne_post.trajectory.tuning import PassSettings


class Piece(Struct, frozen=True, eq=False):
    """Knots ``begin`` to ``end`` that a pass solves after a cruise.

    ``cruise`` are the coefficients of X from the end of the piece before on, with the first three of this one; it is
    empty where the section begins. ``after`` are the last three of this one, where a cruise follows.
    """

    begin: int
    end: int
    cruise: Array
    after: Array | None


def find_cruise(grid: Grid, x: Array, limits: Limits, unit: float) -> Array:
    """Ranges of s (k, 2) at the feed rate in the profile x (n,), without the ways to brake to a stop at both ends."""
    speed, share = np.sqrt(x), tuning.CRUISE_SHARE
    slope = np.abs(grid.d1) * speed[:, None]
    even = (x >= (1.0 - 2.0 * tuning.CRUISE_STEP) * grid.speed**2) & (x <= share * limit_jerk(grid, limits))
    even &= (slope <= share * limits.velocity).all(axis=1)
    even &= (np.abs(grid.d2) * x[:, None] <= share * limits.acceleration).all(axis=1)
    # from one feed rate to the next in the time over which they are evened out
    feed = np.where(even, grid.speed, 1.0)
    change = np.abs(np.diff(feed)) / feed[1:]
    jerk = slope[1:] * (change / (tuning.CRUISE_EVEN * unit) ** 2)[:, None]
    goes_on = even[1:] & even[:-1] & (change <= tuning.CRUISE_STEP)
    goes_on &= (jerk <= (1.0 - share) * limits.jerk).all(axis=1)
    first, last = find_runs(goes_on)
    if not len(first):
        return np.empty((0, 2))
    # each maximum is taken up to the next stretch: what lies between is taken off
    top = np.maximum.reduceat(np.where(even[:, None], slope, 0.0), first)
    ramp = np.where(
        top * limits.jerk >= limits.acceleration**2,
        top / limits.acceleration + limits.acceleration / limits.jerk,
        2.0 * np.sqrt(top / limits.jerk),
    ).max(axis=1)
    # the profile that passes start from is averaged over some time, which is less at its speed
    ramp += tuning.START_STEP * tuning.START_SMOOTH * unit
    way = ramp * np.maximum.reduceat(np.where(even, speed, 0.0), first)
    found = np.stack([grid.s[first] + way, grid.s[last] - way], axis=1)
    return np.asarray(found[found[:, 1] > found[:, 0]])


def split_into_pieces(task: SectionTask, profile: Profile, knots: int, settings: PassSettings) -> Iterator[Piece]:
    """What a pass over so many knots solves: all but the ranges of cruise."""
    knot = settings.knot_units * task.unit
    # a coefficient of the profile stands two steps after its time
    begins, ends = (
        (profile.step / knot * (np.searchsorted(profile.coefficients, task.cruise[:, side]) - 2.0)).astype(np.intp)
        + way
        for side, way in ((0, 2), (1, -2))
    )
    kept = (ends - begins) * knot >= tuning.LOOK_AHEAD_UNITS * task.unit
    solved, cruise = 0, np.empty(0)
    stretches = list(zip(begins[kept].tolist(), ends[kept].tolist(), strict=True))
    for (begin, end), following in zip(stretches, _follow_feed(task, profile, stretches, settings), strict=True):
        yield Piece(solved, begin, cruise, following[:3])
        solved, cruise = end, following
    yield Piece(solved, knots, cruise, None)


def _follow_feed(
    task: SectionTask, profile: Profile, stretches: list[tuple[int, int]], settings: PassSettings
) -> Iterator[Array]:
    """Coefficients of X (end - begin + 3,) that lead to the planned share of the feed, over each stretch of knots."""
    if not stretches:
        return
    knot = settings.knot_units * task.unit
    # means of means over so many knots are below the limits of all intervals that a coefficient reaches
    reach = tuning.CRUISE_EVEN // settings.knot_units // 2
    at_a_time = max(tuning.AT_A_TIME // max(end - begin for begin, end in stretches), 1)
    for first in range(0, len(stretches), at_a_time):
        group = stretches[first : first + at_a_time]
        s = profile.find_s(knot * np.concatenate([np.arange(begin, end + 1, dtype=float) for begin, end in group]))
        feed = np.asarray(task.section.find_speed(s), dtype=float)
        # those between two stretches mean nothing
        every = (settings.shares[0] * knot * np.minimum(feed[1:], feed[:-1]) / np.diff(s)) ** 2
        at = 0
        for begin, end in group:
            lowest = find_lowest_around(every[at : at + end - begin], 2 * reach + 3)
            yield hold_ends(average_around(average_around(lowest, reach), reach), 1, 2)
            at += end - begin + 1
