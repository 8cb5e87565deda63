"""The parallel module alone: the paper's published numbers, its rod equations (3)-(6), symmetries and odd input."""

import itertools

import numpy as np
import pytest

from verne_post import load_machine
from verne_post.kinematics.modules.verne.module import VerneModule

from ..builders import LENGTHS, orientations, rods

#: A geometry without the symmetry L2 = L3, where exchanging legs II and III would be noticed.
SKEW = {**LENGTHS, "L2": 960.0, "L3": 935.0}

#: Round trips in mm. Measured 1.3e-12; the rest is room for another platform's rounding.
ROUND_TRIP_MM = 1e-9
#: Residual of a rod equation in mm2: an error of 1e-12 mm on a rod of 950 mm makes 2e-9.
RESIDUAL_MM2 = 1e-8


@pytest.fixture(scope="module")
def module() -> VerneModule:
    return VerneModule(**LENGTHS)


# --- the paper's equations, independent of the module's code --------------------------------------


def drops(position, alpha, rho, g=LENGTHS):
    """How far each platform attachment hangs below its slider's (-s_i times the roots in (11)-(13)), (..., 3) mm."""
    z, tilt = np.asarray(position)[..., 2], g["R2"] * np.sin(alpha)
    rho = np.asarray(rho)
    return np.stack([z - rho[..., 0], z - tilt - rho[..., 1], z + tilt - rho[..., 2]], axis=-1)


def in_working_mode(position, alpha, rho, g=LENGTHS):
    """Every s_i = -1, and the rods of leg I uncrossed."""
    return (drops(position, alpha, rho, g) > 0).all(axis=-1) & (g["R1"] * np.cos(alpha) > g["r1"])


def all_inverse_solutions(position, g=LENGTHS):
    """Every (alpha, rho) that closes the rods at a position: alpha from (9), rho by (14), (12), (13)."""
    x, y, z = position
    found = []
    for alpha in orientations(x, y, g):
        ca, sa = np.cos(alpha), np.sin(alpha)
        rho1 = z + y * (g["R1"] * ca - g["r1"]) / (g["R1"] * sa)
        under2 = g["L2"] ** 2 - (x + g["leg23_x_offset"]) ** 2 - (y - g["R2"] * ca + g["r4"]) ** 2
        under3 = g["L3"] ** 2 - (x + g["leg23_x_offset"]) ** 2 - (y + g["R2"] * ca - g["r4"]) ** 2
        for s2, s3 in itertools.product((1, -1), repeat=2):
            rho2 = z - g["R2"] * sa + s2 * np.sqrt(under2)
            rho3 = z + g["R2"] * sa + s3 * np.sqrt(under3)
            found.append((alpha, np.array([rho1, rho2, rho3])))
    return found


def scan(x, y, g=LENGTHS, n=4001):
    """Dense scan of (14) in the working mode over the uncrossed tilt: True where a root with real rods is certain.

    x, y (m,) are those of P. A root is certain where (14) changes sign between two neighbouring
    angles at which all three radicands of (11)-(13) are positive. Pairs of roots inside one step
    are missed, so False proves nothing.
    """
    alpha = np.linspace(-1, 1, n) * np.arccos(g["r1"] / g["R1"])
    ca, sa = np.cos(alpha), np.sin(alpha)
    x, y = np.asarray(x)[:, None], np.asarray(y)[:, None]
    arm = g["R1"] ** 2 + g["r1"] ** 2 - 2 * g["R1"] * g["r1"] * ca
    leg1 = g["L1"] ** 2 - arm - (x + g["leg1_x_offset"]) ** 2 - y**2
    leg2 = g["L2"] ** 2 - (x + g["leg23_x_offset"]) ** 2 - (y - g["R2"] * ca + g["r4"]) ** 2
    leg3 = g["L3"] ** 2 - (x + g["leg23_x_offset"]) ** 2 - (y + g["R2"] * ca - g["r4"]) ** 2
    loop = y * (g["R1"] * ca - g["r1"]) + g["R1"] * sa * np.sqrt(np.maximum(leg1, 0.0))
    real = (leg1 > 0) & (leg2 > 0) & (leg3 > 0)
    return ((loop[:, 1:] * loop[:, :-1] < 0) & real[:, 1:] & real[:, :-1]).any(axis=1)


def random_positions(seed, n):
    """Points of a box around the reachable plane (x -500..625, y -550..550), two thirds of them reachable."""
    rng = np.random.default_rng(seed)
    return rng.uniform([-560.0, -600.0, 0.0], [680.0, 600.0, 2000.0], size=(n, 3))


@pytest.fixture(scope="module")
def rim(module):
    """Points on the rim of the reachable plane and outward unit directions, found by bisection along rays."""
    rng, n = np.random.default_rng(2), 500
    angle = rng.uniform(-np.pi, np.pi, n)
    outward = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=-1)
    middle = np.stack([np.zeros(n), np.zeros(n), rng.uniform(0.0, 2000.0, n)], axis=-1)
    low, high = np.zeros(n), np.full(n, 1500.0)
    for _ in range(54):  # 1500 mm / 2**54 is the spacing of doubles at 500 mm
        distance = 0.5 * (low + high)
        ok = module.inverse(middle + distance[:, None] * outward)[2]
        low, high = np.where(ok, distance, low), np.where(ok, high, distance)
    return middle + low[:, None] * outward, outward


# --- published numbers ----------------------------------------------------------------------------


def test_the_machine_file_holds_the_identified_lengths():
    assert load_machine("verne").module == VerneModule(**LENGTHS)


def test_figure_6_sixteen_solutions_of_which_the_module_takes_the_only_working_one(module):
    position = np.array([-240.0, -86.0, 1000.0])
    solutions = all_inverse_solutions(position)
    assert len(solutions) == 16
    assert np.isfinite([rho for _alpha, rho in solutions]).all()
    for alpha, rho in solutions:
        # the roots of the cubic carry 1e-12 of the coefficients' size, about 1e-8 mm2 here
        assert np.abs(rods(position, alpha, rho)).max() < 1e-6
    angles = sorted({round(alpha, 4) for alpha, _rho in solutions})
    assert angles == [-2.9112, -0.0522, 0.0522, 2.9112]
    working = [(alpha, rho) for alpha, rho in solutions if in_working_mode(position, alpha, rho)]
    assert len(working) == 1
    rho, alpha, _ok = module.inverse(position)
    assert alpha == pytest.approx(working[0][0], abs=1e-11)
    assert rho == pytest.approx(working[0][1], abs=1e-8)


#: Table III, case a: alpha and P as printed; test_verne_modes.py has the other cases.
TABLE_III_ALPHA, TABLE_III_P = -0.2269, (-199.80, 355.92, 1242.0)


def test_table_iii_case_a_is_the_working_mode(module):
    position, alpha, ok = module.forward(np.array([674.0137, 685.1566, 250.4100]))
    assert ok
    assert position == pytest.approx(TABLE_III_P, abs=0.009)  # the print precision of the table
    assert alpha == pytest.approx(TABLE_III_ALPHA, abs=0.5e-4)


def test_table_iii_case_a_from_the_sliders_as_printed(module):
    """The sliders of Table III are printed to whole millimetres, which moves P by 0.36 mm (0.3601 in z)."""
    position, _alpha, ok = module.forward(np.array([674.0, 685.0, 250.0]))
    assert ok
    assert position == pytest.approx(TABLE_III_P, abs=0.361)


def test_figure_7_the_working_mode_among_its_roots(module):
    """Sliders (250, 1000, 750): one of the real roots is in the working mode, alpha = -0.0265."""
    rho = np.array([250.0, 1000.0, 750.0])
    position, alpha, ok = module.forward(rho)
    assert ok
    assert alpha == pytest.approx(-0.0265, abs=0.5e-4)
    assert in_working_mode(position, alpha, rho)
    assert np.abs(rods(position, alpha, rho)).max() < RESIDUAL_MM2


def test_figure_5_ellipses_of_equal_tilt(module):
    """Points of the ellipse (8) of an angle alpha have that tilt: y_P and alpha of opposite signs (14)."""
    R1, r1, L1 = LENGTHS["R1"], LENGTHS["r1"], LENGTHS["L1"]
    alpha = np.repeat(np.linspace(-40, 40, 33), 181) * np.pi / 180
    alpha = alpha[alpha != 0]
    around = np.tile(np.linspace(0, np.pi, 181), 32)
    arm = R1**2 + r1**2 - 2 * R1 * r1 * np.cos(alpha)
    a = np.sqrt(L1**2 - arm)
    b = R1 * np.abs(np.sin(alpha)) * a / np.sqrt(arm)
    x1, y = a * np.cos(around), -np.sign(alpha) * b * np.sin(around)
    position = np.stack([x1 - LENGTHS["leg1_x_offset"], y, np.full_like(y, 1000.0)], axis=-1)
    _rho, found, ok = module.inverse(position)
    # with less vertical drop of leg I than this a second tilt exists (kinematics: "Working mode")
    single = ok & (a**2 - x1**2 - y**2 > 100.0**2)
    assert single.sum() > 1000
    # y fixes alpha through a root of order one; 1e-9 rad is a thousandth of what a rod could notice
    assert found[single] == pytest.approx(alpha[single], abs=1e-9)


@pytest.mark.parametrize("x", [-400.0, -100.0, 0.0, 320.0, 600.0])
def test_table_i_y_zero_has_no_tilt(module, x):
    """Table I, y_P = 0: alpha in {0, +-alpha1, pi}; the working mode is 0, exactly."""
    assert any(abs(alpha) < 1e-6 for alpha in orientations(x, 0.0))  # a double root of the cubic
    _rho, alpha, ok = module.inverse(np.array([x, 0.0, 1000.0]))
    assert ok
    assert alpha == 0.0


# --- round trips and rods -------------------------------------------------------------------------


@pytest.mark.parametrize("lengths", [LENGTHS, SKEW], ids=["verne", "skew"])
def test_forward_of_inverse_over_the_reachable_plane(lengths):
    module = VerneModule(**lengths)
    rng = np.random.default_rng(1)
    position = rng.uniform([-480.0, -480.0, 0.0], [560.0, 480.0, 2000.0], size=(117_000, 3))
    rho, alpha, ok = module.inverse(position)
    assert ok.sum() > 100_000
    back, alpha_back, ok_back = module.forward(rho[ok])
    assert ok_back.all()
    assert np.abs(back - position[ok]).max() < ROUND_TRIP_MM
    assert np.abs(alpha_back - alpha[ok]).max() < 1e-12  # 1e-9 mm over the length of a rod


@pytest.mark.parametrize("inside", [1e-6, 1e-3, 0.1, 1.0, 10.0])
def test_forward_of_inverse_close_to_the_rim(module, rim, inside):
    """1e-6 mm inside the rim a drop is about 0.04 mm, and the solution still exact."""
    border, outward = rim
    position = border - inside * outward
    rho, alpha, ok = module.inverse(position)
    assert ok.all()
    # the tilt changes with the root of the distance to the rim: 1e-9 mm of rod instead of 1e-11
    assert np.abs(rods(position, alpha, rho)).max() < 2e-6
    back, _alpha, ok_back = module.forward(rho)
    assert ok_back.all()
    assert np.abs(back - position).max() < ROUND_TRIP_MM


@pytest.mark.parametrize("lengths", [LENGTHS, SKEW], ids=["verne", "skew"])
def test_inverse_closes_the_rods_in_the_working_mode(lengths):
    module = VerneModule(**lengths)
    position = random_positions(3, 20_000)
    rho, alpha, ok = module.inverse(position)
    assert np.abs(rods(position[ok], alpha[ok], rho[ok], lengths)).max() < RESIDUAL_MM2
    assert in_working_mode(position[ok], alpha[ok], rho[ok], lengths).all()


def test_far_from_the_pivot_the_rods_close_near_the_serial_singularity_of_leg_one_too():
    """A geometry whose equation for the tilt bends much where leg I hangs down by a few hundredths of its rod only."""
    lengths = dict(zip(LENGTHS, (82.0, 486.0, 192.0, 451.0, -129.0, 373.0, 210.0, 720.0, 723.0), strict=True))
    pivot = np.array([160.0, 40.0, 690.0])
    gauge = np.random.default_rng(1).uniform(-541, 541, (40_000, 3))
    rho, alpha, ok = VerneModule(**lengths).solve_coupled(pivot, gauge)
    rho, alpha, (x, y, z) = rho[ok], alpha[ok], gauge[ok].T
    c, s = np.cos(alpha), np.sin(alpha)
    position = pivot + np.stack([x, -(c * y - s * z), -(s * y + c * z)], axis=-1)  # P = pivot + F Rx(alpha) g
    assert in_working_mode(position, alpha, rho, lengths).all()
    hanging = drops(position, alpha, rho, lengths)[:, 0] / lengths["L1"]
    assert np.count_nonzero((hanging > 0.03) & (hanging < 0.1)) > 1000
    residual = np.abs(rods(position, alpha, rho, lengths)).max(axis=-1)
    assert residual[hanging > 0.03].max() < 10 * RESIDUAL_MM2


@pytest.mark.parametrize("lengths", [LENGTHS, SKEW], ids=["verne", "skew"])
def test_forward_returns_the_working_mode_or_nothing(lengths):
    """Slider values at random, most of which no pose of the working mode closes."""
    module = VerneModule(**lengths)
    rho = np.random.default_rng(4).uniform(-500.0, 1500.0, size=(20_000, 3))
    position, alpha, ok = module.forward(rho)
    assert 0.2 < ok.mean() < 0.95
    # an accepted residual of 2e-6 mm2 is 1e-9 mm of rod length
    assert np.abs(rods(position[ok], alpha[ok], rho[ok], lengths)).max() < 2e-6
    assert in_working_mode(position[ok], alpha[ok], rho[ok], lengths).all()
    assert np.isnan(position[~ok]).all()
    assert np.isnan(alpha[~ok]).all()


def test_margins_are_the_drops_and_the_distance_to_crossing(module):
    position = random_positions(5, 5000)
    rho, alpha, ok = module.inverse(position)
    margins = module.find_geometry_margins(position, alpha)
    assert margins[ok][:, :3] == pytest.approx(drops(position, alpha, rho)[ok], abs=ROUND_TRIP_MM)
    assert margins[ok][:, 3] == pytest.approx(130.0 * np.cos(alpha[ok]) - 80.0, abs=1e-12)
    assert np.isnan(margins[~ok]).all()


def test_margins_have_the_codes_and_thresholds_of_the_contract(module):
    """VP202 and VP203 are errors below the thresholds and warnings up to twice them, VP201 always an error."""
    names = module.name_margins(70.0, 0.1)
    shown = [(margin.code, margin.axis, margin.unit, margin.error_below, margin.warn_below) for margin in names]
    assert shown == [
        ("VP202", "rho1", "mm", 70.0, 140.0),
        ("VP202", "rho2", "mm", 70.0, 140.0),
        ("VP202", "rho3", "mm", 70.0, 140.0),
        ("VP201", None, "mm", 0.0, 0.0),
        ("VP203", None, "", 0.1, 0.2),
    ]


# --- symmetries -----------------------------------------------------------------------------------


@pytest.mark.parametrize("lengths", [LENGTHS, SKEW], ids=["verne", "skew"])
def test_mirror_in_y_exchanges_legs_ii_and_iii(lengths):
    module = VerneModule(**lengths)
    mirrored = VerneModule(**{**lengths, "L2": lengths["L3"], "L3": lengths["L2"]})
    position = random_positions(6, 10_000)
    rho, alpha, ok = module.inverse(position)
    rho_m, alpha_m, ok_m = mirrored.inverse(position * [1.0, -1.0, 1.0])
    assert (ok == ok_m).all()
    assert rho_m[ok][:, [0, 2, 1]] == pytest.approx(rho[ok], abs=ROUND_TRIP_MM)
    assert -alpha_m[ok] == pytest.approx(alpha[ok], abs=1e-12)
    back, alpha_back, ok_back = mirrored.forward(rho[ok][:, [0, 2, 1]])
    assert ok_back.all()
    assert back * [1.0, -1.0, 1.0] == pytest.approx(position[ok], abs=ROUND_TRIP_MM)
    assert -alpha_back == pytest.approx(alpha[ok], abs=1e-12)


def test_z_shifts_every_slider(module):
    """The sliders run along z: shifting P in z shifts all of them, the tilt stays."""
    position = random_positions(7, 5000)
    rho, alpha, ok = module.inverse(position)
    rho_shifted, alpha_shifted, ok_shifted = module.inverse(position + np.array([0.0, 0.0, 321.5]))
    assert (ok == ok_shifted).all()
    assert rho_shifted[ok] == pytest.approx(rho[ok] + 321.5, abs=ROUND_TRIP_MM)
    assert alpha_shifted[ok] == pytest.approx(alpha[ok], abs=1e-12)


@pytest.mark.parametrize("scale", [1e-3, 1 / 25.4, 25.4, 1e3])
def test_scaling_all_lengths_scales_every_position(module, rim, scale):
    """No length of the code is hidden in its tolerances: the same machine in metres, inches, micrometres."""
    scaled = VerneModule(**{name: scale * value for name, value in LENGTHS.items()})
    border, outward = rim
    position = np.concatenate([random_positions(8, 5000), border - outward, border + outward])
    rho, alpha, ok = module.inverse(position)
    rho_s, alpha_s, ok_s = scaled.inverse(scale * position)
    assert (ok == ok_s).all()
    # relative to a rod of 950 mm: the same 1e-9 mm
    assert rho_s[ok] / scale == pytest.approx(rho[ok], abs=ROUND_TRIP_MM)
    assert alpha_s[ok] == pytest.approx(alpha[ok], abs=1e-12)
    back, _alpha, ok_back = scaled.forward(rho_s[ok])
    assert ok_back.all()
    assert back / scale == pytest.approx(position[ok], abs=ROUND_TRIP_MM)


# --- reach: refused only where no solution exists -------------------------------------------------


def test_unreachable_only_where_a_dense_scan_finds_no_root(module, rim):
    border, outward = rim
    near = [border + away * outward for away in (-20.0, -1.0, -0.01, 0.01, 1.0, 20.0)]
    position = np.concatenate([*near, random_positions(9, 3000)])
    rho, alpha, ok = module.inverse(position)
    assert 1500 < (~ok).sum() < len(ok) - 1500
    certain = np.concatenate([scan(part[:, 0], part[:, 1]) for part in np.array_split(position, 12)])
    assert not (certain & ~ok).any()
    # what is called reachable is proven by the solution itself
    assert np.abs(rods(position[ok], alpha[ok], rho[ok])).max() < RESIDUAL_MM2
    assert in_working_mode(position[ok], alpha[ok], rho[ok]).all()


def test_of_two_working_tilts_the_one_that_legs_ii_and_iii_allow_is_found():
    """Close to leg I's serial singularity (14) has two working roots; a short leg III rules one of them out."""
    g = {**LENGTHS, "leg1_x_offset": -270.0, "R1": 150.0, "r1": 84.0, "L1": 661.0, "leg23_x_offset": 250.0}
    g |= {"R2": 155.0, "r4": 480.0, "L2": 1125.0, "L3": 585.0}
    position = np.array([[-347.97251382, -202.14710888, 0.0]])
    assert scan(position[:, 0], position[:, 1], g).all()  # a solution exists: alpha = 0.71368
    rho, alpha, ok = VerneModule(**g).inverse(position)
    assert ok.all()
    assert alpha == pytest.approx(0.71368222, abs=1e-8)
    assert np.abs(rods(position, alpha, rho, g)).max() < RESIDUAL_MM2


def test_just_outside_the_rim_is_unreachable(module, rim):
    border, outward = rim
    assert not module.inverse(border + 1e-6 * outward)[2].any()


def test_why_not_says_crossing_only_where_crossed_solutions_exist():
    """VP201 where every real solution has R1 cos(alpha) <= r1, VP110 where there is none; from the cubic (9).

    The VERNE's own lengths have no position of the first sort (its legs II and III are shorter
    there than the rim of leg I), so this takes a platform whose legs II and III reach farther when crossed.
    """
    g = {**LENGTHS, "R2": 500.0, "r4": 150.0, "L2": 700.0, "L3": 700.0}
    module = VerneModule(**g)
    position = random_positions(11, 3000)
    position = position[~module.inverse(position)[2]]
    codes = np.array([code for p in position for code in module.explain_unreachable(p, np.zeros((1, 3)))])
    expected = []
    for x, y, _z in position:
        cosines = np.cos(orientations(x, y, g))
        leg2 = g["L2"] ** 2 - (x + g["leg23_x_offset"]) ** 2 - (y - g["R2"] * cosines + g["r4"]) ** 2
        leg3 = g["L3"] ** 2 - (x + g["leg23_x_offset"]) ** 2 - (y + g["R2"] * cosines - g["r4"]) ** 2
        crossed = (leg2 > 0) & (leg3 > 0) & (g["R1"] * cosines <= g["r1"])
        expected.append("VP201" if crossed.any() else "VP110")
    assert codes.tolist() == expected
    assert expected.count("VP201") > 50
    assert expected.count("VP110") > 1000


def test_why_not_takes_several_poses_at_once(module):
    codes = module.explain_unreachable(np.array([900.0, 0.0, 1000.0]), np.array([[0.0, 0.0, 0.0], [50.0, 10.0, 0.0]]))
    assert codes == ["VP110", "VP110"]


# --- shapes and odd input -------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(), (1,), (7,), (3, 4), (2, 3, 5), (0,), (4, 0)])
def test_shapes_follow_the_input(module, shape):
    position = np.broadcast_to([-240.0, -86.0, 1000.0], (*shape, 3))
    rho, alpha, ok = module.inverse(position)
    assert (rho.shape, alpha.shape, ok.shape) == ((*shape, 3), shape, shape)
    assert ok.all()
    back, alpha_back, ok_back = module.forward(rho)
    assert (back.shape, alpha_back.shape, ok_back.shape) == ((*shape, 3), shape, shape)
    assert ok_back.all()
    assert ok.dtype == ok_back.dtype == np.bool_


def test_batch_equals_rows(module):
    """Across the borders of the internal chunks; rows stop iterating together, so they differ by rounding only."""
    position = random_positions(12, 20_000)
    position[5] = np.nan
    rho, alpha, ok = module.inverse(position)
    back, alpha_back, ok_back = module.forward(rho)
    for row in [0, 1, 5, 8190, 8191, 8192, 8193, 16383, 16384, 19_999, *range(100, 300)]:
        rho_row, alpha_row, ok_row = module.inverse(position[row])
        assert ok_row == ok[row]
        np.testing.assert_allclose(rho_row, rho[row], rtol=0, atol=ROUND_TRIP_MM)
        np.testing.assert_allclose(alpha_row, alpha[row], rtol=0, atol=1e-12)
        back_row, alpha_back_row, ok_back_row = module.forward(rho[row])
        assert ok_back_row == ok_back[row]
        np.testing.assert_allclose(back_row, back[row], rtol=0, atol=ROUND_TRIP_MM)
        np.testing.assert_allclose(alpha_back_row, alpha_back[row], rtol=0, atol=1e-12)


def test_lists_and_integers_are_positions_too_and_input_is_left_alone(module):
    rho, _alpha, ok = module.inverse([-240, -86, 1000])
    assert ok
    assert rho == pytest.approx([368.3548, 85.1938, 179.4083], abs=0.5e-4)
    position = random_positions(13, 100)
    before = position.copy()
    rho, _alpha, _ok = module.inverse(position)
    rho_before = rho.copy()
    module.forward(rho)
    np.testing.assert_array_equal(position, before)
    np.testing.assert_array_equal(rho, rho_before)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e9])
@pytest.mark.parametrize("entry", [0, 1, 2])
def test_unsolvable_input_gives_nan_and_not_ok_for_that_row_only(module, bad, entry):
    position = np.tile([-240.0, -86.0, 1000.0], (3, 1))
    rho_good, _alpha, _ok = module.inverse(position)
    sliders = rho_good.copy()
    position[1, entry] = bad
    sliders[1, entry] = bad
    rho, alpha, ok = module.inverse(position)
    if bad == 1e9 and entry == 2:  # the sliders have no end here: any z can be reached
        assert ok.all()
    else:
        assert ok.tolist() == [True, False, True]
        assert np.isnan(rho[1]).all()
        assert np.isnan(alpha[1])
        np.testing.assert_array_equal(rho[[0, 2]], rho_good[[0, 2]])
    back, alpha, ok = module.forward(sliders)
    assert ok.tolist() == [True, False, True]
    assert np.isnan(back[1]).all()
    assert np.isnan(alpha[1])


@pytest.mark.parametrize("position", [[2000.0, 0.0, 1000.0], [0.0, -700.0, 1000.0], [-600.0, 0.0, 500.0]])
def test_out_of_reach_is_nan_and_not_ok(module, position):
    rho, alpha, ok = module.inverse(np.array(position))
    assert not ok
    assert np.isnan(rho).all()
    assert np.isnan(alpha)


@pytest.mark.parametrize("shape", [(), (2,), (4,), (6,), (3, 2), (3, 4), (1, 6)])
def test_wrong_shapes_raise(module, shape):
    with pytest.raises(ValueError, match="shape"):
        module.inverse(np.zeros(shape))
    with pytest.raises(ValueError, match="shape"):
        module.forward(np.zeros(shape))
