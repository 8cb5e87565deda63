"""A five-axis machine of one chain: three linear joints and two rotary ones, each on the tool's or part's side.

All vectors are in the *polar frame* of the rotary pair (:mod:`~verne_post.kinematics.chain.pair`), in place of the
table frame: its origin is the part zero, with all joints at 0. There the nominal angles A and C are polar angles of
the tool axis. Between the base and the rotary joints of each side lie the linear ones, so the tip equation is linear:
``M x = Part(tip) - Tool(gauge - l axis)``, with M constant. mm and rad.
"""

from collections.abc import Callable
from typing import ClassVar, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.base.rotations import (
    find_axis_of_angles,
    rotate_x,
    rotate_x_rate,
    rotate_y,
    rotate_z,
    rotate_z_rate,
    solve_angles_of_axis,
    wrap_angle,
)
from verne_post.base.units import DEG_PER_RAD
from verne_post.kinematics.chain.pair import PolarPair
from verne_post.kinematics.five_axis import check_vectors, convert_axis_to_angles
from verne_post.model.poses import Platform, find_platform_angles
from verne_post.model.protocols import Margin, WholeSolution

#: The base frame of pictures and bodies has z down, as that of the parallel modules.
MIRROR: Final = np.array([1.0, -1.0, -1.0])


class Rotary(Struct, frozen=True, eq=False):
    """A rotary joint: a point (3,) of its axis at home, and whether it carries the tool."""

    through: Array
    on_tool: bool


class ChainMachine(Struct, frozen=True, eq=False):
    """Implements the ``FiveAxis`` protocol; joints are x, y, z, the tilt and the turn of the pair."""

    nose_offset: ClassVar[float] = 0.0  #: The gauge point is the platform point.
    pair: PolarPair
    #: gauge, axis (3,): Gauge point, and tool axis from tip to spindle, with all joints at 0.
    gauge: Array
    axis: Array
    linear: Array  #: (3, 3): M: columns are the motions of the tool against the part by the linear joints.
    tilt: Rotary
    turn: Rotary
    solver: Array  #: (3, 3): The inverse of M.

    # --- what the rotary joints do to points ----------------------------------------------------------------

    def _turn_about_tilt(
        self, vector: Array, angle: Array, rotate: Callable[[Array, Array], Array] = rotate_x
    ) -> Array:
        """Turn vectors (..., 3) about the tilting joint; ``rotate`` may be the derivative of the turn."""
        lean = self.pair.lean
        if not lean:
            return rotate(vector, angle)
        return rotate_y(rotate(rotate_y(vector, lean), angle), -lean)

    def turn_part(self, point: Array, q: Array) -> Array:
        """Points (..., 3) of the part, turned by the rotary joints q (..., 2), with the linear ones at 0."""
        if not self.turn.on_tool:
            point = rotate_z(point - self.turn.through, q[..., 1]) + self.turn.through
        if not self.tilt.on_tool:
            point = self._turn_about_tilt(point - self.tilt.through, q[..., 0]) + self.tilt.through
        return point

    def turn_part_back(self, point: Array, q: Array) -> Array:
        """Inverse of :meth:`turn_part`."""
        return self._turn_back(point, q, on_tool=False)

    def turn_tool(self, point: Array, q: Array) -> Array:
        """Points (..., 3) of the tool's end where the rotary joints put them, the linear ones at 0."""
        return self._turn_back(point, q, on_tool=True)

    def _turn_back(self, point: Array, q: Array, *, on_tool: bool) -> Array:
        if self.tilt.on_tool == on_tool:
            point = self._turn_about_tilt(point - self.tilt.through, -q[..., 0]) + self.tilt.through
        if self.turn.on_tool == on_tool:
            point = rotate_z(point - self.turn.through, -q[..., 1]) + self.turn.through
        return point

    def place_tip(self, tool_length: Array | float) -> Array:
        """The tip (..., 3) with all joints at 0."""
        return np.asarray(self.gauge - np.asarray(tool_length, dtype=float)[..., None] * self.axis)

    # --- poses and joints ---------------------------------------------------------------------------------------

    def find_platform_gauge(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """What the linear joints have to reach, (..., 3): ``M x``."""
        return self._find_reach(tip, self.pair.find_joints(np.asarray(angles, dtype=float)), tool_length)

    def _find_reach(self, tip: Array, rotary: Array, tool_length: Array | float) -> Array:
        reach: Array = self.turn_part(np.asarray(tip, dtype=float), rotary) - self.turn_tool(
            self.place_tip(tool_length), rotary
        )
        return reach

    def find_joints(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Joint values (..., 5) of tips (..., 3) and nominal angles (..., 2)."""
        return self._place_joints(tip, self.pair.find_joints(np.asarray(angles, dtype=float)), tool_length)

    def place_joints(self, tip: Array, turns: Array, tool_length: Array | float) -> Array:
        """The same for the angles d and t (..., 2) of a nutating pair."""
        return self._place_joints(
            tip, turns - [self.pair.nutation.home if self.pair.nutation else 0.0, 0.0], tool_length
        )

    def _place_joints(self, tip: Array, rotary: Array, tool_length: Array | float) -> Array:
        reach = self._find_reach(tip, rotary, tool_length)
        q = np.empty((*reach.shape[:-1], 5))
        q[..., :3] = reach @ self.solver.T
        q[..., 3:] = rotary
        return q

    def solve(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Platform, Mask]:
        """Joint values, platform, and ok: False only where a number is not finite."""
        q = self.find_joints(tip, angles, tool_length)
        ok = np.asarray(np.isfinite(q).all(axis=-1))
        if not np.all(ok):
            q[~ok] = np.nan
        return q, self._find_platform(q), ok

    def find_nominal_pose(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Where the tool is: tip (..., 3) and nominal angles (..., 2) of joint values (..., 5)."""
        q = np.asarray(q, dtype=float)
        reach = self.turn_tool(self.place_tip(tool_length), q[..., 3:]) + q[..., :3] @ self.linear.T
        angles = self.pair.find_angles(q[..., 3:])
        tip = self.turn_part_back(reach, q[..., 3:])
        return tip, angles, np.asarray(np.isfinite(tip).all(axis=-1))

    def measure(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Array, Mask]:
        """As :meth:`find_nominal_pose`, with the tool axis (..., 3) of these angles."""
        tip, angles, ok = self.find_nominal_pose(q, tool_length)
        return tip, angles, find_axis_of_angles(angles[..., 0], angles[..., 1]), ok

    def inverse(self, tip: Array, axis: Array, tool_length: Array | float) -> tuple[Array, Mask]:
        """Joint values of a pose in the part frame; see :meth:`Machine.inverse`."""
        tip, axis = (check_vectors(*one) @ self.pair.directions.T for one in ((tip, "tip"), (axis, "axis")))
        tip, angles = convert_axis_to_angles(tip, axis, tool_length)
        q = self.find_joints(tip, angles, tool_length)
        ok = np.asarray(np.isfinite(q).all(axis=-1))
        if self.pair.nutation is not None:
            ok &= self.pair.nutation.measure_miss(angles[..., 0]) == 0.0
        q[~ok] = np.nan
        return q, ok

    def forward(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Tip and tool axis in the part frame, and ok; see :meth:`Machine.forward`."""
        q = check_vectors(q, "q", 5)
        tip, _angles, axis, ok = self.measure(q, tool_length)
        return tip @ self.pair.directions, axis @ self.pair.directions, ok

    def inverse_all(self, tip: Array, axis: Array, tool_length: float) -> list[WholeSolution]:
        """Solutions of a pose (3,), (3,) in the polar frame, the tilt on either side of the pole; none out of reach."""
        tip, axis = check_vectors(tip, "tip"), check_vectors(axis, "axis")
        tilt, turn = (float(angle) for angle in solve_angles_of_axis(axis))
        solutions: list[WholeSolution] = []
        if self.pair.nutation is not None and self.pair.nutation.measure_miss(np.array(tilt)):
            return solutions
        for other, angles in ((False, (tilt, turn)), (True, (-tilt, float(wrap_angle(turn + np.pi))))):
            q = self.find_joints(tip, np.array(angles), tool_length)
            solutions.append(WholeSolution(tuple(q.tolist()), angles, 0.0, (), other, None))
        return solutions

    def explain_unreachable(self, tip: Array, angles: Array, tool_length: Array | float) -> list[str]:
        """Finding codes of poses (m, 3), (m, 2) without a solution: only those that are no numbers."""
        return ["VP110"] * len(tip)

    def find_jacobian(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Joint rates by pose rates, (..., 5, 5): rows the joints, columns tip x, y, z (mm), nominal A and C (rad)."""
        tip, angles = np.asarray(tip, dtype=float), np.asarray(angles, dtype=float)
        q = self.pair.find_joints(angles)
        shape = np.broadcast_shapes(tip.shape[:-1], q.shape[:-1], np.shape(tool_length))
        rates = np.zeros((*shape, 5, 5))
        along = np.zeros((*shape, 3, 5))
        still = np.zeros(3)
        for axis, unit in enumerate(np.eye(3)):
            along[..., axis] = self.turn_part(unit, q) - self.turn_part(still, q)
        along[..., 3] = self._rate(tip, tool_length, q, by_tilt=True)
        along[..., 4] = self._rate(tip, tool_length, q, by_tilt=False)
        rates[..., :3, :] = self.solver @ along
        rates[..., 3, 3] = rates[..., 4, 4] = 1.0
        if self.pair.nutation is not None:  # so far by the joints
            tilting, turning = self.pair.nutation.find_rates(angles)
            rates[..., 3] = rates[..., 3] * tilting[..., None] + rates[..., 4] * turning[..., None]
        return rates

    def _rate(self, tip: Array, tool_length: Array | float, q: Array, *, by_tilt: bool) -> Array:
        """Derivative (..., 3) of what the linear joints have to reach, by the tilt or by the turn."""
        joint, (a, c) = (self.tilt if by_tilt else self.turn), (q[..., 0], q[..., 1])

        def differentiate(vector: Array, angle: Array) -> Array:
            return self._turn_about_tilt(vector, angle, rotate_x_rate) if by_tilt else rotate_z_rate(vector, angle)

        angle = a if by_tilt else c
        if joint.on_tool:
            point = self.place_tip(tool_length)
            if not by_tilt and self.tilt.on_tool:
                point = self._turn_about_tilt(point - self.tilt.through, -a) + self.tilt.through
            rate = differentiate(point - joint.through, -angle)  # of the angle against the joint; so is the side
            return rotate_z(rate, -c) if by_tilt and self.turn.on_tool else rate
        point = tip
        if by_tilt and not self.turn.on_tool:
            point = rotate_z(point - self.turn.through, c) + self.turn.through
        rate = differentiate(point - joint.through, angle)
        return self._turn_about_tilt(rate, a) if not by_tilt and not self.tilt.on_tool else rate

    # --- bodies and pictures: z down; the base carries the rotary joints of the part's side --------------

    def find_platform(self, q: Array) -> tuple[Platform, Mask]:
        """The spindle's end as a platform, for joint values (..., 5)."""
        q = np.asarray(q, dtype=float)
        return self._find_platform(q), np.asarray(np.isfinite(q).all(axis=-1))

    def _find_platform(self, q: Array) -> Platform:
        point = (self.turn_tool(self.gauge, q[..., 3:]) + q[..., :3] @ self.linear.T) * MIRROR
        if self.pair.lean and self.tilt.on_tool:
            middle = self.turn_tool(np.zeros(3), q[..., 3:])
            units = ((self.turn_tool(unit, q[..., 3:]) - middle) * MIRROR for unit in np.diag(MIRROR))
            return Platform(point, find_platform_angles(*units))
        a, c = (
            q[..., 3 + number] if joint.on_tool else np.zeros(q.shape[:-1])
            for number, joint in enumerate((self.tilt, self.turn))
        )
        # F Rz(-C) Rx(-A) F = Rz(C) Rx(-A), as the product Rx Ry Rz that a platform has
        beta = np.arcsin(np.sin(c) * np.sin(-a))
        alpha = np.arctan2(np.cos(c) * np.sin(-a), np.cos(a))
        gamma = np.arctan2(np.sin(c) * np.cos(a), np.cos(c))
        return Platform(point, np.stack([alpha, beta, gamma], axis=-1))

    @property
    def spindle(self) -> Array:
        """Unit vector from the gauge point towards the tip with all joints at 0, z down."""
        return np.asarray(-self.axis * MIRROR)

    def find_tool_axis(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Tool axis (..., 3) in the polar frame: as programmed."""
        return find_axis_of_angles(angles[..., 0], angles[..., 1])

    def carry_to_table(self, point: Array, q: Array) -> Array:
        """Points (..., 3) of the base frame in the polar frame of the part, for joint values (..., 5)."""
        return self.turn_part_back(point * MIRROR, q[..., 3:])

    # --- what parallel machines have and a chain has not ----------------------------------------------------------

    def find_geometry_margins(self, q: Array, angles: Array, platform: Platform) -> Array:
        """How far the tilting joint of a nutating pair is from its fold, degrees, shape (..., 1); else none."""
        if self.pair.nutation is None:
            return np.empty((*np.shape(q)[:-1], 0))
        return DEG_PER_RAD * self.pair.nutation.measure_fold(np.asarray(q)[..., 3, None])

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """The fold of a nutating pair. It has no threshold: the joints have to keep their limits. No rods."""
        return () if self.pair.nutation is None else (Margin("distance from the fold", "VP202", None, "deg", 0.0, 0.0),)

    def measure_conditioning(self, q: Array, platform: Platform) -> tuple[Array, Array]:
        """1, and the reciprocal condition number of the linear joints, each (...)."""
        ones = np.ones(np.shape(q)[:-1])
        return ones, ones / np.linalg.cond(self.linear)

    def sketch(self, q: Array, platform: Platform) -> Array:
        """No rods: (n, 0, 2, 3)."""
        return np.empty((len(q), 0, 2, 3))
