"""The linear delta: exact reference table, the rods of its parallelograms, every mode, its singularities, odd input."""

from pathlib import Path

import numpy as np
import pytest

from verne_post import check, load_machine
from verne_post.kinematics.modules.linear_delta import LinearDeltaModule

REFERENCE = Path(__file__).resolve().parents[1] / "reference" / "linear_delta.csv"
#: A rounding of 1e-13 mm grows by at most a rod over its drop, which is below 20 for all points here.
ROUND_TRIP_MM = 1e-9

LENGTHS = {"platform_radius": 150.0, "base_radius": 500.0, "rod_length": 900.0}
MODULE = LinearDeltaModule(**LENGTHS, leg_angles_deg=(0.0, 120.0, 240.0))
#: Three different angles, not in order: nothing may rest on symmetry or on the numbering.
SKEW = LinearDeltaModule(**LENGTHS, leg_angles_deg=(10.0, 255.0, 130.0))
#: Legs crowded on one side: only such a machine has a parallel singularity with every slider above the platform.
CROWDED = LinearDeltaModule(
    platform_radius=150.0, base_radius=900.0, rod_length=900.0, leg_angles_deg=(0.0, 10.0, 20.0)
)
OFFSETS = {
    "table.pivot": [15.0, -25.0, 1580.0],
    "table.rotary_offset": [4.0, -7.0, 30.0],
    "spindle.nose_offset_mm": 20.0,
    "module.platform_radius": 140.0,
    "module.base_radius": 480.0,
    "module.rod_length": 900.0,
    "module.leg_angles_deg": [0.0, 120.0, 240.0],
}


def rods(module, position, rho):
    """Rod vectors (..., 3 legs, 3) from slider joint to platform joint, from the two radii themselves."""
    theta = np.radians(module.leg_angles_deg)
    out = np.stack([np.cos(theta), np.sin(theta), np.zeros(3)], axis=-1)
    slider = module.base_radius * out + np.asarray(rho)[..., :, None] * [0.0, 0.0, 1.0]
    return np.asarray(position)[..., None, :] + module.platform_radius * out - slider


def excess(module, position, rho):
    """Lengths of the rods minus what they should be, (..., 3) mm."""
    return np.linalg.norm(rods(module, position, rho), axis=-1) - module.rod_length


def points(n=2000, seed=1, size=450.0):
    rng = np.random.default_rng(seed)
    return rng.uniform([-size, -size, 900.0], [size, size, 1700.0], (n, 3))


def test_reference_table_both_ways(machine_with):
    machine = machine_with(OFFSETS, "linear_delta")
    table = np.genfromtxt(REFERENCE, delimiter=",", names=True, skip_header=3)
    tip = np.column_stack([table["tip_x"], table["tip_y"], table["tip_z"]])
    angles = np.radians(np.column_stack([table["a_deg"], table["c_deg"]]))
    expected = np.column_stack([table["rho1_mm"], table["rho2_mm"], table["rho3_mm"], angles])
    q, platform, ok = machine.five_axis.solve(tip, angles, table["tool_mm"])
    alpha = platform.alpha
    assert ok.all()
    assert not alpha.any()
    np.testing.assert_allclose(q, expected, rtol=0, atol=ROUND_TRIP_MM)
    back, _angles, ok = machine.five_axis.find_nominal_pose(expected, table["tool_mm"])
    assert ok.all()
    np.testing.assert_allclose(back, tip, rtol=0, atol=ROUND_TRIP_MM)


@pytest.mark.parametrize("module", [MODULE, SKEW], ids=["regular", "skew"])
def test_inverse_closes_the_rods_and_forward_returns(module):
    position = points()
    rho, alpha, ok = module.inverse(position)
    assert ok.mean() > 0.9
    rho, position = rho[ok], position[ok]
    assert not alpha[ok].any()
    assert np.abs(excess(module, position, rho)).max() < 1e-11
    assert (rods(module, position, rho)[..., 2] > 0).all()  # every slider above the platform; z points down
    back, alpha, ok = module.forward(rho)
    assert ok.all()
    assert not alpha.any()
    drop = rods(module, position, rho)[..., 2].min(axis=1)
    assert np.abs(back - position)[drop > 45.0].max() < ROUND_TRIP_MM
    assert np.abs(back - position).max() < 1e-6


def test_coupled_is_the_upright_position():
    gauge = np.random.default_rng(2).uniform([-200, -200, 100], [200, 200, 500], (50, 3))
    pivot = np.array([15.0, -25.0, 1580.0])
    direct = MODULE.inverse(pivot + gauge * [1, -1, -1])
    for one, other in zip(MODULE.solve_coupled(pivot, gauge), direct, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_third_of_a_turn_exchanges_the_legs():
    position = points(50, size=250.0)
    c, s = np.cos(2 * np.pi / 3), np.sin(2 * np.pi / 3)
    turned = position @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(MODULE.inverse(turned)[0], MODULE.inverse(position)[0][:, [2, 0, 1]], atol=1e-10)


def test_numbering_does_not_matter():
    """The same legs numbered clockwise: the same machine with two sliders exchanged, in every function."""
    other = LinearDeltaModule(**LENGTHS, leg_angles_deg=(0.0, 240.0, 120.0))
    position = points(3000, size=900.0)
    rho, _alpha, ok = MODULE.inverse(position)
    rho_other, _alpha, ok_other = other.inverse(position)
    np.testing.assert_array_equal(ok, ok_other)
    np.testing.assert_allclose(rho_other[ok], rho[ok][:, [0, 2, 1]], rtol=0, atol=1e-8)
    back, _alpha, ok_back = other.forward(rho_other[ok])
    assert ok_back.all()
    np.testing.assert_allclose(back, position[ok], rtol=0, atol=1e-3)  # some of them right at the rim


# --- every mode --------------------------------------------------------------------------------------


@pytest.mark.parametrize("module", [MODULE, SKEW], ids=["regular", "skew"])
def test_eight_working_modes_with_reasons(module):
    for position in points(20, seed=4, size=250.0):
        found = module.inverse_all(position)
        assert sorted(one.signs for one in found) == [(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
        (used,) = [one for one in found if one.refused is None]
        assert used is found[0]
        assert used.signs == (-1, -1, -1)
        np.testing.assert_allclose(used.rho, module.inverse(position)[0], rtol=0, atol=1e-12)
        for one in found:
            assert np.abs(excess(module, position, np.array(one.rho))).max() < 1e-10
            for name, sign in zip(module.actuators, one.signs, strict=True):
                assert (f"attachment of {name} not above" in (one.refused or "")) == (sign > 0)
            # the rods close, so the position must be among the assembly modes of these sliders
            apart = [np.abs(np.array(m.position) - position).max() for m in module.forward_all(np.array(one.rho))]
            assert min(apart) < 1e-6


def test_two_assembly_modes_mirror_each_other():
    """Level sliders: straight above and below by the drop. Others: mirrored in the plane of the slider joints."""
    lower, upper = MODULE.forward_all(np.array([400.0, 400.0, 400.0]))
    drop = np.sqrt(900.0**2 - 350.0**2)
    assert lower.position == pytest.approx((0.0, 0.0, 400.0 + drop), abs=1e-9)
    assert upper.position == pytest.approx((0.0, 0.0, 400.0 - drop), abs=1e-9)
    assert lower.refused is None
    for name in MODULE.actuators:
        assert f"attachment of {name} not above" in upper.refused
    assert "parallel singularity" in upper.refused
    rng = np.random.default_rng(5)
    for rho in rng.uniform(200, 900, (30, 3)):
        modes = MODULE.forward_all(rho)
        assert len(modes) == 2
        assert [mode.refused is None for mode in modes] == [True, False]
        for mode in modes:
            assert np.abs(excess(MODULE, mode.position, rho)).max() < 1e-10
        np.testing.assert_allclose(modes[0].position, MODULE.forward(rho)[0], rtol=0, atol=1e-12)
        between = np.subtract(modes[0].position, modes[1].position)
        for one, other in ((0, 1), (0, 2)):  # at right angles to the plane of the spheres' centres
            edge = rods(MODULE, np.zeros(3), rho)[one] - rods(MODULE, np.zeros(3), rho)[other]
            assert abs(between @ edge) < 1e-6


def test_forward_is_ok_exactly_where_the_inverse_returns():
    """Far apart sliders can hold the platform above one of them: real, but not the working mode."""
    sliders = np.random.default_rng(8).uniform(0.0, 1500.0, (3000, 3))
    position, _alpha, ok = SKEW.forward(sliders)
    np.testing.assert_allclose(SKEW.inverse(position[ok])[0], sliders[ok], rtol=0, atol=1e-5)  # some rods lie flat
    others = [SKEW.forward_all(row) for row in sliders[~ok]]
    held = [modes for modes in others if modes]
    assert len(held) > 50
    assert all(mode.refused for modes in held for mode in modes)
    assert any("attachment" in modes[0].refused and "singularity" not in modes[0].refused for modes in held)


def test_spheres_that_do_not_meet_have_no_mode():
    rho = np.array([0.0, 0.0, 2500.0])
    assert MODULE.forward_all(rho) == []
    position, alpha, ok = MODULE.forward(rho)
    assert not ok
    assert np.isnan(position).all()
    assert np.isnan(alpha)


# --- what cannot be reached --------------------------------------------------------------------------


def beyond():
    """Points with three real rods from sliders above, on the wrong side of the plane of the slider joints."""
    position = points(20000, seed=6, size=1100.0)
    away = rods(CROWDED, position, np.zeros(3))[..., :2]
    radicand = 900.0**2 - np.sum(away**2, axis=-1)
    real = (radicand > 0).all(axis=1)
    position, rho = position[real], position[real][:, 2, None] - np.sqrt(radicand[real])
    side = np.linalg.det(rods(CROWDED, position, rho))
    middle = np.linalg.det(rods(CROWDED, [0.0, 0.0, 800.0], [0.0, 0.0, 0.0]))
    return position[side * middle < 0], rho[side * middle < 0]


def test_beyond_a_parallel_singularity_nothing_is_solved():
    """There the sliders of the working mode carry the platform to another place: it would have to pass the
    singularity.
    """
    position, rho = beyond()
    assert len(position) > 50
    _rho, _alpha, ok = CROWDED.inverse(position)
    assert not ok.any()
    assert set(CROWDED.explain_unreachable(np.zeros(3), position * [1, -1, -1])) == {"VP203"}
    back, _alpha, ok = CROWDED.forward(rho)
    assert np.median(np.abs(back[ok] - position[ok]).max(axis=1)) > 1.0
    assert CROWDED.inverse(back[ok])[2].all()
    refused = [one.refused for one in CROWDED.inverse_all(position[0])]
    assert all(refused)
    assert any(reason.startswith("beyond a parallel singularity") for reason in refused)


def test_the_check_reports_what_lies_beyond(machine_with):
    position, _rho = beyond()
    # the tip at A = C = 0 without a tool, seen from a pivot at z = 1600 of the base frame
    x, y, z = position[np.abs(position[:, 2] - 1200.0).argmin()] * [1, -1, -1] + [0, 0, 1600]
    keys = {"base_radius": 900.0, "leg_angles_deg": [0.0, 10.0, 20.0]}
    machine = machine_with({f"module.{key}": value for key, value in keys.items()}, "linear_delta")
    source = f"G49 G0 X{x:.6f} Y{y:.6f} Z{z:.6f} A0 C0\nG1 Z{z + 1:.6f} F100\nM2\n"
    result = check(source.encode(), machine)
    assert result.exit_code == 1
    (found,) = [item for item in result.findings if item.code == "VP203"]
    assert (found.severity, found.line) == ("error", 2)
    assert "beyond a parallel singularity" in found.message


@pytest.mark.parametrize("module", [MODULE, SKEW], ids=["regular", "skew"])
def test_legs_spread_around_have_no_parallel_singularity(module):
    """With every slider above the platform: wherever the rods reach, the pose is solved."""
    position = points(20000, seed=7, size=900.0)
    reach = np.linalg.norm(rods(module, position, np.zeros(3))[..., :2], axis=-1).max(axis=1) < module.rod_length
    np.testing.assert_array_equal(module.inverse(position)[2], reach)


def test_too_far_away_is_out_of_reach():
    position = np.array([[1300.0, 0.0, 1200.0], [0.0, 900.0, 1200.0], [0.0, 0.0, 1200.0]])
    rho, _alpha, ok = MODULE.inverse(position)
    assert ok.tolist() == [False, False, True]
    assert np.isnan(rho[:2]).all()
    assert MODULE.explain_unreachable(np.zeros(3), position[:2] * [1, -1, -1]) == ["VP110", "VP110"]
    assert MODULE.inverse_all(position[0]) == []


def test_a_rod_that_almost_lies_flat_still_has_both_modes():
    """Half a millimetre of drop: the first leg's slider is so far above the platform, or below."""
    position = np.array([350.0 - np.sqrt(900.0**2 - 0.5**2), 0.0, 1200.0])
    found = MODULE.inverse_all(position)
    assert len(found) == 8
    assert sorted({round(one.rho[0], 6) for one in found}) == [1199.5, 1200.5]


def test_margins_are_the_drops_of_the_rods():
    position = points(200, size=300.0)
    rho, alpha, ok = SKEW.inverse(position)
    assert ok.all()
    margins = SKEW.find_geometry_margins(position, alpha)
    np.testing.assert_allclose(margins[:, :3], rods(SKEW, position, rho)[..., 2], rtol=0, atol=1e-9)
    determinant = np.linalg.det(rods(SKEW, position, rho) / SKEW.rod_length)
    np.testing.assert_allclose(margins[:, 3], np.sign(determinant[0]) * determinant, rtol=0, atol=1e-12)
    names = load_machine("linear_delta").margins
    assert [(one.code, one.axis, one.error_below, one.warn_below) for one in names] == [
        *(("VP202", joint, 100.0, 200.0) for joint in SKEW.actuators),
        ("VP203", None, -np.inf, -np.inf),
    ]


def test_jacobians_against_central_differences():
    position = points(50, size=250.0)
    rho, alpha, ok = SKEW.inverse(position)
    assert ok.all()
    parallel, serial = SKEW.find_jacobians(position, alpha, rho)
    step = 1e-4

    def half(p, q):
        return 0.5 * (np.sum(rods(SKEW, p, q) ** 2, axis=-1) - SKEW.rod_length**2)

    for k, unit in enumerate(np.eye(3)):
        by_pose = (half(position + step * unit, rho) - half(position - step * unit, rho)) / (2 * step)
        by_rho = (half(position, rho + step * unit) - half(position, rho - step * unit)) / (2 * step)
        np.testing.assert_allclose(parallel[:, :3, k], by_pose, rtol=0, atol=1e-5)
        np.testing.assert_allclose(serial[:, :3, k], by_rho, rtol=0, atol=1e-5)
    assert (parallel[:, 3] == [0, 0, 0, 1]).all()


def test_rows_that_are_no_numbers_are_not_ok():
    odd = np.array([[0.0, 0.0, 1200.0], [np.nan, 0.0, 0.0], [0.0, np.inf, 0.0], [0.0, 0.0, np.inf], [1e200, 0.0, 0.0]])
    for solve in (MODULE.inverse, lambda p: MODULE.solve_coupled(np.zeros(3), p * [1, -1, -1])):
        rho, alpha, ok = solve(odd)
        assert ok.tolist() == [True, False, False, False, False]
        assert np.isnan(rho[1:]).all()
        assert np.isnan(alpha[1:]).all()
    assert len(MODULE.explain_unreachable(np.zeros(3), odd)) == len(odd)
    for row in odd[1:]:
        assert MODULE.inverse_all(row) == []
        assert MODULE.forward_all(row) == []
    position, alpha, ok = MODULE.forward(np.array([[400.0, 400.0, 400.0], [np.nan, 0.0, 0.0], [np.inf, 0.0, 1.0]]))
    assert ok.tolist() == [True, False, False]
    assert np.isnan(position[1:]).all()
    assert np.isnan(alpha[1:]).all()


@pytest.mark.parametrize("shape", [(), (0,), (7,), (2, 3)])
def test_shapes(shape):
    position = np.broadcast_to([10.0, 20.0, 1200.0], (*shape, 3))
    rho, alpha, ok = MODULE.inverse(position)
    assert (rho.shape, alpha.shape, ok.shape) == ((*shape, 3), shape, shape)
    back, alpha, ok = MODULE.forward(rho)
    assert (back.shape, alpha.shape, ok.shape) == ((*shape, 3), shape, shape)
    assert MODULE.find_geometry_margins(position, alpha).shape == (*shape, 4)
