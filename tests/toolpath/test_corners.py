"""Rounded corners of polylines: smooth to the third derivative, within tolerance, and never over a stop."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from verne_post.base.units import ROTARY_METRIC_MM
from verne_post.toolpath import corners, deviations
from verne_post.toolpath.contour_pose import find_contour_pose
from verne_post.toolpath.corner_shapes import (
    EVEN_PEAK,
    EVEN_THIRD,
    KNEE,
    ODD_PEAK,
    ODD_THIRD,
    OUTSIDE,
    PEAK,
    THIRD,
    jump_slopes,
    jump_values,
    shape_slope,
    shape_value,
)

from .polylines import contour_of, ends_of_blends, flat, jumps, program_of, shares_of_tolerance

# --- the shape of a corner blend ------------------------------------------------------------------------------


def test_shape_0_is_the_kernel_integrated_numerically() -> None:
    """G(x) = integral of (x - v)+ k(v) dv - x+ with k = 15/16 (1 - v^2)^2, by Gauss points: exact for polynomials."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    x = np.linspace(-1.3, 1.3, 53)
    reach = np.clip(x, -1.0, 1.0)  # (x - v)+ is zero beyond v = x
    v = -1.0 + 0.5 * (reach + 1.0)[:, None] * (nodes + 1.0)
    kernel = 15.0 / 16.0 * (1.0 - v**2) ** 2
    smoothed = 0.5 * (reach + 1.0) * ((x[:, None] - v) * kernel @ weights)
    slope = 0.5 * (reach + 1.0) * (kernel @ weights)
    shape = np.zeros(len(x), dtype=int)
    np.testing.assert_allclose(shape_value(shape, x), smoothed - np.maximum(x, 0.0), atol=1e-14)
    np.testing.assert_allclose(shape_slope(shape, x), slope - np.heaviside(x, 0.5), atol=1e-14)


@pytest.mark.parametrize("shape", range(len(PEAK)))
def test_shapes_take_out_the_kink_and_are_smooth(shape: int) -> None:
    """By differences of polynomials fitted on both sides of 0, the knee and 1; the table is not looked at."""
    nodes = 0.1 * (1.0 - np.cos(np.pi * np.arange(8) / 7)) / 2
    fit = np.linalg.inv(np.vander(nodes, increasing=True))[:4]
    factorials = np.array([1.0, 1.0, 2.0, 6.0])

    def derivatives(at: float, side: float) -> np.ndarray:
        return (fit @ shape_value(np.full(8, shape), at + side * nodes)) * side ** np.arange(4) * factorials

    kink = derivatives(0.0, 1.0) - derivatives(0.0, -1.0)
    np.testing.assert_allclose(kink, [0.0, -1.0, 0.0, 0.0], atol=1e-6)
    for at in (KNEE, 1.0):
        np.testing.assert_allclose(derivatives(at, 1.0) - derivatives(at, -1.0), 0.0, atol=1e-6)
    x = np.linspace(0.01, 0.99, 99)
    value, slope = (function(np.full(99, shape), x) for function in (shape_value, shape_slope))
    np.testing.assert_array_equal(shape_value(np.full(99, shape), -x), value)
    np.testing.assert_array_equal(shape_slope(np.full(99, shape), -x), -slope)
    step = (shape_value(np.full(99, shape), x + 1e-5) - shape_value(np.full(99, shape), x - 1e-5)) / 2e-5
    np.testing.assert_allclose(slope, step, atol=1e-7)
    assert np.abs(value).max() <= PEAK[shape]
    assert shape_value(np.array([shape]), np.zeros(1))[0] == pytest.approx(PEAK[shape], rel=1e-3)
    lowest = value.min()
    assert shape_value(np.array([shape]), OUTSIDE[[shape]])[0] <= max(lowest, 0.0) or shape == 0
    assert (lowest < 0) == (shape > 0)
    third = np.diff(value, 3) / (x[1] - x[0]) ** 3
    assert 0.8 * THIRD[shape] < max(np.abs(third).max(), abs(derivatives(0.0, 1.0)[3])) <= THIRD[shape] * 1.01


@pytest.mark.parametrize("shape", [0, 1])
def test_odd_and_even_functions_take_out_jumps_of_the_second_and_third_derivative(shape: int) -> None:
    """By polynomials fitted on both sides, as above; peaks and third derivatives by differences on a grid."""
    nodes = 0.5 * (1.0 - np.cos(np.pi * np.arange(8) / 7))
    fit = np.linalg.inv(np.vander(nodes, increasing=True))[:4] * np.array([1.0, 1.0, 2.0, 6.0])[:, None]
    shapes, x = np.full(8, shape), np.linspace(0.0, 1.0, 2001)
    grid = jump_values(np.full(len(x), shape), x)
    for which, (order, parity, peak, third) in enumerate(
        ((2, -1, ODD_PEAK[shape], ODD_THIRD[shape]), (3, 1, EVEN_PEAK, EVEN_THIRD))
    ):
        right, left = (fit @ jump_values(shapes, side * nodes)[which] * side ** np.arange(4) for side in (1.0, -1.0))
        wanted = np.zeros(4)
        wanted[order] = -1.0
        np.testing.assert_allclose(right - left, wanted, atol=1e-10)
        end = fit @ jump_values(shapes, 1.0 - nodes)[which] * (-1.0) ** np.arange(4)
        np.testing.assert_allclose(end, 0.0, atol=1e-10)
        assert np.abs(jump_values(shapes, np.full(8, 1.3))[which]).max() < 1e-15
        np.testing.assert_array_equal(jump_values(np.full(len(x), shape), -x)[which], parity * grid[which])
        assert np.abs(grid[which]).max() == pytest.approx(peak, rel=1e-5)
        assert np.abs(np.diff(grid[which], 3)).max() * 2000.0**3 == pytest.approx(third, rel=1e-2)
        slope = (
            jump_values(np.full(99, shape), x[1:-1:20][:99] + 1e-5)[which]
            - jump_values(np.full(99, shape), x[1:-1:20][:99] - 1e-5)[which]
        ) / 2e-5
        np.testing.assert_allclose(jump_slopes(np.full(99, shape), x[1:-1:20][:99])[which], slope, atol=1e-8)


def test_odd_and_even_functions_are_the_best_of_their_kind() -> None:
    """No other polynomial of degree 7 in the neighbourhood has less of what each was chosen for."""
    x = np.linspace(0.0, 1.0, 801)
    rows = [np.polynomial.polynomial.polyder(np.eye(8), order) for order in range(4)]
    conditions = np.vstack(
        [[np.polynomial.polynomial.polyval(at, row) for row in rows] for at in (0.0, 1.0)]
    )  # (8, 8): value and derivatives of the powers at both ends

    def measure(at_0: list[float]) -> tuple[float, float]:
        """Largest value and largest third derivative."""
        found = np.linalg.solve(conditions, [*at_0, 0.0, 0.0, 0.0, 0.0])
        third = np.polynomial.polynomial.polyder(found, 3)
        return tuple(np.abs(np.polynomial.polynomial.polyval(x, c)).max() for c in (found, third))  # type: ignore[return-value]

    def fitted(which: int, shape: int) -> np.ndarray:
        nodes = 0.5 * (1.0 - np.cos(np.pi * np.arange(8) / 7))
        found = np.linalg.solve(np.vander(nodes, increasing=True), jump_values(np.full(8, shape), nodes)[which])
        return found[:4] * [1.0, 1.0, 2.0, 6.0]

    goals = (
        (0, 0, (1, 3), lambda peak, third: third),
        (0, 1, (1, 3), lambda peak, third: third * np.sqrt(peak)),
        (1, 0, (0, 2), lambda peak, third: peak + 10.0 * max(third - 0.5 - 1e-6, 0.0)),
    )
    for which, shape, free, goal in goals:
        start = fitted(which, shape)
        best = goal(*measure(start.tolist()))
        for first in (-0.03, 0.0, 0.03):
            for second in (-0.03, 0.0, 0.03):
                other = start.copy()
                other[list(free)] *= 1.0 + np.array([first, second])
                assert goal(*measure(other.tolist())) >= best * (1 - 1e-5)


def test_the_narrowest_shape_that_keeps_the_feed_is_taken_else_the_widest_with_room() -> None:
    """One corner of 90 degrees (bend of root 2) under a tolerance of 0.01 mm, jerk of 1e5 mm/s3 along the bend."""
    share = np.array([0.0, 100.0, 0.0])  # the normal part of the bend, 1, over the tolerance

    def chosen(feed: float, room: float) -> int:
        around = np.full(3, feed), np.full(3, room)
        shape = corners.choose_shapes(share, around[1], around[0], lambda corner: np.full(len(corner), 1e5), 1e-4)
        assert shape[0] == shape[2] == 0
        return int(shape[1])

    # the third derivative of G times v^3 / reach^2 is the jerk along the bend: by hand for shape 0, 1.4434 (4.5 mm/s)^3
    # / (0.0621 mm)^2 = 3.4e4 mm/s3
    assert chosen(4.5, 100.0) == 0
    assert chosen(1e3, 100.0) == len(PEAK) - 1
    assert chosen(1e3, 0.0) == 0
    rooms = [chosen(1e3, 0.97 / (100.0 * peak) * 1.001) for peak in PEAK]
    assert rooms == list(range(len(PEAK)))
    by_feed = [chosen(feed, 100.0) for feed in np.linspace(1, 30, 100)]
    assert by_feed == sorted(by_feed)
    assert len(set(by_feed)) >= 4


def test_a_pose_beyond_the_end_of_its_segment_is_measured_from_the_end() -> None:
    """The nearest pose of a line may lie beyond the corner; where the table turns, it is the one with the same s."""
    off, one = np.array([[0.01, 0.004, 0, 2e-4, 0]]), np.array([1.0])

    def used(before: float, after: float, turning: float = 0.0) -> float:
        slope = np.array([[1.0, 0, 0, turning, 0]])
        return float(deviations.find_share_used(off, slope, (before * one, after * one), 0.02 * one, 0.5e-3 * one)[0])

    left_behind = np.hypot(np.hypot(0.5, 0.2), 0.4) / np.sqrt(2.0)
    assert used(-1.0, 1.0) == pytest.approx(
        left_behind
    )  # only 0.4 of the axis tolerance, 0.2 of that of the tip, are used
    assert used(-1.0, 0.0) == pytest.approx(np.hypot(0.5, 0.2))
    assert used(-1.0, 1.0, turning=0.02) == pytest.approx(np.hypot(0.5, 0.2))


# --- reaches -----------------------------------------------------------------------------------------

LENGTHS = st.floats(1e-6, 1e3)
WANTED = st.one_of(st.just(0.0), st.just(np.inf), st.floats(1e-7, 1e4))


@given(st.lists(st.tuples(LENGTHS, WANTED), min_size=1, max_size=12), WANTED)
@settings(max_examples=150, deadline=None)
def test_shared_reaches_do_not_overlap_and_nobody_gets_less_than_half(
    rows: list[tuple[float, float]], last: float
) -> None:
    length = np.array([row[0] for row in rows])
    wanted = np.array([0.0, *(row[1] for row in rows[1:]), 0.0])
    reach = corners.share_segments(wanted, length)
    assert (reach >= 0).all()
    assert (reach <= wanted).all()
    assert (reach[:-1] + reach[1:] <= length * (1 + 1e-15)).all()
    fair = np.minimum(wanted[1:-1], 0.5 * np.minimum(length[1:], length[:-1]))
    assert (reach[1:-1] >= fair).all()
    # a corner between corners that want nothing has the whole of the shorter segment
    alone = (wanted[:-2] == 0) & (wanted[2:] == 0)
    np.testing.assert_array_equal(
        reach[1:-1][alone], np.minimum(wanted[1:-1], np.minimum(length[1:], length[:-1]))[alone]
    )


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=60, deadline=None)
def test_overlapping_reaches_stop_at_walls(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 12))
    s = np.append(0.0, np.cumsum(10.0 ** rng.uniform(-5, 2, n)))
    wall = rng.random(n + 1) < 0.3
    wall[[0, -1]] = True
    tight = wall & (rng.random(n + 1) < 0.5)
    wanted = np.where(rng.random(n + 1) < 0.2, np.inf, 10.0 ** rng.uniform(-5, 3, n + 1))
    reach = corners.limit_overlap(wanted, s, wall, tight)
    assert (reach[wall] == 0).all()
    assert (reach[~wall] > 0).all()
    assert (reach <= wanted).all()
    for k in np.flatnonzero(~wall):
        for j in np.flatnonzero(wall):
            assert reach[k] <= abs(s[j] - s[k]) * (1 + 1e-12) + 1e-12
            if tight[j]:  # half of the segment on this side of the wall stays free
                segment = s[j + 1] - s[j] if j < k else s[j] - s[j - 1]
                assert reach[k] <= abs(s[j] - s[k]) - 0.5 * segment + 1e-12 * s[-1]
        assert reach[k] <= s[min(k + corners.SEGMENTS, n)] - s[k] + 1e-12
        assert reach[k] <= s[k] - s[max(k - corners.SEGMENTS, 0)] + 1e-12
    clear = corners.measure_gaps(reach, s)
    for k in range(n + 1):
        others = np.delete(np.arange(n + 1), k)
        assert clear[k] == pytest.approx((np.abs(s[others] - s[k]) - reach[others]).min(), abs=1e-9 * s[-1])


# --- whole contours ------------------------------------------------------------------------------------


def random_walk(rng: np.random.Generator) -> np.ndarray:
    return flat(rng.uniform(-20, 20, 2) + np.cumsum(rng.normal(size=(30, 2)), axis=0))


def uneven(rng: np.random.Generator) -> np.ndarray:
    """1 um next to 100 mm."""
    length = np.where(np.arange(12) % 2, 10.0 ** rng.uniform(-3, -1, 12), rng.uniform(50, 100, 12))
    heading = np.cumsum(rng.uniform(-2, 2, 12))
    steps = length[:, None] * np.column_stack([np.cos(heading), np.sin(heading)])
    return flat(np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)]))


def five_axis(rng: np.random.Generator) -> np.ndarray:
    tip = np.cumsum(rng.normal(size=(25, 3)) * 0.5, axis=0) + [0, 0, 40]
    return np.column_stack([tip, np.cumsum(rng.normal(size=(25, 2)) * [0.3, 2.0], axis=0)])


def rotary_only(rng: np.random.Generator) -> np.ndarray:
    return np.column_stack([np.tile([3.0, 4.0, 40.0], (20, 1)), np.cumsum(rng.normal(size=(20, 2)), axis=0)])


def turn_and_go(rng: np.random.Generator) -> np.ndarray:
    """Tip moves and rotations by turns: corners between the two."""
    steps = np.zeros((20, 5))
    steps[::2, :3] = rng.normal(size=(10, 3))
    steps[1::2, 3:] = rng.normal(size=(10, 2))
    return np.cumsum(steps, axis=0) + [0, 0, 40, 0, 0]


def noisy_cam(rng: np.random.Generator) -> np.ndarray:
    """Many points a step apart, off the curve by about the tolerance: corner blends overlap."""
    t = np.linspace(0, 2, 60)
    return flat(np.column_stack([20 * np.cos(t), 20 * np.sin(t)]) + rng.normal(size=(60, 2)) * 0.01)


def spikes(rng: np.random.Generator) -> np.ndarray:
    points = np.column_stack([np.arange(40) * 0.3, np.zeros(40)])
    points[rng.integers(1, 39, 6), 1] = rng.uniform(-1, 1, 6)
    return flat(points)


def zigzag(rng: np.random.Generator) -> np.ndarray:
    """Corners of 0.1 to 179 degrees, and reversals."""
    turn = np.radians([0.1, 1.0, 10.0, 45.0, 90.0, 120.0, 150.0, 154.0, 155.0, 170.0, 179.0, 180.0])
    heading = np.cumsum(turn * np.where(np.arange(12) % 2, 1, -1))
    steps = rng.uniform(0.5, 3, (12, 1)) * np.column_stack([np.cos(heading), np.sin(heading)])
    return flat(np.vstack([[0.0, 0.0], np.cumsum(steps, axis=0)]))


def duplicates(rng: np.random.Generator) -> np.ndarray:
    """Every direction several times, so that segments join, and points given twice."""
    heading = np.repeat(np.cumsum(rng.uniform(-2, 2, 8)), 3)
    points = np.vstack([[0.0, 0.0], np.cumsum(np.column_stack([np.cos(heading), np.sin(heading)]), axis=0)])
    return flat(np.repeat(points, 2, axis=0))


SHAPES = [random_walk, uneven, five_axis, rotary_only, turn_and_go, noisy_cam, spikes, zigzag, duplicates]


@pytest.mark.parametrize("mode", ["blend", "spline"])
@pytest.mark.parametrize("shape", SHAPES)
def test_contours_are_smooth_and_within_tolerance(shape: Callable[..., np.ndarray], mode: str) -> None:
    for seed in range(2):
        rng = np.random.default_rng([seed, len(shape.__name__)])
        tolerance = 10.0 ** rng.uniform(-3, -1)
        contour = contour_of(program_of(shape(rng), tolerance), mode)
        at, width = ends_of_blends(contour)
        assert len(at) > 5
        # positions are exact to some 1e-13 mm of a path of some 500 mm, and a degree 7 fit multiplies that by 1e3
        assert jumps(contour, at, width)[..., :3].max() < 3e-9
        assert jumps(contour, at, width)[..., 3:].max() < 3e-9 / ROTARY_METRIC_MM
        # the rest up to 1 is left to the rounding of the written numbers
        assert shares_of_tolerance(contour).max() < 0.98
        assert contour.tip_tolerance.max() <= tolerance + 1e-9


@pytest.mark.parametrize("mode", ["blend", "spline"])
def test_a_kink_would_be_seen(mode: str) -> None:
    """The same measure on a contour whose bends are changed afterwards: the sum no longer fits them."""
    contour = contour_of(program_of(random_walk(np.random.default_rng(1)), 0.01), mode)
    assert contour.corners is not None
    at, width = ends_of_blends(contour)
    contour.corners.bend[5:20] *= 0.999
    assert jumps(contour, at, width).max() > 1e-6


@pytest.mark.parametrize("mode", ["blend", "spline"])
@pytest.mark.parametrize("degrees", [0.1, 10.0, 90.0, 150.0])
def test_a_corner_alone_uses_its_tolerance(mode: str, degrees: float) -> None:
    """Long segments: the contour uses 0.97 of it, or the vertex is left behind by root 2 of that."""
    turn = np.radians(degrees)
    points = flat(np.array([[-40.0, 0.0], [0.0, 0.0], [40 * np.cos(turn), 40 * np.sin(turn)]]))
    contour = contour_of(program_of(points, 0.002), mode)
    assert contour.corners is not None
    vertex = np.linalg.norm(find_contour_pose(contour, np.flatnonzero(contour.segment == 1)[:1], np.zeros(1))[0][0, :2])
    used = shares_of_tolerance(contour, 401).max()
    assert used <= 0.9701
    assert vertex <= np.sqrt(2.0) * 0.97 * 0.002 * 1.0001
    assert max(used, vertex / (np.sqrt(2.0) * 0.002)) == pytest.approx(0.97, rel=1e-3)


@pytest.mark.parametrize("mode", ["blend", "spline"])
def test_every_blend_ends_at_the_end_of_an_element(mode: str) -> None:
    """A grid made of elements must see the narrowest corner blend on the longest segment."""
    steps = [uneven, noisy_cam, five_axis]
    programs = [program_of(shape(np.random.default_rng(4)), tolerance) for shape in steps for tolerance in (1e-3, 0.02)]
    # 5 micrometres of blend beside 30 mm: less than a thousandth of the move
    programs.append(program_of(flat(np.array([[0.0, 0.0], [30.0, 0.0], [30.0, 0.01], [0.0, 0.02]])), 0.01))
    for program in programs:
        contour = contour_of(program, mode)
        assert contour.corners is not None
        ends = np.append(0.0, np.cumsum(contour.length))
        blended = contour.corners.reach > 0
        assert blended.any()
        for s, reach in zip(contour.corners.s[blended], contour.corners.reach[blended], strict=True):
            for at in (s - reach, s + reach):
                assert np.abs(ends - at).min() <= 2 * corners.SEGMENTS * 1e-3 * reach + 1e-9


def test_reversals_are_stops_and_what_turns_less_is_not() -> None:
    heading = np.cumsum(np.radians([0.0, 150.0, 170.0, 175.0, 90.0]))
    points = np.vstack([[0.0, 0.0], np.cumsum(np.column_stack([np.cos(heading), np.sin(heading)]), axis=0)])
    contour = contour_of(program_of(flat(points), 0.01))
    by_segment = np.zeros(5, dtype=int)
    by_segment[contour.segment] = contour.section
    np.testing.assert_array_equal(by_segment, [0, 0, 0, 1, 1])


@pytest.mark.parametrize("mode", ["blend", "spline"])
def test_a_change_of_feed_on_a_straight_line_flows(mode: str) -> None:
    points = flat(np.column_stack([np.arange(6.0), np.zeros(6)]))
    contour = contour_of(program_of(points, 0.01, np.array([0, 1000, 2000, 2000, 500, 9000.0])), mode)
    assert contour.n_sections == 1
    assert shares_of_tolerance(contour).max() < 1e-3


@pytest.mark.parametrize("mode", ["blend", "spline"])
@pytest.mark.parametrize("tolerance", [1e-6, 3.0])
def test_tolerances_far_from_the_size_of_the_segments(mode: str, tolerance: float) -> None:
    """P of a nanometre, and P of ten segments."""
    rng = np.random.default_rng(2)
    contour = contour_of(program_of(flat(np.cumsum(rng.normal(size=(40, 2)) * 0.3, axis=0)), tolerance), mode)
    assert shares_of_tolerance(contour).max() < (0.98 if tolerance > 1e-3 else 1.0)
    at, width = ends_of_blends(contour)
    assert jumps(contour, at, width).max() < 3e-9


@pytest.mark.parametrize("mode", ["blend", "spline"])
def test_segments_of_a_few_nanometres_between_long_ones(mode: str) -> None:
    points = flat(np.array([[0, 0], [30, 0], [30, 1e-5], [60, 1e-5], [60, 20], [60 - 5e-6, 20], [30, 20], [30, 0.0]]))
    contour = contour_of(program_of(points, 0.05), mode)
    assert len(contour.path) == 7
    at, width = ends_of_blends(contour)
    assert jumps(contour, at, width).max() < 3e-9
    assert shares_of_tolerance(contour).max() < 0.98
