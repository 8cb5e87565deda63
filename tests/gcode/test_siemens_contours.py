"""CYCLE62 and CYCLE72: moves worked out by hand, the same contour written out under G41, and what is refused."""

import math
from pathlib import Path

import numpy as np
import pytest

from tests.builders import read_values
from tests.gcode.conftest import make_tool
from tests.gcode.pocket_judge import rectangle, sample_path
from verne_post.gcode.siemens.contour_milling import PARAMETERS
from verne_post.model.moves import MoveKind

TOOL, RADIUS = 8.0, 4.0
HEAD = "N10 G17 G90 G54 G71 G94\nN20 T1 D1 M6\nN30 S3000 M3\nN40 G0 X-30 Y-30 Z60 A0 C0\n"
#: A plate of 40 x 30, clockwise from its corner: outside is to its left.
PLATE = "EDGE: G0 X0 Y0\nG1 Y30\nX40\nY0\nEND: X0\n"
VALUES = {
    "KNAME": '"EDGE:END"', "RTP": 50, "RFP": 0, "SDIS": 2, "DP": -6, "MID": 3, "FAL": 0, "FALD": 0, "FFP1": 500,
    "FFD": 150, "VARI": 1, "RL": 41, "AS1": 1, "LP1": 5,
    "FF3": 1000,
}  # fmt: skip


def write(**values):
    values = {**VALUES, **values}
    return f"CYCLE72({','.join(str(values.get(name, '')) for name in PARAMETERS['CYCLE72'])})"


@pytest.fixture(scope="module")
def mill(view):
    """Execute calls with a contour after the end of the program; (moves, findings)."""

    def run(text, contour=PLATE, head=HEAD, **options):
        text = f"{head}{text}\nM30\n{contour}"
        return view(text, dialect="siemens", tools={1: make_tool(1, 10.0, TOOL)}, **options)

    return run


def rows_of(moves):
    """Kind, X, Y, Z, feed rate (0: rapid), centre and sweep of each move from the fifth line on."""
    found = []
    for kind, end, feed, arc in zip(moves.kind, moves.end, moves.feed, moves.arc, strict=True):
        round_one = (
            (*moves.arcs.center[arc][:2].round(6), round(float(moves.arcs.sweep[arc]), 6)) if arc >= 0 else (0, 0, 0)
        )
        letter = "RLA"[(MoveKind.RAPID, MoveKind.FEED, MoveKind.ARC).index(kind)]
        found.append(
            (
                letter,
                *(float(v) for v in np.round(end[:3], 6) + 0.0),
                float(np.nan_to_num(feed)),
                *map(float, round_one),
            )
        )
    return found[1:]


def line(letter, x, y, z, feed=0.0, u=0.0, v=0.0, sweep=0.0):
    return (letter, float(x), float(y), float(z), float(feed), float(u), float(v), float(sweep))


def test_a_plate_worked_out_by_hand(mill):
    """Roughing with 0.5 and 0.25 to spare, 5.75 deep in two levels of 2.875; a quarter circle of 5 to the edge and
    away.
    """
    moves, findings = mill(write(FAL=0.5, FALD=0.25, AS1=2))
    assert findings == ()
    off, expected = RADIUS + 0.5, []
    for number, z in enumerate((-2.875, -5.75)):
        begin = -off - 5
        expected += [
            line("R", begin, -5, 50 if number else 60),
            line("R", begin, -5, -0.875 if number else 2),
            line("L", begin, -5, z, 150),
            line("A", -off, 0, z, 500, begin, 0, 90),
            line("L", -off, 30, z, 500),
            line("A", 0, 30 + off, z, 500, 0, 30, -90),
            line("L", 40, 30 + off, z, 500),
            line("A", 40 + off, 30, z, 500, 40, 30, -90),
            line("L", 40 + off, 0, z, 500),
            line("A", 40, -off, z, 500, 40, 0, -90),
            line("L", 0, -off, z, 500),
            line("A", -5, -off - 5, z, 500, 0, -off - 5, 90),
            line("R", -5, -off - 5, 50),
        ]
    assert rows_of(moves) == expected


@pytest.mark.parametrize(("values", "ends"), [
    # a straight line: the edge of the tool comes from 5 before the corner, so its middle from 5 + 4; right of it inside
    ({"AS1": 1}, ((-4, -9), (-9, -4))), ({"AS1": 1, "RL": 42}, ((4, -9), (-9, 4))),
    # on the contour lengths are those of the middle
    ({"RL": 40}, ((0, -5), (-5, 0))),
    ({"AS1": 2}, ((-9, -5), (-5, -9))), ({"AS1": 3}, ((-14, 0), (0, -14))), ({"AS1": 3, "RL": 42}, ((14, 0), (0, 14))),
    ({"AS1": 2, "AS2": 1, "LP2": 7}, ((-9, -5), (-11, -4))), ({"AS1": 1, "AS2": 3, "LP2": 7}, ((-4, -9), (0, -18))),
])  # fmt: skip
def test_where_the_tool_comes_to_the_contour_and_leaves_it(mill, values, ends):
    moves, findings = mill(write(MID=0, **values))
    assert findings == ()
    rows = rows_of(moves)
    down, up = next(row for row in rows if row[4] == 150), rows[-2]
    assert (down[1:4], up[1:3], up[3]) == ((*ends[0], -6), ends[1], -6)


@pytest.mark.parametrize(("kind", "way"), [
    # between the levels at -3 and -6, from where the tool leaves the contour (-5, -9) to where it comes to it (-9, -5)
    (1, [("R", -5, -9, 50, 0), ("R", -9, -5, 50, 0), ("R", -9, -5, -1, 0)]),
    (101, [("R", -5, -9, 2, 0), ("R", -9, -5, 2, 0), ("R", -9, -5, -1, 0)]),
    (201, [("R", -5, -9, -1, 0), ("R", -9, -5, -1, 0)]), (301, [("R", -9, -5, -3, 0)]),
    (11, [("L", -5, -9, 50, 1000), ("L", -9, -5, 50, 1000), ("L", -9, -5, -1, 1000)]), (311, [("L", -9, -5, -3, 1000)]),
])  # fmt: skip
def test_ways_between_levels(mill, kind, way):
    moves, findings = mill(write(VARI=kind, AS1=2))
    assert findings == ()
    rows = [row[:5] for row in rows_of(moves)]
    first = rows.index(("A", -5, -9, -3, 500)) + 1
    assert rows[first : first + len(way) + 1] == [*way, ("L", -9, -5, -6, 150)]
    assert rows[-1][3] == 50


CONTOUR = """%_N_KNOB_SPF
PROC KNOB
DEF REAL WIDE
WIDE=40
G90 G1 X=R1 Y0
X=R1+WIDE RND=5
G3 Y20 CR=10
G1 X=R1 CHR=6 F250
Y0
M17
"""


def test_the_contour_is_that_of_g41_with_its_corners_feeds_and_variables(mill, view):
    """A subprogram in inches of the same file with RND, CHR, F, R parameters: the moves at the depth are those of G41
    written out.
    """
    for start, turn, side in (
        ("", "", "G42"),
        ("MIRROR X0\n", "", "G42"),
        ("", "ROT RPL=30\n", "G42"),
        ("", "", "G41"),
    ):
        begin = f"{HEAD}R1=60\n{start}{turn}"
        moves, findings = mill(f"{write(KNAME=chr(34) + 'KNOB' + chr(34), MID=0, RL=side[1:], LP1=6)}", CONTOUR, begin)
        assert findings == ()
        written = (
            f"G0 X50 Y{-4 if side == 'G42' else 4}\n"
            "G1 Z-6 F500\n"
            f"{side} G1 X60 Y0\n"
            "X100 RND=5\n"
            "G3 Y20 CR=10\n"
            "G1 X60 CHR=6 F250\n"
            "Y0\n"
            "G40 Y-9"
        )
        other, findings = view(f"{begin}{written}\nM30", dialect="siemens", tools={1: make_tool(1, 10.0, TOOL)})
        assert findings == ()
        one, two = ([row for row in rows_of(table) if row[3] == -6 and row[0] != "R"] for table in (moves, other))
        one, two = one[2:-1], two[2:-1]  # without plunge, way to the contour, way from it
        assert len(one) >= 5
        assert [row[0] for row in one] == [row[0] for row in two]
        assert np.abs(np.array([row[1:] for row in one]) - np.array([row[1:] for row in two])).max() < 2e-6


def test_levels_leave_the_plate_alone_and_reach_it(mill):
    """Every level keeps the radius and the allowance from the plate; the depth is reached."""
    moves, findings = mill(write(FAL=0.5, MID=2.5, AS1=3))
    assert findings == ()
    shape = rectangle(40, 30, 0, 0, (20, 15))
    places = np.concatenate([part for _rapid, part in sample_path(moves)])
    deep = places[places[:, 2] < -1e-9]
    assert abs(shape(deep[:, :2]).min() - RADIUS - 0.5) < 1e-6
    assert sorted({round(float(z), 6) for z in moves.end[:, 2] if z < 0}) == [-6, -4, -2]


EDITOR = "E_LAB_A_RIM: ;#SM Z:2\nG17 G90 DIAMOF;*GP*\nG0 X0 Y0 ;*GP*\nG1 Y30\nX40\nY0\nX0\nE_LAB_E_RIM:\n"


@pytest.mark.parametrize(
    ("before", "contour"),
    [
        ('CYCLE62("EDGE",0,,)', "%_N_EDGE_SPF\nG0 X0 Y0\nG1 Y30\nX40\nY0\nX0\nRET\n"),
        ('CYCLE62("RIM",1,,)', EDITOR),
        ('CYCLE62("",2,"EDGE","END")', PLATE),
        ('CYCLE62("PARTS",3,"EDGE","END")', f"%_N_PARTS_SPF\n{PLATE}M17\n"),
        # named once for several cycles; a later one takes the place of it
        (f'CYCLE62("",2,"EDGE","END")\n{write(KNAME=chr(34) * 2)}\nCYCLE62("",2,"EDGE","END")', PLATE),
    ],
)
def test_contours_that_cycle62_names(mill, before, contour):
    """The tail of newer controls: the plane, the feed mode, the contour of CYCLE62, and a depth that counts from the
    reference plane.
    """
    tail = {"_UMODE": 0, "FS": 1, "ZFS": 2, "_GMODE": 101, "_DMODE": 1011, "_AMODE": 101, "DP": 6}
    moves, findings = mill(f"{before}\n{write(KNAME=chr(34) * 2, **tail)}", contour)
    assert findings == ()
    plain, _ = mill(write())
    rows = rows_of(plain)
    assert rows_of(moves)[-len(rows) + 2 :] == rows[2:]  # without the way to the first place


def test_a_contour_of_another_file(view):
    tools = {1: make_tool(1, 10.0, TOOL)}
    call = write(KNAME='"/_N_WKS_DIR/_N_P_WPD/_N_RIM_SPF"')
    good, bad = (
        view(f"{HEAD}{call}\nM30", dialect="siemens", tools=tools, subroutines={"rim": text})
        for text in (b"G0 X0 Y0\nG1 Y30\nX40\nY0\nX0\nM17\n", b"G0 X0 Y0\nG1 Y30\nX40 Z3\nX0\nM17\n")
    )
    assert good[1] == ()
    assert set(good[0].line[2:].tolist()) == {5}
    assert [(item.code, item.line, "rim.spf, line 3" in item.full_message) for item in bad[1]] == [("VP017", 5, True)]


@pytest.mark.parametrize(("values", "code", "part"), [
    ({"VARI": 5}, "VP002", "VARI"), ({"VARI": 21}, "VP002", "VARI"), ({"VARI": 401}, "VP002", "VARI"),
    ({"RL": 43}, "VP002", "RL"), ({"AS1": 12}, "VP002", "AS1"),
    ({"AS1": 4}, "VP002", "AS1"), ({"AS1": 2, "RL": 40}, "VP002", "AS1"), ({"LP1": 0}, "VP007", "LP1"),
    ({"AS2": 2}, "VP007", "LP2"), ({"FALD": 6}, "VP007", "FALD"),
    ({"MID": 0.0001}, "VP007", "strokes"), ({"MID": -1}, "VP007", "MID"), ({"FF3": -1}, "VP009", "FF3"),
    ({"DP": 6}, "VP007", "bottom"), ({"KNAME": '"RIM"'}, "VP023", "RIM"),
    ({"KNAME": '"EDGE:NOWHERE"'}, "VP023", "NOWHERE"), ({"KNAME": '"END:EDGE"'}, "VP023", "before it begins"),
    ({"KNAME": '""'}, "VP005", "KNAME"), ({"KNAME": '"/"'}, "VP005", "KNAME"), ({"_GMODE": 3}, "VP002", "_GMODE"),
    ({"_DMODE": 2}, "VP002", "_DMODE"), ({"_AMODE": 3}, "VP002", "_AMODE"),
])  # fmt: skip
def test_values_that_are_refused_before_the_first_move(mill, values, code, part):
    moves, findings = mill(write(**values))
    assert [(item.code, item.line) for item in findings] == [(code, 5)]
    assert part in findings[0].message
    assert len(moves) == 1


@pytest.mark.parametrize(("contour", "line", "part"), [
    ("EDGE: G1 X0\nEND: Y30", 7, "names X and Y"), ("EDGE: G2 X0 Y0 CR=90\nEND: Y30", 7, "needs the position"),
    ("EDGE: G0 X0 Y0\nG0 Y30\nEND: X40", 9, "G0"), ("EDGE: G0 X0 Y0\nEND: M8", 8, "more"),
    ("EDGE: G0 X0 Y0\nEND:", 7, "at least one"), ("EDGE: G0 X0 Y0\nG1 Y30 Z-1\nEND: X40", 8, "Z"),
    ("EDGE: G0 X0 Y0\nTRANS X5\nG1 Y30\nEND: X40", 10, "frames"),
    ("EDGE: G0 X0 Y0\nG1 G41 Y30\nEND: X40", 8, "G41"),
    ("EDGE: G0 X0 Y0\nG1 Y30\nM30\nEND: X40", 10, "end the program"), ("EDGE: G0 X0 Y0\nG1 C30\nEND: X40", 8, "TRAORI"),
    ("EDGE: G0 X0 Y0\nG1 Y30 Q3\nEND: X40", 8, "Q"),
])  # fmt: skip
def test_contours_that_are_refused(mill, contour, line, part):
    moves, findings = mill(write(), contour)
    assert findings[0].line == line, findings
    assert part in findings[0].message
    assert len(moves) == 1


def test_a_corner_that_the_tool_cannot_reach_is_refused_at_its_line(mill):
    """A notch of 6 mm between two lines, and a tool of 8 mm."""
    findings = mill(write(RL=42, AS1=1), "EDGE: G0 X0 Y0\nG1 Y30\nX6\nEND: Y0\n")[1]
    assert [(item.code, item.line) for item in findings] == [("VP026", 10)]


def test_what_the_cycle_needs_before(view):
    tools = {1: make_tool(1, 10.0, TOOL)}
    for head, code in (
        (HEAD.replace("T1 D1 M6", ""), "VP012"),
        (f"{HEAD}G93\n", "VP017"),
        (f"{HEAD}SCALE X2\n", "VP017"),
        (f"{HEAD}G18\n", "VP017"),
        (f"{HEAD}G41 X0 Y0 G1 F9\n", "VP017"),
    ):
        found = view(f"{head}{write()}\nM30\n{PLATE}", dialect="siemens", tools=tools)[1]
        assert [item.code for item in found][:1] == [code], head
    found = view(f"{HEAD}MCALL {write()}\nM30\n{PLATE}", dialect="siemens", tools=tools)[1]
    assert [item.code for item in found] == ["VP002"]


def test_a_contour_that_mills_along_itself_is_refused(mill):
    call = write(KNAME='"SELF"')
    found = mill(call, f"%_N_SELF_SPF\nG0 X0 Y0\n{call}\nG1 Y30\nM17\n")[1]
    assert [(item.code, item.line) for item in found] == [("VP017", 9)]


def test_loops_in_contours_have_an_end(mill):
    findings = mill(write(), "EDGE: G0 X0 Y0\nLOOP\nG1 Y30\nX40\nENDLOOP\nEND: X0\n", max_repeats=2_000)[1]
    assert [item.code for item in findings] == ["VP024"]


# --- the page ---------------------------------------------------------------------------------------------

PAGE = Path(__file__).parents[2] / "docs" / "siemens.md"
OTHER = {"MID": 2, "KNAME": '"EDGE:LAST"', "VARI": 101, "RL": 42, "AS1": 2, "AS2": 2, "LP2": 3, "_AMODE": 1, "FFD": 100}
BESIDE = {"_AMODE": {"RFP": -1}, "LP2": {"AS2": 1, "LP2": 9}, "AS2": {"AS2": 1, "LP2": 9}, "FF3": {"VARI": 11}}


def read_rows():
    table = PAGE.read_text(encoding="utf-8").split("## Milling along a contour")[1].split("\n## ")[0]
    found = []
    for text in table.splitlines():
        if text.startswith("| `"):
            names, kind, _does = (cell.strip() for cell in text.strip("|").split("|", 2))
            found += [(name, value, kind) for name, value in read_values(names)]
    return found


def test_the_page_names_every_value():
    assert {name for name, *_rest in read_rows()} == {name for values in PARAMETERS.values() for name in values}


@pytest.mark.parametrize(("name", "value", "kind"), [row for row in read_rows() if row[0] in PARAMETERS["CYCLE72"]])
def test_every_value_does_what_the_page_says(mill, name, value, kind):
    contour, before = f"{PLATE}LAST: X-10\n", BESIDE.get(name, {})
    if kind == "refused":
        found = mill(write(**{**before, name: value}), contour)[1]
        assert [(item.code, name in item.message) for item in found] == [("VP002", True)]
        return
    other = OTHER.get(name, before.get(name, VALUES.get(name, 0)) + 1) if name not in OTHER else OTHER[name]
    one, two = (mill(write(**{**before, **more}), contour) for more in ({}, {name: other}))
    assert (one[1], two[1]) == ((), ())
    assert (rows_of(one[0]) != rows_of(two[0])) == (kind == "executed")


def test_a_circle_in_one_block_is_a_whole_one(mill):
    moves, findings = mill(write(MID=0, RL=42, AS1=2, LP1=3), "EDGE: G0 X20 Y0\nEND: G3 X20 Y0 I-20 J0\n")
    assert findings == ()
    whole = [row for row in rows_of(moves) if abs(row[-1]) > 180]
    assert whole == [line("A", 24, 0, -6, 500 * 24 / 20, 0, 0, 360)]
    assert math.isclose(rows_of(moves)[-2][1], 27)
