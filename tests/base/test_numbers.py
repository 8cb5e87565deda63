"""Numbers as text."""

import math

import pytest

from verne_post.base.numbers import format_duration, format_fixed


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


@pytest.mark.parametrize(
    ("seconds", "shown"),
    [
        (0.0, "0 s"),
        (0.125, "0.125 s"),
        (59.4, "59.4 s"),
        (59.7, "1 min"),
        (125.0, "2 min 5 s"),
        (3599.6, "1 h"),
        (60_000.0, "16 h 40 min"),
        (86_400.0, "1 day"),
        (121_500.0, "1 day 10 h"),
        (9e6, "104 days 4 h"),
        (math.inf, "over 1000 days"),
    ],
)
def test_a_time_has_its_two_largest_units(seconds: float, shown: str) -> None:
    assert format_duration(seconds) == shown
