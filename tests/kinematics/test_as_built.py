"""The as-built machine: against a second formulation, against the nominal machine, and on whole programs."""

import math
from pathlib import Path

import numpy as np
import pytest

import verne_post as vp
from verne_post.base.rotations import find_axis_of_angles
from verne_post.config import list_machine_files
from verne_post.config.load import build_machine
from verne_post.kinematics.as_built.axis_correction import AxisCorrection
from verne_post.kinematics.as_built.machine import AsBuiltMachine

from .six_rods import SixRods, as_toml, random_table

VERNE = list_machine_files()["verne"].read_text(encoding="utf-8")
SAMPLES = Path(__file__).resolve().parents[2] / "gcode_samples"
TOOL = 100.0
#: Tips (mm) and angles (degrees) at the corners of the workspace, and its middle.
CORNERS = [
    (x, y, z, a, c) for x in (-220, 220) for y in (-220, 220) for z in (10, 250) for a in (-85, 0, 85) for c in (0, 130)
]


def built(table, changes=()):
    text = VERNE
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    return build_machine((text + as_toml(table)).encode(), "m.toml")


@pytest.fixture(scope="module")
def perturbed():
    return built(random_table(1))


@pytest.fixture(scope="module")
def poses():
    """Legal poses of the nominal machine: tip, angles, joints."""
    rng = np.random.default_rng(5)
    n = 4000
    tip = rng.uniform([-220, -220, 0], [220, 220, 260], (n, 3))
    angles = np.radians(rng.uniform([-80, -180], [80, 180], (n, 2)))
    machine = vp.load_machine("verne")
    q, _platform, ok = machine.five_axis.solve(tip, angles, TOOL)
    ok &= ((q >= machine.limits.lower) & (q <= machine.limits.upper)).all(axis=1)
    return tip[ok], angles[ok], q[ok]


# --- against other formulations ----------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_inverse_agrees_with_ten_equations_solved_by_least_squares(seed, poses):
    """1e-9 mm in the sliders; scipy's rotations, no elimination."""
    table = random_table(seed)
    machine, reference, nominal = built(table), SixRods(table), vp.load_machine("verne")
    tips, angles, joints = poses
    chosen = [(tips[k], angles[k], joints[k]) for k in range(seed, len(tips), 400)]
    for x, y, z, a, c in CORNERS[seed::4]:
        tip, pair = np.array([x, y, z], float), np.radians([a, c])
        q, _platform, ok = nominal.five_axis.solve(tip, pair, TOOL)
        if ok:
            chosen.append((tip, pair, q))
    for tip, pair, near in chosen:
        q, _platform, ok = machine.five_axis.solve(tip, pair, TOOL)
        assert ok
        other = reference.inverse(tip, *pair, TOOL, near)
        assert q[:3] == pytest.approx(other[:3], abs=1e-9)
        assert q[3:] == pytest.approx(other[3:], abs=1e-11)


def test_forward_leads_back_and_agrees_with_the_equations(perturbed, poses):
    tip, angles, _q = poses
    q = perturbed.five_axis.find_joints(tip, angles, TOOL)
    back, pair, axis, ok = perturbed.five_axis.measure(q, TOOL)
    assert ok.all()
    assert np.abs(back - tip).max() < 1e-9
    assert np.abs(pair - angles).max() < 1e-11
    reference = SixRods(random_table(1))
    platform, closed = perturbed.five_axis.find_platform(q)
    assert closed.all()
    from scipy.spatial.transform import Rotation

    for k in range(0, len(q), 97):
        turn = Rotation.from_matrix(platform.build_matrix()[k]).as_rotvec()
        assert np.abs(reference.rods(q[k, :3], turn, platform.position[k])).max() < 1e-9
        at, direction = reference.tool(turn, platform.position[k], q[k, 3], q[k, 4], TOOL)
        assert at == pytest.approx(back[k], abs=1e-9)
        assert direction == pytest.approx(axis[k], abs=1e-12)


def test_without_deviations_the_joints_are_the_nominal_ones(poses):
    """Through the as-built route: 1e-9 mm."""
    machine, nominal = built({}), vp.load_machine("verne")
    assert isinstance(machine.five_axis, AsBuiltMachine)
    tip, angles, q = poses
    assert np.abs(machine.five_axis.find_joints(tip, angles, TOOL) - q).max() < 1e-9
    solved, platform, _ok = machine.five_axis.solve(tip, angles, TOOL)
    ideal = nominal.five_axis.solve(tip, angles, TOOL)[1]
    assert np.abs(platform.position - ideal.position).max() < 1e-9
    assert np.abs(platform.angles - ideal.angles).max() < 1e-12
    margins = machine.five_axis.find_geometry_margins(solved, angles, platform)
    expected = nominal.five_axis.find_geometry_margins(q, angles, ideal)
    assert margins[:, :5] == pytest.approx(expected, abs=1e-9)
    assert np.abs(margins[:, 6:]).max() < 1e-9


@pytest.mark.parametrize("sample", ["posted.nc", "pocket_3axis.nc"])
def test_without_deviations_setpoints_are_the_nominal_ones(sample):
    """From stop to stop: profiles are made of derivatives, which amplify rounding of the joints (1e-12 mm) a
    thousandfold.
    """
    source = (SAMPLES / sample).read_bytes()
    options = vp.Options(tool_length=80.0, wcs={"G54": (0, 0, 20)}, smoothing="off", decimals=10)
    rows = [vp.convert(source, machine, options).setpoints for machine in (built({}), vp.load_machine("verne"))]
    assert rows[0].values == pytest.approx(rows[1].values, abs=5e-9)


def test_deviations_of_single_parts_do_what_they_say():
    """Each from the geometry of the parts alone."""
    tip, angles = np.array([30.0, -40.0, 50.0]), np.radians([0.0, 0.0])
    plain = vp.load_machine("verne").five_axis.find_joints(tip, angles, TOOL)
    # every slider joint 0.3 mm lower: every slider 0.3 mm higher
    lower = built({"slider_ends_mm": [[0, 0, 0.3]] * 6}).five_axis.find_joints(tip, angles, TOOL)
    assert lower - plain == pytest.approx([-0.3] * 3 + [0, 0], abs=1e-9)
    # the whole rotary axis aside: the table's origin goes with it, and so does the part
    aside = built({"rotary_axis_mm": [0.2, 0.0]}).five_axis.find_joints(tip, angles, TOOL)
    shifted = vp.load_machine("verne").five_axis.find_joints(tip + [0.2, 0, 0], angles, TOOL)
    assert aside == pytest.approx(shifted, abs=1e-9)
    # a tilt axis above the pivot is no difference at A = 0 but for the tilt of the platform
    joints = built({"tilt_axis_mm": [0.0, 0.4]}).five_axis.find_joints(np.array([0.0, 0.0, 50.0]), angles, TOOL)
    assert joints == pytest.approx(
        vp.load_machine("verne").five_axis.find_joints(np.array([0.0, 0.0, 50.0]), angles, TOOL), abs=1e-9
    )


# --- what five axes cannot correct ------------------------------------------------------------------------


def test_the_axis_lies_in_the_plane_of_the_programmed_one_and_the_tilt_axis(perturbed, poses):
    tip, angles, _q = poses
    q, platform, _ok = perturbed.five_axis.solve(tip, angles, TOOL)
    axis = perturbed.five_axis.forward(q, TOOL)[1]
    off = np.linalg.norm(axis - find_axis_of_angles(angles[:, 0], angles[:, 1]), axis=1)
    error = perturbed.five_axis.measure_axis_error(q, angles, platform)
    assert np.abs(error) == pytest.approx(off, rel=1e-3, abs=1e-9)
    assert np.degrees(off).max() > 0.03  # nothing is corrected by accident


def test_c_takes_its_share_where_the_tool_is_tilted(perturbed, poses):
    tip, angles, _q = poses
    corrected = perturbed.five_axis.switch_correction(on=True)
    q = corrected.find_joints(tip, angles, TOOL)
    back, axis, ok = corrected.forward(q, TOOL)
    assert ok.all()
    assert np.abs(back - tip).max() < 1e-9
    tilt = np.abs(np.degrees(angles[:, 0]))
    off = np.linalg.norm(axis - find_axis_of_angles(angles[:, 0], angles[:, 1]), axis=1)
    assert off[tilt > 6.0].max() < 1e-11
    assert np.array_equal(q[tilt < 2.0, 4], angles[tilt < 2.0, 1])
    error = np.abs(perturbed.five_axis.measure_axis_error(*_solved(perturbed, tip, angles))).max()
    assert np.abs(q[:, 4] - angles[:, 1]).max() < error / math.sin(AxisCorrection().begins)
    _tip, pair, _axis, _ok = corrected.measure(q, TOOL)
    assert np.abs(pair - angles).max() < 1e-11  # also between the two tilts


def _solved(machine, tip, angles):
    q, platform, _ok = machine.five_axis.solve(tip, angles, TOOL)
    return q, angles, platform


def test_the_share_has_three_continuous_derivatives():
    share, step = AxisCorrection().share, 1e-4
    for edge in (AxisCorrection().begins, AxisCorrection().whole):
        for order in (1, 2, 3):
            sides = [np.diff(share(edge + side * step * (np.arange(order + 1) + 0.5)), order)[0] for side in (-1, 1)]
            jump = abs(abs(sides[0]) - abs(sides[1])) / step**order
            scale = {1: 40.0, 2: 4e3, 3: 4e5}[order]  # of a ramp of 4 degrees
            assert jump < 0.02 * scale


def test_the_axis_error_of_a_program_is_bounded_and_not_far_from_sampled_ones(perturbed):
    source = b"G21 G90 G94\nG0 X60 Y-40 Z40 A-40 C-60\nG1 X-70 Y50 Z55 A50 C100 F4000\nM2\n"
    result = vp.convert(source, perturbed, vp.Options(tool_length=100.0))
    assert result.ok, result.findings
    bound, seen = result.summary.axis_error_deg, result.summary.verification.axis_error_deg
    assert seen <= bound <= 1.02 * seen


# --- the machine file ----------------------------------------------------------------------------------


def refused(text):
    with pytest.raises(vp.InputError) as found:
        build_machine(text.encode(), "m.toml")
    return [item.message for item in found.value.findings]


def test_what_is_no_as_built_table_is_refused():
    (text,) = refused(VERNE + as_toml({"rod_lengths_mm": [0.1] * 5}))
    assert "m.toml: as_built.rod_lengths_mm" in text
    assert "6" in text
    (text,) = refused(VERNE + as_toml({"rod_length_mm": [0.1] * 6}))
    assert "did you mean rod_lengths_mm" in text
    assert len(refused(VERNE + as_toml({"rod_lengths_mm": [850.1] * 6}))) == 6  # lengths in place of deviations
    assert "source is missing" in " ".join(refused(VERNE + "\n[as_built]\nrod_lengths_mm = [0, 0, 0, 0, 0, 0]\n"))
    serial = list_machine_files()["serial"].read_text(encoding="utf-8")
    (text,) = refused(serial + as_toml({}))
    assert "'serial' has no as-built model" in text
    without = VERNE[: VERNE.index("[rods]")] + VERNE[VERNE.index("[accuracy]") :].replace('rods = "assumed"\n', "")
    (text,) = refused(without + as_toml({}))
    assert "rods is missing" in text


def test_a_machine_that_does_not_close_names_the_parameter():
    table = random_table(3)
    table["rod_lengths_mm"][4] = -20.0
    drop = "serial_singularity_mm = 100.0", "serial_singularity_mm = 0.0"
    (text,) = refused((VERNE + as_toml(table)).replace(*drop))
    assert "rod_lengths_mm, rod III at larger x = -20 mm" in text


def test_a_file_of_its_own(tmp_path):
    table = random_table(2)
    (tmp_path / "machine.toml").write_text(VERNE + '\n[as_built]\nfile = "parts.toml"\n', encoding="utf-8")
    (tmp_path / "parts.toml").write_text(as_toml(table), encoding="utf-8")
    machine = vp.load_machine(str(tmp_path / "machine.toml"))
    assert np.array_equal(machine.five_axis.deviations.pack_vector(), built(table).five_axis.deviations.pack_vector())
    assert machine.provenance["as_built"] == "made for a test"
    before = machine.sha256
    (tmp_path / "parts.toml").write_text(as_toml(random_table(4)), encoding="utf-8")
    assert vp.load_machine(str(tmp_path / "machine.toml")).sha256 != before
    (tmp_path / "parts.toml").write_text(as_toml(table) + "[limits]\n", encoding="utf-8")
    with pytest.raises(vp.InputError, match="expected one table"):
        vp.load_machine(str(tmp_path / "machine.toml"))
    (tmp_path / "parts.toml").unlink()
    with pytest.raises(vp.InputError, match=r"as_built\.file 'parts\.toml'"):
        vp.load_machine(str(tmp_path / "machine.toml"))


def test_the_options_of_the_correction_are_refused_on_a_nominal_machine():
    result = vp.convert(b"G21 G90\nG0 X0 Y0 Z50 A0 C0\nM2\n", "verne", vp.Options(correct_axis=True))
    assert not result.ok
    assert "[as_built]" in result.findings[0].message


# --- margins and bodies -----------------------------------------------------------------------------------


def test_determinants_are_those_of_the_six_rod_jacobian(perturbed, poses):
    """The product of both margins is the determinant of the 6 x 6 matrix, over rods, spacing and arm."""
    tip, angles, _q = (part[::40] for part in poses)
    q, platform, _ok = perturbed.five_axis.solve(tip, angles, TOOL)
    geometry = perturbed.five_axis.geometry
    margins = perturbed.five_axis.find_geometry_margins(q, angles, platform)
    start, end = np.moveaxis(perturbed.five_axis.sketch(q, platform), 2, 0)
    rods = end - start
    assert np.linalg.norm(rods, axis=-1) == pytest.approx(np.tile(geometry.rods, (len(q), 1)), abs=1e-9)
    arms = end - platform.position[:, None]
    whole = np.abs(np.linalg.det(np.concatenate([rods, np.cross(arms, rods)], axis=-1)))
    length, ends = geometry.rods, geometry.platform_ends
    spacing = np.linalg.norm(ends[2] - ends[3]) * np.linalg.norm(ends[4] - ends[5])
    scale = length[0] * length[1] * length[2] * length[4] * np.abs(ends[:, 1]).max() * spacing * length[2] * length[4]
    assert margins[:, 4] * margins[:, 5] == pytest.approx(whole / scale, rel=1e-9)
    assert (margins[:, 4:6] > 0).all()
    parallel, serial = perturbed.five_axis.measure_conditioning(q, platform)
    assert ((parallel > 0) & (parallel < 1) & (serial > 0) & (serial < 1)).all()


# --- whole programs -----------------------------------------------------------------------------------------


def test_setpoints_for_the_drawing_are_out_by_tenths_on_the_real_machine(perturbed):
    source = b"G21 G90 G94 F3000\nG0 X-40 Y0 Z50 A20 C0\nG1 X40 A30 C20\nY30\nX-40\nM2\n"
    options = vp.Options(tool_length=100.0)
    ideal, real = (vp.convert(source, machine, options) for machine in ("verne", perturbed))
    assert ideal.ok
    assert real.ok
    assert real.summary.verification.tip_deviation_mm < 0.01
    old = vp.verify(ideal.setpoints, source, perturbed, options)
    assert not old.ok
    assert 0.05 < old.tip_deviation_mm < 0.6
    assert vp.verify(real.setpoints, source, perturbed, options).ok


def test_tool_vectors_are_corrected_through_both_axes(perturbed):
    source = b"G21 G90 G94 F2000\nG43.5 H1\nG0 X0 Y0 Z60 I0 J0.6 K0.8\nG1 X20 I0.48 J0.36 K0.8\nX40 I0.6 J0 K0.8\nM2\n"
    result = vp.convert(source, perturbed, vp.Options(dialect="fanuc", tool_length=80.0))
    assert result.ok, result.findings
    assert result.summary.verification.axis_error_deg < 1e-5


def test_no_command_writes_over_the_parts_of_the_machine(tmp_path, run, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "machine.toml").write_text(VERNE + '\n[as_built]\nfile = "parts.csv"\n', encoding="utf-8")
    (tmp_path / "parts.csv").write_text(as_toml(random_table(2)), encoding="utf-8")
    (tmp_path / "a.nc").write_text("G21 G90\nG0 X0 Y0 Z50 A0 C0\nX5\nM2\n", encoding="utf-8")
    answer = run("convert", "a.nc", "--machine", "machine.toml", "--tool-length", "80", "-o", "parts.csv")
    assert answer.code == 2
    assert (tmp_path / "parts.csv").read_text(encoding="utf-8") == as_toml(random_table(2))
