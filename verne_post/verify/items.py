"""What rows are judged against: the segments and dwells of a program in order, and what each asks for.

An *item* is a segment or a dwell; a *group* are neighbouring items of one source line, as rows name no more than that.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from verne_post.base.columns import Growing, GrowingTable, blocks, running_sums
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.model.contour import Contour
from verne_post.verify.projection import RADIAN_MM, chord_lengths, paces

Array = NDArray[np.float64]
Ints = NDArray[np.integer]
Mask = NDArray[np.bool_]

#: A dwell this close above a whole number of cycles is that number (in cycles).
_WHOLE_CYCLE = 1e-9


@dataclass(frozen=True, eq=False)
class SegmentMeasures:
    """What each segment (n,) is measured by.

    Attributes
    ----------
    rounded : ndarray of bool
        The motion may be some way from the segment.
    chord_length : ndarray
        See :func:`~verne_post.verify.projection.chord_lengths`, mm.
    told_by : ndarray
        Shortest motion that the segment can be told by, mm; along a great circle A and C turn unevenly, the axis evenly.
    corner_u : ndarray
        What a corner within its tolerance may add to a projection, as a share of the segment.
    tip_pace, turn_pace, swing_pace : ndarray
        See :func:`~verne_post.verify.projection.paces`.
    """

    rounded: Mask
    chord_length: Array
    told_by: Array
    corner_u: Array
    tip_pace: Array
    turn_pace: Array
    swing_pace: Array


def segment_measures(contour: Contour) -> SegmentMeasures:
    """Measures of the programmed segments of a contour."""
    table = GrowingTable(rounded=(bool,), chord_length=(float,), told_by=(float,), corner_u=(float,),
                         tip_pace=(float,), turn_pace=(float,), swing_pace=(float,))  # fmt: skip
    for begin, end in blocks(len(contour.path)):
        path = contour.path.part(begin, end)
        tip, axis = contour.tip_tolerance[begin:end], contour.axis_tolerance[begin:end]
        chord = chord_lengths(path)
        tip_pace, turn_pace, swing_pace = paces(path)
        table.extend(
            rounded=(tip > 0) | (axis > 0),
            chord_length=chord,
            told_by=np.maximum(np.where(chord > 0, chord, path.length), ZERO_LENGTH_MM),
            corner_u=(tip + RADIAN_MM * axis) / np.maximum(chord, ZERO_LENGTH_MM),
            tip_pace=tip_pace,
            turn_pace=turn_pace,
            swing_pace=swing_pace,
        )
    return SegmentMeasures(**table.columns())


@dataclass(frozen=True, eq=False)
class Items:
    """Segments and dwells in order, m of them in g groups.

    Attributes
    ----------
    segment : ndarray of int32, shape (m,)
        -1 for a dwell.
    rest_segment : ndarray of int32, shape (m,)
        The segment itself, or the next one behind a dwell; the number of segments where there is none.
    line : ndarray of int64, shape (m,)
    dwell_cycles : ndarray of int64, shape (m,)
        No fewer rows than these, 0 for a segment.
    stop_before : ndarray of bool, shape (m,)
        The machine stands still before the item.
    stops_before : ndarray of int64, shape (m + 1,)
        How many such there are before each item.
    time_before, way_before : ndarray, shape (m + 1,)
        Seconds at the programmed feed, and way (mm), of all before each item.
    group_first : ndarray of int64, shape (g + 1,)
        First item of each group, and m.
    group_line : ndarray of int64, shape (g,)
    """

    segment: Ints
    rest_segment: Ints
    line: Ints
    dwell_cycles: Ints
    stop_before: Mask
    stops_before: Ints
    time_before: Array
    way_before: Array
    group_first: Ints
    group_line: Ints


def items_of(contour: Contour, chord_length: Array, cycle: float) -> Items:
    """The items of a contour, whose segments are so long (n,); a dwell lasts a whole number of cycles (s)."""
    path, n = contour.path, len(contour.path)
    order = np.argsort(path.dwell_segment, kind="stable")
    behind = path.dwell_segment[order]  # a dwell comes before the segment with its number
    dwell_at = behind + np.arange(len(behind))
    cycles = np.maximum(np.ceil(path.dwell_seconds / cycle - _WHOLE_CYCLE), 1)[order]
    dwell_line = path.dwell_line[order]
    table = GrowingTable(segment=(np.int32,), rest_segment=(np.int32,), line=(np.int64,), dwell_cycles=(np.int64,),
                         stop_before=(bool,), time=(float,), way=(float,))  # fmt: skip
    first_of_group = Growing(np.int64)
    section_before, line_before = -1, -1
    for begin, end in blocks(n + len(behind)):
        item = np.arange(begin, end)
        number = np.searchsorted(dwell_at, item)  # of dwells before
        dwell = np.flatnonzero(np.append(dwell_at, -1)[np.minimum(number, len(dwell_at))] == item)
        rest = item - number
        rest[dwell] = behind[number[dwell]]
        segment = rest.copy()
        segment[dwell] = -1
        moving = np.flatnonzero(segment >= 0)
        own = segment[moving]
        line, waits, section = np.empty(len(item), np.int64), np.zeros(len(item)), np.full(len(item), -1)
        line[moving], line[dwell] = path.line[own], dwell_line[number[dwell]]
        waits[dwell] = cycles[number[dwell]]
        section[moving] = contour.section[np.searchsorted(contour.segment, own)]
        time, way = np.zeros(len(item)), np.zeros(len(item))
        time[moving], way[moving] = path.feed_time[own], chord_length[own]
        stops = (section < 0) | (section != np.append(section_before, section[:-1]))
        table.extend(
            segment=segment, rest_segment=rest, line=line, dwell_cycles=waits, stop_before=stops, time=time, way=way
        )
        first_of_group.extend(item[line != np.append(line_before, line[:-1])])
        section_before, line_before = int(section[-1]), int(line[-1])
    columns = table.columns()
    time, way = columns.pop("time"), columns.pop("way")
    first_of_group.extend(np.array([n + len(behind)]))
    group_first = first_of_group.column()
    group_line = Growing(np.int64)
    for begin, end in blocks(len(group_first) - 1):
        group_line.extend(columns["line"][group_first[begin:end]])
    return Items(
        **columns, stops_before=running_sums(columns["stop_before"]), time_before=running_sums(time),
        way_before=running_sums(way), group_first=group_first, group_line=group_line.column(),
    )  # fmt: skip
