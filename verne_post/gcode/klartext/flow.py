"""The order in which lines of a Klartext program are executed: labels, repeats, subprograms, plain stretches."""

import math
import re
from functools import partial
from typing import Final

from msgspec import Struct, field

from verne_post.base.long_text import Text
from verne_post.base.suggestions import DIGITS_OF_LABELS, find_meant, find_meant_number, list_near_numbers, name_numbers
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode import plain
from verne_post.gcode.calls import CallStack
from verne_post.gcode.execution import Execution, StopConditions, run_program
from verne_post.gcode.klartext.cycle_words import list_missing
from verne_post.gcode.klartext.program import Jump, Klartext
from verne_post.gcode.klartext.recovery import KlartextRecovery
from verne_post.gcode.klartext.statements import KlartextText, read_statement
from verne_post.gcode.machining.plane_geometry import Point
from verne_post.gcode.machining.state import State
from verne_post.gcode.mistyped import correct_line, execute_as_meant
from verne_post.gcode.plain import PlainLines
from verne_post.gcode.program_error import (
    GIVE_FILE,
    GIVE_LABEL,
    ProgramError,
    end_with,
    locate_errors,
    write_numbers,
)
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.repeats import Repeats
from verne_post.gcode.setup import Setup
from verne_post.gcode.text import Chunk
from verne_post.model.findings import CalledPlace, Remedy

#: What the END PGM of a called file repeats.
_BEGIN: Final = re.compile(rb"\s*(?:\d+[ \t]+)?BEGIN[ \t]+PGM[ \t]+(\S+[ \t]+(?:MM|INCH))\b", re.IGNORECASE)


#: What follows LBL or CALL LBL where the label is lost.
_NO_LABEL: Final = re.compile(r"[ \t]*(?:REP\b|$)")


class _Call(Struct):
    """One call: of a label, or of a ``program``; ``repeats`` counts what is left of each REP by its line."""

    program: bool = False
    label: str = ""
    repeats: dict[int, int] = field(default_factory=dict)


class KlartextFlow:
    """Where a program goes on."""

    def __init__(self, main: KlartextText, interpreter: Klartext) -> None:
        self.interpreter, self.recovery = interpreter, KlartextRecovery(interpreter)
        self.calls = CallStack(main, 1, _Call())
        self.has_ended = False
        self._files: dict[str, KlartextText] = {}
        self._called_labels: set[str] = set()
        self.repeats = Repeats(interpreter.setup.max_repeats)

    def follow(self, jump: Jump, line: int) -> None:
        """Go where a statement of a line leads; ``self.calls.line`` is already the next one.

        Raises
        ------
        ProgramError
            VP023, VP024.
        """
        with locate_errors(jump.column):
            self._follow(jump, line)

    def _follow(self, jump: Jump, line: int) -> None:
        frame = self.calls.frame
        is_label = self.calls.in_call and not frame.program
        if jump.kind == "end":
            if is_label and not self.calls.text.label_errors:  # one of them may be its end
                end = Remedy("write LBL 0", "LBL 0", line=line, way="before")
                text = f"LBL {frame.label}, which CALL LBL has called, runs on into END PGM; write LBL 0 before it"
                raise ProgramError("VP023", text, edits=(end,))
            if not self._leave_program():
                self.has_ended = True
        elif jump.kind == "return":
            if is_label:
                self.leave()
        elif jump.kind == "label":
            if self.calls.in_main and jump.name in self._called_labels:
                text = f"the program runs on into LBL {jump.name}, which CALL LBL calls too; write M30 or M2 before it"
                end = Remedy("write M30", "M30", line=line, way="before")
                self.interpreter.recorder.note_once("VP024", text, line, (end,), severity="warning")
        elif jump.kind == "goto":
            self.calls.line = self._label(jump.name, line, is_jump=True)
        elif jump.kind == "call":
            self._enter(self.calls.text, self._label(jump.name, line), line, _Call(label=jump.name), f"LBL {jump.name}")
            self._called_labels.add(jump.name)
        elif jump.kind == "repeat":
            counters = frame.repeats
            repeats_left = counters.get(line, jump.repeats)
            if repeats_left:
                begin = self._label(jump.name, line)
                if begin > line:
                    raise ProgramError(
                        "VP017",
                        f"CALL LBL {jump.name} REP {jump.repeats}: REP repeats the section from the label to this "
                        f"line, and LBL {jump.name} is after it, in line {begin - 1}: nothing would be repeated; "
                        "write the label before this line, or CALL LBL without REP for a subprogram up to LBL 0",
                    )
                counters[line], self.calls.line = repeats_left - 1, begin
            else:
                counters.pop(line, None)
        else:
            self._call_program(jump.name, line)

    def _label(self, name: str, line: int, *, is_jump: bool = False) -> int:
        labels = self.calls.text.labels
        if name not in labels:
            running = set() if is_jump else {call.label for call in self.calls.list_frames()}  # which no call means
            others = [one for one in labels if one not in running]
            text, number = f"LBL {name} is not in the program", find_meant_number(name, others)
            if number:
                edit = Remedy(f"write LBL {number}", f"LBL {number}", line=line, misspelt=f"LBL {name}")
                error = ProgramError("VP023", f"{text}; did you mean LBL {number}?", edits=(edit,))
                error.passes_to = labels[number] if is_jump else 0
                raise error
            near = find_meant(name, others, slip_alone=True, least=3)
            numbers = list_near_numbers(name, others, DIGITS_OF_LABELS)
            text += f"; it has {name_numbers(numbers, 'LBL ')}" if numbers else ""
            edits = write_numbers(numbers, name, "LBL ", line)
            message = f'"{name}": {text}; did you mean "{near}"?' if near else text
            error = ProgramError("VP023", message, edits=edits).advise("" if near else GIVE_LABEL)
            if is_jump:
                near_lines = [labels[one] for one in numbers or [near] * bool(near)]
                error.passes_to = max(near_lines, default=min((at for at in labels.values() if at > line), default=0))
            raise error
        return labels[name] + 1

    def _enter(self, text: KlartextText, begin: int, line: int, call: _Call, name: str) -> None:
        self.calls.check_depth(name)
        self.calls.enter(text, begin, line, call)
        if call.program:
            self.interpreter.q.local.append({})

    def leave(self) -> None:
        """Go back to where the last subprogram was called."""
        if self.calls.leave().program:
            self.interpreter.q.local.pop()

    def _leave_program(self) -> bool:
        """END PGM of a called program leads back; False in the program itself."""
        while self.calls.in_call:
            was_program = self.calls.frame.program
            self.leave()
            if was_program:
                return True
        return False

    def _call_program(self, name: str, line: int) -> None:
        setup = self.interpreter.setup
        if name not in setup.subroutines:
            raise ProgramError(
                "VP023", f"CALL PGM {name}: there is no file {name}.h in the folder of the program"
            ).advise(GIVE_FILE)
        if name not in self._files:
            self._files[name] = KlartextText(setup.subroutines[name], setup, setup.name_file(name, "h"))
        self._enter(self._files[name], 1, line, _Call(program=True), f"PGM {name}")


def execute_klartext(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    """Execute a Klartext program from its first line on, until it ends or a stop condition is met."""
    execution = Execution(state, Recorder(language="heidenhain"))
    flow = KlartextFlow(KlartextText(source, setup), Klartext(setup, state, execution.recorder))
    run_program(_KlartextRun(flow), execution, setup, stop)
    if flow.interpreter.functions.has_ended or flow.has_ended:
        flow.interpreter.patterns.report_uncalled_cycle("the end of the program")
        flow.interpreter.settings.close_cycle()
        flow.interpreter.settings.report_lone_head()
    if (line := flow.interpreter.blank.open_line) and setup.machine:
        text = "BLK FORM 0.1 has no BLK FORM 0.2, so the stock is not known; write 0.2 with its other corner"
        execution.recorder.warn("VP005", text, line, None, "warning")
    if setup.machine and not any(error.code == "VP010" for error in execution.errors):
        for line, message, edits in flow.calls.main.find_wrong_frame():
            if any(error.line == line and error.code in ("VP001", "VP002") for error in execution.errors):
                continue
            execution.recorder.note_once("VP010", message, line, edits, severity="warning")
    try:
        _ = flow.calls.main.labels
        wrong_labels = flow.calls.main.label_errors
    except ProgramError as error:
        wrong_labels = [error]
    for wrong_label in wrong_labels:  # also where nothing calls them: a control does not run the program
        if not any(one.message == wrong_label.message for one in execution.errors):
            execution.report_at_line(
                wrong_label.code,
                wrong_label.message,
                wrong_label.line or 1,
                wrong_label.column,
                edits=wrong_label.edits,
            )
    return execution


class _KlartextRun:
    """A Klartext program in execution."""

    def __init__(self, flow: KlartextFlow) -> None:
        self.flow, self.calls = flow, flow.calls

    @property
    def has_ended(self) -> bool:
        """True after END PGM, M2 or M30."""
        return self.flow.interpreter.functions.has_ended or self.flow.has_ended

    def may_restart(self) -> bool:
        """True where nothing of earlier lines is still to come."""
        interpreter = self.flow.interpreter
        return interpreter.waiting.is_empty and not interpreter.patterns.modal

    def find_chunk(self) -> Chunk | None:
        """The chunk of the next line; None where the text ends."""
        return self.calls.text.find_chunk(self.calls.line)

    def execute(self, chunk: Chunk, stop: StopConditions) -> tuple[int, list[ProgramError]]:
        """Execute the next statement, which may take several lines, or a stretch at once."""
        return (self.calls.line, []) if self._execute_stretch(chunk, stop) else self._execute_statement(stop)

    def end_text(self, execution: Execution) -> bool:
        """The text ends without END PGM: an error."""
        text = self.calls.text
        place = CalledPlace(text.name, text.n_lines) if text.name else None
        inside = "the text ends inside a call" if self.calls.in_call else "the file ends"
        what = f"{inside} without END PGM, M2 or M30"
        head = _BEGIN.match(text.source) if text.name else None
        edits = end_with("M30" if head is None else f"END PGM {head[1].decode('latin-1')}")
        line = self.calls.shown_line or max(text.n_lines, 1)
        execution.report_at_line("VP010", what, line, edits=edits, place=place)
        return False

    def leave_call(self) -> None:
        """Go back to where the last subprogram was called, as far as it was executed."""
        self.flow.leave()

    def _execute_stretch(self, chunk: Chunk, stop: StopConditions) -> bool:
        """Execute a stretch of plain lines at once; False where there is none."""
        flow = self.flow
        interpreter, row = flow.interpreter, self.calls.line - chunk.first_line
        end, view = chunk.lines.end(row), plain.PlainView()
        last = (
            stop.cut(self.calls.line, end + chunk.first_line, is_about=stop.is_about(self.calls.text))
            - chunk.first_line
        )
        if (
            last - row < plain.MIN_LINES
            or not _is_ready(interpreter)
            or not plain.is_ready(interpreter.state, view, chunk.lines, row)
        ):
            return False
        while last > row and not chunk.lines.moves[last - 1]:
            last -= 1  # comments
        if (
            last < end
            or chunk.first_line + last == chunk.end_line
            or self.calls.text.is_corner_next(chunk.first_line + last)
        ):
            last -= 1  # RND or CHF may begin at its end
        if (
            not interpreter.modes.tcp
            or interpreter.modes.along_vectors
            or any(interpreter.frames.wraps.values())
            or interpreter.paths.shortest
        ):
            last = chunk.lines.find_first_named(row, last, list(interpreter.setup.rotary))
        if last - row < plain.MIN_LINES:
            return False
        interpreter.frames.block.line = self.calls.shown_line or self.calls.line
        state = interpreter.state
        start = state.position[0], state.position[1]
        stretch = plain.execute(chunk.lines, row, last, interpreter.core, view)
        if stretch > row:
            first, self.calls.line = self.calls.line, self.calls.line + stretch - row
            interpreter.contour.last_rapid = view.motion == 0
            interpreter.contour.last_cut = 0 if view.motion == 0 else self.calls.show(self.calls.line - 1)
            interpreter.settings.close_cycle()
            interpreter.paths.direction = _find_last_direction(
                chunk.lines, row, stretch, start, interpreter.setup.rotary
            )
            flow.repeats.count(self.calls.text, first, self.calls.line - 1, 0)
        return stretch > row

    def _execute_statement(self, stop: StopConditions) -> tuple[int, list[ProgramError]]:
        """Execute the next statement: the line after it, and its errors.

        After a misspelt word they are also those with the word that is meant.
        """
        flow = self.flow
        text, line, interpreter = self.calls.text, self.calls.line, flow.interpreter
        moves = interpreter.recorder.count
        self.calls.line += 1
        parts = text.read_parts(line, self._warn_of_tilde)
        last = line + len(parts) - 1
        self.calls.line = last + 1
        errors: list[ProgramError] = []
        if len(parts) > 1 and text.goes_on(last):
            why = f"~ at its end continues the cycle in line {last + 1}, which is a separate block; take ~ away"
            missing, others = list_missing(" ".join(parts))
            if not missing:  # else the cycle says it
                right = f"write {' or '.join(others)}" if others else "write the parameter that is missing"
                errors.append(ProgramError("VP001", f"{why}, or {right}", line=last))

        def execute(first_part: str) -> None:
            self._execute_parts([first_part, *parts[1:]], line)

        def correct(first_part: str, error: ProgramError) -> str | None:
            return None if stop.first_error else correct_line(first_part, error)

        give_up = partial(interpreter.recorder.give_up, self.calls.show(line))
        errors += execute_as_meant(parts[0], give_up, execute, correct)[0]
        if not errors:
            flow.repeats.count(text, line, line, interpreter.recorder.count - moves)
        return last + 1, errors

    def _warn_of_tilde(self, line: int) -> None:
        """A line of a cycle has no ~, where the lines before have one."""
        if self.calls.in_main and self.flow.interpreter.setup.machine:
            text = (
                f"line {line} has no ~ at its end: a control ends CYCL DEF there; write ~, the next line belongs to it"
            )
            self.flow.interpreter.recorder.warn("VP001", text, line, None, "warning", _write_tilde(line))

    def _execute_parts(self, parts: list[str], line: int) -> None:
        """Execute the statement of some lines."""
        flow, text, interpreter = self.flow, self.calls.text, self.flow.interpreter
        try:
            statement = read_statement(parts, line)
        except ProgramError as error:
            if correct_line(parts[0], error) is None:
                flow.recovery.pass_unread(parts)
            raise
        shown_line = self.calls.show(line)
        if not (statement.is_deleted and interpreter.setup.block_delete):
            following = self.calls.line
            try:
                interpreter.execute_statement(statement, shown_line, corner_next=lambda: text.is_corner_next(following))
            except ProgramError as error:
                interpreter.recorder.give_up(shown_line)
                # a misspelt word is corrected, and the statement executed again
                if error.code == "VP005" and statement.keyword == "BEGIN PGM":
                    text.complete_begin(error, parts[0])
                if error.code == "VP005" and statement.keyword == "CYCL DEF":
                    self.calls.line = text.skip_parameters(following)
                    if self.calls.line > following:
                        error.message += (
                            f"; line {following - 1} has no ~ at its end, and parameters follow it: write ~"
                        )
                        error.edits += _write_tilde(following - 1)
                if statement.keyword in ("LBL", "CALL LBL") and _NO_LABEL.match(statement.rest):
                    text.name_label(error, statement.keyword, line)
                if correct_line(parts[0], error) is None and flow.recovery.pass_failed(statement, error):
                    return
                raise
            interpreter.has_failed = interpreter.has_failed and statement.keyword in ("RND", "CHF", "DEP", "")
            if interpreter.jump is not None and not interpreter.functions.has_ended:
                if interpreter.jump.kind == "end":
                    interpreter.waiting.refuse("END PGM")
                    if not self.calls.in_call:
                        interpreter.recorder.record_event(shown_line, "end", code="END PGM")
                name_at = statement.rest.find(f'"{interpreter.jump.name}"')
                line_of_name, column = statement.find_place(name_at)
                with locate_errors(column if name_at >= 0 and line_of_name == line else None):
                    flow.follow(interpreter.jump, line)


def _write_tilde(line: int) -> tuple[Remedy, ...]:
    """The edit of a line of a cycle that does not say that the next one belongs to it."""
    return (Remedy("write ~", " ~", line=line, way="after"),)


def _find_last_direction(
    lines: PlainLines, first: int, done_row: int, start: Point, rotary: tuple[int, int]
) -> Point | None:
    """Direction in XY of the last move of a stretch from ``start``; None without one, or where a rotary axis turns."""
    last = done_row - 1 - int(lines.moves[first:done_row][::-1].argmax())
    if (lines.row[last, rotary] == last).any():
        return None
    ends = [
        [lines.filled_words[k, axis] if k >= first and lines.row[k, axis] >= first else start[axis] for axis in (0, 1)]
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
        and interpreter.frames.factors == (1.0, 1.0, 1.0)
        and (interpreter.modes.tcp or interpreter.maps.tilt is None)
    )
