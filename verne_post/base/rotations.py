"""Rotations about single axes, and the meaning of a programmed pair (A, C) as a tool axis.

Every function is vectorised over leading dimensions. Points are transformed, axes only rotated.
Angles are in rad and in *workpiece sense*: positive A and C turn the workpiece by the right-hand
rule about x and z of the ``upright`` frame (see docs/conventions.md).
"""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.tolerances import POLE_SINE


def _stack_coordinates(x: Array, y: Array, z: Array) -> Array:
    """Vectors (..., 3) of their coordinates."""
    shapes = {np.shape(x), np.shape(y), np.shape(z)}
    vectors = np.empty((*(np.broadcast_shapes(*shapes) if len(shapes) > 1 else shapes.pop()), 3))
    vectors[..., 0], vectors[..., 1], vectors[..., 2] = x, y, z
    return vectors


def rotate_x(vector: Array, angle: Array | float) -> Array:
    """Turn vectors about x: ``Rx(angle) @ vector``, active, column vectors.

    Parameters
    ----------
    vector : ndarray, shape (..., 3)
    angle : ndarray, shape (...)
        rad.

    Returns
    -------
    ndarray, shape (..., 3)
    """
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    return _stack_coordinates(x, c * y - s * z, s * y + c * z)


def rotate_y(vector: Array, angle: Array | float) -> Array:
    """Turn vectors about y: ``Ry(angle) @ vector``; shapes as in :func:`rotate_x`."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    return _stack_coordinates(c * x + s * z, y, c * z - s * x)


def rotate_z(vector: Array, angle: Array | float) -> Array:
    """Turn vectors about z: ``Rz(angle) @ vector``; shapes as in :func:`rotate_x`."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    return _stack_coordinates(c * x - s * y, s * x + c * y, z)


def rotate_x_rate(vector: Array, angle: Array | float) -> Array:
    """Derivative of :func:`rotate_x` by the angle."""
    turned = rotate_x(vector, angle)
    return np.stack([np.zeros_like(turned[..., 0]), -turned[..., 2], turned[..., 1]], axis=-1)


def rotate_z_rate(vector: Array, angle: Array | float) -> Array:
    """Derivative of :func:`rotate_z` by the angle."""
    turned = rotate_z(vector, angle)
    return np.stack([-turned[..., 1], turned[..., 0], np.zeros_like(turned[..., 0])], axis=-1)


def measure_angles(one: Array, other: Array) -> Array:
    """Angles (...) between vectors (..., 3) of any length, rad."""
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(one, other), axis=-1), (one * other).sum(axis=-1)))


def wrap_angle(angle: Array | float) -> Array:
    """The same direction in (-pi, pi]."""
    return np.pi - np.mod(np.pi - np.asarray(angle, dtype=float), 2 * np.pi)


def find_axis_of_angles(a: Array | float, c: Array | float) -> Array:
    """Tool axis in the table frame that the nominal trunnion machine holds at (A, C).

    Parameters
    ----------
    a, c : ndarray, shape (...)
        Nominal tilt and rotary angle, rad, workpiece sense.

    Returns
    -------
    ndarray, shape (..., 3)
        Unit vectors from tip to spindle, ``(sin A sin C, sin A cos C, cos A)``.
    """
    sa = np.sin(a)
    return _stack_coordinates(sa * np.sin(c), sa * np.cos(c), np.cos(a))


def differentiate_axis(angles: Array) -> Array:
    """Derivatives (..., 3, 2) of :func:`find_axis_of_angles` by A and C, for angles (..., 2) in rad."""
    (sin_a, sin_c), (cos_a, cos_c) = np.moveaxis(np.sin(angles), -1, 0), np.moveaxis(np.cos(angles), -1, 0)
    by_tilt = np.stack([cos_a * sin_c, cos_a * cos_c, -sin_a], axis=-1)
    return np.stack([by_tilt, np.stack([sin_a * cos_c, -sin_a * sin_c, np.zeros_like(sin_a)], axis=-1)], axis=-1)


def solve_angles_of_axis(axis: Array) -> tuple[Array, Array]:
    """Nominal angles of a tool axis: the solution with b in [0, pi], C in (-pi, pi].

    Parameters
    ----------
    axis : ndarray, shape (..., 3)
        Unit vectors in the table frame.

    Returns
    -------
    b, c : ndarray, shape (...)
        rad. At the pole, where the rotary angle means nothing, c = 0.
    """
    kx, ky, kz = axis[..., 0], axis[..., 1], axis[..., 2]
    sine = np.hypot(kx, ky)
    c = np.where(sine > POLE_SINE, np.arctan2(kx, ky), 0.0)
    return np.arctan2(sine, kz), np.where(c <= -np.pi, np.pi, c)
