"""Compensation: vertices of coarsely divided curves moved to the outside by what their corner blends cut inside.

A CAM system cuts a curve into chords whose error is near the tolerance. Blends over two segments on each side would
average the facets out, but they cut inside by several times the chord error, and the tolerance makes them narrow. Here
the vertices are moved by the opposite of what the blends will add, so that the sum follows the curve that the facets
stand for: between the vertices, which lie on it, and the middle of the chords, which lie beside it.

Only what neighbouring corners have in common is compensated. A vertex that is off the curve is averaged out as before.
"""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.base.columns import Growing, release_memory
from verne_post.base.rows import measure_rows
from verne_post.base.team import ALONE, Team, split_evenly
from verne_post.model.contour import Corners
from verne_post.toolpath.corners import (
    METRIC,
    SEGMENTS,
    USED_SHARE,
    find_bends,
    find_displacement,
    find_slopes,
    find_smaller_beside,
    find_widest,
    limit_overlap,
)
from verne_post.toolpath.deviations import Chords, find_bend_shares, find_deviations

#: The contour passes vertices on the inside at this share of the chord error. At 0.8 it uses as much of the tolerance
#: at vertices as in the middle of chords (measured from 0.3 to 1.3 on waves of 0.35 and 0.5 mm: 0.0066 to 0.0045 mm).
CUT: Final = 0.8
#: Nothing is compensated where blends cut inside by less than the first share of the tolerance, within ``WINDOW``
#: vertices on each side; everything is above the second. Below, compensated curves gain nothing, and uneven ones lose
#: up to 9 %.
NEEDED: Final = (0.7, 0.95)
WINDOW: Final = 6
#: The reach of blends over the distance to the end of the compensated stretch. At 1 the vertices would move so unevenly
#: there that the middle of their chords left the tolerance.
TAPER: Final = 0.5
#: Share of the tolerance that places between those which are looked at may use more (0.0003 was seen).
UNSEEN: Final = 0.002
#: Chord errors above this share of the tolerance are not tried.
MOST_CHORD: Final = 1.2
#: Weights of neighbouring corners in what they have in common: alternating bends cancel.
_COMMON: Final = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
#: Where bends differ from their common part by more than this share, on average, they are no curve. Random walks of 5
#: to 30 degrees have 0.6 and more, and would take up to 5 % longer; waves with three decimals have 0.1.
MOST_ROUGH: Final = 0.35
#: So many vertices at most at a time, and so many more on both sides.
COMPENSATED_VERTICES: Final = 1 << 12
OVERLAP: Final = 64


def compensate_blends(
    programmed: Array,
    vertex: Array,
    s: Array,
    soft: Mask,
    chords: Chords,
    tip_tolerance: Array,
    axis_tolerance: Array,
    team: Team = ALONE,
) -> tuple[Array, Mask]:
    """Move vertices outward, where blends over two segments then stay within the tolerance.

    Parameters
    ----------
    programmed, vertex : ndarray, shape (n + 1, 5)
        Poses at the corners as programmed, and as they are without compensation, mm and rad.
    s : ndarray, shape (n + 1,)
        Metric length at the corners, mm.
    soft : ndarray of bool, shape (n + 1,)
        Vertices of finely divided feed moves that are no features.
    chords : Chords
        How far the n segments are from what is programmed.
    tip_tolerance, axis_tolerance : ndarray, shape (n + 1,)
        mm and rad.

    Returns
    -------
    moved : ndarray, shape (n + 1, 5)
    chain : ndarray of bool, shape (n + 1,)
        Vertices whose blends have to reach as far as :func:`limit_chain_reach` says.
    """

    def compensate_part(part: tuple[int, int]) -> tuple[Array, Mask]:
        release_memory()
        begin, end = part
        if not soft[begin:end].any():
            return vertex[begin:end], np.zeros(end - begin, dtype=bool)
        first = max(begin - OVERLAP, 0)
        rows, mine = slice(first, end + OVERLAP), slice(begin - first, end - first)
        poses, members = _compensate(
            programmed[rows],
            vertex[rows],
            s[rows],
            soft[rows],
            chords.take(slice(first, end + OVERLAP - 1)),
            tip_tolerance[rows],
            axis_tolerance[rows],
        )
        return poses[mine], members[mine]

    moved, chain = Growing(float, 5), Growing(bool)
    for poses, members in team.map(compensate_part, split_evenly(len(soft), COMPENSATED_VERTICES)):
        moved.extend(poses)
        chain.extend(members)
    return moved.freeze(), chain.freeze()


def limit_chain_reach(chain: Mask, alone: Array, s: Array) -> Array:
    """Reach (n + 1,) of the blends of a chain: over two segments on each side, less near its ends; 0 for others.

    It is at least the reach ``alone`` (n + 1,) of single blends, but no blend reaches over the end of the chain.
    """
    before = s - np.maximum.accumulate(np.where(chain, s[0], s))
    after = np.minimum.accumulate(np.where(chain, s[-1], s)[::-1])[::-1] - s
    wanted = np.where(chain, np.maximum(TAPER * np.minimum(before, after), alone), 0.0)
    return limit_overlap(wanted, s, ~chain, np.zeros(len(s), dtype=bool))


def _compensate(
    programmed: Array, vertex: Array, s: Array, soft: Mask, chords: Chords, tip_tolerance: Array, axis_tolerance: Array
) -> tuple[Array, Mask]:
    """As :func:`compensate_blends`, of a part of a path."""
    n = len(s) - 1
    if n < 2 * SEGMENTS + 2:
        return vertex, np.zeros(n + 1, dtype=bool)
    length = np.diff(s)
    slope = find_slopes(vertex[:-1], vertex[1:], length)
    bend = find_bends(slope)
    bend[~soft] = 0.0
    shorter = find_smaller_beside(length)
    bend_share = find_bend_shares(bend, slope, tip_tolerance, axis_tolerance)
    chord = bend_share * shorter / 8.0
    common = np.stack([_average(column) for column in bend.T], axis=1)
    apart, whole = (_average(measure_rows(part * METRIC)) for part in (bend - common, bend))
    chain = ~_is_any_near(~(soft & (apart <= MOST_ROUGH * whole) & (chord <= MOST_CHORD)))  # and so are all near it
    every, shape = np.arange(n + 1), np.zeros(n + 1, dtype=np.int8)
    alone = find_widest(shape, bend_share)
    while chain.any():
        corners = Corners(s, limit_chain_reach(chain, alone, s), common, shape)
        inward = find_displacement(corners, every, s)
        share = _find_needed(find_bend_shares(inward, slope, tip_tolerance, axis_tolerance))
        if not (share * chain).any():
            break
        outward = (CUT / 8.0 * shorter[:, None] * common - inward) * share[:, None]
        moved = vertex + np.where(chain[:, None], outward, 0.0)
        moved_slope = find_slopes(moved[:-1], moved[1:], length)
        corners = Corners(s, corners.reach, find_bends(moved_slope), shape)
        used = find_deviations(corners, moved_slope, moved - programmed, chords, tip_tolerance, axis_tolerance)
        beyond = chain & (used > USED_SHARE - UNSEEN)
        if not beyond.any():
            return moved, chain
        chain = chain & ~_is_any_near(beyond)
    return vertex, np.zeros(n + 1, dtype=bool)


def _average(column: Array) -> Array:
    """What neighbouring corners (n,) have in common."""
    return np.convolve(column, _COMMON, mode="same")


def _find_needed(used: Array) -> Array:
    """How much of the compensation is made (n,), from 0 to 1, without a jump from vertex to vertex.

    ``used`` are shares of the tolerance (n,) that the blends would use.
    """
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(used, 2 * WINDOW, mode="edge"), 2 * WINDOW + 1)
    share = np.clip((windows.max(axis=1) - NEEDED[0]) / (NEEDED[1] - NEEDED[0]), 0.0, 1.0)
    return np.asarray(np.lib.stride_tricks.sliding_window_view(share, 2 * WINDOW + 1).mean(axis=1))


def _is_any_near(mask: Mask) -> Mask:
    """Whether a mask is set at any vertex within ``SEGMENTS``."""
    padded = np.pad(mask, SEGMENTS)
    return np.asarray(np.lib.stride_tricks.sliding_window_view(padded, 2 * SEGMENTS + 1).any(axis=1))
