"""The contour that the tool really follows, as segments of the programmed pieces.

Made by toolpath, read by kinematics and timing. A *segment* has a parameter w from 0 to 1; today it is one
programmed piece. A *run* is a sequence of segments between two standstills; along a run the pose is three times
continuously differentiable by the path parameter s.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from verne_post.model.toolpath import ToolPath

Array = NDArray[np.float64]
Ints = NDArray[np.int32]


@dataclass(frozen=True)
class Contour:
    """All motion of a program as it will be made.

    Attributes
    ----------
    path : ToolPath
        The programmed pieces.
    piece : ndarray of int32, shape (n,)
        The piece that a segment belongs to: its source line, feed and tool length.
    length : ndarray, shape (n,)
        Length by s, mm (metric length; see docs/architecture.md).
    turn : ndarray, shape (n,)
        Rotation of table and arc together over the segment, rad.
    run : ndarray of int32, shape (n,)
    dwell_run : ndarray of int32, shape (d,)
        A dwell stands before this run (the number of runs: after the last).
    """

    path: ToolPath
    piece: Ints
    length: Array
    turn: Array
    run: Ints
    dwell_run: Ints

    def __len__(self) -> int:
        return len(self.piece)

    @property
    def line(self) -> Ints:
        """Source line of each segment."""
        return self.path.line[self.piece]

    @property
    def tool_length(self) -> Array:
        """Tool length of each segment, mm."""
        return self.path.tool_length[self.piece]

    @property
    def pace(self) -> Array:
        """Seconds per mm of s at the programmed feed, 0 for rapids."""
        return (self.path.feed_time / self.path.length)[self.piece]

    @property
    def n_runs(self) -> int:
        """Number of runs."""
        return int(self.run[-1]) + 1 if len(self.run) else 0
