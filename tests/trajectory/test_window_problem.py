"""What the interior point method sees of windows: how they are laid end to end, differences at points, the tightest rows."""

import numpy as np
import pytest

from verne_post.trajectory.window_problem import Layout, Window, _Samples, largest_rows


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


@pytest.mark.parametrize(
    ("knot", "cycle"), [(8, 1), (4, 1), (2, 1), (1, 1), (8, 4), (8, 2), (8, 0.25), (3, 0.7), (8, 10)]
)
@pytest.mark.parametrize("k", [2, 3, 4])
def test_differences_are_those_around_each_point(knot: float, cycle: float, k: int) -> None:
    """However points share samples: of q = s = t^3 the third difference is 6, the second one 6 t."""
    knots = np.arange(3.0, 10.0)
    samples = _Samples.of(knots, knot, k, cycle)
    assert (np.diff(samples.phases) > 0).all()
    assert samples.phases[0] >= 0
    assert samples.phases[-1] < 1
    t = ((knots + samples.phases[:, None]) * knot).ravel()
    a, b, c, d = (samples.times[samples.first + part * samples.stride] ** 3 for part in range(4))
    assert (d - 3 * (c - b) - a) / cycle**3 == pytest.approx(np.full(len(t), 6.0), rel=1e-6)
    assert (d - c - b + a) / (2 * cycle**2) == pytest.approx(6 * t, rel=1e-6)


@pytest.mark.parametrize("gap", [3, 7])
def test_windows_end_to_end_are_told_apart(gap: int) -> None:
    first = Window(10, 14, np.arange(7.0), begin_tied=False, end_tied=True)
    last = Window(20, 21, np.arange(10.0, 14.0), begin_tied=True, end_tied=False)
    layout = Layout([first, last], gap)
    assert layout.knots().tolist() == [*range(10, 14 + gap), 20]
    assert layout.in_gap().tolist() == [False] * 4 + [True] * gap + [False]
    assert layout.held().tolist() == [False] * 4 + [True] * (gap + 3) + [False]
    for window, part in zip(layout.windows, layout.split(layout.start()), strict=True):
        assert part.tolist() == window.start.tolist()
