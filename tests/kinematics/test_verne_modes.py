"""Every working mode and every assembly mode: the paper's figures and tables, and identities between both."""

import numpy as np
import pytest

from verne_post.kinematics.modules.verne import working_modes
from verne_post.kinematics.modules.verne.inverse import place_coupled_point
from verne_post.kinematics.modules.verne.module import VerneModule

from ..builders import LENGTHS, rods

MODULE = VerneModule(**LENGTHS)


def test_fig_6_has_sixteen_solutions_and_one_in_use():
    found = MODULE.inverse_all(np.array([-240.0, -86.0, 1000.0]))
    assert len(found) == 16
    assert len({solution.rho for solution in found}) == 16
    assert sorted({round(solution.alpha, 4) for solution in found}) == [-2.9112, -0.0522, 0.0522, 2.9112]
    (used,) = [solution for solution in found if solution.refused is None]
    assert used.signs == (-1, -1, -1)
    assert used.rho == pytest.approx((368.3548, 85.1938, 179.4083), abs=5e-5)  # the digits of kinematics.md
    for solution in found:  # 1e-9 mm on a rod of 950
        assert np.abs(rods((-240.0, -86.0, 1000.0), solution.alpha, solution.rho)).max() < 2e-6


def test_table_iii():
    """All twelve coordinates within 0.009 mm, the print precision of the table, and its angles cut to two decimals."""
    found = {round(one.alpha, 1): one for one in MODULE.forward_all(np.array([674.0137, 685.1566, 250.41]))}
    table = {
        -0.2: (-0.22, -199.80, 355.92, 1242.0),
        -0.1: (-0.14, 298.35, -297.53, -120.22),
        1.8: (1.81, -393.6, 322.82, 958.21),
        2.7: (2.69, -115.62, -189.68, -0.26),
    }
    assert sorted(found) == sorted(table)
    for key, (angle, *position) in table.items():
        assert found[key].position == pytest.approx(position, abs=0.009)
        assert np.trunc(100 * found[key].alpha) / 100 == pytest.approx(angle, abs=1e-9)
    assert [key for key, one in found.items() if one.refused is None] == [-0.2]  # case (a)


def test_six_assembly_modes_where_fig_7_reports_four():
    found = MODULE.forward_all(np.array([250.0, 1000.0, 750.0]))
    angles = sorted(round(one.alpha, 4) for one in found)
    assert angles == [-2.6445, -1.7409, -0.2826, -0.0265, 0.9692, 3.0706]
    for one in found:
        assert np.abs(rods(one.position, one.alpha, (250.0, 1000.0, 750.0))).max() < 2e-6
    assert [round(one.alpha, 4) for one in found if one.refused is None] == [-0.0265]


def test_the_six_modes_are_no_accident_of_the_lengths():
    rng = np.random.default_rng(3)
    for _ in range(40):
        g = {name: value + rng.uniform(-0.5, 0.5) for name, value in LENGTHS.items()}
        assert len(VerneModule(**g).forward_all(np.array([250.0, 1000.0, 750.0]))) == 6


def test_table_i_level_positions():
    for y, expected in ((0.0, 2), (1e-7, 4), (-86.0, 4)):  # y = 0: 0 and pi, each with leg I on both sides
        assert len({one.alpha for one in MODULE.inverse_all(np.array([100.0, y, 1000.0]))}) == expected
    level = MODULE.inverse_all(np.array([100.0, 0.0, 1000.0]))
    assert sorted({one.alpha for one in level}) == pytest.approx([0.0, np.pi])
    assert len(level) == 16


@pytest.mark.parametrize("l3", [950.0, 900.0])
def test_forward_of_every_inverse_contains_the_position(l3):
    """Also close to y = 0, where the elimination of (21) fails, and for unequal legs."""
    g = {**LENGTHS, "L3": l3}
    module = VerneModule(**g)
    rng = np.random.default_rng(5)
    count = 0
    for k in range(40):
        y = rng.uniform(-450, 450) if k % 2 else rng.choice([0.0, 1e-9, 1e-6, 1e-3, 0.1, 1.0]) * rng.choice([-1, 1])
        position = np.array([rng.uniform(-450, 550), y, 1000.0])
        for solution in module.inverse_all(position):
            count += 1
            apart = [
                np.abs(np.array(one.position) - position).max() for one in module.forward_all(np.array(solution.rho))
            ]
            # candidates are polished to 1e-9 mm; near y = 0 two modes lie close together and are told apart at 1e-4
            assert min(apart) < 1e-6
    assert count > 300


def test_every_tilt_of_a_point_that_turns_with_the_platform_is_found():
    """Against sign changes of (3) along the tilt, rho1 being eliminated by (3) minus (4)."""
    rng = np.random.default_rng(11)
    alpha = np.linspace(-np.pi, np.pi, 40001)[1:-1]
    alpha = alpha[alpha != 0.0]
    c, s = np.cos(alpha), np.sin(alpha)
    several = 0
    for _ in range(60):
        pivot, gauge = rng.uniform(-150, 150, 3) + [0.0, 0.0, 900.0], rng.uniform(-300, 300, 3)

        def place(c, s, pivot=pivot, gauge=gauge):  # Rx turns y and z, F takes their negatives
            turned = np.stack(
                np.broadcast_arrays(gauge[0], c * gauge[1] - s * gauge[2], s * gauge[1] + c * gauge[2]), -1
            )
            return pivot + turned * [1.0, -1.0, -1.0]

        position = place(c, s)
        rho1 = position[:, 2] + position[:, 1] * (LENGTHS["R1"] * c - LENGTHS["r1"]) / (LENGTHS["R1"] * s)
        value = rods(position, alpha, np.stack([rho1] * 3, axis=-1))[:, 0]
        crossings = np.flatnonzero(np.sign(value[1:]) != np.sign(value[:-1]))
        found = MODULE.solve_coupled_all(pivot, gauge)
        tilts = sorted({one.alpha for one in found})
        for one in found:
            at = place(np.cos(one.alpha), np.sin(one.alpha))
            assert np.abs(rods(at, one.alpha, one.rho)).max() < 2e-6
        reached = [k for k in crossings if min(_drops(position[k], alpha[k])) > 0]  # by the two single rods
        assert tilts == pytest.approx([0.5 * (alpha[k] + alpha[k + 1]) for k in reached], abs=1e-4)
        assert len(found) == 4 * len(tilts)
        several += len(tilts) > 2
        rho, tilt, ok = MODULE.solve_coupled(pivot, gauge[None])
        used = [(one.alpha, *one.rho) for one in found if one.refused is None]
        assert used == ([pytest.approx((tilt[0], *rho[0]), abs=1e-6)] if ok[0] else [])
    assert several > 10


def test_newtons_method_finds_a_tilt_in_few_steps(monkeypatch):
    """From a milliradian beside it four steps lead to the last digits: errors are squared by each."""
    monkeypatch.setattr(working_modes, "POLISH_STEPS", 4)
    rng = np.random.default_rng(12)
    tried = 0
    for _ in range(30):
        pivot, gauge = rng.uniform(-150, 150, 3) + [0.0, 0.0, 900.0], rng.uniform(-300, 300, 3)
        point = place_coupled_point(pivot, gauge[None]).select(0)
        for one in MODULE.solve_coupled_all(pivot, gauge)[::4]:
            for beside in (-1e-3, 1e-3):
                found = working_modes._polish_tilt(MODULE, point, one.alpha + beside, one.signs[0])
                if found is not None and abs(found - one.alpha) < 1e-2:
                    tried += 1
                    assert found == pytest.approx(one.alpha, abs=1e-13)
    assert tried > 100


@pytest.mark.parametrize("leg", [2, 3])
def test_a_tilt_that_a_leg_just_reaches_is_one(leg):
    """Leg I alone decides the tilt; the other leg has half a square millimetre left, or lacks as much."""
    position = np.array([-240.0, -86.0, 1000.0])
    for alpha in {one.alpha for one in MODULE.inverse_all(position)}:
        needed = LENGTHS[f"L{leg}"] ** 2 - _drops(position, alpha)[leg - 2]
        for left, count in ((0.5, 4), (-0.5, 0)):
            module = VerneModule(**{**LENGTHS, f"L{leg}": float(np.sqrt(needed + left))})
            found = [one for one in module.inverse_all(position) if abs(one.alpha - alpha) < 1e-6]
            assert len({one.rho for one in found}) == count


def _drops(position, alpha):
    """What is left of the two single rods, over what the platform stands away from their sliders; mm2."""
    g = LENGTHS
    side = np.array([1.0, -1.0]) * (g["R2"] * np.cos(alpha) - g["r4"])
    aside = (position[0] + g["leg23_x_offset"]) ** 2 + (position[1] - side) ** 2
    return np.array([g["L2"], g["L3"]]) ** 2 - aside


def test_no_root_is_lost_or_invented():
    """Against sign changes of a dense scan of the rod equations, eliminated in another way: y by (5) minus (6)."""
    rng = np.random.default_rng(9)
    alpha = np.linspace(-np.pi, np.pi, 40001)
    for _ in range(60):
        rho = rng.uniform([50.0, 50.0, 50.0], [1250.0, 1250.0, 1250.0])
        found = MODULE.forward_all(rho)
        for one in found:
            assert np.abs(rods(one.position, one.alpha, rho)).max() < 2e-6
        assert len(found) % 2 == 0  # roots of a polynomial of even degree on the circle come in pairs
        assert len(found) >= _scanned(rho, alpha)


def _scanned(rho, alpha):
    """Sign changes of (3) along alpha, where (14), (5) - (6) and (10) - (5) give y, z and x; poles are left out."""
    g = LENGTHS
    c, s = np.cos(alpha), np.sin(alpha)
    m, n, big_d = g["R2"] * c - g["r4"], g["R2"] * s, g["R1"] * c - g["r1"]
    # (5) - (6): -4 y m - 4 n z + ... is linear in y and z; with (14) y D = R1 s (rho1 - z)
    k2, k3 = -n - rho[1], n - rho[2]
    a11, a12, b1 = -4 * m, 2 * (k2 - k3), k3**2 - k2**2
    a21, a22, b2 = big_d, g["R1"] * s, g["R1"] * s * rho[0]
    det = a11 * a22 - a12 * a21
    with np.errstate(divide="ignore", invalid="ignore"):
        y, z = (b1 * a22 - a12 * b2) / det, (a11 * b2 - a21 * b1) / det
        arm = g["R1"] ** 2 + g["r1"] ** 2 - 2 * g["R1"] * g["r1"] * c
        ten = y**2 + (z - rho[0]) ** 2 - g["L1"] ** 2 + arm  # (10) without its x term
        five = (y - m) ** 2 + (z - n - rho[1]) ** 2 - g["L2"] ** 2
        d = g["leg1_x_offset"] - g["leg23_x_offset"]
        x1 = (five - ten + d * d) / (2 * d)
        value = x1**2 + ten
    jump = np.abs(np.diff(det)) > 0
    change = (np.sign(value[1:]) != np.sign(value[:-1])) & (np.sign(det[1:]) == np.sign(det[:-1])) & jump
    return int(np.sum(change & np.isfinite(value[1:]) & np.isfinite(value[:-1])))
