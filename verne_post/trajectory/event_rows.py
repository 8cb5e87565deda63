"""When events happen: at the first row that belongs to a motion after them."""

import numpy as np

from verne_post.base.arrays import Array, Ints


class EventRows:
    """Finds the rows of events while rows go by.

    Parameters
    ----------
    before : ndarray of int, shape (n,)
        Number of the move that follows each event, ascending; -1 for what happens at the very beginning.
    """

    def __init__(self, before: Ints) -> None:
        self.before = before
        self.row = np.full(len(before), -1, dtype=np.int64)
        self.numbers: list[Array] = []
        self._last: Array | None = None
        self._seen = 0

    def feed(self, first: int, move: Ints, numbers: Array) -> None:
        """The next rows: the number of the first, the move that each belongs to, and what is written of it."""
        while len(self.numbers) < len(self.before):
            due = self.before[len(self.numbers)]
            at = 0 if due < 0 else int(np.argmax(move >= due)) if (move >= due).any() else -1
            if at < 0:
                break
            self._happens(first + at, numbers[at])
        self._last, self._seen = numbers[-1], first + len(move)

    def finish(self) -> None:
        """No more rows: what is left happens at the last one."""
        while self._last is not None and len(self.numbers) < len(self.before):
            self._happens(self._seen - 1, self._last)

    def _happens(self, row: int, numbers: Array) -> None:
        self.row[len(self.numbers)] = row
        self.numbers.append(numbers)
