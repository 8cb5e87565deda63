"""What forward and inverse kinematics cost in a servo thread: closed form, Newton cold, Newton warm, in the exported C.

Run: python tests/benchmarks/kins_time.py [--poses 20000] [--write]     needs gcc; with --write the table goes into
docs/linuxcnc.md Random poses whose joints are within travel and whose rods drop as the machine file asks. Warm starts
from the solution of a pose 0.5 mm and 0.1 degrees beside, what a fast move does in 1 ms. One thread; of each pose the
shortest of five measurements of twenty solutions in a row, so that interruptions by other programs do not count;
"worst" is the slowest pose.
"""

import argparse
import ctypes
import subprocess
import sys
import tempfile
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from page import write_section

import verne_post
from verne_post.output.machine_formats.linuxcnc_kins import write_component

HARNESS = Path(__file__).resolve().parents[1] / "output" / "kins_harness.c"
METHODS = {"closed form": (0, 0), "Newton, cold": (1, 0), "Newton, warm": (1, 1)}
MANY = 20
Array = NDArray[np.float64]


def compile_machine(machine: verne_post.Machine, folder: Path) -> ctypes.CDLL:
    """The exported C as halcompile would compile it."""
    for name, text in write_component(machine).items():
        (folder / name).write_text(text, encoding="utf-8")
    words = ["gcc", "-O2", "-shared", "-fPIC", "-I", str(folder), str(HARNESS), "-o", str(folder / "kins.so"), "-lm"]
    subprocess.run(words, check=True)
    return ctypes.CDLL(str(folder / "kins.so"))


def perturb(folder: Path) -> verne_post.Machine:
    """The VERNE of `machine perturb --seed 1`: parts off by 0.05 mm and 0.1 mrad."""
    path = folder / "built.toml"
    subprocess.run([sys.executable, "-m", "verne_post", "machine", "perturb", "--seed", "1", "-o", path], check=True)
    return verne_post.load_machine(path)


def draw(machine: verne_post.Machine, n: int, reached: bool) -> list[Array]:
    """World poses, poses beside them, tool lengths, joints of both, of poses in travel, or else of those without a
    solution.
    """
    random = np.random.default_rng(0)
    tip = random.uniform(-700.0, 700.0, (n, 3))
    angles = np.radians(random.uniform([-95.0, -180.0], [95.0, 180.0], (n, 2)))
    tool = random.uniform(0.0, 250.0, n)
    beside = random.normal(size=(n, 3))
    beside *= 0.5 / np.linalg.norm(beside, axis=1, keepdims=True)
    factors = np.array([column.factor for column in machine.columns])
    rows = []
    for t, w in ((tip, angles), (tip + beside, angles + np.radians(0.1))):
        world = t - machine.coordinates.machine_zero
        world[:, 2] += tool
        rows += [np.column_stack([world, w * factors[3:]]), machine.five_axis.find_joints(t, w, tool)]
    with np.errstate(invalid="ignore"):
        within = ((rows[1] >= machine.limits.lower) & (rows[1] <= machine.limits.upper)).all(axis=1)
    chosen = within & np.isfinite(rows[3]).all(axis=1) if reached else ~np.isfinite(rows[1]).all(axis=1)
    return [one[chosen] for one in (rows[0], rows[2], tool, rows[1] * factors, rows[3] * factors)]


def measure(
    library: ctypes.CDLL, rows: Array, other: Array, tool: Array, forward: bool, solver: int, warm: int
) -> Array:
    """Nanoseconds of each row."""
    ns = np.empty(len(rows))
    rows, other, tool = (np.ascontiguousarray(one) for one in (rows, other, tool))
    pointers = [one.ctypes.data_as(ctypes.c_void_p) for one in (rows, other, tool)]
    library.time_rows(len(rows), *pointers, int(forward), solver, warm, MANY, ns.ctypes.data_as(ctypes.c_void_p))
    return ns


def study(n: int) -> str:
    """The table."""
    lines = [
        f"{n:,} random poses a machine, {datetime.now(UTC):%Y-%m-%d}, gcc -O2, nanoseconds of the whole machine: "
        "median, then worst pose.",
        "",
        "| machine | direction | closed form | Newton, cold | Newton, warm |",
        "| --- | --- | --- | --- | --- |",
    ]
    for kind in ("verne", "verne, as built", "linear_delta", "serial"):
        with tempfile.TemporaryDirectory() as name:
            machine = perturb(Path(name)) if kind.endswith("as built") else verne_post.load_machine(kind)
            library = compile_machine(machine, Path(name))
            for title, forward, warms in (("inverse", False, 1), ("forward", True, 1), ("inverse, refused", False, 0)):
                world, near, tool, joints, near_joints = (one[:n] for one in draw(machine, 10 * n, bool(warms)))
                rows, other = (joints, near_joints) if forward else (world, near)
                if not len(rows):
                    continue  # a serial machine reaches everything
                cells = ["-"] * len(METHODS)
                for k, (solver, warm) in enumerate(METHODS.values()):
                    if warm <= warms:
                        ns = measure(library, rows, other, tool, forward, solver, warm)
                        cells[k] = f"{np.nanmedian(ns):.0f}, {np.nanmax(ns):.0f}"
                lines.append(f"| `{kind}` | {title} | {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Measure and print, or write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--poses", type=int, default=20_000)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    text = study(given.poses)
    if given.write:
        write_section("kinematics in a servo thread", text, "linuxcnc.md")
    print(text)


if __name__ == "__main__":
    main()
