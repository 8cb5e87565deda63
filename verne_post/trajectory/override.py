"""Feed override and slow start: how fast planned motion is executed.

With an override o the planned time tau passes at the rate o, so velocities are multiplied by o, accelerations by o^2
and jerks by o^3: what was inside the limits stays inside. A slow start lets the rate rise along a logistic curve r(t)
from ``START_RATE`` to 1. Its change adds acceleration, qd r', and jerk, 3 qdd r r' + qd r''; with r' <= (1 - r)/T and
|r''| <= (1 - r)/T^2 these fit into the margin that r < 1 leaves, 1 - r^2 and 1 - r^3, when for each joint
T >= 2 max(V/A, A/J, (V/J)^(1/2)). So the limits hold by construction, and verification sees it on the rows.
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.tolerances import WHOLE_CYCLE_SHARE
from verne_post.model.findings import make_input_error
from verne_post.model.machine import Limits

#: Where a slow start begins, as a share of the override.
START_RATE: Final = 0.1
#: The ramp is so many of its time constants long: at its ends the rate is within 0.25 % of ``START_RATE`` and of 1.
_CONSTANTS: Final = 12.0
#: So many time constants after its middle the ramp is over to double precision.
_OVER: Final = 37.0


class FeedOverride(Struct, frozen=True):
    """The rate at which planned time passes."""

    override: float = 1.0  #: 0 to 1.
    #: Seconds from the beginning of the file in which the rate rises to the override; 0 for no slow start.
    ramp: float = 0.0

    @property
    def steady(self) -> float:
        """Time from which on the rate is the override, s."""
        return self.ramp / 2 + _OVER * self.ramp / _CONSTANTS

    def find_planned_time(self, t: Array) -> Array:
        """Planned seconds (n,) that have passed at times t (n,) of the file, were there no standstills."""
        if self.ramp == 0.0:
            return self.override * t
        constant = self.ramp / _CONSTANTS
        risen = np.logaddexp(0.0, (t - self.ramp / 2) / constant) - np.logaddexp(0.0, -_CONSTANTS / 2)
        return self.override * (START_RATE * t + (1.0 - START_RATE) * constant * risen)

    def rate(self, t: float) -> float:
        """Planned seconds that pass in a second, at time t of the file."""
        if self.ramp == 0.0:
            return self.override
        risen = 1.0 / (1.0 + np.exp(-_CONSTANTS * (t / self.ramp - 0.5)))
        return float(self.override * (START_RATE + (1.0 - START_RATE) * risen))

    def count_cycles(self, planned: float, begin: float, cycle: float) -> int:
        """Smallest whole number of cycles, 1 or more, in which so many planned seconds pass from time ``begin`` on."""
        if self.ramp == 0.0 or begin >= self.steady:
            return max(int(np.ceil(planned / (self.override * cycle) * (1 - WHOLE_CYCLE_SHARE))), 1)
        low, high = 0, int(np.ceil(planned / (self.override * START_RATE * cycle))) + 1
        start = float(self.find_planned_time(np.array([begin]))[0])
        while high - low > 1:
            middle = (low + high) // 2
            if float(self.find_planned_time(np.array([begin + middle * cycle]))[0]) - start >= planned:
                high = middle
            else:
                low = middle
        return high

    def find_shares(self, row: Array, cycles: Array, begin: Array, cycle: float) -> Array:
        """Shares (n,) of motions that are done at their rows (n,): 0 at row 0, 1 at row ``cycles`` (n,).

        The motions begin at times ``begin`` (n,), s.
        """
        if self.ramp == 0.0:
            return row / cycles
        start, now, end = (self.find_planned_time(begin + cycle * k) for k in (0.0 * row, row, cycles))
        return np.asarray((now - start) / (end - start))


#: At the speed that was planned.
AS_PLANNED: Final = FeedOverride()


def build_feed_override(override: float, slow_start: float, limits: Limits) -> FeedOverride:
    """The playback that a user asks for.

    Raises
    ------
    InputError
        VP018 where the slow start is too short for the limits to hold.
    """
    roots = np.stack(
        [
            limits.velocity / limits.acceleration,
            limits.acceleration / limits.jerk,
            (limits.velocity / limits.jerk) ** 0.5,
        ]
    )
    shortest = _CONSTANTS * 2.0 * float(roots.max())
    if 0.0 < slow_start < shortest:
        text = (
            f"--slow-start {slow_start:g}: on this machine a slow start must take at least {shortest:.3g} s, or it "
            "would exceed limits itself"
        )
        raise make_input_error("VP018", text)
    return FeedOverride(override, slow_start)
