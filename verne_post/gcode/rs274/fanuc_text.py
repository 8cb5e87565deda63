"""Texts of Fanuc programs: how they are recognised, where a listing ends, and lines in the words of RS274/NGC."""

import math
import re
from typing import Final

from verne_post.base.long_text import Text
from verne_post.base.printable import make_printable_in_place
from verne_post.gcode.block import strip_comments
from verne_post.gcode.expressions import ValueReader, Values
from verne_post.gcode.mistyped import COMMA_BEHIND
from verne_post.gcode.program_error import ProgramError

#: At the beginning of a line: ``:1000`` for O1000, ``/2`` for a block that switch 2 deletes.
_COLON: Final = re.compile(r"[ \t]*(:)[ \t]*[0-9]")
_DELETE: Final = re.compile(r"[ \t]*/([1-9])[ \t]*[^ \t0-9.]")
#: A comment with others in it, and the parentheses that are left after its first end.
NESTED_COMMENT: Final = re.compile(r"\(([^()]*\([^)]*)\)((?:[ \t]*\))*)")
_BLANK: Final = str.maketrans("()", "  ")
#: A program number with words beside it.
_NUMBER_AND_WORDS: Final = re.compile(
    r"([ \t]*(?:N[ \t]*\d+[ \t]*)?O[ \t]*\d[ \t\d]*)(?=(?:\([^()]*\)|[ \t])*(?:[A-NP-Z#/][^A-Z]*[-+.\d#\[]))",
    re.IGNORECASE,
)
#: Slips in a program number, which stands alone or before its title.
_SLIPS_OF_NUMBER: Final = (
    (re.compile(r"[ \t]*(\d+O\d+)(?=[ \t]*(?:\(|$))", re.IGNORECASE), "a digit before its letter"),
    (re.compile(r"[ \t]*(O\d+O[\dO]*)(?=[ \t]*(?:\(|$))", re.IGNORECASE), "the letter O in a number"),
    (re.compile(r"[ \t]*(O\d+P[\dP]*)(?=[ \t]*(?:\(|$))", re.IGNORECASE), "the letter P in a number"),
)
#: Lines without a program number or an end, up to a ``%`` before a program number.
_LISTING: Final = re.compile(
    rb"(?:(?![ \t]*[O:][ \t]*\d|[ \t]*%|[^\n]*\bM0*(?:2|30|99)\b)[^\n]*\n)*(?=[ \t]*%[^\n]*\n\s*[O:][ \t]*\d)",
    re.IGNORECASE,
)
#: A word without a point, and the comma of a corner.
_WORD_BEFORE_CORNER: Final = re.compile(r"([A-Z][ \t]*[-+]?\d+),$", re.IGNORECASE)
_AXIS_BEHIND_COMMA: Final = re.compile(r",[ \t]+C[ \t]*[-+\d.]", re.IGNORECASE)
_NUMBER_WITH_O: Final = re.compile(r"[ \t/]*(N\d+O0*)(?!\w)", re.IGNORECASE)
#: Lines that are looked at.
_HEADER_LINES: Final = 200
#: ``%``, for which another key may stand, and a program number, which may lack its O or have another key in its place,
#: or such a number alone in its line.
_OPENING: Final = re.compile(
    rb"\s*(?:(?:%[^\n]*|[^\s(;/NGMTXYZO][ \t\r]*)\n\s*){1,2}(?:\([^()\n]*\)\s*\n\s*){0,9}"
    rb"(?:(?:(?:[OIKLP]{1,2}|[0-9]O)?[0-9 \t]+|O[ \t]*)(?=\(|\r?\n)"
    rb"|[O:]\s*[0-9]++(?![ \t]*(?:SUB|CALL|IF|WHILE|DO|REPEAT)))|"
    rb"\s*O[ \t]*[0-9]++[ \t\r]*(?:\([^\n]*)?(?:\n|$)",
    re.IGNORECASE,
)
#: Text after ``%``, or ``:1000`` after such a line.
_TITLE: Final = re.compile(rb"\s*%(?!_N_|[^\n]*_[MS]PF)[ \t]*[^ \t\r\n][^\r\n]*|\s*(?:%[^\n]*\n\s*)?:[0-9]+")
_PROGRAM_NUMBER: Final = re.compile(
    rb"^[ \t]*(?:(?:[OIKLP:]{1,2}|[0-9]O)\s*[0-9]*|[0-9]+)", re.IGNORECASE | re.MULTILINE
)
#: Letters of such words that a message shows.
_SHOWN_LETTERS: Final = 20
#: Beside a header these outweigh words of RS274/NGC.
_OWN_CODES: Final = re.compile(
    rb"(?<![A-Z])G0*(?:68\.2|53\.1|54\.1|5\.1|69|8(?=\s*P)|6\.2)(?![0-9.])|(?<![A-Z])M98\s*P[0-9]{5,}",
    re.IGNORECASE,
)
#: These need no header, where no word of RS274/NGC is beside them: calls of macros, and look-ahead modes.
_FANUC_ONLY: Final = re.compile(
    rb"(?<![A-Z])G0*(?:6[56][ \t]*P[0-9]|5\.1[ \t]*Q[01]|[58][ \t]*P[0-9]+[ \t\r]*(?:[(;\n]|$))", re.IGNORECASE
)
#: Of these, which RS274/NGC does not have, several need no header: its line may be lost.
_UNKNOWN_CODES: Final = re.compile(rb"(?<![A-Z])G0*(?:68\.2|53\.1|54\.1|69)(?![0-9.])", re.IGNORECASE)
_ENOUGH_CODES: Final = 2
#: G43.4 and G43.5, which RS274/NGC has here too, outweigh its words as those do, but not its G64 P.
_SHARED_CODES: Final = re.compile(rb"(?<![A-Z])G0*43\.[45](?![0-9.])", re.IGNORECASE)
#: A path tolerance: G64 of Fanuc has no words.
_TOLERANCE: Final = re.compile(rb"(?<![A-Z])G0*64[ \t]*[PQ]", re.IGNORECASE)
#: What only RS274/NGC has: such a text is not Fanuc's, whatever its header. G41.1 is Fanuc's too, with another meaning:
#: refused as Fanuc's, where RS274/NGC takes D1 for a diameter of 1 mm.
_OTHER_CODES: Final = re.compile(
    rb"#<|(?<![A-Z])O\s*(?:<|[0-9]+[ \t]*(?:SUB|CALL|IF|WHILE|DO|REPEAT))|\((?:MSG|DEBUG|PRINT|ABORT),|"
    + _TOLERANCE.pattern
    + rb"|(?<![A-Z])G0*(?:43\.2|43\.1(?![^\n]*H)|59\.[123]|61\.1|92\.[23]|9[01]\.1|5\.[23])(?![0-9.])",
    re.IGNORECASE,
)
#: G10 L20, and G54.1.
_HERE: Final = re.compile(rb"(?<![A-Z])L[ \t]*20(?![0-9.])", re.IGNORECASE)
_ADDITIONAL_CODE: Final = re.compile(rb"(?<![A-Z])G0*54\.1", re.IGNORECASE)


def find_sign(begin: bytes) -> str:
    """The words for which a text is Fanuc's; empty where none are, or where others are RS274/NGC's alone.

    They are text after ``%``, an O number with it or alone, or calls of macros and look-ahead modes. ``begin`` is how
    the program begins, behind what a listing prints before it.
    """
    head = b"\n".join(begin.split(b"\n")[:_HEADER_LINES])
    if match := _TITLE.match(head):
        return _show(match.group())
    without_comments = re.sub(rb"\([^)\n]*(?:\)|$)", b"", head, flags=re.MULTILINE)
    opening = _OPENING.match(head)
    if opening is None:
        own = _FANUC_ONLY.search(without_comments)
        if own is None and len(codes := list(_UNKNOWN_CODES.finditer(without_comments))) >= _ENOUGH_CODES:
            own = codes[0]
        return "" if own is None or _OTHER_CODES.search(head) else _show(own.group())
    if _HERE.search(without_comments) and not _ADDITIONAL_CODE.search(without_comments):
        return ""  # G10 L20 is an origin of G54.1 there, and the present place in RS274/NGC
    # read as Fanuc's, an RS274 text is refused or stays higher; the other way it would dwell for minutes
    outweighs = _OWN_CODES.search(without_comments) or (
        _SHARED_CODES.search(without_comments) and not _TOLERANCE.search(without_comments)
    )
    number = _PROGRAM_NUMBER.search(opening.group())
    return _show(number.group()) if number and (outweighs or not _OTHER_CODES.search(head)) else ""


def _show(words: bytes) -> str:
    return make_printable_in_place(words.decode("latin-1").strip())[:_SHOWN_LETTERS]


def prepare_line(text: str) -> str:
    """``:1000`` is O1000, ``/2`` is ``/``, ``(a (b))`` is one comment; every character keeps its column."""
    if ")" in text:
        end = text.rfind(")") + 1  # after it every parenthesis would be tried up to the end of the line
        code = NESTED_COMMENT.sub(
            lambda match: f"({match[1].translate(_BLANK)}){match[2].translate(_BLANK)}", text[:end]
        )
        text = code + text[end:]
    for sign, pattern, letter in ((":", _COLON, "O"), ("/", _DELETE, " ")):
        if sign in text and (match := pattern.match(text)) is not None:
            text = f"{text[: match.start(1)]}{letter}{text[match.end(1) :]}"
    return text


def refuse_letter_in_number(text: str) -> None:
    """Refuse (VP001) N9O0, which would be the block N9 of a program O0: no program has the number 0."""
    if match := _NUMBER_WITH_O.match(text):
        right = match[1].upper().replace("O", "0")
        message = f"{match[1]}: the letter O in a number; did you mean {right}?"
        raise ProgramError("VP001", message, match.start(1) + 1)
    for pattern, what in _SLIPS_OF_NUMBER:
        if match := pattern.match(text):
            wrong = match[1].upper()
            right = (
                f"O{wrong.replace('O', '', 1)}"
                if wrong[0] != "O"
                else f"O{wrong[1:].replace('O', '0').replace('P', '0')}"
            )
            raise ProgramError("VP001", f"{match[1]}: {what}; did you mean {right}?", match.start(1) + 1)


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
    while at >= 0 and characters.count("[", 0, at) > characters.count("]", 0, at):
        at = characters.find(",", at + 1)  # the one before was between the arguments of a function
    letter = characters[at + 1 : at + 2]
    if at < 0 or letter not in ("R", "C"):
        return text, None
    reader = ValueReader(characters, places, values)
    reader.at = at + 2
    size = reader.read_word(letter)
    # C0 behind a comma and a blank is an axis; ,C#1 is a corner, whatever the value
    is_word = _AXIS_BEHIND_COMMA.match(text, places[at]) is not None
    if not size > 0 and is_word and (word := _WORD_BEFORE_CORNER.search(text, 0, places[at] + 1)):
        right = f"{word[1]}."
        raise ProgramError("VP001", f"{word[0]}: {COMMA_BEHIND}; did you mean {right}?", word.start() + 1)
    if not size > 0:
        raise reader.error(
            "VP007", f",{letter}{'' if math.isnan(size) else f'{size:g}'}: the size of a corner is greater than 0", at
        )
    begin, end = places[at], places[reader.at]
    return text[:begin] + " " * (end - begin) + text[end:], (letter, size)
