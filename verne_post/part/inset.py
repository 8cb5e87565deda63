"""The part as it is a gouge deep inside: the surface that a tool must cross to cut deeper, and depths of places.

Each facet is shifted inwards. Shifted facets part along edges that are concave from outside, and at their vertices:
strips and fans close these gaps.
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import measure_rows, sum_rows
from verne_post.part.stl import Mesh

#: Strips and fans turn by so much at most from one to the next, rad. Facets that turn less are widened in their place.
_TURN: Final = np.radians(10.0)
#: Facets are shifted by this share of the gouge: so no place of strips and fans is farther inside than the gouge.
SHARE: Final = float(np.cos(0.5 * _TURN))
#: No place of facets, strips and fans that is nearer to the surface than this share of the gouge closes anything.
CLOSES: Final = 0.99
#: Strips are no longer than this, mm.
_STRIP_MM: Final = 1.0
#: Places whose distances are measured together.
_TOGETHER: Final = 4096
#: Distances that differ by less are equal, mm.
_EQUAL_MM: Final = 1e-9


class Surface:
    """Triangles (n, 3, 3) of a surface with outward normals (n, 3), for signed distances from it."""

    def __init__(self, corner: Array, normal: Array, middle: Array, radius: Array) -> None:
        from scipy.spatial import cKDTree

        self.corner, self.normal, self.middle = corner, normal, middle
        self.widest = float(radius.max(initial=0.0))
        self.tree = cKDTree(middle)

    def measure(self, point: Array) -> Array:
        """Distances (n,) of points (n, 3), mm; negative inside."""
        result = np.empty(len(point))
        for first in range(0, len(point), _TOGETHER):
            some = point[first : first + _TOGETHER]
            near, _k = self.tree.query(some)
            lists = self.tree.query_ball_point(some, near + self.widest + _EQUAL_MM)
            count = np.array([len(one) for one in lists])
            owner = np.repeat(np.arange(len(some)), count)
            cell = np.concatenate([np.asarray(one, dtype=np.int64) for one in lists])
            distance = _measure_to_triangles(some[owner], self.corner[cell])
            begin = np.cumsum(count) - count
            least = np.minimum.reduceat(distance, begin)
            # at an edge the facet that the place is farther above or below says on which side it is
            height = np.einsum("ij,ij->i", some[owner] - self.corner[cell, 0], self.normal[cell])
            height = np.where(distance <= least[owner] + _EQUAL_MM, height, 0.0)
            high, low = np.maximum.reduceat(height, begin), np.minimum.reduceat(height, begin)
            result[first : first + _TOGETHER] = np.where(high >= -low, least, -least)
        return result


def _measure_to_triangles(point: Array, corner: Array) -> Array:
    """Distances (n,) of points (n, 3) from triangles (n, 3, 3)."""
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal /= np.maximum(measure_rows(normal), np.finfo(float).tiny)[:, None]
    height = sum_rows((point - corner[:, 0]) * normal)
    over = np.ones(len(point), dtype=bool)
    beside = np.full(len(point), np.inf)
    for k in range(3):
        start, side = corner[:, k], corner[:, (k + 1) % 3] - corner[:, k]
        away = point - start
        over &= sum_rows(np.cross(side, away) * normal) >= 0
        square = np.maximum(sum_rows(side * side), np.finfo(float).tiny)
        share = np.clip(sum_rows(away * side) / square, 0.0, 1.0)
        beside = np.minimum(beside, measure_rows(away - share[:, None] * side))
    return np.where(over, np.abs(height), beside)


def widen_facets(mesh: Mesh, depth: float) -> Array:
    """How far each facet (m,), shifted inwards, reaches past its edges to close gaps at edges that hardly turn, mm."""
    first, second, turn, _ends = _find_concave_edges(mesh)
    widest = np.zeros(len(mesh.facets))
    some = turn <= _TURN
    for facet in (first, second):
        np.maximum.at(widest, facet[some], depth * np.tan(turn[some]))
    return widest


def close_gaps(mesh: Mesh, depth: float) -> tuple[Array, Array, Ints]:
    """Triangles between the facets of a mesh that are shifted inwards by a depth, mm.

    Returns
    -------
    corner : ndarray, shape (n, 3, 3)
    normal : ndarray, shape (n, 3)
        Outwards.
    facet : ndarray of int, shape (n,)
        A facet beside each.
    """
    first, second, turn, ends = _find_concave_edges(mesh)
    some = np.flatnonzero(turn > _TURN)
    normals = mesh.list_normals()
    corners: list[Array] = [np.zeros((0, 3, 3))]
    outwards: list[Array] = [np.zeros((0, 3))]
    facets: list[Ints] = [np.zeros(0, dtype=np.int64)]
    for k in some.tolist():
        a, b = mesh.vertices[ends[k]]
        pieces = max(1, int(np.ceil(np.linalg.norm(b - a) / _STRIP_MM)))
        along = a + np.linspace(0.0, 1.0, pieces + 1)[:, None] * (b - a)
        inward = -depth / SHARE * _turn_from(normals[first[k]], normals[second[k]], turn[k])
        place = along[:, None] + inward
        strip = _join_triangles(place)
        corners.append(strip)
        outwards.append(_find_way_to_line(strip.mean(axis=1), a, b))
        facets.append(np.full(len(strip), first[k]))
    at_gaps = np.unique(ends[some])
    of_vertex: dict[int, list[tuple[int, int, float]]] = {vertex: [] for vertex in at_gaps.tolist()}
    one_side, other_side, angle, its_ends, _above = _list_edges(mesh)
    for k in np.flatnonzero(np.isin(its_ends, at_gaps).any(axis=1)).tolist():
        for vertex in its_ends[k].tolist():
            if vertex in of_vertex:
                of_vertex[vertex].append((int(one_side[k]), int(other_side[k]), float(angle[k])))
    for vertex, edges in of_vertex.items():
        around = np.unique(np.round(normals[np.unique([pair[:2] for pair in edges])], 9), axis=0)
        if len(around) < 3:  # the strips meet
            continue
        centre = around.sum(axis=0)
        centre = centre / np.linalg.norm(centre) if np.linalg.norm(centre) > _EQUAL_MM else around[0]
        for one, other, turned in edges:
            if turned <= _EQUAL_MM:
                continue
            rim = _turn_from(normals[one], normals[other], turned)
            fan = _divide_fan(centre, rim)
            corners.append(mesh.vertices[vertex] - depth / SHARE * fan)
            outwards.append(fan.mean(axis=1))
            facets.append(np.full(len(fan), one))
    corner = np.concatenate(corners)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    normal *= np.where(sum_rows(normal * np.concatenate(outwards)) < 0, -1.0, 1.0)[:, None]
    return corner, normal / measure_rows(normal)[:, None], np.concatenate(facets)


def _find_way_to_line(place: Array, a: Array, b: Array) -> Array:
    """Vectors (n, 3) from places to the line through two points."""
    along = (b - a) / np.linalg.norm(b - a)
    away = a - place
    return np.asarray(away - (away @ along)[:, None] * along)


def _join_triangles(place: Array) -> Array:
    """Triangles (n, 3, 3) of a net of places (j, k, 3), without those that have no area."""
    w, x, y, z = place[:-1, :-1], place[1:, :-1], place[1:, 1:], place[:-1, 1:]
    corner = np.concatenate([np.stack(one, axis=2).reshape(-1, 3, 3) for one in ((w, x, y), (w, y, z))])
    area = np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return np.asarray(corner[area > _EQUAL_MM])


def _divide_fan(centre: Array, rim: Array) -> Array:
    """Triangles (n, 3, 3) on the unit sphere between a centre and a rim (k, 3)."""
    apart = float(np.arccos(np.clip(rim @ centre, -1.0, 1.0)).max())
    steps = max(1, int(np.ceil(apart / _TURN)))
    share = np.linspace(0.0, 1.0, steps + 1)[:, None, None]
    place = (1.0 - share) * centre + share * rim[None]
    place /= np.maximum(np.linalg.norm(place, axis=2), _EQUAL_MM)[:, :, None]
    return _join_triangles(place)


def _turn_from(start: Array, end: Array, turn: float) -> Array:
    """Unit vectors (n, 3) from one to the other, no two farther apart than strips turn."""
    share = np.linspace(0.0, 1.0, max(1, int(np.ceil(turn / _TURN))) + 1)[:, None]
    if turn > np.pi - _TURN:  # folded back: by way of any direction across
        across = np.cross(start, np.eye(3)[int(np.abs(start).argmin())])
        across /= np.linalg.norm(across)
        return np.asarray(np.cos(share * np.pi) * start + np.sin(share * np.pi) * across)
    return np.asarray((np.sin((1.0 - share) * turn) * start + np.sin(share * turn) * end) / np.sin(turn))


def _find_concave_edges(mesh: Mesh) -> tuple[Ints, Ints, Array, Ints]:
    """Edges that are concave from outside: their two facets (k,), how far these turn, rad, and the vertices (k, 2)."""
    first, second, turn, ends, above = _list_edges(mesh)
    some = above & (turn > _EQUAL_MM)
    return first[some], second[some], turn[some], ends[some]


def _list_edges(mesh: Mesh) -> tuple[Ints, Ints, Array, Ints, Mask]:
    """Edges of two facets: these (k,), their turn, rad, vertices (k, 2), and whether they are concave from outside."""
    facets = mesh.facets
    start, end = facets.ravel(), np.roll(facets, -1, axis=1).ravel()
    of, opposite = np.repeat(np.arange(len(facets)), 3), np.roll(facets, -2, axis=1).ravel()
    key = np.minimum(start, end) * len(mesh.vertices) + np.maximum(start, end)
    order = np.argsort(key, kind="stable")
    pair = np.flatnonzero(key[order][1:] == key[order][:-1])
    one, other = order[pair], order[pair + 1]
    normals = mesh.list_normals()
    n1, n2 = normals[of[one]], normals[of[other]]
    turn = np.arctan2(measure_rows(np.cross(n1, n2)), sum_rows(n1 * n2))
    away = mesh.vertices[opposite[other]] - mesh.vertices[start[one]]
    return of[one], of[other], turn, np.stack([start[one], end[one]], axis=1), sum_rows(away * n1) > 0
