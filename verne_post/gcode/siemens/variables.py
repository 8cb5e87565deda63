"""Variables of Siemens programs: R parameters, those that DEF and PROC define, arrays, scopes of calls."""

from typing import Final, Protocol

from msgspec import Struct, field

from verne_post.base.numbers import round_half_away
from verne_post.base.suggestions import (
    LETTERS_OF_FUNCTIONS,
    MAY_BE_MEANT,
    find_correction,
    find_meant,
    find_suggestion,
    name_near_numbers,
    suggest,
)
from verne_post.gcode.mistyped import MEANT_CHARACTERS
from verne_post.gcode.program_error import DOUBLE_EQUALS, ProgramError, write_meant
from verne_post.gcode.siemens.cursor import NAME, NUMBER, Cursor
from verne_post.gcode.siemens.slips import (
    explain_glued_value,
    explain_signed_count,
    refuse_lost_equals,
    refuse_no_value,
    refuse_no_word,
)
from verne_post.gcode.siemens.values import FUNCTIONS, Index, Names, Value, read_indices, read_value
from verne_post.gcode.siemens.vocabulary import CONSTANTS, GROUP_OF, STATEMENTS, TYPES, VALUE_MODES

#: What other languages call them.
_TYPES_ELSEWHERE: Final = {"INTEGER": "INT", "FLOAT": "REAL", "DOUBLE": "REAL", "BOOLEAN": "BOOL"}
#: R parameters that there are: as many as a control can be given.
_LAST_R: Final = 32_535
#: Words that a variable of the same name would silently take away: axes, feed rate, spindle, tool.
_WORDS: Final = tuple("XYZABCFSTD")
#: Elements of an array at most.
_MAX_ELEMENTS: Final = 100_000


class SystemVariables(Protocol):
    """Variables that begin with ``$``."""

    def read_system(self, name: str, index: tuple[Index, ...], cursor: Cursor, at: int) -> Value:
        """Value of one; raises ProgramError."""

    def write_system(self, name: str, index: tuple[Index, ...], value: Value, cursor: Cursor, at: int) -> None:
        """Set one; raises ProgramError."""

    def assign_frame(self, name: str, index: tuple[Index, ...], cursor: Cursor, at: int, names: Names) -> bool:
        """Read the value of a frame and set a variable to it; False for variables that are no frames."""


class Variable(Struct):
    """One variable: its type, bounds of its indices (empty: no array), and its values by index."""

    kind: str
    bounds: tuple[int, ...] = ()
    values: dict[tuple[Index, ...], Value] = field(default_factory=dict)

    def convert(self, value: Value, name: str, cursor: Cursor, at: int) -> Value:
        """A value as the type has it: INT rounds, BOOL is 0 or 1."""
        if (self.kind == "STRING" or self.kind == "CHAR") != isinstance(value, str) and self.kind != "CHAR":
            what = "a text" if isinstance(value, str) else "a number"
            raise cursor.error("VP007", f"{name} is of type {self.kind}; {what} cannot be assigned to it", at)
        if isinstance(value, str):
            return value
        if self.kind == "INT":
            return round_half_away(value)
        return float(value != 0) if self.kind == "BOOL" else value

    def find_default(self) -> Value:
        """What it has before anything is assigned."""
        return "" if self.kind == "STRING" else 0.0


class Variables(Struct):
    """All variables that are visible where the program is: those of the call, then those of the main program."""

    system: SystemVariables
    r: dict[int, float] = field(default_factory=dict)
    scopes: list[dict[str, Variable]] = field(default_factory=lambda: [{}])
    unset_r: list[int] = field(default_factory=list)  #: R parameters that have been read before they were set.

    def find(self, name: str) -> Variable | None:
        """The variable of a name."""
        scope = self.scopes[-1]
        if name in scope:
            return scope[name]
        return self.scopes[0].get(name)

    def is_known(self, name: str) -> bool:
        """True where a name is that of a variable that a program may set."""
        return name == "R" or read_r_number(name) is not None or name.startswith("$") or self.find(name) is not None

    # --- reading ------------------------------------------------------------------------------------

    def read(self, name: str, index: tuple[Index, ...], cursor: Cursor, at: int) -> Value:
        """Value of a variable."""
        number = read_r_number(name)
        if number is not None and not index:
            return self._read_r(self._check_r(number, cursor, at))
        if name == "R" and not index and (message := explain_signed_count(cursor, at)):
            raise cursor.error("VP001", message, at)
        if name == "R":
            return self._read_r(self._check_r(index[0] if len(index) == 1 else -1, cursor, at))
        if name.startswith("$"):
            return self.system.read_system(name, index, cursor, at)
        variable = self.find(name)
        if variable is None and name in CONSTANTS and not index:
            return CONSTANTS[name]
        if variable is None and (joined_name := self._join_name(name, cursor, at)):
            raise cursor.error("VP025", joined_name, at)
        if variable is None:
            near = suggest(name, *({*scope} for scope in reversed(self.scopes)))
            if len(name) == 1 and near:  # NR for N may be right, and N*R3 is nearly NR*3
                near = f"; {find_suggestion(near)}{MAY_BE_MEANT}"
            near = near or (f"; did you mean _{name}?" if f"_{name}" in CONSTANTS else "")
            define = f"; if it is one of the machine's builder, write its value on top: DEF REAL {name}=0"
            text = f"{name} is neither defined (DEF) nor a function or variable that is known here{near or define}"
            raise cursor.error("VP025", text, at)
        return variable.values.get(self._check_index(variable, name, index, cursor, at), variable.find_default())

    def _join_name(self, name: str, cursor: Cursor, at: int) -> str:
        """What is meant by a name in which a blank is too many, and by Rl0: the message; empty for others."""
        if glued_words := explain_glued_value(name, cursor.text, at, self.is_known):
            return glued_words
        written_name = cursor.text[at : at + len(name)]
        digits = written_name[1:].translate(MEANT_CHARACTERS)
        if name[0] == "R" and digits.isdecimal():  # digits alone are an R parameter
            return f"{written_name}: a letter in the number; did you mean {written_name[0]}{digits}?"
        following = NAME.match(cursor.text, cursor.at)
        whole = "" if following is None else name + following[0].upper()
        if following is None or not (self.find(whole) or whole in VALUE_MODES or whole in FUNCTIONS):
            return ""
        both = cursor.text[at : following.end()]
        return f"{both}: a blank is in the name; did you mean {written_name}{following[0]}?"

    def _read_r(self, number: int) -> float:
        if number not in self.r:
            self.unset_r.append(number)
        return self.r.setdefault(number, 0.0)

    def explain_unset(self, number: int) -> str:
        """What is to be told of an R parameter that has been read before it was set."""
        near = name_near_numbers(str(number), (str(one) for one in self.r if one not in self.unset_r), "R")
        text = f"R{number} is read before the program sets it: it counts as 0, and a control has its last value"
        return f"{text}; write R{number}=0 first if that is meant{f'; the program sets {near}' if near else ''}"

    def look_up(self, name: str) -> Value | None:
        """Value of an R parameter, or of a variable that is no array; None for another name."""
        number, variable = read_r_number(name.upper()), self.find(name.upper())
        if number is not None:
            return self.r.get(number, 0.0)
        return None if variable is None or variable.bounds else variable.values.get((), variable.find_default())

    # --- setting ------------------------------------------------------------------------------------

    def write(self, name: str, index: tuple[Index, ...], value: Value, cursor: Cursor, at: int) -> None:
        """Assign a value."""
        number = read_r_number(name) if not index else index[0] if name == "R" and len(index) == 1 else None
        if number is not None or name == "R":
            if number is None and not index:
                raise cursor.error("VP025", "R without a number; write R and the number of the parameter", at)
            number = self._check_r(-1 if number is None else number, cursor, at)
            if isinstance(value, str):
                raise cursor.error("VP007", f"R{number} is a number; a text cannot be assigned to it", at)
            self.r[number] = value
        elif name.startswith("$"):
            self.system.write_system(name, index, value, cursor, at)
        else:
            variable = self.find(name)
            if variable is None:
                edits = write_meant(name, *({*scope} for scope in reversed(self.scopes)))
                right = edits[0].value if edits else f"DEF REAL {name} at the beginning"
                raise cursor.error("VP025", f"{name} is not defined; write {right}", at, edits)
            variable.values[self._check_index(variable, name, index, cursor, at)] = variable.convert(
                value, name, cursor, at
            )

    def assign(self, name: str, cursor: Cursor, at: int) -> None:
        """Read ``[...] = value`` after a name, and assign it; arrays may be given several values."""
        index = read_indices(cursor, self)
        if cursor.text.startswith("==", cursor.at):
            raise cursor.error("VP001", DOUBLE_EQUALS)
        cursor.expect("=", f"and a value after {name}")
        refuse_no_value(cursor, name, at)
        if name.startswith("$") and self.system.assign_frame(name, index, cursor, at, self):
            return
        variable = self.find(name)
        if variable is not None and variable.bounds and cursor.peek_name() in ("SET", "REP"):
            self._fill(variable, name, self._check_index(variable, name, index, cursor, at), cursor, at)
            return
        try:
            value = read_value(cursor, self)
        except ProgramError:
            if (number := read_r_number(name)) is not None:
                self.r.setdefault(number, 0.0)  # what reads it has no error of its own
            raise
        self.write(name, index, value, cursor, at)

    # --- defining -------------------------------------------------------------------------------------

    def define(self, cursor: Cursor) -> None:
        """Read what follows DEF: a type, and names with sizes and values."""
        kind, defined_names = read_type(cursor), list[str]()
        while True:
            cursor.skip()
            at, name = cursor.at, cursor.name()
            if name is None or read_r_number(name) is not None or name.startswith("$"):
                raise cursor.error("VP001", "expected the name of a variable after DEF and its type", at)
            if name in self.scopes[-1]:
                raise cursor.error("VP004", f"{name} is defined twice", at)
            if name in _WORDS or name in GROUP_OF or name in STATEMENTS:
                raise cursor.error("VP004", f"{name} is a word of the language; give the variable another name", at)
            bounds = tuple(size for size in read_indices(cursor, self) if isinstance(size, int))
            elements = 1
            for size in bounds:
                elements *= max(size, 0)
            if len(bounds) > 3 or not 0 < elements <= _MAX_ELEMENTS:
                raise cursor.error(
                    "VP007", f"{name}: an array has up to three indices and {_MAX_ELEMENTS} elements", at
                )
            variable = Variable(kind, bounds)
            if cursor.take("="):
                self._initialise(variable, name, cursor, at)
            self.scopes[-1][name] = variable
            defined_names.append(name)
            if not cursor.take(","):
                break
        value = NUMBER.match(cursor.text, cursor.at + (cursor.skip() in ("+", "-")))
        if value is not None and not bounds:
            error = refuse_lost_equals(cursor, at, name, cursor.text[at : value.end()])
            for defined_name in defined_names if find_correction(error.message) else ():  # the line is executed again
                del self.scopes[-1][defined_name]
            raise error

    def _initialise(self, variable: Variable, name: str, cursor: Cursor, at: int) -> None:
        """A value, or the values of an array: in brackets, SET or REP."""
        if variable.bounds:
            self._fill(variable, name, (0,) * len(variable.bounds), cursor, at)
        else:
            variable.values[()] = variable.convert(read_value(cursor, self), name, cursor, at)

    def _fill(self, variable: Variable, name: str, first: tuple[Index, ...], cursor: Cursor, at: int) -> None:
        """Values of the elements from one on: SET(1,,3), in which a gap leaves its element, or REP(value, how many)."""
        places = _list_every_index(variable.bounds)
        places = places[places.index(first) :]
        if (word := cursor.peek_name()) in ("SET", "REP"):
            cursor.name()
        cursor.expect("(", f"and the values of the array {name}")
        if word == "REP":
            value, count = variable.convert(read_value(cursor, self), name, cursor, at), len(places)
            if cursor.take(","):
                given = read_value(cursor, self)
                if given not in range(1, count + 1):
                    raise cursor.error("VP007", f"REP: {given} elements; from here on {name} has {count}", at)
                count = int(given)
            variable.values.update(dict.fromkeys(places[:count], value))
        else:
            for index in places:
                if cursor.skip() not in (",", ")"):
                    variable.values[index] = variable.convert(read_value(cursor, self), name, cursor, at)
                if not cursor.take(","):
                    break
        cursor.expect(")", "after the values of an array")

    @staticmethod
    def _check_r(number: Index, cursor: Cursor, at: int) -> int:
        if not isinstance(number, int) or not 0 <= number <= _LAST_R:
            raise cursor.error("VP025", f"R parameters are R0 to R{_LAST_R}", at)
        return number

    @staticmethod
    def _check_index(
        variable: Variable, name: str, index: tuple[Index, ...], cursor: Cursor, at: int
    ) -> tuple[Index, ...]:
        if len(index) != len(variable.bounds):
            raise cursor.error("VP025", f"{name} has {len(variable.bounds)} indices; here are {len(index)}", at)
        for given, size in zip(index, variable.bounds, strict=True):
            if not isinstance(given, int) or not 0 <= given < size:
                raise cursor.error("VP025", f"{name}: the index {given} is not one of 0 to {size - 1}", at)
        return index


def _list_every_index(bounds: tuple[int, ...]) -> list[tuple[Index, ...]]:
    found: list[tuple[Index, ...]] = [()]
    for size in bounds:
        found = [(*index, number) for index in found for number in range(size)]
    return found


def read_r_number(name: str) -> int | None:
    """The number of an R parameter as R12; None for other names."""
    return int(name[1:]) if name[0] == "R" and name[1:].isdigit() and len(name) < 8 else None


def read_type(cursor: Cursor) -> str:
    """Read a type of DEF or PROC; words for where a variable is visible or who may change it may stand before it."""
    while True:
        cursor.skip()
        at, name = cursor.at, cursor.name()
        if name in ("NCK", "CHAN", "SYNR", "SYNW", "SYNRW"):
            continue
        if name in ("AXIS", "FRAME"):
            raise cursor.error("VP002", f"variables of type {name} are not executed", at)
        if name not in TYPES:
            near = find_meant(name or "", TYPES, slip_alone=True, least=LETTERS_OF_FUNCTIONS)
            near = near or find_meant(f"DEF {name}", [f"DEF {one}" for one in TYPES], slip_alone=True)[len("DEF ") :]
            near = _TYPES_ELSEWHERE.get(name or "", near)
            types = f"expected a type: {', '.join(TYPES)}"
            raise cursor.error("VP001", f"{name}: {types}; did you mean {near}?" if near else types, at)
        if name == "STRING" and cursor.take("["):
            cursor.number()
            cursor.expect("]", "after the length of a STRING")
        return name


def refuse_leftover(cursor: Cursor) -> None:
    """Nothing may follow."""
    if not cursor.is_at_end and cursor.text[cursor.at] in ")]":
        raise refuse_no_word(cursor, cursor.at, lambda _name: False)
    if not cursor.is_at_end:
        raise ProgramError(
            "VP001", f"{cursor.text[cursor.at : cursor.at + 20].rstrip()!r}: nothing may follow here", cursor.at + 1
        )
