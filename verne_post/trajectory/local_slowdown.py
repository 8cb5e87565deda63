"""Slowing a profile down around one place; all rows outside stay as they are."""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.ragged import find_runs
from verne_post.trajectory import tuning
from verne_post.trajectory.interpolation import interpolate
from verne_post.trajectory.row_limits import REST_ROWS


def slow_down_locally(s: Array, slower: Array, reach: int) -> Array:
    """Rows s (n,) slowed down around some of them, by at least ``slower`` (n,), from 1 on.

    The speed falls and rises again over ``reach`` rows on each side. Every such place takes a whole number of rows
    more, so all rows outside stay as they are.
    """
    n = len(s)
    extra = np.pad(tuning.SLOWDOWN_MARGIN * (slower - 1.0), 2 * reach)
    plateau = np.lib.stride_tricks.sliding_window_view(extra, reach + 1).max(axis=1)
    bell = np.hanning(reach + 2)[1:-1]
    smooth = np.convolve(plateau, bell / bell.sum(), mode="full")
    begin = (len(smooth) - n) // 2
    slowness = smooth[begin : begin + n]
    inside = slowness > 0
    inside[[0, -1]] = False
    starts, ends = find_runs(inside)
    parts, done = [], 0
    for low, high in zip(starts.tolist(), ends.tolist(), strict=True):
        first, last = low - 1, high  # rows that stay where they are
        around = slice(max(first - reach, 0), min(last + reach, n - 1) + 1)
        at = _slower_instants(first, slowness[first : last + 1])
        parts += [
            s[done : first + 1],
            interpolate(np.arange(around.start, around.stop, dtype=float), s[around], at[1:-1]),
        ]
        done = last
    return np.asarray(np.maximum.accumulate(np.clip(np.concatenate([*parts, s[done:]]), s[0], s[-1])))


def _slower_instants(first: int, slowness: Array) -> Array:
    """Instants (in rows) from row ``first`` on that pass slower by ``1 + slowness``, a whole number of them."""
    rows = np.arange(len(slowness), dtype=float)
    added = float(np.sum(0.5 * (slowness[1:] + slowness[:-1])))
    density = 1.0 + slowness * (np.ceil(added) / added)
    passed = np.append(0.0, np.cumsum(0.5 * (density[1:] + density[:-1])))
    wanted = np.arange(round(float(passed[-1])) + 1, dtype=float)
    found = interpolate(passed, rows, wanted)
    return np.asarray(first + found)


def excess_of_rows(worst: Array) -> Array:
    """Largest excess of the differences that each row of a section is in, from :func:`excess` of the rows at rest."""
    padded = np.concatenate([np.ones(REST_ROWS), np.maximum(worst, 1.0), np.ones(REST_ROWS)])
    around = np.lib.stride_tricks.sliding_window_view(padded, REST_ROWS + 1).max(axis=1)
    return np.asarray(around[REST_ROWS:-REST_ROWS])
