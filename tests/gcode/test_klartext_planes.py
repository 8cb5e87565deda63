"""Klartext on the machine: tips and tool axes on the part against rotation matrices written down from the manuals'
rules.

The table of the nominal machine: A about x carries C about z carries the part; p_machine = Rx(A) Rz(C) p_part. The work
system lies 40 mm over the rotary centre, which lies on the tilt axis of verne.toml.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import verne_post
from verne_post.app.assemble import assemble, build_interpreter_setup, read_draft
from verne_post.gcode.read import interpret_program
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

ORIGIN = np.array([0.0, 0.0, 40.0])
LENGTH = 80.0
SAMPLES = Path(__file__).resolve().parents[2] / "gcode_samples"
HEAD = ["BEGIN PGM P MM", "TOOL CALL 1 Z S1000 F900", "L X+0 Y+0 Z+60 A+0 C+0 R0 FMAX"]


def rx(angle):
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def ry(angle):
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def rz(angle):
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def axis_of(a, c):
    """Tool axis on the part: the machine's z, turned back with the table."""
    return (rx(a) @ rz(c)).T @ [0, 0, 1]


@pytest.fixture(scope="module")
def options():
    tool = Tool(1, 1, (0.0, 0.0, LENGTH, *(0.0,) * 6), 8.0)
    return Options(tools={1: tool}, wcs={"G54": tuple(ORIGIN)}, dialect="heidenhain")


@pytest.fixture(scope="module")
def poses(machine, options):
    """Tips on the part and A, C (degrees) at the ends of the segments of statements after the head."""

    def run(*statements):
        text = "\n".join([*HEAD, *statements, "M30", "END PGM P MM"]).encode()
        path = read_draft(text, machine, options).path
        return path.end[:, :3] - ORIGIN, np.degrees(path.end[:, 3:])

    return run


@pytest.fixture(scope="module")
def findings(machine, options):
    def run(*statements):
        text = "\n".join([*HEAD, *statements, "M30", "END PGM P MM"]).encode()
        with pytest.raises(verne_post.InputError) as error:
            interpret_program(text, build_interpreter_setup(machine, options))
        return error.value.findings[0]

    return run


# --- planes ------------------------------------------------------------------------------------------------

POINT = np.array([7.0, -11.0, 13.0])
TO_POINT = "L X+7 Y-11 Z+13 FMAX"


@pytest.mark.parametrize(
    ("plane", "rotation"),
    [
        ("SPATIAL SPA+20 SPB+0 SPC+0", rx(20)),
        ("SPATIAL SPA+15 SPB-10 SPC+35", rz(35) @ ry(-10) @ rx(15)),
        ("EULER EULPR+40 EULNU+20 EULROT-30", rz(40) @ rx(20) @ rz(-30)),
        ("VECTOR BX+1 BY+0 BZ+0 NX+0 NY-0.34202014332566871 NZ+0.93969262078590843", rx(20)),
        ("POINTS P1X+1 P1Y+2 P1Z+3 P2X+6 P2Y+2 P2Z+3 P3X+0 P3Y+2.93969262078590843 P3Z+3.34202014332566871", rx(20)),
        ("RELATIV SPB+25", ry(25)),
        ("AXIAL A+25 C+40", (rx(25) @ rz(40)).T),
    ],
)
@pytest.mark.parametrize("move", ["MOVE FMAX", "TURN FMAX", "MOVE DIST15 F2000", "TURN MB7 FMAX"])
def test_planes(poses, plane, rotation, move):
    tips, angles = poses("CYCL DEF 7.1 X+3", "CYCL DEF 7.2 Y+4", f"PLANE {plane} {move}", TO_POINT)
    assert tips[-1] == pytest.approx([3, 4, 0] + rotation @ POINT, abs=1e-8)
    assert axis_of(*angles[-1]) == pytest.approx(rotation @ [0, 0, 1], abs=1e-9)


def test_maps_inside_and_outside_a_plane(poses):
    """Shift and rotation before the plane lie outside it, those after it inside; a mirror image inside too."""
    tips, angles = poses(
        "CYCL DEF 7.1 X+3",
        "CYCL DEF 10.1 ROT+30",
        "PLANE SPATIAL SPA+0 SPB+20 SPC+0 MOVE FMAX",
        "CYCL DEF 8.1 Y",
        "CYCL DEF 11.1 SCL0.5",
        TO_POINT,
    )
    assert tips[-1] == pytest.approx([3, 0, 0] + rz(30) @ ry(20) @ (POINT * [0.5, -0.5, 0.5]), abs=1e-8)
    assert axis_of(*angles[-1]) == pytest.approx(rz(30) @ ry(20) @ [0, 0, 1], abs=1e-9)


def test_line_0_of_cycle_8_ends_the_mirror_image_at_once(poses):
    tips, _angles = poses("CYCL DEF 8.0", "CYCL DEF 8.1 X", "CYCL DEF 8.0", TO_POINT)
    assert tips[-1] == pytest.approx(POINT, abs=1e-8)


def test_a_mirror_image_before_a_plane_mirrors_the_plane(poses):
    tips, angles = poses("CYCL DEF 8.1 X", "PLANE SPATIAL SPA+0 SPB+20 SPC+0 MOVE FMAX", TO_POINT)
    mirror = np.diag([-1, 1, 1])
    assert tips[-1] == pytest.approx(mirror @ ry(20) @ POINT, abs=1e-8)
    assert axis_of(*angles[-1]) == pytest.approx(mirror @ ry(20) @ [0, 0, 1], abs=1e-9)


@pytest.mark.parametrize(
    ("begin", "end"),
    [
        ("CYCL DEF 10.1 ROT+30", "CYCL DEF 10.1 ROT+0"),
        ("TRANS ROTATION ROT-40", "TRANS ROTATION RESET"),
        ("CYCL DEF 8.1 Y", "CYCL DEF 8.0"),
        ("TRANS MIRROR AXIS X", "TRANS MIRROR RESET"),
        ("CYCL DEF 11.1 SCL0.5", "CYCL DEF 11.1 SCL1"),
        ("TRANS SCALE SCL2", "TRANS SCALE RESET"),
    ],
)
def test_the_end_of_a_map_in_a_plane_takes_back_that_of_before(poses, begin, end):
    """A control has one rotation, one mirror image, one factor: the same plane without it puts the point as if it had
    never been."""
    plane = "PLANE SPATIAL SPA+20 SPB+0 SPC+0 MOVE FMAX"
    tips, angles = poses(begin, plane, end, plane, TO_POINT)
    assert tips[-1] == pytest.approx(rx(20) @ POINT, abs=1e-8)
    assert axis_of(*angles[-1]) == pytest.approx(rx(20) @ [0, 0, 1], abs=1e-9)
    tips, _angles = poses(begin, plane, end, "PLANE RESET MOVE FMAX", "CYCL DEF 10.1 IROT+90", TO_POINT)
    assert tips[-1] == pytest.approx(rz(90) @ POINT, abs=1e-8)


def test_relative_planes_add_up(poses):
    tips, _angles = poses(
        "PLANE SPATIAL SPA+20 SPB+0 SPC+0 STAY", "PLANE RELATIV SPC+30 STAY", "PLANE RELATIV SPB+10 MOVE FMAX", TO_POINT
    )
    assert tips[-1] == pytest.approx(rx(20) @ rz(30) @ ry(10) @ POINT, abs=1e-8)


@pytest.mark.parametrize(
    ("start", "sequence", "wanted"),
    [
        # the manual's table for SPATIAL SPB+45 on a machine whose rotary table C stands on a tilting table A
        ("C+0", "", (45, 90)), ("C+0", "SEQ+", (45, 90)), ("C+0", "SEQ-", (-45, -90)), ("C-105", "", (-45, -90)),
        ("C-105", "SEQ+", (45, 90)), ("C-105", "SEQ-", (-45, -90)), ("C-135", "SEQ+", (45, 90)),
    ],
)  # fmt: skip
def test_the_choice_of_axis_positions(poses, start, sequence, wanted):
    _tips, angles = poses(f"L A+0 {start} FMAX", f"PLANE SPATIAL SPA+0 SPB+45 SPC+0 MOVE FMAX {sequence}", TO_POINT)
    turned = np.round(angles[-1] - np.array(wanted), 6)
    assert turned[0] == 0
    assert turned[1] % 360 == 0
    assert abs(angles[-1, 1] - float(start[1:])) <= 270


def test_stay_and_the_computed_positions(poses):
    tips, angles = poses(
        "PLANE SPATIAL SPA+0 SPB+45 SPC+0 STAY",
        "L A+Q120 C+Q122 FMAX",
        TO_POINT,
    )
    assert angles[-1] == pytest.approx([45, 90])
    assert tips[-1] == pytest.approx(ry(45) @ POINT, abs=1e-8)


def test_cycle_19_is_a_plane_by_spatial_angles(poses):
    tips, angles = poses("CYCL DEF 19.1 A+15 B-10 C+35", "L A+Q120 C+Q122 FMAX", TO_POINT)
    assert tips[-1] == pytest.approx(rz(35) @ ry(-10) @ rx(15) @ POINT, abs=1e-8)
    assert axis_of(*angles[-1]) == pytest.approx(rz(35) @ ry(-10) @ rx(15) @ [0, 0, 1], abs=1e-9)


def test_cycle_19_that_positions_the_axes_is_plane_with_move(machine, options):
    """F and the set-up clearance in the cycle; all angles 0 bring the table back in the same way."""
    given = replace(options, control={"heidenhain": {"cycle_19": "moves"}})
    programs = [
        [
            "CYCL DEF 19.0 WORKING PLANE",
            "CYCL DEF 19.1 A+15 B-10 C+35 F2000 ABST25",
            TO_POINT,
            "CYCL DEF 19.1 A+0 B+0 C+0 FMAX SETUP25",
        ],
        ["PLANE SPATIAL SPA+15 SPB-10 SPC+35 MOVE DIST25 F2000", TO_POINT, "PLANE RESET MOVE DIST25 FMAX"],
    ]
    paths = [
        read_draft("\n".join([*HEAD, *text, "M30", "END PGM P MM"]).encode(), machine, given).path for text in programs
    ]
    np.testing.assert_allclose(paths[0].end, paths[1].end, atol=1e-9)
    stays = "\n".join([*HEAD, "CYCL DEF 19.1 A+15 B+0 C+0", "M30", "END PGM P MM"]).encode()
    with pytest.raises(verne_post.InputError, match="set-up clearance"):
        interpret_program(stays, build_interpreter_setup(machine, given))


def test_table_rot_turns_the_table(poses):
    """Both have the same tips on the part; with TABLE ROT the plane's X lies along X of the machine."""
    for kind, c in (("COORD ROT", 0.0), ("TABLE ROT", -30.0)):
        tips, angles = poses("L C+10 FMAX", f"PLANE SPATIAL SPA+0 SPB+0 SPC+30 TURN FMAX {kind}", TO_POINT)
        assert tips[-1] == pytest.approx(rz(30) @ POINT, abs=1e-8)
        assert angles[-1] == pytest.approx([0, c], abs=1e-9)


def test_move_holds_the_point_before_the_tip(poses):
    tips, angles = poses("PLANE SPATIAL SPA+0 SPB+40 SPC+0 MOVE DIST25 FMAX")
    start = np.array([0.0, 0.0, 60.0])
    for tip, (a, c) in zip(tips, angles, strict=True):
        assert tip - 25 * axis_of(a, c) == pytest.approx(start - [0, 0, 25], abs=1e-8)


# --- without tool-centre-point control -----------------------------------------------------------------------


def test_without_m128_coordinates_do_not_turn_with_the_table(poses, machine):
    assert np.allclose(machine.coordinates.rotary_offset[:2], 0)
    offset = machine.coordinates.rotary_offset
    tips, angles = poses("L A+20 C+30 FMAX", "L X+7 Y-11 Z+53 FMAX", "L Z+60 FMAX", "CC X+7 Y-1", "C X+7 Y+9 DR+ F300")

    def seen(tip):
        return (rx(20) @ rz(30)).T @ (np.asarray(tip) + ORIGIN + offset) - rz(30).T @ offset - ORIGIN

    for end, place in zip(tips[-3:], ([7, -11, 53], [7, -11, 60], [7, 9, 60]), strict=True):
        assert end == pytest.approx(seen(place), abs=1e-8)
    assert angles[-1] == pytest.approx([20, 30])


def test_a_turn_without_m128_leaves_the_machine_where_it_is(poses, machine):
    offset = machine.coordinates.rotary_offset
    tips, angles = poses("L X+40 Y+10 FMAX", "L A+30 C-60 FMAX")
    assert len(tips) == 2  # tests/toolpath/test_turns.py looks at the way between
    for tip, (a, c) in zip(tips[1:], angles[1:], strict=True):
        in_machine = rx(a) @ (offset + rz(c) @ (tip + ORIGIN)) - offset - ORIGIN
        assert in_machine == pytest.approx([40, 10, 60], abs=1e-8)


def test_m128_and_m129_change_the_meaning_of_coordinates_only(poses, machine):
    tips, _angles = poses("L A+20 C+30 FMAX", "M128", "L X+7 Y-11 Z+53 FMAX", "M129", "L X+7 Y-11 Z+53 FMAX")
    offset = machine.coordinates.rotary_offset
    assert tips[-2] == pytest.approx([7, -11, 53], abs=1e-8)
    seen = (rx(20) @ rz(30)).T @ (np.array([7, -11, 53]) + ORIGIN + offset) - rz(30).T @ offset - ORIGIN
    assert tips[-1] == pytest.approx(seen, abs=1e-8)


def test_feed_of_turns(machine, options):
    """A and C alone: degrees a minute; M116: mm a minute of the tip."""

    def seconds(*statements):
        text = "\n".join([*HEAD, "L X+50 FMAX", *statements, "M30", "END PGM P MM"]).encode()
        path = read_draft(text, machine, options).path
        return path.feed_time.sum()

    assert seconds("L C+90 F600") == pytest.approx(9.0)
    assert seconds("L A+30 C+40 F600") == pytest.approx(5.0)
    assert seconds("M116", "L C+90 F600") == pytest.approx(50 * np.pi / 2 / 10, rel=1e-3)


# --- tool vectors -----------------------------------------------------------------------------------------------


def test_ln_points_the_tool(poses):
    axis = np.array([0.2, -0.1, np.sqrt(0.95)])
    tips, angles = poses("M128", f"LN X+5 Y+6 Z+50 TX{axis[0]:+.9f} TY{axis[1]:+.9f} TZ{axis[2]:+.9f} F900")
    assert tips[-1] == pytest.approx([5, 6, 50], abs=1e-8)
    assert axis_of(*angles[-1]) == pytest.approx(axis, abs=1e-8)


def test_spatial_angles_of_tcpm(poses):
    _tips, angles = poses("FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS", "L X+5 Y+6 Z+50 A+10 B+20 C+30 F900")
    assert axis_of(*angles[-1]) == pytest.approx(rz(30) @ ry(20) @ rx(10) @ [0, 0, 1], abs=1e-8)


def test_retract_along_the_tool(poses):
    tips, angles = poses("M128", "L X+5 Y+6 Z+50 A+20 C+30 FMAX", "L M140 MB12")
    assert tips[-1] - tips[-2] == pytest.approx(12 * axis_of(*angles[-1]), abs=1e-8)


# --- shorter ways ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("statements", "c"),
    [
        (["L C+350 FMAX"], 350),
        (["M126", "L C+350 FMAX"], -10),
        (["M126", "L C+170 FMAX", "L C+200 FMAX"], 200),
        (["L C+400 FMAX", "M94", "L C+50 FMAX"], 410),
        (["L C+400 FMAX", "L C+50 FMAX"], 50),
        (["L C-20 FMAX", "M94", "L IC+50 FMAX"], 30),
        (["L C-20 FMAX", "M94 C", "M126", "L C+10 FMAX"], 10),
        (["L A-20 C+370 FMAX", "M94", "L A-30 C+50 FMAX"], 410),
    ],
)
def test_positions_of_c(poses, statements, c):
    _tips, angles = poses(*statements)
    assert angles[-1, 1] == pytest.approx(c)


# --- what is refused ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("statements", "words"),
    [
        (["PLANE SPATIAL SPA+20 SPB+0 SPC+0 STAY", "L X+5 FMAX"], "normal to"),
        (["PLANE SPATIAL SPA+20 SPB+0 SPC+0 STAY",
          "CYCL DEF 240 C Q200=2 Q343=0 Q201=-1 Q344=0 Q206=9 Q211=0 Q203=0 Q204=5", "CYCL CALL"],
         "cycle 240 in a tilted plane that the tool is not normal to"),
        (["CYCL DEF 7.0", "CYCL DEF 7.1 X+5", "PLANE SPATIAL SPA+20 SPB+0 SPC+0 MOVE FMAX",
              "CYCL DEF 7.0", "CYCL DEF 7.1 X+9"], "PLANE RESET first"),
        (["PLANE SPATIAL SPA+20 SPB+0 SPC+0 MOVE FMAX", "CYCL DEF 10.0", "CYCL DEF 10.1 ROT+9",
          "PLANE SPATIAL SPA+10 SPB+0 SPC+0 MOVE FMAX"], "write PLANE RESET between them, or reset it first"),
        (["LN X+5 TX+0 TY+0 TZ+1 F900"], "needs M128"),
    ],
)  # fmt: skip
def test_what_would_be_a_guess_is_refused(findings, statements, words):
    found = findings(*statements)
    assert found.code == "VP017"
    assert words in found.message
    assert found.line == len(HEAD) + len(statements)


def test_a_reset_without_its_move_ends_the_plane(machine, options):
    """The plane after it was an error too, which said to write the PLANE RESET that is there."""
    plane = "PLANE SPATIAL SPA+{} SPB+0 SPC+0 MOVE FMAX"
    shift = ["CYCL DEF 7.0", "CYCL DEF 7.1 X+5"]
    text = "\n".join([*HEAD, plane.format(20), *shift, "PLANE RESET", plane.format(10), "M30", "END PGM P MM"])
    with pytest.raises(verne_post.InputError) as error:
        interpret_program(text.encode(), build_interpreter_setup(machine, options))
    assert [(one.code, one.line) for one in error.value.findings] == [("VP005", len(HEAD) + 4)]


@pytest.mark.parametrize(
    ("before", "inside", "words"),
    [
        ("TRANS ROTATION ROT+30", ["TRANS ROTATION ROT+9"], "TRANS ROTATION RESET or PLANE RESET first"),
        ("TRANS ROTATION ROT+30", ["CYCL DEF 10.0", "CYCL DEF 10.1 IROT+9"], "a rotation in a tilted plane while"),
        ("TRANS MIRROR AXIS X", ["CYCL DEF 8.0", "CYCL DEF 8.1 Y"], "TRANS MIRROR RESET or PLANE RESET first"),
        ("TRANS MIRROR AXIS X", ["TRANS MIRROR AXIS X"], "TRANS MIRROR RESET or PLANE RESET first"),
        ("TRANS SCALE SCL2", ["TRANS SCALE SCL3"], "TRANS SCALE RESET or PLANE RESET first"),
        (
            "TRANS ROTATION ROT+30",
            ["TRANS ROTATION RESET", "L X+5 FMAX"],
            "write the plane again after the end of the rotation",
        ),
    ],
)
def test_a_second_map_in_a_plane_is_refused(findings, before, inside, words):
    found = findings(before, "PLANE SPATIAL SPA+20 SPB+0 SPC+0 MOVE FMAX", *inside)
    assert (found.code, found.line) == ("VP017", len(HEAD) + 2 + len(inside))
    assert words in found.message


@pytest.mark.parametrize("before", ["TRANS ROTATION ROT+30", "TRANS MIRROR AXIS Y"])
@pytest.mark.parametrize("plane", [["CYCL DEF 19.0", "CYCL DEF 19.1 A+20 B+0 C+0"], ["PLANE AXIAL A+20 C+0 TURN FMAX"]])
def test_planes_by_axes_after_a_rotation_or_mirror_image_are_refused(findings, before, plane):
    found = findings(before, *plane)
    assert (found.code, found.line) == ("VP017", len(HEAD) + 1 + len(plane))
    assert "does not act on the tilt" in found.message


@pytest.mark.parametrize(
    ("statement", "code"),
    [
        ("PLANE SPATIAL SPA+20 SPB+0 SPC+0 MOVE STAY FMAX", "VP006"),
        ("PLANE SPATIAL SPA+20 SPB+0 SPC+0 MOVE SEQ+ SEQ- FMAX", "VP006"),
        ("PLANE RESET STAY SEQ+", "VP006"),
        ("PLANE RESET TABLE ROT STAY", "VP006"),
        ("CYCL DEF 8.1 X X", "VP004"),
        ("M94 C C", "VP004"),
    ],
)
def test_words_that_contradict_or_repeat_each_other_are_refused(findings, statement, code):
    assert findings(statement).code == code


def test_headers_of_cam_systems(machine, options):
    """Retracts to the limit before any position is named; footers that take a shift back before they end the plane."""

    def path(*statements):
        text = "\n".join(["BEGIN PGM P MM", *statements, "M30", "END PGM P MM"]).encode()
        return read_draft(text, machine, options).path

    first = path("TOOL CALL 1 Z S900", "L M140 MB MAX", "L X+5 Y+6 FMAX", "L Z+30 FMAX")
    gauge = first.first_pose[2] + LENGTH
    assert gauge == pytest.approx(machine.coordinates.machine_zero[2])
    shift = ["CYCL DEF 7.0 SHIFT", "CYCL DEF 7.1 X{}", "CYCL DEF 7.2 Y{}", "CYCL DEF 7.3 Z{}"]
    end = path(
        *HEAD[1:],
        *(line.format(9) for line in shift),
        "PLANE SPATIAL SPA+20 SPB+0 SPC+0 TURN MB MAX FMAX",
        "L X+1 Y+1 Z+50 FMAX",
        *(line.format(0) for line in shift),
        "PLANE RESET STAY",
        "L A+0 C+0 FMAX",
        "L X+1 Y+2 Z+70 FMAX",
    )
    assert end.end[-1, :3] - ORIGIN == pytest.approx([1, 2, 70], abs=1e-8)


def test_holes_of_a_post_for_turning_tables(machine, options):
    """Head, labels, tool by name, datum from the table, plane with STAY and Q120: each hole by hand, 8 mm below a
    surface at -1.
    """
    control = {"heidenhain": {"tools": {"DRILL_5": 1}, "datums": {"2": [10.0, 0.0, -5.0]}}}
    raw = (Path(__file__).parents[1] / "corpus" / "heidenhain" / "planes.h").read_bytes()
    path = read_draft(raw, machine, replace(options, control=control)).path
    bottoms = [[10, 0, -5] + ry(30) @ [5, y, -9] for y in (0, -6)]
    tips = path.end[:, :3] - ORIGIN
    for bottom in bottoms:
        at = np.abs(tips - bottom).max(axis=1).argmin()
        assert tips[at] == pytest.approx(bottom, abs=1e-8)
        assert axis_of(*np.degrees(path.end[at, 3:])) == pytest.approx(ry(30) @ [0, 0, 1], abs=1e-9)
    plain = verne_post.convert(raw, machine, replace(options, control=control, cycle=0.01))
    assert plain.ok, plain.findings


def test_feed_per_turn_of_a_rotary_move_without_m128(machine):
    """60 degrees at 0.5 degrees a turn and 600 turns a minute: 12 s."""
    text = b"BEGIN PGM A MM\nTOOL CALL 1 Z S600\nL X+10 Y+0 Z+50 A+0 C+0 R0 FMAX M3\nM136\nL C+60 F0.5\nEND PGM A MM\n"
    program = assemble(text, machine, Options(tool_length=80.0, wcs={"G54": (0, 0, 60)}))
    assert program.path.feed_time.sum() == pytest.approx(12.0)
