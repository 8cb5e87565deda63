"""Cutter compensation: the centre keeps its distance from the programmed contour. Measured on the curves themselves."""

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import verne_post as vp
from verne_post.model.moves import MoveKind

SETTINGS = settings(max_examples=60, deadline=None, database=None, derandomize=True)


def points(moves, start):
    """Points along the moves in XY, from ``start`` on, 0.05 mm or closer."""
    place, found = np.array(start), []
    for i in range(len(moves)):
        end = moves.end[i, :2]
        if moves.kind[i] == MoveKind.ARC:
            row = moves.arc[i]
            center, sweep = moves.arcs.center[row, :2], math.radians(moves.arcs.sweep[row])
            r0, r1 = place - center, end - center
            first = math.atan2(r0[1], r0[0])
            u = np.linspace(0, 1, max(2, int(abs(sweep) * np.hypot(*r0) / 0.05)))
            radius = np.hypot(*r0) + u * (np.hypot(*r1) - np.hypot(*r0))
            found.append(
                center + radius[:, None] * np.stack([np.cos(first + u * sweep), np.sin(first + u * sweep)], axis=-1)
            )
        else:
            u = np.linspace(0, 1, max(2, int(np.hypot(*(end - place)) / 0.05)))[:, None]
            found.append(place + u * (end - place))
        place = end
    return found


@st.composite
def contours(draw):
    """Entry, then moves of 30 mm and quarter circles of 18 mm with corners between 20 and 120 degrees."""
    heading, x, y = math.radians(draw(st.integers(0, 359))), 0.0, 0.0
    start = (-40 * math.cos(heading), -40 * math.sin(heading))
    lines = []
    for _ in range(draw(st.integers(1, 5))):
        heading += math.radians(draw(st.integers(20, 120)) * draw(st.sampled_from([1, -1])))
        c, s = math.cos(heading), math.sin(heading)
        side = draw(st.sampled_from([0, 0, 1, -1]))
        if side:
            i, j = -18 * side * s, 18 * side * c
            x, y, heading = x + i + 18 * c, y + j + 18 * s, heading + side * math.pi / 2
            lines.append(f"G{3 if side > 0 else 2} X{x:.9f} Y{y:.9f} I{i:.9f} J{j:.9f}")
        else:
            x, y = x + 30 * c, y + 30 * s
            lines.append(f"G1 X{x:.9f} Y{y:.9f}")
    return start, lines


@SETTINGS
@given(contours(), st.sampled_from(["G41.1", "G42.1"]), st.integers(2, 9))
def test_the_centre_keeps_its_distance(view, contour, code, diameter):
    (x, y), lines = contour
    head, body = f"F100 G0 X{x:.9f} Y{y:.9f}\n", "G1 X0 Y0\n" + "\n".join(lines)
    moves, findings = view(f"{head}{code} D{diameter}\n{body}\nG40\nG0 Z9\nM2", dialect="rs274")
    if findings:
        assert findings[0].code == "VP026"  # a corner into which the tool does not reach
        return
    plain, _ = view(f"{head}{body}\nM2", dialect="rs274")
    programmed = points(plain, (0, 0))[2:]  # without the way to the start, and the entry
    centre = points(moves, (0, 0))[2:-1]
    path = np.concatenate(centre)
    radius = diameter / 2
    for k, segment in enumerate(programmed):
        gap = cKDTree(segment).query(path)[0]
        # a longer contour, or one with two arcs, may come near itself, which no control looks for
        if len(lines) == 1 or (len(lines) == 2 and not any("I" in line for line in lines)):
            assert gap.min() > radius - 0.002  # 0.05 mm between points: a chord's sag of 0.0006
        beside = np.sort(np.abs(gap - radius))
        # corners on both sides may take most of a segment away; a twentieth of it, 1.5 mm, is always left
        assert beside[: len(segment) // 20].max() < 0.002, f"segment {k} is left"


def test_left_and_right(view):
    for code, y in (("G41.1", 2.0), ("G42.1", -2.0)):
        moves, findings = view(f"F9 G0 X-10\n{code} D4\nG1 X0\nX10\nX20\nG40\nG0 X30\nM2", dialect="rs274")
        assert findings == ()
        assert moves.end[1:4, 1].tolist() == [y, y, y]
        assert moves.end[-1, :2].tolist() == [30.0, 0.0]


def test_outside_corners_are_rounded_about_the_corner_and_inside_ones_shortened(view):
    moves, _ = view("F9 G0 X-10\nG41.1 D4\nG1 X0\nX10\nY-10\nX20\nG40 G0 Z5\nM2", dialect="rs274")
    arc = moves.arc[3]
    assert moves.kind[3] == MoveKind.ARC
    assert moves.arcs.center[arc, :2].tolist() == [10.0, 0.0]
    assert moves.arcs.sweep[arc] == pytest.approx(-90.0)
    assert moves.end[3:6, :2].round(9).tolist() == [[12, 0], [12, -8], [20, -8]]


def test_the_tool_table_has_the_diameter(view):
    moves, _ = view("F9 G0 X-10\nG41 D1\nG1 X0\nX10\nG40 G0 Z5\nM2", dialect="rs274")  # T1 is 6 mm wide
    assert moves.end[1, :2].tolist() == [0.0, 3.0]


def test_a_negative_diameter_changes_the_side_and_none_stays_on_the_contour(view):
    def ends(code):
        moves, findings = view(f"F9 G0 X-10\n{code}\nG1 X0\nX10\nG3 X10 Y20 J10\nG1 Y9\nG40 G0 Z5\nM2", dialect="rs274")
        assert findings == ()
        return moves.end[:, :3].tolist()

    assert ends("G42.1 D-4") == ends("G41.1 D4")
    assert ends("G41.1 D0") == [[-10, 0, 0], [0, 0, 0], [10, 0, 0], [10, 20, 0], [10, 9, 0], [10, 9, 5]]


@pytest.mark.parametrize(("code", "entry", "end", "center", "sweep"), [
    # a quarter from (10, 40) about (20, 40) to (20, 30): the tool ends 5 mm inside, or outside of its end, in its
    # direction
    ("G41.1 D10", "G3 X20 Y30 I10", (20, 35), (20, 47.5), math.degrees(math.atan2(10, 7.5))),
    ("G41.1 D10", "G3 X20 Y30 R10", (20, 35), (20, 47.5), math.degrees(math.atan2(10, 7.5))),
    ("G41.1 D10", "G3 X20 Y30 I10 P2", (20, 35), (20, 47.5), 360 + math.degrees(math.atan2(10, 7.5))),
    ("G42.1 D10", "G3 X20 Y30 I10", (20, 25), (20, 25 + 65 / 6), 180 - math.degrees(math.atan2(60, 25))),
    ("G41.1 D0", "G3 X20 Y30 I10", (20, 30), (20, 40), 90),
    ("G42.1 D10", "G2 X20 Y50 I10", (20, 45), (20, 32.5), -math.degrees(math.atan2(10, 7.5))),
])  # fmt: skip
def test_an_arc_leads_onto_the_contour(view, code, entry, end, center, sweep):
    """As in LinuxCNC: the centre goes on an arc from where the tool is, which ends beside the programmed one in its
    direction.
    """
    way = 1 if end[1] < 40 else -1
    moves, findings = view(f"F9 G0 X10 Y40\n{code}\n{entry}\nG1 X40\nY{40 - 50 * way}\nG40\nG0 Z5\nM2", dialect="rs274")
    assert findings == ()
    assert moves.kind[1] == MoveKind.ARC
    assert moves.end[1, :2] == pytest.approx(end)
    assert moves.arcs.center[0, :2] == pytest.approx(center)
    assert moves.arcs.sweep[0] == pytest.approx(sweep)
    assert moves.end[2, 1] == pytest.approx(end[1])  # the line goes on beside the contour


def test_other_controls_begin_compensation_on_a_straight_move(view):
    """Fanuc and Siemens refuse an arc as first move."""
    for dialect, code in (("fanuc", "G41 D1"), ("siemens", "G41")):
        found = view(f"T1 M6\nG0 X10. Y40. F9.\n{code}\nG3 X20. Y30. I10. J0.\nG40\nG0 Z5.\nM30", dialect=dialect)[1]
        assert [(item.code, item.line) for item in found] == [("VP026", 4)], dialect


def test_an_arc_that_touches_the_offset_line_is_reached_however_its_numbers_round(view):
    # the offset circle (radius 15 about 0, 0) touches the offset line X15; a 9th decimal makes them miss each other
    for y in (-17.320508075, -17.320508076):
        moves, findings = view(
            f"F9 G0 X10 Y40\nG41.1 D10\nG1 Y0\nY{y}\nG3 X-10 Y17.320508076 I-10 J{-y}\nG40\nG1 X-50\nM2",
            dialect="rs274",
        )
        assert findings == ()
        assert moves.end[2, :2] == pytest.approx([15.0, 0.0], abs=1e-3)


def test_moves_off_the_plane_follow_their_amended_corner(view):
    moves, _ = view("F9 G0 X-10\nG41.1 D4\nG1 X0\nX10\nZ-3\nY10\nG40 G0 Z5\nM2", dialect="rs274")
    assert moves.end[2:5, :3].round(9).tolist() == [[8, 2, 0], [8, 2, -3], [8, 10, -3]]


@pytest.mark.parametrize(("program", "code", "line"), [
    ("G41.1 D9\nG1 X4", "VP026", 3), ("G41.1 D12\nG2 X4 Y4 I4", "VP026", 3), ("G41.1 D15\nG3 X8 Y4 J10", "VP026", 3),
    ("G41.1 D11\nG3 X6 Y2 J10", "VP026", 3), ("G41.1 D9\nG1 X20\nA5", "VP026", 4),
    ("G41.1 D9\nG1 X20\nX21\nY30", "VP026", 5), ("G41.1 D30\nG1 X20\nG3 X30 Y10 J10", "VP026", 4),
    ("G41.1 D2\nG1 X20\nX30\nG40\nG2 X40 I5", "VP026", 6), ("G41.1 D2\nG41.1 D2", "VP017", 3),
    ("G19 G41.1 D2", "VP017", 2),
    ("G41.1 D2\nG55", "VP017", 3), ("G41.1 D2\nG92 X5", "VP017", 3), ("G41.1 D2\nG53 G0 X5", "VP017", 3),
    ("G41.1 D2\nG28 X5", "VP017", 3), ("G41.1 D2\nG43 H1", "VP017", 3), ("G41.1 D2\nG18", "VP017", 3),
    ("G41.1 D2\nM6", "VP017", 3),
    ("G41.1 D2\nG81 Z-1 R1 X1", "VP017", 3), ("G93 G41.1 D2", "VP017", 2), ("G41.1", "VP005", 2),
    ("G41 D7", "VP012", 2),
    ("G41", "VP012", 2),
])  # fmt: skip
def test_refused(view, program, code, line):
    found = view(f"F9 G0 X0\n{program}\nM2", dialect="rs274")[1]
    assert [(item.code, item.line) for item in found] == [(code, line)]


def test_feed_per_turn_holds_beside_the_contour(view):
    moves, findings = view("S100 M3 F9 G0 X0\nG95 F0.2\nG41.1 D4 G1 X10\nX20\nY-10\nM2", dialect="rs274")
    assert findings == ()
    assert moves.end[1:, :2].round(9).tolist() == [[10, 2], [20, 2], [22, 0], [22, -10]]
    assert moves.feed[1:].tolist() == [0.2] * 4


BESIDE = "T1 M6\nF9 G0 X20 Y20\nG41 G0 X10\nG1 Y10\nG40\n"  # T1 is 6 mm wide: it stands at X13


@pytest.mark.parametrize(
    ("change", "x"), [("M6 T2", 13.0), ("M61 Q2", 13.0), ("G92 X5\nM6 T2", 8.0), ("G10 L2 P1 X4\nM6 T2", 9.0)]
)
def test_a_change_of_tool_after_a_contour_takes_the_position_of_the_tool(view, change, x):
    moves, findings = view(f"{BESIDE}{change}\nG0 Z5\nM2", dialect="rs274")  # rs274's own answers
    assert findings == ()
    assert moves.end[-1, :3] == pytest.approx([x, 10.0, 5.0])


def test_without_a_change_of_tool_the_next_move_goes_to_the_contour(view):
    moves, _ = view(f"{BESIDE}G0 Z5\nM2", dialect="rs274")
    assert moves.end[-1, :3].tolist() == [10.0, 10.0, 5.0]


@pytest.mark.parametrize("end", [-20.0, 35.0, -75.0])
@pytest.mark.parametrize(("word", "side"), [("G41.1", 1.0), ("G42.1", -1.0)])
def test_an_arc_as_entry_ends_beside_its_end_in_its_direction(view, word, side, end):
    """About X6 Y8 from X0 Y0, counter-clockwise; the tool's centre comes from where it stands, on an arc about another
    place.
    """
    centre, inwards = np.array([6.0, 8.0]), -np.array([np.cos(np.radians(end)), np.sin(np.radians(end))])
    last = centre - 10.0 * inwards
    text = f"G21 G90 G94 F600\nG0 X0 Y0 Z5 A0 C0\n{word} D3 G3 X{last[0]:.9f} Y{last[1]:.9f} I6 J8\nM2"
    moves, findings = view(text, dialect="rs274")
    assert findings == ()
    target = last + side * 1.5 * inwards  # left of an arc to the left is towards its middle
    row = int(np.flatnonzero(moves.arc >= 0)[-1])
    assert moves.end[row][:2] == pytest.approx(target, abs=1e-6)
    middle = moves.arcs.center[moves.arc[row]][:2]
    assert np.linalg.norm(middle) == pytest.approx(np.linalg.norm(middle - target), abs=1e-6)
    assert float((middle - target) @ [-inwards[1], inwards[0]]) == pytest.approx(0.0, abs=1e-6)
    assert float((middle - target) @ inwards) > 0.0


#: Two lines and a rounded corner, whose centre is to the right: the tool (T1, 6 mm) belongs to their left.
ROUNDED = {
    "fanuc": "T1 M6\nG0 X-20. Y-20. F500.\n{side} D1 G1 X0 Y-10.\nY28.\n{sense} X2. Y30. {at}\nG1 X26.\nG40 Y50.\nM30",
    "siemens": "{mirror}\nT1 D1 M6\nG0 X-20 Y-20 F500\n{side} G1 X0 Y-10\nY28\n{sense} X2 Y30 {at}\nG1 X26\n"
    "G40 Y50\nM30",
    "heidenhain": "BEGIN PGM A MM\nTOOL CALL 1 Z S9\nL X-20 Y-20 Z+0 R0 FMAX\nL X+0 Y-10 {side} F500\nL Y+28\n{at}\n"
    "L X+26\nL Y+50 R0\nEND PGM A MM",
}


@pytest.mark.parametrize(("dialect", "words", "question"), [
    ("fanuc", {"side": "G41", "sense": "G2", "at": "R2."}, ""),
    ("fanuc", {"side": "G42", "sense": "G2", "at": "R2."}, "with G41 in line 3 the tool fits: is the side right?"),
    ("fanuc", {"side": "G41", "sense": "G3", "at": "R2."}, "is G2 meant?"),
    ("fanuc", {"side": "G41", "sense": "G3", "at": "I2. J0"}, "is G2 meant?"),
    ("siemens", {"side": "G42", "sense": "G2", "at": "CR=2", "mirror": ""},
     "with G41 in line 4 the tool fits: is the side right?"),
    ("siemens", {"side": "G42", "sense": "G2", "at": "CR=2", "mirror": "MIRROR X0"},
     "with G41 in line 4 the tool fits: is the side right?"),
    ("siemens", {"side": "G41", "sense": "G3", "at": "CR=2", "mirror": "MIRROR X0"}, "is G2 meant?"),
    ("heidenhain", {"side": "RR", "at": "CR X+2 Y+30 R+2 DR-"}, "with RL in line 4 the tool fits: is the side right?"),
    ("heidenhain", {"side": "RL", "at": "CR X+2 Y+30 R+2 DR+"}, "is DR- meant?"),
])  # fmt: skip
def test_a_swapped_side_and_a_swapped_sense_are_told_apart(view, dialect, words, question):
    """The other sense is asked for where only that is tangent to the line before, else the other side."""
    found = [item for item in view(ROUNDED[dialect].format(**words), dialect=dialect)[1] if item.code == "VP026"]
    said = [item.message for item in found]
    text = f"tool 1 (diameter 6 mm) is too wide for this arc, whose radius is 2 mm: {question}"
    assert said == ([text] if question else [])
    right = re.search(r"G([234]1?)|R[LR]|DR-", question)
    assert [one.value for item in found for one in item.edits] == ([right[1] or right[0]] if right else [])


@pytest.mark.parametrize(
    ("remark", "cutter", "doubt"),
    [
        ("(A)", 3.0, "; but its cutter among the tool shapes is 3 mm thick: with 3 mm the tool fits: "),
        ("(T1 D=3. FLAT END MILL)", 6.1, "; but the program's remark in line 1 names 3 mm: with 3 mm the tool fits: "),
        (
            "(T1 D=3. FLAT END MILL)",
            3.0,
            "; but its cutter among the tool shapes is 3 mm thick and the program's remark in "
            "line 1 names 3 mm: with 3 mm the tool fits: ",
        ),
        ("(A)", 8.0, "; but its cutter among the tool shapes is 8 mm thick: "),
        ("(T1 D=6. FLAT END MILL)", 6.1, None),
    ],
)
def test_another_diameter_of_the_tool_is_told_and_no_other_side(view, remark, cutter, doubt):
    text = f"{remark}\n{ROUNDED['fanuc'].format(side='G42', sense='G2', at='R2.')}"
    shapes = {1: (vp.Cylinder("cutter", cutter, 20.0), vp.Cylinder("holder", 30.0))}
    (found,) = view(text, dialect="fanuc", tool_shapes=shapes)[1]
    said = "tool 1 (diameter 6 mm) is too wide for this arc, whose radius is 2 mm"
    side = ": with G41 in line 4 the tool fits: is the side right?"
    assert found.message == (said + side if doubt is None else f"{said}{doubt}which diameter is right?")
    assert bool(found.edits) == (doubt is None)


@pytest.mark.parametrize(
    ("dialect", "side", "sense"),
    [
        ("fanuc", "G42", "R2."),
        ("siemens", "G42", "CR=2"),
        ("heidenhain", "RR", "CR X+2 Y+30 R+2 DR-"),
    ],
)
def test_no_other_side_is_proposed_where_the_entry_move_comes_from_this_one(view, dialect, side, sense):
    """With the other one it would cross the contour."""
    text = ROUNDED[dialect].format(side=side, sense="G2", at=sense, mirror="")
    for start, is_proposed in (("X-20", True), ("X20", False), ("X+20", False)):
        found = [one for one in view(text.replace("X-20", start), dialect=dialect)[1] if one.code == "VP026"]
        assert [bool(one.edits) for one in found] == [is_proposed]


@pytest.mark.parametrize("side", ["G41", "G42"])
def test_the_other_side_is_not_proposed_where_the_tool_does_not_fit_there_either(view, side):
    """Two turns in a slot of 5 mm, one to the left and one to the right."""
    text = f"T1 M6\nF500\nG0 X0 Y0\n{side} D1 G1 X0 Y20\nX30\nY25\nX0\nY30\nX30\nG40 Y50\nM30"
    said = [item for item in view(text, dialect="fanuc")[1] if item.code == "VP026"]
    assert len(said) == 1
    assert said[0].message.endswith("without cutting into the contour")
    assert said[0].edits == ()


def test_a_swapped_sense_is_told_at_the_line_after_the_arc(view):
    """A corner of 8 mm in a pocket, turned the wrong way: the next line is where the tool does not fit."""
    pocket = "T1 M6\nF500\nG0 X15 Y15\nG41 D1 G1 Y0\nX22\n{} X30 Y8 R8\nG1 Y9\nX20\nG40 Y15\nM2"
    (found,) = view(pocket.format("G2"), dialect="rs274")[1]
    assert (found.code, found.line) == ("VP026", 7)
    assert found.message.endswith("cutting into the contour: is G3 meant in line 6?")
    assert [(one.line, one.word, one.value) for one in found.edits] == [(6, ("G", 2.0), "3")]
    assert all("meant" not in item.message for item in view(pocket.format("G3"), dialect="rs274")[1])
