"""What corner blends leave of the least time: single corners, also beside arcs, zigzags, facets, neighbouring passes, a
slow program.

    python tests/benchmarks/blending.py [--write]

``--write`` puts the tables into docs/performance.md. The free optimum of corners and zigzags is that of an independent
linear program: p(t) in the plane with piecewise constant jerk, inside a tube of 0.0097 mm, no path and no parameter
prescribed. It holds for the limits of serial.toml (4000 mm/s2, 80,000 mm/s3).
"""

import argparse
import os
import platform
import sys
import time
from functools import cache

import numpy as np
from contouring import program, table
from numpy.typing import NDArray
from page import processor, write_section

import verne_post
from verne_post import Options, convert
from verne_post.app.assemble import assemble
from verne_post.app.plan import plan_program
from verne_post.cli.arithmetic import choose_settings
from verne_post.model.machine import Machine

Array = NDArray[np.float64]
LENGTH_MM = 50.0
LEADS_MM = (8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30)
#: ms that a corner of 90 degrees between long legs loses against its feed rate, by feed rate in mm/min.
FREE_CORNER_MS = {1500: 11.3, 3000: 24.7, 6000: 44.4}
#: ms a corner of zigzags with moves of 1 mm at F3000, by angle.
FREE_ZIGZAG_MS = {90: 48.1, 30: 36.3, 10: 21.7}
RANDOM_CORNERS = 250
ARC_RADII_MM = (1, 5, 20, 50)


@cache
def load(name: str) -> Machine:
    """A machine, read once."""
    return verne_post.load_machine(name)


def seconds(source: bytes, machine: str, smoothing: str = "spline", cycle: float | None = None) -> float:
    """Planned time of a program."""
    options = Options(tool_length=LENGTH_MM, smoothing=smoothing, cycle=cycle)
    timeline = plan_program(assemble(source, load(machine), options)).timeline
    return float(timeline.first_row[-1] * timeline.cycle)


def corner(angle_deg: float, feed: float, before: float, after: float, heading: float = 0.0) -> bytes:
    """Two moves, mm, with a corner between."""
    turn = heading + np.radians(angle_deg)
    x, y = before * np.cos(heading), before * np.sin(heading)
    ends = [(x, y), (x + after * np.cos(turn), y + after * np.sin(turn))]
    return program(
        [f"G21 G90 G94 G64 P0.01 F{feed:g}", "G0 X0 Y0 Z60 A0 C0", *(f"G1 X{p:.5f} Y{q:.5f}" for p, q in ends)]
    )


def corner_table() -> str:
    """One corner of 90 degrees between lines of many lengths: time lost against the feed rate, least, most, and with a
    stop.
    """
    rows, slower = [], 0
    for machine in ("serial", "verne"):
        for feed in (1500, 3000, 6000):
            lost = {"spline": [], "off": []}  # type: dict[str, list[float]]
            for lead in LEADS_MM:
                straight = seconds(program([f"G21 G94 F{feed}", "G0 X0 Y0 Z60", f"G1 X{lead + 20}"]), machine)
                for smoothing, column in lost.items():
                    column.append(1e3 * (seconds(corner(90, feed, lead, 20), machine, smoothing) - straight))
            slower += sum(ours > stop for ours, stop in zip(lost["spline"], lost["off"], strict=True))
            free = f"{FREE_CORNER_MS[feed]}" if machine == "serial" else "-"
            rows.append(
                [
                    f"{machine} F{feed}",
                    f"{min(lost['spline']):.0f}",
                    f"{max(lost['spline']):.0f}",
                    free,
                    f"{min(lost['off']):.0f}",
                ]
            )
    rng, worse = np.random.default_rng(4), 0
    for _ in range(RANDOM_CORNERS):
        feed, machine = rng.choice([1500, 3000, 6000, 12000]), str(rng.choice(["serial", "verne", "linear_delta"]))
        source = corner(rng.uniform(20, 150), feed, *10 ** rng.uniform(-0.3, 1.4, 2), rng.uniform(0, 2 * np.pi))
        cycle = float(rng.choice([0.25e-3, 0.5e-3, 1e-3, 2e-3, 4e-3]))
        worse += seconds(source, machine, cycle=cycle) > seconds(source, machine, "off", cycle)
    return (
        table(["corner of 90 degrees, 0.01 mm", "least ms lost", "most ms lost", "free optimum ms", "stop, ms"], rows)
        + "\n"
        f"Slower than a stop: {slower} of {len(LEADS_MM) * 6} of these, and {worse} of {RANDOM_CORNERS} random corners "
        "(20 to 150 degrees, legs of\n0.5 to 25 mm, three machines, cycles of 0.25 to 4 ms).\n"
    )


def beside_arc(angle_deg: float, feed: float, radius: float) -> bytes:
    """A line of 13 mm, a corner, and an arc of 12 mm or 300 degrees that goes on to the same side."""
    turn, sweep = np.radians(angle_deg), min(np.radians(300), 12.0 / radius)
    center = np.array([13.0, 0.0]) + radius * np.array([-np.sin(turn), np.cos(turn)])
    end = center + radius * np.array([np.sin(turn + sweep), -np.cos(turn + sweep)])
    arc = f"G3 X{end[0]:.6f} Y{end[1]:.6f} I{center[0] - 13.0:.6f} J{center[1]:.6f}"
    return program([f"G21 G90 G94 G64 P0.01 F{feed:g}", "G0 X0 Y0 Z60 A0 C0", "G1 X13 Y0", arc])


def arc_table() -> str:
    """Corners between a line and an arc: the most time that they lose beyond a corner between lines, over angles."""
    rows = []
    for machine in ("serial", "verne"):
        for feed in (1500, 3000, 6000):
            beyond = []
            for angle_deg in (0, 10, 30, 60, 90):
                line = seconds(corner(angle_deg, feed, 13, 12), machine) - 25 * 60 / feed
                lengths = [13 + min(np.radians(300) * radius, 12.0) for radius in ARC_RADII_MM]
                beyond.append(
                    [
                        1e3 * (seconds(beside_arc(angle_deg, feed, radius), machine) - length * 60 / feed - line)
                        for radius, length in zip(ARC_RADII_MM, lengths, strict=True)
                    ]
                )
            rows.append([f"{machine} F{feed}", *(f"{one:.0f}" for one in np.max(beyond, axis=0))])
    return table(
        [
            "corner between line and arc, ms beyond a corner of lines",
            *(f"radius {radius} mm" for radius in ARC_RADII_MM),
        ],
        rows,
    )


def zigzag(angle_deg: float, moves: int) -> bytes:
    """Moves of 1 mm at F3000 that turn to both sides by turns."""
    half, k = np.radians(angle_deg) / 2, np.arange(1, moves + 1)
    ends = zip(np.cos(half) * k, np.sin(half) * (k % 2), strict=True)
    return program(["G21 G90 G94 G64 P0.01 F3000", "G0 X0 Y0 Z60 A0 C0", *(f"G1 X{x:.5f} Y{y:.5f}" for x, y in ends)])


def zigzag_table() -> str:
    """Milliseconds a corner, without the ends."""
    rows = []
    for angle_deg, free in FREE_ZIGZAG_MS.items():
        ours, stop = (
            1e3 * (seconds(zigzag(angle_deg, 60), "serial", how) - seconds(zigzag(angle_deg, 20), "serial", how)) / 40
            for how in ("spline", "off")
        )
        rows.append([f"{angle_deg} deg", f"{ours:.1f}", f"{free}", f"{ours / free:.2f}", f"{stop:.1f}"])
    return table(["zigzag of 1 mm, F3000, serial", "ms per corner", "free optimum ms", "ratio", "stop, ms"], rows)


def wave(x: Array, feed: float, *, arcs: bool = False) -> bytes:
    """A surface with waves of 16 mm, 2 mm high, cut along x (n,) in mm, with three decimals: lines, or arcs as curved
    as it is.
    """
    z = 60 + 2 * np.sin(np.pi * x / 8)
    ends = [f"X{p:.3f} Z{q:.3f}" for p, q in zip(x, z, strict=True)]
    words = [f"G1 {end}" for end in ends]
    if arcs:
        middle, way = 0.5 * (x[1:] + x[:-1]), np.sign(x[1] - x[0])
        slope, bend = np.pi / 4 * np.cos(np.pi * middle / 8), -(np.pi**2) / 32 * np.sin(np.pi * middle / 8)
        curvature = bend / (1 + slope**2) ** 1.5
        words[1:] = [
            f"G{2 if k * way > 0 else 3} {end} R{abs(1 / k):.3f}" if abs(k) > 1e-4 else f"G1 {end}"
            for end, k in zip(ends[1:], curvature, strict=True)
        ]
    return program([f"G21 G90 G94 G18 G64 P0.01 F{feed:g}", f"G0 Y0 A0 C0 {ends[0]}", *words[1:]])


def speeds(source: bytes, feed: float, machine: str) -> tuple[Array, Array]:
    """Where the tip is between rows, mm along x in order, and its speed there over the feed rate."""
    result = convert(source, load(machine), Options(tool_length=LENGTH_MM))
    assert result.setpoints is not None, result.findings
    joints = result.setpoints.values / [column.factor for column in load(machine).columns]
    tip, _angles, _ok = load(machine).five_axis.find_nominal_pose(joints, np.full(len(joints), LENGTH_MM))
    at, speed = 0.5 * (tip[1:, 0] + tip[:-1, 0]), np.linalg.norm(np.diff(tip, axis=0), axis=1) / load(machine).cycle
    order = np.argsort(at)
    return at[order], speed[order] * 60 / feed


def surface_table() -> str:
    """Time of a wave by steps, and how two passes of opposite directions, their points half a step apart, differ in
    speed.
    """
    rows, places = [], np.linspace(20, 76, 4000)
    for machine in ("serial", "verne"):
        for step, arcs in ((0.1, False), (0.25, False), (0.5, False), (0.25, True), (0.5, True), (1.0, True)):
            x = np.arange(0, 96 + 1e-9, step)
            differences = []
            for feed in (4000, 12000):
                passes = (wave(along, feed, arcs=arcs) for along in (x, x[::-1][:-1] - step / 2))
                there, back = (speeds(source, feed, machine) for source in passes)
                differences.append(np.abs(np.interp(places, *there) - np.interp(places, *back)).max())
            rows.append(
                [
                    f"{machine}, {'arcs of ' if arcs else ''}{step:g} mm",
                    f"{seconds(wave(x, 12000, arcs=arcs), machine):.3f}",
                    *(f"{100 * one:.2f} %" for one in differences),
                ]
            )
    header = ["wave of 96 mm", "s at F12000", "speeds differ at F4000 by", "at F12000 by"]
    return table(header, rows)


def slow_table() -> str:
    """A program that hardly ever brakes: 4,500 moves of 5 mm at F1200 along a spiral, CPU of everything up to
    the rows.
    """
    turn = np.linspace(0, 60 * np.pi, 4501)
    radius = 15 + 25 * turn / turn[-1]
    x, y, z = radius * np.cos(turn), radius * np.sin(turn), 60 + 3 * np.sin(turn / 7)
    ends = (f"G1 X{p:.4f} Y{q:.4f} Z{r:.4f}" for p, q, r in zip(x, y, z, strict=True))
    source = program(["G21 G90 G94 G64 P0.01 F1200", f"G0 X{x[0]:.4f} Y{y[0]:.4f} Z60 A0 C0", *ends])
    begin = time.process_time()
    result = convert(source, load("verne"), Options(tool_length=LENGTH_MM), lambda block: None)
    spent = time.process_time() - begin
    assert result.summary is not None
    duration = float(result.summary.cycle_time)
    return table(
        ["slow program, 4,500 moves, verne", "motion s", "CPU s", "us/ms"],
        [["spiral, F1200", f"{duration:.0f}", f"{spent:.1f}", f"{1e3 * spent / duration:.1f}"]],
    )


def main() -> None:
    """Measure, print, and with --write put the tables into the page."""
    parser = argparse.ArgumentParser(description="Benchmark of corner blends.")
    parser.add_argument("--write", action="store_true", help="put the tables into docs/performance.md")
    given = parser.parse_args()
    parts = []
    for measure in (corner_table, arc_table, zigzag_table, surface_table, slow_table):
        print(f"... {measure.__name__}", file=sys.stderr)
        parts.append(measure().strip("\n"))
    text = "\n\n".join(parts)
    print(text)
    if given.write:
        ran = f"one thread of {processor()}, Python {platform.python_version()}, numpy {np.__version__}"
        write_section("blending", text, ran=ran)


if __name__ == "__main__":
    # as the command does; libraries read this when they are loaded
    if not choose_settings().items() <= os.environ.items():
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, **choose_settings()})
    main()
