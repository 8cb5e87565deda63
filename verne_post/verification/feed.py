"""The feed: the time that rows take, against the time that the program allows at the programmed feed rate."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.numbers import format_beyond
from verne_post.base.rows import sum_rows
from verne_post.base.tolerances import FEED_RATIO
from verne_post.model.verification import NO_LIMIT_NEAR, Verification
from verne_post.verification.block_times import BlockTimeCheck
from verne_post.verification.collector import FindingCollector
from verne_post.verification.reference import DERIVATIVES, Reference
from verne_post.verification.rows import MeasuredRows

#: The feed is checked over so many rows.
_FEED_ROWS: Final = (1, 16, 256, 4096)
#: A row that takes less than this share of its cycle at the programmed feed is slow. Motion profiles approach the feed
#: from below, to within two thousandths, which nobody could see.
_SLOW: Final = 0.99
#: Mean square of what rounding adds to a step between two rows, over the square of the largest displacement of the tip.
#: Half a unit of the last decimal displaces by half of it, and values between are equally likely.
_NOISE_SQUARE: Final = 2.0 / 12.0


class FeedCheck:
    """Shows that the tool moves no faster than programmed: 1.001 of the feed over 1, 16, 256 and 4096 rows.

    The more rows, the less rounding weighs. Progress along the segment counts. Rounded corners are shorter than their
    vertex: beside them the step of the tip counts, at the fastest segment that it touches. Where the feed rate is a
    time, progress counts there too, as far as the tolerance leaves it known, and so do whole blocks
    (:class:`BlockTimeCheck`).
    """

    def __init__(self, reference: Reference, findings: FindingCollector) -> None:
        self.reference, self.findings = reference, findings
        #: ratio, line: Largest share of the programmed feed so far that is certain, and its source line.
        self.ratio, self.line = 0.0, 0
        joints = [column.joint for column in reference.columns]
        self.blocks = BlockTimeCheck(
            reference, findings, [*(f"{kind} of {joint}" for kind in DERIVATIVES for joint in joints), NO_LIMIT_NEAR]
        )
        #: (3 * n_joints + 1,): Rows of feed moves slower than the feed, by the limit that was nearest; the
        #: last number counts those near none. Of timed blocks only the rows of late ones count.
        self.slow_rows = np.zeros(len(self.blocks.limits), dtype=np.int64)
        # sums up to the last rows, as far back as the longest stretch
        self._totals, self._slacks = np.zeros(1), np.zeros(1)

    def check(self, rows: MeasuredRows, nearest: Ints) -> None:
        """Check the next rows; ``nearest`` (n,) is the limit that is nearest to each."""
        time, slack = self._compute_progress_times(rows)
        timed = self.reference.path.timed
        by_step = self.reference.measures.has_tolerance[rows.segment] & ~rows.dwell & ~timed[rows.segment]
        by_step[rows.touched.row[~timed[rows.touched.segment]]] = True  # the last step before a dwell too
        if by_step.any():
            step_time, step_slack = self._step_times(rows)
            time, slack = np.where(by_step, step_time, time), np.where(by_step, step_slack, slack)
        self._compare(rows, time, slack)
        spent = time + slack
        of_block = timed[rows.segment] & ~rows.dwell
        slow = (spent > 0) & (spent < _SLOW * self.reference.cycle) & ~of_block
        self.slow_rows += np.bincount(nearest[slow], minlength=len(self.slow_rows))
        # what rounding and corners may change of a step is the same for its neighbours: a late block shows it
        self.blocks.check(rows, of_block & (time < _SLOW * self.reference.cycle), nearest)

    def finish(self, result: Verification) -> None:
        """Say what has been found: seconds below the feed rate by derivative and joint, or the control cycle."""
        blocks = self.blocks
        result.feed_ratio, result.feed_line = max((self.ratio, self.line), (blocks.share, blocks.line))
        result.timed_blocks, result.late_blocks, result.latest_block = blocks.count, blocks.late, blocks.latest
        rows = zip(blocks.limits, (self.slow_rows + blocks.slow_rows).tolist(), strict=True)
        result.slow = {name: count * self.reference.cycle for name, count in rows if count}

    def _compare(self, rows: MeasuredRows, time: Array, slack: Array) -> None:
        """Compare times (n,) at the programmed feed with those that rows take, one and many together."""
        n = len(time)
        totals = np.append(self._totals, self._totals[-1] + np.cumsum(time))
        slacks = np.append(self._slacks, slack)
        self._totals, self._slacks = totals[-_FEED_ROWS[-1] :], slacks[-_FEED_ROWS[-1] :]
        for count in _FEED_ROWS:
            first = max(len(totals) - n, count)
            if first >= len(totals):
                break
            spent = totals[first:] - totals[first - count : len(totals) - count]
            noise = np.maximum(slacks[first:], slacks[first - count : len(slacks) - count])
            certain = np.zeros(n)
            certain[n - len(spent) :] = (spent - noise) / (count * self.reference.cycle)
            top = int(np.argmax(certain))
            if certain[top] > self.ratio:
                self.ratio, self.line = float(certain[top]), int(rows.line[top])
            bad = np.flatnonzero(certain > FEED_RATIO)
            if len(bad):
                row = int(bad[0])
                line, value = int(rows.line[row]), float(certain[row])
                self.findings.add(
                    "VP404",
                    f"the tip goes at {format_beyond(value, FEED_RATIO)} times the programmed feed rate F",
                    line,
                    rows.first + row,
                    len(bad),
                    check=count,
                    value=value,
                    limit=FEED_RATIO,
                    unit="of the feed",
                )

    def _compute_progress_times(self, rows: MeasuredRows) -> tuple[Array, Array]:
        """Seconds (n,) for the progress to rows at the programmed feed, and how far rounding may change them."""
        items, feed_time = self.reference.items, self.reference.path.feed_time[rows.segment]
        measures = self.reference.measures
        # by which shares of segments rounding, and corners within their tolerance, may change a step between two rows
        unsure = 2 * (2 * self.reference.noise.tip / measures.motion_length + measures.blend_u)
        stays = (rows.item_before == rows.item) & ~rows.dwell
        # rounding may put a row beyond the end of a short segment: that is no progress, and is not made good later
        u_before, u = np.clip(rows.u_before, 0.0, 1.0), np.clip(rows.u, 0.0, 1.0)
        time = np.where(stays, u - u_before, 0.0) * feed_time
        slack = np.where(rows.dwell, 0.0, unsure[rows.segment] * feed_time)
        entered = rows.entered_rows
        if len(entered):
            old, new = rows.item_before[entered], rows.item[entered]
            begun, left, came, whole = items.measure_passed(old, new, u_before[entered], u[entered])
            spent = left * self._compute_item_times(begun) + (items.time_before[new] - items.time_before[old + 1])
            time[entered] = (spent + came * self._compute_item_times(new)) * whole
            segment = items.segment[begun]
            more = 0.5 * unsure[segment] * self._compute_item_times(begun)
            slack[entered] += np.where((old >= 0) & (segment >= 0), more, 0.0)
        return time, slack

    def _compute_item_times(self, item: Ints) -> Array:
        """Seconds (n,) that items take at the programmed feed; 0 for dwells."""
        segment = self.reference.items.segment[item]
        return np.where(segment >= 0, self.reference.path.feed_time[segment], 0.0)

    def _step_times(self, rows: MeasuredRows) -> tuple[Array, Array]:
        """As :meth:`_compute_progress_times`, by steps of the tip, at the fastest segment that a step touches."""
        size = self._step_sizes(rows)
        time, slack = self._compute_step_times(size, rows.segment)
        row = rows.touched.row
        time[row], slack[row] = np.inf, np.inf
        passing_time, passing_slack = self._compute_step_times(size[row], rows.touched.segment)
        np.minimum.at(time, row, passing_time)
        np.minimum.at(slack, row, passing_slack)
        return time, slack

    def _step_sizes(self, rows: MeasuredRows) -> Array:
        """Steps (n,) of the tip, mm.

        Rounding makes every step longer across its direction, so that a sum of steps grows with their number: the mean
        of this growth is subtracted.
        """
        square = sum_rows(rows.step[:, :3] ** 2)
        return np.sqrt(np.maximum(square - _NOISE_SQUARE * self.reference.noise.tip**2, 0.0))

    def _compute_step_times(self, size: Array, segment: Ints) -> tuple[Array, Array]:
        """Seconds (n,) of steps (n,) at the feed of segments (n,), 0 for rapids, and what rounding may change."""
        pace = self.reference.measures.tip_pace[segment]
        return size * pace, 4 * self.reference.noise.tip * pace
