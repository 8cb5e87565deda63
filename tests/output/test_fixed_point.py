"""Numbers as text, whole columns at a time: Python's own formatting to the byte."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from verne_post.output.fixed_point import EXACT, format_rows


def by_python(columns: list[np.ndarray], decimals: list[int], separator: str) -> str:
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return "".join(separator.join(f"{v:.{d}f}" for v, d in zip(row, decimals, strict=True)) + "\n" for row in rows)


@given(
    st.integers(0, 12),
    st.lists(st.tuples(st.floats(-1e3, 1e3), st.integers(-(10**9), 10**9)), min_size=1, max_size=20),
)
def test_rounded_numbers_are_what_python_writes(decimals: int, pairs: list[tuple[float, int]]) -> None:
    first = np.round(np.array([one for one, _ in pairs]), decimals)
    second = np.array([float(two) for _, two in pairs])
    columns, places = [first, second], [decimals, 0]
    assert format_rows(columns, places, ",") == by_python(columns, places, ",")


@pytest.mark.parametrize("decimals", [0, 1, 6])
@pytest.mark.parametrize(
    "numbers",
    [
        [0.0, -0.0, 1.0, -1.0, 9.0, 10.0, 99.0, -100.0],
        [0.5, 1.5, 2.5, -0.5],  # halves are no whole units at 0 decimals
        [np.pi, -np.e],
        [float("nan"), 1.0],
        [float("inf"), -1.0],
        [EXACT, -EXACT, EXACT - 1.0],
        [1e300, 1.0],
        [0.999999, -0.000001],
    ],
    ids=str,
)
def test_so_are_the_others(numbers: list[float], decimals: int) -> None:
    columns = [np.array(numbers), np.arange(float(len(numbers)))]
    assert format_rows(columns, [decimals, 3], " ") == by_python(columns, [decimals, 3], " ")


@pytest.mark.parametrize("cycle", [0.000125, 0.001, 0.0012, 0.01, 1 / 3000])
def test_times_a_cycle_apart_keep_their_digits_to_the_end_of_a_long_file(cycle: float) -> None:
    decimals = {0.000125: 6, 0.001: 3, 0.0012: 4, 0.01: 2}.get(cycle, 12)
    time = (2**31 - 1000 + np.arange(1000)) * cycle
    assert format_rows([time], [decimals], ",") == by_python([time], [decimals], ",")


def test_a_number_half_a_unit_off_is_rounded_as_python_rounds_it() -> None:
    """The nearest doubles on both sides of every half: only the exact binary value says which way they go."""
    halves = (np.arange(1, 2000) + 0.5) * 1e-3
    around = np.concatenate([halves, np.nextafter(halves, 0), np.nextafter(halves, np.inf)])
    assert format_rows([around], [3], ",") == by_python([around], [3], ",")


def test_no_rows_are_no_text() -> None:
    assert format_rows([np.empty(0), np.empty(0)], [3, 0], ",") == ""
