"""What must hold for any lengths: symmetries, units, batches, and one solution found again among all of the other
direction.
"""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import asdict, replace

from verne_post.base.rotations import find_axis_of_angles
from verne_post.kinematics.five_axis import HybridMachine
from verne_post.kinematics.modules.verne.module import VerneModule
from verne_post.kinematics.tables.tilting import TiltingTable

VERNE = VerneModule(
    leg1_x_offset=-320.0, R1=130.0, r1=80.0, L1=850.0, leg23_x_offset=240.0, R2=190.0, r4=565.0, L2=950.0, L3=950.0
)
#: Agreement of two ways to one number of some 1000 mm, and of angles. Measured 4e-12 and 2e-14 where the rods drop by
#: 100 mm.
SAME_MM = 1e-9
SAME_ANGLE = 1e-12
#: Smallest drop at which numbers are compared, as share of L1: digits are lost towards the serial singularity. The
#: machine file allows 100 mm, 0.118 L1.
SMALLEST_DROP = 0.118

#: A plane that reaches over the rim on all sides.
x_of_p = st.floats(-560.0, 680.0)
y_of_p = st.one_of(st.floats(-600.0, 600.0), st.sampled_from([0.0, -0.0, 1e-12, 1e-9, -1e-6, 1e-3, 0.1, -1.0]))
z_of_p = st.floats(500.0, 1400.0)
positions = st.tuples(x_of_p, y_of_p, z_of_p).map(np.array)
#: The VERNE itself, and lengths within 5 % of it, L2 and L3 each on its own.
factors = st.lists(st.floats(0.95, 1.05), min_size=9, max_size=9)
modules = st.one_of(
    st.just(VERNE),
    factors.map(lambda f: VerneModule(*(v * k for v, k in zip(asdict(VERNE).values(), f, strict=True)))),
)


def mirrored(module):
    """The module behind a mirror in y: legs II and III change places."""
    return replace(module, L2=module.L3, L3=module.L2)


def scaled(module, k):
    return VerneModule(**{name: k * value for name, value in asdict(module).items()})


def solvable(module, position):
    """Rho and alpha of a position that is in reach and no close call."""
    rho, alpha, ok = module.inverse(position)
    assume(ok)
    assume(module.find_geometry_margins(position, alpha)[:3].min() > SMALLEST_DROP * module.L1)
    return rho, alpha


def turn_between(one, other):
    return np.abs((np.asarray(one) - other + np.pi) % (2 * np.pi) - np.pi)


# --- symmetry ------------------------------------------------------------------------------------------------------


@settings(deadline=None, max_examples=200)
@given(modules, positions)
def test_a_mirror_in_y_exchanges_sliders_2_and_3_and_turns_the_tilt(module, position):
    rho, alpha = solvable(module, position)
    image = mirrored(module)
    rho_image, alpha_image, ok = image.inverse(position * [1, -1, 1])
    assert ok
    assert rho_image == pytest.approx(rho[[0, 2, 1]], abs=SAME_MM)
    assert alpha_image == pytest.approx(-alpha, abs=SAME_ANGLE)
    back, tilt, ok = module.forward(rho)
    back_image, tilt_image, ok_image = image.forward(rho[[0, 2, 1]])
    assert ok == ok_image
    if ok:
        assert back_image == pytest.approx(back * [1, -1, 1], abs=SAME_MM)
        assert tilt_image == pytest.approx(-tilt, abs=SAME_ANGLE)


@settings(deadline=None, max_examples=40)
@given(modules, positions)
def test_every_solution_has_its_mirror_image(module, position):
    rho, _alpha = solvable(module, position)
    image = mirrored(module)
    here, there = module.inverse_all(position), image.inverse_all(position * [1, -1, 1])
    assert len(here) == len(there)
    for one in here:
        wanted = np.array(one.rho)[[0, 2, 1]]
        apart = [
            max(np.abs(np.array(other.rho) - wanted).max(), turn_between(other.alpha, -one.alpha)) for other in there
        ]
        other = there[int(np.argmin(apart))]
        # solutions that the machine does not use may stand near a serial singularity, where half the digits are lost
        assert min(apart) < 1e-5
        assert (other.refused is None) == (one.refused is None)
    here, there = module.forward_all(rho), image.forward_all(rho[[0, 2, 1]])
    assert len(here) == len(there)
    for one in here:
        wanted = np.array(one.position) * [1, -1, 1]
        assert min(np.abs(np.array(other.position) - wanted).max() for other in there) < 1e-5


# --- units -----------------------------------------------------------------------------------------------------------


@settings(deadline=None, max_examples=200)
@given(modules, positions, st.floats(-3.0, 3.0).map(lambda e: 10.0**e))
def test_a_module_k_times_as_large_has_k_times_the_sliders(module, position, k):
    rho, alpha = solvable(module, position)
    rho_k, alpha_k, ok = scaled(module, k).inverse(k * position)
    assert ok
    assert rho_k / k == pytest.approx(rho, abs=SAME_MM)
    assert alpha_k == pytest.approx(alpha, abs=SAME_ANGLE)
    back, tilt, ok = module.forward(rho)
    back_k, tilt_k, ok_k = scaled(module, k).forward(k * rho)
    assert ok == ok_k
    if ok:
        assert back_k / k == pytest.approx(back, abs=SAME_MM)
        assert tilt_k == pytest.approx(tilt, abs=SAME_ANGLE)


@settings(deadline=None, max_examples=40)
@given(modules, positions, st.floats(-3.0, 3.0).map(lambda e: 10.0**e))
def test_the_number_of_solutions_has_no_unit(module, position, k):
    rho, _alpha = solvable(module, position)
    large = scaled(module, k)
    assert len(large.inverse_all(k * position)) == len(module.inverse_all(position))
    here, there = module.forward_all(rho), large.forward_all(k * rho)
    assert len(here) == len(there)
    for one in here:  # matched by pose: alpha = pi and -pi are one, and sort at either end
        apart = [np.abs(np.array(other.position) / k - one.position).max() for other in there]
        assert min(apart) < 1e-5
        assert (there[int(np.argmin(apart))].refused is None) == (one.refused is None)


# --- batches
# -------------------------------------------------------------------------------------------------------------


@settings(deadline=None, max_examples=20)
@given(modules, st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_a_batch_is_its_rows(module, seed, n):
    """Not bit by bit: rows iterate until the last of them rests, and one more Newton step moves the others by rounding.

    1e-11 mm is 100 spacings of doubles at 1000 mm.
    """
    rng = np.random.default_rng(seed)
    machine = HybridMachine(
        module, TiltingTable(np.array([6.0, -9.0, 1580.0]), np.array([12.0, -8.0, 35.0]), np.zeros(3), 1.0, 1.0), 42.0
    )
    tip = rng.uniform([-400.0, -400.0, 0.0], [400.0, 400.0, 150.0], (n, 3))
    axis = find_axis_of_angles(rng.uniform(0, np.pi / 2, n), rng.uniform(-np.pi, np.pi, n))
    tool = rng.uniform(0.0, 250.0, n)
    q, ok = machine.inverse(tip, axis, tool)
    for row in range(n):
        q_row, ok_row = machine.inverse(tip[row], axis[row], float(tool[row]))
        assert ok_row == ok[row]
        if not ok_row:
            assert np.isnan(q_row).all()
            assert np.isnan(q[row]).all()
            continue
        # towards the serial singularity a rounding of the tilt moves the slider by more
        position, tilt, _ok = module.forward(q_row[:3])
        if not module.find_geometry_margins(position, tilt)[:3].min() > SMALLEST_DROP * module.L1:
            continue
        assert np.abs(q_row - q[row]).max() < 1e-11
        together = [v[row] for v in machine.forward(q, tool)[:2]]
        alone = machine.forward(q_row, float(tool[row]))[:2]
        assert np.abs(together[0] - alone[0]).max() < 1e-11
        assert np.abs(together[1] - alone[1]).max() < 1e-13


# --- there and back
# -----------------------------------------------------------------------------------------------------


@settings(deadline=None, max_examples=25)
@given(modules, positions)
def test_all_forward_solutions_of_every_inverse_solution_contain_the_pose(module, position):
    solutions = module.inverse_all(position)
    for solution in solutions:
        modes = module.forward_all(np.array(solution.rho))
        apart = [
            max(np.abs(np.array(mode.position) - position).max(), 1000 * turn_between(mode.alpha, solution.alpha))
            for mode in modes
        ]
        assert min(apart) < 1e-4  # modes are told apart at 1e-4 mm; a mode that is double is known to half its digits
        mode = modes[int(np.argmin(apart))]
        assert (mode.refused is None) == (solution.refused is None)
        assert len([mode for mode in modes if mode.refused is None]) >= (solution.refused is None)
