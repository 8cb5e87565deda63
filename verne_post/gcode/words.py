"""Bytes -> words, vectorised: the fast reader for plain blocks.

A *plain* block consists of letters followed by decimal numbers, blanks, and comments without a message. Anything
else (messages, parameters, expressions, damaged numbers) is left to :mod:`verne_post.gcode.block`, which reads one
block exactly; both obey one contract, and numbers are bit-identical to ``float()``.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Mask
from verne_post.base.columns import release_memory
from verne_post.base.long_text import Text

#: Bytes read at a time: the intermediate arrays then stay in the processor's cache.
CHUNK_BYTES: Final = 1 << 18
#: A mantissa of at most 15 digits and a power of ten up to 1e15 are exact doubles, and IEEE division
#: of exact operands is correctly rounded, as ``float()`` is. Longer numbers go to the exact reader.
MAX_DIGITS: Final = 15

_BLANK, _DIGIT, _DOT, _SIGN, _LETTER, _NEWLINE, _COMMENT, _OTHER = range(8)
#: Stands for a comment without a message: no word may contain it.
_MARK: Final = b"\x01"
_SILENT: Final = re.compile(rb"\((?![ \t]*(?:MSG|DEBUG|PRINT|LOG|ABORT|PROBE))[^()\n]*\)|;[^\n]*", re.IGNORECASE)


def _make_classes() -> NDArray[np.uint8]:
    table = np.full(256, _OTHER, dtype=np.uint8)
    for characters, kind in ((b" \t\r", _BLANK), (b"0123456789", _DIGIT), (b".", _DOT), (b"+-", _SIGN),
                             (b"\n", _NEWLINE), (_MARK, _COMMENT)):  # fmt: skip
        table[list(characters)] = kind
    letters = b"ABCDEFGHIJKLMNOPQRSTUVWXYZ"
    table[list(letters)] = _LETTER
    table[list(letters.lower())] = _LETTER
    return table


_CLASS: Final = _make_classes()
_POWER: Final = np.array([float(10**k) for k in range(MAX_DIGITS + 1)])


@dataclass(frozen=True)
class WordTable:
    """Words of consecutive source lines.

    Attributes
    ----------
    first_line : int
        1-based number of the first line.
    text : bytes
        The lines themselves.
    letter : ndarray of uint8, shape (w,)
        Upper-case letter codes, in source order.
    value : ndarray, shape (w,)
    row : ndarray of intp, shape (w,)
        Line of each word, from 0.
    plain : ndarray of bool, shape (n_lines,)
        False for lines that only the exact reader can read; their words are not in the table.
    """

    first_line: int
    text: bytes
    n_lines: int
    letter: NDArray[np.uint8]
    value: Array
    row: NDArray[np.intp]
    plain: Mask


def whole_lines(source: Text, start: int = 0) -> Iterator[bytes]:
    """A text in chunks of whole lines, from an offset on; what was read of a file is released after each chunk."""
    while start < len(source):
        end = chunk_end(source, start)
        yield source[start:end]
        release_memory()
        start = end


def chunk_end(source: Text, start: int) -> int:
    """Where the chunk of whole lines that begins at ``start`` ends."""
    if start + CHUNK_BYTES >= len(source):
        return len(source)
    end = source.rfind(b"\n", start, start + CHUNK_BYTES) + 1
    return end or source.find(b"\n", start) + 1 or len(source)


def split_words(first_line: int, text: bytes) -> WordTable:
    """Split plain lines into words.

    Parameters
    ----------
    first_line : int
        1-based number of the first line of ``text``.
    text : bytes
        Whole lines.
    """
    n_lines = text.count(b"\n") + (not text.endswith(b"\n"))
    read = text if text.endswith(b"\n") else text + b"\n"
    if _MARK in read:  # no program has it; if one does, it is no comment
        read = read.replace(_MARK, b"?")
    raw = np.frombuffer(read, dtype=np.uint8)
    if b"(" in read or b";" in read:
        begins = np.flatnonzero((raw == ord("(")) | (raw == ord(";")))
        read = _mark_comments(read, begins.tolist())
        raw = np.frombuffer(read, dtype=np.uint8)
    kinds = _CLASS[raw]
    solid = kinds != _BLANK
    characters, kinds = raw[solid], kinds[solid]
    starts = np.flatnonzero(kinds >= _LETTER)
    kind = kinds[starts]
    length = np.diff(starts, append=len(characters)) - 1
    newline = kind == _NEWLINE
    row = np.cumsum(newline) - newline
    plain = np.ones(n_lines, dtype=bool)
    if starts[0] > 0:  # digits before the first letter
        plain[0] = False
    # digits before the first letter of a line or after a comment, or a character that no plain word has
    stray = newline & (length > 0)
    plain[np.minimum(row[stray] + 1, n_lines - 1)] = False
    plain[row[(kind == _COMMENT) & (length > 0)]] = False
    plain[row[kind == _OTHER]] = False

    is_word = kind == _LETTER
    begin, length, row = starts[is_word] + 1, length[is_word], row[is_word]
    letter = characters[starts[is_word]] & 0xDF
    value, good = _read_numbers(characters, begin, length)
    plain[row[~good]] = False
    keep = plain[row]
    return WordTable(first_line, text, n_lines, letter[keep], value[keep], row[keep], plain)


def _mark_comments(text: bytes, begins: list[int]) -> bytes:
    """Put a mark in place of each comment without a message; ``begins`` are all places of ``(`` and ``;``."""
    kept, end = [], 0
    for begin in begins:
        if begin >= end and (match := _SILENT.match(text, begin)) is not None:
            kept.append(text[end:begin])
            end = match.end()
    kept.append(text[end:])
    return _MARK.join(kept)


def _read_numbers(
    characters: NDArray[np.uint8], begin: NDArray[np.intp], length: NDArray[np.intp]
) -> tuple[Array, Mask]:
    """Values of the numbers at ``begin``; False where a number is not plain."""
    padded = np.append(characters, np.uint8(0))
    first = padded[begin]
    signed = ((first == ord("-")) | (first == ord("+"))) & (length > 0)
    body = length - signed
    # one sign, MAX_DIGITS digits and a point are the most that is read here
    good = (body > 0) & (body <= MAX_DIGITS + 1)
    body = np.where(good, body, 0)
    # words in order of length: those that have a character at place j are one slice
    order = np.argsort(body.astype(np.uint8), kind="stable")
    at = (begin + signed)[order]
    begins = np.searchsorted(body[order], np.arange(1, MAX_DIGITS + 2))
    n = len(at)
    mantissa = np.zeros(n, dtype=np.int64)
    decimals = np.zeros(n, dtype=np.int8)
    points = np.zeros(n, dtype=np.int8)
    strange = np.zeros(n, dtype=bool)
    for place, low in enumerate(begins):
        if low == n:
            break
        longer = slice(int(low), None)
        character = padded[at[longer] + place]
        digit = character - np.uint8(48)
        is_digit = digit < 10
        if is_digit.all():
            mantissa[longer] = mantissa[longer] * 10 + digit
            decimals[longer] += points[longer]
        else:
            mantissa[longer] = np.where(is_digit, mantissa[longer] * 10 + digit, mantissa[longer])
            decimals[longer] += points[longer] * is_digit
            is_point = character == ord(".")
            points[longer] += is_point
            strange[longer] |= ~(is_digit | is_point)
    usable = ~strange & (points <= 1) & (body[order] - points >= 1) & (body[order] - points <= MAX_DIGITS)
    magnitude = mantissa / _POWER[np.minimum(decimals, MAX_DIGITS)]
    value = np.empty(n)
    value[order] = magnitude
    good[order] &= usable
    return np.where(first == ord("-"), -value, value), good
