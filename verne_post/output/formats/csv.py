"""The default: comma separated, with a header."""

from collections.abc import Iterator
from typing import Final

from verne_post.output.file_format import FileFormat
from verne_post.output.setpoints import write_csv_header, write_csv_rows
from verne_post.output.spool import WrittenRows


def write(rows: WrittenRows) -> Iterator[bytes]:
    """Write what ``verify`` reads."""
    yield write_csv_header(rows.columns, rows.format.drives).encode()
    yield from (write_csv_rows(block).encode() for block in rows.iterate_blocks())


FORMAT: Final = FileFormat(write, ".csv", WrittenRows.name_columns, has_undriven=True)
