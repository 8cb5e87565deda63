"""Tools as they move: poses of consecutive rows, and a tree over time that bounds how poses of a stretch differ."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.part.bodies import Piece

#: Children of a node of the tree.
FAN: Final = 8
#: The minimum between two rows is known to this, mm; below what a row can be rounded to by 1e4.
SEARCHED_MM: Final = 1e-9
#: Stretches of several rows that are bent by more than this, mm, are divided at once.
SMALL_BEND_MM: Final = 0.2
#: Tangents at the ends of a curved path may be above the distance along it by this, over the largest second derivative:
#: an eighth for the path itself, and a half for each end, whose direction is not that of the chord.
BOW_SHARE: Final = 0.625
#: Chords are joined where no place is farther from the straight line, mm: two ways along one curve, there and back, are
#: then no farther from each other, and count as one. So many are joined at most.
STRAIGHT_MM: Final = 0.001
MOST_CHORDS: Final = 16
#: An axis that changes by less than this does not turn: rounding.
SAME_AXIS: Final = 1e-9


class Level(Struct, frozen=True, eq=False):
    """Nodes of equal length: node k covers the spans that begin in ``FAN`` to the power of its level rows from k on."""

    middle: Ints  #: (n,): A row of the node.
    #: tip, chord (n,): Largest distance of its tips (mm) and of its axes (chord of unit vectors) from those of
    #: that row.
    tip: Array
    chord: Array
    last: Ints  #: (n,): Its last row: the first of the next node.
    #: tip_bend, chord_bend (n,): The same distances from the straight motion between first and last row; infinite
    #: where the tool changes between.
    tip_bend: Array
    chord_bend: Array


class Motion(Struct, frozen=True, eq=False):
    """One tool at the rows of its motion, in the order of time."""

    name: str  #: Of the tool, in messages.
    pieces: tuple[Piece, ...]
    #: tip, axis (n, 3): mm and unit vectors, in the frame of the mesh.
    tip: Array
    axis: Array
    line: Ints  #: (n,): Source lines.
    #: (n,): The tool moves straight on to the next row; not where another tool comes between, nor after the last
    #: row.
    linked: Mask
    levels: tuple[Level, ...]  #: From nodes of ``FAN`` spans to a few that cover all.
    #: How far the distance between two rows may be below what tangents at the rows say, mm: the relative path
    #: bows.
    bow: float


def build_motion(name: str, pieces: tuple[Piece, ...], tip: Array, axis: Array, line: Ints, linked: Mask) -> Motion:
    """A motion with its tree; rows at which the tool stands still are one."""
    same = (np.diff(tip, axis=0) == 0).all(axis=1) & (np.diff(axis, axis=0) == 0).all(axis=1) & linked[:-1]
    keep = np.append(~same, True)  # the last row of a standstill, whose line the next motion has
    tip, axis = (np.ascontiguousarray(one[keep], dtype=np.float64) for one in (tip, axis))
    line, linked = line[keep], linked[keep].copy()
    linked[-1] = False
    levels, size = [], FAN
    while True:
        levels.append(_build_level(tip, axis, linked, size))
        if size * FAN >= len(tip):
            break
        size *= FAN
    long = max(piece.high for piece in pieces)
    return Motion(name, pieces, tip, axis, line, linked, tuple(levels), _bound_bow(tip, axis, linked, long))


def _build_level(tip: Array, axis: Array, linked: Mask, size: int) -> Level:
    """The nodes of ``size`` spans: each has the rows from its first to the first of the next one."""
    n = len(tip)
    first = np.arange(0, n, size)
    middle, last = np.minimum(first + size // 2, n - 1), np.minimum(first + size, n - 1)
    own = np.repeat(np.arange(len(first)), np.diff(np.append(first, n)))
    share = (np.arange(n) - first[own]) / np.maximum(last - first, 1)[own]
    whole = np.logical_and.reduceat(linked | (np.arange(n) == n - 1), first)
    reach, bend = [], []
    for place in (tip, axis):
        within = np.maximum.reduceat(np.linalg.norm(place - place[middle[own]], axis=1), first)
        reach.append(np.maximum(within, np.linalg.norm(place[last] - place[middle], axis=1)))
        straight = place[first][own] + share[:, None] * (place[last] - place[first])[own]
        if place is axis:
            straight /= np.linalg.norm(straight, axis=1)[:, None]
        bent = np.maximum.reduceat(np.linalg.norm(place - straight, axis=1), first)
        bend.append(np.where(whole, bent, np.inf))
    return Level(middle, reach[0], reach[1], last, bend[0], bend[1])


def _bound_bow(tip: Array, axis: Array, linked: Mask, long: float) -> float:
    """What the relative path of a point of the tool between two rows may bow, at most."""
    if not linked.any():
        return 0.0
    at = np.flatnonzero(linked)
    move = np.linalg.norm(tip[at + 1] - tip[at], axis=1)
    turn = np.linalg.norm(axis[at + 1] - axis[at], axis=1)
    return BOW_SHARE * float((2.0 * move * turn + turn * turn * long).max())


def join_chords(tip: Array, axis: Array, owner: Ints, first: Ints) -> tuple[Ints, Ints]:
    """Join chords of one owner, of those from pose ``first`` (n,) to the next, where they are nearly one line.

    A blended corner is short and hardly bent, and a large arc nearly straight: few of their chords are needed.

    Parameters
    ----------
    tip, axis : ndarray, shape (m, 3)
        Poses, mm and unit.
    owner : ndarray of int, shape (m,)

    Returns
    -------
    first, last : ndarray of int
        The poses with which the spans begin and end.
    """
    still = np.abs(axis[first + 1] - axis[first]).max(axis=1) < SAME_AXIS
    goes_on = still[1:] & still[:-1] & (np.diff(first) == 1) & (np.diff(owner[first]) == 0)
    begins = np.flatnonzero(np.append(True, ~goes_on))
    counts = np.diff(np.append(begins, len(first)))
    number = np.arange(len(first)) - np.repeat(begins, counts)
    left = np.repeat(counts, counts) - number
    last, kept = first + 1, np.ones(len(first), dtype=bool)
    joined = np.zeros(len(first), dtype=bool)
    size = MOST_CHORDS
    while size > 1:
        some = np.flatnonzero((number % size == 0) & (left >= size) & ~joined)
        chords = some[:, None] + np.arange(size)
        start, way = tip[first[some]], tip[first[some] + size] - tip[first[some]]
        long = np.linalg.norm(way, axis=1)
        off = tip[first[chords[:, 1:]]] - start[:, None]
        along = (off @ (way / np.where(long > 0, long, 1.0)[:, None])[..., None])[..., 0]
        aside = np.sqrt(np.maximum((off * off).sum(axis=-1) - along * along, 0.0)).max(axis=1)
        steps = np.diff(along, axis=1, prepend=0.0, append=long[:, None])
        straight = (aside <= STRAIGHT_MM) & (steps >= 0).all(axis=1)
        last[some[straight]] = first[some[straight]] + size
        kept[chords[straight, 1:]] = False
        joined[chords[straight]] = True
        size //= 2
    return first[kept], last[kept]
