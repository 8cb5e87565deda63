"""Lines that differ only in numbers, read by one compiled template: faster than :mod:`verne_post.gcode.block`.

A template reads what is well formed and of ordinary size. For anything else it gives nothing, and the exact reader
reads the line again and says what is wrong. Both give the same numbers to the last bit.
"""

import math
import re
from collections.abc import Callable
from typing import Final, NamedTuple

from verne_post.base.tolerances import WHOLE_NUMBER
from verne_post.gcode.expressions import (
    DOMAIN,
    FUNCTIONS,
    FUNCTIONS_LONGEST_FIRST,
    MAX_NUMBER,
    OPERATOR,
    OPERATORS,
    PRECEDENCE,
    Key,
    Values,
)
from verne_post.gcode.program_error import ProgramError

#: A value, computed from the numbers of the line and the parameters.
Node = Callable[[list[float], Values], float]

_NUMBER: Final = re.compile(r"(\d+\.?\d*|\.\d+)")
#: Comments, names, polar words and all else that only the exact reader reads; and ``?``, which is a number here.
_OTHER: Final = re.compile(r"[^\t\r A-Za-z0-9.+\-*/=#\[\]]")
_BLANKS: Final = str.maketrans("", "", " \t\r")
_LETTERS: Final = frozenset("ABCDEFGHIJKLMPQRSTUVWXYZ")
#: What Fanuc's controls compute otherwise.
_MACRO_NAMES: Final = ("ASIN", "ATAN", "FIX", "FUP", "ROUND")
#: So many templates are kept.
_MOST_KEPT: Final = 2_000
#: Digits of a number, products and quotients of a line: values from 1 / MAX_NUMBER to MAX_NUMBER never overflow.
_MAX_DIGITS, _MAX_PRODUCTS = 30, 4
#: Characters of a template, and brackets and # in it; with more a line is not one of many.
_MAX_LENGTH, _MAX_BRACKETS = 200, 40


class Words(NamedTuple):
    """The content of a line as in :class:`~verne_post.gcode.block.Block`; columns are minus the word's number."""

    codes: list[tuple[str, float, int]]
    words: dict[str, float]
    columns: dict[str, int]
    settings: list[tuple[Key, float, int]]


class _Template(NamedTuple):
    """Words of a line: letter or index, value, and minus the number of the word."""

    codes: list[tuple[str, Node, int]]
    words: list[tuple[str, Node]]
    columns: dict[str, int]
    settings: list[tuple[Node, Node, int]]


#: By what stands between the numbers of a line.
_templates: dict[tuple[str | bool, ...], _Template | None] = {}


def read_by_template(text: str, values: Values) -> Words | None:
    """The words of a line; None where only the exact reader can read it."""
    parts = _NUMBER.split(text)
    numbers = parts[1::2]
    key = (*parts[::2], values.custom_macro)
    try:
        template = _templates[key]  # one look: the hash of such a key costs a tenth of reading the line
    except KeyError:
        if len(_templates) >= _MOST_KEPT:
            _templates.clear()
        template = _templates[key] = _find_template(text, len(numbers), values.custom_macro)
    if template is None or (len(text) > _MAX_DIGITS and any(len(number) > _MAX_DIGITS for number in numbers)):
        return None
    n = list(map(float, numbers))
    try:
        words = {letter: node(n, values) for letter, node in template.words}
        codes = [(letter, node(n, values), at) for letter, node, at in template.codes]
        settings: list[tuple[Key, float, int]] = [
            (_round_index(index(n, values)), node(n, values), at) for index, node, at in template.settings
        ]
    except (ProgramError, ArithmeticError, ValueError):
        return None
    for value in words.values():
        if abs(value) > MAX_NUMBER:
            return None
    for _letter, value, _at in codes:
        if abs(value) > MAX_NUMBER:
            return None
    return Words(codes, words, template.columns.copy(), settings)


def _find_template(text: str, count: int, custom_macro: bool) -> _Template | None:
    """The template of a line with so many numbers; None where there is none, or where blanks stand inside a number."""
    if _OTHER.search(text):
        return None
    text = text.translate(_BLANKS).upper()
    return _compile(_NUMBER.sub("?", text), custom_macro) if len(_NUMBER.findall(text)) == count else None


def find_word_columns(text: str) -> list[int]:
    """1-based columns of the words and settings of a line that a template has read, or that has plain words alone."""
    columns, depth, before, comment = [], 0, "", False
    for at, character in enumerate(text.upper(), 1):
        if comment or character in "(;":
            comment = character != ")"
        elif character not in " \t\r":
            # a letter after a letter, sign or operator is that of a function, and a # there is a value
            if depth == 0 and (character in _LETTERS or character == "#") and (not before or before in "0123456789.]"):
                columns.append(at)
            depth += (character == "[") - (character == "]")
            before = character
    return columns


def find_word_column(text: str, number: int) -> int | None:
    """The column of a word whose number in its line, from -1 down, stands in place of it.

    None where the line as it is written has fewer words: a mistyped one is executed as it is meant.
    """
    columns = find_word_columns(text)
    return columns[-number - 1] if -number <= len(columns) else None


# --- compiling ----------------------------------------------------------------------------------------------


class _NoTemplateError(Exception):
    """Only the exact reader reads such a line."""


def _compile(text: str, custom_macro: bool) -> _Template | None:
    if len(text) > _MAX_LENGTH or text.count("[") + text.count("#") > _MAX_BRACKETS:
        return None
    try:
        return _Compiler(text, custom_macro).compile()
    except _NoTemplateError:
        return None


class _Compiler:
    """Reads a line whose numbers are ``?``, by the rules of :class:`~verne_post.gcode.expressions.ValueReader`."""

    def __init__(self, text: str, custom_macro: bool) -> None:
        self.text, self.custom_macro = text, custom_macro
        self.at = self.number = self.products = 0

    def compile(self) -> _Template:
        """All words of the line."""
        template, count = _Template([], [], {}, []), 0
        if self.text.startswith("N?"):
            self.at, self.number = 2, 1
            self._end_word()
        while self.at < len(self.text):
            count -= 1
            letter = self._peek()
            if letter == "#":
                index = self._index()
                if self._peek() != "=":
                    raise _NoTemplateError
                template.settings.append(
                    (index, self._compile_binary(1) if self.custom_macro else self._compile_value(), count)
                )
            elif letter in ("G", "M"):
                template.codes.append((letter, self._compile_value(), count))
            elif letter in _LETTERS and letter not in template.columns:
                template.words.append((letter, self._compile_value()))
                template.columns[letter] = count
            else:
                raise _NoTemplateError
            self._end_word()
        if self.products > _MAX_PRODUCTS:
            raise _NoTemplateError
        return template

    def _end_word(self) -> None:
        if self.text[self.at : self.at + 1] in ("?", "+", "-", "."):
            raise _NoTemplateError

    def _peek(self) -> str:
        character = self.text[self.at : self.at + 1]
        self.at += 1
        return character

    def _compile_value(self) -> Node:
        first = self._peek()
        if first == "?":
            at = self.number
            self.number += 1
            return lambda n, _values: n[at]
        if first == "[":
            node = self._compile_binary(1)
            if self._peek() != "]":
                raise _NoTemplateError
            return node
        if first == "#":
            index = self._index()
            return lambda n, values: _check_ordinary(values.read_value(_round_index(index(n, values))))
        if first in ("+", "-"):
            if self.text[self.at : self.at + 1] in ("+", "-"):
                raise _NoTemplateError
            node = self._compile_value()
            return node if first == "+" else lambda n, values: -node(n, values)
        self.at -= 1
        return self._compile_function()

    def _index(self) -> Node:
        if self.text[self.at : self.at + 1] in ("+", "-"):
            raise _NoTemplateError
        return self._compile_value()

    def _compile_function(self) -> Node:
        name = next((name for name in FUNCTIONS_LONGEST_FIRST if self.text.startswith(name, self.at)), None)
        if name is None or name == "EXISTS" or (self.custom_macro and name in _MACRO_NAMES):
            raise _NoTemplateError
        self.at += len(name)
        argument = self._bracket()
        if name == "ATAN":
            if self._peek() != "/":
                raise _NoTemplateError
            other = self._bracket()
            return lambda n, values: _check_ordinary(math.degrees(math.atan2(argument(n, values), other(n, values))))
        function, is_allowed = FUNCTIONS[name], DOMAIN.get(name, (lambda _value: True, ""))[0]

        def apply(n: list[float], values: Values) -> float:
            value = argument(n, values)
            if not is_allowed(value):
                raise ValueError
            return _check_ordinary(float(function(value)))

        return apply

    def _bracket(self) -> Node:
        if self.text[self.at : self.at + 1] != "[":
            raise _NoTemplateError
        return self._compile_value()

    def _compile_binary(self, least: int) -> Node:
        left = self._compile_value()
        while (match := OPERATOR.match(self.text, self.at)) is not None and PRECEDENCE[match.group()] >= least:
            self.at = match.end()
            left = self._join(match.group(), left, self._compile_binary(PRECEDENCE[match.group()] + 1))
        return left

    def _join(self, operator: str, left: Node, right: Node) -> Node:
        if operator == "+":
            return lambda n, values: left(n, values) + right(n, values)
        if operator == "-":
            return lambda n, values: left(n, values) - right(n, values)
        if operator in "*/":
            self.products += 1
            if operator == "*":
                return lambda n, values: left(n, values) * right(n, values)
            return lambda n, values: left(n, values) / right(n, values)
        if operator == "**" or self.custom_macro:  # letters between values might as well begin a word
            raise _NoTemplateError
        apply = OPERATORS[operator]
        return lambda n, values: float(apply(left(n, values), right(n, values)))


def _check_ordinary(value: float) -> float:
    """A value with which nothing overflows; any other is for the exact reader."""
    if value and not 1.0 / MAX_NUMBER < abs(value) < MAX_NUMBER:
        raise ValueError
    return value


def _round_index(value: float) -> int:
    index = round(value)
    if abs(value - index) > WHOLE_NUMBER:
        raise ValueError
    return index
