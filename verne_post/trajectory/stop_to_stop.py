"""Motion profiles of sections that begin and end at rest: one scalar profile s(t) for each section.

Along a section each joint is a smooth function q(s), so

    qd = q' sd,   qdd = q'' sd^2 + q' sdd,   qddd = q''' sd^3 + 3 q'' sd sdd + q' sddd.

With the largest |q'|, |q''|, |q'''| over the section, a profile that obeys scalar limits V, A, J on s keeps
every joint inside its limits when for each joint

    |q'| V <= v,   |q''| V^2 + |q'| A <= a,   |q'''| V^3 + 3 |q''| V A + |q'| J <= j.

How the limits are split between the terms is free; the split that takes the least time is chosen.
"""

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.base.ragged import number_parts
from verne_post.model.contour import Contour
from verne_post.model.findings import SolverError, make_finding
from verne_post.model.machine import Limits
from verne_post.trajectory import tuning
from verne_post.trajectory.ruckig_backend import plan_rest_to_rest
from verne_post.trajectory.visible import limit_visible_speed


class StopToStopProfiles(Struct, frozen=True, eq=False):
    """Profile s(t) of each section: seven phases of constant jerk, from rest to rest.

    ``durations`` and ``jerks`` have shape (n_sections, 7); s in mm (metric length), t in s.
    """

    durations: Array
    jerks: Array
    length: Array

    @property
    def total(self) -> Array:
        """Duration of each section, s."""
        return self.durations.sum(axis=1)

    def slow_down(self, factor: Array) -> "StopToStopProfiles":
        """The same profiles, each taking ``factor`` (n_sections,) times as long."""
        return replace(self, durations=self.durations * factor[:, None], jerks=self.jerks / factor[:, None] ** 3)

    def find_peak_speed(self) -> Array:
        """Largest speed ds/dt of each section, mm/s."""
        speed = np.zeros(len(self.length))
        v, a = np.zeros(len(self.length)), np.zeros(len(self.length))
        for phase in range(7):
            dt, j = self.durations[:, phase], self.jerks[:, phase]
            with np.errstate(divide="ignore", invalid="ignore"):
                turning = np.clip(np.where(j != 0, -a / j, 0.0), 0.0, dt)  # where the acceleration changes sign
            speed = np.maximum(speed, v + turning * (a + turning * j / 2))
            v = v + dt * (a + dt * j / 2)
            a = a + dt * j
            speed = np.maximum(speed, v)
        return speed

    def find_position(self, section: NDArray[np.integer], t: Array) -> Array:
        """Path parameter s (n,) at times t (n,) after the start of sections (n,)."""
        durations, jerks = self.durations[section], self.jerks[section]
        s, v, a = np.zeros(len(t)), np.zeros(len(t)), np.zeros(len(t))
        left = t.copy()
        for phase in range(7):
            dt = np.clip(left, 0.0, durations[:, phase])
            j = jerks[:, phase]
            s += dt * (v + dt * (a / 2 + dt * j / 6))
            v += dt * (a + dt * j / 2)
            a += dt * j
            left -= dt
        return np.clip(s, 0.0, self.length[section])


def plan_sections(
    contour: Contour, first: Array, second: Array, third: Array, limits: Limits, wanted: NDArray[np.bool_], cycle: float
) -> StopToStopProfiles:
    """Plan the sections of a contour from stop to stop.

    Parameters
    ----------
    first, second, third : ndarray, shape (n, n_joints)
        Largest derivatives of the joints by w over the elements of the sections that are wanted, one after the other.
    wanted : ndarray of bool, shape (n_sections,)
        Sections to plan; the others get a profile of no duration.
    cycle : float
        Control cycle, s.

    Raises
    ------
    SolverError
        Naming the source line of the first section without a profile.
    """
    begins = contour.section_begins
    n_sections = len(begins) - 1
    durations, jerks, distance = np.zeros((n_sections, 7)), np.zeros((n_sections, 7)), np.zeros(n_sections)
    chosen = np.flatnonzero(wanted)
    done = 0
    for start in range(0, len(chosen), tuning.AT_A_TIME):
        chunk = chosen[start : start + tuning.AT_A_TIME]
        count = begins[chunk + 1] - begins[chunk]
        owner, place = number_parts(count)
        element, at = begins[chunk][owner] + place, np.cumsum(count) - count
        length, bounds = contour.length[element], slice(done, done + len(element))
        done = bounds.stop
        slope = [
            np.maximum.reduceat(d[bounds] / length[:, None] ** k, at)
            for k, d in enumerate((first, second, third), start=1)
        ]
        with np.errstate(divide="ignore"):
            cap = np.minimum(
                1.0 / contour.find_pace(element), limit_visible_speed(contour, element, np.zeros(len(element)), cycle)
            )
        cap = np.minimum.reduceat(cap, at)
        distance[chunk] = np.add.reduceat(length, at)
        v, a, j = split_limits(distance[chunk], cap, slope[0], slope[1], slope[2], limits)
        durations[chunk], jerks[chunk] = plan_rest_to_rest(distance[chunk], v, a, j)
    lost = np.flatnonzero(~np.isfinite(durations).all(axis=1))
    if len(lost):
        line = int(contour.find_lines(begins[lost[:1]])[0])
        raise SolverError(
            make_finding(
                "VP420",
                f"no feasible motion profile for the motion of line {line}",
                line=line,
                count=len(lost),
            )
        )
    return StopToStopProfiles(durations, jerks, distance)


def split_limits(
    distance: Array, speed_cap: Array, d1: Array, d2: Array, d3: Array, limits: Limits
) -> tuple[Array, Array, Array]:
    """Scalar limits V, A, J on s that keep every joint inside its limits, for the least time.

    Parameters
    ----------
    distance, speed_cap : ndarray, shape (n,)
        mm and mm/s; the cap is the feed, infinite for rapids.
    d1, d2, d3 : ndarray, shape (n, n_joints)
        Largest |q'|, |q''|, |q'''|.

    Returns
    -------
    V, A, J : ndarray, shape (n,)
    """
    velocity, acceleration, jerk = (
        tuning.STOP_TO_STOP_SHARE * x for x in (limits.velocity, limits.acceleration, limits.jerk)
    )
    d1 = np.maximum(d1, np.finfo(float).tiny)
    with np.errstate(divide="ignore", over="ignore"):
        top = np.minimum(speed_cap, (velocity / d1).min(axis=1))
        top = np.minimum(top, np.sqrt(acceleration / d2).min(axis=1))
        top = np.minimum(top, np.cbrt(jerk / d3).min(axis=1))
    best = np.full((4, len(distance)), np.inf)
    for speed_share in tuning.SPEED_SHARES:
        v = top * speed_share
        with np.errstate(over="ignore"):
            a_top = ((acceleration - d2 * (v * v)[:, None]) / d1).min(axis=1)
            j_left = jerk - d3 * (v**3)[:, None]
            for share in tuning.ACCELERATION_SHARES:
                a = a_top * share
                j = ((j_left - 3 * d2 * (v * a)[:, None]) / d1).min(axis=1)
                usable = (a > 0) & (j > 0)
                time = find_duration(distance, v, np.where(usable, a, 1.0), np.where(usable, j, 1.0))
                time = np.where(usable, time, np.inf)
                better = time < best[0]
                best = np.where(better, np.stack([time, v, a, j]), best)
    return best[1], best[2], best[3]


def find_duration(distance: Array, v: Array, a: Array, j: Array) -> Array:
    """Time of the rest-to-rest profile under limits v, a, j, in closed form; all shape (n,)."""
    reaches_a = v * j >= a * a
    ramp = np.where(reaches_a, v / a + a / j, 2 * np.sqrt(v / j))
    cruising = distance / v + ramp
    peak = 0.5 * (-a * a / j + np.sqrt((a * a / j) ** 2 + 4 * a * distance))
    trapezoid = 2 * (peak / a + a / j)
    triangle = 4 * np.cbrt(distance / (2 * j))
    short = np.where(distance >= 2 * a**3 / j**2, trapezoid, triangle)
    return np.where(distance >= v * ramp, cruising, short)
