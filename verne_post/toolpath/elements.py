"""Elements: parts of segments on which the contour is one smooth function."""

from typing import Any, Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import USED_UP_SHARE, ZERO_LENGTH_MM
from verne_post.base.units import ROTARY_METRIC_MM
from verne_post.model.contour import Corners, Feeds
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.toolpath.corners import find_breakpoints

#: An element shorter than this share of the corner blends that bound it is given to its neighbour: only there does the
#: contour bend so little on it that it is smooth across both. A share of the segment instead would hide narrow blends
#: on long segments. The grid of planning would then take a corner and the way after it for one smooth function, and the
#: profile would slow down a second time at its next point.
MIN_SHARE: Final = 1e-3


def split_into_elements(path: ToolPath, corners: Corners) -> dict[str, Any]:
    """Split segments (n,) at the breakpoints of their corner blends.

    Returns columns ``segment``, ``low``, ``high`` and ``length`` of a Contour, in order.
    """
    n = len(path)
    inner, at, width = find_breakpoints(corners)
    u = (at - corners.s[inner]) / path.length[inner]
    least = MIN_SHARE * width / path.length[inner]
    inside = (u > least) & (u < 1.0 - least)
    inner, u, least = inner[inside], u[inside], least[inside]
    # begin of every element: the start of its segment, then the breakpoints; one that is too short joins the one before
    segment = np.concatenate([np.arange(n), inner])
    low, least = np.concatenate([np.zeros(n), u]), np.concatenate([np.zeros(n), least])
    order = np.lexsort((low, segment))
    segment, low, least = segment[order], low[order], least[order]
    near = np.append(False, (segment[1:] == segment[:-1]) & (np.diff(low) < np.minimum(least[1:], least[:-1])))
    segment, low = segment[~near], low[~near]
    last = np.append(segment[1:] != segment[:-1], True)
    high = np.where(last, 1.0, np.append(low[1:], 1.0))
    kept = high - low > USED_UP_SHARE
    segment, low, high = segment[kept], low[kept], high[kept]
    return {
        "segment": segment.astype(np.int32),
        "low": low,
        "high": high,
        "length": (high - low) * path.length[segment],
    }


def measure_rotation(path: ToolPath) -> Array:
    """Rotation (n,) of each segment: table angles, and the direction of arcs, splines and turns, rad."""
    turn = np.abs(path.end[:, 3:] - path.start[:, 3:]).sum(axis=1)
    curved = path.arc >= 0
    turn[curved] += np.abs(path.arcs.sweep[path.arc[curved]])
    splined = path.spline >= 0
    turn[splined] = path.splines.turn[path.spline[splined]]
    turn[path.turn >= 0] *= 2.0  # the tip goes round with the table
    joint = path.kind == SegmentKind.JOINT
    if joint.any():
        ends = path.joints[path.joint[joint]]
        turn[joint] = np.abs(ends[:, 1, -2:] - ends[:, 0, -2:]).sum(axis=1)
    return turn


def find_feeds(path: ToolPath) -> Feeds:
    """The feed rate of the tip along lines, arcs and splines; elsewhere it is a time."""
    delta = path.end - path.start
    turn = measure_rows(delta[:, 3:])
    tip = measure_rows(delta[:, :3])
    arc = path.arc >= 0
    tip[arc] = np.sqrt(np.maximum(path.length[arc] ** 2 - (ROTARY_METRIC_MM * turn[arc]) ** 2, 0.0))
    tip[path.spline >= 0] = path.length[path.spline >= 0]
    fed = path.feed_time > 0
    seconds = np.where(fed, path.feed_time, 1.0)
    rate = np.where(fed, np.where(tip > ZERO_LENGTH_MM, tip, 0.0) / seconds, np.inf)
    return Feeds(rate, ~path.timed, np.where(fed, path.length / seconds, np.inf))
