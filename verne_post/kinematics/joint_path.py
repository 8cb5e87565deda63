"""JointPath: the actuated joints along a contour, exactly: q(element, w)."""

from collections.abc import Iterator
from functools import cached_property
from typing import Final, Protocol

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.ragged import number_parts
from verne_post.model.contour import Contour
from verne_post.model.machine import Machine
from verne_post.model.poses import JointPoses, Platform, Pose
from verne_post.model.protocols import Carrying, ClearanceModel, Nutating, PoseFunction, SpeedFunction
from verne_post.model.toolpath import SegmentKind

#: Rows evaluated at a time: what lies between pose and joints then stays in the processor's cache.
EVALUATED_ROWS: Final = 4096
#: Whole turns of a wrist on a carrier are followed in steps of so much path and rotation. Its pole is 0.5 degrees wide,
#: and beside it the turning joint moves by less than half a turn in one step.
TURN_STEP_MM: Final = 4.0
TURN_STEP: Final = np.radians(0.5)


class KeepOutModel(ClearanceModel, Protocol):
    """Distances from boxes on the table."""

    def move_part(self, shift: Array) -> "KeepOutModel":
        """The same where the part stands elsewhere on the table by ``shift`` (3,), mm."""


class Solved(JointPoses, frozen=True, eq=False):
    """Solved poses, and where the platform is; NaN where not ok (n,)."""

    platform: Platform
    ok: Mask


class JointPath(Struct, frozen=True, eq=False, dict=True):
    """The joints of a machine that follows a contour.

    ``pose`` evaluates the geometry and ``speed`` the feed; they are handed in, because kinematics knows no tool path.
    In a dry run the real tool is ``lift`` (mm) shorter than the one that the poses are solved with. ``keep_out`` holds
    the boxes that the motion has to keep out of, None where there are none.
    """

    contour: Contour
    machine: Machine
    pose: PoseFunction
    speed: SpeedFunction
    lift: float = 0.0
    keep_out: KeepOutModel | None = None

    def solve(self, element: Ints, w: Array) -> Solved:
        """Solve poses at parameter w (n,) of elements (n,)."""
        tip, angles, length, joint, q_joint = self._evaluate_pose(element, w)
        q, platform, ok = self.machine.five_axis.solve(tip, angles, length)
        q[joint] = q_joint
        self._lay_joints(element, w, tip, length, q)
        self._follow_turns(element, w, q)
        return Solved(q, tip, angles, platform, ok)

    def find_solvable(self, element: Ints, w: Array) -> Mask:
        """Which of the poses (n,) of :meth:`solve` can be solved.

        No turn of a wrist is followed, so the pose function may be one that places these n points alone.
        """
        tip, angles, length, _joint, _q_joint = self._evaluate_pose(element, w)
        return self.machine.five_axis.solve(tip, angles, length)[2]

    def find_tool_axis(self, solved: Solved) -> Array:
        """Tool axis (n, 3) on the table."""
        return self.machine.five_axis.find_tool_axis(solved.q, solved.angles, solved.platform)

    def find_margins(self, solved: Solved) -> Array:
        """Margins of the geometry (n, m)."""
        return self.machine.five_axis.find_geometry_margins(solved.q, solved.angles, solved.platform)

    def _evaluate_pose(self, element: Ints, w: Array) -> tuple[Array, Array, Array, Ints, Array]:
        """Tip, nominal angles, tool length; which of the poses (n,) are on motions in joint space, and their joints."""
        path, five_axis = self.contour.path, self.machine.five_axis
        segment = self.contour.segment[element]
        length = path.tool_length[segment]
        tip, angles = self.pose(self.contour, element, w)
        joint = np.flatnonzero(path.kind[segment] == SegmentKind.JOINT)
        q_joint = np.empty((0, 1))
        if len(joint):
            ends = path.joints[path.joint[segment[joint]]]
            q_joint = ends[:, 0] + w[joint, None] * (ends[:, 1] - ends[:, 0])
            tip[joint], angles[joint], _ok = five_axis.find_nominal_pose(q_joint, length[joint])
        return tip, angles, length, joint, q_joint

    def _lay_joints(self, element: Ints, w: Array, tip: Array, length: Array, q: Array) -> None:
        """Take q (n, n_joints) of a nutating pair from its joints where these go linearly: A is unsure near a fold."""
        path, five_axis = self.contour.shape, self.machine.five_axis
        if not len(path.circles.joints) or not isinstance(five_axis, Nutating):
            return
        row = path.circle[self.contour.segment[element]]
        on = np.flatnonzero((row >= 0) & np.isfinite(path.circles.joints[row, 0]) & ~self.contour.blended[element])
        joints = path.circles.joints[row[on], :4]
        turns = joints[:, :2] + self.contour.find_parameters(element[on], w[on])[:, None] * (
            joints[:, 2:] - joints[:, :2]
        )
        q[on] = five_axis.place_joints(tip[on], turns, length[on])

    def _follow_turns(self, element: Ints, w: Array, q: Array) -> None:
        """Put the turning joint of a wrist on a carrier, in q (n, n_joints), on the turn to which its way leads."""
        if self.is_carrying:
            place, turn = self._turns
            q[:, -1] += 2 * np.pi * np.round((np.interp(element + w, place, turn) - q[:, -1]) / (2 * np.pi))

    @cached_property
    def is_carrying(self) -> bool:
        """Whether the machine's wrist is on a carrier; asking takes as long as solving a hundred poses."""
        return isinstance(self.machine.five_axis, Carrying)

    @cached_property
    def _turns(self) -> tuple[Array, Array]:
        """Places along the contour (m,), element plus parameter, and the turning joint there without jumps."""
        contour = self.contour
        wanted = np.maximum(contour.length[:] / TURN_STEP_MM, contour.rotation[:] / TURN_STEP)
        owner, index = number_parts(parts := np.maximum(np.ceil(wanted), 1).astype(int))
        w = index / parts[owner]
        element, w = np.append(owner, len(contour) - 1), np.append(w, 1.0)
        turn = np.empty(len(w))
        for part in _split_rows(len(w)):
            tip, angles, length, joint, q_joint = self._evaluate_pose(element[part], w[part])
            q = self.machine.five_axis.find_joints(tip, angles, length)
            q[joint] = q_joint
            turn[part] = q[:, -1]
        known = np.isfinite(turn)
        if not known.any():
            return element + w, np.zeros(len(w))
        turn = np.unwrap(turn[np.maximum.accumulate(np.where(known, np.arange(len(w)), np.argmax(known)))])
        return element + w, turn

    def place_bodies(self, element: Ints, solved: Solved) -> Pose:
        """Where the real tool and the module are at solved poses of elements (n,)."""
        segment = self.contour.segment[element]
        tip, axis = solved.tip, self.find_tool_axis(solved)
        if self.lift:
            tip = tip + self.lift * axis
        length = self.contour.path.tool_length[segment] - self.lift
        return Pose(solved.q, solved.platform, tip, axis, length, segment)

    def find_joints(self, element: Ints, w: Array) -> Array:
        """Joint values (n, n_joints), mm and rad, workpiece sense; NaN where unsolvable."""
        return self.find_joint_poses(element, w).q

    def find_joint_poses(self, element: Ints, w: Array) -> JointPoses:
        """As :meth:`find_joints`, with the poses."""
        n = len(w)
        rows = JointPoses(np.empty((n, len(self.machine.columns))), np.empty((n, 3)), np.empty((n, 2)))
        for part in _split_rows(n):
            tip, angles, length, joint, q_joint = self._evaluate_pose(element[part], w[part])
            rows.tip[part], rows.angles[part] = tip, angles
            rows.q[part] = self.machine.five_axis.find_joints(tip, angles, length)
            rows.q[part][joint] = q_joint
            self._lay_joints(element[part], w[part], tip, length, rows.q[part])
            self._follow_turns(element[part], w[part], rows.q[part])
        return rows

    def find_speed_cap(self, element: Ints, w: Array) -> Array:
        """Largest ds/dt (n,) that the feed allows, mm/s; infinite for rapids."""
        speed = np.empty(len(w))
        for part in _split_rows(len(w)):
            speed[part] = self.speed(self.contour, element[part], w[part])
        return speed


def _split_rows(n: int) -> Iterator[slice]:
    """Rows evaluated at a time, of n."""
    for first in range(0, n, EVALUATED_ROWS):
        yield slice(first, first + EVALUATED_ROWS)
