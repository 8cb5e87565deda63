"""JointPath: the actuated joints along a tool path, exactly: q(piece, u)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from verne_post.model.machine import Machine
from verne_post.model.protocols import PoseFunction
from verne_post.model.toolpath import PieceKind, ToolPath

Array = NDArray[np.float64]
Ints = NDArray[np.integer]


@dataclass(frozen=True, eq=False)
class Solved:
    """Everything known about solved poses; all arrays of length n, NaN where not ok."""

    q: Array
    tip: Array
    angles: Array
    position: Array
    alpha: Array
    ok: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class JointPath:
    """The joints of a machine that follows a tool path.

    ``pose`` evaluates the programmed geometry; it is handed in, because kinematics knows no tool path.
    """

    path: ToolPath
    machine: Machine
    pose: PoseFunction

    def solve(self, piece: Ints, u: Array) -> Solved:
        """Solve poses at parameter u (n,) of pieces (n,)."""
        path, five_axis = self.path, self.machine.five_axis
        length = path.tool_length[piece]
        tip, angles = self.pose(path, piece, u)
        joint = np.flatnonzero(path.kind[piece] == PieceKind.JOINT)
        q_joint = np.empty((0, 0))
        if len(joint):
            ends = path.joints[path.joint[piece[joint]]]
            q_joint = ends[:, 0] + u[joint, None] * (ends[:, 1] - ends[:, 0])
            tip[joint], angles[joint], _ok = five_axis.nominal(q_joint, length[joint])
        q, position, alpha, ok = five_axis.solve(tip, angles, length)
        if len(joint):
            q[joint] = q_joint
        return Solved(q, tip, angles, position, alpha, ok)

    def q(self, piece: Ints, u: Array) -> Array:
        """Joint values (n, n_joints), mm and rad, workpiece sense; NaN where unsolvable."""
        return self.solve(piece, u).q
