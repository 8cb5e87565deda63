"""The time of each block whose feed rate is a time: inverse time, degrees per minute, F of all machine axes together.

Rows name the line that they belong to, so a block takes as long as its rows, to a control cycle. It does not matter how
tip and table share the motion of a blended corner.
"""

from typing import Final, NamedTuple

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import iterate_blocks
from verne_post.base.tolerances import FEED_RATIO, WHOLE_CYCLE
from verne_post.model.verification import BlockTime
from verne_post.verification.collector import FindingCollector
from verne_post.verification.reference import Reference
from verne_post.verification.rows import LastRow, MeasuredRows

#: A block that takes longer than programmed by this share and so many control cycles is late.
LATE_SHARE: Final = 1.01
LATE_CYCLES: Final = 2.0


class _Edge(NamedTuple):
    """Begin of a block: row and line, the seconds that all blocks before ask for, and those less their rows' time."""

    row: int
    line: int
    asked: float
    ahead: float


class BlockTimeCheck:
    """Shows that no timed block, and no run of them, takes less than its time; measures those that take longer.

    A block is what one source line asks for, from its first row to the first row of the next line. That row may stand
    up to a cycle after its beginning. So a block, or several in a row together, may seem a cycle shorter.
    """

    def __init__(self, reference: Reference, findings: FindingCollector, limits: list[str]) -> None:
        self.reference, self.findings, self.limits = reference, findings, limits
        #: count, late: Blocks whose feed rate is a time, so far, and those of them that take longer.
        self.count, self.late = 0, 0
        self.latest: BlockTime | None = None  #: The one that takes longer by most seconds.
        #: share, line: Largest time of a block over what it is certain to take at most, and its line.
        self.share, self.line = 0.0, 0
        #: (k,): Rows of late blocks that fall short of the feed rate, by the limit that was nearest.
        self.slow_rows = np.zeros(len(limits), dtype=np.int64)
        timed = reference.path.timed
        self._is_asked = any(timed[first:last].any() for first, last in iterate_blocks(len(timed)))
        # the line of the last row, its group, its first row, and its slow rows so far
        self._line, self._group, self._begin = -1, -1, 0
        self._slow = np.zeros((1, len(limits)), dtype=np.int64)
        #: The edge of blocks, so far, from which on rows have been slowest.
        self._lowest: _Edge | None = None
        self._asked = 0.0

    def check(self, rows: MeasuredRows, slow: Mask, nearest: Ints) -> None:
        """Check the next rows (n,), which of them are ``slow``, and which limit is ``nearest`` to each."""
        if not self._is_asked:
            return
        new, k = np.flatnonzero(np.diff(rows.line, prepend=self._line)), len(self.limits)
        block = np.searchsorted(new, np.flatnonzero(slow), side="right")
        counts = np.bincount(block * k + nearest[slow], minlength=(len(new) + 1) * k).reshape(-1, k)
        counts[0] += self._slow[0]
        if len(new):
            group = np.searchsorted(self.reference.items.group_first, rows.item[new], side="right") - 1
            self._close(np.append(self._group, group), np.append(self._begin, rows.first + new), counts[:-1])
            self._line, self._group, self._begin = int(rows.line[-1]), int(group[-1]), rows.first + int(new[-1])
        self._slow = counts[-1:]

    def finish(self, last: LastRow, n_rows: int) -> None:
        """Check the block that ends with the last of ``n_rows`` rows."""
        items = self.reference.items
        if self._is_asked and last.item == len(items.segment) - 1:
            self._close(np.array([self._group, len(items.group_line)]), np.array([self._begin, n_rows - 1]), self._slow)

    def _close(self, group: Ints, begin: Ints, slow: Ints) -> None:
        """Check blocks (m,) of groups (m + 1,) with first rows ``begin`` (m + 1,) and ``slow`` rows (m, k)."""
        if group[0] < 0:
            group, begin, slow = group[1:], begin[1:], slow[1:]
        if len(group) < 2:
            return
        items, cycle = self.reference.items, self.reference.cycle
        line = items.group_line[group[:-1]]
        asked, timed = self._compute_times(group)
        self._compare(line, begin, asked)
        alone = np.flatnonzero(timed & (np.diff(group) == 1))
        if not len(alone):
            return
        asked, spent, line = asked[alone], cycle * np.diff(begin)[alone], line[alone]
        self.count += len(alone)
        share = asked / (spent + cycle)
        top = int(np.argmax(share))
        if share[top] > self.share:
            self.share, self.line = float(share[top]), int(line[top])
        late = np.flatnonzero(spent > LATE_SHARE * asked + (LATE_CYCLES + WHOLE_CYCLE) * cycle)
        if not len(late):
            return
        self.late += len(late)
        self.slow_rows += slow[alone[late]].sum(axis=0)
        worst = late[np.argmax((spent - asked)[late])]
        if self.latest is None or spent[worst] - asked[worst] > self.latest.spent_s - self.latest.asked_s:
            reason = self.limits[int(np.argmax(slow[alone[worst]]))]
            self.latest = BlockTime(int(line[worst]), float(asked[worst]), float(spent[worst]), reason)

    def _compute_times(self, group: Ints) -> tuple[Array, Mask]:
        """Seconds that blocks (m,) between groups (m + 1,) ask for, and which blocks have only timed segments."""
        items, path = self.reference.items, self.reference.path
        edges = items.group_first[group]
        segment = items.segment[edges[0] : edges[-1]]
        timed = (segment >= 0) & path.timed[segment]
        seconds = np.append(0.0, np.cumsum(np.where(timed, path.feed_time[segment], 0.0)))
        others = np.append(0, np.cumsum(~timed))
        at = edges - edges[0]
        return np.diff(seconds[at]), np.diff(others[at]) == 0

    def _compare(self, line: Ints, begin: Ints, asked: Array) -> None:
        """Find blocks (m,), and blocks in a row, that take less than they ask for; they begin with rows (m + 1,)."""
        cycle = self.reference.cycle
        total = self._asked + np.append(0.0, np.cumsum(asked))
        self._asked = float(total[-1])
        ahead = total - FEED_RATIO * cycle * begin
        low = int(np.argmin(ahead))
        lowest = np.minimum.accumulate(ahead)
        before = self._lowest
        if before is not None:
            lowest = np.minimum(lowest, before.ahead)
        bad = np.flatnonzero((ahead - lowest)[1:] > FEED_RATIO * cycle + WHOLE_CYCLE)
        if len(bad):
            end = int(bad[0]) + 1
            start = int(np.argmin(ahead[:end]))
            edge = _Edge(int(begin[start]), int(line[start]), float(total[start]), float(ahead[start]))
            if before is not None and before.ahead < edge.ahead:
                edge = before
            self._report(edge, int(begin[end]), int(line[end - 1]), float(total[end]) - edge.asked)
        if low < len(line) and (before is None or ahead[low] < before.ahead):
            self._lowest = _Edge(int(begin[low]), int(line[low]), float(total[low]), float(ahead[low]))

    def _report(self, edge: _Edge, row: int, line: int, asked: float) -> None:
        """Report that blocks from an edge to ``row`` take less than the seconds that they ask for."""
        spent = self.reference.cycle * (row - edge.row)
        what = (
            f"the block of line {line} takes"
            if line == edge.line
            else f"the blocks of lines {edge.line} to {line} take"
        )
        self.findings.add(
            "VP404",
            f"{what} {spent:.6g} s, programmed are {asked:.6g} s",
            line,
            row,
            value=spent,
            limit=asked,
            unit="s",
        )
