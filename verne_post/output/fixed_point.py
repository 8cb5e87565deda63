"""Columns of numbers with fixed decimals as lines of text: the bytes of ``%.{decimals}f``, in a fifth of its time.

Setpoints have been rounded to their decimals, so each is a whole number of units of the last one. Whole-number division
finds its digits for a column at a time. Other columns take Python's own formatting.
"""

from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Mask

#: A number rounded to its decimals, times their power of ten, is off the whole number by less than this share: two
#: roundings to a double, and one for a multiple that is no double itself.
NOISE: Final = 2.0**-51
#: Below this the noise is less than a quarter of a unit: the digits are those of the whole number.
EXACT: Final = 2.0**49
_ZERO, _MINUS, _POINT = b"0-."


def format_rows(table: Iterable[NDArray[Any]], decimals: Sequence[int], separator: str) -> str:
    """Lines of numbers, one of each column (n,) of the table with that column's decimals."""
    columns = [np.asarray(column, dtype=float) for column in table]
    ends = [*separator * (len(columns) - 1), "\n"]
    cells = [_make_cells(column, places, end) for column, places, end in zip(columns, decimals, ends, strict=True)]
    exact = [cell for cell in cells if cell is not None]
    if len(exact) < len(cells):
        line = separator.join(f"%.{places}f" for places in decimals) + "\n"
        return (line * len(columns[0])) % tuple(np.column_stack(columns).ravel().tolist())
    text, shown = (np.concatenate(parts, axis=1) for parts in zip(*exact, strict=True))
    return text[shown].tobytes().decode("ascii")


def _make_cells(numbers: Array, decimals: int, end: str) -> tuple[NDArray[np.uint8], Mask] | None:
    """Characters of a right-aligned column, and which are shown, (n, width); None for numbers that are not whole."""
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = numbers * 10.0**decimals
        whole = np.rint(scaled)
        size = np.abs(whole)
        # written so that NaN counts as not whole
        if not bool((np.abs(scaled - whole) <= NOISE * size).all() and (size < EXACT).all()):
            return None
    left = size.astype(np.int64)
    digits = max(len(str(left.max(initial=0))), decimals + 1)
    text = np.empty((len(numbers), 1 + digits + (decimals > 0) + 1), np.uint8)
    shown = np.ones(text.shape, np.bool_)
    text[:, 0], shown[:, 0] = _MINUS, np.signbit(numbers)
    text[:, -1] = ord(end)
    place = text.shape[1] - 2
    for digit in range(digits):
        if digit == decimals and decimals:
            text[:, place] = _POINT
            place -= 1
        if digit > decimals:
            shown[:, place] = left > 0
        rest = left // 10
        text[:, place] = left - 10 * rest + _ZERO
        left, place = rest, place - 1
    return text, shown
