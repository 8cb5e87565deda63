"""Execution of a program of blocks: chunks, stretches of plain lines, single blocks; errors are collected."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, Final

from msgspec import Struct, field

from verne_post.base.long_text import Text
from verne_post.gcode import plain
from verne_post.gcode.block import Block
from verne_post.gcode.machining.state import State
from verne_post.gcode.missing_setup import ONE_TOOL
from verne_post.gcode.plain_vectors import end_of_vectors, pointing
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.rs274.flow import Flow
from verne_post.gcode.rs274.interpreter import Rs274
from verne_post.gcode.rs274.recovery import FATAL, Recovery
from verne_post.gcode.setup import Setup
from verne_post.gcode.templates import word_columns
from verne_post.gcode.text import Chunk, ProgramText, decode_line
from verne_post.model.findings import Finding, finding
from verne_post.model.moves import AXES

#: So many things that errors of one cause are about are named.
_NAMED: Final = 8
#: At most so many findings, and errors that they count: a file with more is not G-code, or has one mistake in every line.
MAX_ERRORS, MAX_COUNTED = 50, 1_000


class Execution(Struct):
    """One execution of a program, or of its beginning: the state at its end, what was recorded, and the errors."""

    state: State
    recorder: Recorder
    errors: list[Finding] = field(default_factory=list)
    _reported: set[tuple[int, str, str]] = field(default_factory=set)
    #: Where the finding of each cause stands among the errors, and what it is about.
    _causes: dict[tuple[str, str], tuple[int, list[str]]] = field(default_factory=dict)
    _counted: int = 0

    def report(self, error: ProgramError, line: int, *, shown_line: int | None = None, file: str | None = None) -> bool:
        """Report an error; False where execution cannot go on after it.

        ``shown_line`` stands for lines of another ``file``. Errors of the same words have one cause, and are one finding.
        """
        line = error.line or line
        shown = shown_line or line
        message = error.message if file is None else f"{file}, line {line}: {error.message}"
        key = (shown, error.code, message)
        if key in self._reported:  # the error is in a loop, whose end may depend on what was not executed
            return False
        self._reported.add(key)
        column = error.column if file is None else None
        self.report_at_line(error.code, message, shown, column, error.about, error.settled_by)
        self._counted += 1
        return error.code not in FATAL and len(self.errors) < MAX_ERRORS and self._counted < MAX_COUNTED

    def report_all(self, errors: Iterable[ProgramError], line: int, **where: Any) -> bool:
        """Report the errors of one block; False where execution cannot go on after them."""
        return all(self.report(error, line, **where) for error in errors)

    def report_at_line(
        self,
        code: str,
        message: str,
        line: int,
        column: int | None = None,
        about: str | None = None,
        settled_by: tuple[str, ...] = (),
    ) -> None:
        """Add an error of one line, or count it with those of its cause; it then names everything that they are about."""
        words = message if about is None else message.replace(about, "\0")
        at, things = self._causes.setdefault((code, words), (len(self.errors), []))
        if about is not None and about not in things:
            things.append(about)
        if at == len(self.errors):
            where = {"line": line, "last_line": line, "worst_line": line, "column": column}
            self.errors.append(finding(code, message, settled_by=(settled_by,) if settled_by else (), **where))
            return
        item = self.errors[at]
        settled = item.settled_by if settled_by in item.settled_by or not settled_by else (*item.settled_by, settled_by)
        self.errors[at] = replace(
            item, last_line=max(item.last_line or line, line), count=item.count + 1,
            message=words.replace("\0", _names(things)).replace(ONE_TOOL if len(things) > 1 else "\0", ""),
            settled_by=settled,
        )  # fmt: skip


def _names(things: list[str]) -> str:
    """Tool 1, tool 2 and tool 3."""
    shown = things if len(things) <= _NAMED else [*things[: _NAMED - 1], f"{len(things) - _NAMED + 1} more"]
    return " and ".join((*([", ".join(shown[:-1])] if shown[:-1] else []), *shown[-1:]))


class LineTrace(Struct):
    """Lines that the program itself executes, in order, without those of calls.

    A span is (first line, line after the last, whether a restart may begin there). It may not while cutter compensation
    or a canned cycle is active, or while control points of a spline are read: the next block then depends on those before.
    """

    spans: list[tuple[int, int, bool]] = field(default_factory=list)

    def add(self, first: int, last: int, *, may_restart: bool) -> None:
        """Add lines ``first`` to ``last`` (excluded), which have been executed."""
        if self.spans and self.spans[-1][1:] == (first, may_restart):
            first = self.spans.pop()[0]
        self.spans.append((first, last, may_restart))


class StopConditions(Struct, frozen=True):
    """Where an execution ends before the program does, and whether it traces its lines.

    Attributes
    ----------
    all_known : bool
        As soon as the position of every axis is known.
    first_error : bool
        At the first error, which is raised; without it all errors are collected.
    after_line : int or None
        After the first execution of a line.
    before_line : int or None
        When the program itself, outside of calls, comes to a line.
    trace : LineTrace or None
        Gets the executed lines.
    """

    all_known: bool = False
    first_error: bool = False
    after_line: int | None = None
    before_line: int | None = None
    trace: LineTrace | None = None

    def cut(self, line: int, last: int, *, in_main: bool) -> int:
        """The line before which a stretch from ``line`` to ``last`` (excluded) must end."""
        if in_main and self.after_line is not None and line <= self.after_line:
            last = min(last, self.after_line + 1)
        if in_main and self.before_line is not None and line < self.before_line:
            last = min(last, self.before_line)
        return last

    def is_met(self, state: State, setup: Setup, line: int, then: int, *, in_main: bool) -> bool:
        """Whether a line that has been executed was the last one; ``then`` is the one that would follow."""
        passed = self.after_line is not None and in_main and line <= self.after_line < then
        return passed or (self.all_known and all_known(state, setup))


def execute_blocks(source: Text, setup: Setup, state: State, stop: StopConditions, language: type[Rs274]) -> Execution:
    """Execute the blocks of a program from the first on, until it ends or a stop condition is met."""
    execution = Execution(state, Recorder())
    execution.recorder.says_tcp = False  # until a code does
    interpreter = language(setup, state, execution.recorder)
    main = ProgramText(source, setup, language)
    flow = Flow(main, interpreter)
    recovery = None if stop.first_error else Recovery(interpreter)
    if main.first_line > 1:
        execution.recorder.event(1, "not executed", text=f"lines 1 to {main.first_line - 1}, before the %")
    watched = stop.all_known or stop.after_line is not None
    while not interpreter.ended:
        text, line, shown_line = flow.text, flow.line, flow.shown_line  # a return may already have left them
        chunk = text.chunk(line)
        if chunk is None or line == text.closing:
            _end_text(execution, flow)
            break
        in_main = text is main and not flow.in_call
        if in_main and line == stop.before_line:
            break
        restart = stop.trace is not None and may_restart(state) and interpreter.may_restart()
        errors: list[ProgramError] = []
        try:
            if not _execute_stretch(flow, chunk, stop):
                errors = _execute_line(flow, chunk, recovery)
                last = line + 1
            else:
                last = flow.line
            if in_main and stop.trace is not None:
                stop.trace.add(line, last, may_restart=restart)
        except ProgramError as error:
            errors.append(error)
        if errors and (
            not execution.report_all(errors, line, shown_line=shown_line, file=text.name) or stop.first_error
        ):
            break
        if watched and stop.is_met(state, setup, line, flow.line, in_main=text is main):
            break
    return execution


def may_restart(state: State) -> bool:
    """True where the core lets a program begin: the next move does not depend on how the one before has moved."""
    return state.compensation is None and state.centre is None


def all_known(state: State, setup: Setup) -> bool:
    """True when the position of every axis of the machine is known."""
    return all(state.known[AXES.index(letter)] for letter in setup.axes)


def _execute_stretch(flow: Flow, chunk: Chunk, stop: StopConditions) -> bool:
    """Execute a stretch of plain lines at once; False where there is none."""
    interpreter, row = flow.interpreter, flow.line - chunk.first_line
    last = chunk.lines.end(row)
    if last - row < plain.MIN_LINES:
        return False
    if flow.text.closing is not None:
        last = min(last, flow.text.closing - chunk.first_line)
    last = stop.cut(flow.line, last + chunk.first_line, in_main=flow.text is flow.main) - chunk.first_line
    view = interpreter.view_plain_lines(has_vector=bool(chunk.lines.has_offsets[row]))
    if view is None:
        return False
    if not view.turning:
        last = min(last, chunk.lines.find_turning(row))
    if view.pointed:
        last = end_of_vectors(interpreter.core, view, chunk.lines, row, last)
    if last - row < plain.MIN_LINES or not plain.is_ready(interpreter.state, view, chunk.lines, row):
        return False
    point = pointing(interpreter.core, chunk.lines) if view.pointed else None
    done = plain.execute(chunk.lines, row, last, interpreter.core, view, flow.shown_line, point)
    if done > row:
        interpreter.go_on_after_plain_lines(view)
        first, flow.line = flow.line, flow.line + done - row
        flow.repeats.count(flow.text, first, flow.line - 1, 0)
    return done > row


def _execute_line(flow: Flow, chunk: Chunk, recovery: Recovery | None) -> list[ProgramError]:
    """Execute a line; with recovery its errors are returned, without the first is raised."""
    text, line, interpreter = flow.text, flow.line, flow.interpreter
    moves, row = interpreter.recorder.count, line - chunk.first_line
    errors: list[ProgramError] = []
    flow.line += 1
    interpreter.parameters.line = line
    block = chunk.block(row, line) if interpreter.reads_plain_words else None
    try:
        if block is not None:
            errors = _execute_block(flow, block, line, recovery)
        elif line != text.opening and _is_executed(raw := chunk.raw(row), interpreter.setup):
            errors = _read_and_execute(flow, decode_line(raw), line, recovery)
    except ProgramError as error:
        _find_column(error, chunk.raw(row))
        raise
    for found in errors:
        _find_column(found, chunk.raw(row))
    flow.repeats.count(text, line, line, interpreter.recorder.count - moves)
    return errors


def _is_executed(raw: bytes, setup: Setup) -> bool:
    """False for blank lines, and for those that block delete leaves out."""
    return bool(raw.strip()) and not (setup.block_delete and raw.lstrip().startswith(b"/"))


def _find_column(error: ProgramError, raw: bytes) -> None:
    """Put the column of a word in place of its number in the line."""
    if error.column is not None and error.column < 0:
        error.column = word_columns(decode_line(raw))[-error.column - 1]


def _read_and_execute(flow: Flow, text: str, line: int, recovery: Recovery | None) -> list[ProgramError]:
    try:
        block = flow.interpreter.read(text, line)
    except ProgramError as error:
        if recovery is None:
            raise
        recovery.pass_unread(text, line)
        return [error]
    return _execute_block(flow, block, line, recovery)


def _execute_block(flow: Flow, block: Block, line: int, recovery: Recovery | None) -> list[ProgramError]:
    interpreter, errors = flow.interpreter, []
    if block.o is not None:
        flow.step(block)
        return []
    if block.macro is not None:
        flow.macros.step(block.macro, line)
        return []
    block.line = flow.shown_line or line
    if recovery is None:
        interpreter.execute(block)
    else:
        errors = recovery.execute(block)
    if interpreter.call is not None and not interpreter.ended:
        try:
            flow.follow(interpreter.call, line)
        except ProgramError as error:
            if recovery is None:
                raise
            errors.append(error)
    return errors


def _end_text(execution: Execution, flow: Flow) -> None:
    """The text ends without M2 or M30: an error but for a pair of %."""
    text = flow.text
    percent = text.opening is not None
    if (unfinished := flow.interpreter.find_unfinished()) is not None:
        what = f"the text ends before {unfinished}"
    elif flow.in_call:
        what = f"the text ends inside a subroutine{f' ({text.name})' if text.name else ''}; expected endsub or M99"
    elif text.closing is not None or flow.interpreter.ends_with_text:
        execution.recorder.event(flow.line, "end", code="%")
        return
    else:
        what = f"the file ends without {'M2, M30 or a closing %' if percent else 'M2 or M30'}"
    execution.report_at_line("VP010", what, flow.shown_line or max(text.n_lines, 1))
