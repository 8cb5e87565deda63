"""Klartext statements -> the interpreter: which method executes which keyword; path functions in their order."""

import re
from collections.abc import Callable, Mapping
from typing import Final

from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.suggestions import find_meant
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.arcs import Arc
from verne_post.gcode.klartext.approach import KlartextApproach
from verne_post.gcode.klartext.blank import Blank
from verne_post.gcode.klartext.contour import KlartextContour
from verne_post.gcode.klartext.cycles import KlartextCycles
from verne_post.gcode.klartext.formulas import VALUE, read_value
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.klartext.functions import KlartextFunctions
from verne_post.gcode.klartext.orientation import KlartextOrientation
from verne_post.gcode.klartext.paths import KlartextPaths, Target
from verne_post.gcode.klartext.patterns import KlartextPatterns
from verne_post.gcode.klartext.planes import KlartextPlanes
from verne_post.gcode.klartext.q_parameters import assign, execute_fn, label_of
from verne_post.gcode.klartext.settings import KlartextSettings
from verne_post.gcode.klartext.statements import Statement, count_blanks, refuse_label
from verne_post.gcode.klartext.words import Words, read_words
from verne_post.gcode.machining.state import State
from verne_post.gcode.machining.turning import warn_of_curve
from verne_post.gcode.program_error import At, write_words
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.model.findings import Remedy
from verne_post.model.moves import AXES, MoveKind

PATHS: Final = ("L", "LN", "LP", "C", "CP", "CR", "CT", "CTP")
_APPROACH: Final = re.compile(r"[ \t]*(P?)(LT|LN|CT|LCT)(?![A-Z])")
_LABEL: Final = re.compile(r"[ \t]*(?:\"([^\"]*)\"|(\d+)|(QS\d+))(?=[ \t]|$)")
_REPEAT: Final = re.compile(rf"[ \t]+REP[ \t]*({VALUE})(?:[ \t]*/[ \t]*\d+)?[ \t]*$")
_TARGET: Final = re.compile(r"GOTO[ \t]+LBL[ \t]*")
_MAX_REPEATS: Final = 65_534


class Jump(Struct, frozen=True):
    """Where the program goes on: a label, called or repeated so many times, or another program."""

    kind: str  # "goto", "call", "repeat", "label", "return", "program", "end"
    name: str = ""
    repeats: int = 0
    column: int | None = None  #: Of the name.


class Klartext:
    """Executes statements.

    ``jump`` is what the last one asks the flow for.
    """

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        self.frames = frames = KlartextFrames(setup, state, recorder)
        self.core, self.setup, self.state, self.recorder = frames.core, setup, state, recorder
        self.q, self.modes, self.maps, self.waiting = frames.q, frames.modes, frames.maps, frames.waiting
        self.paths = KlartextPaths(frames)
        self.contour = KlartextContour(frames, self.paths)
        self.approaches = KlartextApproach(frames, self.paths, self.contour)
        self.functions = KlartextFunctions(frames, self.contour)
        self.planes = KlartextPlanes(frames, self.contour, self.functions)
        self.cycles = KlartextCycles(frames, self.contour)
        self.orientation = KlartextOrientation(frames, self.contour, self.functions)
        self.settings = KlartextSettings(frames, self.functions, self.planes)
        self.patterns = KlartextPatterns(frames, self.paths, self.contour, self.functions, self.cycles, self.settings)
        self.jump: Jump | None = None
        self.blank = Blank()
        self.has_failed = False

    def execute_statement(self, statement: Statement, shown_line: int, *, corner_next: Callable[[], bool]) -> None:
        """Execute one statement; ``corner_next`` tells whether RND or CHF follows.

        Raises
        ------
        ProgramError
        """
        self.jump = None
        self.functions.calls = []
        self.frames.block = At(shown_line)
        if statement.keyword in PATHS:
            self._execute_path(statement, corner_next)
        elif statement.keyword:
            STATEMENTS[statement.keyword](self)(statement)
        if statement.keyword not in ("", "CYCL DEF"):
            self.settings.close_cycle()
        if self.functions.has_ended:
            self.waiting.refuse("the end of the program")

    # --- path functions ----------------------------------------------------------------------------------------

    def _execute_path(self, statement: Statement, corner_next: Callable[[], bool]) -> None:
        words = read_words(statement, self.q)
        self.functions.check_functions(words, beside="coordinates")
        machine = next((word.number for word in words.functions if word.number in (91, 92, 130)), None)
        if machine is not None:
            self._execute_elsewhere(statement, words, machine)
            return
        if self.waiting.is_empty:
            self.functions.begin_functions(words)
        elif words.functions:
            raise statement.error(
                "VP017", "M functions beside the element after RND, CHF or APPR; write them in a separate block"
            )
        vector = self.orientation.take_vector(statement, words)
        target = self.paths.read_target(statement, words)
        self.orientation.orient(target, vector)
        arc = self.paths.build(statement, words, target)
        self._finish_path(statement, words, target, arc, corner_next)
        self.functions.end_functions(words)
        self.patterns.call_cycles(has_moved=bool(target.axes), is_retract={*target.axes} == {2})

    def _finish_path(
        self, statement: Statement, words: Words, target: Target, arc: Arc | None, corner_next: Callable[[], bool]
    ) -> None:
        rapid = words.rapid
        self.contour.set_feed(statement, words)
        if self.waiting.approach is not None and words.compensation is not None:
            raise statement.error("VP017", f"{words.compensation} in the first element after APPR, which sets the side")
        words.check_used(statement, "side F DR M" if statement.keyword in ("C", "CP", "CR") else "side F M")
        if rapid and arc is not None:
            raise statement.error("VP017", "FMAX on an arc is not executed; give F")
        kind = MoveKind.RAPID if rapid else MoveKind.FEED
        if not target.axes:
            if not self.waiting.is_empty:
                raise statement.error("VP017", "a block without coordinates where RND, CHF or APPR needs an element")
            self.contour.set_side(statement, words.compensation)
            return
        if target.turns and not self.modes.tcp and arc is None:
            self._turn_table(statement, words, target, kind)
            return
        if target.turns and arc is not None:
            raise statement.error("VP017", "a rotary axis beside an arc is not executed")
        if self.waiting.queue.first is None or self.waiting.queue.corner is None:
            self.contour.set_side(statement, words.compensation)
        elif words.compensation is not None and words.compensation != (self.contour.side or "R0"):
            raise statement.error(
                "VP017",
                f"{words.compensation} right after {self.waiting.queue.corner.name}; change it one element later",
            )
        wait = corner_next()
        if wait and target.turns:
            raise statement.error("VP017", "RND or CHF after a move of a rotary axis")
        self.approaches.add_element(self.paths.make_element(target, arc, kind), wait=wait)

    def _turn_table(self, statement: Statement, words: Words, target: Target, kind: MoveKind) -> None:
        """A and C without tool-centre-point control."""
        self.waiting.refuse("a motion of a rotary axis")
        if words.compensation not in (None, "R0"):
            raise statement.error("VP017", f"{words.compensation} beside a rotary axis")
        self.contour.set_side(statement, words.compensation)
        if kind == MoveKind.FEED:
            self.contour.check_feed()
        axes = target.axes
        point = target.end[:3] if any(axis < 3 for axis in axes) else None
        self.core.start_of_motion(kind, absolute=True, machine=False)
        targets = {axis: target.end[axis] for axis in axes if 3 <= axis < 6}
        if kind == MoveKind.FEED and point is not None:
            warn_of_curve(self.core, statement.line, target.end, "M128")
        if not self.setup.machine:
            self.frames.run_line(self.frames.block, kind, target.end, axes)
        else:
            self.frames.turn_axes(kind, targets, point, axes)
        self.contour.last_rapid, self.contour.last_cut, self.paths.direction = kind == MoveKind.RAPID, 0, None

    def _execute_elsewhere(self, statement: Statement, words: Words, number: int) -> None:
        """M91, M92: machine coordinates; M130: the untilted system. Straight lines, without compensation."""
        name = f"M{number}"
        if statement.keyword != "L":
            raise statement.error("VP017", f"{name} goes with L")
        self.waiting.refuse(name)
        late = words.compensation == "R0" and self.state.compensation is not None
        self.frames.refuse_beside(f"{name} (beside R0, which takes effect after it)" if late else name)
        self.functions.begin_functions(words)
        kind = MoveKind.RAPID if words.rapid else MoveKind.FEED
        self.contour.set_feed(statement, words)
        if words.compensation in ("RL", "RR"):
            raise statement.error("VP017", f"{words.compensation} beside {name}")
        self.contour.set_side(statement, words.compensation)
        if number == 130:
            self._go_untilted(statement, words, kind)
        else:
            self.functions.warn_of_tcp(name)
            self._go_in_machine(statement, words, kind, number)
        self.contour.last_rapid, self.contour.last_cut, self.paths.direction = words.rapid, 0, None
        self.functions.end_functions(words)
        named_axes = words.columns.keys() & {*AXES, *("I" + letter for letter in AXES)}
        self.patterns.call_cycles(has_moved=True, is_retract=named_axes <= {"Z", "IZ"})

    def _go_untilted(self, statement: Statement, words: Words, kind: MoveKind) -> None:
        kept_tilt, self.maps.tilt = self.maps.tilt, None
        inner, self.maps.inner = self.maps.inner, type(self.maps.inner)()
        self.frames.refresh_frame()
        try:
            target = self.paths.read_target(statement, words)
            words.check_used(statement, "side F M")
            if target.turns:
                raise statement.error("VP017", "a rotary axis beside M130 is not executed")
            self.approaches.add_element(self.paths.make_element(target, None, kind), wait=False)
        finally:
            self.maps.tilt, self.maps.inner = kept_tilt, inner
            self.frames.refresh_frame()

    def _go_in_machine(self, statement: Statement, words: Words, kind: MoveKind, number: int) -> None:
        home = self.state.home2
        if number == 92 and home is None:
            raise statement.error(
                "VP015", "M92 counts from a position of the machine: add [home] g30 to the machine file"
            )
        machine, axes = self.frames.find_machine_position(), []
        for axis, letter in enumerate(AXES):
            if letter not in words.values and "I" + letter not in words.values:
                continue
            if letter not in self.setup.axes:
                error = statement.error("VP011", self.setup.describe_missing_axis(letter))
                raise error.advise(self.setup.advise_axis(letter, "LN with M128"))
            if "I" + letter in words.values:
                raise statement.error("VP017", f"I{letter} beside M{number}: machine coordinates are absolute")
            value = words.take(letter) or 0.0
            value = self.frames.convert_length(value) if letter in "XYZUVW" else value
            machine[axis] = value + (home[axis] if number == 92 and home is not None else 0.0)
            axes.append(axis)
        words.check_used(statement, "side F M")
        if not axes:
            raise statement.error("VP005", f"M{number} needs coordinates")
        if kind == MoveKind.FEED:
            self.contour.check_feed()
        self.core.start_of_motion(kind, absolute=True, machine=True)
        if {0, 1, self.setup.rotary[1]} & set(axes):
            self.recorder.fix_c(self.frames.block.line)
        self.frames.move_machine(kind, machine, axes)
        self.core.frames.forget_programmed({0, 1, 2, *axes})
        self.frames.refresh_frame()

    # --- corners, approach, departure -----------------------------------------------------------------------------

    def _set_corner(self, statement: Statement) -> None:
        rest = statement.rest
        if statement.keyword == "CHF" and rest.strip():
            rest = "LEN" + rest.lstrip()
        words = read_words(replace(statement, rest=rest), self.q)
        if self.has_failed and self.waiting.queue.first is None:
            return
        self.contour.set_corner(statement, words)

    def _approach(self, statement: Statement) -> None:
        match = _APPROACH.match(statement.rest)
        if match is None:
            raise statement.error(
                "VP002", f"{statement.keyword}{statement.rest[:8]}: expected LT, LN, CT, LCT, or P before them", 0
            )
        polar, kind = match.groups()
        words = read_words(
            replace(statement, rest=statement.rest[match.end() :], begin=statement.begin + match.end()), self.q
        )
        self.functions.check_functions(words, beside=statement.keyword)
        self.functions.begin_functions(words)
        leaves = statement.keyword == "DEP"
        target = self.paths.read_target(statement, words)
        if target.turns:
            raise statement.error("VP017", f"a rotary axis beside {statement.keyword}")
        if polar:
            self.paths.build(replace(statement, keyword="LP"), words, target)
        flat = [axis for axis in target.axes if axis < 2]
        if leaves and flat and kind != "LCT":
            raise statement.error("VP006", f"DEP {kind} takes no X and Y")
        if (not leaves or kind == "LCT") and len(flat) < 1:
            raise statement.error("VP005", f"{statement.keyword} {kind} needs X and Y")
        if leaves and self.has_failed and self.contour.side is None:
            pass  # an error right before has ended the compensation
        elif leaves:
            if words.compensation not in (None, "R0"):
                raise statement.error("VP017", f"{words.compensation} beside DEP, which ends compensation")
            height = target.end[2] if 2 in target.axes else None
            point = [*target.end[:2], *self.state.position[2:]] if kind == "LCT" else None
            self.approaches.depart(statement, words, kind, point, height)
        else:
            open_axes = {0, 1} if kind == "LCT" else {0, 1} - set(flat)  # the way of LCT depends on where it begins
            self.core.require_known(self.frames.block, sorted(open_axes), f"APPR {kind}")
            if 2 in target.axes:
                self.core.frames.stand_at({2: target.end[2]})
            self.approaches.start_approach(statement, words, kind, target.end)
        self.functions.end_functions(words)

    # --- calls -------------------------------------------------------------------------------------------------------

    def _call_cycle(self, statement: Statement) -> None:
        """CYCL CALL, PAT, POS."""
        match = re.match(r"[ \t]*(PAT|POS)?(?![A-Z])", statement.rest)
        where, at = (match.group(1), match.end()) if match is not None else (None, 0)
        words = read_words(replace(statement, rest=statement.rest[at:], begin=statement.begin + at), self.q)
        self.functions.check_functions(words, beside="CYCL CALL")
        self.functions.begin_functions(words)
        if where == "POS":
            self.patterns.call_at(statement, words)
        elif where == "PAT":
            self.patterns.call_places(statement, words)
        else:
            words.check_used(statement, "M")
            self.patterns.call_cycle()
        self.functions.end_functions(words)

    def _execute_words(self, statement: Statement) -> None:
        """M, F, S, R0 alone in a block."""
        words = read_words(statement, self.q)
        self.functions.check_functions(words)
        self.waiting.refuse("a block without coordinates")
        self.functions.begin_functions(words)
        self.contour.set_feed(statement, words)
        self.contour.set_side(statement, words.compensation)
        retracts = words.rapid and any(word.number == 140 for word in words.functions)  # in rapid traverse anyway
        words.check_used(statement, "side F M" if retracts else "side M")
        self.functions.end_functions(words)
        self.patterns.call_cycles(has_moved=False)

    # --- flow --------------------------------------------------------------------------------------------------------

    def _find_label(self, match: re.Match[str]) -> str:
        quoted_name, digits, text = match.groups()
        return label_of(quoted_name, digits, text, self.q)

    def _call_label(self, statement: Statement) -> None:
        match = _LABEL.match(statement.rest)
        if match is None:
            is_missing = not statement.rest.strip()
            text = "CALL LBL needs a label, a number or a name in quotes"
            raise statement.error("VP005", text, 0) if is_missing else refuse_label(statement)
        name, rest = self._find_label(match), statement.rest[match.end() :]
        at = match.start() + len(match[0]) - len(match[0].lstrip())
        _line, column = statement.find_place(at)
        if not rest.strip():
            self.jump = Jump("call", name, column=column)
            return
        repeat = _REPEAT.match(rest)
        if repeat is None:
            word = rest.split()[0]
            if find_meant(word, ("REP",), least=3, slip_alone=True):
                text = f"{word}: no meaning in this language; did you mean REP?"
                raise statement.error("VP001", text, match.end())
            if word == "REP" and not rest.split()[1:]:
                text = "REP needs the number of repeats after it; without REP, CALL LBL calls a subprogram up to LBL 0"
                raise statement.error("VP001", text, match.end())
            edits = (Remedy(f"write ;{word}", f";{word}", misspelt=word, is_choice=True),) if word != "REP" else ()
            text = f"{rest.strip()[:15]!r} after CALL LBL; expected REP and a number, or ; before a remark"
            raise statement.error("VP001", text, match.end(), edits)
        count = read_value(repeat.group(1), self.q)
        if count != round(count) or not 0 <= count <= _MAX_REPEATS:
            text = f"REP {count:g}: repeats are whole, up to {_MAX_REPEATS}"
            raise statement.error("VP007", text, match.end() + repeat.start(1))
        self.jump = Jump("repeat", name, round(count), column)

    def _label(self, statement: Statement) -> None:
        match = _LABEL.match(statement.rest)
        if match is not None and _REPEAT.match(statement.rest, match.end()):
            edits = write_words("LBL", "CALL LBL")
            raise statement.error("VP001", "a label has no REP; write CALL LBL to repeat", -len("LBL"), edits)
        if match is None or match.group(3) or statement.rest[match.end() :].strip():
            raise refuse_label(statement)
        name = self._find_label(match)
        self.jump = Jump("return") if name == "0" else Jump("label", name)

    def _call_program(self, statement: Statement) -> None:
        text = statement.rest.strip().strip('"')
        name = re.split(r"[\\/:]", text)[-1].strip().lower()
        name = name[:-2] if name.endswith(".h") else name
        if not name or "." in name:
            raise statement.error("VP023", f"CALL PGM {text[:30]}: expected the name of a Klartext program (.H)")
        self.jump = Jump("program", name, column=statement.find_place(count_blanks(statement.rest))[1])

    def _assign_parameter(self, statement: Statement) -> None:
        assign(statement, self.q)

    def _compute_function(self, statement: Statement) -> None:
        answer = execute_fn(statement, self.q)
        if answer.label is not None:
            label = _TARGET.search(statement.rest)
            self.jump = Jump("goto", answer.label, column=label and statement.find_place(label.end())[1])
        if answer.message is not None:
            self.recorder.record_event(self.frames.block.line, "not executed", text=answer.message)

    # --- head, end, stops ---------------------------------------------------------------------------------------------

    def _begin_program(self, statement: Statement) -> None:
        match = re.search(r"[ \t](MM|INCH|IN)[ \t]*$", statement.rest)
        if match is None:
            unit = statement.rest.split()[-1] if len(statement.rest.split()) > 1 else ""
            near = find_meant(unit, ("MM", "INCH"), slip_alone=True, least=2)
            if not near:
                raise statement.error("VP005", "BEGIN PGM needs a name, and MM or INCH")
            message = f"{unit}: the unit of BEGIN PGM is MM or INCH; did you mean {near}?"
            raise statement.error("VP005", message, statement.rest.rindex(unit))
        if not statement.rest[: match.start()].strip():
            raise statement.error("VP005", "BEGIN PGM needs a name, and MM or INCH")
        inch = match.group(1) != "MM"  # IN: of older controls
        self.modes.inch = inch
        self.q.control_values[113] = float(inch)

    def _end_program(self, statement: Statement) -> None:
        self.jump = Jump("end")

    def _read_blank(self, statement: Statement) -> None:
        """BLK FORM: the stock, shown as an event; a box or a cylinder is kept for the report."""
        self.recorder.record_event(self.frames.block.line, "stock", text="BLK FORM" + statement.rest.rstrip())
        unit = MM_PER_INCH if self.modes.inch else 1.0
        stock = self.blank.read(statement, self.q, unit, self.state.frame)
        self.recorder.stock = stock or self.recorder.stock

    def _call_tool(self, statement: Statement) -> None:
        tool = self.state.loaded_tool
        self.functions.call_tool(statement)
        if self.state.loaded_tool != tool:
            self.patterns.warn_of_modal("TOOL CALL")

    def _stop(self, statement: Statement) -> None:
        words = read_words(statement, self.q)
        self.functions.check_functions(words)
        words.check_used(statement, "M")
        self.waiting.refuse("STOP")
        self.functions.begin_functions(words)
        self.functions.run_codes([0])
        self.functions.end_functions(words)
        self.patterns.call_cycles(has_moved=False)

    def _set_pole(self, statement: Statement) -> None:
        words = read_words(statement, self.q)
        self.paths.set_pole(statement, words)

    def _refuse_selected(self, statement: Statement) -> None:
        raise statement.error("VP002", "CALL SELECTED PGM is not executed; write CALL PGM", 0)


#: What executes a statement.
STATEMENTS: Final[Mapping[str, Callable[[Klartext], Callable[[Statement], None]]]] = {
    "BEGIN PGM": lambda one: one._begin_program,
    "END PGM": lambda one: one._end_program,
    "BLK FORM": lambda one: one._read_blank,
    "TOOL CALL": lambda one: one._call_tool,
    "TOOL DEF": lambda one: one.functions.define_tool,
    "CYCL DEF": lambda one: one.patterns.define_cycle,
    "CYCL CALL": lambda one: one._call_cycle,
    "CALL LBL": lambda one: one._call_label,
    "CALL PGM": lambda one: one._call_program,
    "CALL SELECTED PGM": lambda one: one._refuse_selected,
    "PLANE": lambda one: one.planes.execute_plane,
    "FUNCTION": lambda one: one.orientation.execute_function,
    "TRANS": lambda one: one.settings.transform,
    "SEL TABLE": lambda one: one.settings.select_table,
    "PATTERN DEF": lambda one: one.patterns.define_places,
    "STOP": lambda one: one._stop,
    "LBL": lambda one: one._label,
    "FN": lambda one: one._compute_function,
    "APPR": lambda one: one._approach,
    "DEP": lambda one: one._approach,
    "RND": lambda one: one._set_corner,
    "CHF": lambda one: one._set_corner,
    "CC": lambda one: one._set_pole,
    **dict.fromkeys(("Q", "QL", "QR", "QS"), lambda one: one._assign_parameter),
    **dict.fromkeys(("M", "F", "S", "R0", "RL", "RR"), lambda one: one._execute_words),
}
