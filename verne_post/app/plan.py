"""A program is checked and, when nothing is wrong, given its motion profiles."""

from dataclasses import dataclass

from verne_post.app.assemble import Program
from verne_post.app.constraints import check_program
from verne_post.app.result import Progress
from verne_post.model.findings import Finding, InputError
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
    total = len(program.contour)
    report = None if progress is None else lambda done: progress("planning", done, total)
    planning = PlanningOptions(program.cycle, options.solver, options.quality, played)
    limits = program.machine.limits
    profiles = plan_contour(program.joints(), bounds.first, bounds.second, bounds.third, limits, planning, report)
    return Plan(
        program, profiles, timeline(program.contour, profiles, planning), tuple(findings), bounds.axis_error_deg
    )
