"""Polynomials over short spans: enclosures hold between the samples, derivatives are exact for polynomials."""

import numpy as np
import pytest

from verne_post.base import spans

U = np.linspace(0.0, 1.0, 2001)
#: Degree 7 through powers of u: the rounding of values of size 1 grows by 1e4, by each derivative some ten times more.
ROUNDING = (1e-11, 1e-10, 1e-9, 1e-8)


def random_polynomials(seed, n=50):
    """Polynomials of degree 7 with values of size 1: coefficients in powers of u, (8, n)."""
    return np.random.default_rng(seed).normal(size=(spans.NODES, n)) / np.arange(1, spans.NODES + 1)[:, None]


def sampled(coefficients, at=None):
    """Values (len(at), n, 1) at the samples."""
    at = spans.SAMPLES if at is None else at
    return np.polynomial.polynomial.polyval(at, coefficients).T[:, :, None]


def test_samples_lie_inside_the_span_and_are_symmetric():
    assert spans.SAMPLES.shape == (spans.NODES,)
    assert ((spans.SAMPLES > 0) & (spans.SAMPLES < 1)).all()
    assert np.sort(1 - spans.SAMPLES) == pytest.approx(np.sort(spans.SAMPLES), abs=1e-15)


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_the_enclosure_holds_between_the_samples_and_at_the_ends(order):
    coefficients = random_polynomials(1)
    derived = np.polynomial.polynomial.polyder(coefficients, order) if order else coefficients
    dense = np.polynomial.polynomial.polyval(U, derived)
    lower, upper = spans.enclose_derivative(sampled(coefficients), order)
    slack = ROUNDING[order]
    assert (lower[:, 0] <= dense.min(axis=1) + slack).all()
    assert (upper[:, 0] >= dense.max(axis=1) - slack).all()
    # Bernstein coefficients of the ends are the values there: an extreme at an end is met exactly
    assert (lower[:, 0] <= np.minimum(dense[:, 0], dense[:, -1]) + slack).all()
    assert (upper[:, 0] >= np.maximum(dense[:, 0], dense[:, -1]) - slack).all()


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_the_enclosure_closes_in_when_a_span_is_halved(order):
    """Quadratic convergence: an eighth of the span has at most a tenth of the excess of a half."""
    coefficients = np.array([[0.3, -1.0, 2.0, 0.5, -0.7, 0.1, 0.2, -0.3]]).T
    derived = np.polynomial.polynomial.polyder(coefficients, order) if order else coefficients

    def excess(width):
        at = 0.2 + width * spans.SAMPLES
        _lower, upper = spans.enclose_derivative(sampled(coefficients, at), order)
        dense = np.polynomial.polynomial.polyval(0.2 + width * U, derived)
        return float(upper[0, 0] - dense.max() * width**order) / width**order

    assert excess(0.125) < 0.1 * excess(0.5) + ROUNDING[order] / 0.125**order


@pytest.mark.parametrize("slope", [-2.0, 0.0, 3.0])
def test_a_straight_line_is_enclosed_exactly(slope):
    values = (1.0 + slope * spans.SAMPLES)[:, None, None]
    lower, upper = spans.enclose_derivative(values)
    assert lower[0, 0] == pytest.approx(min(1.0, 1.0 + slope), abs=ROUNDING[0])
    assert upper[0, 0] == pytest.approx(max(1.0, 1.0 + slope), abs=ROUNDING[0])
    lower, upper = spans.enclose_derivative(values, 1)
    assert (lower[0, 0], upper[0, 0]) == pytest.approx((slope, slope), abs=ROUNDING[1])


def test_the_tail_is_nothing_for_low_degrees_and_grows_with_what_is_missed():
    low = np.random.default_rng(2).normal(size=(6, 20))
    assert spans.bound_tail(sampled(low)).max() < ROUNDING[0]
    short, long = np.cos(0.5 * spans.SAMPLES), np.cos(8.0 * spans.SAMPLES)
    tails = spans.bound_tail(np.stack([short, long], axis=1)[:, :, None])[:, 0]
    assert tails[0] < 1e-7 < 1e-3 < tails[1]


def test_columns_are_independent():
    first, second = sampled(random_polynomials(3)), sampled(random_polynomials(4))
    both = np.concatenate([first, second], axis=2)
    for order in range(4):
        lower, upper = spans.enclose_derivative(both, order)
        for column, values in enumerate((first, second)):
            alone = spans.enclose_derivative(values, order)
            np.testing.assert_allclose(lower[:, column], alone[0][:, 0], rtol=0, atol=ROUNDING[order])
            np.testing.assert_allclose(upper[:, column], alone[1][:, 0], rtol=0, atol=ROUNDING[order])


def test_few_samples_enclose_what_their_last_coefficients_say():
    """Polynomials whose higher coefficients fall: bounds from three samples, widened by the tail, hold; those alone do
    not.
    """
    falling = np.random.default_rng(5).normal(size=(spans.NODES, 400)) * 0.2 ** np.arange(spans.NODES)[:, None]
    dense = np.polynomial.chebyshev.chebval(2 * U - 1, falling)
    few = np.polynomial.chebyshev.chebval(2 * spans.FEW_SAMPLES - 1, falling).T[:, :, None]
    (lower, upper), tail = spans.enclose_derivative(few), spans.bound_tail(few)
    assert few.shape == (spans.FEW_NODES, 400, 1)
    assert (lower - tail <= dense.min(axis=1)[:, None]).all()
    assert (upper + tail >= dense.max(axis=1)[:, None]).all()
    assert (lower[:, 0] > dense.min(axis=1) + 1e-9).any()
