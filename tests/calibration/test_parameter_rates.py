"""The model of a calibration and its derivatives against six rods closed by scipy."""

import numpy as np
import pytest

from verne_post.calibration.as_built.data import build_tolerance_vector
from verne_post.calibration.as_built.stations import see_from_stations
from verne_post.model.deviations import PARAMETERS

from .independent import SIGMA, tip_and_axis, tools


def test_the_tolerances_stand_in_the_order_of_the_parameters():
    assert (build_tolerance_vector(0.05, 1e-4) == SIGMA).all()
    assert [SIGMA[k] == 1e-4 for k in range(58)] == ["mrad" in name for name in PARAMETERS]


@pytest.mark.parametrize("seed", range(4))
def test_tools_are_where_the_equations_say(model, draw_poses, true_machine, seed):
    poses, true = draw_poses(25, seed), 3.0 * true_machine(seed)
    found = model.predict(true, poses.joints, poses.length)
    tip, axis = tools(true, poses.joints, poses.length)
    assert found.ok.all()
    assert found.tip == pytest.approx(tip, abs=1e-9)
    assert found.axis == pytest.approx(axis, abs=1e-12)


def test_derivatives_by_every_part_are_differences_of_the_equations(model, draw_poses, true_machine):
    """Central differences: the third derivative leaves 1e-8 of a step of 0.01 mm or 0.01 mrad, rounding about
    as much.
    """
    poses, true = draw_poses(3, 5), true_machine(1)
    rates = model.differentiate(true, poses.joints, poses.length)[1]
    for k in range(58):
        step = np.zeros(58)
        step[k] = 0.01 if SIGMA[k] > 1e-3 else 1e-5
        after, before = (tools(true + sign * step, poses.joints, poses.length) for sign in (1.0, -1.0))
        tip, axis = ((a - b) / (2.0 * step[k]) for a, b in zip(after, before, strict=True))
        scale = 1.0 if SIGMA[k] > 1e-3 else 1000.0
        assert rates.tip[:, :, k] == pytest.approx(tip, abs=2e-7 * scale), PARAMETERS[k]
        assert rates.axis[:, :, k] == pytest.approx(axis, abs=1e-9 * scale), PARAMETERS[k]


def test_derivatives_by_every_joint_are_differences_of_the_equations(model, draw_poses, true_machine):
    poses, true = draw_poses(3, 6), true_machine(2)
    rates = model.differentiate(true, poses.joints, poses.length)[1]
    for row in range(3):
        for k in range(5):
            step = np.zeros(5)
            step[k] = 0.01 if k < 3 else 1e-5
            after, before = (tip_and_axis(true, poses.joints[row] + sign * step, poses.length[row]) for sign in (1, -1))
            tip, axis = ((a - b) / (2.0 * step[k]) for a, b in zip(after, before, strict=True))
            scale = 1.0 if k < 3 else 1000.0
            assert rates.tip_by_joint[row, :, k] == pytest.approx(tip, abs=2e-7 * scale)
            assert rates.axis_by_joint[row, :, k] == pytest.approx(axis, abs=1e-9 * scale)


def test_derivatives_by_a_station_are_differences():
    rng = np.random.default_rng(2)
    tip, axis, station = rng.uniform(-200, 200, (6, 3)), rng.standard_normal((6, 3)), np.array([0, 1, -1, 0, 1, 1])
    at = np.concatenate([rng.uniform(-50, 50, (2, 3)), np.zeros((2, 3))], axis=1)
    seen = see_from_stations(tip, axis, station, at)
    assert (seen.tip[2] == tip[2]).all()
    assert (seen.tip_by_station[2] == 0.0).all()
    for k in range(6):
        step = np.zeros((2, 6))
        step[:, k] = 1e-4
        after, before = (see_from_stations(tip, axis, station, at + sign * step) for sign in (1.0, -1.0))
        assert (after.tip - before.tip) / 2e-4 == pytest.approx(seen.tip_by_station[:, :, k], abs=1e-5)
        assert (after.axis - before.axis) / 2e-4 == pytest.approx(seen.axis_by_station[:, :, k], abs=1e-7)
    # turned by a quarter about z, x is read as -y
    quarter = np.array([[0.0, 0.0, 0.0, 0.0, 0.0, np.pi / 2]])
    read = see_from_stations(np.array([[3.0, 0.0, 1.0]]), np.array([[1.0, 0.0, 0.0]]), np.array([0]), quarter)
    assert read.tip[0] == pytest.approx([0.0, -3.0, 1.0], abs=1e-12)
