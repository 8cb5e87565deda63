"""The fit of the lengths: least squares on the whitened corrections, what the readings determine, random starts."""

from typing import Any, Final, NamedTuple

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from scipy.optimize import least_squares

from verne_post.base.arrays import Array, Ints
from verne_post.base.tolerances import NOISE_LEVERAGE, RANK_SHARE, SAME_LENGTHS_MM, SMALL_COEFFICIENT, WEAK_SHARE
from verne_post.calibration.adjustment import adjust_readings
from verne_post.calibration.data import EXACT, Direction, Landing, Readings, Uncertainty
from verne_post.model.protocols import Identifiable

#: Trial data sets that show how much leverage the measurement errors alone have.
NOISE_DRAWS: Final = 4
#: Evaluations of one stage of one fit; from the machine file's lengths it takes about ten.
EVALUATIONS: Final = 300
#: A random start draws lengths up to this many times the longest one of the machine file.
START_REACH: Final = 1.5

#: Relative change of lengths and of the sum of squares at which the fit ends: near the rounding of double precision.
CONVERGED: Final = 1e-13


class End(NamedTuple):
    """Where a fit ends: t, its chi-square, and whether it converged."""

    t: Array
    chi_square: float
    converged: bool


class Fit(Struct, frozen=True, eq=False):
    """Lengths are ``origin + basis @ t``; t is estimated."""

    module: Identifiable
    data: Readings
    sigma: Uncertainty
    groups: list[Ints]
    origin: Array
    basis: Array
    lower: Array

    def run(self, t: Array) -> End:
        """Fit from a start t."""
        # a tilt that is given leads even far-off lengths to its own solution, so it is exact first, then what it is
        t = self._minimise(EXACT, t).x
        if np.isinf(self.sigma.tilt):
            t = self._minimise(replace(EXACT, tilt=np.inf), t).x
        ended = self._minimise(self.sigma, t)
        return End(ended.x, float(2 * ended.cost), bool(ended.status > 0))

    def _minimise(self, sigma: Uncertainty, t: Array) -> Any:
        last: list[tuple[bytes, Array, Array]] = []

        def evaluate_both(at: Array) -> tuple[bytes, Array, Array]:
            if not last or last[0][0] != at.tobytes():
                lengths = self.origin + self.basis @ at
                value, design, _states = adjust_readings(self.module, lengths, self.data, sigma, self.groups)
                last[:] = [(at.tobytes(), value, design @ self.basis)]
            return last[0]

        return least_squares(
            lambda at: evaluate_both(at)[1],
            t,
            jac=lambda at: evaluate_both(at)[2],
            bounds=(self.lower, np.inf),
            method="trf",
            xtol=CONVERGED,
            ftol=CONVERGED,
            gtol=10 * CONVERGED,
            max_nfev=EVALUATIONS,
        )


def separate(fit: Fit, lengths: Array) -> tuple[Array, Array]:
    """Directions of t that the data determine (q, a) and those that they do not (q, b), orthonormal.

    A singular direction of the whitened derivatives is lost when rounding is all it has, when its uncertainty is not
    small against the lengths, or when errors of the readings alone give it as much leverage.
    """
    _residual, design, base = adjust_readings(fit.module, lengths, fit.data, fit.sigma, fit.groups)
    q = fit.basis.shape[1]
    # with rows of zeros, so that fewer equations than lengths leave directions without a singular value of their own
    by_t = np.concatenate([design @ fit.basis, np.zeros((q, q))])
    _u, size, vt = np.linalg.svd(by_t, full_matrices=False)
    rng = np.random.default_rng(0)
    noise = np.zeros(q)
    for _ in range(NOISE_DRAWS):
        drawn = _disturb(fit.data, fit.sigma, rng)
        states = adjust_readings(fit.module, lengths, drawn, fit.sigma, fit.groups)[2]
        change = np.concatenate(
            [
                state.whiten(other.raw - state.raw).reshape(-1, len(lengths))
                for state, other in zip(base, states, strict=True)
            ]
        )
        noise += ((change @ fit.basis @ vt.T) ** 2).sum(axis=0)
    lost = (size <= RANK_SHARE * size.max()) | (size * WEAK_SHARE * np.abs(lengths).max() < 1)
    lost |= size < NOISE_LEVERAGE * np.sqrt(noise / NOISE_DRAWS)
    return vt[~lost].T, vt[lost].T


def _disturb(data: Readings, sigma: Uncertainty, rng: np.random.Generator) -> Readings:
    """The data with another draw of reading errors."""
    _names, which = np.unique(data.setting, return_inverse=True)
    rho = data.rho + sigma.slider * rng.standard_normal((which.max() + 1, data.rho.shape[1]))[which]
    pose = np.array(data.pose)
    pose[:, :3] += sigma.position * rng.standard_normal((len(pose), 3))
    if np.isfinite(sigma.tilt):
        pose[:, 3] += sigma.tilt * rng.standard_normal(len(pose))
    return replace(data, rho=rho, pose=pose)


def name_directions(lost: Array, names: tuple[str, ...]) -> tuple[Direction, ...]:
    """Short combinations that span the lost directions (p, d), reduced so that each has a length that no other has."""
    rows = np.array(lost.T)
    for step in range(len(rows)):
        open_ = np.abs(rows[step:])
        row, column = divmod(int(np.argmax(open_)), open_.shape[1])
        rows[[step, step + row]] = rows[[step + row, step]]
        rows[step] /= rows[step, column]
        others = np.arange(len(rows)) != step
        rows[others] -= rows[others, column][:, None] * rows[step]
    directions = []
    for row_values in rows:
        scaled = row_values / row_values[np.argmax(np.abs(row_values))]
        directions.append(
            Direction(
                {
                    name: float(value)
                    for name, value in zip(names, scaled, strict=True)
                    if abs(value) > SMALL_COEFFICIENT
                }
            )
        )
    return tuple(directions)


class Starts(NamedTuple):
    """Ends of random starts: the places, best first; the number that ended nowhere; the best end, or None."""

    landings: tuple[Landing, ...]
    failed: int
    best: End | None


def fit_random_starts(fit: Fit, turn: Array, basis: Array, starts: int) -> Starts:
    """Fit from random lengths.

    Parameters
    ----------
    turn : ndarray, shape (q, a)
        From the unknowns of ``fit`` to the changes of lengths, of which ``basis`` (p, q) makes all lengths.
    """
    names = fit.module.length_names
    rng = np.random.default_rng(0)
    reach = START_REACH * float(np.abs(fit.origin).max())
    signed = [names.index(name) for name in fit.module.signed_lengths]
    ends: list[End] = []
    for _ in range(starts):
        lengths = reach * rng.uniform(size=len(names))
        lengths[signed] *= rng.choice([-1.0, 1.0], size=len(signed))
        # a column's t is the mean change of the lengths that it moves
        t = turn.T @ ((basis.T @ (lengths - fit.origin)) / basis.sum(axis=0))
        try:
            end = fit.run(t)
        except (np.linalg.LinAlgError, ValueError):  # the fit ran to lengths with which nothing can close
            continue
        if end.converged and np.isfinite(end.chi_square):
            ends.append(end)
    ends.sort(key=lambda end: end.chi_square)
    places: list[tuple[Array, float, int]] = []
    for end in ends:
        lengths = fit.origin + fit.basis @ end.t
        near = [i for i, (there, *_rest) in enumerate(places) if np.abs(there - lengths).max() < SAME_LENGTHS_MM]
        if near:
            there, best, count = places[near[0]]
            places[near[0]] = (there, best, count + 1)
        else:
            places.append((lengths, end.chi_square, 1))
    landings = tuple(Landing(name_lengths(names, there), chi_square, count) for there, chi_square, count in places)
    return Starts(landings, starts - len(ends), ends[0] if ends else None)


def name_lengths(names: tuple[str, ...], values: Array) -> dict[str, float]:
    """Lengths (p,), mm, by name."""
    return {name: float(value) for name, value in zip(names, values, strict=True)}
