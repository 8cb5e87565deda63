"""What corner blends of straight segments use of the tolerance, and how far they are narrowed to stay inside it.

The distance from the path counts, not that from the corner: the part of a displacement along a segment only means that
another pose of the segment is the nearest one. A segment that stands for an arc is off it itself.
"""

from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rows import measure_rows, sum_rows
from verne_post.model.contour import Corners
from verne_post.toolpath.corner_shapes import OUTSIDE
from verne_post.toolpath.corners import SEGMENTS, USED_SHARE, find_displacement

#: Overlapping blends that leave the tolerance together are narrowed by at most this factor at a time, and so often.
NARROWING: Final = 0.6
NARROWINGS: Final = 12
#: Places besides the middle where segments near wide shapes, and chords of arcs, are looked at: lobes of two blends, or
#: a blend and an arc's height, add up anywhere.
_PLACES: Final = (0.1, 0.2, 0.3, 0.4, 0.6, 0.7, 0.8, 0.9)
#: The contour beside a segment depends on no more than so many segments on each side: on those that a corner blend
#: reaches, and on as many again in each round of narrowing.
NEIGHBOURS: Final = (NARROWINGS + 4) * (2 * SEGMENTS + 1)


class Chords(Struct, frozen=True):
    """How far n straight segments are from the arcs for which they stand."""

    sag: Array  #: (n, 3): From the middle of the arc to that of its chord, mm; 0 for segments that stand for none.
    cosine: Array  #: (n,): Of half the angle of the arc, which is below pi; 1 for segments that stand for none.

    def take(self, segment: Ints | slice) -> "Chords":
        """Those of some segments."""
        return Chords(self.sag[segment], self.cosine[segment])

    def measure_height(self, part: Array) -> Array:
        """From the arcs to the segments (n, 3), mm, at shares ``part`` (n,) of their chords."""
        from_middle = (2.0 * part - 1.0) ** 2
        root = np.sqrt(1.0 - (1.0 - self.cosine**2) * from_middle)
        share = (1.0 - from_middle) * (1.0 + self.cosine) / (root + self.cosine)
        return np.asarray(share[:, None] * self.sag)


def find_share_used(
    off: Array,
    slope: Array,
    ends: tuple[Array, Array],
    tip_tolerance: Array,
    axis_tolerance: Array,
    chords: Chords | None = None,
) -> Array:
    """Share of the tolerance (n,) that displacements use; 0 where there is neither displacement nor tolerance.

    A displaced pose is near the pose with its s; where the table stands still, near the pose whose tip is nearest. The
    programmed pose itself must stay near either: it stays within root 2 of both tolerances together, which cuts the
    tips of corners of more than 90 degrees less than they would allow.

    Parameters
    ----------
    off : ndarray, shape (n, 5)
        Displacement of poses on a straight segment, mm and rad.
    slope : ndarray, shape (n, 5)
        Derivative of the segment by s.
    ends : tuple of ndarray, shape (n,)
        From the poses to both ends of their segment, mm: the nearest pose lies between.
    tip_tolerance, axis_tolerance : ndarray, shape (n,)
        mm and rad.
    chords : Chords, optional
        How far the segments are from what was programmed.
    """
    square = np.where(slope[:, 3:].any(axis=1), 0.0, sum_rows(slope[:, :3] ** 2))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        along = np.where(square > 0, sum_rows(off[:, :3] * slope[:, :3]) / square, 0.0).clip(*ends)
        same, nearest = (
            (
                measure_rows(away[:, :3] + _find_heights(chords, ends, by)) / tip_tolerance,
                measure_rows(away[:, 3:]) / axis_tolerance,
            )
            for by, away in ((0.0, off), (along, off - along[:, None] * slope))
        )
        used = np.fmax(np.fmin(np.fmax(*same), np.fmax(*nearest)), np.hypot(*np.nan_to_num(same)) / np.sqrt(2.0))
    return np.where(np.isfinite(used), used, 0.0)


def _find_heights(chords: Chords | None, ends: tuple[Array, Array], along: Array | float) -> Array | float:
    """From arcs to their chords (n, 3), mm, ``along`` (n,) mm beyond poses that are ``ends`` from the ends."""
    return 0.0 if chords is None else chords.measure_height((along - ends[0]) / (ends[1] - ends[0]))


def find_bend_shares(bend: Array, slope: Array, tip_tolerance: Array, axis_tolerance: Array) -> Array:
    """Share of the tolerance (n + 1,) that a displacement by ``bend`` times 1 mm uses, on the worse segment."""
    zero, far = np.zeros(len(bend)), np.full(len(bend), np.inf)
    before = find_share_used(bend, np.concatenate([slope[:1], slope]), (-far, zero), tip_tolerance, axis_tolerance)
    after = find_share_used(bend, np.concatenate([slope, slope[-1:]]), (zero, far), tip_tolerance, axis_tolerance)
    return np.maximum(before, after)


def find_deviations(
    corners: Corners, slope: Array, shift: Array, chords: Chords, tip_tolerance: Array, axis_tolerance: Array
) -> Array:
    """The largest share of the tolerance (n + 1,) that the contour uses anywhere where the blend of a corner reaches.

    It is measured at corners and at the middle of segments; near wide shapes and on chords of arcs also at places in
    between, and where each wide shape swings out.

    Parameters
    ----------
    slope : ndarray, shape (n, 5)
        Derivative of the segments by s.
    shift : ndarray, shape (n + 1, 5)
        How far vertices have been moved before.
    chords : Chords
        How far the segments are from what was programmed.
    tip_tolerance, axis_tolerance : ndarray, shape (n + 1,)
        The tolerance of a point between two corners is the smaller of theirs.
    """
    s, reach = corners.s, corners.reach
    n = len(s) - 1
    wide = np.flatnonzero((corners.shape > 0) & (reach > 0))
    near_wide = np.zeros(n + 2 * SEGMENTS, dtype=bool)
    for step in range(2 * SEGMENTS):
        near_wide[wide + step] = True
    bent = chords.sag.any(axis=1)
    looked = np.flatnonzero(near_wide[SEGMENTS:-SEGMENTS] | bent)
    between = np.concatenate([np.arange(n), np.repeat(looked, len(_PLACES))])
    share = np.concatenate([np.full(n, 0.5), np.tile(_PLACES, len(looked))])
    outside = OUTSIDE[corners.shape[wide]] * reach[wide]
    swings = np.concatenate([s[wide] - outside, s[wide] + outside])
    on = np.clip(np.searchsorted(s, swings, side="right") - 1, 0, n - 1)
    inner = np.concatenate([between, on])
    inner_at = np.concatenate([s[between] + share * (s[between + 1] - s[between]), swings])
    every = np.arange(n + 1)
    largest = np.zeros(n + 1)
    at_corners = find_displacement(corners, np.minimum(every, n - 1), s)
    for at, off, owner, low, high in (
        (s, at_corners, np.append(0, every[:-1]), every, every),
        (s, at_corners, np.append(every[:-1], n - 1), every, every),
        (inner_at, find_displacement(corners, inner, inner_at), inner, inner, inner + 1),
    ):
        ends = s[owner] - at, s[owner + 1] - at
        part = (-ends[0] / (ends[1] - ends[0]))[:, None]
        away = off + shift[owner] + part * (shift[owner + 1] - shift[owner])
        tip, axis = (np.minimum(bound[low], bound[high]) for bound in (tip_tolerance, axis_tolerance))
        used = find_share_used(away, slope[owner], ends, tip, axis, chords.take(owner) if bent.any() else None)
        for step in range(-SEGMENTS, SEGMENTS + 2):
            near = np.clip(owner + step, 0, n)
            covers = np.abs(at - s[near]) < reach[near]
            np.maximum.at(largest, near[covers], used[covers])
    return largest


def narrow_blends(
    corners: Corners,
    kept: Mask,
    slope: Array,
    shift: Array,
    chords: Chords,
    tip_tolerance: Array,
    axis_tolerance: Array,
) -> Array:
    """Reaches (n + 1,) of overlapping corner blends, narrowed until their sum stays within the tolerance.

    Parameters are those of :func:`find_deviations`; the reaches of corners ``kept`` (n + 1,) stay as they are.
    """
    reach = corners.reach.copy()
    for _ in range(NARROWINGS):
        corners = replace(corners, reach=reach)
        worst = find_deviations(corners, slope, shift, chords, tip_tolerance, axis_tolerance) / USED_SHARE
        beyond = (worst > 1.0) & ~kept
        if not beyond.any():
            return reach
        reach[beyond] *= np.maximum(1.0 / worst[beyond], NARROWING)
    return reach
