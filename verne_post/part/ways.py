"""Straight ways that a tool has cut, and whether it follows them: there it is as clear as while it cut."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.part.clearance import TOUCH_MM

#: Rounding of shares of a way.
SHARE_SLACK: Final = 1e-9


def find_ways(past: Array, tip: Array, axis: Array, reach: float) -> tuple[Array, Array]:
    """Tips and axes (n, 2, 3) of the ways that a stretch of a span may lie on, or along its axis above them.

    ``past`` (2, 2, 3, n): tips and axes of the spans cut before, in columns because they are many.
    """
    tips, axes = past
    turned = np.abs(axes - axis[0][:, None]).max(axis=(0, 1)) - np.abs(axis[1] - axis[0]).max()
    near = 2.0 * reach * turned <= 0.5 * TOUCH_MM
    if (axis[0] == axis[1]).all():
        if not near.all():
            tips, axes = tips[..., near], axes[..., near]
        beside = np.linalg.svd(axis[:1])[2][1:]  # two directions across the axis
        past_ends, ends = beside @ tips, beside @ tip.T
        low, high = past_ends.min(axis=0) - TOUCH_MM, past_ends.max(axis=0) + TOUCH_MM
        near = ((low <= ends.max(axis=1)[:, None]) & (high >= ends.min(axis=1)[:, None])).all(axis=0)
    return tips[..., near].transpose(2, 0, 1), axes[..., near].transpose(2, 0, 1)


def list_columns(tip: Array, axis: Array) -> Array:
    """Spans (n, 2, 3), (n, 2, 3) as columns (tip and axis, 2, 3, n)."""
    return np.stack([tip, axis]).transpose(0, 2, 3, 1)


def follows_ways(part: tuple[Array, Array], ways: tuple[Array, Array], reach: float, lifts: bool) -> bool:
    """Whether a straight stretch lies on straight ways of the same tool, or with ``lifts`` along its axis above them.

    The distance from what lies above a straight way is convex along the stretch: all places between near ones are near.
    """
    (start, end), (axis, last_axis) = part
    tips, axes = ways
    turned = np.abs(axes - axis).max(axis=(1, 2)) + np.abs(last_axis - axis).max()
    same = 2.0 * reach * turned <= 0.5 * TOUCH_MM
    tips, along = tips[same], end - start
    way, intervals = tips[:, 1] - tips[:, 0], []
    across = along - (along @ axis) * axis
    for direction in (along, across):
        square = float(direction @ direction)
        if square > 0:
            share = np.clip((tips - start) @ direction / square, 0.0, 1.0)
        else:
            share = np.tile([0.0, 1.0], (len(tips), 1))
        off = start + share[..., None] * along - tips[:, :1]
        apart = _measure_from_way(off, way, None)
        if lifts:
            apart = np.minimum(apart, _measure_from_way(off, way, axis))
        intervals.append(np.sort(share[apart.max(axis=1) <= 0.5 * TOUCH_MM], axis=1))
    covered = 0.0
    for low, high in sorted(np.concatenate(intervals).tolist()):
        if low > covered + SHARE_SLACK:
            break
        covered = max(covered, high)
    return covered >= 1.0 - SHARE_SLACK


def _measure_from_way(off: Array, way: Array, axis: Array | None) -> Array:
    """Distance of points (n, 2, 3) from ways (n, 3), seen from their begin; above a way, only across ``axis``."""
    height = np.zeros(off.shape[:2])
    rise = np.zeros(len(way))
    if axis is not None:
        height, rise = off @ axis, way @ axis
        off, way = off - height[..., None] * axis, way - rise[:, None] * axis
    long = (way * way).sum(1)[:, None]
    share = np.clip((off * way[:, None]).sum(-1) / np.where(long > 0, long, 1.0), 0.0, 1.0)
    if axis is not None:  # the parts of the way that are not above the point
        steep = np.abs(rise)[:, None] > SHARE_SLACK
        meets = np.clip(height / np.where(steep, rise[:, None], 1.0), 0.0, 1.0)
        share = np.where(
            steep & (rise[:, None] > 0), np.minimum(share, meets), np.where(steep, np.maximum(share, meets), share)
        )
        height = np.minimum(height - share * rise[:, None], 0.0)
    return np.hypot(np.linalg.norm(off - share[..., None] * way[:, None], axis=-1), height)
