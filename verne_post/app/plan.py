"""A program is checked and, when nothing is wrong, given its motion profiles."""

from dataclasses import dataclass

import numpy as np

from verne_post.app.assemble import Program
from verne_post.app.constraints import check_program
from verne_post.app.result import Progress
from verne_post.base.arrays import Array
from verne_post.base.columns import blocks
from verne_post.model.findings import Finding, InputError, finding
from verne_post.model.verdict import worst
from verne_post.trajectory.override import feed_override
from verne_post.trajectory.plan import MotionProfiles, PlanningOptions, plan_contour
from verne_post.trajectory.sample import Timeline, timeline


@dataclass(frozen=True, eq=False)
class Plan:
    """A checked program with its time profiles."""

    program: Program
    profiles: MotionProfiles
    timeline: Timeline
    findings: tuple[Finding, ...]
    axis_error_deg: float


def plan_program(program: Program, progress: Progress | None = None) -> Plan:
    """Check and, when nothing is wrong, plan.

    Raises
    ------
    InputError
        With all findings when one of them is an error.
    SolverError
        When no feasible velocity profile is found.
    """
    options = program.options
    played = feed_override(options.override, options.slow_start, program.machine.limits)
    bounds, findings = check_program(program, progress)
    if worst(findings) == "error":
        raise InputError(*findings)
    _require_rows(program, _least_seconds(program) / program.cycle)
    total = len(program.contour)
    report = None if progress is None else lambda done: progress("planning", done, total)
    planning = PlanningOptions(program.cycle, options.solver, options.quality, played)
    limits = program.machine.limits
    profiles = plan_contour(program.joints(), bounds.first, bounds.second, bounds.third, limits, planning, report)
    laid_out = timeline(program.contour, profiles, planning)
    _require_rows(program, laid_out.n_rows)
    return Plan(program, profiles, laid_out, tuple(findings), bounds.axis_error_deg)


def _least_seconds(program: Program) -> float:
    """The time that the program takes at its feed rates; planned motion takes no less."""
    path = program.path
    at_feed = sum(float(_finite(path.feed_time[first:last]).sum()) for first, last in blocks(len(path)))
    return at_feed + float(path.dwell_seconds.sum())


def _finite(seconds: Array) -> Array:
    """Rapid traverse has no time of its own."""
    return np.where(np.isfinite(seconds), seconds, 0.0)


def _require_rows(program: Program, rows: float) -> None:
    """Refuse more rows than the options allow.

    Raises
    ------
    InputError
        VP035, at the line that takes longest.
    """
    if rows <= program.options.max_rows:
        return
    path = program.path
    lines = np.append(path.line, path.dwell_line)
    seconds = np.append(_finite(path.feed_time), path.dwell_seconds)
    slowest = int(np.argmax(seconds))
    text = (
        f"the program takes more than {rows:.4g} rows of {program.cycle:g} s, and --max-rows allows {program.options.max_rows}; "
        f"this line takes longest, {seconds[slowest]:.4g} s"
    )
    line = int(lines[slowest])
    raise InputError(finding("VP035", text, line=line, last_line=line, worst_line=line))
