"""A linear delta: three vertical sliders, three parallelograms, a platform that only translates.

Leg i stands at the angle theta_i about z, its slider joint at the base radius and its platform joint at the platform
radius. A parallelogram keeps the platform parallel to the base, so the tilt alpha is 0 and leg i is one rod equation,

    (x - d cos theta_i)^2 + (y - d sin theta_i)^2 + (z - rho_i)^2 = L^2,    d = base radius - platform radius:

P lies on three spheres of radius L about (d cos theta_i, d sin theta_i, rho_i). Base frame: z and rho point down; mm,
rad. In the *working mode* every slider joint is above the platform joint of its leg, and P is below the plane of the
three sphere centres. Where the two sides of that plane meet, the rods lie in it: the parallel singularity.
"""

from collections.abc import Sequence
from itertools import product
from typing import ClassVar

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.base.conditioning import find_reciprocal_condition
from verne_post.base.units import RAD_PER_DEG
from verne_post.kinematics.modules.solutions import build_determinant_margin, drop_margins, make_triple, place_upright
from verne_post.model.protocols import ForwardSolution, InverseSolution, Margin

_BEYOND = "beyond a parallel singularity: the platform is not below the plane of the slider joints"


class LinearDeltaModule(Struct, frozen=True):
    """Lengths in mm; ``leg_angles_deg`` counts from x towards y of the base frame."""

    platform_radius: float
    base_radius: float
    rod_length: float
    leg_angles_deg: Sequence[float]

    actuators: ClassVar[tuple[str, ...]] = ("rho1", "rho2", "rho3")

    @property
    def _feet(self) -> Array:
        """Sphere centres seen from above, shape (3, 2): ``d (cos theta, sin theta)``, mm."""
        theta = RAD_PER_DEG * np.array(self.leg_angles_deg, dtype=float)
        return (self.base_radius - self.platform_radius) * np.stack([np.cos(theta), np.sin(theta)], axis=-1)

    # --- inverse -------------------------------------------------------------------------------

    def _compute_radicands(self, position: Array) -> Array:
        """Squared vertical drops of the three rods, shape (..., 3), mm2."""
        away = np.asarray(position, dtype=float)[..., None, :2] - self._feet
        return self.rod_length**2 - np.sum(away**2, axis=-1)

    def _compute_rods(self, position: Array, rho: Array) -> Array:
        """Vectors along the rods, shape (..., 3, 3): rod by component, mm."""
        rods = np.empty((*np.shape(rho), 3))
        rods[..., :2] = position[..., None, :2] - self._feet
        rods[..., 2] = position[..., 2, None] - rho
        return rods

    def sketch(self, position: Array, alpha: Array, rho: Array) -> Array:
        """Rods (n, 3, 2, 3) for a picture: the middle of each parallelogram, from slider to platform."""
        del alpha
        rods = self._compute_rods(position, rho)
        angle = RAD_PER_DEG * np.array(self.leg_angles_deg)
        aside = self.platform_radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(3)], axis=-1)
        platform = position[..., None, :] + aside
        return np.stack([platform - rods, platform], axis=-2)

    def _measure_below_plane(self, position: Array, rho: Array) -> Array:
        """Triple product of the rods, shape (...), mm3: positive where P is below the plane of the sphere centres.

        It is the determinant of the rod equations' derivatives by x, y, z, up to a constant.
        """
        feet, rods = self._feet, self._compute_rods(position, rho)
        u, v, w = rods[..., 0, :], rods[..., 1, :], rods[..., 2, :]
        (ax, ay), (bx, by) = feet[1] - feet[0], feet[2] - feet[0]
        # the sign is negative where the legs are numbered clockwise
        return np.sign(ax * by - ay * bx) * np.sum(u * np.cross(v, w), axis=-1)

    def inverse(self, position: Array) -> tuple[Array, Array, Mask]:
        """Sliders for a platform position, in the working mode: ``rho_i = z - sqrt(radicand_i)``, alpha = 0.

        Not ok where a rod is too short, or P is beyond a parallel singularity.
        """
        point = np.asarray(position, dtype=float)
        with np.errstate(invalid="ignore", over="ignore"):
            radicands = self._compute_radicands(point)
            rho = point[..., 2, None] - np.sqrt(radicands)
            ok = (
                (radicands > 0).all(axis=-1)
                & (self._measure_below_plane(point, rho) > 0)
                & np.isfinite(rho).all(axis=-1)
            )
        return np.where(ok[..., None], rho, np.nan), np.where(ok, 0.0, np.nan), ok

    def solve_coupled(self, pivot: Array, gauge: Array) -> tuple[Array, Array, Mask]:
        """Sliders for ``pivot + F gauge`` (3,), (..., 3); as :meth:`inverse`, because nothing tilts."""
        return self.inverse(place_upright(pivot, gauge))

    def explain_unreachable(self, pivot: Array, gauge: Array) -> list[str]:
        """Finding codes of poses (m, 3) without a solution: VP110, rod too short; VP203, a parallel singularity."""
        with np.errstate(invalid="ignore", over="ignore"):
            radicands = self._compute_radicands(place_upright(pivot, gauge))
        return ["VP203" if (row > 0).all() else "VP110" for row in radicands]

    # --- forward -------------------------------------------------------------------------------

    def forward(self, rho: Array) -> tuple[Array, Array, Mask]:
        """Platform position for slider coordinates, in the working mode: the lower meeting point of three spheres.

        Ok where they meet and every slider is above the platform.
        """
        sliders = np.asarray(rho, dtype=float)
        with np.errstate(invalid="ignore", over="ignore"):
            foot, normal, height2 = self._intersect_spheres(sliders)
            position = foot + np.sqrt(height2)[..., None] * normal
            ok = (height2 > 0) & (position[..., 2, None] > sliders).all(axis=-1) & np.isfinite(position).all(axis=-1)
        return np.where(ok[..., None], position, np.nan), np.where(ok, 0.0, np.nan), ok

    def _intersect_spheres(self, rho: Array) -> tuple[Array, Array, Array]:
        """Where the three spheres meet: ``foot +- sqrt(height2) normal``, the normal unit and downwards.

        Two differences of the rod equations are planes; they meet in the line through the centre of the circle around
        the three sphere centres (foot), at right angles to their plane. Its cut with a sphere is ``height2``, negative
        where there is none.
        """
        centres = np.empty((*np.shape(rho), 3))
        centres[..., :2] = self._feet
        centres[..., 2] = rho
        u, v = centres[..., 1, :] - centres[..., 0, :], centres[..., 2, :] - centres[..., 0, :]
        normal = np.cross(u, v)
        size2 = np.sum(normal**2, axis=-1, keepdims=True)
        u2, v2 = np.sum(u**2, axis=-1, keepdims=True), np.sum(v**2, axis=-1, keepdims=True)
        out = np.cross(u2 * v - v2 * u, normal) / (2 * size2)  # from the first centre to the circle's
        height2 = self.rod_length**2 - np.sum(out**2, axis=-1)
        return centres[..., 0, :] + out, normal * (np.sign(normal[..., 2:]) / np.sqrt(size2)), height2

    # --- every solution --------------------------------------------------------------------------

    def inverse_all(self, position: Array) -> list[InverseSolution]:
        """All eight working modes ``rho_i = z + s_i sqrt(radicand_i)`` of one position (3,), none where a rod is short.

        Each has the reason why it is refused; the one in use comes first.
        """
        point = np.asarray(position, dtype=float)
        with np.errstate(invalid="ignore", over="ignore"):
            radicands = self._compute_radicands(point)
        if not ((radicands >= 0).all() and np.isfinite(point).all()):
            return []
        solutions = []
        for signs in product((-1, 1), repeat=3):
            rho = point[2] + np.array(signs) * np.sqrt(radicands)
            solutions.append(InverseSolution(0.0, signs, make_triple(rho), self._find_refusal(point, rho)))
        return sorted(solutions, key=lambda one: (one.refused is not None, one.signs))

    def forward_all(self, rho: Array) -> list[ForwardSolution]:
        """Both assembly modes of one set of sliders (3,), none where the spheres do not meet; the one in use first."""
        sliders = np.asarray(rho, dtype=float)
        with np.errstate(invalid="ignore", over="ignore"):
            foot, normal, height2 = self._intersect_spheres(sliders)
        if not height2 >= 0:
            return []
        solutions = []
        for side in (1.0, -1.0):
            position = foot + side * np.sqrt(height2) * normal
            solutions.append(ForwardSolution(make_triple(position), 0.0, self._find_refusal(position, sliders)))
        return sorted(solutions, key=lambda one: one.refused is not None)

    def _find_refusal(self, position: Array, rho: Array) -> str | None:
        """Why a pair of position (3,) and sliders (3,) is not the machine's."""
        reasons = [
            f"attachment of {name} not above the platform's"
            for name, slider in zip(self.actuators, rho, strict=True)
            if slider >= position[2]
        ]
        if self._measure_below_plane(position, rho) <= 0:
            reasons.append(_BEYOND)
        return "; ".join(reasons) or None

    def solve_coupled_all(self, pivot: Array, gauge: Array) -> list[InverseSolution]:
        """As :meth:`inverse_all` for ``pivot + F gauge``, because nothing tilts."""
        return self.inverse_all(place_upright(pivot, gauge))

    # --- velocities --------------------------------------------------------------------------------

    def find_jacobians(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Half the derivatives of the rod equations and of ``alpha = 0``: (..., 4, 4) by pose, (..., 4, 3) by rho."""
        rods = self._compute_rods(position, rho)
        parallel = np.zeros((*np.shape(rho)[:-1], 4, 4))
        parallel[..., :3, :3] = rods
        parallel[..., 3, 3] = 1.0
        serial = np.zeros((*np.shape(rho)[:-1], 4, 3))
        serial[..., np.arange(3), np.arange(3)] = -rods[..., 2]
        return parallel, serial

    def measure_conditioning(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Reciprocal condition numbers of the rods' directions and of their drops, each (...)."""
        rods = self._compute_rods(position, rho)
        drops = np.abs(rods[..., 2])
        return find_reciprocal_condition(rods), drops.min(axis=-1) / drops.max(axis=-1)

    # --- margins ---------------------------------------------------------------------------------

    def find_geometry_margins(self, position: Array, alpha: Array) -> Array:
        """Vertical drops of the three rods (mm), then the determinant of the rods' directions; shape (..., 4)."""
        drops = np.sqrt(np.maximum(self._compute_radicands(position), 0.0))
        determinant = self._measure_below_plane(position, position[..., 2, None] - drops) / self.rod_length**3
        return np.concatenate([drops, determinant[..., None]], axis=-1)

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`find_geometry_margins` measures, with thresholds (mm; the determinant has no unit)."""
        return (*drop_margins(self.actuators, serial_singularity), build_determinant_margin(parallel_singularity))
