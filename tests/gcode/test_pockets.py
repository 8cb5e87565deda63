"""Milling cycles: depth, wall, reach and rapid traverse by a judge of samples; heights and feeds worked out by hand."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from tests.gcode.pocket_judge import circle, curved_slot, judge, polygon, rectangle
from verne_post.gcode.machining.pockets import Face, Milling, mill_face
from verne_post.model.control_keys import HeidenhainKeys, read_keys
from verne_post.model.moves import MoveKind

HEAD = "BEGIN PGM C MM\nTOOL CALL 1 Z S1000 F300\nL X+10 Y+20 Z+40 R0 FMAX M3\n"
#: What the cases below share, and may replace.
COMMON = {
    215: 1, 368: 0, 207: 500, 351: 1, 201: -6, 202: 3, 369: 0, 206: 150, 338: 0, 200: 2, 203: 0, 204: 50, 370: 1,
    366: 0, 385: 400, 218: 40, 219: 24,
    220: 6, 224: 0, 367: 0, 223: 40, 222: 50, 374: 0, 375: 60, 216: 0, 217: 0, 376: 10, 248: 70, 378: 120, 377: 3,
    424: 50, 425: 30,
    389: 0, 225: 0, 226: 0, 227: 0, 386: -6, 253: 750, 357: 2,
    573: 0, 571: 20, 572: 6,
}  # fmt: skip
TOOL = 8.0


@pytest.fixture(scope="module")
def mill(view):
    """Execute one cycle at X10 Y20 with a tool of 8 mm; (moves, findings)."""
    from verne_post.gcode.klartext.cycle_words import MACHINING

    def run(number, q, head=HEAD, tail=""):
        needs, defaults = MACHINING[number]
        values = {name: {**COMMON, **q}[name] for name in needs} | {
            name: value for name, value in q.items() if name in defaults
        }
        words = " ".join(f"Q{name}={value}" for name, value in values.items())
        text = f"{head}CYCL DEF {number} CYCLE {words}\nCYCL CALL\n{tail}END PGM C MM\n"
        return view(text, dialect="heidenhain", tools={1: make_tool(1, 10.0, TOOL)})

    return run


HERE = (10.0, 20.0)
SQUARE = {215: 0, 368: 0.3, 369: 0.2}
POCKETS = {
    "rectangle": (251, {}, rectangle(40, 24, 6, 0, HERE)),
    "helix, up-cut": (251, {366: 1, 351: -1}, rectangle(40, 24, 6, 0, HERE)),
    "to and fro": (251, {366: 2}, rectangle(40, 24, 6, 0, HERE)),
    "sharp corners": (251, {220: 0}, rectangle(40, 24, 4, 0, HERE)),
    "tall, turned, from a corner": (251, {218: 20, 219: 44, 224: 30, 367: 1, 366: 2},
                                    rectangle(20, 44, 6, 30, (10 + 10 * 3**0.5 / 2 - 11, 20 + 5 + 22 * 3**0.5 / 2))),
    "square": (251, {218: 30, 219: 30, 220: 15, 366: 2}, circle(15, HERE)),
    "with finishing": (251, {**SQUARE, 366: 1}, rectangle(40, 24, 6, 0, HERE)),
    "finishing in steps": (251, {**SQUARE, 338: 1.5}, rectangle(40, 24, 6, 0, HERE)),
    "wide overlap": (251, {370: 1.9, 220: 0}, rectangle(40, 24, 4, 0, HERE)),
    "circle": (252, {366: 1}, circle(20, HERE)),
    "circle with finishing": (252, {**SQUARE, 366: 1}, circle(20, HERE)),
    "slot": (253, {219: 10, 366: 2}, rectangle(40, 10, 5, 0, HERE)),
    "slot of the tool": (253, {219: 8, 374: 90, 366: 1}, rectangle(8, 40, 4, 0, HERE)),
    "slot from its end": (253, {219: 10, 367: 1, **SQUARE}, rectangle(40, 10, 5, 0, (30, 20))),
    "slot from an arc": (253, {219: 10, 367: 3}, rectangle(40, 10, 5, 0, (-5, 20))),
    "curved slot": (254, {377: 1, 219: 10, 366: 2}, curved_slot(30, 10, 70, 10)),
    "curved slot with finishing": (254, {377: 1, 219: 10, **SQUARE, 366: 2}, curved_slot(30, 10, 70, 10)),
    "long curved slot": (254, {377: 1, 219: 12, 248: 300}, curved_slot(30, 10, 300, 12)),
}  # fmt: skip


@pytest.mark.parametrize("name", POCKETS)
def test_pockets_are_milled_whole_and_no_further(mill, name):
    number, q, shape = POCKETS[name]
    moves, findings = mill(number, q)
    assert findings == ()
    judge(moves, 0.5 * TOOL, shape, 0.0, -6.0)


def test_roughing_leaves_its_allowances(mill):
    moves, findings = mill(251, {**SQUARE, 215: 1, 366: 1})
    assert findings == ()
    judge(moves, 0.5 * TOOL, rectangle(40, 24, 6, 0, HERE), 0.0, -6.0, allowance=0.3, floor_allowance=0.2)


STUDS = {
    "rectangle": (256, {}, rectangle(40, 24, 6, 0, HERE), rectangle(50, 30, 0, 0, HERE)),
    "sharp, turned, up-cut": (256, {220: 0, 224: 25, 351: -1}, rectangle(40, 24, 0, 25, HERE),
                              rectangle(50, 30, 0, 25, HERE)),
    "large blank": (256, {424: 80, 425: 60}, rectangle(40, 24, 6, 0, HERE), rectangle(80, 60, 0, 0, HERE)),
    "corner": (256, {367: 3}, rectangle(40, 24, 6, 0, (-10, 8)), rectangle(50, 30, 0, 0, (-10, 8))),
    "with finishing": (256, {**SQUARE, 424: 70}, rectangle(40, 24, 6, 0, HERE), rectangle(70, 30, 0, 0, HERE)),
    "circle": (257, {}, circle(20, HERE), circle(25, HERE)),
    "circle, from an angle, with finishing": (257, {376: 45, 222: 80, **SQUARE}, circle(20, HERE), circle(40, HERE)),
    "hexagon": (258, {222: 60}, polygon(6, 10, 6, 0, HERE), circle(30, HERE)),
    "triangle through its corners, sharp, turned, up-cut": (258, {573: 1, 571: 40, 572: 3, 220: 0, 224: 20, 351: -1},
                                                            polygon(3, 10, 0, 20, HERE), circle(25, HERE)),
    "square, with finishing": (258, {**SQUARE, 571: 20, 572: 4, 220: 2, 224: -30}, polygon(4, 10, 2, -30, HERE),
                               circle(25, HERE)),
    "corners as round as the circle inside": (258, {220: 10}, circle(10, HERE), circle(25, HERE)),
}  # fmt: skip


@pytest.mark.parametrize("name", STUDS)
def test_studs_stand_and_their_blanks_are_gone(mill, name):
    number, q, shape, blank = STUDS[name]
    moves, findings = mill(number, q)
    assert findings == ()
    judge(moves, 0.5 * TOOL, shape, 0.0, -6.0, blank=blank)


@pytest.mark.parametrize("q", [{}, {389: 2, 350: 2, 218: -40}, {219: -24, 370: 1.9, 369: 0.2, 215: 0}])
@pytest.mark.parametrize("number", [232, 233])
def test_faces_are_milled_whole_from_beside_them(mill, number, q):
    q = {name: value for name, value in q.items() if number == 233 or name not in (350, 215)}
    moves, findings = mill(number, {**q, 225: 10, 226: 20})
    assert findings == ()
    sides = q.get(218, 40), q.get(219, 24)
    judge(moves, 0.5 * TOOL, None, 0.0, -6.0, blank=rectangle(40, 24, 0, 0, (10 + 0.5 * sides[0], 20 + 0.5 * sides[1])))


def shown(moves, first=0):
    """Letter, place and feed of each move from a row on: R rapid, L line, A arc."""
    return [
        (
            "RLA"[(MoveKind.RAPID, MoveKind.FEED, MoveKind.ARC).index(kind)],
            *np.round(end[:3], 4) + 0.0,
            0 if kind == MoveKind.RAPID else feed,
        )
        for kind, end, feed in list(zip(moves.kind, moves.end, moves.feed, strict=True))[first:]
    ]


def test_a_slot_worked_out_by_hand(mill):
    """40 x 10, tool 8: paths 0 and 1 mm beside the middle line; two infeeds of 3, finishing of 0.25 a side and 0.5 in
    depth.
    """
    moves, findings = mill(253, {219: 10, 215: 0, 368: 0.25, 369: 0.5, 367: 2, 201: -6.5, 385: 400})
    assert findings == ()
    x = [25 + value for value in (-15, 15, -15.75, 15.75)]  # ends of the middle line, of the path before the allowance
    rough = [
        ("L", x[1], 20, 500),
        ("L", x[0], 20, 500),
        ("L", 25, 20, 500),
        ("L", 25, 19.25, 500),
        ("L", x[1], 19.25, 500),
        ("A", x[1], 20.75, 500),
        ("L", x[0], 20.75, 500),
        ("A", x[0], 19.25, 500),
        ("L", 25, 19.25, 500),
    ]
    fine = [("L", x[1], 19, 400), ("A", x[1], 21, 400), ("L", x[0], 21, 400), ("A", x[0], 19, 400), ("L", 25, 19, 400)]

    def at(z, *strokes):
        return [(kind, a, b, z, feed) for kind, a, b, feed in strokes]

    assert shown(moves, 1) == [
        ("R", 25, 20, 40, 0),
        ("R", 25, 20, 2, 0),
        ("L", 25, 20, -3, 150),
        *at(-3, *rough),
        ("R", 25, 19.25, -1, 0),
        ("R", 25, 20, -1, 0),
        ("L", 25, 20, -6, 150),
        *at(-6, *rough),
        ("R", 25, 19.25, -4, 0),
        ("R", 25, 20, -4, 0),
        ("R", 25, 20, 2, 0),
        # along the wall, from and to quarter circles of 1 mm
        ("R", 24, 20, 2, 0),
        ("L", 24, 20, -6.5, 150),
        ("A", 25, 19, -6.5, 400),
        *at(-6.5, *fine),
        ("A", 26, 20, -6.5, 400),
        ("R", 26, 20, -4.5, 0),
        ("R", 26, 20, 2, 0),
        # the floor
        ("R", 25, 20, 2, 0),
        ("R", 25, 20, -4, 0),
        ("L", 25, 20, -6.5, 150),
        *at(-6.5, *[(kind, a, b, 400) for kind, a, b, _feed in rough[:3]]),
        ("L", 25, 19, -6.5, 400),
        *at(-6.5, *fine),
        ("R", 25, 19, 2, 0),
        ("R", 25, 20, 2, 0),
        ("R", 25, 20, 50, 0),
        ("R", 10, 20, 50, 0),
    ]


def test_a_hexagon_is_the_path_that_is_written_out(mill, view):
    """The values are those of docs/heidenhain.md: 20 mm across the flats, corners of 2 mm, clockwise from the side at
    -30 degrees.
    """
    cycle, findings = mill(258, {222: 26, 202: 6, 220: 2, 224: 0})
    assert findings == ()
    turn = [(math.cos(math.radians(a)), math.sin(math.radians(a))) for a in range(-30, 331, 60)]

    def place(side, along, out):
        """Along the side (counter-clockwise) that is at -30 + 60 side degrees, and out from the middle."""
        c, s = turn[side % 6]
        return f"X{10 + out * c - along * s:.10f} Y{20 + out * s + along * c:.10f}"

    half = 8 * math.tan(math.radians(30))
    written = ["G0 " + place(0, 5, 19), "G0 Z2", "G1 Z-6 F150", f"G3 {place(0, 0, 14)} R5 F500"]
    for side in (0, -1, -2, -3, -4, -5):
        written += [f"G1 {place(side, -half, 14)}", f"G2 {place(side - 1, half, 14)} R6"]
    written += [f"G1 {place(0, 0, 14)}", f"G3 {place(0, -5, 19)} R5", "G0 Z2", "G0 Z50", "G0 X10 Y20"]
    text = "\n".join(["G21 G90 G64", "T1 M6 G43 H1", "G0 X10 Y20 Z40 S1000 M3", *written, "M2"])
    moves, findings = view(text, dialect="rs274", tools={1: make_tool(1, 10.0, TOOL)})
    assert findings == ()
    rows = [
        table.end[1:][np.abs(np.diff(table.end[:, :3], axis=0)).max(axis=1) > 1e-9][:, :3] for table in (cycle, moves)
    ]
    assert rows[0].shape == rows[1].shape == (len(written), 3)
    assert np.abs(rows[0] - rows[1]).max() < 1e-6
    assert np.abs(cycle.arcs.center - moves.arcs.center)[:, :2].max() < 1e-6
    assert cycle.arcs.sweep == pytest.approx(moves.arcs.sweep, abs=1e-6)


def test_strokes_of_a_face_are_even(mill):
    """25 wide, overlap 8: four strokes, each taking 6.25; the tool's edge ends them at 6.25, 12.5, 18.75 and 25."""
    moves, findings = mill(233, {218: -30, 219: 25, 370: 2 * 0.999, 202: 4, 386: -6, 389: 0})
    assert findings == ()
    right, left, rows = 16, -26, [22.25, 28.5, 34.75, 41]
    way = [
        (right, rows[0]),
        (left, rows[0]),
        (left, rows[1]),
        (right, rows[1]),
        (right, rows[2]),
        (left, rows[2]),
        (left, rows[3]),
        (right, rows[3]),
    ]
    lines = [place for kind, *place, _feed in shown(moves, 1) if kind == "L"]
    assert lines == [[*place, z] for z in (-3, -6) for place in way]


@pytest.mark.parametrize("zigzag", [True, False])
def test_a_face_is_left_between_strokes_only_where_all_go_one_way(zigzag):
    """Four strokes on each of two levels: to and fro the tool stays down, else it goes back above the face."""
    milling = Milling(radius=4.0, clear=2.0, levels=(-1.0, -2.0), bottom=-2.0, step=6.0)
    strokes = list(mill_face(Face(30.0, 24.0, 5.0, zigzag), milling))
    rows = [6.0 * number - 4.0 for number in range(1, 5)]
    for level in milling.levels:
        downs = [one.end for one in strokes if one.pace == "plunge" and one.height == level]
        assert downs == [(-5.0, across) for across in (rows[:1] if zigzag else rows)]
        ends = [one.end for one in strokes if one.pace == "mill" and one.height == level]
        ways = [(-5.0, 35.0) if not zigzag or number % 2 == 0 else (35.0, -5.0) for number in range(4)]
        assert ends == [(u, across) for way, across in zip(ways, rows, strict=True) for u in way]
    # above the face it goes sideways where it has come up, and straight to where it goes down
    rapids = [one.end for one in strokes if one.pace == "rapid"]
    last = (-5.0 if zigzag else 35.0, rows[-1])
    back = (
        [] if zigzag else [place for number in range(3) for place in ((35.0, rows[number]), (-5.0, rows[number + 1]))]
    )
    assert rapids == 2 * [(-5.0, rows[0]), *back, last]
    assert {one.height for one in strokes if one.pace == "rapid"} == {2.0}


def test_a_helix_goes_down_to_its_level(mill):
    """Half turns, equally high, the last one at the infeed."""
    moves, findings = mill(251, {366: 1})
    assert findings == ()
    heights = [float(end[2]) for kind, end in zip(moves.kind, moves.end, strict=True) if kind == MoveKind.ARC]
    falls = -np.diff([0.0, *heights])
    turns = [fall for fall in falls if fall > 1e-6]
    assert min(heights[: heights.index(-3.0) + 1]) == -3.0
    assert np.ptp(turns[: len(turns) // 2]) < 0.3 * max(turns)


def test_single_lip_drilling(mill):
    moves, findings = mill(241, {201: -30, 379: 10, 253: 700, 427: 60, 428: 1200, 426: 4, 211: 0, 208: 900})
    assert findings == ()
    assert [(kind, z, feed) for kind, _x, _y, z, feed in shown(moves, 1)] == [
        ("R", 2, 0),
        ("L", -8, 700),
        ("L", -30, 150),
        ("L", 2, 900),
        ("R", 50, 0),
    ]
    events = [
        (event.kind, event.data.get("direction"), event.data.get("speed"), event.data.get("state"))
        for event in moves.events
    ][2:-1]
    assert events == [
        ("spindle", "counterclockwise", 60, None),
        ("spindle", "clockwise", 1200, None),
        ("coolant", None, None, "flood"),
        ("coolant", None, None, "off"),
        ("spindle", "counterclockwise", 60, None),
    ]


@pytest.mark.parametrize(("number", "q", "code", "part"), [
    (251, {219: 7, 220: 0}, "VP007", "no room"), (251, {368: 9}, "VP007", "allowance"),
    (251, {220: 13}, "VP007", "corner"), (251, {215: 2}, "VP007", "Q215=2"),
    (251, {370: 2}, "VP007", "Q370"), (251, {202: 0}, "VP007", "Q202"), (251, {202: 0.0001}, "VP007", "strokes"),
    (251, {207: 0}, "VP009", "Q207"),
    (251, {207: "MAX"}, "VP009", "Q207"), (251, {206: "MAX", 366: 1}, "VP009", "arcs"),
    (251, {366: 3}, "VP007", "Q366"), (251, {351: 2}, "VP007", "Q351"),
    (251, {219: 8, 220: 0, 366: 1}, "VP007", "helix"), (252, {366: 2}, "VP007", "Q366"),
    (252, {223: 0}, "VP007", "Q223"), (253, {219: 17}, "VP007", "two diameters"),
    (253, {218: 9, 219: 10}, "VP007", "long"), (254, {248: 360}, "VP007", "ends of the slot"),
    (254, {375: 9, 219: 10}, "VP007", "on a circle"), (254, {377: 1.5}, "VP007", "Q377"),
    (256, {424: 30}, "VP007", "blank"), (257, {222: 30}, "VP007", "blank"), (256, {220: -2}, "VP007", "Q220"),
    (258, {220: -2}, "VP002", "Q220"),
    (258, {572: 2}, "VP007", "Q572"), (258, {572: 31}, "VP007", "Q572"), (258, {572: 4.5}, "VP007", "Q572"),
    (258, {573: 2}, "VP007", "Q573"), (258, {571: 0}, "VP007", "Q571"),
    (258, {571: 51}, "VP007", "Q222"), (258, {220: 11}, "VP007", "circle inside"), (233, {386: 1}, "VP007", "Q386"),
    (233, {218: 0}, "VP007", "Q218"),
    (251, {201: 5}, "VP007", "Q201"), (241, {426: 6}, "VP007", "Q426"), (241, {435: -9}, "VP002", "Q435"),
    (241, {202: 5}, "VP002", "Q202"),
])  # fmt: skip
def test_mistakes_are_refused_before_the_first_move(mill, number, q, code, part):
    moves, findings = mill(number, q)
    assert [item.code for item in findings] == [code]
    assert part in findings[0].message
    assert len(moves) <= 1 + (number == 241)


def test_plunge_angle(view):
    text = (
        f"{HEAD}CYCL DEF 252 P Q215=1 Q223=40 Q368=0 Q207=500 Q351=1 Q201=-6 Q202=3 Q369=0 Q206=150 Q338=0 Q200=2 "
        "Q203=0 Q204=9 Q370=1 Q366=1\n"
        "CYCL CALL\n"
        "END PGM C MM"
    )
    counts = []
    for keys in ({}, {"plunge_angle": 3.0}, {"plunge_angle": 1}):
        moves, findings = view(
            text, dialect="heidenhain", tools={1: make_tool(1, 10.0, TOOL)}, control={"heidenhain": keys}
        )
        assert findings == ()
        counts.append(len(moves))
    assert counts[0] == counts[1] < counts[2]
    with pytest.raises(ValueError, match="degrees"):
        read_keys(HeidenhainKeys, {"plunge_angle": 90})


PAGE = Path(__file__).resolve().parents[2] / "docs" / "heidenhain.md"
#: Another value of a parameter, where that is not a little more than the one above; and parameters that only act beside
#: others.
OTHER = {
    202: 2,
    370: 0.8,
    215: 1,
    220: 0,
    351: -1,
    366: 2,
    367: 2,
    389: 2,
    350: 2,
    377: 2,
    218: 44,
    219: 20,
    223: 36,
    338: 1.5,
    376: 40,
    572: 5,
}
#: Parameters of these cycles that are refused with any other value.
UNUSED = {(233, 220), (233, 338), (233, 367), (233, 368), (254, 367)}
BESIDE = {385: SQUARE, 338: SQUARE, 369: {215: 0}, 368: {215: 0}, 215: SQUARE, 216: {367: 0}}


def rows():
    """Parameters of the table of the page, each with its kind."""
    table = PAGE.read_text(encoding="utf-8").split("| parameter | kind | does |\n|---|---|---|\n")[1].split("\n\n")[0]
    found = []
    for line in table.splitlines():
        names, kind, _does = (cell.strip() for cell in line.strip("|").split("|"))
        found += [(int(name), float(value or 0), kind) for name, value in re.findall(r"Q(\d+)(?:=(\d))?", names)]
    return found


@pytest.mark.parametrize(("name", "value", "kind"), rows())
def test_every_parameter_does_what_the_page_says(mill, name, value, kind):
    from verne_post.gcode.klartext.cycle_words import MACHINING
    from verne_post.gcode.klartext.milling import CYCLES

    having = [number for number in CYCLES if name in {*MACHINING[number][0], *MACHINING[number][1]}]
    assert having
    for number in having:
        before = {**BESIDE.get(name, {}), **({219: 10} if number in (253, 254) else {368: 0} if number == 233 else {})}
        if kind == "refused":
            found = mill(number, {**before, name: value})[1]
            if name != 367 or number == 254:
                assert [(item.code, f"Q{name}={value:g}" in item.message) for item in found] == [("VP002", True)]
            continue
        if (number, name) in UNUSED:
            continue
        other = (
            1
            if (number, name) == (252, 366)
            else 9
            if number in (253, 254) and name == 219
            else OTHER.get(name, COMMON.get(name, 0) + 1)
        )
        one, other_moves = (mill(number, {**before, **more}) for more in ({}, {name: other}))
        assert (one[1], other_moves[1]) == ((), ()), number
        shown = [
            [table.end.tolist(), np.nan_to_num(table.feed).tolist(), table.arcs.sweep.tolist()]
            for table, _findings in (one, other_moves)
        ]
        assert shown[0] != shown[1], number


def test_the_page_names_every_parameter():
    from verne_post.gcode.klartext.cycle_words import MACHINING
    from verne_post.gcode.klartext.milling import CYCLES

    assert {name for number in CYCLES for name in (*MACHINING[number][0], *MACHINING[number][1])} == {
        name for name, *_rest in rows()
    }


# --- circles of Haas controls ---------------------------------------------------------------------------

HAAS = "%\nO1\nG21 G90 G17 G54\nT1 M6\nG43 H1 G0 X10. Y20. Z2.\nS1000 M3 F500.\n"


def run_haas(view, text):
    return view(f"{HAAS}{text}\nM30\n%\n", dialect="fanuc", tools={1: make_tool(1, 10.0, TOOL)})


@pytest.mark.parametrize("turn", ["G12", "G13"])
def test_circles_of_haas_mill_a_pocket_whole_and_no_further(view, turn):
    """Circles of the tool's centre at 2, 5, 8 ... 16 mm: with 8 mm of tool all of the circle of 20 mm, on two levels,
    back in the middle.
    """
    moves, findings = run_haas(view, f"G91 {turn} I6. K20. Q3. D1 Z-4. L2\nG90 G0 Z50.")
    assert findings == ()
    judge(moves, 0.5 * TOOL, circle(20, HERE), 2.0, -6.0)
    sweep = moves.arcs.sweep
    assert (sweep * (1 if turn == "G13" else -1) > 0).all()
    last = moves.end[:, :3][moves.kind == MoveKind.ARC][-1]
    np.testing.assert_allclose(last, (*HERE, -6.0), atol=1e-9)


def test_a_circle_of_haas_worked_out_by_hand(view):
    """I10 with a tool of 4 mm radius: down, half circle to the wall of 6 mm, round in two halves, half circle back;
    exactly those moves.
    """
    moves, _ = run_haas(view, "G13 I10. D1 Z-1. F300")
    rows = [(*end[:3].round(9), feed) for end, feed in zip(moves.end, moves.feed, strict=True)]
    assert rows[1:] == [(10, 20, -1, 300), (10, 14, -1, 300), (10, 26, -1, 300), (10, 14, -1, 300), (10, 20, -1, 300)]
    np.testing.assert_allclose(moves.arcs.center[:, :2], [(10, 17), HERE, HERE, (10, 17)], atol=1e-12)
    assert moves.arcs.sweep.tolist() == [180.0] * 4


@pytest.mark.parametrize("mode", ["G90", "G91", "G20"])
def test_holes_on_a_circle_and_in_a_row_of_haas(view, mode):
    """Five at 15 + 72 k degrees about X10 Y20, three 20 degrees apart, and four in a row at 30 degrees: the same as
    holes written out in G81.
    """
    given = {"G90": ("X10. Y20.", "8.", ""), "G91": ("", "8.", "G91"), "G20": ("", f"{8 / 25.4:.12f}", "")}[mode]
    unit = 25.4 if mode == "G20" else 1.0
    begin = f"{mode.replace('91', '90')} G99 G81 Z{-4 / unit:.12f} R{1 / unit:.12f} L0 F90\n"
    circle_of_holes = run_haas(view, f"{begin}{given[2]}\nG70 {given[0]} I{given[1]} J15. L5\nG80 G21 G90")[0]
    arc_of_holes = run_haas(view, f"{begin}{given[2]}\nG71 {given[0]} I{given[1]} J15. K-20. L3\nG80 G21 G90")[0]
    row = run_haas(view, f"{begin}{given[2]}\nG72 {given[0]} I{given[1]} J30. L4\nG80 G21 G90")[0]
    away, angle = 8.0 * np.arange(4), np.radians(30)
    bottoms = row.end[np.abs(row.end[:, 2] + 4) < 1e-9, :2]
    expected = np.column_stack([10 + away * np.cos(angle), 20 + away * np.sin(angle)])
    np.testing.assert_allclose(bottoms, expected, atol=1e-9)
    for moves, angles in ((circle_of_holes, 15 + 72 * np.arange(5)), (arc_of_holes, 15 - 20 * np.arange(3))):
        bottoms = moves.end[np.abs(moves.end[:, 2] + 4) < 1e-9, :2]
        angles = np.radians(angles)
        np.testing.assert_allclose(
            bottoms, np.column_stack([10 + 8 * np.cos(angles), 20 + 8 * np.sin(angles)]), atol=1e-9
        )


@pytest.mark.parametrize(("text", "code", "part"), [
    ("G13 I3. D1", "VP007", "does not fit"), ("G13 I9.", "VP005", "needs D"), ("G12 D1", "VP005", "needs I"),
    ("G13 I9. K12. D1", "VP005", "together"), ("G13 I9. K7. Q1. D1", "VP007", "K7"),
    ("G13 I9. D1 L2", "VP007", "G91"), ("G13 I9. X1. D1", "VP006", "X"), ("G18 G13 I9. D1", "VP017", "G17"),
    ("G13 I6. K20. Q0.0001 D1", "VP007", "more than"), ("G41 D1 G1 X40.\nG13 I9. D1", "VP017", "compensation"),
    ("G13 Z-1.", "VP005", "needs I"), ("G70 I8. L5", "VP005", "L0"), ("G81 Z-4. R1. L0\nG70 I8.", "VP005", "needs L"),
    ("G81 Z-4. R1. L0\nG71 I8. L3", "VP005", "needs K"), ("G81 Z-4. R1. L0\nG70 I-8. L3", "VP007", "I-8"),
    ("G81 Z-4. R1. L0\nG70 I8. L99999", "VP007", "holes"), ("G81 Z-4. R1. L0\nG72 J30. L3", "VP005", "distance"),
    ("G72 I8. J30. L3", "VP005", "L0"), ("G51 X0 Y0 Z0 P2.\nG81 Z-4. R1. L0\nG70 I8. L3", "VP017", "G5"),
])  # fmt: skip
def test_what_circles_of_haas_need(view, text, code, part):
    findings = run_haas(view, text)[1]
    assert findings
    assert findings[0].code == code, findings
    assert part in findings[0].message
