"""Rows of rest where one section ends and the next begins: as few as the joints need where the feed rate is a time.

Differences reach over four rows. With three rows at the standstill none of them covers the end of one motion and the
beginning of the next, so both are planned by themselves. But a block with a time may be late by two cycles of rest at
most. There the joints are checked across the standstill, and rows that they do not need are left out.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.model.machine import Limits
from verne_post.trajectory.row_limits import REST_ROWS, measure_joint_excess

#: Rows of rest beside a continuous section; the row at the standstill itself is the third.
ROWS_BETWEEN: Final = 2


class Standstills:
    """Counts the rows of rest of sections, which it is told in order.

    Parameters
    ----------
    find_ends : callable
        Joints (m, n_joints) of the first rows, or else of the last, of a section by its number; at most four, in order.
    continuous : ndarray of bool, shape (n_sections,)
        The section is planned as continuous.
    timed : ndarray of bool, shape (2, n_sections)
        The first and the last element of the section have a feed rate that is a time.
    dwelt : ndarray, shape (n_sections + 1,)
        Cycles of the dwells before each section.
    limits : Limits
        With a limit of jerk.
    cycle : float
        Control cycle, s.
    """

    def __init__(
        self,
        find_ends: Callable[[int, bool], Array],
        continuous: Mask,
        timed: Mask,
        dwelt: Array,
        limits: Limits,
        cycle: float,
    ) -> None:
        self.find_ends, self.continuous, self.timed = find_ends, continuous, timed
        self.dwelt, self.limits, self.cycle = dwelt, limits, cycle

    def count_before(self, section: int) -> int:
        """Rows of rest before a continuous section."""
        if section == 0:
            return 0
        return self._count(section) if self.timed[0, section] else ROWS_BETWEEN

    def count_after(self, section: int) -> int:
        """Rows of rest after a continuous section: none where the next one is continuous too, and has them."""
        if section + 1 == len(self.continuous) or self.continuous[section + 1]:
            return 0
        return self._count(section + 1) if self.timed[1, section] else ROWS_BETWEEN

    def _count(self, section: int) -> int:
        """Rows of rest that the joints need between a section and the one before."""
        arriving, leaving = self.find_ends(section - 1, False), self.find_ends(section, True)
        if min(len(arriving), len(leaving)) <= REST_ROWS:
            return ROWS_BETWEEN  # a difference would see the standstill beyond
        stood = int(self.dwelt[section])
        # what comes from a blended motion, and leaves for another, stands for a cycle: it is a stop
        least = int(stood == 0 and self.continuous[section - 1] and self.continuous[section])
        for rows in range(least, ROWS_BETWEEN):
            standing = np.repeat(leaving[:1], 1 + rows + min(stood, ROWS_BETWEEN), axis=0)
            q = np.concatenate([arriving[:-1], standing, leaving[1:]])
            if measure_joint_excess(q, self.limits, self.cycle).max() <= 1.0:
                return rows
        return ROWS_BETWEEN
