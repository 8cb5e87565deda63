"""Klartext that is not executed: each is refused by its code, at its line, in words that name what is wrong."""

import re

import pytest

from tests.gcode.conftest import make_tool

TOOLS = {1: make_tool(1, 10.0, 10.0)}
HEAD = ["BEGIN PGM T MM", "TOOL CALL 1 Z S1000 F300", "L X+0 Y+0 Z+10 R0 F100 M3"]
DRILL = "CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=100 Q202=5 Q210=0 Q203=0 Q204=20 Q211=0"

PECK = "CYCL DEF 205 P Q200=2 Q201=-5 Q206=100 Q202=2 Q203=0 Q204=2 Q212=0 Q205=0 Q258=1 Q259=1 Q257=0 Q256=0 Q211=0"
BORE_BACK = "CYCL DEF 204 B Q200=2 Q249=5 Q250=20 Q251=3 Q252=1 Q253=750 Q254=200 Q255=0 Q203=0 Q204=9"
BORE = "CYCL DEF 202 B Q200=2 Q201=-5 Q206=100 Q211=0 Q208=0 Q203=0 Q204=5"
MILL_BORE = "CYCL DEF 208 B Q200=2 Q201=-4 Q206=150 Q334=1 Q203=0 Q204=2 Q335=20 Q351=1 Q370=0"


#: Words that Klartext does not have; G54 and others are also names of work offsets (--wcs).
G_WORD = re.compile(r"\bG(0|1|4[0-9]|9[0-9])\b")


@pytest.mark.parametrize(
    ("statements", "code", "words"),
    [
        # feed rates and depths of cycles
        ([DRILL.replace("Q206=100", "Q206=0"), "CYCL CALL"], "VP009", "Q206=0"),
        ([DRILL.replace("Q206=100", "Q206=-150"), "CYCL CALL"], "VP009", "Q206=-150"),
        ([DRILL.replace("Q206=100", "Q206=MAX"), "CYCL CALL"], "VP009", "not FMAX"),
        ([BORE.replace("Q208=0", "Q208=-5") + " Q214=1 Q336=0", "CYCL CALL"], "VP007", "Q208=-5"),
        ([BORE_BACK.replace("Q254=200", "Q254=0") + " Q214=1 Q336=0", "CYCL CALL"], "VP009", "Q254=0"),
        ([PECK.replace("Q212=0", "Q212=1.5"), "CYCL CALL"], "VP007", "give Q205"),
        ([DRILL, "CYCL CALL M99"], "VP017", "both call the cycle; write one of the two"),
        (["CC X+0 Y+0", "C X+9 Y+9 DR"], "VP001", "DR without a sign; write DR+ or DR-"),
        # numbers beyond any
        (
            ["FN 0: Q1 = +99999999", *["FN 3: Q1 = Q1 * Q1"] * 7, "FN 2: Q2 = Q1 - Q1", "L X+Q2"],
            "VP007",
            "Q1 would be 1e+32",
        ),
        (['CALL LBL "²"'], "VP023", "²"),
        (["L X+1 M" + "1" * 5000], "VP002", "M111111111..."),
        (["TOOL CALL " + "9" * 400 + " Z S100"], "VP002", "a tool number is whole"),
        # approach and departure
        (
            ["L X+5 RL", "L X+9", "M128"],
            "VP017",
            "RL of line 4 is still in force; write R0 in line 5, the last move in X and Y",
        ),
        (["L X+5 RL", "L X+9 A+5"], "VP026", "RL of line 4: the contour is plane; write R0 first"),
        (["L X+5 RL", "APPR LT X+9 Y+5 LEN3 RL"], "VP017", "APPR while RL"),
        (["APPR CT X+5 Y+5 CCA90 R3"], "VP005", "needs RL or RR"),
        (["APPR LT X+5 Y+5 RL"], "VP005", "needs LEN"),
        (["APPR LT X+5 Y+5 LEN-3 RL"], "VP007", "greater than 0"),
        (["APPR CT X+5 Y+5 CCA400 R3 RL"], "VP007", "up to 360"),
        (["APPR CT X+5 Y+5 R3 RL"], "VP005", "needs CCA"),
        (["APPR LT X+5 Y+5 LEN3 RL", "L Z-1"], "VP008", "begins in X and Y"),
        (["APPR LT LEN3 RL"], "VP005", "needs X and Y"),
        (["DEP LT LEN3"], "VP017", "right before"),
        (["L X+5", "DEP CT CCA90 R3"], "VP017", "needs RL or RR"),
        (["L X+5 RL", "L X+9", "DEP LT LEN3 X+5"], "VP006", "takes no X and Y"),
        (["L X+5 RL", "L X+9", "DEP LT LEN3 RL"], "VP017", "beside DEP"),
        # contours
        (["L X+10 F0"], "VP007", "greater than 0"),
        (["L X+10", "RND R-2"], "VP007", "greater than 0"),
        (["L X+10", "RND"], "VP005", "length"),
        (["L X+10", "CHF"], "VP005", "length"),
        (["L X+10 FU0"], "VP007", "FU"),
        (["TOOL CALL 1 Z DR-9", "L X+10 RL"], "VP007", "DR"),
        (["TOOL CALL 0 Z", "L X+10 RL"], "VP012", "TOOL CALL 0 leaves no tool before line 5, which needs the radius"),
        (["L X+10", "CHF 2", "CR X+20 Y+0 R+8 DR+"], "VP008", "it needs two lines"),
        (["L X+10", "RND R2", "L Z-5"], "VP008", "X and Y"),
        (["L X+10 Z+5", "RND R2", "L X+10 Y+9 Z+1"], "VP008", "out of the plane"),
        (["L X+10", "RND R2", "M8"], "VP017", "needs the next line or arc"),
        (["L X+10", "RND R2", "L Y+9 RL"], "VP017", "one element later"),
        (["L X+10 A+5", "RND R2"], "VP017", "right before"),
        (["APPR LT X+5 Y+5 LEN3 RL", "L X+9 RL"], "VP017", "first element after APPR"),
        (["CC X+5 Y+0", "C X+10 DR+ A+5"], "VP017", "beside an arc"),
        (["L A+5 RL"], "VP017", "beside a rotary axis"),
        # circles, polar places
        (["L X+900000"], None, ""),
        (["CC X+1 Y+2 Z+3"], "VP006", "two coordinates"),
        (["CC X+1"], "VP005", "one coordinate"),
        (["CC X+0 Y+0", "LP"], "VP005", "PR or PA"),
        (["CC X+5 Y+0", "C Z+5 DR+"], "VP005", "coordinate of its end"),
        (["CC X+5 Y+0", "CP X+5 DR+"], "VP003", "no coordinates of its plane"),
        (["CC X+0 Y+0", "CP PA+90 DR+"], "VP008", "radius is zero"),
        (["CC X+5 Y+0", "CP DR+"], "VP005", "PA or IPA"),
        (["CC X+5 Y+0", "CP IPA+90 DR-"], "VP008", "opposite signs"),
        (["CC X+5 Y+0", "CP PA+90"], "VP005", "DR+ or DR-"),
        (["CC X+5 Y+0", "CP IPA+99999999 DR+"], "VP008", "angle"),
        (["CR X+5 Y+5 DR+"], "VP005", "needs R"),
        (["CR X+0 Y+0 R+5 DR+"], "VP008", "full circle"),
        (["L Z+5", "CT X+5 Y+5"], "VP017", "right before"),
        (["L X+5", "CT X+5 Y+0"], "VP008", "where the tool is"),
        (["L X+5", "CT X-5 Y+0"], "VP008", "straight back"),
        # blocks and words
        (["L X+5 FAUTO FU1"], "VP004", "F AUTO and FU"),
        (["L X+5 RL RR"], "VP004", "RR and RL|RL and RR"),
        (["L X+5 MB MAX"], "VP006", "M140"),
        (["L A"], "VP001", "A"),
        (["CR X+5 Y+5 R+9 DR+ M91"], "VP017", "goes with L"),
        (["L X+5 M91 RL"], "VP017", "beside M91"),
        (["L IX+5 M91"], "VP017", "absolute"),
        (["L M91"], "VP005", "needs coordinates"),
        (["L X+5 A+5 M130"], "VP017", "M130"),
        (["M140 MB-5"], "VP007", "not negative"),
        # tools
        (["TOOL CALL 1.5 Z"], "VP002", "stepped"),
        (["TOOL CALL 1 Z FU2"], "VP002", "F in mm/min"),
        (["TOOL CALL DL+1"], "VP006", "tool number"),
        (["TOOL DEF 1.5 L+5 R+1"], "VP002", "whole"),
        (["TOOL DEF 5 R+1"], "VP005", "needs L"),
        (["CALL LBL 6 REP 2", "LBL 6", "L X+5"], "VP017", "nothing would be repeated"),
        (["TOOL CALL 1 Z S1000 DL-1", "L IZ-5"], "VP017", "TOOL CALL of line 4"),
        (["TOOL CALL 1 Z S1000 DL+1", "L X+5", "L IX+5 IZ-5"], "VP017", "TOOL CALL of line 4"),
        (["L C-20 FMAX", "M94", "L C+10 FMAX"], "VP017", "M94 in line 5 has reduced C-20"),
        (["L C-400 FMAX", "M94 C", "L IC+10 FMAX", "L C+10 FMAX"], "VP017", "reduced C-400"),
        # calls, programs
        (["CALL LBL 1 5"], "VP001", "REP"),
        (["LBL 1", "CALL LBL 1 REP 1.5"], "VP007", "whole"),
        (["CALL PGM A.I"], "VP023", "Klartext program"),
        (["LBL 1", "CALL LBL 1", "LBL 0", "CALL LBL 1"], "VP024", "nested calls"),
        (["CALL SELECTED PGM"], "VP002", "CALL PGM"),
        # formulas and parameters
        (["Q1 = LN 0"], "VP007", "not positive"),
        (["Q1 = ASIN 2"], "VP007", "beyond 1"),
        (["Q1 = 1E500"], "VP001|VP007", ""),
        (["Q1 = 5 $ 3"], "VP001", "in a formula"),
        (["Q1 = " + "( " * 99 + "1" + " )" * 99], "VP001", "nested brackets"),
        (["Q1 = -8 ^ 0.5"], "VP007", "power"),
        (["Q1 = 5 +"], "VP001", "expected a value"),
        (["Q1 = 5 * )"], "VP001", "not a value"),
        (["FN 4: Q1 = +5 DIV +0"], "VP007", "division by zero"),
        (["FN 5: Q1 = SQRT -5"], "VP007", "square root"),
        (["FN 77: Q1 = +5"], "VP002", "FN 77"),
        (["Q99999 = 5"], "VP025", "there are Q0 to"),
        (["Q1"], "VP001", "write Q1 = and its value"),
        (["Q1 ="], "VP005", "without a value"),
        (["QS1 = 5"], "VP002", "quotes"),
        (['QS1 = "A"', "L X+QS1"], "VP025|VP001", ""),
        (['QS1 = "A"', "Q1 = TONUMB( SRC_QS1 )"], "VP007", "TONUMB"),
        (["Q1 = TONUMB( QS1 )"], "VP001", "TONUMB"),
        # cycles
        (["CYCL DEF 200 DRILLING Q200=2 Q200=3"], "VP004", "Q200 appears twice"),
        (["CYCL DEF 200 DRILLING Q206=FU"], "VP002", "mm/min"),
        ([DRILL + " Q999=1"], "VP006", "Q999"),
        ([DRILL.replace("Q200=2", "Q200=-0.5"), "CYCL CALL"], "VP007", "distance"),
        ([DRILL.replace("Q211=0", "Q211=-0.5"), "CYCL CALL"], "VP007", "dwell"),
        ([DRILL.replace("Q201=-5", "Q201=0.5"), "CYCL CALL"], "VP007", "depth is negative"),
        ([DRILL.replace("Q202=5", "Q202=0"), "CYCL CALL"], "VP007", "plunging"),
        ([DRILL.replace("Q202=5", "Q202=0.00001"), "CYCL CALL"], "VP007", "pecks"),
        ([DRILL.replace("Q202=5", "Q202=0.5"), "CYCL CALL"], None, ""),
        (
            [
                "CYCL DEF 208 BORE Q200=2 Q201=-4 Q206=150 Q334=1 Q203=0 Q204=2 Q335=20 Q342=0 Q351=1 Q370=0",
                "CYCL CALL",
            ],
            None,
            "",
        ),
        (["CYCL DEF 208 BORE Q200=2 Q201=-4 Q206=150 Q334=1 Q203=0 Q204=2 Q335=20 Q343=0"], "VP006", "Q343"),
        ([DRILL.replace("Q204=20", "Q204=-0.5"), "CYCL CALL"], "VP007", "Q204"),
        ([DRILL.replace("Q210=0", "Q210=86400.5"), "CYCL CALL"], "VP007", "Q210"),
        ([DRILL.replace("Q210=0", "Q210=86400"), "CYCL CALL"], None, ""),
        ([DRILL + " Q395=1", "CYCL CALL"], "VP002", "Q395"),
        ([PECK.replace("Q258=1", "Q258=-0.5"), "CYCL CALL"], "VP007", "Q258"),
        ([PECK.replace("Q259=1", "Q259=-0.5"), "CYCL CALL"], "VP007", "Q259"),
        ([PECK, "CYCL CALL"], None, ""),
        *(([BORE_BACK + f" Q214={side}", "CYCL CALL"], "VP007", f"Q214={side}") for side in ("0", "5", "1.5")),
        ([BORE_BACK + " Q214=1", "CYCL CALL"], None, ""),
        ([BORE_BACK.replace("Q255=0", "Q255=-0.5") + " Q214=1", "CYCL CALL"], "VP007", "Q255"),
        ([BORE_BACK + " Q214=1", "M5", "CYCL CALL"], "VP017", "spindle"),
        *(([BORE + f" Q214={side}", "CYCL CALL"], "VP007", f"Q214={side}") for side in ("-1", "5", "0.5")),
        ([BORE + " Q214=1", "M5", "CYCL CALL"], "VP017", "spindle"),
        (["CYCL DEF 206 TAP Q200=2 Q201=-5 Q206=100 Q211=0 Q203=0 Q204=5", "M5", "CYCL CALL"], "VP017", "spindle"),
        *(
            ([MILL_BORE.replace(*change), "CYCL CALL"], "VP007", words)
            for change, words in (
                (("Q351=1", "Q351=0"), "Q351"),
                (("Q335=20", "Q335=10"), "wider than the tool"),
                (("Q334=1", "Q334=0"), "infeed"),
                (("Q370=0", "Q370=1"), "Q370"),
                (("Q334=1", "Q334=0.00001"), "pecks"),
            )
        ),
        ([MILL_BORE.replace("Q335=20", "Q335=10.1"), "CYCL CALL"], None, ""),
        (["CYCL DEF 240 C Q200=2 Q343=1 Q201=-2 Q344=0 Q206=9 Q211=0 Q203=0 Q204=5", "CYCL CALL"], "VP002", "Q343"),
        (["CYCL CALL POS"], "VP005|VP017", "coordinates"),
        ([DRILL, "CYCL CALL POS"], "VP005", "coordinates"),
        (["PATTERN DEF"], "VP005", "needs positions"),
        (["PATTERN DEF POS1( X+5 )"], "VP005", "needs Y"),
        (["PATTERN DEF POS1( X+5 Y+5 Z+0 FOO )"], "VP001", "FOO"),
        (["PATTERN DEF ROW1( X+5 Y+5 D+5 NUM2.5 ROT+0 Z+0 )"], "VP007", "whole"),
        # planes, frames
        (["PLANE SPATIAL SPA+5 SPA+5 SPB+0 SPC+0 STAY"], "VP004", "twice"),
        (["PLANE VECTOR BX1 BY0 BZ0 NX1 NY0 NZ0 STAY"], "VP008", "do not define a plane"),
        (["PLANE AXIAL B+5 STAY"], "VP011", "B"),
        (["PLANE AXIAL STAY"], "VP005", "A or C"),
        (["PLANE SPATIAL SPA+5 SPB+0 SPC+0 TURN DIST5 F100"], "VP006", "DIST"),
        (["PLANE SPATIAL SPA+5 SPB+0 SPC+0 STAY F100"], "VP006", "STAY"),
        (["CYCL DEF 11.0 SCALING", "CYCL DEF 11.1 5"], "VP001", "SCL"),
        (["CYCL DEF 11.0 SCALING", "CYCL DEF 11.1 SCL0"], "VP007", "factor"),
        (["CYCL DEF 7.0 DATUM", "CYCL DEF 7.1 B+5"], "VP002|VP011", "B"),
        (["CYCL DEF 247 DATUM SETTING Q338=1"], "VP005", "Q339"),
        (["CYCL DEF 247 DATUM SETTING Q339=9999"], "VP007", ""),
        (["CYCL DEF 247 DATUM SETTING Q339=-1"], "VP007", "0 to 48"),
        (["CYCL DEF 247 A Q339=1", "CYCL DEF 247 A Q339=0"], "VP007", "presets 0 and 1"),
        (["CYCL DEF 32.0 TOLERANCE", "CYCL DEF 32.1 T-1"], "VP007", "not negative"),
        # tool vectors
        (["M128", "LN X+5 Y+0 Z+0 NX0 NY0"], "VP005", "all of"),
        (["M128", "LN X+5 Y+0 Z+0"], "VP005", "NX NY NZ"),
        (["M128", "LN X+5 Y+0 Z+0 TX0 TY0 TZ2"], "VP007", "unit vector"),
        (["LN X+5 Y+0 Z+0 TX0 TY0 TZ1"], "VP017", "M128"),
        (["FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS", "L IA+5"], "VP002", "incremental spatial"),
    ],
)
def test_what_is_not_executed_is_refused(view, statements, code, words):
    text = "\n".join([*HEAD, *statements, "END PGM T"])
    _moves, findings = view(text, dialect="heidenhain", tools=TOOLS, max_repeats=1000)
    if code is None:
        assert findings == ()
        return
    assert findings
    found = findings[0]
    assert found.code in code.split("|"), found
    assert any(part in found.message for part in words.split("|")), found
    assert len(HEAD) < found.line <= len(HEAD) + len(statements) + 1
    assert not G_WORD.search(found.message), "Klartext has no such words"


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ((6, 14, 15, 16, *range(20, 26), *range(270, 277)), "SL cycle"), ((27, 28, 29, 39), "cylinder surface"),
        ((17,), "rigid tapping"),
        ((1, 2, 3, 4, 5), "older controls; write cycle"), ((285, 286, 287), "gears"), ((12,), "CALL PGM"),
        ((18,), "thread cutting"), ((26,), "ellipses"), ((30,), "3-D data"),
        ((225,), "engraving"), ((230,), "multipass"), ((231,), "ruled"), ((239,), "weighs"),
        (range(400, 500), "touch probe"), (range(800, 900), "turning"),
        ((226, 259, 266, 399, 500, 799, 900), "is not executed; docs"),
    ],
)  # fmt: skip
def test_refused_cycles_say_what_they_are(view, numbers, words):
    for number in numbers:
        text = "\n".join([*HEAD, f"CYCL DEF {number} A", "END PGM T"])
        _moves, findings = view(text, dialect="heidenhain", tools=TOOLS)
        assert (findings[0].code, findings[0].line) == ("VP002", len(HEAD) + 1)
        assert f"CYCL DEF {number} is not" in findings[0].message
        assert words in findings[0].message


def test_a_program_begins_with_its_name_and_unit(view):
    _moves, findings = view("BEGIN PGM T\nL X+5 F9\nEND PGM T", dialect="heidenhain")
    assert (findings[0].code, findings[0].line) == ("VP005", 1)


def test_an_unfinished_statement_at_the_end(view):
    _moves, findings = view("BEGIN PGM T MM\nCYCL DEF 200 ~", dialect="heidenhain")
    assert (findings[0].code, findings[0].line) == ("VP001", 2)


@pytest.mark.parametrize(
    "block",
    [
        "L Z+100 R0 FMAX",
        "L R0\nL Z+100 FMAX",
        "L R0 M140 MB10",
        "L R0\nL A+30 FMAX",
        "L R0\nCYCL CALL",
        "L R0\nL Z+1 FMAX M91",
    ],
)
def test_after_r0_the_first_move_is_in_the_plane(view, block):
    """Whether the tool goes sideways onto the contour with anything else depends on the control."""
    head = (
        "BEGIN PGM T MM\nTOOL CALL 1 Z S1000 F500\nL X+0 Y+0 Z+5 A+0 C+0 R0 FMAX M3\nL X+10 Y+10 RL\nL X+30\nL Y+30\n"
    )
    tools = {1: make_tool(1, 10.0, 6.0)}
    found = view(f"{head}{block}\nEND PGM T MM", dialect="heidenhain", tools=tools)[1]
    assert [item.code for item in found[:1]] == ["VP017"]
    for fine in ("L X+50 R0", "L R0\nL X+50\nL Z+100 FMAX", "DEP LT LEN5\nL Z+100 FMAX"):
        assert view(f"{head}{fine}\nEND PGM T MM", dialect="heidenhain", tools=tools)[1] == ()


CIRCLE = "Q216=0 Q217=0 Q244=9 Q245=0 Q246=360 Q247=0 Q241=3 Q203=0 Q204=5 Q301=0"
_SPLIT_DRILL = DRILL.replace(" Q", " ~\n   Q").splitlines()


@pytest.mark.parametrize(
    ("statements", "line", "column", "words"),
    [
        ([*_SPLIT_DRILL, "   Q302=3", "CYCL CALL"], 10, 4, "Q302"),  # the tilde before it is left out
        (["L X+10", "RND R50", "L Y+10"], 2, 5, "RND: no arc of radius 50"),
        ([DRILL.replace("Q201=-5", "Q201=5"), "L X+5", "CYCL CALL", "CYCL CALL"], 1, 30, "Q201=5"),
        ([*_SPLIT_DRILL, "L X+5 M99", "L X+9 M99"], 3, 4, "Q201=5"),
        ([*_SPLIT_DRILL, f"CYCL DEF 220 P Q200=-2 {CIRCLE}"], 10, 16, "Q200=-2"),
        (["17 L X+10  F0"], 1, 12, "F0"),
        (["L M140 MB5 F0"], 1, 3, "F0"),
        (["7 TOOL CALL 1 Z S900 F-5"], 1, 22, "F-5"),
        (["TOOL CALL 1 Z S900 FZ0.1"], 1, 20, "FZ of TOOL CALL"),
        (["TOOL CALL 1 Z S900 X5"], 1, 20, "does not use X"),
        (["CALL PGM  OTHER"], 1, 11, "other.h"),
        (["FN 9: IF +0 EQU +0 GOTO LBL 77"], 1, 29, "LBL 77"),
        (["CALL LBL 1 REP 2.5"], 1, 16, "REP 2.5"),
        (["CYCL DEF 11.0 SCALE", "CYCL DEF 11.1 SCL 0"], 2, 19, "SCL0"),
        (["CYCL DEF 32.0 TOLERANCE", "CYCL DEF 32.1 T-0.1"], 2, 15, "T-0.1"),
        (["CYCL DEF 247 DATUM ~", "  Q339=+99"], 2, 3, "Q339=99"),
    ],
)
def test_an_error_is_where_the_program_has_what_is_wrong(view, statements, line, column, words):
    statements = [one.replace("Q201=-5", "Q201=5") if "Q201=5" in words else one for one in statements]
    _moves, findings = view("\n".join([*HEAD, *statements, "END PGM T"]), dialect="heidenhain", tools=TOOLS)
    assert [(item.line, item.column) for item in findings] == [(len(HEAD) + line, column)]
    assert words in findings[0].message


def test_an_error_of_a_cycle_that_a_called_program_defines_is_at_the_call(view):
    defines = f"BEGIN PGM A MM\nL X+1\n{DRILL.replace('Q201=-5', 'Q201=5')}\nCYCL CALL\nEND PGM A MM\n"
    text = "\n".join([*HEAD, "CALL PGM A", "END PGM T"])
    _moves, findings = view(text, dialect="heidenhain", tools=TOOLS, subroutines={"a": defines.encode()})
    assert [(item.line, item.column) for item in findings] == [(len(HEAD) + 1, None)]
    assert "Q201=5" in findings[0].message


def test_a_corner_of_a_called_program_has_the_line_of_the_call(view):
    rounded = "BEGIN PGM A MM\nL X+20\nRND R5\nL Y+20\nEND PGM A MM\n"
    text = "\n".join([*HEAD, "M8", "M9", "CALL PGM A", "END PGM T"])
    moves, findings = view(text, dialect="heidenhain", tools=TOOLS, subroutines={"a": rounded.encode()})
    assert findings == ()
    assert set(moves.line[-3:].tolist()) == {len(HEAD) + 3}


def test_a_spindle_speed_of_a_called_program_is_told_at_the_call(view):
    called = "BEGIN PGM A MM\nL X+20\nTOOL CALL S2000\nEND PGM A MM\n"
    text = "\n".join([*HEAD, "M8", "M9", "CALL PGM A", "L X+5", "END PGM T"])
    moves, findings = view(text, dialect="heidenhain", tools=TOOLS, subroutines={"a": called.encode()})
    assert findings == ()
    speeds = [(event.line, event.data.get("speed")) for event in moves.events if event.kind == "spindle"]
    assert speeds[-1] == (len(HEAD) + 3, 2000.0)
