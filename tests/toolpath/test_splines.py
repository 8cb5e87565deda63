"""Spline segments: where the tool flows along them, curves that equal arcs and lines, and how the table turns beside
them.
"""

import numpy as np
import pytest
from scipy.interpolate import BSpline

import verne_post
from verne_post.app.assemble import assemble
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.model.splines import GrowingSplines, Splines
from verne_post.model.toolpath import SegmentKind
from verne_post.toolpath.contour_pose import find_contour_pose
from verne_post.toolpath.evaluate import differentiate_pose, evaluate_pose
from verne_post.toolpath.splines import turn_pieces

from .polylines import MACHINE, contour_of, poses_at
from .test_contour import lines_named, stops

HALF = f"{np.sqrt(0.5):.15f}"
#: Quarters of a circle of 10 mm about X0 Y10, from X0 Y0 anticlockwise, as G6.2 of order 3.
CIRCLE = f"""G6.2 P3 K0 X0 Y0 R1
K0 X10 Y0 R{HALF}
K0 X10 Y10 R1
K1 X10 Y20 R{HALF}
K1 X0 Y20 R1
K2 X-10 Y20 R{HALF}
K2 X-10 Y10 R1
K3 X-10 Y0 R{HALF}
K3 X0 Y0 R1
K4
K4
K4
"""
WAVES = """G6.2 P4 K0 X0 Y0 Z40 A0 C0
K0 X10 Y20 Z41 A-3 C5
K0 X30 Y25 Z42 A-8 C20
K0 X50 Y0 Z44 A-10 C30 R2
K1 X70 Y-20 Z43 A-8 C30
K2 X90 Y0 Z40 A-5 C30
K3
K3
K3
K3
"""


def fanuc(body: str) -> str:
    return f"%\nO1 (A)\nG21 G90 G94 G17 F1000\nG0 X0 Y0 Z40 A0 C0\n{body}M30\n%\n"


# Line 1 is the head, line 2 the start; the body begins on line 3.
BODIES: dict[str, tuple[str, set[tuple[int, int]]]] = {
    "pieces of order 3 have corners in curvature": ("G61\nG5.2 X5 Y5 P1 L3\nX9 Y0 P1\nX15 Y3 P1\nG5.3", {(5, 6)}),
    "which are blended": ("G64 P0.01\nG5.2 X5 Y5 P1 L3\nX9 Y0 P1\nX15 Y3 P1\nG5.3", set()),
    "pieces of order 4 flow": ("G61\nG5.2 X5 Y5 P1 L4\nX9 Y0 P1\nX15 Y3 P1\nX19 Y5 P1\nX25 Y1 P1\nG5.3", set()),
    "with weights as well": ("G61\nG5.2 X5 Y5 P3 L4\nX9 Y0 P1\nX15 Y3 P0.2\nX19 Y5 P2\nX25 Y1 P1\nG5.3", set()),
    "and stop once": ("G61.1\nG5.2 X5 Y5 P1 L4\nX9 Y0 P1\nX15 Y3 P1\nX19 Y5 P1\nX25 Y1 P1\nG5.3\nG1 Y9", {(8, 10)}),
    "a line leads into a bend": ("G61\nG1 X5\nG5 X15 Y5 I3 J0 P-3 Q-3", {(4, 5)}),
    "a line leads into a straight beginning": ("G61\nG1 X5\nG5.2 X7 Y0 P1 L4\nX9 Y0 P1\nX15 Y9 P1\nG5.3", set()),
    "bezier curves in a row": ("G61\nG5 X10 Y0 I3 J3 P-3 Q3\nG5 X20 Y0 P-3 Q-3", {(4, 5)}),
}


@pytest.mark.parametrize("what", BODIES)
def test_where_it_flows_and_where_it_stops(what: str) -> None:
    body, expected = BODIES[what]
    assert stops(contour_of(lines_named(body))) - {(2, 4), (2, 5), (2, 6)} == expected


@pytest.mark.parametrize("body", ["G64\n" + WAVES + "G1 X100\n", "G61\n" + WAVES, "G61\n" + CIRCLE])
def test_sections_are_smooth_and_tips_even(body: str) -> None:
    contour = contour_of(fanuc(body))
    n = len(contour)
    element = np.repeat(np.arange(n), 9)
    w, step = np.tile(np.linspace(0.1, 0.9, 9), n), 1e-5
    tips = [find_contour_pose(contour, element, w + side * step)[0] for side in (-1, 1)]
    speed = np.linalg.norm(tips[1] - tips[0], axis=1) / (2 * step * contour.length[element])
    splined = contour.path.kind[contour.segment[element]] == SegmentKind.SPLINE
    plain = splined & ~contour.blended[element]
    np.testing.assert_allclose(speed[plain], 1.0, atol=1e-8)


def test_a_circle_of_weights_is_the_circle() -> None:
    """One section, the length and the derivatives of the arc."""
    spline = contour_of(fanuc("G61\n" + CIRCLE)).path
    arc = contour_of(lines_named("G61\nG3 X0 Y0 J10")).path
    assert spline.n_sections == 1
    assert spline.length.sum() == pytest.approx(20.0 * np.pi, abs=1e-9)
    u = np.linspace(0.0, 1.0, 41)
    for quarter in range(4):
        mine = np.full(len(u), quarter)
        tip, _angles = evaluate_pose(spline, mine, u)
        wanted, _same = evaluate_pose(arc, np.zeros(len(u), int), (quarter + u) / 4)
        np.testing.assert_allclose(tip, wanted, atol=1e-9)
        for order, (here, there) in enumerate(
            zip(
                differentiate_pose(spline, mine, u),
                differentiate_pose(arc, np.zeros(len(u), int), (quarter + u) / 4),
                strict=True,
            ),
            start=1,
        ):
            np.testing.assert_allclose(here[:, :3] * 4**order, there[:, :3], rtol=1e-9, atol=1e-6)


def test_table_angles_are_coordinates_of_the_same_spline() -> None:
    path = contour_of(fanuc("G61\n" + WAVES)).path
    points = np.array(
        [
            [0, 0, 40, 0, 0],
            [10, 20, 41, -3, 5],
            [30, 25, 42, -8, 20],
            [50, 0, 44, -10, 30],
            [70, -20, 43, -8, 30],
            [90, 0, 40, -5, 30],
        ],
        dtype=float,
    )
    weights = np.array([1.0, 1, 1, 2, 1, 1])
    plane = BSpline(
        np.array([0, 0, 0, 0, 1, 2, 3, 3, 3, 3.0]), np.column_stack([points * weights[:, None], weights]), 3
    )
    t = np.linspace(0.0, 3.0, 4001)
    exact = plane(t)[:, :5] / plane(t)[:, 5:]
    exact[:, 2] += 50.0  # G54 on the table
    exact[:, 3:] = np.radians(exact[:, 3:])
    signs = np.sign(evaluate_pose(path, np.array([2]), np.array([1.0]))[1] / exact[-1, 3:])  # of the machine file
    for segment in range(3):
        tip, angles = evaluate_pose(path, np.full(7, segment), np.linspace(0.0, 1.0, 7))
        for here, turned in zip(tip, angles * signs, strict=True):
            nearest = np.argmin(np.linalg.norm(exact[:, :3] - here, axis=1))
            assert np.linalg.norm(exact[nearest, :3] - here) < 0.05
            np.testing.assert_allclose(turned, exact[nearest, 3:], atol=2e-4)


def test_derivatives_are_those_of_the_poses() -> None:
    path = contour_of(fanuc("G61\n" + WAVES)).path
    u, step = np.linspace(0.05, 0.95, 13), 2e-3
    for segment in range(3):
        mine = np.full(len(u), segment)
        values = [np.hstack(evaluate_pose(path, mine, u + k * step)) for k in range(-3, 4)]
        first, second, third = differentiate_pose(path, mine, u)
        stencils = {
            1: np.array([-1, 9, -45, 0, 45, -9, 1]) / 60 / step,
            2: np.array([2, -27, 270, -490, 270, -27, 2]) / 180 / step**2,
            3: np.array([1, -8, 13, 0, -13, 8, -1]) / 8 / step**3,
        }
        for order, exact in ((1, first), (2, second), (3, third)):
            differences = np.einsum("k,knj->nj", stencils[order], np.array(values))
            np.testing.assert_allclose(exact, differences, rtol=2e-3, atol=2e-4 * np.abs(exact).max())


def test_a_blend_beside_a_spline_is_smooth_and_within_tolerance() -> None:
    contour = contour_of(lines_named("G64 P0.05\nG1 X5\nG5 X15 Y5 I3 J0 P-3 Q-3\nG1 Y9"))
    assert contour.n_blended == 2
    ends = np.cumsum(contour.length)[:-1]
    step = 1e-4
    for order, stencil in ((0, [1.0]), (1, [-1.5, 2.0, -0.5]), (2, [2.0, -5.0, 4.0, -1.0])):
        sides = []
        for side, name in ((-1, "before"), (1, "after")):
            values = [weight * poses_at(contour, ends + side * k * step, name) for k, weight in enumerate(stencil)]
            sides.append(np.sum(values, axis=0) * side**order / step**order)
        np.testing.assert_allclose(sides[0], sides[1], atol=[1e-9, 1e-5, 1e-3][order])


def drawn_pieces(degree: int, m: int) -> Splines:
    rng = np.random.default_rng(degree)
    points = rng.normal(size=(m * (degree + 1), 5))
    knots = np.sort(rng.uniform(size=(m, 2 * degree)), axis=1)
    return Splines(
        np.full(m, degree, np.int32),
        (degree + 1) * np.arange(m),
        2 * degree * np.arange(m),
        points,
        np.exp(rng.normal(size=len(points))),
        knots.ravel(),
    )


def angles_along(pieces: Splines) -> np.ndarray:
    from verne_post.verification.splines import evaluate_spline_points

    m = len(pieces)
    share = np.linspace(0.0, 1.0, 5)
    rows = []
    for piece in range(m):
        degree, first = pieces.degree[piece], pieces.first_knot[piece]
        low, high = pieces.knots[first + degree - 1], pieces.knots[first + degree]
        rows.append(evaluate_spline_points(pieces, np.full(5, piece), low + share * (high - low)))
    return np.array(rows)


@pytest.mark.parametrize("degree", [1, 2, 3, 5])
def test_other_branches_of_the_table(degree: int) -> None:
    """Angles are counted from the start; on the other branch A has the other sign; in place C may turn on the way."""
    pieces = drawn_pieces(degree, 3)
    exact = angles_along(pieces)
    start, end = exact[:, 0].copy(), exact[:, -1].copy()
    expected = exact.copy()
    expected[:, :, 3:] -= exact[:, :1, 3:]
    for poses in (start, end):
        poses[1, 3:] = [-poses[1, 3], poses[1, 4] + np.pi]
    expected[1, :, 3] *= -1.0
    end[2, 4] += 0.5
    turned = angles_along(turn_pieces(pieces, start, end))
    np.testing.assert_allclose(turned[:2], expected[:2], atol=1e-12)
    np.testing.assert_allclose(turned[2, :, :4], expected[2, :, :4], atol=1e-12)
    np.testing.assert_allclose(turned[2, [0, -1], 4], expected[2, [0, -1], 4] + [0.0, 0.5], atol=1e-12)


def test_tables_of_pieces_of_several_degrees() -> None:
    both = GrowingSplines(5)
    for degree in (3, 1, 5):
        both.extend(drawn_pieces(degree, 2))
    every = both.freeze()
    picked = every.select(np.array([4, 0, 2]))
    np.testing.assert_array_equal(angles_along(picked), angles_along(every)[[4, 0, 2]])
    assert picked.degree.tolist() == [5, 3, 1]


def test_work_offsets_planes_and_lifts_move_control_points() -> None:
    """A turned, shifted, lifted part has the same curve, turned, shifted, lifted."""
    plain = assemble(fanuc(CIRCLE).encode(), MACHINE, Options(tool_length=80.0)).contour.path
    offset = WorkOffset((7.0, -3.0, 60.0), 30.0)
    moved = assemble(
        fanuc(CIRCLE).encode(), MACHINE, Options(tool_length=80.0, wcs={1: offset}, air=4.0, air_along="table")
    )
    c, s = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
    u = np.linspace(0.0, 1.0, 5)
    base = evaluate_pose(plain, np.zeros(5, int), np.zeros(5))[0][0] - [0.0, 0.0, 40.0]
    for segment in range(4):
        here = evaluate_pose(plain, np.full(5, segment), u)[0] - base
        there = evaluate_pose(moved.contour.path, np.full(5, segment), u)[0] - [7.0, -3.0, 64.0]
        turned = np.column_stack([c * here[:, 0] - s * here[:, 1], s * here[:, 0] + c * here[:, 1], here[:, 2]])
        np.testing.assert_allclose(there, turned, atol=1e-8)


def test_a_loop_in_one_block_and_blocks_of_the_path(monkeypatch: pytest.MonkeyPatch) -> None:
    """Tables that are made block by block have the same splines."""
    source = fanuc("G61\n" + WAVES + "G0 X0 Y0 Z40 A0 C0\n" + CIRCLE + "G0 X0 Y0 Z40\n" + WAVES)
    whole = contour_of(source).path
    monkeypatch.setattr("verne_post.base.columns.BLOCK_ROWS", 2)
    apart = contour_of(source).path
    rows = np.repeat(np.arange(len(whole)), 5)
    u = np.tile(np.linspace(0.0, 1.0, 5), len(whole))
    np.testing.assert_array_equal(np.hstack(evaluate_pose(whole, rows, u)), np.hstack(evaluate_pose(apart, rows, u)))
    np.testing.assert_array_equal(whole.section, apart.section)


def test_dry_run_along_the_tool_keeps_the_curve() -> None:
    result = verne_post.check(
        fanuc(WAVES), MACHINE, Options(tool_length=80.0, wcs={1: WorkOffset((0, 0, 50.0))}, air=5.0)
    )
    assert result.ok
