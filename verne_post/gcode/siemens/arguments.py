"""Arguments of cycles by name: numbers, texts, what was left out."""

import math
import re
from collections.abc import Sequence
from typing import Final

from msgspec import Struct, field

from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.machining.holes import METRIC_PITCH
from verne_post.gcode.program_error import ProgramError, write_words
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.siemens.values import Value
from verne_post.gcode.siemens.variables import Variables
from verne_post.gcode.siemens.words import Call, read_argument_values
from verne_post.model.findings import Remedy

#: Between a height and a depth that are rounded each, in the unit of the program.
_ROUNDED_DEPTH: Final = 0.002
#: _PITA of a pitch -> its unit, mm; 0 is that of the program.
_PITCH_UNITS: Final = {0: 0.0, 1: 1.0, 2: MM_PER_INCH, 3: MM_PER_INCH}
_TURNS_AN_INCH: Final = 2
#: A value that is a number alone.
NUMBER: Final = re.compile(r"[-+]?[\d.]+")
#: Values of threads that only an editor reads: the pitch as a text, and the row of a table of threads.
OF_EDITOR: Final = ("_PITM", "_PTAB", "_PTABA")


class Arguments(Struct):
    """The arguments of one call of a cycle; ``used`` are the names that were asked for."""

    call: Call
    values: dict[str, Value]
    names: Sequence[str]
    used_names: set[str] = field(default_factory=set)

    def is_given(self, name: str) -> bool:
        """True where it was not left out."""
        self.used_names.add(name)
        return name in self.values

    def number(self, name: str, default: float = 0.0) -> float:
        """A number; left out: the default."""
        self.used_names.add(name)
        value = self.values.get(name, default)
        if isinstance(value, str):
            raise self.error("VP007", f'{name} is "{value[:20]}"; a number is needed', name)
        return value

    def require(self, *groups: tuple[str, ...]) -> None:
        """Refuse (VP005) a call in which, of groups of names, none is given; all of them at once."""
        missing = [group for group in groups if not any(map(self.is_given, group))]
        if missing:
            *some, last = map(" or ".join, missing)
            text = f"{', '.join(some)} and {last} are needed" if some else f"{last} is needed"
            raise self.error("VP005", text, missing[0][0])

    def read_whole(self, name: str, default: int = 0) -> int:
        """A whole number."""
        value = self.number(name, default)
        if value != round(value):
            raise self.error("VP007", f"{name} {value:g} is not whole", name)
        return round(value)

    def read_text(self, name: str) -> str:
        """A text; left out: empty."""
        self.used_names.add(name)
        value = self.values.get(name, "")
        if not isinstance(value, str):
            raise self.error("VP007", f"{name} {value:g} is a number; a text is needed", name)
        return value

    def error(self, code: str, message: str, name: str) -> ProgramError:
        """An error at an argument."""
        at = list(self.names).index(name) if name in self.names else -1
        column, place = self.call.column, ""
        if at >= len(self.call.arguments or ()):  # there is no character to mark
            place = f" (value {at + 1} of the call)"
        if self.call.arguments and 0 <= at < len(self.call.arguments):
            argument = self.call.arguments[at]
            column = argument.column + len(argument.text) - len(argument.text.lstrip())
        return ProgramError(code, f"{self.call.name}: {message}{place}", column)

    def write_opposite(self, name: str) -> tuple[Remedy, ...]:
        """The edit of an error that the other sign of a number settles, where the call has a number for it."""
        arguments, at = self.call.arguments or (), list(self.names).index(name)
        text = arguments[at].text.strip() if at < len(arguments) else ""
        return write_words(text, f"-{text}".replace("-+", "-").removeprefix("--")) if NUMBER.fullmatch(text) else ()

    def refuse_rest(self, harmless: Sequence[str] = ()) -> None:
        """Arguments that were given other than 0, and that nothing has asked for, are not executed."""
        for name, value in self.values.items():
            if name not in self.used_names and name not in harmless and value not in (0.0, ""):
                shown_value = value if isinstance(value, str) else f"{value:g}"
                raise self.error("VP002", f"{name} {shown_value} is not executed", name)


def read_cycle(call: Call, names: Sequence[str], variables: Variables) -> Arguments:
    """Read the arguments of a call by the names that the cycle gives them.

    ProgramError VP005: more than the cycle has.
    """
    given = read_argument_values(call.arguments or (), variables)
    if len(given) > len(names):
        raise ProgramError("VP005", f"{call.name} has {len(names)} values; here are {len(given)}", call.column)
    return Arguments(call, {name: value for name, value in zip(names, given, strict=False) if value is not None}, names)


def check_depths(given: Arguments, absolute: str, relative: str, bottom: float, recorder: Recorder, line: int) -> None:
    """Warn (VP505) of a height beside another depth below RFP, which counts in its place, where the cycle is called.

    ``bottom`` is where the depth ends, in the unit of the program. A height of 0 is taken for a value left out.

    Raises
    ------
    ProgramError
        VP007: the depth below RFP is negative, as where a comma was lost.
    """
    depth, height = given.number(relative), given.number(absolute)
    if depth < 0:
        text = f"{relative} {depth:g}: a depth below RFP is not negative; write {-depth:g}"
        if height:
            text += f", or leave {relative} empty, with a comma for it, if {absolute} {height:g} is meant"
        raise given.error("VP007", text, relative)
    if not height or abs(height - bottom) <= _ROUNDED_DEPTH:
        return
    text = (
        f"{absolute} is {height:g}, but {relative} {depth:g} below RFP ends at {bottom:g}, and {relative} counts; "
        "leave one of them empty"
    )
    error = given.error("VP505", text, relative)
    recorder.warn(error.code, error.message, given.call.line or line, error.column)


def read_pitch(given: Arguments, unit: float) -> float:
    """Pitch of a thread, mm, below 0 for left-hand: PIT in the unit of _PITA, or MPIT, a metric size.

    ``unit`` is that of lengths, mm.
    """
    pitch, size = given.number("PIT"), given.number("MPIT")
    if not pitch and size:
        if abs(size) not in METRIC_PITCH:
            raise given.error(
                "VP007", f"MPIT {size:g}: no coarse thread of this size is known; give PIT, its pitch", "MPIT"
            )
        return math.copysign(METRIC_PITCH[abs(size)], size)
    kind = given.read_whole("_PITA") if "_PITA" in given.names else 0
    if kind not in _PITCH_UNITS:
        raise given.error("VP002", f"_PITA {kind} is not executed: 1 mm, 2 turns an inch, 3 inch", "_PITA")
    if kind == _TURNS_AN_INCH and pitch:
        return MM_PER_INCH / pitch
    return pitch * (_PITCH_UNITS[kind] or unit)
