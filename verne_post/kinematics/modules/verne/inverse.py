"""Sliders of the VERNE module for a platform position, in the working mode: equations (11) to (14)."""

from typing import Final, NamedTuple

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.tolerances import BRACKET_STEPS, REAL_ROOT_IMAG, ROD_RESIDUAL_MM2, TILT_ERROR, TILT_STEP
from verne_post.kinematics.modules.verne.geometry import VerneGeometry

#: Rows worked on at a time: the intermediate arrays then stay in the processor's cache.
CHUNK: Final = 4096
#: Share of rod L1 below which leg I's drop is small enough for two tilts to be near each other.
FLAT_LEG: Final = 0.01
#: Share of rod L1 below which leg I may have a second tilt in the working mode; generous.
SECOND_TILT: Final = 0.25
#: Halley's steps after the first; one reaches 1e-16 where the machine works, the rest goes to the bracket.
INVERSE_STEPS: Final = 5


class PointOfTilt(NamedTuple):
    """P as a function of the tilt: x fixed, ``y = y0 + yc cos(alpha) + ys sin(alpha)``, z alike. Base frame, mm.

    All fields are arrays (n,), or all are numbers.
    """

    x: Array
    y0: Array
    yc: Array
    ys: Array
    z0: Array
    zc: Array
    zs: Array

    def find_y(self, c: Array, s: Array) -> Array:
        """The y of P at a tilt given by its cosine and sine, mm."""
        return self.y0 + self.yc * c + self.ys * s

    def find_z(self, c: Array, s: Array) -> Array:
        """The z of P at a tilt given by its cosine and sine, mm."""
        return self.z0 + self.zc * c + self.zs * s

    def select(self, which: slice | Ints | int) -> "PointOfTilt":
        """Some of the rows."""
        return PointOfTilt(*(field[which] for field in self))

    def make_columns(self) -> "PointOfTilt":
        """Every field as a column (n, 1), or (1, 1), for several tilts of each point."""
        return PointOfTilt(*(np.reshape(field, (-1, 1)) for field in self))


def place_fixed_point(position: Array) -> PointOfTilt:
    """Positions (n, 3) that do not depend on the tilt."""
    zero = np.zeros(len(position))
    return PointOfTilt(position[:, 0], position[:, 1], zero, zero, position[:, 2], zero, zero)


def place_coupled_point(pivot: Array, gauge: Array) -> PointOfTilt:
    """Positions ``pivot + F Rx(alpha) gauge`` for gauge points (n, 3) of the upright frame at alpha = 0."""
    gx, gy, gz = gauge[:, 0], gauge[:, 1], gauge[:, 2]
    # F Rx(alpha) (gx, gy, gz) = (gx, -(c gy - s gz), -(s gy + c gz))
    y0, z0 = (np.broadcast_to(float(pivot[k]), len(gauge)) for k in (1, 2))
    return PointOfTilt(pivot[0] + gx, y0, -gy, gz, z0, -gz, -gy)


def solve_inverse(geometry: VerneGeometry, position: Array) -> tuple[Array, Array, Mask]:
    """Sliders for a platform position, in the working mode: equations (11) to (14); see ``ParallelModule.inverse``."""
    rho, alpha, ok = _solve(geometry, place_fixed_point(np.asarray(position, dtype=float).reshape(-1, 3)))
    shape = np.shape(position)[:-1]
    return rho.reshape(*shape, 3), alpha.reshape(shape), ok.reshape(shape)


def solve_inverse_coupled(geometry: VerneGeometry, pivot: Array, gauge: Array) -> tuple[Array, Array, Mask]:
    """Sliders for a platform point that turns with the platform's tilt; see ``ParallelModule.solve_coupled``."""
    rho, alpha, ok = _solve(geometry, place_coupled_point(pivot, np.asarray(gauge, dtype=float).reshape(-1, 3)))
    shape = np.shape(gauge)[:-1]
    return rho.reshape(*shape, 3), alpha.reshape(shape), ok.reshape(shape)


@np.errstate(invalid="ignore")  # what has no solution is NaN on the way
def _solve(geometry: VerneGeometry, points: PointOfTilt) -> tuple[Array, Array, Mask]:
    """Sliders (n, 3), tilt (n,) and ok (n,) of points in the working mode."""
    n = len(points.x)
    rho = np.empty((n, 3))
    alpha = np.empty(n)
    for first in range(0, n, CHUNK):
        part = slice(first, first + CHUNK)
        rho[part], alpha[part] = _solve_chunk(geometry, points.select(part))
    solved = np.isfinite(rho)
    if solved.all():
        return rho, alpha, np.ones(n, dtype=bool)
    ok = solved[:, 0] & solved[:, 1] & solved[:, 2]
    rho[~ok] = np.nan
    alpha[~ok] = np.nan
    return rho, alpha, ok


def _solve_chunk(geometry: VerneGeometry, point: PointOfTilt) -> tuple[Array, Array]:
    """Sliders (n, 3) and tilt (n,), each NaN where it has no solution."""
    s, converged = _iterate_tilt_sine(geometry, point)
    alpha = np.arcsin(s)
    if not converged.all():
        alpha[~converged] = np.nan
        finite = np.isfinite(point.x) & np.isfinite(point.y0) & np.isfinite(point.yc) & np.isfinite(point.ys)
        bad = np.flatnonzero(~converged & finite)
        alpha[bad] = _bracket_tilt(geometry, point.select(bad))
        s = np.sin(alpha)
    c = np.sqrt(1.0 - s * s)  # the tilt is less than a quarter turn
    y = point.find_y(c, s)
    radicands = geometry.find_radicands(point.x, y, c)
    closed = _choose_closed_legs(geometry, alpha, radicands, point)
    if closed is not None:
        alpha = closed
        c, s = np.cos(alpha), np.sin(alpha)
        y = point.find_y(c, s)
        radicands = geometry.find_radicands(point.x, y, c)
    z = point.find_z(c, s)
    unclosed = _find_unclosed(geometry, radicands[0], alpha, y)
    alpha[unclosed] = radicands[0, unclosed] = np.nan
    drop = np.sqrt(radicands)
    rho = np.empty((len(s), 3))
    rho[:, 0] = z - drop[0]
    rho[:, 1] = z - geometry.R2 * s - drop[1]
    rho[:, 2] = z + geometry.R2 * s - drop[2]
    return rho, alpha


def _iterate_tilt_sine(geometry: VerneGeometry, point: PointOfTilt) -> tuple[Array, Mask]:
    """Sine s of the tilt that solves (14) in the working mode, by Halley's steps from s = 0; False where they fail.

    f = y (R1 cos a - r1) + R1 sin a sqrt(M),  M the radicand of (11). With c = sqrt(1 - s^2), df/ds = f' / c, ' = d/da,
    so that no step needs a trigonometric function. The first one is written out for s = 0, c = 1.
    """
    R1, r1 = geometry.R1, geometry.r1
    x_leg1 = point.x + geometry.leg1_x_offset
    y0, yc, ys = point.y0, point.yc, point.ys
    const = geometry.L1**2 - R1**2 - r1**2 - x_leg1**2
    with np.errstate(divide="ignore", over="ignore"):
        y = y0 + yc
        root = np.sqrt(const + 2 * R1 * r1 - y * y)
        f, df = y * (R1 - r1), ys * (R1 - r1) + R1 * root
        ddf = -yc * (R1 - r1) - R1 * y * (1 + 2 * ys / root)
        s = -f * df / (df * df - 0.5 * f * ddf)
        c = np.sqrt(1.0 - s * s)
        for _ in range(INVERSE_STEPS):
            y = y0 + yc * c + ys * s
            dy, ddy = ys * c - yc * s, y0 - y
            arm = R1 * c - r1
            root = np.sqrt(const + 2 * R1 * r1 * c - y * y)
            droot = -(R1 * r1 * s + y * dy) / root
            ddroot = -(R1 * r1 * c + dy * dy + y * ddy + droot * droot) / root
            f = y * arm + R1 * s * root
            df = dy * arm + R1 * (c * root + s * (droot - y))
            ddf = ddy * arm + R1 * (c * (2 * droot - y) + s * (ddroot - root - 2 * dy))
            newton = f / df
            bend = 0.5 * newton * (ddf / df + s / c)
            step = c * newton / (1.0 - bend)
            s = s - step
            c = np.sqrt(1.0 - s * s)
            # written so that NaN counts as not converged
            small = (np.abs(step) < TILT_STEP) & (np.abs(step) * bend * bend < TILT_ERROR)
            if bool(small.all()):
                break
        return s, small & (R1 * c > r1)


def _bracket_tilt(geometry: VerneGeometry, point: PointOfTilt) -> Array:
    """Tilt of rows where the iteration failed: by bracket, or the smallest real root of the squared equation."""
    found = np.full(len(point.x), np.nan)
    within = np.flatnonzero(_is_within_leg_1(geometry, point))  # few where a path is far out of reach
    if not len(within):
        return found
    point = point.select(within)
    low = np.full_like(point.x, -geometry.crossing_angle)
    high = -low
    for _ in range(BRACKET_STEPS):
        middle = 0.5 * (low + high)
        value, _radicand = _evaluate_loop(geometry, middle, point)
        above = value > 0
        high = np.where(above, middle, high)
        low = np.where(above, low, middle)
    alpha = 0.5 * (low + high)
    _value, radicand = _evaluate_loop(geometry, alpha, point)
    lost = np.flatnonzero(~(radicand > 0))
    if len(lost):
        alpha[lost] = _choose_least(_find_working_tilts(geometry, point.select(lost)))
    found[within] = alpha
    return found


def _is_within_leg_1(geometry: VerneGeometry, point: PointOfTilt) -> Mask:
    """False where leg I is too short for a point at every tilt: the radicand of (11) is negative at its largest."""
    ends = np.array([[-geometry.crossing_angle], [geometry.crossing_angle]])
    # y0 + yc cos a + ys sin a is largest and smallest at the ends, or where a is the direction of (yc, ys)
    swing, direction = np.hypot(point.yc, point.ys), np.arctan2(point.ys, point.yc)
    y = point.find_y(np.cos(ends), np.sin(ends))
    highest = np.where(np.abs(direction) < ends[1], point.y0 + swing, y.max(axis=0))
    lowest = np.where(np.pi - np.abs(direction) < ends[1], point.y0 - swing, y.min(axis=0))
    nearest = np.maximum(np.maximum(lowest, -highest), 0.0)
    x_leg1 = point.x + geometry.leg1_x_offset
    return np.asarray(geometry.L1**2 - (geometry.R1 - geometry.r1) ** 2 - x_leg1**2 - nearest**2 >= 0.0)


def _choose_closed_legs(geometry: VerneGeometry, alpha: Array, radicands: Array, point: PointOfTilt) -> Array | None:
    """Tilts (n,) that let legs II and III close where ``alpha`` does not; None where nothing changes.

    Close to leg I's serial singularity (14) has two working roots: where leg II or III is too short for the one, the
    other is taken if that suits them.
    """
    # leg I has a second tilt only where its drop is small
    near = radicands[0] < (SECOND_TILT * geometry.L1) ** 2
    rows = np.flatnonzero(np.isfinite(alpha) & ~(radicands > 0).all(axis=0) & near)
    if not len(rows):
        return None
    points = point.select(rows)
    others = _find_working_tilts(geometry, points)
    least = _choose_least(np.where(_find_closed(geometry, points, others), others, np.nan))
    better = alpha.copy()
    better[rows] = np.where(np.isnan(least), alpha[rows], least)
    return better


def _choose_least(tilts: Array) -> Array:
    """The smallest tilt (n,) of each row (n, k), by its size; NaN where a row has none."""
    size = np.where(np.isnan(tilts), np.inf, np.abs(tilts))
    return np.take_along_axis(tilts, size.argmin(axis=1)[:, None], axis=1)[:, 0]


def _find_closed(geometry: VerneGeometry, points: PointOfTilt, tilts: Array) -> Mask:
    """Whether all legs close at tilts (n, k) of points (n,)."""
    columns = points.make_columns()
    c = np.cos(tilts)
    x = np.broadcast_to(columns.x, c.shape)
    return np.asarray((geometry.find_radicands(x, columns.find_y(c, np.sin(tilts)), c) > 0).all(axis=0))


def _find_unclosed(geometry: VerneGeometry, radicand1: Array, alpha: Array, y: Array) -> Ints:
    """Rows where (14) fails: where leg I is nearly horizontal two tilts merge, and the iteration may stop early."""
    flat = np.flatnonzero(radicand1 < (FLAT_LEG * geometry.L1) ** 2)
    c, s = np.cos(alpha[flat]), np.sin(alpha[flat])
    miss = y[flat] * (geometry.R1 * c - geometry.r1) + geometry.R1 * s * np.sqrt(radicand1[flat])
    return flat[~(np.abs(miss) < 0.5 * ROD_RESIDUAL_MM2 * max(geometry.L1 / 850.0, 1.0) ** 2)]


def _evaluate_loop(geometry: VerneGeometry, alpha: Array, point: PointOfTilt) -> tuple[Array, Array]:
    """Equation (14) in the working mode with the radicand of (11) cut off at zero, and the radicand."""
    R1, r1 = geometry.R1, geometry.r1
    c, s = np.cos(alpha), np.sin(alpha)
    y = point.find_y(c, s)
    x_leg1 = point.x + geometry.leg1_x_offset
    radicand = geometry.L1**2 - (R1**2 + r1**2 - 2 * R1 * r1 * c) - x_leg1**2 - y * y
    return y * (R1 * c - r1) + R1 * s * np.sqrt(np.maximum(radicand, 0.0)), radicand


# --- roots of the squared equation -------------------------------------------------------------


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # points without bound have no tilt
def find_tilts(geometry: VerneGeometry, points: PointOfTilt, near_circle: float = REAL_ROOT_IMAG) -> Array:
    """All real alpha of (7) for points (n,) or one: a trigonometric cubic, at most six roots, rad.

    They are the rows of the result (n, 6), ascending; then NaN.

    Seven samples give its seven Fourier coefficients exactly. In w = exp(i alpha) it is a polynomial of degree six,
    whose roots on the unit circle, up to ``near_circle``, are the real angles. The roots are the eigenvalues of the
    companion matrix, as in ``numpy.roots``.
    """
    a = 2 * np.pi * np.arange(7) / 7
    c, s = np.cos(a), np.sin(a)
    columns = points.make_columns()
    x_leg1 = columns.x + geometry.leg1_x_offset
    y = columns.find_y(c, s)
    arm = geometry.R1**2 + geometry.r1**2 - 2 * geometry.R1 * geometry.r1 * c
    value = arm * y**2 - (geometry.R1 * s) ** 2 * (geometry.L1**2 - arm - x_leg1**2)
    orders = np.fft.fft(value, axis=1)[:, [3, 2, 1, 0, 6, 5, 4]]  # fft gives orders 0, 1, 2, 3, -3, -2, -1
    companion = np.zeros((len(value), 6, 6), dtype=complex)
    companion[:, range(1, 6), range(5)] = 1.0
    companion[:, 0] = -orders[:, 1:] / orders[:, :1]
    whole = np.isfinite(companion[:, 0]).all(axis=1)
    roots = np.full((len(value), 6), np.nan, dtype=complex)
    roots[whole] = np.linalg.eigvals(companion[whole])
    for row in np.flatnonzero(orders[:, 0] == 0.0).tolist():  # of lower degree
        found = np.roots(orders[row])
        roots[row, : len(found)] = found
    return np.sort(np.where(np.abs(np.abs(roots) - 1) < near_circle, np.angle(roots), np.nan), axis=1)


@np.errstate(invalid="ignore")
def _find_working_tilts(geometry: VerneGeometry, points: PointOfTilt) -> Array:
    """The roots of :func:`find_tilts` that are in the working mode of leg I: (n, 6), the others NaN."""
    a = find_tilts(geometry, points)
    value, radicand = _evaluate_loop(geometry, a, points.make_columns())
    # the value is a length squared; the wrong sign of the root doubles a term of that size
    same_sign = np.abs(value) <= REAL_ROOT_IMAG * geometry.R1 * geometry.L1
    return np.where((np.abs(a) < geometry.crossing_angle) & (radicand > 0) & same_sign, a, np.nan)


def explain_unreachable(geometry: VerneGeometry, pivot: Array, gauge: Array) -> list[str]:
    """Why poses have no solution in the working mode: "VP201" if only crossed ones exist, else "VP110".

    Parameters
    ----------
    pivot : ndarray, shape (3,)
    gauge : ndarray, shape (m, 3)
        As in :func:`solve_inverse_coupled`.
    """
    points = place_coupled_point(pivot, np.asarray(gauge, dtype=float))
    tilts = find_tilts(geometry, points)
    crossed = _find_closed(geometry, points, tilts) & (geometry.R1 * np.cos(tilts) <= geometry.r1)
    return np.where(crossed.any(axis=1), "VP201", "VP110").tolist()
