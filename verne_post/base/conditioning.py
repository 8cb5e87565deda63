"""How near square matrices, the Jacobians of mechanisms, are to singular ones."""

import numpy as np

from verne_post.base.arrays import Array


def measure_singularity(matrix: Array) -> Array:
    """Signed 1 over the norm (...) of the inverse of matrices (..., n, n).

    At most the least singular value, with the sign of the determinant: smooth through 0. NaN where numbers are missing.
    """
    determinant = np.linalg.det(matrix)
    sound = np.isfinite(determinant) & (determinant != 0.0)
    try:
        inverse = np.linalg.inv(np.where(sound[..., None, None], matrix, np.eye(matrix.shape[-1])))
    except np.linalg.LinAlgError:  # as singular as digits tell
        return np.zeros(determinant.shape)
    size = np.sqrt((inverse**2).sum(axis=(-2, -1)))
    return np.where(sound, np.sign(determinant) / size, np.where(determinant == 0.0, 0.0, np.nan))


def find_reciprocal_condition(matrix: Array) -> Array:
    """Least over largest singular value (...) of matrices (..., n, m)."""
    singular = np.linalg.svd(matrix, compute_uv=False)
    return np.asarray(singular[..., -1] / singular[..., 0])
