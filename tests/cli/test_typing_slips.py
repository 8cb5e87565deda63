"""Edits of an editor for words, numbers and characters that are mistyped or pasted."""

from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("pygls", reason="needs the extra lsp")

from tests.cli.test_quick_fixes import HEADS, NEVER, NGC, SETUP, TOOLS, apply_places, check, inspector, look
from verne_post.base.suggestions import find_correction
from verne_post.cli.lsp.fixes import find_file_fixes, find_fixes
from verne_post.cli.lsp.inspector import Inspector
from verne_post.cli.lsp.places import find_range

__all__ = ["inspector"]

SHIFT = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\nCYCL DEF {} Y+5\nCYCL DEF 7.3 Z+1"
DRILLING = "CYCL DEF 200 DRILLING ~\n Q200=2 ~\n Q201=-1 ~\n Q206=9 ~\n Q202=5 ~\n Q210=0 ~\n {} ~\n Q211=0"
LOOP = "R1=3\n{}\nR1=R1-1\n{}"


def embed(ending: str, lines: str) -> str:
    """A program with these lines."""
    return f"{lines}\n".join(HEADS[ending])


@pytest.mark.parametrize(
    ("ending", "wrong", "right", "said", "title"),
    [
        (
            ".h",
            DRILLING.format("Q203=+O     Q204=+3"),
            ("+O", "+0"),
            "the letter O",
            "Write Q203=+0 in place of Q203=+O",
        ),
        (".h", "PLANE SPATIAL SPA+0 SPB+0 SPC+0 TURM FMAX", ("TURM", "TURN"), "", "Write TURN in place of TURM"),
        (".h", "CYCL DEF 7.0 N\nCYCL DEF 7,1 X+5", ("7,1", "7.1"), "a decimal comma", "Write 7.1 in place of 7,1"),
        (".h", "L X=-2", ("X=", "X"), "have no =", "Write X-2 in place of X=-2"),
        (
            ".h",
            "CALL LBL 1\nM30\nLBL1\nL X+5\nLBL 0\nLBL 10\nL X+6\nLBL 0",
            ("LBL1\n", "LBL 1\n"),
            "a blank is missing",
            "Write LBL 1 in place of LBL1",
        ),
        *(
            (
                ".h",
                f"{wrong}{more}\nM30\nLBL 1\nL X+5\nLBL 0",
                (wrong, "CALL LBL 1"),
                f"{wrong}: a blank is missing; write CALL LBL 1",
                f"Write CALL LBL 1 in place of {wrong}",
            )
            for wrong, more in (("CALL LBL1", ""), ("CALL LBL1", " ; call"), ("CALL  LBL1", ""))
        ),
        (
            ".h",
            "LBL 1\nL IX+5\nCALL LBL1 REP3",
            ("LBL1 REP", "LBL 1 REP"),
            "write CALL LBL 1",
            "Write CALL LBL 1 in place of CALL LBL1",
        ),
        (".mpf", "FOR PASS = 1 TO4\nX3\nENDFOR", ("TO4", "TO 4"), "a blank is missing", "Write TO 4 in place of TO4"),
        (".mpf", "FRO PASS = 1 TO 4\nX3\nENDFOR", ("FRO", "FOR"), "", "Write FOR in place of FRO"),
        (".mpf", LOOP.format("WHIEL R1 > 1", "ENDWHILE"), ("WHIEL", "WHILE"), "", "Write WHILE in place of WHIEL"),
        (".mpf", LOOP.format("WHILE R1 > 1 DO", "ENDWHILE"), ("DO", ""), "has none", "Take DO out"),
        (".mpf", "FOR PAS = 1 TO 3\nX3\nENDFOR", ("PAS", "PASS"), "not defined", "Write PASS in place of PAS"),
        (
            ".mpf",
            "FOR PASS1 TO 3\nX3\nENDFOR",
            ("PASS1", "PASS=1"),
            "an = is missing",
            "Write PASS=1 in place of PASS1",
        ),
        (".mpf", "X=IC40", ("IC40", "IC(40)"), "in parentheses", "Write IC(40) in place of IC40"),
        (".mpf", "GOTOF DONE\nX5\nDONE\nX3", ("\nDONE", "\nDONE:"), "with a colon", "Write DONE: in place of DONE"),
        (
            ".mpf",
            LOOP.format("TOP", "IF R1>1 GOTOB TOP"),
            ("TOP", "TOP:"),
            "with a colon",
            "Write TOP: in place of TOP",
        ),
    ],
)
def test_a_slip_has_one_finding_and_its_edit(
    inspector: Inspector, tmp_path: Path, ending: str, wrong: str, right: tuple[str, str], said: str, title: str
) -> None:
    text = embed(ending, wrong)
    message, _word, made = look(inspector, tmp_path / f"a{ending}", text)
    assert said in message
    assert made[title] == (tmp_path / f"a{ending}", text.replace(wrong, wrong.replace(*right, 1)), True)


@pytest.mark.parametrize(
    ("lines", "wrong", "right", "title"),
    [
        ("MCALL CYCLE82(50;0,2,-5)\nX5\nMCALL", ";0", ",0", "Write , in place of ;"),
        ("CYCLE8250,0,2,-5)", "CYCLE8250", "CYCLE82(50", "Write CYCLE82(50 in place of CYCLE8250"),
        ("CYCLE82 50,0,2,-5)", "CYCLE82 50", "CYCLE82(50", "Write CYCLE82(50 in place of CYCLE82 50"),
        ("CYCLE832)", "CYCLE832)", "CYCLE832()", "Write CYCLE832( in place of CYCLE832"),
        ("CYCLE832(0.05,3,1))", "))", ")", "Take ) out"),
        ("CYCLE832(()", "(()", "()", "Write"),
        ('CYCLE800(0,""",0,57,0,0,0,0,0,0,0,0,0,0,0,1)', '"""', '""', 'Write "" in place of """'),
        ("G0 SUPAD0", "SUPAD0", "SUPA D0", "Write SUPA D0 in place of SUPAD0"),
        ("COMP OF", "COMP OF", "COMPOF", "Write COMPOF in place of COMP OF"),
        ("G0 2X0", "2X0", "X20", "Write X20 in place of 2X0"),
        ("45 X5", "45", "N45", "Write N45 in place of 45"),
        ("G2 X5 CR 3", "CR 3", "CR=3", "Write CR=3 in place of CR 3"),
        ("R1=2\nX=Rl", "Rl", "R1", "Write R1 in place of Rl"),
        ("PASS=2\nX=PA SS", "PA SS", "PASS", "Write PASS in place of PA SS"),
        ("X=A C(5)", "A C", "AC", "Write AC in place of A C"),
        ("R1-5", "R1-5", "R1=-5", "Write R1=-5 in place of R1-5"),
        ("X-l", "X-l", "X-1", "Write X-1 in place of X-l"),
        ("Xl Y2", "Xl", "X1", "Write X1 in place of Xl"),
        ("N-8 X5", "N-8", "N8", "Write N8 in place of N-8"),
        ("G-0 X5", "G-0", "G0", "Write G0 in place of G-0"),
        ("N1l0 CYCLE800()", "N1l0", "N110", "Write N110 in place of N1l0"),
        ("EF REAL _A5=3\nX=_A5", "\nEF", "\nDEF", "Write DEF in place of EF"),
        ("DF REAL _A5=3\nX=_A5", "\nDF", "\nDEF", "Write DEF in place of DF"),
        ("DEF FEAL _A5=3\nX=_A5", "FEAL", "REAL", "Write REAL in place of FEAL"),
        ("DEFF REAL _A5\nX=_A5", "DEFF", "DEF", "Write DEF in place of DEFF"),
        ("DEF REAL _A5=1, _DEP -3\nX=_DEP", "_DEP -3", "_DEP=-3", "Write _DEP=-3 in place of _DEP -3"),
        ("PASS=3\nG0Z=PASS", "G0Z", "G0 Z", "Write G0 Z in place of G0Z"),
        ("R2=5\nX=R2F300", "R2F300", "R2 F300", "Write R2 F300 in place of R2F300"),
        ("R1=3\nIFR1>0 GOTOF DONE\nX5\nDONE:", "IFR1", "IF R1", "Write IF R1 in place of IFR1"),
        ("MCALLCYCLE82(50,0,2,-5)\nMCALL", "MCALLCYCLE", "MCALL CYCLE", "Write MCALL CYCLE82 in place of MCALLCYCLE82"),
        ("CDC(0)", "CDC", "C=DC", "Write C=DC in place of CDC"),
        ("PASS=3\nXPASS", "XPASS", "X=PASS", "Write X=PASS in place of XPASS"),
        ("R2=5\nYR2", "YR2", "Y=R2", "Write Y=R2 in place of YR2"),
        ("R2=5\nX=2R*3", "2R", "R2", "Write R2 in place of 2R"),
        ("DEF REAL _F_R\n_F_R9\nX=_F_R", "_F_R9", "_F_R=9", "Write _F_R=9 in place of _F_R9"),
        ("R 1=5\nX=R1", "R 1", "R1", "Write R1 in place of R 1"),
        ("IF (PASS=0) GOTOF DONE\nX5\nDONE:", "S=0", "S==0", "Write == in place of ="),
        ("FOR PASS = 1 TO 3\nX3\nENDF0R", "ENDF0R", "ENDFOR", "Write ENDFOR in place of ENDF0R in line 8"),
        ("IF 1>2 GOT0F DONE\nX5\nDONE:", "GOT0F", "GOTOF", "Write GOTOF in place of GOT0F"),
        ("IF 1<2 G0TOF DONE\nX5\nDONE:", "G0TOF", "GOTOF", "Write GOTOF in place of G0TOF"),
        ("X=CI(5)", "CI", "IC", "Write IC in place of CI"),
        ("G0 DO", "DO", "D0", "Write D0 in place of DO"),
        ("PASS=3\nG1 =ZPASS", "=ZPASS", "Z=PASS", "Write Z=PASS in place of =ZPASS"),
        ("DEF REAL ZDEPTH=-2\nG1 =ZDEPTH", "=ZDEPTH", "Z=ZDEPTH", "Write Z=ZDEPTH in place of =ZDEPTH"),
        ("TRAORI\nX5 A3=0 B3=0 C3.5", "C3.5", "C3=.5", "Write C3=.5 in place of C3.5"),
        ("CYCLE832(0.1,ROUGH,1)", "ROUGH", "_ROUGH", "Write _ROUGH in place of ROUGH"),
        ("G1 Y-3 0", "Y-3 0", "Y-30", "Write Y-30 in place of Y-3 0 in line 6"),
        ("G5 4", "G5 4", "G54", "Write G54 in place of G5 4"),
        ("RRAFOOF", "RRAFOOF", "TRAFOOF", "Write TRAFOOF in place of RRAFOOF"),
        ("YCLE832()", "YCLE832", "CYCLE832", "Write CYCLE832 in place of YCLE832"),
        ("IF (1<2)) GOTOF DONE\nX5\nDONE:", "))", ")", "Take ) out"),
        ("TILTED FACE", "TILTED FACE", ";TILTED FACE", "Write ;TILTED FACE in place of TILTED FACE"),
        ("FACE(3)\nM30\n%_NFACE_SPF\nPROC FACE(REAL A9)\nX=A9\nRET", "%_NFACE", "%_N_FACE",
         "Write %_N_FACE_SPF in place of %_NFACE_SPF"),
    ],
)  # fmt: skip
def test_a_sign_of_siemens_that_is_missing_or_too_many(
    inspector: Inspector, tmp_path: Path, lines: str, wrong: str, right: str, title: str
) -> None:
    text = embed(".mpf", lines)
    _message, _word, made = look(inspector, tmp_path / "a.mpf", text)
    assert made[title][1] == text.replace(wrong, right)


@pytest.mark.parametrize(
    ("lines", "wrong", "right", "said"),
    [
        ("FN 1: Q1 = +2 - 1,5", "-", "+", "- belongs to FN 2; write +, or FN 2: in place of FN 1:"),
        ('LBL "ON"\nFN 9: IF +1 EQU +2 GOTOL BL "ON"', "GOTOL BL", "GOTO LBL", "the blank is at a wrong place"),
        ('LBL "ON"\nFN 9: IF +1 EQU +2I GOTO LBL "ON"', "+2I", "+21", "a letter in the number"),
        ("FN 0: Q1 - +5", "-", "=", "expected =, found -; write FN 0: Q1 = value"),
        ("FN 9: IF +1 EQ +2 GOTO LBL 0", "EQ", "EQU", "expected EQU, found EQ"),
        (
            'LBL "ON"\nFN 9: IF +1 EQU +2 GOTO LBL ON"',
            'LBL ON"',
            'LBL "ON"',
            "write FN 9: IF value EQU value GOTO LBL label",
        ),
        ("FN 0 Q1 = 5", "FN 0", "FN 0:", "a colon is missing after the number of FN; write FN 0:"),
        ("Q1 5", "Q1", "Q1 =", "an = is missing after the parameter"),
        ('QSl = "A"', "QSl", "QS1", "did you mean QS1?"),
        ("CYCL EF 7.0 N\nCYCL DEF 7.1 X+5", "EF 7.0", "DEF 7.0", "did you mean DEF?"),
        ("VYCL DEF 7.0 N\nCYCL DEF 7.1 X+5", "VYCL", "CYCL", "did you mean CYCL?"),
        ("CYCLDEF 7.0 N\nCYCL DEF 7.1 X+5", "CYCLDEF", "CYCL DEF", "a blank is missing"),
        ("CY CL DEF 7.0 N\nCYCL DEF 7.1 X+5", "CY CL", "CYCL", "a blank is in the word"),
        ("CYCL DEF 7..0 N\nCYCL DEF 7.1 X+5", "7..0", "7.0", "no number of a cycle"),
        ("CYCL DEF 7.0 N\nCYCL DEF 7.l X+5", "7.l", "7.1", "did you mean 7.1?"),
        ("CYCL DEF 7.0 N\nCYCL DEF 71 X+5", "71", "7.1", "the point in the number is missing"),
        ("CYCL DEF 10.0 N\nCYCL DEF 10.1 RT+3", "RT", "ROT", "write ROT+30"),
        ("PLANESPATIAL SPA+0 SPB+0 SPC+0 STAY", "PLANESPATIAL", "PLANE SPATIAL", "a blank is missing"),
        ("BLK FORM 01 Z X-5 Y-5 Z-5\nBLK FORM 0.2 X+5 Y+5 Z+0", "01", "0.1", "the point is missing"),
        ("3 1 L X+5", "3 1", "31", "a blank is in the number of the block"),
        ("3 OLD PART OF 2019", "OLD", "; OLD", "write ; before it if it is a remark"),
        ("L X+2 5 Y+1", "X+2 5", "X+25", "a blank is in the number; did you mean X+25?"),
        ("L X+5 FMA X", "FMA X", "FMAX", "a blank is in the word; did you mean FMAX?"),
        ("L +X5 Y+1", "+X5", "X+5", "did you mean X+5?"),
        (DRILLING.format("Q203--2 Q204=+3"), "Q203--2", "Q203=-2", "an = is missing; write Q203=-2"),
        ('CALL LBL "ON"\nM30\nLBL "ON""\nL X+5\nLBL 0', '"ON""', '"ON"', 'did you mean "ON"?'),
        ("CALL LBL 10\nM30\nLBL l0\nL X+5\nLBL 0", "l0", "10", "a letter in the number; did you mean 10?"),
        ("CALL LBL 7\nM30\nLBK 7\nL X+5\nLBL 0", "LBK", "LBL", "did you mean LBL?"),
        ('CALL LBK "ON"\nM30\nLBL "ON"\nL X+5\nLBL 0', "LBK", "LBL", "did you mean LBL?"),
        ("LBL 1\nL X+5\nCALL LBL l REP 2", "LBL l", "LBL 1", "did you mean 1?"),
        ("LL X+5", "LL", "L", "the letter is there twice"),
        ("FNN 0: Q1 = +5\nL X+Q1", "FNN", "FN", "the letter is there twice"),
        ("F 0: Q1 = +5\nL X+Q1", "F 0", "FN 0", "did you mean FN?"),
        ("Q1l = 5\nL X+Q11", "Q1l", "Q11", "did you mean Q11?"),
        ("K X+5", "K", "L", "did you mean L?"),
        ("LM 8", "LM 8", "L M8", "the blank is at a wrong place"),
        ("l5 L X+5", "l5", "15", "a letter in the number of the block"),
        ("C YCL DEF 7.0 N\nCYCL DEF 7.1 X+5", "C YCL", "CYCL", "a blank is in the word"),
        ("OLANE RESET STAY", "OLANE", "PLANE", "did you mean PLANE?"),
        ("PLANE RESETSTAY", "RESETSTAY", "RESET STAY", "a blank is missing"),
        ("FUNCTION RESE T TCPM", "RESE T TCPM", "RESET TCPM", "did you mean RESET TCPM?"),
        ("FUNCTION TCPM F TXP AXIS POS PATHCTRL AXIS\nFUNCTION RESET TCPM", "TXP", "TCP", "did you mean TCP?"),
        ("L X*5", "X*5", "X+5", "write X+5 or X-5"),
        ("L X1-1", "X1-1", "X-11", "a digit before its sign"),
        ("L X+I", "X+I", "X+1", "the letter I in a number"),
        ("L 4X", "4X", "X4", "the letter stands before its number"),
        ("L X+5 R0 FMA XM8", "FMA XM8", "FMAX M8", "the blank is at a wrong place"),
        ("L X+5 R0FMAX", "R0FMAX", "R0 FMAX", "a blank is missing"),
        ("L X+5 R0 MAX", " MAX", " FMAX", "the F is missing"),
        ("BLK FORM 0..1 Z X-5 Y-5 Z-5\nBLK FORM 0.2 X+5 Y+5 Z+0", "0..1", "0.1", "write BLK FORM 0.1"),
        ("TOOL CALL 1Z S1000", "1Z", "1 Z", "a blank is missing"),
        (DRILLING.format("203=2 Q204=+3"), "203", "Q203", "the Q before the number is missing"),
        (DRILLING.format("Q203-2 Q204=+3"), "Q203-2", "Q203=2", "write Q203=-2 or Q203=2"),
        (DRILLING.format("Q2032 Q204=+3"), "Q2032", "Q203=2", "an = is missing"),
        (DRILLING.format("Q203=*2 Q204=+3"), "Q203=*2", "Q203=+2", "has + or - as its sign"),
        (DRILLING.format("Q203=2 0 Q204=+30"), "Q203=2 0", "Q203=20", "a blank is in the number"),
        (DRILLING.format("Q203+=2 Q204=+3"), "Q203+=2", "Q203=+2", "the sign stands after the ="),
        (DRILLING.format("Q20l=2 Q204=+3").replace("Q201=-1", "Q203=-1"), "Q20l", "Q201", "a letter in the number"),
        ("CYCL DEF 24 DATUM SETTING Q339=+1", "24", "247", "no cycle of these parameters"),
        (DRILLING.format("Q203=+1 Q204=+3").replace("200 DR", "220 DR"), "220", "200", "no cycle of these"),
        (DRILLING.format("Q203 2 Q204=+3"), "Q203 2", "Q203=2", "an = is missing; write Q203=2"),
        (DRILLING.format("Q2 03=2 Q204=+3"), "Q2 03=", "Q203=", "a blank is in the number; write Q203="),
        (DRILLING.format("Q203=2 Q204=+3 CLEAR"), "CLEAR", ";CLEAR", "a remark begins with ;"),
        (DRILLING.replace("{} ~", "Q203=+1 Q204=+3 ;CLEAR"), ";CLEAR", ";CLEAR ~", "write ~"),
        ("L Z+33 300 M8", "Z+33 300", "Z+33 F300", "write Z+33 F300"),
        ("L X+2 250 Y+1", "X+2 250", "X+2.250", "write X+2.250 or X+2250"),
        ("L X+2-50 Y+1", "X+2-50", "X+2.50", "- in a number; write X+250 or X+2.50"),
        (SHIFT.format("8.2"), "8.2", "7.2", "8.2: the line above is of cycle 7; did you mean 7.2?"),
        (SHIFT.format("4.2"), "4.2", "7.2", "4.2: the line above is of cycle 7; did you mean 7.2?"),
        ("CYCL DEF 10.0 ROTATION\nCYCL DEF 11.1 ROT+30", "11.1", "10.1", "of cycle 10; did you mean 10.1?"),
        ("CALL LBL 7\nM30\nLB 7\nL X+5\nLBL 0", "LB 7", "LBL 7", "did you mean LBL?"),
        ('CALL LBL "ON"\nM30\nLL "ON"\nL X+5\nLBL 0', 'LL "ON"', 'LBL "ON"', "did you mean LBL?"),
        ('CALL "ON" LBL\nM30\nLBL "ON"\nL X+5\nLBL 0', '"ON" LBL', 'LBL "ON"', "two words in the wrong order"),
        ("CYCL DEFF 7.0 N\nCYCL DEF 7.1 X+5", "DEFF", "DEF", "did you mean DEF?"),
        ("L X-2 1F50", "X-2 1F50", "X-2 F150", "write X-21 F50 or X-2 F150"),
        ("L X+2:5", "X+2:5", "X+2.5", ": in a number; did you mean X+2.5?"),
        ("Q5 = 3\nL X+5Q", "X+5Q", "X+Q5", "a digit before its letter; did you mean X+Q5?"),
        ("W5 = 3\nL X+Q5", "W5", "Q5", "no parameter; did you mean Q5?"),
        ("L X+5 R00", "R00", "R0", "did you mean R0?"),
        ("X+5 L F50", "X+5 L", "L X+5", "two words in the wrong order"),
        ("DEF CYCL 7.0 N\nCYCL DEF 7.1 X+5", "DEF CYCL", "CYCL DEF", "two words in the wrong order"),
        ("CYCL 7.0 DEF N\nCYCL DEF 7.1 X+5", "7.0 DEF", "DEF 7.0", "two words in the wrong order"),
        ("RESET PLANE STAY", "RESET PLANE", "PLANE RESET", "two words in the wrong order"),
        ("CYCL DEF 7.0 N\nCYCL DEF 7-1 X+5", "7-1", "7.1", "no number of a cycle"),
        ("CYCL DEF 7.0 N\nCYCL DEF 7:1 X+5", "7:1", "7.1", "no number of a cycle"),
        ("CYCL DEF 7.0 N\nCYCL DEF 7 1 X+5", "7 1", "7.1", "no number of a cycle"),
        ("CYCL DEF 7.0 N\nCYCL DEF 7,,1 X+5", "7,,1", "7.1", "no number of a cycle"),
        ("CACL DEF 7.0 N\nCYCL DEF 7.1 X+5", "CACL", "CYCL", "did you mean CYCL?"),
        ("BLK FORM0.1 Z X-5 Y-5 Z-5\nBLK FORM 0.2 X+5 Y+5 Z+0", "FORM0.1", "FORM 0.1", "a blank is missing"),
        ("BLK FORM 9.1 Z X-5 Y-5 Z-5\nBLK FORM 0.2 X+5 Y+5 Z+0", "9.1", "0.1", "no number of a corner"),
        ("BLK FORM 0.1 T X-5 Y-5 Z-5\nBLK FORM 0.2 X+5 Y+5 Z+0", "T X", "Z X", "no axis of the tool"),
        ("BLK FORM 0.1 ZX-5 Y-5 Z-5\nBLK FORM 0.2 X+5 Y+5 Z+0", "ZX-5", "Z X-5", "a blank is missing"),
        ("N7 L X+5", "N7", "7", "a letter in the number of the block"),
        ("7K L X+5", "7K", "7", "a letter in the number of the block"),
        ("CALL LBL 7\nM30\n8W LBL 7\nL X+5\nLBL 0", "8W", "8", "a letter in the number of the block"),
        ("TOOL CALL l Z S1000", "CALL l", "CALL 1", "a letter in the number; did you mean 1?"),
        ("PLANE SPATIAL SPA+l0 SPB+0 SPC+0 STAY", "SPA+l0", "SPA+10", "the letter l in a number"),
        ("J9", "J9", "M9", "write M9"),
        ("M33", "M33", "M3", "did you mean M3?"),
        ("M128\nL X+5 A+5\nM12", "M12\n", "M129\n", "did you mean M129?"),
        ("M138\nM129", "M138", "M128", "M128 may be meant"),
        (DRILLING.format("Q203=+2 ~~ \nQ204=+3"), "~~", "~", "one ~ at the end of a line is enough"),
        (DRILLING.format("Q203=+2 ~\n ~ Q204=+3").replace("+3 ~", "+3"), "~ Q204=+3", "Q204=+3 ~", "write Q204=+3 ~"),
        (DRILLING.format("Q203=3+0 Q204=+3"), "=3+0", "=+30", "a digit stands before the sign"),
        (DRILLING.format("Q20=3+2 Q204=+3"), "Q20=3+2", "Q203=+2", "a digit stands before the ="),
        (DRILLING.format("Q203==-2 Q204=+3"), "==-2", "=-2", "two = stand in it; write Q203=-2"),
        (DRILLING.format("Q203=+I Q204=+3"), "+I", "+1", "a letter in the number"),
    ],
)
def test_a_sign_of_klartext_that_is_missing_or_too_many(
    inspector: Inspector, tmp_path: Path, lines: str, wrong: str, right: str, said: str
) -> None:
    text = embed(".h", lines)
    message, _word, made = look(inspector, tmp_path / "a.h", text)
    assert said in message
    at = text.rindex(wrong, 0, text.index(lines) + len(lines)) if wrong == "-" else text.index(wrong, text.index(lines))
    assert f"{text[:at]}{right}{text[at + len(wrong) :]}" in [fixed for _path, fixed, _settles in made.values()]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("CYCL DEF 11.0 B+3 SCALING", "B+3: CYCL DEF 11.0 has the name of the cycle alone; values stand in 11.1"),
        ("CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT", "expected ROT and an angle in degrees; write ROT+30"),
        ("L A C R0", "A without a number; write A and its value"),
        ("L X+5 R0 0 M3", "0: the letter before this number is missing"),
        (
            "CYCL DEF 7.0 N\nM8\nCYCL DEF 7.1 X+5",
            "CYCL DEF 7.1 goes on with CYCL DEF 7.0 of line 5, and the line between "
            "them ends that cycle; write it after this one",
        ),
        ("CYCL DEF .1 X+5", ".1: the digits before the point are missing, as in CYCL DEF 7.1"),
        ("L X+Q150", "Q150 has no value; the control gives Q100 to Q199, and this one only at the machine"),
        ('QS = "A"', "QS: the number of the parameter is missing, as in QS1 ="),
        ("L X+Q10\nL Y+Q10", "Q10 has no value; set it first"),
        ("L +20", "+20: the letter before this number is missing"),
        ("FN 3: Q1 = +2 *", "expected a value, the line ends; write FN 3: Q1 = value * value"),
        ("LBL 3\nFN 9 IF +1 EQU +2 GOTO LBL 3\nL X+Q5", "a colon is missing after the number of FN; write FN 9:"),
    ],
)
def test_what_is_missing_in_a_line_of_klartext(inspector: Inspector, tmp_path: Path, line: str, said: str) -> None:
    assert look(inspector, tmp_path / "a.h", embed(".h", line))[0] == said


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("R1=2*3SIN(30)", "SIN() is a function of a value; the operator or = before it is missing"),
        (
            "N36 0 X5",
            "0: the letter before this number is missing, such as G0; write it, or N360 if the blank is too many",
        ),
        ("R=5", "R without a number; write R and the number of the parameter"),
        ("G2 X9 CR", "CR: expected '=' and a value after it"),
    ],
)
def test_what_is_missing_in_a_line_of_siemens(inspector: Inspector, tmp_path: Path, line: str, said: str) -> None:
    assert look(inspector, tmp_path / "a.mpf", embed(".mpf", line))[0] == said


@pytest.mark.parametrize(
    ("ending", "lines", "right", "title"),
    [
        (".ngc", "o<h> sub\nX5\no<h> endsubb\no<h> call", ("endsubb", "endsub"), "Write endsub in place of endsubb"),
        (".ngc", "o5 whilee [0]\nX5\no5 endwhile", ("whilee", "while"), "Write while in place of whilee"),
        (".ngc", "#<d>=5\n#<d>=#<d>-1.5\nX#<d>", ("#<d>-1.5", "[#<d>-1.5]"), "Write [#<d>-1.5] in place of #<d>-1.5"),
        (".ngc", "#1=5\nX -#1 / 2 Y5", ("-#1 / 2", "[-#1 / 2]"), "Write [-#1 / 2] in place of -#1 / 2"),
        (".ngc", "#1=5\nX[#1] 250", (" 250", " F250"), "Write F250 in place of 250"),
        (".ngc", "#<a>=5\nX#<a> 250", (" 250", " F250"), "Write F250 in place of 250"),
    ],
)
def test_a_slip_of_blocks_has_one_finding_and_its_edit(
    inspector: Inspector, tmp_path: Path, ending: str, lines: str, right: tuple[str, str], title: str
) -> None:
    text = embed(ending, lines)
    _message, word, made = look(inspector, tmp_path / f"a{ending}", text)
    assert word in right[0]
    assert made[title][1] == text.replace(*right, 1)


TOOL = "[tools]\n1 = { length = 80, diameter = 6 }\n[wcs]\nG54 = [0, 0, 60]\n"
COMPENSATED = "L X+10 RL F500\nL X+20 Y+5 ; end\nL Z+70\nPLANE SPATIAL SPA+0 SPB+10 SPC+0 STAY"
FANUC_TOOL = "%\nO1\nG21 G90 G94 G17 G54\nT1 M6\nM3 S9\nG0 X0. Y0. Z50. A0. C0.\nG1 Z40. F300.\nM30\n%\n"


@pytest.mark.parametrize(
    ("lines", "right"),
    [
        ("WHILE R1<3\nREPET\nR1=R1+1\nX=R1\nUNTIL R1>2\nENDWHILE", "REPEAT"),
        ("FOR R2=1 TO 2\nWHLE R1<3\nR1=R1+1\nX=R1\nENDWHILE\nENDFOR", "WHILE"),
    ],
)
def test_a_misspelt_loop_inside_another_is_one_finding(
    inspector: Inspector, tmp_path: Path, lines: str, right: str
) -> None:
    path = tmp_path / "a.mpf"
    (item,) = check(inspector, path, embed(".mpf", f"R1=0\n{lines}")).findings
    assert item.code == "VP002" and item.message.endswith(f"did you mean {right}?")


@pytest.mark.parametrize(
    ("line", "right"),
    [("X10.+5.", "X[10.+5.]"), ("X- 5 + 3 Y2", "X[- 5 + 3] Y2"), ("#1=5*2", "#1=[5*2]"), ("#1=5-#2", "#1=[5-#2]")],
)
def test_an_expression_that_begins_with_a_number_has_its_brackets(
    inspector: Inspector, tmp_path: Path, line: str, right: str
) -> None:
    text = embed(".ngc", f"#2=1\n{line}")
    message, _word, made = look(inspector, tmp_path / "a.ngc", text)
    assert "an expression is written in brackets" in message
    assert [fixed for _path, fixed, _settles in made.values()] == [text.replace(line, right)]


@pytest.mark.parametrize("line", ["X5 -3", "X5-", "X5--3", "X[5*/2]+3"])  # X5 -3: the letter of a word is missing
def test_a_sign_behind_a_number_may_be_no_operator(inspector: Inspector, tmp_path: Path, line: str) -> None:
    (item,) = check(inspector, tmp_path / "a.ngc", embed(".ngc", line)).findings
    assert "brackets" not in item.message


PASS = "o<p> sub\nG1 X#1 F300\no<p> endsub\nG21 G90 G95 G17 G54\nM3 S9\nG0 X0 Y0 Z50 A0 C0\no<p> call [5]\nM2\n"
LAST_M03 = "{}G21 G90 G94 G17 G54\nG0 X0. Y0. Z50. A0. C0.\nM3 S900\nG1 X5. F500.\nM03\n{}"


@pytest.mark.parametrize(
    ("name", "text", "code", "title", "right"),
    [
        ("a.ngc", embed(".ngc", "G0 Z60\nX5 F300"), "VP009", "Write G1 before line 6", ("X5 F300", "G1\nX5 F300")),
        ("b.ngc", embed(".ngc", "G95\nG4 P1\nX3 F300"), "VP505", "Write G94 in place of G95 in line 5", ("G95", "G94")),
        ("d.ngc", PASS, "VP505", "Write G94 in place of G95 in line 4", ("G95", "G94")),
        ("e.ngc", embed(".ngc", "G95\nX3 F.3\nX4 F900"), "VP505", "Write G94 before line 7", ("X4", "G94\nX4")),
        ("a.h", embed(".h", COMPENSATED), "VP017", "Write R0 after Y+5 in line 6", ("Y+5", "Y+5 R0")),
        ("a.nc", FANUC_TOOL, "VP012", "Write G43 H1 before line 7", ("G1 Z40.", "G43 H1\nG1 Z40.")),
        ("b.nc", LAST_M03.format("%\nO1\n", "%\n"), "VP010", "Write M30 in place of M03 in line 7", ("M03", "M30")),
        ("c.ngc", LAST_M03.format("", ""), "VP010", "Write M30 in place of M03 in line 5", ("M03", "M30")),
        ("b.h", embed(".h", "M182\nL X+3"), "VP002", "Write M128 in place of M182", ("M182", "M128")),
    ],
)  # fmt: skip
def test_what_a_message_says_is_an_edit(
    inspector: Inspector, tmp_path: Path, name: str, text: str, code: str, title: str, right: tuple[str, str]
) -> None:
    found = check(inspector, tmp_path / name, text, TOOL if code in ("VP012", "VP017") else SETUP)
    item = next(one for one in found.findings if one.code == code)
    fixes = find_fixes(inspector, found, item, {tmp_path / name: text}, NEVER)
    made = {fix.title.partition(" (")[0]: f"{text[: fix.begin]}{fix.new}{text[fix.end :]}" for fix in fixes}
    assert made[title] == right[1].join(text.rsplit(right[0], 1))


@pytest.mark.parametrize("before", ["", "M4 S1000\n", "M3 S1000\nM5\n", "T1 M3 S1000\nM6\n"])
def test_a_start_of_a_standing_spindle_at_the_end_is_a_choice(
    inspector: Inspector, tmp_path: Path, before: str
) -> None:
    """M30 was preferred below the M3, which would start the spindle again after the last retract."""
    text = embed(".ngc", "").replace("M3 S1000\n", before).replace("M2\n", "M3\n")
    found = check(inspector, tmp_path / "a.ngc", text)
    item = next(one for one in found.findings if one.code == "VP010")
    assert "starts the spindle, and no motion follows: write M30 there" in item.message
    assert [one.is_choice for one in item.edits] == [True, True]
    made = {
        f"{text[: one.begin]}{one.new}{text[one.end :]}"
        for one in find_fixes(inspector, found, item, {tmp_path / "a.ngc": text}, NEVER)
    }
    assert made == {f"{text}M30\n", f"{text.removesuffix('M3' + chr(10))}M30\n"}


CL = "UNITS/MM\n{}\nSPINDL/RPM,7500,CLW\nRAPID\nGOTO/0,0,50,0,0,1\n{}\nGOTO/0,0,5\nFINI\n"
SIEMENS = "G17 G54 G71 G90 G94\nT1 D1\n{}\nS900 M3\nG0 X0 Y0 Z50\nG1 Z5 F400\nM30\n"


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("a.cls", CL.format("LOADTL/1,ADJST,5", "FEDRAT/MMPM,400"), 2),
        ("a.cls", CL.format("LOADTL1", "FEDRAT/MMPM,400"), 2),
        ("a.cls", CL.format("LOADTL/1", "FEDRATMMPM,400"), 6),
        ("a.mpf", SIEMENS.format("M6 QQ"), 3),
        ("a.mpf", SIEMENS.format("M6 M8X"), 3),
    ],
)
def test_a_refused_line_may_load_the_tool_or_set_the_feed(
    inspector: Inspector, tmp_path: Path, name: str, text: str, line: int
) -> None:
    found = check(inspector, tmp_path / name, text, TOOL).findings
    assert [one.line for one in found if one.severity == "error"] == [line]


def test_an_edit_of_a_called_file_is_none_of_the_call(inspector: Inspector, tmp_path: Path) -> None:
    (tmp_path / "TASCHE.SPF").write_text("PROC TASCHE(RAEL T)\nG1 X=T F500\nRET\n", "utf-8")
    (item,) = check(inspector, tmp_path / "a.mpf", embed(".mpf", "TASCHE(3)")).findings
    assert item.message.startswith("PROC of TASCHE, line 1: RAEL: ") and item.message.endswith("write REAL there")
    assert item.edits == ()


MACRO = "%\nO8002\n#100=0\nWHILE [#100 LT #2] DO1\nG1 Z{} F250.\n#100=#100+1\nEND1\nM99\n%\n"


@pytest.mark.parametrize(
    ("name", "text", "wrong", "right", "caller"),
    [
        ("O8002.nc", MACRO, "-1,5", "-1.5", ""),
        ("O8002.nc", MACRO, "-1,5", "-1.5", "".join(HEADS[".nc"]).replace("M30", "G65 P8002 B3.\nM30")),
        ("O8002.nc", MACRO, "1O.", "10.", "".join(HEADS[".nc"]).replace("M30", "G65 P8002 B0.\nM30")),
        ("s.ngc", "o<s> sub\no5 if [#1 GT 0]\nG1 Z{}\no5 endif\no<s> endsub\n", "1O", "10", ""),
        ("S.SPF", "PROC S(REAL T)\nIF T<0\nG1 X=T\nRET\nENDIF\nTRAORI\n{}\nRET\n", "TRAFOF", "TRAFOOF", ""),
        ("S.SPF", "PROC S(REAL T)\nWHILE T>0\n{}\nT=T-1\nENDWHILE\nRET\n", "G0 DO", "G0 D0", ""),
        ("S.SPF", "PROC S(REAL T)\nFOR R1=1 TO T\n{}\nENDFOR\nRET\n", "G1 X3 SUPAD0", "G1 X3 SUPA D0", ""),
    ],
)  # fmt: skip
def test_a_slip_under_a_condition_of_a_called_file_has_its_edit(
    inspector: Inspector, tmp_path: Path, name: str, text: str, wrong: str, right: str, caller: str
) -> None:
    """Lines that are not executed without the values of a call were not read, and with them the error had no place."""
    path, text, right = tmp_path / name, text.format(wrong), text.format(right)
    if caller:
        check(inspector, tmp_path / "a.nc", caller)
    found = inspector.check(path, {path: text}, NEVER)
    (item,) = (one for one in found.findings if one.severity == "error")
    assert item.column is not None
    (fix,) = find_fixes(inspector, found, item, {path: text}, NEVER)
    assert (apply_places(fix), fix.settles) == (right, True)
    assert inspector.check(path, {path: right}, NEVER).findings == ()


@pytest.mark.parametrize("ending", [".nc", ".ngc"])
@pytest.mark.parametrize(
    ("wrong", "right", "said"),
    [
        ("5\n", "%\n", "5: a program that ends with % begins with one; did you mean %?"),
        ("$\n", "%\n", "$: a program that ends with % begins with one; did you mean %?"),
        ("%\nO1\n(PLATE))\n", "%\nO1\n(PLATE)\n", ")): the ) is there twice; did you mean )?"),
        ("%\nO1\n9PLATE A)\n", "%\nO1\n(PLATE A)\n", "9PLATE A): the digit on the key of the (; did you"),
        ("%\nO1\nPLATE A\n", "%\nO1\n(PLATE A)\n", "PLATE A: words without numbers; write (PLATE A) if"),
    ],
)
def test_a_slip_of_the_first_lines_has_its_edit(
    inspector: Inspector, tmp_path: Path, ending: str, wrong: str, right: str, said: str
) -> None:
    """The % was said to be M5 or a second spindle; no comment had an edit."""
    wrong, right = (one.replace("O1\n", "O1\n" * (ending == ".nc")) for one in (wrong, right))
    rest = f"{NGC}G43 H1 Z50\nG1 X5 F500\nM30\n%\n"
    message, _word, made = look(inspector, tmp_path / f"a{ending}", wrong + rest)
    assert message.startswith(said)
    ((_path, new, settles),) = made.values()
    assert (new, settles) == (right + rest, "if" not in said)


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("tool_length = 8O", "tool_length = 80"),
        ("tool_length = B0", "tool_length = 80"),
        ("tool_length = 9S", "tool_length = 95"),
        ("tool_length = --8", "tool_length = -8"),
        ("tools.1 = { length = 8 0, diameter = 10 }", "tools.1 = { length = 80, diameter = 10 }"),
        ("tools.1 = { length = 8, diameter = 10", "tools.1 = { length = 8, diameter = 10 }"),
        ("tools.1 = length = 80, diameter = 10 }", "tools.1 = { length = 80, diameter = 10 }"),
        ("keep_out.a = 5\n[tools", "keep_out.a = 5\n[tools]"),
        ("tools]", "[tools]"),
        *((wrong, "[tools]") for wrong in ("[tool]s", "[[tools]", "[tools]]", "{tools]")),
        ("t[ools]", "[tools]"),
        ("[.tools]", "[tools]"),
        ("[tools.]", "[tools]"),
        ("[keep_out..a]\nmin = [1, 2, 3]", "[keep_out.a]\nmin = [1, 2, 3]"),
        ("[keep_out a]\nmin = [1, 2, 3]", "[keep_out.a]\nmin = [1, 2, 3]"),
        ("home = [0. 0, 40]", "home = [0, 0, 40]"),
        ("home = [00, 0, 40]", "home = [0, 0, 40]"),
        ("home = [0, 0. 40]", "home = [0, 0, 40]"),
        ("[keep_out,a]\nmin = [1, 2, 3]", "[keep_out.a]\nmin = [1, 2, 3]"),
        ("[kep_out.a]", "[keep_out.a]"),
        ("tolerance = 0..02", "tolerance = 0.02"),
        ('machine = "verne', 'machine = "verne"'),
        ('machine = verne"', 'machine = "verne"'),
        ("[tools]\n[siemens]\ngroups = [0, 0, 60", "[tools]\n[siemens]\ngroups = [0, 0, 60]"),
        ("home = 0, 0, 40]", "home = [0, 0, 40]"),
        ("tool_length = 80mm", "tool_length = 80"),
        ("tool_length = 80 mm", "tool_length = 80"),
        ('tool_length = "80 mm"', "tool_length = 80"),
        ("tools.1 = { length = 80 mm, diameter = 10 }", "tools.1 = { length = 80, diameter = 10 }"),
        ("tools.1 = { length = 80 mm, diameter = 6 mm }", "tools.1 = { length = 80, diameter = 6 mm }"),
        ("home = [0, 0, 40 mm]", "home = [0, 0, 40]"),
        ("tool_length = 80.", "tool_length = 80.0"),
        ("machine = ac_trunnion", 'machine = "ac_trunnion"'),
        ("machine = \u201cac_trunnion\u201d", 'machine = "ac_trunnion"'),
        *(
            (f"allow_rewind = {wrong}", f"allow_rewind = {right}")
            for right, words in (
                (
                    "true",
                    (
                        "True",
                        "ture",
                        "tru",
                        "yes",
                        "on",
                        "1",
                        '"true"',
                        "'on'",
                        '"ture"',
                        "rrue",
                        "yrue",
                        "rue",
                        "tru e",
                    ),
                ),
                ("false", ("FALSE", "flase", "no", "off", "0", '"false"', '"no"')),
            )
            for wrong in words
        ),
        ("tool_length = \u20138", "tool_length = -8"),
        ("tool_length = \u20118", "tool_length = -8"),
        ("tool_length =\u20098", "tool_length = 8"),
        ("machine = \u00abac_trunnion\u00bb # \u00ab\u00bb", 'machine = "ac_trunnion" # \u00ab\u00bb'),
        ("machine = \u2018ac_trunnion\u2019", "machine = 'ac_trunnion'"),
    ],
)
def test_a_slip_of_a_setup_has_its_edit(inspector: Inspector, tmp_path: Path, wrong: str, right: str) -> None:
    (tmp_path / "a.ngc").write_text(embed(".ngc", "X5"))
    path, text = tmp_path / "a.ngc.toml", f"{wrong}\n[wcs]\nG54 = [0, 0, 60]\n"
    path.write_text(text, "utf-8")
    found, _program = inspector.check_file(path, {path: text}, NEVER)
    (item,) = (replace(one, line=one.file_line, file=None) for one in found if one.code == "VP503")
    (fix,) = find_file_fixes(inspector, path, item, {path: text}, NEVER)
    if not fix.words and "not a TOML file" in item.message:  # it was the whole line
        place = find_range(item, lines := text.split("\n"))
        assert lines[place.start.line][place.start.character : place.end.character] == text[fix.begin : fix.end]
    assert f"{text[: fix.begin]}{fix.new}{text[fix.end :]}" == apply_places(fix) == text.replace(wrong, right)


def test_h_without_g43_may_be_g(inspector: Inspector, tmp_path: Path) -> None:
    """H91 that was G91: with H1 in its place the program is legal, and goes elsewhere."""
    for line, is_preferred in (("H91", False), ("G43 H91 Z50.", True)):
        head = "%\nO1\nG90 G94 G17 G21 G54\nT1 M6\nS3000 M3\nG0 A0. C0.\nG43 H1 Z50.\nX0. Y0.\n"
        text = f"{head}G1 X1. F500.\n{line}\nG1 X2.\nM30\n%\n"
        _message, word, made = look(inspector, tmp_path / "a.nc", text, TOOLS)
        assert word == "H91"
        assert made["Write H1 in place of H91"][1:] == (text.replace("H91", "H1"), is_preferred)


@pytest.mark.parametrize("wrong", ["5 80 mm", "80 cm", "8. 5", "9Q", "9.5.0", "8\nto ol = 3"])
def test_a_slip_of_a_setup_has_no_edit_that_leaves_no_toml(inspector: Inspector, tmp_path: Path, wrong: str) -> None:
    """Nor one that makes 80 mm of 80 cm."""
    path, text = tmp_path / "a.ngc.toml", f"tool_length = {wrong}\n[wcs]\nG54 = [0, 0, 60]\n"
    (item,) = inspector.check_file(path, {path: text}, NEVER)[0]
    assert find_file_fixes(inspector, path, replace(item, line=item.file_line, file=None), {path: text}, NEVER) == []


def test_a_jump_in_the_wrong_direction(inspector: Inspector, tmp_path: Path) -> None:
    """That the label stands there does not say that the program means it so."""
    text = embed(".mpf", "GOTOB DONE\nX5\nDONE:\nX3")
    message, word, made = look(inspector, tmp_path / "a.mpf", text)
    assert "GOTOB DONE: the label is after this line, in line 8; write GOTOF" in message
    assert word == "GOTOB"
    assert made["Write GOTOF in place of GOTOB"][1:] == (text.replace("GOTOB", "GOTOF"), False)


@pytest.mark.parametrize(
    ("line", "said", "word"),
    [
        ("L X+5 FAUT0", "FAUT0: no meaning in this language; did you mean FAUTO?", "FAUT0"),
        ("L X+5 F AUT0", "AUT0: no meaning in this language; did you mean AUTO?", "AUT0"),
    ],
)
def test_a_misspelt_feed_rate_of_klartext(
    inspector: Inspector, tmp_path: Path, line: str, said: str, word: str
) -> None:
    text = embed(".h", line).replace("Z S1000", "Z S1000 F900")
    message, underlined, made = look(inspector, tmp_path / "a.h", text)
    assert (message, underlined) == (said, word)
    assert any(fixed == text.replace("AUT0", "AUTO") for _path, fixed, _settles in made.values())


def test_a_loop_that_is_not_closed_is_marked_at_its_word(inspector: Inspector, tmp_path: Path) -> None:
    text = embed(".mpf", "R1=3\nN70 WHILE R1 > 1\nR1=R1-1")
    assert look(inspector, tmp_path / "a.mpf", text)[1] == "WHILE"


def test_a_subprogram_that_is_nearly_that_of_a_file(inspector: Inspector, tmp_path: Path) -> None:
    """The file is read too, so that nothing else is said of the call."""
    (tmp_path / "SLOT.SPF").write_text("PROC SLOT(REAL A)\nG1 X=A\nRET\n")
    text = embed(".mpf", "SLOTT(3)")
    message, _word, made = look(inspector, tmp_path / "a.mpf", text)
    assert message == "SLOTT: no meaning in this language; did you mean SLOT?"
    assert made["Write SLOT in place of SLOTT"][1:] == (text.replace("SLOTT", "SLOT"), True)


@pytest.mark.parametrize(
    ("ending", "line", "is_meant"),
    [
        (".ngc", "X1.2.3(a\u2013b)", False),
        (".ngc", "X1.2.3Y\u20135", False),
        (".mpf", "X1.2.3;a\u2013b", False),
        (".mpf", "X=(1\u20132)", True),
    ],
)
def test_a_character_of_mail_is_sought_at_the_word_that_cannot_be_read(
    inspector: Inspector, tmp_path: Path, ending: str, line: str, is_meant: bool
) -> None:
    message, _word, _made = look(inspector, tmp_path / f"a{ending}", embed(ending, line))
    assert ("en dash" in message) == is_meant


@pytest.mark.parametrize(
    ("ending", "lines", "said"),
    [
        (
            ".ngc",
            "X5\u00a0Y6\u00a0Z49\nX7\u00a0Y8",
            "a no-break space (U+00A0), as copied from a mail or PDF; write a blank",
        ),
        (".mpf", "X5\u00a0Y6\nX7\u00a0Y8", "a no-break space (U+00A0), as copied from a mail or PDF; write a blank"),
        (
            ".h",
            "L X+5\u00a0Y+6\nL X+7\u00a0Y+8",
            "a no-break space (U+00A0), as copied from a mail or PDF; write a blank",
        ),
        (".ngc", "X5 Y\u20136\nX\u20137", "an en dash (U+2013), as copied from a mail or PDF; write a minus (-)"),
        (".mpf", "X5 Y\u20136\nX=\u20137", "an en dash (U+2013), as copied from a mail or PDF; write a minus (-)"),
        (".h", "L X+5 Y\u22126\nL X\u22127", "a minus sign (U+2212), as copied from a mail or PDF; write a minus (-)"),
        (
            ".mpf",
            "MSG(\u201ca\u201d)\nMSG(\u201cb\u201d)",
            'a left double quotation mark (U+201C), as copied from a mail or PDF; write a straight quote (")',
        ),
    ],
)
def test_characters_of_mail_and_pdf(inspector: Inspector, tmp_path: Path, ending: str, lines: str, said: str) -> None:
    """One finding, an edit of its line, and one of all lines; remarks stay as they are."""
    marks = str.maketrans("\u00a0\u2013\u2212\u201c\u201d", ' --""')
    remark = "(a \u2013 b)" if ending == ".ngc" else "; a \u2013 b"
    first, second = lines.split("\n")
    text = embed(ending, f"{first} {remark}\n{second}")
    message, _word, made = look(inspector, tmp_path / f"a{ending}", text)
    assert message == said
    files = [fixed for _path, fixed, _settles in made.values()]
    assert files == [
        embed(ending, f"{first.translate(marks)} {remark}\n{second}"),
        embed(ending, f"{first.translate(marks)} {remark}\n{second.translate(marks)}"),
    ]


CALLED = "M98 P1302\nM98 P1302\nM30\n{}\nX5\nM99"


@pytest.mark.parametrize("code", ["G200", "G100", "G500", "G900", "G211", "G177", "G433", "G431"])
def test_a_code_of_three_digits_is_one_of_the_builder(inspector: Inspector, tmp_path: Path, code: str) -> None:
    """It is executed as no other code, whose units or plane all moves behind it would have; [remap] settles it."""
    text = embed(".ngc", f"{code}\nX3 Y2")
    (item,) = check(inspector, tmp_path / "a.ngc", text).findings
    assert item.message.startswith(f"{code} is not a code of this language") and "[remap]" in item.message
    assert (item.settled_by, find_correction(item.message)) == ((("remap", code),), None)
    near = {"G433": "G43", "G431": "G43.1", "G211": "G21", "G177": "G17"}.get(code)
    made = look(inspector, tmp_path / "a.ngc", text)[2]
    assert [title for title in made if title.startswith("Write")] == [f"Write {near} in place of {code}"] * bool(near)
    assert not any(settles for _path, _text, settles in made.values())


@pytest.mark.parametrize(
    ("ending", "line", "near"),
    [
        (".nc", "G90 G211 G17", "G21"),
        (".nc", "G221", "G21"),  # not G121, G122 and G187 of Haas
        (".nc", "G177", "G17"),
        (".nc", "G880", "G80"),
        (".ngc", "G990", "G90"),
        (".ngc", "G433 H1 Z50", "G43"),
        (".ngc", "G11 X24", "G1"),
        (".ngc", "G38 X24", None),
        (".ngc", "M33", "M3"),
        (".nc", "M55", "M5"),
        (".nc", "M88", "M8"),
        (".nc", "M200", None),
    ],
)
def test_a_digit_that_is_there_twice_is_a_choice(
    inspector: Inspector, tmp_path: Path, ending: str, line: str, near: str | None
) -> None:
    text = embed(ending, line)
    item = next(one for one in check(inspector, tmp_path / f"a{ending}", text).findings if one.severity == "error")
    assert find_correction(item.message) is None
    assert [(one.value, one.is_choice) for one in item.edits] == [(near, True)] * bool(near)


@pytest.mark.parametrize(
    ("ending", "line", "near"),
    [
        (".nc", "N30 S6000 3", "M3"),
        (".nc", "T1 6", "M6"),
        (".nc", "X4 F300 8", "M8"),
        (".nc", "N120 9 (off)", "M9"),
        (".nc", "N120 80", "G80"),
        (".nc", "N120 1 X5", "G1"),
        (".ngc", "N50 8", "M8"),
        (".ngc", "N210 5 ; off", "M5"),
        (".ngc", "N340 2", "M2"),
        (".ngc", "N340 17", "G17"),
    ],
)
def test_a_code_that_has_lost_its_letter(
    inspector: Inspector, tmp_path: Path, ending: str, line: str, near: str
) -> None:
    """Alone in its block, a digit is an M code; behind S, T and F, one is told in Fanuc too."""
    (item,) = check(inspector, tmp_path / f"a{ending}", embed(ending, line)).findings
    assert item.code == "VP001"
    assert [(one.value, one.misspelt, one.is_choice) for one in item.edits] == [(near, near[1:], True)]


@pytest.mark.parametrize(
    ("line", "said", "choices"),
    [
        ("H0 Z5", "G0 may be meant", ["G0"]),  # G43 H0 would cancel the length of the tool
        ("#<d>=3\nH1 Z#<d>", "G1 may be meant", ["G1", "G43 H1"]),
        ("H1", "the G43 of a tool may be missing", ["G43 H1"]),
        ("H2 Z5", "the G43 of a tool may be missing", ["G43 H2"]),
        ("H0", "nothing in the block uses H0", []),
        ("G41.1 D5 X5\nC-34\nG40 X50", "or X-34, if the key beside is meant", ["X-34", "G40"]),
        ("N420 N5", "write M5 if that is meant", ["M5"]),
        ("N420 N77", "N must be the first word of a block", []),
    ],
)
def test_a_key_beside_is_a_choice(
    inspector: Inspector, tmp_path: Path, line: str, said: str, choices: list[str]
) -> None:
    (item,) = check(inspector, tmp_path / "a.ngc", embed(".ngc", line)).findings
    assert said in item.message
    assert [(one.value, one.is_choice) for one in item.edits] == [(one, True) for one in choices]


@pytest.mark.parametrize("line", ["S 6000", "X 20", "X- 20 F 300", "S6000", "S6000 (3)", "G 1 X5 (2 0)"])
@pytest.mark.parametrize("ending", [".nc", ".ngc"])
def test_a_blank_before_a_number_is_none_in_it(inspector: Inspector, tmp_path: Path, line: str, ending: str) -> None:
    assert check(inspector, tmp_path / f"a{ending}", embed(ending, line)).findings == ()


def test_m3_is_not_written_before_a_digit(inspector: Inspector, tmp_path: Path) -> None:
    text = "%\nO1\nG21 G90 G94 G17 G54\nT1 M6\nG0 G43 H1 X0 Y0 Z50 A0 C0\nS6000 3\nG1 X5 F300\nM30\n%\n"
    found = check(inspector, tmp_path / "a.nc", text, TOOLS)
    lost, idle = found.findings
    assert (lost.code, lost.line, idle.code) == ("VP001", 6, "VP050")
    assert [one.value for one in lost.edits] == ["M3"]
    assert find_fixes(inspector, found, idle, {tmp_path / "a.nc": text}, NEVER) == []


@pytest.mark.parametrize(
    ("ending", "line", "said"),
    [
        (".nc", "#1=0\nX10,C#1", ",C0: the size of a corner is greater than 0"),
        (".nc", "X10,C0", ",C0: the size of a corner is greater than 0"),
        (".nc", "X10,C#1", ",C: the size of a corner is greater than 0"),
        (".ngc", "G21 /90 G17 G54", "'/' may only be the first character of a block"),
        (".ngc", "G-17", "G-17 is not a code"),
        (".ngc", "#1=SQRT[4]+FIX[2.7]", "+: a sign without a number; write the number, or brackets around"),
        (".h", "FN 4: Q2 = +1 : +2", "expected DIV, found :; write FN 4: Q1 = value DIV value"),
        (".h", "FN 3: Q2 = +1 DIV +2", "DIV belongs to FN 4; write *, or FN 4: in place of FN 3:"),
        (".h", "CYCL DEF 99.1", "CYCL DEF 99 is not executed"),
        (".h", "CYCL DEF 101 X", "CYCL DEF 101 is not executed"),
        (".h", "CYCL DEF 10.0 ROTATION\nCYCL DEF 102 ROT+3", "CYCL DEF 102 is not executed"),
    ],
)
def test_what_is_no_slip_is_told_as_it_is(
    inspector: Inspector, tmp_path: Path, ending: str, line: str, said: str
) -> None:
    found = check(inspector, tmp_path / f"a{ending}", embed(ending, line))
    (item,) = (one for one in found.findings if one.severity == "error")
    assert item.message.startswith(said)
    assert not any(fix.settles for fix in find_fixes(inspector, found, item, {found.path: found.source}, NEVER))


@pytest.mark.parametrize(
    ("line", "value"),
    [
        ("Q2=9\nFN 9: IF +1 EQU +1 GOTO LBL1\nQ2=0\nLBL 1", 9),
        ("Q1=6\nFN 4: Q2 = +Q1DIV+2", 3),
        ("Q1=6\nFN 4: Q2 = +Q1 DIV2", 3),
        ("FN 5: Q2 = SQRT4", 2),
        ("FN 6: Q2 = SIN30", 0.5),
        ("FN 8: Q2 = +3LEN+4", 5),
        ("Q1=3\nFN 8: Q2 = +4LENQ1", 5),
        ("FN 0: Q2 = +1,5", 1.5),
    ],
)
def test_words_of_fn_need_no_blanks(inspector: Inspector, tmp_path: Path, line: str, value: float) -> None:
    """Where the value is another one, the jump over a line that cannot be read is not taken."""
    path, lines = tmp_path / "a.h", f"{line}\nFN 9: IF +Q2 EQU +{{}} GOTO LBL 7\nX\nLBL 7"
    for wanted, codes in ((value, []), (value + 1, ["VP002"])):
        found = check(inspector, path, embed(".h", lines.format(wanted))).findings
        assert [one.code for one in found if one.severity == "error"] == codes


@pytest.mark.parametrize(
    ("ending", "line", "right"),
    [
        (".ngc", "G53 G0 ZI0", ("ZI0", "Z10")),
        (".ngc", "XI3", ("XI3", "X13")),
        (".ngc", "2G0", ("2G0", "G20")),
        (".ngc", "9G1", ("9G1", "G91")),
        (".ngc", "G17O", ("G17O", "G17")),
        (".ngc", "X-+5", ("X-+5", "X+5")),
    ],
)
def test_what_may_be_meant_is_not_preferred(
    inspector: Inspector, tmp_path: Path, ending: str, line: str, right: tuple[str, str]
) -> None:
    text = embed(ending, line)
    message, marked, made = look(inspector, tmp_path / f"a{ending}", text)
    assert (marked, message.endswith(f"{right[1]} may be meant")) == (right[0], True)
    assert [(fixed, settles) for _path, fixed, settles in made.values()] == [(text.replace(*right), False)]


@pytest.mark.parametrize(
    ("ending", "lines", "wrong", "rights"),
    [
        (".mpf", "G2 X10 Y5 CR-8", "CR-8", ["CR=8", "CR=-8"]),
        (".mpf", "R1=5\nX-R1", "X-R1", ["X=R1", "X=-R1"]),
        (".mpf", "TRAORI\nG1 A3=0 B3-0.05 C3=1", "B3-0.05", ["B3=0.05", "B3=-0.05"]),
        (".mpf", "FOR PASS-1 TO 3\nX=PASS\nENDFOR", "PASS-", ["PASS=", "PASS=-"]),
        (".mpf", "R1-5\nX=R1", "R1-5", ["R1=R1-5", "R1=-5", "R1=5"]),
        (".mpf", "DEF INT K-3\nX=K", "K-3", ["K=3", "K=-3"]),
        (".h", "Q1 - 5", "Q1 -", ["Q1 =", "Q1 = -"]),
        (".ngc", "X10/5 Y1", "10/5", ["10.5", "[10/5]"]),
        (".h", "Q1 = 1\nQ1 - Q1 + 2", "Q1 - Q", ["Q1 = Q", "Q1 = - Q"]),
    ],
)
def test_a_key_beside_that_of_an_equals_sign_or_a_point_is_a_choice(
    inspector: Inspector, tmp_path: Path, ending: str, lines: str, wrong: str, rights: list[str]
) -> None:
    """A sign may be meant as it stands, too: none of the readings is preferred."""
    path, text = tmp_path / f"a{ending}", embed(ending, lines)
    errors = [one for one in check(inspector, path, text).findings if one.severity == "error"]
    assert [wrong.startswith(one.edits[0].misspelt) for one in errors] == [True]
    found = check(inspector, path, text)
    fixes = [one for one in find_fixes(inspector, found, errors[0], {path: text}, NEVER) if one.text is not None]
    assert [(apply_places(one), one.settles) for one in fixes] == [(text.replace(wrong, one), False) for one in rights]


@pytest.mark.parametrize(
    ("lines", "lacks_else"),
    [
        ("IF 1==2\nX5\nELS\nX6\nENDIF", True),
        ("IF 1==2\nX5\nELS\nX6\nELSE\nX7\nENDIF", False),
        ("IF 1==2\nX5\nIF 1==1\nELS\nX6\nENDIF\nENDIF", False),
    ],
)
def test_a_passed_word_is_asked_for_where_it_may_be_else(
    inspector: Inspector, tmp_path: Path, lines: str, *, lacks_else: bool
) -> None:
    found = check(inspector, tmp_path / "a.mpf", embed(".mpf", lines)).findings
    assert ["did you mean ELSE?" in one.message for one in found if one.severity == "error"] == [True] * lacks_else


ZERO = "o<a> sub\nX#<_q>\n0<a> endsub\no<b> sub\no<b> endsub\n#<_q>=5\no<a> call"
#: So that a loop without end is short.
FEW_REPEATS = "[options]\nmax_repeats = 300\n"
ENDLESS = "#1=3\n{}\nX#1\n{}"


@pytest.mark.parametrize(
    ("ending", "lines", "said", "word", "right"),
    [
        (".ngc", "80", "write its letter, such as N80 or G80", "80", None),
        (".nc", "90", "write its letter, such as G90 or O90", "90", None),
        (".nc", "2500 M3", "such as N2500 or S2500", "2500", None),
        (".nc", "N15 0 Y-30", "or a blank in N150", "0", None),
        (".nc", "S 6 000", "S 6 000: blanks mean nothing in a number", "S 6", ("S 6 000", "S6000")),
        (".nc", "X 2 0 Y1", "X 2 0: blanks mean nothing in a number, so that this is X20", "X 2", ("X 2 0", "X20")),
        (".ngc", "X 2 0 Y1", "X 2 0: blanks mean nothing in a number, so that this is X20", "X 2", ("X 2 0", "X20")),
        (".ngc", "X- 2 0 Y1", "so that this is X-20", "X", ("X- 2 0", "X-20")),
        (".ngc", "F1 0 0", "F1 0 0: blanks mean nothing in a number, so that this is F100", "F1", ("F1 0 0", "F100")),
        (".ngc", "G3 X9 Y0 Z6 0I4 J0", "Z6 0: blanks mean nothing in a number", "Z6", ("Z6 0", "Z60")),
        (".nc", "G4 5", "G4 5: blanks mean nothing in a number, so that this is G45", "G4", ("4 5", "4 P5")),
        (".ngc", "G4 0.3", "the time of G4", "0.3", ("4 0.3", "4 P0.3")),
        (".nc", "G28 91 Z0", "so that this is G2891", "G28", ("28 91", "28 G91")),
        (".nc", "6G9", "a digit before its letter", "6G9", ("6G9", "G69")),
        (".ngc", "G3 3Y1 J11", "a digit before its letter", "3Y1", None),
        (".ngc", "X5 A0 0C", "a digit before its letter", "0C", ("0C", "C0")),
        (".ngc", "G433 H1", "as G43 would be", "G433", ("433", "43")),
        (".nc", "G531", "as G53.1 would be", "G531", None),
        (".ngc", "G-1 X5", "did you mean G1?", "G-1", ("-1", "1")),
        (".nc", "N90 #101 10", "an = is missing", "10", ("101 10", "101= 10")),
        (".ngc", "#<d> [2*3]", "an = is missing", "[", ("> [", ">= [")),
        (".ngc", "#6=1\nG0 #X6", "the # before its letter", "#X6", ("#X6", "X#6")),
        (".ngc", "#o1 sub\nG0 X1\n#o1 endsub", "an O word has no #", "#o1", None),
        (".ngc", "o2 if [1]\nX1\n#o2 else\nX2\no2 endif", "an O word has no #", "#o2", ("#o2", "o2")),
        (".ngc", "#1=[2 EQQ 2]", "did you mean EQ?", "EQQ", ("EQQ", "EQ")),
        (".ngc", "#1=[2*C0S[30]]", "did you mean COS?", "C0S", ("C0S", "COS")),
        (".ngc", "#1=[2 EQ I]", "a letter in a number", "I", ("I]", "1]")),
        (".nc", "N2I0 G0 X1", "did you mean N210?", "N2I0", ("N2I0", "N210")),
        (".nc", "N6O G0 X5", "the letter O in a number", "N6O", ("N6O", "N60")),
        (".nc", "N9O0 G0 X5", "the letter O in a number", "N9O0", ("N9O0", "N900")),
        (".nc", "XI3", "the letter I in a number", "XI3", ("XI3", "X13")),
        (".nc", "G43 Hl G0 Z50", "the letter l in a number", "Hl", ("Hl", "H1")),
        (".nc", "G0 Z=60", "words have no =", "Z=60", ("Z=60", "Z60")),
        (".nc", "G0 X-I0 Y2", "the letter I in a number", "X-I0", ("X-I0", "X-10")),
        (".nc", "X5 F30I", "the letter I in a number", "F30I", ("30I", "301")),
        (".nc", "X1l.5", "the letter l in a number", "X1l.5", ("X1l", "X11")),
        (".nc", "G0 -X40", "the sign before its letter", "-X40", ("-X40", "X-40")),
        (".nc", "G54 0G X0", "a digit before its letter", "0G", ("0G", "G0")),
        (".nc", "#1=5\n#1=#1-3,", "a comma after a number", "3,", ("3,", "3.")),
        (".nc", "#31=5\nX[#3l*2]", "a letter in a number", "#3l", ("#3l", "#31")),
        (".nc", "#1=6 HOLES)", "no '(' begins; write (HOLES)", "HOLES", ("HOLES", "(HOLES")),
        (".nc", "#1=2\nX#1*2]", "written in brackets", "#1*2]", ("#1*2]", "[#1*2]")),
        (".nc", "#1=1\nN8 [#1 LT 3] DO1\n#1=#1+1\nEND1", "WHILE is missing", "[", ("[#1 LT", "WHILE [#1 LT")),
        (".nc", "#1=1\nWHILE [#1 LT 3] DO1\n#1=#1+1\nENDI", "did you mean END1?", "ENDI", ("ENDI", "END1")),
        (".nc", "#1=1\nWHILE [#1 LT 3] DO1\n#1=#1+1\nEND+1", "did you mean END1?", "END+1", ("END+1", "END1")),
        (".nc", "#1=1\nIF [#1 EQ 3 GOTO 5\nN5", "a ] is missing before GOTO", "GOTO 5", ("3 GOTO", "3] GOTO")),
        (".nc", "#1=1\nIF [#1 GT 1O] GOTO 5\nN5", "the letter O in a number", "1O", ("1O", "10")),
        (".nc", "G63.1", "as G53.1 would be", "G63.1", None),
        (".nc", "B70 X5\nN80 X6", "N70 may be meant, a block number", "B70", ("B70", "N70")),
        (".nc", "M-8", "did you mean M8?", "M-8", ("M-8", "M8")),
        (".nc", "X5\n8", "such as M8 or O8", "8", None),
        (".nc", "G0 A0, C0", "a comma after a number", "A0,", ("A0,", "A0")),
        (".ngc", "o4 repeat 4\nX5\no4 endrepeat", "values of o4 repeat are written", "4", (" 4\n", " [4]\n")),
        (".ngc", "o4 sub\nX#1\no4 endsub\no4 call [0] [5]]", "']' without the '['", "]", ("]]", "]")),
        (".ngc", ZERO, "the digit 0 in place of the letter o", "0<a>", ("0<a>", "o<a>")),
        (".ngc", "#1=3\no4 o\n#1=[#1-1]\no4 while [#1 GT 0]", "did you mean do?", "o", ("o4 o\n", "o4 do\n")),
        (".nc", "#1=1\nWHIEL [#1 LT 3] DO1\n#1=#1+1\nEND1", "did you mean WHILE?", "WHIEL", ("WHIEL", "WHILE")),
        (".nc", "#1=1\nWHILE [#1 LT 3] DO1\n#1=#1+1\nENDD1", "did you mean END?", "ENDD", ("ENDD", "END")),
        (".nc", "#1=1\nWHILE [#1 LT 3] DO1\n#1=#1+1\nENDREPEAT", "such as END1", "ENDREPEAT", None),
        (".nc", "#1=1\nIF [#1 LT 3] THNE #1=4", "did you mean THEN?", "THNE", ("THNE", "THEN")),
        (".nc", "IF [1 LT 3]] GOTO 1\nN1 X4", "']' without the '['", "]", ("]]", "]")),
        (".ngc", "= 0\nX#<i>", "'=' does not begin a word", "=", None),
        (".ngc", "#<d> = =2.4\no2 while [#<d> LT 2]\no2 endwhile", "compares, and gives no value", "=", None),
        (".ngc", "#<s>=3\nX2 Z-3<s>", "did you mean #<s>?", "3<s>", ("3<s>", "#<s>")),
        (".ngc", "#<s>=3\nX13<s>", "'<' does not begin a word", "<", None),
        (".ngc", "X5 I3 J2", "no G2 or G3 is in force", "I3", None),
        (".nc", "N100 P41301", "the M98 of a call may be missing", "P41301", None),
        (".nc", "Z34558860", "its decimal point may be missing", "Z34558860", None),
        (".nc", CALLED.format("O1302\nO1302"), "O1302 appears twice, first in line 10", "O1302", None),
        (".nc", CALLED.format("1302"), "line 10 begins with 1302, which lacks", "P1302", ("\n1302", "\nO1302")),
        (".nc", CALLED.format("O13002"), "which nothing calls", "P1302", ("O13002", "O1302")),
        (".nc", "X5 M088", "M088: the digit is there twice", "M088", ("M088", "M08")),
        (".ngc", "X5 M055", "M055: the digit is there twice", "M055", ("M055", "M05")),
        (".mpf", "X5 M088", "M088: the digit is there twice", "M088", ("M088", "M08")),
        (".h", "L X+5 M055", "M055: the digit is there twice", "M055", ("M055", "M05")),
        (".ngc", "G9O G94 G17 G55", "G9O: the letter O in a number; did you mean G90?", "G9O", ("G9O", "G90")),
        (".nc", "G011 X5 F300", "G011: the digit is there twice; did you mean G01?", "G011", ("G011", "G01")),
        (".mpf", "G011 X5 F300", "G011: the digit is there twice", "G011", ("G011", "G01")),
        (".mpf", "M12", "M12: no meaning in this language; [remap]", "M12", None),
        (".ngc", "X-,8", "X-,8: a decimal comma in a number; did you mean X-.8?", "X-,8", ("X-,8", "X-.8")),
        (".nc", "Y,8", "Y,8: a decimal comma in a number; did you mean Y.8?", "Y,8", ("Y,8", "Y.8")),
        (".mpf", "X=,8", "did you mean X=.8?", "X=,8", ("X=,8", "X=.8")),
        (".nc", "G0 A C0", "A needs a number, found 'C'", "A", None),
        (".ngc", "G0 X Y5", "X needs a number, found 'Y'", "X", None),
        (".nc", "M40\nO9010\nX5\nM99", "M40: no meaning in this language", "M40", None),
    ],
)  # fmt: skip
def test_a_slip_of_a_block_is_told_at_its_word(
    inspector: Inspector, tmp_path: Path, ending: str, lines: str, said: str, word: str, right: tuple[str, str] | None
) -> None:
    text = embed(ending, lines)
    if lines.endswith("M99"):
        text = text.replace("M99\nM30\n", "M99\n")
    message, marked, made = look(inspector, tmp_path / f"a{ending}", text)
    assert said in message
    assert marked == word
    if right is not None:
        assert text.replace(lines, lines.replace(*right, 1)) in [fixed for _path, fixed, _settles in made.values()]


@pytest.mark.parametrize(
    ("ending", "lines", "said", "line"),
    [
        (".ngc", ENDLESS.format("o5 while [#1 GT 0]", "o5 endwhile"), "no line of it sets #1", 6),
        (".nc", ENDLESS.format("WHILE [#1 GT 0] DO1", "END1\n#1=0"), "the loop of lines 8 to 10, and no line", 8),
        (".nc", "N5 X5\nGOTO5", "the last in the loop of lines 7 to 8; if", 7),
        (".mpf", "R1=1\nWHILE (R1<5)\nX5\nENDWHILE", "no line of it sets R1, which its condition asks", 7),
        (".mpf", "R1=1\nREPEAT\nX5\nN10 R1=R1-1\nUNTIL R1>5", "the last in the loop of lines 8 to 10; if", 8),
        (".mpf", "LOOP\nX5\nENDLOOP", "the last in the loop of lines 6 to 8; if", 6),
        (".h", "FN 0: Q1 = +0\nLBL 1\nL X+5\nFN 12: IF +Q1 LT +5 GOTO LBL 1", "no line of it sets Q1, which", 7),
        (".h", "LBL 1\nL X+5\nCALL LBL 1", "what line 7 calls leads to line 7 again", 7),
    ],
)
def test_a_loop_without_end_is_named(
    inspector: Inspector, tmp_path: Path, ending: str, lines: str, said: str, line: int
) -> None:
    (tmp_path / "verne-post.toml").write_text(FEW_REPEATS)
    (item,) = check(inspector, tmp_path / f"a{ending}", embed(ending, lines)).findings
    assert (item.code, item.line) == ("VP024", line)
    assert said in item.message


@pytest.mark.parametrize(
    ("ending", "lines", "said"),
    [
        (".mpf", "R1=0 R2=0\nWHILE R1<5\nR2=R2+900\nX=R2\nENDWHILE", "no line of it sets R1"),
        (".h", "Q1 = 0\nQ2 = 0\nLBL 1\nQ2 = Q2 + 900\nL X+Q2\nFN 12: IF +Q1 LT +5 GOTO LBL 1", "no line of it sets Q1"),
        (".nc", "#1=0\n#2=0\nWHILE [#1 LT 5] DO1\n#2=#2+900\nX#2\nEND1", "no line of it sets #1"),
        (".mpf", "FOR R1=1 TO 200\nX=R1*900\nENDFOR", "in the loop of lines 7 to 8"),
    ],
)
def test_a_value_that_grows_in_a_loop_is_one_finding(
    inspector: Inspector, tmp_path: Path, ending: str, lines: str, said: str
) -> None:
    (tmp_path / "verne-post.toml").write_text(FEW_REPEATS.replace("300", "900"))
    (item,) = check(inspector, tmp_path / f"a{ending}", embed(ending, lines)).findings
    assert item.code == "VP007"
    assert said in item.message


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ("X1000000\nY2000000", ("X1e+06 is beyond any machine", "Y2e+06 is beyond any machine")),
        (
            "X=R1*90000\nY=R1*80000",
            (
                "X180000 is beyond any machine, in the loop of lines 7 to 9",
                "Y160000 is beyond any machine, in the loop",
            ),
        ),
    ],
)
def test_values_beyond_any_machine_in_a_loop_are_one_finding_each(
    inspector: Inspector, tmp_path: Path, lines: str, said: tuple[str, ...]
) -> None:
    text = embed(".mpf", f"FOR R1=1 TO 4\n{lines}\nENDFOR")
    found = check(inspector, tmp_path / "a.mpf", text).findings
    assert [item.code for item in found] == ["VP007", "VP007"]
    assert all(item.message.startswith(one) for item, one in zip(found, said, strict=True))


def test_a_loop_that_calls_a_subprogram_may_set_its_variable_there(inspector: Inspector, tmp_path: Path) -> None:
    (tmp_path / "verne-post.toml").write_text(FEW_REPEATS)
    (tmp_path / "STEP.spf").write_text("R1=R1+0.00001\nG1 X=R1\nRET\n")
    (item,) = check(inspector, tmp_path / "a.mpf", embed(".mpf", "R1=1\nWHILE R1<5\nSTEP\nENDWHILE")).findings
    assert item.code == "VP024"
    assert "no line of it sets" not in item.message


@pytest.mark.parametrize(
    ("ending", "n_copies", "head", "code", "line"),
    [(".nc", 2, "", "VP051", 11), (".ngc", 2, "", "VP051", 6), (".nc", 1, "%\n", "VP021", 2)],
)
def test_a_program_that_stands_twice_or_ends_before_it_begins(
    inspector: Inspector, tmp_path: Path, ending: str, n_copies: int, head: str, code: str, line: int
) -> None:
    text = head + embed(ending, "X5") * n_copies
    item = next(iter(check(inspector, tmp_path / f"a{ending}", text).findings))
    assert (item.code, item.line) == (code, line)


@pytest.mark.parametrize(
    ("lines", "said", "line"),
    [
        ("_DEP=3\nX=_DEP Y=_DEP\nX=_DEP", "_DEP: not defined", 6),
        ("R1= R2=-3\nX=R2", "the value after = is missing", 6),
        ("R1=SIN((30)\nX=R1", "expected ',' or ')' in SIN", 6),
        ("R21200\nX3 F=R2", "an = and its new value are missing", 6),
        ("G900", "it has G500 and G700 and G90", 6),
        ("X5 N3", "a block number stands at the beginning", 6),
        ("N5 -4 Y5", "-4: the letter before this number is missing", 6),
        ("R1=3\nN-100 TOP:\nR1=R1-1\nIF R1>0 GOTOB TOP", "did you mean N100?", 7),
    ],
)
def test_what_follows_from_a_slip_of_siemens_is_not_told(
    inspector: Inspector, tmp_path: Path, lines: str, said: str, line: int
) -> None:
    (item,) = check(inspector, tmp_path / "a.mpf", embed(".mpf", lines)).findings
    assert item.line == line
    assert said in item.message


#: A pocket whose first line and first corner have changed places, and a contour that is too narrow by itself.
SWAPPED_LINES = {
    "a.mpf": "T1 D1 M6\nS900 M3\nF500\nG0 X30 Y30 Z0\nG41 G1 Y0\nG3 X60 Y10 CR=10\nG1 X50\nY50\n"
    "G3 X50 Y60 CR=10\nG1 X10\nG40 Y30\nG0 X30 Y30\nG41 G1 Y0\nX60\nG3 X62 Y2 CR=2\nG40 G1 X30\nM30\n",
    "a.h": "BEGIN PGM A MM\nTOOL CALL 1 Z S900\nL X+30 Y+30 Z+0 R0 FMAX M3\nL Y+30 FMAX\nL Y+0 RL F500\n"
    "CR X+60 Y+10 R+10 DR+\nL X+50\nL Y+50\nCR X+50 Y+60 R+10 DR+\nL X+10\nL Y+30 R0\nL X+30 Y+30\nL Y+0 RL\n"
    "L X+60\nCR X+62 Y+2 R+2 DR+\nL X+30 R0\nEND PGM A MM\n",
}


@pytest.mark.parametrize("name", SWAPPED_LINES)
def test_corners_of_a_contour_whose_arc_is_refused_are_no_errors(
    inspector: Inspector, tmp_path: Path, name: str
) -> None:
    """The contour behind a refused arc leads elsewhere; that of the next compensation is looked at as ever."""
    setup = "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 80, diameter = 16 }\n"
    found = check(inspector, tmp_path / name, SWAPPED_LINES[name], setup).findings
    said = [(item.code, item.line) for item in found if item.severity == "error"]
    assert said == [("VP008", 6), ("VP026", 15)]


@pytest.mark.parametrize(
    ("line", "wrong", "near"),
    [
        *(("CR X+5 Y+5 R+30 {} F9", wrong, ["DR-"]) for wrong in ("SR-", "DE-", "FR-", "DT-")),
        ("CR X+5 Y+5 R+30 {} F9", "DE+", ["DR+"]),
        *(("L X+5 {} F9", wrong, near) for wrong, near in (("EL", ["RL"]), ("TR", ["RR"]), ("RK", ["RL"]))),
        *(("L X+5 {} F9", wrong, near) for wrong, near in (("RT", ["RR"]), ("E0", ["R0"]), ("N8", ["M8"]))),
        ("L X+5 {} F9", "N99", ["M99"]),
    ],
)
def test_a_short_word_of_klartext_with_the_key_beside_the_right_one(
    inspector: Inspector, tmp_path: Path, line: str, wrong: str, near: list[str]
) -> None:
    """It is named, and may be chosen: it is a side, a sense or a function of the machine, and none is preferred."""
    text = embed(".h", line.format(wrong))
    found = check(inspector, tmp_path / "a.h", text)
    item = next(one for one in found.findings if one.code == "VP001")
    assert item.message == f"{wrong}: no meaning in this language; {' or '.join(near)} may be meant"
    assert [(one.value, one.is_choice) for one in item.edits] == [(one, True) for one in near]
    fixes = [one for one in find_fixes(inspector, found, item, {tmp_path / "a.h": text}, NEVER) if one.is_choice]
    assert [one.new for one in fixes] == near if wrong != "N99" else not fixes  # without a cycle, M99 is wrong too
    assert not any(one.settles for one in fixes)


@pytest.mark.parametrize(
    ("line", "rights"),
    [("9L L X+5", {"91 L": False, "9 L": False}), ("M33", {"M30": False}), ("M300", {"M30": True})],
)
def test_an_edit_is_preferred_where_it_alone_is_likely(
    inspector: Inspector, tmp_path: Path, line: str, rights: dict[str, bool]
) -> None:
    """9L became 91 without a choice, and M33 in the last line M3."""
    text = embed(".h", line) if line[0] == "9" else embed(".h", "L X+5").replace("M30", line)
    made = look(inspector, tmp_path / "a.h", text)[2]
    wrong = line.removesuffix(" L X+5") + " L" * line.endswith("X+5")
    assert {fixed: settles for path, fixed, settles in made.values() if path.suffix == ".h"} == {
        text.replace(wrong, right): settles for right, settles in rights.items()
    }


@pytest.mark.parametrize(
    ("wrong", "rights"),
    [("94 G17 X1", ["G94", "N94"]), ("G71 94 X1", ["G94"]), ("1 X7", ["G1", "N1"]), ("1 =7", ["R1"])],
)
def test_a_code_without_its_letter_is_a_choice(
    inspector: Inspector, tmp_path: Path, wrong: str, rights: list[str]
) -> None:
    text = embed(".mpf", wrong)
    number = next(word for word in wrong.split() if word.isdigit())
    _message, _word, made = look(inspector, tmp_path / "a.mpf", text)
    files = {
        title: (tmp_path / "a.mpf", text.replace(wrong, wrong.replace(number, right)), False)
        for right in rights
        for title in [f"Write {right} in place of {number}"]
    }
    assert made == files


@pytest.mark.parametrize("wrong", ["MM", " MM", "T", "TMM", "T NM"])
def test_begin_pgm_without_name_or_unit_is_completed_from_end_pgm(
    inspector: Inspector, tmp_path: Path, wrong: str
) -> None:
    right = embed(".h", "L X+5")
    text = right.replace("PGM T MM", f"PGM {wrong}", 1)
    message, _word, made = look(inspector, tmp_path / "a.h", text)
    assert message.endswith("write BEGIN PGM T MM, as END PGM has it")
    assert list(made.values()) == [(tmp_path / "a.h", right, True)]


def test_two_names_of_a_program_are_a_choice(inspector: Inspector, tmp_path: Path) -> None:
    text = embed(".h", "L X+5").replace("END PGM T", "END PGM S")
    message, _word, made = look(inspector, tmp_path / "a.h", text)
    assert "write END PGM T MM, or BEGIN PGM S MM in line 1" in message
    assert [(one, is_preferred) for _path, one, is_preferred in made.values()] == [
        (text.replace("PGM S", "PGM T"), False),
        (text.replace("PGM T", "PGM S"), False),
    ]


@pytest.mark.parametrize(
    ("ending", "wrong", "begin", "rights", "is_preferred"),
    [
        (".ngc", "3<d>=5\nG1 X#<d>", "3<d>", ["#<d>"], True),
        (".ngc", "$<d>=5\nG1 X#<d>", "$<d>", ["#<d>"], True),
        (".ngc", "3100=5\nG1 X#3100", "3100", ["#100", "#3100"], False),
        *((ending, "G1 X3 F80l", "F80l", ["F801", "F80"], False) for ending in (".ngc", ".nc", ".mpf")),
        (".h", "L X+3 F80l", "F80l", ["F801", "F80"], False),
        (".nc", "G40 G1 X9. F8l", "F8l", ["F81", "F8"], False),
    ],
)
def test_readings_that_are_as_likely_are_choices(
    inspector: Inspector, tmp_path: Path, ending: str, wrong: str, begin: str, rights: list[str], is_preferred: bool
) -> None:
    path, text = tmp_path / f"a{ending}", embed(ending, wrong)
    found = check(inspector, path, text, TOOLS if ending == ".h" else SETUP)
    (item,) = (one for one in found.findings if one.severity == "error")
    made = find_fixes(inspector, found, item, {path: text}, NEVER)
    assert [(apply_places(fix), fix.settles) for fix in made] == [
        (text.replace(begin, right, 1), is_preferred) for right in rights
    ]


def test_a_percent_sign_below_a_remark_is_taken_out(inspector: Inspector, tmp_path: Path) -> None:
    right = embed(".ngc", "G1 X3")
    message, word, made = look(inspector, tmp_path / "a.ngc", f"(A)\n%\n{right}")
    assert (message, word) == ("% stands in the first line and below the last block; take it out", "%")
    assert list(made.values()) == [(tmp_path / "a.ngc", f"(A)\n\n{right}", True)]


def test_an_edge_beside_the_contour_is_a_choice(inspector: Inspector, tmp_path: Path) -> None:
    path, text = tmp_path / "a.ngc", "T1 M6\nG43 H1\n" + embed(".ngc", "X-40\nG41 E1 G1 X-30\nX9")
    found = check(inspector, path, text, "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 80, diameter = 8 }\n")
    (item,) = (one for one in found.findings if one.severity == "error")
    made = [apply_places(fix) for fix in find_fixes(inspector, found, item, {path: text}, NEVER) if not fix.settles]
    assert made == [text.replace("E1", "D1")]


@pytest.mark.parametrize(
    ("lines", "title"),
    [
        ("M98 P2000\nM30\nO2000\nG1 X4.\nM9\n%", "End the program with M99 before the closing %"),
        ("M98 P2000\nM3\nO2000\nG1 X4.\nM99\n%", "Write M30 before line 9"),
    ],
)
def test_an_edit_that_leaves_the_mistyped_code_is_a_choice(
    inspector: Inspector, tmp_path: Path, lines: str, title: str
) -> None:
    path, text = tmp_path / "a.nc", f"{HEADS['.nc'][0]}{lines}\n"
    found = check(inspector, path, text, TOOLS)
    fixes = [fix for item in found.findings for fix in find_fixes(inspector, found, item, {path: text}, NEVER)]
    assert [fix.settles for fix in fixes if fix.title.startswith(title)] == [False]


def test_m6_beside_another_code_is_a_choice(inspector: Inspector, tmp_path: Path) -> None:
    path, text = tmp_path / "a.mpf", "T1 M5\n" + "".join(HEADS[".mpf"]).partition("\n")[2]
    found = check(inspector, path, text, TOOLS)
    fixes = [fix for item in found.findings for fix in find_fixes(inspector, found, item, {path: text}, NEVER)]
    assert [fix.settles for fix in fixes if fix.title.startswith("Write M6 after T1 in line 1")] == [False]
