"""A five-axis machine without rotary joints: six legs hold the platform with the spindle; the part stands still.

A program gives five of the platform's six motions. The sixth, a turn about the tool axis that no tool shows, is fixed
once for all: with w0 the tool axis at home and w the programmed one, both in the base frame, and s a constant of the
machine file,

    R = R(w0 -> w) R(w0, s),      R(w0 -> w) v = v + k x v + k x (k x v) / (1 + w0.w),      k = w0 x w,

the shortest turn from home. It is smooth except for w opposite to w0, which the bound on turn excludes. The gauge point
G of the tool gives P = G - R g, and each leg then has its actuator in closed form.

Words are those of a head with both rotary joints through the gauge point, on linear axes along those of the part:
machine coordinates are the place of the gauge point, and A and C the direction of the tool. The last two joint values
are these two angles; nothing drives them, and the legs alone determine the place of the tool. Vectors are in the polar
frame of the two words, as in :mod:`~verne_post.kinematics.chain.machine`; those of the legs are in the base frame of
the file. mm and rad.
"""

from functools import cached_property
from typing import ClassVar

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.base.rotations import differentiate_axis, find_axis_of_angles, solve_angles_of_axis
from verne_post.base.units import DEG_PER_RAD
from verne_post.kinematics.chain.carried import choose_turn, find_nominal_turn
from verne_post.kinematics.chain.machine import MIRROR, ChainMachine
from verne_post.kinematics.five_axis import check_vectors, convert_axis_to_angles
from verne_post.kinematics.modules.six_legs import SixLegs, turn_by
from verne_post.model.poses import Platform, find_platform_angles
from verne_post.model.protocols import Margin, WholeSolution


class HexapodMachine(Struct, frozen=True, dict=True, eq=False):
    """Implements ``FiveAxis`` and ``RodModule``; joints are six actuators, and the angles of the two words."""

    nose_offset: ClassVar[float] = 0.0  #: The gauge point is the platform point of pictures.
    nominal_chain: ChainMachine  #: The head that words and machine coordinates mean.
    legs: SixLegs
    to_polar: Array  #: (3, 3): Turns directions of the base frame into the polar frame.
    part_zero: Array  #: (3,): Origin of the polar frame, base frame.
    spare_turn: float  #: s, rad.
    actuators: tuple[str, ...]  #: Names of the six.
    #: base_cone, platform_cone: How far legs may turn in their joints from home, degrees.
    base_cone: float | None = None
    platform_cone: float | None = None

    @property
    def spindle(self) -> Array:
        """Unit vector from the gauge point towards the tip at home, z down."""
        return self.nominal_chain.spindle

    @property
    def home(self) -> Array:
        """Joint values (8,) with the platform turned as the base."""
        values, _drops2 = self.legs.find_values(np.array(self.legs.home, dtype=float), np.eye(3))
        return np.append(values, [0.0, 0.0])

    @cached_property
    def _arm(self) -> Array:
        """From P to the gauge point (3,), platform frame."""
        return np.asarray(self._place(self.nominal_chain.gauge) - np.array(self.legs.home))

    @cached_property
    def _upright(self) -> Array:
        """w0 (3,)."""
        return self.nominal_chain.axis @ self.to_polar

    @cached_property
    def _spare(self) -> Array:
        """R(w0, s)."""
        return turn_by(self.spare_turn * self._upright)

    def _place(self, point: Array) -> Array:
        """Points (..., 3) of the polar frame in the base frame."""
        return np.asarray(point @ self.to_polar + self.part_zero)

    def find_platform_gauge(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Gauge point (..., 3) from its place at home."""
        return self.nominal_chain.find_platform_gauge(tip, angles, tool_length)

    # --- poses to joints ---------------------------------------------------------------------------------------------

    def _find_turn(self, axis: Array) -> Array:
        """R (..., 3, 3) for tool axes (..., 3) of the base frame."""
        (a, b, c), (u, v, w) = self._upright, (axis[..., 0], axis[..., 1], axis[..., 2])
        x, y, z, cosine = b * w - c * v, c * u - a * w, a * v - b * u, a * u + b * v + c * w
        share = 1.0 / (1.0 + cosine)
        turn = np.empty((*axis.shape[:-1], 3, 3))  # k k' / (1 + w0.w) + w0.w and the cross product with k
        turn[..., 0, 0], turn[..., 1, 1], turn[..., 2, 2] = (share * one * one + cosine for one in (x, y, z))
        for row, column, one, other, third in ((1, 0, x, y, z), (0, 2, z, x, y), (2, 1, y, z, x)):
            turn[..., row, column] = share * one * other + third
            turn[..., column, row] = share * one * other - third
        return np.asarray((turn.reshape(-1, 3) @ self._spare).reshape(turn.shape)) if self.spare_turn else turn

    def _find_platform_pose(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Array]:
        """P (..., 3) and R (..., 3, 3) of tips (..., 3) and nominal angles (..., 2)."""
        axis = find_axis_of_angles(angles[..., 0], angles[..., 1])
        gauge = self._place(tip + np.asarray(tool_length, dtype=float)[..., None] * axis)
        turn = self._find_turn(axis @ self.to_polar)
        return gauge - (turn.reshape(-1, 3) @ self._arm).reshape(turn.shape[:-1]), turn

    @np.errstate(all="ignore")
    def _solve(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Array, Array, Mask]:
        """Joints (..., 8), P (..., 3), R (..., 3, 3) and ok (...)."""
        angles = np.asarray(angles, dtype=float)
        position, turn = self._find_platform_pose(np.asarray(tip, dtype=float), angles, tool_length)
        values, ok = self.legs.inverse(position, turn)
        q = np.empty((*position.shape[:-1], 8))
        q[..., :6] = values
        q[..., 6:] = self.nominal_chain.pair.find_joints(angles)
        q[~ok] = np.nan
        return q, position, turn, ok

    def find_joints(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Joint values (..., 8) of tips (..., 3) and nominal angles (..., 2); NaN out of reach."""
        return self._solve(tip, angles, tool_length)[0]

    def solve(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Platform, Mask]:
        """Joint values, platform and ok; see ``FiveAxis``."""
        q, position, turn, ok = self._solve(tip, angles, tool_length)
        return q, self._draw_platform(position, turn), ok

    def explain_unreachable(self, tip: Array, angles: Array, tool_length: Array | float) -> list[str]:
        """Finding codes of poses (m, 3), (m, 2) without a solution: VP203 beyond a singularity, VP110 out of reach."""
        with np.errstate(all="ignore"):
            within = self.legs.is_within(*self._find_platform_pose(tip, np.asarray(angles, dtype=float), tool_length))
        return ["VP203" if one else "VP110" for one in within]

    @property
    def no_reach(self) -> str:
        """What keeps a pose out of reach: struts have a length for every pose, rods not."""
        most = f"{self.legs.largest_turn_deg:g} degrees from home"
        if self.legs.rods is None:
            return f"the platform would turn {most} or more (carrier.largest_turn_deg)"
        return f"no slider position satisfies the rod lengths with the platform turned less than {most}"

    def inverse_all(self, tip: Array, axis: Array, tool_length: float) -> list[WholeSolution]:
        """The used solution of a pose (3,), (3,) in the polar frame; turns about the tool axis are no solutions."""
        tip, axis = check_vectors(tip, "tip"), check_vectors(axis, "axis")
        tilt, turn = (float(angle) for angle in solve_angles_of_axis(axis))
        q, _position, _turn, ok = self._solve(tip, np.array([tilt, turn]), tool_length)
        return [WholeSolution(tuple(q.tolist()), (tilt, turn), 0.0, (), False, None)] if ok else []

    @np.errstate(all="ignore")
    def inverse(self, tip: Array, axis: Array, tool_length: Array | float) -> tuple[Array, Mask]:
        """Joint values of a pose in the part frame; see :meth:`Machine.inverse`."""
        directions = self.nominal_chain.pair.directions
        tip, axis = (check_vectors(*one) @ directions.T for one in ((tip, "tip"), (axis, "axis")))
        q, _position, _turn, ok = self._solve(*convert_axis_to_angles(tip, axis, tool_length), tool_length)
        return q, ok

    # --- joints to poses -----------------------------------------------------------------------------------

    @np.errstate(all="ignore")
    def measure(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Array, Mask]:
        """Tip (..., 3), nominal angles (..., 2) with A in [0, pi], tool axis (..., 3) and ok (...) of q (..., 8).

        The legs say it all; the last two values choose the turn of C, and C itself where the tool stands upright.
        """
        q = np.asarray(q, dtype=float)
        position, turn, ok = self.legs.forward(q[..., :6])
        axis = (turn @ self._upright) @ self.to_polar.T
        gauge = (position + turn @ self._arm - self.part_zero) @ self.to_polar.T
        tip = gauge - np.asarray(tool_length, dtype=float)[..., None] * axis
        tilt, c = solve_angles_of_axis(axis)
        near = find_nominal_turn(self.nominal_chain.pair.find_angles(q[..., 6:]))
        return tip, np.stack([tilt, choose_turn(tilt, c, near)], axis=-1), axis, ok & np.isfinite(tip).all(axis=-1)

    def find_nominal_pose(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """As :meth:`measure`, without the tool axis."""
        tip, angles, _axis, ok = self.measure(q, tool_length)
        return tip, angles, ok

    @np.errstate(all="ignore")
    def forward(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Tip and tool axis in the part frame, and ok; see :meth:`Machine.forward`."""
        q = np.asarray(q, dtype=float)
        if q.ndim == 0 or q.shape[-1] != 8:
            raise ValueError(f"q must have shape (..., 8), six actuators and two angles, got {q.shape}")
        tip, _angles, axis, ok = self.measure(q, tool_length)
        directions = self.nominal_chain.pair.directions
        return tip @ directions, axis @ directions, ok

    def find_jacobian(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Joint rates by pose rates, (..., 8, 5): rows the joints, columns tip x, y, z (mm), nominal A and C (rad)."""
        q, position, turn, _ok = self._solve(tip, angles, tool_length)
        angles = np.broadcast_to(np.asarray(angles, dtype=float), (*q.shape[:-1], 2))
        turns = np.zeros((*q.shape[:-1], 3, 5))  # the tool axis by the pose
        turns[..., 3:] = differentiate_axis(angles)
        moves = np.asarray(tool_length, dtype=float)[..., None, None] * turns  # G by the pose
        moves[..., :3] += np.eye(3)
        turns, moves = self.to_polar.T @ turns, self.to_polar.T @ moves
        axis = find_axis_of_angles(angles[..., 0], angles[..., 1]) @ self.to_polar
        # the shortest turn as a quaternion (1 + w0.w, w0 x w) of length sqrt(2 + 2 w0.w)
        real, cross = (1.0 + axis @ self._upright)[..., None, None], np.cross(self._upright, axis)[..., None]
        real_rate = self._upright @ turns
        cross_rate = np.cross(self._upright[:, None], turns, axis=-2)
        spin = cross_rate - (real_rate[..., None, :] * cross + np.cross(cross_rate, cross, axis=-2)) / real
        arm = (turn @ self._arm)[..., None]
        motion = np.concatenate([moves - np.cross(spin, arm, axis=-2), spin], axis=-2)
        rates = np.zeros((*q.shape[:-1], 8, 5))
        rates[..., :6, :] = self.legs.find_rates(position, turn) @ motion
        rates[..., 6, 3] = rates[..., 7, 4] = 1.0
        return rates

    # --- bodies and pictures: z down, the part stands still -------------------------------------------------

    def _draw_platform(self, position: Array, turn: Array) -> Platform:
        gauge = (position + turn @ self._arm - self.part_zero) @ self.to_polar.T
        polar = self.to_polar @ turn @ self.to_polar.T
        units = [(polar @ unit) * MIRROR for unit in np.diag(MIRROR)]
        return Platform(gauge * MIRROR, find_platform_angles(*units))

    def _find_pose_of(self, platform: Platform) -> tuple[Array, Array]:
        """P (..., 3) and R (..., 3, 3) of platforms, the inverse of :meth:`_draw_platform`."""
        polar = platform.build_matrix() * (MIRROR[:, None] * MIRROR)
        turn = self.to_polar.T @ polar @ self.to_polar
        return self._place(platform.position * MIRROR) - turn @ self._arm, turn

    def find_platform(self, q: Array) -> tuple[Platform, Mask]:
        """The spindle's end as a platform, for joint values (..., 8)."""
        position, turn, ok = self.legs.forward(np.asarray(q, dtype=float)[..., :6])
        return self._draw_platform(position, turn), ok

    def find_tool_axis(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Tool axis (..., 3) in the polar frame: as programmed."""
        return find_axis_of_angles(angles[..., 0], angles[..., 1])

    def carry_to_table(self, point: Array, q: Array) -> Array:
        """Points (..., 3) of the base frame with z down in the polar frame of the part, which stands still."""
        return np.asarray(point * MIRROR)

    @np.errstate(all="ignore")
    def find_geometry_margins(self, q: Array, angles: Array, platform: Platform) -> Array:
        """The Jacobian's measure, drops of rods along their rails, mm, and what is left of cones, degrees."""
        pose = self._find_pose_of(platform)
        columns = [self.legs.measure(*pose)[..., None]]
        if self.legs.rods is not None:
            columns.append(np.sqrt(np.maximum(self.legs.find_values(*pose)[1], 0.0)))
        for cone, turned in zip((self.base_cone, self.platform_cone), self.legs.measure_cones(*pose), strict=True):
            if cone is not None:
                columns.append(cone - DEG_PER_RAD * turned)
        return np.concatenate(columns, axis=-1)

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`find_geometry_margins` measures, with thresholds."""
        singular, drop = parallel_singularity, serial_singularity
        where = ("base", "platform") if self.legs.rods is None else ("slider", "platform")
        what = "measure of the parallel Jacobian"
        return (
            Margin(what, "VP203", None, "", singular, 2 * singular),
            *(
                Margin(f"drop of rod {k + 1} along its rail", "VP202", name, "mm", drop, 2 * drop)
                for k, name in enumerate(self.actuators)
                if self.legs.rods is not None
            ),
            *(
                Margin(f"angle left to the leg's joint on the {side}", "VP214", name, "deg", 0.0, 0.0)
                for cone, side in zip((self.base_cone, self.platform_cone), where, strict=True)
                if cone is not None
                for name in self.actuators
            ),
        )

    def measure_conditioning(self, q: Array, platform: Platform) -> tuple[Array, Array]:
        """Reciprocal condition numbers of the legs, parallel and serial."""
        return self.legs.measure_conditioning(*self._find_pose_of(platform))

    @property
    def rod_legs(self) -> tuple[str, ...]:
        """Every rod is a leg."""
        return self.actuators

    @property
    def parallelograms(self) -> tuple[str, ...]:
        """All: no leg has two rods that could meet."""
        return self.actuators

    @property
    def shortest_rod(self) -> float:
        """At home, mm."""
        return float(np.linalg.norm(np.diff(self._sketch_home(), axis=-2), axis=-1).min())

    def _sketch_home(self) -> Array:
        """Legs (6, 2, 3) at home, base frame."""
        home = np.array(self.legs.home, dtype=float), np.eye(3)
        return np.stack(self.legs.find_legs(*home, self.legs.find_values(*home)[0]), axis=-2)

    def find_rod_directions(self, position: Array) -> tuple[Array, Array]:
        """Directions of the legs (6, 3) at home, where both frames are the same."""
        legs = np.diff(self._sketch_home(), axis=-2)[..., 0, :] @ self.to_polar.T * MIRROR
        unit = legs / np.linalg.norm(legs, axis=-1, keepdims=True)
        return unit, unit

    def find_rod_ends(self, rho: Array, platform: Platform) -> tuple[Array, Array]:
        """Ends of the legs at base and platform, each (n, 6, 3), base frame with z down, of actuators (n, 6)."""
        start, end = self.legs.find_legs(*self._find_pose_of(platform), rho)
        first, last = (((point - self.part_zero) @ self.to_polar.T) * MIRROR for point in (start, end))
        return first, last

    def sketch(self, q: Array, platform: Platform) -> Array:
        """Legs (n, 6, 2, 3) for a picture, base frame with z down; sliders stand at q, whatever the rods reach."""
        return np.stack(self.find_rod_ends(q[..., :6], platform), axis=-2)
