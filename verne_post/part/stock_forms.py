"""Stock before it is cut: a box, a cylinder, a closed mesh, or what another set-up has left."""

import io
import struct
import tokenize
import zipfile
import zlib
from functools import lru_cache
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.ragged import number_parts
from verne_post.base.rotations import rotate_z
from verne_post.model.findings import make_input_error
from verne_post.part.dexels import FORM, MOST_RAYS, NOWHERE, Dexels
from verne_post.part.stl import Mesh, read_stl

#: Distance of the rays where nothing else is asked for, mm.
CELL_MM: Final = 0.1
#: Rays pass beside the middle of cells by these shares, so that none runs along an edge; without a common measure.
ASIDE: Final = (1.7e-6, 2.3e-6)
#: Edges that are less wide, in rays, count as a whole in their column: where they cross it rounding would decide.
_STEEP: Final = 1e-3
#: What reading a damaged archive raises, in zipfile, zlib and numpy.
_DAMAGES: Final = (
    OSError,
    ValueError,
    TypeError,
    KeyError,
    EOFError,
    OverflowError,
    MemoryError,
    RuntimeError,
    struct.error,
    zipfile.BadZipFile,
    zlib.error,
    tokenize.TokenError,
)


def make_box(low: Array, high: Array, origin: Array, turn: float, cell: float = CELL_MM) -> Dexels:
    """A box with corners (3,) in a frame at ``origin`` of the table, turned by ``turn`` about its normal (rad)."""
    size = np.asarray(high, dtype=float) - low
    counts = _count_rays(size[:2], cell)
    corner = np.asarray(origin, dtype=float) + rotate_z(np.append(np.asarray(low, dtype=float)[:2], 0.0), turn)
    ends = np.full((*counts, 2), NOWHERE), np.full((*counts, 2), -NOWHERE)
    ends[0][..., 0], ends[1][..., 0] = low[2], high[2]
    return Dexels(corner, turn, size[:2] / counts, *ends)


def make_cylinder(low: Array, high: Array, bore: float, origin: Array, turn: float, cell: float = CELL_MM) -> Dexels:
    """An upright cylinder in the middle of such a box, with a bore of this diameter (0: none)."""
    stock = make_box(low, high, origin, turn, cell)
    size = np.asarray(high, dtype=float)[:2] - np.asarray(low)[:2]
    x, y = (
        (np.arange(n) + 0.5) * one - 0.5 * long for n, one, long in zip(stock.counts, stock.cell, size, strict=True)
    )
    r = np.hypot(*np.meshgrid(x, y, indexing="ij"))
    empty = (r > 0.5 * float(size.min())) | (r < 0.5 * bore)
    stock.low[empty, 0], stock.high[empty, 0] = NOWHERE, -NOWHERE
    return stock


def make_of_mesh(mesh: Mesh, origin: Array, turn: float) -> Dexels:
    """A mesh, given in such a frame: closed where rays pass, and boxes may touch each other.

    Raises
    ------
    InputError
        VP506: it is open, flipped or inside out, or rays leave it more often than they enter it.
    """
    corner = mesh.list_corners()
    low, high = corner.min(axis=(0, 1)), corner.max(axis=(0, 1))
    stock = make_box(low, high, origin, turn)
    ends = list_intervals(mesh.name, (corner - np.append(low[:2], 0.0)), stock.cell, stock.counts)
    return Dexels(stock.origin, turn, stock.cell, *ends)


def list_intervals(name: str, corner: Array, cell: Array, counts: tuple[int, int]) -> tuple[Array, Array]:
    """Intervals of rays inside triangles (n, 3, 3) of their frame: ends (nx, ny, places), ``low > high`` for none.

    Raises
    ------
    InputError
        VP506: rays leave it more often than they enter it.
    """
    ray, z, side = cross_mesh(corner / np.append(cell, 1.0), counts)
    order = np.lexsort((-side, z, ray))
    ray, z, side = ray[order], z[order], side[order]
    depth = np.cumsum(side)  # how often the ray is inside; every ray has to come out again
    is_last = np.diff(ray, append=-1) != 0
    if depth.min(initial=0) < 0 or (depth[is_last] != 0).any():
        raise make_input_error(
            "VP506",
            f"{name}: it crosses itself, or facets are missing: a ray along z leaves it more often than it enters it",
        )
    enters, leaves = (side > 0) & (depth == 1), depth == 0
    ray, enter, leave = ray[enters], z[enters], z[leaves]
    place = np.arange(len(ray)) - np.maximum.accumulate(np.where(np.diff(ray, prepend=-1) != 0, np.arange(len(ray)), 0))
    places = max(2, int(place.max(initial=0)) + 1)
    low_ends, high_ends = np.full((*counts, places), NOWHERE), np.full((*counts, places), -NOWHERE)
    i, j = np.divmod(ray, counts[1])
    low_ends[i, j, place], high_ends[i, j, place] = enter, leave
    return low_ends, high_ends


@lru_cache(maxsize=2)
def read_stock(raw: bytes, name: str, unit: str) -> Dexels:
    """The stock of an STL file, or what another run has left (npz), in the frame of the file; not to be cut itself.

    Raises
    ------
    InputError
        VP506.
    """
    if name.lower().rstrip(")").endswith(".npz"):
        return unpack(raw, name)
    return make_of_mesh(read_stl(raw, name, unit), np.zeros(3), 0.0)


def unpack(raw: bytes, name: str) -> Dexels:
    """What :meth:`Dexels.pack` wrote.

    Raises
    ------
    InputError
        VP506: another file.
    """
    try:
        with np.load(io.BytesIO(raw), allow_pickle=False) as file:
            if int(file["form"]) != FORM:
                raise ValueError("another form")
            origin, turn, cell, low, high = (
                file[key].astype(float) for key in ("origin", "turn", "cell", "low", "high")
            )
            if low.ndim != 3 or low.shape != high.shape or np.isnan(low).any() or np.isnan(high).any():
                raise ValueError("rays without ends")
            if not (np.isfinite([*origin.ravel(), turn, *cell.ravel()]).all() and (cell > 0).all()):
                raise ValueError("rays without places")
            return Dexels(
                origin.reshape(3), float(turn), cell.reshape(2), np.ascontiguousarray(low), np.ascontiguousarray(high)
            )
    except _DAMAGES:
        text = f"{name}: not a stock file; expected a file of --stock-left, or an STL file"
        raise make_input_error("VP506", text) from None


def _count_rays(size: Array, cell: float) -> tuple[int, int]:
    """Rays along x and y: as asked for, or as many as there may be."""
    cell = max(cell, float(np.sqrt(size[0] * size[1] / MOST_RAYS)))
    x, y = np.maximum(np.round(size / cell), 1).astype(int).tolist()
    return x, y


def cross_mesh(corner: Array, counts: tuple[int, int]) -> tuple[Ints, Array, Ints]:
    """Crossings of rays with triangles (n, 3, 3), x and y in cells: ray number, z, and 1 entering or -1 leaving."""
    x, y = ((corner[..., k] - 0.5 - ASIDE[k]).T for k in range(2))  # (3, n), ray i is at x = i
    area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0])
    first = np.maximum(np.ceil(x.min(axis=0)), 0).astype(int)
    last = np.minimum(np.floor(x.max(axis=0)), counts[0] - 1).astype(int)
    owner, i = number_parts(np.where(area != 0, np.maximum(last - first + 1, 0), 0))
    i += first[owner]
    first, last = _find_rows(x[:, owner], y[:, owner], i, counts[1])
    column, j = number_parts(np.maximum(last - first + 1, 0))
    owner, i, j = owner[column], i[column], j + first[column]
    # one column after the other: rows of two and three numbers take four times as long
    dx, dy = [one[owner] - i for one in x], [one[owner] - j for one in y]
    turned = area[owner]
    weight = [(dx[k - 2] * dy[k - 1] - dy[k - 2] * dx[k - 1]) / turned for k in range(3)]
    inside = (weight[0] >= 0) & (weight[1] >= 0) & (weight[2] >= 0)
    owner, i, j = owner[inside], i[inside], j[inside]
    z = sum(weight[k][inside] * corner[owner, k, 2] for k in range(3))
    return i * counts[1] + j, z, np.where(area[owner] < 0, 1, -1)


def _find_rows(x: Array, y: Array, i: Ints, rows: int) -> tuple[Ints, Ints]:
    """First and last rays (n,) of columns ``i`` that triangles (3, n) may meet, and one more each for rounding."""
    low, high = np.full(len(i), np.inf), np.full(len(i), -np.inf)
    for k in range(3):
        wide = x[k] - x[k - 1]
        steep = np.abs(wide) < _STEEP
        way = (i - x[k - 1]) / np.where(steep, 1.0, wide) * (y[k] - y[k - 1])
        ends = [np.where(steep, y[k - 1 + n], y[k - 1] + way) for n in range(2)]
        meets = (np.minimum(x[k - 1], x[k]) <= i) & (i <= np.maximum(x[k - 1], x[k]))
        low = np.where(meets, np.minimum(low, np.minimum(*ends)), low)
        high = np.where(meets, np.maximum(high, np.maximum(*ends)), high)
    return np.maximum(np.ceil(low) - 1, 0).astype(int), np.minimum(np.floor(high) + 1, rows - 1).astype(int)
