"""The least distance for which a question is true."""

import pytest

from verne_post.base.least import find_least


@pytest.mark.parametrize("edge", [0.3, 1.99, 2.0, 7.25, 159.9])
def test_it_ends_right_and_no_more_than_settled_above_what_is_not(edge: float) -> None:
    asked = []

    def is_true(distance: float) -> bool:
        asked.append(distance)
        return distance >= edge

    found = find_least(is_true, (2.0, 5.0, 10.0, 160.0), 0.01)
    assert found is not None
    assert edge <= found <= edge + 0.01
    assert len(asked) == len(set(asked)), "each may be a check of a whole program"


def test_none_of_the_tried_is_none() -> None:
    assert find_least(lambda distance: distance > 20, (2.0, 10.0), 0.01) is None
    assert find_least(lambda distance: True, (), 0.01) is None
