"""Meshes of the scene: fixtures that are meshes. A page has the shape of each as far as a screen shows it."""

from typing import Any, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints
from verne_post.report.pack import Pack

#: Vertices of all fixtures together: a screen shows no more, and the page stays small.
FIXTURE_VERTICES: Final = 24_000
#: Places of a vertex along each side of its surface: the largest number of two bytes.
_PLACES: Final = 65_535
#: How much coarser the next attempt is, where a surface has too many vertices.
_COARSER: Final = 1.3


class Surface(Struct, frozen=True, eq=False):
    """Triangles on the table.

    Attributes
    ----------
    name : str
    vertices : ndarray, shape (n, 3)
        mm, about ``middle``.
    facets : ndarray of int, shape (m, 3)
    middle : ndarray, shape (3,)
        mm, table frame.
    turn : float
        About the table's normal, rad.
    """

    name: str
    vertices: Array
    facets: Ints
    middle: Array
    turn: float


def thin_surface(vertices: Array, facets: Ints, most: int) -> tuple[Array, Ints]:
    """A surface of at most ``most`` vertices: near ones are one, and facets between these go. None is moved farther than it must."""
    low = vertices.min(axis=0)
    step = max(float(np.ptp(vertices, axis=0).max()), 1e-9) / _PLACES
    while True:
        place, first, of = np.unique(
            np.rint((vertices - low) / step).astype(np.int64), axis=0, return_index=True, return_inverse=True
        )
        if len(place) <= most:
            break
        step *= max(_COARSER, np.sqrt(len(place) / most) / _COARSER)
    merged = of.reshape(-1)[facets]
    kept = (merged[:, 0] != merged[:, 1]) & (merged[:, 1] != merged[:, 2]) & (merged[:, 2] != merged[:, 0])
    return vertices[first], merged[kept]


def pack_surfaces(pack: Pack, surfaces: list[Surface]) -> list[dict[str, Any]]:
    """Pack surfaces as ``surface.K.vertex`` and ``surface.K.facet``; returns what else the script needs."""
    described = []
    for k, one in enumerate(surfaces):
        low = one.vertices.min(axis=0)
        step = max(float(np.ptp(one.vertices, axis=0).max()), 1e-9) / _PLACES
        pack.add(f"surface.{k}.vertex", np.rint((one.vertices - low) / step), "<u2")
        pack.add(f"surface.{k}.facet", one.facets, "<u4")
        described.append(
            {"name": one.name, "low": low.tolist(), "step": step, "middle": one.middle.tolist(), "turn": one.turn}
        )
    return described
