"""Machines of one chain: reference values, other people's formulas, and a judge with matrices of its own."""

import json
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post
from verne_post.config.load import build_machine
from verne_post.kinematics.chain.senses import describe_senses
from verne_post.model.findings import InputError
from verne_post.model.machine import Machine
from verne_post.toolpath.evaluate import turn_tip

ROOT = Path(__file__).resolve().parents[2]
CHAINS = ["ac_trunnion", "bc_trunnion", "b_head_c_table", "ca_fork_head", "ab_table", "nutating_table", "nutating_head"]
REFERENCE = [json.loads(line) for line in (ROOT / "tests/reference/chains.jsonl").read_text().splitlines()[1:]]
LIMITS = "velocity = 500.0\nacceleration = 4000.0\njerk = 80000.0\n"


def describe(
    tool: str, part: str, joints: dict[str, str], gauge: str = "[0, 0, 300]", axis: str = "[0, 0, 1]", chain: str = ""
) -> str:
    """A machine file: joints in the order of letters from the base outwards, and the geometry keys of the
    rotary ones.
    """
    text = 'schema = 2\nname = "test"\n[chain]\n'
    text += f"tool = {list(tool)}\npart = {list(part)}\ngauge = {gauge}\naxis = {axis}\n".replace("'", '"')
    text += chain or "part_zero = [0, 0, 0]\n"
    for letter, unit in zip("xyz", np.eye(3).tolist(), strict=True):
        text += f"[joints.{letter}]\n"
        text += joints.get(letter, f'slides = {unit}\npositive = "tool"\n') + f"travel_mm = [-9e3, 9e3]\n{LIMITS}"
    for letter in sorted(set(joints) - set("xyz")):
        text += f"[joints.{letter}]\n{joints[letter]}{LIMITS}"
    return (
        text + '[control]\ncycle_s = 0.001\n[provenance]\nchain = "assumed"\njoints = "assumed"\ncontrol = "assumed"\n'
    )


def build(text: str) -> Machine:
    return build_machine(text.encode(), "test.toml")


def random_axes(n: int) -> np.ndarray:
    vectors = np.random.default_rng(n).normal(size=(n, 3))
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def in_file_units(machine: Machine, q: np.ndarray) -> np.ndarray:
    return np.asarray(q * [column.factor for column in machine.columns])


def both_solutions(machine: Machine, tip: np.ndarray, axis: np.ndarray, length: float) -> list[np.ndarray]:
    """Joints of a pose in the part frame."""
    polar = machine.coordinates.part_frame
    return [np.array(one.q) for one in machine.five_axis.inverse_all(polar @ tip, polar @ axis, length)]


# --- a judge of its own: 4 x 4 matrices, joint by joint -------------------------------------------------------------


def motion(joint: dict[str, object], value: np.ndarray, carries_tool: bool) -> np.ndarray:
    """Matrices (n, 4, 4) of the motion of what a joint carries, for values (n,) of the file (mm, degrees)."""
    sense = joint.get("positive", "tool" if carries_tool else "part")
    value = value if (sense == "tool") == carries_tool else -value
    matrix = np.tile(np.eye(4), (len(value), 1, 1))
    unit = np.array(joint.get("slides", joint.get("turns")), dtype=float)
    unit = unit / np.linalg.norm(unit)
    if "slides" in joint:
        matrix[:, :3, 3] = value[:, None] * unit
        return matrix
    x, y, z = unit
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(value)[:, None, None]
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    through = np.array(joint["through"], dtype=float)
    matrix[:, :3, :3], matrix[:, :3, 3] = turn, through - turn @ through
    return matrix


def judge(text: str, values: dict[str, np.ndarray], length: float) -> tuple[np.ndarray, np.ndarray]:
    """Tip and tool axis in the part frame (n, 3) of joint values of the file."""
    data = tomllib.loads(text)
    chain, joints = data["chain"], data["joints"]

    def carry(side: str) -> np.ndarray:
        matrix = np.eye(4)
        for name in chain[side]:
            matrix = matrix @ motion(joints[name], values[name], side == "tool")
        return matrix

    axis = np.array(chain["axis"], dtype=float) / np.linalg.norm(chain["axis"])
    up = np.array(chain.get("up", [0, 0, 1]), dtype=float)
    up /= np.linalg.norm(up)
    x = np.array([1.0, 0.0, 0.0]) - up[0] * up
    x /= np.linalg.norm(x)
    part = np.eye(4)
    part[:3, :3], part[:3, 3] = np.stack([x, np.cross(up, x), up], axis=1), chain["part_zero"]
    tip, away = np.append(np.array(chain["gauge"]) - length * axis, 1.0), np.append(axis, 0.0)
    both = np.linalg.inv(carry("part") @ part) @ carry("tool")
    return (both @ tip)[..., :3], (both @ away)[..., :3]


#: Pairs at right angles on all sides, with directions that lie along nothing: letters of the tool's side, of the
#: part's, seed.
RANDOM = [
    ("xyz", "bc", 1),
    ("xy", "zca", 2),
    ("xyzb", "c", 3),
    ("xb", "yza", 4),
    ("xyzca", "", 5),
    ("yzab", "x", 6),
    ("", "xyzba", 7),
]


def random_machine(tool: str, part: str, seed: int, between: float = 90.0, beside: float = 90.0) -> str:
    """A machine file with degrees between its rotary joints and between the farther one and the tool, else at
    random.
    """
    random = np.random.default_rng(seed)
    near, far = [letter for letter in (*reversed(part), *tool) if letter in "abc"]
    frame = np.linalg.qr(random.normal(size=(3, 3)))[0]
    spin = random.uniform(-3, 3)  # of the tool axis about the far joint
    travel = ""
    if nutates := (between, beside) != (90.0, 90.0):
        spin *= 0.4 * (between == beside)  # with a hole in the reach the travel begins at its rim
        travel = "travel_deg = [-100, 100]\n" if between == beside else "travel_deg = [0, 180]\n"
    a, b = np.radians([between, beside])
    axis = np.cos(spin) * frame[0] + np.sin(spin) * frame[2]
    if nutates:
        axis = np.sin(b) * axis + np.cos(b) * frame[1]
        frame[0] = np.sin(a) * frame[0] + np.cos(a) * frame[1]
    joints = {
        letter: f'slides = {random.normal(size=3).tolist()}\npositive = "{random.choice(["tool", "part"])}"\n'
        for letter in "xyz"
    }
    for letter, unit in ((near, frame[0]), (far, frame[1])):
        joints[letter] = (
            f"turns = {(random.uniform(0.5, 2) * unit).tolist()}\nthrough = {random.uniform(-90, 90, 3).tolist()}\n"
            f'positive = "{random.choice(["tool", "part"])}"\n{travel * (letter == far)}'
        )
    chain = f"part_zero = {random.uniform(-50, 50, 3).tolist()}\nup = {random.normal(size=3).tolist()}\n"
    return describe(tool, part, joints, str(random.uniform(-300, 300, 3).tolist()), str(axis.tolist()), chain)


#: The same with degrees between the joints, and between the farther one and the tool: with a pole, and with a hole
#: round it.
SKEW = [
    ("yz", "xbc", 11, 45.0, 45.0),
    ("xyzca", "", 12, 50.0, 50.0),
    ("xyzb", "c", 13, 65.0, 115.0),
    ("xb", "yza", 14, 70.0, 40.0),
    ("", "xyzba", 15, 120.0, 80.0),
    ("xyzca", "", 16, 35.0, 80.0),
]


@pytest.mark.parametrize("described", RANDOM + SKEW, ids=lambda described: str(described[2]))
def test_round_trip_against_matrices(described: tuple[Any, ...]) -> None:
    """15,000 random poses a machine, both solutions: the judge puts tip and axis where they were; beyond the reach
    there is none.
    """
    seed = described[2]
    text = random_machine(*described)
    machine = build(text)
    random, axis = np.random.default_rng(seed), random_axes(15_000)
    tip, length = random.uniform(-150, 150, axis.shape), 73.5
    q, ok = machine.inverse(tip, axis, length)
    a, b = np.radians(described[3:] or (90.0, 90.0))
    tilt = np.arccos(axis @ machine.coordinates.part_frame[2])
    low, high = sorted([abs(a - b), np.pi - abs(np.pi - a - b)])
    if machine.coordinates.nutation is not None and machine.coordinates.nutation.reach[0] != pytest.approx(low):
        low, high = np.pi - high, np.pi - low  # z of the polar frame is on the side where the reach begins
    assert (ok == ((tilt > low) & (tilt < high))).all()
    q, tip, axis = q[ok], tip[ok], axis[ok]
    polar = machine.coordinates.part_frame
    _q, angles, _ok = machine.five_axis.find_nominal_pose(q, length)
    other = machine.five_axis.find_joints(tip @ polar.T, angles * [-1, 1] + [0, np.pi], length)
    # linear joints at random may nearly lie in a plane, which multiplies the last bits of their sum
    slack = 1e-12 * np.linalg.cond(machine.five_axis.linear)
    # near the fold of a nutating pair the joint follows from its last bits
    turned = 1e-12 if len(described) == 3 else 1e-10
    for solution in (q, other):
        values = dict(
            zip((column.joint for column in machine.columns), in_file_units(machine, solution).T, strict=True)
        )
        there, points = judge(text, values, length)
        assert np.abs(there - tip).max() < slack * 1e3
        assert np.abs(points - axis).max() < turned
        back, leans, _ok = machine.forward(solution, length)
        assert np.abs(back - tip).max() < slack * 1e3
        assert np.abs(leans - axis).max() < turned


@pytest.mark.parametrize("row", REFERENCE, ids=[f"{row['machine']}_{k}" for k, row in enumerate(REFERENCE)])
def test_reference_values(row: dict[str, object]) -> None:
    machine = verne_post.load_machine(str(row["machine"]))
    tip, axis, length = np.array(row["tip_mm"]), np.array(row["axis"]), float(str(row["tool_length_mm"]))
    if not row["solutions"]:  # beyond the reach of a nutating pair
        assert not both_solutions(machine, tip, axis, length)
        assert not machine.inverse(tip, axis, length)[1]
        return
    found = [in_file_units(machine, q) for q in both_solutions(machine, tip, axis, length)]
    for solution in row["solutions"]:  # type: ignore[attr-defined]
        driven = [k for k, column in enumerate(machine.columns) if column.driven]  # all, but on a hexapod
        assert sorted(solution["joints"]) == sorted(machine.columns[k].joint for k in driven)
        wanted = np.array([solution["joints"][machine.columns[k].joint] for k in driven])
        turn = np.array([360.0 * (machine.columns[k].unit == "deg") for k in driven])
        away = [q[driven] - wanted - turn * np.round((q[driven] - wanted) / 360.0) for q in found]
        assert min(np.abs(one).max() for one in away) < 1e-11
    q, ok = machine.inverse(tip, axis, length)
    assert ok
    assert np.abs(machine.forward(q, length)[0] - tip).max() < 1e-11


def test_jacobian_is_the_derivative() -> None:
    """By central differences on every arrangement of sides."""
    step = 1e-5
    for described in RANDOM + SKEW:
        machine = build(random_machine(*described))
        random = np.random.default_rng(described[2])
        pose = np.append(random.uniform(-100, 100, 3), random.uniform(-2, 2, 2))
        if (nutation := machine.coordinates.nutation) is not None:
            pose[3] = np.copysign(np.array([0.4, 0.6]) @ nutation.reach, pose[3])
        exact = machine.five_axis.find_jacobian(pose[:3], pose[3:], 60.0)
        for k in range(5):
            ends = [
                machine.five_axis.find_joints(one[:3], one[3:], 60.0)
                for one in (pose + step * np.eye(5)[k], pose - step * np.eye(5)[k])
            ]
            assert (ends[0] - ends[1]) / (2 * step) == pytest.approx(exact[:, k], abs=1e-5)  # rounding over the step


def test_bodies_stand_where_the_tool_is() -> None:
    """The platform's point and spindle, brought onto the part, are gauge point and tool axis."""
    for described in RANDOM + SKEW:
        machine = build(random_machine(*described))
        axis = random_axes(50)
        tip = np.random.default_rng(described[2]).uniform(-100, 100, axis.shape)
        polar = machine.coordinates.part_frame
        q, ok = machine.inverse(tip, axis, 40.0)
        q, tip, axis = q[ok], tip[ok], axis[ok]
        platform, _ok = machine.five_axis.find_platform(q)
        gauge = machine.five_axis.carry_to_table(platform.position, q) @ polar
        below = (
            machine.five_axis.carry_to_table(platform.position + platform.turn(machine.five_axis.spindle), q) @ polar
        )
        assert np.abs(gauge - tip - 40.0 * axis).max() < 1e-9
        assert np.abs(gauge - below - axis).max() < 1e-9


# --- other people's formulas: LinuxCNC's trt, bridge mill (5axis) and max kinematics
# ---------------------------------------


def rows(*columns: object) -> np.ndarray:
    return np.stack(np.broadcast_arrays(*columns), axis=-1)  # type: ignore[arg-type]


def joint_values() -> tuple[np.ndarray, np.ndarray]:
    """Linear joints (n, 3), mm, and two rotary ones (n, 2), degrees."""
    random = np.random.default_rng(5)
    return random.uniform(-200, 200, (2000, 3)), random.uniform(-175, 175, (2000, 2))


def forward(machine: Machine, linear: np.ndarray, tilt: np.ndarray, turn: np.ndarray, length: float) -> np.ndarray:
    q = rows(*linear.T, tilt, turn) / [column.factor for column in machine.columns]
    return machine.forward(q, length)[0]


@pytest.mark.parametrize("letter", ["a", "b"])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_linuxcnc_trunnions(letter: str, sense: float) -> None:
    """Xyzac-trt and xyzbc-trt, as shipped (the part turns right-handed) and with conventional directions."""
    rotary_point, tilt_point = np.array([3.0, -4.0, 5.0]), np.array([11.0, 0.7, -13.0])
    tilt_point[1 if letter == "b" else 0] = 0.0
    direction = [1, 0, 0] if letter == "a" else [0, 1, 0]
    positive = "part" if sense > 0 else "tool"
    through = (rotary_point + tilt_point).tolist()
    machine = build(
        describe(
            "xyz",
            letter + "c",
            {
                letter: f'turns = {direction}\nthrough = {through}\npositive = "{positive}"\n',
                "c": f'turns = [0, 0, 1]\nthrough = {rotary_point.tolist()}\npositive = "{positive}"\n',
            },
            gauge="[0, 0, 30]",
        )
    )
    linear, rotary = joint_values()
    x, y, z = (linear - rotary_point - tilt_point).T
    (st, ct), (sc, cc) = ((np.sin(one), np.cos(one)) for one in sense * np.radians(rotary).T)
    if letter == "a":
        flat = np.stack([x + tilt_point[0], ct * y + st * z + tilt_point[1], -st * y + ct * z + tilt_point[2]])
    else:
        flat = np.stack([ct * x - st * z + tilt_point[0], y + tilt_point[1], st * x + ct * z + tilt_point[2]])
    wanted = np.stack([cc * flat[0] + sc * flat[1], -sc * flat[0] + cc * flat[1], flat[2]], axis=1) + rotary_point
    assert np.abs(forward(machine, linear, *rotary.T, 30.0) - wanted).max() < 1e-12 * 1e3  # of lengths of 10^3 mm


def test_linuxcnc_bridge_mill() -> None:
    """5axiskins: C carries B, whose positive angle is left-handed; the pivot is 250 mm over the tip at home."""
    machine = build(
        describe(
            "xyzcb",
            "",
            {
                "b": "turns = [0, -1, 0]\nthrough = [0, 0, 250]\n",
                "c": "turns = [0, 0, 1]\nthrough = [0, 0, 0]\n",
            },
            gauge="[0, 0, 250]",
        )
    )
    linear, rotary = joint_values()
    (sb, cb), (sc, cc) = ((np.sin(one), np.cos(one)) for one in np.radians(rotary).T)
    wanted = linear + 250.0 * rows(sb * cc, sb * sc, 1.0 - cb)
    assert np.abs(forward(machine, linear, *rotary.T, 250.0) - wanted).max() < 1e-12 * 1e3


@pytest.mark.parametrize("conventional", [1.0, -1.0])
def test_linuxcnc_max(conventional: float) -> None:
    """Maxkins: B head over a C table, pivot 120 mm and tool 60 mm."""
    machine = build(
        describe(
            "xyzb",
            "c",
            {
                "b": f"turns = [0, {conventional}, 0]\nthrough = [0, 0, 180]\n",
                "c": 'turns = [0, 0, 1]\nthrough = [0, 0, 0]\npositive = "tool"\n',
            },
            gauge="[0, 0, 60]",
        )
    )
    linear, rotary = joint_values()
    b, c = np.radians(rotary).T
    x, y = linear[:, 0] - conventional * 180.0 * np.sin(b), linear[:, 1]
    wanted = rows(np.cos(c) * x - np.sin(c) * y, np.sin(c) * x + np.cos(c) * y, linear[:, 2] + 180.0 * (1 - np.cos(b)))
    assert np.abs(forward(machine, linear, *rotary.T, 60.0) - wanted).max() < 1e-12 * 1e3


# --- what cannot depend on how a machine is described
# -----------------------------------------------------------------------


def test_sides_of_linear_axes_do_not_matter() -> None:
    """A linear axis on the other side, positive as the tool moves, has the same values."""
    joints = {
        "b": 'turns = [0, 1, 0]\nthrough = [5, 6, 7]\npositive = "tool"\n',
        "c": "turns = [0, 0, 1]\nthrough = [1, 2, 3]\n",
    }
    axis, tip = random_axes(100), np.random.default_rng(3).uniform(-90, 90, (100, 3))
    first, *others = (
        build(describe(tool, part, joints)).inverse(tip, axis, 50.0)[0]
        for tool, part in (("xyz", "bc"), ("xz", "ybc"), ("", "xyzbc"))
    )
    for other in others:
        assert np.abs(first - other).max() < 1e-12


def test_directions_of_the_base_do_not_matter() -> None:
    """All directions and points turned by one rotation about z, the part's frame too: the same joints."""
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])

    def turned(matrix: np.ndarray) -> Machine:
        def show(*vector: float) -> list[float]:
            return [float(value) for value in matrix @ vector]

        joints = {letter: f"slides = {show(*unit)}\n" for letter, unit in zip("xyz", np.eye(3).tolist(), strict=True)}
        joints |= {
            "b": f"turns = {show(0, 1, 0)}\nthrough = {show(5, 6, 7)}\n",
            "c": f"turns = {show(0, 0, 1)}\nthrough = {show(1, 2, 3)}\n",
        }
        return build(describe("xyzb", "c", joints, gauge=str(show(10, 20, 300))))

    axis, tip = random_axes(200), np.random.default_rng(3).uniform(-90, 90, (200, 3))
    q, _ok = turned(np.eye(3)).inverse(tip, axis, 50.0)
    p, _ok = turned(turn).inverse(tip @ turn.T, axis @ turn.T, 50.0)
    assert np.abs((q - p)[:, :3]).max() < 1e-11
    assert np.abs(np.sin(0.5 * (q - p)[:, 3:])).max() < 1e-13


def test_senses_in_words() -> None:
    """Bridge mill: B is left-handed."""
    machine = build(
        describe(
            "xyzcb",
            "",
            {
                "b": "turns = [0, -1, 0]\nthrough = [0, 0, 250]\n",
                "c": "turns = [0, 0, 1]\nthrough = [0, 0, 0]\n",
            },
        )
    )
    points, *senses = describe_senses(machine)
    said = "at joints 0 the tool points towards -z of the part: from the spindle down; its gauge point is at "
    assert points == f"{said}0, 0, 300 of the part"
    assert senses[3:] == [
        "B +10: the tool leans towards -x of the part",
        "C +10: with B +10, the tool leans from -x towards -y of the part",
    ]
    *_linear, b, _c = describe_senses(verne_post.load_machine("bc_trunnion"))
    assert b == "B +10: the tool leans towards +x of the part"


# --- files that are refused
# ------------------------------------------------------------------------------------------------

B = "turns = [0, 1, 0]\nthrough = [0, 0, 0]\n"
C = "turns = [0, 0, 1]\nthrough = [0, 0, 0]\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (describe("xyz", "bc", {"b": B, "c": B}), "the two rotary joints are parallel"),
        (describe("xyzbc", "", {"b": B, "c": C}),
         "the rotary joint farther from the part and the tool axis are parallel"),
        (describe("xyz", "cb", {"b": B, "c": C}), "is the order of c and b reversed?"),
        (describe("xyz", "bc", {"b": B.replace("1, 0]", "1, 1]"), "c": C}),
         "b -180 and 180, its folds; expected a travel between them"),
        (describe("xyz", "bc", {"b": B.replace("1, 0]", "1, 1]") + "travel_deg = [-10, 181]\n", "c": C}),
         "travel_deg = [-10.0, 181.0]: the pair"),
        (describe("xyz", "bc", {"b": B.replace("1, 0]", "1, 1]"), "c": C}, axis="[0, 0.01, 2]"),
         "the tool just misses the direction of the"),
        (describe("xyz", "bc", {"b": B.replace("[0, 1", "[0, 1, 0.001]#"), "c": C}),
         "give them as drawn, not as measured"),
        (describe("xyzb", "", {"b": B}), "expected x, y, z, and two of a, b, c"),
        (describe("xy", "bc", {"b": B, "c": C}), "joints.z: neither chain.tool nor chain.part names it"),
        (describe("xyz", "bc", {"b": B, "c": C}).replace("[joints.c]", "[joints.cc]"),
         "joints.cc: neither chain.tool nor chain.part names it; did you mean c?"),
        (describe("xyz", "bcc", {"b": B, "c": C}), "expected every joint once"),
        (describe("xybz", "c", {"b": B, "c": C}), "b turns z: a rotary joint that carries a linear one"),
        (describe("xyz", "bc", {"b": B, "c": C, "x": "slides = [0, 1, 0]\n"}), "lie in a plane"),
        (describe("xyz", "bc", {"b": "turns = [0, 1, 0]\n", "c": C}), "a joint that turns has through"),
        (describe("xyz", "bc", {"b": B, "c": C + "slides = [1, 0, 0]\n"}), "expected one of slides and turns"),
        (describe("xyz", "bc", {"b": B.replace("1", "0"), "c": C}), "turns = [0.0, 0.0, 0.0]: expected a direction"),
        (describe("xyz", "bc", {"b": B.replace("1", "1e-320"), "c": C}), "expected a direction, with a length"),
        (describe("xyz", "bc", {"b": B, "c": C}, axis="[0, 0, 0]"), "axis = [0.0, 0.0, 0.0]: expected a direction"),
        (describe("xyz", "ab", {"a": B.replace("0, 1", "1, 0"),
                                "b": B}) + 'table = "assumed"\n[table]\nradius = 99.0\n', "no face at z = 0"),
    ],
)  # fmt: skip
def test_refused_files(text: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        build(text)
    assert said in caught.value.findings[0].message
    assert caught.value.findings[0].code == "VP501"


# --- without tool-centre-point control ---------------------------------------------------------------------


@pytest.mark.parametrize("name", [name for name in CHAINS if not name.startswith("nutating")])
def test_tips_are_carried_while_all_joints_go_straight(name: str) -> None:
    """The curve of a tip between two poses, on which every joint stands where its own line has it."""
    machine, pick = verne_post.load_machine(name), np.random.default_rng(5)
    wide = np.array([60.0, 60.0, 40.0, 0.6, 1.5])
    start, end = pick.uniform(-wide, wide, (2, 40, 5))
    turns = machine.coordinates.carry_tips(start, end, np.full(40, 80.0))
    poses = {}
    for u in (0.0, 0.3, 0.8, 1.0):
        tip = turn_tip(turns, np.arange(40), np.full(40, u))
        poses[u] = machine.five_axis.solve(tip, (start + u * (end - start))[:, 3:], 80.0)[0]
        if u in (0.0, 1.0):
            assert np.abs(tip - (start if u == 0.0 else end)[:, :3]).max() < 1e-9
    for u, q in poses.items():
        assert np.abs(q - (poses[0.0] + u * (poses[1.0] - poses[0.0]))).max() < 1e-9


@pytest.mark.parametrize("name", CHAINS)
def test_only_a_tool_along_z_of_the_part_is_upright(name: str) -> None:
    """The joints of a pair are at most two of A, B and C; a pair that leans by 10 degrees still points upwards."""
    coordinates = verne_post.load_machine(name).coordinates
    words = np.zeros((4, 9))
    words[1:, 3:6] = 10.0 * np.eye(3)
    upright = [coordinates.is_upright(one) for one in words]
    assert upright[0]
    assert not all(upright[1:3])
