"""What the interior point method sees of windows: how they are laid end to end, differences at points, the tightest
rows.
"""

import numpy as np
import pytest
from msgspec.structs import replace

from verne_post.model.machine import Limits
from verne_post.trajectory import tuning
from verne_post.trajectory.section_path import SectionTask
from verne_post.trajectory.spline_profile import Profile
from verne_post.trajectory.tuning import PassSettings
from verne_post.trajectory.window_problem import (
    TIED,
    Layout,
    Window,
    _Samples,
    build_window_problem,
    choose_largest_rows,
)

from .curves import Curve


@pytest.mark.parametrize("rows", [2, 3, 6, 8, 9])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_largest_come_first(rows: int, count: int) -> None:
    random = np.random.default_rng(rows)
    scores = random.normal(size=(rows, 500)) * 10.0 ** random.uniform(-6, 6, size=(rows, 500))
    before = scores.copy()
    chosen = choose_largest_rows(scores, min(count, rows - 1))
    np.testing.assert_array_equal(scores, before)
    wanted = np.argsort(-scores, axis=0, kind="stable")[: len(chosen)]
    np.testing.assert_array_equal(chosen, wanted)


def test_equal_scores_give_different_rows() -> None:
    for value in (0.0, 1.0, -1.0, -0.0):
        chosen = choose_largest_rows(np.full((6, 4), value), 3)
        assert all(len(set(column)) == 3 for column in chosen.T.tolist())
        assert (chosen >= 0).all() and (chosen < 6).all()


@pytest.mark.parametrize(
    ("knot", "cycle"), [(8, 1), (4, 1), (2, 1), (1, 1), (8, 4), (8, 2), (8, 0.25), (3, 0.7), (8, 10)]
)
@pytest.mark.parametrize("k", [2, 3, 4])
def test_differences_are_those_around_each_point(knot: float, cycle: float, k: int) -> None:
    """However points share samples: of q = s = t^3 the third difference is 6, the second one 6 t."""
    knots = np.arange(3.0, 10.0)
    samples = _Samples.build(knots, knot, k, cycle)
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
    assert layout.list_knots().tolist() == [*range(10, 14 + gap), 20]
    assert layout.find_gaps().tolist() == [False] * 4 + [True] * gap + [False]
    assert layout.find_held().tolist() == [False] * 4 + [True] * (gap + 3) + [False]
    for window, part in zip(layout.windows, layout.split(layout.start()), strict=True):
        assert part.tolist() == window.start.tolist()


# --- constraints against the formulas of interior_point.py ----------------------------------------

UNIT, SPEED = 2e-3, 50.0
#: Joints c1 s + c2 s^2 + c3 s^3, one of them at rest; of such joints the second and third differences are the
#: derivatives.
CUBICS = np.array([[1.0, 0.3, 0.02], [-0.6, 0.1, -0.05], [0.0, 0.0, 0.0], [0.2, -0.5, 0.01]])
SETTINGS = PassSettings(
    knot_units=4,
    points_per_knot=3,
    tightest_rows=(0, 0),
    largest_x=3.0,
    start_gap=1.0,
    final_gap=1.0,
    iterations=1,
    shares=(0.9, 0.8, 0.7),
)


class Even(Profile, frozen=True, eq=False):
    """s grows evenly."""

    def find_s(self, sigma: np.ndarray) -> np.ndarray:
        return SPEED * sigma


def _task(cycle: float, feed: object, velocity: float) -> SectionTask:
    curve = Curve(1e3, lambda s: [c[0] * s + c[1] * s**2 + c[2] * s**3 for c in CUBICS], feed)  # type: ignore[arg-type]
    n = len(CUBICS)
    full, spread = np.full(n, np.inf), np.linspace(1.0, 2.0, n)
    limits = Limits(-full, full, velocity * spread, 4e3 * spread, 2e5 * spread[::-1], 0.0)
    return SectionTask(curve, limits, cycle, UNIT)


def _problem(task: SectionTask, settings: PassSettings):  # type: ignore[no-untyped-def]
    """Two windows with a gap; problem, intervals in the gap, the intervals that are held, and times (k, n) of the
    points.
    """
    windows = [
        Window(10, 19, np.ones(12), begin_tied=True, end_tied=True),
        Window(30, 36, np.ones(9), begin_tied=True, end_tied=False),
    ]
    layout = Layout.build(windows, task, settings)
    problem = build_window_problem(task, Even(np.zeros(6), 1.0), settings, layout)
    n, gap = 15 + layout.gap, layout.gap
    in_gap = np.zeros(n, dtype=bool)
    in_gap[9 : 9 + gap] = True
    held = np.zeros(n, dtype=bool)
    held[[*range(TIED), *range(9 - TIED, 9), *range(9 + gap, 9 + gap + TIED)]] = True
    knots = np.array([*range(10, 19 + gap), *range(30, 36)])
    return problem, in_gap, held, (knots + problem.phases[:, None]) * settings.knot_units * UNIT


def _derivatives(t: np.ndarray, cycle: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Joints' derivatives (n_joints, points) by pseudo-time; the first one over a cycle."""
    s = SPEED * t.ravel()
    c1, c2, c3 = (column[:, None] for column in CUBICS.T)
    first = (c1 + 2 * c2 * s + 3 * c3 * s**2) * SPEED + c3 * SPEED**3 * cycle**2 / 4
    return first, (2 * c2 + 6 * c3 * s) * SPEED**2, np.broadcast_to(6 * c3 * SPEED**3, first.shape)


@pytest.mark.parametrize("cycle", [UNIT, 4 * UNIT, 12 * UNIT, 1.3 * UNIT])
def test_largest_rates_are_those_of_joints_and_feed(cycle: float) -> None:
    """The feed rate is that of the slower of the two rows, half a cycle before and after a point; here it varies within
    one.
    """

    def feed(s: np.ndarray) -> np.ndarray:
        return 40.0 + 25.0 * np.sin(2.0 * np.pi * s / (SPEED * 1.7 * cycle)) + 20.0 * np.sin(11.0 * s)

    task = _task(cycle, feed, 400.0)
    problem, in_gap, held, t = _problem(task, SETTINGS)
    slower = np.minimum(feed(SPEED * (t - cycle / 2)), feed(SPEED * (t + cycle / 2)))
    by_feed = (0.9 * slower / SPEED) ** 2
    q1 = np.abs(_derivatives(t, cycle)[0]).reshape(len(CUBICS), *t.shape)
    with np.errstate(divide="ignore"):
        by_joints = ((0.9 * task.limits.velocity[:, None, None] / q1) ** 2).min(axis=0)
    expected = np.clip(np.minimum(by_feed, by_joints), 2 * tuning.SMALLEST_X, SETTINGS.largest_x)
    for bound in (by_feed, by_joints):
        assert (expected == bound)[:, ~in_gap].any()
    # held coefficients may be as fast as rows may reach
    expected[:, held] *= (tuning.ACCEPTED_RATIOS[0] / tuning.PLANNED_SHARES[0]) ** 2
    cap = problem.cap.reshape(t.shape)
    np.testing.assert_allclose(cap[:, ~in_gap], expected[:, ~in_gap], rtol=1e-9)
    assert (cap[:, in_gap] > SETTINGS.largest_x).all()


def _values(rows: tuple[np.ndarray, ...], x: np.ndarray) -> np.ndarray:
    """What rows give for X and its derivatives."""
    return sum(row * value for row, value in zip(rows, x, strict=False))


@pytest.mark.parametrize("cycle", [UNIT, 4 * UNIT, 1.3 * UNIT])
@pytest.mark.parametrize("tightest", [(0, 0), (2, 3), (1, 2)])
def test_rows_are_acceleration_and_jerk_over_their_limits(cycle: float, tightest: tuple[int, int]) -> None:
    """For any X the rows of each side are the motion of joints by the formulas: all, or those that can be tight
    first.
    """
    task = _task(cycle, np.inf, 1e4)
    problem, in_gap, _held, t = _problem(task, replace(SETTINGS, tightest_rows=tightest))
    q1, q2, q3 = _derivatives(t, cycle)
    rest = np.zeros((1, t.size))
    acceleration = (
        np.concatenate([q2 / (0.8 * task.limits.acceleration[:, None]), rest]),
        np.concatenate(
            [q1 / (1.6 * task.limits.acceleration[:, None]), rest + UNIT / (2 * tuning.VIRTUAL_ACCELERATION)]
        ),
    )
    by_jerk = 0.7 * task.limits.jerk[:, None]
    jerk = (
        np.concatenate([q3 / by_jerk, rest]),
        np.concatenate([1.5 * q2 / by_jerk, rest]),
        np.concatenate([0.5 * q1 / by_jerk, rest + UNIT**2 / (2 * tuning.VIRTUAL_JERK)]),
    )
    random = np.random.default_rng(3)
    some_x = [np.array([random.uniform(0.1, 2.0), *random.normal(scale=100.0 ** np.arange(1, 3))]) for _ in range(4)]
    outside = np.broadcast_to(~in_gap, t.shape).ravel()
    for got, wanted, count in zip((problem.acceleration, problem.jerk), (acceleration, jerk), tightest, strict=True):
        assert all((row[:, ~outside] == 0.0).all() for row in got)
        top = np.abs(wanted[-1])
        upper = tuple(row * np.where(wanted[-1] < 0, -1.0, 1.0) for row in wanted)
        sides = []
        for sign in (1.0, -1.0):
            side = tuple(sign * row for row in upper)
            if count:  # near the limit now, or when the highest derivative reaches what some row allows
                order = np.argsort(-(side[0] + top / top.max(axis=0)), axis=0)[:count]
                side = tuple(np.take_along_axis(row, order, axis=0) for row in side)
            sides.append(side)
        expected = tuple(np.concatenate(pair) for pair in zip(*sides, strict=True))
        for x in some_x:
            values, those = (np.sort(_values(rows, x)[:, outside], axis=0) for rows in (got, expected))
            np.testing.assert_allclose(values, those, rtol=1e-4, atol=1e-4 * np.abs(those).max())
