"""Setpoints as they will be written: blocks of rows in file units, rounded to their decimals."""

from typing import Final

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints
from verne_post.model.drives import Drive

#: In place of the source line of a row whose file names none.
UNKNOWN_LINE: Final = -1


class SetpointFormat(Struct, frozen=True):
    """Format of a setpoint file: the cycle, and how every column is rounded.

    Attributes
    ----------
    cycle : float
        s.
    decimals : tuple of int
        Per joint column.
    time_decimals : int
        Of the time column.
    drives : tuple of Drive
        How the numbers of each column count; empty where they are mm and degrees.
    header_lines : int or None
        Lines of a text file before its first row; None where the rows are no lines of a file.
    """

    cycle: float
    decimals: tuple[int, ...]
    time_decimals: int
    drives: tuple[Drive, ...] = ()
    header_lines: int | None = None

    @property
    def quanta(self) -> Array:
        """One unit of the last decimal of each joint column, mm or degrees."""
        scales = [drive.scale for drive in self.drives] or [1.0] * len(self.decimals)
        return np.array([10.0**-d / scale for d, scale in zip(self.decimals, scales, strict=True)])


class SetpointBlock(Struct, frozen=True):
    """Consecutive rows of a setpoint file: what a sink is called with.

    Attributes
    ----------
    first : int
        Index of the first row; row k stands at ``t = k * format.cycle``.
    values : ndarray, shape (n, n_joints)
        Joint values in mm and degrees, in the sense of the machine file, as the written numbers stand for them.
    line : ndarray of int32, shape (n,)
        Source line of each row. UNKNOWN_LINE in blocks of a file that names none: matching rows with the program enters
        the lines.
    format : SetpointFormat
        Control cycle, and how every column is rounded.
    numbers : ndarray, shape (n, n_joints), or None
        The numbers as written; None where they are ``values`` themselves.
    segment : ndarray, shape (n,), or None
        The segment of the tool path that each row is on; None where the rows come from a file, which does not hold it.
    """

    first: int
    values: Array
    line: NDArray[np.int32]
    format: SetpointFormat
    numbers: Array | None = None
    segment: Ints | None = None

    @property
    def written(self) -> Array:
        """The numbers as written (n, n_joints)."""
        return self.values if self.numbers is None else self.numbers
