"""How long cutting a stock takes: 100,000 rows of a five-axis raster, 60 x 60 mm, rays 0.1 mm apart.

``python -m tests.benchmarks.stock [--numpy]`` prints bodies, CPU seconds, nanoseconds a ray and memory. The first call
of the compiled code is not counted.
"""

import resource
import sys
import time

import numpy as np

from verne_post.model.part_setup import Cylinder
from verne_post.part.bodies import build_pieces
from verne_post.part.dexels import find_boxes, list_sweeps
from verne_post.part.ray_tables import make_table
from verne_post.part.stock_forms import make_box

ROWS, LINES, STEP = 100_000, 150, 0.2


def main() -> None:
    """Cut with three tools."""
    compiled = "--numpy" not in sys.argv
    share = np.linspace(0.0, 1.0, ROWS // LINES)
    x = np.concatenate([60 * (share if k % 2 == 0 else 1 - share) for k in range(LINES)])
    y = np.repeat(np.linspace(0, 60, LINES), len(share))
    tip = np.stack([x, y, 12 + 2 * np.sin(x / 9) * np.cos(y / 11)], axis=1)
    axis = np.stack(
        [-0.3 * np.cos(x / 9) * np.cos(y / 11), 0.3 * np.sin(x / 9) * np.sin(y / 11), np.ones_like(x)], axis=1
    )
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    # a row is left out while the tool has moved by less than STEP
    moved = np.append(
        0.0,
        np.cumsum(np.linalg.norm(np.diff(tip, axis=0), axis=1) + 12 * np.linalg.norm(np.diff(axis, axis=0), axis=1)),
    )
    keep = np.unique(np.searchsorted(moved, np.arange(0.0, moved[-1], STEP)))
    tips, axes = (np.stack([one[keep][:-1], one[keep][1:]], axis=1) for one in (tip, axis))
    for name, corner in (("flat", 0.0), ("ball", 4.0), ("bull", 1.0)):
        (piece,) = build_pieces((Cylinder("cutter", 8.0, 12.0, corner_radius=corner),), 12.0)
        table, sweeps = make_table(piece), list_sweeps(tips, axes, 12.0, 1.5 * STEP)
        make_box(np.zeros(3), np.array([60.0, 60, 20]), np.zeros(3), 0.0, 2.0).cut(
            sweeps.take(slice(0, 2)), table, compiled=compiled
        )
        stock = make_box(np.zeros(3), np.array([60.0, 60, 20]), np.zeros(3), 0.0, 0.1)
        low, high = find_boxes(sweeps, table)
        rays = float(((high - low)[:, :2].prod(axis=1) / stock.area).sum())
        begun, cpu = time.perf_counter(), time.process_time()
        volume = float(stock.cut(sweeps, table, compiled=compiled).sum())
        begun, cpu = time.perf_counter() - begun, time.process_time() - cpu
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(
            f"{name}: {len(sweeps)} bodies, {cpu:.1f} s CPU, {begun:.1f} s, {cpu / rays * 1e9:.1f} ns a ray, "
            f"{volume:.1f} mm3, {memory:.0f} MB"
        )


if __name__ == "__main__":
    main()
