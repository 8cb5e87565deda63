"""Rows within limits, from rows that nearly are: small shifts along the path around those beyond a limit.

Limits are those on the differences of the rows themselves, so what counts here is what verification will check. Around
each row that is beyond a limit the rows of a stretch are shifted along the path: least squares on the excess, damped
by the jerk that the shifts make, one banded solution a step. Where that is not enough, the stretch is given more
rows, and in the end the whole section is slowed down, which always helps: every ratio falls with the speed.
"""

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask, find_used
from verne_post.base.columns import Growing, iterate_blocks, release_memory
from verne_post.base.ragged import find_runs
from verne_post.base.team import split_evenly
from verne_post.trajectory import tuning
from verne_post.trajectory.interpolation import interpolate, resample_rows
from verne_post.trajectory.row_limits import (
    REST_ROWS,
    JointRows,
    add_rest,
    find_exceeding,
    measure_excess,
    measure_rows_excess,
)
from verne_post.trajectory.row_shifts import HELD_ROWS, join_stretches, shift_rows
from verne_post.trajectory.section_path import SectionTask, find_finite_joints

#: Rows that lie far apart, and what a stretch counts for at least: around each, the system reads 64 kB of every column.
SCATTERED_ROWS: Final = 1 << 8


def repair_or_slow_down(task: SectionTask, rows: Callable[[float], Array], *, is_repair_tried: bool = False) -> Array:
    """Path parameters of rows, from rest to rest, inside every limit.

    Parameters
    ----------
    rows : callable
        Rows s (n,) of a profile stretched by a factor from 1 on; the first 0, the last the section's length.
    is_repair_tried : bool
        Whether :func:`repair_rows` has failed with the rows that are not stretched.

    Raises
    ------
    ValueError
        However slow, the rows are beyond a limit: the joints jump along the section.
    """
    s = rows(1.0)
    for attempt in range(tuning.SLOWDOWN_ATTEMPTS):
        z = add_rest(s)
        worst = measure_excess(task, z)
        if attempt or not is_repair_tried:
            repaired = repair_rows(task, z, find_exceeding(worst))
            if repaired is not None:
                return repaired
        # braking before a place takes jerk as well, the less the longer it lasts
        reach = max(round(2**attempt * tuning.SLOWDOWN_REACH * task.unit / task.cycle), 8)
        s = slow_down_locally(s, np.cbrt(measure_row_excess(worst)), reach)
    slower, top, before = 1.0, np.inf, np.inf
    while top <= tuning.JUMP_SHARE * before or (task.section.measure_hidden(z) > 1.0).any():
        slower, before = 2.0 * slower, top
        z = add_rest(rows(slower))
        worst = measure_excess(task, z)
        repaired = repair_rows(task, z, find_exceeding(worst))
        if repaired is not None:
            return repaired
        top = float(worst.max())
    at = z[int(np.argmax(worst))]
    raise ValueError(f"no speed is slow enough at s = {at:.6g} mm of the section: the joints jump there")


def repair_rows(task: SectionTask, z: Array, over: tuple[Ints, Array], hopeless: float = np.inf) -> Array | None:
    """Rows inside every limit, made from rows z (n,) that nearly are; None where that takes too many rounds.

    The given rows have rows of rest at both ends (:func:`add_rest`), the result does not. ``over`` says which of them
    are :func:`find_exceeding` a limit. Repair gives up where more than one in
    ``tuning.ROWS_PER_FAR_ROW`` is beyond ``hopeless`` times a limit after a round.
    """
    z, (bad, ratio) = _show_path(task, z, over)
    reach = max(round(tuning.REPAIR_REACH * task.unit / task.cycle), 8)
    for attempt in range(tuning.REPAIR_ROUNDS + 1):
        if not len(bad):
            rises = all((np.diff(z[first : last + 1]) >= 0).all() for first, last in iterate_blocks(len(z)))
            return z[REST_ROWS:-REST_ROWS] if rises else None
        if attempt == tuning.REPAIR_ROUNDS:
            break
        width = reach * (2 + attempt) // 2
        added = np.maximum(ratio > tuning.FAR_RATIO, 2**attempt // 2)
        around = np.clip(bad[added > 0, None] + width * np.arange(-1, 2), 0, len(z) - 2).ravel()
        gentle = 0.5 * np.cbrt(tuning.GENTLE_LENGTH * added * _find_pace(task, z, around))
        low, high = join_stretches(
            bad, np.maximum(width, np.round(gentle)).astype(np.intp), np.zeros_like(bad), np.full_like(bad, len(z))
        )
        more = np.maximum.reduceat(added, np.searchsorted(bad, low)) * (high - low > 2 * HELD_ROWS)
        z, bad, ratio = _repair_stretches(z, low, high, more, reach, task)
        if tuning.ROWS_PER_FAR_ROW * np.count_nonzero(ratio > hopeless) > len(z):
            break
    return None


def _show_path(task: SectionTask, z: Array, over: tuple[Ints, Array]) -> tuple[Array, tuple[Ints, Array]]:
    """Rows z, with more of them where steps hide the path, and the result of :func:`find_exceeding` for them.

    Steps that hide the path or are far beyond the feed are halved.

    Unchanged where no step hides the path.
    """
    halved = False
    while len(bad := over[0]):
        hides = _measure_at_steps(z, bad, lambda s: task.section.measure_hidden(s) > 1.0)
        if not hides.any() and not halved:
            break
        fast = _measure_at_steps(
            z, bad, lambda s: np.diff(s) > tuning.FAR_RATIO * task.cycle * JointRows.build(task, s).cap
        )
        long = bad[hides | fast]
        if not len(long):
            break
        more = Growing(float)
        for begin, end in iterate_blocks(len(z)):
            steps_here = long[slice(*np.searchsorted(long, [begin, end]))]
            middle = 0.5 * (z[steps_here] + z[steps_here + 1])
            more.extend(np.insert(z[begin:end], steps_here + 1 - begin, middle))
        z, halved = more.freeze(), True
        over = find_exceeding(measure_excess(task, z))
    return z, over


def _measure_at_steps(z: Array, rows: Ints, measure: Callable[[Array], Mask]) -> Mask:
    """What ``measure`` finds at steps (n - 1,) between places (n,), for those that begin at ``rows`` (m,) of z."""
    found = [np.empty(0, dtype=bool)]
    for first in range(0, len(rows), SCATTERED_ROWS):
        release_memory()
        near = rows[first : first + SCATTERED_ROWS, None] + np.arange(-1, 2)
        found.append(measure(z[np.clip(near, 0, len(z) - 1)].ravel())[1::3])
    return np.concatenate(found)


def _repair_stretches(
    z: Array, low: Ints, high: Ints, more: Ints, reach: int, task: SectionTask
) -> tuple[Array, Ints, Array]:
    """Rows with stretches [low, high) given ``more`` rows and shifted, and the :func:`find_exceeding` of the result.

    All exceeding rows lie in the stretches. Held rows at both ends keep the differences across the ends. The stretches
    are repaired in groups, so that the memory does not grow with the section.
    """
    new = Growing(float)
    done = 0  # of the old rows
    rows, ratios = [], []
    lengths = high - low + more
    passed = np.cumsum(np.maximum(lengths, SCATTERED_ROWS))
    bounds = [last for _first, last in split_evenly(int(passed[-1]), tuning.SHARED_ROWS)]
    edges = find_used(np.searchsorted(passed, [0, *bounds], side="right")).tolist()
    groups = [slice(first, last) for first, last in pairwise(edges)]
    shift = partial(_shift_stretches, task, reach, z, low, high, more)
    for some, (shifted, excesses) in zip(groups, task.team.map(shift, groups), strict=True):
        ends = np.cumsum(lengths[some])[:-1]
        places = zip(low[some].tolist(), high[some].tolist(), strict=True)
        for (a, b), part, worst in zip(places, np.split(shifted, ends), np.split(excesses, ends), strict=True):
            new.copy(z[done:a])
            still = np.flatnonzero(worst[: len(part) - REST_ROWS] > 1.0)
            rows.append(new.count + still)
            ratios.append(worst[still])
            new.extend(part.copy())
            done = b
    new.copy(z[done:])
    return new.freeze(), np.concatenate(rows), np.concatenate(ratios)


def _shift_stretches(
    task: SectionTask, reach: int, z: Array, low: Ints, high: Ints, more: Ints, some: slice
) -> tuple[Array, Array]:
    """Rows of some of the stretches, laid end to end, given more and shifted, and their excess."""
    release_memory()
    places = zip(low[some].tolist(), high[some].tolist(), more[some].tolist(), strict=True)
    parts = [_add_rows(z[a:b], k) for a, b, k in places]
    shifted = shift_rows(np.concatenate(parts), np.array([len(part) for part in parts]), reach, task)
    return shifted.s, measure_rows_excess(shifted, task)


def _find_pace(task: SectionTask, s: Array, rows: Ints) -> float:
    """Largest motion of a joint in the cycles that begin at rows, over the motion that its jerk makes from rest."""
    most = 0.0
    for first in range(0, len(rows), SCATTERED_ROWS):
        release_memory()
        some = rows[first : first + SCATTERED_ROWS]
        q = find_finite_joints(task.section, np.stack([s[some], s[some + 1]]).ravel()).reshape(2, len(some), -1)
        most = max(most, float((np.abs(q[1] - q[0]) / (task.limits.jerk * task.cycle**3)).max()))
    return most


def _add_rows(part: Array, more: int) -> Array:
    """The same stretch in more rows: slower in its middle, unchanged at its ends."""
    n = len(part)
    if more == 0:
        return part
    k = np.arange(n + more, dtype=float)
    f = np.clip((k - HELD_ROWS) / (n + more - 1 - 2 * HELD_ROWS), 0.0, 1.0)
    step = f**4 * (35 + f * (-84 + f * (70 - 20 * f)))
    return resample_rows(part, k - more * step, HELD_ROWS)


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
        at = _place_slower_instants(first, slowness[first : last + 1])
        parts += [
            s[done : first + 1],
            interpolate(np.arange(around.start, around.stop, dtype=float), s[around], at[1:-1]),
        ]
        done = last
    return np.asarray(np.maximum.accumulate(np.clip(np.concatenate([*parts, s[done:]]), s[0], s[-1])))


def _place_slower_instants(first: int, slowness: Array) -> Array:
    """Instants (in rows) from row ``first`` on that pass slower by ``1 + slowness``, a whole number of them."""
    rows = np.arange(len(slowness), dtype=float)
    added = float(np.sum(0.5 * (slowness[1:] + slowness[:-1])))
    density = 1.0 + slowness * (np.ceil(added) / added)
    passed = np.append(0.0, np.cumsum(0.5 * (density[1:] + density[:-1])))
    wanted = np.arange(round(float(passed[-1])) + 1, dtype=float)
    found = interpolate(passed, rows, wanted)
    return np.asarray(first + found)


def measure_row_excess(worst: Array) -> Array:
    """Largest excess of the differences that each row is in; ``worst`` is :func:`measure_excess` with rest added."""
    padded = np.concatenate([np.ones(REST_ROWS), np.maximum(worst, 1.0), np.ones(REST_ROWS)])
    around = np.lib.stride_tricks.sliding_window_view(padded, REST_ROWS + 1).max(axis=1)
    return np.asarray(around[REST_ROWS:-REST_ROWS])
