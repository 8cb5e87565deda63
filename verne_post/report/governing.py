"""Which limit governs each moment of a program, and what it costs against the programmed feed rate."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.app.assemble import Program
from verne_post.app.line_facts import AT_FEED, RATES, RowLimits
from verne_post.base.arrays import Array, Ints, Mask
from verne_post.report.table import Governing

#: So many bands of equal width are the shares of the programmed feed; what is at the feed is a band of its own.
FEED_BANDS: Final = 10
#: How much higher a limit is imagined, to say what that would win.
HIGHER: Final = 1.2


class Spent(Struct, frozen=True, eq=False):
    """Seconds of rows (m,): all, those in rapids, at a standstill and at the feed rate, the loss against it.

    ``limit`` is the limit that governs each row.
    """

    seconds: Array
    rapid: Array
    standing: Array
    at_feed: Array
    lost: Array
    limit: Ints


class GoverningLimits:
    """Takes the rows of a program block by block; n_frames stretches, each from a frame to the next."""

    def __init__(self, program: Program, cycle: float, n_frames: int) -> None:
        self._row_limits = RowLimits(program)
        n_joints = len(program.machine.columns)
        self._power = np.repeat([*RATES.values()], n_joints).astype(float)
        self._cycle, self._contour, self._names = cycle, program.contour, self._row_limits.names
        k = len(self._names)
        self._seconds, self._lost_from = np.zeros((n_frames, k)), np.zeros(n_frames)
        self._rapid, self._lost, self._won, self._at_stops = np.zeros(k), np.zeros(k), np.zeros(k), np.zeros(k)
        self._reached = np.zeros(FEED_BANDS + 1)
        # of the rows so far: section of the last one, loss since the last row at the feed, whether a stop is there
        self._section, self._open, self._at_stop, self._stood = -1, np.zeros(k), False, False

    def add(
        self, stretch: Ints, segment: Ints, speed: Array, turning: Array, rates: dict[str, Array]
    ) -> tuple[Array, Spent]:
        """Add the next rows; returns the programmed tip speed (m,), NaN for rapids and a standing tip, and the times.

        Parameters
        ----------
        stretch, segment : ndarray of int, shape (m,)
        speed, turning : ndarray, shape (m,)
            Of the tip, mm/s, and of A and C together, rad/s.
        rates : dict
            Velocity, acceleration and jerk of the joints, (m, n_joints), units of the file.

        Returns
        -------
        Array, Spent
            The programmed speed, and where the seconds go. A row stands for the time since the row before it; the first
            row of the program stands for none.
        """
        row = self._row_limits.measure(segment, speed, turning, rates)
        rate, feeding, share, nearest = self._row_limits.rate[segment], row.feeding, row.share, row.nearest
        feed, shape, rest = range(row.shares.shape[1], len(self._names))
        seconds = np.full(len(segment), self._cycle)
        if self._section < 0:
            seconds[0] = 0.0
        held_back = feeding & (nearest < feed) | feeding & (nearest == shape)
        lost = np.where(held_back, seconds * np.maximum(1.0 - share, 0.0), 0.0)
        k = len(self._names)
        np.add.at(self._seconds, (stretch, nearest), seconds)
        np.add.at(self._lost_from, stretch, lost)
        self._lost += np.bincount(nearest, lost, k)
        standing = nearest == rest
        in_rapids = seconds * (~feeding & ~standing)
        self._rapid += np.bincount(nearest, in_rapids, k)
        self._won += np.bincount(nearest, seconds * self._estimate_won(nearest, row.shares, share), k)
        band = np.where(share >= AT_FEED, FEED_BANDS, np.minimum(share * FEED_BANDS, FEED_BANDS - 1))
        moving = feeding & ~standing
        self._reached += np.bincount(band[moving].astype(np.int64), seconds[moving], FEED_BANDS + 1)
        self._add_at_stops(segment, nearest, lost, standing)
        spent = Spent(seconds, in_rapids, seconds * standing, seconds * (nearest == feed), lost, nearest)
        return np.where(feeding & (rate > 0.0), rate, np.nan), spent

    def _estimate_won(self, nearest: Ints, shares: Array, share: Array) -> Array:
        """Estimate which share of its time each row (m,) would win, were the limit that governs it higher and no other.

        A motion that is executed faster by a factor f has f, f2 and f3 times the velocities, accelerations and jerks. A
        row becomes faster until it reaches its own limit again, or another one, or the feed rate.
        """
        with np.errstate(divide="ignore"):
            room = np.concatenate([shares ** (-1.0 / self._power), 1.0 / share[:, None]], axis=1)
        feed = room.shape[1] - 1
        row = np.flatnonzero(nearest <= feed)
        own = np.append(HIGHER ** (1.0 / self._power), HIGHER)[nearest[row]]
        room[row, nearest[row]] = np.inf
        won = np.zeros(len(nearest))
        won[row] = 1.0 - 1.0 / np.maximum(np.minimum(own, room[row].min(axis=1)), 1.0)
        return won

    def _add_at_stops(self, segment: Ints, nearest: Ints, lost: Array, standing: Mask) -> None:
        """Add what is lost in stretches below the feed rate that begin or end at a stop."""
        contour, k = self._contour, len(self._names)
        section = contour.section[np.searchsorted(contour.segment, segment)]
        begins = np.append(section[0] != self._section, section[1:] != section[:-1])
        # rows on both sides of a stop
        stop = begins | standing | np.append(self._stood, standing[:-1])
        stop |= np.append(begins[1:] | standing[1:], False)
        slow = lost > 0.0
        # stretch 0 goes on from the rows before; a row at the feed rate begins the next one
        of = np.cumsum(~slow)
        touched = np.bincount(of[slow], stop[slow], of[-1] + 1) > 0.0
        self._at_stop |= bool(begins[0] or standing[0] or touched[0])
        if of[-1] > 0:
            here = slow & (of == 0)
            self._open += np.bincount(nearest[here], lost[here], k)
            self._at_stops += self._open * self._at_stop
            inside = slow & (of > 0) & (of < of[-1]) & touched[of]
            self._at_stops += np.bincount(nearest[inside], lost[inside], k)
            self._open, self._at_stop = np.zeros(k), bool(touched[-1])
        here = slow & (of == of[-1])
        self._open += np.bincount(nearest[here], lost[here], k)
        self._section, self._stood = int(section[-1]), bool(standing[-1])

    def finish(self) -> Governing:
        """What all rows together say."""
        return Governing(
            self._names,
            self._seconds.argmax(axis=1),
            self._lost_from,
            self._seconds.sum(axis=0),
            self._rapid,
            self._lost,
            # the end of the program is a stop
            self._at_stops + self._open,
            self._won,
            self._reached,
        )
