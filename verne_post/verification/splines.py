"""Splines as verification sees them: de Boor's algorithm on control points and knots, and lengths by quadrature.

Nothing of what planning has derived from a spline is used, only its control points, weights and knots.
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.ragged import number_parts
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.model.splines import Splines
from verne_post.verification.matching import match_places

#: Gauss-Legendre nodes of a panel, from 0 to 1, and their weights.
_NODES, _WEIGHTS = (np.asarray(part) for part in np.polynomial.legendre.leggauss(8))
_NODES, _WEIGHTS = 0.5 * (_NODES + 1.0), 0.5 * _WEIGHTS
#: A piece is measured in so many panels, and in twice as many until its length changes by no more than this share.
_PANELS, _MOST_PANELS = 4, 4096
_SETTLED: Final = 1e-9
#: Newton steps to the parameter at a length: the speed hardly changes within a panel.
_STEPS: Final = 5
#: Share of a piece after whose step the next would be lost in rounding, since each squares the error.
_NEGLIGIBLE: Final = 1e-9
#: Rows are looked at so many at a time: each is compared with all panels of its piece.
_ROWS: Final = 1024
#: Nearest places of one row that are refined, steps of each at most, and the step (a share of the piece) that is the
#: last: the next would be negligible, since each squares the error.
_CANDIDATES, _REFINEMENTS, _REFINED = 3, 12, 1e-7
#: So many places of a piece are looked at where no candidate has come near.
_CLOSER: Final = 257
#: Places of one curve that are this near to being equally far from a row (mm) are told apart by the row before.
_EQUALLY_FAR_MM: Final = 2e-3


class MeasuredSplines(Struct, frozen=True, eq=False):
    """Some pieces of B-splines (m,), measured along."""

    pieces: Splines  #: Tip (mm) and turn of the angles since the start (rad).
    first: Ints  #: (m + 1,): First row of each piece in what follows; a piece has one row more than panels.
    at: Array  #: (r,): Parameter of the B-spline.
    #: length, metric (r,): Length from the start of the piece to there: of the tip, and of tip and angles
    #: together, mm.
    length: Array
    metric: Array
    pose: Array  #: (r, 5)

    def measure_lengths(self, piece: Ints) -> Array:
        """Length of the tip (n,) over pieces (n,), mm."""
        return self.length[self.first[piece + 1] - 1]

    def measure_total_metric(self, piece: Ints) -> Array:
        """Length of tip and angles (n,) over pieces (n,), mm."""
        return self.metric[self.first[piece + 1] - 1]


def measure_splines(pieces: Splines, radian_mm: float) -> MeasuredSplines:
    """Measure pieces; a radian of the angles counts for so many mm of their metric length."""
    panels = np.zeros(len(pieces), dtype=np.int64)
    lengths: list[tuple[Ints, Array]] = []  # of pieces, over each of their panels
    left, count = np.arange(len(pieces)), _PANELS
    coarse = _measure_panels(pieces, left, count, radian_mm)
    while len(left):
        count *= 2
        fine = _measure_panels(pieces, left, count, radian_mm)
        total = fine.sum(axis=2)
        settled = (np.abs(coarse.sum(axis=2) - total) <= _SETTLED * total).all(axis=0) | (count >= _MOST_PANELS)
        lengths.append((left[settled], fine[:, settled]))
        panels[left[settled]] = count
        left, coarse = left[~settled], fine[:, ~settled]
    first = np.append(0, np.cumsum(panels + 1))
    sums = np.zeros((2, int(first[-1])))
    for piece, parts in lengths:
        rows = first[piece][:, None] + np.arange(1, parts.shape[2] + 1)
        sums[:, rows] = np.cumsum(parts, axis=2)
    owner, place = number_parts(panels + 1)
    low, high = _find_ends(pieces, owner)
    at = low + (high - low) * (place / panels[owner])
    return MeasuredSplines(pieces, first, at, sums[0], sums[1], evaluate_spline_points(pieces, owner, at))


def _find_ends(pieces: Splines, piece: Ints) -> tuple[Array, Array]:
    """Knots (n,) between which pieces (n,) run."""
    middle = pieces.first_knot[piece] + pieces.degree[piece]
    return pieces.knots[middle - 1], pieces.knots[middle]


def _measure_panels(pieces: Splines, piece: Ints, count: int, radian_mm: float) -> Array:
    """Lengths (2, n, count) over the panels of pieces (n,): of the tip, and of tip and angles together."""
    low, high = _find_ends(pieces, piece)
    width = ((high - low) / count)[:, None]
    at = (low[:, None] + np.arange(count) * width)[:, :, None] + _NODES * width[:, :, None]
    many = np.repeat(piece, count * len(_NODES))
    slope = differentiate_spline_points(pieces, many, at.ravel())[1].reshape(*at.shape, 5)
    speed, turn = np.linalg.norm(slope[..., :3], axis=3), radian_mm * np.linalg.norm(slope[..., 3:], axis=3)
    return np.stack([speed @ _WEIGHTS, np.hypot(speed, turn) @ _WEIGHTS]) * width


# --- evaluation ------------------------------------------------------------------------------


def evaluate_spline_points(pieces: Splines, piece: Ints, at: Array) -> Array:
    """Poses (n, 5) of pieces (n,) at parameters (n,) of the B-spline."""
    return differentiate_spline_points(pieces, piece, at)[0]


def differentiate_spline_points(pieces: Splines, piece: Ints, at: Array) -> tuple[Array, Array]:
    """Poses (n, 5) as :func:`evaluate_spline_points`, and their derivatives by the parameter.

    De Boor's triangle runs in homogeneous coordinates down to its last two points, whose difference is the derivative.
    """
    point, slope = np.empty((len(piece), 5)), np.empty((len(piece), 5))
    for degree, where in pieces.group_by_degree(piece):
        points, weights, knots = pieces.select_degree(piece[where], degree)
        x = at[where, None]
        origin = points[:, :1]
        row = np.concatenate([(points - origin) * weights[:, :, None], weights[:, :, None]], axis=2)
        for level in range(1, degree):
            row = _climb_level(row, x, knots, level, degree)
        begin, end = knots[:, degree - 1], knots[:, degree]
        rise = degree * (row[:, 1] - row[:, 0]) / (end - begin)[:, None]
        top = _climb_level(row, x, knots, degree, degree)[:, 0]
        weight = top[:, -1:]
        here = top[:, :-1] / weight
        point[where] = here + origin[:, 0]
        slope[where] = (rise[:, :-1] - rise[:, -1:] * here) / weight
    return point, slope


def _climb_level(row: Array, x: Array, knots: Array, level: int, degree: int) -> Array:
    """One level of de Boor's triangle: (n, j, k) -> (n, j - 1, k)."""
    begin, end = knots[:, level - 1 : degree], knots[:, degree : 2 * degree - level + 1]
    share = ((x - begin) / (end - begin))[:, :, None]
    return np.asarray((1.0 - share) * row[:, :-1] + share * row[:, 1:])


def measure_lengths_at(splines: MeasuredSplines, piece: Ints, at: Array, radian_mm: float) -> tuple[Array, Array]:
    """Lengths (n,) from the start of pieces (n,) to parameters (n,): of the tip, and of tip and angles together, mm."""
    low, high = _find_ends(splines.pieces, piece)
    panels = splines.first[piece + 1] - splines.first[piece] - 1
    panel = np.clip(((at - low) / (high - low) * panels).astype(int), 0, panels - 1)
    row = splines.first[piece] + panel
    width = at - splines.at[row]
    inner = splines.at[row][:, None] + _NODES * width[:, None]
    slope = differentiate_spline_points(splines.pieces, np.repeat(piece, len(_NODES)), inner.ravel())[1].reshape(
        *inner.shape, 5
    )
    speed, turn = np.linalg.norm(slope[..., :3], axis=2), radian_mm * np.linalg.norm(slope[..., 3:], axis=2)
    return splines.length[row] + speed @ _WEIGHTS * width, splines.metric[row] + np.hypot(
        speed, turn
    ) @ _WEIGHTS * width


def find_parameters_at(splines: MeasuredSplines, piece: Ints, u: Array, radian_mm: float) -> Array:
    """Parameters (n,) of pieces (n,) at shares u (n,) of the length of the tip, 0 to 1."""
    result = np.empty(len(u))
    low, high = _find_ends(splines.pieces, piece)
    for begin in range(0, len(u), _ROWS):
        some = slice(begin, begin + _ROWS)
        mine, wanted = piece[some], u[some] * splines.measure_lengths(piece[some])
        row = _find_panel(splines, mine, wanted)
        before, after = splines.length[row], splines.length[row + 1]
        share = np.clip((wanted - before) / np.maximum(after - before, np.finfo(float).tiny), 0.0, 1.0)
        at = splines.at[row] + share * (splines.at[row + 1] - splines.at[row])
        for _ in range(_STEPS):
            slope = differentiate_spline_points(splines.pieces, mine, at)[1]
            missing = wanted - measure_lengths_at(splines, mine, at, radian_mm)[0]
            step = missing / measure_rows(slope[:, :3])
            at = np.clip(at + step, low[some], high[some])
            if (np.abs(step) <= _NEGLIGIBLE * (high - low)[some]).all():
                break
        result[some] = at
    return result


def _find_panel(splines: MeasuredSplines, piece: Ints, length: Array) -> Ints:
    """Row of the panel of pieces (n,) in which a length (n,) of the tip is reached."""
    first, last = splines.first[piece], splines.first[piece + 1] - 2
    while (last > first).any():  # bisection
        middle = (first + last + 1) // 2
        beyond = splines.length[middle] > length
        first, last = np.where(beyond, first, middle), np.where(beyond, middle - 1, last)
    return np.asarray(first)


# --- projection ------------------------------------------------------------------------------


class _Samples(Struct, frozen=True, eq=False):
    """Places of pieces (k,): parameters ``at`` (r,), poses (r, 5); those of piece i begin at ``first[i]``, (k + 1,)."""

    piece: Ints
    first: Ints
    at: Array
    pose: Array


class _Candidates(Struct, frozen=True, eq=False):
    """Shares u (n, candidates) of places for poses, and weighted offsets of the poses from them (n, candidates, 5).

    What is not found is infinitely far.
    """

    u: Array
    off: Array

    @property
    def away(self) -> Array:
        """Distances (n, candidates), mm."""
        return np.asarray(np.linalg.norm(self.off, axis=2))

    def append_rows(self, rows: Ints, more: "_Candidates") -> "_Candidates":
        """These and those of some rows (m,)."""
        u, off = np.zeros((len(self.u), more.u.shape[1])), np.full((len(self.u), *more.off.shape[1:]), np.inf)
        u[rows], off[rows] = more.u, more.off
        return _Candidates(np.concatenate([self.u, u], axis=1), np.concatenate([self.off, off], axis=1))


def project(
    splines: MeasuredSplines,
    piece: Ints,
    pose: Array,
    fresh: Mask,
    u_before: float,
    radian_mm: float,
    bounds: tuple[Array, Array] | None,
) -> Array:
    """Share u (n,) of the length of the tip at the places of pieces (n,) that are nearest to poses (n, 5).

    Beyond both ends the curve goes on straight, there by shares of the metric length. Where a curve comes near itself,
    a row may belong to any place within ``bounds``, of the tip (mm) and of the angles (rad), (n,) both; the places that
    follow from row to row are chosen. None: the nearest. ``fresh`` (n,) marks first rows of a segment, and ``u_before``
    is that of the row before the first.
    """
    weight = np.array([1.0, 1.0, 1.0, radian_mm, radian_mm])
    every = _Samples(np.arange(len(splines.pieces)), splines.first, splines.at, splines.pose)
    found = _search(splines, every, piece, pose, weight, radian_mm)
    far = np.flatnonzero(found.away.min(axis=1) > _EQUALLY_FAR_MM)
    if len(far):  # the few places of the panels may have missed a bend: look closer
        pieces, mine = np.unique(piece[far], return_inverse=True)
        low, high = _find_ends(splines.pieces, pieces)
        at = (low[:, None] + np.linspace(0.0, 1.0, _CLOSER) * (high - low)[:, None]).ravel()
        there = evaluate_spline_points(splines.pieces, np.repeat(pieces, _CLOSER), at)
        closer = _Samples(pieces, _CLOSER * np.arange(len(pieces) + 1), at, there)
        found = found.append_rows(far, _search(splines, closer, mine, pose[far], weight, radian_mm))
    nearest = found.u[np.arange(len(piece)), np.argmin(found.away, axis=1)]
    if bounds is None:
        return nearest
    share = np.maximum(
        np.linalg.norm(found.off[..., :3], axis=2) / bounds[0][:, None],
        np.abs(found.off[..., 3:]).max(axis=2) / (radian_mm * bounds[1][:, None]),
    )
    possible = (share <= 1.0) | (found.away <= found.away.min(axis=1, keepdims=True) + _EQUALLY_FAR_MM)
    return _choose_places(found.u, possible, nearest, splines.measure_lengths(piece), pose, fresh, u_before)


def _choose_places(
    u: Array, possible: Mask, nearest: Array, total: Array, pose: Array, fresh: Mask, u_before: float
) -> Array:
    """Share (n,) of each row among u (n, candidates): the nearest, or by the rows beside where several may be."""
    several: Mask = np.any(possible & (np.abs(u - nearest[:, None]) > _SETTLED), axis=1)
    if not several.any():
        return nearest
    result = nearest.copy()
    step = measure_rows(np.diff(pose[:, :3], axis=0, prepend=pose[:1, :3]))
    step[fresh] = 0.0  # from the start of the piece; the row before is on another one, perhaps far from here
    begins = np.flatnonzero(several & (fresh | ~np.append(False, several[:-1])))
    # the row after them, which is not doubtful, decides too
    ends = np.flatnonzero(~np.append(several[:-1] & ~fresh[1:], False)) + 1
    for begin, end in zip(begins.tolist(), ends[np.searchsorted(ends, begins, side="right")].tolist(), strict=True):
        row, candidate = np.nonzero(possible[begin:end])
        row += begin
        before = 0.0 if fresh[begin] else (result[begin - 1] if begin else u_before)
        found = match_places(
            np.zeros(len(row), dtype=np.int64),
            u[row, candidate] * total[row],
            np.zeros(len(row)),
            np.searchsorted(row, np.arange(begin, end + 1)),
            before * total[begin],
            step[begin:end],
        )
        result[begin:end] = u[row, candidate][found]
    return result


def _search(
    splines: MeasuredSplines, samples: _Samples, own: Ints, pose: Array, weight: Array, radian_mm: float
) -> _Candidates:
    """Places nearest to poses (n, 5), each sought from the nearest samples of its piece ``own`` (n,)."""
    u, off = np.zeros((len(own), _CANDIDATES)), np.full((len(own), _CANDIDATES, 5), np.inf)
    first, at = samples.first, samples.at
    for begin in range(0, len(own), _ROWS):
        mine, poses = own[begin : begin + _ROWS], pose[begin : begin + _ROWS]
        row, local = _find_candidates(first, samples.pose, mine, poses, weight)
        rows, place = np.nonzero(local)
        row, owner = row[rows, place], mine[rows]
        low, high = at[np.maximum(row - 1, first[owner])], at[np.minimum(row + 1, first[owner + 1] - 1)]
        found = _refine(splines, samples.piece[owner], poses[rows], (low, at[row], high), weight, radian_mm)
        u[begin + rows, place], off[begin + rows, place] = found
    return _Candidates(u, off)


def _find_candidates(first: Ints, there: Array, piece: Ints, pose: Array, weight: Array) -> tuple[Ints, Mask]:
    """Rows (n, candidates) of the poses of pieces (n,) that are locally nearest to poses (n, 5), and which are."""
    count = first[piece + 1] - first[piece]
    owner, place = number_parts(count)
    row = first[piece][owner] + place
    away = measure_rows((there[row] - pose[owner]) * weight)
    before, after = np.append(np.inf, away[:-1]), np.append(away[1:], np.inf)
    local = ((place == 0) | (away <= before)) & ((place == count[owner] - 1) | (away < after))
    # the nearest local minima of every row; each has one at least
    order = np.lexsort((np.where(local, away, np.inf), owner))
    begin = np.cumsum(count) - count
    chosen = order[begin[:, None] + np.minimum(np.arange(_CANDIDATES), count[:, None] - 1)]
    return row[chosen], local[chosen]


def _refine(
    splines: MeasuredSplines,
    piece: Ints,
    pose: Array,
    within: tuple[Array, Array, Array],
    weight: Array,
    radian_mm: float,
) -> tuple[Array, Array]:
    """Nearest shares u (n,) of pieces (n,) ``within`` (lowest, first, highest) parameters, and offsets of poses."""
    low, at, high = within
    for _ in range(_REFINEMENTS):  # Gauss-Newton
        point, slope = differentiate_spline_points(splines.pieces, piece, at)
        off, slope = (pose - point) * weight, slope * weight
        better = np.clip(at + np.sum(off * slope, axis=1) / np.sum(slope * slope, axis=1), low, high)
        at, step = better, np.abs(better - at) / (high - low)
        if step.max(initial=0.0) < _REFINED:
            break
    point, slope = differentiate_spline_points(splines.pieces, piece, at)
    total = splines.measure_lengths(piece)
    u = measure_lengths_at(splines, piece, at, radian_mm)[0] / total
    low, high = _find_ends(splines.pieces, piece)
    # beyond an end along the direction that the curve has there
    off, slope = (pose - point) * weight, slope * weight
    along = np.sum(off * slope, axis=1) / np.sum(slope * slope, axis=1)
    ahead = np.where(at >= high, np.maximum(along, 0.0), np.where(at <= low, np.minimum(along, 0.0), 0.0))
    u += ahead * measure_rows(slope) / np.maximum(splines.measure_total_metric(piece), ZERO_LENGTH_MM)
    return u, off - ahead[:, None] * slope
