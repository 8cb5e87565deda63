"""Splines of LinuxCNC and of Fanuc controls as moves, and everything that is refused instead of being chorded."""

import json
from pathlib import Path

import numpy as np
import pytest

from verne_post.base.bsplines import find_even_parts
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.splines import BSpline, build_uniform_knots, cut_spline
from verne_post.model.moves import MoveKind, PathMode
from verne_post.verification.splines import evaluate_spline_points, find_parameters_at, measure_splines, project

HEAD = "G21 G90 G94 G17 F1000\nG0 X0 Y0 Z0\n"
CHORDS = [
    json.loads(line)
    for line in (Path(__file__).parents[1] / "reference" / "linuxcnc_splines.jsonl").read_text("utf-8").splitlines()
]


def curve(moves):
    """All pieces of a program's splines, measured: X, Y, Z, A, C of their control points."""
    pieces = moves.splines.replace_points(moves.splines.points[:, [0, 1, 2, 3, 5]])
    return measure_splines(pieces, 50.0)


def places(moves, share):
    """X Y of every piece at shares of its own parameter."""
    splines = curve(moves)
    m, degree = len(splines.pieces), splines.pieces.degree
    found = []
    for piece in range(m):
        knots = splines.pieces.knots[splines.pieces.first_knot[piece] :][: 2 * degree[piece]]
        low, high = knots[degree[piece] - 1], knots[degree[piece]]
        found.append(
            evaluate_spline_points(splines.pieces, np.full(len(share), piece), low + share * (high - low))[:, :2]
        )
    return np.array(found)


# --- LinuxCNC ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", CHORDS, ids=lambda case: case["name"])
def test_chords_of_linuxcnc_end_on_the_curve(view, case):
    """LinuxCNC replaces splines by chords; every chord ends on our curve, one after the other, up to its last point."""
    moves, findings = view(case["program"])
    assert findings == ()
    splines = curve(moves)
    points = np.array(case["points"])
    m = len(splines.pieces)
    away, place = np.full(len(points), np.inf), np.zeros(len(points))
    for piece in range(m):
        pose = np.column_stack([points, np.full(len(points), splines.pieces.points[0, 2]), np.zeros((len(points), 2))])
        every = np.full(len(points), piece)
        u = np.clip(project(splines, every, pose, np.ones(len(points), bool), 0.0, 50.0, None), 0.0, 1.0)
        at = evaluate_spline_points(splines.pieces, every, find_parameters_at(splines, every, u, 50.0))
        off = np.linalg.norm(at[:, :2] - points, axis=1)
        nearer = off < away - 1e-7
        away, place = np.where(nearer, off, away), np.where(nearer, piece + u, place)
    assert away.max() < 1e-7
    assert (np.diff(place)[:-1] > 0).all()  # the last point may come twice
    np.testing.assert_allclose(moves.end[-1, :2], points[-1], atol=1e-9)


def test_cubic_and_quadratic_are_bezier_curves(view):
    moves, _ = view(HEAD + "G5 X10 Y0 I2 J5 P-2 Q5\nG5.1 X20 Y4 I3 J-3\nM2")
    t = np.linspace(0.0, 1.0, 5)
    s = 1.0 - t
    cubic, quadratic = places(moves, t)
    for axis, (a, b, c, d) in enumerate([(0, 2, 8, 10), (0, 5, 5, 0)]):
        np.testing.assert_allclose(
            cubic[:, axis], s**3 * a + 3 * s**2 * t * b + 3 * s * t**2 * c + t**3 * d, atol=1e-12
        )
    for axis, (a, b, c) in enumerate([(10, 13, 20), (0, -3, 4)]):
        np.testing.assert_allclose(quadratic[:, axis], s**2 * a + 2 * s * t * b + t**2 * c, atol=1e-12)


@pytest.mark.parametrize(("points", "weights", "rest"), [
    ([(0, 0), (0, 0), (10, 10), (20, 0)], [1, 1, 2, 1], "first"),
    ([(0, 0), (10, 10), (20, 0), (20, 0)], [1, 2, 1, 1], "last"),
])  # fmt: skip
def test_a_control_point_that_repeats_the_first_or_the_last(view, points, weights, rest):
    """The curve begins, or ends, at rest by its parameter: a straight part of some nm, and the curve itself to the last
    digit.
    """
    lines = "\n".join(f"X{x} Y{y} P{weight}" for (x, y), weight in zip(points[1:], weights[1:], strict=True))
    moves, findings = view(f"{HEAD}G5.2 {lines.replace(chr(10), ' L4' + chr(10), 1)}\nG5.3\nM2")
    assert findings == ()

    def on_curve(t):
        t = np.atleast_1d(t)[:, None]
        shares = np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3]) * weights
        return shares @ np.array(points, float) / shares.sum(axis=1)[:, None]

    kinds = [MoveKind(kind).name for kind in moves.kind[1:]]
    assert kinds == (["FEED", "SPLINE"] if rest == "first" else ["SPLINE", "FEED"])
    # the part that is cut off is half a half of a half ... of the parameter
    shares = [0.5**k for k in range(1, 21)]
    ends = shares if rest == "first" else [1 - share for share in shares]
    cut = min(ends, key=lambda t: np.abs(on_curve(t)[0] - moves.end[1, :2]).max())
    assert on_curve(cut)[0] == pytest.approx(moves.end[1, :2], abs=1e-12)
    assert np.linalg.norm(moves.end[1, :2] - points[0 if rest == "first" else -1]) < 1e-4
    u = np.linspace(0, 1, 9)
    t = cut + (1 - cut) * u if rest == "first" else cut * u
    np.testing.assert_allclose(places(moves, u)[0], on_curve(t), atol=1e-9)
    # straight: the middle of the part lies on its chord
    middle = on_curve(0.5 * cut if rest == "first" else 0.5 * (1 + cut))[0]
    a, b = np.array(points[0 if rest == "first" else -1], float), moves.end[1, :2]
    chord = (b - a) / np.linalg.norm(b - a)
    assert abs((middle - a) @ np.array([-chord[1], chord[0]])) < 1e-9


def test_a_cubic_goes_on_where_the_one_before_leads(view):
    given, _ = view(HEAD + "G5 X10 Y0 I2 J5 P-2 Q5\nG5 X20 Y0 I2 J-5 P-2 Q1\nM2")
    left_out, _ = view(HEAD + "G5 X10 Y0 I2 J5 P-2 Q5\nG5 X20 Y0 P-2 Q1\nM2")
    np.testing.assert_array_equal(given.splines.points, left_out.splines.points)


def test_pieces_follow_the_lines_that_complete_them(view):
    moves, _ = view(HEAD + "G5.2 X0 Y1 P1 L4\nX2 Y2 P1\nX2 Y0 P1\nX5 Y0 P2\nM8\nX6 Y6 P1\nG5.3\nM2")
    assert moves.line[1:].tolist() == [5, 6, 8]
    assert (moves.kind[1:] == MoveKind.SPLINE).all()
    np.testing.assert_array_equal(moves.end[-1, :2], [6.0, 6.0])
    assert moves.splines.weights.tolist() == [1, 1, 1, 1, 1, 1, 1, 2, 1, 1, 2, 1]
    assert [event.before for event in moves.events if event.kind == "coolant"] == [1]  # when its block is read


def test_weight_of_the_start_and_inches(view):
    mm, _ = view(HEAD + "G5.2 P3\nX25.4 Y25.4 P1\nX50.8 Y0 P1\nG5.3\nM2")
    inch, _ = view("G20 G90 G94 G17 F1000\nG0 X0 Y0 Z0\nG5.2 P3\nX1 Y1 P1\nX2 Y0 P1\nG5.3\nM2")
    np.testing.assert_allclose(mm.splines.points, inch.splines.points, atol=1e-12)
    assert mm.splines.weights.tolist() == [3.0, 1.0, 1.0]


def test_exact_stop_is_at_the_end_of_the_curve(view):
    moves, _ = view("G61.1\n" + HEAD + "G5.2 X0 Y1 P1 L3\nX2 Y2 P1\nX2 Y0 P1\nX5 Y0 P2\nG5.3\nM2")
    modes = [moves.controls[k].mode for k in moves.control[1:]]
    assert modes == [PathMode.EXACT_PATH, PathMode.EXACT_PATH, PathMode.EXACT_STOP]


def test_inverse_time_is_of_the_whole_curve(view):
    moves, _ = view("G21 G90 G17\nG0 X0 Y0 Z0\nG93 G5.1 X3 Y0 I1.5 J0.00001 F2\nM2")
    assert moves.feed[-1] == pytest.approx(6.0, rel=1e-9)


def test_dump_shows_control_points(run, tmp_path):
    path = tmp_path / "a.ngc"
    path.write_text(HEAD + "G5.1 X10 Y0 I5 J5\nM2\n")
    record = json.loads(run("dump", "moves", path).out.splitlines()[-2])
    assert (record["kind"], record["degree"], record["knots"]) == ("spline", 2, [0.0, 0.0, 1.0, 1.0])
    assert [point[:2] for point in record["points"]] == [[0, 0], [5, 5], [10, 0]]


# --- Fanuc --------------------------------------------------------------------------------------------

FANUC = "%\nO1 (A)\nG21 G90 G94 G17 F1000\nG0 X0 Y0 Z0 A0 C0\n"
NURBS = """G6.2 P4 K0 X0 Y0 Z0 R1
K0 X10 Y20 A-3 C5
K0 X30 Y25 A-8 C20
K0 X50 Y0 A-10 C30 R2
K1 X70 Y-20 A-8 C30
K3
K3
K3
K3
"""


def test_nurbs_of_fanuc(view):
    moves, findings = view(f"{FANUC}{NURBS}G1 X80\nM30\n%")
    assert findings == ()
    assert moves.line[1:].tolist() == [8, 9, 14]
    assert moves.splines.degree.tolist() == [3, 3]
    assert moves.splines.knots.tolist() == [0, 0, 0, 1, 3, 3, 0, 0, 1, 3, 3, 3]
    assert moves.splines.weights.tolist() == [1, 1, 1, 2, 1, 1, 2, 1]
    np.testing.assert_array_equal(moves.end[2, [0, 1, 2, 3, 5]], [70, -20, 0, -8, 30])


def test_nurbs_of_fanuc_with_words_left_out(view):
    """The first block may leave the point and the knot to what holds; the order without P is 4; G6.2 is modal."""
    whole, _ = view(f"{FANUC}{NURBS}M30\n%")
    short, _ = view(FANUC + NURBS.replace("P4 K0 X0 Y0 Z0 R1", "") + "M30\n%")
    np.testing.assert_array_equal(whole.splines.points, short.splines.points)
    twice, findings = view(FANUC + NURBS + "P2 K0 X70\nK0 X80\nK1\nK1\nM30\n%")
    assert findings == ()
    assert twice.kind[-1] == MoveKind.FEED  # of order 2: a straight line


# --- what is refused -----------------------------------------------------------------------------------

BAD = {
    "one of I and J": ("G5 X10 Y0 I2 P-2 Q5", "VP005"),
    "P without Q": ("G5 X10 Y0 I2 J1 P-2", "VP005"),
    "the first of a series without I and J": ("G5 X10 Y0 P-2 Q5", "VP005"),
    "another move in between": ("G5 X10 Y0 I2 J5 P-2 Q5\nG1 X11\nG5 X20 Y0 P-2 Q5", "VP005"),
    "no end": ("G5 I2 J1 P-2 Q5", "VP005"),
    "a modal G5": ("G5 X10 Y0 I2 J5 P-2 Q5\nX20 P1 Q1", "VP005"),
    "J missing": ("G5.1 X10 I5", "VP005"),
    "Z": ("G5 X10 Y0 Z3 I2 J5 P-2 Q5", "VP006"),
    "another plane": ("G18 G5.1 X10 I5 J5", "VP017"),
    "compensation": ("G41.1 D2 G5.1 X10 I5 J5", "VP017"),
    "a spline after G40": ("G41.1 D2 G1 X5\nG40 G5.1 X10 I5 J5", "VP026"),
    "no feed": ("F0 G5.1 X10 I5 J5", "VP009"),
    "a cusp": ("G5 X10 Y0 I10 J10 P-10 Q10", "VP031"),
    "one place": ("G5 X0 Y0 I0 J0 P0 Q0", "VP031"),
    "G5.3 alone": ("G5.3", "VP031"),
    "a point without weight": ("G5.2 X0 Y1 P1\nX2 Y2\nX2 Y0 P2\nG5.3", "VP005"),
    "the first point without weight": ("G5.2 X0 Y1\nX2 Y2 P1\nX2 Y0 P2\nG5.3", "VP005"),
    "a weight of 0": ("G5.2 X0 Y1 P1\nX2 Y2 P0\nX2 Y0 P2\nG5.3", "VP031"),
    "too few points": ("G5.2 X0 Y1 P1 L4\nX2 Y2 P1\nG5.3", "VP031"),
    "X without Y": ("G5.2 X0 Y1 P1\nX2 P1\nX2 Y0 P2\nG5.3", "VP005"),
    "a point with Z": ("G5.2 X0 Y1 P1\nX2 Y2 Z1 P1\nX2 Y0 P2\nG5.3", "VP006"),
    "an order of 2": ("G5.2 X0 Y1 P1 L2\nX2 Y2 P1\nX2 Y0 P2\nG5.3", "VP007"),
    "another move before G5.3": ("G5.2 X0 Y1 P1\nX2 Y2 P1\nG1 X3\nX4", "VP031"),
    "another system before G5.3": ("G5.2 X0 Y1 P1\nX2 Y2 P1\nG55\nX4 Y4 P1\nG5.3", "VP031"),
    "inverse time": ("G93 F2\nG5.2 X0 Y1 P1 F2\nX2 Y2 P1\nG5.3", "VP017"),
    "an end beside G5.3": ("G5.2 X0 Y1 P1\nX2 Y2 P1\nG5.3 X5", "VP006"),
    "G6.2": ("G6.2 X5", "VP002"),
}


@pytest.mark.parametrize("what", BAD)
def test_refused(view, what):
    body, code = BAD[what]
    _moves, findings = view(f"{HEAD}{body}\nM2")
    assert findings[0].code == code, findings


def test_a_program_that_ends_in_a_spline(view):
    for end in ("M2", "%"):
        start = "%\n" if end == "%" else ""
        _moves, findings = view(f"{start}{HEAD}G5.2 X0 Y1 P1\nX2 Y2 P1\n{end}\n")
        assert len(findings) == 1
        assert "spline" in findings[0].message


FANUC_BAD = {
    "a start elsewhere": (NURBS.replace("X0 Y0 Z0 R1", "X1 Y0 Z0 R1"), "VP031"),
    "too few knots alone": (NURBS.replace("K3\nK3\nK3\nK3", "K3\nK3\nK3"), "VP031"),
    "no end": (NURBS.replace("K3\n", ""), "VP031"),
    "first knots that differ": (NURBS.replace("K0 X30", "K0.5 X30"), "VP031"),
    "knots that fall": (NURBS.replace("K1 X70", "K-1 X70"), "VP031"),
    "a point without knot": (NURBS.replace("K1 X70", "X70"), "VP005"),
    "a negative weight": (NURBS.replace("R2", "R-2"), "VP031"),
    "order 5": (NURBS.replace("P4", "P5"), "VP007"),
    "P again": (NURBS.replace("K1 X70", "P4 K1 X70"), "VP006"),
    "another feed": (NURBS.replace("K1 X70", "F50 K1 X70"), "VP006"),
    "incremental": ("G91\n" + NURBS, "VP017"),
    "per revolution": ("G95 F1 S100 M3\n" + NURBS, "VP017"),
    "compensation": ("G41 D1\n" + NURBS, "VP017"),
    "tool vectors": ("G43.5 H1\n" + NURBS, "VP017"),
    "a point after knots": (NURBS.replace("K3\nK3\n", "K3\nK3 X9\n", 1), "VP031"),
    "a weight of a knot": (NURBS.replace("K3\n", "K3 R1\n", 1), "VP006"),
    "a hole inside": (NURBS.replace("K1 X70", "K0 X70"), "VP031"),
}


@pytest.mark.parametrize("what", FANUC_BAD)
def test_refused_of_fanuc(view, what):
    body, code = FANUC_BAD[what]
    _moves, findings = view(f"{FANUC}{body}G1 X80\nM30\n%")
    assert findings[0].code == code, findings


@pytest.mark.parametrize(
    ("program", "line"),
    [
        (f"{HEAD}G5.2 X0 Y1 P1\nX2 Y2 P1\nX3 Y0 P2\nX4 Y2 P1\nX5 Y0 P2\nG5.3\nM2", 6),
        (f"{FANUC}{NURBS}M30\n%", 9),
        (
            "; siemens\nG90 G94 G17 G54\nTRAORI\nG0 X0 Y0 Z0\nBSPLINE X10 Y10 F100\nX20 Y-10\nX30 Y0\nX40\nG1 X50\nM30",
            8,
        ),
    ],
)
def test_no_more_points_than_the_bound(view, monkeypatch, program, line):
    """In every dialect: what is read is bounded before anything is computed of it."""
    monkeypatch.setattr("verne_post.gcode.splines.MAX_POINTS", 4)
    _moves, findings = view(program)
    assert findings[0].code == "VP031"
    assert "more than 4 control points in one spline" in findings[0].message
    assert findings[0].line == line


def test_the_first_refusal_ends_the_work(monkeypatch):
    """A curve that stops early is not measured to its end: where it stops, that takes a hundred times as long."""
    measured = []
    monkeypatch.setattr(
        "verne_post.gcode.splines.find_even_parts",
        lambda controls, count: measured.append(len(controls)) or find_even_parts(controls, count),
    )
    with pytest.raises(ProgramError, match="stops or turns back"):
        cut_spline(spline_of([(5 * (k % 2), 0, 0) for k in range(2000)], 2))
    assert sum(measured) <= 256


# --- the general element -----------------------------------------------------------------------------


def spline_of(points, degree, knots=None, weights=None):
    nine = [[*point, *[0.0] * (9 - len(point))] for point in points]
    n = len(points)
    return BSpline(degree, nine, weights or [1.0] * n, knots or build_uniform_knots(n, degree), list(range(1, n + 1)))


def test_degree_one_is_straight_moves():
    cut = cut_spline(spline_of([(0, 0), (3, 4), (3, 10)], 1))
    assert cut.straight.all()
    assert cut.line == [2, 3]
    assert cut.length.tolist() == pytest.approx([5.0, 6.0])
    assert [end[:2] for end in cut.end] == [[3, 4], [3, 10]]


def test_a_straight_curve_that_stands_at_its_ends_is_a_straight_move():
    cut = cut_spline(spline_of([(0, 0, 0), (0, 0, 0), (3, 4, 0), (3, 4, 0)], 3))
    assert cut.straight.tolist() == [True]
    assert cut.length.sum() == pytest.approx(5.0)


def test_repeated_knots_cut_and_empty_spans_are_none():
    knots = [0, 0, 0, 0, 1, 1, 1, 2, 2, 2, 2]
    cut = cut_spline(spline_of([(0, 0), (1, 2), (3, 2), (4, 0), (5, 3), (7, 3), (8, 0)], 3, knots))
    assert cut.line == [4, 7]
    np.testing.assert_allclose(cut.end[0][:2], [4.0, 0.0], atol=1e-15)


def test_a_turn_in_place_is_no_spline():
    with pytest.raises(Exception, match="write G1"):
        cut_spline(spline_of([(0, 0, 0, 5.0 * k) for k in range(4)], 3))


@pytest.mark.parametrize(
    "knots", [[0, 0, 0, 1, 2, 2, 2], [0, 0, 1, 2, 3, 4, 4, 4], [0, 0, 0, 0, 1, 1, 1, float("nan")]]
)
def test_knots_that_do_not_fit(knots):
    with pytest.raises(Exception, match="knot"):
        cut_spline(spline_of([(0, 0), (1, 2), (3, 2), (4, 0)], 3, knots))


def test_what_ends_a_spline_of_siemens_too_early_is_named(run, tmp_path):
    path = tmp_path / "p.mpf"
    path.write_text("G710 G90\nTRAORI\nG0 X0 Y0 Z60 A=0 C=0\nBSPLINE\nG1 X20 F900\nM30\n")
    said = " ".join(run("check", path, "--tool-length", 80).out.split())
    assert "needs 3 points after its start; there are 0 before G1 ends it: leave G1 out of its blocks" in said
