"""Tool errors over the workspace: what the ideal model leaves, what a calibration leaves, and what it says of that."""

import numpy as np
import pytest
from msgspec.structs import replace
from scipy.spatial.transform import Rotation

from verne_post.calibration.as_built.calibrate import calibrate
from verne_post.calibration.as_built.data import build_prior_of_manufacture, build_tolerance_vector
from verne_post.calibration.as_built.equations import Measurement
from verne_post.calibration.as_built.prediction import compute_tool_errors, find_quantiles, predict_errors_before
from verne_post.calibration.as_built.stations import align_stations
from verne_post.model.deviations import Deviations

from .independent import tools


@pytest.fixture(scope="module")
def calibrated(machine, model, draw_poses, read_tools, true_machine):
    true = true_machine(2)
    measurement = Measurement(model, read_tools(draw_poses(40, 2), true, 2))
    prior = build_prior_of_manufacture(build_tolerance_vector())
    return true, calibrate(measurement, prior, machine.five_axis, model.machine, draw_poses(400, 9))


def test_the_ideal_model_is_tenths_off_on_real_parts(machine, model, draw_poses, true_machine):
    """Places of 0.05 mm and directions of 0.1 mrad: some tenths of a millimetre, some hundredths of a degree."""
    poses = draw_poses(300, 9)
    found = [predict_errors_before(model, true_machine(seed), machine.five_axis, poses) for seed in range(20)]
    medians = [find_quantiles(errors.tip)[0] for errors in found]
    assert 0.2 < np.mean(medians) < 0.5
    assert 0.4 < np.mean([find_quantiles(errors.tip)[2] for errors in found]) < 0.9
    axis = np.degrees([find_quantiles(errors.axis) for errors in found])
    assert 0.03 < axis[:, 0].mean() < 0.1
    assert axis[:, 2].max() < 0.3


def test_errors_before_are_those_of_the_equations(machine, model, draw_poses, true_machine):
    poses, true = draw_poses(15, 3), true_machine(3)
    found = predict_errors_before(model, true, machine.five_axis, poses)
    tip = tools(true, poses.joints, poses.length)[0]
    assert found.tip == pytest.approx(np.linalg.norm(tip - poses.tip, axis=1), abs=1e-9)


def test_the_true_deviations_leave_the_axis_that_c_could_correct_and_no_tip(model, draw_poses, true_machine):
    poses, true = draw_poses(200, 9), true_machine(4)
    joints = model.machine.replace_deviations(Deviations.build_from_vector(true)).find_joints(
        poses.tip, poses.angles, poses.length
    )
    left = compute_tool_errors(model, true, joints, poses)
    assert left.tip.max() < 1e-9
    assert 0.01 < np.degrees(left.axis.max()) < 0.2


def test_what_is_predicted_after_is_what_is_left(calibrated, model, draw_poses):
    """The quantiles that it promises hold for the true machine, at poses of another draw."""
    true, result = calibrated
    poses = draw_poses(400, 77)
    machine = model.machine.replace_deviations(Deviations.build_from_vector(result.fit.deviations))
    left = compute_tool_errors(model, true, machine.find_joints(poses.tip, poses.angles, poses.length), poses)
    promised, found = find_quantiles(result.after.errors.tip), find_quantiles(left.tip)
    assert 0.4 * promised[0] < found[0] < 2.0 * promised[0]
    assert found[2] < 1.5 * promised[2]
    before = find_quantiles(result.before.tip)
    assert before[0] > 20 * found[0]
    axis, promised_axis = find_quantiles(left.axis), find_quantiles(result.after.errors.axis)
    assert axis[0] == pytest.approx(promised_axis[0], rel=0.1)


def test_half_of_the_directions_stay_open_and_are_named(calibrated, model, draw_poses):
    """Moving a rod parallel to itself along x is open for any reading: it changes no length between its ends."""
    _true, result = calibrated
    assert 30 <= result.determined <= 40
    assert result.determined + len(result.undetermined) == 58
    named = [set(direction.coefficients) for direction in result.undetermined]
    for rod in ("I at +y", "I at -y"):
        assert {f"platform_ends_mm, rod {rod}, x", f"slider_ends_mm, rod {rod}, x"} in named
    assert 0.0 < result.left_share < 0.5


def test_a_shift_and_turn_of_the_part_is_taken_off(calibrated, machine, model, draw_poses, read_tools):
    """Readings from an unknown ball: the part's place is known to hundredths, its shape to micrometres."""
    true, with_place = calibrated
    readings = read_tools(draw_poses(40, 2), true, 2)
    readings = align_stations(model, np.zeros(58), replace(readings, station=np.zeros(40, dtype=int)))
    prior = build_prior_of_manufacture(build_tolerance_vector())
    result = calibrate(Measurement(model, readings), prior, machine.five_axis, model.machine, draw_poses(400, 9))
    whole, shape = find_quantiles(result.after.errors.tip), find_quantiles(result.after.shape)
    assert whole[0] > 3 * shape[0]
    assert shape[1] < 2 * find_quantiles(with_place.after.errors.tip)[1]
    assert (find_quantiles(with_place.after.shape)[0]) < find_quantiles(with_place.after.errors.tip)[0]
    # the best rigid motion of one drawn machine, by another route
    poses = draw_poses(400, 9)
    held = model.machine.replace_deviations(Deviations.build_from_vector(result.fit.deviations))
    joints = held.find_joints(poses.tip, poses.angles, poses.length)
    left = model.predict(true, joints, poses.length).tip
    turn, _rest = Rotation.align_vectors(poses.tip - poses.tip.mean(axis=0), left - left.mean(axis=0))
    rest = np.linalg.norm(turn.apply(left - left.mean(axis=0)) - (poses.tip - poses.tip.mean(axis=0)), axis=1)
    assert np.median(rest) < 2 * shape[0]
