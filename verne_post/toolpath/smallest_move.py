"""The smallest move of the part with which a program is within limits: people do not like to set up a part again.

The size of a move is a bound of how far any point of the part is moved: the shift of its zero, and the turn times the
largest distance of the program from the zero. A part is turned only where no shift alone will do.
"""

from collections.abc import Iterator
from itertools import product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Mask
from verne_post.toolpath.work_offset import AROUND, FOLLOWED, REFINEMENTS, ROUNDS, SCATTERED, SHRINK, Place, Search

#: Margins that the points of the program keep to every limit: the points may miss the worst place. The larger ones
#: serve where the check of the whole program refuses what a smaller one found.
RESERVES: Final = (1e-4, 2e-3, 0.02)
#: A proposed shift is rounded to this, mm, away from where the part is: people do not set hundredths.
ROUND_MM: Final = 0.1
#: One sampled place of so many says which points decide.
SCREENED: Final = 64
#: The nearest sampled moves are so much of the whole range.
NEAREST: Final = 1e-5


class SmallestMove:
    """Moves of the part of one program from where it is now.

    Parameters
    ----------
    search : Search
    start : Place
        Where the part is.
    counts : ndarray of bool, shape (k,)
        The margins that depend on the place.
    """

    def __init__(self, search: Search, start: Place, counts: Mask) -> None:
        self.search, self.start, self.counts = search, start.pack_array(), counts
        tip = search.points.tip
        self.reach = float(np.hypot(tip[:, 0], tip[:, 1]).max())

    def measure_size(self, places: Array) -> Array:
        """How far no point of the part is moved at most, mm, for places (n, 4)."""
        moved = places - self.start
        return np.asarray(np.linalg.norm(moved[..., :3], axis=-1) + self.reach * np.abs(moved[..., 3]))

    def propose(self) -> Iterator[Array]:
        """Places (4,) within limits by the points of the program, the smallest move first, in round numbers first."""
        for reserve in RESERVES:
            found = self._find_shift(reserve)
            if found is None:
                found = self.find(self.search.free, reserve)
            if found is None:
                return
            found = self._drop_idle(found)
            moved = found - self.start
            round_one = found.copy()
            round_one[:3] = (
                self.start[:3] + np.sign(moved[:3]) * np.ceil(np.abs(moved[:3]) / ROUND_MM - 1e-6) * ROUND_MM
            )
            for place in (round_one, found):
                if self._is_legal(place):
                    yield place

    def _find_shift(self, reserve: float) -> Array | None:
        """The nearest place (4,) found by a shift along all free axes or some: fewer are searched more closely."""
        shifts = self.search.free & [True, True, True, False]
        found = self.find(shifts, reserve) if shifts.any() else None
        may_stay = (self.start >= self.search.low) & (self.start <= self.search.high)
        for one in sorted(product((False, True), repeat=3), key=sum)[1:-1]:
            free = shifts & [*one, False]
            stay = shifts & ~free
            if free.sum() != sum(one) or not stay.any() or not may_stay[stay].all():
                continue
            farthest = np.array([self.search.low, self.search.high] if found is None else [found])
            nearer = self.find(free, reserve, float(self.measure_size(farthest).max()))
            found = found if nearer is None else nearer
        return found

    def _drop_idle(self, found: Array) -> Array:
        """A place without what its move does not need: the search leaves a trace in every coordinate."""
        for kept in sorted(product((False, True), repeat=4), key=sum):
            place = np.where(kept, found, self.start)
            if self._is_legal(place):
                return place
        return found

    def _is_legal(self, place: Array) -> bool:
        """Whether a place (4,) lies in the range, and no point of the program is beyond a limit there."""
        return bool(self.search.is_inside(place) and self.search.rate(place[None], self.counts)[0] >= 0.0)

    def find(self, free: Mask, reserve: float, within: float = np.inf) -> Array | None:
        """The nearest place (4,) found at which every margin is at least the reserve, nearer than ``within``, mm; None
        where none was found.
        """
        random = np.random.default_rng(0)  # the same program has the same answer
        low = np.where(free, np.maximum(self.search.low, self.start - within), self.start)
        high = np.where(free, np.minimum(self.search.high, self.start + within), self.start)
        n = SCATTERED // 2 if within == np.inf else SCATTERED // 16
        # half of the samples over the whole range, half near the start, in steps of the same ratio
        far = self.search.draw_places(random, n, low, high)
        share = NEAREST ** random.random((n, 1))
        near = self.start + share * random.uniform(-1, 1, (n, 4)) * (high - low)
        places = self.search.keep_inside(np.concatenate([far, near, self.start[None]]), low, high)
        places = places[self.measure_size(places) < within]
        if not len(places):
            return None
        rows = self.search.choose_first_rows()
        for _ in range(REFINEMENTS):
            few = self.search.find_deciding_rows(places[::SCREENED], self.counts, rows)
            floor = np.full(len(places), reserve)
            legal = places[self.search.rate_promising(places, self.counts, rows, few, floor) >= reserve]
            if not len(legal):
                return None
            best = legal[np.argsort(self.measure_size(legal), kind="stable")[:FOLLOWED]]
            best = self._improve(best, rows, low, high, reserve, random)
            worse = self.search.find_worst_rows(best[0])
            if np.isin(worse, rows).all():
                return np.asarray(best[0])
            rows = np.union1d(rows, worse)
            places = np.concatenate([best, places])
        return None

    def _improve(
        self, best: Array, rows: NDArray[np.intp], low: Array, high: Array, reserve: float, random: np.random.Generator
    ) -> Array:
        """Nearer places around good ones (n, 4), in ranges that shrink with the move; returns them nearest first."""
        share = 0.5
        for _ in range(ROUNDS):
            size = self.measure_size(best)
            # nearer along the way back, and aside of it by less and less
            back = self.start + (best - self.start)[:, None] * (1 - share * random.random((len(best), AROUND, 1)))
            aside = share * random.uniform(-1, 1, (len(best), AROUND, 4)) * size[:, None, None]
            aside[..., 3] /= max(self.reach, 1.0)
            around = self.search.keep_inside(back + aside, low, high)
            sizes = self.measure_size(around)
            share *= SHRINK
            nearer = sizes < size[:, None]  # no other is asked for
            if not nearer.any():
                continue
            few = self.search.find_deciding_rows(best, self.counts, rows)
            floor = np.full(np.count_nonzero(nearer), reserve)
            legal = self.search.rate_promising(around[nearer], self.counts, rows, few, floor) >= reserve
            sizes[~nearer] = np.inf
            sizes[nearer] = np.where(legal, sizes[nearer], np.inf)
            top, each = sizes.argmin(axis=1), np.arange(len(best))
            better = sizes[each, top] < size
            best[better] = around[each, top][better]
        return np.asarray(best[np.argsort(self.measure_size(best), kind="stable")])
