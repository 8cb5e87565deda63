"""Sections of few rows get along with fewer, inside every limit by independent differences."""

import numpy as np
import pytest

from verne_post.base.team import ALONE
from verne_post.trajectory import tuning
from verne_post.trajectory.continuous import plan_continuous
from verne_post.trajectory.fewer_rows import try_fewer_rows
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
