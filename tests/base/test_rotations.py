"""Rotations about single axes, and the meaning of a programmed pair (A, C) as a tool axis."""

import math

import numpy as np
import pytest

from verne_post.base.rotations import find_axis_of_angles, rotate_x, rotate_z, solve_angles_of_axis

#: Unit vectors and angles: a few roundings of 1e-16.
EXACT = 1e-14
QUARTER = math.pi / 2


@pytest.mark.parametrize(
    ("rotate", "vector", "turned"),
    [
        (rotate_x, [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]),
        (rotate_x, [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]),
        (rotate_x, [5.0, 0.0, 0.0], [5.0, 0.0, 0.0]),
        (rotate_z, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        (rotate_z, [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]),
        (rotate_z, [0.0, 0.0, 5.0], [0.0, 0.0, 5.0]),
    ],
)
def test_a_quarter_turn_by_the_right_hand_rule(rotate, vector, turned):
    assert rotate(np.array(vector), QUARTER) == pytest.approx(turned, abs=EXACT)


@pytest.mark.parametrize("rotate", [rotate_x, rotate_z])
def test_rotations_add_up_and_can_be_undone(rotate):
    rng = np.random.default_rng(1)
    vector, first, second = rng.normal(size=(200, 3)), rng.uniform(-9, 9, 200), rng.uniform(-9, 9, 200)
    assert rotate(rotate(vector, first), second) == pytest.approx(rotate(vector, first + second), abs=EXACT * 10)
    assert rotate(rotate(vector, first), -first) == pytest.approx(vector, abs=EXACT * 10)
    assert np.linalg.norm(rotate(vector, first), axis=1) == pytest.approx(np.linalg.norm(vector, axis=1), rel=EXACT)


@pytest.mark.parametrize("rotate", [rotate_x, rotate_z])
def test_rotations_broadcast(rotate):
    vector = np.array([1.0, 2.0, 3.0])
    angles = np.linspace(-3, 3, 12).reshape(3, 4)
    turned = rotate(vector, angles)
    assert turned.shape == (3, 4, 3)
    assert turned[2, 1] == pytest.approx(rotate(vector, angles[2, 1]), abs=EXACT)
    assert rotate(np.ones((3, 4, 3)), 0.5).shape == (3, 4, 3)
    assert rotate(np.empty((0, 3)), np.empty(0)).shape == (0, 3)
    np.testing.assert_array_equal(vector, [1.0, 2.0, 3.0])


def test_a_programmed_pair_is_what_the_trunnion_machine_holds():
    """The spindle stands along +z; the table turned by Rx(A) Rz(C) sees it along k with Rx(A) Rz(C) k = z."""
    rng = np.random.default_rng(2)
    a, c = rng.uniform(-4, 4, 500), rng.uniform(-40, 40, 500)
    k = find_axis_of_angles(a, c)
    upright = rotate_x(rotate_z(k, c), a)
    assert np.abs(upright - [0.0, 0.0, 1.0]).max() < 10 * EXACT  # C up to 40 rad costs a digit
    expected = np.stack([np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)], axis=-1)
    np.testing.assert_allclose(k, expected, rtol=0, atol=EXACT)


@pytest.mark.parametrize(
    ("a_deg", "c_deg", "axis"),
    [
        (0, 77, [0, 0, 1]),
        (90, 0, [0, 1, 0]),
        (90, 90, [1, 0, 0]),
        (-90, 0, [0, -1, 0]),
        (180, 0, [0, 0, -1]),
        (90, 180, [0, -1, 0]),
    ],
)
def test_axes_by_hand(a_deg, c_deg, axis):
    assert find_axis_of_angles(math.radians(a_deg), math.radians(c_deg)) == pytest.approx(axis, abs=EXACT)


def test_angles_of_axis_undo_axis_of_angles():
    rng = np.random.default_rng(3)
    b, c = rng.uniform(1e-3, math.pi - 1e-3, 2000), rng.uniform(-math.pi + 1e-9, math.pi, 2000)
    b_back, c_back = solve_angles_of_axis(find_axis_of_angles(b, c))
    assert b_back == pytest.approx(b, abs=EXACT)
    # C is known to the rounding of the axis over sin b >= 1e-3
    assert c_back == pytest.approx(c, abs=1e-12)


def test_angles_stay_in_their_ranges_whatever_the_axis():
    rng = np.random.default_rng(4)
    axis = rng.normal(size=(5000, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    b, c = solve_angles_of_axis(axis)
    assert ((b >= 0) & (b <= math.pi)).all()
    assert ((c > -math.pi) & (c <= math.pi)).all()
    assert np.abs(find_axis_of_angles(b, c) - axis).max() < EXACT


@pytest.mark.parametrize("zero", [0.0, -0.0])
def test_c_is_pi_and_never_minus_pi(zero):
    b, c = solve_angles_of_axis(np.array([zero, -1.0, 0.0]))
    assert (b, c) == (pytest.approx(QUARTER, abs=EXACT), math.pi)
    assert solve_angles_of_axis(np.array([-1e-20, -1.0, 0.0]))[1] == math.pi  # rounds to -pi in atan2


@pytest.mark.parametrize("zero", [0.0, -0.0, 1e-10, -1e-10])
@pytest.mark.parametrize("up", [1.0, -1.0])
def test_at_the_pole_c_is_0(zero, up):
    b, c = solve_angles_of_axis(np.array([zero, zero, up]))
    assert c == 0.0
    assert b == pytest.approx(0.0 if up > 0 else math.pi, abs=2e-10)


def test_nan_stays_nan():
    for entry in range(3):
        axis = np.array([0.0, 0.6, 0.8])
        axis[entry] = np.nan
        b, _c = solve_angles_of_axis(axis)
        assert np.isnan(b)


def test_shapes():
    b, c = solve_angles_of_axis(np.broadcast_to([0.0, 0.6, 0.8], (2, 0, 3)))
    assert b.shape == c.shape == (2, 0)
    assert find_axis_of_angles(np.zeros((4, 1)), np.zeros(3)).shape == (4, 3, 3)
