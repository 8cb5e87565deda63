"""Small shifts of rows along the path that bring their differences inside the limits.

Least squares on the excess, damped by the jerk that the shifts make, one banded solution a step.
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, find_used
from verne_post.base.lapack import pbtrf, pbtrs
from verne_post.base.ragged import number_parts
from verne_post.base.rows import find_row_max, sum_rows
from verne_post.trajectory import tuning
from verne_post.trajectory.row_limits import REST_ROWS, JointRows
from verne_post.trajectory.section_path import Section, SectionTask, find_finite_joints

#: Rows that stay at the ends of a stretch: what differences across the end are taken from, and the section's ends.
HELD_ROWS: Final = REST_ROWS + 1
#: The derivative by s is a difference over this share of a row's step, over which it hardly changes, and over at least
#: this share of the section's length, far above rounding.
SLOPE_STEP: Final = 1e-2
SLOPE_LENGTH: Final = 1e-9
_DIFFERENCES: Final = ((-1.0, 1.0), (1.0, -2.0, 1.0), (-1.0, 3.0, -3.0, 1.0))


def shift_rows(s: Array, lengths: Ints, reach: int, task: SectionTask) -> JointRows:
    """Rows of stretches, laid end to end, shifted until their differences are inside the limits or the steps used up.

    Stretches may be anywhere in the section, and several may have the same part of it. The first and last rows of each
    stretch stay where they are. A step that makes a stretch worse is not taken, and the next one is damped more. After
    each step a stretch is cut down to the surroundings of the rows that are still beyond a limit.
    """
    rows = JointRows.build(task, s)
    slope = _find_slopes(task.section, rows)  # shifts are small against a row's step: the slopes stay what they are
    high: Ints = np.cumsum(lengths)
    low: Ints = high - lengths
    damping = np.full(len(lengths), tuning.SHIFT_DAMPING)
    for _ in range(tuning.SHIFT_STEPS):
        owner, place = number_parts(high - low)
        here = low[owner] + place
        model = _LinearModel(rows.select(here), slope[here], owner, task)
        trial = np.clip(model.rows.s + model.solve_shifts(damping), rows.s[low][owner], rows.s[high - 1][owner])
        _keep_rising(trial, owner)
        tried = _LinearModel(JointRows.build(task, trial), slope[here], owner, task)
        merit, after = (np.bincount(owner, one.sum_squares(tuning.AIMED_RATIOS)) for one in (model, tried))
        left = tried.sum_squares(tuning.ACCEPTED_RATIOS)
        better = (np.bincount(owner, left) == 0.0) | (after < merit)
        taken = better[owner]
        rows.s[here[taken]], rows.q[here[taken]] = trial[taken], tried.rows.q[taken]
        taken = taken[:-1] & (owner[1:] == owner[:-1])
        rows.cap[here[:-1][taken]] = tried.rows.cap[taken]
        damping = np.where(better, np.maximum(0.1 * damping, tuning.SHIFT_DAMPING), 100.0 * damping)
        still = np.flatnonzero(np.where(better[owner], left, model.sum_squares(tuning.ACCEPTED_RATIOS)) > 0.0)
        if not len(still):
            break
        bad, of = here[still], owner[still]
        low, high = join_stretches(bad, np.full_like(bad, reach), low[of], high[of])
        damping = damping[of[np.searchsorted(bad, low)]]
    return rows


def join_stretches(bad: Ints, width: Ints, lowest: Ints, highest: Ints) -> tuple[Ints, Ints]:
    """Where stretches of so many rows (m,) on each side of rows ``bad`` (m,) begin and end; those that touch are one.

    They stay inside [lowest, highest) of each (m,), and those of different bounds stay apart.
    """
    low = np.minimum.accumulate(np.maximum(bad - width, lowest)[::-1])[::-1]
    high = np.maximum.accumulate(np.minimum(bad + REST_ROWS + 1 + width, highest))
    gaps = np.flatnonzero((low[1:] > high[:-1] + HELD_ROWS) | (lowest[1:] != lowest[:-1]))
    return low[np.append(0, gaps + 1)], high[np.append(gaps, len(bad) - 1)]


def _keep_rising(s: Array, owner: Ints) -> None:
    """Make rows s (n,) of stretches, which are in order, the largest of their stretch so far."""
    back = np.flatnonzero((s[1:] < s[:-1]) & (owner[1:] == owner[:-1]))
    for stretch in find_used(owner[back]):
        rows = slice(*np.searchsorted(owner, [stretch, stretch + 1]))
        np.maximum.accumulate(s[rows], out=s[rows])


def _find_slopes(section: Section, rows: JointRows) -> Array:
    """Derivatives of the joints by s (n, n_joints) at rows."""
    step = np.maximum(SLOPE_STEP * np.abs(np.gradient(rows.s)), SLOPE_LENGTH * section.length)
    step = np.where(rows.s + step > section.length, -step, step)
    return np.asarray((find_finite_joints(section, rows.s + step) - rows.q) / step[:, None])


class _LinearModel:
    """The differences of rows along stretches laid end to end, over their limits, linear in shifts of the rows.

    ``values[o]`` has shape (n - o, m), ``gains[o]`` (n, m) or, for the feed, by difference.
    """

    def __init__(self, rows: JointRows, slope: Array, owner: Ints, task: SectionTask) -> None:
        self.rows, self.owner, self.n = rows, owner, len(owner)
        self.values: list[Array] = []
        self.gains: list[Array] = []
        difference = rows.q
        for order, limit in enumerate((task.limits.velocity, task.limits.acceleration, task.limits.jerk), start=1):
            difference = np.diff(difference, axis=0)
            scale = 1.0 / (limit * task.cycle**order)
            whole = (owner[order:] == owner[:-order])[:, None]
            self.values.append(np.where(whole, difference * scale, 0.0))
            self.gains.append(slope * scale)
        self.by_feed = np.where(owner[1:] == owner[:-1], 1.0 / (task.cycle * rows.cap), 0.0)
        self.feed = np.diff(rows.s) * self.by_feed
        strain = find_row_max(np.abs(self.gains[2]))
        self.strain = np.maximum(strain, tuning.SMALLEST_STRAIN * strain.max())
        self.weight = np.where(owner[1:] == owner[:-1], np.minimum(self.strain[1:], self.strain[:-1]), 0.0)
        self.forward = np.diff(rows.s) * self.weight
        edge = np.ones(self.n, dtype=bool)
        edge[HELD_ROWS:-HELD_ROWS] = owner[2 * HELD_ROWS :] != owner[: -2 * HELD_ROWS]
        self.edge = edge

    def sum_squares(self, bounds: tuple[float, float, float]) -> Array:
        """Squares (n,) beyond the bounds on feed, acceleration and jerk, of differences that begin at each row."""
        total = np.zeros(self.n)
        total[:-1] = np.maximum(self.feed - bounds[0], 0.0) ** 2
        for order, values in enumerate(self.values, start=1):
            total[:-order] += sum_rows(np.maximum(np.abs(values) - bounds[order - 1], 0.0) ** 2)
        return total

    def solve_shifts(self, damping: Array) -> Array:
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
                _add_to_normal_equations(band, rhs, rows, slopes, excess_now)
            rows = np.flatnonzero(self.feed + self.by_feed * np.diff(change) > tuning.AIMED_RATIOS[0])
            _add_to_normal_equations(
                band, rhs, rows, [-self.by_feed[rows], self.by_feed[rows]], self.feed[rows] - tuning.AIMED_RATIOS[0]
            )
            # rows never go backwards
            rows = np.flatnonzero(self.forward + self.weight * np.diff(change) < 0)
            weight = self.weight[rows]
            _add_to_normal_equations(band, rhs, rows, [weight, -weight], -self.forward[rows])
            rhs[self.edge] = 0.0
            factor, info = pbtrf(band, lower=1, overwrite_ab=1)
            if info != 0:
                break
            solution, _info = pbtrs(factor, rhs, lower=1)
            change = solution.reshape(-1)
            change[self.edge] = 0.0
        return change if np.isfinite(change).all() else np.zeros(n)


def _add_to_normal_equations(band: Array, rhs: Array, rows: Ints, slopes: list[Array], exceeding: Array) -> None:
    """Add differences that begin at ``rows`` and are ``exceeding`` their aims to the normal equations."""
    n = len(rhs)
    for i, slope in enumerate(slopes):
        rhs -= np.bincount(rows + i, slope * exceeding, minlength=n)
        for k in range(i, len(slopes)):
            band[k - i] += np.bincount(rows + i, slope * slopes[k], minlength=n)
