"""What would make one line of a program legal: a move of the part, another branch of the table, less tilt.

Nothing here is believed because a formula says so: every proposal is judged along the whole line, as `check` would.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.rotations import axis_of_angles
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.kinematics.checks.clearance import check_constraints, clearance_checks, clearances
from verne_post.kinematics.checks.violations import Check, machine_checks
from verne_post.kinematics.joint_path import JointPath, Solved
from verne_post.model.contour import Contour
from verne_post.model.findings import Finding
from verne_post.model.toolpath import SegmentKind

Array = NDArray[np.float64]
Ints = NDArray[np.integer]

#: Samples of a element among which the worst place is sought first; 64 parts of a line bring the grid's own error
#: below the reserves.
GRID: Final = np.linspace(0.0, 1.0, 65)
#: Each of these refinements around the worst sample narrows the place by 32.
ZOOMS: Final = 5
#: How far inside its limit a quantity is brought (mm, rad, or its own unit): the samples may miss the worst place, and
#: the proposal is rounded. The larger ones are tried when judging the whole line refuses a smaller one.
RESERVES: Final = (0.002, 0.02, 0.2)
#: Decimals of a proposed move, mm: a micrometre.
SHIFT_DECIMALS: Final = 3
#: Half the step of the differences that stand for the derivative of a margin by the tip, mm.
DIFFERENCE_MM: Final = 1e-3
#: A part is never moved by more than this, mm: beyond it no table reaches.
FARTHEST_MM: Final = 1000.0
#: Newton's method has settled when a step is shorter, mm.
SETTLED_MM: Final = 2e-3
#: Steps of Newton's method on the limits; the linearised problem is solved anew at each.
NEWTON_STEPS: Final = 20
#: Sweeps over the linearised limits in search of the smallest move that keeps them all.
SWEEPS: Final = 400
#: Distances at which a reachable place is sought when the line is out of reach, mm.
SOUGHT_MM: Final = (2.0, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0)
#: Turns of C that are tried where its travel is limited.
TURNS: Final = 3

#: A millidegree inside the travel: what a program with three decimals can name.
TILT_RESERVE: Final = float(np.radians(1e-3))
#: Codes of the table's own travel.
ROTARY_CODES: Final = ("VP102", "VP103")


@dataclass(frozen=True, eq=False)
class Place:
    """A point of a line: where a quantity is worst."""

    element: int
    w: float


@dataclass(frozen=True)
class Branch:
    """Another way to hold the same tool axes: ``flip`` is 1 for (-A, C + pi), ``turns`` whole turns of C are added."""

    flip: int
    turns: int

    def of(self, angles: Array) -> Array:
        """The pairs (..., 2) on this branch."""
        return np.asarray(angles * [1.0 - 2.0 * self.flip, 1.0] + [0.0, np.pi * self.flip + 2 * np.pi * self.turns])


@dataclass(frozen=True)
class Shift:
    """A move of the part on the table (3,), mm, and the codes of errors that it leaves on the line."""

    vector: tuple[float, float, float]
    leaves: tuple[str, ...]


@dataclass(frozen=True)
class _Moved:
    """The pose function of a line whose part, or whose end alone, stands elsewhere, or whose table is on another branch."""

    joints: JointPath
    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    end_only: bool = False
    branch: Branch = Branch(0, 0)

    def __call__(self, contour: Contour, element: Ints, w: Array) -> tuple[Array, Array]:
        tip, angles = self.joints.pose(contour, element, w)
        share = w[:, None] if self.end_only else 1.0
        return tip + share * np.array(self.shift), self.branch.of(angles)


def of_line(joints: JointPath, line: int) -> JointPath:
    """The elements of one source line alone, in their order; none when the line has no motion."""
    return replace(joints, contour=joints.contour.only(np.flatnonzero(joints.contour.line() == line)))


def movable(line: JointPath) -> bool:
    """Whether the line is tied to the part; a rewind in joint values, or the approach of --from, is not."""
    path, segment = line.contour.path, line.contour.segment
    return bool((path.kind[segment] != SegmentKind.JOINT).all() and (path.move[segment] >= 0).all())


def straight(line: JointPath) -> bool:
    """Whether the line is one straight motion, whose end can be named elsewhere."""
    path, segment = line.contour.path, line.contour.segment
    return len(segment) == 1 and bool(path.kind[segment[0]] == SegmentKind.LINE)


# --- where a quantity is worst ---------------------------------------------------------------


def every_check(line: JointPath) -> list[Check]:
    """The bounds on the columns of :func:`measure`."""
    machine = line.machine
    checks = machine_checks(machine)
    first = len(machine.columns) + len(machine.margins)
    for model in clearances(line):
        checks += clearance_checks(model, first)
        first += len(model.names)
    checks.append(Check("VP210", "height over the table face", None, first, 1.0, 0.0, 0.0, LIMIT_SLACK_MM, "mm", 1.0))
    return checks


def measure(line: JointPath, element: Ints, w: Array) -> tuple[Array, Solved]:
    """Joints, margins, clearances and height over the table face (infinite beside it) of points: (n, m), NaN unsolved."""
    machine = line.machine
    solved = line.solve(element, w)
    parts = [solved.q, machine.module.geometry_margins(solved.position, solved.alpha)]
    tool = line.contour.tool_length(element)
    parts += [model.evaluate(line.bodies(element, solved))[0] for model in clearances(line)]
    nose = solved.tip + tool[:, None] * axis_of_angles(solved.angles[:, 0], solved.angles[:, 1])
    heights = [
        np.where(np.hypot(point[:, 0], point[:, 1]) < machine.table_radius, point[:, 2], np.inf)
        for point in (solved.tip, nose)
    ]
    parts.append(np.minimum(*heights)[:, None])
    return np.concatenate(parts, axis=1), solved


def _grid(line: JointPath) -> tuple[Ints, Array]:
    n = len(line.contour)
    return np.repeat(np.arange(n), len(GRID)), np.tile(GRID, n)


def worst_places(line: JointPath, checks: list[Check]) -> list[tuple[Place, float] | None]:
    """Where each bound is worst along the line, and the value there; None where nothing of the line can be solved."""
    element, w = _grid(line)
    values, _solved = measure(line, element, w)
    found: list[tuple[Place, float] | None] = []
    for check in checks:
        series = check.sign * values[:, check.quantity]
        if np.isnan(series).all():
            found.append(None)
            continue
        at = int(np.nanargmin(series))
        here, centre, half = int(element[at]), float(w[at]), float(GRID[1])
        value = float(series[at])
        for _ in range(ZOOMS):
            near = np.clip(np.linspace(centre - half, centre + half, 65), 0.0, 1.0)
            series = check.sign * measure(line, np.full(len(near), here), near)[0][:, check.quantity]
            best = int(np.argmin(np.where(np.isnan(series), np.inf, series)))
            if series[best] <= value:
                centre, value = float(near[best]), float(series[best])
            half /= 32
        found.append((Place(here, centre), check.sign * value))
    return found


def place_of(line: JointPath, item: Finding) -> Place | None:
    """Where the value of a finding of this line stands; None where the finding has no value, or no such place."""
    if item.value is None:
        return _first_unsolved(line) if item.code in ("VP110", "VP201", "VP203") else None
    checks = [check for check in every_check(line) if (check.code, check.axis) == (item.code, item.axis)]
    seen = [(abs(best[1] * check.factor - item.value), best[0])
            for check, best in zip(checks, worst_places(line, checks), strict=True) if best is not None]  # fmt: skip
    return min(seen, key=lambda one: one[0])[1] if seen else None


def _first_unsolved(line: JointPath) -> Place | None:
    """The first point of the line from which on the machine cannot follow."""
    element, w = _grid(line)
    bad = np.flatnonzero(~line.solve(element, w).ok)
    if not len(bad):
        return None
    at = int(bad[0])
    good, lost = (float(w[at - 1]), float(w[at])) if at and element[at - 1] == element[at] else (0.0, float(w[at]))
    for _ in range(40):  # bisection to the last digits of w
        middle = 0.5 * (good + lost)
        if line.solve(element[at : at + 1], np.array([middle])).ok[0]:
            good = middle
        else:
            lost = middle
    return Place(int(element[at]), lost)


# --- another branch, another turn of C ------------------------------------------------------------


def errors_of(line: JointPath) -> tuple[str, ...]:
    """Codes of the errors of a line, each once."""
    found = check_constraints(line)[1]
    return tuple(dict.fromkeys(item.code for item in found if item.severity == "error"))


def on_branch(line: JointPath, branch: Branch) -> JointPath:
    """The line with its table on another branch."""
    return replace(line, pose=_Moved(line, branch=branch))


def legal_branches(line: JointPath) -> Iterator[Branch]:
    """Other branches on which the whole line keeps every limit, nearest first: the other table solution, turns of C."""
    limited = bool(np.isfinite([line.machine.limits.lower[-1], line.machine.limits.upper[-1]]).any())
    turns = sorted(range(-TURNS, TURNS + 1), key=abs) if limited else [0]
    for flip, turn in sorted(product((0, 1), turns), key=lambda one: (abs(one[1]), one[0])):
        if (flip, turn) != (0, 0) and not errors_of(on_branch(line, Branch(flip, turn))):
            yield Branch(flip, turn)


# --- less tilt ---------------------------------------------------------------------------------------


def tilt_inside(line: JointPath, place: Place) -> float | None:
    """Nominal A (rad) that brings the table's tilt just inside its travel, tip and C as they are at ``place``.

    Newton's method with the machine's Jacobian; None where it does not end inside.
    """
    machine = line.machine
    solved = line.solve(np.array([place.element]), np.array([place.w]))
    tip, angles = solved.tip[0], solved.angles[0].copy()
    tool = float(line.contour.tool_length(np.array([place.element]))[0])
    low, high = float(machine.limits.lower[-2]), float(machine.limits.upper[-2])
    goal = min(max(float(solved.q[0, -2]), low + TILT_RESERVE), high - TILT_RESERVE)
    for _ in range(NEWTON_STEPS):
        q, _position, _alpha, ok = machine.five_axis.solve(tip, angles, tool)
        rate = machine.five_axis.jacobian(tip, angles, tool)[-2, -2]
        if not ok or not np.isfinite(rate) or rate == 0.0:
            return None
        step = (goal - float(q[-2])) / float(rate)
        if abs(step) < LIMIT_SLACK_MM:
            return float(angles[0]) if low <= q[-2] <= high else None
        angles[0] += step
    return None


# --- a move of the part --------------------------------------------------------------------------------


def shift_line(line: JointPath, shift: Array, end_only: bool = False) -> JointPath:
    """The line with its part, or the end of a straight line alone, moved on the table by ``shift`` (3,), mm."""
    x, y, z = (float(value) for value in shift)
    keep_out = line.keep_out if end_only or line.keep_out is None else line.keep_out.moved(shift)
    return replace(line, pose=_Moved(line, (x, y, z), end_only), keep_out=keep_out)


def smallest_shift(
    line: JointPath, basis: Array, *, end_only: bool = False, also_warnings: bool = False
) -> Shift | None:
    """A smallest move of the part along ``basis`` (k, 3) that keeps the line inside travel, margins and clearances.

    ``basis`` is orthonormal, in the table frame. With ``end_only`` the end of a straight line moves alone.

    The limits are linearised at the worst place of each (sliders by ``jacobian``, the others by differences), the
    least move that keeps them is taken, and so on until it stands. Then the whole line is judged there. Tilt and
    rotary travel are not asked: a move of the part is no cure for them; what it leaves is said in ``leaves``.
    None when nothing was found within ``FARTHEST_MM``.
    """
    skip = len(line.machine.module.actuators)
    checks = [check for check in every_check(line) if check.quantity < skip or check.quantity >= skip + 2]
    start = _reachable(line, basis, end_only)
    if start is None:
        return None
    for reserve in RESERVES:
        vector = _least_move(line, checks, basis, start, reserve, also_warnings, end_only)
        if vector is None:
            continue
        moved = shift_line(line, vector, end_only)
        found = check_constraints(moved)[1]
        left = [item for item in found if item.severity == "error" or also_warnings]
        others = tuple(dict.fromkeys(item.code for item in left if item.code not in ROTARY_CODES))
        if not others:
            x, y, z = (float(value) for value in vector)
            return Shift((x, y, z), tuple(dict.fromkeys(item.code for item in left)))
    return None


def _solvable(line: JointPath, shift: Array, end_only: bool) -> bool:
    element, w = _grid(line)
    return bool(shift_line(line, shift, end_only).solve(element, w).ok.all())


def _reachable(line: JointPath, basis: Array, end_only: bool) -> Array | None:
    """A small combination of the basis at which all of the line can be solved: zero, or the first that is found."""
    if _solvable(line, np.zeros(3), end_only):
        return np.zeros(3)
    ways = np.array([one for one in product((-1, 0, 1), repeat=len(basis)) if any(one)]) @ basis
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    for distance in SOUGHT_MM:
        for way in ways:
            # the ends and the middle first: most ways fail there
            few = shift_line(line, distance * way, end_only).solve(np.zeros(3, dtype=int), np.array([0.0, 0.5, 1.0]))
            if few.ok.all() and _solvable(line, distance * way, end_only):
                return np.asarray(distance * way)
    return None


def _least_move(
    line: JointPath,
    checks: list[Check],
    basis: Array,
    start: Array,
    reserve: float,
    also_warnings: bool,
    end_only: bool,
) -> Array | None:
    """Newton's method on the limits from ``start``; the rounded move (3,), None where it does not settle."""
    element, w = _grid(line)
    at, best = start, None
    for _ in range(NEWTON_STEPS):
        there = shift_line(line, at, end_only)
        values, _solved = measure(there, element, w)
        inside, slope = _linearised(line, at, end_only, checks, values, element, w, reserve, also_warnings)
        if (inside > -0.9 * reserve).all() and (best is None or np.linalg.norm(at) < np.linalg.norm(best)):
            best = at
        rows = slope @ basis.T
        share = _least_norm(rows, rows @ np.linalg.pinv(basis.T) @ at - inside)
        if share is None:
            return best
        goal = np.round(share @ basis, SHIFT_DECIMALS)
        for _half in range(NEWTON_STEPS):  # back towards where the line can be solved
            if _solvable(line, goal, end_only):
                break
            goal = np.round(0.5 * (goal + at), SHIFT_DECIMALS)
        else:
            return best
        if np.linalg.norm(goal) > FARTHEST_MM or np.linalg.norm(goal - at) < SETTLED_MM:
            return best
        at = goal
    return best


def _linearised(
    line: JointPath,
    at: Array,
    end_only: bool,
    checks: list[Check],
    values: Array,
    element: Ints,
    w: Array,
    reserve: float,
    also_warnings: bool,
) -> tuple[Array, Array]:
    """By check: how far it is inside its bound less the reserve (c,), and its derivative by the move (c, 3)."""
    row = np.array([int(np.argmin(check.sign * values[:, check.quantity])) for check in checks])
    inside = np.array([
        check.sign * (values[k, check.quantity] - (check.warn if also_warnings else check.limit)) - reserve
        for check, k in zip(checks, row, strict=True)
    ])  # fmt: skip
    tip, angles = shift_line(line, at, end_only).pose(line.contour, element[row], w[row])
    rates = line.machine.five_axis.jacobian(tip, angles, line.contour.tool_length(element[row]))[..., :3]
    slope = np.empty((len(checks), 3))
    for axis in range(3):
        step = DIFFERENCE_MM * np.eye(3)[axis]
        ahead = measure(shift_line(line, at + step, end_only), element[row], w[row])[0]
        behind = measure(shift_line(line, at - step, end_only), element[row], w[row])[0]
        with np.errstate(invalid="ignore"):  # infinite beside the table
            slope[:, axis] = [
                (ahead[k, check.quantity] - behind[k, check.quantity]) / (2 * DIFFERENCE_MM)
                for k, check in enumerate(checks)
            ]
    for k, check in enumerate(checks):
        if check.quantity < len(line.machine.module.actuators):
            slope[k] = rates[k, check.quantity] * (w[row[k]] if end_only else 1.0)
        slope[k] *= check.sign
    # a bound that the module does not have (minus infinity), or that says nothing here, asks nothing
    usable = np.isfinite(inside) & np.isfinite(slope).all(axis=1)
    return np.where(usable, inside, np.inf), np.where(usable[:, None], slope, 0.0)


def _least_norm(rows: Array, wanted: Array) -> Array | None:
    """The shortest vector s with ``rows @ s >= wanted``, by cyclic projections in the dual; None where there is none."""
    size = (rows * rows).sum(axis=1)
    asking = np.flatnonzero(np.isfinite(wanted) & (size > 0))
    weight = np.zeros(len(rows))
    s = np.zeros(rows.shape[1])
    for _ in range(SWEEPS):
        before = s.copy()
        for k in asking:
            new = max(0.0, weight[k] + (wanted[k] - rows[k] @ s) / size[k])
            s = s + (new - weight[k]) * rows[k]
            weight[k] = new
        if np.abs(s - before).max() < LIMIT_SLACK_MM:
            return s
        if np.linalg.norm(s) > 10 * FARTHEST_MM:
            return None
    return s
