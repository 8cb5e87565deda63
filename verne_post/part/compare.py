"""A nominal surface against the moving tools: how deep they cut, how much they leave, and what is certain.

Facets are divided into cells. A cell is *clear* where a certain bound says that no gouge in it is deeper than asked, a
*gouge* where one is found along its normal; else it is cut in four, until its size says that this leads nowhere: *not
decided*. Excess is measured at the middle of each cell of the first division.
"""

from collections.abc import Callable
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import find_row_max, measure_rows, sum_rows
from verne_post.model.findings import InputError, make_input_error
from verne_post.model.part_setup import GRID_MM, Wanted
from verne_post.part.bound import find_clear, find_limit
from verne_post.part.motion import Motion
from verne_post.part.stl import Mesh
from verne_post.part.sweep import Nearest, find_nearest

CLEAR, GOUGE, UNDECIDED = range(3)
#: Parts of the tool that cut, and the rest of it.
CUTTING: Final = ("cutter",)
FOLLOWING: Final = ("shank", "holder")
#: More cells than this are not made, nor looked at again: 300 bytes each.
MAX_CELLS: Final = 1_000_000
#: A cell that is still not decided below this share of the gouge that is asked for is left so.
_LEAST_SHARE: Final = 0.05
_HOPELESS_SHARE: Final = 0.25
#: Depths along the normal are known to this, mm.
TRACED_MM: Final = 1e-4
#: Distances of the middles of cells may be above the least ones by this, mm.
_SLACK_MM: Final = 1e-5
#: Places within so many times the grid are one neighbourhood of the fit.
_NEIGHBOURS: Final = 10.0
#: Cells looked at between two reports of progress.
_BLOCK: Final = 20_000
#: Triangles whose height is a smaller share of their longest side are halved first.
_SLIM: Final = 0.3
#: A number of parts that is this close above a whole one is that: rounding.
_EVEN: Final = 1e-9

#: Called with the number of cells done and of all.
Watch = Callable[[int, int], None]


class Cells(Struct, frozen=True, eq=False):
    """Triangles (n, 3, 3) that facets (n,) were cut into, mm."""

    corner: Array
    facet: Ints

    def select(self, some: Ints | Mask | slice) -> "Cells":
        """Some of the cells."""
        return Cells(self.corner[some], self.facet[some])

    def cut(self, n: int) -> "Cells":
        """The n * n equal triangles of each."""
        i, j = np.nonzero(np.add.outer(np.arange(n), np.arange(n)) < n)
        k, m = np.nonzero(np.add.outer(np.arange(n), np.arange(n)) < n - 1)
        upright = np.stack([[i, i + 1, i], [j, j, j + 1]])
        turned = np.stack([[k + 1, k + 1, k], [m, m + 1, m + 1]])
        share = np.concatenate([upright, turned], axis=2) / n  # along two sides, corner, triangle
        order = np.lexsort((share[1, 0], share[0, 0]))
        share = share[:, :, order].transpose(2, 1, 0)
        a, sides = self.corner[:, 0], self.corner[:, 1:] - self.corner[:, :1]
        corner = a[:, None, None] + np.einsum("tcs,nsx->ntcx", share, sides)
        return Cells(corner.reshape(-1, 3, 3), np.repeat(self.facet, n * n))

    def halve(self) -> "Cells":
        """The two triangles of each, by the middle of its longest side."""
        side = np.stack([self.corner[:, (k + 2) % 3] - self.corner[:, (k + 1) % 3] for k in range(3)], axis=1)
        longest, row = (side * side).sum(2).argmax(axis=1), np.arange(len(self.corner))
        a, b, c = (self.corner[row, (longest + k) % 3] for k in range(3))
        middle = 0.5 * (b + c)
        parts = np.stack([np.stack([a, b, middle], axis=1), np.stack([a, middle, c], axis=1)], axis=1)
        return Cells(parts.reshape(-1, 3, 3), np.repeat(self.facet, 2))

    def find_circles(self) -> tuple[Array, Array]:
        """Middle (n, 3) and radius (n,) of the least circle about each."""
        side = np.stack([self.corner[:, (k + 2) % 3] - self.corner[:, (k + 1) % 3] for k in range(3)], axis=1)
        square = sum_rows(side * side)
        longest = square.argmax(axis=1)
        row = np.arange(len(self.corner))
        ends = self.corner[row, (longest + 1) % 3], self.corner[row, (longest + 2) % 3]
        middle = 0.5 * (ends[0] + ends[1])
        total = sum_rows(square)
        acute = np.flatnonzero(total > 2 * square[row, longest])
        weight = (square * (total[:, None] - 2 * square))[acute]
        weight /= sum_rows(weight)[:, None]
        middle[acute] = (weight[:, :, None] * self.corner[acute]).sum(1)
        # the largest of three equal distances: rounding only
        return middle, find_row_max(measure_rows(self.corner - middle[:, None]))


class Gouges(Struct, frozen=True, eq=False):
    """Places (n,) that are cut into deeper than asked, along their normals."""

    place: Array
    depth: Array  #: Along the normal, mm, no more than the search: what is judged.
    facet: Ints
    nearest: Nearest

    @property
    def shortest(self) -> Array:
        """Depths (n,) by the shortest way out, mm: how far the tool is off, also beside a wall that it undercuts."""
        return -self.nearest.distance


class Comparison(Struct, frozen=True, eq=False):
    """What the tools left of a nominal surface."""

    mesh: Mesh
    wanted: Wanted
    cells: Cells  #: Of the first division.
    #: (n,): Along the normal, mm: above 0 material that stays, below 0 a cut into the part; where it is small,
    #: the distance. NaN: no cutter comes within the search.
    deviation: Array
    nearest: Nearest  #: Of the middles of the cells.
    state: Ints  #: (m,): CLEAR, GOUGE or UNDECIDED for each facet.
    deepest: Array  #: (m,): A gouge of a facet that is not decided is no deeper than this, mm.
    gouges: Gouges
    grid: float  #: mm, the one asked for, or chosen.


def compare(
    mesh: Mesh, motions: tuple[Motion, ...], wanted: Wanted, watch: Watch | None = None, *, accelerate: bool = True
) -> Comparison:
    """Compare a nominal surface with the moving tools.

    Parameters
    ----------
    mesh : Mesh
        In the frame of the motions.
    accelerate : bool
        Use numba where it is installed.

    Raises
    ------
    InputError
        VP018 where the grid would make too many cells.
    """
    judge = _Judge(mesh, motions, wanted, accelerate)
    grid = choose_grid(mesh, wanted.grid)
    cells = divide(mesh, grid)
    blocks = [cells.select(slice(first, first + _BLOCK)) for first in range(0, len(cells.facet), _BLOCK)]
    looked, deviations = [], []
    for k, block in enumerate(blocks):
        if watch is not None:
            watch(k, len(blocks))
        nearest, deviation = judge.judge_cells(block)
        looked.append(nearest)
        deviations.append(deviation)
    nearest = Nearest(*(np.concatenate([getattr(one, name) for one in looked]) for name in Nearest.__struct_fields__))
    return Comparison(
        mesh, wanted, cells, np.concatenate(deviations), nearest, judge.state, judge.deepest, judge.list_gouges(), grid
    )


def choose_grid(mesh: Mesh, asked: float | None) -> float:
    """The grid that is asked for; None: :data:`GRID_MM`, or the finest of one digit that has not too many places.

    Raises
    ------
    InputError
        VP018: the grid that is asked for has too many, or any has.
    """
    grid = GRID_MM if asked is None else asked
    while True:
        try:
            _list_parts(mesh, grid)
        except InputError:
            if asked is not None or len(mesh.facets) > MAX_CELLS:
                raise
            step = 10.0 ** np.floor(np.log10(grid) + _EVEN)
            grid = float(round(grid / step + 1.0) * step)
        else:
            return float(f"{grid:.1g}") if asked is None else grid


def divide(mesh: Mesh, grid: float) -> Cells:
    """Cells of facets: no place of one is farther than ``grid`` from its middle.

    Raises
    ------
    InputError
        VP018: there would be too many; the message has a grid that will do.
    """
    done = [
        some.select(parts == n).cut(n) for some, parts in _list_parts(mesh, grid) for n in np.unique(parts).tolist()
    ]
    corner, facet = (np.concatenate([getattr(one, name) for one in done]) for name in ("corner", "facet"))
    order = np.argsort(facet, kind="stable")  # neighbours are looked at one after the other
    return Cells(corner[order], facet[order])


def _list_parts(mesh: Mesh, grid: float) -> list[tuple[Cells, Ints]]:
    """Facets, halved where they are slim, and into how many parts each side of them is cut (n,); VP018: too many."""
    done, left, count = [], Cells(mesh.list_corners(), np.arange(len(mesh.facets))), 0
    while len(left.facet):
        parts = np.maximum(np.ceil(left.find_circles()[1] / grid - _EVEN), 1).astype(np.int64)
        side = np.linalg.norm(left.corner - np.roll(left.corner, 1, axis=1), axis=2).max(axis=1)
        slim = (parts > 1) & (2.0 * measure_areas(left.corner) < _SLIM * side * side)
        count += int((parts[~slim] ** 2).sum())
        if count + 2 * int(slim.sum()) > MAX_CELLS:
            enough = grid * np.sqrt(count / MAX_CELLS)
            text = (
                f"{mesh.name}: a grid of {grid:g} mm has too many places; give {max(1.2 * enough, 1.5 * grid):.2g} mm "
                "(grid_mm of [part] in the set-up, --grid of machined), or a smaller STL with only the surface that "
                "matters"
            )
            raise make_input_error("VP018", text)
        done.append((left.select(~slim), parts[~slim]))
        left = left.select(slim).halve()
    return done


def measure_areas(corner: Array) -> Array:
    """Areas (n,) of triangles (n, 3, 3)."""
    return 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)


class _Judge:
    """Decides cells, and keeps what is known of their facets."""

    def __init__(self, mesh: Mesh, motions: tuple[Motion, ...], wanted: Wanted, accelerate: bool) -> None:
        self.motions, self.wanted, self.accelerate = motions, wanted, accelerate
        self.normals = mesh.list_normals()
        self.state = np.full(len(mesh.facets), CLEAR)
        self.deepest = np.zeros(len(mesh.facets))
        self.found: list[Gouges] = []
        self.bow = max((motion.bow for motion in motions), default=0.0)
        #: phi that a gouge reaches at least somewhere, of the sharpest piece of each group.
        self.limits: dict[tuple[str, ...], float] = {
            parts: max(
                (
                    find_limit(piece, wanted.gouge)
                    for motion in motions
                    for piece in motion.pieces
                    if piece.part in parts
                ),
                default=-np.inf,
            )
            for parts in (CUTTING, FOLLOWING)
        }

    def judge_cells(self, cells: Cells) -> tuple[Nearest, Array]:
        """Decide cells of the first division; returns what is nearest to their middles, and the deviations (n,)."""
        middle, _delta = cells.find_circles()
        nearest = self._look(middle, self.wanted.search, CUTTING, _SLACK_MM)
        normal = self.normals[cells.facet]
        deviation = np.where(nearest.row < 0, np.nan, nearest.distance)
        high = np.flatnonzero(nearest.distance > 0.5 * self.wanted.excess)
        deviation[high] = self._trace(middle[high], normal[high], nearest.distance[high], self.wanted.search, CUTTING)
        for parts in (CUTTING, FOLLOWING):
            if np.isfinite(self.limits[parts]):
                deep, depth = self._judge_parts(cells, parts, nearest if parts == CUTTING else None)
                deviation[deep] = -np.maximum(depth, np.where(deviation[deep] < 0, -deviation[deep], 0.0))
        return nearest, deviation

    def list_gouges(self) -> Gouges:
        """All places that were found."""
        if not self.found:
            none = np.zeros(0, dtype=np.int64)
            return Gouges(np.zeros((0, 3)), np.zeros(0), none, Nearest(np.zeros(0), none, none, none))
        nearest = Nearest(
            *(np.concatenate([getattr(one.nearest, name) for one in self.found]) for name in Nearest.__struct_fields__)
        )
        place, depth, facet = (
            np.concatenate([getattr(one, name) for one in self.found]) for name in ("place", "depth", "facet")
        )
        return Gouges(place, depth, facet, nearest)

    def _look(self, point: Array, cap: Array | float, parts: tuple[str, ...], slack: float = 0.0) -> Nearest:
        return find_nearest(self.motions, point, cap, parts, slack=slack, accelerate=self.accelerate)

    def _judge_parts(self, cells: Cells, parts: tuple[str, ...], nearest: Nearest | None) -> tuple[Ints, Array]:
        """Decide cells for one group of parts; returns those that are gouges at their middles, and the depths there."""
        wanted, limit = self.wanted, self.limits[parts]
        first: tuple[Ints, Array] | None = None
        while True:
            middle, delta = cells.find_circles()
            left = np.arange(len(delta))
            if nearest is not None:  # farther is clear at once
                left = np.flatnonzero(nearest.distance - _SLACK_MM - delta - self.bow <= limit)
            clear = find_clear(
                self.motions,
                middle[left],
                self.normals[cells.facet[left]],
                delta[left],
                wanted.gouge,
                parts,
                accelerate=self.accelerate,
            )
            left = left[~clear]
            cells, middle, delta = cells.select(left), middle[left], delta[left]
            normal = self.normals[cells.facet]
            nearest = self._look(middle, delta + self.bow, parts) if nearest is None else nearest.select(left)
            depth = np.zeros(len(left))
            cut = np.flatnonzero(nearest.distance <= 0.5 * limit)
            depth[cut] = -self._trace(middle[cut], normal[cut], -wanted.search, 0.0, parts)
            gouge = np.nan_to_num(depth, nan=0.0) > wanted.gouge
            self.state[cells.facet[gouge]] = GOUGE
            self.found.append(Gouges(middle[gouge], depth[gouge], cells.facet[gouge], nearest.select(gouge)))
            if first is None:
                first = left[gouge], depth[gouge]
            open_ones = ~gouge
            # where the middle itself cannot be called clear, smaller cells can only show a deeper place
            hopeless = (nearest.distance - self.bow <= limit) & (delta < _HOPELESS_SHARE * wanted.gouge)
            small = open_ones & (hopeless | (delta < _LEAST_SHARE * wanted.gouge) | (4 * open_ones.sum() > MAX_CELLS))
            facet = cells.facet[small]
            self.state[facet] = np.where(self.state[facet] == GOUGE, GOUGE, UNDECIDED)
            np.maximum.at(
                self.deepest,
                facet,
                (delta[small] + self.bow + _SLACK_MM - nearest.distance[small]) * wanted.gouge / -limit,
            )
            # a facet that is known to be gouged is not looked at again
            again = open_ones & ~small & (self.state[cells.facet] != GOUGE)
            if not again.any():
                return first
            cells, nearest = cells.select(again).cut(2), None

    def _trace(self, point: Array, normal: Array, start: Array | float, stop: float, parts: tuple[str, ...]) -> Array:
        """How far along the normal (n,) the tools are met first, from ``start`` on; NaN where not before ``stop``."""
        at = np.array(np.broadcast_to(start, len(point)), dtype=np.float64)
        left = np.arange(len(point))
        while len(left):
            cap = stop - at[left] + TRACED_MM
            distance = self._look(point[left] + at[left, None] * normal[left], cap, parts).distance
            met = distance <= TRACED_MM
            at[left] += np.where(met, np.maximum(distance, 0.0), distance)
            left = left[~met & (at[left] <= stop)]
        return np.where(at <= stop, at, np.nan)


def fit_datum(found: Comparison) -> tuple[Array, Array]:
    """Rigid motion of the mesh (rotation (3, 3), shift (3,)) that makes the deviations of touched places least squares.

    The lowest place of each neighbourhood counts, where the tool has been; what stays between two strips does not tell
    where the part is. Only directions are moved that the surface determines: a plane leaves its own directions alone.
    First order; places beyond three times the median are left out.
    """
    normals = found.mesh.list_normals()[found.cells.facet]
    middle, _delta = found.cells.find_circles()
    cube = np.floor(middle / (_NEIGHBOURS * found.grid)).astype(np.int64)
    order = np.lexsort((found.deviation, *np.rint(normals).T, *cube.T))  # NaN last
    key = np.hstack([cube, np.rint(normals).astype(np.int64)])[order]
    first = order[np.append(True, (key[1:] != key[:-1]).any(axis=1))] if len(order) else order
    deviation = found.deviation[first]
    near = np.isfinite(deviation)
    if not near.any():
        return np.eye(3), np.zeros(3)
    near &= np.abs(deviation) <= 3.0 * np.median(np.abs(deviation[near])) + TRACED_MM
    place, normal, deviation = middle[first][near], normals[first][near], deviation[near]
    centre = place.mean(axis=0)
    arm = place - centre
    scale = max(float(np.abs(arm).max()), TRACED_MM)
    rows = np.hstack([normal, np.cross(arm, normal) / scale])
    moved = np.linalg.lstsq(rows, deviation, rcond=1e-6)[0]
    turn = _make_rotation(np.asarray(moved[3:] / scale))
    return turn, centre - turn @ centre + moved[:3]


def _make_rotation(vector: Array) -> Array:
    """The rotation (3, 3) about a vector by its length, rad."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def is_inside(mesh: Mesh, point: Array) -> Mask:
    """Whether points (n, 3) are inside a closed mesh: by the solid angle that it fills."""
    inside = np.zeros(len(point), dtype=bool)
    for k, one in enumerate(point):
        a, b, c = np.moveaxis(mesh.list_corners() - one, 1, 0)
        la, lb, lc = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        top = (a * np.cross(b, c)).sum(1)
        below = la * lb * lc + (a * b).sum(1) * lc + (b * c).sum(1) * la + (c * a).sum(1) * lb
        inside[k] = np.arctan2(top, below).sum() > np.pi  # half of the solid angle; the whole is 4 pi
    return inside


def move_mesh(found: Comparison) -> Mesh:
    """The mesh of a comparison where its deviations are least squares."""
    return found.mesh.move(*fit_datum(found))
