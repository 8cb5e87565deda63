"""What would bring one line of a program within limits: a move of the part, another branch of the table, less tilt.

Every proposal is checked along the whole line, as `check` would: none rests on a formula alone.
"""

from collections.abc import Iterator
from itertools import product
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.least import find_least
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.kinematics.checks.clearance import check_constraints
from verne_post.kinematics.checks.least_move import (
    NEAR_MM,
    SHIFT_DECIMALS,
    MoveProblem,
    find_end_on_the_way,
    find_least_move,
    find_move_along,
    find_start,
)
from verne_post.kinematics.checks.line_measures import (
    list_checks,
    list_samples,
    measure,
    put_on_branch,
    shift_line,
    solve_samples,
    tilt_line_end,
)
from verne_post.kinematics.checks.violations import Check
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.branch import Branch
from verne_post.model.findings import Finding
from verne_post.model.toolpath import SegmentKind
from verne_post.model.verdict import NO_POSE

#: Each of these refinements around the worst sample narrows the place by 32.
ZOOMS: Final = 5
#: How far inside its limit a quantity is brought (mm, rad, or its own unit): the samples may miss the worst place, and
#: the proposal is rounded. The larger ones are tried when the check of the whole line refuses a smaller one.
RESERVES: Final = (0.002, 0.02, 0.2)
#: So much farther the end of a line is put, mm, where the check finds a contact between the samples.
FARTHER_MM: Final = (0.5, 2.0)
#: From so far beside, mm, a move is sought anew: on an axis of symmetry no direction is better than its reverse, and a
#: limit is level there.
BESIDE_MM: Final = 3.0
#: A lift is rounded up to this, mm.
LIFT_STEP_MM: Final = 0.1
#: A part is never moved by more than this, mm: beyond it no table reaches.
FARTHEST_MM: Final = 1000.0
#: The same of an end alone, whose word may have a digit or two too many, mm.
FARTHEST_WORD_MM: Final = 100_000.0
#: Steps of Newton's method on the table's tilt.
NEWTON_STEPS: Final = 20
#: Halvings of the place where a line gets out of reach: to the last digits of w.
BISECTIONS: Final = 40
#: Turns of C that are tried where its travel is limited.
TURNS: Final = 3

#: A millidegree inside the travel: what a program with three decimals can name.
TILT_RESERVE: Final = float(np.radians(1e-3))
#: Codes of the table's own travel.
ROTARY_CODES: Final = ("VP102", "VP103")


class Place(Struct, frozen=True, eq=False):
    """A point of a line: where a quantity is worst."""

    element: int
    w: float


class Shift(Struct, frozen=True):
    """A move of the part on the table (3,), mm, and the codes of errors that it leaves on the line."""

    vector: tuple[float, float, float]
    leaves: tuple[str, ...]


def select_line(joints: JointPath, line: int) -> JointPath:
    """The elements of one source line alone, in their order; none when the line has no motion."""
    return replace(joints, contour=joints.contour.select(np.flatnonzero(joints.contour.find_lines() == line)))


def is_movable(line: JointPath) -> bool:
    """Whether the line is tied to the part; a rewind in joint values, the table under a standing spindle, or
    the approach of --from, is not.
    """
    path, segment = line.contour.path, line.contour.segment
    return bool(
        (path.kind[segment] != SegmentKind.JOINT).all()
        and (path.turn[segment] < 0).all()
        and (path.move[segment] >= 0).all()
    )


def is_straight(line: JointPath) -> bool:
    """Whether the line is one straight motion, whose end can be named elsewhere."""
    path, segment = line.contour.path, line.contour.segment
    return len(segment) == 1 and bool(path.kind[segment[0]] == SegmentKind.LINE)


# --- where a quantity is worst ---------------------------------------------------------------


def find_worst_places(line: JointPath, checks: list[Check]) -> list[tuple[Place, float] | None]:
    """Where each bound is worst along the line, and the value there; None where nothing of the line can be solved."""
    element, w = list_samples(line)
    values, _solved = measure(line, element, w)
    places: list[tuple[Place, float] | None] = []
    for check in checks:
        series = check.sign * values[:, check.quantity]
        if np.isnan(series).all():
            places.append(None)
            continue
        at = int(np.nanargmin(series))
        here, centre, half = int(element[at]), float(w[at]), float(w[1])
        value = float(series[at])
        for _ in range(ZOOMS):
            near = np.clip(np.linspace(centre - half, centre + half, 65), 0.0, 1.0)
            series = check.sign * measure(line, np.full(len(near), here), near)[0][:, check.quantity]
            best = int(np.argmin(np.where(np.isnan(series), np.inf, series)))
            if series[best] <= value:
                centre, value = float(near[best]), float(series[best])
            half /= 32
        places.append((Place(here, centre), check.sign * value))
    return places


def place_of(line: JointPath, item: Finding) -> Place | None:
    """Where the value of a finding of this line stands; None where the finding has no value, or no such place."""
    if item.value is None:
        return _find_first_unsolved(line) if item.code in NO_POSE else None
    checks = [
        check
        for check in list_checks(line)
        if (check.code, check.axis) == (item.code, item.axis) and (item.code != "VP215" or item.quantity == check.name)
    ]
    by_distance = [
        (abs(best[1] * check.factor - item.value), best[0])
        for check, best in zip(checks, find_worst_places(line, checks), strict=True)
        if best is not None
    ]
    return min(by_distance, key=lambda one: one[0])[1] if by_distance else None


def is_beyond_at_start(line: JointPath, item: Finding) -> bool:
    """Whether a limit is broken where the line begins, and no more at its end: a line before it is at fault."""
    if item.value is None:
        first = _find_first_unsolved(line)
        return first is not None and (first.element, first.w) == (0, 0.0)
    ends, _solved = measure(line, np.array([0, len(line.contour) - 1]), np.array([0.0, 1.0]))
    for check in list_checks(line):
        if (check.code, check.axis) == (item.code, item.axis):
            before, after = check.sign * (ends[:, check.quantity] - check.limit)
            if before < 0.0 and after > before - LIMIT_SLACK_MM:
                return True
    return False


def _find_first_unsolved(line: JointPath) -> Place | None:
    """The first point of the line from which on the machine cannot follow."""
    element, w = list_samples(line)
    bad = np.flatnonzero(~line.solve(element, w).ok)
    if not len(bad):
        return None
    at = int(bad[0])
    good, lost = (float(w[at - 1]), float(w[at])) if at and element[at - 1] == element[at] else (0.0, float(w[at]))
    for _ in range(BISECTIONS):
        middle = 0.5 * (good + lost)
        if line.solve(element[at : at + 1], np.array([middle])).ok[0]:
            good = middle
        else:
            lost = middle
    return Place(int(element[at]), lost)


# --- another branch, another turn of C ------------------------------------------------------------


def find_errors(line: JointPath) -> tuple[str, ...]:
    """Codes of the errors of a line, each once."""
    findings = check_constraints(line)[1]
    return tuple(dict.fromkeys(item.code for item in findings if item.severity == "error"))


def find_legal_branches(line: JointPath) -> Iterator[Branch]:
    """Other branches on which the whole line keeps every limit, nearest first: the other table solution, turns of C.

    None where no joint turns: then all branches are the same pose.
    """
    if not line.machine.columns[-1].driven:
        return
    limited = bool(np.isfinite([line.machine.limits.lower[-1], line.machine.limits.upper[-1]]).any())
    turns = sorted(range(-TURNS, TURNS + 1), key=abs) if limited else [0]
    for flip, turn in sorted(product((0, 1), turns), key=lambda one: (abs(one[1]), one[0])):
        if (flip, turn) != (0, 0) and not find_errors(put_on_branch(line, Branch(flip, turn))):
            yield Branch(flip, turn)


# --- less tilt ---------------------------------------------------------------------------------------


def find_legal_tilt(line: JointPath, place: Place) -> float | None:
    """Nominal A (rad) that brings the table's tilt just inside its travel, tip and C as they are at ``place``.

    Newton's method with the machine's Jacobian; None where it does not end inside.
    """
    machine = line.machine
    solved = line.solve(np.array([place.element]), np.array([place.w]))
    tip, angles = solved.tip[0], solved.angles[0].copy()
    tool = float(line.contour.find_tool_lengths(np.array([place.element]))[0])
    low, high = float(machine.limits.lower[-2]), float(machine.limits.upper[-2])
    goal = min(max(float(solved.q[0, -2]), low + TILT_RESERVE), high - TILT_RESERVE)
    for _ in range(NEWTON_STEPS):
        q, _platform, ok = machine.five_axis.solve(tip, angles, tool)
        rate = machine.five_axis.find_jacobian(tip, angles, tool)[-2, -2]
        if not ok or not np.isfinite(rate) or rate == 0.0:
            return None
        step = (goal - float(q[-2])) / float(rate)
        if abs(step) < LIMIT_SLACK_MM:
            return float(angles[0]) if low <= q[-2] <= high else None
        angles[0] += step
    return None


#: Shares of the way from the limit of the tilt to the level table at which a line is tried.
_LESS_TILT: Final = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)


def list_legal_end_tilts(line: JointPath, place: Place) -> Iterator[float]:
    """Nominal A (rad) for the end of a straight line that keep the whole line within limits, the nearest first.

    ``place`` is where the table's tilt is worst.
    """
    inside = find_legal_tilt(line, place)
    if inside is None or place.w <= 0.0:
        return
    _tip, angles = line.pose(line.contour, np.array([0, 0]), np.array([place.w, 1.0]))
    change = (inside - float(angles[0, 0])) / place.w
    end = float(angles[1, 0]) + change
    upright = line.machine.coordinates.home_tilt - end  # there it breaks another limit: seek on towards the level table
    for share in (0.0, *_LESS_TILT):
        if not find_errors(tilt_line_end(line, change + share * upright)):
            yield end + share * upright


# --- a move of the part --------------------------------------------------------------------------------


def find_smallest_shift(
    line: JointPath,
    basis: Array,
    *,
    end_only: bool = False,
    also_warnings: bool = False,
    farthest: float = FARTHEST_MM,
) -> Shift | None:
    """A smallest move of the part that keeps the line inside travel, margins and clearances; None where none is found.

    The whole line is checked at the proposed place. Tilt and rotary travel set no condition: a move of the part is no
    cure for them.

    Parameters
    ----------
    basis : ndarray, shape (k, 3)
        Orthonormal directions in the table frame that the move may combine.
    end_only : bool
        The end of a straight line moves alone.
    also_warnings : bool
        Remove warnings too.
    farthest : float
        Of a whole line, mm: moves beyond are not sought.
    """
    skip = len(line.machine.actuators)
    checks = [check for check in list_checks(line) if check.quantity < skip or check.quantity >= skip + 2]
    farthest = FARTHEST_WORD_MM if end_only else farthest
    problem = MoveProblem(line, checks, basis, end_only, also_warnings, farthest)
    start = find_start(problem)
    if start is None:
        return None
    for vector in _list_moves(problem, start):
        if vector is None:
            continue
        findings = check_constraints(problem.move_part(vector))[1]
        left = [item for item in findings if item.severity == "error" or also_warnings]
        if all(item.code in ROTARY_CODES for item in left):
            x, y, z = (float(value) for value in vector)
            return Shift((x, y, z), tuple(dict.fromkeys(item.code for item in left)))
    return None


def _list_moves(problem: MoveProblem, start: Array) -> Iterator[Array | None]:
    """Moves (3,) to be checked along the whole line, the smaller ones first."""
    for reserve in RESERVES:
        on_the_way, is_nearest = find_end_on_the_way(problem, reserve) if problem.end_only else (None, False)
        least = None if is_nearest else find_least_move(problem, start, reserve)
        found = [one for one in (least, on_the_way) if one is not None]
        if not found and len(problem.basis) > 1:  # what does not keep this reserve keeps no larger one
            break
        yield min(found, key=np.linalg.norm, default=None)
    if not problem.end_only:
        starts = [start + sign * BESIDE_MM * problem.basis.sum(axis=0) for sign in (1.0, -1.0)]  # aside in every way
        solvable = [there for there in starts if solve_samples(problem.move_part(there)) is not None]
        for reserve in RESERVES:
            around = [one for there in solvable if (one := find_least_move(problem, there, reserve)) is not None]
            if not around and len(problem.basis) > 1:  # what does not keep this reserve keeps no larger one
                break
            yield min(around, key=np.linalg.norm, default=None)
    along: Array | None = None
    for reserve in RESERVES if problem.end_only else ():  # a moved part has other directions to go to
        along = find_move_along(problem, reserve)
        yield along
    if along is not None:
        way = along / float(np.linalg.norm(along))
        yield from (np.round(along + more * way, SHIFT_DECIMALS) for more in FARTHER_MM)


def find_least_lift(line: JointPath, direction: Array) -> float | None:
    """How far, mm, the whole of a line goes along a direction (3,) of the table frame to keep its limits; else None.

    The bodies around it stay. Rounded up, and one step farther.
    """

    def keeps_limits(distance: float) -> bool:
        return not find_errors(replace(shift_line(line, distance * direction), keep_out=line.keep_out))

    inside = find_least(keeps_limits, NEAR_MM, 0.5 * LIFT_STEP_MM)
    lift = None if inside is None else (inside // LIFT_STEP_MM + 2.0) * LIFT_STEP_MM
    return lift if lift is not None and keeps_limits(lift) else None
