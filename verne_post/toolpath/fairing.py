"""Fairing: vertices of finely divided curves moved a little, so that their decimals do not shake the machine.

CAM systems write points with three or four decimals. At 0.2 mm from point to point that is an error of several
thousandths in direction at every vertex, which costs jerk. A smoothing spline through tip and table angles takes out
what is shorter than a dozen points; no vertex moves by more than a share of its tolerance, and sharp corners, stops
and the ends of a stretch do not move at all.
"""

from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array, Mask
from verne_post.base.columns import Growing, GrowingTable, iterate_blocks
from verne_post.base.lapack import pbtrf, pbtrs
from verne_post.base.ragged import find_runs
from verne_post.base.rows import measure_rows
from verne_post.base.team import ALONE, Team
from verne_post.model.moves import Moves
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath.compensation import compensate_blends
from verne_post.toolpath.corner_rules import Smoothing, find_corner_rules, limit_fairing
from verne_post.toolpath.corners import find_reversals, find_slopes
from verne_post.toolpath.deviations import NEIGHBOURS
from verne_post.toolpath.straighten import Straightened

#: Vertices of finely divided curves move by at most this share of their tolerance; the rest is for blending corners.
FAIRING_SHARE: Final = 0.35
#: Waves shorter than so many points are taken out.
POINTS: Final = 12.0
#: A stretch has at least so many vertices that may move.
SHORTEST: Final = 8
#: A vertex where the tip turns by more than this (rad) is a feature of the part.
FEATURE: Final = np.radians(15.0)
#: A segment so many times longer than the median of its stretch does not divide a curve finely.
LONG_SEGMENT: Final = 4.0
#: So many vertices of a stretch are faired at a time, and so many more on both sides. Over those the effect of the held
#: end decays, by a factor of e in three vertices.
LONGEST: Final = 1 << 15
OVERLAP: Final = 256
#: Vertices become features in so many rounds at most. A stretch of which more than this share is held is left as it is.
ROUNDS: Final = 8
MOSTLY_HELD: Final = 0.5


def fair_path(
    path: ToolPath, left: Straightened, s: Array, moves: Moves, smoothing: Smoothing, team: Team = ALONE
) -> tuple[ToolPath, Mask]:
    """Move the vertices of finely divided feed moves; returns also which are compensated (n + 1,).

    Parameters
    ----------
    left : Straightened
        How far segments are from programmed curves.
    s : ndarray, shape (n + 1,)
        Metric length at the corners, mm.
    moves : Moves
        For the G61 and G64 in force.
    """
    n = len(path)
    vertex, table = Growing(float, 5), GrowingTable(soft=(bool,), free=(bool,), tip=(float,), axis=(float,))
    vertex.extend(path.start[:1])
    for begin, end in iterate_blocks(n):
        vertex.extend(path.end[begin:end])
        first, last = max(begin - NEIGHBOURS, 0), min(end + NEIGHBOURS, n)
        part, rules = path.take_part(first, last), find_corner_rules(path, left.swing, first, last, moves, smoothing)
        reversal = find_reversals(find_slopes(part.start, part.end, part.length))
        soft = rules.allowed_corners & rules.straight & ~rules.smooth & ~reversal
        # a segment that continues in another, or ends at a curve, keeps its direction, which was matched as programmed
        kept = rules.smooth | rules.curved_corners
        soft[1:-1] &= ~(kept[2:] | kept[:-2])
        whole = FAIRING_SHARE * rules.tip_tolerance
        tip = limit_fairing(part, moves, whole)
        fed = part.feed_time > 0
        soft[1:-1] &= fed[1:] & fed[:-1]
        soft &= (tip > 0) & ~find_features(np.concatenate([part.start[:1], part.end]), s[first : last + 1])
        mine = slice(begin - first, end - first + (end == n))
        table.extend(
            soft=soft[mine],
            free=(soft & (tip == whole))[mine],
            tip=tip[mine],
            axis=FAIRING_SHARE * rules.axis_tolerance[mine],
        )
    columns = table.freeze()
    programmed = vertex.freeze()
    moved = fair_vertices(programmed, s, columns["soft"], columns["tip"], columns["axis"], team)
    bounds = columns["tip"] / FAIRING_SHARE, columns["axis"] / FAIRING_SHARE
    moved, chain = compensate_blends(programmed, moved, s, columns["free"], left.chords, *bounds, team)
    ends = GrowingTable(start=(float, 5), end=(float, 5))
    for begin, end in iterate_blocks(n):
        soft = columns["soft"][begin : end + 1, None]
        ends.extend(
            start=np.where(soft[:-1], moved[begin:end], path.start[begin:end]),
            end=np.where(soft[1:], moved[begin + 1 : end + 1], path.end[begin:end]),
        )
    return replace(path, **ends.freeze()), chain


def fair_vertices(
    vertex: Array, s: Array, soft: Mask, tip_bound: Array, axis_bound: Array, team: Team = ALONE
) -> Array:
    """Move vertices (n + 1, 5) within bounds.

    Parameters
    ----------
    vertex : ndarray, shape (n + 1, 5)
        Tip (mm) and nominal angles (rad) at the corners of a path.
    s : ndarray, shape (n + 1,)
        Metric length at the corners, mm.
    soft : ndarray of bool, shape (n + 1,)
        Corners between straight feed moves that may be blended, and are no features (:func:`find_features`).
    tip_bound, axis_bound : ndarray, shape (n + 1,)
        How far each may move, mm and rad; above 0 where it is soft.
    """

    def fair_part(part: tuple[int, int, int, int]) -> tuple[int, Array]:
        first, last, begin, end = part
        rows = slice(first, last)
        faired = _fair_stretch(vertex[rows], s[rows], tip_bound[rows], axis_bound[rows])
        return begin, faired[begin - first : end - first]

    moved = Growing(float, 5)
    for begin, faired in team.map(fair_part, _find_stretches(soft)):
        moved.copy(vertex[moved.count : begin])
        moved.extend(faired)
    moved.copy(vertex[moved.count :])
    return moved.freeze()


def _find_stretches(soft: Mask) -> Iterator[tuple[int, int, int, int]]:
    """Find stretches of soft vertices and their held ends: (first, last + 1, first and last + 1 to keep).

    A long one is faired in parts. Each has vertices on both sides whose result is not used.
    """
    starts, ends = find_runs(soft)
    for first, last in zip(starts.tolist(), ends.tolist(), strict=True):
        if last - first < SHORTEST:
            continue
        for begin in range(first, last, LONGEST):
            end = min(begin + LONGEST, last)
            yield max(begin - OVERLAP, first) - 1, min(end + OVERLAP, last) + 1, begin, end


def find_features(vertex: Array, s: Array) -> Mask:
    """Find vertices that are sharp corners of the part, or stand beside a segment far longer than its neighbour."""
    feature = np.zeros(len(s), dtype=bool)
    delta = np.diff(vertex[:, :3], axis=0)
    size = measure_rows(delta)
    cosine = np.sum(delta[1:] * delta[:-1], axis=1)
    sine = measure_rows(np.cross(delta[1:], delta[:-1]))
    feature[1:-1] = (np.arctan2(sine, cosine) > FEATURE) & (size[1:] > 0) & (size[:-1] > 0)
    length = np.diff(s)
    longer = np.maximum(length[1:], length[:-1]) > LONG_SEGMENT * np.minimum(length[1:], length[:-1])
    feature[1:-1] |= longer
    return feature


def _fair_stretch(vertex: Array, s: Array, tip_bound: Array, axis_bound: Array) -> Array:
    """Fair one stretch, its ends held. Vertices that would have to move too far are features, and are held as well."""
    held = np.zeros(len(s), dtype=bool)
    held[[0, -1]] = True
    # a cubic smoothing spline passes waves of length L by 1 / (1 + lam h (2 pi / L)^4)
    spacing = float(np.median(np.diff(s)))
    lam = (POINTS / (2 * np.pi)) ** 4 * spacing**3
    for _ in range(ROUNDS):
        change = _smooth(vertex, s, held, lam)
        soft = np.flatnonzero(~held)
        ratio = np.maximum(
            measure_rows(change[soft, :3]) / tip_bound[soft], measure_rows(change[soft, 3:]) / axis_bound[soft]
        )
        far = soft[ratio > 1.0]
        if not len(far):
            return np.asarray(vertex + change)
        held[far] = True
        if held.mean() > MOSTLY_HELD:
            break
    return vertex


def _smooth(values: Array, s: Array, held: Mask, lam: float) -> Array:
    """Changes (n, k) that a cubic smoothing spline makes to values (n, k) at s (n,); those ``held`` (n,) do not change.

    The spline minimises the sum of squared changes plus ``lam`` times its squared bending (Reinsch 1967). Let D be the
    second differences over uneven steps, G the Gram matrix of the hat functions that second derivatives consist of, and
    M 1 where a value may move. The second derivatives are ``g = (G + lam D M D^T)^-1 D y``, the change is ``-lam M D^T
    g``. scipy's smoothing spline makes a basis point by point, which takes 20 times as long.
    """
    h = np.diff(s)
    steps = np.stack([1.0 / h[:-1], -1.0 / h[:-1] - 1.0 / h[1:], 1.0 / h[1:]])  # D, row i over values i to i + 2
    weight = np.where(held, 0.0, lam)
    n = len(s) - 2
    band = np.zeros((3, n))  # the lower triangle, diagonal first
    band[0] = (h[:-1] + h[1:]) / 3 + sum(steps[k] ** 2 * weight[k : k + n] for k in range(3))
    band[1, :-1] = h[1:-1] / 6 + sum(steps[k + 1, :-1] * steps[k, 1:] * weight[k + 1 : k + n] for k in range(2))
    band[2, :-2] = steps[2, :-2] * steps[0, 2:] * weight[2:n]
    bends = sum(steps[k][:, None] * values[k : k + n] for k in range(3))
    factor, info = pbtrf(band, lower=1)
    assert info == 0, "G is positive definite, and what is added to it is no less than 0"
    bends, _info = pbtrs(factor, bends, lower=1)
    change = np.zeros_like(values)
    for k in range(3):
        change[k : k + n] -= steps[k][:, None] * bends
    return change * weight[:, None]
