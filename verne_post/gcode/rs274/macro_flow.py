"""Where a Fanuc program goes on: IF, GOTO, WHILE, DO and END, and the local variables of macros that it calls."""

from typing import Protocol

from msgspec import Struct, field

from verne_post.base.suggestions import list_near_numbers, name_numbers
from verne_post.gcode.calls import CallStack
from verne_post.gcode.parameters import LOCAL_INDICES
from verne_post.gcode.program_error import CLOSE_IN_ORDER, GIVE_LABEL, ProgramError, locate_errors
from verne_post.gcode.rs274.interpreter import Call, Rs274
from verne_post.gcode.rs274.macro_text import Loops, Statement, find_block_numbers, find_loops, find_numbered_lines
from verne_post.gcode.rs274.macro_variables import LOCAL
from verne_post.gcode.text import ProgramText
from verne_post.model.findings import Remedy


class Frame(Struct):
    """What one call brings back.

    ``label`` is None for the program itself; ``remaining`` counts calls of M98 L; ``counters`` the rounds of repeat.
    """

    label: str | None = None
    program: bool = False
    begin: int = 0
    remaining: int = 0
    arguments: dict[int, float] = field(default_factory=dict)
    #: Of a call of an O word: how many values it gives, and its line, as called files count theirs.
    n_values: int = len(LOCAL_INDICES)
    line: int = 0
    counters: dict[int, int] = field(default_factory=dict)
    #: Of a macro of Fanuc: the local variables of the program that has called it, and its own call.
    outer: dict[int, float] | None = None
    call: Call | None = None


class Running(Protocol):
    """The order of execution of one program, as a statement can change it."""

    interpreter: Rs274
    calls: CallStack[ProgramText, Frame]


class MacroFlow:
    """Statements and calls of custom macros, in the order of execution of one program."""

    def __init__(self, flow: Running) -> None:
        self.flow = flow
        self._loops: dict[int, Loops] = {}
        self._numbers: dict[tuple[int, int], list[int]] = {}

    # --- statements --------------------------------------------------------------------------------

    def step(self, statement: Statement, line: int) -> None:
        """Execute a statement; ``line`` of its calls is already the next one.

        Raises
        ------
        ProgramError
        """
        with locate_errors(statement.column):
            self._execute(statement, line)

    def _execute(self, statement: Statement, line: int) -> None:
        flow = self.flow
        if statement.kind == "if":
            self._execute_if(statement, line)
        elif statement.kind == "goto":
            statement.start()
            self._jump(statement, line)
        elif statement.kind == "end":
            begin = self._find_loops(flow.calls.text).begin
            if line not in begin:
                raise ProgramError("VP023", "END without the DO that it would end").advise(CLOSE_IN_ORDER)
            flow.calls.line = begin[line]
        else:
            holds = statement.kind == "do" or statement.read_condition()
            end = self._find_loops(flow.calls.text).end
            if line not in end:
                raise ProgramError("VP023", "expected WHILE [...] DO1, with END1 after it; numbers are 1 to 9")
            if not holds:
                flow.calls.line = end[line] + 1

    def _execute_if(self, statement: Statement, line: int) -> None:
        holds = statement.read_condition()
        statement.refuse_misspelt("GOTO", "THEN")
        goes = statement.pass_word("GOTO", "GO")
        if not goes and not statement.pass_word("THEN", "TH"):
            raise statement.reader.error("VP001", "expected GOTO or THEN", statement.reader.at)
        if not holds:
            self._check_unused(statement, goes=goes)
            return
        if goes or statement.pass_word("GOTO", "GO"):
            self._jump(statement, line)
            return
        for setting in statement.read_settings():
            self.flow.interpreter.set_parameter(*setting)

    @staticmethod
    def _check_unused(statement: Statement, *, goes: bool) -> None:
        """What follows a false condition can be read: its values need not exist, as it is not executed."""
        try:
            if goes or statement.pass_word("GOTO", "GO"):
                statement.read_number("GOTO")
            else:
                list(statement.read_settings())
        except ProgramError as error:
            if error.code in ("VP001", "VP002"):
                raise

    def _jump(self, statement: Statement, line: int) -> None:
        flow, column = self.flow, statement.reader.find_column(statement.reader.at)
        number = statement.read_number("GOTO")
        with locate_errors(column):
            target = self.find_block(number, line, is_marked=True)
            entered_loop = self._find_loops(flow.calls.text).find_entered(line, target)
            if entered_loop is not None:
                raise ProgramError(
                    "VP023", f"GOTO {number} leads into the loop of line {entered_loop}; a jump may only leave a loop"
                )
        flow.calls.line = target

    def find_block(self, number: int, line: int, *, is_marked: bool = False) -> int:
        """The line of a block number: sought from a line on to the end of its program, then from its beginning.

        ``is_marked``: an error stands at the number.

        Raises
        ------
        ProgramError
            VP023: there is none.
        """
        text = self.flow.calls.text
        if (id(text), number) not in self._numbers:
            self._numbers[id(text), number] = find_numbered_lines(text.source, number)
        starts = sorted(text.structure.programs.values())
        first = max((start for start in starts if start <= line), default=text.first_line)
        last = min((start for start in starts if start > line), default=text.closing or text.n_lines + 1)
        within = [at for at in self._numbers[id(text), number] if first <= at < last]
        target = next((at for at in within if at > line), within[0] if within else None)
        if target is None:
            numbers = find_block_numbers(text.source)
            near = list_near_numbers(str(number), numbers)
            also, edits = (
                name_numbers(near, "N"),
                tuple(Remedy(f"write {one}", one, way="marked", is_choice=len(near) > 1) for one in near if is_marked),
            )
            message = f"there is no block N{number} in this program{f'; it has {also}' if also else ''}"
            error = ProgramError("VP023", message, edits=edits).advise(GIVE_LABEL)
            if is_marked:
                next_line = min((at for at in numbers.values() if line < at < last), default=0)
                error.passes_to = max((numbers[one] for one in near), default=next_line)
            raise error
        return target

    def _find_loops(self, text: ProgramText) -> Loops:
        if id(text) not in self._loops:
            self._loops[id(text)] = find_loops(text.source, text.structure.programs.values())
        return self._loops[id(text)]

    # --- calls -------------------------------------------------------------------------------------

    def enter(self, frame: Frame, call: Call) -> None:
        """A macro begins: it has local variables of its own, and no modal call is in force in it."""
        interpreter = self.flow.interpreter
        numbered_values = interpreter.state.store.numbered_values
        frame.outer, frame.call = {key: numbered_values.pop(key) for key in LOCAL if key in numbered_values}, call
        numbered_values.update(call.arguments or {})
        if call.keeps:
            interpreter.modes.macro = None

    def repeat(self, frame: Frame) -> None:
        """A macro begins again (L of G65), with the arguments of its call."""
        if frame.call is not None:
            numbered_values = self.flow.interpreter.state.store.numbered_values
            for key in LOCAL:
                numbered_values.pop(key, None)
            numbered_values.update(frame.call.arguments or {})

    def leave(self, frame: Frame) -> None:
        """A macro ends: the local variables of before hold again."""
        call = frame.call
        if frame.outer is None or call is None:
            return
        interpreter = self.flow.interpreter
        numbered_values = interpreter.state.store.numbered_values
        last = {key: numbered_values.pop(key) for key in LOCAL if key in numbered_values}
        numbered_values.update(frame.outer)
        if call.keeps and call.arguments is not None:  # the next call goes on with them
            call.arguments.clear()
            call.arguments.update(last)
            interpreter.modes.macro = call
