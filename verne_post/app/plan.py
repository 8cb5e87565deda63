"""A program is checked and, when nothing is wrong, given its motion profiles.

A shaper displaces the motion by half the variance of its weights times the acceleration. Corners leave a share of their
tolerance to it. Where that is not enough, on tight arcs and fast corners, and where the feed rate falls, speed limits
along the path are lowered until the shaped rows themselves keep tolerance and feed rate.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.app.assemble import Program
from verne_post.app.constraints import check_program
from verne_post.app.result import Progress
from verne_post.base.arrays import Array, Ints
from verne_post.base.columns import iterate_blocks, sum_running
from verne_post.base.long_text import Text
from verne_post.base.numbers import format_duration
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import PATH_AXIS_DEG, PATH_TIP_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.kinematics.checks.limits import JointBounds
from verne_post.model.contour import Contour
from verne_post.model.findings import Finding, InputError, SolverError, make_finding, make_input_error
from verne_post.model.protocols import SpeedFunction
from verne_post.model.toolpath import SegmentKind
from verne_post.model.verdict import find_worst
from verne_post.toolpath.contour_pose import find_contour_pose, find_speed_cap
from verne_post.trajectory import tuning
from verne_post.trajectory.override import build_feed_override
from verne_post.trajectory.plan import MotionProfiles, PlanningOptions, plan_contour
from verne_post.trajectory.sample import Rows, RowSampler, Timeline, lay_out
from verne_post.trajectory.shaper import shape_rows

#: Of what verification allows where the path has no tolerance, so much is used: the rest is for rounding.
EXACT_SHARE: Final = 0.9
#: Where the motion stands in its program, which does not change how it is planned.
_PLACES: Final = ("line", "move", "dwell_line")


#: Takes findings while others, or their remedies, are still sought.
Tell = Callable[[Sequence[Finding]], None]


class Plan(Struct, frozen=True, eq=False):
    """A checked program with its time profiles."""

    program: Program
    profiles: MotionProfiles
    timeline: Timeline
    findings: tuple[Finding, ...]
    axis_error_deg: float


def plan_or_refuse(
    source: Text,
    program: Program,
    progress: Progress | None = None,
    *,
    only_cause: bool = False,
    tell: Tell | None = None,
    planned: Sequence[Plan] = (),
) -> Plan:
    """:func:`plan_program` of a source; what refuses it names the remedies that were tried.

    With ``only_cause`` no remedies are sought, which changes nothing in what is found. ``tell`` gets the findings
    before remedies are sought, which may take longer than the check.

    Raises
    ------
    InputError
    """
    with _try_remedies(source, program, only_cause=only_cause, tell=tell):
        return plan_program(program, progress, planned=planned)


def check_or_refuse(source: Text, program: Program, progress: Progress | None = None) -> list[Finding]:
    """What :func:`check_limits` finds, of a source; what refuses it names the remedies that were tried.

    Raises
    ------
    InputError
    """
    with _try_remedies(source, program):
        return check_limits(program, progress)[1]


@contextmanager
def _try_remedies(
    source: Text, program: Program, *, only_cause: bool = False, tell: Tell | None = None
) -> Iterator[None]:
    """Add the remedies that were tried to what refuses a program."""
    try:
        yield
    except InputError as error:
        from verne_post.app.remedies.refused import add_remedies, name_cause
        from verne_post.app.start_lines import quote_start  # for refused programs alone

        if tell is not None:
            tell(error.findings)
        found = (name_cause if only_cause else add_remedies)(source, program, error.findings)
        raise InputError(*quote_start(source, program, found)) from None


def check_limits(
    program: Program, progress: Progress | None = None, *, only_first: bool = False
) -> tuple[JointBounds, list[Finding]]:
    """:func:`~verne_post.app.constraints.check_program`, and whether the rows can be too many.

    Raises
    ------
    InputError
        With all findings when one of them is an error; VP035: more rows than the options allow.
    """
    bounds, findings = check_program(program, progress, only_first=only_first)
    if find_worst(findings) == "error":
        raise InputError(*findings)
    _require_rows(program, _compute_least_seconds(program) / program.cycle)
    return bounds, findings


def plan_program(
    program: Program,
    progress: Progress | None = None,
    *,
    only_first: bool = False,
    planned: Sequence[Plan] = (),
) -> Plan:
    """Check and, when nothing is wrong, plan.

    With ``only_first`` the check of a stock ends at its first error: whether there is one is asked, not which. The
    profiles of one that was ``planned`` before are those of the same motion, whatever else the programs say.

    Raises
    ------
    InputError
        With all findings when one of them is an error.
    SolverError
        When no feasible motion profile is found.
    """
    options = program.options
    played = build_feed_override(options.override, options.slow_start, program.machine.limits)
    bounds, findings = check_limits(program, progress, only_first=only_first)
    total = len(program.contour)
    report = None if progress is None else lambda done: progress("planning", done, total)
    planning = PlanningOptions(
        program.cycle, options.solver, options.quality, played, program.build_shaper(), program.team
    )
    known = next((one.profiles for one in planned if _is_same_motion(one, program, planning)), None)
    if known is None:
        profiles, laid_out = _plan(program, bounds, planning, report)
    else:
        profiles, laid_out = known, lay_out(program.contour, known, planning)
        _require_rows(program, laid_out.n_rows)
    return Plan(program, profiles, laid_out, tuple(findings), bounds.axis_error_deg)


def _is_same_motion(plan: Plan, program: Program, planning: PlanningOptions) -> bool:
    """Whether a program has the motion of another that was planned in the same way, to the last bit."""
    before, timeline = plan.program, plan.timeline
    now, then = (
        (one.options.solver, one.options.quality, one.options.lift, cycle, playback)
        for one, cycle, playback in (
            (program, planning.cycle, planning.playback),
            (before, timeline.cycle, timeline.playback),
        )
    )
    is_shaped = planning.rest or len(timeline.weights) > 1  # a shaper's limits of speed are sought once more
    return (
        not is_shaped
        and before.machine is program.machine
        and now == then
        and _is_same(before.contour, program.contour)
    )


def _is_same(one: object, other: object) -> bool:
    """Whether two values hold the same numbers, wherever their lines stand."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.shape == other.shape and one.dtype == other.dtype and one.tobytes() == other.tobytes()
    if isinstance(one, Struct) and type(one) is type(other):
        return all(
            _is_same(getattr(one, name), getattr(other, name)) for name in one.__struct_fields__ if name not in _PLACES
        )
    return type(one) is type(other) and one == other


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
    joints, contour = program.build_joint_path(), program.contour
    limits, stretch = NO_LIMITS, np.ones(contour.n_sections)
    for _ in range(tuning.SHAPER_ATTEMPTS if planning.rest else 1):
        limited = replace(joints, speed=limits.cap(contour, joints.speed)) if len(limits.begin) else joints
        profiles = plan_contour(
            limited, bounds.first, bounds.second, bounds.third, program.machine.limits, planning, report, stretch
        )
        laid_out = lay_out(contour, profiles, planning)
        _require_rows(program, laid_out.n_rows)
        if not planning.rest:
            return profiles, laid_out
        lower, too_fast = find_slowdown(program, profiles, laid_out)
        if (too_fast <= 1.0).all():
            return profiles, laid_out
        limits, stretch = limits.lower(lower), stretch * np.where(too_fast > 1.0, tuning.SHAPER_MARGIN * too_fast, 1.0)
    line = int(contour.find_lines(contour.section_begins[[int(np.argmax(too_fast))]])[0])
    text = (
        "with the input shaper, no speed that was tried keeps tolerance and feed rate in the motion that begins in "
        f"line {line}"
    )
    raise SolverError(make_finding("VP420", text, line=line))


def _compute_least_seconds(program: Program) -> float:
    """The time that the program takes at its feed rates; planned motion takes no less."""
    path = program.path
    at_feed = sum(
        float(_replace_infinite(path.feed_time[first:last]).sum()) for first, last in iterate_blocks(len(path))
    )
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
        f"at its feed rates the program takes {format_duration(rows * program.cycle)}, in rows of {program.cycle:g} s; "
        f"--max-rows allows {(most := program.options.max_rows)} rows, {format_duration(most * program.cycle)}; the "
        f"longest line takes {format_duration(float(seconds[slowest]))}"
    )
    line = int(lines[slowest])
    raise make_input_error("VP035", text, line=line)


class SpeedLimits(Struct, frozen=True, eq=False):
    """Largest ds/dt along a path, a step function: ``speed`` (m,), mm/s, from ``begin`` (m,), mm; before, infinite."""

    begin: Array
    speed: Array

    def find_limits(self, s: Array) -> Array:
        """The limits (n,) at path lengths s (n,)."""
        return np.append(np.inf, self.speed)[np.searchsorted(self.begin, s, side="right")]

    def lower(self, other: "SpeedLimits") -> "SpeedLimits":
        """The lower one of both everywhere."""
        begin = np.union1d(self.begin, other.begin)
        return SpeedLimits(begin, np.minimum(self.find_limits(begin), other.find_limits(begin)))

    def cap(self, contour: Contour, speed: SpeedFunction) -> SpeedFunction:
        """A feed cap that keeps them too."""
        starts = sum_running(contour.length)

        def limit_speed(contour: Contour, element: Ints, w: Array) -> Array:
            return np.minimum(
                speed(contour, element, w), self.find_limits(starts[element] + w * contour.length[element])
            )

        return limit_speed


NO_LIMITS: Final = SpeedLimits(np.empty(0), np.empty(0))


def find_slowdown(program: Program, profiles: MotionProfiles, laid_out: Timeline) -> tuple[SpeedLimits, Array]:
    """Speed limits along the path that keep tolerance and feed rate of shaped rows, and factors of excess speed.

    The factors (n_sections,) are 1 where nothing is too fast. The limits are for continuous sections, the factors for
    those from stop to stop.
    """
    contour = program.contour
    starts, sampler = sum_running(contour.length), RowSampler(contour, profiles, laid_out)
    limits, too_fast = NO_LIMITS, np.ones(contour.n_sections)
    for sampled in map(sampler.make_rows, sampler.list_blocks()):
        factor = _measure_excess(program, sampled, laid_out)
        if (factor <= 1.0).all():
            continue
        # a shaped row is made of all rows under its weights
        reach = len(laid_out.weights) - 1
        around = np.lib.stride_tricks.sliding_window_view(np.pad(factor, reach), reach + 1).max(axis=1)
        np.maximum.at(too_fast, contour.section[sampled.element], around)
        s = starts[sampled.element] + sampled.w * contour.length[sampled.element]
        limits = limits.lower(_make_slower_limits(s, around, laid_out.cycle))
    return limits, too_fast


def _measure_excess(program: Program, sampled: Rows, laid_out: Timeline) -> Array:
    """By which factor (n,) the motion around each shaped row is too fast."""
    contour, weights = program.contour, laid_out.weights
    shaped = shape_rows(program.build_joint_path().find_joints(sampled.element, sampled.w), weights)
    segment = contour.segment[sampled.shown]
    tip, angles, _ok = program.machine.five_axis.find_nominal_pose(shaped, contour.path.tool_length[segment])
    meant_tip, meant_angles = find_contour_pose(contour, sampled.shown, sampled.shown_w)
    tip_bound = _compute_remaining_tolerances(contour.tip_tolerance[segment], PATH_TIP_MM)
    axis_bound = _compute_remaining_tolerances(contour.axis_tolerance[segment], PATH_AXIS_DEG * RAD_PER_DEG)
    off = np.maximum(measure_rows(tip - meant_tip) / tip_bound, np.abs(angles - meant_angles).max(axis=1) / axis_bound)
    off[contour.path.kind[segment] == SegmentKind.JOINT] = 0.0  # straight in the joints: means of rows stay on it
    factor = np.sqrt(off)  # displacement goes with the square of the speed
    cap = laid_out.cycle * find_speed_cap(contour, sampled.shown, sampled.shown_w)
    by_feed = np.diff(sampled.at) / (np.minimum(cap[1:], cap[:-1]) * tuning.ACCEPTED_RATIOS[0])
    factor[1:] = np.maximum(factor[1:], by_feed)
    return np.asarray(factor)


def _compute_remaining_tolerances(tolerance: Array, exact: float) -> Array:
    """The tolerances (n,) that corners leave to the shaper, or the verification's of ``exact`` paths if larger."""
    by_corners = (1.0 - tuning.SHAPER_SHARE) * tolerance
    return np.maximum(tolerance, EXACT_SHARE * exact) - by_corners


def _make_slower_limits(s: Array, factor: Array, cycle: float) -> SpeedLimits:
    """Limits that make the steps between rows s (n,) slower by ``factor`` (n,) where it is above 1."""
    step, needed = np.diff(s), np.maximum(factor[1:], factor[:-1])
    moving = np.flatnonzero(step > 0)
    speed = np.where(needed > 1.0, step / (cycle * tuning.SHAPER_MARGIN * np.maximum(needed, 1.0)), np.inf)
    begin, speed = np.append(s[moving], s[-1]), np.append(speed[moving], np.inf)
    changes = speed != np.append(np.inf, speed[:-1])
    return SpeedLimits(begin[changes], speed[changes])
