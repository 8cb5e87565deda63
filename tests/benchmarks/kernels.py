"""Poses/s of the whole machine's inverse and forward kinematics on one core.

Run: python tests/benchmarks/kernels.py
Compare ratios, not absolute times: machines are shared and drift.
"""

import time
from collections.abc import Callable

import numpy as np

import verne_post
from verne_post.base.rotations import find_axis_of_angles

REPEATS = 3


def best(job: Callable[[], object]) -> float:
    """Shortest time of a few repetitions, s."""
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        job()
        times.append(time.perf_counter() - begin)
    return min(times)


def pose_rates(poses: int = 1_000_000) -> None:
    """Print poses/s of the whole machine, tilts up to 90 degrees."""
    machine = verne_post.load_machine()
    rng = np.random.default_rng(1)
    tip = rng.uniform([-150, -150, 0], [150, 150, 150], (poses, 3))
    axis = find_axis_of_angles(rng.uniform(0, np.pi / 2, poses), rng.uniform(-np.pi, np.pi, poses))
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
    pose_rates()
