"""Rotations of the platform as matrices with poses last, (3, 3, n), and as the three angles of :class:`Platform`."""

import numpy as np

from verne_post.base.arrays import Array


def make_tilts(alpha: Array) -> Array:
    """Rotations (3, 3, n) about x by tilts (n,)."""
    c, s = np.cos(alpha), np.sin(alpha)
    one, zero = np.ones_like(c), np.zeros_like(c)
    return np.array([[one, zero, zero], [zero, c, -s], [zero, s, c]])


def solve_angles_of_rotation(rotation: Array) -> Array:
    """Angles alpha, beta, gamma (n, 3) of rotations (3, 3, n) = Rx(alpha) Ry(beta) Rz(gamma), rad."""
    return np.stack(
        [
            np.arctan2(-rotation[1, 2], rotation[2, 2]),
            np.arcsin(rotation[0, 2]),
            np.arctan2(-rotation[0, 1], rotation[0, 0]),
        ],
        axis=1,
    )
