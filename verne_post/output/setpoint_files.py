"""Setpoint files of any format, read: the format is recognized by the first bytes."""

import tempfile
from collections.abc import Iterator
from shutil import copyfileobj
from typing import IO

from verne_post.base.text_marks import is_utf16
from verne_post.model.findings import make_input_error
from verne_post.model.setpoints import SetpointBlock
from verne_post.output.expected import Expected
from verne_post.output.file_format import HEAD_BYTES
from verne_post.output.formats import FORMATS
from verne_post.output.formats.csv import FORMAT as DEFAULT


def read_setpoints(stream: IO[bytes], expected: Expected) -> Iterator[SetpointBlock]:
    """Read a setpoint file block by block. One from a pipe is copied to a temporary file.

    Raises
    ------
    InputError
        VP020: wrong columns, something that is not a number, a row out of time, a format without all rows.
    """
    if not stream.seekable():
        with tempfile.TemporaryFile() as copy:
            copyfileobj(stream, copy)
            copy.seek(0)
            yield from read_setpoints(copy, expected)
        return
    start = stream.tell()
    head = stream.read(HEAD_BYTES)
    stream.seek(start)
    formats = () if is_utf16(head) else (FORMATS[name] for name in FORMATS)
    found = next((one for one in formats if one.recognize is not None and one.recognize(head, expected)), DEFAULT)
    if found.read is None:
        text = (
            "the file has knots of cubics, and not every row; verify the rows of the same conversion, with --format csv"
        )
        raise make_input_error("VP020", text, file=expected.name)
    yield from found.read(stream, expected)
