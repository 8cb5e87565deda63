"""Reductions over the few columns of tall tables: numpy's own answers."""

import numpy as np
import pytest

from verne_post.base.rows import find_row_max, find_row_min, measure_rows, sum_rows


@pytest.mark.parametrize("shape", [(0, 3), (1, 1), (7, 2), (1000, 5)], ids=str)
def test_they_agree_with_numpy(shape: tuple[int, int]) -> None:
    table = np.random.default_rng(1).normal(size=shape)
    before = table.copy()
    np.testing.assert_array_equal(find_row_max(table), table.max(axis=1))
    np.testing.assert_array_equal(find_row_min(table), table.min(axis=1))
    np.testing.assert_allclose(sum_rows(table), table.sum(axis=1), rtol=0, atol=1e-14)
    np.testing.assert_allclose(measure_rows(table), np.linalg.norm(table, axis=1), rtol=1e-15)
    np.testing.assert_array_equal(table, before)


def test_one_column_is_not_handed_out_itself() -> None:
    table = np.arange(3.0)[:, None]
    find_row_max(table)[:] = 9.0
    assert table[:, 0].tolist() == [0.0, 1.0, 2.0]


def test_of_a_table_of_more_dimensions_the_last_one_is_reduced() -> None:
    table = np.random.default_rng(4).normal(size=(7, 5, 3))
    np.testing.assert_allclose(sum_rows(table), table.sum(axis=-1), rtol=0, atol=1e-14)
    np.testing.assert_array_equal(find_row_max(table), table.max(axis=-1))
