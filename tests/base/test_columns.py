"""Columns in memory and in files."""

import numpy as np
import pytest

from verne_post.base import columns
from verne_post.base.columns import Growing, GrowingTable, iterate_blocks, release_memory, sum_running


@pytest.fixture(params=[0, 1 << 10, 1 << 30], ids=["file", "both", "memory"])
def held(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    monkeypatch.setattr(columns, "IN_MEMORY", request.param)
    monkeypatch.setattr(columns, "BLOCK_ROWS", 10)
    return int(request.param)


@pytest.mark.parametrize(("dtype", "width"), [(float, ()), (np.int8, ()), (bool, (3,)), (np.int32, (2, 4))])
def test_what_was_added_is_there(dtype: type, width: tuple[int, ...], held: int) -> None:
    rng = np.random.default_rng(1)
    parts = [rng.integers(0, 2, (count, *width)).astype(dtype) for count in (0, 5, 1, 0, 700)]
    column = Growing(dtype, *width)
    for part in parts:
        column.extend(part)
    whole = column.freeze()
    assert column.count == len(whole) == 706
    assert whole.dtype == dtype
    assert np.array_equal(whole, np.concatenate(parts))
    release_memory()
    assert np.array_equal(whole, np.concatenate(parts))
    copied = Growing(dtype, *width)
    copied.copy(whole[3:])
    assert np.array_equal(copied.freeze(), whole[3:])


def test_an_empty_column_has_its_shape(held: int) -> None:
    assert Growing(float, 5).freeze().shape == (0, 5)


def test_what_lies_in_a_file_cannot_be_changed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(columns, "IN_MEMORY", 0)
    column = Growing(float)
    column.extend(np.zeros(3))
    with pytest.raises(ValueError, match="read-only"):
        column.freeze()[0] = 1.0


def test_a_table_needs_every_column(held: int) -> None:
    table = GrowingTable(a=(float,), b=(np.int32, 2))
    table.extend(a=np.zeros(3), b=np.ones((3, 2)))
    with pytest.raises(KeyError):
        table.extend(a=np.zeros(3))
    assert {name: column.shape for name, column in table.freeze().items()} == {"a": (3,), "b": (3, 2)}


def test_sums_are_those_of_all_at_once(held: int) -> None:
    """To the last bit: lengths along a path must not depend on the blocks."""
    values = np.random.default_rng(2).normal(size=105)
    assert np.array_equal(sum_running(values), np.append(0.0, np.cumsum(values)))
    flags = values > 0
    assert sum_running(flags).tolist() == [0, *np.cumsum(flags).tolist()]
    assert sum_running(values[:0]).tolist() == [0.0]


def test_blocks_follow_each_other(held: int) -> None:
    assert list(iterate_blocks(25)) == [(0, 10), (10, 20), (20, 25)]
    assert list(iterate_blocks(25, 13)) == [(13, 23), (23, 25)]
    assert list(iterate_blocks(0)) == []


@pytest.mark.parametrize("width", [(), (3,)])
def test_rows_that_are_one_row_need_no_memory(width: tuple[int, ...], held: int) -> None:
    """Broadcast rows stay one row until another comes; what was added is there either way."""
    value, other = np.arange(1.0, 4.0)[: int(np.prod(width, initial=1))].reshape(width), np.full(width, -0.0)
    same = [np.broadcast_to(value, (count, *width)) for count in (2, 700, 41)]
    column = Growing(float, *width)
    for part in same:
        column.extend(part)
    whole = column.freeze()
    assert np.array_equal(whole, np.concatenate(same))
    assert whole.strides[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        whole[0] = 0.0
    for last in (np.broadcast_to(other, (9, *width)), other[None], np.broadcast_to(value, (1, *width))):
        column = Growing(float, *width)
        for part in (*same, last, same[0]):
            column.extend(part)
        whole = column.freeze()
        assert column.count == len(whole)
        assert whole.tobytes() == np.concatenate((*same, last, same[0])).tobytes()
