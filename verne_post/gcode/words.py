"""Bytes -> words, vectorised: the fast reader for plain blocks.

A *plain* block consists of letters followed by decimal numbers, blanks, and comments without a message. Anything
else (messages, parameters, expressions, damaged numbers) is left to :mod:`verne_post.gcode.block`, which reads one
block exactly; both obey one contract, and numbers are bit-identical to ``float()``.
"""

import re
import string
from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import release_memory
from verne_post.base.long_text import Text

#: Bytes read at a time: the intermediate arrays then stay in the processor's cache.
CHUNK_BYTES: Final = 1 << 18
#: Bytes of the first chunk: where a program starts is found by executing its opening lines several times.
OPENING_BYTES: Final = 1 << 12
#: Chunks after it are so many times as long as all before them, up to ``CHUNK_BYTES``.
GROWTH: Final = 8
#: A mantissa of at most 15 digits and a power of ten up to 1e15 are exact doubles, and IEEE division
#: of exact operands is correctly rounded, as ``float()`` is. Longer numbers go to the exact reader.
MAX_DIGITS: Final = 15

_DIGIT, _SIGN, _POINT, _LETTER, _NEWLINE, _COMMENT, _OTHER = range(7)
_BLANKS: Final = b" \t\r"
#: No plain word has this character.
_STRANGE: Final = ord("?")
#: Stands for a comment without a message: no word may contain it.
_MARK: Final = b"\x01"
_SILENT: Final = re.compile(rb"\((?![ \t]*(?:MSG|DEBUG|PRINT|LOG|ABORT|PROBE))[^()\n]*\)|;[^\n]*", re.IGNORECASE)


def _make_classes() -> bytes:
    table = bytearray([_OTHER]) * 256
    for characters, kind in (
        (b"0123456789", _DIGIT),
        (b".", _POINT),
        (b"+-", _SIGN),
        (b"\n", _NEWLINE),
        (_MARK, _COMMENT),
        (string.ascii_letters.encode(), _LETTER),
    ):
        for character in characters:
            table[character] = kind
    return bytes(table)


_CLASS: Final = _make_classes()
_IS_BLANK: Final = np.isin(np.arange(256), list(_BLANKS))
_IS_DIGIT: Final = np.isin(np.arange(256), list(b"0123456789."))
_POWER: Final = np.array([float(10**k) for k in range(MAX_DIGITS + 1)])
#: Eight characters are read as one number of 64 bits, the first of them in the lowest byte.
_WINDOW: Final = 8
_ZEROS: Final = np.uint64(int.from_bytes(b"0" * _WINDOW, "little"))
#: Keeps the last n characters of a window, n = 0 to 8.
_LAST: Final = np.array([(1 << 64) - (1 << 8 * (_WINDOW - n)) for n in range(_WINDOW + 1)], dtype=np.uint64)
#: A byte above 9 has its highest bit set by this sum, if it has not had it before.
_TO_HIGH_BIT: Final = np.uint64(0x76 * 0x0101010101010101)
_HIGH_BITS: Final = np.uint64(0x80 * 0x0101010101010101)
#: Pairs of digits in bytes 0 and 4, and their factors: 10^6 and 10^2, and two bytes on 10^4 and 1.
_PAIRS: Final = np.uint64(0xFF * 0x0000000100000001)
_ODD_PAIRS: Final = np.uint64((10**6 << 32) + 10**2)
_EVEN_PAIRS: Final = np.uint64((10**4 << 32) + 1)


class WordTable(Struct, frozen=True):
    """Words of consecutive source lines."""

    first_line: int  #: 1-based number of the first line.
    text: bytes  #: The lines themselves.
    n_lines: int
    letter: NDArray[np.uint8]  #: (w,): Upper-case letter codes, in source order.
    value: Array  #: (w,)
    row: NDArray[np.intp]  #: (w,): Line of each word, from 0.
    #: (n_lines,): False for lines that only the exact reader can read; what the table has of their words means
    #: nothing.
    plain: Mask


def read_whole_lines(source: Text, start: int = 0) -> Iterator[bytes]:
    """A text in chunks of whole lines, from an offset on; what was read of a file is released after each chunk."""
    while start < len(source):
        end = find_chunk_end(source, start)
        yield source[start:end]
        release_memory()
        start = end


def find_chunk_end(source: Text, start: int) -> int:
    """The end of the chunk of whole lines from ``start`` on. The first chunks are short, for opening lines alone."""
    size = min(CHUNK_BYTES, max(OPENING_BYTES, GROWTH * start))
    if start + size >= len(source):
        return len(source)
    end = source.rfind(b"\n", start, start + size) + 1
    return end or source.find(b"\n", start) + 1 or len(source)


def count_lines(text: bytes) -> int:
    """How many lines a text has; the last one may lack its end."""
    return int(np.count_nonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n"))) + (not text.endswith(b"\n"))


def mark_blanks_in_numbers(text: bytes) -> bytes:
    """A text in which blanks between two digits are a character that no plain word has.

    :func:`split_words` passes over blanks, as RS274/NGC does; other languages end a number there.
    """
    raw = np.frombuffer(text, dtype=np.uint8)
    blank = np.flatnonzero(_IS_BLANK[raw[1:-1]]) + 1
    after = blank[_IS_DIGIT[raw[blank - 1]]]  # blanks right after a digit
    inside = after[_IS_DIGIT[raw[after + 1]]]
    if _IS_BLANK[raw[after + 1]].any():  # several: what comes after them counts
        solid = np.flatnonzero(~_IS_BLANK[raw])
        at = np.searchsorted(solid, after)
        inside = after[_IS_DIGIT[raw[solid[np.minimum(at, len(solid) - 1)]]]]
    if not len(inside):
        return text
    marked_bytes = raw.copy()
    marked_bytes[inside] = _STRANGE
    return marked_bytes.tobytes()


def split_words(first_line: int, text: bytes) -> WordTable:
    """Split plain lines into words.

    Parameters
    ----------
    first_line : int
        1-based number of the first line of ``text``.
    text : bytes
        Whole lines.
    """
    read = text if text.endswith(b"\n") else text + b"\n"
    if _MARK in read:  # no program has it; if one does, it is no comment
        read = read.replace(_MARK, b"?")
    if b"(" in read or b";" in read:
        raw = np.frombuffer(read, dtype=np.uint8)
        begins = np.flatnonzero((raw == ord("(")) | (raw == ord(";")))
        read = _mark_comments(read, begins.tolist())
    characters = read.translate(None, _BLANKS)
    kinds = np.frombuffer(characters.translate(_CLASS), dtype=np.uint8)
    starts = np.flatnonzero(kinds >= _POINT)
    kind = kinds[starts]
    newline = np.flatnonzero(kind == _NEWLINE)
    n_lines = len(newline)
    plain = np.ones(n_lines, dtype=bool)
    if starts[0] > 0:  # digits before the first letter
        plain[0] = False
    # digits before the first letter of a line or after a comment, or a character that no plain word has
    stray = starts[newline[:-1] + 1] != starts[newline[:-1]] + 1
    plain[1:][stray] = False
    comment = np.flatnonzero(kind == _COMMENT)
    odd = [comment[starts[comment + 1] != starts[comment] + 1], np.flatnonzero(kind == _OTHER)]
    point = np.flatnonzero(kind == _POINT)
    odd.append(point[kind[point - 1] != _LETTER])  # it does not belong to the first number after a letter
    plain[np.searchsorted(newline, np.concatenate(odd))] = False

    word = np.flatnonzero(kind == _LETTER)
    per_line = np.diff(np.searchsorted(word, newline), prepend=0)
    row = np.repeat(np.arange(n_lines), per_line)
    begin = starts[word] + 1
    has_point = kind[word + 1] == _POINT
    end = starts[word + 1]
    value, good = _read_numbers(characters, begin, end, np.where(has_point, starts[word + 1 + has_point] - end - 1, 0))
    plain[row[~good]] = False
    letter = np.frombuffer(characters, dtype=np.uint8)[begin - 1] & np.uint8(0xDF)
    return WordTable(first_line, text, n_lines, letter, value, row, plain)


def _mark_comments(text: bytes, begins: list[int]) -> bytes:
    """Put a mark in place of each comment without a message; ``begins`` are all places of ``(`` and ``;``."""
    kept_comments, end = [], 0
    for begin in begins:
        if begin >= end and (match := _SILENT.match(text, begin)) is not None:
            kept_comments.append(text[end:begin])
            end = match.end()
    kept_comments.append(text[end:])
    return _MARK.join(kept_comments)


def _read_numbers(characters: bytes, begin: Ints, end: Ints, decimals: Ints) -> tuple[Array, Mask]:
    """Values of numbers between ``begin`` and ``end``, then so many ``decimals``; False where one is not plain."""
    text = b"0" * _WINDOW + characters + b"0"
    first = np.frombuffer(text, dtype=np.uint8)[begin + _WINDOW]
    negative = first == ord("-")
    whole = end - begin
    whole -= (negative | (first == ord("+"))) & (whole > 0)
    count = whole + decimals
    good = (count > 0) & (count <= MAX_DIGITS)
    strange = np.flatnonzero(~good)
    whole[strange] = decimals[strange] = 0
    # the eight characters before each place
    windows = np.ndarray((len(text) - _WINDOW,), "<u8", text, strides=(1,))
    above, fine = _read_digits(windows, end, whole)
    below, also = _read_digits(windows, end + 1 + decimals, decimals)
    power = _POWER[decimals]
    value = above * power  # whole numbers below 10^15: exact
    value += below
    value /= power
    np.negative(value, out=value, where=negative)
    return value, good & fine & also


def _read_digits(windows: NDArray[np.uint64], end: Ints, count: Ints) -> tuple[Array, Mask]:
    """The whole numbers of ``count`` digits (at most 15) before ``end``; False where others are among them."""
    number, good = _read_window(windows[end], np.minimum(count, _WINDOW))
    long = np.flatnonzero(count > _WINDOW)
    if len(long):
        higher, fine = _read_window(windows[end[long] - _WINDOW], count[long] - _WINDOW)
        number[long] += higher * _POWER[_WINDOW]
        good[long] &= fine
    return number, good


def _read_window(window: NDArray[np.uint64], count: Ints) -> tuple[Array, Mask]:
    """The numbers that the last ``count`` characters of windows are; False where one of them is no digit."""
    digits = window ^ _ZEROS
    digits &= _LAST[count]
    strange = digits + _TO_HIGH_BIT
    strange |= digits
    strange &= _HIGH_BITS
    good = strange == 0
    pairs = digits * 10  # in every second byte
    pairs += digits >> 8
    others = pairs >> 16
    pairs &= _PAIRS
    pairs *= _ODD_PAIRS
    others &= _PAIRS
    others *= _EVEN_PAIRS
    pairs += others
    pairs >>= 32
    return pairs.view(np.int64).astype(np.float64), good
