"""What a machine with given deviations would measure, and how that changes with each of them."""

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.kinematics.as_built.forward import PlatformPose
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.kinematics.as_built.parameter_rates import ToolRates, differentiate_tool
from verne_post.model.deviations import Deviations


class Prediction(Struct, frozen=True, eq=False):
    """Tip (n, 3) in mm and tool axis (n, 3), from tip to spindle, in the table frame; where the rods close (n,)."""

    tip: Array
    axis: Array
    ok: Mask


class AsBuiltModel(Struct, frozen=True, eq=False):
    """A machine whose parts deviate by a vector of 58 numbers (mm, rad), in place of its own deviations.

    Joints (n, 5) are rho1, rho2, rho3 in mm, A and C in rad; lengths (n,) are from the gauge line to the tip, mm.
    """

    machine: AsBuiltMachine

    def predict(self, deviations: Array, joints: Array, length: Array) -> Prediction:
        """Where the tool is."""
        return Prediction(*self._make_machine_with(deviations).forward(joints, length))

    def differentiate(self, deviations: Array, joints: Array, length: Array) -> tuple[Prediction, ToolRates]:
        """Where the tool is, and its derivatives by the deviations and by the joints."""
        machine = self._make_machine_with(deviations)
        platform, ok = machine.find_platform(joints)
        pose = PlatformPose(platform.position.T, np.moveaxis(platform.build_matrix(), 0, -1), ok)
        from_platform = np.broadcast_to(length, ok.shape) + machine.nose_offset
        rates = differentiate_tool(machine.geometry, pose, joints[:, :3].T, joints[:, 3:].T, from_platform)
        return Prediction(*machine.forward(joints, length)), rates

    def _make_machine_with(self, deviations: Array) -> AsBuiltMachine:
        return self.machine.replace_deviations(Deviations.build_from_vector(deviations))
