"""What a report draws: the frames of a program, its curves, the path of its tip, and the places of its findings."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints
from verne_post.model.findings import Finding
from verne_post.model.summary import Summary


@dataclass(frozen=True, eq=False)
class Curve:
    """One quantity over the program: between two frames the first, the lowest and the highest value, each where it occurs.

    Attributes
    ----------
    x : ndarray, shape (m,)
        Rising; time in s, or the path in mm.
    values : ndarray, shape (m,)
        NaN out of reach.
    """

    x: Array
    values: Array


@dataclass(frozen=True, eq=False)
class Trail:
    """The path of the tip: between two frames the points where x, y, z and the margin are first, lowest and highest.

    Attributes
    ----------
    frame : ndarray of int, shape (m,)
        The last frame at or before each point.
    line : ndarray of int, shape (m,)
    tip : ndarray, shape (m, 3)
    speed, margin : ndarray, shape (m,)
        As in :class:`Study`.
    """

    frame: Ints
    line: Ints
    tip: Array
    speed: Array
    margin: Array


@dataclass(frozen=True, eq=False)
class Study:
    """Frames of one program, n of them, evenly spaced along ``x`` up to the last, which is the end of the program.

    Attributes
    ----------
    timed : bool
        ``x`` is time in s, and every frame is a row; else the program is refused, and ``x`` is the path in mm.
    x : ndarray, shape (n,)
    line : ndarray of int, shape (n,)
    q : ndarray, shape (n, n_joints)
        Joints in mm and degrees, in the sense of the machine file; NaN out of reach.
    curves : dict
        "position" and, of rows, "velocity", "acceleration" and "jerk" of each joint in mm or degrees and s; "alpha" in degrees.
        Velocities and so on are differences of a row to those before it.
    tip, axis : ndarray, shape (n, 3)
        Table frame.
    speed : ndarray, shape (n,)
        Tip, mm/s; NaN where the program is refused.
    margin : ndarray, shape (n,)
        Smallest margin to a limit (toolpath.margins), NaN out of reach.
    alpha_deg : ndarray, shape (n,)
        Platform tilt.
    nose, platform : ndarray, shape (n, 3)
        Spindle nose and P with z up, mm.
    rods : ndarray, shape (n, k, 2, 3)
        From slider to platform, z up; none where the module cannot be drawn.
    tilt, turn : ndarray, shape (n,)
        Where the table stands, rad, workpiece sense.
    tool_length : ndarray, shape (n,)
        Gauge line to tip, mm.
    place : ndarray of int, shape (n_findings,)
        The frame that shows each finding: the nearest to its worst point, on its line if that has a frame; -1 for none.
    place_tip : ndarray, shape (n_findings, 3)
        The tip at the worst point itself; NaN where there is none.
    stock : ndarray, shape (m, 3)
        Lines of the stock that the program defines, table frame; NaN ends each.
    """

    findings: tuple[Finding, ...]
    summary: Summary | None
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
    alpha_deg: Array
    nose: Array
    platform: Array
    rods: Array
    tilt: Array
    turn: Array
    tool_length: Array
    place: NDArray[np.intp]
    place_tip: Array
    stock: Array = field(default_factory=lambda: np.empty((0, 3)))
