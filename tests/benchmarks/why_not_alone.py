"""What toppra and ruckig alone would do of this job: time, limits, stops, import cost and memory.

Run: python tests/benchmarks/why_not_alone.py [--write]     with --write the tables go into docs/contouring.md
The last table is that of serial.toml without jerk limits, for the sections with blended corners: toppra's own profile
on the grid that both solvers are given, on a fine one, and our rows. toppra: its time-optimal profile along the contour
that ours follows, corners blended, sampled each control cycle; no jerk limit. ruckig: a jerk-limited profile for each
segment, from standstill to standstill, along the programmed path (--smoothing off). Ratios are differences of rows over
the limits of the machine, the worst joint. The last table is that of serial.toml without jerk limits: every sample, its
sections with blended corners alone.
"""

import argparse
import os
import platform
import re
import statistics
import subprocess
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from importlib.metadata import version
from typing import Final
from unittest.mock import patch

import contouring
import numpy as np
from contouring import Array, Part, blade, planned, sample, second_order, seconds, sections, table, zigzag
from page import write_section

import verne_post
from verne_post import Options, convert
from verne_post.config.load import build_machine
from verne_post.model.machine import Machine
from verne_post.model.part_setup import WorkOffset
from verne_post.trajectory import reachability, toppra_backend, tuning
from verne_post.trajectory.section_path import Grid, build_grid_along

IMPORTS: Final = {
    "numpy": "import numpy",
    "toppra": "import toppra, toppra.algorithm, toppra.constraint",
    "ruckig": "import ruckig",
    "ours, as far as a conversion needs it": "import verne_post.app.convert, "
    "verne_post.trajectory.continuous, verne_post.app.plan",
}
RUNS: Final = 9
#: Spans of a fine grid are no longer, mm, and all their points are kept.
FINE_SPAN: Final = 0.1


def parts() -> Iterator[tuple[str, Part]]:
    """Machines and programs."""
    plain = Options(tool_length=50.0)
    for corner in (90, 30, 2):
        yield "serial", Part(f"zigzag 1 mm, {corner} deg, F3000", zigzag(corner), plain)
    yield "serial", Part("blade, 600 moves of 1 mm, F6000", blade(600, step=1.0, feed=6000), Options(tool_length=80.0))
    yield "verne", Part("the same on the VERNE", blade(600, step=1.0, feed=6000), Options(tool_length=80.0))
    yield (
        "verne",
        Part(
            "blade_5axis.nc",
            sample("blade_5axis.nc"),
            Options(tool_length=120.0, wcs={1: WorkOffset((0.0, 0.0, 10.0))}),
        ),
    )


def sample_profile(grid: Grid, x: Array, cycle: float) -> Array:
    """Path parameters at whole control cycles of a profile with constant acceleration between grid points, to
    its end.
    """
    speed, step = np.sqrt(x), np.diff(grid.s)
    taken = 2 * step / (speed[:-1] + speed[1:])
    times = np.concatenate([[0.0], np.cumsum(taken)])
    at = np.append(np.arange(0.0, times[-1], cycle), times[-1])
    k = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(step) - 1)
    t = at - times[k]
    rate = (x[k + 1] - x[k]) / (2 * step[k])
    return np.clip(grid.s[k] + speed[k] * t + 0.5 * rate * t * t, grid.s[k], grid.s[k + 1])


def find_ratios(q: Array, machine: Machine) -> list[str]:
    """Velocity, acceleration and jerk of joints (n, 5) over the limits, from rest to rest."""
    rows = np.concatenate([q[:1].repeat(3, axis=0), q, q[-1:].repeat(3, axis=0)])
    found = []
    for limit in (machine.limits.velocity, machine.limits.acceleration, machine.limits.jerk):
        rows = np.diff(rows, axis=0) / machine.cycle
        found.append(f"{(np.abs(rows) / limit).max():.2f}")
    return found


def compare() -> str:
    """All three along each program."""
    rows, gaps = [], []
    for kind, part in parts():
        machine = verne_post.load_machine(kind)
        blended, stopping = (planned(part.source, part, machine, how) for how in ("spline", "off"))
        parts_, total, ours_2nd = [], 0.0, second_order(blended)
        for section in sections(blended):
            grid = build_grid_along(section)
            x = toppra_backend.solve(grid, machine.limits)
            total += reachability.find_duration(grid.s, x)
            parts_.append(section.find_joints(sample_profile(grid, x, machine.cycle)))
        stops = len(parts_) - 1
        rows.append([part.name, "toppra", f"{total:.3f}", *find_ratios(np.concatenate(parts_), machine), f"{stops}"])
        factors = np.array([column.factor for column in machine.columns])
        for title, plan, smoothing in (("ruckig", stopping, "off"), ("ours", blended, "spline")):
            result = convert(part.source, machine, part.options.changed(smoothing=smoothing))
            assert result.setpoints is not None, result.findings
            q = np.asarray(result.setpoints.values) / factors
            rows.append(
                [part.name, title, f"{seconds(plan):.3f}", *find_ratios(q, machine), f"{len(sections(plan)) - 1}"]
            )
        gaps.append(abs(total / ours_2nd - 1))
        print(*rows[-3:], sep="\n", flush=True)
    text = table(["program", "planner", "s", "velocity", "acceleration", "jerk", "stops"], rows)
    return f"{text}\nThe least time without jerk limits by toppra and by ours differs by {max(gaps):.0e} of it at most."


def compare_without_jerk() -> str:
    """Ours and toppra's own profile where nothing but velocity and acceleration is limited."""
    raw = (contouring.ROOT / "machine_configs/serial.toml").read_text(encoding="utf-8")
    machine = build_machine(re.sub(r"(?m)^\w+_jerk = .*$", "", raw).encode(), "serial without jerk")
    rows = []
    for part in contouring.parts():
        if not part.name.endswith(".nc"):
            continue
        plan = planned(part.source, part, machine, "spline")
        continuous = np.flatnonzero(plan.profiles.continuous_first >= 0)
        every = [sections(plan)[k] for k in continuous]
        coarse = [build_grid_along(section) for section in every]
        with patch.multiple(tuning, LONGEST_SPAN=FINE_SPAN, MANY_SPANS=sys.maxsize):
            fine = [build_grid_along(section) for section in every]
        found = [
            sum(reachability.find_duration(grid.s, toppra_backend.solve(grid, machine.limits)) for grid in grids)
            for grids in (coarse, fine)
        ]
        ours = plan.profiles.cycles[continuous].sum() * plan.timeline.cycle
        points = [sum(len(grid.s) for grid in grids) for grids in (coarse, fine)]
        cells = [f"{plan.profiles.second_order_bound_s:.4f}"]
        for seconds_, count in zip(found, points, strict=True):
            cells.append(f"{seconds_:.4f} ({count:,})")
        rows.append([part.name, *cells, f"{ours:.3f}", *(f"{100 * (ours / one - 1):+.2f} %" for one in found)])
        print(rows[-1], flush=True)
    head = ["sample", "bound", "toppra (points)", "on a fine grid", "rows", "rows over toppra", "... the fine grid"]
    return table(head, rows).rstrip()


def weigh_imports() -> str:
    """CPU seconds and peak memory of a process that imports one thing."""
    rows = []
    report = (  # VmHWM begins with the program, which ru_maxrss does not
        "\n"
        "import time\n"
        "print(time.process_time(), *[line.split()[1] for line in open('/proc/self/status') if 'VmHWM' in line])"
    )
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    for name, words in IMPORTS.items():
        found = [
            subprocess.run(
                [sys.executable, "-c", words + report], env=environment, capture_output=True, text=True, check=True
            )
            for _ in range(RUNS)
        ]
        cpu, memory = zip(*(map(float, one.stdout.split()) for one in found), strict=True)
        rows.append([name, f"{statistics.median(cpu):.2f}", f"{statistics.median(memory) / 1024:.0f}"])
    return table(["import", "CPU s", "peak MiB"], rows).rstrip()


def main() -> None:
    """Measure and print, or write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    versions = ", ".join(f"{name} {version(name)}" for name in ("toppra", "ruckig", "numpy"))
    text = (
        f"{versions}, Python {platform.python_version()}, {datetime.now(UTC):%Y-%m-%d}.\n"
        "\n"
        f"{compare()}\n"
        "\n"
        f"{weigh_imports()}"
    )
    without = compare_without_jerk()
    if given.write:
        write_section("toppra and ruckig alone", text, "contouring.md")
        write_section("without jerk limits", without, "contouring.md")
    print(text, without, sep="\n\n")


if __name__ == "__main__":
    main()
