"""A whole text of CLDATA: its statements one after the other, stretches of GOTO at once."""

from verne_post.base.long_text import Text
from verne_post.gcode.apt.statements import Points, Statement, read_statements
from verne_post.gcode.apt.stretch import execute_points
from verne_post.gcode.apt.subprograms import expand_calls
from verne_post.gcode.apt.translator import Translator
from verne_post.gcode.execution import Execution, StopConditions, all_known, may_restart
from verne_post.gcode.machining.state import State
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.rs274.interpreter import Rs274
from verne_post.gcode.rs274.recovery import Recovery
from verne_post.gcode.setup import Setup


def execute_text(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    """Execute a text up to FINI; errors are reported in the execution."""
    execution = Execution(state, Recorder())
    run = _Run(execution, Rs274(setup, state, execution.recorder), stop)
    for item, called in expand_calls(read_statements(source)):
        if isinstance(item, Points):
            ended = run.execute_points(item, called=called)
        else:
            ended = run.execute(item, called=called)
        if ended:
            return execution
    last_line = max(source.count(b"\n") + (not source.endswith(b"\n")), 1)
    execution.report_at_line("VP010", "the text ends without FINI", last_line)
    return execution


class _Run:
    """Executes statements; each method tells whether the execution ends there."""

    def __init__(self, execution: Execution, interpreter: Rs274, stop: StopConditions) -> None:
        self.execution, self.interpreter, self.stop = execution, interpreter, stop
        self.translator = Translator(interpreter.state, interpreter.setup.coordinates)
        self.recovery = None if stop.first_error else Recovery(interpreter)
        self.line = 0

    def execute(self, item: Statement | ProgramError, *, called: bool) -> bool:
        """One statement; ``called``: of a subprogram."""
        stop, state = self.stop, self.interpreter.state
        self.line = line = item.line or self.line
        after = stop.after_line is not None and line > stop.after_line
        if not called and (after or (stop.before_line is not None and line >= stop.before_line)):
            return True
        self._trace(line, line + 1, called=called)
        try:
            if isinstance(item, ProgramError):
                raise item
            for block in self.translator.blocks(item):
                if self.recovery is None:
                    self.interpreter.execute(block)
                elif not self.execution.report_all(self.recovery.execute(block), line):
                    return True
        except ProgramError as error:
            if not self.execution.report(error, line) or stop.first_error:
                return True
        return self.interpreter.ended or (stop.all_known and all_known(state, self.interpreter.setup))

    def execute_points(self, points: Points, *, called: bool) -> bool:
        """A stretch of GOTO: one by one as long as modes or errors ask for it, the others at once."""
        row = 0
        while row < len(points):
            if self.execute(points.statement(row), called=called):
                return True
            row += 1
            last = self.stop.cut(points.line + row, points.line + len(points), in_main=not called) - points.line
            done = execute_points(points, row, last, self.translator, self.interpreter)
            if done > row:
                self.line = points.line + done - 1
                self._trace(points.line + row, points.line + done, called=called)
                row = done
        return False

    def _trace(self, first: int, last: int, *, called: bool) -> None:
        if self.stop.trace is not None and not called:
            restart = may_restart(self.interpreter.state) and self.translator.cycle is None
            self.stop.trace.add(first, last, may_restart=restart)
