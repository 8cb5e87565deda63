"""The time-optimal profile under velocity and acceleration limits, by exact reachability passes.

Between grid points i and i + 1 the path acceleration u is constant, so the squared speeds x and K at both are tied by
K = x + 2 D u. Every joint demands |q' u + q'' x| <= a at both ends of the step, which is |A K + B x| <= a with

    A = q' / (2 D),  B = q'' - A  at the beginning,      A = q' / (2 D) + q'',  B = -q' / (2 D)  at the end.

With symmetric limits rest is always feasible. The largest x from which some K up to a given one can be reached is

    x = min(cap, V, min over A B <= 0 of (a + |A| K) / |B|),

V being the largest x of any K, a corner of two lines. Solved backwards this gives what is controllable; forwards,
K = min(controllable, min (a - sgn(A) B x) / |A|) gives the profile. Such maps keep brackets, so a window solved from
its largest and its smallest start value encloses the truth, and where the two meet the value no longer depends on what
came before: windows are solved side by side and joined exactly.
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.rows import find_row_max, find_row_min
from verne_post.model.machine import Limits
from verne_post.trajectory import tuning
from verne_post.trajectory.section_path import Grid

#: A steeper line of (x, K) bounds K or x alone except for rounding; a larger x than anything reaches (mm2/s2).
_HUGE: Final = 1.0 / float(np.finfo(float).eps)
#: Corners that are lower by no more than this share are the same but for rounding.
_CORNER_ROUNDING: Final = 8.0 * float(np.finfo(float).eps)


def solve(grid: Grid, limits: Limits, *, start: float = 0.0, window: int | None = None) -> Array:
    """Squared speed x = sd^2 of the time-optimal profile, at rest at the end of the grid.

    Parameters
    ----------
    start : float
        x at the first point, mm2/s2; less where the grid does not let the profile stop from it.
    window : int
        Grid points that are solved one after the other; does not change the result.

    Returns
    -------
    ndarray, shape (n,)
        mm2/s2.
    """
    window = window or tuning.PASS_WINDOW
    x_cap = limit_speeds(grid, limits)
    x_cap[0], x_cap[-1] = min(x_cap[0], start), 0.0
    lines = _find_lines(grid, limits)
    forward = _find_rising_in_x(lines)
    x_cap[:-1] = _lower_to_possible(x_cap[:-1], forward)
    # backward: from K at i + 1 to x at i
    reach = _solve_windows(x_cap[:-1][::-1], _run_backward(_find_rising_in_k(lines)), window)
    controllable = np.append(reach[::-1], 0.0)
    # forward: from x at i to K at i + 1
    begin = float(controllable[0])
    return np.append(begin, _solve_windows(controllable[1:], forward, window, begin))


def find_duration(s: Array, x: Array) -> float:
    """Time of a profile with constant acceleration between grid points, s."""
    speed = np.sqrt(x)
    return float((2 * np.diff(s) / (speed[:-1] + speed[1:])).sum())


def bound_duration(s: Array, x: Array, acceleration: Array) -> float:
    """Time in which no profile passes the points s (n,) faster than with sd^2 = x (n,), s.

    Each step is made with the largest path ``acceleration`` (n,) up to the higher speed, and at that speed from there
    on. Where a step is much longer than the way to reach the feed rate, constant acceleration would take twice the
    time.
    """
    speed, step = np.sqrt(x), np.diff(s)
    even = np.abs(np.diff(x)) / (2 * step)
    steepest = np.maximum(np.maximum(acceleration[1:], acceleration[:-1]), np.maximum(even, np.finfo(float).tiny))
    change = np.abs(np.diff(speed)) / steepest
    return float((change + (step - even * step / steepest) / np.maximum(speed[1:], speed[:-1])).sum())


def find_accelerations(grid: Grid, limits: Limits, x: Array) -> Array:
    """Largest path acceleration (n,) that any joint leaves at squared speeds x (n,), mm/s2."""
    with np.errstate(divide="ignore"):
        return np.asarray(find_row_min((limits.acceleration + np.abs(grid.d2) * x[:, None]) / np.abs(grid.d1)))


def limit_speeds(grid: Grid, limits: Limits) -> Array:
    """Largest x (n,) that feed and velocities allow, and even motion inside the acceleration limits."""
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.minimum(grid.speed**2, find_row_min(limits.velocity / np.abs(grid.d1)) ** 2)
        return np.minimum(x, _HUGE)


def limit_jerk(grid: Grid, limits: Limits) -> Array:
    """The x (n,) at which even motion alone takes the whole jerk, (J / |third derivative|)^(2/3)."""
    with np.errstate(divide="ignore"):
        return np.cbrt(find_row_min(limits.jerk / np.abs(grid.d3)) ** 2)


def _find_lines(grid: Grid, limits: Limits) -> tuple[Array, Array]:
    """A and B over a of every step, shape (n - 1, 2 n_joints): |A K + B x| <= 1."""
    half = (0.5 / np.diff(grid.s))[:, None]
    begin, end = half * grid.d1[:-1], half * grid.d1[1:]
    a = np.concatenate([begin, end + grid.d2[1:]], axis=1)
    b = np.concatenate([grid.d2[:-1] - begin, -end], axis=1)
    over = np.tile(1.0 / limits.acceleration, 2)
    return a * over, b * over


def _find_rising_in_k(lines: tuple[Array, Array]) -> tuple[Array, Array]:
    """Offset and gain of the bounds x <= offset + gain K that rise with K; the others are infinite."""
    a, b = lines
    steep, size = np.abs(a), np.abs(b)
    # as a factor: which lines rise is as good as random, and choosing by a mask waits for every guess that is wrong
    rising = ((a * b <= 0) & (steep < _HUGE * size)).astype(float)
    steep *= rising
    steep /= np.maximum(size, np.finfo(float).tiny)
    size *= rising
    with np.errstate(divide="ignore"):
        return np.divide(1.0, size, out=size), steep


def _find_rising_in_x(lines: tuple[Array, Array]) -> tuple[Array, Array]:
    """Offset and gain of the bounds K <= offset + gain x; the gain is negative where a larger x leaves less K."""
    a, b = lines
    bounding = np.abs(a) * _HUGE > np.abs(b)
    size = np.where(bounding, a, 1.0)
    return np.where(bounding, 1.0 / np.abs(size), np.inf), np.where(bounding, -b / size, 0.0)


def _run_backward(lines: tuple[Array, Array]) -> tuple[Array, Array]:
    return lines[0][::-1], lines[1][::-1]


def _lower_to_possible(cap: Array, lines: tuple[Array, Array]) -> Array:
    """Caps (n,) of x, lowered to V where no K at all is left at a cap.

    Every line bounds K from above, by U = offset + gain x, and from below, by L = gain x - offset; K >= 0 is one more
    bound from below. The room between the lowest U and the highest L is concave in x, and there is some at rest. So
    Newton's method comes down to V from beyond it, from the corner of two lines to a lower one.
    """
    lowered = cap.copy()
    # where even motion at the cap keeps all limits, x = K = cap is possible
    rows = np.flatnonzero(find_row_max(np.abs(1.0 - lines[1]) / lines[0]) * cap > 1.0)
    while len(rows):
        offset, gain = (line[rows] for line in lines)
        slope = gain * lowered[rows, None]
        every = np.arange(len(rows))
        above, below = (offset + slope).argmin(axis=1), (slope - offset).argmax(axis=1)
        least = np.maximum((slope - offset)[every, below], 0.0)
        none = np.flatnonzero((offset + slope)[every, above] < least)
        rows, above, below, every = rows[none], above[none], below[none], every[none]
        from_zero = least[none] == 0.0
        width = offset[every, above] + np.where(from_zero, 0.0, offset[every, below])
        corner = width / (np.where(from_zero, 0.0, gain[every, below]) - gain[every, above])
        lower = corner < lowered[rows] * (1.0 - _CORNER_ROUNDING)
        lowered[rows] = np.minimum(corner, lowered[rows])
        rows = rows[lower]
    return lowered


def _solve_windows(cap: Array, lines: tuple[Array, Array], window: int, start: float = 0.0) -> Array:
    """``y[i] = min(cap[i], min_j(offset[i, j] + gain[i, j] y[i - 1]))``, never below 0; ``start`` is y[-1]."""
    n, count = lines[0].shape
    windows = -(-n // window)
    pad = windows * window - n

    def order_steps_first(line: Array) -> Array:
        """By step, line and window: what one step needs lies together."""
        full = np.concatenate([line, np.zeros((pad, count))]).reshape(windows, window, count)
        return np.ascontiguousarray(full.transpose(1, 2, 0))

    caps = np.ascontiguousarray(np.append(cap, np.zeros(pad)).reshape(windows, window).T)
    offset, gain = (order_steps_first(line) for line in lines)
    low, high = np.zeros(windows), np.append(start, caps[-1, :-1])  # brackets of starts
    low[0] = start
    bracket = _solve_side_by_side(caps, offset, gain, np.stack([low, high]))
    values = np.ascontiguousarray(bracket[:, 1])
    uncertain = np.count_nonzero(bracket[:, 0] != values, axis=0)  # steps until the start of a window is forgotten
    begin = np.append(start, values[-1, :-1])
    rows = np.flatnonzero(np.append(True, uncertain[:-1] < window))
    while len(rows):  # windows whose start is known
        steps = slice(0, int(uncertain[rows].max()))
        values[steps, rows] = _solve_side_by_side(
            caps[steps, rows], offset[steps, :, rows], gain[steps, :, rows], begin[None, rows]
        )[:, 0]
        # a window that forgets nothing goes on in the next one
        rows = rows[uncertain[rows] == window] + 1
        rows = rows[rows < windows]
        begin[rows] = values[-1, rows - 1]
    return np.asarray(values.T.ravel()[:n])


def _solve_side_by_side(cap: Array, offset: Array, gain: Array, start: Array) -> Array:
    """Solve windows side by side, from one start value or from both ends of a bracket.

    Parameters
    ----------
    cap : ndarray, shape (m, w)
    offset, gain : ndarray, shape (m, lines, w)
    start : ndarray, shape (1 or 2, w)

    Returns
    -------
    ndarray, shape (m, 1 or 2, w)
    """
    y = start
    found = np.empty((len(cap), *start.shape))
    # a bound that falls turns a bracket over
    turning = (gain.min(axis=(1, 2), initial=0.0) < 0).tolist() if len(start) == 2 else [False] * len(cap)
    bound = np.empty((len(start), *gain.shape[1:]))
    for turns, limit, one_offset, one_gain, out in zip(turning, cap, offset, gain, found, strict=True):
        np.multiply(one_gain, y[:, None], out=bound)
        if turns:
            bound[0], bound[1] = np.minimum(bound[0], bound[1]), np.maximum(bound[0], bound[1])
        np.add(bound, one_offset, out=bound)
        y = np.minimum.reduce(bound, axis=1, out=out)
        np.minimum(limit, y, out=y)
        np.maximum(y, 0.0, out=y)
    return found
