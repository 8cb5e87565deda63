"""Flat layouts of ragged tables."""

import numpy as np
import pytest

from verne_post.base.ragged import find_runs, number_parts


@pytest.mark.parametrize("counts", [[], [0], [3], [2, 0, 1, 4], [0, 0, 2, 0]])
def test_parts_follow_each_other(counts: list[int]) -> None:
    owner, place = number_parts(np.array(counts, dtype=int))
    assert list(zip(owner.tolist(), place.tolist(), strict=True)) == [
        (k, part) for k, count in enumerate(counts) for part in range(count)
    ]


@pytest.mark.parametrize(
    ("mask", "runs"), [("", []), ("0", []), ("1", [(0, 1)]), ("0110", [(1, 3)]), ("1101", [(0, 2), (3, 4)])]
)
def test_runs_of_a_mask(mask: str, runs: list[tuple[int, int]]) -> None:
    first, last = find_runs(np.array([one == "1" for one in mask], dtype=bool))
    assert list(zip(first.tolist(), last.tolist(), strict=True)) == runs
