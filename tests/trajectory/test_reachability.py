"""The reachability passes: closed form, legality and optimality on the grid, and windows that join exactly."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from verne_post.model.machine import Limits
from verne_post.trajectory import reachability, tuning
from verne_post.trajectory.initial_profile import bound_second_order_time
from verne_post.trajectory.reachability import _find_rising_in_x, _lower_to_possible
from verne_post.trajectory.section_path import Grid, build_grid_along

from .curves import Curve, limits, straight, wavy


def ratios(grid, limits, x):  # type: ignore[no-untyped-def]
    """Acceleration over its limit at both ends of every step: the larger, (n - 1, joints)."""
    u = np.diff(x)[:, None] / (2 * np.diff(grid.s)[:, None])
    ends = [np.abs(grid.d1[k] * u + grid.d2[k] * x[k, None]) for k in (slice(None, -1), slice(1, None))]
    return np.maximum(*ends) / limits.acceleration


def test_straight_line_takes_the_time_of_the_trapezoid() -> None:
    section, top = straight(40.0, feed=50.0), limits(3)
    grid = build_grid_along(replace(section, elements=2000))
    # v / a + s / v; a grid of 5 um shortens the ramps by less than a step each
    assert reachability.find_duration(grid.s, reachability.solve(grid, top)) == pytest.approx(
        50 / 5000 + 40 / 50, rel=2e-4
    )


def test_the_bound_of_a_straight_line_is_that_of_the_trapezoid_on_any_grid() -> None:
    """At a slow feed the first and last step of the grid are many times as long as the ramps."""
    for feed in (1.0, 10.0):
        section, top = straight(20.0, feed=feed), limits(3)
        grid = build_grid_along(section)
        x = reachability.solve(grid, top)
        least = reachability.bound_duration(grid.s, x, reachability.find_accelerations(grid, top, x))
        exact = feed / 5000 + 20 / feed
        assert least == pytest.approx(exact, rel=1e-12)
        assert reachability.find_duration(grid.s, x) > (1 + 5e-4) * exact


@pytest.mark.parametrize("waves", [0.5, 3.0, 20.0])
@pytest.mark.parametrize("feed", [np.inf, 30.0])
def test_the_bound_is_no_more_than_the_profile_takes_on_the_grid(waves: float, feed: float) -> None:
    grid, top = build_grid_along(wavy(50.0, waves, feed)), limits(3)
    x = reachability.solve(grid, top)
    least = reachability.bound_duration(grid.s, x, reachability.find_accelerations(grid, top, x))
    assert 0.95 < least / reachability.find_duration(grid.s, x) <= 1.0


@pytest.mark.parametrize("waves", [0.5, 3.0, 20.0])
@pytest.mark.parametrize("feed", [np.inf, 30.0])
def test_profile_is_legal_and_somewhere_at_a_limit_at_every_step(waves: float, feed: float) -> None:
    grid, top = build_grid_along(wavy(50.0, waves, feed)), limits(3)
    x = reachability.solve(grid, top)
    ratio = ratios(grid, top, x).max(axis=1)
    assert x[0] == x[-1] == 0.0
    assert (x <= reachability.limit_speeds(grid, top) * (1 + 1e-12)).all()
    assert ratio.max() <= 1 + 1e-9
    # nothing is left over: the acceleration is at its limit, or the speed at its cap at one end of the step,
    # but for the single steps on which it turns from speeding up to slowing down
    at_cap = x >= reachability.limit_speeds(grid, top) * (1 - 1e-9)
    loose = ~((ratio > 1 - 1e-6) | at_cap[:-1] | at_cap[1:])
    assert not (loose[1:] & loose[:-1]).any()


@pytest.mark.parametrize("seed", range(4))
def test_caps_are_lowered_to_what_leaves_a_next_speed(seed: int) -> None:
    """Against a linear program in both squared speeds of a step: the largest x <= cap for which some K >= 0 is
    possible.
    """
    rng = np.random.default_rng(seed)
    steps, count = 40, 6
    a, b = (rng.normal(size=(steps, count)) * 10.0 ** rng.uniform(-2, 2, (steps, 1)) for _ in range(2))
    a[rng.random(a.shape) < 0.2] = b[rng.random(b.shape) < 0.2] = 0.0  # lines that bound x, or K, alone
    cap = 10.0 ** rng.uniform(-1, 3, steps)
    offset, gain = _find_rising_in_x((a, b))
    lowered = _lower_to_possible(cap, (offset, gain))
    assert 5 < np.count_nonzero(lowered < cap) < steps - 5
    for one_offset, one_gain, most, found in zip(offset, gain, cap, lowered, strict=True):
        bounding = np.isfinite(one_offset)
        lines = np.stack([one_gain[bounding], -np.ones(np.count_nonzero(bounding))], axis=1)
        exact = linprog(
            [-1.0, 0.0],
            np.concatenate([lines, -lines]),
            np.tile(one_offset[bounding], 2),
            bounds=[(0, most), (0, None)],
        )
        assert found == pytest.approx(exact.x[0], rel=1e-6)


@pytest.mark.parametrize("window", [3, 17, 64])
def test_windows_join_to_the_full_solution(window: int) -> None:
    grid = build_grid_along(wavy(80.0, 12.0, 60.0))
    top = limits(3)
    full = reachability.solve(grid, top, window=len(grid.s))
    assert np.array_equal(reachability.solve(grid, top, window=window), full)


def test_a_section_of_resting_joints_is_only_bound_by_its_feed() -> None:
    grid = build_grid_along(Curve(10.0, lambda s: [np.ones_like(s), np.zeros_like(s)], feed=20.0))
    assert (reachability.solve(grid, limits(2))[1:-1] == 400.0).all()


def test_tiny_elements_do_not_look_curved() -> None:
    # breaks 1e-7 mm apart: rounding of the joints over their square would be an acceleration of the path
    section = straight(40.0, feed=50.0)
    near = np.sort(np.concatenate([section.breaks, section.breaks[1:-1] + 1e-7]))

    class Broken:
        length, breaks = section.length, near
        find_joints, find_speed = staticmethod(section.find_joints), staticmethod(section.find_speed)

    grid = build_grid_along(Broken())
    assert np.abs(grid.d2).max() == 0.0


@pytest.mark.parametrize(
    ("section", "message"),
    [
        (Curve(5.0, lambda s: [np.where(s > 2, np.nan, s)]), "not finite at s = 2"),
        (Curve(100.0, lambda s: [np.where(s > 25, np.nan, s)]), "not finite at s = 25.9"),  # the first of several spans
        (Curve(5.0, lambda s: [s], feed=0.0), "allows no speed"),
        (Curve(np.nan, lambda s: [s]), "finite length"),
        (Curve(0.0, lambda s: [s]), "finite length"),
    ],
)
def test_impossible_sections_are_refused(section: Curve, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        build_grid_along(section)


def test_a_joint_that_turns_at_a_grid_point_only_bounds_the_speed_there() -> None:
    """Its q' is exactly 0 and its q'' is not: |q'' x| <= a, and nothing stops."""
    s = np.linspace(0.0, 20.0, 41)
    d1 = np.stack([np.ones_like(s), np.zeros_like(s)], axis=1)
    d2 = np.zeros_like(d1)
    d2[20, 1] = 4.0
    top = limits(2)
    grid = Grid(s, d1, d2, np.zeros_like(d1), np.full(len(s), np.inf))
    x = reachability.solve(grid, top)
    assert x[20] == pytest.approx(top.acceleration[1] / 4.0)
    assert (x[1:-1] > 0).all()
    assert ratios(grid, top, x).max() <= 1 + 1e-9


def test_short_elements_share_spans_and_their_derivatives_are_exact() -> None:
    fine = replace(wavy(50.0, 3.0, 60.0), elements=1000)  # 0.8 ms each at the feed rate
    grid = build_grid_along(fine)
    assert len(grid.s) < 1100  # eight elements share eight points; with a span for each there are 4000
    assert (grid.s[0], grid.s[-1]) == (0.0, 50.0)
    k = 2 * np.pi * 3.0 / 50.0
    s = grid.s[1:-1]
    assert grid.d1[1:-1, 0] == pytest.approx(1 + 0.6 * np.cos(k * s), abs=1e-7)
    assert grid.d2[1:-1, 0] == pytest.approx(-0.6 * k * np.sin(k * s), abs=1e-5)
    assert grid.d3[1:-1, 0] == pytest.approx(-0.6 * k**2 * np.cos(k * s), abs=1e-3)


def test_no_span_reaches_over_the_end_of_a_rapid_or_a_slow_element() -> None:
    """Elements of 0.05 mm at 60 mm/s, one that takes 10 s, and rapids: the first are spans of their own shape."""
    near = np.concatenate([np.linspace(0.0, 15.0, 301), [35.0], np.linspace(35.1, 50.0, 150)])
    shape = wavy(50.0, 3.0)

    class Mixed:
        length, breaks, find_joints = 50.0, near, staticmethod(shape.find_joints)

        @staticmethod
        def find_speed(s: np.ndarray) -> np.ndarray:
            return np.select([s < 15.0, s < 35.0], [60.0, 2.0], np.inf)

    grid, alone = build_grid_along(Mixed()), build_grid_along(Mixed(), 0, 300)
    assert np.array_equal(grid.s[1 : len(alone.s) - 1], alone.s[1:-1])
    assert np.count_nonzero(grid.s > 35.0) >= 4 * 150


def test_a_long_grid_is_solved_stretch_by_stretch(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the number of its points: the time stays, and few of them are worked on together."""
    section, top = wavy(400.0, 60.0, 60.0), limits(3)
    sizes: list[int] = []

    def solve(grid: Grid, top: Limits, *, start: float) -> np.ndarray:
        sizes.append(len(grid.s))
        return reachability.solve(grid, top, start=start)

    whole = bound_second_order_time(section, top, solve)
    points = sizes.pop()
    monkeypatch.setattr(tuning, "GRID_POINTS", points // 5)
    divided = bound_second_order_time(section, top, solve)
    assert len(sizes) in (5, 6)
    assert max(sizes) <= 1.5 * (points // 5) + 6
    assert divided == pytest.approx(whole, rel=1e-12)
