"""One line of a program worked through: words, pose, every solution of table and module, margins."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from verne_post.base.rotations import axis_of_angles
from verne_post.base.units import DEG_PER_RAD
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.machine import Machine

Array = NDArray[np.float64]


def pose_of_line(joints: JointPath, line: int) -> int | None:
    """The last segment of a source line, None when the line has no motion."""
    segments = np.flatnonzero(joints.contour.line == line)
    return int(segments[-1]) if len(segments) else None


def explain_pose(joints: JointPath, segment: int) -> Iterator[str]:
    """Lines of text about the end of a segment."""
    machine, contour = joints.machine, joints.contour
    solved = joints.solve(np.array([segment]), np.array([1.0]))
    tip, angles = solved.tip[0], solved.angles[0]
    tool = float(contour.tool_length[segment])
    axis = axis_of_angles(angles[0], angles[1])
    yield f"line {contour.line[segment]}, end of its motion; tool length {tool:g} mm"
    yield f"  tip on the table     {_mm(tip)}"
    yield f"  tool axis            ({', '.join(f'{value:.6f}' for value in axis)})"
    yield f"  nominal angles       A {DEG_PER_RAD * angles[0]:.6f} deg, C {DEG_PER_RAD * angles[1]:.6f} deg (workpiece sense)"
    for name, pair in (("as programmed", angles), ("other table solution", np.array([-angles[0], angles[1] + np.pi]))):
        yield from _table_solution(machine, name, tip, pair, tool)
    if not solved.ok[0]:
        return
    yield "every solution of the module at this platform position:"
    for solution in machine.module.inverse_all(solved.position[0]):
        reasons = [solution.refused] if solution.refused else []
        reasons += [f"travel of {joint}" for joint in _beyond(machine, np.array(solution.rho))]
        signs = ",".join(f"{sign:+d}" for sign in solution.signs)
        mode = f"  s ({signs})" if signs else ""
        values = zip(machine.module.actuators, solution.rho, strict=True)
        joints_text = ", ".join(f"{name} {value:.4f}" for name, value in values)
        verdict = "in use" if not reasons else "refused: " + "; ".join(reasons)
        yield f"  alpha {DEG_PER_RAD * solution.alpha:10.4f} deg{mode}  {joints_text}  {verdict}"


def _table_solution(machine: Machine, name: str, tip: Array, angles: Array, tool: float) -> Iterator[str]:
    q, position, alpha, ok = machine.five_axis.solve(tip, angles, tool)
    if not ok:
        (code,) = machine.five_axis.why_not(tip[None], angles[None], tool)
        yield f"{name}: refused: {code}, no solution in the working mode"
        return
    lower, upper = machine.limits.lower, machine.limits.upper
    broken = [column.joint for column, value, low, high in zip(machine.columns, q, lower, upper, strict=True)
              if not low <= value <= high]  # fmt: skip
    yield f"{name}: " + ("possible" if not broken else "refused: beyond the travel of " + ", ".join(broken))
    yield f"  platform             P {_mm(position)}, leaning by alpha {DEG_PER_RAD * float(alpha):.6f} deg"
    for column, value, low, high in zip(machine.columns, q, lower, upper, strict=True):
        margin = abs(column.factor) * float(min(value - low, high - value))
        yield f"  {column.header:<20} {value * column.factor:.6f}   margin to its travel {margin:.6f} {column.unit}"
    margins = machine.module.geometry_margins(position, alpha)
    for measure, value in zip(machine.margins, margins, strict=True):
        what = f"{measure.name} ({measure.axis})" if measure.axis else measure.name
        unit = f" {measure.unit}" if measure.unit else ""
        bound = f", must be above {measure.error_below:g}" if np.isfinite(measure.error_below) else ""
        yield f"  {what:<36} {value:.6f}{unit}{bound} ({measure.code})"
    parallel, serial = machine.module.conditioning(position, alpha, q[:-2])
    yield f"  conditioning (1 even, 0 singular)    parallel {float(parallel):.4f}, serial {float(serial):.4f}"


def _beyond(machine: Machine, rho: Array) -> list[str]:
    n = len(rho)
    bad = (rho < machine.limits.lower[:n]) | (rho > machine.limits.upper[:n])
    return [name for name, out in zip(machine.module.actuators, bad, strict=True) if out]


def _mm(point: Array) -> str:
    return f"({', '.join(f'{value:.6f}' for value in point)}) mm"
