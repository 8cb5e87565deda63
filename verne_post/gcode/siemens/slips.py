"""What is meant by words of a Siemens program in which a sign, a blank or a bracket is missing or too many."""

import re
from collections.abc import Callable
from typing import Final

from verne_post.base.suggestions import MAY_BE_MEANT
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.siemens.cursor import NAME, NUMBER, Cursor
from verne_post.gcode.siemens.values import FUNCTIONS
from verne_post.gcode.siemens.vocabulary import ADDRESSES, CYCLES, GROUP_OF, NO_EFFECT, STATEMENTS
from verne_post.model.findings import Remedy

_LAST_WORD: Final = re.compile(r"[A-Za-z_$]\w*\.?\d*$")
#: A letter that stands behind the first digit of its number, or its sign.
_SWAPPED_WORD: Final = re.compile(r"([-+]|\d)([A-Za-z])([\d.]*)(?![\w.=(\[])")
_TEXT: Final = re.compile(r'"[^"]*"')
_NEXT: Final = re.compile(r"[ \t]+(\w+)")
_LETTER_NUMBER: Final = re.compile(r"([A-Z])\d+")
#: Letters of a name that others may be glued to.
_LEAST: Final = 3


def refuse_no_word(cursor: Cursor, at: int) -> ProgramError:
    """The error of what begins with no letter."""
    text, rest = cursor.text, cursor.text[at:]
    before = text[:at].rstrip()
    last = _LAST_WORD.search(before)
    if rest[0] in ")]":
        edits = (Remedy(f"take {rest[0]} out", misspelt=rest[0], is_choice=True),)
        return cursor.error("VP001", f"{rest[0]} closes no bracket; take it out", at, edits)
    if rest[0] == '"':
        edits = (Remedy("take the quote out", misspelt='"', is_choice=True),)
        return cursor.error("VP001", "a quote too many; take it out", at, edits)
    swapped_word = _SWAPPED_WORD.match(text, at)
    if swapped_word is not None and (swapped_word[2].upper() in ADDRESSES or swapped_word[2].upper() in "GMN"):
        right = f"{swapped_word[2]}{swapped_word[1]}{swapped_word[3]}"
        if not right.endswith(("+", "-")):
            text = f"{swapped_word[0]}: the letter stands before its number; "
            if swapped_word[2].upper() in "GM":  # 2G0 may be G0 behind a number without its letter
                edits = (Remedy(f"write {right}", right, misspelt=swapped_word[0], is_choice=True),)
                return cursor.error("VP001", f"{text}{right}{MAY_BE_MEANT}", at, edits)
            return cursor.error("VP001", f"{text}did you mean {right}?", at)
    number = NUMBER.match(text, at)
    if number is None:
        return cursor.error("VP001", f"{rest[0]!r} does not begin a word; expected a name or a letter and a number", at)
    message = f"{number[0]}: the letter before this number is missing"
    if last is None and len(number[0]) == 1:
        return cursor.error("VP001", message, at)
    if last is None:
        return cursor.error("VP001", f"{number[0]}: a block number begins with N; did you mean N{number[0]}?", at)
    written_text, right = text[last.start() : number.end()], f"{last[0]}={number[0]}"
    if len(last[0]) > 1 and last[0].upper() in ADDRESSES:
        return cursor.error("VP001", f"{written_text}: an = is missing; did you mean {right}?", last.start())
    right = f"{last[0]}{number[0]}"
    if text[last.end()] in " \t" and last[0][-1].isdigit():
        message += f"; write it, or {right} if the blank is too many"
    return cursor.error("VP001", message, at)


def find_lost_bracket(cursor: Cursor, at: int, is_subprogram: Callable[[str], bool]) -> ProgramError | None:
    """The error of a call whose opening bracket is missing, as CYCLE823,0,3); None for other words."""
    rest = cursor.text[at:]
    code = _TEXT.sub("", rest)
    name = NAME.match(rest)
    if name is None or code.count(")") != code.count("(") + 1:
        return None
    for end in range(name.end(), 1, -1):
        known_name = rest[:end].upper()
        value = rest[end:].lstrip(" \t")
        if value and (known_name in CYCLES or known_name in NO_EFFECT or is_subprogram(known_name)):
            first = re.split(r"[,)]", value, maxsplit=1)[0]
            written_text = rest[: len(rest) - len(value) + len(first)]
            return cursor.error(
                "VP001", f"{written_text}: a ( is missing; did you mean {rest[:end]}({first.rstrip()}?", at
            )
    return None


def explain_blanks(name: str, text: str, at: int, is_subprogram: Callable[[str], bool]) -> str:
    """The message about a word with a blank too many, or two that have none between them; empty for others."""
    words = (GROUP_OF, NO_EFFECT, STATEMENTS, CYCLES)
    written_text = text[at : at + len(name)]
    following = _NEXT.match(text, at + len(name))
    if following is not None:
        whole = name + following[1].upper()
        if any(whole in known_name for known_name in words) or is_subprogram(whole):
            return f"{written_text}{following[0]}: a blank is in the word; did you mean {written_text}{following[1]}?"
    for end in range(len(name) - 1, _LEAST - 1, -1):
        address = _LETTER_NUMBER.fullmatch(name[end:])
        is_known = any(name[:end] in known_name for known_name in words[:3])
        if is_known and address is not None and address[1] in (*ADDRESSES, "G", "M"):
            return f"{written_text}: a blank is missing; did you mean {written_text[:end]} {written_text[end:]}?"
    return ""


def explain_function(name: str) -> str:
    """The message about a function that stands where a word begins; empty for other names."""
    return f"{name}() is a function of a value; the operator or = before it is missing" if name in FUNCTIONS else ""
