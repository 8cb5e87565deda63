"""Velocities of written rows, for formats that want them."""

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array
from verne_post.output.spool import WrittenRows


def velocities_at(rows: WrittenRows, at: NDArray[np.intp]) -> Array:
    """Velocities of some rows by central differences of fourth order.

    Parameters
    ----------
    at : ndarray of int, shape (n,)
        Indices of rows.

    Returns
    -------
    ndarray, shape (n, n_joints)
        Units of the rows a second; 0 at the first and the last row, where the machine is at rest.
    """
    last = len(rows.numbers) - 1

    def shift_rows(rows_later: int) -> Array:
        return np.array(rows.numbers[np.clip(at + rows_later, 0, last)])

    velocities = (8.0 * (shift_rows(1) - shift_rows(-1)) - (shift_rows(2) - shift_rows(-2))) / (
        12.0 * rows.format.cycle
    )
    velocities[(at == 0) | (at == last)] = 0.0
    return np.asarray(velocities)
