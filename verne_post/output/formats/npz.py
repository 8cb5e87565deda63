"""Numpy's archive: t, values, line; columns names those of values, about is JSON: what the rows were made of."""

import io
import json
from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.output.file_format import FileFormat
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


def name_columns(rows: WrittenRows) -> tuple[str, ...]:
    """The array ``t``, the columns of ``values``, the array ``line``."""
    return ("t", *rows.name_joints(), "line")


FORMAT: Final = FileFormat(write, ".npz", name_columns, has_undriven=True)
