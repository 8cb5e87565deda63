"""Where programs start: heads as CAM systems write them, first places that are not plain moves; cuts before A and C are
named (VP036).
"""

import math
from pathlib import Path

import numpy as np
import pytest

from tests.builders import check_unplanned
from tests.gcode.heads import DIALECTS, HEADS, LENGTH, MOVES, PART_HEIGHT, program
from verne_post import gcode
from verne_post.app.assemble import assemble, build_interpreter_setup
from verne_post.model.findings import InputError
from verne_post.model.moves import ZERO9, MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

TOOLS = {1: Tool(1, 1, (0.0, 0.0, LENGTH, *ZERO9[3:]), diameter=10.0)}
PAGE = Path(__file__).parents[2] / "docs" / "starts.md"
XYZAC = [0, 1, 2, 3, 5]
#: Rounding of some matrix products of lengths up to 1,000 mm.
ROUNDING = 1e-6

RS274 = """G21 G90 G0 X0 Y0
G43 H1 Z30
G1 Z3 F600
X20
{end}
M2"""


def warned(source, machine, **options):
    """Line and text of every VP036."""
    options = {"tool_length": 60.0, "wcs": {"G54": (0.0, 0.0, 60.0)}} | options
    findings = assemble(source.encode(), machine, Options(**options)).moves.findings
    return [(item.line, item.message) for item in findings if item.code == "VP036"]


@pytest.mark.parametrize(
    ("end", "words"),
    [
        ("G0 Z60\nG0 A30 C45", "A and C: assumed to start at A30 C45, as line 6 says"),
        ("G0 Z60\nG0 A0 C45", "C: assumed to start at C45, as line 6 says"),
        ("G0 Z60\nG0 A-10\nG0 C0", "A: assumed to start at A-10, as line 7 says"),
        ("G1 A12 C0", "A: assumed to start at A12, as line 5 says"),
    ],
)
def test_the_first_cut_before_a_or_c_is_named(machine, end, words):
    ((line, text),) = warned(RS274.format(end=end), machine)
    assert line == 3
    assert words in text


@pytest.mark.parametrize(
    ("end", "a", "c", "stands"),
    [
        ("G0 Z60\nG0 A15 C0", 0, 0, "A0"),
        ("G0 Z60\nG0 A15 C30", 0, 0, "A0 C0"),
        ("G0 Z60\nG0 A15 C30", 15, 0, "C0"),
        ("G0 Z60\nG0 A15 C30", 15, -330, ""),
        ("G0 Z60\nG0 A15 C0", 15, 90, ""),  # of C, named before or at 0, nothing was assumed
    ],
)
def test_the_approach_does_not_turn_the_table_for_cuts_that_do_not_name_it(machine, end, a, c, stands):
    """--from home turned the table to the angle of a later plane, and a level contour was milled tilted."""
    options = Options(
        tool_length=60.0, wcs={"G54": (0.0, 0.0, 60.0)}, approach=(264.0, 210.0, 210.0, float(a), float(c))
    )
    found = [item for item in check_unplanned(RS274.format(end=end), machine, options).findings if item.code == "VP036"]
    assert [(item.severity, item.line) for item in found] == [("error" if stands else "warning", 3)]
    assert (f"; approach has {stands}, and the table" in found[0].message) == bool(stands)


@pytest.mark.parametrize("end", ["G0 Z60", "G0 Z60\nG0 A0 C0", "G0 Z60\nG0 A0 C0\nG0 A30 C45"])
def test_a_table_that_stands_at_0_needs_no_words(machine, end):
    assert warned(RS274.format(end=end), machine) == []


@pytest.mark.parametrize(
    "head",
    [
        "G21 G90 G0 X0 Y0 A30 C45\nG0 Z30\nG1 Z3 F600",
        "G21 G90 G0 X0 Y0 Z30\nG0 A30 C45\nG1 Z3 F600",
        "G21 G90 G0 X0 Y0 Z30\nG1 A30 C45 F600\nZ3",
    ],
)
def test_a_cut_after_both_are_named_is_what_was_written(machine, head):
    assert warned(f"{head}\nX20\nM2", machine) == []


def test_a_cut_in_a_subprogram_counts(machine):
    source = "G21 G90 G0 X0 Y0 Z30\no1 sub\nG1 Z3 F600\nX20\no1 endsub\no1 call\nG0 Z60\nA30 C45\nM2"
    assert [line for line, _text in warned(source, machine)] == [3]


@pytest.mark.parametrize(
    ("dialect", "source", "line"),
    [
        ("fanuc", "O1\nG21 G90 G0 X0. Y0. Z30.\nG1 Z3. F600.\nX20.\nG0 Z60.\nG68.2 X0 Y0 Z0 I0 J20. K0\nG53.1\nM30", 3),
        ("siemens", 'G71 G90 G0 X0 Y0 Z30\nG1 Z3 F600\nX20\nG0 Z60\nCYCLE800(1,"",0,57,0,0,0,30,0,0,0,0,0,-1)\nM30', 2),
        (
            "heidenhain",
            "BEGIN PGM T MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+30 R0 FMAX\nL Z+3 R0 F600\nL Z+60 FMAX\n"
            "PLANE SPATIAL SPA+20 SPB+0 SPC+0 TURN FMAX\nL X+0 Y+0 Z+60 R0 FMAX\nM30\nEND PGM T MM",
            4,
        ),
    ],
)
def test_a_plane_that_is_tilted_later(machine, dialect, source, line):
    ((first, text),) = warned(source, machine, dialect=dialect)
    assert first == line
    assert f"line {1 + source[: source.rindex('M30')].count(chr(10)) - (2 if dialect == 'heidenhain' else 1)}" in text
    assert "the first to turn the table" in text
    assert text.endswith("; name A before")


LEVEL_FIRST = {
    "fanuc": "O1\nG21 G90{reset} G0 X0. Y0. Z30.\nG1 Z3. F600.\nX20.\nG0 Z60.\nG68.2 X0 Y0 Z0 I0 J20. K0\n{turn}\nM30",
    "siemens": "G71 G90\n{reset}\nG0 X0 Y0 Z30\nG1 Z3 F600\nX20\nG0 Z60\n{turn}\nM30",
    "heidenhain": "BEGIN PGM T MM\nTOOL CALL 1 Z S1000\n{reset}\nL X+0 Y+0 Z+30 R0 FMAX\nL Z+3 R0 F600\nL Z+60 FMAX\n"
    "{turn}\nL X+0 Y+0 Z+60 R0 FMAX\nM30\nEND PGM T MM",
}


@pytest.mark.parametrize(
    ("dialect", "reset", "turn", "is_plane"),
    [
        ("fanuc", " G69", "G53.1", True),
        ("siemens", "CYCLE800()", 'CYCLE800(1,"",0,57,0,0,0,30,0,0,0,0,0,-1)', True),
        ("siemens", "CYCLE800()", "G0 A-30 C0", False),
        ("heidenhain", "PLANE RESET STAY", "PLANE SPATIAL SPA+20 SPB+0 SPC+0 TURN FMAX", True),
    ],
)
def test_a_cut_after_the_end_of_all_planes_is_on_a_level_table(machine, dialect, reset, turn, is_plane):
    """A level pocket after CYCLE800() was cut with the table tilted as a plane behind it asks for."""
    for first, is_level in ((reset, is_plane), ("", False)):
        source = LEVEL_FIRST[dialect].format(reset=first, turn=turn)
        assert bool(warned(source, machine, dialect=dialect)) is not is_level
        options = Options(tool_length=60.0, wcs={"G54": (0.0, 0.0, 60.0)}, dialect=dialect)
        moves = assemble(source.encode(), machine, options).moves
        cut = int(np.argmax(moves.kind == MoveKind.FEED))
        assert bool(abs(moves.end[cut, 3]) < 1e-9) is is_level


# --- heads, first moves, dialects ----------------------------------------------------------------------


def with_tool(dialect="auto", **options):
    return Options(tools=TOOLS, wcs={"G54": (0.0, 0.0, PART_HEIGHT)}, dialect=dialect, **options)


def poses(source, machine, dialect="auto"):
    """The moves, the start and all ends in machine coordinates: X Y Z A C, mm and degrees."""
    moves = gcode.interpret_program(source.encode(), build_interpreter_setup(machine, with_tool(dialect)))
    to_machine = machine.coordinates.map_to_machine
    ends = [to_machine(end, moves.frames[frame])[XYZAC] for end, frame in zip(moves.end, moves.frame, strict=True)]
    return moves, to_machine(moves.start, moves.start_frame)[XYZAC], np.array(ends)


def table_of_starts():
    """docs/starts.md: (head, first move) -> the cells of its last table."""
    lines = PAGE.read_text("utf-8").split("## Where they start")[1].splitlines()
    head, _rule, *rows = [
        [cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")
    ]
    return {(row[0], move): cell for row in rows for move, cell in zip(head[1:], row[1:], strict=True)}


STARTS = table_of_starts() if PAGE.exists() else {}


def expected_start(head, move, dialect):
    """A start of docs/starts.md."""
    first, *others = STARTS[head, move].split("; ")
    entry = next((other.split(" (")[0] for other in others if dialect in other.lower()), first)
    x, y, z, *table = entry.split()
    angles = {"A": 0.0, "C": 0.0} | {word[0]: float(word[1:]) for word in table}
    return [float(x), float(y), float(z), angles["A"], angles["C"]]


@pytest.mark.skipif(not STARTS, reason="beside an installed wheel there are no docs")
@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize("head", HEADS)
@pytest.mark.parametrize("dialect", DIALECTS)
def test_heads_start_without_motion_before_the_tool(machine, dialect, head, move):
    moves, start, ends = poses(program(head, move, dialect), machine, dialect)
    before_tool = next(event.before for event in moves.events if event.kind == "tool")
    assert np.abs(ends[:before_tool] - start).max(initial=0.0) < ROUNDING
    assert start == pytest.approx(expected_start(head, move, dialect), abs=0.051)  # the page shows 0.1


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize(
    "options", [{}, {"split_at_stops": True, "approach": "home"}], ids=["alone", "split, from home"]
)
def test_a_tool_change_in_the_head_is_no_stop(machine, dialect, options):
    source = program("Fusion 360, G28", "X Y Z", dialect)
    made = assemble(source.encode(), machine, with_tool(dialect, **options))
    assert made.stops == ()


def test_the_first_motion_comes_down_along_the_tool_axis(machine):
    """X Y Z in one block after a retract, under tilt: only machine Z changes."""
    _moves, start, ends = poses("G21 G90\nG53 G0 Z0\nT1 M6\nG0 A30 C40\nG43.4 H1\nG0 X10 Y20 Z60\nM2", machine)
    assert start[2] == pytest.approx(0.0, abs=ROUNDING)
    assert start[[0, 1, 3, 4]] == pytest.approx(ends[-1][[0, 1, 3, 4]], abs=ROUNDING)
    # by hand: tip on the table, turned by C and A, under a spindle that stands upright over it
    a, c = math.radians(30), math.radians(40)
    x, y = 10 * math.cos(c) - 20 * math.sin(c), 10 * math.sin(c) + 20 * math.cos(c)
    assert start[:2] == pytest.approx([x, math.cos(a) * y - math.sin(a) * (60 + PART_HEIGHT)], abs=ROUNDING)


OVER = [(head, table, "X10 Y20 Z60") for head in ("", "G0 A0 C0\n") for table in ("A30 C40", "A90 C0")] + [
    ("", table, order) for table in ("A90 C0", "A90 C90") for order in ("X10 Y20\nZ60", "Z60\nX10 Y20", "Z60\nY20\nX10")
]


@pytest.mark.parametrize(("head", "table", "order"), OVER)
def test_after_a_retract_the_spindle_stands_over_the_first_place(machine, head, table, order):
    """In machine coordinates: X Y Z of one block, and of several where the table stands upright."""
    _moves, start, ends = poses(f"G21 G90\nG53 G0 Z0\n{head}T1 M6\nG43.4 H1\nG0 {table}\n{order}\nM2", machine)
    assert start[:3] == pytest.approx([*ends[-1][:2], 0.0], abs=ROUNDING)


@pytest.mark.parametrize("order", [("X10", "Y20", "Z60"), ("Z60", "Y20", "X10"), ("Y20", "Z60", "X10")])
@pytest.mark.parametrize("table", ["A0 C90", "A90 C0", "A90 C90", "A30 C40"])
def test_axes_named_one_by_one_on_a_turned_table(machine, table, order):
    """None of the moves has a length, also where the first axis of the program is another of the machine."""
    lines = "\n".join(order)
    _moves, start, ends = poses(f"G21 G90\nT1 M6\nG43.4 H1\nG0 {table}\n{lines}\nM2", machine)
    assert np.abs(ends - start).max() < ROUNDING


def test_an_axis_turned_before_z_is_named_does_not_lower_the_start(machine):
    """Z50 is meant in the work system: at A0 the tool starts at Z50 too, not at the machine height that Z50 has
    at A90.
    """
    moves, _start, _ends = poses("G21 G90\nT1 M6\nG43.4 H1\nG0 A0 C0\nX10 Y10\nA90\nZ50\nM2", machine)
    assert moves.start[2] - LENGTH == pytest.approx(50.0, abs=ROUNDING)  # numbers of before G43.4, without the length


def test_axes_never_named_are_0_in_the_work_system_of_the_first_place(machine):
    source = b"G21 G90\nG53 G0 Z0\nT1 M6\nG55\nG43 H1\nG0 X10 Z50\nM2"
    options = Options(tools=TOOLS, wcs={"G55": (0.0, 7.0, 60.0, 30.0)})
    moves = gcode.interpret_program(source, build_interpreter_setup(machine, options))
    assert moves.end[-1][XYZAC] == pytest.approx([10.0, 0.0, 50.0, 0.0, 0.0], abs=ROUNDING)
    assert machine.coordinates.map_to_machine(moves.start, moves.start_frame)[5] == pytest.approx(-30.0)


# --- first places that are not plain moves ---------------------------------------------------------------

KLARTEXT = "BEGIN PGM T MM\n{retract}TOOL CALL 1 Z S1000\nM3\n{first}\nL Z+90 R0 FMAX\nM30\nEND PGM T MM"
SIEMENS = "G90 G71 G17\n{retract}T1 M6\nD1\nF300 S1000 M3\n{first}\nG0 Z90\nM30"
FANUC = "O1\nG21 G90\n{retract}T1 M6\nS1000 M3\n{first}\nM30"
DRILL = "CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=300 Q202=5 Q210=0 Q203=+0 Q204=20 Q211=0\n"
RING = (
    "CYCL DEF 220 POLAR PATTERN Q216=+0 Q217=+0 Q244=60 Q245=+0 Q246=+360 Q247=+0 Q241=4 Q200=2 Q203=+0 Q204=20 Q301=1 "
    "Q365=0"
)
PLACES = [
    ("heidenhain", "CC X+0 Y+0\nLP PR+20 PA+90 R0 FMAX\nL Z+30 FMAX", (0, 20, 30)),
    ("heidenhain", DRILL + "CYCL CALL POS X+10 Y+20 Z+3 FMAX", (10, 20, 5)),
    ("heidenhain", DRILL + "PATTERN DEF POS1 (X+10 Y+20 Z+0) POS2 (X+30 Y+20 Z+0)\nCYCL CALL PAT FMAX", (10, 20, 2)),
    ("heidenhain", DRILL + "L X+10 Y+20 R0 FMAX M99", (10, 20, 2)),
    ("heidenhain", DRILL + RING, (30, 0, 20)),
    ("heidenhain", "APPR LT X+10 Y+20 Z-5 LEN15 RL F500\nL X+50\nDEP LT LEN5", (-5, 25, -5)),
    ("heidenhain", "APPR LN X+10 Y+20 Z-5 LEN15 RL F500\nL X+50\nDEP LT LEN5", (10, 40, -5)),
    ("heidenhain", "APPR CT X+10 Y+20 Z-5 CCA90 R8 RL F500\nL X+50\nDEP LT LEN5", (2, 33, -5)),
    ("heidenhain", "CC X+0 Y+0\nAPPR PLT PR+20 PA+90 Z-5 LEN10 RL F500\nL X+50\nDEP LT LEN5", (-10, 25, -5)),
    ("siemens", "MCALL CYCLE81(50,0,2,-5)\nHOLES1(10,20,0,5,15,3)\nMCALL", (15, 20, 2)),
    ("siemens", "MCALL CYCLE81(50,0,2,-5)\nHOLES2(10,20,30,0,0,4)\nMCALL", (40, 20, 2)),
    ("siemens", "MCALL CYCLE81(50,0,2,-5)\nCYCLE801(10,20,0,15,15,2,2)\nMCALL", (10, 20, 2)),
    ("siemens", "G111 X0 Y0\nG0 AP=90 RP=20\nZ50", (0, 20, 50)),
    ("fanuc", "G43 H1\nG98 G81 X10. Y20. Z-5. R2. F300", (10, 20, 2)),
    ("rs274", "G43 H1\nG0 @20 ^90\nZ50", (0, 20, 50)),
]  # fmt: skip
RETRACTS = {
    "heidenhain": "L Z+0 R0 FMAX M91\n",
    "siemens": "G0 SUPA Z0 D0\n",
    "fanuc": "G53 Z0\n",
    "rs274": "G53 G0 Z0\n",
}
FORMS = {"heidenhain": KLARTEXT, "siemens": SIEMENS, "fanuc": FANUC, "rs274": FANUC.removeprefix("O1\n")}


@pytest.mark.parametrize("retracts", [False, True])
@pytest.mark.parametrize(("dialect", "first", "place"), PLACES)
def test_first_places_that_are_not_plain_moves(machine, dialect, first, place, retracts):
    source = FORMS[dialect].format(retract=RETRACTS[dialect] if retracts else "", first=first)
    _moves, start, _ends = poses(source, machine, dialect)
    height = 0.0 if retracts else place[2] + LENGTH + PART_HEIGHT - 550.0  # machine zero is 550 mm over the table
    assert start == pytest.approx([*place[:2], height, 0.0, 0.0], abs=ROUNDING)


PLANES = [
    ("heidenhain", "PLANE EULER EULPR+140 EULNU+30 EULROT+0 TURN FMAX SEQ+\nL X+0 Y+0 R0 FMAX\nL Z+50 R0 FMAX"),
    ("heidenhain", "PLANE EULER EULPR+140 EULNU+30 EULROT+0 MOVE FMAX SEQ+\nL X+0 Y+0 R0 FMAX\nL Z+50 R0 FMAX"),
    ("siemens", 'CYCLE800(0,"",0,39,0,0,0,140,30,0,0,0,0,1)\nG0 X0 Y0\nZ50'),
    ("siemens", 'TRAORI\nCYCLE800(0,"",0,39,0,0,0,140,30,0,0,0,0,1)\nG0 X0 Y0\nZ50'),
    ("fanuc", "G68.2 X0 Y0 Z0 I140. J30. K0\nG53.1\nG43 H1\nG0 X0 Y0\nZ50."),
]


@pytest.mark.parametrize(("dialect", "first"), PLANES)
def test_a_plane_before_x_and_y_are_named(machine, dialect, first):
    """The spindle starts at the retract over the zero of the plane, the table where the plane stands level."""
    _moves, start, _ends = poses(FORMS[dialect].format(retract=RETRACTS[dialect], first=first), machine, dialect)
    assert start == pytest.approx([0.0, -math.sin(math.radians(30)) * PART_HEIGHT, 0.0, 30.0, 40.0], abs=ROUNDING)


@pytest.mark.parametrize(
    ("first", "words"),
    [
        ("CC X+0 Y+0\nLP PA+90 R0 FMAX", "LP needs the position of X"),
        ("CC IX+5 Y+0\nLP PR+5 PA+90 R0 FMAX", "CC needs the position of X"),
        ("APPR LCT X+10 Y+20 Z-5 R8 RL F500\nL X+50", "APPR LCT needs the position of X"),
        ("M140 MB50", "needs the position of Z"),
        (DRILL + "CYCL CALL POS X+10 FMAX", "CYCL CALL POS needs the position of Y"),
    ],
)
def test_what_depends_on_where_the_tool_stands_is_refused(machine, first, words):
    with pytest.raises(InputError) as caught:
        poses(KLARTEXT.format(retract="", first=f"{first}\nL X+0 Y+0 Z+50 R0 FMAX"), machine, "heidenhain")
    item = caught.value.findings[0]
    assert item.code == "VP013"
    assert words in item.message
    assert "G9" not in item.message, "Klartext has no G90"


CONTOUR = "G0 X0 Y0\nZ50.\nG1 Z5. F500\nG41 D1 X20. Y10.\nY30.\nG2 X40. Y50. R20.\nG1 X60.\nG40 Y70.\nG0 Z50."


def test_cutter_compensation_on_a_plane(machine):
    """G41 after G53.1 is that of the same contour without a plane: the tool stands upright on both."""
    flat, _start, _ends = poses(FANUC.format(retract="", first=f"G43 H1\nG0 A0 C0\n{CONTOUR}"), machine, "fanuc")
    on_plane, _start, _ends = poses(
        FANUC.format(retract="", first=f"G68.2 X9. Y8. Z7. I140. J30. K0\nG53.1\nG43 H1\n{CONTOUR}"), machine, "fanuc"
    )
    assert on_plane.end[-9:, :3] == pytest.approx(flat.end[-9:, :3], abs=ROUNDING)
    assert np.abs(flat.end[-5, :2] - [20.0, 30.0]).max() == pytest.approx(5.0)  # beside the contour


def test_cutter_compensation_under_tool_vectors_is_refused(machine):
    head = "O1\nG21 G90\nT1 M6\nG43.5 H1\nG0 X0 Y0 Z50. I0 J0 K1.\nG1 Z5. F500\n"
    source = head + "{}G41 D1 X20.\nX40.\nG40 X60.\nM30"
    with pytest.raises(
        InputError, match=r"G41 while a tool axis .I J K. is in force; write G49 before, and name A and C"
    ):
        poses(source.format(""), machine, "fanuc")
    with pytest.raises(InputError, match=r"G41 while a tool axis .I J K. is in force; name A and C in a move before"):
        poses(source.format("G49\n"), machine, "fanuc")
    poses(source.format("G49\nG0 A0 C0\n"), machine, "fanuc")


def test_first_namings_that_contradict_each_other(machine):
    """Z of a plane that stands upright is Y of the part, which has been named: nothing says how high the tool
    stands.
    """
    source = "O1\nG21 G90\nT1 M6\nG0 X0 Y0\nG68.2 X0 Y0 Z0 I0 J90. K0\nG53.1\nG43 H1 Z50.\nX0 Y0\nM30"
    with pytest.raises(InputError, match="cannot be found from its first lines"):
        poses(source, machine, "fanuc")


CHANGED = [
    (
        "fanuc",
        "O1\n"
        "G21 G90\n"
        "T1 M6\n"
        "G43 H1\n"
        "G0 A0 C0\n"
        "X0 Y0 Z200.\n"
        "G49\n"
        "G68.2 X0 Y0 Z0 I140. J30. K0\n"
        "G53.1\n"
        "G0 X0 Y0\n"
        "Z50.\n"
        "M30",
    ),
    (
        "siemens",
        "G71 G90 G17\n"
        "T1 M6\n"
        "D1\n"
        "G0 A0 C0\n"
        "X0 Y0 Z200\n"
        "D0\n"
        'CYCLE800(0,"",0,39,0,0,0,140,30,0,0,0,0,1)\n'
        "G0 X0 Y0\n"
        "Z50\n"
        "M30",
    ),
]


@pytest.mark.parametrize(("dialect", "source"), CHANGED)
def test_a_length_that_changes_before_a_plane_does_not_turn_the_table_back(machine, dialect, source):
    moves, _start, _ends = poses(source, machine, dialect)
    assert moves.end[-2:, [3, 5]] == pytest.approx(np.array([[30.0, 40.0]] * 2), abs=ROUNDING)


@pytest.mark.parametrize(
    ("dialect", "step"), [("rs274", "G91 G0 Z1\nG90"), ("fanuc", "G91 G0 Z1.\nG90"), ("siemens", "G0 Z=IC(1)")]
)
def test_an_incremental_move_is_no_first_naming(machine, dialect, step):
    """X and Y are at home, Y and Z are named, Z goes up by 1, then X is named: Z starts where it was named first."""
    homes, length = ("G53 G0 X0 Y0", "G43 H1") if dialect != "siemens" else ("G0 SUPA X0 Y0", "D1")
    head = "%\nO1\nG21 G90 G17\n" if dialect == "fanuc" else "G90 G17\n"
    end = "M30\n%" if dialect == "fanuc" else "M30"
    source = f"{head}{homes}\nT1 M6\n{length}\nG1 Y14. Z39. F500\n{step}\nG0 X-17.\n{end}"
    _moves, start, _ends = poses(source, machine, dialect)
    assert start == pytest.approx([0, 0, 39 + PART_HEIGHT + LENGTH - 550, 0, 0], abs=ROUNDING)
