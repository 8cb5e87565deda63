"""Where instruments stand that do not measure in the table frame: unknown places, and for some unknown directions.

A tip at y on the table is read as ``R^T (y - c)`` by an instrument at c whose axes are turned by R = exp(w x). Balls
that are probed and nests of sensors have their axes along the table's (w = 0); a laser tracker may stand in any
direction.
"""

from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints
from verne_post.calibration.as_built.data import ToolReadings
from verne_post.calibration.as_built.model import AsBuiltModel

#: Unknowns of a station: c (mm), w (rad).
SIZE: Final = 6
#: Places and directions are known to this, mm and rad, once :func:`align_stations` has brought them near. It decides
#: nothing, because machines within their tolerances move the tips far less.
NEAR_MM: Final = 10.0
NEAR_TURN: Final = 0.02
#: Tips that a turned frame needs, not on one line.
LEAST_TIPS: Final = 3
#: Tips so many times as far off as the median do not count for the first place of a frame, found in so many rounds.
FAR: Final = 5.0
TRIMS: Final = 5
#: The smaller extent of the tips of a frame, mm: below it they count as lying on one line.
LEAST_EXTENT_MM: Final = 1.0


class Seen(Struct, frozen=True, eq=False):
    """Tips and axes (n, 3) as their instruments read them, with the turns and places that this takes.

    ``turn`` (n, 3, 3) is R^T; ``tip_by_station`` and ``axis_by_station`` (n, 3, 6) are derivatives by c and w.
    """

    tip: Array
    axis: Array
    turn: Array
    tip_by_station: Array
    axis_by_station: Array


def see_from_stations(tip: Array, axis: Array, station: Ints, unknowns: Array) -> Seen:
    """What instruments read of tips and axes (n, 3) of the table frame.

    Parameters
    ----------
    tip, axis : ndarray, shape (n, 3)
    station : ndarray of int, shape (n,)
        -1: the table frame.
    unknowns : ndarray, shape (k, 6)
        c and w of each station.
    """
    known = np.concatenate([unknowns, np.zeros((1, SIZE))])[station]
    turn = _make_rotations(known[:, 3:]).transpose(0, 2, 1)
    from_here = tip - known[:, :3]
    inside = (station >= 0)[:, None, None]
    by_tip = np.concatenate([-turn, turn @ _make_skew_matrices(from_here)], axis=2) * inside
    by_axis = np.concatenate([np.zeros_like(turn), turn @ _make_skew_matrices(axis)], axis=2) * inside
    tip_seen, axis_seen = ((turn @ vector[..., None])[..., 0] for vector in (from_here, axis))
    return Seen(tip_seen, axis_seen, turn, by_tip, by_axis)


def _make_skew_matrices(vector: Array) -> Array:
    """Matrices (n, 3, 3) that make the cross product with vectors (n, 3)."""
    return np.cross(vector[:, None, :], np.eye(3)[None], axis=2).transpose(0, 2, 1)


def _make_rotations(turn: Array) -> Array:
    """Rotations (n, 3, 3) by vectors (n, 3): axis times angle."""
    angle = np.linalg.norm(turn, axis=1)[:, None, None]
    k = _make_skew_matrices(turn)
    # sin x / x and (1 - cos x) / x^2, also where x is 0
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * k + 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * (k @ k))


def align_stations(model: AsBuiltModel, deviations: Array, tools: ToolReadings) -> ToolReadings:
    """The readings of stations brought near the table frame, by the median shift, or a rotation if turned.

    Raises
    ------
    ValueError
        A frame with too few tips, or all of them on one line.
    """
    predicted = model.predict(deviations, tools.joints, tools.length).tip
    tip, axis = np.array(tools.tip), np.array(tools.axis)
    for station in np.unique(tools.station[tools.station >= 0]):
        rows = np.flatnonzero(tools.station == station)
        if not tools.turned[rows[0]]:
            for k in range(3):
                measured = rows[np.isfinite(tip[rows, k])]
                if len(measured):
                    tip[rows, k] += np.median(predicted[measured, k] - tip[measured, k])
            continue
        whole = rows[np.isfinite(tip[rows]).all(axis=1)]
        line = int(tools.line[rows[0]])
        if len(whole) < LEAST_TIPS:
            raise ValueError(
                f"the frame of line {line} has {len(whole)} whole tips; {LEAST_TIPS} are needed, not on one line"
            )
        near = whole
        for _ in range(TRIMS):  # without readings that are far off, such as typing errors
            centre, goal = tip[near].mean(axis=0), predicted[near].mean(axis=0)
            u, size, vt = np.linalg.svd((predicted[near] - goal).T @ (tip[near] - centre))
            if np.sqrt(size[1] / len(near)) < LEAST_EXTENT_MM:
                raise ValueError(f"all tips of the frame of line {line} lie on one line; add one beside it")
            rotation = u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt
            off = np.linalg.norm((tip[whole] - centre) @ rotation.T + goal - predicted[whole], axis=1)
            near = whole[off <= max(FAR * float(np.median(off)), LEAST_EXTENT_MM)]
        tip[rows] = (tip[rows] - centre) @ rotation.T + goal
        axis[rows] = axis[rows] @ rotation.T
        if not np.isfinite(tip[rows]).all():
            raise ValueError(
                f"the frame of line {line} has a tip with a blank coordinate: a turned frame needs all three"
            )
    return replace(tools, tip=tip, axis=axis)
