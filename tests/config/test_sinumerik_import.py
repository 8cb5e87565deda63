"""Machine files from machine data of a SINUMERIK: tips by the formula of the tool carrier; what is missing or not meant
is refused.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from verne_post.config.load import build_machine
from verne_post.config.sinumerik import convert_sinumerik, is_machine_data
from verne_post.model.findings import InputError

LENGTH = 62.5
#: By what turns: letters of both axes, MD24100, vectors I1 to I4, V1 and V2.
CASES: dict[str, dict[str, Any]] = {
    "T": {"letters": "CB", "type": 24, "I1": (0, -12, -330), "I2": (-40, 12, 130), "I3": (40, 0, 200), "V1": (0, 0, 1),
          "V2": (0, 1, 0)},
    "P": {"letters": "AC", "type": 40, "I2": (310, 220, -420), "I3": (1.5, -0.3, 52), "I4": (-311.5, -219.7, 368),
          "V1": (-1, 0, 0), "V2": (0, 0, -1)},
    "M": {"letters": "BC", "type": 56, "I1": (-35, 0, -220), "I2": (35, 0, 220), "I3": (410, 150, -500),
          "I4": (-410, -150, 500), "V1": (0, 1, 0), "V2": (0, 0, -1)},
}  # fmt: skip
#: Names of the vectors in TRAORI, by the commissioning manual.
NAMES = {
    "T": {"I1": "PART_OFFSET", "I2": "JOINT_OFFSET", "I3": "BASE_TOOL"},
    "P": {"I2": "BASE_TOOL", "I3": "JOINT_OFFSET_PART", "I4": "PART_OFFSET"},
    "M": {"I1": "JOINT_OFFSET", "I2": "BASE_TOOL", "I3": "JOINT_OFFSET_PART", "I4": "PART_OFFSET"},
}
FIRST = {"I1": 1, "I2": 4, "V1": 7, "V2": 10, "I3": 15, "I4": 18}


def write_axes(letters: str) -> list[str]:
    """Names, limits and speeds of five axes; the machine axes stand in another order than those of the channel."""
    lines = ["N10050 $MN_SYSCLOCK_CYCLE_TIME=0.001", "N10070 $MN_IPO_SYSCLOCK_TIME_RATIO=4"]
    for k, letter in enumerate("XYZ" + letters):
        machine = (3, 1, 2, 5, 4)[k]
        rotary = k > 2
        lines += [
            f'N10000 $MN_AXCONF_MACHAX_NAME_TAB[{machine - 1}]="{letter}1" \'4a1',
            f'N20080 $MC_AXCONF_CHANAX_NAME_TAB[{k}]="{letter}"',
            f"N20070 $MC_AXCONF_MACHAX_USED[{k}]={machine}",
            f"N30300 $MA_IS_ROT_AX[AX{machine}]={'TRUE' if rotary else 0}",
            f"N32000 $MA_MAX_AX_VELO[AX{machine}]={20 + k if rotary else 30000 + k}",
            f"N32300 $MA_MAX_AX_ACCEL[0,{letter}1]={1.5 if rotary else 4 + k} ; of DYNNORM",
            f"N36100 $MA_POS_LIMIT_MINUS[AX{machine}]={-100 - k}",
            f"N36110 $MA_POS_LIMIT_PLUS[AX{machine}]={110 + k}",
        ]
    return lines


def write_data(kind: str, *, carrier: bool = False, slot: int = 1) -> str:
    case = CASES[kind]
    lines = ["%_N_INITIAL_INI", "CHANDATA(1)", *write_axes(case["letters"])]
    if carrier:
        for key in ("I1", "I2", "I3", "I4", "V1", "V2"):
            lines += [f"$TC_CARR{FIRST[key] + k}[1]={value}" for k, value in enumerate(case.get(key, (0, 0, 0)))]
        lines += [f'$TC_CARR{21 + k}[1]="{letter}"' for k, letter in enumerate(case["letters"])]
        lines.append(f'$TC_CARR23[1]="{kind}"')
    else:
        lines.append(f"N24100 $MC_TRAFO_TYPE_{slot}={case['type']}")
        lines += [f"N24110 $MC_TRAFO_AXES_IN_{slot}[{k}]={k + 1}" for k in range(5)]
        for key, name in NAMES[kind].items():
            lines += [f"$MC_TRAFO5_{name}_1[{k}]={value}" for k, value in enumerate(case[key])]
        for number in (1, 2):
            lines += [f"$MC_TRAFO5_AXIS{number}_1[{k}]={value}" for k, value in enumerate(case[f"V{number}"])]
    return "\n".join([*lines, "M17", ""])


def convert(text: str) -> tuple[Any, Any]:
    made = convert_sinumerik(text.encode(), "m.ini")
    return build_machine(made.text.encode(), "m.toml"), made


def find_tip(kind: str, linear: np.ndarray, first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tip and tool axis in the part by the vectors of the tool carrier, machine zero where both are at rest."""
    case = {key: np.array(value, dtype=float) for key, value in CASES[kind].items() if key[0] in "IV"}
    turn_one, turn_two = (
        Rotation.from_rotvec(np.outer(np.radians(angle), case[key])) for key, angle in (("V1", first), ("V2", second))
    )
    up = np.array([0.0, 0.0, LENGTH])
    if kind == "T":  # adapter and tool hang on axis 2, which hangs on axis 1
        return linear + case["I2"] + case["I3"] - turn_one.apply(
            case["I2"] + turn_two.apply(case["I3"] + up)
        ), turn_one.apply(turn_two.apply(up / LENGTH))
    if kind == "P":  # the part point that the table has carried to the tip
        tip = linear - up
        back = turn_two.inv().apply(turn_one.inv().apply(tip - case["I2"]) - case["I3"])
        return back + case["I2"] + case["I3"], turn_two.inv().apply(
            turn_one.inv().apply(np.tile(up / LENGTH, (len(tip), 1)))
        )
    tip = linear + case["I2"] - turn_one.apply(case["I2"] + up)
    return turn_two.inv().apply(tip - case["I3"]) + case["I3"], turn_two.inv().apply(turn_one.apply(up / LENGTH))


@pytest.mark.parametrize("kind", CASES)
@pytest.mark.parametrize("carrier", [False, True])
def test_tips_are_those_of_the_vectors(kind: str, carrier: bool) -> None:
    machine, made = convert(write_data(kind, carrier=carrier))
    random = np.random.default_rng(24)
    linear, first, second = (
        random.uniform(-90, 90, (300, 3)),
        random.uniform(-95, 95, 300),
        random.uniform(-95, 95, 300),
    )
    letters = CASES[kind]["letters"].lower()
    values = dict(zip(("x", "y", "z", *letters), (*linear.T, first, second), strict=True))
    joints = np.column_stack([values[column.joint] / column.factor for column in machine.columns])
    tip, axis, ok = machine.forward(joints, LENGTH)
    wanted, leans = find_tip(kind, linear, first, second)
    assert ok.all()
    assert np.abs(tip - wanted).max() < 1e-9
    assert np.abs(axis - leans).max() < 1e-12
    assert not any("does not close" in item.message for item in made.findings)


def test_limits_speeds_and_the_cycle() -> None:
    """mm/min and m/s2, turns per minute and per s2; the machine axis of each is that of the channel's table."""
    machine, made = convert(write_data("P"))
    by_name = {column.joint: k for k, column in enumerate(machine.columns)}
    factor = np.array([column.factor for column in machine.columns])
    for k, letter in enumerate("xyzac"):
        at = by_name[letter]
        low, high = sorted((machine.limits.lower[at] * factor[at], machine.limits.upper[at] * factor[at]))
        assert (low, high) == pytest.approx((-100 - k, 110 + k))
        velocity, acceleration = ((20 + k) * 6.0, 1.5 * 360.0) if k > 2 else ((30000 + k) / 60.0, 1000.0 * (4 + k))
        assert machine.limits.velocity[at] * abs(factor[at]) == pytest.approx(velocity)
        assert machine.limits.acceleration[at] * abs(factor[at]) == pytest.approx(acceleration)
    assert machine.cycle == pytest.approx(0.004)
    assert any("no $MA_MAX_AX_JERK" in item.message for item in made.findings)
    endless, _made = convert(write_data("P") + "$MA_ROT_IS_MODULO[C1]=1\n")
    assert np.isinf(endless.limits.upper[-1])


def test_type_72_takes_the_tool_carrier_and_the_second_slot_and_channel_are_found() -> None:
    text = write_data("T", carrier=True) + "N24200 $MC_TRAFO_TYPE_2=72\n$MC_TRAFO5_TCARR_NO_1=1\n"
    text += "".join(f"$MC_TRAFO_AXES_IN_2[{k}]={k + 1}\n" for k in range(5)) + "$MC_TRAFO_TYPE_1=256\n"
    machine, made = convert(text.replace("CHANDATA(1)", "CHANDATA(2)"))
    assert "tool carrier 1" in machine.name
    assert [column.joint for column in machine.columns] == ["x", "y", "z", "b", "c"]
    assert made.text == convert(text)[1].text


def test_what_is_left_out_is_said() -> None:
    _machine, made = convert(write_data("P").replace("TRAFO5_PART_OFFSET_1[2]=368", "TRAFO5_PART_OFFSET_1[2]=368.25"))
    said = " ".join(item.message for item in made.findings)
    assert "I2 + I3 + I4 = [0.0, 0.0, 0.25]: the chain does not close" in said
    _machine, made = convert(write_data("T", carrier=True) + "$TC_CARR43[1]=0.01\n")
    assert any("fine offsets are left out" in item.message for item in made.findings)


@pytest.mark.parametrize(
    ("kind", "old", "new", "code", "why"),
    [
        ("P", "TRAFO_TYPE_1=40", "TRAFO_TYPE_1=33", "VP508", "names its axes by letters, without their directions"),
        ("P", "TRAFO_TYPE_1=40", "TRAFO_TYPE_1=256", "VP508", "neither a transformation of five axes"),
        ("P", "TRAFO_TYPE_1=40", "TRAFO_TYPE_1=72", "VP507", "TRAFO5_TCARR_NO_1 is missing"),
        ("P", "TRAFO_TYPE_1=40", "TRAFO_TYPE_1=forty", "VP507",
         "m.ini:45: $MC_TRAFO_TYPE_1 = 'forty': expected a number"),
        ("P", "M17", "$MC_TRAFO5_ROT_AX_OFFSET_1[1]=90", "VP508",
         "rotary axes that are not at 0 where the vectors hold"),
        ("P", "M17", "$MC_TRAFO5_ROT_SIGN_IS_PLUS_1[0]=FALSE", "VP508", "reverse $MC_TRAFO5_AXIS1_1 in its place"),
        ("P", "M17", "$MC_TRAFO5_BASE_ORIENT_1[1]=1", "VP508", "is not along +z"),
        ("P", "M17", "$MN_SCALING_SYSTEM_IS_METRIC=0", "VP508", "data in inches are not imported"),
        ("P", "TRAFO5_AXIS2_1[2]=-1", "TRAFO5_AXIS2_1[2]=0", "VP507", "$MC_TRAFO5_AXIS2_1: no direction"),
        ("P", '[4]="C"', '[4]="C2"', "VP508", "= 'C2': expected A or B or C"),
        ("P", "[4]=4", "[4]=0", "VP507", "names no machine axis for C"),
        ("P", "$MA_MAX_AX_VELO[AX3]=30000", "", "VP507", "$MA_MAX_AX_VELO of X is missing"),
        ("P", "$MA_POS_LIMIT_PLUS[AX3]=110", "", "VP507", "of X do not bound its travel"),
        ("P", "$MA_POS_LIMIT_PLUS[AX4]=114", "", "VP507", "of C do not bound it, and $MA_ROT_IS_MODULO is not TRUE"),
        ("P", "$MA_IS_ROT_AX[AX4]=TRUE", "", "VP507", "$MA_IS_ROT_AX of C is not TRUE"),
        ("P", "TRAFO_AXES_IN_1[4]=5", "TRAFO_AXES_IN_1[4]=0", "VP507", "expected the numbers of five axes"),
    ],
)  # fmt: skip
def test_refused(kind: str, old: str, new: str, code: str, why: str) -> None:
    text = write_data(kind)
    assert old in text
    with pytest.raises(InputError) as refused:
        convert(text.replace(old, new, 1))
    (item,) = refused.value.findings
    place = f"{item.file}:{item.file_line}: " if item.file else ""
    assert (item.code, why in place + item.message) == (code, True), item.message


@pytest.mark.parametrize(
    ("old", "new", "code", "why"),
    [
        ('$TC_CARR23[1]="M"', '$TC_CARR23[1]="X"', "VP508", "expected T, P or M"),
        ('$TC_CARR22[1]="C"', '$TC_CARR22[1]="W"', "VP507", "names no axis W"),
        ("M17", '$TC_CARR23[2]="T"', "VP508", "the tool carriers 1, 2"),
        ("M17", "$TC_CARR25[1]=5", "VP508", "$TC_CARR25[1] is not 0"),
    ],
)
def test_refused_carriers(old: str, new: str, code: str, why: str) -> None:
    with pytest.raises(InputError) as refused:
        convert(write_data("M", carrier=True).replace(old, new, 1))
    (item,) = refused.value.findings
    place = f"{item.file}:{item.file_line}: " if item.file else ""
    assert (item.code, why in place + item.message) == (code, True), item.message


def test_a_pair_that_no_machine_file_holds_is_refused(run: Callable[..., Any], tmp_path: Path) -> None:
    """Axes that are parallel, and those that look measured: by the sentence of the machine file."""
    source = tmp_path / "m.ini"
    source.write_text(write_data("P").replace("TRAFO5_AXIS2_1[0]=0", "TRAFO5_AXIS2_1[0]=-0.002"), encoding="utf-8")
    answer = run("machine", "import", source, "-o", tmp_path / "m.toml")
    assert answer.code != 0
    assert "give them as drawn, not as measured" in answer.out + answer.err
    assert not (tmp_path / "m.toml").exists()


def test_the_command_knows_machine_data_from_an_ini_of_linuxcnc(run: Callable[..., Any], tmp_path: Path) -> None:
    source, made = tmp_path / "m.arc", tmp_path / "m.toml"
    source.write_text(write_data("P"), encoding="utf-8")
    answer = run("machine", "import", source, "-o", made)
    assert answer.code == 0, answer.err
    assert "A +10: the tool leans" in answer.out
    assert "VP509 warning" in answer.err
    assert run("machine", "validate", made).code == 0
    assert not is_machine_data(b"[KINS]\nKINEMATICS = xyzac-trt-kins\n")
