"""A whole text of CLDATA: statements in order, stretches of GOTO at once, subprograms where they are called."""

from collections.abc import Iterator
from typing import Final

from msgspec.structs import replace

from verne_post.base.long_text import Text
from verne_post.base.suggestions import find_correction
from verne_post.gcode.apt.interpreter import AptInterpreter
from verne_post.gcode.apt.modes import AptModes
from verne_post.gcode.apt.slips import correct_number, correct_sign
from verne_post.gcode.apt.statements import Points, Statement, read_statements
from verne_post.gcode.apt.stretch import execute_points
from verne_post.gcode.apt.translator import OF_SUBPROGRAMS, STATEMENTS, make_blocks, refuse_statement
from verne_post.gcode.apt.words import REFUSED_WORDS, REMARKS, WITHOUT_EFFECT
from verne_post.gcode.execution import Execution, StopConditions, knows_all, may_restart
from verne_post.gcode.machining.assumptions import assume_feed, assume_length
from verne_post.gcode.machining.state import State
from verne_post.gcode.mistyped import UNREADABLE
from verne_post.gcode.program_error import ProgramError, end_with
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.rs274.recovery import Recovery
from verne_post.gcode.setup import Setup
from verne_post.model.control_keys import AptKeys, read_keys

#: Remarks that only Creo writes, and bytes of a text among which they begin.
_SYSTEM_REMARK: Final = b"$$->"
_HEAD: Final = 1 << 16
#: Errors that a mistyped number may be the cause of.
_OF_NUMBERS: Final = ("VP001", "VP002", "VP005")
#: Words that are not misspelt.
_KNOWN_WORDS: Final = frozenset((*STATEMENTS, *REMARKS, *WITHOUT_EFFECT, *REFUSED_WORDS))
_Item = Statement | Points | ProgramError


def execute_text(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    """Execute a text up to FINI; errors are reported in the execution."""
    execution = Execution(state, Recorder(language="aptcl"))
    lists_arcs = _SYSTEM_REMARK in source[:_HEAD]
    run = _Run(execution, AptInterpreter(setup, state, execution.recorder), stop, lists_arcs=lists_arcs)
    for item, is_called in _expand_calls(read_statements(source)):
        if isinstance(item, Points):
            has_ended = run.execute_points(item, is_called=is_called)
        else:
            has_ended = run.execute(item, is_called=is_called)
        if has_ended:
            return execution
    if run.ended_path:
        return execution
    last_line = max(source.count(b"\n") + (not source.endswith(b"\n")), 1)
    execution.report_at_line("VP010", "the text ends without FINI", last_line, edits=end_with("FINI"))
    return execution


class _Run:
    """Executes statements; each method tells whether the execution ends there."""

    def __init__(
        self, execution: Execution, interpreter: AptInterpreter, stop: StopConditions, *, lists_arcs: bool
    ) -> None:
        self.execution, self.interpreter, self.stop = execution, interpreter, stop
        setup, state = interpreter.setup, interpreter.state
        keys = read_keys(AptKeys, setup.control.get("aptcl", {}))
        self.modes = AptModes(setup, state, execution.recorder, keys, lists_arcs, knows_unit=bool(keys.units))
        self.recovery = None if stop.first_error else Recovery(interpreter)
        self.line = 0
        #: The last statement was END-OF-PATH, with which the texts of some writers end.
        self.ended_path = False

    def execute(self, item: Statement | ProgramError, *, is_called: bool) -> bool:
        """One statement; ``is_called``: of a subprogram."""
        stop, state = self.stop, self.interpreter.state
        self.line = line = item.line or self.line
        after = stop.after_line is not None and line > stop.after_line
        if not is_called and (after or (stop.before_line is not None and line >= stop.before_line)):
            return True
        self._trace(line, line + 1, is_called=is_called)
        if stop.trace is not None and not is_called and isinstance(item, Statement) and item.n_lines > 1:
            stop.trace.add(line + 1, line + item.n_lines, may_restart=False)
        try:
            if isinstance(item, ProgramError):
                raise item
            self.ended_path = item.major == "END-OF-PATH"
            for block in make_blocks(self.modes, item):
                if self.recovery is None:
                    self.interpreter.execute(block)
                elif not self.execution.report_all(self.recovery.execute(block), line) and not self.stop.past_errors:
                    return True
        except ProgramError as error:
            self.execution.recorder.give_up(line)
            major = item.major if isinstance(item, Statement) else ""
            is_unread = not major or (isinstance(item, Statement) and "" in item.words)  # it may be any statement
            if is_unread or error.code == "VP002" or major == "FEDRAT":  # FEDRAT may be what is misspelt
                assume_feed(state)
            if is_unread or (major.startswith("LOAD") and error.code in UNREADABLE):
                assume_length(state)
            if major == "CYCLE":  # the cycle before holds no longer
                self.modes.cycle = None
            reading = None
            if isinstance(item, Statement) and error.code in _OF_NUMBERS:
                reading = correct_sign(item, _KNOWN_WORDS) or correct_number(item)
            if reading is not None:
                error, item = reading
            if (not self.execution.report(error, line) and not stop.past_errors) or stop.first_error:
                return True
            if reading is not None:
                return self.execute(item, is_called=is_called)
            correction = find_correction(error.message)
            if correction is not None and isinstance(item, Statement):
                if item.major == correction[0]:
                    return self.execute(replace(item, major=correction[1]), is_called=is_called)
                if item.words and item.words[0].upper() == correction[0]:
                    words = (correction[1], *item.words[1:])
                    return self.execute(replace(item, words=words), is_called=is_called)
        return self.interpreter.has_ended or (stop.all_known and knows_all(state, self.interpreter.setup))

    def execute_points(self, points: Points, *, is_called: bool) -> bool:
        """A stretch of GOTO: one by one as long as modes or errors ask for it, the others at once."""
        row = 0
        while row < len(points):
            if self.execute(points.make_statement(row), is_called=is_called):
                return True
            row += 1
            last = self.stop.cut(points.line + row, points.line + len(points), is_about=not is_called) - points.line
            stretch = execute_points(points, row, last, self.modes, self.interpreter)
            if stretch > row:
                self.line = points.line + stretch - 1
                self._trace(points.line + row, points.line + stretch, is_called=is_called)
                row = stretch
        return False

    def _trace(self, first: int, last: int, *, is_called: bool) -> None:
        if self.stop.trace is not None and not is_called:
            restart = may_restart(self.interpreter.state) and self.modes.cycle is None
            self.stop.trace.add(first, last, may_restart=restart)


def _expand_calls(items: Iterator[_Item]) -> Iterator[tuple[_Item, bool]]:
    """Statements in the order in which they are executed, and whether each stands in a subprogram.

    A subprogram is defined before it is called, calls none itself, and does nothing where it is defined.
    """
    subprograms: dict[str, list[_Item]] = {}
    open_name, open_line = "", 0
    for item in items:
        if isinstance(item, Statement) and item.major not in _KNOWN_WORDS:
            error, reading = refuse_statement(item), correct_sign(item, OF_SUBPROGRAMS)
            correction = find_correction(error.message)
            if reading is not None:
                error, item = reading
                error.line = item.line
                yield error, False
            elif correction is not None and correction[1] in OF_SUBPROGRAMS:
                yield error, False
                item = replace(item, major=correction[1])
        if not isinstance(item, Statement) or item.major not in OF_SUBPROGRAMS:
            if open_name:
                subprograms[open_name].append(item)
            else:
                yield item, False
            continue
        name = item.text.upper()
        problem = _find_problem(item, name, subprograms, open_name)
        if problem is not None:
            yield problem, False
        elif item.major == "DEFSUB":
            subprograms[name], open_name, open_line = [], name, item.line
        elif item.major == "ENDSUB":
            open_name = ""
        else:
            yield from ((inner, True) for inner in subprograms[name])
    if open_name:
        yield ProgramError("VP010", f"DEFSUB/{open_name} without ENDSUB", line=open_line), False


def _find_problem(
    item: Statement, name: str, subprograms: dict[str, list[_Item]], open_name: str
) -> ProgramError | None:
    """What is wrong with one of the three statements."""
    code, message = "VP017", ""
    if item.major == "ENDSUB":
        message = "" if open_name else "ENDSUB, and no DEFSUB before it"
    elif open_name:
        message = f"{item.major} inside DEFSUB/{open_name}; write ENDSUB before"
    elif len(item.words) != 1:
        code, message = "VP005", f"{item.major} takes the name of one subprogram"
    elif item.major == "DEFSUB" and name in subprograms:
        message = f"DEFSUB/{name} for the second time"
    elif item.major == "CALSUB" and name not in subprograms:
        message = f"CALSUB/{name}: no DEFSUB/{name} comes before it"
    return ProgramError(code, message, line=item.line) if message else None
