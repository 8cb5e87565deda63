"""Following errors: where the machine was against where it was told to be, in the joints and at the tool."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.rotations import axis_of_angles

Array = NDArray[np.float64]
Forward = Callable[[Array, Array], tuple[Array, Array, NDArray[np.bool_]]]

#: Delays that are tried, in rows, when the log may begin late or lag.
MOST_DELAY: Final = 2000
#: The distance from the commanded path is sought among so many rows on each side of the same time.
ASIDE: Final = 200
#: Rows looked at together.
CHUNK: Final = 4096


@dataclass(frozen=True, eq=False)
class Following:
    """What a log says of a run.

    Attributes
    ----------
    delay : int
        Rows by which the log is behind the setpoints, as it was compared.
    rows : int
        Rows that were compared.
    joint_worst, joint_rms : ndarray, shape (n_joints,)
        mm and rad.
    tip_worst, axis_worst : float
        Tip (mm) and axis (rad) against those of the same time.
    tip_row, axis_row : int
        Setpoint rows where they are.
    path_worst : float
        Tip against the nearest place of the commanded path, mm: what the part sees.
    path_row : int
    """

    delay: int
    rows: int
    joint_worst: Array
    joint_rms: Array
    tip_worst: float
    tip_row: int
    axis_worst: float
    axis_row: int
    path_worst: float
    path_row: int


def delay_of(commanded: Array, measured: Array) -> int:
    """Whole rows by which a log (m, n_joints) lags behind setpoints (n, n_joints), by the least mean square of all joints."""
    scale = np.maximum(np.ptp(commanded, axis=0), 1e-9)
    rms = np.full(MOST_DELAY + 1, np.inf)
    for delay in range(min(MOST_DELAY, len(measured) - 2) + 1):
        n = min(len(commanded), len(measured) - delay)
        step = max(n // 20_000, 1)
        rms[delay] = np.mean(((measured[delay : delay + n : step] - commanded[:n:step]) / scale) ** 2)
    return int(np.argmin(rms))


def follow(commanded: Array, measured: Array, tool_length: Array, forward: Forward, delay: int) -> Following:
    """Compare a log with the setpoints that it was made of.

    Parameters
    ----------
    commanded, measured : ndarray, shape (n, n_joints) and (m, n_joints)
        mm and rad; row k + ``delay`` of the log belongs to row k of the setpoints.
    tool_length : ndarray, shape (n,)
    forward : callable
        (q, tool_length) -> tip, nominal angles, ok.
    delay : int
    """
    n = min(len(commanded), len(measured) - delay)
    wanted, was, tool_length = commanded[:n], measured[delay : delay + n], tool_length[:n]
    off = was - wanted
    tips = np.concatenate([forward(wanted[k : k + CHUNK], tool_length[k : k + CHUNK])[0] for k in range(0, n, CHUNK)])
    tip_worst, tip_row, axis_worst, axis_row, path_worst, path_row = 0.0, 0, 0.0, 0, 0.0, 0
    for first in range(0, n, CHUNK):
        part = slice(first, min(first + CHUNK, n))
        tip, angles, _ok = forward(was[part], tool_length[part])
        _tip, right, _ok = forward(wanted[part], tool_length[part])
        apart = np.linalg.norm(tip - tips[part], axis=1)
        turned = np.linalg.norm(axis_of_angles(*angles.T) - axis_of_angles(*right.T), axis=1)
        aside = _from_path(tip, tips, first)
        for value, row in ((apart, "tip"), (turned, "axis"), (aside, "path")):
            at = int(np.argmax(value))
            if row == "tip" and value[at] > tip_worst:
                tip_worst, tip_row = float(value[at]), first + at
            elif row == "axis" and value[at] > axis_worst:
                axis_worst, axis_row = float(value[at]), first + at
            elif row == "path" and value[at] > path_worst:
                path_worst, path_row = float(value[at]), first + at
    return Following(
        delay, n, np.abs(off).max(axis=0), np.sqrt((off**2).mean(axis=0)), tip_worst, tip_row, axis_worst, axis_row,
        path_worst, path_row,
    )  # fmt: skip


def _from_path(tip: Array, path: Array, first: int) -> Array:
    """Distance (n,) of tips from the polyline of the commanded ones, near the same time; row 0 is row ``first`` of the path."""
    best = np.full(len(tip), np.inf)
    at = first + np.arange(len(tip))
    for shift in range(-ASIDE, ASIDE):
        low = np.clip(at + shift, 0, len(path) - 2)
        start, along = path[low], path[low + 1] - path[low]
        square = (along * along).sum(1)
        share = np.clip(((tip - start) * along).sum(1) / np.where(square > 0, square, 1.0), 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(tip - start - share[:, None] * along, axis=1))
    return best
