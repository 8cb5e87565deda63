"""Stock as parallel rays (dexels): on each the intervals that are still material.

The rays run along z of the stock's own frame, through the middles of equal cells. What a tool takes is cut from every
ray exactly. Between the rays nothing is known: what is thinner than their distance may be missed, and a wall along them
may be off by half of it. A body that moves straight with a vertical axis is cut as swept; any other one as standing
bodies, which never take more than the sweep.
"""

import io
from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.ragged import number_parts
from verne_post.base.rotations import rotate_z
from verne_post.part.ray_tables import VERTICAL, RayTable, meet_moving, meet_standing

#: Ends of a place for an interval that is free, mm: beyond everything.
NOWHERE: Final = 1e30
#: Rounding of a place in a row of spans, as a share of the distance between bodies.
SAME_PLACE: Final = 1e-6
#: Rays at most, 36 MB with two intervals each; a larger stock has them farther apart.
MOST_RAYS: Final = 1_000_000
#: Overflow rows and their places to begin with.
OVERFLOW: Final = (64, 8)
#: What a saved stock begins with; later forms get another number.
FORM: Final = 1

#: Ends that are equal to this many decimals, mm, are equal in a mesh.
EQUAL_DECIMALS: Final = 4
#: The twelve triangles of a box; bit k of a corner says whether it is at the upper end along axis k.
_CORNERS: Final = (
    (0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2),
    (1, 3, 7), (1, 7, 5),
)  # fmt: skip
#: A triangle of a binary STL file.
_FACET: Final = np.dtype([("normal", "<f4", 3), ("vertex", "<f4", (3, 3)), ("attribute", "<u2")])


class Sweeps(Struct, frozen=True, eq=False):
    """Bodies that move straight with a vertical axis, or stand (at ``end``, with any axis)."""

    #: start, end, axis (n, 3): Tips, mm, and unit axis, in the frame of the stock.
    start: Array
    end: Array
    axis: Array
    owner: Ints  #: (n,): The span of motion that each belongs to.

    def __len__(self) -> int:
        return len(self.owner)

    def take(self, which: Ints | Mask | slice) -> "Sweeps":
        """Some of them."""
        return Sweeps(self.start[which], self.end[which], self.axis[which], self.owner[which])


def load_compiled() -> Any:
    """The compiled kernels; None where numba is not installed."""
    try:
        from verne_post.part import compiled_rays
    except ImportError:
        return None
    return compiled_rays


def find_upright(axis: Array) -> Mask:
    """Spans (n,) whose axis, at both ends (n, 2, 3), is vertical and points up."""
    return np.asarray((np.hypot(axis[..., 0], axis[..., 1]) < VERTICAL).all(axis=1) & (axis[..., 2] > 0).all(axis=1))


def count_bodies(tip: Array, axis: Array, reach: float, step: float) -> Ints:
    """How many bodies (n,) stand for each span alone, without the one at its begin.

    That is an upper bound: in :func:`list_sweeps`, short spans in a row share bodies.
    """
    return np.where(find_upright(axis), 1, np.maximum(np.ceil(_measure_moved(tip, axis, reach) / step), 1)).astype(int)


def _measure_moved(tip: Array, axis: Array, reach: float) -> Array:
    """How far a body moves at most on each span (n,), mm."""
    return np.linalg.norm(tip[:, 1] - tip[:, 0], axis=1) + reach * np.linalg.norm(axis[:, 1] - axis[:, 0], axis=1)


def list_sweeps(tip: Array, axis: Array, reach: float, step: float) -> Sweeps:
    """The bodies that stand for spans of motion; short spans in a row share them.

    Parameters
    ----------
    tip, axis : ndarray, shape (n, 2, 3)
        At the beginning and at the end of each span; between them both change evenly.
    reach : float
        Length of the body, mm: how far a turn of the axis moves it.
    step : float
        Standing bodies are no farther from each other than this, mm.
    """
    upright = find_upright(axis)
    if upright.all():
        return Sweeps(tip[:, 0], tip[:, 1], np.tile([0.0, 0.0, 1.0], (len(tip), 1)), np.arange(len(tip)))
    parts = count_bodies(tip, axis, reach, step)
    goes_on = np.zeros(len(tip), dtype=bool)
    goes_on[1:] = (tip[1:, 0] == tip[:-1, 1]).all(axis=1) & (axis[1:, 0] == axis[:-1, 1]).all(axis=1) & ~upright[:-1]
    moved, short = _measure_moved(tip, axis, reach), ~upright & (parts <= 2)
    row = np.cumsum(~(goes_on & short & np.append(False, short[:-1]))) - 1  # each long span is a row of its own
    total = np.bincount(row, moved)
    apart = (total / np.maximum(np.ceil(total / step), 1))[row] + (total[row] == 0)
    end = np.cumsum(moved) - (np.cumsum(total) - total)[row]
    before, after = (np.floor(one / apart + SAME_PLACE).astype(int) for one in (end - moved, end))
    before[upright], after[upright] = 0, 1
    starts = ~upright & ~goes_on
    owner, index = number_parts(after - before + starts)
    place = (before[owner] + index + ~starts[owner]) * apart[owner] - (end - moved)[owner]
    share = np.clip(place / np.where(moved > 0, moved, 1.0)[owner], 0.0, 1.0)
    share[upright[owner]] = 1.0
    at = tip[owner, 0] + share[:, None] * (tip[owner, 1] - tip[owner, 0])
    to = axis[owner, 0] + share[:, None] * (axis[owner, 1] - axis[owner, 0])
    to /= np.linalg.norm(to, axis=1)[:, None]
    to[upright[owner]] = 0.0, 0.0, 1.0
    return Sweeps(np.where(upright[owner, None], tip[owner, 0], at), at, to, owner)


def find_boxes(sweeps: Sweeps, table: RayTable) -> tuple[Array, Array]:
    """Corners (n, 3) of boxes around bodies that move."""
    side = table.radius * np.sqrt(np.maximum(1.0 - sweeps.axis**2, 0.0))
    heights = table.low * sweeps.axis, table.high * sweeps.axis
    low, high = (choose(sweeps.start, sweeps.end) + choose(*heights) for choose in (np.minimum, np.maximum))
    return low - side, high + side


class Dexels:
    """A stock that is cut.

    Parameters
    ----------
    origin : ndarray, shape (3,)
        Where the corner of the first cell is at z = 0 of the stock, mm, table frame.
    turn : float
        The stock's frame is turned by this about the table's normal, rad.
    cell : ndarray, shape (2,)
        Distance of the rays along x and y of the stock, mm.
    low, high : ndarray, shape (nx, ny, places)
        Ends of the intervals of each ray, in no order, mm; ``low > high``: free.

    The few rays that get more intervals than they have places go on in a row of an overflow table. Places for all rays
    would be gigabytes.
    """

    def __init__(self, origin: Array, turn: float, cell: Array, low: Array, high: Array) -> None:
        self.origin, self.turn, self.cell, self._low, self._high = origin, turn, cell, low, high
        #: The overflow row of each ray; 0, which stays free, for none. And how many rows are in use.
        self._row, self._rows = np.zeros(low.shape[:2], np.int32), np.ones(1, np.int32)
        self._more_low, self._more_high = np.full(OVERFLOW, NOWHERE), np.full(OVERFLOW, -NOWHERE)
        #: So many places of each overflow row are in use at most: one ray with hundreds gives all rows as many.
        self._used = np.zeros(OVERFLOW[0], np.int32)
        there = high > low
        #: Corners (3,) of a box around the material, in the frame of the stock.
        least, most = (low[there].min(), high[there].max()) if there.any() else (0.0, 0.0)
        self.least, self.most = np.append(np.zeros(2), least), np.append(np.array(self.counts) * cell, most)

    @property
    def counts(self) -> tuple[int, int]:
        """Rays along x and along y."""
        return self._low.shape[0], self._low.shape[1]

    @property
    def low(self) -> Array:
        """Lower ends of all intervals (nx, ny, places)."""
        return self._low if self._rows[0] == 1 else np.concatenate([self._low, self._more_low[self._row]], axis=2)

    @property
    def high(self) -> Array:
        """Upper ends of all intervals (nx, ny, places)."""
        return self._high if self._rows[0] == 1 else np.concatenate([self._high, self._more_high[self._row]], axis=2)

    @property
    def resolution(self) -> float:
        """A point is no farther from a ray than this, mm."""
        return 0.5 * float(np.hypot(*self.cell))

    @property
    def area(self) -> float:
        """Of a cell, mm2."""
        return float(self.cell[0] * self.cell[1])

    def measure_volume(self) -> float:
        """What is left, mm3."""
        tables = (self._low, self._high), (self._more_low, self._more_high)
        return self.area * sum(float(np.maximum(high - low, 0.0).sum()) for low, high in tables)

    def copy(self) -> "Dexels":
        """The stock as it is now."""
        return Dexels(self.origin, self.turn, self.cell, self.low.copy(), self.high.copy())

    def thin(self, most: int) -> "Dexels":
        """The same on fewer rays, evenly chosen: no more than ``most``."""
        step = int(np.ceil(np.sqrt(self.counts[0] * self.counts[1] / most)))
        if step <= 1:
            return self.copy()
        some = tuple(slice(step // 2, max(n // step, 1) * step, step) for n in self.counts)
        return Dexels(self.origin, self.turn, step * self.cell, self.low[some].copy(), self.high[some].copy())

    def place_inside(self, tip: Array, axis: Array) -> tuple[Array, Array]:
        """Points and directions (..., 3) of the table frame in the frame of the stock."""
        return rotate_z(tip - self.origin, -self.turn), rotate_z(axis, -self.turn)

    def move(self, origin: Array, turn: float, *, back: bool = False) -> "Dexels":
        """The stock of a frame at ``origin`` (3,) of the table, turned by ``turn``, on the table; ``back``: inverse."""
        if back:
            return Dexels(rotate_z(self.origin - origin, -turn), self.turn - turn, self.cell, self.low, self.high)
        return Dexels(rotate_z(self.origin, turn) + origin, self.turn + turn, self.cell, self.low, self.high)

    def encode_stl(self) -> bytes:
        """Boxes as a binary STL: neighbouring rays with equal intervals are one box."""
        low, high = self.merge_columns()
        corner = np.stack(
            [np.where(np.array(_CORNERS) >> k & 1, high[:, k, None, None], low[:, k, None, None]) for k in range(3)],
            axis=-1,
        )
        facets = np.zeros(12 * len(low), _FACET)
        facets["vertex"] = self.place_outside(corner).reshape(-1, 3, 3)
        return b"stock left".ljust(80) + len(facets).to_bytes(4, "little") + facets.tobytes()

    def place_outside(self, point: Array) -> Array:
        """Points (..., 3) of the frame of the stock in the table frame."""
        return rotate_z(point, self.turn) + self.origin

    # --- rays and bodies ---------------------------------------------------------------------------

    def cut(self, sweeps: Sweeps, table: RayTable, *, compiled: bool = True) -> Array:
        """Take bodies away, in their order; the volume that each takes (n,), mm3.

        ``compiled`` = False leaves numba aside, which takes longer and has the same answers.
        """
        removed = np.zeros(len(sweeps))
        kernels = load_compiled() if compiled else None
        rows = self._find_near(sweeps, table)
        if kernels is None:
            for row in rows.tolist():
                removed[row] = self.take(*self._meet(sweeps, table, row))
            return removed
        near = sweeps.take(rows)
        volume, done = np.zeros(len(rows)), 0
        while done < len(rows):
            stock, bodies = self._describe(), _describe_sweeps(near)
            done, i, j, *ends = kernels.cut(stock, self.cell, bodies, _describe_table(table), volume, done)
            if done < len(rows):  # an interval has found no place
                self._store(*(np.array([one]) for one in (i, j, *ends)))
        removed[rows] = volume
        return removed

    def find_touching(
        self, sweeps: Sweeps, table: RayTable, *, compiled: bool = True, only_first: bool = False
    ) -> Mask:
        """Which bodies (n,) have material in them on some ray; ``only_first``: one of them, sought from the last on."""
        touching = np.zeros(len(sweeps), dtype=bool)
        if table.is_empty:
            return touching
        kernels = load_compiled() if compiled else None
        rows = self._find_near(sweeps, table)
        if kernels is None:
            for row in rows[::-1].tolist():
                touching[row] = len(self.list_overlaps(sweeps, table, row)[0]) > 0
                if only_first and touching[row]:
                    break
            return touching
        if only_first:
            rows = rows[::-1]
        found = np.zeros(len(rows), dtype=np.bool_)
        stock, near = self._describe(), _describe_sweeps(sweeps.take(rows))
        kernels.touch(stock, self.cell, near, _describe_table(table), found, only_first)
        touching[rows] = found
        return touching

    def list_overlaps(
        self, sweeps: Sweeps, table: RayTable, row: int, most_rays: float = np.inf
    ) -> tuple[Array, Array]:
        """Middles (m, 3) of the material inside body ``row``, and its length (m,) along the rays, mm.

        Where more rays than ``most_rays`` meet the box of the body, only some are looked at, in even steps.
        """
        window, low, high = self._meet(sweeps, table, row, most_rays)
        rays, enter, leave = _list_met(window, low, high)
        middles, overlaps = [], []
        for low, high, at, own in self._list_places(*rays):
            starts, ends = np.maximum(low[at], enter[own]), np.minimum(high[at], leave[own])
            ray, k = np.nonzero(ends > starts)
            starts, ends = starts[ray, k], ends[ray, k]
            xy = (np.column_stack(rays)[own][ray] + 0.5) * self.cell
            middles.append(np.column_stack([xy, 0.5 * (starts + ends)]))
            overlaps.append(ends - starts)
        return np.concatenate(middles), np.concatenate(overlaps)

    def _list_places(self, i: Ints, j: Ints) -> Iterator[tuple[Array, Array, tuple[Ints, ...], Ints | slice]]:
        """Tables with intervals of rays (m,): lower and upper ends, where the rays are in them, and which rays."""
        yield self._low, self._high, (i, j), slice(None)
        row = self._row[i, j]
        own = np.flatnonzero(row)
        if len(own):
            used = self._used[row[own]].max()
            yield self._more_low[:, :used], self._more_high[:, :used], (row[own],), own

    def _find_near(self, sweeps: Sweeps, table: RayTable) -> Ints:
        """Bodies whose box reaches into that of the stock."""
        low, high = find_boxes(sweeps, table)
        return np.flatnonzero(((high > self.least) & (low < self.most)).all(axis=1))

    def _meet(
        self, sweeps: Sweeps, table: RayTable, row: int, most_rays: float = np.inf
    ) -> tuple[tuple[slice, slice], Array, Array]:
        """The cells around a body, or some of them, and where their rays enter and leave it."""
        one = sweeps.take(slice(row, row + 1))
        least, most = find_boxes(one, table)
        first = np.maximum(np.ceil(least[0, :2] / self.cell - 0.5), 0).astype(int)
        last = np.minimum(np.floor(most[0, :2] / self.cell - 0.5) + 1, self.counts).astype(int)
        n, m = np.maximum(last - first, 0).tolist()
        step = max(int(np.sqrt(n * m / most_rays)), 1)
        window = slice(first[0], first[0] + n, step), slice(first[1], first[1] + m, step)
        x, y = (
            (np.arange(one.start, one.stop, step) + 0.5) * size for one, size in zip(window, self.cell, strict=True)
        )
        x, y = np.meshgrid(x, y, indexing="ij")
        axis, end = one.axis[0], one.end[0]
        if axis[2] > 0 and np.hypot(axis[0], axis[1]) < VERTICAL:
            low, high = meet_moving(table, x, y, one.start[0], end)
        else:
            low, high = meet_standing(table, x - end[0], y - end[1], axis)
            low, high = low + end[2], high + end[2]
        return window, low, high

    def take(self, window: tuple[slice, slice], a: Array, b: Array) -> float:
        """Take the intervals from ``a`` to ``b``, one for each ray of a window of cells, away; the volume, mm3."""
        return self.take_along(*_list_met(window, a, b))

    def take_along(self, rays: list[Ints], enters: Array, leaves: Array) -> float:
        """The same along different rays (m,), from where they enter (m, 1) to where they leave."""
        removed, split = 0.0, []
        for low, high, at, own in self._list_places(*rays):
            ray, k = np.nonzero((enters[own] < high[at]) & (leaves[own] > low[at]))
            place = (*(one[ray] for one in at), k)
            lo, hi, enter, leave = low[place], high[place], enters[own][ray, 0], leaves[own][ray, 0]
            removed += float((np.minimum(hi, leave) - np.maximum(lo, enter)).sum())
            below, above = lo < enter, hi > leave
            low[place] = np.where(below, lo, np.where(above, leave, NOWHERE))
            high[place] = np.where(below, enter, np.where(above, hi, -NOWHERE))
            both = below & above
            split.append([one[own][ray[both]] for one in rays] + [leave[both], hi[both]])
        for i, j, low, high in split:
            self._store(i, j, low, high)
        return removed * self.area

    def find_filled(self, rays: list[Ints]) -> Mask:
        """Along which rays (m,) there is material."""
        filled = np.zeros(len(rays[0]), dtype=bool)
        for low, high, at, own in self._list_places(*rays):
            filled[own] |= (high[at] > low[at]).any(axis=1)
        return filled

    def _store(self, i: Ints, j: Ints, low: Array, high: Array) -> None:
        """Give intervals (m,) of different rays a free place."""
        free = self._low[i, j] > self._high[i, j]
        is_full = ~free.any(axis=1)
        k = np.argmax(free, axis=1)
        some = ~is_full
        self._low[i[some], j[some], k[some]], self._high[i[some], j[some], k[some]] = low[some], high[some]
        if not is_full.any():
            return
        i, j, low, high = i[is_full], j[is_full], low[is_full], high[is_full]
        new = np.flatnonzero(self._row[i, j] == 0)
        self._row[i[new], j[new]] = self._rows[0] + np.arange(len(new))
        self._rows += len(new)
        while self._rows[0] >= len(self._more_low):  # one is left for the next interval that finds no place
            self._add_places(2, 1)
        row = self._row[i, j]
        if not (self._more_low[row] > self._more_high[row]).any(axis=1).all():
            self._add_places(1, 2)
        k = np.argmax(self._more_low[row] > self._more_high[row], axis=1)
        self._more_low[row, k], self._more_high[row, k] = low, high
        self._used[row] = np.maximum(self._used[row], k + 1)

    def _add_places(self, rows: int, places: int) -> None:
        """So many times the rows of the overflow table, and places in each."""
        n, m = self._more_low.shape
        for name, nowhere in (("_more_low", NOWHERE), ("_more_high", -NOWHERE)):
            more = np.full((rows * n, places * m), nowhere)
            more[:n, :m] = getattr(self, name)
            setattr(self, name, more)
        self._used = np.append(self._used, np.zeros((rows - 1) * n, np.int32))

    def _describe(self) -> tuple[Array | Ints, ...]:
        return self._low, self._high, self._row, self._more_low, self._more_high, self._used, self._rows

    # --- to files ----------------------------------------------------------------------------------

    def pack(self) -> bytes:
        """As a file (npz) has it; :func:`stock_forms.unpack` reads it for the next set-up."""
        buffer = io.BytesIO()
        taken = np.asarray((self.high > self.low).any(axis=(0, 1)))
        taken[0] = True
        np.savez_compressed(
            buffer,
            form=np.array(FORM),
            origin=self.origin,
            turn=np.array(self.turn),
            cell=self.cell,
            low=self.low[..., taken],
            high=self.high[..., taken],
        )
        return buffer.getvalue()

    def merge_columns(self) -> tuple[Array, Array]:
        """Corners (n, 3) of boxes that together are the stock: neighbouring rays with equal intervals are one box."""
        ends = (np.moveaxis(np.round(one, EQUAL_DECIMALS), 2, 0) for one in (self.low, self.high))
        boxes = [box for low, high in zip(*ends, strict=True) for box in _merge_cells(low, high)]
        if not boxes:
            return np.empty((0, 3)), np.empty((0, 3))
        i0, i1, j0, j1, low, high = np.array(boxes).T
        dx, dy = self.cell
        return np.stack([i0 * dx, j0 * dy, low], axis=1), np.stack([i1 * dx, j1 * dy, high], axis=1)


def _describe_sweeps(sweeps: Sweeps) -> tuple[Array, Array, Array]:
    return tuple(np.ascontiguousarray(one) for one in (sweeps.start, sweeps.end, sweeps.axis))  # type: ignore[return-value]


def _describe_table(table: RayTable) -> tuple[Array, Array, float, float, float]:
    return table.edges, table.corners, table.radius, table.low, table.high


def _list_met(window: tuple[slice, slice], a: Array, b: Array) -> tuple[list[Ints], Array, Array]:
    """Cells (m,) of a window whose rays meet a body, and where they enter and leave it (m, 1)."""
    met = np.nonzero(a < b)
    rays = [one * (cells.step or 1) + cells.start for one, cells in zip(met, window, strict=True)]
    return rays, a[met][:, None], b[met][:, None]


def _merge_cells(low: Array, high: Array) -> list[tuple[float, ...]]:
    """Rectangles of cells (nx, ny) with equal intervals: first and last cells, and the interval."""
    boxes: list[tuple[float, ...]] = []
    growing: dict[tuple[float, ...], int] = {}
    for i in range(len(low) + 1):
        runs: list[tuple[float, ...]] = []
        if i < len(low):
            a, b = low[i], high[i]
            begins = np.flatnonzero(np.concatenate([[True], (np.diff(a) != 0) | (np.diff(b) != 0)]))
            ends = np.append(begins[1:], len(a))
            there = b[begins] > a[begins]
            runs = list(
                zip(
                    begins[there].tolist(),
                    ends[there].tolist(),
                    a[begins][there].tolist(),
                    b[begins][there].tolist(),
                    strict=True,
                )
            )
        now = {run: growing.pop(run, i) for run in runs}
        boxes += [(first, i, *run) for run, first in growing.items()]
        growing = now
    return boxes
