"""How far cylinders are from boxes: distances that are certain, by a direction that separates them.

For two convex bodies and a unit vector n, the gap between their supports in the direction n,

    g(n) = min n.y - max n.x    (y in the one, x in the other),

is never more than their distance. The largest gap over all n is the distance; where the bodies overlap, it is minus the
depth. So whatever direction is found, g(n) is a distance that can be relied on. Where the bodies are apart, the
direction is that between the nearest points, found by projecting on the one and the other in turn, with momentum. Where
they overlap, the best of the directions of faces, axis and edges counts.
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.rows import measure_rows, sum_rows

#: Points are sought until their distance is at most this above the gap, mm, and in no more than so many steps.
SURE_MM: Final = 1e-7
STEPS: Final = 1000
#: Steps between two looks at who is done.
LOOK: Final = 25
#: Points that are nearer than this need not come nearer: the direction between them is what it will be.
TOUCHING_MM: Final = 1e-4


def measure_cylinder_to_box(start: Array, end: Array, radius: Array, half: Array) -> Array:
    """Signed distance of cylinders from boxes about the origin: exact to ``SURE_MM`` when apart, never too large.

    Parameters
    ----------
    start, end : ndarray, shape (n, 3)
        Centres of the flat ends, in the frame of the box, mm; a cylinder may have no length.
    radius : ndarray, shape (n,)
        0 for a line segment.
    half : ndarray, shape (3,)
        Half sizes of the box.

    Returns
    -------
    ndarray, shape (n,)
        mm; negative where the bodies overlap.
    """
    middle, axis, long = _split_axes(start, end)
    distance_bound = np.full(len(start), -np.inf)
    for n in _list_directions(axis):
        distance_bound = np.maximum(distance_bound, _evaluate_gap_either_way(n, middle, axis, long, radius, half))
    rest = np.arange(len(start))
    point = np.clip(middle, -half, half)
    ahead, momentum = point.copy(), np.ones(len(start))
    for step in range(STEPS):
        m, k, h, r = middle[rest], axis[rest], long[rest], radius[rest]
        new = np.clip(_project_onto_cylinder(ahead, m, k, h, r), -half, half)
        moved = new - point
        back = sum_rows((ahead - new) * moved) > 0
        grown = np.where(back, 1.0, 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2)))
        ahead = new + np.where(back, 0.0, (momentum - 1.0) / grown)[:, None] * moved
        point, momentum = new, grown
        if step % LOOK and step + 1 < STEPS:
            continue
        apart = _project_onto_cylinder(point, m, k, h, r) - point
        distance = measure_rows(apart)
        clear = distance > 0
        gap = _evaluate_gap(apart / np.where(clear, distance, 1.0)[:, None], m, k, h, r, half)
        distance_bound[rest[clear]] = np.maximum(distance_bound[rest[clear]], gap[clear])
        # the points of bodies that overlap come nearer and nearer to each other
        open_ = (distance > TOUCHING_MM) & (distance - distance_bound[rest] > SURE_MM)
        if not open_.any():
            break
        rest, point, ahead, momentum = rest[open_], point[open_], ahead[open_], momentum[open_]
    return distance_bound


def bound_distance(start: Array, end: Array, radius: Array, half: Array) -> Array:
    """A quick lower bound (n,) of the same distance: a capsule against the sphere around the box, mm."""
    along = end - start
    square = sum_rows(along * along)
    share = np.clip(-sum_rows(start * along) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    return np.asarray(measure_rows(start + share[:, None] * along) - radius - np.linalg.norm(half))


def _split_axes(start: Array, end: Array) -> tuple[Array, Array, Array]:
    """Middle, unit axis and half length of cylinders; the axis of one without length points anywhere."""
    along = end - start
    length = measure_rows(along)
    axis = np.where(length[:, None] > 0, along / np.where(length > 0, length, 1.0)[:, None], [0.0, 0.0, 1.0])
    return 0.5 * (start + end), axis, 0.5 * length


def _evaluate_gap(n: Array, middle: Array, axis: Array, long: Array, radius: Array, half: Array) -> Array:
    """G of unit directions (n, 3) from the box to the cylinder."""
    return _take_sizes_off(sum_rows(n * middle), n, axis, long, radius, half)


def _evaluate_gap_either_way(n: Array, middle: Array, axis: Array, long: Array, radius: Array, half: Array) -> Array:
    """The larger of G(n) and G(-n)."""
    return _take_sizes_off(np.abs(sum_rows(n * middle)), n, axis, long, radius, half)


def _take_sizes_off(apart: Array, n: Array, axis: Array, long: Array, radius: Array, half: Array) -> Array:
    """How far middles are apart along unit directions (n, 3), less what both bodies reach along them."""
    along = sum_rows(n * axis)
    across = np.sqrt(np.maximum(1.0 - along**2, 0.0))
    return np.asarray(apart - long * np.abs(along) - radius * across - sum_rows(np.abs(n) * half))


#: Directions whose cross product, or difference, is shorter than this are parallel: another one replaces them.
PARALLEL: Final = 1e-9


def _list_directions(axis: Array) -> list[Array]:
    """Directions that separate faces and edges: the box's faces, the cylinder's ends, and across both."""
    directions = [np.broadcast_to(unit, axis.shape) for unit in np.eye(3)]
    directions.append(axis)
    for k, unit in enumerate(np.eye(3)):
        across = np.zeros_like(axis)
        across[:, k - 2], across[:, k - 1] = axis[:, k - 1], -axis[:, k - 2]
        for way in (across, unit - axis * axis[:, k, None]):
            size = measure_rows(way)[:, None]
            directions.append(np.where(size > PARALLEL, way / np.where(size > PARALLEL, size, 1.0), unit))
    return directions


def _project_onto_cylinder(point: Array, middle: Array, axis: Array, long: Array, radius: Array) -> Array:
    """The nearest points (n, 3) of cylinders."""
    from_middle = point - middle
    height = sum_rows(from_middle * axis)
    across = from_middle - height[:, None] * axis
    size = measure_rows(across)
    share = np.minimum(radius / np.where(size > 0, size, 1.0), 1.0)
    return middle + np.clip(height, -long, long)[:, None] * axis + share[:, None] * across
