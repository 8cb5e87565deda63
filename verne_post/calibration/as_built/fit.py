"""The most probable deviations for readings and a prior (Gauss-Newton), without readings that contradict the others."""

from typing import Final, NamedTuple

import numpy as np
from msgspec import Struct
from scipy.special import chdtrc

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.calibration.as_built.data import Prior
from verne_post.calibration.as_built.equations import ROWS, Blocks, Measurement
from verne_post.calibration.as_built.stations import NEAR_MM, NEAR_TURN, SIZE
from verne_post.kinematics.as_built.parameter_rates import COUNT

#: Steps of Gauss and Newton; four where the readings are sound.
STEPS: Final = 30
#: The fit ends when a step is smaller than this, in standard deviations of what is known before.
SETTLED: Final = 1e-9
#: A reading is left out when chance would put one of all readings so far off with this probability.
BAD_READING: Final = 1e-3
#: A reading is left out before any fit when machines within their tolerances give one so far off with this probability.
IMPOSSIBLE: Final = 1e-12
#: At most this share of the readings is left out; where more contradict, no choice among them is safe.
MOST_LEFT_OUT: Final = 0.1
#: A reading that nothing else checks: the rest of its variance is below this share.
UNCHECKED: Final = 1e-9
#: Parts of the readings: each is predicted from all the others.
FOLDS: Final = 5


class Fit(Struct, frozen=True, eq=False):
    """Where a fit ends."""

    unknowns: Array  #: (p,): 58 deviations (mm, rad), and place (mm) and turn (rad) of each station.
    factor: Array  #: (p, p): Their covariance is ``factor @ factor.T``.
    blocks: Blocks  #: Of all readings at the solution, those left out too.
    chi_square: float  #: Of the readings used and the prior together.
    freedom: int
    converged: bool

    @property
    def deviations(self) -> Array:
        """The deviations (58,)."""
        return self.unknowns[:COUNT]

    @property
    def probability(self) -> float:
        """Probability of so large a misfit, with the stated uncertainties and within the prior; NaN without freedom."""
        return float(chdtrc(self.freedom, self.chi_square)) if self.freedom > 0 else float("nan")

    @property
    def covariance(self) -> Array:
        """Of the deviations (58, 58)."""
        part = self.factor[:COUNT]
        return part @ part.T


class BadReading(Struct, frozen=True):
    """A block that was left out, and how far it is from what the others predict (5,), mm and rad."""

    block: int
    off: Array
    probability: float


def _compute_prior(measurement: Measurement, prior: Prior) -> tuple[Array, Array]:
    """Mean (p,) and factor of the covariance (p, p) of all unknowns before the readings."""
    size = measurement.size
    factor = np.zeros((size, size))
    factor[:COUNT, :COUNT] = prior.factor
    turned = _find_turned_stations(measurement)
    for station in range(measurement.stations):
        first = COUNT + SIZE * station
        spread = [NEAR_MM] * 3 + [NEAR_TURN if station in turned else 0.0] * 3
        factor[range(first, first + SIZE), range(first, first + SIZE)] = spread
    mean = np.zeros(size)
    mean[:COUNT] = prior.mean
    return mean, factor


def _find_turned_stations(measurement: Measurement) -> set[int]:
    """Stations whose directions are unknown too."""
    return {int(station) for station in measurement.tools.station[measurement.tools.turned]}


def fit(measurement: Measurement, prior: Prior, kept: Mask) -> Fit:
    """The most probable deviations, from the readings that are kept (n,)."""
    mean, factor = _compute_prior(measurement, prior)
    size = len(mean)
    at = np.zeros(size)
    for _ in range(STEPS):
        blocks = measurement.build_equations(mean + factor @ at)
        step = np.linalg.lstsq(
            _stack_equations(blocks, kept, factor), np.concatenate([blocks.residual[kept].ravel(), -at]), rcond=None
        )[0]
        at = at + step
        converged = bool(np.abs(step).max() < SETTLED)
        if converged:
            break
    blocks = measurement.build_equations(mean + factor @ at)
    upper = np.linalg.qr(_stack_equations(blocks, kept, factor), mode="r")
    chi_square = float((blocks.residual[kept] ** 2).sum() + at @ at)
    freedom = int(blocks.used[kept].sum()) - _count_taken_by_stations(measurement, blocks, kept)
    return Fit(mean + factor @ at, factor @ np.linalg.inv(upper), blocks, chi_square, freedom, converged)


def _count_taken_by_stations(measurement: Measurement, blocks: Blocks, kept: Mask) -> int:
    """Count the equations that determine places and turns of stations: as many as their unknowns with readings."""
    turned, tools, taken = _find_turned_stations(measurement), measurement.tools, 0
    for station in range(measurement.stations):
        rows = np.flatnonzero((tools.station == station) & kept[: len(tools)])
        first = COUNT + SIZE * station
        columns = slice(first, first + (SIZE if station in turned else 3))
        taken += (
            int(np.linalg.matrix_rank(blocks.design[rows, :, columns].reshape(len(rows) * ROWS, -1)))
            if len(rows)
            else 0
        )
    return taken


def _stack_equations(blocks: Blocks, kept: Mask, factor: Array) -> Array:
    """Rows of the kept equations, and of what is known before, by the unknowns in standard deviations."""
    size = len(factor)
    return np.concatenate([(blocks.design[kept] @ factor).reshape(-1, size), np.eye(size)])


def fit_robustly(measurement: Measurement, prior: Prior) -> tuple[Fit, Mask, tuple[BadReading, ...]]:
    """Fit, and leave out readings that the others contradict, the worst one first.

    Returns
    -------
    Fit
    kept : ndarray of bool, shape (n,)
    bad : tuple of BadReading
        More than :data:`MOST_LEFT_OUT` of the readings are never left out.
    """
    n = len(measurement)
    kept = np.ones(n, dtype=bool)
    allowed = max(1, int(MOST_LEFT_OUT * n))
    out = _find_impossible(measurement, prior)
    if len(out) > allowed:  # not single readings: the fit tells, if it can
        impossible, out = len(out), []
    else:
        impossible, kept[out] = 0, False
    try:
        found = fit(measurement, prior, kept)
    except ArithmeticError:
        if not impossible:
            raise
        raise ArithmeticError(
            f"{impossible} of {n} readings are farther off than any machine within its tolerances would be; "
            "check units, senses, tool lengths and the frame of the readings"
        ) from None
    while len(out) < allowed:
        chance, distance = _judge_from_others(found, kept)
        worst = int(np.argmax(np.where(kept, distance, -1.0)))  # chances as small as 1e-400 are all zero
        if not chance[worst] < BAD_READING / n:
            break
        kept[worst] = False
        out.append(worst)
        found = fit(measurement, prior, kept)
    # a reading may have looked bad beside a worse one
    chance, _distance = _judge_from_others(found, kept)
    again = [block for block in out if chance[block] >= BAD_READING / n]
    if again:
        kept[again] = True
        found = fit(measurement, prior, kept)
        chance, _distance = _judge_from_others(found, kept)
    bad = tuple(BadReading(block, found.blocks.off[block], float(chance[block])) for block in out if block not in again)
    return found, kept, bad


def _find_impossible(measurement: Measurement, prior: Prior) -> list[int]:
    """Blocks that no machine within its tolerances would give; a fit to them would run away."""
    mean, factor = _compute_prior(measurement, prior)
    before = Fit(mean, factor, measurement.build_equations(mean), 0.0, 0, converged=False)
    chance, _distance = _judge_from_others(before, np.zeros(len(measurement), dtype=bool))
    return np.flatnonzero(chance < IMPOSSIBLE).tolist()


def _judge_from_others(found: Fit, kept: Mask) -> tuple[Array, Array]:
    """How probable each reading is as seen from all the others (n,), and how far off, as a chi-square (n,).

    Where nothing else checks a reading the chance is 1. A single bad reading is always the one that is farthest off.

    With V the share of a block's variance that the fit takes up, a reading that was used is off by ``(1 - V)^-1 r``
    from what the others predict, one that was not by r itself.
    """
    blocks = found.blocks
    reach = blocks.design @ found.factor
    taken = reach @ reach.transpose(0, 2, 1)
    sign = np.where(kept, -1.0, 1.0)[:, None, None]
    spread = np.eye(ROWS) + sign * taken
    size, turn = np.linalg.eigh(spread)
    part = (blocks.residual[:, None, :] @ turn)[:, 0]
    checked = size > UNCHECKED
    distance = np.where(checked, part**2 / np.where(checked, size, 1.0), 0.0).sum(axis=1)
    return np.asarray(chdtrc(np.maximum(blocks.used.sum(axis=1), 1), distance)), distance


class HeldOut(Struct, frozen=True, eq=False):
    """Readings predicted from the others, in :data:`FOLDS` parts."""

    tip: Array  #: (m,): Distances of measured and predicted tips, mm.
    axis: Array  #: (k,): Angles of measured and predicted axes, rad.
    expected_tip: float  #: Root mean square of the distances that the stated uncertainties make.
    probability: float  #: The smallest of the parts' probabilities, times their number.


def hold_out(measurement: Measurement, prior: Prior, kept: Mask) -> HeldOut | None:
    """Predict every part of the readings from the others; None for fewer than two."""
    tools = measurement.tools
    rows = np.flatnonzero(kept[: len(tools)])
    parts = min(FOLDS, len(rows))
    if parts < 2:
        return None
    order = np.random.default_rng(0).permutation(len(rows))
    found = [
        one
        for part in range(parts)
        if (one := _predict(measurement, prior, kept, rows[np.flatnonzero(order % parts == part)])) is not None
    ]
    if not found:
        return None
    tip, axis = (
        np.concatenate([_compute_norms(one.off[:, part]) for one in found]) for part in (slice(3), slice(3, None))
    )
    expected = float(np.sqrt(np.concatenate([one.variance for one in found]).mean()))
    probability = min(1.0, len(found) * min(one.probability for one in found))
    return HeldOut(tip[np.isfinite(tip)], axis[np.isfinite(axis)], expected, probability)


class _Predicted(NamedTuple):
    """Readings minus predictions (m, 5), mm and rad; expected squared tip distances (m,); their probability."""

    off: Array
    variance: Array
    probability: float


def _predict(measurement: Measurement, prior: Prior, kept: Mask, held: Ints) -> _Predicted | None:
    """Predict the ``held`` rows from the other kept ones; None where these tell nothing of their stations."""
    tools = measurement.tools
    training = np.array(kept)
    training[held] = False
    held = held[_are_foreseen(tools.station, held, training)]
    if not len(held):
        return None
    found = fit(measurement, prior, training)
    blocks = found.blocks.take(held)
    reach = blocks.design @ found.factor
    flat, residual = reach.reshape(len(held) * ROWS, -1), blocks.residual.ravel()
    spread = np.eye(len(flat)) + flat @ flat.T
    probability = float(chdtrc(int(blocks.used.sum()), residual @ np.linalg.solve(spread, residual)))
    parts = blocks.spread @ np.concatenate([np.broadcast_to(np.eye(ROWS), blocks.spread.shape), reach], axis=2)
    variance = ((parts[:, :3] ** 2).sum(axis=2) * blocks.used[:, :3]).sum(axis=1)  # the reading's own, and the fit's
    return _Predicted(blocks.off, variance, probability)


def _are_foreseen(station: Ints, held: Ints, training: Mask) -> Mask:
    """Which held rows are measured from a place that the others know too."""
    known = set(station[training[: len(station)]].tolist()) | {-1}
    return np.array([int(station[row]) in known for row in held], dtype=bool)


def _compute_norms(off: Array) -> Array:
    """Lengths of what was measured of vectors (n, k); NaN where nothing was."""
    measured = np.isfinite(off).any(axis=1)
    return np.where(measured, np.sqrt(np.nansum(off**2, axis=1)), np.nan)
