"""The smallest move of a part: a search along all axes is no worse than one along some."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from verne_post.toolpath.smallest_move import SmallestMove
from verne_post.toolpath.work_offset import Place


@pytest.mark.parametrize("letters", ["x", "xy", "xyz"])
def test_fewer_axes_are_tried_and_the_nearest_place_is_kept(monkeypatch: pytest.MonkeyPatch, letters: str) -> None:
    """The scattered search along all axes found 36 mm where 13.4 mm along X do it."""
    free = np.array([letter in letters for letter in "xyzc"])
    ends = {"low": np.full(4, -1e3), "high": np.full(4, 1e3)}
    search: Any = SimpleNamespace(free=free, points=SimpleNamespace(tip=np.ones((1, 3))), **ends)
    smallest = SmallestMove(search, Place(0.0, 0.0, 0.0, 0.0), np.ones(1, dtype=bool))
    places = {(True,): (13.4, 0, 0, 0), (True, True): (13.2, -7.6, 0, 0), (True, True, True): (13.2, -7.6, 32.4, 0)}
    asked = []

    def find(axes: Any, _reserve: float, within: float = np.inf) -> Any:
        asked.append(tuple(axes[:3].tolist()))
        place = np.array(places.get(tuple(axes[: axes.sum()].tolist()), (0, 500, 0, 0)), dtype=float)
        return place if smallest.measure_size(place) < within else None

    monkeypatch.setattr(smallest, "find", find)
    found = smallest._find_shift(0.0)
    assert found is not None
    assert found.tolist() == [13.4, 0.0, 0.0, 0.0]
    assert len(set(asked)) == len(asked) == 2 ** len(letters) - 1
