"""What a report draws: the frames of a program, its curves, the path of its tip, and the places of its findings."""

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from verne_post.app.assemble import Program
from verne_post.base.arrays import Array, Ints, Mask
from verne_post.model.findings import Finding
from verne_post.model.summary import Summary
from verne_post.part.verdict import Machined


class Curve(Struct, frozen=True, eq=False):
    """One quantity over the program: between two frames the first, lowest and highest value, each where it occurs.

    Attributes
    ----------
    x : ndarray, shape (m,)
        Rising; time in s, or the path in mm.
    values : ndarray, shape (m,)
        NaN out of reach.
    """

    x: Array
    values: Array


class Trail(Struct, frozen=True, eq=False):
    """The path of the tip: between two frames the points where x, y, z and the margin are first, lowest and highest.

    Attributes
    ----------
    frame : ndarray of int, shape (m,)
        The last frame at or before each point.
    line : ndarray of int, shape (m,)
    tip : ndarray, shape (m, 3)
    speed, margin : ndarray, shape (m,)
        As in :class:`Study`.
    bad : ndarray of bool, shape (m,)
        In violation: on a line with an error, and beyond a limit there; the whole line where no margin says which part.
    """

    frame: Ints
    line: Ints
    tip: Array
    speed: Array
    margin: Array
    bad: Mask


class Governing(Struct, frozen=True, eq=False):
    """Which limit is nearest at each moment, and what it costs against the programmed feed rate.

    Attributes
    ----------
    names : tuple of str, k of them
        "velocity of rho1", ..., then those of :data:`verne_post.report.governing.OTHERS`.
    of_frame : ndarray of int, shape (n,)
        The one that governs most rows from each frame to the next.
    lost_from_frame : ndarray, shape (n,)
        Seconds that feed moves take longer from each frame to the next than at the programmed feed rate.
    seconds, rapid, lost : ndarray, shape (k,)
        How long each governs, how much of this are rapids, and what it costs on feed moves, s.
    at_stops : ndarray, shape (k,)
        How much of ``lost`` is before and after a stop, s.
    won : ndarray, shape (k,)
        Seconds that the program would be shorter if this limit alone were higher by
        :data:`verne_post.report.governing.HIGHER`: an estimate from each row by itself.
    reached : ndarray, shape (b,)
        Seconds of feed moves by the share of the programmed feed rate that they reach: bands of equal width, and last
        those at the feed rate (:data:`verne_post.report.governing.AT_FEED`), which belong to no other band.
    """

    names: tuple[str, ...]
    of_frame: Ints
    lost_from_frame: Array
    seconds: Array
    rapid: Array
    lost: Array
    at_stops: Array
    won: Array
    reached: Array


class Operation(Struct, frozen=True):
    """What one operation takes with one tool.

    Attributes
    ----------
    tool : int
        Its number, 0 where the program names none.
    name : str
        The remark that heads the operation; empty before the first one.
    first_line, last_line : int
        Of the lines that move there, the first and the last one of the text.
    frame : int
        Where it begins.
    seconds, rapid, standing, lost : float
        All of it, and of this rapids and standstills; what feed moves lose against their feed rate, s.
    """

    tool: int
    name: str
    first_line: int
    last_line: int
    frame: int
    seconds: float
    rapid: float
    standing: float
    lost: float


class LineTimes(Struct, frozen=True, eq=False):
    """What each line of the text takes; n_lines + 1 of them, row 0 for what belongs to no line.

    Attributes
    ----------
    seconds, lost : ndarray, shape (n_lines + 1,)
        All of it, and what feed moves lose against their feed rate, s.
    limit : ndarray of int, shape (n_lines + 1,)
        The limit (:class:`Governing`) that governs where most is lost, -1 where nothing is.
    """

    seconds: Array
    lost: Array
    limit: Ints


class Spectrum(Struct, frozen=True, eq=False):
    """Accelerations of the joints by frequency: m bands of equal width on a logarithmic scale.

    Attributes
    ----------
    edges : ndarray, shape (m + 1,)
        Hz; from the lowest band to half the rate of the rows.
    rms : ndarray, shape (n_joints, m)
        Root mean square of each joint's acceleration in each band, mm/s2 or deg/s2.
    """

    edges: Array
    rms: Array


class Study(Struct, frozen=True, eq=False):
    """Frames of one program, n of them: evenly spaced along ``x``, and the first row of every block.

    The last frame is the end of the program. First rows are left out where these would be more than the others.

    Attributes
    ----------
    program : Program or None
        None where it cannot be read.
    governing : Governing or None
    operations : tuple of Operation
        In the order in which they begin; none where the program is refused.
    lines : LineTimes or None
        None where the program is refused.
    spectrum : Spectrum or None
        Of rows alone.
    timed : bool
        ``x`` is time in s, and every frame is a row; else the program is refused, and ``x`` is the path in mm.
    x : ndarray, shape (n,)
    line : ndarray of int, shape (n,)
    q : ndarray, shape (n, n_joints)
        Joints in mm and degrees, in the sense of the machine file; NaN out of reach.
    curves : dict
        "position" and, of rows, "velocity", "acceleration" and "jerk" of each joint in mm or degrees and s; "alpha" in
        degrees; "margin"; of rows, "speed" of the tip and "feed", the programmed one (NaN for rapids and where the tip
        stands still). Velocities and so on are differences of a row to those before it.
    tip, axis : ndarray, shape (n, 3)
        Part frame: the table frame of a tilting rotary table.
    speed : ndarray, shape (n,)
        Tip, mm/s; NaN where the program is refused.
    margin : ndarray, shape (n,)
        Smallest margin to a limit (toolpath.margins), NaN out of reach.
    nearest : ndarray of int, shape (n,)
        Which margin that is, of ``margin_names``; -1 out of reach.
    move : ndarray of int, shape (n,)
        Row of the Moves table, -1 on the approach.
    alpha_deg : ndarray, shape (n,)
        Platform tilt.
    nose, platform : ndarray, shape (n, 3)
        Spindle nose and P in directions of the part with the table at 0, z up, mm.
    basis : ndarray, shape (n, 2, 3)
        A direction across the spindle, and from the tip to the spindle, likewise.
    rods : ndarray, shape (n, k, 2, 3)
        From slider to platform, likewise; none where the module cannot be drawn.
    tilt, turn : ndarray, shape (n,)
        Where the table stands, rad, workpiece sense.
    tool_length : ndarray, shape (n,)
        Gauge line to tip, mm.
    place : ndarray of int, shape (n_findings,)
        The frame that shows each finding: the nearest to its worst point, on its line if that has a frame; -1 for none.
    place_tip : ndarray, shape (n_findings, 3)
        The tip at the worst point itself, or the place on the part where it is cut; NaN where there is none.
    part : Machined or None
        What the rows leave of the nominal part.
    """

    findings: tuple[Finding, ...]
    summary: Summary | None
    program: Program | None
    governing: Governing | None
    operations: tuple[Operation, ...]
    lines: LineTimes | None
    spectrum: Spectrum | None
    timed: bool
    x: Array
    line: NDArray[np.int64]
    q: Array
    curves: dict[str, tuple[Curve, ...]]
    trail: Trail
    tip: Array
    axis: Array
    speed: Array
    margin: Array
    nearest: Ints
    margin_names: tuple[str, ...]
    move: Ints
    alpha_deg: Array
    nose: Array
    platform: Array
    basis: Array
    rods: Array
    tilt: Array
    turn: Array
    tool_length: Array
    place: NDArray[np.intp]
    place_tip: Array
    part: Machined | None = None
