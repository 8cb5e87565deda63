"""Profiles become rows: whole cycles, standstills that are rows, the right line on each, blocks without seams."""

import numpy as np
import pytest

import verne_post
from verne_post.app.assemble import assemble
from verne_post.app.convert import make_setpoint_blocks
from verne_post.app.plan import Plan, plan_program
from verne_post.model.options import Options
from verne_post.output.rounding import choose_setpoint_format

from ..builders import MACHINE, OPTIONS

# lines: 2 start, 3 dwell, 4 out, 5 and 6 dwells, 7 sideways, 8 dwell and move, 9 arc, 10 up, 11 dwell
BODY = """G0 X0 Y0 Z40 A0 C0
G4 P0.0205
X3
G4 P0.007
G4 P0.1
G1 Y2 A4 F2000
G4 P0.013 X1
G2 I1 C5
G0 Z41
G4 P0.0301"""
DWELLS = {3: 0.0205, 5: 0.007, 6: 0.1, 8: 0.013, 11: 0.0301}
CYCLES = [0.00025, 0.001, 0.004]


def planned(body: str, cycle: float = 0.001, head: str = "G21 G90 G94 G17 G61.1") -> Plan:
    options = Options(tool_length=OPTIONS.tool_length, wcs=OPTIONS.wcs, cycle=cycle)
    return plan_program(assemble(f"{head}\n{body}\nM2\n".encode(), MACHINE, options))


def rows(plan: Plan) -> tuple[np.ndarray, np.ndarray]:
    """Values and lines of every row."""
    fmt = choose_setpoint_format(MACHINE, plan.program.cycle, None, accept_rounding=False)
    blocks = [block for block, _move in make_setpoint_blocks(plan, fmt)]
    assert [block.first for block in blocks] == [0, *np.cumsum([len(block.values) for block in blocks])[:-1]]
    return np.concatenate([block.values for block in blocks]), np.concatenate([block.line for block in blocks])


@pytest.mark.parametrize("cycle", CYCLES)
def test_sections_last_whole_cycles_and_are_stretched_by_less_than_one(cycle: float) -> None:
    plan = planned(BODY, cycle)
    cycles = np.diff(plan.timeline.first_row)[plan.timeline.section >= 0]
    stretch = cycles * cycle - plan.profiles.profiles.total
    assert len(cycles) == 5
    # a duration a billionth of a cycle above a whole number counts as that number
    assert (stretch >= -1e-9 * cycle).all()
    assert (stretch < cycle).all()
    values, line = rows(plan)
    assert len(values) == len(line) == plan.timeline.n_rows == plan.timeline.first_row[-1] + 1


@pytest.mark.parametrize("cycle", CYCLES)
def test_standstills_are_rows(cycle: float) -> None:
    """At the first row of each item the tool stands at a programmed corner, to the last written decimal."""
    plan = planned(BODY, cycle)
    values, _line = rows(plan)
    corners = [(0, 0, 40, 0, 0), (3, 0, 40, 0, 0), (3, 2, 40, 4, 0), (1, 2, 40, 4, 0)]
    corners += [(1, 2, 40, 4, 5), (1, 2, 41, 4, 5)]
    factor = np.array([column.factor for column in MACHINE.columns])
    stand = values[plan.timeline.first_row]
    found = [stand[0]]
    for row in stand[1:]:
        if (row != found[-1]).any():
            found.append(row)
    assert len(found) == len(corners)
    for row, corner in zip(found, corners, strict=True):
        tip, angles, ok = MACHINE.five_axis.find_nominal_pose(row / factor, 80.0)
        assert ok
        # half a unit of the seventh decimal of a slider, at most 5e-8 mm each, or of the sixth at 4 ms
        assert tip - [0, 0, 50] == pytest.approx(corner[:3], abs=2e-5 if cycle > 0.001 else 1e-6)
        assert np.degrees(angles) == pytest.approx(corner[3:], abs=2e-6 if cycle > 0.001 else 1e-7)


@pytest.mark.parametrize("cycle", CYCLES)
def test_dwell_rows_carry_the_dwell_and_are_exactly_as_many_as_it_needs(cycle: float) -> None:
    plan = planned(BODY, cycle)
    values, line = rows(plan)
    items = plan.timeline
    dwells = np.flatnonzero(items.section < 0)
    assert items.line[dwells].tolist() == list(DWELLS)
    for item, (number, seconds) in zip(dwells, DWELLS.items(), strict=True):
        first, last = items.first_row[item], items.first_row[item + 1]
        needed = int(np.ceil(round(seconds / cycle, 6)))  # 0.0205 s at 1 ms: 21 cycles
        assert last - first == needed
        assert (line[first:last] == number).all()
        assert (values[first : last + 1] == values[first]).all()  # the next motion starts there
    # the dwell at the end keeps the last row too; line 8 is a dwell and a move
    assert (line == 3).sum() == np.ceil(round(0.0205 / cycle, 6))
    assert (line == 11).sum() == np.ceil(round(0.0301 / cycle, 6)) + 1


@pytest.mark.parametrize("seconds", [0.0, 0.001, 0.002, 0.0029999999, 0.003, 0.0030000001, 1e-12])
def test_dwell_of_any_length_is_rounded_up(seconds: float) -> None:
    """However short it is, a dwell has a row to itself."""
    source = f"G21 G90 G94 G17\nG0 X0 Y0 Z20 A0 C0\nG4 P{seconds:.13f}\nX1\nG4 P{seconds:.13f}\nM2\n".encode()
    result = verne_post.convert(source, MACHINE, OPTIONS)
    assert [item.message for item in result.findings] == []
    assert result.setpoints is not None
    needed = max(int(np.ceil(seconds / 0.001 - 1e-9)), 1)
    assert (result.setpoints.line == 3).sum() == needed
    assert (result.setpoints.line == 5).sum() == needed + 1  # and the last row of the file


def test_row_at_a_joint_belongs_to_the_later_segment() -> None:
    plan = planned(BODY)
    values, line = rows(plan)
    path, items = plan.program.path, plan.timeline
    for item, section in enumerate(items.section):
        if section >= 0:
            first, last = items.first_row[item], items.first_row[item + 1]
            mine = path.line[path.section == section]
            assert line[first] == mine[0]
            assert line[last - 1] == mine[-1]
            assert (values[first + 1] != values[first]).any()  # the next row has moved
    assert line[-1] == 11
    assert (np.diff(line) >= 0).all()


def test_rows_inside_a_section_belong_to_the_segment_that_contains_them() -> None:
    """Collinear segments in one run: the line follows from where the tip is."""
    plan = planned("G0 X0 Y0 Z20 A0 C0\nG1 X1 F3000\nX1.5\nX1.503\nX4", head="G21 G90 G94 G17")
    values, line = rows(plan)
    assert plan.program.path.n_sections == 1
    factor = np.array([column.factor for column in MACHINE.columns])
    tip, _angles, ok = MACHINE.five_axis.find_nominal_pose(values / factor, 80.0)
    assert ok.all()
    inside = np.abs(tip[:, 0, None] - [1.0, 1.5, 1.503]).min(axis=1) > 1e-6  # written decimals cannot tell closer
    wanted = 3 + np.searchsorted([1.0, 1.5, 1.503], tip[:, 0])
    assert (line == wanted)[inside].all()
    assert set(line) >= {3, 4, 6}


def test_last_row_is_the_end_of_the_last_segment() -> None:
    plan = planned("G0 X0 Y0 Z20 A0 C0\nG1 X1 F1000\nG3 X-1 I-1 A5 C9")
    values, line = rows(plan)
    factor = np.array([column.factor for column in MACHINE.columns])
    tip, angles, _ok = MACHINE.five_axis.find_nominal_pose(values[-1] / factor, 80.0)
    assert line[-1] == 4
    assert tip == pytest.approx([-1.0, 0.0, 70.0], abs=1e-6)  # the written decimals
    assert np.degrees(angles) == pytest.approx([5.0, 9.0], abs=1e-7)


PROGRAMS: dict[str, str] = {
    "everything": BODY,
    "flow": "G0 X0 Y0 Z20 A0 C0\nG1 F3000\n" + "\n".join(f"X{0.02 * k:.2f}" for k in range(1, 100)),
    "dwell alone at the end": "G0 X0 Y0 Z20 A0 C0\nX1\nG4 P0.014",
}


@pytest.mark.parametrize("what", PROGRAMS)
@pytest.mark.parametrize("size", [1, 5, 64])
def test_blocks_join_without_seams(what: str, size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = planned(PROGRAMS[what], head="G21 G90 G94 G17")
    values, line = rows(plan)
    monkeypatch.setattr("verne_post.trajectory.sample.BLOCK_ROWS", size)
    small_values, small_line = rows(plan)
    assert (line == small_line).all()
    # the same rows; the iteration of the inverse kinematics may end a step earlier in a small block, which can
    # turn the last written decimal
    assert small_values == pytest.approx(values, abs=1.01e-7)


def test_small_blocks_through_the_whole_conversion(monkeypatch: pytest.MonkeyPatch) -> None:
    source = f"G21 G90 G94 G17\n{BODY}\nM2\n".encode()
    whole = verne_post.convert(source, MACHINE, OPTIONS)
    monkeypatch.setattr("verne_post.trajectory.sample.BLOCK_ROWS", 5)
    sizes: list[int] = []
    result = verne_post.convert(source, MACHINE, OPTIONS, sink=lambda block: sizes.append(len(block.values)))
    assert result.ok
    assert result.setpoints is None
    assert whole.setpoints is not None
    assert sum(sizes) == len(whole.setpoints.t)
    assert set(sizes[:-1]) == {5}
