"""Expressions of Siemens programs: numbers, texts, variables, operators in their order, functions."""

import math
import re
from collections.abc import Callable, Mapping
from typing import Final, Protocol

from verne_post.base.numbers import round_half_away
from verne_post.base.suggestions import LETTERS_OF_FUNCTIONS, find_meant
from verne_post.gcode.expressions import MAX_NESTING
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.siemens.cursor import Cursor
from verne_post.gcode.siemens.vocabulary import VALUE_MODES
from verne_post.model.findings import Remedy

#: What an expression has: a number (BOOL: 0 and 1), or a text.
Value = float | str
#: Numbers that differ by this share are equal, as the control has it.
_EQUAL_SHARE: Final = 1e-12

#: Operators by how strongly they bind; NOT, B_NOT and signs bind strongest of all.
_RANKS: Final = {
    symbol: rank
    for rank, symbols in enumerate(
        (
            ("==", "<>", ">=", "<=", ">", "<"),
            ("<<",),
            ("OR",),
            ("XOR",),
            ("AND",),
            ("B_OR",),
            ("B_XOR",),
            ("B_AND",),
            ("+", "-"),
            ("*", "/", "DIV", "MOD"),
        )
    )
    for symbol in symbols
}
_OPERATOR: Final = re.compile(
    r"(==|<>|>=|<=|<<|[<>]|(?:DIV|MOD|AND|OR|XOR|B_AND|B_OR|B_XOR)(?![A-Z0-9_]))", re.IGNORECASE
)
#: A text in the quotes of other languages; 'HFF' is a number.
_SINGLE_QUOTED: Final = re.compile(r"'+((?!H[^'_]{0,2}'|B[01]*')[^'\"]*)['\"]+", re.IGNORECASE)
#: Operators of one character, and the end of the line.
_ARITHMETIC: Final = frozenset(("+", "-", "*", "/", ""))


class Names(Protocol):
    """Where names of expressions get their values."""

    def read(self, name: str, index: "tuple[Index, ...]", cursor: Cursor, at: int) -> Value:
        """Value of a variable; raises ProgramError (VP025) for one that has none."""


#: An index of a variable: a number, or the name of an axis or component.
Index = int | str


def read_value(cursor: Cursor, names: Names, depth: int = 0) -> Value:
    """Read an expression up to where it ends. ProgramError: With the column of what does not fit."""
    return _Reader(cursor, names, depth).read_level(0)


def read_number(cursor: Cursor, names: Names, depth: int = 0) -> float:
    """Read an expression that must be a number."""
    cursor.skip()
    at = cursor.at
    value = read_value(cursor, names, depth)
    if isinstance(value, str):
        raise cursor.error("VP007", f'"{value[:20]}" is a text; a number is needed', at)
    return value


def read_indices(cursor: Cursor, names: Names, depth: int = 0) -> tuple[Index, ...]:
    """Read ``[...]`` after a name, if it is there: whole numbers, and names such as X or TR."""
    if not cursor.take("["):
        return ()
    if depth > MAX_NESTING:
        raise cursor.error("VP001", f"more than {MAX_NESTING} nested brackets")
    found: list[Index] = []
    while True:
        cursor.skip()
        at, name = cursor.at, cursor.name()
        if name is not None and cursor.skip() in (",", "]") and name in _INDEX_NAMES:
            found.append(name)
        else:
            cursor.at = at
            value = read_number(cursor, names, depth + 1)
            if abs(value - round(value)) > _WHOLE:
                raise cursor.error("VP007", f"the index {value:g} is not whole", at)
            found.append(round(value))
        if cursor.take("]"):
            return tuple(found)
        cursor.expect(",", "or ']' after an index")


#: Indices that are names: axes, and components of frames.
_INDEX_NAMES: Final = ("X", "Y", "Z", "A", "B", "C", "TR", "RT", "SC", "MI", "FI")
_WHOLE: Final = 1e-9
#: Of AC, IC and DC.
_LETTERS_OF_MODES: Final = 2
#: With what numbers begin, and NOT and B_NOT.
_DIGITS: Final = frozenset("0123456789.")
_NEGATES: Final = frozenset("NnBb")


class _Reader:
    """Recursive descent; values are computed while they are read."""

    def __init__(self, cursor: Cursor, names: Names, depth: int) -> None:
        self.cursor, self.names, self.depth = cursor, names, depth

    def read_level(self, rank: int) -> Value:
        """A value, and the operators that follow it and bind at least as strongly as ``rank``."""
        left = self.read_signed()
        cursor = self.cursor
        while True:
            operator = cursor.skip()
            at = cursor.at
            if operator not in _ARITHMETIC:  # most values end here, or go on with one of these
                match = _OPERATOR.match(cursor.text, at)
                if match is None:
                    return left
                operator = match[1].upper()
            if not operator or _RANKS[operator] < rank:
                return left
            cursor.at = at + len(operator)
            left = self._apply(operator, left, self.read_level(_RANKS[operator] + 1), at)

    def read_signed(self) -> Value:
        """A value with signs or NOT before it."""
        cursor = self.cursor
        symbol = cursor.skip()
        at = cursor.at
        if symbol in _DIGITS and (number := cursor.number()) is not None:  # most values are numbers
            return number
        if symbol in ("+", "-"):
            cursor.at += 1
            self._nest(at)
            value = self._number(self.read_signed(), at)
            self.depth -= 1
            return -value if symbol == "-" else value
        name = cursor.peek_name() if symbol in _NEGATES else None
        if name in ("NOT", "B_NOT"):
            cursor.at += len(name)
            self._nest(at)
            value = self._number(self.read_signed(), at)
            self.depth -= 1
            return float(not value) if name == "NOT" else float(~int(value))
        return self.read_primary()

    def _nest(self, at: int) -> None:
        self.depth += 1
        if self.depth > MAX_NESTING:
            raise self.cursor.error("VP001", f"more than {MAX_NESTING} nested brackets", at)

    def read_primary(self) -> Value:
        """A number, a text, a bracket, a function or a variable."""
        cursor = self.cursor
        symbol = cursor.skip()
        at = cursor.at
        if symbol == "(":
            cursor.at += 1
            self._nest(at)
            value = self.read_level(0)
            self.depth -= 1
            if cursor.skip() == "=":
                raise cursor.error("VP001", "=: a comparison is written with two; did you mean ==?")
            cursor.expect(")", "after an expression")
            return value
        if symbol == '"':
            text = cursor.read_string()
            assert text is not None
            return text
        number = cursor.number()
        if number is not None:
            return number
        name = cursor.name()
        if name is None:
            if (quoted_text := _SINGLE_QUOTED.match(cursor.text, at)) is not None:
                right = f'"{quoted_text[1]}"'
                edits = (Remedy(f"write {right}", right, misspelt=quoted_text[0]),)
                text = f"{quoted_text[0]}: a text stands in double quotes; write {right}"
                raise cursor.error("VP001", text, at, edits)
            shown_text = repr(symbol) if symbol else "the end of the line"
            raise cursor.error("VP001", f"expected a value, found {shown_text}", at)
        if name in ("TRUE", "FALSE"):
            return float(name == "TRUE")
        if cursor.skip() == "(":
            return self._read_function(name, at)
        if (constant := {"PI": math.pi, "$PI": math.pi}.get(name)) is not None:
            return constant
        return self.names.read(name, read_indices(cursor, self.names, self.depth), cursor, at)

    def _read_function(self, name: str, at: int) -> Value:
        cursor = self.cursor
        cursor.at += 1
        self._nest(at)
        arguments: list[Value] = []
        if not cursor.take(")"):
            while True:
                arguments.append(self.read_level(0))
                if cursor.take(")"):
                    break
                cursor.expect(",", f"or ')' in {name}")
        self.depth -= 1
        if name in TEXT_FUNCTIONS:
            return self._evaluate_text_function(name, arguments, at)
        if name not in FUNCTIONS:
            near = find_meant(name, FUNCTIONS, TEXT_FUNCTIONS, slip_alone=True, least=LETTERS_OF_FUNCTIONS)
            if not near and cursor.text[:at].rstrip().endswith("="):
                near = find_meant(name, VALUE_MODES, slip_alone=True, least=_LETTERS_OF_MODES)
            text = f"{name}: not a function that is known here{f'; did you mean {near}?' if near else ''}"
            raise cursor.error("VP002", text, at)
        counts, function = FUNCTIONS[name]
        if len(arguments) not in counts:
            wanted_counts = " or ".join(map(str, counts))
            raise cursor.error("VP005", f"{name} takes {wanted_counts} values; here are {len(arguments)}", at)
        numbers = [self._number(argument, at) for argument in arguments]
        try:
            value = function(*numbers)
        except (ValueError, OverflowError, ZeroDivisionError):
            shown_numbers = ", ".join(f"{number:g}" for number in numbers)
            raise cursor.error("VP007", f"{name}({shown_numbers}) has no value", at) from None
        return cursor.check_size(float(value), at)

    def _evaluate_text_function(self, name: str, arguments: list[Value], at: int) -> Value:
        counts, function = TEXT_FUNCTIONS[name]
        if len(arguments) not in counts:
            raise self.cursor.error("VP005", f"{name} takes {' or '.join(map(str, counts))} values", at)
        try:
            return function(*arguments)
        except (ValueError, TypeError, AttributeError, OverflowError):
            raise self.cursor.error("VP007", f"{name} has no value for these arguments", at) from None

    def _number(self, value: Value, at: int) -> float:
        if isinstance(value, str):
            raise self.cursor.error("VP007", f'"{value[:20]}" is a text; a number is needed', at)
        return value

    def _apply(self, operator: str, left: Value, right: Value, at: int) -> Value:
        if operator == "<<":
            text = spell_value(left) + spell_value(right)
            if len(text) > _MAX_TEXT:
                raise self.cursor.error("VP007", f"a text of more than {_MAX_TEXT} characters", at)
            return text
        if isinstance(left, str) or isinstance(right, str):
            if operator in ("==", "<>") and isinstance(left, str) and isinstance(right, str):
                return float((left == right) == (operator == "=="))
            raise self.cursor.error("VP007", f"{operator} of a text; a number is needed", at)
        try:
            value = OPERATORS[operator](left, right)
        except (ZeroDivisionError, OverflowError, ValueError):
            raise self.cursor.error("VP007", f"{left:g} {operator} {right:g} has no value", at) from None
        return self.cursor.check_size(float(value), at)


_MAX_TEXT: Final = 10_000


def spell_value(value: Value) -> str:
    """A value as ``<<`` writes it."""
    return value if isinstance(value, str) else f"{value:.10g}"


def are_equal(a: float, b: float) -> bool:
    """What ``==`` takes for equal."""
    return abs(a - b) <= _EQUAL_SHARE * max(abs(a), abs(b))


def _truncate(value: float) -> int:
    return int(value)


OPERATORS: Final[Mapping[str, Callable[[float, float], float]]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "DIV": lambda a, b: float(math.trunc(a / b)),
    "MOD": lambda a, b: math.fmod(_truncate(a), _truncate(b)),
    "==": are_equal,
    "<>": lambda a, b: not are_equal(a, b),
    ">": lambda a, b: a > b and not are_equal(a, b),
    "<": lambda a, b: a < b and not are_equal(a, b),
    ">=": lambda a, b: a >= b or are_equal(a, b),
    "<=": lambda a, b: a <= b or are_equal(a, b),
    "AND": lambda a, b: bool(a) and bool(b),
    "OR": lambda a, b: bool(a) or bool(b),
    "XOR": lambda a, b: bool(a) != bool(b),
    "B_AND": lambda a, b: _truncate(a) & _truncate(b),
    "B_OR": lambda a, b: _truncate(a) | _truncate(b),
    "B_XOR": lambda a, b: _truncate(a) ^ _truncate(b),
}


FUNCTIONS: Final[Mapping[str, tuple[tuple[int, ...], Callable[..., float]]]] = {
    "SIN": ((1,), lambda a: math.sin(math.radians(a))),
    "COS": ((1,), lambda a: math.cos(math.radians(a))),
    "TAN": ((1,), lambda a: math.tan(math.radians(a))),
    "ASIN": ((1,), lambda a: math.degrees(math.asin(a))),
    "ACOS": ((1,), lambda a: math.degrees(math.acos(a))),
    "ATAN2": ((2,), lambda y, x: math.degrees(math.atan2(y, x))),
    "SQRT": ((1,), math.sqrt),
    "POT": ((1,), lambda a: a * a),
    "TRUNC": ((1,), lambda a: float(math.trunc(a))),
    "ROUND": ((1,), round_half_away),
    "ROUNDUP": ((1,), lambda a: float(math.ceil(a))),
    "ABS": ((1,), abs),
    "LN": ((1,), math.log),
    "EXP": ((1,), math.exp),
    "MINVAL": ((2,), min),
    "MAXVAL": ((2,), max),
    "BOUND": ((3,), lambda low, high, value: min(max(low, value), high)),
}


def _number_of(text: str) -> float:
    cursor = Cursor(text.strip())
    sign = -1.0 if cursor.take("-") else 1.0
    value = cursor.number()
    if value is None or not cursor.is_at_end:
        raise ValueError(text)
    return sign * value


def _is_number(text: str) -> float:
    try:
        _number_of(text)
    except (ValueError, ProgramError):
        return 0.0
    return 1.0


def _cut_text(text: str, first: float, count: float = 1e4) -> str:
    if first < 0 or count < 0:
        raise ValueError(text)
    return text[int(first) : int(first) + int(count)]


TEXT_FUNCTIONS: Final[Mapping[str, tuple[tuple[int, ...], Callable[..., Value]]]] = {
    "STRLEN": ((1,), lambda s: float(len(s + ""))),
    "TOUPPER": ((1,), lambda s: s.upper()),
    "TOLOWER": ((1,), lambda s: s.lower()),
    "NUMBER": ((1,), _number_of),
    "ISNUMBER": ((1,), _is_number),
    "INDEX": ((2,), lambda s, c: float(s.find(c))),
    "RINDEX": ((2,), lambda s, c: float(s.rfind(c))),
    "SUBSTR": ((2, 3), _cut_text),
}
