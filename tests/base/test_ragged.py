"""Flat layouts of ragged tables."""

import numpy as np
import pytest

from verne_post.base.ragged import ragged


@pytest.mark.parametrize("counts", [[], [0], [3], [2, 0, 1, 4], [0, 0, 2, 0]])
def test_parts_follow_each_other(counts: list[int]) -> None:
    owner, place = ragged(np.array(counts, dtype=int))
    assert list(zip(owner.tolist(), place.tolist(), strict=True)) == [
        (k, part) for k, count in enumerate(counts) for part in range(count)
    ]
