"""Lengths from measured poses: the paper's Table III, known answers with known noise, and data that cannot tell."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from verne_post.calibration.data import Readings, Uncertainty
from verne_post.calibration.identify import identify
from verne_post.calibration.readings import read_readings
from verne_post.kinematics.modules.verne.loops import LENGTHS, evaluate_loops
from verne_post.kinematics.modules.verne.module import VerneModule

REFERENCE = Path(__file__).resolve().parents[1] / "reference" / "table_iii.csv"
TRUE = {
    "leg1_x_offset": -319.7,
    "R1": 130.4,
    "r1": 79.8,
    "L1": 850.3,
    "leg23_x_offset": 240.2,
    "R2": 190.3,
    "r4": 564.6,
    "L2": 950.2,
    "L3": 949.7,
}
NOMINAL = VerneModule(-320.0, 130.0, 80.0, 850.0, 240.0, 190.0, 565.0, 950.0, 950.0)
MODULE = VerneModule(**TRUE)
SIGMA = Uncertainty(0.01, 0.02, np.radians(0.01))


@pytest.fixture(scope="module")
def table_iii():
    return read_readings(REFERENCE.read_bytes(), NOMINAL.actuators)


def poses(n, seed=0, y=(-400.0, 400.0)):
    """True pairs of sliders and poses, spread over the working plane."""
    rng = np.random.default_rng(seed)
    position = np.stack(
        [rng.uniform(-300, 350, n), rng.uniform(*y, n) if y[0] < y[1] else np.zeros(n), rng.uniform(900, 1500, n)],
        axis=-1,
    )
    rho, alpha, ok = MODULE.inverse(position)
    assert ok.all()
    return Readings(rho, np.column_stack([position, alpha]), np.arange(n), np.arange(n) + 2)


def read(data, rng, sigma=SIGMA):
    """What instruments of this uncertainty say."""
    pose = data.pose + rng.standard_normal(data.pose.shape) * [*3 * [sigma.position], sigma.tilt]
    return replace(data, rho=data.rho + sigma.slider * rng.standard_normal(data.rho.shape), pose=pose)


def without_tilts(data):
    return replace(data, pose=np.column_stack([data.pose[:, :3], np.full(len(data.pose), np.nan)]))


# --- the loop equations --------------------------------------------------------------------------------


@given(seed=st.integers(0, 2**32 - 1))
def test_derivatives_of_the_loop_equations(seed):
    """Against differences of a step that leaves about eight digits."""
    rng = np.random.default_rng(seed)
    at = [np.array(list(TRUE.values())), rng.uniform(0, 900, (1, 3)), rng.uniform(-3, 3, (1, 4)) * [100, 100, 400, 1]]
    value, *slopes = evaluate_loops(*at)
    for which, slope in enumerate(slopes):
        for column in range(at[which].shape[-1]):
            step = np.zeros(at[which].shape[-1])
            step[column] = 1e-5
            plus, minus = ([*at[:which], at[which] + sign * step, *at[which + 1 :]] for sign in (1, -1))
            rate = (evaluate_loops(*plus)[0] - evaluate_loops(*minus)[0]) / 2e-5
            assert slope[..., column] == pytest.approx(rate, abs=1e-6 * (1 + np.abs(slope).max()))
    assert value + rods_lengths() == pytest.approx(spans(*at[1:]), rel=1e-12)


def rods_lengths():
    return np.array([TRUE[name] for name in ("L1", "L1", "L2", "L3")])


def spans(rho, pose, g=TRUE):
    """Square roots of the first three terms of the paper's (3), (4), (5), (6), as printed."""
    x, y, z, alpha = pose.T
    c, s = np.cos(alpha), np.sin(alpha)
    x1, x2 = x + g["leg1_x_offset"], x + g["leg23_x_offset"]
    squares = [
        x1**2 + (y + g["R1"] * c - g["r1"]) ** 2 + (z + g["R1"] * s - rho[:, 0]) ** 2,
        x1**2 + (y - g["R1"] * c + g["r1"]) ** 2 + (z - g["R1"] * s - rho[:, 0]) ** 2,
        x2**2 + (y - g["R2"] * c + g["r4"]) ** 2 + (z - g["R2"] * s - rho[:, 1]) ** 2,
        x2**2 + (y + g["R2"] * c - g["r4"]) ** 2 + (z + g["R2"] * s - rho[:, 2]) ** 2,
    ]
    return np.sqrt(squares).T


def test_names_are_the_modules_own():
    assert NOMINAL.__struct_fields__ == LENGTHS


# --- Table III -----------------------------------------------------------------------------------------

WHOLE = {"leg1_x_offset": -320, "R1": 130, "r1": 80, "L1": 850, "leg23_x_offset": 240, "R2": 190, "r4": 565, "L2": 950}
DETUNED = VerneModule(-300.0, 120.0, 90.0, 870.0, 260.0, 200.0, 540.0, 930.0, 930.0)


def test_table_iii_with_its_digits_taken_as_exact(table_iii):
    """All error in the rods, alike: lengths a little off whole numbers, from far-off lengths too."""
    exact = Uncertainty(0.0, 0.0, np.inf, 1.0)
    for module in (NOMINAL, DETUNED):
        found = identify(module, table_iii, exact, tied=[("L2", "L3")]).lengths
        assert [round(found[name], 1) for name in ("leg23_x_offset", "r4", "L2", "L3")] == [240.8, 565.4, 950.4, 950.4]


def test_table_iii_with_sliders_freed_within_their_digits(table_iii):
    """Sliders printed to 1 mm and shared by all four modes, coordinates to 0.01 mm: uniform errors, width /
    sqrt(12).
    """
    sigma = Uncertainty(1 / np.sqrt(12), 0.01 / np.sqrt(12), np.inf)
    for module in (NOMINAL, DETUNED):
        found = identify(module, table_iii, sigma, tied=[("L2", "L3")])
        assert {name: round(value) for name, value in found.lengths.items()} == {**WHOLE, "L3": 950}
        off = [abs(found.lengths[name] - whole) / found.uncertainty[name] for name, whole in WHOLE.items()]
        assert max(off) < 3
        assert found.lengths["L2"] == found.lengths["L3"]
        # 4 modes of 4 rods, less a tilt each, less 8 lengths
        assert found.degrees_of_freedom == 4
        assert 0.01 < found.probability < 0.99
        assert not found.undetermined
        # the sliders that kinematics found to more digits: 674.0137, 685.1566, 250.4100
        fitted = table_iii.rho[0] - found.residual[0, :3]
        assert fitted == pytest.approx([674.0137, 685.1566, 250.4100], abs=0.1)
    # exact sliders do not fit the digits of the poses by far
    assert identify(NOMINAL, table_iii, replace(sigma, slider=0.0), tied=[("L2", "L3")]).probability < 1e-6


def test_random_starts_on_table_iii_land_on_one_solution(table_iii):
    """Those that reach a fit at all; the few that do not close the rods are far worse, not rivals."""
    sigma = Uncertainty(0.29, 0.003, np.inf)
    found = identify(DETUNED, table_iii, sigma, tied=[("L2", "L3")], starts=12)
    best, *others = found.landings
    assert best.count >= 8
    assert best.chi_square < 10
    assert all(other.chi_square > 1e6 for other in others)
    assert sum(landing.count for landing in found.landings) + found.failed_starts == 12
    assert {name: round(value) for name, value in best.lengths.items()} == {**WHOLE, "L3": 950}


# --- known answers -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("tilts", [True, False])
def test_exact_readings_give_the_true_lengths(tilts):
    data = poses(12) if tilts else without_tilts(poses(12))
    found = identify(NOMINAL, data, SIGMA)
    assert found.converged
    for name, value in TRUE.items():  # 1e-5: a thousandth of what the readings could tell
        assert found.lengths[name] == pytest.approx(value, abs=1e-5)
    assert found.chi_square < 1e-6
    assert found.degrees_of_freedom == 12 * (4 if tilts else 3) - 9


@pytest.mark.parametrize("tilts", [True, False])
def test_uncertainties_are_those_of_repeated_measurements(tilts):
    """30 trials against the covariance that each states; every bound at four standard deviations of what it bounds.

    Without tilts four lengths are known to millimetres only, and a covariance, which is linear, cannot say how the
    others bend along with them; readings that are twenty times better keep to the linear part.
    """
    sigma = SIGMA if tilts else Uncertainty(SIGMA.slider / 20, SIGMA.position / 20, SIGMA.tilt)
    data, rng, trials = poses(25, seed=3), np.random.default_rng(5), 30
    true = np.array([TRUE[name] for name in LENGTHS])
    scaled, distances, squares = [], [], []
    for _ in range(trials):
        noisy = read(data, rng, sigma)
        found = identify(NOMINAL, noisy if tilts else without_tilts(noisy), sigma)
        spread = np.array(list(found.uncertainty.values()))
        off = np.array([found.lengths[name] for name in LENGTHS]) - true
        scaled.append(off / spread)
        distances.append(off @ np.linalg.solve(found.correlation * np.outer(spread, spread), off))
        squares.append(found.chi_square)
    assert np.abs(np.mean(scaled, axis=0)).max() < 4 / np.sqrt(trials)  # no bias
    # chi-square of nine lengths together: mean 9, variance 18; so uncertainties too small or large by a third show
    assert np.mean(distances) == pytest.approx(9, abs=4 * np.sqrt(18 / trials))
    freedom = found.degrees_of_freedom
    assert np.mean(squares) == pytest.approx(freedom, abs=4 * np.sqrt(2 * freedom / trials))


def test_rows_of_one_setting_share_the_error_of_their_sliders(table_iii):
    """Apart, the four rows may each bend the sliders their own way, and say less about everything."""
    sigma = Uncertainty(0.29, 0.003, np.inf)
    shared = identify(NOMINAL, table_iii, sigma, tied=[("L2", "L3")])
    apart = identify(NOMINAL, replace(table_iii, setting=np.arange(4)), sigma, tied=[("L2", "L3")])
    assert (shared.residual[:, :3] == shared.residual[0, :3]).all()
    assert np.ptp(apart.residual[:, :3], axis=0).min() > 0.01
    for name, spread in shared.uncertainty.items():
        assert spread < 0.7 * apart.uncertainty[name]


def test_an_outlier_shows_in_chi_square_and_in_its_row():
    noisy = read(poses(20), np.random.default_rng(1))
    pose = np.array(noisy.pose)
    pose[7, 1] += 0.5  # 25 standard uncertainties
    found = identify(NOMINAL, replace(noisy, pose=pose), SIGMA)
    assert found.probability < 1e-9
    worst = np.nanargmax(np.abs(found.scaled).max(axis=1, initial=0, where=np.isfinite(found.scaled)))
    assert worst == 7


def test_held_lengths_keep_their_values():
    found = identify(replace(NOMINAL, L1=TRUE["L1"]), poses(12), SIGMA, held=("L1",))
    assert found.lengths["L1"] == TRUE["L1"]
    assert "L1" not in found.uncertainty
    assert found.lengths["R1"] == pytest.approx(TRUE["R1"], abs=1e-5)


# --- what cannot be told ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("n", "noise"), [(8, False), (8, True), (600, True)])
def test_poses_without_tilt_leave_sums_open(noise, n):
    """At y = 0, alpha = 0 leg I is a plane triangle: only L1^2 - (R1 - r1)^2 counts; legs II and III with R2 - r4
    alike.

    So one of R1, r1, L1 is known where two are held, and one of R2, r4 besides each rod. The noise of
    many rows must not pass for tilts: 600 of them would give R1 = 2 mm.
    """
    data = poses(n, y=(0.0, 0.0))
    found = identify(NOMINAL, read(data, np.random.default_rng(2)) if noise else data, SIGMA)
    assert len(found.undetermined) == 4
    groups = [set(direction.coefficients) for direction in found.undetermined]
    assert all(group <= {"R1", "r1", "L1"} or group <= {"R2", "r4", "L2", "L3"} for group in groups)
    assert sum(group <= {"R1", "r1", "L1"} for group in groups) == 2
    for name in ("R1", "r1", "L1", "R2", "r4", "L2", "L3"):
        assert np.isnan(found.uncertainty[name])
    for name in ("leg1_x_offset", "leg23_x_offset"):  # known all the same
        assert abs(found.lengths[name] - TRUE[name]) < 4 * found.uncertainty[name] < 1.0
    # a change along a named direction opens no rod: second order of 0.01 mm over the drop of a rod
    for direction in found.undetermined:
        other = {name: found.lengths[name] + 0.01 * direction.coefficients.get(name, 0.0) for name in LENGTHS}
        fitted = [np.array([lengths[name] for name in LENGTHS]) for lengths in (found.lengths, other)]
        change = evaluate_loops(fitted[1], data.rho, data.pose)[0] - evaluate_loops(fitted[0], data.rho, data.pose)[0]
        assert np.abs(change).max() < (1e-3 if noise else 1e-5)


def test_holding_one_length_of_each_leaves_nothing_open():
    data = poses(30, y=(0.0, 0.0))
    right = replace(NOMINAL, R1=TRUE["R1"], r1=TRUE["r1"], R2=TRUE["R2"], r4=TRUE["r4"])
    found = identify(right, data, SIGMA, held=("R1", "r1", "R2", "r4"))
    assert not found.undetermined
    assert found.lengths["L1"] == pytest.approx(TRUE["L1"], abs=1e-5)


def test_too_few_rows_leave_lengths_open():
    found = identify(NOMINAL, poses(2), SIGMA)
    assert len(found.undetermined) >= 1
    assert found.degrees_of_freedom <= 8


def test_one_direction_is_said_in_words():
    """Leg I alone stands on one pose: with only L3 and r4 free and one row, one combination of both stays open."""
    found = identify(NOMINAL, poses(1), SIGMA, held=[name for name in LENGTHS if name not in ("L3", "L1", "r1")])
    words = [direction.describe() for direction in found.undetermined]
    assert all(" with " in text or text.endswith(" alone") for text in words)


def test_exact_readings_that_contradict_each_other_are_refused():
    with pytest.raises(ValueError, match="above 0"):
        identify(NOMINAL, poses(4), Uncertainty(0.1, 0.0, 0.1))
    with pytest.raises(ValueError, match="no length"):
        identify(NOMINAL, poses(4), SIGMA, held=LENGTHS)
