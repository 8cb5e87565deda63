"""Finds the shapes of corner blends in verne_post/toolpath/corner_shapes.py, and prints their tables.

Each shape is sought together with the motion profiles that pass its corners, as one nonlinear program (CasADi and
IPOPT, of the extra ``bench``): a plane, two equal joints, limits on acceleration and jerk, a tolerance on both sides of
the path. The profile is a jerk constant between places x of the blend, the time from place to place unknown; the shape
is two polynomials of degree 7 over half of the blend. The reach of a shape is given, ``rho tolerance / sin(angle)``,
and the least time is sought:

* wide shapes: of single corners of 30 to 120 degrees between long lines, which the tool brakes for;
* narrow ones: of zigzags and polygons of 10 degrees whose segments are a little shorter than the reach, so that blends
  overlap.

The functions that take out jumps of the second and third derivative are one polynomial of degree 7 on each side with
two numbers left, which are found by direct search.

    python tests/benchmarks/corner_shapes.py
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import casadi
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.linalg import null_space
from scipy.optimize import minimize

Array = NDArray[np.float64]

#: mm, mm/s2, mm/s3. Only the ratio of the feed rate to (jerk tolerance^2)^(1/3) matters while acceleration is no limit.
TOLERANCE: Final = 0.0097
ACCELERATION: Final = 4e3
JERK: Final = 8e4
#: Where both polynomials of a half meet.
KNEE: Final = 0.25
#: Places of a profile inside a blend and beyond it.
INSIDE: Final = 50
BEYOND: Final = 25
#: Overlapping blends reach over so many corners on each side at most.
NEIGHBOURS: Final = 3
LONGEST_S: Final = 60.0

_KNOTS: Final = np.concatenate([np.zeros(8), np.full(4, KNEE), np.ones(8)])
_BASIS: Final = [BSpline(_KNOTS, np.eye(12), 7)]
for _order in range(3):
    _BASIS.append(_BASIS[-1].derivative())


@dataclass(frozen=True)
class Case:
    """Corners that a shape is to pass fast.

    Attributes
    ----------
    angle_deg : float
        By which the path turns.
    feed : float
        mm/s.
    overlap : float
        Reach over the length of the segments; 0 for a single corner.
    alternate : bool
        The path turns to both sides by turns, or always to the same.
    weight : float
    """

    angle_deg: float
    feed: float
    overlap: float = 0.0
    alternate: bool = True
    weight: float = 1.0


WIDE: Final = [Case(30, 50), Case(60, 50), Case(90, 50), Case(120, 50)]


def narrow(feed: float) -> list[Case]:
    """Overlapping corners."""
    return [
        Case(10, feed, overlap, alternate, 2.0 if alternate else 1.0)
        for overlap in (1.05, 1.25, 1.5)
        for alternate in (True, False)
    ]


def displacement(x: Array, case: Case) -> list[casadi.DM]:
    """What all blends add at x, and its first three derivatives: matrices over the coefficients of the shape."""
    rows = [np.zeros((len(x), 12)) for _ in _BASIS]
    for corner in range(-NEIGHBOURS, NEIGHBOURS + 1) if case.overlap else (0,):
        away = x - (corner / case.overlap if case.overlap else 0.0)
        turn = (-1.0) ** corner if case.alternate else 1.0
        side = np.where(away >= 0, 1.0, -1.0)
        for order, basis in enumerate(_BASIS):
            values = basis(np.minimum(np.abs(away), 1.0))
            rows[order] += (turn * (np.abs(away) < 1.0) * side**order)[:, None] * values
    return [casadi.DM(row) for row in rows]


def add_case(problem: Any, shape: Any, case: Case, rho: float) -> Any:
    """Constrain a shape and the profile of half a corner (the other half is its mirror image); returns the time lost,
    s.
    """
    angle, half = np.radians(case.angle_deg), np.radians(case.angle_deg) / 2
    reach, unit = rho * TOLERANCE / np.sin(angle), (TOLERANCE / JERK) ** (1 / 3)
    beyond = 0 if case.overlap else BEYOND
    x = np.linspace(0.0, 0.5 / case.overlap, INSIDE + 1) if case.overlap else np.linspace(0.0, 1.0, INSIDE + 1) ** 1.5
    n = INSIDE + beyond
    v, a, j, t = (problem.variable(n + extra) for extra in (1, 1, 0, 0))
    speed, acceleration, jerk, time = case.feed * v, ACCELERATION * a, JERK * j, unit * t
    step = casadi.DM(reach * np.diff(x))
    if beyond:
        lead = problem.variable()
        problem.subject_to(lead >= 1e-4)
        problem.set_initial(lead, 2.0)
        step = casadi.vertcat(step, lead * casadi.DM(np.full(beyond, 1.0 / beyond)))
        for limited in (j[INSIDE:], a[INSIDE:]):
            problem.subject_to(problem.bounded(-1, limited, 1))
        problem.subject_to(v[n] == 1)
    problem.subject_to(speed[1:] == speed[:-1] + acceleration[:-1] * time + jerk * time**2 / 2)
    problem.subject_to(acceleration[1:] == acceleration[:-1] + jerk * time)
    moved = speed[:-1] * time + acceleration[:-1] * time**2 / 2 + jerk * time**3 / 6
    problem.subject_to(step / (case.feed * unit) == moved / (case.feed * unit))
    for end in (a[0], a[n]):
        problem.subject_to(end == 0)
    problem.subject_to(problem.bounded(0.01, v, 1.0))
    problem.subject_to(t >= 0)
    at_ends = [row @ shape for row in displacement(x, case)]
    middle = [row @ shape for row in displacement((x[1:] + x[:-1]) / 2, case)]
    inner = slice(0, INSIDE)
    h = time[inner] / 2
    states = (
        (speed[inner], acceleration[inner], [row[:-1] for row in at_ends]),
        (
            speed[inner] + acceleration[inner] * h + jerk[inner] * h**2 / 2,
            acceleration[inner] + jerk[inner] * h,
            middle,
        ),
        (speed[1 : INSIDE + 1], acceleration[1 : INSIDE + 1], [row[1:] for row in at_ends]),
    )
    # components of the displacement along and across the leaving leg; joints along both legs of a right angle
    along, across = 2 * np.sin(half) ** 2, np.sin(angle)
    for velocity, accelerated, row in states:
        slope, curvature, third = row[1], row[2] / reach, row[3] / reach**2
        bent = third * velocity**3 + 3 * curvature * velocity * accelerated + slope * jerk[inner]
        pulled = curvature * velocity**2 + slope * accelerated
        leaving = ((jerk[inner] + along * bent, across * bent), (accelerated + along * pulled, across * pulled))
        for (ahead, aside), limit, mirror in zip(leaving, (JERK, ACCELERATION), (1.0, -1.0), strict=True):
            # the arriving half: its part along the chord changes sign with time as its derivative's order says
            chord = np.cos(half) * ahead - np.sin(half) * aside
            bisector = np.sin(half) * ahead + np.cos(half) * aside
            for part, rest in ((chord, bisector), (mirror * chord, -mirror * bisector)):
                for joint in (
                    np.cos(half) * part + np.sin(half) * rest,
                    -np.sin(half) * part + np.cos(half) * rest,
                ):
                    problem.subject_to(problem.bounded(-1, joint / limit, 1))
    alone = casadi.DM(_BASIS[0](np.linspace(0, 1, 60))) @ shape
    for off in (at_ends[0], alone):
        problem.subject_to(problem.bounded(-1, across * reach * off / TOLERANCE, 1))
    problem.set_initial(v, 0.6 if case.overlap else np.linspace(0.25, 1.0, n + 1))
    problem.set_initial(t, 0.1)
    return casadi.sum1(time) - casadi.sum1(step) / case.feed


def find_shape(cases: list[Case], rho: float) -> tuple[Array, list[float]]:
    """The numbers of a shape as in the table, and the time that each corner loses against its feed rate, ms."""
    # 0 with three derivatives at 1, the slope of the kink and no third derivative at 0
    given = np.array([*(basis(1.0) for basis in _BASIS), _BASIS[1](0.0), _BASIS[3](0.0)])
    particular = np.linalg.lstsq(given, np.array([0, 0, 0, 0, -0.5, 0]), rcond=None)[0]
    free = null_space(given)
    problem = casadi.Opti()
    unknown = problem.variable(free.shape[1])
    shape = casadi.DM(particular) + casadi.DM(free) @ unknown
    lost = [2e3 * add_case(problem, shape, case, rho) for case in cases]
    problem.minimize(sum(case.weight * one for case, one in zip(cases, lost, strict=True)))
    quiet = {"print_level": 0, "sb": "yes", "max_iter": 400, "tol": 1e-6, "max_wall_time": LONGEST_S}
    problem.solver("ipopt", {"print_time": 0}, quiet)
    solution = problem.solve()
    found = np.asarray(solution.value(shape)).ravel()
    numbers = [_BASIS[0](0.0) @ found, _BASIS[2](0.0) @ found, *(basis(KNEE) @ found for basis in _BASIS)]
    return np.array(numbers), [float(solution.value(one)) for one in lost]


def find_jump_function(order: int, goal: Callable[[float, float], float], guess: tuple[float, float]) -> Array:
    """Value and first three derivatives at 0 of the function that takes out a jump of a derivative, best by a goal.

    ``goal`` is of its largest value and largest third derivative; ``guess`` are the two numbers that are free.
    """
    powers = [np.polynomial.polynomial.polyder(np.eye(8), k) for k in range(4)]
    conditions = np.vstack([[np.polynomial.polynomial.polyval(x, row) for row in powers] for x in (0.0, 1.0)])
    places = np.linspace(0.0, 1.0, 801)

    def start(free: Array) -> Array:
        """An odd function has no value and half the jump at 0, an even one no slope."""
        return np.array([0.0, free[0], -0.5, free[1]] if order == 2 else [free[0], 0.0, free[1], -0.5])

    def measure(free: Array) -> float:
        found = np.linalg.solve(conditions, np.append(start(free), np.zeros(4)))
        third = np.polynomial.polynomial.polyder(found, 3)
        return goal(*(float(np.abs(np.polynomial.polynomial.polyval(places, c)).max()) for c in (found, third)))

    precise = {"xatol": 1e-10, "fatol": 1e-14, "maxiter": 8000}
    tried = [
        minimize(measure, factor * np.array(guess), method="Nelder-Mead", options=precise)
        for factor in (0.5, 0.9, 1.0, 1.5)
    ]
    return start(min(tried, key=lambda one: float(one.fun)).x)


def main() -> None:
    """Print the table of shapes, with the time lost at each case, and those of the functions for other jumps."""
    for rho, cases in ((13, narrow(50)), (18, narrow(50)), (26, narrow(100)), (36, WIDE), (48, WIDE), (62, WIDE)):
        numbers, lost = find_shape(cases, rho)
        print(
            f"    [{', '.join(f'{number:.6g}' for number in numbers)}],  # rho {rho}; ms lost:",
            ", ".join(f"{one:.1f}" for one in lost),
            flush=True,
        )
    for name, order, goal, guess in (
        ("odd, least third derivative", 2, lambda peak, third: third, (0.09, 1.4)),
        (
            "odd, least third derivative times root of the peak",
            2,
            lambda peak, third: third * np.sqrt(peak),
            (0.09, 1.4),
        ),
        (
            "even, third derivative of 1/2, least peak",
            3,
            lambda peak, third: peak + max(third - 0.5, 0.0),
            (-6e-4, 0.023),
        ),
    ):
        print(f"{name}:", ", ".join(f"{one:.6g}" for one in find_jump_function(order, goal, guess)), flush=True)


if __name__ == "__main__":
    main()
