"""What is meant by words of a Siemens program in which a sign, a blank or a bracket is missing or too many."""

import re
from collections.abc import Callable, Iterable
from typing import Final

from verne_post.base.suggestions import DIGITS_OF_KEYS, MAY_BE_MEANT, find_meant
from verne_post.gcode.mistyped import OF_ALL_MOVES
from verne_post.gcode.program_error import ProgramError, write_words
from verne_post.gcode.siemens.cursor import NAME, NUMBER, Cursor
from verne_post.gcode.siemens.values import FUNCTIONS
from verne_post.gcode.siemens.vocabulary import ADDRESSES, CYCLES, GROUP_OF, NO_EFFECT, STATEMENTS, TYPES, VALUE_MODES
from verne_post.model.findings import Remedy

_LAST_WORD: Final = re.compile(r"[A-Za-z_$]\w*\.?\d*$")
#: A letter that stands behind the first digit of its number, or its sign.
_SWAPPED_WORD: Final = re.compile(r"([-+]|\d)([A-Za-z])([\d.]*)(?![\w.=(\[])")
_TEXT: Final = re.compile(r'"[^"]*"')
_NEXT: Final = re.compile(r"[ \t]+(\w+)")
_LETTER_NUMBER: Final = re.compile(r"([A-Z])\d+")
#: A word with a number that another digit follows.
_LAST_VALUE: Final = re.compile(r"(?<![A-Za-z_])[A-Za-z]\w*[ \t]*=?[ \t]*[-+]?(?:\d+\.?\d*|\.\d+)$")
#: Characters of a name that a control knows, so that a long one takes no time.
_LONGEST_NAME: Final = 40
_AXIS_OR_FEED: Final = re.compile(r"[ \t]*(?:[XYZABCIJKFS]=?[-+]?[\d.]|$)", re.IGNORECASE)
#: A block that is the end of a program without its M.
_END_WITHOUT_M: Final = re.compile(r"(?:N\d+[ \t]+)?(30|0?2|17)[ \t]*", re.IGNORECASE)
#: A number of a block, code, tool or edge with a sign.
_SIGNED_COUNT: Final = re.compile(r"([GMNTDR])[-+](\d+)(?![\w.])", re.IGNORECASE)
#: A number with its sign behind it.
_SIGN_BEHIND: Final = re.compile(r"(?<![A-Za-z_$])([XYZABCIJK])(\d++\.?\d*+|\.\d++)[-+](?:\s|$)", re.IGNORECASE)
#: A number in which a small L stands for 1, as far as the L.
_BEFORE_L: Final = re.compile(r"(?<![A-Za-z_])[A-Za-z]\w*=?[-+]?[\d.]+$")
#: A G function and an address that no blank divides, and a variable and a word.
_GLUED_CODE: Final = re.compile(r"([GMDTNSF]\d+)([A-Z]+\d?)")
#: A name, and another one behind a blank that may belong elsewhere.
_NAMES: Final = re.compile(r"([A-Z]\w*)(?:[ \t]+\w+)?", re.IGNORECASE)
_NO_VALUE: Final = re.compile(r"[ \t]+[A-Za-z_$]\w*[ \t]*=(?!=)")
#: A component of a tool axis without its =.
_VECTOR: Final = re.compile(r"([ABC]3)(\.\d+)(?![\w.])", re.IGNORECASE)
_VECTOR_BESIDE: Final = re.compile(r"(?<!\w)[ABC]3[ \t]*=", re.IGNORECASE)
_GLUED_WORD: Final = re.compile(r"(\w+?)([A-Z]\d+)")
#: Behind the = that stands before its address.
_AFTER_EQUALS: Final = re.compile(r"=[ \t]*([XYZABCIJKFS])(?=[-+.\w(])([^\s=]*)", re.IGNORECASE)
#: Two words of letters, with which a remark begins.
_WORDS: Final = re.compile(r"([A-Za-z]{2,}:?)[ \t]+(?:[-(&][ \t]*)?([A-Za-z]{2,})(?![\w=(\[]|[ \t]*[=(\[])")
#: Of CYCLE832; CYCLE83, which a digit may follow where its bracket is missing, has more.
_VALUES_OF_832: Final = 4
#: A word, and the blank that belongs behind the digit after it.
_WORD_BEFORE_DIGIT: Final = re.compile(r"([A-Z][-+]?\d+)[ \t]$", re.IGNORECASE)
#: A component of a tool axis, its sign, and the = that is missing between them, or stands behind the sign.
_SIGNED_VECTOR: Final = re.compile(r"([ABC]3)([-+])(=?)(\d+\.?\d*|\.\d+)(?![\w.])", re.IGNORECASE)
#: A number with a letter of the row below the digits on a keyboard; O looks like 0 itself.
_LETTER_OF_DIGIT: Final = re.compile(
    r"(?<![A-Z_$\d.=])([A-Z][-+]?)(\d{0,9}\.?\d{0,9})([QWERTYUIP])(\d{0,9}\.?\d{0,9})(?![\w.=(\[])", re.IGNORECASE
)
#: A radius as other languages write it, a word that it may be glued to, an arc, its end, its centre or radius.
_RADIUS: Final = re.compile(r"R[ \t]*=?[ \t]*([-+]?(?:\d++\.?\d*+|\.\d++))(?![\d_.]|[ \t]*[-+*/=(\[])", re.IGNORECASE)
_WORD_BEFORE: Final = re.compile(r"[A-Z][-+]?[\d.]{1,20}$", re.IGNORECASE)
_MOTION: Final = re.compile(r"(?<![A-Z_$\d])G0?[0-3](?![\d.])", re.IGNORECASE)
_END_OF_ARC: Final = re.compile(r"(?<![A-Z_$])[XYZ][ \t]*[-+.\d=]", re.IGNORECASE)
_CENTRE: Final = re.compile(r"(?<![A-Z_$])(?:[IJK][ \t]*[-+.\d=]|(?:[IJK]1|[CA]R|[AR]P)[ \t]*=)", re.IGNORECASE)
#: Statements before a name.
HEADS: Final = ("IF", "WHILE", "UNTIL", "FOR", "GOTO", "GOTOF", "GOTOB", "GOTOC", "MCALL", "DEF")
#: Letters whose keys are beside that of G.
_BESIDE_G: Final = "BFHTVY"
#: Letters of a name that others may be glued to.
_LEAST: Final = 3


def refuse_no_word(cursor: Cursor, at: int, is_variable: Callable[[str], bool]) -> ProgramError:
    """The error of what begins with no letter."""
    text, rest = cursor.text, cursor.text[at:]
    before = text[:at].rstrip()
    last = _LAST_WORD.search(before)
    if rest[0] in ")]":
        edits: tuple[Remedy, ...] = (Remedy(f"take {rest[0]} out", misspelt=rest[0], is_choice=True),)
        return cursor.error("VP001", f"{rest[0]} closes no bracket; take it out", at, edits)
    if rest[0] == '"':
        edits = (Remedy("take the quote out", misspelt='"', is_choice=True),)
        return cursor.error("VP001", "a quote too many; take it out", at, edits)
    swapped_word = _SWAPPED_WORD.match(text, at)
    if swapped_word is not None and (swapped_word[2].upper() in ADDRESSES or swapped_word[2].upper() in "GMN"):
        right = f"{swapped_word[2]}{swapped_word[1]}{swapped_word[3]}"
        if not right.endswith(("+", "-")):
            word = _WORD_BEFORE_DIGIT.search(text[:at])
            value = re.compile(r"[-+]?\d*\.?\d*").match(text, swapped_word.end() - len(swapped_word[3]))
            is_moved = swapped_word[1] == "0" if swapped_word[3] else swapped_word[1].isdigit()
            if word is not None and is_moved and value is not None and value[0].strip("+-."):
                return _refuse_moved_blank(cursor, word, swapped_word, value[0])
            text = f"{swapped_word[0]}: the letter stands before its number; "
            if swapped_word[2].upper() in "GM":  # 2G0 may be G0 behind a number without its letter
                edits = (Remedy(f"write {right}", right, misspelt=swapped_word[0], is_choice=True),)
                return cursor.error("VP001", f"{text}{right}{MAY_BE_MEANT}", at, edits)
            return cursor.error("VP001", f"{text}did you mean {right}?", at)
    number = NUMBER.match(text, at)
    if number is not None and (end := _END_WITHOUT_M.fullmatch(text)) is not None and end.start(1) == at:
        edits = (Remedy(f"write M{end[1]}", f"M{end[1]}", misspelt=end[1], is_choice=True),)
        text = f"{end[1]}: the letter before this number is missing; {_suggest_word(f'M{end[1]}')}"
        return cursor.error("VP001", text, at, edits)
    if number is None and (error := explain_equals(cursor, at, is_variable)) is not None:
        return error
    vector = _SIGNED_VECTOR.match(text, max(at - 2, 0))
    if vector is not None and vector.start(2) == at:
        if not vector[3]:
            return refuse_lost_equals(cursor, vector.start(), vector[1], vector[0])
        meaning = f"the = stands before the sign; did you mean {vector[1]}={vector[2]}{vector[4]}?"
        return cursor.error("VP001", f"{vector[0]}: {meaning}", vector.start())
    sign_behind = _SIGN_BEHIND.search(text[: at + 2]) if rest[0] in "+-" else None
    if sign_behind is not None:
        right = f"{sign_behind[1]}{rest[0]}{sign_behind[2]}"
        written_text = sign_behind[0].rstrip()
        edits = (Remedy(f"write {right}", right, misspelt=written_text, is_choice=True),)
        message = f"{written_text}: the sign stands after its number; {right}{MAY_BE_MEANT}"
        return cursor.error("VP001", message, sign_behind.start(), edits)
    if rest[0] in "+-" and (signed_number := NUMBER.match(text, at + 1)) is not None:
        return cursor.error("VP001", f"{rest[0]}{signed_number[0]}: the letter before this number is missing", at)
    if number is None:
        return cursor.error("VP001", f"{rest[0]!r} does not begin a word; expected a name or a letter and a number", at)
    message = f"{number[0]}: the letter before this number is missing"
    value = _LAST_VALUE.search(before)
    code = f"{'R' if text[number.end() :].lstrip().startswith('=') else 'G'}{number[0]}"
    is_known = (
        code in GROUP_OF or code in NO_EFFECT or (code[0] == "R" and number[0].isdigit())
    ) and f" {code} " not in f"{text.upper()} "
    edits = write_words(number[0], code, is_choice=True) if is_known else ()
    if last is None and value is None and not _AXIS_OR_FEED.match(text, number.end()) and not is_known:
        if len(number[0]) == 1:
            return cursor.error("VP001", message, at)
        return cursor.error("VP001", f"{number[0]}: a block number begins with N; did you mean N{number[0]}?", at)
    if last is None and value is None:
        # in 30 F1200 an axis may have lost its letter
        letters = ("R" if code[0] == "R" else "GN") if is_known else "NXYZ" if len(number[0]) > 1 else ""
        rights = [f"{letter}{number[0]}" for letter in letters if letter in "GR" or letter not in text.upper()]
        edits = write_words(number[0], *rights, is_choice=True)
        return cursor.error("VP001", f"{message}, such as {' or '.join(rights)}" if rights else message, at, edits)
    if last is not None and len(last[0]) > 1 and not last[0].endswith("1") and last[0].upper() in ADDRESSES:
        written_text, right = text[last.start() : number.end()], f"{last[0]}={number[0]}"
        return cursor.error("VP001", f"{written_text}: an = is missing; did you mean {right}?", last.start())
    if edits:
        message += f", such as {code}"
    if value is None or text[len(before)] not in " \t":
        return cursor.error("VP001", message, at, edits)
    right, written_text = f"{value[0]}{number[0]}", text[value.start() : number.end()]
    is_code = right[0] in "Gg" and f"G{right[1:]}" not in (*GROUP_OF, *NO_EFFECT)
    if is_code or re.search(r"(?<![\d.])0$", value[0]):
        return cursor.error("VP001", message, at, edits)
    if right[0] in "Nn" and (name := NAME.match(text, number.end())) is not None and number[0].isdigit():
        written_text, right = f"{written_text}{name[0]}", f"{right} {name[0]}"
        message = f"{written_text}: a blank and a digit have changed places; did you mean {right}?"
        return cursor.error("VP001", message, value.start())
    if right[0] not in "NSFnsf":  # else what the number was would be lost
        edits = (*edits, Remedy(f"write {right}", right, misspelt=written_text, is_choice=True))
    return cursor.error("VP001", f"{message}; write it, or {right} if the blank is too many", at, edits)


def refuse_lost_equals(cursor: Cursor, at: int, name: str, wrong: str) -> ProgramError:
    """The error of a name and its value without =, as CR-8: the - may be the key beside that of the =, or a sign."""
    name, value = wrong[: len(name)], wrong[len(name) :].lstrip()
    rights = [f"{name}={value}"]
    if value[0] == "-":
        rights.insert(0, f"{name}={value[1:].lstrip()}")
    meaning = f"did you mean {rights[0]}?" if len(rights) == 1 else f"{' or '.join(rights)}{MAY_BE_MEANT}"
    return cursor.error("VP001", f"{wrong}: an = is missing; {meaning}", at, write_words(wrong, *rights))


def _refuse_moved_blank(cursor: Cursor, word: re.Match[str], swapped_word: re.Match[str], value: str) -> ProgramError:
    """The error of N4 0S3000: the blank and the 0 have changed places; in S120 0M3 the 0 may be that of M03, too."""
    letter, digit = swapped_word[2], swapped_word[1]
    written_text, right = f"{word[0]}{digit}{letter}{value}", f"{word[1]}{digit} {letter}{value}"
    if letter.upper() not in "GMTD" or digit != "0":
        text = f"{written_text}: a blank and a digit have changed places; did you mean {right}?"
        return cursor.error("VP001", text, word.start())
    other = f"{word[0]}{letter}{digit}{value}"
    edits = tuple(Remedy(f"write {one}", one, misspelt=written_text, is_choice=True) for one in (right, other))
    text = f"{written_text}: two characters have changed places; {right} or {other}{MAY_BE_MEANT}"
    return cursor.error("VP001", text, word.start(), edits)


def refuse_no_value(cursor: Cursor, name: str, at: int) -> None:
    """Refuse an = that the next word follows, as R1= R2=3."""
    if _NO_VALUE.match(cursor.text, cursor.at):
        raise cursor.error("VP001", f"{name}=: the value after = is missing; write it", at)


def _suggest_word(word: str) -> str:
    """Words after which ``word`` is executed, unless other moves or the end depend on it."""
    is_grave = word.upper() in OF_ALL_MOVES or word[:1] in "Mm"
    return f"{word}{MAY_BE_MEANT}" if is_grave else f"did you mean {word}?"


def explain_signed_count(cursor: Cursor, at: int) -> str:
    """The message about a whole number with a sign, as N-8, or a vector without =; empty for other words."""
    vector = _VECTOR.match(cursor.text, at)
    if vector is not None and _VECTOR_BESIDE.search(cursor.text):
        return f"{vector[0]}: an = is missing; did you mean {vector[1]}={vector[2]}?"
    match = _SIGNED_COUNT.match(cursor.text, at)
    return (
        ""
        if match is None
        else f"{match[0]}: a number after {match[1].upper()} has no sign; {_suggest_word(f'{match[1]}{match[2]}')}"
    )


def refuse_r(cursor: Cursor, at: int) -> ProgramError:
    """The error of an R without its number, which may stand before it: 1R."""
    if divided_word := re.match(r"R[ \t]+(\d+)(?=[ \t]*=)", cursor.text[at:], re.IGNORECASE):
        text = f"{divided_word[0]}: a blank is in the word; did you mean R{divided_word[1]}?"
        return cursor.error("VP001", text, at)
    digits = re.search(r"(?<![\w.])\d+$", cursor.text[:at])
    if digits is None or cursor.text[at + 1 : at + 2].isdigit():
        return cursor.error("VP001", "R without a number; write R and the number of the parameter", at)
    text = f"{digits[0]}R: the letter stands before its number; did you mean R{digits[0]}?"
    return cursor.error("VP001", text, digits.start())


def refuse_l(cursor: Cursor, at: int) -> ProgramError | None:
    """The error of N1l0, in which L0 would be a word; None where the L begins a word, as in n10l20."""
    match, digits = _BEFORE_L.search(cursor.text[:at]), NUMBER.match(cursor.text, at + 1)
    rest = cursor.text[at + 1 : at + 2].strip("(;, \t") if digits is None else digits[0]
    if cursor.text[at] != "l" or match is None or (rest and not re.search("[A-Z]", cursor.text)):
        return None
    written_text = f"{match[0]}l{rest}"
    message = f"{written_text}: the letter l in a number; did you mean {match[0]}1{rest}?"
    return cursor.error("VP001", message, match.start())


def explain_equals(cursor: Cursor, at: int, is_variable: Callable[[str], bool]) -> ProgramError | None:
    """The error of an = before its address, which stands behind a blank: G1 =ZDEPTH; None for others."""
    match = _AFTER_EQUALS.match(cursor.text, at)
    if match is None or cursor.text[at - 1] not in " \t":
        return None
    address, value = match.groups()
    name, rest = NAME.match(f"{address}{value}"), NAME.match(value)
    if name is not None and rest is not None and is_variable(name[0].upper()):
        if is_variable(rest[0].upper()):
            text = f"{match[0]}: no address stands before the =; write {address}={address}{value} or {address}={value}"
            return cursor.error("VP001", text, at)
        text = f"{match[0]}: no address stands before the =; did you mean {address}={address}{value}?"
        return cursor.error("VP001", text, at)
    text = f"{match[0]}: the = stands before its address; did you mean {address}={value}?"
    return cursor.error("VP001", text, at)


def explain_glued(name: str, text: str, at: int, is_variable: Callable[[str], bool]) -> str:
    """The message about two words that lack a blank or an = between them, as G0Z and ZDEPTH; empty for others."""
    written_text = text[at : at + len(name)]
    rest = text[at + len(name) :].lstrip(" \t")
    if (
        (match := _GLUED_CODE.fullmatch(name)) is not None
        and (match[2] in ADDRESSES or is_variable(match[2]))
        and rest[:1] == "="
    ):
        end = match.end(1)
        return f"{written_text}: a blank is missing; did you mean {written_text[:end]} {written_text[end:]}?"
    for end in range(min(len(name) - 1, _LONGEST_NAME), 1, -1) if not rest.startswith(("(", "=")) else ():
        if is_variable(name[:end]) and name[0] != "R" and (name[end:].isdigit() or is_variable(name[end:])):
            return f"{written_text}: an = is missing; did you mean {written_text[:end]}={written_text[end:]}?"
    letters = name.rstrip("0123456789")
    for end in range(1, min(len(name), _LONGEST_NAME)) if letters == name or letters not in ADDRESSES else ():
        value = name[end:]
        is_value = is_variable(value) if not rest.startswith(("(", "=")) else value in VALUE_MODES and rest[0] == "("
        if is_value and value != "R" and name[:end] in ADDRESSES:
            return f"{written_text}: an = is missing; did you mean {written_text[:end]}={written_text[end:]}?"
    return ""


def explain_moved_blank(text: str, at: int, heads: Iterable[str], is_operand: Callable[[str, str], bool]) -> str:
    """The message about one of ``heads`` and its operand whose blank is missing, or one place too far; else empty."""
    match = _NAMES.match(text, at)
    if match is None or len(match[0]) > _LONGEST_NAME:
        return ""
    for written_text in dict.fromkeys((match[1], match[0])):
        names = "".join(written_text.split())
        for head in sorted(heads, key=len, reverse=True):
            operand = names[len(head) :]
            is_moved = operand and names.upper().startswith(head) and match[1].upper() != head
            if is_moved and is_operand(head, operand.upper()):
                what = "a blank is missing" if written_text == names else "the blank is in the wrong place"
                return f"{written_text}: {what}; did you mean {names[: len(head)]} {operand}?"
    return ""


def explain_glued_value(name: str, text: str, at: int, is_variable: Callable[[str], bool]) -> str:
    """The message about a variable and the word after it, without a blank: R2F300; empty for other names."""
    match = _GLUED_WORD.fullmatch(name)
    if match is None or match[2][0] not in ADDRESSES or not is_variable(match[1]):
        return ""
    written_text, end = text[at : at + len(name)], match.end(1)
    return f"{written_text}: a blank is missing; did you mean {written_text[:end]} {written_text[end:]}?"


def find_letter_of_digit(cursor: Cursor, at: int) -> ProgramError | None:
    """The error of a number with a letter whose key is below that of a digit, as YQ0 and X2w.5; None for others.

    A name of two letters alone in its block may be a subprogram.
    """
    for match in _LETTER_OF_DIGIT.finditer(cursor.text, max(at - _LONGEST_NAME, 0), at + _LONGEST_NAME):
        letter = match[1][0].upper()
        has_digit = bool((match[2] + match[4]).strip("."))
        is_beside = match[3].islower() and letter == match[1][0]
        if not match.start() <= at < match.end() or letter not in (*ADDRESSES, "G", "M", "N"):
            continue
        if not match[2] and f"{match[1]}{match[3]}".upper() in ADDRESSES:  # CR10
            continue
        if has_digit or is_beside or re.search(r"[A-Z]\d", cursor.text[match.end() :], re.IGNORECASE):
            right = f"{match[1]}{match[2]}{match[3].upper().translate(DIGITS_OF_KEYS)}{match[4]}"
            error = cursor.error("VP001", f"{match[0]}: the letter {match[3]} in a number", match.start())
            return propose_key_beside(error, match[0], right)
    return None


def propose_key_beside(error: ProgramError, wrong: str, right: str) -> ProgramError:
    """An error of a word that may be meant for another one, by the key beside that of one of its characters."""
    error.message += f"; {right}{MAY_BE_MEANT}, whose key is beside"
    error.edits += (Remedy(f"write {right}", right, misspelt=wrong, is_choice=True),)
    return error


def find_radius(cursor: Cursor, at: int, is_set: Callable[[str], bool], motion: str) -> ProgramError | None:
    """The error of R5 in an arc without a centre, as other languages write its radius; None for others.

    ``motion`` is in force before the block.
    """
    word, block = _RADIUS.match(cursor.text, at), _TEXT.sub("", cursor.text)
    if word is None or _CENTRE.search(block) or _END_OF_ARC.search(block) is None:
        return None
    if [motion, *_MOTION.findall(block)][-1][-1:] not in ("2", "3"):
        return None
    before = _WORD_BEFORE.search(cursor.text[max(at - _LONGEST_NAME, 0) : at])
    word_before, blank = ("", "") if before is None else (before[0], " ")
    written_text = f"{word_before}{word[0]}"
    values = (word[1], word[0]) if is_set(word[0].upper()) else (word[1],)
    rights = [f"{word_before}{blank}CR={value}" for value in values]
    meaning = f"did you mean {rights[0]}?" if len(rights) == 1 else f"{' or '.join(rights)}{MAY_BE_MEANT}"
    edits = tuple(Remedy(f"write {one}", one, misspelt=written_text, is_choice=len(rights) > 1) for one in rights)
    text = f"{written_text}: the radius of an arc is CR= in this language; {meaning}"
    return cursor.error("VP001", text, at - len(word_before), edits)


def propose_feed(error: ProgramError, cursor: Cursor, at: int) -> None:
    """Say in the error of R300 without a value that it may be F300, unless the block has an F."""
    word = re.compile(r"R(\d+)(?=[ \t]*(?:$|[A-Z]))", re.IGNORECASE).match(cursor.text, at)
    if word is not None and word[1].strip("0") and "F" not in cursor.text.upper():
        error.edits = ()
        propose_key_beside(error, word[0], f"F{word[1]}")


def propose_code(error: ProgramError, name: str, value: float, column: int) -> None:
    """Say in the error of a motion without F (VP009) that its only place, as Y54, may be a G function."""
    code = f"G{value:g}"
    if error.code == "VP009" and name in _BESIDE_G and code in (*GROUP_OF, *NO_EFFECT):
        wrong, error.column = f"{name}{value:g}", column
        error.message = f"{wrong}: {code}{MAY_BE_MEANT}, whose key is beside; as it stands: {error.message}"
        error.edits = (Remedy(f"write {code}", code, misspelt=wrong, is_choice=True),)


def refuse_remark(cursor: Cursor, at: int) -> ProgramError | None:
    """The error of words that are a remark without its ;, which begin a block; None where they may be another slip."""
    head = re.sub(r"^[ \t]*(?:N\d+[ \t]*)?", "", cursor.text[:at], flags=re.IGNORECASE)
    begin = at - len(head)
    if head and not re.fullmatch(r"[A-Za-z]\w*[ \t]*:[ \t]*", head):
        return None
    match = _WORDS.match(cursor.text, begin)
    if match is None:
        return None
    is_type = match[2].upper() in TYPES and not head and _NEXT.match(cursor.text, match.end()) is not None
    if is_type and find_meant(match[0].upper(), [f"DEF {match[2]}".upper()], slip_alone=True):
        return cursor.error("VP001", f"{match[1]}: no meaning in this language; did you mean DEF?", begin)
    tables = (GROUP_OF, NO_EFFECT, STATEMENTS, CYCLES, ADDRESSES)
    if any(one.upper() in table for one in match.groups() for table in tables):
        return None
    edits = (Remedy("write ;", f";{match[0]}", misspelt=match[0], is_choice=True),)
    text = f"{match[0]}: no words of this language; a remark begins with ;, as ;{match[0]}"
    return cursor.error("VP001", text, begin, edits)


def find_lost_bracket(cursor: Cursor, at: int, is_subprogram: Callable[[str], bool]) -> ProgramError | None:
    """The error of a call whose opening bracket is missing, as CYCLE823,0,3); None for other words."""
    rest = cursor.text[at:]
    code = _TEXT.sub("", rest)
    name = NAME.match(rest)
    if name is None or code.count(")") != code.count("(") + 1:
        return None
    ends = range(min(name.end(), _LONGEST_NAME), 1, -1)
    for end in sorted(ends, key=lambda end: not is_subprogram(rest[:end].upper())):  # SLOT of the program before SLOT1
        known_name = rest[:end].upper()
        value = rest[end:].lstrip(" \t")
        if known_name == "CYCLE832" and value.count(",") >= _VALUES_OF_832:
            continue  # CYCLE83 and its first value
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
        is_label = text[following.end() :].strip() == ":"
        if is_label or any(whole in known_name for known_name in words) or is_subprogram(whole):
            return f"{written_text}{following[0]}: a blank is in the word; did you mean {written_text}{following[1]}?"
    for end in range(min(len(name) - 1, _LONGEST_NAME), _LEAST - 1, -1):
        if not any(name[:end] in known_name for known_name in words[:3]):
            continue
        address, following_word = _LETTER_NUMBER.fullmatch(name[end:]), name[end:]
        is_word = address is not None and address[1] in (*ADDRESSES, "G", "M")
        if is_word or any(following_word in known_name for known_name in words):
            return f"{written_text}: a blank is missing; did you mean {written_text[:end]} {written_text[end:]}?"
    return ""


def explain_function(name: str) -> str:
    """The message about a function that stands where a word begins; empty for other names."""
    return f"{name}() is a function of a value; the operator or = before it is missing" if name in FUNCTIONS else ""
