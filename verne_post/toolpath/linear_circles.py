"""Great circles that are followed linearly in A and C: short steps between tool vectors, within their axis tolerance.

CAM systems cut the swing of a tool axis into steps of a degree or so. Along such a step the great circle from axis to axis is
all but linear in A and C. Followed linearly, the step is a straight segment: it is faired, its corners are blended with those
around, as if it had been programmed with A and C words. What the contour is off the great circle by that, the corners beside
it do not use. The programmed path keeps its great circles, and verification measures from them.
"""

from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints
from verne_post.base.columns import Growing, blocks
from verne_post.base.rotations import axis_of_angles
from verne_post.base.rows import row_norm
from verne_post.model.moves import Moves
from verne_post.model.toolpath import ToolPath
from verne_post.toolpath.corner_rules import Smoothing, find_segment_tolerances
from verne_post.toolpath.evaluate import circle_axis

#: Share of the axis tolerance that following a great circle linearly may use. The corners have the rest. Over 600 random programs
#: with coarse steps the time is 0.909 of that between great circles with a quarter, 0.897 with half; single programs lose 3 %.
CIRCLE_SHARE: Final = 0.5
#: Where the distance between great circle and linear A and C is measured, as shares of a step. It is largest near the middle, and
#: between these places by 2 % at most of what it is at them: less than corners leave of the tolerance.
_PLACES: Final = (1 / 8, 2 / 8, 3 / 8, 4 / 8, 5 / 8, 6 / 8, 7 / 8)


def straighten_circles(path: ToolPath, moves: Moves, smoothing: Smoothing) -> tuple[ToolPath, Array]:
    """Take great circles that are nearly linear in A and C for straight segments, where G64 holds and the tip moves.

    Returns
    -------
    path : ToolPath
        With fewer great circles.
    off : ndarray, shape (n,)
        How far each of its segments is from the programmed great circle, rad; 0 for the others.
    """
    if not len(path.circles.angle):
        return path, np.broadcast_to(0.0, len(path))
    circle, off = Growing(np.int32), Growing(float)
    for begin, end in blocks(len(path)):
        part = path.part(begin, end)
        tip, axis = find_segment_tolerances(part, moves, smoothing)
        which = np.flatnonzero((part.circle >= 0) & (tip > 0) & (part.start[:, :3] != part.end[:, :3]).any(axis=1))
        away = np.zeros(len(part))
        away[which] = _measure_from_linear(part, which)
        followed = away > CIRCLE_SHARE * smoothing.share * axis
        away[followed] = 0.0
        linear = np.zeros(len(part), dtype=bool)
        linear[which] = ~followed[which]
        circle.extend(np.where(linear, -1, part.circle))
        off.extend(away)
    return replace(path, circle=circle.column()), off.column()


def _measure_from_linear(path: ToolPath, segment: Ints) -> Array:
    """Largest angle between the tool axes (m,) of great circles and of linear A and C on segments (m,), rad."""
    start, end = path.start[segment, 3:], path.end[segment, 3:]
    off = np.zeros(len(segment))
    for share in _PLACES:
        axis = circle_axis(path, segment, np.full(len(segment), share))
        angles = start + share * (end - start)
        off = np.maximum(off, row_norm(axis - axis_of_angles(angles[:, 0], angles[:, 1])))
    return off
