"""ToolPath -> Contour: which corners are blended, where the motion stops, and the elements in between."""

from typing import Any, Final

import numpy as np
from msgspec.structs import asdict, replace

from verne_post.base.arrays import Array
from verne_post.base.columns import Growing, GrowingTable, iterate_blocks, release_memory, sum_running
from verne_post.base.team import ALONE, Team, split_evenly
from verne_post.model.contour import Contour, Corners, Feeds
from verne_post.model.moves import Moves
from verne_post.model.toolpath import ToolPath, find_sections
from verne_post.toolpath.corner_rules import Smoothing, find_corner_rules
from verne_post.toolpath.deviations import NEIGHBOURS
from verne_post.toolpath.elements import find_feeds, measure_rotation
from verne_post.toolpath.fairing import fair_path
from verne_post.toolpath.rounding import RoundedSegments, round_corners
from verne_post.toolpath.straighten import straighten

__all__ = ["Smoothing", "make_exact_contour", "smooth_contour"]

#: Segments whose corners are blended together: with half as many or all at once one process takes a tenth longer.
ROUNDED_SEGMENTS: Final = 1 << 12
#: Columns of a contour for every element and every segment, as they are made block by block.
_ELEMENTS: Final = {
    "segment": (np.int32,),
    "low": (float,),
    "high": (float,),
    "length": (float,),
    "rotation": (float,),
    "section": (np.int32,),
    "blended": (bool,),
}
_SEGMENTS: Final = {
    "tip_tolerance": (float,),
    "axis_tolerance": (float,),
    "rate": (float,),
    "by_tip": (bool,),
    "cap": (float,),
}


class _ContourTable:
    """A contour that grows by blocks of segments."""

    def __init__(self) -> None:
        self._elements, self._segments = GrowingTable(**_ELEMENTS), GrowingTable(**_SEGMENTS)
        self._corners = GrowingTable(reach=(float,), bend=(float, 5), shape=(np.int8,))
        self._curved, self._controls = (
            GrowingTable(curved=(np.int64,), jump=(float, 2, 5), curve=(np.int32,)),
            Growing(float, 8, 5),
        )
        self._section = -1  # of the last segment so far
        self._blended = False

    def extend(self, elements: dict[str, Any], feeds: Feeds, tip_tolerance: Array, axis_tolerance: Array) -> None:
        """Add segments, and elements with all columns of a contour."""
        self._elements.extend(**elements)
        self._segments.extend(tip_tolerance=tip_tolerance, axis_tolerance=axis_tolerance, **asdict(feeds))

    def extend_rounded(self, block: RoundedSegments, feeds: Feeds, first: int, *, last: bool) -> None:
        """Add rounded segments from number ``first`` on; the ``last`` ones with the corner at their end."""
        n = len(block.tip_tolerance)
        section = np.cumsum(block.stops[:n]) + self._section
        segment = block.elements["segment"]
        numbered = {"segment": segment + first, "section": section[segment]}
        self.extend(block.elements | numbered, feeds, block.tip_tolerance, block.axis_tolerance)
        corner = slice(n + last)
        self._corners.extend(reach=block.reach[corner], bend=block.bend[corner], shape=block.shape[corner])
        curve = np.where(block.curve < 0, -1, block.curve + self._controls.count)
        self._curved.extend(curved=block.curved + first, jump=block.jump, curve=curve)
        self._controls.extend(block.controls)
        self._section = int(section[-1])
        self._blended |= bool(block.elements["blended"].any())

    def build(self, path: ToolPath, shape: ToolPath, s: Array) -> Contour:
        """The contour of a path, that follows ``shape``, with corners at ``s``; nothing can be added any more."""
        of_segment = self._segments.freeze()
        feeds = Feeds(*(of_segment.pop(name) for name in ("rate", "by_tip", "cap")))
        columns = self._corners.freeze() | self._curved.freeze()
        corners = Corners(s, **columns, controls=self._controls.freeze()) if self._blended else None
        return Contour(
            path=path,
            shape=shape,
            corners=corners,
            feeds=feeds,
            dwell_section=path.dwell_section,
            **of_segment,
            **self._elements.freeze(),
        )


def make_exact_contour(path: ToolPath) -> Contour:
    """The segments as they are, with a stop at every corner: one element a segment."""
    table = _ContourTable()
    for begin, end in iterate_blocks(len(path)):
        part, zero = path.take_part(begin, end), np.zeros(end - begin)
        elements = {
            "segment": np.arange(begin, end),
            "low": zero,
            "high": zero + 1,
            "length": part.length,
            "rotation": measure_rotation(part),
            "section": part.section,
            "blended": zero,
        }
        table.extend(elements, find_feeds(part), zero, zero)
    return table.build(path, path, np.empty(0))


def smooth_contour(path: ToolPath, moves: Moves, smoothing: Smoothing, team: Team = ALONE) -> Contour:
    """Blend every corner that may be blended; the others stay stops.

    Parameters
    ----------
    moves : Moves
        For the G61 and G64 in force.
    """
    n = len(path)
    if n < 2:
        return make_exact_contour(path)
    s = sum_running(path.length)
    straight, left = straighten(path, moves, smoothing)
    shape, chain = straight, np.zeros(n + 1, dtype=bool)
    if smoothing.overlap:
        shape, chain = fair_path(straight, left, s, moves, smoothing, team)

    def round_part(part: tuple[int, int]) -> tuple[RoundedSegments, Feeds]:
        release_memory()
        begin, end = part
        first, last = max(begin - NEIGHBOURS, 0), min(end + NEIGHBOURS, n)
        rules = find_corner_rules(straight, left.swing, first, last, moves, smoothing)
        corners = slice(first, last + 1)
        seen = (
            straight.take_part(first, last),
            left.take_part(first, last),
            shape.take_part(first, last),
            s[corners],
            chain[corners],
        )
        rounded = round_corners(*seen, rules, smoothing)
        return rounded.take_part(begin - first, end - first), find_feeds(path.take_part(begin, end))

    parts = split_evenly(n, ROUNDED_SEGMENTS)
    table = _ContourTable()
    for (begin, end), (rounded, feeds) in zip(parts, team.map(round_part, parts), strict=True):
        table.extend_rounded(rounded, feeds, begin, last=end == n)
    contour = table.build(path, shape, s)
    return replace(
        contour, dwell_section=find_sections(contour.section, np.searchsorted(contour.segment, path.dwell_segment))
    )
