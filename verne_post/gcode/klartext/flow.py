"""The order in which the lines of a Klartext program are executed: labels, repeats, subprograms, and plain stretches."""

import math
from typing import Final

from msgspec import Struct, field

from verne_post.base.long_text import Text
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode import plain
from verne_post.gcode.execution import Execution, StopConditions, run_program
from verne_post.gcode.klartext.program import Jump, Klartext
from verne_post.gcode.klartext.recovery import KlartextRecovery
from verne_post.gcode.klartext.statements import KlartextText, read_statement
from verne_post.gcode.machining.elements import Point
from verne_post.gcode.machining.state import State
from verne_post.gcode.plain import PlainLines
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.repeats import Repeats
from verne_post.gcode.rs274.flow import MAX_DEPTH
from verne_post.gcode.setup import Setup
from verne_post.gcode.text import Chunk

#: Statements that a program may have after its end, but for subprograms: none is executed there.
_NO_LINE: Final = 0


class _Call(Struct):
    """One call: where it came from; ``program`` for CALL PGM; ``repeats`` counts what is left of each REP by its line."""

    text: KlartextText
    line: int
    program: bool = False
    shown: int | None = None
    repeats: dict[int, int] = field(default_factory=dict)


class KlartextFlow:
    """Where a program goes on."""

    def __init__(self, main: KlartextText, interpreter: Klartext) -> None:
        self.main, self.interpreter, self.recovery = main, interpreter, KlartextRecovery(interpreter)
        self.text, self.line = main, 1
        self.shown_line: int | None = None
        self.ended = False
        self._calls = [_Call(main, _NO_LINE)]
        self._files: dict[str, KlartextText] = {}
        self.repeats = Repeats(interpreter.setup.max_repeats)

    @property
    def in_call(self) -> bool:
        """True inside a subprogram."""
        return len(self._calls) > 1

    def follow(self, jump: Jump, line: int) -> None:
        """Go where a statement of a line leads; ``self.line`` is already the next one.

        Raises
        ------
        ProgramError
            VP023, VP024.
        """
        if jump.kind == "end":
            if not self._leave_program():
                self.ended = True
        elif jump.kind == "return":
            if self.in_call and not self._calls[-1].program:
                self._leave()
        elif jump.kind == "goto":
            self.line = self._label(jump.name)
        elif jump.kind == "call":
            target = self._label(jump.name)
            self._enter(_Call(self.text, self.line, shown=self.shown_line))
            self.line = target
        elif jump.kind == "repeat":
            counters = self._calls[-1].repeats
            left = counters.get(line, jump.repeats)
            if left:
                counters[line] = left - 1
                self.line = self._label(jump.name)
            else:
                counters.pop(line, None)
        else:
            self._call_program(jump.name, line)

    def _label(self, name: str) -> int:
        labels = self.text.labels
        if name not in labels:
            raise ProgramError("VP023", f"LBL {name} does not stand in the program")
        return labels[name] + 1

    def _enter(self, call: _Call) -> None:
        if len(self._calls) > MAX_DEPTH:
            raise ProgramError("VP024", f"more than {MAX_DEPTH} calls inside each other")
        self._calls.append(call)
        if call.program:
            self.interpreter.q.local.append({})

    def _leave(self) -> None:
        call = self._calls.pop()
        self.text, self.line, self.shown_line = call.text, call.line, call.shown
        if call.program:
            self.interpreter.q.local.pop()

    def _leave_program(self) -> bool:
        """END PGM of a called program leads back; False in the program itself."""
        while self.in_call:
            was_program = self._calls[-1].program
            self._leave()
            if was_program:
                return True
        return False

    def _call_program(self, name: str, line: int) -> None:
        texts = self.interpreter.setup.subroutines
        if name not in texts:
            raise ProgramError("VP023", f"CALL PGM {name}: there is no file {name}.h in the folder of the program")
        if name not in self._files:
            self._files[name] = KlartextText(texts[name], self.interpreter.setup, f"{name}.h")
        self._enter(_Call(self.text, self.line, program=True, shown=self.shown_line))
        self.shown_line = self.shown_line or line
        self.text, self.line = self._files[name], 1


def execute_klartext(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    """Execute a Klartext program from its first line on, until it ends or a stop condition is met."""
    execution = Execution(state, Recorder())
    flow = KlartextFlow(KlartextText(source, setup), Klartext(setup, state, execution.recorder))
    return run_program(_KlartextRun(flow), execution, setup, stop)


class _KlartextRun:
    """A Klartext program in execution."""

    def __init__(self, flow: KlartextFlow) -> None:
        self.flow = flow

    @property
    def ended(self) -> bool:
        """True after END PGM, M2 or M30."""
        return self.flow.interpreter.functions.ended or self.flow.ended

    def may_restart(self) -> bool:
        """True where nothing of earlier lines is still to come."""
        interpreter = self.flow.interpreter
        return interpreter.waiting.is_empty and not interpreter.patterns.modal

    def find_chunk(self) -> Chunk | None:
        """The chunk of the next line; None where the text ends."""
        return self.flow.text.chunk(self.flow.line)

    def execute(self, chunk: Chunk, stop: StopConditions) -> tuple[int, list[ProgramError]]:
        """Execute the next statement, which may take several lines, or a stretch at once."""
        flow, line = self.flow, self.flow.line
        if not self._execute_stretch(chunk, stop):
            self._execute_statement()
        goes_on = flow.text is flow.main and not flow.in_call and flow.line > line
        return flow.line if goes_on else line + 1, []

    def end_text(self, execution: Execution) -> bool:
        """The text ends without END PGM: an error."""
        flow, text = self.flow, self.flow.text
        inside = f"the text ends inside a call{f' ({text.name})' if text.name else ''}"
        what = f"{inside if flow.in_call else 'the file ends'} without END PGM, M2 or M30"
        execution.report_at_line("VP010", what, flow.shown_line or max(text.n_lines, 1))
        return False

    def _execute_stretch(self, chunk: Chunk, stop: StopConditions) -> bool:
        """Execute a stretch of plain lines at once; False where there is none."""
        flow = self.flow
        interpreter, row = flow.interpreter, flow.line - chunk.first_line
        end, view = chunk.lines.end(row), plain.PlainView()
        last = stop.cut(flow.line, end + chunk.first_line, in_main=flow.text is flow.main) - chunk.first_line
        if (
            last - row < plain.MIN_LINES
            or not _is_ready(interpreter)
            or not plain.is_ready(interpreter.state, view, chunk.lines, row)
        ):
            return False
        while last > row and not chunk.lines.moves[last - 1]:
            last -= 1  # comments
        if last < end or chunk.first_line + last == chunk.end_line or flow.text.is_corner_next(chunk.first_line + last):
            last -= 1  # RND or CHF may begin at its end
        if (
            not interpreter.modes.tcp
            or interpreter.modes.along_vectors
            or any(interpreter.frames.wraps.values())
            or interpreter.paths.shortest
        ):
            last = chunk.lines.first_named(row, last, list(interpreter.setup.rotary))
        if last - row < plain.MIN_LINES:
            return False
        interpreter.frames.block.line = flow.shown_line or flow.line
        state = interpreter.state
        start = state.position[0], state.position[1]
        done = plain.execute(chunk.lines, row, last, interpreter.core, view, flow.shown_line)
        if done > row:
            first, flow.line = flow.line, flow.line + done - row
            interpreter.contour.last_rapid = view.motion == 0
            interpreter.paths.direction = _find_last_direction(chunk.lines, row, done, start, interpreter.setup.rotary)
            flow.repeats.count(flow.text, first, flow.line - 1, 0)
        return done > row

    def _execute_statement(self) -> None:
        flow = self.flow
        text, line, interpreter = flow.text, flow.line, flow.interpreter
        moves = interpreter.recorder.count
        flow.line += 1
        parts = text.parts(line)
        flow.line = line + len(parts)
        statement = read_statement(parts, line)
        shown = flow.shown_line or line
        if not (statement.deleted and interpreter.setup.block_delete):
            following = flow.line
            try:
                interpreter.execute_statement(statement, shown, corner_next=lambda: text.is_corner_next(following))
            except ProgramError as error:
                if not flow.recovery.pass_failed(statement, error):
                    raise
                return
            interpreter.failed = interpreter.failed and statement.keyword in ("RND", "CHF", "DEP", "")
            if interpreter.jump is not None and not interpreter.functions.ended:
                if interpreter.jump.kind == "end":
                    interpreter.waiting.refuse("END PGM")
                    if not flow.in_call:
                        interpreter.recorder.event(shown, "end", code="END PGM")
                flow.follow(interpreter.jump, line)
        flow.repeats.count(text, line, line, interpreter.recorder.count - moves)


def _find_last_direction(
    lines: PlainLines, first: int, done: int, start: Point, rotary: tuple[int, int]
) -> Point | None:
    """Direction in XY of the last move of a stretch that begins at ``start``; None without one, or where a rotary axis turns."""
    last = done - 1 - int(lines.moves[first:done][::-1].argmax())
    if (lines.row[last, rotary] == last).any():
        return None
    ends = [
        [lines.filled[k, axis] if k >= first and lines.row[k, axis] >= first else start[axis] for axis in (0, 1)]
        for k in (last - 1, last)
    ]
    du, dv = (float(end - begin) for begin, end in zip(*ends, strict=True))
    size = math.hypot(du, dv)
    return None if size < ZERO_LENGTH_MM else (du / size, dv / size)


def _is_ready(interpreter: Klartext) -> bool:
    """True where plain lines are nothing but straight moves."""
    return (
        interpreter.waiting.is_empty
        and interpreter.contour.side is None
        and not interpreter.patterns.modal
        and not interpreter.modes.inch
        and not interpreter.contour.per_turn
        and not interpreter.modes.as_spatial
        and bool((interpreter.frames.factors == 1.0).all())
        and (interpreter.modes.tcp or interpreter.maps.tilt is None)
    )
