"""Velocities and singularities: Jacobians against central differences, VP203 on a geometry made for it."""

import numpy as np
import pytest

from verne_post import load_machine
from verne_post.app.assemble import assemble
from verne_post.app.constraints import check_program
from verne_post.kinematics.modules.verne.module import VerneModule
from verne_post.model.options import Options

from ..builders import LENGTHS, rods

#: Unequal rods, so that no symmetry hides a wrong sign.
SKEW = {**LENGTHS, "L2": 930.0, "L3": 965.0, "R2": 205.0, "leg1_x_offset": -300.0}
#: Step of central differences, mm and rad: error h^2 q''' / 6 near 1e-9, rounding 1e-13 / h near 1e-9.
STEP = 1e-4


def poses(lengths, n=200):
    """Random solved poses of a module."""
    rng = np.random.default_rng(3)
    position = np.stack([rng.uniform(-300, 300, n), rng.uniform(-300, 300, n), rng.uniform(800, 1400, n)], axis=-1)
    module = VerneModule(**lengths)
    rho, alpha, ok = module.inverse(position)
    assert ok.mean() > 0.9
    return module, position[ok], alpha[ok], rho[ok]


@pytest.mark.parametrize("lengths", [LENGTHS, SKEW], ids=["verne", "skew"])
def test_both_parts_are_the_derivatives_of_the_rod_equations(lengths):
    module, position, alpha, rho = poses(lengths)
    parallel, serial = module.find_jacobians(position, alpha, rho)

    def difference(dp=(0, 0, 0), da=0.0, dr=(0, 0, 0)):
        step = STEP * np.array(dp), STEP * da, STEP * np.array(dr)
        ahead = rods(position + step[0], alpha + step[1], rho + step[2], lengths)
        behind = rods(position - step[0], alpha - step[1], rho - step[2], lengths)
        return (ahead - behind) / (4 * STEP)  # half of the derivative

    unit = np.eye(3)
    for k in range(3):
        assert np.abs(parallel[:, :, k] - difference(dp=unit[k])).max() < 1e-5  # of 1e3 mm
        assert np.abs(serial[:, :, k] - difference(dr=unit[k])).max() < 1e-5
    assert np.abs(parallel[:, :, 3] - difference(da=1.0)).max() < 1e-3  # of 1e5 mm2


def test_joint_rates_of_the_whole_machine_against_central_differences():
    machine = load_machine("verne").five_axis
    rng = np.random.default_rng(4)
    n = 300
    tip = np.stack([rng.uniform(-150, 150, n), rng.uniform(-150, 150, n), rng.uniform(0, 150, n)], axis=-1)
    angles = np.stack([rng.uniform(-1.2, 1.2, n), rng.uniform(-3, 3, n)], axis=-1)
    tool = rng.uniform(50, 250, n)
    total = machine.find_jacobian(tip, angles, tool)
    pose = np.concatenate([tip, angles], axis=1)
    for k in range(5):
        step = STEP * np.eye(5)[k]
        ahead, behind = pose + step, pose - step
        q_ahead, q_behind = (machine.solve(p[:, :3], p[:, 3:], tool)[0] for p in (ahead, behind))
        # rounding of q (1e-12 mm) over the step is 1e-8
        assert np.abs(total[:, :, k] - (q_ahead - q_behind) / (2 * STEP)).max() < 2e-7 * np.abs(total[:, :, k]).max()


def test_joint_rates_out_of_reach_are_nan_and_shapes_broadcast():
    machine = load_machine("verne").five_axis
    tip = np.array([[[0.0, 0.0, 50.0], [5000.0, 0.0, 0.0]]])
    total = machine.find_jacobian(tip, np.zeros((1, 2, 2)), 50.0)
    assert total.shape == (1, 2, 5, 5)
    assert np.isfinite(total[0, 0]).all()
    assert np.isnan(total[0, 1]).any()


# --- singularities --------------------------------------------------------------------------------


@pytest.mark.parametrize("lengths", [LENGTHS, SKEW], ids=["verne", "skew"])
def test_the_margin_is_the_scaled_determinant(lengths):
    module, position, alpha, rho = poses(lengths)
    parallel, _serial = module.find_jacobians(position, alpha, rho)
    rod = np.array([lengths["L1"], lengths["L1"], lengths["L2"], lengths["L3"]])
    scaled = parallel / rod[:, None] / np.array([1.0, 1.0, 1.0, max(lengths["R1"], lengths["R2"])])
    determinant = np.linalg.det(scaled)
    margin = module.find_geometry_margins(position, alpha)[:, 4]
    assert np.abs(margin - np.sign(determinant[0]) * determinant).max() < 1e-12
    reach, _serial_part = module.measure_conditioning(position, alpha, rho)
    singular = np.linalg.svd(scaled, compute_uv=False)
    assert np.abs(reach - singular[:, -1] / singular[:, 0]).max() < 1e-12


def test_the_present_geometry_keeps_clear_of_parallel_singularities():
    """Over the whole reachable plane on a 25 mm grid, with every rod's drop above the machine file's 100 mm."""
    module = VerneModule(**LENGTHS)
    x, y = np.meshgrid(np.arange(-550.0, 651.0, 25.0), np.arange(-575.0, 576.0, 25.0))
    position = np.stack([x.ravel(), y.ravel(), np.full(x.size, 900.0)], axis=-1)
    _rho, alpha, ok = module.inverse(position)
    margins = module.find_geometry_margins(position[ok], alpha[ok])
    inside = margins[:, :3].min(axis=1) > 100.0
    assert inside.sum() > 900
    assert margins[inside, 4].min() > 0.2
    assert margins[inside, 4].max() < 1.0


def test_at_a_parallel_singularity_the_platform_moves_with_the_sliders_locked():
    """On a geometry made for it the margin changes sign; there a pose rate exists that moves no slider."""
    module = VerneModule(**SINGULAR)
    x = np.linspace(-350.0, 350.0, 4001)
    position = np.stack([x, np.full_like(x, 60.0), np.full_like(x, 900.0)], axis=-1)
    rho, alpha, ok = module.inverse(position)
    margin = np.where(ok, module.find_geometry_margins(position, alpha)[:, 4], np.nan)
    crossing = np.flatnonzero(margin[1:] * margin[:-1] < 0)
    assert len(crossing) >= 1
    k = crossing[0]
    parallel, _serial = module.find_jacobians(position[k], alpha[k], rho[k])
    _u, _singular, rows = np.linalg.svd(parallel * [1, 1, 1, 1 / module.R2])
    free = rows[-1] * [1, 1, 1, 1 / module.R2]
    # 0.1 mm along the free direction leaves every rod's length as it is to second order
    moved = rods(position[k] + 0.1 * free[:3], alpha[k] + 0.1 * free[3], rho[k], SINGULAR)
    across = rods(position[k] + 0.1 * rows[0, :3], alpha[k] + 0.1 * rows[0, 3] / module.R2, rho[k], SINGULAR)
    assert np.abs(moved).max() < 0.01 * np.abs(across).max()
    assert module.measure_conditioning(position[k], alpha[k], rho[k])[0] < 1e-3


#: All legs on one side of the platform, and narrow: near x = 134.5 the three sliders hold it no longer.
SINGULAR = {**LENGTHS, "leg1_x_offset": 200.0, "leg23_x_offset": 240.0, "r4": 200.0}


def test_vp203_is_an_error_below_the_threshold_and_a_warning_up_to_twice_it(machine_with):
    """A straight line whose ends are clear and whose middle is not, on the constructed geometry."""
    lengths = {f"module.{key}": value for key, value in SINGULAR.items()}
    wide = {**lengths, "limits.rho_mm": [-3000.0, 3000.0], "limits.serial_singularity_mm": 0.0}
    source = b"G21 G90 G94\nG0 X0 Y20 Z60\nG1 X150 F3000\nM2\n"

    def verdict(threshold):
        machine = machine_with({**wide, "limits.parallel_singularity": threshold})
        program = assemble(source, machine, Options(tool_length=50.0))
        return [item for item in check_program(program)[1] if item.code == "VP203"]

    (found,) = verdict(0.004)
    assert found.severity == "error"
    assert found.line == 3
    assert found.value < 0.004 == found.limit
    machine = machine_with({**wide, "limits.parallel_singularity": 0.004})
    program = assemble(source, machine, Options(tool_length=50.0))
    joints = program.build_joint_path()
    solved = joints.solve(np.zeros(2001, dtype=int), np.linspace(0.0, 1.0, 2001))
    dense = machine.module.find_geometry_margins(solved.platform.position, solved.platform.alpha)[:, 4]
    assert found.value == pytest.approx(dense.min(), abs=1e-6)
    threshold = float(dense[:1000].min())  # the same line cut short stays a warning
    short = b"G21 G90 G94\nG0 X0 Y20 Z60\nG1 X75 F3000\nM2\n"
    machine = machine_with({**wide, "limits.parallel_singularity": 0.75 * threshold})
    program = assemble(short, machine, Options(tool_length=50.0))
    (warned,) = [item for item in check_program(program)[1] if item.code == "VP203"]
    assert (warned.severity, warned.limit) == ("warning", pytest.approx(1.5 * threshold))


# --- all solutions of the whole machine -----------------------------------------------------------


def test_every_solution_of_the_whole_machine_gives_the_pose():
    """Own transform: the platform point tilts with alpha, the table stands at A; the axis is that of A - alpha
    and C.
    """
    machine = load_machine("verne")
    rng = np.random.default_rng(5)
    most = 0
    for _ in range(40):
        tip = rng.uniform(-150, 150, 3)
        tilt, turn, tool = rng.uniform(0.05, 1.5), rng.uniform(-3, 3), rng.uniform(50, 250)
        axis = np.array([np.sin(tilt) * np.sin(turn), np.sin(tilt) * np.cos(turn), np.cos(tilt)])
        found = machine.five_axis.inverse_all(tip, axis, tool)
        tilts = {(one.other_table, round(one.alpha, 9)) for one in found}
        most = max(most, *(sum(other == side for other, _alpha in tilts) for side in (False, True)))
        for one in found:
            a, c = one.q[3], one.q[4]
            nominal = a - one.alpha
            held = np.array([np.sin(nominal) * np.sin(c), np.sin(nominal) * np.cos(c), np.cos(nominal)])
            assert held == pytest.approx(axis, abs=1e-12)
            turned = np.array(
                [np.cos(c) * tip[0] - np.sin(c) * tip[1], np.sin(c) * tip[0] + np.cos(c) * tip[1], tip[2]]
            )
            # tip on the tilted table, then up the tilted tool to the platform
            y = np.cos(a) * turned[1] - np.sin(a) * turned[2] - tool * np.sin(one.alpha)
            z = np.sin(a) * turned[1] + np.cos(a) * turned[2] + tool * np.cos(one.alpha)
            position = np.array([0.0, 0.0, 1600.0]) + [turned[0], -y, -z]
            assert np.abs(rods(position, np.array(one.alpha), np.array(one.q[:3]), LENGTHS)).max() < 5e-6
        in_use = [one for one in found if one.refused is None and not one.other_table]
        q, ok = machine.inverse(tip, axis, tool)
        assert ok == (len(in_use) > 0)
        if ok:
            assert min(np.abs(np.array(one.q) - q).max() for one in in_use) < 1e-9
    assert most <= 6
