"""For LinuxCNC's halstreamer: the joints alone, separated by blanks, a line a cycle, no header."""

import io
from collections.abc import Iterator
from typing import IO, Final

from verne_post.model.setpoints import SetpointBlock
from verne_post.output.expected import Expected
from verne_post.output.file_format import FileFormat
from verne_post.output.fixed_point import format_rows
from verne_post.output.setpoints import is_row, read_exact_blocks, read_tables
from verne_post.output.spool import WrittenRows


def write(rows: WrittenRows) -> Iterator[bytes]:
    """Write fixed-point text."""
    return (format_rows(block.written.T, rows.format.decimals, " ").encode() for block in rows.iterate_blocks())


def read(stream: IO[bytes], expected: Expected) -> Iterator[SetpointBlock]:
    """Read rows of joints; the lines of the program are not in the file."""
    with io.TextIOWrapper(stream, encoding="utf-8-sig") as text:
        tables = read_tables(text, expected.name, None, expected.driven, 0)
        # decimals are those of the numbers: who reads the text and writes it again may pad it with zeros
        yield from read_exact_blocks(((table, None, None) for _first, _lines, table in tables), expected, 0)


def recognize(head: bytes, expected: Expected) -> bool:
    """The first line has numbers between blanks."""
    cells = head.partition(b"\n")[0].decode("utf-8-sig", "replace").split()
    return len(cells) > 1 and is_row(cells)


FORMAT: Final = FileFormat(write, ".txt", WrittenRows.name_joints, read=read, recognize=recognize)
