"""Execution of a Siemens program: stretches of plain lines, single lines, and the ends of its sections."""

from verne_post.base.long_text import Text
from verne_post.base.suggestions import find_correction
from verne_post.gcode.execution import Execution, StopConditions, run_program
from verne_post.gcode.machining.state import State
from verne_post.gcode.mistyped import correct_line, shift_back
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.siemens.executor import Executor
from verne_post.gcode.siemens.flow import Flow
from verne_post.gcode.siemens.program import SiemensText
from verne_post.gcode.siemens.stretch import execute_stretch
from verne_post.gcode.siemens.vocabulary import STATEMENTS
from verne_post.gcode.text import Chunk, decode_line


def execute_siemens(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    """Execute a Siemens program from its first line on, until it ends or a stop condition is met."""
    execution = Execution(state, Recorder(language="siemens"))
    flow = Flow(SiemensText(source, setup), Executor(setup, state, execution.recorder))
    return run_program(_SiemensRun(flow), execution, setup, stop)


class _SiemensRun:
    """A Siemens program in execution."""

    def __init__(self, flow: Flow) -> None:
        self.flow, self.calls = flow, flow.calls

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
        line = self.calls.line
        raw = chunk.read_raw(line - chunk.first_line)
        text = self.calls.text
        try:
            last = execute_stretch(self.flow, chunk, stop, in_main=self.calls.in_main)
            if last is None:
                self.flow.step(raw)
        except ProgramError as error:
            corrected_line = _correct(raw, error)
            if corrected_line is None or stop.first_error or self.calls.text is not text:
                return line + 1, [] if self.flow.executor.pass_failed(raw, error) else [error]
            self.calls.line = line
            return line + 1, self._go_on(error, corrected_line)
        return last or line + 1, []

    def _step(self, raw: bytes) -> list[ProgramError]:
        """Execute a line whose misspelt word is corrected; its other errors."""
        line = self.calls.line
        try:
            self.flow.step(raw)
        except ProgramError as error:
            if (corrected_line := _correct(raw, error)) is not None:
                self.calls.line = line
                return self._go_on(error, corrected_line)
            return [] if self.flow.executor.pass_failed(raw, error) else [error]
        return []

    def _go_on(self, error: ProgramError, corrected_line: str) -> list[ProgramError]:
        """The error of a misspelt word, and those of its line with the word that is meant."""
        later_errors = self._step(corrected_line.encode())
        shift_back(error, later_errors)
        return [error, *later_errors]

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


def _correct(raw: bytes, error: ProgramError) -> str | None:
    """The line with the word that is meant; None for words of branches and loops, whose partners the text has."""
    correction = find_correction(error.message)
    is_control = correction is not None and correction[1] in STATEMENTS and correction[1] != "MCALL"
    return None if is_control else correct_line(decode_line(raw), error)
