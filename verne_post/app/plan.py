"""A program is checked and, when nothing is wrong, given its motion profiles."""

from collections.abc import Callable

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.app.assemble import Program
from verne_post.app.constraints import check_program
from verne_post.app.result import Progress
from verne_post.app.shaping import NO_LIMITS, find_slowdown
from verne_post.base.arrays import Array
from verne_post.base.columns import blocks
from verne_post.base.long_text import Text
from verne_post.kinematics.checks.limits import JointBounds
from verne_post.model.findings import Finding, InputError, SolverError, finding
from verne_post.model.verdict import worst
from verne_post.trajectory import tuning
from verne_post.trajectory.override import feed_override
from verne_post.trajectory.plan import MotionProfiles, PlanningOptions, plan_contour
from verne_post.trajectory.sample import Timeline, timeline


class Plan(Struct, frozen=True, eq=False):
    """A checked program with its time profiles."""

    program: Program
    profiles: MotionProfiles
    timeline: Timeline
    findings: tuple[Finding, ...]
    axis_error_deg: float


def plan_or_refuse(source: Text, program: Program, progress: Progress | None = None) -> Plan:
    """:func:`plan_program` of a source; what refuses it names the remedies that were tried.

    Raises
    ------
    InputError
    """
    try:
        return plan_program(program, progress)
    except InputError as error:
        from verne_post.app.tried_remedies import add_remedies  # for refused programs alone

        raise InputError(*add_remedies(source, program, error.findings)) from None


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
    _require_rows(program, _compute_least_seconds(program) / program.cycle)
    total = len(program.contour)
    report = None if progress is None else lambda done: progress("planning", done, total)
    planning = PlanningOptions(program.cycle, options.solver, options.quality, played, program.shaper(), program.team)
    profiles, laid_out = _plan(program, bounds, planning, report)
    return Plan(program, profiles, laid_out, tuple(findings), bounds.axis_error_deg)


def _plan(
    program: Program, bounds: JointBounds, planning: PlanningOptions, report: Callable[[int], None] | None
) -> tuple[MotionProfiles, Timeline]:
    """Plan; again and slower where an input shaper would move the tool too far from its path.

    Raises
    ------
    InputError
        VP035: more rows than the options allow.
    SolverError
    """
    joints, contour = program.joints(), program.contour
    limits, stretch = NO_LIMITS, np.ones(contour.n_sections)
    for _ in range(tuning.SHAPER_ATTEMPTS if planning.rest else 1):
        limited = replace(joints, speed=limits.applied_to(contour, joints.speed)) if len(limits.begin) else joints
        profiles = plan_contour(
            limited, bounds.first, bounds.second, bounds.third, program.machine.limits, planning, report, stretch
        )
        laid_out = timeline(contour, profiles, planning)
        _require_rows(program, laid_out.n_rows)
        if not planning.rest:
            return profiles, laid_out
        lower, too_fast = find_slowdown(program, profiles, laid_out)
        if (too_fast <= 1.0).all():
            return profiles, laid_out
        limits, stretch = limits.lower(lower), stretch * np.where(too_fast > 1.0, tuning.SHAPER_MARGIN * too_fast, 1.0)
    line = int(contour.line(contour.section_begins[[int(np.argmax(too_fast))]])[0])
    text = f"with the input shaper the motion that begins in line {line} keeps tolerance and feed rate at no speed that was tried"
    raise SolverError(finding("VP420", text, line=line, last_line=line, worst_line=line))


def _compute_least_seconds(program: Program) -> float:
    """The time that the program takes at its feed rates; planned motion takes no less."""
    path = program.path
    at_feed = sum(float(_replace_infinite(path.feed_time[first:last]).sum()) for first, last in blocks(len(path)))
    return at_feed + float(path.dwell_seconds.sum())


def _replace_infinite(seconds: Array) -> Array:
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
    seconds = np.append(_replace_infinite(path.feed_time), path.dwell_seconds)
    slowest = int(np.argmax(seconds))
    text = (
        f"the program takes more than {rows:.4g} rows of {program.cycle:g} s, and --max-rows allows {program.options.max_rows}; "
        f"this line takes longest, {seconds[slowest]:.4g} s"
    )
    line = int(lines[slowest])
    raise InputError(finding("VP035", text, line=line, last_line=line, worst_line=line))
