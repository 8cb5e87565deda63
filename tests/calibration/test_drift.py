"""Touch-up of a warm machine: few readings on top of a calibration."""

import numpy as np
import pytest

from verne_post.calibration.as_built.data import build_prior_of_manufacture, build_tolerance_vector
from verne_post.calibration.as_built.drift import build_prior_of_drift, find_drift_directions, split_drift
from verne_post.calibration.as_built.equations import Measurement
from verne_post.calibration.as_built.fit import fit

DRIFT_MM = 0.05


@pytest.fixture(scope="module")
def warm(model, draw_poses, read_tools, true_machine):
    """Ten machines: calibrated cold from 60 readings, drifted, touched up with 8."""
    cases = []
    directions = find_drift_directions(model.machine.geometry)
    for seed in range(10):
        true, rng = true_machine(seed), np.random.default_rng([5, seed])
        cold = Measurement(model, read_tools(draw_poses(60, 200 + seed), true, 1000 + seed))
        before = fit(cold, build_prior_of_manufacture(build_tolerance_vector()), np.ones(60, dtype=bool))
        drift = DRIFT_MM * rng.standard_normal(6)
        drifted = true + directions @ drift
        few = Measurement(model, read_tools(draw_poses(8, 300 + seed), drifted, 2000 + seed))
        prior = build_prior_of_drift(before.deviations, before.covariance, directions, DRIFT_MM)
        after = fit(few, prior, np.ones(8, dtype=bool))
        told = split_drift(before.deviations, after.deviations, prior, after.covariance, directions, DRIFT_MM)
        cases.append((drift, drifted, before, after, told))
    return cases


def test_the_directions_are_what_their_names_say(model, draw_poses):
    """Rods of one leg longer by 1 mm, and a zero of 1 mm: the same as another reading of that slider."""
    poses, directions = draw_poses(20, 3), find_drift_directions(model.machine.geometry)
    assert np.abs(directions[:, :3]).sum(axis=0).tolist() == [2.0, 2.0, 2.0]
    for leg in range(3):
        moved = model.predict(0.1 * directions[:, 3 + leg], poses.joints, poses.length).tip
        joints = np.array(poses.joints)
        joints[:, leg] += 0.1
        assert moved == pytest.approx(model.predict(np.zeros(58), joints, poses.length).tip, abs=1e-9)


def test_eight_readings_bring_a_warm_machine_back_to_micrometres(warm, model, draw_poses):
    held = draw_poses(300, 9)
    for _drift, drifted, before, after, _told in warm:
        true = model.predict(drifted, held.joints, held.length).tip
        off = [
            np.linalg.norm(model.predict(found.deviations, held.joints, held.length).tip - true, axis=1)
            for found in (before, after)
        ]
        assert np.median(off[1]) < 0.006
        assert np.median(off[1]) < 0.3 * np.median(off[0])


def test_the_drift_is_told_with_its_uncertainty(warm):
    """Truth minus told in stated uncertainties: 7 numbers of 10 machines, mean square 1 within four deviations."""
    apart = np.eye(3) - 1.0 / 3.0
    scaled = []
    for drift, _drifted, _before, _after, told in warm:
        scaled += [
            *((told.growth - drift[:3]) / told.growth_sigma),
            *((told.zeros - apart @ drift[3:]) / told.zeros_sigma),
            (told.height + drift[3:].mean()) / told.height_sigma,
        ]
    assert np.max(np.abs(scaled)) < 4.0
    assert np.mean(np.square(scaled)) == pytest.approx(1.0, abs=0.6)
    assert max(told.growth_sigma.max() for *_rest, told in warm) < 0.4 * DRIFT_MM
