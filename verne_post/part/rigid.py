"""A mesh that moves rigidly, against one that stands: lines in which they come too near, certain between rows.

The pose of the body is where the corners of the box around it are; between two rows these go straight (whoever
divides the motion sees to that). Time is the way of the corner that goes farthest, so that no point of the body moves
by more than the time that passes. Balls about facets of both, over a stretch of time, are divided, the largest of the
three first, until the gap says that they keep off, or two facets are found that do not.
"""

from typing import Any, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.ragged import number_parts
from verne_post.base.segments import measure_between_triangles, measure_point_to_segment
from verne_post.part.compare import Cells, is_inside
from verne_post.part.motion import FAN
from verne_post.part.stl import Mesh, order_facets
from verne_post.part.sweep import take

#: Facets that are nearer than the limit by less than their motion count as too near when that is so small, mm.
LEAST_MM: Final = 0.001
#: Edges whose cross product is no longer than this, mm2, are parallel: it has no direction.
_PARALLEL_MM2: Final = 1e-9
#: Pairs that are looked at together.
_TOGETHER: Final = 1 << 14
#: Corners of a box, lowest first: its neighbours along x, y and z are 1, 2 and 4.
CORNERS: Final = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], dtype=float)


class Balls(Struct, frozen=True, eq=False):
    """A tree of balls over the facets (m,) of a mesh, which are its first nodes."""

    corner: Array  #: (m, 3, 3): mm.
    #: middle, radius (n, 3) and (n,): mm; all corners of its facets are in a ball, and so are these.
    middle: Array
    radius: Array
    #: child, count (n,): First of the nodes below, and how many these are; 0 of a facet.
    child: Ints
    count: Ints


def build_balls(mesh: Mesh) -> Balls:
    """The tree of a mesh; its last node is the top."""
    corner = mesh.list_corners()
    corner = corner[order_facets(corner.mean(axis=1))]
    m = n = len(corner)
    middle, radius = Cells(corner, np.arange(m)).find_circles()
    columns = [(middle, radius, np.zeros(m, dtype=np.int64), np.zeros(m, dtype=np.int64))]
    offset, size = 0, FAN
    while n > 1:
        begin = np.arange(0, m, size)
        low, high = np.minimum.reduceat(corner.min(axis=1), begin), np.maximum.reduceat(corner.max(axis=1), begin)
        middle = 0.5 * (low + high)
        away = np.linalg.norm(corner - np.repeat(middle, np.diff(np.append(begin, m)), axis=0)[:, None], axis=2)
        first = np.arange(0, n, FAN)
        radius = np.maximum.reduceat(away.max(axis=1), begin)
        columns.append((middle, radius, offset + first, np.minimum(FAN, n - first)))
        offset, n, size = offset + n, len(first), size * FAN
    middle, radius, child, count = (np.concatenate(one) for one in zip(*columns, strict=True))
    return Balls(corner, middle, radius, child, count)


class Body(Struct, frozen=True, eq=False):
    """A mesh that moves; ``balls`` as shares (0 to 1) of its box from ``low`` to ``high`` (3,), radii in mm."""

    mesh: Mesh
    balls: Balls
    low: Array
    high: Array

    def list_corners(self) -> Array:
        """Corners (8, 3) of the box, mm, in the frame of the mesh."""
        return self.low + CORNERS * (self.high - self.low)


def build_body(mesh: Mesh) -> Body:
    """A mesh made ready to be moved."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    balls = build_balls(mesh)
    corner, middle = ((one - low) / (high - low) for one in (balls.corner, balls.middle))
    return Body(mesh, Balls(corner, middle, balls.radius, balls.child, balls.count), low, high)


class Way(Struct, frozen=True, eq=False):
    """Rows (n,) of a body: ``corner`` (n, 8, 3) of its box, ``line``, and ``time``: way of its farthest corner, mm.

    Unlinked rows are 1 apart in time.
    """

    corner: Array
    line: Ints
    time: Array
    linked: Mask


def build_way(corner: Array, line: Ints, linked: Mask) -> Way:
    """The way of a body whose box has its corners at (n, 8, 3)."""
    linked = linked.copy()
    linked[-1:] = False
    step = np.linalg.norm(np.diff(corner, axis=0), axis=2).max(axis=1, initial=0.0)
    return Way(corner, line, np.append(0.0, np.cumsum(np.where(linked[:-1], step, 1.0))), linked)


def find_lines(body: Body, fixture: Balls, way: Way, limit: float) -> tuple[Ints, Array]:
    """Lines (k,) in which a body comes as near to a fixture as the limit, mm, and a distance (k,) at which each does.

    Those that are not named keep off for all time, between rows too. Bodies inside each other whose surfaces do not
    meet are not found: see :func:`find_inside`.
    """
    line, group = np.unique(way.line, return_inverse=True)
    group = group.reshape(-1)
    near, value = np.zeros(len(line), dtype=bool), np.full(len(line), np.inf)
    first = np.flatnonzero(np.append(True, ~way.linked[:-1]))
    last = np.flatnonzero(~way.linked)
    tops = (np.full(len(first), len(one.radius) - 1) for one in (body.balls, fixture))
    waiting: list[tuple[Any, ...]] = [(way.time[first], way.time[last], *tops)]
    while waiting:
        chunk = _take_some(waiting)
        left = np.append(0, np.cumsum(~near[group]))
        begin = np.searchsorted(way.time, chunk[0], side="right") - 1
        end = np.minimum(np.searchsorted(way.time, chunk[1], side="left"), len(group) - 1)
        start, stop, b, f = take(np.flatnonzero(left[end + 1] > left[begin]), *chunk)
        middle, half = 0.5 * (start + stop), 0.5 * (stop - start)
        at, row = _place(way, middle)
        ends = _place(way, start)[0], _place(way, stop)[0]
        # between two rows all places go straight
        straight = stop <= way.time[np.minimum(row + 1, len(group) - 1)]
        straight &= start >= way.time[row]
        lower = _measure_gap(body, fixture, at, b, f) - half
        lower[straight] = _measure_gap_on_way(body, fixture, *(take(straight, *ends, b, f)))
        keep = np.flatnonzero(lower <= limit)
        start, stop, b, f, half, at, row, straight = take(keep, start, stop, b, f, half, at, row, straight)
        ends = take(keep, *ends)
        facets = (body.balls.count[b] == 0) & (fixture.count[f] == 0)
        own = np.flatnonzero(facets)
        distance = measure_between_triangles(_map(at[own], body.balls.corner[b[own]]), fixture.corner[f[own]])
        lower = distance - half[own]
        one = np.flatnonzero(straight[own] & (lower <= limit) & (distance > limit))
        which = own[one]
        before, after = (_map(end[which], body.balls.corner[b[which]]) for end in ends)
        lower[one] = np.maximum(lower[one], _bound_facets(before, after, fixture.corner[f[which]]))
        is_near = (distance <= limit) | ((lower <= limit) & (half[own] <= LEAST_MM))
        hit = own[is_near]
        near[group[row[hit]]] = True
        np.minimum.at(value, group[row[hit]], distance[is_near])
        open_ones = np.ones(len(b), dtype=bool)
        open_ones[own] = (lower <= limit) & (half[own] > LEAST_MM)
        # where all goes straight only two facets need less time
        half = np.where(straight, -0.5, half)
        # others are divided at the row that is nearest to their middle
        middle = 0.5 * (start + stop)
        rows = way.time[row], way.time[np.minimum(row + 1, len(group) - 1)]
        before, after = (np.where((one > start) & (one < stop), one, np.inf) for one in rows)
        nearer = np.where(np.abs(before - middle) <= np.abs(after - middle), before, after)
        middle = np.where(straight | ~np.isfinite(nearer), middle, nearer)
        waiting += _divide(body, fixture, take(np.flatnonzero(open_ones), start, stop, b, f, half, middle))
    return line[near], value[near]


def _take_some(waiting: list[tuple[Any, ...]]) -> tuple[Any, ...]:
    """The last of what waits, so many that they are looked at together; the rest goes on waiting."""
    taken = [waiting.pop()]
    while waiting and sum(len(one[0]) for one in taken) < _TOGETHER:
        taken.append(waiting.pop())
    chunk = tuple(np.concatenate(one) for one in zip(*taken, strict=True))
    if len(chunk[0]) > _TOGETHER:
        waiting.append(tuple(one[_TOGETHER:] for one in chunk))
    return tuple(one[:_TOGETHER] for one in chunk)


def _divide(body: Body, fixture: Balls, pairs: tuple[Any, ...]) -> list[tuple[Any, ...]]:
    """Each pair of balls over a stretch of time in parts, by the largest of the three."""
    start, stop, b, f, half, middle = pairs
    size = np.stack(
        [
            half,
            np.where(body.balls.count[b] > 0, body.balls.radius[b], -1.0),
            np.where(fixture.count[f] > 0, fixture.radius[f], -1.0),
        ]
    )
    # balls have eight parts and time has two; two facets have only time
    which = np.argmax(size, axis=0)
    parts = []
    for k, tree in ((1, body.balls), (2, fixture)):
        own = np.flatnonzero(which == k)
        node = (b, f)[k - 1][own]
        pair, index = number_parts(tree.count[node])
        child = tree.child[node][pair] + index
        one, other = own[pair], (f, b)[k - 1][own][pair]
        parts.append((start[one], stop[one], *((child, other) if k == 1 else (other, child))))
    own = np.flatnonzero(which == 0)
    parts += [(start[own], middle[own], b[own], f[own]), (middle[own], stop[own], b[own], f[own])]
    return [one for one in parts if len(one[0])]


def find_distances(body: Body, fixture: Balls, corner: Array, near: float) -> Array:
    """Distances (n,) of a body from a fixture in poses, mm: 0 where surfaces meet, ``near`` where they are farther.

    ``corner`` (n, 8, 3) is where the box around the body has its corners.
    """
    n = len(corner)
    best = np.where(np.isfinite(corner).all(axis=(1, 2)), near, np.nan)
    tops = (np.full(n, len(one.radius) - 1) for one in (body.balls, fixture))
    waiting: list[tuple[Any, ...]] = [(np.arange(n), *tops)]
    while waiting:
        chunk = _take_some(waiting)
        pose, b, f = chunk
        at = corner[pose]
        lower = _measure_gap(body, fixture, at, b, f)
        facets = (body.balls.count[b] == 0) & (fixture.count[f] == 0)
        # two balls hold a place of each surface
        np.fmin.at(best, pose, lower + 2.0 * (body.balls.radius[b] + fixture.radius[f]))
        own = np.flatnonzero(facets & (lower < best[pose]))
        distance = measure_between_triangles(_map(at[own], body.balls.corner[b[own]]), fixture.corner[f[own]])
        np.minimum.at(best, pose[own], distance)
        pose, b, f = take(np.flatnonzero(~facets & (lower < best[pose])), pose, b, f)
        parts = _divide(body, fixture, (pose, pose, b, f, np.full(len(pose), -2.0), pose))
        waiting += [tuple(one[k].astype(np.int64) for k in (0, 2, 3)) for one in parts]
    return best


def find_inside(body: Body, fixture: Mesh, way: Way) -> Ints:
    """Rows (k,) at which a motion begins with one of body and fixture inside the other, by one vertex of each."""
    found = []
    for row in np.flatnonzero(np.append(True, ~way.linked[:-1])).tolist():
        sides = way.corner[row, [1, 2, 4]] - way.corner[row, 0]
        share = np.linalg.solve(sides.T, fixture.vertices[0] - way.corner[row, 0])
        vertex = _map(way.corner[row : row + 1], ((body.mesh.vertices[:1] - body.low) / (body.high - body.low))[None])[
            0
        ]
        if is_inside(fixture, vertex)[0] or is_inside(body.mesh, (body.low + share * (body.high - body.low))[None])[0]:
            found.append(row)
    return np.array(found, dtype=np.int64)


def _place(way: Way, time: Array) -> tuple[Array, Ints]:
    """Corners (m, 8, 3) at times (m,), and the rows at or before."""
    row = np.clip(np.searchsorted(way.time, time, side="right") - 1, 0, max(len(way.time) - 2, 0))
    after = np.minimum(row + 1, len(way.time) - 1)
    long = way.time[after] - way.time[row]
    share = np.where(long > 0, (time - way.time[row]) / np.where(long > 0, long, 1.0), 0.0)
    corner = way.corner[row] + share[:, None, None] * (way.corner[after] - way.corner[row])
    return corner, np.where(share >= 1.0, after, row)


def _map(corner: Array, share: Array) -> Array:
    """Points (m, k, 3) given as shares of a box, whose corners are at (m, 8, 3)."""
    origin = corner[:, :1]
    return np.asarray(origin + share @ (corner[:, [1, 2, 4]] - origin))


def _measure_gap_on_way(body: Body, fixture: Balls, start: Array, end: Array, b: Ints, f: Ints) -> Array:
    """The least gap of balls (m,) while a body goes straight from one place of its corners (m, 8, 3) to another."""
    first, last = (_map(one, body.balls.middle[b][:, None])[:, 0] for one in (start, end))
    away = measure_point_to_segment(fixture.middle[f], first, last)
    return np.asarray(away - body.balls.radius[b] - fixture.radius[f])


def _bound_facets(start: Array, end: Array, other: Array) -> Array:
    """Lower bound (n,) of the distance of facets (n, 3, 3) from others while they go straight from a start to an end.

    In a fixed direction the gap is concave in time, so that its least value is at an end. Directions are the normals of
    both, in their planes those of their edges, and those that are square to an edge of each.
    """
    sides = [one - np.roll(one, 1, axis=1) for one in (0.5 * (start + end), other)]
    square = np.cross(sides[0][:, :, None], sides[1][:, None, :]).reshape(len(start), 9, 3)
    normals = [np.cross(one[:, :1], one[:, 1:2]) for one in sides]
    beside = [np.cross(one, normal) for one, normal in zip(sides, normals, strict=True)]
    direction = np.concatenate([*normals, *beside, square], axis=1)
    long = np.linalg.norm(direction, axis=2, keepdims=True)
    direction /= np.where(long > _PARALLEL_MM2, long, np.inf)
    along = direction.transpose(0, 2, 1)
    own, fixed = np.stack([start @ along, end @ along]), other @ along
    above = (own.min(axis=2) - fixed.max(axis=1)).min(axis=0)
    below = (fixed.min(axis=1) - own.max(axis=2)).min(axis=0)
    return np.asarray(np.maximum(above, below).max(axis=1))


def _measure_gap(body: Body, fixture: Balls, corner: Array, b: Ints, f: Ints) -> Array:
    """How far balls (m,) of both are apart, mm; below 0 where they overlap."""
    middle = _map(corner, body.balls.middle[b][:, None])[:, 0]
    away = np.linalg.norm(middle - fixture.middle[f], axis=1)
    return np.asarray(away - body.balls.radius[b] - fixture.radius[f])
