"""Fixtures as meshes: which lines of moving tools come too near to them, certain between rows, and how deep."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints
from verne_post.part.bound import find_above
from verne_post.part.compare import MAX_CELLS, Cells
from verne_post.part.motion import Motion
from verne_post.part.places import GOLDEN, list_lines, touch_cells
from verne_post.part.stl import Mesh, order_facets
from verne_post.part.sweep import find_nearest

#: Bodies may touch, and reach into a fixture by this, mm: otherwise a tool that slides along it would be checked in
#: steps of a nanometre.
TOUCH_MM: Final = 0.005
#: So many neighbouring facets are held against all bodies together first.
_CLUSTER: Final = 16
#: Triangles this small that no bound clears count as touched, mm.
_LEAST_MM: Final = 0.002
#: The deepest place is sought on triangles down to this size, mm. Triangles are skipped that can be deeper only by
#: this, mm, or by this share of the depth.
_DEEPEST_MM: Final = 0.01
_DEEPER_MM: Final = 0.001
_DEEPER_SHARE: Final = 0.01
#: So many triangles are cut again where the least distance is sought, and so many are looked at first.
_SOUGHT: Final = 500
_FIRST: Final = 32


class Spot(Struct, frozen=True, eq=False):
    """A place (3,) of a mesh, its distance from a body, mm, and the motion and row at or before it; -1: none."""

    distance: float = np.inf
    place: Array = np.full(3, np.nan)
    motion: int = -1
    row: int = -1


class Contact(Struct, frozen=True, eq=False):
    """One body of one motion that comes too near."""

    part: str
    line: Ints  #: (k,): Every line in which it does.
    value: Array  #: (k,): How near it was seen there first, mm.
    deepest: Spot  #: The least distance that was seen.
    bound: float  #: No place of the mesh is nearer at any time, mm.


class Contacts(Struct, frozen=True, eq=False):
    """Where tools come nearer to a mesh than allowed, or as near as no bound tells apart."""

    mesh: Mesh
    allowed: float  #: mm.
    found: tuple[Contact, ...]
    #: The least distance that was seen anywhere, mm; infinite where nothing moves, or it was not asked for.
    least: float = np.inf


def find_contacts(
    mesh: Mesh, motions: tuple[Motion, ...], allowed: float, *, with_least: bool = False, accelerate: bool = True
) -> Contacts:
    """Find where tools come nearer to a closed mesh than ``allowed``; a body that is not named keeps off for all time.

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
    cells, balls = Cells(mesh.list_corners(), np.arange(len(mesh.facets))), _Balls(mesh)
    normals = mesh.list_normals()
    found = [
        contact
        for k, motion in enumerate(motions)
        for part in dict.fromkeys(piece.part for piece in motion.pieces)
        for contact in _find_contact(cells, normals, balls, motions, (k, part), limit, accelerate)
    ]
    least = min((one.deepest.distance for one in found), default=np.inf)
    if with_least and not found:
        least = _seek_least(cells, normals, motions, (), Spot(), accelerate)[0].distance
    return Contacts(mesh, allowed, tuple(found), least)


class _Balls:
    """Balls about neighbouring facets of a mesh."""

    def __init__(self, mesh: Mesh) -> None:
        corner = mesh.list_corners()
        self.facet = order_facets(corner.mean(axis=1))
        first = np.arange(0, len(self.facet), _CLUSTER)
        low = np.minimum.reduceat(corner[self.facet].min(axis=1), first)
        high = np.maximum.reduceat(corner[self.facet].max(axis=1), first)
        self.middle, self.reach = 0.5 * (low + high), 0.5 * np.linalg.norm(high - low, axis=1)

    def find_near(self, motion: Motion, part: str, limit: float, accelerate: bool) -> Ints:
        """Facets that a body may come near to."""
        cap = limit + self.reach + motion.bow
        nearest = find_nearest((motion,), self.middle, cap, (part,), accelerate=accelerate)
        return self.facet[np.repeat(nearest.row >= 0, _CLUSTER)[: len(self.facet)]]


def _find_contact(
    cells: Cells,
    normals: Array,
    balls: _Balls,
    motions: tuple[Motion, ...],
    body: tuple[int, str],
    limit: float,
    accelerate: bool,
) -> list[Contact]:
    """The lines in which one body touches cells, if there are any."""
    motion, part = motions[body[0]], body[1]
    near = cells.select(balls.find_near(motion, part, limit, accelerate))
    marks = list_lines(motion)
    # what touches an inner piece touches one of those that it lies in
    for piece in (one for one in motion.pieces if one.part == part and not one.inner):
        left = near
        while len(left.facet):
            middle, delta = left.find_circles()
            least = _LEAST_MM if 4 * len(left.facet) <= MAX_CELLS else np.inf  # what is left counts as touched
            opened = touch_cells(
                motion, piece, (middle, normals[left.facet], delta), limit, least, marks, accelerate=accelerate
            )
            left = left.select(opened).cut(2)
    touched = np.flatnonzero(marks.touched)
    if not len(touched):
        return []
    first = touched[int(np.argmin(marks.value[touched]))]
    seen = Spot(float(marks.value[first]), marks.place[first], body[0], int(marks.row[first]))
    deepest, bound = _seek_least(near, normals, motions, body, seen, accelerate)
    return [Contact(part, marks.line[touched], marks.value[touched], deepest, bound)]


def _seek_least(
    cells: Cells,
    normals: Array,
    motions: tuple[Motion, ...],
    body: tuple[int, str] | tuple[()],
    seen: Spot,
    accelerate: bool,
) -> tuple[Spot, float]:
    """The place of cells nearest to one body that touches them, or to all, and a lower bound of the distance.

    ``seen`` is improved where cells may be nearer. The search stops at the deepest possible place, and at a gain below
    a share of the depth.
    """
    own, parts = ((motions[body[0]],), (body[1],)) if body else (motions, ())
    pieces = [piece for motion in own for piece in motion.pieces if not parts or piece.part in parts]
    smallest = _DEEPEST_MM if body else _LEAST_MM
    # inside a convex body of revolution no place is deeper than its radius
    floor = -max((piece.radius for piece in pieces), default=0.0)
    bow = max((motion.bow for motion in own), default=0.0)
    bound = np.inf  # of the cells that are not looked at again
    while True:
        gain = max(_DEEPER_MM, -_DEEPER_SHARE * seen.distance) if body else 0.0
        middle, delta = cells.find_circles()
        lower = np.full(len(delta), np.inf)
        # evenly over all, so that the first ones say much about the others
        mixed = np.argsort(np.arange(len(delta)) * GOLDEN % 1.0, kind="stable")
        at, size = 0, _FIRST
        while at < len(delta) and seen.distance > floor + gain:
            some = np.sort(mixed[at : at + size])
            cap = seen.distance - gain + delta[some] + bow
            nearest = find_nearest(own, middle[some], cap, parts, accelerate=accelerate)
            there = np.flatnonzero(nearest.row >= 0)
            lower[some[there]] = nearest.distance[there] - delta[some[there]] - bow
            if len(there):
                best = there[np.argmin(nearest.distance[there])]
                if nearest.distance[best] < seen.distance:
                    motion = body[0] if body else int(nearest.motion[best])
                    seen = Spot(float(nearest.distance[best]), middle[some[best]], motion, int(nearest.row[best]))
            at, size = at + size, 4 * size
        if seen.distance <= floor + gain:
            return seen, floor
        sought = seen.distance - gain
        left = np.flatnonzero(lower < sought)
        above = find_above(
            own,
            middle[left],
            normals[cells.facet[left]],
            delta[left],
            dict.fromkeys(pieces, sought),
            parts,
            accelerate=accelerate,
        )
        left = left[~above]
        small = delta[left] <= smallest
        again = left[~small][np.argsort(lower[left[~small]], kind="stable")]
        bound = float(lower[np.concatenate([left[small], again[_SOUGHT:]])].min(initial=bound))
        if not len(again):
            return seen, max(floor, min(bound, sought))
        cells = cells.select(again[:_SOUGHT]).cut(2)
