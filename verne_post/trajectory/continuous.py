"""Motion profiles of continuous sections: near the time optimum, inside every limit on the differences of the rows.

A first profile (:mod:`initial_profile`) comes from the second-order reachability pass. It need not be legal: the interior point
method re-times it in a few passes, coarse to fine, each on the profile of the pass before. Only s(t) changes, so the tool
stays on the path whatever happens here. Rows that are still beyond a limit are repaired, one stretch at a time.
"""

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.columns import Growing
from verne_post.base.team import ALONE, Team
from verne_post.model.machine import Limits
from verne_post.trajectory import reachability, tuning
from verne_post.trajectory.fewer_rows import try_fewer_rows
from verne_post.trajectory.initial_profile import Solver, initial_profile
from verne_post.trajectory.override import AS_PLANNED, FeedOverride
from verne_post.trajectory.repair import repair_or_slow_down, repair_rows
from verne_post.trajectory.retiming import retime
from verne_post.trajectory.row_limits import at_rest, exceeding, excess
from verne_post.trajectory.section_path import Section, SectionTask
from verne_post.trajectory.section_rows import sample_rows
from verne_post.trajectory.spline_profile import Profile, Times, positions
from verne_post.trajectory.tuning import Effort


class ContinuousProfile(Struct, frozen=True, eq=False):
    """The profile of one section.

    Attributes
    ----------
    s : ndarray, shape (n,)
        Path parameter at t = 0, cycle, 2 cycle, ..., from rest to rest; the first is 0, the last the section's length.
    bound : float
        Time of the second-order optimum of the same section, s: no profile inside the limits is faster, but for what the feed
        and the limits allow between the points of the grid.
    """

    s: Array
    bound: float


class _PlannedSection(Struct, frozen=True, eq=False):
    """A profile, the times that its last pass gives it, and its repaired rows; None where they could not be repaired."""

    profile: Profile
    times: Times
    rows: Array | None


def plan_continuous(
    section: Section, limits: Limits, cycle: float, effort: Effort = tuning.NORMAL, solver: Solver = reachability.solve,
    playback: FeedOverride = AS_PLANNED, begin: float = 0.0, team: Team = ALONE,
) -> ContinuousProfile:  # fmt: skip
    """Plan a section from rest to rest.

    Parameters
    ----------
    section : Section
    limits : Limits
        Where no joint has a jerk limit, the section is planned with ``tuning.QUALITY``.
    cycle : float
        Control cycle, s.
    effort : Effort
        How finely to plan. Where the rows of the profile cannot be repaired, the section is planned with ``tuning.QUALITY``.
    solver : callable
        Of the second-order problem.
    playback : FeedOverride
        How fast the planned profile is executed.
    begin : float
        When the section begins in the file, s.
    team : Team
        The processes that plan it.

    Raises
    ------
    ValueError
        The section, a limit but jerk, or the cycle is not a finite positive number, or the joints jump along the section.
    """
    positive = np.concatenate([limits.velocity, limits.acceleration, [cycle]])
    if not (np.isfinite(positive).all() and (positive > 0).all() and (limits.jerk > 0).all()):
        raise ValueError("velocity, acceleration and cycle must be finite and above 0, jerk above 0")
    if np.isinf(limits.jerk).all():
        effort = tuning.QUALITY  # nothing but the optimum is asked for, and few passes lead there
    limits = limits.bound_jerk(cycle)
    unit = max(tuning.TIME_UNIT, cycle)
    first = initial_profile(section, limits, unit, solver, team)
    bound, task = first.bound, SectionTask(section, limits, cycle, first.unit, first.cruise, team=team)
    planned = _plan_with_effort(task, first.profile, bound, effort)
    if planned.rows is None and effort is not tuning.QUALITY:
        # a better profile costs less than to repair this one, and is faster by far
        planned = _plan_with_effort(task, first.profile, bound, tuning.QUALITY)
    if planned.rows is not None and playback == AS_PLANNED:
        return ContinuousProfile(try_fewer_rows(task, planned.rows), bound)

    def rows(slower: float) -> Array:
        return sample_rows(task, planned.profile, planned.times, slower, playback, begin)

    return ContinuousProfile(repair_or_slow_down(replace(task, feed_share=playback.override), rows), bound)


def _plan_with_effort(task: SectionTask, profile: Profile, bound: float, effort: Effort) -> _PlannedSection:
    """Make all passes; repeat the last one while too many rows are far beyond a limit, or cannot be repaired."""
    if effort is tuning.QUALITY:  # without a margin, rows that follow the feed rate are beyond it by their rounding
        task = replace(task, cruise=np.empty((0, 2)))
    for done, settings in enumerate(effort.passes):
        if done and profile.duration < effort.near_bound * bound:
            break
        profile = rebuild_profile(task, profile, retime(task, profile, settings))
    last = replace(effort.last, knot_units=1) if profile.duration > tuning.JERK_BOUND_RATIO * bound else effort.last
    times = retime(task, profile, last)
    for repeats_left in reversed(range(effort.repeats + 1)):
        z = at_rest(sample_rows(task, profile, times))
        over = exceeding(excess(task, z))
        if not repeats_left or tuning.ROWS_PER_FAR_ROW * np.count_nonzero(over[1] > tuning.FAR_RATIO) <= len(z):
            rows = repair_rows(task, z, over)
            if rows is not None:
                return _PlannedSection(profile, times, rows)
        if repeats_left:
            profile = rebuild_profile(task, profile, times)
            times = retime(task, profile, replace(last, tightest_rows=tuning.ALL_ROWS))
    return _PlannedSection(profile, times, None)


def rebuild_profile(task: SectionTask, profile: Profile, times: Times) -> Profile:
    """Make a profile that has been re-timed a profile by itself."""
    unit = task.unit
    count = int(np.ceil(times.total / unit)) + 1
    samples = Growing(float)
    for part in positions(profile, times, count, lambda number: np.minimum(unit * number, times.total), task.team):
        samples.extend(part)
    return Profile.through_samples(samples.column(), unit)
