"""A place in one line of a Siemens program: blanks, numbers, names and texts, each with its column."""

import re
from typing import Final

from msgspec import Struct

from verne_post.gcode.expressions import MAX_NUMBER
from verne_post.gcode.program_error import ProgramError, close_here
from verne_post.model.findings import Remedy

#: A number as it is written, with EX for a power of ten.
NUMBER: Final = re.compile(r"([0-9]+\.?[0-9]*|\.[0-9]+)(?:EX([+-]?[0-9]+))?", re.IGNORECASE)
#: A name: of a word, a variable, a label or a subprogram.
NAME: Final = re.compile(r"[A-Za-z_$][A-Za-z0-9_]*")
_BLANKS: Final = " \t\r"
#: Values in other bases: 'HFF', 'B1010'.
_BASED_NUMBER: Final = re.compile(r"'(?:H([0-9A-F]+)|B([01]+))'", re.IGNORECASE)
#: Digits of such a value: no control has longer ones.
_MOST_DIGITS: Final = 64


def strip_zeros(digits: str) -> str:
    """A whole number as it is compared: without leading zeros, of any length."""
    return digits.lstrip("0") or "0"


class Cursor(Struct):
    """A line without its comment, and the next character to read."""

    text: str
    at: int = 0

    def skip(self) -> str:
        """Pass blanks; the next character, or an empty text at the end."""
        symbol = self.text[self.at : self.at + 1]
        while symbol and symbol in _BLANKS:
            self.at += 1
            symbol = self.text[self.at : self.at + 1]
        return symbol

    def error(self, code: str, message: str, at: int | None = None, edits: tuple[Remedy, ...] = ()) -> ProgramError:
        """An error at a character (None: the next one)."""
        return ProgramError(code, message, (self.at if at is None else at) + 1, edits=edits)

    def take(self, symbol: str) -> bool:
        """Pass a symbol if it comes next."""
        if self.skip() != symbol and not self.text.startswith(symbol, self.at):
            return False
        self.at += len(symbol)
        return True

    def expect(self, symbol: str, why: str) -> None:
        """Pass a symbol that must come next."""
        if not self.take(symbol):
            shown_text = self.text[self.at : self.at + 1]
            closing = next((one for one in ")]" if symbol == one or why.startswith(f"or '{one}'")), "")
            is_over = not shown_text or shown_text.isalpha()
            raise self.error(
                "VP001",
                f"expected '{symbol}' {why}, found {repr(shown_text) if shown_text else 'the end of the line'}",
                edits=close_here(closing) if closing and is_over else (),
            )

    def name(self) -> str | None:
        """Pass a name, in upper case; None where none comes next."""
        self.skip()
        match = NAME.match(self.text, self.at)
        if match is None:
            return None
        self.at = match.end()
        return match.group().upper()

    def peek_name(self) -> str | None:
        """The name that comes next, in upper case, without passing it."""
        self.skip()
        match = NAME.match(self.text, self.at)
        return None if match is None else match.group().upper()

    def number(self) -> float | None:
        """Pass a number without a sign; None where none comes next."""
        begin = self.at
        match = NUMBER.match(self.text, begin)
        if match is None:
            based_number = _BASED_NUMBER.match(self.text, begin)
            if based_number is None:
                return None
            if len(based_number.group()) > _MOST_DIGITS:
                raise self.error(
                    "VP007", f"{based_number.group()[:12]}: a number has no more than {_MOST_DIGITS} digits", begin
                )
            self.at = based_number.end()
            return self.check_size(
                float(int(based_number[1], 16) if based_number[1] else int(based_number[2], 2)), begin
            )
        self.at = match.end()
        if self.text[self.at : self.at + 1] == ".":
            raise self.error("VP001", f"{match.group()}.: a number has one point")
        return self.check_size(float(match[1] if match[2] is None else f"{match[1]}E{match[2]}"), begin)

    def read_string(self) -> str | None:
        """Pass a text in double quotes; None where none comes next."""
        if self.text[self.at : self.at + 1] != '"':
            return None
        end = self.text.find('"', self.at + 1)
        if end < 0:
            raise self.error("VP001", 'the text is not closed on its line; expected "')
        value, self.at = self.text[self.at + 1 : end], end + 1
        return value

    def check_size(self, value: float, at: int) -> float:
        """The value, unless it is beyond any machine."""
        if not abs(value) <= MAX_NUMBER:
            raise self.error("VP007", "the number is beyond any machine", at)
        return value

    @property
    def is_at_end(self) -> bool:
        """True where nothing but blanks is left."""
        return self.skip() == ""
