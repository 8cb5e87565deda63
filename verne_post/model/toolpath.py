"""The tool path as a table of segments in the table frame. Made by toolpath, read by kinematics, trajectory and verify.

A *segment* is one programmed motion, with parameter u from 0 to 1. A *section* is a sequence of segments
between two standstills; its path parameter s adds up the lengths of its segments.
"""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import Growing, iterate_blocks
from verne_post.model.moves import CalledLines
from verne_post.model.splines import Splines


class SegmentKind:
    """Shape of a segment: plain numbers, which numpy compares with an array in a fifth of the time of an IntEnum."""

    LINE: Final = 0
    ARC: Final = 1
    JOINT: Final = 2
    SPLINE: Final = 3
    TURN: Final = 4


class ArcSegments(Struct, frozen=True):
    """Geometry of arc segments in the table frame.

    ``tip(u) = center + r(u) (cos(u sweep) e1 + sin(u sweep) e2) + u rise``,
    ``r(u) = r0 + u (r1 - r0)``: radii differ by what the program's decimals leave open.
    """

    #: center, e1, e2, rise (m, 3): mm; e1 and e2 are orthogonal unit vectors, e1 points from the centre to the
    #: start.
    center: Array
    e1: Array
    e2: Array
    rise: Array
    #: r0, r1 (m,): Radius at start and end, mm.
    r0: Array
    r1: Array
    sweep: Array  #: (m,): rad, positive from e1 to e2.


class GreatCircles(Struct, frozen=True):
    """Tool axes that turn evenly along a great circle: ``axis(u) = cos(u angle) first + sin(u angle) side``.

    The nominal angles follow from the axis: the tilt on the side of the segment's own angles, C continuous from its
    start. Rows with ``joints`` are the other case in which A and C are not linear: the joints of a nutating pair are.
    """

    #: first, side (m, 3): Orthogonal unit vectors, table frame.
    first: Array
    side: Array
    angle: Array  #: (m,): rad, positive; of both joints together where these are linear.
    #: (m, 6): Joint angles d and t at both ends, and the angles a and b of the pair
    #: (:mod:`~verne_post.model.nutation`), rad; NaN on great circles.
    joints: Array


class TurnSegments(Struct, frozen=True):
    """Geometry of segments along which the axes of the machine go linearly, not the tip, table frame.

    ``tip(u) = shift + u drift + Rz(-C) (Ry(-lean) Rx(-A) place - offset + u slide)``, where ``place`` (seen from the
    tilt axis, upright frame), A and C go linearly from u = 0 to 1. These A and C are those of the program; the table
    may stand on another branch. On a nutating pair they are its joint angles.
    """

    #: first, last (m, 3): ``place`` at both ends, mm.
    first: Array
    last: Array
    #: angles, last_angles (m, 2): A and C at both ends, rad.
    angles: Array
    last_angles: Array
    #: offset, shift, slide, drift (m, 3): mm. A table that tilts and turns needs no ``slide`` and ``drift``.
    offset: Array
    shift: Array
    slide: Array
    drift: Array
    lean: Array  #: (m,): Of the tilting joint's direction over x, rad: 0 at right angles.


class SplineSegments(Struct, frozen=True):
    """Geometry of spline segments in the table frame: m pieces of rational B-splines of tip and nominal angles.

    ``pieces`` define the curve; the rest is derived from them. Along a segment u is the share of the tip's arc length.
    """

    #: Control points (p, 5): tip, mm, and how far the nominal angles have turned since the start of the segment,
    #: rad.
    pieces: Splines
    length: Array  #: (m,): Arc length of the tip, mm.
    turn: Array  #: (m,): Rotation over the piece: of the direction of the tip, and of both table angles, rad.
    #: (p, 6): Bezier control points of each piece, seen from its first control point: coordinates times weights,
    #: and weights.
    controls: Array
    first_part: NDArray[np.int64]  #: (m,): First row of what follows, for each piece.
    #: low, high (r,): Parts of a piece by u, one after the other.
    low: Array
    high: Array
    parameter: Array  #: (r, 16): Chebyshev coefficients of the Bezier curve's parameter on each part.
    #: (r,): Largest curvature of tip and angles together on each part, by metric length, in rad per mm of the tip
    #: path.
    bend: Array

    def __len__(self) -> int:
        return len(self.length)

    def find_parts(self, row: Ints, u: Array) -> Ints:
        """The parts (n,) on which u (n,) of pieces ``row`` (n,) are."""
        part, last = self.first_part[row], np.append(self.first_part[1:], len(self.low))[row]
        while True:  # parts of a piece are few
            onward = part + 1 < last
            onward[onward] = u[onward] > self.high[part[onward]]
            if not onward.any():
                return part
            part = part + onward


class ToolPath(Struct, frozen=True):
    """All motion of a program."""

    line: Ints  #: (n,): Source line; 0 for approach and departure.
    kind: NDArray[np.int8]  #: (n,): :class:`SegmentKind`.
    #: start, end (n, 5): Tip in the table frame (mm) and nominal angles A, C (rad, workpiece sense, unwrapped).
    #: For JOINT segments these are the poses at both ends.
    start: Array
    end: Array
    tool_length: Array  #: (n,): Gauge line to tip, mm.
    feed_time: Array  #: (n,): Seconds that the segment takes at the programmed feed rate, 0 for rapids.
    #: (n,): The feed rate is a time: inverse time, degrees per minute where the tip stands still, F of all
    #: machine axes together. Then progress along the segment counts, otherwise the speed of the tip.
    timed: Mask
    length: Array  #: (n,): Metric length: tip path and rotation together, of splines the tip path alone, mm.
    arc: Ints  #: (n,): Row of ``arcs``, -1 for other segments.
    arcs: ArcSegments
    spline: Ints  #: (n,): Row of ``splines``, -1 for other segments.
    splines: SplineSegments
    turn: Ints  #: (n,): Row of ``turns``, -1 for other segments.
    turns: TurnSegments
    circle: Ints  #: (n,): Row of ``circles``, -1 where A and C are linear along the segment, or those of a spline.
    circles: GreatCircles
    free: Mask  #: (n,): Programmed with a tool axis: the table may stand on either side.
    joints: Array  #: (k, 2, n_joints): Joint values at both ends of the JOINT segments, mm and rad.
    joint: Ints  #: (n,): Row of ``joints``, -1 for other segments.
    move: Ints  #: (n,): Row of the Moves table, -1 for approach and departure.
    section: Ints  #: (n,): The section that the segment belongs to, 0, 1, ...
    dwell_section: Ints  #: (d,): A dwell stands before this section (the number of sections: after the last).
    dwell_seconds: Array  #: (d,)
    dwell_line: Ints  #: (d,)
    first_pose: Array  #: (5,): Where the program starts, as ``start``.
    first_tool_length: float
    called_lines: CalledLines = CalledLines()  #: Of the moves.

    def __len__(self) -> int:
        return len(self.line)

    @property
    def n_sections(self) -> int:
        """Number of sections."""
        return int(self.section[-1]) + 1 if len(self.section) else 0

    def find_tool_lengths(self, line: Ints) -> Array:
        """Tool length (n,) at source lines (n,): of the first segment of the line, or of the line before it."""
        lines, first = np.unique(self.line, return_index=True)
        at = np.clip(np.searchsorted(lines, line, side="right") - 1, 0, len(lines) - 1)
        return np.asarray(self.tool_length[first[at]])

    def number_lines(self, segment: Ints) -> Ints:
        """Lines (n,) of segments (n,) as ``called_lines`` counts them."""
        return self.called_lines.number_moves(self.line[segment], self.move[segment])

    @property
    def dwell_segment(self) -> NDArray[np.intp]:
        """The segment that each dwell stands before (d,); the number of segments: after the last."""
        return np.searchsorted(self.section, self.dwell_section)

    def renumber_dwells(self, section: Ints) -> Ints:
        """``dwell_section`` (d,) for new section numbers (n,): dwells stand before the same segments."""
        return find_sections(section, self.dwell_segment)

    @property
    def move_reached(self) -> Ints:
        """The move of each segment (n,); for a detour and the departure the last move before, -1 before all."""
        reached, last = Growing(np.int32), np.full(1, -1, dtype=np.int32)
        for begin, end in iterate_blocks(len(self)):
            block = np.maximum.accumulate(np.append(last, self.move[begin:end]))[1:]
            reached.extend(block)
            last = block[-1:]
        return reached.freeze()

    @property
    def first_move(self) -> int:
        """The first move that has a segment, 0 where there is none."""
        for begin, end in iterate_blocks(len(self)):
            move = self.move[begin:end]
            if (move >= 0).any():
                return int(move[move >= 0][0])
        return 0

    @property
    def moves_with_length(self) -> Ints:
        """Numbers of the moves that have segments, ascending."""
        numbers, last = Growing(np.int32), -1
        for begin, end in iterate_blocks(len(self)):
            move = self.move[begin:end]
            move = move[move >= 0]
            if len(move):
                numbers.extend(move[move != np.append(last, move[:-1])])
                last = int(move[-1])
        return numbers.freeze()

    def take_part(self, first: int, last: int) -> "ToolPath":
        """Segments ``first`` to ``last`` (excluded) as a path without dwells; the tables of shapes keep their rows."""
        return replace(
            self,
            **{name: getattr(self, name)[first:last] for name in SEGMENT_COLUMNS},
            dwell_section=self.dwell_section[:0],
            dwell_seconds=self.dwell_seconds[:0],
            dwell_line=self.dwell_line[:0],
        )


#: What a tool path keeps for every segment: type, and width where it is not one number.
SEGMENT_COLUMNS: Final[Mapping[str, tuple[Any, ...]]] = {
    "line": (np.int32,), "kind": (np.int8,), "start": (float, 5), "end": (float, 5), "tool_length": (float,),
    "feed_time": (float,), "timed": (bool,), "length": (float,), "arc": (np.int32,), "spline": (np.int32,),
    "turn": (np.int32,), "circle": (np.int32,), "free": (bool,), "joint": (np.int32,),
    "move": (np.int32,), "section": (np.int32,),
}  # fmt: skip


def find_sections(section: Ints, row: Ints) -> Ints:
    """Sections (d,) of rows (d,) of a column of section numbers (n,); the next section for rows after the last."""
    n = len(section)
    if not n:
        return np.zeros(len(row), dtype=np.int32)
    return np.where(row < n, section[np.minimum(row, n - 1)], section[-1] + 1).astype(np.int32)
