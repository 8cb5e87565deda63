"""The iterative solver that the paper sets against its closed form: Newton-Raphson on the constraint equations.

The paper's conclusion says that the controller of the real machine "resorts to an iterative Newton-Raphson resolution
of the kinematics models". This is that solver for the whole five-axis machine, written from the equations alone
(docs/theory.md, docs/conventions.md) and sharing no code with the product, so that it can serve as a yardstick and as a
second opinion.

Inverse, eight unknowns (x, y, z, alpha, rho1, rho2, rho3, A) and eight equations:

    x = pivot_x + v_x                                      v = rotary_offset + Rz(C) tip
    y - l sin(alpha) = pivot_y - (v_y cos A - v_z sin A)   the tip, seen from the platform and from the table
    z + l cos(alpha) = pivot_z - (v_y sin A + v_z cos A)   l = nose offset + tool length
    A - alpha = b                                          the tool axis: b its tilt in the part
    (3), (4), (5), (6)

C follows from the tool axis alone and is no unknown. Forward: four unknowns (x, y, z, alpha) in (3)-(6), then the
table. Equations (3) and (4) enter as half their sum and a quarter of their difference, and (5), (6) halved: that
changes no iterate. mm, rad, workpiece sense; the base frame's z points down.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from verne_post.kinematics.five_axis import HybridMachine

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
Mask = NDArray[np.bool_]
Step = Callable[[Array, Array], Array]

#: Rows worked on at a time; the arrays of a step then stay in the cache. Of 512 to 16384 this was the fastest.
CHUNK: Final = 8192
#: The same for the dense systems, which hold 64 numbers a row.
CHUNK_DENSE: Final = 1024
#: An iteration that has not ended by then has failed.
MOST_STEPS: Final = 50
#: It ends when no angle moves by more than this (rad) and no length by more than this times the rod. Convergence is
#: quadratic, so the error is then that of rounding. The product's forward solution ends at the same step.
SMALL_STEP: Final = 1e-9
#: Where an iterate has left every machine, mm over the rod: it will not come back.
LOST: Final = 1e6
#: Rods must close to this at a solution: 1e-9 mm on a rod of 950 mm.
CLOSED_MM2: Final = 2e-6
#: Converged rows are taken out of the iteration when at least this share of a chunk is done: copying costs less than a
#: step.
TAKE_OUT: Final = 0.25


@dataclass(frozen=True)
class Lengths:
    """Lengths of the module, mm: x1 = D1 - d1, x2 = D2 - d2, the others as in the paper."""

    x1: float
    R1: float
    r1: float
    L1: float
    x2: float
    R2: float
    r4: float
    L2: float
    L3: float


#: The geometry identified from the paper's Table III.
VERNE: Final = Lengths(-320.0, 130.0, 80.0, 850.0, 240.0, 190.0, 565.0, 950.0, 950.0)


@dataclass(frozen=True)
class Table:
    """Tilting rotary table and spindle: pivot in the base frame, rotary offset in the tilt frame, nose offset; mm."""

    pivot: tuple[float, float, float]
    rotary_offset: tuple[float, float, float]
    nose: float = 0.0


def numbers_of(machine: "HybridMachine") -> tuple[Lengths, Table]:
    """The numbers of a machine of the product, and nothing else of it."""
    m, table = machine.module, machine.table
    lengths = Lengths(m.leg1_x_offset, m.R1, m.r1, m.L1, m.leg23_x_offset, m.R2, m.r4, m.L2, m.L3)
    return lengths, Table(tuple(table.pivot), tuple(table.rotary_offset), machine.nose_offset)


class Solved(NamedTuple):
    """Solutions of n rows: values (NaN where not ok), ok, Newton steps taken, and whether the iteration came to rest.

    A row that came to rest but is not ok has found another solution than the working mode.
    """

    values: Array
    ok: Mask
    steps: Ints
    at_rest: Mask


# --- the iteration -----------------------------------------------------------------------------------------------


def iterate(step: Step, start: Array, data: Array, scale: Array, chunk: int) -> tuple[Array, Ints, Mask]:
    """Newton-Raphson over columns: ``u -= step(u, data)`` until each column rests.

    Parameters
    ----------
    step : callable
        Newton step of unknowns (m, k) for data (d, k); NaN where the Jacobian is singular.
    start : ndarray, shape (m, n)
    data : ndarray, shape (d, n)
    scale : ndarray, shape (m, 1)
        What counts as 1 for each unknown.
    chunk : int

    Returns
    -------
    u : ndarray, shape (m, n)
    steps : ndarray of int, shape (n,)
    at_rest : ndarray of bool, shape (n,)
    """
    n = start.shape[1]
    u_all, steps, at_rest = np.empty_like(start), np.zeros(n, dtype=int), np.zeros(n, dtype=bool)
    for first in range(0, n, chunk):
        where: Ints | slice = slice(first, min(first + chunk, n))
        u, d = start[:, where].copy(), data[:, where]
        open_ = None  # rows of the chunk that are still iterated; None stands for all
        for count in range(1, MOST_STEPS + 1):
            with np.errstate(all="ignore"):
                change = step(u, d)
                u -= change
                size = (np.abs(change) / scale).max(axis=0)
            still = size < SMALL_STEP
            over = still | ~(size < LOST)  # written so that NaN ends too
            done = int(np.count_nonzero(over))
            if done == 0 and count < MOST_STEPS:
                continue
            if done == len(over) or count == MOST_STEPS:
                rows = _rows(first, u.shape[1], open_)
                u_all[:, rows], steps[rows], at_rest[rows] = u, count, still
                break
            if done >= TAKE_OUT * len(over):
                rows = _rows(first, u.shape[1], open_)
                out = rows[over]
                u_all[:, out], steps[out], at_rest[out] = u[:, over], count, still[over]
                open_, u, d = rows[~over], u[:, ~over], d[:, ~over]
    return u_all, steps, at_rest


def _rows(first: int, n: int, open_: Ints | None) -> Ints:
    return np.arange(first, first + n) if open_ is None else open_


# --- the module alone --------------------------------------------------------------------------------------------


def rods(g: Lengths, pose: Array, rho: Array) -> Array:
    """Left-hand sides of (3), (4), (5), (6), shape (4, n), mm2, for pose (n, 4) = x, y, z, alpha and rho (n, 3)."""
    x, y, z, alpha = pose.T
    rho1, rho2, rho3 = rho.T
    c, s = np.cos(alpha), np.sin(alpha)
    return np.stack(
        [
            (x + g.x1) ** 2 + (y + g.R1 * c - g.r1) ** 2 + (z + g.R1 * s - rho1) ** 2 - g.L1**2,
            (x + g.x1) ** 2 + (y - g.R1 * c + g.r1) ** 2 + (z - g.R1 * s - rho1) ** 2 - g.L1**2,
            (x + g.x2) ** 2 + (y - g.R2 * c + g.r4) ** 2 + (z - g.R2 * s - rho2) ** 2 - g.L2**2,
            (x + g.x2) ** 2 + (y + g.R2 * c - g.r4) ** 2 + (z + g.R2 * s - rho3) ** 2 - g.L3**2,
        ]
    )


def in_working_mode(g: Lengths, pose: Array, rho: Array) -> Mask:
    """Rods closed, each slider's attachment above the platform's, rods of leg I uncrossed."""
    _x, _y, z, alpha = pose.T
    c, tilt = np.cos(alpha), g.R2 * np.sin(alpha)
    above = (rho[:, 0] < z) & (rho[:, 1] < z - tilt) & (rho[:, 2] < z + tilt)
    return above & (g.R1 * c > g.r1) & (np.abs(rods(g, pose, rho)) < CLOSED_MM2).all(axis=0)


def _forward_step(g: Lengths) -> Step:
    """Newton step of the four rod equations, eliminated by hand: x first, then a system of three by its minors."""

    def step(u: Array, rho: Array) -> Array:
        x, y, z, alpha = u
        c, s = np.cos(alpha), np.sin(alpha)
        d, e = g.R1 * c - g.r1, g.R1 * s
        x1, x2, h = x + g.x1, x + g.x2, z - rho[0]
        arm, tilt = g.R2 * c - g.r4, g.R2 * s
        y2, z2, y3, z3 = y - arm, z - tilt - rho[1], y + arm, z + tilt - rho[2]
        # (3) - (4) over 4; (3) + (4) over 4; (5) and (6) over 2: right-hand sides, then columns y, z, alpha
        fa, ja = y * d + h * e, h * (g.R1 * c) - y * e
        fb = 0.5 * (x1 * x1 + y * y + h * h + d * d + e * e - g.L1**2)
        jb = g.r1 * e
        side = x2 * x2
        fc, jc = 0.5 * (side + y2 * y2 + z2 * z2 - g.L2**2), y2 * tilt - z2 * (g.R2 * c)
        fd, jd = 0.5 * (side + y3 * y3 + z3 * z3 - g.L3**2), z3 * (g.R2 * c) - y3 * tilt
        # without x: row a; (6) - (5); x2 times row b minus x1 times row c
        p1, p2, p3, p0 = y3 - y2, z3 - z2, jd - jc, fd - fc
        q1, q2, q3, q0 = x2 * y - x1 * y2, x2 * h - x1 * z2, x2 * jb - x1 * jc, x2 * fb - x1 * fc
        m1, m2, m3 = p2 * q3 - p3 * q2, p3 * q1 - p1 * q3, p1 * q2 - p2 * q1
        over = 1.0 / (d * m1 + e * m2 + ja * m3)
        n1, n2, n3 = p0 * q3 - p3 * q0, p0 * q2 - p2 * q0, p0 * q1 - p1 * q0
        dy = (fa * m1 - e * n1 + ja * n2) * over
        dz = (d * n1 + fa * m2 - ja * n3) * over
        da = (e * n3 - d * n2 + fa * m3) * over
        rest_b, rest_c = fb - y * dy - h * dz - jb * da, fc - y2 * dy - z2 * dz - jc * da
        dx = (x1 * rest_b + x2 * rest_c) / (x1 * x1 + x2 * x2)
        return np.stack([dx, dy, dz, da])

    return step


def _forward_dense_step(g: Lengths) -> Step:
    """The same step by one general solution of a 4 x 4 system a row."""

    def step(u: Array, rho: Array) -> Array:
        x, y, z, alpha = u
        c, s = np.cos(alpha), np.sin(alpha)
        value, jacobian = np.empty((u.shape[1], 4)), np.empty((u.shape[1], 4, 4))
        for row, (offset, radius, base, sign, slider, rod) in enumerate(_legs(g)):
            dx, dy, dz = x + offset, y + sign * (radius * c - base), z + sign * radius * s - rho[slider]
            value[:, row] = dx * dx + dy * dy + dz * dz - rod**2
            jacobian[:, row, 0], jacobian[:, row, 1], jacobian[:, row, 2] = 2 * dx, 2 * dy, 2 * dz
            jacobian[:, row, 3] = 2 * sign * radius * (dz * c - dy * s)
        return _solved(jacobian, value)

    return step


def _legs(g: Lengths) -> tuple[tuple[float, float, float, float, int, float], ...]:
    """For (3) to (6): x offset, platform radius, base radius, sign of both, slider, rod."""
    return (
        (g.x1, g.R1, g.r1, 1.0, 0, g.L1),
        (g.x1, g.R1, g.r1, -1.0, 0, g.L1),
        (g.x2, g.R2, g.r4, -1.0, 1, g.L2),
        (g.x2, g.R2, g.r4, 1.0, 2, g.L3),
    )


def _solved(jacobian: Array, value: Array) -> Array:
    """Solutions (m, n) of n systems; NaN where one is singular."""
    try:
        return np.linalg.solve(jacobian, value[:, :, None])[:, :, 0].T
    except np.linalg.LinAlgError:  # one singular system stops the whole call
        jacobian, value = jacobian.copy(), value.copy()
        singular = ~(np.abs(np.linalg.det(jacobian)) > 0)
        jacobian[singular], value[singular] = np.eye(jacobian.shape[1]), np.nan
        return np.linalg.solve(jacobian, value[:, :, None])[:, :, 0].T


def centre(g: Lengths, rho: Array) -> Array:
    """Start of the forward iteration, (n, 4): the middle of the workspace, hanging below the mean of the sliders."""
    start = np.zeros((len(rho), 4))
    start[:, 0] = -0.5 * (g.x1 + g.x2)
    start[:, 2] = rho.mean(axis=1) + _middle_drops(g).mean()
    return start


def _middle_drops(g: Lengths) -> Array:
    """Vertical drops of the three legs in the middle of the workspace."""
    across = 0.5 * (g.x1 - g.x2)
    squares = [r**2 - e**2 - across**2 for r, e in ((g.L1, g.R1 - g.r1), (g.L2, g.R2 - g.r4), (g.L3, g.R2 - g.r4))]
    return np.sqrt(np.array(squares))


def forward_from(g: Lengths, rho: Array, start: Array, dense: bool = False) -> tuple[Array, Ints, Mask]:
    """Newton-Raphson on (3)-(6) from any start, whatever mode it leads to.

    Parameters
    ----------
    g : Lengths
    rho : ndarray, shape (n, 3)
    start : ndarray, shape (n, 4)
        x, y, z, alpha.
    dense : bool
        Solve a general 4 x 4 system at each step instead of the elimination by hand.

    Returns
    -------
    pose : ndarray, shape (n, 4)
    steps : ndarray of int, shape (n,)
    at_rest : ndarray of bool, shape (n,)
    """
    scale = np.array([[g.L1], [g.L1], [g.L1], [1.0]])
    step, chunk = (_forward_dense_step(g), CHUNK_DENSE) if dense else (_forward_step(g), CHUNK)
    pose, steps, at_rest = iterate(step, np.ascontiguousarray(start.T), np.ascontiguousarray(rho.T), scale, chunk)
    return pose.T, steps, at_rest


def _turns(alpha: Array) -> Array:
    """Whole turns in alpha, rad: an iteration that began badly may end any number of them away."""
    return 2 * np.pi * np.round(alpha / (2 * np.pi))


def forward(g: Lengths, rho: Array, start: Array | None = None, dense: bool = False) -> Solved:
    """Pose (n, 4) of the platform in the working mode, for rho (n, 3)."""
    pose, steps, at_rest = forward_from(g, rho, centre(g, rho) if start is None else start, dense)
    pose[:, 3] -= _turns(pose[:, 3])
    ok = at_rest & in_working_mode(g, pose, rho)
    return Solved(np.where(ok[:, None], pose, np.nan), ok, steps, at_rest)


# --- the whole machine ---------------------------------------------------------------------------------------------


def _pose_data(table: Table, tip: Array, axis: Array, tool: Array) -> tuple[Array, Array]:
    """Known numbers of each pose (5, n): X of P, v_y, v_z, b, l; and C (n,)."""
    kx, ky, kz = axis.T
    across = np.hypot(kx, ky)
    # below 1e-9 the axis is vertical to rounding and C free
    c = np.where(across > 1e-9, np.arctan2(kx, ky), 0.0)
    cosine, sine = np.cos(c), np.sin(c)
    ox, oy, oz = table.rotary_offset
    vx = ox + cosine * tip[:, 0] - sine * tip[:, 1]
    vy = oy + sine * tip[:, 0] + cosine * tip[:, 1]
    vz = oz + tip[:, 2]
    return np.stack([table.pivot[0] + vx, vy, vz, np.arctan2(across, kz), table.nose + tool]), c


def _inverse_step(g: Lengths, table: Table) -> Step:
    """Newton step of all eight equations; their sparse Jacobian is eliminated by hand, down to alpha and rho1."""
    _px, py, pz = table.pivot

    def step(u: Array, data: Array) -> Array:
        x, y, z, alpha, rho1, rho2, rho3, tilt = u
        x_known, vy, vz, b, tool = data
        c, s, ct, st = np.cos(alpha), np.sin(alpha), np.cos(tilt), np.sin(tilt)
        down, across = st * vy + ct * vz, ct * vy - st * vz
        f_axis = tilt - alpha - b
        dx = x - x_known
        # y and z of P move by (y0, z0) and with alpha by (ya, za)
        tool_c, tool_s = tool * c, tool * s
        y0, ya = y - tool_s - py + across + down * f_axis, tool_c + down
        z0, za = z + tool_c - pz + down - across * f_axis, tool_s - across
        d, e, h = g.R1 * c - g.r1, g.R1 * s, z - rho1
        x1 = x + g.x1
        pa = d * ya + e * za + h * (g.R1 * c) - y * e
        qa = y * d + h * e - d * y0 - e * z0
        pb = y * ya + h * za + g.r1 * e
        qb = 0.5 * (x1 * x1 + y * y + h * h + d * d + e * e - g.L1**2) - x1 * dx - y * y0 - h * z0
        over = 1.0 / (pb * e - pa * h)
        da = (qb * e - qa * h) * over
        drho1 = (pa * qb - pb * qa) * over
        dy, dz = y0 + ya * da, z0 + za * da
        x2, arm, tilt = x + g.x2, g.R2 * c - g.r4, g.R2 * s
        y2, z2, y3, z3 = y - arm, z - tilt - rho2, y + arm, z + tilt - rho3
        side, slide, swing, rise = x2 * x2, x2 * dx, tilt * da, g.R2 * c * da
        drho2 = dz - rise + (slide + y2 * (dy + swing) - 0.5 * (side + y2 * y2 + z2 * z2 - g.L2**2)) / z2
        drho3 = dz + rise + (slide + y3 * (dy - swing) - 0.5 * (side + y3 * y3 + z3 * z3 - g.L3**2)) / z3
        return np.stack([dx, dy, dz, da, drho1, drho2, drho3, da + f_axis])

    return step


def _inverse_dense_step(g: Lengths, table: Table) -> Step:
    """The same step by one general solution of an 8 x 8 system a row."""
    _px, py, pz = table.pivot

    def step(u: Array, data: Array) -> Array:
        x, y, z, alpha = u[:4]
        tilt = u[7]
        x_known, vy, vz, b, tool = data
        c, s, ct, st = np.cos(alpha), np.sin(alpha), np.cos(tilt), np.sin(tilt)
        n = u.shape[1]
        value, jacobian = np.empty((n, 8)), np.zeros((n, 8, 8))
        value[:, 0], jacobian[:, 0, 0] = x - x_known, 1.0
        down, across = st * vy + ct * vz, ct * vy - st * vz
        value[:, 1], jacobian[:, 1, 1] = y - tool * s - py + across, 1.0
        jacobian[:, 1, 3], jacobian[:, 1, 7] = -tool * c, -down
        value[:, 2], jacobian[:, 2, 2] = z + tool * c - pz + down, 1.0
        jacobian[:, 2, 3], jacobian[:, 2, 7] = -tool * s, across
        value[:, 3], jacobian[:, 3, 3], jacobian[:, 3, 7] = tilt - alpha - b, -1.0, 1.0
        for row, (offset, radius, base, sign, slider, rod) in enumerate(_legs(g), start=4):
            dx, dy, dz = x + offset, y + sign * (radius * c - base), z + sign * radius * s - u[4 + slider]
            value[:, row] = dx * dx + dy * dy + dz * dz - rod**2
            jacobian[:, row, 0], jacobian[:, row, 1], jacobian[:, row, 2] = 2 * dx, 2 * dy, 2 * dz
            jacobian[:, row, 3] = 2 * sign * radius * (dz * c - dy * s)
            jacobian[:, row, 4 + slider] = -2 * dz
        return _solved(jacobian, value)

    return step


def pose_without_tilt(g: Lengths, table: Table, tip: Array, axis: Array, tool: Array) -> Array:
    """A good start of the inverse iteration, (n, 8): where a spindle that never tilts would stand, legs as in the
    middle.
    """
    return _pose_without_tilt(g, table, _pose_data(table, tip, axis, tool)[0]).T


def _pose_without_tilt(g: Lengths, table: Table, data: Array) -> Array:
    x, vy, vz, b, length = data
    cb, sb = np.cos(b), np.sin(b)
    start = np.zeros((8, data.shape[1]))
    start[0], start[7] = x, b
    start[1] = table.pivot[1] - (cb * vy - sb * vz)
    start[2] = table.pivot[2] - (sb * vy + cb * vz) - length
    start[4:7] = start[2] - _middle_drops(g)[:, None]
    return start


def middle(g: Lengths, table: Table, n: int) -> Array:
    """A start that knows nothing of the pose, (n, 8): P in the middle of the workspace, 600 mm over the pivot,
    A = 0.
    """
    start = np.zeros((n, 8))
    start[:, 0], start[:, 2] = -0.5 * (g.x1 + g.x2), table.pivot[2] - 600.0
    start[:, 4:7] = start[:, 2:3] - _middle_drops(g)
    return start


def inverse(
    g: Lengths, table: Table, tip: Array, axis: Array, tool: Array, start: Array | None = None, dense: bool = False
) -> tuple[Solved, Array]:
    """Newton-Raphson on all eight equations of the whole machine.

    Parameters
    ----------
    g : Lengths
    table : Table
    tip, axis : ndarray, shape (n, 3)
        Table frame; the axis from tip to spindle, a unit vector.
    tool : ndarray, shape (n,)
        Tool length, mm.
    start : ndarray, shape (n, 8), optional
        x, y, z, alpha, rho1, rho2, rho3, A; without it :func:`pose_without_tilt`.
    dense : bool
        Solve a general 8 x 8 system at each step instead of the elimination by hand.

    Returns
    -------
    Solved
        values (n, 8) as ``start``; ok only in the working mode.
    q : ndarray, shape (n, 5)
        rho1, rho2, rho3, A, C; NaN where not ok.
    """
    data, c = _pose_data(table, tip, axis, tool)
    scale = np.array([[g.L1]] * 3 + [[1.0]] + [[g.L1]] * 3 + [[1.0]])
    step, chunk = (_inverse_dense_step, CHUNK_DENSE) if dense else (_inverse_step, CHUNK)
    begin = _pose_without_tilt(g, table, data) if start is None else np.ascontiguousarray(start.T)
    found, steps, at_rest = iterate(step(g, table), begin, data, scale, chunk)
    u = found.T
    turns = _turns(u[:, 3])
    u[:, 3] -= turns
    u[:, 7] -= turns
    ok = at_rest & in_working_mode(g, u[:, :4], u[:, 4:7])
    u = np.where(ok[:, None], u, np.nan)
    q = np.column_stack([u[:, 4:], np.where(ok, c, np.nan)])
    return Solved(u, ok, steps, at_rest), q


def tool_of_pose(table: Table, pose: Array, tilt: Array, c: Array, tool: Array) -> tuple[Array, Array]:
    """Tip and tool axis (n, 3) in the table frame, of the platform's pose (n, 4) over the table at (A, C)."""
    x, y, z, alpha = pose.T
    length = table.nose + tool
    cl, sl = np.cos(alpha), np.sin(alpha)
    # from the pivot, upright, then back through the tilt and the rotary
    ux, uy, uz = x - table.pivot[0], table.pivot[1] - (y - length * sl), table.pivot[2] - (z + length * cl)
    ct, st, cc, sc = np.cos(tilt), np.sin(tilt), np.cos(c), np.sin(c)
    ox, oy, oz = table.rotary_offset
    vx, vy, vz = ux - ox, ct * uy + st * uz - oy, ct * uz - st * uy - oz
    across = st * cl - ct * sl
    tip = np.stack([cc * vx + sc * vy, cc * vy - sc * vx, vz], axis=-1)
    return tip, np.stack([sc * across, cc * across, ct * cl + st * sl], axis=-1)


def forward_machine(
    g: Lengths, table: Table, q: Array, tool: Array, start: Array | None = None, dense: bool = False
) -> tuple[Solved, Array, Array]:
    """Tip and axis (n, 3) of joints q (n, 5), through Newton-Raphson on (3)-(6); the first value is that of the
    module.
    """
    solved = forward(g, q[:, :3], start, dense)
    tip, axis = tool_of_pose(table, solved.values, q[:, 3], q[:, 4], tool)
    return solved, tip, axis
