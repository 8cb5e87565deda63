"""The rows of a conversion until it has passed: on disk, read as often as a format needs, never all in memory."""

from collections.abc import Iterator, Mapping

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.base.columns import GrowingTable, iterate_blocks
from verne_post.model.machine import Column
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.output.setpoints import name_columns, name_joints

#: Rows handed to a writer at a time.
CHUNK_ROWS = 8192


class WrittenRows(Struct, frozen=True, eq=False):
    """All rows of one file: numbers as they are to be written (n, n_joints) and source lines (n,).

    Row k stands at k cycles. ``about`` says what they were made of, for formats that have a place for it.
    """

    numbers: Array
    line: NDArray[np.int32]
    columns: tuple[Column, ...]
    format: SetpointFormat
    about: Mapping[str, str] = field(default_factory=dict)

    def iterate_blocks(self) -> Iterator[SetpointBlock]:
        """The rows block by block; only ``written`` of the blocks means anything."""
        for begin, end in iterate_blocks(len(self.numbers)):
            for first in range(begin, end, CHUNK_ROWS):
                part = slice(first, min(first + CHUNK_ROWS, end))
                numbers = np.array(self.numbers[part])
                yield SetpointBlock(first, numbers, np.array(self.line[part]), self.format, numbers)

    def take_part(self, first: int, last: int) -> "WrittenRows":
        """Rows ``first`` to ``last``, both included, as a file of its own."""
        return replace(self, numbers=self.numbers[first : last + 1], line=self.line[first : last + 1])

    def name_joints(self) -> tuple[str, ...]:
        """Names of the columns of the joints, with what their numbers are."""
        return name_joints(self.columns, self.format.drives)

    def name_columns(self) -> tuple[str, ...]:
        """The same with time and source line, as CSV has them."""
        return name_columns(self.columns, self.format.drives)

    def take_driven(self) -> "WrittenRows":
        """The same rows without the columns that no drive follows, which are the last ones."""
        joints = tuple(column for column in self.columns if column.driven)
        count = len(joints)
        assert self.columns[:count] == joints
        rounded = replace(self.format, decimals=self.format.decimals[:count], drives=self.format.drives[:count])
        return replace(self, numbers=self.numbers[:, :count], columns=joints, format=rounded)


class Spool:
    """Collects blocks, and gives them back as rows."""

    def __init__(self, columns: tuple[Column, ...]) -> None:
        self.columns = columns
        self.format: SetpointFormat | None = None
        self._rows = GrowingTable(numbers=(float, len(columns)), line=(np.int32,))

    def take(self, block: SetpointBlock) -> None:
        """Append the next rows."""
        self.format = block.format
        self._rows.extend(numbers=block.written, line=block.line)

    def collect_rows(self) -> WrittenRows:
        """All rows that were collected."""
        assert self.format is not None
        return WrittenRows(**self._rows.freeze(), columns=self.columns, format=self.format)
