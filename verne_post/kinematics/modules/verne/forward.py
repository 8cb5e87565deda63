"""Platform position of the VERNE module for slider coordinates, in the working mode: Newton on (10), (5), (6)."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.base.tolerances import NEWTON_STEP, ROD_RESIDUAL_MM2
from verne_post.kinematics.modules.verne.geometry import VerneGeometry
from verne_post.kinematics.modules.verne.rods import compute_leg_drops, compute_rod_residuals

#: Rows worked on at a time: the intermediate arrays then stay in the processor's cache.
CHUNK: Final = 4096
#: Newton steps from the middle of the workspace (rim: 8).
FORWARD_STEPS: Final = 25
#: Largest change of the tilt in one step, rad: it may not jump over the crossing of the rods, where y has a pole.
LARGEST_TILT_STEP: Final = 0.3


def solve_forward(geometry: VerneGeometry, rho: Array) -> tuple[Array, Array, Mask]:
    """Platform position for slider coordinates, in the working mode: Newton's method on (10), (5), (6).

    Equation (14) is used to write y and z by the drop w = z - rho1 of leg I,
    ``y = -w R1 sin(alpha) / (R1 cos(alpha) - r1)``, which is smooth in the working mode.
    Shapes as in ``ParallelModule.forward``; ok where the iteration reached a solution in the working mode.
    """
    flat = np.asarray(rho, dtype=float).reshape(-1, 3)
    position = np.empty((len(flat), 3))
    alpha = np.empty(len(flat))
    ok = np.empty(len(flat), dtype=bool)
    for first in range(0, len(flat), CHUNK):
        part = slice(first, first + CHUNK)
        position[part], alpha[part], ok[part] = _solve_chunk(geometry, flat[part])
    shape = np.shape(rho)[:-1]
    return position.reshape(*shape, 3), alpha.reshape(shape), ok.reshape(shape)


def _solve_chunk(geometry: VerneGeometry, rho: Array) -> tuple[Array, Array, Mask]:
    R1, r1, R2, r4 = geometry.R1, geometry.r1, geometry.R2, geometry.r4
    rho1, rho2, rho3 = rho.T
    x0, w0 = geometry.find_workspace_middle()
    x, w, a = np.full(len(rho), x0), np.full(len(rho), w0), np.zeros(len(rho))
    dx = dw = da = np.full(len(rho), np.nan)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for _ in range(FORWARD_STEPS):
            c, s = np.cos(a), np.sin(a)
            uncrossed = R1 * c - r1
            t = -R1 * s / uncrossed
            dt = -R1 * (R1 - r1 * c) / uncrossed**2
            y, dy = t * w, dt * w
            x1, x2 = x + geometry.leg1_x_offset, x + geometry.leg23_x_offset
            arm, darm = R2 * c - r4, -R2 * s
            y2, z2 = y - arm, rho1 + w - R2 * s - rho2
            y3, z3 = y + arm, rho1 + w + R2 * s - rho3
            e1 = x1**2 + y**2 + w**2 - geometry.L1**2 + R1**2 + r1**2 - 2 * R1 * r1 * c
            e2 = x2**2 + y2**2 + z2**2 - geometry.L2**2
            e3 = x2**2 + y3**2 + z3**2 - geometry.L3**2
            # halves of the partial derivatives by x, w, alpha
            j11, j12, j13 = x1, y * t + w, y * dy + R1 * r1 * s
            j21, j22, j23 = x2, y2 * t + z2, y2 * (dy - darm) - z2 * R2 * c
            j31, j32, j33 = x2, y3 * t + z3, y3 * (dy + darm) + z3 * R2 * c
            m1, m2, m3 = j22 * j33 - j23 * j32, j23 * j31 - j21 * j33, j21 * j32 - j22 * j31
            det = 2 * (j11 * m1 + j12 * m2 + j13 * m3)
            dx = (e1 * m1 + e2 * (j13 * j32 - j12 * j33) + e3 * (j12 * j23 - j13 * j22)) / det
            dw = (e1 * m2 + e2 * (j11 * j33 - j13 * j31) + e3 * (j13 * j21 - j11 * j23)) / det
            da = (e1 * m3 + e2 * (j12 * j31 - j11 * j32) + e3 * (j11 * j22 - j12 * j21)) / det
            scale = np.minimum(1.0, LARGEST_TILT_STEP / np.abs(da))
            x, w, a = x - scale * dx, w - scale * dw, a - scale * da
            if bool((np.abs(da) < NEWTON_STEP).all() and (np.abs(dx) + np.abs(dw) < NEWTON_STEP * geometry.L1).all()):
                break
        c, s = np.cos(a), np.sin(a)
        y = -w * R1 * s / (R1 * c - r1)
        position = np.stack([x, y, rho1 + w], axis=-1)
        converged = (np.abs(da) < NEWTON_STEP) & (np.abs(dx) + np.abs(dw) < NEWTON_STEP * geometry.L1)
        ok = converged & _is_in_working_mode(geometry, position, a, rho)
    position[~ok] = np.nan
    a[~ok] = np.nan
    return position, a, ok


def _is_in_working_mode(geometry: VerneGeometry, position: Array, alpha: Array, rho: Array) -> Mask:
    """Rods closed, uncrossed, and every slider attachment above the platform's."""
    above = (compute_leg_drops(geometry, position[:, 2], alpha, rho) > 0).all(axis=-1)
    scale = (geometry.L1 / 850.0) ** 2  # the residual is a length squared
    residuals = compute_rod_residuals(geometry, position, alpha, rho)
    closed = (np.abs(residuals) < ROD_RESIDUAL_MM2 * max(scale, 1.0)).all(axis=-1)
    return above & closed & (np.abs(alpha) < geometry.crossing_angle)
