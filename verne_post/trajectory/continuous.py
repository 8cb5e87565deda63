"""Motion profiles of continuous sections: near the time optimum, inside every limit on the differences of the rows.

A first profile (:mod:`plan_initial_profile`) comes from the second-order reachability pass. It may exceed limits. The
interior-point passes re-time it, coarse to fine, each on the profile of the pass before. Only s(t) changes, so the tool
stays on the path in any case. Rows that are still beyond a limit are repaired, one stretch at a time.

Rows at the ends of a profile over which hardly anything moves are left out.
"""

from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.columns import Growing
from verne_post.base.team import ALONE, Team
from verne_post.model.machine import Limits
from verne_post.trajectory import reachability, tuning
from verne_post.trajectory.fewer_rows import try_fewer_rows
from verne_post.trajectory.initial_profile import Solver, plan_initial_profile
from verne_post.trajectory.override import AS_PLANNED, FeedOverride
from verne_post.trajectory.repair import repair_or_slow_down, repair_rows
from verne_post.trajectory.retiming import retime
from verne_post.trajectory.row_limits import add_rest, find_exceeding, measure_excess
from verne_post.trajectory.section_path import Section, SectionTask, find_finite_joints
from verne_post.trajectory.spline_profile import Profile, Times, find_positions
from verne_post.trajectory.tuning import Effort

#: Without jerk limits, sections of up to this many rows are tried with fewer; of longer ones a row is less than 0.01 %.
FEW_ROWS_WITHOUT_JERK: Final = 10_000
#: ... and in so many rounds of shifts. After one, sections of the samples take up to two cycles more; eight save none.
ROUNDS_WITHOUT_JERK: Final = 2


class ContinuousProfile(Struct, frozen=True, eq=False):
    """The profile of one section."""

    #: (n,): Path parameter at t = 0, cycle, 2 cycle, ..., from rest to rest; the first is 0, the last the
    #: section's length.
    s: Array
    #: Time of the second-order optimum of the same section, s. No profile inside the limits is faster, except for
    #: what the feed and the limits allow between the points of the grid.
    bound: float


class _PlannedSection(Struct, frozen=True, eq=False):
    """A profile, the times of its last pass, and its repaired rows; None where they could not be repaired."""

    profile: Profile
    times: Times
    rows: Array | None


def plan_continuous(
    section: Section,
    limits: Limits,
    cycle: float,
    effort: Effort = tuning.NORMAL,
    solver: Solver = reachability.solve,
    playback: FeedOverride = AS_PLANNED,
    begin: float = 0.0,
    team: Team = ALONE,
) -> ContinuousProfile:
    """Plan a section from rest to rest.

    Parameters
    ----------
    limits : Limits
        Where no joint has a jerk limit, the section is planned with ``tuning.QUALITY``.
    cycle : float
        Control cycle, s.
    effort : Effort
        How finely to plan. If its rows cannot be repaired, a section is planned with ``tuning.QUALITY``.
    solver : callable
        Of the second-order problem.
    playback : FeedOverride
        How fast the planned profile is executed.
    begin : float
        When the section begins in the file, s.

    Raises
    ------
    ValueError
        The cycle or a limit except jerk is not finite and positive, the section is not, or the joints jump along it.
    """
    positive = np.concatenate([limits.velocity, limits.acceleration, [cycle]])
    if not (np.isfinite(positive).all() and (positive > 0).all() and (limits.jerk > 0).all()):
        raise ValueError("velocity, acceleration and cycle must be finite and above 0, jerk above 0")
    few_rows, rounds = tuning.FEW_ROWS, 1
    if np.isinf(limits.jerk).all():  # nothing but the optimum is asked for, and few passes lead there
        effort, few_rows, rounds = tuning.QUALITY, FEW_ROWS_WITHOUT_JERK, ROUNDS_WITHOUT_JERK
    limits = limits.bound_jerk(cycle)
    unit = max(tuning.TIME_UNIT, cycle)
    first = plan_initial_profile(section, limits, unit, solver, team)
    bound, task = first.bound, SectionTask(section, limits, cycle, first.unit, first.cruise, team=team)
    planned = _plan_with_effort(task, first.profile, bound, effort)
    if planned.rows is None and effort is not tuning.QUALITY:
        # a better profile costs less than to repair this one, and is faster by far
        planned = _plan_with_effort(task, first.profile, bound, tuning.QUALITY)
    if planned.rows is not None and playback == AS_PLANNED:
        return ContinuousProfile(try_fewer_rows(task, planned.rows, few_rows, rounds), bound)

    def make_rows(slower: float) -> Array:
        return sample_rows(task, planned.profile, planned.times, slower, playback, begin)

    slowed = repair_or_slow_down(
        replace(task, feed_share=playback.override), make_rows, is_repair_tried=playback == AS_PLANNED
    )
    return ContinuousProfile(slowed, bound)


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
        z = add_rest(sample_rows(task, profile, times))
        over = find_exceeding(measure_excess(task, z))
        if not repeats_left or tuning.ROWS_PER_FAR_ROW * np.count_nonzero(over[1] > tuning.FAR_RATIO) <= len(z):
            rows = repair_rows(task, z, over, effort.hopeless)
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
    for part in find_positions(profile, times, count, lambda number: np.minimum(unit * number, times.total), task.team):
        samples.extend(part)
    return Profile.interpolate(samples.freeze(), unit)


def sample_rows(
    task: SectionTask,
    profile: Profile,
    times: Times,
    slower: float = 1.0,
    playback: FeedOverride = AS_PLANNED,
    begin: float = 0.0,
) -> Array:
    """Path parameters (n,) of the profile as it is executed from time ``begin`` on, at whole cycles.

    It is stretched by ``slower`` to a whole number of cycles; resting ends are left out.
    """
    section, cycle = task.section, task.cycle
    cycles = playback.count_cycles(times.total * slower, begin, cycle)

    def find_instants(row: Array) -> Array:
        done = playback.find_shares(row, np.full(len(row), float(cycles)), np.full(len(row), begin), cycle)
        return times.total * done

    every, farthest = Growing(float), 0.0
    for s in find_positions(profile, times, cycles + 1, find_instants, task.team):
        s = np.maximum.accumulate(np.append(farthest, np.clip(s, 0.0, section.length)))[1:]
        every.extend(s)
        farthest = float(s[-1])
    s = every.freeze()
    first = int(np.searchsorted(s, 0.0, side="right")) - 1
    last = int(np.searchsorted(s, section.length, side="left"))
    s = s[max(first, 0) : last + 1]
    at_start, at_end = _count_creeping(task, s, cycle * playback.rate(begin))
    rows = Growing(float)
    rows.extend(np.zeros(1))
    rows.copy(s[1 + at_start : len(s) - 1 - at_end])
    rows.extend(np.array([section.length]))
    return rows.freeze()


def _count_creeping(task: SectionTask, s: Array, cycle: float) -> tuple[int, int]:
    """Count rows after the first and before the last over which joints hardly move: creeping that nobody needs.

    ``cycle`` is what passes of the planned time from row to row, s: under an override the limits count that it leaves.
    """
    section, limits, n = task.section, task.limits, len(s)
    count = min(tuning.CREEPING_ROWS, n // 4)
    if count < 2:
        return 0, 0
    reach = np.minimum(limits.jerk * cycle**3, np.minimum(limits.acceleration * cycle**2, limits.velocity * cycle))
    tail = np.concatenate([[0.0], s[1:count], s[n - count : -1], [section.length]])
    moved = find_finite_joints(section, tail)
    by_feed = cycle * np.asarray(section.find_speed(tail), dtype=float)

    def count_creeping(rows: slice, end: int) -> int:
        strain = (np.abs(moved[rows] - moved[end]) / reach).max(axis=1)
        strain = np.maximum(strain, np.abs(tail[rows] - tail[end]) / by_feed[rows])
        return int(np.count_nonzero(strain < tuning.CREEPING_MOTION))

    at_start, at_end = count_creeping(slice(1, count), 0), count_creeping(slice(count, -1), -1)
    # the step that takes their place must be one that the rows allow
    while at_start and _is_too_far(section, np.array([0.0, 0.0, s[1 + at_start]]), cycle):
        at_start //= 2
    while at_end and _is_too_far(section, np.append(s[[-3 - at_end, -2 - at_end]], section.length), cycle):
        at_end //= 2
    return at_start, at_end


def _is_too_far(section: Section, s: Array, cycle: float) -> bool:
    """Whether the last step between rows s (n,) hides the path, or is far beyond a feed that changes along it."""
    cap = np.asarray(section.find_speed(np.array([s[-2], 0.5 * (s[-2] + s[-1]), s[-1]])), dtype=float).min()
    return bool(section.measure_hidden(s)[-1] > 1.0 or s[-1] - s[-2] > (1.0 + 2 * tuning.CREEPING_MOTION) * cycle * cap)
