"""Long stretches of plain moves, vectorised. Must agree with the general interpreter to the last bit.

A line is executed here when it has only N, G0 to G3, axis words, F and the words of an arc, each at most once, and when
it is nothing but a straight move or an arc in absolute coordinates in this modal state.
"""

import math
from bisect import bisect_left
from collections.abc import Callable
from functools import cache, cached_property
from typing import Final

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.units import MM_PER_INCH, SECONDS_PER_MINUTE
from verne_post.gcode import plain_arcs
from verne_post.gcode.lengths import find_effective_feed, measure_lengths
from verne_post.gcode.machining.machining import MOTION_LINES, Machining
from verne_post.gcode.machining.state import State
from verne_post.gcode.plain_arcs import PlainArcs
from verne_post.gcode.recorder import RunEnds
from verne_post.gcode.rs274.values import MAX_ANGLE_DEG, MAX_LENGTH_MM
from verne_post.gcode.setup import Setup
from verne_post.gcode.words import WordTable
from verne_post.model.moves import AXES, FeedMode, MoveKind

#: Shorter stretches are cheaper in the general interpreter.
MIN_LINES: Final = 8
#: Stretches of so many lines gain nothing from the short way of those that are alike.
_LONG_STRETCH: Final = 1_000
#: So many lines of a long stretch come first: where line after line is refused, each attempt costs no more than these.
_HEAD: Final = 32
_F, _G, _N = 9, 10, 11
#: What a line names, in one number: a bit for each axis, F and G.
_BITS: Final = 1 << np.arange(_G + 1)
_NOT_ALIKE: Final = (0, 0)
_LINEAR: Final = [0, 1, 2, 6, 7, 8]
_ROTARY: Final = [3, 4, 5]
#: Largest plausible number of each column, mm and degrees. After N come words of arcs, then all other letters.
_LIMIT: Final = np.array(
    [*[MAX_LENGTH_MM] * 3, *[MAX_ANGLE_DEG] * 3, *[MAX_LENGTH_MM] * 3, *[math.inf] * 3, *[MAX_LENGTH_MM] * 5]
)


#: Turns A and C of the ends (n, 9) of lines to their tool axes; returns the recorded ones (n, 3), or None.
Point = Callable[[int, Array], Array | None]


class PlainLines:
    """The plain lines of one chunk as dense tables, computed once for all stretches of it.

    The columns are the nine axes, F, G and N. ``offsets`` has other words of each line itself, NaN where it has none:
    I, J, K and R of arcs or of tool axes, or I, J, K in place of the tool axes of Siemens programs; it is None where no
    line has any. ``plain`` is True for lines that may be executed from here. ``row`` is, for each line and column, the
    last line up to it that has the word (-1: none), ``filled_words`` that word. ``moves`` is True for lines that make a
    move (a bare G0 or G1 counts with ``bare_codes``), ``beyond_mm`` and ``beyond_inch`` for those with a coordinate
    beyond any machine.
    """

    def __init__(self, words: WordTable, setup: Setup, *, bare_codes: bool = True, others: str = "") -> None:
        letters = words.letter.tobytes()
        has_others = any(letter.encode() in letters for letter in others)
        #: The other words are those of arcs.
        self.arcs = arcs = has_others and others == plain_arcs.WORDS
        columns = AXES + "FGN" + others * has_others
        unknown = len(columns)  # column of letters that have none
        column = bytearray([unknown]) * 256
        for place, letter in enumerate(columns):
            if letter in setup.axes or place >= len(AXES):
                column[ord(letter)] = place
        plain, row, value = words.plain.copy(), words.row, words.value
        which = np.frombuffer(letters.translate(bytes(column)), dtype=np.uint8)
        plain[row[which == unknown]] = False
        values = np.full((words.n_lines, unknown + 1), np.nan)
        values.reshape(-1)[row * (unknown + 1) + which] = value
        present = ~np.isnan(values)
        if np.count_nonzero(present) < len(value):  # a letter that appears twice
            plain &= present.sum(axis=1) == np.bincount(row, minlength=words.n_lines)
        g = values[:, _G]
        plain &= ~present[:, _G] | (g == 0) | (g == 1) | (arcs & ((g == 2) | (g == 3)))
        negative = value < 0
        if negative.any():
            plain[row[negative & ((which == _F) | (which == _N))]] = False
        self.beyond_mm, self.beyond_inch = self._find_beyond(which, row, np.abs(value), words.n_lines)
        # N must be the first word of its line
        has_n = np.flatnonzero(present[:, _N])
        first_word = np.searchsorted(words.row, has_n)
        plain[has_n[words.letter[first_word] != ord("N")]] = False
        self.plain, self.first_line = plain, words.first_line
        self.moves = present[:, :9].any(axis=1) | (present[:, _G] & bare_codes)
        self.offsets = values[:, _N + 1 : unknown] if has_others else None
        self.has_offsets = present[:, _N + 1 : unknown].any(axis=1)
        if has_others:
            self.moves |= present[:, _N + 1 : _N + 4].any(axis=1)
        self.row = np.full((words.n_lines, _N + 1), -1, dtype=np.int32)
        self.filled_words = np.full(self.row.shape, np.nan)
        numbers = np.arange(words.n_lines, dtype=np.int32)
        for at in np.flatnonzero(np.bincount(which[which <= _N], minlength=_N + 1)).tolist():
            last = np.maximum.accumulate(np.where(present[:, at], numbers, -1))
            self.row[:, at] = last
            self.filled_words[:, at] = values[np.maximum(last, 0), at]
        self._first_g = present[:, _G]

    @staticmethod
    def _find_beyond(which: NDArray[np.uint8], row: Ints, size: Array, n_lines: int) -> tuple[Mask, Mask]:
        """Lines with a coordinate beyond any machine, in mm and in inches; from columns, lines and sizes of words."""
        in_mm, in_inch = np.zeros(n_lines, dtype=bool), np.zeros(n_lines, dtype=bool)
        large = np.flatnonzero(size > min(MAX_LENGTH_MM / MM_PER_INCH, MAX_ANGLE_DEG))
        if len(large):
            row, size, limit = row[large], size[large], _LIMIT[which[large]]
            in_mm[row[size > limit]] = True
            in_inch[row[size > np.where(which[large] // 3 == 1, limit, limit / MM_PER_INCH)]] = True
        return in_mm, in_inch

    @cached_property
    def alike(self) -> dict[int, tuple[int, int]]:
        """Stretches with one G code, one feed rate, and no axis that the first line does not name.

        First line -> line after the last, and what the first line names, as :data:`_BITS`.
        """
        g = self.filled_words[:, _G]
        other = ~self.moves | self._beyond | self._is_curve
        other[1:] |= self._first_g[1:] & ~(g[1:] == g[:-1])
        begin = np.flatnonzero(self.plain & np.append(True, ~self.plain[:-1]))
        end = np.append(np.flatnonzero(~self.plain), len(self.plain))
        end = end[np.searchsorted(end, begin)]
        odd = np.append(np.flatnonzero(other), len(other))
        odd = odd[np.searchsorted(odd, begin + 1)]
        here, there = self.row[begin] == begin[:, None], self.row[end - 1] >= begin[:, None]
        good = ~other[begin] | (
            self._first_g[begin] & self.moves[begin] & ~self._beyond[begin] & ~self._is_curve[begin]
        )
        good &= (odd >= end) & (here[:, :_F] == there[:, :_F]).all(axis=1)
        good &= (self.row[end - 1, _F] <= begin) & (here[:, _G] | ~there[:, _G])
        named_bits = here[good, : _G + 1] @ _BITS
        return dict(zip(begin[good].tolist(), zip(end[good].tolist(), named_bits.tolist(), strict=True), strict=True))

    @cached_property
    def _beyond(self) -> Mask:
        return self.beyond_mm | self.beyond_inch

    @cached_property
    def _is_curve(self) -> Mask:
        """Lines that have words of an arc, or its code."""
        return self.has_offsets | (self._first_g & (self.filled_words[:, _G] >= 2)) if self.arcs else self.has_offsets

    @cached_property
    def _curves(self) -> list[int]:
        return [*np.flatnonzero(self._is_curve).tolist(), len(self.plain)]

    def find_next_curved(self, first: int) -> int:
        """The first line from ``first`` on that has words of an arc, or its code."""
        return self._curves[bisect_left(self._curves, first)]

    @cached_property
    def _odd(self) -> list[int]:
        return [*np.flatnonzero(~self.plain).tolist(), len(self.plain)]

    @cached_property
    def _turning(self) -> list[int]:
        here = self.row == np.arange(len(self.row))[:, None]
        return [*np.flatnonzero(here[:, _ROTARY].any(axis=1) & ~here[:, :3].all(axis=1)).tolist(), len(self.plain)]

    def find_turning(self, first: int) -> int:
        """The first line from ``first`` on that names a rotary axis, and not all of X, Y and Z."""
        return self._turning[bisect_left(self._turning, first)]

    def find_first_named(self, first: int, last: int, columns: list[int]) -> int:
        """The first line from ``first`` on that names one of the axes, or ``last``."""
        if last <= first or (self.row[last - 1, columns] < first).all():
            return last
        return first + int((self.row[first:last, columns] >= first).any(axis=1).argmax())

    def end(self, first: int) -> int:
        """The first line from ``first`` on that is not plain, or the number of lines."""
        return self._odd[bisect_left(self._odd, first)]


@cache
def _find_named_words(bits: int) -> tuple[Mask, tuple[int, ...], bool, bool]:
    """Axes that a line names, as a mask and as numbers, and whether it has F and G; from :data:`_BITS`."""
    named_columns = np.array([bits >> column & 1 for column in range(_G + 1)], dtype=bool)
    return (
        named_columns[:_F],
        tuple(np.flatnonzero(named_columns[:_F]).tolist()),
        bool(named_columns[_F]),
        bool(named_columns[_G]),
    )


class PlainView(Struct):
    """What the modes of a language make of plain lines."""

    #: Code of motion, times ten, of lines that give none; afterwards that of the last line which has been
    #: executed.
    motion: int | None = None
    inch: bool = False
    arcs: bool = True  #: Words of arcs are nothing but an incremental centre or a radius.
    has_tool_axes: bool = False  #: Every line gives the tool axis anew.
    turning: bool = True  #: Lines that turn the table and name not all of X, Y and Z are nothing but moves.


def is_ready(state: State, view: PlainView, lines: PlainLines, row: int) -> bool:
    """True when plain lines from ``row`` on are nothing but absolute straight moves and arcs."""
    arcs = lines.arcs and _may_curve(state, view)
    return (
        (view.motion in (0, 10) or (arcs and view.motion in (20, 30)) or bool(lines.row[row, _G] == row))
        and state.values_before_length is None
        and (view.has_tool_axes or state.tool_axis is None)
        and state.compensation is None
        and state.centre is None
        and not state.tcp_off
    )


def _may_curve(state: State, view: PlainView) -> bool:
    """True where arcs may be executed at once: feed rates are those of the tip."""
    return view.arcs and state.feed_mode != FeedMode.INVERSE and False not in state.known_axes


def turn_to_axes(core: Machining, end: Array, axes: Array) -> None:
    """Turn the rotary axes of the ends (n, 9) of lines, in place, to their tool axes (n, 3), which are unit vectors."""
    state, (tilt, turn) = core.state, core.setup.rotary
    words = state.position[tilt], state.position[turn]
    end[:, [tilt, turn]] = core.setup.coordinates.turn_to_axes(words, axes, state.frame)
    if core.setup.machine:
        state.has_position = state.named_axes[tilt] = state.named_axes[turn] = True


def execute(
    lines: PlainLines,
    first: int,
    last: int,
    core: Machining,
    view: PlainView,
    point: Point | None = None,
) -> int:
    """Execute lines ``first`` to ``last`` (exclusive) as far as possible; returns the first line not done.

    ``view`` has the motion of the last one afterwards.

    ``point`` takes the tool axes of lines that all have one.
    """
    if point is None:
        core.hold_tool_axis(None)  # A and C of these lines are words, also after those of vectors
    head = first + _HEAD
    if last - first > _LONG_STRETCH:
        stretch = _execute(lines, first, head, core, view, point)
        if stretch < head:
            return stretch
        first = head
    return _execute(lines, first, last, core, view, point)


def _execute(
    lines: PlainLines,
    first: int,
    last: int,
    core: Machining,
    view: PlainView,
    point: Point | None,
) -> int:
    if point is None and last - first < _LONG_STRETCH and _execute_alike(lines, first, last, core, view):
        return last
    setup, state, recorder = core.setup, core.state, core.recorder
    if point is None and lines.offsets is not None and not (lines.arcs and _may_curve(state, view)):
        last = min(last, lines.find_next_curved(first))
        if last == first:
            return first
    if False in state.known_axes:
        last = _cut_before_named(lines, first, last, state)
        if last == first:
            return first
    is_scaled = view.inch and state.feed_mode != FeedMode.INVERSE
    given = lines.row[first:last] >= first
    filled_words = lines.filled_words[first:last]
    motion = np.where(given[:, _G], filled_words[:, _G], (view.motion or 0) / 10)
    angular = np.where(given[:, _F], filled_words[:, _F], state.feed_angular)
    feed = np.where(given[:, _F], filled_words[:, _F] * MM_PER_INCH if is_scaled else filled_words[:, _F], state.feed)
    moves = lines.moves[first:last]
    feeds = moves & (motion >= 1)
    words = filled_words[:, :9]
    if view.inch:
        words = words.copy()
        words[:, _LINEAR] *= MM_PER_INCH
    end = np.where(given[:, :9], words, state.position)
    bad = _find_refused(lines, first, last, setup, state, view, feeds, feed)
    if core.warns_of_idle_feed or core.doubts_rapid_feeds:  # the general interpreter looks at F in a block of a rapid
        numbers = np.arange(first, last)
        row = lines.row[first:last]
        is_told = np.where(row[:, _G] == numbers, core.doubts_rapid_feeds, core.warns_of_idle_feed)
        idle = moves & (motion == 0) & (row[:, _F] == numbers) & is_told
        bad = idle if bad is None else bad | idle
    arcs = None if point is not None else _find_arcs(lines, first, last, moves, motion, end, state, view)
    if arcs is not None:
        bad = arcs[1] if bad is None else bad | arcs[1]
    if bad is not None and bad.any():
        n = int(np.argmax(bad))  # the general interpreter names the error
        if n == 0:
            return first
        last = first + n
        given, motion, moves, feed, angular, end = (column[:n] for column in (given, motion, moves, feed, angular, end))
    tool_axes = None if point is None else point(first, end)
    shown_feed = feed
    # without inches, and after an F in this unit, the feed of a turn is that of a move of the tip
    if state.feed_mode == FeedMode.INVERSE or is_scaled or state.feed != state.feed_angular:
        delta = np.diff(end, axis=0, prepend=[state.position])
        shown_feed = find_effective_feed(state.feed_mode, feed, angular, *measure_lengths(delta))
    rapid = motion == 0
    number = np.arange(lines.first_line + first, lines.first_line + last)
    kind = np.where(rapid, MoveKind.RAPID, MoveKind.FEED)
    shown_feed = np.where(rapid, np.nan, shown_feed)
    is_timed = state.feed_mode == FeedMode.INVERSE
    seconds = np.where(rapid, np.nan, SECONDS_PER_MINUTE / np.where(rapid, 1.0, feed))[moves] if is_timed else np.nan
    straight, curves = len(kind) > 0, None
    if arcs is not None:
        is_arc = motion >= 2
        kind[is_arc], shown_feed[is_arc] = MoveKind.ARC, feed[is_arc]
        straight = bool((moves & ~is_arc).any())
        curves = arcs[0].select_before(len(motion), state.plane)
    if not moves.all():
        number, kind, shown_feed, moved_ends = number[moves], kind[moves], shown_feed[moves], end[moves]
    else:
        moved_ends = end
    if given[-1, _F]:
        core.has_zero_feed = bool(feed[-1] == 0.0)
    if recorder.lacks_feed and given[-1, _F]:
        recorder.note_feed(recorder.count + int(np.count_nonzero(moves[: int(np.argmax(given[:, _F]))])))
    recorder.add_many(state, number, kind, moved_ends, shown_feed, curves, tool_axes, seconds)
    turn = core.setup.rotary[1]
    if recorder.fixes_c is None and given[-1, turn]:
        first_named = int(lines.first_line + first + np.argmax(given[:, turn]))
        recorder.fix_c(first_named)
    state.arc_may_follow = state.arc_may_follow or straight
    view.motion = 10 * int(motion[-1])
    if given[-1, _G] and (name := MOTION_LINES.get(view.motion)):
        own_line = int(lines.first_line + lines.row[last - 1, _G])
        core.word_lines[name] = recorder.lines.number(own_line)
    state.feed, state.feed_angular = float(feed[-1]), float(angular[-1])
    state.position = end[-1].tolist()
    for axis in np.flatnonzero(given[-1, :9]).tolist():
        state.has_position = state.named_axes[axis] = True
    return last


def _find_arcs(
    lines: PlainLines, first: int, last: int, moves: Mask, motion: Array, end: Array, state: State, view: PlainView
) -> tuple[PlainArcs, Mask] | None:
    """Arcs among lines, and the lines that only the general interpreter may execute; None where there is neither."""
    if not lines.arcs or (lines.find_next_curved(first) >= last and view.motion in (0, 10)):
        return None
    assert lines.offsets is not None
    is_arc = moves & (motion >= 2)
    offsets = lines.offsets[first:last]
    arcs = plain_arcs.find_arcs(
        offsets[is_arc], motion[is_arc] == 2, np.flatnonzero(is_arc), end, state, inch=view.inch
    )
    bad = ~is_arc & lines.has_offsets[first:last]
    bad[arcs.row] = arcs.refused_rows
    if not state.arc_may_follow:
        bad |= is_arc & (np.cumsum(moves & ~is_arc) == 0)
    return arcs, bad


def _execute_alike(lines: PlainLines, first: int, last: int, core: Machining, view: PlainView) -> bool:
    """Execute lines with one G code, one feed rate, and only axes that the first line names; False for others.

    Stretches between other lines are often so, and too short for what :func:`execute` looks at.
    """
    state = core.state
    end_of_alike, bits = lines.alike.get(first, _NOT_ALIKE)
    if (
        end_of_alike < last
        or False in state.known_axes
        or view.inch
        or state.feed_mode != FeedMode.PER_MINUTE
        or (core.setup.machine and not state.has_tool_length)
    ):
        return False
    mask, axes, has_feed, has_code = _find_named_words(bits)
    motion = 10 * int(lines.filled_words[first, _G]) if has_code else view.motion or 0
    feed = float(lines.filled_words[first, _F]) if has_feed else state.feed
    if motion == 0 and has_feed and (core.doubts_rapid_feeds if has_code else core.warns_of_idle_feed):
        return False
    if motion > 10 or (motion == 10 and feed == 0.0) or (not has_feed and feed != state.feed_angular):
        return False
    end = RunEnds(lines.filled_words[first:last, :_F], mask, state.position)
    ends_at, final = state.position.copy(), lines.filled_words[last - 1].tolist()
    for axis in axes:
        ends_at[axis] = final[axis]
        state.has_position = state.named_axes[axis] = True
    kind, shown_feed = (MoveKind.RAPID, math.nan) if motion == 0 else (MoveKind.FEED, feed)
    if has_feed:
        core.has_zero_feed = feed == 0.0
        core.recorder.note_feed()
    core.recorder.add_run(state, lines.first_line + first, kind, end, shown_feed)
    if core.setup.rotary[1] in axes:
        core.recorder.fix_c(lines.first_line + first)
    state.arc_may_follow = True
    view.motion = motion
    if has_code and (name := MOTION_LINES.get(motion)):
        core.word_lines[name] = core.recorder.lines.number(lines.first_line + first)
    state.feed = state.feed_angular = feed
    state.position = ends_at
    return True


def _find_refused(
    lines: PlainLines, first: int, last: int, setup: Setup, state: State, view: PlainView, feeds: Mask, feed: Array
) -> Mask | None:
    """Lines that only the general interpreter may check; None where there are none."""
    bad = None
    if state.feed == 0 or not feed.all():
        bad = feeds & (feed == 0)
    if state.feed_mode == FeedMode.INVERSE:
        has_feed = lines.row[first:last, _F] == np.arange(first, last)
        bad = feeds & ~has_feed if bad is None else bad | (feeds & ~has_feed)
    if setup.machine:
        beyond = (lines.beyond_inch if view.inch else lines.beyond_mm)[first:last]
        turning = state.spindle_on and state.spindle_speed > 0 and not state.surface_speed
        if (state.feed_mode == FeedMode.PER_REVOLUTION and not turning) or not state.has_tool_length:
            beyond = beyond | feeds
        bad = beyond if bad is None else bad | beyond
    return bad


def _cut_before_named(lines: PlainLines, first: int, last: int, state: State) -> int:
    """End of the lines before the first that names a new axis, which the general interpreter executes."""
    if state.first_places is not None and not all(state.is_known(axis) == state.known_axes[axis] for axis in range(9)):
        return first  # axes that are never named wait for the first move
    unknown_axes = [axis for axis, is_known in enumerate(state.known_axes) if not is_known]
    fresh = (lines.row[first:last, unknown_axes] >= first).any(axis=1)
    return first + int(np.argmax(fresh)) if fresh.any() else last
