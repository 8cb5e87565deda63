"""The rod equations (3) to (6) of the VERNE module and their derivatives.

Every solution, in any mode, is polished and checked with these. Arrays may have any leading shape; base frame
(z down), mm and rad.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.conditioning import find_reciprocal_condition
from verne_post.kinematics.modules.verne.geometry import VerneGeometry

#: Slider of each rod equation, and the side of the platform (sign of y of its attachment at alpha = 0).
SLIDER: Final = np.array([0, 0, 1, 2])
#: Where along x the rods are drawn at the platform, mm from P.
SKETCH_X: Final = 100.0
SIDE: Final = np.array([1.0, -1.0, -1.0, 1.0])


#: Residual of the rod equations that a polished solution must reach, over the square of a rod: 1e-9 mm on a rod of 950.
CLOSED: Final = 2e-12
#: Newton steps that polish a solution, at most.
POLISH_STEPS: Final = 40
#: A Newton step below this (over a rod; alpha in rad) leaves nothing to gain.
POLISHED: Final = 1e-15


def find_rod_vectors(geometry: VerneGeometry, position: Array, alpha: Array, rho: Array) -> Array:
    """Vectors along the rods from slider to platform, shape (..., 4, 3), mm.

    Parameters
    ----------
    position : ndarray, shape (..., 3)
    alpha : ndarray, shape (...)
    rho : ndarray, shape (..., 3)
    """
    return place_vectors(*geometry.group_lengths_by_equation()[:3], position, alpha, rho)


def place_vectors(offset: Array, radius: Array, base: Array, position: Array, alpha: Array, rho: Array) -> Array:
    """:func:`find_rod_vectors` for the x offsets, platform radii and base radii (4,) of the equations, mm."""
    alpha = np.asarray(alpha)[..., None]
    return np.stack(
        [
            position[..., :1] + offset,
            position[..., 1:2] + SIDE * (radius * np.cos(alpha) - base),
            position[..., 2:] + SIDE * radius * np.sin(alpha) - rho[..., SLIDER],
        ],
        axis=-1,
    )


def sketch(geometry: VerneGeometry, position: Array, alpha: Array, rho: Array) -> Array:
    """Rods (n, 4, 2, 3) from slider to platform for a picture, base frame, mm.

    The kinematics know the distance of slider and platform joints along x, not their places: ``SKETCH_X`` is assumed.
    """
    offset, radius, _base, _rod = geometry.group_lengths_by_equation()
    tilt = np.asarray(alpha)[..., None]
    platform = np.stack(
        [
            position[..., :1] + SKETCH_X * np.sign(-offset),
            position[..., 1:2] + SIDE * radius * np.cos(tilt),
            position[..., 2:] + SIDE * radius * np.sin(tilt),
        ],
        axis=-1,
    )
    return np.stack([platform - find_rod_vectors(geometry, position, alpha, rho), platform], axis=-2)


def compute_rod_residuals(geometry: VerneGeometry, position: Array, alpha: Array, rho: Array) -> Array:
    """Left-hand sides of (3), (4), (5), (6), shape (..., 4), mm2."""
    rod = geometry.group_lengths_by_equation()[3]
    return np.asarray((find_rod_vectors(geometry, position, alpha, rho) ** 2).sum(axis=-1) - rod**2)


def compute_rod_jacobians(geometry: VerneGeometry, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
    """Derivatives of half the left-hand sides of (3) to (6).

    ``parallel @ d(x, y, z, alpha) + serial @ d(rho) = 0``.

    Returns
    -------
    parallel : ndarray, shape (..., 4, 4)
        By x, y, z (mm) and alpha (mm2/rad).
    serial : ndarray, shape (..., 4, 3)
        By the sliders, mm.
    """
    _offset, radius, _base, _rod = geometry.group_lengths_by_equation()
    d = find_rod_vectors(geometry, position, alpha, rho)
    c, s = np.cos(alpha)[..., None], np.sin(alpha)[..., None]
    turn = SIDE * radius * (d[..., 2] * c - d[..., 1] * s)
    parallel = np.concatenate([d, turn[..., None]], axis=-1)
    serial = np.zeros((*d.shape[:-1], 3))
    serial[..., np.arange(4), SLIDER] = -d[..., 2]
    return parallel, serial


def find_scales(geometry: VerneGeometry) -> tuple[Array, float]:
    """What makes the Jacobians dimensionless: the rod of each equation, and the arm of the tilt, mm.

    The tilt counts by the larger arm of the platform: one unit is the distance that its outermost joint moves.
    """
    return geometry.group_lengths_by_equation()[3], max(geometry.R1, geometry.R2)


def measure_conditioning(geometry: VerneGeometry, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
    """Reciprocal condition numbers of both parts, dimensionless: 1 is even in all directions, 0 is singular.

    The parallel part is the matrix that a forward step inverts; the serial one, by the sliders and alpha, is the one
    that an inverse step inverts.

    Returns
    -------
    parallel, serial : ndarray, shape (...)
    """
    parallel, serial = compute_rod_jacobians(geometry, position, alpha, rho)
    rod, arm = find_scales(geometry)
    parallel = parallel / rod[:, None] / np.array([1.0, 1.0, 1.0, arm])
    serial = np.concatenate([serial / rod[:, None], parallel[..., 3:]], axis=-1)
    return find_reciprocal_condition(parallel), find_reciprocal_condition(serial)


def compute_parallel_determinant(
    geometry: VerneGeometry, position: Array, tilt: tuple[Array, Array], drops: Array
) -> Array:
    """Determinant of the scaled parallel Jacobian in the working mode, shape (...); zero at a parallel singularity.

    Rows are scaled by their rod, the column of alpha by the arm of :func:`find_scales`. The determinant is written out,
    because every pose of a program needs it. Both rods of a leg pair share their x component, so the differences of
    rows have none.

    Parameters
    ----------
    position : ndarray, shape (..., 3)
    tilt : tuple of 2 ndarrays, shape (...)
        Cosine and sine of alpha.
    drops : ndarray, shape (3, ...)
        Vertical drops of the legs, mm.
    """
    c, s = tilt
    offset, radius, base, _rod = geometry.group_lengths_by_equation()
    rod, arm = find_scales(geometry)
    tilts = (s * geometry.R1, -s * geometry.R1, 0.0, 0.0)
    rows = []
    for i in range(4):
        dy = position[..., 1] + SIDE[i] * (radius[i] * c - base[i])
        dz = drops[SLIDER[i]] + tilts[i]
        rows.append((dy, dz, SIDE[i] * radius[i] * (dz * c - dy * s)))
    leg1 = tuple(a - b for a, b in zip(rows[0], rows[1], strict=True))
    leg23 = tuple(a - b for a, b in zip(rows[2], rows[3], strict=True))
    x1, x2 = position[..., 0] + offset[0], position[..., 0] + offset[2]
    value = x1 * _compute_determinant(leg1, rows[2], leg23) + x2 * _compute_determinant(rows[0], leg1, leg23)
    return np.asarray(value / (float(np.prod(rod)) * arm))


def _compute_determinant(a: tuple[Array, ...], b: tuple[Array, ...], c: tuple[Array, ...]) -> Array:
    """Determinant of three rows of three columns."""
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])


def compute_leg_drops(geometry: VerneGeometry, z: Array, alpha: Array, rho: Array) -> Array:
    """How far the platform's attachments are below the sliders', shape (..., 3), mm; all positive in the working mode.

    Parameters
    ----------
    z : ndarray, shape (...)
        Of P, base frame, mm.
    alpha : ndarray, shape (...)
    rho : ndarray, shape (..., 3)
    """
    tilt = geometry.R2 * np.sin(alpha)
    return np.stack(np.broadcast_arrays(z - rho[..., 0], z - tilt - rho[..., 1], z + tilt - rho[..., 2]), axis=-1)


def refuse_mode(geometry: VerneGeometry, alpha: float, drops: Sequence[float] | Array) -> str | None:
    """Why a solution is not the machine's: crossed rods, or an attachment below the platform's. None: it is."""
    reasons = []
    if geometry.R1 * np.cos(alpha) <= geometry.r1:
        reasons.append("rod crossing: R1 cos(alpha) <= r1")
    for name, drop in zip(geometry.actuators, drops, strict=True):
        if drop <= 0:
            reasons.append(f"attachment of {name} not above the platform's")
    return "; ".join(reasons) or None
