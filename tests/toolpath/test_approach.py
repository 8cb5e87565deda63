"""The approach from a known standstill: retract, turn, position, plunge, and nothing that is not needed."""

import re

import numpy as np
import pytest

from verne_post import InputError, load_machine
from verne_post.app.assemble import assemble
from verne_post.config import list_machine_files
from verne_post.model.moves import Frame
from verne_post.model.options import Options
from verne_post.model.toolpath import SegmentKind

from ..builders import axis_of

#: Joint values in mm and rad, positions in mm: two solutions of the same pose differ by 1e-12.
EXACT = 1e-9
TOOL = 50.0
PROGRAM = "G21 G90 G94 G61.1 F1200\nG0 X40 Y10 Z30 A20 C-15\nG1 X60\nG1 Y40 A35\nM2\n"
FIRST = (np.array([40.0, 10.0, 30.0]), np.radians([20.0, -15.0]))
LINE, JOINT = SegmentKind.LINE, SegmentKind.JOINT


@pytest.fixture(scope="module")
def offset_machine(tmp_path_factory):
    """A machine with every offset of the table and the spindle, A and C named by the tool's motion, and a bent home."""
    text = list_machine_files()["verne"].read_text(encoding="utf-8")
    for key, value in {
        "rotary_offset": "[12.0, -8.0, 35.0]",
        "machine_zero": "[3.0, -2.0, 520.0]",
        "nose_offset_mm": "42.0",
        "a_positive": '"tool"',
        "c_positive": '"tool"',
        "g28": "[30.0, -20.0, -5.0, 10.0, 40.0]",
    }.items():
        text, count = re.subn(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
        assert count == 1
    path = tmp_path_factory.mktemp("machine") / "offset.toml"
    path.write_text(text, encoding="utf-8")
    return load_machine(path)


def approached(machine, start, text=PROGRAM, **options):
    return assemble(text.encode(), machine, Options(tool_length=TOOL, approach=start, **options))


def ends(program):
    """Joint values at both ends of every segment, (n, 2, 5)."""
    n = len(program.path)
    joints = program.build_joint_path()
    return np.stack([joints.find_joints(np.arange(n), np.full(n, u)) for u in (0.0, 1.0)], axis=1)


def in_file_units(machine, q):
    return tuple(float(v) for v in q * [column.factor for column in machine.columns])


def machine_z(machine, pose):
    """Machine coordinate Z of a pose of the path (tip and nominal angles)."""
    frame = Frame(tool=(0.0, 0.0, TOOL, *(0.0,) * 6))
    coordinates = machine.coordinates
    return coordinates.map_to_machine(coordinates.map_from_table(pose[:3], pose[3:], frame), frame)[2]


def joints_at(machine, x, y, z, a_deg, c_deg):
    """Joint values over the table: gauge line at x, y, z of machine coordinates (file sense)."""
    frame = Frame(tool=(0.0, 0.0, TOOL, *(0.0,) * 6))
    position = np.array([x, y, z, a_deg, 0.0, c_deg, 0.0, 0.0, 0.0])
    tip, angles = machine.coordinates.map_to_table(machine.coordinates.map_to_program(position, frame), frame)
    q, _platform, ok = machine.five_axis.solve(tip, angles, TOOL)
    assert ok
    return q


@pytest.fixture(params=["machine", "offset_machine"])
def any_machine(request):
    return request.getfixturevalue(request.param)


@pytest.fixture
def program(any_machine):
    """From a low standstill with the table turned elsewhere: all four steps are needed."""
    start = joints_at(any_machine, -60.0, 25.0, -200.0, 10.0, 70.0)
    return approached(any_machine, in_file_units(any_machine, start)), start


# --- the four steps -------------------------------------------------------------------------------


def test_four_steps_then_the_program(any_machine, program):
    program, start = program
    path = program.path
    alone = assemble(PROGRAM.encode(), any_machine, Options(tool_length=TOOL)).path
    assert path.kind.tolist() == [LINE, JOINT, JOINT, LINE, LINE, LINE]
    assert path.line.tolist() == [0, 0, 0, 0, 3, 4]
    assert path.move.tolist() == [-1] * 4 + alone.move.tolist()
    assert path.section.tolist() == [0, 1, 2, 3, 4, 5]  # a standstill between any two steps
    assert path.joint.tolist() == [-1, 0, 1, -1, -1, -1]
    assert (path.feed_time[:4] == 0.0).all()  # rapids
    assert (path.length > 0.0).all()
    assert (path.tool_length == TOOL).all()
    np.testing.assert_array_equal(path.start[4:], alone.start)
    np.testing.assert_array_equal(path.end[4:], alone.end)
    assert ends(program)[0, 0] == pytest.approx(start, abs=EXACT)


def test_consecutive_segments_meet_in_joint_space(any_machine, program):
    q = ends(program[0])
    assert np.abs(q[1:, 0] - q[:-1, 1]).max() < EXACT


def test_the_retract_sections_along_the_tool_axis_to_machine_zero(any_machine, program):
    path = program[0].path
    step = path.end[0] - path.start[0]
    axis = axis_of(*path.start[0, 3:])
    assert step[3:] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert step[:3] == pytest.approx(200.0 * axis, abs=EXACT)
    assert machine_z(any_machine, path.end[0]) == pytest.approx(0.0, abs=EXACT)


def test_the_sliders_stand_still_while_the_table_turns(any_machine, program):
    program, _start = program
    q = ends(program)
    np.testing.assert_array_equal(q[1, 0, :3], q[1, 1, :3])
    assert np.abs(q[1, 0, 3:] - q[1, 1, 3:]).min() > 0.1
    u = np.linspace(0.0, 1.0, 50)
    along = program.build_joint_path().find_joints(np.full(50, 1), u)
    assert np.abs(along - (q[1, 0] + u[:, None] * (q[1, 1] - q[1, 0]))).max() < EXACT


def test_the_table_stands_still_while_the_spindle_is_positioned(any_machine, program):
    program, _start = program
    q = ends(program)
    np.testing.assert_array_equal(q[2, 0, 3:], q[2, 1, 3:])
    assert np.abs(q[2, 0, :3] - q[2, 1, :3]).max() > 1.0


def test_the_plunge_sections_along_the_first_poses_axis_from_machine_zero(any_machine, program):
    path = program[0].path
    tip, angles = path.first_pose[:3], path.first_pose[3:]
    sense = -1.0 if any_machine.columns[3].factor < 0 else 1.0
    assert angles == pytest.approx(sense * FIRST[1], abs=1e-12)
    assert path.end[3] == pytest.approx(path.first_pose, abs=EXACT)
    step = path.start[3, :3] - tip
    assert step == pytest.approx(np.linalg.norm(step) * axis_of(*angles), abs=EXACT)
    assert path.start[3, 3:] == pytest.approx(angles, abs=1e-12)
    assert machine_z(any_machine, path.start[3]) == pytest.approx(0.0, abs=EXACT)


def test_poses_of_the_joint_steps_are_where_the_machine_is(any_machine, program):
    """What a JOINT segment calls start and end are the poses at both ends, for checks and messages."""
    program, _start = program
    path, q = program.path, ends(program)
    for segment in (1, 2):
        for pose, joints in ((path.start[segment], q[segment, 0]), (path.end[segment], q[segment, 1])):
            tip, angles, ok = any_machine.five_axis.find_nominal_pose(joints, TOOL)
            assert ok
            assert pose == pytest.approx(np.concatenate([tip, angles]), abs=EXACT)
    assert path.joints.shape == (2, 2, 5)
    assert path.joints == pytest.approx(q[1:3], abs=EXACT)


# --- from home ------------------------------------------------------------------------------------


def test_from_home(any_machine):
    """From [home] g28, machine coordinates of the gauge line in the file's sense, to the first pose."""
    program = approached(any_machine, "home")
    q = ends(program)
    x, y, z, a, c = any_machine.home.g28
    assert q[0, 0] == pytest.approx(joints_at(any_machine, x, y, z, a, c), abs=EXACT)
    assert np.abs(q[1:, 0] - q[:-1, 1]).max() < EXACT
    plain = assemble(PROGRAM.encode(), any_machine, Options(tool_length=TOOL))
    assert q[-2, 0] == pytest.approx(ends(plain)[0, 0], abs=EXACT)
    # the default machine's home is at machine Z 0 already: nothing to retract; the other one's is 5 mm lower
    steps = [LINE, JOINT, JOINT, LINE] if z < 0 else [JOINT, JOINT, LINE]
    assert program.path.kind.tolist()[: len(steps)] == steps
    assert len(program.path) == len(steps) + 2


def test_home_must_be_in_the_file(tmp_path):
    text = list_machine_files()["verne"].read_text(encoding="utf-8")
    text = re.sub(r"(?ms)^\[home\].*?(?=^\[)", "", text)
    text = re.sub(r'(?m)^home = "assumed"\n', "", text)
    path = tmp_path / "homeless.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="home") as refused:
        approached(load_machine(path), "home")
    assert refused.value.findings[0].code == "VP015"


# --- steps that are not needed --------------------------------------------------------------------


def test_a_machine_over_the_first_pose_only_plunges(any_machine):
    program = approached(any_machine, "home")
    over = ends(program)[-3, 0]
    again = approached(any_machine, in_file_units(any_machine, over))
    assert again.path.kind.tolist() == [LINE, LINE, LINE]
    assert ends(again)[0, 0] == pytest.approx(over, abs=EXACT)
    assert again.path.section.tolist() == [0, 1, 2]


def test_a_machine_turned_but_not_positioned_skips_the_turn(any_machine):
    program = approached(any_machine, "home")
    turned = ends(program)[-4, 0]
    again = approached(any_machine, in_file_units(any_machine, turned))
    assert again.path.kind.tolist()[:-2] == [JOINT, LINE]


def test_a_machine_at_the_first_pose_goes_up_and_down(machine):
    """The approach knows no short cut through the part; from the first pose itself it retracts and comes back."""
    plain = assemble(PROGRAM.encode(), machine, Options(tool_length=TOOL))
    program = approached(machine, in_file_units(machine, ends(plain)[0, 0]))
    assert program.path.kind.tolist() == [LINE, LINE, LINE, LINE]
    np.testing.assert_allclose(program.path.start[0], program.path.end[1], rtol=0, atol=EXACT)


def test_a_machine_above_z_0_stays_at_its_height_for_the_turn(machine):
    start = joints_at(machine, -60.0, 25.0, 35.0, 10.0, 70.0)
    program = approached(machine, in_file_units(machine, start))
    assert program.path.kind.tolist()[:-2] == [JOINT, JOINT, LINE]
    q = ends(program)
    np.testing.assert_allclose(q[0, 1, :3], start[:3], rtol=0, atol=EXACT)
    assert machine_z(machine, program.path.start[2]) == pytest.approx(0.0, abs=EXACT)


def test_a_first_pose_above_z_0_is_not_passed_from_below(machine):
    """The spindle is positioned at the first pose's own height; there is nothing to plunge."""
    start = joints_at(machine, -60.0, 25.0, -100.0, 10.0, 70.0)
    text = PROGRAM.replace("Z30 A20", "Z540 A5")
    program = approached(machine, in_file_units(machine, start), text)
    assert machine_z(machine, program.path.first_pose) > 10.0
    assert program.path.kind.tolist()[:-2] == [LINE, JOINT, JOINT]
    q = ends(program)
    plain = assemble(text.encode(), machine, Options(tool_length=TOOL))
    assert q[2, 1] == pytest.approx(ends(plain)[0, 0], abs=EXACT)


def test_whole_turns_of_c_are_turned(machine):
    """C stays unwrapped: a first pose at C 705 is reached at 705, not at -15."""
    program = approached(machine, "home", PROGRAM.replace("C-15", "C705"))
    q = ends(program)
    assert np.degrees(q[0, 1, 4]) == pytest.approx(705.0)
    assert np.abs(q[1:, 0] - q[:-1, 1]).max() < EXACT


# --- what follows keeps its place -----------------------------------------------------------------


def test_dwells_and_arcs_of_the_program_keep_their_place(machine):
    text = PROGRAM.replace("G1 X60\n", "G1 X60\nG4 P0.5\nG3 X40 Y30 I-20 J0\n")
    plain = assemble(text.encode(), machine, Options(tool_length=TOOL)).path
    program = approached(machine, "home", text)
    path, steps = program.path, 3
    assert len(path) == len(plain) + steps
    assert path.dwell_section.tolist() == [section + steps for section in plain.dwell_section]
    assert path.dwell_seconds.tolist() == [0.5]
    assert path.arc.tolist() == [-1] * steps + plain.arc.tolist()
    assert path.section.tolist() == [0, 1, 2, *(plain.section + steps)]
    q, q_plain = ends(program), ends(assemble(text.encode(), machine, Options(tool_length=TOOL)))
    np.testing.assert_allclose(q[steps:], q_plain, rtol=0, atol=EXACT)


# --- refusals -------------------------------------------------------------------------------------


def test_sliders_that_close_nothing_are_refused(machine):
    with pytest.raises(InputError) as refused:
        approached(machine, (0.0, 5000.0, 0.0, 0.0, 0.0))
    assert [item.code for item in refused.value.findings] == ["VP018"]


@pytest.mark.parametrize("values", [(400.0, 400.0, 400.0), (400.0,) * 6])
def test_another_number_of_values_is_refused(machine, values):
    with pytest.raises(InputError, match="rho1,rho2,rho3,a,c") as refused:
        approached(machine, values)
    assert [item.code for item in refused.value.findings] == ["VP018"]


def test_a_first_pose_that_cannot_be_approached_is_refused(machine):
    """Out of reach also at machine Z 0: there is no place to plunge from."""
    text = PROGRAM.replace("X40 Y10", "X900 Y10").replace("X60", "X910")
    with pytest.raises(InputError, match="out of reach") as refused:
        approached(machine, "home", text)
    assert {item.code for item in refused.value.findings} <= {"VP018", "VP110"}
