"""Program texts of any length: bytes in memory, or in a temporary file and read like bytes."""

import hashlib
import mmap
from collections.abc import Iterator
from typing import IO, Final

from verne_post.base.columns import map_columns, release_memory

#: So many bytes are looked at together.
_CHUNK: Final = 1 << 20


class LongText(mmap.mmap):
    """A mapped file with the methods of ``bytes`` that readers of programs need and maps lack."""

    def count(self, byte: bytes, start: int = 0, end: int | None = None) -> int:
        """Count one byte in a stretch."""
        return sum(part.count(byte) for part in iterate_parts(self, start, end))

    def index(self, part: bytes) -> int:
        """Position of the first occurrence of a part, which must occur."""
        at = self.find(part)
        if at < 0:
            raise ValueError(f"{part!r} does not occur")
        return at

    def startswith(self, part: bytes) -> bool:
        """Whether the text begins with a part."""
        return self[: len(part)] == part

    def endswith(self, part: bytes) -> bool:
        """Whether the text ends with a part."""
        return self[-len(part) :] == part


#: The text of a program.
Text = bytes | LongText


def iterate_parts(text: Text, start: int = 0, end: int | None = None) -> Iterator[bytes]:
    """A stretch of a text in parts; memory of a mapped file is released after each."""
    last = len(text) if end is None else min(end, len(text))
    for at in range(start, last, _CHUNK):
        yield text[at : min(at + _CHUNK, last)]
        release_memory()


def count_line(text: Text, at: int) -> int:
    """Number of the line, from 1 on, in which the byte ``at`` of a text stands."""
    return text.count(b"\n", 0, at) + 1


def iterate_lines(text: Text) -> Iterator[bytes]:
    """Lines of a text without their ends, as splitting it gives them, but one by one."""
    begun: list[bytes] = []
    for part in iterate_parts(text):
        head, end, rest = part.partition(b"\n")
        begun.append(head)
        if end:
            yield b"".join(begun)
            *lines, last = rest.split(b"\n")
            yield from lines
            begun = [last]
    yield b"".join(begun)


def decode_lines(text: Text) -> Iterator[str]:
    """The same as characters; bytes that are no UTF-8 are replaced."""
    return (line.decode("utf-8", errors="replace") for line in iterate_lines(text))


def compute_sha256(text: Text) -> str:
    """SHA-256 of a text, in hexadecimal."""
    digest = hashlib.sha256()
    for part in iterate_parts(text):
        digest.update(part)
    return digest.hexdigest()


def map_text(file: IO[bytes]) -> LongText:
    """Map the text of a file that nobody else changes."""
    return map_columns(file, LongText)


def take_line(text: Text, number: int) -> bytes | None:
    """Line ``number``, 1-based, without its end; None after the last one."""
    start, left = 0, number - 1
    while left:
        part = text[start : start + _CHUNK]
        here = part.count(b"\n")
        if here >= left:
            start += len(part) - len(part.split(b"\n", left)[-1])
            break
        start, left = start + len(part), left - here
        if start >= len(text):
            return None
    end = text.find(b"\n", start)
    return text[start : len(text) if end < 0 else end]
