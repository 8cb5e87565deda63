"""Calibration of simulated machines, whose readings come from six rods closed by scipy."""

import numpy as np
import pytest
from msgspec.structs import replace
from scipy.spatial.transform import Rotation

from verne_post.calibration.as_built.data import (
    JointUncertainty,
    LengthReading,
    build_prior_of_covariance,
    build_prior_of_manufacture,
    build_tolerance_vector,
)
from verne_post.calibration.as_built.equations import Measurement
from verne_post.calibration.as_built.fit import fit, fit_robustly, hold_out
from verne_post.calibration.as_built.stations import align_stations

from .independent import PLATFORM, RODS, SIGMA, tools

PRIOR = build_prior_of_manufacture(build_tolerance_vector())


def everything(measurement: Measurement) -> np.ndarray:
    return np.ones(len(measurement), dtype=bool)


def tip_errors(model, found: np.ndarray, true: np.ndarray, poses) -> np.ndarray:
    """Distances of the tips that two machines have at the same joints, mm."""
    one, other = (model.predict(vector, poses.joints, poses.length).tip for vector in (found, true))
    return np.linalg.norm(one - other, axis=1)


@pytest.fixture(scope="module")
def twenty(model, draw_poses, read_tools, true_machine):
    """Fits of 20 machines from 40 random poses, readings of 3 um, tools of 60 and 160 mm."""
    fits = []
    for seed in range(20):
        true = true_machine(seed)
        measurement = Measurement(model, read_tools(draw_poses(40, 100 + seed), true, seed))
        fits.append((true, measurement, *fit_robustly(measurement, PRIOR)))
    return fits


# --- what the issue asks for -------------------------------------------------------------------------


def test_forty_readings_give_the_tip_to_micrometres(twenty, model, draw_poses):
    """At 400 poses that were not measured: median 4 um, none beyond 20 um, on each of 20 machines."""
    held = draw_poses(400, 9)
    for true, _measurement, found, kept, _bad in twenty:
        errors = tip_errors(model, found.deviations, true, held)
        assert found.converged
        assert kept.all()
        assert np.median(errors) <= 0.004
        assert errors.max() <= 0.020
        assert np.median(tip_errors(model, np.zeros(58), true, held)) > 0.04  # without it: ten times as much and more


def test_a_reading_off_by_a_millimetre_is_found(model, draw_poses, read_tools, true_machine):
    for seed, row, axis in ((3, 11, 0), (4, 30, 1), (5, 21, 2)):
        readings = read_tools(draw_poses(40, seed), true_machine(seed), seed)
        tip = np.array(readings.tip)
        tip[row, axis] += 1.0
        measurement = Measurement(model, replace(readings, tip=tip))
        found, kept, bad = fit_robustly(measurement, PRIOR)
        assert np.flatnonzero(~kept).tolist() == [row] == [one.block for one in bad]
        assert bad[0].off[axis] == pytest.approx(1.0, abs=0.05)  # from what the others predict
        clean = fit(Measurement(model, readings), PRIOR, kept)
        assert found.deviations == pytest.approx(clean.deviations, abs=1e-7)


def test_several_bad_readings_are_found_even_where_one_hides_another(model, draw_poses, read_tools, true_machine):
    readings = read_tools(draw_poses(60, 8), true_machine(8), 8)
    tip = np.array(readings.tip)
    tip[[5, 20, 41]] += [[1.0, 0.0, 0.0], [0.0, 0.03, -0.02], [0.0, -0.4, 0.0]]
    kept = fit_robustly(Measurement(model, replace(readings, tip=tip)), PRIOR)[1]
    assert np.flatnonzero(~kept).tolist() == [5, 20, 41]


@pytest.mark.parametrize("station", ["table", "sphere", "frame"])
def test_a_typing_error_of_metres_is_found_before_it_misleads(model, draw_poses, read_tools, true_machine, station):
    """In the table frame, and beside a place that it would pull along."""
    readings = read_tools(draw_poses(40, 6), true_machine(6), 6)
    tip, joints = np.array(readings.tip), np.array(readings.joints)
    tip[17, 2] *= 1000.0
    joints[23, 3] += 1.5
    readings = replace(readings, tip=tip, joints=joints)
    if station != "table":
        turned = np.full(40, station == "frame")
        readings = replace(readings, station=np.zeros(40, dtype=int), turned=turned)
        readings = align_stations(model, np.zeros(58), readings)
    found, kept, bad = fit_robustly(Measurement(model, readings), PRIOR)
    assert found.converged
    assert np.flatnonzero(~kept).tolist() == [17, 23]
    assert {one.block for one in bad} == {17, 23}
    assert found.probability > 1e-3


def test_readings_that_are_all_in_other_units_are_told(model, draw_poses, read_tools, true_machine):
    readings = read_tools(draw_poses(40, 6), true_machine(6), 6)
    inches = Measurement(model, replace(readings, tip=readings.tip / 25.4))
    with pytest.raises(ArithmeticError, match="40 of 40 readings are farther off than any machine"):
        fit_robustly(inches, PRIOR)


# --- statistics: what it says of itself is true ------------------------------------------------------------


def test_uncertainties_are_those_of_twenty_machines(twenty):
    """Truth minus fit in the stated covariance is chi-square with 58 degrees of freedom, the misfit with 120."""
    distances = [
        (found.deviations - true) @ np.linalg.solve(found.covariance, found.deviations - true)
        for true, _measurement, found, _kept, _bad in twenty
    ]
    assert np.mean(distances) == pytest.approx(58, abs=4 * np.sqrt(2 * 58 / 20))
    squares = [found.chi_square for _true, _measurement, found, _kept, _bad in twenty]
    assert {found.freedom for _true, _measurement, found, _kept, _bad in twenty} == {120}
    assert np.mean(squares) == pytest.approx(120, abs=4 * np.sqrt(2 * 120 / 20))


def test_held_out_readings_are_as_far_off_as_expected(twenty):
    ratios = []
    for _true, measurement, _found, kept, _bad in twenty[:8]:
        held = hold_out(measurement, PRIOR, kept)
        assert len(held.tip) == 40
        assert held.probability > 1e-3
        ratios.append((held.tip**2).mean() / held.expected_tip**2)
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.25)  # 320 readings of three coordinates, which share machines


def test_uncertainties_that_are_stated_too_small_are_told(model, draw_poses, read_tools, true_machine):
    readings = read_tools(draw_poses(40, 1), true_machine(1), 1, sigma=0.009)
    measurement = Measurement(model, replace(readings, sigma_tip=np.full(40, 0.003)))
    found = fit(measurement, PRIOR, everything(measurement))
    assert found.probability < 1e-6
    assert hold_out(measurement, PRIOR, everything(measurement)).probability < 1e-3


# --- kinds of readings ------------------------------------------------------------------------------------


def test_exact_readings_explain_themselves_and_the_machine(model, draw_poses, read_tools, true_machine):
    """A hundred times better readings than usual: tips and axes between them are known a hundred times better."""
    poses, true, held = draw_poses(120, 2), true_machine(2), draw_poses(200, 9)
    measurement = Measurement(model, read_tools(poses, true, 2, sigma=3e-5, axes=2e-7))
    found = fit(measurement, PRIOR, everything(measurement))
    assert tip_errors(model, found.deviations, true, held).max() < 2e-4
    one, other = (model.predict(vector, held.joints, held.length).axis for vector in (found.deviations, true))
    assert np.abs(one - other).max() < 1e-6


def test_the_axis_is_told_by_readings_of_the_axis(model, draw_poses, read_tools, true_machine):
    poses, true, held = draw_poses(150, 4), true_machine(4), draw_poses(200, 9)
    left = []
    for axes in (None, 2e-5):
        measurement = Measurement(model, read_tools(poses, true, 4, axes=axes))
        found = fit(measurement, PRIOR, everything(measurement))
        one, other = (model.predict(vector, held.joints, held.length).axis for vector in (found.deviations, true))
        left.append(np.degrees(np.linalg.norm(one - other, axis=1)).max())
    assert left[0] < 0.0045
    assert left[1] < 0.5 * left[0]


def test_a_coordinate_that_was_not_measured_is_none(model, draw_poses, read_tools, true_machine):
    """Only heights: fewer equations, the same machine, and no claim about what no reading tells."""
    poses, true = draw_poses(80, 4), true_machine(4)
    readings = read_tools(poses, true, 4)
    tip = np.array(readings.tip)
    tip[:, :2] = np.nan
    measurement = Measurement(model, replace(readings, tip=tip))
    found = fit(measurement, PRIOR, everything(measurement))
    assert found.freedom == 80
    assert found.probability > 1e-3
    off = (
        tools(found.deviations, poses.joints[:10], poses.length[:10])[0]
        - tools(true, poses.joints[:10], poses.length[:10])[0]
    )
    assert np.abs(off[:, 2]).max() < 0.012
    assert np.abs(off[:, :2]).max() > 0.02


def test_centres_of_spheres_are_found_with_the_machine(model, draw_poses, read_tools, true_machine):
    """Two instruments, each with a zero of its own on the table."""
    poses, true, held = draw_poses(80, 6), true_machine(6), draw_poses(200, 9)
    readings = read_tools(poses, true, 6)
    centres = np.array([[123.0, -45.0, 67.0], [-80.0, 10.0, 31.0]])
    sphere = np.arange(80) % 2
    read = replace(readings, tip=readings.tip - centres[sphere], station=sphere)
    near = align_stations(model, np.zeros(58), read)
    shift = (near.tip - read.tip)[:2]
    measurement = Measurement(model, near)
    found, kept, _bad = fit_robustly(measurement, PRIOR)
    assert kept.all()
    assert found.freedom == 240 - 6
    assert found.probability > 1e-3
    spread, stations = np.sqrt(np.diag(found.factor @ found.factor.T))[58:], found.unknowns[58:].reshape(2, 6)
    assert np.abs(stations[:, :3] + shift - centres).max() < 4 * spread.max() < 0.2
    assert (stations[:, 3:] == 0.0).all()  # their axes are those of the table
    # nothing says any more where the table frame is, so tips are known up to a shift
    moved = (
        model.predict(found.deviations, held.joints, held.length).tip
        - model.predict(true, held.joints, held.length).tip
    )
    assert np.linalg.norm(moved - moved.mean(axis=0), axis=1).max() < 0.03


def test_a_tracker_may_stand_anywhere_and_any_way(model, draw_poses, read_tools, true_machine):
    """Tips and axes in a frame of its own, metres away and far turned: the machine is found with the frame."""
    poses, true, held = draw_poses(80, 6), true_machine(6), draw_poses(200, 9)
    readings = read_tools(poses, true, 6, axes=2e-5)
    turn, place = Rotation.from_euler("xyz", [100.0, -40.0, 200.0], degrees=True), np.array([1500.0, -2000.0, 300.0])
    moved = replace(
        readings,
        tip=turn.inv().apply(readings.tip - place),
        axis=turn.inv().apply(readings.axis),
        station=np.zeros(80, dtype=int),
        turned=np.ones(80, dtype=bool),
    )
    measurement = Measurement(model, align_stations(model, np.zeros(58), moved))
    found, kept, _bad = fit_robustly(measurement, PRIOR)
    assert found.converged
    assert kept.all()
    assert found.freedom == 80 * 5 - 6
    assert 1e-3 < found.probability < 0.999
    assert hold_out(measurement, PRIOR, kept).probability > 1e-3
    assert np.abs(found.deviations / SIGMA).max() < 4.0
    # where the table frame is follows from the axes that turned the tips, but for its height, its turn about z, and
    # what the places of the axes leave open; so tips are known up to a rigid motion of some hundredths
    one, other = (model.predict(vector, held.joints, held.length).tip for vector in (found.deviations, true))
    rigid = Rotation.align_vectors(other - other.mean(axis=0), one - one.mean(axis=0))[0]
    shape = rigid.apply(one - one.mean(axis=0)) - (other - other.mean(axis=0))
    assert np.linalg.norm(shape, axis=1).max() < 0.02
    assert np.linalg.norm(one - other, axis=1).max() < 0.2


def test_a_frame_needs_tips_that_tell_its_directions(model, draw_poses, read_tools):
    readings = replace(
        read_tools(draw_poses(6, 6), np.zeros(58), 6), station=np.zeros(6, dtype=int), turned=np.ones(6, dtype=bool)
    )
    with pytest.raises(ValueError, match="2 whole tips"):
        align_stations(model, np.zeros(58), readings.take(np.arange(2)))
    same = readings.take(np.zeros(6, dtype=int))
    with pytest.raises(ValueError, match="on one line"):
        align_stations(model, np.zeros(58), same)


def test_a_measured_rod_and_a_distance_of_ends_are_readings_too(model, draw_poses, read_tools, true_machine):
    poses, true = draw_poses(40, 7), true_machine(7)
    ends = PLATFORM + true[:18].reshape(6, 3)
    lengths = (
        LengthReading("rod", (2,), RODS[2] + true[38] + 0.001, 0.002, 2),
        LengthReading("platform", (0, 3), float(np.linalg.norm(ends[0] - ends[3])), 0.002, 3),
    )
    measurement = Measurement(model, read_tools(poses, true, 7), lengths)
    found = fit(measurement, PRIOR, everything(measurement))
    assert found.freedom == 122
    assert found.deviations[38] == pytest.approx(true[38], abs=0.006)
    assert np.sqrt(found.covariance[38, 38]) < 0.0021
    fitted = PLATFORM + found.deviations[:18].reshape(6, 3)
    assert np.linalg.norm(fitted[0] - fitted[3]) == pytest.approx(lengths[1].value, abs=0.006)


def test_joints_that_stand_elsewhere_than_commanded(model, draw_poses, true_machine, read_tools):
    """Sliders off by 10 um at random: taken as exact, the readings contradict; with their uncertainty they do not."""
    poses, true = draw_poses(60, 3), true_machine(3)
    rng = np.random.default_rng(3)
    stood = poses.joints + np.concatenate([0.01 * rng.standard_normal((60, 3)), np.zeros((60, 2))], axis=1)
    readings = read_tools(replace(poses, joints=stood), true, 3)
    readings = replace(readings, joints=poses.joints)
    exact, known = (Measurement(model, readings, (), JointUncertainty(slider)) for slider in (0.0, 0.01))
    assert fit(exact, PRIOR, everything(exact)).probability < 1e-6
    found = fit(known, PRIOR, everything(known))
    assert 1e-3 < found.probability < 0.999
    held = hold_out(known, PRIOR, everything(known))
    assert (held.tip**2).mean() == pytest.approx(held.expected_tip**2, rel=0.35)  # 60 readings of three coordinates


def test_coordinates_that_no_reading_of_a_place_has_are_no_unknowns(model, draw_poses, read_tools, true_machine):
    """Spheres whose heights, or all but one coordinate, were not measured take up as many equations as they have
    coordinates.
    """
    readings = read_tools(draw_poses(60, 4), true_machine(4), 4)
    for measured in (2, 1):
        tip = np.array(readings.tip)
        tip[:, measured:] = np.nan
        measurement = Measurement(model, replace(readings, tip=tip, station=np.arange(60) % 20))
        assert fit(measurement, PRIOR, everything(measurement)).freedom == measured * (60 - 20)


# --- priors ------------------------------------------------------------------------------------------------


def test_three_readings_move_the_machine_no_farther_than_its_tolerances(model, draw_poses, read_tools, true_machine):
    """What few readings cannot tell stays nominal: nothing runs away."""
    measurement = Measurement(model, read_tools(draw_poses(3, 1), true_machine(1), 1))
    found = fit(measurement, PRIOR, everything(measurement))
    assert found.converged
    assert (found.deviations / SIGMA) @ (found.deviations / SIGMA) < 30  # nine equations, chi-square
    assert tip_errors(model, found.deviations, true_machine(1), draw_poses(200, 9)).max() < 0.4


def test_readings_in_two_parts_tell_the_same_as_at_once(model, draw_poses, read_tools, true_machine):
    """The first part's answer is the prior of the second."""
    readings = read_tools(draw_poses(60, 5), true_machine(5), 5)
    whole = Measurement(model, readings)
    at_once = fit(whole, PRIOR, everything(whole))
    first, second = (Measurement(model, readings.take(part)) for part in (np.arange(40), np.arange(40, 60)))
    half = fit(first, PRIOR, everything(first))
    again = fit(second, build_prior_of_covariance(half.deviations, half.covariance), everything(second))
    # the machine is not quite linear: a thousandth of what is known
    spread = np.sqrt(np.diag(at_once.covariance))
    assert np.abs((again.deviations - at_once.deviations) / spread).max() < 0.02
    assert np.diag(again.covariance) == pytest.approx(np.diag(at_once.covariance), rel=1e-2)
