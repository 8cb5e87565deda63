"""Moves: the motion that a program asks for, with all modal state resolved. Made by gcode, read by toolpath.

Positions are what an interpreter reports: absolute, program coordinates of the active work system
with tool offset and G92 taken out, mm and degrees whatever the program's units, in the order
X Y Z A B C U V W. Every row knows its source line.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace as replace_fields
from enum import IntEnum
from typing import Any, Final

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace
from numpy.typing import NDArray

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.tolerances import UPRIGHT_DEG
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.findings import CalledPlace, Finding, Remedy
from verne_post.model.part_setup import MACHINE_SYSTEM, Vector9, describe_tool_number, name_system
from verne_post.model.splines import Splines, build_empty_splines

AXES: Final = "XYZABCUVW"
ZERO9: Final[Vector9] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class MoveKind(IntEnum):
    """Kind of a move.

    TURN: the axes of the nominal machine go linearly, so that the turning table carries the part past the tip. SWING: A
    and C go linearly, and the tool turns about one point of its axis, which keeps its place on the part.
    """

    RAPID = 0
    FEED = 1
    ARC = 2
    DWELL = 3
    SPLINE = 4
    TURN = 5
    SWING = 6


class FeedMode(IntEnum):
    """G94, G93, G95."""

    PER_MINUTE = 0
    INVERSE = 1
    PER_REVOLUTION = 2


class PathMode(IntEnum):
    """G61, G61.1, G64."""

    EXACT_PATH = 0
    EXACT_STOP = 1
    BLEND = 2


class PathControl(Struct, frozen=True):
    """How exactly corners are taken.

    ``tolerance`` (P) and ``merge`` (Q) of G64 are in mm, ``axis_deg`` is that of the tool axis; None: not given.
    """

    mode: PathMode = PathMode.BLEND
    tolerance: float | None = None
    merge: float | None = None
    axis_deg: float | None = None


class Feature(Struct, frozen=True):
    """A tilted work plane (G68.2): its origin and the directions of its X, Y, Z, in program coordinates without it.

    ``rotation`` has nine numbers, row by row; its columns are the plane's axes.
    """

    origin: tuple[float, float, float]
    rotation: tuple[float, ...]
    #: False where no word of the program asks for it: it follows from where the table stands, or is that of an arc.
    is_programmed: bool = True

    @property
    def is_level(self) -> bool:
        """True where Z points as without the plane: it shifts the zero, or turns X and Y."""
        return self.rotation[8] >= math.cos(RAD_PER_DEG * UPRIGHT_DEG)

    def map_outside(self, point: Array) -> Array:
        """Points (..., 3) of the plane in program coordinates without it."""
        return self.turn_outside(point) + np.asarray(self.origin)

    def map_inside(self, point: Array) -> Array:
        """Inverse of :meth:`map_outside`."""
        return (point - np.asarray(self.origin)) @ self._matrix

    def turn_outside(self, direction: Array) -> Array:
        """Directions (..., 3) of the plane in program coordinates without it."""
        return direction @ self._matrix.T

    def turn_inside(self, direction: Array) -> Array:
        """Inverse of :meth:`turn_outside`."""
        return direction @ self._matrix

    @property
    def _matrix(self) -> Array:
        return np.array(self.rotation).reshape(3, 3)


class Frame(Struct, frozen=True):
    """Everything that lies between program coordinates and machine coordinates.

    Lengths in mm, angles in degrees in the sense of the machine file (``part_turn``: workpiece sense).
    """

    system: int = 1  #: 1 to 9 for G54 to G59.3, above :data:`ADDITIONAL_SYSTEMS` for G54.1 P1 and so on.
    origin: Vector9 = ZERO9  #: The system's origin in machine coordinates (parameters 5221 ...).
    turn: float = 0.0  #: R of G10 L2: turns X and Y only.
    part_turn: float = 0.0  #: c of ``--wcs``: how far the part is turned on the table.
    g92: Vector9 = ZERO9  #: Offset of G92 or G52 in force.
    tool: Vector9 = ZERO9  #: Tool offset in force; the length is its third entry.
    feature: Feature | None = None  #: The tilted work plane in force; G92 lies outside it.

    @property
    def tool_length(self) -> float:
        """Gauge line to tip, mm."""
        return self.tool[2]


class Stock(Struct, frozen=True):
    """A box or a cylinder along Z, as controls draw it: it is shown, and nothing keeps out of it (``--stock`` does)."""

    line: int  #: Where it is defined.
    #: low, high: Corners of the box, or of the box around the cylinder, mm, program coordinates of ``frame``.
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    frame: Frame  #: The work system in force there, without tool and tilted plane.
    round: bool = False  #: A cylinder.
    bore: float = 0.0  #: Inner diameter of a cylinder, mm.

    @property
    def size(self) -> tuple[float, float, float]:
        """Lengths along X, Y, Z, mm."""
        x, y, z = (top - bottom for bottom, top in zip(self.low, self.high, strict=True))
        return x, y, z

    def record(self) -> dict[str, object]:
        """As JSON has it."""
        return {
            "line": self.line,
            "shape": "cylinder" if self.round else "box",
            "work_system": name_system(self.frame.system),
            "low_mm": list(self.low),
            "high_mm": list(self.high),
            "bore_mm": self.bore,
        }


#: Why a call with values does nothing.
IGNORED: Final = "ignored by [remap]"


class Event(Struct, frozen=True):
    """An auxiliary function: spindle, coolant, tool, stop, message.

    ``before`` is the index of the move that follows it (the number of moves so far).
    """

    line: int
    kind: str
    before: int
    data: dict[str, object] = field(default_factory=dict)
    own_line: int = 0  #: In another file, which ``line`` calls: its line there, as :class:`CalledLines` counts it.
    #: Number of the tool here, also of a tool that has only a name and so no number in ``data``.
    tool: int = 0

    def waits(self, *, optional_stop: bool) -> bool:
        """True where the machine waits for a person or a signal; M1 only where it stops."""
        if self.kind == "stop":
            return self.data["stop"] != "optional" or optional_stop
        return self.kind == "tool" or (self.kind == "input" and self.data["wait"] != 0)


class Selection(Struct, frozen=True):
    """A tool that T selects for the next change of tools, or TOOL DEF before any TOOL CALL."""

    number: int  #: 0 for an empty spindle.
    line: int
    before: int  #: As in :class:`Event`.
    name: str = ""  #: Where the program calls it by its name.
    is_loaded: bool = False  #: A change of tools loads it before T selects again.
    is_defined: bool = False  #: TOOL DEF names it.
    is_beside_pallet: bool = False  #: M60, the change of pallets, stands in its block: a mistyped M6, as a rule.
    own_line: int = 0  #: As in :class:`Event`.

    def spell(self) -> str:
        """The word of the program."""
        if self.is_defined:
            return f"TOOL DEF {self.number}"
        return f'T="{self.name}"' if self.name else f"T{self.number}"

    def propose_change(self) -> tuple[Remedy, ...]:
        """M6 behind T; TOOL DEF takes a TOOL CALL with its speed, which nobody has said."""
        choice = self.is_beside_pallet
        edit = Remedy("write M6", "M6", line=self.own_line, word=("T", self.number), way="behind", is_choice=choice)
        instead = (Remedy("write M6", "M6", line=self.own_line, misspelt="M60"),) if choice else ()
        return () if self.is_defined else (*instead, edit)

    def describe_change(self) -> str:
        """Where M6 is to be written."""
        return f"M6 in place of M60 beside {self.spell()}" if self.is_beside_pallet else f"M6 after {self.spell()}"


class PlaneCall(Struct, frozen=True):
    """Where the program puts a tilted plane in force, or ends it."""

    line: int
    before: int  #: As in :class:`Event`.
    word: str = ""  #: What says so, as G68.2; empty where the plane ends.
    end: str = ""  #: What would end it, as G69.
    turn: str = ""  #: What would turn the table to it.
    own_line: int = 0  #: As in :class:`Event`.
    turned: int = 0  #: The number of moves after the table has turned to it, without words of its axes; 0: it has not.
    is_first: bool = False  #: Nothing before this turn has said how the table stands.


class Tap(Struct, frozen=True):
    """The first thread of one pitch that a tool taps."""

    line: int  #: In another file, its line there.
    before: int  #: As in :class:`Event`.
    tool: int | None  #: None before the first change of tools.
    pitch: float  #: Of the moves, mm a turn.


def name_tools(events: Iterable[Event]) -> dict[int, str]:
    """Number -> name of the tools that a program names."""
    return {event.tool: str(event.data["name"]) for event in events if "name" in event.data}


def list_tool_changes(events: Iterable[Event]) -> list[tuple[Event, int]]:
    """What puts another tool into the spindle, or gives the one that is there a number; with that number."""
    return [(event, event.tool) for event in events if event.kind in ("tool", "tool number")]


def describe_tool(event: Event) -> str:
    """The tool of a tool change, as a person knows it."""
    return describe_tool_number(event.tool, name_tools([event]))


class CallSpan(Struct, frozen=True):
    """Where the program goes into a call or comes back from one: the calls of the moves that follow."""

    before: int  #: As in :class:`Event`.
    #: Of each call, the outermost first: the line that calls, and the first line of the subprogram. A subprogram in
    #: another file has the line that calls it.
    chain: tuple[tuple[int, int], ...]


#: Lines of a called file have numbers above it times the number of the call, so that no other line has them.
LINES_OF_A_CALL: Final = 10**9


class OwnLine(int):
    """A line as :class:`CalledLines` counts it: it is kept while another file with such a line may be executed."""

    __slots__ = ()


class CalledLines(Struct, frozen=True):
    """The lines of other files that a program calls, with numbers of their own, beside those of the lines that call.

    A call of a file is the file and the line of the program that calls it; calls are counted from 1.
    """

    calls: Sequence[tuple[str, int]] = ()
    files: tuple[str, ...] = ()  #: Those that were executed, with moves or without.
    #: Of stretches of moves, ascending: the number of the first, and its line; 0 for the lines that moves have.
    before: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    line: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    def number_moves(self, line: Ints, move: Ints) -> Ints:
        """The lines (n,) of moves (n,), which are (n,) in the program. Lines of a stretch count up with the moves."""
        if not len(self.before):
            return line
        at = np.searchsorted(self.before, move, side="right") - 1
        begin = np.where((at >= 0) & (move >= 0), self.line[at], 0)
        return np.where(begin > 0, begin + move - self.before[at], line)

    def insert(self, at: NDArray[np.intp]) -> "CalledLines":
        """The same with moves of the program itself before those with the numbers ``at``, which are ascending."""
        if not len(self.before):
            return self
        begins = np.union1d(self.before, at)
        line = np.concatenate([self.number_moves(np.zeros(len(begins), np.int64), begins), np.zeros(len(at), np.int64)])
        before = np.concatenate([begins + np.searchsorted(at, begins, side="right"), at + np.arange(len(at))])
        order = np.argsort(before)
        return replace(self, before=before[order], line=line[order])

    def find_file(self, number: int) -> tuple[int, str | None, int | None]:
        """A line in its file, the file, and the line of the program that calls it; None where that is the program."""
        call, line = divmod(number, LINES_OF_A_CALL)
        return (line, *self.calls[call - 1]) if call else (number, None, None)

    def show(self, number: int) -> int:
        """The line of the program that calls the file of a line; that line, if it is one of the program."""
        line, _file, calling_line = self.find_file(number)
        return calling_line or line

    def name_line(self, number: int) -> str:
        """``line 12``, or ``O2000.nc, line 3`` in another file."""
        line, file, _calling_line = self.find_file(number)
        return f"{file}, line {line}" if file else f"line {line}"

    def name_lines(self, message: str) -> str:
        """A message in which such lines are named by their files."""
        return _CALLED_LINE.sub(lambda found: self.name_line(int(found.group(1))), message)

    def keep_edits(self, edits: tuple[Remedy, ...]) -> tuple[Remedy, ...]:
        """What is to be written, without what would be in other files."""
        return tuple(one for one in edits if one.line < LINES_OF_A_CALL)

    def place(self, item: Finding) -> Finding:
        """A finding of such a line, as one of the line that calls, ``called`` at that of the file.

        What would be written at lines of other files is left out.
        """
        message, edits = self.name_lines(item.message), self.keep_edits(item.edits)
        last, worst = (None if one is None else self.show(one) for one in (item.last_line, item.worst_line))
        own_line, file, line = self.find_file(item.line or 0)
        if file is None or line is None:
            return replace_fields(item, message=message, edits=edits, last_line=last, worst_line=worst)
        last, worst, place = max(line, last or line), worst or line, CalledPlace(file, own_line, item.column)
        same = replace_fields(item, message=message, edits=edits, column=None, lines=(), called=place)
        return replace_fields(same, line=line, last_line=last, worst_line=worst)

    def find_line(self, item: Finding) -> Finding:
        """A finding of the text, with the line of the other file in which it stands."""
        there = item.called
        call = None if there is None else (there.file, item.line)
        if there is None or call not in self.calls:
            return item
        own = (self.calls.index(call) + 1) * LINES_OF_A_CALL + there.line
        return replace_fields(item, line=own, last_line=own, worst_line=own)


#: A number that only lines of called files have, in a message.
_CALLED_LINE: Final = re.compile(r"\bline (\d{10,}+)")


class TablePlace(Struct, frozen=True):
    """A named place of the machine: the branch of the table decides which place of the part that is."""

    before: int  #: Index of the move that follows.
    machine: tuple[float, float]  #: A and C at which the table was taken to stand, machine coordinates, degrees.
    #: A and C words hold: another branch needs ``allow_rewind``. Else a tool axis gives way to a place of the
    #: table.
    by_words: bool = False


class Arcs(Struct, frozen=True):
    """The arcs among the moves, in order; row ``Moves.arc[i]`` belongs to move i."""

    plane: NDArray[np.int8]  #: (m,): 0 XY, 1 ZX, 2 YZ.
    center: Array  #: (m, 3): Program coordinates; the entry normal to the plane is that of the start.
    turns: NDArray[np.int32]  #: (m,): Signed, counter-clockwise positive; 1 = up to one full turn.
    sweep: Array  #: (m,): Signed angle in degrees.


class ArcFeed(Struct, frozen=True):
    """Where F holds on arcs under cutter compensation: the feed rate of the tool's centre over F, between two bounds.

    On the contour it is the length of the centre's arc over that of the programmed one: below 1 inside, above outside.
    """

    name: str = ""  #: The word or key that says so; empty where F is that of the centre.
    #: least, most: No arc is slower or faster than that, times F.
    least: float = 1.0
    most: float = 1.0
    assumed: bool = False  #: The program does not say so: the control's reset state.

    def share(self, on_contour: float) -> float:
        """The centre's feed rate over F, on an arc where ``on_contour`` keeps F on the contour."""
        return min(max(on_contour, self.least), self.most)


class ArcFeedUse(Struct, frozen=True):
    """How many arcs go at another feed rate than F for one reason, and their smallest and largest feed rate over F."""

    rule: ArcFeed
    arcs: int
    slowest: float
    fastest: float

    def record(self) -> dict[str, object]:
        """As JSON has it."""
        return {
            "by": self.rule.name,
            "assumed": self.rule.assumed,
            "arcs": self.arcs,
            "slowest": self.slowest,
            "fastest": self.fastest,
        }

    def count_arc(self, share: float) -> "ArcFeedUse":
        """Count one more."""
        return ArcFeedUse(self.rule, self.arcs + 1, min(self.slowest, share), max(self.fastest, share))


class Moves(Struct, frozen=True):
    """The program as a table, one row a move (a motion or a dwell), in order of execution."""

    line: NDArray[np.int32]  #: (n,)
    kind: NDArray[np.int8]  #: (n,): :class:`MoveKind`.
    end: Array  #: (n, 9): mm and degrees.
    #: (n,): mm/min, deg/min for rotary-only moves, TURN and SWING; the speed that results for inverse time; mm
    #: per revolution for G95; NaN for rapids; seconds for dwells. Of the tool's centre where compensation leads
    #: it.
    feed: Array
    feed_mode: NDArray[np.int8]  #: (n,): :class:`FeedMode`.
    spindle: Array  #: (n,): Spindle speed (1/min) in force, 0 when it stands, or is not known (G96).
    frame: NDArray[np.int32]  #: (n,): Index into ``frames``.
    control: NDArray[np.int32]  #: (n,): Index into ``controls``.
    #: (n,): Index into ``arcs``, -1 for other moves than arcs and SWING; of SWING only the standing centre
    #: counts.
    arc: NDArray[np.int32]
    #: (n,): Index into ``splines``, -1 for other moves. Neighbouring pieces of one B-spline are consecutive
    #: moves.
    spline: NDArray[np.int32]
    #: (n, 3): Tool axis that holds at the end, unit, program directions, from tip to spindle; NaN where A and C
    #: words hold. A and C of ``end`` are then one of the pairs that give this axis.
    tool_axis: Array
    #: (n,): Duration of the move if its feed rate is a time: inverse time, and F of all machine axes together.
    #: Else NaN.
    seconds: Array
    arcs: Arcs
    frames: tuple[Frame, ...]
    controls: tuple[PathControl, ...]
    events: tuple[Event, ...]
    start: Array  #: (9,): Where the program starts, program coordinates of ``start_frame``.
    start_frame: Frame
    #: First source line that names C, or sends X or Y to machine coordinates, where C decides what place of the
    #: part that is; None where the program leaves C open.
    fixes_c: int | None = None
    placed_systems: frozenset[int] = frozenset()  #: Work systems to which the program gives an origin.
    control_lines: tuple[int, ...] = ()  #: Where called files say so, the line of each control; 0 elsewhere.
    system_lines: Mapping[int, int] = field(
        default_factory=dict
    )  #: Work system -> the first line that selects it, in its own file.
    system_columns: Mapping[int, int] = field(default_factory=dict)  #: The columns there that are known.
    #: What a parameter file would keep after the program.
    parameters: Mapping[int, float] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()  #: Warnings about the text.
    #: Control points in program coordinates, all nine axes: mm and degrees. The first piece of a curve begins
    #: where the move before it ends, and each ends at its ``end``.
    splines: Splines = field(default_factory=lambda: build_empty_splines(len(AXES)))
    stock: Stock | None = None  #: The stock that the program defines.
    #: Arcs beside the contour whose feed rate is not F, by the word that says so.
    arc_feeds: tuple[ArcFeedUse, ...] = ()
    table_places: tuple[TablePlace, ...] = ()  #: Where a tool axis gave way to a place of the table.
    #: Numbers of the moves at which codes begin and cease, in turn, to say in which directions X Y Z count (tool-
    #: centre-point control, a plane). Without such a code, a control would read X Y Z in its own directions under
    #: a turned table. Languages other than RS274 say it from move 0 on; Siemens programs no longer do where
    #: TRAFOOF or CYCLE800() leave the table turned, until they name A or C.
    tcp_changes: tuple[int, ...] = (0,)
    tcp_ends: tuple[PlaneCall, ...] = ()  #: Those words, and G49, which leave the table as it stands.
    calls: tuple[CallSpan, ...] = ()  #: In order; before the first one, the program itself is executed.
    #: Whether controls of the language hold the tip only after such a code, also where the table turns as it cuts.
    needs_tcp_code: bool = False
    selections: tuple[Selection, ...] = ()  #: The tools that T selects, in the order of execution, T0 too.
    read_tools: frozenset[int] = frozenset()  #: Tools whose length or diameter H or D puts in force.
    radius_tools: frozenset[int] = frozenset()  #: Tools whose diameter moves the path: compensation and cycles.
    #: First and last line of each contour under cutter compensation -> what says its side: G42 of line 20.
    compensated_lines: Mapping[tuple[int, int], str] = field(default_factory=dict)
    planes: tuple[PlaneCall, ...] = ()  #: Tilted planes, in the order of execution.
    called_lines: CalledLines = CalledLines()
    #: Line and number of the next move, of each word that gives the spindle a speed; in another file, its line there.
    speeds: tuple[tuple[int, int], ...] = ()
    turn_feeds: tuple[tuple[int, int], ...] = ()  #: The same of each G95.
    taps: tuple[Tap, ...] = ()
    feeds: tuple[int, ...] = ()  #: Number of the next move, of the first feed rate after each change of tools.
    language: str = ""  #: "siemens", "heidenhain" or "aptcl": whose words messages have; else those of G-code.
    #: Number of the first move that may cut: feed moves before it are those of a retracted head without a length.
    first_cut: int = 0
    #: Numbers of the moves to machine coordinates (G53, G28, SUPA, M91): no length and no work offset matters there.
    machine_moves: tuple[int, ...] = ()
    #: Numbers of the moves at which the control has cancelled the tool length and takes one again, in turn.
    length_ends: tuple[int, ...] = ()
    #: Numbers of the moves at which A and C words begin and cease, in turn, to name the table's place that a tool axis
    #: has: words along a great circle.
    named_changes: tuple[int, ...] = ()
    #: Numbers of the moves at which A and C, which go linearly, begin and cease, in turn, to be solved from a tool
    #: axis of the program.
    aimed_changes: tuple[int, ...] = ()
    #: Rotary axes whose angle in cuts is assumed (VP036), each with the line that names it later.
    assumed_axes: Mapping[int, int] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.line)

    def name_tools(self) -> dict[int, str]:
        """Number -> name of the tools that the program names, those too that no change of tools loads."""
        return {**{one.number: one.name for one in self.selections if one.name}, **name_tools(self.events)}

    def list_called_tools(self) -> dict[int, None]:
        """Numbers of tools, each once: one that T names without M6 is meant to cut as much as one that M6 loads."""
        loaded = (number for _change, number in list_tool_changes(self.events))
        return dict.fromkeys([*loaded, *(one.number for one in self.selections if one.number)])

    def find_said_tcp(self, move: Ints) -> Mask:
        """Whether codes say, at each of some moves, in which directions X Y Z count."""
        return np.searchsorted(self.tcp_changes, move, side="right") % 2 == 1

    def find_cancelled_length(self, move: Ints) -> Mask:
        """Whether the control has cancelled the tool length, at each of some moves."""
        return np.searchsorted(self.length_ends, move, side="right") % 2 == 1

    def find_named(self, move: Ints) -> Mask:
        """Whether A and C are words of the program at each of some moves, and not those of a tool vector."""
        vectors = np.isfinite(self.tool_axis[move, 0])
        return ~vectors | (np.searchsorted(self.named_changes, move, side="right") % 2 == 1)

    def find_aimed(self, move: Ints) -> Mask:
        """Whether the program gives a tool axis at each of some moves, and no A and C."""
        solved = np.searchsorted(self.aimed_changes, move, side="right") % 2 == 1
        return ~self.find_named(move) | solved

    def find_in_machine(self) -> Mask:
        """Where a move leads to a place of the machine, which no work offset moves: ``machine_moves``, and G500."""
        found: Mask = np.isin(self.frame, [at for at, one in enumerate(self.frames) if one.system == MACHINE_SYSTEM])
        found[list(self.machine_moves)] = True
        return found

    def find_of_cycles(self) -> Mask:
        """Which moves a drilling or milling cycle makes: a pass of one line has rapids and cuts.

        Lines of called files have numbers of their own, as :meth:`count_own_lines` gives them.
        """
        begins = np.flatnonzero(np.diff(self.line, prepend=self.line[:1] - 1))
        is_rapid = self.kind == MoveKind.RAPID
        both = [
            np.logical_or.reduceat(one, begins) if len(begins) else np.zeros(0, dtype=bool)
            for one in (is_rapid, ~is_rapid & (self.kind != MoveKind.DWELL))
        ]
        return np.repeat(both[0] & both[1], np.diff(begins, append=len(self)))

    def find_selecting_line(self, system: int, move: int) -> int:
        """The line whose word puts a work system in force for a move; that of the move if it holds from the start.

        Rapids before the word count as its own: of a program that retracts first, and then names G54.
        """
        line, named_line = int(self.line[move]), self.system_lines.get(system)
        show = self.called_lines.show
        if named_line is None or (show(named_line), named_line) <= (show(line), line):
            return line if named_line is None else named_line
        later = np.flatnonzero(self.kind[move:] != MoveKind.RAPID)[:1] + move
        return line if len(later) and show(int(self.line[later[0]])) < show(named_line) else named_line

    def count_own_lines(self) -> "Moves":
        """The same with lines of called files in place of the lines that call them, as ``called_lines`` counts."""
        called = self.called_lines
        if not called.calls:
            return self
        own = {
            name: tuple(replace(one, line=one.own_line or one.line) for one in getattr(self, name))
            for name in ("events", "planes", "selections", "tcp_ends")
        }
        findings = tuple(called.find_line(one) for one in self.findings)
        return replace(self, line=called.number_moves(self.line, np.arange(len(self))), findings=findings, **own)

    @property
    def dwells(self) -> NDArray[np.intp]:
        """Numbers of the moves that are dwells, as the tool path has them; one of no time is a stop."""
        return np.flatnonzero(self.kind == MoveKind.DWELL)

    def start_at(self, first: int, first_event: int, switched: tuple[Event, ...]) -> "Moves":
        """The moves from number ``first`` on, and the events from ``first_event`` on after those of ``switched``."""
        kept = (replace(event, before=max(event.before - first, 0)) for event in self.events[first_event:])
        if first == 0:
            return replace(self, events=(*switched, *kept))
        rows = {name: getattr(self, name)[first:] for name in MOVE_COLUMNS}
        called = self.called_lines
        counted = self._count_anew(lambda number: max(number - first, 0))  # what has been said before holds from it on
        return replace(
            self,
            **{**rows, **counted},
            called_lines=replace(called, before=called.before - first),
            events=(*switched, *kept),
            start=self.end[first - 1],
            start_frame=self.frames[self.frame[first - 1]],
        )

    def insert(self, at: NDArray[np.intp], rows: Mapping[str, Array]) -> "Moves":
        """The same with moves of the program itself before those with the numbers ``at`` (n,), which are ascending.

        ``rows``: the columns of all moves. What is said before such a move is said before the one that is inserted.
        """
        counted = self._count_anew(lambda number: number + int(np.searchsorted(at, number, side="left")))
        events = tuple(
            replace(event, before=event.before + int(np.searchsorted(at, event.before, side="left")))
            for event in self.events
        )
        return replace(self, **{**rows, **counted}, events=events, called_lines=self.called_lines.insert(at))

    def _count_anew(self, count: Callable[[int], int]) -> dict[str, Any]:
        """All that is said of moves by their numbers, but events and called lines; ``count``: the new number of one."""
        said = ("tcp_ends", "table_places", "selections", "calls", "taps")
        planes = (replace(one, before=count(one.before), turned=count(one.turned)) for one in self.planes)
        numbers = ("tcp_changes", "named_changes", "aimed_changes", "length_ends", "feeds")
        after = (count(number + 1) for number in self.machine_moves)  # the one that is inserted before is none of them
        return {
            **{name: tuple(replace(one, before=count(one.before)) for one in getattr(self, name)) for name in said},
            **{name: tuple(map(count, getattr(self, name))) for name in numbers},
            **{
                name: tuple((line, count(number)) for line, number in getattr(self, name))
                for name in ("speeds", "turn_feeds")
            },
            "planes": tuple(planes),
            "first_cut": count(self.first_cut),
            "machine_moves": tuple(number - 1 for number in after if number > 0),
        }


#: What Moves keep for every move: type, and width where it is not one number.
MOVE_COLUMNS: Final[Mapping[str, tuple[Any, ...]]] = {
    "line": (np.int32,), "kind": (np.int8,), "end": (float, 9), "feed": (float,), "feed_mode": (np.int8,),
    "spindle": (float,),
    "frame": (np.int32,), "control": (np.int32,), "arc": (np.int32,), "spline": (np.int32,),
    "tool_axis": (float, 3), "seconds": (float,),
}  # fmt: skip


def find_tool_of_moves(move: Ints, first: int, moves: Moves) -> Ints:
    """Number of the tool in the spindle at moves (n,), 0 if none is named; before ``first``, the tool of that move."""
    changes = list_tool_changes(moves.events)
    before = np.array([event.before for event, _number in changes], dtype=np.int64)
    numbers = np.array([0, *(number for _event, number in changes)], dtype=np.int64)
    return np.asarray(numbers[np.searchsorted(before, np.maximum(move, first), side="right")])
