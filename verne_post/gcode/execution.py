"""Execution of a program line by line, in any language: the loop, its errors, where it stops, and what it traces."""

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, Final, Protocol

from msgspec import Struct, field

from verne_post.base.printable import join_names
from verne_post.base.program_lines import remove_remarks
from verne_post.base.suggestions import find_correction
from verne_post.gcode.calls import CallStack
from verne_post.gcode.loops import Loop
from verne_post.gcode.machining.state import State
from verne_post.gcode.missing_setup import NEAR_TOOL, ONE_TOOL
from verne_post.gcode.mistyped import drop_letter
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.text import Chunk, ChunkedText, decode_line, take_code
from verne_post.model.findings import CalledPlace, Finding, Remedy, add_line, make_finding
from verne_post.model.moves import AXES, OwnLine

#: So many things that errors of one cause are about are named.
_MOST_NAMES: Final = 8
#: Errors after which a program does not go on: the next line is not known.
FATAL: Final = ("VP023", "VP024", "VP027")
#: Errors that a line has whatever has been executed before it; a program that is missing is one of them (VP023).
OF_TEXT: Final = ("VP001", "VP002", "VP003", "VP004", "VP006", "VP011", "VP023")
#: Those after which what the line would have done is not known, unless a file of the user can give its word a meaning.
_OF_READING: Final = ("VP001", "VP002", "VP003", "VP004")
_TWICE: Final = ("VP003", "VP004")
#: Errors that may only follow from what such a line would have done: they are reported when it can be read.
_OF_STATE: Final = ("VP016", "VP017", "VP026", "VP031", "VP041")
#: Errors that positions lead to: they may only follow from a line that was read with a guess.
_OF_POSITIONS: Final = ("VP008", "VP013", "VP016")
#: The axis of a word that names a place.
_PLACE: Final = re.compile(r"(?<![A-Z_$])([A-CU-Z])[ \t]*=?[ \t]*(?=[-+.\d])")
#: Statements that say which lines come next, or set what such a statement asks for: in every language, with a letter O
#: for a zero.
_OF_ORDER: Final = re.compile(
    r"^[ \t/]*+(?:N?\d++[ \t]*+)?(?:[#<O]|Q[LRS]?\d++[ \t]*+=|FN\b|(?:R\d++|[A-Z_]\w{2,80}+)[ \t]*+=)"
    r"|(?<![A-Z_])(?:IF|ELSE|WHILE|UNTIL|REPEAT[BP]?|LOOP|FOR|CASE|DO\d|END(?:IF|FOR|WHILE|LOOP|\d)|GOTO[BCF]?|LBL|RET"
    r"|(?<!TOOL )(?<!CYCL )(?:CALL|DEF))(?![A-Z])"
    r"|(?<![A-Z_])M[0O]*+(?:2|17|3[0O]++|9[6-9])(?!\d)",
    re.IGNORECASE,
)
#: Most findings, and errors that they count: a file with more is no G-code, or has one mistake in every line.
MAX_ERRORS, MAX_COUNTED = 50, 1_000


class Execution(Struct):
    """One execution of a program, or of its beginning: the state at its end, what was recorded, and the errors."""

    state: State
    recorder: Recorder
    errors: list[Finding] = field(default_factory=list)
    _reported_errors: set[tuple[int, str, str]] = field(default_factory=set)
    #: Where the finding of each cause stands among the errors, what it is about, and its place in another file.
    _causes: dict[tuple[str, str], tuple[int, list[str], CalledPlace | None]] = field(default_factory=dict)
    is_lost: bool = False  #: A jump or a call leads nowhere, and lines behind it were not read.
    #: Lines of the program that a jump to nowhere is probably meant to pass over: what they say may be no program.
    _passed_lines: set[int] = field(default_factory=set)
    _error_count: int = 0
    _has_unread_line: bool = False
    #: Axes that stand where a misspelt word, as it was corrected, has sent them.
    _doubtful_axes: set[str] = field(default_factory=set)
    _refused_contour: int = 0  #: The line from which a compensation holds on whose contour a block is refused.

    def drop_wrong_corners(self, errors: list[ProgramError], contour: int) -> list[ProgramError]:
        """Leave out corners of a contour of which a block is refused: they are not where the program means them.

        ``contour`` is the line from which the compensation held before the ``errors``; 0 without one.
        """
        if contour and any(error.code in ("VP006", "VP008", "VP011") for error in errors):
            self._refused_contour = contour
        if not contour or contour != self._refused_contour:
            return errors
        return [error for error in errors if error.code != "VP026"]

    def drop_consequences(
        self, errors: list[ProgramError], chunk: Chunk, lines: range, moves: int
    ) -> list[ProgramError]:
        """Leave out what only follows from a place that was guessed, or that an arc does not end at, until it is named.

        ``lines`` of a chunk have been executed, after ``moves`` moves. Languages themselves know what follows from
        lines that they could not read.
        """
        corrections = [find_correction(error.message) for error in errors if error.code in ("VP001", "VP002")]
        guesses = [word[1] for one in corrections if one is not None and (word := _PLACE.match(one[1])) is not None]
        is_arc_wrong = any(error.code == "VP008" for error in errors)
        if not self._doubtful_axes and not guesses and not is_arc_wrong:
            return errors
        is_doubtful = bool(self._doubtful_axes or guesses)
        self._doubtful_axes.update(guesses)
        if not guesses and (errors or self.recorder.count > moves):
            for line in lines:
                text = take_code(decode_line(chunk.read_raw(line - chunk.first_line)))
                self._doubtful_axes.difference_update(_PLACE.findall(text.upper()))
                # the end of an arc that does not close may be what is wrong
                self._doubtful_axes.update(_PLACE.findall(text.upper()) if is_arc_wrong and not is_doubtful else ())
        if not is_doubtful:
            return errors
        return [error for error in errors if error.code not in _OF_POSITIONS]

    def report(self, error: ProgramError, line: int, *, shown_line: int | None = None, file: str | None = None) -> bool:
        """Report an error; False where execution cannot go on after it.

        ``shown_line`` stands for lines of another ``file``. Errors of the same words are one finding.
        """
        called_lines = self.recorder.lines.name_calls()
        if error.of_program:
            shown_line, file = None, None
        line = error.line or line
        if isinstance(line, OwnLine):
            line, file, shown_line = called_lines.find_file(line)
        shown_number = shown_line or line
        if file is None:
            if error.code in _OF_READING and line in self._passed_lines:
                return True
            self._passed_lines.update(range(line + 1, error.passes_to))
        message = called_lines.name_lines(error.message)
        place = None if file is None else CalledPlace(file, line, error.column)
        key = (shown_number, error.code, message if place is None else f"{place}: {message}")
        if (
            key in self._reported_errors and not error.of_value
        ):  # the error is in a loop, whose end may depend on what was not executed
            return False
        self._reported_errors.add(key)
        goes_on = error.goes_on or (error.code not in FATAL and not error.breaks_structure)
        self.is_lost |= (error.code == "VP023" or error.breaks_structure) and not goes_on
        if self._has_unread_line and error.code in _OF_STATE:
            return goes_on
        if error.code == "VP008" and any(
            at == shown_number and code != "VP008" for at, code, _ in self._reported_errors
        ):
            return goes_on  # the arc may lack what is wrong there
        is_unread = error.code in _OF_READING and not error.settled_by
        self._has_unread_line |= is_unread or error.leaves_unknown
        column = error.column if file is None else None
        there = (one if one.line or one.key else replace(one, line=shown_number) for one in error.edits)
        edits = called_lines.keep_edits(
            tuple(one for one in there if file is None or one.key or one.way == "end" or isinstance(one.line, OwnLine))
        )
        reason = error.about, error.settled_by, error.cause, edits, error.advice
        self.report_at_line(error.code, message, shown_number, column, *reason, place=place)
        if error.cause_line and file is None:
            self._move_to_cause(error.cause, error.cause_line)
        self._error_count += 1
        return goes_on and len(self.errors) < MAX_ERRORS and self._error_count < MAX_COUNTED

    def report_all(self, errors: Iterable[ProgramError], line: int, **where: Any) -> bool:
        """Report the errors of one block; False where execution cannot go on after them."""
        all_errors = list(errors)
        # beside its correction, a misspelt word that was one too many is there twice
        is_misspelt = len(all_errors) > 1 and all_errors[0].code in ("VP001", "VP002")
        kept_errors = (error for error in all_errors if not (is_misspelt and error.code in _TWICE))
        # nor has the code that a mistyped number is corrected to, as M80 for M8O, an error of its own
        mistyped_places = {(error.line, error.column) for error in all_errors if error.code == "VP001" and error.column}
        unknown_places = {(error.line, error.column) for error in all_errors if error.code == "VP002"}
        for error in all_errors:
            if error.code == "VP001" and (error.line, error.column) in unknown_places:
                error.message = drop_letter(error.message)
        return all(
            self.report(error, line, **where)
            for error in kept_errors
            if error.code != "VP002" or (error.line, error.column) not in mistyped_places
        )

    def report_at_line(
        self,
        code: str,
        message: str,
        line: int,
        column: int | None = None,
        about: str | None = None,
        settled_by: tuple[str, ...] = (),
        cause: str = "",
        edits: tuple[Remedy, ...] = (),
        advice: str | None = None,
        *,
        place: CalledPlace | None = None,
    ) -> None:
        """Add an error of a line, or count it with those of its cause, which then names everything concerned.

        It has the ``place`` in another file of the first of them.
        """
        words = message if about is None else message.replace(about, "\0")
        shared_words = NEAR_TOOL.sub("", words)
        words_of_cause = ("", cause) if cause else (code, f"{place.file}\0{shared_words}" if place else shared_words)
        at, things, place = self._causes.setdefault(words_of_cause, (len(self.errors), [], place))
        if cause and at < len(self.errors):
            words = shared_words = self.errors[at].message
        if about is not None and about not in things:
            things.append(about)
        if at == len(self.errors):
            more = {
                "settled_by": (settled_by,) if settled_by else (),
                "edits": edits,
                "advice": advice,
                "called": place,
            }
            self.errors.append(make_finding(code, message, line=line, column=column, **more))
            return
        item = self.errors[at]
        if len(things) > 1:
            words = shared_words.replace(ONE_TOOL, "")
        all_settled_by = (
            item.settled_by if settled_by in item.settled_by or not settled_by else (*item.settled_by, settled_by)
        )
        self.errors[at] = replace(
            add_line(item, line),
            message=words.replace("\0", _join_names(things)),
            settled_by=all_settled_by,
        )

    def _move_to_cause(self, cause: str, line: int) -> None:
        """The finding of several errors stands in the line of their cause: that is what to look at first."""
        at, *_others = self._causes["", cause]
        item = self.errors[at]
        first = item.line or line
        if item.count > 1 and first > line:
            message = item.message.replace(f"{cause} is active", f"first in line {first}")
            self.errors[at] = replace(item, line=line, worst_line=line, column=None, message=message)


def _join_names(things: list[str]) -> str:
    """Tool 1, tool 2 and tool 3."""
    shown_names = (
        things if len(things) <= _MOST_NAMES else [*things[: _MOST_NAMES - 1], f"{len(things) - _MOST_NAMES + 1} more"]
    )
    return join_names(shown_names)


class LineTrace(Struct):
    """Lines that the program itself executes, in order, without those of calls.

    A span is (first line, line after the last, whether a restart may begin there). It may not while cutter compensation
    or a canned cycle is active, or while control points of a spline are read: such blocks depend on earlier ones. Nor
    where a statement of several lines goes on.
    """

    spans: list[tuple[int, int, bool]] = field(default_factory=list)
    counted_line: int = 0  #: The line of the program, also in a call, whose executions are counted.
    n_counted: int = 0
    is_met: bool = False  #: The execution has ended where a stop condition was met, also in a call.
    met_from: int = 0  #: The number of the first move of what was executed last before that.
    met_call: int = 0  #: The line of the program that calls it; 0 where it stands in the program itself.

    def add(self, first: int, last: int, *, may_restart: bool) -> None:
        """Add lines ``first`` to ``last`` (excluded), which have been executed."""
        if self.spans and self.spans[-1][1:] == (first, may_restart):
            first = self.spans.pop()[0]
        self.spans.append((first, last, may_restart))


class StopConditions(Struct, frozen=True):
    """Where an execution ends before the program does, and whether it traces its lines."""

    all_known: bool = False  #: As soon as the position of every axis is known.
    first_error: bool = False  #: At the first error, which is raised; without it all errors are collected.
    after_line: int | None = None  #: After the first execution of a line.
    file: str | None = None  #: The called file that has that line, or the counted one; None for the program itself.
    before_line: int | None = None  #: When the program itself, outside of calls, comes to a line.
    trace: LineTrace | None = None  #: Gets the executed lines.
    #: Not at an error after which the next line is not known: each line after it is executed once, in its order.
    past_errors: bool = False

    def is_about(self, text: ChunkedText) -> bool:
        """Whether its lines are those of a text."""
        return text.name == self.file

    def cut(self, line: int, last: int, *, is_about: bool) -> int:
        """The line before which a stretch from ``line`` to ``last`` (excluded) must end.

        A line of a called file is executed alone: its moves have the line of the call.
        """
        if is_about and self.after_line is not None and line <= self.after_line:
            last = min(last, self.after_line + (self.file is None or line == self.after_line))
        if is_about and self.before_line is not None and line < self.before_line:
            last = min(last, self.before_line)
        return last

    def is_met(self, state: State, setup: Setup, line: int, last: int, *, is_about: bool) -> bool:
        """Whether lines that have been executed, up to ``last`` (excluded), have the one after which it ends."""
        is_passed = self.after_line is not None and is_about and line <= self.after_line < last
        return is_passed or (self.all_known and knows_all(state, setup))


class Run(Protocol):
    """A program of one language in execution; :func:`run_program` asks it for lines, or stretches of lines, in turn."""

    @property
    def calls(self) -> CallStack[Any, Any]:
        """Where it goes on."""

    @property
    def has_ended(self) -> bool:
        """True after its end."""

    def may_restart(self) -> bool:
        """True where nothing of earlier lines is still to come."""

    def find_chunk(self) -> Chunk | None:
        """The chunk of the next line; None where the text ends."""

    def execute(self, chunk: Chunk, stop: StopConditions) -> tuple[int, list[ProgramError]]:
        """Execute the next line, or a stretch; returns the line after it, as the text is written, and the errors."""

    def end_text(self, execution: Execution) -> bool:
        """The text ends; True where the program goes on elsewhere."""

    def leave_call(self) -> None:
        """Go back to where the last subprogram was called, as far as it was executed."""


def run_program(run: Run, execution: Execution, setup: Setup, stop: StopConditions) -> Execution:
    """Execute a program from its next line on, until it ends or a stop condition is met; its errors are collected."""
    calls, state = run.calls, execution.state
    is_watched = stop.all_known or stop.after_line is not None
    loop = Loop()
    reached_line, is_lost = 0, False  # the last line of the program itself so far; the next one is not known
    while not run.has_ended:
        text, line, shown_line = calls.text, calls.line, calls.shown_line  # a return may leave them
        main_line = line if stop.past_errors and calls.in_main else 0
        errors: list[ProgramError] = []
        last, moves, chunk = line + 1, execution.recorder.count, None
        execution.recorder.lines.enter(text.name or "", line, shown_line)
        try:
            chunk = run.find_chunk()
            if chunk is None:
                if run.end_text(execution):
                    continue
                break
            in_main = calls.in_main
            if in_main and line == stop.before_line:
                break
            execution.recorder.note_calls(calls.chain)
            restart = stop.trace is not None and may_restart(state) and run.may_restart()
            contour = 0 if state.compensation is None else state.compensation.start_line
            frame = calls.frame
            last, errors = run.execute(chunk, stop)
            if calls.text is not text or calls.frame is not frame:
                loop.calls_now = True
            elif calls.line <= line:
                loop.note(calls, line)
            errors = execution.drop_wrong_corners(errors, contour)
            errors = execution.drop_consequences(errors, chunk, range(line, min(last, chunk.end_line)), moves)
            if stop.trace is not None and stop.is_about(text) and line <= stop.trace.counted_line < last:
                stop.trace.n_counted += 1
            if in_main and stop.trace is not None:
                span_end = last if chunk.lines.plain[line - chunk.first_line] else line + 1  # a stretch, or a statement
                stop.trace.add(line, span_end, may_restart=restart)
                if span_end < last:
                    stop.trace.add(span_end, last, may_restart=False)
        except ProgramError as error:
            execution.recorder.give_up(shown_line or line)
            errors = [error]
        if errors:
            language = execution.recorder.language
            if _is_order_in_doubt(errors, chunk, line, language):
                execution.recorder.lines.note_doubt()
            errors = [one for error in errors if (one := loop.name(error, text, line, language)) is not None]
        if errors and (
            not execution.report_all(errors, line, shown_line=shown_line, file=text.name) or stop.first_error
        ):
            if not stop.past_errors:
                break
            is_lost = True
            while calls.in_call:
                run.leave_call()
        if stop.past_errors and calls.in_main:
            reached_line = max(reached_line, main_line)
            calls.line = max(calls.line, reached_line + 1) if is_lost else calls.line
            reached_line = max(reached_line, calls.line - 1)
        if is_watched and stop.is_met(state, setup, line, last, is_about=stop.is_about(text)):
            if stop.trace is not None:
                stop.trace.is_met, stop.trace.met_from, stop.trace.met_call = True, moves, shown_line or 0
            break
    execution.recorder.lines.place = None
    return execution


def _is_order_in_doubt(errors: list[ProgramError], chunk: Chunk | None, line: int, language: str) -> bool:
    """Whether the lines that come next may be others when the errors of a line are corrected."""
    if chunk is None:
        return True
    at = next((one.line for one in errors if one.line and chunk.first_line <= one.line < chunk.end_line), line)
    if _OF_ORDER.search(remove_remarks(decode_line(chunk.read_raw(at - chunk.first_line)), language)):
        return True
    corrections = (find_correction(error.message) for error in errors if error.code in _OF_READING)
    return any(one is not None and _OF_ORDER.search(one[1]) for one in corrections)


def may_restart(state: State) -> bool:
    """True where the core lets a program begin: the next move does not depend on how the one before has moved."""
    return state.compensation is None and state.centre is None


def knows_all(state: State, setup: Setup) -> bool:
    """True when the position of every axis of the machine is known."""
    return all(state.known_axes[AXES.index(letter)] for letter in setup.axes)
