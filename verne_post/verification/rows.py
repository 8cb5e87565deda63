"""Rows as they are checked: each matched with an item of the program, and measured once for all checks.

A row is matched by its source line. Where several items share a line, the progress along them decides, and so it does
along the whole program in a file that names no lines. The lines found are then entered in its blocks.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.ragged import number_parts
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import PATH_AXIS_DEG, PATH_TIP_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.setpoints import UNKNOWN_LINE, SetpointBlock
from verne_post.model.toolpath import SegmentKind
from verne_post.verification.axis_words import name_poses
from verne_post.verification.deviation import measure_deviation
from verne_post.verification.one_line import place_rows
from verne_post.verification.programmed import RADIAN_MM
from verne_post.verification.projection import Measured, project_onto_straight, project_unwrapped
from verne_post.verification.reference import Reference

#: Joints (n, n_joints) and tool lengths (n,) -> tip (n, 3), nominal angles (n, 2), true tool axis (n, 3), ok (n,).
Forward = Callable[[Array, Array], tuple[Array, Array, Array, Mask]]

#: Rows looked at together when several segments share a source line.
_LOOK_AHEAD: Final = 1024
#: Rows that are matched together after one that has gone on to a later group of its line; then twice as many each time.
_AFTER_CHANGE: Final = 64
#: Items of one section that are looked at together: rows that are placed together do not pass more.
_ITEMS_AHEAD: Final = 1 << 12
_APPROACHES: Final = (
    "the rows begin with an approach, and the program has none as it is verified: "
    "give --from home, or the --from of the conversion"
)


class Touched(Struct, frozen=True, eq=False):
    """Segments that steps between two items touch, where a corner of one of them may be rounded; m in order."""

    #: row, segment (m,)
    row: Ints
    segment: Ints
    part: Array  #: (m, 2): Between which u the step passes the segment, from 0 to 1.


class MeasuredRows(Struct, frozen=True, eq=False):
    """Consecutive rows (n,), and the steps that lead to them. The first row of a file has a step of length 0."""

    first: int  #: Index of the first row in the file.
    #: line, item (n,)
    line: Ints
    item: Ints
    dwell: Mask  #: (n,): The item is a dwell.
    segment: Ints  #: (n,): Of the item; where it is a dwell, the next segment (the last one, where none comes).
    u: Array  #: (n,): Where on its segment a row is, from 0 to 1; not limited.
    #: item_before, u_before (n,): Of the row before; -1 before the first row of a file.
    item_before: Ints
    u_before: Array
    pose: Measured
    #: origin, step (n, 5): Tip (mm) and angles (times RADIAN_MM) of the row before, and their change to this row.
    #: The tip is that of this row's tool: where the tool length changes, the machine does not move.
    origin: Array
    step: Array
    entered_rows: Ints  #: (c,): Rows that are the first of their item.
    rows_before: Ints  #: (c,): How many rows the item before those had.
    touched: Touched  #: By the steps to ``entered_rows``.


class LastRow(Struct, frozen=True, eq=False):
    """Where the last row was.

    ``rows`` counts the rows of its item so far; ``q`` (n_joints,) and ``pose`` (5,) are None before the first row.
    """

    item: int = -1
    u: float = 0.0
    group: int = -1
    line: int = -2
    rows: int = 0
    tool_length: float = 0.0
    q: Array | None = None
    pose: Array | None = None


class LostPath(Struct, frozen=True):
    """Why the rows of a block cannot be followed from ``row`` on.

    ``approaches`` where the rows begin with an approach, and the program has none: nothing else is known of them.
    """

    row: int
    code: str
    text: str
    approaches: bool = False


class RowMatcher:
    """Matches a stream of rows with the items of a program, and measures them."""

    def __init__(self, reference: Reference, forward: Forward, *, joints_by_axis: bool = False) -> None:
        #: forward: (q, tool_length) -> tip, nominal angles, ok.
        self.reference, self.forward, self._joints_by_axis = reference, forward, joints_by_axis
        #: The largest angle between the true tool axis and that of the nominal angles so far, rad.
        self.axis_error = 0.0
        self.last = LastRow()

    def match(self, block: SetpointBlock) -> tuple[list[MeasuredRows], LostPath | None]:
        """Measure the next rows, up to one that cannot be followed.

        Returns
        -------
        parts : list of MeasuredRows
            Consecutive; none where not even the first row can be followed.
        lost : LostPath or None
        """
        parts: list[MeasuredRows] = []
        begin, count, n = 0, len(block.values), len(block.values)
        while begin < n:
            rows, lost, later = self._match_some(block, begin, min(begin + count, n))
            if rows is not None:
                parts.append(rows)
                begin += len(rows.item)
            if lost is not None:
                return parts, lost
            count = _AFTER_CHANGE if later >= 0 else 2 * count
            if later >= 0:
                self.last = replace(self.last, group=later)
        return parts, None

    def _match_some(
        self, block: SetpointBlock, begin: int, end: int
    ) -> tuple[MeasuredRows | None, LostPath | None, int]:
        """Measure rows of a block, up to a lost one or one on a later group of its line; that group, or -1."""
        items, path = self.reference.items, self.reference.path
        line, q = block.line[begin:end].astype(np.int64), block.values[begin:end] / self.reference.factor
        lost: LostPath | None = None
        item: Ints
        group: Ints
        if line[0] == UNKNOWN_LINE:
            item = self._place_without_lines(q)
            n, line = len(item), items.line[item].astype(np.int64)
            group = np.searchsorted(items.group_first, item, side="right") - 1
        else:
            group, lost = self._match_groups(line)
            if not len(group):
                return None, None if lost is None else replace(lost, row=begin + lost.row), -1
            n = len(group)
            item = self._split_groups(q[:n], group)
        rest = items.rest_segment[item]
        segment = np.minimum(rest, len(path) - 1)
        tip, angles, axis, ok = self.forward(q[:n], path.tool_length[segment])
        fresh = np.append(item[0] != self.last.item, item[1:] != item[:-1])
        pose = self._name_words(segment, Measured(q[:n], tip, angles), fresh, self.last.u)
        if not ok.all():
            n = int(np.argmin(ok))
            lost = LostPath(n, "VP411", "no position of the platform fits the joint values")
            pose = pose.select(np.arange(n))
        u = self._measure_progress(item[:n], rest[:n], segment[:n], pose)
        passed, later = n, -1
        if block.line[begin] == UNKNOWN_LINE:
            block.line[begin : begin + n] = line[:n]
        else:
            passed, later = self._find_later_group(group[:n], item[:n], segment[:n], pose, u)
        if later >= 0:
            n, lost = passed, None
        if lost is not None:
            lost = replace(lost, row=begin + lost.row)
        if not n:
            return None, lost, later
        pose = pose if n == len(pose.q) else pose.select(np.arange(n))
        # what no angle of the axes corrects: the true axis against that of the nominal angles
        self.axis_error = max(self.axis_error, float(measure_rows(axis[:n] - pose.axis).max()))
        return self._measure(block.first + begin, line[:n], group[:n], item[:n], segment[:n], u[:n], pose), lost, later

    def _name_words(self, segment: Ints, pose: Measured, fresh: Mask, u_before: float) -> Measured:
        """Measured poses (n,) with the angles of their segments, where the joints tell the tool axis alone."""
        if not self._joints_by_axis:
            return pose
        return name_poses(self.reference.path, segment, pose, self.reference.words_bound, (fresh, u_before))

    # --- matching -------------------------------------------------------------------------

    def _match_groups(self, line: Ints) -> tuple[Ints, LostPath | None]:
        """Group of each row by its source line, up to one whose line is not the program's next."""
        items = self.reference.items
        group = self.last.group + np.cumsum(line != np.append(self.last.line, line[:-1]))
        while True:
            beyond = group >= len(items.group_line)
            expected = items.group_line[np.minimum(group, len(items.group_line) - 1)]
            wrong = np.flatnonzero(beyond | (expected != line))
            if not len(wrong):
                return group, None
            row = int(wrong[0])
            hop = self._count_skipped(int(group[row]), int(line[row]))
            if hop is None:
                if not line[row] and group[row] == 0:
                    return group[:row], LostPath(row, "VP413", _APPROACHES, approaches=True)
                where = f"line {expected[row]}" if not beyond[row] else "its end"
                hint = (
                    "; line 0 is an approach or a departure: give the --from and --to of the conversion"
                    if not line[row]
                    else ""
                )
                text = f"it belongs to line {line[row]}, where the program goes on with {where}{hint}"
                return group[:row], LostPath(row, "VP413", text)
            group[row:] += hop

    def _count_skipped(self, group: int, line: int) -> int | None:
        """How many whole groups of one section were passed between two rows; None if the line does not follow."""
        items = self.reference.items
        for hop in range(1, len(items.group_line) - group):
            first = items.group_first[group + hop]
            if items.stop_before[items.group_first[group] : first].any():
                return None
            if items.group_line[group + hop] == line:
                return hop
        return None

    def _find_later_group(self, group: Ints, item: Ints, segment: Ints, pose: Measured, u: Array) -> tuple[int, int]:
        """First row that has left the last segment of its group (n,), and the next group of its line; -1 if none.

        What is so short that no row stands on it may lie between the two: then the lines of the rows do not change.
        """
        items, path = self.reference.items, self.reference.path
        if not len(items.next_group):
            return -1, -1
        row = np.flatnonzero((items.next_group[group] >= 0) & (item == items.group_first[group + 1] - 1))
        row = row[~measure_deviation(self.reference, segment[row], u[row], pose.select(row)).within]
        later = items.next_group[group[row]]
        other, fresh = items.segment[items.group_first[later]], np.ones(len(row), dtype=bool)
        some = self._name_words(other, pose.select(row), fresh, 0.0)
        other_u = project_unwrapped(path, other, some, fresh, 0.0, self.reference.find_bounds(other))
        found = np.flatnonzero(measure_deviation(self.reference, other, other_u, some).within)
        return (int(row[found[0]]), int(later[found[0]])) if len(found) else (-1, -1)

    def _split_groups(self, q: Array, group: Ints) -> Ints:
        """Item of its group (n,) that each row belongs to."""
        items = self.reference.items
        item: Ints = items.group_first[group]
        several = items.group_first[group + 1] - item > 1
        if not several.any():
            return item
        edges = np.flatnonzero(np.diff(group, prepend=-1, append=-1))
        for begin, end in pairwise(edges.tolist()):
            if not several[begin]:
                continue
            now, last = (int(items.group_first[group[begin] + k]) - k for k in (0, 1))
            self._place_in_order(q, item, begin, end, now, last)
        return item

    def _place_without_lines(self, q: Array) -> Ints:
        """Item of each row (n, n_joints) of a file that names no lines: all items of the program follow each other."""
        item = np.empty(len(q), dtype=np.int64)
        self._place_in_order(q, item, 0, len(q), 0, len(self.reference.items.segment) - 1)
        return item

    def _place_in_order(self, q: Array, item: Ints, begin: int, end: int, now: int, last: int) -> None:
        """Find the item of rows ``begin`` to ``end`` of q (n, n_joints), from item ``now`` to ``last`` in order."""
        items = self.reference.items
        rows, u = 0, None
        if begin == 0 and now <= self.last.item:
            now, rows, u = self.last.item, self.last.rows, self.last.u
        row = begin
        while row < end:
            if now == last:
                item[row:end] = now
                break
            before = items.stops_before[now + 1]
            stop = min(int(np.searchsorted(items.stops_before, before, side="right")) - 1, last + 1, now + _ITEMS_AHEAD)
            if items.segment[now] < 0:
                take = min(int(items.dwell_cycles[now]) - rows, end - row)
                item[row : row + take] = now
            elif stop == now + 1:
                take = self._count_rows_of_item(q[row:end], now, u)
                item[row : row + take] = now
            else:
                place = now, u or 0.0, self._find_pose_before(q, row, now)
                by_axis = self._joints_by_axis
                placed = place_rows(self.reference, self.forward, q[row:end], place, stop - 1, by_axis=by_axis)
                take = int(np.searchsorted(placed, stop - 1))
                item[row : row + take] = placed[:take]
                if take < end - row:
                    row, now, u = row + take, stop - 1, u if take == 0 and now == stop - 1 else None
                    continue
            row += take
            now, u, rows = stop, None, 0

    def _find_pose_before(self, q: Array, row: int, item: int) -> Array:
        """Tip (mm) and angles (times RADIAN_MM) before a row of q (n, n_joints); its own for the first row."""
        if row == 0 and self.last.pose is not None:
            return self.last.pose
        at = slice(max(row - 1, 0), max(row, 1))
        tip, angles, _axis, _ok = self.forward(
            q[at], self.reference.path.tool_length[[self.reference.items.segment[item]]]
        )
        return np.append(tip[0], RADIAN_MM * angles[0])

    def _count_rows_of_item(self, q: Array, item: int, u_before: float | None) -> int:
        """Count rows before the end of a segment; ``u_before`` is None if the row before is not on it."""
        path = self.reference.path
        segment = int(self.reference.items.segment[item])
        close = 1.0 - self.reference.noise.tip / self.reference.measures.motion_length[segment]
        for begin in range(0, len(q), _LOOK_AHEAD):
            some_q = q[begin : begin + _LOOK_AHEAD]
            at = np.full(len(some_q), segment)
            tip, angles, _axis, _ok = self.forward(some_q, path.tool_length[at])
            fresh = np.zeros(len(some_q), dtype=bool)
            fresh[0] = u_before is None
            pose = self._name_words(at, Measured(some_q, tip, angles), fresh, u_before or 0.0)
            u = project_unwrapped(path, at, pose, fresh, u_before or 0.0, self.reference.find_bounds(at))
            past = np.flatnonzero(u >= close)
            if len(past):
                return begin + int(past[0])
            u_before = float(u[-1])
        return len(q)

    # --- measuring ------------------------------------------------------------------------

    def _measure_progress(self, item: Ints, rest: Ints, segment: Ints, pose: Measured) -> Array:
        """Where on its segment (n,) each row is; on a dwell the start of the next segment, 1 after the last."""
        path = self.reference.path
        fresh = np.append(item[0] != self.last.item, item[1:] != item[:-1])
        u = project_unwrapped(path, segment, pose, fresh, self.last.u, self.reference.find_bounds(segment))
        return np.where(self.reference.items.segment[item] < 0, np.where(rest < len(path), 0.0, 1.0), u)

    def _measure(
        self, first: int, line: Ints, group: Ints, item: Ints, segment: Ints, u: Array, pose: Measured
    ) -> MeasuredRows:
        """Measure the steps to rows, of which ``first`` is the index of the first one, and remember the last row."""
        last, n = self.last, len(item)
        now = np.concatenate([pose.tip, RADIAN_MM * pose.angles], axis=1)
        before = np.vstack([now[:1] if last.pose is None else last.pose[None], now[:-1]])
        tool_length = self.reference.path.tool_length[segment]
        origin = self._change_tool(before, tool_length, pose.q)
        item_before, u_before = np.append(last.item, item[:-1]), np.append(last.u, u[:-1])
        entered = np.flatnonzero(item_before != item)
        rows = MeasuredRows(
            first,
            line,
            item,
            self.reference.items.segment[item] < 0,
            segment,
            u,
            item_before,
            u_before,
            pose,
            origin,
            now - origin,
            entered,
            np.diff(entered, prepend=-last.rows),
            self._find_touched(
                entered,
                item_before[entered],
                item[entered],
                self._place(item_before[entered], u_before[entered], before[entered]),
                self._place(item[entered], u[entered], now[entered]),
            ),
        )
        count = n - int(entered[-1]) if len(entered) else n + last.rows
        self.last = LastRow(
            int(item[-1]),
            float(u[-1]),
            int(group[-1]),
            int(line[-1]),
            count,
            float(tool_length[-1]),
            pose.q[-1],
            now[-1],
        )
        return rows

    def _change_tool(self, before: Array, tool_length: Array, q: Array) -> Array:
        """Poses ``before`` (n, 5) rows, with the tip of the rows' own tools (n,); joints (n, n_joints)."""
        last = self.last
        changed = np.flatnonzero(np.diff(tool_length, prepend=tool_length[0] if last.q is None else last.tool_length))
        if not len(changed):
            return before
        origin = before.copy()
        q_before = np.vstack([q[:1] if last.q is None else last.q[None], q[:-1]])
        origin[changed, :3] = self.forward(q_before[changed], tool_length[changed])[0]
        return origin

    def _place(self, item: Ints, u: Array, pose: Array) -> Array:
        """Share (n,) of its segment at which each pose (n, 5) is: ``u``, but by tolerances on straight segments.

        A corner of short moves may use all of an axis tolerance that is many times as long, in mm, as that of the tip.
        Then the nearest place by shares is not the nearest one by length.
        """
        reference, segment, place = self.reference, self.reference.items.segment[item], u.copy()
        straight = np.flatnonzero((item >= 0) & (segment >= 0) & (reference.path.kind[segment] == SegmentKind.LINE))
        on, tip, angles = segment[straight], pose[straight, :3], pose[straight, 3:] / RADIAN_MM
        some = Measured(tip, tip, angles, self._joints_by_axis)
        tip_bound = PATH_TIP_MM + reference.tip_tolerance[on]
        axis_bound = PATH_AXIS_DEG * RAD_PER_DEG + reference.axis_tolerance[on]
        place[straight] = project_onto_straight(reference.path, on, some, tip_bound / axis_bound)
        return place

    def _find_touched(self, row: Ints, old: Ints, new: Ints, old_u: Array, new_u: Array) -> Touched:
        """Segments that steps to rows (c,) touch, from one item to a later one."""
        items, has_tolerance = self.reference.items, self.reference.measures.has_tolerance
        begin = np.maximum(old, 0)
        step, within = number_parts(new - begin + 1)
        segment = items.segment[begin[step] + within]
        step, segment = step[segment >= 0], segment[segment >= 0]
        blended = np.zeros(len(row), dtype=bool)
        blended[step[has_tolerance[segment]]] = True
        step, segment = step[blended[step]], segment[blended[step]]
        first, last = np.diff(step, prepend=-1) != 0, np.diff(step, append=-1) != 0
        low = np.where(first, np.clip(old_u[step], 0.0, 1.0), 0.0)
        high = np.where(last, np.clip(new_u[step], 0.0, 1.0), 1.0)
        return Touched(row[step], segment, np.stack([low, high], axis=1))
