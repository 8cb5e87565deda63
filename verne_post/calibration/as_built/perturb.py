"""A simulated machine: parts that deviate at random within tolerances, and what instruments would read on it."""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.model.deviations import Deviations


def simulate_tips(machine: AsBuiltMachine, joints: Array, length: Array, sigma: float, seed: int) -> Array:
    """Tips (n, 3) that an instrument of uncertainty ``sigma`` (mm) reads on a machine at joints (n, 5), table frame."""
    tip, _axis, _ok = machine.forward(joints, length)
    return np.asarray(tip + sigma * np.random.default_rng(seed).standard_normal(tip.shape))


def draw_deviations(seed: int, tolerances: Array) -> Deviations:
    """Normal deviations of all 58 parameters.

    Parameters
    ----------
    seed : int
        The same seed gives the same machine.
    tolerances : ndarray, shape (58,)
        Standard deviations, mm and rad.
    """
    return Deviations.from_vector(tolerances * np.random.default_rng(seed).standard_normal(len(tolerances)))
