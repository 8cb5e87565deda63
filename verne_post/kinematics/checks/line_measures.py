"""One line of a program: its motion, the same motion elsewhere on the table, and what is measured along it."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.kinematics.checks.clearance import build_clearance_checks, list_clearances
from verne_post.kinematics.checks.violations import Check, list_machine_checks
from verne_post.kinematics.joint_path import JointPath, Solved
from verne_post.model.branch import AS_PROGRAMMED, Branch
from verne_post.model.contour import Contour

#: Samples of an element among which the worst place is sought first; 64 parts of a line bring the grid's own error
#: below the reserves.
GRID: Final = np.linspace(0.0, 1.0, 65)
#: A line of many elements, such as a cycle with pecks, has about so many samples, and of an element at least these.
MOST_SAMPLES: Final = 650
FEWEST: Final = 5


class _MovedPose(Struct, frozen=True):
    """The pose function of a line with its part or end moved, another tilt at the end, or another branch."""

    joints: JointPath
    shift: Array = np.zeros(3)  #: (3,), or one for each of the points (n, 3).
    end_only: bool = False
    branch: Branch = AS_PROGRAMMED
    end_tilt: float = 0.0

    def __call__(self, contour: Contour, element: Ints, w: Array) -> tuple[Array, Array]:
        tip, angles = self.joints.pose(contour, element, w)
        share = w[:, None] if self.end_only else 1.0
        tilted = angles + w[:, None] * np.array([self.end_tilt, 0.0])
        return tip + share * self.shift, self.branch.apply_to(tilted)


def put_on_branch(line: JointPath, branch: Branch) -> JointPath:
    """The line with its table on another branch."""
    return replace(line, pose=_MovedPose(line, branch=branch))


def tilt_line_end(line: JointPath, tilt: float) -> JointPath:
    """A straight line whose end has a nominal A that is larger by ``tilt``, rad."""
    return replace(line, pose=_MovedPose(line, end_tilt=tilt))


def shift_line(line: JointPath, shift: Array, end_only: bool = False) -> JointPath:
    """The line with its part, or the end of a straight line alone, moved on the table by ``shift`` (3,), mm."""
    keep_out = line.keep_out if end_only or line.keep_out is None else line.keep_out.move_part(shift)
    return replace(line, pose=_MovedPose(line, shift, end_only), keep_out=keep_out)


def list_checks(line: JointPath) -> list[Check]:
    """The bounds on the columns of :func:`measure`."""
    machine = line.machine
    checks = list_machine_checks(machine)
    first = len(machine.columns) + len(machine.margins)
    for model in list_clearances(line, meshes=True):
        checks += build_clearance_checks(model, first)
        first += len(model.names)
    checks.append(Check("VP210", "height over the table face", None, first, 1.0, 0.0, 0.0, LIMIT_SLACK_MM, "mm", 1.0))
    return checks


def measure(line: JointPath, element: Ints, w: Array) -> tuple[Array, Solved]:
    """Joints, margins, clearances and height over the table face (inf beside it) of points: (n, m), NaN unsolved.

    The least of each clearance is right; others may be lower bounds that are no smaller.
    """
    solved = line.solve(element, w)
    return measure_solved(line, element, solved), solved


def measure_solved(line: JointPath, element: Ints, solved: Solved) -> Array:
    """The values of :func:`measure` at poses that are solved."""
    return np.concatenate(list(iterate_measures(line, element, solved)), axis=1)


def iterate_measures(line: JointPath, element: Ints, solved: Solved) -> Iterator[Array]:
    """The columns of :func:`measure_solved` in parts, one after the other: those of bodies take most of the time."""
    yield solved.q
    yield line.find_margins(solved)
    for model in list_clearances(line, meshes=True):
        yield model.evaluate(line.place_bodies(element, solved), least_only=True)[0]
    yield _find_heights(line, element, solved)[:, None]


def measure_each(line: JointPath, element: Ints, w: Array, quantity: Ints) -> Array:
    """One value (n,) of each point: the column of :func:`measure` that ``quantity`` (n,) names."""
    solved = line.solve(element, w)
    geometry = np.concatenate([solved.q, line.find_margins(solved)], axis=1)
    first = geometry.shape[1]
    value = geometry[np.arange(len(w)), np.minimum(quantity, first - 1)]
    for model in list_clearances(line, meshes=True):
        own = np.flatnonzero((quantity >= first) & (quantity < first + len(model.names)))
        if len(own):
            some = solved if len(own) == len(w) else line.solve(element[own], w[own])
            margins = model.evaluate(line.place_bodies(element[own], some))[0]
            value[own] = margins[np.arange(len(own)), quantity[own] - first]
        first += len(model.names)
    return np.where(quantity == first, _find_heights(line, element, solved), value)


def measure_around(line: JointPath, shifts: Array, end_only: bool, element: Ints, w: Array, quantity: Ints) -> Array:
    """:func:`measure_each` of n points with the part, or the end alone, moved by each of ``shifts`` (m, 3): (m, n)."""
    values = np.empty((len(shifts), len(w)))
    first = len(line.machine.columns) + len(line.machine.margins)
    bodies = (quantity >= first) & (
        quantity < first + sum(len(one.names) for one in list_clearances(line, meshes=True))
    )
    # bodies stand elsewhere for each of the moves, and a wrist follows its way along the whole line
    alone = np.ones(len(w), dtype=bool) if line.is_carrying else bodies
    if alone.any():
        some = element[alone], w[alone], quantity[alone]
        values[:, alone] = [measure_each(shift_line(line, shift, end_only), *some) for shift in shifts]
    if not alone.all():
        many = (np.tile(one[~alone], len(shifts)) for one in (element, w, quantity))
        there = replace(line, pose=_MovedPose(line, np.repeat(shifts, np.count_nonzero(~alone), axis=0), end_only))
        values[:, ~alone] = measure_each(there, *many).reshape(len(shifts), -1)
    return values


def _find_heights(line: JointPath, element: Ints, solved: Solved) -> Array:
    """Height (n,) of tip and gauge line over the table face, inf beside it."""
    tool = line.contour.find_tool_lengths(element)
    axis = line.find_tool_axis(solved)
    nose, tip = solved.tip + tool[:, None] * axis, solved.tip + line.lift * axis
    heights = [
        np.where(np.hypot(point[:, 0], point[:, 1]) < line.machine.table_radius, point[:, 2], np.inf)
        for point in (tip, nose)
    ]
    return np.minimum(*heights)


def list_samples(line: JointPath) -> tuple[Ints, Array]:
    """Element and parameter (n,) of the samples of a line."""
    n = len(line.contour)
    grid = np.linspace(0.0, 1.0, int(np.clip(MOST_SAMPLES // n, FEWEST, len(GRID))))
    return np.repeat(np.arange(n), len(grid)), np.tile(grid, n)


def solve_samples(line: JointPath) -> Solved | None:
    """The samples of the line; None unless all can be solved."""
    solved = line.solve(*list_samples(line))
    return solved if solved.ok.all() else None


def find_solvable(line: JointPath, shifts: Array, end_only: bool) -> Mask:
    """At which of some places of the part, or of the end alone (n, 3), the ends and the middle can be solved."""
    few = np.tile([0.0, 0.5, 1.0], len(shifts))
    there = replace(line, pose=_MovedPose(line, np.repeat(shifts, 3, axis=0), end_only))
    return np.asarray(there.find_solvable(np.zeros(len(few), dtype=int), few).reshape(-1, 3).all(axis=1))
