"""The recorder: turns executed motion, dwells and events into a Moves table."""

import dataclasses
import math
from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from itertools import groupby
from typing import Any, Final, NamedTuple, Protocol

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Mask
from verne_post.base.columns import BLOCK_ROWS, GrowingTable, release_memory
from verne_post.base.units import SECONDS_PER_MINUTE
from verne_post.gcode.arcs import Arc
from verne_post.gcode.line_counter import LineCounter
from verne_post.gcode.program_error import write_before
from verne_post.model.codes import CODES
from verne_post.model.findings import Finding, Remedy, make_finding
from verne_post.model.moves import (
    AXES,
    MOVE_COLUMNS,
    ZERO9,
    ArcFeed,
    ArcFeedUse,
    Arcs,
    CallSpan,
    Event,
    FeedMode,
    Frame,
    MoveKind,
    Moves,
    PathControl,
    PlaneCall,
    Selection,
    Stock,
    TablePlace,
    Tap,
)
from verne_post.model.splines import GrowingSplines, Splines
from verne_post.model.verdict import Severity

#: In place of a tool axis where A and C words hold.
_NO_TOOL_AXIS: Final = (np.nan, np.nan, np.nan)
#: Types of the columns after line, kind, end and feed, which a block of moves may share.
_SHARED_TYPES: tuple[type, ...] = tuple(dtype for dtype, *_width in list(MOVE_COLUMNS.values())[4:])
#: The columns that moves of a run share.
_SHARED_BY_RUNS: Final = tuple(name for name in MOVE_COLUMNS if name not in ("line", "end"))
#: Of a block of moves: their places in the table; line, kind, end, feed; of each other column one value, or one a row.
_Block = tuple[slice | NDArray[np.int64], NDArray[np.int32], NDArray[np.int8], Array, Array, Sequence[Any]]
_ARC_LAYOUT: dict[str, tuple[Any, ...]] = {
    "plane": (np.int8,),
    "center": (float, 3),
    "turns": (np.int32,),
    "sweep": (float,),
}
#: Rows that are kept one by one, before they become arrays; cutter compensation amends the last few.
_KEPT_ROWS = 50_000

#: What ends a tilted plane, as messages call it -> as it is written; the table stays.
ENDS_OF_PLANES: Final = {"G69": "G69", "CYCLE800()": "CYCLE800()", "PLANE RESET": "PLANE RESET STAY"}


class Modes(Protocol):
    """The modal state recorded with every motion; :class:`~verne_post.gcode.machining.state.State` implements it."""

    frame: Frame
    feed: float
    feed_mode: FeedMode
    control: PathControl
    spindle_speed: float
    spindle_on: bool
    surface_speed: bool
    tool_axis: tuple[float, float, float] | None


class ArcRows(NamedTuple):
    """Arcs of one plane and one turn each: centres (n, 3), sweeps in degrees (n,), number of the plane."""

    center: Array
    sweep: Array
    plane: int


class Row(NamedTuple):
    """One motion or dwell as it is recorded; the columns of :class:`~verne_post.model.moves.Moves`."""

    line: int
    kind: int
    end: list[float]
    feed: float
    feed_mode: int
    spindle: float
    frame: int
    control: int
    arc: int
    spline: int
    tool_axis: tuple[float, ...]
    seconds: float


class RunEnds(NamedTuple):
    """Ends of straight moves: words (n, 9), which axes (9,) have them, and where the other axes stand."""

    words: Array
    named_axes: Mask
    rest: list[float]


class _Run(NamedTuple):
    """Straight moves that share all but their ends.

    ``place`` is that of the first; ``counted``: the lines count up with the moves; ``shared`` are all other columns.
    """

    place: int
    line: int
    is_counted: bool
    end: RunEnds
    shared_columns: tuple[Any, ...]


def _find_repeated_values(runs: list[_Run], blocks: list[_Block]) -> dict[str, Any]:
    """Find the columns that have one value in all moves of runs and blocks, and that value."""
    rows = [columns for columns, _runs in groupby(run.shared_columns for run in runs)]
    rows += [(kind, feed, *shared_columns) for _place, _line, kind, _end, feed, shared_columns in blocks]
    found = {}
    for name, values in zip(_SHARED_BY_RUNS, zip(*rows, strict=True), strict=False):
        first = values[0]
        if not any(isinstance(value, np.ndarray) for value in values) and all(v is first or v == first for v in values):
            found[name] = first
    return found


def _fill_runs(part: dict[str, NDArray[Any]], runs: list[_Run], first: int) -> None:
    """Write runs into some columns of a table from the move ``first`` on; gaps between them are not kept."""
    for shared_columns, group in groupby(runs, key=lambda run: run.shared_columns):
        alike = list(group)
        rows = slice(alike[0].place - first, alike[-1].place + len(alike[-1].end.words) - first)
        for name, value in zip(_SHARED_BY_RUNS, shared_columns, strict=True):
            if name in part:
                part[name][rows] = value
        for place, line, is_counted, (words, named_words, rest), _shared_columns in alike:
            rows = slice(place - first, place - first + len(words))
            part["line"][rows] = np.arange(line, line + len(words)) if is_counted else line
            end = part["end"][rows]
            end[:] = rest
            np.copyto(end, words, where=named_words)


class Recorder(Struct):
    """Collects motion row by row or block by block, and freezes it into a Moves table."""

    blocks: list[_Block] = field(default_factory=list)
    runs: list[_Run] = field(default_factory=list)
    rows: list[Row] = field(default_factory=list)
    #: Place of each of those rows in the table.
    places: list[int] = field(default_factory=list)
    arcs: list[Arc] = field(default_factory=list)
    frames: dict[Frame, int] = field(default_factory=dict)
    controls: dict[PathControl, int] = field(default_factory=dict)
    #: The lines that first say how corners are passed, while another file is executed; 0 in the program itself.
    control_lines: dict[PathControl, int] = field(default_factory=dict)
    events: list[Event] = field(default_factory=list)
    #: Warnings by line, counted in its own file, and code: of a line that is executed again, they are counted.
    warnings: dict[tuple[int, str], Finding] = field(default_factory=dict)
    #: First line that names C, or sends X or Y to machine coordinates.
    fixes_c: int | None = None
    #: As in Moves; in RS274 codes say it.
    tcp_changes: list[int] = field(default_factory=lambda: [0])
    tcp_ends: list[PlaneCall] = field(default_factory=list)
    calls: list[CallSpan] = field(default_factory=list)
    lines: LineCounter = field(default_factory=LineCounter)
    needs_tcp_code: bool = False
    selections: list[Selection] = field(default_factory=list)
    read_tools: set[int] = field(default_factory=set)
    radius_tools: set[int] = field(default_factory=set)
    compensated_lines: dict[tuple[int, int], str] = field(default_factory=dict)
    planes: list[PlaneCall] = field(default_factory=list)
    speeds: list[tuple[int, int]] = field(default_factory=list)
    turn_feeds: list[tuple[int, int]] = field(default_factory=list)
    taps: dict[tuple[int | None, float], Tap] = field(default_factory=dict)
    #: Number of the next move at the first feed rate that is given after each change of tools.
    feeds: list[int] = field(default_factory=list)
    lacks_feed: bool = False  #: True from a change of tools to that.
    changes: int = 0  #: Of tools, so far.
    #: By that number: the move of the last F beside a rapid that a cut may use, and what is told if none does.
    idle_feeds: dict[int, tuple[int, Finding]] = field(default_factory=dict)
    #: Of F beside G0 and Z alone: the move, F in mm/min, and what is told if a cut at this height has a larger one.
    plunge_feeds: list[tuple[int, float, Finding]] = field(default_factory=list)
    language: str = ""
    first_cut: int = 0
    machine_moves: list[int] = field(default_factory=list)
    length_ends: list[int] = field(default_factory=list)
    named_changes: list[int] = field(default_factory=list)
    aimed_changes: list[int] = field(default_factory=list)
    assumed_axes: dict[int, int] = field(default_factory=dict)
    #: Work systems to which the program has given an origin.
    placed_systems: set[int] = field(default_factory=set)
    #: Work system -> the first line that selects it, counted in its own file.
    system_lines: dict[int, int] = field(default_factory=dict)
    #: The columns there that are known.
    system_columns: dict[int, int] = field(default_factory=dict)
    has_word_numbers: bool = False  #: One of them is minus the number of a word in the line that is executed.
    #: Where tool axes gave way to places of the table.
    table_places: list[TablePlace] = field(default_factory=list)
    stock: Stock | None = None
    #: Arcs beside the contour whose feed rate is not F.
    arc_feeds: dict[ArcFeed, ArcFeedUse] = field(default_factory=dict)
    #: The first line of which something was left out, or read as something else: an error must say so. 0: none.
    given_up_line: int = 0
    count: int = 0
    #: Rows and arcs that no longer change, and their numbers.
    table: GrowingTable = field(default_factory=lambda: GrowingTable(**MOVE_COLUMNS))
    arc_table: GrowingTable = field(default_factory=lambda: GrowingTable(**_ARC_LAYOUT))
    splines: GrowingSplines = field(default_factory=lambda: GrowingSplines(len(AXES)))
    settled_rows: int = 0
    settled_arcs: int = 0
    left_plane: int = 0  #: The line after the plane in use that begins what mostly stands after its end.
    #: The frame and the path control that were recorded last, and their rows.
    _last: tuple[Frame | None, int, PathControl | None, int] = (None, -1, None, -1)

    def give_up(self, line: int) -> None:
        """An error has ended the execution of a line, whatever is done about it afterwards."""
        self.given_up_line = self.given_up_line or line

    def note_calls(self, chain: tuple[tuple[int, int], ...]) -> None:
        """The next moves are made inside these calls."""
        if self.calls and self.calls[-1].before == self.count:
            self.calls.pop()  # calls without motion, as those that compute
        if chain != (self.calls[-1].chain if self.calls else ()):
            self.calls.append(CallSpan(self.count, chain))

    @property
    def is_tcp_said(self) -> bool:
        """Whether codes say in which directions X Y Z count."""
        return len(self.tcp_changes) % 2 == 1

    def say_tcp(self, is_said: bool) -> None:
        """From the next move on, codes say in which directions X Y Z count, or no longer do."""
        if is_said != self.is_tcp_said:
            self.tcp_changes.append(self.count)

    def note_length_end(self, is_ended: bool) -> None:
        """From the next move on, the control has cancelled the tool length, or no longer has."""
        if is_ended != len(self.length_ends) % 2:
            self.length_ends.append(self.count)

    @property
    def is_axis_named(self) -> bool:
        """Whether A and C words name the table's place that a tool axis has."""
        return len(self.named_changes) % 2 == 1

    def note_axis(self, *, is_named: bool, is_aimed: bool) -> None:
        """From the next move on, A and C words name the table's place that a tool axis has, or no longer do.

        ``is_aimed``: they are solved from a tool axis, and go linearly.
        """
        for changes, holds in ((self.named_changes, is_named), (self.aimed_changes, is_aimed)):
            if holds == (len(changes) % 2 == 1):
                continue
            if changes and changes[-1] == self.count:
                changes.pop()
            else:
                changes.append(self.count)

    def end_tcp(self, line: int, word: str) -> None:
        """A word ends tool-centre-point control, or a plane, and X Y Z count in the directions of the machine."""
        self.say_tcp(False)
        self.note_tcp_end(line, word)

    def note_system(self, system: int, line: int, column: int | None = None) -> None:
        """A line selects a work system."""
        if system not in self.system_lines:
            self.system_lines[system] = self.lines.find_own(line)
            if column is not None:
                self.system_columns[system] = column
                self.has_word_numbers |= column < 0

    def note_control(self, control: PathControl) -> None:
        """A line that is executed says how corners are passed."""
        place = self.lines.place
        self.control_lines.setdefault(control, 0 if place is None else self.lines.number(place.line))

    def find_system_columns(self, find_column: Callable[[int], int | None]) -> None:
        """Put the columns of a line in place of the numbers of its words, which are below 0."""
        self.has_word_numbers = False
        columns = {key: find_column(one) if one < 0 else one for key, one in self.system_columns.items()}
        self.system_columns = {system: column for system, column in columns.items() if column is not None}

    def note_tcp_end(self, line: int, word: str) -> None:
        """A word ends tool-centre-point control, or the length, and leaves the table as it stands."""
        self.tcp_ends.append(PlaneCall(line, self.count, word, own_line=self.lines.find_own(line)))

    def select_tool(self, number: int, line: int, name: str = "", *, is_defined: bool = False) -> None:
        """T selects a tool for the next change, or TOOL DEF does before any TOOL CALL."""
        own_line = self.lines.find_own(line)
        self.selections.append(Selection(number, line, self.count, name, is_defined=is_defined, own_line=own_line))

    def call_plane(self, line: int, word: str = "", end: str = "", turn: str = "") -> None:
        """A tilted plane is in force from here on; or, without ``word``, none."""
        self.planes.append(PlaneCall(line, self.count, word, end, turn, self.lines.find_own(line)))
        self.left_plane = 0

    def note_turn_to_plane(self, *, is_first: bool) -> None:
        """The last moves have turned the table to the plane in force, ``is_first``: which nothing had placed before."""
        if self.planes and self.planes[-1].word:
            self.planes[-1] = replace(self.planes[-1], turned=self.count, is_first=is_first)

    def leave_plane(self, line: int) -> None:
        """A line begins what mostly stands after the end of the plane; the first one since moves were made in it."""
        if self.planes and self.planes[-1].word and self.count - self.planes[-1].before > 1:
            self.left_plane = self.left_plane or self.lines.find_own(line)

    def name_plane(self, otherwise: str) -> str:
        """The plane in force by its line, and the change of tools after it; ``otherwise`` where no plane is."""
        plane = self.planes[-1] if self.planes else None
        if plane is None or not plane.word:
            return otherwise
        changes = (one.own_line or one.line for one in self.events if one.kind == "tool" and one.before > plane.before)
        change = next(changes, 0)
        after = f" (still in force after the change of tools in line {change})" if change else ""
        return f"the plane of {plane.word} in line {plane.own_line}{after}"

    def explain_plane(self, otherwise: str) -> str:
        """What to do where the tool is not upright on the plane in force; ``otherwise`` where the program has none."""
        plane = self.planes[-1] if self.planes else None
        if plane is None or not plane.word:
            return otherwise
        what = f"the plane of {plane.word} in line {plane.own_line}"
        before = f", before line {self.left_plane}" if self.left_plane else ""
        if self.count - plane.before > 1:  # it was in use: beside a turn to it there was another move
            if not any(one.kind == "tool" and one.before > plane.before for one in self.events):
                end = f"{plane.end} where it is over{before}"
                return f"{what} is in force: {plane.turn}; look at its angles too; or write {end}"
            return f"{what} is still in force: write {plane.end} where it is over, or {plane.turn}"
        return f"{what} is in force: {plane.turn} ({plane.end} ends it)"

    def list_plane_edits(self) -> tuple[Remedy, ...]:
        """What :meth:`explain_plane` says, as edits: what turns the table to the plane, and what ends it before."""
        plane = self.planes[-1] if self.planes else None
        if plane is None or not plane.word:
            return ()
        turn = Remedy("write G53.1", "G53.1", line=plane.own_line, word=("G", 68.2), way="below")
        edits = (turn,) if plane.word == "G68.2" else ()
        end = ENDS_OF_PLANES.get(plane.end)
        return (
            (*edits, *write_before(end, line=self.left_plane, turns=True))
            if end and self.count - plane.before > 1
            else edits
        )

    def index_frame(self, frame: Frame) -> int:
        """Row of a frame in the table of frames."""
        return self.frames.setdefault(frame, len(self.frames))

    def add(
        self,
        modes: Modes,
        line: int,
        kind: MoveKind,
        end: list[float],
        feed: float,
        arc: Arc | None = None,
        spline: int = -1,
        seconds: float | None = None,
    ) -> None:
        """Record one motion or dwell; ``spline`` is the number of its piece.

        ``seconds`` is the duration where the feed rate is a time; None: 1/F minutes under G93, otherwise no time.
        """
        arc_row = -1
        if arc is not None:
            arc_row = self.settled_arcs + len(self.arcs)
            self.arcs.append(arc)
        if seconds is None:
            seconds = math.nan
            if modes.feed_mode == FeedMode.INVERSE and kind not in (MoveKind.RAPID, MoveKind.DWELL) and modes.feed:
                seconds = SECONDS_PER_MINUTE / modes.feed
        axis = modes.tool_axis or _NO_TOOL_AXIS
        self._keep(Row(line, kind, end, feed, *self._record_modes(modes), arc_row, spline, axis, seconds))

    def _record_modes(self, modes: Modes) -> tuple[int, float, int, int]:
        """Feed mode, spindle speed, frame and path control as they are recorded."""
        frame, frame_at, control, control_at = self._last
        if modes.frame is not frame or modes.control is not control:
            frame_at = self.index_frame(modes.frame)
            control_at = self.controls.setdefault(modes.control, len(self.controls))
            self._last = modes.frame, frame_at, modes.control, control_at
        return (
            modes.feed_mode,
            modes.spindle_speed if modes.spindle_on and not modes.surface_speed else 0.0,
            frame_at,
            control_at,
        )

    def keep_pieces(self, pieces: Splines) -> int:
        """Keep pieces of B-splines, and return the number of the first; :meth:`add` records the motion along each."""
        first = self.splines.count
        self.splines.extend(pieces)
        return first

    def _keep(self, row: Row) -> None:
        row = row._replace(line=self.lines.take_move(self.count, row.line))
        self.rows.append(row)
        self.places.append(self.count)
        self.count += 1
        if len(self.rows) >= 2 * _KEPT_ROWS:
            self._settle(_KEPT_ROWS)

    def amend(self, index: int, u: int, v: int, end: tuple[float, float], sweep: float | None) -> None:
        """Let the motion ``index`` (counted over all) end elsewhere in a plane; an arc turns ``sweep`` degrees more."""
        at = bisect_left(self.places, index)
        row = self.rows[at]
        point = list(row.end)
        point[u], point[v] = end
        self.rows[at] = row._replace(end=point)
        if sweep is not None:
            arc = self.arcs[row.arc - self.settled_arcs]
            self.arcs[row.arc - self.settled_arcs] = replace(arc, sweep=arc.sweep + sweep)

    def repeat_as_arc(self, index: int, line: int, end: list[float], feed: float, arc: Arc) -> None:
        """Record an arc under the modes of the motion ``index``."""
        row = self.rows[bisect_left(self.places, index)]
        self._keep(
            row._replace(line=line, kind=MoveKind.ARC, end=end, feed=feed, arc=self.settled_arcs + len(self.arcs))
        )
        self.arcs.append(arc)

    def add_many(
        self,
        modes: Modes,
        line: NDArray[np.int_],
        kind: NDArray[np.int_],
        end: Array,
        feed: Array,
        arcs: ArcRows | None = None,
        tool_axis: Array | None = None,
        seconds: Array | float = np.nan,
    ) -> None:
        """Record moves that share the modal state, as arrays; those of the kind ARC belong to ``arcs``, in order.

        ``tool_axis`` (n, 3) are their own tool axes; None for that of the modal state. ``seconds`` (n,) are their times
        where the feed rate is one. ``line`` (n,) is counted in the text that is executed.
        """
        n = len(line)
        if n == 0:
            return
        line = self.lines.take_moves(self.count, line)
        if len(self.rows) > _KEPT_ROWS:
            self._flush(len(self.rows))
        shared_columns = (
            *self._record_modes(modes),
            self._keep_arcs(kind, arcs),
            -1,
            modes.tool_axis or _NO_TOOL_AXIS if tool_axis is None else tool_axis,
            seconds,
        )
        place = slice(self.count, self.count + n)
        self.blocks.append((place, line.astype(np.int32), kind.astype(np.int8), end, feed, shared_columns))
        self.count += n
        if self.count - self.settled_rows >= BLOCK_ROWS:  # nothing waits for its end to be amended before such moves
            self._settle()

    def _keep_arcs(self, kind: NDArray[np.int_], arcs: ArcRows | None) -> NDArray[np.int64] | int:
        """Keep arcs, none of which is ever amended; for every move the row of its arc, -1 for none."""
        if arcs is None or not len(arcs.sweep):
            return -1
        self._flush(len(self.rows))  # arcs are in the order of the moves
        n, is_arc = len(arcs.sweep), kind == MoveKind.ARC
        turns = np.where(arcs.sweep < 0, -1, 1).astype(np.int32)
        self.arc_table.extend(plane=np.full(n, arcs.plane, np.int8), center=arcs.center, turns=turns, sweep=arcs.sweep)
        row = np.where(is_arc, self.settled_arcs + np.cumsum(is_arc) - 1, -1)
        self.settled_arcs += n
        return row

    def add_run(self, modes: Modes, line: int, kind: MoveKind, end: RunEnds, feed: float) -> None:
        """Record straight moves that differ only in their ends, of lines from ``line`` on in the text executed."""
        is_counted = self.lines.place is None
        line = int(self.lines.take_moves(self.count, line + np.arange(len(end.words)))[0]) if not is_counted else line
        if len(self.rows) > _KEPT_ROWS:
            self._flush(len(self.rows))
        shared_columns = (kind, feed, *self._record_modes(modes), -1, -1, modes.tool_axis or _NO_TOOL_AXIS, np.nan)
        self.runs.append(_Run(self.count, line, is_counted, end, shared_columns))
        self.count += len(end.words)
        if self.count - self.settled_rows >= BLOCK_ROWS:
            self._settle()

    def fix_c(self, line: int) -> None:
        """Note that a line leaves C no longer open."""
        if self.fixes_c is None:
            self.fixes_c = line if self.lines.place is None else self.lines.place.shown_line

    def note_arc_feed(self, rule: ArcFeed, share: float) -> None:
        """Note that an arc goes at ``share`` times F."""
        if share != 1.0:
            self.arc_feeds[rule] = self.arc_feeds.get(rule, ArcFeedUse(rule, 0, share, share)).count_arc(share)

    def record_event(self, line: int, kind: str, **data: object) -> None:
        """Record an auxiliary function, a message, a stop or a call."""
        own_line = self.lines.find_own(line) if self.lines.place is not None else 0
        self.events.append(Event(line, kind, self.count, data, own_line))
        self.lacks_feed |= kind == "tool"
        self.changes += kind == "tool"

    def record_tool(self, line: int, kind: str, number: int, data: dict[str, object]) -> None:
        """Record that a tool is selected or comes into the spindle, by the number that it has in here."""
        self.record_event(line, kind, **data)
        self.events[-1] = replace(self.events[-1], tool=number)

    def note_feed(self, count: int | None = None) -> None:
        """A feed rate is given, before the move of a number or the next one."""
        if self.lacks_feed:
            self.feeds.append(self.count if count is None else count)
            self.lacks_feed = False

    def warn(
        self,
        code: str,
        message: str,
        line: int,
        column: int | None,
        severity: Severity | None = None,
        edits: tuple[Remedy, ...] = (),
        advice: str | None = None,
    ) -> None:
        """Record a warning; ``severity`` and ``advice`` where those of the code are others."""
        key = self.lines.find_own(line), code
        before, line = self.warnings.get(key), int(key[0])
        if before is not None:
            self.warnings[key] = dataclasses.replace(before, count=before.count + 1)
            return
        severity, edits = severity or CODES[code].severity, self.lines.find_edits(edits)
        item = make_finding(code, message, severity=severity, edits=edits, advice=advice, line=line, column=column)
        self.warnings[key] = self.lines.name_calls().place(item)

    def note_once(
        self,
        code: str,
        message: str,
        line: int,
        edits: tuple[Remedy, ...] = (),
        tool: int | None = None,
        quantity: str = "",
        severity: Severity | None = None,
        column: int | None = None,
    ) -> None:
        """Record a warning at the first place alone, with the data that a finding may have."""
        known_texts = (item.message for item in self.warnings.values() if item.code == code)
        if not any(one == message or one.endswith(f": {message}") for one in known_texts):
            self.warn(code, message, line, column, severity, edits)
            key = self.lines.find_own(line), code
            self.warnings[key] = dataclasses.replace(self.warnings[key], tool=tool, quantity=quantity)

    def _flush(self, count: int) -> None:
        """Turn the first rows of those that are kept one by one into a block, and settle their arcs."""
        rows, places = self.rows[:count], self.places[:count]
        if not rows:
            return
        line, kind, end, feed, *shared_columns = zip(*rows, strict=True)
        columns: list[NDArray[Any]] = [
            np.array(column, dtype=dtype) for column, dtype in zip(shared_columns, _SHARED_TYPES, strict=True)
        ]
        self.blocks.append(
            (
                np.array(places),
                np.array(line, dtype=np.int32),
                np.array(kind, dtype=np.int8),
                np.array(end, dtype=float),
                np.array(feed, dtype=float),
                columns,
            )
        )
        del self.rows[:count], self.places[:count]
        arcs = self.arcs[: max(max(row.arc for row in rows) + 1 - self.settled_arcs, 0)]
        del self.arcs[: len(arcs)]
        self.settled_arcs += len(arcs)
        self.arc_table.extend(
            plane=np.array([arc.plane for arc in arcs], dtype=np.int8),
            center=np.array([arc.center for arc in arcs], dtype=float).reshape(-1, 3),
            turns=np.array([arc.turns for arc in arcs], dtype=np.int32),
            sweep=np.array([arc.sweep for arc in arcs], dtype=float),
        )

    def _settle(self, kept_count: int = 0) -> None:
        """Add everything recorded so far to the table, but for so many of the last rows that are kept one by one."""
        self._flush(len(self.rows) - kept_count)
        first, end = self.settled_rows, self.places[0] if self.places else self.count
        runs = [run for run in self.runs if run.place < end]
        blocks: list[_Block] = []
        later: list[_Block] = []
        for block in self.blocks:
            place = block[0]
            begins = place.start if isinstance(place, slice) else place[0]
            (blocks if begins < end else later).append(block)
        repeated_values = _find_repeated_values(runs, blocks)
        shapes = {name: (end - first, *width) for name, (_dtype, *width) in MOVE_COLUMNS.items()}
        part = {
            name: np.empty(shape, MOVE_COLUMNS[name][0])
            for name, shape in shapes.items()
            if name not in repeated_values
        }
        _fill_runs(part, runs, first)
        for place, *columns, shared_columns in blocks:  # over what runs have left between them
            at = slice(place.start - first, place.stop - first) if isinstance(place, slice) else place - first
            for name, values in zip(MOVE_COLUMNS, (*columns, *shared_columns), strict=True):
                if name in part:
                    part[name][at] = values
        self.table.extend(
            **part, **{name: np.broadcast_to(value, shapes[name]) for name, value in repeated_values.items()}
        )
        del self.runs[: len(runs)]
        self.blocks, self.settled_rows = later, end
        release_memory()  # the text so far

    def _place_stock(self, kind: NDArray[np.int8], frame: NDArray[np.int32]) -> Stock | None:
        """The stock, in the work system of the first cut where the program has named none before the stock.

        Heads of programs define the stock before they name the system; a control only draws it, in the one that it has.
        """
        stock = self.stock
        lines = map(self.lines.name_calls().show, self.system_lines.values())
        if stock is None or min(lines, default=math.inf) <= stock.line:
            return stock
        cuts = np.flatnonzero((kind != MoveKind.RAPID) & (kind != MoveKind.DWELL))
        first = tuple(self.frames)[int(frame[cuts[0]])] if len(cuts) else stock.frame
        if first.system == stock.frame.system:
            return stock
        return replace(stock, frame=replace(first, g92=ZERO9, tool=ZERO9, feature=None))

    def freeze(self, start: list[float], first_frame: Frame, parameters: Mapping[int, float]) -> Moves:
        """Build the table.

        Parameters
        ----------
        start : list of float
            Where the program starts, in ``first_frame``; mm and degrees.
        parameters : mapping
            Numbered parameters after the program.
        """
        self._settle()
        table, arcs = self.table.freeze(), Arcs(**self.arc_table.freeze())
        return Moves(
            arcs=arcs,
            splines=self.splines.freeze(),
            frames=tuple(self.frames),
            controls=tuple(self.controls),
            control_lines=tuple(self.control_lines.get(one, 0) for one in self.controls),
            events=tuple(self.events),
            start=np.array(start, dtype=float),
            start_frame=first_frame,
            fixes_c=self.fixes_c,
            parameters=parameters,
            stock=self._place_stock(table["kind"], table["frame"]),
            placed_systems=frozenset(self.placed_systems),
            system_lines=dict(self.system_lines),
            system_columns=dict(self.system_columns),
            arc_feeds=tuple(self.arc_feeds.values()),
            table_places=tuple(self.table_places),
            tcp_changes=tuple(self.tcp_changes),
            tcp_ends=tuple(self.tcp_ends),
            calls=tuple(self.calls),
            needs_tcp_code=self.needs_tcp_code,
            selections=tuple(self.selections),
            read_tools=frozenset(self.read_tools),
            radius_tools=frozenset(self.radius_tools),
            compensated_lines=self.compensated_lines,
            planes=tuple(self.planes),
            called_lines=self.lines.freeze(),
            speeds=tuple(self.speeds),
            turn_feeds=tuple(self.turn_feeds),
            taps=tuple(self.taps.values()),
            feeds=tuple(self.feeds),
            language=self.language,
            first_cut=self.first_cut,
            machine_moves=tuple(self.machine_moves),
            length_ends=tuple(self.length_ends),
            named_changes=tuple(self.named_changes),
            aimed_changes=tuple(self.aimed_changes),
            assumed_axes=self.assumed_axes,
            findings=(
                *self.warnings.values(),
                *_find_idle_feed(self, table["kind"], table["end"]),
                *_find_plunge_feed(self.plunge_feeds, table["kind"], table["end"], table["feed"]),
            ),
            **table,
        )


def _find_idle_feed(recorder: Recorder, kind: NDArray[np.int8], end: Array) -> tuple[Finding, ...]:
    """The first of the warnings that wait for a cut, where the tool rises without one; the builder's codes may cut.

    Nothing where it has risen last before: then it only goes to where it parks.
    """
    if recorder.given_up_line:
        return ()
    changes = [one.before for one in recorder.events if one.kind == "tool"]
    others = [one.before for one in recorder.events if one.kind in ("remapped", "auxiliary", "not executed")]
    for number, (begin, item) in recorder.idle_feeds.items():
        moves = slice(begin, changes[number] if number < len(changes) else len(kind))
        is_cut = (kind[moves] != MoveKind.RAPID) & (kind[moves] != MoveKind.DWELL)
        rises = (np.diff(end[moves, 2]) > 0.0).any()  # a place to park at is left as it is
        ways = np.diff(end[slice(changes[number - 1] if number else 0, begin), 2])
        has_risen = (ways[ways != 0.0][-1:] > 0.0).any()
        if rises and not has_risen and not is_cut.any() and not any(begin <= one <= moves.stop for one in others):
            return (item,)
    return ()


def _find_plunge_feed(
    feeds: list[tuple[int, float, Finding]], kind: NDArray[np.int8], end: Array, feed: Array
) -> tuple[Finding, ...]:
    """The first rapid down to a height at which a cut with a larger F than that of the rapid begins.

    The cut may only rise from there. Nothing where F of another rapid serves neither: the post gives it to rapids.
    """
    found: list[Finding] = []
    height = end[:, 2] if feeds else np.empty(0)
    changes = np.flatnonzero(np.diff(height)) + 1
    for move, own_feed, item in feeds:
        if move + 1 >= len(kind) or kind[move + 1] not in (MoveKind.FEED, MoveKind.ARC):
            return ()
        if math.isclose(feed[move + 1], own_feed):
            continue
        goes_down = move > 0 and height[move] < height[move - 1] and kind[move] == MoveKind.RAPID
        if not goes_down or height[move + 1] != height[move] or feed[move + 1] < own_feed:
            return ()
        left = changes[np.searchsorted(changes, move, side="right") :][:1]  # a plunge from here: it was above the part
        if not len(left) or height[left[0]] > height[move]:
            found.append(item)
    return tuple(found[:1])
