"""Words of Klartext that a slip of typing has made unreadable: what is meant, for path functions, planes and blanks."""

import re
from collections.abc import Sequence
from typing import Final

from verne_post.base.suggestions import MAY_BE_MEANT, drop_doubles, find_meant
from verne_post.gcode.klartext.statements import (
    Statement,
    find_equals,
    join_keyword,
)
from verne_post.gcode.klartext.vocabulary import WORDS
from verne_post.gcode.program_error import ProgramError, write_words

_WHOLE_WORD: Final = re.compile(r"(?!R)[A-Z]+[-+]?[1-9]\d*[.,]?\d*|[A-Z]+[-+]?\d+[.,]\d*")
#: A word with a sign that numbers do not have.
_OTHER_SIGN: Final = re.compile(r"(\w*[A-Z])[ \t]*[*/]([\d.,]+)")
_SIGN_IN_NUMBER: Final = re.compile(r"([A-Z]+)(\d)([-+])([\d.,]*)")
_NUMBER_BEFORE: Final = re.compile(r"([-+]|\d)([A-Z]+)([-+]?\d[\d.,]*|)")
_DIGIT_BEFORE_Q: Final = re.compile(r"([FS]?)(\d)Q(\d*)")
#: The number of the tool and its axis, or the axis and the speed, without the blank between them.
_TOOL_AND_AXIS: Final = re.compile(r"(\d+(?=Z)|Z(?=[SF]))(Z|[SF]\d+)")
_NAME_AND_NUMBER: Final = re.compile(r"([A-Z]{3,6})([-+]?[\d.,]+)")
#: Words too short for other slips, and the keys beside those of their letters.
_SHORT_WORD: Final = re.compile(r"R[LR0]|DR[-+]|M\d{1,3}|[AR][-+]?[\d.,]+")
#: More digits than these, alone behind the coordinates of a line without F, are a feed rate.
_DIGITS_OF_DECIMALS: Final = 2
#: Axes, and so many of them as are worth a choice for a number that has lost its letter.
_AXES: Final = "XYZABC"
_MOST_LETTERS: Final = 3
_COORDINATE_OF: Final = re.compile(r"(?<!\w)I?([XYZABC])[ \t]*[-+\d.,Q]")
_COORDINATE_BEHIND: Final = re.compile(r"[ \t]I?[XYZABCUVW][-+\d]")
_KEYS_BESIDE: Final = {"A": "Q", "D": "SFERXC", "R": "ETDF4", "L": "KOP", "M": "NJK,"}


def find_slip(
    pattern: re.Pattern[str], statement: Statement, text: str, begin: int, names: Sequence[str] = ()
) -> ProgramError | None:
    """The error of a word that begins at a place of the rest of a statement, with what is meant; None if that is open.

    Parameters
    ----------
    pattern : re.Pattern
        Of the words of the statement.
    names : sequence of str
        Letters that stand before numbers in it.
    """
    word, start = text[begin:].split()[0], len(text[:begin].rpartition(" ")[0])
    start += text.startswith(" ", start)
    whole = text[start:].split()[0]
    if (sign := _OTHER_SIGN.fullmatch(word)) is not None:
        rights = [f"{sign[1]}{one}{sign[2]}" for one in "+-"]
        return statement.refuse_word(word, "a number has + or - as its sign", *rights, at=begin)
    if statement.keyword == "TOOL CALL" and (parts := _TOOL_AND_AXIS.fullmatch(word)):
        return statement.refuse_word(word, "a blank is missing", f"{parts[1]} {parts[2]}", at=begin)
    is_point = word[0] == ":" or re.fullmatch(r"[A-Z]+[-+]\d+-\d+", whole) is not None
    if (is_point or word == "Q") and text[begin - 1].isdigit():
        right = f"{whole[:-2]}Q{whole[-2]}" if word == "Q" else re.sub(r"(?<=\d)[-:]", ".", whole)
        if word[0] == "-" and pattern.fullmatch(right):  # the keys of 0 and of the point are both beside it
            rights = [re.sub(r"(?<=\d)-", "", whole), right]
            return statement.refuse_word(whole, "- in a number", *rights, at=start)
        if pattern.fullmatch(right):
            what = "a digit before its letter" if word == "Q" else f"{word[0]} in a number"
            return statement.error("VP001", f"{whole}: {what}; did you mean {right}?", start)
    if equals := find_equals(statement, text, begin):
        return equals
    earlier_words = text[:begin].split()
    if rights := _list_divided(statement, text, begin):
        at = text.rindex(earlier_words[-1], 0, begin)
        wrong = text[at : begin + len(word)]
        return statement.refuse_word(wrong, "a blank in a number, or a number without its letter", *rights, at=at)
    if earlier_words and (digit := re.fullmatch(r"(\d)([A-Z])(.+)", word)):
        number, rest = earlier_words[-1] + digit[1], digit[2] + digit[3]
        if pattern.fullmatch(number) and pattern.fullmatch(rest) and not earlier_words[-1].startswith("R"):
            rights = [f"{number} {rest}"]
            if digit[3][0].isdigit():
                rights.append(f"{earlier_words[-1]} {digit[2]}{digit[1]}{digit[3]}")
            at = text.rindex(earlier_words[-1], 0, begin)
            wrong = text[at : begin + len(word)]
            what = "the blank is at a wrong place"
            if len(rights) > 1:
                return statement.refuse_word(wrong, what, *rights, at=at)
            return statement.error("VP001", f"{wrong}: {what}; did you mean {rights[0]}?", at)
    if moved_blank := _join_word(pattern, statement, text, begin):
        message, at = moved_blank
        return statement.error("VP001", message, at)
    for written_word, at in ((whole, start), (word, begin)):
        if (reading := _read_as_meant(pattern, written_word, names)) is not None:
            what, right = reading
            return statement.error("VP001", f"{written_word}: {what}; did you mean {right}?", at)
    if near := _list_near_words(pattern, word):
        edits = write_words(word, *near, is_choice=True)
        message = f"{word}: no meaning in this language; {' or '.join(near)}{MAY_BE_MEANT}"
        return statement.error("VP001", message, begin, edits)
    ends = (
        at
        for at in range(1, len(word))
        if word[:at] not in ("F", "M", "R") and pattern.fullmatch(word[:at]) and pattern.fullmatch(word[at:])
    )
    if at := next(ends, 0):
        return statement.refuse_word(word, "a blank is missing", f"{word[:at]} {word[at:]}", at=begin)
    if re.match(r"[-+]?[\d.]", word):
        rights = [one for one in _list_lettered(statement, text, begin) if pattern.fullmatch(one)]
        text = f"{word[:15]}: the letter before this number is missing"
        text += f"; write {' or '.join(rights)}" if rights else ""
        return statement.error("VP001", text, begin, write_words(word, *rights, is_choice=True))
    return None


def _list_divided(statement: Statement, text: str, begin: int) -> list[str]:
    """What a number alone may be behind a coordinate: a feed rate, or the decimals; [] for one digit, its last one."""
    word, before = text[begin:].split()[0], text[:begin].split()[-1:]
    if not word.isdigit() or len(word) < _DIGITS_OF_DECIMALS or not before or not _WHOLE_WORD.fullmatch(before[0]):
        return []
    has_point = re.search("[.,]", before[0]) is not None
    is_feed = len(word) > _DIGITS_OF_DECIMALS and word[0] != "0" and statement.keyword == "L"
    is_feed = is_feed and re.search(r"(?<!\w)F", text) is None and _COORDINATE_BEHIND.search(text, begin) is None
    if statement.keyword == "TOOL CALL" and word[0] != "0" and before[0][0] == "S":
        return [f"{before[0]} F{word}", f"{before[0]}{word}"]
    feed = [f"{before[0]} F{word}"] * is_feed
    return feed if has_point else feed or [f"{before[0]}.{word}", f"{before[0]}{word}"]


def _list_lettered(statement: Statement, text: str, begin: int) -> list[str]:
    """A number alone with each letter that it may have lost: S, or F behind it; an axis between those around it."""
    word = text[begin:].split()[0]
    if statement.keyword == "TOOL CALL":
        return [f"{one}{word}" for one in "SF" if re.search(rf"(?<!\w){one}", text) is None][:1]
    axes = [[_AXES.index(one) for one in _COORDINATE_OF.findall(part)] for part in (text[:begin], text[begin:])]
    between = _AXES[max(axes[0], default=-1) + 1 : min(axes[1], default=len(_AXES))]
    is_place = statement.keyword in ("L", "C", "BLK FORM") and re.search("[-+.,]", word) is not None
    return [f"{one}{word}" for one in between] if is_place and len(between) <= _MOST_LETTERS else []


def _list_near_words(pattern: re.Pattern[str], word: str) -> list[str]:
    """The short words of a statement that a key beside the right one turns into this word."""
    readings = (
        word[:at] + right + word[at + 1 :]
        for at, letter in enumerate(word)
        for right, beside in _KEYS_BESIDE.items()
        if letter in beside
    )
    return [one for one in readings if _SHORT_WORD.fullmatch(one) and pattern.fullmatch(one)]


def _read_as_meant(pattern: re.Pattern[str], word: str, names: Sequence[str]) -> tuple[str, str] | None:
    """What is wrong with a word, and the one that is meant; None where no single slip explains it."""
    readings: list[tuple[str, str]] = []
    if word in ("MAX", "AUTO"):
        readings += [("the F is missing", f"F{word}")]
    if word[1:] in ("MAX", "AUTO"):
        readings += [("no meaning in this language", f"F{word[1:]}")]
    if letters := re.fullmatch(r"([A-Z])([A-Z])([-+].+)", word):
        readings += [("two letters in the wrong order", f"{letters[2]}{letters[1]}{letters[3]}")]
    if "I" in word[1:] and re.search(r"[-+\d]", word):
        readings += [("the letter I in a number", word[0] + word[1:].replace("I", "1"))]
    if re.fullmatch(r"[A-Z]+[-+][\d.,]*L[\d.,L]*", word):
        readings += [("the letter l in a number", word[:2] + word[2:].replace("L", "1"))]
    if word[-1] == "O" and word[:-1] in names and len(word) > 3:
        readings += [("the letter O in a number", f"{word[:-1]}0")]
    if swapped_parts := _SIGN_IN_NUMBER.fullmatch(word):
        readings += [
            ("a digit before its sign", f"{swapped_parts[1]}{swapped_parts[3]}{swapped_parts[2]}{swapped_parts[4]}")
        ]
    if digits := _DIGIT_BEFORE_Q.fullmatch(word):
        readings += [("a digit before its letter", f"{digits[1]}Q{digits[2]}{digits[3]}")]
    if swapped_parts := _NUMBER_BEFORE.fullmatch(word):
        sign = swapped_parts[3][:1] if swapped_parts[3][:1] in ("+", "-") else ""
        right = f"{swapped_parts[2]}{sign}{swapped_parts[1]}{swapped_parts[3][len(sign) :]}"
        readings += [("the letter stands before its number", right)]
    readings += [("no meaning in this language", once) for once in drop_doubles(word)]
    if (parts := _NAME_AND_NUMBER.fullmatch(word)) and (near := find_meant(parts[1], names, slip_alone=True, least=3)):
        readings += [("no meaning in this language", near + parts[2])]
    return next(((what, right) for what, right in readings if pattern.fullmatch(right)), None)


def _join_word(pattern: re.Pattern[str], statement: Statement, text: str, begin: int) -> tuple[str, int] | None:
    """The message about words between which a blank is too many or at a wrong place, and where they begin.

    A zero behind a whole word is none of its digits: R0 may have lost its letter.
    """
    word = text[begin:].split()[0]
    earlier_words, following = text[:begin].split(), text[begin + len(word) :].split()
    if word.isdigit() and earlier_words and _WHOLE_WORD.fullmatch(earlier_words[-1]):
        message = f"{earlier_words[-1]} {word}: a blank is in the number; did you mean {earlier_words[-1]}{word}?"
        return message, text.rindex(earlier_words[-1], 0, begin)
    if statement.keyword in ("L", "C") and not earlier_words and (longer := join_keyword(statement, word)):
        written_word = f"{statement.keyword}{text[:begin]}{longer[1:]}"
        return f"{written_word}: a blank is in the word; did you mean {longer}?", -1
    if following and word.isalpha() and word + following[0] in ("FMAX", "FAUTO", *WORDS):
        return f"{word} {following[0]}: a blank is in the word; did you mean {word}{following[0]}?", begin
    if not following or (word.isalpha() and following[0] in WORDS):
        return None
    joined_text = word + following[0]
    if text[begin - 1].isdigit() and pattern.fullmatch(joined_text):  # X-30D R+
        right = f"{earlier_words[-1]} {joined_text}"
        wrong = f"{earlier_words[-1]}{word} {following[0]}"
        return f"{wrong}: the blank is at a wrong place; did you mean {right}?", begin - len(earlier_words[-1])
    for at in (len(word) - 1, len(word) + 1):
        if 0 < at < len(joined_text) and pattern.fullmatch(joined_text[:at]) and pattern.fullmatch(joined_text[at:]):
            right = f"{joined_text[:at]} {joined_text[at:]}"
            return f"{word} {following[0]}: the blank is at a wrong place; did you mean {right}?", begin
    return None
