"""Every solution of the VERNE module: working modes of a position, assembly modes of slider coordinates.

Equation numbers refer to the paper, as in :mod:`verne_post.kinematics.modules.verne.module`. The inverse solutions answer a
person's question, one position at a time; the assembly modes are found for whole arrays of slider coordinates.
"""

from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.ragged import ragged
from verne_post.kinematics.modules.solutions import ForwardSolution, InverseSolution
from verne_post.kinematics.modules.verne.rods import rod_jacobians, rod_residuals

if TYPE_CHECKING:
    from verne_post.kinematics.modules.verne.module import VerneModule

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Residual of the rod equations that a solution must reach, over the square of a rod: 1e-9 mm on a rod of 950.
CLOSED: Final = 2e-12
#: Two poses closer than this (over a rod; alpha in rad) are one: far above rounding, far below any two modes.
SAME_POSE: Final = 1e-7
#: Roots may leave the unit circle by this: a double root splits by the root of machine epsilon, and candidates are
#: polished and judged by their residual anyway.
NEAR_CIRCLE: Final = 1e-3
#: The same for assembly modes, where E near zero costs the eigenvalues most of their digits.
NEAR_CIRCLE_FORWARD: Final = 0.1
#: A candidate whose rods miss by more than this share of a rod squared does not belong to its alpha.
HOPELESS: Final = 0.5
#: A leading coefficient of the characteristic polynomial smaller than this (relative) is raised to it: two roots then
#: lie far from the unit circle instead of at infinity.
LEADING: Final = 1e-13
POLISH_STEPS: Final = 40
#: A Newton step below this (over a rod; alpha in rad) leaves nothing to gain.
POLISHED: Final = 1e-15
#: Sets of slider coordinates worked on at a time.
CHUNK: Final = 1024


@dataclass(frozen=True, eq=False)
class ForwardModes:
    """All real assembly modes of many slider coordinates; k is the largest count, the rest is NaN and False.

    Attributes
    ----------
    position : ndarray, shape (n, k, 3)
        P in the base frame, mm.
    alpha : ndarray, shape (n, k)
        rad, ascending.
    working : ndarray of bool, shape (n, k)
        In the working mode.
    """

    position: Array
    alpha: Array
    working: Mask

    @property
    def count(self) -> NDArray[np.intp]:
        """Number of modes of each row."""
        return np.asarray(np.isfinite(self.alpha).sum(axis=1))


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
    module : VerneModule
    position : ndarray, shape (3,)
        P in the base frame, mm.
    """
    x, y, z = (float(value) for value in np.asarray(position, dtype=float))
    return _inverse(module, x, (y, 0.0, 0.0), (z, 0.0, 0.0))


def inverse_coupled_all(module: "VerneModule", pivot: Array, gauge: Array) -> list[InverseSolution]:
    """All real solutions for a platform point that turns with the tilt: six tilts at most, each with its postures.

    Parameters
    ----------
    module : VerneModule
    pivot : ndarray, shape (3,)
        Base frame, mm.
    gauge : ndarray, shape (3,)
        Upright frame at alpha = 0, mm; the platform point is ``pivot + F Rx(alpha) gauge``.
    """
    gx, gy, gz = (float(value) for value in gauge)
    return _inverse(module, float(pivot[0]) + gx, (float(pivot[1]), -gy, gz), (float(pivot[2]), -gz, -gy))


def _inverse(
    module: "VerneModule", x: float, y_of: tuple[float, float, float], z_of: tuple[float, float, float]
) -> list[InverseSolution]:
    """Solutions where y = y_of . (1, cos alpha, sin alpha), z alike."""
    found = []
    for alpha, s1 in _leans(module, x, y_of):
        c, s = np.cos(alpha), np.sin(alpha)
        y, z = (terms[0] + terms[1] * c + terms[2] * s for terms in (y_of, z_of))
        radicands = module._radicands(np.array(x), np.array(y), np.array(c))
        if not (radicands[1:] >= 0).all():
            continue
        drop = np.sqrt(np.maximum(radicands, 0.0))
        for s2, s3 in product((-1, 1), repeat=2):
            tilt = module.R2 * s
            rho = (float(z + s1 * drop[0]), float(z - tilt + s2 * drop[1]), float(z + tilt + s3 * drop[2]))
            reason = refusal(module, alpha, (-s1 * drop[0], -s2 * drop[1], -s3 * drop[2]))
            found.append(InverseSolution(float(alpha), (s1, s2, s3), rho, reason))
    return sorted(found, key=lambda one: (one.refused is not None, one.alpha, one.signs))


def orientations(module: "VerneModule", position: Array) -> list[float]:
    """All tilt angles of the platform at a position: equation (9), Table I. rad, ascending."""
    x, y, _z = (float(value) for value in np.asarray(position, dtype=float))
    return sorted({alpha for alpha, _s1 in _leans(module, x, (y, 0.0, 0.0))})


def iso_alpha_ellipse(module: "VerneModule", alpha: float, turn: Array) -> Array:
    """Where P may stand so that the platform tilts by alpha: the ellipse of equation (8), Fig. 5.

    With ``arm2 = R1^2 + r1^2 - 2 R1 r1 cos(alpha)`` (7) reads
    ``(R1 sin)^2 (x + D1 - d1)^2 + arm2 y^2 = (R1 sin)^2 (L1^2 - arm2)``, hence the semi-axes
    ``a = sqrt(L1^2 - arm2)`` and ``b = a R1 |sin(alpha)| / sqrt(arm2)``. By (14) the working mode (rho1 above z_P,
    uncrossed rods) tilts by +alpha on the half y < 0 and by -alpha on the half y > 0.
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
        x and y of P, base frame, mm. Independent of z. NaN where leg I is too short to tilt so far anywhere.
    """
    arm2 = module.R1**2 + module.r1**2 - 2 * module.R1 * module.r1 * np.cos(alpha)
    radicand = module.L1**2 - arm2
    a = np.sqrt(radicand) if radicand >= 0 else np.nan
    b = a * abs(module.R1 * np.sin(alpha)) / np.sqrt(arm2)
    return np.stack([a * np.cos(turn) - module.leg1_x_offset, b * np.sin(turn)], axis=-1)


def _leans(module: "VerneModule", x: float, y_of: tuple[float, float, float]) -> list[tuple[float, int]]:
    """Lean angles with the side s1 of leg I (Tables I and II)."""
    x1 = x + module.leg1_x_offset
    if y_of == (0.0, 0.0, 0.0):  # sin(alpha)^2 times the radicand of (11) vanishes
        found = [(alpha, s1) for alpha in (0.0, np.pi) if _radicand1(module, x1, 0.0, alpha) >= 0 for s1 in (-1, 1)]
        cosine = (module.R1**2 + module.r1**2 - module.L1**2 + x1**2) / (2 * module.R1 * module.r1)
        if abs(cosine) < 1:
            found += [(sign * float(np.arccos(cosine)), -1) for sign in (-1.0, 1.0)]
        return found
    found = []
    for rough in module._orientation_roots(x1, *y_of, NEAR_CIRCLE):
        for s1 in (-1, 1):
            alpha = _polished_lean(module, x1, y_of, float(rough), s1)
            if alpha is not None and all(abs(alpha - other) > SAME_POSE or s1 != t for other, t in found):
                found.append((alpha, s1))
    return found


def _radicand1(module: "VerneModule", x1: float, y: float, alpha: float) -> float:
    arm = module.R1**2 + module.r1**2 - 2 * module.R1 * module.r1 * np.cos(alpha)
    return float(module.L1**2 - arm - x1**2 - y**2)


def _polished_lean(
    module: "VerneModule", x1: float, y_of: tuple[float, float, float], alpha: float, s1: int
) -> float | None:
    """Newton on (14) with leg I on side s1: ``y (R1 cos - r1) = s1 R1 sin sqrt(M)``; None where it does not hold."""
    big, small = module.R1, module.r1
    for last in range(POLISH_STEPS + 1):
        c, s = np.cos(alpha), np.sin(alpha)
        y = y_of[0] + y_of[1] * c + y_of[2] * s
        radicand = _radicand1(module, x1, y, alpha)
        if radicand <= 0:
            return None
        root = np.sqrt(radicand)
        f = y * (big * c - small) - s1 * big * s * root
        if last == POLISH_STEPS:
            break
        dy = y_of[2] * c - y_of[1] * s
        slope = dy * (big * c - small) - y * big * s - s1 * big * (c * root - s * (big * small * s + y * dy) / root)
        step = f / slope if slope else 0.0
        if abs(step) > 0.1:
            return None  # this root belongs to the other side
        alpha -= step
        if abs(step) < POLISHED:
            break
    closed = abs(f) < CLOSED * module.L1**2
    return float((alpha + np.pi) % (2 * np.pi) - np.pi) if closed else None


# --- forward ------------------------------------------------------------------------------------


def forward_modes(module: "VerneModule", rho: Array) -> ForwardModes:
    """All real assembly modes of many sets of slider coordinates.

    With y and z written by ``w`` (y = R1 sin w, z - rho1 = -D w, D = R1 cos - r1, which is (14)), the difference of (5)
    and (6) gives w, that of (10) and (5) gives x, and (10) becomes a trigonometric polynomial of degree four in alpha;
    its roots are eigenvalues of a companion matrix. Where the denominator E of w vanishes, (21), w follows from
    (10) itself as a quadratic. Every candidate is polished on (3) to (6) and kept only if the rods close.

    Parameters
    ----------
    module : VerneModule
    rho : ndarray, shape (n, 3)
        mm.
    """
    parts = [_modes(module, rho[first : first + CHUNK]) for first in range(0, max(len(rho), 1), CHUNK)]
    k = max(part.alpha.shape[1] for part in parts)

    def joined(arrays: list[Array], fill: float) -> Array:
        return np.concatenate([
            np.concatenate([a, np.full((len(a), k - a.shape[1], *a.shape[2:]), fill, dtype=a.dtype)], axis=1)
            for a in arrays
        ])  # fmt: skip

    return ForwardModes(
        joined([part.position for part in parts], np.nan),
        joined([part.alpha for part in parts], np.nan),
        joined([part.working for part in parts], False).astype(bool),  # type: ignore[misc]
    )


def forward_all(module: "VerneModule", rho: Array) -> list[ForwardSolution]:
    """All real assembly modes of one set of slider coordinates (3,), mm, with the reason why each is refused."""
    sliders = np.asarray(rho, dtype=float)
    modes = forward_modes(module, sliders[None])
    found = []
    for position, alpha in zip(modes.position[0], modes.alpha[0].tolist(), strict=True):
        x, y, z = (float(value) for value in position)
        tilt = module.R2 * np.sin(alpha)
        drops = (z - sliders[0], z - tilt - sliders[1], z + tilt - sliders[2])
        found.append(ForwardSolution((x, y, z), alpha, refusal(module, alpha, drops)))
    return sorted(found, key=lambda one: (one.refused is not None, one.alpha))


def _modes(module: "VerneModule", rho: Array) -> ForwardModes:
    """:func:`forward_modes` of one chunk."""
    roots = _candidate_leans(module, rho)
    special = _vanishing(module, rho)
    alpha = np.concatenate([roots, roots, roots, special, special], axis=1)
    column = rho[:, None, :]
    lower, upper = (_quadratic(module, column, np.concatenate([roots, special], axis=1), sign) for sign in (-1.0, 1.0))
    k = roots.shape[1]
    w = np.concatenate([_exact(module, column, roots), lower[:, :k], upper[:, :k], lower[:, k:], upper[:, k:]], axis=1)
    row, which = np.nonzero(np.isfinite(alpha) & np.isfinite(w))
    pose = _polished(module, rho[row], alpha[row, which], w[row, which])
    closed = np.flatnonzero(np.isfinite(pose[:, 3]))
    return _distinct(module, rho, row[closed], pose[closed])


def _linear(module: "VerneModule", rho: Array, alpha: Array) -> tuple[Array, Array, Array, Array, Array, Array]:
    """N and E with w = N / (2 E); x + D1 - d1 = p + q w; K of (10); and the square (R1 sin)^2 + D^2."""
    rho1, rho2, rho3 = rho[..., 0], rho[..., 1], rho[..., 2]
    c, s = np.cos(alpha), np.sin(alpha)
    d_arm, m, n = module.R1 * c - module.r1, module.R2 * c - module.r4, module.R2 * s
    k = rho3 - rho2 - 2 * n
    numerator = k * (2 * rho1 - rho2 - rho3) - (module.L2**2 - module.L3**2)
    e = (rho3 - rho2) * d_arm + 2 * s * (module.R2 * module.r1 - module.R1 * module.r4)
    big_k = module.L1**2 - (module.R1**2 + module.r1**2 - 2 * module.R1 * module.r1 * c)
    d, g = module.leg1_x_offset - module.leg23_x_offset, rho1 - n - rho2
    p = d / 2 + (big_k - module.L2**2 + m**2 + g**2) / (2 * d)
    q = (-2 * module.R1 * s * m - 2 * d_arm * g) / (2 * d)
    return numerator, e, p, q, big_k, (module.R1 * s) ** 2 + d_arm**2


def _candidate_leans(module: "VerneModule", rho: Array) -> Array:
    """Roots near the unit circle of (10) times (2 E)^2, a trigonometric polynomial of degree four: (n, 8), else NaN."""
    samples = 17  # twice what degree four needs: rounding averages out
    angles = 2 * np.pi * np.arange(samples) / samples
    numerator, e, p, q, big_k, square = _linear(module, rho[:, None, :], angles)
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
    return np.where(np.abs(np.abs(roots) - 1) < NEAR_CIRCLE_FORWARD, np.angle(roots), np.nan)


def _exact(module: "VerneModule", rho: Array, alpha: Array) -> Array:
    """W by the difference of (5) and (6), NaN where E is zero."""
    numerator, e, *_rest = _linear(module, rho, alpha)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(e != 0, numerator / (2 * e), np.nan)


def _vanishing(module: "VerneModule", rho: Array) -> Array:
    """The alpha at which E = a cos + b sin + c vanishes: (n, 2), NaN where there is none."""
    apart = rho[:, 2] - rho[:, 1]
    a, c = apart * module.R1, -apart * module.r1
    b = 2 * (module.R2 * module.r1 - module.R1 * module.r4)
    size = np.hypot(a, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        half = np.arccos(np.where(np.abs(c) <= size, -c / size, np.nan))
    middle = np.arctan2(b, a)
    return np.stack([middle + half, middle - half], axis=1)


def _quadratic(module: "VerneModule", rho: Array, alpha: Array, sign: float) -> Array:
    """W from (10) alone, with x by (10) minus (5); the real part of a root that is not real."""
    _numerator, _e, p, q, big_k, square = _linear(module, rho, alpha)
    a, b, c = q**2 + square, p * q, p**2 - big_k
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((-b + sign * np.sqrt(np.maximum(b**2 - a * c, 0.0))) / a)


def _polished(module: "VerneModule", rho: Array, alpha: Array, w: Array) -> Array:
    """Newton on the rod equations (3) to (6) in (x, y, z, alpha): poses (m, 4), NaN where the rods do not close."""
    _n, _e, p, q, _k, _square = _linear(module, rho, alpha)
    d_arm = module.R1 * np.cos(alpha) - module.r1
    pose = np.stack(
        [p + q * w - module.leg1_x_offset, module.R1 * np.sin(alpha) * w, rho[:, 0] - d_arm * w, alpha], axis=-1
    )
    scale = np.array([module.L1, module.L1, module.L1, 1.0])
    miss = np.abs(rod_residuals(module, pose[:, :3], pose[:, 3], rho)).max(axis=1)
    active = np.flatnonzero(miss < HOPELESS * module.L1**2)
    for _ in range(POLISH_STEPS):
        if not len(active):
            break
        now = pose[active]
        residual = rod_residuals(module, now[:, :3], now[:, 3], rho[active])
        slope = rod_jacobians(module, now[:, :3], now[:, 3], rho[active])[0] * scale
        singular = np.linalg.det(slope) == 0.0
        slope[singular] = np.eye(4)
        step = np.linalg.solve(slope, 0.5 * residual[..., None])[..., 0]
        largest = np.abs(step).max(axis=1)
        alive = ~singular & (largest < 1.0)  # also false for NaN
        pose[active] = now - np.where(alive[:, None], step * scale, 0.0)
        active = active[alive & (largest >= POLISHED)]
    miss = np.abs(rod_residuals(module, pose[:, :3], pose[:, 3], rho)).max(axis=1)
    pose[~(miss < CLOSED * module.L1**2)] = np.nan
    pose[:, 3] = (pose[:, 3] + np.pi) % (2 * np.pi) - np.pi
    return pose


def _distinct(module: "VerneModule", rho: Array, row: NDArray[np.intp], pose: Array) -> ForwardModes:
    """Poses (m, 4) of rows (m,) without repetition, each row's by ascending alpha."""
    order = np.lexsort((pose[:, 3], row))
    row, pose = row[order], pose[order]
    n = len(rho)
    count = np.bincount(row, minlength=n)
    k = max(int(count.max(initial=0)), 1)
    _row, place = ragged(count)
    table = np.full((n, k, 4), np.nan)
    table[row, place] = pose
    apart = np.abs(table[:, :, None, :3] - table[:, None, :, :3]).max(axis=-1) / module.L1
    turn = np.abs((table[:, :, None, 3] - table[:, None, :, 3] + np.pi) % (2 * np.pi) - np.pi)
    same = (apart < SAME_POSE) & (turn < SAME_POSE)
    repeated = (same & np.tri(k, k=-1, dtype=bool)).any(axis=2)
    table[repeated] = np.nan
    table = np.take_along_axis(table, np.argsort(table[:, :, 3], axis=1)[..., None], axis=1)
    k = max(int(np.isfinite(table[:, :, 3]).sum(axis=1).max(initial=0)), 1)
    table = table[:, :k]
    position, alpha = table[..., :3], table[..., 3]
    tilt = module.R2 * np.sin(alpha)
    z = position[..., 2]
    with np.errstate(invalid="ignore"):
        working = (rho[:, None, 0] < z) & (rho[:, None, 1] < z - tilt) & (rho[:, None, 2] < z + tilt)
        working &= module.R1 * np.cos(alpha) > module.r1
    return ForwardModes(position, alpha, working)
