"""Feed rates of drilling cycles that the machine cannot reach (VP505)."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.base.columns import iterate_blocks
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.tolerances import ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.model.findings import Finding, make_finding
from verne_post.model.machine import Machine
from verne_post.model.moves import FeedMode, Moves
from verne_post.model.plausibility import PLAUSIBLE
from verne_post.model.toolpath import SegmentKind, ToolPath

#: Drills and reamers are fed less a turn, mm.
_TURN_FEED: Final = 2.0
#: Above the limit by more than rounding.
_ABOVE: Final = 1.001
#: The feed rate of a thread is its pitch a turn, as shares: it is rounded.
_OF_PITCH: Final = (0.99, 1.01)


def check_hole_feeds(moves: Moves, path: ToolPath, machine: Machine, from_move: int) -> Iterator[Finding]:
    """VP505: a drilling cycle at a feed rate that the velocity limits of the joints exclude; one finding a program.

    Links and retracts may have any feed rate, and so may the way down in a hole that is drilled so far. So only moves
    down along the tool count that the next move leaves upwards, with more than 2 mm a turn of a turning spindle.
    """
    is_fast = (moves.feed_mode == FeedMode.PER_MINUTE) & (moves.spindle > 0)
    is_fast &= (moves.feed > _TURN_FEED * moves.spindle) & (moves.feed <= PLAUSIBLE["feed rate"].high)
    is_fast[:from_move] = False
    if not is_fast.any():
        return
    is_fast &= moves.find_of_cycles()
    pitches = np.unique([tap.pitch for tap in moves.taps])
    for begin, end in iterate_blocks(len(path)):
        rows = _find_plunges(path, begin, min(end, len(path) - 1))
        if not len(rows := rows[is_fast[path.move[rows]]]):
            continue
        feeds = moves.feed[path.move[rows]]
        turns = feeds / moves.spindle[path.move[rows]]
        lower, upper = (np.searchsorted(pitches, share * turns) for share in _OF_PITCH)
        highest = _find_highest_feeds(path, machine, rows)
        above = np.flatnonzero((feeds > _ABOVE * highest) & (lower == upper))  # a pitch has a finding of its own
        for at in above[:1].tolist():
            word = "FEDRAT" if moves.language == "aptcl" else "F"
            text = (
                f"{word} is {feeds[at]:.10g} mm/min in this drilling cycle, {turns[at]:.3g} mm a turn, and the joints "
                f"of the machine allow {highest[at]:.6g} mm/min on average in this hole: is a digit too many?"
            )
            yield make_finding("VP505", text, severity="warning", line=int(moves.line[path.move[rows[at]]]))
            return


def _find_plunges(path: ToolPath, begin: int, end: int) -> Ints:
    """Rows of straight feed moves down along a tool that does not turn, before one of the same line that goes up."""
    start, finish = path.start[begin : end + 1], path.end[begin : end + 1]
    delta: Array = finish[:, :3] - start[:, :3]
    axis = find_axis_of_angles(finish[:, 3], finish[:, 4])
    up = (delta * axis).sum(axis=1)
    is_along = np.abs(delta - up[:, None] * axis).max(axis=1) <= ZERO_LENGTH_MM
    is_along &= np.abs(finish[:, 3:] - start[:, 3:]).max(axis=1) <= ZERO_ANGLE
    is_straight = (path.kind[begin : end + 1] == SegmentKind.LINE) & (path.move[begin : end + 1] >= 0)
    is_cut = is_straight & is_along & (path.feed_time[begin : end + 1] > 0) & ~path.free[begin : end + 1]
    down, line = is_cut & (up < -ZERO_LENGTH_MM), path.line[begin : end + 1]
    goes_up = is_along & (up > ZERO_LENGTH_MM)
    return np.flatnonzero(down[:-1] & goes_up[1:] & (line[:-1] == line[1:])) + begin


def _find_highest_feeds(path: ToolPath, machine: Machine, rows: Ints) -> Array:
    """The mean feed rates (mm/min) of rows whose slowest joint goes all the way at its velocity limit."""
    first, last = (
        machine.five_axis.solve(poses[:, :3], poses[:, 3:], path.tool_length[rows])[0]
        for poses in (path.start[rows], path.end[rows])
    )
    seconds = (np.abs(last - first) / machine.limits.velocity).max(axis=1)
    ways = np.linalg.norm(path.end[rows, :3] - path.start[rows, :3], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(seconds > 0, 60.0 * ways / seconds, np.inf)
