"""Newton-Raphson on the full constraint equations against the product: two roads, one pose."""

import numpy as np
import pytest
from newton_raphson import (
    VERNE,
    _forward_dense_step,
    _forward_step,
    _inverse_dense_step,
    _inverse_step,
    centre,
    forward,
    forward_from,
    forward_machine,
    in_working_mode,
    inverse,
    middle,
    numbers_of,
    pose_without_tilt,
)

#: Agreement in mm and of unit vectors. Measured 1e-12 and 1e-15; the rest is room for another platform's rounding.
SAME_MM = 1e-9
SAME_AXIS = 1e-12


@pytest.fixture(scope="module", params=["as shipped", "no offset zero"])
def five_axis(request, machine_with):
    changes = {
        "table.pivot": [6.0, -9.0, 1580.0],
        "table.rotary_offset": [12.0, -8.0, 35.0],
        "spindle.nose_offset_mm": 42.0,
        "module.L2": 960.0,
        "module.L3": 935.0,
    }
    return machine_with(changes if request.param == "no offset zero" else {}).five_axis


def poses(seed, n):
    """Tips within +-150 mm and 0 to 150 mm high, tilts up to 90 degrees, tools 50 to 250 mm: all within reach."""
    rng = np.random.default_rng(seed)
    tip = rng.uniform([-150.0, -150.0, 0.0], [150.0, 150.0, 150.0], (n, 3))
    b, c = rng.uniform(0.0, np.pi / 2, n), rng.uniform(-np.pi, np.pi, n)
    return tip, np.stack([np.sin(b) * np.sin(c), np.sin(b) * np.cos(c), np.cos(b)], axis=-1), rng.uniform(50, 250, n)


@pytest.mark.parametrize("dense", [False, True])
def test_inverse_agrees_with_the_product(five_axis, dense):
    tip, axis, tool = poses(1, 5000 if dense else 50_000)
    lengths, table = numbers_of(five_axis)
    for start in (None, middle(lengths, table, len(tip))):
        solved, q = inverse(lengths, table, tip, axis, tool, start, dense)
        expected, ok = five_axis.inverse(tip, axis, tool)
        assert ok.all()
        assert solved.ok.all()
        assert np.abs(q - expected)[:, :3].max() < SAME_MM
        assert np.abs(q - expected)[:, 3:].max() < SAME_AXIS


@pytest.mark.parametrize("dense", [False, True])
def test_forward_agrees_with_the_product(five_axis, dense):
    tip, axis, tool = poses(2, 5000 if dense else 50_000)
    q, _ok = five_axis.inverse(tip, axis, tool)
    solved, tip_back, axis_back = forward_machine(*numbers_of(five_axis), q, tool, dense=dense)
    expected_tip, expected_axis, ok = five_axis.forward(q, tool)
    assert ok.all()
    assert solved.ok.all()
    for there in (expected_tip, tip):
        assert np.abs(tip_back - there).max() < SAME_MM
    for there in (expected_axis, axis):
        assert np.abs(axis_back - there).max() < SAME_AXIS


def test_elimination_by_hand_is_the_general_solution(five_axis):
    """From starts all over the place one step is that of the general system, so no iterate is another one."""
    rng = np.random.default_rng(3)
    lengths, table = numbers_of(five_axis)
    tip, axis, tool = poses(3, 2000)
    around = rng.uniform(-1.0, 1.0, (8, 2000)) * [[200], [200], [200], [0.5], [200], [200], [200], [0.5]]
    start = pose_without_tilt(lengths, table, tip, axis, tool).T + around
    b, c = np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]), np.arctan2(axis[:, 0], axis[:, 1])
    o = np.array(table.rotary_offset)[:, None]
    vx = o[0] + np.cos(c) * tip[:, 0] - np.sin(c) * tip[:, 1] + table.pivot[0]
    vy = o[1] + np.sin(c) * tip[:, 0] + np.cos(c) * tip[:, 1]
    data = np.stack([vx, vy, o[2] + tip[:, 2], b, table.nose + tool])
    for by_hand, general, u, known in (
        (_inverse_step(lengths, table), _inverse_dense_step(lengths, table), start, data),
        (_forward_step(lengths), _forward_dense_step(lengths), start[:4], start[4:7]),
    ):
        expected = general(u, known)
        tame = np.abs(expected).max(axis=0) < 1e4  # an almost singular system is known to fewer digits
        assert tame.mean() > 0.9
        assert np.abs(by_hand(u, known) - expected)[:, tame].max() < 1e-7  # of steps of up to 1e4 mm


def test_a_solution_in_another_mode_or_none_is_not_returned(machine):
    """Starts all over the place: many iterations come to rest at other assembly modes, some nowhere."""
    rng = np.random.default_rng(4)
    tip, axis, tool = poses(4, 5000)
    lengths, _table = numbers_of(machine.five_axis)
    rho = machine.inverse(tip, axis, tool)[0][:, :3]
    start = rng.uniform([-800, -800, -800, -np.pi], [800, 800, 2000, np.pi], (5000, 4))
    solved = forward(lengths, rho, start)
    other = solved.at_rest & ~solved.ok
    assert 0.1 < other.mean() < 0.9
    assert np.isnan(solved.values[~solved.ok]).all()
    position, alpha, _ok = machine.module.forward(rho)
    assert np.abs(solved.values[solved.ok, :3] - position[solved.ok]).max() < SAME_MM
    # some iterations turned the platform hundreds of times before they came to rest, which costs digits of alpha
    assert np.abs(solved.values[solved.ok, 3] - alpha[solved.ok]).max() < 1e-11
    # what is refused closes the rods indeed, in another mode
    pose, _steps, _at_rest = forward_from(lengths, rho, start)
    assert not in_working_mode(lengths, pose[other], rho[other]).any()


@pytest.mark.parametrize("dense", [False, True])
def test_poses_out_of_reach_are_failures(machine, dense):
    lengths, table = numbers_of(machine.five_axis)
    rng = np.random.default_rng(5)
    tip, axis, tool = poses(5, 300)
    tip = tip + [[900.0, 0.0, 0.0]] * np.sign(rng.uniform(-1, 1, (300, 1)))
    axis = np.tile([0.0, 0.0, 1.0], (300, 1))  # C = 0, so that x of P is that of the tip: beyond every rod
    solved, q = inverse(lengths, table, tip, axis, tool, dense=dense)
    assert not solved.ok.any()
    assert np.isnan(q).all()
    assert np.isnan(solved.values).all()
    rho = np.tile([50.0, 2500.0, 50.0], (3, 1))  # slider 2 hangs too deep for both others
    solved = forward(lengths, rho, dense=dense)
    assert not solved.ok.any()
    assert np.isnan(solved.values).all()


@pytest.mark.parametrize("dense", [False, True])
def test_a_singular_row_fails_alone(dense):
    """At w = 0 and alpha = 0 leg I cannot be told from its mirror image: the Jacobian of (3)-(6) is singular."""
    rho = np.tile([674.0137, 685.1566, 250.41], (3, 1))
    start = centre(VERNE, rho)
    start[1] = [80.0, 0.0, np.nan, 0.0]
    start[2, 1:] = [0.0, rho[2, 0], 0.0]
    solved = forward(VERNE, rho, start, dense)
    assert solved.ok[0]
    assert not solved.ok[1]
    # case (a) of Table III, printed to 0.01 mm
    assert solved.values[0, :3] == pytest.approx([-199.80, 355.92, 1242.0], abs=0.01)
