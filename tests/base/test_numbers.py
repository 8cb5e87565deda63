"""Numbers as text."""

import math

import pytest

from verne_post.base.numbers import format_fixed


@pytest.mark.parametrize(
    ("value", "decimals", "shown"),
    [
        (-0.0, 2, "0.00"),
        (-0.004, 2, "0.00"),
        (-0.006, 2, "-0.01"),
        (0.004, 2, "0.00"),
        (-0.4, 0, "0"),
        (-10.0, 0, "-10"),
        (-100.0, 1, "-100.0"),
        (math.inf, 2, "inf"),
        (math.nan, 2, "nan"),
    ],
)
def test_a_number_is_never_minus_zero(value: float, decimals: int, shown: str) -> None:
    assert format_fixed(value, decimals) == shown
