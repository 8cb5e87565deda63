"""ToolPath -> Contour: where the tool flows, where it stops, and the poses along it."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.model.contour import Contour
from verne_post.model.moves import Moves
from verne_post.model.toolpath import PieceKind, ToolPath
from verne_post.toolpath.blend import STRETCH, bernstein, bernstein_slope, blend_distances, blended_corners
from verne_post.toolpath.build import ROTARY_METRIC_MM
from verne_post.toolpath.evaluate import pose

Array = NDArray[np.float64]
Ints = NDArray[np.integer]


def exact_contour(path: ToolPath) -> Contour:
    """The pieces as they are, with a stop at every corner."""
    n = len(path)
    return Contour(
        path=path,
        piece=np.arange(n, dtype=np.int32),
        blend=np.full(n, -1, dtype=np.int32),
        low=np.zeros(n),
        high=np.ones(n),
        length=path.length,
        turn=_turn(path),
        run=path.run,
        controls=np.empty((0, 8, 5)),
        dwell_run=path.dwell_run,
    )


def blended_contour(path: ToolPath, moves: Moves, tip_default: float, axis_default: float) -> Contour:
    """Blend every corner that may be blended; the others stay stops.

    Parameters
    ----------
    path : ToolPath
    moves : Moves
        For the G61 and G64 in force.
    tip_default, axis_default : float
        Tolerances of a G64 without P, mm and rad.

    Returns
    -------
    Contour
        Its ``path`` has the runs of the contour, and the tolerance of every piece.
    """
    n = len(path)
    allowed, tip_tolerance, axis_tolerance = blended_corners(path, moves, tip_default, axis_default)
    joined = path.run[1:] == path.run[:-1]
    corner = np.flatnonzero(allowed & ~joined)
    d, controls = blend_distances(path, corner, tip_tolerance[corner], axis_tolerance[corner])
    made = d > 0
    corner, d, controls = corner[made], d[made], controls[made]
    flows = joined.copy()
    flows[corner] = True
    run = np.append(0, np.cumsum(~flows)).astype(np.int32)
    row_at = np.full(n, -1, dtype=np.int32)  # blend at the end of piece i
    row_at[corner] = np.arange(len(corner))
    at_end, at_start = np.zeros(n), np.zeros(n)
    at_end[corner] = d / path.length[corner]
    at_start[corner + 1] = d / path.length[corner + 1]
    blended = np.zeros(n, dtype=bool)
    blended[corner + 1] = True
    tip_of_piece, axis_of_piece = np.zeros(n), np.zeros(n)
    for side in (corner, corner + 1):
        np.maximum.at(tip_of_piece, side, tip_tolerance[corner])
        np.maximum.at(axis_of_piece, side, axis_tolerance[corner])
    smooth = replace(
        path, run=run, blended=blended, tip_tolerance=tip_of_piece, axis_tolerance=axis_of_piece,
        dwell_run=_dwell_runs(path, run),
    )  # fmt: skip

    # each piece gives: second half of the blend before it, its own middle part, first half of the blend after it
    index = np.arange(n, dtype=np.int32)
    before = np.append(np.int32(-1), row_at[:-1])
    reach = np.append(d, 0.0) * STRETCH / 2
    middle = 1.0 - at_end - at_start
    part = {
        "piece": np.stack([index, index, index], axis=1),
        "blend": np.stack([before, np.full(n, -1, dtype=np.int32), row_at], axis=1),
        "low": np.stack([np.full(n, 0.5), at_start, np.zeros(n)], axis=1),
        "high": np.stack([np.ones(n), 1.0 - at_end, np.full(n, 0.5)], axis=1),
        "length": np.stack([reach[before], middle * path.length, reach[row_at]], axis=1),
    }
    # a piece that its blends use up has no part of its own left, up to rounding
    keep = np.stack([before >= 0, middle > 1e-9, row_at >= 0], axis=1).ravel()
    flat = {name: column.ravel()[keep] for name, column in part.items()}
    share = np.where(flat["blend"] >= 0, 1.0, flat["high"] - flat["low"])
    return Contour(
        path=smooth, turn=_turn(path)[flat["piece"]] * share, run=run[flat["piece"]], controls=controls,
        dwell_run=smooth.dwell_run, **flat,
    )  # fmt: skip


def _dwell_runs(path: ToolPath, run: NDArray[np.int32]) -> NDArray[np.int32]:
    """Dwells stand before the same pieces, whose runs have new numbers."""
    begins = np.append(np.flatnonzero(np.diff(path.run, prepend=-1)), len(path))
    return np.append(run, run[-1] + 1)[begins[path.dwell_run]].astype(np.int32)


def _turn(path: ToolPath) -> Array:
    """Rotation of each piece: table angles and the sweep of arcs, rad."""
    turn = np.abs(path.end[:, 3:] - path.start[:, 3:]).sum(axis=1)
    curved = path.arc >= 0
    turn[curved] += np.abs(path.arcs.sweep[path.arc[curved]])
    joint = path.kind == PieceKind.JOINT
    if joint.any():
        ends = path.joints[path.joint[joint]]
        turn[joint] = np.abs(ends[:, 1, -2:] - ends[:, 0, -2:]).sum(axis=1)
    return turn


def contour_pose(contour: Contour, segment: Ints, w: Array) -> tuple[Array, Array]:
    """Tip (n, 3) and nominal angles (n, 2) at parameter w (n,) of segments (n,)."""
    at = contour.low[segment] + w * (contour.high[segment] - contour.low[segment])
    tip, angles = pose(contour.path, contour.piece[segment], at)
    blend = contour.blend[segment]
    curved = np.flatnonzero(blend >= 0)
    if len(curved):
        point = bernstein(contour.controls[blend[curved]], at[curved])
        tip[curved], angles[curved] = point[:, :3], point[:, 3:]
    return tip, angles


def speed_cap(contour: Contour, segment: Ints, w: Array) -> Array:
    """Largest ds/dt (n,) at which the tool keeps to the programmed feed, mm/s; infinite for rapids.

    On a piece the tip moves evenly with s. Along a blend it moves slower than s, by how much follows from the
    derivative of the curve; for pieces whose tip stands still the table angles count.
    """
    path = contour.path
    piece = contour.piece[segment]
    with np.errstate(divide="ignore"):
        cap = np.where(path.feed_time[piece] > 0, path.length[piece] / path.feed_time[piece], np.inf)
    curved = np.flatnonzero((contour.blend[segment] >= 0) & (path.feed_time[piece] > 0))
    if len(curved):
        row, piece = segment[curved], piece[curved]
        at = contour.low[row] + w[curved] * (contour.high[row] - contour.low[row])
        slope = bernstein_slope(contour.controls[contour.blend[row]], at)
        slope *= ((contour.high[row] - contour.low[row]) / contour.length[row])[:, None]
        delta = path.end[piece] - path.start[piece]
        arc = path.arc[piece]
        tip = np.linalg.norm(delta[:, :3], axis=1)
        tip = np.where(arc >= 0, np.sqrt(np.maximum(path.length[piece] ** 2 - _angle_part(delta), 0.0)), tip)
        by_tip = tip > ZERO_LENGTH_MM
        angle = np.linalg.norm(delta[:, 3:], axis=1)
        wanted = np.where(by_tip, tip, angle) / path.feed_time[piece]
        rate = np.where(by_tip, np.linalg.norm(slope[:, :3], axis=1), np.linalg.norm(slope[:, 3:], axis=1))
        with np.errstate(divide="ignore"):
            cap[curved] = wanted / rate
    return cap


def _angle_part(delta: Array) -> Array:
    return (ROTARY_METRIC_MM * np.linalg.norm(delta[:, 3:], axis=1)) ** 2
