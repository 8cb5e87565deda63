"""Programs that once moved to a wrong position, or nowhere: each is a mistake that a hostile review found."""

import numpy as np
import pytest

from verne_post.model.findings import InputError


def codes(view, program, **options):
    """Codes and lines of the findings."""
    return [(item.code, item.line) for item in view(program, **options)[1]]


def places(view, program, **options):
    """X, Y, Z of every move of a program without errors."""
    moves, findings = view(program, **options)
    assert findings == ()
    return moves.end[:, :3].round(4).tolist()


# --- fanuc ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("line", "end"), [
    ("G0 X[#1*3/4.5]", [66.6667, 50, -10]), ("G0 X[#1/2-10.]", [40, 50, -10]), ("/3 G0 X#1", [100, 50, -10]),
    ("G5.1 Q3 X0 Y0 Z0", [50, 50, -10]), ("G50.1 X0 Y0", [50, 50, -10]), ("G0 G5.1 Q1 X7.", [7, 50, -10]),
])  # fmt: skip
def test_fanuc_lines_end_where_they_say(view, line, end):
    found = places(view, f"%\nO1\n#1=100.\nG0 X50. Y50. Z-10.\nG1 F100 X50.\n{line}\nM30\n%", dialect="fanuc")
    assert found[-1] == end


@pytest.mark.parametrize(("line", "code"), [
    ("G15 X2.", "VP006"), ("G67 X3.", "VP006"), ("G69 X1.", "VP006"), ("G8 P1 X4.", "VP006"), ("G50 X0", "VP006"),
    ("G10 L2 P0 X0 Y0 Z0", "VP007"), ("G0 X#5061", "VP025"),
    ("#3000=1(ALARM)", "VP027"),
    ("G0 X#101", "VP025"), ("#5221=100.", "VP025"),
])  # fmt: skip
def test_fanuc_lines_that_mean_something_else_there_are_refused(view, line, code):
    assert codes(view, f"%\nO1\nG0 X50. Y50. Z-10. F100\nG1 X60.\n{line}\nM30\n%", dialect="fanuc") == [(code, 5)]


def test_a_list_of_holes_is_called_by_its_number(view):
    program = (
        "%\n"
        "O9\n"
        "G0 Z9\n"
        "G82 G99 X0 Z-5. R2. P500 F100\n"
        "M98 P1000\n"
        "G80\n"
        "M30\n"
        ":1000 (HOLES)\n"
        "X1.\n"
        "X2.\n"
        "M99\n"
        "O1\n"
        "X77.\n"
        "M99\n"
        "%"
    )
    moves, findings = view(program, dialect="fanuc")
    assert findings == ()
    assert sorted(set(moves.end[:, 0].tolist())) == [0.0, 1.0, 2.0]
    assert moves.feed[moves.kind == 3].tolist() == [0.5] * 3


def test_a_work_system_is_no_dwell(view):
    moves, findings = view("%\nO1\nG0 Z9\nG82 X0 Z-5. R2. P500 F100\nG54.1 P2 X10.\nM30\n%", dialect="fanuc")
    assert findings == ()
    assert moves.feed[moves.kind == 3].tolist() == [0.5, 0.5]


def test_k0_stores_a_cycle_and_g86_needs_no_dwell(view):
    assert places(view, "%\nO1\nG0 Z9\nG81 G99 X0 Z-5. R2. F100 K0\nX4.\nM30\n%", dialect="fanuc")[-1] == [4, 0, 2]
    assert codes(view, "%\nO1\nS9 M3 G0 Z9\nG86 X0 Z-5. R2. F100\nM30\n%", dialect="fanuc") == []


# --- rs274 ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "line", ["G92 @5 ^90", "G53 G0 @5 ^90", "G28 @5 ^90", "G10 L2 P1 @3 ^0", "G52 ^5", "G43.1 @1 ^0"]
)
def test_polar_words_are_for_motion(view, line):
    assert codes(view, f"G0 X1 Y1\n{line}\nM2") == [("VP017", 2)]


def test_numbered_lines_may_hold_o_words(view):
    assert places(view, "N10 o1 sub\nN20 G0 X1\nN30 o1 endsub\nN40 o1 call\nN50 O1000\nM2", dialect="rs274") == [
        [1, 0, 0]
    ]
    assert places(view, "(a) N10 (b) o1 repeat [2]\nG91 G0 X1\n(c)o1 endrepeat\nM2", dialect="rs274") == [
        [1, 0, 0],
        [2, 0, 0],
    ]


def test_deleted_o_words_do_not_count(view):
    assert codes(view, "/o1 repeat [2]\nG0 X1\no1 endrepeat\nM2", block_delete=True) == [("VP023", 3)]
    assert codes(view, "/o1 if [0]\nG0 X1\n/o1 endif\nM2", block_delete=True) == []


def test_a_subprogram_may_not_begin_in_a_loop(view):
    assert codes(view, "M98 P100\nM2\no1 repeat [2]\nO100\nG0 X1\no1 endrepeat\nM99", dialect="rs274") == [("VP023", 6)]


def test_p_and_l_serve_one_code(view):
    program = "G0 Z9 F9\nG82 X0 Z-5 R2 P.5\nX2 M98 P7 L2\nM2\nO7\nM99"
    assert codes(view, program, dialect="rs274") == [("VP003", 3)]
    assert codes(view, "G0 Z9 F9\nG82 X0 Z-5 R2 P.5\nG4 X2 P3\nM2", dialect="rs274") == [("VP003", 3)]


def test_m72_brings_the_spindle_back_where_everybody_sees_it(view):
    moves, findings = view("S1000 M3 M8\nM70\nM5\nM9\nM49\nM72\nG1 X3 F100\nM2", dialect="rs274")
    assert findings == ()
    shown = [
        (event.kind, event.data.get("direction") or event.data.get("state"))
        for event in moves.events
        if event.line == 6
    ]
    assert shown == [("spindle", "clockwise"), ("coolant", "off"), ("coolant", "flood"), ("override", None)]
    assert moves.spindle.tolist() == [1000.0]


def test_many_holes_are_bounded(view):
    assert view("F9 G0 Z9\nG81 X0 Y0 Z-1 R1 L10000\nM2", dialect="rs274")[1] == ()
    program = "F9 G0 Z9\n" + "G81 X0 Y0 Z-1 R1 L10000\n" * 300 + "M2"
    assert codes(view, program, dialect="rs274")[0][0] == "VP024"


@pytest.mark.parametrize(("program", "dialect"), [
    (" " * 60_000 + "G0 X1\no1 if [1]\no1 endif\nM2", "rs274"), ("G0" + " " * 60_000 + "X1\nM30", "fanuc"),
    ("(" * 30_000 + "\no1 if [1]\no1 endif\nM2", "rs274"),
    ("N" + "1 " * 30_000 + "G0 X1\no1 if [1]\no1 endif\nM2", "rs274"),
])  # fmt: skip
def test_long_lines_are_read_once(view, program, dialect):
    """These took half a minute when blanks were tried against each other."""
    assert all(item.code in ("VP001", "VP007", "VP010") for item in view(program, dialect=dialect)[1])


# --- user-defined codes ---------------------------------------------------------------------------------------


def test_axis_words_beside_user_defined_codes_are_refused(view):
    remap = {"G68.3": "event", "G68.4": "ignore"}
    for line in ("G68.3 X0 Y0 Z0 R45", "G68.4 X1 Y1"):
        assert codes(view, f"G0 X5 Y5 Z-5\n{line}\nM2", remap=remap) == [("VP006", 2)]
    assert places(view, "G0 X5\nG68.4 G0 X1\nM2", remap=remap)[-1] == [1, 0, 0]


@pytest.mark.parametrize(
    "block", ["S1000 M3 G81 G98 X50 Y0 Z30 R50 F100", "G28 X40 Y10 Z60", "G2 X5 Y5 R50 F100", "G0 X51"]
)
def test_nothing_moves_over_a_turned_table_without_tool_centre_point_control(machine, block):
    from verne_post.app.assemble import build_interpreter_setup
    from verne_post.gcode import interpret_program
    from verne_post.model.options import Options

    source = f"G49 G0 X0 Y0 Z100 A0 C0\nG0 C90\nM429\n{block}\nG80\nM2".encode()
    with pytest.raises(InputError) as error:
        interpret_program(source, build_interpreter_setup(machine, Options(remap={"M429": "tcp off"}, dialect="rs274")))
    assert [(item.code, item.line) for item in error.value.findings] == [("VP017", 4)]


# --- aptcl ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("text", "code", "line"), [
    ("MULTAX/ON\nFEDRAT/9\nGOTO/10,0,0,0,0,1\nCIRCLE/0,0,0,0,0,1,10\nGOTO/0,10,0,0,0.6,0.8", "VP002", 5),
    ("FEDRAT/9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGODLTA/1", "VP017", 4),
    ("FEDRAT/9\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nRAPID\nGOTO/0,10,0", "VP017", 5),
    ("FEDRAT/9\nGOTO/0,0,9\nCYCLE/DRILL,DEPTH,5,CLEAR,2\nGODLTA/1,0,0", "VP017", 4), ("AUXFUN/99", "VP002", 1),
    ("FEDRAT/9\nGOTO/0,0,9\nCYCLE/DRILL,DEPTH,5,CLEAR,2\nUNITS/INCHES", "VP017", 4),
    ("CIRCLE/0,0,0,0,0,1,5\nUNITS/MM", "VP017", 2),
    ("CYCLE/DRILL,DEPTH,5,CLEAR,2\nCIRCLE/10,0,0,0,0,1,10", "VP017", 2),
])  # fmt: skip
def test_statements_that_would_be_half_done_are_refused(view, text, code, line):
    assert codes(view, f"{text}\nFINI", dialect="aptcl") == [(code, line)]


def test_a_new_axis_holds_for_increments(view):
    moves, findings = view("FEDRAT/9\nGOTO/0,0,9\nTLAXIS/0,1,0\nGODLTA/1,0,0\nFINI", dialect="aptcl")
    assert findings == ()
    assert moves.tool_axis[-1].tolist() == [0, 1, 0]


def test_a_drill_rises_before_it_goes_sideways(view):
    head = "FEDRAT/9\nRAPID\nGOTO/0,0,-30\n"
    assert places(view, head + "CYCLE/DRILL,DEPTH,5,CLEAR,2,RETURN,20\nGOTO/10,0,0\nFINI", dialect="aptcl")[1:3] == [
        [0, 0, 20],
        [10, 0, 20],
    ]
    steps = places(view, head + "CYCLE/DRILL,DEPTH,5,CLEAR,2\nGOTO/0,0,0\nGOTO/10,0,20\nFINI", dialect="aptcl")
    assert steps[5:7] == [[0, 0, 22], [10, 0, 22]]


def test_feeds_keep_their_unit_and_come_back(view):
    program = (
        "FEDRAT/500\n"
        "RAPID\n"
        "GOTO/0,0,9\n"
        "UNITS/INCHES\n"
        "CYCLE/DRILL,DEPTH,.1,CLEAR,.1,IPM,50\n"
        "GOTO/0,0,0\n"
        "CYCLE/OFF\n"
        "GOTO/1,0,0\n"
        "FINI"
    )
    moves, findings = view(program, dialect="aptcl")
    assert findings == ()
    assert moves.feed[-1] == pytest.approx(500.0)
    assert np.nanmin(moves.feed) == pytest.approx(500.0)
    program = (
        "FEDRAT/500\n"
        "RAPID\n"
        "GOTO/0,0,9\n"
        "CYCLE/DRILL,DEPTH,1,CLEAR,1,MMPM,50\n"
        "GOTO/0,0,0\n"
        "CYCLE/BORE,DEPTH,1,CLEAR,1\n"
        "GOTO/1,0,0\n"
        "FINI"
    )
    assert view(program, dialect="aptcl")[0].feed[-1] == 500.0


def test_the_spindle_starts_again_the_way_it_turned(view):
    moves, findings = view("SPINDL/1000,RPM,CCLW\nSPINDL/OFF\nSPINDL/ON\nFINI", dialect="aptcl")
    assert findings == ()
    assert [event.data.get("direction") for event in moves.events[:3]] == [
        "counterclockwise",
        "stop",
        "counterclockwise",
    ]


@pytest.mark.parametrize(
    ("text", "dialect"),
    [("X" * 200_000, "siemens"), ("R" + "1" * 200_000 + "=1", "siemens"), ("A" * 200_000 + "/1", "aptcl")],
)
def test_messages_are_short(view, text, dialect):
    found = view(f"G0 X1\n{text}\n" if dialect == "siemens" else f"{text}\nFINI", dialect=dialect)[1]
    assert found
    assert all(len(item.message) < 2000 for item in found)
