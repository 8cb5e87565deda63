"""Differences of a warm machine from the calibrated one: rods of a leg grow alike, zeros shift, the table rises.

The table's height and the mean of the three zeros cannot be told apart: moving the table is moving all sliders. So the
drift has six unknowns, three growths and three zeros, and the common part of the zeros is called the table's height.
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.calibration.as_built.data import Prior, build_prior_of_covariance
from verne_post.kinematics.as_built.geometry import LEG, AsBuiltGeometry
from verne_post.kinematics.as_built.parameter_rates import COUNT, PLACES

#: How far growth and zeros of a warm machine may be, mm: a rod of 950 mm of steel grows 0.01 mm a degree.
DRIFT_MM: Final = 0.05


class Drift(Struct, frozen=True, eq=False):
    """The result of a touch-up, mm: growth of rods and shift of sliders' zeros by leg (3,), with uncertainties.

    ``height`` is how far the table has come nearer to the platform, the mean shift of the zeros with its sign changed;
    ``zeros`` are without it.
    """

    growth: Array
    growth_sigma: Array
    zeros: Array
    zeros_sigma: Array
    height: float
    height_sigma: float


def find_drift_directions(geometry: AsBuiltGeometry) -> Array:
    """Changes of the deviations (58, 6) by a growth of 1 mm of the rods of each leg, and by a zero of each slider."""
    directions = np.zeros((COUNT, 6))
    for rod, leg in enumerate(LEG):
        directions[PLACES["rod_lengths"].start + rod, leg] = 1.0
        first = PLACES["slider_ends"].start + 3 * rod
        directions[first : first + 3, 3 + leg] = geometry.guides[rod]
    return directions


def build_prior_of_drift(calibrated: Array, covariance: Array, directions: Array, drift: float) -> Prior:
    """The calibrated deviations (58,) with what the calibration left open, and a drift (mm) on top."""
    return build_prior_of_covariance(calibrated, covariance + drift**2 * directions @ directions.T)


def split_drift(before: Array, after: Array, prior: Prior, posterior: Array, directions: Array, drift: float) -> Drift:
    """How much of a change of the deviations (58,) is drift, with what is left open.

    Given the deviations, the drift does not depend on the readings: its expectation is a linear function of them.
    """
    total = prior.factor @ prior.factor.T
    gain = drift**2 * np.linalg.solve(total, directions).T  # (6, 58)
    found = gain @ (after - before)
    spread = drift**2 * (np.eye(6) - gain @ directions) + gain @ posterior @ gain.T
    mean = np.full((3, 3), 1.0 / 3.0)
    apart = np.eye(3) - mean
    zeros = spread[3:, 3:]
    return Drift(
        growth=found[:3],
        growth_sigma=np.sqrt(np.diag(spread)[:3]),
        zeros=apart @ found[3:],
        zeros_sigma=np.sqrt(np.diag(apart @ zeros @ apart)),
        height=float(-found[3:].mean()),
        height_sigma=float(np.sqrt(zeros.mean())),
    )
