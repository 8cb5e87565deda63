"""Time-optimal planners of robots on our programs: Tesseract's TOTG with ruckig's smoothing, and roboplan's TOPP-RA.

Run: python tests/benchmarks/robot_planners.py [--only NAME] [--write]     with --write the table goes into
docs/performance.md Needs pip install tesseract-robotics==0.5.1 roboplan==0.7.0 beside verne-post, best in an
environment of their own. Both plan joints through waypoints, with limits of joints alone: here the ends of the
programmed moves, on the serial machine, whose joints are nearly the part's axes, and places of longer moves each 1 mm.
A radian of A and C is 50 mm, as in our corners. They know no feed rate: where X, Y and Z move alone it is given as a
limit of each of them. Both blend a corner within a distance, 0.01 mm here. Units are metres: in millimetres toppra's
own bound of the speed along the path, 10 units/s, would decide.
"""

import argparse
import tempfile
from collections.abc import Callable
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from contouring import Array, Part, table
from linuxcnc_planner import convert_rows, find_tools, measure, parts
from msgspec import Struct
from page import write_section

import verne_post
from verne_post import convert
from verne_post.model.machine import Machine

#: What a mm and a radian of A and C count, and how far a corner may be blended, m.
MM: Final = 1e-3
RADIAN: Final = 50.0 * MM
TOLERANCE: Final = 0.01 * MM
#: Between two waypoints, m: the joints go straight there.
LONGEST_MOVE: Final = 1.01 * MM
#: Ruckig's smoothing stretches a move again and again, up to so many times its time.
LONGEST: Final = 50.0
#: TOTG gives some places on a straight line the time of the one before, s: a jump of 1 mm if they were played.
SAME_TIME: Final = 1e-6
NAMES: Final = [*"xyzac"]
UNITS: Final = np.array([MM, MM, MM, RADIAN, RADIAN])
PROGRAMS: Final = ("zigzag 1 mm, 90", "zigzag 1 mm, 30", "zigzag 1 mm, 2 deg", "wave of 0.5", "square", "600 moves")


class Task(Struct, frozen=True):
    """Waypoints (n, 5) and limits (5,), all in m, m/s and so on; and the time between rows, s."""

    points: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    cycle: float


def make_task(machine: Machine, part: Part, feed: float) -> Task:
    """What the planners are asked."""
    result = convert(part.source, machine, part.options.changed(smoothing="off"))
    assert result.setpoints is not None, result.findings
    scale = find_scale(machine)
    rows, lines = np.asarray(result.setpoints.values) * scale, np.asarray(result.setpoints.line)
    ends = np.append(np.flatnonzero(np.diff(lines)), len(lines) - 1)
    passed = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(rows, axis=0), axis=1))])
    places = [np.zeros(1)]
    for begin, end in pairwise(passed[[0, *ends]]):
        if end - begin > 1e-3 * MM:
            places.append(np.linspace(begin, end, int(np.ceil((end - begin) / LONGEST_MOVE - 1e-6)) + 1)[1:])
    rising = np.concatenate([[True], np.diff(passed) > 0.0])
    points = np.column_stack([np.interp(np.concatenate(places), passed[rising], one) for one in rows[rising].T])
    limits = machine.limits
    velocity = limits.velocity * UNITS
    if not np.ptp(points[:, 3:], axis=0).any():
        velocity[:3] = np.minimum(velocity[:3], feed * MM)
    return Task(points, velocity, limits.acceleration * UNITS, limits.jerk * UNITS, machine.cycle)


def find_scale(machine: Machine) -> Array:
    """Factors (5,) from units of the machine file to m."""
    return UNITS / [column.factor for column in machine.columns]


def plan_tesseract(task: Task, smoothed: bool) -> Array:
    """Rows (m, 5): its states at the waypoints, with a polynomial of degree 5 between two, as a controller
    plays them.
    """
    from tesseract_robotics import tesseract_command_language as language
    from tesseract_robotics import tesseract_time_parameterization as timing

    program = language.CompositeInstruction()
    for point in task.points:
        state = language.StateWaypointPoly_wrap_StateWaypoint(language.StateWaypoint(NAMES, point))
        move = language.MoveInstruction(state, language.MoveInstructionType_FREESPACE, "DEFAULT")
        program.appendMoveInstruction(language.MoveInstructionPoly_wrap_MoveInstruction(move))
    trajectory = timing.InstructionsTrajectory(program)
    limits = [np.column_stack([-one, one]) for one in (task.velocity, task.acceleration, task.jerk)]
    one = np.ones(1)
    if not timing.TimeOptimalTrajectoryGeneration(TOLERANCE, 1e-4).compute(trajectory, *limits, one, one):
        raise RuntimeError("TOTG found no profile")
    if smoothed and not timing.RuckigTrajectorySmoothing(1.1, LONGEST).compute(trajectory, *limits, one, one, one):
        raise RuntimeError(f"ruckig's smoothing found no profile within {LONGEST:.0f} times the time")
    times, q, v, a = [], [], [], []
    for k in range(len(task.points)):
        # each is held: what it leads to lies within it
        instruction = program[k]
        move = language.InstructionPoly_as_MoveInstructionPoly(instruction)
        waypoint = move.getWaypoint()
        state = language.WaypointPoly_as_StateWaypointPoly(waypoint)
        times.append(state.getTime())
        for rows, one in ((q, state.getPosition()), (v, state.getVelocity()), (a, state.getAcceleration())):
            rows.append(np.array(one, dtype=float).ravel())
    return play(*(np.array(rows) for rows in (times, q, v, a)), task.cycle)


def play(times: Array, q: Array, v: Array, a: Array, cycle: float) -> Array:
    """Rows each cycle of states (n, 5) at times (n,): degree 5 between two; a state at the time of the one before is
    left out.
    """
    apart = np.concatenate([[True], np.diff(times) > SAME_TIME])
    times, q, v, a = (one[apart] for one in (times, q, v, a))
    at = np.append(np.arange(0.0, times[-1], cycle), times[-1])
    k = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    h = (times[k + 1] - times[k])[:, None]
    u = (at - times[k])[:, None] / h
    p0, p1, v0, v1, a0, a1 = q[k], q[k + 1], v[k] * h, v[k + 1] * h, a[k] * h * h, a[k + 1] * h * h
    d, e, f = p1 - p0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0
    return np.asarray(
        p0
        + u
        * (
            v0
            + u
            * (0.5 * a0 + u * (10 * d - 4 * e + 0.5 * f + u * (-15 * d + 7 * e - f + u * (6 * d - 3 * e + 0.5 * f))))
        )
    )


def plan_roboplan(task: Task) -> Array:
    """Rows (m, 5) of straight lines with circular corners, its sample time a cycle."""
    from roboplan import core, toppra

    link = (
        '<link name="l{0}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" '
        'iyz="0"/></inertial></link>'
    )
    joint = (
        '<joint name="{1}" type="prismatic"><parent link="l{0}"/><child link="l{2}"/><axis xyz="1 0 0"/>'
        '<limit lower="-1e5" upper="1e5" effort="1e6" velocity="{3}"/></joint>'
    )
    text = "".join(joint.format(k, name, k + 1, task.velocity[k]) for k, name in enumerate(NAMES))
    urdf = f'<robot name="r">{"".join(link.format(k) for k in range(6))}{text}</robot>'
    limits = "".join(
        f"  {name}:\n    max_acceleration: [{task.acceleration[k]}]\n    max_jerk: [{task.jerk[k]}]\n"
        for k, name in enumerate(NAMES)
    )
    scene = core.Scene("machine", core.loadUrdfSceneDescriptionFromXml(urdf))
    scene.addGroup("all", NAMES)
    with tempfile.TemporaryDirectory() as folder:
        config = Path(folder, "limits.yaml")
        config.write_text(f"joint_limits:\n{limits}", encoding="utf-8")
        scene.importJointLimitsFromConfig(core.loadJointLimitsConfig(config))
    path = core.JointPath()
    path.joint_names, path.positions = NAMES, list(task.points)
    options = toppra.TOPPRAOptions(
        dt=task.cycle, mode=toppra.SplineFittingMode.LinearBlend, max_blend_deviation=TOLERANCE
    )
    return np.array(toppra.PathParameterizerTOPPRA(scene, "all").generate(path, options).positions)


PLANNERS: Final[dict[str, Callable[[Task], Array]]] = {
    "Tesseract: TOTG": lambda task: plan_tesseract(task, smoothed=False),
    "Tesseract: TOTG, ruckig": lambda task: plan_tesseract(task, smoothed=True),
    "roboplan: TOPP-RA": plan_roboplan,
}


def compare(only: str | None) -> str:
    """Every planner and ours on each program."""
    rows = []
    machine = verne_post.load_machine("serial")
    scale = find_scale(machine)
    for kind, part in parts():
        if kind != "serial" or not any(name in part.name for name in (PROGRAMS if only is None else (only,))):
            continue
        feed = float(part.name.rpartition("F")[2]) / 60
        path = find_tools(machine, part, np.asarray(convert_rows(machine, part, smoothing="off")))
        task = make_task(machine, part, feed)
        for title, plan in {**PLANNERS, "ours": None}.items():
            try:
                joints = convert_rows(machine, part) if plan is None else plan(task) / scale
            except RuntimeError as error:
                rows.append([part.name, title, str(error), *["-"] * 5])
            else:
                tip = find_tools(machine, part, joints)[0]
                fastest = np.linalg.norm(np.diff(tip, axis=0), axis=1).max() / machine.cycle / feed
                cells = measure(machine, part, joints, path).cells()
                # the blade has rapids
                rows.append(
                    [part.name, title, *cells[:-1], "-" if "blade" in part.name else f"{fastest:.2f}", cells[-1]]
                )
            print(rows[-1], flush=True)
    head = ["program", "planner", "s", "velocity", "acceleration", "jerk", "feed", "off the path: mm, deg"]
    return table(head, rows).rstrip()


def main() -> None:
    """Measure and print, or write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", help="programs whose name contains this")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    versions = ", ".join(f"{name} {version(name)}" for name in ("tesseract-robotics", "roboplan"))
    text = compare(given.only)
    if given.write:
        write_section("planners of robots", text, ran=f"{versions}, verne-post {verne_post.__version__}")
    print(text)


if __name__ == "__main__":
    main()
