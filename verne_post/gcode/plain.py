"""Long stretches of plain straight moves, vectorised. Must agree with the general interpreter to the last bit.

A line is taken here when it has only N, G0 or G1, axis words and F, each at most once, and the modal
state is one in which such a line is nothing but a straight move in absolute coordinates.
"""

from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Mask
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.expressions import MAX_NUMBER
from verne_post.gcode.frame_codes import MAX_ANGLE_DEG, MAX_LENGTH_MM
from verne_post.gcode.motion_codes import MotionCodes, effective_feed, line_lengths
from verne_post.gcode.setup import Setup
from verne_post.gcode.state import State
from verne_post.gcode.words import WordTable
from verne_post.model.moves import AXES, FeedMode, MoveKind

#: Shorter stretches are cheaper in the general interpreter.
MIN_LINES: Final = 8
#: Stretches of so many lines gain nothing from the short way of those that are alike.
_LONG_STRETCH: Final = 1_000
_C, _F, _G, _N = 5, 9, 10, 11
_ROTARY: Final = [3, 4, 5]
_LINEAR: Final = [0, 1, 2, 6, 7, 8]


class PlainLines:
    """The plain lines of one chunk as dense tables, computed once for all stretches of it.

    The columns are the nine axes, F, G and N. ``plain`` is True for lines that may be executed from here; ``row`` is,
    for each line and column, the last line up to it that has the word (-1: none), ``filled`` that word; ``moves`` is
    True for lines that make a move (G0 or G1 alone: where ``bare_codes`` do), ``beyond_mm`` and ``beyond_inch`` for those with a coordinate beyond any machine.
    """

    def __init__(self, words: WordTable, setup: Setup, *, bare_codes: bool = True) -> None:
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
            size = np.abs(values)
            plain &= ~(values[:, _F] < 0) & ~(values[:, _N] < 0) & ~(size > MAX_NUMBER).any(axis=1)
            turned = (size[:, _ROTARY] > MAX_ANGLE_DEG).any(axis=1)
            self.beyond_mm = turned | (size[:, _LINEAR] > MAX_LENGTH_MM).any(axis=1)
            self.beyond_inch = turned | (size[:, _LINEAR] > MAX_LENGTH_MM / MM_PER_INCH).any(axis=1)
        # N must be the first word of its line
        has_n = np.flatnonzero(present[:, _N])
        first_word = np.searchsorted(words.row, has_n)
        plain[has_n[words.letter[first_word] != ord("N")]] = False
        self.plain, self.first_line = plain, words.first_line
        self.moves = present[:, :9].any(axis=1) | (present[:, _G] & bare_codes)
        self.row = np.where(present, np.arange(words.n_lines, dtype=np.int32)[:, None], np.int32(-1))
        np.maximum.accumulate(self.row, axis=0, out=self.row)
        self.filled = np.take_along_axis(values, np.maximum(self.row, 0), axis=0)
        self.beyond = self.beyond_mm | self.beyond_inch
        self._first_g = present[:, _G]

    @cached_property
    def alike(self) -> list[int]:
        """For every line the first one after it that makes no move, has another G code, or goes beyond any machine."""
        g = self.filled[:, _G]
        other = ~self.moves | self.beyond
        other[1:] |= self._first_g[1:] & ~(g[1:] == g[:-1])
        stops = np.append(np.flatnonzero(other), len(other))
        return stops[np.searchsorted(stops, np.arange(len(other)), side="right")].tolist()

    def ends(self) -> NDArray[np.intp]:
        """For every line the end (exclusive) of the stretch of plain lines that it stands in."""
        stops = np.append(np.flatnonzero(~self.plain), len(self.plain))
        return stops[np.searchsorted(stops, np.arange(len(self.plain)))]


def is_ready(state: State, lines: PlainLines, row: int) -> bool:
    """True when the modal state lets plain lines from ``row`` on be nothing but absolute straight moves."""
    return (
        state.absolute
        and (state.motion in (0, 10) or bool(lines.row[row, _G] == row))
        and state.held is None
        and not state.vectors
        and state.tool_axis is None
        and state.compensation is None
        and state.centre is None
        and not state.diameter_mode
        and not state.tcp_off
        and state.spline is None
    )


def execute(lines: PlainLines, first: int, last: int, codes: MotionCodes, shown_line: int | None = None) -> int:
    """Execute lines ``first`` to ``last`` (exclusive) as far as possible; returns the first line not done.

    ``shown_line`` is recorded in place of the line itself: that of the call, for lines of another file.
    """
    if last - first < _LONG_STRETCH and _execute_alike(lines, first, last, codes, shown_line):
        return last
    setup, state, recorder = codes.setup, codes.state, codes.recorder
    if not all(state.known[AXES.index(letter)] for letter in setup.axes):
        last = _until_known(lines, first, last, setup, state)
    scaled = state.inch and state.feed_mode != FeedMode.INVERSE
    given = lines.row[first:last] >= first
    filled = lines.filled[first:last]
    motion = np.where(given[:, _G], filled[:, _G], (state.motion or 0) / 10)
    angular = np.where(given[:, _F], filled[:, _F], state.feed_angular)
    feed = np.where(given[:, _F], filled[:, _F] * MM_PER_INCH if scaled else filled[:, _F], state.feed)
    moves = lines.moves[first:last]
    feeds = moves & (motion == 1)
    bad = _find_refused(lines, first, last, setup, state, feeds, feed)
    if bad is not None and bad.any():
        n = int(np.argmax(bad))  # the general interpreter names the error
        if n == 0:
            return first
        last = first + n
        given, filled, motion, moves, feed, angular = (
            given[:n],
            filled[:n],
            motion[:n],
            moves[:n],
            feed[:n],
            angular[:n],
        )

    words = filled[:, :9]
    if state.inch:
        words = words.copy()
        words[:, _LINEAR] *= MM_PER_INCH
    end = np.where(given[:, :9], words, state.position)
    shown = feed
    # without inches, and after an F in this unit, the feed of a turn is that of a move of the tip
    if state.feed_mode == FeedMode.INVERSE or scaled or state.feed != state.feed_angular:
        delta = np.diff(end, axis=0, prepend=[state.position])
        shown = effective_feed(state.feed_mode, feed, angular, *line_lengths(delta))
    rapid = motion == 0
    number = np.arange(lines.first_line + first, lines.first_line + last) if shown_line is None else None
    kind = np.where(rapid, MoveKind.RAPID, MoveKind.FEED)
    shown = np.where(rapid, np.nan, shown)
    if not moves.all():
        number = number[moves] if number is not None else None
        kind, shown, moved = kind[moves], shown[moves], end[moves]
    else:
        moved = end
    if number is None:
        number = np.full(len(kind), shown_line)
    recorder.add_many(state, number, kind, moved, shown)
    if recorder.fixes_c is None and given[-1, _C]:
        named = int(lines.first_line + first + np.argmax(given[:, _C]))
        recorder.fix_c(named if shown_line is None else shown_line)
    state.arc_may_follow = state.arc_may_follow or len(kind) > 0
    state.motion, state.cycle = 10 * int(motion[-1]), None
    state.feed, state.feed_angular = float(feed[-1]), float(angular[-1])
    state.position = end[-1].tolist()
    for axis in np.flatnonzero(given[-1, :9]).tolist():
        state.placed = True
        state.known[axis] = state.named[axis] = True
    return last


def _execute_alike(lines: PlainLines, first: int, last: int, codes: MotionCodes, shown_line: int | None) -> bool:
    """Execute lines with one G code, one feed rate, and no axis that the first of them does not name; False for any others.

    Stretches between other lines are often so, and too short for what :func:`execute` looks at.
    """
    state, recorder = codes.state, codes.recorder
    here, there = lines.row[first].tolist(), lines.row[last - 1].tolist()
    given = [row >= first for row in there]
    if (
        lines.alike[first] < last or lines.beyond[first] or not lines.moves[first]
        or [row == first for row in here[:_F]] != given[:_F] or (given[_F] and there[_F] != first) or (given[_G] and here[_G] != first)
        or False in state.known or state.inch or state.feed_mode != FeedMode.PER_MINUTE
        or (codes.setup.machine and not state.length_given)
    ):  # fmt: skip
        return False
    motion = 10 * int(lines.filled[first, _G]) if given[_G] else state.motion or 0
    feed = float(lines.filled[first, _F]) if given[_F] else state.feed
    if (motion == 10 and feed == 0.0) or (not given[_F] and feed != state.feed_angular):
        return False
    end = lines.filled[first:last, :_F].copy()
    for axis, named in enumerate(given[:_F]):
        if named:
            state.placed = state.named[axis] = True
        else:
            end[:, axis] = state.position[axis]
    kind, shown = (MoveKind.RAPID, np.nan) if motion == 0 else (MoveKind.FEED, feed)
    line = lines.first_line + first if shown_line is None else shown_line
    recorder.add_run(state, line, kind, end, shown, counted=shown_line is None)
    if given[_C]:
        recorder.fix_c(line)
    state.arc_may_follow = True
    state.motion, state.cycle = motion, None
    state.feed = state.feed_angular = feed
    state.position = end[-1].tolist()
    return True


def _find_refused(
    lines: PlainLines, first: int, last: int, setup: Setup, state: State, feeds: Mask, feed: Array
) -> Mask | None:
    """Lines that only the general interpreter may check; None where there are none."""
    bad = None
    if state.feed == 0 or not feed.all():
        bad = feeds & (feed == 0)
    if state.feed_mode == FeedMode.INVERSE:
        has_feed = lines.row[first:last, _F] == np.arange(first, last)
        bad = feeds & ~has_feed if bad is None else bad | (feeds & ~has_feed)
    if setup.machine:
        beyond = (lines.beyond_inch if state.inch else lines.beyond_mm)[first:last]
        turning = state.spindle_on and state.spindle_speed > 0
        if (state.feed_mode == FeedMode.PER_REVOLUTION and not turning) or not state.length_given:
            beyond = beyond | feeds
        bad = beyond if bad is None else bad | beyond
    return bad


def _until_known(lines: PlainLines, first: int, last: int, setup: Setup, state: State) -> int:
    """End of the lines up to and including the one after which every axis is known."""
    axes = [AXES.index(letter) for letter in setup.axes]
    known = np.array([state.known[axis] for axis in axes])
    complete = ((lines.row[first:last, axes] >= first) | known).all(axis=1)
    return first + int(np.argmax(complete)) + 1 if complete.any() else last
