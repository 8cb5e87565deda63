"""The rod equations (3) to (6) of the VERNE as functions of its lengths, in mm of rod, with every derivative.

What an identification needs; the product's path never asks for derivatives by a length. Base frame, mm, rad.
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.kinematics.modules.verne.rods import SIDE, SLIDER, place_vectors

#: The lengths in the order of [module]; offsets may have either sign, the others are positive.
LENGTHS: Final = ("leg1_x_offset", "R1", "r1", "L1", "leg23_x_offset", "R2", "r4", "L2", "L3")
SIGNED: Final = frozenset({"leg1_x_offset", "leg23_x_offset"})

#: Of the equations (3), (4), (5), (6): offset, platform arm, slider arm and rod as indices of LENGTHS.
_OFFSET: Final = np.array([0, 0, 4, 4])
_ARM: Final = np.array([1, 1, 5, 5])
_BASE: Final = np.array([2, 2, 6, 6])
_ROD: Final = np.array([3, 3, 7, 8])


def evaluate_loops(lengths: Array, rho: Array, pose: Array) -> tuple[Array, Array, Array, Array]:
    """How much too long each rod would have to be, by (3), (4), (5), (6), and the derivatives of that.

    The paper's equation ``d^2 - L^2 = 0`` is taken as ``d - L = 0``, d the distance that the rod must span: the same
    root, but a length, so that misfits of different rods compare.

    Parameters
    ----------
    lengths : ndarray, shape (9,)
        In the order of :data:`LENGTHS`, mm.
    rho : ndarray, shape (n, 3)
        Sliders, mm.
    pose : ndarray, shape (n, 4)
        x, y, z of P (base frame, mm) and alpha (rad).

    Returns
    -------
    value : ndarray, shape (n, 4)
        mm; zero where the rods close.
    by_lengths : ndarray, shape (n, 4, 9)
    by_sliders : ndarray, shape (n, 4, 3)
    by_pose : ndarray, shape (n, 4, 4)
    """
    n = len(rho)
    alpha = pose[:, 3]
    c, s = np.cos(alpha)[:, None], np.sin(alpha)[:, None]
    arm, rod = lengths[_ARM], lengths[_ROD]
    rods = place_vectors(lengths[_OFFSET], arm, lengths[_BASE], pose[:, :3], alpha, rho)
    span = np.linalg.norm(rods, axis=-1)
    ux, uy, uz = np.moveaxis(rods / span[..., None], -1, 0)
    each = np.arange(4)
    by_lengths = np.zeros((n, 4, len(LENGTHS)))
    by_lengths[:, each, _OFFSET] = ux
    by_lengths[:, each, _ARM] = SIDE * (c * uy + s * uz)
    by_lengths[:, each, _BASE] = -SIDE * uy
    by_lengths[:, each, _ROD] = -1.0
    by_sliders = np.zeros((n, 4, 3))
    by_sliders[:, each, SLIDER] = -uz
    by_pose = np.stack([ux, uy, uz, SIDE * arm * (c * uz - s * uy)], axis=-1)
    return span - rod, by_lengths, by_sliders, by_pose
