"""The parallel module of the VERNE: three vertical sliders, six rods, a platform that tilts.

Equation numbers refer to Kanaan, Wenger, Chablat, *Kinematics analysis of the parallel module of
the VERNE machine*. Base frame: z points down, x along the line from leg pair II/III to leg I; mm, rad.
The *working mode* is the one the machine uses: every attachment point of a slider above the
platform's (s1 = s2 = s3 = -1) and uncrossed rods of leg I (R1 cos alpha > r1).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.tolerances import (
    BRACKET_STEPS,
    NEWTON_STEP,
    REAL_ROOT_IMAG,
    ROD_RESIDUAL_MM2,
    TILT_ERROR,
    TILT_STEP,
)
from verne_post.kinematics.mobility import Joint, rod_pairs
from verne_post.kinematics.modules.solutions import ForwardSolution, InverseSolution
from verne_post.kinematics.modules.verne import modes, rods
from verne_post.kinematics.modules.verne.loops import LENGTHS, SIGNED, loop_equations
from verne_post.kinematics.modules.verne.modes import ForwardModes
from verne_post.model.protocols import Margin

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

#: Rows worked on at a time: the intermediate arrays then stay in the processor's cache.
CHUNK: Final = 4096
#: Share of rod L1 below which leg I's drop is small enough for two tilts to be near each other.
FLAT_LEG: Final = 0.01
#: Halley's steps behind the first; one reaches 1e-16 where the machine works, the rest goes to the bracket.
INVERSE_STEPS: Final = 5
#: Newton steps of the forward solution from the middle of the workspace (rim: 8).
FORWARD_STEPS: Final = 25


@dataclass(frozen=True)
class VerneModule:
    """Lengths of the module, with the paper's symbols (mm).

    ``leg1_x_offset`` is D1 - d1, ``leg23_x_offset`` D2 - d2: only these differences enter.
    """

    leg1_x_offset: float
    R1: float
    r1: float
    L1: float
    leg23_x_offset: float
    R2: float
    r4: float
    L2: float
    L3: float

    actuators: ClassVar[tuple[str, ...]] = ("rho1", "rho2", "rho3")
    length_names: ClassVar[tuple[str, ...]] = LENGTHS
    signed_lengths: ClassVar[frozenset[str]] = SIGNED

    @property
    def crossing_angle(self) -> float:
        """The tilt at which the rods of leg I would cross: R1 cos(alpha) = r1."""
        return float(np.arccos(self.r1 / self.R1))

    # --- inverse -------------------------------------------------------------------------

    def inverse(self, position: Array) -> tuple[Array, Array, Mask]:
        """Sliders for a platform position, in the working mode: equations (11) to (14).

        Parameters
        ----------
        position : ndarray, shape (..., 3)
            P in the base frame, mm.

        Returns
        -------
        rho : ndarray, shape (..., 3)
            mm, NaN where not ok.
        alpha : ndarray, shape (...)
            Lean of the platform, rad, NaN where not ok.
        ok : ndarray of bool, shape (...)
        """
        flat = np.asarray(position, dtype=float).reshape(-1, 3)
        zero = np.zeros(len(flat))
        rho, alpha, ok = self._solve(flat[:, 0], flat[:, 1], zero, zero, flat[:, 2], zero, zero)
        shape = np.shape(position)[:-1]
        return rho.reshape(*shape, 3), alpha.reshape(shape), ok.reshape(shape)

    def inverse_coupled(self, pivot: Array, gauge: Array) -> tuple[Array, Array, Mask]:
        """Sliders for a platform point that turns with the tilt itself: ``pivot + F Rx(alpha) gauge``.

        Parameters
        ----------
        pivot : ndarray, shape (3,)
            Base frame, mm.
        gauge : ndarray, shape (..., 3)
            Upright frame at alpha = 0, mm.

        Returns
        -------
        rho, alpha, ok
            As :meth:`inverse`.
        """
        g = np.asarray(gauge, dtype=float).reshape(-1, 3)
        gx, gy, gz = g[:, 0], g[:, 1], g[:, 2]
        # F Rx(alpha) (gx, gy, gz) = (gx, -(c gy - s gz), -(s gy + c gz))
        y0, z0 = (np.broadcast_to(float(pivot[k]), len(g)) for k in (1, 2))
        rho, alpha, ok = self._solve(pivot[0] + gx, y0, -gy, gz, z0, -gz, -gy)
        shape = np.shape(gauge)[:-1]
        return rho.reshape(*shape, 3), alpha.reshape(shape), ok.reshape(shape)

    @np.errstate(invalid="ignore")  # what has no solution is NaN on the way
    def _solve(
        self, x: Array, y0: Array, yc: Array, ys: Array, z0: Array, zc: Array, zs: Array
    ) -> tuple[Array, Array, Mask]:
        """Working-mode solution where y_P = y0 + yc cos(alpha) + ys sin(alpha), z_P alike; all shape (n,)."""
        n = len(x)
        rho = np.empty((n, 3))
        alpha = np.empty(n)
        for first in range(0, n, CHUNK):
            part = slice(first, first + CHUNK)
            x_leg1 = x[part] + self.leg1_x_offset
            s, good = self._lean(x_leg1, y0[part], yc[part], ys[part])
            a = np.arcsin(s)
            if not good.all():
                a[~good] = np.nan
                given = np.isfinite(x_leg1) & np.isfinite(y0[part]) & np.isfinite(yc[part]) & np.isfinite(ys[part])
                bad = np.flatnonzero(~good & given)
                a[bad] = self._bracketed(x_leg1[bad], y0[part][bad], yc[part][bad], ys[part][bad])
                s = np.sin(a)
            c = np.sqrt(1.0 - s * s)  # the tilt is less than a quarter turn
            y = y0[part] + yc[part] * c + ys[part] * s
            radicands = self._radicands(x[part], y, c)
            if self._prefer_closed_legs(a, radicands, x[part], y0[part], yc[part], ys[part]):
                c, s = np.cos(a), np.sin(a)
                y = y0[part] + yc[part] * c + ys[part] * s
                radicands = self._radicands(x[part], y, c)
            z = z0[part] + zc[part] * c + zs[part] * s
            self._refuse_unclosed(radicands, a, y)
            drop = np.sqrt(radicands)
            rho[part, 0] = z - drop[0]
            rho[part, 1] = z - self.R2 * s - drop[1]
            rho[part, 2] = z + self.R2 * s - drop[2]
            alpha[part] = a
        solved = np.isfinite(rho)
        if solved.all():
            return rho, alpha, np.ones(n, dtype=bool)
        ok = solved[:, 0] & solved[:, 1] & solved[:, 2]
        rho[~ok] = np.nan
        alpha[~ok] = np.nan
        return rho, alpha, ok

    def _refuse_unclosed(self, radicands: Array, alpha: Array, y: Array) -> None:
        """Where leg I is all but horizontal two tilts merge and the iteration may stop short of them: NaN where (14) fails.

        Changes ``alpha`` and leg I's radicand in place.
        """
        flat = np.flatnonzero(radicands[0] < (FLAT_LEG * self.L1) ** 2)
        c, s = np.cos(alpha[flat]), np.sin(alpha[flat])
        miss = y[flat] * (self.R1 * c - self.r1) + self.R1 * s * np.sqrt(radicands[0, flat])
        open_ = flat[~(np.abs(miss) < 0.5 * ROD_RESIDUAL_MM2 * max(self.L1 / 850.0, 1.0) ** 2)]
        alpha[open_] = radicands[0, open_] = np.nan

    def _radicands(self, x: Array, y: Array, cos_alpha: Array) -> Array:
        """Radicands of (11), (12), (13), shape (3, ...): squared vertical drops of the three legs, mm2."""
        x1, x2 = x + self.leg1_x_offset, x + self.leg23_x_offset
        arm = self.R2 * cos_alpha - self.r4
        leg1 = self.L1**2 - (self.R1**2 + self.r1**2 - 2 * self.R1 * self.r1 * cos_alpha)
        found = np.empty((3, *np.shape(y)))
        found[0] = leg1 - x1**2 - y**2
        found[1] = self.L2**2 - x2**2 - (y - arm) ** 2
        found[2] = self.L3**2 - x2**2 - (y + arm) ** 2
        return found

    def _lean(self, x_leg1: Array, y0: Array, yc: Array, ys: Array) -> tuple[Array, Mask]:
        """Sine s of the tilt that solves (14) in the working mode, by Halley's steps from s = 0; False where they fail.

        f = y (R1 cos a - r1) + R1 sin a sqrt(M),  M the radicand of (11). With c = sqrt(1 - s^2), df/ds = f' / c, ' = d/da,
        so that no step needs a trigonometric function. The first one is written out for s = 0, c = 1.
        """
        R1, r1 = self.R1, self.r1
        const = self.L1**2 - R1**2 - r1**2 - x_leg1**2
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
            good = small & (R1 * c > r1)
        return s, good

    def _bracketed(self, x_leg1: Array, y0: Array, yc: Array, ys: Array) -> Array:
        """Rows where the iteration failed: every real root of the squared equation, by bracket or closed form."""
        lo = np.full_like(x_leg1, -self.crossing_angle)
        hi = -lo
        for _ in range(BRACKET_STEPS):
            mid = 0.5 * (lo + hi)
            f, _radicand = self._loop(mid, x_leg1, y0, yc, ys)
            above = f > 0
            hi = np.where(above, mid, hi)
            lo = np.where(above, lo, mid)
        a = 0.5 * (lo + hi)
        _f, radicand = self._loop(a, x_leg1, y0, yc, ys)
        lost = ~(radicand > 0)
        a[lost] = np.nan
        for row in np.flatnonzero(lost):
            inside = self._working(x_leg1[row], y0[row], yc[row], ys[row])
            if len(inside):
                a[row] = inside[np.argmin(np.abs(inside))]
        return a

    def _prefer_closed_legs(self, a: Array, radicands: Array, x: Array, y0: Array, yc: Array, ys: Array) -> bool:
        """Where leg II or III is too short for the tilt found, take leg I's other working tilt if that suits them.

        Close to leg I's serial singularity (14) has two working roots. Changes ``a`` in place; True where it did.
        """
        changed = False
        # leg I has a second tilt only where its drop is small; 0.25 L1 is generous
        open_ = np.isfinite(a) & ~(radicands > 0).all(axis=0) & (radicands[0] < (0.25 * self.L1) ** 2)
        for row in np.flatnonzero(open_):
            others = self._working(float(x[row] + self.leg1_x_offset), float(y0[row]), float(yc[row]), float(ys[row]))
            y = y0[row] + yc[row] * np.cos(others) + ys[row] * np.sin(others)
            closed = (self._radicands(np.full_like(others, x[row]), y, np.cos(others)) > 0).all(axis=0)
            if closed.any():
                a[row] = others[closed][np.argmin(np.abs(others[closed]))]
                changed = True
        return changed

    def _loop(self, a: Array, x_leg1: Array, y0: Array, yc: Array, ys: Array) -> tuple[Array, Array]:
        """Equation (14) in the working mode with the radicand of (11) cut off at zero, and the radicand."""
        c, s = np.cos(a), np.sin(a)
        y = y0 + yc * c + ys * s
        radicand = self.L1**2 - (self.R1**2 + self.r1**2 - 2 * self.R1 * self.r1 * c) - x_leg1**2 - y * y
        root = np.sqrt(np.maximum(radicand, 0.0))
        return y * (self.R1 * c - self.r1) + self.R1 * s * root, radicand

    def _orientation_roots(
        self, x_leg1: float, y0: float, yc: float, ys: float, near_circle: float = REAL_ROOT_IMAG
    ) -> Array:
        """All real alpha of (7) with y = y0 + yc cos + ys sin: a trigonometric cubic, at most six roots.

        Seven samples give its seven Fourier coefficients exactly; in w = exp(i alpha) it is a
        polynomial of degree six, whose roots on the unit circle are the real angles.
        """
        if not np.isfinite([x_leg1, y0, yc, ys]).all():
            return np.empty(0)
        a = 2 * np.pi * np.arange(7) / 7
        c, s = np.cos(a), np.sin(a)
        y = y0 + yc * c + ys * s
        arm = self.R1**2 + self.r1**2 - 2 * self.R1 * self.r1 * c
        value = arm * y**2 - (self.R1 * s) ** 2 * (self.L1**2 - arm - x_leg1**2)
        coefficients = np.fft.fft(value) / 7  # orders 0, 1, 2, 3, -3, -2, -1
        roots = np.roots(coefficients[[3, 2, 1, 0, 6, 5, 4]])
        on_circle = np.abs(np.abs(roots) - 1) < near_circle
        return np.sort(np.angle(roots[on_circle]))

    def _working(self, x_leg1: float, y0: float, yc: float, ys: float) -> Array:
        """The roots of :meth:`_orientation_roots` that are in the working mode of leg I."""
        a = self._orientation_roots(x_leg1, y0, yc, ys)
        f, radicand = self._loop(a, np.full_like(a, x_leg1), y0, yc, ys)  # type: ignore[arg-type]
        # f is a length squared; the wrong sign of the root doubles a term of that size
        same_sign = np.abs(f) <= REAL_ROOT_IMAG * self.R1 * self.L1
        return a[(np.abs(a) < self.crossing_angle) & (radicand > 0) & same_sign]

    def why_unreachable(self, pivot: Array, gauge: Array) -> list[str]:
        """Why poses have no solution in the working mode: "VP201" if only crossed ones exist, else "VP110".

        Parameters
        ----------
        pivot : ndarray, shape (3,)
        gauge : ndarray, shape (m, 3)
            As in :meth:`inverse_coupled`.
        """
        codes = []
        for gx, gy, gz in np.asarray(gauge, dtype=float):
            x = float(pivot[0] + gx)
            a = self._orientation_roots(x + self.leg1_x_offset, float(pivot[1]), -gy, gz)
            y = pivot[1] - gy * np.cos(a) + gz * np.sin(a)
            real = (self._radicands(np.full_like(a, x), y, np.cos(a)) > 0).all(axis=0)
            codes.append("VP201" if bool(np.any(real & (self.R1 * np.cos(a) <= self.r1))) else "VP110")
        return codes

    # --- every solution ----------------------------------------------------------------------

    def inverse_all(self, position: Array) -> list[InverseSolution]:
        """All real inverse solutions of one position (3,), with the reason each is refused: at most 16 (Fig. 6)."""
        return modes.inverse_all(self, position)

    def inverse_coupled_all(self, pivot: Array, gauge: Array) -> list[InverseSolution]:
        """All real solutions of :meth:`inverse_coupled` for one gauge point (3,): six tilts at most."""
        return modes.inverse_coupled_all(self, pivot, gauge)

    def orientations(self, position: Array) -> list[float]:
        """All tilts of the platform at one position (3,), rad: equation (9), Table I."""
        return modes.orientations(self, position)

    def forward_all(self, rho: Array) -> list[ForwardSolution]:
        """All real assembly modes of one set of sliders (3,), with the reason each is refused (Fig. 7, Table III)."""
        return modes.forward_all(self, rho)

    def forward_modes(self, rho: Array) -> ForwardModes:
        """All real assembly modes of many sets of sliders (n, 3), mm."""
        return modes.forward_modes(self, np.asarray(rho, dtype=float).reshape(-1, 3))

    def iso_alpha_ellipse(self, alpha: float, turn: Array) -> Array:
        """Points (n, 2) of the ellipse (8) on which the platform tilts by +-alpha (Fig. 5)."""
        return modes.iso_alpha_ellipse(self, alpha, turn)

    def sketch(self, position: Array, alpha: Array, rho: Array) -> Array:
        """Rods (n, 4, 2, 3) for a picture; see :func:`.verne_rods.sketch`."""
        return rods.sketch(self, position, alpha, rho)

    # --- identification ------------------------------------------------------------------

    def loop_equations(self, lengths: Array, rho: Array, pose: Array) -> tuple[Array, Array, Array, Array]:
        """The rod equations (3) to (6) for any lengths, with derivatives; see :mod:`.verne_loops`."""
        return loop_equations(lengths, rho, pose)

    # --- forward -------------------------------------------------------------------------

    def forward(self, rho: Array) -> tuple[Array, Array, Mask]:
        """Platform position for slider coordinates, in the working mode: Newton on (10), (5), (6).

        Equation (14) is used to write y and z by the drop w = z - rho1 of leg I,
        ``y = -w R1 sin(alpha) / (R1 cos(alpha) - r1)``, which is smooth in the working mode.

        Parameters
        ----------
        rho : ndarray, shape (..., 3)
            mm.

        Returns
        -------
        position : ndarray, shape (..., 3)
            mm, NaN where not ok.
        alpha : ndarray, shape (...)
        ok : ndarray of bool, shape (...)
            True where the iteration reached a solution in the working mode.
        """
        flat = np.asarray(rho, dtype=float).reshape(-1, 3)
        position = np.empty((len(flat), 3))
        alpha = np.empty(len(flat))
        ok = np.empty(len(flat), dtype=bool)
        for first in range(0, len(flat), CHUNK):
            part = slice(first, first + CHUNK)
            position[part], alpha[part], ok[part] = self._forward_chunk(flat[part])
        shape = np.shape(rho)[:-1]
        return position.reshape(*shape, 3), alpha.reshape(shape), ok.reshape(shape)

    def _forward_start(self) -> tuple[float, float]:
        """A point in the middle of the workspace: x of P and the drop of leg I there."""
        x = -0.5 * (self.leg1_x_offset + self.leg23_x_offset)
        drop2 = self.L1**2 - (self.R1 - self.r1) ** 2 - (x + self.leg1_x_offset) ** 2
        return x, float(np.sqrt(max(drop2, (0.25 * self.L1) ** 2)))

    def _forward_chunk(self, rho: Array) -> tuple[Array, Array, Mask]:
        R1, r1, R2, r4 = self.R1, self.r1, self.R2, self.r4
        rho1, rho2, rho3 = rho.T
        x0, w0 = self._forward_start()
        x, w, a = np.full(len(rho), x0), np.full(len(rho), w0), np.zeros(len(rho))
        dx = dw = da = np.full(len(rho), np.nan)
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            for _ in range(FORWARD_STEPS):
                c, s = np.cos(a), np.sin(a)
                uncrossed = R1 * c - r1
                t = -R1 * s / uncrossed
                dt = -R1 * (R1 - r1 * c) / uncrossed**2
                y, dy = t * w, dt * w
                x1, x2 = x + self.leg1_x_offset, x + self.leg23_x_offset
                arm, darm = R2 * c - r4, -R2 * s
                y2, z2 = y - arm, rho1 + w - R2 * s - rho2
                y3, z3 = y + arm, rho1 + w + R2 * s - rho3
                e1 = x1**2 + y**2 + w**2 - self.L1**2 + R1**2 + r1**2 - 2 * R1 * r1 * c
                e2 = x2**2 + y2**2 + z2**2 - self.L2**2
                e3 = x2**2 + y3**2 + z3**2 - self.L3**2
                # halves of the partial derivatives by x, w, alpha
                j11, j12, j13 = x1, y * t + w, y * dy + R1 * r1 * s
                j21, j22, j23 = x2, y2 * t + z2, y2 * (dy - darm) - z2 * R2 * c
                j31, j32, j33 = x2, y3 * t + z3, y3 * (dy + darm) + z3 * R2 * c
                m1, m2, m3 = j22 * j33 - j23 * j32, j23 * j31 - j21 * j33, j21 * j32 - j22 * j31
                det = 2 * (j11 * m1 + j12 * m2 + j13 * m3)
                dx = (e1 * m1 + e2 * (j13 * j32 - j12 * j33) + e3 * (j12 * j23 - j13 * j22)) / det
                dw = (e1 * m2 + e2 * (j11 * j33 - j13 * j31) + e3 * (j13 * j21 - j11 * j23)) / det
                da = (e1 * m3 + e2 * (j12 * j31 - j11 * j32) + e3 * (j11 * j22 - j12 * j21)) / det
                # The tilt may not jump over the crossing of the rods, where y has a pole.
                scale = np.minimum(1.0, 0.3 / np.abs(da))
                x, w, a = x - scale * dx, w - scale * dw, a - scale * da
                if bool((np.abs(da) < NEWTON_STEP).all() and (np.abs(dx) + np.abs(dw) < NEWTON_STEP * self.L1).all()):
                    break
            c, s = np.cos(a), np.sin(a)
            y = -w * R1 * s / (R1 * c - r1)
            position = np.stack([x, y, rho1 + w], axis=-1)
            converged = (np.abs(da) < NEWTON_STEP) & (np.abs(dx) + np.abs(dw) < NEWTON_STEP * self.L1)
            ok = converged & self._in_working_mode(position, a, rho)
        position[~ok] = np.nan
        a[~ok] = np.nan
        return position, a, ok

    def _in_working_mode(self, position: Array, alpha: Array, rho: Array) -> Mask:
        """Rods closed, uncrossed, and every slider attachment above the platform's."""
        z = position[:, 2]
        tilt = self.R2 * np.sin(alpha)
        above = (rho[:, 0] < z) & (rho[:, 1] < z - tilt) & (rho[:, 2] < z + tilt)
        scale = (self.L1 / 850.0) ** 2  # the residual is a length squared
        residuals = rods.rod_residuals(self, position, alpha, rho)
        closed = (np.abs(residuals) < ROD_RESIDUAL_MM2 * max(scale, 1.0)).all(axis=-1)
        return above & closed & (np.abs(alpha) < self.crossing_angle)

    # --- velocities -----------------------------------------------------------------------

    def jacobians(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Parallel (..., 4, 4) and serial (..., 4, 3) part of the rod equations: see :func:`verne_rods.rod_jacobians`."""
        return rods.rod_jacobians(self, position, alpha, rho)

    def conditioning(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Reciprocal condition numbers of the scaled parallel and serial part, each (...)."""
        return rods.conditioning(self, position, alpha, rho)

    @property
    def joint_graph(self) -> tuple[Joint, ...]:
        """Bodies and joints of Fig. 3, for the mobility (1)."""
        return rod_pairs(self.actuators, ("I", "II", "III"))

    # --- margins --------------------------------------------------------------------------

    def geometry_margins(self, position: Array, alpha: Array) -> Array:
        """Vertical drops of the three legs (mm), R1 cos(alpha) - r1 (mm), scaled parallel determinant; shape (..., 5).

        The determinant counts positive on the side of the middle of the workspace.
        """
        c, s = np.cos(alpha), np.sin(alpha)
        drops = np.sqrt(np.maximum(self._radicands(position[..., 0], position[..., 1], c), 0.0))
        determinant = self._determinant_side * rods.parallel_determinant(self, position, (c, s), drops)
        return np.stack([drops[0], drops[1], drops[2], self.R1 * c - self.r1, determinant], axis=-1)

    @cached_property
    def _determinant_side(self) -> float:
        """Sign of the parallel determinant in the middle of the workspace."""
        x, _drop = self._forward_start()
        middle, upright = np.array([x, 0.0, 0.0]), (np.array(1.0), np.array(0.0))
        drops = np.sqrt(np.maximum(self._radicands(middle[0], middle[1], upright[0]), 0.0))
        return 1.0 if rods.parallel_determinant(self, middle, upright, drops) >= 0 else -1.0

    def margin_names(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`geometry_margins` measures, with thresholds (mm; the determinant has no unit)."""
        drops = tuple(
            Margin("vertical drop of a rod", "VP202", joint, "mm", serial_singularity, 2 * serial_singularity)
            for joint in self.actuators
        )
        return (
            *drops,
            Margin("R1 cos(alpha) - r1", "VP201", None, "mm", 0.0, 0.0),
            Margin(
                "determinant of the parallel Jacobian",
                "VP203",
                None,
                "",
                parallel_singularity,
                2 * parallel_singularity,
            ),
        )
