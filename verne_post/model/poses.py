"""Joint values together with the poses that they stand for, and where the platform is."""

import numpy as np
from msgspec import Struct, field

from verne_post.base.arrays import Array, Ints
from verne_post.base.rotations import rotate_x, rotate_y, rotate_z


class JointPoses(Struct, frozen=True, eq=False):
    """Joints and poses of n rows."""

    q: Array  #: (n, n_joints): mm and rad.
    tip: Array  #: (n, 3): Table frame, mm.
    angles: Array  #: (n, 2): Nominal A and C, rad, workpiece sense.


class Platform(Struct, frozen=True, eq=False):
    """Where the platform of solved poses is, in the base frame."""

    position: Array  #: (..., 3): P, mm.
    #: (..., 3): alpha, beta, gamma (rad): the platform is turned by ``R = Rx(alpha) Ry(beta) Rz(gamma)``. A
    #: machine without deviations has only the tilt alpha.
    angles: Array

    @property
    def alpha(self) -> Array:
        """Platform tilt (...), rad."""
        return np.asarray(self.angles[..., 0])

    def turn(self, vector: Array) -> Array:
        """Directions (3,) or (..., 3) of the platform frame in the base frame."""
        alpha, beta, gamma = np.moveaxis(self.angles, -1, 0)
        return rotate_x(rotate_y(rotate_z(np.asarray(vector, dtype=float), gamma), beta), alpha)

    def turn_back(self, vector: Array) -> Array:
        """Inverse of :meth:`turn`."""
        alpha, beta, gamma = np.moveaxis(self.angles, -1, 0)
        return rotate_z(rotate_y(rotate_x(vector, -alpha), -beta), -gamma)

    def add_axis(self) -> "Platform":
        """Platforms (n,) as (n, 1): then :meth:`turn` takes several vectors (n, k, 3) of each."""
        return Platform(self.position[:, None], self.angles[:, None])

    def build_matrix(self) -> Array:
        """R (..., 3, 3)."""
        (ca, cb, cc), (sa, sb, sc) = np.moveaxis(np.cos(self.angles), -1, 0), np.moveaxis(np.sin(self.angles), -1, 0)
        rows = (
            (cb * cc, -cb * sc, sb),
            (ca * sc + sa * sb * cc, ca * cc - sa * sb * sc, -sa * cb),
            (sa * sc - ca * sb * cc, sa * cc + ca * sb * sc, ca * cb),
        )
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def find_platform_angles(x: Array, y: Array, z: Array) -> Array:
    """alpha, beta, gamma (..., 3) of a :class:`Platform` with unit vectors x, y, z (..., 3) in the base frame, rad."""
    angles = (
        np.arctan2(-z[..., 1], z[..., 2]),
        np.arcsin(np.clip(z[..., 0], -1.0, 1.0)),
        np.arctan2(-y[..., 0], x[..., 0]),
    )
    return np.stack(angles, axis=-1)


class Pose(Struct, frozen=True, eq=False):
    """Solved poses, n rows: what a clearance is computed from.

    ``q`` are joints (n, n_joints), ``tip`` and ``axis`` (n, 3) the tool on the table. ``segment`` is the programmed
    segment of each pose, where distances depend on it.
    """

    q: Array
    platform: Platform
    tip: Array
    axis: Array
    tool_length: Array
    segment: Ints = field(default_factory=lambda: np.empty(0, dtype=np.intp))

    def take(self, rows: Ints) -> "Pose":
        """Some of the rows."""
        platform = Platform(self.platform.position[rows], self.platform.angles[rows])
        return Pose(self.q[rows], platform, self.tip[rows], self.axis[rows], self.tool_length[rows], self.segment[rows])
