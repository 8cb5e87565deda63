"""Ragged tables laid out flat: each owner has several parts, one after the other; runs of a mask."""

import numpy as np

from verne_post.base.arrays import Ints, Mask


def number_parts(count: Ints) -> tuple[Ints, Ints]:
    """Owner and place of every part (m,), for owners (n,) with ``count`` parts, 0 or more; places begin at 0."""
    owner = np.repeat(np.arange(len(count)), count)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)


def find_runs(mask: Mask) -> tuple[Ints, Ints]:
    """First place of each run of True in a mask (n,), and the place after its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return edges[::2], edges[1::2]
