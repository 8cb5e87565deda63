"""Assembly modes of the VERNE module: every platform position for the same slider coordinates.

Equation numbers as in :mod:`verne_post.kinematics.modules.verne.geometry`.
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.ragged import number_parts
from verne_post.kinematics.modules.solutions import make_triple
from verne_post.kinematics.modules.verne.geometry import VerneGeometry
from verne_post.kinematics.modules.verne.rods import (
    CLOSED,
    POLISH_STEPS,
    POLISHED,
    compute_leg_drops,
    compute_rod_jacobians,
    compute_rod_residuals,
    refuse_mode,
)
from verne_post.model.protocols import ForwardSolution

#: Two poses closer than this (over a rod; alpha in rad) are one: far above rounding, far below any two modes.
SAME_POSE: Final = 1e-7
#: Roots may leave the unit circle by this, because E near zero costs the eigenvalues most of their digits. Candidates
#: are polished and checked by their residual anyway.
NEAR_CIRCLE: Final = 0.1
#: A candidate whose rods miss by more than this share of a rod squared does not belong to its alpha.
HOPELESS: Final = 0.5
#: A leading coefficient of the characteristic polynomial smaller than this (relative) is raised to it: two roots then
#: lie far from the unit circle instead of at infinity.
LEADING: Final = 1e-13
#: Sets of slider coordinates worked on at a time.
CHUNK: Final = 1024


class ForwardModes(Struct, frozen=True, eq=False):
    """All real assembly modes of many slider coordinates; k is the largest count, the rest is NaN and False."""

    position: Array  #: (n, k, 3): P in the base frame, mm.
    alpha: Array  #: (n, k): rad, ascending.
    working: Mask  #: (n, k): In the working mode.

    @property
    def count(self) -> Ints:
        """Number of modes of each row."""
        return np.asarray(np.isfinite(self.alpha).sum(axis=1))


def find_forward_modes(geometry: VerneGeometry, rho: Array) -> ForwardModes:
    """All real assembly modes of many sets of slider coordinates.

    With y and z written by ``w`` (y = R1 sin w, z - rho1 = -D w, D = R1 cos - r1, which is (14)), the difference of (5)
    and (6) gives w, that of (10) and (5) gives x, and (10) becomes a trigonometric polynomial of degree four in alpha;
    its roots are eigenvalues of a companion matrix. Where the denominator E of w vanishes, (21), w follows from
    (10) itself as a quadratic. Every candidate is polished on (3) to (6) and kept only if the rods close.

    Parameters
    ----------
    rho : ndarray, shape (n, 3)
        mm.
    """
    rho = np.asarray(rho, dtype=float).reshape(-1, 3)
    parts = [_find_modes(geometry, rho[first : first + CHUNK]) for first in range(0, max(len(rho), 1), CHUNK)]
    k = max(part.alpha.shape[1] for part in parts)

    def join(arrays: list[Array], fill: float) -> Array:
        return np.concatenate(
            [
                np.concatenate([a, np.full((len(a), k - a.shape[1], *a.shape[2:]), fill, dtype=a.dtype)], axis=1)
                for a in arrays
            ]
        )

    return ForwardModes(
        join([part.position for part in parts], np.nan),
        join([part.alpha for part in parts], np.nan),
        join([part.working for part in parts], False).astype(bool),  # type: ignore[misc]
    )


def forward_all(geometry: VerneGeometry, rho: Array) -> list[ForwardSolution]:
    """All real assembly modes of slider coordinates (3,), mm, and why each is refused: Fig. 7, Table III."""
    sliders = np.asarray(rho, dtype=float)
    modes = find_forward_modes(geometry, sliders[None])
    solutions = []
    for position, alpha in zip(modes.position[0], modes.alpha[0].tolist(), strict=True):
        drops = compute_leg_drops(geometry, position[2], alpha, sliders)
        solutions.append(ForwardSolution(make_triple(position), alpha, refuse_mode(geometry, alpha, drops)))
    return sorted(solutions, key=lambda one: (one.refused is not None, one.alpha))


def _find_modes(geometry: VerneGeometry, rho: Array) -> ForwardModes:
    """:func:`find_forward_modes` of one chunk."""
    roots = _find_tilts(geometry, rho)
    special = _find_tilts_without_difference(geometry, rho)
    alpha = np.concatenate([roots, roots, roots, special, special], axis=1)
    column = rho[:, None, :]
    lower, upper = (
        _solve_w_of_quadratic(geometry, column, np.concatenate([roots, special], axis=1), sign) for sign in (-1.0, 1.0)
    )
    k = roots.shape[1]
    w = np.concatenate(
        [_compute_w_of_difference(geometry, column, roots), lower[:, :k], upper[:, :k], lower[:, k:], upper[:, k:]],
        axis=1,
    )
    row, which = np.nonzero(np.isfinite(alpha) & np.isfinite(w))
    pose = _polish(geometry, rho[row], alpha[row, which], w[row, which])
    closed = np.flatnonzero(np.isfinite(pose[:, 3]))
    return _keep_distinct(geometry, rho, row[closed], pose[closed])


def _compute_linear_terms(
    geometry: VerneGeometry, rho: Array, alpha: Array
) -> tuple[Array, Array, Array, Array, Array, Array]:
    """N and E with w = N / (2 E); x + D1 - d1 = p + q w; K of (10); and the square (R1 sin)^2 + D^2."""
    rho1, rho2, rho3 = rho[..., 0], rho[..., 1], rho[..., 2]
    c, s = np.cos(alpha), np.sin(alpha)
    d_arm, m, n = geometry.R1 * c - geometry.r1, geometry.R2 * c - geometry.r4, geometry.R2 * s
    k = rho3 - rho2 - 2 * n
    numerator = k * (2 * rho1 - rho2 - rho3) - (geometry.L2**2 - geometry.L3**2)
    e = (rho3 - rho2) * d_arm + 2 * s * (geometry.R2 * geometry.r1 - geometry.R1 * geometry.r4)
    big_k = geometry.L1**2 - (geometry.R1**2 + geometry.r1**2 - 2 * geometry.R1 * geometry.r1 * c)
    d, g = geometry.leg1_x_offset - geometry.leg23_x_offset, rho1 - n - rho2
    p = d / 2 + (big_k - geometry.L2**2 + m**2 + g**2) / (2 * d)
    q = (-2 * geometry.R1 * s * m - 2 * d_arm * g) / (2 * d)
    return numerator, e, p, q, big_k, (geometry.R1 * s) ** 2 + d_arm**2


def _find_tilts(geometry: VerneGeometry, rho: Array) -> Array:
    """Roots near the unit circle of (10) times (2 E)^2, a trigonometric polynomial of degree four: (n, 8), else NaN."""
    samples = 17  # twice what degree four needs: rounding averages out
    angles = 2 * np.pi * np.arange(samples) / samples
    numerator, e, p, q, big_k, square = _compute_linear_terms(geometry, rho[:, None, :], angles)
    values = (2 * e * p + q * numerator) ** 2 + numerator**2 * square - 4 * e**2 * big_k
    coefficients = np.fft.fft(values, axis=1)[:, [4, 3, 2, 1, 0, -1, -2, -3, -4]]
    size = np.abs(coefficients).max(axis=1)
    leading = coefficients[:, 0]
    floor = np.where(size > 0, LEADING * size, 1.0)
    leading = np.where(np.abs(leading) < floor, floor, leading)
    companion = np.zeros((len(rho), 8, 8), dtype=complex)
    companion[:, np.arange(1, 8), np.arange(7)] = 1.0
    companion[:, 0] = -coefficients[:, 1:] / leading[:, None]
    roots = np.linalg.eigvals(companion)
    return np.where(np.abs(np.abs(roots) - 1) < NEAR_CIRCLE, np.angle(roots), np.nan)


def _compute_w_of_difference(geometry: VerneGeometry, rho: Array, alpha: Array) -> Array:
    """W by the difference of (5) and (6), NaN where E is zero."""
    numerator, e, *_rest = _compute_linear_terms(geometry, rho, alpha)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(e != 0, numerator / (2 * e), np.nan)


def _find_tilts_without_difference(geometry: VerneGeometry, rho: Array) -> Array:
    """The alpha at which E = a cos + b sin + c vanishes: (n, 2), NaN where there is none."""
    apart = rho[:, 2] - rho[:, 1]
    a, c = apart * geometry.R1, -apart * geometry.r1
    b = 2 * (geometry.R2 * geometry.r1 - geometry.R1 * geometry.r4)
    size = np.hypot(a, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        half = np.arccos(np.where(np.abs(c) <= size, -c / size, np.nan))
    middle = np.arctan2(b, a)
    return np.stack([middle + half, middle - half], axis=1)


def _solve_w_of_quadratic(geometry: VerneGeometry, rho: Array, alpha: Array, sign: float) -> Array:
    """W from (10) alone, with x by (10) minus (5); the real part of a root that is not real."""
    _numerator, _e, p, q, big_k, square = _compute_linear_terms(geometry, rho, alpha)
    a, b, c = q**2 + square, p * q, p**2 - big_k
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((-b + sign * np.sqrt(np.maximum(b**2 - a * c, 0.0))) / a)


def _polish(geometry: VerneGeometry, rho: Array, alpha: Array, w: Array) -> Array:
    """Newton on the rod equations (3) to (6) in (x, y, z, alpha): poses (m, 4), NaN where the rods do not close."""
    _n, _e, p, q, _k, _square = _compute_linear_terms(geometry, rho, alpha)
    d_arm = geometry.R1 * np.cos(alpha) - geometry.r1
    pose = np.stack(
        [p + q * w - geometry.leg1_x_offset, geometry.R1 * np.sin(alpha) * w, rho[:, 0] - d_arm * w, alpha], axis=-1
    )
    scale = np.array([geometry.L1, geometry.L1, geometry.L1, 1.0])
    miss = np.abs(compute_rod_residuals(geometry, pose[:, :3], pose[:, 3], rho)).max(axis=1)
    active = np.flatnonzero(miss < HOPELESS * geometry.L1**2)
    for _ in range(POLISH_STEPS):
        if not len(active):
            break
        now = pose[active]
        residual = compute_rod_residuals(geometry, now[:, :3], now[:, 3], rho[active])
        slope = compute_rod_jacobians(geometry, now[:, :3], now[:, 3], rho[active])[0] * scale
        singular = np.linalg.det(slope) == 0.0
        slope[singular] = np.eye(4)
        step = np.linalg.solve(slope, 0.5 * residual[..., None])[..., 0]
        largest = np.abs(step).max(axis=1)
        alive = ~singular & (largest < 1.0)  # also false for NaN
        pose[active[alive]] = (now - step * scale)[alive]
        active = active[alive & (largest >= POLISHED)]
    miss = np.abs(compute_rod_residuals(geometry, pose[:, :3], pose[:, 3], rho)).max(axis=1)
    pose[~(miss < CLOSED * geometry.L1**2)] = np.nan
    pose[:, 3] = (pose[:, 3] + np.pi) % (2 * np.pi) - np.pi
    return pose


def _keep_distinct(geometry: VerneGeometry, rho: Array, row: Ints, pose: Array) -> ForwardModes:
    """Poses (m, 4) of rows (m,) without repetition, each row's by ascending alpha."""
    order = np.lexsort((pose[:, 3], row))
    row, pose = row[order], pose[order]
    n = len(rho)
    count = np.bincount(row, minlength=n)
    k = max(int(count.max(initial=0)), 1)
    _row, place = number_parts(count)
    table = np.full((n, k, 4), np.nan)
    table[row, place] = pose
    apart = np.abs(table[:, :, None, :3] - table[:, None, :, :3]).max(axis=-1) / geometry.L1
    turn = np.abs((table[:, :, None, 3] - table[:, None, :, 3] + np.pi) % (2 * np.pi) - np.pi)
    same = (apart < SAME_POSE) & (turn < SAME_POSE)
    repeated = (same & np.tri(k, k=-1, dtype=bool)).any(axis=2)
    table[repeated] = np.nan
    table = np.take_along_axis(table, np.argsort(table[:, :, 3], axis=1)[..., None], axis=1)
    k = max(int(np.isfinite(table[:, :, 3]).sum(axis=1).max(initial=0)), 1)
    table = table[:, :k]
    position, alpha = table[..., :3], table[..., 3]
    with np.errstate(invalid="ignore"):
        working = (compute_leg_drops(geometry, position[..., 2], alpha, rho[:, None]) > 0).all(axis=-1)
        working &= geometry.R1 * np.cos(alpha) > geometry.r1
    return ForwardModes(position, alpha, working)
