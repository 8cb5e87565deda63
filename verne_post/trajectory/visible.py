"""What shows in the rows: between two of them the path must not do what they cannot tell of.

Rows are places at whole control cycles, and nothing else reaches the drives. A circle that is passed within one cycle
leaves no trace in them. So the cycle limits the speed too: an arc turns by less than half a turn from one row to the
next, and the path between two rows stays near the straight step between them. With control cycles of a few milliseconds
the limits of the joints are far stricter; with cycles of a tenth of a second and more they are not.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.columns import Growing, iterate_blocks, sum_running
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import PATH_AXIS_DEG, PATH_TIP_MM
from verne_post.base.units import RAD_PER_DEG, ROTARY_METRIC_MM
from verne_post.model.contour import Contour
from verne_post.trajectory import tuning

PoseAt = Callable[[Array], tuple[Array, Array]]

#: Or than half of what verification accepts beside a path, mm and rad.
LEAST: Final = 0.5 * np.array([[PATH_TIP_MM], [PATH_AXIS_DEG * RAD_PER_DEG]])

#: A radian of a spline counts as so many of an arc. A spline may turn anywhere between two rows, and by 1.75 rad at
#: most for its length to stay below 1.6 of the step, as that of an arc of half a turn does.
SPLINE_TURN: Final = 1.5
#: The way over which a spline may turn without limit, since verification looks no closer than PATH_TIP_MM: a narrower
#: bend need not slow the whole spline down.
SHORT_WAY: Final = 0.9 * PATH_TIP_MM
#: At so many places the path between two rows is looked at.
PLACES_BETWEEN: Final = 8


class Turning:
    """How far curves turn along some elements of a contour, splines by the curvature of each of their parts.

    Parameters
    ----------
    contour : Contour
    first, last : int
        Elements, ``last`` excluded.
    """

    def __init__(self, contour: Contour, first: int, last: int) -> None:
        self.contour, self.first = contour, first
        path, splines = contour.path, contour.path.splines
        mine = path.spline[contour.segment[first:last]] if len(splines) else np.empty(0, dtype=np.int32)
        mine = mine[mine >= 0]
        parts = np.append(splines.first_part, len(splines.low))[[mine[0], mine[-1] + 1]] if len(mine) else [0, 0]
        self._first_part = int(parts[0])
        over_parts, over_elements = Growing(float), Growing(float)
        for begin, end in iterate_blocks(int(parts[1]), self._first_part):
            part = np.arange(begin, end)
            piece = np.searchsorted(splines.first_part, part, side="right") - 1
            over_parts.extend(
                _find_spline_rate(contour, part) * (splines.high - splines.low)[begin:end] * splines.length[piece]
            )
        self._before = sum_running(over_parts.freeze())
        for begin, end in iterate_blocks(last, first):
            element = np.arange(begin, end)
            segment = contour.segment[element]
            over_elements.extend(
                self._measure_on(segment, contour.high[element]) - self._measure_on(segment, contour.low[element])
            )
        self._over = sum_running(over_elements.freeze())

    def measure_turn(self, element: Ints, w: Array) -> Array:
        """Rad from the beginning of the elements up to w (n,) of elements (n,)."""
        segment, low = self.contour.segment[element], self.contour.low[element]
        turned = self._measure_on(segment, self.contour.find_parameters(element, w)) - self._measure_on(segment, low)
        return np.asarray(self._over[element - self.first] + turned)

    def _measure_on(self, segment: Ints, u: Array) -> Array:
        """Rad from the beginning of segments (n,) up to u (n,)."""
        path, splines = self.contour.path, self.contour.path.splines
        turned = np.zeros(len(segment))
        arc = np.flatnonzero(path.arc[segment] >= 0)
        turned[arc] = u[arc] * np.abs(path.arcs.sweep[path.arc[segment[arc]]])
        carried = np.flatnonzero(path.turn[segment] >= 0)
        turned[carried] = u[carried] * _measure_table_turn(self.contour, segment[carried])
        spline = np.flatnonzero(path.spline[segment] >= 0)
        if len(spline):
            piece = path.spline[segment[spline]]
            part = splines.find_parts(piece, u[spline])
            before = self._before[part - self._first_part] - self._before[splines.first_part[piece] - self._first_part]
            way = (u[spline] - splines.low[part]) * splines.length[piece]
            turned[spline] = before + _find_spline_rate(self.contour, part) * way
        return turned


def _measure_table_turn(contour: Contour, segment: Ints) -> Array:
    """Rad by which the table turns along segments (n,), both axes together; the tip turns with it by no more."""
    path = contour.path
    return np.asarray(np.abs(path.end[segment, 3:] - path.start[segment, 3:]).sum(axis=1))


def _find_spline_rate(contour: Contour, part: Ints) -> Array:
    """Rad by which parts (n,) of splines count in a mm."""
    return np.minimum(SPLINE_TURN * contour.path.splines.bend[part], tuning.MOST_TURN / SHORT_WAY)


def limit_visible_speed(contour: Contour, element: Ints, w: Array, cycle: float) -> Array:
    """Largest ds/dt (n,), mm/s, at w (n,) of elements (n,) for rows to show how curves turn; infinite on lines."""
    path, segment = contour.path, contour.segment[element]
    rate = np.zeros(len(segment))
    arc = path.arc[segment]
    curved = np.flatnonzero(arc >= 0)
    rate[curved] = np.abs(path.arcs.sweep[arc[curved]]) / path.length[segment[curved]]
    carried = np.flatnonzero(path.turn[segment] >= 0)
    rate[carried] = _measure_table_turn(contour, segment[carried]) / path.length[segment[carried]]
    splined = np.flatnonzero(path.spline[segment] >= 0)
    if len(splined):
        u = contour.find_parameters(element[splined], w[splined])
        rate[splined] = _find_spline_rate(contour, path.splines.find_parts(path.spline[segment[splined]], u))
    with np.errstate(divide="ignore"):
        return np.asarray(tuning.MOST_TURN / (cycle * rate))


def measure_hidden(
    pose: PoseAt, contour: Contour, s: Array, element: Ints, poses: tuple[Array, Array], turned: Array | None
) -> Array:
    """How many times too far steps (n - 1,) are from the path between their ends, or arcs turn; up to 1 is near enough.

    The step before the first is taken to have been as long as need be.

    Parameters
    ----------
    pose : callable
        Tip and angles at places of the section.
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
    size = np.stack([measure_rows(np.diff(tip, axis=0)), measure_rows(np.diff(angles, axis=0))])
    bound = tuning.BULGE * np.maximum(size, np.append(np.full((2, 1), np.inf), size[:, :-1], axis=1)) + LEAST
    # a path of this length is nowhere farther than this from its chord; not so where s is not the length
    shape, segment = contour.shape, contour.segment[element]
    curved = (shape.arc[segment] >= 0) | (shape.spline[segment] >= 0) | (shape.turn[segment] >= 0)
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
