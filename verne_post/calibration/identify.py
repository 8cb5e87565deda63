"""Lengths of a module from measured pairs of sliders and platform poses.

Sliders and poses are both measured, each with its own uncertainty, so this is a fit with errors in all variables: the
smallest corrections, counted in uncertainties, that let every rod close. For given lengths the corrections of one
setting of the sliders follow from linearised loop equations, repeated at the corrected values until they stand
(condition adjustment, Gauss-Helmert). Whitened by the covariance of the equations they are the residuals of the
outer fit over the lengths alone; their gradient is exact, and the number of unknowns does not grow with the data.
An unmeasured tilt is a free unknown of its row, eliminated by turning the row's equations so that only the first one
contains it. Works on any module with the protocol ``Identifiable``; mm and rad.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.special import chdtrc

from verne_post.base.tolerances import (
    ADJUST_STEP,
    NOISE_LEVERAGE,
    RANK_SHARE,
    SAME_LENGTHS_MM,
    SMALL_COEFFICIENT,
    WEAK_SHARE,
)
from verne_post.model.findings import InputError, finding
from verne_post.model.protocols import Identifiable

Array = NDArray[np.float64]
Ints = NDArray[np.integer]
Mask = NDArray[np.bool_]

#: Linearisations of the corrections; with errors far below the rods three suffice, far-off lengths are cut short.
ADJUST_STEPS: Final = 20
#: A tilt may change by this much from one linearisation to the next, rad.
TILT_STEP: Final = 0.3
#: Leans tried for a row that has none; two solutions of a row are farther apart wherever they can be told apart.
LEAN_GRID: Final = 72
#: Trial data sets that show how much leverage the measurement errors alone have.
NOISE_DRAWS: Final = 4
#: Evaluations of one stage of one fit; from the machine file's lengths it takes about ten.
EVALUATIONS: Final = 300
#: Separability is judged at the solution, which moves a little when a direction is held; two passes settle it.
PASSES: Final = 3
#: A random start draws lengths up to this many times the longest one of the machine file.
START_REACH: Final = 1.5


@dataclass(frozen=True, eq=False)
class Measured:
    """Measured pairs.

    Attributes
    ----------
    rho : ndarray, shape (n, m)
        Actuators, mm.
    pose : ndarray, shape (n, 4)
        x, y, z of P in the base frame (mm) and alpha (rad), NaN where it was not measured.
    setting : ndarray of int, shape (n,)
        Rows of one setting share one reading of the actuators, and so its error.
    line : ndarray of int, shape (n,)
        Where the row stands in its file.
    """

    rho: Array
    pose: Array
    setting: Ints
    line: Ints


@dataclass(frozen=True)
class Uncertainty:
    """Standard uncertainties of the readings: sliders and positions in mm, tilt in rad; 0 is exact.

    An infinite ``tilt`` uses measured tilts only to know which solution a row is. ``rod`` is how far each rod may miss
    (mm): play and bending, which no length explains; the only error left where all readings are taken as exact.
    """

    slider: float
    position: float
    tilt: float
    rod: float = 0.0


#: Readings exact, all error in the rods: poor statistics, but defined for any lengths, so it comes first.
_EXACT: Final = Uncertainty(0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Direction:
    """A combination of lengths that the data do not determine: coefficients, the largest +-1."""

    coefficients: dict[str, float]

    def words(self) -> str:
        """As one clause: "R1 +1.00 with r1 +1.00"."""
        parts = [f"{name} {value:+.2f}" for name, value in self.coefficients.items()]
        return " with ".join(parts) if len(parts) > 1 else f"{next(iter(self.coefficients))} alone"


@dataclass(frozen=True)
class Landing:
    """Where random starts ended: all lengths (mm), the chi-square there, and how many came."""

    lengths: dict[str, float]
    chi_square: float
    count: int


@dataclass(frozen=True, eq=False)
class Identification:
    """What the data say about the lengths.

    Attributes
    ----------
    lengths : dict
        All lengths, mm; held and undetermined ones stand as in the machine file.
    uncertainty : dict
        Standard uncertainty of the estimated lengths, mm; NaN where the data do not determine a length.
    correlation : ndarray, shape (k, k)
        In the order of ``uncertainty``.
    tied : tuple of tuple of str
    undetermined : tuple of Direction
    chi_square, degrees_of_freedom, probability
        Of the corrections; the probability that readings with the stated uncertainties give as much or more
        (NaN without redundancy).
    residual : ndarray, shape (n, m + 4)
        Measured minus fitted: actuators, x, y, z (mm), alpha (rad, NaN where not used).
    misfit : ndarray, shape (n, e)
        What each rod misses at the fitted readings, mm; zero where rods are exact.
    scaled : ndarray, shape (n, m + 4 + e)
        Both in standard uncertainties; NaN where exact or not used.
    converged : bool
    landings : tuple of Landing
        Best first; empty without random starts.
    failed_starts : int
    """

    lengths: dict[str, float]
    uncertainty: dict[str, float]
    correlation: Array
    tied: tuple[tuple[str, ...], ...]
    undetermined: tuple[Direction, ...]
    chi_square: float
    degrees_of_freedom: int
    probability: float
    residual: Array
    misfit: Array
    scaled: Array
    converged: bool
    landings: tuple[Landing, ...]
    failed_starts: int


# --- corrections for given lengths -----------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Adjusted:
    """Settings with equally many rows: m settings, k rows each, e equations a row, p lengths."""

    whitened: Array  # (m, k e)
    design: Array  # (m, k e, p), derivative of the whitened residuals
    raw: Array  # (m, k, e, p), derivative of the equations at the corrected readings
    turn: Array  # (m, k, e, e)
    dropped: Mask  # (m, k, e)
    root: Array  # (m, k e, k e), Cholesky factor of the covariance
    correction: Array  # (m, sliders + 4 k)
    misfit: Array  # (m, k, e), what the rods miss at the corrected readings, mm

    def whiten(self, by_lengths: Array) -> Array:
        """Apply the turning and weighting of this state to derivatives (m, k, e, p)."""
        turned = self.turn @ by_lengths
        turned[self.dropped] = 0.0
        m, k, e, p = turned.shape
        return np.linalg.solve(self.root, turned.reshape(m, k * e, p)).astype(float, copy=False)


def _groups(setting: Ints) -> list[Ints]:
    """Row numbers (m, k) of the settings with k rows, one array for each k."""
    _names, which, counts = np.unique(setting, return_inverse=True, return_counts=True)
    order = np.argsort(which, kind="stable")
    first = np.cumsum(counts) - counts
    return [order[first[counts == k][:, None] + np.arange(k)] for k in np.unique(counts)]


def _turned(by_lean: Array, free: Mask) -> tuple[Array, Mask]:
    """Reflections (..., e, e) after which only the first equation of a free row contains its tilt; that equation."""
    e = by_lean.shape[-1]
    size = np.linalg.norm(by_lean, axis=-1)
    use = free & (size > 0)
    normal = np.array(by_lean)
    normal[..., 0] += np.where(by_lean[..., 0] < 0, -1.0, 1.0) * size
    square = np.where(use, (normal**2).sum(axis=-1), 1.0)
    outer = normal[..., :, None] * normal[..., None, :]
    turn = np.eye(e) - np.where(use, 2.0 / square, 0.0)[..., None, None] * outer
    dropped = np.zeros(by_lean.shape, dtype=bool)
    dropped[..., 0] = use
    return turn, dropped


def _with_leans(module: Identifiable, lengths: Array, data: Measured) -> Array:
    """Poses (n, 4) with a tilt for every row: where there is none, the one that comes closest to closing the rods."""
    pose = np.array(data.pose)
    blank = np.flatnonzero(np.isnan(pose[:, 3]))
    if len(blank):
        grid = 2 * np.pi * np.arange(LEAN_GRID) / LEAN_GRID - np.pi
        trial = np.repeat(pose[blank], LEAN_GRID, axis=0)
        trial[:, 3] = np.tile(grid, len(blank))
        value = module.loop_equations(lengths, np.repeat(data.rho[blank], LEAN_GRID, axis=0), trial)[0]
        pose[blank, 3] = grid[np.argmin((value**2).sum(axis=1).reshape(-1, LEAN_GRID), axis=1)]
    return pose


def _adjust(
    module: Identifiable, lengths: Array, data: Measured, sigma: Uncertainty, start: Array, rows: Ints
) -> _Adjusted:
    """Smallest corrections with which the loops of some settings close."""
    m, k = rows.shape
    sliders = data.rho.shape[1]
    read = np.concatenate([data.rho[rows[:, 0]], start[rows].reshape(m, 4 * k)], axis=1)
    free = np.isnan(data.pose[rows, 3]) | np.isinf(sigma.tilt)
    tilt = sliders + 3 + 4 * np.arange(k)
    variance = np.tile(
        np.r_[np.full(sliders, sigma.slider**2), np.tile([*(3 * [sigma.position**2]), sigma.tilt**2], k)], (m, 1)
    )
    variance[:, tilt] = np.where(free, 0.0, variance[:, tilt])
    now = np.array(read)
    for step in range(ADJUST_STEPS):
        rho = np.repeat(now[:, None, :sliders], k, axis=1).reshape(m * k, sliders)
        parts = module.loop_equations(lengths, rho, now[:, sliders:].reshape(m * k, 4))
        value, by_lengths, by_sliders, by_pose = (part.reshape(m, k, *part.shape[1:]) for part in parts)
        e = value.shape[2]
        turn, dropped = _turned(by_pose[..., 3], free)
        by_reading = np.zeros((m, k, e, sliders + 4 * k))
        by_reading[..., :sliders] = turn @ by_sliders
        turned_pose = turn @ by_pose
        for row in range(k):
            by_reading[:, row, :, sliders + 4 * row : sliders + 4 * row + 4] = turned_pose[:, row]
        off = read - now
        off[:, tilt] = np.where(free, 0.0, off[:, tilt])
        closing = (turn @ value[..., None])[..., 0] + (by_reading @ off[:, None, :, None])[..., 0]
        b = np.where(dropped[..., None], 0.0, by_reading).reshape(m, k * e, -1)
        covariance = (b * variance[:, None, :]) @ np.swapaxes(b, 1, 2)
        flat = dropped.reshape(m, k * e)
        covariance[:, np.arange(k * e), np.arange(k * e)] += np.where(flat, 1.0, sigma.rod**2)
        root = np.linalg.cholesky(covariance)
        whitened = np.linalg.solve(root, np.where(flat, 0.0, closing.reshape(m, k * e))[..., None])
        multiplier = np.linalg.solve(np.swapaxes(root, 1, 2), whitened)
        correction = -variance * (np.swapaxes(b, 1, 2) @ multiplier)[..., 0]
        # the equation that was turned towards the tilt gives the free tilt
        first = closing[..., 0] + (by_reading[..., 0, :] * correction[:, None, :]).sum(axis=-1)
        slope = turned_pose[..., 0, 3]
        change = np.where(dropped[..., 0], -first / np.where(dropped[..., 0], slope, 1.0), 0.0)
        change = np.clip(change, -TILT_STEP, TILT_STEP)
        new = read + correction
        new[:, tilt] = np.where(free, now[:, tilt] + change, new[:, tilt])
        moved = float(np.abs(new - now).max())
        now = new
        if moved < ADJUST_STEP or step == ADJUST_STEPS - 1:
            break
    state = _Adjusted(whitened[..., 0], np.empty(0), by_lengths, turn, dropped, root, correction, value)
    return replace(state, design=state.whiten(by_lengths))


def _adjusted(
    module: Identifiable, lengths: Array, data: Measured, sigma: Uncertainty, groups: Sequence[Ints]
) -> tuple[Array, Array, list[_Adjusted]]:
    """Whitened residuals, their derivatives by the lengths, and the state of every group."""
    start = _with_leans(module, lengths, data)
    states = [_adjust(module, lengths, data, sigma, start, rows) for rows in groups]
    p = len(lengths)
    residual = np.concatenate([state.whitened.ravel() for state in states])
    return residual, np.concatenate([state.design.reshape(-1, p) for state in states]), states


# --- the fit ---------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Task:
    """Lengths are ``origin + basis @ t``; t is estimated."""

    module: Identifiable
    data: Measured
    sigma: Uncertainty
    groups: list[Ints]
    origin: Array
    basis: Array
    lower: Array

    def fit(self, t: Array) -> tuple[Array, float, bool]:
        """From a start t: where the fit ends, its chi-square, and whether it converged."""
        # a tilt that is given leads even far-off lengths to its own solution, so it is exact first, then what it is
        t = self._minimise(_EXACT, t).x
        if np.isinf(self.sigma.tilt):
            t = self._minimise(replace(_EXACT, tilt=np.inf), t).x
        ended = self._minimise(self.sigma, t)
        return ended.x, float(2 * ended.cost), bool(ended.status > 0)

    def _minimise(self, sigma: Uncertainty, t: Array) -> Any:
        last: list[tuple[bytes, Array, Array]] = []

        def both(at: Array) -> tuple[bytes, Array, Array]:
            if not last or last[0][0] != at.tobytes():
                lengths = self.origin + self.basis @ at
                value, design, _states = _adjusted(self.module, lengths, self.data, sigma, self.groups)
                last[:] = [(at.tobytes(), value, design @ self.basis)]
            return last[0]

        return least_squares(
            lambda at: both(at)[1], t, jac=lambda at: both(at)[2], bounds=(self.lower, np.inf), method="trf",
            xtol=1e-13, ftol=1e-13, gtol=1e-12, max_nfev=EVALUATIONS,
        )  # fmt: skip


def identify(
    module: Identifiable,
    data: Measured,
    sigma: Uncertainty,
    held: Sequence[str] = (),
    tied: Sequence[Sequence[str]] = (),
    starts: int = 0,
) -> Identification:
    """Estimate a module's lengths from measured pairs.

    Parameters
    ----------
    module : Identifiable
        Gives the loop equations, and the lengths to start from.
    data : Measured
    sigma : Uncertainty
    held : sequence of str
        Lengths that keep the module's values.
    tied : sequence of sequences of str
        Groups of lengths that are equal.
    starts : int
        Random starts besides the module's own lengths; the best end of all is taken.

    Returns
    -------
    Identification

    Raises
    ------
    ValueError
        No length is left to estimate, or an uncertainty is negative or leaves nothing that may miss.
    InputError
        The readings determine none of the lengths to estimate (VP502).
    numpy.linalg.LinAlgError
        Where the equations of a setting contradict each other for any correction (exact readings).
    """
    if not (min(sigma.slider, sigma.position, sigma.tilt, sigma.rod) >= 0 and max(sigma.position, sigma.rod) > 0):
        raise ValueError("no uncertainty may be negative, and that of positions or of rods must be above 0")
    names = module.length_names
    origin = np.array([float(getattr(module, name)) for name in names])
    columns = _columns(names, held, tied)
    if not columns:
        raise ValueError("no length is left to estimate")
    basis = np.zeros((len(names), len(columns)))
    for column, group in enumerate(columns):
        basis[[names.index(name) for name in group], column] = 1.0
        origin[[names.index(name) for name in group]] = np.mean([origin[names.index(name)] for name in group])
    # a column's t is the change of its lengths; a positive length may shrink to nothing
    lower = np.array(
        [-np.inf if group[0] in module.signed_lengths else -origin[names.index(group[0])] for group in columns]
    )
    groups = _groups(data.setting)
    whole = _Task(module, data, sigma, groups, origin, basis, lower)
    kept, lost = _separable(whole, origin)
    for _ in range(PASSES):
        if not kept.shape[1]:
            raise InputError(
                finding(
                    "VP502", "the readings determine none of the lengths to estimate; measure more poses of other kinds"
                )
            )
        task, turn = whole, np.eye(len(columns))
        if lost.shape[1]:
            task, turn = replace(whole, basis=basis @ kept, lower=np.full(kept.shape[1], -np.inf)), kept
        t, chi_square, converged = task.fit(np.zeros(turn.shape[1]))
        held_back = lost.shape[1]
        kept, lost = _separable(whole, origin + task.basis @ t)
        if lost.shape[1] == held_back:
            break
    landings, failed, best = _random_starts(task, turn, basis, starts, names)
    if best is not None and best[1] < chi_square:
        t, chi_square, converged = best
    return _report(task, t, converged, landings, failed, columns, _directions(basis @ lost, names))


def _columns(names: tuple[str, ...], held: Sequence[str], tied: Sequence[Sequence[str]]) -> list[tuple[str, ...]]:
    """Groups of lengths that move as one, in the order of the names."""
    partner = {name: tuple(group) for group in tied for name in group}
    columns: list[tuple[str, ...]] = []
    for name in names:
        group = partner.get(name, (name,))
        if not set(group) & set(held) and group not in columns:
            columns.append(group)
    return columns


def _separable(task: _Task, lengths: Array) -> tuple[Array, Array]:
    """Directions of t that the data determine (q, a) and those that they do not (q, b), orthonormal.

    A singular direction of the whitened derivatives is lost when rounding is all it has, when its uncertainty is not
    small against the lengths, or when errors of the readings alone give it as much leverage.
    """
    _residual, design, base = _adjusted(task.module, lengths, task.data, task.sigma, task.groups)
    q = task.basis.shape[1]
    # with rows of zeros, so that fewer equations than lengths leave directions without a singular value of their own
    by_t = np.concatenate([design @ task.basis, np.zeros((q, q))])
    _u, size, vt = np.linalg.svd(by_t, full_matrices=False)
    rng = np.random.default_rng(0)
    noise = np.zeros(q)
    for _ in range(NOISE_DRAWS):
        drawn = _disturbed(task.data, task.sigma, rng)
        states = _adjusted(task.module, lengths, drawn, task.sigma, task.groups)[2]
        change = np.concatenate(
            [
                state.whiten(other.raw - state.raw).reshape(-1, len(lengths))
                for state, other in zip(base, states, strict=True)
            ]
        )
        noise += ((change @ task.basis @ vt.T) ** 2).sum(axis=0)
    lost = (size <= RANK_SHARE * size.max()) | (size * WEAK_SHARE * np.abs(lengths).max() < 1)
    lost |= size < NOISE_LEVERAGE * np.sqrt(noise / NOISE_DRAWS)
    return vt[~lost].T, vt[lost].T


def _disturbed(data: Measured, sigma: Uncertainty, rng: np.random.Generator) -> Measured:
    """The data with another draw of reading errors."""
    _names, which = np.unique(data.setting, return_inverse=True)
    rho = data.rho + sigma.slider * rng.standard_normal((which.max() + 1, data.rho.shape[1]))[which]
    pose = np.array(data.pose)
    pose[:, :3] += sigma.position * rng.standard_normal((len(pose), 3))
    if np.isfinite(sigma.tilt):
        pose[:, 3] += sigma.tilt * rng.standard_normal(len(pose))
    return replace(data, rho=rho, pose=pose)


def _directions(lost: Array, names: tuple[str, ...]) -> tuple[Direction, ...]:
    """Few-worded combinations that span the lost directions (p, d): reduced so that each has a length of its own."""
    rows = np.array(lost.T)
    for step in range(len(rows)):
        open_ = np.abs(rows[step:])
        row, column = divmod(int(np.argmax(open_)), open_.shape[1])
        rows[[step, step + row]] = rows[[step + row, step]]
        rows[step] /= rows[step, column]
        others = np.arange(len(rows)) != step
        rows[others] -= rows[others, column][:, None] * rows[step]
    found = []
    for row_values in rows:
        scaled = row_values / row_values[np.argmax(np.abs(row_values))]
        found.append(
            Direction(
                {
                    name: float(value)
                    for name, value in zip(names, scaled, strict=True)
                    if abs(value) > SMALL_COEFFICIENT
                }
            )
        )
    return tuple(found)


def _random_starts(
    task: _Task, turn: Array, basis: Array, starts: int, names: tuple[str, ...]
) -> tuple[tuple[Landing, ...], int, tuple[Array, float, bool] | None]:
    """Fit from random lengths; where they land, how many failed, and the best end."""
    rng = np.random.default_rng(0)
    reach = START_REACH * float(np.abs(task.origin).max())
    ends: list[tuple[Array, float, bool]] = []
    failed = 0
    for _ in range(starts):
        lengths = reach * rng.uniform(size=len(names))
        signed = [names.index(name) for name in task.module.signed_lengths]
        lengths[signed] *= rng.choice([-1.0, 1.0], size=len(signed))
        # a column's t is the mean change of the lengths that it moves
        t = turn.T @ ((basis.T @ (lengths - task.origin)) / basis.sum(axis=0))
        try:
            end = task.fit(t)
        except (np.linalg.LinAlgError, ValueError):  # the fit ran to lengths with which nothing can close
            failed += 1
            continue
        if end[2] and np.isfinite(end[1]):
            ends.append(end)
        else:
            failed += 1
    ends.sort(key=lambda end: end[1])
    landings: list[tuple[Array, float, int]] = []
    for t, chi_square, _converged in ends:
        lengths = task.origin + task.basis @ t
        near = [
            i for i, (there, _chi, _count) in enumerate(landings) if np.abs(there - lengths).max() < SAME_LENGTHS_MM
        ]
        if near:
            there, best_chi, count = landings[near[0]]
            landings[near[0]] = (there, best_chi, count + 1)
        else:
            landings.append((lengths, chi_square, 1))
    named = tuple(Landing(_named(names, there), chi, count) for there, chi, count in landings)
    return named, failed, ends[0] if ends else None


def _named(names: tuple[str, ...], values: Array) -> dict[str, float]:
    return {name: float(value) for name, value in zip(names, values, strict=True)}


def _report(
    task: _Task, t: Array, converged: bool, landings: tuple[Landing, ...], failed: int,
    columns: list[tuple[str, ...]], undetermined: tuple[Direction, ...],
) -> Identification:  # fmt: skip
    names = task.module.length_names
    lengths = task.origin + task.basis @ t
    residual, design, states = _adjusted(task.module, lengths, task.data, task.sigma, task.groups)
    _u, size, vt = np.linalg.svd(design @ task.basis, full_matrices=False)
    spread_of_t = task.basis @ (vt.T / size)
    covariance = spread_of_t @ spread_of_t.T
    estimated = [name for name in names if any(name in group for group in columns)]
    index = [names.index(name) for name in estimated]
    blurred = {name for direction in undetermined for name in direction.coefficients}
    spread = np.sqrt(np.diag(covariance)[index])
    spread = np.where([name in blurred for name in estimated], np.nan, spread)
    correlation = covariance[np.ix_(index, index)] / np.outer(spread, spread)
    n, sliders = task.data.rho.shape
    off = np.full((n, sliders + 4), np.nan)
    misfit = np.empty((n, states[0].misfit.shape[2]))
    for rows, state in zip(task.groups, states, strict=True):
        m, k = rows.shape
        off[rows, :sliders] = -state.correction[:, None, :sliders]
        off[rows, sliders:] = -state.correction[:, sliders:].reshape(m, k, 4)
        misfit[rows] = state.misfit
    free = np.isnan(task.data.pose[:, 3]) | np.isinf(task.sigma.tilt)
    off[free, -1] = np.nan
    errors = task.sigma
    sigma = np.array([*sliders * [errors.slider], *3 * [errors.position], errors.tilt, *misfit.shape[1] * [errors.rod]])
    scaled = np.concatenate([off, misfit], axis=1) / np.where(sigma > 0, sigma, np.nan)
    equations = sum(int((~state.dropped).sum()) for state in states)
    chi_square, freedom = float(residual @ residual), equations - len(t)
    return Identification(
        lengths=_named(names, lengths),
        uncertainty=dict(zip(estimated, spread.tolist(), strict=True)),
        correlation=correlation,
        tied=tuple(group for group in columns if len(group) > 1),
        undetermined=undetermined,
        chi_square=chi_square,
        degrees_of_freedom=freedom,
        probability=float(chdtrc(freedom, chi_square)) if freedom > 0 else float("nan"),
        residual=off,
        misfit=misfit,
        scaled=scaled,
        converged=converged,
        landings=landings,
        failed_starts=failed,
    )
