"""Shapes of corner blends, from narrow ones that only cut inside to wide ones that swing out before the corner.

A corner blend displaces the path by ``bend reach G(x)`` (:mod:`verne_post.toolpath.corners`). Every G here is even,
takes the kink out of the polyline, and is three times continuously differentiable; it is 0 with all of these
derivatives at x = 1. Shape 0 averages the polyline; it lies on the inside throughout. The others pass the corner
faster: they first swing to the outside, within the same tolerance, so that the path bends less at the corner. That
takes length: at the same tolerance their reach is larger. Between 0 and 1 each is two polynomials of degree 7 that meet
at ``KNEE``; six numbers define it.

The numbers were found by ``tests/benchmarks/corner_shapes.py``: for a given reach, shape and motion profile were sought
together that pass corners in the least time under jerk limits. The first three were found on zigzags and polygons of 10
degrees whose blends overlap, the others on single corners of 30 to 120 degrees.
"""

from typing import Final

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from verne_post.base.arrays import Array, Ints

#: Where both polynomials of a half meet.
KNEE: Final = 0.25
#: One row a shape: G and its second derivative at 0, G and its first three derivatives at the knee. The first is
#: 15/16 integral of max(x - v, 0) (1 - v^2)^2 dv - max(x, 0), a polynomial of degree 6.
_SHAPES: Final = np.array(
    [
        [5 / 32, 15 / 16, 0.0, 0.0, 0.0, 0.0],
        [0.0683434, 1.89286, -0.00420963, -0.118399, 1.04104, -4.05719],
        [0.0464128, 2.25152, -0.0178668, -0.0671768, 1.06528, -5.3547],
        [0.0354599, 2.60098, -0.0207119, -0.018275, 1.057, -6.99919],
        [0.0277778, 3.64822, -0.0144809, 0.012419, 0.51108, -6.16219],
        [0.0208333, 3.76892, -0.0187811, 0.0273988, 0.505225, -6.42338],
        [0.016129, 4.74716, -0.0139847, 0.0432032, 0.221108, -5.10328],
    ]
)


def _evaluate_average(x: float) -> list[float]:
    """G of shape 0 and its first three derivatives at x."""
    z = x * x
    return [
        15 / 16 * (((z / 30 - 1 / 6) * z + 0.5) * z + 1 / 6) - 0.5 * x,
        15 / 16 * ((z / 5 - 2 / 3) * z + 1.0) * x - 0.5,
        15 / 16 * (1.0 - z) ** 2,
        -15 / 4 * x * (1.0 - z),
    ]


def _evaluate_powers(x: float) -> Array:
    """Value and first three derivatives (4, 8) of the first eight powers at x."""
    powers = np.arange(8)
    return np.array(
        [
            np.prod([powers - k for k in range(order)], axis=0, initial=1.0)
            * np.where(powers >= order, x ** np.maximum(powers - order, 0.0), 0.0)
            for order in range(4)
        ]
    )


def _join(begin: float, end: float, values: list[float]) -> Array:
    """Coefficients (8,) by powers of x, lowest first, with these values and first three derivatives at both ends."""
    return np.asarray(np.linalg.solve(np.vstack([_evaluate_powers(begin), _evaluate_powers(end)]), values))


def _solve_polynomials() -> Array:
    """Coefficients (shapes, 2, 8) of both polynomials of each half, by powers of x, lowest first."""
    found = np.empty((len(_SHAPES), 2, 8))
    for number, (top, curvature, *at_knee) in enumerate(_SHAPES):
        knee = at_knee if number else _evaluate_average(KNEE)
        found[number, 0] = _join(0.0, KNEE, [top, -0.5, curvature, 0.0, *knee])
        found[number, 1] = _join(KNEE, 1.0, [*knee, 0.0, 0.0, 0.0, 0.0])
    return found


_VALUE: Final = np.ascontiguousarray(_solve_polynomials().reshape(-1, 8).T)
_SLOPE: Final = _VALUE[1:] * np.arange(1, 8)[:, None]

#: First and third derivative at 0 of the odd functions of shape 0 and of others; value and second one of the even.
_ODD: Final = ((0.0940326, 1.088771), (0.0415232, 1.980166))
_EVEN: Final = (-6.24067e-5, 0.0267439)


def shape_value(shape: Ints, x: Array) -> Array:
    """G of shapes at x, arrays of any but the same shape; zero outside (-1, 1)."""
    y = np.minimum(np.abs(x), 1.0)
    rest = 1.0 - y
    rest *= rest
    rest *= rest
    value = ((y + 4.0) * y + 5.0) * rest  # of shape 0: (5 + 4 y + y^2) (1 - y)^4 / 32
    value *= 1 / 32
    return _put_wide(value, _VALUE, shape, y)


def shape_slope(shape: Ints, x: Array) -> Array:
    """Derivative of G by x, as :func:`shape_value`; the mean of both sides at 0."""
    y = np.minimum(np.abs(x), 1.0)
    rest = 1.0 - y
    slope = ((3.0 * y + 9.0) * y + 8.0) * rest
    rest *= rest
    slope *= rest
    slope *= -1 / 16
    return _put_wide(slope, _SLOPE, shape, y) * np.sign(x)


def _put_wide(result: Array, coefficients: Array, shape: Ints, y: Array) -> Array:
    """Replace what shape 0 has by the polynomials (powers, pieces) of the other shapes at y between 0 and 1.

    Along most of a finely divided program every shape is 0.
    """
    wide = np.flatnonzero(shape)
    if len(wide):
        at = y.take(wide)
        rows = coefficients.take(2 * shape.take(wide) + (at > KNEE), axis=1)
        value = rows[-1]
        for row in rows[-2::-1]:
            value *= at
            value += row
        result.put(wide, value)
    return result


#: Shapes from this one on are for corners that the tool brakes for.
BRAKING: Final = 4
#: How many shapes there are.
SHAPES: Final = len(_SHAPES)

_ODD_VALUE: Final = np.array(
    [
        _join(0.0, 1.0, [0.0, slope, -0.5, third, 0.0, 0.0, 0.0, 0.0])
        for slope, third in (_ODD[0], *[_ODD[1]] * (SHAPES - 1))
    ]
).T
_EVEN_VALUE: Final = _join(0.0, 1.0, [_EVEN[0], 0.0, _EVEN[1], -0.5, 0.0, 0.0, 0.0, 0.0])


def jump_values(shape: Ints, x: Array) -> tuple[Array, Array]:
    """The odd and even function (n,) of shapes (n,) at x (n,): they take out jumps of second and third derivative."""
    y = np.minimum(np.abs(x), 1.0)
    odd = polyval(y, _ODD_VALUE[:, shape], tensor=False) * np.sign(x)
    return np.asarray(odd, dtype=float), np.asarray(polyval(y, _EVEN_VALUE), dtype=float)


def jump_slopes(shape: Ints, x: Array) -> tuple[Array, Array]:
    """Derivatives by x of :func:`jump_values`."""
    y = np.minimum(np.abs(x), 1.0)
    odd, even = polyval(y, polyder(_ODD_VALUE)[:, shape], tensor=False), polyval(y, polyder(_EVEN_VALUE))
    return np.asarray(odd, dtype=float), np.asarray(even * np.sign(x), dtype=float)


_EVERYWHERE: Final = np.linspace(0.0, 1.0, 1001)
_ON_GRID: Final = np.array([shape_value(np.full(1001, shape), _EVERYWHERE) for shape in range(len(_SHAPES))])
#: Largest abs(G) of each shape: the displacement of the path over abs(bend) reach; G(0), up to rounding.
PEAK: Final = np.abs(_ON_GRID).max(axis=1)
#: Where each shape lies farthest on the outside; 0 for shape 0, which does not.
OUTSIDE: Final = np.where(_ON_GRID.min(axis=1) < 0, _EVERYWHERE[_ON_GRID.argmin(axis=1)], 0.0)
#: Largest abs of the third derivative of each shape, which at constant speed sets the jerk.
THIRD: Final = np.array(
    [
        max(
            np.abs(polyval(x, polyder(_VALUE[:, 2 * shape + piece], 3))).max()
            for piece, x in enumerate((np.linspace(0.0, KNEE, 101), np.linspace(KNEE, 1.0, 301)))
        )
        for shape in range(len(_SHAPES))
    ]
)
#: The same two of the odd functions (SHAPES,), and of the even one.
ODD_PEAK: Final = np.abs(polyval(_EVERYWHERE, _ODD_VALUE)).max(axis=1)
ODD_THIRD: Final = np.abs(polyval(_EVERYWHERE, polyder(_ODD_VALUE, 3))).max(axis=1)
EVEN_PEAK: Final = float(np.abs(polyval(_EVERYWHERE, _EVEN_VALUE)).max())
EVEN_THIRD: Final = 0.5
