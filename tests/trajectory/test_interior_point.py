"""The banded interior point method on problems whose answer is known, and when it is cut short."""

import numpy as np
import pytest
from msgspec.structs import replace

from verne_post.trajectory.interior_point import Problem, build_basis, solve


def line(n: int = 200, cap: float = 1.0, *, held: slice = slice(0)) -> Problem:
    """A joint with Q' = 1: X below its cap, |X'| / 2 <= 5 and |X''| / 2 <= 100 X^(-1/2)."""
    phases = np.array([0.25, 0.75])
    one, none = np.ones((1, 2 * n)), np.zeros((1, 2 * n))

    def both(row: np.ndarray) -> np.ndarray:
        return np.concatenate([row, -row])

    acceleration = (both(none), both(0.5 * one / 5.0))
    jerk = (both(none), both(none), both(0.5 * one / 100.0))
    stays = np.zeros(n + 3, dtype=bool)
    stays[held] = True
    return Problem(0.01, phases, np.full(2 * n, cap), acceleration, jerk, stays)


def values(problem: Problem, c: np.ndarray) -> np.ndarray:
    """X, X' and X'' at the points, from the definition of the splines."""
    n = len(c) - 3
    table = build_basis(problem.knot, problem.phases)
    return np.stack([sum(row[:, k, None] * c[k : k + n] for k in range(4)).ravel() for row in table])


def test_basis_is_a_partition_of_one_and_its_derivatives_match_differences() -> None:
    f, h = np.linspace(0.1, 0.9, 5), 1e-5
    table = build_basis(0.5, f)
    assert table[0].sum(axis=1) == pytest.approx(np.ones(5))
    up, down = build_basis(0.5, f + h), build_basis(0.5, f - h)
    for order in (1, 2):
        # central differences over the knot spacing of 0.5
        assert table[order] == pytest.approx((up - down)[order - 1] / (2 * h * 0.5), abs=1e-8)


def test_nothing_but_the_cap() -> None:
    problem = line(cap=4.0)
    found = solve(problem, np.full(203, 1.0), start_gap=10.0, final_gap=1e-4, iterations=40)
    assert found.legal
    # the time is 1e-4 from its least, so is the mean of X^(-1/2)
    assert float((values(problem, found.coefficients)[0] ** -0.5).mean()) == pytest.approx(0.5, rel=2e-4)


def test_limits_hold_at_every_point_whatever_the_start() -> None:
    rng = np.random.default_rng(3)
    start = rng.uniform(0.05, 3.0, 203)  # far beyond every limit
    start[:3] = 0.2
    problem = line(held=slice(3))
    found = solve(problem, start, start_gap=30.0, final_gap=1e-3, iterations=60)
    x, x1, x2 = values(problem, found.coefficients)
    assert found.legal
    assert found.coefficients[:3] == pytest.approx(np.full(3, 0.2))
    assert x.max() <= 1.001
    assert np.abs(x1).max() / 2 <= 5 * 1.001
    assert (np.abs(x2) / 2 <= 100 * x**-0.5 * 1.001).all()
    # it reaches the cap as fast as the acceleration and jerk let it: 0.8 at a slope of 10 and 50 ms of jerk each
    assert 0.08 <= problem.knot * (np.argmax(x.reshape(2, -1)[0] > 0.99)) <= 0.16


def test_a_window_that_is_not_the_last_ends_slowly() -> None:
    problem = line(held=slice(-3, None))
    found = solve(
        problem, np.append(np.full(200, 0.9), np.full(3, 0.01)), start_gap=10.0, final_gap=1e-2, iterations=40
    )
    assert found.legal
    assert found.coefficients[-3:].max() <= 0.011
    assert found.coefficients[:100].min() > 0.95


@pytest.mark.parametrize("iterations", [0, 1, 3])
def test_cut_short_it_says_so_and_stays_positive(iterations: int) -> None:
    problem = line(cap=0.01)
    found = solve(problem, np.full(203, 2.0), start_gap=10.0, final_gap=1e-9, iterations=iterations)
    assert found.iterations <= iterations
    assert (found.coefficients > 0).all()
    if iterations == 0:
        assert not found.legal


@pytest.mark.parametrize("size", [1e15, 1e25, 1e37])
def test_rows_that_overflow_end_it_without_a_warning(size: float) -> None:
    """Rows are in single precision; squares of such rows are not numbers there."""
    problem = line()
    beyond = replace(problem, jerk=tuple(size * row for row in problem.jerk))
    found = solve(
        beyond, np.full(203, 0.9) + np.linspace(0, 0.1, 203) ** 2, start_gap=10.0, final_gap=1e-3, iterations=20
    )
    assert np.isfinite(found.coefficients).all()
    assert (found.coefficients > 0).all()
