"""Rows that follow the feed rate where no joint holds the motion back.

Blocks of inverse time may ask for a hundredth of the speed of their neighbours by s while hardly anything moves. A
profile changes its speed over some twenty units (``tuning.VIRTUAL_JERK``), which is a tenth of a short block; the
joints would allow it from one row to the next. So where a profile is slower than the feed rate, faster rows are tried.
"""

from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.base.ragged import find_runs
from verne_post.base.tolerances import WHOLE_CYCLE
from verne_post.trajectory import tuning
from verne_post.trajectory.interpolation import average_around, find_lowest_around
from verne_post.trajectory.row_limits import REST_ROWS, JointRows, add_rest, measure_joint_excess
from verne_post.trajectory.section_path import SectionTask, check_joints

#: The feed rate is looked at in so many places of each row, and at least so many of each element.
_PLACES: Final = 8
#: A row at which a joint has more than this share of a limit is as slow as that joint makes it.
SLACK_SHARE: Final = 0.9
#: A stretch of at least so many rows that cannot be made faster whole is tried in halves.
_SPLIT_ROWS: Final = 8
#: A long stretch is as slow as its slowest change of speed needs; the next pass finds its parts that are still slow.
_PASSES: Final = 2
#: Two stretches that lose less than a row each are tried as one of at most so many rows; longer ones can lose 1 %.
_JOINED_ROWS: Final = 200
#: A change of the feed rate is evened out over so many rows, tried in turn: fewer lose less time, more take less jerk.
EVEN_ROWS: Final = (0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
#: Of the largest feed rate of a stretch, these shares are tried in turn: a short block may have no time to reach it.
_PEAK_SHARES: Final = (1.0, 0.6, 0.4, 0.3, 0.2)
#: ... and to so many rows the fewest are sought.
_REACH_STEP: Final = 0.25


def follow_feed(task: SectionTask, s: Array, timed: Mask) -> Array:
    """Rows that take no longer than such rows s (n,) from rest to rest, and keep every limit as these do.

    Stretches that are slower than the feed rate, or halves of them, are replaced one by one. Only ``timed`` elements
    (m,) of the section count: those whose feed rate is a time. Rows at which a joint comes near a limit stay. Two
    stretches that lose a share of a row each lose a whole one together.
    """
    z = add_rest(s)
    for _ in range(_PASSES):
        z = _shorten(task, z, _list_stretches(task, z, timed), _SPLIT_ROWS)
    joined = [(a, d) for (a, _b), (_c, d) in pairwise(_list_stretches(task, z, timed)) if d - a < _JOINED_ROWS]
    return _shorten(task, z, joined, _JOINED_ROWS)[REST_ROWS:-REST_ROWS]


def _list_stretches(task: SectionTask, z: Array, timed: Mask) -> list[tuple[int, int]]:
    """First and last rows of stretches of z (n,) slower than the feed rate, on ``timed`` elements (m,) alone."""
    rows = JointRows.build(task, z)
    step = np.diff(z)
    slow = step < tuning.FEED_REACHED * task.cycle * rows.cap
    slow[:REST_ROWS], slow[-REST_ROWS:] = False, False
    element = np.searchsorted(task.section.breaks[1:-1], z, side="right")
    others = np.append(0, np.cumsum(~timed))
    slow &= others[element[1:] + 1] == others[element[:-1]]
    held = np.flatnonzero(measure_joint_excess(rows.q, task.limits, task.cycle) > SLACK_SHARE)
    for k in range(REST_ROWS):  # a difference that begins at a row is of so many steps
        slow[held + k] = False
    return [(a, b) for a, b in _find_stretches(slow) if others[element[b] + 1] == others[element[a]]]


def _shorten(task: SectionTask, z: Array, stretches: list[tuple[int, int]], split: int) -> Array:
    """Rows z (n,) with as few rows as the limits allow in each stretch, or in halves from ``split`` rows on."""
    parts, done = list[Array](), 0
    stretches = stretches[::-1]
    while stretches:
        first, last = stretches.pop()
        if first < done:
            continue  # joined with the stretch before
        found = _find_legal_rows(task, z, first, last)
        if found is not None:
            parts += [z[done:first], found]
            done = last + 1
        elif last - first >= split:  # one place that holds the motion back does not keep the rest slow
            middle = (first + last) // 2
            stretches += [(middle + REST_ROWS, last), (first, middle)]
    return np.concatenate([*parts, z[done:]])


def _find_stretches(slow: Mask) -> Iterator[tuple[int, int]]:
    """First and last row of stretches of slow steps; those that one difference sees together are one."""
    first, last = find_runs(slow)
    if len(first):
        apart = np.flatnonzero(first[1:] - last[:-1] > 2 * REST_ROWS)
        yield from zip(first[np.append(0, apart + 1)].tolist(), last[np.append(apart, -1)].tolist(), strict=True)


def _find_legal_rows(task: SectionTask, z: Array, first: int, last: int) -> Array | None:
    """Fewer rows than ``first`` to ``last`` (both included) of z (n,), between the same ends and inside all limits."""
    edges, fastest = _find_paces(task, z[first], z[last])

    def find_legal(pace: Array, begin: float, end: float, reach: float) -> Array | None:
        rows = _space_rows_evenly(edges, pace, task.cycle, reach, begin, end)
        if len(rows) > last - first:
            return None
        around = np.concatenate([z[first - REST_ROWS : first], rows, z[last + 1 : last + 1 + REST_ROWS]])
        q, hidden = task.section.find_joints_and_hidden(around)
        check_joints(q, around)
        too_fast = max(measure_joint_excess(q, task.limits, task.cycle).max(), hidden.max() / tuning.ACCEPTED_RATIOS[0])
        return rows if too_fast <= 1.0 else None

    step = np.diff(z[first - 1 : last + 2]) / task.cycle
    for share in _PEAK_SHARES:
        pace = np.maximum(fastest, fastest.min() / share)
        if (edges[-1] - edges[0]) * pace.min() > (last - first - 1 + 2 * WHOLE_CYCLE) * task.cycle:
            return None  # at this speed all the way there would be no row fewer, and evened out it is nowhere higher
        for begin, end in (np.inf, np.inf), (step[:2].max(), step[-2:].max()):
            found = _find_least_reach(partial(find_legal, pace, begin, end))
            if found is not None:
                return found
    return None


def _find_least_reach(find_legal: Callable[[float], Array | None]) -> Array | None:
    """The rows that ``find_legal`` gives for the least reach in rows for which it gives any, to _REACH_STEP."""
    shorter = 0.0
    for reach in EVEN_ROWS:
        found = find_legal(reach)
        if found is None:
            shorter = reach
            continue
        while reach - shorter > _REACH_STEP:
            middle = 0.5 * (reach + shorter)
            better = find_legal(middle)
            if better is None:
                shorter = middle
            else:
                reach, found = middle, better
        return found
    return None


def _find_paces(task: SectionTask, begin: float, end: float) -> tuple[Array, Array]:
    """Edges s (m + 1,) between two places, and seconds per mm at the feed rate between them (m,)."""
    section = task.section
    breaks = section.breaks[
        np.searchsorted(section.breaks, begin, "right") : np.searchsorted(section.breaks, end, "left")
    ]
    edges = np.concatenate([[begin], breaks, [end]])
    edges = np.append((edges[:-1, None] + np.arange(_PLACES) / _PLACES * np.diff(edges)[:, None]).ravel(), end)
    speed = np.asarray(section.find_speed(0.5 * (edges[1:] + edges[:-1])), dtype=float)
    return edges, 1.0 / (task.feed_share * tuning.PLANNED_SHARES[0] * speed)


def _space_rows_evenly(edges: Array, pace: Array, cycle: float, reach: float, begin: float, end: float) -> Array:
    """Rows (n,) at the paces (m,) between edges (m + 1,), or slower; the speed changes over ``reach`` rows.

    So do those from the speed ``begin`` at the first row and to ``end`` at the last, where they are finite.
    """
    time = np.append(0.0, np.cumsum(pace * np.diff(edges)))
    if reach and min(begin, end) > 0.0:
        cells = max(int(np.ceil(time[-1] / cycle * _PLACES)), 1)
        at = np.linspace(0.0, time[-1], cells + 1)
        speed = 1.0 / pace[np.clip(np.searchsorted(time, 0.5 * (at[1:] + at[:-1])) - 1, 0, len(pace) - 1)]
        # means of means of the lowest around are nowhere above; those of squares make the acceleration even
        half = round(reach * _PLACES / 2)
        # so far do the means reach
        beside = 4 * half if np.isfinite(begin) else 0
        speed = np.concatenate([np.full(beside, begin), speed, np.full(beside, end)])
        lowest = find_lowest_around(speed**2, 2 * half)
        even = np.maximum(average_around(average_around(lowest, half), half), lowest.min())
        even = even[beside : len(even) - beside]
        # a cell may last several rows: the acceleration is even within each
        even = np.sqrt(np.concatenate([even[:1], 0.5 * (even[1:] + even[:-1]), even[-1:]]))
        return _sample_rows(np.interp(at, time, edges), even, cycle)
    count = int(np.ceil(time[-1] / cycle - WHOLE_CYCLE))
    return np.interp(np.linspace(0.0, time[-1], count + 1), time, edges)


def _sample_rows(edges: Array, speed: Array, cycle: float) -> Array:
    """Rows (n,) from the first of edges (m,) to the last, at speeds (m,) with an even acceleration between."""
    lasts = 2.0 * np.diff(edges) / (speed[1:] + speed[:-1])
    time = np.append(0.0, np.cumsum(lasts))
    count = int(np.ceil(time[-1] / cycle - WHOLE_CYCLE))
    at = np.linspace(0.0, time[-1], count + 1)
    cell = np.minimum(np.searchsorted(time, at, side="right") - 1, len(lasts) - 1)
    since = at - time[cell]
    gained = np.diff(speed)[cell] * since / np.maximum(lasts[cell], np.finfo(float).tiny)
    rows = edges[cell] + since * (speed[cell] + 0.5 * gained)
    rows[-1] = edges[-1]
    return np.clip(rows, edges[0], edges[-1])
