"""Joint values together with the poses that they stand for."""

from dataclasses import dataclass

from verne_post.base.arrays import Array


@dataclass(frozen=True, eq=False)
class JointPoses:
    """Joints and poses of n rows.

    Attributes
    ----------
    q : ndarray, shape (n, n_joints)
        mm and rad.
    tip : ndarray, shape (n, 3)
        Table frame, mm.
    angles : ndarray, shape (n, 2)
        Nominal A and C, rad, workpiece sense.
    """

    q: Array
    tip: Array
    angles: Array
