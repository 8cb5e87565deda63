"""A carrier on three struts of variable length that a central leg guides: a universal joint at the base, and a slide.

Let o be the joint of the leg, n its direction at home, e the first axis of the joint (fixed to the base, across n) and
m = n x e. The platform's point P alone determines how it is turned: in the frame of e, m, n

    P - o = d (sin b, -sin a cos b, cos a cos b),        R = R(e, a) R(m, b),

because the slide keeps the platform's third direction along the leg. The struts from b_k (base) to a_k (platform) are

    l_k = |P + R a_k - b_k|.

The inverse is closed form. The forward solution is Newton from home, or along the way of the struts from home where
that does not close. A solution counts if it closes, has the sign of the Jacobian at home, and turns no farther from
home than the bound. Base frame of the file; mm, rad.
"""

import math
from collections.abc import Sequence
from functools import cached_property
from itertools import product
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.base.conditioning import find_reciprocal_condition, measure_singularity
from verne_post.base.rotations import measure_angles
from verne_post.base.units import RAD_PER_DEG
from verne_post.kinematics.modules.newton import find_poses, follow_from_home

#: Struts may miss their lengths by this, mm: a Newton step on from there changes nothing that setpoints show.
CLOSED: Final = 1e-9
#: The longest Newton step as a share of the leg at home: longer ones leave the assembly.
LONGEST_STEP: Final = 0.3
#: Smallest measure of the Jacobian at home: a singular one is some 1e-17.
SINGULAR: Final = 1e-6
#: Cosine of the angle below which directions are at right angles: digits of a file.
ACROSS: Final = 1e-9
#: How far from home the struts are tried when a machine is loaded, over the leg at home.
TRIED: Final = (-0.1, 0.0, 0.1)


class CentralLeg(Struct, frozen=True, dict=True, eq=False):
    """Three struts and a central leg.

    Raises
    ------
    ValueError
        In a sentence: the leg has no length or its first axis lies along it, the Jacobian is singular at home, or the
        way to a place around home leads to another pose.
    """

    home: Sequence[float]  #: P (3,) where the platform has the directions of the base.
    base: Sequence[float]  #: o (3,), the middle of the leg's universal joint.
    first_axis: Sequence[float]  #: e (3,), of any length.
    #: ends, feet: Joints of the struts on the platform and on the base, (3, 3).
    ends: Sequence[Sequence[float]]
    feet: Sequence[Sequence[float]]
    largest_turn_deg: float  #: Assemblies whose leg is turned farther from home are not the machine's.

    def __post_init__(self) -> None:
        if not self.leg > 0:
            raise ValueError("central.base is home: the central leg has no length there")
        if abs(float(self.frame[:, 0] @ self.frame[:, 2])) > ACROSS:
            raise ValueError("central.first_axis is not at a right angle to the leg at home, from central.base to home")
        home = np.array(self.home, dtype=float)
        measure = abs(float(self.measure(home)))
        if not measure > SINGULAR:
            raise ValueError(
                f"the Jacobian is singular at home: its measure is {measure:.3g}; expected more than {SINGULAR:g}"
            )
        points = home + self.leg * np.array(list(product(TRIED, repeat=3)))
        points = points[self.is_own(points)]
        lengths = self.find_lengths(points)
        way, (found, reached) = follow_from_home(self, lengths), find_poses(self, lengths)
        if not reached.all() or max(np.abs(way - points).max(), np.abs(found - points).max()) > CLOSED:
            raise ValueError(
                "near home the same strut lengths allow more than one position of the platform: choose another home"
            )

    @cached_property
    def leg(self) -> float:
        """Length of the leg at home, mm."""
        return math.dist(self.home, self.base)

    @cached_property
    def frame(self) -> Array:
        """Columns: e, m = n x e, n."""
        n = (np.array(self.home, dtype=float) - self.base) / self.leg
        e = np.array(self.first_axis, dtype=float)
        e = e / np.linalg.norm(e)
        return np.stack([e, np.cross(n, e), n], axis=1)

    @cached_property
    def _ends(self) -> Array:
        return np.array(self.ends, dtype=float)

    @cached_property
    def _feet(self) -> Array:
        return np.array(self.feet, dtype=float)

    # --- the leg ---------------------------------------------------------------------------------------------------

    def find_turn(self, position: Array) -> Array:
        """R (..., 3, 3) of the platform at positions (..., 3) of P."""
        x, y, z = np.moveaxis((position - np.array(self.base)) @ self.frame, -1, 0)
        across = np.hypot(y, z)
        leg = np.hypot(x, across)
        sin_a, cos_a, sin_b, cos_b = -y / across, z / across, x / leg, across / leg
        still = np.zeros_like(x)
        rows = ((cos_b, still, sin_b), (sin_a * sin_b, cos_a, -sin_a * cos_b), (-cos_a * sin_b, sin_a, cos_a * cos_b))
        inner = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
        return np.asarray(self.frame @ inner @ self.frame.T)

    def find_turn_rates(self, position: Array) -> Array:
        """Velocity of turning of the platform by that of P, (..., 3, 3), rad per mm."""
        x, y, z = np.moveaxis((position - np.array(self.base)) @ self.frame, -1, 0)
        across2 = y**2 + z**2
        across, leg2 = np.sqrt(across2), x**2 + across2
        still = np.zeros_like(x)
        by_a = np.stack([still, -z / across2, y / across2], axis=-1)
        by_b = np.stack([across, -x * y / across, -x * z / across], axis=-1) / leg2[..., None]
        about_a = np.stack([still + 1.0, still, still], axis=-1)
        about_b = np.stack([still, z / across, -y / across], axis=-1)
        inner = about_a[..., :, None] * by_a[..., None, :] + about_b[..., :, None] * by_b[..., None, :]
        return np.asarray(self.frame @ inner @ self.frame.T)

    def is_within(self, position: Array) -> Mask:
        """Whether the leg to positions (..., 3) is turned less from home than its bound."""
        away = position - np.array(self.base)
        leg = np.linalg.norm(away, axis=-1)
        return np.asarray(away @ self.frame[:, 2] > math.cos(RAD_PER_DEG * self.largest_turn_deg) * leg)

    def is_own(self, position: Array) -> Mask:
        """Whether positions (..., 3) are the machine's: the leg within its bound, the Jacobian's sign as at home."""
        with np.errstate(invalid="ignore"):
            return np.asarray(
                self.is_within(position) & (np.linalg.det(self.find_rates(position)) * self._home_sign > 0)
            )

    # --- struts ------------------------------------------------------------------------------------------------------

    def find_rods(self, position: Array) -> tuple[Array, Array]:
        """Ends of the struts at base and platform, each (..., 3, 3)."""
        end = position[..., None, :] + self._ends @ np.swapaxes(self.find_turn(position), -1, -2)
        return np.broadcast_to(self._feet, end.shape), end

    def find_lengths(self, position: Array) -> Array:
        """Lengths of the struts (..., 3) at positions (..., 3) of P."""
        foot, end = self.find_rods(position)
        return np.asarray(np.linalg.norm(end - foot, axis=-1))

    def find_rates(self, position: Array) -> Array:
        """Derivatives (..., 3, 3) of the lengths by P."""
        foot, end = self.find_rods(position)
        unit = end - foot
        unit = unit / np.linalg.norm(unit, axis=-1, keepdims=True)
        return np.asarray(unit + np.cross(end - position[..., None, :], unit) @ self.find_turn_rates(position))

    @cached_property
    def _home_sign(self) -> float:
        return float(np.sign(np.linalg.det(self.find_rates(np.array(self.home, dtype=float)))))

    def measure(self, position: Array) -> Array:
        """Signed 1 over the norm of the inverse of :meth:`find_rates`, positive as at home: smooth through 0."""
        return self._home_sign * measure_singularity(self.find_rates(position))

    def measure_conditioning(self, position: Array) -> Array:
        """Reciprocal condition number of :meth:`find_rates`, (...)."""
        return find_reciprocal_condition(self.find_rates(position))

    def measure_cones(self, position: Array) -> tuple[Array, Array]:
        """How far struts are turned from home in their joints, rad: on the base and on the platform, each (..., 3)."""
        (foot, end), (first_foot, first_end) = (
            self.find_rods(position),
            self.find_rods(np.array(self.home, dtype=float)),
        )
        rod, first = end - foot, first_end - first_foot
        of_platform = rod @ self.find_turn(position)  # in its own directions, which are those of the base at home
        return measure_angles(rod, first), measure_angles(of_platform, first)

    # --- forward ---------------------------------------------------------------------------------------------------

    def find_position(self, lengths: Array) -> tuple[Array, Mask]:
        """Positions (..., 3) of P at lengths (..., 3) of the struts, and ok (...): the assembly that home leads to."""
        lengths = np.asarray(lengths, dtype=float)
        position, ok = find_poses(self, lengths.reshape(-1, 3))
        return position.reshape(lengths.shape), ok.reshape(lengths.shape[:-1])

    def find_first(self) -> tuple[Array, Array]:
        """See ``Held``: a pose is P."""
        home = np.array(self.home, dtype=float)
        return home, self.find_lengths(home)

    def differentiate(self, pose: Array, values: Array) -> tuple[Array, Array]:
        """See ``Held``."""
        return self.find_rates(pose), self.find_lengths(pose) - values

    def move_back(self, pose: Array, step: Array) -> tuple[Array, Array]:
        """See ``Held``."""
        size = np.abs(step).max(axis=-1) / self.leg
        return pose - step * np.minimum(1.0, LONGEST_STEP / size)[:, None], size

    def is_closed(self, pose: Array, values: Array) -> Mask:
        """See ``Held``."""
        closed = (np.abs(self.find_lengths(pose) - values) <= CLOSED).all(axis=-1)
        own = np.zeros(len(pose), dtype=bool)
        own[closed] = self.is_own(pose[closed])
        return own
