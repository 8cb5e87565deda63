"""Rows of a re-timed profile, without those at the ends over which hardly anything moves."""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.columns import Growing
from verne_post.trajectory import tuning
from verne_post.trajectory.override import AS_PLANNED, FeedOverride
from verne_post.trajectory.section_path import Section, SectionTask, joints_at
from verne_post.trajectory.spline_profile import Profile, Times, positions


def sample_rows(
    task: SectionTask, profile: Profile, times: Times, slower: float = 1.0, playback: FeedOverride = AS_PLANNED,
    begin: float = 0.0,
) -> Array:  # fmt: skip
    """Path parameters (n,) of the profile as it is executed from time ``begin`` on, at whole cycles.

    It is stretched by ``slower`` to a whole number of cycles; resting ends are left out.
    """
    section, cycle = task.section, task.cycle
    cycles = playback.cycles(times.total * slower, begin, cycle)

    def instants(row: Array) -> Array:
        done = playback.shares(row, np.full(len(row), float(cycles)), np.full(len(row), begin), cycle)
        return times.total * done

    every, farthest = Growing(float), 0.0
    for s in positions(profile, times, cycles + 1, instants, task.team):
        s = np.maximum.accumulate(np.append(farthest, np.clip(s, 0.0, section.length)))[1:]
        every.extend(s)
        farthest = float(s[-1])
    s = every.column()
    first = int(np.searchsorted(s, 0.0, side="right")) - 1
    last = int(np.searchsorted(s, section.length, side="left"))
    s = s[max(first, 0) : last + 1]
    at_start, at_end = _count_creeping(task, s, cycle * playback.rate(begin))
    rows = Growing(float)
    rows.extend(np.zeros(1))
    rows.copy(s[1 + at_start : len(s) - 1 - at_end])
    rows.extend(np.array([section.length]))
    return rows.column()


def _count_creeping(task: SectionTask, s: Array, cycle: float) -> tuple[int, int]:
    """How many rows after the first and before the last a joint hardly moves over; the profile creeps there, and need not.

    ``cycle`` is what passes of the planned time from row to row, s: under an override the limits count that it leaves.
    """
    section, limits, n = task.section, task.limits, len(s)
    count = min(tuning.CREEPING_ROWS, n // 4)
    if count < 2:
        return 0, 0
    reach = np.minimum(limits.jerk * cycle**3, np.minimum(limits.acceleration * cycle**2, limits.velocity * cycle))
    tail = np.concatenate([[0.0], s[1:count], s[n - count : -1], [section.length]])
    moved = joints_at(section, tail)
    by_feed = cycle * np.asarray(section.speed(tail), dtype=float)

    def creeping(rows: slice, end: int) -> int:
        strain = (np.abs(moved[rows] - moved[end]) / reach).max(axis=1)
        strain = np.maximum(strain, np.abs(tail[rows] - tail[end]) / by_feed[rows])
        return int(np.count_nonzero(strain < tuning.CREEPING_MOTION))

    at_start, at_end = creeping(slice(1, count), 0), creeping(slice(count, -1), -1)
    # the step that takes their place must be one that the rows allow
    while at_start and _too_far(section, np.array([0.0, 0.0, s[1 + at_start]]), cycle):
        at_start //= 2
    while at_end and _too_far(section, np.append(s[[-3 - at_end, -2 - at_end]], section.length), cycle):
        at_end //= 2
    return at_start, at_end


def _too_far(section: Section, s: Array, cycle: float) -> bool:
    """Whether the last step between rows s (n,) hides the path, or where the feed changes along it is far beyond the feed."""
    cap = np.asarray(section.speed(np.array([s[-2], 0.5 * (s[-2] + s[-1]), s[-1]])), dtype=float).min()
    return bool(section.hidden(s)[-1] > 1.0 or s[-1] - s[-2] > (1.0 + 2 * tuning.CREEPING_MOTION) * cycle * cap)
