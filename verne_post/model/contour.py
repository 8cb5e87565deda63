"""The contour that the tool really follows, as segments of the programmed pieces.

Made by toolpath, read by kinematics and timing. A *segment* has a parameter w from 0 to 1 and lies on one programmed
piece, or on the half of a corner that belongs to it. A *run* is a sequence of segments between two standstills; along a
run the pose is three times continuously differentiable by the path parameter s.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.columns import blocks
from verne_post.model.toolpath import ToolPath

Array = NDArray[np.float64]
Ints = NDArray[np.int32]
#: Numbers of segments, or a stretch of them.
Rows = NDArray[np.integer] | slice
EVERY: Final = slice(None)


@dataclass(frozen=True)
class Corners:
    """Rounded corners between straight pieces: bumps on the polyline, see :mod:`verne_post.toolpath.corners`.

    Attributes
    ----------
    s : ndarray, shape (n + 1,)
        Where the corners of the n pieces are, by metric length along the whole path, mm; the ends of the path included.
    reach : ndarray, shape (n + 1,)
        Half width of the bump, mm; 0 where a corner is not rounded.
    bend : ndarray, shape (n + 1, 5)
        Change of the derivatives of tip and nominal angles by s.
    shift : int
        Piece i of the contour begins at corner ``i + shift``: a contour may begin in the middle of a path, and with pieces
        that no bump reaches.
    """

    s: Array
    reach: Array
    bend: Array
    shift: int = 0


@dataclass(frozen=True)
class Feeds:
    """What the programmed feed asks of each piece, each shape (n,).

    Attributes
    ----------
    rate : ndarray
        mm/s of the tip, or rad/s of the table angles where ``by_tip`` is False; infinite for rapids.
    by_tip : ndarray of bool
        False where the tip stands still.
    even : ndarray
        ds/dt at the feed where tip and angles move evenly along the piece, mm/s; infinite for rapids.
    """

    rate: Array
    by_tip: NDArray[np.bool_]
    even: Array


@dataclass(frozen=True)
class Contour:
    """All motion of a program as it will be made.

    Attributes
    ----------
    path : ToolPath
        The programmed pieces.
    shape : ToolPath
        The pieces that are followed: as programmed, or with vertices moved within their tolerance.
    piece : ndarray of int32, shape (n,)
        The piece that a segment belongs to: its source line, feed and tool length.
    curve : ndarray of int32, shape (n,)
        Row of ``controls``, -1 for a part of a piece.
    low, high : ndarray, shape (n,)
        Where on its piece (u from 0 to 1), or on its curve, a segment begins and ends.
    length : ndarray, shape (n,)
        Length by s, mm (metric length; see docs/architecture.md).
    turn : ndarray, shape (n,)
        Rotation of table and arc together over the segment, rad.
    run : ndarray of int32, shape (n,)
    corners : Corners or None
        Rounded corners; None where there are none.
    bumped : ndarray of bool, shape (n,)
        A rounded corner's bump reaches into the segment.
    feeds : Feeds
    controls : ndarray, shape (m, 8, 5)
        Control points of curves of degree 7: tip in the table frame and nominal angles.
    tip_tolerance, axis_tolerance : ndarray, shape (n_pieces,)
        How far the contour may be from each programmed piece, mm and rad; 0 where it follows it exactly.
    dwell_run : ndarray of int32, shape (d,)
        A dwell stands before this run (the number of runs: after the last).
    entry : int
        A restart begins with this piece, maybe in the middle of a rounded corner; -1 where the whole program is made.
    """

    path: ToolPath
    shape: ToolPath
    piece: Ints
    curve: Ints
    low: Array
    high: Array
    length: Array
    turn: Array
    run: Ints
    corners: Corners | None
    bumped: NDArray[np.bool_]
    feeds: Feeds
    controls: Array
    tip_tolerance: Array
    axis_tolerance: Array
    dwell_run: Ints
    entry: int = -1

    def __len__(self) -> int:
        return len(self.piece)

    def line(self, segment: Rows = EVERY) -> Ints:
        """Source lines (m,) of segments (m,)."""
        return self.path.line[self.piece[segment]]

    def tool_length(self, segment: Rows = EVERY) -> Array:
        """Tool lengths (m,) of segments (m,), mm."""
        return self.path.tool_length[self.piece[segment]]

    def pace(self, segment: Rows = EVERY) -> Array:
        """Seconds per mm of s at the programmed feed (m,) of segments (m,), 0 for rapids."""
        piece = self.piece[segment]
        return np.asarray(self.path.feed_time[piece] / self.path.length[piece])

    @property
    def n_runs(self) -> int:
        """Number of runs."""
        return int(self.run[-1]) + 1 if len(self.run) else 0

    @property
    def run_begins(self) -> NDArray[np.intp]:
        """First segment of each run, and the number of segments after the last (n_runs + 1,)."""
        return np.searchsorted(self.run, np.arange(self.n_runs + 1))

    def only(self, segments: NDArray[np.integer]) -> "Contour":
        """Some segments, in order, as a contour of their own without dwells; each run keeps its segments together."""
        _runs, run = np.unique(self.run[segments], return_inverse=True)
        return replace(
            self, piece=self.piece[segments], curve=self.curve[segments], low=self.low[segments], high=self.high[segments],
            length=self.length[segments], turn=self.turn[segments], run=run.astype(np.int32), bumped=self.bumped[segments],
            dwell_run=self.dwell_run[:0],
        )  # fmt: skip

    @property
    def flowing(self) -> NDArray[np.bool_]:
        """Runs with a rounded corner in them (n_runs,)."""
        found = np.zeros(self.n_runs, dtype=bool)
        for first, last in blocks(len(self)):
            some = slice(first, last)
            found[self.run[some][self.bumped[some] | (self.curve[some] >= 0)]] = True
        return found

    @property
    def n_rounded(self) -> int:
        """Corners that are not stops."""
        bumps, curved = 0, np.zeros(len(self.controls), dtype=bool)
        if self.corners is not None:
            for first, last in blocks(len(self.path) - 1):
                programmed = self.path.move[first : last + 1] >= 0
                corner = np.flatnonzero(programmed[1:] & programmed[:-1]) + first + 1 + self.corners.shift
                bumps += int((self.corners.reach[corner] > 0).sum())
        for first, last in blocks(len(self)):
            curve = self.curve[first:last]
            curved[curve[curve >= 0]] = True
        return bumps + int(curved.sum())
