"""Statements of cutter location text in which one sign is missing, too many or another one."""

import re
from collections.abc import Collection, Iterator
from itertools import pairwise
from typing import Final, NamedTuple

from msgspec.structs import replace

from verne_post.gcode.apt.statements import Statement, is_number
from verne_post.gcode.apt.words import NUMBERS_OF, WORDS_OF
from verne_post.gcode.mistyped import DIGITS_ALIKE
from verne_post.gcode.program_error import ProgramError, write_words

#: Longer words are no slips.
_LONGEST: Final = 40
#: Words of the longest statement that is looked at.
_MOST_WORDS: Final = 20
#: A number with letters that look like digits.
_MISTYPED_NUMBER: Final = re.compile(
    r"[-+]?(?:(?=\D*\d)[\d.]*([Ool])[\dOol]*\.?[\dOol]*|\d[\d.]*([SBZ])[\dSBZ]*\.?[\dSBZ]*)$"
)
_HEAD: Final = re.compile(r"[A-Za-z]+")
#: What may stand in place of a slash or a comma.
_OTHER_SIGNS: Final = re.compile(r"[ \t]*[.,;:/\\]?[ \t]*")
#: Major words whose numbers have decimals, and are no pairs.
_WITH_DECIMALS: Final = ("GOTO", "GODLTA", "FROM", "FEDRAT", "SPINDL", "DELAY", "CYCLE")
_WHOLE_PART, _DECIMALS = re.compile(r"[-+]?\d+$"), re.compile(r"\d+$")


class _Reading(NamedTuple):
    """A statement as it may be meant, and the word at a column that becomes another one."""

    statement: Statement
    wrong: str
    right: str
    what: str
    column: int | None
    is_choice: bool = False


def correct_number(statement: Statement) -> tuple[ProgramError, Statement] | None:
    """The error of the first word that is a number but for letters like digits, and the statement with that number."""
    for at, word in enumerate(statement.words):
        if match := _MISTYPED_NUMBER.match(word):
            right = word.translate(DIGITS_ALIKE)
            text = f"{word}: the letter {match[1] or match[2]} in a number; did you mean {right}?"
            words = (*statement.words[:at], right, *statement.words[at + 1 :])
            return ProgramError("VP001", text, _find_column(statement, at)), replace(statement, words=words)
    return None


def correct_sign(statement: Statement, majors: Collection[str]) -> tuple[ProgramError, Statement] | None:
    """The error of a slash, comma or point, and the statement that is meant; None where none or several fit."""
    if len(statement.words) > _MOST_WORDS or _has_form(statement.major, statement.words):
        return None
    read = _list_without_slash if statement.major not in majors else _list_other_words
    found = [one for one in read(statement, majors) if _has_form(one.statement.major, one.statement.words)]
    if len({one.statement.words for one in found}) != 1:
        return None
    statement, wrong, right, what, column, is_choice = found[0]
    edits = write_words(wrong, right, is_choice=is_choice)
    return ProgramError("VP001", f"{wrong}: {what}; did you mean {right}?", column, edits=edits), statement


def _find_column(statement: Statement, at: int) -> int | None:
    """The column of a word after the slash."""
    return statement.columns[at + 1] if statement.columns else None


def _has_form(major: str, words: Collection[str]) -> bool:
    """Whether the words after a slash are known there, and the numbers are as many as they are to be."""
    known_words, is_of_numbers = WORDS_OF.get(major, {}), [is_number(word) for word in words]
    counts, count = {n for name, n in NUMBERS_OF if name == major}, sum(is_of_numbers)
    if not words or any(word.upper() not in known_words for word in words if not is_number(word)):
        return False
    if counts and 0 not in counts:
        return count in counts
    has_words_between = not any(one and other for one, other in pairwise(is_of_numbers))
    return (
        has_words_between and (count > 0 or 0 not in counts or major == "SPINDL") and (count == 1 or major != "FEDRAT")
    )


def _list_without_slash(statement: Statement, majors: Collection[str]) -> Iterator[_Reading]:
    """Statements whose major word runs into what follows, or is followed by another sign."""
    text = statement.text if not statement.major else ",".join((statement.major, *statement.words))
    head = _HEAD.match(text)
    names = (major for major in majors if head is not None and head[0].upper().startswith(major))
    for major in sorted(names, key=len, reverse=True)[:1]:
        sign = _OTHER_SIGNS.match(text, len(major))
        rest = text[sign.end() if sign is not None else len(major) :]
        words, wrong = tuple(word.strip() for word in rest.split(",")), text.split(",")[0].rstrip()
        if sign is not None and "," in sign[0]:
            wrong = f"{wrong},{words[0]}"
        right = f"{major}/{words[0]}"
        what = "the first word has a slash after it" if sign and sign[0].strip() else "the slash is missing"
        # the sign may stand in place of the slash
        is_choice = rest[:1] in ("-", "+")
        columns = statement.columns[:1]
        meant_statement = Statement(statement.line, major, words, rest, columns, statement.n_lines)
        yield _Reading(meant_statement, wrong, right, what, columns[0] if columns else None, is_choice)


def _list_other_words(statement: Statement, _majors: Collection[str]) -> Iterator[_Reading]:
    """Statements with another word, or with one for two."""
    words = statement.words
    known_words = {*WORDS_OF.get(statement.major, {})}

    def read(at: int, count: int, new: tuple[str, ...], what: str, wrong: str = "", right: str = "") -> _Reading:
        meant_statement = replace(
            statement, words=(*words[:at], *new, *words[at + count :]), columns=statement.columns[:1]
        )
        wrong, right = wrong or ",".join(words[at : at + count]), right or ",".join(new)
        return _Reading(meant_statement, wrong, right, what, _find_column(statement, at))

    for at, word in enumerate(words):
        before = words[at - 1] if at else ""
        # behind the name of a cycle, 10,2 may be a depth and a clearance without their words
        may_be_one = statement.major in _WITH_DECIMALS and (statement.major != "CYCLE" or at > len(("name", "depth")))
        if may_be_one and _WHOLE_PART.match(before) and _DECIMALS.match(word):
            yield read(at - 1, 2, (f"{before}.{word}",), "a decimal comma in a number")
        if not word and at:
            yield read(at - 1, 2, (before,), "the comma is there twice", f"{before},", before)
        if not at and word[:1] == "/":
            yield read(0, 1, (word[1:],), "the slash is there twice")
        if not word or is_number(word) or word.upper() in known_words or len(word) > _LONGEST:
            continue
        for one in range(1, len(word)):
            sign = _OTHER_SIGNS.match(word, one)
            rest = word[sign.end() if sign is not None else one :]
            if _is_word(word[:one], known_words) and _is_word(rest, known_words):
                is_divided = sign is not None and sign[0].strip()
                what = f"{sign[0].strip()} in place of a comma" if sign and is_divided else "a comma is missing"
                yield read(at, 1, (word[:one], rest), what)
            if word[one - 1 : one + 1] == "..":
                yield read(at, 1, (word[:one] + word[one + 1 :],), "the point is there twice")


def _is_word(text: str, known_words: Collection[str]) -> bool:
    return is_number(text) or text.upper() in known_words
