"""The default: comma separated, with a header."""

import io
from collections.abc import Iterator
from typing import IO, Final

from verne_post.model.setpoints import SetpointBlock
from verne_post.output.expected import Expected
from verne_post.output.file_format import FileFormat
from verne_post.output.setpoints import read_csv, write_csv_header, write_csv_rows
from verne_post.output.spool import WrittenRows


def write(rows: WrittenRows) -> Iterator[bytes]:
    """Write the header, then the rows."""
    yield write_csv_header(rows.columns, rows.format.drives).encode()
    yield from (write_csv_rows(block).encode() for block in rows.iterate_blocks())


def read(stream: IO[bytes], expected: Expected) -> Iterator[SetpointBlock]:
    """Read rows with their header."""
    with io.TextIOWrapper(stream, encoding="utf-8-sig") as text:
        yield from read_csv(text, expected)


FORMAT: Final = FileFormat(write, ".csv", WrittenRows.name_columns, has_undriven=True, read=read)
