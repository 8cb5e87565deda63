"""Numpy's archive: t, values, line; columns names those of values, about is JSON: what the rows were made of."""

import io
import json
from collections.abc import Iterator
from typing import IO, Any, Final
from zipfile import BadZipFile, ZipFile

import numpy as np
from numpy.typing import NDArray

from verne_post.model.findings import make_input_error
from verne_post.model.setpoints import SetpointBlock
from verne_post.output.expected import Expected
from verne_post.output.file_format import FileFormat
from verne_post.output.setpoints import READ_ROWS, check_names, name_joints, read_exact_blocks
from verne_post.output.spool import WrittenRows


def write(rows: WrittenRows) -> Iterator[bytes]:
    """Write one archive, not compressed."""
    buffer = io.BytesIO()
    np.savez(
        buffer,
        t=rows.format.cycle * np.arange(len(rows.line), dtype=np.float64),
        values=rows.numbers,
        line=rows.line,
        columns=np.array(rows.name_joints()),
        about=np.array(json.dumps(dict(rows.about), allow_nan=False)),
    )
    yield buffer.getvalue()


def read(stream: IO[bytes], expected: Expected) -> Iterator[SetpointBlock]:
    """Read the arrays side by side, never whole."""
    try:
        with ZipFile(stream) as archive:
            with archive.open("columns.npy") as member:
                names = np.lib.format.read_array(member, allow_pickle=False).tolist()
            check_names(names, name_joints(expected.columns, expected.drives), expected.name)
            with archive.open("t.npy") as t, archive.open("values.npy") as values, archive.open("line.npy") as line:
                tables = zip(*(_take_rows(member) for member in (values, t, line)), strict=True)
                yield from read_exact_blocks(tables, expected)
    except (BadZipFile, KeyError, ValueError, EOFError, TypeError) as error:
        text = f"no archive with t, values, line and columns, as --format npz writes: {error}"
        raise make_input_error("VP020", text, file=expected.name) from None


def _take_rows(member: IO[bytes]) -> Iterator[NDArray[Any]]:
    """Rows of an array in an archive, in parts."""
    version = np.lib.format.read_magic(member)
    read_header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, by_columns, dtype = read_header(member)
    if dtype.kind not in "fiu" or (by_columns and len(shape) > 1) or not shape:
        raise ValueError("an array is of another kind")
    width = int(np.prod(shape[1:]))
    for first in range(0, shape[0], READ_ROWS):
        count = min(READ_ROWS, shape[0] - first)
        raw = member.read(count * width * dtype.itemsize)
        yield np.frombuffer(raw, dtype=dtype).reshape(count, *shape[1:])


def recognize(head: bytes, expected: Expected) -> bool:
    """An archive."""
    return head.startswith(b"PK\3\4")


def name_columns(rows: WrittenRows) -> tuple[str, ...]:
    """The array ``t``, the columns of ``values``, the array ``line``."""
    return ("t", *rows.name_joints(), "line")


FORMAT: Final = FileFormat(
    write, ".npz", name_columns, has_undriven=True, read=read, recognize=recognize, is_archive=True
)
