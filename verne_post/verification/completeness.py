"""Completeness: every segment and dwell of the program in order, every stop reached, from first to last pose."""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.numbers import format_beyond
from verne_post.base.tolerances import PATH_TIP_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.verification.collector import FindingCollector
from verne_post.verification.programmed import RADIAN_MM
from verne_post.verification.reference import Reference
from verne_post.verification.rows import LastRow, MeasuredRows


class CompletenessCheck:
    """Shows that the rows pass every segment in order, reach each stop, and keep each dwell.

    Progress on a segment never runs back, and no row lies beyond its ends. At each standstill of the program a row
    stands, within PATH_TIP_MM. A dwell has at least as many rows as its time has cycles. The file begins at the start
    pose and ends at the last pose. Rounding of the rows is allowed for, and so is what a corner within its tolerance
    adds to a projection.
    """

    def __init__(self, reference: Reference, findings: FindingCollector) -> None:
        self.reference, self.findings = reference, findings
        #: The farthest that rows have come along the item of the last row.
        self._farthest = 0.0

    def check(self, rows: MeasuredRows) -> None:
        """Check the next rows."""
        self._order(rows)
        self._check_changes(rows)

    def finish(self, last: LastRow) -> bool:
        """Check that the last row is the end of the program; False where the file is cut short."""
        items = self.reference.items
        end, line = len(items.segment) - 1, last.line
        if last.item < end:
            missing = items.line[last.item + 1]
            self.findings.add("VP412", f"the file ends on line {line}; the motion of line {missing} is missing", line)
            return False
        segment = int(items.segment[end])
        if segment < 0:
            if last.rows < items.dwell_cycles[end] + 1:
                self.findings.add("VP412", f"the dwell of line {line} is too short", line)
        else:
            return self._end_of(segment, last)
        return True

    def _end_of(self, segment: int, last: LastRow) -> bool:
        """Check that the last row is at the end of a segment: by its progress, as a circle is closed, and its pose.

        False where it is before the end. Rows within the tolerance of a tight arc do not show how far along it they
        are.
        """
        measures, noise, line = self.reference.measures, self.reference.noise, last.line
        missing, length = abs(1.0 - last.u), measures.motion_length[segment]
        assert last.pose is not None, "there has been a row"
        if missing > measures.blend_u[segment] + (PATH_TIP_MM + 2 * noise.tip) / length:
            self.findings.add("VP412", f"the file ends before the end of the motion of line {line}", line)
            return False
        off = last.pose - self.reference.path.end[segment] * [1.0, 1.0, 1.0, RADIAN_MM, RADIAN_MM]
        tip, angle = float(np.linalg.norm(off[:3])), float(np.abs(off[3:]).max() / RADIAN_MM)
        tip_bound, angle_bound = self.reference.exact_bounds
        for name, value, bound, unit in (
            ("tip", tip, tip_bound, "mm"),
            ("tool axis", angle / RAD_PER_DEG, angle_bound / RAD_PER_DEG, "deg"),
        ):
            if not value <= bound:
                text = (
                    f"the last row: the {name} is {format_beyond(value, bound)} {unit} off the end of the program, "
                    f"allowed {bound:.4g} {unit}"
                )
                self.findings.add("VP411", text, line, value=value, limit=bound, unit=unit)
        return True

    def _order(self, rows: MeasuredRows) -> None:
        """Check that progress on each segment goes from its start to its end."""
        measures, segment, moves = self.reference.measures, rows.segment, ~rows.dwell
        length, blend_u = measures.motion_length[segment], measures.blend_u[segment]
        slack = 2 * self.reference.noise.tip / length + blend_u
        farthest = self._follow(rows)
        # each of two rows may stand aside of the segment, one ahead of its place and one after it
        back = np.flatnonzero(moves & ~(rows.u >= farthest - slack - blend_u))
        if len(back):
            row = int(back[0])
            line = int(rows.line[row])
            self.findings.add("VP413", f"the rows run back along line {line}", line, rows.first + row, len(back))
        margin = slack + PATH_TIP_MM / length
        outside = np.flatnonzero(moves & ((rows.u < -margin) | (rows.u > 1 + margin)))
        if len(outside):
            row = int(outside[0])
            line = int(rows.line[row])
            self.findings.add(
                "VP413", f"the tip is beyond the ends of the motion of line {line}", line, rows.first + row
            )

    def _follow(self, rows: MeasuredRows) -> Array:
        """The farthest u (n,) that rows up to each have come along its item."""
        u = np.append(self._farthest if rows.item_before[0] == rows.item[0] else -np.inf, rows.u)
        # ranks instead of numbers: what keeps those of different items apart must not cost them their last digits
        order = np.argsort(u, kind="stable")
        rank = np.empty(len(u), dtype=np.int64)
        rank[order] = np.arange(len(u))
        apart = len(u) * np.cumsum(np.append([False, False], np.diff(rows.item) != 0))
        reached = u[order[np.maximum.accumulate(rank + apart) - apart]][1:]
        self._farthest = float(reached[-1])
        return np.asarray(reached)

    def _check_changes(self, rows: MeasuredRows) -> None:
        """Check steps from one item to a later one: no standstill is left out, and stops are reached."""
        reference, items = self.reference, self.reference.items
        old, new = rows.item_before[rows.entered_rows], rows.item[rows.entered_rows]
        stops_there = items.stop_before[new]
        skips = items.count_stops_between(old, new) > stops_there
        after_dwell = (old >= 0) & (items.segment[old] < 0)
        segment = items.segment[new]
        length = reference.measures.motion_length[segment]
        # a restart may begin beside the corner that the whole program would round
        aside = np.where(segment == reference.entry, reference.entry_aside, 0.0)
        off = np.abs(rows.u[rows.entered_rows]) * length > PATH_TIP_MM + reference.noise.tip + aside
        off &= stops_there & (segment >= 0)
        for k in np.flatnonzero(skips | after_dwell | off).tolist():
            row = rows.first + int(rows.entered_rows[k])
            line = int(rows.line[rows.entered_rows[k]])
            if skips[k]:
                skipped = items.line[old[k] + 1 : new[k]]
                lines = ", ".join(str(value) for value in skipped[:5]) or str(line)
                self.findings.add("VP412", f"the motion of line {lines} is left out", line, row)
                continue
            if after_dwell[k] and rows.rows_before[k] < items.dwell_cycles[old[k]]:
                self.findings.add("VP412", f"the dwell of line {items.line[old[k]]} is too short", line, row)
            if off[k] and old[k] < 0:
                self.findings.add("VP412", "the file does not begin at the start pose", line, row)
            elif off[k]:
                text = f"the end of the motion before line {line} is not reached"
                self.findings.add("VP412", text, line, row)
