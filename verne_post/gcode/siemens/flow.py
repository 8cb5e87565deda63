"""The order of lines in a Siemens program: jumps, branches, loops, repeated stretches, subprograms, and bounds."""

import math
import re
from collections.abc import Callable
from typing import Final

from msgspec.structs import replace

from verne_post.base.printable import join_names
from verne_post.base.suggestions import find_correction, find_meant
from verne_post.gcode.calls import CallStack
from verne_post.gcode.program_error import CHECK_CALLER, GIVE_FILE, IS_SUBPROGRAM, ProgramError, write_words
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.repeats import Repeats
from verne_post.gcode.siemens.calls import (
    Frame,
    Library,
    MissingValues,
    bind_arguments,
    copy_scope,
    find_missing_values,
    freeze,
    read_procedure,
)
from verne_post.gcode.siemens.contour_milling import PARAMETERS as CONTOURS
from verne_post.gcode.siemens.contour_milling import ContourMilling, build_contour_error, check_first_block
from verne_post.gcode.siemens.cursor import NAME, Cursor
from verne_post.gcode.siemens.drilling import PARAMETERS as DRILLING
from verne_post.gcode.siemens.executor import Executor
from verne_post.gcode.siemens.headers import find_meant_header
from verne_post.gcode.siemens.jumps import JUMPS, end_stretch, read_repeats
from verne_post.gcode.siemens.milling import MODAL_MILLING
from verne_post.gcode.siemens.program import Section, SiemensText, refuse_header, split_line
from verne_post.gcode.siemens.slips import explain_moved_blank
from verne_post.gcode.siemens.values import read_value, spell_value
from verne_post.gcode.siemens.variables import refuse_leftover
from verne_post.gcode.siemens.vocabulary import TYPES
from verne_post.gcode.siemens.words import Call, Words, read_argument_values, read_arguments
from verne_post.model.findings import Remedy

#: MCALL without its M.
_WITHOUT_PATH: Final = re.compile(r"[ \t/]*(?:N\d+[ \t]*)?CALL(?:[ \t]+(?:CYCLE|HOLES).*|[ \t]*)", re.IGNORECASE)
#: Alarms of SETAL that stop a program; others are only shown.
_STOPPING_ALARMS: Final = (range(60_000, 62_000), range(65_500, 68_000))
#: A letter whose key is beside that of N before a number at the beginning of a line, and a block number.
_NEAR_N: Final = re.compile(r"[ \t]*([BHJM])(\d{2,9})(?=[ \t])", re.IGNORECASE)
_I_IN_NUMBER: Final = re.compile(r"[ \t]*(N)(\d{0,8}I\d{1,8})(?=[ \t]+[A-Z_])", re.IGNORECASE)
_BLOCK_NUMBER: Final = re.compile(rb"[ \t]*N[ \t]*(\d{1,9})", re.IGNORECASE)
#: What begins a program; a name may begin with _, as in %_NEW_MPF.
_NAME_OF_PROGRAM: Final = re.compile(r"%[A-Z_]\w*_[MS]PF", re.IGNORECASE | re.ASCII)
#: A line of a program's name in which % is mistyped.
_LIKE_HEADER: Final = re.compile(r"[^\w;]_N_\w+$|\d_N_\w+$")
_SECOND_LINE: Final = 2
#: F with an expression.
_FEED: Final = re.compile(r"(?<!\w)F[ \t]*=[ \t]*([^ \t]+)", re.IGNORECASE)


class Flow:
    """The order in which the lines of a program are executed.

    Attributes
    ----------
    calls : CallStack
        The line that comes next, and where calls return to.
    ended : bool
        True after the end of the program.
    is_contour : bool
        The lines are those of a contour, which calls no cycles.
    """

    def __init__(self, main: SiemensText, executor: Executor, *, is_contour: bool = False) -> None:
        self.executor, self.is_contour = executor, is_contour
        self.library = Library(executor.setup, main)
        executor.words.is_subprogram = self.is_subprogram
        executor.words.list_subprograms = self.library.list_names
        executor.words.is_label = lambda name: name in self.calls.text.labels
        self.calls = CallStack(main, main.main.first, Frame(main.main))
        self.has_ended = False
        self.repeats = Repeats(executor.setup.max_repeats)
        self.contours = ContourMilling(executor, self.library, self.calls, self._run_contour)

    def is_subprogram(self, name: str) -> bool:
        """True where a name is that of a subprogram that can be called."""
        return self.library.find(name, self.calls.text) is not None

    # --- one line -------------------------------------------------------------------------------------------

    def step(self, raw: bytes) -> None:
        """Execute the next line."""
        text, line, moves = self.calls.text, self.calls.line, self.executor.move_count
        self.calls.line += 1
        item = split_line(raw)
        if not (item.is_skipped and self.executor.setup.block_delete):
            unset = len(self.executor.variables.unset_r)
            try:
                self._execute(Cursor(item.text, item.begin), line)
            except ProgramError as error:
                self._refuse_misspelt_number(item.text, text, line)
                name = error.settled_by[1] if error.settled_by[:1] == ("remap",) else ""
                if name and text.is_target(name) and (bare := text.find_bare_label(name)) is not None:
                    raise bare from None
                if not name and error.code == "VP002" and (correction := find_correction(error.message)) is not None:
                    name = correction[0].upper()
                if NAME.fullmatch(name) and (header := text.find_misspelt_header(name)) is not None:
                    raise header from None
                missing = self.calls.frame.missing if text is self.calls.text else None
                if missing is not None and self._is_of_missing(error, missing, raw, line):
                    missing.explain(error, f"{text.name}, line {line}" if text.name else f"line {line}")
                raise
            finally:
                for number in self.executor.variables.unset_r[unset:]:
                    self.executor.warn_of_unset(number, self.calls.show(line))
        if not self.has_ended and self.calls.text is text:
            end_stretch(self, line)
        self.repeats.count(text, line, line, self.executor.move_count - moves)

    @staticmethod
    def _refuse_misspelt_number(line_text: str, text: SiemensText, line: int) -> None:
        """Refuse (VP001) M120 that stands for N120, as the numbers above and below show, in a line with an error."""
        match = _NEAR_N.match(line_text) or _I_IN_NUMBER.match(line_text)
        if match is None or line < _SECOND_LINE:
            return
        beside = [_BLOCK_NUMBER.match(text.read_line(number)) for number in (line - 1, line + 1)]
        above, below = (None if one is None else int(one[1]) for one in beside)
        for number in dict.fromkeys(match[2].upper().replace("I", digit) for digit in "18"):
            if above is not None and above < int(number) < (below or math.inf):  # none below the last one
                what = "the letter I in a number" if number != match[2] else "a block number begins with N"
                message = f"{match[1]}{match[2]}: {what}; did you mean N{number}?"
                raise ProgramError("VP001", message, match.start(1) + 1) from None

    def _is_of_missing(self, error: ProgramError, missing: MissingValues, raw: bytes, line: int) -> bool:
        """Whether a missing value of the call leads to an error: with other values the line has none, or another one.

        Where cutter compensation is on, that is not known: no state beside the program's begins inside it.
        """
        executor = self.executor
        code = self._find_feed_word(line) if error.code == "VP009" else split_line(raw).text
        names = missing.find_used(error, code, executor.variables.scopes[-1])
        if not names or error.code == "VP009":  # its line has moved the axes
            return bool(names)
        if executor.interpreter.state.compensation is not None:
            return False
        fork = executor.fork(executor.interpreter.state.feed, knows_place=True)
        fork.modal, fork.variables.r = executor.modal, dict(executor.variables.r)
        scopes = [copy_scope(scope) for scope in executor.variables.scopes]
        for number, name in enumerate(names, 1):
            is_text = scopes[-1][name].kind == "STRING"
            scopes[-1][name].values[()] = str(number) if is_text else float(number)
        fork.variables.scopes = scopes
        flow = Flow(self.calls.main, fork)
        flow.calls = CallStack(self.calls.text, line, Frame(self.calls.frame.section))
        try:
            flow.step(raw)
        except ProgramError as other:
            return other.message != error.message
        return True

    def _find_feed_word(self, line: int) -> str:
        """The last F= of the subprogram up to a line, which a feed rate of zero comes from; empty without one."""
        for number in range(line, self.calls.frame.section.first - 1, -1):
            found = _FEED.findall(split_line(self.calls.text.read_line(number)).text)
            if found:
                return str(found[-1])
        return ""

    def _may_be_header(self, text: str, line: int) -> bool:
        """Whether a line without % may be meant to begin a program: a call of a subprogram is none."""
        word = text.strip().upper()
        if not NAME.fullmatch(word):
            return line == self.calls.frame.section.first or _LIKE_HEADER.match(word) is not None
        name = word.removeprefix("_N_").removesuffix("_SPF").removesuffix("_MPF")
        names = (*self.library.list_names(), *self.executor.setup.remap)
        return line == self.calls.frame.section.first and not {word, name} & {*names}

    def _execute(self, cursor: Cursor, line: int) -> None:
        symbol = cursor.skip()
        if symbol == "":
            return
        if symbol == "%" or self._may_be_header(cursor.text, line):
            right = find_meant_header(cursor.text, is_first=self.calls.in_main and not self.calls.in_call)
            if right and not _NAME_OF_PROGRAM.fullmatch(cursor.text.strip()):
                raise refuse_header(cursor.text, right)
        if symbol == "%":
            if line not in (self.calls.frame.section.first, self.calls.frame.section.last):
                raise cursor.error("VP001", "'%' begins a program; a file with several has lines such as %_N_NAME_SPF")
            return
        at, name = cursor.at, cursor.name()
        handler = HANDLERS.get(name or "")
        if handler is not None and cursor.skip() != "=":
            handler(self, cursor, line)
            return
        cursor.at = at
        words = self.executor.read(cursor, self.calls.show(line))
        _refuse_second_call(words)
        if any(number == 17 for number, _column in words.m) and self.calls.in_call:
            self.executor.run(words)
            self._return(cursor, line)
            return
        due = self.executor.run(words)
        if self.executor.has_ended or any(number == 17 for number, _column in words.m):
            self._end_program(line)
            return
        for call in words.calls:
            self._call(call, words, line)
        if due and self.executor.modal is not None:
            modal, self.executor.modal = self.executor.modal, None  # its own moves do not call it
            self.enter(modal, line)
            self.calls.frame.modal = modal

    # --- ends -----------------------------------------------------------------------------------------------

    def end_section(self) -> bool:
        """At the end of the lines of a program: return from it. False at the end of the program itself."""
        if not self.calls.in_call:
            return False
        self._leave()
        return True

    def _end_program(self, line: int) -> None:
        self.executor.finish()
        self.has_ended = True
        if not self.executor.has_ended:
            self.executor.record_event(self.calls.show(line), "end", code="M17")

    def _return(self, cursor: Cursor, line: int) -> None:
        """RET, M17."""
        if cursor.take("("):
            raise cursor.error("VP002", "RET with values (return to another block) is not executed", cursor.at - 1)
        refuse_leftover(cursor)
        if not self.calls.in_call:
            self._end_program(line)
            return
        self._leave()

    def _leave(self) -> None:
        frame = self.calls.frame
        executor = self.executor
        variables = executor.variables
        results = [(outside, variables.read(outside.inside, (), Cursor("", 0), 0)) for outside in frame.results]
        if frame.remaining > 1:  # as if it were called anew
            frame.remaining -= 1
            frame.repeats.clear()
            frame.ends.clear()
            kept_variables = {outside.inside: variables.scopes[-1][outside.inside] for outside in frame.results}
            variables.scopes[-1] = {**copy_scope(frame.scope), **kept_variables}
            if frame.saved_modes is not None:
                executor.restore(frame.saved_modes.copy())
            self.calls.line = read_procedure(frame.section).line + 1
            return
        self.calls.leave()
        variables.scopes.pop()
        called_by = self.calls.line - 1
        for outside, value in results:
            variables.write(outside.name, outside.index, value, Cursor("", 0), 0)
        if frame.saved_modes is not None:
            executor.restore(frame.saved_modes)
        if frame.modal is not None:
            executor.modal = frame.modal
        executor.record_event(self.calls.show(max(called_by, 1)), "return", label=frame.section.name)
        end_stretch(self, called_by)

    # --- calls ----------------------------------------------------------------------------------------------

    def _call(self, call: Call, words: Words, line: int) -> None:
        repeats = 1
        if (given := words.words.get("P")) is not None:
            repeats = read_repeats(given.value, call.column)
        if self.is_contour and self.executor.is_cycle(call.name):
            raise ProgramError("VP017", f"{call.name} in a contour, which has lines and arcs alone", call.column)
        if call.name in CONTOURS:
            self.executor.interpreter.motion.corners.finish()
            self.executor.interpreter.motion.note_numbers()
            self.contours.run(call, self.calls.show(line))
        elif self.executor.is_cycle(call.name):
            self.executor.run_cycle(call, self.calls.show(line))
        elif repeats:
            self.enter(call, line, repeats)

    def enter(self, call: Call, line: int, repeats: int = 1) -> None:
        """Call a subprogram."""
        section = self.library.find(call.name, self.calls.text)
        if section is None:
            raise ProgramError(
                "VP023",
                f"{call.name} is defined neither in the program nor in a file {call.name}.SPF",
                call.column,
            ).advise(GIVE_FILE)
        self.calls.check_depth(call.name, call.column)
        executor = self.executor
        try:
            procedure = read_procedure(section)
        except ProgramError as error:
            if section.text is self.calls.main:
                error.of_program = True
                raise
            where = f"PROC of {section.name or call.name}, line {error.line}"
            message = re.sub(r"did you mean ([^?]*)\?$", r"write \1 there", error.message)  # no edit of this file
            raise ProgramError(error.code, f"{where}: {message}", call.column).advise(error.advice) from None
        try:
            scope, results = bind_arguments(call, procedure, executor.variables)
        except ProgramError as error:
            if error.column is None and section.text is self.calls.main:
                error.line, error.of_program = section.first, True
            error.column = error.column or (None if error.line else call.column)
            raise
        executor.record_event(self.calls.show(line), "call", label=section.name)
        name, own_name = section.name or call.name, procedure.name
        if own_name and name.upper() not in (own_name.upper(), f"_N_{own_name}_SPF".upper()):
            text = (
                f"{name} is called, and its PROC line names {own_name}: is this the text of another subprogram? write "
                f"PROC {name} there, or call {own_name}"
            )
            executor.interpreter.recorder.note_once("VP023", text, self.calls.show(line), severity="warning")
        saved_modes = executor.modes.copy() if procedure.save else None
        kept_scope = copy_scope(scope) if repeats > 1 else {}
        frame = Frame(section, repeats, saved_modes, results=results, scope=kept_scope)
        if self.calls.text is self.calls.main:
            frame.missing = find_missing_values(call, procedure, line)
        self.calls.enter(section.text, procedure.line + 1, line, frame)
        executor.variables.scopes.append(scope)

    def _run_contour(self, section: Section, feed: float, call: Call) -> tuple[Recorder, Executor]:
        """Execute a contour once on a state of its own; its blocks count as repeated ones."""
        fork = self.executor.fork(feed)
        flow = Flow(self.calls.main, fork, is_contour=True)
        begin, has_begun = read_procedure(section).line + 1, False
        scopes = self.executor.variables.scopes
        fork.variables.scopes = [*scopes, {} if section.is_whole else dict(scopes[-1])]
        flow.calls = CallStack(section.text, begin, Frame(section))
        is_of_program = self.contours.is_of_program(section)
        while not flow.has_ended:
            line, calls = flow.calls.line, flow.calls
            if line > calls.frame.section.last:
                if not flow.end_section():
                    fork.finish()
                    break
                continue
            try:
                flow.step(calls.text.read_line(line))
                self.repeats.add(1)
                if not has_begun and fork.move_count:
                    has_begun = True
                    check_first_block(fork)
                if fork.interpreter.state.compensation is not None:
                    raise ProgramError(
                        "VP017", "a contour has no G41 and G42: RL of the cycle says on which side the tool goes"
                    )
            except ProgramError as error:
                raise build_contour_error(error, section, calls.show(line), call, is_of_program) from None
        return fork.interpreter.recorder, fork

    def _call_external(self, cursor: Cursor, line: int) -> None:
        """CALL, EXTCALL: the last part of the path names a file beside the program."""
        begin = cursor.at - len("CALL")
        cursor.skip()
        if _WITHOUT_PATH.fullmatch(cursor.text):
            text = "CALL needs the path of a subprogram; MCALL may be meant"
            raise cursor.error("VP001", text, begin, write_words("CALL", "MCALL", is_choice=True))
        at, bracket = cursor.at, cursor.take("(")
        path = read_value(cursor, self.executor.variables)
        if bracket:
            cursor.expect(")", "after the path of the subprogram")
        refuse_leftover(cursor)
        name = str(path).replace("\\", "/").rpartition("/")[2].partition(".")[0].upper()
        name = name.removeprefix("_N_")
        self.enter(Call(name.removesuffix("_SPF").removesuffix("_MPF"), None, at + 1), line)

    def _set_modal_call(self, cursor: Cursor, line: int) -> None:
        """MCALL with a call, or alone."""
        column = cursor.at
        if cursor.is_at_end:
            self.executor.end_modal(self.calls.show(line))
            return
        try:
            words = self.executor.read(cursor, self.calls.show(line))
        except ProgramError as error:
            correction = find_correction(error.message)
            right_name = "" if correction is None else correction[1]
            if correction is not None and self.executor.is_cycle(right_name) and not self.executor.is_modal(right_name):
                near = find_meant(correction[0], DRILLING)
                error.message = f"{correction[0]}: no cycle that MCALL calls; write the cycle that is meant"
                error.message += f", such as {near}" if near else ""
            raise
        if len(words.calls) != 1 or words.words or words.groups or words.m:
            raise cursor.error("VP001", "MCALL takes one call: MCALL CYCLE81(...)", column)
        own_line = self.executor.interpreter.recorder.lines.number(line)
        call = freeze(words.calls[0], self.executor.variables, own_line)
        if self.executor.is_cycle(call.name) and not self.executor.is_modal(call.name):
            raise ProgramError(
                "VP002",
                f"MCALL {call.name} is not executed: modal are drilling cycles, {', '.join(MODAL_MILLING)} and "
                f"subprograms; call {call.name} at each place",
                call.column,
            )
        self.executor.modal = call
        self.executor.lone_calls.clear()
        self.executor.modal_is_shown = self.calls.shown_line is None

    # --- definitions, messages ----------------------------------------------------------------------------------

    def _define(self, cursor: Cursor, line: int) -> None:
        cursor.skip()
        is_used = self.calls.text.has_name
        if message := explain_moved_blank(cursor.text, cursor.at, TYPES, lambda _type, name: is_used(name)):
            raise cursor.error("VP001", message)
        self.executor.variables.define(cursor)
        refuse_leftover(cursor)

    def _check_procedure(self, cursor: Cursor, line: int) -> None:
        """A PROC line of the program itself, which nothing calls; refuse (VP005) values that come from a call."""
        procedure = read_procedure(self.calls.frame.section)
        if self.calls.in_call or procedure.line != line:
            raise ProgramError("VP001", "PROC is the first block of a program", 1)
        call = Call("PROC", None, 1)
        scope, _results = bind_arguments(call, procedure, self.executor.variables)
        self.executor.variables.scopes[-1].update(scope)
        missing = find_missing_values(call, procedure, line)
        if missing is not None:
            names = join_names(missing.names)
            text = f"{IS_SUBPROGRAM}, and a call gives it {names}; {CHECK_CALLER}"
            missing = replace(missing, message=text, remedy="")
            self.calls.frame.missing = missing  # which errors of later lines follow from
            error = ProgramError("VP005", text, missing.column, missing.line, of_program=True)
            error.cause = missing.cause
            raise error.advise(missing.remedy)

    def _show_message(self, cursor: Cursor, line: int) -> None:
        arguments = read_arguments(cursor) if cursor.skip() == "(" else None
        if arguments is None:
            raise cursor.error("VP001", "expected '(' after MSG")
        refuse_leftover(cursor)
        bare = arguments[0].text.strip() if len(arguments) == 1 else ""
        if NAME.fullmatch(bare) and not self.executor.variables.is_known(bare.upper()):
            right = f'MSG("{bare}")'
            edits = (Remedy(f"write {right}", f'"{bare}"', misspelt=bare),)
            text = f"{bare}: the text of a message is written in quotation marks; did you mean {right}?"
            column = arguments[0].column + arguments[0].text.index(bare)
            raise ProgramError("VP001", text, column, edits=edits)
        texts = (one for one in read_argument_values(arguments, self.executor.variables) if one is not None)
        for value in list(texts)[:1]:
            self.executor.record_event(self.calls.show(line), "message", text=spell_value(value))

    def _raise_alarm(self, cursor: Cursor, line: int) -> None:
        arguments = read_arguments(cursor) if cursor.skip() == "(" else ()
        refuse_leftover(cursor)
        values = [one for one in read_argument_values(arguments, self.executor.variables) if one is not None]
        if not values or isinstance(values[0], str):
            raise cursor.error("VP005", "SETAL takes the number of an alarm, and a text", 0)
        shown_values = " ".join(spell_value(value) for value in values)
        if any(round(values[0]) in numbers for numbers in _STOPPING_ALARMS):
            raise ProgramError("VP027", f"the program asks to stop: alarm {shown_values}")
        self.executor.record_event(self.calls.show(line), "message", text=f"alarm {shown_values}")


_Handler = Callable[[Flow, Cursor, int], None]
HANDLERS: Final[dict[str, _Handler]] = {
    **JUMPS,
    "DEF": Flow._define,
    "PROC": Flow._check_procedure,
    "RET": Flow._return,
    "MCALL": Flow._set_modal_call,
    "CALL": Flow._call_external,
    "EXTCALL": Flow._call_external,
    "MSG": Flow._show_message,
    "SETAL": Flow._raise_alarm,
}


def _refuse_second_call(words: Words) -> None:
    """A block has one call, and none beside the end of a program: what would come first is not written."""
    if len(words.calls) > 1:
        raise ProgramError(
            "VP003",
            f"{words.calls[0].name} and {words.calls[1].name} in one block: write one call a block",
            words.calls[1].column,
        )
    ends = [(number, column) for number, column in words.m if number in (2, 17, 30)]
    if words.calls and ends:
        raise ProgramError(
            "VP003",
            f"{words.calls[0].name} and M{ends[0][0]} in one block: write the end in a separate block",
            ends[0][1],
        )
