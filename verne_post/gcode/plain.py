"""Long stretches of plain straight moves, vectorised. Must agree with the general interpreter to the last bit.

A line is taken here when it has only N, G0 or G1, axis words and F, each at most once, and the modal
state is one in which such a line is nothing but a straight move in absolute coordinates.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.expressions import MAX_NUMBER
from verne_post.gcode.frame_codes import MAX_ANGLE_DEG, MAX_LENGTH_MM
from verne_post.gcode.motion_codes import effective_feed, line_lengths
from verne_post.gcode.scan import WordTable
from verne_post.gcode.state import Recorder, Setup, State
from verne_post.model.moves import AXES, FeedMode, MoveKind

Array = NDArray[np.float64]

#: Shorter stretches are cheaper in the general interpreter.
MIN_LINES: Final = 8
_C, _F, _G, _N = 5, 9, 10, 11
_ROTARY: Final = [3, 4, 5]


class PlainLines:
    """The plain lines of one scanned chunk as a dense table.

    ``values`` has one row a line and one column each for the nine axes, F, G and N; NaN where the
    word is absent. ``plain`` is True for lines that may be executed from it.
    """

    def __init__(self, words: WordTable, setup: Setup) -> None:
        column = np.full(256, -1, dtype=np.int8)
        for place, letter in enumerate(AXES):
            if letter in setup.axes:
                column[ord(letter)] = place
        column[[ord("F"), ord("G"), ord("N")]] = _F, _G, _N
        which = column[words.letter]
        usable = which >= 0
        values = np.full((words.n_lines, 12), np.nan)
        values[words.row[usable], which[usable]] = words.value[usable]
        present = ~np.isnan(values)
        count = np.bincount(words.row, minlength=words.n_lines)
        plain = words.plain & (present.sum(axis=1) == count)  # no other letter, none twice
        g = values[:, _G]
        plain &= ~present[:, _G] | (g == 0) | (g == 1)
        with np.errstate(invalid="ignore"):
            plain &= ~(values[:, _F] < 0) & ~(values[:, _N] < 0) & ~(np.abs(values) > MAX_NUMBER).any(axis=1)
        # N must be the first word of its line
        first_word = np.searchsorted(words.row, np.arange(words.n_lines))
        has_n = np.flatnonzero(present[:, _N])
        plain[has_n[words.letter[first_word[has_n]] != ord("N")]] = False
        self.values, self.present, self.plain = values, present, plain
        self.first_line = words.first_line

    def ends(self) -> Array:
        """For every line the end (exclusive) of the stretch of plain lines that it stands in."""
        stops = np.append(np.flatnonzero(~self.plain), len(self.plain))
        return stops[np.searchsorted(stops, np.arange(len(self.plain)))]


def ready(state: State) -> bool:
    """True when the modal state lets plain lines be nothing but absolute straight moves."""
    return (
        state.absolute
        and state.motion in (0, 10)
        and state.held is None
        and not state.vectors
        and state.vector is None
        and state.compensation is None
        and state.centre is None
        and not state.diameter_mode
        and not state.tcp_off
    )


def execute(
    lines: PlainLines,
    first: int,
    last: int,
    setup: Setup,
    state: State,
    recorder: Recorder,
    shown_line: int | None = None,
) -> int:
    """Execute lines ``first`` to ``last`` (exclusive) as far as possible; returns the first line not done.

    ``shown_line`` is recorded in place of the line itself: that of the call, for lines of another file.
    """
    values, present = lines.values[first:last], lines.present[first:last]
    n = last - first
    if not all(state.known[AXES.index(letter)] for letter in setup.axes):
        n = _until_known(present, setup, state)
        values, present = values[:n], present[:n]
    motion = _fill(values[:, _G], present[:, _G], (state.motion or 0) / 10)
    has_axes = present[:, :9].any(axis=1)
    moves = has_axes | present[:, _G]
    feeds = moves & (motion == 1)
    linear = np.where(np.isnan(values[:, _F]), 0.0, values[:, _F])
    if state.inch and state.feed_mode != FeedMode.INVERSE:
        linear = linear * MM_PER_INCH
    feed = _fill(linear, present[:, _F], state.feed)
    angular = _fill(values[:, _F], present[:, _F], state.feed_angular)
    bad = feeds & (feed == 0)
    if setup.machine:  # a coordinate beyond any machine
        linear_words = values[:, [axis for axis in range(9) if axis not in _ROTARY]]
        bound = MAX_LENGTH_MM / MM_PER_INCH if state.inch else MAX_LENGTH_MM
        with np.errstate(invalid="ignore"):
            bad |= (np.abs(linear_words) > bound).any(axis=1) | (np.abs(values[:, _ROTARY]) > MAX_ANGLE_DEG).any(axis=1)
    if state.feed_mode == FeedMode.INVERSE:
        bad |= feeds & ~present[:, _F]
    elif (
        state.feed_mode == FeedMode.PER_REVOLUTION
        and setup.machine
        and not (state.spindle_on and state.spindle_speed > 0)
    ):
        bad |= feeds
    if setup.machine and not state.length_said:
        bad |= feeds
    if bad.any():
        n = int(np.argmax(bad))  # the general interpreter names the error
        if n == 0:
            return first
        values, present, motion = values[:n], present[:n], motion[:n]
        moves, feed, angular = moves[:n], feed[:n], angular[:n]

    end = np.empty((n, 9))
    for axis in range(9):
        column = values[:, axis]
        if state.inch and axis not in _ROTARY:
            column = column * MM_PER_INCH
        end[:, axis] = _fill(column, present[:, axis], state.position[axis])
    delta = np.diff(end, axis=0, prepend=[state.position])
    shown = effective_feed(state.feed_mode, feed, angular, *line_lengths(delta))
    rapid = motion == 0
    rows = np.flatnonzero(moves)
    number = lines.first_line + first + rows if shown_line is None else np.full(len(rows), shown_line)
    recorder.add_many(
        state,
        number,
        np.where(rapid, MoveKind.RAPID, MoveKind.FEED)[rows],
        end[rows],
        np.where(rapid, np.nan, shown)[rows],
    )
    if present[:n, _C].any():
        named = int(lines.first_line + first + np.argmax(present[:n, _C]))
        recorder.fix_c(named if shown_line is None else shown_line)
    state.motion = 10 * int(motion[-1])
    state.arc_may_follow = state.arc_may_follow or bool(moves.any())
    state.feed, state.feed_angular = float(feed[-1]), float(angular[-1])
    state.position = [float(v) for v in end[-1]]
    for axis, seen in enumerate(present[:, :9].any(axis=0)):
        if seen:
            state.placed = True
            state.known[axis] = state.named[axis] = True
    return first + n


def _until_known(present: NDArray[np.bool_], setup: Setup, state: State) -> int:
    """Number of lines up to and including the one after which every axis is known."""
    axes = [AXES.index(letter) for letter in setup.axes]
    known = np.array([state.known[axis] for axis in axes])
    seen = np.logical_or.accumulate(present[:, axes], axis=0) | known
    complete = seen.all(axis=1)
    return int(np.argmax(complete)) + 1 if complete.any() else len(present)


def _fill(values: Array, present: NDArray[np.bool_], before: float) -> Array:
    """Carry the last present value forward; ``before`` stands in front of the first one."""
    index = np.where(present, np.arange(1, len(values) + 1), 0)
    np.maximum.accumulate(index, out=index)
    return np.append(before, values)[index]
