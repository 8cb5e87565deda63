"""A program looked at from all sides: what a report page draws, frame by frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from verne_post.model.findings import Finding
from verne_post.model.summary import Summary

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Study:
    """Frames of one program, n of them in order.

    Attributes
    ----------
    timed : bool
        ``x`` is time in s; else the program is refused, and ``x`` is the path in mm.
    x : ndarray, shape (n,)
    line : ndarray of int, shape (n,)
    q : ndarray, shape (n, n_joints)
        Joints in mm and degrees, in the sense of the machine file; NaN out of reach.
    extremes : dict
        "velocity", "acceleration", "jerk": for each frame the largest size (n, n_joints) among the rows that it stands for,
        with its sign; empty where the program is refused.
    tip, axis : ndarray, shape (n, 3)
        Table frame.
    speed : ndarray, shape (n,)
        Tip, mm/s; NaN where the program is refused.
    margin : ndarray, shape (n,)
        Smallest room to a limit (toolpath.room), NaN out of reach.
    lean_deg : ndarray, shape (n,)
    nose, platform : ndarray, shape (n, 3)
        Spindle nose and P with z up, mm.
    rods : ndarray, shape (n, k, 2, 3)
        From slider to platform, z up; none where the module cannot be drawn.
    tilt, turn : ndarray, shape (n,)
        Where the table stands, rad, workpiece sense.
    """

    findings: tuple[Finding, ...]
    summary: Summary | None
    timed: bool
    x: Array
    line: NDArray[np.int64]
    q: Array
    extremes: dict[str, Array]
    tip: Array
    axis: Array
    speed: Array
    margin: Array
    lean_deg: Array
    nose: Array
    platform: Array
    rods: Array
    tilt: Array
    turn: Array
