"""Subprograms of Siemens programs: PROC lines, arguments, where a name is defined."""

import re
from typing import Final

from msgspec import Struct, field
from msgspec.structs import replace

from verne_post.base.printable import join_names
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.setup import Setup
from verne_post.gcode.siemens.arguments import NUMBER
from verne_post.gcode.siemens.cursor import NAME, Cursor
from verne_post.gcode.siemens.modes import Modes
from verne_post.gcode.siemens.program import Section, SiemensText
from verne_post.gcode.siemens.values import Index, Value, read_indices
from verne_post.gcode.siemens.variables import Variable, Variables, read_type
from verne_post.gcode.siemens.words import Argument, Call, read_argument_values
from verne_post.gcode.text import decode_line, take_code
from verne_post.model.findings import Remedy

_PROC: Final = re.compile(r"[ \t]*(?:N[0-9]+)?[ \t]*PROC[ \t]+", re.IGNORECASE)
#: What may follow the arguments of PROC.
_FLAGS: Final = ("SAVE", "DISPLOF", "DISPLON", "SBLOF", "SBLON", "ACTBLOCNO", "PREPRO")
_ENDINGS: Final = ("", "_spf", "_mpf")
#: Errors that a value may lead to.
_OF_VALUES: Final = ("VP005", "VP007", "VP008", "VP009")
#: Lines that may stand before PROC.
_LINES_BEFORE: Final = 200


class Parameter(Struct, frozen=True):
    """A parameter of PROC: name, type, default; ``by_name`` (VAR): it sets the caller's variable.

    ``bounds`` are those of an array, 0 where the PROC line leaves one out; empty: no array.
    """

    name: str
    kind: str
    default: Value | None
    by_name: bool
    bounds: tuple[int, ...] = ()


class Procedure(Struct, frozen=True):
    """What the PROC line says: its line, its values, and whether modes are restored at the end (SAVE)."""

    line: int
    parameters: tuple[Parameter, ...] = ()
    save: bool = False
    is_missing: bool = False  #: The subprogram has no PROC line.
    name: str = ""  #: Which the PROC line gives.


class Repeat(Struct):
    """A stretch of lines that REPEAT executes again, and where the program goes on after it."""

    first: int
    last: int
    remaining: int
    back: int


class Outside(Struct, frozen=True):
    """A variable of the caller (VAR) that the one ``inside`` a subprogram sets when that returns."""

    inside: str
    name: str
    index: tuple[Index, ...]


class Frame(Struct):
    """One call: its program, how often it still runs, what it begins with and brings back."""

    section: Section
    remaining: int = 1
    saved_modes: Modes | None = None
    modal: Call | None = None
    repeats: list[Repeat] = field(default_factory=list)
    ends: dict[int, float] = field(default_factory=dict)
    results: list[Outside] = field(default_factory=list)
    scope: dict[str, Variable] = field(default_factory=dict)
    missing: "MissingValues | None" = None


class MissingValues(Struct, frozen=True):
    """Values of a PROC line that a call in the program leaves out: where it stands, and what is to be said of it."""

    line: int
    column: int
    names: tuple[str, ...]
    message: str
    remedy: str = "Write the missing values into the call."

    @property
    def cause(self) -> str:
        """Errors with the same one are one finding."""
        return f"{self.message} {self.line}"

    def find_used(self, error: ProgramError, code: str, values: dict[str, Variable]) -> list[str]:
        """The values of these that ``code``, which fails, reads and nothing has set, if they may lead to the error."""
        used_names = {one.upper() for one in NAME.findall(code)} if error.code in _OF_VALUES else set()
        return [name for name in self.names if error.line is None and name in used_names and not values[name].values]

    def explain(self, error: ProgramError, where: str) -> None:
        """Say in an error of the subprogram that a missing value leads to it, at the call; ``where`` names its line."""
        error.line, error.column, error.of_program = self.line, self.column, True
        error.code, error.message = "VP005", f"{self.message} ({where}: {error.message})"
        error.cause, error.edits, error.settled_by = self.cause, (), ()
        error.advise(self.remedy)


class Library:
    """Finds subprograms: in the text that calls, in the program, in files."""

    def __init__(self, setup: Setup, main: SiemensText) -> None:
        self.setup, self.main = setup, main
        self._files: dict[str, SiemensText] = {}

    def list_names(self) -> list[str]:
        """The names of the subprograms in the program and in files."""
        files = (key.removesuffix("_spf").removesuffix("_mpf").upper() for key in self.setup.subroutines)
        return [*(section.name for section in self.main.sections), *files]

    def find(self, name: str, text: SiemensText) -> Section | None:
        """The subprogram of a name; None where there is none."""
        for place in (text, self.main):
            section = place.find_section(name)
            if section is not None:
                return section
        for ending in _ENDINGS:
            key = name.lower() + ending
            source = self.setup.subroutines.get(key)
            if source is not None:
                if key not in self._files:
                    self._files[key] = SiemensText(source, self.setup, self.setup.name_file(key, "spf"))
                return self._files[key].main
        return None


#: A name, and the type of a value, between which the bracket is missing.
_TYPE_BEHIND_NAME: Final = re.compile(r"(\w+)(?:VAR|REAL|INT|BOOL|STRING|CHAR|AXIS)")
#: A PROC line without PROC, or with another word in its place.
_HEADLESS: Final = re.compile(
    r"[ \t]*(?:N\d+[ \t]*)?(?:([^ \t(;]+)[ \t]+)?([A-Z_]\w*)[ \t]*\([ \t]*(?:VAR|REAL|INT|BOOL|STRING|CHAR|AXIS)\b",
    re.I,
)


def read_procedure(section: Section) -> Procedure:
    """The PROC line of a subprogram; one without has no values. Errors have its line."""
    for line in range(section.first, min(section.last, section.first + _LINES_BEFORE) + 1):
        text = take_code(decode_line(section.text.read_line(line)).rstrip("\r"))
        if not text.strip() or text.lstrip().startswith("%"):
            continue
        match = _PROC.match(text)
        try:
            if match is None:
                _refuse_headless(text)
                return Procedure(line - 1, is_missing=True)
            return _read_proc(Cursor(text, match.end()), line)
        except ProgramError as error:
            error.line = line
            raise
    return Procedure(section.first - 1, is_missing=True)


def _refuse_headless(text: str) -> None:
    """Refuse a PROC line in which PROC is misspelt (VP002), glued to the name, or missing (VP001)."""
    match = _HEADLESS.match(text)
    if match is None:
        return
    word, name = match[1], match[2]
    if word is not None:
        message = f"{word}: values of a subprogram follow PROC and its name; did you mean PROC?"
        raise ProgramError("VP002", message, match.start(1) + 1)
    if name[:4].upper() == "PROC" and len(name) > len("PROC"):
        message = f"{name}: a blank is missing; did you mean PROC {name[4:]}?"
        raise ProgramError("VP001", message, match.start(2) + 1)
    message = f"{name}: PROC is missing before the name of the subprogram; did you mean PROC {name}?"
    raise ProgramError("VP001", message, match.start(2) + 1)


def _read_proc(cursor: Cursor, line: int) -> Procedure:
    cursor.skip()
    at = cursor.at
    own_name = cursor.name() or ""
    name_and_type = _TYPE_BEHIND_NAME.fullmatch(own_name)
    if name_and_type is not None and cursor.peek_name() is not None and ")" in cursor.text:
        written_text, end = cursor.text[at : at + name_and_type.end()], name_and_type.end(1)
        right = f"{written_text[:end]}({written_text[end:]}"
        raise cursor.error("VP001", f"{written_text}: a ( is missing; did you mean {right}?", at)
    found: list[Parameter] = []
    if cursor.take("(") and not cursor.take(")"):
        while True:
            found.append(_read_parameter(cursor))
            if cursor.take(")"):
                break
            if (name := cursor.peek_name()) is not None:
                head, end = cursor.text[: cursor.at], cursor.at + len(name)
                before = head.split()[-1]
                right, wrong = f"{before}, {name}", cursor.text[head.rindex(before) : end]
                edits = (Remedy(f"write {right}", right, misspelt=wrong),)
                raise cursor.error("VP001", f"{wrong}: a comma is missing; write {right}", edits=edits)
            cursor.expect(",", "or ')' after a value of PROC")
    save = False
    while (name := cursor.name()) is not None:
        if name not in _FLAGS:
            raise cursor.error("VP002", f"{name} is not known after PROC")
        save = save or name == "SAVE"
    return Procedure(line, tuple(found), save, name=own_name)


def _read_parameter(cursor: Cursor) -> Parameter:
    by_name = cursor.peek_name() == "VAR"
    if by_name:
        cursor.name()
    kind = read_type(cursor)
    cursor.skip()
    at, name = cursor.at, cursor.name()
    if name is None:
        raise cursor.error("VP001", "expected the name of a value of PROC", at)
    if cursor.take("["):
        return Parameter(name, kind, None, by_name, _read_bounds(cursor))
    default: Value | None = None
    if cursor.take("="):
        sign = -1.0 if cursor.take("-") else 1.0
        cursor.skip()
        number = cursor.number()
        default = sign * number if number is not None else cursor.read_string()
    return Parameter(name, kind, default, by_name)


def _read_bounds(cursor: Cursor) -> tuple[int, ...]:
    """Sizes of an array after ``[``; a size may be left out."""
    found = []
    while True:
        cursor.skip()
        found.append(round(cursor.number() or 0.0))
        if cursor.take("]"):
            return tuple(found)
        cursor.expect(",", "or ']' after the size of an array")


def bind_arguments(call: Call, procedure: Procedure, variables: Variables) -> tuple[dict[str, Variable], list[Outside]]:
    """The variables that a call begins with, and which of them set the caller's."""
    arguments = call.arguments or ()
    arguments = () if len(arguments) == 1 and not arguments[0].text.strip() else arguments
    if arguments and procedure.is_missing:
        text = f"{call.name} has no PROC line, so it takes no values, and its call gives {len(arguments)}; write PROC "
        raise ProgramError("VP023", f"{text}{call.name}(...), with a type and a name for each, as its first line")
    if len(arguments) > len(procedure.parameters):
        raise ProgramError(
            "VP023",
            f"{call.name} takes {len(procedure.parameters)} values (its PROC line); here are {len(arguments)}",
            call.column,
        )
    scope: dict[str, Variable] = {}
    results = []
    for number, parameter in enumerate(procedure.parameters):
        if parameter.bounds:
            scope[parameter.name] = _bind_array(call, arguments[number : number + 1], parameter, variables)
            continue
        value = next(iter(read_argument_values(arguments[number : number + 1], variables)), None)
        if value is None:
            value = parameter.default
        variable = Variable(parameter.kind)
        if value is not None:
            variable.values[()] = variable.convert(value, parameter.name, Cursor("", 0), call.column - 1)
        scope[parameter.name] = variable
        if parameter.by_name and number < len(arguments):
            cursor = Cursor(arguments[number].text)
            name = cursor.name()
            if name is not None:  # the index counts as it is now
                results.append(Outside(parameter.name, name, read_indices(cursor, variables)))
    return scope, results


def find_missing_values(call: Call, procedure: Procedure, line: int) -> MissingValues | None:
    """What a call of the program leaves out of the values that its PROC line asks for; None where nothing."""
    given = [bool(argument.text.strip()) for argument in call.arguments or ()]
    given += [False] * (len(procedure.parameters) - len(given))
    pairs = list(zip(procedure.parameters, given, strict=False))
    missing = [one for one, is_given in pairs if not (is_given or one.bounds or one.default is not None)]
    if not missing:
        return None
    names = join_names([f"{one.name} ({one.kind})" for one in missing])
    counts = f"{'is' if len(missing) == 1 else 'are'} missing and count{'s' * (len(missing) == 1)} as 0"
    text = f"{call.name} gives {sum(given)} of the {len(pairs)} values of its PROC line: {names} {counts}"
    return MissingValues(call.line or line, call.column, tuple(one.name for one in missing), text)


def copy_scope(scope: dict[str, Variable]) -> dict[str, Variable]:
    """Variables that do not change with those of another pass; arrays of the caller stay the caller's."""
    return {
        name: variable if variable.bounds else Variable(variable.kind, values=dict(variable.values))
        for name, variable in scope.items()
    }


def _bind_array(call: Call, given: tuple[Argument, ...], parameter: Parameter, variables: Variables) -> Variable:
    """The array of the caller itself (VAR), or a copy; without one an array of its own."""
    text = given[0].text.strip() if given else ""
    if not text:
        return Variable(parameter.kind, parameter.bounds)
    outside = variables.find(text.upper())
    fits = outside is not None and outside.kind == parameter.kind and len(outside.bounds) == len(parameter.bounds)
    if (
        outside is None
        or not fits
        or any(size not in (0, n) for size, n in zip(parameter.bounds, outside.bounds, strict=True))
    ):
        sizes = ",".join(str(size or "") for size in parameter.bounds)
        raise ProgramError(
            "VP023",
            f"{call.name}: {parameter.name} is an array, {parameter.kind}[{sizes}]; {text[:20]} is none",
            given[0].column,
        )
    return outside if parameter.by_name else Variable(outside.kind, outside.bounds, dict(outside.values))


def freeze(call: Call, variables: Variables, line: int) -> Call:
    """A call whose arguments are numbers and texts: MCALL of a line reads them once."""
    if call.arguments is None:
        return replace(call, line=line)
    values = read_argument_values(call.arguments, variables)
    arguments = zip(call.arguments, values, strict=True)
    return Call(call.name, tuple(_freeze_value(one, value) for one, value in arguments), call.column, line)


def _freeze_value(argument: Argument, value: Value | None) -> Argument:
    """The same with its value, in brackets where the program has no number there."""
    if value is None or NUMBER.fullmatch(argument.text.strip()):
        return argument
    text = f'"{value}"' if isinstance(value, str) else f"({float(value)!r})".replace("e+", "EX").replace("e", "EX")
    return Argument(text, argument.column)
