"""Klartext: contours, parameters and flow against values worked out by hand."""

import math

import numpy as np
import pytest

from tests.gcode.conftest import list_places_on, make_tool, moves_as_text
from verne_post import check
from verne_post.app.assemble import build_interpreter_setup
from verne_post.base.suggestions import find_meant_number, name_near_numbers
from verne_post.gcode import interpret_program
from verne_post.model.control_keys import HeidenhainKeys, read_keys
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

TOOLS = {1: make_tool(1, 10.0, 10.0)}


@pytest.fixture(scope="module")
def run(view):
    """Interpret statements after a head: the moves."""

    def interpret(*statements, unit="MM", **options):
        head = [f"BEGIN PGM T {unit}", "TOOL CALL 1 Z S1000 F300", "L X+0 Y+0 Z+0 R0 F100"]
        options.setdefault("tools", TOOLS)
        moves, findings = view("\n".join([*head, *statements, "END PGM T"]), dialect="heidenhain", **options)
        assert findings == ()
        return moves

    return interpret


@pytest.fixture(scope="module")
def refusal(view):
    """The first finding of statements after a head."""

    def interpret(*statements):
        head = ["BEGIN PGM T MM", "TOOL CALL 1 Z S1000 F300", "L X+0 Y+0 Z+0 R0 F100"]
        _moves, findings = view(
            "\n".join([*head, *statements, "END PGM T"]), dialect="heidenhain", tools=TOOLS, max_repeats=1000
        )
        assert findings
        return findings[0]

    return interpret


def ends(moves, first=1):
    return np.round(moves.end[first:, :3], 9)


def last(moves):
    return pytest.approx(moves.end[-1, :3].tolist(), abs=1e-9)


# --- lines and arcs --------------------------------------------------------------------------------


def test_f_of_a_tool_call_holds_until_another_f(run):
    """Also where FMAX stands between, and where the call names no tool."""
    moves = run(
        "L X+1",
        "TOOL CALL 1 Z S900 F640",
        "L X+2 FMAX",
        "L X+3",
        "L X+4 F70",
        "TOOL CALL S800 F55",
        "L X+5",
        "TOOL CALL S700",
        "L X+6",
    )
    assert moves.feed[[1, 3, 4, 5, 6]].tolist() == [100.0, 640.0, 70.0, 55.0, 55.0]
    per_turn = run("L X+1 FU0.5 M3", "TOOL CALL S900 F640", "L X+2")
    assert per_turn.feed_mode[-1] != per_turn.feed_mode[-2]
    assert per_turn.feed[-1] == 640.0


def test_lines_incremental_and_inches(run):
    moves = run("L X+10 Y-5,5", "L IX+2 IZ-3 F250", "L IX-1 FMAX", "L IX-1")
    assert moves_as_text(moves)[1:] == [
        "4 feed X10 Y-5.5 F100",
        "5 feed X12 Y-5.5 Z-3 F250",
        "6 rapid X11 Y-5.5 Z-3",
        "7 feed X10 Y-5.5 Z-3 F250",
    ]
    moves = run("L X+1 F40", unit="INCH")
    assert run("L X+1 F40", unit="IN").end.tolist() == moves.end.tolist()  # of older controls
    assert moves.end[-1, 0] == pytest.approx(25.4)
    assert moves.feed[-1] == pytest.approx(4 * 25.4)  # 40 tenths of an inch a minute


@pytest.mark.parametrize(
    ("statement", "end", "sweep"),
    [
        ("C X+10 Y+10 DR+", (10, 10, 0), 270.0),
        ("C X+10 Y+10 DR-", (10, 10, 0), -90.0),
        ("C X+0 Y+0 DR-", (0, 0, 0), -360.0),
        ("CP PA+0 DR-", (20, 0, 0), -180.0),
        ("CP IPA+450 IZ-5 DR+", (10, -10, -5), 450.0),
        ("CP IPA-45 DR-", (10 - 10 * math.cos(math.radians(45)), 10 * math.sin(math.radians(45)), 0), -45.0),
    ],
)
def test_arcs_about_the_pole(run, statement, end, sweep):
    """From (0, 0) about (10, 0): the angle of the start is 180 degrees."""
    moves = run("CC X+10 Y+0", statement)
    assert end == last(moves)
    assert moves.arcs.sweep[-1] == pytest.approx(sweep)
    assert moves.arcs.center[-1, :2] == pytest.approx([10.0, 0.0])


def test_arcs_in_other_planes(run):
    """A pole in Y and Z: DR+ turns from Y to Z."""
    moves = run("CC Y+5 Z+0", "C Y+5 Z-5 DR+")
    assert last(moves) == (0, 5, -5)
    assert moves.arcs.plane[-1] == 2
    assert moves.arcs.sweep[-1] == pytest.approx(90.0)
    moves = run("CC X+5 Z+0", "C X+5 Z-5 DR+")  # from Z to X: Z-5 lies 270 degrees on
    assert moves.arcs.plane[-1] == 1
    assert moves.arcs.sweep[-1] == pytest.approx(270.0)


def test_radius_and_tangent_arcs(run):
    moves = run("CR X+10 Y+10 R+10 DR-", "L X+20", "CT X+30 Y+20")
    assert moves.arcs.center[0, :2] == pytest.approx([10.0, 0.0])
    # CT: goes on along +X from (20, 10) to (30, 20): a quarter about (20, 20)
    assert moves.arcs.center[1, :2] == pytest.approx([20.0, 20.0])
    assert moves.arcs.sweep[1] == pytest.approx(90.0)
    assert run("CR X+10 Y+10 R-10 DR-").arcs.sweep[0] == pytest.approx(-270.0)


def test_polar_lines(run):
    moves = run("CC X+10 Y+0", "LP PR+20 PA+90", "LP IPA+90", "LP IPR-5 Z+3")
    assert ends(moves) == pytest.approx(np.array([[10, 20, 0], [-10, 0, 0], [-5, 0, 3]]))


# --- corners -----------------------------------------------------------------------------------------


def test_rounding_between_lines(run):
    """A right angle at (20, 0) with radius 5: tangent points 5 from the corner, centre (15, 5)."""
    moves = run("L X+20 F200", "RND R5 F50", "L Y+30", "L X+0")
    assert ends(moves) == pytest.approx(np.array([[15, 0, 0], [20, 5, 0], [20, 30, 0], [0, 30, 0]]))
    assert moves.arcs.center[0, :2] == pytest.approx([15.0, 5.0])
    assert moves.feed[1:].tolist() == [200.0, 50.0, 200.0, 200.0]
    assert moves.line[1:].tolist() == [4, 5, 6, 7]


def test_rounding_between_a_line_and_an_arc(run):
    """A line along X to (20, 0), then a circle about (30, 0) of radius 10.

    The rounding of radius 2 touches the line y = 0 at height 2 and the circle from outside: its centre is 2 above the
    line and 12 from (30, 0).
    """
    moves = run("L X+20", "RND R2", "CC X+30 Y+0", "C X+30 Y+10 DR-")
    center = moves.arcs.center[0, :2]
    assert center == pytest.approx([30.0 - math.sqrt(12.0**2 - 2.0**2), 2.0])
    touch = np.array([30.0, 0.0]) + 10.0 * (center - [30.0, 0.0]) / 12.0
    assert moves.end[2, :2] == pytest.approx(touch)
    assert moves.end[1, :2] == pytest.approx([center[0], 0.0])


def test_chamfer(run):
    moves = run("L X+20", "CHF 4", "L Y+30")
    assert ends(moves) == pytest.approx(np.array([[16, 0, 0], [20, 4, 0], [20, 30, 0]]))


# --- compensation, approach, departure ---------------------------------------------------------------------


def test_compensation_enters_and_leaves_at_right_angles(run):
    """Tool radius 5, left of a line along +X from (10, 0): beside its start, and beside its end."""
    moves = run("L X+10 Y+0 RL", "L X+40", "L Y+30", "L X+60 Y+60 R0")
    assert ends(moves) == pytest.approx(np.array([[10, 5, 0], [35, 5, 0], [35, 30, 0], [60, 60, 0]]))


@pytest.mark.parametrize(
    ("statement", "path"),
    [
        # the tool comes on a line in the direction of the contour, 5 beside it
        ("APPR LT X+20 Y+0 LEN12 RL", [(8, 5), (20, 5)]),
        # at right angles: LEN and the radius of the tool away
        ("APPR LN X+20 Y+0 LEN12 RL", [(20, 17), (20, 5)]),
        # the tool's centre on a quarter of radius 12 about (20, 17)
        ("APPR CT X+20 Y+0 CCA90 R+12 RL", [(8, 17), (20, 5)]),
        ("APPR CT X+20 Y+0 CCA90 R+12 RR", [(8, -17), (20, -5)]),
        # from the side of the workpiece: about (20, -7)
        ("APPR CT X+20 Y+0 CCA90 R-12 RL", [(8, -7), (20, 5)]),
    ],
)
def test_approaches(run, statement, path):
    moves = run("L X-40 Y-10", statement, "L X+50")
    assert moves.end[2:4, :2] == pytest.approx(np.array(path), abs=1e-9)
    side = -5.0 if "RR" in statement else 5.0
    assert moves.end[4, :2] == pytest.approx([50.0, side])


def test_approach_on_a_tangent(run):
    """LCT: from (-40, 30) on a tangent of the circle about (20, 17) with radius 12, on it to (20, 5)."""
    moves = run("L X-40 Y+30", "APPR LCT X+20 Y+0 R12 RL", "L X+50")
    start, touch, center = np.array([-40.0, 30.0]), moves.end[2, :2], np.array([20.0, 17.0])
    assert np.linalg.norm(touch - center) == pytest.approx(12.0)
    assert (touch - start) @ (touch - center) == pytest.approx(0.0, abs=1e-9)
    assert moves.end[3, :2] == pytest.approx([20.0, 5.0])
    assert 0 < moves.arcs.sweep[0] < 90  # on in the direction of travel
    leaving = np.array([-(touch - center)[1], (touch - center)[0]])
    assert leaving @ (touch - start) > 0


def test_an_approach_goes_down_after_the_plane(run):
    moves = run("L X-40 Y-10 Z+20 FMAX", "APPR LT X+20 Y+0 Z-3 LEN12 RL F80", "L X+50")
    assert ends(moves, 2) == pytest.approx(np.array([[8, 5, 20], [8, 5, -3], [20, 5, -3], [50, 5, -3]]))
    assert moves.kind[2:].tolist() == [MoveKind.RAPID, MoveKind.RAPID, MoveKind.FEED, MoveKind.FEED]
    assert moves.feed[4:].tolist() == [80.0, 80.0]  # F of APPR holds on
    slow = run("L X-40 Y-10 F55", "APPR CT X+20 Y+0 CCA90 R+12 RL F80", "L X+50", "DEP LT LEN5 F33", "L X+99")
    assert slow.feed[1:].tolist() == [55.0, 55.0, 80.0, 80.0, 33.0, 33.0]
    slow = run("L X-40 Y+30 F55", "APPR LCT X+20 Y+0 R12 RL F80", "L X+50")
    assert slow.feed[1:].tolist() == [55.0, 80.0, 80.0, 80.0]


@pytest.mark.parametrize(
    ("statement", "path"),
    [
        ("DEP LT LEN12", [(62, 5)]),
        ("DEP LN LEN12", [(50, 17)]),
        ("DEP CT CCA90 R+12", [(62, 17)]),
        ("DEP LT LEN12 Z+9", [(62, 5), (62, 5)]),
    ],
)
def test_departures(run, statement, path):
    moves = run("L X+10 Y+0 RL", "L X+50", statement, "L X+90 Y+90")
    assert moves.end[3 : 3 + len(path), :2] == pytest.approx(np.array(path), abs=1e-9)
    assert moves.end[-1, :2] == pytest.approx([90.0, 90.0])


def test_departure_on_a_tangent(run):
    moves = run("L X+10 Y+0 RL", "L X+50", "DEP LCT X+80 Y+60 R12")
    touch, center, end = moves.end[3, :2], np.array([50.0, 17.0]), np.array([80.0, 60.0])
    assert np.linalg.norm(touch - center) == pytest.approx(12.0)
    assert (end - touch) @ (touch - center) == pytest.approx(0.0, abs=1e-9)
    assert moves.end[4, :2] == pytest.approx(end)


def test_a_mirror_image_changes_sides_and_arcs(run):
    """Mirrored in X: RL comes to lie right of the mirrored path, arcs turn the other way."""
    plain = run("L X+10 Y+0 RL", "L X+40", "RND R8", "L Y+30", "CC X+30 Y+30", "C X+30 Y+40 DR+", "L X+60 Y+60 R0")
    mirrored = run(
        "CYCL DEF 8.1 X",
        "L X+10 Y+0 RL",
        "L X+40",
        "RND R8",
        "L Y+30",
        "CC X+30 Y+30",
        "C X+30 Y+40 DR+",
        "L X+60 Y+60 R0",
    )
    assert ends(mirrored) == pytest.approx(ends(plain) * [-1, 1, 1])
    assert mirrored.arcs.sweep == pytest.approx(-plain.arcs.sweep)


def test_scaling_scales_lengths_but_not_the_tool(run):
    moves = run("CYCL DEF 11.1 SCL2", "L X+10 Y+0 RL", "L X+40", "RND R8", "L Y+30", "L X+60 R0")
    assert moves.end[1, :2] == pytest.approx([20.0, 5.0])
    assert moves.arcs.center[0, :2] == pytest.approx([80 - 16, 16])
    assert moves.end[3, :2] == pytest.approx([75.0, 16.0])


# --- maps ---------------------------------------------------------------------------------------------------


def place(moves):
    """Where the last move ends, outside all maps."""
    frame = moves.frames[moves.frame[-1]]
    return frame.feature.map_outside(moves.end[-1, :3]) if frame.feature is not None else moves.end[-1, :3]


def test_maps_act_in_the_order_of_the_program(run):
    """Shift, then rotation about the new datum; the other order turns the shift."""
    point = np.array([10.0, 0.0, 0.0])
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    turned = np.array([10 * c, 10 * s, 0.0])
    shift_first = run("CYCL DEF 7.1 X+50", "CYCL DEF 10.1 ROT+30", "L X+10 Y+0")
    assert place(shift_first) == pytest.approx([50, 0, 0] + turned)
    turn_first = run("CYCL DEF 10.1 ROT+30", "CYCL DEF 7.1 X+50", "L X+10 Y+0")
    assert place(turn_first) == pytest.approx(6 * turned)
    assert place(run("CYCL DEF 7.1 X+50", "CYCL DEF 7.1 IX+5", "L X+10 Y+0")) == pytest.approx(point + [55, 0, 0])
    assert place(run("CYCL DEF 10.1 ROT+30", "CYCL DEF 10.1 IROT-30", "L X+10 Y+0")) == pytest.approx(point)


def test_a_preset_ends_the_maps(run):
    moves = run("CYCL DEF 7.1 X+50", "CYCL DEF 10.1 ROT+30", "CYCL DEF 247 PRESET Q339=2", "L X+10 Y+0")
    assert moves.frames[moves.frame[-1]].feature is None
    assert moves.frames[moves.frame[-1]].system == 2


def test_preset_0_is_the_datum_that_holds_at_the_start(run):
    """Set by hand at the control: G54, unless the program also calls preset 1, which is another place."""
    moves = run("L X+1", "CYCL DEF 247 PRESET Q339=2", "L X+2", "CYCL DEF 247 PRESET Q339=+0", "L X+3")
    assert [moves.frames[frame].system for frame in moves.frame[-3:]] == [1, 2, 1]


# --- parameters -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("5 * 3 + 2 * 10", 35), ("SQ 10 - 3 ^ 3", 73), ("( 2 + 3 ) * 4", 20), ("SIN 30", 0.5), ("COS 60 * 2", 1.0),
        ("SQRT 16", 4), ("ABS -3.5", 3.5), ("INT -3.7", -3), ("FRAC 3,25", 0.25), ("NEG 4", -4), ("SGN -9", -1),
        ("ATAN 1", 45), ("ASIN 1", 90), ("ACOS 0", 90), ("LN 1", 0), ("LOG 1000", 3), ("EXP 0", 1), ("PI", math.pi),
        ("17 % 5", 2), ("-2 * -3", 6), ("10 - 4 - 3", 3), ("TAN 45 / 2", 0.5),
    ],
)  # fmt: skip
def test_formulas(run, formula, value):
    assert run(f"Q1 = {formula}", "L X+Q1").end[-1, 0] == pytest.approx(value)


@pytest.mark.parametrize(
    ("function", "value"),
    [
        ("FN 0: Q1 = -4", -4), ("FN 1: Q1 = +3 + +4", 7), ("FN 2: Q1 = +3 - +5", -2), ("FN 3: Q1 = +3 * -2", -6),
        ("FN 4: Q1 = +9 DIV +2", 4.5), ("FN 5: Q1 = SQRT +9", 3), ("FN 6: Q1 = SIN +90", 1),
        ("FN 7: Q1 = COS +180", -1),
        ("FN 8: Q1 = +3 LEN +4", 5), ("FN 13: Q1 = +10 ANG -10", 135),
    ],
)  # fmt: skip
def test_functions(run, function, value):
    assert run(function, "L X+Q1").end[-1, 0] == pytest.approx(value)


def test_functions_need_no_blank_before_their_number(run):
    assert run("FN0: Q1 = +5", "FN12: IF +Q1 LT +9 GOTO LBL 2", "L X+99 FMAX", "LBL 2", "L X+Q1 FMAX").end[-1, 0] == 5


def test_a_comment_that_goes_on_is_a_comment_in_its_next_lines(run):
    moves = run("7 ;This program is free~", "L X+99 FMAX~", " RND R5", "L X+5 FMAX", ";last~", "LBL 1")
    assert moves.end[:, 0].tolist() == [0, 5]


def test_declared_texts(run):
    assert run('9 DECLARE STRING QS1 = "a;b"', "L X+5 FMAX").end[-1, 0] == 5
    assert run('DECLARE STRING QS1 = "C"', "CALL LBL QS1", "M30", 'LBL "C"', "L X+7 FMAX", "LBL 0").end[-1, 0] == 7


def test_subprograms_and_repeats(run):
    moves = run(
        "LBL 1",
        "L IX+10",
        "CALL LBL 1 REP 2/2",
        'CALL LBL "UP"',
        "L IY+1",
        "M30",
        'LBL "UP"',
        "L IZ+5",
        "CALL LBL 3",
        "LBL 0",
        "LBL 3",
        "L IZ+1",
        "LBL 0",
    )
    assert ends(moves) == pytest.approx(
        np.array([[10, 0, 0], [20, 0, 0], [30, 0, 0], [30, 0, 5], [30, 0, 6], [30, 1, 6]])
    )


def test_a_loop_by_jumps(run):
    moves = run("FN 0: Q1 = +0", "LBL 2", "Q1 = Q1 + 1", "L X+Q1", "FN 12: IF +Q1 LT +4 GOTO LBL 2")
    assert moves.end[1:, 0].tolist() == [1.0, 2.0, 3.0, 4.0]


def test_called_programs_keep_their_own_ql(run):
    other = b"0 BEGIN PGM OTHER MM\nQL1 = 9\nL Y+QL1\n9 END PGM OTHER MM"
    moves = run("QL1 = 5", "CALL PGM TNC:\\JOBS\\OTHER.H", "L X+QL1", subroutines={"other": other})
    assert last(moves) == (5, 9, 0)
    assert moves.line[1:].tolist() == [5, 6]  # lines of the other file are those of the call


def test_what_tools_show(run):
    assert run("L X+Q108 Y+Q114").end[-1, :2] == pytest.approx([5.0, 10.0])


@pytest.mark.parametrize(
    ("statements", "code", "words"),
    [
        (["L X+5 Q"], "VP001", "'Q'"),
        (["L X+5 X+6"], "VP004", "X appears twice"),
        (["L X+5 PR+6"], "VP006", "does not use PR"),
        (["L X+Q77"], "VP025", "Q77 has no value"),
        (["FN 18: SYSREAD Q5 = ID1", "L X+Q5"], "VP025", "not known here"),
        (["C X+5 DR+"], "VP005", "write CC"),
        (["CC X+3 Y+0", "C X+5 Y+1 DR+"], "VP008", "not on the circle"),
        (["CC X+3 Y+0", "C X+6"], "VP005", "DR"),
        (["M5", "RND R5"], "VP017", "right before"),
        (["L X+10", "RND R50", "L Y+10"], "VP008", "no arc"),
        (["L X+10", "RND R5", "TOOL CALL 1 Z"], "VP017", "needs the next"),
        (["L X+10", "CHF 50", "L Y+10"], "VP008", "longer"),
        (["APPR LT X+5 Y+5 LEN3 RL", "M30"], "VP017", "APPR"),
        (["L X+10 RL", "L X+20 RR"], "VP017", "R0"),
        (["CALL LBL 9"], "VP023", "LBL 9"),
        (["LBL 1", "LBL 1", "CALL LBL 1"], "VP023", "twice"),
        (["CALL PGM NONE"], "VP023", "none.h"),
        (["LBL 1", "L IX+1", "FN 9: IF +1 EQU +1 GOTO LBL 1"], "VP024", "repeated"),
        (["CALL LBL 1", "M30", "LBL 1", "L X+1"], "VP023", "LBL 1, which CALL LBL has called, runs on into END PGM"),
        (["Q1 = 1 / 0"], "VP007", "zero"),
        (["Q1 = SQRT -1"], "VP007", "negative"),
        (["Q1 = ( 2"], "VP001", "not closed"),
        (["Q1 = 10 ^ 400"], "VP007", "beyond any machine"),
        (["CYCL CALL"], "VP017", "CYCL DEF"),
        (["CYCL DEF 200 D Q200=2"], "VP005", "needs Q"),
        (["CYCL DEF 7.1 X+5 ~"], "VP001", "not a coordinate"),
        (["PLANE SPATIAL SPA+5 SPB+0 STAY"], "VP005", "SPC"),
        (["PLANE SPATIAL SPA+5 SPB+0 SPC+0"], "VP005", "MOVE, TURN or STAY"),
        (["L X+5 ~"], "VP001", "END"),
        (["G1 X5"], "VP002", "G1"),
        (["X+5"], "VP001", "X+5"),
        (["L X1 0 Y5"], "VP001", "X1 0: a blank is in the number; did you mean X10?"),
    ],
)
def test_refusals(refusal, statements, code, words):
    found = refusal(*statements)
    assert (found.code, words in found.message) == (code, True), found


def test_a_text_without_end(view):
    _moves, findings = view("BEGIN PGM T MM\nL X+0 F100", dialect="heidenhain")
    assert [item.code for item in findings] == ["VP010"]


def test_recognised(view):
    for text in ("0 BEGIN PGM A MM\nL X+5 F9\nEND PGM A MM", "; x\n\nbegin pgm a mm\nL X+5 F9\nend pgm a mm"):
        moves, findings = view(text)
        assert (findings, moves.end[0, 0]) == ((), 5.0)
    assert view("G1 X5 F9\nM2")[1] == ()


# --- plain lines -------------------------------------------------------------------------------------------------


def test_plain_lines_are_what_the_general_reader_makes_of_them(run):
    """Long stretches go through the scanner; M8 keeps a line out of it."""
    random = np.random.default_rng(5)
    lines = []
    for k in range(200):
        x, y, z = np.round(random.uniform(-50, 50, 3), 3)
        words = [f"X{x:+g}", f"Y{y:+g}".replace(".", ","), f"Z{z:g}"][: 1 + k % 3]
        feed = " FMAX" if k % 7 == 0 else f" F{100 + k}" if k % 4 == 0 else ""
        lines.append(f"{k} L {' '.join(words)}{' R0' if k % 5 == 0 else ''}{feed}")
    fast = run(*lines)
    slow = run(*(f"{line} M8" for line in lines))
    for name in ("kind", "end", "feed", "line"):
        assert np.array_equal(getattr(fast, name), getattr(slow, name), equal_nan=name == "feed"), name


@pytest.mark.parametrize(
    "odd",
    [
        "; note",
        "",
        "L X+5 ; note",
        "12 ; note",
        "* - note",
        "L X+5 ; note ~\nY+7",
        "; note ~\nL X+5",
        "F200",
        "L FMAX\nL X+5",
        "L X+5 ; RND R2",
        "; note\nRND R2\nL Y+30",
        "; one\n\n; two\nCHF 1\nL X+20 Y+30",
        "L X+1 ~\n; note\nL X+5",
        "CT X+30 Y+9",
        "L X+5 Y+5\nL Z+7\nCT X+30 Y+9",
        "L X+5 C+3\nCT X+30 Y+9",
        "CALL LBL 1\nFN 9: IF +1 EQU +1 GOTO LBL 2\nLBL 1\nCT X+30 Y+9\nLBL 0\nLBL 2",
    ],
)
def test_comments_among_plain_lines_are_what_the_general_reader_makes_of_them(view, monkeypatch, odd):
    stretch = [f"L X+{k} Y+{k * k % 7}" for k in range(12)]
    text = "\n".join(
        ["BEGIN PGM T MM", "L X+0 Y+0 Z+5 A+0 C+0 R0 F100", *stretch, odd, *stretch, "; end", "END PGM T MM"]
    )
    fast, fast_errors = view(text, dialect="heidenhain")
    monkeypatch.setattr("verne_post.gcode.plain.MIN_LINES", 10**9)
    slow, slow_errors = view(text, dialect="heidenhain")
    assert fast_errors == slow_errors
    for name in ("kind", "end", "feed", "line"):
        assert np.array_equal(getattr(fast, name), getattr(slow, name), equal_nan=name == "feed"), name


@pytest.mark.parametrize(
    "before",
    ["TOOL CALL 1 Z S1000 F900", "CR X+20 Y+5 R+30 DR- F900", "F900", "L X+5 F900", "L X+5 F300\nM136\nM137\nF900"],
)
def test_stretches_of_turns_alone_have_the_feed_in_force(view, monkeypatch, before):
    turns = [f"L C+{5 * k}" for k in range(13)]
    steps = [f"L X+{k}" for k in range(13)]
    text = "\n".join(
        [
            "BEGIN PGM T MM",
            "TOOL CALL 1 Z S1000 F500",
            "L X+0 Y+0 Z+80 A+0 C+0 FMAX M3",
            "M128",
            "L X+1 F300",
            *steps,
            before,
            *turns,
            "L X+5 M8",
            *turns[::-1],
            "L C+0",
            "END PGM T MM",
        ]
    )
    fast, errors = view(text, dialect="heidenhain")
    monkeypatch.setattr("verne_post.gcode.plain.MIN_LINES", 10**9)
    slow, _errors = view(text, dialect="heidenhain")
    assert errors == ()
    assert fast.feed[-1] == 900.0
    for name in ("kind", "end", "feed", "line"):
        assert np.array_equal(getattr(fast, name), getattr(slow, name), equal_nan=name == "feed"), name


@pytest.mark.parametrize(
    "line", ["X+5", "G1 X+5", "N5 L X+5", "L X1 0", "L X+5 (5)", "L X5.5.5", "12 L X+5 G1", "L X+5 % 3"]
)
def test_no_line_that_is_none_slips_through_the_scanner(view, line):
    text = "\n".join(
        ["BEGIN PGM T MM", "L X+1 F100", *["L IX+1", "L X+3"] * 3, *["L X+2"] * 9, line, *["L X+2"] * 9, "END PGM T MM"]
    )
    _moves, findings = view(text, dialect="heidenhain")
    assert [item.line for item in findings] == [18]


# --- the stock -----------------------------------------------------------------------------------------


def test_the_stock_is_kept(run):
    box = run("BLK FORM 0.1 Z X-40 Y-30,5 Z-10", "BLK FORM 0.2 X+40 IY+60 Z+5", "L X+1").stock
    assert (box.low, box.high, box.line, box.round) == ((-40, -30.5, -10), (40, 29.5, 5), 5, False)
    assert box.size == (80, 60, 15)
    inch = run("BLK FORM 0.1 Z X+0 Y+0 Z-1", "BLK FORM 0.2 X+1 Y+2 Z+0", "L X+1", unit="INCH").stock
    assert inch.size == pytest.approx((25.4, 50.8, 25.4))
    cylinder = run("Q1 = 50", "BLK FORM CYLINDER Z RQ1 L105 DIST+5 RI10", "L X+1").stock
    assert (cylinder.low, cylinder.high, cylinder.bore, cylinder.round) == ((-50, -50, -100), (50, 50, 5), 20, True)
    shifted = run("CYCL DEF 7.1 X+9", "BLK FORM CYLINDER Z D8 L4", "L X+1").stock
    assert shifted.high == (4, 4, 0)  # of the datum, whatever shifts it later
    assert shifted.frame.feature is None
    assert run('BLK FORM FILE "PART.STL"', "L X+1").stock is None


@pytest.mark.parametrize(("statements", "code", "line"), [
    (["BLK FORM 0.1 Z X+0 Y+0"], "VP005", 4), (["BLK FORM 0.1 Z X+0 Y+0", "BLK FORM 0.2 X+1 Y+1 Z+1"], "VP005", 4),
    (["BLK FORM 0.2 X+1 Y+1 Z+1"], "VP017", 4), (["BLK FORM 0.1 Z X+0 Y+0 Z+0 W+1"], "VP001", 4),
    (["BLK FORM 0.1 Z X+0 X+0 Y+0 Z+0"], "VP004", 4),
    (["BLK FORM 0.1 Z X+0 Y+0 Z+0", "BLK FORM 0.2 X+1 Y+0 Z+1"], "VP007", 5),
    (["BLK FORM CYLINDER Z R5"], "VP005", 4), (["BLK FORM CYLINDER Z R5 D10 L9"], "VP005", 4),
    (["BLK FORM CYLINDER X R5 L9"], "VP002", 4),
    (["BLK FORM CYLINDER Z R5 L9 RI5"], "VP007", 4), (["BLK FORM CYLINDER Z R5 L-9"], "VP007", 4),
])  # fmt: skip
def test_a_stock_that_cannot_be(refusal, statements, code, line):
    found = refusal(*statements)
    assert (found.code, found.line) == (code, line)


# --- tools by name ----------------------------------------------------------------------------------------

NAMED = "BEGIN PGM T MM\n{}\nTOOL CALL {} Z S900\nL X+1 F100\nEND PGM T"


@pytest.mark.parametrize(("before", "call"), [("", '"MILL 10"'), ("", "QS3"), ('TOOL DEF "MILL 10"', '"MILL 10"')])
def test_a_name_is_the_number_that_the_settings_give_it(view, before, call):
    before = 'QS3 = "MILL 10"' if call == "QS3" else before
    text = NAMED.format(before, call)
    moves, findings = view(
        text,
        dialect="heidenhain",
        tools={7: make_tool(7, 33.0, 4.0)},
        control={"heidenhain": {"tools": {"MILL 10": 7}}},
    )
    assert findings == ()
    assert moves.frames[moves.frame[-1]].tool_length == 33.0
    assert any(event.data.get("name") == "MILL 10" for event in moves.events)


def test_a_name_without_a_number_is_refused_where_there_is_a_table(view):
    _moves, findings = view(NAMED.format("", '"MILL 10"'), dialect="heidenhain", tools=TOOLS)
    assert [(item.code, item.line, item.column) for item in findings] == [("VP012", 3, 11)]
    assert "[heidenhain.tools]" in findings[0].message


@pytest.mark.parametrize(("second", "codes"), [("A", []), ("B", ["VP018"])])
def test_names_without_a_table_are_tools_of_their_own(view, second, codes):
    text = NAMED.format('TOOL CALL "A" Z S900', f'"{second}"')
    moves, findings = view(text, dialect="heidenhain", tools=None, tool_length=50.0)
    assert [item.code for item in findings] == codes
    assert codes or moves.frames[moves.frame[-1]].tool_length == 50.0


@pytest.mark.parametrize("radius", ["R0.5", "R0,5", "R+0.5", "R 0.5"])
def test_a_radius_below_1_needs_no_sign(run, radius):
    moves = run("L X+10 R0 F200", f"RND {radius}", "L Y+10")
    assert moves.end[-2, :2].tolist() == [10.0, 0.5]


def test_feed_rates_per_turn_and_per_minute_need_a_number_of_their_own(run, view):
    moves = run("L X+1 F200 M3", "L X+2 F0.2 M136", "L X+3", "L X+4 F300 M137", "L X+5")
    assert [(moves.feed[row], moves.feed_mode[row]) for row in range(-5, 0)] == [
        (200, 0),
        (0.2, 2),
        (0.2, 2),
        (300, 0),
        (300, 0),
    ]
    for lines, said in (
        (["L X+1 F200 M3", "L X+2 M136"], "M136 of line .* has ended the last F, and takes a new one in mm per turn"),
        (["L X+1 F0.2 M136 M3", "L X+2 M137"], "M137 of line .* has ended the last F, and takes a new one in mm/min"),
        (["L X+1 F0.2 M136 M3", "M137", "L X+2"], "M137 of line .* has ended the last F"),
        (["L X+1 F200 M3", "M136", "M137", "L X+2"], "M137 of line .* has ended the last F"),
    ):
        with pytest.raises(AssertionError, match=f"VP009.*{said}"):
            run(*lines)


@pytest.mark.parametrize(
    "words", ["DWELL 0.5", "V.ZEIT0.5", "V.IDO 0.5", "TIME.5", "TEMPO ATTESA 0,5", "Q1", "DWELL Q1", "0.5"]
)
def test_words_before_a_dwell_are_those_of_the_controls_language(view, words):
    moves, findings = view(
        "BEGIN PGM A MM\n"
        "Q1 = 0.5\n"
        "CYCL DEF 9.0 DWELL\n"
        f"CYCL DEF 9.1 {words}\n"
        "CYCL DEF 13.1 ANGULO 90\n"
        "L X+5 FMAX\n"
        "END PGM A MM\n",
        dialect="heidenhain",
    )
    assert findings == ()
    assert moves.feed[moves.kind == MoveKind.DWELL].tolist() == [0.5]


def test_a_dwell_by_function(view):
    """Seconds, and turns of the spindle: 3 turns at 90 turns a minute are 2 s. It needs a spindle that turns."""
    text = (
        "BEGIN PGM A MM\nTOOL CALL 1 Z S90\n{}\nFUNCTION DWELL TIME1,5\nFUNCTION DWELL REV3\nL X+5 FMAX\nEND PGM A MM\n"
    )
    moves, found = view(text.format("M3"), dialect="heidenhain")
    assert (found, moves.feed[moves.kind == MoveKind.DWELL].tolist()) == ((), [1.5, 2.0])
    found = view(text.format("M5"), dialect="heidenhain")[1]
    assert [(item.code, item.line, "turns" in item.message) for item in found] == [("VP017", 5, True)]


@pytest.mark.parametrize("words", ["TIME", "5 5", "T 0.5 S", "--5"])
def test_a_dwell_needs_its_number(view, words):
    text = f"BEGIN PGM A MM\nCYCL DEF 9.0 DWELL\nCYCL DEF 9.1 {words}\nL X+5 FMAX\nEND PGM A MM\n"
    assert [item.code for item in view(text, dialect="heidenhain")[1]] == ["VP001"]


# --- what the set-up has of the control ---------------------------------------------------------------------------

DATUMS = {"heidenhain": {"datums": {"5": [10, -20, 2.5], "7": [1.0, 0.0, 0.0]}}}


@pytest.mark.parametrize(("statements", "wanted"), [
    (["CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 7.1 #5"], [11, -18, 5.5]), (["Q1 = 7", "CYCL DEF 7.1 #Q1"], [2, 2, 3]),
    (["SEL TABLE \"TNC:/A.D\"", "TRANS DATUM TABLE TABLINE5"], [11, -18, 5.5]),
    (["CYCL DEF 7.1 X+100 Y+100", "CYCL DEF 7.1 #7"], [2, 2, 3]), (["CYCL DEF 7.1 #5", "TRANS DATUM RESET"], [1, 2, 3]),
    (["CYCL DEF 7.1 #5", "CYCL DEF 7.1 IX+1"], [12, -18, 5.5]),
    (["CYCL DEF 10.1 ROT+90", "CYCL DEF 7.1 #5"], [20 - 2, 10 + 1, 5.5]),  # the shift acts in the turned system
])  # fmt: skip
def test_rows_of_the_datum_table_are_shifts_of_the_set_up(run, statements, wanted):
    assert place(run(*statements, "L X+1 Y+2 Z+3", control=DATUMS)) == pytest.approx(wanted, abs=1e-9)
    inches = run(
        *statements[:-1],
        statements[-1].replace("IX+1", "IX+0.03937007874"),
        "L X+1 Y+2 Z+3",
        unit="INCH",
        control=DATUMS,
    )
    if not any("+100" in one for one in statements):
        assert place(inches) == pytest.approx(np.array(wanted) + 24.4 * _turned(statements), abs=1e-6)


def _turned(statements):
    """How X1 Y2 Z3 count: turned by 90 degrees after the rotation."""
    return np.array([-2, 1, 3]) if "CYCL DEF 10.1 ROT+90" in statements else np.array([1, 2, 3])


@pytest.mark.parametrize(
    ("statements", "control", "part"),
    [
        (["CYCL DEF 7.1 #5"], {}, "none"),
        (["CYCL DEF 7.1 #6"], DATUMS, "rows 5, 7"),
        (["TRANS DATUM TABLE TABLINE1"], DATUMS, "#1"),
        (['SEL TABLE "A.D"'], {}, "heidenhain.datums"),
        (['SEL TABLE "A.D"', 'SEL TABLE "B.D"'], DATUMS, "several"),
    ],
)
def test_rows_that_the_set_up_does_not_have_are_refused(view, statements, control, part):
    text = "\n".join(["BEGIN PGM T MM", "TOOL CALL 1 Z S1000 F300", "L X+0 Y+0 Z+0 R0 F100", *statements, "END PGM T"])
    found = view(text, dialect="heidenhain", tools=TOOLS, control=control)[1]
    assert [(item.code, item.line) for item in found] == [("VP002", 3 + len(statements))]
    assert part in found[0].message


@pytest.mark.parametrize(
    "keys",
    [{"datums": {"A": [1, 2, 3]}}, {"datums": {"1": [1, 2]}}, {"datums": {"1": [1, 2, "Z"]}}, {"cycle_19": "turns"}],
)
def test_keys_of_the_control_are_checked(keys):
    with pytest.raises(ValueError, match=next(iter(keys))):
        read_keys(HeidenhainKeys, keys)


def test_blanks_are_where_the_control_lets_them_be(run):
    """Written by hand into the texts of CAM systems."""
    moves = run("CYCL DEF9 .0 VARAKOZASI IDO", "CYCL DEF9.1 V.IDO5", "CYCL DEF7.1 X+2", "L X+1")
    assert place(moves)[0] == 3
    assert moves.feed[moves.kind == MoveKind.DWELL].tolist() == [5]
    assert ends(run("M140 MB30 FMAX"))[-1].tolist() == ends(run("L M140 MB30 FMAX"))[-1].tolist() == [0, 0, 30]


def test_words_that_were_not_answered_change_nothing(run):
    """R, F and M with nothing beside them, in the middle of a contour with RL."""
    contour = ["L X+0 Y-20 RL F500", "L X+30{}", "L Y+20{}", "DEP LT LEN5"]
    one, two = (run(*(line.format(empty) for line in contour)) for empty in ("", " R F M"))
    assert one.end.tolist() == two.end.tolist()
    assert np.nan_to_num(one.feed).tolist() == np.nan_to_num(two.feed).tolist()


def test_tools_and_stocks_of_zero_as_cam_systems_write_them(view):
    """R0 of TOOL DEF is a radius, not the end of compensation; a stock from a corner to the same corner is none."""
    text = (
        "BEGIN PGM C IN\n"
        "BLK FORM 0.1 Z X0 Y0 Z0\n"
        "BLK FORM 0.2 X0 Y0 Z0\n"
        "TOOL DEF 1 L3 R0\n"
        "TOOL CALL 1 Z S100\n"
        "L X1 Y1 Z1 F MAX M3\n"
        "L X2 F40\n"
        "END PGM C IN"
    )
    moves, findings = view(text, dialect="heidenhain")
    assert findings == ()
    assert moves.stock is None
    assert moves.frames[moves.frame[-1]].tool_length == pytest.approx(76.2)


def test_f_of_a_turn_is_in_degrees_in_programs_in_inches_too(machine, view):
    """F1000 is 2540 mm/min, and 1000 degrees a minute: 90 degrees take 5.4 s, about a tip that stands in the middle."""
    text = (
        "BEGIN PGM A INCH\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+4 A+0 C+0 FMAX M3\nL C+900 F1000\nL X+1\n{}\n"
        "L C+990 F1000\nL Z+5\nL Z+4 C+999\nEND PGM A INCH\n"
    )
    for word in ("M129", "M128"):
        setup = build_interpreter_setup(machine, Options(dialect="heidenhain", tool_length=60.0))
        moves = interpret_program(text.format(word).encode(), setup)
        feeds = dict(zip(moves.line.tolist(), moves.feed.tolist(), strict=True))
        assert [feeds[4], feeds[7]] == pytest.approx([1000.0, 1000.0])
        assert [feeds[5], feeds[8]] == pytest.approx([2540.0, 2540.0])
        turn = moves.line.tolist().index(9)
        bare = view(text.format(word), dialect="heidenhain")[0]  # without a machine, as dump moves has it
        assert dict(zip(bare.line.tolist(), bare.feed.tolist(), strict=True))[4] == pytest.approx(1000.0)
        if word == "M129":  # sqrt(25.4^2 + 9^2) at 2540
            assert moves.seconds[turn] == pytest.approx(60 * math.hypot(25.4, 9) / 2540)
        else:
            assert feeds[9] == pytest.approx(2540.0)


def test_tool_def_waits_for_the_next_call(run):
    """The contour is at Y0 along X, to the left of it the tool's centre at Y5, the radius in the table."""
    contour = ["L X+20 Y+0 RL F500", "L X+40", "L X+60 R0"]
    for call, radius, length in ((), 5.0, 10.0), (("TOOL CALL 1 Z S1000",), 2.0, 50.0):
        moves = run("L X+0 Y+20", "TOOL DEF 1 L+50 R+2", *call, "L Y+30 Z+5", *contour)
        assert moves.end[-2, :2] == pytest.approx([40.0, radius])
        assert moves.frames[moves.frame[-2]].tool_length == length


def test_iz_after_a_tool_call_of_the_same_length_or_after_z(run):
    for statements in (["TOOL CALL 1 Z S900"], ["TOOL CALL 1 Z S900 DL+1", "L Z+0"]):
        assert run(*statements, "L IZ-5").end[-1, 2] == -5
    moves = run("TOOL CALL 1 Z S900 DL+1", "L Z+60 FMAX M91", "L IZ-5")  # the machine says where Z is
    assert moves.end[-1, 2] == moves.end[-2, 2] - 5


def test_user_codes_switch_tool_centre_point_control_as_m129_does(machine):
    text = (
        "BEGIN PGM P MM\nTOOL CALL 1 Z S900 F500\nL X+10 Y+5 Z+50 FMAX\nM128\nL A+30 C+40 FMAX\n{}\nL X+3 A+10 FMAX\n"
        "{}\nL X+7 A+20 F500\nEND PGM P MM\n"
    )
    own = list_places_on(machine, text.format("M129", "M128"), "heidenhain")
    remap = {"M429": "tcp off", "M428": "tcp on"}
    assert list_places_on(machine, text.format("M429", "M428"), "heidenhain", remap=remap) == own
    assert list_places_on(machine, text.format("", ""), "heidenhain") != own


@pytest.mark.parametrize(
    ("number", "known", "named"),
    [
        ("11", ("1", "2", "LEFT"), "LBL 1, which is nearly this number"),
        ("33", ("3", "32"), "LBL 3, which is nearly this number"),
        ("1001", ("1000", "2000"), "LBL 1000, which is nearly this number"),
        ("12", ("112", "2"), "LBL 112 and LBL 2, which are nearly this number"),
        ("12", ("11", "13"), ""),  # short numbers that differ by one digit are the usual ones
        ("12", ("1", "2", "112", "120"), ""),
        ("LEFT", ("1",), ""),
    ],
)
def test_near_numbers_are_named(number, known, named):
    assert name_near_numbers(number, known, "LBL ") == named


@pytest.mark.parametrize(
    ("number", "known", "meant"),
    [
        ("100", ("10", "1", "LEFT"), "10"),
        ("1320", ("1300", "1302"), "1302"),
        ("10", ("1", "2"), ""),  # a subprogram of its own
        ("12", ("112", "212"), ""),  # either
        ("11", ("12",), ""),
        ("101", ("102", "1011"), "1011"),  # another digit may be a number of its own
    ],
)
def test_a_number_is_meant_that_one_digit_tells_apart(number, known, meant):
    assert find_meant_number(number, known) == meant


_TOOL_AND_PLACE = Options(
    dialect="heidenhain", wcs={"G54": (0, 0, 0)}, tools={1: Tool(1, 1, (0, 0, 80.0, 0, 0, 0, 0, 0, 0), 10.0)}
)


def _warn(machine, body):
    text = f"BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+60 A+0 C+0 FMAX M3\n{body}\nM30\nEND PGM P MM\n"
    findings = check(text.encode(), machine, _TOOL_AND_PLACE).findings
    assert not [one for one in findings if one.severity == "error"]
    return [(one.code, one.line) for one in findings if one.code in ("VP026", "VP037")]


@pytest.mark.parametrize(
    ("approach", "depart", "found"),
    [
        ("APPR LT X+20 Y+0 LEN5 RL F500", "DEP LT LEN5", []),
        ("APPR LT X+20 Y+0 LEN5 F500", "DEP LT LEN5", [("VP026", 4)]),
        ("L X+20 Y+0 F500", "DEP LT LEN5", [("VP026", 6)]),
        ("L X+20 Y+0 RL F500", "L X+60 R0", []),
    ],
)
def test_an_approach_without_a_side_is_told_once(machine, approach, depart, found):
    assert _warn(machine, f"{approach}\nL X+40\n{depart}") == found


@pytest.mark.parametrize(
    ("body", "found"),
    [
        ("L A-20 FMAX\nL Z+50 F600\nM128\nL X+5", [("VP037", 5)]),
        ("L A-20 FMAX\n" + "L X+5 F600\nL X+6\n" * 20 + "M128\nL X+7", [("VP037", 44)]),
        ("L A-20 FMAX\nL Z+50 FMAX\nM128\nL X+5 F600", []),
        ("L Z+50 F600\nL A-20 FMAX\nM128\nL X+5", []),
        ("L Z+50 F600\nM128\nL X+5 A-20", []),
        ("L A-20 F600\nM128\nL X+5", []),
    ],
)
def test_a_cut_at_a_tilted_table_right_before_m128(machine, body, found):
    assert _warn(machine, body) == found
    text = f"BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+60 A+0 C+0 FMAX M3\n{body}\nM30\nEND PGM P MM\n"
    told = [one for one in check(text.encode(), machine, _TOOL_AND_PLACE).findings if one.code == "VP037"]
    assert not any(item.edits for item in told), "before the cut alone, the tilt is still one of the machine's axes"


@pytest.mark.parametrize(
    ("text", "said"), [("Q206= ;FEED ~", "Q206, the plunge feed,"), ("Q201= ~", "Q201, the depth,")]
)
def test_a_cycle_parameter_without_a_value(machine, text, said):
    """The next parameter was read as its value, and told to have none."""
    other = "Q201=-5 ~" if "Q206" in text else "Q206=150 ~"
    cycle = f"CYCL DEF 200 DRILLING ~\nQ200=2 ~\n{other}\n{text}\nQ202=5 ~\nQ210=0 ~\nQ203=0 ~\nQ204=20 ~\nQ211=0"
    program = (
        f"BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+60 A+0 C+0 FMAX M3\n{cycle}\nCYCL CALL\nM30\nEND PGM P MM"
    )
    [finding] = [one for one in check(program.encode(), machine, _TOOL_AND_PLACE).findings if one.severity == "error"]
    number = text[:4]
    assert (finding.code, finding.line, finding.column) == ("VP001", 7, 1)
    assert finding.message == f"{said} has no value; write its number after {number}="


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("X=5 R0", "X=5: a coordinate has no =, and no path function stands before it; write L X+5 or L X-5"),
        ("PR=5 PA+3", "PR=5: a coordinate has no =, and no path function stands before it; write LP PR+5 or LP PR-5"),
        ("X=5 Y+3 DR+", "X=5: a coordinate has no =, and no path function stands before it; write C X+5 or C X-5"),
        ("X+5 Y+5 L R0", "X+5: L stands after the coordinates; write L before X+5, at the start of the block"),
        ("X+5 Y+5 Z+9 LN R0", "X+5: LN stands after the coordinates; write LN before X+5, at the start of the block"),
        ("X+5 Y+5 R0", "X+5: coordinates without a path function before them; write L X+5"),
    ],
)
def test_coordinates_in_the_wrong_place_or_with_an_equals_sign(machine, line: str, said: str) -> None:
    """X=5 was called a remark, and L was to be written a second time."""
    text = f"BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+60 A+0 C+0 FMAX M3\n{line}\nM30\nEND PGM P MM"
    [finding] = [one for one in check(text.encode(), machine, _TOOL_AND_PLACE).findings if one.severity == "error"]
    assert (finding.code, finding.line, finding.column, finding.message) == ("VP001", 4, 1, said)


def test_coordinates_without_a_statement_lack_l(machine):
    text = (
        "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+60 A+0 C+0 FMAX M3\n4 Y+20 F100\nL X+5 F100\nM30\nEND PGM P MM"
    )
    [finding] = [one for one in check(text.encode(), machine, _TOOL_AND_PLACE).findings if one.severity == "error"]
    assert (finding.code, finding.line, finding.column) == ("VP001", 4, 3)
    assert finding.message == "Y+20: coordinates without a path function before them; write L Y+20"
    assert [(one.value, one.misspelt) for one in finding.edits] == [("L Y+20", "Y+20")]


@pytest.mark.parametrize(("second", "line"), [("BLK FORM 0.2 X+9 Y+9 Z+0", None), ("* - no second", 4)])
def test_a_stock_with_one_corner_is_told(machine, second, line):
    """No stock was known, and nothing said so."""
    text = f"BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+60 A+0 C+0 FMAX M3\nBLK FORM 0.1 Z X+0 Y+0 Z-9\n{second}\n"
    findings = check(f"{text}L X+5 F9\nM30\nEND PGM P MM".encode(), machine, _TOOL_AND_PLACE).findings
    found = [(one.severity, one.line) for one in findings if one.code == "VP005"]
    assert found == ([] if line is None else [("warning", line)])


@pytest.mark.parametrize(
    ("words", "code", "column"),
    [
        ("L+50 R0 X+5", "VP006", 20),
        ("R0 L+50", None, None),
        ("R+0 LEN50", None, None),
        ("L+50 RL", "VP006", None),
        ("R0 L", "VP001", 15),
        ("L+50 L+40", "VP004", 17),
    ],
)
def test_tool_def_has_words_of_its_own(machine, words, code, column):
    """L is a length and R0 a radius: they were rewritten before they were read, and columns counted back."""
    text = f"BEGIN PGM P MM\nTOOL DEF 1 {words}\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+60 A+0 C+0 FMAX M3\nEND PGM P MM\n"
    options = Options(dialect="heidenhain", wcs={"G54": (0, 0, 0)})
    found = [item for item in check(text.encode(), machine, options).findings if item.line == 2]
    assert [(item.code, item.column) for item in found] == ([(code, column)] if code else [])
