"""One block read exactly: the reader for every line that is not plain, and the judge of its errors.

Blanks may stand anywhere outside comments, letter case means nothing, a number is an optional sign,
digits and at most one point; there is no exponent.
"""

from dataclasses import dataclass, field
from typing import Final

#: Numbers beyond this mean nothing in any word, and would overflow somewhere.
MAX_NUMBER: Final = 1e30
_DIGITS: Final = "0123456789"
_BLANKS: Final = " \t\r"
#: Letters that may start a word, in addition to N (first only) and O (a program number, alone).
WORD_LETTERS: Final = "ABCDEFGHIJKLMPQRSTUVWXYZ"


class BlockError(Exception):
    """A block that cannot be used: finding code, sentence, 1-based column (None: the whole block)."""

    def __init__(self, code: str, message: str, column: int | None = None) -> None:
        super().__init__(message)
        self.code, self.message, self.column = code, message, column


@dataclass
class Block:
    """The words of one block.

    ``codes`` are G and M words as ("G", number, column); ``words`` maps other letters to numbers.
    """

    line: int
    codes: list[tuple[str, float, int]] = field(default_factory=list)
    words: dict[str, float] = field(default_factory=dict)
    columns: dict[str, int] = field(default_factory=dict)
    comment: str | None = None
    program_number: bool = False


def read_block(text: str, line: int) -> Block:
    """Read one line.

    Parameters
    ----------
    text : str
        The line without its line end.
    line : int
        1-based line number.

    Raises
    ------
    BlockError
        With the column of the first character that does not fit.
    """
    block = Block(line)
    at, first, slash = 0, True, False
    while True:
        at = _skip_blanks(text, at)
        if at == len(text):
            return block
        character = text[at].upper() if text[at].isascii() else text[at]
        if character == "/" and first and not slash:
            slash = True
            at += 1
            continue
        if character in "(;":
            comment, at = _comment(text, at)
            if character == "(":  # only these can be messages, and only the last one
                block.comment = comment
            continue
        column = at + 1
        if character == "N" and first:
            number, at = _number(text, at + 1, "N")
            if number < 0:
                raise BlockError("VP007", f"N{number:g}: a block number is not negative", column)
        elif character == "O" and first:
            behind = _skip_blanks(text, at + 1)
            if text[behind : behind + 1] == "<":
                raise BlockError(
                    "VP002", "O words (sub, call, if, while ...) are not supported by this version", column
                )
            number, at = _number(text, at + 1, "O")
            block.program_number = True
        elif character in WORD_LETTERS:
            number, at = _number(text, at + 1, character)
            if character in "GM":
                block.codes.append((character, number, column))
            elif character in block.words:
                raise BlockError("VP004", f"{character} stands twice in the block", column)
            else:
                block.words[character] = number
                block.columns[character] = column
        else:
            raise BlockError("VP001", _strange(character, first), column)
        first = False
        if block.program_number and _skip_blanks(text, at) < len(text) and text[_skip_blanks(text, at)] not in "(;":
            raise BlockError(
                "VP002",
                "O words (sub, call, if, while ...) are not supported by this version; only a comment may follow a program number",
                _skip_blanks(text, at) + 1,
            )


def _strange(character: str, first: bool) -> str:
    if character == "N":
        return "N must be the first word of a block"
    if character == "O":
        return "O must be the first word of a block"
    if character in "#[":
        return f"'{character}': parameters and expressions are not supported by this version"
    if character in "@^$":
        return f"'{character}': words of this kind are not supported by this version"
    if character in _DIGITS + "+-.":
        return f"'{character}': a number without a letter before it"
    if character == "/" and not first:
        return "'/' may only be the first character of a block"
    if character == "%":
        return "'%' must stand alone on its line"
    return f"{character!r} does not begin a word; expected a letter and a number"


def _skip_blanks(text: str, at: int) -> int:
    while at < len(text) and text[at] in _BLANKS:
        at += 1
    return at


def _comment(text: str, at: int) -> tuple[str, int]:
    """Text of the comment that begins at ``at``, and where reading goes on."""
    if text[at] == ";":
        return text[at + 1 :].rstrip("\r"), len(text)
    for end in range(at + 1, len(text)):
        if text[end] == "(":
            raise BlockError("VP001", "'(' inside a comment: comments do not nest", end + 1)
        if text[end] == ")":
            return text[at + 1 : end], end + 1
    raise BlockError("VP001", "the comment is not closed on its line; expected ')'", at + 1)


def _number(text: str, at: int, letter: str) -> tuple[float, int]:
    """The number behind a letter: (value, where reading goes on)."""
    digits: list[str] = []
    place = at
    seen_digit = False
    while place < len(text):
        character = text[place]
        if character in _BLANKS:
            pass
        elif character in _DIGITS:
            digits.append(character)
            seen_digit = True
        elif (character in "+-" and not digits) or (character == "." and "." not in digits):
            digits.append(character)
        elif character in "+-.":
            raise BlockError("VP001", f"{letter}{''.join(digits)}{character}: not a number", place + 1)
        else:
            break
        place += 1
    if not seen_digit:
        found = f"'{text[place]}'" if place < len(text) else "the end of the line"
        if place < len(text) and text[place] in "#[":
            found = f"'{text[place]}' (parameters and expressions are not supported by this version)"
        raise BlockError("VP001", f"{letter} needs a number, found {found}", min(place, len(text)) + 1)
    value = float("".join(digits))
    if abs(value) > MAX_NUMBER:
        raise BlockError("VP007", f"{letter}{''.join(digits)[:20]}: the number is beyond any machine", at)
    return value, place
