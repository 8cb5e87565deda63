"""Rows that follow the feed rate: what leaves out the search for fewer of them."""

import numpy as np
import pytest

from verne_post.base.tolerances import WHOLE_CYCLE
from verne_post.trajectory.follow_feed import EVEN_ROWS, _space_rows_evenly


@pytest.mark.parametrize("seed", range(30))
def test_rows_are_never_fewer_than_at_the_highest_speed(seed: int) -> None:
    """Stretches without a row to gain are given up by this, unseen: also speeds from and to faster neighbours."""
    pick = np.random.default_rng(seed)
    edges = np.append(0.0, np.cumsum(pick.uniform(0.01, 2.0, pick.integers(1, 9))))
    pace, cycle = 1.0 / pick.uniform(1.0, 60.0, len(edges) - 1), 0.01
    fewest = np.ceil(edges[-1] * pace.min() / cycle - 2 * WHOLE_CYCLE) + 1
    for reach in EVEN_ROWS:
        for begin, end in ((np.inf, np.inf), pick.uniform(1.0, 200.0, 2)):
            assert len(_space_rows_evenly(edges, pace, cycle, reach, begin, end)) >= fewest
