"""The rod equations (3) to (6) of the VERNE module, their derivatives, and the rods as bodies.

Everything that closes a rod, in any mode, is judged and polished with these. Arrays may have any leading shape;
base frame (z down), mm and rad.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from verne_post.kinematics.modules.verne.module import VerneModule

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Slider of each rod equation, and the side of the platform (sign of y of its attachment at alpha = 0).
SLIDER: Final = np.array([0, 0, 1, 2])
#: Where along x the rods are drawn at the platform, mm from P.
SKETCH_X: Final = 100.0
SIDE: Final = np.array([1.0, -1.0, -1.0, 1.0])


def _lengths(module: "VerneModule") -> tuple[Array, Array, Array, Array]:
    """X offset, platform radius, base radius and rod length of each equation."""
    m = module
    return (
        np.array([m.leg1_x_offset, m.leg1_x_offset, m.leg23_x_offset, m.leg23_x_offset]),
        np.array([m.R1, m.R1, m.R2, m.R2]),
        np.array([m.r1, m.r1, m.r4, m.r4]),
        np.array([m.L1, m.L1, m.L2, m.L3]),
    )


def rod_vectors(module: "VerneModule", position: Array, alpha: Array, rho: Array) -> Array:
    """Vectors along the rods from slider to platform, shape (..., 4, 3), mm.

    Parameters
    ----------
    module : VerneModule
    position : ndarray, shape (..., 3)
    alpha : ndarray, shape (...)
    rho : ndarray, shape (..., 3)
    """
    return vectors(*_lengths(module)[:3], position, alpha, rho)


def vectors(offset: Array, radius: Array, base: Array, position: Array, alpha: Array, rho: Array) -> Array:
    """:func:`rod_vectors` for the x offsets, platform radii and base radii (4,) of the equations, mm."""
    alpha = np.asarray(alpha)[..., None]
    return np.stack(
        [
            position[..., :1] + offset,
            position[..., 1:2] + SIDE * (radius * np.cos(alpha) - base),
            position[..., 2:] + SIDE * radius * np.sin(alpha) - rho[..., SLIDER],
        ],
        axis=-1,
    )


def sketch(module: "VerneModule", position: Array, alpha: Array, rho: Array) -> Array:
    """Rods (n, 4, 2, 3) from slider to platform for a picture, base frame, mm.

    The kinematics know how far slider and platform joints are apart along x, not where: they are drawn ``SKETCH_X`` from P.
    """
    offset, radius, _base, _rod = _lengths(module)
    tilt = np.asarray(alpha)[..., None]
    platform = np.stack(
        [
            position[..., :1] + SKETCH_X * np.sign(-offset),
            position[..., 1:2] + SIDE * radius * np.cos(tilt),
            position[..., 2:] + SIDE * radius * np.sin(tilt),
        ],
        axis=-1,
    )
    return np.stack([platform - rod_vectors(module, position, alpha, rho), platform], axis=-2)


def rod_residuals(module: "VerneModule", position: Array, alpha: Array, rho: Array) -> Array:
    """Left-hand sides of (3), (4), (5), (6), shape (..., 4), mm2."""
    rod = _lengths(module)[3]
    return np.asarray((rod_vectors(module, position, alpha, rho) ** 2).sum(axis=-1) - rod**2)


def rod_jacobians(module: "VerneModule", position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
    """Derivatives of half the left-hand sides of (3) to (6).

    ``parallel @ d(x, y, z, alpha) + serial @ d(rho) = 0``.

    Returns
    -------
    parallel : ndarray, shape (..., 4, 4)
        By x, y, z (mm) and alpha (mm2/rad).
    serial : ndarray, shape (..., 4, 3)
        By the sliders, mm.
    """
    _offset, radius, _base, _rod = _lengths(module)
    d = rod_vectors(module, position, alpha, rho)
    c, s = np.cos(alpha)[..., None], np.sin(alpha)[..., None]
    turn = SIDE * radius * (d[..., 2] * c - d[..., 1] * s)
    parallel = np.concatenate([d, turn[..., None]], axis=-1)
    serial = np.zeros((*d.shape[:-1], 3))
    serial[..., np.arange(4), SLIDER] = -d[..., 2]
    return parallel, serial


def scales(module: "VerneModule") -> tuple[Array, float]:
    """What makes the Jacobians dimensionless: the rod of each equation, and the arm of the tilt, mm.

    The tilt counts by the larger arm of the platform: one unit is the distance that its outermost joint moves.
    """
    return _lengths(module)[3], max(module.R1, module.R2)


def conditioning(module: "VerneModule", position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
    """Reciprocal condition numbers of both parts, dimensionless: 1 is even in all directions, 0 is singular.

    The parallel part is the matrix that a forward step inverts; the serial one, by the sliders and alpha, is the one
    that an inverse step inverts.

    Returns
    -------
    parallel, serial : ndarray, shape (...)
    """
    parallel, serial = rod_jacobians(module, position, alpha, rho)
    rod, arm = scales(module)
    parallel = parallel / rod[:, None] / np.array([1.0, 1.0, 1.0, arm])
    serial = np.concatenate([serial / rod[:, None], parallel[..., 3:]], axis=-1)
    values = [np.linalg.svd(matrix, compute_uv=False) for matrix in (parallel, serial)]
    return values[0][..., -1] / values[0][..., 0], values[1][..., -1] / values[1][..., 0]


def parallel_determinant(module: "VerneModule", position: Array, tilt: tuple[Array, Array], drops: Array) -> Array:
    """Determinant of the scaled parallel Jacobian in the working mode, shape (...); zero at a parallel singularity.

    Rows over their rod, the column of alpha over the arm of :func:`scales`. Written out, because every pose of a
    program is judged by it: both rods of a leg pair share their x component, so the differences of rows have none.

    Parameters
    ----------
    module : VerneModule
    position : ndarray, shape (..., 3)
    tilt : tuple of 2 ndarrays, shape (...)
        Cosine and sine of alpha.
    drops : ndarray, shape (3, ...)
        Vertical drops of the legs, mm.
    """
    c, s = tilt
    offset, radius, base, _rod = _lengths(module)
    rod, arm = scales(module)
    tilts = (s * module.R1, -s * module.R1, 0.0, 0.0)
    rows = []
    for i in range(4):
        dy = position[..., 1] + SIDE[i] * (radius[i] * c - base[i])
        dz = drops[SLIDER[i]] + tilts[i]
        rows.append((dy, dz, SIDE[i] * radius[i] * (dz * c - dy * s)))
    leg1 = tuple(a - b for a, b in zip(rows[0], rows[1], strict=True))
    leg23 = tuple(a - b for a, b in zip(rows[2], rows[3], strict=True))
    x1, x2 = position[..., 0] + offset[0], position[..., 0] + offset[2]
    value = x1 * _triple(leg1, rows[2], leg23) + x2 * _triple(rows[0], leg1, leg23)
    return np.asarray(value / (float(np.prod(rod)) * arm))


def _triple(a: tuple[Array, ...], b: tuple[Array, ...], c: tuple[Array, ...]) -> Array:
    """Determinant of three rows of three columns."""
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])


@dataclass(frozen=True, eq=False)
class VerneRods:
    """The six rods where they really are; implements ``RodModule``.

    The kinematics need only D1 - d1 and D2 - d2; distances between legs need the sliders' own places.

    Attributes
    ----------
    module : VerneModule
    leg1_slider_x, leg23_slider_x : float
        d1 and d2: x of the slider's attachments, base frame, mm.
    leg23_spacing : float
        Distance of the two rods of a parallelogram. They lie along x, the only direction that a tilt about x leaves
        parallel to itself, which is why one equation stands for both.
    """

    module: "VerneModule"
    leg1_slider_x: float
    leg23_slider_x: float
    leg23_spacing: float

    rod_legs: ClassVar[tuple[str, ...]] = ("I", "I", "II", "II", "III", "III")
    parallelograms: ClassVar[tuple[str, ...]] = ("II", "III")

    @property
    def shortest_rod(self) -> float:
        """Mm."""
        return min(self.module.L1, self.module.L2, self.module.L3)

    def inverse(self, position: Array) -> tuple[Array, Array, Mask]:
        """As :meth:`VerneModule.inverse`."""
        return self.module.inverse(position)

    def rods(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Ends of the rods at slider and platform, each (n, 6, 3), base frame, mm."""
        _offset, _radius, base, _rod = _lengths(self.module)
        vectors = rod_vectors(self.module, position, alpha, rho)
        slider = np.array([self.leg1_slider_x, self.leg1_slider_x, self.leg23_slider_x, self.leg23_slider_x])
        start = np.stack(
            np.broadcast_arrays(np.broadcast_to(slider, rho[..., SLIDER].shape), SIDE * base, rho[..., SLIDER]), axis=-1
        )
        pick, aside = np.array([0, 1, 2, 2, 3, 3]), np.zeros((6, 3))
        aside[2:, 0] = 0.5 * self.leg23_spacing * np.array([-1.0, 1.0, -1.0, 1.0])
        start, vectors = start[..., pick, :] + aside, vectors[..., pick, :]
        return start, start + vectors
