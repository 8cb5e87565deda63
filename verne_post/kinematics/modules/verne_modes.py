"""Every solution of the VERNE module: working modes of a position, assembly modes of slider coordinates.

Equation numbers refer to the paper, as in :mod:`verne_post.kinematics.modules.verne`. One position or one set of
sliders at a time: these answer a person's question; the product's path uses the vectorised working mode.
"""

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from verne_post.kinematics.modules.verne import VerneModule

Array = NDArray[np.float64]

#: Residual of the rod equations that a solution must reach, over the square of a rod: 1e-9 mm on a rod of 950.
CLOSED: Final = 2e-12
#: Two poses closer than this (over a rod; alpha in rad) are one: far above rounding, far below any two modes.
SAME_POSE: Final = 1e-7
#: Roots may leave the unit circle by this: a double root splits by the root of machine epsilon, and candidates are
#: polished and judged by their residual anyway.
NEAR_CIRCLE: Final = 1e-3
POLISH_STEPS: Final = 40


@dataclass(frozen=True)
class InverseSolution:
    """One inverse solution: lean (rad), configuration indices s1, s2, s3, sliders (mm).

    ``refused`` is None for the one that the machine uses, else the reason by geometry.
    """

    alpha: float
    signs: tuple[int, int, int]
    rho: tuple[float, float, float]
    refused: str | None


@dataclass(frozen=True)
class ForwardSolution:
    """One assembly mode: position of P (mm), lean (rad), and why it is refused (None for the one in use)."""

    position: tuple[float, float, float]
    alpha: float
    refused: str | None


def refusal(module: "VerneModule", alpha: float, drops: tuple[float, float, float]) -> str | None:
    """Why a solution is not the machine's: crossed rods, or an attachment below the platform's."""
    reasons = []
    if module.R1 * np.cos(alpha) <= module.r1:
        reasons.append("rod crossing: R1 cos(alpha) <= r1")
    for name, drop in zip(module.actuators, drops, strict=True):
        if drop <= 0:
            reasons.append(f"attachment of {name} not above the platform's")
    return "; ".join(reasons) or None


# --- inverse ------------------------------------------------------------------------------------


def inverse_all(module: "VerneModule", position: Array) -> list[InverseSolution]:
    """All real inverse solutions of one platform position: at most 16 (Fig. 6).

    Parameters
    ----------
    position : ndarray, shape (3,)
        P in the base frame, mm.
    """
    x, y, z = (float(value) for value in np.asarray(position, dtype=float))
    found = []
    for alpha, s1 in _leans(module, x, y):
        c, s = np.cos(alpha), np.sin(alpha)
        radicands = module._radicands(np.array(x), np.array(y), np.array(c))
        if not (radicands[1:] >= 0).all():
            continue
        drop = np.sqrt(np.maximum(radicands, 0.0))
        for s2, s3 in product((-1, 1), repeat=2):
            lean = module.R2 * s
            rho = (float(z + s1 * drop[0]), float(z - lean + s2 * drop[1]), float(z + lean + s3 * drop[2]))
            reason = refusal(module, alpha, (-s1 * drop[0], -s2 * drop[1], -s3 * drop[2]))
            found.append(InverseSolution(float(alpha), (s1, s2, s3), rho, reason))
    return sorted(found, key=lambda one: (one.refused is not None, one.alpha, one.signs))


def orientations(module: "VerneModule", position: Array) -> list[float]:
    """All lean angles of the platform at a position: equation (9), Table I. rad, ascending."""
    x, y, _z = (float(value) for value in np.asarray(position, dtype=float))
    return sorted({alpha for alpha, _s1 in _leans(module, x, y)})


def iso_alpha_ellipse(module: "VerneModule", alpha: float, turn: Array) -> Array:
    """Where P may stand so that the platform leans by alpha: the ellipse of equation (8), Fig. 5.

    With ``arm2 = R1^2 + r1^2 - 2 R1 r1 cos(alpha)`` (7) reads
    ``(R1 sin)^2 (x + D1 - d1)^2 + arm2 y^2 = (R1 sin)^2 (L1^2 - arm2)``, hence the semi-axes
    ``a = sqrt(L1^2 - arm2)`` and ``b = a R1 |sin(alpha)| / sqrt(arm2)``. By (14) the working mode (rho1 above z_P,
    uncrossed rods) leans by +alpha on the half y < 0 and by -alpha on the half y > 0.
    For alpha = 0 or pi the ellipse is the segment y = 0.

    Parameters
    ----------
    alpha : float
        rad; +alpha and -alpha have the same ellipse.
    turn : ndarray, shape (n,)
        Where on the ellipse: 0 is its end at largest x, pi / 2 the end of the y axis, rad.

    Returns
    -------
    ndarray, shape (n, 2)
        x and y of P, base frame, mm. Independent of z. NaN where leg I is too short to lean so far anywhere.
    """
    arm2 = module.R1**2 + module.r1**2 - 2 * module.R1 * module.r1 * np.cos(alpha)
    radicand = module.L1**2 - arm2
    a = np.sqrt(radicand) if radicand >= 0 else np.nan
    b = a * abs(module.R1 * np.sin(alpha)) / np.sqrt(arm2)
    return np.stack([a * np.cos(turn) - module.leg1_x_offset, b * np.sin(turn)], axis=-1)


def _leans(module: "VerneModule", x: float, y: float) -> list[tuple[float, int]]:
    """Lean angles with the side s1 of leg I (Tables I and II)."""
    x1 = x + module.leg1_x_offset
    if y == 0.0:  # sin(alpha)^2 times the radicand of (11) vanishes
        found = [(alpha, s1) for alpha in (0.0, np.pi) if _radicand1(module, x1, y, alpha) >= 0 for s1 in (-1, 1)]
        cosine = (module.R1**2 + module.r1**2 - module.L1**2 + x1**2) / (2 * module.R1 * module.r1)
        if abs(cosine) < 1:
            found += [(sign * float(np.arccos(cosine)), -1) for sign in (-1.0, 1.0)]
        return found
    found = []
    for rough in module._orientation_roots(x1, y, 0.0, 0.0, NEAR_CIRCLE):
        for s1 in (-1, 1):
            alpha = _polished_lean(module, x1, y, float(rough), s1)
            if alpha is not None and all(abs(alpha - other) > SAME_POSE or s1 != t for other, t in found):
                found.append((alpha, s1))
    return found


def _radicand1(module: "VerneModule", x1: float, y: float, alpha: float) -> float:
    arm = module.R1**2 + module.r1**2 - 2 * module.R1 * module.r1 * np.cos(alpha)
    return float(module.L1**2 - arm - x1**2 - y**2)


def _polished_lean(module: "VerneModule", x1: float, y: float, alpha: float, s1: int) -> float | None:
    """Newton on (14) with leg I on side s1: ``y (R1 cos - r1) = s1 R1 sin sqrt(M)``; None where it does not hold."""
    scale = module.L1**2
    for _ in range(POLISH_STEPS):
        c, s = np.cos(alpha), np.sin(alpha)
        radicand = _radicand1(module, x1, y, alpha)
        if radicand <= 0:
            return None
        root = np.sqrt(radicand)
        f = y * (module.R1 * c - module.r1) - s1 * module.R1 * s * root
        slope = -y * module.R1 * s - s1 * module.R1 * (c * root - s * module.R1 * module.r1 * s / root)
        step = f / slope if slope else 0.0
        if abs(step) > 0.1:
            return None  # this root belongs to the other side
        alpha -= step
        if abs(step) < 1e-15:
            break
    residual = y * (module.R1 * np.cos(alpha) - module.r1) - s1 * module.R1 * np.sin(alpha) * np.sqrt(
        max(_radicand1(module, x1, y, alpha), 0.0)
    )
    return float((alpha + np.pi) % (2 * np.pi) - np.pi) if abs(residual) < CLOSED * scale else None


# --- forward ------------------------------------------------------------------------------------


def forward_all(module: "VerneModule", rho: Array) -> list[ForwardSolution]:
    """All real assembly modes of one set of slider coordinates.

    With y and z written by ``w`` (y = R1 sin w, z - rho1 = -D w, D = R1 cos - r1, which is (14)), the difference of (5)
    and (6) gives w, that of (10) and (5) gives x, and (10) becomes a trigonometric polynomial of degree four in alpha;
    its roots are eigenvalues of a companion matrix. Where the denominator E of w vanishes, (21), w follows from
    (10) itself as a quadratic. Every candidate is polished on (3) to (6) and kept only if the rods close.

    Parameters
    ----------
    rho : ndarray, shape (3,)
        mm.
    """
    sliders = np.asarray(rho, dtype=float)
    n = 17  # twice what degree four needs: rounding averages out
    angles = 2 * np.pi * np.arange(n) / n
    values = np.array([_characteristic(module, sliders, alpha) for alpha in angles])
    coefficients = np.fft.fft(values) / n
    ordered = coefficients[[4, 3, 2, 1, 0, -1, -2, -3, -4]]
    roots = np.roots(ordered)
    candidates = [float(np.angle(root)) for root in roots if abs(abs(root) - 1) < 0.1]
    starts = [(alpha, w) for alpha in candidates for w in _drops(module, sliders, alpha)]
    starts += [(alpha, w) for alpha in _vanishing(module, sliders) for w in _quadratic(module, sliders, alpha)]
    found: list[ForwardSolution] = []
    for alpha, w in starts:
        pose = _polished_pose(module, sliders, alpha, w)
        if pose is None or any(_same(module, pose, other) for other in found):
            continue
        x, y, z, lean = pose
        offset = module.R2 * np.sin(lean)
        drops = (z - sliders[0], z - offset - sliders[1], z + offset - sliders[2])
        found.append(ForwardSolution((x, y, z), lean, refusal(module, lean, drops)))
    return sorted(found, key=lambda one: (one.refused is not None, one.alpha))


def _linear(module: "VerneModule", rho: Array, alpha: float) -> tuple[float, float, float, float, float, float]:
    """N and E with w = N / (2 E); x + D1 - d1 = p + q w; K of (10); and the square (R1 sin)^2 + D^2."""
    c, s = np.cos(alpha), np.sin(alpha)
    d_arm, m, n = module.R1 * c - module.r1, module.R2 * c - module.r4, module.R2 * s
    k = rho[2] - rho[1] - 2 * n
    numerator = k * (2 * rho[0] - rho[1] - rho[2]) - (module.L2**2 - module.L3**2)
    e = (rho[2] - rho[1]) * d_arm + 2 * s * (module.R2 * module.r1 - module.R1 * module.r4)
    big_k = module.L1**2 - (module.R1**2 + module.r1**2 - 2 * module.R1 * module.r1 * c)
    d, g = module.leg1_x_offset - module.leg23_x_offset, rho[0] - n - rho[1]
    p = d / 2 + (big_k - module.L2**2 + m**2 + g**2) / (2 * d)
    q = (-2 * module.R1 * s * m - 2 * d_arm * g) / (2 * d)
    return float(numerator), float(e), float(p), float(q), float(big_k), float((module.R1 * s) ** 2 + d_arm**2)


def _characteristic(module: "VerneModule", rho: Array, alpha: float) -> float:
    """Equation (10) times (2 E)^2, a trigonometric polynomial of degree four."""
    numerator, e, p, q, big_k, square = _linear(module, rho, alpha)
    return (2 * e * p + q * numerator) ** 2 + numerator**2 * square - 4 * e**2 * big_k


def _drops(module: "VerneModule", rho: Array, alpha: float) -> list[float]:
    numerator, e, *_rest = _linear(module, rho, alpha)
    exact = [numerator / (2 * e)] if e else []
    return [*exact, *_quadratic(module, rho, alpha)]


def _vanishing(module: "VerneModule", rho: Array) -> list[float]:
    """The two alpha at which E vanishes: E = a cos + b sin + c."""
    a = (rho[2] - rho[1]) * module.R1
    b = 2 * (module.R2 * module.r1 - module.R1 * module.r4)
    c = -(rho[2] - rho[1]) * module.r1
    size = float(np.hypot(a, b))
    if size == 0 or abs(c) > size:
        return []
    middle, half = float(np.arctan2(b, a)), float(np.arccos(-c / size))
    return [middle + half, middle - half]


def _quadratic(module: "VerneModule", rho: Array, alpha: float) -> list[float]:
    """W from (10) alone, with x by (10) minus (5)."""
    _numerator, _e, p, q, big_k, square = _linear(module, rho, alpha)
    a, b, c = q**2 + square, p * q, p**2 - big_k
    root = np.sqrt(max(b**2 - a * c, 0.0))
    return [float((-b + root) / a), float((-b - root) / a)] if a else []


def _polished_pose(
    module: "VerneModule", rho: Array, alpha: float, w: float
) -> tuple[float, float, float, float] | None:
    """Newton on the rod equations (3) to (6) in (x, y, z, alpha)."""
    _n, _e, p, q, _k, _square = _linear(module, rho, alpha)
    d_arm = module.R1 * np.cos(alpha) - module.r1
    pose = np.array([p + q * w - module.leg1_x_offset, module.R1 * np.sin(alpha) * w, rho[0] - d_arm * w, alpha])
    for _ in range(POLISH_STEPS):
        residual, slope = _rods(module, rho, pose)
        try:
            step = np.linalg.solve(slope, residual)
        except np.linalg.LinAlgError:
            return None
        largest = float(np.abs(step / [module.L1, module.L1, module.L1, 1.0]).max())
        if not np.isfinite(largest) or largest > 1.0:
            return None
        pose = pose - step
        if largest < 1e-15:
            break
    residual, _slope = _rods(module, rho, pose)
    if float(np.abs(residual).max()) > CLOSED * module.L1**2:
        return None
    x, y, z, lean = (float(value) for value in pose)
    return x, y, z, float((lean + np.pi) % (2 * np.pi) - np.pi)


def _rods(module: "VerneModule", rho: Array, pose: Array) -> tuple[Array, Array]:
    """Residuals of (3) to (6) and their derivatives by x, y, z, alpha."""
    x, y, z, alpha = pose
    c, s = np.cos(alpha), np.sin(alpha)
    rows, residuals = [], []
    legs = (
        (module.leg1_x_offset, module.R1, module.r1, 1.0, rho[0], module.L1),
        (module.leg1_x_offset, module.R1, module.r1, -1.0, rho[0], module.L1),
        (module.leg23_x_offset, module.R2, module.r4, -1.0, rho[1], module.L2),
        (module.leg23_x_offset, module.R2, module.r4, 1.0, rho[2], module.L3),
    )
    for offset, radius, base, sign, slider, rod in legs:
        dx, dy = x + offset, y + sign * (radius * c - base)
        dz = z + sign * radius * s - slider
        residuals.append(dx**2 + dy**2 + dz**2 - rod**2)
        rows.append([2 * dx, 2 * dy, 2 * dz, 2 * sign * radius * (dz * c - dy * s)])
    return np.array(residuals), np.array(rows)


def _same(module: "VerneModule", pose: tuple[float, float, float, float], other: ForwardSolution) -> bool:
    apart = np.abs(np.array(pose[:3]) - other.position).max() / module.L1
    turn = abs((pose[3] - other.alpha + np.pi) % (2 * np.pi) - np.pi)
    return bool(apart < SAME_POSE and turn < SAME_POSE)
