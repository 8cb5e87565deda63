"""What a report draws: the frames of a program, its curves, the path of its tip, and the places of its findings."""

from typing import Final

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from verne_post.app.assemble import Program
from verne_post.base.arrays import Array, Ints, Mask
from verne_post.model.findings import Finding
from verne_post.model.options import Options
from verne_post.model.summary import Summary
from verne_post.part.verdict import Machined

#: A platform that tilts by less is level: joints are solved, and rounded as written.
_NO_TILT_DEG: Final = 1e-4


class Curve(Struct, frozen=True, eq=False):
    """One quantity over the program: between two frames the first, lowest and highest value, each where it occurs."""

    x: Array  #: (m,): Rising; time in s, or the path in mm.
    values: Array  #: (m,): NaN out of reach.


class Trail(Struct, frozen=True, eq=False):
    """The path of the tip: between two frames the points where x, y, z and the margin are first, lowest and highest."""

    frame: Ints  #: (m,): The last frame at or before each point.
    line: Ints  #: (m,)
    tip: Array  #: (m, 3)
    #: speed, margin (m,): As in :class:`Study`.
    speed: Array
    margin: Array
    #: (m,): In violation: on a line with an error, and beyond a limit there; the whole line where no margin says
    #: which part.
    bad: Mask
    rapid: Mask  #: (m,): No feed move leads there: a rapid or the approach does, or the tip stands.

    @property
    def framed(self) -> Array:
        """Tips (n, 3) that a picture shows as large as it can: cuts and violations; all where there are none.

        Retracts go far away from the part, and would make it tiny.
        """
        shown = ~self.rapid | self.bad
        return self.tip[shown] if shown.any() else self.tip


class Governing(Struct, frozen=True, eq=False):
    """Which limit is nearest at each moment, and what it costs against the programmed feed rate."""

    #: k of them: "velocity of rho1", ..., then those of :data:`verne_post.app.line_facts.OTHERS`.
    names: tuple[str, ...]
    of_frame: Ints  #: (n,): The one that governs most rows from each frame to the next.
    #: (n,): Seconds that feed moves take longer from each frame to the next than at the programmed feed rate.
    lost_from_frame: Array
    #: seconds, rapid, lost (k,): How long each governs, how much of this are rapids, and what it costs on feed
    #: moves, s.
    seconds: Array
    rapid: Array
    lost: Array
    at_stops: Array  #: (k,): How much of ``lost`` is before and after a stop, s.
    #: (k,): Seconds that the program would be shorter if this limit alone were higher by
    #: :data:`verne_post.report.governing.HIGHER`: an estimate from each row by itself.
    won: Array
    #: (b,): Seconds of feed moves by the share of the programmed feed rate that they reach: bands of equal width,
    #: and last those at the feed rate (:data:`verne_post.app.line_facts.AT_FEED`), which belong to no other
    #: band.
    reached: Array


class Operation(Struct, frozen=True):
    """What one operation takes with one tool."""

    tool: int  #: Its number, 0 where the program names none.
    name: str  #: The remark that heads the operation; empty before the first one.
    tool_remark: str  #: What the program says about the tool.
    #: first_line, last_line: Of the lines that move there, or call what moves, the first and the last one of the text.
    first_line: int
    last_line: int
    frame: int  #: Where it begins.
    #: seconds, rapid, standing, lost: All of it, and of this rapids and standstills; what feed moves lose against
    #: their feed rate, s.
    seconds: float
    rapid: float
    standing: float
    lost: float


class LineTimes(Struct, frozen=True, eq=False):
    """What each line of the text takes; n_lines + 1 of them, row 0 for what belongs to no line."""

    #: seconds, feed, at_feed, lost (n_lines + 1,): All of it, that of feed moves, their part at the feed rate, and what
    #: they lose against it, s.
    seconds: Array
    feed: Array
    at_feed: Array
    lost: Array
    limit: Ints  #: (n_lines + 1,): The limit (:class:`Governing`) that governs where most is lost, -1 where nothing is.


class Spectrum(Struct, frozen=True, eq=False):
    """Accelerations of the joints by frequency: m bands of equal width on a logarithmic scale."""

    edges: Array  #: (m + 1,): Hz; from the lowest band to half the rate of the rows.
    rms: Array  #: (n_joints, m): Root mean square of each joint's acceleration in each band, mm/s2 or deg/s2.


class Study(Struct, frozen=True, eq=False):
    """Frames of one program, n of them: evenly spaced along ``x``, and the first row of every block.

    The last frame is the end of the program. First rows are left out where these would be more than the others.
    """

    findings: tuple[Finding, ...]
    options: Options
    summary: Summary | None
    program: Program | None  #: None where it cannot be read.
    governing: Governing | None
    operations: tuple[Operation, ...]  #: In the order in which they begin; none where the program is refused.
    lines: LineTimes | None  #: None where the program is refused.
    spectrum: Spectrum | None  #: Of rows alone.
    #: ``x`` is time in s, and every frame is a row; else the program is refused, and ``x`` is the path in mm.
    timed: bool
    x: Array  #: (n,)
    line: NDArray[np.int64]  #: (n,)
    q: Array  #: (n, n_joints): Joints in mm and degrees, in the sense of the machine file; NaN out of reach.
    #: "position" and, of rows, "velocity", "acceleration" and "jerk" of each joint in mm or degrees and s;
    #: "alpha" in degrees; "margin"; of rows, "speed" of the tip and "feed", the programmed one (NaN for rapids
    #: and where the tip stands still). Velocities and so on are differences of a row to those before it.
    curves: dict[str, tuple[Curve, ...]]
    trail: Trail
    #: tip, axis (n, 3): Part frame: the table frame of a tilting rotary table.
    tip: Array
    axis: Array
    speed: Array  #: (n,): Tip, mm/s; NaN where the program is refused.
    margin: Array  #: (n,): Smallest margin to a limit (toolpath.margins), NaN out of reach.
    nearest: Ints  #: (n,): Which margin that is, of ``margin_names``; -1 out of reach.
    margin_names: tuple[str, ...]
    move: Ints  #: (n,): Row of the Moves table, -1 on the approach.
    alpha_deg: Array  #: (n,): Platform tilt.
    #: nose, platform (n, 3): Spindle nose and P in directions of the part with the table at 0, z up, mm.
    nose: Array
    platform: Array
    basis: Array  #: (n, 2, 3): A direction across the spindle, and from the tip to the spindle, likewise.
    rods: Array  #: (n, k, 2, 3): From slider to platform, likewise; none where the module cannot be drawn.
    #: tilt, turn (n,): Where the table stands, rad, workpiece sense.
    tilt: Array
    turn: Array
    tool_length: Array  #: (n,): Gauge line to tip, mm.
    #: (n_findings,): The frame that shows each finding: the nearest to its worst point, on its line if that has a
    #: frame; -1 for none.
    place: NDArray[np.intp]
    #: (n_findings, 3): The tip at the worst point itself, or the place on the part where it is cut; NaN where
    #: there is none.
    place_tip: Array
    part: Machined | None = None  #: What the rows leave of the nominal part.

    @property
    def tilts(self) -> bool:
        """Whether the platform tilts."""
        return bool(np.nanmax(np.abs(self.alpha_deg), initial=0.0) > _NO_TILT_DEG)
