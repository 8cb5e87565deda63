"""One pass over a program of blocks: chunks, stretches of plain lines, single blocks, errors collected."""

from dataclasses import dataclass, field
from typing import Final

from verne_post.base.long_text import Text
from verne_post.gcode import plain
from verne_post.gcode.expressions import BlockError
from verne_post.gcode.flow import Flow
from verne_post.gcode.interpret import Interpreter
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.state import State
from verne_post.gcode.text import Chunk, ProgramText, decode_line
from verne_post.model.findings import Finding, finding
from verne_post.model.moves import AXES

#: So many errors are reported at most: behind them a file is not G-code.
MAX_ERRORS: Final = 50


#: Errors behind which a program does not go on: where it would is not known.
_FATAL: Final = ("VP023", "VP024", "VP027")


@dataclass
class Pass:
    """One interpretation of a program, or of its beginning."""

    state: State
    recorder: Recorder
    errors: list[Finding]
    seen: set[tuple[int, str, str]] = field(default_factory=set)


@dataclass
class Trace:
    """Lines that the program itself executes, in order, without those of calls.

    A span is (first line, line behind the last, whether a restart may begin there): not while cutter compensation or a
    canned cycle holds, for what comes then depends on what was before.
    """

    spans: list[tuple[int, int, bool]] = field(default_factory=list)

    def note(self, first: int, last: int, *, open_: bool) -> None:
        """Note lines ``first`` to ``last`` (excluded) that have been executed."""
        if self.spans and self.spans[-1][1:] == (first, open_):
            first = self.spans.pop()[0]
        self.spans.append((first, last, open_))


@dataclass(frozen=True)
class Stops:
    """Where a pass ends before the program does, and what it notes on the way.

    ``known``: as soon as every axis is known; ``error``: at the first error; ``line``: behind the first execution of a line;
    ``before``: when the program itself, outside of calls, comes to a line.
    """

    known: bool = False
    error: bool = False
    line: int | None = None
    before: int | None = None
    trace: Trace | None = None


def run_blocks(source: Text, setup: Setup, state: State, stops: Stops, language: type[Interpreter]) -> Pass:
    """Execute the blocks of a program from the first on, until it ends or a stop is met."""
    recorder = Recorder()
    run = Pass(state, recorder, [])
    machine = language(setup, state, recorder)
    main = ProgramText(source, setup, language)
    flow = Flow(main, machine)
    while not machine.ended:
        text, line = flow.text, flow.line
        chunk = text.chunk(line)
        if chunk is None or line == text.closing:
            _end_of_text(run, flow, line, machine)
            break
        own = text is main and not flow.in_call
        if own and line == stops.before:
            break
        open_ = may_restart(state)
        try:
            if not _stretch(flow, chunk, machine, stops):
                _one_block(flow, chunk.raw[line - chunk.first_line], machine)
                if own and stops.trace is not None:
                    stops.trace.note(line, line + 1, open_=open_)
            elif own and stops.trace is not None:
                stops.trace.note(line, flow.line, open_=open_)
        except BlockError as error:
            name, shown = flow.text.name, flow.shown_line
            if not note(run, error, line, shown_line=shown, file=name) or stops.error:
                break
        if stops.known and all_known(state, setup):
            break
        if stops.line is not None and text is main and line <= stops.line < flow.line:
            break
    return run


def may_restart(state: State) -> bool:
    """True where the next block does not depend on how the one before has moved."""
    return state.compensation is None and state.centre is None and state.cycle is None


def all_known(state: State, setup: Setup) -> bool:
    """True when the place of every axis of the machine is known."""
    return all(state.known[AXES.index(letter)] for letter in setup.axes)


def _stretch(flow: Flow, chunk: Chunk, machine: Interpreter, stops: Stops) -> bool:
    """Execute a stretch of plain lines at once; False where there is none."""
    row = flow.line - chunk.first_line
    last = chunk.ends[row]
    if flow.text.closing is not None:
        last = min(last, flow.text.closing - chunk.first_line)
    if stops.line is not None and flow.text is flow.main and flow.line <= stops.line:
        last = min(last, stops.line + 1 - chunk.first_line)
    if stops.before is not None and flow.text is flow.main and flow.line < stops.before:
        last = min(last, stops.before - chunk.first_line)
    if last - row < plain.MIN_LINES or not plain.ready(machine.state, chunk.lines, row):
        return False
    done = plain.execute(chunk.lines, row, last, machine.setup, machine.state, machine.recorder, flow.shown_line)
    if done > row:
        first, flow.line = flow.line, flow.line + done - row
        flow.count(flow.text, first, flow.line - 1, 0)
    return done > row


def _one_block(flow: Flow, raw: bytes, machine: Interpreter) -> None:
    text, line, moves = flow.text, flow.line, machine.recorder.count
    flow.line += 1
    _execute(flow, raw, machine, line)
    flow.count(text, line, line, machine.recorder.count - moves)


def _execute(flow: Flow, raw: bytes, machine: Interpreter, line: int) -> None:
    deleted = machine.setup.block_delete and raw.lstrip().startswith(b"/")
    if line == flow.text.opening or deleted or not raw.strip():
        return
    machine.parameters.line = line
    block = machine.read(decode_line(raw), line)
    if block.o is not None:
        flow.step(block)
        return
    block.line = flow.shown_line or line
    machine.execute(block)
    if machine.call is not None and not machine.ended:
        flow.follow(machine.call, line)


def note(run: Pass, error: BlockError, line: int, *, shown_line: int | None = None, file: str | None = None) -> bool:
    """Note an error; False where reading cannot go on behind it.

    ``shown_line`` stands for lines of another ``file``.
    """
    line = error.line or line
    shown = shown_line or line
    message = error.message if file is None else f"{file}, line {line}: {error.message}"
    again = (shown, error.code, message) in run.seen
    run.seen.add((shown, error.code, message))
    if not again:
        column = error.column if file is None else None
        run.errors.append(finding(error.code, message, line=shown, last_line=shown, worst_line=shown, column=column))
    # an error that comes again is in a loop, whose end may depend on what was not done
    return not again and error.code not in _FATAL and len(run.errors) < MAX_ERRORS


def _end_of_text(run: Pass, flow: Flow, line: int, machine: Interpreter) -> None:
    """The text is over without M2 or M30: right only with a pair of %."""
    text = flow.text
    if flow.in_call:
        what = f"the text ends inside a subroutine{f' ({text.name})' if text.name else ''}; expected endsub or M99"
    elif text.opening is not None and text.closing is not None:
        machine.recorder.event(line, "end", code="%")
        return
    else:
        what = f"the file ends without {'M2, M30 or a closing %' if text.opening is not None else 'M2 or M30'}"
    at = flow.shown_line or max(text.n_lines, 1)
    run.errors.append(finding("VP010", what, line=at, last_line=at, worst_line=at))
