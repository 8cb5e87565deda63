"""Following errors: measured against commanded positions, in the joints and at the tool."""

from collections.abc import Callable
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.tolerances import STANDING_JOINT

Forward = Callable[[Array, Array], tuple[Array, Array, Mask]]

#: Delays that are tried, in rows, where the log may begin late or lag.
MOST_DELAY: Final = 2000
#: Rows of a file that are compared for each delay; of a longer file every second, third, ... one.
_DELAY_ROWS: Final = 20_000
#: The distance from the commanded path is sought among so many rows on each side of the same time.
ASIDE: Final = 200
#: Rows looked at together.
CHUNK: Final = 4096


class Following(Struct, frozen=True, eq=False):
    """Following errors of a measured motion."""

    delay: int  #: Rows by which the log is later than the setpoints, as it was compared.
    rows: int  #: Rows that were compared.
    #: joint_worst, joint_rms (n_joints,): mm and rad.
    joint_worst: Array
    joint_rms: Array
    #: tip_worst, axis_worst: Tip (mm) and axis (rad) against those of the same time.
    tip_worst: float
    #: tip_row, axis_row: Setpoint rows where they are.
    tip_row: int
    axis_worst: float
    axis_row: int
    path_worst: float  #: Tip against the nearest place of the commanded path, mm: what the part sees.
    path_row: int


def estimate_delay(commanded: Array, measured: Array) -> int:
    """Estimate by how many whole rows a log (m, n_joints) is later than setpoints (n, n_joints).

    It is the delay with the least mean square error of all joints, each over its range of motion.
    """
    scale = np.maximum(np.ptp(commanded, axis=0), STANDING_JOINT)
    square = np.full(MOST_DELAY + 1, np.inf)
    for delay in range(min(MOST_DELAY, len(measured) - 2) + 1):
        n = min(len(commanded), len(measured) - delay)
        step = max(n // _DELAY_ROWS, 1)
        square[delay] = np.mean(((measured[delay : delay + n : step] - commanded[:n:step]) / scale) ** 2)
    return int(np.argmin(square))


def compare_log(commanded: Array, measured: Array, tool_length: Array, forward: Forward, delay: int) -> Following:
    """Compare a log with the setpoints that were executed.

    Parameters
    ----------
    commanded, measured : ndarray, shape (n, n_joints) and (m, n_joints)
        mm and rad; row k + ``delay`` of the log belongs to row k of the setpoints.
    tool_length : ndarray, shape (n,)
        mm.
    forward : callable
        (q, tool_length) -> tip, nominal angles, ok.
    delay : int
        Rows.
    """
    n = min(len(commanded), len(measured) - delay)
    commanded, measured, tool_length = commanded[:n], measured[delay : delay + n], tool_length[:n]
    chunks = [slice(first, min(first + CHUNK, n)) for first in range(0, n, CHUNK)]
    tips, axes = map(
        np.concatenate, zip(*(_solve_tools(commanded, tool_length, forward, rows) for rows in chunks), strict=True)
    )
    tip_error, axis_error, path_error = (np.empty(n) for _ in range(3))
    for rows in chunks:
        tip, axis = _solve_tools(measured, tool_length, forward, rows)
        tip_error[rows] = np.linalg.norm(tip - tips[rows], axis=1)
        axis_error[rows] = np.linalg.norm(axis - axes[rows], axis=1)
        path_error[rows] = _measure_distance_from_path(tip, tips, rows.start)
    error = measured - commanded
    return Following(
        delay,
        n,
        np.abs(error).max(axis=0),
        np.sqrt((error**2).mean(axis=0)),
        *_find_largest(tip_error),
        *_find_largest(axis_error),
        *_find_largest(path_error),
    )


def _solve_tools(q: Array, tool_length: Array, forward: Forward, rows: slice) -> tuple[Array, Array]:
    """Tips and tool axes (n, 3) of some rows of joint values."""
    tip, angles, _ok = forward(q[rows], tool_length[rows])
    return tip, find_axis_of_angles(*angles.T)


def _find_largest(error: Array) -> tuple[float, int]:
    """The largest error and its row."""
    row = int(np.argmax(error))
    return float(error[row]), row


def _measure_distance_from_path(tip: Array, path: Array, first: int) -> Array:
    """Distance (n,) of tips from the polyline of commanded ones, near the same time; ``first`` is the row of tip 0."""
    nearest = np.full(len(tip), np.inf)
    row = first + np.arange(len(tip))
    for shift in range(-ASIDE, ASIDE):
        low = np.clip(row + shift, 0, len(path) - 2)
        start, along = path[low], path[low + 1] - path[low]
        square = (along * along).sum(1)
        share = np.clip(((tip - start) * along).sum(1) / np.where(square > 0, square, 1.0), 0.0, 1.0)
        nearest = np.minimum(nearest, np.linalg.norm(tip - start - share[:, None] * along, axis=1))
    return nearest
