"""Siemens: values, variables of the control and calls by hand; and what is refused, by its code, at its line."""

import numpy as np
import pytest

import verne_post
from verne_post.app.assemble import view_moves_plainly
from verne_post.model.machine import Machine

HEAD = "G0 X0 Y0 Z5 F100\n"


@pytest.mark.parametrize(
    ("lines", "end"),
    [
        # values
        ("X=TRUE Y=FALSE", (1, 0)),
        ('X=("A"=="A") Y=("A"<>"A")', (1, 0)),
        ('X=("A"=="B") Y=("A"<>"B")', (0, 1)),
        ('X=ISNUMBER("1.5") Y=ISNUMBER("A")', (1, 0)),
        ('X=NUMBER(SUBSTR("A123",1)) Y=NUMBER(SUBSTR("A123",1,2))', (123, 12)),
        ('DEF STRING[8] Q1A="AB"\nX=STRLEN(Q1A) Y=INDEX(Q1A,"B")', (2, 1)),
        ("DEF REAL Q[3]=REP(4)\nX=Q[0] Y=Q[2]", (4, 4)),
        ("DEF NCK REAL Q=3\nX=Q", (3, 0)),
        # variables of the control
        ("$P_UIFR[1,X,TR]=3\nX=$P_UIFR[1,X,TR]", (3, 0)),
        ("X=$TC_DP3[1,1] Y=$TC_DP6[1,1]", (10, 3)),
        ("X=$TC_DP3[7,1] Y=$TC_DP1[1,1]", (0, 0)),
        ("$TC_DP3[5,1]=40\n$TC_DP6[5,1]=4\n$TC_DP1[5,1]=120\n$TC_DP12[5,1]=0\nX=$TC_DP3[5,1] Y=$TC_DP6[5,1]", (40, 4)),
        ("DEF REAL Q[3]=set(1,2,3)\nX=Q[0] Y=Q[2]", (1, 3)),
        # subprograms: repeated stretches that end with a call, passes that begin anew, an index as it is at the call
        ("G91\nLA: ONE\nREPEATB LA P=2\nY9\nM30\n%_N_ONE_SPF\nX1\nM17", (3, 9)),
        ("G91\nLA: Y1\nLB: ONE\nY2\nREPEAT LA LB P=1\nM30\n%_N_ONE_SPF\nX1\nM17", (2, 4)),
        ("G91\nTHREE P2\nM30\n%_N_THREE_SPF\nDEF INT I\nI=I+3\nX=I\nM17", (6, 0)),
        ("G91\nFOUR(2) P3\nM30\n%_N_FOUR_SPF\nPROC FOUR(REAL V)\nX=V\nV=V+5\nM17", (6, 0)),
        ("R1=5\nSUB(R[R1])\nX=R5 Y=R6\nM30\n%_N_SUB_SPF\nPROC SUB(VAR REAL V)\nV=9\nR1=6\nM17", (9, 0)),
        ("SUB1(2)\nM30\n%_N_SUB1_SPF\nPROC SUB1(REAL Q) DISPLOF\nX=Q\nRET", (2, 0)),
        ("EXTCALL(\"SUB1\")\nM30\n%_N_SUB1_SPF\nX1\nM17", (1, 0)),
        ("G91\nA1: X1\nREPEATB A1 P=2", (3, 0)),
        ("X=$P_UIFR[1,X,SC] Y=$P_UIFR[1,X,MI]", (1, 0)),
        ("G70\nR1=$TC_DP3[1,1] R2=$P_UIFR[1,X,TR]\nG71 X=R1 Y=R2", (10, 0)),  # mm under G70 too
        ("G70 F20\nX1\nR1=$P_EP[X] R2=$P_F\nG71 X=R1 Y=R2", (1, 20)),  # a place in inches, a feed rate in mm
        ("G700\nR1=$P_UIFR[1,C,TR] R2=$P_UIFR[1,Z,RT]\nG710 X=R1 Y=R2", (0, 0)),  # angles
        ("GOTOF \"B\"<<1\nX9\nB1: Y2", (0, 2)),
        ("CTOL=0.1 OTOL=1\nX1", (1, 0)),
        ("G2 X10 Y0 AR=180", (10, 0)),
        ("G111 X0 Y0\nG1 RP=5 AP=90", (0, 5)),
        ("G111 X0 Y0\nG0 AP=0 RP=20\nG91 AP=90 RP=20", (0, 20)),
    ],
)  # fmt: skip
def test_values_and_calls(view, lines, end):
    moves, findings = view(f"{HEAD}{lines}\nM30", dialect="siemens", max_repeats=300)
    assert findings == ()
    assert np.allclose(moves.end[-1, :2], end, atol=1e-9)


def test_what_is_written_to_an_offset_holds_from_the_next_g54_on(view):
    lines = "$P_UIFR[1,X,TR]=10\nX1\nTRANS Z0\nX2\nD1\nX3\nG54\nX4"
    moves, findings = view(f"{HEAD}{lines}\nM30", dialect="siemens")
    assert findings == ()
    origins = [moves.frames[frame].origin[0] for frame in moves.frame[-4:].tolist()]
    assert origins == [0, 0, 0, 10]


@pytest.mark.parametrize(
    ("line", "code", "part"),
    [
        # values
        ('X="A"+1', "VP007", "text"),
        ('X=("A"<"B")', "VP007", "number is needed"),
        ('X=SIN("A")', "VP007", "text"),
        ("X=SIN(1,2)", "VP005", "SIN takes 1"),
        ("X=ATAN2(1)", "VP005", "ATAN2 takes 2"),
        ('X=NUMBER("A")', "VP007", "NUMBER"),
        ('X=NUMBER(SUBSTR("A",-1))', "VP007", "SUBSTR"),
        ("X=" + "(" * 300 + "1" + ")" * 300, "VP001", "nested brackets"),
        ('X="A', "VP001", "not closed"),
        ("X1EX400", "VP007", "beyond any machine"),
        # calls
        ("ONE TWO\nM30\n%_N_ONE_SPF\nM17\n%_N_TWO_SPF\nM17", "VP003", "one call a block"),
        ("ONE M30\n%_N_ONE_SPF\nM17", "VP003", "the end in a separate block"),
        ("S1000 M3\nCYCLE840(5,0,2,-5,,0,4,3,0,11)", "VP007", "no coarse thread"),
        # polar places
        ("G111 X5 Y7\nAP=90 RP=-5", "VP007", "not negative"),
        ("G111 X5 Y7\nAP=90 RP=5\nRP=IC(5)", "VP007", "absolute, also in G91"),
        ("G1 AP=40 RP=20\nG111 X5 Y5\nG91 AP=10", "VP013", "since the last pole"),
        ("G1 AP=40 RP=20\nG111 X5 Y5\nRP=10", "VP005", "until the next pole"),
        ("G1 AP=40 RP=20\nG18 G1 RP=10", "VP005", "until the next pole or plane"),
        ("CIP X10 Y0 I1=DC(5) J1=5", "VP017", "rotary axes"),
        # numbers longer than any
        ('T="²"', "VP012", "²"),
        ("G" + "1" * 5000, "VP002", "G1111"),
        ("R1='H" + "F" * 400 + "'", "VP007", "64 digits"),
        ("A1: X1\nREPEATB A1 P=" + "9" * 25, "VP007", "whole number from 0"),
        ("N" + "1" * 5000 + " X1\nGOTOB N" + "1" * 5001, "VP023", "N111"),
        # variables
        ("DEF REAL X", "VP004", "word of the language"),
        ("DEF INT G1", "VP004", "word of the language"),
        ('R1="A"', "VP007", "R1 is a number"),
        ('DEF REAL Q\nQ="A"', "VP007", "of type REAL"),
        ("DEF STRING[4] Q1A\nQ1A=5", "VP007", "of type STRING"),
        ("DEF REAL Q[2]\nX=Q", "VP025", "indices"),
        ("DEF REAL Q[2]\nX=Q[2]", "VP025", "index 2"),
        ('FOR R1="A" TO 3\nENDFOR', "VP007", "number"),
        # of the control
        ("X=$P_UIFR[1,X]", "VP025", "number, axis, TR"),
        ("X=$P_UIFR[1]", "VP025", "number, axis, TR"),
        ('$P_UIFR[1,X,TR]="A"', "VP007", "number"),
        ("$AC_TIME=5", "VP025", "$AC_TIME"),
        ("X=$TC_DP3[1,2]", "VP012", "edge 1"),
        ("X=$TC_DP3[1]", "VP012", "edge 1"),
        ("$TC_DP3[1,1]=-4", "VP007", "not negative"),
        ("$TC_DP12[1,1]=4", "VP002", "$TC_DP12"),
        ("X=$P_EP[5]", "VP025", "one axis"),
        # calls
        ("SUB1(2)\nM30\n%_N_SUB1_SPF\nPROC SUB1(REAL Q) FOO\nM17", "VP002", "FOO"),
        ("SUB1(2)\nM30\n%_N_SUB1_SPF\nPROC SUB1(REAL)\nM17", "VP001", "name"),
        ("SUB1(2)\nM30\n%_N_SUB1_SPF\nPROC SUB1(REAL Q[2])\nM17", "VP023", "REAL[2]; 2 is none"),
        ("DEF INT W[2]\nSUB1(W)\nM30\n%_N_SUB1_SPF\nPROC SUB1(REAL Q[2])\nM17", "VP023", "W is none"),
        ("DEF REAL W[3]\nSUB1(W)\nM30\n%_N_SUB1_SPF\nPROC SUB1(VAR REAL Q[2])\nM17", "VP023", "W is none"),
        ("DEF REAL W[2,2]\nSUB1(W)\nM30\n%_N_SUB1_SPF\nPROC SUB1(VAR REAL Q[2])\nM17", "VP023", "W is none"),
        ("SUB1(1)\nM30\n%_N_SUB1_SPF\nPROC SUB1(REAL Q[2)\nM17", "VP001", "array"),
        ("SETMS(2)", "VP002", "one spindle"),
        ("EXTERN UP X5", "VP001", "nothing may follow"),
        ("CASE(1) 1 GOTOF A9", "VP001", "expected OF"),
        ("CASE(1) OF 1 A9", "VP001", "expected GOTOF"),
        ("CASE(1) OF 1 GOTOF A9", "VP023", "GOTOF A9"),
        ("CASE(1) OF DEFAULT GOTOF A9 2 GOTOF A9\nA9:", "VP001", "nothing may follow"),
        ("RET(1)", "VP002", "RET"),
        ("MCALL X1", "VP001", "one call"),
        ("MSG 5", "VP001", "'('"),
        ("SETAL(\"A\")", "VP005", "SETAL"),
        ("REPEAT P1", "VP001|VP023", ""),
        ("A1: X1\nREPEAT A1 P1.5", "VP007|VP001", ""),
        ("A1: X1\nX2\nB1: X3\nREPEAT B1 A1", "VP023", ""),
        # motion
        ("ADIS=-1", "VP007", "ADIS"),
        ("G2 X10 I5 TURN=1.5", "VP007", "TURN"),
        ("G2 X10 I5 AR=400", "VP007", "AR"),
        ("G2 X10 Y0 I5 AR=90", "VP003", "say it twice"),
        ("G2 AR=90", "VP008", "centre"),
        ("G1 X10\nCT X20 Y0", "VP008", "straight ahead"),
        ("X=ACP(5)", "VP017", "rotary"),
        ("G2 X10 I=ACP(5)", "VP017", "rotary"),
        ("G110 AP=5", "VP005", "RP= and AP="),
        ("SCALE X2\nCIP X10 Y0 I1=5 J1=5", "VP017", "ellipse"),
        ("SCALE X0", "VP007", "scale"),
        ("TRANS X=IC(5)", "VP001", "plain numbers"),
        ("ROT A5", "VP006", "ROT does not use A"),
        ("ROT RPL=30 X5", "VP003", "RPL="),
        ("G93 BSPLINE X1 Y1 F1", "VP017", "G93"),
        ("BSPLINE X1 SD=2\nX2 SD=3\nX3\nG1", "VP031", "SD=3"),
        ("BSPLINE X1 PL=-1\nX2\nX3\nG1", "VP031", "PL=-1"),
        ("BSPLINE X1 A5\nX2\nX3\nG1", "VP017", "TRAORI"),
        # cycles
        ("MCALL HOLES1(0,0,0,5,5,3)", "VP002", "modal"),
        ("CYCLE81(10,0,1,-5,,0,0,9)", "VP002|VP005", ""),
        ("CYCLE82(10,0,1,-5,,-1)", "VP017", "turns of the spindle"),
        ("S100 M3\nCYCLE83(10,0,1,-5,,-0.0001,,0.0001,,,1,0)", "VP007", "strokes"),
        ("CYCLE800(3,\"\",0,57,0,0,0,30,0,0,0,0,0,-1)", "VP002", "_FR 3"),
        ("CYCLE800(0,\"\",0,128,0,0,0,90,0,0,0,0,0,-1)", "VP007", "no axis for _A"),
    ],
)  # fmt: skip
def test_what_is_not_executed_is_refused(view, line, code, part):
    found = view(f"{HEAD}{line}\nM30", dialect="siemens", max_repeats=300)[1]
    assert found, line
    assert found[0].code in code.split("|"), found
    assert part in found[0].message
    assert found[0].line in range(2, 3 + line.count("\n"))


@pytest.mark.parametrize(("turn", "codes"), [(0.0, []), (30.0, ["VP025"])])
def test_how_far_the_part_is_turned_is_not_read_as_nothing(machine: Machine, turn: float, codes: list[str]) -> None:
    text = b"G54 G0 X0 Y0 Z80 A0 C0\nX=5+$P_UIFR[1,Z,RT]\nM30\n"
    options = verne_post.Options(
        dialect="siemens", tool_length=80.0, wcs={"G54": verne_post.WorkOffset((0.0, 0.0, 40.0), turn)}
    )
    assert [item.code for item in verne_post.check(text, machine, options).findings] == codes


@pytest.mark.parametrize(
    ("call", "code", "column", "count"),
    [
        ("CYCLE83(50,40,2,20,,35,,5,0,0,-1,0)", "VP007", 37, 3),
        ("CYCLE83(50,40,2)", "VP005", 7, 3),
        ("CYCLE84(50,40,2,20,,0,3,6,,0,100,100)", "VP048", 7, 1),
        ("POCKET3(60,40,2,20,30,20,12,0,0,0,2,0,0,500,200,0,11,4)", "VP007", 32, 3),
        ("CYCLE83(50,40,2,20,,35,,5,0,0,1,0,1)", "VP017", 41, 3),
    ],
)
def test_a_wrong_value_of_mcall_stands_in_its_line(call: str, code: str, column: int, count: int) -> None:
    """It was reported at the holes, which are right, with no column."""
    source = f"G71 G90\nT1 M6 D1\nS900 M3\nG0 X0 Y0 Z60 A0 C0\nF600\nMCALL {call}\nX5\nX10\nX15\nMCALL\nM30\n"
    tools = {1: verne_post.Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0)}
    options = verne_post.Options(tools=tools, wcs={"G54": (0, 0, 60)}, dialect="siemens")
    (found,) = verne_post.check(source, "verne", options).findings
    assert (found.code, found.line, found.last_line, found.column, found.count) == (code, 6, 6, column, count)
    # of a subprogram in a file the line that calls it is shown, and no column of another line
    sub = f"PROC HOLES\nMCALL {call}\nX5\nX10\nX15\nMCALL\nM17\n"
    source = source[: source.index("MCALL")] + "HOLES\nM30\n"
    options = options.changed(subroutines={"holes": sub.encode()})
    (found,) = verne_post.check(source, "verne", options).findings
    assert (found.code, found.line, found.column, found.count) == (code, 6, None, count)


def test_a_forgotten_mcall_is_named_once() -> None:
    """The cycle was reported at two lines that do not name it, and nothing named the MCALL."""
    head = "G71 G90\nT1 M6 D1\nS900 M3\nG0 X0 Y0 Z50 A0 C0\nF600\n"
    mcall = "MCALL CYCLE83(50,40,2,20,,35,,5,0,0,1,0)\nX5\nG0 X10\n"
    source = f"{head}{mcall}TRAORI\nG0 A20\nX20\nX30\nM30\n"
    tools = {1: verne_post.Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0)}
    options = verne_post.Options(tools=tools, wcs={"G54": (0, 0, 60)}, dialect="siemens")
    (found,) = verne_post.check(source, "verne", options).findings
    assert (found.code, found.line) == ("VP017", 10)
    assert found.message.startswith(
        "MCALL of line 6 still calls CYCLE83; write MCALL alone before this motion if it is"
    )
    assert verne_post.check(source.replace("TRAORI", "MCALL\nTRAORI"), "verne", options).ok


@pytest.mark.parametrize("modal", ["MCALL ", ""])
def test_a_hole_along_another_axis_than_the_tool_names_axn(modal: str) -> None:
    """Ninety words named MCALL, and _DIR of CYCLE800, which are right."""
    plane = 'G71 G90\nT1 M6 D1\nS900 M3\nG0 X0 Y0 Z60\nCYCLE800(0,"",0,57,0,0,40,20,0,0,0,0,0,-1)\nG0 X0 Y0 Z60\nF600\n'
    source = f"{plane}{modal}CYCLE83(50,40,2,20,,35,,5,0,0,1,0,1)\nX5\n{modal}\nCYCLE800()\nM30\n"
    tools = {1: verne_post.Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 6.0)}
    options = verne_post.Options(tools=tools, wcs={"G54": (0, 0, 60)}, dialect="siemens")
    (found,) = verne_post.check(source, "verne", options).findings
    assert (found.code, found.line, found.column) == ("VP017", 8, 35 + len(modal))
    assert found.message == (
        "CYCLE83: _AXN 1 drills along X, but the tool points along Z: it would be dragged sideways; write _AXN 3"
    )
    assert verne_post.check(source.replace("0,1)\nX5", "0,3)\nX5"), "verne", options).ok


def test_words_of_the_group_that_does_not_decide_are_shown() -> None:
    """ORIAXES had no effect, and ``dump moves`` did not say so."""
    source = "G71 G90\nTRAORI\nORIAXES\nORIWKS\nG0 X0 Y0 Z50 A0 C0\nM30\n"
    for by_group, word in ((False, "ORIAXES"), (True, "ORIWKS")):
        options = verne_post.Options(control={"siemens": {"orientation_by_group": by_group}}, dialect="siemens")
        events = view_moves_plainly(source.encode(), options)[0].events
        assert [event.data["word"] for event in events if event.kind == "without effect"] == [word]


@pytest.mark.parametrize(
    ("text", "dialect"),
    [("G1 X10 RND=50\nY10\nM30", "siemens"), ("G1 X10. ,R50.\nY10.\nM30", "fanuc")],
)
def test_a_corner_that_does_not_fit_is_refused_at_its_own_line(view, text, dialect):
    _moves, findings = view(f"G0 X0. Y0. Z5. F100.\n{text}", dialect=dialect)
    assert [(item.code, item.line) for item in findings] == [("VP008", 2)]


def test_an_orientation_word_of_the_group_without_effect_is_told_with_the_words_that_decide(view):
    moves, _findings = view("TRAORI\nORIAXES\nORIMKS\nG0 X0 Y0 Z50 A0 C0\nM30", dialect="siemens")
    told = [event.data for event in moves.events if event.kind == "without effect"]
    why = "ORIMKS and ORIWKS decide: orientation_by_group = false of [siemens]"
    assert told == [{"word": "ORIAXES", "why": why}]


@pytest.mark.parametrize(
    ("vector", "missing"),
    [
        ("A3=0.1 B3=0.2", "C3"),
        ("C3=0.9 A3=0.1", "B3"),
        ("A3=1", "B3 and C3"),
        ("A3=0.6 C3=0.8", ""),  # a vector of length 1
        ("C3=1", ""),
        ("A3=0.1 B3=0.2 C3=5", ""),
    ],
)
def test_a_tool_axis_that_lacks_a_component(machine, vector, missing):
    program = f"G17 G90 G94 G710 G54\nTRAORI\nS900 M3\nG0 X0 Y0 Z60 A3=0 B3=0 C3=1\nG1 X1 {vector} F500\nM30\n"
    options = verne_post.Options(dialect="siemens", tool_length=80.0, wcs={"G54": (0, 0, 60)})
    findings = verne_post.check(program, machine, options).findings
    found = [(item.line, item.message) for item in findings if item.code == "VP044"]
    assert [line for line, _text in found] == [5] * bool(missing)
    assert all(text.startswith(f"{missing} missing beside") for _line, text in found)
