"""Rates of the two kernels everything else waits for: reading a program, and inverse kinematics.

Run: python tests/benchmarks/kernels.py [LINES]
Prints lines/s of scan + interpret (and of LinuxCNC's rs274 on the same file, when it is installed) and
poses/s of the whole machine's inverse and forward kinematics on one core. Compare ratios, not
absolute times: machines are shared and drift.
"""

import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import verne_post
from verne_post.base.rotations import axis_of_angles

REPEATS = 3


def best(job: Callable[[], object]) -> float:
    """Shortest of a few runs, s."""
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        job()
        times.append(time.perf_counter() - begin)
    return min(times)


def five_axis_program(lines: int) -> bytes:
    """Short five-axis G1 moves along a wavy spiral, as a finishing pass has them."""
    s = 0.2 * np.arange(lines)
    x, y, z = 50 * np.cos(s / 50), 50 * np.sin(s / 50), 60 + 1e-4 * s
    a, c = 20 + 10 * np.sin(s / 30), np.degrees(s / 200)
    rows = "\n".join("G1 X%.4f Y%.4f Z%.4f A%.4f C%.4f" % row for row in zip(x, y, z, a, c, strict=True))
    return f"G21 G90 G94 G49 F3000\nG0 X50 Y0 Z60 A20 C0\n{rows}\nM2\n".encode()


def read_rates(lines: int) -> None:
    """Print lines/s of this front end and of rs274."""
    source = five_axis_program(lines)
    ours = best(lambda: verne_post.gcode.read_moves(source))
    print(f"read_moves      {lines:9d} lines  {ours:7.2f} s  {lines / ours:12,.0f} lines/s")
    rs274 = shutil.which("rs274")
    if rs274 is None:
        print("rs274           not installed")
        return
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "program.ngc"
        program.write_bytes(source)
        theirs = best(lambda: subprocess.run([rs274, "-g", program], stdout=subprocess.DEVNULL, check=False,
                                             stderr=subprocess.DEVNULL, cwd=folder))  # fmt: skip
    print(
        f"rs274           {lines:9d} lines  {theirs:7.2f} s  {lines / theirs:12,.0f} lines/s  ours is {theirs / ours:.1f} x"
    )


def pose_rates(poses: int = 1_000_000) -> None:
    """Print poses/s of the whole machine, tilts up to 90 degrees."""
    machine = verne_post.load_machine()
    rng = np.random.default_rng(1)
    tip = rng.uniform([-150, -150, 0], [150, 150, 150], (poses, 3))
    axis = axis_of_angles(rng.uniform(0, np.pi / 2, poses), rng.uniform(-np.pi, np.pi, poses))
    length = rng.uniform(50, 250, poses)
    q, ok = machine.inverse(tip, axis, length)
    assert ok.all()
    position, _alpha, _ok = machine.module.forward(q[:, :3])
    for name, job in (
        ("module inverse", lambda: machine.module.inverse(position)),
        ("full inverse", lambda: machine.inverse(tip, axis, length)),
        ("full forward", lambda: machine.forward(q, length)),
    ):
        seconds = best(job)
        print(f"{name:15s} {poses:9d} poses  {seconds:7.2f} s  {poses / seconds:12,.0f} poses/s")


if __name__ == "__main__":
    read_rates(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000)
    pose_rates()
