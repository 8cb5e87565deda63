"""What contouring costs and gains: limits, deviation, machining time, distance from the optimum, CPU.

Run from the repository's root: python tests/benchmarks/contouring.py [--write]
Prints the tables of docs/performance.md; ``--write`` puts them there, with the machine's name and the date.
Long programs are in scaling.py. Compare ratios: machines are shared and drift.

Velocity, acceleration, jerk and feed are measured on the text of the written file, with differences taken here.
"""

import argparse
import io
import os
import platform
import re
import sys
import textwrap
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray
from page import processor, write_section

import verne_post
from verne_post import Options, convert
from verne_post.app.assemble import assemble
from verne_post.app.constraints import check_program
from verne_post.app.plan import Plan, plan_program
from verne_post.cli.arithmetic import choose_settings
from verne_post.model.machine import Machine
from verne_post.model.part_setup import WorkOffset
from verne_post.model.setpoints import SetpointBlock
from verne_post.model.summary import Summary
from verne_post.output.setpoints import write_csv_header, write_csv_rows
from verne_post.trajectory import continuous, reachability, toppra_backend, tuning
from verne_post.trajectory.plan import ContourSection, PlanningOptions, plan_contour
from verne_post.trajectory.section_path import build_grid_along

Array = NDArray[np.float64]
Answer = TypeVar("Answer")

ROOT = Path(__file__).resolve().parents[2]
#: The third-order reference is planned for programs of at most so much motion, s.
AFFORDABLE_S = 10.0
#: toppra is asked about grids of at most so many points.
TOPPRA_POINTS = 60_000
#: Everything is measured at least so often, and over so many seconds: on shared cores a short measurement is often
#: disturbed.
REPEATS = 3
REPEATS_S = 1.5
ZIGZAG_CORNERS_DEG = (90, 30, 10, 2)
#: mm/min: one that stopping at every corner nearly reaches, and one far above.
ZIGZAG_FEEDS = (3000, 12000)
#: What the columns of the table of times are.
TIME_COLUMNS: Final = (
    "*spline*, *blend* and *off*: machining times with each `--smoothing`; spline is the default.",
    "*over 2nd order*: the excess of all motion over the time-optimal profile without jerk limits, on a grid "
    "along the same contour. The line *motion* of the summary differs from it: it counts only motion without a "
    "stop (`slider_bound.nc`: 14.2 %), and compares with a lower bound of that profile (`blade_5axis.nc`: 1.6 "
    "%).",
    "*over reference*: the excess over the same sections with `--quality`, in sections with blended corners. Of the "
    "blade of 10^4 moves it counts the first 1000 moves. A program with more than 10 s of motion was not measured "
    "(-).",
    "*profile*: the CPU time of planning per millisecond of motion.",
    "*CPU us/move*: the time from text to verified CSV, without start-up.",
)


@dataclass(frozen=True)
class Part:
    """A program to measure; ``cut`` is a shorter one of the same kind where the whole is too long for the
    references.
    """

    name: str
    source: bytes
    options: Options
    cut: bytes | None = None

    @property
    def short(self) -> bytes:
        """What the references are planned for."""
        return self.source if self.cut is None else self.cut


# --- programs --------------------------------------------------------------------------------------


def program(lines: list[str]) -> bytes:
    """Lines of G-code -> a program."""
    return ("\n".join([*lines, "M2"]) + "\n").encode()


def blade(moves: int, *, vectors: bool = False, step: float = 0.2, feed: int = 3000) -> bytes:
    """Finishing passes of short moves over a bulging surface, the tool led by 25 degrees and turning with the surface.

    With A and C words, or the same tool axes as I J K.
    """
    per_pass = round(40 / step)
    x = np.linspace(-20, 20, per_pass + 1)
    lines = [f"G21 G90 G94 G64 P0.01 F{feed}", "G0 X-20 Y-15 Z70 A10 C0"]
    for number in range(-(-moves // (per_pass + 1))):
        y = -15 + 30 * ((0.01 * number) % 1.0)
        along = x[:: 1 if number % 2 == 0 else -1]
        z = 40 + 6 * np.cos(along / 18) * np.cos(y / 25)
        across = 6 / 25 * np.cos(along / 18) * np.sin(y / 25)
        a = 25 + 0.8 * np.degrees(np.arctan(across)) + 3 * np.sin(along / 15)
        c = 0.9 * np.degrees(np.arctan(6 / 18 * np.sin(along / 18) * np.cos(y / 25))) + 8 * np.sin(along / 20)
        words = [f"A{r:.4f} C{t:.4f}" for r, t in zip(a, c, strict=True)]
        if vectors:
            tilt, turn = np.radians(a), np.radians(c)
            axis = np.sin(tilt) * np.sin(turn), np.sin(tilt) * np.cos(turn), np.cos(tilt)
            words = [f"I{i:.7f} J{j:.7f} K{k:.7f}" for i, j, k in zip(*axis, strict=True)]
        lines += [f"G1 X{p:.4f} Y{y:.4f} Z{q:.4f} {axis}" for p, q, axis in zip(along, z, words, strict=True)]
    if vectors:
        lines.insert(2, "G43.5")
    return program([*lines[: moves + 2 + vectors], "G0 Z80"])


def zigzag(corner_deg: float, moves: int = 60, feed: int = 3000) -> bytes:
    """Moves of 1 mm that turn left and right by an angle."""
    half = np.radians(corner_deg) / 2
    k = np.arange(1, moves + 1)
    x, y = -30 + np.cos(half) * k, np.sin(half) * (k % 2)
    lines = ["G21 G90 G94 G64 P0.01", "G0 X-30 Y0 Z60 A0 C0"]
    return program(lines + [f"G1 X{p:.5f} Y{q:.5f} F{feed}" for p, q in zip(x, y, strict=True)])


def cone(step: float = 0.3, radius: float = 30.0, half_deg: float = 15.0, lean_deg: float = 10.0) -> bytes:
    """Flank of a leaning cone frustum as in NAS 979: the axis follows the generators, A and C never rest."""
    half, tilt = np.radians([half_deg, lean_deg])
    turn = np.linspace(0, 2 * np.pi, round(2 * np.pi * radius / step) + 1)
    ring = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros_like(turn)])
    generator = np.stack([-np.sin(half) * np.cos(turn), -np.sin(half) * np.sin(turn), np.full_like(turn, np.cos(half))])
    leaning = np.array([[1, 0, 0], [0, np.cos(tilt), -np.sin(tilt)], [0, np.sin(tilt), np.cos(tilt)]])
    tip, axis = leaning @ ring + [[0.0], [0.0], [60.0]], leaning @ generator
    a = np.degrees(np.arccos(axis[2]))
    c = np.degrees(np.unwrap(np.arctan2(axis[0], axis[1])))
    rows = [f"X{x:.4f} Y{y:.4f} Z{z:.4f} A{p:.4f} C{q:.4f}" for x, y, z, p, q in zip(*tip, a, c, strict=True)]
    return program(["G21 G90 G94 G64 P0.01 F2000", f"G0 {rows[0]}", *(f"G1 {row}" for row in rows[1:])])


def parts() -> Iterator[Part]:
    """What is measured."""
    base = Options(tool_length=80.0)
    yield Part("blade, 10^4 moves of 0.2 mm", blade(10_000), base, cut=blade(1000))
    yield Part("the same, tool vectors", blade(10_000, vectors=True), base, cut=blade(1000, vectors=True))
    for name, vectors in (("blade, 1 mm, F9000", False), ("the same, F9000, tool vectors", True)):
        yield Part(name, blade(1000, vectors=vectors, step=1.0, feed=9000), base)
    yield Part("cone (NAS 979), 0.3 mm", cone(), base)
    yield Part("pocket_3axis.nc", sample("pocket_3axis.nc"), base.changed(wcs={"G54": (-10.0, 15.0, 60.0)}))
    yield Part(
        "blade_5axis.nc", sample("blade_5axis.nc"), Options(tool_length=120.0, wcs={1: WorkOffset((0.0, 0.0, 10.0))})
    )
    yield Part(
        "slider_bound.nc", sample("slider_bound.nc"), Options(tool_length=60.0, wcs={1: WorkOffset((0.0, 0.0, 80.0))})
    )
    for corner_deg in ZIGZAG_CORNERS_DEG:
        yield Part(f"zigzag 1 mm, {corner_deg} deg", zigzag(corner_deg), Options(tool_length=50.0))


def sample(name: str) -> bytes:
    """A program of gcode_samples."""
    return (ROOT / "gcode_samples" / name).read_bytes()


# --- measuring -------------------------------------------------------------------------------------


def converted(part: Part, machine: Machine) -> tuple[str, Summary]:
    """From text to verified CSV: the written file, and its summary."""
    out = io.StringIO()
    out.write(write_csv_header(machine.columns, ()))

    def sink(block: SetpointBlock) -> None:
        out.write(write_csv_rows(block))

    result = convert(part.source, machine, part.options, sink)
    assert result.ok and result.summary is not None, f"{part.name}: {result.findings}"
    return out.getvalue(), result.summary


def least(call: Callable[[], Answer]) -> tuple[float, Answer]:
    """Least CPU seconds of a call that is made again and again, and what it returns."""
    begin = time.process_time()
    spent: list[float] = []
    while len(spent) < REPEATS or time.process_time() - begin < REPEATS_S:
        start = time.process_time()
        answer = call()
        spent.append(time.process_time() - start)
    return min(spent), answer


def programmed_feeds(source: bytes) -> dict[int, float]:
    """Feed in mm/s of every line that feeds, by line number; what the programs above use of G-code is understood."""
    found: dict[int, float] = {}
    feed, motion = 0.0, 0
    for number, text in enumerate(source.decode().upper().splitlines(), start=1):
        words = re.findall(r"([A-Z])\s*([-+.\d]+)", re.sub(r"\([^)]*\)|;.*", "", text))
        for letter, value in words:
            if letter == "F":
                feed = float(value) / 60
            elif letter == "G" and float(value) in (0, 1, 2, 3):
                motion = int(float(value))
        if motion and any(letter in "XYZ" for letter, _value in words):
            found[number] = feed
    return found


def ratios(text: str, part: Part, machine: Machine) -> list[float]:
    """Worst velocity, acceleration, jerk and feed of a file over their limits."""
    rows = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1)
    cycle, q = machine.cycle, rows[:, 1:-1]
    size = np.abs([column.factor for column in machine.columns])
    found = []
    difference = np.concatenate([q[:1].repeat(3, axis=0), q, q[-1:].repeat(3, axis=0)])
    for limit in (machine.limits.velocity, machine.limits.acceleration, machine.limits.jerk):
        difference = np.diff(difference, axis=0) / cycle
        found.append(float((np.abs(difference) / (size * limit)).max()))
    feeds = programmed_feeds(part.source)
    feed = np.array([feeds.get(int(line), np.inf) for line in rows[:, -1]])
    joints = q / [column.factor for column in machine.columns]
    tip, _angles, _ok = machine.five_axis.find_nominal_pose(joints, np.full(len(q), part.options.tool_length))
    speed = np.linalg.norm(np.diff(tip, axis=0), axis=1) / cycle
    return [*found, float((speed / np.maximum(feed[1:], feed[:-1])).max())]


def planned(source: bytes, part: Part, machine: Machine, smoothing: str) -> Plan:
    """The plan of a program with a kind of smoothing."""
    return plan_program(assemble(source, machine, part.options.changed(smoothing=smoothing)))


def seconds(plan: Plan) -> float:
    """Machining time."""
    return float(plan.timeline.first_row[-1] * plan.timeline.cycle)


def sections(plan: Plan) -> list[ContourSection]:
    """All sections of a plan as functions of their path parameter."""
    contour, joints = plan.program.contour, plan.program.build_joint_path()
    begins = np.append(np.flatnonzero(np.diff(contour.section, prepend=-1)), len(contour)).tolist()
    return [ContourSection(joints, first, last, plan.timeline.cycle) for first, last in pairwise(begins)]


def moving_time(plan: Plan) -> float:
    """Machining time without dwells."""
    timeline = plan.timeline
    return float((np.diff(timeline.first_row) * timeline.cycle)[timeline.section >= 0].sum())


def second_order(plan: Plan) -> float:
    """Least time of the same contour under velocity, acceleration and feed, jerk left out, s."""
    total = 0.0
    for section in sections(plan):
        grid = build_grid_along(section)
        total += reachability.find_duration(grid.s, reachability.solve(grid, plan.program.machine.limits))
    return total


def reference_gap(plan: Plan) -> float:
    """Time of the continuous sections over that of the same sections planned with the highest effort, less 1."""
    ours = best = 0
    for number, section in enumerate(sections(plan)):
        if plan.profiles.continuous_first[number] < 0:
            continue
        best += (
            len(continuous.plan_continuous(section, plan.program.machine.limits, plan.program.cycle, tuning.QUALITY).s)
            - 1
        )
        ours += int(plan.profiles.cycles[number])
    return ours / best - 1 if best else float("nan")


def profile_cost(plan: Plan) -> float:
    """CPU of the time profiles, microseconds for one millisecond of motion."""
    program = plan.program
    bounds, _findings = check_program(program)
    spent, _profile = least(
        partial(
            plan_contour,
            program.build_joint_path(),
            bounds.first,
            bounds.second,
            bounds.third,
            program.machine.limits,
            PlanningOptions(program.cycle),
        )
    )
    return 1e3 * spent / moving_time(plan)


# --- tables ----------------------------------------------------------------------------------------


def table(header: list[str], rows: list[list[str]]) -> str:
    """A table in Markdown, columns aligned."""
    widths = [max(len(row[k]) for row in (header, *rows)) for k in range(len(header))]
    lines = [[cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in (header, *rows)]
    lines.insert(1, ["-" * width for width in widths])
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def percent(gap: float) -> str:
    """A gap, or a dash where there is none."""
    return "-" if np.isnan(gap) else f"{100 * gap:.1f} %"


def contour_tables(machine: Machine) -> tuple[str, str]:
    """What is written, and what it takes."""
    written, timed = [], []
    converted(Part("start-up", zigzag(90, moves=3), Options(tool_length=50.0)), machine)
    for part in parts():
        print(f"... {part.name}", file=sys.stderr)
        cpu, (text, summary) = least(partial(converted, part, machine))
        verdict = summary.verification
        assert verdict is not None
        velocity, acceleration, jerk, feed = ratios(text, part, machine)
        written.append(
            [
                part.name,
                f"{velocity:.4f}",
                f"{acceleration:.4f}",
                f"{jerk:.4f}",
                f"{feed:.4f}",
                f"{verdict.tip_deviation_mm:.4f}",
                f"{verdict.axis_deviation_deg:.4f}",
                f"{summary.n_blended}",
                f"{summary.n_stops}",
            ]
        )
        plan = planned(part.source, part, machine, "spline")
        short = plan if part.cut is None else planned(part.short, part, machine, "spline")
        off, blend = (seconds(planned(part.source, part, machine, how)) for how in ("off", "blend"))
        spline = seconds(plan)
        reference = reference_gap(short) if seconds(short) <= AFFORDABLE_S else float("nan")
        timed.append(
            [
                part.name,
                f"{spline:.3f}",
                f"{blend:.3f}",
                f"{off:.3f}",
                f"{off / spline:.2f}",
                percent(moving_time(plan) / second_order(plan) - 1),
                percent(reference),
                f"{profile_cost(plan):.0f}",
                f"{1e6 * cpu / summary.n_segments:.0f}",
            ]
        )
    return (
        table(
            ["program", "velocity", "acceleration", "jerk", "feed", "tip mm", "axis deg", "rounded", "stops"], written
        ),
        table(
            [
                "program",
                "spline s",
                "blend s",
                "off s",
                "off / spline",
                "over 2nd order",
                "over reference",
                "profile us/ms",
                "CPU us/move",
            ],
            timed,
        ),
    )


def gain_table(machine: Machine) -> str:
    """How much longer stopping at every corner takes, with jerk limits and without."""
    rows = []
    for feed in ZIGZAG_FEEDS:
        for corner_deg in ZIGZAG_CORNERS_DEG:
            part = Part("zigzag", zigzag(corner_deg, feed=feed), Options(tool_length=50.0))
            off, spline = (planned(part.source, part, machine, how) for how in ("off", "spline"))
            rows.append(
                [
                    f"F{feed}",
                    f"{corner_deg}",
                    f"{second_order(off) / second_order(spline):.2f}",
                    f"{seconds(off) / seconds(spline):.2f}",
                ]
            )
    return table(["feed", "corner deg", "without jerk limits", "with them"], rows)


def compare_with_toppra(machine: Machine) -> str:
    """The reachability pass against toppra on the same grids, as a sentence."""
    ours, theirs, apart = [], [], []
    for part in parts():
        plan = planned(part.short, part, machine, "spline")
        section = max(sections(plan), key=lambda one: one.length)
        grid, limits = build_grid_along(section), machine.limits
        if len(grid.s) > TOPPRA_POINTS:
            continue
        our_cpu, x = least(partial(reachability.solve, grid, limits))
        their_cpu, other = least(partial(toppra_backend.solve, grid, limits))
        ours.append(1e3 * our_cpu)
        theirs.append(1e3 * their_cpu)
        apart.append(abs(reachability.find_duration(grid.s, other) / reachability.find_duration(grid.s, x) - 1))
    return textwrap.fill(
        f"**The first profile, without jerk limits, against toppra** on the same {len(ours)} grids: ours takes "
        f"{min(ours):.1f} to {max(ours):.1f} ms, toppra {min(theirs):.0f} to {max(theirs):.0f} ms. The times of the "
        f"profiles differ by at most {max(apart):.0e}, relative.",
        120,
    )


def main() -> None:
    """Measure, print, and with --write put the tables into the page."""
    parser = argparse.ArgumentParser(description="Benchmark of contouring.")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/performance.md")
    given = parser.parse_args()
    machine = verne_post.load_machine()
    written, timed = contour_tables(machine)
    blocks = [
        textwrap.fill(
            "**Limits and path.** The ratios come from differences of the numbers in the written "
            "file; *feed* is the largest step of the tip from row to row, rounding included. Verification "
            "measured the distances from the path, *tip* and *axis*. The last two columns count rounded "
            "corners, and stops that remain.",
            120,
        ),
        written,
        "**Time.** The columns are:",
        "\n".join(
            textwrap.fill(f"- {text}", 120, subsequent_indent="  ", break_on_hyphens=False) for text in TIME_COLUMNS
        ),
        timed,
        textwrap.fill(
            "**Zigzags of 1 mm.** Time with a stop at every corner, divided by the time with rounded "
            "corners. The third column has the least times without jerk limits, the fourth the "
            "planned times with them.",
            120,
        ),
        gain_table(machine),
        compare_with_toppra(machine),
    ]
    text = "\n\n".join(block.strip("\n") for block in blocks)
    print(text)
    if given.write:
        ran = f"one thread of {processor()}, Python {platform.python_version()}, numpy {np.__version__}"
        write_section("contouring", text, ran=ran)


if __name__ == "__main__":
    # as the command does; libraries read this when they are loaded
    if not choose_settings().items() <= os.environ.items():
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **choose_settings()})
    main()
