"""The rows that the interior point method sees of each point: those with the largest scores."""

import numpy as np
import pytest

from verne_post.trajectory.window_problem import largest_rows


@pytest.mark.parametrize("rows", [2, 3, 6, 8, 9])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_largest_come_first(rows: int, count: int) -> None:
    random = np.random.default_rng(rows)
    scores = random.normal(size=(rows, 500)) * 10.0 ** random.uniform(-6, 6, size=(rows, 500))
    before = scores.copy()
    chosen = largest_rows(scores, min(count, rows - 1))
    np.testing.assert_array_equal(scores, before)
    wanted = np.argsort(-scores, axis=0, kind="stable")[: len(chosen)]
    np.testing.assert_array_equal(chosen, wanted)


def test_equal_scores_give_different_rows() -> None:
    for value in (0.0, 1.0, -1.0, -0.0):
        chosen = largest_rows(np.full((6, 4), value), 3)
        assert all(len(set(column)) == 3 for column in chosen.T.tolist())
        assert (chosen >= 0).all() and (chosen < 6).all()
