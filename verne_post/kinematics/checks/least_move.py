"""The smallest move of a part that brings one line inside its limits: Newton's method on the limits.

The limits are linearised at the worst place of each (sliders by the Jacobian, the others by differences). The least
move that keeps them is taken, and so on until it stands.
"""

from collections.abc import Callable
from itertools import product
from math import hypot
from operator import mul
from typing import Final

import numpy as np
from msgspec import Struct, field

from verne_post.base.arrays import Array
from verne_post.base.least import find_least
from verne_post.base.stopping import check_wanted
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.kinematics.checks.line_measures import (
    find_solvable,
    iterate_measures,
    list_samples,
    measure_around,
    measure_solved,
    shift_line,
    solve_samples,
)
from verne_post.kinematics.checks.violations import Check
from verne_post.kinematics.joint_path import JointPath, Solved

#: Decimals of a proposed move, mm: a micrometre.
SHIFT_DECIMALS: Final = 3
#: Half the step of the differences that stand for the derivative of a margin by the tip, mm.
DIFFERENCE_MM: Final = 1e-3
#: Newton's method has settled when a step is shorter, mm.
SETTLED_MM: Final = 2e-3
#: Share of the reserve that the linearised limits may leave unused.
KEPT_RESERVE: Final = 0.9
#: Steps of Newton's method; the linearised problem is solved anew at each.
NEWTON_STEPS: Final = 20
#: Places at which one search linearises the limits: 346 moves that were found took at most 24, those in vain up to 100.
MOST_LINEARISED: Final = 32
#: Sweeps over the linearised limits in search of the smallest move that keeps them all.
SWEEPS: Final = 400
#: Distances at which a reachable place is sought when the line is out of reach, mm.
SOUGHT_MM: Final = (2.0, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0)
#: Those of another end that Newton's method does not find: it is no farther for a slip of a number.
NEAR_MM: Final = SOUGHT_MM[:7]
#: A line that is shorter than this, mm, is not what a person means by another end.
LEAST_WAY_MM: Final = 0.2


class MoveProblem(Struct, frozen=True, eq=False):
    """What is moved, and inside what."""

    line: JointPath
    checks: list[Check]  #: The limits to keep.
    basis: Array  #: (k, 3): Orthonormal directions in the table frame that the move may combine.
    end_only: bool  #: The end of a straight line moves alone.
    also_warnings: bool  #: Keep the weaker bounds too.
    farthest: float  #: Longest move, mm.
    #: How far inside its bound each check is (c,), and its derivative (c, k), at the moves that were tried.
    slopes: dict[tuple[float, ...], tuple[Array, Array]] = field(default_factory=dict)
    #: The smallest reserve that a move by a distance, mm, does not keep: larger ones are not kept either.
    refused: dict[float, float] = field(default_factory=dict)

    def move_part(self, shift: Array) -> JointPath:
        """The line after a move (3,), mm."""
        return shift_line(self.line, shift, self.end_only)


def find_start(problem: MoveProblem) -> Array | None:
    """The first small combination of the basis (3,) that makes the whole line solvable, zero if it is; None if none."""
    if solve_samples(problem.move_part(np.zeros(3))) is not None:
        return np.zeros(3)
    basis = problem.basis
    directions = np.array([signs for signs in product((-1, 0, 1), repeat=len(basis)) if any(signs)]) @ basis
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for distance in (one for one in SOUGHT_MM if one < problem.farthest):
        shifts = distance * directions
        # the ends and the middle first: most directions fail there
        for shift in shifts[find_solvable(problem.line, shifts, problem.end_only)]:
            if solve_samples(problem.move_part(shift)) is not None:
                return np.asarray(shift)
    return None


def find_move_along(problem: MoveProblem, reserve: float) -> Array | None:
    """The shorter move (3,) along the one direction of the basis, there or back; None if none is found.

    Newton's method finds none where the worst limit does not change along it, as beside a wall of a fixture. The
    move is halved between a place that keeps the limits and one that does not.
    """
    keeps_limits = _make_question(problem, reserve)

    far = find_least(lambda distance: keeps_limits(-distance) or keeps_limits(distance), NEAR_MM, SETTLED_MM)
    if far is None:
        return None
    return _name_move(problem, -far if keeps_limits(-far) else far)


def find_end_on_the_way(problem: MoveProblem, reserve: float) -> tuple[Array | None, bool]:
    """The move (3,) of the end of a straight line, along the one direction of the basis, back towards its start, to the
    last place that keeps the limits; None if the line breaks them from its start on.

    And whether no other end can be nearer: the line moves in this direction alone, so any end behind this one leads
    through what is in the way.
    """
    line, way = problem.line, problem.basis[0]
    tip, angles = line.pose(line.contour, np.zeros(2, dtype=int), np.array([0.0, 1.0]))
    span = float((tip[1] - tip[0]) @ way / (way @ way))
    beside = np.abs(tip[1] - tip[0] - span * way).max() + np.abs(angles[1] - angles[0]).max()
    least = abs(span) - LEAST_WAY_MM
    keeps_limits = _make_question(problem, reserve)
    back = None if least <= 0.0 else find_least(lambda far: keeps_limits(-np.sign(span) * far), (least,), SETTLED_MM)
    if back is None:
        return None, False
    return _name_move(problem, -np.sign(span) * back), beside < LIMIT_SLACK_MM


def _name_move(problem: MoveProblem, distance: float) -> Array:
    """The move (3,) by a distance along the one direction of the basis, rounded."""
    return np.asarray(np.round(distance * problem.basis[0], SHIFT_DECIMALS))


def _make_question(problem: MoveProblem, reserve: float) -> Callable[[float], bool]:
    """Whether a move by a distance along the one direction of the basis keeps the limits at the samples of the line."""
    element, _w = list_samples(problem.line)
    checks = problem.checks
    bounds = [check.warn if problem.also_warnings else check.limit for check in checks]

    def keeps_limits(distance: float) -> bool:
        if problem.refused.get(distance, np.inf) <= reserve:
            return False
        there = problem.move_part(distance * problem.basis[0])
        solved = solve_samples(there)
        if solved is None:
            problem.refused[distance] = -np.inf
            return False
        first = 0
        for values in iterate_measures(there, element, solved):  # until one is broken: travel is measured before bodies
            for check, bound in zip(checks, bounds, strict=True):
                column = check.quantity - first
                if 0 <= column < values.shape[1]:
                    inside = np.nanmin(check.sign * (values[:, column] - bound), initial=np.inf)
                    if not inside >= reserve:
                        problem.refused[distance] = reserve
                        return False
            first += values.shape[1]
        return True

    return keeps_limits


def find_least_move(problem: MoveProblem, start: Array, reserve: float) -> Array | None:
    """Newton's method on the limits from ``start`` (3,); the rounded move (3,), None where it does not settle.

    ``reserve`` is how far inside its limit each quantity is brought, in its unit.
    """
    at, best, there, solved = start, None, problem.move_part(start), None
    visited = {tuple(start.tolist())}
    for _ in range(NEWTON_STEPS):
        check_wanted()
        if len(problem.slopes) >= MOST_LINEARISED and tuple(at.tolist()) not in problem.slopes:
            return best
        inside, slope = _linearise(problem, at, there, solved)
        inside = inside - reserve
        if (inside > -KEPT_RESERVE * reserve).all() and (best is None or np.linalg.norm(at) < np.linalg.norm(best)):
            best = at
        share = _find_least_norm(slope, slope @ problem.basis @ at - inside, 10 * problem.farthest)
        if share is None:
            return best
        goal = np.round(share @ problem.basis, SHIFT_DECIMALS)
        for _half in range(NEWTON_STEPS):  # back towards where the line can be solved
            there = problem.move_part(goal)
            found = solve_samples(there)
            if found is not None:
                break
            goal = np.round(0.5 * (goal + at), SHIFT_DECIMALS)
        else:
            return best
        if np.linalg.norm(goal) > problem.farthest or np.linalg.norm(goal - at) < SETTLED_MM:
            return best
        place = tuple(goal.tolist())
        if place in visited:  # each step depends on the place alone: from here on it goes round
            return best
        visited.add(place)
        at, solved = goal, found
    return best


def _linearise(problem: MoveProblem, at: Array, there: JointPath, solved: Solved | None) -> tuple[Array, Array]:
    """By check: how far it is inside its bound at its worst sample (c,), and its derivative by the basis (c, k).

    ``there`` is the line after the move ``at`` (3,), with its samples where they are solved. Several reserves lead to
    the same moves.
    """
    if tuple(at.tolist()) in problem.slopes:
        return problem.slopes[tuple(at.tolist())]
    line, checks = problem.line, problem.checks
    element, w = list_samples(line)
    values = measure_solved(there, element, there.solve(element, w) if solved is None else solved)
    row = np.array([int(np.argmin(check.sign * values[:, check.quantity])) for check in checks])
    inside = np.array(
        [
            check.sign * (values[k, check.quantity] - (check.warn if problem.also_warnings else check.limit))
            for check, k in zip(checks, row, strict=True)
        ]
    )
    tip, angles = problem.move_part(at).pose(line.contour, element[row], w[row])
    rates = line.machine.five_axis.find_jacobian(tip, angles, line.contour.find_tool_lengths(element[row]))[..., :3]
    column = np.array([check.quantity for check in checks])
    steps = DIFFERENCE_MM * problem.basis
    ends = np.concatenate([at + steps, at - steps])
    plus, minus = np.split(measure_around(line, ends, problem.end_only, element[row], w[row], column), 2)
    with np.errstate(invalid="ignore"):  # infinite beside the table
        slope = ((plus - minus) / (2 * DIFFERENCE_MM)).T
    for k, check in enumerate(checks):
        if check.quantity < len(line.machine.actuators):
            slope[k] = problem.basis @ rates[k, check.quantity] * (w[row[k]] if problem.end_only else 1.0)
        slope[k] *= check.sign
    # a bound that the module does not have (minus infinity), or that has no value here, sets no condition
    usable = np.isfinite(inside) & np.isfinite(slope).all(axis=1)
    found = np.where(usable, inside, np.inf), np.where(usable[:, None], slope, 0.0)
    problem.slopes[tuple(at.tolist())] = found
    return found


def _find_least_norm(rows: Array, wanted: Array, longest: float) -> Array | None:
    """The shortest s with ``rows @ s >= wanted``, by cyclic projections in the dual; None if above ``longest``."""
    size = (rows * rows).sum(axis=1)
    active = np.flatnonzero(np.isfinite(wanted) & (size > 0))
    # numbers, not arrays: there are three of them at most
    limits = [*zip(active.tolist(), rows[active].tolist(), wanted[active].tolist(), size[active].tolist(), strict=True)]
    weight = [0.0] * len(rows)
    s = [0.0] * rows.shape[1]
    for _ in range(SWEEPS):
        before = s
        for k, row, goal, square in limits:
            new = max(0.0, weight[k] + (goal - sum(map(mul, row, s))) / square)
            change = new - weight[k]
            if change:
                s = [at + change * rate for at, rate in zip(s, row, strict=True)]
                weight[k] = new
        if all(abs(now - then) < LIMIT_SLACK_MM for now, then in zip(s, before, strict=True)):
            return np.array(s)
        if hypot(*s) > longest:
            return None
    return np.array(s)
