"""Iterative against closed form: the comparative study that the paper announces.

Run: python tests/benchmarks/kinematics_study.py [--poses N] [--dense [N]]
Prints markdown: time per pose, iterations, poor starts, and what happens near singularities, for the product's
solutions, for Newton-Raphson on the full constraint equations (newton_raphson.py) and for scipy called pose by pose.
--dense instead compares every assembly mode of N triples of sliders (100,000) with a dense scan (dense_scan.py).
Compare ratios, not absolute times: machines are shared and drift. All ratios are of one run, whose jobs take turns.
"""

import argparse
import datetime
import math
import platform
import time
from collections.abc import Callable
from dataclasses import astuple, replace
from pathlib import Path
from typing import Final

import newton_raphson as nr
import numpy as np
import scipy
from dense_scan import assembly_modes, disagreements
from numpy.typing import NDArray
from scipy.optimize import fsolve, root

import verne_post
from verne_post.kinematics.five_axis import HybridMachine
from verne_post.kinematics.modules.verne.module import VerneModule
from verne_post.kinematics.tables.tilting import TiltingTable

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

REPEATS: Final = 5
#: Poses of the scipy loop, whose time is scaled.
SAMPLE: Final = 300
#: Poses of each row of the tables about failures.
TRIALS: Final = 20_000
#: Two solutions are one within this, mm.
SAME_MM: Final = 1e-6


# --- poses ---------------------------------------------------------------------------------------------------------


def workspace(n: int, seed: int) -> tuple[Array, Array, Array]:
    """Tips within +-150 mm and 0 to 150 mm high, tilts up to 90 degrees, tools of 50 to 250 mm: tip, axis, tool."""
    rng = np.random.default_rng(seed)
    tip = rng.uniform([-150.0, -150.0, 0.0], [150.0, 150.0, 150.0], (n, 3))
    return tip, axes(rng.uniform(0.0, np.pi / 2, n), rng.uniform(-np.pi, np.pi, n)), rng.uniform(50.0, 250.0, n)


def axes(b: Array, c: Array) -> Array:
    """Tool axes of nominal angles."""
    return np.stack([np.sin(b) * np.sin(c), np.sin(b) * np.cos(c), np.cos(b)], axis=-1)


def hung(g: nr.Lengths, side: Array | float, alpha: Array, drop: Array | float) -> tuple[Array, Array]:
    """Pose (n, 4) and sliders (n, 3) with a given tilt and drop of leg I, all legs hanging; NaN where that is
    impossible.

    ``side`` is the sign of x + D1 - d1.
    """
    c, s = np.cos(alpha), np.sin(alpha)
    arm = g.R1 * c - g.r1
    y = -g.R1 * s * drop / arm  # (14)
    with np.errstate(invalid="ignore"):
        x = side * np.sqrt(g.L1**2 - arm**2 - (g.R1 * s) ** 2 - drop**2 - y**2) - g.x1  # (10)
        drop2 = np.sqrt(g.L2**2 - (x + g.x2) ** 2 - (y - g.R2 * c + g.r4) ** 2)
        drop3 = np.sqrt(g.L3**2 - (x + g.x2) ** 2 - (y + g.R2 * c - g.r4) ** 2)
    z = np.full_like(x, 1000.0)
    return np.stack([x, y, z, alpha], axis=-1), np.stack(
        [z - drop, z - g.R2 * s - drop2, z + g.R2 * s - drop3], axis=-1
    )


def near_serial(g: nr.Lengths, drop: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Poses in which leg I has a small drop."""
    alpha = rng.uniform(-0.8, 0.8, 4 * TRIALS)
    return possible(*hung(g, rng.choice([-1.0, 1.0], len(alpha)), alpha, drop))


def near_crossing(g: nr.Lengths, margin: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Poses with R1 cos(alpha) - r1 = margin, y between 100 and 400 mm: leg I then has a small drop as well."""
    alpha = np.full(4 * TRIALS, np.arccos((g.r1 + margin) / g.R1)) * rng.choice([-1.0, 1.0], 4 * TRIALS)
    drop = rng.uniform(100.0, 400.0, len(alpha)) * margin / (g.R1 * np.sin(np.abs(alpha)))
    return possible(*hung(g, rng.choice([-1.0, 1.0], len(alpha)), alpha, drop))


def parallel_singular_geometry() -> nr.Lengths:
    """The VERNE with legs II and III on the side of leg I, so that they are parallel with it in the middle."""
    g = nr.VERNE
    drop1 = np.sqrt(g.L1**2 - (g.R1 - g.r1) ** 2 - g.x1**2)
    slope = g.x1 / drop1
    drop2 = np.sqrt((g.L2**2 - (g.R2 - g.r4) ** 2) / (1 + slope**2))
    return replace(g, x2=float(slope * drop2))


def near_parallel(g: nr.Lengths, away: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Poses in which leg I drops by ``away`` mm more than where the Jacobian of (3)-(6) is singular."""
    alpha = rng.uniform(-0.2, 0.2, 4 * TRIALS)
    low, high = np.full(len(alpha), 100.0), np.full(len(alpha), 840.0)

    def value(drop: Array) -> Array:
        pose, rho = hung(g, -1.0, alpha, drop)
        rows = np.empty((len(alpha), 4, 4))
        c, s = np.cos(alpha), np.sin(alpha)
        for k, (offset, radius, base, sign, slider, _rod) in enumerate(nr._legs(g)):
            dx, dy = pose[:, 0] + offset, pose[:, 1] + sign * (radius * c - base)
            dz = pose[:, 2] + sign * radius * s - rho[:, slider]
            rows[:, k] = np.stack([dx, dy, dz, sign * radius * (dz * c - dy * s)], axis=-1)
        with np.errstate(invalid="ignore"):
            return np.linalg.det(rows)

    first = value(low)
    crossing = first * value(high) < 0
    for _ in range(50):
        middle = 0.5 * (low + high)
        same = value(middle) * first > 0
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    pose, rho = hung(g, -1.0, alpha, low + away)
    return possible(np.where(crossing[:, None], pose, np.nan), rho)


def possible(pose: Array, rho: Array) -> tuple[Array, Array]:
    """The first rows without NaN."""
    fine = np.flatnonzero(np.isfinite(pose).all(axis=1) & np.isfinite(rho).all(axis=1))[:TRIALS]
    return pose[fine], rho[fine]


def as_machine(g: nr.Lengths, table: nr.Table) -> HybridMachine:
    """The product's machine of any lengths."""
    return HybridMachine(
        VerneModule(*astuple(g)),
        TiltingTable(np.array(table.pivot), np.array(table.rotary_offset), np.zeros(3), 1.0, 1.0),
        table.nose,
    )


# --- scipy, pose by pose ---------------------------------------------------------------------------------------------


def plain_inverse(g: nr.Lengths, table: nr.Table, data: Array, start: Array) -> Array:
    """scipy as one writes it down: ``root`` for each pose, on equations of arrays, derivatives left to it."""
    pivot = np.array(table.pivot)
    found = np.empty(start.shape)
    for k in range(len(start)):
        x_known, vy, vz, b, tool = data[:, k]

        def value(u, x_known=x_known, vy=vy, vz=vz, b=b, tool=tool):
            c, s, ct, st = np.cos(u[3]), np.sin(u[3]), np.cos(u[7]), np.sin(u[7])
            held = u[:3] + tool * np.array([0.0, -s, c])
            carried = pivot + np.array([x_known - pivot[0], st * vz - ct * vy, -st * vy - ct * vz])
            return np.concatenate([held - carried, [u[7] - u[3] - b], nr.rods(g, u[None, :4], u[None, 4:7])[:, 0]])

        found[k] = root(value, start[k], tol=1e-10).x
    return found


def plain_forward(g: nr.Lengths, rho: Array, start: Array) -> Array:
    """The same for (3)-(6)."""
    return np.array(
        [
            root(lambda u, slider=slider: nr.rods(g, u[None], slider[None])[:, 0], begin, tol=1e-10).x
            for slider, begin in zip(rho, start, strict=True)
        ]
    )


def scipy_inverse(g: nr.Lengths, table: nr.Table, data: Array, start: Array) -> Array:
    """One fsolve for each pose, on the same eight equations with their Jacobian; scalars, which suit it best."""
    _px, py, pz = table.pivot
    legs = nr._legs(g)
    found = np.full(start.shape, np.nan)
    for k in range(len(start)):
        x_known, vy, vz, b, tool = data[:, k].tolist()

        def value(u, x_known=x_known, vy=vy, vz=vz, b=b, tool=tool):
            x, y, z, alpha, *slider, tilt = u.tolist()
            c, s, ct, st = math.cos(alpha), math.sin(alpha), math.cos(tilt), math.sin(tilt)
            return [
                x - x_known,
                y - tool * s - py + ct * vy - st * vz,
                z + tool * c - pz + st * vy + ct * vz,
                tilt - alpha - b,
                *(
                    (x + o) ** 2 + (y + sign * (r * c - base)) ** 2 + (z + sign * r * s - slider[i]) ** 2 - rod**2
                    for o, r, base, sign, i, rod in legs
                ),
            ]

        def slope(u, vy=vy, vz=vz, tool=tool):
            x, y, z, alpha, *slider, tilt = u.tolist()
            c, s, ct, st = math.cos(alpha), math.sin(alpha), math.cos(tilt), math.sin(tilt)
            rows = [
                [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
                [0.0, 1.0, 0.0, -tool * c, 0.0, 0.0, 0.0, -st * vy - ct * vz],
                [0.0, 0.0, 1.0, -tool * s, 0.0, 0.0, 0.0, ct * vy - st * vz],
                [0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0],
            ]
            for o, r, base, sign, i, _rod in legs:
                dy, dz = y + sign * (r * c - base), z + sign * r * s - slider[i]
                row = [2 * (x + o), 2 * dy, 2 * dz, 2 * sign * r * (dz * c - dy * s), 0.0, 0.0, 0.0, 0.0]
                row[4 + i] = -2 * dz
                rows.append(row)
            return rows

        u, _info, ended, _why = fsolve(value, start[k], fprime=slope, xtol=1e-12, full_output=True)
        if ended == 1:
            found[k] = u
    return found


def scipy_forward(g: nr.Lengths, rho: Array, start: Array) -> Array:
    """One fsolve for each triple, on (3)-(6) with their Jacobian."""
    legs = nr._legs(g)
    found = np.full(start.shape, np.nan)
    for k in range(len(start)):
        slider = rho[k].tolist()

        def value(u, slider=slider):
            x, y, z, alpha = u.tolist()
            c, s = math.cos(alpha), math.sin(alpha)
            return [
                (x + o) ** 2 + (y + sign * (r * c - base)) ** 2 + (z + sign * r * s - slider[i]) ** 2 - rod**2
                for o, r, base, sign, i, rod in legs
            ]

        def slope(u, slider=slider):
            x, y, z, alpha = u.tolist()
            c, s = math.cos(alpha), math.sin(alpha)
            rows = []
            for o, r, base, sign, i, _rod in legs:
                dy, dz = y + sign * (r * c - base), z + sign * r * s - slider[i]
                rows.append([2 * (x + o), 2 * dy, 2 * dz, 2 * sign * r * (dz * c - dy * s)])
            return rows

        u, _info, ended, _why = fsolve(value, start[k], fprime=slope, xtol=1e-12, full_output=True)
        if ended == 1:
            found[k] = u
    return found


# --- time ------------------------------------------------------------------------------------------------------------


def medians(jobs: list[Callable[[], object]]) -> list[float]:
    """Median time of each job, s; the jobs take turns, so that a drift of the machine meets all of them."""
    times: list[list[float]] = [[] for _ in jobs]
    for _ in range(REPEATS):
        for job, taken in zip(jobs, times, strict=True):
            begin = time.perf_counter()
            job()
            taken.append(time.perf_counter() - begin)
    return [float(np.median(taken)) for taken in times]


def print_times(title: str, n: int, rows: list[tuple[str, int, Callable[[], object], str]]) -> None:
    """Table of jobs (name, poses, job, steps); the first is the yardstick."""
    taken = medians([job for _name, _n, job, _steps in rows])
    first = taken[0] / rows[0][1]
    print(f"\n**{title}**, {n:,} random poses\n\n| solution | poses/s | time per pose | steps |\n|---|---|---|---|")
    for (name, poses, _job, steps), seconds in zip(rows, taken, strict=True):
        each = seconds / poses
        print(f"| {name} | {1 / each:,.0f} | {each / first:,.2f} | {steps} |")


def speed(n: int) -> None:
    """Time per pose, everything solved from good starts."""
    machine = verne_post.load_machine()
    g, table = nr.numbers_of(machine.five_axis)
    tip, axis, tool = workspace(n, 1)
    expected, ok = machine.inverse(tip, axis, tool)
    assert ok.all()
    # the pose before, on a path with points 0.2 mm and 0.1 degrees apart: its solution is given, and costs nothing
    rng = np.random.default_rng(2)
    aside = rng.normal(size=(2, n, 3))
    aside *= np.array([0.2, np.radians(0.1)])[:, None, None] / np.linalg.norm(aside, axis=2, keepdims=True)
    axis_before = axis + aside[1]
    axis_before /= np.linalg.norm(axis_before, axis=1, keepdims=True)
    before = nr.inverse(g, table, tip + aside[0], axis_before, tool)[0].values
    middle = nr.middle(g, table, n)
    some = slice(0, SAMPLE)
    data, _c = nr._pose_data(table, tip[some], axis[some], tool[some])
    good = nr.pose_without_tilt(g, table, tip[some], axis[some], tool[some])

    def steps(solved: nr.Solved, values: Array) -> str:
        assert solved.ok.all()
        assert np.abs(values - expected)[:, :3].max() < SAME_MM
        return f"{solved.steps.mean():.2f}"

    def newton(start: Array | None, dense: bool) -> tuple[Callable[[], object], str]:
        job = lambda: nr.inverse(g, table, tip, axis, tool, start, dense)  # noqa: E731
        return job, steps(*job())

    for loop in (scipy_inverse, plain_inverse):
        assert np.abs(loop(g, table, data, good)[:, 4:7] - expected[some, :3]).max() < SAME_MM
    print_times(
        "Inverse, whole machine",
        n,
        [
            ("product: one unknown", n, lambda: machine.inverse(tip, axis, tool), ""),
            *(
                (f"Newton-Raphson, 8 unknowns, {how}, start: {name}", n, *newton(start, dense))
                for dense, how in ((True, "general 8 x 8 solve"), (False, "eliminated by hand"))
                for name, start in (("the same pose without tilt", None), ("pose before", before), ("middle", middle))
            ),
            (
                "scipy fsolve for each pose, derivatives given, start: the same pose without tilt",
                SAMPLE,
                lambda: scipy_inverse(g, table, data, good),
                "",
            ),
            (
                "scipy root for each pose, as one writes it down, start: the same pose without tilt",
                SAMPLE,
                lambda: plain_inverse(g, table, data, good),
                "",
            ),
        ],
    )

    rho = np.ascontiguousarray(expected[:, :3])
    centre = nr.centre(g, rho[some])
    for loop in (scipy_forward, plain_forward):
        assert np.abs(loop(g, rho[some], centre)[:, :3] - nr.forward(g, rho[some]).values[:, :3]).max() < SAME_MM

    def newton_forward(start: Array | None, dense: bool) -> tuple[Callable[[], object], str]:
        job = lambda: nr.forward_machine(g, table, expected, tool, start, dense)  # noqa: E731
        solved, tip_back, _axis = job()
        assert solved.ok.all()
        assert np.abs(tip_back - tip).max() < SAME_MM
        return job, f"{solved.steps.mean():.2f}"

    print_times(
        "Forward, whole machine",
        n,
        [
            ("product: three unknowns", n, lambda: machine.forward(expected, tool), ""),
            *(
                (f"Newton-Raphson, 4 unknowns, {how}, start: {name}", n, *newton_forward(start, dense))
                for dense, how in ((True, "general 4 x 4 solve"), (False, "eliminated by hand"))
                for name, start in (("middle", None), ("pose before", before[:, :4]))
            ),
            (
                "scipy fsolve for each triple (module alone), derivatives given, start: middle",
                SAMPLE,
                lambda: scipy_forward(g, rho[some], centre),
                "",
            ),
            (
                "scipy root for each triple (module alone), as one writes it down, start: middle",
                SAMPLE,
                lambda: plain_forward(g, rho[some], centre),
                "",
            ),
        ],
    )
    few = rho[: n // 20]
    modes, one = medians([lambda: machine.module.forward_modes(few), lambda: machine.module.forward(few)])
    print(f"\nEvery assembly mode (octic, product) takes {modes / one:.0f} times the time of the one in use.")


# --- failures
# -----------------------------------------------------------------------------------------------------------


def percent(mask: Mask) -> str:
    """Share of a mask; what is not quite all or nothing shows."""
    share = 100 * float(np.mean(mask))
    if 0 < share < 0.1 or 99.9 < share < 100:
        return "< 0.1" if share < 50 else "> 99.9"
    return f"{share:.0f}" if share in (0, 100) else f"{share:.1f}"


def poor_starts() -> None:
    """Newton-Raphson and fsolve from starts ever further from the solution."""
    machine = verne_post.load_machine()
    g, table = nr.numbers_of(machine.five_axis)
    tip, axis, tool = workspace(TRIALS, 3)
    found, _q = nr.inverse(g, table, tip, axis, tool)
    u = found.values
    data, _c = nr._pose_data(table, tip[:SAMPLE], axis[:SAMPLE], tool[:SAMPLE])
    rng = np.random.default_rng(4)
    print(
        "\n"
        f"**Poor starts**, {TRIALS:,} poses of the workspace ({SAMPLE} for fsolve): per cent that end in the machine's "
        "mode / in another / nowhere\n"
    )
    print("| start off by | Newton-Raphson inverse | steps | forward | steps | fsolve inverse | fsolve forward |")
    print("|---|---|---|---|---|---|---|")
    lengths = np.array([1, 1, 1, 0, 1, 1, 1, 0], dtype=float)
    for off, turn in ((50.0, 0.1), (150.0, 0.3), (300.0, 0.6), (600.0, 1.2), (1200.0, np.pi)):
        start = u + rng.uniform(-1, 1, u.shape) * (off * lengths + turn * (1 - lengths))
        cells = []
        inverse, _q = nr.inverse(g, table, tip, axis, tool, start)
        forward = nr.forward(g, u[:, 4:7], start[:, :4])
        for solved, truth in ((inverse, u), (forward, u[:, :4])):
            assert np.abs(solved.values - truth)[solved.ok, :3].max() < SAME_MM
            cells += [f"{percent(solved.ok)} / {percent(solved.at_rest & ~solved.ok)} / {percent(~solved.at_rest)}"]
            cells += [f"{solved.steps[solved.at_rest].mean():.1f}"]
        for values in (
            scipy_inverse(g, table, data, start[:SAMPLE])[:, [0, 1, 2, 3, 4, 5, 6]],
            np.column_stack([scipy_forward(g, u[:SAMPLE, 4:7], start[:SAMPLE, :4]), u[:SAMPLE, 4:7]]),
        ):
            ended = np.isfinite(values[:, 0])
            right = np.zeros(SAMPLE, dtype=bool)
            right[ended] = np.abs(values[ended, :3] - u[:SAMPLE][ended, :3]).max(axis=1) < 1e-3
            cells += [f"{percent(right)} / {percent(ended & ~right)} / {percent(~ended)}"]
        print(f"| {off:.0f} mm, {turn:.1f} rad | {' | '.join(cells)} |")
    print("\nThe product's solutions take no start.")


def near_singularities() -> None:
    """What the solvers do where leg I stretches, where its rods cross, and where the platform loses its hold."""
    machine = verne_post.load_machine()
    g, table = nr.numbers_of(machine.five_axis)
    rng = np.random.default_rng(5)
    anywhere = workspace(TRIALS, 6)
    print("\nTimes: over that of the product in the workspace. Newton-Raphson is the one eliminated by hand.")
    for title, make, levels, unit in (
        ("Serial singularity of leg I", near_serial, (300.0, 100.0, 30.0, 10.0, 3.0, 1.0, 0.1, 0.01), "drop"),
        ("Crossing of leg I's rods", near_crossing, (30.0, 10.0, 3.0, 1.0, 0.1), "R1 cos(alpha) - r1"),
    ):
        print(f"\n**{title}**, whole machine, inverse\n")
        print(
            f"| {unit} | poses | product: solved, % | time | Newton-Raphson: solved, % | other mode | nowhere | "
            "steps, mean (most) | time |"
        )
        print("|---|---|---|---|---|---|---|---|---|")
        for level in levels:
            pose, _rho = make(g, level, rng)
            n = len(pose)
            tilt, c = pose[:, 3] + rng.uniform(0.0, np.pi / 2, n), rng.uniform(-np.pi, np.pi, n)
            tool = rng.uniform(50.0, 250.0, n)
            tip, axis = nr.tool_of_pose(table, pose, tilt, c, tool)
            q, ok = machine.inverse(tip, axis, tool)
            ok &= closed(g, table, q, tip, axis, tool)
            solved, _q = nr.inverse(g, table, tip, axis, tool)
            usual, product, newton = medians(
                [
                    lambda: machine.inverse(*anywhere),
                    lambda tip=tip, axis=axis, tool=tool: machine.inverse(tip, axis, tool),
                    lambda tip=tip, axis=axis, tool=tool: nr.inverse(g, table, tip, axis, tool),
                ]
            )
            usual *= n / TRIALS
            print(
                f"| {level:g} mm | {n:,} | {percent(ok)} | {product / usual:.1f} | {percent(solved.ok)} | "
                f"{percent(solved.at_rest & ~solved.ok)} | {percent(~solved.at_rest)} | "
                f"{solved.steps.mean():.1f} ({solved.steps.max()}) | {newton / usual:.1f} |"
            )

    g = parallel_singular_geometry()
    other = as_machine(g, table)
    print(
        "\n**Parallel singularity**, module alone, forward; the VERNE with legs II and III beside leg I "
        f"(D2 - d2 = {g.x2:.1f} mm)\n"
    )
    print(
        "| drop of leg I off the singular one | product: this pose / another in the working mode / none, % | "
        "Newton-Raphson, % | steps, mean (most) | this pose among all modes of the product, % |"
    )
    print("|---|---|---|---|---|")
    for level in (30.0, 3.0, 0.3, 0.03, -0.03, -0.3, -3.0, -30.0):
        pose, rho = near_parallel(g, level, rng)
        position, alpha, ok = other.module.forward(rho)
        solved = nr.forward(g, rho)
        cells = []
        for values, good in ((np.column_stack([position, alpha]), ok), (solved.values, solved.ok)):
            same = good & (np.abs(values[:, :3] - pose[:, :3]).max(axis=1) < 0.5 * abs(level))
            cells.append(f"{percent(same)} / {percent(good & ~same)} / {percent(~good)}")
        modes = other.module.forward_modes(rho[:1000])
        near = np.abs(modes.position - pose[:1000, None, :3]).max(axis=2)
        there = np.nanmin(near, axis=1) < 0.1 * abs(level)
        print(
            f"| {level:+g} mm | {cells[0]} | {cells[1]} | {solved.steps.mean():.1f} ({solved.steps.max()}) | "
            f"{percent(there)} |"
        )


def closed(g: nr.Lengths, table: nr.Table, q: Array, tip: Array, axis: Array, tool: Array) -> Mask:
    """Which joints hold their pose: the tilt is A - b, P then follows from the tool, and the rods must close."""
    (x, vy, vz, b, length), _c = nr._pose_data(table, tip, axis, tool)
    alpha, tilt = q[:, 3] - b, q[:, 3]
    y = table.pivot[1] - (np.cos(tilt) * vy - np.sin(tilt) * vz) + length * np.sin(alpha)
    z = table.pivot[2] - (np.sin(tilt) * vy + np.cos(tilt) * vz) - length * np.cos(alpha)
    residual = np.abs(nr.rods(g, np.stack([x, y, z, alpha], axis=-1), q[:, :3]))
    return np.asarray((residual < nr.CLOSED_MM2).all(axis=0))


# --- all modes
# ------------------------------------------------------------------------------------------------------------


def dense(n: int) -> None:
    """Assembly modes of the product against those of the scan; every triple where they differ, with residuals."""
    g = nr.VERNE
    module = VerneModule(*astuple(g))
    rng = np.random.default_rng(6)
    travel = rng.uniform(50.0, 1250.0, (n, 3))
    level = travel.copy()
    level[:, 2] = level[:, 1] + 10.0 ** rng.uniform(-14.0, 2.0, n) * rng.choice([-1.0, 0.0, 1.0], n)
    position = rng.uniform([-500.0, -550.0, 700.0], [625.0, 550.0, 1300.0], (2 * n, 3))
    used, alpha, ok = module.inverse(position)
    ok[ok] = module.find_geometry_margins(position[ok], alpha[ok])[:, :3].min(axis=1) > 100.0
    used = used[ok & (np.abs(used - 650.0) < 600.0).all(axis=1)][:n]
    print("\n| sliders | triples | 0 | 2 | 4 | 6 modes, % | triples where product and scan differ |")
    print("|---|---|---|---|---|---|---|")
    differing = []
    for name, rho in (
        ("anywhere in their travel of 50 to 1250 mm", travel),
        ("the same, rho3 within 1e-14 to 100 mm of rho2", level),
        ("-1500 to 1500 mm", rng.uniform(-1500.0, 1500.0, (n, 3))),
        ("of poses that the machine file allows", used),
    ):
        bad, counts = 0, np.zeros(9, dtype=int)
        for first in range(0, len(rho), 5000):
            part = rho[first : first + 5000]
            scanned, row = assembly_modes(g, part)
            modes = module.forward_modes(part)
            counts += np.bincount(np.isfinite(modes.alpha).sum(axis=1), minlength=9)
            rows = disagreements(scanned, row, modes.position, modes.alpha)
            bad += len(rows)
            for k in rows:
                theirs = np.column_stack([modes.position[k], modes.alpha[k]])
                differing.append((part[k], scanned[row == k], theirs[np.isfinite(theirs[:, 3])]))
        shares = " | ".join(f"{100 * count / len(rho):.1f}" for count in counts[:8:2])
        print(f"| {name} | {len(rho):,} | {shares} | {bad} |")
    for rho, scanned, theirs in differing:
        print(f"\nrho = {rho.tolist()}")
        for name, poses in (("scan", scanned), ("product", theirs)):
            for pose in poses:
                print(f"  {name}: {pose.tolist()}, residual {np.abs(nr.rods(g, pose[None], rho[None])).max():.1e} mm2")


def computer() -> str:
    """Name of the processor, as far as the system tells."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Iterative against closed form, as markdown.")
    parser.add_argument("--poses", type=int, default=200_000, help="poses of the timed jobs")
    parser.add_argument(
        "--dense", type=int, nargs="?", const=100_000, help="compare all assembly modes of N triples instead"
    )
    arguments = parser.parse_args()
    today = datetime.datetime.now(tz=datetime.UTC).date()
    print(f"{computer()}, one core, {today}, numpy {np.__version__}, scipy {scipy.__version__}")
    if arguments.dense:
        dense(arguments.dense)
    else:
        speed(arguments.poses)
        poor_starts()
        near_singularities()
