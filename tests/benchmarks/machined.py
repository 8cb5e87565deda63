"""How long the comparison of rows with a surface takes: 100,000 rows of a five-axis raster over 40 x 40 mm.

``python -m tests.benchmarks.machined [GRID_MM] [--numpy N_POINTS]``; one core, CPU seconds; the second call is timed,
the first compiles.
"""

import argparse
import time

import numpy as np

from verne_post.model.part_setup import Cylinder, Wanted
from verne_post.part.bodies import build_pieces
from verne_post.part.compare import compare
from verne_post.part.motion import Motion, build_motion
from verne_post.part.stl import build_mesh
from verne_post.part.sweep import find_nearest

ROWS, SIZE, PITCH, RADIUS = 100_000, 40.0, 1.0, 4.0


def make_raster(corner: float) -> Motion:
    """Strips along x, the tool leaning by up to 10 degrees on its way, its corner tangent to the plane z = 0."""
    strips = int(SIZE / PITCH) + 1
    each = ROWS // strips
    share = np.linspace(0, 1, each)
    x = np.concatenate([SIZE * (share if k % 2 == 0 else 1 - share) for k in range(strips)])
    y = np.repeat(PITCH * np.arange(strips), each)
    lean = np.radians(10) * np.sin(2 * np.pi * x / SIZE)
    axis = np.stack([np.sin(lean), 0.2 * np.sin(x / 7), np.cos(lean)], axis=1)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    # tip = lowest point of the corner on z = 0: for a ball the centre is at z = R
    tip = np.stack([x, y, np.full(len(x), corner)], axis=1) - corner * axis
    shape = (Cylinder("cutter", 2 * RADIUS, 60, corner_radius=corner),)
    return build_motion("tool 1", build_pieces(shape, 60), tip, axis, np.arange(len(x)) // 50, np.ones(len(x), bool))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("grid", type=float, nargs="?", default=0.1)
    parser.add_argument("--numpy", type=int, default=4000)
    given = parser.parse_args()
    place = np.arange(given.grid / 2, SIZE, given.grid)
    point = np.stack(np.meshgrid(place, place, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    start = time.process_time()
    motion = make_raster(RADIUS)
    print(f"{len(motion.tip)} rows, tree {time.process_time() - start:.2f} s, bow {motion.bow:.1e} mm")
    find_nearest((motion,), point[:1000], 2.0)
    start = time.process_time()
    found = find_nearest((motion,), point, 2.0)
    took = time.process_time() - start
    print(
        f"numba: {len(point)} points {took:.2f} s, {1e6 * took / len(point):.1f} us a point, G "
        f"{found.distance.min():.6f} to {found.distance.max():.6f}"
    )
    some = point[: given.numpy]
    start = time.process_time()
    other = find_nearest((motion,), some, 2.0, accelerate=False)
    took = time.process_time() - start
    print(
        f"numpy: {len(some)} points {took:.2f} s, {1e6 * took / len(some):.1f} us a point, "
        f"{took * len(point) / len(some):.0f} s for all"
    )
    print(f"difference {np.abs(other.distance - found.distance[: given.numpy]).max():.1e}")
    corner = np.array([[0.0, 0, 0], [SIZE, 0, 0], [SIZE, SIZE, 0], [0, SIZE, 0]])
    mesh, small = (build_mesh("plane", size * corner[[[0, 1, 2], [0, 2, 3]]]) for size in (1.0, 0.1))
    compare(small, (motion,), Wanted(grid=given.grid))
    for part, accelerate in ((mesh, True), (small, False)):
        start = time.process_time()
        judged = compare(part, (motion,), Wanted(grid=given.grid), accelerate=accelerate)
        took = time.process_time() - start
        places = len(judged.cells.facet)
        print(
            f"{'numba' if accelerate else 'numpy'}: verdict on {places} places {took:.2f} s, {1e6 * took / places:.1f} "
            f"us a place, states {np.bincount(judged.state, minlength=3)}"
        )


if __name__ == "__main__":
    main()
