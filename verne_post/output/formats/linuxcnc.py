"""For LinuxCNC's halstreamer: the joints alone, separated by blanks, a line a cycle, no header."""

from collections.abc import Iterator
from typing import Final

from verne_post.output.file_format import FileFormat
from verne_post.output.fixed_point import format_rows
from verne_post.output.spool import WrittenRows


def write(rows: WrittenRows) -> Iterator[bytes]:
    """Write fixed-point text."""
    return (format_rows(block.written.T, rows.format.decimals, " ").encode() for block in rows.iterate_blocks())


FORMAT: Final = FileFormat(write, ".txt", WrittenRows.name_joints)
