"""What a machine with given deviations would measure, and how that changes with each of them."""

from dataclasses import dataclass

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.kinematics.as_built.forward import PlatformPose, solve_rods, tool_on_table
from verne_post.kinematics.as_built.geometry import AsBuiltGeometry, NominalTable, RodPlaces, place_parts
from verne_post.kinematics.as_built.parameter_rates import ToolRates, tool_rates
from verne_post.kinematics.modules.verne.module import VerneModule
from verne_post.model.deviations import Deviations


@dataclass(frozen=True, eq=False)
class Prediction:
    """Tip (n, 3) in mm and tool axis (n, 3), from tip to spindle, in the table frame; where the rods close (n,)."""

    tip: Array
    axis: Array
    ok: Mask


@dataclass(frozen=True, eq=False)
class AsBuiltModel:
    """The nominal machine, whose parts deviate by a vector of 58 numbers (mm, rad).

    Joints (n, 5) are rho1, rho2, rho3 in mm, A and C in rad; lengths (n,) are from the gauge line to the tip, mm.
    """

    module: VerneModule
    places: RodPlaces
    table: NominalTable

    def predict(self, deviations: Array, joints: Array, length: Array) -> Prediction:
        """Where the tool is."""
        geometry, pose, length = self._solve(deviations, joints, length)
        tip, axis = tool_on_table(geometry, pose, joints[:, 3:].T, length)
        return Prediction(tip.T, axis.T, pose.ok)

    def rates(self, deviations: Array, joints: Array, length: Array) -> tuple[Prediction, ToolRates]:
        """Where the tool is, and its derivatives by the deviations and by the joints."""
        geometry, pose, length = self._solve(deviations, joints, length)
        tip, axis = tool_on_table(geometry, pose, joints[:, 3:].T, length)
        rates = tool_rates(geometry, pose, joints[:, :3].T, joints[:, 3:].T, length)
        return Prediction(tip.T, axis.T, pose.ok), rates

    def _solve(self, deviations: Array, joints: Array, length: Array) -> tuple[AsBuiltGeometry, PlatformPose, Array]:
        geometry = place_parts(self.module, self.places, self.table, Deviations.from_vector(deviations))
        position, alpha, _ok = self.module.forward(joints[:, :3])
        c, s, zero = np.cos(alpha), np.sin(alpha), np.zeros_like(alpha)
        one = np.ones_like(alpha)
        start = np.array([[one, zero, zero], [zero, c, -s], [zero, s, c]])
        pose = solve_rods(geometry, joints[:, :3].T, position.T, start)
        return geometry, pose, np.broadcast_to(length, alpha.shape) + geometry.nose_offset
