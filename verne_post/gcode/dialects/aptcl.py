"""APT cutter location text (CLDATA as CAM systems write it): GOTO with tool axis, RAPID, FEDRAT, CIRCLE, CYCLE.

Each statement becomes blocks of the interpreter: the same modes, checks and moves as in any other program.
docs/gcode.md lists the statements.
"""

import re
from typing import Final

from verne_post.base.long_text import Text
from verne_post.gcode.apt.statements import read_statements
from verne_post.gcode.apt.subprograms import expand_calls
from verne_post.gcode.apt.translator import Translator
from verne_post.gcode.dialect import Dialect
from verne_post.gcode.execution import Execution, StopConditions, all_known, may_restart
from verne_post.gcode.expressions import BlockError
from verne_post.gcode.initial_state import initial_state
from verne_post.gcode.interpret import Interpreter
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.recovery import Recovery
from verne_post.gcode.setup import Setup
from verne_post.gcode.state import State

_HEADER: Final = re.compile(
    rb"\s*(?:\$\$[^\n]*\n\s*)*(?:PARTNO|MACHIN\s*/|UNITS\s*/|MULTAX|FROM\s*/|LOADTL\s*/|TOOL PATH/|PPRINT)",
    re.IGNORECASE,
)


def _recognise(source: Text) -> bool:
    """A statement with which only CLDATA begins."""
    return _HEADER.match(source[: 1 << 16]) is not None


def _initial_state(setup: Setup) -> State:
    """Tool vectors, absolute, mm."""
    state = initial_state(setup)
    state.vectors = True
    state.tool_axis = (0.0, 0.0, 1.0)
    return state


def _execute(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    execution = Execution(state, Recorder())
    interpreter = Interpreter(setup, state, execution.recorder)
    translator = Translator(state, setup.coordinates)
    recovery = None if stop.first_error else Recovery(interpreter)
    line = 0
    for item, called in expand_calls(read_statements(source)):
        line = item.line or line
        after = stop.after_line is not None and line > stop.after_line
        if not called and (after or (stop.before_line is not None and line >= stop.before_line)):
            return execution
        if stop.trace is not None and not called:
            stop.trace.add(line, line + 1, may_restart=may_restart(state) and translator.cycle is None)
        try:
            if isinstance(item, BlockError):
                raise item
            for block in translator.blocks(item):
                if recovery is None:
                    interpreter.execute(block)
                elif not execution.report_all(recovery.execute(block), line):
                    return execution
        except BlockError as error:
            if not execution.report(error, line) or stop.first_error:
                return execution
        if interpreter.ended or (stop.all_known and all_known(state, setup)):
            return execution
    last_line = max(source.count(b"\n") + (not source.endswith(b"\n")), 1)
    execution.report_at_line("VP010", "the text ends without FINI", last_line)
    return execution


def _names_axis(_source: Text, letter: str, _setup: Setup) -> bool:
    """GOTO names every axis: its tool axis those that turn."""
    return letter in "XYZAC"


DIALECT: Final[Dialect] = Dialect(_recognise, _initial_state, _execute, _names_axis)
