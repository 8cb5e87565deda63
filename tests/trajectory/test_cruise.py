"""Where nothing is solved: ranges at the feed rate. The rows there are checked like all others, and cost no time."""

from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import verne_post
from verne_post.app import line_facts
from verne_post.app.assemble import assemble
from verne_post.app.plan import plan_program
from verne_post.base.arrays import Array
from verne_post.model.options import Options
from verne_post.trajectory import continuous, tuning
from verne_post.trajectory.continuous import plan_continuous
from verne_post.trajectory.cruise import find_cruise
from verne_post.trajectory.reachability import solve as second_order
from verne_post.trajectory.sample import BLOCK_ROWS, Rows, RowSampler
from verne_post.trajectory.section_path import build_grid_along

from ..builders import MACHINE, SAMPLES
from .curves import Curve, assert_legal, cornered, limits, straight


def stepped(s: Array) -> Array:
    """A feed that changes by 1 % every millimetre, and by a half at 60 mm."""
    return np.where(s < 60.0, 20.0, 10.0) * np.where(np.floor(s) % 2 == 0, 1.0, 0.99)


def test_a_range_begins_after_the_way_to_brake() -> None:
    section, top = straight(100.0, 50.0), limits(3)
    grid = build_grid_along(section)
    [(first, last)] = find_cruise(grid, second_order(grid, top), top, 1e-3)
    # v = 50, J = 1e5: 2 sqrt(v / J) = 45 ms, in which braking takes 1.1 mm
    assert 1.1 < first < 6.0
    assert 94.0 < last < 98.9


@pytest.mark.parametrize(("share", "found"), [(0.5, True), (0.9, False)])
def test_joints_near_a_limit_are_no_cruise(share: float, found: bool) -> None:
    """Even motion on a circle of 10 mm: v^2 / r of the acceleration, here as a share of it."""
    top = limits(3)
    feed = np.sqrt(share * top.acceleration[0] * 10.0)
    section = Curve(2000.0, lambda s: [10 * np.sin(s / 10), 10 * np.cos(s / 10), 0 * s], feed, 400)
    wide = limits(3, 833.0, 5000.0, 1e9)
    grid = build_grid_along(section)
    assert bool(len(find_cruise(grid, second_order(grid, wide), wide, 1e-3))) is found


@pytest.mark.parametrize("section", [straight(100.0, 30.0), straight(100.0, stepped)])  # type: ignore[arg-type]
@pytest.mark.parametrize("cycle", [2.5e-4, 1e-3, 4e-3])
def test_rows_are_legal_and_no_slower_than_solved_ones(
    section: Curve, cycle: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    top = limits(3)
    s = plan_continuous(section, top, cycle).s
    assert_legal(section, s, top, cycle)
    solved = continuous.plan_initial_profile

    def without(*arguments: Any) -> Any:
        found = solved(*arguments)
        assert len(found.cruise)
        return replace(found, cruise=np.empty((0, 2)))

    monkeypatch.setattr(continuous, "plan_initial_profile", without)
    assert len(s) <= 1.005 * len(plan_continuous(section, top, cycle).s) + 1


def test_a_corner_between_long_lines_is_solved() -> None:
    section, top = cornered(40.0, 2, 0.2, 50.0), limits(3)
    s = plan_continuous(section, top, 1e-3).s
    assert_legal(section, s, top, 1e-3)
    assert np.diff(s)[len(s) // 4 : -len(s) // 4].min() < 0.045


def test_pieces_that_are_solved_together_take_the_time_of_each_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    section, top = cornered(40.0, 6, 0.2, 50.0), limits(3)
    together = plan_continuous(section, top, 1e-3).s
    assert_legal(section, together, top, 1e-3)
    monkeypatch.setattr(tuning, "TOGETHER_VALUES", 0)
    alone = plan_continuous(section, top, 1e-3).s
    assert_legal(section, alone, top, 1e-3)
    # each is within 0.3 % of the time that its six corners take, some 40 ms each
    assert len(together) == pytest.approx(len(alone), abs=2)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("START_X", 0.3),
        ("START_X", 0.6),
        ("START_SLACK", 0.05),
        ("START_SLACK", 0.5),
        ("START_SLACK", 3.0),
        ("START_SMOOTH", 20),
    ],
)
def test_what_a_solution_starts_from_does_not_decide_the_time(
    name: str, value: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Pieces without a solution tied to the cruise beside them, and steps spoilt by rounding, once took twelve times as
    long.
    """
    source = (SAMPLES / "blade_5axis.nc").read_bytes()
    options = Options(tool_length=120.0, wcs={"G54": (0.0, 0.0, 10.0)})
    seconds = []
    for attribute in ("START_X", name):
        monkeypatch.setattr(tuning, attribute, getattr(tuning, attribute) if not seconds else value)
        result = verne_post.check(source, MACHINE, options)
        assert result.summary is not None, result.findings
        seconds.append(result.summary.cycle_time)
    assert seconds[1] == pytest.approx(seconds[0], rel=0.005)


def test_the_highest_effort_is_no_slower_where_the_feed_rate_is_kept() -> None:
    """It plans without a margin: rows that followed the feed rate were beyond it by rounding, and the section was
    slowed down.
    """
    turn = np.linspace(0, 2 * np.pi, 127)  # the flank of a cone that leans by 10 degrees
    sine, cosine, zero = np.sin(turn), np.cos(turn), np.zeros(127)
    half, lean = np.radians([15, 10])
    leaning = np.array([[1, 0, 0], [0, np.cos(lean), -np.sin(lean)], [0, np.sin(lean), np.cos(lean)]])
    tip = (leaning @ [20 * cosine, 20 * sine, zero]).T + [0, 0, 60]
    axis = leaning @ [-np.sin(half) * cosine, -np.sin(half) * sine, zero + np.cos(half)]
    a, c = np.degrees(np.arccos(axis[2])), np.degrees(np.unwrap(np.arctan2(axis[0], axis[1])))
    rows = ["X%.4f Y%.4f Z%.4f A%.4f C%.4f" % (*at, tilt, table) for at, tilt, table in zip(tip, a, c, strict=True)]
    source = "\n".join(["G21 G90 G94 G64 P0.01 F2000", f"G0 {rows[0]}", *(f"G1 {row}" for row in rows[1:]), "M2\n"])
    seconds = {}
    for quality in (False, True):
        result = verne_post.check(source.encode(), MACHINE, Options(tool_length=80.0, quality=quality))
        assert result.summary is not None, result.findings
        seconds[quality] = result.summary.cycle_time
    assert seconds[True] <= seconds[False]


def test_the_cost_of_a_very_slow_line_does_not_depend_on_its_time() -> None:
    """A mistyped feed rate: the profiles of an hour are no longer than those of minutes."""
    kept = []
    for feed in (3.0, 0.3):
        source = f"G21 G90 G94 G17\nG0 X0 Y0 Z60\nG1 X20 F{feed}\nY20 F1000\nX0\nM2\n".encode()
        plan = plan_program(assemble(source, MACHINE, Options(tool_length=80.0)))
        seconds = plan.timeline.n_rows * plan.timeline.cycle
        assert seconds == pytest.approx(20 * 60 / feed + 2.4, rel=1e-3)
        kept.append(len(plan.profiles.continuous_s))
    assert kept[0] == kept[1] < 5000


def test_the_facts_of_a_very_slow_line_are_those_of_all_its_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten minutes of a line, and half a minute of an arc with the table turning."""
    source = b"G21 G90 G94 G17\nG0 X0 Y0 Z60 A0 C0\nG1 X10 F1\nG2 X20 C90 I5 F20\nG1 X0 F1000\nM2\n"
    plan = plan_program(assemble(source, MACHINE, Options(tool_length=80.0)))
    made = list[int]()
    make_rows = RowSampler.make_rows

    def count(sampler: RowSampler, first: int) -> Rows:
        made.append(first)
        return make_rows(sampler, first)

    monkeypatch.setattr(RowSampler, "make_rows", count)
    few, n_few = line_facts.measure_lines(plan), len(made)
    monkeypatch.setattr(line_facts, "_BLOCKS", 10**6)
    every = line_facts.measure_lines(plan)
    assert 1.5 * n_few < len(made) - n_few == -(-plan.timeline.n_rows // BLOCK_ROWS)
    assert few.held_by == every.held_by
    for name in ("line", "seconds", "nearest"):
        np.testing.assert_array_equal(getattr(few, name), getattr(every, name))
    for name in ("speed", "margin"):
        np.testing.assert_allclose(getattr(few, name), getattr(every, name), rtol=1e-4)
