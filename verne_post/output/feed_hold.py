"""How fast a player of setpoints may slow down and stop on the path: docs/first-use/feed-hold.md.

Read at a rate r(t) = 1 / (1 + exp(t / T)), a joint that has v, a and j in the rows has, with r' and r'' of this curve,

    r^2 a - r (1 - r) v / T      and      r^3 j - 3 r^2 (1 - r) a / T + r (1 - r) (1 - 2 r) v / T^2.

A hold may begin at any row, so that every row meets every r: T has to do for all of them, with all signs against it.
"""

import math
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.model.machine import Limits
from verne_post.output.rounding import convert_positions
from verne_post.output.spool import CHUNK_ROWS, WrittenRows

#: The curve steps to its ends, 1 and 0: shares of the jerk limit that the step may take in one cycle. At 1 the rows may
#: use all of the limit, at 0 nothing.
_STEP_AT_1: Final = 0.01
_STEP_AT_0: Final = 0.5
#: Velocities and accelerations are rounded up to such shares of their limits, so that few combinations are left.
_STEPS: Final = 64
#: Rates at which the limits are looked at.
_RATES: Final = np.linspace(0.02, 1.0, 50)
#: T is found to this share.
_NEAR: Final = 0.01


class FeedHold(Struct, frozen=True):
    """The curve of a hold: T in s, and how many T before and after r = 1/2 it begins and ends."""

    seconds: float
    before: int
    after: int


def find_hold(rows: WrittenRows, limits: Limits) -> FeedHold:
    """A hold that suffices wherever it begins: joints keep their limits, beside what rounding adds to the rows."""
    cycle, count = rows.format.cycle, len(rows.columns)
    limits = limits.bound_jerk(cycle)
    factors = np.abs([column.factor for column in rows.columns])
    bounds = [factors * one[:count] for one in (limits.velocity, limits.acceleration, limits.jerk)]
    jerks = _find_jerks(rows, bounds)
    at = [np.flatnonzero(table >= 0.0) for table in jerks]
    joints = [
        (speed / _STEPS * bounds[0][k], acceleration / _STEPS * bounds[1][k], jerks[k][places] * bounds[2][k])
        for k, places in enumerate(at)
        for acceleration, speed in [np.divmod(places, _STEPS + 1)]
    ]

    def find_share(seconds: float) -> float:
        shares = [1.0]
        for k, motion in enumerate(joints):
            v, a, j = (one[:, None] for one in motion)
            r, falls = _RATES, _RATES * (1.0 - _RATES) / seconds
            shares.append(float(((r**2 * a + falls * v) / bounds[1][k]).max(initial=0.0)))
            jerk = r**3 * j + 3.0 * r * falls * a + falls * np.abs(1.0 - 2.0 * r) / seconds * v
            shares.append(float((jerk / bounds[2][k]).max(initial=0.0)))
        return max(shares)

    velocity, acceleration, jerk = bounds
    half = acceleration / jerk / 2.0
    low, high = (
        cycle,
        float(np.maximum(velocity / acceleration / 2.0, half + np.sqrt(half**2 + velocity / jerk / 3.0)).max()),
    )
    while high - low > _NEAR * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if find_share(middle) <= 1.0 else (middle, high)
    step = float((velocity / jerk).max()) / cycle**2
    before, after = (max(1, math.ceil(math.log(step / share))) for share in (_STEP_AT_1, _STEP_AT_0))
    return FeedHold(high, before, after)


def _find_jerks(rows: WrittenRows, bounds: list[Array]) -> Array:
    """Shares of the jerk limit (n_joints, ...): the largest with each acceleration and speed, rounded up; else -1."""
    found = np.full((len(rows.columns), (_STEPS + 1) ** 2), -1.0)
    for first in range(0, len(rows.numbers), CHUNK_ROWS):
        q = convert_positions(np.array(rows.numbers[first : first + CHUNK_ROWS + 3]), rows.format)
        if len(q) < 4:
            break
        v, a, j = (
            np.abs(np.diff(q, order, axis=0)) / rows.format.cycle**order / bound
            for order, bound in enumerate(bounds, start=1)
        )
        v, a = np.maximum(v[:-2], np.maximum(v[1:-1], v[2:])), np.maximum(a[:-1], a[1:])  # around each jerk
        speeds, accelerations = (np.minimum(np.ceil(_STEPS * one), _STEPS).astype(np.intp) for one in (v, a))
        for k, table in enumerate(found):
            # rounding to few decimals adds jerk to the rows: it must not excuse that of a hold
            np.maximum.at(table, accelerations[:, k] * (_STEPS + 1) + speeds[:, k], np.minimum(j[:, k], 1.0))
    return found
