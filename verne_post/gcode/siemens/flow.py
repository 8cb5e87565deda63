"""Where a Siemens program goes on: jumps, branches, loops, repeated stretches, subprograms, and the bounds of all of them."""

from collections.abc import Callable
from typing import Final

from verne_post.gcode.expressions import BlockError
from verne_post.gcode.flow import MAX_DEPTH, MOVES_OF_BLOCK
from verne_post.gcode.siemens.calls import Frame, Library, Repeat, bind_arguments, freeze, read_procedure
from verne_post.gcode.siemens.cursor import Cursor
from verne_post.gcode.siemens.executor import Executor
from verne_post.gcode.siemens.program import SiemensText, split_line
from verne_post.gcode.siemens.values import Value, are_equal, read_indices, read_number, read_value, shown
from verne_post.gcode.siemens.variables import refuse_leftover
from verne_post.gcode.siemens.words import Call, Words, read_arguments
from verne_post.gcode.text import ProgramText

#: Alarms of SETAL that stop a program; others are only shown.
_STOPPING_ALARMS: Final = (range(60_000, 62_000), range(65_500, 68_000))
#: A subprogram or a stretch is repeated so often at most by one P.
_MOST_REPEATS: Final = 9999


class Flow:
    """The order in which the lines of a program are executed.

    Attributes
    ----------
    frames : list of Frame
        The program, and the calls inside each other; the last is executed.
    line : int
        The line that comes next, 1-based.
    shown_line : int or None
        Line of the program that stands for lines of another file.
    ended : bool
        True after the end of the program.
    """

    def __init__(self, main: SiemensText, executor: Executor) -> None:
        self.main, self.executor = main, executor
        self.library = Library(executor.setup, main)
        executor.words.is_subprogram = self.is_subprogram
        self.frames = [Frame(main.main, 0)]
        self.line = main.main.first
        self.shown_line: int | None = None
        self.ended = False
        self.repeated = 0
        self._reached: dict[ProgramText, int] = {}

    @property
    def frame(self) -> Frame:
        """The call that is executed."""
        return self.frames[-1]

    @property
    def text(self) -> SiemensText:
        """The file that is executed."""
        return self.frame.section.text

    @property
    def in_call(self) -> bool:
        """True inside a subprogram."""
        return len(self.frames) > 1

    def is_subprogram(self, name: str) -> bool:
        """True where a name is that of a subprogram that can be called."""
        return self.library.find(name, self.text) is not None

    # --- one line -------------------------------------------------------------------------------------------

    def step(self, raw: bytes) -> None:
        """Execute the next line.

        Raises
        ------
        BlockError
            With the column of what cannot be executed.
        """
        text, line, moves = self.text, self.line, self.executor.move_count
        self.line += 1
        item = split_line(raw)
        if not (item.skipped and self.executor.setup.block_delete):
            self._execute(Cursor(item.text, item.begin), line)
        if not self.ended and self.text is text:
            self._end_stretch(line)
        self.count(text, line, line, self.executor.move_count - moves)

    def _execute(self, cursor: Cursor, line: int) -> None:
        symbol = cursor.skip()
        if symbol == "":
            return
        if symbol == "%":
            if line not in (self.frame.section.first, self.frame.section.last):
                raise cursor.error("VP001", "'%' begins a program; a file with several has lines such as %_N_NAME_SPF")
            return
        at, name = cursor.at, cursor.name()
        handler = _HANDLERS.get(name or "")
        if handler is not None and cursor.skip() != "=":
            handler(self, cursor, line)
            return
        cursor.at = at
        words = self.executor.read(cursor, self.shown_line or line)
        if any(number == 17 for number, _column in words.m) and self.in_call:
            self.executor.run(words)
            self._return(cursor, line)
            return
        due = self.executor.run(words)
        if self.executor.ended or any(number == 17 for number, _column in words.m):
            self._end_program(line)
            return
        for call in words.calls:
            self._call(call, words, line)
        if due and self.executor.modal is not None:
            modal, self.executor.modal = self.executor.modal, None  # its own moves do not call it
            self.enter(modal, line)
            self.frame.modal = modal

    def count(self, text: ProgramText, first: int, last: int, moves: int) -> None:
        """Count the lines ``first`` to ``last`` of a text that have just been executed, if that was not for the first time."""
        seen = self._reached.get(text, 0)
        if moves > MOVES_OF_BLOCK:
            self.repeated += moves - MOVES_OF_BLOCK
        if last > seen:
            self._reached[text] = last
        if first <= seen:
            self.repeated += max(min(last, seen) - first + 1, moves)
        most = self.executor.setup.max_repeats
        if self.repeated > most:
            raise BlockError(
                "VP024",
                f"loops, jumps and calls have repeated {most} blocks and moves; if the program is meant to, raise --max-repeats",
            )

    # --- ends -----------------------------------------------------------------------------------------------

    def end_section(self) -> bool:
        """At the end of the lines of a program: return from it. False at the end of the program itself."""
        if not self.in_call:
            return False
        self._leave()
        return True

    def _end_program(self, line: int) -> None:
        self.ended = True
        if not self.executor.ended:
            self.executor.event(self.shown_line or line, "end", code="M17")

    def _return(self, cursor: Cursor, line: int) -> None:
        """RET, M17."""
        if cursor.take("("):
            raise cursor.error("VP002", "RET with values (return to another block) is not executed", cursor.at - 1)
        refuse_leftover(cursor)
        if not self.in_call:
            self._end_program(line)
            return
        self._leave()

    def _leave(self) -> None:
        frame = self.frame
        executor = self.executor
        if frame.remaining > 1:
            frame.remaining -= 1
            frame.repeats.clear()
            self.line = read_procedure(frame.section).line + 1
            return
        results = [
            (outside, executor.variables.read(inside, (), Cursor("", 0), 0)) for inside, outside in frame.results
        ]
        self.frames.pop()
        self.line = frame.line
        if not self.in_call or self.text is self.main:
            self.shown_line = None if self.text is self.main else self.shown_line
        executor.variables.scopes.pop()
        shown_line = self.shown_line or max(frame.line - 1, 1)
        for outside, value in results:
            cursor = Cursor(outside)
            name = cursor.name()
            if name is not None:
                executor.variables.write(name, read_indices(cursor, executor.variables), value, cursor, 0)
        if frame.saved is not None:
            executor.restore(frame.saved)
        if frame.modal is not None:
            executor.modal = frame.modal
        executor.event(shown_line, "return", label=frame.section.name)

    # --- calls ----------------------------------------------------------------------------------------------

    def _call(self, call: Call, words: Words, line: int) -> None:
        repeats = 1
        if (given := words.words.get("P")) is not None:
            repeats = self._whole(given.value, 0, "P", call.column)
        if self.executor.is_cycle(call.name):
            self.executor.run_cycle(call, self.shown_line or line)
        elif repeats:
            self.enter(call, line, repeats)

    def _whole(self, value: float, least: int, name: str, column: int) -> int:
        number = round(value)
        if abs(value - number) > 1e-9 or not least <= number <= _MOST_REPEATS:
            raise BlockError("VP007", f"{name}{value:g}: a whole number from {least} to {_MOST_REPEATS}", column)
        return number

    def enter(self, call: Call, line: int, repeats: int = 1) -> None:
        """Call a subprogram."""
        section = self.library.find(call.name, self.text)
        if section is None:
            raise BlockError("VP023", f"{call.name} is defined neither in the program nor in a file {call.name}.SPF in its folder or a "
                             "--subroutine-path", call.column)  # fmt: skip
        if len(self.frames) > MAX_DEPTH:
            raise BlockError(
                "VP024", f"more than {MAX_DEPTH} calls inside each other, the last of {call.name}", call.column
            )
        executor = self.executor
        procedure = read_procedure(section)
        scope, results = bind_arguments(call, procedure, executor.variables)
        executor.event(self.shown_line or line, "call", label=section.name)
        saved = executor.modes.copy() if procedure.save else None
        self.frames.append(Frame(section, self.line, repeats, saved, results=results))
        executor.variables.scopes.append(scope)
        if section.text is not self.main and self.shown_line is None:
            self.shown_line = line
        self.line = procedure.line + 1

    def _extcall(self, cursor: Cursor, line: int) -> None:
        """EXTCALL: the last part of the path names a file beside the program."""
        cursor.skip()
        at, bracket = cursor.at, cursor.take("(")
        path = read_value(cursor, self.executor.variables)
        if bracket:
            cursor.expect(")", "after the path of EXTCALL")
        refuse_leftover(cursor)
        name = str(path).replace("\\", "/").rpartition("/")[2].partition(".")[0].upper()
        for part in ("_N_",):
            name = name.removeprefix(part)
        self.enter(Call(name.removesuffix("_SPF").removesuffix("_MPF"), None, at + 1), line)

    def _modal(self, cursor: Cursor, line: int) -> None:
        """MCALL with a call, or alone."""
        column = cursor.at
        if cursor.ended:
            self.executor.modal = None
            return
        words = self.executor.read(cursor, self.shown_line or line)
        if len(words.calls) != 1 or words.words or words.groups or words.m:
            raise cursor.error("VP001", "MCALL takes one call: MCALL CYCLE81(...)", column)
        call = freeze(words.calls[0], self.executor.variables)
        if self.executor.is_cycle(call.name) and not self.executor.is_drilling(call.name):
            raise BlockError("VP002", f"MCALL {call.name}: patterns, CYCLE800 and CYCLE832 are not modal", call.column)
        self.executor.modal = call

    # --- jumps and branches -----------------------------------------------------------------------------------

    def _if(self, cursor: Cursor, line: int) -> None:
        holds = read_number(cursor, self.executor.variables) != 0
        word = cursor.peek_name()
        if word in ("GOTO", "GOTOF", "GOTOB", "GOTOC"):
            cursor.name()
            if holds:
                self._jump(cursor, line, word)
            return
        refuse_leftover(cursor)
        branch = self.text.structure.branch[line]
        if not holds:
            self.line = branch + 1

    def _else(self, cursor: Cursor, line: int) -> None:
        refuse_leftover(cursor)
        self.line = self.text.structure.branch[line] + 1

    def _endif(self, cursor: Cursor, line: int) -> None:
        _ = self.text.structure
        refuse_leftover(cursor)

    def _goto(self, cursor: Cursor, line: int) -> None:
        self._jump(cursor, line, "GOTO")

    def _goto_forward(self, cursor: Cursor, line: int) -> None:
        self._jump(cursor, line, "GOTOF")

    def _goto_backward(self, cursor: Cursor, line: int) -> None:
        self._jump(cursor, line, "GOTOB")

    def _goto_if_there(self, cursor: Cursor, line: int) -> None:
        self._jump(cursor, line, "GOTOC")

    def _jump(self, cursor: Cursor, line: int, word: str) -> None:
        cursor.skip()
        at = cursor.at
        target = self._read_target(cursor)
        refuse_leftover(cursor)
        found = self._find(target, line, forward=word != "GOTOB", backward=word != "GOTOF")
        if found is None:
            if word == "GOTOC":
                return
            where = {"GOTOF": " after this line", "GOTOB": " before this line"}.get(word, "")
            raise cursor.error("VP023", f"{word} {target}: there is no such label or block number{where}", at)
        self.line = found
        self.frame.repeats.clear()

    def _read_target(self, cursor: Cursor) -> str:
        name = cursor.peek_name()
        if name is not None and self.executor.variables.find(name) is None and name not in ("N",):
            cursor.name()
            return self._block_number(name)
        value: Value = read_value(cursor, self.executor.variables)
        return self._block_number(shown(value).upper())

    @staticmethod
    def _block_number(name: str) -> str:
        return f"N{int(name[1:])}" if name[0:1] == "N" and name[1:].isdigit() else name

    def _find(self, label: str, line: int, *, forward: bool, backward: bool) -> int | None:
        """The line of a label in the running program: after this line first, then before it."""
        section = self.frame.section
        lines = [place for place in self.text.labels.get(label, ()) if section.first <= place <= section.last]
        after = next((place for place in lines if place > line), None)
        before = next((place for place in reversed(lines) if place <= line), None)
        return after if forward and after is not None else before if backward else None

    # --- loops ----------------------------------------------------------------------------------------------

    def _for(self, cursor: Cursor, line: int) -> None:
        variables = self.executor.variables
        cursor.skip()
        at, name = cursor.at, cursor.name()
        if name is None:
            raise cursor.error("VP001", "expected a variable after FOR", at)
        variables.assign(name, cursor, at)
        if cursor.name() != "TO":
            raise cursor.error("VP001", "expected TO and the last value of FOR")
        last = read_number(cursor, variables)
        refuse_leftover(cursor)
        end = self.text.structure.end[line]
        self.frame.ends[line] = last
        if self._loop_value(line, cursor) > last:
            self.line = end + 1

    def _loop_value(self, line: int, cursor: Cursor) -> float:
        """The value of the variable of a FOR."""
        name, at, inner = self._loop_variable(line)
        value = self.executor.variables.read(name, read_indices(inner, self.executor.variables), inner, at)
        if isinstance(value, str):
            raise cursor.error("VP007", f"FOR {name}: a number is needed")
        return value

    def _loop_variable(self, line: int) -> tuple[str, int, Cursor]:
        item = split_line(self.text.line(line))
        cursor = Cursor(item.text, item.begin)
        cursor.name()
        cursor.skip()
        at, name = cursor.at, cursor.name()
        assert name is not None
        return name, at, cursor

    def _endfor(self, cursor: Cursor, line: int) -> None:
        refuse_leftover(cursor)
        begin = self.text.structure.begin[line]
        last = self.frame.ends.get(begin)
        if last is None:
            raise cursor.error("VP023", f"ENDFOR is reached, and its FOR (line {begin}) was not", 0)
        value = self._loop_value(begin, cursor) + 1.0
        name, at, inner = self._loop_variable(begin)
        self.executor.variables.write(name, read_indices(inner, self.executor.variables), value, inner, at)
        if value < last or are_equal(value, last):
            self.line = begin + 1

    def _while(self, cursor: Cursor, line: int) -> None:
        holds = read_number(cursor, self.executor.variables) != 0
        refuse_leftover(cursor)
        end = self.text.structure.end[line]
        if not holds:
            self.line = end + 1

    def _loop(self, cursor: Cursor, line: int) -> None:
        refuse_leftover(cursor)
        _ = self.text.structure

    def _back(self, cursor: Cursor, line: int) -> None:
        """ENDWHILE, ENDLOOP."""
        refuse_leftover(cursor)
        begin = self.text.structure.begin[line]
        self.line = begin

    def _until(self, cursor: Cursor, line: int) -> None:
        holds = read_number(cursor, self.executor.variables) != 0
        refuse_leftover(cursor)
        begin = self.text.structure.begin[line]
        if not holds:
            self.line = begin + 1

    def _repeat(self, cursor: Cursor, line: int) -> None:
        """REPEAT of REPEAT ... UNTIL, or REPEAT label [label] P=n."""
        if cursor.ended:
            _ = self.text.structure.end[line]
            return
        self._repeat_stretch(cursor, line, one_block=False)

    def _repeat_block(self, cursor: Cursor, line: int) -> None:
        self._repeat_stretch(cursor, line, one_block=True)

    def _repeat_stretch(self, cursor: Cursor, line: int, *, one_block: bool) -> None:
        labels: list[tuple[str, int]] = []
        times = 1
        while not cursor.ended:
            at, name = cursor.at, cursor.name()
            if name == "P" and cursor.take("="):
                times = self._whole(read_number(cursor, self.executor.variables), 0, "P", at + 1)
            elif name is not None and name[0] == "P" and name[1:].isdigit():
                times = self._whole(float(name[1:]), 0, "P", at + 1)
            elif name is None or len(labels) == (1 if one_block else 2):
                raise cursor.error("VP001", "expected a label, and P= for how often", at)
            else:
                labels.append((self._block_number(name), at))
        if not labels:
            raise cursor.error("VP001", "expected a label after REPEAT", 0)
        places = []
        for label, at in labels:
            place = self._find(label, line, forward=True, backward=True)
            if place is None:
                raise cursor.error("VP023", f"REPEAT {label}: there is no such label", at)
            places.append(place)
        first = places[0]
        if one_block:
            last = first
        elif len(places) == 2:
            last = places[1]
        else:
            ends = [
                place for place in self.text.labels.get("ENDLABEL", ()) if first <= place <= self.frame.section.last
            ]
            last = next((place for place in ends if place < line or first > line), line - 1)
        if last < first or first <= line <= last:
            raise cursor.error(
                "VP023",
                f"REPEAT {labels[0][0]}: the lines {first} to {last} cannot be repeated from line {line}",
                labels[0][1],
            )
        if times:
            self.frame.repeats.append(Repeat(first, last, times, line + 1))
            self.line = first

    def _end_stretch(self, line: int) -> None:
        """After the last line of a repeated stretch: once more, or on."""
        repeats = self.frame.repeats
        while repeats and repeats[-1].last == line and self.line == line + 1:
            repeat = repeats[-1]
            repeat.remaining -= 1
            if repeat.remaining > 0:
                self.line = repeat.first
                return
            repeats.pop()
            self.line = repeat.back
            line = repeat.back - 1

    # --- definitions, messages ----------------------------------------------------------------------------------

    def _define(self, cursor: Cursor, line: int) -> None:
        self.executor.variables.define(cursor)
        refuse_leftover(cursor)

    def _proc(self, cursor: Cursor, line: int) -> None:
        """A PROC line of the program itself: nothing calls it, so its values are what they are without a call."""
        procedure = read_procedure(self.frame.section)
        if self.in_call or procedure.line != line:
            raise BlockError("VP001", "PROC is the first block of a program", 1)
        scope, _results = bind_arguments(Call("PROC", None, 1), procedure, self.executor.variables)
        self.executor.variables.scopes[-1].update(scope)

    def _message(self, cursor: Cursor, line: int) -> None:
        arguments = read_arguments(cursor) if cursor.skip() == "(" else None
        if arguments is None:
            raise cursor.error("VP001", "expected '(' after MSG")
        refuse_leftover(cursor)
        texts = [argument for argument in arguments if argument.text.strip()]
        for argument in texts[:1]:
            self.executor.event(
                self.shown_line or line, "message", text=shown(read_value(argument.cursor(), self.executor.variables))
            )

    def _alarm(self, cursor: Cursor, line: int) -> None:
        arguments = read_arguments(cursor) if cursor.skip() == "(" else ()
        refuse_leftover(cursor)
        values = [
            read_value(argument.cursor(), self.executor.variables) for argument in arguments if argument.text.strip()
        ]
        if not values or isinstance(values[0], str):
            raise cursor.error("VP005", "SETAL takes the number of an alarm, and a text", 0)
        said = " ".join(shown(value) for value in values)
        if any(round(values[0]) in numbers for numbers in _STOPPING_ALARMS):
            raise BlockError("VP027", f"the program asks to stop: alarm {said}")
        self.executor.event(self.shown_line or line, "message", text=f"alarm {said}")


_Handler = Callable[[Flow, Cursor, int], None]
_HANDLERS: Final[dict[str, _Handler]] = {
    "IF": Flow._if, "ELSE": Flow._else, "ENDIF": Flow._endif, "GOTO": Flow._goto, "GOTOF": Flow._goto_forward, "GOTOB": Flow._goto_backward, "GOTOC": Flow._goto_if_there,
    "FOR": Flow._for, "ENDFOR": Flow._endfor, "WHILE": Flow._while, "ENDWHILE": Flow._back, "LOOP": Flow._loop, "ENDLOOP": Flow._back,
    "REPEAT": Flow._repeat, "REPEATB": Flow._repeat_block, "UNTIL": Flow._until, "DEF": Flow._define, "PROC": Flow._proc, "RET": Flow._return,
    "MCALL": Flow._modal, "EXTCALL": Flow._extcall, "MSG": Flow._message, "SETAL": Flow._alarm,
}  # fmt: skip
