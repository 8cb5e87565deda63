"""Ragged tables laid out flat: each owner has several parts, one after the other."""

import numpy as np

from verne_post.base.arrays import Ints


def ragged(count: Ints) -> tuple[Ints, Ints]:
    """Owner and place of every part (m,), for owners (n,) with ``count`` parts, 0 or more; places begin at 0."""
    owner = np.repeat(np.arange(len(count)), count)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
