"""Values of Klartext: numbers with point or comma, Q parameters, and formulas with their functions."""

import math
import re
from collections.abc import Callable
from typing import Final, Protocol

from verne_post.base.suggestions import LETTERS_OF_FUNCTIONS, find_meant
from verne_post.gcode.expressions import MAX_NESTING, MAX_NUMBER
from verne_post.gcode.program_error import ProgramError, locate_errors
from verne_post.model.findings import Remedy

#: A number or a parameter with a sign, as words have it.
VALUE: Final = r"[+-]?[ \t]*(?:\d+[.,]?\d*|[.,]\d+|Q[LR]?\d+)"
_TOKEN: Final = re.compile(r"[ \t]*(\d+[.,]?\d*|[.,]\d+|Q[LRS]?\d+|[A-Z]+|[-+*/^()%])")
_EQUAL: Final = 1e-9
_FULL_TURN: Final = 360.0


class Numbers(Protocol):
    """Where Q parameters are looked up."""

    def read_value(self, name: str) -> float:
        """Value of Q1, QL1 or QR1; raises ProgramError (VP025) for one that has none."""


def _take_square_root(x: float) -> float:
    if x < 0:
        raise ValueError("SQRT of a negative number")
    return math.sqrt(x)


def _take_logarithm(x: float) -> float:
    if x <= 0:
        raise ValueError("LN or LOG of a number that is not positive")
    return math.log(x)


def _make_arc_function(function: Callable[[float], float]) -> Callable[[float], float]:
    def compute(x: float) -> float:
        if abs(x) > 1:
            raise ValueError("ASIN or ACOS of a number beyond 1")
        return math.degrees(function(x))

    return compute


_FUNCTIONS: Final[dict[str, Callable[[float], float]]] = {
    "SIN": lambda x: math.sin(math.radians(x)),
    "COS": lambda x: math.cos(math.radians(x)),
    "TAN": lambda x: math.tan(math.radians(x)),
    "ASIN": _make_arc_function(math.asin),
    "ACOS": _make_arc_function(math.acos),
    "ATAN": lambda x: math.degrees(math.atan(x)),
    "SQ": lambda x: x * x,
    "SQRT": _take_square_root,
    "ABS": abs,
    "INT": lambda x: float(math.trunc(x)),
    "FRAC": lambda x: x - math.trunc(x),
    "NEG": lambda x: -x,
    "LN": _take_logarithm,
    "LOG": lambda x: _take_logarithm(x) / math.log(10.0),
    "EXP": math.exp,
    "SGN": lambda x: float((x > 0) - (x < 0)),
}


def read_value(text: str, numbers: Numbers) -> float:
    """A signed number or parameter, as it stands after the letter of a word.

    Raises
    ------
    ProgramError
        VP001 for anything else, VP007 for a number beyond any machine.
    """
    text = text.strip()
    sign = -1.0 if text.startswith("-") else 1.0
    body = text.lstrip("+-").strip()
    with locate_errors(1 + len(text) - len(body)):
        return sign * (numbers.read_value(body) if body.startswith("Q") else _number(body))


def _number(text: str) -> float:
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        raise ProgramError("VP001", f"{text[:20]!r} is not a number") from None
    if not abs(value) <= MAX_NUMBER:
        raise ProgramError("VP007", f"{text[:20]} is beyond any machine")
    return value


def evaluate(text: str, numbers: Numbers) -> float:
    """The value of a formula: ``Q2 + 3 * SIN Q4``.

    Raises
    ------
    ProgramError
        VP001 for what is no formula, VP007 for a value that does not exist, VP025 for a parameter without a value. Its
        column is that of the formula.
    """
    formula = _Formula(text, numbers)
    try:
        value = formula.sum(0)
        if formula.at < len(formula.tokens):
            formula.at += 1
            raise ProgramError("VP001", f"{formula.tokens[formula.at - 1]!r} in a formula; expected an operator")
    except OverflowError:
        raise ProgramError("VP007", f"{text.strip()[:60]}: the value is beyond any machine") from None
    except (ValueError, ZeroDivisionError) as error:
        raise ProgramError("VP007", f"{text.strip()[:60]}: {error}") from None
    except ProgramError as error:
        if error.column is None and formula.columns:
            error.column = formula.columns[formula.at - 1]
        raise
    if isinstance(value, complex) or not abs(value) <= MAX_NUMBER:
        raise ProgramError("VP007", f"{text.strip()[:60]}: the value is beyond any machine")
    return float(value)


class _Formula:
    """Reads a formula from left to right: functions and powers first, then products, then sums."""

    def __init__(self, text: str, numbers: Numbers) -> None:
        self.numbers, self.at = numbers, 0
        self.tokens: list[str] = []
        self.columns: list[int] = []  #: Of the tokens, from 1.
        place = 0
        self.text = text = text.rstrip()
        while place < len(text):
            match = _TOKEN.match(text, place)
            if match is None:
                at = place + len(text[place:]) - len(text[place:].lstrip())
                raise ProgramError("VP001", f"{text[at:][:10]!r} in a formula", at + 1)
            self.tokens.append(match.group(1))
            self.columns.append(match.start(1) + 1)
            place = match.end()

    def _take(self, *symbols: str) -> str | None:
        if self.at < len(self.tokens) and self.tokens[self.at] in symbols:
            self.at += 1
            return self.tokens[self.at - 1]
        return None

    def sum(self, depth: int) -> float:
        """Terms with + and -."""
        if depth > MAX_NESTING:
            raise ProgramError("VP001", f"more than {MAX_NESTING} nested brackets and functions")
        value = self._read_product(depth)
        while (operator := self._take("+", "-")) is not None:
            term = self._read_product(depth)
            value = value + term if operator == "+" else value - term
        return value

    def _read_product(self, depth: int) -> float:
        value = self._raise_to_power(depth)
        while (operator := self._take("*", "/", "%")) is not None:
            factor = self._raise_to_power(depth)
            if operator != "*" and factor == 0:
                raise ProgramError("VP007", "a division by zero")
            value = (
                value * factor if operator == "*" else value / factor if operator == "/" else math.fmod(value, factor)
            )
        return value

    def _raise_to_power(self, depth: int) -> float:
        value = self._read_operand(depth + 1)
        while self._take("^") is not None:
            result = value ** self._read_operand(depth + 1)
            if isinstance(result, complex):
                raise ProgramError("VP007", f"{value:g} has no real power of this exponent")
            value = result
        return value

    def _read_operand(self, depth: int) -> float:
        if depth > MAX_NESTING:
            raise ProgramError("VP001", f"more than {MAX_NESTING} nested brackets and functions")
        if (sign := self._take("+", "-")) is not None:
            value = self._read_operand(depth + 1)
            return -value if sign == "-" else value
        if self.at == len(self.tokens):
            raise ProgramError("VP001", "the formula ends; expected a value")
        token, column = self.tokens[self.at], self.columns[self.at]
        self.at += 1
        if token == "(":
            value = self.sum(depth + 1)
            if self._take(")") is None:
                open_text = self.text[column - 1 :]
                edits = (Remedy("write )", f"{open_text})", misspelt=open_text, is_choice=True),)
                raise ProgramError("VP001", "a bracket of the formula is not closed; write )", column, edits=edits)
            return value
        if token == "PI":
            return math.pi
        if token in _FUNCTIONS:
            return _FUNCTIONS[token](self._read_operand(depth + 1))
        if token.startswith("Q") and token[-1].isdigit():
            return self.numbers.read_value(token)
        if token[0].isdigit() or token[0] in ".,":
            return _number(token)
        near = find_meant(token, (*_FUNCTIONS, "PI"), slip_alone=True, least=LETTERS_OF_FUNCTIONS)
        text = f"{token!r} is not a value or a function of a formula"
        if near:
            text = f"{token}: no function of this name; did you mean {near}?"
        raise ProgramError("VP001", text, column)


def combine(function: int, first: float, second: float) -> float:
    """FN 1 to 8 and 13: the result of the function for its operands; 5 to 7 take one."""
    if function == 4 and second == 0:
        raise ProgramError("VP007", "FN 4: a division by zero")
    if function == 5:
        if first < 0:
            raise ProgramError("VP007", "FN 5: the square root of a negative number")
        return math.sqrt(first)
    if function == 13:
        return math.degrees(math.atan2(first, second)) % _FULL_TURN
    return {
        1: lambda: first + second,
        2: lambda: first - second,
        3: lambda: first * second,
        4: lambda: first / second,
        6: lambda: math.sin(math.radians(first)),
        7: lambda: math.cos(math.radians(first)),
        8: lambda: math.hypot(first, second),
    }[function]()


def holds(relation: str, first: float, second: float) -> bool:
    """The condition of FN 9 to 12: EQU, NE, GT, LT."""
    same = abs(first - second) <= _EQUAL
    return {"EQU": same, "NE": not same, "GT": first > second and not same, "LT": first < second and not same}[relation]
