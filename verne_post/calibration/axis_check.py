"""Setpoint files that move one actuator at a time, a little and slowly, and what a person must see then.

For the first motion of a machine whose senses, zeros and scales nobody has proven yet. Rows go from the position that
the drives show to a small distance on either side and back; all other actuators keep their numbers.
"""

import textwrap
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.rotations import rotate_x, rotate_z
from verne_post.base.tolerances import ACCELERATION_RATIO, JERK_RATIO, VELOCITY_RATIO
from verne_post.base.units import DEG_PER_RAD
from verne_post.kinematics.chain.senses import describe_sense, name_direction
from verne_post.model.drives import Drive
from verne_post.model.findings import Finding, InputError, SolverError, UsageError, make_finding
from verne_post.model.machine import Machine
from verne_post.model.poses import Platform, Pose
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.output.rounding import convert_positions, estimate_rounding_noise, name_column, round_setpoints
from verne_post.trajectory.ruckig_backend import plan_rest_to_rest
from verne_post.trajectory.stop_to_stop import StopToStopProfiles

#: Distances that are tried, mm or degrees: the larger one only when all of the smaller one were right.
DISTANCES: Final = (1.0, 10.0)
#: Share of the full speed; accelerations and jerks are this squared and cubed, as an override would have them.
SPEED: Final = 0.02
#: How long it stands at every end, s: time to look.
STANDING_S: Final = 1.0
#: Components of a motion below this are left out of the text, mm.
SEEN_MM: Final = 5e-5
#: And turns below this, degrees: both round to nothing in its four decimals.
SEEN_DEG: Final = 5e-5
#: Points of the table that one can look at: this far from the rotary centre, mm.
MARK_MM: Final = 100.0


class AxisMove(Struct, frozen=True, eq=False):
    """One file: its name, its rows, and what must be seen."""

    name: str
    block: SetpointBlock
    expected_motion: str


def plan_axis_moves(machine: Machine, numbers: tuple[float, ...], fmt: SetpointFormat) -> Iterator[AxisMove]:
    """The files in the order in which they are to be run.

    Parameters
    ----------
    numbers : tuple of float
        Where the machine stands: what the drives read, in the units of the file.

    Raises
    ------
    UsageError
        For a wrong number of values.
    InputError
        VP1xx, VP2xx where the machine cannot stand, without a tool, at the position
        or 10 mm or degrees beside it.
    """
    columns = machine.columns
    if len(numbers) != len(columns):
        names = ",".join(column.joint for column in columns)
        raise UsageError("at", f"takes {len(columns)} values {names}, got {len(numbers)}")
    factor = np.array([column.factor for column in columns])
    here = convert_positions(np.array([numbers]), fmt)[0] / factor
    _require_place(machine, here, "the position of --at")
    driven = [(joint, column) for joint, column in enumerate(columns) if column.driven]
    for distance in DISTANCES:
        for joint, column in driven:
            step = np.zeros(len(columns))
            step[joint] = distance / factor[joint]
            for sign in (1.0, -1.0):
                _require_place(
                    machine, here + sign * step, f"{column.joint} {sign * distance:+g} {column.unit} from --at"
                )
    number = 0
    for distance in DISTANCES:
        for joint, column in driven:
            number += 1
            step = np.zeros(len(columns))
            step[joint] = distance / factor[joint]
            values, written = round_setpoints(
                here + _plan_there_and_back(machine, joint, abs(step[joint]), fmt.cycle)[:, None] * step, machine, fmt
            )
            block = SetpointBlock(0, values, np.zeros(len(values), dtype=np.int32), fmt, written)
            _require_slow(machine, block, joint)
            peak = float(np.abs(np.diff(values[:, joint])).max() / fmt.cycle)
            yield AxisMove(
                f"{number:02d}_{column.joint}_{distance:g}{column.unit}",
                block,
                _describe_motion(machine, fmt.drives, here, step, joint, distance, peak),
            )


def _plan_there_and_back(machine: Machine, joint: int, distance: float, cycle: float) -> Array:
    """Shares of a distance (mm or rad) row by row: 0, +1, 0, -1, 0, standing at each."""
    limits = machine.limits.bound_jerk(cycle)
    durations, jerks = plan_rest_to_rest(
        np.array([distance]),
        SPEED * limits.velocity[[joint]],
        SPEED**2 * limits.acceleration[[joint]],
        SPEED**3 * limits.jerk[[joint]],
    )
    if not np.isfinite(durations).all():
        raise SolverError(
            make_finding("VP420", f"no feasible motion profile for a motion of {machine.columns[joint].joint}")
        )
    profile = StopToStopProfiles(durations, jerks, np.array([distance]))
    total = float(profile.total[0])
    cycles = int(np.ceil(total / cycle))
    share = (
        profile.find_position(np.zeros(cycles + 1, dtype=np.intp), total / cycles * np.arange(cycles + 1.0)) / distance
    )
    stand = np.zeros(int(np.ceil(STANDING_S / cycle)))
    out, back = share[1:], share[::-1][1:]
    return np.concatenate([[0.0], stand, out, 1.0 + stand, back, stand, -out, stand - 1.0, -back, stand])


def _require_place(machine: Machine, q: Array, what: str) -> None:
    """Refuse joint values (n_joints,) at which the machine cannot stand without a tool."""
    findings: list[Finding] = []
    for column, value, low, high in zip(machine.columns, q, machine.limits.lower, machine.limits.upper, strict=True):
        if not low <= value <= high:
            limit = low if value < low else high
            text = (
                f"{what}: {column.header} would be {value * column.factor:.4f}, beyond its limit "
                f"{limit * column.factor:g}"
            )
            findings.append(
                make_finding(
                    column.code,
                    text,
                    axis=column.joint,
                    value=float(value * column.factor),
                    limit=float(limit * column.factor),
                    unit=column.unit,
                )
            )
    platform, closed = machine.five_axis.find_platform(q)
    if not closed:
        findings.append(make_finding("VP110", f"{what}: no position of the platform fits these sliders"))
        raise InputError(*findings)
    tip, angles, _ok = machine.five_axis.find_nominal_pose(q, 0.0)
    for margin, value in zip(
        machine.margins, machine.five_axis.find_geometry_margins(q, angles, platform), strict=True
    ):
        if value < margin.error_below:
            text = f"{what}: {margin.name} is {value:.3f}, below {margin.error_below:g}"
            findings.append(make_finding(margin.code, text, severity="error", axis=margin.axis))
    if tip[2] < 0 and np.hypot(tip[0], tip[1]) < machine.table_radius:
        findings.append(
            make_finding("VP210", f"{what}: the spindle nose would be {-tip[2]:.3f} mm below the table face")
        )
    if machine.clearance is not None:
        axis = machine.five_axis.find_tool_axis(q, angles, platform)
        one = Platform(platform.position[None], platform.angles[None])
        pose = Pose(q[None], one, tip[None], axis[None], np.zeros(1))
        for margin, value in zip(machine.clearance.names, machine.clearance.evaluate(pose)[0][0], strict=True):
            if value < margin.error_below:
                findings.append(
                    make_finding(
                        margin.code, f"{what}: {margin.name} is {value:.3f} {margin.unit}, below {margin.error_below:g}"
                    )
                )
    if findings:
        raise InputError(*findings)


def _require_slow(machine: Machine, block: SetpointBlock, joint: int) -> None:
    """Verify the rows: no other axis moves, and none is faster than two hundredths."""
    dt, column = block.format.cycle, machine.columns[joint]
    moved = np.ptp(block.values, axis=0) > 0
    moved[joint] = False
    noise = (block.format.quanta[joint] / dt, *(part[joint] for part in estimate_rounding_noise(block.format)))
    bounds = machine.limits.bound_jerk(dt)
    limits = (bounds.velocity, bounds.acceleration, bounds.jerk)
    ratios = (VELOCITY_RATIO, ACCELERATION_RATIO, JERK_RATIO)
    difference = block.values[:, joint]
    slow = not moved.any()
    for order, (limit, ratio, allowed) in enumerate(zip(limits, ratios, noise, strict=True), start=1):
        difference = np.diff(difference) / dt
        bound = SPEED**order * limit[joint] * abs(column.factor) * ratio + allowed
        slow = slow and bool(np.abs(difference).max() <= bound)
    if not slow:
        raise AssertionError(f"rows of {column.joint} are not what was planned")


# --- texts: what must be seen -------------------------------------------------------------------------


def _describe_motion(
    machine: Machine, drives: tuple[Drive, ...], here: Array, step: Array, joint: int, distance: float, peak: float
) -> str:
    """What happens on the way to the positive side, in words."""
    column = machine.columns[joint]
    counted = ""
    if drives:
        before, after = (
            drives[joint].find_numbers(np.array([place]) * column.factor)[0]
            for place in (here[joint], here[joint] + step[joint])
        )
        counted = (
            f" The drive counts {'up' if after > before else 'down'} by {abs(after - before):.10g} "
            f"({name_column(column, drives, joint)})."
        )
    first = (
        f"{column.joint} goes {distance:+g} {column.unit}, back, {-distance:+g} {column.unit}, and back, at {peak:.2g} "
        f"{column.unit}/s at most.{counted}"
    )
    if joint < len(machine.columns) - 2:
        return f"{first} On the first way {_describe_nose(machine, here, step)}"
    if machine.coordinates.rotary[joint - len(machine.columns)] in machine.coordinates.head:
        return f"{first} On the first way {describe_sense(machine, here, joint)}."
    return f"{first} On the first way {_describe_mark(machine, here, step)}"


def _describe_nose(machine: Machine, here: Array, step: Array) -> str:
    q = np.stack([here, here + step])
    five_axis = machine.five_axis
    platform, _ok = five_axis.find_platform(q)
    nose = (platform.position + five_axis.nose_offset * platform.turn(five_axis.spindle)) * [1.0, -1.0, -1.0]
    moved = (nose[1] - nose[0]) @ machine.coordinates.part_frame
    against = "" if machine.module is not None else " against the part"
    text = f"the spindle nose moves {_describe_displacement(moved)}{against}."
    if not machine.columns[-1].driven:  # the legs turn the platform in every direction
        leans = np.diff(machine.forward(q, 0.0)[1], axis=0)[0]
        return (
            f"{text} The tool leans by {DEG_PER_RAD * float(np.linalg.norm(leans)):.4f} deg towards "
            f"{name_direction(leans)} of the part."
        )
    turned = DEG_PER_RAD * float(np.diff(platform.alpha)[0])
    return text + (f" The platform tilts by {turned:+.4f} deg about x." if abs(turned) > SEEN_DEG else "")


def _describe_mark(machine: Machine, here: Array, step: Array) -> str:
    """Marks on the table face, seen from where they are now, in directions of the machine with z up."""
    part_frame = machine.coordinates.part_frame
    marks = MARK_MM * part_frame.T[:2]  # along x and y of the part
    a, c = here[-2:]
    before, after = (rotate_x(rotate_z(marks, turn), tilt) for tilt, turn in ((a, c), (a + step[-2], c + step[-1])))
    moved = (after - before) @ part_frame
    far = int(np.argmax(np.linalg.norm(moved, axis=1)))
    mark = f"a mark {MARK_MM:g} mm from the rotary centre, where the table's {'xy'[far]} axis points,"
    return f"{mark} moves {_describe_displacement(moved[far])}."


def _describe_displacement(moved: Array) -> str:
    """A displacement (3,), z up, without what is too little to be seen."""
    x, y, z = moved
    parts = [f"{value:+.4f} mm in {letter}" for value, letter in ((x, "x"), (y, "y")) if abs(value) >= SEEN_MM]
    if abs(z) >= SEEN_MM:
        parts.append(f"{abs(z):.4f} mm {'up' if z > 0 else 'down'}")
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def write_instructions(machine: Machine, moves: Sequence[AxisMove]) -> str:
    """What to do with the files, and what one must see at each."""
    head = (
        f"Axis check of {machine.name}: run the files one by one, in this order, without a tool, one hand on the stop. "
        "Each moves one actuator to its positive side, back, to its negative side and back, as at an override of 2 %, "
        "and rests for a second at each end. Before every file all drives must read what the first row says. x, y and "
        "up are directions of the machine with z up: those of the table at A = C = 0. Stop at the first difference, "
        "correct sign, zero or scale, and begin again with new files. Only when all small motions were right, run the "
        "large ones."
    )
    parts = [textwrap.fill(head, width=100)]
    for move in moves:
        seconds = (len(move.block.values) - 1) * move.block.format.cycle
        text = f"{move.name}.csv ({seconds:.1f} s): {move.expected_motion}"
        parts.append(textwrap.fill(text, width=100, initial_indent="[ ] ", subsequent_indent="    "))
    return "\n\n".join(parts) + "\n"
