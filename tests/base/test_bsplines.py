"""Rational curves against scipy's B-splines, and against curves whose points and lengths are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from verne_post.base.bsplines import (
    derive_by_length,
    differentiate_bezier,
    evaluate_bezier,
    evaluate_piece_ends,
    find_bezier_controls,
    find_curve_parameter,
    find_even_parts,
)


def drawn(seed: int, degree: int, spread: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One span of a random rational B-spline far from the origin: points, weights, knots."""
    rng = np.random.default_rng(seed)
    points = 400.0 + np.cumsum(rng.normal(size=(1, degree + 1, 5)), axis=1)
    weights = np.exp(spread * rng.normal(size=(1, degree + 1)))
    return points, weights, np.sort(rng.uniform(size=(1, 2 * degree)))


def by_scipy(points: np.ndarray, weights: np.ndarray, knots: np.ndarray, t: np.ndarray, order: int) -> list[np.ndarray]:
    """Points (n, 5) and their derivatives by the parameter of the span from 0 to 1: scipy in homogeneous
    coordinates.
    """
    degree = points.shape[1] - 1
    low, high = knots[0, degree - 1], knots[0, degree]
    origin = points[0, 0]
    plane = np.column_stack([(points[0] - origin) * weights[0][:, None], weights[0]])
    # the outermost knots of the basis have no influence on the span
    spline = BSpline(np.concatenate([[knots[0, 0] - 1], knots[0], [knots[0, -1] + 1]]), plane, degree)
    parts = [spline(low + t * (high - low), nu) * (high - low) ** nu for nu in range(order + 1)]
    a, w = [part[:, :-1] for part in parts], [part[:, -1:] for part in parts]
    c0 = a[0] / w[0]
    result = [c0 + origin]
    if order >= 1:
        result.append((a[1] - w[1] * c0) / w[0])
    if order >= 2:
        result.append((a[2] - 2 * w[1] * result[1] - w[2] * c0) / w[0])
    if order >= 3:
        result.append((a[3] - 3 * w[1] * result[2] - 3 * w[2] * result[1] - w[3] * c0) / w[0])
    return result


@given(seed=st.integers(0, 10_000), degree=st.integers(1, 9))
def test_points_and_derivatives_are_those_of_scipy(seed: int, degree: int) -> None:
    points, weights, knots = drawn(seed, degree)
    t = np.linspace(0.0, 1.0, 7)
    expected = by_scipy(points, weights, knots, t, 3)
    controls = np.repeat(find_bezier_controls(points - points[:, :1], weights, knots), len(t), axis=0)
    for order, (here, wanted) in enumerate(zip(differentiate_bezier(controls, t, 3), expected, strict=True)):
        wanted = wanted - (points[:, 0] if order == 0 else 0.0)
        np.testing.assert_allclose(here, wanted, atol=1e-11 * max(1.0, np.abs(wanted).max()))
    np.testing.assert_allclose(evaluate_piece_ends(points, weights, knots)[0], expected[0][-1], atol=1e-11)


def test_clamped_ends_are_the_control_point_to_the_last_bit() -> None:
    points, weights, _knots = drawn(3, 3)
    assert (evaluate_piece_ends(points, weights, np.array([[0.1, 0.2, 0.3, 0.7, 0.7, 0.7]])) == points[:, -1]).all()


def test_parabola_has_its_length_in_closed_form() -> None:
    """y = x^2 from 0 to 2: (2 sqrt(17) + asinh(4) / 2) / 2 ... with the antiderivative of sqrt(1 + 4 x^2)."""
    controls = np.array([[[0.0, 0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0], [2.0, 4.0, 0.0, 1.0]]])
    exact = 0.5 * 2.0 * np.sqrt(17.0) + np.arcsinh(4.0) / 4.0
    assert find_even_parts(controls, 3).length[0] == pytest.approx(exact, rel=1e-13)


def test_quarter_circle_is_evenly_divided() -> None:
    half = np.sqrt(0.5)
    controls = np.array([[[3.0, 0.0, 0.0, 1.0], [3.0 * half, 3.0 * half, 0.0, half], [0.0, 3.0, 0.0, 1.0]]])
    parts = find_even_parts(controls, 3)
    assert parts.length[0] == pytest.approx(1.5 * np.pi, rel=1e-13)
    u = np.linspace(0.0, 1.0, 101)
    part = np.clip(np.searchsorted(parts.high, u), 0, len(parts.high) - 1)
    t = find_curve_parameter(parts.low[part], parts.high[part], parts.polynomial[part], u)
    many = np.repeat(controls, len(u), axis=0)
    angle = 0.5 * np.pi * u
    np.testing.assert_allclose(evaluate_bezier(many, t)[:, 0], 3.0 * np.cos(angle), atol=1e-12)
    first, second, third = derive_by_length(differentiate_bezier(many, t, 3), 3)
    np.testing.assert_allclose(first[:, 1], np.cos(angle), atol=1e-12)
    np.testing.assert_allclose(second[:, 0], -np.cos(angle) / 3.0, atol=1e-12)
    np.testing.assert_allclose(third[:, 1], -np.cos(angle) / 9.0, atol=1e-12)


@pytest.mark.parametrize(
    "points",
    [
        [[0, 0], [10, 10], [0, 10], [10, 0]],  # a cusp
        [[0, 0], [0, 0], [5, 5], [10, 0]],  # no direction at the start
        [[0, 0], [5, 5], [10, 0], [10, 0]],  # ... and at the end
        [[0, 0], [20, 0], [-10, 0], [10, 0]],  # there and back
        [[1, 1], [1, 1], [1, 1], [1, 1]],
    ],
)
def test_curves_that_stop_are_not_regular(points: list[list[float]]) -> None:
    controls = np.zeros((1, 4, 4))
    controls[0, :, :2], controls[0, :, 3] = points, 1.0
    assert not find_even_parts(controls, 3).regular[0]


def test_a_narrow_bend_is_regular() -> None:
    """Close to the cusp above, with a bend of some micrometres."""
    controls = np.zeros((1, 4, 4))
    controls[0, :, :2], controls[0, :, 3] = [[0, 0], [10, 10.1], [0, 10], [10, 0]], 1.0
    assert find_even_parts(controls, 3).regular[0]
