"""The lengths of the VERNE module, and what follows from them alone.

Equation numbers refer to Kanaan, Wenger, Chablat, *Kinematics analysis of the parallel module of the VERNE machine*.
Base frame: z points down, x along the line from leg pair II/III to leg I; mm, rad. The *working mode* is the one that
the machine uses: every attachment point of a slider above the platform's (s1 = s2 = s3 = -1) and uncrossed rods of
leg I (R1 cos alpha > r1).
"""

from typing import ClassVar

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array


class VerneGeometry(Struct, frozen=True):
    """Lengths of the module, with the paper's symbols (mm).

    ``leg1_x_offset`` is D1 - d1, ``leg23_x_offset`` D2 - d2: only these differences enter.
    """

    leg1_x_offset: float
    R1: float
    r1: float
    L1: float
    leg23_x_offset: float
    R2: float
    r4: float
    L2: float
    L3: float

    actuators: ClassVar[tuple[str, ...]] = ("rho1", "rho2", "rho3")

    @property
    def crossing_angle(self) -> float:
        """The tilt at which the rods of leg I would cross: R1 cos(alpha) = r1."""
        return float(np.arccos(self.r1 / self.R1))

    def group_lengths_by_equation(self) -> tuple[Array, Array, Array, Array]:
        """X offset, platform arm, slider arm and rod length (4,) of the equations (3), (4), (5), (6)."""
        return (
            np.array([self.leg1_x_offset, self.leg1_x_offset, self.leg23_x_offset, self.leg23_x_offset]),
            np.array([self.R1, self.R1, self.R2, self.R2]),
            np.array([self.r1, self.r1, self.r4, self.r4]),
            np.array([self.L1, self.L1, self.L2, self.L3]),
        )

    def find_radicands(self, x: Array, y: Array, cos_alpha: Array) -> Array:
        """Radicands of (11), (12), (13), shape (3, ...): squared vertical drops of the three legs, mm2."""
        x1, x2 = x + self.leg1_x_offset, x + self.leg23_x_offset
        arm = self.R2 * cos_alpha - self.r4
        leg1 = self.L1**2 - (self.R1**2 + self.r1**2 - 2 * self.R1 * self.r1 * cos_alpha)
        squares = np.empty((3, *np.shape(y)))
        squares[0] = leg1 - x1**2 - y**2
        squares[1] = self.L2**2 - x2**2 - (y - arm) ** 2
        squares[2] = self.L3**2 - x2**2 - (y + arm) ** 2
        return squares

    def find_workspace_middle(self) -> tuple[float, float]:
        """A point in the middle of the workspace: x of P and the drop of leg I there, mm."""
        x = -0.5 * (self.leg1_x_offset + self.leg23_x_offset)
        drop2 = self.L1**2 - (self.R1 - self.r1) ** 2 - (x + self.leg1_x_offset) ** 2
        return x, float(np.sqrt(max(drop2, (0.25 * self.L1) ** 2)))
