"""Profiles of continuous sections, checked on the differences of their rows by independent code."""

from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from verne_post.trajectory import continuous, repair, tuning
from verne_post.trajectory.continuous import plan_continuous
from verne_post.trajectory.reachability import find_duration as profile_duration
from verne_post.trajectory.reachability import solve as second_order
from verne_post.trajectory.section_path import SectionTask, build_grid_along
from verne_post.trajectory.stop_to_stop import find_duration
from verne_post.trajectory.tuning import QUALITY, Effort

from .curves import Curve, assert_legal, cornered, limits, straight, wavy


@pytest.mark.parametrize(("length", "feed"), [(0.01, np.inf), (1.0, 50.0), (30.0, 50.0), (300.0, np.inf), (2.0, 0.5)])
def test_straight_lines_take_the_time_of_the_seven_phases(length: float, feed: float) -> None:
    section, top = straight(length, feed), limits(3)
    s = plan_continuous(section, top, 1e-3).s
    assert_legal(section, s, top, 1e-3)
    best = find_duration(*(np.array([v]) for v in (length, min(feed, 833.0), 5000.0, 1e5)))[0]
    # 1 % of loss, and two cycles for the ends and the whole number of cycles
    assert (len(s) - 1) * 1e-3 <= best * 1.01 + 2e-3


@pytest.mark.parametrize("cycle", [125e-6, 5e-4, 1e-3, 2e-3, 1e-2])
def test_every_cycle(cycle: float) -> None:
    section, top = cornered(1.0, 6, 0.2, 50.0), limits(3)
    assert_legal(section, plan_continuous(section, top, cycle).s, top, cycle)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("share", [0.1, 10.0])
def test_every_scale(scale: float, share: float) -> None:
    section = wavy(1.5 * scale, 4.0)
    top = limits(3, acceleration=5000 * share, jerk=1e5 * share * share)
    s = plan_continuous(section, top, 1e-3).s
    assert_legal(section, s, top, 1e-3)
    grid = build_grid_along(section)
    assert (len(s) - 1) * 1e-3 >= 0.98 * profile_duration(grid.s, second_order(grid, top))


def test_blends_are_within_two_percent_of_the_fine_solution() -> None:
    section, top = cornered(1.0, 12, 0.25, 50.0), limits(3)
    s, fine = plan_continuous(section, top, 1e-3).s, plan_continuous(section, top, 1e-3, QUALITY).s
    assert_legal(section, s, top, 1e-3)
    assert_legal(section, fine, top, 1e-3)
    assert len(s) <= 1.02 * len(fine)


def test_a_section_that_cannot_be_repaired_is_planned_finely(monkeypatch: pytest.MonkeyPatch) -> None:
    section, top = cornered(1.0, 3, 0.25, 50.0), limits(3)
    fine = plan_continuous(section, top, 1e-3, QUALITY).s
    planned = continuous._plan_with_effort

    def without_repair(task: Any, profile: Any, bound: float, effort: Effort) -> Any:
        found = planned(task, profile, bound, effort)
        return found if effort is QUALITY else replace(found, rows=None)

    monkeypatch.setattr(continuous, "_plan_with_effort", without_repair)
    assert np.array_equal(plan_continuous(section, top, 1e-3).s, fine)


@pytest.mark.parametrize(
    ("pitch", "corners", "cycle", "fewer"), [(1.0, 5, 0.02, 3), (1.5, 6, 0.01, 5), (2.0, 4, 0.01, 2)]
)
def test_a_short_section_loses_the_rows_that_repair_added(
    pitch: float, corners: int, cycle: float, fewer: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    section, top = cornered(pitch, corners, 0.4, 50.0), limits(3)
    s = plan_continuous(section, top, cycle).s
    assert_legal(section, s, top, cycle)
    assert len(s) <= tuning.SINGLE_ROWS - fewer
    monkeypatch.setattr(tuning, "SINGLE_ROWS", 0)
    assert len(plan_continuous(section, top, cycle).s) >= len(s) + fewer


def test_a_feed_that_changes_is_kept_on_both_sides() -> None:
    section, top = straight(30.0, lambda s: np.where((s > 10) & (s < 20), 8.0, 100.0)), limits(3)  # type: ignore[arg-type]
    s = plan_continuous(section, top, 1e-3).s
    assert_legal(section, s, top, 1e-3)
    speed = np.diff(s) / 1e-3
    middle = 0.5 * (s[1:] + s[:-1])
    assert speed[(middle > 11) & (middle < 19)].min() > 7.9
    assert speed[middle < 9].max() > 90.0


def test_a_section_over_several_windows() -> None:
    section, top = wavy(120.0, 60.0, 12.0), limits(3)
    s = plan_continuous(section, top, 1e-3).s
    assert len(s) > 9000
    assert_legal(section, s, top, 1e-3)


def test_random_sections() -> None:
    rng = np.random.default_rng(11)
    for _ in range(12):
        scale, waves = 10.0 ** rng.uniform(-2, 2), rng.uniform(0.5, 10)
        k = 2 * np.pi * waves / scale
        a, p = rng.normal(size=(3, 2)) / k, rng.uniform(0, 6, (3, 2))

        def joints(s: np.ndarray, k: float = k, a: np.ndarray = a, p: np.ndarray = p) -> list[np.ndarray]:
            return [a[i, 0] * np.sin(k * s + p[i, 0]) + a[i, 1] * np.sin(2 * k * s + p[i, 1]) for i in range(3)]

        section = Curve(scale, joints, scale * 10.0 ** rng.uniform(-0.3, 2), int(10 * waves) + 1)
        top = limits(3, *(b * 10.0 ** rng.uniform(-1, 1) for b in (833.0, 5000.0, 1e5)))
        cycle = float(rng.choice([5e-4, 1e-3, 4e-3]))
        assert_legal(section, plan_continuous(section, top, cycle).s, top, cycle)


def test_rows_that_are_beyond_the_limits_are_repaired_in_place() -> None:
    section, top = straight(30.0), limits(3)
    s = plan_continuous(section, top, 1e-3).s
    spoilt = s.copy()
    spoilt[len(s) // 2] += 5e-5  # 0.15 to 1.5 times the jerk limit in the four differences around
    assert_legal(
        section, repair.repair_or_slow_down(SectionTask(section, top, 1e-3, 1e-3), lambda _slower: spoilt), top, 1e-3
    )


@pytest.mark.parametrize("apart", range(83, 90))
def test_stretches_that_nearly_touch_stay_in_order(apart: int) -> None:
    section, top = straight(30.0, 60.0), limits(3)
    spoilt = plan_continuous(section, top, 1e-3).s
    spoilt[[200, 200 + apart]] += 3.5e-5  # 1.05 times the jerk limit at constant speed
    assert_legal(
        section, repair.repair_or_slow_down(SectionTask(section, top, 1e-3, 1e-3), lambda _slower: spoilt), top, 1e-3
    )


def test_a_profile_beyond_repair_is_slowed_down() -> None:
    section, top = straight(30.0), limits(3)
    asked = []

    def rows(slower: float) -> np.ndarray:
        asked.append(slower)
        w = np.linspace(0, 1, int(30 * slower) + 2)  # 30 ms for what takes 200
        return 30.0 * w**4 * (35 - 84 * w + 70 * w**2 - 20 * w**3)

    s = repair.repair_or_slow_down(SectionTask(section, top, 1e-3, 1e-3), rows)
    assert_legal(section, s, top, 1e-3)
    assert len(asked) < 100


@pytest.mark.parametrize(
    ("section", "message"),
    [
        (Curve(5.0, lambda s: [np.where(s > 2, np.nan, s)]), "not finite"),
        (Curve(5.0, lambda s: [np.where(s > 2, 0.5, 0.0) + s]), "joints jump"),
    ],
)
def test_sections_without_a_profile_are_refused(section: Curve, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        plan_continuous(section, limits(1), 1e-3)


@pytest.mark.parametrize("cycle", [0.0, -1e-3, np.nan])
def test_cycles_that_are_none_are_refused(cycle: float) -> None:
    with pytest.raises(ValueError, match="must be finite and above 0"):
        plan_continuous(straight(1.0), limits(3), cycle)
