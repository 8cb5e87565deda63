"""Which lines of one version of a program are those of another.

Lines that occur once in both are anchors, as many as stand in the same order in both. From each anchor equal lines are
followed in both directions ("patience diff", Bram Cohen). It takes the time of sorting, whatever the differences.
"""

import re
from bisect import bisect_left
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Final

from msgspec import Struct

#: What a block number is: two versions of a program number the same block differently.
_NUMBER: Final = re.compile(rb"^\s*(?:N\d+\s*|\d+\s+)", re.IGNORECASE)


class Stretch(Struct, frozen=True):
    """Lines of both versions that belong together, counted from 0, ends excluded; one of the sides may have none."""

    same: bool
    first_a: int
    last_a: int
    first_b: int
    last_b: int


def align_lines(a: Sequence[bytes], b: Sequence[bytes]) -> list[Stretch]:
    """Cut two texts into stretches of equal and different lines; block numbers and outer blanks do not count."""
    a, b = ([_NUMBER.sub(b"", line).strip() for line in lines] for lines in (a, b))
    stretches: list[Stretch] = []
    at_a = at_b = 0
    for i, j in [*_list_pairs(a, b), (len(a), len(b))]:
        if i < at_a or j < at_b:
            continue  # a stretch of equal lines has gone past it
        if i == at_a and j == at_b and stretches and stretches[-1].same and i < len(a):
            begin = stretches.pop()
            stretches.append(Stretch(True, begin.first_a, i + 1, begin.first_b, j + 1))
        else:
            if i > at_a or j > at_b:
                stretches.append(Stretch(False, at_a, i, at_b, j))
            if i < len(a):
                stretches.append(Stretch(True, i, i + 1, j, j + 1))
        at_a, at_b = i + 1, j + 1
    return stretches


def _list_pairs(a: Sequence[bytes], b: Sequence[bytes]) -> Iterator[tuple[int, int]]:
    """Pairs of equal lines, in order on both sides."""
    once_a, once_b = ({line for line, count in Counter(lines).items() if count == 1} for lines in (a, b))
    place = {line: j for j, line in enumerate(b) if line in once_b and line in once_a}
    anchors = _choose_rising([(i, place[line]) for i, line in enumerate(a) if line in place])
    at_a = at_b = 0
    for i, j in [*anchors, (len(a), len(b))]:
        # forwards from what was last paired
        while at_a < i and at_b < j and a[at_a] == b[at_b]:
            yield at_a, at_b
            at_a, at_b = at_a + 1, at_b + 1
        # backwards from the anchor
        back = 0
        while i - back > at_a and j - back > at_b and a[i - back - 1] == b[j - back - 1]:
            back += 1
        yield from ((i - k, j - k) for k in range(back, 0, -1))
        if i < len(a):
            yield i, j
        at_a, at_b = i + 1, j + 1


def _choose_rising(pairs: Sequence[tuple[int, int]]) -> list[tuple[int, int]]:
    """The longest choice of pairs whose second numbers rise; the first ones do."""
    tails: list[int] = []
    last: list[int] = []
    before = [-1] * len(pairs)
    for k, (_i, j) in enumerate(pairs):
        at = bisect_left(tails, j)
        if at:
            before[k] = last[at - 1]
        # the end of the list, or one place of it
        tails[at : at + 1], last[at : at + 1] = [j], [k]
    chosen = []
    k = last[-1] if last else -1
    while k >= 0:
        chosen.append(pairs[k])
        k = before[k]
    return chosen[::-1]
