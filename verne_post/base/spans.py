"""Polynomials that stand for a smooth function over a short span, with bounds between the samples.

A span is sampled at Chebyshev points. The Bernstein coefficients of the interpolating polynomial
enclose its values (and those of its derivatives), and the last Chebyshev coefficients tell how well
it stands for the function. Where an enclosure is too wide to decide, the span is halved.
"""

from math import comb
from typing import Final

import numpy as np
from numpy.polynomial import chebyshev

from verne_post.base.arrays import Array

#: Samples per span: degree 7. Over 20 degrees of rotation or 50 mm the machine's joints are
#: represented to 1e-11 mm, and three derivatives of a polynomial of degree 7 are still of degree 4.
NODES: Final = 8
#: Samples of a short span: the last coefficients are then as large as the motion over it, which is small enough.
FEW_NODES: Final = 3


def _place_samples(nodes: int) -> Array:
    """Chebyshev points in a span, from 0 to 1."""
    return np.asarray(0.5 * (chebyshev.chebpts1(nodes) + 1.0), dtype=np.float64)


#: Positions of the samples in a span, from 0 to 1 (both ends excluded).
SAMPLES: Final[Array] = _place_samples(NODES)
FEW_SAMPLES: Final[Array] = _place_samples(FEW_NODES)
#: The samples, then both ends.
WITH_ENDS: Final[Array] = np.append(SAMPLES, [0.0, 1.0])


def _convert_to_chebyshev(nodes: int) -> Array:
    """Values at the samples -> Chebyshev coefficients."""
    return np.asarray(np.linalg.inv(chebyshev.chebvander(chebyshev.chebpts1(nodes), nodes - 1)), dtype=np.float64)


def _make_bernstein_matrix(degree: int) -> Array:
    """Monomials on [0, 1] -> Bernstein coefficients of the same degree."""
    return np.array(
        [[comb(i, k) / comb(degree, k) if k <= i else 0.0 for k in range(degree + 1)] for i in range(degree + 1)]
    )


def _compute_enclosures(nodes: int) -> list[Array]:
    """Samples -> Bernstein coefficients of the derivatives by the span's own 0..1 parameter, up to the third."""
    monomials = np.linalg.inv(np.vander(_place_samples(nodes), nodes, increasing=True))
    matrices = []
    for order in range(min(nodes, 4)):
        degree = nodes - 1 - order
        derived = np.array([np.polynomial.polynomial.polyder(column, order) for column in monomials.T]).T
        matrices.append(_make_bernstein_matrix(degree) @ derived[: degree + 1])
    return matrices


#: By the number of samples.
_TAIL: Final = {nodes: _convert_to_chebyshev(nodes)[-2:] for nodes in (FEW_NODES, NODES)}
_ENCLOSE: Final = {nodes: _compute_enclosures(nodes) for nodes in (FEW_NODES, NODES)}


def apply_matrix(matrix: Array, values: Array) -> Array:
    """A matrix (r, m) applied to the samples of every span: values (m, n, k) -> (r, n, k)."""
    result = np.einsum("rj,jm->rm", matrix, values.reshape(len(values), -1))
    return np.asarray(result.reshape(len(matrix), *values.shape[1:]))


def bound_tail(values: Array) -> Array:
    """Size of the last two Chebyshev coefficients: values (NODES or FEW_NODES, n, k) -> (n, k)."""
    return np.asarray(np.abs(apply_matrix(_TAIL[len(values)], values)).sum(axis=0))


def enclose_derivative(values: Array, order: int = 0) -> tuple[Array, Array]:
    """Lower and upper bound (n, k) of a derivative by the span's own 0..1 parameter.

    Parameters
    ----------
    values : ndarray, shape (NODES or FEW_NODES, n, k)
        Samples.
    order : int
        0 to 3.
    """
    coefficients = apply_matrix(_ENCLOSE[len(values)][order], values)
    return coefficients.min(axis=0), coefficients.max(axis=0)
