"""Short sections in fewer rows: a control cycle less at a time, as long as shifts along the path keep every limit.

Over few rows the profile in continuous time is not the last word: limits hold for differences of rows, whose number is
whole, and a row is a share of the time that counts.
"""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.trajectory import tuning
from verne_post.trajectory.interpolation import interpolate
from verne_post.trajectory.row_limits import REST_ROWS, at_rest, rows_excess
from verne_post.trajectory.row_shifts import HELD_ROWS, shift_rows
from verne_post.trajectory.section_path import SectionTask


def try_fewer_rows(task: SectionTask, s: Array) -> Array:
    """Path parameters of as few rows as are found inside every limit, from such rows s (n,), from rest to rest.

    Sections of more than ``tuning.FEW_ROWS`` stay as they are.
    """
    while HELD_ROWS < len(s) <= tuning.FEW_ROWS:
        n = len(s)
        faster = interpolate(np.arange(n, dtype=float), s, np.linspace(0.0, n - 1.0, n - 1))
        faster[[0, -1]] = s[[0, -1]]  # to the last digit
        z = at_rest(np.maximum.accumulate(np.clip(faster, s[0], s[-1])))
        rows = shift_rows(z, np.array([len(z)]), len(z), task)
        if rows_excess(rows, task).max() > 1.0 or (np.diff(rows.s) < 0).any():
            break
        s = rows.s[REST_ROWS:-REST_ROWS]
    return s
