"""Facets that no tool cuts into: certain, from one point of each, by convexity.

phi of a piece is convex. So over a facet within delta of a point x it is at least phi(x) - delta |P grad phi(x)|, where
P projects on the facet. It is also at least the value of any plane or cone that supports the piece (its sides, its
end), which decides where phi has a kink. Along a straight relative path this holds for place and time together.
"""

from collections.abc import Mapping
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.part.bodies import Piece
from verne_post.part.motion import FAN, Level, Motion
from verne_post.part.sweep import (
    bound_bend,
    find_crossing,
    list_children,
    load_accelerator,
    look,
    look_between,
    measure_motion,
    take,
)

#: Spans are halved so often at most: 2**-10 of the motion between two rows.
_HALVINGS: Final = 10
#: Points that go down the tree together.
_TOGETHER: Final = 4096


def find_limit(piece: Piece, depth: float) -> float:
    """The phi that a gouge of this depth along the normal reaches somewhere on the surface, mm, below 0.

    A wedge of a tool reaches sin(half its angle) of the depth, a rounded edge all of it, up to its radius. Gouges that
    are not small against the tool count as small ones.
    """
    depth = min(depth, 0.5 * piece.radius, 0.5 * (piece.high - piece.low))
    if piece.rounding > 0:
        return -min(depth, piece.rounding)
    along = np.diff(piece.core, axis=0)
    along = along[(along != 0).any(axis=1)]
    heading = np.arctan2(along[:, 1], along[:, 0])
    sharp = np.cos(0.5 * np.diff(heading))  # sin of half the inner angle
    if piece.core[1, 1] > piece.core[0, 1]:  # a point
        sharp = np.append(sharp, np.cos(heading[0]))
    return -depth * float(sharp.min(initial=1.0))


def find_clear(
    motions: tuple[Motion, ...],
    point: Array,
    normal: Array,
    delta: Array,
    depth: float,
    parts: tuple[str, ...],
    *,
    accelerate: bool = True,
) -> Mask:
    """Where no tool cuts deeper than ``depth`` along the normal into flat facets (n,): certain where True.

    Parameters as of :func:`find_above`.
    """
    limits = {piece: find_limit(piece, depth) for motion in motions for piece in motion.pieces}
    return find_above(motions, point, normal, delta, limits, parts, accelerate=accelerate)


def find_above(
    motions: tuple[Motion, ...],
    point: Array,
    normal: Array,
    delta: Array,
    limits: Mapping[Piece, float],
    parts: tuple[str, ...] = (),
    *,
    accelerate: bool = True,
) -> Mask:
    """Where phi stays above the limit of each piece over flat facets (n,): certain where True.

    Parameters
    ----------
    point, normal : ndarray, shape (n, 3)
    delta : ndarray, shape (n,)
        No place of a facet is farther from its point, mm.
    limits : mapping
        mm.
    parts : tuple of str
        Parts of the tool that count; all where empty.
    """
    point, normal = (np.ascontiguousarray(one, dtype=np.float64) for one in (point, normal))
    clear = np.ones(len(point), dtype=bool)
    kernel = load_accelerator() if accelerate else None
    for motion in motions:
        for piece in motion.pieces:
            if parts and piece.part not in parts:
                continue
            limit = limits[piece] + motion.bow
            if kernel is not None:
                kernel.check_above(motion, piece, point, normal, delta, limit, clear)
                continue
            left = np.flatnonzero(clear)
            for first in range(0, len(left), _TOGETHER):
                some = left[first : first + _TOGETHER]
                clear[some] = _check_above(motion, piece, point[some], normal[some], delta[some], limit)
    return clear


# --- without numba -----------------------------------------------------------------------------------


def _check_above(motion: Motion, piece: Piece, point: Array, normal: Array, delta: Array, limit: float) -> Mask:
    top = motion.levels[-1]
    owner: Ints = np.repeat(np.arange(len(point)), len(top.middle))
    node: Ints = np.tile(np.arange(len(top.middle)), len(point))
    for level, below in zip(motion.levels[::-1], (*motion.levels[-2::-1], None), strict=True):
        at = level.middle[node]
        seen = look(piece, point[owner], motion.tip[at], motion.axis[at])
        lower = seen.phi - level.tip[node] - level.chord[node] * np.sqrt(np.einsum("ij,ij->i", seen.d, seen.d))
        owner, node = take(np.flatnonzero(lower - delta[owner] <= limit), owner, node)
        straight = level.tip_bend[node] < delta[owner]
        straight[straight] = is_stretch_above(
            motion, piece, level, node[straight], (point, normal, delta), owner[straight], limit
        )
        owner, node = list_children(
            owner[~straight], node[~straight], len(motion.tip) if below is None else len(below.middle)
        )
    seen = look(piece, point[owner], motion.tip[node], motion.axis[node])
    move, turn = measure_motion(motion, node)
    away = np.linalg.norm(move, axis=1) + np.linalg.norm(turn, axis=1) * np.linalg.norm(seen.d, axis=1)
    near = np.flatnonzero(seen.phi - away - delta[owner] <= limit)
    owner, row = take(near, owner, node)
    return are_spans_above(motion, piece, (point, normal, delta), owner, row, limit)


def are_spans_above(
    motion: Motion, piece: Piece, facets: tuple[Array, Array, Array], owner: Ints, row: Ints, limit: float
) -> Mask:
    """Whether phi stays above a limit over facets (n,), points, normals and delta, in their spans from rows (m,)."""
    point, normal, delta = facets
    clear = np.ones(len(point), dtype=bool)
    move, turn = measure_motion(motion, row)
    low, width = np.zeros(len(row)), np.where(motion.linked[row], 1.0, 0.0)
    for halving in range(_HALVINGS + 1):
        start, end = (
            _View(motion, piece, point[owner], normal[owner], row, move, turn, share) for share in (low, low + width)
        )
        above = _is_above(piece, start, end, width, delta[owner], limit)
        failed = ~above & (width == 0)
        for one in (start, end):
            failed |= ~above & ~_is_above(piece, one, one, 0.0 * width, delta[owner], limit)
        if halving == _HALVINGS:
            failed |= ~above
        clear[owner[failed]] = False
        left = np.flatnonzero(~above & clear[owner])
        if not len(left):
            break
        owner, row, move, turn = take(np.repeat(left, 2), owner, row, move, turn)
        width = np.repeat(0.5 * width[left], 2)
        low = np.repeat(low[left], 2) + np.tile([0.0, 1.0], len(left)) * width
    return clear


def is_stretch_above(
    motion: Motion,
    piece: Piece,
    level: Level,
    node: Ints,
    facets: tuple[Array, Array, Array],
    owner: Ints,
    limit: float,
) -> Mask:
    """Whether phi stays above a limit over whole nodes (m,), by their straight motion and its bend."""
    point, normal, delta = (one[owner] for one in facets)
    first = node * FAN ** (1 + [one is level for one in motion.levels].index(True))
    last = level.last[node]
    move, turn = motion.tip[last] - motion.tip[first], motion.axis[last] - motion.axis[first]
    start, end = (
        _View(motion, piece, point, normal, first, move, turn, np.full(len(node), share)) for share in (0.0, 1.0)
    )
    far = np.maximum(np.hypot(start.seen.r, start.seen.h), np.hypot(end.seen.r, end.seen.h)) + delta
    return _is_above(piece, start, end, np.ones(len(node)), delta, limit + bound_bend(level, node, move, turn, far))


class _View:
    """Points at shares of spans: r and h, their derivatives by the share, and along facet normals, each (n,)."""

    def __init__(
        self,
        motion: Motion,
        piece: Piece,
        point: Array,
        normal: Array,
        row: Ints,
        move: Array,
        turn: Array,
        share: Array,
    ) -> None:
        self.seen, speed = look_between(motion, piece, point, row, move, turn, share)
        seen = self.seen
        away = np.where(seen.r > 0, seen.r, np.inf)
        self.by_share_h = np.einsum("ij,ij->i", seen.d, speed) - np.einsum("ij,ij->i", move, seen.u)
        self.by_share_r = (-np.einsum("ij,ij->i", seen.d, move) - seen.h * self.by_share_h) / away
        self.normal_h = np.einsum("ij,ij->i", normal, seen.u)
        self.normal_r = (np.einsum("ij,ij->i", seen.d, normal) - seen.h * self.normal_h) / away

    def measure_gap(self, piece: Piece) -> Array:
        """How far the whole piece is beyond the facet's plane, on its outer side; no more than phi on the facet."""
        height = self.normal_r * self.seen.r + self.normal_h * self.seen.h
        across = np.sqrt(np.maximum(1.0 - self.normal_h**2, 0.0))
        support = np.max([r * across - h * self.normal_h for r, h in piece.core.tolist()], axis=0)
        return np.asarray(-height - support - piece.rounding)

    def find_tangent(self, by_r: Array, by_h: Array) -> tuple[Array, Array]:
        """Slope by the share, and along the facet, of a function with these derivatives by r and h."""
        square = np.where(self.seen.r > 0, by_r * by_r, 0.0) + by_h * by_h
        across = np.sqrt(np.maximum(square - (by_r * self.normal_r + by_h * self.normal_h) ** 2, 0.0))
        return by_r * self.by_share_r + by_h * self.by_share_h, across


def _is_above(piece: Piece, start: _View, end: _View, width: Array, delta: Array, limit: float | Array) -> Mask:
    """Whether phi is above a limit over facets and intervals, by its tangents or by a side supporting the piece."""
    functions = [[(view.seen.phi, view.seen.by_r, view.seen.by_h) for view in (start, end)]]
    for start_r, start_h, _r, _h, by_r, by_h, _square in piece.list_edges():
        functions.append(
            [
                ((view.seen.r - start_r) * by_r + (view.seen.h - start_h) * by_h - piece.rounding, by_r, by_h)
                for view in (start, end)
            ]
        )
    # along the facet's own normal: concave along a straight path, so the ends have its least value
    above = np.asarray(np.minimum(*(view.measure_gap(piece) for view in (start, end))) > limit)
    for (f0, *by0), (f1, *by1) in functions:
        (g0, q0), (g1, q1) = start.find_tangent(*by0), end.find_tangent(*by1)
        between = f0 + g0 * find_crossing(f0, g0, f1, g1, width) - delta * np.maximum(q0, q1)
        lower = np.where((g0 >= 0) | (width == 0), f0 - delta * q0, np.where(g1 <= 0, f1 - delta * q1, between))
        above |= lower > limit
    return above
