"""What words mean on the machine: start pose, tool length, machine coordinates, work offsets, senses, stops.

Expectations are worked out here with rotation matrices, from the definition of machine coordinates
``m = Rx(A) (rotary_offset + Rz(C) p_gauge) - rotary_offset - machine_zero``.
"""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

import verne_post
from verne_post import check
from verne_post.app.assemble import assemble, build_interpreter_setup, view_moves_plainly
from verne_post.config.load import build_machine
from verne_post.config.machine_paths import list_machine_files
from verne_post.gcode.read import interpret_program
from verne_post.model.findings import InputError
from verne_post.model.moves import ZERO9
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool, WorkOffset

ZERO_HEIGHT = 550.0  # machine_zero of the default machine file, over the rotary centre
TOOLS = {1: Tool(1, 1, (0.0, 0.0, 60.0, *ZERO9[3:])), 2: Tool(2, 2, (0.0, 0.0, 90.0, *ZERO9[3:]))}


# --- the definition, by hand ----------------------------------------------------------------------


def rx(degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def rz(degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def tool_axis(a, c):
    """From tip to spindle, in the table frame."""
    a, c = math.radians(a), math.radians(c)
    return np.array([math.sin(a) * math.sin(c), math.sin(a) * math.cos(c), math.cos(a)])


def machine_coordinates(tip, a, c, length, rotary_offset=(0, 0, 0), machine_zero=(0, 0, ZERO_HEIGHT)):
    """X Y Z of the gauge line; tip in the table frame, degrees in workpiece sense."""
    gauge = np.asarray(tip, dtype=float) + length * tool_axis(a, c)
    return rx(a) @ (np.asarray(rotary_offset) + rz(c) @ gauge) - rotary_offset - machine_zero


def tip_at(machine_point, a, c, length, rotary_offset=(0, 0, 0), machine_zero=(0, 0, ZERO_HEIGHT)):
    """Inverse of :func:`machine_coordinates`."""
    inner = rx(a).T @ (np.asarray(machine_point, dtype=float) + rotary_offset + machine_zero) - rotary_offset
    return rz(c).T @ inner - length * tool_axis(a, c)


# --- the code under test ---------------------------------------------------------------------------


def poses(path):
    """Start poses, end poses as x, y, z in the table frame, A and C in degrees, workpiece sense."""
    scale = np.array([1, 1, 1, math.degrees(1), math.degrees(1)])
    return path.start * scale, path.end * scale


def read(source, machine, **options):
    """(path, start poses, end poses) of a program on a machine."""
    path = assemble(source.encode(), machine, Options(**options)).path
    return (path, *poses(path))


def refusals(source, machine, **options):
    """Findings of a refused program as (code, line)."""
    with pytest.raises(InputError) as caught:
        assemble(source.encode(), machine, Options(**options))
    return [(item.code, item.line) for item in caught.value.findings if item.code != "VP033"]


def near(*values):
    return pytest.approx(values, abs=1e-6)


@pytest.fixture(scope="session")
def variant():
    """Build the default machine with groups of its file changed: ``variant(a_positive='"tool"', home=None)``."""
    text = list_machine_files()["verne"].read_text("utf-8")

    def build(home="", **keys):
        changed = text
        for key, value in keys.items():
            changed, n = re.subn(rf"(?m)^{key} = [^#\n]*", f"{key} = {value} ", changed)
            assert n == 1
        if home is None:
            changed, n = re.subn(r"(?ms)^\[home\].*?(?=^\[)", "", changed)
            assert n == 1
        return build_machine(changed.encode(), "changed.toml")

    return build


# --- where the program starts --------------------------------------------------------------------

#: program (tool length 60) -> first pose, lines that really move
STARTS = {
    "everything named at once": ("G0 X40 Y-30 Z100 A30 C20\nZ50\nM2", (40, -30, 100, 30, 20), [2]),
    "height first": ("G0 Z50\nX40 Y-30\nZ10\nM2", (40, -30, 50, 0, 0), [3]),
    "one axis after the other": ("G0 Z50\nA0\nX40\nC5\nY-30\nZ10\nM2", (40, -30, 50, 0, 5), [6]),
    "G53 Z0": ("G53 G0 Z0\nX40 Y-30\nZ10\nM2", (40, -30, ZERO_HEIGHT - 60, 0, 0), [3]),
    "G28 G91 Z0": ("G28 G91 Z0\nG90 G0 X40 Y-30\nZ10\nM2", (40, -30, ZERO_HEIGHT - 60, 0, 0), [3]),
    "G30 G91 X0 Y0 Z0": ("G91 G30 X0 Y0 Z0\nG90 G0 X40 Y-30\nZ10\nM2", (0, 0, ZERO_HEIGHT - 60, 0, 0), [2, 3]),
    "G28 of everything": ("G28\nG90 G0 X40 Y-30\nM2", (0, 0, ZERO_HEIGHT - 60, 0, 0), [2]),
    "axes never named": ("G0 Z50\nX40 Y-30\nG1 F100 X50\nM2", (40, -30, 50, 0, 0), [3]),
    "only X ever named": ("G0 X40\nX50\nM2", (40, 0, 0, 0, 0), [2]),
    "letters in comments name nothing": ("(A30 C20)\nG0 X40 Y-30 Z50 ;A5\nZ60\nM2", (40, -30, 50, 0, 0), [3]),
    "letters after the end name nothing": ("G0 X40 Y-30 Z50\nZ60\nM2\nA30 C20\n", (40, -30, 50, 0, 0), [2]),
    "a height kept through a turn of the table": ("G0 Z50\nC90\nX40 Y-30\nZ60\nM2", (40, -30, 50, 0, 90), [4]),
    "work offset before the first motion": (
        "G10 L2 P1 X10 Y20 Z-500\nG0 X40 Y-30 Z50 A0 C0\nZ60\nM2", (50, -10, 100, 0, 0), [3],
    ),
    "C of a work offset": ("G10 L2 P1 C25 Z-550\nG0 X1 Y2 Z50 A0 C10\nZ60\nM2", (1, 2, 50, 0, 35), [3]),
    "G10 names no axis": ("G10 L2 P1 X0 Y0 Z-550 A0 C0\nG0 X40 Y-30\nZ5\nM2", (40, -30, 5, 0, 0), []),
    "inches": ("G20 G0 Z2\nX1 Y-1\nZ1\nM2", (25.4, -25.4, 50.8, 0, 0), [3]),
}  # fmt: skip


@pytest.mark.parametrize("name", STARTS)
def test_start_pose(machine, name):
    source, first, lines = STARTS[name]
    if not lines:
        source, lines = source.replace("\nM2", "\nX41\nM2"), [source.count("\n") + 1]
    path, start, _end = read(source, machine, tool_length=60.0)
    assert path.line.tolist() == lines
    assert start[0] == near(*first)
    assert path.first_pose[:3] == near(*first[:3])


@pytest.mark.parametrize("opening", ["G53 G0 Z0", "G28 G91 Z0\nG90", "G90 G53 G0 Z0\nG53 Z0", "G91 G30 Z0\nG90 G0"])
@pytest.mark.parametrize(("a", "c"), [(30, 20), (-45, 100), (80, 0), (0, 50)])
def test_an_opening_retract_fixes_machine_z_also_under_tilt(machine, opening, a, c):
    path, start, end = read(f"{opening}\nG0 X40 Y-30 A{a} C{c}\nZ10\nM2", machine, tool_length=60.0)
    last = opening.count("\n") + 3
    assert path.line.tolist() == [last]  # everything before is of zero length
    assert start[0, [0, 1, 3, 4]] == near(40, -30, a, c)
    assert machine_coordinates(start[0, :3], a, c, 60)[2] == pytest.approx(0.0, abs=1e-6)
    assert end[0] == near(40, -30, 10, a, c)


def test_an_axis_that_is_never_named_is_zero_in_the_first_active_system(machine):
    source = "G55\nG0 X40 Y-30 Z50 C10\nZ60\nM2"
    _path, start, _end = read(source, machine, tool_length=60.0, wcs={2: WorkOffset((1.0, 2.0, 3.0), 30.0)})
    x, y = rz(30)[:2, :2] @ [40, -30]
    assert start[0] == near(1 + x, 2 + y, 53, 0, 10 - 30)
    source = source.replace(" C10", "")
    _path, start, _end = read(source, machine, tool_length=60.0, wcs={2: WorkOffset((1.0, 2.0, 3.0), 30.0)})
    assert start[0] == near(1 + x, 2 + y, 53, 0, -30)


def test_blocks_that_are_deleted_name_nothing(machine):
    source = "/G0 A0 C0\nG0 X40 Y-30 Z50\nZ60\nM2"
    _path, start, _end = read(source, machine, tool_length=60.0, block_delete=True)
    assert start[0] == near(40, -30, 50, 0, 0)


@pytest.mark.parametrize(("source", "wanted"), [
    ("G91 G0 X5\nG90 X1 Y1 Z50\nZ60\nM2", ("VP013", 1)),
    ("G0 X1 Z50\nG91 Y5\nM2", ("VP013", 2)),
    ("G0 X1 Y1 Z50 A0\nG91 C5\nM2", ("VP013", 2)),
    ("G0 X1 Y1\nF9 G2 X2 I.5\nG0 Z50\nM2", ("VP013", 2)),
    ("G92 X0\nG0 X1 Y1 Z50\nM2", ("VP013", 1)),
    ("G0 X1 Y1\nG10 L20 P1 Z5\nG0 Z50\nM2", ("VP013", 2)),
    ("G91 G28 Z5\nG90 G0 X1 Y1\nM2", ("VP013", 1)),
])  # fmt: skip
def test_positions_must_be_known(machine, source, wanted):
    assert refusals(source, machine, tool_length=60.0) == [wanted]


def test_errors_before_and_after_the_first_pose_are_reported_together(machine):
    """All findings, not the first: also where the opening lines have some."""
    source = "G0 X1 X2\nG0 X0 Y0 Z50 A0 C0\nQ1\nG12\nM2"
    assert refusals(source, machine, tool_length=60.0) == [("VP004", 1), ("VP006", 3), ("VP002", 4)]


def test_no_motion(machine):
    assert refusals("G0 X0 Y0 Z50\nM2", machine) == [("VP021", None)]


# --- tool length ------------------------------------------------------------------------------------

HERE = "G0 X0 Y0 Z200 A0 C0\n"

#: program, options, wanted finding
LENGTHS_REFUSED = {
    "H without a table": (HERE + "G43 H1\nM2", {}, ("VP012", 2)),
    "G43 without a tool": (HERE + "G43\nM2", {"tools": TOOLS}, ("VP012", 2)),
    "H that the table lacks": (HERE + "G43 H3\nM2", {"tools": TOOLS}, ("VP012", 2)),
    "T that the table lacks": ("T3\n" + HERE + "X1\nM2", {"tools": TOOLS}, ("VP012", 1)),
    "feed before any length": (HERE + "X1\nG1 X2 F100\nM2", {"tools": TOOLS}, ("VP012", 3)),
    "arc before any length": (HERE + "G2 I5 F100\nM2", {}, ("VP012", 2)),
    "G10 L1 alone says no length": (HERE + "G10 L1 P1 Z60\nG1 X2 F100\nM2", {}, ("VP012", 3)),
    "T1 M6 alone says no length": ("T1 M6\n" + HERE + "G1 X2 F100\nM2", {"tools": TOOLS}, ("VP012", 3)),
    "a retracted head to Z": ("G53 G0 Z0\nG1 X2 Y3 Z5 F100\nM2", {"tools": TOOLS}, ("VP012", 2)),
    "a retracted head that turns": ("G53 G0 Z0\nG0 A0 C0\nG1 X2 C30 F100\nM2", {"tools": TOOLS}, ("VP012", 3)),
    "a retracted head on an arc": ("G53 G0 Z0\nG0 X0 Y0\nG2 I5 F100\nM2", {"tools": TOOLS}, ("VP012", 3)),
    "a retracted head beside a tilted table": (
        "G53 G0 Z0\nG0 A30 C0\nG1 X2 Y3 F100\nM2", {"tools": TOOLS}, ("VP012", 3),
    ),
    "a head that is down again": ("G53 G0 Z0\nG0 Z200\nG1 X2 Y3 F100\nM2", {"tools": TOOLS}, ("VP012", 3)),
    "G43.1 X": (HERE + "G43.1 X1 Z60\nM2", {}, ("VP007", 2)),
    "G43.1 A": (HERE + "G43.1 A1\nM2", {}, ("VP007", 2)),
    "a tool with X": (HERE + "G10 L1 P1 X1 Z60\nG43 H1\nM2", {}, ("VP007", 3)),
    "--tool-length with two tools": ("T1 M6\nT2 M6\n" + HERE + "X1\nM2", {"tool_length": 60.0}, ("VP018", 2)),
    # length changes under tilt
    "feed after a change": ("G0 X0 Y0 Z200 A30 C0\nX1\nG43 H1\nG1 X2 F100\nM2", {"tools": TOOLS}, ("VP016", 4)),
    "arc after a change": ("G0 X0 Y0 Z200 A30 C0\nX1\nG43 H1\nG2 I5 F100\nM2", {"tools": TOOLS}, ("VP016", 4)),
    "G91 after a change": ("G0 X0 Y0 Z200 A30 C0\nX1\nG43 H1\nG91 X2\nM2", {"tools": TOOLS}, ("VP016", 4)),
    "G53 G1 after a change": ("G0 X0 Y0 Z200 A30 C0\nX1\nG43 H1\nG53 G1 F9 Z0\nM2", {"tools": TOOLS}, ("VP016", 4)),
    # motion of zero length is motion: the axes have been named with the old length
    "feed on the first pose": ("G0 X0 Y0 Z200 A30 C0\nG43 H1\nG1 X2 F9\nM2", {"tools": TOOLS}, ("VP016", 3)),
    # BUG: accepted when no axis but those of the last G53, G28 or G30 has been named (X Y Z count as such)
    "feed where G53 has turned the table": (
        "G0 X0 Y0 Z200 A0 C0\nG53 G0 Z0 A30 C0\nG43 H1\nG1 X2 F9\nM2", {"tools": TOOLS}, ("VP016", 4),
    ),
    "G91 where G53 has turned the table": (
        "G0 X0 Y0 Z200 A0 C0\nG53 G0 Z0 A30 C0\nG43 H1\nG91 X2\nM2", {"tools": TOOLS}, ("VP016", 4),
    ),
    "G91 on the first pose": ("G0 X0 Y0 Z200 A30 C0\nG43 H1\nG91 X2\nM2", {"tools": TOOLS}, ("VP016", 3)),
    "feed after G49": ("G43.1 Z60\nG0 X0 Y0 Z200 A30 C0\nX1\nG49\nG1 X2 F100\nM2", {}, ("VP016", 5)),
    "feed with the table upside down": (
        "G0 X0 Y0 Z200 A180 C0\nX1\nG43 H1\nG1 X2 F9\nM2", {"tools": TOOLS}, ("VP016", 4),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", LENGTHS_REFUSED)
def test_tool_lengths_that_are_refused(machine, name):
    source, options, wanted = LENGTHS_REFUSED[name]
    assert refusals(source, machine, **options) == [wanted]


def test_a_tilt_of_the_start_is_explained_by_the_line_that_names_a_first(machine):
    head = "G0 X0 Y0 Z200\nG49 G81 X1 Y1 Z190 R195 F100\nG80\n"
    with pytest.raises(
        InputError, match="A is named first in line 4, so the program starts with A 30: name A and C before line 2"
    ):
        assemble((head + "G0 A30 C0\nG1 X5\nM2").encode(), machine, Options())
    assemble((head + "G0 A0 C0\nG1 X5\nM2").encode(), machine, Options())
    unset = "T1 M6\nG43 H1\n" + head.replace("G49 ", "") + "G0 A30 C0\nG1 X5\nM2"
    assert refusals(unset, machine) == [("VP012", 2), ("VP017", 4)]  # a missing length does not hide it
    with pytest.raises(InputError) as caught:  # the program tilts itself
        assemble(("G0 A30 C0\n" + head + "M2").encode(), machine, Options())
    assert "named first" not in str(caught.value)


def test_a_tilt_of_the_start_is_explained_in_a_subprogram_too(machine):
    """The holes of a label behind the end of the program said nothing of the line that tilts the start."""
    program = (
        "BEGIN PGM T MM\nTOOL CALL 1 Z S900 F300\nL X+9 Y+9 Z+200 R0 FMAX M3\n"
        "CYCL DEF 200 D Q200=2 Q201=-5 Q206=100 Q202=5 Q210=0 Q203=0 Q204=20 Q211=0\nCALL LBL 1\n{}\nSTOP M30\n"
        "LBL 1\nL X+5 FMAX M99\nLBL 0\nEND PGM T MM\n"
    )
    options = Options(dialect="heidenhain", tools=TOOLS, split_at_stops=True)
    with pytest.raises(
        InputError, match="A is named first in line 6, so the program starts with A 30: name A and C bef"
    ):
        assemble(program.format("L A+30 C+0 R0 FMAX").encode(), machine, options)
    assemble(program.format("L A+0 C+0 R0 FMAX").encode(), machine, options)


def test_a_tilt_of_the_start_is_explained_by_the_plane_that_turns_a_first():
    """Line 8 names no A: PLANE ... TURN turns it. A pocket was drilled."""
    program = (
        "BEGIN PGM T MM\nTOOL CALL 1 Z S900\nL Z-5 R0 FMAX M91\nL X+0 Y+0 R0 FMAX M3\n"
        "CYCL DEF 251 P Q215=0 Q218=40 Q219=30 Q220=9 Q368=0 Q224=0 Q367=0 Q207=900 Q351=1 Q201=-6 Q202=3 Q369=0 "
        "Q206=300 Q338=0 Q200=2 Q203=0 Q204=50 Q370=0.9 Q366=0 Q385=500\nCYCL CALL\nL Z+100 FMAX\n"
        "PLANE SPATIAL SPA+0 SPB+25 SPC+0 TURN FMAX SEQ- TABLE ROT ; not A+25\nL X+0 Y+0 Z+60 FMAX\n"
        "PLANE RESET STAY\nM30\nEND PGM T MM\n"
    )
    tools = {1: Tool(1, 1, (0.0, 0.0, 90.0, *(0.0,) * 6), 16.0)}
    with pytest.raises(InputError) as caught:
        assemble(program.encode(), verne_post.load_machine("hexapod"), Options(dialect="heidenhain", tools=tools))
    (item,) = caught.value.findings
    assert (item.code, item.line) == ("VP017", 6)
    assert item.message.startswith("cycle 251 mills along Z, but the tool points along")
    assert "; line 8 turns A, so the program starts with A -25: name A and C before line 6" in item.message


def test_what_follows_from_an_unknown_radius_is_no_error_of_its_own(machine):
    """After APPR without a radius DEP was told to lack RL; the tool, called by its name, had a number."""
    program = (
        'BEGIN PGM T MM\nTOOL CALL "D10" Z S900 F300\nL X+60 Y-20 Z+200 A+0 C+0 R0 FMAX M3\n'
        "APPR LCT X+30 Y-20 R3 RL F500\nL X+30 Y+20\nL X-30 Y+20\nDEP LCT X-60 Y+30 R3\nM30\nEND PGM T MM\n"
    )
    with pytest.raises(InputError) as caught:
        assemble(program.encode(), machine, Options(dialect="heidenhain", tool_length=80.0))
    (item,) = (one for one in caught.value.findings if one.severity == "error")
    assert (item.code, item.line) == ("VP012", 4)
    assert item.message.startswith('the radius of tool "D10" is not known')


@pytest.mark.parametrize(
    ("language", "program", "line"),
    [
        ("heidenhain", "TOOL CALL 5 Z S900 F300 DR+0.05\nL X-20 Y-20 Z+5 A+0 C+0 R0 FMAX M3\nL X+0 RL F800\nL Y+10", 3),
        ("fanuc", "G10 L13 P5 R0.05\nT5 M6\nS900 M3\nG0 G90 G21 G43 H5 X-20. Y-20. Z5.\nG41 D5 G1 X0. F800\nY10.", 1),
    ],
)
def test_wear_is_not_the_radius_of_a_tool_whose_radius_is_not_known(machine, language, program, line):
    """DR+0.05, and 0.05 of G10 L13, were taken for the whole radius: a tool of 10 mm would have cut 5 mm too deep."""
    known = Tool(5, 5, (0.0, 0.0, 80.0, *ZERO9[3:]), 10.0)
    end = "M30" if language == "fanuc" else "L X+30\nM30"
    text = f"{program}\n{end}\n".encode()
    for diameter, keys in ((0.0, {("tools", "5", "diameter")}), (10.0, set())):
        options = Options(dialect=language, tools={5: replace(known, diameter=diameter)})
        found = [item for item in check(text, machine, options).findings if item.severity == "error"]
        assert {key for item in found for key in item.settled_by} == keys
        assert [item.line for item in found if item.code == "VP012"][:1] == ([line] if keys else [])


def test_a_register_of_wear_may_be_cleared_before_the_tool_is_measured(machine):
    moves = interpret_program(
        b"G21 G90\nG10 L13 P1 R0\nG10 L11 P9 R0\nG43 H1 G0 X5. Y0 Z90.\nM30\n",
        build_interpreter_setup(machine, Options(dialect="fanuc", tools=TOOLS)),
    )
    assert moves.frames[moves.frame[-1]].tool[2] == 60.0


def test_the_remedies_are_named(machine):
    with pytest.raises(InputError, match=r"--tool-table.*--tool-length.*G49"):
        assemble((HERE + "G1 X2 F100\nM2").encode(), machine, Options())
    with pytest.raises(InputError, match=r"--tool-table.*--tool-length.*where the program has one tool"):
        assemble((HERE + "G43 H7\nM2").encode(), machine, Options())


def test_a_table_that_hinders_a_retracted_head_is_named(machine):
    source = "G53 G0 Z0\nG1 X2 Y3 F100\nG43 H1 Z50\nG1 X5\nG0 A30 C0\nG1 X9\nM2"
    with pytest.raises(InputError, match=r"with the table at A 30, .*turn to A0 before"):
        assemble(source.encode(), machine, Options(tools=TOOLS))


def test_a_retracted_head_goes_to_x_and_y_at_feed_before_any_length(machine):
    """As posts write it that replace G0: no length alters the way of a head that stays at its height."""
    source = "G53 G0 Z0\nT1 M6\n{0} X10 Y-5{1}\n{0} X40 Y35{1}\nG0 G43 Z16 H1\nG1 Z1 F300\nM2"
    path, start, end = read(source.format("G1", " F5000"), machine, tools=TOOLS)
    rapid, first, last = read(source.format("G0", ""), machine, tools=TOOLS)
    found = check(source.format("G1", " F5000"), machine, Options(tools=TOOLS, split_at_stops=True)).findings
    assert "VP034" not in [item.code for item in found]  # it comes down with a length
    assert np.array_equal(start, first)
    assert np.array_equal(end, last)
    assert end[0, :2] == near(40, 35)
    assert path.feed_time[0] == pytest.approx(50.0 / 5000.0 * 60.0)  # 30 and 40 mm: 50 mm at 5000 mm/min
    assert rapid.feed_time[0] == 0.0


#: program, options, tool length of each segment
LENGTHS = {
    "rapids before count 0": (HERE + "X1\nG43 H1\nX2\nG1 X3 F9\nM2", {"tools": TOOLS}, [0, 60, 60]),
    "G49 says 0": (HERE + "G49\nG1 X2 F100\nM2", {}, [0]),
    "the tool in the spindle": ("T2 M6\n" + HERE + "G43\nG1 X2 F100\nM2", {"tools": TOOLS}, [90]),
    "G43.4 H": (HERE + "G43.4 H2\nG1 X2 F100\nM2", {"tools": TOOLS}, [90]),
    "G10 L1 without a table": ("G10 L1 P7 Z33\n" + HERE + "G43 H7\nG1 X2 F100\nM2", {}, [33]),
    "G10 L1 over a table": ("G10 L1 P1 Z33\n" + HERE + "G43 H1\nG1 X2 F100\nM2", {"tools": TOOLS}, [33]),
    "G43.1": ("G43.1 Z12.5\n" + HERE + "G1 X2 F100\nM2", {}, [12.5]),
    "G43.1 in inches": ("G20 G43.1 Z1\n" + HERE + "G1 X2 F100\nM2", {}, [25.4]),
    "--tool-length is the length": (
        HERE + "X1\nG43 H1\nX2\nG49\nX3\nG43.1 Z5\nG1 F9 X4\nM2", {"tool_length": 77.0}, [77, 77, 77, 77],
    ),
    "--tool-length ignores the table": (HERE + "G43 H1\nG1 F9 X4\nM2", {"tool_length": 77.0, "tools": TOOLS}, [77]),
    "--tool-length with one tool twice": ("T1 M6\nT1 M6\n" + HERE + "G1 F9 X4\nM2", {"tool_length": 77.0}, [77]),
    "--tool-length and an empty spindle": ("T1 M6\nT0 M6\n" + HERE + "G1 F9 X4\nM2", {"tool_length": 77.0}, [77]),
    "two tools one after the other": (
        HERE + "G43 H1\nX1\nG43 H2\nX2\nG1 X3 F9\nM2", {"tools": TOOLS}, [60, 90, 90],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", LENGTHS)
def test_tool_lengths(machine, name):
    source, options, lengths = LENGTHS[name]
    path, start, end = read(source, machine, **options)
    moving = path.line > source[: source.index("X0 Y0 Z200")].count("\n") + 1
    assert path.tool_length[moving].tolist() == lengths
    # where the length changes the gauge line stands still
    for i in range(1, len(path)):
        before = end[i - 1, :3] + path.tool_length[i - 1] * tool_axis(*end[i - 1, 3:])
        assert start[i, :3] + path.tool_length[i] * tool_axis(*start[i, 3:]) == near(*before)


#: what follows a change from no tool to one of 60 mm at X0 Y0 Z200 A C20 -> end of that motion, tip and angles
AFTER_A_CHANGE = {
    "G0 Z150": lambda a, c: (0, 0, 150, a, c),
    "G0 X5": lambda a, c: (5, 0, 200, a, c),
    "G0 X5 Y6 Z7": lambda a, c: (5, 6, 7, a, c),
    "G0 A0 C0": lambda a, c: (0, 0, 200, 0, 0),
    "G53 G0 Z0": lambda a, c: (*tip_at([*machine_coordinates((0, 0, 200), a, c, 0)[:2], 0], a, c, 60), a, c),
    "G28 G91 Z0": lambda a, c: (*tip_at([*machine_coordinates((0, 0, 200), a, c, 0)[:2], 0], a, c, 60), a, c),
    "G28": lambda a, c: (0, 0, ZERO_HEIGHT - 60, 0, 0),
}


@pytest.mark.parametrize("word", ["G43 H1", "G43.4 H1", "G43.1 Z60", "G10 L1 P1 Z60\nG43 H1", "G43 H2\nG43 H1"])
@pytest.mark.parametrize("a", [0.0, 30.0, -60.0])
@pytest.mark.parametrize("after", AFTER_A_CHANGE)
# the second and third opening are of zero length
@pytest.mark.parametrize("opening", ["G0 X0 Y0 Z190 A{} C20\nZ200", "G0 X0 Y0 Z200 A{} C20", "G0 A{} C20\nZ200\nX0 Y0"])
def test_a_length_may_change_in_the_air_before_an_absolute_rapid(machine, opening, word, after, a):
    """Axes that the rapid does not name keep their programmed values, not those that the change gave them."""
    wanted = list(AFTER_A_CHANGE[after](a, 20.0))
    if a == 0.0 and "Z" not in after.split("X")[-1] and after != "G28":
        wanted[2] = 140.0  # at A = 0 it is a plain shift of Z, as on any control
    source = f"{opening.format(a)}\n{word}\n{after}\nG90 G0 X3\nM2"
    path, start, end = read(source, machine, tools=TOOLS)
    assert (path.tool_length[0] == 0.0) == ("190" in opening)
    i = int(np.argmax(path.tool_length > 0))
    assert start[i] == near(*(np.array([0, 0, 200]) - 60 * tool_axis(a, 20)), a, 20)
    assert end[i] == near(*wanted)
    assert path.tool_length[i] == 60.0


@pytest.mark.parametrize("word", ["G1 F100 Z30", "G91 G0 Z-110", "G91 G1 F9 Z-110", "G19 G90.1 G2 F9 Z30 Y0 J0 K85"])
def test_with_a_zero_anything_may_follow_a_change(machine, word):
    path, start, end = read(f"G0 X0 Y0 Z190 A0 C20\nZ200\nG43 H1\n{word}\nM2", machine, tools=TOOLS)
    assert path.line.tolist() == [2, 4]
    assert start[1] == near(0, 0, 140, 0, 20)
    assert end[1] == near(0, 0, 30, 0, 20)


def test_a_change_follows_a_change_of_work_offset(machine):
    """Programmed values that are kept follow G54 ... but not the tool."""
    source = "G10 L2 P2 X7 Z-540\nG0 X0 Y0 Z190 A30 C0\nZ200\nG43 H1\nG55\nG0 Y1\nM2"
    _path, _start, end = read(source, machine, tools=TOOLS)
    assert end[-1] == near(0, 1, 200, 30, 0)


@pytest.mark.parametrize(("a", "c"), [(0, 30), (20, 30), (-35, 0)])
def test_the_length_is_given_on_the_way_down(machine, a, c):
    """What CAM systems post: retract, turn the table, position, then G43 together with the height."""
    source = f"G53 G0 Z0\nG0 A{a} C{c}\nX40 Y-30\nG43.4 Z60 H2\nG1 X50 F100\nM2"
    path, start, end = read(source, machine, tools=TOOLS)
    assert path.line.tolist() == [4, 5]
    assert machine_coordinates(path.first_pose[:3], a, c, 0)[2] == pytest.approx(0.0, abs=1e-6)
    assert start[0, :3] + 90 * tool_axis(a, c) == near(*path.first_pose[:3])
    assert end[0] == near(40, -30, 60, a, c)
    assert end[1] == near(50, -30, 60, a, c)


@pytest.mark.parametrize("retract", ["G28 G91 Z0\nG90", "G53 G0 Z0"])
@pytest.mark.parametrize(("a", "c"), [(0, 30), (20, 30), (-35, 0)])
def test_the_length_is_given_at_the_retract(machine, retract, a, c):
    """Z stands at machine Z 0 and was never programmed, so there is no programmed value to go back to."""
    source = f"{retract}\nG0 A{a} C{c}\nG43.4 H2\nG0 X40 Y-30\nZ60\nG1 X50 F100\nM2"
    path, start, end = read(source, machine, tools=TOOLS)
    last = retract.count("\n") + 5
    assert path.line.tolist() == [last, last + 1]
    assert start[0, [0, 1, 3, 4]] == near(40, -30, a, c)
    assert machine_coordinates(start[0, :3], a, c, 90)[2] == pytest.approx(0.0, abs=1e-6)
    assert end[0] == near(40, -30, 60, a, c)


@pytest.mark.parametrize("first", ["G1 X0 Y0 Z200 A30 C0 F1000", "G0 X0 Y0 Z200\nG1 A30 C0 F1000"])
def test_a_length_given_before_any_motion_changes_nothing(machine, first):
    """The rule for changes under tilt is about changes after motion has begun."""
    path, _start, _end = read(f"T1 M6\nG43 H1\n{first}\nG0 X10\nM2", machine, tools=TOOLS)
    assert path.line[-1] == first.count("\n") + 4
    assert set(path.tool_length) == {60.0}


# --- machine coordinates ------------------------------------------------------------------------------


@pytest.mark.parametrize("offset", [(0, 0, 0), (3, -40, 25)])
@pytest.mark.parametrize("zero", [(0, 0, 550), (10, -20, 480)])
@pytest.mark.parametrize(("word", "named"), [
    ("G53 G0 Z0", {2: 0}), ("G53 G0 Z-100", {2: -100}), ("G53 G0 X5 Y6", {0: 5, 1: 6}), ("G53 G1 F9 X5", {0: 5}),
    ("G53 G0 A0 C0", {3: 0, 4: 0}), ("G53 G0 C-50 Z-20", {2: -20, 4: -50}), ("G91 G28 Z0", {2: 0}),
    ("G28 G91 X0 Y0", {0: 0, 1: 0}),
])  # fmt: skip
def test_machine_coordinates(variant, offset, zero, word, named):
    """Named axes go to their machine coordinates, the others keep theirs, in the frame of the nominal machine."""
    machine = variant(rotary_offset=list(map(float, offset)), machine_zero=list(map(float, zero)))
    path, start, end = read(f"G0 X40 Y-30 Z60 A30 C20\nZ70\n{word}\nM2", machine, tool_length=60.0)
    assert path.line.tolist() == [2, 3]
    before = [*machine_coordinates((40, -30, 70), 30, 20, 60, offset, zero), 30, 20]
    wanted = [named.get(axis, value) for axis, value in enumerate(before)]
    assert start[1] == near(40, -30, 70, 30, 20)
    assert [*machine_coordinates(end[1, :3], *end[1, 3:], 60, offset, zero), *end[1, 3:]] == near(*wanted)
    if set(named) == {2}:  # a move of Z alone runs along the tool axis
        assert np.cross(end[1, :3] - start[1, :3], tool_axis(30, 20)) == near(0, 0, 0)


def test_g53_takes_out_offsets_and_length(machine):
    source = "G10 L2 P1 X10 Y20 Z-500 R30\nG0 X0 Y0 Z100 A0 C0\nG92 X5\nG53 G0 X1 Y2 Z3\nM2"
    _path, _start, end = read(source, machine, tool_length=60.0)
    assert end[-1] == near(1, 2, 3 + ZERO_HEIGHT - 60, 0, 0)


def test_homes_of_the_machine_file(variant):
    machine = variant(g28="[1.0, 2.0, -30.0, 0.0, 40.0]", g30="[0.0, 0.0, -50.0, 10.0, 0.0]")
    source = "G0 X0 Y0 Z100 A0 C0\nG28 Z120\nG30\nG28\nM2"
    path, _start, end = read(source, machine, tool_length=60.0)
    assert path.line.tolist() == [2, 2, 3, 4]
    assert end[0] == near(0, 0, 120, 0, 0)
    assert end[1] == near(0, 0, -30 + ZERO_HEIGHT - 60, 0, 0)
    assert end[2] == near(*tip_at((0, 0, -50), 10, 0, 60), 10, 0)
    assert end[3] == near(*tip_at((1, 2, -30), 0, 40, 60), 0, 40)


@pytest.mark.parametrize("word", ["G28", "G30", "G28 G91 Z0", "G30 X1"])
def test_homes_are_refused_without_a_home(variant, word):
    assert refusals(f"G0 X0 Y0 Z100 A0 C0\n{word}\nM2", variant(home=None), tool_length=60.0) == [("VP015", 2)]


# --- work offsets ------------------------------------------------------------------------------------

PART = "G0 X40 Y-30 Z60 A30 C20\nG1 X10 Y5 Z20 A-10 C200 F500\nG2 X30 Y5 I10 Z25 A0\nG18 G3 X10 I-10 C90\nG0 Z100\nM2"
ORIGIN, TURN = (10.0, 20.0, 30.0), 40.0


def on_table(program, origin=ORIGIN, turn=TURN):
    """Pose on the table of programmed X Y Z A C, workpiece sense."""
    x, y, z, a, c = program
    return (*(np.array(origin) + rz(turn) @ [x, y, z]), a, c - turn)


def test_wcs_is_what_it_says(machine):
    _path, start, end = read(PART, machine, tool_length=60.0, wcs={1: WorkOffset(ORIGIN, TURN)})
    assert start[0] == near(*on_table((40, -30, 60, 30, 20)))
    assert end[0] == near(*on_table((10, 5, 20, -10, 200)))
    assert end[-1] == near(*on_table((10, 5, 100, 0, 90)))


def test_the_tool_axis_in_the_part_does_not_depend_on_the_part_turn(machine):
    _path, start, _end = read(PART, machine, tool_length=60.0, wcs={1: WorkOffset(ORIGIN, TURN)})
    assert rz(TURN).T @ tool_axis(*start[0, 3:]) == near(*tool_axis(30, 20))


@pytest.mark.parametrize(("a_sense", "c_sense"), [(1, 1), (-1, 1), (1, -1), (-1, -1)])
def test_wcs_equals_g10(variant, a_sense, c_sense):
    """``--wcs o, c`` is ``G10 L2 X Y Z R c C -c``; o counts from the table, the words from machine zero."""
    words = {1: '"workpiece"', -1: '"tool"'}
    machine = variant(a_positive=words[a_sense], c_positive=words[c_sense])
    given, *_ = read(PART, machine, tool_length=60.0, wcs={1: WorkOffset(ORIGIN, TURN)})
    x, y, z = ORIGIN
    g10 = f"G10 L2 P1 X{x} Y{y} Z{z - ZERO_HEIGHT} R{TURN} C{-c_sense * TURN}\n"
    written, *_ = read(g10 + PART, machine, tool_length=60.0)
    assert written.line.tolist() == (given.line + 1).tolist()
    for name in ("start", "end", "feed_time", "length"):
        assert getattr(written, name) == pytest.approx(getattr(given, name), abs=1e-9), name
    for name in ("center", "e1", "e2", "rise", "r0", "sweep"):
        assert getattr(written.arcs, name) == pytest.approx(getattr(given.arcs, name), abs=1e-9), name
    assert len(given.arcs.sweep) == 2


def test_each_system_has_its_offset(machine):
    wcs = {number: WorkOffset((number, 0.0, 10.0 * number)) for number in range(1, 10)}
    systems = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"]
    source = "".join(f"{system} G0 X100 Y0 Z200 A0 C0\n" for system in systems)
    _path, start, end = read(source + "M2", machine, tool_length=60.0, wcs=wcs)
    assert [*start[:1, 0], *end[:, 0]] == near(*range(101, 110))
    assert [*start[:1, 2], *end[:, 2]] == near(*range(210, 300, 10))


def test_g10_overrides_wcs_from_its_line_on(machine):
    source = "G0 X0 Y0 Z100 A0 C0\nG10 L2 P1 X1 Z-550\nG0 X0 Y0 Z100\nM2"
    _path, start, end = read(source, machine, tool_length=60.0, wcs={1: WorkOffset(ORIGIN)})
    assert start[0] == near(10, 20, 130, 0, 0)
    assert end[0] == near(1, 20, 100, 0, 0)


@pytest.mark.parametrize("turn", [0.0, 40.0])
def test_g10_l20_under_tilt(machine, turn):
    """The place stays, its numbers become those of the block."""
    source = "G0 X40 Y-30 Z60 A30 C20\nG10 L20 P1 X1 Y2 Z3 A4 C5\nG0\nG0 X1 Y2 Z4 A4 C5\nM2"
    program = assemble(source.encode(), machine, Options(tool_length=60.0, wcs={1: WorkOffset(ORIGIN, turn)}))
    assert program.moves.end[1, [0, 1, 2, 3, 5]] == near(1, 2, 3, 4, 5)
    assert program.path.line.tolist() == [4]
    start, end = poses(program.path)
    assert start[0] == near(*on_table((40, -30, 60, 30, 20), turn=turn))
    assert end[0] - start[0] == near(0, 0, 1, 0, 0)


@pytest.mark.parametrize("word", ["G92 X1 Y2 Z3 A4 C5", "G52 X1 Z2 C3", "G54", "G59.3", "G10 L2 P1 X5 R20 C3", "G92.1"])
def test_changes_of_offset_move_nothing(machine, word):
    source = f"G0 X40 Y-30 Z60 A30 C20\nZ70\n{word}\nG91 G0 X0 Y0 Z0 A0 C0\nM2"
    path, _start, _end = read(source, machine, tool_length=60.0)
    assert path.line.tolist() == [2]


# --- senses -------------------------------------------------------------------------------------------

SENSED = """G10 L2 P2 A{5} C{7} Z-500
G53 G0 Z0
G0 X40 Y-30 A{30} C{20}
G1 Z60 F500
X50 A{-20} C{400}
G53 G0 Z-50 C{15}
G55 G0 X1 Y2 Z200 A{3} C{4}
G92 C{100} A{2}
G1 C{110} A{12}
G91 C{-5} A{1}
G90 G28
M2
"""


@pytest.mark.parametrize(("a_sense", "c_sense"), [(-1, 1), (1, -1), (-1, -1)])
def test_senses(machine, variant, a_sense, c_sense):
    """Words named by the tool's motion (ISO 841) are those of the workpiece with the other sign, everywhere."""
    words = {1: '"workpiece"', -1: '"tool"'}
    home = f"[0.0, 0.0, 0.0, {10.0 * a_sense}, {30.0 * c_sense}]"
    plain = variant(g28="[0.0, 0.0, 0.0, 10.0, 30.0]")
    other = variant(a_positive=words[a_sense], c_positive=words[c_sense], g28=home)
    sign = {"A": a_sense, "C": c_sense}
    program = re.sub(r"([AC])\{(-?\d+)\}", lambda m: f"{m[1]}{sign[m[1]] * int(m[2])}", SENSED)
    reference = re.sub(r"[{}]", "", SENSED)
    wcs = {1: WorkOffset((0.0, 0.0, 0.0)), 2: WorkOffset(ORIGIN, TURN)}
    one, *_ = read(reference, plain, tool_length=60.0, wcs=wcs)
    two, *_ = read(program, other, tool_length=60.0, wcs=wcs)
    assert two.line.tolist() == one.line.tolist()
    assert len(one) == 7
    for name in ("start", "end", "length", "feed_time"):
        assert getattr(two, name) == pytest.approx(getattr(one, name), abs=1e-9), name
    # and the same words mean something else there
    three, *_ = read(reference, other, tool_length=60.0, wcs=wcs)
    assert np.abs(three.end - one.end).max() > 0.1


@pytest.mark.parametrize(("a_sense", "c_sense"), [(1, 1), (-1, 1), (1, -1), (-1, -1)])
def test_the_sense_of_a_programmed_pose(variant, a_sense, c_sense):
    words = {1: '"workpiece"', -1: '"tool"'}
    machine = variant(a_positive=words[a_sense], c_positive=words[c_sense])
    source = "G0 X50 Y0 Z40 A30 C60\nZ41\nM2"
    _path, start, _end = read(source, machine, tool_length=60.0, wcs={1: WorkOffset(ORIGIN, TURN)})
    assert start[0] == near(*on_table((50, 0, 40, a_sense * 30, c_sense * 60)))


# --- axes that the machine lacks -------------------------------------------------------------------------


def test_the_same_lines_are_read_anew_for_another_machine(machine):
    """B is an axis of the one and none of the other: opening lines that were scanned before are not taken for both."""
    text = b"G0 X0 Y0 Z200\nG1 F100\nX5\nX6 B0\nX7 B1\nX8\nX9\nX10\nM2\n"
    setup = build_interpreter_setup(verne_post.load_machine("bc_trunnion"), Options(tool_length=60.0))
    assert interpret_program(text, setup).end[-1, 4] == 1.0
    with pytest.raises(InputError, match="B: VERNE has no such axis"):
        interpret_program(text, build_interpreter_setup(machine, Options(tool_length=60.0)))


@pytest.mark.parametrize("letter", "BUVW")
@pytest.mark.parametrize(
    "words",
    [
        "G0 {}1",
        "G0 X1 {}0",
        "G1 X1 {}1 F9",
        "G53 G0 {}0",
        "G28 {}0",
        "G92 {}0",
        "G52 {}1",
        "G10 L2 P1 {}5",
        "G10 L1 P1 {}5",
        "G43.1 {}5",
    ],
)
def test_axes_that_the_machine_lacks(machine, letter, words):
    source = f"G49 G0 X0 Y0 Z100 A0 C0\n{words.format(letter)}\nM2"
    assert refusals(source, machine) == [("VP011", 2)]
    assert view_moves_plainly(source.encode(), Options())[1] == ()


# --- stops for a person -----------------------------------------------------------------------------------

#: program, line of the refusal or None
STOPS = {
    "before motion": ("M0\nT1 M6\nM60\nM1\nG28 G91 Z0\nG90 G0 X0 Y0\nZ10\nM2", None),
    "after moves of zero length": ("G28 G91 Z0\nT1 M6\nM0\nG90 G0 X0 Y0\nM60\nZ10\nM2", None),
    "before the first motion on its line": ("G0 X0 Y0 Z50\nT1 M6 Z10\nM2", None),
    "M0 after motion": ("G0 X0 Y0 Z50\nZ10\nM0\nZ20\nM2", [3]),
    "M0 acts after the motion of its line": ("G0 X0 Y0 Z50\nZ10 M0\nZ20\nM2", [2]),
    "M60 after motion": ("G0 X0 Y0 Z50\nZ10\nM60\nZ20\nM2", [3]),
    "M6 after motion": ("G0 X0 Y0 Z50\nZ10\nT1 M6\nZ20\nM2", [3]),
    "M1 after motion": ("G0 X0 Y0 Z50\nZ10\nM1\nZ20\nM2", None),
    "every stop is named": ("T1 M6\nG0 X0 Y0 Z50\nZ10\nM0\nZ20\nM60\nM6\nM2", [4, 6, 7]),
    "M2 and M30 are no stops": ("G0 X0 Y0 Z50\nZ10 M30", None),
}  # fmt: skip


@pytest.mark.parametrize("name", STOPS)
def test_stops(machine, name):
    source, lines = STOPS[name]
    if lines is None:
        assert len(read(source, machine, tool_length=60.0)[0]) >= 1
    else:
        assert refusals(source, machine, tool_length=60.0) == [("VP014", line) for line in lines]


def test_optional_stops_stop_when_asked_for(machine):
    source, _lines = STOPS["M1 after motion"]
    assert refusals(source, machine, tool_length=60.0, optional_stop=True) == [("VP014", 3)]
    assert len(read(STOPS["before motion"][0], machine, tool_length=60.0, optional_stop=True)[0]) == 1


# --- a work system turned by R of G10 L2 -----------------------------------------------------------------


@pytest.mark.parametrize("part_turn", [0.0, 40.0])
@pytest.mark.parametrize(("word", "axis"), [("G91 G28 X0", 0), ("G91 G28 Y0", 1), ("G30 X20", 0), ("G91 G28 Y0 Z0", 1)])
def test_home_of_one_axis_stays_on_the_line_of_that_axis(variant, word, axis, part_turn):
    machine = variant(g28="[30, -20, 0, 0, 0]", g30="[30, -20, 0, 0, 0]")
    wcs = {1: WorkOffset((5.0, 7.0, 0.0), part_turn)}
    program = f"G49 G10 L2 P1 R25\nG0 X50 Y-10 Z120 A0 C0\n{word}\nM2"
    moves = assemble(program.encode(), machine, Options(dialect="rs274", wcs=wcs)).moves
    # home in the turned system, by hand: C0 turns the part so that X points R beside the machine's
    home = rz(-25) @ (np.array([30, -20, 0]) - rz(-part_turn) @ np.array([5, 7, 0]))
    wanted = [50.0, -10.0]
    wanted[axis] = home[axis]
    assert np.allclose(moves.end[-1, :2], wanted, rtol=0, atol=1e-9)
    if "Z" in word:
        assert moves.end[-1, 2] == pytest.approx(ZERO_HEIGHT)


@pytest.mark.parametrize(
    ("place", "word", "code"),
    [
        ("A20 C0", "G91 G28 X0", "VP017"),
        ("A0 C30", "G91 G28 Y0", "VP017"),
        ("A0 C30", "G91 G28 X0 Y0", None),
        ("A20 C30", "G91 G28 Z0", None),
        ("A20 C30", "G28", None),
    ],
)
def test_home_of_one_axis_of_a_turned_system_needs_an_upright_table(machine, place, word, code):
    program = f"G49 G10 L2 P1 R25\nG0 X50 Y-10 Z120 {place}\n{word}\nM2".encode()
    try:
        found = assemble(program, machine, Options(dialect="rs274")) and None
    except InputError as error:
        found = [(item.code, item.line) for item in error.findings]
    assert found == (code and [(code, 3)])


def test_feed_per_turn_under_g96_is_refused(machine):
    """Its feed rate would follow the distance from X0; by the minute G96 changes no motion."""
    head = b"G21 G90\nG96 S100 M3\nG0 X0 Y0 Z60 A0 C0\n"
    options = Options(tool_length=80.0, dialect="rs274")
    found = check(head + b"G95 F0.1\n" + b"G1 X1\nX2\nX3\nX4\n" * 9 + b"M2", machine, options).findings
    assert {(item.code, item.severity) for item in found if item.code != "VP033"} == {
        ("VP017", "error"),
        ("VP045", "warning"),
    }
    assert min(item.line for item in found if item.code == "VP017") == 5
    slow = interpret_program(head + b"F100\nG1 X1\nM2", build_interpreter_setup(machine, options))
    plain = interpret_program(
        head.replace(b"G96", b"G97") + b"F100\nG1 X1\nM2", build_interpreter_setup(machine, options)
    )
    assert (slow.end == plain.end).all()
    assert slow.feed[-1] == plain.feed[-1] == 100.0
