"""Setpoint files of any format, read: the format is recognized by the first bytes."""

import io
import tempfile
from collections.abc import Iterator
from shutil import copyfileobj
from typing import IO, Any

from verne_post.base.text_marks import NO_TEXT, UTF16, is_utf16
from verne_post.model.findings import make_input_error
from verne_post.model.setpoints import SetpointBlock
from verne_post.output.expected import Expected
from verne_post.output.file_format import HEAD_BYTES
from verne_post.output.formats import FORMATS
from verne_post.output.formats.csv import FORMAT as DEFAULT
from verne_post.output.setpoints import READS


def read_setpoints(stream: IO[bytes], expected: Expected) -> Iterator[SetpointBlock]:
    """Read a setpoint file block by block. An archive from a pipe is copied to a temporary file.

    Raises
    ------
    InputError
        VP020: no setpoints, wrong columns, no number, a row out of time, a format without all rows.
    """
    head = stream.read(HEAD_BYTES)
    formats = () if is_utf16(head) else (FORMATS[name] for name in FORMATS)
    found = next((one for one in formats if one.recognize is not None and one.recognize(head, expected)), DEFAULT)
    if found.read is None:
        text = (
            "the file has knots of cubics, and not every row; verify the rows of the same conversion, with --format csv"
        )
        raise make_input_error("VP020", text, file=expected.name)
    try:
        with _open_whole(stream, head, found.is_archive) as whole:
            yield from found.read(whole, expected)
    except UnicodeDecodeError:
        text = f"the file is {UTF16}" if is_utf16(head) else f"this is no setpoint file: {NO_TEXT}; {READS}"
        raise make_input_error("VP020", text, file=expected.name) from None


def _open_whole(stream: IO[bytes], head: bytes, seeks: bool) -> IO[bytes]:
    """A stream from its begin on, of which ``head`` has been taken."""
    if stream.seekable():
        stream.seek(-len(head), io.SEEK_CUR)
        return stream
    if not seeks:
        return io.BufferedReader(_Joined(head, stream))
    copy = tempfile.TemporaryFile()  # noqa: SIM115 - closed by who reads it
    copy.write(head)
    copyfileobj(stream, copy)
    copy.seek(0)
    return copy


class _Joined(io.RawIOBase):
    """Bytes that were taken from a stream, and the rest of it."""

    def __init__(self, head: bytes, rest: IO[bytes]) -> None:
        self.head, self.rest = head, rest

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        found = self.head[: len(buffer)] or self.rest.read(len(buffer))
        self.head = self.head[len(found) :]
        buffer[: len(found)] = found
        return len(found)
