"""Rotary pairs on and under a carrier of three sliders that never turns: reference values, a judge of its own, and
refusals.
"""

import json
import tomllib

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import verne_post
from tests.kinematics.test_chain import LIMITS, ROOT, both_solutions, in_file_units, random_axes
from verne_post.config.load import build_machine
from verne_post.model.findings import InputError

TEXT = (ROOT / "machine_configs/george_v.toml").read_text(encoding="utf-8")
LENGTH = 80.0


def describe_urane() -> str:
    """The rails and rods of the shipped Urane-SX-like machine over another table, A that carries B: that of the
    reference values.
    """
    module = tomllib.loads((ROOT / "machine_configs/urane_sx.toml").read_text(encoding="utf-8"))["module"]
    rods = ", ".join(
        f"{{platform = {one['platform']}, slider = {one['slider']}, rail = {one['rail']}, rod = {one['length']}, by = "
        f"'{one['by'].replace('rho', 'q')}'}}"
        for one in module["rod"]
    )
    text = (
        "schema = 2\n"
        'name = "urane"\n'
        "[chain]\n"
        'tool = ["carrier"]\n'
        "part = "
        '["a", "b"]\n'
        "up = [0, 0, -1]\n"
        "axis = [0, 0, -1]\n"
    )
    text += "gauge = [0, 0, 1050]\npart_zero = [0, 0, 1600]\n[carrier]\nkind = 'rods'\nactuators = ['q1', 'q2', 'q3']\n"
    text += (
        "home = [0, 0, 900]\n"
        "home_actuators_mm = [300, 300, 300]\n"
        f"rods = [{rods}]\n"
        "smallest_singular_value = 0.05\n"
        "smallest_drop_mm = 100\n"
    )
    text += "".join(f"[joints.q{k}]\ntravel_mm = [-200, 800]\n{LIMITS}" for k in (1, 2, 3))
    text += f"[joints.a]\nturns = [1, 0, 0]\nthrough = [0, -10, 1650]\ntravel_deg = [-110, 110]\n{LIMITS}"
    text += f"[joints.b]\nturns = [0, 1, 0]\nthrough = [0, 0, 1620]\n{LIMITS}"
    text += "[control]\ncycle_s = 0.001\n[provenance]\n"
    return text + "".join(f"{group} = 'assumed'\n" for group in ("chain", "carrier", "joints", "control"))


def test_reference_values_over_a_table() -> None:
    """Both solutions of 30 poses, 40 digits, found by equations that share nothing with the package."""
    machine = build_machine(describe_urane().encode(), "urane.toml")
    rows = [json.loads(line) for line in (ROOT / "tests/reference/rods.jsonl").read_text().splitlines()[1:]]
    rows = [row for row in rows if row["machine"] == "urane_sx"]
    assert len(rows) == 30
    for row in rows:
        tip, axis, length = np.array(row["tip_mm"]), np.array(row["axis"]), row["tool_length_mm"]
        found = [in_file_units(machine, q) for q in both_solutions(machine, tip, axis, length)]
        assert len(found) == len(row["solutions"])
        for solution in row["solutions"]:
            wanted = np.array([solution["joints"][column.joint] for column in machine.columns])
            away = [np.append(q[:3] - wanted[:3], (q[3:] - wanted[3:] + 180.0) % 360.0 - 180.0) for q in found]
            assert min(np.abs(one).max() for one in away) < 1e-8  # places of the file have nine decimals


def judge(
    values: np.ndarray, place: np.ndarray, length: float, text: str = TEXT
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Misfits of the six rods (n, 6), tip and tool axis (n, 3) in the part frame, of joints of the file (n, 5) and P
    (n, 3).
    """
    data = tomllib.loads(text)
    carrier, joints, chain = data["carrier"], data["joints"], data["chain"]
    misfit = []
    for rod in carrier["rods"]:
        rho = values[:, carrier["actuators"].index(rod["by"]), None]
        vector = place + rod["platform"] - rod["slider"] - rho * rod["rail"]
        misfit.append(np.linalg.norm(vector, axis=1) - rod["rod"])

    def carry(point: np.ndarray) -> np.ndarray:
        for name, degrees in (("a", values[:, 3]), ("c", values[:, 4])):
            through = np.array(joints[name]["through"])
            point = (
                Rotation.from_rotvec(np.outer(np.radians(degrees), joints[name]["turns"])).apply(point - through)
                + through
            )
        return point - carrier["home"] + place

    gauge, axis = np.array(chain["gauge"]), np.array(chain["axis"])
    tip, top = (carry(np.tile(gauge - along * axis, (len(values), 1))) for along in (length, 0.0))
    up = np.diag([1.0, -1.0, -1.0])
    return np.stack(misfit, axis=1), (tip - chain["part_zero"]) @ up, (top - tip) @ up / length


def test_inverse_and_forward_by_the_judge() -> None:
    machine = verne_post.load_machine("george_v")
    random = np.random.default_rng(5)
    axis = random_axes(2000)
    axis = axis[axis[:, 2] > 0.3][:500]
    tip = random.uniform([-200, -200, 0], [200, 200, 150], axis.shape)
    q, ok = machine.inverse(tip, axis, LENGTH)
    assert ok.all()
    place = machine.five_axis._find_position(q)
    misfit, there, leans = judge(in_file_units(machine, q), place, LENGTH)
    assert np.abs(misfit).max() < 1e-6  # rails of the file have nine digits
    assert np.abs(there - tip).max() < 1e-6
    assert np.abs(leans - axis).max() < 1e-12
    back, turned, closed = machine.forward(q, LENGTH)
    assert closed.all()
    assert np.abs(back - tip).max() < 1e-8
    assert np.abs(turned - axis).max() < 1e-12


NUTATING = TEXT.replace("turns = [1.0, 0.0, 0.0]", "turns = [-0.766044443118978, 0.0, -0.6427876096865393]").replace(
    "[-110.0, 110.0]", "[-180.0, 180.0]"
)


def test_a_nutating_wrist_goes_by_its_joints() -> None:
    """A at 50 degrees to C and to the tool: places of a program by the judge, half way with half of the words, and the
    fold as a margin.
    """
    machine = build_machine(NUTATING.encode(), "mine.toml")
    text = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG1 X40 Y20 A60 C50 F3000\nG1 X0 Y-30 A-80 C-20\nM2\n"
    result = verne_post.convert(text, machine, verne_post.Options(tool_length=LENGTH, wcs={"G54": (0.0, 0.0, 0.0)}))
    assert result.ok, result.findings
    rows, line = np.asarray(result.setpoints.values), np.asarray(result.setpoints.line)
    place = machine.five_axis._find_position(rows[:, :3])
    misfit, tip, _axis = judge(rows, place, LENGTH, NUTATING)
    assert np.abs(misfit).max() < 1e-5
    assert np.abs(tip[0] - [0, 0, 50]).max() < 1e-4
    assert np.abs(tip[-1] - [0, -30, 50]).max() < 1e-4
    on = np.flatnonzero(line == 3)
    middle = on[np.argmin(np.abs(tip[on, 0] - 20.0))]
    step = np.abs(np.diff(rows[on, 3])).max()
    assert abs(rows[middle, 3] - 30.0) < step
    assert abs(rows[middle, 4] - 25.0) < step
    assert "distance from the fold" in [margin.name for margin in machine.margins]
    assert machine.five_axis.find_geometry_margins(
        rows[:3] / [1, 1, 1, 57.3, 57.3], np.zeros((3, 2)), machine.five_axis.find_platform(rows[:3])[0]
    ).shape == (3, len(machine.margins))


@pytest.mark.parametrize("text", [TEXT, describe_urane(), NUTATING], ids=["on", "under", "nutating"])
def test_jacobian_is_the_derivative(text: str) -> None:
    machine = build_machine(text.encode(), "mine.toml")
    random = np.random.default_rng(3)
    tip = random.uniform([-100, -100, 0], [100, 100, 100], (50, 3))
    angles = random.uniform([0.1, -3], [0.8, 3], (50, 2)) * random.choice([[1, 1], [-1, 1]], 50)
    rates = machine.five_axis.find_jacobian(tip, angles, LENGTH)
    for k, step in enumerate([1e-3, 1e-3, 1e-3, 1e-5, 1e-5]):
        move = step * np.eye(5)[k]
        ends = [machine.five_axis.find_joints(tip + s * move[:3], angles + s * move[3:], LENGTH) for s in (1, -1)]
        assert np.allclose(rates[..., k], (ends[0] - ends[1]) / (2 * step), rtol=1e-6, atol=1e-5)


def test_margins_are_those_of_the_rods() -> None:
    """Drop along the rails, Jacobian and cones by the file; at home cones are full, out of reach the code says why."""
    machine = verne_post.load_machine("george_v")
    own, carrier = machine.five_axis, tomllib.loads(TEXT)["carrier"]
    tip, angles = np.array([[0.0, 0.0, 120.0], [150.0, -60.0, 60.0]]), np.array([[0.0, 0.0], [0.5, 1.0]])
    q, platform, ok = own.solve(tip, angles, LENGTH)
    assert ok.all()
    margins, names = own.find_geometry_margins(q, angles, platform), [margin.name for margin in machine.margins]
    place = own._find_position(q)
    first = np.array(carrier["home"])
    for k in (0, 2, 4):
        rod = carrier["rods"][k]
        at = [
            p + rod["platform"] - rod["slider"] - rho * np.array(rod["rail"])
            for p, rho in zip(place, q[:, k // 2], strict=True)
        ]
        drop = margins[:, names.index(f"drop of rod {k + 1} along its rail")]
        assert np.abs(np.abs(at @ np.array(rod["rail"])) - drop).max() < 1e-6
        home = first + rod["platform"] - rod["slider"] - own.home[k // 2] * np.array(rod["rail"])
        turned = np.degrees(np.arccos(np.clip(at @ home / rod["rod"] ** 2, -1, 1)))
        cone = margins[:, names.index(f"angle left to the joints of rod {k + 1}")]
        assert np.abs(50.0 - turned - cone).max() < 1e-3
    assert own.explain_unreachable(np.array([[3e3, 0.0, 0.0]]), np.zeros((1, 2)), LENGTH) == ["VP110"]


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('tool = ["carrier", "c", "a"]', 'tool = ["c", "a"]', "expected 'carrier' first in tool"),
        ("home_actuators_mm", "central = {base = [0, 0, 0], first_axis = [1, 0, 0]}\nhome_actuators_mm",
         "too many: central"),
        ("smallest_drop_mm = 100.0", "", "missing: smallest_drop_mm"),
        ("rail = [0, -0.5, 0.866025404], rod = 750", "rail = [0, 0, 0], rod = 750", "expected a direction"),
        ("rod = 750", "rod = 760", "carrier.rods, value 1 and value 2: these two rods of q1 do not fit each other"),
        ("slider = [-100, 700, 0]", "slider = [-90, 700, 0]", ""),
        ('by = "q3"', 'by = "q2"', ""),
        ("travel_mm = [-200.0, 750.0]", "slides = [0, 0, 1]\ntravel_mm = [-200.0, 750.0]",
         "a slider is its place on the rails"),
    ],
)  # fmt: skip
def test_refused_on_loading(old: str, new: str, why: str) -> None:
    text = TEXT.replace(old, new, 1)
    assert text != TEXT
    with pytest.raises(InputError) as refused:
        build_machine(text.encode(), "mine.toml")
    assert why in " ".join(item.message for item in refused.value.findings)
