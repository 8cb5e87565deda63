"""The same programs by LinuxCNC's planner and by ours: time, joint limits, path; and what makes LinuxCNC slow on
five-axis paths.

Run: python tests/benchmarks/linuxcnc_planner.py [--only NAME] [--write]     with --write the tables go into
docs/performance.md Needs what linuxcnc_run.py says. From 2.10 on both planners run, without jerk limits (0) and with
them (1), into a table of their own. LinuxCNC runs in simulation, in real time, with the exported kinematics under
tool-centre-point control; the joints are sampled each servo period of 1 ms as commanded. Both stand at the first pose
before, and time ends when the last joint stands. Velocity, acceleration, jerk are differences of rows over the limits
of the machine file. Samples have six decimals: that alone shows up to 0.4 of the jerk limit of A. The path is measured
against ours without rounded corners.
"""

import argparse
import re
import tempfile
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from blending import wave
from contouring import Part, blade, program, sample, table, zigzag
from linuxcnc_run import Array, run_program, stream, version, why_not
from page import write_section
from scipy.spatial import cKDTree

import verne_post
from verne_post import Options, convert
from verne_post.model.machine import Machine
from verne_post.model.part_setup import WorkOffset

#: A joint that moves by less in a period stands, mm and degrees: two units of the last place of samples.
STANDS: Final = 2e-6
#: The dwell that separates the way to the first pose from the program, in periods.
DWELL: Final = 400
#: What a radian of tool axis counts where a row's place on the path is looked for, mm.
AXIS_MM: Final = 10.0


class Measured(NamedTuple):
    """One way of running a program."""

    seconds: float
    over: Array  # velocity, acceleration, jerk: the worst joint over its limit
    tip: float  # mm off the programmed path
    axis: float  # degrees

    def cells(self) -> list[str]:
        """For a table."""
        return [f"{self.seconds:.3f}", *(f"{one:.2f}" for one in self.over), f"{self.tip:.3f}, {self.axis:.3f}"]


def parts() -> Iterator[tuple[str, Part]]:
    """Machines and programs."""
    plain = Options(tool_length=50.0)
    for corner in (90, 30, 10, 2):
        yield "serial", Part(f"zigzag 1 mm, {corner} deg, F3000", zigzag(corner), plain)
    for step in (0.1, 0.5):
        source = wave(np.arange(0, 96 + 1e-9, step), 6000).replace(b"G18 ", b"")
        yield "serial", Part(f"wave of {step:g} mm, F6000", source, plain)
    square = [f"G1 X{x} Y{y} F6000" for x, y in ((40, 0), (40, 40), (0, 40), (0, 0))]
    yield (
        "serial",
        Part("square of 40 mm, F6000", program(["G21 G90 G94 G64 P0.01", "G0 X0 Y0 Z60 A0 C0", *square]), plain),
    )
    swing = program(["G21 G90 G94 G64 P0.01", "G0 X150 Y100 Z60 A0 C0", "G0 A60 C170"])
    five = [
        Part(
            "blade_5axis.nc",
            sample("blade_5axis.nc"),
            Options(tool_length=120.0, wcs={1: WorkOffset((0.0, 0.0, 10.0))}),
        ),
        Part("posted.nc", cut_posted(), Options(tool_length=82.5, wcs={1: WorkOffset((0.0, 0.0, 50.0))})),
        Part("blade, 2000 moves of 0.25 mm, F3000", blade(2000, step=0.25), Options(tool_length=80.0)),
        Part("blade, 600 moves of 1 mm, F6000", blade(600, step=1.0, feed=6000), Options(tool_length=80.0)),
        Part("a far swing, rapid", swing, plain),
    ]
    for kind in ("serial", "verne"):
        for part in five:
            yield kind, part


def cut_posted() -> bytes:
    """The sample posted.nc from its first motion to its retract: G28, G53 and the tool table mean other places in
    LinuxCNC.
    """
    lines = sample("posted.nc").decode().splitlines()
    first, last = (next(k for k, line in enumerate(lines) if line.startswith(number)) for number in ("N60", "N180"))
    return program(
        ["G21 G90 G94 G17 G54 G64 P0.01", *(line.replace("G43.4 Z45 H1", "Z45") for line in lines[first : last + 1])]
    )


def convert_rows(machine: Machine, part: Part, **changed: object) -> Array:
    """Our rows (n, 5), units of the machine file."""
    result = convert(part.source, machine, part.options.changed(**changed))
    assert result.setpoints is not None, result.findings
    return np.asarray(result.setpoints.values)


def prepare(machine: Machine, part: Part, first: Array) -> str:
    """The program for LinuxCNC: work offset and tool as our options say, and a way to the first pose before it."""
    factors = np.array([column.factor for column in machine.columns])
    length = part.options.tool_length or 0.0
    tip, angles, _ok = machine.five_axis.find_nominal_pose(first / factors, length)
    place = tip - machine.coordinates.machine_zero + [0.0, 0.0, length]
    a, c = angles * factors[3:]
    offset = part.options.wcs[1].origin_mm if part.options.wcs else (0.0, 0.0, 0.0)
    x, y, z = np.array(offset) - machine.coordinates.machine_zero
    words = f"X{place[0]:.6f} Y{place[1]:.6f} Z{place[2]:.6f} A{a:.6f} C{c:.6f}"
    head = [
        "G21 G90 G94",
        f"G10 L2 P1 X{x:.6f} Y{y:.6f} Z{z:.6f} A0 C0",
        f"G43.1 Z{length:g}",
        f"G53 G0 {words}",
        "G4 P0.6",
    ]
    return "\n".join([*head, part.source.decode()])


def cut_program(joints: Array, first: Array) -> Array:
    """Rows from the standstill at the first pose to the last standstill."""
    moves = (np.abs(np.diff(joints, axis=0)) > STANDS).any(axis=1)
    at_first = (np.abs(joints - first) < 1e-4).all(axis=1)
    still = np.concatenate([[0], np.cumsum(~moves)]) - np.maximum.accumulate(
        np.concatenate([[0], np.where(moves, np.cumsum(~moves), 0)])
    )
    begin = np.flatnonzero(at_first & (still >= DWELL))[0]
    later = np.flatnonzero(moves[begin:])
    return joints[begin + later[0] : begin + later[-1] + 2]


def measure(machine: Machine, part: Part, joints: Array, path: tuple[Array, Array]) -> Measured:
    """What rows (n, 5) do."""
    factors = np.array([column.factor for column in machine.columns])
    rows = np.concatenate([joints[:1]] * 3 + [joints] + [joints[-1:]] * 3) / factors
    limits = (machine.limits.velocity, machine.limits.acceleration, machine.limits.jerk)
    over = np.array(
        [
            (np.abs(np.diff(rows, order + 1, axis=0)).max(axis=0) / machine.cycle ** (order + 1) / limit).max()
            for order, limit in enumerate(limits)
        ]
    )
    tip, axis = find_tools(machine, part, joints)
    # where tip and axis together are nearest: a turn about a standing tip is a path too
    near, there = (np.column_stack([one[0], AXIS_MM * one[1]]) for one in (path, (tip, axis)))
    _far, nearest = cKDTree(near).query(there)
    offs, leans = np.full(len(tip), np.inf), np.full(len(tip), np.inf)
    for side in (-1, 0):
        a = np.clip(nearest + side, 0, len(path[0]) - 2)
        along = near[a + 1] - near[a]
        share = ((there - near[a]) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-18)
        miss = near[a] + np.clip(share, 0.0, 1.0)[:, None] * along - there
        off, lean = np.linalg.norm(miss[:, :3], axis=1), np.degrees(np.linalg.norm(miss[:, 3:], axis=1) / AXIS_MM)
        closer = off < offs
        leans, offs = np.where(closer, lean, leans), np.where(closer, off, offs)
    return Measured((len(joints) - 1) * machine.cycle, over, float(offs.max()), float(leans.max()))


def find_tools(machine: Machine, part: Part, joints: Array) -> tuple[Array, Array]:
    """Tips and tool axes of rows."""
    factors = np.array([column.factor for column in machine.columns])
    tip, axis, _ok = machine.forward(joints / factors, part.options.tool_length or 0.0)
    return tip, axis


def run_linuxcnc(machine: Machine, part: Part, first: Array, ini: dict[str, str] | None = None) -> Array:
    """Rows of LinuxCNC's planner."""
    with tempfile.TemporaryDirectory() as name:
        run = run_program(machine, Path(name), prepare(machine, part, first), 600.0, ini)
    if not run.done:
        raise SystemExit(f"{part.name}: {run.said}")
    return cut_program(run.joints, first)


def has_s_curve() -> bool:
    """Whether LinuxCNC is 2.10 or newer."""
    return tuple(map(int, re.findall(r"\d+", version())[:2])) >= (2, 10)


def list_planners() -> dict[str, dict[str, str] | None]:
    """Planners of LinuxCNC, and the lines of machine.ini that each has in place of others."""
    if not has_s_curve():
        return {"LinuxCNC": None}
    return {"0: no jerk limit": {"PLANNER_TYPE = 1\n": "PLANNER_TYPE = 0\n"}, "1: S-curve": None}


def compare(only: str | None) -> str:
    """Ours beside LinuxCNC's planner; of 2.10 its two planners. A cell has the values of both."""
    rows, planners = [], list(list_planners())
    for kind, part in parts():
        if only is not None and only not in f"{kind} {part.name}":
            continue
        machine = verne_post.load_machine(kind)
        ours = convert_rows(machine, part)
        path = find_tools(machine, part, convert_rows(machine, part, smoothing="off"))
        found = {} if has_s_curve() else {"ours": ours}
        for title, ini in list_planners().items():
            found[title] = run_linuxcnc(machine, part, ours[0], ini)
        both = [measure(machine, part, joints, path).cells() for joints in found.values()]
        rows.append([f"{kind}: {part.name}", *(" / ".join(pair) for pair in zip(*both, strict=True))])
        print(rows[-1], flush=True)
    names = " / ".join(planners if has_s_curve() else ["ours", *planners])
    head = [f"program; each cell: {names}", "s", "velocity", "acceleration", "jerk", "off the path: mm, deg"]
    return table(head, rows).rstrip()


def sum_moves(source: bytes, feed: float, accelerations: Array) -> float:
    """Time of the G1 moves, s, each by itself: the axis that needs longest goes from rest to rest with half its
    acceleration, and the next move begins where it brakes; but none is faster than the ``feed``, mm/s.
    """
    place, ends = dict.fromkeys("XYZAC", 0.0), []
    for line in source.decode().splitlines():
        if line.startswith(("G0 ", "G1 ")):
            place.update({letter: float(number) for letter, number in re.findall(r"([XYZAC])(-?[\d.]+)", line)})
            ends.append([*place.values(), line.startswith("G1 ")])
    rows = np.array(ends)
    way = np.abs(np.diff(rows[:, :5], axis=0))[rows[1:, 5] == 1]
    seconds = np.sqrt(2 * way / accelerations).max(axis=1)
    return float(np.maximum(seconds, np.linalg.norm(way[:, :3], axis=1) / feed).sum())


def find_cause() -> str:
    """Time of the blade by LinuxCNC as one thing after the other is changed, beside that of moves planned one
    by one.
    """
    machine, options = verne_post.load_machine("serial"), Options(tool_length=80.0)
    source = blade(2000, step=0.25)
    straight = b"\n".join(line.split(b" A")[0] if line.startswith(b"G1") else line for line in source.split(b"\n"))
    scale = np.abs([column.factor for column in machine.columns])
    plain = machine.limits.acceleration * scale

    def times_four(*axes: int) -> tuple[Array, dict[str, str]]:
        changed = np.where(np.isin(range(5), axes), 4.0, 1.0) * plain
        lines = {f"MAX_ACCELERATION = {old:.12g}\n": f"MAX_ACCELERATION = {4 * old:.12g}\n" for old in plain[[*axes]]}
        return changed, lines

    cases = (
        ("as it is", source, 50.0, plain, None),
        ("every acceleration times 4", source, 50.0, *times_four(0, 1, 2, 3, 4)),
        ("that of C alone times 4", source, 50.0, *times_four(4)),
        ("that of X, Y, Z alone times 4", source, 50.0, *times_four(0, 1, 2)),
        ("half as many moves of 0.5 mm", blade(1000, step=0.5), 50.0, plain, None),
        ("twice the feed rate", source.replace(b"F3000", b"F6000"), 100.0, plain, None),
        ("G64 P1 in place of G64 P0.01", source.replace(b"P0.01", b"P1"), 50.0, plain, None),
        ("without A and C words", straight, 50.0, plain, None),
    )
    rows = []
    for title, text, feed, accelerations, ini in cases:
        part = Part("blade", text, options)
        first = convert_rows(machine, part)[0]
        took = (len(run_linuxcnc(machine, part, first, ini)) - 1) * machine.cycle
        rows.append([title, f"{took:.2f}", f"{sum_moves(text, feed, accelerations):.2f}"])
        print(rows[-1], flush=True)
    return table(["blade, 2000 moves of 0.25 mm, F3000, on `serial`", "s by LinuxCNC", "s move by move"], rows).rstrip()


def play_back() -> str:
    """Our rows through halstreamer, sampled again."""
    said = []
    for kind, part in parts():
        if "2000" in part.name or "zigzag 1 mm, 30" in part.name:
            rows = convert_rows(verne_post.load_machine(kind), part)
            with tempfile.TemporaryDirectory() as name:
                played = stream(Path(name), rows)
            same = len(played) == len(rows) and np.abs(played - rows).max() <= 5.1e-7
            said.append(f"{kind}, {part.name}: {len(rows)} rows, {'equal' if same else 'DIFFERENT'}")
    return "; ".join(said)


def main() -> None:
    """Measure and print, or write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", help="programs whose name contains this")
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    if why_not() is not None:
        raise SystemExit(f"LinuxCNC: {why_not()}")
    if has_s_curve():
        text, section = compare(given.only), "linuxcnc 2.10 planners"
    else:
        streamed = play_back()
        print(streamed, flush=True)
        text, section = compare(given.only), "linuxcnc planner"
        cause = find_cause() if given.only is None else ""
        text = f"{text}\n\n{cause}\n\n{textwrap.fill(f'Streamed: {streamed}.', 118)}"
    if given.write:
        write_section(section, text, ran=f"LinuxCNC {version()}, verne-post {verne_post.__version__}")
    print(text)


if __name__ == "__main__":
    main()
