"""Map matching by dynamic programming (Viterbi): which of several places that are near a row the row belongs to.

Of the places near each row, those count that follow each other by steps as long as the rows'.
"""

from itertools import pairwise

import numpy as np

from verne_post.base.arrays import Array, Ints


def match_places(item: Ints, where: Array, cost: Array, first: Ints, place: float, step: Array) -> Ints:
    """The cheapest sequence of candidates, one for each row (n,): their indices, ascending.

    Parameters
    ----------
    item, where, cost : ndarray, shape (m,)
        Of the candidates: items that ascend from row to row, place along the path (mm), and extra cost (mm). The way to
        a candidate costs as many mm as it differs from the row's step.
    first : ndarray of int, shape (n + 1,)
        First candidate of each row, and m.
    place : float
        Place of the row before the first one, mm.
    step : ndarray, shape (n,)
        Length of the step to each row, mm.
    """
    total, before = np.zeros(1), np.array([place])
    item_before = np.array([-1])
    came: list[Ints] = []
    for k, (begin, end) in enumerate(pairwise(first.tolist())):
        ways = total[:, None] + np.abs(where[None, begin:end] - before[:, None] - step[k])
        ways[item_before[:, None] > item[None, begin:end]] = np.inf
        best = np.argmin(ways, axis=0)
        total = ways[best, np.arange(end - begin)] + cost[begin:end]
        before, item_before = where[begin:end], item[begin:end]
        came.append(best)
    found = np.empty(len(step), dtype=np.int64)
    chosen = int(np.argmin(total))
    for k in range(len(step) - 1, -1, -1):
        found[k] = first[k] + chosen
        chosen = int(came[k][chosen])
    return found
