"""Machine files from configurations of LinuxCNC: the joints are those of its formulas; what cannot be read or meant is refused."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from verne_post.config.linuxcnc import convert_linuxcnc
from verne_post.config.load import build_machine
from verne_post.model.findings import InputError

LETTERS = {
    "xyzab_tdr_kins": "xyzab",
    "xyzac-trt-kins": "xyzac",
    "xyzbc-trt-kins": "xyzbc",
    "5axiskins": "xyzbcw",
    "maxkins": "xyzabcuvw",
}
LENGTH = 62.5


def write_ini(kinematics: str, hal: str = "", letters: str = "", units: str = "mm", more: str = "") -> str:
    """An INI file with limits of its own for each joint."""
    text = f"[EMC]\nMACHINE = mill\n# a comment\n[KINS]\nKINEMATICS = {kinematics}\n[TRAJ]\nLINEAR_UNITS = {units}\n"
    text += "[EMCMOT]\nSERVO_PERIOD = 2000000\n[HAL]\n" + "".join(f"HALCMD = {line}\n" for line in hal.splitlines())
    for number in range(len(letters or LETTERS.get(kinematics.split()[0], "xyzab"))):
        text += (
            f"[JOINT_{number}]\nMIN_LIMIT = {-100 - number}\nMAX_LIMIT = {150 + number}\nMAX_VELOCITY = {20 + number}\n"
        )
        text += f"MAX_ACCELERATION = {300 + number}\n"
    return text + more


def convert(text: str, files: dict[str, str] | None = None) -> Any:
    def read(name: str) -> bytes | None:
        return (files or {})[name].encode() if name in (files or {}) else None

    made = convert_linuxcnc(text.encode(), "m.ini", read)
    return build_machine(made.text.encode(), "m.toml"), made


def find_tip(machine: Any, linear: np.ndarray, tilt: np.ndarray, turn: np.ndarray) -> np.ndarray:
    joints = np.column_stack([linear, tilt, turn]) / [column.factor for column in machine.columns]
    tip, _axis, ok = machine.forward(joints, LENGTH)
    assert ok.all()
    return np.asarray(tip)


def draw_joints() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    random = np.random.default_rng(48)
    return random.uniform(-200, 200, (500, 3)), random.uniform(-175, 175, 500), random.uniform(-175, 175, 500)


@pytest.mark.parametrize("letter", ["a", "b"])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_trunnions_are_those_of_trtfuncs(letter: str, sense: float) -> None:
    """Its forward, with the tool length in the pin tool-offset: pose of the gauge point less the tool is the tip."""
    name, across = f"xyz{letter}c-trt-kins", "y" if letter == "a" else "x"
    point, aside, high = np.array([3.0, -4.0, 5.0]), 11.0, -13.0
    hal = "".join(f"setp {name}.{axis}-rot-point {value}\n" for axis, value in zip("xyz", point, strict=True))
    hal += f"setp {name}.{across}-offset {aside}\nnet :dz {name}.z-offset\nsets :dz {high}\n"
    hal += f"net :tool motion.tooloffset.z => {name}.tool-offset\nsetp {name}.conventional-directions {'TRUE' if sense < 0 else '0'}"
    machine, _made = convert(write_ini(name, hal))
    linear, tilt, turn = draw_joints()
    (st, sc), (ct, cc) = ((f(np.radians(sense * tilt)), f(np.radians(sense * turn))) for f in (np.sin, np.cos))
    dx, dy = (0.0, aside) if letter == "a" else (aside, 0.0)
    jx, jy, jz = (linear - point - [dx, dy, high + LENGTH]).T
    if letter == "a":
        x = cc * jx + sc * ct * jy + sc * st * jz + sc * dy
        y = -sc * jx + cc * ct * jy + cc * st * jz + cc * dy
        z = -st * jy + ct * jz + high + LENGTH
    else:
        x = cc * ct * jx + sc * jy - cc * st * jz + cc * dx
        y = -sc * ct * jx + cc * jy + sc * st * jz - sc * dx
        z = st * jx + ct * jz + high + LENGTH
    wanted = np.stack([x, y, z], axis=1) + point - [0.0, 0.0, LENGTH]
    assert np.abs(find_tip(machine, linear, tilt, turn) - wanted).max() < 1e-9


def test_two_tables_are_those_of_xyzab_tdr() -> None:
    """Its inverse, type 1: the part turns by A and then by B, each about a point of its own."""
    name, point, dx, dz = "xyzab_tdr_kins", np.array([3.0, -4.0, 5.0]), 17.5, -23.0
    hal = "".join(f"setp {name}.{axis}-rot-point {value}\n" for axis, value in zip("xyz", point, strict=True))
    machine, _made = convert(write_ini(name, hal + f"setp {name}.x-offset {dx}\nsetp {name}.z-offset {dz}"))
    random = np.random.default_rng(49)
    tip, a, b = random.uniform(-90, 90, (500, 3)), random.uniform(-100, 100, 500), random.uniform(-170, 170, 500)
    (sa, sb), (ca, cb) = ((f(np.radians(a)), f(np.radians(b))) for f in (np.sin, np.cos))
    qx, qy, qz = (tip + [0.0, 0.0, LENGTH] - point - [dx, 0.0, dz + LENGTH]).T
    linear = np.stack([
        cb * qx + sa * sb * qy - ca * sb * qz + cb * dx - sb * dz,
        ca * qy + sa * qz,
        sb * qx - sa * cb * qy + ca * cb * qz + sb * dx + cb * dz + LENGTH,
    ], axis=1) + point  # fmt: skip
    assert [column.joint for column in machine.columns] == ["x", "y", "z", "b", "a"]
    assert np.abs(find_tip(machine, linear, b, a) - tip).max() < 1e-9


def test_bridge_mill_is_that_of_5axiskins() -> None:
    """With the tool length in W, as the pivot length grows by it."""
    machine, made = convert(
        write_ini("5axiskins", "setp 5axiskins.pivot-length 180.5", more="[AXIS_W]\nMIN_LIMIT = 0\n")
    )
    linear, tilt, turn = draw_joints()
    radius, b, c = 180.5 + LENGTH, np.radians(180.0 - tilt), np.radians(turn)
    arm = radius * np.stack([np.sin(b) * np.cos(c), np.sin(b) * np.sin(c), np.cos(b)], axis=1)
    wanted = linear + arm + [0.0, 0.0, 180.5]
    assert np.abs(find_tip(machine, linear, tilt, turn) - wanted).max() < 1e-9
    assert any("W: a machine file has five joints" in one.message for one in made.findings)


@pytest.mark.parametrize("con", [1.0, -1.0])
def test_max_is_that_of_maxkins(con: float) -> None:
    hal = f"setp maxkins.pivot-length [MAX]PIVOT\nsetp maxkins.conventional-directions {int(con > 0)}"
    machine, _made = convert(write_ini("maxkins", hal, more="[MAX]\nPIVOT = 120.25\n"))
    linear, tilt, turn = draw_joints()
    arm, b, c = 120.25 + LENGTH, np.radians(tilt), np.radians(turn)
    x, y = linear[:, 0] - con * arm * np.sin(b), linear[:, 1]
    wanted = np.stack(
        [np.cos(c) * x - np.sin(c) * y, np.sin(c) * x + np.cos(c) * y, linear[:, 2] - arm * np.cos(b) + 120.25], axis=1
    )
    assert np.abs(find_tip(machine, linear, tilt, turn) - wanted).max() < 1e-9


def test_limits_follow_the_joints_and_units() -> None:
    """Numbers of joints are the places of letters in coordinates; an inch is 25.4 mm, a degree a degree; axes bound rotary joints too."""
    text = write_ini(
        "xyzac-trt-kins coordinates=zyxcay",
        letters="zyxcay",
        units="inch",
        more="[AXIS_A]\nMAX_LIMIT = 90\n[AXIS_C]\nWRAPPED_ROTARY = 1\n",
    )
    machine, made = convert(text.replace("MAX_VELOCITY = 23\n", "MAX_VELOCITY = 23\nMAX_JERK = 2000\n"))
    assert [column.joint for column in machine.columns] == ["x", "y", "z", "a", "c"]
    factor = np.array([column.factor for column in machine.columns])
    ends = np.sort(np.stack([machine.limits.lower * factor, machine.limits.upper * factor]), axis=0)
    wanted = [
        [-102 * 25.4, 152 * 25.4],
        [-101 * 25.4, 151 * 25.4],
        [-100 * 25.4, 150 * 25.4],
        [-104.0, 90.0],
        [-np.inf, np.inf],
    ]
    assert np.allclose(ends.T, wanted)
    assert np.allclose(machine.limits.velocity * np.abs(factor), [22 * 25.4, 21 * 25.4, 20 * 25.4, 24, 23])
    assert machine.cycle == pytest.approx(0.002)
    said = " ".join(one.message for one in made.findings)
    assert "Y has several joints" in said
    assert "xyzac-trt-kins.tool-offset is not connected" in said
    assert "joints.x, joints.y, joints.z, joints.a: no MAX_JERK" in said
    assert machine.limits.jerk[4] == np.radians(2000.0)
    assert {one.code for one in made.findings} == {"VP509"}


def test_files_that_the_ini_names_are_read() -> None:
    text = write_ini("xyzac-trt-kins").replace(
        "[HAL]\n", "[HAL]\nHALFILE = LIB:sim.tcl\nHALFILE = a.hal\nPOSTGUI_HALFILE = none.hal\n"
    )
    head, rest = text.split("[EMCMOT]\n")
    files = {
        "a.hal": "loadrt x\nxyzac-trt-kins.y-offset = 7.5 # mm\nsetp xyzac-trt-kins.z-offset \\\n 2\n",
        "rest.inc": "[EMCMOT]\n" + rest,
    }
    machine, made = convert(head + "#INCLUDE rest.inc\n", files)
    assert machine.five_axis.tilt.through.tolist() == [0.0, 7.5, 2.0]
    assert any("not read: LIB:sim.tcl, none.hal" in one.message for one in made.findings)


GOOD = write_ini("xyzac-trt-kins")


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        ("", "VP507", "[KINS]KINEMATICS is missing"),
        ("KINEMATICS = x\n", "VP507", "m.ini:1: 'KINEMATICS = x' is neither [SECTION] nor NAME = value"),
        (GOOD.replace("MIN_LIMIT = -100\n", "MIN_LIMIT = low\n"), "VP507", "[JOINT_0]MIN_LIMIT = 'low': expected a number"),
        (GOOD.replace("MIN_LIMIT = -100\n", ""), "VP507", "[JOINT_0]: MIN_LIMIT and MAX_LIMIT of x do not bound its travel"),
        (GOOD.replace("MAX_VELOCITY = 21\n", "MAX_VELOCITY = 0\n"), "VP507", "[JOINT_1]MAX_VELOCITY of y is 0; expected a number above 0"),
        (GOOD.replace("= mm", "= furlong"), "VP507", "[TRAJ]LINEAR_UNITS = furlong: expected one of mm"),
        (GOOD.replace("= mm", "= mm\nANGULAR_UNITS = rad"), "VP507", "m.ini:8: [TRAJ]ANGULAR_UNITS = rad: expected deg"),
        (GOOD + "#INCLUDE gone.inc\n", "VP507", "#INCLUDE gone.inc: there is no such file"),
        (write_ini("xyzac-trt-kins coordinates=xyzbc"), "VP507", "xyzac-trt-kins needs a too"),
        (write_ini("xyzac-trt-kins", "net :y xyzac-trt-kins.y-offset probe.out"), "VP507", "comes from the signal :y, which no number is set to"),
        (write_ini("xyzac-trt-kins", "setp xyzac-trt-kins.y-offset [A]B"), "VP507", "[A]B: the INI has no such key"),
        (write_ini("xyzac-trt-kins", "setp xyzac-trt-kins.y-offset nan"), "VP507", "expected a number"),
        (write_ini("genhexkins"), "VP508", "KINEMATICS = genhexkins: a hexapod"),
        (write_ini("xyzacb_trsrn"), "VP508", "three rotary joints"),
        (write_ini("mykins"), "VP508", "no kinematics whose meaning is known here; imported are xyzac-trt-kins"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_or_meant_is_refused(text: str, code: str, said: str) -> None:
    with pytest.raises(InputError) as refused:
        convert(text)
    [item] = refused.value.findings
    assert item.code == code
    assert said in item.message


def test_a_file_that_includes_itself_ends() -> None:
    with pytest.raises(InputError) as refused:
        convert("#INCLUDE m.ini\n", {"m.ini": "#INCLUDE m.ini\n"})
    assert "more than 10 deep" in refused.value.findings[0].message


def test_the_command_writes_a_sound_file_and_says_the_senses(tmp_path: Path, run: Callable[..., Any]) -> None:
    folder = tmp_path / "config"
    folder.mkdir()
    (folder / "kins.hal").write_text("setp xyzac-trt-kins.y-offset 20\n", encoding="utf-8")
    (folder / "m.ini").write_text(GOOD.replace("[HAL]\n", "[HAL]\nHALFILE = kins.hal\n"), encoding="utf-8")
    answer = run("machine", "import", folder / "m.ini", "-o", tmp_path / "mine.toml")
    assert answer.code == 0, answer.err
    assert "A +10: the tool leans towards +y of the part" in answer.out
    assert "VP509 warning:" in answer.err
    assert run("machine", "validate", tmp_path / "mine.toml").code == 0
    assert "through = [0.0, 20.0, 0.0]" in (tmp_path / "mine.toml").read_text(encoding="utf-8")
    (folder / "m.ini").write_text(write_ini("genhexkins"), encoding="utf-8")
    refused = run("machine", "import", folder / "m.ini", "-o", tmp_path / "other.toml")
    assert refused.code == 2
    assert "VP508 error:" in refused.err + refused.out
    assert not (tmp_path / "other.toml").exists()
