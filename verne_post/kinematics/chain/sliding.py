"""A machine of one chain whose linear joints are three sliders on rods that hold the platform without turning it.

The rotary pair stands on any side, as on linear axes. The vector x that the linear joints of the chain would reach, in
directions of the base, moves the platform: ``P = home + x``. The sliders of the rods follow in closed form. Rotary
joints, both solutions and words are those of the chain. All vectors are in the polar frame of the pair
(:mod:`~verne_post.kinematics.chain.machine`); places of the platform are in the base frame of the file. mm and rad.
"""

from typing import ClassVar

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Mask
from verne_post.base.rotations import measure_angles
from verne_post.base.units import DEG_PER_RAD
from verne_post.kinematics.chain.machine import MIRROR, ChainMachine
from verne_post.kinematics.five_axis import check_vectors
from verne_post.kinematics.modules.rods import RodsModule
from verne_post.model.poses import Platform
from verne_post.model.protocols import Margin, WholeSolution


class SlidingMachine(Struct, frozen=True, eq=False):
    """Implements the ``FiveAxis`` protocol; joints are the sliders, the tilt and the turn of the pair."""

    nose_offset: ClassVar[float] = 0.0  #: The gauge point is the platform point of pictures.
    chain: ChainMachine  #: The pair on linear axes: what words and machine coordinates mean.
    module: RodsModule  #: The rods; their platform never tilts.
    to_polar: Array  #: (3, 3): Turns directions of the base frame into the polar frame.
    part_zero: Array  #: (3,): Origin of the polar frame, base frame.
    cone: float | None = None  #: How far rods may turn in their joints from home, degrees.

    @property
    def spindle(self) -> Array:
        """Unit vector from the gauge point towards the tip with the rotary joints at 0, z down."""
        return self.chain.spindle

    @property
    def home(self) -> Array:
        """Joint values (5,) with the carrier at home and the rotary joints at 0."""
        return np.append(self.module.inverse(np.array(self.module.home, dtype=float))[0], [0.0, 0.0])

    # --- sliders and linear axes ---------------------------------------------------------------------------------

    def _solve_sliders(self, q: Array) -> tuple[Array, Array, Mask]:
        """Joints (..., 5), P (..., 3) and ok (...) of joints (..., 5) of the chain on linear axes."""
        position = np.array(self.module.home) + (q[..., :3] @ self.chain.linear.T) @ self.to_polar
        rho, _alpha, ok = self.module.inverse(position)
        ok = ok & np.isfinite(q).all(axis=-1)
        return np.where(ok[..., None], np.concatenate([rho, q[..., 3:]], axis=-1), np.nan), position, np.asarray(ok)

    def _find_linear(self, q: Array) -> tuple[Array, Mask]:
        """The inverse of :meth:`_solve_sliders`."""
        q = np.asarray(q, dtype=float)
        position, _alpha, ok = self.module.forward(q[..., :3])
        reach = (position - np.array(self.module.home)) @ self.to_polar.T
        return np.concatenate([reach @ self.chain.solver.T, q[..., 3:]], axis=-1), ok & np.isfinite(q).all(axis=-1)

    def _find_position(self, q: Array) -> Array:
        """P (..., 3) of joints (..., 5)."""
        return self.module.forward(np.asarray(q, dtype=float)[..., :3])[0]

    # --- poses and joints ----------------------------------------------------------------------------------------

    def find_platform_gauge(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """What the linear axes of the chain would have to reach (..., 3)."""
        return self.chain.find_platform_gauge(tip, angles, tool_length)

    def find_joints(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Joint values (..., 5) of tips (..., 3) and nominal angles (..., 2); NaN out of reach."""
        return self._solve_sliders(self.chain.find_joints(tip, angles, tool_length))[0]

    def place_joints(self, tip: Array, turns: Array, tool_length: Array | float) -> Array:
        """The same for the angles d and t (..., 2) of a nutating pair."""
        return self._solve_sliders(self.chain.place_joints(tip, turns, tool_length))[0]

    def solve(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Platform, Mask]:
        """Joint values, platform and ok; see ``FiveAxis``."""
        q, platform, _ok = self.chain.solve(tip, angles, tool_length)
        moved, _position, ok = self._solve_sliders(q)
        return moved, platform, ok

    def find_nominal_pose(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Where the tool is: tip (..., 3) and nominal angles (..., 2) of joint values (..., 5)."""
        linear, ok = self._find_linear(q)
        tip, angles, finite = self.chain.find_nominal_pose(linear, tool_length)
        return tip, angles, ok & finite

    def measure(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Array, Mask]:
        """As :meth:`find_nominal_pose`, with the tool axis (..., 3) of these angles."""
        linear, ok = self._find_linear(q)
        tip, angles, axis, finite = self.chain.measure(linear, tool_length)
        return tip, angles, axis, ok & finite

    def inverse(self, tip: Array, axis: Array, tool_length: Array | float) -> tuple[Array, Mask]:
        """Joint values of a pose in the part frame; see :meth:`Machine.inverse`."""
        q, _position, ok = self._solve_sliders(self.chain.inverse(tip, axis, tool_length)[0])
        return q, ok

    def forward(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Tip and tool axis in the part frame, and ok; see :meth:`Machine.forward`."""
        q = check_vectors(q, "q", 5)
        linear, ok = self._find_linear(q)
        tip, axis, finite = self.chain.forward(linear, tool_length)
        return tip, axis, ok & finite

    def inverse_all(self, tip: Array, axis: Array, tool_length: float) -> list[WholeSolution]:
        """Both solutions of one pose (3,), (3,) in the polar frame that the rods reach, in their working mode."""
        solutions = []
        for one in self.chain.inverse_all(tip, axis, tool_length):
            q, _position, ok = self._solve_sliders(np.array(one.q))
            if ok:
                solutions.append(replace(one, q=tuple(q.tolist())))
        return solutions

    def explain_unreachable(self, tip: Array, angles: Array, tool_length: Array | float) -> list[str]:
        """Finding codes of poses (m, 3), (m, 2) without a solution: rods do not close, or a parallel singularity."""
        _q, position, _ok = self._solve_sliders(self.chain.find_joints(tip, angles, tool_length))
        return self.module.explain_places(position)

    def find_jacobian(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Joint rates by pose rates, (..., 5, 5): rows the joints, columns tip x, y, z (mm), nominal A and C (rad)."""
        rates = self.chain.find_jacobian(tip, angles, tool_length)
        q, position, _ok = self._solve_sliders(self.chain.find_joints(tip, angles, tool_length))
        moved = self.to_polar.T @ self.chain.linear @ rates[..., :3, :]  # of P, base frame
        first = self.module.first_rods
        rods = self.module.find_vectors(position, np.zeros(position.shape[:-1]), q[..., :3])[..., first, :]
        shares = rods / (rods * self.module.rails[first]).sum(axis=-1, keepdims=True)
        rates[..., :3, :] = shares @ moved
        return rates

    # --- margins, bodies and pictures ----------------------------------------------------------------------------

    def find_platform(self, q: Array) -> tuple[Platform, Mask]:
        """The spindle's end as a platform, for joint values (..., 5)."""
        linear, ok = self._find_linear(q)
        return self.chain.find_platform(linear)[0], ok

    def find_tool_axis(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Tool axis (..., 3) in the polar frame: as programmed."""
        return self.chain.find_tool_axis(q, angles, platform)

    def carry_to_table(self, point: Array, q: Array) -> Array:
        """Points (..., 3) of the base frame, z down, in the polar frame of the part, for joint values (..., 5)."""
        return self.chain.carry_to_table(point, q)

    def find_geometry_margins(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Those of the chain and of the rods, and what is left of the cones of rods, degrees."""
        gauge = self.chain.turn_tool(self.chain.gauge, q[..., 3:])
        position = np.array(self.module.home) + (platform.position * MIRROR - gauge) @ self.to_polar
        upright = np.zeros(position.shape[:-1])
        own = self.chain.find_geometry_margins(q, angles, platform)
        margins = np.concatenate([own, self.module.find_geometry_margins(position, upright)], axis=-1)
        if self.cone is None:
            return margins
        rods = self.module.find_vectors(position, upright, q[..., :3])[..., self.module.distinct, :]
        home = np.array(self.module.home, dtype=float)
        first = self.module.find_rod_directions(home)[0][self.module.distinct]
        turned = measure_angles(rods, first)
        return np.concatenate([margins, self.cone - DEG_PER_RAD * turned], axis=-1)

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`find_geometry_margins` measures, with thresholds."""
        thresholds = serial_singularity, parallel_singularity
        names = (*self.chain.name_margins(*thresholds), *self.module.name_margins(*thresholds))
        if self.cone is None:
            return names
        return (
            *names,
            *(
                Margin(f"angle left to the joints of rod {k + 1}", "VP214", self.module.rod[k].by, "deg", 0.0, 0.0)
                for k in self.module.distinct.tolist()
            ),
        )

    def measure_conditioning(self, q: Array, platform: Platform) -> tuple[Array, Array]:
        """Reciprocal condition numbers of the rods, parallel and serial."""
        position = self._find_position(q)
        return self.module.measure_conditioning(position, np.zeros(position.shape[:-1]), q[..., :3])

    def sketch(self, q: Array, platform: Platform) -> Array:
        """Rods (n, 6, 2, 3) for a picture, base frame with z down; sliders stand at q, whatever the rods reach."""
        module = self.module
        start = module.feet + q[:, module.slider_of, None] * module.rails
        rods = np.stack([start, self._find_position(q)[:, None] + module.ends], axis=-2)
        return np.asarray(((rods - self.part_zero) @ self.to_polar.T) * MIRROR)
