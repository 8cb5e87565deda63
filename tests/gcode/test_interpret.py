"""What blocks mean beyond the reference file: order, units, feed, arcs, homes, offsets, tools, ends, errors.

Moves are written as ``line kind axes feed``: axes that are not named are 0, feeds are mm/min or deg/min
(F) and seconds (P). Every expectation was confirmed with LinuxCNC's rs274 2.9 unless a comment says otherwise.
"""

import re

import numpy as np
import pytest

from verne_post.gcode import interpret_plainly
from verne_post.model.findings import InputError
from verne_post.model.moves import FeedMode, PathControl, PathMode

# --- order of execution, units, feed, distance mode -----------------------------------------------

BLOCKS = {
    # order: position on the line is meaningless
    "F is taken before the unit change, mm to inch": ("F10 G20 G1 X1\nM2", ["1 feed X25.4 F10"]),
    "F is taken before the unit change, inch to mm": ("G20\nF10 G21 G1 X50\nM2", ["2 feed X50 F254"]),
    "the feed mode comes before F": ("X3 F2 Y4 G1 G93\nM2", ["1 feed X3 Y4 F10"]),
    "a dwell comes before the motion of its line": ("F60 G1 X1 G4 P.25\nM2", ["1 dwell P0.25", "1 feed X1 F60"]),
    "units act on their own line": ("G0 X1 G20\nX2 G21\nM2", ["1 rapid X25.4", "2 rapid X2"]),
    "distance mode acts on its own line": ("G0 X1\nX1 G91\nX1 G90\nM2", ["1 rapid X1", "2 rapid X2", "3 rapid X1"]),
    "tool offset comes before motion": ("G0 Z0\nG0 X1 G43 H1\nM2", ["1 rapid", "2 rapid X1 Z-10"]),
    "work offset comes before motion": ("G10 L2 P2 X10\nG0 X1 G55\nG0 X0 G54\nM2", ["2 rapid X1", "3 rapid"]),
    "G10 P0 means the system chosen on its line": (
        "G55 G10 L2 P0 X10\nG53 G0 X10\nG54 G0\nM2", ["2 rapid", "3 rapid X10"],
    ),
    "a comment between words": ("G0 (one) X1 (two) Y2\nM2", ["1 rapid X1 Y2"]),
    # modal motion
    "motion is modal": (
        "G1 X1 F9\nY2\nG0 Z3\nX0\nM2",
        ["1 feed X1 F9", "2 feed X1 Y2 F9", "3 rapid X1 Y2 Z3", "4 rapid Y2 Z3"],
    ),
    "a motion word without axes is a move of no length": (
        "G0 X1\nG1 F5\nG0\nM2",
        ["1 rapid X1", "2 feed X1 F5", "3 rapid X1"],
    ),
    "F alone is no move": ("G1 X1 F5\nF7\nX2\nM2", ["1 feed X1 F5", "3 feed X2 F7"]),
    "F of a G0 block is stored": ("G0 X1 F44\nG1 X2\nM2", ["1 rapid X1", "2 feed X2 F44"]),
    "other codes suspend motion for a line": (
        "G1 X1 F5\nG92 X0\nX1\nG10 L2 P1 X5\nX2\nG28 X7\nX3\nG4 P1\nX4\nM2",
        ["1 feed X1 F5", "3 feed X1 F5", "5 feed X2 F5", "6 rapid X7", "6 rapid X-6", "7 feed X3 F5", "8 dwell P1",
         "9 feed X4 F5"],
    ),
    "N is only a number": ("N10 G0 X1\nN5.5 X2\nN10X3\nN7\nM2", ["1 rapid X1", "2 rapid X2", "3 rapid X3"]),
    "lower case, blanks inside numbers": ("n 1 g 0 x - 1 . 5\t0y+ .5\nm2", ["1 rapid X-1.5 Y0.5"]),
    # units
    "a unit change keeps position and feed": ("F100 G1 X25.4\nG20\nX2\nG91 X1\nM2", [
        "1 feed X25.4 F100", "3 feed X50.8 F100", "4 feed X76.2 F100"]),
    "inch scales lengths and mixed feeds": ("G20\nF2 G1 X1 A10\nM2", ["2 feed X25.4 A10 F50.8"]),
    "inch leaves rotary words and rotary feeds": ("G20\nF2 G1 A90 B-5 C20\nM2", ["2 feed A90 B-5 C20 F2"]),
    "a rotary feed keeps its number through a unit change": ("F2 G1 A1\nG20\nA2\nX1\nM2", [
        "1 feed A1 F2", "3 feed A2 F2", "4 feed X25.4 A2 F2"]),
    "inch leaves dwells": ("G20 G4 P1.5\nM2", ["1 dwell P1.5"]),
    # inverse time
    "G93 of a straight move": ("G93 G1 X3 Y4 A90 F2\nM2", ["1 feed X3 Y4 A90 F10"]),
    "G93 of a rotary move": ("G93 G1 A3 C4 F2\nM2", ["1 feed A3 C4 F10"]),
    "G93 of a tiny move with a large rotation": ("G93 G1 X1 A90 F2\nM2", ["1 feed X1 A90 F2"]),
    "G93 in inches": ("G20 G93 G1 X1 F2\nM2", ["1 feed X25.4 F50.8"]),
    "G93 of an arc": ("G93 G2 X10 I5 F2\nM2", ["1 arc X10 F31.4159"]),
    "G93 of a helix of three turns": ("G93 G3 I-5 Z30 P3 F1\nM2", ["1 arc Z30 F98.9072"]),
    "G93 does not touch rapids": ("G93 G0 X5\nG1 X6 F3\nM2", ["1 rapid X5", "2 feed X6 F3"]),
    "G93 with the same F again": (
        "G93 G1 X10 F2\nX20 F2\nX21 F2\nM2",
        ["1 feed X10 F20", "2 feed X20 F20", "3 feed X21 F2"],
    ),
    "G94 with its F": ("G93 G1 X1 F5\nG94 F30 X2\nX3\nM2", ["1 feed X1 F5", "2 feed X2 F30", "3 feed X3 F30"]),
    # G80
    "G80 alone": ("G1 F9 X1\nG80\nG0 X2\nM2", ["1 feed X1 F9", "3 rapid X2"]),
    # the usual safety line
    "G80 beside another motion code": ("G0 G17 G40 G49 G80 G90\nX1\nG80 G1 F5\nX2\nM2", [
        "1 rapid", "2 rapid X1", "3 feed X1 F5", "4 feed X2 F5"]),
    # ends
    "M2 ends the reading": ("G0 X1\nM2\nX2 X3 ((\n#", ["1 rapid X1"]),
    "M30 acts after the motion of its line": ("G0 X1 M30\nX2", ["1 rapid X1"]),
    "a pair of %": ("\n %\nG0 X1\n% \nX2 ((", ["3 rapid X1"]),
    "M2 inside a pair of %": ("%\nG0 X1\nM2\nX2 ((\n%", ["2 rapid X1"]),
    "M2 after a single %": ("%\nG0 X1\nM2", ["2 rapid X1"]),
    "a program number": ("%\nO1234 (TOP)\nG0 X1\n%", ["3 rapid X1"]),
    "everything else is left alone": (
        "G17 G40 G98 G61\nM48 (override)\nM3 S100\nM8\nM5 M9\nS5 T1\nG0 X1\nM2", ["7 rapid X1"],
    ),
}  # fmt: skip

# --- coordinates and tools --------------------------------------------------------------------------

COORDINATES = {
    # homes
    "G28 over a point": ("G0 X5 Y6 Z7\nG28 Z20\nM2", ["1 rapid X5 Y6 Z7", "2 rapid X5 Y6 Z20", "2 rapid X5 Y6"]),
    "G28 over an incremental point": ("G0 X5 Z7\nG91 G28 Z1 X0\nM2", ["1 rapid X5 Z7", "2 rapid X5 Z8", "2 rapid"]),
    "G28 of all axes": ("G0 X5 A7\nG28\nM2", ["1 rapid X5 A7", "2 rapid X5 A7", "2 rapid"]),
    "G30 in inches": ("G20 G0 X1\nG30 Y2\nM2", ["1 rapid X25.4", "2 rapid X25.4 Y50.8", "2 rapid X25.4"]),
    "G28 obeys offsets on the way and not at home": (
        "G10 L2 P1 X10\nG92 X3\nG0 X4\nG28 X5\nM2", ["3 rapid X4", "4 rapid X5", "4 rapid X3"],
    ),
    "G28 takes out the tool": ("G43 H1\nG0 Z5\nG28 Z6\nM2", ["2 rapid Z5", "3 rapid Z6", "3 rapid Z-10"]),
    # G53
    "G53 takes out offset, tool and G92 for one line": (
        "G10 L2 P1 X10 Z1\nG43 H2\nG92 Y5\nG53 G0 X1 Y1 Z1\nX1 Y1 Z1\nM2", ["4 rapid X-9 Y6 Z-25", "5 rapid X1 Y1 Z1"],
    ),
    "G53 G1 feeds": ("G10 L2 P1 X10\nF50 G53 G1 X1\nX2\nM2", ["2 feed X-9 F50", "3 feed X2 F50"]),
    "G53 with modal G0": ("G10 L2 P1 X10\nG0\nG53 X0\nM2", ["2 rapid X-10", "3 rapid X-10"]),
    "G53 under rotation": ("G10 L2 P1 R90\nG53 G0 X10\nM2", ["2 rapid Y-10"]),
    "G53 in inches": ("G20 G53 G0 X1 A5\nM2", ["1 rapid X25.4 A5"]),
    # G10 L2, L20
    "G10 L2 acts at once on the active system": ("G0 X10\nG10 L2 P1 X3\nG91 G0 X0\nM2", ["1 rapid X10", "3 rapid X7"]),
    "G10 L2 leaves other axes": ("G10 L2 P1 X3 Y4\nG10 L2 P1 X5\nG53 G0 X0 Y0\nM2", ["3 rapid X-5 Y-4"]),
    "G10 L2 is not incremental": ("G91 G10 L2 P1 X3\nG10 L2 P1 X3\nG90 G53 G0 X0\nM2", ["3 rapid X-3"]),
    "G10 L2 of another system": ("G10 L2 P9 X3 C4\nG59.3\nG53 G0 X0 C0\nM2", ["3 rapid X-3 C-4"]),
    "G10 L2 in inches": ("G20 G10 L2 P1 X1 A1\nG53 G0 X0 A0\nM2", ["2 rapid X-25.4 A-1"]),
    "G10 L2 R turns moves and centres": ("G10 L2 P1 X1 R30\nG53 G0 X1 Y2\nM2", ["2 rapid X1 Y1.7321"]),
    "G10 L2 R stays until the next R": ("G10 L2 P1 R90\nG10 L2 P1 X1\nG53 G0 X2\nG10 L2 P1 R0\nG53 G0 X2\nM2", [
        "3 rapid Y-1", "5 rapid X1"]),
    "G10 L20 makes here read as given": (
        "G0 X10 Y20\nG10 L20 P1 X1\nG91 G0 X0\nM2",
        ["1 rapid X10 Y20", "3 rapid X1 Y20"],
    ),
    "G10 L20 of another system": ("G0 X10\nG10 L20 P3 X1\nG56 G91 G0 X0\nM2", ["1 rapid X10", "3 rapid X1"]),
    "G10 L20 P0 with a tool": ("G43 H1\nG0 Z5\nG10 L20 P0 Z100\nG91 G0 Z0\nM2", ["2 rapid Z5", "4 rapid Z100"]),
    # G92, G52
    "a second G92 replaces the first": (
        "G0 X5\nG92 X0\nG92 X3\nG0 X4\nG53 G0 X0\nM2",
        ["1 rapid X5", "4 rapid X4", "5 rapid X-2"],
    ),
    "G92 keeps axes that it does not name": ("G92 Y7\nG92 X3\nG91 G0 X0\nM2", ["3 rapid X3 Y7"]),
    "G92 holds across systems": ("G92 X7\nG10 L2 P2 X1\nG55 G91 G0 X0\nM2", ["3 rapid X6"]),
    "G92 in inches": ("G20 G92 X1 A5\nG91 G0 X0\nM2", ["2 rapid X25.4 A5"]),
    "G92.1 forgets": ("G92 X7\nG92.1\nG92.3\nG91 G0 X0\nM2", ["4 rapid"]),
    "G92.2 suspends, G92.3 resumes": ("G92 X7\nG92.2\nG91 G0 X0\nG92.3\nX0\nM2", ["3 rapid", "5 rapid X7"]),
    "G52 is an offset in the same store": (
        "G52 X5\nG0 X1\nG53 G0 X1\nG92.1\nG91 X0\nM2",
        ["2 rapid X1", "3 rapid X-4", "5 rapid X1"],
    ),
    "G52 X0 resets X": ("G92 X5 Y5\nG52 X0\nG91 G0 X0\nM2", ["3 rapid Y5"]),
    # tools
    "T1 M6, G43": ("T1 M6\nG43\nG53 G0 Z0\nM2", ["3 rapid Z-10"]),
    "T selects and does not load": ("T1\nG43\nG53 G0 Z0\nM2", ["3 rapid"]),
    "G43 H0 is the tool in the spindle": ("T2 M6\nG43 H0\nG53 G0 Z0\nM2", ["3 rapid Z-25"]),
    "M6 does not change the offset": (
        "T1 M6\nG43\nT2 M6\nG53 G0 Z0\nG43\nG53 G0 Z0\nM2",
        ["4 rapid Z-10", "6 rapid Z-25"],
    ),
    "T acts before M6 whatever their order": ("T1\nM6 T2\nG43\nG53 G0 Z0\nM2", ["4 rapid Z-25"]),
    "G43 does not move": ("G0 Z50\nG43 H1\nG91 G0 Z0\nG49\nZ0\nM2", ["1 rapid Z50", "3 rapid Z40", "5 rapid Z50"]),
    "G43.1 sets the axes that it names": ("G43 H1\nG43.1 X3\nG53 G0 X0 Z0\nG43.1 Z7\nG53 Z0\nM2", [
        "3 rapid X-3 Z-10", "5 rapid X-3 Z-7"]),
    "G43.1 in inches": ("G20 G43.1 Z1\nG53 G0 Z0\nM2", ["2 rapid Z-25.4"]),
    "G10 L1 waits for the next G43": (
        "G43 H1\nG10 L1 P1 Z33\nG53 G0 Z0\nG43 H1\nG53 G0 Z0\nM2",
        ["3 rapid Z-10", "5 rapid Z-33"],
    ),
    # G43.4 is our own: the same offset as G43, because tool-centre-point control is always on
    "G43.4": ("G43.4 H1\nG53 G0 Z0\nM2", ["2 rapid Z-10"]),
}  # fmt: skip

TABLE = {**BLOCKS, **COORDINATES}


def test_no_name_stands_twice():
    assert len(TABLE) == len(BLOCKS) + len(COORDINATES)


@pytest.mark.parametrize("name", TABLE)
def test_moves(moves_text, name):
    program, expected = TABLE[name]
    assert moves_text(program) == expected


@pytest.mark.parametrize(("program", "kept", "deleted"), [
    ("/G0 X1\nG0 X2\n/ M2\nX3\nM2", ["1 rapid X1", "2 rapid X2"], ["2 rapid X2", "4 rapid X3"]),
    ("  / N5 G0 X1\n/\nM2", ["1 rapid X1"], []),
    ("/(MSG,x)\nG0 X1\nM2", ["2 rapid X1"], ["2 rapid X1"]),
    ("/G12\nG0 X1\nM2", None, ["2 rapid X1"]),
    # the words of a deleted block are not looked at
    ("/X1 X2\n/#1=2\n//X1.2.3\nG0 X1\nM2", None, ["4 rapid X1"]),
])  # fmt: skip
def test_block_delete(view, moves_text, program, kept, deleted):
    if kept is None:
        assert len(view(program)[1]) == 1
    else:
        assert moves_text(program) == kept
    assert moves_text(program, block_delete=True) == deleted
    messages = [event for event in view(program, block_delete=True)[0].events if event.kind == "message"]
    assert messages == []


# --- arcs -------------------------------------------------------------------------------------------

#: program -> plane, centre, turns, sweep, end
ARCS = {
    "F9 G2 X10 Y10 R10": (0, (10, 0, 0), -1, -90, (10, 10, 0)),
    "F9 G3 X10 Y10 R10": (0, (0, 10, 0), 1, 90, (10, 10, 0)),
    "F9 G2 X10 Y10 R-10": (0, (0, 10, 0), -1, -270, (10, 10, 0)),
    "F9 G3 X10 Y10 R-10": (0, (10, 0, 0), 1, 270, (10, 10, 0)),
    "F9 G3 X10 Y10 R10 Z5 P2": (0, (0, 10, 0), 2, 450, (10, 10, 5)),
    "F9 G2 I5": (0, (5, 0, 0), -1, -360, (0, 0, 0)),
    "F9 G3 J-5 Z3": (0, (0, -5, 0), 1, 360, (0, 0, 3)),
    "F9 G2 X10 I5 P4": (0, (5, 0, 0), -4, -1260, (10, 0, 0)),
    "F9 G2 X0 Y0 I3 J4": (0, (3, 4, 0), -1, -360, (0, 0, 0)),
    "F9 G0 X7 Y8 Z9\nG91 G3 X-10 I-5": (0, (2, 8, 9), 1, 180, (-3, 8, 9)),
    "F9 G0 X7 Y8\nG90.1 G3 X-3 Y8 I2 J8": (0, (2, 8, 0), 1, 180, (-3, 8, 0)),
    "F9 G0 X7 Y8\nG90.1\nG91.1 G3 X-3 I-5": (0, (2, 8, 0), 1, 180, (-3, 8, 0)),
    "F9 G20 G2 X1 I.5": (0, (12.7, 0, 0), -1, -180, (25.4, 0, 0)),
    # an end that differs from the start by rounding only
    "F9 G0 X.1\nG91 X.2\nG90 G2 X.3 I5": (0, (5.3, 0, 0), -1, -360, (0.3, 0, 0)),
    "F9 G0 X.1\nG91 X.2\nG90 G3 X.3 I5": (0, (5.3, 0, 0), 1, 360, (0.3, 0, 0)),
    "F9 G0 X.1\nG91 X.2\nG90 G3 X.3 I-5": (0, (-4.7, 0, 0), 1, 360, (0.3, 0, 0)),
    # G18: the plane is Z, X; G2 looks the wrong way round to one who thinks in X, Z
    "F9 G18 G2 X10 Z10 R10": (1, (0, 0, 10), -1, -90, (10, 0, 10)),
    "F9 G18 G3 X10 Z10 R10": (1, (10, 0, 0), 1, 90, (10, 0, 10)),
    "F9 G18 G2 X10 I5 Y4": (1, (5, 0, 0), -1, -180, (10, 4, 0)),
    "F9 G18 G3 K5 P2": (1, (0, 0, 5), 2, 720, (0, 0, 0)),
    "F9 G18 G3 X10 Z10 K10": (1, (0, 0, 10), 1, 270, (10, 0, 10)),
    # G19: the plane is Y, Z
    "F9 G19 G2 Y10 Z10 R10": (2, (0, 10, 0), -1, -90, (0, 10, 10)),
    "F9 G19 G3 Y10 Z10 R10": (2, (0, 0, 10), 1, 90, (0, 10, 10)),
    "F9 G19 G3 Y10 Z10 K10": (2, (0, 0, 10), 1, 90, (0, 10, 10)),
    "F9 G19 G2 Y10 J5 X2 P3": (2, (0, 5, 0), -3, -900, (2, 10, 0)),
    # measured tolerances
    "F9 G2 X10.0282 I5": (0, (5, 0, 0), -1, -180, (10.0282, 0, 0)),
    "F9 G2 X20002.82 I10000": (0, (10000, 0, 0), -1, -180, (20002.82, 0, 0)),
    "F9 G2 X2000.15 I1000": (0, (1000, 0, 0), -1, -180, (2000.15, 0, 0)),
    "F9 G2 X10 R4.999": (0, (5, 0, 0), -1, -180, (10, 0, 0)),
    "F9 G2 X10 R-4.999": (0, (5, 0, 0), -1, -180, (10, 0, 0)),
    # under G20 the tolerance is 0.002828 in (0.0718 mm)
    "F9 G20 G2 X2.0028 I1": (0, (25.4, 0, 0), -1, -180, (50.87112, 0, 0)),
}


@pytest.mark.parametrize("program", ARCS)
def test_arcs(view, program):
    plane, center, turns, sweep, end = ARCS[program]
    moves, findings = view(program + "\nM2")
    assert findings == ()
    assert moves.arc.tolist()[-1] == len(moves.arcs.plane) - 1 == 0
    assert (moves.arcs.plane[0], moves.arcs.turns[0]) == (plane, turns)
    assert moves.arcs.center[0] == pytest.approx(center, abs=1e-9)
    assert moves.arcs.sweep[0] == pytest.approx(sweep, abs=0.2 if "R4.999" in program or "R-4.999" in program else 1e-9)
    assert moves.end[-1, :3] == pytest.approx(end, abs=1e-9)
    assert moves.feed[-1] == 9.0


def test_rotary_axes_go_along_with_an_arc(moves_text):
    assert moves_text("F9 G3 X10 I5 A10 C-20\nM2") == ["1 arc X10 A10 C-20 F9"]


# --- modes that are columns or tables of their own ---------------------------------------------------


def test_feed_per_revolution(view):
    moves, _findings = view("S1000 M3 G95 F.1 G1 X1\nM4 S500 X2\nM5 G94 F60 X3\nG20\nG95 F1 X4\nM2")
    assert moves.feed.tolist() == pytest.approx([0.1, 0.1, 60.0, 25.4], abs=1e-12)
    assert moves.feed_mode.tolist() == [FeedMode.PER_REVOLUTION] * 2 + [FeedMode.PER_MINUTE, FeedMode.PER_REVOLUTION]
    assert moves.spindle.tolist() == [1000.0, 500.0, 0.0, 0.0]


@pytest.mark.parametrize(("word", "control"), [
    ("", PathControl(PathMode.BLEND, None, None)),
    ("G61", PathControl(PathMode.EXACT_PATH)),
    ("G61.1", PathControl(PathMode.EXACT_STOP)),
    ("G61 G0\nG64", PathControl(PathMode.BLEND, None, None)),
    ("G64 P.02", PathControl(PathMode.BLEND, 0.02, 0.02)),
    ("G64 P.02 Q.5", PathControl(PathMode.BLEND, 0.02, 0.5)),
    ("G64 P.02 Q0", PathControl(PathMode.BLEND, 0.02, 0.0)),
    ("G20 G64 P.01 Q1", PathControl(PathMode.BLEND, 0.254, 25.4)),
])  # fmt: skip
def test_path_control(view, word, control):
    moves, findings = view(f"{word}\nG0 X1\nM2")
    assert findings == ()
    assert moves.controls[moves.control[-1]] == control


def events_of(moves):
    return [(event.line, event.before, event.kind, event.data) for event in moves.events]


def test_events_come_in_order_of_execution(view):
    moves, findings = view(
        "G1 X1 M0 M8 F100 M3 S500 M6 T1 (MSG, go)\nM5 G0 X2 M9\nM7\nM4 S20 G4 P1\nM1\nM60\nG0 X3 M30"
    )
    assert findings == ()
    assert events_of(moves) == [
        (1, 0, "message", {"text": " go"}),
        (1, 0, "tool", {"number": 1}),
        (1, 0, "spindle", {"direction": "clockwise", "speed": 500.0}),
        (1, 0, "coolant", {"state": "flood"}),
        (1, 1, "stop", {"stop": "program"}),
        (2, 1, "spindle", {"direction": "stop", "speed": 500.0}),
        (2, 1, "coolant", {"state": "off"}),
        (3, 2, "coolant", {"state": "mist"}),
        (4, 2, "spindle", {"direction": "counterclockwise", "speed": 20.0}),
        (5, 3, "stop", {"stop": "optional"}),
        (6, 3, "stop", {"stop": "pallet"}),
        (7, 4, "end", {"code": "M30"}),
    ]
    assert moves.spindle.tolist() == [500.0, 0.0, 20.0, 20.0]  # M6 on line 1 stops the spindle before M3 starts it


def test_g96_is_an_event_and_g97_ends_it(view):
    """As in LinuxCNC: S in the block of G96, D the most turns a minute; the same S then is 1/min again."""
    moves, findings = view("G21 G96 D-2500 S100 M3\nG0 X1\nS120\nG97\nG1 F9 X2\nG20\nG96 S50\nM5\nM2", dialect="rs274")
    assert findings == ()
    modes = [event.data for event in moves.events if event.kind == "spindle mode"]
    assert modes == [
        {"code": "G96", "speed": 100.0, "unit": "m/min", "most_per_minute": 2500.0},
        {"code": "G97"},
        {"code": "G96", "speed": 50.0, "unit": "ft/min"},
    ]
    speeds = [
        (event.line, event.data["speed"], event.data.get("unit")) for event in moves.events if event.kind == "spindle"
    ]
    assert speeds == [(1, 100, "m/min"), (3, 120, "m/min"), (4, 120, None), (7, 50, "ft/min"), (8, 50, "ft/min")]
    assert moves.spindle.tolist() == [0.0, 120.0]  # not known while G96 holds
    assert [(item.code, item.line) for item in moves.findings] == [("VP045", 1), ("VP045", 7)]


@pytest.mark.parametrize(
    ("program", "code", "line"),
    [("G96", "VP005", 1), ("G96 D5", "VP005", 1), ("G97 D5", "VP006", 1), ("G96 S-5", "VP007", 1)],
)
def test_g96_needs_s(view, program, code, line):
    found = view(f"{program}\nG0 X1\nM2", dialect="rs274")[1]
    assert [(item.code, item.line) for item in found] == [(code, line)]


def test_a_tool_change_stops_the_spindle(view):
    assert view("M3 S100 G0 X1\nM6 T1\nX2\nM2")[0].spindle.tolist() == [100.0, 0.0]


@pytest.mark.parametrize(("line", "text"), [
    ("(MSG,Hello  World )", "Hello  World "), ("(msg, x)", " x"), ("G0 X1 (mSg,late)", "late"), ("(a)(MSG,b)", "b"),
    ("(MSG,a)(b)", None), ("; (MSG,x)", None), ("( MSG,x)", None), ("(M S G,x)", None), ("(MSGx)", None),
    ("(DEBUG,x)", "x"), ("(MSG,\u00e4\u2713)", "\u00e4\u2713"),
    ("(MSG,x) ; remark", "x"), (";MSG,x", None),
])  # fmt: skip
def test_messages(view, line, text):
    moves, findings = view(f"{line}\nM2")
    assert findings == ()
    messages = [event.data["text"] for event in moves.events if event.kind == "message"]
    assert messages == ([] if text is None else [text])


def test_frames_of_moves(view):
    """Every row knows what lies between its numbers and the machine."""
    moves, _findings = view("G0 X1\nG10 L2 P2 X5 R30\nG55 G43 H1\nG92 Y2\nG0 X3\nG54\nX4\nM2")
    frames = [moves.frames[index] for index in moves.frame]
    assert [frame.system for frame in frames] == [1, 2, 1]
    assert [frame.turn for frame in frames] == [0.0, 30.0, 0.0]
    assert [frame.tool_length for frame in frames] == [0.0, 10.0, 10.0]
    assert [frame.origin[0] for frame in frames] == [0.0, 5.0, 0.0]
    assert frames[0].g92 == (0.0,) * 9
    assert frames[1].g92 == frames[2].g92 != frames[0].g92
    # machine = R (program + G92) + origin + tool stays where it is while frames change
    machine = []
    for end, frame in zip(moves.end, frames, strict=True):
        turn, (x, y, z) = np.radians(frame.turn), (end + np.array(frame.g92))[:3]
        c, s = np.cos(turn), np.sin(turn)
        machine.append(np.array([c * x - s * y, s * x + c * y, z]) + frame.origin[:3] + np.array(frame.tool[:3]))
    assert machine[0] == pytest.approx([1, 0, 0], abs=1e-12)
    assert machine[1][2] == pytest.approx(0.0, abs=1e-12)
    assert machine[2][1:] == pytest.approx(machine[1][1:], abs=1e-12)


# --- errors -------------------------------------------------------------------------------------------

#: Finding code, line:column, program (a bar for a new line; M2 is added at its end). LinuxCNC refuses them too,
#: but for words that only this version lacks.
ERRORS = """
# text
VP001 1:8   G0 X1.2.3
VP001 1:2   X
VP001 1:7   G0 X1 (open
VP001 1:4   (a (b) c)
VP001 1:5   G0 X(c)1
VP001 1:1   5
VP001 1:4   G0 &1
VP001 1:4   G0 / X1
VP001 1:4   G0 %
VP001 1:4   G0 N1 X1
VP001 1:4   G0 O1
VP001 1:6   G0 X1)
VP001 2:5   %|G0 X%1
VP005 1:1   X1e3
VP006 1:6   G0 X1e3
VP001 1:5   G0 X½
# parameters and expressions
VP001 1:4   G0 #1
VP001 1:9   G0 X[1+2
VP001 1:6   G0 X[]
VP001 1:7   G0 X[1(c)]
VP001 1:4   #1=
VP001 1:4   #1=X
VP001 1:2   #=1
VP001 1:1   #<a=1
VP001 1:2   #<>=1
VP001 1:4   #1=FOO[1]
VP001 1:8   #1=SIN 30
VP001 1:11  #1=ATAN[1]
VP001 1:10  #1=EXISTS[1]
VP001 1:13  #1=EXISTS[#1+2]
VP025 1:12  #1=EXISTS[#1.5]
VP007 1:6   #1=[1/0]
VP007 1:7   #1=[5 MOD 0]
VP007 1:7   #1=[-8**[1/3]]
VP007 1:4   #1=SQRT[-1]
VP007 1:4   #1=LN[0]
VP007 1:4   #1=ACOS[1.0000001]
VP007 1:4   #1=EXP[1000]
VP007 1:5   G0 X[2**200]
VP025 1:5   G0 X#<foo>
VP025 1:5   G0 X#0
VP025 1:1   #5602=1
VP025 1:2   #1.5=1
VP025 1:1   #<_x>=1
VP025 1:1   #5420=1
VP025 1:5   G0 X#<_ini[a]b>
VP025 1:5   G0 X#5021
# O words
VP023 1:1   o1 call
VP023 1:1   o1 endsub
VP023 1:1   o1 if [1]
VP023 3:1   o1 if [1]|o2 while [0]|o1 endif|o2 endwhile
VP023 2:1   o1 while [0]|o2 break|o1 endwhile
VP023 1:4   o1 fi
VP023 3:1   o1 sub|o1 endsub|o1 sub|o1 endsub|o1 call
VP023 1:5   M98 P1
VP023 1:1   o1 sub|M98 P1
VP001 1:11  o1 if [1] G0 X1|o1 endif
VP001 1:13  o1 repeat [2|o1 endrepeat
VP024 1:1   M99
# polar words
VP017 1:4   G0 @1
VP003 1:4   G0 @1 ^2 X1
VP017 1:8   G18 G0 @1 ^2
# codes
VP002 1:1   G12
VP002 1:4   G0 G5.4 X1
VP002 1:1   G-1
VP002 1:1   G1.05
VP002 1:1   G90.5
VP002 1:1   M200
VP002 1:1   M10
VP007 1:1   M3.1
VP007 1:1   M-3
VP005 1:1   M98
VP002 1:5   G10 L12 P1 Z1
VP002 1:1   G38.2 Z1
VP002 1:1   G33 K1
VP002 1:1   G76
VP002 1:1   M101
VP002 1:7   G0 G7 X1
VP002 1:1   G17.1
VP005 1:1   G43.2
VP005 1:1   M67 E0
# modal groups
VP003 1:4   G0 G1 X1
VP003 1:8   G90 X1 G91
VP003 1:5   G20 G21
VP003 1:5   G54 G59.1
VP003 1:5   G93 G94
VP003 1:4   M7 M8
VP003 1:4   M0 M2
VP003 1:8   G43 H1 G49
VP003 1:4   M3 M3
VP004 1:11  G0 X1 G92 X2
VP003 1     G0 G92 X2
VP003 1     G28 G1 X1 F1
VP003 1     G10 L2 P1 G0 X1
VP003 1:7   G4 P1 G28
VP003 1:5   G61 G64
VP003 1:5   G17 G18
VP003 1     M0 M6 M3 M8 M48
# words
VP004 1:10  G0 X1 Y2 X3
VP004 1:4   F1 F2
VP004 1:8   G10 L2 L2 P1
VP005 1:1   X1
VP005 2:1   G80|X1
VP005 1:1   G4
VP005 1:1   G92
VP005 1:1   G52
VP005 1:1   G10 P1 X1
VP005 1:1   G10 L2 X1
VP005 1     F9 G2 X1
VP005 1     F9 G90.1 G2 X2 I1
VP006 1:5   G80 X1
VP006 1:7   G0 X1 P2
VP006 1:1   H1
VP006 1:4   G0 D1
VP006 1:10  G1 X1 F1 R2
VP006 1:5   G43 P1
VP006 1     F9 G2 X1 K1
VP006 1     F9 G18 G2 X1 J1
VP006 1:7   G4 P1 Q1
VP006 1:12  G10 L20 P1 R3
VP006 1:11  G10 L2 P1 I1
VP006 1:1   E1
VP006 1:5   G49 H1
VP006 1:4   M3 Q1
# numbers
VP007 1:1   F-1
VP007 1:1   S-5
VP007 1:4   G4 P-1
VP007 1:1   T1.5
VP007 1:1   T-1
VP007 1:1   N-1 G0
VP007 1:8   G10 L2 P10 X1
VP007 1:5   G43 H1.5
VP007 1:14  F9 G2 X1 I.5 P0
VP007 1:14  F9 G2 X1 I.5 P1.5
VP007 1:8   G10 L1 P0 Z1
VP007 1:5   G43 H-1
# arcs
VP008 1:13  F9 G2 X0 Y0 R5
VP008 1:11  F9 G2 X10 R4
VP008 1:11  F9 G2 X10 R4.998
VP008 1     F9 G2 X10.0284 I5
VP008 1     F9 G2 X20002.84 I10000
VP008 1     F9 G20 G2 X.40284 I.2
VP008 1     F9 G20 G2 X2.003 I1
VP008 1     F9 G2 X0.001 I.0005
VP008 1     F9 G2 I0 J0
VP008 1     F9 G2 X2001.1 I1000
VP003 1:14  F9 G2 X10 I5 R5
# feed
VP009 1     G1 X1
VP009 3     F5 G1 X1|F0|X2
VP009 2     F9 G93|G1 X1
VP009 1     G2 X2 I1
VP009 3     G93|F2|G1 X1
VP009 2     G93 G1 X1 F1|X2
VP009 2     F9 G1 X1|G95 X2
VP009 3     G93 G1 X1 F1|G94|X2
VP009 2     S1 M3 G95 F1 G1 X1|G94 X2
VP009 2     G0 X0 Y0 Z5|G81 Z-1 R1
# tools, machine coordinates
VP012 1:1   T9
VP012 1:5   G43 H9
VP005 1:5   G53 X1
VP017 1     F9 G53 G2 X1 I.5
VP017 1     G91 G53 G0 X1
VP017 2     G91|G0 G53 X1
VP017 1     G53
VP017 3     G1 X1 F1|G2 X2 I.5|G53 X1
# stricter than LinuxCNC
VP003 1     G1 G43.1 Z5 F1
VP007 1:8   G10 L2 P1.5 X1
VP009 1     G93 G1 X1 F0
# refused by one rule each
VP023 1:2   O1.5 if [1]
VP007 1:4   G4 P90000
VP007 1:6   #1=[0**[-1]]
VP023 1:1   o1 return
VP023 1:1   o[1] if [1]
VP023 2:1   o1 sub|o2 sub|o2 endsub|o1 endsub
VP023 1:5   M98 P1|o1 sub|o1 endsub
VP005 1:1   G43.2
VP005 1:1   M61
VP012 1:5   M61 Q9
VP005 1:1   M66 L0
VP007 1:8   M66 P1 L9
VP007 1:8   M66 E1 L3
VP005 1:1   M66 P1 L3
VP007 1:5   G64 P-1
VP006 1:14  G10 L1 P1 Z5 I3
VP005 1:1   G5.2 F9 X1 P1
"""


def error_table():
    """Rows of ERRORS as program, code, line and column."""
    table = []
    for row in ERRORS.splitlines():
        if row and not row.startswith("#"):
            code, place, program = re.split(" +", row, maxsplit=2)
            line, _, column = place.partition(":")
            table.append((program.replace("|", "\n"), code, int(line), int(column) if column.isdigit() else None))
    table.append(("o1 call" + 31 * " [1]", "VP023", 1, 1))  # a call gives 30 values at most
    return table


@pytest.mark.parametrize(("program", "code", "line", "column"), error_table())
def test_errors(view, program, code, line, column):
    moves, findings = view(f"{program}\nM2")
    assert [(item.code, item.line, item.column) for item in findings] == [(code, line, column)]
    item = findings[0]
    assert (item.severity, item.last_line, item.worst_line) == ("error", item.line, item.line)
    assert len(item.message) > 10
    assert not len(moves) or moves.line.max() < item.line


@pytest.mark.parametrize("program", ["\u017f100", "\u01315 G2 F9 X10", "G0 X1\nT1 \ufb063"])
def test_letters_are_ascii(view, program):
    """Letters whose upper case is made of ASCII letters: long s, dotless i, the ligature st."""
    assert [item.code for item in view(f"{program}\nM2")[1]] == ["VP001"]


@pytest.mark.parametrize(
    ("program", "line"),
    [
        ("G0 X1\nX2", 2),
        ("%\nG0 X1\n", 2),
        ("%\nG0 X1\n%%\n", 3),
        ("G0 X1\n%\n", 2),
        ("G0 X1 (M2)\n; M30\n", 2),
        ("/M2", None),
    ],
)
def test_programs_that_do_not_end(view, program, line):
    _moves, findings = view(program, block_delete=line is None)
    assert len(findings) == 1
    assert findings[0].code in ("VP010", "VP001")
    assert findings[0].line == (line or 1)


# --- all errors at once: the door for those who need a whole program -----------------------------------


def codes_and_lines(source):
    with pytest.raises(InputError) as caught:
        interpret_plainly(source)
    return [(item.code, item.line) for item in caught.value.findings]


def test_every_error_is_reported():
    source = b"G0 X1 X2\nG1 X1\nF5\nX3 (\nG12\nX4\nQ1\nM2\n"
    wanted = [("VP004", 1), ("VP009", 2), ("VP001", 4), ("VP002", 5), ("VP006", 7)]
    assert codes_and_lines(source) == wanted
    assert codes_and_lines(source.replace(b"M2\n", b"")) == [*wanted, ("VP010", 7)]


@pytest.mark.parametrize("code", ["G31", "G38.2"])
def test_a_probe_of_any_control_is_named(code):
    """G31 is a probe of Fanuc and Mach3, whose programs are read in this language too."""
    with pytest.raises(InputError) as caught:
        interpret_plainly(f"{code} Z-5 F100\nM2\n".encode())
    assert f"not executed: {code} (probing: " in caught.value.findings[0].message


def test_a_file_of_errors_is_given_up():
    text = b"".join(b"Q%d\n" % n for n in range(1000))
    assert codes_and_lines(text) == [("VP006", line) for line in range(1, 51)]
    with pytest.raises(InputError) as caught:
        interpret_plainly(b"Q1\n" * 9999)
    assert [(item.code, item.last_line, item.count) for item in caught.value.findings] == [("VP006", 1000, 1000)]


def test_a_program_is_read_alone():
    moves = interpret_plainly(b"/G0 X1\nG0 X2\nM2", block_delete=True)
    assert moves.end[:, 0].tolist() == [2.0]
    assert moves.start.tolist() == [0.0] * 9
    assert interpret_plainly(b"T1 M6\nG0 G43 H1 Z5\nM2", tools={1: (100, 8)}).frames[-1].tool_length == 100.0
