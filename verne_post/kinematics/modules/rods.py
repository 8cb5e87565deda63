"""A carrier described by its rods: three actuators that slide on straight rails, six rods of fixed length.

Rod k has its ball joints at a_k on the platform and at b_k + rho u_k on the slider of its actuator:

    w_k = P + Rx(alpha) a_k - b_k,        |w_k - rho u_k| = L_k.

Given P and alpha, each rod alone has its slider in closed form, ``rho = w.u - s sqrt(L^2 - |w|^2 + (w.u)^2)``, with the
side s that it has at home. The rods of one slider must agree. Where the platform tilts, alpha follows from that by
Newton steps from 0, and from larger tilts where a rod does not reach at 0.
The forward solution is Newton from home, or along the way of the sliders from home where that does not close. Other
assemblies of the same sliders can have the same sides and the same sign of the Jacobian; the way from home and a bound
on alpha exclude them.

Base frame (z down); mm, rad. The platform may tilt about x alone; loading refuses a mechanism that turns otherwise.
"""

import math
from functools import cached_property
from itertools import product
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.base.conditioning import find_reciprocal_condition, measure_singularity
from verne_post.base.rotations import rotate_x, rotate_x_rate
from verne_post.base.units import RAD_PER_DEG
from verne_post.kinematics.modules.newton import STEPS, find_poses, follow_from_home
from verne_post.kinematics.modules.rod_geometry import CLOSED, RodGeometry
from verne_post.kinematics.modules.solutions import make_triple, place_upright
from verne_post.model.poses import Platform
from verne_post.model.protocols import ForwardSolution, InverseSolution, Margin

#: A Newton step of the tilt of less (rad times mm) leaves nothing to gain.
STILL: Final = 1e-12
#: The longest turn of a Newton step, rad.
LONGEST_TURN: Final = 0.3
#: Tilts from which the search begins anew, rad, smallest first: those of a row together, which is faster for few poses.
STARTS: Final = np.array([side * 0.1 * k for k in range(1, 11) for side in (1, -1)]).reshape(4, 5)
#: From there steps are no longer than this, rad: a longer one can leave the tilts at which every rod reaches.
SHORT_TURN: Final = 0.05
#: Smallest measure of the Jacobian at home: a singular one is some 1e-17.
SINGULAR: Final = 1e-6
#: How far from home the rods are tried when a machine is loaded, over the shortest rod.
TRIED: Final = (-0.1, 0.0, 0.1)
_IN_PLACE: Final = np.zeros(3)


class RodsModule(RodGeometry, frozen=True, dict=True, eq=False):
    """Implements ``ParallelModule``, ``RodModule`` and ``Drawable``.

    Raises
    ------
    ValueError
        At home the rods are open or the Jacobian is singular; away from home they stay open or close in another pose.
    """

    def __post_init__(self) -> None:
        home = np.array(self.home, dtype=float)
        asked, drops2 = self.find_sliders(home, np.zeros(()), self.ends)
        if not (drops2 > 0).all():
            k = int(np.argmin(drops2))
            raise ValueError(
                f"{self.key}, value {k + 1}: at home it is {math.sqrt(-drops2[k]):.6g} mm too short to reach its rail"
            )
        gaps = asked - asked[self.first_rods][self.slider_of]
        if np.abs(gaps).max() > CLOSED:
            k = int(np.argmax(np.abs(gaps)))
            other = int(self.first_rods[self.slider_of[k]])
            first, second = (
                f"value {one + 1} (platform {list(rod.platform)}, slider {list(rod.slider)}, length {rod.length:g}) at "
                f"{asked[one]:.6f}"
                for one, rod in ((other, self.rod[other]), (k, self.rod[k]))
            )
            raise ValueError(
                f"{self.key}, value {other + 1} and value {k + 1}: these two rods of {self.rod[k].by} do not fit each "
                f"other: at home {first}, {second}; correct the one that is not as drawn"
            )
        measure = abs(float(self._measure(home, np.zeros(()), asked[self.first_rods])))
        if not measure > SINGULAR:
            raise ValueError(
                f"at home the rods leave the platform free to move: their Jacobian is singular ({measure:.1g})"
            )
        self._try_around_home(home)

    def _try_around_home(self, home: Array) -> None:
        """Refuse rods that do not close around home, or whose sliders lead to another pose than the way from home."""
        shares = np.array(list(product(TRIED, repeat=3)))
        points = home + shares * self.shortest_rod
        rho, alpha, ok = self.inverse(points)
        drops = self.find_sliders(points, np.zeros(len(points)), self.ends)[1]
        open_ = ~ok & (drops > 0).all(axis=-1)
        if open_.all() or (open_ & (np.abs(shares).sum(axis=-1) < 0.15)).any():
            raise ValueError(
                "away from home the rods do not close with a platform that tilts about x alone; other turns are not "
                "executed over a tilting rotary table"
            )
        pose = np.concatenate([points[ok], alpha[ok, None]], axis=-1)
        way, (found, reached) = follow_from_home(self, rho[ok]), find_poses(self, rho[ok])
        if not reached.all() or max(np.abs(one - pose).max() for one in (way, found)) > CLOSED:
            raise ValueError(
                "near home the same slider positions allow more than one position of the platform: choose another home"
            )

    # --- inverse -----------------------------------------------------------------------------------------------

    def _solve(self, centre: Array, arms: Array) -> tuple[Array, Array, Mask, Mask]:
        """Sliders (..., 3) and tilt (...) of ``P = centre + Rx(alpha) (arm - a)``; whether closed, and the machine's.

        Where a rod does not reach at tilt 0 the search begins at larger tilts, until it finds the machine's own.
        """
        shape = np.broadcast_shapes(centre.shape[:-1], arms.shape[:-2])
        with np.errstate(all="ignore"):
            found = self._solve_from(centre, arms, np.zeros(shape))
            if self.tilts and not found[3].all():
                centre, arms = np.broadcast_to(centre, (*shape, 3)), np.broadcast_to(arms, (*shape, 6, 3))
                for starts in STARTS:
                    left = ~found[3]
                    n = np.arange(np.count_nonzero(left))
                    alpha = np.repeat(starts[:, None], len(n), axis=1)
                    again = self._solve_from(
                        np.tile(centre[left], (len(starts), 1, 1)), np.tile(arms[left], (len(starts), 1, 1, 1)), alpha
                    )
                    closed, own = again[2:]
                    which = np.where(own.any(axis=0), own.argmax(axis=0), len(starts) - 1 - closed[::-1].argmax(axis=0))
                    for kept, new in zip(found, again, strict=True):
                        some = closed.any(axis=0).reshape(-1, *[1] * (new.ndim - 2))
                        kept[left] = np.where(some, new[which, n], kept[left])
        return found

    def _solve_from(self, centre: Array, arms: Array, alpha: Array) -> tuple[Array, Array, Mask, Mask]:
        """:meth:`_solve` from one tilt (...) on."""
        if self.tilts:
            alpha = self._find_tilt(centre, arms, alpha, LONGEST_TURN if not alpha.any() else SHORT_TURN)
        sliders, drops2 = self.find_sliders(centre, alpha, arms)
        rho = sliders[..., self.first_rods]
        misses = np.abs(sliders - rho[..., self.slider_of]) > CLOSED
        closed: Mask = np.array(~(misses | ~(drops2 > 0)).any(axis=-1))
        position = centre + rotate_x(arms[..., 0, :] - self.ends[0], alpha)
        return rho, np.array(alpha), closed, np.array(closed & self._is_own(position, alpha, rho))

    def _find_tilt(self, centre: Array, arms: Array, alpha: Array, longest: float) -> Array:
        """The tilt at which the rods of each actuator ask for the same slider: Newton from ``alpha``, least squares."""
        for _ in range(STEPS):
            turned = rotate_x(arms, alpha[..., None])
            away = centre[..., None, :] + turned - self.feet
            sliders, drops2 = self.move_sliders(away)
            gaps = sliders - sliders[..., self.first_rods][..., self.slider_of]
            rods = away - sliders[..., None] * self.rails
            rates = (rods[..., 2] * turned[..., 1] - rods[..., 1] * turned[..., 2]) / (self.sides * np.sqrt(drops2))
            rates = rates - rates[..., self.first_rods][..., self.slider_of]
            step = (gaps * rates).sum(axis=-1) / (rates**2).sum(axis=-1)
            alpha = alpha - np.clip(step, -longest, longest)
            if not (np.abs(step) * self.arm > STILL).any():
                break
        return alpha

    def _is_own(self, position: Array, alpha: Array, rho: Array) -> Mask:
        """Whether closed rods are the machine's: little tilt, and the sign of the Jacobian that home has."""
        own = np.isfinite(rho).all(axis=-1) & (np.abs(alpha) < RAD_PER_DEG * self.largest_tilt_deg)
        return np.asarray(own & (np.linalg.det(self._scale_jacobian(position, alpha, rho)) * self._home_sign > 0))

    def inverse(self, position: Array) -> tuple[Array, Array, Mask]:
        """Sliders (..., 3), tilt and ok for positions (..., 3) of P, in the working mode of home."""
        return _mark(*self._solve(np.asarray(position, dtype=float), self.ends))

    def solve_coupled(self, pivot: Array, gauge: Array) -> tuple[Array, Array, Mask]:
        """Sliders, tilt and ok for ``P = pivot + F Rx(alpha) gauge``; see ``ParallelModule``."""
        return _mark(*self._solve(np.asarray(pivot, dtype=float), self._carry_arms(gauge)))

    def _carry_arms(self, gauge: Array) -> Array:
        """Joints of the platform (..., 6, 3) seen from the pivot, at tilt 0; F commutes with turns about x."""
        return place_upright(_IN_PLACE, gauge)[..., None, :] + self.ends

    def explain_unreachable(self, pivot: Array, gauge: Array) -> list[str]:
        """Finding codes of poses (m, 3) without a solution: VP110, rods stay open; VP203, a parallel singularity."""
        closed = self._solve(np.asarray(pivot, dtype=float), self._carry_arms(gauge))[2]
        return ["VP203" if one else "VP110" for one in closed]

    def explain_places(self, position: Array) -> list[str]:
        """As :meth:`explain_unreachable`, for positions (m, 3) of P."""
        closed = self._solve(np.asarray(position, dtype=float), self.ends)[2]
        return ["VP203" if one else "VP110" for one in closed]

    # --- forward -----------------------------------------------------------------------------------------------

    def forward(self, rho: Array) -> tuple[Array, Array, Mask]:
        """Position (..., 3) of P, tilt and ok for sliders (..., 3): the assembly that home leads to."""
        sliders = np.asarray(rho, dtype=float)
        pose, ok = find_poses(self, sliders.reshape(-1, 3))
        pose, ok = pose.reshape(*sliders.shape[:-1], 4), ok.reshape(sliders.shape[:-1])
        return pose[..., :3], pose[..., 3], ok

    def find_first(self) -> tuple[Array, Array]:
        """See ``Held``: a pose is P and the tilt (4,)."""
        return np.array([*self.home, 0.0]), self.inverse(np.array(self.home))[0]

    def differentiate(self, pose: Array, values: Array) -> tuple[Array, Array]:
        """See ``Held``: least squares over the six rods."""
        rods, rows = self._differentiate_rods(pose[:, :3], pose[:, 3], values)
        misfit = 0.5 * ((rods**2).sum(axis=-1) / self.rod_lengths - self.rod_lengths)
        across = rows.swapaxes(-1, -2)
        return across @ rows, (across @ misfit[:, :, None])[..., 0]

    def move_back(self, pose: Array, step: Array) -> tuple[Array, Array]:
        """See ``Held``."""
        step = step * np.minimum(1.0, LONGEST_TURN * self.arm / np.abs(step[:, 3]))[:, None]
        return pose - step / [1.0, 1.0, 1.0, self.arm], np.abs(step).max(axis=-1) / self.shortest_rod

    def is_closed(self, pose: Array, values: Array) -> Mask:
        """See ``Held``: every rod on its side of home."""
        rods = self.find_vectors(pose[:, :3], pose[:, 3], values)
        closed = (np.abs(np.linalg.norm(rods, axis=-1) - self.rod_lengths) <= CLOSED).all(axis=-1)
        on_side = ((rods * self.rails).sum(axis=-1) * self.sides > 0).all(axis=-1)
        return closed & on_side & self._is_own(pose[:, :3], pose[:, 3], values)

    def _differentiate_rods(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Rod vectors (..., 6, 3), and derivatives (..., 6, 4) of their lengths by P and by the tilt times the arm."""
        rods = self.find_vectors(position, alpha, rho)
        by_tilt = (rods * rotate_x_rate(self.ends, alpha[..., None])).sum(axis=-1, keepdims=True) / self.arm
        return rods, np.concatenate([rods, by_tilt], axis=-1) / self.rod_lengths[:, None]

    # --- every solution that is known ----------------------------------------------------------------------------

    def inverse_all(self, position: Array) -> list[InverseSolution]:
        """The solution in use of one position (3,); others have no closed form."""
        return self._list_solution(*self.inverse(position))

    def solve_coupled_all(self, pivot: Array, gauge: Array) -> list[InverseSolution]:
        """The solution in use of one gauge point (3,)."""
        return self._list_solution(*self.solve_coupled(pivot, gauge))

    def _list_solution(self, rho: Array, alpha: Array, ok: Mask) -> list[InverseSolution]:
        signs = tuple(int(-side) for side in self.sides[self.first_rods])
        return [InverseSolution(float(alpha), signs, make_triple(rho), None)] if ok else []

    def forward_all(self, rho: Array) -> list[ForwardSolution]:
        """The assembly in use of one set of sliders (3,)."""
        position, alpha, ok = self.forward(rho)
        return [ForwardSolution(make_triple(position), float(alpha), None)] if ok else []

    # --- velocities, margins -------------------------------------------------------------------------------------

    def _scale_jacobian(self, position: Array, alpha: Array, rho: Array) -> Array:
        """Derivatives (..., 6, 6) of rod lengths by all six motions of the platform, turns times its mean radius."""
        unit = self.find_vectors(position, alpha, rho) / self.rod_lengths[:, None]
        arms = rotate_x(np.broadcast_to(self.ends - self.ends.mean(axis=0), unit.shape), alpha[..., None])
        return np.concatenate([unit, np.cross(arms, unit) / self.arm], axis=-1)

    @cached_property
    def _home_sign(self) -> float:
        """Sign of the Jacobian's determinant at home."""
        rho = self.find_sliders(np.array(self.home, dtype=float), np.zeros(()), self.ends)[0][self.first_rods]
        return float(np.sign(np.linalg.det(self._scale_jacobian(np.array(self.home), np.zeros(()), rho))))

    def _measure(self, position: Array, alpha: Array, rho: Array) -> Array:
        """Signed 1 over the norm of the scaled Jacobian's inverse, at most its least singular value; smooth at 0."""
        return measure_singularity(self._scale_jacobian(position, alpha, rho))

    def find_jacobians(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Closure of the six rod lengths, projected on the four motions: (..., 4, 4) by pose, (..., 4, 3) by rho."""
        rods, rows = self._differentiate_rods(position, alpha, rho)
        by_slider = -(rods * self.rails).sum(axis=-1, keepdims=True) / self.rod_lengths[:, None]
        by_rho = by_slider * (self.slider_of[:, None] == np.arange(3))
        across = rows.swapaxes(-1, -2)
        return across @ (rows * [1.0, 1.0, 1.0, self.arm]), across @ by_rho

    def measure_conditioning(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        """Reciprocal condition numbers of the scaled Jacobian and of the rods' shares along the rails, each (...)."""
        parallel = find_reciprocal_condition(self._scale_jacobian(position, alpha, rho))
        shares = np.abs((self.find_vectors(position, alpha, rho) * self.rails).sum(axis=-1)) / self.rod_lengths
        return parallel, shares.min(axis=-1) / shares.max(axis=-1)

    def find_geometry_margins(self, position: Array, alpha: Array) -> Array:
        """Drops of rods along their rails (mm), one of each set of parallel rods, then the Jacobian's measure."""
        with np.errstate(all="ignore"):
            sliders, drops2 = self.find_sliders(position, np.asarray(alpha), self.ends)
            measure = self._home_sign * self._measure(position, np.asarray(alpha), sliders[..., self.first_rods])
        return np.concatenate([np.sqrt(np.maximum(drops2, 0.0))[..., self.distinct], measure[..., None]], axis=-1)

    def name_margins(self, serial_singularity: float, parallel_singularity: float) -> tuple[Margin, ...]:
        """What :meth:`find_geometry_margins` measures, with thresholds (mm; the Jacobian's measure has no unit)."""
        drops = [
            Margin(
                f"drop of rod {k + 1} along its rail",
                "VP202",
                self.rod[k].by,
                "mm",
                serial_singularity,
                2 * serial_singularity,
            )
            for k in self.distinct.tolist()
        ]
        what = "measure of the parallel Jacobian"
        return (*drops, Margin(what, "VP203", None, "", parallel_singularity, 2 * parallel_singularity))

    # --- the rods as bodies ----------------------------------------------------------------------------------------

    @property
    def rod_legs(self) -> tuple[str, ...]:
        """Name of the leg of each rod: the number of its actuator."""
        return tuple(rod.by.removeprefix("rho") for rod in self.rod)

    @property
    def parallelograms(self) -> tuple[str, ...]:
        """Legs whose rods stay parallel."""
        alone = [self.rod_legs[k] for k in self.distinct]
        return tuple(leg for leg in dict.fromkeys(alone) if alone.count(leg) == 1)

    def find_rod_directions(self, position: Array) -> tuple[Array, Array]:
        """Directions of the rods (6, 3) at a position (3,) of P: in the base frame, and in the platform's."""
        rho, alpha, _ok = self.inverse(position)
        unit = self.find_vectors(position, alpha, rho) / self.rod_lengths[:, None]
        return unit, rotate_x(unit, -alpha)

    def find_rod_ends(self, rho: Array, platform: Platform) -> tuple[Array, Array]:
        """Ends of the rods at slider and platform, each (n, 6, 3), base frame, mm."""
        return self._find_ends(platform.position, platform.alpha, rho)

    def _find_ends(self, position: Array, alpha: Array, rho: Array) -> tuple[Array, Array]:
        end = position[:, None, :] + rotate_x(np.broadcast_to(self.ends, (len(rho), 6, 3)), alpha[:, None])
        return end - self.find_vectors(position, alpha, rho), end

    def sketch(self, position: Array, alpha: Array, rho: Array) -> Array:
        """Rods (n, 6, 2, 3) for a picture."""
        return np.stack(self._find_ends(position, alpha, rho), axis=-2)


def _mark(rho: Array, alpha: Array, _closed: Mask, ok: Mask) -> tuple[Array, Array, Mask]:
    """Sliders, tilt and ok; NaN where not ok."""
    return np.where(ok[..., None], rho, np.nan), np.where(ok, alpha, np.nan), ok
