"""The time-optimal law under velocity and acceleration limits, by an exact reachability scan.

At each grid point i with x = sd^2 and u = sdd every joint demands |q' u + q'' x| <= a. With symmetric limits
rest is always feasible, and the largest x_i from which x_(i+1) <= K can be reached is

    x_i = min(cap_i, min_j (K + 2 D b_j) / (1 - 2 D c_j)),   b = a / |q'|,  c = q'' / q',  D = s_(i+1) - s_i,

a minimum of increasing affine maps. The forward pass has the same form. Such maps are monotone, so a window
scanned from its largest and from its smallest start value brackets the truth, and where the two meet
the value no longer depends on what came before: windows are scanned side by side and joined exactly.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.model.machine import Limits
from verne_post.timing.run_path import Grid

Array = NDArray[np.float64]

#: Grid points per window: enough steps to forget the start, few enough Python steps.
WINDOW: Final = 512
#: A joint that moves less than this per mm does not limit the acceleration.
STILL: Final = 1e-12
#: Stands for the acceleration of a joint that bounds none.
UNBOUNDED: Final = 1e30
#: Stands for the squared speed where nothing bounds it.
X_UNBOUNDED: Final = 1e14


def solve(
    grid: Grid, limits: Limits, cap: Array | None = None, *, start: float = 0.0, window: int = WINDOW
) -> Array:  # fmt: skip
    """Squared speed x = sd^2 of the time-optimal law, at rest at the end of the grid.

    Parameters
    ----------
    grid : Grid
    limits : Limits
    cap : ndarray, shape (n,), optional
        Keep x below this as well, mm2/s2.
    start : float
        x at the first point, mm2/s2; less where the grid does not let the law stop from it.
    window : int
        Grid points that are scanned one after the other; does not change the result.

    Returns
    -------
    ndarray, shape (n,)
        mm2/s2.
    """
    x_cap = speed_caps(grid, limits)
    if cap is not None:
        x_cap = np.minimum(x_cap, cap)
    x_cap[0], x_cap[-1] = min(x_cap[0], start), 0.0
    b, c = _affine(grid, limits)
    step = 2 * np.diff(grid.s)[:, None]
    # backward: from K at i + 1 to x at i
    room = 1.0 - step * c[:-1]
    bounded = room > 0
    gain = np.where(bounded, 1.0 / np.where(bounded, room, 1.0), 0.0)
    offset = np.where(bounded, step * b[:-1] * gain, np.inf)
    reach = _scan_windows(x_cap[:-1][::-1], offset[::-1], gain[::-1], window)
    controllable = np.append(reach[::-1], 0.0)
    # forward: from x at i to x at i + 1
    offset, gain = step * b[:-1], np.maximum(room, 0.0)
    return np.append(controllable[0], _scan_windows(controllable[1:], offset, gain, window, controllable[0]))


def duration(s: Array, x: Array) -> float:
    """Time of a law with constant acceleration between grid points, s."""
    speed = np.sqrt(x)
    return float((2 * np.diff(s) / (speed[:-1] + speed[1:])).sum())


def speed_caps(grid: Grid, limits: Limits) -> Array:
    """Largest x (n,) that feed, velocities and the acceleration limits among themselves allow."""
    with np.errstate(divide="ignore", invalid="ignore"):
        x = np.minimum(grid.speed**2, ((limits.velocity / np.abs(grid.d1)) ** 2).min(axis=1))
        x = np.minimum(x, X_UNBOUNDED)
        b, c = _affine(grid, limits)
        # u must exist: -b_j - c_j x <= b_k - c_k x for every pair of joints
        for j in range(b.shape[1]):
            for k in range(b.shape[1]):
                slope = c[:, k] - c[:, j]
                x = np.where(slope > 0, np.minimum(x, (b[:, j] + b[:, k]) / slope), x)
        still = np.abs(grid.d1) <= STILL
        return np.minimum(x, np.where(still, limits.acceleration / np.abs(grid.d2), np.inf).min(axis=1))


def jerk_caps(grid: Grid, limits: Limits) -> Array:
    """The x (n,) at which even motion alone takes the whole jerk, (J / |q'''|)^(2/3)."""
    with np.errstate(divide="ignore"):
        return np.cbrt((limits.jerk / np.abs(grid.d3)) ** 2).min(axis=1)


def _affine(grid: Grid, limits: Limits) -> tuple[Array, Array]:
    """B = a / |q'| and c = q'' / q' for each joint; a joint that stands still bounds nothing."""
    moving = np.abs(grid.d1) > STILL
    slope = np.where(moving, grid.d1, 1.0)
    return np.where(moving, limits.acceleration / np.abs(slope), UNBOUNDED), np.where(moving, grid.d2 / slope, 0.0)


def _scan_windows(cap: Array, offset: Array, gain: Array, window: int, start: float = 0.0) -> Array:
    """``y[i] = min(cap[i], min_j(offset[i, j] + gain[i, j] y[i - 1]))`` with ``start`` before the first."""
    n, joints = offset.shape
    windows = -(-n // window)
    pad = windows * window - n
    cap = np.append(cap, np.zeros(pad)).reshape(windows, window)
    offset = np.concatenate([offset, np.zeros((pad, joints))]).reshape(windows, window, joints)
    gain = np.concatenate([gain, np.zeros((pad, joints))]).reshape(windows, window, joints)
    values = np.empty((windows, window))
    low, high = np.zeros(windows + 1), np.append(start, cap[:, -1])
    low[0] = start
    rows = np.arange(windows)
    while len(rows):
        certain = low[rows] == high[rows]
        both = _run(cap[rows], offset[rows], gain[rows], np.stack([low[rows], high[rows]]))
        values[rows] = both[1]
        low[rows + 1], high[rows + 1] = both[0, :, -1], both[1, :, -1]
        # a window is final once its start was certain; the first of the others becomes so in every round
        rows = rows[~certain]
    return values.ravel()[:n]


def _run(cap: Array, offset: Array, gain: Array, start: Array) -> Array:
    """Scan windows (w, m) side by side from start values (k, w); returns (k, w, m)."""
    y = start
    found = np.empty((len(start), *cap.shape))
    for i in range(cap.shape[1]):
        y = np.minimum(cap[:, i], (offset[:, i] + gain[:, i] * y[..., None]).min(axis=-1))
        found[..., i] = y
    return found
