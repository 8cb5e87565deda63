"""Arguments of cycles by name: numbers, texts, what was left out."""

from collections.abc import Sequence

from msgspec import Struct, field

from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.siemens.values import Value
from verne_post.gcode.siemens.variables import Variables
from verne_post.gcode.siemens.words import Call, read_argument_values


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
        column = self.call.column
        if self.call.arguments and 0 <= at < len(self.call.arguments):
            argument = self.call.arguments[at]
            column = argument.column + len(argument.text) - len(argument.text.lstrip())
        return ProgramError(code, f"{self.call.name}: {message}", column)

    def refuse_rest(self, harmless: Sequence[str] = ()) -> None:
        """Arguments that were given other than 0, and that nothing has asked for, are not executed."""
        for name, value in self.values.items():
            if name not in self.used_names and name not in harmless and value not in (0.0, ""):
                shown_value = value if isinstance(value, str) else f"{value:g}"
                raise self.error("VP002", f"{name} {shown_value} is not executed", name)


def read_cycle(call: Call, names: Sequence[str], variables: Variables) -> Arguments:
    """Read the arguments of a call by the names that the cycle gives them.

    Raises
    ------
    ProgramError
        VP005: more than the cycle has.
    """
    given = read_argument_values(call.arguments or (), variables)
    if len(given) > len(names):
        raise ProgramError("VP005", f"{call.name} has {len(names)} values; here are {len(given)}", call.column)
    return Arguments(call, {name: value for name, value in zip(names, given, strict=False) if value is not None}, names)
