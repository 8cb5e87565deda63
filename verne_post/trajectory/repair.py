"""Rows that are legal, from rows that nearly are: small shifts along the path around those beyond a limit.

Limits are those on the differences of the rows themselves, so what is found here is what will be judged. Around
each row that is beyond a limit the rows of a stretch are shifted along the path: least squares on the excess, damped
by the jerk that the shifts make, one banded solution a step. Where that is not enough, the stretch is given more
rows, and in the end the whole run is slowed down, which always helps: every ratio falls with the speed.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.linalg import get_lapack_funcs

from verne_post.base.columns import Growing, blocks, release_memory
from verne_post.base.ragged import ragged
from verne_post.base.rows import row_max, row_sum
from verne_post.model.machine import Limits
from verne_post.trajectory import tuning
from verne_post.trajectory.section_path import Section, joints_at

Array = NDArray[np.float64]
Ints = NDArray[np.integer]
Mask = NDArray[np.bool_]

#: Resting rows at both ends, which the differences count as well.
REST: Final = 3
#: Rows that stay at the ends of a stretch: what differences across the end are taken from, and the run's own ends.
HELD: Final = REST + 1

_PBTRF, _PBTRS = get_lapack_funcs(("pbtrf", "pbtrs"), dtype=np.float64)
_DIFFERENCES: Final = ((-1.0, 1.0), (1.0, -2.0, 1.0), (-1.0, 3.0, -3.0, 1.0))


def repair_or_slow_down(
    section: Section, rows: Callable[[float], Array], limits: Limits, cycle: float, unit: float
) -> Array:
    """Path parameters of rows, from rest to rest, inside every limit.

    Parameters
    ----------
    section : Run
    rows : callable
        Rows s (n,) of a profile stretched by a factor from 1 on; the first 0, the last the run's length.
    limits : Limits
    cycle, unit : float
        Control cycle, and the time scale of the profile, s.

    Raises
    ------
    ValueError
        However slow, the rows are beyond a limit: the joints jump along the run.
    """
    s = rows(1.0)
    for attempt in range(tuning.SLOWDOWN_ATTEMPTS):
        z = at_rest(s)
        worst = excess(section, z, limits, cycle)
        found = repair_rows(section, z, exceeding(worst), limits, cycle, unit)
        if found is not None:
            return found
        # braking before a place takes jerk of its own, the less the longer it lasts
        reach = max(round(2**attempt * tuning.SLOWDOWN_REACH * unit / cycle), 8)
        s = slow_down_locally(s, np.cbrt(_over_rows(worst)), reach)
    for slower in tuning.STRETCH_FACTORS:
        z = at_rest(rows(slower))
        found = repair_rows(section, z, exceeding(excess(section, z, limits, cycle)), limits, cycle, unit)
        if found is not None:
            return found
    slower, before = tuning.STRETCH_FACTORS[-1], np.inf
    for _ in range(tuning.STRETCH_ATTEMPTS):
        s = rows(slower)
        worst = excess(section, at_rest(s), limits, cycle)
        top = float(worst.max())
        if top <= 1.0:
            return s
        if top > tuning.JUMP_SHARE * before and not (section.hidden(at_rest(s)) > 1.0).any():
            break
        before = top
        slower *= float(np.clip(np.cbrt(top), tuning.STRETCH_STEP[0], tuning.STRETCH_STEP[1]))
    at = at_rest(s)[int(np.argmax(worst))]
    raise ValueError(f"no speed is slow enough at s = {at:.6g} mm of the run: the joints jump there")


def _over_rows(worst: Array) -> Array:
    """Largest excess of the differences that each row of a run is in, from :func:`excess` of the rows at rest."""
    padded = np.concatenate([np.ones(REST), np.maximum(worst, 1.0), np.ones(REST)])
    around = np.lib.stride_tricks.sliding_window_view(padded, REST + 1).max(axis=1)
    return np.asarray(around[REST:-REST])


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
    edges = np.flatnonzero(np.diff(np.concatenate([[False], inside, [False]]).astype(np.int8)))
    parts, done = [], 0
    for low, high in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        first, last = low - 1, high  # rows that stay where they are
        around = slice(max(first - tuning.SLOWDOWN_CONTEXT, 0), min(last + tuning.SLOWDOWN_CONTEXT, n - 1) + 1)
        at = _slower_instants(first, slowness[first : last + 1])
        parts += [
            s[done : first + 1],
            make_interp_spline(np.arange(around.start, around.stop), s[around], k=5)(at[1:-1]),
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
    found = make_interp_spline(passed, rows, k=min(5, len(rows) - 1))(wanted)
    return np.asarray(first + found)


def excess(section: Section, s: Array, limits: Limits, cycle: float) -> Array:
    """Largest ratio over the accepted one of the differences that begin at each row, shape (n - 3,).

    The rows s (n,) rest at both ends.
    """
    worst = Growing(float)
    for begin, end in blocks(len(s) - REST):
        for first in range(begin, end, tuning.ROWS_AT_A_TIME):
            before = min(first, 1)
            rows = _Rows.at(section, s[first - before : min(first + tuning.ROWS_AT_A_TIME, end) + REST], cycle)
            worst.extend(_excess(rows, limits, cycle)[before:])
    return worst.column()


def _excess(rows: "_Rows", limits: Limits, cycle: float) -> Array:
    """As :func:`excess`, of rows whose joints are known."""
    count = len(rows.s) - REST
    worst = (np.diff(rows.s) / (cycle * rows.cap))[:count] / tuning.ACCEPTED_RATIOS[0]
    difference = rows.q
    for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk)):
        difference = np.diff(difference, axis=0)
        ratio = row_max(np.abs(difference) * (1.0 / (limit * cycle ** (order + 1) * tuning.ACCEPTED_RATIOS[order])))
        worst = np.maximum(worst, ratio[:count])
    return worst


def exceeding(worst: Array) -> tuple[Ints, Array]:
    """Rows (m,) at which differences begin that are beyond a limit, and by how much, from the :func:`excess` of all."""
    bad = np.concatenate([first + np.flatnonzero(worst[first:last] > 1.0) for first, last in blocks(len(worst))])
    return bad, worst[bad]


def repair_rows(
    section: Section, z: Array, over: tuple[Ints, Array], limits: Limits, cycle: float, unit: float
) -> Array | None:  # fmt: skip
    """Rows inside every limit, made from rows z (n,) that nearly are; None where that takes too many rounds.

    Those given have rows of rest at both ends (:func:`at_rest`), those found have not. ``over`` says which of the given ones
    are :func:`exceeding` a limit.
    """
    z, (bad, ratio) = _showing(section, z, over, limits, cycle)
    reach = max(round(tuning.REPAIR_REACH * unit / cycle), 8)
    for attempt in range(tuning.REPAIR_ROUNDS + 1):
        if not len(bad):
            return z[REST:-REST] if _never_back(z) else None
        if attempt == tuning.REPAIR_ROUNDS:
            break
        width = reach * (2 + attempt) // 2
        added = np.where(
            ratio > tuning.FAR_RATIO, min(tuning.FAR_ADDED_ROWS, 1 + len(z) // tuning.ROWS_PER_ADDED_ROW), 0
        )
        added = np.maximum(added, 2 ** (attempt - 1) if attempt else 0)
        around = np.clip(bad[added > 0, None] + width * np.arange(-1, 2), 0, len(z) - 2).ravel()
        gentle = 0.5 * np.cbrt(tuning.GENTLE_LENGTH * added * _pace(section, z, around, limits, cycle))
        low, high = _stretches(
            bad, np.maximum(width, np.round(gentle)).astype(np.intp), np.zeros_like(bad), np.full_like(bad, len(z))
        )
        more = np.maximum.reduceat(added, np.searchsorted(bad, low)) * (high - low >= tuning.SHORTEST_STRETCH)
        z, bad, ratio = _mended_stretches(z, low, high, more, reach, section, limits, cycle)
    return None


def _showing(
    section: Section, z: Array, over: tuple[Ints, Array], limits: Limits, cycle: float
) -> tuple[Array, tuple[Ints, Array]]:
    """Rows with others halfway along steps that hide the path or are far beyond the feed, and which are :func:`exceeding` a limit.

    Unchanged where no step hides the path.
    """
    for halving in range(tuning.STEP_HALVINGS):
        bad = over[0]
        if not len(bad):
            break
        steps = z[np.clip(bad[:, None] + np.arange(-1, 2), 0, len(z) - 1)].ravel()
        hides = section.hidden(steps)[1::3] > 1.0
        if not hides.any() and not halving:
            break
        cap = _Rows.at(section, steps, cycle).cap[1::3]
        long = bad[hides | (z[bad + 1] - z[bad] > tuning.FAR_RATIO * cycle * cap)]
        if not len(long):
            break
        more = Growing(float)
        for begin, end in blocks(len(z)):
            some = long[slice(*np.searchsorted(long, [begin, end]))]
            more.extend(np.insert(z[begin:end], some + 1 - begin, 0.5 * (z[some] + z[some + 1])))
        z = more.column()
        over = exceeding(excess(section, z, limits, cycle))
    return z, over


def _never_back(z: Array) -> bool:
    return all((np.diff(z[first : last + 1]) >= 0).all() for first, last in blocks(len(z)))


def _mended_stretches(
    z: Array, low: Ints, high: Ints, more: Ints, reach: int, section: Section, limits: Limits, cycle: float
) -> tuple[Array, Ints, Array]:
    """Rows with stretches [low, high) given ``more`` rows and shifted, and those that still are :func:`exceeding` a limit.

    All that were lie in the stretches, whose held rows at both ends keep what differences across the ends are. So many are
    mended at a time that what is needed besides does not grow with the run.
    """
    new = Growing(float)
    done = 0  # of the old rows
    rows, ratios = [], []
    lengths = high - low + more
    group = np.cumsum(np.maximum(lengths, tuning.STRETCH_ROWS)) // tuning.ROWS_AT_A_TIME
    for first, last in pairwise(np.flatnonzero(np.diff(group, prepend=-1, append=group[-1] + 1)).tolist()):
        release_memory()
        some = slice(first, last)
        places = list(zip(low[some].tolist(), high[some].tolist(), strict=True))
        parts = [_with_more_rows(z[a:b], k) for (a, b), k in zip(places, more[some].tolist(), strict=True)]
        shifted = _shifted(np.concatenate(parts), lengths[some], reach, section, limits, cycle)
        ends = np.cumsum(lengths[first : last - 1])
        judged = np.split(_excess(shifted, limits, cycle), ends)
        for (a, b), part, worst in zip(places, np.split(shifted.s, ends), judged, strict=True):
            new.copy(z[done:a])
            still = np.flatnonzero(worst[: len(part) - REST] > 1.0)
            rows.append(new.count + still)
            ratios.append(worst[still])
            new.extend(part.copy())
            done = b
    new.copy(z[done:])
    return new.column(), np.concatenate(rows), np.concatenate(ratios)


def _stretches(bad: Ints, width: Ints, lowest: Ints, highest: Ints) -> tuple[Ints, Ints]:
    """Where stretches of so many rows (m,) on each side of rows ``bad`` (m,) begin and end; those that touch are one.

    They stay inside [lowest, highest) of each (m,), and those of different bounds stay apart.
    """
    low = np.minimum.accumulate(np.maximum(bad - width, lowest)[::-1])[::-1]
    high = np.maximum.accumulate(np.minimum(bad + REST + 1 + width, highest))
    gaps = np.flatnonzero((low[1:] > high[:-1] + HELD) | (lowest[1:] != lowest[:-1]))
    return low[np.append(0, gaps + 1)], high[np.append(gaps, len(bad) - 1)]


def at_rest(s: Array) -> Array:
    """Rows s (n,) with those of rest at both ends that the differences count as well."""
    rows = Growing(float)
    rows.copy(s, REST, REST)
    return rows.column()


def _pace(section: Section, s: Array, rows: Ints, limits: Limits, cycle: float) -> float:
    """Largest motion of a joint in the cycles that begin at rows, over the motion that its jerk makes in one from rest."""
    most = 0.0
    for first in range(0, len(rows), tuning.SCATTERED_ROWS):
        release_memory()
        some = rows[first : first + tuning.SCATTERED_ROWS]
        q = joints_at(section, np.stack([s[some], s[some + 1]]).ravel()).reshape(2, len(some), -1)
        most = max(most, float((np.abs(q[1] - q[0]) / (limits.jerk * cycle**3)).max()))
    return most


def _with_more_rows(part: Array, more: int) -> Array:
    """The same stretch in more rows: slower in its middle, unchanged at its ends."""
    n = len(part)
    if more == 0:
        return part
    k = np.arange(n + more, dtype=float)
    f = np.clip((k - HELD) / (n + more - 1 - 2 * HELD), 0.0, 1.0)
    step = f**4 * (35 + f * (-84 + f * (70 - 20 * f)))
    at = make_interp_spline(np.arange(n, dtype=float), part, k=5)(k - more * step)
    at[:HELD], at[-HELD:] = part[:HELD], part[-HELD:]
    return np.maximum.accumulate(np.clip(at, part[0], part[-1]))


@dataclass(frozen=True, eq=False)
class _Rows:
    """Rows s (n,), their joints q (n, n_joints), and the largest speed by the feed ``cap`` (n - 1,) over each step."""

    s: Array
    q: Array
    cap: Array

    @classmethod
    def at(cls, section: Section, s: Array, cycle: float) -> "_Rows":
        """The slowest of the caps at both ends and in the middle of a step counts, and where it hides the path a slower one."""
        ends = np.asarray(section.speed(s), dtype=float)
        middle = np.asarray(section.speed(0.5 * (s[1:] + s[:-1])), dtype=float)
        cap = np.minimum(np.minimum(ends[1:], ends[:-1]), middle)
        hidden = section.hidden(s)
        too_long = np.flatnonzero(hidden > 1.0)
        slower = (s[too_long + 1] - s[too_long]) / (cycle * np.minimum(hidden[too_long], tuning.HIDDEN_SHORTENING))
        cap[too_long] = np.minimum(cap[too_long], slower)
        return cls(s, joints_at(section, s), cap)

    def taken(self, rows: Ints) -> "_Rows":
        """Some rows (m,); caps between such as are no neighbours mean nothing."""
        return _Rows(self.s[rows], self.q[rows], self.cap[rows[:-1]])


def _shifted(s: Array, lengths: Ints, reach: int, section: Section, limits: Limits, cycle: float) -> _Rows:
    """Rows of stretches, laid end to end, shifted until their differences are inside the limits, or the steps are used up.

    The first and last rows of each stretch stay where they are. A step that makes a stretch worse is not taken, and the next
    one is damped more. From each step to the next a stretch is cut down to what lies around the rows still beyond a limit.
    """
    rows = _Rows.at(section, s, cycle)
    slope = _slopes(section, rows)  # shifts are small against a row's step: the slopes stay what they are
    high: Ints = np.cumsum(lengths)
    low: Ints = high - lengths
    damping = np.full(len(lengths), tuning.SHIFT_DAMPING)
    for _ in range(tuning.SHIFT_STEPS):
        owner, place = ragged(high - low)
        here = low[owner] + place
        model = _Model(rows.taken(here), slope[here], owner, limits, cycle)
        # stretches follow each other along the run, so that no row of one can hold back another's
        trial = np.clip(model.rows.s + model.shifts(damping), rows.s[low][owner], rows.s[high - 1][owner])
        np.maximum.accumulate(trial, out=trial)
        tried = _Model(_Rows.at(section, trial, cycle), slope[here], owner, limits, cycle)
        merit, after = (np.bincount(owner, one.squares(tuning.AIMED_RATIOS)) for one in (model, tried))
        left = tried.squares(tuning.ACCEPTED_RATIOS)
        better = (np.bincount(owner, left) == 0.0) | (after < merit)
        taken = better[owner]
        rows.s[here[taken]], rows.q[here[taken]] = trial[taken], tried.rows.q[taken]
        taken = taken[:-1] & (owner[1:] == owner[:-1])
        rows.cap[here[:-1][taken]] = tried.rows.cap[taken]
        damping = np.where(better, np.maximum(0.1 * damping, tuning.SHIFT_DAMPING), 100.0 * damping)
        still = np.flatnonzero(np.where(better[owner], left, model.squares(tuning.ACCEPTED_RATIOS)) > 0.0)
        if not len(still):
            break
        bad, of = here[still], owner[still]
        low, high = _stretches(bad, np.full_like(bad, reach), low[of], high[of])
        damping = damping[of[np.searchsorted(bad, low)]]
    return rows


def _slopes(section: Section, rows: _Rows) -> Array:
    """Derivatives of the joints by s (n, n_joints) at rows."""
    step = np.maximum(tuning.SLOPE_STEP * np.abs(np.gradient(rows.s)), tuning.SLOPE_LENGTH * section.length)
    step = np.where(rows.s + step > section.length, -step, step)
    return np.asarray((joints_at(section, rows.s + step) - rows.q) / step[:, None])


class _Model:
    """The differences of rows along stretches laid end to end, over their limits, linear in shifts of the rows.

    ``values[o]`` has shape (n - o, m), ``gains[o]`` (n, m) or, for the feed, by difference.
    """

    def __init__(self, rows: _Rows, slope: Array, owner: Ints, limits: Limits, cycle: float) -> None:
        self.rows, self.owner, self.n = rows, owner, len(owner)
        self.values: list[Array] = []
        self.gains: list[Array] = []
        difference = rows.q
        for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), start=1):
            difference = np.diff(difference, axis=0)
            scale = 1.0 / (limit * cycle**order)
            whole = (owner[order:] == owner[:-order])[:, None]
            self.values.append(np.where(whole, difference * scale, 0.0))
            self.gains.append(slope * scale)
        self.by_feed = np.where(owner[1:] == owner[:-1], 1.0 / (cycle * rows.cap), 0.0)
        self.feed = np.diff(rows.s) * self.by_feed
        strain = row_max(np.abs(self.gains[2]))
        self.strain = np.maximum(strain, tuning.SMALLEST_STRAIN * strain.max())
        self.weight = np.where(owner[1:] == owner[:-1], np.minimum(self.strain[1:], self.strain[:-1]), 0.0)
        self.forward = np.diff(rows.s) * self.weight
        edge = np.ones(self.n, dtype=bool)
        edge[HELD:-HELD] = owner[2 * HELD :] != owner[: -2 * HELD]
        self.edge = edge

    def squares(self, bounds: tuple[float, float, float]) -> Array:
        """Squares (n,) beyond the bounds on velocity and feed, acceleration, and jerk, of differences that begin at each row."""
        total = np.zeros(self.n)
        total[:-1] = np.maximum(self.feed - bounds[0], 0.0) ** 2
        for order, values in enumerate(self.values, start=1):
            total[:-order] += row_sum(np.maximum(np.abs(values) - bounds[order - 1], 0.0) ** 2)
        return total

    def shifts(self, damping: Array) -> Array:
        """Shifts (n,) that bring everything inside in the linear model, damped by stretch."""
        n = self.n
        fixed = np.zeros((4, n))
        damped = damping[self.owner[: n - 3]] * self.strain[: n - 3] ** 2
        damped[self.owner[3:] != self.owner[:-3]] = 0.0
        third = _DIFFERENCES[2]
        for i in range(4):
            for k in range(i, 4):
                fixed[k - i, i : n - 3 + i] += third[i] * third[k] * damped
        fixed[0] += damping[self.owner] * self.strain**2 * tuning.SMALLEST_STRAIN
        fixed[0, self.edge] = tuning.FIXED_DIAGONAL
        change = np.zeros(n)
        for _ in range(tuning.ACTIVE_SET_STEPS):
            band, rhs = fixed.copy(order="F"), np.zeros(n)
            for order, (values, gains) in enumerate(zip(self.values, self.gains, strict=True), start=1):
                predicted = values.copy()
                moved = gains * change[:, None]
                for i, c in enumerate(_DIFFERENCES[order - 1]):
                    predicted += c * moved[i : n - order + i]
                rows, joints = np.nonzero(np.abs(predicted) > tuning.AIMED_RATIOS[order - 1])
                sign = np.sign(predicted[rows, joints])
                excess_now = sign * values[rows, joints] - tuning.AIMED_RATIOS[order - 1]
                slopes = [c * sign * gains[rows + i, joints] for i, c in enumerate(_DIFFERENCES[order - 1])]
                _add(band, rhs, rows, slopes, excess_now)
            rows = np.flatnonzero(self.feed + self.by_feed * np.diff(change) > tuning.AIMED_RATIOS[0])
            _add(band, rhs, rows, [-self.by_feed[rows], self.by_feed[rows]], self.feed[rows] - tuning.AIMED_RATIOS[0])
            # rows never run backwards
            rows = np.flatnonzero(self.forward + self.weight * np.diff(change) < 0)
            weight = self.weight[rows]
            _add(band, rhs, rows, [weight, -weight], -self.forward[rows])
            rhs[self.edge] = 0.0
            factor, info = _PBTRF(band, lower=1, overwrite_ab=1)
            if info != 0:
                break
            solution, _info = _PBTRS(factor, rhs, lower=1)
            change = solution.reshape(-1)
            change[self.edge] = 0.0
        return change if np.isfinite(change).all() else np.zeros(n)


def _add(band: Array, rhs: Array, rows: Ints, slopes: list[Array], exceeding: Array) -> None:
    """Add differences that begin at ``rows`` and are ``exceeding`` their aims to the normal equations."""
    n = len(rhs)
    for i, slope in enumerate(slopes):
        rhs -= np.bincount(rows + i, slope * exceeding, minlength=n)
        for k in range(i, len(slopes)):
            band[k - i] += np.bincount(rows + i, slope * slopes[k], minlength=n)
