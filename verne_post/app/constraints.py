"""The check of a program: one function, which every command and the Python API share."""

from dataclasses import replace

from verne_post.app.assemble import Program, machine_setup
from verne_post.app.result import Progress
from verne_post.kinematics.checks.clearance import check_constraints
from verne_post.kinematics.checks.keep_out import build_keep_out
from verne_post.kinematics.checks.limits import JointBounds
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.findings import Finding


def check_program(program: Program, progress: Progress | None = None) -> tuple[JointBounds, list[Finding]]:
    """Every geometric check along the whole contour, and what the assembly found; sorted by line and code.

    Returns
    -------
    JointBounds
        What profiles from stop to stop need.
    list of Finding
    """
    total = len(program.contour)
    report = None if progress is None else lambda done: progress("checking", done, total)
    bounds, found = check_constraints(guarded_joints(program), report)
    return bounds, sort_findings([*program.machine.warnings, *program.findings, *found])


def check_line(program: Program, joints: JointPath, line: int) -> list[Finding]:
    """The same for a part of :func:`guarded_joints` that belongs to one source line."""
    own = [item for item in program.findings if item.line == line]
    return sort_findings([*own, *check_constraints(joints)[1]])


def guarded_joints(program: Program) -> JointPath:
    """The joints along the contour, with the fixtures and the stock that the motion has to keep out of."""
    frames = machine_setup(program.machine, program.options).frames
    keep_out = build_keep_out(program.machine, program.path, program.moves, program.options, frames)
    return replace(program.joints(), keep_out=keep_out)


def sort_findings(findings: list[Finding]) -> list[Finding]:
    """Findings by line and code."""
    return sorted(findings, key=lambda item: (item.line or 0, item.code))
