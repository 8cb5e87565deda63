"""Siemens programs: every word against its RS274 twin, or against numbers worked out by hand from the rules of the
control.
"""

import re

import numpy as np
import pytest

import verne_post
from tests.gcode.conftest import list_places_on, make_tool
from verne_post.model.control_keys import SiemensKeys
from verne_post.model.moves import IGNORED, MoveKind, PathMode
from verne_post.model.options import Options

HEAD = "G0 X0 Y0 Z5 F100\n"


def same_moves(view, siemens, rs274):
    """Both texts make the same moves, to 1e-9; returns those of the Siemens program."""
    first, errors = view(f"{HEAD}{siemens}\nM30", dialect="siemens")
    assert errors == ()
    second, errors = view(f"{HEAD}{rs274}\nM30", dialect="rs274")
    assert errors == ()
    assert np.array_equal(first.kind, second.kind)
    assert np.allclose(first.end, second.end, atol=1e-9, rtol=0)
    assert np.allclose(first.feed, second.feed, atol=1e-9, rtol=0, equal_nan=True)
    assert np.allclose(first.arcs.center, second.arcs.center, atol=1e-9, rtol=0)
    assert np.allclose(first.arcs.sweep, second.arcs.sweep, atol=1e-9, rtol=0)
    assert np.array_equal(first.arcs.plane, second.arcs.plane)
    return first


@pytest.mark.parametrize(("siemens", "rs274"), [
    # text: numbers, blanks, comments, labels, block numbers
    ("G1X10Y-2.5", "G1 X10 Y-2.5"), ("N10 G1 X=10 Y=-2.5 ; text (with) \"quotes", "G1 X10 Y-2.5"),
    ("g1 x1EX1 y=-25EX-1", "G1 X10 Y-2.5"),
    ("N20 LABEL: G1 X.5", "G1 X.5"), (":30 G1 X+5", "G1 X5"), ("G1 X 10 Y - 3", "G1 X10 Y-3"), ("/3 G1 X2", "G1 X2"),
    ("G1 X='H1F'", "G1 X31"), ("X5", "G0 X5"),
    # expressions
    ("R1=2 R2=R1*3+4\nX=R2", "G0 X10"), ("R[5]=7\nX=R5", "G0 X7"), ("X=-(2+3)*2", "G0 X-10"),
    ("X=7 DIV 2 Y=7 MOD 4 Z=7/2", "G0 X3 Y3 Z3.5"),
    ("X=POT(3)+SQRT(16) Y=ABS(-2) Z=TRUNC(-2.7)", "G0 X13 Y2 Z-2"),
    ("X=ROUND(2.5) Y=ROUND(-2.5) Z=ROUNDUP(2.1)", "G0 X3 Y-3 Z3"),
    ("X=10*SIN(30) Y=10*COS(60) Z=ATAN2(1,1)", "G0 X5 Y5 Z45"),
    ("X=MINVAL(3,4) Y=MAXVAL(3,4) Z=BOUND(0,2,5)", "G0 X3 Y4 Z2"),
    ("X=6 B_AND 3 Y=6 B_OR 3 Z=6 B_XOR 3", "G0 X2 Y7 Z5"), ("X=2+3*2==8 Y=(1<2) AND (2<1) Z=NOT 0", "G0 X1 Y0 Z1"),
    ("X=1==5 AND 3", "G0 X1"), ("X=STRLEN(\"ab\"<<12)", "G0 X4"),
    ("DEF REAL A1=4, B1\nDEF INT N1=2.6\nX=A1 Y=N1 Z=B1", "G0 X4 Y3 Z0"),
    ("DEF REAL L1[2,2]=SET(1,2,3,4)\nX=L1[1,0]", "G0 X3"),
    ("DEF REAL L1[4]=SET(1,,3)\nL1[1]=SET(7,,9)\nX=L1[0] Y=L1[1] Z=L1[2]", "G0 X1 Y7 Z3"),
    ("DEF REAL L1[4]=REP(5,2)\nL1[2]=REP(4)\nX=L1[1] Y=L1[2] Z=L1[3]", "G0 X5 Y4 Z4"),
    ("DEF BOOL Q=5\nDEF STRING[8] S1A=\"3.5\"\nX=Q Y=NUMBER(S1A)", "G0 X1 Y3.5"), ("X=$P_EP[Z]", "G0 X5"),
    ("X=$PI", "G0 X3.141592653589793"),
    # distances
    ("G91 X1\nX1 Y2", "G91 G0 X1\nX1 Y2"), ("X=IC(2)\nX=IC(2)", "G0 X2\nX4"), ("G91 X=AC(7) Y3", "G0 X7 Y3"),
    ("C=350\nC=DC(10)", "G0 C350\nC370"),
    ("C350\nC=ACP(10)\nC=ACN(0)", "G0 C350\nC370\nC360"), ("C=ACN(350)", "G0 C-10"),
    ("A=AC(5) C=AC(700)", "G0 A5 C700"),
    ("G70 X1\nG710 Y1", "G0 X25.4\nY1"), ("G700 G1 X1 F10\nG71 X2", "G1 X25.4 F254\nX2"),
    ("G70 G1 X1 F10", "G1 X25.4 F10"),
    # arcs
    ("G2 X10 Y0 I5 J0", "G2 X10 Y0 I5 J0"), ("G2 X10 Y0 I=AC(5) J=AC(0)", "G2 X10 Y0 I5 J0"),
    ("G3 X10 Y0 CR=7", "G3 X10 Y0 R7"),
    ("G3 X10 Y0 CR=-7", "G3 X10 Y0 R-7"), ("G2 I5 J0 TURN=2 Z-1", "G2 I5 J0 P3 Z-1"),
    ("G3 I5 J0 AR=90", "G3 X5 Y-5 I5 J0"),
    ("G2 I5 J0 AR=270", "G2 X5 Y-5 I5 J0"), ("G2 X10 Y0 AR=180", "G2 X10 Y0 R5"),
    ("G3 X10 Y0 AR=300", "G3 X10 Y0 R-10"),
    ("G18 G3 X10 Z5 K0 I5", "G18 G3 X10 Z5 I5 K0"), ("G19 G2 Y6 Z5 J3", "G19 G2 Y6 Z5 J3 K0"),
    ("G2 X10 Y0 I5\nX20 I5", "G2 X10 Y0 I5\nX20 I5"),
    ("CIP X10 Y0 I1=5 J1=5", "G2 X10 Y0 I5 J0"), ("CIP X10 Y0 I1=IC(5) J1=IC(-5) Z5", "G3 X10 Y0 I5 J0"),
    ("CIP Y6 Z5 J1=3 K1=8", "G19 G2 Y6 J3 K0"),
    ("G1 X10\nCT X10 Y10", "G1 X10\nG3 X10 Y10 J5"), ("G1 X10\nCT X20 Y-10", "G1 X10\nG2 X20 Y-10 J-10"),
    ("G2 X4 Y0 I2\nCT X8", "G2 X4 Y0 I2\nG3 X8 I2"),
    # polar words
    ("G111 X1 Y2\nG1 AP=90 RP=5", "G1 X1 Y7"),
    ("X3 Y4\nG110 X1 Y1\nG1 RP=2 AP=0\nAP=IC(90)", "G0 X3 Y4\nG1 X6 Y5\nX4 Y7"),
    ("G111 RP=10 AP=0\nG112 X1 Y0\nRP=1 AP=180", "G0 X10 Y0"), ("X5\nG111\nG3 AP=90 RP=5", "G0 X5\nG3 X0 Y5 I-5"),
    # dwell, feed, spindle
    ("G4 F2.5", "G4 P2.5"), ("S600 M3\nG4 S30", "S600 M3\nG4 P3"), ("G93 G1 X10 F2", "G93 G1 X10 F2"),
    ("G95 S100 M3 G1 X10 F0.1", "G95 S100 M3 F.1 G1 X10"),
    ("F=50*2 G1 X1", "F100 G1 X1"), ("S1=500 M1=3", "S500 M3"), ("G94 F200 G1 X1", "F200 G1 X1"),
    # flow
    ("R1=3\nA1: X=R1\nR1=R1-1\nIF R1>0 GOTOB A1", "G0 X3\nX2\nX1"), ("GOTOF N90\nX1\nN90 X2", "G0 X2"),
    ("GOTO ENDE\nX1\nENDE: X2", "G0 X2"),
    ("GOTOC NOWHERE\nX1", "G0 X1"), ("IF 1==2\nX1\nELSE\nX2\nENDIF", "G0 X2"),
    ("IF 1\nIF 0\nX1\nENDIF\nX3\nELSE\nX2\nENDIF", "G0 X3"),
    ("FOR R1=1 TO 3\nX=R1\nENDFOR", "G0 X1\nX2\nX3"), ("FOR R1=2 TO 1\nX=R1\nENDFOR\nX9", "G0 X9"),
    ("R1=0\nWHILE R1<2\nR1=R1+1\nX=R1\nENDWHILE", "G0 X1\nX2"),
    ("R1=0\nLOOP\nR1=R1+1\nX=R1\nIF R1==2 GOTOF RAUS\nENDLOOP\nRAUS: X9", "G0 X1\nX2\nX9"),
    ("R1=0\nREPEAT\nR1=R1+1\nX=R1\nUNTIL R1==2", "G0 X1\nX2"),
    ("A1: X=IC(1)\nREPEAT A1 P=2", "G0 X1\nX2\nX3"),
    ("A1: X=IC(1)\nY=IC(1)\nA2: X=IC(1)\nREPEATB A1 P=2\nX9", "G0 X1\nY1\nX2\nX3\nX4\nX9"),
    ("A1: X=IC(1)\nA2: Y=IC(1)\nZ9\nREPEAT A1 A2", "G0 X1\nY1\nZ9\nX2\nY2"),
    ("A1: X=IC(1)\nENDLABEL: Y=IC(1)\nREPEAT A1", "G0 X1\nY1\nX2\nY2"),
    ("R1=0\nA1: X=IC(10)\nIF R1==2 GOTOF A2\nY=IC(1)\nA2: R1=R1+1\nENDLABEL:\nREPEAT A1 P=3",
     "G0 X10\nY1\nX20\nY2\nX30\nX40\nY3"),
    ("R1=0\nA1: R1=R1+1\nX=R1\nA3: IF R1>2 GOTOF A9\nREPEAT A1 A3 P=9\nX50\nA9: X9", "G0 X1\nX2\nX3\nX9"),
    ("SUB1\nX9\nM30\n%_N_SUB1_SPF\nX1\nM17", "G0 X1\nX9"), ("L10 P2\nM30\n%_N_L10_SPF\nX=IC(1)\nRET", "G0 X1\nX2"),
    ("SUB1(2,,4)\nM30\n%_N_SUB1_SPF\nPROC SUB1(REAL A1, INT B1=7, REAL C1)\nX=A1 Y=B1 Z=C1\nM17", "G0 X2 Y7 Z4"),
    ("DEF REAL Q\nSUB1(Q)\nX=Q\nM30\n%_N_SUB1_SPF\nPROC SUB1(VAR REAL A1)\nA1=5\nM17", "G0 X5"),
    ("SUB1\nX1\nM30\n%_N_SUB1_SPF\nPROC SUB1 SAVE\nG91 X1\nRET", "G91 G0 X1\nG90 X1"),
    ("SUB1\nG2 X10 Y0 I5 F100\nM30\n%_N_SUB1_SPF\nPROC SUB1 SAVE\nG18 G93 TRANS X5\nRET", "G2 X10 Y0 I5"),
    ("EXTCALL \"/dir/SUB1.SPF\"\nM30\n%_N_SUB1_SPF\nX1\nM17", "G0 X1"),
    ("CALL \"/_N_SPF_DIR/_N_SUB1_SPF\"\nM30\n%_N_SUB1_SPF\nX1\nM17", "G0 X1"),
    ("MCALL SUB1(3)\nX1\nX2\nMCALL\nX5\nM30\n%_N_SUB1_SPF\nPROC SUB1(REAL Q)\nZ=Q\nZ9\nM17",
     "G0 X1\nZ3\nZ9\nX2\nZ3\nZ9\nX5"),
    ("X3 Z9\nG75 Z0\nG75 X0 Y0 FP=1\nX5", "G0 X3 Z9\nG53 Z0\nG53 X0 Y0\nX5"),
    # words without effect beside motion
    ("SOFT FFWON COMPCAD G601\nDYNFINISH\nG1 X1", "G1 X1"),
    ("STOPRE\nFGROUP(X,Y,Z,A,C)\nACC[X]=50\nWORKPIECE(,,,\"BOX\",0,1,2,3)\nX1", "G0 X1"),
])  # fmt: skip
def test_words_have_rs274_twins(view, siemens, rs274):
    same_moves(view, siemens, rs274)


@pytest.mark.parametrize(("line", "code", "part"), [
    ("X1 X2", "VP004", "twice"), ("G0 G1 X1", "VP003", "group"), ("G64 G60", "VP003", "group"),
    ("G5 X1", "VP002", "G5"), ("BSPLINE X1", "VP031", "needs"), ("BSPLINE X1 SD=5", "VP031", "SD"),
    ("BSPLINE G91 X1", "VP017", "G90"), ("BSPLINE X1 Y2 PL=2\nX3\nX5\nX7\nG1", "VP031", "PL="),
    ("BSPLINE X1 PW=0", "VP031", "PW"), ("BSPLINE PW=2", "VP005", "PW"), ("CSPLINE X1", "VP002", "splines"),
    ("POLY PO[X]=(1,2)", "VP002", "polynomials"), ("DIAMON", "VP002", "lathe"), ("G96 S100", "VP002", "lathe"),
    ("POCKET3(1,2)", "VP005", "DP"), ("CYCLE63(1)", "VP002", "contour"),
    ("CYCLE84(1,2)", "VP005", "DP or DPR"), ("RND=2", "VP017", "G1, G2, G3"), ("G33 Z1", "VP002", "synchronised"),
    ("A4=1", "VP002", "surface"), ("WHEN TRUE DO X=1", "VP002", "synchronised"),
    ("TRACYL(40)", "VP002", "other machines"), ("G43", "VP002", "D1"), ("G80", "VP002", "MCALL alone"),
    ("X=FOO", "VP025", "FOO"), ("FOO=1", "VP002", "FOO"), ("FOO(1)", "VP002", "FOO"), ("X=1/0", "VP007", "no value"),
    ("X=SQRT(-1)", "VP007", "no value"), ("X=1+", "VP001", "end of the line"),
    ("X=\"A\"", "VP007", "text"), ("X=(1", "VP001", "')'"), ("X1.2.3", "VP001", "point"), ("?", "VP001", "?"),
    ("MSG(\"a", "VP001", "quote"), ("Q5", "VP002", "Q"),
    ("G1 X1 A3=0 B3=0 C3=1", "VP017", "TRAORI"), ("G2 X1", "VP005", "centre"), ("G2 X10 I5 CR=5", "VP003", "one of"),
    ("G2 X10 I1", "VP008", "not on the circle"), ("G2 X10 I5 K1", "VP006", "K"), ("G2 X10 CR=1", "VP008", "small"),
    ("X=DC(5)", "VP017", "rotary"), ("CT X5 Z9", "VP008", "plane"), ("CIP X10", "VP005", "I1"),
    ("CIP X10 I1=5", "VP008", "line"), ("CIP X10 Y0 J1=5 K=3 I1=5", "VP006", "K"), ("TRANS X1 G1", "VP003", "motion"),
    ("SCALE X0", "VP007", "scale"), ("SCALE X2\nG2 X10 I5", "VP017", "ellipse"),
    ("SCALE X2\nAROT Z30", "VP017", "skews"), ("G4 X1", "VP005", "F"), ("G4 F-1", "VP007", "negative"),
    ("G4 S5", "VP017", "spindle"), ("F-5", "VP007", "negative"),
    ("GOTOF X9", "VP023", "X9"), ("GOTOB N5", "VP023", "before"), ("IF 1", "VP023", "ENDIF"), ("ENDIF", "VP023", "IF"),
    ("FOR R1=1", "VP001", "TO"), ("REPEAT A9", "VP023", "A9"), ("MCALL SUB1", "VP002", "SUB1"),
    ("G75", "VP005", "axes"), ("G75 Z0 FP=3", "VP015", "fixed points"), ("MCALL CYCLE800()", "VP002", "modal"),
    ("D2", "VP012", "edge"), ("T=\"MILL\"", "VP012", "siemens.tools"), ("S2=500", "VP002", "spindle 2"),
    ("M77", "VP002", "remap"), ("M3 M4", "VP003", "group"), ("TRAORI(2)", "VP002", "one transformation"),
    ("L99", "VP002", "L99"), ("G558 X1", "VP007", "G505"),
    ("SETAL(61000,\"no\")", "VP027", "no"), ("LOOP\nENDLOOP", "VP024", "repeated"),
    ("$P_UIFR[1,X,RT]=5", "VP002", "TR"), ("CTRANS(X,5)", "VP001", "$P_PFRAME=CTRANS"),
    ("$P_PFRAME=5", "VP001", "expected a frame"), ("$P_PFRAME=CTRANS(X)", "VP001", "','"),
    ("$P_PFRAME=CROT(A,5)", "VP001", "axis"), ("$P_PFRAME=CTRANS(X,1,X,2)", "VP004", "twice"),
    ("$P_PFRAME=CSCALE(X,0)", "VP007", "greater"), ("$P_UIFR[1]=CROT(X,5)", "VP002", "about Z"),
    ("$P_UIFR[1]=CSCALE(X,2)", "VP002", "about Z"), ("$P_IFRAME=CMIRROR(X)", "VP002", "about Z"),
    ("$P_UIFR[99]=CTRANS(X,1)", "VP025", "no such work offset"),
    ("$P_PFRAME=$P_UIFR[99]", "VP025", "no such work offset"), ("X=$AC_TIME", "VP025", "$AC_TIME"),
    ("X1 P3", "VP006", "P3"), ("R99999=1", "VP025", "R0"), ("DEF REAL X9X\nDEF REAL X9X", "VP004", "twice"),
    ("DEF AXIS Q", "VP002", "AXIS"), ("X=R[1.5]", "VP007", "whole"), ("SUPA G91 X1", "VP017", "absolute"),
    ("SUPA X=DC(1)", "VP017", "DC"), ("SUPA C=IC(1)", "VP017", "IC"), ("SUPA G2 X1", "VP017", "G0 or G1"),
    ("AP=5", "VP005", "AP="), ("RP=5 AP=5 X3", "VP003", "one way"),
    ("CYCLE800(0,\"\",0,57,0,0,0,30,0,0,0,0,0,5)", "VP007", "_DIR"),
    ("TRANS X1\nCYCLE800(0,\"\",0,57,0,0,0,30,0,0,0,0,0,1)", "VP017", "TRANS"), ("CYCLE832(0.1,25)", "VP002", "_TOLM"),
    ("CYCLE832(0.1,5)", "VP002", "last digit"), ("CYCLE832(0.1,3000001)", "VP002", "_TOLM"),
    ("CYCLE832(0.1,112021)", "VP002", "_TOLM"), ("CUTMOD=2", "VP002", "CUTMOD=2"), ("CUTMOD", "VP001", "CUTMOD"),
    ("SPOS=IC(90)", "VP002", "DC()"), ("SPOS[2]=90", "VP002", "SPOS"), ("M40=1", "VP002", "spindle 40"),
    ("M41", "VP002", "gears"), ("CYCLE82(10)", "VP005", "RFP"), ("CYCLE82(10,10,1,,5)", "VP007", "same height"),
    ("CYCLE82(10,10,1,5,0,0,0,1,1)", "VP007", "same height"), ("CYCLE82(10,10,1,10)", "VP007", "no depth"),
    ("CYCLE82(10,0,1,5)", "VP007", "wrong side"),
    ("Z-5\nCYCLE82(10,0,1,-9)", "VP017", "below"), ("CYCLE83(10,0,1,-9,,-20)", "VP007", "first depth"),
    ("CYCLE82(1,2,3,4,5,6,7,8,9,10,11,12,13,14,15)", "VP005", "values"), ("CYCLE85(10,0,1,-5,,0)", "VP009", "FFR"),
    ("PROC X1", "VP001", "first block"), ("%", "VP001", "begins a program"),
    ("X='HG'", "VP001", "value"), ("X=1E5", "VP002", "E: no meaning"), ("FGROUP(X", "VP001", "bracket"),
    ("FGROUP(C)\nG1 X1 C9 F9", "VP002", "write G93"), ("FGROUP(A,C)", "VP002", "FGROUP(A,C)"),
    ("IF 1 GOTOF", "VP001", "value"), ("G1 X1 = 5", "VP006", "X1=5"), ("CALL \"A\"", "VP023", "A.SPF"),
    ("CALL BLOCK A TO B", "VP025", "BLOCK"),
    ("EXTCALL \"A\"", "VP023", "A.SPF"),
])  # fmt: skip
def test_what_is_not_executed_is_an_error_at_its_line(view, line, code, part):
    found = view(f"{HEAD}{line}\nM30", dialect="siemens", max_repeats=300)[1]
    assert [item.code for item in found] == [code], found
    assert part in found[0].message
    assert found[0].line in range(2, 3 + line.count("\n"))


@pytest.mark.parametrize(("siemens", "points", "weights", "knots", "degree"), [
    ("BSPLINE X10 Y10\nX20 Y-10\nX30 Y0 Z3", [(0, 0, 5), (10, 10, 5), (20, -10, 5), (30, 0, 3)], [1, 1, 1, 1],
     [0, 0, 0, 0, 1, 1, 1, 1], 3),
    ("BSPLINE X10 Y10 SD=2 PW=3\nX20 Y-10\nX30 Y0", [(0, 0, 5), (10, 10, 5), (20, -10, 5), (30, 0, 5)], [1, 3, 1, 1],
     [0, 0, 0, 1, 2, 2, 2], 2),
    ("BSPLINE X10 Y10 SD=2 PL=0\nX20 Y-10 PL=0.5\nX30 Y0 PL=2", [(0, 0, 5), (10, 10, 5), (20, -10, 5), (30, 0, 5)],
     [1, 1, 1, 1], [0, 0, 0, 0.5, 2.5, 2.5, 2.5], 2),
    ("BSPLINE X10 Y10 PL=1\nX20 Y-10 PL=3\nX30 Y0 PL=0\nX40 PL=0",
     [(0, 0, 5), (10, 10, 5), (20, -10, 5), (30, 0, 5), (40, 0, 5)], [1] * 5, [0, 0, 0, 0, 1, 4, 4, 4, 4], 3),
    ("ROT Z90\nG0 X0 Y0\nBSPLINE X10 Y10\nX20 Y-10\nX30 Y0\nROT", [(0, 0, 5), (10, 10, 5), (20, -10, 5), (30, 0, 5)],
     [1, 1, 1, 1], [0, 0, 0, 0, 1, 1, 1, 1], 3),
])  # fmt: skip
def test_splines(view, siemens, points, weights, knots, degree):
    """The curve of the recorded pieces goes through the points that de Boor's recursion gives."""
    moves, errors = view(f"{HEAD}{siemens}\nG1 X40", dialect="siemens")
    assert errors == ()
    rows = np.flatnonzero(moves.kind == MoveKind.SPLINE)
    assert len(rows) == len(set(knots)) - 1

    def curve(t):
        """Point at a parameter, by the definition of the basis functions."""

        def basis(i, p):
            if p == 0:
                return float(knots[i] <= t < knots[i + 1] or (t == knots[-1] and knots[i] < knots[i + 1] == knots[-1]))
            left = 0.0 if knots[i + p] == knots[i] else (t - knots[i]) / (knots[i + p] - knots[i]) * basis(i, p - 1)
            right = (
                0.0
                if knots[i + p + 1] == knots[i + 1]
                else (knots[i + p + 1] - t) / (knots[i + p + 1] - knots[i + 1]) * basis(i + 1, p - 1)
            )
            return left + right

        share = np.array([basis(i, degree) * weights[i] for i in range(len(points))])
        return share @ np.array(points, dtype=float) / share.sum()

    inner = sorted({knot for knot in knots if knot > 0})
    for row, knot in zip(rows, inner, strict=True):
        assert moves.end[row, :3] == pytest.approx(curve(knot), abs=1e-9)


def test_compensation_begins_beside_the_contour(view):
    """NORM: however short the first move is, it ends a radius to the left of the contour's start."""
    moves, errors = view(
        "T2 M6\nG0 X-1 Y-1 Z0 F100\nG41 G1 X0 Y0\nY20\nG3 X-10 Y30 CR=10\nG40 G1 X-20", dialect="siemens"
    )
    assert errors == ()
    assert np.allclose(moves.end[1:4, :2], [(-3, 0), (-3, 20), (-10, 27)], atol=1e-9)  # a tool of 6 mm


def modes(moves):
    return [
        (moves.controls[index].mode, moves.controls[index].tolerance, moves.controls[index].axis_deg)
        for index in moves.control
    ]


LORENZ = """DEF REAL P[3], Q[3]
DEF INT I
EXTERN STEP(VAR REAL[3], VAR REAL[3], REAL)
P[0]=1 P[1]=2 P[2]=3
G1 X0 Y0 Z0 F100
STEP(P,Q,0.5)
X=Q[0] Y=Q[1] Z=Q[2]
{copy}
X=P[0] Y=P[1] Z=P[2]
M30
%_N_STEP_SPF
PROC STEP(VAR REAL A[3], VAR REAL B[], REAL H)
DEF INT K
FOR K=0 TO 2
B[K]=A[K]*H
ENDFOR
A[0]=9
RET
%_N_SPOIL_SPF
PROC SPOIL(REAL A[3], REAL B[2])
A[1]=77 B[1]=5
X=B[1]+B[0]
RET"""


def test_a_feed_rate_that_nobody_programs_is_refused_but_where_the_set_up_has_the_control_s(view):
    """Alarm 10860, unless SD42110 is not 0."""
    errors = view("G0 X0 Y0 Z50\nG1 X5\nM30", dialect="siemens")[1]
    assert [(item.code, item.line) for item in errors] == [("VP009", 2)]
    assert "start under [siemens]" in errors[0].message
    control = {"siemens": {"start": f"{SiemensKeys().start} F700"}}
    moves, errors = view("G0 X0 Y0 Z50\nG1 X5\nF80 X6\nM30", dialect="siemens", control=control)
    assert errors == ()
    assert moves.feed.tolist()[1:] == [700, 80]


@pytest.mark.parametrize(("copy", "ends"), [
    ("", [[0, 0, 0], [0.5, 1, 1.5], [9, 2, 3]]),  # VAR: the caller's own array
    ("SPOIL(P)", [[0, 0, 0], [0.5, 1, 1.5], [5, 1, 1.5], [9, 2, 3]]),  # without VAR a copy; left out: zeros
])  # fmt: skip
def test_arrays_as_values(view, copy, ends):
    moves, errors = view(LORENZ.format(copy=copy), dialect="siemens")
    assert errors == ()
    assert moves.end[:, :3].tolist() == ends


@pytest.mark.parametrize(("value", "x"), [("7", 7.0), ("R1+1", 9.0), ("3.0", 5.0), ("4", 5.0)])
def test_case(view, value, x):
    program = (
        "R1=8\n"
        "G1 F100\n"
        f"CASE({value}) OF 7 GOTOF A 9 GOTOF B DEFAULT GOTOF C\n"
        "X99\n"
        "A: X7\n"
        "GOTOF E\n"
        "B: X9\n"
        "GOTOF E\n"
        "C: X5\n"
        "E: M30"
    )
    moves, errors = view(program, dialect="siemens")
    assert errors == ()
    assert moves.end[:, 0].tolist() == [x]


def test_case_without_a_fitting_value_goes_on(view):
    assert view("G1 F100\nCASE(R1) OF 1 GOTOF A\nX1\nA: X2\nM30", dialect="siemens")[0].end[:, 0].tolist() == [1, 2]


def test_extern_calls_nothing(view):
    program = "G1 X0 F100\nEXTERN UP\nEXTERN UQ(REAL, VAR INT[2])\nUP\nM30\n%_N_UP_SPF\nX=IC(5)\nM17"
    moves, errors = view(program, dialect="siemens")
    assert errors == ()
    assert moves.end[:, 0].tolist() == [0, 5]


def test_a_program_with_splines_alone_is_recognised(view):
    moves, errors = view("G1 X0 Y0 F1000\nBSPLINE X10 Y10\nX20 Y5\nX30\nX40\nG1 X50\nM30")
    assert errors == ()
    assert moves.end[-1, 0] == 50


def test_path_control(view):
    text = (
        "G0 X0 Y0 Z0\n"
        "G64 X1\n"
        "G9 X2\n"
        "X3\n"
        "G641 ADIS=0.4 X4\n"
        "G642 CTOL=0.02 OTOL=0.5 X5\n"
        "G642 CTOL=-1 OTOL=-1 X6\n"
        "G60 X7\n"
        "G64\n"
        "CYCLE832(0.05,_ORI_FINISH,1.5)\n"
        "X8\n"
        "CYCLE832(0.05,112011,1.5)\n"
        "X8.5\n"
        "CYCLE832(0.05,2112101)\n"
        "X8.7\n"
        "CYCLE832(0.05,1)\n"
        "X9\n"
        "CYCLE832()\n"
        "X10\n"
        "M30"
    )
    moves, errors = view(text, dialect="siemens")
    assert errors == ()
    stop, blend = PathMode.EXACT_STOP, PathMode.BLEND
    assert modes(moves) == [
        (stop, None, None),
        (blend, None, None),
        (stop, None, None),
        (blend, None, None),
        (blend, 0.1, None),
        (blend, 0.02, 0.5),
        (blend, None, None),
        (stop, None, None),
        (blend, 0.05, 1.5),
        (blend, 0.05, 1.5),
        (blend, 0.05, None),
        (blend, 0.05, None),
        (blend, None, None),
    ]


def test_events(view):
    moves, errors = view(
        'T2 M6\nS500 M4 M8\nMSG("d="<<R1+1)\nFFWON\nM0\nM1\nSPOS=90\nH5\nSETAL(62000)\nG0 X1 M30', dialect="siemens"
    )
    assert errors == ()
    assert [(event.line, event.kind) for event in moves.events] == [
        (1, "tool"),
        (2, "spindle"),
        (2, "coolant"),
        (3, "message"),
        (4, "without effect"),
        (5, "stop"),
        (6, "stop"),
        (7, "orient"),
        (8, "auxiliary"),
        (9, "message"),
        (10, "end"),
    ]
    assert moves.events[3].data["text"] == "d=1"
    assert moves.frames[0].tool_length == 25.0


def test_the_end_of_the_file_ends_a_program(view):
    for text in ("G0 X1", "G0 X1\nM17", "G0 X1\nM2\nX2", "G0 X1\nRET\n", "%_N_A_MPF\n;$PATH=/_N_MPF_DIR\nG0 X1\n"):
        moves, errors = view(text, dialect="siemens")
        assert errors == ()
        assert (len(moves), moves.end[0][0]) == (1, 1.0)


def test_work_offsets_and_places_of_the_machine(view):
    text = "G54 G0 X1 Y2 Z3\n$P_UIFR[2,X,TR]=100\nG55 X1\nSUPA X7\nG505 X0\nG500 X5\nTRANS X10\nG53 X4\nX4"
    moves, errors = view(text, dialect="siemens", wcs={})
    assert errors == ()
    frames = [moves.frames[index] for index in moves.frame]
    machine = [
        end[0] + frame.origin[0] + (frame.feature.origin[0] if frame.feature else 0)
        for end, frame in zip(moves.end, frames, strict=True)
    ]
    assert machine == [1.0, 101.0, 7.0, 0.0, 5.0, 4.0, 14.0]


@pytest.mark.parametrize(
    ("word", "end"), [("C0", 0.0), ("C=DC(0)", 360.0), ("C=ACP(10)", 370.0), ("C=ACN(10)", 10.0), ("C=AC(10)", 10.0)]
)
@pytest.mark.parametrize("shift", [0.0, 30.0])
def test_ways_of_rotary_axes_in_machine_coordinates(view, word, end, shift):
    """As posts end: SUPA A=DC(0) C=DC(0). The way counts from where the machine stands, not from the programmed
    angle.
    """
    text = f"$P_UIFR[1,C,TR]={shift}\nG54 G0 X0 Y0 Z50 C{340 - shift}\nSUPA {word}\nM30"
    moves, errors = view(text, dialect="siemens", wcs={})
    assert errors == ()
    frame = moves.frames[moves.frame[-1]]
    assert moves.end[-1][5] + frame.origin[5] == pytest.approx(end)


@pytest.mark.parametrize(
    ("value", "whole"), [(4.5, 5), (2.5, 3), (0.5, 1), (1.5, 2), (2.4999, 2), (-1.5, -2), (6.5, 7)]
)
def test_int_rounds_halves_away_from_zero(view, value, whole):
    moves, errors = view(f"DEF INT I\nI={value}\nG0 X=I", dialect="siemens")
    assert errors == ()
    assert moves.end[-1, 0] == whole


def test_comments_before_the_first_header_are_no_program(view):
    moves, errors = view("; made by hand\n\n%_N_MAIN_MPF\nG0 X7\nM30", dialect="siemens")
    assert errors == ()
    assert moves.end[-1, 0] == 7.0
    moves, errors = view("G0 X3\nM30\n%_N_PART_SPF\nG0 X7\nM17", dialect="siemens")
    assert moves.end[-1, 0] == 3.0


def test_m_functions_that_are_not_executed_can_be_given_a_meaning(view):
    moves, errors = view("M41\nM40\nG0 X1", dialect="siemens", remap={"M41": "event"})
    assert errors == ()
    assert [(event.kind, event.line) for event in moves.events[:2]] == [("remapped", 1), ("without effect", 2)]


@pytest.mark.parametrize(
    "word", ["SPOS=90", "SPOS=DC(90)", "SPOS=ACP(90)", "SPOS=ACN(90)", "SPOS=AC(90)", "SPOS[1]=DC(90)"]
)
def test_the_spindle_stops_at_an_angle(view, word):
    moves, errors = view(f"S500 M3\n{word}\nG0 X1", dialect="siemens")
    assert errors == ()
    assert [event.data for event in moves.events if event.kind == "orient"] == [{"angle": 90.0}]


@pytest.mark.parametrize("key", ["edges", "tools"])
def test_d_has_the_number_of_the_edge_or_of_the_tool(view, key):
    numbers = {"edges": 1, "tools": 2}
    own, other = numbers[key], 3 - numbers[key]
    for text, length in (
        (f"T2 M6 D{own}", 25),
        (f"T2 D{own}\nM6", 25),
        (f"T2\nM6\nD0\nD{own}", 25),
        (f"T2 M6\nD{own}\nD0", 0),
        (f"D{own}\nT0 M6", 0),
    ):
        moves, errors = view(f"{text}\nG0 X1", dialect="siemens", control={"siemens": {"d_numbers": key}})
        assert errors == ()
        assert moves.frames[moves.frame[-1]].tool_length == length, text
    for text in (f"T2 M6 D{other}", f"T2 D{other}\nM6", f"T2 M6\nD{other}"):
        found = view(f"{text}\nG0 X1", dialect="siemens", control={"siemens": {"d_numbers": key}})[1]
        assert [item.code for item in found] == ["VP012"]
        assert "d_numbers" in found[0].message
    flat = view("G0 X=$TC_DP3[2]", dialect="siemens", control={"siemens": {"d_numbers": key}})
    assert (flat[1] == ()) == (key == "tools")


def test_d0_leaves_the_radius_out(view):
    contour = "G41 G1 X10 Y10 F100\nX30\nY30\nG40 X50"
    tools = {2: make_tool(2, 25.0, 10.0)}
    on_contour = view(f"T2 M6\nD0\n{contour}", dialect="siemens", tools=tools)[0]
    plain = view("T2 M6\nD0\nG1 X10 Y10 F100\nX30\nY30\nX50", dialect="siemens", tools=tools)[0]
    np.testing.assert_allclose(on_contour.end, plain.end)
    beside = view(f"T2 M6\nD1\n{contour}", dialect="siemens", tools=tools)[0]
    assert abs(beside.end[1, 1] - 15.0) < 1e-9
    for edge, radius in ((0, 0.0), (1, 5.0)):
        assert view(f"T2 M6\nD{edge}\nG0 X=$P_TOOLR", dialect="siemens", tools=tools)[0].end[-1, 0] == radius


@pytest.mark.parametrize(
    ("call", "radius", "length"), [("", 5, 100), ("D1", 4, 120), ("T1 M6", 4, 120), ("D0\nD1", 4, 120)]
)
def test_changed_data_of_the_tool_wait_for_d(view, call, radius, length):
    """The contour is at Y0 along X, to the left of it the tool's centre at Y5 with the radius of the call."""
    text = (
        "G0 X0 Y50 Z60 F100\nT1 D1 M6\n$TC_DP6[1,1]=4 $TC_DP3[1,1]=120\nX0 Y50 Z60\n"
        f"{call}\nG41 G1 X20 Y0\nX40\nG40 X50"
    )
    moves, errors = view(text, dialect="siemens", tools={1: make_tool(1, 100.0, 10.0)})
    assert errors == ()
    assert moves.end[-2, :2] == pytest.approx([40, radius])
    assert moves.frames[moves.frame[-2]].tool_length == length
    radius_text = f"T1 D1 M6\n$TC_DP6[1,1]=4\n{call}\nG0 X=$P_TOOLR Y=$TC_DP6[1,1]"
    shown = view(radius_text, dialect="siemens", tools={1: make_tool(1, 100.0, 10.0)})[0]
    assert shown.end[-1, :2].tolist() == [radius, 4]


def test_a_radius_that_waits_for_d_is_not_guessed(view):
    text = "T1 M6\n$TC_DP6[1,1]=4\n{}\nG41 G1 X20 Y0 F100\nG40 X30"
    found = view(text.format(""), dialect="siemens", tools={1: make_tool(1, 100.0, 0.0)})[1]
    assert [(item.code, item.line) for item in found] == [("VP012", 4)] and "write D1 after" in found[0].message
    assert view(text.format("D1"), dialect="siemens", tools={1: make_tool(1, 100.0, 0.0)})[1] == ()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("G41 G1 X5", "no tool is in the spindle; load one with T and M6"),
        ("T7 M6\nG41 G1 X5", "--tool-table"),
        ("TRAORI\nA3=0.1 C3=1\nG41 G1 X5", "A3= B3= C3="),
        ("TRAORI\nA3=0.1 C3=1\nBSPLINE X5 A5\nX6\nX7\nG1", "A3= B3= C3="),
    ],
)
def test_messages_name_words_of_the_language(view, text, said):
    found = view(f"{HEAD}{text}\nM30", dialect="siemens", tools=None)[1]
    assert said in found[0].message
    assert not re.search(r"I J K|G41\.1|G42\.1|G43|G49|G10|G53", found[0].message)


@pytest.mark.parametrize(
    ("group", "noted"),
    [
        ("FGROUP(X,Y,Z)", False),
        ("FGROUP()", False),
        ("FGROUP(X,Y)", False),
        ("FGROUP(X,Y,Z,A,C)", True),
    ],
)
def test_f_of_a_group_with_rotary_axes_is_told(view, group, noted):
    """On a control a turn beside a move slows it down; FGROUP(C) with 20 degrees at F600 took 0.1 s in place of 2 s,
    without a word.
    """
    moves, _findings = view(f"{group}\nG1 X1 C9 F9\n{group}\nM30\n", dialect="siemens")
    found = [(item.code, item.severity, item.line) for item in moves.findings]
    assert found == ([("VP039", "note", 1)] if noted else [])


def test_names_of_the_builder_mean_what_the_set_up_says(view):
    """A subprogram that only the control has: with or without values, beside the program's own words or alone."""
    text = "G0 X1 Z9\nM202(0.0024)\nL6\nKX_CLAMP\nTRAOOF\nG0 X2\nM30"
    named = {"M202": "ignore", "L6": "ignore", "KX_CLAMP": "event", "TRAOOF": "tcp off"}
    moves, found = view(text, dialect="siemens", remap=named)
    assert found == ()
    assert moves.end[:, 0].tolist() == [1.0, 2.0]
    events = [event for event in moves.events if event.kind == "remapped"]
    assert [(event.line, event.data["code"], event.data["meaning"]) for event in events] == [
        (4, "KX_CLAMP", "event"),
        (5, "TRAOOF", "tcp off"),
    ]
    for name in ("KX_CLAMP", "L6"):
        (item,) = view(f"{name}\nM30", dialect="siemens")[1]
        assert (item.code, item.line, item.settled_by) == ("VP002", 1, (("remap", name),))
    told = [(event.line, event.data["word"]) for event in moves.events if event.data.get("why") == IGNORED]
    assert told == [(2, "M202"), (3, "L6")]
    found = view("MCALL KX_CLAMP(1)\nX5\nM30", dialect="siemens", remap=named)[1]
    assert [(item.code, item.line, "takes one call" in item.message) for item in found] == [("VP001", 1, True)]


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("CYCEL832(0.01)", "CYCLE832"),
        ("CYCLE8OO(1)", "CYCLE800"),
        ("CYCLEB00(1)", "CYCLE800"),
        ("CYCLE8O(1)", "CYCLE800"),
        ("CYCLE8000(1)", "CYCLE800"),
        ("CYCLE8000", "CYCLE800"),
        ("CYCLEB1(9,5,2,-10)", "CYCLE81"),
        ("TRA0R1", "TRAORI"),
        ("TRAOOF", "TRAFOOF"),
    ],
)
def test_a_slip_of_a_word_that_moves_axes_is_not_to_be_ignored(view, written, meant):
    """CYCLE8OO was left to [remap], and the hole was drilled upright."""
    item = view(f"{written}\nM30", dialect="siemens")[1][0]
    name = written.partition("(")[0]
    assert item.message == f"{name}: no meaning in this language; did you mean {meant}?"
    assert (item.code, item.line, item.settled_by) == ("VP002", 1, ())


def test_user_codes_switch_tool_centre_point_control_as_trafoof_does(machine):
    """Of a name and of an M code: what follows is the same to the last digit."""
    text = "G0 X10 Y5 Z9\nTRAORI\nG0 A30 C40\nG1 F500 X12\n{}\nG0 X3 A10\nX5 Y2\n{}\nG1 X7 A20\nM30"
    remap = {"TRAOOF": "tcp off", "M429": "tcp off", "M428": "tcp on", "TRAON": "tcp on"}
    own = list_places_on(machine, text.format("TRAFOOF", "TRAORI"), "siemens")
    for off, on in (("TRAOOF", "TRAON"), ("M429", "M428")):
        assert list_places_on(machine, text.format(off, on), "siemens", remap=remap) == own
    assert list_places_on(machine, text.format("", ""), "siemens") != own


@pytest.mark.parametrize("angle", [0, 20])
@pytest.mark.parametrize("frame", ["TRANS X5", "ROT Z30", "MIRROR X0", "$P_PFRAME=CTRANS(X,3)"])
@pytest.mark.parametrize("end", ["CYCLE800()", 'CYCLE800(0,"0")'])
def test_the_end_of_a_plane_with_a_frame_set_in_it_is_refused(view, angle, frame, end):
    plane = f'G0 X0 Y0 Z0\nCYCLE800(0,"",0,57,0,0,0,{angle})'
    _moves, found = view(f"{plane}\n{frame}\nX1\n{end}\nX2\nM30", dialect="siemens")
    assert [(item.code, item.line) for item in found] == [("VP017", 5)]
    assert "TRANS without axes before CYCLE800()" in found[0].message
    for text in (f"{plane}\n{frame}\nX1\nTRANS\n{end}\nX2", f"G0 X0 Y0 Z0\n{frame}\n{end}\nX2"):
        assert view(f"{text}\nM30", dialect="siemens")[1] == ()


@pytest.mark.parametrize(
    "text",
    ["X=$TC_DP3[1,1]", "X=$TC_DP6[1,1]", "X=$P_UIFR[1,X,TR]", "R1=$P_F", "R1=$AA_IM[X]", "R1=$P_TOOLR"]
    + ["R1=$P_TOOLL[1]", "$P_UIFR[1,X,TR]=3", "$TC_DP3[1,1]=5", "$TC_DP6[1,1]=5"],
)
def test_lengths_of_the_control_under_g700_are_refused(view, text):
    _moves, found = view(f"G0 X0 Y0 Z0\nG700\n{text}\nX1\nM30", dialect="siemens")
    assert [(item.code, item.line) for item in found] == [("VP017", 3)]
    assert "under G700" in found[0].message


@pytest.mark.parametrize(("name", "said"), [("PART", None), ("part", None), ("OTHER", "PART is called, and its PROC")])
def test_a_proc_line_with_the_name_of_another_subprogram(name: str, said: str | None) -> None:
    """The text of another subprogram may stand under this name."""
    text = f"G90 G94\nG0 X0 Y0 Z50\nPART\nPART\nM30\n%_N_PART_SPF\nPROC {name}\nG1 X9 F500\nRET\n"
    options = Options(tool_length=80.0, wcs={"G54": (0.0, 0.0, 60.0)}, dialect="siemens")
    found = [item for item in verne_post.check(text, "verne", options).findings if item.code == "VP023"]
    assert [(item.line, item.severity) for item in found] == ([(3, "warning")] if said else [])
    assert not said or f"{said} line names {name}" in found[0].message
