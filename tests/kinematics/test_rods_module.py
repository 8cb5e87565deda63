"""Carriers described by their rods: against the closed forms, by a judge of its own, and what is refused on loading."""

import json
import tomllib

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import verne_post
from tests.kinematics.test_chain import ROOT
from verne_post.config.load import build_machine
from verne_post.kinematics.modules.newton import settle
from verne_post.kinematics.modules.rod_geometry import Rod
from verne_post.kinematics.modules.rods import RodsModule
from verne_post.model.findings import InputError

FILES = ["verne_by_rods", "urane_sx"]
TEXT = {name: (ROOT / f"machine_configs/{name}.toml").read_text() for name in [*FILES, "quickstep"]}


def random_poses(seed, n=400):
    random = np.random.default_rng(seed)
    tip = random.uniform([-200, -200, 0], [200, 200, 250], (n, 3))
    return tip, random.uniform([-1.2, -3], [1.2, 3], (n, 2))


def measure_rods(text, rho, position, alpha):
    """Lengths of the rods (n, 6) from the file, rotations by scipy, minus what they should be."""
    rods = tomllib.loads(text)["module"]["rod"]
    turn = Rotation.from_rotvec(np.outer(alpha, [1, 0, 0]))
    misfit = []
    for rod in rods:
        rail = np.array(rod["rail"], float) / np.linalg.norm(rod["rail"])
        foot = np.array(rod["slider"], float) + rho[:, int(rod["by"][-1]) - 1, None] * rail
        end = position + turn.apply(np.array(rod["platform"], float))
        misfit.append(np.linalg.norm(end - foot, axis=1) - rod["length"])
    return np.stack(misfit, axis=1)


def test_the_verne_by_its_rods_is_the_verne():
    """Joints, tilts, derivatives and refusals of 2000 poses, many out of reach: 1e-9 mm is the last digit that
    setpoints have.
    """
    closed, rods = verne_post.load_machine("verne"), verne_post.load_machine("verne_by_rods")
    random = np.random.default_rng(4)
    tip, angles = random.uniform(-900, 900, (2000, 3)), random.uniform([-1.5, -3], [1.5, 3], (2000, 2))
    q, platform, ok = closed.five_axis.solve(tip, angles, 80.0)
    mine, tilted, solved = rods.five_axis.solve(tip, angles, 80.0)
    assert not (solved & ~ok).any()
    # the limit of the file counts for the legs of the closed form, and for each single rod here
    legal = ok & (rods.module.find_geometry_margins(platform.position, platform.alpha)[:, :4] >= 100.0).all(axis=1)
    assert solved[legal].all()
    assert 200 < legal.sum() < ok.sum() < 1800
    ok = solved
    assert np.abs(mine - q)[ok].max() < 1e-9
    assert np.abs(tilted.alpha - platform.alpha)[ok].max() < 1e-12
    tip, angles = tip[ok], angles[ok]
    assert np.allclose(
        rods.five_axis.find_jacobian(tip, angles, 80.0), closed.five_axis.find_jacobian(tip, angles, 80.0), rtol=1e-7
    )
    assert {"VP110"} >= set(rods.five_axis.explain_unreachable(np.full((1, 3), 3e3), np.zeros((1, 2)), 0.0))


def test_a_delta_by_its_rods_is_the_delta():
    delta = verne_post.load_machine("linear_delta").module
    rods = []
    for k, leg in enumerate(np.radians(delta.leg_angles_deg)):
        turn = Rotation.from_euler("z", leg)
        for side in (-60.0, 60.0):
            ends = (turn.apply([radius, side, 0.0]) for radius in (delta.platform_radius, delta.base_radius))
            rods.append(Rod(*ends, (0, 0, 2), delta.rod_length, f"rho{k + 1}"))
    mine = RodsModule((0, 0, 1000.0), (170.0,) * 3, rods, 60.0)
    points = np.random.default_rng(2).uniform([-300, -300, 900], [300, 300, 1500], (500, 3))
    rho, _alpha, ok = delta.inverse(points)
    assert ok.all()
    assert np.abs(mine.inverse(points)[0] - rho).max() < 1e-9
    assert np.abs(mine.forward(rho)[0] - points).max() < 1e-9
    assert mine.parallelograms == ("1", "2", "3")


@pytest.mark.parametrize("name", [*FILES, "quickstep"])
def test_rods_close_and_forward_comes_back(name):
    machine = verne_post.load_machine(name)
    tip, angles = random_poses(7)
    q, platform, ok = machine.five_axis.solve(tip, angles, 80.0)
    assert ok.all()
    assert np.abs(measure_rods(TEXT[name], q[:, :3], platform.position, platform.alpha)).max() < 1e-9
    found, back, ok = machine.five_axis.find_nominal_pose(q, 80.0)
    assert ok.all()
    assert np.abs(found - tip).max() < 1e-8
    assert np.abs(back - angles).max() < 1e-11


def test_a_turned_base_has_the_same_sliders():
    """Turned as a whole by any turn about x (the tilt stays one about x), rails included: no direction is preferred."""
    module = verne_post.load_machine("verne_by_rods").module
    turn = Rotation.from_euler("x", 0.7)
    rods = [
        Rod(turn.apply(r.platform), turn.apply(r.slider), 3 * turn.apply(r.rail), r.length, r.by) for r in module.rod
    ]
    other = RodsModule(turn.apply(module.home), module.home_mm, rods, 60.0)
    points = np.random.default_rng(3).uniform([-150, -150, 850], [150, 150, 1250], (300, 3))
    rho, alpha, ok = module.inverse(points)
    assert ok.all()
    turned = other.inverse(turn.apply(points))
    assert np.abs(turned[0] - rho).max() < 1e-9
    assert np.abs(turned[1] - alpha).max() < 1e-12
    measure = module.find_geometry_margins(points, alpha)[:, -1]
    smallest = np.linalg.svd(module._scale_jacobian(points, alpha, rho), compute_uv=False)[:, -1]
    assert (measure <= smallest * (1 + 1e-9)).all()
    assert (measure * np.sqrt(6) >= smallest * (1 - 1e-9)).all()


def test_other_assemblies_of_the_same_sliders_are_refused():
    """Newton from 40 random starts a pose finds other closed assemblies; none is taken for the machine's, home's always
    is.
    """
    module = verne_post.load_machine("verne_by_rods").module
    random = np.random.default_rng(5)
    points = random.uniform([-150, -150, 850], [150, 150, 1250], (40, 3))
    rho, alpha, _ok = module.inverse(points)
    sliders = np.repeat(rho, 40, axis=0)
    start = np.column_stack([random.uniform(-1500, 1500, (1600, 3)), random.uniform(-3, 3, 1600)])
    pose = settle(module, start, sliders)
    rods = measure_rods(TEXT["verne_by_rods"], sliders, pose[:, :3], pose[:, 3])
    closed = np.abs(rods).max(axis=1) < 1e-6
    home = np.abs(pose[:, :3] - np.repeat(points, 40, axis=0)).max(axis=1) < 1e-6
    assert (closed & ~home).sum() > 100
    taken = module.is_closed(pose, sliders)
    turns = np.abs(np.mod(pose[:, 3] - np.repeat(alpha, 40) + np.pi, 2 * np.pi) - np.pi)
    assert not (taken & ~home).any()
    assert (taken | ~home | (turns > 1e-6) | (np.abs(pose[:, 3]) > 1)).all()


def refuse(name, *pairs):
    text = TEXT[name]
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new, 1)
    with pytest.raises(InputError) as refused:
        build_machine(text.encode(), "mine.toml")
    return " ".join(item.message for item in refused.value.findings)


def test_wrong_rods_are_refused_with_a_reason():
    six = "platform = [213.205080756888, -30.717967697245, 0], slider = [429.711431702997, -155.717967697245, 0]"
    text = refuse("urane_sx", ("[-80, 450, 0]", "[-80, 450.5, 0]"))
    assert "module: rod, value 1 and value 2: these two rods of rho1 do not fit each other: at home value 1" in text
    assert "450.5" in text
    assert "too short to reach its rail" in refuse("urane_sx", ("length = 700", "length = 200"))
    assert "expected a direction" in refuse("urane_sx", ("rail = [0, 0, 1]", "rail = [0, 0, 0]"))
    assert "none is moved by rho1" in refuse("urane_sx", ('by = "rho1"', 'by = "rho2"'), ('by = "rho1"', 'by = "rho2"'))
    assert "rod" in refuse("urane_sx", (f'  {{ {six}, rail = [0, 0, 1], length = 700, by = "rho3" }},\n', ""))


def test_singular_and_otherwise_turning_rods_are_refused():
    """Both rods of each leg at one place: the platform turns freely. The VERNE's twisted about z tilts about another
    axis.
    """
    verne, delta = (verne_post.load_machine(name).module for name in FILES)
    double = [Rod(r.platform, r.slider, r.rail, r.length, r.by) for r in delta.rod for _ in range(2)][::2]
    twice = [double[k - k % 2] for k in range(6)]
    with pytest.raises(ValueError, match="Jacobian is singular"):
        RodsModule(delta.home, delta.home_mm, twice, 60.0)
    turn = Rotation.from_euler("z", 0.5)
    twisted = [Rod(turn.apply(r.platform), turn.apply(r.slider), r.rail, r.length, r.by) for r in verne.rod]
    with pytest.raises(ValueError, match="about x alone"):
        RodsModule(verne.home, verne.home_mm, twisted, 60.0)


def test_cones_and_rods_as_bodies():
    """Thick rods and narrow cones are found by the checks of every machine."""
    bodies = (
        "[rods]\n"
        "diameter_mm = 30\n"
        "slider_cone_deg = 5\n"
        "cone_centre = [0, 0, 1000]\n"
        "[clearance]\n"
        "minimum_mm = 500\n"
        "[home]"
    )
    text = TEXT["verne_by_rods"].replace("[home]", bodies, 1) + 'rods = "assumed"\nclearance = "assumed"\n'
    machine = build_machine(text.encode(), "mine.toml")
    options = verne_post.Options(tool_length=80.0, wcs={"G54": (0, 0, 50)})
    found = verne_post.check("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X120 F900\nM2\n", machine, options).findings
    assert {"VP211", "VP214"} <= {item.code for item in found}


@pytest.mark.parametrize("name", [*FILES, "quickstep"])
def test_a_program_runs_and_a_violation_is_found(name):
    options = verne_post.Options(tool_length=80.0, wcs={"G54": (0, 0, 50)})
    text = "G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X30 Y20 A20 C40 F1500\nM2\n"
    result = verne_post.convert(text, name, options)
    assert result.ok
    last = result.setpoints.values[-1] * [1, 1, 1, np.pi / 180, np.pi / 180]
    tip, _axis, ok = verne_post.load_machine(name).forward(last, 80.0)
    assert ok
    assert np.abs(tip - [30, 20, 100]).max() < 1e-5
    far = verne_post.check(text.replace("X30", "X3000"), name, options)
    assert {"VP110"} <= {item.code for item in far.findings}


REFERENCE = [json.loads(line) for line in (ROOT / "tests/reference/rods.jsonl").read_text().splitlines()[1:]]


@pytest.mark.parametrize("name", ["verne", "verne_by_rods"])
def test_reference_values_of_the_verne(name):
    """Both solutions of 30 poses, loops closed with 40 digits by equations that share nothing with the modules."""
    machine = verne_post.load_machine(name)
    for row in (row for row in REFERENCE if row["machine"] == "verne"):
        tip, axis, length = np.array(row["tip_mm"]), np.array(row["axis"]), row["tool_length_mm"]
        found = [np.array(one.q) for one in machine.five_axis.inverse_all(tip, axis, length) if one.refused is None]
        for solution in row["solutions"]:
            wanted = list(solution["joints"].values())
            away = [one * [column.factor for column in machine.columns] - wanted for one in found]
            assert min(np.abs([*one[:3], *((one[3:] + 180.0) % 360.0 - 180.0)]).max() for one in away) < 1e-9


def test_reference_values_of_the_urane_sx():
    """Its table turns about x and y there: here two rotations put the gauge point where the three sliders have to hold
    it.
    """
    module = verne_post.load_machine("urane_sx").module
    rows = [row for row in REFERENCE if row["machine"] == "urane_sx"]
    assert len(rows) == 30
    up = np.diag([1.0, -1.0, -1.0])  # of the part, in the base frame
    for row in rows:
        gauge = np.array(row["tip_mm"]) + row["tool_length_mm"] * np.array(row["axis"])
        for solution in row["solutions"]:
            joints = solution["joints"]
            tilt, turn = (Rotation.from_euler(axis, joints[name], degrees=True) for axis, name in ("xa", "yb"))
            point = turn.apply(up @ gauge + [0.0, 0.0, -20.0]) + [0.0, 0.0, 1620.0]
            point = tilt.apply(point - [0.0, -10.0, 1650.0]) + [0.0, -10.0, 1650.0]
            rho, _alpha, ok = module.inverse(point - [0.0, 0.0, 150.0])
            assert ok
            assert np.abs(rho - [joints[name] for name in ("q1", "q2", "q3")]).max() < 1e-8  # places have nine decimals


def test_a_carrier_of_another_kind_is_refused():
    """A kind of schema 1 as a carrier of schema 2: one finding says what there is."""
    with pytest.raises(InputError) as refused:
        build_machine(b'schema = 2\nname = "hexapod"\n[carrier]\nkind = "verne"\n', "mine.toml")
    [item] = refused.value.findings
    assert item.code == "VP501"
    assert item.message.startswith("mine.toml: [carrier]")
    assert "kind = 'verne', 'serial', 'linear_delta' or 'rods'" in item.message
