"""Execution of a Siemens program: stretches of plain lines, single lines, and the ends of its sections."""

import re
from functools import partial
from typing import Final

from verne_post.base.long_text import Text
from verne_post.base.suggestions import find_correction
from verne_post.gcode.execution import Execution, StopConditions, run_program
from verne_post.gcode.machining.state import State
from verne_post.gcode.mistyped import correct_line, execute_as_meant
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.siemens.executor import Executor
from verne_post.gcode.siemens.flow import Flow
from verne_post.gcode.siemens.program import SiemensText
from verne_post.gcode.siemens.stretch import execute_stretch
from verne_post.gcode.siemens.vocabulary import STATEMENTS
from verne_post.gcode.text import Chunk, decode_line

#: Statements without a partner in another line.
_WITHOUT_PARTNER: Final = ("MCALL", "DEF", "MSG")

#: What is told of a name that DEF has not defined.
_NO_VARIABLE: Final = re.compile(r"(\w+)(?: is neither defined \(|: not defined \(| is not defined; write)")


def execute_siemens(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    """Execute a Siemens program from its first line on, until it ends or a stop condition is met."""
    execution = Execution(state, Recorder(language="siemens"))
    flow = Flow(SiemensText(source, setup), Executor(setup, state, execution.recorder))
    return run_program(_SiemensRun(flow), execution, setup, stop)


class _SiemensRun:
    """A Siemens program in execution."""

    def __init__(self, flow: Flow) -> None:
        self.flow, self.calls = flow, flow.calls
        self._undefined_names: dict[tuple[SiemensText, str], int] = {}  #: With the line that uses each first.

    @property
    def has_ended(self) -> bool:
        """True after M2, M30, or M17 of the program itself."""
        return self.flow.has_ended

    def may_restart(self) -> bool:
        """True where nothing of earlier blocks is still to come."""
        return self.flow.executor.can_restart

    def find_chunk(self) -> Chunk | None:
        """The chunk of the next line; None where the section ends."""
        line = self.calls.line
        return self.calls.text.find_chunk(line) if line <= self.calls.frame.section.last else None

    def execute(self, chunk: Chunk, stop: StopConditions) -> tuple[int, list[ProgramError]]:
        """Execute the next line, or a stretch at once; a line that only follows from an error before it is passed."""
        line, text, last = self.calls.line, self.calls.text, None
        raw = chunk.read_raw(line - chunk.first_line)
        code = decode_line(raw)

        def execute(words: str) -> None:
            nonlocal last
            if words is code:
                last = execute_stretch(self.flow, chunk, stop)
            else:
                self.calls.line = line
            if last is None:
                self.flow.step(raw if words is code else words.encode())

        def correct(words: str, error: ProgramError) -> str | None:
            return None if stop.first_error or self.calls.text is not text else _correct(words, error)

        give_up = partial(self.flow.executor.interpreter.recorder.give_up, self.calls.show(line))
        errors, rest = execute_as_meant(code, give_up, execute, correct)
        if rest is not None:
            last = None
            if self.flow.executor.pass_failed(raw if rest is code else rest.encode(), errors[-1]):
                errors.pop()
        return last or line + 1, [error for error in errors if self._note_name(error, text, line)]

    def _note_name(self, error: ProgramError, text: SiemensText, line: int) -> bool:
        """Whether an error is to be reported: of a name that is not defined, the line that uses it first is told.

        In a loop that line ends the execution when it comes again, so that nothing is left out there.
        """
        match = _NO_VARIABLE.match(error.message)
        return match is None or self._undefined_names.setdefault((text, match[1]), line) == line

    def end_text(self, execution: Execution) -> bool:
        """The section ends: return from it, or end the program."""
        if self.flow.end_section():
            return True
        self.flow.executor.finish()
        execution.recorder.record_event(max(self.calls.line - 1, 1), "end", code="end of file")
        return False

    def leave_call(self) -> None:
        """Go back to where the last subprogram was called, as far as it was executed."""
        self.calls.leave()
        self.flow.executor.variables.scopes.pop()


def _correct(text: str, error: ProgramError) -> str | None:
    """The line with the word that is meant; None for words of branches and loops, whose partners the text has."""
    correction = find_correction(error.message)
    words = [""] if correction is None else correction[1].upper().split()
    is_jump = len(words) > 1 and "GOTO" in text.upper()
    is_control = words[0] in STATEMENTS and words[0] not in _WITHOUT_PARTNER and not is_jump
    return None if is_control else correct_line(text, error)
