"""Small shifts of rows along the path that bring their differences inside the limits.

Least squares on the excess, damped by the jerk that the shifts make, one banded solution a step.
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, find_used
from verne_post.base.lapack import pbtrf, pbtrs
from verne_post.base.ragged import number_parts
from verne_post.base.rows import find_row_max
from verne_post.trajectory import tuning
from verne_post.trajectory.row_limits import REST_ROWS, JointRows
from verne_post.trajectory.section_path import Section, SectionTask, find_finite_joints

#: Rows that stay at the ends of a stretch: what differences across the end are taken from, and the section's ends.
HELD_ROWS: Final = REST_ROWS + 1
#: The derivative by s is a difference over this share of a row's step, over which it hardly changes, and over at least
#: this share of the section's length, far above rounding.
SLOPE_STEP: Final = 1e-2
SLOPE_LENGTH: Final = 1e-9
#: First, second and third difference of rows, with zeros behind for the rows that they do not reach.
_DIFFERENCES: Final = np.array([[-1.0, 1.0, 0.0, 0.0], [1.0, -2.0, 1.0, 0.0], [-1.0, 3.0, -3.0, 1.0]])
#: The rows of a difference, counted from its first one, and the pairs of them that normal equations have.
_REACHED: Final = np.arange(_DIFFERENCES.shape[1])
_FIRST, _SECOND = np.triu_indices(len(_REACHED))


def shift_rows(s: Array, lengths: Ints, reach: int, task: SectionTask) -> JointRows:
    """Rows of stretches, laid end to end, shifted until their differences are inside the limits or the steps used up.

    Stretches may be anywhere in the section, and several may have the same part of it. The first and last rows of each
    stretch stay where they are. A step that makes a stretch worse is not taken, and the next one is damped more, until
    it would shift hardly anything: then the stretch stays as it is. After each step a stretch is cut down to the
    surroundings of the rows that are still beyond a limit.
    """
    rows = JointRows.build(task, s)
    slope = _find_slopes(task.section, rows)  # shifts are small against a row's step: the slopes stay what they are
    high: Ints = np.cumsum(lengths)
    low: Ints = high - lengths
    damping = np.full(len(lengths), tuning.SHIFT_DAMPING)
    model = None
    for _ in range(tuning.SHIFT_STEPS):
        if model is None:
            owner, place = number_parts(high - low)
            here = low[owner] + place
            model = _LinearModel(rows.select(here), slope[here], owner, task)
        trial = np.clip(model.rows.s + model.solve_shifts(damping), rows.s[low][owner], rows.s[high - 1][owner])
        _keep_rising(trial, owner)
        tried = _LinearModel(JointRows.build(task, trial), model.slope, owner, task)
        merit, after = (np.bincount(owner, one.sum_squares(tuning.AIMED_RATIOS)) for one in (model, tried))
        left = tried.sum_squares(tuning.ACCEPTED_RATIOS)
        better = (np.bincount(owner, left) == 0.0) | (after < merit)
        taken = better[owner]
        rows.s[here[taken]], rows.q[here[taken]] = trial[taken], tried.rows.q[taken]
        within = taken[:-1] & (owner[1:] == owner[:-1])
        rows.cap[here[:-1][within]] = tried.rows.cap[within]
        damping = np.where(better, np.maximum(0.1 * damping, tuning.SHIFT_DAMPING), 100.0 * damping)
        beyond = np.where(taken, left, model.sum_squares(tuning.ACCEPTED_RATIOS)) > 0.0
        still = np.flatnonzero(beyond & (damping <= tuning.LARGEST_DAMPING)[owner])
        if not len(still):
            break
        bad, of = here[still], owner[still]
        before, (low, high) = (low, high), join_stretches(bad, np.full_like(bad, reach), low[of], high[of])
        damping = damping[of[np.searchsorted(bad, low)]]
        # the model that there is stays the right one while no stretch is cut, and all or none took the step
        if not np.array_equal((low, high), before) or better.any() != better.all():
            model = None
        elif better.all():
            model = tried
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

    ``values`` (3, n, n_joints) are the differences of each order that begin at a row, 0 where they reach beyond its
    stretch. They are linear in ``gains`` (n + 3, n_joints), by order times ``scale`` (3, n_joints).
    """

    def __init__(self, rows: JointRows, slope: Array, owner: Ints, task: SectionTask) -> None:
        self.rows, self.slope, self.owner, self.n = rows, slope, owner, len(owner)
        limits = np.stack([task.limits.velocity, task.limits.acceleration, task.limits.jerk])
        self.scale = 1.0 / (limits * task.cycle ** np.arange(1.0, len(limits) + 1)[:, None])
        self.gains = np.append(slope, np.zeros((REST_ROWS, slope.shape[1])), axis=0)
        ends = np.flatnonzero(owner[1:] != owner[:-1])
        self.values = np.zeros((len(limits), *rows.q.shape))
        _add_differences(self.values, rows.q, self.scale)
        for order in range(len(limits)):
            for back in range(order + 1):
                self.values[order, ends - back] = 0.0
        self.by_feed = 1.0 / (task.cycle * rows.cap)
        strain = find_row_max(np.abs(slope * self.scale[2]))
        self.strain = np.maximum(strain, tuning.SMALLEST_STRAIN * strain.max())
        self.weight = np.minimum(self.strain[1:], self.strain[:-1])
        self.by_feed[ends] = self.weight[ends] = 0.0
        way = np.diff(rows.s)
        self.feed, self.forward = way * self.by_feed, way * self.weight
        edge = np.ones(self.n, dtype=bool)
        edge[HELD_ROWS:-HELD_ROWS] = owner[2 * HELD_ROWS :] != owner[: -2 * HELD_ROWS]
        self.edge = edge

    def sum_squares(self, bounds: tuple[float, float, float]) -> Array:
        """Squares (n,) beyond the bounds on feed, acceleration and jerk, of differences that begin at each row."""
        beyond = np.maximum(np.abs(self.values) - np.array(bounds)[:, None, None], 0.0)
        total = np.einsum("onj,onj->n", beyond, beyond)
        total[:-1] += np.maximum(self.feed - bounds[0], 0.0) ** 2
        return np.asarray(total)

    def solve_shifts(self, damping: Array) -> Array:
        """Shifts (n,) that bring everything inside in the linear model, damped by stretch."""
        n = self.n
        damped = damping[self.owner[: n - REST_ROWS]] * self.strain[: n - REST_ROWS] ** 2
        damped[self.owner[REST_ROWS:] != self.owner[:-REST_ROWS]] = 0.0
        whole = np.arange(n - REST_ROWS)
        fixed, _none = _build_normal_equations(
            n, whole, _DIFFERENCES[2][:, None] * np.sqrt(damped), np.zeros(len(whole))
        )
        fixed[0] += damping[self.owner] * self.strain**2 * tuning.SMALLEST_STRAIN
        fixed[0, self.edge] = tuning.FIXED_DIAGONAL
        aims = np.array(tuning.AIMED_RATIOS)
        change, active = np.zeros(n), None
        for _ in range(tuning.ACTIVE_SET_STEPS):
            predicted = self.values.copy()
            _add_differences(predicted, self.gains[:n] * change[:, None], self.scale)
            steps = np.diff(change)
            before, active = (
                active,
                (
                    np.flatnonzero(np.abs(predicted) > aims[:, None, None]),
                    np.flatnonzero(self.feed + self.by_feed * steps > aims[0]),
                    np.flatnonzero(self.forward + self.weight * steps < 0.0),  # rows never go backwards
                ),
            )
            if before is not None and all(map(np.array_equal, before, active)):
                break
            over, fast, back = active
            order, place = np.divmod(over, n * self.gains.shape[1])
            row, joint = np.divmod(place, self.gains.shape[1])
            sign = np.sign(predicted.ravel()[over])
            reached = self.gains.ravel()[place + self.gains.shape[1] * _REACHED[:, None]]
            slopes = _DIFFERENCES.T[:, order] * (sign * self.scale[order, joint]) * reached
            steps = np.zeros((len(_REACHED), len(fast) + len(back)))
            steps[1] = np.append(self.by_feed[fast], -self.weight[back])
            steps[0] = -steps[1]
            band, rhs = _build_normal_equations(
                n,
                np.concatenate([row, fast, back]),
                np.append(slopes, steps, axis=1),
                np.concatenate(
                    [sign * self.values.ravel()[over] - aims[order], self.feed[fast] - aims[0], -self.forward[back]]
                ),
            )
            rhs[self.edge] = 0.0
            factor, info = pbtrf(np.asfortranarray(band + fixed), lower=1, overwrite_ab=1)
            if info != 0:
                break
            solution, _info = pbtrs(factor, rhs, lower=1)
            change = solution.reshape(-1)
            change[self.edge] = 0.0
        return change if np.isfinite(change).all() else np.zeros(n)


def _add_differences(total: Array, rows: Array, scale: Array) -> None:
    """Add the differences of rows (n, n_joints), of each order times its scale, to ``total`` (3, n, n_joints)."""
    for order, factor in enumerate(scale, start=1):
        rows = rows[1:] - rows[:-1]
        total[order - 1, :-order] += rows * factor


def _build_normal_equations(n: int, first: Ints, slopes: Array, excess: Array) -> tuple[Array, Array]:
    """Band (4, n) and right side (n,) of the least squares of differences (m,) that begin at rows ``first``.

    ``slopes`` (4, m) are their derivatives by the shifts of the rows that they reach, 0 behind the last row.
    """
    rows, length = first + _REACHED[:, None], n + REST_ROWS
    rhs = np.bincount(rows.ravel(), (slopes * -excess).ravel(), minlength=length).astype(float, copy=False)
    place = rows[_FIRST] + length * (_SECOND - _FIRST)[:, None]
    products = slopes[_FIRST] * slopes[_SECOND]
    band = np.bincount(place.ravel(), products.ravel(), minlength=len(_REACHED) * length).astype(float, copy=False)
    return band.reshape(len(_REACHED), length)[:, :n], rhs[:n]
