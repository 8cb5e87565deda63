"""Six legs that hold the spindle alone: a judge of its own, the free turn, continuity from home, singularities, and
refusals.

The reference values of ``hexapod`` stand in tests/reference/chains.jsonl and are tested with those of the chains.
"""

import tomllib
from typing import Any

import numpy as np
import pytest
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

import verne_post
from tests.kinematics.test_carrier_descriptions import build, find_part_frame, read, turned
from tests.kinematics.test_chain import ROOT, random_axes
from verne_post.config.load import build_machine
from verne_post.kinematics.modules.six_legs import SixLegs
from verne_post.model.findings import InputError

LENGTH = 90.0
NAMES = ["hexapod", "hexam", "hexaglide"]
#: Range of poses of the part (mm), and the smallest z of the tool axis, that each reaches.
REACH = {"hexapod": (150.0, 0.85), "hexam": (150.0, 0.85), "hexaglide": (100.0, 0.93)}
#: Six sliders on parallel rails, symmetric in every way: all legs close, and the platform is free to move at home.
SINGULAR = {
    "platform": [[-120, -180, 0], [120, -180, 0], [-200, 0, 0], [200, 0, 0], [-120, 180, 0], [120, 180, 0]],
    "slider": [[0, -350, 0], [0, -350, 0], [0, 0, 0], [0, 0, 0], [0, 350, 0], [0, 350, 0]],
}


def list_ends(values: np.ndarray, place: np.ndarray, turn: Rotation, data: dict[str, Any]) -> list[Any]:
    """Ends (n, 3) of the legs at base and platform, in the order of the actuators (n, 6)."""
    carrier, ends = data["carrier"], []
    for k, name in enumerate(carrier["actuators"]):
        if "struts" in carrier:
            (leg,) = [one for one in carrier["struts"] if one["length"] == name]
            foot = np.array(leg["base"])
        else:
            (leg,) = [one for one in carrier["rods"] if one["by"] == name]
            rail = np.array(leg["rail"]) / np.linalg.norm(leg["rail"])
            foot = np.array(leg["slider"]) + values[:, k, None] * rail
        ends.append((foot, turn.apply(leg["platform"]) + place))
    return ends


def judge(values: np.ndarray, place: np.ndarray, turn: Rotation, data: dict[str, Any]) -> Any:
    """Misfits of the legs (n, 6), tip and tool axis (n, 3) in the part frame, of actuators (n, 6), P (n, 3) and the
    platform's turn.
    """
    carrier, chain = data["carrier"], data["chain"]
    ends = [np.linalg.norm(top - foot, axis=1) for foot, top in list_ends(values, place, turn, data)]
    if "struts" in carrier:
        misfit = [length - value for length, value in zip(ends, values.T, strict=True)]
    else:
        rods = {one["by"]: one["rod"] for one in carrier["rods"]}
        misfit = [length - rods[name] for length, name in zip(ends, carrier["actuators"], strict=True)]
    up = np.diag([1.0, -1.0, -1.0])  # z of the part is -z of the base, x is x
    away = np.array(chain["gauge"]) - carrier["home"]
    top = turn.apply(away) + place
    tip = turn.apply(away - LENGTH * np.array(chain["axis"])) + place
    return np.stack(misfit, axis=1), (tip - chain["part_zero"]) @ up, (top - tip) @ up / LENGTH


def draw_poses(name: str, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Tips and tool axes (n, 3), most of them leaned."""
    wide, upright = REACH[name]
    axis = random_axes(60 * n)
    axis = axis[axis[:, 2] > upright][:n]
    assert len(axis) == n
    return np.random.default_rng(n).uniform([-wide, -wide, 0], [wide, wide, 80], axis.shape), axis


@pytest.mark.parametrize("name", NAMES)
def test_inverse_and_forward_by_the_judge(name: str) -> None:
    """Legs, tip and axis of 1000 poses close by scipy's rotations from the file; forward comes back; home leads to
    every pose.
    """
    machine, data = verne_post.load_machine(name), read(name)
    tip, axis = draw_poses(name, 1000)
    q, ok = machine.inverse(tip, axis, LENGTH)
    assert ok.all()
    place, turn, closed = machine.five_axis.legs.forward(q[:, :6])
    assert closed.all()
    misfit, there, leans = judge(q[:, :6], place, Rotation.from_matrix(turn), data)
    assert np.abs(misfit).max() < 1e-9
    feet, tops = machine.five_axis.legs.find_legs(place, turn, q[:, :6])
    for k, (foot, top) in enumerate(list_ends(q[:, :6], place, Rotation.from_matrix(turn), data)):
        assert max(np.abs(feet[:, k] - foot).max(), np.abs(tops[:, k] - top).max()) < 1e-9
    assert np.abs(there - tip).max() < 1e-9
    assert np.abs(leans - axis).max() < 1e-12
    back, points, reached = machine.forward(q, LENGTH)
    assert reached.all()
    assert max(np.abs(back - tip).max(), 100.0 * np.abs(points - axis).max()) < 1e-9
    # the platform turns about an axis across both tool axes: no turn about the tool is left
    spin = Rotation.from_matrix(turn).as_rotvec()
    assert np.abs(spin[:, 2]).max() < 1e-12
    # continuity: the actuators led from home in 32 steps, each solved by scipy from the one before
    home = machine.five_axis.home[:6]
    for row in range(4):
        at = np.append(np.array(data["carrier"]["home"]), np.zeros(3))
        for share in np.arange(1, 33) / 32:
            now = (home + share * (q[row, :6] - home))[None]
            at = fsolve(
                lambda p, now=now: judge(now, p[None, :3], Rotation.from_rotvec(p[None, 3:]), data)[0][0],
                at,
                xtol=1e-13,
            )
        assert np.abs(at[:3] - place[row]).max() < 1e-6
        assert np.abs(at[3:] - spin[row]).max() < 1e-8


@pytest.mark.parametrize("name", NAMES)
def test_jacobian_is_the_derivative(name: str) -> None:
    machine, random = verne_post.load_machine(name), np.random.default_rng(3)
    wide = REACH[name][0]
    tip = random.uniform([-wide, -wide, 0], [wide, wide, 80], (50, 3))
    angles = np.column_stack([random.uniform(0.05, 0.25, 50) * random.choice([-1, 1], 50), random.uniform(-3, 3, 50)])
    rates = machine.five_axis.find_jacobian(tip, angles, LENGTH)
    assert np.isfinite(rates).all()
    for k, step in enumerate([1e-3, 1e-3, 1e-3, 1e-5, 1e-5]):
        move = step * np.eye(5)[k]
        ends = [machine.five_axis.find_joints(tip + s * move[:3], angles + s * move[3:], LENGTH) for s in (1, -1)]
        assert np.allclose(rates[..., k], (ends[0] - ends[1]) / (2 * step), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_directions_of_the_base_and_order_of_legs_do_not_matter(name: str) -> None:
    tip, axis = draw_poses(name, 50)
    data = read(name)
    joints, ok = build(data).inverse(tip, axis, LENGTH)
    assert ok.all()
    data.pop("home")
    del data["provenance"]["home"]
    for by in ([0.0, 0.0, 0.7], [0.3, -0.2, 0.7]):
        turn = Rotation.from_rotvec(by).as_matrix()
        other = turned(data, turn)
        to_other = find_part_frame(other).T @ turn @ find_part_frame(data)
        again, found = build(other).inverse(tip @ to_other.T, axis @ to_other.T, LENGTH)
        assert found.all()
        assert np.abs(joints[:, :6] - again[:, :6]).max() < 1e-6  # files give nine digits
    key = "struts" if "struts" in data["carrier"] else "rods"
    data["carrier"]["actuators"].reverse()
    data["carrier"][key].reverse()
    if "home_actuators_mm" in data["carrier"]:
        data["carrier"]["home_actuators_mm"].reverse()
    assert np.abs(build(data).inverse(tip, axis, LENGTH)[0][:, 5::-1] - joints[:, :6]).max() < 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_words_are_those_of_a_head(name: str) -> None:
    """A 20 C 30 on the part: the axis that a fork head C A has there; with words = "BC" B leans it towards +x."""
    machine = verne_post.load_machine(name)
    angles = machine.coordinates.map_to_table(
        np.array([0, 0, 0, 20.0, 0, 30.0, 0, 0, 0]), verne_post.model.moves.Frame()
    )[1]
    axis = machine.forward(machine.five_axis.find_joints(np.zeros(3), angles, LENGTH), LENGTH)[1]
    expected = Rotation.from_euler("ZX", [30.0, 20.0], degrees=True).apply([0.0, 0.0, 1.0])
    assert np.abs(axis - expected).max() < 1e-12
    data = read(name)
    data["chain"]["words"] = "BC"
    other = build(data)
    assert [column.joint for column in other.columns[-2:]] == ["b", "c"]
    angles = other.coordinates.map_to_table(
        np.array([0, 0, 0, 0, 20.0, 30.0, 0, 0, 0]), verne_post.model.moves.Frame()
    )[1]
    axis = other.forward(other.five_axis.find_joints(np.zeros(3), angles, LENGTH), LENGTH)[1]
    assert np.abs(axis - Rotation.from_euler("ZY", [30.0, 20.0], degrees=True).apply([0.0, 0.0, 1.0])).max() < 1e-12


def test_the_spare_turn_is_about_the_tool() -> None:
    """At 80 degrees of it the symmetric hexapod is nearly singular, at 90 it is: refused on the way there by the bound
    on turn.
    """
    tip, axis = draw_poses("hexapod", 20)
    measures = []
    for degrees in (0.0, 20.0, 50.0, 80.0, 89.0):
        data = read("hexapod")
        data["carrier"] |= {"spare_turn_deg": degrees, "largest_turn_deg": 89.9}
        machine = build(data)
        q, ok = machine.inverse(np.zeros(3), np.array([0.0, 0.0, 1.0]), LENGTH)
        assert ok
        _place, turn, _ok = machine.five_axis.legs.forward(q[:6])
        # about the tool axis, which points up at home, -z of the base
        assert np.degrees(Rotation.from_matrix(turn).as_rotvec()) == pytest.approx([0.0, 0.0, -degrees], abs=1e-9)
        platform, _ok = machine.five_axis.find_platform(q)
        measures.append(float(machine.five_axis.find_geometry_margins(q, np.zeros(2), platform)[0]))
        if degrees == 20.0:
            joints, ok = machine.inverse(tip, axis, LENGTH)
            back, points, _ok = machine.forward(joints[ok], LENGTH)
            assert ok.sum() > 10
            assert max(np.abs(back - tip[ok]).max(), np.abs(points - axis[ok]).max()) < 1e-9
    assert (np.diff(measures) < 0).all()
    assert measures[-1] < 0.05 * measures[0]


def test_the_margin_passes_through_zero_at_the_singularity() -> None:
    """Turned by 90 degrees about z the legs of the symmetric hexapod hold it no more; beyond, the sign is
    another one.
    """
    legs = verne_post.load_machine("hexapod").five_axis.legs
    turns = Rotation.from_rotvec(np.radians([[0, 0, d] for d in (0.0, 80.0, 89.0, 90.0, 91.0, 100.0)])).as_matrix()
    place = np.tile(np.array(legs.home, dtype=float), (len(turns), 1))
    measure = legs.measure(place, turns)
    assert (measure[:3] > 0).all()
    assert abs(measure[3]) < 1e-12
    assert (measure[4:] < 0).all()
    # the smallest singular value of the design note for this hexapod: 0.56 at 0, 0.115 at 80, 0.011 at 89 degrees
    smallest = np.linalg.svd(legs._scale_jacobian(place, turns), compute_uv=False)[:, -1]
    assert smallest[:3] == pytest.approx([0.56, 0.115, 0.011], abs=0.006)
    assert (measure[:3] <= smallest[:3]).all()
    assert (measure[:3] >= smallest[:3] / np.sqrt(6)).all()


def test_the_singular_hexaglide_is_refused_as_singular() -> None:
    with pytest.raises(
        ValueError, match="at home the legs leave the platform free to move: their Jacobian is singular"
    ):
        SixLegs(
            [0.0, 0.0, 500.0],
            SINGULAR["platform"],
            SINGULAR["slider"],
            60.0,
            [[1.0, 0.0, 0.0]] * 6,
            [700.0] * 6,
            [-600.0, 600.0] * 3,
        )
    names = [f"q{k}" for k in range(1, 7)]
    data = read("hexapod")
    data["carrier"] = {
        "kind": "rods",
        "actuators": names,
        "home": [0.0, 0.0, 500.0],
        "home_actuators_mm": [-600.0, 600.0] * 3,
        "rods": [
            {
                "platform": [float(v) for v in end],
                "slider": [float(v) for v in foot],
                "rail": [1.0, 0.0, 0.0],
                "rod": 700.0,
                "by": name,
            }
            for end, foot, name in zip(SINGULAR["platform"], SINGULAR["slider"], names, strict=True)
        ],
        "rod_diameter_mm": 40.0,
        "smallest_singular_value": 0.05,
        "smallest_drop_mm": 50.0,
    }
    data["joints"] = {name: {**data["joints"]["l1"], "travel_mm": [-1500.0, 1500.0]} for name in names}
    with pytest.raises(InputError) as refused:
        build(data)
    assert "their Jacobian is singular" in refused.value.findings[0].message


def test_legs_that_meet_are_measured() -> None:
    """Two struts that cross beside each other: the distance of the segments less the diameter, and negative where they
    meet.
    """
    data = read("hexapod")
    data["carrier"]["rod_diameter_mm"] = 130.0
    machine = build(data)
    q, platform, ok = machine.five_axis.solve(np.zeros((1, 3)), np.zeros((1, 2)), LENGTH)
    assert ok.all()
    from verne_post.model.poses import Pose  # as the checks do

    pose = Pose(q, platform, np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.array([LENGTH]))
    assert machine.clearance is not None
    margins, _points = machine.clearance.evaluate(pose)
    place, turn, _ok = machine.five_axis.legs.forward(q[:, :6])
    ends = {
        one["length"]: (turn[0] @ one["platform"] + place[0], np.array(one["base"]))
        for one in data["carrier"]["struts"]
    }
    share = np.linspace(0, 1, 401)
    for name, value in zip([margin.name for margin in machine.clearance.names], margins[0], strict=True):
        first, second = name.removeprefix("distance of the rods of legs ").split(" and ")
        lines = [foot + share[:, None] * (end - foot) for end, foot in (ends[first], ends[second])]
        least = np.linalg.norm(lines[0][:, None] - lines[1], axis=-1).min()
        assert value == pytest.approx(least - 130.0, abs=0.05)
    assert len(margins[0]) == 15
    assert margins.min() < 0


def test_numbers_that_are_none_and_poses_out_of_reach() -> None:
    machine = verne_post.load_machine("hexapod")
    tip = np.array([[0, 0, np.nan], [0, 0, np.inf], [0, 0, 50], [0, 0, 50]])
    axis = np.array([[0, 0, 1.0], [0, 0, 1.0], [0, 0, -1.0], [0, 0.1, 0.99498743710662]])
    q, ok = machine.inverse(tip, axis, LENGTH)
    assert ok.tolist() == [False, False, False, True]
    assert np.isnan(q[:3]).all()
    assert machine.five_axis.explain_unreachable(tip[2:3], np.array([[1.3, 0.0]]), LENGTH) == ["VP110"]
    far = np.array([[100.0] * 8, [np.nan, *[1e3] * 7], [-1e3, *[1e3] * 7]])
    assert not machine.forward(far, LENGTH)[2].any()
    with pytest.raises(ValueError, match="six actuators and two angles"):
        machine.forward(np.zeros(6), LENGTH)


def test_rods_that_do_not_reach_have_no_drop() -> None:
    """Beside the machine no rod closes: what is left of each along its rail is 0, not less, and not the least that one
    may have.
    """
    five_axis = verne_post.load_machine("hexaglide").five_axis
    q, platform, ok = five_axis.solve(np.array([[0.0, 0.0, -1200.0]]), np.zeros((1, 2)), LENGTH)
    assert not ok.any()
    assert five_axis.find_geometry_margins(q, np.zeros((1, 2)), platform)[0, 1:7].tolist() == [0.0] * 6


@pytest.mark.parametrize("name", [*NAMES, "tricept", "george_v", "urane_sx"])
def test_margins_warn_at_twice_of_what_is_refused(name: str) -> None:
    margins = verne_post.load_machine(name).five_axis.name_margins(0.1, 0.2)
    assert margins
    assert [one.warn_below for one in margins] == [2 * one.error_below for one in margins]


TEXT = (ROOT / "machine_configs/hexapod.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('words = "AC"', "", "chain.words is missing"),
        ('words = "AC"', 'words = "AB"', "chain.words"),
        ('tool = ["carrier"]', 'tool = ["carrier", "l1"]', "expected tool = ['carrier'] and part = []"),
        ("axis = [0.0, 0.0, -1.0] ", "axis = [0.0, 0.6, -0.8] ", "chain.axis is not along chain.up"),
        ('length = "l2"', 'length = "l1"', "expected each once"),
        ('"l5", "l6"]', '"l5"]', "5 actuators"),
        ("home = [0.0, 0.0, 900.0] ", "home = [0.0, 0.0, 0.0] ", "their Jacobian is singular"),
        ("spare_turn_deg = 0.0 ", "central = { base = [0, 0, 0], first_axis = [1, 0, 0] }", "too many: central"),
        ("[home] ", "[joints.c]\nturns = [0, 0, 1]\nthrough = [0, 0, 0]\nvelocity = 1.0\nacceleration = 1.0\n[home] ",
         "a rotary table under them is not executed yet"),
        ("[home] ", "[table]\nradius = 200.0\n[home] ", "leave [table] out"),
        ("[home] ", "[clearance]\nspindle_diameter_mm = 90\nspindle_top_mm = 90\nminimum_mm = 1\n[home] ",
         "there is no [table]"),
        ("travel_mm = [650.0, 1600.0]", "slides = [0, 0, 1]\ntravel_mm = [650.0, 1600.0]",
         "the value of a strut is its length"),
    ],
)  # fmt: skip
def test_refused_on_loading(old: str, new: str, why: str) -> None:
    assert old in TEXT
    text = TEXT.replace(old, new, 1)
    for table in ("table", "clearance"):
        text += f'{table} = "assumed"\n' * (f"[{table}]" in new)
    with pytest.raises(InputError) as refused:
        build_machine(text.encode(), "mine.toml")
    assert why in " ".join(item.message for item in refused.value.findings)


def test_words_belong_to_six_legs_alone() -> None:
    text = (
        (ROOT / "machine_configs/tricept.toml")
        .read_text(encoding="utf-8")
        .replace("part = []", 'part = []\nwords = "AC"')
    )
    assert "words" not in tomllib.loads(TEXT)["joints"]
    with pytest.raises(InputError, match="leave the key out"):
        build_machine(text.encode(), "mine.toml")
