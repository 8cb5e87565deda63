"""Rows on disk while a conversion goes on: written once, read as often as a format needs, never all in memory."""

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from verne_post.model.machine import Column
from verne_post.model.setpoints import SetpointBlock, SetpointFormat

Array = NDArray[np.float64]

#: Rows handed to a writer at a time.
CHUNK_ROWS = 8192


@dataclass(frozen=True, eq=False)
class WrittenRows:
    """All rows of one file: numbers as they are to be written (n, n_joints) and source lines (n,); both may lie on disk.

    Row k stands at k cycles.
    """

    numbers: Array
    line: NDArray[np.int32]
    columns: tuple[Column, ...]
    format: SetpointFormat

    def blocks(self) -> Iterator[SetpointBlock]:
        """The rows block by block; only ``written`` of the blocks means anything."""
        for first in range(0, len(self.numbers), CHUNK_ROWS):
            part = slice(first, first + CHUNK_ROWS)
            numbers = np.array(self.numbers[part])
            yield SetpointBlock(first, numbers, np.array(self.line[part]), self.format, numbers)

    def part(self, first: int, last: int) -> "WrittenRows":
        """Rows ``first`` to ``last``, both included, as a file of its own."""
        return replace(self, numbers=self.numbers[first : last + 1], line=self.line[first : last + 1])


class Spool:
    """Takes blocks, and gives them back as rows; use it as a context."""

    def __init__(self, columns: tuple[Column, ...]) -> None:
        self.columns = columns
        self.format: SetpointFormat | None = None
        self.n_rows = 0

    def __enter__(self) -> "Spool":
        self._numbers = tempfile.TemporaryFile()
        self._line = tempfile.TemporaryFile()
        return self

    def __exit__(self, *_error: Any) -> None:
        self._numbers.close()
        self._line.close()

    def take(self, block: SetpointBlock) -> None:
        """The next rows."""
        self.format = block.format
        self._numbers.write(np.ascontiguousarray(block.written, dtype=np.float64).tobytes())
        self._line.write(np.ascontiguousarray(block.line, dtype=np.int32).tobytes())
        self.n_rows += len(block.line)

    def rows(self) -> WrittenRows:
        """Everything that was taken."""
        assert self.format is not None
        self._numbers.flush()
        self._line.flush()
        shape = (self.n_rows, len(self.columns))
        numbers: Any = np.memmap(self._numbers, np.float64, "r", shape=shape)
        line: Any = np.memmap(self._line, np.int32, "r", shape=shape[:1])
        return WrittenRows(numbers, line, self.columns, self.format)
