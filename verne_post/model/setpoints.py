"""Setpoints as they will be written: blocks of rows in file units, rounded to their decimals."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class SetpointFormat:
    """What a reader must know of a setpoint file: the cycle, and how every column is rounded.

    Attributes
    ----------
    cycle : float
        s.
    decimals : tuple of int
        Per joint column.
    time_decimals : int
    """

    cycle: float
    decimals: tuple[int, ...]
    time_decimals: int


@dataclass(frozen=True)
class SetpointBlock:
    """Consecutive rows of a setpoint file.

    Attributes
    ----------
    first : int
        Index of the first row; row k stands at ``t = k * cycle``.
    values : ndarray, shape (n, n_joints)
        Joint values in the units and the sense of the file, rounded.
    line : ndarray of int32, shape (n,)
        Source line of each row.
    format : SetpointFormat
    """

    first: int
    values: NDArray[np.float64]
    line: NDArray[np.int32]
    format: SetpointFormat
