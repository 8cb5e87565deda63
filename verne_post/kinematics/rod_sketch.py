"""Rods for a picture: at their own places where the machine file says where these are."""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.kinematics.as_built.bodies import place_rod_ends
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.kinematics.five_axis import HybridMachine
from verne_post.model.deviations import Deviations
from verne_post.model.machine import Machine
from verne_post.model.poses import Platform


def sketch_rods(machine: Machine, q: Array, platform: Platform) -> Array:
    """Rods (n, k, 2, 3) from slider to platform, base frame, mm, for joints (n, n_joints) and platforms (n,).

    With ``rod_places`` there are all six of a VERNE; without, one a rod equation, drawn where the module puts it.
    """
    nominal = machine.five_axis
    if machine.rod_places is None or not isinstance(nominal, HybridMachine):
        return nominal.sketch(q, platform)
    geometry = AsBuiltMachine(nominal, machine.rod_places, Deviations.build_nominal()).geometry
    return np.stack(place_rod_ends(geometry, q[:, :3], platform), axis=2)
