"""Spline segments: pieces of B-splines placed in the table frame, and what is evaluated along them.

u is the share of the tip's arc length, so that the tip moves evenly along a segment as it does along lines and arcs. A
piece is evaluated as a Bezier curve (:mod:`verne_post.base.bsplines`); verification evaluates the B-spline itself.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec.structs import asdict, replace
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints, find_used
from verne_post.base.bsplines import (
    EvenParts,
    derive_by_length,
    differentiate_bezier,
    evaluate_bezier,
    evaluate_piece_ends,
    find_bezier_controls,
    find_curve_parameter,
    find_even_parts,
    split_slices,
)
from verne_post.base.columns import GrowingTable
from verne_post.base.ragged import number_parts
from verne_post.base.rows import measure_rows, sum_rows
from verne_post.base.tolerances import POSE_DECIMALS_MM, POSE_DECIMALS_RAD, ZERO_ANGLE
from verne_post.base.units import ROTARY_METRIC_MM
from verne_post.model.findings import make_input_error
from verne_post.model.moves import Moves
from verne_post.model.protocols import TableCoordinates
from verne_post.model.splines import GrowingSplines, Splines, build_empty_splines
from verne_post.model.toolpath import SplineSegments

#: Columns of spline segments: of each piece, of each control point, of each part.
_PIECES: Final = {"length": (float,), "turn": (float,), "first_part": (np.int64,)}
_CONTROLS: Final = {"controls": (float, 6)}
_PARTS: Final = {"low": (float,), "high": (float,), "parameter": (float, 16), "bend": (float,)}
#: The curvature is looked at in so many places of each part, where its parameter is a polynomial of degree 15.
_PLACES: Final = 24


class GrowingSplineSegments:
    """Spline segments to which others are added at the end."""

    def __init__(self) -> None:
        self.count = self._parts = 0
        self._splines = GrowingSplines(5)
        self._tables = [GrowingTable(**columns) for columns in (_PIECES, _CONTROLS, _PARTS)]

    def extend(self, segments: SplineSegments) -> None:
        """Add segments."""
        self._splines.extend(segments.pieces)
        columns = asdict(segments) | {"first_part": segments.first_part + self._parts}
        for table in self._tables:
            table.extend(**columns)
        self.count += len(segments)
        self._parts += len(segments.low)

    def freeze(self) -> SplineSegments:
        """Return all of them; none can be added any more."""
        columns = [table.freeze() for table in self._tables]
        return SplineSegments(self._splines.freeze(), **columns[0], **columns[1], **columns[2])


def place_pieces(moves: Moves, row: Ints, coordinates: TableCoordinates) -> Splines:
    """Pieces of moves ``row`` (m,) in the table frame: tip (mm) and nominal angles (rad), rounded like other poses."""
    if not len(row):
        return build_empty_splines(5)
    pieces = moves.splines.select(moves.spline[row])
    frame = np.repeat(moves.frame[row], pieces.degree + 1)
    placed = np.empty((len(frame), 5))
    for index in find_used(frame):
        in_frame = np.flatnonzero(frame == index)
        tip, angles = coordinates.map_to_table(pieces.points[in_frame], moves.frames[index])
        placed[in_frame, :3] = np.round(tip, POSE_DECIMALS_MM)
        placed[in_frame, 3:] = np.round(angles, POSE_DECIMALS_RAD)
    return pieces.replace_points(placed)


def find_ends(pieces: Splines) -> Array:
    """Poses (m, 5) at the ends of pieces."""
    ends = np.empty((len(pieces), 5))
    for degree, where in pieces.group_by_degree(np.arange(len(pieces))):
        ends[where] = evaluate_piece_ends(*pieces.select_degree(where, degree))
    return ends


def turn_pieces(pieces: Splines, start: Array, end: Array) -> Splines:
    """Pieces whose table angles lead from those of poses to those of others (m, 5), and are counted from the former.

    Where another branch of the table has been chosen, A has the other sign, and C is turned. Under a vertical tool C
    may turn on the way, evenly from control point to control point of the piece as a Bezier curve.
    """
    points, weights, knots = pieces.points.copy(), pieces.weights.copy(), pieces.knots.copy()
    for degree, where in pieces.group_by_degree(np.arange(len(pieces))):
        here, weight, knot = pieces.select_degree(where, degree)
        rows = pieces.first_point[where][:, None] + np.arange(degree + 1)
        ends = evaluate_piece_ends(here, weight, knot)
        begins = _find_begins(here, weight, knot)
        away = [
            np.abs(sign * begins[:, 3] - start[where, 3]) + np.abs(sign * ends[:, 3] - end[where, 3])
            for sign in (-1, 1)
        ]
        side = np.where(away[0] < away[1], -1.0, 1.0)
        for poses in (here.transpose(1, 0, 2), begins[None], ends[None]):
            poses[..., 3] *= side
        first, last = start[where, 3:] - begins[:, 3:], end[where, 3:] - ends[:, 3:]
        here[:, :, 3:] -= begins[:, None, 3:]
        turns = np.flatnonzero((np.abs(first - last) > ZERO_ANGLE).any(axis=1))
        here[turns], weight[turns] = _convert_to_bezier(here[turns], weight[turns], knot[turns])
        knot[turns] = np.repeat([0.0, 1.0], degree)
        share = (np.arange(degree + 1) / degree)[:, None]
        here[turns, :, 3:] += share * (last - first)[turns, None]
        points[rows], weights[rows] = here, weight
        knots[pieces.first_knot[where][:, None] + np.arange(2 * degree)] = knot
    return replace(pieces, points=points, weights=weights, knots=knots)


def _find_begins(points: Array, weights: Array, knots: Array) -> Array:
    """Poses (m, k) at which pieces of one degree begin."""
    return evaluate_piece_ends(points[:, ::-1], weights[:, ::-1], -knots[:, ::-1])


def _convert_to_bezier(points: Array, weights: Array, knots: Array) -> tuple[Array, Array]:
    """Control points and weights of pieces of one degree as Bezier curves."""
    controls = find_bezier_controls(points - points[:, :1], weights, knots)
    return controls[..., :-1] / controls[..., -1:] + points[:, :1], controls[..., -1]


def make_spline_segments(pieces: Splines, line: Ints) -> SplineSegments:
    """Find what is derived from placed pieces (m,) of source lines (m,).

    A bent piece has dozens of parts: few pieces are worked on together, and what is long goes to files.

    Raises
    ------
    InputError
        VP031 where a curve stops or turns back at a point.
    """
    segments = GrowingSplineSegments()
    for some in split_slices(len(pieces)):
        segments.extend(_divide_pieces(pieces.select(np.arange(len(pieces))[some]), line[some]))
    return segments.freeze()


def _divide_pieces(pieces: Splines, line: Ints) -> SplineSegments:
    """What :func:`make_spline_segments` finds of few pieces."""
    m = len(pieces)
    length, turn = np.zeros(m), np.zeros(m)
    controls, count = np.zeros((len(pieces.points), 6)), np.zeros(m, dtype=np.int64)
    of_degree: list[tuple[NDArray[np.intp], EvenParts, Array]] = []
    for degree, where in pieces.group_by_degree(np.arange(m)):
        points, weights, knots = pieces.select_degree(where, degree)
        bezier = find_bezier_controls(points - points[:, :1], weights, knots)
        controls[pieces.first_point[where][:, None] + np.arange(degree + 1)] = bezier
        parts = find_even_parts(bezier, 3)
        if not parts.regular.all():
            at = int(line[where[np.argmin(parts.regular)]])
            text = "the spline stops or turns back at a point: it has no direction there"
            raise make_input_error("VP031", text, line=at)
        length[where] = parts.length
        count[where] = np.diff(parts.first, append=len(parts.low))
        turn[where], bends = _measure_turn(bezier, parts)
        of_degree.append((where, parts, bends))
    first = (np.cumsum(count) - count).astype(np.int64)
    total = int(count.sum())
    low, high, parameter, bend = np.empty(total), np.empty(total), np.empty((total, 16)), np.empty(total)
    for where, parts, bends in of_degree:
        owner, place = number_parts(count[where])
        rows = first[where][owner] + place
        low[rows], high[rows], parameter[rows], bend[rows] = parts.low, parts.high, parts.polynomial, bends
    return SplineSegments(pieces, length, turn, controls, first, low, high, parameter, bend)


def _measure_turn(controls: Array, parts: EvenParts) -> tuple[Array, Array]:
    """Rotation (n,) over curves, of the tip's direction and both angles; largest curvature (r,) of parts, by metric."""
    n = len(controls)
    curve = np.repeat(np.arange(n), np.diff(parts.first, append=len(parts.low)))
    x = (np.arange(_PLACES) + 0.5) / _PLACES
    x[0], x[-1] = 0.0, 1.0  # the ends of a part are looked at too
    turned, bend = np.empty((len(curve), _PLACES)), np.empty(len(curve))
    for some in split_slices(len(curve)):
        part = np.repeat(np.arange(len(curve))[some], _PLACES)
        width = (parts.high - parts.low)[part]
        low = parts.low[part]
        at = find_curve_parameter(low, parts.high[part], parts.polynomial[part], low + np.resize(x, len(part)) * width)
        first, second, _third = derive_by_length(differentiate_bezier(controls[curve[part]], at, 3), 3)
        rate = measure_rows(second[:, :3]) + sum_rows(np.abs(first[:, 3:]))
        first[:, 3:] *= ROTARY_METRIC_MM
        second[:, 3:] *= ROTARY_METRIC_MM
        square = sum_rows(first * first)
        across = second - (sum_rows(first * second) / square)[:, None] * first
        bend[some] = (measure_rows(across) / np.sqrt(square)).reshape(-1, _PLACES).max(axis=1)
        turned[some] = (rate * (width * parts.length[curve[part]] / _PLACES)).reshape(-1, _PLACES)
    turn: Array = np.bincount(np.repeat(curve, _PLACES), weights=turned.ravel(), minlength=n).astype(float)
    return turn, bend


# --- evaluation ------------------------------------------------------------------------------


def _split_by_degree(
    segments: SplineSegments, row: Ints, u: Array
) -> Iterator[tuple[NDArray[np.intp], Array, Array, Array]]:
    """By degree, for segments ``row`` (n,) at u (n,): places, Bezier control points, parameters and origins."""
    pieces = segments.pieces
    for degree, where in pieces.group_by_degree(row):
        mine, at = row[where], u[where]
        part = segments.find_parts(mine, at)
        t = find_curve_parameter(segments.low[part], segments.high[part], segments.parameter[part], at)
        point = pieces.first_point[mine][:, None] + np.arange(degree + 1)
        yield where, segments.controls[point], t, pieces.points[point[:, 0]]


def evaluate_splines(segments: SplineSegments, row: Ints, u: Array) -> Array:
    """Tip (mm) and turn of nominal angles since the start (rad), (n, 5), at u (n,) of segments ``row`` (n,)."""
    poses = np.empty((len(row), 5))
    for where, controls, t, origin in _split_by_degree(segments, row, u):
        poses[where] = evaluate_bezier(controls, t) + origin
    return poses


def differentiate_splines(segments: SplineSegments, row: Ints, u: Array) -> tuple[Array, Array, Array]:
    """First three derivatives by u of :func:`evaluate_splines`, each (n, 5)."""
    result = np.empty((3, len(row), 5))
    for where, controls, t, _origin in _split_by_degree(segments, row, u):
        length = segments.length[row[where], None]
        by_length = derive_by_length(differentiate_bezier(controls, t, 3), 3)
        for order, derivative in enumerate(by_length):
            result[order, where] = derivative * length ** (order + 1)
    return result[0], result[1], result[2]


def lift_splines(segments: SplineSegments, up: Array) -> SplineSegments:
    """The same segments, moved by ``up`` (3,), mm."""
    pieces = segments.pieces
    return replace(segments, pieces=pieces.replace_points(pieces.points + np.append(up, [0.0, 0.0])))
