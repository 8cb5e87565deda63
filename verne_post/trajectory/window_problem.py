"""The constraints of one window of a pass: limits at the points, from differences of rows a cycle apart."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.trajectory import tuning
from verne_post.trajectory.interior_point import Problem
from verne_post.trajectory.section_path import SectionTask, joints_at
from verne_post.trajectory.spline_profile import Profile
from verne_post.trajectory.tuning import PassSettings

Array = NDArray[np.float64]


#: From the planned share of the feed up to what rows may reach, squared.
_HELD_EXCESS: Final = (tuning.ACCEPTED_RATIOS[0] / tuning.PLANNED_SHARES[0]) ** 2


@dataclass(frozen=True, eq=False)
class Window:
    """Part of a profile that one solution re-times.

    Attributes
    ----------
    begin, end : int
        Knots, ``end`` excluded.
    fixed : ndarray, shape (0,) or (3,)
        The first coefficients, where the window before gives them.
    end_x : ndarray, shape (3,), or None
        The last coefficients; None where the section ends there.
    """

    begin: int
    end: int
    fixed: Array
    end_x: Array | None


@dataclass(frozen=True, eq=False)
class _Differences:
    """Joints' first three derivatives by pseudo-time (n_joints, points), and the share of the feed that is used (points,)."""

    first: Array
    second: Array
    third: Array
    feed_x: Array


def window_problem(task: SectionTask, profile: Profile, settings: PassSettings, window: Window) -> Problem:
    """Constraints at the points of a window, from differences of rows a cycle apart: the acceptance metric itself."""
    n, k = window.end - window.begin, settings.points_per_knot
    unit, limits, shares = task.unit, task.limits, settings.shares
    at_points = _differences(task, profile, settings, window)
    q1, q2, q3 = at_points.first, at_points.second, at_points.third
    with np.errstate(divide="ignore", invalid="ignore"):
        by_speed = 1.0 / ((q1 / (shares[0] * limits.velocity[:, None])) ** 2).max(axis=0)
    cap = np.minimum(np.where(np.isnan(at_points.feed_x), np.inf, at_points.feed_x), by_speed)
    cap = np.clip(cap, 2 * tuning.SMALLEST_X, settings.largest_x)
    # coefficients that are held may stand at the cap itself, which leaves no room inside
    near_held = cap.reshape(k, n)
    near_held[:, : len(window.fixed)] *= _HELD_EXCESS
    near_held[:, n - 3 * (window.end_x is not None) :] *= _HELD_EXCESS
    acceleration, jerk = shares[1] * limits.acceleration[:, None], shares[2] * limits.jerk[:, None]
    virtual = np.zeros((1, n * k))
    q1a = np.concatenate([0.5 * q1 / acceleration, virtual + 0.5 * unit / tuning.VIRTUAL_ACCELERATION])
    q2a = np.concatenate([q2 / acceleration, virtual])
    q1j = np.concatenate([0.5 * q1 / jerk, virtual + 0.5 * unit**2 / tuning.VIRTUAL_JERK])
    q2j = np.concatenate([1.5 * q2 / jerk, virtual])
    q3j = np.concatenate([q3 / jerk, virtual])

    both: list[tuple[Array, ...]] = [(q2a, q1a), (q3j, q2j, q1j)]
    acceleration_rows, jerk_rows = (
        _tightest(rows, count or len(rows[0])) for rows, count in zip(both, settings.tightest_rows, strict=True)
    )
    phases = (np.arange(k) + 0.5) / k
    knot = settings.knot_units * unit
    return Problem(knot, phases, cap, acceleration_rows, jerk_rows, window.fixed, window.end_x)


def _differences(task: SectionTask, profile: Profile, settings: PassSettings, window: Window) -> _Differences:
    """Differences at the points of a window over the control cycle, by phase and then by interval."""
    section, k = task.section, settings.points_per_knot
    delta = task.cycle
    knot = settings.knot_units * task.unit
    spacing = knot / k
    points = (window.end - window.begin) * k
    apart = round(delta / spacing)
    if apart >= 1 and abs(apart * spacing - delta) < 1e-9 * delta:  # points share their samples
        first = window.begin * knot + 0.5 * spacing - 1.5 * delta
        s = profile.s(first + spacing * np.arange(points + 3.0 * apart))
        offset = apart
    else:
        at = (window.begin + (np.arange(points) + 0.5) / k) * knot
        s = profile.s(at + delta * np.array([[-1.5], [-0.5], [0.5], [1.5]])).reshape(-1)
        offset = points
    q = np.ascontiguousarray(joints_at(section, s).T)
    a, b, c, d = (q[:, m * offset : m * offset + points] for m in range(4))
    low, high = slice(offset, offset + points), slice(2 * offset, 2 * offset + points)
    speed = np.asarray(section.speed(s[offset : high.stop]), dtype=float)
    speed = np.minimum(speed[:points], speed[offset:])
    slope = s[high] - s[low]
    with np.errstate(divide="ignore", invalid="ignore"):
        feed_x = _by_phase((settings.shares[0] * delta * speed / slope)[None], k)[0] ** 2
    return _Differences(
        _by_phase((c - b) / delta, k),
        _by_phase((d - c - b + a) / (2 * delta**2), k),
        _by_phase((d - 3 * (c - b) - a) / delta**3, k),
        feed_x,
    )


def _tightest(rows: tuple[Array, ...], count: int) -> tuple[Array, ...]:
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
        chosen = largest_rows(sign * upper[0] + reach, count) * len(points) + points
        sides.append([sign * row.take(chosen) for row in upper])
    return tuple(np.concatenate(pair) for pair in zip(*sides, strict=True))


def largest_rows(scores: Array, count: int) -> NDArray[np.int64]:
    """Rows (count, points) in which the largest of finite scores (m, points) stand, the largest first.

    Every score carries the number of its row in its last bits, so that ordering the scores orders the rows: scores that are
    equal but for these bits are as good as equal.
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


def _by_phase(a: Array, k: int) -> Array:
    """Points in order of time (m, n k) -> by phase, then by interval."""
    return np.ascontiguousarray(a.reshape(len(a), -1, k).transpose(0, 2, 1)).reshape(len(a), -1)
