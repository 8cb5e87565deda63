"""What rows are checked against: the segments and dwells of a program in order, and what each asks for.

An *item* is a segment or a dwell; a *group* are neighbouring items of one source line, as rows name no more than that.
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.columns import Growing, GrowingTable, iterate_blocks, sum_running
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import WHOLE_CYCLE, ZERO_LENGTH_MM
from verne_post.model.contour import Contour
from verne_post.model.toolpath import ToolPath
from verne_post.verification.programmed import (
    RADIAN_MM,
    find_tip_paces,
    measure_metric_lengths,
    measure_progress_lengths,
)

#: Arcs whose radius is fewer tolerances are tight: seen from the centre, places within the tolerance of their ends may
#: be in any direction. At 4 they are still in that of their place, within 1 % of the tolerance.
_TIGHT: Final = 4.0
#: Places of a segment at which the motion of its tool axis is measured: its length is a share of places of rows.
_PLACES: Final = 5


class SegmentMeasures(Struct, frozen=True, eq=False):
    """What each segment (n,) is measured by."""

    has_tolerance: Mask  #: The motion may leave the segment, near rounded corners.
    metric_length: Array  #: See :func:`~verne_post.verification.programmed.measure_metric_lengths`, mm.
    #: Length of which the progress along the segment is a share, mm: the metric length; on splines that of the
    #: tip; that of the path where the metric one is 0. Never below ZERO_LENGTH_MM.
    motion_length: Array
    blend_u: Array  #: What a corner within its tolerance may add to a projection, as a share of the segment.
    tip_pace: Array  #: See :func:`~verne_post.verification.programmed.find_tip_paces`.
    joint_length: Array  #: Metric length, in which C counts by what it moves the axis where joints tell no more, mm.


def measure_segments(contour: Contour, *, by_axis: bool = False) -> SegmentMeasures:
    """Measure the programmed segments of a contour; ``by_axis`` where joints tell the tool axis alone."""
    table = GrowingTable(
        has_tolerance=(bool,), metric_length=(float,), motion_length=(float,), blend_u=(float,), tip_pace=(float,)
    )
    joint_length = Growing(float)
    for begin, end in iterate_blocks(len(contour.path)):
        path = contour.path.take_part(begin, end)
        tip, axis = contour.tip_tolerance[begin:end], contour.axis_tolerance[begin:end]
        length = measure_metric_lengths(path)
        progress = measure_progress_lengths(path, length)
        if by_axis:
            progress = np.minimum(progress, _measure_axis_lengths(path, progress))
        table.extend(
            has_tolerance=(tip > 0) | (axis > 0),
            metric_length=length,
            motion_length=np.maximum(np.where(progress > 0, progress, path.length), ZERO_LENGTH_MM),
            blend_u=np.maximum(
                (tip + RADIAN_MM * axis) / np.maximum(progress, ZERO_LENGTH_MM),
                _find_turns_of_tight_arcs(path, tip, axis),
            ),
            tip_pace=find_tip_paces(path),
        )
        if by_axis:
            joint_length.extend(_measure_joint_lengths(path, length))
    columns = table.freeze()
    return SegmentMeasures(**columns, joint_length=joint_length.freeze() if by_axis else columns["metric_length"])


def _measure_axis_lengths(path: ToolPath, length: Array) -> Array:
    """Length (n,) of tip and tool axis along segments at least, where C counts by what it moves the axis, mm."""
    turn = RADIAN_MM * np.abs(path.end[:, 3:] - path.start[:, 3:])
    tip = np.sqrt(np.maximum(length**2 - (turn**2).sum(axis=1), 0.0))
    lean = np.abs(np.sin([path.start[:, 3], path.end[:, 3]])).min(axis=0)
    return np.asarray(np.sqrt(tip**2 + turn[:, 0] ** 2 + (lean * turn[:, 1]) ** 2))


def _measure_joint_lengths(path: ToolPath, metric_length: Array) -> Array:
    """Length (n,) of tip and tool axis along segments, where C counts by what it moves the axis, mm."""
    turn = RADIAN_MM * np.abs(path.end[:, 3:] - path.start[:, 3:])
    tip = np.maximum(metric_length**2 - (turn**2).sum(axis=1), 0.0)
    share = (np.arange(_PLACES) + 0.5) / _PLACES
    lean = np.sin(path.start[:, 3, None] + share * (path.end[:, 3] - path.start[:, 3])[:, None])
    pace = np.sqrt(tip[:, None] + turn[:, :1] ** 2 + (lean * turn[:, 1:]) ** 2)
    return np.asarray(np.where(path.circle >= 0, metric_length, pace.mean(axis=1)))


def _find_turns_of_tight_arcs(path: ToolPath, tip_tolerance: Array, axis_tolerance: Array) -> Array:
    """A whole turn as a share of segments (n,) that are arcs hardly larger than their tolerance; 0 for the others.

    It is at least 1 for arcs that neither rise nor turn the axes by more than the tolerance: their turns look alike.
    """
    turns = np.zeros(len(path))
    on_arc = np.flatnonzero(path.arc >= 0)
    arcs, row = path.arcs, path.arc[on_arc]
    tight = np.minimum(arcs.r0, arcs.r1)[row] < _TIGHT * tip_tolerance[on_arc]
    on_arc, row = on_arc[tight], row[tight]
    turn = np.abs(path.end[on_arc, 3:] - path.start[on_arc, 3:]).max(axis=1, initial=0.0)
    flat = (measure_rows(arcs.rise[row]) <= tip_tolerance[on_arc]) & (turn <= axis_tolerance[on_arc])
    turns[on_arc] = np.maximum(2.0 * np.pi / np.abs(arcs.sweep[row]), flat)
    return turns


class Items(Struct, frozen=True, eq=False):
    """Segments and dwells in order, m of them in g groups."""

    segment: Ints  #: (m,): -1 for a dwell.
    #: (m,): The segment itself, or the next one after a dwell; the number of segments where there is none.
    rest_segment: Ints
    line: Ints  #: (m,)
    dwell_cycles: Ints  #: (m,): No fewer rows than these, 0 for a segment.
    stop_before: Mask  #: (m,): The machine stands still before the item.
    stops_before: Ints  #: (m + 1,): How many such there are before each item.
    #: time_before, length_before (m + 1,): Seconds at the programmed feed, and metric length (mm), of all before
    #: each item.
    time_before: Array
    length_before: Array
    #: (m + 1,): As ``length_before``, of what the joints tell: see ``joint_length`` of :class:`SegmentMeasures`.
    joint_length_before: Array
    group_first: Ints  #: (g + 1,): First item of each group, and m.
    group_line: Ints  #: (g,)
    #: (g,) or (0,): The next group of the same line, where the machine does not stand still before it; else -1.
    #: Empty where no line comes back.
    next_group: Ints

    def count_stops_between(self, old: Ints, new: Ints) -> Ints:
        """How many standstills (n,) there are from items to later ones, that before the later one included."""
        return self.stops_before[new + 1] - self.stops_before[old + 1]

    def measure_passed(self, old: Ints, new: Ints, old_u: Array, new_u: Array) -> tuple[Ints, Array, Array, Mask]:
        """What steps pass from u of items (n,), -1 before the first, to u of later items (n,).

        Returns
        -------
        begun : ndarray of int, shape (n,)
            The earlier item; 0 before the first.
        left, came : ndarray, shape (n,)
            Share of the earlier item that is passed, 0 before the first; share of the later one.
        whole : ndarray of bool, shape (n,)
            No standstill has been left out.
        """
        left = np.where(old >= 0, np.maximum(1.0 - old_u, 0.0), 0.0)
        whole = self.count_stops_between(old, new) <= self.stop_before[new]
        return np.maximum(old, 0), left, np.maximum(new_u, 0.0), whole


def list_items(contour: Contour, measures: SegmentMeasures, cycle: float) -> Items:
    """List the items of a contour, whose segments are measured; a dwell lasts whole cycles (s)."""
    path, n = contour.path, len(contour.path)
    order = np.argsort(path.dwell_segment, kind="stable")
    next_segment = path.dwell_segment[order]  # a dwell comes before the segment with its number
    dwell_at = next_segment + np.arange(len(order))
    cycles = np.maximum(np.ceil(path.dwell_seconds / cycle - WHOLE_CYCLE), 1)[order]
    dwell_line = path.dwell_line[order]
    table = GrowingTable(
        segment=(np.int32,),
        rest_segment=(np.int32,),
        line=(np.int64,),
        dwell_cycles=(np.int64,),
        stop_before=(bool,),
        time=(float,),
        length=(float,),
    )
    is_by_axis, joint_length = measures.joint_length is not measures.metric_length, Growing(float)
    first_of_group = Growing(np.int64)
    section_before, line_before = -1, -1
    for begin, end in iterate_blocks(n + len(order)):
        item = np.arange(begin, end)
        number = np.searchsorted(dwell_at, item)  # of dwells before
        dwell = np.flatnonzero(np.append(dwell_at, -1)[np.minimum(number, len(dwell_at))] == item)
        rest = item - number
        rest[dwell] = next_segment[number[dwell]]
        segment = rest.copy()
        segment[dwell] = -1
        moving = np.flatnonzero(segment >= 0)
        moved = segment[moving]
        line, waits, section = np.empty(len(item), np.int64), np.zeros(len(item)), np.full(len(item), -1)
        line[moving], line[dwell] = path.line[moved], dwell_line[number[dwell]]
        waits[dwell] = cycles[number[dwell]]
        section[moving] = contour.section[np.searchsorted(contour.segment, moved)]
        time, length = np.zeros(len(item)), np.zeros(len(item))
        time[moving], length[moving] = path.feed_time[moved], measures.metric_length[moved]
        stops = (section < 0) | (section != np.append(section_before, section[:-1]))
        table.extend(
            segment=segment,
            rest_segment=rest,
            line=line,
            dwell_cycles=waits,
            stop_before=stops,
            time=time,
            length=length,
        )
        if is_by_axis:
            lengths = np.zeros(len(item))
            lengths[moving] = measures.joint_length[moved]
            joint_length.extend(lengths)
        first_of_group.extend(item[line != np.append(line_before, line[:-1])])
        section_before, line_before = int(section[-1]), int(line[-1])
    columns = table.freeze()
    time, length = columns.pop("time"), sum_running(columns.pop("length"))
    first_of_group.extend(np.array([n + len(order)]))
    group_first = first_of_group.freeze()
    group_line = Growing(np.int64)
    for begin, end in iterate_blocks(len(group_first) - 1):
        group_line.extend(columns["line"][group_first[begin:end]])
    line, stops = group_line.freeze(), sum_running(columns["stop_before"])
    return Items(
        **columns,
        stops_before=stops,
        time_before=sum_running(time),
        length_before=length,
        joint_length_before=sum_running(joint_length.freeze()) if is_by_axis else length,
        group_first=group_first,
        group_line=line,
        next_group=_find_next_of_line(line, group_first, stops),
    )


def _find_next_of_line(line: Ints, first: Ints, stops_before: Ints) -> Ints:
    """``next_group`` of :class:`Items`, from its ``group_line``, ``group_first`` and ``stops_before``."""
    if (line[1:] > line[:-1]).all():
        return np.zeros(0, dtype=np.int64)
    result = np.full(len(line), -1)
    order = np.argsort(line, kind="stable")
    again = np.flatnonzero(line[order[1:]] == line[order[:-1]])
    group, later = order[again], order[again + 1]
    moving = stops_before[first[later] + 1] == stops_before[first[group + 1]]
    result[group[moving]] = later[moving]
    return result
