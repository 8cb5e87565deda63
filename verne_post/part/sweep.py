"""The least distance of points from a tool over all its motion, G(x) = min over time of phi: rows and between rows.

Between two rows tip and axis go straight (the axis renormalised). phi is convex along a straight relative path. So
three things decide: it changes by no more than the motion (D); tangents at both ends lie below it; and where neither is
enough, its minimum is found between the crossings of tangents. :attr:`Motion.bow` bounds how far the path bows.

Numba, if installed, walks the same tree point by point (``accelerated``); without it all points go down together.
"""

from functools import cache
from typing import Any, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.part.bodies import Piece
from verne_post.part.motion import BOW_SHARE, FAN, SEARCHED_MM, SMALL_BEND_MM, Level, Motion, build_motion

#: Tangents cross, or the span is halved, so often at most: 2**-30 of the longest motion in a row.
_STEPS: Final = 60
#: Points that go down the tree together: their pairs with nodes stay within some 100 MB.
_TOGETHER: Final = 2048


class Nearest(Struct, frozen=True, eq=False):
    """Where the moving tools come nearest to points (n,)."""

    distance: Array  #: (n,): mm, negative inside a tool; the bound that was given where none comes nearer.
    #: motion, piece, row (n,): Index of the motion, of its piece, and the row at or before; -1 where none comes
    #: nearer.
    motion: Ints
    piece: Ints
    row: Ints

    def select(self, some: Ints | Mask) -> "Nearest":
        """The same of some points."""
        return Nearest(self.distance[some], self.motion[some], self.piece[some], self.row[some])


@cache
def load_accelerator() -> Any:
    """The module with the compiled kernels; None where numba is not installed."""
    try:
        import numba  # noqa: F401
    except ImportError:
        return None
    from verne_post.part import accelerated

    return accelerated


def find_nearest(
    motions: tuple[Motion, ...],
    point: Array,
    cap: Array | float,
    parts: tuple[str, ...] = (),
    *,
    slack: float = 0.0,
    accelerate: bool = True,
) -> Nearest:
    """The least distances of points from moving tools.

    Parameters
    ----------
    point : ndarray, shape (n, 3)
        mm, in the frame of the motions.
    cap : float or ndarray, shape (n,)
        Distances from here on are not told apart.
    parts : tuple of str
        Parts of the tool that count; all where empty.
    slack : float
        Distances may be above the least ones by this, mm. Below a face that the tool slides along, thousands of rows
        are equally near except for rounding, and need not all be looked at.
    accelerate : bool
        Use numba where it is installed.
    """
    point = np.ascontiguousarray(point, dtype=np.float64)
    distance = np.array(np.broadcast_to(cap, len(point)), dtype=np.float64)
    found = Nearest(distance, *(np.full(len(point), -1) for _ in range(3)))
    kernel = load_accelerator() if accelerate else None
    for k, motion in enumerate(motions):
        for p, piece in enumerate(motion.pieces):
            if parts and piece.part not in parts:
                continue
            before = found.distance.copy()
            if kernel is None:
                for first in range(0, len(point), _TOGETHER):
                    rows = slice(first, first + _TOGETHER)
                    found.distance[rows], found.row[rows] = _search_tree(
                        motion, piece, point[rows], found.distance[rows], found.row[rows], slack
                    )
            else:
                kernel.scan(motion, piece, point, found.distance, found.row, slack)
            nearer = found.distance < before
            found.motion[nearer], found.piece[nearer] = k, p
    return found


def find_first_row(motion: Motion, point: Array, limit: float, parts: tuple[str, ...], last: int) -> int:
    """The first row from which the tool comes nearer than ``limit`` to a point (n, 3), at the latest ``last``.

    Each step halves the rows: of the earlier half it leaves only the points that the tool comes near there.
    """
    first = 0
    while first < last:
        middle = (first + last) // 2
        some = slice(first, middle + 2)
        earlier = (getattr(motion, name)[some] for name in ("tip", "axis", "line", "linked"))
        near = find_nearest((build_motion(motion.name, motion.pieces, *earlier),), point, limit, parts).row >= 0
        if near.any():
            last, point = middle, point[near]
        else:
            first = middle + 1
    return last


# --- without numba -----------------------------------------------------------------------------------


class Seen(Struct, frozen=True, eq=False):
    """Points as a pose sees them: offset d (n, 3) from the tip, axis u (n, 3), r, h, phi and its derivatives (n,)."""

    d: Array
    u: Array
    r: Array
    h: Array
    phi: Array
    by_r: Array
    by_h: Array


def look(piece: Piece, point: Array, tip: Array, axis: Array) -> Seen:
    """Points (n, 3) as poses (n, 3), (n, 3) see them."""
    d = point - tip
    h = np.einsum("ij,ij->i", d, axis)
    r = np.sqrt(np.maximum(np.einsum("ij,ij->i", d, d) - h * h, 0.0))
    return Seen(d, axis, r, h, *piece.evaluate(r, h))


def _find_slope(seen: Seen, move: Array, turn: Array) -> Array:
    """Derivative of phi by the share of a span, where the tip moves by ``move`` and the axis by ``turn`` (n, 3)."""
    dh = np.einsum("ij,ij->i", seen.d, turn) - seen.h * np.einsum("ij,ij->i", seen.u, turn)
    dh -= np.einsum("ij,ij->i", move, seen.u)
    dr = -np.einsum("ij,ij->i", seen.d, move) - seen.h * dh
    dr = np.where(seen.r > 0, dr / np.where(seen.r > 0, seen.r, 1.0), 0.0)  # on the axis 0 is a subgradient
    return seen.by_r * dr + seen.by_h * dh


def _search_tree(
    motion: Motion, piece: Piece, point: Array, best: Array, row: Ints, slack: float
) -> tuple[Array, Ints]:
    """Improve the least distances (n,) of points; returns them and their rows."""
    best, row = best.copy(), row.copy()
    top = motion.levels[-1]
    _start_greedily(motion, piece, point, best, row)
    owner: Ints = np.repeat(np.arange(len(point)), len(top.middle))
    node: Ints = np.tile(np.arange(len(top.middle)), len(point))
    for level, below in zip(motion.levels[::-1], (*motion.levels[-2::-1], None), strict=True):
        owner, node = _drop_far(motion, piece, point, level, owner, node, best, row, slack)
        owner, node = list_children(owner, node, len(motion.tip) if below is None else len(below.middle))
    search_spans(motion, piece, point, owner, node, best, row, slack)
    return best, row


def _start_greedily(motion: Motion, piece: Piece, point: Array, best: Array, row: Ints) -> None:
    """Go down to one row of each point by the nearest of the middle poses: a first distance."""
    n, top = len(point), motion.levels[-1]
    node = np.zeros(n, dtype=np.int64)
    for level in (*motion.levels[::-1], None):
        count = len(motion.tip) if level is None else len(level.middle)
        fan = len(top.middle) if level is top else FAN
        owner = np.repeat(np.arange(n), fan)
        child = np.minimum(np.repeat(node if level is top else FAN * node, fan) + np.tile(np.arange(fan), n), count - 1)
        at = child if level is None else level.middle[child]
        phi = look(piece, point[owner], motion.tip[at], motion.axis[at]).phi.reshape(n, fan)
        chosen = phi.argmin(axis=1)
        node = child.reshape(n, fan)[np.arange(n), chosen]
        _improve(best, row, np.arange(n), phi.min(axis=1), at.reshape(n, fan)[np.arange(n), chosen])


def _improve(best: Array, row: Ints, owner: Ints, phi: Array, at: Ints) -> None:
    """Take the distances phi (m,) at rows ``at`` that are below the best of their owners; owners are sorted."""
    if not len(owner):
        return
    begin = np.flatnonzero(np.diff(owner, prepend=-1))
    least = np.minimum.reduceat(phi, begin)
    who = owner[begin]
    nearer = least < best[who]
    best[who[nearer]] = least[nearer]
    hit = np.flatnonzero(phi <= best[owner])
    row[owner[hit]] = at[hit]


def take(some: Ints, *columns: Array | Ints) -> Any:
    """The same rows of several columns."""
    return tuple(one[some] for one in columns)


def list_children(owner: Ints, node: Ints, count: int) -> tuple[Ints, Ints]:
    """The children below ``count`` of pairs of owner and node."""
    child = FAN * np.repeat(node, FAN) + np.tile(np.arange(FAN), len(node))
    there = child < count
    return np.repeat(owner, FAN)[there], child[there]


def _drop_far(
    motion: Motion,
    piece: Piece,
    point: Array,
    level: Level,
    owner: Ints,
    node: Ints,
    best: Array,
    row: Ints,
    slack: float,
) -> tuple[Ints, Ints]:
    """Pairs of points and nodes in which the tool may come nearer than it is known to."""
    at = level.middle[node]
    seen = look(piece, point[owner], motion.tip[at], motion.axis[at])
    _improve(best, row, owner, seen.phi, at)
    lower = seen.phi - level.tip[node] - level.chord[node] * np.sqrt(np.einsum("ij,ij->i", seen.d, seen.d))
    owner, node = take(np.flatnonzero(lower < best[owner] - slack), owner, node)
    lower, ends = bound_stretches(motion, piece, point, level, owner, node)
    for at, phi in ends:
        _improve(best, row, owner, phi, at)
    return take(np.flatnonzero(lower - motion.bow < best[owner] - slack), owner, node)


def bound_stretches(
    motion: Motion, piece: Piece, point: Array, level: Level, owner: Ints, node: Ints
) -> tuple[Array, list[tuple[Ints, Array]]]:
    """Lower bounds (m,) of the distance over whole nodes, by tangents to their straight motion and its bend.

    -inf where that is much. Also both ends: their rows (m,), and the distances there (m,).
    """
    first = node * FAN ** (1 + [one is level for one in motion.levels].index(True))
    last = level.last[node]
    move, turn = motion.tip[last] - motion.tip[first], motion.axis[last] - motion.axis[first]
    start, end = (look(piece, point[owner], motion.tip[at], motion.axis[at]) for at in (first, last))
    far = np.maximum(np.hypot(start.r, start.h), np.hypot(end.r, end.h))
    lower = find_lowest(start.phi, _find_slope(start, move, turn), end.phi, _find_slope(end, move, turn))
    lower -= bound_bend(level, node, move, turn, far)
    lower[level.tip_bend[node] >= SMALL_BEND_MM] = -np.inf
    return lower, [(first, start.phi), (last, end.phi)]


def bound_bend(level: Level, node: Ints, move: Array, turn: Array, far: Array) -> Array:
    """Bound, mm, of how far points within ``far`` (m,) of the tip are off their straight relative path over nodes."""
    length, angle = np.linalg.norm(move, axis=1), np.linalg.norm(turn, axis=1)
    bent = level.tip_bend[node] + level.chord_bend[node] * (far + level.tip_bend[node])
    return bent + BOW_SHARE * (2.0 * length * angle + angle * angle * far)


def search_spans(
    motion: Motion, piece: Piece, point: Array, owner: Ints, first: Ints, best: Array, row: Ints, slack: float = 0.0
) -> None:
    """Look at rows ``first`` (m,) and at the spans that begin with them."""
    start = look(piece, point[owner], motion.tip[first], motion.axis[first])
    _improve(best, row, owner, start.phi, first)
    # a rough bound with one end, before the other is looked at
    after = np.minimum(first + 1, len(motion.tip) - 1)
    move, turn = measure_motion(motion, first)
    away = np.sqrt(np.einsum("ij,ij->i", move, move))
    away += np.sqrt(np.einsum("ij,ij->i", turn, turn) * np.einsum("ij,ij->i", start.d, start.d))
    near = np.flatnonzero(motion.linked[first] & (start.phi - away < best[owner] - slack))
    owner, first, after, move, turn, away = take(near, owner, first, after, move, turn, away)
    start = _select_seen(start, near)
    end = look(piece, point[owner], motion.tip[after], motion.axis[after])
    _improve(best, row, owner, end.phi, after)
    near = np.flatnonzero(0.5 * (start.phi + end.phi - away) < best[owner] - slack)
    owner, first, move, turn = take(near, owner, first, move, turn)
    start, end = _select_seen(start, near), _select_seen(end, near)
    low, high = np.zeros(len(owner)), np.ones(len(owner))
    f0, f1 = start.phi, end.phi
    g0, g1 = _find_slope(start, move, turn), _find_slope(end, move, turn)
    for step in range(_STEPS):
        crossing = find_crossing(f0, g0, f1, g1, high - low)
        lower = f0 + g0 * crossing
        # the path is not quite straight: with its bow the least distance may be below both tangents
        near = np.flatnonzero(
            (g0 < 0) & (g1 > 0) & (lower - motion.bow < best[owner]) & (np.minimum(f0, f1) - lower > SEARCHED_MM)
        )
        if not len(near):
            return
        owner, first, move, turn, low, high, f0, f1, g0, g1, crossing = take(
            near, owner, first, move, turn, low, high, f0, f1, g0, g1, crossing
        )
        share = low + crossing if step % 3 < 2 else 0.5 * (low + high)
        seen, speed = look_between(motion, piece, point[owner], first, move, turn, share)
        _improve(best, row, owner, seen.phi, first)
        slope = _find_slope(seen, move, speed)
        falls = slope < 0
        low, f0, g0 = (np.where(falls, *one) for one in ((share, low), (seen.phi, f0), (slope, g0)))
        high, f1, g1 = (np.where(falls, *one) for one in ((high, share), (f1, seen.phi), (g1, slope)))


def measure_motion(motion: Motion, row: Ints) -> tuple[Array, Array]:
    """Changes of tip and axis (m, 3) from rows (m,) to the next ones; 0 where the tool does not move on to them."""
    after = np.where(motion.linked[row], row + 1, row)
    return motion.tip[after] - motion.tip[row], motion.axis[after] - motion.axis[row]


def find_crossing(f0: Array, g0: Array, f1: Array, g1: Array, width: Array) -> Array:
    """Where tangents at both ends of intervals cross, from the lower end."""
    bend = g1 - g0
    return np.clip((f0 - f1 + g1 * width) / np.where(bend > 0, bend, 1.0), 0.0, width)


def find_lowest(f0: Array, g0: Array, f1: Array, g1: Array) -> Array:
    """The least value (m,) of a convex function on [0, 1] with these values and tangents at both ends."""
    between = f0 + g0 * find_crossing(f0, g0, f1, g1, np.ones(len(f0)))
    return np.where(g0 >= 0, f0, np.where(g1 <= 0, f1, between))


def _select_seen(seen: Seen, some: Ints) -> Seen:
    return Seen(*(getattr(seen, name)[some] for name in Seen.__struct_fields__))


def look_between(
    motion: Motion, piece: Piece, point: Array, first: Ints, move: Array, turn: Array, share: Array
) -> tuple[Seen, Array]:
    """Points as the pose at a share of a span sees them, and the derivative of the axis by the share."""
    axis = motion.axis[first] + share[:, None] * turn
    long = np.sqrt(np.einsum("ij,ij->i", axis, axis))[:, None]
    axis = axis / long
    speed = (turn - axis * np.einsum("ij,ij->i", axis, turn)[:, None]) / long
    return look(piece, point, motion.tip[first] + share[:, None] * move, axis), speed
