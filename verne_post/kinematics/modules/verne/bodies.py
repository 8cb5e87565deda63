"""The rods of the VERNE module as bodies, for distances between them."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.kinematics.modules.verne.geometry import VerneGeometry
from verne_post.kinematics.modules.verne.inverse import solve_inverse
from verne_post.kinematics.modules.verne.rods import SIDE, SLIDER, rod_vectors


@dataclass(frozen=True, eq=False)
class VerneRods:
    """The six rods at their places; implements ``RodModule``.

    The kinematics need only D1 - d1 and D2 - d2; distances between legs need the sliders' own places.

    Attributes
    ----------
    leg1_slider_x, leg23_slider_x : float
        d1 and d2: x of the slider's attachments, base frame, mm.
    leg23_spacing : float
        Distance of the two rods of a parallelogram. They lie along x, the only direction that a tilt about x leaves
        parallel to itself, which is why one equation stands for both.
    """

    module: VerneGeometry
    leg1_slider_x: float
    leg23_slider_x: float
    leg23_spacing: float

    rod_legs: ClassVar[tuple[str, ...]] = ("I", "I", "II", "II", "III", "III")
    parallelograms: ClassVar[tuple[str, ...]] = ("II", "III")

    @property
    def shortest_rod(self) -> float:
        """Length of the shortest rod, mm."""
        return min(self.module.L1, self.module.L2, self.module.L3)

    def inverse(self, position: Array) -> tuple[Array, Array, Mask]:
        """As :func:`solve_inverse`."""
        return solve_inverse(self.module, position)

    def rods(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Ends of the rods at slider and platform, each (n, 6, 3), base frame, mm."""
        _offset, _radius, base, _rod = self.module.lengths_by_equation()
        vectors = rod_vectors(self.module, position, alpha, rho)
        slider = np.array([self.leg1_slider_x, self.leg1_slider_x, self.leg23_slider_x, self.leg23_slider_x])
        start = np.stack(
            np.broadcast_arrays(np.broadcast_to(slider, rho[..., SLIDER].shape), SIDE * base, rho[..., SLIDER]), axis=-1
        )
        pick, aside = np.array([0, 1, 2, 2, 3, 3]), np.zeros((6, 3))
        aside[2:, 0] = 0.5 * self.leg23_spacing * np.array([-1.0, 1.0, -1.0, 1.0])
        start, vectors = start[..., pick, :] + aside, vectors[..., pick, :]
        return start, start + vectors
