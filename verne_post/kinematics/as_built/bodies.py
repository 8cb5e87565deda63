"""The rods of the VERNE as bodies at their places, nominal or as built, for distances between them."""

from typing import ClassVar

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.kinematics.as_built.forward import find_rod_vectors
from verne_post.kinematics.as_built.geometry import AsBuiltGeometry
from verne_post.kinematics.modules.verne.geometry import VerneGeometry
from verne_post.kinematics.modules.verne.inverse import solve_inverse
from verne_post.model.poses import Platform


class VerneRods(Struct, frozen=True, eq=False):
    """The six rods at their places; implements ``RodModule``.

    The nominal kinematics need only D1 - d1 and D2 - d2. Distances between legs need the joints' own places: as built
    in ``geometry``, as drawn in ``drawn``.
    """

    module: VerneGeometry
    geometry: AsBuiltGeometry
    drawn: AsBuiltGeometry

    rod_legs: ClassVar[tuple[str, ...]] = ("I", "I", "II", "II", "III", "III")
    parallelograms: ClassVar[tuple[str, ...]] = ("II", "III")

    @property
    def shortest_rod(self) -> float:
        """Length of the shortest rod, mm."""
        return float(self.geometry.rods.min())

    def find_rod_directions(self, position: Array) -> tuple[Array, Array]:
        """Directions of the rods (6, 3) at a position (3,) of P, as drawn: in the base frame, and in the platform's."""
        rho, alpha, _ok = solve_inverse(self.module, position[None])
        platform = Platform(position[None], np.array([[float(alpha[0]), 0.0, 0.0]]))
        start, end = place_rod_ends(self.drawn, rho, platform)
        direction = (end - start) / np.linalg.norm(end - start, axis=-1, keepdims=True)
        return direction[0], platform.add_axis().turn_back(direction)[0]

    def find_rod_ends(self, rho: Array, platform: Platform) -> tuple[Array, Array]:
        """Ends of the rods at slider and platform, each (n, 6, 3), base frame, mm."""
        return place_rod_ends(self.geometry, rho, platform)


def place_rod_ends(geometry: AsBuiltGeometry, rho: Array, platform: Platform) -> tuple[Array, Array]:
    """Ends of the rods at slider and platform for sliders (n, 3), each (n, 6, 3), base frame, mm."""
    rotation = np.moveaxis(platform.build_matrix(), 0, -1)
    position = platform.position.T
    vectors, arms = find_rod_vectors(geometry, rho.T, position, rotation)
    ends = position[:, None] + arms
    return np.moveaxis(ends - vectors, -1, 0).swapaxes(1, 2), np.moveaxis(ends, -1, 0).swapaxes(1, 2)
