"""Execution of a program of RS274/NGC blocks: stretches of plain lines, single blocks."""

import dataclasses
import re
from contextlib import suppress
from functools import partial
from typing import Final

from verne_post.base.long_text import Text
from verne_post.base.program_lines import remove_remarks
from verne_post.gcode import plain
from verne_post.gcode.block import Block
from verne_post.gcode.execution import FATAL, OF_TEXT, Execution, StopConditions, run_program
from verne_post.gcode.machining.state import State
from verne_post.gcode.mistyped import correct_number, correct_word, execute_as_meant, shift_back
from verne_post.gcode.parameters import LOCAL_INDICES
from verne_post.gcode.plain_vectors import end_of_vectors, take_vectors
from verne_post.gcode.program_error import CHECK_CALLER, IS_SUBPROGRAM, ProgramError, end_with
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.rs274.fanuc_points import find_length_without_unit
from verne_post.gcode.rs274.flow import Flow
from verne_post.gcode.rs274.interpreter import Rs274
from verne_post.gcode.rs274.letterless import find_divided
from verne_post.gcode.rs274.recovery import OF_WORDS, Recovery, place_at_code
from verne_post.gcode.setup import Setup
from verne_post.gcode.templates import find_word_column
from verne_post.gcode.text import Chunk, ProgramText, decode_line
from verne_post.model.findings import CalledPlace, Finding, Remedy

#: Numbers in a message.
_VALUES: Final = re.compile(r"-?\d+(?:\.\d+)?")
#: An F word with an expression or a parameter, or a number; and numbers of parameters.
_FEED: Final = re.compile(r"(?<![A-Z_<#])F[ \t]*+(\[.*|[-+]?[ \t]*+#[ \t]*+\d+|[-+.\d]+)", re.IGNORECASE)
_PARAMETER: Final = re.compile(r"#[ \t]*+(\d+)")
#: A plane that is not where it is to have ended.
_OF_PLANE: Final = re.compile(r"write G69 first")


def execute_blocks(source: Text, setup: Setup, state: State, stop: StopConditions, language: type[Rs274]) -> Execution:
    """Execute the blocks of a program from the first on, until it ends or a stop condition is met."""
    execution = Execution(state, Recorder(needs_tcp_code=language.traits.turns_table_alone))
    execution.recorder.tcp_changes.clear()  # until a code says it
    interpreter = language(setup, state, execution.recorder)
    main = ProgramText(source, setup, language)
    if main.first_line > 1:
        execution.recorder.record_event(1, "not executed", text=f"lines 1 to {main.first_line - 1}, before the %")
    recovery = None if stop.first_error else Recovery(interpreter)
    run = _BlockRun(Flow(main, interpreter), recovery, past_errors=stop.past_errors)
    return run_program(run, execution, setup, stop)


def note_missing_unit(execution: Execution, source: Text, dialect: str, *, only_fine: bool = False) -> None:
    """A note (VP039) about a program with lengths, or with such as programs in inches have, and neither G20 nor G21."""
    if line := find_length_without_unit(source, only_fine=only_fine):
        text = (
            "the program has neither G20 nor G21: lengths are read in mm; a control has the unit that was in force "
            f'before, or that its setting says; write the code, or [{dialect}] units = "mm" or "inch" in '
            "verne-post.toml"
        )
        execution.recorder.note_once("VP039", text, line)


def _find_last_start(text: ProgramText) -> tuple[int, str] | None:
    """The last line of a program but remarks, and the M3 that stands alone there; None where another word does."""
    line = text.closing or text.n_lines + 1
    code = ""
    while not code and line > 1:
        line -= 1
        code = remove_remarks(decode_line(text.read_line(line))).strip()
    last = re.fullmatch(r"(?:N\d+[ \t]*)?(M0*3)", code, re.IGNORECASE)
    return (line, last[1]) if last is not None else None


class _BlockRun:
    """A program of blocks in execution; with recovery all errors of a block are found."""

    def __init__(self, flow: Flow, recovery: Recovery | None, *, past_errors: bool) -> None:
        self.flow, self.calls, self.recovery = flow, flow.calls, recovery
        self._past_errors = past_errors
        #: A call has been left out, whose program is missing: it may set any mode and variable, and stops loops.
        self._misses_program = False
        self._gives_up = False
        #: A code of the last line has no meaning: it may be what ends the program.
        self._has_unknown_code = False
        self._is_unread = False  #: The last line could not be read, or has such a code.
        #: The errors of each line, and whether a G code is unknown or a plane begins or ends elsewhere.
        self._reported_errors: dict[tuple[int, int], dict[tuple[str, str], str]] = {}
        self._lacks_code = False
        #: The last block with codes: its line, and whether the spindle ran forward before it.
        self._last_codes = 0, False

    @property
    def has_ended(self) -> bool:
        """True after M2 or M30, and where a loop does not end because a program is missing."""
        return self._gives_up or self.flow.interpreter.has_ended

    def may_restart(self) -> bool:
        """True where nothing of earlier blocks is still to come."""
        return self.flow.interpreter.may_restart()

    def find_chunk(self) -> Chunk | None:
        """The chunk of the next line; None where the text ends."""
        text, line = self.calls.text, self.calls.line
        return None if line == text.closing else text.find_chunk(line)

    def execute(self, chunk: Chunk, stop: StopConditions) -> tuple[int, list[ProgramError]]:
        """Execute the next line, or a stretch at once."""
        line = self.calls.line
        try:
            if self._execute_stretch(chunk, stop):
                return self.calls.line, []
            errors = self._execute_line(chunk)
        except ProgramError as error:
            if self.recovery is not None and not self._past_errors and self.recovery.follows_unread(error):
                self._gives_up = True
                return line + 1, []
            if self._past_errors or not self._misses_program or error.code in OF_TEXT:
                raise
            # after any other error the next line would be the same again, or in the same loop
            self._gives_up = self.calls.line == line or error.code == "VP024"
            return line + 1, []
        if self._misses_program and not self._past_errors:
            errors = [error for error in errors if error.code in OF_TEXT]
        self._misses_program = self._misses_program or any(error.goes_on for error in errors)
        return line + 1, errors

    def _execute_stretch(self, chunk: Chunk, stop: StopConditions) -> bool:
        """Execute a stretch of plain lines at once; False where there is none."""
        flow = self.flow
        interpreter, row = flow.interpreter, self.calls.line - chunk.first_line
        last = chunk.lines.end(row)
        if last - row < plain.MIN_LINES:
            return False
        if self.calls.text.closing is not None:
            last = min(last, self.calls.text.closing - chunk.first_line)
        last = (
            stop.cut(self.calls.line, last + chunk.first_line, is_about=stop.is_about(self.calls.text))
            - chunk.first_line
        )
        view = interpreter.view_plain_lines(has_vector=bool(chunk.lines.has_offsets[row]))
        if view is None:
            return False
        if not view.turning:
            last = min(last, chunk.lines.find_turning(row))
        if view.has_tool_axes:
            last = end_of_vectors(interpreter.core, view, chunk.lines, row, last)
        if last - row < plain.MIN_LINES or not plain.is_ready(interpreter.state, view, chunk.lines, row):
            return False
        point = take_vectors(interpreter.core, chunk.lines) if view.has_tool_axes else None
        stretch = plain.execute(chunk.lines, row, last, interpreter.core, view, point)
        if stretch > row:
            interpreter.go_on_after_plain_lines(view)
            first, self.calls.line = self.calls.line, self.calls.line + stretch - row
            flow.repeats.count(self.calls.text, first, self.calls.line - 1, 0)
        return stretch > row

    def _execute_line(self, chunk: Chunk) -> list[ProgramError]:
        """Execute a line; with recovery its errors are returned, without the first is raised."""
        flow = self.flow
        text, line, interpreter = self.calls.text, self.calls.line, flow.interpreter
        moves, row = interpreter.recorder.count, line - chunk.first_line
        errors: list[ProgramError] = []
        warnings = interpreter.recorder.warnings
        first = len(warnings)
        self.calls.line += 1
        interpreter.parameters.line = line
        is_lost = self._lacks_code and self.recovery is not None and self.recovery.is_plane_lost()
        block = chunk.build_block(row, line) if interpreter.reads_plain_words else None
        try:
            if block is not None:
                errors = self._execute_block(block, line)
            elif line != text.opening and _is_executed(raw := chunk.read_raw(row), interpreter.setup):
                errors = self._read_and_execute(decode_line(raw), line)
                if errors and not interpreter.custom_macro:
                    errors = self._name_cause(errors, chunk.read_raw(row), line)
        except ProgramError as error:
            _find_column(error, chunk.read_raw(row))
            self._name_missing_value(error, text, line)
            raise
        finally:
            if len(warnings) > first:
                _find_columns_of_warnings(warnings, first, chunk.read_raw(row))
            if interpreter.recorder.has_word_numbers:
                interpreter.recorder.find_system_columns(partial(find_word_column, decode_line(chunk.read_raw(row))))
        for found in errors:
            _find_column(found, chunk.read_raw(row))
        if errors:  # what is missing beside them may be in what was left out; the number of a block is in no word
            number = next(find_divided(decode_line(chunk.read_raw(row)), line), None)
            is_beside = (
                number is not None
                and number.letter == "N"
                and all((error.column or 0) > number.end for error in errors)
            )
            codes = OF_WORDS if is_beside else (*OF_WORDS, "VP001")
            for key in [key for key in list(warnings)[first:] if key[1] in codes]:
                del warnings[key]
        flow.repeats.count(text, line, line, interpreter.recorder.count - moves)
        if errors:
            errors = self._drop_following(errors, text, line, is_lost=is_lost)
            for found in errors:
                self._name_missing_value(found, text, line)
        self._has_unknown_code = any(error.code == "VP002" for error in errors)
        self._is_unread = self._has_unknown_code or any(error.code == "VP001" for error in errors)
        return errors

    def _name_cause(self, errors: list[ProgramError], raw: bytes, line: int) -> list[ProgramError]:
        """The errors of a line; those at a number that a blank divides are that number, without what follows."""
        text, recovery = decode_line(raw), self.recovery
        if recovery is None:
            return errors
        for error in errors:
            _find_column(error, raw)
        for number in find_divided(text, line):
            own = [one for one in errors if number.begin <= (one.column or 0) <= number.end and one.code != "VP008"]
            if own:
                recorder = self.flow.interpreter.recorder
                recorder.warnings.pop((recorder.lines.find_own(line), "VP001"), None)
                recovery.pass_unread(text, line)
                return [number.error, *(one for one in errors if one not in own and one.code not in OF_WORDS)]
        return errors

    def _name_missing_value(self, error: ProgramError, text: ProgramText, line: int) -> None:
        """A feed rate of zero that is a value which the call of an O word does not give stands at the call, once."""
        frame = self.calls.frame
        if error.code != "VP009":
            return
        for at in range(line, frame.begin - 1, -1):
            code = remove_remarks(decode_line(text.read_line(at)))
            if (feed := _FEED.search(code)) is None:
                continue
            numbers = [int(one) for one in _PARAMETER.findall(feed[1])]
            if re.search(r"[-+]", feed[1]):
                return  # a sum may be another one than 0
            lacking = [one for one in numbers if one > frame.n_values and one in LOCAL_INDICES]
            body = "\n".join(decode_line(text.read_line(one)) for one in range(frame.begin, at))
            if lacking and not any(re.search(rf"#[ \t]*{one}[ \t]*=", body) for one in lacking):
                number, own_line = lacking[0], self.flow.interpreter.recorder.lines.find_own(at)
                given = f"{frame.n_values or 'no'} value{'s' * (frame.n_values != 1)}"
                error.message = (
                    f"o{frame.label} call gives {given}, and F of line {own_line} is #{number}, which is 0 then; give "
                    f"#{number} too"
                )
                error.line, error.column, error.of_program, error.of_value = frame.line, None, True, True
                error.cause = f"#{number} of line {frame.line}"
            return

    def _drop_following(
        self, errors: list[ProgramError], text: ProgramText, line: int, *, is_lost: bool
    ) -> list[ProgramError]:
        """Errors of a line without those that its error in an earlier run, or an unknown G code before, has caused.

        ``is_lost``: since that code, or a plane that is not there, the axes of the plane have not been named again.
        """
        earlier = self._reported_errors.setdefault((id(text), line), {})
        left = []
        for error in errors:
            kind = error.code, _VALUES.sub("0", error.message)  # a loop gives other values
            is_new = not earlier or earlier.get(kind) == error.message or error.code in FATAL
            of_plane = error.code == "VP017" and _OF_PLANE.search(error.message) is not None
            follows = (is_lost and error.code in ("VP008", "VP013", "VP017")) or (self._lacks_code and of_plane)
            if is_new and not follows:
                left.append(error)
        for error in left:
            earlier.setdefault((error.code, _VALUES.sub("0", error.message)), error.message)
        lacks_code = any(
            (error.code == "VP002" and error.edits and re.match(r"G\S+ is not a code", error.message))
            or error.leaves_unknown
            or (error.code == "VP017" and _OF_PLANE.search(error.message))
            for error in left
        )
        if lacks_code and self.recovery is not None:
            self._lacks_code = True
            self.recovery.lose_plane()
        return left

    def _read_and_execute(self, text: str, line: int) -> list[ProgramError]:
        if self.recovery is None:
            return self._execute_block(self.flow.interpreter.read(text, line), line)

        words, block = text, Block(line)

        def read(right_text: str) -> None:
            nonlocal words, block
            words, block = right_text, self.flow.interpreter.read(right_text, line)

        give_up = partial(self.flow.interpreter.recorder.give_up, self.calls.show(line))
        errors, rest = execute_as_meant(text, give_up, read, _correct)
        if rest is not None:
            follows = self.recovery.follows_unread(errors[-1])  # before this line counts as one that sets nothing
            self.recovery.pass_unread(rest, line)
            if follows or (len(errors) > 1 and errors[-1].code in OF_WORDS):
                errors.pop()
            return errors
        try:
            later_errors = self._execute_block(block, line)
        except ProgramError as later_error:
            if not errors:
                raise
            errors[0].breaks_structure = later_error.breaks_structure
            later_errors = []  # it may only follow
        if errors:  # what follows from the mistyped word is no error of its own
            # which words belong to a mistyped code is not known
            later_errors = [error for error in later_errors if error.code not in (*OF_WORDS, "VP007")]
            for error in later_errors:
                _find_column(error, words.encode())
            for error in reversed(errors):
                shift_back(error, later_errors)
        return errors + later_errors

    def _execute_block(self, block: Block, line: int) -> list[ProgramError]:
        flow, recovery = self.flow, self.recovery
        interpreter, errors = flow.interpreter, []
        if block.o is not None:
            if block.o.keyword is None and self._has_unknown_code and not self.calls.in_call:
                self._gives_up = not self.calls.text.is_head(line)  # what the code would have done is not known
            if not self._gives_up:
                flow.step(block)
            return []
        if block.macro is not None:
            flow.macros.step(block.macro, line)
            return []
        block.line = self.calls.show(line)
        if block.codes:
            state = interpreter.state
            self._last_codes = block.line, state.spindle_on and not state.spindle_reversed
        if recovery is None:
            try:
                interpreter.execute(block)
            except ProgramError as error:
                place_at_code(error, block)
                raise
        else:
            errors = recovery.execute(block)
        if interpreter.call is not None and not interpreter.has_ended:
            try:
                flow.follow(interpreter.call, line)
            except ProgramError as error:
                if recovery is None:
                    raise
                errors.append(error)
                interpreter.modes.macro = None  # of G66: it is missing after every move
        return errors

    def end_text(self, execution: Execution) -> bool:
        """The text ends without M2 or M30: an error but for a pair of %."""
        if self._is_unread:  # the last line may be what ends the program
            return False
        flow, text = self.flow, self.calls.text
        percent = text.opening is not None
        starts = _find_last_start(text)
        edits, also, place = end_with("M30"), "", None
        if starts is not None and self._last_codes[0] == starts[0]:
            right = Remedy("write M30", "30", line=starts[0], word=("M", 3.0), is_choice=True)
            edits = (right,) if self._last_codes[1] else (right, dataclasses.replace(edits[0], is_choice=True))
            what = "a spindle that runs already" if self._last_codes[1] else "the spindle, and no motion follows"
            also = f"; {starts[1]} of line {starts[0]} starts {what}: write M30 there if it is meant"
        if (unfinished_error := flow.interpreter.find_unfinished()) is not None:
            what = f"the text ends before {unfinished_error}"
        elif self.calls.in_call:
            ends = "M99" if flow.interpreter.custom_macro else "endsub or M99"
            last = (text.closing or text.n_lines + 1) - 1
            label = self.calls.frame.label
            what = f"O{label}, which has been called, runs on to the end of the text; expected {ends}"
            edits = end_with("M99") if flow.interpreter.custom_macro else ()
            place = CalledPlace(text.name, last) if text.name else None
        elif text.closing is not None or flow.interpreter.ends_with_text:
            execution.recorder.record_event(self.calls.line, "end", code="%")
            if flow.interpreter.custom_macro and flow.interpreter.setup.machine and not execution.errors:
                what = (
                    "no M30 or M2 ends the program before the closing %, where a control stops with an alarm"
                    f"{also or '; write M30 before it'}"
                )
                execution.recorder.note_once("VP010", what, self.calls.line, edits, severity="warning")
            return False
        elif not execution.recorder.count and not execution.errors and _is_of_subprograms(text):
            what = f"{IS_SUBPROGRAM}, and nothing calls it here; {CHECK_CALLER}"
            execution.report_at_line("VP010", what, max(text.n_lines, 1), advice="")
            return False
        else:
            what = f"the file ends without {'M2, M30 or a closing %' if percent else 'M2 or M30'}{also}"
        line = self.calls.shown_line or max(text.n_lines, 1)
        execution.report_at_line("VP010", what, line, edits=edits, place=place)
        return False

    def leave_call(self) -> None:
        """Go back to where the last subprogram was called, as far as it was executed."""
        frame = self.calls.frame
        self.flow.leave()
        self.flow.macros.leave(frame)


def _is_of_subprograms(text: ProgramText) -> bool:
    """Whether a text begins and ends with subprograms, whose labels fit together: no lines of its own call them."""
    with suppress(ProgramError):
        if subs := text.structure.subs.values():
            after = range(max(end for _begin, end in subs) + 1, text.n_lines + 1)
            behind = (remove_remarks(decode_line(text.read_line(line))).strip(" \t\r/%") for line in after)
            return text.is_head(min(begin for begin, _end in subs)) and not any(behind)
    return False


def _is_executed(raw: bytes, setup: Setup) -> bool:
    """False for blank lines, and for those that block delete leaves out."""
    return bool(raw.strip()) and not (setup.block_delete and raw.lstrip().startswith(b"/"))


def _find_columns_of_warnings(warnings: dict[tuple[int, str], Finding], first: int, raw: bytes) -> None:
    """The same for the warnings of the line: those from number ``first`` on."""
    for key, item in list(warnings.items())[first:]:
        if item.column is not None and item.column < 0:
            column = find_word_column(decode_line(raw), item.column)
            warnings[key] = dataclasses.replace(item, column=column)


def _correct(text: str, error: ProgramError) -> str | None:
    """The line with what is meant by a word that cannot be read; of others the structure of the block says it."""
    return (correct_word(text, error) if error.code == "VP001" else None) or correct_number(text, error)


def _find_column(error: ProgramError, raw: bytes) -> None:
    """Put the column of a word in place of its number in the line."""
    if error.column is not None and error.column < 0:
        error.column = find_word_column(decode_line(raw), error.column)
