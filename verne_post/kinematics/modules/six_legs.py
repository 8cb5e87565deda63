"""A platform that six legs hold: struts of variable length, or rods of fixed length on sliders, one actuator to a leg.

Leg k goes from its joint b_k on the base, or on the slider at 0, to a_k on the platform. With R turning the platform at
P,

    away_k = P + R a_k - b_k,      strut: q_k = |away_k|,      rod: |away_k - q_k u_k| = L_k,

    q_k = away_k.u_k - s_k sqrt(L_k^2 - |away_k|^2 + (away_k.u_k)^2)      on the side s_k on which home has the rod.

So the inverse is closed form. The forward solution is Newton from home, or along the way of the actuators from home
where that does not close. A solution counts if it closes, has its rods on their sides and the sign of the Jacobian of
home, and is turned no farther from home than the bound: sides and sign alone do not exclude other assemblies. Base
frame of the file; mm, rad.
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

#: Legs may miss their lengths by this, mm: a Newton step on from there changes nothing that setpoints show.
CLOSED: Final = 1e-9
#: The longest turn of a Newton step, rad: longer ones leave the assembly.
LONGEST_TURN: Final = 0.3
#: Smallest measure of the Jacobian at home: a singular one is some 1e-17.
SINGULAR: Final = 1e-6
#: A rotation vector shorter than this, rad, turns by its first two orders: the third is beyond double precision.
SMALL_TURN: Final = 1e-6
#: Distances from home at which loading tries the legs: a share of the shortest leg, and a turn about each axis, rad.
TRIED: Final = (-0.1, 0.0, 0.1)


class SixLegs(Struct, frozen=True, dict=True, eq=False):
    """Six legs.

    Raises
    ------
    ValueError
        In a sentence: at home a rod does not reach or the Jacobian is singular; or the way around home leads to another
        pose.
    """

    home: Sequence[float]  #: P (3,) where the platform has the directions of the base.
    #: ends, feet: Joints on the platform, and on the base or on the sliders at 0, (6, 3).
    ends: Sequence[Sequence[float]]
    feet: Sequence[Sequence[float]]
    largest_turn_deg: float  #: Assemblies that are turned farther from home are not the machine's.
    rails: Sequence[Sequence[float]] | None = None  #: Directions of the rails (6, 3), of any length; None for struts.
    rods: Sequence[float] | None = None  #: Lengths of the rods (6,); None for struts.
    #: About where the sliders are at home (6,): they choose the side of each rod on its rail.
    home_mm: Sequence[float] | None = None
    keys: Sequence[str] | None = None  #: Of the legs (6,) in the machine file.

    def __post_init__(self) -> None:
        home, still = np.array(self.home, dtype=float), np.eye(3)
        _values, drops2 = self.find_values(home, still)
        if not (drops2 > 0).all():
            k = int(np.argmin(drops2))
            missing = math.sqrt(-drops2[k])
            leg = self.keys[k] if self.keys else f"leg {k + 1}"
            raise ValueError(
                f"{leg}: at home it is {missing:.6g} mm too short to reach its rail"
                if self.rods
                else f"{leg}: it has no length at home"
            )
        measure = abs(float(self._measure(home, still)))
        if not measure > SINGULAR:
            raise ValueError(
                f"at home the legs leave the platform free to move: their Jacobian is singular ({measure:.1g}); "
                "expected joints or a home with which the legs hold it"
            )
        self._try_around_home()

    def _try_around_home(self) -> None:
        """Refuse legs whose actuators lead to another pose around home than the way from home does."""
        steps = np.array(list(product(TRIED, repeat=6)))
        steps = steps[np.abs(steps).sum(axis=-1) < 0.35]  # up to three of the six at once
        position = self.home + self._shortest * steps[:, :3]
        turn = turn_by(steps[:, 3:])
        values, ok = self.inverse(position, turn)
        position, turn, values = position[ok], turn[ok], values[ok]
        wanted = _join(position, turn)
        way, (found, reached) = follow_from_home(self, values), find_poses(self, values)
        if not reached.all() or max(np.abs(poses - wanted).max() for poses in (way, found)) > 1e3 * CLOSED:
            raise ValueError(
                "near home the same actuator values allow more than one position of the platform: choose another home"
            )

    # --- legs ------------------------------------------------------------------------------------------------------

    @cached_property
    def _ends(self) -> Array:
        return np.array(self.ends, dtype=float)

    @cached_property
    def _feet(self) -> Array:
        return np.array(self.feet, dtype=float)

    @cached_property
    def unit_rails(self) -> Array:
        """Unit vectors along the rails (6, 3); 0 for struts."""
        if self.rails is None:
            return np.zeros((6, 3))
        rails = np.array(self.rails, dtype=float)
        return np.asarray(rails / np.linalg.norm(rails, axis=-1, keepdims=True))

    @cached_property
    def _sides(self) -> Array:
        """1 where home has the platform's end ahead of the slider's along the rail, else -1; (6,)."""
        along = ((np.array(self.home) + self._ends - self._feet) * self.unit_rails).sum(axis=-1)
        return np.where(along >= np.array(self.home_mm or np.zeros(6)), 1.0, -1.0)

    @cached_property
    def arm(self) -> float:
        """Mean distance of the platform's joints from their middle, mm: what a turn counts by."""
        return float(np.linalg.norm(self._ends - self._ends.mean(axis=0), axis=-1).mean())

    @cached_property
    def _shortest(self) -> float:
        """Of the legs at home, mm."""
        return float(np.linalg.norm(self.find_vectors(np.array(self.home, dtype=float), np.eye(3)), axis=-1).min())

    def _turn_arms(self, turn: Array) -> Array:
        """R a_k (..., 6, 3)."""
        flat = turn.reshape(-1, 3) @ self._ends.T  # one product of many rows
        return np.swapaxes(flat.reshape(*turn.shape[:-1], 6), -1, -2)

    def _find_away(self, position: Array, turn: Array) -> Array:
        return position[..., None, :] + self._turn_arms(turn) - self._feet

    def find_values(self, position: Array, turn: Array) -> tuple[Array, Array]:
        """Actuators (..., 6) at P (..., 3) turned by R (..., 3, 3); squared drops of rods, or lengths of struts."""
        return self._place_actuators(self._find_away(position, turn))

    def _place_actuators(self, away: Array) -> tuple[Array, Array]:
        """:meth:`find_values` of away (..., 6, 3)."""
        square = sum_squares(away)
        if self.rods is None:
            return np.sqrt(square), square
        x, y, z = self.unit_rails.T
        along = away[..., 0] * x + away[..., 1] * y + away[..., 2] * z
        drops2 = np.array(self.rods) ** 2 - square + along**2
        return along - self._sides * np.sqrt(np.maximum(drops2, 0.0)), drops2

    def find_vectors(self, position: Array, turn: Array, values: Array | None = None) -> Array:
        """Vectors along the legs (..., 6, 3), to the platform, with actuators of the pose or at ``values`` (..., 6)."""
        if values is None:
            values = self.find_values(position, turn)[0]
        return self._shift_feet(self._find_away(position, turn), values)

    def _shift_feet(self, away: Array, values: Array) -> Array:
        """Vectors along legs whose actuators stand at values (..., 6), of away (..., 6, 3)."""
        return away if self.rods is None else away - values[..., None] * self.unit_rails

    def find_legs(self, position: Array, turn: Array, values: Array) -> tuple[Array, Array]:
        """Ends of the legs at base and platform, each (..., 6, 3), with the actuators at ``values`` (..., 6)."""
        foot = self._feet + values[..., None] * self.unit_rails
        return foot, foot + self.find_vectors(position, turn, values)

    def find_rates(self, position: Array, turn: Array) -> Array:
        """Derivatives (..., 6, 6) of the actuators by the platform's motion: velocity of P, and of turning, rad."""
        unit, arms = self._find_units(position, turn)
        rows = np.concatenate([unit, np.cross(arms, unit)], axis=-1)
        return rows if self.rods is None else rows / (unit * self.unit_rails).sum(axis=-1, keepdims=True)

    def _find_units(self, position: Array, turn: Array) -> tuple[Array, Array]:
        """Unit vectors along the legs, and arms R a_k, each (..., 6, 3)."""
        arms = self._turn_arms(turn)
        away = position[..., None, :] + arms - self._feet
        return self._shorten(away, self._place_actuators(away)[0]), np.broadcast_to(arms, away.shape)

    def _shorten(self, away: Array, values: Array) -> Array:
        """Unit vectors along legs whose actuators stand at values (..., 6)."""
        vectors = self._shift_feet(away, values)
        return np.asarray(vectors / np.sqrt(sum_squares(vectors))[..., None])

    # --- which poses are the machine's -------------------------------------------------------------------------------

    def _scale_jacobian(self, position: Array, turn: Array) -> Array:
        """Derivatives (..., 6, 6) of leg lengths by the platform's motion, turns about the joints' middle scaled."""
        unit, arms = self._find_units(position, turn)
        return self._scale_rows(unit, arms - arms.mean(axis=-2, keepdims=True))

    def _scale_rows(self, unit: Array, arms: Array) -> Array:
        """Derivatives (..., 6, 6) of leg lengths along units (..., 6, 3), turns about where the arms begin scaled."""
        rows = np.swapaxes(np.empty((*unit.shape[:-2], 6, 6)), -1, -2)  # motion by motion, as the units lie in memory
        rows[..., :3] = unit
        (a, b, c), (x, y, z) = (np.moveaxis(one, -1, 0) for one in (arms, unit))
        rows[..., 3], rows[..., 4], rows[..., 5] = b * z - c * y, c * x - a * z, a * y - b * x
        rows[..., 3:] /= self.arm
        return rows

    def _measure(self, position: Array, turn: Array) -> Array:
        """Signed 1 over the norm of the scaled Jacobian's inverse, at most its least singular value; smooth at 0."""
        return measure_singularity(self._scale_jacobian(position, turn))

    def measure(self, position: Array, turn: Array) -> Array:
        """The same (...) with the sign against home."""
        return self._home_sign * self._measure(position, turn)

    @cached_property
    def _home_sign(self) -> float:
        return float(np.sign(self._measure(np.array(self.home, dtype=float), np.eye(3))))

    def measure_conditioning(self, position: Array, turn: Array) -> tuple[Array, Array]:
        """Reciprocal condition numbers (...) of the scaled Jacobian, and of rod shares along rails (1 for struts)."""
        parallel = find_reciprocal_condition(self._scale_jacobian(position, turn))
        if self.rods is None:
            return parallel, np.ones_like(parallel)
        shares = np.abs((self._find_units(position, turn)[0] * self.unit_rails).sum(axis=-1))
        return parallel, shares.min(axis=-1) / shares.max(axis=-1)

    def is_within(self, position: Array, turn: Array) -> Mask:
        """Whether every leg reaches, and the platform is turned less from home than its bound."""
        return self._is_within(turn, self.find_values(position, turn)[1])

    def _is_within(self, turn: Array, drops2: Array) -> Mask:
        cosine = 0.5 * (turn[..., 0, 0] + turn[..., 1, 1] + turn[..., 2, 2] - 1.0)
        return np.asarray((drops2 > 0).all(axis=-1) & (cosine > math.cos(RAD_PER_DEG * self.largest_turn_deg)))

    @np.errstate(all="ignore")
    def inverse(self, position: Array, turn: Array) -> tuple[Array, Mask]:
        """Actuators (..., 6) of home's assembly at P (..., 3) turned by R (..., 3, 3), NaN if not ok; and ok (...)."""
        arms = self._turn_arms(turn)
        away = position[..., None, :] + arms - self._feet
        values, drops2 = self._place_actuators(away)
        arms = np.broadcast_to(arms - arms.mean(axis=-2, keepdims=True), away.shape)
        sign = np.linalg.det(self._scale_rows(self._shorten(away, values), arms))
        ok = self._is_within(turn, drops2) & np.isfinite(values).all(axis=-1) & (sign * self._home_sign > 0)
        return np.where(ok[..., None], values, np.nan), np.asarray(ok)

    def measure_cones(self, position: Array, turn: Array) -> tuple[Array, Array]:
        """Turns of legs in their joints from home, rad: on the base or slider, and on the platform, each (..., 6)."""
        legs = self.find_vectors(position, turn)
        first = self.find_vectors(np.array(self.home, dtype=float), np.eye(3))
        return measure_angles(legs, first), measure_angles(legs @ turn, first)

    # --- forward ---------------------------------------------------------------------------------------------------

    def forward(self, values: Array) -> tuple[Array, Array, Mask]:
        """P (..., 3), R (..., 3, 3) and ok (...) of actuators (..., 6), in the assembly of home; NaN if not ok."""
        values = np.asarray(values, dtype=float)
        poses, ok = find_poses(self, values.reshape(-1, 6))
        shape = values.shape[:-1]
        position, turn = _split(poses)
        return position.reshape(*shape, 3), turn.reshape(*shape, 3, 3), ok.reshape(shape)

    def find_first(self) -> tuple[Array, Array]:
        """See ``Held``: a pose is P, and R row by row (12,)."""
        home, still = np.array(self.home, dtype=float), np.eye(3)
        return _join(home, still), self.find_values(home, still)[0]

    def differentiate(self, pose: Array, values: Array) -> tuple[Array, Array]:
        """See ``Held``: what legs miss of their lengths (n, 6), and their rates by P and by turns times the arm."""
        position, turn = _split(pose)
        arms = self._turn_arms(turn)
        vectors = self._shift_feet(position[:, None, :] + arms - self._feet, values)
        lengths = np.sqrt(sum_squares(vectors))
        rows = self._scale_rows(vectors / lengths[..., None], arms)
        return rows, lengths - (values if self.rods is None else np.array(self.rods))

    def move_back(self, pose: Array, step: Array) -> tuple[Array, Array]:
        """See ``Held``."""
        position, turn = _split(pose)
        spin = np.sqrt(sum_squares(step[:, 3:])) / self.arm
        step = step * np.minimum(1.0, LONGEST_TURN / np.maximum(spin, SMALL_TURN))[:, None]
        moved = _join(position - step[:, :3], turn_by(-step[:, 3:] / self.arm) @ turn)
        return moved, np.abs(step).max(axis=-1, initial=0.0) / self.arm

    def is_closed(self, pose: Array, values: Array) -> Mask:
        """See ``Held``: every leg closed, every rod on its side of home."""
        position, turn = _split(pose)
        own, ok = self.inverse(position, turn)
        if self.rods is None:
            return np.asarray(ok & (np.abs(own - values) <= CLOSED).all(axis=-1))
        vectors = self.find_vectors(position, turn, values)
        on_side = ((vectors * self.unit_rails).sum(axis=-1) * self._sides > 0).all(axis=-1)
        misses = np.abs(np.sqrt(sum_squares(vectors)) - np.array(self.rods))
        return np.asarray(ok & on_side & (misses <= CLOSED).all(axis=-1))


def _join(position: Array, turn: Array) -> Array:
    """Poses (..., 12) of P (..., 3) and R (..., 3, 3)."""
    return np.concatenate([position, turn.reshape(*turn.shape[:-2], 9)], axis=-1)


def _split(pose: Array) -> tuple[Array, Array]:
    """The inverse of :func:`_join`."""
    return pose[..., :3], pose[..., 3:].reshape(*pose.shape[:-1], 3, 3)


def turn_by(vector: Array) -> Array:
    """Rotations (..., 3, 3) about and by vectors (..., 3), rad."""
    angle = np.sqrt(sum_squares(vector))
    small = angle < SMALL_TURN
    safe = np.where(small, 1.0, angle)
    first = np.where(small, 1.0, np.sin(safe) / safe)
    second = np.where(small, 0.5, 2.0 * (np.sin(0.5 * safe) / safe) ** 2)
    cosine = 1.0 - second * angle**2
    x, y, z = (vector[..., k] for k in range(3))
    turn = np.empty((*vector.shape[:-1], 3, 3))  # vv' second + the cross product with v first + cosine
    turn[..., 0, 0], turn[..., 1, 1], turn[..., 2, 2] = (second * one * one + cosine for one in (x, y, z))
    for row, column, one, other, third in ((1, 0, x, y, z), (0, 2, z, x, y), (2, 1, y, z, x)):
        turn[..., row, column] = second * one * other + first * third
        turn[..., column, row] = second * one * other - first * third
    return turn


def sum_squares(vector: Array) -> Array:
    """Squared lengths (...) of vectors (..., 3)."""
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    return np.asarray(x * x + y * y + z * z)
