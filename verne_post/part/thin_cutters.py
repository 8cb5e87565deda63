"""Cutters without a diameter, which are thin lines in a stock: what they may have cut, and how wide they can be.

What such a cutter may have cut is no contact of one that comes after it. It leaves what is below the plane across its
axis through its tip, and what is far from its axis.
"""

import math
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.part.clearance import TOUCH_MM

#: Farther than this, mm, from its axis a cutter of unknown diameter has cut nothing: shell mills for spindles of taper
#: 40 end at 160 mm (ISO 6462: larger ones are screwed to the nose of a spindle of taper 50), most drills at 50 mm.
LINE_RADIUS_MM: Final = 80.0
DRILL_RADIUS_MM: Final = 25.0
#: Nor higher above its tip.
LINE_HEIGHT_MM: Final = 100.0


class ThinCuts:
    """Spans along which cutters that are thin lines have cut, and the largest radius of each of them."""

    def __init__(self) -> None:
        #: Tips and the first axis (n, 3, 3) of spans, and how wide (n,) the cutter is at most; in parts.
        self._parts: list[tuple[Array, Array]] = []
        self.first_span: float = np.inf  #: The first of them.
        self._radius: dict[int, float] = {}  #: By tool, mm.
        #: By line how far all of them are from a certain contact, mm.
        self.gaps: dict[int, float] = {}

    def __bool__(self) -> bool:
        return bool(self._parts)

    def get_radius(self, tool: int) -> float:
        """How wide a cutter is at most, mm."""
        return self._radius.get(tool, LINE_RADIUS_MM)

    def set_radius(self, tool: int, radius: float) -> None:
        """A wider cutter would have met the stock in a rapid."""
        self._radius[tool] = radius

    def add(self, tool: int, rows: Ints, tip: Array, axis: Array) -> None:
        """Note spans (n,) with tips and axes (n, 2, 3) of a tool."""
        self.first_span = min(self.first_span, int(rows[0]))
        radius = self.get_radius(tool)
        across = np.linalg.norm(np.cross(np.diff(tip, axis=1)[:, 0], axis[:, 0]), axis=1)
        widths = np.where(across > TOUCH_MM, radius, min(radius, DRILL_RADIUS_MM))
        self._parts.append((np.concatenate([tip, axis[:, :1]], axis=1), widths))

    def may_have_cut(self, point: Array, line: int, below: float) -> bool:
        """Whether all points (n, 3) may be cut, up to ``below`` a tip, mm. If not, the gap of the line is noted."""
        cuts, widths = (np.concatenate(one) for one in zip(*self._parts, strict=True))
        self._parts[:] = [(cuts, widths)]
        reach = math.hypot(LINE_RADIUS_MM, LINE_HEIGHT_MM)
        near = (cuts[:, :2].min(axis=1) <= point.max(axis=0) + reach).all(axis=1)
        near &= (cuts[:, :2].max(axis=1) >= point.min(axis=0) - reach).all(axis=1)
        if all((_measure_aside(cuts[near], at, below, LINE_HEIGHT_MM) < widths[near]).any() for at in point):
            return True
        if line not in self.gaps:
            self.gaps[line] = max(float(_measure_aside(cuts, at, below, LINE_HEIGHT_MM).min()) for at in point)
        return False


def _measure_aside(cuts: Array, at: Array, least: float, most: float) -> Array:
    """Distance (n,) of a point from the axes of cutters where it is so high above their tips; infinite if nowhere.

    ``cuts`` (n, 3, 3): tips at the beginning and at the end, and the axis.
    """
    begin, end, along = cuts.transpose(1, 0, 2)
    way, gap = end - begin, at - begin
    rise, high = (way * along).sum(axis=1), (gap * along).sum(axis=1)
    way, gap = way - rise[:, None] * along, gap - high[:, None] * along
    rise = np.where(np.abs(rise) < ZERO_LENGTH_MM, ZERO_LENGTH_MM, rise)  # a level span: all of it, or nothing
    shares = np.sort([(high - least) / rise, (high - most) / rise], axis=0)
    low, high = np.maximum(shares[0], 0.0), np.minimum(shares[1], 1.0)
    nearest = (gap * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), ZERO_LENGTH_MM**2)
    share = np.clip(nearest, low, np.maximum(low, high))
    aside = np.linalg.norm(gap - share[:, None] * way, axis=1)
    return np.where(low <= high, aside, np.inf)
