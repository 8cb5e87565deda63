"""Rational curves: pieces of B-splines as Bezier curves, their derivatives, and parameters that run evenly along them.

A piece is one span between two knots: degree + 1 control points with weights, and the 2 degree knots around it. It is
turned into a Bezier curve in homogeneous coordinates, which is evaluated with all its derivatives. Where a curve has no
singular point, polynomials give its own parameter from the share of the arc length.
"""

from math import comb
from typing import Any, Final

import numpy as np
from msgspec import Struct
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import measure_rows, sum_rows
from verne_post.base.tolerances import EVEN_PARAMETER


def find_bezier_controls(points: Array, weights: Array, knots: Array) -> Array:
    """Bezier control points of spans of rational B-splines, in homogeneous coordinates.

    Parameters
    ----------
    points : ndarray, shape (n, degree + 1, k)
        Seen from somewhere near, as from the first of them: what a short span far away has would be lost in rounding.
    weights : ndarray, shape (n, degree + 1)
        Positive.
    knots : ndarray, shape (n, 2 degree)
        Those that the span depends on; the span lies between the middle two, which differ.

    Returns
    -------
    ndarray, shape (n, degree + 1, k + 1)
        Points times their weights, then the weights. Equal weights become 1 exactly.
    """
    weights = weights / weights[:, :1]
    plane = np.concatenate([points * weights[:, :, None], weights[:, :, None]], axis=2)
    degree = points.shape[1] - 1
    low, high = knots[:, degree - 1], knots[:, degree]
    controls = np.empty_like(plane)
    for place in range(degree + 1):
        # the polar form at degree - place times the low end and place times the high end
        left = plane
        for step in range(1, degree + 1):
            at = high if step <= place else low
            begin, end = knots[:, step - 1 : degree], knots[:, degree : 2 * degree - step + 1]
            share = ((at[:, None] - begin) / (end - begin))[:, :, None]
            left = left[:, :-1] + share * (left[:, 1:] - left[:, :-1])
        controls[:, place] = left[:, 0]
    return controls


def evaluate_piece_ends(points: Array, weights: Array, knots: Array) -> Array:
    """Where spans of rational B-splines end (n, k): exactly at the last control point, where the knots say so.

    Parameters are those of :func:`find_bezier_controls`; points may be far away.
    """
    degree = points.shape[1] - 1
    origin = points[:, :1]
    last = find_bezier_controls(points - origin, weights, knots)[:, -1]
    ends = last[:, :-1] / last[:, -1:] + origin[:, 0]
    there = (knots[:, degree:] == knots[:, degree : degree + 1]).all(axis=1)
    return np.where(there[:, None], points[:, -1], ends)


def evaluate_bezier(controls: Array, t: Array) -> Array:
    """Points (n, k) of rational Bezier curves with controls (n, degree + 1, k + 1) at parameters t (n,), 0 to 1."""
    plane = _evaluate_bernstein(controls, t)
    return np.asarray(plane[:, :-1] / plane[:, -1:])


def differentiate_bezier(controls: Array, t: Array, order: int) -> list[Array]:
    """Points (n, k) of rational Bezier curves (see :func:`evaluate_bezier`) and derivatives by t up to ``order``."""
    plane, differences = [], controls
    for step in range(order + 1):
        degree = differences.shape[1] - 1
        plane.append(_evaluate_bernstein(differences, t))
        if not degree:
            plane += [np.zeros_like(plane[0])] * (order - step)
            break
        differences = degree * np.diff(differences, axis=1)
    weight = [part[:, -1:] for part in plane]
    result: list[Array] = []
    for step in range(order + 1):  # (w C)^(m) = sum of binomials times w^(j) C^(m - j)
        rest = plane[step][:, :-1]
        for j in range(1, step + 1):
            rest = rest - comb(step, j) * weight[j] * result[step - j]
        result.append(rest / weight[0])
    return result


def _evaluate_bernstein(controls: Array, t: Array) -> Array:
    """Bezier curves (n, k) with control points (n, degree + 1, k) at parameters t (n,)."""
    degree = controls.shape[1] - 1
    power = np.arange(degree + 1)
    binomial = np.array([comb(degree, j) for j in power.tolist()], dtype=float)
    basis = binomial * t[:, None] ** power * (1.0 - t[:, None]) ** (degree - power)
    point = basis[:, :1] * controls[:, 0]
    for j in range(1, degree + 1):
        point += basis[:, j, None] * controls[:, j]
    return np.asarray(point)


# --- parameters that run evenly ------------------------------------------------------------------

#: Nodes of the polynomials over one part of a curve.
_NODES: Final = 16
_X: Final = np.asarray(chebyshev.chebpts1(_NODES), dtype=np.float64)
_FIT: Final = np.linalg.inv(chebyshev.chebvander(_X, _NODES - 1))
#: Chebyshev coefficients of a function -> those of its integral from -1.
_INTEGRATE: Final = np.array([chebyshev.chebint(row, lbnd=-1) for row in np.eye(_NODES)]).T
#: Newton steps from a place along a part to its parameter; each squares the error.
_NEWTON: Final = 8
#: A part of a curve is halved at most so often: at a singular place it would be for ever.
_HALVINGS: Final = 20
#: ... which is inside one of the halves or two; a curve with more that are not settled stands.
_MOST_OPEN: Final = 256
#: So many parts of curves are worked on together: nodes of more would take hundreds of megabytes.
TOGETHER: Final = 1 << 11
#: Roundings that add up in a speed.
_ROUNDINGS: Final = 8.0


class EvenParts(Struct, frozen=True, eq=False):
    """Parts of n curves, in order, on which the curve's parameter is a polynomial in the share of the arc length."""

    length: Array  #: (n,): Arc length of each curve.
    #: (n,): False where the curve stops, turns back, or stands: such curves have one part, whose polynomial means
    #: nothing.
    regular: Mask
    first: NDArray[np.int64]  #: (n,): The first part of each curve.
    #: low, high (m,): Shares of the arc length, 0 to 1, between which each part lies.
    low: Array
    high: Array
    polynomial: Array  #: (m, 16): Chebyshev coefficients of the parameter, by place on the part from -1 to 1.


def split_bezier(controls: Array, t: float) -> tuple[Array, Array]:
    """Control points (m, k) of the two parts of a Bezier curve on both sides of a parameter (de Casteljau)."""
    row, first, second = controls, [controls[0]], [controls[-1]]
    while len(row) > 1:
        row = (1.0 - t) * row[:-1] + t * row[1:]
        first.append(row[0])
        second.append(row[-1])
    return np.array(first), np.array(second[::-1])


def find_even_parts(controls: Array, measured: int) -> EvenParts:
    """Find out how arc length runs along rational Bezier curves of one degree.

    Parameters
    ----------
    controls : ndarray, shape (n, degree + 1, k + 1)
        Homogeneous.
    measured : int
        So many of the k coordinates count for the arc length.
    """
    n = len(controls)
    curve, a, b = np.arange(n), np.zeros(n), np.ones(n)
    regular = np.ones(n, dtype=bool)
    done: list[tuple[Ints, Array, Array, Array]] = []  # curve, begin by t, length, coefficients
    for halving in range(_HALVINGS + 1):
        fits = [_fit_parts(controls[curve[some]], measured, a[some], b[some]) for some in split_slices(len(curve))]
        size, polynomial, good = (np.concatenate(column) for column in zip(*fits, strict=True))
        lost = np.bincount(curve[~good], minlength=n) > (_MOST_OPEN if halving < _HALVINGS else 0)
        regular[lost] = False
        good |= lost[curve]
        done.append((curve[good], a[good], size[good], polynomial[good]))
        if good.all():
            break
        curve, a, b = curve[~good], a[~good], b[~good]
        middle = 0.5 * (a + b)
        curve, a, b = np.tile(curve, 2), np.concatenate([a, middle]), np.concatenate([middle, b])
    curve, begin, size, polynomial = (np.concatenate(column) for column in zip(*done, strict=True))
    keep = regular[curve]
    keep |= begin == 0.0  # one part of a curve that is not regular
    order = np.lexsort((begin, curve))
    order = order[keep[order]]
    curve, size, polynomial = curve[order], size[order], polynomial[order]
    length: Array = np.bincount(curve, weights=size, minlength=n).astype(float)
    first = np.searchsorted(curve, np.arange(n)).astype(np.int64)
    place = np.arange(len(curve)) - first[curve]
    upto = size.copy()
    for k in range(1, int(place.max(initial=0)) + 1):  # one curve's lengths do not depend on those of the others
        here = np.flatnonzero(place == k)
        upto[here] += upto[here - 1]
    with np.errstate(invalid="ignore", divide="ignore"):
        high = upto / length[curve]
    last = np.append(curve[1:] != curve[:-1], True)
    high[last] = 1.0
    low = np.append(0.0, high[:-1])
    low[first] = 0.0
    return EvenParts(length, regular, first, low, high, polynomial)


def split_slices(n: int, together: int = TOGETHER) -> list[slice]:
    """Rows 0 to n, ``together`` in each; one that is empty where there are none."""
    return [slice(begin, begin + together) for begin in range(0, max(n, 1), together)]


def _fit_parts(controls: Array, measured: int, a: Array, b: Array) -> tuple[Array, Array, Mask]:
    """Length (n,) of curves between parameters a and b (n,), polynomials (n, 16), and where those are exact (n,)."""
    n = len(controls)
    t = a[:, None] + 0.5 * (_X + 1.0) * (b - a)[:, None]
    slope = differentiate_bezier(np.repeat(controls, _NODES, axis=0), t.ravel(), 1)[1][:, :measured]
    speed: Array = measure_rows(slope).reshape(n, _NODES) * (0.5 * (b - a))[:, None]
    speeds = _apply(_FIT, speed)
    lengths = _apply(_INTEGRATE, speeds)
    size: Array = np.asarray(chebyshev.chebval(1.0, lengths.T), dtype=np.float64)
    # rounding of the speed, by the largest leg of the control polygon: it shows where a curve nearly stops
    legs = np.abs(np.diff(controls, axis=1)).max(axis=(1, 2)) * (controls.shape[1] - 1)
    noise = _ROUNDINGS * np.finfo(float).eps * legs * (b - a)
    good = _is_settled(speeds, noise) & (speed.min(axis=1) > 0.0) & (size > 0.0)
    # x where the length along the part is that at the nodes: Newton on a function that rises
    x = np.tile(_X, (n, 1))
    wanted = 0.5 * (_X + 1.0) * size[:, None]
    with np.errstate(all="ignore"):
        for _ in range(_NEWTON):
            upto, rate = (chebyshev.chebval(x, rows.T[:, :, None], tensor=False) for rows in (lengths, speeds))
            x = np.clip(x - (upto - wanted) / rate, -1.0, 1.0)
        places = _apply(_FIT, x)
        good &= _is_settled(places, noise / size)
        polynomial = places * (0.5 * (b - a))[:, None]
        polynomial[:, 0] += 0.5 * (a + b)
    return size, polynomial, good


def _apply(matrix: NDArray[Any], rows: NDArray[Any]) -> Array:
    """A matrix applied to each of rows (n, 16). A row's result does not depend on other rows, to the last bit."""
    result = rows[:, :1] * matrix[:, 0]
    for j in range(1, matrix.shape[1]):
        result += rows[:, j, None] * matrix[:, j]
    return np.asarray(result)


def _is_settled(coefficients: Array, noise: Array) -> Mask:
    """Whether the last Chebyshev coefficients (n, 16) are nothing beside the largest, or noise (n,)."""
    size = np.abs(coefficients)
    with np.errstate(invalid="ignore"):
        return np.asarray(size[:, -2:].max(axis=1) <= EVEN_PARAMETER * size.max(axis=1) + noise)


def find_curve_parameter(low: Array, high: Array, polynomial: Array, u: Array) -> Array:
    """Parameter (n,) of curves at shares u (n,) of their arc length, on parts of :class:`EvenParts` (n,)."""
    x = 2.0 * (u - low) / (high - low) - 1.0
    return np.asarray(chebyshev.chebval(x, polynomial.T, tensor=False))


def derive_by_length(derivatives: list[Array], measured: int) -> tuple[Array, Array, Array]:
    """First three derivatives by arc length, each (n, k), from ``derivatives`` by the parameter (points first).

    The first ``measured`` coordinates count for the arc length.
    """
    _point, c1, c2, c3 = derivatives
    tip1, tip2, tip3 = (c[:, :measured] for c in (c1, c2, c3))
    square = sum_rows(tip1 * tip1)[:, None]
    half = sum_rows(tip1 * tip2)[:, None]  # half the derivative of the square, and of that
    bend = sum_rows(tip2 * tip2 + tip1 * tip3)[:, None]
    t1 = 1.0 / np.sqrt(square)
    t2 = -half * t1**4
    t3 = 4.0 * half**2 * t1**7 - bend * t1**5
    return c1 * t1, c2 * t1**2 + c1 * t2, c3 * t1**3 + 3.0 * c2 * t1 * t2 + c1 * t3
