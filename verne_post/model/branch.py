"""Branches of the table: the angles that hold the same tool axis."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.tolerances import POSE_DECIMALS_RAD


class Branch(Struct, frozen=True):
    """A solution for a tool axis: ``flip`` is 1 for (-A, C + pi); ``turns`` whole turns of C are added."""

    flip: int
    turns: int

    def apply_to(self, angles: Array) -> Array:
        """The pair (..., 2) on this branch for the pair on the provisional one, rounded like it.

        Without rounding a table that stands still at C 0 would be one that turns by the last digit of pi.
        """
        if self == AS_PROGRAMMED:
            return angles
        sign = -1.0 if self.flip else 1.0
        turned = angles * [sign, 1.0] + [0.0, np.pi * self.flip + 2 * np.pi * self.turns]
        return np.round(turned, POSE_DECIMALS_RAD)


#: The branch that the program names.
AS_PROGRAMMED: Final = Branch(0, 0)
