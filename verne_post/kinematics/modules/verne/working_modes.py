"""Working modes of the VERNE module: every inverse solution of one platform position.

Equation numbers as in :mod:`verne_post.kinematics.modules.verne.geometry`. They answer a person's question, one
position at a time.
"""

from itertools import product
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.kinematics.modules.verne.geometry import VerneGeometry
from verne_post.kinematics.modules.verne.inverse import PointOfTilt, find_tilts, place_coupled_point, place_fixed_point
from verne_post.kinematics.modules.verne.rods import CLOSED, POLISH_STEPS, POLISHED, refuse_mode
from verne_post.model.protocols import InverseSolution

#: Two tilts closer than this (rad) are one: far above rounding, far below any two modes.
SAME_TILT: Final = 1e-7
#: Roots may leave the unit circle by this: a double root splits by the root of machine epsilon. Candidates are
#: polished and checked by their residual anyway.
NEAR_CIRCLE: Final = 1e-3
#: A Newton step larger than this (rad) means that the root belongs to the other side of leg I.
OTHER_SIDE: Final = 0.1


def inverse_all(geometry: VerneGeometry, position: Array) -> list[InverseSolution]:
    """All real inverse solutions of one platform position: at most 16 (Fig. 6).

    Parameters
    ----------
    position : ndarray, shape (3,)
        P in the base frame, mm.
    """
    return _solve_all(geometry, place_fixed_point(np.asarray(position, dtype=float)[None]).select(0))


def solve_coupled_all(geometry: VerneGeometry, pivot: Array, gauge: Array) -> list[InverseSolution]:
    """All real solutions for a platform point that turns with the tilt: six tilts at most, each with its postures.

    Parameters
    ----------
    pivot : ndarray, shape (3,)
        Base frame, mm.
    gauge : ndarray, shape (3,)
        Upright frame at alpha = 0, mm; the platform point is ``pivot + F Rx(alpha) gauge``.
    """
    return _solve_all(geometry, place_coupled_point(pivot, np.asarray(gauge, dtype=float)[None]).select(0))


def _solve_all(geometry: VerneGeometry, point: PointOfTilt) -> list[InverseSolution]:
    """All inverse solutions of one point, the one in use first."""
    solutions = []
    for alpha, s1 in _find_tilts_and_sides(geometry, point):
        c, s = np.cos(alpha), np.sin(alpha)
        z = point.find_z(c, s)
        radicands = geometry.find_radicands(point.x, point.find_y(c, s), c)
        if not (radicands[1:] >= 0).all():
            continue
        drop = np.sqrt(np.maximum(radicands, 0.0))
        for s2, s3 in product((-1, 1), repeat=2):
            tilt = geometry.R2 * s
            rho = (float(z + s1 * drop[0]), float(z - tilt + s2 * drop[1]), float(z + tilt + s3 * drop[2]))
            reason = refuse_mode(geometry, alpha, (-s1 * drop[0], -s2 * drop[1], -s3 * drop[2]))
            solutions.append(InverseSolution(float(alpha), (s1, s2, s3), rho, reason))
    return sorted(solutions, key=lambda one: (one.refused is not None, one.alpha, one.signs))


def trace_iso_alpha(geometry: VerneGeometry, alpha: float, turn: Array) -> Array:
    """Where P may stand so that the platform tilts by alpha: the ellipse of equation (8), Fig. 5.

    With ``arm2 = R1^2 + r1^2 - 2 R1 r1 cos(alpha)`` (7) reads
    ``(R1 sin)^2 (x + D1 - d1)^2 + arm2 y^2 = (R1 sin)^2 (L1^2 - arm2)``, hence the semi-axes
    ``a = sqrt(L1^2 - arm2)`` and ``b = a R1 |sin(alpha)| / sqrt(arm2)``. By (14) the working mode (rho1 above z_P,
    uncrossed rods) tilts by +alpha on the half y < 0 and by -alpha on the half y > 0.
    For alpha = 0 or pi the ellipse is the line y = 0.

    Parameters
    ----------
    alpha : float
        rad; +alpha and -alpha have the same ellipse.
    turn : ndarray, shape (n,)
        Where on the ellipse: 0 is its end at largest x, pi / 2 the end of the y axis, rad.

    Returns
    -------
    ndarray, shape (n, 2)
        x and y of P, base frame, mm. Independent of z. NaN where leg I is too short to tilt so far anywhere.
    """
    arm2 = geometry.R1**2 + geometry.r1**2 - 2 * geometry.R1 * geometry.r1 * np.cos(alpha)
    radicand = geometry.L1**2 - arm2
    a = np.sqrt(radicand) if radicand >= 0 else np.nan
    b = a * abs(geometry.R1 * np.sin(alpha)) / np.sqrt(arm2)
    return np.stack([a * np.cos(turn) - geometry.leg1_x_offset, b * np.sin(turn)], axis=-1)


def _find_tilts_and_sides(geometry: VerneGeometry, point: PointOfTilt) -> list[tuple[float, int]]:
    """Tilts with the side s1 of leg I (Tables I and II)."""
    tilts: list[tuple[float, int]] = []
    if point.y0 == point.yc == point.ys == 0.0:  # sin(alpha)^2 times the radicand of (11) vanishes
        x1 = float(point.x + geometry.leg1_x_offset)
        tilts += [(a, s1) for a in (0.0, np.pi) if _compute_leg1_radicand(geometry, x1, 0.0, a) >= 0 for s1 in (-1, 1)]
        cosine = (geometry.R1**2 + geometry.r1**2 - geometry.L1**2 + x1**2) / (2 * geometry.R1 * geometry.r1)
        if abs(cosine) < 1:
            tilts += [(sign * float(np.arccos(cosine)), -1) for sign in (-1.0, 1.0)]
        return tilts
    (found,) = find_tilts(geometry, point, NEAR_CIRCLE)
    for rough in found[np.isfinite(found)]:
        for s1 in (-1, 1):
            alpha = _polish_tilt(geometry, point, float(rough), s1)
            if alpha is not None and all(abs(alpha - other) > SAME_TILT or s1 != t for other, t in tilts):
                tilts.append((alpha, s1))
    return tilts


def _compute_leg1_radicand(geometry: VerneGeometry, x1: float, y: float, alpha: float) -> float:
    """Radicand of (11), mm2."""
    arm2 = geometry.R1**2 + geometry.r1**2 - 2 * geometry.R1 * geometry.r1 * np.cos(alpha)
    return float(geometry.L1**2 - arm2 - x1**2 - y**2)


def _polish_tilt(geometry: VerneGeometry, point: PointOfTilt, alpha: float, s1: int) -> float | None:
    """Newton's method on (14) with leg I on side s1: ``y (R1 cos - r1) = s1 R1 sin sqrt(M)``; None where it fails."""
    R1, r1 = geometry.R1, geometry.r1
    x1, yc, ys = (float(value) for value in (point.x + geometry.leg1_x_offset, point.yc, point.ys))
    for last in range(POLISH_STEPS + 1):
        c, s = np.cos(alpha), np.sin(alpha)
        y = float(point.find_y(c, s))
        radicand = _compute_leg1_radicand(geometry, x1, y, alpha)
        if radicand <= 0:
            return None
        root = np.sqrt(radicand)
        f = y * (R1 * c - r1) - s1 * R1 * s * root
        if last == POLISH_STEPS:
            break
        dy = ys * c - yc * s
        slope = dy * (R1 * c - r1) - y * R1 * s - s1 * R1 * (c * root - s * (R1 * r1 * s + y * dy) / root)
        step = f / slope if slope else 0.0
        if abs(step) > OTHER_SIDE:
            return None
        alpha -= step
        if abs(step) < POLISHED:
            break
    closed = abs(f) < CLOSED * geometry.L1**2
    return float((alpha + np.pi) % (2 * np.pi) - np.pi) if closed else None
