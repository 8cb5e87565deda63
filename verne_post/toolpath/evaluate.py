"""Poses along pieces: the programmed geometry, evaluated exactly."""

import numpy as np
from numpy.typing import NDArray

from verne_post.base.rotations import wrapped
from verne_post.model.toolpath import ArcPieces, PieceKind, ToolPath

Array = NDArray[np.float64]
Ints = NDArray[np.integer]


def pose(path: ToolPath, piece: Ints, u: Array) -> tuple[Array, Array]:
    """Tip and nominal angles at parameter u of pieces (LINE and ARC).

    Parameters
    ----------
    path : ToolPath
    piece : ndarray of int, shape (n,)
    u : ndarray, shape (n,)
        0 to 1.

    Returns
    -------
    tip : ndarray, shape (n, 3)
        Table frame, mm.
    angles : ndarray, shape (n, 2)
        Nominal A and C, rad, workpiece sense.
    """
    start, end = path.start[piece], path.end[piece]
    at = start + u[:, None] * (end - start)
    tip, angles = at[:, :3], at[:, 3:]
    curved = np.flatnonzero(path.kind[piece] == PieceKind.ARC)
    if len(curved):
        tip[curved] = arc_tip(path.arcs, path.arc[piece[curved]], u[curved])
    swung = np.flatnonzero(path.circle[piece] >= 0)
    if len(swung):
        angles[swung] = circle_angles(path, piece[swung], u[swung])
    return tip, angles


def circle_angles(path: ToolPath, piece: Ints, u: Array) -> Array:
    """Nominal angles (n, 2) at parameter u (n,) of pieces whose tool axis follows a great circle."""
    circles, row = path.circles, path.circle[piece]
    turn = u * circles.angle[row]
    axis = np.cos(turn)[:, None] * circles.first[row] + np.sin(turn)[:, None] * circles.side[row]
    start, end = path.start[piece, 3:], path.end[piece, 3:]
    # a great circle that avoids the pole keeps to one side of the tilt
    side = np.where(start[:, 0] + end[:, 0] < 0, -1.0, 1.0)
    tilt = side * np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])
    direction = np.arctan2(side * axis[:, 0], side * axis[:, 1])
    # its azimuth changes by less than half a turn from end to end
    return np.stack([tilt, start[:, 1] + wrapped(direction - start[:, 1])], axis=1)


def arc_tip(arcs: ArcPieces, row: Ints, u: Array) -> Array:
    """Tip (n, 3) at parameter u (n,) of the arcs in ``row`` (n,)."""
    angle = u * arcs.sweep[row]
    radius = arcs.r0[row] + u * (arcs.r1[row] - arcs.r0[row])
    return (
        arcs.center[row]
        + (radius * np.cos(angle))[:, None] * arcs.e1[row]
        + (radius * np.sin(angle))[:, None] * arcs.e2[row]
        + u[:, None] * arcs.rise[row]
    )


def arc_derivatives(arcs: ArcPieces, row: Ints, u: Array) -> tuple[Array, Array, Array]:
    """First three derivatives of the tip by u, each shape (n, 3)."""
    w = arcs.sweep[row][:, None]
    phi = u[:, None] * w
    radial = np.cos(phi) * arcs.e1[row] + np.sin(phi) * arcs.e2[row]
    tangent = np.cos(phi) * arcs.e2[row] - np.sin(phi) * arcs.e1[row]
    grow = (arcs.r1 - arcs.r0)[row][:, None]
    radius = arcs.r0[row][:, None] + u[:, None] * grow
    return (
        radius * w * tangent + grow * radial + arcs.rise[row],
        -radius * w**2 * radial + 2 * grow * w * tangent,
        -radius * w**3 * tangent - 3 * grow * w**2 * radial,
    )
