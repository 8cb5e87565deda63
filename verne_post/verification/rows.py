"""Rows as they are checked: each matched with an item of the program, and measured once for all checks.

A row is matched by its source line. Where several items share a line, the progress along them decides.
"""

from collections.abc import Callable
from itertools import pairwise
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.ragged import ragged
from verne_post.base.rows import row_norm
from verne_post.base.tolerances import PATH_AXIS_DEG, PATH_TIP_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.setpoints import SetpointBlock
from verne_post.model.toolpath import SegmentKind
from verne_post.verification.projection import RADIAN_MM, Measured, straight_u, unwrapped_u
from verne_post.verification.reference import Reference

#: Joints (n, n_joints) and tool lengths (n,) -> tip (n, 3), nominal angles (n, 2), true tool axis (n, 3), ok (n,).
Forward = Callable[[Array, Array], tuple[Array, Array, Array, Mask]]

#: Rows looked at together when several segments share a source line.
_LOOK_AHEAD: Final = 1024


class Touched(Struct, frozen=True, eq=False):
    """Segments that steps between two items touch, where a corner of one of them may be rounded; m in order.

    Attributes
    ----------
    row, segment : ndarray of int, shape (m,)
    part : ndarray, shape (m, 2)
        Between which u the step passes the segment, from 0 to 1.
    """

    row: Ints
    segment: Ints
    part: Array


class MeasuredRows(Struct, frozen=True, eq=False):
    """Consecutive rows (n,), and the steps that lead to them. The first row of a file has a step of length 0.

    Attributes
    ----------
    first : int
        Index of the first row in the file.
    line, item : ndarray of int, shape (n,)
    dwell : ndarray of bool, shape (n,)
        The item is a dwell.
    segment : ndarray of int, shape (n,)
        Of the item; where it is a dwell, the next segment (the last one, where none comes).
    u : ndarray, shape (n,)
        Where on its segment a row is, from 0 to 1; not limited.
    item_before, u_before : ndarray, shape (n,)
        Of the row before; -1 before the first row of a file.
    origin, step : ndarray, shape (n, 5)
        Tip (mm) and angles (times RADIAN_MM) of the row before, and their change to this row. The tip is that of this row's
        tool: where the tool length changes, the machine does not move.
    axis_step : ndarray, shape (n,)
        Angle by which the tool axis turns, rad.
    entered : ndarray of int, shape (c,)
        Rows that are the first of their item.
    rows_before : ndarray of int, shape (c,)
        How many rows the item before those had.
    touched : Touched
        By the steps to ``entered``.
    """

    first: int
    line: Ints
    item: Ints
    dwell: Mask
    segment: Ints
    u: Array
    item_before: Ints
    u_before: Array
    pose: Measured
    origin: Array
    step: Array
    axis_step: Array
    entered: Ints
    rows_before: Ints
    touched: Touched


class LastRow(Struct, frozen=True, eq=False):
    """Where the last row was.

    ``rows`` counts the rows of its item so far; ``q`` (n_joints,), ``pose`` (5,) and ``axis`` (3,) are None before the first
    row of a file.
    """

    item: int = -1
    u: float = 0.0
    group: int = -1
    line: int = -2
    rows: int = 0
    tool_length: float = 0.0
    q: Array | None = None
    pose: Array | None = None
    axis: Array | None = None


class LostPath(Struct, frozen=True):
    """Why the rows of a block cannot be followed from ``row`` on."""

    row: int
    code: str
    text: str


class RowMatcher:
    """Matches a stream of rows with the items of a program, and measures them.

    Attributes
    ----------
    forward : callable
        (q, tool_length) -> tip, nominal angles, ok.
    """

    def __init__(self, reference: Reference, forward: Forward) -> None:
        self.reference, self.forward = reference, forward
        #: The largest angle between the true tool axis and that of the nominal angles so far, rad.
        self.axis_error = 0.0
        self.last = LastRow()

    def match(self, block: SetpointBlock) -> tuple[MeasuredRows | None, LostPath | None]:
        """Measure the next rows, up to one that cannot be followed.

        Returns
        -------
        rows : MeasuredRows or None
            None where not even the first row can be followed.
        lost : LostPath or None
        """
        group, lost = self._groups(block.line.astype(np.int64))
        if not len(group):
            return None, lost
        items, path = self.reference.items, self.reference.path
        q = block.values[: len(group)] / self.reference.factor
        item: Ints = items.group_first[group]
        several = items.group_first[group + 1] - item > 1
        if several.any():
            item = self._split_groups(q, group, item, several)
        rest = items.rest_segment[item]
        segment = np.minimum(rest, len(path) - 1)
        tip, angles, axis, ok = self.forward(q, path.tool_length[segment])
        if not ok.all():
            n = int(np.argmin(ok))
            lost = LostPath(n, "VP411", ": the joint values close no position of the platform")
            if not n:
                return None, lost
            group, item, rest, segment = group[:n], item[:n], rest[:n], segment[:n]
            q, tip, angles, axis = q[:n], tip[:n], angles[:n], axis[:n]
        pose = Measured(q, tip, angles)
        # what no angle of the axes corrects: the true axis against that of the nominal angles
        self.axis_error = max(self.axis_error, float(row_norm(axis - pose.axis).max()))
        u = self._progress(item, rest, segment, pose)
        return self._measure(block, group, item, segment, u, pose), lost

    # --- matching -------------------------------------------------------------------------

    def _groups(self, line: Ints) -> tuple[Ints, LostPath | None]:
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
            hop = self._skipped(int(group[row]), int(line[row]))
            if hop is None:
                where = f"line {expected[row]}" if not beyond[row] else "the end"
                hint = (
                    "; line 0 is an approach or a departure: give the --from and --to of the conversion"
                    if not line[row]
                    else ""
                )
                text = f" belongs to line {line[row]}, where the program has {where}{hint}"
                return group[:row], LostPath(row, "VP413", text)
            group[row:] += hop

    def _skipped(self, group: int, line: int) -> int | None:
        """How many whole groups of one section were passed between two rows; None if the line does not follow."""
        items = self.reference.items
        for hop in range(1, len(items.group_line) - group):
            first = items.group_first[group + hop]
            if items.stop_before[items.group_first[group] : first].any():
                return None
            if items.group_line[group + hop] == line:
                return hop
        return None

    def _split_groups(self, q: Array, group: Ints, item: Ints, several: Mask) -> Ints:
        """Item of its group that each row belongs to, where groups have several items."""
        items, item = self.reference.items, item.copy()
        edges = np.flatnonzero(np.diff(group, prepend=-1, append=-1))
        for begin, end in pairwise(edges.tolist()):
            if not several[begin]:
                continue
            now, last = (int(items.group_first[group[begin] + k]) - k for k in (0, 1))
            rows, u = 0, None
            if begin == 0 and group[0] == self.last.group:
                now, rows, u = self.last.item, self.last.rows, self.last.u
            row = begin
            while row < end:
                if now == last:
                    item[row:end] = now
                    break
                if items.segment[now] < 0:
                    take = min(int(items.dwell_cycles[now]) - rows, end - row)
                else:
                    take = self._rows_of_item(q[row:end], now, u)
                item[row : row + take] = now
                row += take
                now, u, rows = now + 1, None, 0
        return item

    def _rows_of_item(self, q: Array, item: int, u_before: float | None) -> int:
        """How many of the next rows lie before the end of a segment; ``u_before`` is None if the row before is not on it."""
        path = self.reference.path
        segment = int(self.reference.items.segment[item])
        close = 1.0 - self.reference.noise.tip / self.reference.measures.motion_length[segment]
        for begin in range(0, len(q), _LOOK_AHEAD):
            some_q = q[begin : begin + _LOOK_AHEAD]
            at = np.full(len(some_q), segment)
            tip, angles, _axis, _ok = self.forward(some_q, path.tool_length[at])
            fresh = np.zeros(len(some_q), dtype=bool)
            fresh[0] = u_before is None
            u = unwrapped_u(path, at, Measured(some_q, tip, angles), fresh, u_before or 0.0)
            past = np.flatnonzero(u >= close)
            if len(past):
                return begin + int(past[0])
            u_before = float(u[-1])
        return len(q)

    # --- measuring ------------------------------------------------------------------------

    def _progress(self, item: Ints, rest: Ints, segment: Ints, pose: Measured) -> Array:
        """Where on its segment (n,) each row is; on a dwell the start of the next segment, 1 after the last."""
        path = self.reference.path
        fresh = np.append(item[0] != self.last.item, item[1:] != item[:-1])
        u = unwrapped_u(path, segment, pose, fresh, self.last.u)
        return np.where(self.reference.items.segment[item] < 0, np.where(rest < len(path), 0.0, 1.0), u)

    def _measure(
        self, block: SetpointBlock, group: Ints, item: Ints, segment: Ints, u: Array, pose: Measured
    ) -> MeasuredRows:
        """Measure the steps to rows, and remember the last row."""
        last, n = self.last, len(item)
        now = np.concatenate([pose.tip, RADIAN_MM * pose.angles], axis=1)
        axis = pose.axis
        before = np.vstack([now[:1] if last.pose is None else last.pose[None], now[:-1]])
        tool_length = self.reference.path.tool_length[segment]
        origin = self._with_new_tool(before, tool_length, pose.q)
        axis_before = np.vstack([axis[:1] if last.axis is None else last.axis[None], axis[:-1]])
        item_before, u_before = np.append(last.item, item[:-1]), np.append(last.u, u[:-1])
        entered = np.flatnonzero(item_before != item)
        rows = MeasuredRows(
            block.first, block.line[:n], item, self.reference.items.segment[item] < 0, segment, u, item_before, u_before,
            pose, origin, now - origin, row_norm(axis - axis_before), entered, np.diff(entered, prepend=-last.rows),
            self._touched(
                entered, item_before[entered], item[entered],
                self._place(item_before[entered], u_before[entered], before[entered]),
                self._place(item[entered], u[entered], now[entered]),
            ),
        )  # fmt: skip
        count = n - int(entered[-1]) if len(entered) else n + last.rows
        self.last = LastRow(
            int(item[-1]), float(u[-1]), int(group[-1]), int(block.line[n - 1]), count, float(tool_length[-1]), pose.q[-1],
            now[-1], axis[-1],
        )  # fmt: skip
        return rows

    def _with_new_tool(self, before: Array, tool_length: Array, q: Array) -> Array:
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
        """Where on its segment (n,) each of some poses (n, 5) is by the shares of the tolerances: ``u`` but for straight segments.

        A corner of short moves may use all of an axis tolerance that is many times as long, in mm, as that of the tip. Then
        another place is the nearest one by shares than by length.
        """
        reference, segment, place = self.reference, self.reference.items.segment[item], u.copy()
        straight = np.flatnonzero((item >= 0) & (segment >= 0) & (reference.path.kind[segment] == SegmentKind.LINE))
        on, tip, angles = segment[straight], pose[straight, :3], pose[straight, 3:] / RADIAN_MM
        tip_bound = PATH_TIP_MM + reference.tip_tolerance[on]
        axis_bound = PATH_AXIS_DEG * RAD_PER_DEG + reference.axis_tolerance[on]
        place[straight] = straight_u(reference.path, on, tip, angles, tip_bound / axis_bound)
        return place

    def _touched(self, row: Ints, old: Ints, new: Ints, old_u: Array, new_u: Array) -> Touched:
        """Segments that steps to rows (c,) touch, from one item to a later one."""
        items, has_tolerance = self.reference.items, self.reference.measures.has_tolerance
        begin = np.maximum(old, 0)
        step, within = ragged(new - begin + 1)
        segment = items.segment[begin[step] + within]
        step, segment = step[segment >= 0], segment[segment >= 0]
        blended = np.zeros(len(row), dtype=bool)
        blended[step[has_tolerance[segment]]] = True
        step, segment = step[blended[step]], segment[blended[step]]
        first, last = np.diff(step, prepend=-1) != 0, np.diff(step, append=-1) != 0
        low = np.where(first, np.clip(old_u[step], 0.0, 1.0), 0.0)
        high = np.where(last, np.clip(new_u[step], 0.0, 1.0), 1.0)
        return Touched(row[step], segment, np.stack([low, high], axis=1))
