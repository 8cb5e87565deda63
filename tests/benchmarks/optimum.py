"""How far planned profiles are from the least time along the same contour: a nonlinear program (CasADi and IPOPT, extra
``bench``).

    python tests/benchmarks/optimum.py [--write]

The rows s_k of a section are free, and so is the time from row to row, the same for all; their number is that of the
planned rows. Velocities, accelerations and jerks are differences of the joints at these rows, as verification takes
them, inside the limits at ratio 1; the speed keeps the feed cap. Joints along the contour are a B-spline through a
dense table. The start is the profile of ``--quality``. What is found is a local optimum: the least time is no longer
than this.

The second table has what copp-py finds along the same contours, where it finds a profile (``third_order_peer.py``).
``--write`` puts both into docs/performance.md.
"""

import argparse
import time
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, Final

import casadi
import copp_py
import numpy as np
from blending import LENGTH_MM, corner, load
from contouring import blade, table, zigzag
from msgspec import Struct
from numpy.typing import NDArray
from page import processor, write_section
from third_order_peer import PeerProfile, find_profile

from verne_post import Options
from verne_post.app.assemble import assemble
from verne_post.app.constraints import check_program
from verne_post.model.machine import Limits
from verne_post.trajectory.plan import ContourSection, PlanningOptions, plan_contour

Array = NDArray[np.float64]

#: Points of the table of a section, for each mm: corner blends of some 0.1 mm must be smooth in it.
POINTS_PER_MM: Final = 200
#: The joints' table is a spline of this degree: its third derivative is continuous.
DEGREE: Final = 5
REST_ROWS: Final = 3
LONGEST_S: Final = 240.0


class Comparison(Struct, frozen=True):
    """Times of the longest continuous section, s: planned, with ``--quality``, the least; planning's CPU s; and the
    peer.
    """

    planned_s: float
    quality_s: float
    least_s: float
    cpu_s: float
    peer: PeerProfile | None


def cases() -> Iterator[tuple[str, bytes, str, Options]]:
    """Name, program, machine and options."""
    options = Options(tool_length=LENGTH_MM)
    for angle in (90, 30, 10, 2):
        for feed in (3000, 12000):
            if angle != 30 or feed == 3000:
                yield f"zigzag 1 mm, {angle} deg, F{feed}", zigzag(angle, 12, feed), "serial", options
    yield "corner 90 deg, F3000", corner(90, 3000, 6.0, 6.0), "serial", options
    yield "zigzag 1 mm, 30 deg, F3000, VERNE", zigzag(30, 12, 3000), "verne", options
    yield "blade, 60 moves", blade(60), "verne", Options(tool_length=80.0)


def least_time(section: ContourSection, limits: Limits, rows: Array, cycle: float) -> float:
    """Time of the optimum of one section, s, from the rows (n,) of a profile."""
    n, length = len(rows), section.length
    grid = np.linspace(0.0, length, int(np.ceil(length * POINTS_PER_MM)) + 1)
    joints = section.find_joints(grid)
    moving = np.ptp(joints, axis=0) > 1e-9
    place = [
        casadi.interpolant(f"q{column}", "bspline", [grid], joints[:, column], {"degree": [DEGREE]})
        for column in np.flatnonzero(moving)
    ]
    problem = casadi.Opti()
    inner, stretch = problem.variable(n - 2), problem.variable()
    s = casadi.vertcat(np.zeros(1 + REST_ROWS), inner, np.full(1 + REST_ROWS, length))
    h = cycle * stretch
    cap = section.find_speed(0.5 * (rows[1:] + rows[:-1]))
    steps = s[REST_ROWS + 1 : -REST_ROWS] - s[REST_ROWS : -REST_ROWS - 1]
    problem.subject_to(problem.bounded(0, steps / (cycle * cap), stretch))
    for q, column in zip(place, np.flatnonzero(moving), strict=True):
        value = q(s.T).T
        for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), start=1):
            value = value[1:] - value[:-1]
            scaled = value / (float(limit[column]) * h**order)
            problem.subject_to(problem.bounded(-1, scaled, 1))
    problem.minimize(stretch)
    problem.set_initial(inner, rows[1:-1])
    problem.set_initial(stretch, 1.02)
    quiet: dict[str, Any] = {"print_level": 0, "sb": "yes", "max_wall_time": LONGEST_S, "tol": 1e-7, "max_iter": 600}
    problem.solver("ipopt", {"print_time": False, "expand": False}, quiet)
    try:
        answer = problem.solve()
    except RuntimeError:
        return float("nan")
    return float(answer.value(stretch)) * cycle * (n - 1)


def compare(source: bytes, machine_name: str, options: Options) -> Comparison:
    """Plan a program, and its longest continuous section by the other two ways."""
    machine = load(machine_name)
    program = assemble(source, machine, options)
    bounds, _findings = check_program(program)
    joints, contour = program.build_joint_path(), program.contour
    found, spent = [], []
    for quality in (False, True):
        begun = time.process_time()
        profiles = plan_contour(
            joints,
            bounds.first,
            bounds.second,
            bounds.third,
            machine.limits,
            PlanningOptions(program.cycle, quality=quality),
        )
        spent.append(time.process_time() - begun)
        cycles = np.where(profiles.continuous_first >= 0, profiles.cycles, 0)
        longest = int(np.argmax(cycles))
        begin = int(profiles.continuous_first[longest])
        found.append(profiles.continuous_s[begin : begin + int(cycles[longest]) + 1])
    first, last = list(pairwise(contour.section_begins.tolist()))[longest]
    section = ContourSection(joints, first, last, program.cycle)
    planned, with_quality = ((len(rows) - 1) * program.cycle for rows in found)
    least = least_time(section, machine.limits, found[1], program.cycle)
    return Comparison(planned, with_quality, least, spent[0], find_profile(section, machine.limits, program.cycle))


def peer_row(name: str, got: Comparison) -> list[str]:
    """Row of the second table."""
    ours = [f"{got.cpu_s:.2f}", f"{1e3 * got.planned_s:.0f}"]
    if got.peer is None:
        return [name, *ours, "-", "none found", *["-"] * 4]
    over = f"{100 * (got.peer.time_s / got.least_s - 1):.1f} %"
    changes = [f"{got.peer.programs}", f"{100 * got.peer.last_change:.2f} %"]
    found = [f"{got.peer.cpu_s:.2f}", f"{1e3 * got.peer.time_s:.1f}", over, f"{got.peer.jerk_ratio:.2f}"]
    return [name, *ours, *found, *changes]


def main() -> None:
    """Measure, print, and with --write put the tables into the page."""
    parser = argparse.ArgumentParser(description="Planned profiles against the least time.")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/performance.md")
    given = parser.parse_args()
    rows, peers = [], []
    for name, source, machine, options in cases():
        got = compare(source, machine, options)
        times = (got.planned_s, got.quality_s)
        over = [f"{100 * (seconds / got.least_s - 1):.1f} %" for seconds in times]
        rows.append([name, *(f"{1e3 * seconds:.0f}" for seconds in times), f"{1e3 * got.least_s:.1f}", *over])
        peers.append(peer_row(name, got))
        print(*rows[-1], *peers[-1][1:], sep=" | ", flush=True)
    header = ["contour", "planned ms", "--quality ms", "least ms", "planned over it", "--quality over it"]
    peer_header = [
        "contour",
        "planned CPU s",
        "planned ms",
        "copp CPU s",
        "copp ms",
        "copp over least",
        "jerk of its rows",
        "programs",
        "last change",
    ]
    text = "\n\n".join(
        [
            table(header, rows).strip(),
            table(peer_header, peers).strip(),
        ]
    )
    print(text)
    if given.write:
        ran = f"{processor()}, CasADi {casadi.__version__}, copp-py {copp_py.version()}"
        write_section("optimum", text, ran=ran)


if __name__ == "__main__":
    main()
