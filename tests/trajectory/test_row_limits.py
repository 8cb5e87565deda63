"""How far rows are beyond the limits, against the definitions written out row by row."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from verne_post.trajectory import tuning
from verne_post.trajectory.row_limits import add_rest, find_exceeding, measure_excess
from verne_post.trajectory.section_path import SectionTask

from .curves import ACCEPTED, Curve, limits

CYCLE = 2e-3


@dataclass(frozen=True)
class Hiding(Curve):
    """Steps hide more the farther they are along, from a quarter of the path on too much."""

    def measure_hidden(self, s: np.ndarray) -> np.ndarray:
        return 4.0 * s[1:] / self.length * (np.diff(s) > 0)


def section(feed: float | Callable[[np.ndarray], np.ndarray]) -> Hiding:
    return Hiding(20.0, lambda s: [s, np.sin(s), 0.2 * s**2], feed)


def written_out(section: Hiding, rows: np.ndarray, dynamics: tuple[float, float, float]) -> list[float]:
    """Of each row the largest share of what is accepted, over the differences that begin there."""
    q, hidden = section.find_joints(rows), section.measure_hidden(rows)
    found = []
    for k in range(len(rows) - 3):
        places = np.array([rows[k], 0.5 * (rows[k] + rows[k + 1]), rows[k + 1]])
        step = rows[k + 1] - rows[k]
        shares = [step / (CYCLE * section.find_speed(places).min() * ACCEPTED[3])]
        if hidden[k] > 1.0:
            shares.append(hidden[k] / ACCEPTED[3])
        for order, weights in enumerate(([-1, 1], [1, -2, 1], [-1, 3, -3, 1])):
            moved = np.abs(sum(w * q[k + n] for n, w in enumerate(weights))).max()
            shares.append(moved / (dynamics[order] * CYCLE ** (order + 1) * ACCEPTED[order]))
        found.append(max(shares))
    return found


@pytest.mark.parametrize("at_a_time", [1, 4, 7, 1000])
@pytest.mark.parametrize("n", [1, 2, 3, 18, 30])
@pytest.mark.parametrize(
    "dynamics", [(1e9, 1e12, 1e15), (500.0, 1e12, 1e15), (1e9, 3e5, 1e15), (1e9, 1e12, 2e8), (900.0, 9e5, 8e8)]
)
def test_each_difference_counts_in_blocks_of_any_size(
    monkeypatch: pytest.MonkeyPatch, at_a_time: int, n: int, dynamics: tuple[float, float, float]
) -> None:
    monkeypatch.setattr(tuning, "AT_A_TIME", at_a_time)
    random = np.random.default_rng(n)
    curve = section(lambda s: 600.0 + 500.0 * np.sin(9.0 * s))
    rows = add_rest(np.sort(np.append(random.uniform(0.0, 20.0, n), [0.0, 20.0])))
    assert rows[:4].tolist() == [0.0] * 4
    assert rows[-4:].tolist() == [20.0] * 4
    worst = measure_excess(SectionTask(curve, limits(3, *dynamics), CYCLE, CYCLE), rows)
    expected = written_out(curve, rows, dynamics)
    np.testing.assert_allclose(worst, expected, rtol=1e-8, atol=1e-12)
    at, value = find_exceeding(worst)
    assert at.tolist() == [k for k, share in enumerate(expected) if share > 1.0]
    assert value.tolist() == worst[at].tolist()
