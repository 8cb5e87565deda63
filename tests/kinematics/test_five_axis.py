"""The whole machine: module, tilting table and program coordinates, against frames written out as matrices."""

import itertools

import numpy as np
import pytest

from verne_post.model.findings import UsageError
from verne_post.model.moves import Frame

from ..builders import axis_of, rods

#: F of the frames page: base (z down) to upright and back.
F = np.diag([1.0, -1.0, -1.0])
#: Round trips in mm and of unit vectors. Measured 7e-13 and 7e-16; the rest is room for another platform.
ROUND_TRIP_MM = 1e-9
ROUND_TRIP_AXIS = 1e-12

PIVOT, ROTARY_OFFSET, MACHINE_ZERO, NOSE = [6.0, -9.0, 1580.0], [12.0, -8.0, 35.0], [3.0, -2.0, 540.0], 42.0


@pytest.fixture(scope="module")
def offset_machine(machine_with):
    """A machine in which no offset is zero."""
    return machine_with(
        {
            "table.pivot": PIVOT,
            "table.rotary_offset": ROTARY_OFFSET,
            "table.machine_zero": MACHINE_ZERO,
            "spindle.nose_offset_mm": NOSE,
        }
    )


# --- frames, independent of the code under test ---------------------------------------------------


def rx(angle):
    """Rx of the frames page, shape (..., 3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    one, zero = np.ones_like(c), np.zeros_like(c)
    return np.stack([one, zero, zero, zero, c, -s, zero, s, c], axis=-1).reshape(*np.shape(c), 3, 3)


def rz(angle):
    """The same about z."""
    c, s = np.cos(angle), np.sin(angle)
    one, zero = np.ones_like(c), np.zeros_like(c)
    return np.stack([c, -s, zero, s, c, zero, zero, zero, one], axis=-1).reshape(*np.shape(c), 3, 3)


def turn(matrix, vector):
    return np.einsum("...ij,...j->...i", matrix, vector)


def on_table(point_base, a, c, pivot, rotary_offset):
    """A point of the base frame in the table frame, by inverting the chain of the frames page."""
    tilted = turn(F, point_base - np.asarray(pivot))
    return turn(rz(-c), turn(rx(-a), tilted) - np.asarray(rotary_offset))


def random_poses(seed, n):
    """Tips over the table, tool axes over the whole sphere, tools of 0 to 300 mm; nearly all within reach."""
    rng = np.random.default_rng(seed)
    tip = rng.uniform([-250.0, -250.0, -50.0], [250.0, 250.0, 350.0], size=(n, 3))
    axis = rng.normal(size=(n, 3))
    return tip, axis / np.linalg.norm(axis, axis=1, keepdims=True), rng.uniform(0.0, 300.0, n)


# --- the chain ------------------------------------------------------------------------------------


def test_inverse_satisfies_the_chain_of_frames(offset_machine):
    """U = P + Rx(alpha) (0, 0, l) is the tip carried by the table, and both see the same tool axis."""
    tip, axis, length = random_poses(1, 20_000)
    q, ok = offset_machine.inverse(tip, axis, length)
    assert ok.mean() > 0.9
    tip, axis, length, q = tip[ok], axis[ok], length[ok], q[ok]
    position, alpha, _ok = offset_machine.module.forward(q[:, :3])
    # that (P, alpha) closes the rods is checked here, so nothing of the code under test is believed
    assert np.abs(rods(position, alpha, q[:, :3])).max() < 1e-8  # mm2; 1e-11 mm on a rod
    tool = np.stack([0 * length, 0 * length, NOSE + length], axis=-1)
    tip_base = position + turn(rx(alpha), tool)
    a, c = q[:, 3], q[:, 4]
    carried = np.asarray(PIVOT) + turn(F, turn(rx(a), np.asarray(ROTARY_OFFSET) + turn(rz(c), tip)))
    assert np.abs(tip_base - carried).max() < ROUND_TRIP_MM
    axis_upright = np.stack([0 * alpha, -np.sin(alpha), np.cos(alpha)], axis=-1)
    assert np.abs(turn(rx(a), turn(rz(c), axis)) - axis_upright).max() < ROUND_TRIP_AXIS


def test_forward_equals_the_chain_of_frames(offset_machine):
    rng = np.random.default_rng(2)
    position = rng.uniform([-300.0, -300.0, 500.0], [400.0, 300.0, 1400.0], size=(5000, 3))
    rho, alpha, ok = offset_machine.module.inverse(position)
    assert ok.all()
    a, c = rng.uniform(-2.0, 2.0, 5000), rng.uniform(-9.0, 9.0, 5000)
    length = rng.uniform(0.0, 300.0, 5000)
    tip, axis, ok = offset_machine.forward(np.column_stack([rho, a, c]), length)
    assert ok.all()
    tip_base = position + turn(rx(alpha), np.stack([0 * length, 0 * length, NOSE + length], axis=-1))
    assert np.abs(tip - on_table(tip_base, a, c, PIVOT, ROTARY_OFFSET)).max() < ROUND_TRIP_MM
    upright = np.stack([0 * alpha, -np.sin(alpha), np.cos(alpha)], axis=-1)
    assert np.abs(axis - turn(rz(-c), turn(rx(-a), upright))).max() < ROUND_TRIP_AXIS


@pytest.mark.parametrize("name", ["machine", "offset_machine"])
def test_forward_of_inverse_over_many_poses(name, request):
    machine = request.getfixturevalue(name)
    tip, axis, length = random_poses(3, 110_000)
    q, ok = machine.inverse(tip, axis, length)
    assert ok.sum() > 100_000
    back, axis_back, ok_back = machine.forward(q[ok], length[ok])
    assert ok_back.all()
    assert np.abs(back - tip[ok]).max() < ROUND_TRIP_MM
    assert np.abs(axis_back - axis[ok]).max() < ROUND_TRIP_AXIS


def test_inverse_takes_b_from_0_to_pi_and_c_above_minus_pi(offset_machine):
    tip, axis, length = random_poses(4, 20_000)
    axis[:1000, 0] = 0.0  # C exactly 0 and pi, with both signs of zero
    axis[500:1000, 0] = -0.0
    axis[:1000] /= np.linalg.norm(axis[:1000], axis=1, keepdims=True)
    q, ok = offset_machine.inverse(tip, axis, length)
    q, axis = q[ok], axis[ok]
    assert (q[:, 4] > -np.pi).all()
    assert (q[:, 4] <= np.pi).all()
    assert (np.abs(q[:1000, 4]) > 3.0).any()
    _position, alpha, _ok = offset_machine.module.forward(q[:, :3])
    nominal = q[:, 3] - alpha
    # the subtraction of alpha leaves a rounding below 0 and above pi
    assert nominal.min() > -1e-12
    assert nominal.max() < np.pi + 1e-12
    assert np.abs(axis_of(nominal, q[:, 4]) - axis).max() < ROUND_TRIP_AXIS


@pytest.mark.parametrize("zero", [0.0, -0.0])
@pytest.mark.parametrize("up", [1.0, -1.0])
def test_c_is_0_at_the_pole(machine, up, zero):
    q, ok = machine.inverse(np.array([30.0, 40.0, 50.0]), np.array([zero, zero, up]), 200.0)
    assert ok
    assert q[4] == 0.0
    back, axis, _ok = machine.forward(q, 200.0)
    assert back == pytest.approx([30.0, 40.0, 50.0], abs=ROUND_TRIP_MM)
    assert axis == pytest.approx([0.0, 0.0, up], abs=ROUND_TRIP_AXIS)


@pytest.mark.parametrize("sine", [1e-8, 1e-6, 1e-3])
def test_close_to_the_pole_the_axis_still_returns(machine, sine):
    around = np.linspace(-3.1, 3.1, 63)
    axis = axis_of(np.full(63, sine), around)
    q, ok = machine.inverse(np.array([30.0, 40.0, 50.0]), axis, 100.0)
    assert ok.all()
    assert q[:, 4] == pytest.approx(around, abs=1e-6)  # C is known to 1e-16 / sine = 1e-8 at worst
    assert np.abs(machine.forward(q, 100.0)[1] - axis).max() < ROUND_TRIP_AXIS


def test_vertical_tool_tilts_the_table_by_the_platform_tilt(machine):
    """A three-axis program is a five-axis job: the table follows the platform's tilt, A = alpha."""
    rng = np.random.default_rng(5)
    tip = rng.uniform([-200.0, -200.0, 0.0], [200.0, 200.0, 150.0], size=(1000, 3))
    q, ok = machine.inverse(tip, np.array([0.0, 0.0, 1.0]), 100.0)
    assert ok.all()
    _position, alpha, _ok = machine.module.forward(q[:, :3])
    assert q[:, 3] == pytest.approx(alpha, abs=1e-12)
    assert np.abs(alpha).max() > 0.1  # it does tilt


# --- the programmed branch ------------------------------------------------------------------------


def test_solve_follows_the_programmed_angles(offset_machine):
    """The joints are (rho, A + alpha, C), C unwrapped as programmed, negative A included."""
    rng = np.random.default_rng(6)
    n = 20_000
    tip, _axis, length = random_poses(6, n)
    angles = np.column_stack([rng.uniform(-1.6, 1.6, n), rng.uniform(-40.0, 40.0, n)])
    q, platform, ok = offset_machine.five_axis.solve(tip, angles, length)
    position, alpha = platform.position, platform.alpha
    assert ok.mean() > 0.9
    tip, angles, length, q, position, alpha = (v[ok] for v in (tip, angles, length, q, position, alpha))
    np.testing.assert_array_equal(q[:, 4], angles[:, 1])
    assert q[:, 3] - alpha == pytest.approx(angles[:, 0], abs=1e-12)
    assert np.abs(rods(position, alpha, q[:, :3])).max() < 1e-8  # mm2; 1e-11 mm on a rod
    tip_base = position + turn(rx(alpha), np.stack([0 * length, 0 * length, NOSE + length], axis=-1))
    assert np.abs(on_table(tip_base, q[:, 3], q[:, 4], PIVOT, ROTARY_OFFSET) - tip).max() < ROUND_TRIP_MM
    back, angles_back, ok_back = offset_machine.five_axis.find_nominal_pose(q, length)
    assert ok_back.all()
    assert np.abs(back - tip).max() < ROUND_TRIP_MM
    assert np.abs(angles_back - angles).max() < 1e-12


def test_solve_and_inverse_agree_up_to_whole_turns_and_the_second_table_solution(machine):
    """(A, C), (A, C + 2 pi) and (-A, C + pi) name one tool axis and close with the same sliders."""
    tip = np.array([60.0, -30.0, 40.0])
    for a, c in itertools.product([0.3, 1.2], [-2.0, 0.1, 3.0]):
        poses = np.array([[a, c], [a, c + 2 * np.pi], [-a, c + np.pi]])
        q, platform, ok = machine.five_axis.solve(np.tile(tip, (3, 1)), poses, 80.0)
        alpha = platform.alpha
        from_axis, ok_axis = machine.inverse(tip, axis_of(a, c), 80.0)
        assert ok.all()
        assert ok_axis
        assert q[1, :3] == pytest.approx(q[0, :3], abs=ROUND_TRIP_MM)
        assert from_axis == pytest.approx(q[0], abs=ROUND_TRIP_MM)
        # the second solution stands elsewhere in the base frame, but holds the same pose in the part
        back, axis, _ok = machine.forward(q, 80.0)
        assert np.abs(back - tip).max() < ROUND_TRIP_MM
        assert np.abs(axis - axis_of(a, c)).max() < ROUND_TRIP_AXIS
        assert q[2, 3] - alpha[2] == pytest.approx(-a, abs=1e-12)


# --- where the platform does not tilt: textbook trunnion ------------------------------------------


def test_without_platform_tilt_it_is_the_textbook_trunnion(offset_machine):
    """Tips in the plane y_P = 0: alpha = 0, and joints follow a tilting-rotary-table machine's formulas.

    For a table (x about A, z about C) with the rotary centre at (dx, dy, dz) from the tilt axis:
    X = dx + x cos C - y sin C, Y = cos A (dy + x sin C + y cos C) - sin A (dz + z),
    Z = sin A (dy + x sin C + y cos C) + cos A (dz + z); the sliders then from (11)-(13) with alpha = 0.
    """
    rng = np.random.default_rng(7)
    n = 5000
    a, c = rng.uniform(-1.5, 1.5, n), rng.uniform(-7.0, 7.0, n)
    length = rng.uniform(0.0, 250.0, n)
    # P in the plane y = 0, from there to the tip that the table then carries
    position = np.column_stack([rng.uniform(-300, 400, n), np.zeros(n), rng.uniform(700, 1300, n)])
    tip = on_table(position + np.column_stack([0 * a, 0 * a, NOSE + length]), a, c, PIVOT, ROTARY_OFFSET)

    dx, dy, dz = ROTARY_OFFSET
    x, y, z = tip.T
    along = dy + x * np.sin(c) + y * np.cos(c)
    carriage_x = dx + x * np.cos(c) - y * np.sin(c)
    carriage_y = np.cos(a) * along - np.sin(a) * (dz + z)
    carriage_z = np.sin(a) * along + np.cos(a) * (dz + z) + length + NOSE
    x_p, y_p, z_p = PIVOT[0] + carriage_x, PIVOT[1] - carriage_y, PIVOT[2] - carriage_z
    assert np.abs(y_p).max() < ROUND_TRIP_MM
    rho1 = z_p - np.sqrt(850**2 - (130 - 80) ** 2 - (x_p - 320) ** 2)
    rho23 = z_p - np.sqrt(950**2 - (x_p + 240) ** 2 - (565 - 190) ** 2)

    q, platform, ok = offset_machine.five_axis.solve(tip, np.column_stack([a, c]), length)
    alpha = platform.alpha
    assert ok.all()
    assert np.abs(alpha).max() < 1e-12  # y_P is 0 only to rounding
    assert np.abs(q - np.column_stack([rho1, rho23, rho23, a, c])).max() < ROUND_TRIP_MM


# --- reach ----------------------------------------------------------------------------------------


def scan(gauge, pivot, n=2001):
    """As in test_verne_module, for P = pivot + F Rx(alpha) gauge: True where a working solution is certain."""
    alpha = np.linspace(-1, 1, n) * np.arccos(80 / 130)
    ca, sa = np.cos(alpha), np.sin(alpha)
    x = pivot[0] + gauge[:, :1]
    y = pivot[1] - (ca * gauge[:, 1:2] - sa * gauge[:, 2:])
    leg1 = 850**2 - (130**2 + 80**2 - 2 * 130 * 80 * ca) - (x - 320) ** 2 - y**2
    leg2 = 950**2 - (x + 240) ** 2 - (y - 190 * ca + 565) ** 2
    leg3 = 950**2 - (x + 240) ** 2 - (y + 190 * ca - 565) ** 2
    loop = y * (130 * ca - 80) + 130 * sa * np.sqrt(np.maximum(leg1, 0.0))
    real = (leg1 > 0) & (leg2 > 0) & (leg3 > 0)
    return ((loop[:, 1:] * loop[:, :-1] < 0) & real[:, 1:] & real[:, :-1]).any(axis=1)


def test_unreachable_only_where_a_dense_scan_finds_no_solution(offset_machine):
    rng = np.random.default_rng(8)
    n = 12_000
    tip = rng.uniform(-900.0, 900.0, size=(n, 3))
    angles = np.column_stack([rng.uniform(-3.1, 3.1, n), rng.uniform(-3.1, 3.1, n)])
    length = rng.uniform(0.0, 300.0, n)
    q, platform, ok = offset_machine.five_axis.solve(tip, angles, length)
    position, alpha = platform.position, platform.alpha
    assert 0.2 < ok.mean() < 0.8
    carried = turn(rx(angles[:, 0]), np.asarray(ROTARY_OFFSET) + turn(rz(angles[:, 1]), tip))
    gauge = carried + np.column_stack([0 * length, 0 * length, NOSE + length])
    certain = np.concatenate([scan(part, PIVOT) for part in np.array_split(gauge, 12)])
    assert not (certain & ~ok).any()
    # mm2; at the rim a root is double and known to half the digits only: 1e-9 mm of rod
    assert np.abs(rods(position[ok], alpha[ok], q[ok, :3])).max() < 2e-6
    assert (np.abs(alpha[ok]) < np.arccos(80 / 130)).all()
    assert np.isnan(q[~ok]).all()


def test_why_not_names_poses_out_of_reach(machine):
    tip, angles = np.array([[900.0, 0.0, 0.0], [0.0, 900.0, 0.0]]), np.zeros((2, 2))
    assert not machine.five_axis.solve(tip, angles, 50.0)[2].any()
    assert machine.five_axis.explain_unreachable(tip, angles, np.array([50.0, 50.0])) == ["VP110", "VP110"]


# --- shapes and odd input -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tip", "axis", "length", "result"),
    [
        ((3,), (3,), (), ()),
        ((4, 3), (3,), (), (4,)),
        ((3,), (4, 3), (), (4,)),
        ((3,), (3,), (4,), (4,)),
        ((2, 1, 3), (4, 3), (2, 4), (2, 4)),
        ((0, 3), (0, 3), (), (0,)),
    ],
)
def test_inverse_broadcasts(machine, tip, axis, length, result):
    q, ok = machine.inverse(
        np.broadcast_to([10.0, 20.0, 30.0], tip), np.broadcast_to([0.0, 0.6, 0.8], axis), np.full(length, 75.0)
    )
    assert q.shape == (*result, 5)
    assert ok.shape == result
    one, _ok = machine.inverse(np.array([10.0, 20.0, 30.0]), np.array([0.0, 0.6, 0.8]), 75.0)
    assert np.abs(q - one).max(initial=0.0) < ROUND_TRIP_MM
    tip_back, axis_back, ok_back = machine.forward(q, np.full(result, 75.0))
    assert tip_back.shape == axis_back.shape == (*result, 3)
    assert ok_back.shape == result


def test_nan_rows_are_nan_and_not_ok(machine):
    tip, axis, length = random_poses(10, 9)
    tip, axis, length = tip * 0.5, np.tile([0.0, 0.6, 0.8], (9, 1)), length.copy()
    for row in range(3):
        tip[row, row] = np.nan
        axis[3 + row, row] = np.nan
    length[6] = np.nan
    before = tip.copy(), axis.copy(), length.copy()
    q, ok = machine.inverse(tip, axis, length)
    assert ok.tolist() == [False] * 7 + [True] * 2
    assert np.isnan(q[:7]).all()
    assert np.isfinite(q[7:]).all()
    q[7, 0] = np.nan
    q_before = q.copy()
    tip_back, axis_back, ok_back = machine.forward(q, 50.0)
    assert ok_back.tolist() == [False] * 8 + [True]
    assert np.isnan(tip_back[:8]).all()
    assert np.isnan(axis_back[:8]).all()
    for array, kept in zip((tip, axis, length, q), (*before, q_before), strict=True):
        np.testing.assert_array_equal(array, kept)


def test_forward_of_sliders_that_close_nothing(machine):
    tip, axis, ok = machine.forward(np.array([0.0, 5000.0, 0.0, 0.1, 0.2]), 50.0)
    assert not ok
    assert np.isnan(tip).all()
    assert np.isnan(axis).all()


@pytest.mark.parametrize("shape", [(), (2,), (4,), (6,), (3, 4), (1, 2)])
def test_inverse_refuses_wrong_shapes(machine, shape):
    with pytest.raises(ValueError, match="tip"):
        machine.inverse(np.zeros(shape), np.array([0.0, 0.0, 1.0]), 50.0)
    with pytest.raises(ValueError, match="axis"):
        machine.inverse(np.zeros(3), np.zeros(shape), 50.0)


@pytest.mark.parametrize("shape", [(), (3,), (4,), (6,), (10,), (5, 3)])
def test_forward_refuses_wrong_shapes(machine, shape):
    with pytest.raises(ValueError, match="q must have shape"):
        machine.forward(np.zeros(shape), 50.0)


def test_shapes_that_do_not_fit_each_other_raise(machine):
    up = np.array([0.0, 0.0, 1.0])
    with pytest.raises(ValueError, match=r"broadcast|shape"):
        machine.inverse(np.zeros((4, 3)), np.tile(up, (3, 1)), 50.0)
    with pytest.raises(ValueError, match=r"broadcast|shape"):
        machine.inverse(np.zeros((4, 3)), up, np.zeros(3))
    with pytest.raises(ValueError, match=r"broadcast|shape"):
        machine.forward(np.zeros((4, 5)), np.zeros(3))


@pytest.mark.parametrize("wrong", ["here", [[1.0, 2.0], [3.0]], [1.0, 2.0, "z"]])
def test_what_is_not_numbers_raises(machine, wrong):
    with pytest.raises(UsageError, match="tip: expected places in mm"):
        machine.inverse(wrong, np.array([0.0, 0.0, 1.0]), 50.0)
    with pytest.raises(UsageError, match="q: expected joints in mm and rad"):
        machine.forward(wrong, 50.0)


# --- program, table and machine coordinates -------------------------------------------------------

FRAMES = {
    "plain": Frame(),
    "work offset": Frame(system=2, origin=(30.0, -40.0, -500.0, 5.0, 0.0, -20.0, 0.0, 0.0, 0.0)),
    "turned": Frame(origin=(1.0, 2.0, -480.0, *(0.0,) * 6), turn=25.0, part_turn=-70.0),
    "everything": Frame(
        system=3,
        origin=(30.0, -40.0, -500.0, 5.0, 0.0, -20.0, 0.0, 0.0, 0.0),
        turn=-15.0,
        part_turn=40.0,
        g92=(7.0, 8.0, 9.0, 3.0, 0.0, 4.0, 0.0, 0.0, 0.0),
        tool=(0.0, 0.0, 120.0, *(0.0,) * 6),
    ),
}
SENSES = list(itertools.product(["workpiece", "tool"], repeat=2))


@pytest.fixture(scope="module", params=SENSES, ids=["-".join(senses) for senses in SENSES])
def sensed(request, machine_with):
    """A machine for each sense of A and C, and the two signs."""
    a, c = request.param
    machine = machine_with(
        {
            "table.pivot": PIVOT,
            "table.rotary_offset": ROTARY_OFFSET,
            "table.machine_zero": MACHINE_ZERO,
            "table.a_positive": a,
            "table.c_positive": c,
        }
    )
    return machine, 1.0 if a == "workpiece" else -1.0, 1.0 if c == "workpiece" else -1.0


def random_program(n=500):
    """Program coordinates X Y Z A . C . . ., mm and degrees."""
    program = np.random.default_rng(11).uniform(-200.0, 200.0, size=(n, 9))
    program[:, [4, 6, 7, 8]] = 0.0
    return program


def table_of(program, frame, a_sign, c_sign):
    """Written out from the frames page and "What a programmed word means" of the kinematics page."""
    shifted = program + np.asarray(frame.g92)
    o = np.asarray(MACHINE_ZERO) + np.asarray(frame.origin[:3])
    tip = o + turn(rz(np.radians(frame.part_turn + frame.turn)), shifted[:, :3])
    a = np.radians(a_sign * (shifted[:, 3] + frame.origin[3]))
    c = np.radians(c_sign * (shifted[:, 5] + frame.origin[5]) - frame.part_turn)
    return tip, np.column_stack([a, c])


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
def test_to_table_is_the_written_formula(sensed, frame):
    machine, a_sign, c_sign = sensed
    program = random_program()
    tip, angles = machine.coordinates.map_to_table(program, frame)
    tip_expected, angles_expected = table_of(program, frame, a_sign, c_sign)
    assert np.abs(tip - tip_expected).max() < ROUND_TRIP_MM
    assert np.abs(angles - angles_expected).max() < 1e-12


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
def test_to_machine_is_the_written_formula(sensed, frame):
    """Rx(A) (rotary_offset + Rz(C) p_table) - rotary_offset - machine_zero, p_table on the gauge line."""
    machine, a_sign, c_sign = sensed
    program = random_program()
    tip, angles = table_of(program, frame, a_sign, c_sign)
    a, c = angles.T
    gauge_line = tip + frame.tool[2] * axis_of(a, c)
    offset = np.asarray(ROTARY_OFFSET)
    m = turn(rx(a), offset + turn(rz(c), gauge_line)) - offset - np.asarray(MACHINE_ZERO)
    found = machine.coordinates.map_to_machine(program, frame)
    assert np.abs(found[:, :3] - m).max() < ROUND_TRIP_MM
    assert np.abs(found[:, 3] - np.degrees(a_sign * a)).max() < ROUND_TRIP_MM
    assert np.abs(found[:, 5] - np.degrees(c_sign * c)).max() < ROUND_TRIP_MM
    assert (found[:, [4, 6, 7, 8]] == 0.0).all()


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
def test_table_and_machine_coordinates_can_be_undone(sensed, frame):
    machine, _a_sign, _c_sign = sensed
    coordinates = machine.coordinates
    program = random_program()
    # axes that the table lacks are 0 in the inverse of map_to_table, before G92 is taken out; the frames here have none
    # there
    by_table = coordinates.map_from_table(*coordinates.map_to_table(program, frame), frame)
    np.testing.assert_allclose(by_table, program, rtol=0, atol=ROUND_TRIP_MM)
    by_machine = coordinates.map_to_program(coordinates.map_to_machine(program, frame), frame)
    np.testing.assert_allclose(by_machine, program, rtol=0, atol=ROUND_TRIP_MM)
    # and the other way round, from positions of the machine
    position = random_program(300)[::-1]
    np.testing.assert_allclose(
        coordinates.map_to_machine(coordinates.map_to_program(position, frame), frame),
        position,
        rtol=0,
        atol=ROUND_TRIP_MM,
    )


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
def test_single_points_are_as_good_as_batches(sensed, frame):
    machine, _a_sign, _c_sign = sensed
    coordinates = machine.coordinates
    program = random_program(5)
    tip, angles = coordinates.map_to_table(program, frame)
    for row in range(5):
        tip_row, angles_row = coordinates.map_to_table(program[row], frame)
        np.testing.assert_allclose(tip_row, tip[row], rtol=0, atol=ROUND_TRIP_MM)
        np.testing.assert_allclose(angles_row, angles[row], rtol=0, atol=1e-12)


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
def test_a_machine_move_in_z_runs_along_the_tool_axis(sensed, frame):
    """In the part, also while the platform tilts: the tool is not dragged sideways."""
    machine, _a_sign, _c_sign = sensed
    low = np.array([20.0, -30.0, -300.0, 35.0, 0.0, 50.0, 0.0, 0.0, 0.0])
    high = low.copy()
    high[2] += 80.0
    program = machine.coordinates.map_to_program(np.stack([low, high]), frame)
    tip, angles = machine.coordinates.map_to_table(program, frame)
    q, platform, ok = machine.five_axis.solve(tip, angles, frame.tool_length)
    alpha = platform.alpha
    assert ok.all()
    assert np.abs(alpha).min() > 1e-3  # it does tilt
    tip, axis, _ok = machine.forward(q, frame.tool_length)
    assert axis[1] == pytest.approx(axis[0], abs=ROUND_TRIP_AXIS)
    assert tip[1] - tip[0] == pytest.approx(80.0 * axis[0], abs=ROUND_TRIP_MM)


def test_machine_zero_is_over_the_rotary_centre(sensed):
    """Machine position 0 with A = C = 0: the gauge line at machine_zero over the rotary centre."""
    machine, _a_sign, _c_sign = sensed
    for tool in (0.0, 75.0):
        frame = Frame(tool=(0.0, 0.0, tool, *(0.0,) * 6))
        tip, angles = machine.coordinates.map_to_table(machine.coordinates.map_to_program(np.zeros(9), frame), frame)
        assert tip == pytest.approx(np.asarray(MACHINE_ZERO) - [0.0, 0.0, tool], abs=ROUND_TRIP_MM)
        assert angles == pytest.approx([0.0, 0.0], abs=1e-15)


def test_work_origin_of_a_work_offset(sensed):
    """The origin o is machine_zero + the value of G10 L2."""
    machine, _a_sign, _c_sign = sensed
    origin = machine.coordinates.work_origin((10.0, 20.0, 30.0))
    assert origin == pytest.approx((7.0, 22.0, -510.0), abs=1e-12)
    frame = Frame(origin=(*origin, *(0.0,) * 6))
    tip, _angles = machine.coordinates.map_to_table(np.zeros(9), frame)
    assert tip == pytest.approx([10.0, 20.0, 30.0], abs=1e-12)


@pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES)
def test_displacements_and_work_frame(sensed, frame):
    machine, _a_sign, _c_sign = sensed
    coordinates = machine.coordinates
    program = random_program(50)
    step = np.random.default_rng(12).normal(size=(50, 3))
    moved = program.copy()
    moved[:, :3] += step
    tip = coordinates.map_to_table(program, frame)[0]
    assert coordinates.map_to_table(moved, frame)[0] - tip == pytest.approx(
        coordinates.turn_displacement(step, frame), abs=ROUND_TRIP_MM
    )
    point, direction = coordinates.map_to_work(tip, coordinates.turn_displacement(step, frame), frame)
    assert point == pytest.approx(program[:, :3] + frame.g92[:3], abs=ROUND_TRIP_MM)
    assert direction == pytest.approx(step, abs=1e-12)


def test_a_part_turned_on_the_table_sees_the_programmed_tool_axis(sensed):
    """The table stands at C_programmed - c, so that the axis in the part is that of the programmed pair."""
    machine, a_sign, c_sign = sensed
    frame = Frame(part_turn=40.0)
    program = np.zeros(9)
    program[[3, 5]] = 35.0, 70.0
    _tip, angles = machine.coordinates.map_to_table(program, frame)
    in_part = turn(rz(np.radians(-40.0)), axis_of(angles[0], angles[1]))
    assert in_part == pytest.approx(axis_of(np.radians(a_sign * 35.0), np.radians(c_sign * 70.0)), abs=1e-12)


def test_axes_of_the_table(machine):
    assert machine.coordinates.axes == "XYZAC"
