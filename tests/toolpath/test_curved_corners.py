"""Corners beside arcs, splines and great circles: smooth to the third derivative, and within tolerance of both
segments.
"""

import numpy as np
import pytest

from verne_post.base.units import ROTARY_METRIC_MM
from verne_post.model.contour import Contour
from verne_post.toolpath import curved_corners
from verne_post.toolpath.contour_pose import find_contour_pose
from verne_post.toolpath.corner_shapes import BRAKING, PEAK, SHAPES
from verne_post.toolpath.evaluate import evaluate_pose

from .polylines import contour_of, ends_of_blends, jumps, poses_at
from .test_contour import BODIES, MIXED, lines_named
from .test_splines import WAVES, fanuc


def arcs(seed: int, turning: bool) -> str:
    """Lines and arcs of 1 to 20 mm radius in any order; every second corner is tangent, or nearly; maybe with A
    and C.
    """
    rng = np.random.default_rng(seed)
    at, heading, words = np.zeros(2), 0.0, ["G64 P0.01"]
    for number in range(16):
        heading += rng.uniform(-2.0, 2.0) if number % 2 else rng.choice([0.0, 0.02, -0.1])
        along = np.array([np.cos(heading), np.sin(heading)])
        turn = f" A{rng.uniform(-5, 5):.3f} C{rng.uniform(-20, 20):.3f}" if turning and rng.random() < 0.5 else ""
        if rng.random() < 0.6:
            radius, sweep = 10.0 ** rng.uniform(0.0, 1.3), rng.uniform(0.2, 1.5) * rng.choice([-1, 1])
            center = at + np.sign(sweep) * radius * np.array([-along[1], along[0]])
            turned = np.array([[np.cos(sweep), -np.sin(sweep)], [np.sin(sweep), np.cos(sweep)]])
            end = center + turned @ (at - center)
            offset = center - at
            words.append(
                f"G{3 if sweep > 0 else 2} X{end[0]:.9f} Y{end[1]:.9f} I{offset[0]:.9f} J{offset[1]:.9f}{turn}"
            )
            heading += sweep
        else:
            end = at + rng.uniform(0.5, 6.0) * along
            words.append(f"G1 X{end[0]:.9f} Y{end[1]:.9f}{turn}")
        at = np.array([float(f"{end[0]:.9f}"), float(f"{end[1]:.9f}")])
    return lines_named("\n".join(words))


#: A spline that begins with a turn of some 50 degrees within its tolerance, and goes on almost straight.
BEND = "G64 P0.5\nG1 X5\nG5 X12 Y7 I0.3 J-0.05 P-1.5 Q-1.5\nG1 X20 Y9"


PROGRAMS = {
    "lines and arcs": arcs(1, turning=False),
    "more of them": arcs(2, turning=False),
    "lines and arcs with a turning table": arcs(3, turning=True),
    "mixed": lines_named(MIXED),
    "helix under tilt": lines_named(BODIES["a helix under tilt"][0]),
    "great circles": lines_named(
        "G43.5\nG1 X5 I0.1 J0.1 K0.98995\nX9 Y4 I0.48 J0.14 K0.8660254\nX12 I0.2 J0.44 K0.8754427\nX13"
    ),
    "turning spline": fanuc("G64\n" + WAVES + "G1 X100 Y9\n"),
    "a spline with a bend": lines_named(BEND),
    "bezier curves": lines_named("G1 X5 Y3\nG5 X10 Y0 I3 J3 P-3 Q3\nG5 X20 Y0 I1 J2 P-3 Q-3\nG1 X30 Y8"),
}


@pytest.mark.parametrize("mode", ["blend", "spline"])
@pytest.mark.parametrize("what", PROGRAMS)
def test_blends_are_smooth(what: str, mode: str) -> None:
    """Pose and first three derivatives by s go on across every end of a blend and across the corner itself."""
    contour = contour_of(PROGRAMS[what], mode)
    assert contour.corners is not None
    s = contour.corners.s[contour.corners.curved]
    reach = contour.corners.reach[contour.corners.curved]
    assert (reach > 0).sum() >= 1
    at, width = ends_of_blends(contour)
    mine = (np.abs(at[:, None] - s) <= reach * (1 + 1e-9)).any(axis=1)
    assert mine.sum() >= 3 * (reach > 0).sum()
    # arcs are no polynomials: over 0.05 mm of 1 mm one of degree 7 is exact to 1e-14, which the fit multiplies by 1e3
    found = jumps(contour, at[mine], np.minimum(width[mine], 0.05))
    assert found[..., :3].max() < 3e-9
    assert found[..., 3:].max() < 3e-9


@pytest.mark.parametrize("order", [0, 1])
def test_a_jump_that_is_left_in_would_be_seen(order: int) -> None:
    contour = contour_of(PROGRAMS["lines and arcs"])
    assert contour.corners is not None
    at, width = ends_of_blends(contour)
    contour.corners.jump[:, order] *= 0.99
    assert jumps(contour, at, np.minimum(width, 0.1)).max() > (1e-6, 1e-8)[order]


def find_nearest(contour: Contour, element: int, here: np.ndarray) -> list[float]:
    """Of poses (n, 5): larger share of both tolerances at the best pose of the segment of an element, on a dense
    sampling.
    """
    segment = int(contour.segment[element])
    u = np.linspace(0.0, 1.0, 20001)
    # half a step of the sampling may be added to both
    step = contour.path.length[segment] / 20000
    tip, axis = contour.tip_tolerance[segment] + step, contour.axis_tolerance[segment] + step / ROTARY_METRIC_MM
    scale = 1.0 / np.array([tip, tip, tip, axis, axis])
    there = np.ascontiguousarray((np.hstack(evaluate_pose(contour.path, np.full(len(u), segment), u)) * scale).T)
    squares = ((there - one[:, None]) ** 2 for one in here * scale)
    return [float(np.sqrt(np.maximum(away[:3].sum(axis=0), away[3:].sum(axis=0)).min())) for away in squares]


@pytest.mark.parametrize("mode", ["blend", "spline"])
@pytest.mark.parametrize("what", PROGRAMS)
def test_blends_stay_within_tolerance_of_their_segments(what: str, mode: str) -> None:
    """One pose must be near in both tip and axis; and each programmed pose is passed within root 2 of both
    tolerances.
    """
    contour = contour_of(PROGRAMS[what], mode)
    path = contour.path
    for element in np.flatnonzero(contour.blended).tolist():
        on = np.full(9, element)
        w = np.linspace(0.0, 1.0, 9)
        here = np.hstack(find_contour_pose(contour, on, w))
        assert max(find_nearest(contour, element, here)) <= 1.0
        segment = contour.segment[on]
        u = contour.low[on] + w * (contour.high - contour.low)[on]
        off = here - np.hstack(evaluate_pose(path, segment, u))
        share = np.hypot(
            np.linalg.norm(off[:, :3], axis=1) / contour.tip_tolerance[segment],
            np.linalg.norm(off[:, 3:], axis=1) / contour.axis_tolerance[segment],
        )
        assert share.max() <= np.sqrt(2.0)


@pytest.mark.parametrize("degrees", [0.0, 3.0, 30.0, 90.0, 150.0])
@pytest.mark.parametrize("radius", [0.5, 10.0])
def test_a_corner_alone_uses_its_tolerance(degrees: float, radius: float) -> None:
    """Of a long line and a long arc: 0.97 of it, or the corner is left behind by root 2 of that."""
    turn, tolerance = np.radians(degrees), 0.002
    center = radius * np.array([-np.sin(turn), np.cos(turn)])
    body = (
        f"G64 P{tolerance}\nG1 X30\nG3 X{30 + 2 * center[0]:.9f} Y{2 * center[1]:.9f} I{center[0]:.9f} J{center[1]:.9f}"
    )
    contour = contour_of(lines_named(body))
    element = np.repeat(np.arange(len(contour)), 401)
    tip = find_contour_pose(contour, element, np.tile(np.linspace(0, 1, 401), len(contour)))[0]
    own = contour.path.line[contour.segment[element]]
    line = np.abs(tip[own == 4][:, 1] - contour.path.start[0, 1])
    middle = contour.path.arcs.center[0]
    arc = np.abs(np.linalg.norm((tip - middle)[own == 5], axis=1) - radius)
    corner = contour.path.start[contour.path.line == 5][0, :3]
    behind = np.linalg.norm(tip[np.flatnonzero(own == 5)[0]] - corner)
    used = max(line.max(), arc.max(), behind / np.sqrt(2.0)) / tolerance
    # what is measured in finer places than the reach is sought in may shorten it a little
    assert 0.9 < used < 0.9705


def test_a_line_and_a_huge_arc_are_blended_like_two_lines() -> None:
    ends = {}
    for name, move in (("line", "G1 X60 Y30"), ("arc", "G3 X60 Y30 R100000")):
        contour = contour_of(lines_named(f"G64 P0.01\nG1 X30\n{move}"))
        assert contour.corners is not None
        ends[name] = contour.corners.reach[2], contour.corners.shape[2]
    assert ends["line"][1] == ends["arc"][1]
    assert ends["line"][0] == pytest.approx(ends["arc"][0], rel=0.01)


def test_the_shape_is_the_narrowest_at_the_feed_else_the_fastest() -> None:
    """A bend alone, J1 of length 1, jerk limit 1e5 mm/s3: reaches as of 0.01 mm, all of them possible, or
    little room.
    """
    limits = np.array([[1e5], [np.inf], [np.inf]])
    free = 0.01 / PEAK[None]

    def chosen(feed: float, room: float = np.inf) -> int:
        return int(curved_corners.choose_curved_shapes(np.minimum(free, room), np.array([feed]), limits, 1e-5)[0])

    assert chosen(1.0) == 0
    by_feed = [chosen(feed) for feed in np.linspace(2.0, 40.0, 80)]
    assert len(set(by_feed)) >= 3
    assert by_feed[-1] == SHAPES - 1
    # the speed of shape 0 is below 0.3 of the feed in either case: where all have little room, shape 0 bends least
    assert chosen(1e3) >= BRAKING
    assert chosen(1e3, 0.01) == 0
    # the jump of the second derivative alone: the shapes with the wide odd function pass it faster where they have room
    tangent = np.array([[np.inf], [1e5], [np.inf]])
    for reaches, wanted in (([1.0, *[2.2] * 6], BRAKING), ([1.0] * 7, 0)):
        assert curved_corners.choose_curved_shapes(np.array([reaches]), np.array([1e3]), tangent, 1e-5)[0] == wanted


def test_a_bend_of_a_spline_within_the_tolerance_is_replaced_by_a_curve() -> None:
    contour = contour_of(lines_named(BEND))
    assert contour.corners is not None
    assert (contour.corners.curve >= 0).any()
    # what lies between is one polynomial of degree 7 by s, across the corner
    for k in np.flatnonzero(contour.corners.curve >= 0):
        corner = contour.corners.curved[k]
        s, reach = contour.corners.s[corner], contour.corners.reach[corner]
        x = np.linspace(-1.0, 1.0, 31)
        poses = poses_at(contour, s + x * reach * (1 - 1e-12), "after")
        fitted = np.polynomial.chebyshev.chebfit(x, poses, 7)
        np.testing.assert_allclose(np.polynomial.chebyshev.chebval(x, fitted).T, poses, atol=1e-10)


def test_gentle_splines_are_displaced() -> None:
    contour = contour_of(lines_named("G64 P0.01\nG1 X5\nG5 X15 Y5 I3 J2 P-3 Q-3\nG1 X20 Y9"))
    assert contour.corners is not None
    assert (contour.corners.curve < 0).all()
    assert (contour.corners.reach[contour.corners.curved] > 0).sum() == 2
