"""The whole as-built machine: six rods, table axes and spindle where they really are; implements ``FiveAxis``.

The tip is exact. The table's tilt takes the component of the tool axis that it can. What is left, along the tilt axis,
could be taken by C, which would have to swing near the pole: so C stays as programmed, unless :class:`AxisCorrection`
lets it take its share where the tool is tilted enough.
"""

from functools import cached_property
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict, replace

from verne_post.base.arrays import Array, Mask
from verne_post.base.conditioning import find_reciprocal_condition
from verne_post.base.rotations import solve_angles_of_axis, wrap_angle
from verne_post.base.tolerances import CORRECTION_STEP, DIFFERENCE_STEP
from verne_post.kinematics.as_built import inverse, margins
from verne_post.kinematics.as_built.axis_correction import AxisCorrection
from verne_post.kinematics.as_built.bodies import place_rod_ends
from verne_post.kinematics.as_built.forward import (
    PlatformPose,
    find_rod_vectors,
    map_direction_to_table,
    map_point_to_table,
    map_tool_to_table,
    solve_rods,
)
from verne_post.kinematics.as_built.geometry import LEG, MIRROR, AsBuiltGeometry, NominalTable, place_parts
from verne_post.kinematics.five_axis import HybridMachine, check_vectors, convert_axis_to_angles
from verne_post.kinematics.modules.verne.geometry import VerneGeometry
from verne_post.model.deviations import Deviations, RodPlaces
from verne_post.model.poses import Platform, find_platform_angles
from verne_post.model.protocols import Margin, WholeSolution

#: Steps that bring C, and the nominal angles of written joints, to where they stand; each gains a digit or more.
_CORRECTION_STEPS: Final = 60


class _Flat(Struct, frozen=True, eq=False):
    """Poses with components first: tip (3, n), nominal angles (2, n), length from tip to P (n,); original shape."""

    tip: Array
    angles: Array
    length: Array
    shape: tuple[int, ...]


class AsBuiltMachine(Struct, frozen=True, eq=False, dict=True):
    """The as-built machine. Table frame, mm, rad, workpiece sense."""

    nominal_machine: HybridMachine  #: Where the iterations start, and what the other working modes continue.
    places: RodPlaces  #: Where the rods are along x, nominally.
    deviations: Deviations
    #: Largest axis error before VP217, degrees; infinite where the machine file names none.
    axis_error_limit: float = np.inf
    correction: AxisCorrection | None = None  #: None: C stays as programmed.

    @cached_property
    def geometry(self) -> AsBuiltGeometry:
        """The parts where they are."""
        nominal = self.nominal_machine
        table = NominalTable(nominal.table.pivot, nominal.table.rotary_offset, nominal.nose_offset)
        assert isinstance(nominal.module, VerneGeometry)
        return place_parts(nominal.module, self.places, table, self.deviations)

    @property
    def nose_offset(self) -> float:
        """From P to the gauge line along the tool axis, mm."""
        return self.nominal_machine.nose_offset

    @property
    def spindle(self) -> Array:
        """Unit vector from P towards the tip, platform frame."""
        return self.geometry.spindle

    @property
    def corrects_axis(self) -> bool:
        """Whether C takes its share of the axis error."""
        return self.correction is not None

    def replace_deviations(self, deviations: Deviations) -> "AsBuiltMachine":
        """The machine with other deviations."""
        return replace(self, deviations=deviations)

    def switch_correction(self, *, on: bool) -> "AsBuiltMachine":
        """The machine whose C takes its share of the axis error, or does not."""
        return replace(self, correction=AxisCorrection() if on else None)

    # --- inverse ---------------------------------------------------------------------------------

    def find_platform_gauge(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Gauge point of the nominal machine; see :meth:`HybridMachine.find_platform_gauge`."""
        return self.nominal_machine.find_platform_gauge(tip, angles, tool_length)

    def solve(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Platform, Mask]:
        """Joint values that follow the programmed branch; see :meth:`HybridMachine.solve`."""
        flat = self._flatten(tip, angles, tool_length)
        n = len(flat.length)
        q, position, rotation = np.empty((n, 5)), np.empty((n, 3)), np.empty((n, 3))
        for first in range(0, n, inverse.CHUNK):
            part = slice(first, first + inverse.CHUNK)
            found, turn = self._solve_chunk(flat, part)
            q[part] = _assemble_joints(flat.angles[:, part], found, turn)
            position[part] = found.position.T
            rotation[part] = find_platform_angles(*found.rotation.transpose(1, 2, 0))
        ok, shape = np.isfinite(q[:, 0]), flat.shape
        platform = Platform(position.reshape(*shape, 3), rotation.reshape(*shape, 3))
        return q.reshape(*shape, 5), platform, ok.reshape(shape)

    def find_joints(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """The joint values of :meth:`solve` alone, (..., 5)."""
        flat = self._flatten(tip, angles, tool_length)
        q = np.empty((len(flat.length), 5))
        for first in range(0, len(q), inverse.CHUNK):
            part = slice(first, first + inverse.CHUNK)
            found, turn = self._solve_chunk(flat, part)
            q[part] = _assemble_joints(flat.angles[:, part], found, turn)
        return q.reshape(*flat.shape, 5)

    def _flatten(self, tip: Array, angles: Array, tool_length: Array | float) -> _Flat:
        tip, angles = np.asarray(tip, dtype=float), np.asarray(angles, dtype=float)
        shape = np.broadcast_shapes(tip.shape[:-1], angles.shape[:-1], np.shape(tool_length))
        n = int(np.prod(shape))
        length = np.broadcast_to(np.asarray(tool_length, dtype=float) + self.nose_offset, shape).reshape(n)
        tip = np.broadcast_to(tip, (*shape, 3)).reshape(n, 3)
        return _Flat(tip.T, np.broadcast_to(angles, (*shape, 2)).reshape(n, 2).T, length, shape)

    def _solve_chunk(self, flat: _Flat, part: slice) -> tuple[inverse.PlatformSolution, Array]:
        """Solutions of some poses, and joint C."""
        tip, angles, length = flat.tip[:, part], flat.angles[:, part], flat.length[part]
        nominal = self.nominal_machine
        gauge = nominal.find_platform_gauge(tip.T, angles.T, length - nominal.nose_offset)
        alpha = nominal.module.solve_coupled(nominal.table.pivot, gauge)[1]
        turn = angles[1]
        with np.errstate(invalid="ignore", divide="ignore"):  # what has no solution is NaN on the way
            pose = inverse.stand_on_table(self.geometry, tip, angles, turn, length)
            found = inverse.solve_platform(self.geometry, pose, inverse.make_tilts(alpha))
            if self.correction is not None:
                share = self.correction.share(angles[0])
                moved = np.flatnonzero((share > 0) & np.isfinite(found.tilt))
                if len(moved):
                    turn = turn.copy()
                    part_turn, part_found = self._correct(
                        tip[:, moved], angles[:, moved], length[moved], share[moved], found.rotation[..., moved]
                    )
                    turn[moved] = part_turn
                    for name, values in asdict(part_found).items():
                        getattr(found, name)[..., moved] = values
        return found, turn

    def _correct(
        self,
        tip: Array,
        angles: Array,
        length: Array,
        share: Array,
        rotation: Array,
        side: Array = inverse.WORKING_SIDE,
    ) -> tuple[Array, inverse.PlatformSolution]:
        """Joint C that takes its share of the axis error, and the solutions with it."""
        turn = np.zeros_like(length)  # of C, that would take the whole error
        for _ in range(_CORRECTION_STEPS):
            pose = inverse.stand_on_table(self.geometry, tip, angles, angles[1] + turn, length)
            found = inverse.solve_platform(self.geometry, pose, rotation, side)
            axis = pose.axis_along + pose.axis_upright
            rate = self.geometry.tilt_axis @ inverse.cross(self._compute_rotary_axis_upright(angles[0]), axis)
            step = found.across / rate
            turn, rotation = turn + step, found.rotation
            if bool((np.abs(step) < CORRECTION_STEP).all()):
                break
        taken = angles[1] + share * turn
        pose = inverse.stand_on_table(self.geometry, tip, angles, taken, length)
        return taken, inverse.solve_platform(self.geometry, pose, rotation, side)

    def _compute_rotary_axis_upright(self, tilt: Array) -> Array:
        """Directions of the rotary axis (3, n) in the upright frame with joint A at ``tilt`` (n,)."""
        axis = np.broadcast_to(self.geometry.rotary_axis[:, None], (3, len(tilt)))
        return inverse.turn_about(self.geometry.tilt_axis, axis, np.cos(tilt), np.sin(tilt))

    def inverse(self, tip: Array, axis: Array, tool_length: Array | float) -> tuple[Array, Mask]:
        """Joint values of a pose given by its tool axis; C takes its share of the axis error where the tilt allows."""
        tip, angles = convert_axis_to_angles(tip, axis, tool_length)
        q, _platform, ok = self.switch_correction(on=True).solve(tip, angles, tool_length)
        return q, ok

    def inverse_all(self, tip: Array, axis: Array, tool_length: float) -> list[WholeSolution]:
        """The solutions that continue those of the nominal machine, with the true parts; C as in :meth:`solve`."""
        tip = check_vectors(tip, "tip")
        solutions = []
        for one in self.nominal_machine.inverse_all(tip, axis, tool_length):
            angles = np.array(one.angles)[:, None]
            length = np.array([tool_length + self.nose_offset])
            turn = angles[1]
            pose = inverse.stand_on_table(self.geometry, tip[:, None], angles, turn, length)
            side = np.array(one.signs, dtype=float)[LEG]
            with np.errstate(invalid="ignore", divide="ignore"):
                found = inverse.solve_platform(self.geometry, pose, inverse.make_tilts(np.array([one.alpha])), side)
                share = np.zeros(1) if self.correction is None else self.correction.share(angles[0])
                if share[0] > 0:
                    turn, found = self._correct(tip[:, None], angles, length, share, found.rotation, side)
            q = _assemble_joints(angles, found, turn)[0]
            if np.isfinite(q).all():
                tilt = float(find_platform_angles(*found.rotation.transpose(1, 2, 0))[0, 0])
                solutions.append(replace(one, q=tuple(float(value) for value in q), alpha=tilt))
        return solutions

    def explain_unreachable(self, tip: Array, angles: Array, tool_length: Array | float) -> list[str]:
        """Finding codes of poses (m, 3), (m, 2) that :meth:`solve` cannot solve: those of the nominal machine."""
        return self.nominal_machine.explain_unreachable(tip, angles, tool_length)

    def find_jacobian(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Joint rates by pose rates (..., 5, 5) by central differences; see :meth:`HybridMachine.jacobian`."""
        tip, angles = np.asarray(tip, dtype=float), np.asarray(angles, dtype=float)
        columns = []
        for k in range(5):
            step_tip, step_angles = np.zeros(3), np.zeros(2)
            size = DIFFERENCE_STEP * (1.0 if k < 3 else 1e-3)
            (step_tip if k < 3 else step_angles)[k % 3] = size
            after = self.find_joints(tip + step_tip, angles + step_angles, tool_length)
            before = self.find_joints(tip - step_tip, angles - step_angles, tool_length)
            columns.append((after - before) / (2 * size))
        return np.stack(columns, axis=-1)

    # --- forward ---------------------------------------------------------------------------------

    def find_platform(self, q: Array) -> tuple[Platform, Mask]:
        """The platform for joint values (..., 5), by Newton's method on all six rods."""
        q = np.asarray(q, dtype=float)
        shape = q.shape[:-1]
        pose = self._solve_platform(q.reshape(-1, q.shape[-1]))
        angles = find_platform_angles(*pose.rotation.transpose(1, 2, 0))
        return Platform(pose.position.T.reshape(*shape, 3), angles.reshape(*shape, 3)), pose.ok.reshape(shape)

    def _solve_platform(self, q: Array) -> PlatformPose:
        n = len(q)
        position, rotation, ok = np.empty((3, n)), np.empty((3, 3, n)), np.empty(n, dtype=bool)
        for first in range(0, n, inverse.CHUNK):
            part = slice(first, first + inverse.CHUNK)
            near, alpha, _closed = self.nominal_machine.module.forward(q[part, :-2])
            with np.errstate(invalid="ignore", divide="ignore"):
                pose = solve_rods(
                    self.geometry, np.ascontiguousarray(q[part, :-2].T), near.T, inverse.make_tilts(alpha)
                )
            position[:, part], rotation[..., part], ok[part] = pose.position, pose.rotation, pose.ok
        position[:, ~ok] = np.nan
        rotation[..., ~ok] = np.nan
        return PlatformPose(position, rotation, ok)

    def forward(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Tip, tool axis and ok of joint values; see :meth:`Machine.forward`."""
        q = check_vectors(q, "q", 5)
        tip, _angles, axis, ok = self.measure(q, tool_length)
        return tip, axis, ok

    def find_nominal_pose(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """The tip, the angles and ok of :meth:`measure`."""
        tip, angles, _axis, ok = self.measure(q, tool_length)
        return tip, angles, ok

    def measure(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Array, Mask]:
        """Tip (..., 3), programmed angles (..., 2), true axis (..., 3) and validity of joint values (..., 5).

        C is the joint's, and A the one whose axis lies in one plane with the true axis and the tilt axis. Where C takes
        a share of the axis error the pair is the one that :meth:`solve` would bring to these joints.
        """
        q = np.asarray(q, dtype=float)
        shape, flat = q.shape[:-1], q.reshape(-1, 5)
        length = np.broadcast_to(np.asarray(tool_length, dtype=float), shape).reshape(-1)
        pose = self._solve_platform(flat)
        tip, axis = (
            part.T for part in map_tool_to_table(self.geometry, pose, flat[:, -2:].T, length + self.nose_offset)
        )
        angles = self._compute_programmed_angles(flat, axis)
        if self.correction is not None:
            angles = self._solve_programmed_by_correction(self.correction, flat, tip, axis, angles, length)
        ok = pose.ok & np.isfinite(angles[:, 0])
        return tip.reshape(*shape, 3), angles.reshape(*shape, 2), axis.reshape(*shape, 3), ok.reshape(shape)

    def _compute_programmed_angles(self, q: Array, axis: Array) -> Array:
        """Nominal A and C (n, 2) of true axes (n, 3) on the table, where C is as programmed."""
        geometry, c, s = self.geometry, np.cos(q[:, 4]), np.sin(q[:, 4])
        zero, one = np.zeros_like(c), np.ones_like(c)
        # the true axis, and both directions that a programmed axis Rz(-C) Rx(-A) z combines, in the tilt frame
        seen, across, up = (
            inverse.turn_about(geometry.rotary_axis, vector, c, s)
            for vector in (axis.T, np.stack([s, c, zero]), np.stack([zero, zero, one]))
        )
        normal = geometry.tilt_axis[:, None]
        a = np.arctan2(
            -inverse.sum_products(seen, inverse.cross(normal, up)),
            inverse.sum_products(seen, inverse.cross(normal, across)),
        )
        a += 2 * np.pi * np.round((q[:, 3] - a) / (2 * np.pi))
        return np.stack([a, q[:, 4]], axis=1)

    def _solve_programmed_by_correction(
        self, correction: AxisCorrection, q: Array, tip: Array, axis: Array, angles: Array, length: Array
    ) -> Array:
        """Nominal angles (n, 2) where C takes a share: from the axis where it takes all, else by repeated solution."""
        tilt, turn = solve_angles_of_axis(axis)
        other = np.sin(angles[:, 0]) < 0
        tilt, turn = np.where(other, -tilt, tilt), np.where(other, turn + np.pi, turn)
        tilt += 2 * np.pi * np.round((angles[:, 0] - tilt) / (2 * np.pi))
        turn = q[:, 4] + wrap_angle(turn - q[:, 4])
        whole = correction.share(tilt) == 1.0
        angles[whole] = np.stack([tilt, turn], axis=1)[whole]
        rows = np.flatnonzero(~whole & (correction.share(angles[:, 0]) > 0.0) & np.isfinite(tip[:, 0]))
        for _ in range(_CORRECTION_STEPS):
            if not len(rows):
                break
            miss = q[rows, 3:] - self.find_joints(tip[rows], angles[rows], length[rows])[:, 3:]
            angles[rows] += miss
            rows = rows[~(np.abs(miss).max(axis=1) < CORRECTION_STEP)]
        angles[rows] = np.nan
        return angles

    # --- what is measured at solved poses ---------------------------------------------------------------

    def find_tool_axis(self, q: Array, angles: Array, platform: Platform) -> Array:
        """True tool axis (..., 3) in the table frame."""
        upright = -MIRROR * platform.turn(self.spindle)
        flat = np.asarray(q, dtype=float).reshape(-1, 5)[:, -2:].T
        return map_direction_to_table(self.geometry, upright.reshape(-1, 3).T, flat).T.reshape(upright.shape)

    def measure_axis_error(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Angle (...) by which the tool axis is off, positive along the tilt axis, rad: what A cannot correct."""
        true = self.find_tool_axis(q, angles, platform).reshape(-1, 3)
        a, c = np.asarray(angles, dtype=float).reshape(-1, 2).T
        wanted = np.stack([np.sin(c) * np.sin(a), np.cos(c) * np.sin(a), np.cos(a)])
        turn = np.asarray(q, dtype=float).reshape(-1, 5)[:, 4]
        along = (
            self.geometry.tilt_axis @ inverse.turn_about(self.geometry.rotary_axis, axis, np.cos(turn), np.sin(turn))
            for axis in (true.T, wanted)
        )
        off, meant = (np.arcsin(part) for part in along)
        return np.asarray((off - meant).reshape(np.shape(q)[:-1]))

    def carry_to_table(self, point: Array, q: Array) -> Array:
        """Points (..., 3) of the base frame in the table frame, for joint values (..., 5)."""
        upright = (point - self.geometry.pivot) * MIRROR
        flat = np.asarray(q, dtype=float).reshape(-1, 5)[:, -2:].T
        return map_point_to_table(self.geometry, upright.reshape(-1, 3).T, flat).T.reshape(upright.shape)

    def sketch(self, q: Array, platform: Platform) -> Array:
        """Rods (n, 6, 2, 3) from slider to platform of solved poses, base frame, mm."""
        return np.stack(place_rod_ends(self.geometry, q[:, :3], platform), axis=2)

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`find_geometry_margins` measures, with thresholds."""
        return margins.name_margins(
            self.nominal_machine.module.actuators, serial_singularity, parallel_singularity, self.axis_error_limit
        )

    def find_geometry_margins(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Margins (..., m) of solved poses; see :func:`verne_post.kinematics.as_built.margins.measure_margins`."""
        shape = np.shape(q)[:-1]
        flat = np.asarray(q, dtype=float).reshape(-1, 5)
        rotation = np.moveaxis(platform.build_matrix().reshape(-1, 3, 3), 0, -1)
        across = self.measure_axis_error(q, angles, platform).reshape(-1)
        with np.errstate(invalid="ignore"):
            table = margins.measure_margins(
                self.geometry, flat[:, :3].T, platform.position.reshape(-1, 3).T, rotation, across, self._sides
            )
        return table.reshape(*shape, table.shape[-1])

    @cached_property
    def _sides(self) -> tuple[float, float]:
        """Signs of both determinants in the middle of the nominal workspace."""
        module = self.nominal_machine.module
        assert isinstance(module, VerneGeometry)
        x, _drop = module.find_workspace_middle()
        position = np.array([[x, 0.0, 0.0]])
        rho, alpha, _ok = module.inverse(position)
        vectors, arms = find_rod_vectors(self.geometry, rho.T, position.T, inverse.make_tilts(alpha))
        whole, hold = margins.compute_scaled_determinants(self.geometry, vectors, arms)
        return float(np.sign(whole[0])), float(np.sign(hold[0]))

    def measure_conditioning(self, q: Array, platform: Platform) -> tuple[Array, Array]:
        """Reciprocal condition numbers of the six-rod Jacobians, dimensionless: by pose, and by sliders and turn."""
        rotation = platform.build_matrix()
        vectors, arms = find_rod_vectors(
            self.geometry,
            np.reshape(q, (-1, 5))[:, :3].T,
            platform.position.reshape(-1, 3).T,
            np.moveaxis(rotation.reshape(-1, 3, 3), 0, -1),
        )
        arm = float(np.abs(self.geometry.platform_ends[:, 1]).max())
        rows = np.moveaxis(vectors, -1, 0).swapaxes(1, 2) / self.geometry.rods[:, None]
        moments = np.moveaxis(inverse.cross(arms, vectors), -1, 0).swapaxes(1, 2) / self.geometry.rods[:, None] / arm
        sliders = np.zeros((len(rows), 6, 3))
        sliders[:, np.arange(6), LEG] = -(rows * self.geometry.guides).sum(axis=-1)
        both = (np.concatenate([part, moments], axis=-1) for part in (rows, sliders))
        shape = np.shape(q)[:-1]
        parallel, serial = (find_reciprocal_condition(matrix).reshape(shape) for matrix in both)
        return parallel, serial


def _assemble_joints(angles: Array, found: inverse.PlatformSolution, turn: Array) -> Array:
    """Joint values (n, 5), NaN where there is no solution."""
    turn = np.where(np.isfinite(found.tilt), turn, np.nan)
    return np.column_stack([found.rho.T, angles[0] + found.tilt, turn])
