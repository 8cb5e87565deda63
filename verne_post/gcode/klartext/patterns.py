"""Where cycles run: CYCL CALL, M99, M89, CYCL CALL POS, PATTERN DEF, and the patterns 220 and 221."""

import math
import re
from typing import Final

from msgspec import Struct

from verne_post.gcode.klartext.contour import KlartextContour
from verne_post.gcode.klartext.cycle_words import (
    MACHINING,
    PATTERNS,
    Head,
    complete,
    find_cycle_of,
    find_parameter,
    read_head,
    read_parameters,
)
from verne_post.gcode.klartext.cycles import KlartextCycles
from verne_post.gcode.klartext.formulas import VALUE, read_value
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.klartext.functions import KlartextFunctions
from verne_post.gcode.klartext.milling import FACES
from verne_post.gcode.klartext.paths import KlartextPaths
from verne_post.gcode.klartext.settings import SETTINGS, KlartextSettings
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.vocabulary import CYCLES, CYCLES_WITHOUT_EFFECT, REFUSED_CYCLES, Q
from verne_post.gcode.klartext.words import Words
from verne_post.gcode.machining.holes import MAX_HOLES
from verne_post.gcode.machining.patterns import place_circle, place_grid, place_row
from verne_post.gcode.program_error import ProgramError, write_parameter

_ITEM: Final = re.compile(r"[ \t]*(POS|ROW|PAT|FRAME|CIRC|PITCHCIRC)(\d+)[ \t]*\(([^()]*)\)")
_ITEM_WORD: Final = re.compile(rf"[ \t]*(NUMX|NUMY|NUM|ROTX|ROTY|ROT|START|STEP|DX|DY|[XYZD])[ \t]*({VALUE})")
_NEEDS: Final = {
    "POS": ("X", "Y"), "ROW": ("X", "Y", "D", "NUM"), "PAT": ("X", "Y", "DX", "DY", "NUMX", "NUMY"),
    "CIRC": ("X", "Y", "D", "START", "NUM"), "PITCHCIRC": ("X", "Y", "D", "START", "STEP", "NUM"),
}  # fmt: skip
_ALLOWED_WORDS: Final = {"POS": ("Z",), "ROW": ("ROT", "Z"), "PAT": ("ROT", "Z"), "CIRC": ("Z",), "PITCHCIRC": ("Z",)}
_FULL_TURN: Final = 360.0
#: The last lines of settings that have more than one with values: 7.1 X, 7.2 Y, 7.3 Z, and 32.2.
_LAST_PARTS: Final = {7: 9, 32: 2}
#: A cycle in which all of these are 0 does nothing; threads may have a countersink alone.
_DEPTHS: Final = (Q.DEPTH, Q.SINKING_DEPTH, Q.FRONT_DEPTH)
#: What ends the calls of M89.
_END_MODAL: Final = "write M99 at its last place"
#: How a message about the value of a parameter of a cycle begins.
_VALUE_AT_FAULT: Final = re.compile(r"Q(\d+)=")
#: A place: X, Y, and the height that is added to the surface.
Place = tuple[float, float, float]


class DefinedCycle(Struct, frozen=True):
    """A machining cycle with its parameters."""

    number: int
    q: dict[int, float]
    #: Where the program gives its parameters: that of a pattern before its own. None in called files, whose lines no
    #: finding names.
    definitions: tuple[Statement, ...]


class KlartextPatterns:
    """Settings, and where machining cycles run.

    ``cycle`` is the machining cycle in force, ``modal`` whether M89 calls it after every positioning block,
    ``cycle_unread`` that its definition was refused, ``assigned`` are the Q parameters that definitions have set.
    """

    def __init__(
        self,
        frames: KlartextFrames,
        paths: KlartextPaths,
        contour: KlartextContour,
        functions: KlartextFunctions,
        cycles: KlartextCycles,
        settings: KlartextSettings,
    ) -> None:
        self.frames = frames
        self.paths = paths
        self.contour = contour
        self.functions = functions
        self.cycles = cycles
        self.settings = settings
        self.core = frames.core
        self.state = frames.state
        self.q = frames.q
        self.waiting = frames.waiting
        self.cycle: DefinedCycle | None = None
        self.modal = 0  #: The line of M89 while it holds.
        self.places: list[Place] = []
        self.cycle_unread = False
        self.uncalled_cycle: tuple[Statement, int, int] | None = (
            None  #: A definition not called: its cycle, moves before it.
        )
        self.assigned_values: dict[int, float] = {}

    # --- definitions ----------------------------------------------------------------------------------------

    def define_cycle(self, statement: Statement) -> None:
        """CYCL DEF: a setting takes effect, a machining cycle is kept, a pattern runs at once."""
        head = read_head(statement)
        number = head.number
        self.settings.refuse_other_number(statement, head)
        if meant_number := find_cycle_of(head):
            text = f"{number}: no cycle of these parameters; did you mean {meant_number}?"
            raise statement.error("VP001", text, head.begin)
        rest_of_number = re.match(r"[ \t]+\d{1,2}(?=[ \t]+[A-Z])", head.rest)
        if rest_of_number and int(right := f"{number}{rest_of_number[0].strip()}") in CYCLES:
            text = f"{number}{rest_of_number[0]}: a blank is in the number; did you mean {right}?"
            raise statement.error("VP001", text, head.begin)
        if number in REFUSED_CYCLES:
            raise statement.error("VP002", f"CYCL DEF {number} is not executed ({REFUSED_CYCLES[number]})", head.begin)
        if number not in CYCLES and number not in CYCLES_WITHOUT_EFFECT and self._has_lost_point(head):
            digits = statement.rest[head.begin :].split()[0]
            right = f"{number // 10}.{number % 10}"
            text = f"{digits}: the point in the number is missing; did you mean {right}?"
            raise statement.error("VP001", text, head.begin)
        if number not in CYCLES and number not in CYCLES_WITHOUT_EFFECT:
            raise statement.error(
                "VP002",
                f"CYCL DEF {number} is not executed; docs/heidenhain.md lists the cycles that are",
                head.begin,
            )
        if self.settings.execute_setting(statement, head):
            return
        if number in CYCLES_WITHOUT_EFFECT:
            for name, value in read_parameters(statement, head, self.q, self.contour.call_feed).items():
                self.q.set(f"Q{name}", value)
            return
        given = read_parameters(statement, head, self.q, self.contour.call_feed)
        q = complete(statement, number, given, *(MACHINING | PATTERNS)[number])
        if number in FACES:
            q |= {Q.SURFACE: q[Q.START_Z]}
        for name, value in given.items():
            self.q.set(f"Q{name}", value)
        if number in MACHINING:
            self.report_uncalled_cycle(f"the next one in line {statement.line}")
            self.cycle = DefinedCycle(number, q, self._list_definitions(statement))
            self.uncalled_cycle = (statement, number, self.core.recorder.count) if self.cycle.definitions else None
            self.cycle_unread, self.assigned_values = False, given
            self.modal = 0
            return
        self.assigned_values = {name: given.get(name, value) for name, value in self.assigned_values.items()}
        self.waiting.refuse(f"CYCL DEF {number}")
        self._run_pattern(statement, number, q)

    def _has_lost_point(self, head: Head) -> bool:
        """Whether a number, as 71, is that of a line of a setting: the first one, or one of the cycle before."""
        cycle, part = divmod(head.number, 10)
        is_open = not part or (self.settings.open_cycle == cycle and part <= _LAST_PARTS.get(cycle, 1))
        return head.part is None and cycle in SETTINGS and is_open

    def report_uncalled_cycle(self, until: str) -> None:
        """VP023: the cycle defined last is not called before the next one, or the end, and the tool has moved."""
        if self.uncalled_cycle is not None and self.core.recorder.count > self.uncalled_cycle[2]:
            statement, number, _count = self.uncalled_cycle
            text = (
                f"cycle {number} is not called: no CYCL CALL, M99 or M89 before {until}; write M99 where it is to run"
            )
            self.core.recorder.warn("VP023", text, statement.line, None, "warning")
        self.uncalled_cycle = None

    def _list_definitions(self, statement: Statement) -> tuple[Statement, ...]:
        return (statement,) if statement.line == self.frames.block.line else ()

    def define_places(self, statement: Statement) -> None:
        """PATTERN DEF POS1 (X+25 Y+33 Z+0) ...: the places of CYCL CALL PAT."""
        text, at, places = statement.rest.rstrip(), 0, list[Place]()
        while at < len(text):
            match = _ITEM.match(text, at)
            if match is None or match.group(1) == "FRAME":
                shown_text = text[at:].strip()[:20]
                raise statement.error(
                    "VP002",
                    f"PATTERN DEF {shown_text} is not executed; expected POS, ROW, PAT, CIRC or PITCHCIRC and values "
                    "in brackets",
                )
            places += self._place_items(statement, match.group(1), match.group(3))
            at = match.end()
            _count(statement, float(len(places)))
        if not places:
            raise statement.error("VP005", "PATTERN DEF needs positions")
        self.places = places

    def _place_items(self, statement: Statement, kind: str, text: str) -> list[Place]:
        values: dict[str, float] = {}
        at, text = 0, text.rstrip()
        while at < len(text):
            match = _ITEM_WORD.match(text, at)
            if match is None or match.group(1) in values:
                raise statement.error(
                    "VP001", f"PATTERN DEF {kind}: {text[at:].strip()[:15]!r} is not a value that fits there"
                )
            values[match.group(1)] = read_value(match.group(2), self.q)
            at = match.end()
        for name in _NEEDS[kind]:
            if name not in values:
                raise statement.error("VP005", f"PATTERN DEF {kind} needs {name}")
        for name in values:
            if name not in _NEEDS[kind] and name not in _ALLOWED_WORDS[kind] and values[name]:
                raise statement.error("VP002", f"PATTERN DEF {kind}: {name} is not executed")
        x, y, z = values["X"], values["Y"], values.get("Z", 0.0)
        counts = [_count(statement, values[name]) for name in ("NUM", "NUMX", "NUMY") if name in values]
        if kind == "POS":
            return [(x, y, z)]
        turn = values.get("ROT", 0.0)
        if kind == "ROW":
            places = place_row(x, y, turn, 0.0, values["D"], counts[0])
        elif kind == "PAT":
            _count(statement, float(counts[0] * counts[1]))
            places = place_grid(x, y, turn, (values["DX"], values["DY"]), counts[0], counts[1])
        else:
            step = _FULL_TURN / counts[0] if kind == "CIRC" else values["STEP"]
            places = place_circle(x, y, 0.5 * values["D"], values["START"], step, counts[0])
        return [(*place, z) for place in places]

    # --- calls -------------------------------------------------------------------------------------------------

    def call_cycle(self, z: float = 0.0) -> None:
        """Run the defined cycle here; ``z`` raises its surface."""
        self.uncalled_cycle = None
        if self.cycle_unread:
            return
        if self.cycle is None:
            raise ProgramError("VP017", "a cycle call needs a machining cycle; write CYCL DEF first")
        for name, value in self.assigned_values.items():
            if not self.q.has(f"Q{name}", value):
                raise ProgramError(
                    "VP017",
                    f"Q{name} has been changed since CYCL DEF {self.cycle.number}; controls differ in whether a call "
                    "takes the new value; write CYCL DEF again",
                )
        q = self.cycle.q if not z else {**self.cycle.q, Q.SURFACE: self.cycle.q[Q.SURFACE] + z}
        if not any(q.get(name, -1.0 if name == Q.DEPTH else 0.0) for name in _DEPTHS):
            self._warn_of_depth(self.cycle)
        pitch = {206: Q.PLUNGE_FEED, 207: Q.PITCH, 209: Q.PITCH}.get(self.cycle.number)
        self.cycles.pitch_line = None if pitch is None else self._find_place(self.cycle, pitch)[0]
        try:
            self.cycles.run_cycle(self.cycle.number, q)
        except ProgramError as error:
            self._move_to_definition(self.cycle, error)
            raise

    def _warn_of_depth(self, cycle: DefinedCycle) -> None:
        """VP007, once a definition: controls skip a cycle whose depth is 0."""
        own_line, column = self._find_place(cycle, Q.DEPTH)
        line = own_line or self.frames.block.line
        if (self.core.recorder.lines.find_own(line), "VP007") not in self.core.recorder.warnings:
            text = f"Q201=0: the control does not run cycle {cycle.number} with depth 0; write the depth, below 0"
            self.core.recorder.warn("VP007", text, line, column, "warning")

    def _move_to_definition(self, cycle: DefinedCycle, error: ProgramError) -> None:
        """An error about the value of one parameter stands where the cycle has it; more calls would only repeat it."""
        value = _VALUE_AT_FAULT.match(error.message)
        line, column = self._find_place(cycle, int(value[1])) if value else (None, None)
        if line is not None:
            error.line, error.column = line, column
            error.of_program = self.cycle_unread = True

    @staticmethod
    def _find_place(cycle: DefinedCycle, parameter: int) -> tuple[int | None, int | None]:
        """Line and column where the program gives a parameter of a cycle; None where no finding can name them."""
        for definition in cycle.definitions:
            if (at := find_parameter(definition, parameter)) is not None:
                return definition.find_place(at)
        return None, None

    def call_cycles(self, *, has_moved: bool, is_retract: bool = False) -> None:
        """What M99 and M89 ask for at the end of a block; M89 also after every block that has moved."""
        if "cycle" in self.functions.calls:
            self.modal = 0
            self.call_cycle()
        elif "modal" in self.functions.calls:
            self.modal = self.core.recorder.lines.find_own(self.frames.block.line)
            self.core.watcher.last_hole = None
            self._watch_plane()
            self.call_cycle()
        elif self.modal and has_moved:
            if is_retract:
                self.warn_of_modal("Z alone, which is one more place")
            self._watch_plane()
            try:
                self.call_cycle()
            except ProgramError as error:
                if error.code == "VP017" and not error.of_program:  # it is no place of the cycle, which ends here
                    self._explain_modal(error)
                raise

    def _watch_plane(self) -> None:
        """VP043, once for each M89: its cycle makes a hole in another plane than the one before."""
        if self.cycle is not None and not self.cycle_unread:
            self.core.watcher.report_new_plane(self.state, self._name_modal(), _END_MODAL)

    def _explain_modal(self, error: ProgramError) -> None:
        """Say in an error that M89 calls the cycle, in place of VP043, and end it: its next calls are of one cause."""
        self.core.watcher.explain(error, self._name_modal(), f"{_END_MODAL},", self.frames.block.line)
        self.modal = 0

    def warn_of_modal(self, what: str) -> None:
        """VP043, once for each M89: a change of tools, or a retract, finds its cycle on."""
        if self.modal and self.cycle is not None:
            self.core.watcher.report(self._name_modal(), f"at {what}", _END_MODAL, self.frames.block.line)

    def _name_modal(self) -> str:
        return f"M89 of line {self.modal} still calls cycle{'' if self.cycle is None else f' {self.cycle.number}'}"

    def call_at(self, statement: Statement, words: Words) -> None:
        """CYCL CALL POS X Y Z: go to the place at the tool's height, F for this way only; then the cycle."""
        here = self.paths.map_to_input(self.state.position)
        x, y = words.read_coordinate("X", here[0]), words.read_coordinate("Y", here[1])
        z = words.read_coordinate("Z", 0.0)
        with self.core.keep_feed():
            if not words.rapid:
                self.contour.set_feed(statement, words)
            words.check_used(statement, "F M")
            if x is None and y is None and z is None:
                raise statement.error("VP005", "CYCL CALL POS needs coordinates")
            open_axes = [axis for axis, value in enumerate((x, y)) if value is None]
            self.core.require_known(self.frames.block, open_axes, "CYCL CALL POS")
            self._run_at((here[0] if x is None else x, here[1] if y is None else y, z or 0.0), rapid=words.rapid)

    def call_places(self, statement: Statement, words: Words) -> None:
        """CYCL CALL PAT: at every place of PATTERN DEF."""
        if not words.rapid:
            self.contour.set_feed(statement, words)
        words.check_used(statement, "F M")
        if not self.places:
            raise statement.error("VP017", "CYCL CALL PAT needs PATTERN DEF before it; point tables are not read")
        rapid = words.rapid or not self.state.feed
        height = self.state.position[2] if self.state.is_known(2) else -math.inf
        with self.cycles.expect_holes(len(self.places)):
            for place in self.places:
                self._run_at(place, rapid=rapid, least=height)

    def _run_at(self, place: Place, *, rapid: bool, least: float = -math.inf) -> None:
        """First up to the clearance of this place and to ``least`` (Z of the frame), then sideways, then the cycle."""
        if self.cycle_unread:
            return
        if self.cycle is None:
            raise ProgramError("VP017", "a cycle call needs a machining cycle; write CYCL DEF first")
        self.waiting.refuse("a cycle call")
        self.frames.refuse_beside("a cycle call")
        x, y, z = place
        placed_point = self.frames.place([x, y, 0.0])
        clear = max(self.frames.find_height(self.cycle.q[Q.SURFACE] + z + self.cycle.q[Q.CLEARANCE]), least)
        self.core.frames.stand_at({0: placed_point[0], 1: placed_point[1], 2: clear})
        height = max(self.state.position[2], clear)
        if self.state.position[2] < height:
            self.contour.go_straight([*self.state.position[:2], height, *self.state.position[3:]], rapid=True)
        end = [placed_point[0], placed_point[1], height, *self.state.position[3:]]
        self.frames.check_upright("a motion")
        self.contour.go_straight(end, rapid)
        self.call_cycle(z)

    # --- 220, 221 -----------------------------------------------------------------------------------------------

    def _run_pattern(self, statement: Statement, number: int, q: dict[int, float]) -> None:
        if self.cycle_unread:
            return
        if self.cycle is None:
            raise statement.error("VP017", f"CYCL DEF {number} needs a machining cycle before it")
        if q.get(Q.ALONG_CIRCLE):
            text = "Q365=1 is not executed: between holes the tool goes straight; write Q365=0"
            raise statement.error("VP002", text, edits=write_parameter(Q.ALONG_CIRCLE, q[Q.ALONG_CIRCLE], 0.0))
        if q[Q.GO_HIGH] not in (0.0, 1.0):
            raise statement.error("VP007", f"Q301 is {q[Q.GO_HIGH]:g}; allowed are 0 and 1")
        places = _place_circle(statement, q) if number == 220 else _place_grid(statement, q)
        kept_cycle = self.cycle
        second = q[Q.SECOND_CLEARANCE] if q[Q.GO_HIGH] else 0.0
        self.cycle = DefinedCycle(
            kept_cycle.number,
            {**kept_cycle.q, Q.CLEARANCE: q[Q.CLEARANCE], Q.SURFACE: q[Q.SURFACE], Q.SECOND_CLEARANCE: second},
            (*self._list_definitions(statement), *kept_cycle.definitions),
        )
        try:
            with self.cycles.expect_holes(len(places)):
                for k, place in enumerate(places):
                    self._run_at(
                        place,
                        rapid=True,
                        least=-math.inf if k else self.frames.find_height(q[Q.SURFACE] + q[Q.SECOND_CLEARANCE]),
                    )
            if not q[Q.GO_HIGH] and q[Q.SECOND_CLEARANCE] > q[Q.CLEARANCE]:
                self.cycles.go_to_height(q[Q.SURFACE] + q[Q.SECOND_CLEARANCE], 0.0)
        finally:
            self.cycle = DefinedCycle(
                kept_cycle.number,
                {
                    **kept_cycle.q,
                    Q.CLEARANCE: q[Q.CLEARANCE],
                    Q.SURFACE: q[Q.SURFACE],
                    Q.SECOND_CLEARANCE: q[Q.SECOND_CLEARANCE],
                },
                self.cycle.definitions,
            )


def _count(statement: Statement, value: float) -> int:
    if value != round(value) or not 1 <= value <= MAX_HOLES:
        raise statement.error("VP007", f"{value:g}: a number of holes is whole, from 1 to {MAX_HOLES}")
    return round(value)


def _place_circle(statement: Statement, q: dict[int, float]) -> list[Place]:
    """220: on a circle; without a step from the start angle to the stop angle."""
    n, step = _count(statement, q[Q.HOLES]), q[Q.ANGLE_STEP]
    if step == 0:
        span = q[Q.STOP_ANGLE] - q[Q.START_ANGLE]
        whole = abs(abs(span) - _FULL_TURN) < 1e-9
        step = span / n if whole else span / max(n - 1, 1)
    return [
        (*place, 0.0)
        for place in place_circle(q[Q.CENTER_X], q[Q.CENTER_Y], 0.5 * q[Q.CIRCLE], q[Q.START_ANGLE], step, n)
    ]


def _place_grid(statement: Statement, q: dict[int, float]) -> list[Place]:
    """221: rows, to and fro, turned as a whole about the first place."""
    columns, rows = _count(statement, q[Q.COLUMNS]), _count(statement, q[Q.ROWS])
    _count(statement, float(columns * rows))
    return [
        (*place, 0.0)
        for place in place_grid(q[Q.START_X], q[Q.START_Y], q[Q.ROTATION], (q[Q.STEP_X], q[Q.STEP_Y]), columns, rows)
    ]
