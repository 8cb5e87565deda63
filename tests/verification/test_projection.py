"""Lengths along arcs, and the nearest pose where the tip and the rotary axes disagree, as verification measures them,
by hand.
"""

import numpy as np
import pytest

from verne_post.app.assemble import assemble
from verne_post.model.machine import Machine
from verne_post.verification.programmed import (
    RADIAN_MM,
    find_programmed_pose,
    find_tip_paces,
    measure_lengths_to,
    measure_metric_lengths,
    measure_progress_lengths,
)
from verne_post.verification.projection import Measured, measure_deviation_nearby, measure_off_segment

from ..builders import OPTIONS

#: A half circle of 10 mm, and two turns of 5 mm, 5 mm down, while C turns by 40 degrees.
SOURCE = b"G21 G90 G17 G94 F1000\nG0 X0 Y0 Z60 A0 C0\nG2 X20 I10\nG3 X20 Y0 I5 J0 P2 Z55 C40\nM2\n"


def test_lengths_of_arcs_have_all_their_parts(machine: Machine) -> None:
    path = assemble(SOURCE, machine, OPTIONS).path
    arcs = np.flatnonzero(path.arc >= 0)
    unused = np.full(len(path), np.nan)  # lengths of lines are given
    expected = [np.pi * 10, np.sqrt((20 * np.pi) ** 2 + 5**2 + (RADIAN_MM * np.radians(40)) ** 2)]
    for u in (0.0, 0.25, 1.0, -0.1):
        got = measure_lengths_to(path, arcs, np.full(len(arcs), u), unused)
        assert np.allclose(got, u * np.array(expected), rtol=1e-9, atol=1e-12)


def test_every_segment_takes_its_time_at_its_feed(machine: Machine) -> None:
    """Of a line, an arc and three splines, the first of them too: seconds for a mm times the length that the
    path has.
    """
    source = (
        b"G21 G90 G17 G94 F1000\nG0 X0 Y0 Z60 A0 C0\nG5 X10 Y0 I3 J9 P-3 Q9\nG5 X20 Y4 I3 J-9 P-3 Q5\nG5 X30 Y0 I2 J2 "
        b"P-3 Q3\n"
        b"G1 X40\nG2 X50 I5\nM2\n"
    )
    path = assemble(source, machine, OPTIONS).path
    feeding = np.flatnonzero(path.line > 2)
    assert (path.spline[feeding] >= 0).sum() >= 3
    pace = find_tip_paces(path)
    assert np.allclose(pace[feeding] * path.length[feeding], path.feed_time[feeding], rtol=1e-6)
    assert np.allclose(pace[feeding], 60 / 1000, rtol=1e-6)


def test_lengths_of_splines_are_those_of_their_points(machine: Machine) -> None:
    """The first piece of the path too, which turns: sums of small steps along each, to its end and beyond."""
    source = (
        b"%\nO1 (A)\nG21 G90 G94 G17 G61\nG0 X0 Y0 Z60 A0 C0\nF1000\n"
        b"G6.2 P3 K0 X0 Y0 Z60 A0 C0 R1\nK0 X10 Y20 Z60 A-3 C5 R1\nK0 X30 Y0 Z62 A-9 C30 R1\nK1 X40 Y9 Z60 A-5 C30 "
        b"R1\nK2\nK2\nK2\n"
        b"M30\n%\n"
    )
    path = assemble(source, machine, OPTIONS).path
    spline = np.flatnonzero(path.spline >= 0)
    assert (path.spline[spline] == 0).any()
    metric = measure_metric_lengths(path)
    share = np.linspace(0.0, 1.0, 4001)
    tips = []
    for k in spline:
        tip, angles = find_programmed_pose(path, np.full(len(share), k), share)
        moved = np.linalg.norm(np.diff(tip, axis=0), axis=1)
        along = np.append(0.0, np.cumsum(np.hypot(moved, RADIAN_MM * np.linalg.norm(np.diff(angles, axis=0), axis=1))))
        tips.append(moved.sum())
        u = np.array([0.0, 0.25, 0.5, 1.0, 1.1, -0.1])
        expected = np.append(along[[0, 1000, 2000, 4000]], along[-1] * np.array([1.1, -0.1]))
        assert measure_lengths_to(path, np.full(len(u), k), u, metric) == pytest.approx(expected, rel=1e-5, abs=1e-6)
    assert measure_progress_lengths(path, metric)[spline] == pytest.approx(tips, rel=1e-5)
    others = np.setdiff1d(np.arange(len(path)), spline)
    assert measure_progress_lengths(path, metric)[others].tolist() == metric[others].tolist()


# --- the pose nearby that is nearest in both tolerances -----------------------------------------

#: Tip 100 mm along X and 20 mm up while A and C turn, a rapid before it.
LINE = b"G21 G90 G17 G94 F1000\nG0 X0 Y0 Z60 A0 C0\nG1 X100 Z80 A10 C-25\nM2\n"
TIP_BOUND, ANGLE_BOUND = 0.02, 0.0005


def _axis(a: float, c: float) -> np.ndarray:
    return np.array([np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)])


@pytest.mark.parametrize("count", [1, 7])
def test_a_pose_of_the_segment_has_no_deviation(machine: Machine, count: int) -> None:
    """Wherever on the segment; poses beside it are 1e-8 mm away or more."""
    path = assemble(LINE, machine, OPTIONS).path
    segment = np.full(count, np.flatnonzero(path.line == 3)[0])
    u = np.linspace(0.1, 0.9, count)
    on = path.start[segment] + u[:, None] * (path.end - path.start)[segment]
    measured = Measured(np.zeros((count, 5)), on[:, :3], on[:, 3:])
    bounds = np.full(count, TIP_BOUND), np.full(count, ANGLE_BOUND)
    reach = 2 * (bounds[0] + RADIAN_MM * bounds[1]) / measure_metric_lengths(path)[segment]
    tip, axis, rotary = measure_deviation_nearby(path, segment, u, measured, *bounds, reach)
    assert tip.max() < 1e-12
    assert max(axis.max(), rotary.max()) < 1e-14


def test_the_nearest_pose_in_both_tolerances_is_found(machine: Machine) -> None:
    """Tip and rotary axes of each row are where the segment has them at different times; every row to another
    extent.
    """
    path = assemble(LINE, machine, OPTIONS).path
    random, count = np.random.default_rng(7), 40
    segment = np.full(count, np.flatnonzero(path.line == 3)[0])
    start, delta = path.start[segment[0]], (path.end - path.start)[segment[0]]
    tip_bound = TIP_BOUND * random.uniform(0.5, 2.0, count)
    angle_bound = ANGLE_BOUND * random.uniform(0.5, 2.0, count)
    u = random.uniform(0.1, 0.9, count)
    tip = start[:3] + u[:, None] * delta[:3] + random.uniform(-0.5, 0.5, (count, 3)) * tip_bound[:, None]
    apart = random.uniform(-1.0, 1.0, count) * angle_bound / abs(delta[4])
    angles = start[3:] + (u + apart)[:, None] * delta[3:]
    angles[:, 0] += random.uniform(-0.3, 0.3, count) * angle_bound
    measured = Measured(np.zeros((count, 5)), tip, angles)
    reach = 2 * (tip_bound + RADIAN_MM * angle_bound) / measure_metric_lengths(path)[segment]
    found = np.array(measure_deviation_nearby(path, segment, u, measured, tip_bound, angle_bound, reach))
    at_u = np.array(measure_off_segment(path, segment, u, measured))
    better = 0
    for k in range(count):

        def offs(at: float, k: int = k) -> tuple[float, float, float]:
            pose = start + at * delta
            axis = np.linalg.norm(_axis(*angles[k]) - _axis(*pose[3:]))
            return float(np.linalg.norm(tip[k] - pose[:3])), float(axis), float(abs(angles[k, 1] - pose[4]))

        def share(offs: tuple[float, float, float], k: int = k) -> float:
            return max(offs[0] / tip_bound[k], max(offs[1:]) / angle_bound[k])

        low, high = u[k] - reach[k], u[k] + reach[k]
        for _ in range(60):  # the share falls, and then rises
            a, b = (2 * low + high) / 3, (low + 2 * high) / 3
            low, high = (low, b) if share(offs(a)) < share(offs(b)) else (a, high)
        # to a millionth of the stretch, on which the share changes by a few
        assert share(tuple(found[:, k])) == pytest.approx(share(offs(low)), abs=1e-5)
        assert found[:, k] == pytest.approx(offs(low), abs=1e-4 * tip_bound[k])
        better += share(tuple(found[:, k])) < share(tuple(at_u[:, k])) - 0.01
    assert better > count / 2
