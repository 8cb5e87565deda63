"""Profiles s(sigma) from rest to rest as uniform quintic B-splines, and the change from one pseudo-time to the next."""

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.columns import Growing, GrowingTable, iterate_blocks, release_memory
from verne_post.base.lapack import pbtrf, pbtrs
from verne_post.base.team import ALONE, Team, split_evenly
from verne_post.trajectory import tuning
from verne_post.trajectory.interior_point import build_basis

#: Resting samples at both ends of a profile: a quintic spline begins and ends with all derivatives zero.
_REST: Final = 6
#: Samples beside a part that its spline is solved with: the last one counts for 0.43 to this power, less than rounding.
_OVERLAP: Final = 64
_GAUSS, _GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)


def _build_quintic_segments() -> Array:
    """Monomial coefficients (6 powers, 6 splines) of the uniform quintic B-splines on one interval."""
    segment = {0: np.array([1.0])}  # spline k of the degree on the interval 0..1, by k from left to right
    for degree in range(1, 6):
        grown = {}
        for k in range(degree + 1):
            total = np.zeros(degree + 1)
            if k in segment:  # falling part
                total[:degree] += (1.0 + k) / degree * segment[k]
                total[1 : degree + 1] -= segment[k] / degree
            if k - 1 in segment:  # rising part
                total[:degree] += (degree - k) / degree * segment[k - 1]
                total[1 : degree + 1] += segment[k - 1] / degree
            grown[k] = total
        segment = grown
    return np.stack([segment[k] for k in range(6)], axis=1)


_SEGMENTS: Final = _build_quintic_segments()


class Profile(Struct, frozen=True, eq=False):
    """s(sigma) over [0, duration], at rest outside.

    ``coefficients`` are those of a uniform quintic B-spline with knots ``step`` apart.
    """

    coefficients: Array
    step: float

    @classmethod
    def build_from_samples(cls, samples: Array, step: float) -> "Profile":
        """Use samples from rest to rest as coefficients: monotone samples give a monotone profile."""
        coefficients = Growing(float)
        coefficients.copy(samples, _REST, _REST)
        return cls(coefficients.freeze(), step)

    @classmethod
    def interpolate(cls, samples: Array, step: float) -> "Profile":
        """Interpolate samples from rest to rest.

        What a sample adds to the coefficients around it falls by more than half from each to the next, so that long
        profiles are solved part by part, with samples on both sides that are given up.
        """
        n = len(samples) + 2 * _REST
        coefficients = Growing(float)
        for first in range(0, n, tuning.AT_A_TIME):
            release_memory()
            last = min(first + tuning.AT_A_TIME, n)
            low, high = max(first - _OVERLAP, 0), min(last + _OVERLAP, n)
            values = samples[np.clip(np.arange(low, high) - _REST, 0, len(samples) - 1)]
            inner = _solve_interpolation(values)[first - low : last - low]
            if not first:
                coefficients.extend(inner[:1].repeat(2))
            coefficients.extend(inner)
        coefficients.extend(inner[-1:].repeat(2))
        return cls(coefficients.freeze(), step)

    @property
    def duration(self) -> float:
        """End of the profile."""
        return self.step * (len(self.coefficients) - 5)

    def find_s(self, sigma: Array) -> Array:
        """Path parameter at pseudo-times."""
        at = np.clip(sigma * (1.0 / self.step), 0.0, len(self.coefficients) - 5)
        i = np.minimum(at.astype(np.intp), len(self.coefficients) - 6)
        at -= i
        total = np.zeros_like(at)
        for k in range(6):
            p = _SEGMENTS[:, k]
            weight = p[5] * at + p[4]
            for power in (3, 2, 1, 0):
                weight *= at
                weight += p[power]
            weight *= self.coefficients.take(i + k)
            total += weight
        return total


def _solve_interpolation(values: Array) -> Array:
    """Coefficients (n,) of the profile through values (n,) at its knots, that rests beyond both ends."""
    # B-spline values at the knots: 1, 26, 66, 26, 1 over 120
    band = np.empty((3, len(values)), order="F")
    band[0], band[1], band[2] = 66.0 / 120, 26.0 / 120, 1.0 / 120
    rhs = values.copy()
    for end, inner in ((0, 1), (-1, -2)):
        rhs[end] -= 27.0 / 120 * values[end]
        rhs[inner] -= 1.0 / 120 * values[end]
    factor, _info = pbtrf(band, lower=1, overwrite_ab=1)
    coefficients, _info = pbtrs(factor, rhs, lower=1)
    return np.asarray(coefficients.reshape(-1))


class Times(Struct, frozen=True, eq=False):
    """The map between pseudo-time and time that a pass found: at every knot time, dsigma/dt and d2sigma/dt2."""

    knot: float
    t: Array
    rate: Array
    change: Array

    @classmethod
    def build_from_coefficients(cls, coefficients: Array, knot: float) -> "Times":
        """From the cubic B-spline coefficients (n + 3,) of X = (dsigma/dt)^2."""
        n = len(coefficients) - 3
        table, passed = GrowingTable(t=(float,), rate=(float,), change=(float,)), 0.0
        for first, last in iterate_blocks(n + 1):
            c, some = coefficients[first : last + 2], min(last, n) - first  # knots, and intervals between them
            seconds = np.zeros(some)
            for weights, share in zip(build_basis(knot, 0.5 * (_GAUSS + 1))[0], _GAUSS_WEIGHTS, strict=True):
                x = sum(weight * coefficients[first + k : first + k + some] for k, weight in enumerate(weights))
                seconds += 0.5 * knot * share / np.sqrt(np.maximum(x, tuning.SMALLEST_X))
            t = np.cumsum(np.append(passed, seconds))
            at_knots = np.maximum((c[:-2] + 4 * c[1:-1] + c[2:]) / 6, tuning.SMALLEST_X)
            table.extend(t=t[: last - first], rate=np.sqrt(at_knots), change=0.5 * ((c[2:] - c[:-2]) / (2 * knot)))
            passed = t[-1]
        return cls(knot, **table.freeze())

    @property
    def total(self) -> float:
        """Duration of the profile, s."""
        return float(self.t[-1])

    def find_sigma(self, t: Array) -> Array:
        """Pseudo-time at times t (n,) by quintic Hermite interpolation between knots; rises with t."""
        i = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.t) - 2)
        h = self.t[i + 1] - self.t[i]
        f = (t - self.t[i]) / h
        v0, v1 = self.rate[i] * h / self.knot, self.rate[i + 1] * h / self.knot
        a0, a1 = self.change[i] * h * h / self.knot, self.change[i + 1] * h * h / self.knot
        # q(f) = v0 f + a0 f^2/2 + c3 f^3 + c4 f^4 + c5 f^5 with q(1) = 1, q'(1) = v1, q''(1) = a1
        e0, e1, e2 = 1.0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0
        c3 = 10 * e0 - 4 * e1 + 0.5 * e2
        c4 = -15 * e0 + 7 * e1 - e2
        c5 = 6 * e0 - 3 * e1 + 0.5 * e2
        passed = f * (v0 + f * (0.5 * a0 + f * (c3 + f * (c4 + f * c5))))
        return np.asarray((i + np.clip(passed, 0.0, 1.0)) * self.knot, dtype=np.float64)


def find_positions(
    profile: Profile, times: Times, count: int, instants: Callable[[Array], Array], team: Team = ALONE
) -> Iterator[Array]:
    """Path parameters (count,) of a re-timed profile, at the times that ``instants`` has for numbers 0, 1, ...

    They come part by part, from the processes of a ``team``.
    """

    def evaluate(part: tuple[int, int]) -> Array:
        release_memory()
        return profile.find_s(times.find_sigma(instants(np.arange(*part, dtype=float))))

    return team.map(evaluate, split_evenly(count, tuning.SHARED_ROWS))
