"""The serial spindle over the tilting table: exact reference table, the textbook's trunnion formulas, odd input."""

from pathlib import Path

import numpy as np
import pytest

from verne_post import load_machine
from verne_post.kinematics.modules.serial import SerialModule
from verne_post.model.moves import Frame

REFERENCE = Path(__file__).resolve().parents[1] / "reference" / "serial.csv"
#: Sums of a few products of numbers up to 2000: a dozen roundings of 2e-13.
EXACT = 1e-10

#: Every length of the chain is there, so that none can be forgotten or change its sign.
OFFSETS = {
    "table.pivot": [15.0, -25.0, 1580.0],
    "table.rotary_offset": [4.0, -7.0, 30.0],
    "spindle.nose_offset_mm": 20.0,
    "module.zero": [-10.0, 5.0, 1000.0],
}


@pytest.fixture(scope="module")
def offset_machine(machine_with):
    return machine_with(OFFSETS, "serial")


def test_reference_table_both_ways(offset_machine):
    table = np.genfromtxt(REFERENCE, delimiter=",", names=True, skip_header=3)
    tip = np.column_stack([table["tip_x"], table["tip_y"], table["tip_z"]])
    angles = np.radians(np.column_stack([table["a_deg"], table["c_deg"]]))
    expected = np.column_stack([table["x_mm"], table["y_mm"], table["z_mm"], angles])
    q, platform, ok = offset_machine.five_axis.solve(tip, angles, table["tool_mm"])
    alpha = platform.alpha
    assert ok.all()
    assert not alpha.any()
    np.testing.assert_allclose(q, expected, rtol=0, atol=EXACT)
    back, angles_back, ok = offset_machine.five_axis.find_nominal_pose(expected, table["tool_mm"])
    assert ok.all()
    np.testing.assert_allclose(back, tip, rtol=0, atol=EXACT)
    np.testing.assert_allclose(angles_back, angles, rtol=0, atol=1e-15)


def textbook(q_part, a, c, dy, dz):
    """The inverse transformation of a table that tilts about x and turns about z (LinuxCNC's xyzac-trt).

    Written out from the published chain of matrices: the part's point is ``Rz(-C) (D + Rx(-A) P)``, D = (0, dy, dz)
    from the tilt axis to the rotary centre counted against the part, P from the tilt axis to the tip along x, y, z.
    """
    x, y, z = np.moveaxis(q_part, -1, 0)
    sa, ca, sc, cc = np.sin(a), np.cos(a), np.sin(c), np.cos(c)
    px = cc * x - sc * y
    py = sc * ca * x + cc * ca * y - sa * z - ca * dy + sa * dz
    pz = sc * sa * x + cc * sa * y + ca * z - sa * dy - ca * dz
    return np.stack([px, py, pz], axis=-1)


def test_agrees_with_the_textbooks_trunnion_table(machine_with):
    """D is minus our rotary offset; tool and nose add to z, the zero point shifts all three."""
    offset = [0.0, -7.0, 30.0]  # the published table has no offset along the tilt axis
    machine = machine_with({**OFFSETS, "table.rotary_offset": offset}, "serial")
    rng = np.random.default_rng(11)
    n = 500
    tip = rng.uniform(-200, 200, (n, 3))
    angles = rng.uniform(-np.pi, np.pi, (n, 2))
    tool = rng.uniform(0, 250, n)
    axes = textbook(tip, angles[:, 0], angles[:, 1], -offset[1], -offset[2])
    axes[:, 2] += tool + 20.0
    # pivot - zero in the base frame is (25, -30, 580); y and z point the other way in the machine's axes
    axes += [25.0, 30.0, -580.0]
    q, _platform, ok = machine.five_axis.solve(tip, angles, tool)
    assert ok.all()
    np.testing.assert_allclose(q[:, :3], axes, rtol=0, atol=EXACT)
    np.testing.assert_array_equal(q[:, 3:], angles)


def test_the_tool_axis_is_the_textbooks():
    """Third column of the published matrix: tan C = kx / ky, cos A = kz; the spindle itself is upright."""
    machine = load_machine("serial")
    rng = np.random.default_rng(12)
    axis = rng.normal(size=(200, 3))
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    q, ok = machine.inverse(np.zeros((200, 3)), axis, 100.0)
    assert ok.all()
    np.testing.assert_allclose(np.cos(q[:, 3]), axis[:, 2], rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.sin(q[:, 4]) * axis[:, 1], np.cos(q[:, 4]) * axis[:, 0], rtol=0, atol=1e-12)
    tip, back, ok = machine.forward(q, 100.0)
    assert ok.all()
    np.testing.assert_allclose(back, axis, rtol=0, atol=1e-12)
    np.testing.assert_allclose(tip, 0.0, rtol=0, atol=EXACT)


@pytest.mark.parametrize("offsets", [False, True], ids=["shipped", "offsets"])
def test_columns_are_machine_coordinates_where_zero_is_machine_zero(machine_with, offsets):
    """What G53 names is what the columns show: the shipped file, and the rule of docs/machines.md for any other."""
    machine = load_machine("serial")
    if offsets:  # zero = pivot + F (rotary_offset + machine_zero + (0, 0, nose_offset))
        zero = [15.0 + 4.0, -25.0 + 7.0, 1580.0 - (30.0 + 550.0 + 20.0)]
        machine = machine_with({**OFFSETS, "module.zero": zero}, "serial")
    rng = np.random.default_rng(13)
    wanted = np.zeros((50, 9))
    wanted[:, :3], wanted[:, 3], wanted[:, 5] = rng.uniform(-300, 100, (50, 3)), rng.uniform(-90, 90, 50), 77.0
    frame = Frame(tool=(0.0, 0.0, 130.0, *(0.0,) * 6))
    tip, angles = machine.coordinates.map_to_table(machine.coordinates.map_to_program(wanted, frame), frame)
    q, _platform, ok = machine.five_axis.solve(tip, angles, 130.0)
    assert ok.all()
    np.testing.assert_allclose(q * [c.factor for c in machine.columns], wanted[:, [0, 1, 2, 3, 5]], rtol=0, atol=EXACT)


def test_only_one_solution_and_no_margins():
    module = SerialModule(zero=[1.0, 2.0, 3.0])
    (only,) = module.inverse_all(np.array([11.0, 22.0, 33.0]))
    assert (only.rho, only.alpha, only.signs, only.refused) == ((10.0, -20.0, -30.0), 0.0, (), None)
    (mode,) = module.forward_all(np.array(only.rho))
    assert (mode.position, mode.alpha, mode.refused) == ((11.0, 22.0, 33.0), 0.0, None)
    assert module.find_geometry_margins(np.zeros((4, 3)), np.zeros(4)).shape == (4, 0)
    assert load_machine("serial").margins == ()


def test_rows_that_are_no_numbers_are_not_ok():
    module = SerialModule(zero=[0.0, 0.0, 1000.0])
    points = np.array([[1.0, 2.0, 3.0], [np.nan, 0.0, 0.0], [0.0, np.inf, 0.0]])
    for solve in (module.inverse, module.forward, lambda p: module.solve_coupled(np.zeros(3), p)):
        value, alpha, ok = solve(points)
        assert ok.tolist() == [True, False, False]
        assert np.isnan(value[1:]).all()
        assert np.isfinite(value[0]).all()
        assert alpha[0] == 0.0
        assert np.isnan(alpha[1:]).all()
    assert module.inverse_all(points[1]) == module.forward_all(points[2]) == []
    assert module.explain_unreachable(np.zeros(3), points[1:]) == ["VP110"] * 2


@pytest.mark.parametrize("shape", [(), (0,), (7,), (2, 3)])
def test_shapes(shape):
    module = SerialModule(zero=[0.0, 0.0, 1000.0])
    for value, alpha, ok in (module.inverse(np.ones((*shape, 3))), module.forward(np.ones((*shape, 3)))):
        assert (value.shape, alpha.shape, ok.shape) == ((*shape, 3), shape, shape)
