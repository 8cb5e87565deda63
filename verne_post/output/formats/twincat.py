"""For TwinCAT and other readers of raw tables: the joints as little-endian float64, row after row, nothing else."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.output.file_format import FileFormat
from verne_post.output.spool import WrittenRows


def write(rows: WrittenRows) -> Iterator[bytes]:
    """Write raw float64."""
    for block in rows.iterate_blocks():
        yield np.ascontiguousarray(block.written, dtype="<f8").tobytes()


FORMAT: Final = FileFormat(write, ".bin", WrittenRows.name_joints)
