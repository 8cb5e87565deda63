"""Sections of few rows get along with fewer, inside every limit by independent differences."""

from dataclasses import replace

import numpy as np
import pytest

from verne_post.base.team import ALONE
from verne_post.trajectory import tuning
from verne_post.trajectory.continuous import plan_continuous
from verne_post.trajectory.fewer_rows import try_fewer_rows
from verne_post.trajectory.row_limits import add_rest
from verne_post.trajectory.row_shifts import shift_rows
from verne_post.trajectory.section_path import SectionTask

from .curves import Curve, assert_legal, cornered, limits, straight, wavy

TOP = limits(3)
SECTIONS = (straight(1.0, 50.0), wavy(1.5, 4.0), cornered(0.4, 4, 0.1, 50.0))


def task_of(section: Curve, cycle: float) -> SectionTask:
    return SectionTask(section, TOP, cycle, max(tuning.TIME_UNIT, cycle), np.empty((0, 2)), team=ALONE)


@pytest.mark.parametrize("section", SECTIONS)
@pytest.mark.parametrize("cycle", [4e-3, 1e-2])
def test_rows_with_time_to_spare_become_fewer(section: Curve, cycle: float) -> None:
    planned = plan_continuous(section, TOP, cycle).s
    weaker = limits(3, acceleration=5000.0 / 1.5**2, jerk=1e5 / 1.5**3)
    slow = plan_continuous(section, weaker, cycle).s
    fewer = try_fewer_rows(task_of(section, cycle), slow)
    assert_legal(section, fewer, TOP, cycle)
    assert fewer[0] == 0.0
    assert fewer[-1] == section.length
    assert len(fewer) < len(slow) <= tuning.FEW_ROWS
    assert len(fewer) <= 1.1 * len(planned) + 1


def test_short_sections_are_planned_with_fewer_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    counts = []
    for most in (0, tuning.FEW_ROWS):
        monkeypatch.setattr(tuning, "FEW_ROWS", most)
        counts.append([len(plan_continuous(section, TOP, cycle).s) for section in SECTIONS for cycle in (4e-3, 1e-2)])
    before, after = np.array(counts)
    assert (after <= before).all()
    assert after.sum() < 0.99 * before.sum()


def test_longer_sections_stay_as_they_are() -> None:
    section = straight(1.0, 50.0)
    rows = np.linspace(0.0, 1.0, tuning.FEW_ROWS + 1)
    assert try_fewer_rows(task_of(section, 1e-3), rows) is rows


@pytest.mark.parametrize("pitch", [0.005, 0.01])
def test_sections_of_far_more_elements_than_rows_take_far_fewer(pitch: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A zigzag whose corners are smaller than the steps between its rows: no profile of it is near its fastest rows."""
    section, cycle = cornered(pitch, 30, 0.4 * pitch, 50.0), 4e-3
    monkeypatch.setattr(tuning, "CROWDED_ELEMENTS", np.inf)
    monkeypatch.setattr(tuning, "SINGLE_ROWS", 0)
    before = plan_continuous(section, TOP, cycle).s
    monkeypatch.undo()
    after = plan_continuous(section, TOP, cycle).s
    assert_legal(section, after, TOP, cycle)
    assert len(after) < 0.5 * len(before)


def test_no_step_over_many_elements_is_faster_than_the_feed() -> None:
    """A feed that is low in every third element: the ends and the middle of a step may all be in the others."""
    section = cornered(0.005, 100, 0.002, 50.0)
    section = replace(section, feed=lambda s: np.where((s / 0.00125).astype(int) % 3, 50.0, 5.0))
    s = plan_continuous(section, TOP, 1e-2).s
    places = (s[:-1] + (np.arange(1000)[:, None] + 0.5) / 1000 * np.diff(s)).ravel()
    spent = np.diff(s) * np.mean(1.0 / section.find_speed(places).reshape(1000, -1), axis=0)
    assert spent.max() <= 1.02 * 1e-2  # the integral over so many jumps is known so well


def test_rows_that_are_shifted_together_are_shifted_as_each_alone() -> None:
    section, cycle = wavy(1.5, 4.0), 4e-3
    task = task_of(section, cycle)
    x = np.linspace(0.0, 1.0, 12)
    starts = [add_rest(section.length * x**power * (1.0 + power - power * x)) for power in (1.0, 1.5, 2.0)]
    n = len(starts[0])
    together = shift_rows(np.concatenate(starts), np.full(3, n), n, task).s.reshape(3, n)
    for rows, start in zip(together, starts, strict=True):
        assert (np.diff(rows) >= 0.0).all()
        assert rows == pytest.approx(shift_rows(start, np.array([n]), n, task).s, abs=1e-9)
