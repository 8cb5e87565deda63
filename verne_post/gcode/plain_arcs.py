"""Arcs in long stretches of plain lines, vectorised: to the last bit as :mod:`verne_post.gcode.arcs` makes them.

Square roots of sums and arc tangents come from the same functions of the C library, called one by one; the rest are
operations that every processor rounds alike.
"""

import math
from collections.abc import Callable

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.tolerances import (
    ARC_CHORD_MM,
    ARC_HALF_CIRCLE_SHARE,
    ARC_R_TOO_SMALL_MM,
    ARC_RADIUS_INCH_MM,
    ARC_RADIUS_MM,
    ARC_RADIUS_SHARE,
)
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.arcs import PLANES
from verne_post.gcode.machining.state import State
from verne_post.gcode.recorder import ArcRows

#: Columns of the words of arcs: I, J, K, R.
WORDS = "IJKR"
_R = 3


class PlainArcs(Struct, frozen=True, eq=False):
    """Arcs of some lines of a stretch, in order."""

    row: Ints  #: (n,): Their lines, counted from the first of the stretch.
    center: Array  #: (n, 3): Program coordinates, mm.
    sweep: Array  #: (n,): Degrees, counter-clockwise positive.
    refused_rows: Mask  #: (n,): The general interpreter has to say what is wrong; the other columns mean nothing there.

    def select_before(self, last: int, plane: int) -> "ArcRows":
        """Those of the lines before ``last``, as they are recorded."""
        n = int(np.searchsorted(self.row, last))
        return ArcRows(self.center[:n], self.sweep[:n], plane)


def find_arcs(words: Array, clockwise: Mask, row: Ints, end: Array, state: State, *, inch: bool) -> PlainArcs:
    """Centres and sweeps.

    Parameters
    ----------
    words : ndarray, shape (n, 4)
        I, J, K, R in the unit of the program; NaN where a line lacks one.
    clockwise : ndarray of bool, shape (n,)
        G2.
    row : ndarray of int, shape (n,)
    end : ndarray, shape (m, 9)
        Where every line of the stretch ends, mm and degrees.
    state : State
        That before the stretch.
    inch : bool
        Unit of the program.
    """
    first, second, normal, *_letters = PLANES[state.plane]
    words = words * MM_PER_INCH if inch else words
    start, stop = np.where((row > 0)[:, None], end[row - 1], state.position), end[row]
    given = ~np.isnan(words)
    by_radius, by_center = given[:, _R], given[:, :_R].any(axis=1)
    is_refused = (by_radius == by_center) | given[:, normal]
    center, angles = np.empty((len(row), 3)), np.empty(len(row))
    center[:, normal] = start[:, normal]
    plane, columns = np.array([first, second]), np.array([first, second, _R])
    for which, solve in ((by_center, _solve_centers), (by_radius & ~by_center, _solve_radii)):
        at = np.flatnonzero(which)
        if len(at):
            center[np.ix_(at, plane)], angles[at], wrong = solve(
                start[np.ix_(at, plane)],
                stop[np.ix_(at, plane)],
                words[np.ix_(at, columns)],
                clockwise[at],
                inch,
            )
            is_refused[at] |= wrong
    # perhaps of another plane, as its words tell
    stands = stop == start
    is_refused |= by_radius & ~stands[:, normal] & (stands[:, first] != stands[:, second])
    sweep = np.where(clockwise, -1, 1) * np.degrees(angles)
    return PlainArcs(row, center, sweep, is_refused)


def _map(function: Callable[[float, float], float], first: Array, second: Array) -> Array:
    """A function of the C library for every row."""
    return np.fromiter(map(function, first.tolist(), second.tolist()), np.float64, len(first))


def _solve_centers(start: Array, end: Array, words: Array, clockwise: Mask, inch: bool) -> tuple[Array, Array, Mask]:
    """Centre (n, 2), radians (n,) and whether refused (n,), from I, J, K in the plane."""
    tolerance = ARC_RADIUS_INCH_MM if inch else ARC_RADIUS_MM
    center = start + np.where(np.isnan(words[:, :2]), 0.0, words[:, :2])
    (s1, s2), (e1, e2) = (start - center).T, (end - center).T
    r1, r2 = _map(math.hypot, s1, s2), _map(math.hypot, e1, e2)
    allowed_difference = np.minimum(np.maximum(tolerance, ARC_RADIUS_SHARE * np.maximum(r1, r2)), 100 * tolerance)
    is_refused = (r1 < ARC_R_TOO_SMALL_MM) | (r2 < ARC_R_TOO_SMALL_MM) | (np.abs(r1 - r2) > allowed_difference)
    angle = _map(math.atan2, e2, e1) - _map(math.atan2, s2, s1)
    sweep = np.where(clockwise, -angle, angle) % (2 * math.pi)
    return center, np.where(sweep * r1 < ARC_CHORD_MM, 2 * math.pi, sweep), is_refused


def _solve_radii(start: Array, end: Array, words: Array, clockwise: Mask, _inch: bool) -> tuple[Array, Array, Mask]:
    """As :func:`_solve_centers`, from R."""
    d1, d2 = (end - start).T
    radius, half = words[:, 2], 0.5 * _map(math.hypot, d1, d2)
    size = np.abs(radius)
    is_refused = (2 * half < ARC_CHORD_MM) | (half - size > ARC_R_TOO_SMALL_MM) | (radius == 0.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        short = half <= (1.0 - ARC_HALF_CIRCLE_SHARE) * size
        height = np.where(short, np.sqrt(radius * radius - half * half), 0.0)
        side = np.where(clockwise == (radius < 0), 1.0, -1.0)
        middle = 0.5 * (start + end)
        center = np.column_stack(
            [middle[:, 0] - side * height * d2 / (2 * half), middle[:, 1] + side * height * d1 / (2 * half)]
        )
    sweep = 2 * _map(math.atan2, half, height)
    return center, np.where(radius > 0, sweep, 2 * math.pi - sweep), is_refused
