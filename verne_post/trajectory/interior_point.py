"""The jerk-limited profile in pseudo-time: a banded interior point method.

A first profile s(sigma) is given, sigma being nearly time. Sought is X(sigma) = (dsigma/dt)^2, near 1, which
re-times it. With Q the joints as functions of sigma, and ' = d/dsigma, the joints' motion in real time is

    speed  |Q'| X^(1/2),   acceleration  Q'' X + Q' X'/2,   jerk  X^(1/2) (Q''' X + 3/2 Q'' X' + Q' X''/2).

X is a uniform cubic B-spline; the time, the integral of X^(-1/2), is minimised subject to the limits at the
points of a grid. Every constraint depends on (X, X', X'') at one point only, so the normal equations have
half-bandwidth 3 whatever the number of joints. Primal-dual steps with Mehrotra's predictor and corrector.
"""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.base.lapack import pbtrf, pbtrs
from verne_post.trajectory import tuning

#: Constraints, row by row, in single precision. Memory traffic is the cost of an iteration, and 1e-7 of a limit is far
#: below the accuracy that a constraint needs. Coefficients, normal matrix and points are in double precision.
Rows = NDArray[np.float32]


class Problem(Struct, frozen=True, eq=False):
    """Windows of pseudo-time laid end to end: n knot intervals with k points each.

    Point arrays are ordered by phase, then by interval: point p of interval i stands at
    ``(i + phases[p]) * knot`` and has index ``p * n + i``.
    """

    knot: float  #: Knot spacing, s of pseudo-time.
    phases: Array  #: (k,): Positions of the points in an interval, 0 to 1.
    cap: Array  #: (k n,): Largest X, from speeds and feed.
    acceleration: tuple[Array, ...]  #: (a, k n) each: Rows g with ``g0 X + g1 X' <= 1``.
    jerk: tuple[Array, ...]  #: (j, k n) each: Rows g with ``g0 X + g1 X' + g2 X'' <= X^(-1/2)``.
    held_coefficients: NDArray[np.bool_]  #: (n + 3,): Coefficients that stay what they are at the start.


def build_basis(knot: float, fraction: Array) -> Array:
    """The four cubic B-splines on an interval, and their first two derivatives: (3, len, 4)."""
    f = fraction
    value = np.stack([(1 - f) ** 3, 3 * f**3 - 6 * f**2 + 4, -3 * f**3 + 3 * f**2 + 3 * f + 1, f**3], axis=-1) / 6
    slope = np.stack([-((1 - f) ** 2), 3 * f**2 - 4 * f, -3 * f**2 + 2 * f + 1, f**2], axis=-1) / (2 * knot)
    bend = np.stack([1 - f, 3 * f - 2, -3 * f + 1, f], axis=-1) / knot**2
    return np.stack([value, slope, bend])


class Solution(Struct, frozen=True, eq=False):
    """Coefficients of X (n + 3,), the iterations made, and whether all limits hold at the points."""

    coefficients: Array
    iterations: int
    legal: bool


def solve(problem: Problem, start: Array, *, start_gap: float, final_gap: float, iterations: int) -> Solution:
    """Minimise the time.

    Parameters
    ----------
    start : ndarray, shape (n + 3,)
        Coefficients to start from, positive; they need not keep the limits.
    start_gap : float
        Sum of slack times multiplier to start from, over the time.
    final_gap : float
        The same sum at which the iteration ends.
    iterations : int
        At most so many.

    Returns
    -------
    Solution
        Always with positive coefficients; beyond limits where the iteration was cut short.
    """
    return _Iteration(problem).iterate(start, start_gap, final_gap, iterations)


class _Iteration:
    """The constraints of a problem, row by row and point by point, and steps on them.

    Constraint arrays have shape (2 + a + j, points): X below its cap, X above its floor, acceleration, jerk.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.n = len(problem.cap) // len(problem.phases)
        self.points = len(problem.cap)
        self.weight = problem.knot / len(problem.phases)
        table = build_basis(problem.knot, problem.phases)
        self.to_points = np.ascontiguousarray(table.reshape(-1, 4))
        self.to_coefficients = np.ascontiguousarray(self.to_points.T)
        self.band_weights = _assemble_band(table)
        self.cap = problem.cap.astype(np.float32)
        self.acc, self.jerk = (
            [row.astype(np.float32) for row in rows] for rows in (problem.acceleration, problem.jerk)
        )
        self.a = slice(2, 2 + len(self.acc[0]))
        self.j = slice(self.a.stop, self.a.stop + len(self.jerk[0]))
        shape = (self.j.stop, self.points)
        self.count = self.j.stop * self.points
        self._slack_now, self._inverse, self._ratio, self._push, self._work = (
            np.empty(shape, np.float32) for _ in range(5)
        )
        self._d_slack, self._d_dual, self._target = (np.empty(shape, np.float32) for _ in range(3))
        self._j_work = np.empty_like(self.jerk[0])
        self._j_gradient = np.empty_like(self.jerk[0])
        self._a_work = np.empty_like(self.acc[0])

    def evaluate_at_points(self, c: Array) -> Array:
        """(X, X', X'') at the points, shape (3, points)."""
        shifted = np.stack([c[k : k + self.n] for k in range(4)])
        return _multiply(self.to_points, shifted).reshape(3, -1)

    def gather_coefficients(self, y: Array) -> Array:
        """Transposed map: (3, points) to coefficients."""
        local = _multiply(self.to_coefficients, y.reshape(-1, self.n))
        c = np.zeros(self.n + 3)
        for k in range(4):
            c[k : k + self.n] += local[k]
        return c

    def _find_changes(self, out: Rows, points: Array, root_at_points: Array) -> Rows:
        """Slacks without their constant parts: the rows' negative values, plus the root on the jerk rows."""
        y, root = points.astype(np.float32), root_at_points.astype(np.float32)
        out[0] = -y[0]
        out[1] = y[0]
        acc, jerk = out[self.a], out[self.j]
        np.multiply(self.acc[0], y[0], out=acc)
        acc += np.multiply(self.acc[1], y[1], out=self._a_work)
        np.negative(acc, out=acc)
        np.multiply(self.jerk[0], y[0], out=jerk)
        jerk += np.multiply(self.jerk[1], y[1], out=self._j_work)
        jerk += np.multiply(self.jerk[2], y[2], out=self._j_work)
        np.subtract(root, jerk, out=jerk)
        return out

    def find_slacks(self, y: Array, out: Rows) -> Rows:
        """How far each constraint is from its limit."""
        self._find_changes(out, y, 1.0 / np.sqrt(np.maximum(y[0], tuning.SMALLEST_X)))
        out[0] += self.cap
        out[1] -= tuning.SMALLEST_X
        out[self.a] += 1.0
        return out

    def factorise(self, root_bend: Array, ratio: Rows, dual: Rows) -> Array | None:
        """Cholesky factor of the normal matrix; ``root_bend`` is (X^(-1/2))''. None where rounding has spoilt it."""
        w_acc, w_jerk = ratio[self.a], ratio[self.j]
        g0, (_j0, j1, j2) = self._j_gradient, self.jerk
        local = np.empty((6, self.points))
        work = self._a_work
        np.multiply(w_acc, self.acc[0], out=work)
        local[0] = _sum_products(work, self.acc[0])
        local[1] = _sum_products(work, self.acc[1])
        local[3] = _sum_products(np.multiply(w_acc, self.acc[1], out=work), self.acc[1])
        work = self._j_work
        np.multiply(w_jerk, g0, out=work)
        local[0] += _sum_products(work, g0)
        local[1] += _sum_products(work, j1)
        local[2] = _sum_products(work, j2)
        np.multiply(w_jerk, j1, out=work)
        local[3] += _sum_products(work, j1)
        local[4] = _sum_products(work, j2)
        local[5] = _sum_products(np.multiply(w_jerk, j2, out=work), j2)
        # the jerk constraints bend the other way than the objective; a share of its curvature always stays
        bend = np.maximum(self.weight - dual[self.j].sum(axis=0), tuning.LEAST_CURVATURE * self.weight)
        bend *= root_bend
        local[0] += bend
        local[0] += ratio[0] + ratio[1]
        parts = _multiply(self.band_weights, local.reshape(-1, self.n))
        band = np.zeros((4, self.n + 3), order="F")
        row = 0
        for i in range(4):
            for k in range(i, 4):
                band[k - i, i : i + self.n] += parts[row]
                row += 1
        band[0, self.problem.held_coefficients] = tuning.FIXED_DIAGONAL
        factor, info = pbtrf(band, lower=1, overwrite_ab=1)
        return factor if info == 0 and np.isfinite(factor[0]).all() else None

    def find_direction(self, root_slope: Array, factor: Array, push: Rows) -> Array:
        """Change of the coefficients for weights ``push`` on the gradients of the slacks; may be not finite."""
        jerk = push[self.j]
        pull = np.empty((3, self.points))
        acc = push[self.a]
        pull[0] = -self.weight * root_slope
        pull[0] += push[1] - push[0] - _sum_products(acc, self.acc[0]) - _sum_products(jerk, self._j_gradient)
        pull[1] = -_sum_products(acc, self.acc[1]) - _sum_products(jerk, self.jerk[1])
        pull[2] = -_sum_products(jerk, self.jerk[2])
        rhs = self.gather_coefficients(pull)
        rhs[self.problem.held_coefficients] = 0.0
        change, _info = pbtrs(factor, rhs, lower=1)
        change = change.reshape(-1)
        change[self.problem.held_coefficients] = 0.0
        return change

    @np.errstate(over="ignore", invalid="ignore")
    def iterate(self, start: Array, start_gap: float, final_gap: float, iterations: int) -> Solution:
        """The iteration itself; see :func:`solve`. Where numbers overflow it ends with what it has."""
        c = start.copy()
        y = self.evaluate_at_points(c)
        now = self.find_slacks(y, self._slack_now)
        slack: Rows = np.maximum(now, np.float32(tuning.START_SLACK))
        dual: Rows = np.float32(start_gap * self.weight * self.points / self.count) / slack
        done, legal, blocked = 0, False, False
        inverse, ratio, work, target = self._inverse, self._ratio, self._work, self._target
        d_slack, d_dual = self._d_slack, self._d_dual
        while True:
            root = 1.0 / np.sqrt(np.maximum(y[0], tuning.SMALLEST_X))
            infeasible = np.subtract(now, slack, out=now)
            complementarity = _multiply_and_sum(slack, dual)
            objective = self.weight * float(root.sum())
            legal = float(infeasible.min()) > -tuning.ACCEPTED_INFEASIBILITY
            if (legal and complementarity < final_gap * objective) or done == iterations:
                break
            done += 1
            inverse_x = root * root
            root_slope = -0.5 * inverse_x * root
            np.subtract(self.jerk[0], root_slope.astype(np.float32), out=self._j_gradient)
            np.divide(1.0, slack, out=inverse)
            np.multiply(dual, inverse, out=ratio)
            factor = self.factorise(-1.5 * inverse_x * root_slope, ratio, dual)
            if factor is None:
                break
            # predictor: towards complementarity zero; relative to what there is, slacks change by r and duals by -1 - r
            settled = np.multiply(ratio, infeasible, out=work)
            push = np.negative(settled, out=self._push)
            change = self.find_direction(root_slope, factor, push)
            dy = self.evaluate_at_points(change)
            relative = self._find_changes(d_slack, dy, root_slope * dy[0])
            relative += infeasible
            relative *= inverse
            step_p = _step(-float(relative.min()))
            step_d = _step(1.0 + float(relative.max()))
            np.multiply(dual, slack, out=target)
            moved = _multiply_and_sum(target, relative)
            relative_squared = np.multiply(relative, relative, out=d_dual)
            cross = -_multiply_and_sum(target, relative_squared) - moved
            affine = complementarity + step_p * moved - step_d * (complementarity + moved) + step_p * step_d * cross
            share = abs(affine / complementarity) ** 3
            if blocked:
                share = max(share, tuning.RECENTRE)
            mu = share * complementarity / self.count
            # corrector: the product of both changes is -dual slack r (1 + r)
            np.add(relative, relative_squared, out=target)
            target *= dual
            target += np.multiply(np.float32(mu), inverse, out=push)
            np.subtract(target, settled, out=push)
            change = self.find_direction(root_slope, factor, push)
            if not np.isfinite(change).all():
                break
            dy = self.evaluate_at_points(change)
            self._find_changes(d_slack, dy, root_slope * dy[0])
            d_slack += infeasible
            np.multiply(ratio, d_slack, out=d_dual)
            np.subtract(target, d_dual, out=d_dual)
            d_dual -= dual
            step_p = min(tuning.TO_BOUNDARY * _step(-float(np.multiply(d_slack, inverse, out=target).min())), 1.0)
            step_d = min(tuning.TO_BOUNDARY * _step(-float(np.divide(d_dual, dual, out=target).min())), 1.0)
            if step_p < tuning.STUCK_STEP:
                break
            c += step_p * change
            y = self.evaluate_at_points(c)
            blocked = min(step_p, step_d) < tuning.SHORT_STEP
            d_slack *= step_p
            slack += d_slack
            now = self.find_slacks(y, self._slack_now)
            # a slack that the nonlinear constraint exceeds is simply taken over
            np.maximum(slack, now, out=slack)
            d_dual *= step_d
            dual += d_dual
        return Solution(np.maximum(c, tuning.SMALLEST_X), done, legal)


def _sum_products(a: Rows, b: Rows) -> Rows:
    """Sum over rows of the product of (r, points) arrays."""
    return np.einsum("rp,rp->p", a, b)


def _multiply_and_sum(a: Rows, b: Rows) -> float:
    """Sum of products of two matrices; not by BLAS, whose threads only wait for each other here."""
    return float(np.einsum("rp,rp->", a, b))


def _multiply(a: Array, b: Array) -> Array:
    """Product of a small matrix and a wide one, in segments that BLAS does not spread over threads."""
    out = np.empty((len(a), b.shape[1]))
    width = max(tuning.BLAS_WORK // a.size, 1)
    for first in range(0, b.shape[1], width):
        np.matmul(a, b[:, first : first + width], out=out[:, first : first + width])
    return out


def _step(loss: float) -> float:
    """Largest step, up to 1 / tuning.TO_BOUNDARY, that keeps values positive; ``loss`` is the largest relative loss."""
    return 1.0 / max(tuning.TO_BOUNDARY, loss)


def _assemble_band(table: Array) -> Array:
    """Local symmetric matrices (6 entries, k points) -> entries of the band: shape (10, 6 k)."""
    value, slope, bend = table  # each (k, 4)
    rows = [
        np.concatenate(
            [
                value[:, i] * value[:, k],
                value[:, i] * slope[:, k] + slope[:, i] * value[:, k],
                value[:, i] * bend[:, k] + bend[:, i] * value[:, k],
                slope[:, i] * slope[:, k],
                slope[:, i] * bend[:, k] + bend[:, i] * slope[:, k],
                bend[:, i] * bend[:, k],
            ]
        )
        for i in range(4)
        for k in range(i, 4)
    ]
    return np.ascontiguousarray(np.stack(rows))
