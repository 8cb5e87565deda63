"""Arcs whose end is nearly their start: in every dialect, and under cutter compensation."""

import math

import numpy as np
import pytest

TENTHS = "#1=0\n" + "#1=[#1+0.1]\n" * 10  # 1 - 1.1e-16


@pytest.mark.parametrize("dialect", ["rs274", "fanuc"])
@pytest.mark.parametrize(
    ("start", "arc"),
    [
        ("G0 X1", "G3 X#1 R10"),
        ("G0 X1", "G2 X#1 R-10"),
        ("G18 G0 X1", "G2 X#1 Y3 R10"),
        ("G0 X1", "G3 X#1 Z1 R10"),
        ("G0 X10 Y20", "G91 G3 X.0000004 R100000"),
        ("G0 X10 Y20", "G3 R5 X10"),
        ("G0 Y0", "G2 Y.002 R0"),
    ],
)
def test_an_arc_by_radius_is_never_a_full_circle(view, dialect, start, arc):
    moves, findings = view(f"{TENTHS}F100 G0 X0 Y0 Z0\n{start}\n{arc}\nM2", dialect=dialect)
    assert not len(moves.arcs.sweep)
    assert [(item.code, item.line) for item in findings] == [("VP008", 14)]


@pytest.mark.parametrize(("radius", "center"), [(0.5, (0.3, -0.4)), (-0.5, (0.3, 0.4)), (1.0, (0.3, -(0.91**0.5)))])
@pytest.mark.parametrize(("code", "sign"), [(2, 1), (3, -1)])
def test_the_centre_of_an_arc_by_a_small_radius(view, radius, center, code, sign):
    """Of a chord of 0.6 along X: below it for the short way clockwise, above for the long one."""
    moves, findings = view(f"F9 G0 X0 Y0 Z0\nG{code} X0.6 R{radius}\nM2", dialect="rs274")
    assert findings == ()
    assert moves.arcs.center[0, :2] == pytest.approx([center[0], sign * center[1]])


def test_an_arc_by_radius_that_cannot_be_says_how_far_apart_its_ends_are(view):
    """Ends of a 3-4-5 triangle: 2.5e-7 mm apart; and 50 mm, which takes a radius of 25."""
    for body, words in (
        ("X.00000015 Y.0000002 R9", "they are 2.5e-07 mm apart"),
        ("X30 Y40 R24", "at least 25 mm"),
    ):
        _moves, findings = view(f"F9 G91 G2 {body}\nM2", dialect="rs274")
        assert words in findings[0].message


def test_a_short_chord_that_a_program_can_write_is_a_short_arc(view):
    moves, findings = view("F9 G91 G3 X.000001 R90000\nG2 X.000001 R-10\nM2", dialect="rs274")
    assert findings == ()
    assert moves.arcs.sweep[0] == pytest.approx(math.degrees(1e-6 / 90000), rel=1e-6)
    # the long way round is what a negative R asks for, whatever is left out of the circle
    assert moves.arcs.sweep[1] == pytest.approx(-360 + math.degrees(1e-7), abs=1e-9)


@pytest.mark.parametrize(("radius", "sweep"), [(10.0, 60.0), (-10.0, 300.0)])
@pytest.mark.parametrize(("code", "sign"), [("G2", -1), ("G3", 1)])
def test_the_sweep_of_an_arc_by_radius(view, code, sign, radius, sweep):
    moves, findings = view(f"F9 {code} X6 Y8 R{radius}\nM2", dialect="rs274")  # the chord is as long as the radius
    assert findings == ()
    assert moves.arcs.sweep == pytest.approx([sign * sweep])
    assert np.hypot(*(moves.arcs.center[0, :2] - [6, 8])) == pytest.approx(10)


@pytest.mark.parametrize("code", ["G2", "G3"])
@pytest.mark.parametrize(
    ("end", "sweep"),
    [
        ("", 360.0),
        ("X10 Y0", 360.0),
        ("X10 Y.0000001", 360.0),
        ("X10 Y-.0000001", 360.0),
        ("X10.02", 360.0),
        ("X10.02 Y.0000001", 360.0),
        ("X10.02 Y-.0000001", 360.0),
    ],
)
def test_an_arc_by_centre_whose_end_is_its_start_is_a_full_circle(view, code, end, sweep):
    moves, findings = view(f"F9 G0 X10\n{code} {end} I-10\nM2", dialect="rs274")
    assert findings == ()
    assert np.abs(moves.arcs.sweep) == pytest.approx([sweep], abs=1e-5)


@pytest.mark.parametrize(("code", "y", "sweep"), [
    ("G3", "0.000001", 1e-7), ("G2", "0.000001", 2 * math.pi - 1e-7), ("G2", "-0.001", 1e-4),
    ("G3", "-0.001", 2 * math.pi - 1e-4),
])  # fmt: skip
def test_an_arc_by_centre_that_ends_where_a_program_can_write_it_ends_there(view, code, y, sweep):
    moves, findings = view(f"F9 G0 X10\n{code} X10 Y{y} I-10\nM2", dialect="rs274")
    assert findings == ()
    assert np.abs(np.radians(moves.arcs.sweep)) == pytest.approx([sweep], rel=1e-7)


@pytest.mark.parametrize(("end", "sweep"), [("10,0.0000001,0", 360.0), ("10,-0.0000001,0", 360.0), ("0,10,0", 90.0)])
def test_circles_of_cutter_location_text(view, end, sweep):
    text = f"UNITS/MM\nFEDRAT/100\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10\nGOTO/{end}\nFINI"
    moves, findings = view(text, dialect="aptcl")
    assert findings == ()
    assert moves.arcs.sweep == pytest.approx([sweep], abs=1e-5)


# --- beside the contour ------------------------------------------------------------------------------

ENTRY = "F100 G0 X-50\nG41.1 D6\nG1 X0\n"


def test_a_corner_that_is_hardly_one_is_not_rounded_by_a_full_circle(view):
    # the directions differ by a hair more than what counts as a corner at all
    moves, findings = view(f"{ENTRY}X10\nX20 Y-0.0000010000000020000000\nG40 Y50\nM2", dialect="rs274")
    assert findings == ()
    assert moves.arcs.sweep == pytest.approx([-math.degrees(1e-7)], rel=1e-4)


@pytest.mark.parametrize(
    "lines",
    [
        # the corner at its start, and the one at its end, reach beyond the arc
        "X0 Y-10\nG3 X0.3 Y-10.1 R20\nG1 X40 Y10",
        "X0 Y-10\nG3 X0.001 Y-10 R20\nG1 X40 Y10",
    ],
)
def test_an_arc_shorter_than_its_inside_corners_is_refused_and_not_turned_back(view, lines):
    moves, findings = view(f"F100 G0 Y50\nG41.1 D6\nG1 X0 Y0\n{lines}\nG40 Y50\nM2", dialect="rs274")
    assert [item.code for item in findings] == ["VP026"]
    assert not (moves.arcs.sweep * np.sign(moves.arcs.turns) < 0).any()


def test_arcs_beside_a_contour_turn_the_way_they_were_programmed(view):
    """Short and long arcs between lines in any direction; what is not refused must reach its own end."""
    rng = np.random.default_rng(5)
    done = refused = 0
    for _ in range(400):
        radius, first, entry, leave = rng.uniform(4, 40), *rng.uniform(0, 2 * math.pi, 3)
        sense, swept = rng.choice([1, -1]), rng.choice([rng.uniform(1e-4, 0.3), rng.uniform(0.1, 6)])
        begin = radius * np.array([math.cos(first), math.sin(first)])
        last = first + sense * swept
        end = radius * np.array([math.cos(last), math.sin(last)])
        x, y = begin - 30 * np.array([math.cos(entry), math.sin(entry)])
        u, v = end + 30 * np.array([math.cos(leave), math.sin(leave)])
        moves, findings = view(
            f"F100 G0 X{x:.5f} Y{y:.5f}\n{rng.choice(['G41.1', 'G42.1'])} D6\nG1 X{begin[0]:.5f} Y{begin[1]:.5f}\n"
            f"G{3 if sense > 0 else 2} X{end[0]:.5f} Y{end[1]:.5f} I{-begin[0]:.5f} J{-begin[1]:.5f}\n"
            f"G1 X{u:.5f} Y{v:.5f}\nG40 X100 Y100\nM2",
            dialect="rs274",
        )
        refused += findings != ()
        for move in [] if findings else np.flatnonzero(moves.arc >= 0):
            done += 1
            row = moves.arc[move]
            center, angle = moves.arcs.center[row, :2], math.radians(moves.arcs.sweep[row])
            assert angle * moves.arcs.turns[row] >= 0
            du, dv = moves.end[move - 1, :2] - center
            reached = center + [
                du * math.cos(angle) - dv * math.sin(angle),
                du * math.sin(angle) + dv * math.cos(angle),
            ]
            # five decimals of start, end and centre
            assert np.abs(reached - moves.end[move, :2]).max() < 1e-4
    assert done > 300
    assert 50 < refused < 350


@pytest.mark.parametrize(("share", "half"), [(0.9e-12, True), (1.2e-12, False)])
def test_an_arc_by_radius_that_is_nearly_a_half_circle_is_one(view, share, half):
    end = 2000.0 * (1.0 - share)
    moves, findings = view(f"F9 G3 X{end:.12f} R1000\nM2", dialect="rs274")
    assert findings == ()
    # the height of the centre over the chord is R sqrt(2 share): 1.3 um at 1 m
    assert (moves.arcs.center[0, 1] == 0.0) == half
    assert (moves.arcs.sweep[0] == 180.0) == half
