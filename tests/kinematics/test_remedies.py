"""Where a bound is worst along a line: against dense samples of the same quantities."""

from dataclasses import replace

import numpy as np
import pytest

from verne_post.app.assemble import assemble
from verne_post.kinematics.checks.clearance import check_constraints
from verne_post.kinematics.checks.line_measures import list_checks, measure
from verne_post.kinematics.checks.remedies import TURNS, find_legal_branches, find_worst_places, place_of, select_line

from ..builders import MACHINE, OPTIONS

#: Line 2 is a circle whose table turns, line 3 a straight line with a turn.
SOURCE = b"G21 G90 G94 G17 G0 X0 Y0 Z60 A0 C0\nG2 I40 F2000 A9 C70\nG1 X90 Y-20 Z50 A-15 C-40\nM2\n"


@pytest.mark.parametrize("line", [2, 3])
def test_the_worst_place_is_found_between_samples(line: int) -> None:
    """To the last digits of the value: a smooth quantity is as bad beside its worst place, by the square of how far
    beside.
    """
    motion = select_line(assemble(SOURCE, MACHINE, OPTIONS).build_joint_path(), line)
    n, dense = len(motion.contour), np.linspace(0.0, 1.0, 20001)
    values = measure(motion, np.repeat(np.arange(n), len(dense)), np.tile(dense, n))[0]
    checks = list_checks(motion)
    inside = 0
    for check, found in zip(checks, find_worst_places(motion, checks), strict=True):
        assert found is not None
        series = check.sign * values[:, check.quantity]
        place, value = found
        if not np.isfinite(series).all():  # a height over the table that the tool leaves
            continue
        assert check.sign * value <= series.min() + 1e-12 * abs(series.min())
        assert check.sign * value == pytest.approx(series.min(), rel=1e-5, abs=1e-7)
        assert measure(motion, np.array([place.element]), np.array([place.w]))[0][0, check.quantity] == value
        inside += 0.0 < place.w < 1.0 and abs(place.w * 64 - round(place.w * 64)) > 1e-3
    assert inside >= 3


@pytest.mark.parametrize("most", [2.9, 4.4])
def test_turns_of_c_within_its_travel_are_branches_the_nearest_first(most: float) -> None:
    """Up to three turns either way where C has limits; an upright tool may stand on the other solution too."""
    travel = np.array([-most, most]) * 2 * np.pi
    limits = replace(
        MACHINE.limits,
        lower=np.append(MACHINE.limits.lower[:-1], travel[0]),
        upper=np.append(MACHINE.limits.upper[:-1], travel[1]),
    )
    source = b"G21 G90 G94 G17 G0 X0 Y0 Z60 A0 C0\nG1 X40 F2000\nM2\n"
    motion = select_line(assemble(source, replace(MACHINE, limits=limits), OPTIONS).build_joint_path(), 2)
    found = [(one.flip, one.turns) for one in find_legal_branches(motion)]
    reached = [(flip, turn) for flip in (0, 1) for turn in range(-TURNS, TURNS + 1) if abs(turn + 0.5 * flip) < most]
    assert sorted(found) == sorted(set(reached) - {(0, 0)})
    assert [abs(turn) for _flip, turn in found] == sorted(abs(turn) for _flip, turn in found)


def test_a_finding_without_a_value_is_where_the_line_gets_out_of_reach() -> None:
    source = b"G21 G90 G94 G17 G0 X0 Y0 Z60 A0 C0\nG1 X2000 Z300 F2000\nM2\n"
    motion = select_line(assemble(source, MACHINE, OPTIONS).build_joint_path(), 2)
    (item,) = (one for one in check_constraints(motion)[1] if one.code == "VP110")
    assert item.value is None
    place = place_of(motion, item)
    assert place is not None
    w = np.linspace(0.0, 1.0, 100001)
    solved = motion.solve(np.zeros(len(w), dtype=np.intp), w).ok
    assert not solved.all()
    assert place.w == pytest.approx(w[np.argmin(solved)], abs=1e-5)


def test_a_finding_with_a_value_is_where_the_line_has_it() -> None:
    source = b"G21 G90 G94 G17 G0 X0 Y0 Z60 A0 C0\nG1 X300 Y-300 Z600 F2000\nM2\n"
    motion = select_line(assemble(source, MACHINE, OPTIONS).build_joint_path(), 2)
    items = [one for one in check_constraints(motion)[1] if one.value is not None]
    assert items
    for item in items:
        place = place_of(motion, item)
        assert place is not None
        values = measure(motion, np.array([place.element]), np.array([place.w]))[0][0]
        found = [
            values[check.quantity] * check.factor
            for check in list_checks(motion)
            if (check.code, check.axis) == (item.code, item.axis)
        ]
        assert min(abs(value - item.value) for value in found) < 1e-3
