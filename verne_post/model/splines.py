"""Pieces of rational B-splines: the data of curved moves and segments that are neither lines nor arcs.

A piece is what a B-spline is between two knots. It has degree + 1 control points with their weights, and the 2 degree
knots that it depends on; it runs from its knot ``degree - 1`` to its knot ``degree``. A Bezier curve is a piece with
only two different knots. All coordinates share one basis: places and table angles go along together.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints, find_used
from verne_post.base.columns import GrowingTable


class Splines(Struct, frozen=True, eq=False):
    """Pieces of rational B-splines, m of them, in order."""

    degree: NDArray[np.int32]  #: (m,)
    #: first_point, first_knot (m,): Rows of the first control point and of the first knot of each piece.
    first_point: NDArray[np.int64]
    first_knot: NDArray[np.int64]
    points: Array  #: (p, k): Control points.
    weights: Array  #: (p,): Positive.
    knots: Array  #: (q,)

    def __len__(self) -> int:
        return len(self.degree)

    def select_degree(self, piece: Ints, degree: int) -> tuple[Array, Array, Array]:
        """Control points (n, degree + 1, k), weights (n, degree + 1), knots (n, 2 degree) of pieces of one degree."""
        point = self.first_point[piece][:, None] + np.arange(degree + 1)
        return (
            self.points[point],
            self.weights[point],
            self.knots[self.first_knot[piece][:, None] + np.arange(2 * degree)],
        )

    def group_by_degree(self, piece: Ints) -> Iterator[tuple[int, NDArray[np.intp]]]:
        """Every degree among pieces (n,), and the places of those that have it."""
        degrees = self.degree[piece]
        for degree in find_used(degrees):
            yield degree, np.flatnonzero(degrees == degree)

    def select(self, piece: Ints) -> "Splines":
        """Some of the pieces, in any order, without what only others need."""
        degree = self.degree[piece]
        point, knot = (
            _spread(first[piece], count)
            for first, count in ((self.first_point, degree + 1), (self.first_knot, 2 * degree))
        )
        return Splines(
            degree,
            _make_begins(degree + 1),
            _make_begins(2 * degree),
            self.points[point],
            self.weights[point],
            self.knots[knot],
        )

    def replace_points(self, points: Array) -> "Splines":
        """The same pieces with other control points (p, k)."""
        return replace(self, points=points)


def _make_begins(count: Ints) -> NDArray[np.int64]:
    return np.append(0, np.cumsum(count))[: len(count)].astype(np.int64)


def _spread(first: Ints, count: Ints) -> NDArray[np.int64]:
    return np.repeat(first - _make_begins(count), count) + np.arange(int(count.sum()))


_PIECES: Final = {"degree": (np.int32,), "first_point": (np.int64,), "first_knot": (np.int64,)}


class GrowingSplines:
    """Pieces to which others are added at the end; control points have ``width`` coordinates."""

    def __init__(self, width: int) -> None:
        self.count = self._points = self._knots = 0
        self._pieces = GrowingTable(**_PIECES)
        self._controls, self._knot_values = (
            GrowingTable(points=(float, width), weights=(float,)),
            GrowingTable(knots=(float,)),
        )

    def extend(self, pieces: Splines) -> None:
        """Add pieces."""
        self._pieces.extend(
            degree=pieces.degree,
            first_point=pieces.first_point + self._points,
            first_knot=pieces.first_knot + self._knots,
        )
        self._controls.extend(points=pieces.points, weights=pieces.weights)
        self._knot_values.extend(knots=pieces.knots)
        self.count += len(pieces)
        self._points += len(pieces.points)
        self._knots += len(pieces.knots)

    def freeze(self) -> Splines:
        """Return all pieces; none can be added any more."""
        return Splines(**self._pieces.freeze(), **self._controls.freeze(), **self._knot_values.freeze())


def build_empty_splines(width: int) -> Splines:
    """Return a table without pieces."""
    return GrowingSplines(width).freeze()
