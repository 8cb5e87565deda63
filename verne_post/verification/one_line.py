"""Which of several segments of one source line rows belong to, where the motion goes on without a stop."""

from collections.abc import Callable
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.ragged import number_parts
from verne_post.base.rows import measure_rows
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.model.toolpath import SegmentKind
from verne_post.verification.axis_words import name_poses
from verne_post.verification.matching import match_places
from verne_post.verification.programmed import RADIAN_MM, find_tool_axis
from verne_post.verification.projection import Measured, measure_off_segment, project_onto_straight, project_unwrapped
from verne_post.verification.reference import Reference

#: Joints (n, n_joints) and tool lengths (n,) -> tip (n, 3), nominal angles (n, 2), true tool axis (n, 3), ok (n,).
Forward = Callable[[Array, Array], tuple[Array, Array, Array, Mask]]

#: Rows that are placed together, at most: where they are is known from the last one of those before.
_TOGETHER: Final = 128
#: The path is longer than steps along it, since corners are cut: by so many tolerances and this share of the steps.
_TOLERANCES: Final = 8.0
_LONGER: Final = 0.3
#: Rows farther than so many bounds from what was chosen for them show that the choice has gone astray.
_NEAR: Final = 2.0
#: After so many single rows that are no nearer, rows are placed together again: they are not on this path.
_ASTRAY: Final = 8
#: Costs of a candidate, in mm by which the way to it differs from the row's step: per mm of the step at the bound of
#: the tolerance, and per bound that it is beyond. Random programs of one line: below 16, acute corners are left too
#: late; 1 and 100 beyond the bound place alike.
_AT_BOUND: Final = 16.0
_BEYOND: Final = 100.0
_JUST_WITHIN: Final = 0.99


def place_rows(
    reference: Reference, forward: Forward, q: Array, last: tuple[int, float, Array], end: int, *, by_axis: bool
) -> Ints:
    """Item of each row of joint values (n, n_joints), ascending; at least up to the first one on the last item.

    Parameters
    ----------
    last : int, float, ndarray (5,)
        Item on which the row before is, its u there, and its tip (mm) and angles (times RADIAN_MM).
    end : int
        The last item that may be reached. The machine does not stand still before those after the first one.
    by_axis : bool
        The joints tell the tool axis, and not which words hold it.
    """
    items, path = reference.items, reference.path
    item, u, pose = last
    place = items.joint_length_before[item] + min(max(u, 0.0), 1.0) * (
        items.joint_length_before[item + 1] - items.joint_length_before[item]
    )
    result = np.empty(len(q), dtype=np.int64)
    begin, count, astray = 0, _TOGETHER, 0
    while begin < len(q):
        some = q[begin : begin + count]
        tip, angles, _axis, _ok = forward(some, np.full(len(some), path.tool_length[items.segment[item]]))
        now = np.concatenate([tip, RADIAN_MM * angles], axis=1)
        measured = Measured(some, tip, angles, by_axis)
        step = measure_rows(np.diff(_find_motion(now, by_axis), axis=0, prepend=_find_motion(pose[None], by_axis)))
        chosen, places, near = _choose(reference, measured, place, step, item, end)
        if not near and len(some) > 1 and astray < _ASTRAY:  # what is expected has gone astray: fewer at a time
            count = max(len(some) // 4, 1)
            continue
        astray = 0 if near else astray + 1
        # what comes next decides too: only a part of them is settled
        settled = len(some) if begin + len(some) == len(q) else max(len(some) * 3 // 4, 1)
        result[begin : begin + settled] = chosen[:settled]
        item, place, pose = int(chosen[settled - 1]), float(places[settled - 1]), now[settled - 1]
        begin += settled
        if chosen[0] == end:
            break
        count = min(2 * count, _TOGETHER)
    return result[:begin]


def _find_motion(pose: Array, by_axis: bool) -> Array:
    """What steps between poses (n, 5) are measured by: tip and angles, or tip and tool axis; mm."""
    if not by_axis:
        return pose
    return np.concatenate([pose[:, :3], RADIAN_MM * find_tool_axis(pose[:, 3:] / RADIAN_MM)], axis=1)


def _choose(
    reference: Reference, pose: Measured, place: float, step: Array, first: int, end: int
) -> tuple[Ints, Array, bool]:
    """Items and places (n,) of rows, by length, after ``place`` and steps (n,); whether all are within bounds."""
    items, path = reference.items, reference.path
    segments = items.segment[first : end + 1]
    tip_bound, axis_bound = reference.find_bounds(segments)
    expected = place + np.cumsum(step)
    aside = _TOLERANCES * (tip_bound + RADIAN_MM * axis_bound).max() + step.max() + _LONGER * np.cumsum(step)
    starts = items.joint_length_before[first + 1 : end + 1]
    low, high = (np.searchsorted(starts, edge, side="right") for edge in (expected - aside, expected + aside))
    row, within = number_parts(high - low + 1)
    item = first + low[row] + within
    segment, many, fresh = items.segment[item], pose.select(row), np.ones(len(row), dtype=bool)
    if pose.by_axis:
        many = name_poses(path, segment, many, reference.words_bound, (fresh, 0.0))
    u = project_unwrapped(path, segment, many, fresh, 0.0, None)
    on_line = np.flatnonzero(path.kind[segment] == SegmentKind.LINE)
    weight = (tip_bound / axis_bound)[(item - first)[on_line]]
    u[on_line] = project_onto_straight(path, segment[on_line], many.select(on_line), weight)
    begin, length = (
        items.joint_length_before[item],
        items.joint_length_before[item + 1] - items.joint_length_before[item],
    )
    on_arc = np.flatnonzero(path.kind[segment] == SegmentKind.ARC)
    if len(on_arc):  # arcs of a whole turn and more
        turn = 2.0 * np.pi / np.abs(path.arcs.sweep[path.arc[segment[on_arc]]])
        guess = np.clip((expected[row] - begin)[on_arc] / np.maximum(length[on_arc], ZERO_LENGTH_MM), 0.0, 1.0)
        u[on_arc] += turn * np.round((guess - u[on_arc]) / turn)
    u = np.clip(u, 0.0, 1.0)
    where = begin + u * length
    tip, axis, rotary = measure_off_segment(path, segment, u, many)
    off = np.maximum(tip / tip_bound[item - first], np.maximum(axis, rotary) / axis_bound[item - first])
    cost = _AT_BOUND * step[row] * off**2 + _BEYOND * np.maximum(off - _JUST_WITHIN, 0.0)
    first_of_row = np.append(np.flatnonzero(within == 0), len(row))
    found = match_places(item, where, cost, first_of_row, place, step)
    return item[found], where[found], bool((off[found] <= _NEAR).all())
