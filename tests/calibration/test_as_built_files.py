"""Files of a calibration: machine files with [as_built], readings, lengths, covariances; and the study of
tolerances.
"""

import re
import tomllib

import numpy as np
import pytest

import verne_post
from verne_post.calibration.as_built.covariance_file import format_covariance, read_covariance
from verne_post.calibration.as_built.machine_text import write_machine_text
from verne_post.calibration.as_built.perturb import draw_deviations, simulate_tips
from verne_post.calibration.as_built.readings import format_readings, read_length_readings, read_tool_readings
from verne_post.calibration.as_built.tolerances import study_tolerances
from verne_post.config import list_machine_files
from verne_post.config.load import build_machine
from verne_post.model.deviations import IS_ANGLE, PARAMETERS, Deviations
from verne_post.model.findings import InputError

from .independent import SIGMA, tools

VERNE = list_machine_files()["verne"].read_bytes()
HEADER = "rho1_mm,rho2_mm,rho3_mm,a_deg,c_deg,tool_length_mm,x_mm,y_mm,z_mm"
ROW = "600,580,590,10,20,100"


# --- machine files -------------------------------------------------------------------------------------


def test_a_machine_file_keeps_its_text_and_gets_the_deviations():
    drawn = draw_deviations(3, SIGMA)
    text = write_machine_text(VERNE, drawn, "perturbed", "verne.toml")
    assert text.startswith(VERNE.decode().rstrip())
    machine = build_machine(text.encode(), "mine.toml")
    assert machine.provenance["as_built"] == "perturbed"
    assert machine.five_axis.deviations.pack_vector() == pytest.approx(drawn.pack_vector(), abs=1e-7)
    assert machine.five_axis.deviations.pack_vector()[IS_ANGLE] == pytest.approx(
        drawn.pack_vector()[IS_ANGLE], abs=1e-10
    )


def test_a_table_that_stands_in_the_middle_is_replaced():
    first = write_machine_text(VERNE, draw_deviations(3, SIGMA), "one", "verne.toml")
    table = first[first.rindex("[as_built]") :]
    moved = first.replace(table, "").replace("[control]", table + "\n[control]")
    assert tomllib.loads(moved) == tomllib.loads(first)
    again = write_machine_text(moved.encode(), Deviations.build_nominal(), 'quotes " and \\', "mine.toml")
    assert again.count("\n[as_built]") == 1
    found = tomllib.loads(again)
    assert found["as_built"]["source"] == 'quotes " and \\'
    assert np.array(found["as_built"]["platform_ends_mm"]).shape == (6, 3)
    assert np.abs(found["as_built"]["slider_ends_mm"]).max() == 0.0
    assert {key: value for key, value in found.items() if key != "as_built"} == tomllib.loads(VERNE.decode())
    bare = re.sub(r"\],\s*# [^\n]*\n\]", "]\n]", moved)  # last rows without a comma look like a header
    assert bare != moved
    assert write_machine_text(bare.encode(), Deviations.build_nominal(), "x", "m") == write_machine_text(
        moved.encode(), Deviations.build_nominal(), "x", "m"
    )
    for comment in ("# mm; symbols of the paper", "# seconds", "# defaults of G64"):
        assert again.count(comment) == VERNE.decode().count(comment)


def test_a_table_that_cannot_be_replaced_line_by_line_is_refused():
    inline = VERNE.replace(b"schema = 1", b'schema = 1\nas_built = {source = "inline"}')
    with pytest.raises(InputError, match="write it as a table"):
        write_machine_text(inline, Deviations.build_nominal(), "x", "mine.toml")


def test_the_same_seed_is_the_same_machine_and_all_parts_move():
    one, same, other = (draw_deviations(seed, SIGMA).pack_vector() for seed in (5, 5, 6))
    assert (one == same).all()
    assert (one != other).all()
    spread = np.mean([(draw_deviations(seed, SIGMA).pack_vector() / SIGMA) ** 2 for seed in range(200)], axis=0)
    assert spread == pytest.approx(np.ones(58), abs=0.45)  # 4.5 deviations of a chi-square of 200
    assert spread.mean() == pytest.approx(1.0, abs=0.06)


def test_tolerances_of_the_machine_file(tmp_path):
    file = VERNE.decode().replace(
        "[accuracy]", "[tolerances]\nlengths_mm = 0.02\nrod_lengths_mm = 0.005\nguides_mrad = 0.3\n\n[accuracy]"
    )
    with pytest.raises(InputError, match=r"provenance\.tolerances is missing"):
        build_machine(file.encode(), "mine.toml")
    file = file.replace('limits = "assumed"', 'limits = "assumed"\ntolerances = "specified by the drawings"')
    found = dict(zip(PARAMETERS, build_machine(file.encode(), "mine.toml").tolerances, strict=True))
    assert found["rod_lengths_mm, rod I at +y"] == 0.005
    assert found["platform_ends_mm, rod I at +y, x"] == 0.02
    assert found["guides_mrad, leg II, x"] == pytest.approx(3e-4)
    assert found["spindle_axis_mrad, x"] == pytest.approx(1e-4)


# --- readings ------------------------------------------------------------------------------------------


def mistakes(text: str, machine: verne_post.Machine) -> list[tuple[int | None, str]]:
    with pytest.raises(InputError) as error:
        read_tool_readings(text.encode(), machine, 0.003, 0.02)
    assert {item.code for item in error.value.findings} == {"VP502"}
    return [(item.line, item.message) for item in error.value.findings]


def test_readings_in_units_and_senses_of_the_machine(machine):
    text = (
        "# laser tracker\n"
        f"{HEADER},i,j,k,sigma_mm,sigma_mrad,sphere,frame,remark\n"
        f"{ROW},1,2,3,,,,,,,,\n"
        f"{ROW},1,,3,0,0.6,0.8,0.01,0.5,ball,,x\n"
        f"{ROW},1,2,3,,,,,,,ball,\n"
    )
    found, blank = read_tool_readings(text.encode(), machine, 0.003, 0.02)
    assert blank == 0
    assert found.joints == pytest.approx(np.array([[600, 580, 590, np.radians(10), np.radians(20)]] * 3))
    assert found.length.tolist() == [100, 100, 100]
    assert found.line.tolist() == [3, 4, 5]
    assert found.station.tolist() == [-1, 0, 1]
    assert found.turned.tolist() == [False, False, True]
    assert found.sigma_tip.tolist() == [0.003, 0.01, 0.003]
    assert found.sigma_axis == pytest.approx([2e-5, 5e-4, 2e-5])
    assert np.isnan(found.tip).tolist() == [[False] * 3, [False, True, False], [False] * 3]
    assert np.isnan(found.axis).all(axis=1).tolist() == [True, False, True]
    turned = build_machine(VERNE.replace(b'a_positive = "workpiece"', b'a_positive = "tool"'), "x.toml")
    assert read_tool_readings(text.encode(), turned, 0.003, 0.02)[0].joints[0, 3] == pytest.approx(-np.radians(10))


def test_rows_that_are_still_to_be_measured_are_counted(machine):
    found, blank = read_tool_readings(f"{HEADER}\n{ROW},,,\n{ROW},1,2,3\n".encode(), machine, 0.003, 0.02)
    assert (len(found), blank, found.line.tolist()) == (1, 1, [3])
    assert mistakes(f"{HEADER}\n{ROW},,,\n", machine) == [(1, "no row has a measured value")]


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        (f"{HEADER},i\n{ROW},1,2,3,1\n", 1, "three columns"),
        (f"{HEADER},i,j,k\n{ROW},1,2,3,0,0,0.9\n", 2, "length 0.900000"),
        (f"{HEADER},i,j,k\n{ROW},1,2,3,0,,1\n", 2, "j is blank"),
        (f"{HEADER},sigma_mm\n{ROW},1,2,3,0\n", 2, "greater than 0"),
        (f"{HEADER},sphere,frame\n{ROW},1,2,3,a,b\n", 2, "one of them"),
        (f"{HEADER}\n600,x,590,10,20,100,1,2,3\n", 2, "rho2_mm = 'x'"),
        (f"{HEADER}\n{ROW},1,2\n", 2, "8 values; expected 9"),
        (f"{HEADER.replace('c_deg', 'c_degr')}\n{ROW},1,2,3\n", 1, "did you mean c_deg"),
    ],
)
def test_a_mistake_has_its_line_and_what_would_be_right(machine, text, line, says):
    found = mistakes(text, machine)
    assert found[0][0] == line
    assert any(says in message for _line, message in found)


def test_lines_to_fill_in_are_read_back(machine, draw_poses):
    poses = draw_poses(5, 2)
    tips = poses.tip + 0.01
    text = "".join(format_readings(machine, poses.joints, poses.length, tips))
    found, blank = read_tool_readings(text.encode(), machine, 0.003, 0.02)
    assert blank == 0
    assert found.joints == pytest.approx(poses.joints, abs=1e-6)
    assert found.tip == pytest.approx(tips, abs=6e-5)
    empty = "".join(format_readings(machine, poses.joints, poses.length, np.full((5, 3), np.nan)))
    assert empty.count(",60,,,,pose") + empty.count(",160,,,,pose") == 5


def test_measured_lengths_by_name():
    text = (
        b"length,value_mm,sigma_mm,remark\nrod 3,950.01,0.002,\nplatform 1-2,260.003,0.004,bores\nslider "
        b"5-6,120,0.01,\n"
    )
    found = read_length_readings(text)
    assert [(one.part, one.rods, one.value, one.sigma, one.line) for one in found] == [
        ("rod", (2,), 950.01, 0.002, 2),
        ("platform", (0, 1), 260.003, 0.004, 3),
        ("slider", (4, 5), 120.0, 0.01, 4),
    ]
    for bad, says in (("rod 7", "is not known"), ("slider 1-3", "is not known"), ("platform 2-1", "did you mean")):
        with pytest.raises(InputError, match=says):
            read_length_readings(f"length,value_mm,sigma_mm\n{bad},950,0.1\n".encode())
    with pytest.raises(InputError, match="greater than 0"):
        read_length_readings(b"length,value_mm,sigma_mm\nrod 1,850,0\n")


def test_simulated_tips_are_those_of_the_equations(model, draw_poses, true_machine):
    poses, true = draw_poses(10, 4), true_machine(4)
    machine = model.machine.replace_deviations(Deviations.build_from_vector(true))
    exact = tools(true, poses.joints, poses.length)[0]
    assert simulate_tips(machine, poses.joints, poses.length, 0.0, 1) == pytest.approx(exact, abs=1e-9)
    noisy = np.concatenate(
        [simulate_tips(machine, poses.joints, poses.length, 0.01, seed) - exact for seed in range(30)]
    )
    assert noisy.std() == pytest.approx(0.01, rel=0.1)


# --- covariance --------------------------------------------------------------------------------------------


def test_a_covariance_is_read_back_for_its_own_deviations():
    rng = np.random.default_rng(1)
    root = SIGMA[:, None] * rng.standard_normal((58, 58))
    covariance, deviations = root @ root.T, SIGMA * rng.standard_normal(58)
    raw = "".join(format_covariance(deviations, covariance)).encode()
    prior = read_covariance(raw, deviations)
    assert prior.factor @ prior.factor.T == pytest.approx(covariance, rel=1e-9, abs=1e-16)
    other = np.array(deviations)
    other[40] += 0.001
    with pytest.raises(InputError, match="rod_lengths_mm, rod III at larger x differs"):
        read_covariance(raw, other)
    for broken in (b"a,b\n1,2\n", raw[:-9000], b"\xff", raw.replace(b"rod I at +y", b"rod one")):
        with pytest.raises(InputError, match="not a covariance file"):
            read_covariance(broken, deviations)


# --- tolerances ------------------------------------------------------------------------------------------


def test_each_tolerance_does_what_the_equations_say(model, draw_poses):
    """Each part off by its tolerance, alone, by scipy; the order is that of the root mean squares."""
    poses = draw_poses(12, 8)
    study = study_tolerances(model, np.zeros(58), SIGMA, poses, IS_ANGLE)
    nominal = tools(np.zeros(58), poses.joints, poses.length)
    ranked = [item.tip for item in study.parameters]
    assert ranked == sorted(ranked, reverse=True)
    assert {item.name for item in study.parameters} == set(PARAMETERS)
    for item in (*study.parameters[:3], *study.parameters[25:28], study.parameters[-1]):
        vector = np.zeros(58)
        vector[PARAMETERS.index(item.name)] = item.tolerance
        moved = tools(vector, poses.joints, poses.length)
        tip, axis = (np.linalg.norm(one - zero, axis=1) for one, zero in zip(moved, nominal, strict=True))
        assert item.tip == pytest.approx(np.sqrt((tip**2).mean()), rel=2e-3, abs=1e-9)
        assert item.tip_max == pytest.approx(tip.max(), rel=2e-3, abs=1e-9)
        assert item.axis == pytest.approx(np.sqrt((axis**2).mean()), rel=2e-3, abs=1e-12)


def test_all_tolerances_together_are_what_random_machines_do(model, draw_poses):
    poses = draw_poses(40, 8)
    study = study_tolerances(model, np.zeros(58), SIGMA, poses, IS_ANGLE)
    squares = []
    for seed in range(300):
        true = draw_deviations(seed, SIGMA).pack_vector()
        squares.append(((model.predict(true, poses.joints, poses.length).tip - poses.tip) ** 2).sum(axis=1))
    assert np.sqrt(np.mean(squares)) == pytest.approx(np.sqrt((study.tip**2).mean()), rel=0.1)
