"""Lines of Fanuc programs in the words of RS274/NGC: program numbers, deleted blocks, comments; and where a listing ends."""

import re
from typing import Final

from verne_post.base.long_text import Text
from verne_post.gcode.block import strip_comments
from verne_post.gcode.expressions import ValueReader, Values

#: At the beginning of a line: ``:1000`` for O1000, ``/2`` for a block that switch 2 deletes.
_COLON: Final = re.compile(r"[ \t]*(:)[ \t]*[0-9]")
_DELETE: Final = re.compile(r"[ \t]*/([1-9])[ \t]*[^ \t0-9.]")
#: A comment with others in it, and the parentheses that are left after its first end.
NESTED: Final = re.compile(r"\(([^()]*\([^)]*)\)((?:[ \t]*\))*)")
_BLANK: Final = str.maketrans("()", "  ")
#: A program number with words beside it.
_NUMBER_AND_WORDS: Final = re.compile(
    r"([ \t]*(?:N[ \t]*\d+[ \t]*)?O[ \t]*\d[ \t\d]*)(?=(?:\([^()]*\)|[ \t])*(?:[A-NP-Z#/][^A-Z]*[-+.\d#\[]))",
    re.IGNORECASE,
)
#: Lines without a program number or an end, up to a ``%`` before a program number.
_LISTING: Final = re.compile(
    rb"(?:(?![ \t]*[O:][ \t]*\d|[ \t]*%|[^\n]*\bM0*(?:2|30|99)\b)[^\n]*\n)*(?=[ \t]*%[^\n]*\n\s*[O:][ \t]*\d)",
    re.IGNORECASE,
)


def prepare_line(text: str) -> str:
    """``:1000`` is O1000, ``/2`` is ``/``, ``(a (b))`` is one comment; every character keeps its column."""
    end = text.rfind(")") + 1  # after it every parenthesis would be tried up to the end of the line
    if end:
        closed = NESTED.sub(lambda match: f"({match[1].translate(_BLANK)}){match[2].translate(_BLANK)}", text[:end])
        text = closed + text[end:]
    for pattern, letter in ((_COLON, "O"), (_DELETE, " ")):
        if (match := pattern.match(text)) is not None:
            text = f"{text[: match.start(1)]}{letter}{text[match.end(1) :]}"
    return text


def end_of_number(text: str) -> int:
    """Where the program number of a prepared line ends that has words beside it; 0 where there is none."""
    match = _NUMBER_AND_WORDS.match(text)
    return 0 if match is None else match.end(1)


def find_program(source: Text) -> int:
    """Where the program begins behind what a listing prints before it: at the ``%`` before the first program number."""
    match = _LISTING.match(source[: 1 << 16])
    return 0 if match is None or not match.group().strip() else match.end()


def read_corner(text: str, values: Values) -> tuple[str, tuple[str, float] | None]:
    """A line without its corner (``,R5`` or ``,C2``), and letter and size of that; None where there is none."""
    characters, places, _comment = strip_comments(text)
    at = characters.find(",")
    letter = characters[at + 1 : at + 2]
    if at < 0 or letter not in ("R", "C"):
        return text, None
    reader = ValueReader(characters, places, values)
    reader.at = at + 2
    size = reader.read_word(letter)
    if not size > 0:
        raise reader.error("VP007", f",{letter}{size:g}: the size of a corner is greater than 0", at)
    begin, end = places[at], places[reader.at]
    return text[:begin] + " " * (end - begin) + text[end:], (letter, size)
