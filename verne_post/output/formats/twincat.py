"""For TwinCAT and other readers of raw tables: the joints as little-endian float64, row after row, nothing else."""

from collections.abc import Iterator
from typing import IO, Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.model.findings import make_input_error
from verne_post.model.setpoints import SetpointBlock
from verne_post.output.expected import Expected
from verne_post.output.file_format import FileFormat
from verne_post.output.setpoints import READ_ROWS, read_exact_blocks
from verne_post.output.spool import WrittenRows

_BYTES: Final = 8
#: Sizes of numbers that a table may begin with, but for 0. Text, taken as numbers, has others.
_LEAST, _MOST = 1e-13, 1e13
#: Rows of zeros that no program begins with: a standstill of minutes where every joint is at 0.
_MOST_ZEROS: Final = 100_000


def write(rows: WrittenRows) -> Iterator[bytes]:
    """Write raw float64."""
    for block in rows.iterate_blocks():
        yield np.ascontiguousarray(block.written, dtype="<f8").tobytes()


def read(stream: IO[bytes], expected: Expected) -> Iterator[SetpointBlock]:
    """Read rows of joints; the lines of the program are not in the file."""

    def take_tables() -> Iterator[tuple[Array, None, None]]:
        row, zeros = _BYTES * expected.driven, 0
        while raw := stream.read(READ_ROWS * row):
            zeros = -1 if zeros < 0 or any(raw) else zeros + 1
            if zeros * READ_ROWS > _MOST_ZEROS:
                raise make_input_error("VP020", f"the file begins with {_MOST_ZEROS} rows of zeros", file=expected.name)
            if len(raw) % row:
                text = f"the file ends within a row of {expected.driven} numbers of {_BYTES} bytes"
                raise make_input_error("VP020", text, file=expected.name)
            yield np.frombuffer(raw, dtype="<f8").reshape(-1, expected.driven).astype(float), None, None

    return read_exact_blocks(take_tables(), expected)


def recognize(head: bytes, expected: Expected) -> bool:
    """The first row is of numbers that joints may have."""
    size = np.abs(np.frombuffer(head[: len(head) // _BYTES * _BYTES], dtype="<f8")[: expected.driven])
    return len(size) == expected.driven and bool(((size == 0) | ((size >= _LEAST) & (size <= _MOST))).all())


FORMAT: Final = FileFormat(write, ".bin", WrittenRows.name_joints, read=read, recognize=recognize)
