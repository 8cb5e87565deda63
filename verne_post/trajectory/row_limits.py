"""Differences of rows over their limits: the velocity, acceleration, jerk and feed that will be verified."""

from functools import partial
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints
from verne_post.base.columns import Growing, iterate_blocks, release_memory
from verne_post.base.rows import find_row_max
from verne_post.base.team import split_evenly
from verne_post.model.machine import Limits
from verne_post.trajectory import tuning
from verne_post.trajectory.section_path import SectionTask, check_joints

#: Resting rows at both ends, which the differences count as well: jerk is a difference over four rows.
REST_ROWS: Final = 3


class JointRows(Struct, frozen=True, eq=False):
    """Rows s (n,), their joints q (n, n_joints), and the largest speed by the feed ``cap`` (n - 1,) over each step."""

    s: Array
    q: Array
    cap: Array

    @classmethod
    def build(cls, task: SectionTask, s: Array) -> "JointRows":
        """Build from rows s (n,). A step's cap is the lowest at its ends and middle, less where it hides the path."""
        section, cycle = task.section, task.cycle
        n = len(s)
        speed = np.asarray(section.find_speed(np.append(s, 0.5 * (s[1:] + s[:-1]))), dtype=float)
        cap = task.feed_share * np.minimum(np.minimum(speed[1:n], speed[: n - 1]), speed[n:])
        q, hidden = section.find_joints_and_hidden(s)
        check_joints(q, s)
        too_long = np.flatnonzero(hidden > 1.0)
        slower = (s[too_long + 1] - s[too_long]) / (cycle * hidden[too_long])
        cap[too_long] = np.minimum(cap[too_long], slower)
        return cls(s, q, cap)

    def select(self, rows: Ints) -> "JointRows":
        """Some rows (m,); caps between such as are no neighbours mean nothing."""
        return JointRows(self.s[rows], self.q[rows], self.cap[rows[:-1]])


def add_rest(s: Array) -> Array:
    """Rows s (n,) with those of rest at both ends that the differences count as well."""
    rows = Growing(float)
    rows.copy(s, REST_ROWS, REST_ROWS)
    return rows.freeze()


def measure_excess(task: SectionTask, s: Array) -> Array:
    """Largest ratio over the accepted one of the differences that begin at each row, shape (n - 3,).

    The rows s (n,) rest at both ends.
    """
    worst = Growing(float)
    for part in task.team.map(
        partial(_measure_part_of_excess, task, s), split_evenly(len(s) - REST_ROWS, tuning.SHARED_ROWS)
    ):
        worst.extend(part)
    return worst.freeze()


def _measure_part_of_excess(task: SectionTask, s: Array, part: tuple[int, int]) -> Array:
    """The part of :func:`measure_excess` of some rows."""
    release_memory()
    first, last = part
    before = min(first, 1)
    rows = JointRows.build(task, s[first - before : last + REST_ROWS])
    return measure_rows_excess(rows, task)[before:]


def measure_rows_excess(rows: JointRows, task: SectionTask) -> Array:
    """As :func:`measure_excess`, of rows whose joints are known."""
    by_feed = (np.diff(rows.s) / (task.cycle * rows.cap))[: len(rows.s) - REST_ROWS] / tuning.ACCEPTED_RATIOS[0]
    return np.maximum(by_feed, measure_joint_excess(rows.q, task.limits, task.cycle))


def measure_joint_excess(q: Array, limits: Limits, cycle: float) -> Array:
    """As :func:`measure_excess`, of the joints alone: rows q (n, n_joints), of which jerk is limited too."""
    worst, difference = np.zeros(len(q) - REST_ROWS), q
    for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk)):
        difference = np.diff(difference, axis=0)
        ratio = find_row_max(
            np.abs(difference) * (1.0 / (limit * cycle ** (order + 1) * tuning.ACCEPTED_RATIOS[order]))
        )
        worst = np.maximum(worst, ratio[: len(worst)])
    return worst


def find_exceeding(worst: Array) -> tuple[Ints, Array]:
    """Rows (m,) at which differences beyond a limit begin, and their excess, from the :func:`measure_excess` of all."""
    bad = np.concatenate(
        [first + np.flatnonzero(worst[first:last] > 1.0) for first, last in iterate_blocks(len(worst))]
    )
    return bad, worst[bad]
