"""The profile that planning starts from: the second-order optimum, smoothed, sampled in time; its time is a bound.

A section of any length is taken part by part.
"""

from collections.abc import Callable, Iterator

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.columns import Growing, release_memory
from verne_post.base.team import ALONE, Team, split_evenly
from verne_post.model.machine import Limits
from verne_post.trajectory import reachability, tuning
from verne_post.trajectory.cruise import find_cruise
from verne_post.trajectory.section_path import Grid, Section, build_grid_along, divide_grid, join_grids
from verne_post.trajectory.spline_profile import Profile

#: Solvers of the second-order problem: grid, limits, and the x to start with; see ``reachability.solve``.
Solver = Callable[..., Array]


def bound_second_order_time(section: Section, limits: Limits, solver: Solver, team: Team = ALONE) -> float:
    """Time of the second-order optimum of a section, s; the processes of a ``team`` evaluate its joints."""
    bound, x_end = 0.0, 0.0
    for end, grid in _build_grids(section, team):
        x = solver(grid, limits, start=x_end)
        seconds, x_end = _find_least_seconds(grid, limits, x, end)
        bound += seconds
    return bound


def _find_least_seconds(grid: Grid, limits: Limits, x: Array, end: float) -> tuple[float, float]:
    """Time of the second-order optimum x = sd^2 (n,) up to ``end`` by s, in seconds, and x there."""
    s, fastest = _keep_before(grid, x, end)
    _s, steepest = _keep_before(grid, reachability.find_accelerations(grid, limits, x), end)
    return reachability.bound_duration(s, fastest, steepest), float(fastest[-1])


class InitialProfile(Struct, frozen=True, eq=False):
    """A profile, its unit of time (s), the time of the second-order optimum (s), and its ranges of cruise (k, 2)."""

    profile: Profile
    unit: float
    bound: float
    cruise: Array


def plan_initial_profile(
    section: Section, limits: Limits, unit: float, solver: Solver, team: Team = ALONE
) -> InitialProfile:
    """The second-order optimum sampled in time, averaged so that it starts and ends at rest smoothly.

    The section is taken part by part, each with a look-ahead that ends at rest. Where even motion would take far more
    than the jerk allowed, the profile is cut off to that speed; the passes find how it gets there. The processes of a
    ``team`` evaluate the joints.
    """
    smooth = _Smooth(tuning.START_SMOOTH)
    smooth.add(np.zeros(tuning.START_SMOOTH))
    t_end, bound, x_end = 0.0, 0.0, 0.0
    cruise = []
    for end, grid in _build_grids(section, team):
        x = solver(grid, limits, start=x_end)
        cruise.append(np.minimum(find_cruise(grid, x, limits, unit), end))
        seconds, x_end = _find_least_seconds(grid, limits, x, end)
        bound += seconds
        s, x = _keep_before(grid, np.minimum(x, tuning.START_JERK_EXCESS * reachability.limit_jerk(grid, limits)), end)
        x = x / tuning.START_SLOWER**2
        if len(cruise) == 1:
            unit *= min(
                max(
                    (reachability.find_duration(s, x) / unit + tuning.SHORT_SECTION) / tuning.LONG_SECTION,
                    tuning.FINEST_UNIT,
                ),
                1.0,
            )
        part, t_end = _sample_profile(s, x, tuning.START_STEP * unit, t_end)
        smooth.add(part)
    smooth.add(np.full(tuning.START_SMOOTH, section.length))
    smooth.averages.extend(np.array([max(smooth.largest, section.length)]))
    profile = Profile.build_from_samples(smooth.averages.freeze(), tuning.START_STEP * unit)
    return InitialProfile(profile, unit, bound, np.concatenate(cruise))


class _Smooth:
    """Averages of each so many neighbouring samples, which are added part by part; they never fall."""

    def __init__(self, count: int) -> None:
        self.kernel, self.last, self.largest = np.full(count, 1.0 / count), np.empty(0), 0.0
        self.averages = Growing(float)

    def add(self, samples: Array) -> None:
        known = np.concatenate([self.last, samples])
        if len(known) >= len(self.kernel):
            averages = np.append(self.largest, np.convolve(known, self.kernel, mode="valid"))
            averages = np.maximum.accumulate(averages)[1:]
            self.averages.extend(averages)
            self.largest = float(averages[-1])
        self.last = known[-len(self.kernel) + 1 :]


def _build_grids(section: Section, team: Team) -> Iterator[tuple[float, Grid]]:
    """How far every part reaches (s, mm), and the grid along it and what it looks ahead to."""

    def make_grid(piece: tuple[int, int]) -> Grid:
        release_memory()
        return build_grid_along(section, *piece)

    part: list[Grid] = []
    for grid in team.map(make_grid, split_evenly(len(section.breaks) - 1, tuning.GRID_ELEMENTS)):
        for piece in divide_grid(grid, tuning.GRID_POINTS // 2):
            if len(part) == tuning.GRID_PIECES or sum(len(each.s) - 2 for each in (*part, piece)) > tuning.GRID_POINTS:
                yield float(piece.s[0]), join_grids([*part, piece])
                part = []
            part.append(piece)
    yield section.length, join_grids(part)


def _keep_before(grid: Grid, x: Array, end: float) -> tuple[Array, Array]:
    """Grid points s and x = sd^2 of a profile, without what it does beyond ``end``, where it looks ahead."""
    kept = grid.s < end
    # even acceleration between grid points: x is linear in s
    return np.append(grid.s[kept], end), np.append(x[kept], np.interp(end, grid.s, x))


def _sample_profile(s: Array, x: Array, step: float, begin: float) -> tuple[Array, float]:
    """Positions at the multiples of ``step`` in a profile that begins at time ``begin``, and when it ends."""
    speed = np.sqrt(x)
    dt = 2 * np.diff(s) / (speed[:-1] + speed[1:])
    t = begin + np.append(0.0, np.cumsum(dt))
    at = step * np.arange(np.ceil(begin / step), np.ceil(t[-1] / step))
    interval = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(dt) - 1)
    tau = np.minimum(at - t[interval], dt[interval])
    acceleration = (speed[interval + 1] - speed[interval]) / np.maximum(dt[interval], np.finfo(float).tiny)
    return np.clip(s[interval] + speed[interval] * tau + 0.5 * acceleration * tau**2, s[0], s[-1]), float(t[-1])
