"""Values of a block: numbers, parameters, expressions, functions. LinuxCNC's rules, without clamping.

The reader works on a line from which blanks and comments are gone; it knows the place of every
character, so that an error names the column of the line as it was written.
"""

import math
import re
from collections.abc import Callable, Sequence
from operator import ne
from typing import Final, Protocol

from verne_post.base.numbers import round_half_away
from verne_post.base.suggestions import LETTERS_OF_FUNCTIONS, MAY_BE_MEANT, find_meant, has_one_more
from verne_post.base.tolerances import EQUAL_NUMBERS, WHOLE_NUMBER
from verne_post.gcode.program_error import ProgramError, close_here, write_words
from verne_post.model.findings import Remedy

#: Numbers beyond this mean nothing in any word, and would overflow somewhere.
MAX_NUMBER: Final = 1e30
#: Brackets and ``#`` inside each other: no program written by hand or by a post comes near.
MAX_NESTING: Final = 50

_NUMBER: Final = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)")
_NAME: Final = re.compile(r"<([^<>]*)>")
#: A name with a < or > that is there twice, lacks, or stands on the wrong side.
_MISTYPED_NAME: Final = re.compile(r"<+>?([A-Z_][A-Z\d_]*)(?:>*|(?=[\]=*/+-]))", re.IGNORECASE)
_OPEN_NAME: Final = re.compile(r"([A-Z_][A-Z\d_]*)>", re.IGNORECASE)
_NAME_AND_SIGN: Final = re.compile(r"<#([A-Z_][A-Z\d_]*)>", re.IGNORECASE)
_LETTERS: Final = re.compile(r"[A-Z]+")
#: Where a value ends: at the next word, or with the line.
_DIGITS: Final = re.compile(r"[\d.]*")
#: A value without its brackets.
_CLOSED_NUMBER: Final = re.compile(r"\[([-+]?[\d.]+)\]$")
#: What a ] closes whose [ is lost.
_OPEN_LOST: Final = re.compile(r"[^\[\](]{1,40}\]")
_OPERAND: Final = re.compile(r"-?(?:[\d.]+|#(?:\d+|<[^<>]*>))(?=[\[(]|$)")
_IS_OVER: Final = re.compile(r"[A-Z(]|$")
OPERATOR: Final = re.compile(r"\*\*|[*/+-]|MOD|EQ|NE|GT|GE|LT|LE|AND|OR|XOR")
PRECEDENCE: Final = {
    "**": 5, "*": 4, "/": 4, "MOD": 4, "+": 3, "-": 3,
    **dict.fromkeys(("EQ", "NE", "GT", "GE", "LT", "LE"), 2),
    **dict.fromkeys(("AND", "OR", "XOR"), 1),
}  # fmt: skip
#: A number parameter by its index, a named one by its name (lower case, without blanks).
Key = int | str


class Values(Protocol):
    """Where parameters are looked up, and how the language rounds."""

    @property
    def custom_macro(self) -> bool:
        """Fanuc's rules: other ranges and signs of functions and MOD, and no brackets after ``=``."""

    def find_steps_of_word(self, letter: str) -> int | None:
        """Fanuc's rules: the steps of a unit to which ROUND rounds in a letter's word; None where controls differ."""

    def read_value(self, key: Key) -> float:
        """Value of a parameter, NaN for a vacant variable of Fanuc; raises ProgramError (VP025) without a value."""

    def pass_word(self, letter: str) -> None:
        """Fanuc's rules: the word of a letter has a vacant variable, and is passed over."""

    def exists(self, key: Key) -> bool:
        """True for a named parameter that has a value, and for a number that parameters have."""


def show_key(key: Key) -> str:
    """A parameter as it is written."""
    return f"#<{key}>" if isinstance(key, str) else f"#{key}"


class ValueReader:
    """Reads values one after the other from a line.

    Attributes
    ----------
    characters : str
        The line in upper case, without blanks; a comment is one ``(``.
    places : sequence of int
        0-based place of each character in the line as it was written, and of the line's end.
    values : Values or None
        None where parameters mean nothing (tool tables).
    at : int
        Next character to read.
    """

    def __init__(self, characters: str, places: Sequence[int], values: Values | None) -> None:
        self.characters, self.places, self.values = characters, places, values
        self.at = 0
        self._depth = 0
        #: Operators of the expression at hand, in the bracket at hand.
        self._operators: set[str] = set()
        #: Steps of a unit to which ROUND rounds at this place; None where that is not known.
        self._steps: int | None = 1

    @property
    def _is_macro(self) -> bool:
        return self.values is not None and self.values.custom_macro

    def find_column(self, at: int) -> int:
        """1-based column of a character."""
        return self.places[min(at, len(self.places) - 1)] + 1

    def error(self, code: str, message: str, at: int, edits: tuple[Remedy, ...] = ()) -> ProgramError:
        """An error at a character."""
        return ProgramError(code, message, self.find_column(at), edits=edits)

    def read_word(self, letter: str, bound: float = MAX_NUMBER) -> float:
        """The value after a letter: as :meth:`read_value`, within bounds, and no second sign or point behind it."""
        begin = self.at
        if (match := _NUMBER.match(self.characters, begin)) is not None:
            end = match.end()
            if self.characters[end : end + 1] in ("+", "-", "."):
                raise self.error("VP001", f"{letter}{self.characters[begin : end + 1]}: not a number", end)
        if self._is_macro:
            assert self.values is not None
            self._steps = self.values.find_steps_of_word(letter)
        value = self.read_value(letter)
        self._steps = 1
        if math.isnan(value):
            assert self.values is not None
            self.values.pass_word(letter)
        if abs(value) > bound:
            raise self.error("VP007", f"{letter}{value:g}: the number is beyond any machine", begin)
        return value

    def read_value(self, owner: str) -> float:
        """A number, parameter, bracket or function; ``owner`` is what needs it, for messages."""
        characters, begin = self.characters, self.at
        if (match := _NUMBER.match(characters, begin)) is not None:
            self.at = match.end()
            return self._require_finite(float(match.group()), begin)
        first = characters[begin : begin + 1]
        if first == "[":
            return self._require_finite(self.read_bracket(), begin)
        if first == "#":
            return self._read_parameter()
        if first in ("+", "-") and first and re.match(r"[#\[A-Z]", characters[begin + 1 :]):
            self.at += 1
            value = self.read_value(owner)
            return -value if first == "-" else value
        if first and (match := _LETTERS.match(characters, begin)) is not None:
            names = MACRO_LONGEST_FIRST if self._is_macro else FUNCTIONS_LONGEST_FIRST
            word, is_called = match.group(), characters[match.end() : match.end() + 1] == "["
            is_unknown = is_called and word not in names
            if is_unknown and (near := find_meant(word, names, slip_alone=True, least=LETTERS_OF_FUNCTIONS)):
                raise self.error("VP001", f"{word}: no function of this name; did you mean {near}?", begin)
            name = next((name for name in names if word.startswith(name)), None)
            if name is not None:
                self.at += len(name)
                return self._require_finite(self._read_function(SHORT_NAMES.get(name, name), begin), begin)
        alike = _WITH_DIGITS.match(self.characters, begin)
        name = "" if alike is None else alike[1].translate(_MEANT_LETTERS)
        if alike is not None and name in FUNCTIONS_LONGEST_FIRST:
            raise self.error("VP001", f"{alike[1]}: a digit in place of a letter; did you mean {name}?", begin)
        if (name_match := _NAME_AND_SIGN.match(characters, begin)) is not None:
            right = f"#<{name_match[1]}>".lower()
            wrong = name_match[0].lower()
            raise self.error("VP001", f"{wrong}: the # stands before the <; did you mean {right}?", begin)
        shown_text = f"'{first}'" if first and first != "(" else "a comment" if first else "the end of the line"
        is_word_next = first.isalpha() and characters[begin - 1 : begin] == owner
        raise self.error("VP001", f"{owner} needs a number, found {shown_text}", begin - is_word_next)

    def read_assigned(self, owner: str) -> float:
        """The value after ``=``."""
        self._operators = set()
        return self._read_binary(1) if self._is_macro else self.read_word(owner, math.inf)

    def find_number_behind_blank(self, begin: int) -> int:
        """The character before which a blank divides the digits from ``begin`` on; 0 where none does."""
        digits = range(begin + 1, begin + len(_DIGITS.match(self.characters, begin)[0]))  # type: ignore[index]
        return next((at for at in digits if self.places[at] > self.places[at - 1] + 1), 0)

    def read_bracket(self, owner: str = "") -> float:
        """An expression in brackets; ``owner`` is what needs it, for messages."""
        begin = self.at
        if self.characters[begin : begin + 1] != "[":
            text, edits = "expected '['", tuple[Remedy, ...]()
            if self.characters[begin : begin + 1] == "]":
                text, edits = NO_OPENING_BRACKET, TAKE_BRACKET
            elif owner and (match := _OPERAND.match(self.characters, begin)) is not None:
                operand = self.characters[begin : self.find_number_behind_blank(begin) or match.end()]
                closed_number = _CLOSED_NUMBER.search(self.characters[:begin])
                if closed_number is not None and self.places[begin] == self.places[begin - 1] + 1:
                    right = f"[{closed_number[1]}{operand}]"
                    text = f"{closed_number[0]}{operand}: the ] is too far left; did you mean {right}?"
                    raise self.error("VP001", text, closed_number.start())
                right = f"[{operand}]"
                text = f"{operand}: values of {owner} are written in brackets; did you mean {right}?"
            elif owner:
                text = f"{owner} needs its value, in brackets: {owner} [...]"
            if not edits and (match := _OPEN_LOST.match(self.characters, begin)):
                text = f"{match[0]}: the bracket before it is missing"
                edits = write_words(match[0][0], f"[{match[0][0]}")
            raise self.error("VP001", text, begin, edits)
        value = self._read_until("]", begin)
        self.at += 1
        return value

    def _read_until(self, ends: str, begin: int) -> float:
        """The expression after the character at ``at``, up to one that ends it."""
        self._enter_bracket(begin)
        self.at += 1
        outside, self._operators = self._operators, set()
        value = self._read_binary(1)
        self._operators = outside
        if self.characters[self.at : self.at + 1] not in tuple(ends):
            text = f"expected an operator or {' or '.join(map(repr, ends))}"
            if (sign := _SIGN.match(self.characters, self.at)) is not None:
                text = f"{sign[0]}: no operator here; did you mean {_COMPARISONS[sign[0]]}?"
            if (word := _LETTERS.match(self.characters, self.at)) is not None:
                near = find_operator(word[0])
                beside = [one for one in _COMPARING if len(word[0]) == len(one) and sum(map(ne, one, word[0])) == 1]
                advice = f"did you mean {near}?" if near else f"operators are {', '.join(_WORDS)} and + - * / **"
                if beside and not near:
                    advice = f"{' or '.join(beside)}{MAY_BE_MEANT}"
                text = f"{word[0]}: no operator; {advice}" if len(word[0]) > 1 else text
                if not (near or beside) and len(word[0]) > 1 and _IS_OVER.match(self.characters, self.at):
                    text = f"a {ends[-1]} is missing before {word[0]}"
            edits = close_here("]") if _IS_OVER.match(self.characters, self.at) and MAY_BE_MEANT not in text else ()
            if text.endswith(MAY_BE_MEANT) and word is not None:
                edits = tuple(Remedy(f"write {one}", one, misspelt=word[0], is_choice=True) for one in beside)
            if text.startswith("expected") and self.characters[begin : begin + 2] == "[[":
                take = Remedy("take [ out", "[", misspelt="[[", is_choice=True)
                raise self.error("VP001", f"the [ is there twice, or one is not closed: {text}", begin, (take,))
            if text.startswith("expected") and (edits or self.characters[self.at : self.at + 1] == "["):
                text, edits = f"the [ before it is open: {text}", close_here("]")
            raise self.error("VP001", text, self.at, edits)
        self._depth -= 1
        return value

    def read_key(self) -> Key:
        """What follows a ``#``: an index or a name."""
        begin = self.at
        if (match := _NAME.match(self.characters, begin)) is not None:
            self.at = match.end()
            if not match.group(1):
                raise self._refuse_name(begin, "the name of a parameter is missing")
            if self.characters[self.at : self.at + 1] == ">" and not self._is_comparison():
                raise self._refuse_name(begin, "the > is there twice")
            return match.group(1).lower()
        if self.characters[begin : begin + 1] == "<":
            raise self._refuse_name(begin, "the name of a parameter is not closed; expected '>'")
        if (match := _OPEN_NAME.match(self.characters, begin)) is not None:
            wrong, right = f"#{match[0]}".lower(), f"#<{match[1]}>".lower()
            raise self.error("VP001", f"{wrong}: the < of the name is missing; did you mean {right}?", begin - 1)
        self._enter_bracket(begin)
        steps, self._steps = self._steps, 1
        value = self.read_value("#")
        self._steps = steps
        self._depth -= 1
        if math.isnan(value):
            raise self.error("VP025", "the index of a variable is itself one without a value", begin)
        index = round(value)
        if abs(value - index) > WHOLE_NUMBER:
            raise self.error("VP025", f"#{value:g}: the index of a parameter is a whole number", begin)
        return index

    def _is_comparison(self) -> bool:
        """Whether the > after a name in brackets is a comparison: a value follows; before a sign, a blank is too."""
        is_apart = self.places[self.at] > self.places[self.at - 1] + 1
        pattern = _COMPARISON if is_apart else _COMPARISON_JOINED
        return self._depth > 0 and pattern.match(self.characters, self.at) is not None

    def _refuse_name(self, begin: int, what: str) -> ProgramError:
        """The error of a name in <> after the character before ``begin``, with the name that is meant."""
        end = begin + 1
        while end < len(self.characters) and self.places[end] == self.places[end - 1] + 1:
            end += 1  # up to the next blank
        match = _MISTYPED_NAME.match(self.characters, begin, end)
        if match is None:
            return self.error("VP001", what, begin)
        if self.characters[begin : begin + 2] == "<<":
            what = "the < is there twice"
        first = self.characters[begin - 1]
        wrong, right = f"{first}{match[0]}".lower(), f"{first}<{match[1]}>".lower()
        return self.error("VP001", f"{wrong}: {what}; did you mean {right}?", begin - 1)

    def _read_parameter(self) -> float:
        begin = self.at
        if self.values is None:
            raise self.error("VP001", "'#': parameters are not possible here", begin)
        self.at += 1
        key = self.read_key()
        try:
            return self.values.read_value(key)
        except ProgramError as error:
            raise self.error(error.code, error.message, begin, error.edits).advise(error.advice) from None

    def _enter_bracket(self, begin: int) -> None:
        self._depth += 1
        if self._depth > MAX_NESTING:
            raise self.error("VP001", f"more than {MAX_NESTING} nested brackets or #", begin)

    def _require_finite(self, value: float, begin: int) -> float:
        if not math.isfinite(value) and not (self._is_macro and math.isnan(value)):
            raise self.error("VP007", "the value is not finite", begin)
        return value

    def _read_binary(self, least: int) -> float:
        left = self.read_value("an expression")
        while True:
            match = OPERATOR.match(self.characters, self.at)
            precedence = MACRO_PRECEDENCE if self._is_macro else PRECEDENCE
            if match is None or precedence[match.group()] < least:
                return left
            begin, self.at = self.at, match.end()
            self._refuse_doubled(match.group(), begin)
            right = self._read_binary(precedence[match.group()] + 1)
            left = self._require_finite(self._apply(match.group(), left, right, begin), begin)

    def _refuse_doubled(self, operator: str, begin: int) -> None:
        """Refuse (VP001) an operator of letters whose last one is there twice, as in EQQ 2."""
        word = f"{operator}{operator[-1]}"
        if operator.isalpha() and re.match(rf"{word}[\d.#\[-]", self.characters[begin:]):
            raise self.error("VP001", f"{word}: no operator; did you mean {operator}?", begin)

    def _apply(self, operator: str, left: float, right: float, begin: int) -> float:
        if self._is_macro:
            left, right = self._prepare_operands(operator, left, right, begin)
        if operator in ("/", "MOD") and right == 0:
            raise self.error("VP007", f"{left:g} {operator} {right:g}: division by zero", begin)
        if operator == "**" and left < 0 and right != int(right):
            raise self.error("VP007", f"{left:g}**{right:g}: a negative number to a power that is not whole", begin)
        if operator == "**" and left == 0 and right < 0:
            raise self.error("VP007", f"0**{right:g}: zero to a negative power", begin)
        try:
            return float((MACRO_OPERATORS if self._is_macro else OPERATORS)[operator](left, right))
        except OverflowError:
            return math.inf

    def _prepare_operands(self, operator: str, left: float, right: float, begin: int) -> tuple[float, float]:
        """Operands as custom macros take them: a vacant variable is 0 but for EQ and NE, MOD takes whole numbers."""
        self._operators.add(operator)
        if self._operators & set(_OF_BITS) and self._operators - set(_OF_BITS):
            text = f"{operator}: controls differ in the order of AND, OR, XOR and other operators; write brackets"
            raise self.error("VP002", text, begin)
        if operator in ("EQ", "NE") and (math.isnan(left) or math.isnan(right)):  # equal only to another vacant one
            return (0.0, 0.0) if math.isnan(left) and math.isnan(right) else (0.0, 1.0)
        left, right = (0.0 if math.isnan(value) else value for value in (left, right))
        if operator in _OF_BITS and not all(value >= 0 and value == round(value) < MAX_BITS for value in (left, right)):
            raise self.error(
                "VP007",
                f"{left:g} {operator} {right:g}: operands of bit operations are whole numbers from 0 to 4294967295",
                begin,
            )
        return (round_half_away(left), round_half_away(right)) if operator == "MOD" else (left, right)

    def _read_function(self, name: str, begin: int) -> float:
        if self.characters[self.at : self.at + 1] != "[":
            raise self.error("VP001", f"{name} needs its argument in brackets: {name}[...]", self.at)
        if name == "EXISTS":
            return self._exists()
        if self._is_macro:
            return self._call_macro_function(name, begin)
        argument = self.read_bracket()
        if name == "ATAN":
            if self.characters[self.at : self.at + 1] != "/":
                raise self.error("VP001", "ATAN has two arguments: ATAN[y]/[x]", self.at)
            self.at += 1
            return math.degrees(math.atan2(argument, self.read_bracket()))
        return self._call(name, argument, begin)

    def _call_macro_function(self, name: str, begin: int) -> float:
        """A function of custom macros: ATAN and POW have two arguments, a vacant variable is 0."""
        opening = self.at
        argument, other = self._read_until(",]", opening), None
        argument = 0.0 if math.isnan(argument) else argument
        if self.characters[self.at] == ",":
            other = self._read_until("]", self.at)
        self.at += 1
        if name == "ATAN" and self.characters[self.at : self.at + 2] == "/[" and other is None:
            self.at += 1
            other = self.read_bracket()
        if (other is not None and name not in ("ATAN", "POW")) or (other is None and name == "POW"):
            raise self.error("VP001", f"{name} has {'two arguments' if name == 'POW' else 'one argument'}", opening)
        if other is None:
            return math.degrees(math.atan(argument)) if name == "ATAN" else self._call(name, argument, begin)
        other = 0.0 if math.isnan(other) else other
        if name == "POW":
            return self._apply("**", argument, other, begin)
        return _turn_up(math.degrees(math.atan2(argument, other)))

    def _call(self, name: str, argument: float, begin: int) -> float:
        """A function of one argument; ROUND of custom macros rounds to the step of its word."""
        is_allowed, what = DOMAIN.get(name, (None, ""))
        if is_allowed is not None and not is_allowed(argument):
            raise self.error("VP007", f"{name}[{argument:g}]: {what}", begin)
        if name == "ROUND" and self._is_macro:
            if self._steps is None:
                raise self.error(
                    "VP002", "ROUND in this word rounds to a step that controls choose; write the number", begin
                )
            return round_half_away(argument * self._steps) / self._steps
        try:
            return float((MACRO_FUNCTIONS if self._is_macro else FUNCTIONS)[name](argument))
        except OverflowError:
            return math.inf

    def _exists(self) -> float:
        begin = self.at
        if self.values is None or not self.characters.startswith("[#", begin):
            raise self.error("VP001", "EXISTS takes a parameter: EXISTS[#<name>] or EXISTS[#1]", begin)
        self.at += 2
        key = self.read_key()
        if self.characters[self.at : self.at + 1] != "]":
            raise self.error("VP001", "EXISTS takes one parameter; expected ']'", self.at)
        self.at += 1
        return float(self.values.exists(key))


def find_operator(word: str) -> str:
    """The one operator that is a slip away from a word: a letter twice, two that changed places, or one more."""
    near = [
        one for one in _WORDS if word in (one[1] + one[0] + one[2:], one[:1] + one[:0:-1]) or has_one_more(word, one)
    ]
    return near[0] if len(near) == 1 else ""


def _turn_up(degrees: float) -> float:
    """An angle from 0 on, below 360."""
    return degrees + 360.0 if degrees < 0 else degrees


OPERATORS: Final[dict[str, Callable[[float, float], float]]] = {
    "**": lambda a, b: a**b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "MOD": lambda a, b: math.fmod(a, b) + (abs(b) if math.fmod(a, b) < 0 else 0.0),  # never negative
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "EQ": lambda a, b: abs(a - b) < EQUAL_NUMBERS,
    "NE": lambda a, b: abs(a - b) >= EQUAL_NUMBERS,
    "GT": lambda a, b: a > b,
    "GE": lambda a, b: a >= b,
    "LT": lambda a, b: a < b,
    "LE": lambda a, b: a <= b,
    "AND": lambda a, b: a != 0 and b != 0,
    "OR": lambda a, b: a != 0 or b != 0,
    "XOR": lambda a, b: (a != 0) != (b != 0),
}
FUNCTIONS: Final[dict[str, Callable[[float], float]]] = {
    "ABS": abs,
    "ACOS": lambda x: math.degrees(math.acos(x)),
    "ASIN": lambda x: math.degrees(math.asin(x)),
    "COS": lambda x: math.cos(math.radians(x)),
    "EXP": math.exp,
    "FIX": math.floor,
    "FUP": math.ceil,
    "LN": math.log,
    "ROUND": round_half_away,
    "SIN": lambda x: math.sin(math.radians(x)),
    "SQRT": math.sqrt,
    "TAN": lambda x: math.tan(math.radians(x)),
}
_OF_BITS: Final = ("AND", "OR", "XOR")
#: Numbers of bits are below this.
MAX_BITS: Final = 1 << 32
#: Custom macros: AND binds as a product, OR and XOR as sums.
MACRO_PRECEDENCE: Final = PRECEDENCE | {"AND": 4, "OR": 3, "XOR": 3}
#: Other names of functions of custom macros.
SHORT_NAMES: Final = {
    "AB": "ABS", "AC": "ACOS", "AS": "ASIN", "AT": "ATAN", "ATN": "ATAN", "BC": "BCD", "BI": "BIN", "CO": "COS",
    "EX": "EXP",
    "FI": "FIX", "FU": "FUP", "PO": "POW", "RND": "ROUND", "RO": "ROUND", "SI": "SIN", "SQ": "SQRT", "SQR": "SQRT",
    "TA": "TAN",
}  # fmt: skip
#: Fanuc's custom macros. MOD has the sign of the first number, FIX goes towards zero and FUP away from it. Angles of
#: ASIN are 270 to 360 where RS274/NGC has them below 0, and those of ATAN 0 to 360 (parameter 6004, NAT, as delivered).
MACRO_OPERATORS: Final[dict[str, Callable[[float, float], float]]] = {
    **OPERATORS,
    "MOD": math.fmod,
    "AND": lambda a, b: int(a) & int(b),
    "OR": lambda a, b: int(a) | int(b),
    "XOR": lambda a, b: int(a) ^ int(b),
}
MACRO_FUNCTIONS: Final[dict[str, Callable[[float], float]]] = FUNCTIONS | {
    "ASIN": lambda x: _turn_up(math.degrees(math.asin(x))),
    "BCD": lambda x: float(int(f"{x:.0f}", 16)),
    "BIN": lambda x: float(f"{round(x):x}"),
    "FIX": lambda x: math.floor(x) if x >= 0 else math.ceil(x),
    "FUP": lambda x: math.ceil(x) if x >= 0 else math.floor(x),
}
#: How other languages write comparisons.
_COMPARISONS: Final = {
    ">": "GT",
    "<": "LT",
    ">=": "GE",
    "<=": "LE",
    "=": "EQ",
    "==": "EQ",
    "<>": "NE",
    "!=": "NE",
}
#: The error of a bracket too many, and its edit.
NO_OPENING_BRACKET: Final = "']' without the '[' that it would close"
TAKE_BRACKET: Final = (Remedy("take ] out", "", misspelt="]"),)
#: Operators that are words.
_COMPARING: Final = ("EQ", "NE", "GT", "GE", "LT", "LE")
_WORDS: Final = (*_COMPARING, "AND", "OR", "XOR", "MOD")
#: A name of a function with digits in place of letters.
_WITH_DIGITS: Final = re.compile(r"((?=[A-Z0-9]*\d)[A-Z0-9]{2,6})\[")
_MEANT_LETTERS: Final = str.maketrans("015", "OIS")
_COMPARISON_JOINED: Final = re.compile(r">=?(?:[\d.#\[]|[A-Z]+\[)")
_COMPARISON: Final = re.compile(rf"{_COMPARISON_JOINED.pattern}|>=?[+-]")
_SIGN: Final = re.compile("<>|[<>=!]=|[<>=]")
FUNCTIONS_LONGEST_FIRST: Final = sorted([*FUNCTIONS, "ATAN", "EXISTS"], key=len, reverse=True)
MACRO_LONGEST_FIRST: Final = sorted(
    [*FUNCTIONS_LONGEST_FIRST, "BCD", "BIN", "POW", *SHORT_NAMES], key=len, reverse=True
)
DOMAIN: Final[dict[str, tuple[Callable[[float], bool], str]]] = {
    "ACOS": (lambda x: abs(x) <= 1, "the argument lies between -1 and 1"),
    "ASIN": (lambda x: abs(x) <= 1, "the argument lies between -1 and 1"),
    "BCD": (lambda x: x == math.floor(x) and 0 <= x < 1e8, "the argument is whole, from 0 to 99999999"),
    "BIN": (
        lambda x: x == math.floor(x) and 0 <= x < 1e10 and f"{int(x):x}".isdecimal(),
        "the argument is a number of decimal digits in four bits each",
    ),
    "LN": (lambda x: x > 0, "the argument is greater than zero"),
    "SQRT": (lambda x: x >= 0, "the argument is not negative"),
}
