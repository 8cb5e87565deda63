"""What moves while no tool length is in force: G49 or D0 under tilt, and turns of the table under a standing
spindle.
"""

import numpy as np
import pytest

import verne_post as vp
from tests.gcode.test_tails import joints_of_lines
from verne_post.app.assemble import assemble
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool, WorkOffset

ISO = "G21 G90 G17 G94\nT1 M6\nG54\nG0 A30. C40.\nG0 G43.4 H1 X10. Y0. Z50.\nG1 X20. F500.\n"
SIEMENS = "G54 G90 G71 G17 G94\nT1 M6\nD1\nG0 A30 C40\nTRAORI\nG0 X10 Y0 Z50\nG1 X20 F500\nTRAFOOF\nD0\n"
TOOLS = {1: Tool(1, 1, (0.0, 0.0, 80.0) + (0.0,) * 6, 10.0)}
#: Rounding of some matrix products of lengths up to 1,000 mm and angles.
ROUNDING = 1e-8


def options(dialect, **more):
    return Options(tools=TOOLS, wcs={1: WorkOffset((0, 0, 60))}, dialect=dialect, **more)


@pytest.mark.parametrize(
    ("dialect", "text", "why"),
    [
        ("rs274", f"{ISO}G49\nG0 X0. Y0.\nM30\n", "the programmed Z would lower the tool by its length; name Z"),
        # the spindle stands in these, so no Z is what is wrong
        ("fanuc", f"{ISO}G49\nG0 A0. C0.\nM30\n", "this turn would move the part past a tool that no check knows;"),
        ("fanuc", f"{ISO}G49 G0 A0.\nM30\n", "this turn would move the part past a tool that no check knows;"),
        ("siemens", f"{SIEMENS}G0 A0 C0\nM30\n", "this turn would move the part past a tool that no check knows;"),
    ],
)
def test_a_motion_without_z_is_refused(dialect, text, why):
    result = vp.check(text, vp.load_machine("serial"), options(dialect))
    [error] = [item for item in result.findings if item.severity == "error"]
    assert error.code == "VP016"
    assert f"with the table tilted (A 30 deg): {why}" in error.message
    assert error.message.endswith("retract in machine coordinates before")


@pytest.mark.parametrize("length", ["G43.4 H1", "G43.5 H1 I0.3214 J0.3830 K0.8660", "G43 H1", "G43.1 H1"])
@pytest.mark.parametrize("retract", ["G53 G0 Z0.", "G91 G28 Z0.\nG90"])
@pytest.mark.parametrize(
    "turn", ["G0 A0. C0.", "G0 A0.\nC0.", "G91 G0 A-30. C130.\nG90", "G1 A-5. C20. F400.", "G53 G0 A0. C0."]
)
def test_fanuc_turns_the_table_under_a_standing_spindle(length, retract, turn):
    """On the serial machine the joints are X Y Z themselves: after G49 they stand, from end to end of the turn."""
    if "I" in length and "G91 G0" in turn:
        turn = turn.replace("A-30. C130.", "A0. C10.")
    head = (
        "G21 G90 G17 G94\n"
        "T1 M6\n"
        "G54\n"
        f"G0 {'A30. C40.' if 'I' not in length else ''}\n"
        f"{length} G0 X10. Y0. Z50.\n"
        "G1 X20. F500.\n"
    )
    text = f"{head}{retract}\nG49\n{turn}\nG53 G0 X5. Y5.\nM30\n"
    program = assemble(text.encode(), vp.load_machine("serial"), options("fanuc", smoothing="off"))
    assert [item.code for item in program.findings if item.severity == "error"] == []
    joints = joints_of_lines(program)
    lines = text.splitlines()
    first = lines.index("G49") + 1
    before = joints[max(line for line in joints if line < first)]
    turned = [line for line in joints if first < line < lines.index("G53 G0 X5. Y5.") + 1]
    assert turned
    for line in turned:
        assert joints[line][:3] == pytest.approx(before[:3], abs=ROUNDING)
    if "G53" not in turn:
        result = vp.convert(text, vp.load_machine("serial"), options("fanuc", smoothing="off"))
        assert result.ok
        rows = np.isin(result.setpoints.line, turned)
        # a tenth of what verification allows: rows follow polynomials of the joints
        assert np.ptp(result.setpoints.values[rows, :3], axis=0) == pytest.approx([0.0] * 3, abs=1e-4)


def test_fanuc_stands_before_any_code_of_tool_length():
    """A head that has retracted turns the table to its first cut: the start holds, and no linear axis moves."""
    text = (
        "O1\nG21 G90 G49\nG53 G0 Z0.\nG0 A0. C0.\nG53 G0 X50. Y-50.\nT1 M6\nG54\nG0 A30. C40.\nG43.4 H1 X10. Y0. Z50.\n"
        "G1 X20. F500.\nM30\n"
    )
    program = assemble(text.encode(), vp.load_machine("serial"), options("fanuc", smoothing="off"))
    joints = joints_of_lines(program)
    assert joints[8] == pytest.approx([50.0, -50.0, 0.0, np.radians(30.0), np.radians(40.0)], abs=ROUNDING)


@pytest.mark.parametrize(
    ("block", "stays"), [("G0 X0. Y0. A0. C0.", [2]), ("G0 X7. A0. C10.", [1, 2]), ("G0 X0. Y0. A-30. C10.", [2])]
)
def test_fanuc_axes_that_a_turn_does_not_name_stand(block, stays):
    text = f"{ISO}G53 G0 Z0.\nG49\n{block}\nM30\n"
    program = assemble(text.encode(), vp.load_machine("serial"), options("fanuc", smoothing="off"))
    joints = joints_of_lines(program)
    assert joints[9][stays] == pytest.approx(joints[7][stays], abs=ROUNDING)
    named = [axis for axis in range(3) if axis not in stays]
    words = [float(word[1:]) for word in block.split() if word[0] in "XY"]
    assert program.moves.end[-1][named] == pytest.approx(words, abs=ROUNDING)


def test_fanuc_refuses_a_turn_under_which_the_named_axis_does_not_come():
    result = vp.check(f"{ISO}G53 G0 Z0.\nG49\nG0 X7. A0. C90.\nM30\n", vp.load_machine("serial"), options("fanuc"))
    ((code, text),) = [(item.code, item.message) for item in result.findings if item.severity == "error"]
    assert code == "VP017"
    assert "X in one block with a turn of the table" in text
    assert "Y and Z are not named and stand still in the machine" in text


def test_a_length_or_a_plane_in_force_holds_what_it_held():
    """With G43.4 the tip stays on the part; with G43 it does so where no code of the program says tool-centre-point
    control.
    """
    for length in ("G43.4 H1", "G43 H1"):
        text = f"G21 G90\nT1 M6\nG0 A30. C40.\n{length} X10. Y0. Z150.\nG1 Z140. F500.\nG0 A0. C0.\nM30\n"
        program = assemble(text.encode(), vp.load_machine("serial"), options("fanuc", smoothing="off"))
        assert program.path.end[-1, :3] == pytest.approx([10.0, 0.0, 200.0], abs=ROUNDING)


@pytest.mark.parametrize(
    ("tail", "found"),
    [
        ("G53 G0 Z0\nG49\nG0 A0 C0", [9]),
        ("G53 G0 Z0\nG49\nG0 A0 C0\nA20\nA0", [9]),
        ("G53 G0 Z0\nG49\nG0 X0 Y0 A0 C0", [9]),
        ("G53 G0 Z0\nG49\nG53 G0 A0 C0", []),
        ("G53 G0 Z0\nG0 A0 C0", [8]),
        ("G53 G0 Z0\nG49\nG0 X0 Y0 Z200 A0 C0", []),
        ("G91 G28 Z0\nG90\nX0 Y0 A0 C0\nA9", [9]),
        ("G53 G0 Z0\nG53 G0 A0 C0", []),
        ("G53 G0 Z0\nG0 X0 Y0 Z200\nA0 C0", []),
    ],
)
def test_rs274_names_axes_that_go_along(tail, found):
    """The tip is held there, also without a length: one warning, at the first turn, with the way of each axis."""
    result = vp.check(f"{ISO}{tail}\nM30\n", vp.load_machine("serial"), options("rs274"))
    assert [(item.line, item.code) for item in result.findings if item.code == "VP046"] == [
        (line, "VP046") for line in found
    ]
    if found == [9] and "X0" not in tail:
        (item,) = [item for item in result.findings if item.code == "VP046"]
        assert (
            "X+148.763 Y+215.579 Z-51.753 mm" in item.message
        )  # the serial machine's own joints: from X15.3 Y-43.9 Z0
        assert item.message.endswith('or write G53 in it, or read it as a Fanuc program (dialect="fanuc")')


def test_a_fanuc_program_is_told_what_keeps_the_axes_still():
    """G43 of the tool before is in force after a retract: what the warning names settles it."""
    machine = vp.load_machine("serial")
    for tail, warned in (("A20 C30", True), ("G49\nA20 C30", False), ("G53 A20 C30", False)):
        result = vp.check(f"{ISO}G53 G0 Z0\n{tail}\nM30\n", machine, options("fanuc"))
        found = [item.message for item in result.findings if item.code == "VP046"]
        assert len(found) == warned, tail
        if warned:
            assert found[0].startswith("G43.4 of line 5 is active and keeps the tip at its place of the part")
            assert "; write G49 before this line if the tool is done, else name X, Y and Z" in found[0]


@pytest.mark.parametrize(("block", "length", "warned"), [
    ("G1 X30. F500.", 120, True), ("G0 X30.", 120, True), ("G1 X30. F500.", 60, False),
    ("G1 X30. Z50. F500.", 120, False),
    ("G53 G0 Z0.", 120, False), ("G53 G0 Z0.\nG43.1 Z130.\nG1 X30. F500.", 120, False),
])  # fmt: skip
def test_a_longer_tool_goes_on_below_the_programmed_place(block, length, warned):
    """Under a level table the spindle stays where it is until Z is named: a longer tool is deeper by the difference."""
    text = f"G21 G90\nG43.1 Z80.\nG0 X10. Y0. Z50. A0. C0.\nG1 X20. F500.\nG43.1 Z{length}.\n{block}\nM30\n"
    result = vp.check(text, vp.load_machine("serial"), options("rs274"))
    found = [(item.line, item.message) for item in result.findings if item.code == "VP046"]
    assert [line for line, _ in found] == [6] * warned
    if warned:
        assert "the tip continues at Z10, 40 mm below the point that was programmed before; name Z" in found[0][1]


@pytest.mark.parametrize("tilt", [0, 20])
@pytest.mark.parametrize(
    ("dialect", "head", "second", "blocks"),
    [
        (
            "siemens",
            "G71 G90 G54\nT1 M6\nD1\nG0 X0 Y0 Z40 A{tilt} C0\nG1 X10 F500\n",
            "T2 M6\nD1\n",
            ("G0 X20", "G0 X20 Z40"),
        ),
        (
            "heidenhain",
            "BEGIN PGM B MM\n"
            "TOOL CALL 1 Z S5000\n"
            "L Z+40 R0 FMAX\n"
            "M128\n"
            "L X+0 Y+0 A+{tilt} C+0 R0 FMAX\n"
            "L X+10 R0 F500\n",
            "TOOL CALL 2 Z S5000\n",
            ("L X+20 R0 FMAX", "L X+20 Z+40 R0 FMAX"),
        ),
    ],
)
@pytest.mark.parametrize(("length", "named"), [(80.0, 0), (80.0, 1), (60.0, 0)])
def test_a_longer_tool_of_siemens_and_klartext_is_told(dialect, head, second, blocks, tilt, length, named):
    """As in RS274: the spindle stands until Z is named, also under a tilted table, so the tip is deeper; Z names it, a
    shorter tool is none.
    """
    tools = {1: Tool(1, 1, (0.0, 0.0, 60.0) + (0.0,) * 6, 10.0), 2: Tool(2, 2, (0.0, 0.0, length) + (0.0,) * 6, 10.0)}
    text = f"{head.format(tilt=tilt)}{second}{blocks[named]}\n{'END PGM B MM' if dialect == 'heidenhain' else 'M30'}\n"
    setup = Options(tools=tools, wcs={1: WorkOffset((0, 0, 60))}, dialect=dialect, split_at_stops=True)
    result = vp.check(text, vp.load_machine("serial"), setup)
    found = [item.line for item in result.findings if item.code == "VP046"]
    line = next(number for number, block in enumerate(text.splitlines(), start=1) if block == blocks[named])
    assert (result.ok, found) == (True, [line] * (length > 60.0 and not named))


def test_plain_lines_and_single_ones_stand_alike():
    """A stretch that is long enough to be read at once breaks at the turn of the table."""
    text = "O1\nG21 G90\nG53 G0 Z0.\nG0 X0. Y0. A0. C0.\n" + "".join(f"X{n}.\nA{n}.\n" for n in range(12)) + "M30\n"
    for dialect, moves in (("fanuc", False), ("rs274", True)):
        program = assemble(text.encode(), vp.load_machine("serial"), options(dialect, smoothing="off"))
        height = [q[2] for q in joints_of_lines(program).values()]
        assert (np.ptp(height) > 1.0) == moves
        assert any(item.code == "VP046" for item in program.findings) == moves


STANDING = [
    ("rs274", f"{ISO}G53 G0 Z0\nG53 G0 A-20 C200\nM30\n"),
    ("rs274", f"{ISO}G53 G0 Z0\nG91 G28 A0 C0\nM30\n"),
    ("fanuc", f"{ISO}G53 G0 Z0\nG53 A-20. C200.\nM30\n"),
    ("fanuc", f"{ISO}G53 G0 Z0\nG49\nG28 A-5. C20.\nM30\n"),
    ("siemens", f"{SIEMENS}G0 SUPA Z0\nG0 SUPA A-20 C200\nM30\n"),
    ("siemens", f"{SIEMENS}G0 SUPA Z0\nG0 A-20 C200\nM30\n"),
    ("siemens", f'{SIEMENS}G0 SUPA Z0\nCYCLE800(0,"",0,57,0,0,0,0,45,90,0,0,0,1)\nM30\n'),
    ("fanuc", f"{ISO}G49\nG53 G0 Z0\nG68.2 X0 Y0 Z0 I60. J35. K0\nG53.1\nM30\n"),
    ("fanuc", f"{ISO}G43 H1\nG53 G0 Z0\nG68.2 X0 Y0 Z0 I60. J35. K0\nG53.1\nM30\n"),
]


@pytest.mark.parametrize(("dialect", "text"), STANDING)
def test_the_spindle_stands_all_the_way_while_the_table_turns(dialect, text):
    """Also between the ends of the turn, where the tip goes on an arc of the part; A and C turn together."""
    result = vp.convert(text, vp.load_machine("serial"), options(dialect, smoothing="off"))
    assert result.ok, result.findings
    assert [item.code for item in result.findings if item.code == "VP301"] == []
    rows = result.setpoints.values[result.setpoints.line == text.count("\n") - 1]
    assert np.ptp(rows[:, 3:], axis=0).min() > 3.0
    assert np.ptp(rows[:, :3], axis=0) == pytest.approx([0.0] * 3, abs=1e-4)


def test_g53_1_under_tool_centre_point_control_holds_the_tip():
    text = f"{ISO}G0 Z150.\nG68.2 X0 Y0 Z0 I60. J35. K0\nG53.1\nM30\n"
    program = assemble(text.encode(), vp.load_machine("serial"), options("fanuc", smoothing="off"))
    assert program.path.end[-1, :3] == pytest.approx(program.path.start[-1, :3], abs=ROUNDING)
    assert np.ptp([program.path.start[-1, 3], program.path.end[-1, 3]]) > 0.01


LONGER = {
    number: Tool(number, number, (0.0, 0.0, length) + (0.0,) * 6, 10.0) for number, length in ((1, 80.0), (2, 130.0))
}
TILTED_ISO = "G21 G90\nG0 A30. C40.\nG43.4 H1 X10. Y0. Z150.\nX20.\n"
TILTED_SIEMENS = "G54 G90 G71\nG0 A30 C40\nT1 M6 D1\nTRAORI\nG0 X10 Y0 Z150\nX20\n"


@pytest.mark.parametrize(
    ("dialect", "text", "way"),
    [
        ("rs274", f"{TILTED_ISO}G43.4 H2\nG0 X30.\nM30\n", 50.0),
        ("fanuc", f"{TILTED_ISO}G43.4 H2\nG0 X30. Y5.\nM30\n", 50.0),
        ("fanuc", f"{TILTED_ISO}G43.4 H2\nG0 X30. Z150.\nM30\n", None),
        ("fanuc", f"{TILTED_ISO}G53 G0 Z0.\nG43.4 H2\nG0 X30.\nM30\n", None),
        ("rs274", "G21 G90\nG0 A30. C40.\nG43.4 H1\nG0 X10. Y0.\nZ150.\nX20.\nM30\n", None),
        ("siemens", f"{TILTED_SIEMENS}T2 M6 D1\nG0 X30\nM30\n", 50.0),
        ("siemens", f"{TILTED_SIEMENS}T2 M6 D1\nG0 Z150\nM30\n", None),
    ],
)
def test_a_longer_tool_under_tilt_is_named_where_the_spindle_goes_up(dialect, text, way):
    """The tip goes to the Z that was programmed: by 50 mm along the tool axis, where no retract came before."""
    setup = Options(
        tools=LONGER, wcs={1: WorkOffset((0, 0, 60))}, dialect=dialect, smoothing="off", split_at_stops=True
    )
    found = [
        item for item in assemble(text.encode(), vp.load_machine("serial"), setup).findings if item.code == "VP046"
    ]
    assert [item.line for item in found] == ([text.count("\n") - 1] if way else [])
    assert all("the spindle moves by" in item.message for item in found)


@pytest.mark.parametrize("block", ["G0 X30", "G0 A0 C0", "G0 Y7 A10"])
def test_siemens_axes_that_are_not_named_stand_after_another_length(block):
    text = f"{TILTED_SIEMENS}TRAFOOF\nT2 M6 D1\n{block}\nM30\n"
    setup = Options(
        tools=LONGER, wcs={1: WorkOffset((0, 0, 60))}, dialect="siemens", smoothing="off", split_at_stops=True
    )
    joints = joints_of_lines(assemble(text.encode(), vp.load_machine("serial"), setup))
    stays = [axis for axis in range(5) if "XYZAC"[axis] not in block]
    assert joints[9][stays] == pytest.approx(joints[6][stays], abs=ROUNDING)


CUT_ISO = "G21 G90 G17 G94\nT1 M6\nG54\nG53 G0 Z0.\nG0 A0. C0.\nG0 X10. Y0.\nG43 H1 Z50.\nG1 Z2. F500.\n"
CUT_SIEMENS = "G54 G90 G71 G17 G94\nT1 M6\nG0 SUPA Z0 D0\nG0 A0 C0\nG0 X10 Y0\nD1\nG0 Z50\nG1 Z2 F500\n"
CUT_KLARTEXT = (
    "BEGIN PGM B MM\nTOOL CALL 1 Z S5000\nL Z+0 M91 FMAX\nL A+0 C+0 R0 FMAX\nL X+10 Y+0 R0 FMAX\nL Z+50 R0 FMAX\n"
    "L Z+2 R0 F500\n"
)
UNDER, DOWN = "its tip goes 20 mm below the table face", "its tip goes down to Z-50"


@pytest.mark.parametrize(
    ("dialect", "text", "found"),
    [
        ("siemens", f"{CUT_SIEMENS}G0 Z0 D0\nM30\n", ("error", 9, UNDER)),
        ("siemens", f"{CUT_SIEMENS}G0 SUPA Z0\nG0 Z0 D0\nT1 M6 D1\nG0 Z30\nM30\n", ("error", 10, UNDER)),
        ("siemens", f"{CUT_SIEMENS}G0 SUPA Z0 D0\nG0 X20\nM30\n", None),
        ("fanuc", f"{CUT_ISO}G49 G0 Z0.\nM30\n", ("error", 9, UNDER)),
        ("fanuc", f"{CUT_ISO}G49 G0 Z30.\nG0 Z0.\nM30\n", ("error", 10, UNDER)),
        ("fanuc", f"{CUT_ISO}G49 G0 Z30.\nM30\n", ("warning", 9, DOWN)),
        ("rs274", f"{CUT_ISO}G49 G0 Z30.\nM30\n", ("warning", 9, DOWN)),
        ("fanuc", f"{CUT_ISO}G49 G0 Z90.\nM30\n", None),
        ("fanuc", f"{CUT_ISO}G49 G53 G0 Z0.\nM30\n", None),
        ("fanuc", f"{CUT_ISO}G49 G28 G91 Z0.\nG90\nM30\n", None),
        ("heidenhain", f"{CUT_KLARTEXT}TOOL CALL 0\nL Z+0 R0 FMAX\nEND PGM B MM\n", ("warning", 9, UNDER)),
        ("heidenhain", f"{CUT_KLARTEXT}TOOL CALL 0\nL Z+0 M91 FMAX\nEND PGM B MM\n", None),
    ],
)
def test_a_rapid_without_a_length_that_takes_the_tool_too_low_is_told(dialect, text, found):
    """The tool in the spindle is as long as before: 80 mm, over a part zero that is 60 mm above the table face."""
    result = vp.check(text, vp.load_machine("serial"), options(dialect, split_at_stops=True))
    told = [item for item in result.findings if item.code == "VP034"]
    assert [(item.severity, item.line) for item in told] == ([found[:2]] if found else [])
    if found is not None:
        assert found[2] in told[0].message
        word = {"siemens": "SUPA", "heidenhain": "M91"}.get(dialect, "G53")
        assert f"in machine coordinates ({word})" in told[0].message
    assert result.ok == (found is None or found[0] == "warning")


@pytest.mark.parametrize(("dialect", "tail", "line"), [
    ("fanuc", "G0 X10. Y0.", 8), ("fanuc", "G1 X10. Y0.", 8), ("fanuc", "T2 M6\nG0 X10. Y0.\nG43.4 H2 Z50.", 9),
    ("fanuc", "G0 A0. C0.\nX10. Y0.", None), ("fanuc", "G0 X10. Y0. A0. C0.", None), ("rs274", "G0 X10. Y0.", None),
    ("fanuc", "G43.4 H1 G0 X10. Y0. Z50.\nX20.", None), ("fanuc", "G53 G0 X10. Y0.", None),
])  # fmt: skip
def test_x_and_y_by_a_cancelled_length_under_a_tilted_table_are_told(dialect, tail, line):
    """A control moves X and Y of the machine alone there; RS274/NGC cancels no length."""
    setup = Options(
        tools=LONGER, wcs={1: WorkOffset((0, 0, 60))}, dialect=dialect, smoothing="off", split_at_stops=True
    )
    text = f"{ISO}G53 G0 Z0.\n{tail}\nM30\n"
    found = assemble(text.encode(), vp.load_machine("serial"), setup).findings
    told = [item for item in found if item.code == "VP037"]
    assert [(item.line, item.severity) for item in told] == ([(line, "warning")] if line else [])
    assert all(
        "and G53, G28 or G30 has cancelled the tool length: they are read as points" in item.message for item in told
    )
    assert not any(item.edits for item in told)


def test_x_and_y_by_a_restored_length_hold_the_tip():
    setup = options("fanuc", smoothing="off", control={"fanuc": {"length_after_return": "restored"}})
    text = f"{ISO}G53 G0 Z0.\nG0 X10. Y0.\nM30\n"
    found = assemble(text.encode(), vp.load_machine("serial"), setup).findings
    assert [item.code for item in found if item.code == "VP037"] == []
