"""What each constant of ``verne_post.trajectory.tuning`` trades: cycle time, CPU and failures over a range of its
values.

Run from the repository's root: nice python tests/benchmarks/tuning.py [--write] [NAME ...]
Prints the table of docs/tuning.md; ``--write`` puts it there, with the machine's name and the date. With names it
measures those constants only. Each constant is varied alone. Only planning is repeated: it ends with rows inside
``ACCEPTED_RATIOS``.
"""

import argparse
import os
import platform
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from contouring import Part, percent, program, sample, table, zigzag
from msgspec.structs import replace
from page import processor, write_section

import verne_post
from verne_post import Options
from verne_post.app.assemble import assemble
from verne_post.app.constraints import check_program
from verne_post.cli.arithmetic import choose_settings
from verne_post.model.machine import Machine
from verne_post.model.part_setup import WorkOffset
from verne_post.trajectory import tuning
from verne_post.trajectory.plan import MotionProfiles, PlanningOptions, plan_contour

#: Each value is measured so often, the present ones more often: the least CPU counts.
REPEATS = 1
REPEATS_AS_IT_IS = 6
#: Changes of CPU below this are noise on shared cores.
CPU_NOISE = 0.1

HALF_TO_DOUBLE = (0.5, 2.0)
WIDE = (0.1, 10.0)
#: Factors by which each constant is multiplied; whole numbers are rounded, and stay 1 or more.
FACTORS: dict[str, tuple[float, ...]] = {
    "TIME_UNIT": HALF_TO_DOUBLE,
    "FEW_ROWS": (0.1, 5.0),
    "SINGLE_ROWS": (0.1, 2.5),
    "SINGLE_OVER": HALF_TO_DOUBLE,
    "CROWDED_ELEMENTS": HALF_TO_DOUBLE,
    "CROWDED_ROUNDS": (0.5, 2.0),
    "VIRTUAL_ACCELERATION": HALF_TO_DOUBLE,
    "VIRTUAL_JERK": HALF_TO_DOUBLE,
    "WINDOW_KNOTS": (0.1, 4.0),
    "LOOK_AHEAD_UNITS": (0.4, 4.0),
    "TOGETHER_VALUES": (0.01, 5.0),
    "WINDOW_END_X": (0.3, 4.0),
    "START_X": (0.7, 1.02),
    "START_RAMP": (0.3, 2.0),
    "CRAWLING_X": WIDE,
    "ROWS_PER_FAR_ROW": WIDE,
    "JERK_BOUND_RATIO": (0.85, 1.5),
    "SMALLEST_X": WIDE,
    "START_SLACK": WIDE,
    "ACCEPTED_INFEASIBILITY": WIDE,
    "FIXED_DIAGONAL": (1e-15, 1e10),
    "TO_BOUNDARY": (0.9, 1.009),
    "SHORT_STEP": (0.3, 2.0),
    "STUCK_STEP": (1e-6, 10.0),
    "LOST_RATIO": (0.75, 10.0),
    "RECENTRE": (0.3, 2.0),
    "LEAST_CURVATURE": (0.1, 5.0),
    "LONG_SECTION": HALF_TO_DOUBLE,
    "SHORT_SECTION": (0.25, 4.0),
    "FINEST_UNIT": HALF_TO_DOUBLE,
    "START_STEP": HALF_TO_DOUBLE,
    "START_SMOOTH": HALF_TO_DOUBLE,
    "START_JERK_EXCESS": (0.25, 4.0),
    "START_SLOWER": (0.7, 1.5),
    "CRUISE_SHARE": (0.5, 1.3),
    "CRUISE_STEP": (0.25, 4.0),
    "CRUISE_EVEN": HALF_TO_DOUBLE,
    "LONGEST_SPAN": (0.25, 4.0),
    "SHORT_SPAN": (0.01, 3.0),
    "SPAN_ELEMENTS": (0.25, 4.0),
    "TAIL_SHARE": WIDE,
    "TAIL_NOISE": (1e-2, 1e2),
    "MANY_SPANS": (0.01, 100.0),
    "JOINT_ROUNDING": (0.1, 100.0),
    "PASS_WINDOW": (0.05, 200.0),
    "CREEPING_MOTION": (0.1, 5.0),
    "CREEPING_ROWS": (0.1, 10.0),
    "REPAIR_REACH": HALF_TO_DOUBLE,
    "REPAIR_ROUNDS": (0.34, 2.0),
    "SHIFT_STEPS": (0.5, 2.0),
    "ACTIVE_SET_STEPS": (0.25, 2.0),
    "SHIFT_DAMPING": (0.01, 100.0),
    "LARGEST_DAMPING": (0.1, 10.0),
    "FAR_RATIO": (0.95, 1.5),
    "GENTLE_LENGTH": (0.1, 10.0),
    "SMALLEST_STRAIN": (0.01, 100.0),
    "SLOWDOWN_ATTEMPTS": (0.2, 2.0),
    "SLOWDOWN_REACH": HALF_TO_DOUBLE,
    "SLOWDOWN_MARGIN": (0.8, 2.0),
    "JUMP_SHARE": (0.5, 1.1),
    "MOST_TURN": (0.5, 1.1),
    "BULGE": (0.5, 1.1),
    "AT_A_TIME": (0.01, 10.0),
    "GRID_ELEMENTS": (0.01, 10.0),
    "GRID_PIECES": (0.25, 10.0),
    "SHARED_ROWS": (0.01, 10.0),
    "BLAS_WORK": (0.1, 10.0),
}
#: Constants that are no plain numbers: their other values.
OTHER_VALUES: dict[str, tuple[Any, ...]] = {
    "TAKEN_OUT_OVER": ((12, 6), (24, 16, 12, 8, 6, 4, 3)),
    "KEPT_POINTS": ([0, 1, 2, 3, 4, 5, 6, 7], [2, 5]),
    "ACCEPTED_RATIOS": ((1.0002, 1.001, 1.007), (1.0006, 1.004, 1.015)),
    "AIMED_RATIOS": ((1.0, 1.0, 1.0), (1.0002, 1.0015, 1.007)),
    "SPEED_SHARES": tuple(np.concatenate([[1.0], np.geomspace(0.97, 0.02, n)]) for n in (10, 90)),
    "ACCELERATION_SHARES": (np.array([1.0, 0.55, 0.12]), np.linspace(1.0, 0.1, 19)),
    "UNEVEN_S": (0.1, 10.0),
    "UNEVEN_RATIO": (1.2, 10.0),
    "STOP_TO_STOP_SHARE": (1.0 - 1e-4, 1.0),
}
#: Constants of other purposes, which change neither time nor CPU of these programs by what they are: what the summary
#: counts; those that are varied piece by piece, those of the input shaper, which these programs do not have
#: (docs/vibration.md), and how many points a grid may have, which they do not reach.
NOT_VARIED = {
    "FEED_REACHED",
    "ALL_ROWS",
    "QUALITY",
    "PLANNED_SHARES",
    "NORMAL",
    "SHAPER_SHARE",
    "SHAPER_ATTEMPTS",
    "SHAPER_MARGIN",
    "GRID_POINTS",
}
#: Factors of the settings of a pass.
PASS_FACTORS: dict[str, tuple[float, ...]] = {
    "knot_units": HALF_TO_DOUBLE,
    "points_per_knot": HALF_TO_DOUBLE,
    "largest_x": HALF_TO_DOUBLE,
    "start_gap": WIDE,
    "final_gap": WIDE,
    "iterations": HALF_TO_DOUBLE,
}


@dataclass(frozen=True)
class Variation:
    """One constant: its name, its value as text, and other values by text."""

    name: str
    value: str
    others: dict[str, Any]
    #: Name of the attribute of the module that is set, if it is not ``name``.
    attribute: str = ""


@dataclass(frozen=True)
class Measured:
    """Cycle time of each program (nan where it fails), and CPU of them all."""

    seconds: np.ndarray
    cpu: float


@dataclass(frozen=True)
class Job:
    """A program that has been checked: what is left is planning."""

    name: str
    cycle: float
    plan: Callable[[], MotionProfiles]


def jobs_of(machine: Machine) -> Iterator[Job]:
    """Assemble and check the programs once."""
    for part in parts():
        program = assemble(part.source, machine, part.options)
        bounds, _findings = check_program(program)
        yield Job(
            part.name,
            program.cycle,
            partial(
                plan_contour,
                program.build_joint_path(),
                bounds.first,
                bounds.second,
                bounds.third,
                program.machine.limits,
                PlanningOptions(program.cycle),
            ),
        )


def parts() -> Iterator[Part]:
    """Programs that a change shows in, from smooth surfaces to sharp corners."""
    yield Part(
        "blade_5axis.nc", sample("blade_5axis.nc"), Options(tool_length=120.0, wcs={1: WorkOffset((0.0, 0.0, 10.0))})
    )
    yield Part(
        "slider_bound.nc", sample("slider_bound.nc"), Options(tool_length=60.0, wcs={1: WorkOffset((0.0, 0.0, 80.0))})
    )
    yield Part("zigzag of 30 degrees, 1 mm, F12000", zigzag(30, feed=12000), Options(tool_length=50.0))
    yield Part("wavy surface, 0.5 mm, F4000", wavy(), Options(tool_length=80.0))
    yield Part("wandering 0.5 mm moves, P0.003 F6000", wandering(), Options(tool_length=80.0, cycle=0.00025))
    yield Part("0.3 mm corners between dwells", dwells(), Options(tool_length=80.0))
    yield Part("0.01 mm moves, cycle 4 ms", scribbles(), Options(tool_length=80.0, cycle=0.004))
    yield Part("small circles, cycle 0.1 s", circles(), Options(tool_length=80.0, cycle=0.1))
    yield Part("arcs from stop to stop", circles(), Options(tool_length=80.0, smoothing="off"))
    yield Part(
        "sharp corners, cycle 0.125 ms",
        wandering(12, "G64 P0.001"),
        Options(tool_length=80.0, cycle=0.000125, smoothing="blend"),
    )


def wavy(moves: int = 160) -> bytes:
    """Moves of 0.5 mm over a wavy surface, the tool axis following it."""
    x = -0.25 * moves + 0.5 * np.arange(moves + 1)
    z, a, c = 55 + 3 * np.sin(x / 5), 15 + 6 * np.sin(x / 7), 8 * np.cos(x / 9)
    lines = ["G21 G90 G94 G64 P0.01 F4000", f"G0 X{x[0]:.4f} Y0 Z{z[0]:.4f} A{a[0]:.4f} C{c[0]:.4f}"]
    return program(lines + [f"G1 X{p:.4f} Z{q:.4f} A{u:.4f} C{v:.4f}" for p, q, u, v in zip(x, z, a, c, strict=True)])


def dwells() -> bytes:
    """Two short moves at a right angle, and a dwell, again and again: many short sections."""
    lines = ["G21 G90 G94 G64 P0.01 F3000", "G0 X0 Y0 Z60 A0 C0"]
    for k in range(12):
        lines += [f"G1 X{0.3 * k + 0.3:.1f} Y{0.3 * k:.1f}", f"G1 Y{0.3 * k + 0.3:.1f}", "G4 P0.01"]
    return program(lines)


def scribbles() -> bytes:
    """Moves of about the tolerance in any direction: more of them than rows."""
    rng = np.random.default_rng(2)
    x, y = np.cumsum(rng.normal(0.0, 0.008, (2, 100)), axis=1)
    lines = ["G21 G90 G94 G64 P0.01 F3000", "G0 X0 Y0 Z60 A0 C0"]
    return program(lines + [f"G1 X{p:.4f} Y{q:.4f}" for p, q in zip(x, y, strict=True)])


def circles() -> bytes:
    """Circles of 0.5 to 3 mm one after the other, joined by lines."""
    lines = ["G21 G90 G94 G64 P0.05 F4000", "G0 X0 Y0 Z60 A0 C0"]
    for k, radius in [*enumerate((0.5, 1.0, 2.0, 3.0))] * 4:
        lines += [f"G1 X{7 * k}", f"G2 X{7 * k} Y0 I{radius} J0", f"G1 X{7 * k + 6} Y0.5", f"G3 X{7 * k + 7} Y0 R1"]
    return program(lines)


def wandering(moves: int = 40, control: str = "G64 P0.003") -> bytes:
    """Moves of 0.5 mm in directions that have little to do with each other; the tool axis wanders too."""
    rng = np.random.default_rng(1)
    heading = np.cumsum(np.radians(rng.uniform(-120, 120, moves)))
    x, y = np.cumsum(0.5 * np.cos(heading)), np.cumsum(0.5 * np.sin(heading))
    a, c = np.cumsum(rng.normal(0, 0.4, (2, moves)), axis=1)
    lines = [f"G1 X{p:.4f} Y{q:.4f} Z60 A{u:.4f} C{v:.4f}" for p, q, u, v in zip(x, y, a, c, strict=True)]
    return program([f"G21 G90 {control} F6000", *lines])


def shown(value: Any) -> str:
    """A constant's value as text; large whole numbers have all their digits."""
    if isinstance(value, np.ndarray):
        return f"{len(value)} values"
    if isinstance(value, (tuple, list)):
        return ", ".join(shown(one) for one in value) if len(str(value)) < 40 else f"{len(value)} values"
    return f"{value:,.0f}" if 10_000 <= abs(value) < 1e9 and value == round(value) else f"{value:.4g}"


def scaled(value: float, factor: float) -> float:
    """A value times a factor; whole numbers stay whole, and 1 or more."""
    return max(round(value * factor), 1) if isinstance(value, int) else value * factor


def variations() -> Iterator[Variation]:
    """All constants with their other values."""
    known = {name for name in vars(tuning) if name.isupper() and not name.startswith("_")}
    listed = {*FACTORS, *OTHER_VALUES, *NOT_VARIED}
    assert known == listed, f"constants and ranges differ: {sorted(known ^ listed)}"
    normal = tuning.NORMAL
    passes: dict[str, tuple[tuning.PassSettings, Callable[[tuning.PassSettings], tuning.Effort]]] = {
        "first pass": (normal.passes[0], lambda one: replace(normal, passes=(one, normal.passes[1]))),
        "second pass": (normal.passes[1], lambda one: replace(normal, passes=(normal.passes[0], one))),
        "last pass": (normal.last, lambda one: replace(normal, last=one)),
    }
    for title, (one, put) in passes.items():
        for name, factors in PASS_FACTORS.items():
            value = getattr(one, name)
            changed = [scaled(value, factor) for factor in factors]
            others = {shown(new): put(replace(one, **{name: new})) for new in changed if new != value}
            yield Variation(f"{title}: {name}", shown(value), others, "NORMAL")
        rows = [some for some in ((0, 0), (1, 2), (2, 3), (3, 4)) if some != one.tightest_rows]
        yield Variation(
            f"{title}: tightest_rows",
            shown(one.tightest_rows),
            {shown(some): put(replace(one, tightest_rows=some)) for some in rows},
            "NORMAL",
        )
    yield Variation(
        "NORMAL.near_bound",
        shown(normal.near_bound),
        {shown(x): replace(normal, near_bound=x) for x in (0.0, 1.2)},
        "NORMAL",
    )
    yield Variation(
        "NORMAL.hopeless",
        shown(normal.hopeless),
        {shown(ratio): replace(normal, hopeless=ratio) for ratio in (1.1, np.inf)},
        "NORMAL",
    )
    yield Variation(
        "NORMAL.repeats", shown(normal.repeats), {shown(n): replace(normal, repeats=n) for n in (1, 6)}, "NORMAL"
    )
    yield Variation(
        "PLANNED_SHARES",
        shown(tuning.PLANNED_SHARES),
        {
            shown(new): replace(
                normal,
                passes=tuple(replace(one, shares=new) for one in normal.passes),
                last=replace(normal.last, shares=new),
            )
            for new in ((0.998, 0.998, 0.99), (1.0, 1.0, 1.0))
        },
        "NORMAL",
    )
    for name, factors in FACTORS.items():
        value = getattr(tuning, name)
        changed = [scaled(value, factor) for factor in factors]
        yield Variation(name, shown(value), {shown(new): new for new in changed if new != value})
    for name, values in OTHER_VALUES.items():
        yield Variation(name, shown(getattr(tuning, name)), {shown(new): new for new in values})


def measure(jobs: list[Job], repeats: int) -> Measured:
    """Plan all programs, and their least CPU."""
    seconds, cpu = np.full(len(jobs), np.nan), 0.0
    for number, job in enumerate(jobs):
        spent = []
        for _ in range(repeats):
            start = time.process_time()
            try:
                seconds[number] = float(job.plan().cycles.sum()) * job.cycle
            except Exception as error:  # a constant far outside its range may break anything
                print(f"    {job.name}: {type(error).__name__}: {error}", file=sys.stderr)
                break
            spent.append(time.process_time() - start)
        cpu += min(spent, default=0.0)
    return Measured(seconds, cpu)


def largest(changes: list[float]) -> float:
    """The change of the largest size, with its sign."""
    return max(changes, key=abs, default=float("nan"))


def row_of(one: Variation, jobs: list[Job], present: Measured) -> list[str]:
    """Measure one constant over its range: a row of the table."""
    attribute = one.attribute or one.name
    before = getattr(tuning, attribute)
    times: list[float] = []
    cpus: list[float] = []
    failed = 0
    for value in one.others.values():
        setattr(tuning, attribute, value)
        try:
            found = measure(jobs, REPEATS)
        finally:
            setattr(tuning, attribute, before)
        lost = np.isnan(found.seconds)
        failed += int(lost.sum())
        times += (found.seconds / present.seconds - 1)[~lost].tolist()
        if not lost.any():
            cpus.append(found.cpu / present.cpu - 1)
    low, high = min(times, default=float("nan")), max(times, default=float("nan"))
    small = max(abs(low), abs(high)) == 0.0
    span = "0" if small else f"{100 * low:+.2f} to {100 * high:+.2f} %"
    if failed:
        span += f"; {failed} without a profile"
    cpu = largest(cpus)
    tried = [key for key in one.others if key != one.value]
    row = [
        f"`{one.name}`",
        one.value,
        "; ".join(tried),
        span,
        "-" if abs(cpu) < CPU_NOISE else f"{100 * cpu:+.0f} %",
    ]
    print(" | ".join(row), file=sys.stderr, flush=True)
    return row


def main() -> None:
    """Measure, print, and with --write put the table into the page."""
    parser = argparse.ArgumentParser(description="Effect of the constants of planning.")
    parser.add_argument("--write", action="store_true", help="put the table into docs/tuning.md")
    parser.add_argument("names", nargs="*", help="constants to measure; all by default")
    given = parser.parse_args()
    machine = verne_post.load_machine()
    jobs = list(jobs_of(machine))
    measure(jobs, 1)  # start-up
    present = measure(jobs, REPEATS_AS_IT_IS)
    assert not np.isnan(present.seconds).any(), "the programs fail with the present constants"
    begin = time.process_time()
    rows = [row_of(one, jobs, present) for one in variations() if not given.names or one.name in given.names]
    minutes = (time.process_time() - begin) / 60
    spread = abs(measure(jobs, REPEATS).cpu / present.cpu - 1)
    text = "\n\n".join(
        [
            f"Measured in {minutes:.0f} minutes of CPU. A repeated measurement differed by "
            f"{percent(spread)} in CPU time.",
            "The programs, and their machining times, are:",
            "\n".join(f"- {job.name} ({took:.2f} s)" for job, took in zip(jobs, present.seconds, strict=True)),
            table(["constant", "value", "values tried", "machining time", "CPU time"], rows).strip("\n"),
        ]
    )
    print(text)
    if given.write:
        ran = f"one thread of {processor()}, Python {platform.python_version()}, numpy {np.__version__}"
        write_section("tuning", text, "tuning.md", ran)


if __name__ == "__main__":
    # as the command does; libraries read this when they are loaded
    if not choose_settings().items() <= os.environ.items():
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **choose_settings()})
    main()
