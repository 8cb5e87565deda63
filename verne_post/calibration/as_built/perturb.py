"""A simulated machine: parts that deviate at random within tolerances, and what instruments would read on it."""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.calibration.as_built.data import COMMANDED_EXACTLY, JointUncertainty
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.model.deviations import Deviations


def simulate_tips(
    machine: AsBuiltMachine,
    joints: Array,
    length: Array,
    sigma: float,
    seed: int,
    joint_sigma: JointUncertainty = COMMANDED_EXACTLY,
) -> Array:
    """Tips (n, 3), table frame, that an instrument of uncertainty ``sigma`` (mm) reads at commanded joints (n, 5)."""
    random = np.random.default_rng(seed)
    noise = sigma * random.standard_normal((len(joints), 3))
    tip, _axis, _ok = machine.forward(joints + joint_sigma.spread * random.standard_normal(joints.shape), length)
    return np.asarray(tip + noise)


def draw_deviations(seed: int, tolerances: Array) -> Deviations:
    """Normal deviations of all 58 parameters.

    Parameters
    ----------
    seed : int
        The same seed gives the same machine.
    tolerances : ndarray, shape (58,)
        Standard deviations, mm and rad.
    """
    return Deviations.build_from_vector(tolerances * np.random.default_rng(seed).standard_normal(len(tolerances)))
