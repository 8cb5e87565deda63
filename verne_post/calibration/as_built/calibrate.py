"""A calibration from readings: deviations, what stays uncertain, and the tool errors before and after."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.calibration.as_built.data import Prior
from verne_post.calibration.as_built.equations import Measurement
from verne_post.calibration.as_built.fit import BadReading, Fit, HeldOut, fit_robustly, hold_out
from verne_post.calibration.as_built.prediction import (
    ErrorsAfter,
    ToolErrors,
    predict_errors_after,
    predict_errors_before,
)
from verne_post.calibration.as_built.workspace import WorkspacePoses
from verne_post.calibration.data import Direction
from verne_post.calibration.solver import name_directions
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.model.deviations import PARAMETERS
from verne_post.model.protocols import FiveAxis

#: A direction counts as determined when its standard deviation is below this share of the one before the readings.
DETERMINED: Final = 0.9
#: Below this probability readings contradict their uncertainties, or the machine its tolerances: chance of 1 in 1000.
CONTRADICTED: Final = 1e-3
#: Parameters named where most of the tip error that is left comes from.
NAMED: Final = 3


class Calibration(Struct, frozen=True, eq=False):
    """What the readings say."""

    fit: Fit
    kept: Mask  #: (n,): Readings that were used, tools first, then lengths.
    bad: tuple[BadReading, ...]
    held: HeldOut | None
    determined: int  #: Directions of the 58 deviations that the readings narrow down.
    undetermined: tuple[Direction, ...]  #: The others, the simplest first, in tolerances of each parameter.
    #: float): Parameters and their shares (tolerances) in the direction that still moves the tip most.
    left: tuple[tuple[str, float], ...]
    left_share: float  #: Its share of the mean square tip error that is left.
    before: ToolErrors
    after: ErrorsAfter  #: Over the workspace, see :mod:`verne_post.calibration.as_built.prediction`.

    @property
    def contradicted(self) -> bool:
        """Fit, or prediction of readings from the others, is too far off for the stated uncertainties."""
        held = self.held is not None and self.held.probability < CONTRADICTED
        return self.fit.probability < CONTRADICTED or held


def calibrate(
    measurement: Measurement, prior: Prior, present: FiveAxis, machine: AsBuiltMachine, poses: WorkspacePoses
) -> Calibration:
    """Fit, validate and describe.

    Parameters
    ----------
    present : FiveAxis
        Makes the joints until now; its errors are those before.
    machine : AsBuiltMachine
        The same with its as-built kinematics.
    poses : WorkspacePoses
        Where errors are evaluated.

    Raises
    ------
    ArithmeticError
        The rods do not close at a reading.
    """
    fit, kept, bad = fit_robustly(measurement, prior)
    held = hold_out(measurement, prior, kept)
    scale = np.sqrt((prior.factor**2).sum(axis=1))
    size, directions = np.linalg.eigh(fit.covariance / np.outer(scale, scale))
    if (prior.factor == np.diag(np.diag(prior.factor))).all():
        lost = directions[:, np.sqrt(size) >= DETERMINED]
    else:  # what was known before is no ball: seen in its own directions
        inner = np.linalg.solve(prior.factor, fit.factor[: len(scale)])
        size, turned = np.linalg.eigh(inner @ inner.T)
        lost = np.linalg.qr((prior.factor / scale[:, None]) @ turned[:, np.sqrt(size) >= DETERMINED])[0]
    named = sorted(name_directions(lost, PARAMETERS), key=lambda direction: len(direction.coefficients))
    after = predict_errors_after(machine, fit.deviations, fit.factor, poses)
    left, share = _find_largest_left(measurement, fit, scale, poses)
    return Calibration(
        fit,
        kept,
        bad,
        held,
        len(scale) - lost.shape[1],
        tuple(named),
        left,
        share,
        predict_errors_before(measurement.model, fit.deviations, present, poses),
        after,
    )


def _find_largest_left(
    measurement: Measurement, fit: Fit, scale: Array, poses: WorkspacePoses
) -> tuple[tuple[tuple[str, float], ...], float]:
    """The direction that leaves most of the mean square tip error, by its largest parameters, and its share."""
    factor = fit.factor[: len(scale)]
    rates = measurement.model.differentiate(fit.deviations, poses.joints, poses.length)[1]
    moved = (rates.tip @ factor).reshape(-1, factor.shape[1])
    size, turn = np.linalg.eigh(moved.T @ moved)
    direction = factor @ turn[:, -1] / scale
    direction *= np.sign(direction[np.argmax(np.abs(direction))])
    order = np.argsort(-np.abs(direction))[:NAMED]
    return tuple((PARAMETERS[k], float(direction[k])) for k in order), float(size[-1] / size.sum())
