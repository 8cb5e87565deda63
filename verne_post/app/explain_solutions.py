"""Every solution of the whole machine at one pose, and why each is refused: a part of ``explain``."""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from verne_post.app.explain_numbers import format_degrees, format_joint, format_mm
from verne_post.base.arrays import Array
from verne_post.base.numbers import format_fixed
from verne_post.base.printable import join_names
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.tolerances import LIMIT_SLACK, LIMIT_SLACK_MM
from verne_post.base.units import DEG_PER_RAD
from verne_post.kinematics.checks import remedies
from verne_post.model.machine import Machine
from verne_post.model.poses import Platform, Pose
from verne_post.model.protocols import Margin, WholeSolution, name_solution

#: Two pairs of angles, or two sets of joints, that differ by less (rad, mm) are the same in what is printed.
SAME: Final = 1e-6
#: Begins the reason of a solution whose joints leave their travel.
_TRAVEL: Final = "travel of "


def explain_table_solution(
    machine: Machine, name: str, tip: Array, angles: Array, tool: float, lift: float, *, is_programmed: bool = True
) -> Iterator[str]:
    """Whether a table solution is possible, and its margins; of another one than the programmed C may turn wholly."""
    q, platform, ok = machine.five_axis.solve(tip, angles, tool)
    if not ok:
        (code,) = machine.five_axis.explain_unreachable(tip[None], angles[None], tool)
        yield f"{name}: refused: {code}, no solution in the working mode"
        return
    q = q if is_programmed else _turn_into_travel(machine, q)
    measures = _measure_margins(machine, tip, angles, tool, lift)
    beyond = _list_violations(machine, q)
    reasons = [f"beyond the travel of {', '.join(beyond)}"] if beyond else []
    reasons += _list_errors(measures)
    yield f"{name}: " + ("possible" if not reasons else f"refused: {'; '.join(reasons)}")
    if machine.module is not None:
        yield (
            f"  platform             P {format_mm(platform.position)}, platform tilt alpha "
            f"{format_degrees(float(platform.alpha))} deg"
        )
    for column, value, margin in zip(machine.columns, q, find_travel_margins(machine, q), strict=True):
        margin_text = (
            f"margin to its travel {format_fixed(margin, 3)} {column.unit}" if np.isfinite(margin) else "unlimited"
        )
        yield f"  {column.header:<20} {format_fixed(value * column.factor, 3)}   {margin_text}"
    for measure, value in measures:
        what = f"{measure.name} ({measure.axis})" if measure.axis else measure.name
        unit = f" {measure.unit}" if measure.unit else ""
        shown = format_fixed(value, 3 if measure.unit else 6)
        bound = f", must be above {measure.error_below:g}" if np.isfinite(measure.error_below) else ""
        yield f"  {what:<36} {shown}{unit}{bound} ({measure.code})"
    if not any(margin.code == "VP203" for margin in machine.margins):  # axes in a row have no parallel singularity
        return
    parallel, serial = machine.five_axis.measure_conditioning(q, platform)
    yield (
        f"  conditioning (1 even, 0 singular)    parallel {format_fixed(float(parallel), 4)}, serial "
        f"{format_fixed(float(serial), 4)}"
    )


def find_travel_margins(machine: Machine, q: Array) -> Array:
    """How far each joint is from the nearer end of its travel, in the unit of its column; infinite without an end."""
    factors = np.abs([column.factor for column in machine.columns])
    return factors * np.minimum(q - machine.limits.lower, machine.limits.upper - q)


def _measure_margins(
    machine: Machine, tip: Array, angles: Array, tool: float, lift: float
) -> list[tuple[Margin, float]]:
    """Margins of the module, clearances, and the height over the table face, of a pose in the working mode.

    In a dry run the real tool is ``lift`` (mm) shorter than the one that the pose is solved with.
    """
    q, platform, _ok = machine.five_axis.solve(tip, angles, tool)
    found = list(
        zip(machine.margins, machine.five_axis.find_geometry_margins(q, angles, platform).tolist(), strict=True)
    )
    axis = machine.five_axis.find_tool_axis(q, angles, platform)
    tip, tool = tip + lift * axis, tool - lift
    if machine.clearance is not None:
        one = Platform(platform.position[None], platform.angles[None])
        pose = Pose(q[None], one, tip[None], axis[None], np.array([tool]))
        found += zip(machine.clearance.names, machine.clearance.evaluate(pose)[0][0].tolist(), strict=True)
    nose = tip + tool * axis
    for name, point in (("tip over the table face", tip), ("nose over the table face", nose)):
        if np.hypot(point[0], point[1]) < machine.table_radius:
            found.append((Margin(name, "VP210", None, "mm", 0.0, 0.0), float(point[2])))
    return found


def _list_errors(measures: Sequence[tuple[Margin, float]]) -> list[str]:
    return [
        f"{margin.code} {margin.name}" + (f" of {margin.axis}" if margin.axis else "")
        for margin, value in measures
        if value < margin.error_below - LIMIT_SLACK_MM
    ]


def explain_solutions(machine: Machine, tip: Array, angles: Array, q: Array, tool: float, lift: float) -> Iterator[str]:
    """Both table solutions, every tilt, every posture of the legs; the refused ones with all their reasons."""
    axis = find_axis_of_angles(angles[0], angles[1])
    rows = []
    for solution in machine.five_axis.inverse_all(tip, axis, tool):
        reasons = [solution.refused] if solution.refused else []
        in_use = _is(solution, q)
        beyond = _list_violations(machine, q if in_use else _turn_into_travel(machine, np.array(solution.q)))
        if beyond:
            reasons.append(_TRAVEL + ", ".join(beyond))
        if not solution.refused:
            reasons += _list_errors(_measure_margins(machine, tip, np.array(solution.angles), tool, lift))
        rows.append((solution, in_use, reasons))
    usable = sum(not reasons for _solution, _own, reasons in rows)
    by_geometry = sum(solution.refused is not None for solution, _own, _reasons in rows)
    others = [reasons for solution, _own, reasons in rows if reasons and not solution.refused]
    yield (
        f"every solution of the whole machine: {len(rows)}, of which {usable} possible, {by_geometry} refused by "
        f"geometry{_describe_limits(machine, others)}"
    )
    for other in (_has_negative_tilt(angles), not _has_negative_tilt(angles)):
        listed = [row for row in rows if row[0].other_table == other]
        if not listed:
            continue
        turn = format_joint(machine, len(machine.columns) - 1, listed[0][0].q[-1], 4)
        which = "this" if other == _has_negative_tilt(angles) else "other"
        yield f" {which} {name_solution(machine.coordinates)}, {turn}: {len(listed)}"
        for solution, in_use, reasons in sorted(listed, key=lambda row: bool(row[2])):
            signs = ",".join(f"{sign:+d}" for sign in solution.signs)
            mode = f"  s ({signs})" if signs else ""
            joints = ", ".join(format_joint(machine, k, value, 4) for k, value in enumerate(solution.q[:-1]))
            verdict = ("in use" if in_use else "possible") if not reasons else "refused: " + "; ".join(reasons)
            alpha = f"alpha {DEG_PER_RAD * solution.alpha:9.4f} deg{mode}  " if machine.module is not None else ""
            yield f"  {alpha}{joints}  {verdict}"


def _describe_limits(machine: Machine, refusals: Sequence[Sequence[str]]) -> str:
    """``, 2 by the travel of a``: how many solutions limits refuse, and which limits; nothing for none."""
    if not refusals:
        return ""
    named = list(dict.fromkeys(reason for reasons in refusals for reason in reasons))
    beyond = {joint for one in named if one.startswith(_TRAVEL) for joint in one.removeprefix(_TRAVEL).split(", ")}
    joints = [column.joint for column in machine.columns if column.joint in beyond]
    limits = [f"the travel of {', '.join(joints)}"] if joints else []
    limits += [one for one in named if not one.startswith(_TRAVEL)]
    return f", {len(refusals)} by {join_names(limits)}"


def _has_negative_tilt(angles: Array) -> bool:
    """Whether a pair of angles is the table solution with a negative tilt."""
    return bool(np.sin(angles[0]) < -SAME)


def _is(solution: WholeSolution, q: Array) -> bool:
    """Whether a solution is the one of joint values q, whole turns of the table aside."""
    difference = np.array(solution.q) - q
    difference[-2:] = np.remainder(difference[-2:] + np.pi, 2 * np.pi) - np.pi
    return bool(np.abs(difference).max() < SAME)


def _turn_into_travel(machine: Machine, q: Array) -> Array:
    """The same with C by whole turns inside its travel, where that is possible."""
    low, high = machine.limits.lower[-1], machine.limits.upper[-1]
    turns = q[-1] + 2 * np.pi * np.arange(-remedies.TURNS, remedies.TURNS + 1)
    inside = turns[(turns >= low) & (turns <= high)]
    return np.append(q[:-1], inside[np.argmin(np.abs(inside - q[-1]))] if len(inside) else q[-1])


def _list_violations(machine: Machine, q: Array) -> list[str]:
    slack = np.array([LIMIT_SLACK_MM if column.unit == "mm" else LIMIT_SLACK for column in machine.columns])
    bad = (q < machine.limits.lower - slack) | (q > machine.limits.upper + slack)
    return [column.joint for column, out in zip(machine.columns, bad, strict=True) if out]
