"""A five-axis machine whose rotary pair is a wrist on a carrier that turns as it moves: a central leg on three struts.

Words are nominal: A and C hold the tool axis with the carrier turned as at home, so that a program means the same part
everywhere. The joints of the wrist follow from the tool axis as the carrier sees it,

    k' = R(P)' k = (sin a sin c, sin a cos c, cos a),      a in [0, pi].

The axis of c lies along the leg. The axis of a and the gauge line cross it in one point, the wrist's centre. Its place
is W = tip + (l + g) k. So all is closed form: the leg goes from o to W, and P is on it at the wrist's reach h before W.

Whole turns of c are those to which the way of a program leads (``JointPath``); in a pose alone c is less than half a
turn from C. Where the tool stands along the leg, c means nothing: that is the wrist's pole, a singularity and a margin.
Vectors are in the polar frame of the pair, as in :mod:`~verne_post.kinematics.chain.machine`; those of the leg are in
the base frame. mm and rad.
"""

from typing import ClassVar, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.base.rotations import differentiate_axis, find_axis_of_angles, solve_angles_of_axis, wrap_angle
from verne_post.base.tolerances import POLE_SINE
from verne_post.base.units import DEG_PER_RAD
from verne_post.kinematics.chain.machine import MIRROR, ChainMachine
from verne_post.kinematics.five_axis import check_vectors, convert_axis_to_angles
from verne_post.kinematics.modules.central_leg import CentralLeg
from verne_post.model.poses import Platform, find_platform_angles
from verne_post.model.protocols import Margin, WholeSolution

#: The tilting joint of the wrist may come so near to its pole, degrees; the other then turns up to 115 times as fast.
POLE_DEG: Final = 0.5


class CarriedMachine(Struct, frozen=True, eq=False):
    """Implements the ``FiveAxis`` protocol; joints are the struts, the tilt and the turn of the wrist."""

    nose_offset: ClassVar[float] = 0.0  #: The gauge point is the platform point.
    #: The wrist on three linear axes along those of the part: what words and machine coordinates mean.
    nominal_chain: ChainMachine
    leg: CentralLeg
    to_polar: Array  #: (3, 3): Turns directions of the base frame into the polar frame.
    part_zero: Array  #: (3,): Origin of the polar frame, base frame.
    #: reach, nose: h, from P along the leg to the wrist's centre, and g, from there along the tool to the gauge
    #: point.
    reach: float
    nose: float
    actuators: tuple[str, ...]  #: Names of the struts.
    #: base_cone, platform_cone: How far struts may turn in their joints from home, degrees.
    base_cone: float | None = None
    platform_cone: float | None = None

    @property
    def spindle(self) -> Array:
        """Unit vector from the gauge point towards the tip with all joints at 0, z down."""
        return self.nominal_chain.spindle

    def find_platform_gauge(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Gauge point (..., 3) of the nominal machine, from its place at home."""
        return self.nominal_chain.find_platform_gauge(tip, angles, tool_length)

    @property
    def home(self) -> Array:
        """Joint values (5,) with the carrier at home and the wrist at 0."""
        return np.append(self.leg.find_lengths(np.array(self.leg.home, dtype=float)), [0.0, 0.0])

    # --- wrist and leg -----------------------------------------------------------------------------------------------

    def _find_carrier(self, wrist: Array) -> Array:
        """P (..., 3) in the base frame for wrist centres (..., 3) of the polar frame; NaN where W is too near."""
        away = wrist @ self.to_polar + self.part_zero - np.array(self.leg.base)
        size = np.linalg.norm(away, axis=-1, keepdims=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(size > max(self.reach, 0.0), 1.0 - self.reach / size, np.nan)
        return np.asarray(away * share + np.array(self.leg.base))

    def _find_turn(self, position: Array) -> Array:
        """How the carrier is turned at P (..., 3): (..., 3, 3), polar directions."""
        return np.asarray(self.to_polar @ self.leg.find_turn(position) @ self.to_polar.T)

    @np.errstate(all="ignore")
    def _solve(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Joints (..., 5), P (..., 3) and ok (...)."""
        angles = np.asarray(angles, dtype=float)
        axis = find_axis_of_angles(angles[..., 0], angles[..., 1])
        wrist = tip + (np.asarray(tool_length, dtype=float) + self.nose)[..., None] * axis
        position = self._find_carrier(wrist)
        inside = (np.swapaxes(self._find_turn(position), -1, -2) @ axis[..., None])[..., 0]
        near = find_nominal_turn(angles)
        tilt, turn = solve_angles_of_axis(inside)
        turn = choose_turn(tilt, turn, near)
        q = np.empty((*position.shape[:-1], 5))
        q[..., :3] = self.leg.find_lengths(position)
        q[..., 3:] = self.nominal_chain.pair.find_joints(np.stack([tilt, turn], axis=-1))
        ok = np.asarray(np.isfinite(q).all(axis=-1))
        ok[ok] = self.leg.is_own(position[ok])
        q[~ok] = np.nan
        return q, position, ok

    def find_joints(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Joint values (..., 5) of tips (..., 3) and nominal angles (..., 2); NaN out of reach."""
        return self._solve(tip, angles, tool_length)[0]

    def solve(self, tip: Array, angles: Array, tool_length: Array | float) -> tuple[Array, Platform, Mask]:
        """Joint values, platform and ok; see ``FiveAxis``."""
        q, position, ok = self._solve(tip, angles, tool_length)
        return q, self._find_platform(position, q), ok

    def explain_unreachable(self, tip: Array, angles: Array, tool_length: Array | float) -> list[str]:
        """Finding codes of poses (m, 3), (m, 2) without a solution: VP203 beyond a singularity, VP110 out of reach."""
        axis = find_axis_of_angles(angles[..., 0], angles[..., 1])
        with np.errstate(invalid="ignore", divide="ignore"):
            position = self._find_carrier(tip + (np.asarray(tool_length, dtype=float) + self.nose)[..., None] * axis)
            return ["VP203" if within else "VP110" for within in self.leg.is_within(position)]

    @property
    def no_reach(self) -> str:
        """What keeps a pose out of reach: struts have a length for every pose."""
        most = f"{self.leg.largest_turn_deg:g} degrees from home"
        return f"the central leg would turn {most} or more (carrier.largest_turn_deg)"

    def inverse_all(self, tip: Array, axis: Array, tool_length: float) -> list[WholeSolution]:
        """Both solutions of a pose (3,), (3,) in the polar frame: the wrist on either side; first, the used one."""
        tip, axis = check_vectors(tip, "tip"), check_vectors(axis, "axis")
        tilt, turn = (float(angle) for angle in solve_angles_of_axis(axis))
        q, _position, ok = self._solve(tip, np.array([tilt, turn]), tool_length)
        if not ok:
            return []
        a, c = self.nominal_chain.pair.find_angles(q[3:])
        other = np.append(q[:3], self.nominal_chain.pair.find_joints(np.array([-a, wrap_angle(c + np.pi)])))
        why = "the wrist on the other side of its pole"
        return [
            WholeSolution(tuple(q.tolist()), (tilt, turn), 0.0, (), False, None),
            WholeSolution(tuple(other.tolist()), (-tilt, float(wrap_angle(turn + np.pi))), 0.0, (), True, why),
        ]

    # --- joints to poses -----------------------------------------------------------------------------------

    @np.errstate(all="ignore")
    def measure(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Array, Mask]:
        """Tip (..., 3), nominal angles (..., 2) with A in [0, pi], tool axis (..., 3) and ok (...) of q (..., 5).

        C is less than half a turn from the wrist's; it is the wrist's where the tool stands upright, and C is free.
        """
        q = np.asarray(q, dtype=float)
        position, ok = self.leg.find_position(q[..., :3])
        own = self.nominal_chain.pair.find_angles(q[..., 3:])
        axis = (self._find_turn(position) @ find_axis_of_angles(own[..., 0], own[..., 1])[..., None])[..., 0]
        away = position - np.array(self.leg.base)
        along = away / np.linalg.norm(away, axis=-1, keepdims=True)
        wrist = (position + self.reach * along - self.part_zero) @ self.to_polar.T
        tip = wrist - (np.asarray(tool_length, dtype=float) + self.nose)[..., None] * axis
        tilt, turn = solve_angles_of_axis(axis)
        near = find_nominal_turn(own)
        turn = choose_turn(tilt, turn, near)
        ok = ok & np.isfinite(tip).all(axis=-1) & np.isfinite(axis).all(axis=-1)
        return tip, np.stack([tilt, turn], axis=-1), axis, np.asarray(ok)

    def find_nominal_pose(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """As :meth:`measure`, without the tool axis."""
        tip, angles, _axis, ok = self.measure(q, tool_length)
        return tip, angles, ok

    @np.errstate(all="ignore")
    def inverse(self, tip: Array, axis: Array, tool_length: Array | float) -> tuple[Array, Mask]:
        """Joint values of a pose in the part frame; see :meth:`Machine.inverse`."""
        directions = self.nominal_chain.pair.directions
        tip, axis = (check_vectors(*one) @ directions.T for one in ((tip, "tip"), (axis, "axis")))
        q, _position, ok = self._solve(*convert_axis_to_angles(tip, axis, tool_length), tool_length)
        return q, ok

    @np.errstate(all="ignore")
    def forward(self, q: Array, tool_length: Array | float) -> tuple[Array, Array, Mask]:
        """Tip and tool axis in the part frame, and ok; see :meth:`Machine.forward`."""
        q = check_vectors(q, "q", 5)
        tip, _angles, axis, ok = self.measure(q, tool_length)
        directions = self.nominal_chain.pair.directions
        return tip @ directions, axis @ directions, ok

    def find_jacobian(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Joint rates by pose rates, (..., 5, 5): rows the joints, columns tip x, y, z (mm), nominal A and C (rad)."""
        q, position, _ok = self._solve(tip, angles, tool_length)
        angles = np.broadcast_to(np.asarray(angles, dtype=float), (*q.shape[:-1], 2))
        turns = np.zeros((*q.shape[:-1], 3, 5))  # the tool axis by the pose
        turns[..., 3:] = differentiate_axis(angles)
        moves = (np.asarray(tool_length, dtype=float) + self.nose)[..., None, None] * turns  # W by the pose
        moves[..., :3] += np.eye(3)
        away = position - np.array(self.leg.base)
        size = np.linalg.norm(away, axis=-1)[..., None, None]
        along = away[..., None] / size
        share = self.reach / (size + self.reach)
        by_wrist = (1.0 - share) * np.eye(3) + share * along @ np.swapaxes(along, -1, -2)
        carried = by_wrist @ (self.to_polar.T @ moves)  # P by the pose, base frame
        spin = self.to_polar @ self.leg.find_turn_rates(position) @ carried
        axis = find_axis_of_angles(angles[..., 0], angles[..., 1])
        back = np.swapaxes(self._find_turn(position), -1, -2)
        seen = back @ (turns - np.cross(spin, axis[..., None], axis=-2))
        own = self.nominal_chain.pair.find_angles(q[..., 3:])
        sin_a, sin_c, cos_c = np.sin(own[..., 0]), np.sin(own[..., 1]), np.cos(own[..., 1])
        rates = np.empty((*q.shape[:-1], 5, 5))
        rates[..., :3, :] = self.leg.find_rates(position) @ carried
        rates[..., 3, :] = (differentiate_axis(own)[..., None, :, 0] @ seen)[..., 0, :]
        level = np.stack([cos_c, -sin_c, np.zeros_like(sin_a)], -1)  # along which the axis goes while C turns
        with np.errstate(divide="ignore", invalid="ignore"):
            rates[..., 4, :] = (level[..., None, :] @ seen)[..., 0, :] / sin_a[..., None]
        return rates

    # --- bodies and pictures: z down, the part stands still -------------------------------------------------

    def find_platform(self, q: Array) -> tuple[Platform, Mask]:
        """The spindle's end as a platform, for joint values (..., 5)."""
        q = np.asarray(q, dtype=float)
        position, ok = self.leg.find_position(q[..., :3])
        return self._find_platform(position, q), ok & np.isfinite(q).all(axis=-1)

    @np.errstate(all="ignore")
    def _find_platform(self, position: Array, q: Array) -> Platform:
        """The same where P (..., 3) is known."""
        turn = self._find_turn(position)
        chain = self.nominal_chain
        middle = chain.turn_tool(np.zeros(3), q[..., 3:])
        units = [
            (turn @ (chain.turn_tool(unit, q[..., 3:]) - middle)[..., None])[..., 0] * MIRROR
            for unit in np.diag(MIRROR)
        ]
        away = position - np.array(self.leg.base)
        along = away / np.linalg.norm(away, axis=-1, keepdims=True)
        wrist = (position + self.reach * along - self.part_zero) @ self.to_polar.T
        axis = (turn @ (chain.turn_tool(chain.axis, q[..., 3:]) - middle)[..., None])[..., 0]
        return Platform((wrist - self.nose * axis) * MIRROR, find_platform_angles(*units))

    def find_tool_axis(self, q: Array, angles: Array, platform: Platform) -> Array:
        """Tool axis (..., 3) in the polar frame: as programmed."""
        return find_axis_of_angles(angles[..., 0], angles[..., 1])

    def carry_to_table(self, point: Array, q: Array) -> Array:
        """Points (..., 3) of the base frame with z down in the polar frame of the part, which stands still."""
        return np.asarray(point * MIRROR)

    @np.errstate(all="ignore")
    def find_geometry_margins(self, q: Array, angles: Array, platform: Platform) -> Array:
        """The Jacobian's measure, the wrist's way to its pole, and what is left of cones, degrees."""
        axis = find_axis_of_angles(angles[..., 0], angles[..., 1])
        position = self._find_carrier(platform.position * MIRROR + self.nose * axis)
        own = self.nominal_chain.pair.find_angles(q[..., 3:])
        first = [self.leg.measure(position), DEG_PER_RAD * np.abs(own[..., 0])]
        cones = [
            cone - DEG_PER_RAD * turned
            for cone, turned in zip((self.base_cone, self.platform_cone), self.leg.measure_cones(position), strict=True)
            if cone is not None
        ]
        return np.concatenate([np.stack(first, axis=-1), *cones], axis=-1)

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`find_geometry_margins` measures, with thresholds."""
        cones = ((self.base_cone, "base"), (self.platform_cone, "platform"))
        return (
            Margin(
                "measure of the parallel Jacobian", "VP203", None, "", parallel_singularity, 2 * parallel_singularity
            ),
            Margin("tilt of the tool against the central leg", "VP202", None, "deg", POLE_DEG, 2 * POLE_DEG),
            *(
                Margin(f"angle left to the strut's joint on the {where}", "VP214", name, "deg", 0.0, 0.0)
                for cone, where in cones
                if cone is not None
                for name in self.actuators
            ),
        )

    def measure_conditioning(self, q: Array, platform: Platform) -> tuple[Array, Array]:
        """Reciprocal condition number of the struts' rates, and 1: struts have no serial singularity."""
        conditions = self.leg.measure_conditioning(self.leg.find_position(q[..., :3])[0])
        return conditions, np.ones_like(conditions)

    def sketch(self, q: Array, platform: Platform) -> Array:
        """Struts and last the central leg to the wrist's centre (n, 4, 2, 3) for a picture, base frame with z down."""
        position = self.leg.find_position(q[..., :3])[0]
        foot, end = self.leg.find_rods(position)
        base = np.broadcast_to(np.array(self.leg.base), position.shape)
        away = position - base
        wrist = position + self.reach * away / np.linalg.norm(away, axis=-1, keepdims=True)
        leg = np.stack([base, wrist], axis=-2)
        rods = np.concatenate([np.stack([foot, end], axis=-2), leg[..., None, :, :]], axis=-3)
        return np.asarray(((rods - self.part_zero) @ self.to_polar.T) * MIRROR)


def find_nominal_turn(angles: Array) -> Array:
    """C (...) of the same tool axis with A > 0, of angles (..., 2): half a turn on where A < 0."""
    return np.asarray(angles[..., 1] + np.where(np.sin(angles[..., 0]) < -POLE_SINE, np.pi, 0.0))


def choose_turn(tilt: Array, turn: Array, near: Array) -> Array:
    """C (...) less than half a turn from ``near``, of ``turn`` (-pi, pi]; ``near`` itself where the tool is upright."""
    return np.where(np.sin(tilt) > POLE_SINE, near + wrap_angle(turn - near), near)
