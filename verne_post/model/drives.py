"""Drives: what number stands for which place of an actuator, and back."""

from collections.abc import Callable
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.tolerances import DRIVE_STEP

#: A lead error changes by at most this share of the distance: a steeper table is a mistake of units.
STEEPEST_ERROR: Final = 0.1
#: Steps of the iteration for a commanded place; each is at least ten times as near.
_STEPS: Final = 40


class Drive(Struct, frozen=True, eq=False):
    """How a drive counts.

    ``place = x + error(x)`` with ``x = zero + sign * number / scale``: commanded to x, the actuator truly stands at
    ``place``. Places in mm or degrees as the machine file has them.
    """

    unit: str  #: What the numbers are called in a heading.
    sign: float = 1.0  #: -1 where the drive counts the other way.
    zero: float = 0.0  #: Where the drive reads 0, before the lead error.
    scale: float = 1.0  #: Numbers per mm or degree.
    integer: bool = False  #: The drive takes whole numbers.
    #: Lead error (n,) at commanded places (n,); changes by less than ``STEEPEST_ERROR`` of the distance.
    error: Callable[[Array], Array] | None = None

    def find_numbers(self, places: Array) -> Array:
        """Numbers (n,) to command so that the actuator stands at places (n,); not rounded."""
        x = places
        if self.error is not None:
            for _ in range(_STEPS):
                before, x = x, places - self.error(x)
                if np.abs(x - before).max(initial=0.0) < DRIVE_STEP:
                    break
        return np.asarray(self.sign * self.scale * (x - self.zero))

    def find_places(self, numbers: Array) -> Array:
        """Places (n,) at which the actuator stands when it is commanded to numbers (n,)."""
        x = self.zero + self.sign * numbers / self.scale
        return x if self.error is None else x + self.error(x)
