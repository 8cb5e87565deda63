"""How large the jerk of the tool may be in a direction, by the jerk limits of the joints."""

from collections.abc import Callable
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.rows import find_row_max
from verne_post.model.machine import Machine

#: Step of the differences along a direction, mm if it is a unit vector: joints bend over hundreds of millimetres.
STEP: Final = 1e-3


def find_jerk_limit_along(machine: Machine, cycle: float) -> Callable[[Array, Array, Array], Array]:
    """The largest third derivative by time (n,) of poses (n, 5) along directions (n, 5), with tool lengths (n,).

    Poses are tips in the table frame (mm) and nominal angles (rad), directions any multiple of them by a length. Only
    the motion of the joints along the direction counts, not how they bend. Where no jerk is limited, that of rows of a
    ``cycle`` (s) counts. Where a pose is out of reach the answer is not a number.
    """
    solve, jerk = machine.five_axis.solve, machine.limits.bound_jerk(cycle).jerk

    def limit(pose: Array, direction: Array, tool_length: Array) -> Array:
        ends = []
        for side in (-STEP, STEP):
            place = pose + side * direction
            q, _platform, ok = solve(place[:, :3], place[:, 3:], tool_length)
            ends.append(np.where(ok[:, None], q, np.nan))
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / find_row_max(np.abs(ends[1] - ends[0]) / (2.0 * STEP * jerk)))

    return limit
