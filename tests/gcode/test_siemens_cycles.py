"""Cycles of Siemens programs: the moves of every hole, worked out by hand from the rules of the manuals."""

from pathlib import Path

import numpy as np
import pytest

from tests.builders import read_values
from verne_post import check
from verne_post.gcode.siemens import drilling, patterns
from verne_post.model.moves import ZERO9, MoveKind, PathMode
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

HEAD = "G0 X1 Y2 Z50 F100 S600 M3\n"


def heights(view, text, **options):
    """What a program does after its first line: R or F and the height of Z, P and seconds of dwells, X Y where they
    change.
    """
    moves, errors = view(f"{HEAD}{text}\nM30", dialect="siemens", **options)
    assert errors == (), errors
    shown, place = [], (1.0, 2.0)
    for row in range(1, len(moves)):
        end = np.round(moves.end[row], 6) + 0.0
        if moves.kind[row] == MoveKind.DWELL:
            shown.append(f"P{moves.feed[row]:g}")
            continue
        letter = "R" if moves.kind[row] == MoveKind.RAPID else "F"
        if (end[0], end[1]) != place:
            place = (end[0], end[1])
            shown.append(f"{letter}({place[0]:g},{place[1]:g},{end[2]:g})")
        else:
            shown.append(f"{letter}{end[2]:g}")
    return " ".join(shown)


@pytest.mark.parametrize(("call", "expected"), [
    ("CYCLE81(20,0,2,-10)", "R2 F-10 R20"), ("CYCLE81(20,0,2,,10)", "R2 F-10 R20"),
    ("CYCLE81(20,5,2,,10)", "R7 F-5 R20"), ("CYCLE81(20,0,2,0,10)", "R2 F-10 R20"),
    ("CYCLE81(20,0.0004,2,-10,10)", "R2.0004 F-9.9996 R20"),
    ("CYCLE81(0,0,2,-10)", "R2 F-10 R0"), ("CYCLE83(0,0,2,-10,,,4,0,0,0,1,0)", "R2 F-4 F-3 F-8 F-7 F-10 R0"),
    ("Z-50\nCYCLE81(0,0,2,10)", "R-50 R-2 F10 R0"),
    ("CYCLE81 (20,0,2,-10,)", "R2 F-10 R20"), ("CYCLE81(20,0,2,-10,0,0,0,1,12)", "R2 F-10 R20"),
    ("CYCLE81(20,0,2,10,0,0,0,1,1)", "R2 F-10 R20"),
    ("CYCLE82(20,0,2,-10,,1.5)", "R2 F-10 P1.5 R20"), ("CYCLE82(20,0,2,-10,,-5)", "R2 F-10 P0.5 R20"),
    ("CYCLE82(20,0,2,-10,,5,0,1,22)", "R2 F-10 P0.5 R20"),
    ("CYCLE89(20,0,2,-10,,1)", "R2 F-10 P1 F2 R20"), ("CYCLE85(20,0,2,-10,,1,50,200)", "R2 F-10 P1 F2 R20"),
    ("CYCLE840(20,0,2,-10,,0,4,3,0,0,1.25)", "R2 F-10 F2 R20"),
    ("CYCLE86(20,0,2,-10,,1,3,0.5,0,1,45)", "R2 F-10 P1 R(1.5,2,-9) R2 R(1,2,2) R20"),
    # deep holes, taking the chip out: 5, then 4, 3, 2 as long as that is more than the degression, halves at the end
    ("CYCLE83(20,0,2,-20,,-5,,1,0,0,1,1)",
     "R2 F-5 R2 R-4.4 F-9 R2 R-8.4 F-12 R2 R-11.4 F-14 R2 R-13.4 F-15 R2 R-14.4 F-16 R2 R-15.4 F-17 R2 R-16.4 F-18 "
     "R2 R-17.4 F-19 R2 R-18.4 F-20 R20"),
    ("CYCLE83(20,0,2,-10.5,,,4,2,0,0,1,0)", "R2 F-4 F-3 F-6 F-5 F-8 F-7 F-9.25 F-8.25 F-10.5 R20"),
    ("CYCLE83(20,0,2,-10,,,4,0,0,0,1,0)", "R2 F-4 F-3 F-8 F-7 F-10 R20"),
    ("CYCLE83(20,0,2,-10,,,4,-0.5,0,0,1,0,,1)", "R2 F-4 F-3 F-6 F-5 F-7 F-6 F-8 F-7 F-9 F-8 F-10 R20"),
    ("CYCLE83(20,0,2,-10,,,4,-1,0.5,0.25,1,1,,,,2,1)", "R2 F-4 P0.5 R2 P0.25 R-3 F-8 P0.5 R2 P0.25 R-7 F-10 P2 R20"),
    ("CYCLE83(20,0,2,-10,,,4,0,0,0,1,0,,,0.3)", "R2 F-4 F-3.7 F-8 F-7.7 F-10 R20"),
    ("CYCLE83(20,0,2,-10)", "R2 F-10 R20"), ("CYCLE83(20,0,2,-100,,,60,0,0,0,1,1)", "R2 F-60 R2 R-58 F-100 R20"),
    # eight digits: the sixth says that DAM is a percentage, 5 then 4.5, 4.05, 3.645, of which the last is what is left
    ("CYCLE83(20,0,2,-16,,,5,90,0,0,90,0,,,,,,0,1,11211112)", "R2 F-5 F-4 F-9.5 F-8.5 F-13.55 F-12.55 F-16 R20"),
    ("CYCLE83(20,0,2,-16,,,5,1,0,0,90,0,,,,,,0,1,11111112)",
     "R2 F-5 F-4 F-9 F-8 F-12 F-11 F-14 F-13 F-15 F-14 F-16 R20"),
    # upside down
    ("Z-50\nCYCLE82(-20,0,2,10)", "R-50 R-2 F10 R-20"),
])  # fmt: skip
def test_holes(view, call, expected):
    assert heights(view, call) == expected


def test_feeds_of_cycles(view):
    moves, errors = view(
        f"{HEAD}CYCLE85(20,0,2,-10,,0,50,200)\n"
        "CYCLE83(20,0,2,-10,,,4,0,0,0,0.5,0)\n"
        "CYCLE840(20,0,2,-10,,0,4,3,0,0,1.25)\n"
        "G1 Z10",
        dialect="siemens",
    )
    assert errors == ()
    feeds = [float(feed) for feed, kind in zip(moves.feed, moves.kind, strict=True) if kind == MoveKind.FEED]
    assert feeds == [50, 200, 50, 100, 100, 100, 100, 750, 750, 100]
    spindle = [event.data["direction"] for event in moves.events if event.kind == "spindle"]
    assert spindle == ["clockwise", "counterclockwise", "clockwise"]


def test_percentages_of_deep_holes(view):
    moves, errors = view(f"{HEAD}CYCLE83(20,0,2,-9.5,,,5,90,0,0,90,0,,,,,,0,1,11211112)\nG1 Z10", dialect="siemens")
    assert errors == ()
    assert [float(feed) for feed, kind in zip(moves.feed, moves.kind, strict=True) if kind == MoveKind.FEED] == [
        90,
        100,
        100,
        100,
    ]
    for values, part in (
        ("101,0,0,90,0,,,,,,0,1,11211112", "DAM"),
        ("-1,0,0,90,0,,,,,,0,1,11111112", "DAM"),
        ("1,0,0,101,0", "FRF"),
        ("1,0,0,1,0,,,,,,0,1,31111112", "_AMODE"),
    ):
        found = view(f"{HEAD}CYCLE83(20,0,2,-10,,,5,{values})", dialect="siemens")[1]
        assert found[0].code in ("VP002", "VP007")
        assert part in found[0].message


def test_mistakes_of_modal_cycles_are_at_the_value_in_the_line_of_mcall(view):
    """FDEP 5 lies above the reference plane: the 5 of line 2, wherever the hole is."""
    head = "G0 X0 Y0 Z60 F300 S1000 M3\nMCALL CYCLE83(50,0,2,-20,,5,,2,0.5,0.5,1,1)\n"
    for block in ("X10", "HOLES1(0,0,0,10,20,2)"):
        found = view(f"{head}{block}\nMCALL\nM30", dialect="siemens")[1]
        assert [(item.code, item.line, item.column) for item in found] == [("VP007", 2, 27)]


def test_mistakes_of_a_proc_line_stand_in_it(view):
    text = "G0 X0\n  FACE(30,-9)\nM30\n%_N_FACE_SPF\nPROC FACE(REAL A1, FOO B1)\nX=A1\nM17"
    found = view(text, dialect="siemens")[1]
    assert [(item.line, item.column) for item in found] == [(5, 20)]


def test_without_sdr_the_spindle_turns_as_before_the_thread(view):
    moves, errors = view("G0 X0 Y0 Z60 F300 S1000 M4\nCYCLE840(50,0,2,-10,,0.3)", dialect="siemens")
    assert errors == ()
    spindle = [event.data["direction"] for event in moves.events if event.kind == "spindle"]
    assert spindle == ["counterclockwise", "clockwise", "counterclockwise"]


def test_corners_of_cycles_are_not_blended(view):
    moves, errors = view(f"G64\n{HEAD}X5\nCYCLE82(20,0,2,-10)\nX7", dialect="siemens")
    assert errors == ()
    modes = [moves.controls[index].mode for index in moves.control]
    assert modes == [PathMode.BLEND] * 2 + [PathMode.EXACT_PATH] * 3 + [PathMode.BLEND]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "MCALL CYCLE82(20,0,2,-5)\nX3\nR1=1\nY4 Z30\nMCALL\nX9",
            "R(3,2,50) R2 F-5 R20 R(3,4,30) R2 F-5 R20 R(9,4,20)",
        ),
        ("R1=-5\nMCALL CYCLE82(20,0,2,R1)\nR1=-9\nX3", "R(3,2,50) R2 F-5 R20"),  # read once
        ("MCALL CYCLE82(20,0,2,-5)\nHOLES1(0,0,0,10,20,2)", "R(10,0,50) R2 F-5 R20 R(30,0,20) R2 F-5 R20"),
        (
            "X0 Y40\nMCALL CYCLE82(20,0,2,-5)\nHOLES1(0,0,90,10,20,2)",
            "R(0,40,50) R(0,30,50) R2 F-5 R20 R(0,10,20) R2 F-5 R20",
        ),
        ("HOLES2(10,0,5,90,0,4)", "R(10,5,50) R(5,0,50) R(10,-5,50) R(15,0,50)"),
        ("HOLES2(10,0,5,0,30,2)", "R(15,0,50) R(14.3301,2.5,50)"),
        ("HOLES2(10,0,5,90,90,4,1000,0,,,1)", "R(10,5,50) R(5,0,50) R(10,-5,50) R(15,0,50)"),
        ("HOLES2(10,0,5,0,0,2,1000)", "R(15,0,50) R(5,0,50)"),
        ("HOLES2(10,0,5,0,30,2,2000)", "R(15,0,50) R(14.3301,2.5,50)"),
        ("CYCLE801(0,0,0,10,5,2,2)", "R(0,0,50) R(10,0,50) R(10,5,50) R(0,5,50)"),
        ("CYCLE801(0,0,90,10,5,2,1)", "R(0,0,50) R(0,10,50)"),
    ],
)
def test_modal_calls_and_patterns(view, text, expected):
    assert heights(view, text) == expected


def test_cycles_drill_along_the_axis_of_their_plane(view):
    for text, axis in (
        ("G18\nCYCLE82(20,0,2,-5)", 1),
        ("G19\nCYCLE82(20,0,2,-5)", 0),
        ("CYCLE82(20,0,2,-5,,0,0,2)", 1),
        ("CYCLE83(20,0,2,-5,,,5,0,0,0,1,0,1)", 0),
    ):
        moves, errors = view(f"G0 X50 Y50 Z50 F100\n{text}", dialect="siemens")
        assert errors == ()
        assert moves.end[1:, axis].tolist() == [2, -5, 20]
        others = [number for number in range(3) if number != axis]
        assert (moves.end[:, others] == 50).all()


def test_cycles_in_inches(view):
    moves, errors = view("G0 X0 Y0 Z50 F100\nG70\nCYCLE82(1,0,0.1,-0.5)", dialect="siemens")
    assert errors == ()
    assert moves.end[1:, 2] == pytest.approx([2.54, -12.7, 25.4])


@pytest.mark.parametrize(("call", "code", "part"), [
    ("CYCLE82(20,0,2,-10,,1,5)", "VP002", "_GMODE"), ("CYCLE82(20,0,2,-10,,1,0,0,3)", "VP002", "_AMODE"),
    ("CYCLE82(20,0,2,-10,,1,0,0,0,1)", "VP002", "_VARI"), ("CYCLE82(20,0,2,-10,,\"A\")", "VP007", "DTB"),
    ("CYCLE83(20,0,2,-10,,-3,,0,0,0,102)", "VP007", "FRF"), ("CYCLE83(20,0,2,-10,,-3,,0,0,0,1,2)", "VP002", "VARI"),
    ("CYCLE83(20,0,2,-10,,-3,,-2)", "VP007", "DAM"), ("CYCLE83(20,0,2,-10,,-3,,-0.001,0,0,1,0)", "VP007", "strokes"),
    ("CYCLE83(20,0,2,-10,,-3,,0,0,0,1,0,4)", "VP007", "_AXN"), ("CYCLE86(20,0,2,-10,,1,5)", "VP007", "SDIR"),
    ("CYCLE840(20,0,2,-10,,0,3,3)", "VP007", "SDR"), ("M5\nCYCLE840(20,0,2,-10)", "VP017", "spindle"),
    ("CYCLE840(20,0,2,-10,,0,4,3,5)", "VP002", "ENC"), ("HOLES1(0,0,0,10,20,0)", "VP007", "NUM"),
    ("HOLES2(0,0,0,0,0,3)", "VP007", "RAD"), ("HOLES2(0,0,9,0,30,3,1000)", "VP002", "INDA 0 or 120"),
    ("HOLES2(0,0,9,0,0,3,2000)", "VP002", "INDA"), ("HOLES2(0,0,9,0,0,3,1010)", "VP002", "_VARI 1010"),
    ("HOLES1(0,0,0,10,20,2,5)", "VP002", "_VARI"),
    ("CYCLE801(0,0,0,1,1,101,101)", "VP007", "holes"),
    ("G93\nCYCLE82(20,0,2,-10)", "VP017", "G93"), ("MCALL CYCLE82(20,0,2,-10)\nG93 X5 F5", "VP017", "G93"),
    ("CYCLE81(20,0,-3,-10)", "VP007", "SDIS -3"), ("CYCLE83(20,0,-0.1,-10,,-3)", "VP007", "SDIS -0.1"),
    ("CYCLE82(20,0,2)", "VP005", "DP"), ("CYCLE832(-1,1)", "VP007", "negative"),
    ("CYCLE832(0.1,1,0.5,7)", "VP005", "values"),
    ("CYCLE800(9,\"\",0,57,0,0,0,20)", "VP002", "_FR"), ("CYCLE800(0,\"\",100,57,0,0,0,20)", "VP002", "_ST"),
    ("CYCLE800(0,\"\",0,300)", "VP007", "bits"), ("CYCLE800(0,\"\",0,0,0,0,0,20)", "VP007", "_MODE"),
    ("CYCLE800(0,\"\",0,64,0,0,0,1,2,3)", "VP006", "solid"),
])  # fmt: skip
def test_what_a_cycle_refuses(view, call, code, part):
    found = view(f"{HEAD}{call}\nM30", dialect="siemens")[1]
    assert [item.code for item in found] == [code], found
    assert part in found[0].message


def test_strokes_in_all_holes_of_a_pattern_are_bounded(view):
    """10,000 strokes in a hole are allowed; in four of one block they are not, and none of them is drilled."""
    text = (
        "G71 G90 G17\n"
        "T1 D1\n"
        "G0 X0 Y0 Z20\n"
        "F100 S500 M3\n"
        "MCALL CYCLE83(5,0,2,-10,,-0.001,,,,,,1,,,0.001)\n"
        "{}\n"
        "MCALL\n"
        "M30\n"
    )
    moves, findings = view(text.format("HOLES1(0,0,0,5,5,4)"), dialect="siemens")
    assert [item.code for item in findings] == ["VP007"]
    assert "more than 30000 strokes in the holes of one block" in findings[0].message
    assert moves is None or len(moves) < 10


@pytest.mark.parametrize(
    "call", ["CYCLE84(20,0,2,-10,,,5,,1.25,0,500,500,3,0,0,0,0,,{})", "CYCLE840(20,0,2,-10,,0,4,3,0,0,1.25,3,0,0,{})"]
)
def test_texts_of_the_editor_of_threads_have_no_effect(view, call):
    """The row of a table of threads beside PIT, as an editor writes it; PIT alone counts."""
    one, two = (
        view(f"{HEAD}{call.format(texts)}", dialect="siemens", tapping="feed") for texts in ('"","ISO_METRIC","M8"', "")
    )
    assert (one[1], two[1]) == ((), ())
    assert one[0].end.tolist() == two[0].end.tolist()


@pytest.mark.parametrize(("call", "code", "said", "column"), [
    ("CYCLE83(60,41,3,29,-5,,2,0,0,1,1)", "VP007", "DPR -5: a depth below RFP is not negative; write 5, or leave DPR "
     "empty, with a comma for it, if DP 29 is meant", 20),
    ("CYCLE85(60,41,2,,-5,0,50,50)", "VP007", "DPR -5: a depth below RFP is not negative; write 5", 18),
    ("CYCLE83(60,41,2,29,,,-4,0,0,0,1,1)", "VP007", "FDPR -4: a depth below RFP is not negative; write 4", 22),
    ("CYCLE82(60,41,2,38,10)", "VP505", "DP is 38, but DPR 10 below RFP ends at 31, and DPR counts; leave one of "
     "them empty", 20),
    ("POCKET1(60,41,2,37,5,40,30,5,0,0,0,50,500,5,2,0,0)", "VP505", "DP is 37, but DPR 5 below RFP ends at 36, and DPR "
     "counts; leave one of them empty", 20),
    ("LONGHOLE(60,41,2,37,-5,1,40,0,0,9,0,0,99,500,5)", "VP007", "DPR -5: a depth below RFP is not negative; write 5, "
     "or leave DPR empty, with a comma for it, if DP 37 is meant", 21),
])  # fmt: skip
def test_depths_that_contradict_each_other_are_told(machine, call, code, said, column):
    """A comma that was lost makes the first depth the depth below the reference plane."""
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *ZERO9[3:]), 6.0)}
    text = f"T1 D1 M6\nS1000 M3\nG0 X0 Y0 Z60 A0 C0 F300\n{call}\nG0 Z60\nM30"
    findings = check(text.encode(), machine, Options(dialect="siemens", wcs={"G54": (0, 0, 0)}, tools=tools)).findings
    found = [item for item in findings if item.code == code]
    assert [(item.message.partition(": ")[2], item.line, item.column) for item in found] == [(said, 4, column)]


PAGE = Path(__file__).parents[2] / "docs" / "siemens.md"
#: Values of each cycle from which one differs, and what that one is.
HOLE = {"RTP": 20, "RFP": 0, "SDIS": 2, "DP": -10, "DTB": 0.1}
GIVEN = {
    "CYCLE83": {"FDEP": -4, "DAM": 1, "VARI": 1, "DTS": 0.2, "FRF": 0.5},
    "CYCLE84": {"SDAC": 5, "PIT": 1.25, "POSS": 10, "SST": 500},
    "CYCLE85": {"FFR": 50, "RFF": 200},
    "CYCLE86": {"SDIR": 3, "POSS": 10},
    "CYCLE840": {"SDAC": 3, "PIT": 1.25},
    "HOLES1": {"SPCA": 1, "DBH": 5, "NUM": 3},
    "HOLES2": {"RAD": 9, "NUM": 3, "INDA": 20},
    "CYCLE801": {"_DIS1": 5, "_DIS2": 7, "_NUM1": 2, "_NUM2": 3},
}
OTHER = {
    "RTP": 21, "RFP": -1, "SDIS": 3, "DP": -9, "DPR": 9, "DTB": 0.3, "_AMODE": 21, "_DMODE": 1, "FDEP": -5, "FDPR": 5,
    "DAM": 0.5, "_MDEP": 2, "_DIS1": 0.9, "DTS": 0.4, "_DTD": 0.7, "FRF": 0.8, "SDAC": 4, "MPIT": 6, "PIT": 1.5,
    "_PITA": 3, "_VARI": 1, "_VRT": 0.5, "POSS": 20, "SST": 400, "SST1": 300, "FFR": 60, "RFF": 60, "SDIR": 4, "RPA": 1,
    "RPO": 1, "RPAP": 1, "SDR": 4, "ENC": 1, "SPCA": 2, "SPCO": 3, "STA1": 30, "FDIS": 2, "DBH": 6, "NUM": 4, "CPA": 2,
    "CPO": 3, "RAD": 8, "INDA": 40, "_SPCA": 2, "_SPCO": 3, "_STA": 15, "_DIS2": 6, "_NUM1": 3, "_NUM2": 4, "VARI": 0,
    "_TECHNO": 2221, "_PITM": '"8"', "_PTAB": '"ISO_METRIC"', "_PTABA": '"M8"', "_NSP": 3, "_AXN": 1, "_DAM": 3,
}  # fmt: skip
BESIDE = {
    ("CYCLE83", "_VRT"): {"VARI": 0},
    ("CYCLE84", "_VRT"): {"_VARI": 1, "_DAM": 4},
    ("CYCLE84", "_VARI"): {"_DAM": 4},
    ("CYCLE84", "_DAM"): {"_VARI": 1},
    ("CYCLE84", "_TECHNO"): {"_VARI": 2, "_DAM": 4},
    ("CYCLE84", "MPIT"): {"PIT": 0},
    ("CYCLE840", "MPIT"): {"PIT": 0},
    ("CYCLE840", "SDAC"): {"SDR": 4},
    ("CYCLE840", "SDR"): {"SDAC": 4},
}


def list_rows():
    """Name, value, cycles and kind of each value of the table of drilling cycles."""
    head = "| value | of | kind | does |\n|---|---|---|---|\n"
    table = PAGE.read_text(encoding="utf-8").split(head)[1].split("\n\n")[0]
    found = []
    for line in table.splitlines():
        names, cycles, kind, _does = (cell.strip() for cell in line.strip("|").split("|", 3))
        having = list(drilling.PARAMETERS) if cycles == "all drilling cycles" else cycles.split(", ")
        found += [(name, value, having, kind) for name, value in read_values(names)]
    return found


def test_the_page_names_every_value_of_every_drilling_cycle():
    shown = {(cycle, name) for name, _value, cycles, _kind in list_rows() for cycle in cycles}
    every = drilling.PARAMETERS | patterns.PARAMETERS
    assert {(cycle, name) for cycle, names in every.items() for name in names} == shown


@pytest.mark.parametrize(("name", "value", "cycles", "kind"), list_rows())
def test_every_value_of_a_drilling_cycle_does_what_the_page_says(view, name, value, cycles, kind):
    def run(cycle, **more):
        is_hole = cycle in drilling.PARAMETERS
        given = (HOLE if is_hole else {}) | GIVEN.get(cycle, {}) | more
        names = (drilling.PARAMETERS if is_hole else patterns.PARAMETERS)[cycle]
        call = f"{cycle}({','.join(str(given.get(one, '')) for one in names)})"
        head = HEAD.replace("G0", "G18 G0" if name == "_DMODE" and not value else "G0")
        return view(
            f"{head}{'' if is_hole else 'MCALL CYCLE81(20,0,2,-10)'}\n{call}", dialect="siemens", tapping="feed"
        )

    for cycle in cycles:
        beside = BESIDE.get((cycle, name), {})
        one, two = run(cycle, **beside), run(cycle, **beside, **{name: value or OTHER[name]})
        if kind == "refused":
            assert [(item.code, name in item.message) for item in two[1]] == [("VP002", True)], cycle
            continue
        executed = {"_AXN0": "VP017", "_VARI1000": "VP002"}.get(f"{name}{value}")  # a tool along Z, and a step of 20
        if executed is not None:
            assert (one[1], [item.code for item in two[1]]) == ((), [executed]), cycle
            continue
        assert [item for item in two[1] if item.severity == "error"] == [], cycle
        shown = [
            (moves.end.tolist(), np.nan_to_num(moves.feed).tolist(), [(one.kind, one.data) for one in moves.events])
            for moves, _found in (one, two)
        ]
        assert (shown[0] != shown[1]) == (kind == "executed"), cycle


def test_depths_of_a_modal_cycle_are_told_once_where_it_is_defined(machine):
    """Each hole had the warning, at the column that the value has in the line of MCALL."""
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *ZERO9[3:]), 6.0)}
    text = "T1 D1 M6\nS1000 M3\nG0 X0 Y0 Z60 A0 C0 F300\nMCALL CYCLE82(60,41,2,38,10)\nX1\nX2\nX3\nMCALL\nM30"
    findings = check(text.encode(), machine, Options(dialect="siemens", wcs={"G54": (0, 0, 0)}, tools=tools)).findings
    found = [(item.line, item.column, item.count) for item in findings if item.code == "VP505"]
    assert found == [(4, 26, 3)]
