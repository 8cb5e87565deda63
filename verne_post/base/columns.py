"""Columns as long as a program: built block by block, in memory while they are short, in temporary files beyond that.

A column is read like any other array. Pages of a file that have been read count as memory of the process until they are
given up (:func:`release_memory`). So programs of any length fit.
"""

import mmap
import tempfile
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, Any, Final, TypeVar

import numpy as np
from numpy.typing import DTypeLike, NDArray

#: Rows that are worked on together, of any table: temporary arrays have no more.
BLOCK_ROWS: Final = 1 << 16
#: A column of more bytes goes to a file; some forty are held at a time.
IN_MEMORY: Final = 1 << 21

_Map = TypeVar("_Map", bound=mmap.mmap)

_MAPS: "weakref.WeakSet[mmap.mmap]" = weakref.WeakSet()


def iterate_blocks(n: int, first: int = 0) -> Iterator[tuple[int, int]]:
    """Begin and end of the blocks of rows ``first`` to ``n``; memory that one has read is released before the next."""
    for begin in range(first, n, BLOCK_ROWS):
        if begin > first:
            release_memory()
        yield begin, min(begin + BLOCK_ROWS, n)


def release_memory() -> None:
    """Give back the memory of everything that was read from files; it is read again where it is needed."""
    for each in tuple(_MAPS):
        if hasattr(each, "madvise"):
            each.madvise(mmap.MADV_DONTNEED)


def map_columns(file: IO[bytes], kind: type[_Map]) -> _Map:
    """Map a file for reading; it may be closed then. :func:`release_memory` releases its pages."""
    whole = kind(file.fileno(), 0, access=mmap.ACCESS_READ)
    _MAPS.add(whole)
    return whole


def sum_running(values: NDArray[Any]) -> NDArray[Any]:
    """Sums (n + 1,) of the first 0, 1, 2, ... of values (n,); how many there are, of flags."""
    sums = Growing(float if values.dtype.kind == "f" else np.int64)
    last = np.zeros(1, sums.dtype)
    sums.extend(last)
    for first, end in iterate_blocks(len(values)):
        block = np.cumsum(np.append(last, values[first:end]))[1:]
        sums.extend(block)
        last = block[-1:]
    return sums.freeze()


@contextmanager
def name_storage_errors() -> Iterator[None]:
    """Name the folder of temporary files in errors: the files have no name."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, tempfile.gettempdir()) from None


class Growing:
    """A column to which blocks are added at the end.

    Parameters
    ----------
    dtype :
    width : int
        Shape of a row.

    Raises
    ------
    OSError
        When rows are added and the folder of temporary files, which the error names, is full.
    """

    def __init__(self, dtype: DTypeLike, *width: int) -> None:
        self.dtype, self.width = np.dtype(dtype), width
        self.count = 0
        self._blocks: list[NDArray[Any]] = []
        self._held = 0
        self._file: IO[bytes] | None = None
        #: The row (1, *width) that all rows repeat so far; None once another was added.
        self._repeated: NDArray[Any] | None = None

    def extend(self, rows: NDArray[Any]) -> None:
        """Add rows (m, *width), which are copied or must not be changed any more.

        While all rows are one that numpy has broadcast, they need no memory.
        """
        if len(rows) > 1 and rows.strides[0] == 0 and self._repeat(np.array(rows[:1], dtype=self.dtype), len(rows)):
            return
        if self._repeated is not None:
            before, count = self._repeated, self.count
            self._repeated, self.count = None, 0
            for first, last in iterate_blocks(count):
                self._add(before.repeat(last - first, axis=0))
        self._add(np.ascontiguousarray(rows, dtype=self.dtype))

    def _repeat(self, row: NDArray[Any], count: int) -> bool:
        """Add a row (1, *width) ``count`` times if it is the only one; False where others came before."""
        if not self.count:
            self._repeated = row
        elif self._repeated is None or row.tobytes() != self._repeated.tobytes():
            return False
        self.count += count
        return True

    def _add(self, block: NDArray[Any]) -> None:
        if not len(block):
            return
        self.count += len(block)
        self._blocks.append(block)
        self._held += block.nbytes
        if self._held > IN_MEMORY:
            self._write()

    def _write(self) -> None:
        with name_storage_errors():
            if self._file is None:
                self._file = tempfile.TemporaryFile()  # noqa: SIM115 - open until the column is whole or deleted
                weakref.finalize(self, self._file.close)
            for block in self._blocks:
                self._file.write(block.data.cast("B"))
            self._file.flush()
        self._blocks, self._held = [], 0
        release_memory()  # what has been read to make them

    def copy(self, rows: NDArray[Any], before: int = 0, after: int = 0) -> None:
        """Add rows (m, *width) of another column; the first is repeated ``before`` them, the last ``after`` them."""
        self.extend(rows[:1].repeat(before, axis=0))
        for first, last in iterate_blocks(len(rows)):
            self.extend(rows[first:last])
        self.extend(rows[-1:].repeat(after, axis=0))

    def freeze(self) -> NDArray[Any]:
        """Return all rows (count, *width), not to be changed; none can be added any more."""
        shape = (self.count, *self.width)
        if self._repeated is not None:
            return np.broadcast_to(self._repeated, shape)
        if self._file is None:
            if not self._blocks:
                return np.empty(shape, self.dtype)
            return self._blocks[0] if len(self._blocks) == 1 else np.concatenate(self._blocks)
        self._write()
        whole = map_columns(self._file, mmap.mmap)
        self._file.close()
        return np.frombuffer(whole, self.dtype).reshape(shape)


class GrowingTable:
    """Columns of the same length by name, each given as (dtype, *width)."""

    def __init__(self, **columns: tuple[Any, ...]) -> None:
        self._columns = {name: Growing(*layout) for name, layout in columns.items()}

    def extend(self, **rows: NDArray[Any]) -> None:
        """Add a block to every column."""
        parts = [rows[name] for name in self._columns]
        for column, part in zip(self._columns.values(), parts, strict=True):
            column.extend(part)

    def freeze(self) -> dict[str, Any]:
        """Return all columns, whole."""
        return {name: column.freeze() for name, column in self._columns.items()}
