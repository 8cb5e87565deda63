"""Machine files from configurations of LinuxCNC: the joints are those of its formulas; what cannot be read or meant is
refused.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

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
    hal += (
        f"net :tool motion.tooloffset.z => {name}.tool-offset\n"
        f"setp {name}.conventional-directions {'TRUE' if sense < 0 else '0'}"
    )
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
    linear = (
        np.stack(
            [
                cb * qx + sa * sb * qy - ca * sb * qz + cb * dx - sb * dz,
                ca * qy + sa * qz,
                sb * qx - sa * cb * qy + ca * cb * qz + sb * dx + cb * dz + LENGTH,
            ],
            axis=1,
        )
        + point
    )
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


@pytest.mark.parametrize("units", ["inch", "0.03937", "0.0393700787\nANGULAR_UNITS = 1.0"])
def test_limits_follow_the_joints_and_units(units: str) -> None:
    """Numbers of joints are the places of letters in coordinates; an inch is 25.4 mm, a degree a degree; axes bound
    rotary joints too.
    """
    text = write_ini(
        "xyzac-trt-kins coordinates=zyxcay",
        letters="zyxcay",
        units=units,
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
        (GOOD.replace("MIN_LIMIT = -100\n", "MIN_LIMIT = low\n"), "VP507",
         "[JOINT_0]MIN_LIMIT = 'low': expected a number"),
        (GOOD.replace("MIN_LIMIT = -100\n", ""), "VP507",
         "[JOINT_0]: MIN_LIMIT and MAX_LIMIT of x do not bound its travel"),
        (GOOD.replace("MAX_VELOCITY = 21\n", "MAX_VELOCITY = 0\n"), "VP507",
         "[JOINT_1]MAX_VELOCITY of y is 0; expected a number above 0"),
        (GOOD.replace("= mm", "= furlong"), "VP507", "[TRAJ]LINEAR_UNITS = furlong: expected one of mm"),
        (GOOD.replace("= mm", "= mm\nANGULAR_UNITS = rad"), "VP507",
         "m.ini:8: [TRAJ]ANGULAR_UNITS = rad: expected deg"),
        (GOOD.replace("= mm", "= mm\nANGULAR_UNITS = 0.0174533"), "VP507", "expected deg, degree, or 1"),
        (GOOD.replace("= mm", "= 25.4"), "VP507", "LINEAR_UNITS = 25.4: expected one of mm"),
        (GOOD.replace("= mm", "= nan"), "VP507", "LINEAR_UNITS = nan: expected one of mm"),
        (GOOD + "#INCLUDE gone.inc\n", "VP507", "#INCLUDE gone.inc: there is no such file"),
        (write_ini("xyzac-trt-kins coordinates=xyzbc"), "VP507", "xyzac-trt-kins needs a too"),
        (write_ini("xyzac-trt-kins", "net :y xyzac-trt-kins.y-offset probe.out"), "VP507",
         "comes from the signal :y, which no number is set to"),
        (write_ini("xyzac-trt-kins", "setp xyzac-trt-kins.y-offset [A]B"), "VP507", "[A]B: the INI has no such key"),
        (write_ini("xyzac-trt-kins", "setp xyzac-trt-kins.y-offset nan"), "VP507", "expected a number"),
        (write_ini("pentakins"), "VP508", "KINEMATICS = pentakins: five struts"),
        (write_ini("xyzacb_trsrn"), "VP508", "three rotary joints"),
        (write_ini("mykins"), "VP508", "no kinematics whose meaning is known here; imported are xyzac-trt-kins"),
    ],
)  # fmt: skip
def test_what_cannot_be_read_or_meant_is_refused(text: str, code: str, said: str) -> None:
    with pytest.raises(InputError) as refused:
        convert(text)
    [item] = refused.value.findings
    assert item.code == code
    assert item.file == "m.ini"
    assert said in f"m.ini:{item.file_line}: {item.message}"


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
    (folder / "m.ini").write_text(write_ini("pentakins"), encoding="utf-8")
    refused = run("machine", "import", folder / "m.ini", "-o", tmp_path / "other.toml")
    assert refused.code == 2
    assert "m.ini:5: VP508 error:" in refused.err
    (folder / "m.ini").write_text(GOOD.replace("MIN_LIMIT = -100\n", ""), encoding="utf-8")
    refused = run("machine", "import", folder / "m.ini", "-o", tmp_path / "other.toml")
    assert refused.err.count("m.ini") == 1
    assert not (tmp_path / "other.toml").exists()


#: Joints of the sample configuration that LinuxCNC ships for its genhexkins, inches.
BASE = [(-22.95, 13.25), (22.95, 13.25), (22.95, 13.25), (0.0, -26.5), (0.0, -26.5), (-22.95, 13.25)]
PLATFORM = [(-1.0, 11.5), (1.0, 11.5), (10.459, -4.884), (9.459, -6.616), (-9.459, -6.616), (-10.459, -4.884)]


def write_hexapod(spindle: float = 0.0, home: str = "0 0 20 0 0 0", units: str = "inch", more: str = "") -> str:
    hal = ""
    for side, joints in (("base", BASE), ("platform", PLATFORM)):
        for k, place in enumerate(joints):
            hal += "".join(
                f"setp genhexkins.{side}.{k}.{axis} {value}\n" for axis, value in zip("xyz", (*place, 0.0), strict=True)
            )
    hal += f"setp genhexkins.spindle-offset {spindle}\nnet :t genhexkins.tool-offset motion.tooloffset.z\n{more}"
    return write_ini("genhexkins", hal, "xyzabc", units).replace("[TRAJ]\n", f"[TRAJ]\nHOME = {home}\n")


def find_struts(pose: np.ndarray, turn: Rotation, shift: np.ndarray) -> np.ndarray:
    """genhexkins, inverse: |pose + R a - b| with both ends higher by spindle-offset + tool-offset; inches (n, 6)."""
    up = np.stack([0 * shift, 0 * shift, shift], axis=-1)
    legs = [pose + turn.apply(up + [*end, 0.0]) - up - [*base, 0.0] for end, base in zip(PLATFORM, BASE, strict=True)]
    return np.linalg.norm(np.stack(legs, axis=1), axis=2)


def test_the_hexapod_of_genhexkins_stands_at_home_as_its_sample_says() -> None:
    """29.7466: sqrt((22.95 - 1)^2 + (13.25 - 11.5)^2 + 20^2) = sqrt(884.865), which its HOME has rounded."""
    machine, _made = convert(write_hexapod())
    assert machine.five_axis.home[:6] == pytest.approx([25.4 * np.sqrt(884.865)] * 2 + [25.4 * 29.7466] * 4, abs=0.01)
    assert [column.joint for column in machine.columns] == [*(f"joint{k}" for k in range(6)), "a", "c"]
    assert machine.limits.lower[:6].tolist() == [0.0] * 6  # -100 of the file: a strut is not shorter than nothing
    assert machine.limits.upper[:6] == pytest.approx([25.4 * (150 + k) for k in range(6)])
    assert machine.limits.velocity[:6] == pytest.approx([25.4 * (20 + k) for k in range(6)])


@pytest.mark.parametrize("spindle", [0.0, 3.5])
def test_the_struts_are_those_of_genhexkins(spindle: float) -> None:
    """Programs of tip and tool direction; LinuxCNC is given the roll, pitch and yaw of the platform's turn."""
    machine, _made = convert(write_hexapod(spindle))
    random, tool = np.random.default_rng(50), 2.25
    tip = random.uniform([-4, -4, 10], [4, 4, 20], (400, 3))
    tilt, about = random.uniform(0.0, np.radians(25), 400), random.uniform(-np.pi, np.pi, 400)
    # the shortest turn of z is about a horizontal axis
    turn = Rotation.from_rotvec(tilt[:, None] * np.stack([np.cos(about), np.sin(about), 0 * about], axis=1))
    axis = turn.apply([0.0, 0.0, 1.0])
    q, ok = machine.inverse(25.4 * tip, axis, 25.4 * tool)
    assert ok.all()
    roll, pitch, yaw = turn.as_euler("xyz").T
    still = 0.0 * roll
    said = (  # pmRpyMatConvert: about z by yaw, after y by pitch, after x by roll
        Rotation.from_rotvec(np.stack([still, still, yaw], axis=1))
        * Rotation.from_rotvec(np.stack([still, pitch, still], axis=1))
        * Rotation.from_rotvec(np.stack([roll, still, still], axis=1))
    )
    pose = tip + [0.0, 0.0, tool]  # G43: the pose is the tip higher by the tool
    wanted = find_struts(pose, said, np.full(400, spindle + tool))
    assert np.abs(q[:, :6] - 25.4 * wanted).max() < 1e-9
    back, leans, ok = machine.forward(q, 25.4 * tool)
    assert ok.all()
    assert np.abs(back - 25.4 * tip).max() < 1e-9
    assert np.abs(leans - axis).max() < 1e-12


def test_what_a_hexapod_leaves_open_is_said() -> None:
    machine, made = convert(write_hexapod())
    assert machine.clearance is None  # two struts share each joint on the base
    said = " ".join(one.message for one in made.findings)
    for text in (
        "roll, pitch and yaw",
        "count from the gauge point",
        "smallest_singular_value = 0.05 is assumed",
        "screw-lead",
    ):
        assert text in said
    assert "HOME =" not in said
    _machine, made = convert(write_hexapod(more="").replace("[JOINT_3]\n", "[JOINT_3]\nHOME = 29.9\n"))
    assert any("[JOINT_3]HOME = 29.9" in one.message for one in made.findings)


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        (write_hexapod(more="setp genhexkins.screw-lead 0.2"), "VP508", "screw-lead = 0.2: struts whose value turns"),
        (
            write_hexapod().replace("HALCMD = setp genhexkins.base.4.y -26.5\n", ""),
            "VP507",
            "nothing sets genhexkins.base.4.y",
        ),
        (write_hexapod(home="0 0"), "VP507", "[TRAJ]HOME = '0 0': expected X Y Z"),
        (write_hexapod(home="0 0 up"), "VP507", "[TRAJ]HOME = 'up': expected a number"),
        (
            write_hexapod().replace("MAX_LIMIT = 152\n", ""),
            "VP507",
            "[JOINT_2]: MIN_LIMIT and MAX_LIMIT do not bound the strut",
        ),
        (write_hexapod().replace("MAX_VELOCITY = 21\n", ""), "VP507", "[JOINT_1]MAX_VELOCITY of joint1 is missing"),
    ],
)
def test_hexapods_that_cannot_be_read_are_refused(text: str, code: str, said: str) -> None:
    with pytest.raises(InputError) as error:
        convert(text)
    assert error.value.findings[0].code == code
    assert said in error.value.findings[0].message
