"""Spans: parts of elements that are checked together, and halved until each can be decided."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base import spans
from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import iterate_blocks
from verne_post.base.ragged import number_parts
from verne_post.model.contour import Contour

#: Elements, and first spans, checked at a time.
CHUNK: Final = 2048
#: First guess of a span: at most this much path and rotation.
SPAN_MM: Final = 50.0
SPAN_ANGLE: Final = np.radians(20.0)
#: Once a violation is certain its worst value is refined only this much further.
WORST_DEPTH: Final = 7


class Spans(Struct, frozen=True, eq=False):
    """Spans of elements."""

    element: Ints  #: (n,)
    #: low, high (n,): Parameters w of the element between which each span lies, 0 to 1.
    low: Array
    high: Array
    depth: Ints  #: (n,): How often it was halved.

    def __len__(self) -> int:
        return len(self.element)

    def place_samples(self, at: Array = spans.WITH_ENDS) -> tuple[Ints, Array]:
        """Element (m, n) and parameter (m, n) of places ``at`` (m,) of every span: its samples, its ends last."""
        w = self.low + at[:, None] * (self.high - self.low)
        return np.broadcast_to(self.element, w.shape), w

    def take(self, which: slice | Ints | Mask) -> "Spans":
        """Some of the spans."""
        return Spans(self.element[which], self.low[which], self.high[which], self.depth[which])

    def halve(self, which: Mask) -> "Spans":
        """Both halves of some of the spans: all lower ones, then all upper ones."""
        part = self.take(np.flatnonzero(which))
        middle = 0.5 * (part.low + part.high)
        return Spans(
            np.concatenate([part.element, part.element]),
            np.concatenate([part.low, middle]),
            np.concatenate([middle, part.high]),
            np.concatenate([part.depth, part.depth]) + 1,
        )


def split_elements(n: int) -> Iterator[Ints]:
    """The numbers of n elements, so many as are checked at a time."""
    for begin, end in iterate_blocks(n):
        for first in range(begin, end, CHUNK):
            yield np.arange(first, min(first + CHUNK, end))


def cover_elements(contour: Contour, elements: Ints) -> Iterator[Spans]:
    """First spans that cover elements."""
    wanted = np.maximum(contour.length[elements] / SPAN_MM, contour.rotation[elements] / SPAN_ANGLE)
    parts = np.maximum(np.ceil(wanted), 1).astype(int)
    owner, index = number_parts(parts)
    share = parts[owner]
    whole = Spans(elements[owner], index / share, (index + 1) / share, np.zeros(len(owner), int))
    for begin in range(0, len(owner), CHUNK):
        yield whole.take(slice(begin, begin + CHUNK))
