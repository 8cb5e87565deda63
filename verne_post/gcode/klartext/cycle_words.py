"""Definitions of cycles: CYCL DEF lines -> numbers, and which Q parameters each machining cycle needs."""

import re
from collections.abc import Iterable
from typing import Final

from msgspec import Struct

from verne_post.base.suggestions import has_one_more, list_near_numbers
from verne_post.gcode.klartext.formulas import VALUE, Numbers, read_value
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.vocabulary import name_parameter
from verne_post.gcode.program_error import ProgramError, refuse_missing, write_words
from verne_post.model.findings import Remedy

#: FMAX as the value of a feed rate; a retract at 0 or MAX is rapid traverse.
FMAX_VALUE: Final = 99_999.0
_PARAMETER: Final = re.compile(rf"Q(\d+)[ \t]*=[ \t]*(?:({VALUE})|(FMAX|MAX|FAUTO|AUTO|FU|FZ))(?![A-Z0-9])")
#: A parameter without =, or with another sign in its place; one with a blank in its number.
_NO_EQUALS: Final = re.compile(rf"Q(\d+)(?:[ \t]+|(?=[-+]))([-+.]?)[ \t]*({VALUE})(?!\w)(?![ \t]*=)")
_DIVIDED_NUMBER: Final = re.compile(r"Q(\d+)[ \t]+(\d+)[ \t]*=")
#: A parameter without a value, or with a sign alone: the next one begins, or nothing follows.
_EMPTY: Final = re.compile(r"Q(\d{1,6})[ \t]*=[ \t]*[-+]?[ \t]*(?:$|(?=Q\d+[ \t]*=))")
#: A parameter whose Q is missing, whose = is missing, and whose value has another sign than + and -.
_NO_LETTER: Final = re.compile(r"(\d{3})[ \t]*=")
_JOINED_VALUE: Final = re.compile(r"Q(\d{3})(\d[\d.,]*)(?!\w)(?![ \t]*=)")
_OTHER_SIGN: Final = re.compile(r"(Q\d+[ \t]*=[ \t]*)[*/=]([-+]?[\d.,]+)(?!\w)")
#: A digit before the sign of its value, or before the = of its parameter: Q208=3+000, Q20=0+2.
_DIGIT_BEFORE_SIGN: Final = re.compile(r"Q(\d+)=(\d)$")
#: Letters for digits in a value; more than one ~, or one before the last parameter of its line.
_LETTERS_IN_VALUE: Final = re.compile(r"(Q\d+[ \t]*=[ \t]*)([-+]?[\dOIL.,]+)(?!\w)")
_MISPLACED_TILDE: Final = re.compile(r"~[ \t]*(?=~|$)|~[ \t]*(Q\d+[ \t]*=[ \t]*[-+.,\w]+)[ \t]*(?=$|Q)")
#: A parameter in whose number letters stand for digits.
_LETTERS: Final = re.compile(r"(?<!\w)(Q[0-9OIL]+)(?=[ \t]*=)", re.IGNORECASE)
_MEANT_DIGITS: Final = str.maketrans("OoIiLl", "001111")
#: A number in which the letter O stands for 0.
_LETTER_O: Final = re.compile(r"(?=\d+O)[\dO]+(?!\w)")
#: The number of a cycle and of its line, with a comma in place of the point.
_COMMA: Final = re.compile(r"(\d+),(\d+)(?![\d.,])")
#: Another sign for the point, or the letter l for 1.
_WRONG_HEAD: Final = re.compile(
    r"[ \t]*(\d+(?:\.\.|,,|[-:])\d+|(?:7|8|9|1[0139]|32)[ \t]+\d(?=[ \t])"
    r"|\d+\.[LI]|\d+[LI]\.\d+|[LI]\d\.\d+)(?!\w)"
)
_HEAD: Final = re.compile(r"[ \t]*(\d+)(?:[ \t]*\.(\d+))?(?![\d.])")

_HOLE: Final = (200, 201, 203, 204)
_THREAD: Final = (*_HOLE, 335, 239, 253, 207)
_OF_MILLING: Final = (*_HOLE, 368, 207, 351, 202, 206)
_POCKET: Final = (*_OF_MILLING, 215, 369, 338, 366)
_POCKET_DEFAULTS: Final = {385: 500.0, 439: 0.0}
_STUD: Final = (*_OF_MILLING, 370)
#: Without Q215 they are those of controls on which a stud is roughed alone.
_STUD_DEFAULTS: Final = {215: 1.0, 369: 0.0, 338: 0.0, 385: 500.0, 437: 0.0}
#: Machining cycles: parameters that they need, as controls ask for them, and those with a default (parameter -> value).
MACHINING: Final[dict[int, tuple[tuple[int, ...], dict[int, float]]]] = {
    200: ((200, 201, 206, 202, 210, 203, 204), {211: 0.0, 395: 0.0}),
    201: ((200, 201, 206, 211, 208, 203, 204), {}),
    202: ((200, 201, 206, 211, 208, 203, 204, 214), {336: 0.0, 357: 0.2}),
    203: ((200, 201, 206, 202, 210, 203, 204, 212, 213, 205, 211, 208, 256), {395: 0.0}),
    204: ((200, 249, 250, 251, 252, 253, 254, 255, 203, 204, 214), {336: 0.0}),
    205: ((200, 201, 206, 202, 203, 204, 212, 205, 258, 259, 257, 256, 211), {
        379: 0.0, 253: 750.0, 208: FMAX_VALUE, 395: 0.0}),
    206: ((200, 201, 206, 211, 203, 204), {}),
    207: ((200, 201, 239, 203, 204), {}),
    208: ((200, 201, 206, 334, 203, 204, 335), {342: 0.0, 351: 1.0, 370: 0.0}),
    209: ((200, 201, 239, 203, 204, 257, 256), {336: 0.0, 403: 1.0}),
    240: ((200, 343, 201, 344, 206, 211, 203, 204), {}),
    262: ((*_THREAD, 355, 351), {512: 0.0}),
    263: ((*_THREAD, 356, 351, 357, 358, 359, 254), {512: 0.0}),
    264: ((*_THREAD, 356, 351, 202, 258, 257, 256, 358, 359, 206), {512: 0.0}),
    265: ((*_THREAD, 358, 359, 360, 254), {}),
    267: ((*_THREAD, 355, 351, 358, 359, 254), {512: 0.0}),
    241: ((*_HOLE, 206), {211: 0.0, 379: 0.0, 253: 750.0, 208: FMAX_VALUE, 426: 5.0, 427: 50.0, 428: 500.0, 429: 8.0,
                          430: 9.0, 202: 0.0, 212: 0.0, 205: 0.0,
                          401: 100.0, 435: 0.0}),
    232: ((389, 225, 226, 227, 386, 218, 219, 202, 369, 370, 207, 385, 253, 200, 357, 204), {}),
    233: ((389, 218, 219, 227, 386, 202, 370, 207, 253, 200, 204), {
        215: 0.0, 350: 1.0, 369: 0.0, 385: 500.0, 357: 2.0, 347: 0.0, 348: 0.0, 349: 0.0, 220: 0.0, 368: 0.0, 338: 0.0,
        367: 0.0}),
    251: ((*_POCKET, 218, 219, 220, 224, 367, 370), _POCKET_DEFAULTS),
    252: ((*_POCKET, 223, 370), _POCKET_DEFAULTS),
    253: ((*_POCKET, 218, 219, 374, 367), _POCKET_DEFAULTS),
    254: ((*_POCKET, 219, 375, 216, 217, 376, 248, 378, 377), {**_POCKET_DEFAULTS, 367: 0.0}),
    256: ((*_STUD, 218, 424, 219, 425, 220, 224, 367), _STUD_DEFAULTS),
    257: ((*_STUD, 223, 222), {**_STUD_DEFAULTS, 376: -1.0}),
    258: ((*_STUD, 573, 571, 222, 572, 224, 220, 215, 369, 338), {385: 500.0}),
}  # fmt: skip
#: Patterns, which run the cycle that is defined at once.
PATTERNS: Final[dict[int, tuple[tuple[int, ...], dict[int, float]]]] = {
    220: ((216, 217, 244, 245, 246, 247, 241, 200, 203, 204, 301), {365: 0.0}),
    221: ((225, 226, 237, 238, 242, 243, 224, 200, 203, 204, 301), {}),
}
#: All cycles of Q parameters.
OF_PARAMETERS: Final = {247: ((339,), dict[int, float]()), **MACHINING, **PATTERNS}


class Head(Struct, frozen=True):
    """CYCL DEF 7.1: number of the cycle, of its line (None for cycles of Q parameters), and what follows."""

    number: int
    part: int | None
    rest: str
    at: int
    begin: int  #: Of its number.


def read_head(statement: Statement) -> Head:
    """The number after CYCL DEF."""
    match = _HEAD.match(statement.rest)
    if (slip := _WRONG_HEAD.match(statement.rest)) is not None:
        right = re.sub(r"[.,]{2}|[-:]|[ \t]+", ".", slip[1]).translate(_MEANT_DIGITS)
        text = f"{slip[1]}: no number of a cycle; did you mean {right}?"
        raise statement.error("VP001", text, slip.start(1))
    if (written_text := re.match(r"[ \t]*(\d*\.|\.\d+)(?![\d.])", statement.rest)) is not None:
        where, right = (
            ("after", f"{written_text[1]}1") if written_text[1][-1] == "." else ("before", f"7{written_text[1]}")
        )
        text = f"{written_text[1]}: the digits {where} the point are missing, as in CYCL DEF {right}"
        raise statement.error("VP001", text, 0)
    if match is None:
        raise statement.error("VP001", "CYCL DEF needs the number of the cycle", 0)
    if word := _LETTER_O.match(statement.rest, match.start(1)):
        meant_number = word[0].replace("O", "0")
        raise statement.error(
            "VP001", f"{word[0]}: the letter O in a number; did you mean {meant_number}?", word.start()
        )
    if comma := _COMMA.match(statement.rest, match.start(1)):
        right = f"{comma[1]}.{comma[2]}"
        raise statement.error("VP001", f"{comma[0]}: a decimal comma in a number; did you mean {right}?", comma.start())
    part = None if match.group(2) is None else int(match.group(2)[:3])
    return Head(int(match.group(1)[:6]), part, statement.rest[match.end() :], match.end(), match.start(1))


def read_parameters(statement: Statement, head: Head, numbers: Numbers, auto_feed: float) -> dict[int, float]:
    """Q parameters of a definition: ``Q200=+2``; MAX and AUTO as feed rates.

    Raises
    ------
    ProgramError
        For what is no parameter; the name of the cycle comes first and may be any text.
    """
    values: dict[int, float] = {}
    first = re.search(r"(?:^|[ \t])(?:Q[ \t]*\d+|[A-Z]?\d{3})[ \t]*=|(?:^|[ \t])Q\d{4,}(?![ \t]*=)", head.rest)
    at = first.start() if first is not None else len(head.rest)
    text = head.rest
    while at < len(text) and text[at:].strip():
        at += len(text[at:]) - len(text[at:].lstrip())
        if empty := _EMPTY.match(text, at):
            name = int(empty[1])
            what = f", the {name_parameter(name)}," if name_parameter(name) else ""
            message = f"Q{name}{what} has no value; write its number after Q{name}="
            raise statement.error("VP001", message, head.at + at)
        match = _PARAMETER.match(text, at)
        if match is None:
            raise _refuse_unread(statement, head, at)
        place, number, value, word = head.at + at, int(match.group(1)[:6]), match.group(2), match.group(3)
        if number in values:
            raise _refuse_twice(statement, head, number, place)
        if word in ("FU", "FZ"):
            raise statement.error(
                "VP002", f"CYCL DEF {head.number}: Q{number}={word}: feed rates of cycles are in mm/min", place
            )
        if word in ("AUTO", "FAUTO"):
            if not auto_feed:
                raise statement.error("VP009", f"CYCL DEF {head.number}: Q{number}=AUTO needs an F of TOOL CALL", place)
            values[number] = auto_feed
        else:
            with statement.place_errors(head.at + match.start(2)):
                values[number] = FMAX_VALUE if word else read_value(value, numbers)
        at = match.end()
    return values


def _refuse_unread(statement: Statement, head: Head, at: int) -> ProgramError:
    """The error of what is no parameter: the form that is meant, or a remark without its sign."""
    rest = head.rest[at:]
    word = re.match(r"[^ \t]+", rest)[0]  # type: ignore[index]
    if (written_text := _NO_EQUALS.match(rest)) is not None:
        sign, value = written_text[2], written_text[3]
        right = f"Q{written_text[1]}={value if sign in ('', '=') or value[0] in '+-' else sign + value}"
        rights = [right, right.replace("-", "")] if sign == "-" and value[0] not in "+-" else [right]
        text = f"{' '.join(written_text[0].split())}: an = is missing; write {' or '.join(rights)}"
        return statement.error("VP001", text, head.at + at, write_words(written_text[0], *rights))
    if (written_text := _OTHER_SIGN.match(rest)) is not None:
        is_double = "==" in written_text[0]
        signs = ("",) if written_text[2][0] in "-+" else ("", "-") if is_double else ("+", "-")
        rights = [f"{written_text[1]}{one}{written_text[2]}" for one in signs]
        what = "two = stand in it" if is_double else "a number has + or - as its sign"
        return statement.refuse_word(written_text[0], what, *rights, at=head.at + at)
    needs, defaults = OF_PARAMETERS.get(head.number, ((), {}))
    if (written_text := _JOINED_VALUE.match(rest)) is not None and (
        int(written_text[1]) in (*needs, *defaults) or not needs
    ):
        right = f"Q{written_text[1]}={written_text[2]}"
        return statement.refuse_word(written_text[0], "an = is missing", right, at=head.at + at)
    if (written_text := _NO_LETTER.match(rest)) is not None:
        text = f"{written_text[1]}: the Q before the number is missing; did you mean Q{written_text[1]}?"
        return statement.error("VP001", text, head.at + at)
    if (written_text := re.match(r"Q[ \t]+(\d+)[ \t]*=", rest)) is not None:
        right = f"Q{written_text[1]}="
        return statement.refuse_word(written_text[0], "a blank is in the number", right, at=head.at + at)
    other = re.match(r"(?:[A-PR-Z12](\d{3})|(\d)Q(\d\d))(?=[ \t]*=)", rest)
    digits = "" if other is None else other[1] or other[2] + other[3]
    if other is not None and (int(digits) in (*needs, *defaults) or not needs):
        text = f"{other[0]}: no parameter; did you mean Q{digits}?"
        return statement.error("VP001", text, head.at + at)
    if (written_text := re.match(r"Q(\d+)([-+])=(?=[\d.,])", rest)) is not None:
        right = f"Q{written_text[1]}={written_text[2]}"
        return statement.refuse_word(written_text[0], "the sign stands after the =", right, at=head.at + at)
    if word.isdigit() and (before := re.search(r"Q\d+=[-+]?\d+(?=[ \t]+$)", head.rest[:at])) is not None:
        text = f"{before[0]} {word}: a blank is in the number; did you mean {before[0]}{word}?"
        return statement.error("VP001", text, head.at + before.start())
    if (letters := _LETTERS.match(rest)) is not None and (number := _read_letters(letters[1])) is not None:
        text = f"{letters[1].replace('L', 'l')}: a letter in the number; did you mean Q{number}?"
        return statement.error("VP001", text, head.at + at)
    if (written_text := _DIVIDED_NUMBER.match(rest)) is not None:
        right = f"Q{written_text[1]}{written_text[2]}="
        return statement.refuse_word(written_text[0], "a blank is in the number", right, at=head.at + at)
    needs_sign = re.match(r"([-+])[\d.,]+(?!\w)", rest)
    if needs_sign is not None and (parts := _DIGIT_BEFORE_SIGN.search(head.rest[:at])) is not None:
        is_of_name = int(parts[1]) not in needs and int(parts[1] + parts[2]) in needs
        wrong, sign, digits = f"{parts[0]}{needs_sign[0]}", needs_sign[1], needs_sign[0][1:]
        right = f"Q{parts[1]}{parts[2]}={sign}{digits}" if is_of_name else f"Q{parts[1]}={sign}{parts[2]}{digits}"
        text = f"{wrong}: a digit stands before the {'=' if is_of_name else 'sign'}; did you mean {right}?"
        return statement.error("VP001", text, head.at + parts.start())
    if (letter := _LETTERS_IN_VALUE.match(rest)) is not None:
        right = f"{letter[1]}{letter[2].translate(_MEANT_DIGITS)}"
        text = f"{letter[0]}: a letter in the number; did you mean {right}?"
        return statement.error("VP001", text, head.at + at)
    if (tilde := _MISPLACED_TILDE.match(rest)) is not None:
        first, last = (statement.find_place(head.at + at + one)[0] for one in (0, len(tilde[0].rstrip()) - 1))
        right = f"{tilde[1]} ~" if tilde[1] and first == last else ""
        wrong = tilde[0].rstrip() if right else "~"
        edits = (Remedy(f"write {right}" if right else "take one ~ out", right, misspelt=wrong),)
        what = f"a ~ ends its line; write {right}" if right else "one ~ at the end of a line is enough; take one out"
        return statement.error("VP001", f"{wrong}: {what}", head.at + at, edits)
    if not re.match(r"Q\d|[-+\d]", word):
        text = f"{word[:20]}: a remark begins with ;, which is missing; write ;{word[:20]}"
        return statement.error("VP001", text, head.at + at, write_words(word, f";{word}"))
    text = f"CYCL DEF {head.number}: {word[:20]!r} is not of the form Q200=2"
    return statement.error("VP001", text, head.at + at)


def _refuse_twice(statement: Statement, head: Head, number: int, place: int) -> ProgramError:
    """The error of a parameter that is given again, maybe in place of one that is missing: either of both is meant."""
    given = [(match, int(match.group(1))) for match in _PARAMETER.finditer(head.rest)]
    needs = OF_PARAMETERS.get(head.number, ((), {}))[0]
    missing = [one for one in needs if one not in {name for _match, name in given}]
    text, near = f"CYCL DEF {head.number}: Q{number} appears twice", find_with_digit(number, missing)
    near = near or (missing[0] if len(missing) == 1 else None)
    edits = []
    if near is None:
        text += "; take one of the two out"
    for match, name in given if near else ():
        if name == number:
            line, _column = statement.find_place(head.at + match.start())
            new = match[0].replace(match.group(1), str(near), 1)
            edits.append(Remedy(f"write {new}", new, line=line, misspelt=match[0], is_choice=True))
    also = f", and Q{near} is missing, the {name_parameter(near)}; write Q{near} in one of both places" if near else ""
    return statement.error("VP004", text + also, place, tuple(edits))


def find_cycle_of(head: Head) -> int | None:
    """The one other cycle whose number is a slip away, and which has all parameters of a definition; else None."""
    given = {int(one) for one in re.findall(r"(?:^|[ \t])Q(\d{1,4})[ \t]*=", head.rest)}
    fits = [one for one, (needs, defaults) in OF_PARAMETERS.items() if given and given <= {*needs, *defaults}]
    if head.number in fits:
        return None
    complete_fits = [one for one in fits if given >= {*OF_PARAMETERS[one][0]}]
    # a parameter may be mistyped in a cycle that is executed, so its number is wrong only where another has them all
    fits = complete_fits or ([] if head.number in OF_PARAMETERS else fits)
    near = find_with_digit(head.number, fits)
    others = [one for one in fits if sum(a != b for a, b in zip(str(one), str(head.number), strict=False)) == 1]
    same_length = [one for one in others if len(str(one)) == len(str(head.number))]
    return near or (same_length[0] if len(same_length) == 1 else None)


def list_missing(text: str) -> tuple[list[str], list[str]]:
    """The parameters that the cycle of a definition needs and does not have, and the others that it may have."""
    head = re.search(r"DEF[ \t]*(\d{3})", text, re.IGNORECASE)
    given = {int(one) for one in re.findall(r"Q[ \t]*(\d{1,4})[ \t]*=", text, re.IGNORECASE)}
    kinds = OF_PARAMETERS.get(int(head[1]), ((), {})) if head else ((), {})
    missing, others = ([f"Q{one}, the {name_parameter(one)}" for one in kind if one not in given] for kind in kinds)
    return missing, others


def find_parameter(statement: Statement, number: int) -> int | None:
    """Where in the rest of a definition a Q parameter begins; None where it is not given."""
    found = re.search(rf"(?:^|[ \t])(Q0*{number})[ \t]*=", statement.rest)
    return None if found is None else found.start(1)


def find_with_digit(number: int, missing: Iterable[int]) -> int | None:
    """The one parameter that is missing and has one digit more or less, or two in another order; None without one."""
    digits = str(number)

    def is_near(name: str) -> bool:
        shorter, longer = sorted((digits, name), key=len)
        if len(longer) == len(shorter):
            return sorted(shorter) == sorted(longer)
        return has_one_more(longer, shorter)

    found = [one for one in missing if is_near(str(one))]
    return found[0] if len(found) == 1 else None


def _read_letters(word: str) -> int | None:
    """The number of a parameter in which letters stand for digits, as Q2OO; None where it has none."""
    digits = word[1:].translate(_MEANT_DIGITS)
    return int(digits) if digits != word[1:] and digits.isdecimal() else None


def complete(
    statement: Statement, number: int, given: dict[int, float], needs: tuple[int, ...], defaults: dict[int, float]
) -> dict[int, float]:
    """The parameters of a cycle, with defaults; refuses missing ones and those that it does not have."""
    for name in given:
        if name not in needs and name not in defaults:
            missing = [one for one in needs if one not in given]
            others = list_near_numbers(str(name), map(str, missing))
            others = others or [str(one) for one in missing]
            near = find_with_digit(name, missing) or (int(others[0]) if len(others) == 1 else None)
            also = f"; Q{near}, the {name_parameter(near)}, is missing" if near else ""
            raise statement.error(
                "VP006",
                f"Q{name}: CYCL DEF {number} has no such parameter{also}; did you mean Q{near}?"
                if near
                else f"CYCL DEF {number}: Q{name} is not a parameter that is executed here",
                find_parameter(statement, name),
            )
    missing = [name for name in needs if name not in given]
    for word in _LETTERS.finditer(statement.rest) if missing else ():
        meant_number = _read_letters(word[1])
        if meant_number is not None and meant_number in missing:
            text = f"{word[1]}: a letter in the number; did you mean Q{meant_number}?"
            raise statement.error("VP001", text, word.start(1))
    if missing:
        raise refuse_missing(f"CYCL DEF {number}", [(f"Q{name}", name_parameter(name)) for name in missing])
    return {**defaults, **given}
