"""What shows in the rows: between two of them the path must not do what they cannot tell of.

Rows are places at whole control cycles, and nothing else reaches the drives. A circle that is passed within one cycle leaves
no trace in them. So the speed is limited by the cycle too: an arc turns by less than half a turn from one row to the next,
and the path between two rows stays near the straight step between them. With control cycles of a few milliseconds the
limits of the joints are far stricter; with cycles of a tenth of a second and more they are not.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.rows import row_norm
from verne_post.base.tolerances import PATH_AXIS_DEG, PATH_TIP_MM
from verne_post.base.units import RAD_PER_DEG, ROTARY_METRIC_MM
from verne_post.model.contour import Contour
from verne_post.trajectory import tuning

PoseAt = Callable[[Array], tuple[Array, Array]]

#: Or than half of what verification accepts beside a path, mm and rad.
LEAST: Final = 0.5 * np.array([[PATH_TIP_MM], [PATH_AXIS_DEG * RAD_PER_DEG]])

#: A radian of a spline counts as so many of an arc. A spline may turn anywhere between two rows, and by 1.75 rad at most for
#: its length to stay below 1.6 of the step, as that of an arc of half a turn does.
SPLINE_TURN: Final = 1.5
#: At so many places the path between two rows is looked at.
PLACES_BETWEEN: Final = 8


def turn_rate(contour: Contour, element: Ints) -> Array:
    """Rad by which curves turn in a mm of s on elements (n,), splines at the most; 0 on straight segments."""
    path, segment = contour.path, contour.segment[element]
    arc = path.arc[segment]
    result = np.zeros(len(segment))
    curved = np.flatnonzero(arc >= 0)
    result[curved] = np.abs(path.arcs.sweep[arc[curved]]) / path.length[segment[curved]]
    splined = np.flatnonzero(path.spline[segment] >= 0)
    result[splined] = SPLINE_TURN * path.splines.bend[path.spline[segment[splined]]]
    return result


def visible_speed(contour: Contour, element: Ints, cycle: float) -> Array:
    """Largest ds/dt (n,) on elements (n,) at which the rows show how arcs turn, mm/s; infinite on straight segments."""
    with np.errstate(divide="ignore"):
        return np.asarray(tuning.MOST_TURN / (cycle * turn_rate(contour, element)))


def hidden(
    pose: PoseAt, contour: Contour, s: Array, element: Ints, poses: tuple[Array, Array], turned: Array | None
) -> Array:
    """How many times too far steps (n - 1,) are from the path between their ends, or arcs turn; up to 1 is near enough.

    The step before the first is taken to have been as long as need be.

    Parameters
    ----------
    pose : callable
        Tip and angles at places of the section.
    contour : Contour
    s, element : ndarray, shape (n,)
        The rows: places of the section, and the elements that they are on.
    poses : tuple of ndarray
        Tip (n, 3) and angles (n, 2) of the rows.
    turned : ndarray, shape (n,), or None
        How far arcs have turned up to the rows, rad; None where the section has none.
    """
    result = (
        np.zeros(len(s) - 1) if turned is None else np.diff(turned) / (tuning.ACCEPTED_RATIOS[0] * tuning.MOST_TURN)
    )
    way = np.diff(s)
    rows = np.flatnonzero((element[1:] != element[:-1]) & (way > PATH_TIP_MM))
    if not len(rows):
        return result
    tip, angles = poses
    size = np.stack([row_norm(np.diff(tip, axis=0)), row_norm(np.diff(angles, axis=0))])
    bound = tuning.BULGE * np.maximum(size, np.append(np.full((2, 1), np.inf), size[:, :-1], axis=1)) + LEAST
    # a path of this length is nowhere farther than this from its chord; not so where s is not the length
    shape, segment = contour.shape, contour.segment[element]
    curved = (shape.arc[segment] >= 0) | (shape.spline[segment] >= 0)
    even = (shape.circle[segment] < 0) & ~(contour.blended[element] & curved)
    most = 0.5 * np.sqrt(np.maximum(way**2 - size[0] ** 2 - (ROTARY_METRIC_MM * size[1]) ** 2, 0.0))
    # within this of both bounds, the root of the sum of their squares is within 1
    surely = even[1:] & even[:-1] & (most < np.sqrt(0.5) * np.minimum(bound[0], ROTARY_METRIC_MM * bound[1]))
    rows = rows[~surely[rows]]
    places = np.arange(1, PLACES_BETWEEN + 1) / (PLACES_BETWEEN + 1.0)
    for first in range(0, len(rows), tuning.AT_A_TIME):
        some = rows[first : first + tuning.AT_A_TIME]
        here = np.concatenate([tip[some], angles[some]], axis=1)
        step = np.concatenate([tip[some + 1], angles[some + 1]], axis=1) - here
        between = np.concatenate(pose((s[some] + places[:, None] * way[some]).ravel()), axis=1)
        off = between.reshape(len(places), len(some), 5) - here
        scale = 1.0 / np.repeat(bound[:, some].T, (3, 2), axis=1)
        off, step = off * scale, step * scale
        share = np.sum(off * step, axis=2) / np.maximum(np.sum(step * step, axis=1), np.finfo(float).tiny)
        off -= np.clip(share, 0.0, 1.0)[:, :, None] * step
        result[some] = np.maximum(result[some], np.sqrt(np.max(np.sum(off * off, axis=2), axis=0)))
    return result
