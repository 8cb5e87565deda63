"""The constraints of windows of a pass: limits at the points, from differences of rows a cycle apart.

Windows that do not depend on each other are laid end to end and make one problem. Between them stand intervals without
constraints, whose coefficients are held. So what an array operation costs beside its work is paid once for all of them.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.base.tolerances import WHOLE_CYCLE
from verne_post.trajectory import tuning
from verne_post.trajectory.interior_point import Problem
from verne_post.trajectory.interpolation import hold_ends
from verne_post.trajectory.section_path import Section, SectionTask, find_finite_joints
from verne_post.trajectory.spline_profile import Profile
from verne_post.trajectory.tuning import PassSettings

#: From the planned share of the feed up to what rows may reach, squared.
_HELD_EXCESS: Final = (tuning.ACCEPTED_RATIOS[0] / tuning.PLANNED_SHARES[0]) ** 2


#: Coefficients of a cubic spline that an interval shares with the next one; so many are held where a window is tied.
TIED: Final = 3


class Window(Struct, frozen=True, eq=False):
    """Part of a profile that one solution re-times."""

    #: begin, end: Knots, ``end`` excluded.
    begin: int
    end: int
    start: Array  #: (end - begin + 3,): Coefficients to start from.
    #: begin_tied, end_tied: The first three, or the last three stay what they are. Where they do not, the section
    #: begins or ends.
    begin_tied: bool
    end_tied: bool


class Layout(Struct, frozen=True, eq=False):
    """Windows laid end to end."""

    windows: Sequence[Window]  #: Only the first may begin where the section does, and only the last one end there.
    gap: int  #: Intervals between two windows: as many as coefficients and differences reach.

    @classmethod
    def build(cls, windows: Sequence[Window], task: SectionTask, settings: PassSettings) -> "Layout":
        """With gaps for a pass."""
        reach = 3.0 * task.cycle / (settings.knot_units * task.unit)
        return cls(windows, max(TIED, math.ceil(reach)))

    def find_begins(self) -> list[int]:
        """The interval, and the coefficient, with which each window begins."""
        counts = [window.end - window.begin + self.gap for window in self.windows]
        return np.cumsum([0, *counts[:-1]]).tolist()

    @property
    def n(self) -> int:
        """Intervals; after the last window there is no gap."""
        return self.find_begins()[-1] + self.windows[-1].end - self.windows[-1].begin

    def start(self) -> Array:
        """Coefficients (n + 3,) to start from; in the gaps those of the window before go on."""
        filled = [hold_ends(window.start, 0, self.gap - TIED) for window in self.windows]
        return np.concatenate(filled)[: self.n + TIED]

    def find_held(self) -> NDArray[np.bool_]:
        """Coefficients (n + 3,) that stay what they are."""
        held = np.zeros(self.n + TIED, dtype=bool)
        for first, window in zip(self.find_begins(), self.windows, strict=True):
            end = first + window.end - window.begin
            held[first : first + TIED * window.begin_tied] = True
            if window.end_tied:
                held[end : end + self.gap] = True
        return held

    def list_knots(self) -> Array:
        """Knots (n,) of the profile at which the intervals begin; in the gaps those after the window before."""
        parts = [np.arange(window.begin, window.end + self.gap, dtype=float) for window in self.windows]
        return np.concatenate(parts)[: self.n]

    def find_gaps(self) -> NDArray[np.bool_]:
        """Intervals (n,) that belong to no window."""
        parts = [
            np.arange(window.end - window.begin + self.gap) >= window.end - window.begin for window in self.windows
        ]
        return np.concatenate(parts)[: self.n]

    def split(self, coefficients: Array) -> list[Array]:
        """The coefficients of each window, of those of all."""
        parts = zip(self.find_begins(), self.windows, strict=True)
        return [coefficients[first : first + len(window.start)] for first, window in parts]


class _Differences(Struct, frozen=True, eq=False):
    """Joints' first three derivatives by pseudo-time (n_joints, points), and the largest rate by the feed (points,)."""

    first: Array
    second: Array
    third: Array
    by_feed: Array


def build_window_problem(task: SectionTask, profile: Profile, settings: PassSettings, layout: Layout) -> Problem:
    """Constraints at the points of windows, from differences of rows a cycle apart: the acceptance metric itself."""
    k = settings.points_per_knot
    unit, limits, shares = task.unit, task.limits, settings.shares
    samples = _Samples.build(layout.list_knots(), settings.knot_units * unit, k, task.cycle)
    at_points = _take_differences(task.section, profile, samples, task.cycle)
    q1, q2, q3 = at_points.first, at_points.second, at_points.third
    with np.errstate(divide="ignore", invalid="ignore"):
        by_speed = 1.0 / ((q1 / (shares[0] * limits.velocity[:, None])) ** 2).max(axis=0)
    by_feed = (shares[0] * at_points.by_feed) ** 2
    cap = np.minimum(np.where(np.isnan(by_feed), np.inf, by_feed), by_speed)
    cap = np.clip(cap, 2 * tuning.SMALLEST_X, settings.largest_x)
    # coefficients that are held may stand at the cap itself, which leaves no interior
    by_interval = cap.reshape(k, -1)
    for first, window in zip(layout.find_begins(), layout.windows, strict=True):
        end = first + window.end - window.begin
        by_interval[:, first : first + TIED * window.begin_tied] *= _HELD_EXCESS
        by_interval[:, end - TIED * window.end_tied : end] *= _HELD_EXCESS
    in_gap = layout.find_gaps()
    by_interval[:, in_gap] = 2.0 * settings.largest_x
    acceleration, jerk = shares[1] * limits.acceleration[:, None], shares[2] * limits.jerk[:, None]
    virtual = np.zeros((1, len(cap)))
    q1a = np.concatenate([0.5 * q1 / acceleration, virtual + 0.5 * unit / tuning.VIRTUAL_ACCELERATION])
    q2a = np.concatenate([q2 / acceleration, virtual])
    q1j = np.concatenate([0.5 * q1 / jerk, virtual + 0.5 * unit**2 / tuning.VIRTUAL_JERK])
    q2j = np.concatenate([1.5 * q2 / jerk, virtual])
    q3j = np.concatenate([q3 / jerk, virtual])

    both: list[tuple[Array, ...]] = [(q2a, q1a), (q3j, q2j, q1j)]
    acceleration_rows, jerk_rows = (
        _choose_tightest(rows, count or len(rows[0])) for rows, count in zip(both, settings.tightest_rows, strict=True)
    )
    for row in (*acceleration_rows, *jerk_rows):
        row.reshape(len(row), k, -1)[:, :, in_gap] = 0.0
    return Problem(settings.knot_units * unit, samples.phases, cap, acceleration_rows, jerk_rows, layout.find_held())


class _Samples(Struct, frozen=True, eq=False):
    """Where the profile is sampled to take differences at the points of n intervals."""

    times: Array  #: (m,): Pseudo-times of the samples.
    first: NDArray[np.int64]  #: (k n,): First of the four samples around each point, by phase and then by interval.
    stride: int  #: From each of the four to the next.
    phases: Array  #: (k,): Positions of the points in an interval, 0 to 1.

    @classmethod
    def build(cls, knots: Array, knot: float, k: int, cycle: float) -> "_Samples":
        """For k points in each of the intervals that begin at ``knots`` (n,); points share samples where they can."""
        phases = (np.arange(k) + 0.5) / k
        if _is_multiple(cycle, knot / k):
            step, begin, of_interval, chosen = knot / k, 0.5, k, np.arange(k)
        elif _is_multiple(knot, cycle) and k < round(knot / cycle) < 4 * k:  # fewer samples than four for each point
            step, begin, of_interval = cycle, 0.0, round(knot / cycle)
            chosen = np.rint(phases * of_interval).astype(np.int64)
            phases = chosen / of_interval
        else:
            at = (knots + phases[:, None]).ravel() * knot
            apart = cycle * np.array([[-1.5], [-0.5], [0.5], [1.5]])
            return cls((at + apart).ravel(), np.arange(len(at)), len(at), phases)
        stride = round(cycle / step)
        at = (knots[:, None] * knot + step * (begin + np.arange(of_interval))).ravel()
        times = np.append(at, at[-1] + step * np.arange(1.0, 3.0 * stride + 1.0)) - 1.5 * cycle
        return cls(times, (chosen[:, None] + of_interval * np.arange(len(knots))).ravel(), stride, phases)


def _is_multiple(a: float, b: float) -> bool:
    """Whether a is 1, 2, 3, ... times b."""
    times = round(a / b)
    return times >= 1 and abs(times * b - a) < WHOLE_CYCLE * b


def _take_differences(section: Section, profile: Profile, samples: _Samples, cycle: float) -> _Differences:
    """Differences at the points over the control cycle."""
    s = profile.find_s(samples.times)
    q = np.ascontiguousarray(find_finite_joints(section, s).T)
    low, high = samples.first + samples.stride, samples.first + 2 * samples.stride
    a, b, c, d = (q.take(at, axis=1) for at in (samples.first, low, high, high + samples.stride))
    speed = np.asarray(section.find_speed(s), dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        by_feed = cycle * np.minimum(speed[low], speed[high]) / (s[high] - s[low])
    return _Differences((c - b) / cycle, (d - c - b + a) / (2 * cycle**2), (d - 3 * (c - b) - a) / cycle**3, by_feed)


def _choose_tightest(rows: tuple[Array, ...], count: int) -> tuple[Array, ...]:
    """Both signs of rows (m, points); of each side the ``count`` that can become tight first.

    A side are the rows that bound the highest derivative from above, or from below. Tight first are those near
    their limit now, or soon when that derivative changes.
    """
    above = np.where(rows[-1] < 0, -1.0, 1.0)
    upper = tuple(row * above for row in rows)
    if count >= len(above):
        return tuple(np.concatenate([row, -row]) for row in upper)
    reach = upper[-1] / upper[-1].max(axis=0)
    sides = []
    points = np.arange(reach.shape[1])
    for sign in (1.0, -1.0):
        chosen = choose_largest_rows(sign * upper[0] + reach, count) * len(points) + points
        sides.append([sign * row.take(chosen) for row in upper])
    return tuple(np.concatenate(pair) for pair in zip(*sides, strict=True))


def choose_largest_rows(scores: Array, count: int) -> NDArray[np.int64]:
    """Rows (count, points) in which the largest of finite scores (m, points) stand, the largest first.

    Every score carries the number of its row in its last bits, so that ordering the scores orders the rows. Scores that
    differ only in these bits count as equal.
    """
    mask = (1 << (len(scores) - 1).bit_length()) - 1
    keys = scores.copy()
    bits = keys.view(np.int64)
    bits &= ~mask
    bits |= np.arange(len(scores))[:, None]
    result = np.full((count, scores.shape[1]), -np.inf)
    for key in keys:
        for place in result:
            lower = np.minimum(place, key)
            np.maximum(place, key, out=place)
            key = lower  # what gives way may be larger than the next
    return result.view(np.int64) & mask
