"""Coordinates of Fanuc: G68, G68.2, G68.3, G51, G51.1, G16, offsets; corners, cycles that keep words, fine boring.

Expected places are worked out by hand from the operator's manuals of Fanuc series 30i and 0i-MF (coordinate rotation,
scaling, programmable mirror image, polar coordinate command, tilted working plane, optional chamfering and corner R,
canned cycles).
"""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from verne_post import check
from verne_post.app.assemble import build_interpreter_setup
from verne_post.gcode.read import interpret_program
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

R2 = math.sqrt(2.0)


@pytest.fixture
def run(view):
    """Places (x, y, z) of the part after each move of some lines; refuses findings."""

    def read(text, *, before="G0 X0 Y0 Z0 S500 M3 F100", **options):
        source = "\n".join(["%", "O1", "G21 G90 G17", before, *text.split(" / "), "M30", "%"])
        moves, findings = view(source, dialect="fanuc", **options)
        assert findings == ()
        return moves

    return read


def places(moves, first=1):
    """Ends (n, 3) of moves in the coordinates of the part."""
    found = []
    for i in range(first, len(moves)):
        feature = moves.frames[moves.frame[i]].feature
        point = np.array(moves.end[i][:3])
        found.append(point if feature is None else feature.map_outside(point))
    return np.array(found)


@pytest.mark.parametrize(("text", "ends"), [
    # rotation: x' = cx + (x - cx) cos R - (y - cy) sin R
    ("G68 X0 Y0 R90 / G1 X10 Y0 / X10 Y5", [(0, 10, 0), (-5, 10, 0)]),
    ("G68 X10 Y10 R45. / G1 X10 Y20", [(10 - 10 / R2, 10 + 10 / R2, 0)]),
    # without X and Y about where the tool is; in G91 from there
    ("G0 X5 Y5 / G68 R90 / G91 G1 X10", [(5, 5, 0), (5, 15, 0)]),
    ("G68 X0 Y0 R90 / G91 G1 X10 / Y5", [(0, 10, 0), (-5, 10, 0)]),
    # G69 ends it; Z alone does not move X and Y
    ("G68 X0 Y0 R90 / G1 Z5 / X10 Y0 / G69 / G0 X1 Y2", [(0, 0, 5), (0, 10, 5), (1, 2, 5)]),
    # in G18 from Z to X about Y, in G19 from Y to Z about X
    ("G18 G68 Z0 X0 R90 / G1 Z10 X0", [(10, 0, 0)]), ("G19 G68 Y0 Z0 R90 / G1 Y10 Z0", [(0, 0, 10)]),
    # about a direction of space, and once more inside
    ("G68 X0 Y0 Z0 I1 J0 K0 R90 / G1 X1 Y2 Z3", [(1, -3, 2)]),
    ("G68 X0 Y0 Z5 I0 J1 K0 R90 / G1 X10 Y0 Z5", [(0, 0, -5)]),
    ("G68 X0 Y0 Z0 I1 J0 K0 R90 / G68 X0 Y0 Z0 I0 J0 K1 R90 / G1 X1 Y2 Z3", [(-2, -3, 1)]),
    # scaling: x' = c + P (x - c); each axis by its own; about where the tool is
    ("G51 X10 Y0 Z0 P2. / G1 X15 Y5 Z1 / X20", [(20, 10, 2), (30, 10, 2)]),
    ("G51 X0 Y0 Z0 I2. J0.5 K1. / G1 X10 Y10 Z10", [(20, 5, 10)]),
    ("G0 X4 Y4 Z4 / G51 P0.5 / G1 X8 Y0 Z4 / G50 / X1 Y1 Z1", [(4, 4, 4), (6, 2, 4), (1, 1, 1)]),
    ("G51 X0 Y0 Z0 P2. / G91 G1 X3", [(6, 0, 0)]),
    # mirror image: x' = 2 m - x, of the axes that are named; G50.1 ends them by name
    ("G51.1 X10 / G1 X15 Y5", [(5, 5, 0)]), ("G101 X10 / G1 X15 Y5", [(5, 5, 0)]),
    ("G101 X0 / G101 Y0 / G1 X15 Y5 / G100 X0 / X1 Y1", [(-15, -5, 0), (1, -1, 0)]),
    ("G51.1 X0 Y0 / G1 X15 Y5 / G50.1 X0 / X1 Y1 / G50.1 Y0 / Y2", [(-15, -5, 0), (1, -1, 0), (1, 2, 0)]),
    # mirror first, then scaling, then rotation, whose angle is reversed by a mirror image of one axis
    ("G51.1 X0 / G51 X0 Y0 Z0 P2. / G68 X0 Y0 R90. / G1 X10 Y0", [(0, 20, 0)]),
    ("G51.1 X0 / G68 X0 Y0 R90. / G1 X10 Y0", [(0, 10, 0)]),
    # the centre of G68 is scaled as well (5 to 10, then 20 about it), but not its angle; B-63944EN-2/02 p. 211
    ("G51 X0 Y0 Z0 P2. / G68 X5 Y0 R90. / G1 X10 Y0 Z10", [(10, 10, 20)]),
    ("G51 X0 Y0 Z0 P2. / G68 X5 Y0 R90. / G81 X10 Y0 Z-1 R2", [(0, 0, 4), (10, 10, 4), (10, 10, -2), (10, 10, 4)]),
    ("G51 X4 Y0 Z0 P.5 / G68 X8 Y2 R-90. / G1 X8 Y6", [(8, 1, 0)]),
    # and mirrored as its angle is: the image of (10 + 10 cos 30 + 5 sin 30, 5 + 10 sin 30 - 5 cos 30)
    ("G51.1 X0 / G68 X10 Y5 R30. / G1 X20 Y0", [(-12.5 - 5 * math.sqrt(3), 10 - 2.5 * math.sqrt(3), 0)]),
    # without words it is where the tool is, which is a place already
    ("G51 X0 Y0 Z0 P2. / G1 X5 Y0 / G68 R90. / X10 Y0", [(10, 0, 0), (10, 10, 0)]),
    # polar: X is the distance and Y the angle, which stay; in G91 the angle adds up
    ("G16 / G1 X10 Y90 / Y180 / X20 / G15 / X1 Y1", [(0, 10, 0), (-10, 0, 0), (-20, 0, 0), (1, 1, 0)]),
    ("G16 / G1 X10 Y0 / G91 Y90 / Y90", [(10, 0, 0), (0, 10, 0), (-10, 0, 0)]),
    ("G52 X100 / G16 / G1 X10 Y90", [(100, 10, 0)]),
])  # fmt: skip
def test_coordinates(run, text, ends):
    moves = run(text)
    at = places(moves)
    shift = np.array([100.0, 0, 0]) if "G52" in text else 0.0
    assert at + shift == pytest.approx(np.array(ends, dtype=float), abs=1e-9)


def test_the_angle_of_g68_without_a_point_counts_degrees_in_inches_too(run):
    moves = run("G20 / G68 X0 Y0 R30000 / G1 X1. Y0 Z0", control={"fanuc": {"decimal_point": "conventional"}})
    assert places(moves)[-1] == pytest.approx([25.4 * math.sqrt(0.75), 12.7, 0.0], abs=1e-9)


@pytest.mark.parametrize(("text", "center", "sweep"), [
    ("G51.1 X0 / G2 X10 Y10 I10 J0", (-10, 0), 90), ("G51.1 X0 Y0 / G2 X10 Y10 I10 J0", (-10, 0), -90),
    ("G51 X0 Y0 Z0 P2. / G2 X10 Y10 I10 J0", (20, 0), -90),
    ("G51.1 X0 / G2 X10 Y10 R10", (-10, 0), 90), ("G51 X0 Y0 Z0 P2. / G2 X10 Y10 R10", (20, 0), -90),
    ("G51 X0 Y0 Z0 I-1. J1. K1. / G3 X10 Y10 R10", (0, 10), -90),
])  # fmt: skip
def test_arcs_of_a_mirror_image_turn_the_other_way(run, text, center, sweep):
    moves = run(text)
    assert moves.arcs.center[0][:2] == pytest.approx(center, abs=1e-9)
    assert moves.arcs.sweep[0] == pytest.approx(sweep)


def test_modal_arcs_and_sides_of_compensation_follow_the_mirror_image(run):
    moves = run("G2 X10 Y10 I10 J0 / G51.1 Y0 / X20 Y-20 I0 J-10 / G50.1 Y0 / X30 Y10 I0 J-10")
    assert moves.arcs.sweep.tolist() == pytest.approx([-90, 90, -90])
    tools = {1: Tool(1, 1, (0.0,) * 9, 10.0)}
    plain = run("G41 D1 G1 X20 Y0 / Y20 / X40 / G40 X50 Y40", tools=tools)
    mirrored = run("G51.1 X0 / G41 D1 G1 X20 Y0 / Y20 / X40 / G40 X50 Y40", tools=tools)
    assert mirrored.end[:, 0] == pytest.approx(-plain.end[:, 0], abs=1e-9)
    assert mirrored.end[:, 1] == pytest.approx(plain.end[:, 1], abs=1e-9)


def test_a_circle_of_holes_in_polar_coordinates(run):
    written = run("G98 G81 X50 Y0 Z-5 R2 F80 / X0 Y50 / X-50 Y0", before="G0 X0 Y0 Z20 F100")
    for polar in ("G16 / G81 X50 Y0 Z-5 R2 F80 / Y90 / Y180", "G16 / G81 X50 Y0 Z-5 R2 F80 / G91 Y90 K2"):
        moves = run(polar, before="G0 X0 Y0 Z20 F100")
        assert moves.end == pytest.approx(written.end, abs=1e-9)


def make_rotation(axis, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array(
        {
            "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
            "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
            "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
        }[axis]
    )


@pytest.mark.parametrize(("text", "origin", "rotation"), [
    ("G68.2 P0 X1 Y2 Z3 I30 J20 K10", (1, 2, 3),
     make_rotation("z", 30) @ make_rotation("x", 20) @ make_rotation("z", 10)),
    ("G68.2 P1 X1 Y2 Z3 J20", (1, 2, 3), make_rotation("y", 20)),
    ("G68.2 P1 I90 Q321", (0, 0, 0), make_rotation("x", 90)),
    ("G68.2 P2 Q1 X10 Y0 Z0 / G68.2 P2 Q2 X10 Y5 Z0 / G68.2 P2 Q3 X10 Y0 Z8", (10, 0, 0),
     np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]])),
    # Q0: from the first point in the plane, then a turn by R
    ("G68.2 P2 Q0 X1 Y2 Z3 R90 / G68.2 P2 Q1 X10 Y0 Z0 / G68.2 P2 Q2 X10 Y5 Z0 / G68.2 P2 Q3 X10 Y1 Z8", (13, 1, 2),
     np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0]])),
    ("G68.2 P3 Q1 X1 Y2 Z3 I0 J2. K0 / G68.2 P3 Q2 I1. J0 K0", (1, 2, 3), np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]])),
])  # fmt: skip
def test_tilted_planes(run, text, origin, rotation):
    moves = run(f"{text} / G1 X0 Y0 Z0 / X1 / Y1 / Z1 X0 Y0")
    at = places(moves)
    assert at[0] == pytest.approx(origin, abs=1e-9)
    assert at[1] - at[0] == pytest.approx(rotation[:, 0], abs=1e-9)
    assert at[2] - at[1] == pytest.approx(rotation[:, 1], abs=1e-9)
    assert at[3] - at[0] == pytest.approx(rotation[:, 2], abs=1e-9)


def test_without_a_machine_any_two_rotary_axes_end_a_tool_axis(view):
    """`dump moves` reads programs of tables with A and C, and of those with B and C."""
    head = "%\nO1\nG0 X1. Y2. Z50.\nG68.2 X0 Y0 Z0 I0 J30. K90.\nG53.1\nG69\nG43.4 H2\n"
    moves, findings = view(head + "G0 X5. Y3. Z20. B-30. C90.\nM30\n%", dialect="fanuc")
    assert findings == ()
    assert moves.end[-1, 3:6].tolist() == [0.0, -30.0, 90.0]
    alone = view(head + "G0 X5. B-30.\nM30\n%", dialect="fanuc")[1]
    assert [(item.code, item.line) for item in alone] == [("VP013", 8)]


@pytest.mark.parametrize(("turn", "code"), [("G53.1", ""), ("G0 A30.", "VP013"), ("", "")])
def test_a_length_after_the_turn_is_along_the_tool(view, turn, code):
    """Y5 stayed not: a machine that had not turned its table was meant."""
    text = f"%\nO1\nG68.2 X0. Y-25. Z0. I0. J30. K0.\n{turn}\nG0 X-15. Y5. Z60.\nG43 Z60. H1\nG1 X15. F900.\nM30\n%"
    moves, findings = view(text, dialect="fanuc")
    assert [item.code for item in findings] == [code] * bool(code)
    if turn == "G53.1":
        assert moves.end[-1, :3].tolist() == [15.0, 5.0, 60.0]


@pytest.mark.parametrize("choice", ["", "turned", "rising"])
@pytest.mark.parametrize(("i", "j", "k"), [(0, 20, 0), (0, -35, 50), (20, 0, 0), (30, 20, 0), (-40, 25, 70)])
def test_planes_of_two_projected_angles(run, view, choice, i, j, k):
    """X has the angle I in the plane of X and Z, the trace of the plane in Y and Z the angle J; K turns in the
    plane.
    """
    text = f"G68.2 P4 X1 Y2 Z3 I{i} J{j} K{k} / G1 X0 Y0 Z0 / X1 / Y1 / Z1 X0 Y0"
    if i and not choice:
        findings = view("%\nO1\n" + text.replace(" / ", "\n") + "\nM30\n%", dialect="fanuc")[1]
        assert [(item.code, "projection_angles" in item.message) for item in findings] == [("VP005", True)]
        return
    at = places(run(text, control={"fanuc": {"projection_angles": choice}}))
    assert at[0] == pytest.approx((1, 2, 3), abs=1e-9)
    x, y, z = at[1] - at[0], at[2] - at[1], at[3] - at[0]
    assert np.column_stack([x, y, z]).T @ np.column_stack([x, y, z]) == pytest.approx(np.eye(3), abs=1e-9)
    assert np.cross(x, y) == pytest.approx(z, abs=1e-9)
    before = math.cos(math.radians(k)) * x - math.sin(math.radians(k)) * y  # X without K
    up = math.radians(i if choice == "rising" else -i)
    assert before == pytest.approx((math.cos(up), 0, math.sin(up)), abs=1e-9)
    trace = np.cross(z, (1, 0, 0))  # the line of the plane along which X of the part does not change
    assert math.degrees(math.atan2(trace[2], trace[1])) == pytest.approx(j, abs=1e-9)


def read_planes():
    """Rows of the page: block, key, directions of X, Y, Z."""
    page = (Path(__file__).parents[2] / "docs" / "fanuc.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(G68.2 P4[^`]*)` \| (\w*) ?\| (.+?) \| (.+?) \| (.+?) \|$", page, re.MULTILINE)
    return [(block, key, np.array([row.split(",") for row in axes], dtype=float)) for block, key, *axes in rows]


@pytest.mark.parametrize(("block", "key", "axes"), read_planes())
def test_planes_of_the_page(run, block, key, axes):
    text = f"{block.replace('P4', 'P4 X0 Y0 Z0')} / G1 X0 Y0 Z0 / X1 / X0 Y1 / Y0 Z1"
    at = places(run(text, control={"fanuc": {"projection_angles": key}}))
    assert at[1:4] == pytest.approx(axes, abs=6e-5)


def test_the_page_has_its_planes():
    assert len(read_planes()) == 4


def test_two_projected_angles_that_span_no_plane(view):
    control = {"fanuc": {"projection_angles": "turned"}}
    found = view("%\nO1\nG68.2 P4 X0 Y0 Z0 I90. J89.5\nM30\n%", dialect="fanuc", control=control)[1]
    assert [(item.code, "on one line" in item.message) for item in found] == [("VP007", True)]


@pytest.mark.parametrize(("choice", "rotation"), [
    ("fixed", make_rotation("z", 30) @ make_rotation("y", 20) @ make_rotation("x", 10)),
    ("moving", make_rotation("x", 10) @ make_rotation("y", 20) @ make_rotation("z", 30)),
])  # fmt: skip
def test_roll_pitch_and_yaw_need_to_be_told_about_which_axes(run, view, choice, rotation):
    text = "G68.2 P1 X0 Y0 Z0 I10 J20 K30 / G1 X1 Y0 Z0"
    at = places(run(text, control={"fanuc": {"roll_pitch_yaw": choice}}))
    assert at[0] == pytest.approx(rotation[:, 0], abs=1e-9)
    findings = view("%\nO1\n" + text.replace(" / ", "\n") + "\nM30\n%", dialect="fanuc")[1]
    assert [item.code for item in findings] == ["VP005"]
    assert "roll_pitch_yaw" in findings[0].message


@pytest.mark.parametrize(("text", "ends", "arcs"), [
    # ,C: so much of each line; ,R: an arc that touches both
    ("G1 X10 Y0 ,C2 / Y10", [(8, 0), (10, 2), (10, 10)], []),
    ("G1 X10 Y0 ,R2. / Y10 ,C1 / X0", [(8, 0), (10, 2), (10, 9), (9, 10), (0, 10)], [(8, 2, 90)]),
    # between a line and an arc: centre 2 mm beside the line y = 0 and 10 - 2 mm from the centre of the circle
    ("G1 X10 Y0 ,R2 / G3 X0 Y10 I-10 J0", [(2 * math.sqrt(15), 0), (2.5 * math.sqrt(15), 2.5), (0, 10)],
     [(2 * math.sqrt(15), 2, None), (0, 0, None)]),
    ("G1 X10 Y0 ,R2 / X20", [(10, 0), (20, 0)], []),
    ("G91 G1 X10 ,R[1+1] / Y10", [(8, 0), (10, 2), (10, 10)], [(8, 2, 90)]),
    ("#1=0 / WHILE [#1 LT 2] DO1 / G91 G1 X10 ,C1 / Y10 ,C1 / #1=#1+1 / END1 / X5",
     [(9, 0), (10, 1), (10, 9), (11, 10), (19, 10), (20, 11), (20, 19), (21, 20), (25, 20)], []),
])  # fmt: skip
def test_corners(run, text, ends, arcs):
    moves = run(text)
    assert moves.end[1:, :2] == pytest.approx(np.array(ends, dtype=float), abs=1e-9)
    for found, (x, y, sweep) in zip(zip(moves.arcs.center, moves.arcs.sweep, strict=True), arcs, strict=True):
        assert found[0][:2] == pytest.approx((x, y), abs=1e-9)
        assert sweep is None or found[1] == pytest.approx(sweep)


def test_a_corner_has_the_feed_of_the_first_and_is_beside_the_contour_under_compensation(run):
    moves = run("G1 X10 Y0 F50 ,R2 / Y10 F70")
    assert moves.feed[1:].tolist() == [50.0, 50.0, 70.0]
    tools = {1: Tool(1, 1, (0.0,) * 9, 2.0)}
    written = run("G42 D1 G1 X0 Y0 / X8 / G3 X10 Y2 R2 / G1 Y10 / G40 X20", before="G0 X-9 Y0 Z0 F100", tools=tools)
    short = run("G42 D1 G1 X0 Y0 / X10 ,R2 / Y10 / G40 X20", before="G0 X-9 Y0 Z0 F100", tools=tools)
    assert short.end == pytest.approx(written.end, abs=1e-9)
    assert short.feed[:-2] == pytest.approx(written.feed[:-2], nan_ok=True)


@pytest.mark.parametrize(("text", "heights"), [
    # R, Z, Q and P of one cycle hold for the next, until G80
    ("G81 X1 Z-3 R2 / G83 X2 Q2", [20, 2, -3, 20, 20, 2, 0, 2, 0.254, -2, 2, -1.746, -3, 20]),
    ("G82 Z-3 R2 P100 / G99 G81 X2 Z-4", [20, 2, -3, -3, 20, 20, 2, -4, 2]),
    # Haas: pecks from I by J down to no less than K, the last what is left, and P at the bottom; Q ends them
    ("G99 G83 Z-13 R2 I6 J2 K3 P.5", [20, 2, -4, 2, -3.746, -8, 2, -7.746, -11, 2, -10.746, -13, -13, 2]),
    ("G99 G73 Z-6 R2 I4 J0 K4 / Q8 X3", [20, 2, -2, -1.746, -6, 2, 2, -6, 2]),
    # P of other cycles does not dwell in them, and holds beyond them
    ("G99 G82 Z-1 R2 P100 / G83 X2 Q9 / G82 X3", [20, 2, -1, -1, 2, 2, -1, 2, 2, -1, -1, 2]),
    # fine boring: in, dwell, off the wall, out, back
    ("G76 Z-3 R2 P100 I0.2", [20, 2, -3, -3, -3, 20, 20]), ("G99 G76 Z-3 R2 Q0.2", [20, 2, -3, -3, 2, 2]),
])  # fmt: skip
def test_cycles(run, text, heights):
    moves = run(text, before="G0 X0 Y0 Z20 S500 M3 F100", control={"fanuc": {"bore_shift": "-Y"}})
    assert moves.end[1:, 2] == pytest.approx(heights)
    if "G76" in text:
        beside = [(-0.2 if "Q" in text else 0.0), 0.2 if "I" in text else 0.0]
        assert sorted({(x, y) for x, y in moves.end[1:, :2].round(9).tolist()}) == sorted(
            {(0.0, 0.0), (beside[1], beside[0])}
        )
        assert [event.kind for event in moves.events if event.line > 4] == ["spindle", "orient", "spindle", "end"]


def test_h_alone_is_another_length_while_g43_holds(run):
    moves = run("H0 G0 X1 / G43 H1 / X2 / H2 / X3 / H0 / X4")
    assert [moves.frames[i].tool[2] for i in moves.frame[-4:]] == [0.0, 10.0, 25.0, 0.0]


def test_g9_stops_once(run):
    modes = [str(one.mode.name) for one in (lambda m: [m.controls[i] for i in m.control])(run("G9 G1 X1 / X2"))]
    assert modes[1] == "EXACT_STOP"
    assert modes[2] == modes[0] != "EXACT_STOP"


@pytest.mark.parametrize(("text", "length", "radius"), [
    ("G10 L10 P1 R20", 20, 3), ("G10 L11 P1 R0.5", 10.5, 3), ("G10 L11 P1 R0.5 / G10 L11 P1 R0.2", 10.2, 3),
    ("G10 L11 P1 R0.5 / G10 L10 P1 R20", 20.5, 3),
    ("G10 L12 P1 R4", 10, 4), ("G10 L13 P1 R-0.1", 10, 2.9),
    ("G10 L12 P1 R4 / G10 L13 P1 R-0.1 / G10 L12 P1 R5", 10, 4.9),
])  # fmt: skip
def test_offsets_of_tools_and_their_wear(run, text, length, radius):
    moves = run(f"{text} / G43 H1 / G0 X#11001 Y#13001")
    assert moves.end[-1][:2] == pytest.approx((length, radius))
    assert moves.frames[moves.frame[-1]].tool[2] == pytest.approx(length)


@pytest.mark.parametrize(("text", "code", "part"), [
    ("G68 X0 Y0 R45 / G1 X10", "VP017", "name X, Y in G90"),
    ("G68 X0 Y0 R45 / G1 X9 Y9 / G69 / G91 X1", "VP017", "after G69"), ("G68 X0 Y0", "VP005", "R"),
    ("G68 X0 Y0 R45 / G68 X0 Y0 R45", "VP017", "G69"), ("G68 Z0 R45", "VP006", "plane"),
    ("G68 X0 Y0 R9 / G54 / G55", "VP017", "G69"), ("G68 X0 R9 I0 J0 K0", "VP005", "direction"),
    ("G68 X0 Y0 R9 / G53.1", "VP017", "G68.2"), ("G51 X0 Y0 P2", "VP007", "decimal point"),
    ("G51 X0 Y0 Z0 P0.", "VP007", "lies between"), ("G51 X0", "VP005", "P"),
    ("G51 X0 Y0 Z0 P2. / G51 P2.", "VP017", "G50"), ("G51 X0 Y0 Z0 P2. / G28 X0", "VP017", "G28"),
    ("G51 X0 Y0 Z0 P2. / G55", "VP017", "G50"),
    ("G51 X0 Y0 Z0 I2. J3. / G2 X9 Y9 I9", "VP017", "ellipse"), ("G51.1", "VP005", "axes"),
    ("G68 X0 Y0 R9 / G51.1 X0", "VP017", "G69"), ("G51.1 Z0 / G81 Z-3 R2", "VP017", "below"),
    ("G16 / G91 G1 X5", "VP002", "G90"), ("G16 / G2 X5 Y5 I5", "VP017", "R"), ("G18 G16 / G1 X5 Y5", "VP017", "G17"),
    ("G51.1 X0 / G16", "VP017", "G50"),
    ("G51.1 X0 / G68.2 X5 Y0 Z0 I0 J20 K0", "VP017", "G68.2 under G51, G51.1 or G16; end that before (G50, G50.1"),
    ("G51 X0 Y0 Z0 P2. / G68.2 X5 Y0 Z0 I0 J20 K0", "VP017", "G68.2 under"),
    ("G16 / G68.2 X5 Y0 Z0 I0 J20 K0", "VP017", "G68.2 under"), ("G16 / A20 / G68.3", "VP017", "G68.3 under"),
    ("G51.1 X0 / G68 X0 Y0 Z0 I1 J0 K0 R9", "VP017", "G50.1"),
    ("G51 X0 Y0 Z0 P2. / G68 X0 Y0 Z0 I1 J0 K0 R9", "VP017", "G50"),
    ("G68.2 P4 I1", "VP005", "projection_angles"), ("G68.2 P4 J1 Q1", "VP006", "Q"),
    ("G68.2 P5 I1", "VP007", "P0 to P4"), ("G68.2 P2 Q1 X0 / G1 X1", "VP005", "no Q2 (X Y Z of a point on X), Q3 ("),
    ("G68.2 P2 Q4", "VP007", "Q4"),
    ("G68.2 P3 Q1 I1 / G68.2 P3 Q2 I1", "VP007", "right angles"),
    ("G68.2 P3 Q1 I1 / X1", "VP005", "Q2 (I J K along Z)"),
    ("G68.2 P2 X0 Y0 I0 J25. / X1", "VP005", "without P"),
    ("G68.2 P2 Q1 X0 / G68.2 P2 Q2 X1 / G68.2 P2 Q3 X2", "VP007", "line"), ("G68.2 P1 Q122 I1", "VP007", "Q122"),
    ("G68.2 P0 Q1 I1", "VP006", "Q"), ("G68.3 R0", "VP017", "vertical"),
    ("G68.3 X1", "VP005", "X, Y and Z"), ("G53.6 H1", "VP017", "G68.2"), ("G68.2 I0 / G53.6 H1 R5", "VP002", "R"),
    ("G68.4 X0", "VP002", "G68.4"),
    ("G68 X0 Y0 R9 / #1=#5001", "VP025", "#5001"), ("G51.1 X0 / #1=#5042", "VP025", "#5042"),
    ("G1 X9 ,R2 / M8", "VP017", "line or an arc"), ("G1 X9 ,R2 / G0 Y9", "VP017", "line or an arc"),
    ("G0 X9 ,R2", "VP017", "feed move"), ("G1 X1 ,R2 / Y9", "VP008", ",R"),
    ("G1 X9 ,C2 / G2 X5 Y5 R9", "VP008", ",C"), ("G1 X9 ,R0 / Y9", "VP007", "greater than 0"),
    ("G1 X9 ,R2", "VP017", "line or an arc"), ("G1 X9 Z1 ,R2 / Y9", "VP008", "plane"),
    ("G83 Z-3 R2 I1 J1", "VP005", "together"), ("G83 Z-3 R2 I1 J1 K2", "VP007", "fall"),
    ("G83 Z-3 R2 I1 J0 K0", "VP007", "fall"), ("G83 Z-3 R2 I1 J0 K1 Q1", "VP007", "fall"),
    ("G83 Z-3 R2 I1 J.1 K.00001", "VP007", "pecks"),
    ("G76 Z-3 R2 Q0.2", "VP005", "bore_shift"), ("G76 Z-3 R2", "VP005", "Q greater"), ("G87 Z-3 R2 Q1", "VP002", "G87"),
    ("G81 Z-3 R2 / G80 / G82 Z-3 P1", "VP005", "R"),
    ("G10 L11 P9 R1", "VP012", "tool 9"), ("G10 L12 P1", "VP005", "R"), ("G10 L14 P1 R1", "VP002", "L14"),
    ("G91 G30 P3 Z0", "VP015", "P3"), ("G91 G30 P5 Z0", "VP007", "P2, P3 and P4"),
    ("G150 I5. F9", "VP002", "G12 or G13"), ("G113", "VP002", "G154 P"),
    ("G12 I5. F9", "VP005", "G12 needs D"),
    ("G254 / A5", "VP017", "G255"), ("G68 X0 Y0 R9 / G254", "VP017", "G68"), ("G254 / G55", "VP017", "G255"),
    ("G54 G254 / G54.1 P3", "VP017", "G255"), ("G68.2 I10 / G55", "VP017", "G69"), ("G888", "VP002", "[remap]"),
    ("G154 P99", "VP007", "P1 to"), ("G154", "VP005", "P"), ("G101", "VP005", "axes"),
    ("G51 P2. / X1 / G92 X0", "VP017", "G92"),
])  # fmt: skip
def test_refusals(view, text, code, part):
    source = "\n".join(["%", "O1", "G21 G90 G17", "G0 X0 Y0 Z0 S500 M3", "F100", *text.split(" / "), "M30", "%"])
    findings = view(source, dialect="fanuc")[1]
    assert [item.code for item in findings] == [code], findings
    assert part in findings[0].message


@pytest.mark.parametrize("length", ["G43", "G43.4"])
def test_a_plane_without_a_tool_length_says_what_can_be_done(machine, length):
    """Without A and C before the plane, the table is taken to start as the plane turns it."""
    tail = "G53.1\nG43 H1 Z20.\nG0 X1. Y1.\nG69\nM30\n%"
    options = Options(dialect="fanuc", tools={1: Tool(1, 1, (0.0, 0.0, 80.0, *[0.0] * 6), 10.0)})

    def find(level="", again=""):
        head = f"%\nO1\nG21 G90 G17\nT1 M6\nG54 G0 X0 Y0{level}\n{length} H1 Z50.\nG49\nG68.2 X0 Y0 Z0 I0 J20. K0"
        findings = check(f"{head}\n{again}\n{tail}".encode(), machine, options).findings
        return [item for item in findings if item.code == "VP016"]

    (found,) = find()
    assert found.line == 10
    assert "write G43 with its H before G53.1, or retract before it (G53 G0 Z)" in found.message
    assert "name Z in this motion" not in found.message
    assert find(level=" A0 C0") == find(again="G43 H1") == find(again="G53 G0 Z300.") == []


def test_a_cycle_under_a_plane_names_the_angles_of_the_machine(machine):
    head = "%\nO1\nG21 G90 G17 G49\nG0 X0 Y0 Z50. A0 C0 S500 M3 F100\nG68.2 X0 Y0 Z0 I0 J20. K0"
    program = f"{head}\nG81 X0 Y0 Z-5. R2.\nG80\nG69\nM30\n%".encode()
    (found,) = check(program, machine, Options(dialect="fanuc")).findings
    assert "points along (0.0000, 0.3420, 0.9397) of the plane, at A0 C0 of the machine: it would" in found.message


def test_a_program_that_ends_in_a_corner_says_so(view):
    for text in ("G1 X9 ,R2", "G68.2 P2 Q1 X0"):
        findings = view(f"%\nO1\nG0 X0 Y0\nF100\n{text}\n%", dialect="fanuc")[1]
        assert [item.code for item in findings] == ["VP010"]


@pytest.mark.parametrize(("a", "c"), [(20.0, 30.0), (-35.0, 100.0), (0.0, 45.0), (0.0, 0.0)])
def test_a_dynamic_work_offset_counts_along_the_machine_from_the_origin_on_the_table(machine, a, c):
    options = Options(tool_length=50.0, dialect="fanuc", wcs={"G54": (10.0, -20.0, 60.0)})
    text = (
        "%\n"
        "O1\n"
        "G21 G90 G54\n"
        "G43 H1\n"
        f"G0 X0 Y0 Z0 A{a} C{c}\n"
        "G254\n"
        "G0 X1 Y2 Z3\n"
        "G91 G1 X10 F500\n"
        "Y10\n"
        "Z10\n"
        "G90 G255\n"
        "G0 X0 Y0 Z0\n"
        "M30\n"
        "%"
    )
    moves = interpret_program(text.encode(), build_interpreter_setup(machine, options))
    at = [machine.coordinates.map_to_machine(moves.end[i], moves.frames[moves.frame[i]])[:3] for i in range(len(moves))]
    zero = at[0]  # the origin of the part, where the table has carried it
    ends = [(1, 2, 3), (11, 2, 3), (11, 12, 3), (11, 12, 13), (0, 0, 0)]
    assert np.array(at[1:]) - zero == pytest.approx(np.array(ends, dtype=float), abs=1e-9)
    assert not [item for item in moves.findings if item.code == "VP037"]


def test_the_work_offset_in_force_may_be_named_again_under_a_dynamic_one(run):
    """As posts for Haas write it; it changes nothing. Under G68.2, and another offset, it stays refused."""
    head = "G55 / G0 X0 Y0 Z0 A20 C30 / G254 / "
    one, two = (run(f"{head}{text}G0 X1 Y2 Z3 / G255 / X5") for text in ("", "G55 "))
    assert one.end == pytest.approx(two.end, abs=0)
    assert one.frame.tolist() == two.frame.tolist()


def test_haas_codes_are_shown(run):
    moves = run("G154 P3 / G187 P2 E0.01 / G103 P1 / G0 X1 Y1")
    assert [event.data for event in moves.events if event.kind == "look-ahead"] == [
        {"code": "G187", "P": 2.0, "E": 0.01},
        {"code": "G103", "P": 1.0},
    ]
    assert moves.frames[moves.frame[-1]].system == 103
    assert MoveKind(int(moves.kind[-1])) == MoveKind.RAPID
