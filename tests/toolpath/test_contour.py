"""Where the tool flows and where it stops, and what a contour is made of."""

import numpy as np
import pytest

from verne_post.app.assemble import assemble
from verne_post.model.contour import Contour
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.model.toolpath import SegmentKind
from verne_post.toolpath.contour_pose import find_contour_pose, find_speed_cap
from verne_post.toolpath.evaluate import evaluate_pose

from ..builders import MACHINE
from .polylines import contour_of

HEAD = "G21 G90 G94 G17 F1000"
START = "G0 X0 Y0 Z40 A0 C0"


def stops(contour: Contour) -> set[tuple[int, int]]:
    """Pairs of source lines between which the contour stops."""
    ends = np.flatnonzero(np.diff(contour.section))
    return {(int(contour.find_lines()[k]), int(contour.find_lines()[k + 1])) for k in ends}


# Line 1 is the head, line 2 the start; the body begins on line 3.
BODIES: dict[str, tuple[str, set[tuple[int, int]]]] = {
    "no word is G64": ("G1 X5\nY5\nX0", set()),
    "G64": ("G64\nG1 X5\nY5\nX0", set()),
    "G64 P": ("G64 P0.02\nG1 X5\nY5\nX0", set()),
    "G64 P0": ("G64 P0\nG1 X5\nY5\nX0", {(4, 5), (5, 6)}),
    "G61": ("G61\nG1 X5\nY5\nX0", {(4, 5), (5, 6)}),
    "G61 along a line": ("G61\nG1 X5\nX7\nX9", set()),
    "G61.1 along a line": ("G61.1\nG1 X5\nX7\nX9", {(4, 5), (5, 6)}),
    "G64 P0 along a line": ("G64 P0\nG1 X5\nX7\nX9", set()),
    "G61 in the middle": ("G1 X5\nY5\nG61\nX0\nY0\nG64\nX9\nY9", {(4, 6), (6, 7), (7, 9)}),
    "G61.1 in the middle": ("G1 X5\nY5\nG61.1 X0\nY0\nG64 X9\nY9", {(4, 5), (5, 6), (6, 7)}),
    "G64 P0 in the middle": ("G1 X5\nY5\nG64 P0\nX0\nG64 P0.1\nX9 Y15\nX0", {(4, 6), (6, 8)}),
    "a dwell": ("G1 X5\nG4 P0.1\nY5\nX0", {(3, 5)}),
    "a dwell along a line": ("G1 X5\nG4 P0.1\nX7\nX9", {(3, 5)}),
    "a dwell of no time": ("G1 X5\nG4 P0\nY5\nX0", {(3, 5)}),
    "a reversal": ("G1 X5\nX0\nY5", {(3, 4)}),
    "rapids flow": ("G0 X5\nG1 Y5\nG0 X0\nZ50", set()),
    "a change of feed on a line": ("G1 X5\nX9 F2000\nX12 F500", set()),
    "a line of many minutes": ("G1 X5\nY15 F1\nX0 F1000\nY0", {(3, 4), (4, 5)}),
    "a slow line of seconds": ("G1 X5\nY15 F60\nX0 F1000\nY0", set()),
    "another part zero, the same place": ("G1 X5\nG55 X3 Y3 Z30\nG54 Y5", set()),
    "home": ("G1 X5\nY5\nG28 X9 Y9 Z60\nG1 X4 Y9", {(5, 5)}),
    "machine coordinates": ("G1 X5\nY5\nG53 G0 Z-200\nG0 X1", set()),
    "tangent to an arc": ("G1 X5\nG3 X10 Y5 J5\nG1 Y9", set()),
    "no tangent to an arc": ("G1 X5\nG2 X15 I5\nG1 X20", set()),
    "arc to arc": ("G2 X10 I5\nG3 X20 I5\nG2 X30 I5", set()),
    "against an arc": ("G1 X5\nG3 X5 Y10 J5\nG1 X9\nG3 X9 Y20 J5", {(4, 5)}),
    "full circles": ("G1 X5\nG2 I5\nG3 I-5\nG1 Y5", set()),
    "the same circle twice": ("G1 X5\nG3 J5\nG3 J5\nG1 Y5", set()),
    "a helix": ("G1 X5\nG3 X5 Y0 Z36 J5 P2\nG1 X9", set()),
    "a helix under tilt": ("G1 A5 C30\nG3 X5 Y5 Z36 A9 C10 J5\nG1 X9 A0", set()),
    "turns": ("G1 A5\nC30\nA0 C50\nX5", set()),
    "great circles": ("G43.5\nG1 X1 I0.1 J0.1 K0.98995\nX2 I0.2 J0.1 K0.97468\nX3 I0.2 J0.2 K0.95917", set()),
}


def lines_named(body: str) -> str:
    return f"{HEAD}\n{START}\n{body}\nM2\n"


@pytest.mark.parametrize("mode", ["blend", "spline"])
@pytest.mark.parametrize("what", BODIES)
def test_where_it_flows_and_where_it_stops(what: str, mode: str) -> None:
    body, expected = BODIES[what]
    assert stops(contour_of(lines_named(body), mode)) == expected


@pytest.mark.parametrize("what", BODIES)
def test_off_stops_wherever_the_path_bends(what: str) -> None:
    contour = contour_of(lines_named(BODIES[what][0]), "off")
    assert contour.n_blended == 0
    np.testing.assert_array_equal(contour.section, contour.path.section)
    assert (contour.tip_tolerance == 0).all()


def test_a_tool_of_another_length_stops_and_so_do_motions_of_one_line() -> None:
    source = f"{HEAD}\nG43.1 Z10\n{START}\nG1 X5\nY5\nG43.1 Z12\nG0 X9\nG1 Y9\nG0 Y20\nM2\n"
    contour = assemble(source.encode(), MACHINE, Options()).contour
    assert stops(contour) == {(5, 7)}


@pytest.mark.parametrize(
    ("body", "n_blended"),
    [
        ("G1 X[#1] Y[10 * SIN[20 * #1]]", 8),
        ("G1 X[0.04 * #1] Y[0.04 * SIN[90 * #1]]", 0),  # shorter than eight tolerances
        ("G1 X[#1] A[#1] C[#1 * #1]", 8),
        ("G1 A[#1] C[#1 * #1]", 0),
        ("G0 X[#1] Y[10 * SIN[20 * #1]]", 0),
    ],
)
def test_feed_moves_of_one_line_are_blended_and_rapids_are_not(body: str, n_blended: int) -> None:
    loop = f"#1 = 0\no1 WHILE [#1 LT 9]\n#1 = [#1 + 1]\n{body}\no1 ENDWHILE"
    contour = assemble(f"{HEAD}\nG43.1 Z10\n{START}\nF900\n{loop}\nM2\n".encode(), MACHINE, Options()).contour
    line = int(contour.path.line[-1])
    inner = (contour.path.line[1:] == line) & (contour.path.line[:-1] == line)
    assert inner.sum() == 8
    assert contour.n_blended - n_blended in (0, 1)  # with the corner before the loop


def test_approach_and_table_changes_stop() -> None:
    """A rewind between feed moves is made of segments that no line of the program says: nothing is rounded there."""
    body = "G43.5\nG1 X1 I0.1 J0.1 K0.98995\nX2 I0.2 J0.1 K0.97468\nX3 I0.2 J0.2 K0.95917"
    options = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 50.0))}, approach="home")
    contour = assemble(lines_named(body).encode(), MACHINE, options).contour
    path = contour.path
    added = np.flatnonzero((path.move < 0) | (path.kind == SegmentKind.JOINT))
    assert len(added)
    assert (contour.tip_tolerance[added] == 0).all()
    section = np.zeros(len(path), dtype=int)
    section[contour.segment] = contour.section
    assert section[added[-1] + 1] > section[added[-1]]
    assert np.isin(contour.segment[contour.blended], added).sum() == 0


# --- elements ---------------------------------------------------------------------------------------

MIXED = """G1 X5 Y1
G3 X10 Y6 J5
G1 Y9
G1 Y12.4 X10.3
G64 P0.2
X14 A3 C20
A5 C40
G2 X24 Y12.4 I5 J0
G2 X34 Y12.4 I5 Z41 A2
G1 X34 Y5 F4000
X33.9 Y4.9
X33.7 Y4.8
X33.4 Y4.75
G3 I-3 J0
G0 X30
Z45
G4 P0.01
G1 X0 Y0 A0 C0
G61
X3
Y3
G64 P0.05
X9 Y3
X12 Y3.4"""


@pytest.mark.parametrize("mode", ["off", "blend", "spline"])
def test_elements_cover_every_segment_once_and_in_order(mode: str) -> None:
    for body in (MIXED, *(body for body, _stops in BODIES.values())):
        contour = contour_of(lines_named(body), mode)
        n = len(contour)
        assert (np.diff(contour.segment) >= 0).all()
        assert (np.diff(contour.section) >= 0).all()
        assert (np.diff(contour.section) <= 1).all()
        np.testing.assert_array_equal(np.unique(contour.segment), np.arange(len(contour.path)))
        element = np.arange(n)
        begin = np.hstack(find_contour_pose(contour, element, np.zeros(n)))
        end = np.hstack(find_contour_pose(contour, element, np.ones(n)))
        lines = contour.path.kind[contour.segment] != SegmentKind.JOINT
        gap = np.abs(begin[1:] - end[:-1])[lines[1:] & lines[:-1]]
        assert gap.max(initial=0.0) < 1e-9
        share = contour.high - contour.low
        np.testing.assert_allclose(contour.length, share * contour.path.length[contour.segment], rtol=1e-12)
        np.testing.assert_allclose(np.bincount(contour.segment, share, minlength=len(contour.path)), 1.0, atol=2e-9)


@pytest.mark.parametrize("mode", ["off", "blend", "spline"])
def test_speed_cap_is_the_feed_over_the_motion_of_the_tip(mode: str) -> None:
    contour = contour_of(lines_named(MIXED), mode)
    path = contour.path
    h = 1e-4
    w = np.array([0.11, 0.37, 0.5, 0.73, 0.92])
    element, w = np.repeat(np.arange(len(contour)), len(w)), np.tile(w, len(contour))
    before, after = (np.hstack(find_contour_pose(contour, element, w + sign * h)) for sign in (-1, 1))
    rate = (after - before) / (2 * h * contour.length[element])[:, None]
    segment = contour.segment[element]
    cap = find_speed_cap(contour, element, w)
    rapid = path.feed_time[segment] == 0
    assert np.isinf(cap[rapid]).all()
    # programmed speed of the tip; where only the angles move, the time of the segment
    ends = (
        np.hstack(evaluate_pose(path, segment, np.full(len(segment), 0.5 + 1e-4))),
        np.hstack(evaluate_pose(path, segment, np.full(len(segment), 0.5 - 1e-4))),
    )
    along = (ends[0] - ends[1]) / 2e-4
    by_tip = np.linalg.norm(along[:, :3], axis=1) > 1e-6
    fed = ~rapid
    some = fed & by_tip
    wanted = np.linalg.norm(along[some, :3], axis=1) / path.feed_time[segment[some]]
    found = cap[some] * np.linalg.norm(rate[some, :3], axis=1)
    np.testing.assert_allclose(found, wanted, rtol=2e-5)  # second differences over h: 1e-6 in the sharpest curves
    some = fed & ~by_tip
    assert some.any()
    np.testing.assert_allclose(cap[some] * path.feed_time[segment[some]], path.length[segment[some]], rtol=1e-12)


def test_a_corner_blend_across_a_smooth_joint_does_not_reach_into_a_curve() -> None:
    """The short segment after the arc continues in the next: the corner blend at its end may reach over both."""
    contour = contour_of(lines_named("G64 P0.5\nG1 Y5\nG2 X5 Y10 I5\nG1 X7 Y12\nX9 Y14\nX19 Y24.2"), "spline")
    n = np.arange(len(contour))
    gap = np.hstack(find_contour_pose(contour, n[1:], 0.0 * n[1:])) - np.hstack(
        find_contour_pose(contour, n[:-1], 0.0 * n[1:] + 1)
    )
    assert contour.n_blended >= 3
    assert np.abs(gap).max() < 1e-9
