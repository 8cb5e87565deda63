"""Vector programs from text to rows: great circles, twins in A and C words, verification that sees what is wrong.

The judge of the serial machine's rows has its own forward kinematics: three signs and a shift, no tilt.
"""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import verne_post
from verne_post import convert
from verne_post.app.assemble import assemble
from verne_post.app.verify import verify_setpoints
from verne_post.config import list_machine_files
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.model.setpoints import SetpointBlock
from verne_post.output.rounding import choose_setpoint_format
from verne_post.toolpath.contour_pose import find_contour_pose

from ..builders import axis_of, axis_words, two_machines

HEAD = "G21 G90 G94 G17 F3000\n"
MACHINES = two_machines(cycle=0.002)
TOOL = 60.0
#: Written numbers: 1e-3 mm and 1e-3 degrees are what verification accepts; auto decimals are far finer.
TIP_MM, AXIS = 1e-5, 1e-7


def source(body):
    return f"{HEAD}{body}\nM2\n".encode()


def options(**more):
    more.setdefault("tool_length", TOOL)
    more.setdefault("wcs", {1: WorkOffset((0.0, 0.0, 50.0))})
    return Options(**more)


def made(body, machine, **more):
    result = convert(source(body), machine, options(**more))
    assert result.ok, [item.message for item in result.findings]
    return result.setpoints


def poses(setpoints, name):
    """Tip and axis on the table of every row; the serial machine by hand."""
    values = setpoints.values
    if name == "verne":
        machine = MACHINES["verne"]
        tip, axis, ok = machine.forward(values / [column.factor for column in machine.columns], TOOL)
        assert ok.all()
        return tip, axis
    a, c = np.radians(values[:, 3]), np.radians(values[:, 4])
    x, y, z = values[:, 0], values[:, 1], values[:, 2] + 550.0 - TOOL
    y, z = np.cos(a) * y + np.sin(a) * z, np.cos(a) * z - np.sin(a) * y
    tip = np.stack([np.cos(c) * x + np.sin(c) * y, np.cos(c) * y - np.sin(c) * x, z], axis=1)
    return tip, axis_of(a, c)


def verify_rows(setpoints, body, machine, **more):
    program = assemble(source(body), machine, options(**more))
    fmt = choose_setpoint_format(machine, program.cycle, None, accept_rounding=False)
    return verify_setpoints(program, iter([SetpointBlock(0, setpoints.values, setpoints.line, fmt)]))


# --- great circles --------------------------------------------------------------------------------

SWINGS = [
    ((30.0, 0.0), (30.0, 120.0)),
    ((10.0, -170.0), (45.0, 100.0)),
    ((2.0, 10.0), (2.0, 170.0)),
    ((0.0, 0.0), (40.0, 77.0)),
    ((40.0, 30.0), (40.0, 30.0001)),
]


@pytest.mark.parametrize("word", ["G0", "G1"])
@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize(("first", "second"), SWINGS)
def test_every_row_is_on_the_great_circle(name, first, second, word):
    """The axis turns about the normal of both ends (Rodrigues), in step with the tip on its line."""
    body = f"G43.5 G0 X0 Y0 Z60 {axis_words(*first)}\n{word} X20 Y5 Z65 {axis_words(*second)}"
    setpoints = made(body, MACHINES[name])
    tip, axis = poses(setpoints, name)
    k0, k1 = axis_of(*np.radians(first)), axis_of(*np.radians(second))
    p0, p1 = np.array([0.0, 0.0, 110.0]), np.array([20.0, 5.0, 115.0])
    u = (tip - p0) @ (p1 - p0) / ((p1 - p0) @ (p1 - p0))
    assert np.abs(tip - p0 - u[:, None] * (p1 - p0)).max() < TIP_MM
    normal = np.cross(k0, k1)
    angle = math.atan2(np.linalg.norm(normal), k0 @ k1)
    normal /= np.linalg.norm(normal)
    turn = (u * angle)[:, None]
    expected = k0 * np.cos(turn) + np.cross(normal, k0) * np.sin(turn)
    assert np.linalg.norm(axis - expected, axis=1).max() < AXIS
    assert (u[0], u[-1]) == (pytest.approx(0.0, abs=1e-6), pytest.approx(1.0, abs=1e-6))


@pytest.mark.parametrize("name", MACHINES)
def test_a_small_swing_with_a_large_turn_of_c_is_complete(name):
    """C turns by 90 degrees while tip and axis hardly move: the end counts by what moves."""
    made(f"G43.5 G0 X0 Y0 Z60 {axis_words(0.5, 0)}\nG0 Y1 {axis_words(0.5, 90)}", MACHINES[name])


@pytest.mark.parametrize("name", MACHINES)
def test_a_swing_in_place_is_in_degrees_per_minute(name):
    """Nothing but the axis moves: 60 degrees of great circle at 600 deg/min take 6 s and the ramps."""
    body = f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 90)}\nG1 {axis_words(30, 270)} F600"
    setpoints = made(body, MACHINES[name])
    tip, _axis = poses(setpoints, name)
    assert np.abs(tip - [0.0, 0.0, 110.0]).max() < TIP_MM
    assert 6.0 < setpoints.t[-1] < 6.6


@pytest.mark.parametrize("name", MACHINES)
def test_swings_in_place_one_after_another_keep_the_feed_of_the_axis(name):
    """Where motion goes on from swing to swing the turn of the axis counts: made for 600 deg/min they are too fast for
    595.
    """
    body = (
        f"G64 P0.05\nG43.5 G0 X0 Y0 Z60 {axis_words(10, 90)}\nG1 {axis_words(30, 90)} F600\n"
        f"{axis_words(40, 110)}\n{axis_words(30, 150)}"
    )
    setpoints = made(body, MACHINES[name])
    assert not verify_rows(setpoints, body, MACHINES[name]).findings
    slower = verify_rows(setpoints, body.replace("F600", "F595"), MACHINES[name])
    assert {item.code for item in slower.findings} == {"VP404"}


def test_words_along_the_great_circle_where_the_option_says_so():
    """--orientation vector for A and C words is the vector program; auto is linear in A and C."""
    machine = MACHINES["serial"]
    words = "G43.4 G0 X0 Y0 Z60 A30 C0\nG1 X20 A40 C120"
    vectors = f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 0)}\nG1 X20 {axis_words(40, 120)}"
    u = np.linspace(0, 1, 60)
    q = {
        key: assemble(source(body), machine, options(orientation=way))
        .build_joint_path()
        .find_joints(np.zeros(60, int), u)
        for key, body, way in (
            ("vector", vectors, "auto"),
            ("words as vectors", words, "vector"),
            ("vectors", vectors, "vector"),
            ("words", words, "auto"),
            ("words as angles", words, "angles"),
            ("vectors as angles", vectors, "angles"),
        )
    }
    for one, other in (
        ("vector", "words as vectors"),
        ("vector", "vectors"),
        ("words", "words as angles"),
        ("words", "vectors as angles"),
    ):
        assert q[one] == pytest.approx(q[other], abs=1e-9)
    assert np.abs(q["vector"] - q["words"])[:, 3].max() > 0.1


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("turn", [0.0, 33.0])
def test_a_vector_program_is_its_twin_in_words(name, turn):
    """With linear A and C the two programs are one motion, to 1e-9 mm, on a part that is turned as well."""
    tilts = [(20, 10), (25, 60), (50, 60), (30, -40), (0, -40), (15, -40)]
    head = "G0 Y0 Z60 "
    vectors = "G43.5 " + head + "\nG1 ".join(f"X{9 * k} {axis_words(*pair)}" for k, pair in enumerate(tilts))
    words = "G43.4 " + head + "\nG1 ".join(f"X{9 * k} A{pair[0]} C{pair[1]}" for k, pair in enumerate(tilts))
    where = {1: WorkOffset((10.0, -5.0, 50.0), turn)}
    found = [
        assemble(source(body), MACHINES[name], options(orientation="angles", wcs=where)) for body in (vectors, words)
    ]
    elements, u = np.repeat(np.arange(5), 9), np.tile(np.linspace(0, 1, 9), 5)
    assert found[0].build_joint_path().find_joints(elements, u) == pytest.approx(
        found[1].build_joint_path().find_joints(elements, u), abs=1e-9
    )
    assert found[0].path.feed_time == pytest.approx(found[1].path.feed_time, rel=1e-9)


@pytest.mark.parametrize(("a", "c"), [("workpiece", "tool"), ("tool", "workpiece"), ("tool", "tool")])
def test_senses_of_the_machine_file_do_not_change_a_vector_program(tmp_path, a, c):
    """The same tips and axes; the columns change their sign."""
    text = list_machine_files()["serial"].read_text(encoding="utf-8")
    text = text.replace('a_positive = "workpiece"', f'a_positive = "{a}"')
    text = text.replace('c_positive = "workpiece"', f'c_positive = "{c}"').replace("cycle_s = 0.001", "cycle_s = 0.002")
    (tmp_path / "m.toml").write_text(text, encoding="utf-8")
    body = f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 20)}\nG1 X20 {axis_words(40, 100)}\nG53 G0 Z0"
    plain, turned = made(body, MACHINES["serial"]), made(body, verne_post.load_machine(str(tmp_path / "m.toml")))
    signs = [1, 1, 1, -1 if a == "tool" else 1, -1 if c == "tool" else 1]
    assert turned.values == pytest.approx(plain.values * signs, abs=1e-9)


def test_inches_and_feed_modes_of_vector_programs():
    """An inch with a swing in a tenth of a minute: F in mm, in inches, and inverse time."""
    swing = axis_words(40, 100)
    first = f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 20)}\n"
    metric = made(first + f"G1 X25.4 {swing} F254", MACHINES["serial"])
    inches = made(first + f"G20\nF10\nG1 X1 {swing}", MACHINES["serial"])
    inverse = made(first + f"G93 G1 X25.4 {swing} F10", MACHINES["serial"])
    assert inches.values == pytest.approx(metric.values, abs=1e-9)
    assert inverse.values == pytest.approx(metric.values, abs=1e-9)


@pytest.mark.parametrize("name", MACHINES)
def test_an_approach_leads_to_the_branch_that_is_used(name):
    """--from home, where the tilt's range asks for the other table solution."""
    machine = MACHINES[name]
    upper = machine.limits.upper.copy()
    upper[3] = math.radians(15.0)
    machine = replace(machine, limits=replace(machine.limits, upper=upper))
    setpoints = made(
        f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 90)}\nG1 X20\nG53 G0 Z0", machine, approach="home", smoothing="off"
    )
    assert setpoints.values[:, 3].max() <= 15.0
    tip, axis = poses(setpoints, name)
    fed = setpoints.line == 3
    assert axis[fed] == pytest.approx(np.tile(axis_of(*np.radians([30.0, 90.0])), (fed.sum(), 1)), abs=AXIS)
    assert tip[fed][:, 1:] == pytest.approx(np.tile([0.0, 110.0], (fed.sum(), 1)), abs=TIP_MM)


# --- what verification must see -------------------------------------------------------------------

TILTED = f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 20)}\nG1 X20 {axis_words(30, 140)}\nX40"


@pytest.mark.parametrize("name", MACHINES)
def test_another_orientation_than_the_program_is_refused(name):
    """Linear A and C against the great circle, both ways; the ends are the same, the way is not."""
    machine = MACHINES[name]
    for making, judging in (("angles", "auto"), ("auto", "angles")):
        setpoints = made(TILTED, machine, orientation=making)
        assert verify_rows(setpoints, TILTED, machine, orientation=making).ok
        verdict = verify_rows(setpoints, TILTED, machine, orientation=judging)
        assert not verdict.ok
        assert "VP411" in {item.code for item in verdict.findings}


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize(
    "body", [TILTED, f"G43.5 G0 X0 Y0 Z60 {axis_words(2, 20)}\nG1 X20 {axis_words(2, 140)}\nX40"], ids=["steep", "flat"]
)
def test_the_other_branch_and_another_turn_are_refused(name, body):
    """Rows with the same tips and the same tool axes, on the other table solution or a turn away, are not the file."""
    machine = MACHINES[name]
    setpoints = made(body, machine)
    factor = np.array([column.factor for column in machine.columns])
    tip, angles, ok = machine.five_axis.find_nominal_pose(setpoints.values / factor, TOOL)
    assert ok.all()
    for other in (angles * [-1, 1] + [0, math.pi], angles + [0, 2 * math.pi]):
        q, _platform, _ok = machine.five_axis.solve(tip, other, TOOL)
        wrong = replace(setpoints, values=np.round(q * factor, 9))
        assert poses(wrong, name)[1] == pytest.approx(poses(setpoints, name)[1], abs=1e-8)
        verdict = verify_rows(wrong, body, machine)
        assert "VP411" in {item.code for item in verdict.findings}


@pytest.mark.parametrize("name", MACHINES)
def test_an_axis_two_thousandths_of_a_degree_off_is_refused(name):
    """Sideways of the great circle, tip unmoved: verification accepts one thousandth."""
    machine = MACHINES[name]
    setpoints = made(TILTED, machine, smoothing="off")
    factor = np.array([column.factor for column in machine.columns])
    tip, angles, _ok = machine.five_axis.find_nominal_pose(setpoints.values / factor, TOOL)
    for off, fine in ((0.0005, True), (0.002, False)):
        bump = math.radians(off) * np.sin(np.pi * np.linspace(0, 1, len(angles))) ** 4
        q, _platform, _ok = machine.five_axis.solve(tip, angles + bump[:, None] * [1.0, 0.0], TOOL)
        verdict = verify_rows(replace(setpoints, values=np.round(q * factor, 9)), TILTED, machine, smoothing="off")
        assert ("VP411" not in {item.code for item in verdict.findings}) == fine


# --- anything at all ----------------------------------------------------------------------------


@st.composite
def programs(draw):
    """Vector programs with words, rapids, dwells and retracts among them."""
    number = st.floats(-30, 30).map(lambda value: round(value, 3))
    turn = st.one_of(st.sampled_from([0.0, 90.0, 180.0, -90.0]), st.floats(-180, 180))
    tilt = st.one_of(st.sampled_from([0.0, 5e-5, 5e-4, 0.5, 30.0]), st.floats(0.5, 100))
    point_axis = st.builds(axis_words, tilt, turn)
    word = st.sampled_from(["G0", "G1"])
    lines = [f"G43.5 G0 X0 Y0 Z70 {draw(point_axis)}"]
    vectors = True
    for _ in range(draw(st.integers(1, 5))):
        kind = draw(
            st.sampled_from(["vector", "vector", "vector", "plain", "words", "dwell", "retract", "home", "arc"])
        )
        if kind == "vector":
            lines += [] if vectors else ["G43.5"]
            vectors = True
            lines.append(f"{draw(word)} X{draw(number)} Y{draw(number)} Z70 {draw(point_axis)}")
        elif kind == "plain":
            lines.append(f"{draw(word)} X{draw(number)}")
        elif kind == "words":
            lines += ["G43.4"] if vectors else []
            vectors = False
            lines.append(f"{draw(word)} Y{draw(number)} A{draw(number)} C{10 * draw(number)}")
        else:
            lines.append({"dwell": "G4 P0.01", "retract": "G53 G0 Z0", "home": "G28", "arc": "G3 I3"}[kind])
    return "\n".join(lines)


@settings(max_examples=30, deadline=None)
@given(
    programs(),
    st.sampled_from(["verne", "serial"]),
    st.sampled_from([None, 200.0, 360.0]),
    st.sampled_from([25.0, 95.0]),
    st.booleans(),
    st.sampled_from(["auto", "vector", "angles"]),
)
def test_any_vector_program_is_written_and_verified_or_refused(body, name, c_range, a_high, rewind, orientation):
    """Never an exception, never rows that fail our own verification; what is written keeps the ranges."""
    machine = MACHINES[name]
    lower, upper = machine.limits.lower.copy(), machine.limits.upper.copy()
    upper[3] = math.radians(a_high)
    if c_range is not None:
        lower[4], upper[4] = -math.radians(c_range), math.radians(c_range)
    machine = replace(machine, limits=replace(machine.limits, lower=lower, upper=upper), cycle=0.008)
    result = convert(source(body), machine, options(allow_rewind=rewind, orientation=orientation))
    assert result.exit_code in (0, 1, 2), [item.message for item in result.findings]
    assert result.ok or any(item.severity == "error" for item in result.findings)
    if result.ok:
        assert all(item.severity != "error" for item in result.findings)
        assert result.setpoints.values[:, 3].max() <= a_high + 1e-6
        assert c_range is None or np.abs(result.setpoints.values[:, 4]).max() <= c_range + 1e-6


# --- steps that are followed linearly in A and C ---------------------------------------------------------


def swept(step, points, *, tilt=0.2, digits=8, turn=1 / 200):
    """Tool axes along a spiral, and the same poses as A and C words; ``step`` is the way between two points, mm."""
    s = step * np.arange(points)
    a, c = tilt + 0.1 * np.sin(s / 30), s * turn
    tip = np.column_stack([30 * np.cos(s / 30), 30 * np.sin(s / 30), 60 + 1e-3 * s])
    axis = np.column_stack([np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)])
    vectors = [
        "X%.5f Y%.5f Z%.5f I%.*f J%.*f K%.*f" % (*p, *(n for x in k for n in (digits, x)))
        for p, k in zip(tip, axis, strict=True)
    ]
    words = ["X%.5f Y%.5f Z%.5f A%.6f C%.6f" % (*p, *w) for p, w in zip(tip, np.degrees([a, c]).T, strict=True)]
    return (
        source("\n".join(["G43.5", f"G1 {vectors[0]}", *vectors[1:]])),
        source("\n".join([f"G1 {words[0]}", *words[1:]])),
        axis,
    )


def contour_of(text, **wanted):
    return assemble(text, MACHINES["verne"], options(**wanted)).contour


@pytest.mark.parametrize("step, digits", [(0.2, 8), (1.0, 5), (3.0, 5)])
def test_vector_steps_take_no_longer_than_their_words(step, digits):
    """They are blended as straight segments; between great circles the same path took up to two and a half times as
    long.
    """
    vectors, words = (text.replace(b"F3000", b"F9000") for text in swept(step, 200, digits=digits)[:2])
    contour = contour_of(vectors)
    assert (contour.path.circle[1:] >= 0).all()
    assert (contour.shape.circle < 0).all()
    rows = [len(convert(text, MACHINES["verne"], options()).setpoints.values) for text in (vectors, words)]
    assert rows[0] == pytest.approx(rows[1], rel=5e-3)


def farthest_from_linear(k0, k1):
    """Largest angle in degrees between the great circle from axis to axis, by its own formula, and linear A and C."""
    angle = math.acos(float(k0 @ k1))
    u = np.linspace(0.0, 1.0, 101)[:, None]
    along = (np.sin((1 - u) * angle) * k0 + np.sin(u * angle) * k1) / math.sin(angle)
    ends = np.array([[math.acos(k[2]), math.atan2(k[0], k[1])] for k in (k0, k1)])
    a, c = (ends[0] + u * (ends[1] - ends[0])).T
    linear = np.column_stack([np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)])
    return np.degrees(np.linalg.norm(along - linear, axis=1).max())


def test_a_step_is_linear_only_within_half_of_the_axis_tolerance():
    """0.05 degrees in verne.toml. The corners beside it have the rest, and no more."""
    kinds = []
    for step, tilt in ((4.0, 0.2), (10.0, 0.2), (20.0, 0.2), (30.0, 0.5), (4.0, 0.12)):
        text, _words, axis = swept(step, 40, tilt=tilt)
        contour = contour_of(text)
        for (k0, k1), number in zip(pairwise(axis), contour.shape.circle[-39:], strict=True):
            off = farthest_from_linear(k0, k1)
            assert (number < 0) == (off < 0.025) or abs(off - 0.025) < 5e-4, (step, off)
            kinds.append(number < 0)
        assert np.degrees(contour.axis_tolerance).max() <= 0.05 * (1 + 1e-12)
    assert 20 < sum(kinds) < len(kinds) - 20


def test_the_tolerance_is_left_to_the_corners_and_kept():
    """Great circle and blends together: every pose of the contour beside the programmed great circle of its segment."""
    text, _words, axis = swept(9.0, 40)
    contour = contour_of(text)
    assert (contour.shape.circle[-39:] < 0).all()
    assert max(farthest_from_linear(*pair) for pair in pairwise(axis)) > 0.01  # it is used
    element = np.repeat(np.arange(len(contour)), 21)
    _tip, angles = find_contour_pose(contour, element, np.tile(np.linspace(0.0, 1.0, 21), len(contour)))
    segment = contour.segment[element]
    off = np.full(len(segment), np.inf)
    first, side, turn = (getattr(contour.path.circles, name) for name in ("first", "side", "angle"))
    a, c = angles.T
    k = np.column_stack([np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)])
    for near in (-1, 0, 1):  # a blend passes the corner where another segment is the nearer one
        row = contour.path.circle[np.clip(segment + near, 0, len(contour.path) - 1)]
        for u in np.linspace(0.0, 1.0, 201):
            on = np.cos(u * turn[row])[:, None] * first[row] + np.sin(u * turn[row])[:, None] * side[row]
            off = np.where(row >= 0, np.minimum(off, np.linalg.norm(k - on, axis=1)), off)
    fed = contour.path.circle[segment] >= 0
    assert 0.01 < np.degrees(off[fed].max()) <= 0.05


@pytest.mark.parametrize("wanted", [{"approach": "home", "departure": "home"}, {"from_line": 20, "approach": "home"}])
def test_an_approach_changes_no_pose_of_the_program(wanted):
    """Steps that are followed linearly are so behind an approach, and after a restart in the middle."""
    text = swept(5.0, 40)[0]
    alone, approached = contour_of(text), contour_of(text, **wanted)
    assert (alone.shape.circle[1:] < 0).all()
    angles = {}
    for contour in (alone, approached):
        element = np.repeat(np.arange(len(contour)), 5)
        segment = contour.segment[element]
        _tip, pose = find_contour_pose(contour, element, np.tile(np.linspace(0.1, 0.9, 5), len(contour)))
        for line in range(25, 40):
            angles.setdefault(line, []).append(pose[contour.path.line[segment] == line])
    for one, other in angles.values():
        assert len(one) > 0
        assert other == pytest.approx(one, abs=1e-12)
    if "from_line" not in wanted:
        assert convert(text, MACHINES["verne"], options(**wanted)).ok


@pytest.mark.parametrize("head", ["G61", "G64 P0"])
def test_exact_paths_keep_their_great_circles(head):
    text = swept(1.0, 20)[0].replace(b"G43.5", head.encode() + b"\nG43.5")
    assert (contour_of(text).shape.circle[1:] >= 0).all()
    assert (contour_of(swept(1.0, 20)[0], smoothing="off").shape.circle[1:] >= 0).all()


def test_a_turn_in_place_keeps_its_great_circle():
    """Its feed rate is that of the tool axis."""
    body = "G43.5\nG1 X0 Y0 Z50 I0.1 J0 K0.99498744\nI0.1 J0.0001 K0.99498743"
    assert contour_of(source(body)).shape.circle[-1] >= 0


def test_a_swing_that_turns_back_uses_the_axis_tolerance():
    """0.05 degrees are more, in mm of metric length, than 0.01 mm: rows are then not where the nearest pose by length
    is.
    """
    points = [
        "X0.0380 Y-0.1117 Z49.9943 I-0.000005 J0.017909 K0.999840",
        "X0.0760 Y-0.2233 Z50.0234 I-0.000009 J0.017431 K0.999848",
        "X0.1327 Y-0.3268 Z50.0111 I0.000010 J0.016340 K0.999866",
        "X0.1787 Y-0.4353 Z49.9995 I-0.000025 J0.014786 K0.999891",
        "X0.2482 Y-0.5306 Z50.0144 I-0.000070 J0.016638 K0.999862",
        "X0.3134 Y-0.6290 Z50.0121 I-0.000116 J0.018752 K0.999824",
    ]
    assert made(
        "\n".join(["G0 Z80 A1.086 C0", "G43.5 F12000", f"G1 {points[0]}", *points[1:]]), MACHINES["verne"], cycle=0.001
    ).values.size


# --- beside the pole of the table -------------------------------------------------------------------

NEAR_POLE = {
    "on both sides of it": ("G64 P0.009", "X0 Y0 I-0.0001 J0.0003 K1\nG1 X1 Y0 I0 J-0.0001 K1"),
    "on both sides of it, a wide tolerance": ("G64 P0.236", "X0 Y0 I-0.00003 J-0.00006 K1\nG1 X6 Y0 I0 J0.0002 K1"),
    "from beside it on": ("G64 P1", "X1 Y0 I0.00003 J0 K1\nG1 X0 Y0 I0.29 J0.3 K0.91"),
}


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("where", NEAR_POLE)
def test_vectors_beside_the_pole_are_passed_and_verified(name, where):
    """C turns far while the tool axis hardly moves: that is no other branch, and does not slow down what comes after
    it.
    """
    mode, body = NEAR_POLE[where]
    head = f"G21 G90 G94 G17 {mode}\nG43.5 H1 G0 X0 Y0 Z0 I0 J0 K1\nF3000\nG1 "
    result = convert(f"{head}{body}\nM2\n".encode(), MACHINES[name], options())
    assert result.ok, [item.message for item in result.findings]
    assert result.summary.cycle_time < 5.0
