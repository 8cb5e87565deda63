"""Which limit governs each moment of a program, and what it costs against the programmed feed rate."""

from typing import Final

import numpy as np

from verne_post.app.assemble import Program
from verne_post.base.arrays import Array, Ints
from verne_post.base.units import ROTARY_METRIC_MM
from verne_post.report.table import Governing

#: What governs where no limit of a joint does.
OTHERS: Final = ("programmed feed", "no limit near", "standstill")
#: A row at this share of the programmed feed is at the feed: motion profiles come to it from below, to within some thousandths.
AT_FEED: Final = 0.99
#: Below this share of every limit none of them holds the motion back.
_NEAR_SHARE: Final = 0.1
_RATES: Final = ("velocity", "acceleration", "jerk")


class GoverningLimits:
    """Takes the rows of a program block by block; n_frames stretches, each from a frame to the next."""

    def __init__(self, program: Program, cycle: float, n_frames: int) -> None:
        machine, options = program.machine, program.options
        factor = np.abs([column.factor for column in machine.columns])
        self._limits = {name: getattr(machine.limits, name) * factor for name in _RATES}
        self._cycle, feeds = cycle, program.contour.feeds
        self._rate, self._cap = feeds.rate * options.override, feeds.cap * options.override
        self._by_tip = feeds.by_tip
        self._names = (*(f"{name} of {column.joint}" for name in _RATES for column in machine.columns), *OTHERS)
        k = len(self._names)
        self._rows, self._lost_from = np.zeros((n_frames, k), dtype=np.int64), np.zeros(n_frames)
        self._rapid, self._lost = np.zeros(k), np.zeros(k)

    def add(self, stretch: Ints, segment: Ints, speed: Array, turning: Array, rates: dict[str, Array]) -> Array:
        """Add the next rows; returns the programmed speed of the tip (m,), NaN for rapids and where the tip stands still.

        Parameters
        ----------
        stretch, segment : ndarray of int, shape (m,)
        speed, turning : ndarray, shape (m,)
            Of the tip, mm/s, and of A and C together, rad/s.
        rates : dict
            Velocity, acceleration and jerk of the joints, (m, n_joints), units of the file.
        """
        rate, by_tip = self._rate[segment], self._by_tip[segment]
        feeding = np.isfinite(rate)
        # where the feed rate is a time, progress counts: tip and table together, as metric length has them
        along = np.where(by_tip, speed, np.hypot(speed, ROTARY_METRIC_MM * turning))
        share = np.where(feeding, along / np.where(feeding, np.where(by_tip, rate, self._cap[segment]), 1.0), 0.0)
        shares = np.concatenate([np.abs(rates[name]) / self._limits[name] for name in _RATES], axis=1)
        nearest = shares.argmax(axis=1)
        feed, shape, rest = range(shares.shape[1], len(self._names))
        nearest[shares.max(axis=1) < _NEAR_SHARE] = shape
        nearest[share >= AT_FEED] = feed
        nearest[~np.asarray(rates["velocity"]).any(axis=1)] = rest
        lost = np.where(
            feeding & (nearest < feed) | feeding & (nearest == shape), self._cycle * np.maximum(1.0 - share, 0.0), 0.0
        )
        k = len(self._names)
        np.add.at(self._rows, (stretch, nearest), 1)
        np.add.at(self._lost_from, stretch, lost)
        self._lost += np.bincount(nearest, lost, k)
        self._rapid += np.bincount(nearest, ~feeding, k) * self._cycle
        return np.where(feeding & (rate > 0.0), rate, np.nan)

    def finish(self) -> Governing:
        """What all rows together say."""
        return Governing(
            self._names,
            self._rows.argmax(axis=1),
            self._lost_from,
            self._rows.sum(axis=0) * self._cycle,
            self._rapid,
            self._lost,
        )
