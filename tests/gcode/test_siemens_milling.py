"""Milling cycles of Siemens programs: the judge of test_pockets, the same pockets as in Klartext and in G1 to G3, and
the page's table.
"""

import math
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.builders import read_values
from tests.gcode.conftest import make_tool
from tests.gcode.pocket_judge import circle, curved_slot, judge, judge_open_slot, polygon, rectangle
from verne_post.gcode.siemens.milling import MODAL_MILLING
from verne_post.gcode.siemens.milling_values import PARAMETERS
from verne_post.model.moves import MoveKind

TOOL = 8.0
HEAD = "T1 D1 M6\nG0 X10 Y20 Z40 S1000 M3 F300\n"
COMMON = {
    "RTP": 20, "RFP": 0, "SDIS": 2, "DP": -6, "LENG": 40, "WID": 24, "CRAD": 6, "PRAD": 20, "PA": 10, "PO": 20,
    "MID": 3, "FFP1": 500, "FFD": 150, "VARI": 11,
    "MIDA": 4, "RAD1": 3, "DP1": 2, "AP1": 50, "AP2": 30, "NUM": 1, "RAD": 20, "AFSL": 70, "STA1": 10, "FAL": 0,
    "FALD": 0, "CDIR": 0, "MIDF": 0, "STA2": 3,
    "DIATH": 40, "H1": 6, "KDIAM": 30, "PIT": 1.5, "NT": 1, "FFR": 500, "TYPTH": 0, "SWL": 30, "RC": 3,
}  # fmt: skip

#: Values of COMMON that mean something else in a cycle.
OF_CYCLE = {
    "CYCLE70": {},
    "CYCLE79": {"VARI": 1, "NUM": 6},
    "CYCLE90": {"CDIR": 2},
    "CYCLE899": {"VARI": 1001},
}


def write(name, **values):
    """A call with these values of COMMON that it has, and others."""
    values = {
        **COMMON,
        **(
            OF_CYCLE[name]
            if name in OF_CYCLE
            else {"VARI": 1}
            if name.startswith(("CYCLE7", "POCKET1", "POCKET2"))
            else {"VARI": 31}
            if name == "CYCLE61"
            else {}
        ),
        **values,
    }
    return f"{name}({','.join(str(values.get(one, '')) for one in PARAMETERS[name])})"


@pytest.fixture(scope="module")
def mill(view):
    """Execute one cycle with a tool of 8 mm; (moves, findings)."""

    def run(name, head=HEAD, polygon_angle="side", **values):
        text = f"{head}{write(name, **values)}\nM30\n"
        return view(
            text,
            dialect="siemens",
            tools={1: make_tool(1, 10.0, TOOL)},
            control={"siemens": {"polygon_angle": polygon_angle}},
        )

    return run


HERE = (10.0, 20.0)
POCKETS = {
    "POCKET3": ("POCKET3", {}, rectangle(40, 24, 6, 0, HERE)),
    "POCKET3 on a helix, turned, G3": ("POCKET3", {"VARI": 21, "STA": 30, "CDIR": 3}, rectangle(40, 24, 6, 30, HERE)),
    "POCKET3 to and fro, from a corner": ("POCKET3", {"VARI": 31, "_GMODE": 12100}, rectangle(40, 24, 6, 0, (30, 32))),
    "POCKET3 default paths, relative depth": ("POCKET3", {"MIDA": 0, "DP": 6, "_AMODE": 1},
                                              rectangle(40, 24, 6, 0, HERE)),
    "POCKET3 paths in percent": ("POCKET3", {"MIDA": 60, "_AMODE": 10}, rectangle(40, 24, 6, 0, HERE)),
    "POCKET4": ("POCKET4", {"VARI": 21}, circle(20, HERE)),
    "POCKET1": ("POCKET1", {"VARI": 0, "FAL": 0.3}, rectangle(40, 24, 6, 0, HERE)),
    "POCKET2": ("POCKET2", {"VARI": 0, "FAL": 0.3, "DP": "", "DPR": 6}, circle(20, HERE)),
    "SLOT1": ("SLOT1", {"WID": 12, "VARI": 30, "FAL": 0.2, "FALD": 0.1},
              rectangle(40, 12, 6, 10, (10 + 40 * math.cos(math.radians(10)), 20 + 40 * math.sin(math.radians(10))))),
    "SLOT2": ("SLOT2", {"WID": 12}, curved_slot(20, 10, 70, 12, HERE)),
    "LONGHOLE": ("LONGHOLE", {}, rectangle(40, 8, 4, 10,
                                           (10 + 40 * math.cos(math.radians(10)),
                                            20 + 40 * math.sin(math.radians(10))))),
}  # fmt: skip


@pytest.mark.parametrize("name", POCKETS)
def test_pockets_are_milled_whole_and_no_further(mill, name):
    cycle, values, shape = POCKETS[name]
    moves, findings = mill(cycle, **values)
    assert findings == ()
    judge(moves, 0.5 * TOOL, shape, 0.0, -6.0)
    assert moves.end[-1][2] == 20  # the retract plane


def test_finishing_after_roughing_with_allowances(view):
    calls = "\n".join(write("POCKET3", FAL=0.3, FALD=0.2, VARI=kind) for kind in (21, 12))
    moves, findings = view(f"{HEAD}{calls}\nM30", dialect="siemens", tools={1: make_tool(1, 10.0, TOOL)})
    assert findings == ()
    judge(moves, 0.5 * TOOL, rectangle(40, 24, 6, 0, HERE), 0.0, -6.0)
    moves, findings = view(
        f"{HEAD}{write('POCKET3', FAL=0.3, FALD=0.2)}\nM30", dialect="siemens", tools={1: make_tool(1, 10.0, TOOL)}
    )
    assert findings == ()
    judge(moves, 0.5 * TOOL, rectangle(40, 24, 6, 0, HERE), 0.0, -6.0, allowance=0.3, floor_allowance=0.2)


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"CDIR": 1, "STA": 25},
        {"MIDA": 7.9, "MID": 0, "FAL": 0.3, "FALD": 0.2},
        {"LENG": 12, "WID": 9, "MIDA": 0.5},
        {"WID": 40},
    ],
)
@pytest.mark.parametrize("kind", [1001, 2])
def test_open_slots_are_milled_whole_and_their_walls_not_touched(mill, values, kind):
    """Roughed and finished: within LENG all of the floor, and the tool goes down outside of the stock, which ends
    there.
    """
    given = {"LENG": 40, "WID": 14, "STA": 0, **values}
    moves, findings = mill("CYCLE899", VARI=kind, **{**given, **({"FALD": 0.2} if kind == 2 else {})})
    assert findings == ()
    side, floor = (given.get("FAL", 0), given.get("FALD", 0)) if kind == 1001 else (0, 0)
    long = rectangle(500, given["WID"], 0, given["STA"], HERE)
    stock = rectangle(given["LENG"], given["WID"], 0, given["STA"], HERE)
    judge_open_slot(moves, 0.5 * TOOL, long, stock, -6.0 + floor, side)


def test_circles_of_an_open_slot_worked_out_by_hand(mill):
    """16 x 14, tool 8: half circles of 7 - 4 = 3 from 8 + 4 + 2 + 3 = 17 before the middle in 25 / 5 steps to
    its end.
    """
    moves, findings = mill("CYCLE899", LENG=16, WID=14, MID=0, MIDA=5)
    assert findings == ()
    rows = [tuple(float(value) for value in np.round(end[:3], 6) + 0.0) for end in moves.end][1:]
    middles = (-7, -2, 3, 8, 13, 18)
    loops = [((front, 17, -6), (front, 23, -6), (back, 23, -6), (back, 17, -6)) for back, front in pairwise(middles)]
    assert rows == [(-7, 17, 40), (-7, 17, 2), (-7, 17, -6), *sum(loops, ()), (24, 17, -6), (24, 17, 2), (24, 17, 20)]
    centers = [(x, 20) for pair in zip(middles[1:], middles, strict=False) for x in pair]
    np.testing.assert_allclose(moves.arcs.center[:, :2], centers, atol=1e-9)
    assert moves.arcs.sweep.tolist() == [180.0] * 10


def test_a_hexagon_worked_out_by_hand(mill):
    """30 over flats, tool 8: lines 15 + 4 from the middle, arcs of 4 about corners that are 15 tan 30 beside them."""
    moves, findings = mill("CYCLE79", NUM=6, SWL=30, RC=0, AP1=40, MID=0, MIDA=0)
    assert findings == ()
    half, first = 15 * math.tan(math.radians(30)), np.flatnonzero(moves.kind == MoveKind.ARC)[0]
    ends = [(29, 20), (29, 20 - half), (27, 20 - half - 4 * math.sin(math.radians(60)))]
    assert moves.end[first : first + 3, :2] == pytest.approx(np.array(ends), abs=1e-9)
    corner = moves.arcs.center[moves.arc[first + 2]]
    assert (*corner[:2], moves.arcs.sweep[moves.arc[first + 2]]) == pytest.approx((25, 20 - half, -60), abs=1e-9)
    assert (moves.kind[first + 1 :] == MoveKind.ARC).sum() == 7  # six corners, and away from the part


def test_a_square_polygon_is_the_spigot_of_cycle_76(mill):
    """Where the blanks of both let one path go round it: the same moves."""
    both = {"AP1": 36, "MIDA": 0, "STA": 25, "FAL": 0.2}
    one, found = mill("CYCLE79", NUM=4, SWL=30, RC=3, **both)
    assert found == ()
    two, found = mill("CYCLE76", LENG=30, WID=30, CRAD=3, AP2=36, **{**both, "FFD": 500})
    assert found == ()
    assert len(one) == len(two) > 20
    assert one.end == pytest.approx(two.end, abs=1e-9)
    assert one.arcs.sweep == pytest.approx(two.arcs.sweep, abs=1e-9)


def test_a_polygon_worked_out_by_hand(mill):
    """A square of 30, turned by 45 degrees where STA is that of a corner: as CYCLE76 with STA 45 in a round blank."""
    moves, findings = mill("CYCLE79", NUM=4, RC=0, AP1=40, MID=0, MIDA=0)
    assert findings == ()
    arcs = moves.kind == MoveKind.ARC
    # from beside the blank on a quarter circle to 15 + 4 to the right of the middle, then round against the clock:
    # up-cut none
    assert moves.end[arcs][0][:2] == pytest.approx((10 + 19, 20))
    corner, findings = mill("CYCLE79", NUM=4, RC=0, AP1=40, MID=0, MIDA=0, polygon_angle="corner")
    assert findings == ()
    away = 19 * math.sqrt(0.5)
    assert corner.end[corner.kind == MoveKind.ARC][0][:2] == pytest.approx((10 + away, 20 + away))
    found = mill("CYCLE79", polygon_angle="")[1]
    assert [(item.code, "polygon_angle" in item.message) for item in found] == [("VP002", True)]


@pytest.mark.parametrize(("name", "values", "shape", "blank"), [
    ("CYCLE76", {"STA": 25}, rectangle(40, 24, 6, 25, HERE), rectangle(50, 30, 0, 25, HERE)),
    ("CYCLE76", {"_GMODE": 5000, "CDIR": 1}, rectangle(40, 24, 6, 0, (-10, 8)), rectangle(50, 30, 0, 0, (-10, 8))),
    ("CYCLE77", {"AP1": 30}, circle(20, HERE), circle(30, HERE)),
    ("CYCLE79", {"AP1": 60, "STA": 20}, polygon(6, 15, 3, 50, HERE), circle(30, HERE)),
    ("CYCLE79", {"AP1": 34, "NUM": 8, "RC": 0, "MIDA": 0, "CDIR": 1}, polygon(8, 15, 0, 22.5, HERE), circle(17, HERE)),
])  # fmt: skip
def test_spigots_stand_and_their_blanks_are_gone(mill, name, values, shape, blank):
    moves, findings = mill(name, **values)
    assert findings == ()
    judge(moves, 0.5 * TOOL, shape, 0.0, -6.0, blank=blank)


@pytest.mark.parametrize(("name", "values", "blank"), [
    ("CYCLE61", {}, rectangle(40, 24, 0, 0, (30, 32))),
    ("CYCLE61", {"VARI": 21, "LENG": -40, "MIDA": 0}, rectangle(40, 24, 0, 0, (-10, 32))),
    ("CYCLE61", {"VARI": 12, "WID": -24, "FALD": 0.2}, rectangle(40, 24, 0, 0, (30, 8))),
    ("CYCLE61", {"_AMODE": 11010, "MIDA": 80, "PA": 0, "PO": 0}, rectangle(40, 24, 0, 0, (20, 12))),
    ("CYCLE71", {"VARI": 41, "STA": 90, "FDP1": 5}, rectangle(24, 40, 0, 0, (-2, 40))),
    ("CYCLE71", {"VARI": 31, "STA": 90, "LENG": -40, "MIDA": 7}, rectangle(24, 40, 0, 0, (-2, 0))),
])  # fmt: skip
def test_faces_are_milled_whole_from_beside_them(mill, name, values, blank):
    moves, findings = mill(name, **values)
    assert findings == ()
    judge(moves, 0.5 * TOOL, None, 0.0, -6.0, blank=blank)


@pytest.mark.parametrize(("name", "values"), [*((name, {}) for name in MODAL_MILLING), ("CYCLE899", {"VARI": 2})])
def test_milling_of_mcall_is_at_each_place(view, name, values):
    """As single calls there: a block, a row and a grid that is turned; in inches, the same within their digits."""
    tools, control = {1: make_tool(1, 10.0, TOOL)}, {"siemens": {"polygon_angle": "side"}}
    values = {"WID": 14 if name == "CYCLE899" else 24, **values}
    c, s = math.cos(math.radians(20)), math.sin(math.radians(20))
    grid = [(100 + 90 * (u * c - v * s), 90 * (u * s + v * c)) for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))]
    texts = [
        f"MCALL {write(name, **values, PA=0, PO='')}\nG0 X50\nHOLES1(0,0,0,100,50,2)\nCYCLE801(100,0,20,90,90,2,2)\n"
        "MCALL\nX0",
        "".join(
            f"G0 X{x:.12f} Y{y:.12f}\n{write(name, **values, PA=f'{x:.12f}', PO=f'{y:.12f}')}\n"
            for x, y in ((50, 20), (100, 0), (150, 0), *grid)
        )
        + "X0",
    ]
    one, two = (view(f"{HEAD}{text}\nM30", dialect="siemens", tools=tools, control=control) for text in texts)
    assert (one[1], two[1]) == ((), ())
    assert len(one[0]) == len(two[0]) > 7 * 4
    assert np.abs(one[0].end - two[0].end).max() < 1e-9


def test_what_mcall_does_not_execute(view):
    """A pattern of too many strokes is refused before it runs for hours, PA beside the place, and other cycles."""
    tools = {1: make_tool(1, 10.0, TOOL)}
    many = f"{HEAD}MCALL {write('POCKET4', PA=0, PO=0, MID=0.01)}\nHOLES1(0,0,0,100,50,9000)\nM30"
    assert [(item.code, "strokes" in item.message) for item in view(many, dialect="siemens", tools=tools)[1]] == [
        ("VP007", True)
    ]
    found = view(f"{HEAD}MCALL {write('POCKET4', PA=5)}\nX50\nM30", dialect="siemens", tools=tools)[1]
    assert [(item.code, item.line) for item in found] == [("VP002", 3)]  # the line of MCALL
    found = view(f"{HEAD}MCALL {write('SLOT1')}\nX50\nM30", dialect="siemens", tools=tools)[1]
    assert [(item.code, "at each place" in item.message) for item in found] == [("VP002", True)]


def test_levels_are_even_and_faces_worked_out_by_hand(mill):
    """5 mm in infeeds of at most 2 are three of 5/3; 20 wide, paths of at most 6: four of 5; SDIS and the radius beyond
    the edges.
    """
    moves, findings = mill("CYCLE61", DP=-5, MID=2, MIDA=6, LENG=-30, WID=20, VARI=41)
    assert findings == ()
    down = [(round(z, 6)) for z in sorted({float(end[2]) for end in moves.end if end[2] < 0}, reverse=True)]
    assert down == [round(-5 / 3, 6), round(-10 / 3, 6), -5.0]
    floor = [tuple(float(v) for v in end[:2]) for end in moves.end if abs(end[2] + 5) < 1e-9]
    # along the second axis: rows at 10 - 30 / 5 * row, their far edges at 4, -2, -8, -14, -20; the tool's middle 4
    # before
    rows = [10 - 6 * row + 4 for row in (1, 2, 3, 4, 5)]
    ends = 20 - 6, 40 + 6
    assert floor == [(row, y) for number, row in enumerate(rows) for y in (ends if number % 2 == 0 else ends[::-1])]


# --- one pocket in four languages --------------------------------------------------------------------------


def run_all(view, siemens, klartext, rs274, fanuc):
    """Ends, feed rates and arcs of a program in each language: the moves from the first below Z 40 to the last one."""
    tools = {1: make_tool(1, 10.0, TOOL)}
    found = []
    for dialect, text in (
        ("siemens", f"{HEAD}{siemens}\nM30\n"),
        (
            "heidenhain",
            f"BEGIN PGM C MM\nTOOL CALL 1 Z S1000 F300\nL X+10 Y+20 Z+40 R0 FMAX M3\n{klartext}\nEND PGM C MM\n",
        ),
        ("rs274", f"G21 G90 G64\nT1 M6 G43 H1\nG0 X10 Y20 Z40 S1000 M3\n{rs274}\nM2\n"),
        ("fanuc", f"%\nO1\nG21 G90 G17 G40 G80 G54\nT1 M6\nG0 G43 H1 X10 Y20 Z40 S1000 M3\n{fanuc}\nM30\n%\n"),
    ):
        if dialect == "fanuc":
            text = re.sub(r"(?<=[XYZIJRF])(-?\d+)(?![\d.])", r"\1.", text)
        moves, findings = view(text, dialect=dialect, tools=tools, tapping="feed")
        assert findings == (), dialect
        sweep = np.array([moves.arcs.sweep[arc] if arc >= 0 else 0.0 for arc in moves.arc])
        center = np.array([moves.arcs.center[arc][:2] if arc >= 0 else (0.0, 0.0) for arc in moves.arc])
        found.append(np.column_stack([moves.kind, moves.end[:, :3], np.nan_to_num(moves.feed), sweep, center]))
        found[-1] = found[-1][1:][
            np.abs(np.diff(found[-1][:, 1:4], axis=0)).max(axis=1) > 0
        ]  # without what does not move
    return found


Q = "Q207=500 Q351=1 Q201=-6 Q202=3 Q369=0 Q206=150 Q338=0 Q200=2 Q203=0 Q204=20"
#: A slot of 40 x 10 about X10 Y20: the middle line, then 1 mm beside it, on two levels.
SLOT = "G0 Z2\n" + "\n".join(
    f"G1 Z{z} F150\nG1 X25 F500\nX-5\nX10\nY19\nX25\nG3 X25 Y21 J1\nG1 X-5\nG3 X-5 Y19 J-1\nG1 X10\nG0 Z{z + 2}\nG0 Y20"
    for z in (-3, -6)
)
#: A circle of 30 mm in two paths of at most 8 * 0.8.
ROUND_ONE = "G0 Z2\n" + "\n".join(
    f"G1 Z{z} F150\n"
    + "".join(f"G1 Y{20 - r} F500\nG3 X10 Y{20 + r} J{r}\nG3 X10 Y{20 - r} J-{r}\n" for r in (5.5, 11))
    + f"G0 Z{z + 2}\nG0 Y20"
    for z in (-3, -6)
)
#: Five holes on a circle of 40 mm about X0 Y0, the first at 15 degrees.
HOLES = "G0 Z2\n" + "\n".join(
    f"G0 X{20 * math.cos(a):.9f} Y{20 * math.sin(a):.9f}\nG1 Z-6 F150\nG0 Z2"
    for a in (math.radians(15 + 72 * k) for k in range(5))
)
#: A thread M20 x 1.5, 6 mm deep, with a tool of 8 mm. In Klartext the wall is milled at 500 mm/min, and half circles
#: have the slope of the helix. In Siemens the tool's middle goes at 500, and half circles go along the axis by 1.5 / 4
#: * (8 + 10 - 4) / 20.
ON_WALL = 500 * math.hypot(12 * math.pi, 1.5) / math.hypot(20 * math.pi, 1.5)
OVERRUN = 0.2625


def write_thread(code, ramp, feed=500, plunge=500):
    """Four turns on a circle of 10 - 4: upwards with G3, downwards with G2."""
    heights, up = ((-6, -4.5, -3, -1.5, 0), 1) if code == "G3" else ((0, -1.5, -3, -4.5, -6), -1)
    return (
        f"G0 Z2\nG1 Z{heights[0] - up * ramp} F{plunge}\n{code} X16 Y20 I3 J0 Z{heights[0]} F{feed:.10f}\n"
        + "".join(f"{code} X16 Y20 I-6 J0 Z{z}\n" for z in heights[1:])
        + f"{code} X10 Y20 I-3 J0 Z{heights[-1] + up * ramp}\nG0 Z2\nG0 Z20"
    )


def write_thread_in_klartext(turn, ramp):
    """The same with CP, DR+ upwards and DR- downwards, all at 500 mm/min."""
    up = 1 if turn == "+" else -1
    half = f"CC X+13 Y+20\nCP IPA{turn}180 IZ{up * ramp:+} DR{turn} F500\n"
    whole = f"CP IPA{turn}360 IZ{up * 1.5:+} DR{turn}\n"
    begin = -6 - ramp if up > 0 else ramp
    return f"L Z+2 FMAX\nL Z{begin:+} F500\n{half}CC X+10 Y+20\n{whole * 4}{half}L Z+2 FMAX\nL Z+20 FMAX"


#: Each in Siemens, Klartext, RS274/NGC and Fanuc; where a control has no cycle for it, written out.
SAME = {
    "slot": (
        "SLOT1(20,0,2,-6,,1,40,10,-30,20,20,0,0,150,500,3,0,0,11)",
        f"CYCL DEF 253 S Q215=1 Q218=40 Q219=10 Q368=0 Q374=0 Q367=0 {Q} Q366=0\nCYCL CALL",
        f"{SLOT}\nG0 Z2\nG0 Z20",
        f"{SLOT}\nG0 Z2\nG0 Z20",
    ),
    # G13 of Haas comes from the middle on half circles: written out
    "round pocket": (
        "POCKET4(20,0,2,-6,15,10,20,3,0,0,500,150,0,11)",
        f"CYCL DEF 252 P Q215=1 Q223=30 Q368=0 {Q} Q370=1.6 Q366=0\nCYCL CALL",
        f"{ROUND_ONE}\nG0 Z2\nG0 Z20",
        f"{ROUND_ONE}\nG0 Z2\nG0 Z20",
    ),
    # Klartext stays at the set-up clearance between holes (Q301=0), Siemens goes to RTP, Haas to R (G99): here the same
    "bolt circle": (
        "G0 Z2\nF150\nMCALL CYCLE81(2,0,2,-6)\nHOLES2(0,0,20,15,72,5)\nMCALL",
        "L Z+2 FMAX\nCYCL DEF 200 D Q200=2 Q201=-6 Q206=150 Q202=6 Q210=0 Q203=0 Q204=2 Q211=0\n"
        "CYCL DEF 220 C Q216=0 Q217=0 Q244=40 Q245=15 Q246=375 Q247=72 Q241=5 Q200=2 Q203=0 Q204=2 Q301=0",
        HOLES,
        "G0 Z2\nG99 G81 Z-6 R2 L0 F150\nG70 X0 Y0 I20 J15. L5\nG80",
    ),
    "thread of Klartext": (
        write_thread("G3", 0.375, ON_WALL, 700),
        "CYCL DEF 262 T Q335=20 Q239=1.5 Q201=-6 Q355=1 Q253=700 Q351=1 Q200=2 Q203=0 Q204=20 Q207=500\nCYCL CALL",
        *[write_thread("G3", 0.375, ON_WALL, 700)] * 2,
    ),
    "thread of Klartext, downwards": (
        write_thread("G2", 0.375, ON_WALL, 700),
        "CYCL DEF 262 T Q335=20 Q239=1.5 Q201=-6 Q355=1 Q253=700 Q351=-1 Q200=2 Q203=0 Q204=20 Q207=500\nCYCL CALL",
        *[write_thread("G2", 0.375, ON_WALL, 700)] * 2,
    ),
    "thread of Siemens": (
        "CYCLE70(20,0,2,-6,20,0.92,0,1.5,1,0,500,0,10,20,0,21)",
        write_thread_in_klartext("+", OVERRUN),
        *[write_thread("G3", OVERRUN)] * 2,
    ),
    "thread of Siemens, downwards": (
        "CYCLE90(20,0,2,-6,,20,18.16,1.5,500,2,0,10,20)",
        write_thread_in_klartext("-", OVERRUN),
        *[write_thread("G2", OVERRUN)] * 2,
    ),
    "tapped thread": (
        "G0 Z20\nCYCLE84(20,0,2,-6,,,3,,1.25,0,500,500)",
        "L Z+20 FMAX\nTOOL CALL S500\nCYCL DEF 207 R Q200=2 Q201=-6 Q239=1.25 Q203=0 Q204=20\nCYCL CALL",
        "G0 Z20\nS500 M3\nG99 G84 Z-6 R2 F625\nG80\nG0 Z20",
        "G0 Z20\nM29 S500\nG98 G84 Z-6 R2 F625\nG80",
    ),
}


@pytest.mark.parametrize("name", SAME)
def test_the_same_in_four_languages(view, name):
    """Ends, feed rates, arcs: within 1e-6 mm, mm/min and degrees."""
    siemens, klartext, rs274, fanuc = run_all(view, *SAME[name])
    assert len(rs274) > 3
    for other in (siemens, klartext, fanuc):
        assert other.shape == rs274.shape
        assert np.abs(other - rs274).max() < 1e-6


@pytest.mark.parametrize(("name", "values", "code", "part"), [
    ("POCKET3", {"WID": 7, "CRAD": 0}, "VP007", "no room"), ("POCKET3", {"CRAD": 13}, "VP007", "CRAD"),
    ("POCKET3", {"SDIS": -2}, "VP007", "SDIS -2"),
    ("POCKET3", {"RTP": ""}, "VP005", "RTP"), ("POCKET3", {"DP": 6}, "VP007", "bottom"),
    ("POCKET3", {"VARI": 15}, "VP002", "VARI"), ("POCKET3", {"VARI": 41}, "VP002", "VARI"),
    ("POCKET3", {"VARI": 21, "RAD1": 0}, "VP007", "RAD1"), ("POCKET3", {"VARI": 31, "RAD1": 90}, "VP007", "RAD1"),
    ("POCKET3", {"MIDA": 8}, "VP007", "MIDA"), ("POCKET3", {"CDIR": 4}, "VP007", "CDIR"),
    ("POCKET3", {"_GMODE": 20000}, "VP002", "_GMODE"), ("POCKET3", {"_AMODE": 3}, "VP002", "_AMODE"),
    ("POCKET3", {"_DMODE": 2}, "VP002", "_DMODE"), ("POCKET3", {"MID": 0.0001}, "VP007", "strokes"),
    ("POCKET3", {"FFP1": -1}, "VP009", "FFP1"), ("POCKET4", {"PRAD": 0}, "VP007", "PRAD"),
    ("SLOT1", {"LENG": 10, "WID": 12}, "VP007", "LENG"), ("SLOT1", {"NUM": 0}, "VP007", "NUM"),
    ("SLOT1", {"SSF": 2000}, "VP002", "SSF"), ("SLOT1", {"_GMODE": 1000}, "VP002", "_GMODE"),
    ("SLOT2", {"AFSL": 350, "WID": 12}, "VP007", "AFSL"), ("CYCLE76", {"AP1": 30}, "VP007", "AP1"),
    ("CYCLE61", {"_AMODE": 11010}, "VP002", "where PA or PO is not 0"),
    ("CYCLE61", {"_AMODE": 2010, "PA": 0, "PO": 0}, "VP002", "for 2, its thousands digit; it must be 0 to 1"),
    ("CYCLE61", {"_AMODE": 110}, "VP002", "for 1, its hundreds digit; it must be 0"),
    ("CYCLE61", {"LIM": 1}, "VP002", "LIM"), ("CYCLE61", {"VARI": 51}, "VP002", "VARI"),
    ("CYCLE79", {"NUM": 5}, "VP002", "NUM"), ("CYCLE79", {"NUM": 2}, "VP002", "NUM"),
    ("CYCLE79", {"NUM": 9998}, "VP007", "NUM"), ("CYCLE79", {"RC": 16}, "VP007", "RC"),
    ("CYCLE79", {"AP1": 29}, "VP007", "AP1"), ("CYCLE79", {"VARI": 4}, "VP002", "VARI"),
    ("CYCLE79", {"_AMODE": 1000}, "VP002", "for 1, its thousands digit; it must be 0"),
    ("CYCLE899", {"VARI": 1}, "VP002", "VARI"),
    ("CYCLE899", {"VARI": 2001}, "VP002", "VARI"), ("CYCLE899", {"MIDA": 0}, "VP007", "MIDA"),
    ("CYCLE899", {"WID": 8}, "VP007", "no room"), ("CYCLE899", {"WID": 7, "VARI": 2}, "VP007", "narrower"),
    ("CYCLE899", {"_GMODE": 2000}, "VP002", "_GMODE"), ("CYCLE899", {"CDIR": 4}, "VP007", "CDIR"),
    ("CYCLE899", {"MIDA": 0.0001}, "VP007", "strokes"),
    ("CYCLE71", {"LENG": 0, "VARI": 31}, "VP007", "LENG"), ("POCKET1", {"SSF": 900}, "VP002", "SSF"),
])  # fmt: skip
def test_mistakes_are_refused_before_the_first_move(mill, name, values, code, part):
    moves, findings = mill(name, **values)
    assert [item.code for item in findings] == [code]
    assert part in findings[0].message
    assert len(moves) == 1


def test_what_a_pocket_needs_before(view):
    tools = {1: make_tool(1, 10.0, TOOL)}
    for head, code in (
        ("G0 X10 Y20 Z40 S1000 M3 F300\n", "VP012"),
        (f"{HEAD}G93\n", "VP017"),
        (f"{HEAD}SCALE X2\n", "VP017"),
    ):
        found = view(f"{head}{write('POCKET4')}\nM30", dialect="siemens", tools=tools)[1]
        assert [item.code for item in found][:1] == [code], head
    found = view(f"{HEAD.replace('F300', '')}{write('POCKET4', FFP1=0, FFD=0)}\nM30", dialect="siemens", tools=tools)[1]
    assert [item.code for item in found] == ["VP009"]


PAGE = Path(__file__).parents[2] / "docs" / "siemens.md"
OTHER = {
    "MID": 2,
    "VARI": 21,
    "CDIR": 1,
    "NUM": 2,
    "MIDA": 3,
    "FALD": 0.2,
    "FAL": 0.2,
    "SSF": 0,
    "DPR": 5,
    "WID": 20,
    "LENG": 44,
    "CRAD": 5,
    "AP1": 52,
    "INDA": 30,
    "FDP": 5,
    "FDP1": 5,
    "_PITA": 2,
}
BESIDE = {
    "_AMODE": {"RFP": -1},
    "KDIAM": {"TYPTH": 1},
    "RAD1": {"VARI": 21},
    "DP1": {"VARI": 21},
    "STA2": {"VARI": 31},
    "INDA": {"NUM": 2},
    "FFP2": {"FAL": 0.3, "VARI": 12},
    "MIDF": {"FAL": 0.3, "VARI": 12},
}


def rows():
    """Values of the table of the page, each with its kind."""
    table = PAGE.read_text(encoding="utf-8").split("| value | kind | does |\n|---|---|---|\n")[1].split("\n\n")[0]
    found = []
    for line in table.splitlines():
        names, kind, _does = (cell.strip() for cell in line.strip("|").split("|", 2))
        found += [(name, value, kind) for name, value in read_values(names)]
    return found


def test_the_page_names_every_value():
    assert {name for values in PARAMETERS.values() for name in values} == {name for name, *_rest in rows()}


@pytest.mark.parametrize(("name", "value", "kind"), rows())
def test_every_value_does_what_the_page_says(mill, name, value, kind):
    having = [cycle for cycle, values in PARAMETERS.items() if name in values]
    assert having
    for cycle in having:
        before = dict(BESIDE.get(name, {}))
        if cycle == "SLOT2" and name == "VARI":
            before["FAL"] = 0.2
        if cycle.startswith(("SLOT", "LONG")):
            before = {"WID": 12, **before, **({"VARI": 11} if before.get("VARI") == 21 else {})}
        if cycle.startswith(("POCKET1", "POCKET2", "CYCLE7")) and "VARI" in before:
            before["VARI"] %= 10
        if cycle == "CYCLE71":
            before.setdefault("VARI", 31)
        effect = "without effect" if name in ("AP1", "AP2") and cycle.startswith("POCKET") else kind
        if kind == "refused":
            found = mill(cycle, **{**before, name: value})[1]
            assert [(item.code, name in item.message) for item in found] == [("VP002", True)], cycle
            continue
        other = _other(cycle, name)
        if other is None:
            continue
        one, two = (mill(cycle, **{**before, **more}) for more in ({}, {name: other}))
        assert (one[1], two[1]) == ((), ()), cycle
        shown = [
            [table.end.tolist(), np.nan_to_num(table.feed).tolist(), table.arcs.sweep.tolist()]
            for table, _findings in (one, two)
        ]
        assert (shown[0] != shown[1]) == (effect == "executed"), cycle


#: Other values where those of OTHER do not fit; None: no other is executed.
DIFFERENT = {
    ("CYCLE90", "CDIR"): 3,
    ("CYCLE79", "NUM"): 8,
    ("CYCLE79", "_GMODE"): None,
    ("CYCLE70", "NT"): None,
    ("CYCLE899", "VARI"): 2,
    ("CYCLE899", "_GMODE"): None,
}


def _other(cycle, name):
    """Another value that a cycle takes; None where it takes no other."""
    if (cycle, name) in DIFFERENT:
        return DIFFERENT[cycle, name]
    if name == "VARI":
        return {"CYCLE61": 32, "CYCLE70": 21, "CYCLE71": 41, "LONGHOLE": None, "SLOT1": 31, "SLOT2": 10}.get(
            cycle, 2 if cycle.startswith(("POCKET1", "POCKET2", "CYCLE7")) else 21
        )
    if name == "AP1" and cycle.startswith("POCKET"):
        return 7
    if name in ("_GMODE",):
        return None if "LENG" not in PARAMETERS[cycle] or cycle in ("SLOT1", "LONGHOLE") else 2000
    if name == "DP1" and cycle == "SLOT1":
        return None  # helices are not executed there
    if name == "_AMODE":
        return 1
    if name == "WID" and cycle.startswith("SLOT"):
        return 13
    return OTHER.get(name, COMMON.get(name, 0) + 1)


# --- corners of contours ------------------------------------------------------------------------------------

START = "T1 D1 M6\nG0 X0 Y0 Z5 F300 S1000 M3\n"


def place_and_feed(view, text, **options):
    """Kind, X, Y, Z and feed rate of each move after the first."""
    moves, findings = view(f"{START}{text}\nM30", dialect="siemens", tools={1: make_tool(1, 10.0, 4.0)}, **options)
    assert findings == ()
    rows = zip(moves.kind, moves.end, moves.feed, strict=True)
    return [
        (
            "RLA"[(MoveKind.RAPID, MoveKind.FEED, MoveKind.ARC).index(kind)],
            *np.round(end[:3], 6) + 0.0,
            np.nan_to_num(feed),
        )
        for kind, end, feed in rows
    ][1:]


def test_corners_worked_out_by_hand(view):
    """Right angles: a rounding loses its radius on both lines, CHR what it says, CHF its length over the root of 2."""
    root = round(2 / math.sqrt(2), 6)
    assert place_and_feed(view, "G1 X20 RND=4\nY20 CHR=3 FRC=50\nX0 CHF=2\nY0\nG0 Z20") == [
        ("L", 16, 0, 5, 300),
        ("A", 20, 4, 5, 300),
        ("L", 20, 17, 5, 300),
        ("L", 17, 20, 5, 50),
        ("L", root, 20, 5, 300),
        ("L", 0, 20 - root, 5, 300),
        ("L", 0, 0, 5, 300),
        ("R", 0, 0, 20, 0),
    ]
    # RNDM holds until RNDM=0; F of the next block is that of the next line
    assert place_and_feed(view, "G1 X20 RNDM=2\nY20 F200\nRNDM=0\nX0\nY0") == [
        ("L", 18, 0, 5, 300),
        ("A", 20, 2, 5, 300),
        ("L", 20, 18, 5, 200),
        ("A", 18, 20, 5, 200),
        ("L", 0, 20, 5, 200),
        ("L", 0, 0, 5, 200),
    ]
    # line and arc, tangential: nothing to round; what is not followed by a contour keeps its corner
    assert [
        row[:4] for row in place_and_feed(view, "G1 X20 RND=2\nG3 Y20 CR=10\nG1 X0 RND=3\nZ9\nX5 RND=1\nG0 X9")
    ] == [
        ("L", 20, 0, 5),
        ("A", 20, 20, 5),
        ("L", 0, 20, 5),
        ("L", 0, 20, 9),
        ("L", 5, 20, 9),
        ("R", 9, 20, 9),
    ]


def test_corners_are_those_of_lines_and_arcs_written_out(view):
    """Under G41 and G91, in inches, mirrored, and after a subprogram: as G1, G2 and G3 with the same places."""
    for corners, written in (
        (
            "G41 G1 X20 Y5\nX40 RND=4\nY40 CHR=2\nX10\nG40 X0 Y60",
            "G41 G1 X20 Y5\nX36\nG3 X40 Y9 CR=4\nG1 Y38\nX38 Y40\nX10\nG40 X0 Y60",
        ),
        ("G91 G1 X20 RND=4\nY20\nX5", "G91 G1 X16\nG3 X4 Y4 CR=4\nG1 Y16\nX5"),
        ("G70 G1 X1 RND=0.1\nY1", "G70 G1 X0.9\nG3 X1 Y0.1 CR=0.1\nG1 Y1"),
        ("MIRROR X0\nG1 X20 RND=4\nY20", "MIRROR X0\nG1 X16\nG3 X20 Y4 CR=4\nG1 Y20"),
    ):
        one, two = place_and_feed(view, corners), place_and_feed(view, written)
        assert [row[0] for row in one] == [row[0] for row in two]
        assert np.abs(np.array([row[1:] for row in one]) - np.array([row[1:] for row in two])).max() < 2e-6


@pytest.mark.parametrize(("text", "code", "line"), [
    ("G1 X20 RND=3\nY20 M8", "VP017", 4), ("G1 X20 RND=3\nM8\nY20", "VP017", 4), ("G1 X20 RND=3\nG91 Y20", "VP017", 4),
    ("G1 X20 RND=30\nY20", "VP008", 3), ("G1 X20 CHR=3\nG2 X40 Y20 CR=20", "VP008", 3),
    ("G1 X20 RND=-1\nY20", "VP007", 3), ("G1 X20 RND=1 CHR=1\nY20", "VP003", 3), ("G0 X20 RND=1\nY20", "VP017", 3),
    ("G9 G1 X20 RND=1\nY20", "VP017", 3), ("G1 X20 FRC=9\nY20", "VP006", 3),
    ("G1 X20 RNDM=-1\nY20", "VP007", 3), ("G18 G1 X20 RND=1\nZ20", "VP002", 3),
])  # fmt: skip
def test_corners_that_cannot_be(view, text, code, line):
    found = view(f"{START}{text}\nM30", dialect="siemens")[1]
    assert [(item.code, item.line) for item in found][:1] == [(code, line)]


def test_lines_after_rndm_are_not_executed_in_a_stretch(view):
    lines = "\n".join(f"X{21 + k} Y{k % 2}" for k in range(60))
    moves, findings = view(f"{START}G1 X20 RNDM=0.1\n{lines}\nRNDM=0\nX0\nM30", dialect="siemens")
    assert findings == ()
    assert (moves.kind == MoveKind.ARC).sum() == 60


# --- units, planes, maps ------------------------------------------------------------------------------------


def table_of(view, text, dialect="siemens"):
    """Kind, place, feed rate and sweep of every move."""
    moves, findings = view(text, dialect=dialect, tools={1: make_tool(1, 10.0, TOOL)})
    assert findings == ()
    sweep = [moves.arcs.sweep[arc] if arc >= 0 else 0.0 for arc in moves.arc]
    return np.column_stack([moves.kind, moves.end[:, :3], np.nan_to_num(moves.feed), sweep])


SIZES = {
    "LENG": 40,
    "WID": 24,
    "CRAD": 6,
    "RTP": 20,
    "SDIS": 2,
    "DP": -6,
    "MID": 3,
    "PA": 0,
    "PO": 0,
    "FAL": 0.3,
    "FALD": 0.2,
    "MIDA": 5,
    "RAD1": 3,
    "DP1": 1,
}


def test_pockets_in_inches_are_pockets_in_mm(view):
    start = "T1 D1 M6\nG71 G0 X0 Y0 Z40 S1000 M3\n"
    inches = {name: f"{value / 25.4:.12f}" for name, value in SIZES.items()}
    mm = table_of(view, f"{start}{write('POCKET3', **SIZES, VARI=21)}\nM30")
    assert np.abs(table_of(view, f"{start}G70\n{write('POCKET3', **inches, VARI=21)}\nM30") - mm).max() < 1e-6
    feeds = {"FFP1": f"{500 / 25.4:.12f}", "FFD": f"{150 / 25.4:.12f}"}
    assert np.abs(table_of(view, f"{start}G700\n{write('POCKET3', **inches, **feeds, VARI=21)}\nM30") - mm).max() < 1e-6


def test_pockets_in_other_planes_have_their_axes_exchanged(view):
    start = "T1 D1 M6\nG0 X0 Y0 Z0 S1000 M3\n"
    one = table_of(view, f"{start}G0 Z40\n{write('POCKET3', **SIZES, VARI=21)}\nM30")
    for plane, order, up in (("G18", (2, 0, 1), "Y40"), ("G19", (1, 2, 0), "X40")):
        moves, findings = view(
            f"{start}{plane} G0 {up}\n{write('POCKET3', **SIZES, VARI=21)}\nM30",
            dialect="siemens",
            tools={1: make_tool(1, 10.0, TOOL)},
        )
        assert findings == () or plane == "G18"
        assert np.abs(moves.end[:, list(order)] - one[:, 1:4]).max() < 1e-9


def test_maps_move_pockets_of_both_languages(view):
    """A mirror image turns the way round, as for any contour; a rotation and a datum shift move the pocket; scaling is
    not that of the tool.
    """
    start = "T1 D1 M6\nG0 X0 Y0 Z40 S1000 M3\n"
    plain = table_of(view, f"{start}{write('POCKET3', **SIZES, VARI=21, CDIR=3)}\nM30")
    mirrored = table_of(view, f"{start}MIRROR X0\n{write('POCKET3', **SIZES, VARI=21, CDIR=3)}\nM30")
    assert np.abs(plain * [1, -1, 1, 1, 1, -1] - mirrored).max() < 1e-9
    head = "BEGIN PGM C {}\nTOOL CALL 1 Z S1000 F300\nL X+0 Y+0 Z{} R0 FMAX M3\n"
    words = (
        "Q215=0 Q218={} Q219={} Q220={} Q368={} Q224=0 Q367=0 Q207={} Q351=1 Q201={} Q202={} Q369={} Q206={} Q338=0 "
        "Q200={} Q203=0 Q204={} Q370=1 Q366=1 Q385={}"
    )

    def pocket(scale, feed):
        return words.format(
            *(value / scale for value in (40, 24, 6, 0.3)),
            500 / feed,
            *(value / scale for value in (-6, 3, 0.2)),
            150 / feed,
            2 / scale,
            20 / scale,
            400 / feed,
        )

    one = table_of(view, f"{head.format('MM', 40)}CYCL DEF 251 P {pocket(1, 1)}\nCYCL CALL\nEND PGM C MM", "heidenhain")
    inch = table_of(
        view,
        f"{head.format('INCH', 40 / 25.4)}CYCL DEF 251 P {pocket(25.4, 2.54)}\nCYCL CALL\nEND PGM C INCH",
        "heidenhain",
    )
    assert np.abs(one - inch).max() < 1e-6
    scaled = table_of(
        view,
        f"{head.format('MM', 40)}CYCL DEF 11.0 SCALING\n"
        "CYCL DEF 11.1 SCL0.5\n"
        f"CYCL DEF 251 P {pocket(0.5, 1)}\n"
        "CYCL CALL\n"
        "END PGM C MM",
        "heidenhain",
    )
    assert np.abs(one - scaled).max() < 1e-6
    flipped = table_of(
        view,
        f"{head.format('MM', 40)}CYCL DEF 8.0 MIRROR\n"
        "CYCL DEF 8.1 X\n"
        f"CYCL DEF 251 P {pocket(1, 1)}\n"
        "CYCL CALL\n"
        "END PGM C MM",
        "heidenhain",
    )
    assert np.abs(one * [1, -1, 1, 1, 1, -1] - flipped).max() < 1e-9


def test_a_spindle_that_turns_back_turns_climb_milling_round(view):
    one, two = (
        table_of(view, f"T1 D1 M6\nG0 X0 Y0 Z40 S1000 {m}\n{write('POCKET4', VARI=21, CDIR=0)}\nM30")
        for m in ("M3", "M4")
    )
    assert np.abs(one[:, 5] + two[:, 5]).max() == 0
    assert np.abs(one[:, 5]).max() == 180
