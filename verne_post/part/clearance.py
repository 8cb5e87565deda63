"""Fixtures as meshes: how near the parts of moving tools come to them, certain between rows."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.part.bound import find_above
from verne_post.part.compare import MAX_CELLS, Cells
from verne_post.part.motion import Motion
from verne_post.part.stl import Mesh
from verne_post.part.sweep import Nearest, find_nearest

#: Bodies may touch, and reach into a fixture by this, mm: a tool that slides along it would else be checked in steps of a
#: nanometre.
TOUCH_MM: Final = 0.005
#: Triangles in contact are cut to this size, mm, so that every line that touches is seen; those at the border of what a line is
#: known to touch no further.
_LOCAL_MM: Final = 0.5
#: Triangles this small that no bound clears count as touched, mm.
_LEAST_MM: Final = 0.002
#: So many triangles are cut again where the least distance is sought.
_SOUGHT: Final = 500


class Contacts(Struct, frozen=True, eq=False):
    """Where tools come nearer to a mesh than allowed, or as near as no bound tells apart.

    Attributes
    ----------
    mesh : Mesh
    allowed : float
        mm.
    place : ndarray, shape (n, 3)
    nearest : Nearest
        Signed distances of the places (n,).
    least : float
        The least distance that was seen anywhere, mm; infinite where nothing moves, or it was not asked for.
    """

    mesh: Mesh
    allowed: float
    place: Array
    nearest: Nearest
    least: float = np.inf


def find_contacts(
    mesh: Mesh, motions: tuple[Motion, ...], allowed: float, *, with_least: bool = False, accelerate: bool = True
) -> Contacts:  # fmt: skip
    """Find where tools come nearer to a closed mesh than ``allowed``; where there are no contacts, that is certain for all time.

    Parameters
    ----------
    mesh : Mesh
        In the frame of the motions.
    allowed : float
        mm; less by :data:`TOUCH_MM`, a tool that slides along a fixture touches it.
    with_least : bool
        Seek the least distance too.
    """
    limit = allowed - TOUCH_MM
    bow = max((motion.bow for motion in motions), default=0.0)
    limits = {piece: limit for motion in motions for piece in motion.pieces}
    normals, cells = mesh.list_normals(), Cells(mesh.list_corners(), np.arange(len(mesh.facets)))
    places, found = [], []
    known: set[tuple[int, int, int]] = set()
    least = _seek_least(cells, motions, accelerate) if with_least else np.inf
    while len(cells.facet):
        middle, delta = cells.find_circles()
        nearest = find_nearest(motions, middle, limit + delta + bow, accelerate=accelerate)
        touched = nearest.distance <= limit
        near = np.flatnonzero(nearest.distance - delta - bow <= limit)
        open_ones = near[~touched[near]]
        above = find_above(
            motions, middle[open_ones], normals[cells.facet[open_ones]], delta[open_ones], limits, accelerate=accelerate
        )
        open_ones = open_ones[~above]
        known |= set(_name_lines(motions, nearest.select(touched)))
        found_there = [name in known for name in _name_lines(motions, nearest.select(open_ones))]
        open_ones = open_ones[(delta[open_ones] > _LOCAL_MM) | ~np.array(found_there, dtype=bool)]
        again = np.concatenate([open_ones[delta[open_ones] > _LEAST_MM], np.flatnonzero(touched & (delta > _LOCAL_MM))])
        if 4 * len(again) > MAX_CELLS:  # what is left counts as touched
            again = again[:0]
        kept = np.union1d(np.flatnonzero(touched), open_ones[~np.isin(open_ones, again)])
        places.append(middle[kept])
        found.append(nearest.select(kept))
        cells = cells.select(again).cut(2)
    names = Nearest.__struct_fields__
    joined = Nearest(*(np.concatenate([getattr(one, name) for one in found]) for name in names))
    hit = joined.row >= 0
    return Contacts(mesh, allowed, np.concatenate(places)[hit], joined.select(hit), least)


def _name_lines(motions: tuple[Motion, ...], nearest: Nearest) -> list[tuple[int, int, int]]:
    """Motion, piece and line of places (n,)."""
    line = np.zeros(len(nearest.row), dtype=np.int64)
    for k, motion in enumerate(motions):
        own = (nearest.motion == k) & (nearest.row >= 0)
        line[own] = motion.line[nearest.row[own]]
    return list(zip(nearest.motion.tolist(), nearest.piece.tolist(), line.tolist(), strict=True))


def _seek_least(cells: Cells, motions: tuple[Motion, ...], accelerate: bool) -> float:
    """The least distance from the places of cells, by looking again where it may be less; no bound."""
    least = np.inf
    while len(cells.facet):
        middle, delta = cells.find_circles()
        nearest = find_nearest(motions, middle, least + delta, accelerate=accelerate)
        least = min(least, float(nearest.distance[nearest.row >= 0].min(initial=np.inf)))
        lower = nearest.distance - delta
        again = np.flatnonzero((lower < least) & (delta > _LEAST_MM))
        cells = cells.select(again[np.argsort(lower[again], kind="stable")[:_SOUGHT]]).cut(2)
    return least
