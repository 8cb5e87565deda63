"""Fixtures as meshes: read, and checked for a surface that crosses itself, by a tree of boxes over the facets."""

from functools import lru_cache
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.model.findings import make_input_error
from verne_post.part.motion import FAN
from verne_post.part.stl import Mesh, order_facets, read_stl, require_closed
from verne_post.part.sweep import list_children
from verne_post.part.verdict import describe_place

#: Corners this far on both sides of a facet cross it, as a share of the mesh's size: above single precision.
_CROSSED_SHARE: Final = 1e-6


@lru_cache(maxsize=8)
def load_fixture(raw: bytes, name: str, unit: str) -> Mesh:
    """The mesh of a fixture: closed, and nowhere through itself.

    Raises
    ------
    InputError
        VP506.
    """
    mesh = require_closed(read_stl(raw, name, unit))
    crossed = find_crossings(mesh)
    if len(crossed):
        place = describe_place(mesh.list_corners()[crossed[0]].mean(axis=0))
        text = (
            f"{name}: its surface crosses itself: {len(crossed)} facets, the first near {place}; unite its bodies into "
            "one"
        )
        raise make_input_error("VP506", text)
    return mesh


def find_crossings(mesh: Mesh) -> Ints:
    """Facets (k,) that an edge of another facet goes through."""
    corner = mesh.list_corners()
    facet = order_facets(corner.mean(axis=1))
    corner = corner[facet]
    levels = [(corner.min(axis=1), corner.max(axis=1))]  # boxes about facets, about FAN of these, and so on
    while len(levels[-1][0]) > FAN:
        first = np.arange(0, len(levels[-1][0]), FAN)
        low, high = levels[-1]
        levels.append((np.minimum.reduceat(low, first), np.maximum.reduceat(high, first)))
    top = len(levels[-1][0])
    a: Ints = np.repeat(np.arange(top), top)
    b: Ints = np.tile(np.arange(top), top)
    for k in range(len(levels) - 1, -1, -1):
        low, high = levels[k]
        near = (a <= b) & (low[a] <= high[b]).all(axis=1) & (low[b] <= high[a]).all(axis=1)
        a, b = a[near], b[near]
        if k:
            count = len(levels[k - 1][0])
            b, a = list_children(b, a, count)
            a, b = list_children(a, b, count)
    a, b = a[a < b], b[a < b]
    own, other = mesh.facets[facet[a]], mesh.facets[facet[b]]
    apart = (own[:, :, None] == other[:, None, :]).sum(axis=(1, 2)) < 2  # neighbours at an edge cannot cross
    a, b = a[apart], b[apart]
    reach = _CROSSED_SHARE * float(np.ptp(mesh.vertices, axis=0).max())
    crossed = [target[_is_pierced(corner[source], corner[target], reach)] for source, target in ((a, b), (b, a))]
    return np.asarray(np.unique(facet[np.concatenate(crossed)]))


def _is_pierced(source: Array, target: Array, reach: float) -> Array:
    """Whether edges of triangles (n, 3, 3) go through the inside of others, by more than ``reach`` on both sides."""
    origin, first, second = target[:, 0], target[:, 1] - target[:, 0], target[:, 2] - target[:, 0]
    normal = np.cross(first, second)
    height = np.einsum("nkx,nx->nk", source - origin[:, None], normal / np.linalg.norm(normal, axis=1)[:, None])
    pierced = np.zeros(len(source), dtype=bool)
    for k in range(3):
        j = (k + 1) % 3
        through = np.flatnonzero((height[:, k] * height[:, j] < 0) & (np.abs(height[:, [k, j]]).min(axis=1) > reach))
        share = height[through, k] / (height[through, k] - height[through, j])
        point = source[through, k] + share[:, None] * (source[through, j] - source[through, k]) - origin[through]
        n = normal[through] / (normal[through] ** 2).sum(1)[:, None]
        u = (np.cross(point, second[through]) * n).sum(1)
        v = (np.cross(first[through], point) * n).sum(1)
        pierced[through] |= (u > _CROSSED_SHARE) & (v > _CROSSED_SHARE) & (u + v < 1.0 - _CROSSED_SHARE)
    return pierced
