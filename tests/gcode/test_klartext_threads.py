"""Thread milling of Klartext (262 to 265, 267): the path that is written out in RS274/NGC, and the thread on
the wall.
"""

import math

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from verne_post import convert
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options

HEAD = "BEGIN PGM C MM\nTOOL CALL 1 Z S1000 F300\nL X+10 Y+20 Z+40 R0 FMAX M3\n"
TOOLS = {1: make_tool(1, 10.0, 8.0)}
Q = "Q335=20 Q239=1.5 Q201=-6 Q253=700 Q200=2 Q203=0 Q204=20 Q207=500"
#: Mm/min of the middle on a circle of so many mm while the teeth go along the wall, at 10 mm, at 500.
INSIDE, OUTSIDE = (
    f"F{500 * math.hypot(2 * math.pi * radius, 1.5) / math.hypot(20 * math.pi, 1.5):.10f}" for radius in (6, 14)
)
#: A tool of 8 mm over X10 Y20. One turn upwards at the depth, on a circle of 10 - 4, from and to the middle: 262 with
#: Q355=0, 263, 264.
ONE_TURN = f"G1 Z-6.375 F700\nG3 X16 Y20 I3 J0 Z-6 {INSIDE}\nG3 X16 Y20 I-6 J0 Z-4.5\nG3 X10 Y20 I-3 J0 Z-4.125\n"
#: Four turns downwards from the surface, away from the thread at its end: 265.
DOWN = (
    f"G1 Z0.375 F700\nG2 X16 Y20 I3 J0 Z0 {INSIDE}\n"
    + "".join(f"G2 X16 Y20 I-6 J0 Z{z}\n" for z in (-1.5, -3, -4.5, -6))
    + "G2 X10 Y20 I-3 J0\n"
)
#: A countersink with the middle of the tool on a circle of 2 mm, 0.5 mm deep.
FRONT = "G3 X12 Y20 I1 J0 F150\nG3 X12 Y20 I-2 J0\nG3 X10 Y20 I-1 J0\n"
#: A quarter of the pitch times 1.5 / 14: half circles of 1.5 mm beside a circle of 10 + 4.
RAMP = 0.25 * 1.5 * 1.5 / 14
#: 267 in climb milling: clockwise and so downwards; from and to X 10 + 14 + 1.5.
STUD = (
    f"G0 X25.5\nG1 Z{RAMP:.10f} F700\nG3 X24 Y20 I-0.75 J0 Z0 F500\n{OUTSIDE}\n"
    + "".join(f"G2 X24 Y20 I-14 J0 Z{z}\n" for z in (-1.5, -3, -4.5, -6))
    + f"G3 X25.5 Y20 I0.75 J0 Z{-6 - RAMP:.10f} F500\n"
)
#: Its countersink: from that place on a half circle to 9 mm from the middle, once round clockwise, and back.
STUD_FRONT = "G0 X25.5\nG1 Z-0.5 F700\nG3 X19 Y20 I-3.25 J0 F150\nG2 X19 Y20 I-9 J0\nG3 X25.5 Y20 I3.25 J0\n"
CYCLES = {
    "262": (f"262 T {Q} Q355=0 Q351=1", ONE_TURN),
    "263": (f"263 T {Q} Q356=0 Q351=1 Q357=0 Q358=0 Q359=0 Q254=150", ONE_TURN),
    "263, countersink": (
        f"263 T {Q} Q356=0 Q351=1 Q357=0 Q358=-0.5 Q359=2 Q254=150",
        f"G1 Z-0.5 F700\n{FRONT}{ONE_TURN}",
    ),
    "263, countersink alone": (
        f"263 T {Q} Q356=0 Q351=1 Q357=0 Q358=-0.5 Q359=2 Q254=150".replace("Q201=-6", "Q201=0"),
        f"G1 Z-0.5 F700\n{FRONT}",
    ),
    "264": (
        f"264 T {Q} Q356=-10 Q351=1 Q202=4 Q258=0.5 Q257=0 Q256=0 Q358=0 Q359=0 Q206=150",
        f"G1 Z-4 F150\nG0 Z2\nZ-3.5\nG1 Z-8 F150\nG0 Z2\nZ-7.5\nG1 Z-10 F150\n{ONE_TURN}",
    ),
    "264, chip breaks": (
        f"264 T {Q} Q356=-7 Q351=1 Q202=9 Q258=0.5 Q257=3 Q256=0.2 Q358=0 Q359=0 Q206=150",
        f"G1 Z-3 F150\nG0 Z-2.8\nG1 Z-6 F150\nG0 Z-5.8\nG1 Z-7 F150\n{ONE_TURN}",
    ),
    "265": (f"265 T {Q} Q358=0 Q359=0 Q360=0 Q254=150", DOWN),
    "265, countersink before": (
        f"265 T {Q} Q358=-0.5 Q359=2 Q360=0 Q254=150",
        f"G1 Z-0.5 F150\n{FRONT.replace('G3', 'G2')}{DOWN}",
    ),
    "265, countersink after": (
        f"265 T {Q} Q358=-0.5 Q359=2 Q360=1 Q254=150",
        f"{DOWN}G1 Z-0.5 F700\n{FRONT.replace('G3', 'G2')}",
    ),
    "267": (f"267 T {Q} Q355=1 Q351=1 Q358=0 Q359=0 Q254=150", STUD),
    "267, countersink": (f"267 T {Q} Q355=1 Q351=1 Q358=-0.5 Q359=9 Q254=150", STUD_FRONT + STUD.split("\n", 1)[1]),
}


def list_rows(moves):
    """Kind, end, feed rate, sweep and centre of what moves."""
    arcs = [(moves.arcs.sweep[arc], *moves.arcs.center[arc][:2]) if arc >= 0 else (0.0, 0.0, 0.0) for arc in moves.arc]
    rows = np.column_stack([moves.kind, moves.end[:, :3], np.nan_to_num(moves.feed), np.array(arcs)])[1:]
    return rows[np.abs(np.diff(moves.end[:, :3], axis=0)).max(axis=1) + np.abs(rows[:, 5]) > 1e-12]


@pytest.mark.parametrize("name", CYCLES)
def test_a_cycle_is_the_path_that_is_written_out(view, name):
    """Ends, feed rates, arcs: within 1e-6 mm, mm/min and degrees."""
    cycle, written = CYCLES[name]
    home = "G0 X10 Y20" if name.startswith("267") else ""
    moves, findings = view(f"{HEAD}CYCL DEF {cycle}\nCYCL CALL\nEND PGM C MM\n", dialect="heidenhain", tools=TOOLS)
    assert findings == ()
    text = f"G21 G90 G64\nT1 M6 G43 H1\nG0 X10 Y20 Z40 S1000 M3\nG0 Z2\n{written}G0 Z2\nG0 Z20\n{home}\nM2\n"
    other, findings = view(text, dialect="rs274", tools=TOOLS)
    assert findings == ()
    rows = [list_rows(table) for table in (moves, other)]
    assert rows[0].shape == rows[1].shape
    assert np.abs(rows[0] - rows[1]).max() < 1e-6


def test_setpoints_are_those_of_the_path_that_is_written_out(machine):
    """The VERNE, to 1e-6 mm and degrees: 264 with its drilling, 265 and 267 with their countersinks, one after the
    other.
    """
    names = ("264, chip breaks", "265, countersink after", "267, countersink")
    klartext = "".join(f"CYCL DEF {CYCLES[name][0]}\nCYCL CALL\n" for name in names)
    written = "".join(f"G0 Z2\n{CYCLES[name][1]}G0 Z2\nG0 Z20\n" for name in names)
    text = f"G21 G90 G61\nT1 M6 G43 H1\nG0 X10 Y20 Z40 S1000 M3\n{written}G0 X10 Y20\nM2\n"
    given = {"tools": {1: make_tool(1, 80.0, 8.0)}, "wcs": {"G54": (0.0, 0.0, 40.0)}, "cycle": 0.01, "smoothing": "off"}
    values = []
    for dialect, program in (("heidenhain", f"{HEAD}{klartext}END PGM C MM\n"), ("rs274", text)):
        result = convert(program.encode(), machine, Options(dialect=dialect, **given))
        assert result.ok, result.findings
        values.append(result.setpoints.values)
    assert values[0].shape == values[1].shape
    assert np.abs(values[0] - values[1]).max() < 1e-6


def follow_wall(moves, axis):
    """Angle about the axis (degrees, going on) and height of places along the arcs about it."""
    for row in range(1, len(moves)):
        arc = moves.arc[row]
        if arc >= 0 and math.dist(moves.arcs.center[arc][:2], axis) < 1e-6:
            begin, end = moves.end[row - 1], moves.end[row]
            first = math.degrees(math.atan2(begin[1] - axis[1], begin[0] - axis[0]))
            for share in (0.0, 0.3, 1.0):
                yield first + share * moves.arcs.sweep[arc], begin[2] + share * (end[2] - begin[2])


@pytest.mark.parametrize("pitch", [2.0, -2.0])
@pytest.mark.parametrize("climb", [1, -1])
@pytest.mark.parametrize("count", [0, 1, 2])
@pytest.mark.parametrize("before", ["", "M4\n", "CYCL DEF 8.0 MIRROR IMAGE\nCYCL DEF 8.1 X\nL X-10 FMAX\n"])
def test_every_way_of_milling_a_stud_cuts_the_same_thread(view, pitch, climb, count, before):
    """Height and angle about the stud go together as the pitch has it; the tool stays outside, and climb milling with
    M3 is clockwise.
    """
    q = Q.replace("Q239=1.5", f"Q239={pitch}").replace("Q201=-6", "Q201=-6.8")
    text = (
        f"{HEAD}{before}CYCL DEF 267 T {q} Q355={count} Q351={climb} Q358=0 Q359=0 Q254=150\nCYCL CALL\nEND PGM C MM\n"
    )
    moves, findings = view(text, dialect="heidenhain", tools=TOOLS)
    assert findings == ()
    is_mirrored = "MIRROR" in before
    axis = moves.end[-1][:2]
    wall = np.array(list(follow_wall(moves, axis)))
    hand = math.copysign(2.0, pitch) * (-1 if is_mirrored else 1)
    turns = wall[:, 1] / hand - (wall[:, 0] - (180 if is_mirrored else 0)) / 360
    start = turns - np.round(turns - turns[0])
    assert np.ptp(start) < 1e-9 or count == 2
    assert wall[:, 1].min() == pytest.approx(-6.8)
    assert wall[:, 1].max() == pytest.approx({0: -4.8, 1: 0, 2: -0.8}[count])
    sweeps = [moves.arcs.sweep[arc] for arc in range(len(moves.arcs.sweep)) if abs(moves.arcs.sweep[arc]) != 180]
    assert {math.copysign(1, sweep) for sweep in sweeps} == {-climb * (-1 if is_mirrored or "M4" in before else 1)}
    # beside the stud, 14 mm from its axis, wherever the tool is below the set-up clearance
    low = [row for row in range(1, len(moves)) if moves.end[row, 2] < 1.9]
    assert min(math.dist(moves.end[row][:2], axis) for row in low) == pytest.approx(14)
    half = [row for row in low if moves.arc[row] >= 0 and abs(moves.arcs.sweep[moves.arc[row]]) == 180]
    assert all(math.dist(moves.arcs.center[moves.arc[row]][:2], axis) == pytest.approx(15) for row in half)


def test_a_left_hand_thread_from_the_surface(view):
    """Downwards too, so counter-clockwise, with the spindle either way."""
    for before in ("", "M4\n"):
        text = (
            f"{HEAD}{before}CYCL DEF 265 T {Q.replace('Q239=1.5', 'Q239=-1.5')} Q358=0 Q359=0 Q360=0 Q254=150\n"
            "CYCL CALL\n"
            "END PGM C MM\n"
        )
        moves, findings = view(text, dialect="heidenhain", tools=TOOLS)
        assert findings == ()
        assert moves.arcs.sweep.tolist() == [180, *[360] * 4, 180]
        assert moves.end[moves.kind == MoveKind.ARC, 2] == pytest.approx([0, -1.5, -3, -4.5, -6, -6])


def test_threads_in_inches(view):
    """All lengths are inches, F is 0.1 inch/min."""
    values = "Q335=0.8 Q239=0.05 Q201=-0.2 Q253=70 Q200=0.1 Q203=0 Q204=1 Q207=50 Q355=1 Q351=1 Q358=0 Q359=0 Q254=15"
    text = (
        f"{HEAD.replace(' MM', ' INCH').replace('X+10 Y+20 Z+40', 'X+1 Y+2 Z+2')}CYCL DEF 267 T {values}\n"
        "CYCL CALL\n"
        "END PGM C INCH\n"
    )
    moves, findings = view(text, dialect="heidenhain", tools=TOOLS)
    assert findings == ()
    radius = 0.4 * 25.4 + 4
    arcs = moves.kind == MoveKind.ARC
    assert moves.end[arcs, 0].min() == pytest.approx(25.4 + radius)
    assert moves.end[arcs, 2].min() == pytest.approx(-0.2 * 25.4 - 0.25 * 1.27 * 1.27 / radius)
    assert moves.feed[arcs][1] == pytest.approx(
        5 * 25.4 * math.hypot(2 * math.pi * radius, 1.27) / math.hypot(0.8 * 25.4 * math.pi, 1.27)
    )


@pytest.mark.parametrize(("number", "words", "code", "part"), [
    (263, {"Q356=0": "Q356=-8"}, "VP002", "Q356"), (263, {"Q359=2": "Q359=0"}, "VP007", "Q359"),
    (263, {"Q358=-0.5": "Q358=1"}, "VP007", "Q358"), (263, {"Q254=150": "Q254=0"}, "VP009", "Q254"),
    (263, {"Q351=1": "Q351=0"}, "VP007", "Q351"), (264, {"Q358=0": "Q358=-1"}, "VP002", "Q358"),
    (264, {"Q356=-10": "Q356=-6.4"}, "VP007", "Q356"), (264, {"Q356=-10": "Q356=5"}, "VP007", "Q356"),
    (264, {"Q202=4": "Q202=0"}, "VP007", "Q202"), (264, {"Q206=150": "Q206=MAX"}, "VP009", "Q206"),
    (265, {"Q360=1": "Q360=2"}, "VP007", "Q360"), (265, {"Q335=20": "Q335=8"}, "VP007", "Q335"),
    (267, {"Q355=1": "Q355=1.5"}, "VP007", "Q355"), (267, {"Q239=1.5": "Q239=0"}, "VP007", "Q239"),
    (267, {"Q359=9": "Q359=15.5"}, "VP007", "Q359"), (267, {"Q239=1.5": "Q239=0.0001"}, "VP007", "turns"),
    (267, {"Q207=500": "Q207=MAX"}, "VP009", "Q207"), (267, {"Q201=-6": "Q201=6"}, "VP007", "Q201"),
])  # fmt: skip
def test_threads_that_cannot_be_milled(view, number, words, code, part):
    name = next(
        name for name in reversed(CYCLES) if name.startswith(str(number)) and "chip" not in name and "alone" not in name
    )
    cycle = CYCLES[name][0]
    for before, after in words.items():
        assert before in cycle
        cycle = cycle.replace(before, after)
    moves, findings = view(f"{HEAD}CYCL DEF {cycle}\nCYCL CALL\nEND PGM C MM\n", dialect="heidenhain", tools=TOOLS)
    assert [(item.code, part in item.message) for item in findings] == [(code, True)], findings
    assert len(moves) <= 1 + (number == 264)  # its pecks are those of 205
