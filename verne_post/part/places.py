"""Which lines of a motion touch a surface, and where: every line is decided once.

The surface comes as cells: triangles with a middle, a normal and a radius. A line touches where the middle of a cell
comes within the limit of a body at any time of it. It keeps off a cell where a bound over the whole cell and all that
time says so. Lines that touch are not checked again, so that a body deep in a fixture costs no more than one that
grazes it. Cells that decide nothing for some line are to be cut.
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.part.bodies import Piece
from verne_post.part.bound import are_spans_above, is_stretch_above
from verne_post.part.motion import FAN, Motion
from verne_post.part.sweep import list_children, load_accelerator, look, measure_motion, search_spans, take

#: Cells that go down the tree together: the first ones decide most lines for those that follow.
_FIRST: Final = 32
_TOGETHER: Final = 2048
#: Multiples of the golden section, without their whole parts, lie evenly however many are taken.
GOLDEN: Final = 0.5 * (np.sqrt(5.0) - 1.0)


class Marks(Struct, frozen=True, eq=False):
    """The lines (k,) of a motion of n rows, and what is known of them."""

    line: Ints  #: (k,)
    group: Ints  #: (n,): Index of the line of each row.
    #: order, begin (n,) and (k + 1,): The rows of each line, one line after the other.
    order: Ints
    begin: Ints
    touched: Mask  #: (k,)
    value: Array  #: (k,): A distance at which the line touches, mm: the first that was seen.
    place: Array  #: (k, 3): Where that is.
    row: Ints  #: (k,): The row at or before.
    left: Ints  #: How many rows of each node of the tree belong to lines that are not known to touch; level by level.

    def note(self, row: Ints, value: Array, place: Array) -> None:
        """Lines of rows (m,) touch at places (m, 3)."""
        group, first = np.unique(self.group[row], return_index=True)
        new = ~self.touched[group]
        group, first = group[new], first[new]
        self.touched[group] = True
        self.value[group], self.row[group], self.place[group] = value[first], row[first], place[first]


def list_lines(motion: Motion) -> Marks:
    """The lines of a motion, none of which is known to touch."""
    line, group = np.unique(motion.line, return_inverse=True)
    group = group.reshape(-1)
    begin = np.append(0, np.cumsum(np.bincount(group)))
    k = len(line)
    left = [
        np.add.reduceat(np.ones(len(group), dtype=np.int64), _list_firsts(motion, size)) for size in _list_sizes(motion)
    ]
    return Marks(
        line,
        group,
        np.argsort(group, kind="stable"),
        begin,
        np.zeros(k, dtype=bool),
        np.full(k, np.inf),
        np.full((k, 3), np.nan),
        np.full(k, -1),
        np.concatenate(left),
    )


def touch_cells(
    motion: Motion,
    piece: Piece,
    cells: tuple[Array, Array, Array],
    limit: float,
    least: float,
    marks: Marks,
    *,
    accelerate: bool = True,
) -> Mask:
    """Mark the lines in which a piece touches cells (n,); cells that have to be cut (n,).

    Parameters
    ----------
    cells : tuple of ndarray
        Middle and normal (n, 3), and radius (n,), mm.
    limit : float
        mm: what comes as near touches.
    least : float
        Lines that cells no larger than this leave open count as touching, mm.
    """
    kernel = load_accelerator() if accelerate else None
    if kernel is not None:
        arrays = (marks.group, marks.order, marks.begin, marks.touched, marks.value, marks.place, marks.row, marks.left)
        return np.asarray(kernel.touch(motion, piece, cells, limit, least, arrays))
    opened = np.zeros(len(cells[0]), dtype=bool)
    # evenly over all, so that the first ones are not neighbours
    mixed = np.argsort(np.arange(len(opened)) * GOLDEN % 1.0, kind="stable")
    at, size = 0, _FIRST
    while at < len(opened):
        some = mixed[at : at + size]
        opened[some] = _touch_together(motion, piece, take(some, *cells), limit, least, marks)
        at, size = at + size, min(2 * size, _TOGETHER)
    return opened


def _list_sizes(motion: Motion) -> list[int]:
    """Rows of a node of each level."""
    return [FAN ** (k + 1) for k in range(len(motion.levels))]


def _list_firsts(motion: Motion, size: int) -> Ints:
    return np.arange(0, len(motion.tip), size)


# --- without numba -----------------------------------------------------------------------------------


def _touch_together(
    motion: Motion, piece: Piece, cells: tuple[Array, Array, Array], limit: float, least: float, marks: Marks
) -> Mask:
    point, _normal, delta = cells
    waiting = ~marks.touched[marks.group]
    count = len(motion.levels[-1].middle)
    owner: Ints = np.repeat(np.arange(len(point)), count)
    node: Ints = np.tile(np.arange(count), len(point))
    sizes = _list_sizes(motion)[::-1]
    for level, size, below in zip(motion.levels[::-1], sizes, (*motion.levels[-2::-1], None), strict=True):
        left = np.logical_or.reduceat(waiting, _list_firsts(motion, size))
        owner, node = take(np.flatnonzero(left[node]), owner, node)
        at = level.middle[node]
        seen = look(piece, point[owner], motion.tip[at], motion.axis[at])
        lower = seen.phi - level.tip[node] - level.chord[node] * np.sqrt(np.einsum("ij,ij->i", seen.d, seen.d))
        owner, node = take(np.flatnonzero(lower - delta[owner] <= limit), owner, node)
        straight = level.tip_bend[node] < delta[owner]
        straight[straight] = is_stretch_above(
            motion, piece, level, node[straight], cells, owner[straight], limit + motion.bow
        )
        owner, node = list_children(
            owner[~straight], node[~straight], len(motion.tip) if below is None else len(below.middle)
        )
    owner, row = take(np.flatnonzero(waiting[node]), owner, node)
    seen = look(piece, point[owner], motion.tip[row], motion.axis[row])
    move, turn = measure_motion(motion, row)
    away = np.linalg.norm(move, axis=1) + np.linalg.norm(turn, axis=1) * np.linalg.norm(seen.d, axis=1)
    marks.note(*take(np.flatnonzero(seen.phi <= limit), row, seen.phi, point[owner]))
    near = (seen.phi - away - motion.bow - delta[owner] <= limit) & ~marks.touched[marks.group[row]]
    owner, row = take(np.flatnonzero(near), owner, row)
    # the least distance of each pair, where it is below what clears the cell
    reach = limit + delta[owner] + motion.bow
    best, found = reach.copy(), np.full(len(row), -1)
    search_spans(motion, piece, point[owner], np.arange(len(row)), row, best, found)
    marks.note(*take(np.flatnonzero(best <= limit), row, best, point[owner]))
    near = np.flatnonzero((best < reach) & ~marks.touched[marks.group[row]])
    owner, row, best = take(near, owner, row, best)
    above = are_spans_above(motion, piece, take(owner, *cells), np.arange(len(row)), row, limit + motion.bow)
    owner, row, best = take(np.flatnonzero(~above), owner, row, best)
    small = delta[owner] <= least
    marks.note(*take(np.flatnonzero(small), row, best, point[owner]))
    opened = np.zeros(len(point), dtype=bool)
    opened[owner[~small]] = True
    return opened
