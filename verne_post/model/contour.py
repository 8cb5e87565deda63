"""The contour that the tool really follows: elements on the programmed segments.

Made by toolpath, read by kinematics and trajectory. A *segment* is one programmed motion. An *element* is a part of a
segment on which the contour is one smooth function; its parameter w goes from 0 to 1. A *section* is a sequence of
elements between two standstills; along it the pose is three times continuously differentiable by the path parameter s.
"""

from typing import Final

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import iterate_blocks
from verne_post.model.toolpath import ToolPath

#: Numbers of elements, or a slice of them.
Rows = Ints | slice
EVERY: Final = slice(None)


class Corners(Struct, frozen=True):
    """Corner blends: see :mod:`verne_post.toolpath.corners`."""

    #: (n + 1,): Places of the corners of n segments, both ends of the path included, by metric length along the
    #: path, mm.
    s: Array
    reach: Array  #: (n + 1,): Half width of the corner blend, mm; 0 where a corner is not blended.
    bend: Array  #: (n + 1, 5): Jump of the derivatives of tip and nominal angles by s.
    shape: NDArray[np.integer]  #: (n + 1,): Row of the table of shapes in :mod:`verne_post.toolpath.corner_shapes`.
    #: Segment i of the contour begins at corner ``i + shift``. A contour may begin in the middle of a path, and
    #: with segments that no corner blend reaches.
    shift: int = 0
    #: (m,): Corners beside arcs, splines and great circles, in order. Their blends overlap with no others.
    curved: Ints = field(default_factory=lambda: np.empty(0, dtype=int))
    #: (m, 2, 5): Jumps of the second and third derivative by s at those.
    jump: Array = field(default_factory=lambda: np.empty((0, 2, 5)))
    #: (m,): Row of ``controls`` where a curve replaces the path within the reach, -1 elsewhere.
    curve: Ints = field(default_factory=lambda: np.empty(0, dtype=int))
    #: (k, 8, 5): Control points of these curves of degree 7 over the reach: tip (mm) and nominal angles (rad).
    controls: Array = field(default_factory=lambda: np.empty((0, 8, 5)))


class Feeds(Struct, frozen=True):
    """The programmed feed rate of each segment, each shape (n,)."""

    rate: Array  #: mm/s of the tip, 0 where it stands still; infinite for rapids.
    #: The feed rate is a speed of the tip. Where it is a time (``timed`` of the path), ``cap`` holds throughout:
    #: a corner blend leaves each segment its share of the path, however the tip moves.
    by_tip: Mask
    cap: Array  #: ds/dt at the feed rate where tip and angles move evenly along the segment, mm/s; infinite for rapids.


class Contour(Struct, frozen=True):
    """All motion of a program as it will be made: n elements on n_segments segments."""

    path: ToolPath  #: The programmed segments.
    #: The segments that are followed: as programmed, or in their tolerance with moved vertices and chords for
    #: arcs.
    shape: ToolPath
    segment: Ints  #: (n,): The segment that an element belongs to: its source line, feed and tool length.
    #: low, high (n,): Where on its segment (u from 0 to 1) an element begins and ends.
    low: Array
    high: Array
    length: Array  #: (n,): Length by s, mm: the metric length, of tip and tool axis together.
    rotation: Array  #: (n,): Rotation of table and arc together over the element, rad.
    section: Ints  #: (n,): The section that an element belongs to, 0, 1, ...
    corners: Corners | None  #: None where no corner is blended.
    blended: Mask  #: (n,): A corner blend reaches into the element.
    feeds: Feeds
    #: tip_tolerance, axis_tolerance (n_segments,): How far the contour may be from each programmed segment, mm
    #: and rad; 0 where it follows it exactly.
    tip_tolerance: Array
    axis_tolerance: Array
    dwell_section: Ints  #: (d,): A dwell stands before this section (the number of sections: after the last).
    #: A restart begins with this segment, maybe in the middle of a corner blend; -1 where the whole program is
    #: made.
    entry: int = -1

    def __len__(self) -> int:
        return len(self.segment)

    def find_lines(self, element: Rows = EVERY) -> Ints:
        """Source lines (m,) of elements (m,)."""
        return self.path.line[self.segment[element]]

    def find_tool_lengths(self, element: Rows = EVERY) -> Array:
        """Tool lengths (m,) of elements (m,), mm."""
        return self.path.tool_length[self.segment[element]]

    def find_pace(self, element: Rows = EVERY) -> Array:
        """Seconds per mm of s at the programmed feed rate (m,) of elements (m,), 0 for rapids."""
        segment = self.segment[element]
        return np.asarray(self.path.feed_time[segment] / self.path.length[segment])

    def find_parameters(self, element: Ints, w: Array) -> Array:
        """Parameter u (n,) of the segment at w (n,) of elements (n,)."""
        low = self.low.take(element)
        return np.asarray(low + w * (self.high.take(element) - low))

    @property
    def n_sections(self) -> int:
        """Number of sections."""
        return int(self.section[-1]) + 1 if len(self.section) else 0

    @property
    def section_begins(self) -> NDArray[np.intp]:
        """First element of each section, and the number of elements after the last (n_sections + 1,)."""
        return np.searchsorted(self.section, np.arange(self.n_sections + 1))

    def select(self, elements: Ints) -> "Contour":
        """Some elements, in order, as a contour without dwells; each section keeps its elements together."""
        _sections, section = np.unique(self.section[elements], return_inverse=True)
        return replace(
            self,
            segment=self.segment[elements],
            low=self.low[elements],
            high=self.high[elements],
            length=self.length[elements],
            rotation=self.rotation[elements],
            section=section.astype(np.int32),
            blended=self.blended[elements],
            dwell_section=self.dwell_section[:0],
        )

    @property
    def continuous(self) -> Mask:
        """Sections whose curvature changes (n_sections,): with a corner blend or a spline in them."""
        continuous = np.zeros(self.n_sections, dtype=bool)
        for first, last in iterate_blocks(len(self)):
            block = slice(first, last)
            changes = self.blended[block] | (self.path.spline[self.segment[block]] >= 0)
            continuous[self.section[block][changes]] = True
        return continuous

    @property
    def n_blended(self) -> int:
        """Number of blended corners."""
        blended = 0
        if self.corners is not None:
            for first, last in iterate_blocks(len(self.path) - 1):
                programmed = self.path.move[first : last + 1] >= 0
                corner = np.flatnonzero(programmed[1:] & programmed[:-1]) + first + 1 + self.corners.shift
                blended += int((self.corners.reach[corner] > 0).sum())
        return blended
