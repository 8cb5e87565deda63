"""The rods of a carrier that is described by them, as arrays: joints, rails, lengths, and single rods at a pose."""

from collections.abc import Sequence
from functools import cached_property
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints
from verne_post.base.rotations import rotate_x

#: Rods may miss each other's slider by this, mm: files give lengths and places with nine digits.
CLOSED: Final = 1e-6


class Rod(Struct, frozen=True):
    """One rod: joints on the platform and on the slider at 0, direction of the rail (any length), length, actuator."""

    platform: Sequence[float]
    slider: Sequence[float]
    rail: Sequence[float]
    length: float
    by: str


class RodGeometry(Struct, frozen=True, dict=True, eq=False):
    """Six rods on three sliders."""

    home: Sequence[float]  #: P (3,) with the platform upright.
    home_mm: Sequence[float]  #: About where the three sliders are then: they choose the side of each rod on its rail.
    rod: Sequence[Rod]  #: Six.
    largest_tilt_deg: float  #: Assemblies that tilt more are not the machine's.
    actuators: tuple[str, ...] = ("rho1", "rho2", "rho3")  #: Names of the three sliders.
    key: str = "rod"  #: Of the rods in the machine file.

    @cached_property
    def ends(self) -> Array:
        """Joints on the platform (6, 3), platform frame."""
        return np.array([rod.platform for rod in self.rod], dtype=float)

    @cached_property
    def feet(self) -> Array:
        """Joints on the sliders at 0, (6, 3)."""
        return np.array([rod.slider for rod in self.rod], dtype=float)

    @cached_property
    def rails(self) -> Array:
        """Unit vectors along the rails, (6, 3)."""
        rails = np.array([rod.rail for rod in self.rod], dtype=float)
        return np.asarray(rails / np.linalg.norm(rails, axis=-1, keepdims=True))

    @cached_property
    def rod_lengths(self) -> Array:
        """Of the rods (6,)."""
        return np.array([rod.length for rod in self.rod], dtype=float)

    @cached_property
    def slider_of(self) -> Array:
        """Number of the actuator of each rod, (6,)."""
        return np.array([self.actuators.index(rod.by) for rod in self.rod])

    @cached_property
    def first_rods(self) -> Array:
        """The first rod of each actuator, (3,)."""
        return np.array([int(np.flatnonzero(self.slider_of == k)[0]) for k in range(3)])

    @cached_property
    def sides(self) -> Array:
        """1 where home has the platform's end ahead of the slider's along the rail, else -1; (6,)."""
        along = ((np.array(self.home) + self.ends - self.feet) * self.rails).sum(axis=-1)
        return np.where(along >= np.array(self.home_mm)[self.slider_of], 1.0, -1.0)

    @cached_property
    def arm(self) -> float:
        """Mean distance of the platform's joints from their middle, mm: what a turn counts by."""
        return float(np.linalg.norm(self.ends - self.ends.mean(axis=0), axis=-1).mean())

    @cached_property
    def tilts(self) -> bool:
        """Whether the platform's tilt follows from its place: not so where the rods of every actuator stay parallel."""
        shift = self.ends - self.feet
        return not all(self._are_same(shift, k, int(self.first_rods[self.slider_of[k]])) for k in range(6))

    def _are_same(self, places: Array, i: int, j: int) -> bool:
        """Whether two rods have the same places (6, ...), rail and length."""
        data = np.concatenate([places, self.rails, self.rod_lengths[:, None]], axis=-1)
        return bool(np.abs(data[i] - data[j]).max() < CLOSED)

    @cached_property
    def distinct(self) -> Ints:
        """Rods (m,) without those that stay parallel to another one of their actuator."""
        shift = self.ends - self.feet
        places = np.concatenate([shift, self.ends[:, 1:]], axis=-1) if self.tilts else shift
        same = [
            any(self.slider_of[k] == self.slider_of[i] and self._are_same(places, i, k) for i in range(k))
            for k in range(6)
        ]
        return np.flatnonzero(~np.array(same))

    @property
    def shortest_rod(self) -> float:
        """Length of the shortest rod, mm."""
        return float(self.rod_lengths.min())

    def find_sliders(self, centre: Array, alpha: Array, arms: Array) -> tuple[Array, Array]:
        """:meth:`move_sliders` to ``w = centre + Rx(alpha) arm - b``."""
        return self.move_sliders(centre[..., None, :] + rotate_x(arms, alpha[..., None]) - self.feet)

    def move_sliders(self, away: Array) -> tuple[Array, Array]:
        """Sliders (..., 6), one for each rod, that reach w (..., 6, 3), and squared drops along the rails."""
        along = (away * self.rails).sum(axis=-1)
        drops2 = self.rod_lengths**2 - (away**2).sum(axis=-1) + along**2
        return along - self.sides * np.sqrt(np.maximum(drops2, 0.0)), drops2

    def find_vectors(self, position: Array, alpha: Array, rho: Array) -> Array:
        """Vectors along the rods (..., 6, 3), from slider to platform."""
        ends = position[..., None, :] + rotate_x(self.ends, alpha[..., None])
        return np.asarray(ends - self.feet - rho[..., self.slider_of, None] * self.rails)
