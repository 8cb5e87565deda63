"""Lengths of a module from measured pairs of sliders and platform poses.

Sliders and poses are both measured, each with its own uncertainty. So this is a fit with errors in all variables: the
smallest corrections, counted in uncertainties, that let every rod close. The outer fit is over the lengths alone
(``solver``); for given lengths the corrections follow from the loop equations (``adjustment``). The gradient is exact,
and the number of unknowns does not grow with the data. Works on any module with the protocol ``Identifiable``; mm, rad.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec.structs import replace
from scipy.special import chdtrc

from verne_post.calibration.adjustment import adjust_readings, group_settings
from verne_post.calibration.data import Direction, Identification, Readings, Uncertainty
from verne_post.calibration.solver import End, Fit, Starts, fit_random_starts, name_directions, name_lengths, separate
from verne_post.model.findings import make_input_error
from verne_post.model.protocols import Identifiable

__all__ = ["Uncertainty", "identify"]


#: Separability is decided at the solution, which moves a little when a direction is held; two passes settle it.
PASSES: Final = 3


def identify(
    module: Identifiable,
    data: Readings,
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
    held : sequence of str
        Lengths that keep the module's values.
    tied : sequence of sequences of str
        Groups of lengths that are equal.
    starts : int
        Random starts besides the module's own lengths; the best end of all is taken.

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
    columns = _group_lengths(names, held, tied)
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
    groups = group_settings(data.setting)
    whole = Fit(module, data, sigma, groups, origin, basis, lower)
    kept, lost = separate(whole, origin)
    for _ in range(PASSES):
        if not kept.shape[1]:
            raise make_input_error(
                "VP502", "the readings determine none of the lengths to estimate; measure more poses of other kinds"
            )
        fit, turn = whole, np.eye(len(columns))
        if lost.shape[1]:
            fit, turn = replace(whole, basis=basis @ kept, lower=np.full(kept.shape[1], -np.inf)), kept
        end = fit.run(np.zeros(turn.shape[1]))
        held_back = lost.shape[1]
        kept, lost = separate(whole, origin + fit.basis @ end.t)
        if lost.shape[1] == held_back:
            break
    random = fit_random_starts(fit, turn, basis, starts)
    if random.best is not None and random.best.chi_square < end.chi_square:
        end = random.best
    return _report(fit, end, random, columns, name_directions(basis @ lost, names))


def _group_lengths(names: tuple[str, ...], held: Sequence[str], tied: Sequence[Sequence[str]]) -> list[tuple[str, ...]]:
    """Groups of lengths that move as one, in the order of the names."""
    partner = {name: tuple(group) for group in tied for name in group}
    columns: list[tuple[str, ...]] = []
    for name in names:
        group = partner.get(name, (name,))
        if not set(group) & set(held) and group not in columns:
            columns.append(group)
    return columns


def _report(
    fit: Fit, end: End, random: Starts, columns: list[tuple[str, ...]], undetermined: tuple[Direction, ...]
) -> Identification:
    """Lengths, uncertainties and residuals at the end of a fit."""
    names = fit.module.length_names
    lengths = fit.origin + fit.basis @ end.t
    residual, design, states = adjust_readings(fit.module, lengths, fit.data, fit.sigma, fit.groups)
    _u, size, vt = np.linalg.svd(design @ fit.basis, full_matrices=False)
    spread_of_t = fit.basis @ (vt.T / size)
    covariance = spread_of_t @ spread_of_t.T
    estimated = [name for name in names if any(name in group for group in columns)]
    index = [names.index(name) for name in estimated]
    blurred = {name for direction in undetermined for name in direction.coefficients}
    spread = np.sqrt(np.diag(covariance)[index])
    spread = np.where([name in blurred for name in estimated], np.nan, spread)
    correlation = covariance[np.ix_(index, index)] / np.outer(spread, spread)
    n, sliders = fit.data.rho.shape
    off = np.full((n, sliders + 4), np.nan)
    misfit = np.empty((n, states[0].misfit.shape[2]))
    for rows, state in zip(fit.groups, states, strict=True):
        m, k = rows.shape
        off[rows, :sliders] = -state.correction[:, None, :sliders]
        off[rows, sliders:] = -state.correction[:, sliders:].reshape(m, k, 4)
        misfit[rows] = state.misfit
    free = np.isnan(fit.data.pose[:, 3]) | np.isinf(fit.sigma.tilt)
    off[free, -1] = np.nan
    errors = fit.sigma
    sigma = np.array([*sliders * [errors.slider], *3 * [errors.position], errors.tilt, *misfit.shape[1] * [errors.rod]])
    scaled = np.concatenate([off, misfit], axis=1) / np.where(sigma > 0, sigma, np.nan)
    equations = sum(int((~state.dropped).sum()) for state in states)
    chi_square, freedom = float(residual @ residual), equations - len(end.t)
    return Identification(
        lengths=name_lengths(names, lengths),
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
        converged=end.converged,
        landings=random.landings,
        failed_starts=random.failed,
    )
