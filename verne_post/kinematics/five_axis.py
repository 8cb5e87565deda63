"""The whole machine: a parallel module over a tilting rotary table.

The platform only ever tilts about x, and so does the table's tilt. With the gauge-line point g of
the nominal trunnion machine (:meth:`TiltingTable.find_gauge_point`) the platform point is
``P = pivot + F Rx(alpha) g``, ``F = diag(1, -1, -1)``, and the table stands at A + alpha. The module
owns the solution for alpha (:meth:`ParallelModule.solve_coupled`). C does not depend on alpha.
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.base.rotations import (
    find_axis_of_angles,
    rotate_x,
    rotate_x_rate,
    rotate_z,
    rotate_z_rate,
    solve_angles_of_axis,
    wrap_angle,
)
from verne_post.kinematics.tables.tilting import TiltingTable
from verne_post.model.poses import Platform
from verne_post.model.protocols import Drawable, Margin, ParallelModule, WholeSolution

#: F: the base frame against the upright frame.
_MIRROR: Final = np.array([1.0, -1.0, -1.0])
#: The spindle in the platform frame.
_DOWN: Final = np.array([0.0, 0.0, 1.0])
#: Numbers of a block that is mapped, never touched, and freed: 16 MB.
_KEPT_NUMBERS: Final = 2_000_000

# glibc gives freed blocks back to the system, which then maps pages anew for every temporary array. Once a large block
# has been freed, it keeps blocks up to that size. The inverse is 1.6 times as fast then, whatever has been imported.
np.empty(_KEPT_NUMBERS)


class HybridMachine(Struct, frozen=True, eq=False):
    """Implements the ``FiveAxis`` protocol. Table frame, mm, rad, workpiece sense.

    ``nose_offset`` is the distance from P to the gauge line along the tool axis, mm.
    """

    module: ParallelModule
    table: TiltingTable
    nose_offset: float

    def find_platform_gauge(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Gauge point g (..., 3) of the nominal machine: P is ``pivot + F Rx(alpha) g``; see :meth:`solve`."""
        return self.table.find_gauge_point(tip, angles, np.asarray(tool_length) + self.nose_offset)

    def solve(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Platform, Mask]:
        """Joint values that follow the programmed branch: q = (module, A + alpha, C).

        Parameters
        ----------
        tip : ndarray, shape (..., 3)
        angles : ndarray, shape (..., 2)
            Nominal A and C, unwrapped as programmed.
        tool_length : ndarray, shape (...) or float

        Returns
        -------
        q : ndarray, shape (..., 5)
            NaN where not ok.
        platform : Platform
        ok : ndarray of bool, shape (...)
        """
        q, gauge, alpha, ok = self._solve_joints(tip, angles, tool_length)
        return q, _make_tilted_platform(rotate_x(gauge, alpha) * _MIRROR + self.table.pivot, alpha), ok

    def find_joints(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """The joint values of :meth:`solve` alone, (..., 5)."""
        return self._solve_joints(tip, angles, tool_length)[0]

    def _solve_joints(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Array, Array, Mask]:
        """q, gauge point, alpha, ok."""
        gauge = self.find_platform_gauge(tip, angles, tool_length)
        rho, alpha, ok = self.module.solve_coupled(self.table.pivot, gauge)
        q = np.concatenate([rho, angles], axis=-1)
        q[..., -2] += alpha
        if not np.all(ok):
            q[~ok] = np.nan
        return q, gauge, alpha, ok

    def explain_unreachable(self, tip: Array, angles: Array, tool_length: Array | float) -> list[str]:
        """Finding codes of poses (m, 3), (m, 2) that :meth:`solve` cannot solve."""
        return self.module.explain_unreachable(self.table.pivot, self.find_platform_gauge(tip, angles, tool_length))

    def inverse_all(self, tip: Array, axis: Array, tool_length: float) -> list[WholeSolution]:
        """All real solutions of one pose (3,), (3,) in closed form: at most six tilts for each table solution.

        The solutions of the table in use, tilt b in [0, pi], come first; within each, those that the machine can use.
        """
        tip, axis = check_vectors(tip, "tip"), check_vectors(axis, "axis")
        tilt, turn = (float(angle) for angle in solve_angles_of_axis(axis))
        solutions = []
        for other, angles in ((False, (tilt, turn)), (True, (-tilt, float(wrap_angle(turn + np.pi))))):
            gauge = self.find_platform_gauge(tip, np.array(angles), tool_length)
            for one in self.module.solve_coupled_all(self.table.pivot, gauge):
                q = (*one.rho, angles[0] + one.alpha, angles[1])
                solutions.append(WholeSolution(q, angles, one.alpha, one.signs, other, one.refused))
        return solutions

    def find_jacobian(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Joint rates by pose rates, from the derivatives of the module's closure equations.

        Parameters
        ----------
        tip : ndarray, shape (..., 3)
        angles : ndarray, shape (..., 2)
            Nominal A and C.
        tool_length : ndarray, shape (...) or float

        Returns
        -------
        ndarray, shape (..., 5, 5)
            Rows: the joints; columns: tip x, y, z in the table frame (mm), nominal A and C (rad). NaN where the pose
            cannot be solved or stands at a serial singularity.
        """
        tip, angles = np.asarray(tip, dtype=float), np.asarray(angles, dtype=float)
        q, gauge, alpha, ok = self._solve_joints(tip, angles, tool_length)
        position = rotate_x(gauge, alpha) * _MIRROR + self.table.pivot
        parallel, serial = self.module.find_jacobians(position, alpha, q[..., :-2])
        # P = pivot + F Rx(alpha) g: by g and by alpha
        by_gauge = np.stack([rotate_x(rate, alpha) * _MIRROR for rate in self._compute_gauge_rates(tip, angles)], -1)
        by_alpha = rotate_x_rate(gauge, alpha) * _MIRROR
        by_point, by_tilt = parallel[..., :3], parallel[..., 3] + (parallel[..., :3] @ by_alpha[..., None])[..., 0]
        matrix = np.concatenate([serial, by_tilt[..., None]], axis=-1)
        solvable = ok & (np.linalg.det(np.where(ok[..., None, None], matrix, np.eye(4))) != 0.0)
        matrix = np.where(solvable[..., None, None], matrix, np.eye(4))
        rates = -np.linalg.solve(matrix, by_point @ by_gauge)
        rates[~solvable] = np.nan
        total = np.zeros((*rates.shape[:-2], 5, 5))
        total[..., :3, :] = rates[..., :3, :]
        total[..., 3, :] = rates[..., 3, :]
        total[..., 3, 3] += 1.0
        total[..., 4, 4] = 1.0
        return total

    def _compute_gauge_rates(self, tip: Array, angles: Array) -> list[Array]:
        """Derivatives of the gauge point by tip x, y, z and by A and C, each (..., 3)."""
        a, c = angles[..., 0], angles[..., 1]
        units = [np.broadcast_to(unit, np.shape(tip)) for unit in np.eye(3)]
        rates = [rotate_x(rotate_z(unit, c), a) for unit in units]
        rates.append(rotate_x_rate(self.table.rotary_offset + rotate_z(tip, c), a))
        rates.append(rotate_x(rotate_z_rate(tip, c), a))
        return rates

    def find_nominal_pose(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Where the tool is: tip (..., 3) and nominal angles (..., 2) of joint values (..., 5)."""
        q = np.asarray(q, dtype=float)
        position, alpha, ok = self.module.forward(q[..., :-2])
        angles = np.array(q[..., -2:])
        angles[..., 0] -= alpha
        gauge = rotate_x((position - self.table.pivot) * _MIRROR, -alpha)
        tip = self.table.find_tip_of_gauge(gauge, angles, np.asarray(tool_length) + self.nose_offset)
        return tip, angles, ok

    def measure(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Array, Mask]:
        """As :meth:`find_nominal_pose`, with the tool axis (..., 3) of these angles."""
        tip, angles, ok = self.find_nominal_pose(q, tool_length)
        return tip, angles, find_axis_of_angles(angles[..., 0], angles[..., 1]), ok

    def find_platform(self, q: Array) -> tuple[Platform, Mask]:
        """The platform for joint values (..., 5)."""
        position, alpha, ok = self.module.forward(np.asarray(q)[..., :-2])
        return _make_tilted_platform(position, alpha), ok

    # --- what is measured at solved poses ---------------------------------------------------------------

    @property
    def spindle(self) -> Array:
        """Unit vector from P towards the tip, platform frame."""
        return _DOWN

    def find_tool_axis(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Tool axis (..., 3) in the table frame: as programmed."""
        return find_axis_of_angles(angles[..., 0], angles[..., 1])

    def carry_to_table(self, point: Array, q: Array) -> Array:
        """Points (..., 3) of the base frame in the table frame, for joint values (..., 5)."""
        return self.table.find_tip_of_gauge((point - self.table.pivot) * _MIRROR, q[..., -2:], 0.0)

    def find_geometry_margins(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Margins (..., m) of solved poses: those of the module."""
        return self.module.find_geometry_margins(platform.position, platform.alpha)

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`find_geometry_margins` measures, with thresholds."""
        return self.module.name_margins(serial_singularity, parallel_singularity)

    def measure_conditioning(self, q: Array, platform: Platform) -> tuple[Array, Array]:
        """Reciprocal condition numbers of the module's Jacobians, each (...)."""
        return self.module.measure_conditioning(platform.position, platform.alpha, q[..., :-2])

    def sketch(self, q: Array, platform: Platform) -> Array:
        """Rods (n, k, 2, 3) of solved poses for a picture; none of a module that cannot be drawn."""
        if not isinstance(self.module, Drawable):
            return np.empty((len(q), 0, 2, 3))
        return self.module.sketch(platform.position, platform.alpha, q[:, :-2])

    def inverse(self, tip: Array, axis: Array, tool_length: Array | float) -> tuple[Array, Mask]:
        """Joint values of a pose given by its tool axis; see :meth:`Machine.inverse`."""
        tip, angles = convert_axis_to_angles(tip, axis, tool_length)
        q, _platform, ok = self.solve(tip, angles, tool_length)
        return q, ok

    def forward(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Tip, tool axis and ok of joint values; see :meth:`Machine.forward`."""
        q = check_vectors(q, "q", 5)
        tip, angles, ok = self.find_nominal_pose(q, tool_length)
        return tip, find_axis_of_angles(angles[..., 0], angles[..., 1]), ok


def _make_tilted_platform(position: Array, alpha: Array) -> Platform:
    """The platform of a machine that only tilts about x."""
    angles = np.zeros((*np.shape(alpha), 3))
    angles[..., 0] = alpha
    return Platform(position, angles)


def convert_axis_to_angles(tip: Array, axis: Array, tool_length: Array | float) -> tuple[Array, Array]:
    """Tips (..., 3) and nominal angles (..., 2) of poses given by their tool axis, both of the common shape."""
    tip, axis = check_vectors(tip, "tip"), check_vectors(axis, "axis")
    angles = np.stack(solve_angles_of_axis(axis), axis=-1)
    shape = np.broadcast_shapes(tip.shape[:-1], axis.shape[:-1], np.shape(tool_length))
    return np.broadcast_to(tip, (*shape, 3)), np.broadcast_to(angles, (*shape, 2))


def check_vectors(value: Array, name: str, size: int = 3) -> Array:
    """An argument as an array (..., size); a ValueError names any other."""
    array = np.asarray(value, dtype=float)
    if array.ndim == 0 or array.shape[-1] != size:
        raise ValueError(f"{name} must have shape (..., {size}), got {array.shape}")
    return array
