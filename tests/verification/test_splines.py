"""Splines from text to verified rows, and verification that sees what is wrong beside them."""

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import verne_post
from verne_post import convert
from verne_post.app.assemble import assemble
from verne_post.app.verify import verify_setpoints
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.model.setpoints import SetpointBlock
from verne_post.model.splines import Splines
from verne_post.output.rounding import choose_setpoint_format
from verne_post.verification import splines

MACHINES = {name: verne_post.load_machine(name) for name in ("verne", "serial")}
RADIAN_MM = 50.0


def options(**more):
    return Options(tool_length=60.0, wcs={1: WorkOffset((0.0, 0.0, 50.0))}, **more)


def program(body, mode="G61", feed=2000):
    return f"%\nO1 (A)\nG21 G90 G94 G17 {mode}\nG0 X0 Y0 Z40 A0 C0\nF{feed}\n{body}M30\n%\n".encode()


def nurbs(points, order=4, knots=None, weights=None):
    """G6.2 through control points (n, 5): X Y Z A C, the first X0 Y0 Z40 A0 C0."""
    n = len(points)
    inner = np.arange(1, n - order + 1)
    knots = np.concatenate([[0] * order, inner, [n - order + 1] * order]) if knots is None else knots
    weights = np.ones(n) if weights is None else weights
    words = ["X%.6f Y%.6f Z%.6f A%.6f C%.6f" % tuple(point) for point in points]
    lines = [f"K{knots[k]:.6f} {words[k]} R{weights[k]:.6f}" for k in range(n)]
    return f"G6.2 P{order} " + "\n".join([*lines, *(f"K{knot:.6f}" for knot in knots[n:])]) + "\n"


def made(source, machine, **more):
    result = convert(source, machine, options(**more))
    assert result.ok, [item.message for item in result.findings]
    return result


def judge(values, line, source, machine, **more):
    asked = assemble(source, machine, options(**more))
    fmt = choose_setpoint_format(machine, asked.cycle, None, accept_rounding=False)
    return verify_setpoints(asked, iter([SetpointBlock(0, values, line, fmt)]))


WAVES = nurbs([(0, 0, 40, 0, 0), (10, 20, 41, -3, 5), (30, 25, 42, -8, 20), (50, 0, 44, -10, 30), (70, -20, 43, -8, 30),
               (90, 0, 40, -5, 30)], weights=np.array([1, 1, 0.5, 2, 1, 1]))  # fmt: skip
LOOP = nurbs([(0, 0, 40, 0, 0), (60, 40, 40, 0, 0), (-40, 40, 40, 0, 0), (20, 0, 40, 0, 0)])


# --- verification measures by itself ----------------------------------------------------------------


def test_nothing_of_planning_is_used():
    tree = ast.parse(Path(splines.__file__).read_text("utf-8"))
    imported = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert not any("bsplines" in name or "toolpath" in name for name in imported)
    names = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    assert not names & {"controls", "parameter", "first_part", "turn", "bend"}  # what planning has derived


def one(points, weights, knots, degree):
    return Splines(
        np.array([degree], np.int32),
        np.array([0]),
        np.array([0]),
        np.array(points, float),
        np.array(weights, float),
        np.array(knots, float),
    )


def test_lengths_of_a_circle_and_a_parabola():
    half = np.sqrt(0.5)
    quarter = one([[3, 0, 0, 0, 0], [3, 3, 0, 0, 0], [0, 3, 0, 0, 0]], [1, half, 1], [0, 0, 2, 2], 2)
    parabola = one([[0, 0, 0, 0, 0], [1, 0, 0, 0, 0], [2, 4, 0, 0, 0]], [1, 1, 1], [0, 0, 1, 1], 2)
    first = np.zeros(1, int)
    assert splines.measure_splines(quarter, RADIAN_MM).measure_lengths(first)[0] == pytest.approx(
        1.5 * np.pi, rel=1e-11
    )
    exact = np.sqrt(17.0) + np.arcsinh(4.0) / 4.0
    assert splines.measure_splines(parabola, RADIAN_MM).measure_lengths(first)[0] == pytest.approx(exact, rel=1e-11)


def test_shares_of_length_and_back():
    measured = splines.measure_splines(
        one(
            [[0, 0, 0, 0, 0], [1, 8, 0, 0.1, 0], [4, -5, 2, 0.2, 1], [9, 0, 0, 0, 1.5]],
            [1, 2, 0.3, 1],
            [0, 0.2, 1, 1.5, 1.5, 2],
            3,
        ),
        RADIAN_MM,
    )
    u = np.linspace(-0.05, 1.05, 45)
    piece = np.zeros(len(u), int)
    at = splines.find_parameters_at(measured, piece, np.clip(u, 0, 1), RADIAN_MM)
    point, slope = splines.differentiate_spline_points(measured.pieces, piece, at)
    weighted = np.linalg.norm(slope * [1, 1, 1, RADIAN_MM, RADIAN_MM], axis=1)
    beyond = (u - np.clip(u, 0, 1)) * measured.measure_total_metric(piece) / weighted  # straight on, by metric length
    point += beyond[:, None] * slope
    fresh = np.zeros(len(u), bool)
    fresh[0] = True
    np.testing.assert_allclose(splines.project(measured, piece, point, fresh, 0.0, RADIAN_MM, None), u, atol=1e-9)


@pytest.mark.parametrize(("begin", "scale"), [(7.0, 1.0), (-3.0, 0.2)])
def test_lengths_do_not_depend_on_where_knots_begin_nor_on_their_scale(begin, scale):
    """Nor do places at shares of the length, nor the nearest ones."""
    points = [[0, 0, 0, 0, 0], [1, 80, 0, 0.1, 0], [40, -50, 2, 0.2, 1], [90, 0, 0, 0, 1.5]]
    knots, weights = np.array([0, 0.2, 1, 1.5, 1.5, 2]), [1, 20, 0.03, 1]
    first, other = (
        splines.measure_splines(one(points, weights, some, 3), RADIAN_MM) for some in (knots, begin + scale * knots)
    )
    u, piece = np.linspace(0.0, 1.0, 301), np.zeros(301, int)
    at = splines.find_parameters_at(first, piece, u, RADIAN_MM)
    same = splines.find_parameters_at(other, piece, u, RADIAN_MM)
    np.testing.assert_allclose(same, begin + scale * at, atol=1e-9)
    lengths = splines.measure_lengths_at(first, piece, at, RADIAN_MM)
    np.testing.assert_allclose(splines.measure_lengths_at(other, piece, same, RADIAN_MM), lengths, rtol=1e-9, atol=1e-7)
    poses = splines.evaluate_spline_points(first.pieces, piece, at) + [0.0, 0.0, 0.01, 0.0, 0.0]
    found = [splines.project(some, piece, poses, np.arange(301) == 0, 0.0, RADIAN_MM, None) for some in (first, other)]
    np.testing.assert_allclose(found[1], found[0], atol=1e-8)


def test_a_crossing_is_passed_both_times():
    """At the crossing of a loop both places are equally near: the row before decides."""
    measured = splines.measure_splines(
        one([[0, 0, 0, 0, 0], [60, 40, 0, 0, 0], [-40, 40, 0, 0, 0], [20, 0, 0, 0, 0]], [1] * 4, [0, 0, 0, 1, 1, 1], 3),
        RADIAN_MM,
    )
    u = np.linspace(0.0, 1.0, 5001)
    piece = np.zeros(len(u), int)
    point = splines.evaluate_spline_points(
        measured.pieces, piece, splines.find_parameters_at(measured, piece, u, RADIAN_MM)
    )
    fresh = np.zeros(len(u), bool)
    fresh[0] = True
    np.testing.assert_allclose(splines.project(measured, piece, point, fresh, 0.0, RADIAN_MM, None), u, atol=1e-9)


# --- rows ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize("mode", ["G61", "G64"])
def test_rows_are_verified_and_on_the_curve(name, mode):
    result = made(program(WAVES + "G1 X95\n", mode), MACHINES[name])
    source = program(WAVES + "G1 X95\n", mode)
    verdict = judge(result.setpoints.values, result.setpoints.line, source, MACHINES[name])
    assert verdict.feed_ratio == pytest.approx(1.0, abs=1e-3)
    if mode == "G61":
        assert verdict.tip_deviation_mm < 1e-5


@pytest.mark.parametrize("cycle", [0.0005, 0.02, 0.1, 0.5])
def test_cycles_of_any_length(cycle):
    """At half a second a loop takes a handful of rows, which must still tell of it."""
    made(program(LOOP, feed=20_000), MACHINES["verne"], cycle=cycle)


def test_moved_rows_and_rows_left_out_are_refused():
    source, machine = program(WAVES), MACHINES["verne"]
    rows = made(source, machine).setpoints
    assert not judge(rows.values, rows.line, source, machine).findings
    n = len(rows.values)
    for column, shift in ((0, 0.004), (3, 0.002), (4, 0.003)):
        moved = rows.values.copy()
        moved[:, column] += shift * np.sin(np.linspace(0.0, np.pi, n)) ** 4  # as smooth as the motion
        assert any(item.code == "VP411" for item in judge(moved, rows.line, source, machine).findings), column
    kept = np.r_[0 : n // 2, n // 2 + 40 : n]
    assert judge(rows.values[kept], rows.line[kept], source, machine).findings


@pytest.mark.parametrize(
    "other", [WAVES.replace("R2.0", "R2.01"), WAVES.replace("X50.0", "X50.05"), WAVES.replace("C20.0", "C20.1")]
)
def test_rows_of_another_curve_are_refused(other):
    machine = MACHINES["verne"]
    rows = made(program(other), machine).setpoints
    assert any(item.code == "VP411" for item in judge(rows.values, rows.line, program(WAVES), machine).findings)


def test_rows_of_another_feed_are_refused():
    machine = MACHINES["verne"]
    rows = made(program(WAVES, feed=2010), machine).setpoints
    assert any(item.code == "VP404" for item in judge(rows.values, rows.line, program(WAVES), machine).findings)


def test_a_circle_of_weights_takes_the_time_of_the_arc():
    """Exactly the same tip path and feed: the rows take the same time to a cycle or two."""
    half = np.sqrt(0.5)
    corners = [(0, 0), (10, 0), (10, 10), (10, 20), (0, 20), (-10, 20), (-10, 10), (-10, 0), (0, 0)]
    circle = nurbs(
        [(x, y, 40, 0, 0) for x, y in corners],
        3,
        np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4.0]),
        np.array([1, half] * 4 + [1]),
    )
    machine = MACHINES["serial"]
    spline, arc = (made(program(body), machine).setpoints for body in (circle, "G3 X0 Y0 J10\n"))
    assert len(spline.values) == pytest.approx(len(arc.values), rel=0.02)


def test_degree_one_is_straight_moves_to_the_last_digit():
    points = [(0, 0, 40, 0, 0), (10, 5, 41, -2, 5), (20, -5, 42, -3, 9)]
    machine = MACHINES["verne"]
    spline = made(program(nurbs(points, 2)), machine).setpoints
    lines = made(program("".join("G1 X%g Y%g Z%g A%g C%g\n" % point for point in points[1:])), machine).setpoints
    np.testing.assert_array_equal(spline.values, lines.values)


@settings(max_examples=12)
@given(
    seed=st.integers(0, 1_000_000),
    order=st.integers(3, 4),
    power=st.floats(-1.0, 1.0),
    name=st.sampled_from(sorted(MACHINES)),
    mode=st.sampled_from(["G61", "G64"]),
)
def test_random_splines_under_random_limits(seed, order, power, name, mode):
    """Control points, knots, weights and limits by chance: what is made is verified."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(order, 12))
    points = np.zeros((n, 5))
    points[:, :2] = np.cumsum(rng.normal(size=(n, 2)) * 6.0, axis=0)
    points[:, 2] = 40.0 + rng.normal(size=n)
    points[:, 3] = -np.abs(np.cumsum(rng.normal(size=n)))
    points[:, 4] = np.cumsum(rng.normal(size=n) * 4.0)
    points[0] = [0, 0, 40, 0, 0]
    inner = np.cumsum(rng.uniform(0.2, 2.0, n - order + 1))
    knots = np.concatenate([np.zeros(order), inner, [inner[-1]] * (order - 1)])
    weights = np.exp(0.5 * rng.normal(size=n))
    machine = MACHINES[name]
    limits = machine.limits
    factor = 10.0**power
    machine = replace(
        machine,
        cycle=0.004,
        limits=replace(
            limits,
            velocity=limits.velocity * factor,
            acceleration=limits.acceleration * factor,
            jerk=limits.jerk * factor,
        ),
    )
    result = convert(program(nurbs(points, order, knots, weights), mode), machine, options())
    assert result.ok or {item.code for item in result.findings} <= {"VP101", "VP102", "VP210"}, result.findings


#: Curves of order 3 of a tenth of a millimetre beside which the table turns by degrees: control points, weights, knots.
TINY = {
    "a corner that is nearly a reversal": (
        "0 0 40 0 0; -0.050282 0.549007 40.0705 -1.63524 -2.31417; -0.320808 0.354226 39.9685 -4.88031 -4.32097; "
        "-0.098175 0.42947 40.039 -4.75634 -1.84605; -0.323153 0.045182 39.8067 -4.06491 -3.36619; -0.150699 0.283105 "
        "40.7569 -1.64457 -4.59363; -0.010359 0.60195 40.525 -2.0672 3.22881; 0.117988 0.183714 40.695 -0.720534 "
        "9.47559; 0.790074 0.339563 39.7496 -0.525645 7.11166",
        "0.295361 3.29684 0.033942 2.61 0.114478 0.3771 1.11555 0.329651 0.585557",
        "0 0 0 1.1781 1.1781 3.01173 3.91506 5.17035 6.75566 6.92442 6.92442 6.92442",
    ),
    "angles that change their sense": (
        "0 0 40 0 0; 0.004819 0.022104 39.9925 -1.83264 2.40479; -0.00995 0.001258 39.9966 -1.71898 3.81776; 0.008744 "
        "-0.008276 40.0074 -2.11185 -1.81456; -0.001985 0.0046 40.0134 -4.05353 1.01957; 0.010107 0.01093 39.9833 "
        "-1.95693 0.388376; -0.009917 0.016963 39.9843 -1.22302 -4.15788; -0.006007 -0.001579 40.0041 -0.709637 "
        "1.15539; 0.00613 0.020879 39.9994 -0.091505 10.7051",
        "0.068009 14.2317 2.22207 0.121886 0.360096 0.143628 0.448947 0.551559 0.388855",
        "0 0 0 0.654882 1.4388 1.86843 3.15648 3.57649 4.89266 5.87798 5.87798 5.87798",
    ),
    "angles far larger than the tip's way": (
        "0 0 40 0 0; 0.012432 -0.025679 39.9899 -0.235367 -0.812021; 0.037339 -0.033742 40.032 -0.174967 -2.51026; "
        "0.069466 -0.080174 39.9697 -0.223046 -7.17186; 0.081625 -0.07373 40.0405 -0.87495 -7.43581; 0.098163 "
        "-0.012556 39.9415 -1.03974 -6.83644; 0.134998 -0.003662 40.0131 -0.803883 -8.34562; 0.161013 0.002773 39.992 "
        "-1.07323 -7.67512; 0.161686 -0.025707 39.9879 -0.700795 -8.50935",
        "1.15138 1.05297 0.858209 1.17991 1.25678 0.856884 0.98337 0.649719 0.919679",
        "0 0 0 1.37175 1.37175 4.63821 5.48076 6.93624 8.11878 9.47814 9.47814 9.47814",
    ),
}


@pytest.mark.parametrize("what", TINY)
@pytest.mark.parametrize("cycle", [0.002, 0.05])
def test_tiny_curves_beside_large_turns(what, cycle):
    points, weights, knots = (np.array([row.split() for row in text.split(";")], dtype=float) for text in TINY[what])
    body = nurbs(points, 3, knots[0], weights[0]) + f"G1 X{points[-1, 0] + 5:.3f} Y1\n"
    made(program(body, "G64", 10_000), replace(MACHINES["verne"], cycle=cycle))


# --- places that are near each other ------------------------------------------------------------------


def split(points, t):
    """Control points of a Bezier curve before and after its parameter t (de Casteljau)."""
    points = np.array(points, dtype=float)
    before, after = [points[0]], [points[-1]]
    while len(points) > 1:
        points = (1 - t) * points[:-1] + t * points[1:]
        before.append(points[0])
        after.insert(0, points[-1])
    return before, after


def test_rows_aside_of_a_hairpin_are_followed():
    """Rows aside of both legs, nearer to the first one on the way back too, within the bound: they go on."""
    legs = [[0, 0, 0, 0, 0], [20, 0, 0, 0, 0], [20, 0.02, 0, 0, 0], [0, 0.012, 0, 0, 0]]
    measured = splines.measure_splines(one(legs, [1] * 4, [0, 0, 0, 1, 1, 1], 3), RADIAN_MM)
    u = np.linspace(0.0, 1.0, 2001)
    piece, fresh = np.zeros(len(u), int), np.arange(len(u)) == 0
    pose = splines.evaluate_spline_points(
        measured.pieces, piece, splines.find_parameters_at(measured, piece, u, RADIAN_MM)
    )
    pose[:, 1] += np.interp(u, [0.0, 0.5, 0.9, 1.0], [0.0, 0.0, -0.009, -0.009])
    bounds = np.full(len(u), 0.01), np.full(len(u), 1e-3)
    found = splines.project(measured, piece, pose, fresh, 0.0, RADIAN_MM, bounds)
    np.testing.assert_allclose(found, u, atol=1e-3)
    alone = splines.project(measured, piece, pose, fresh, 0.0, RADIAN_MM, None)
    assert np.abs(alone - u).max() > 0.5  # each row by itself is taken for one of the other leg


@pytest.mark.parametrize("mode", ["G61", "G64"])
def test_a_loop_that_is_left_out_is_refused(mode):
    """Rows go to where a curve crosses itself, stop, and go on beyond the loop; each is on the curve."""
    points = [(0, 0, 40, 0, 0), (60, 40, 40, 0, 0), (-40, 40, 40, 0, 0), (20, 0, 40, 0, 0)]
    crossing = 0.5 - 0.25 * np.sqrt(3.0)
    begin, end = split(points, crossing)[0], split(points, 1.0 - crossing)[1]
    np.testing.assert_allclose(begin[-1], end[0], atol=1e-12)
    machine, whole = MACHINES["verne"], program(LOOP + "G1 X30\n", mode)
    lines = np.unique(made(whole, machine).setpoints.line)
    rows = made(program(nurbs(begin) + nurbs(end) + "G1 X30\n"), machine).setpoints
    line = np.where(rows.line < rows.line.max(), *lines)
    assert "VP412" in {item.code for item in judge(rows.values, line, whole, machine).findings}


def test_rows_that_go_back_beside_a_corner_are_refused():
    """By no more in a step than the tolerance of the corner."""
    machine, whole = MACHINES["verne"], program("G1 X40\nG1 Y10\n", "G64")
    lines = np.unique(made(whole, machine).setpoints.line)
    rows = made(program("G1 X30\nG1 X10\nG1 X40\nG1 Y10\n"), machine).setpoints
    line = np.where(rows.line < rows.line.max(), *lines)
    assert "VP413" in {item.code for item in judge(rows.values, line, whole, machine).findings}


#: Rounded corners beside turns of curves that are about as narrow as the tolerance.
NARROW = {
    "the second leg is nearer to the next move": (
        "G0 X-13 Y-2\nG5.2 X-19 Y-4 P1 F13204\nX-11.34 Y-2.1247 P1\nG5.3\nG5.1 Y-2.11 I-0.1 J-0.02\nG1 Y-2.2\n"
    ),
    "a curve that crosses itself beside its beginning": (
        "G0 X-34 Y-20\nG5.2 X-35 Y-32 P1 F1080\nX-35 Y-36 P0.5\nX-33.5 Y-37.2 P1\nG5.3\n"
        "G5.2 X-33 Y-37 P1 L5\nX-33 Y-38 P0.2\nX-33.4 Y-38 P2\nX-33.4 Y-37 P0.5\nG5.3\n"
    ),
    "rows that do not go to the end of the turn": (
        "G0 X17.7170 Y7.0050\nG5.2 X22.6614 Y-6.8620 P1 L3 F1000\nX20.9907 Y-1.8006 P1\nX35.3496 Y19.0707 P1\nG5.3\n"
        "G5.2 X39.5872 Y18.7497 P1 L5 F1000\nX39.3855 Y19.1314 P1\nX39.0673 Y19.1265 P0.2\nX39.4090 Y19.1082 P5\nG5.3\n"
    ),
}


@pytest.mark.parametrize("what", NARROW)
def test_corners_beside_narrow_turns(what):
    made(f"G21 G90 G94 G17\n{NARROW[what]}M2\n".encode(), MACHINES["verne"])


HAIRPINS = {
    "exact, half a micrometer wide, after another curve": (
        "G61\nF12000\nG5.2 X1 Y0 P1 L4\nX0 Y0 P1\nX0 Y1 P1\nG5.3\nG1 X-0.855 Y1.25\nG5.2 X-0.854 Y1 P1 L3\n"
        "X-0.8532 Y1.2499 P0.301\nG5.3",
        0.001,
    ),
    "blended, after an arc": (
        "F1000\nG5.2 P1 L4\nX1 Y0 P1\nX0 Y1 P1\nX0 Y0 P1\nG5.3\nG3 X-0.075 Y0.24 I0.05 J0.13\n"
        "G5.1 X-0.081 Y0.2437 I0.0652 J0",
        0.001,
    ),
    "some nanometers wide, long cycles": (
        "G64 P0.002\nF12000\nG5.1 X0.0005 Y0 I-0.0171 J-0.0004\nG5.1 X0.0034 Y0.026 I0.0185 J-0.0185\n"
        "G1 X-0.0023 Y0.0234 Z40.0019\nG1 X-0.0074 Y0.0268\nG5.1 X-0.0178 Y0.0373 I0 J-0.0606",
        0.01,
    ),
    "10 mm long, a hundred nanometers wide": ("F3000\nG5.1 X0 Y0.0001 I10 J0", 0.001),
}


@pytest.mark.parametrize("what", HAIRPINS)
def test_hairpins_are_passed_and_verified(what):
    """A bend that is narrower than rows can show does not slow the whole curve down: it took minutes, hours or all
    memory.
    """
    body, cycle = HAIRPINS[what]
    source = f"G21 G90 G94 G17 G64\nG0 X0 Y0 Z40 A0 C0\n{body}\nM2\n".encode()
    result = made(source, MACHINES["serial"], cycle=cycle)
    assert result.summary.cycle_time < 3.0
