"""What a word or number that cannot be read was meant for, in every language: a slip of whoever typed it.

A message that knows it begins with what is written, and ends with what is meant: "TRAOIR: no meaning in this language;
did you mean TRAORI?". Editors change the one into the other, and a language goes on as if the latter were written.
"""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from typing import Final

from verne_post.base.long_text import Text, take_line
from verne_post.base.pasted import OF_PROGRAMS, explain_pasted, name_meant, name_pasted, translate_pasted
from verne_post.base.program_lines import remove_remarks
from verne_post.base.suggestions import MAY_BE_MEANT, find_correction, find_meant
from verne_post.gcode.block_slips import explain_function, explain_slip, propose_words
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.text import decode_line
from verne_post.model.findings import Finding, Remedy

#: An address, and a number that has the letter O, or a comma with digits on both sides.
_LETTER_O: Final = re.compile(
    r"(?<![A-Z_])((?:[A-Z]{1,2}\d*[ \t]*=|[A-Z]{1,2}?)[ \t]*|[A-Z]{3}|)([-+]?(?=[\d.]*O)[\dO]*\.?[\dO]*)", re.IGNORECASE
)
_COMMA: Final = re.compile(
    r"(?<![A-Z\d.,])((?:[A-Z]{1,2}\d*[ \t]*=|[A-Z]{1,2})[ \t]*|)([-+]?\d+,\d+)(?![\d.,(])", re.IGNORECASE
)
#: A comma for the point before the first digit.
_COMMA_FIRST: Final = re.compile(
    r"(?<![A-Z\d.,(])(?<![(,][ \t])((?:[A-Z]{1,2}\d*[ \t]*=|[ABCEFIJKQRUVWXYZ])[ \t]*)([-+]?,\d+)(?![\d.,(])",
    re.IGNORECASE,
)
_ADDRESS: Final = r"(?<![A-Z_])((?:[A-Z]{1,2}\d*[ \t]*=|[A-Z]{1,2})[ \t]*)"
COMMA_BEHIND: Final = "a comma after a number"
_TWO_SIGNS: Final = "two signs before a number"
_BEFORE_LETTER: Final = "a digit before its letter"
_I_IN_NUMBER: Final = "the letter I in a number"
_AFTER_CODE: Final = "the letter O after the code"
#: Codes on which all moves behind them depend: nothing but their own digits is executed as one of them.
OF_ALL_MOVES: Final = ("G10", "G17", "G18", "G19", "G20", "G21", "G50", "G70", "G71", "G90", "G91")
#: An address with a number in which a character is too many: what it is, and the parts that stay.
_TOO_MANY: Final = (
    (re.compile(rf"{_ADDRESS}([-+]?\d+(?:\.\d*)?)(),(?![\d,])", re.IGNORECASE), COMMA_BEHIND),
    (re.compile(rf"{_ADDRESS}([-+]?\d*\.)\.+(\d*)(?![\d.])", re.IGNORECASE), "two points in a number"),
    (re.compile(rf"(?<![(,]){_ADDRESS}([-+]?\d*,),+(\d+)(?![\d.,)])", re.IGNORECASE), "two commas in a number"),
    (re.compile(rf"{_ADDRESS}[-+]([-+]\d+\.?)(\d*)(?![\d.])", re.IGNORECASE), _TWO_SIGNS),
)
#: A small L for 1: at the end of a number, where as an address it would have none, or at its beginning; Ql alone is Q1.
_LETTER_L: Final = re.compile(
    r"(?<![A-Za-z_])((?:Q[LR]?\d+[ \t]*=|[A-Z])[ \t]*)"
    r"((?:[-+]?\d+l(?![ \t]*[-+.\d#\[=])|[-+]?l[.\d]+|(?:(?<=[A-Z])|[-+])l(?![ \t]*[-+.\d#\[=]))(?![A-Za-z_,]))"
)
_Q_AND_L: Final = re.compile(r"(?<![A-Za-z_])((?:[A-Z][-+]?)?Q)(l)(?!\w)")
#: An address, and a small L and O that stand for 1 and 0, with no digit before them.
_LETTERS: Final = re.compile(r"(?<![A-Za-z_])([XYZABCFIJKR][ \t]*)([-+]?(?:lO[lO\d]*|ll[lO]*O))(?![\w])")
#: A value of an expression or a list that such letters begin, or end, as in R1=l0, 2*10l and SIN lO.
_VALUE: Final = re.compile(
    r"(?<=[=(\[,+\-*/^<> \t])(?<![ \t\d][XYZABCIJKUVW][-+])()((?=[\d.]*[lOo])[lOo\d]*\.?[lOo\d]*)(?![\w.(\[])"
)
_BEFORE_VALUE: Final = re.compile(
    r"[=(\[,+\-*/^<>]\s*\Z|\b(?:A?(?:SIN|COS|TAN)|SQ|SQRT|ABS|INT|FRAC|NEG|LN|LOG|EXP|DIV|MOD)\s+\Z"
)
#: Numbers with characters that look like a digit, or like the point: as soon as one fits, it says what is meant.
_ALIKE: Final = (_LETTER_O, _COMMA, _COMMA_FIRST, _LETTERS, _LETTER_L, _Q_AND_L, _VALUE)
MEANT_CHARACTERS: Final = str.maketrans({"O": "0", "o": "0", "l": "1", ",": "."})
#: The digits that letters in a number look like.
DIGITS_ALIKE: Final = str.maketrans("OolLSsBbZz", "0011558822")
#: A letter like a digit before a point that ends the number of an axis. Z and B may be words without a number.
_LETTER_BEFORE_POINT: Final = re.compile(
    r"(?<![A-Z_])([XYZABCIJKUVW][ \t]*(?:=[ \t]*)?)([-+]?\d+)([SL])\.(?![\w.])", re.IGNORECASE
)
#: G83O for G83: G codes of three digits are those of Siemens.
_LETTER_TOO_MANY: Final = re.compile(r"G[1-9]\d(?:\.\d)?O", re.IGNORECASE)
#: M8O where M80 has no meaning: those of one digit have one in every language.
_M_AND_LETTER: Final = re.compile(r"(M0?\d)O: the letter O in a number; did you mean M0?\d0\?", re.IGNORECASE)
_BEHIND_M: Final = "the letter O after the M code"
#: A letter twice before a number.
_TWICE: Final = re.compile(r"(?<![A-Z\d_])([A-Z])\1([-+]?(?:\d+\.?\d*|\.\d+)(?![\w.])|(?=[-+]?[#\[]))", re.IGNORECASE)
_NO_EQUALS: Final = "words have no ="
_SIGNED_WORD: Final = re.compile(r"[XYZABCUVWIJKQR]=\d.*", re.IGNORECASE)
_NO_MACRO_WORD: Final = "no word of custom macros"
#: Words of Fanuc whose numbers have a point as a rule.
_WITH_POINT: Final = re.compile(r"[ABCFIJKQRUVWXYZ][-+]?\d+", re.IGNORECASE)
_DIVIDED_NUMBER: Final = re.compile(r"(?<![A-Za-z_])[A-Z][-+]?\d+([lI])(?:\.\d*|\d+\.?\d*)(?![\w.])")
_NUMBER_WITH_POINT: Final = re.compile(rb"[XYZ][-+]?\d+\.", re.IGNORECASE)
#: A digit of a block number behind its blank.
_NUMBER_OF_BLOCK: Final = re.compile(r"^[ \t]*(N\d+)[ \t](\d+)([G#]|(?:END|WHILE|IF|GOTO)(?![A-Z]))", re.IGNORECASE)
#: In blocks of letters and numbers: the first digit before its letter, and a # before the letter.
_WRONG_ORDER: Final = (
    (
        re.compile(r"(?<![\w.\])#])(?<!\d\.[ \t])(\d)([A-Z])(\d*+\.?\d*+)(?![\w#\[])", re.IGNORECASE),
        _BEFORE_LETTER,
        r"\2\1\3",
    ),
    (re.compile(r"(#)(O\d+)(?=[ \t]*[A-Z]{2})", re.IGNORECASE), "an O word has no #", r"\2"),
    (
        re.compile(r"(?<![A-Z\[=+*/-])(#)(?![LI])([A-Z])(\d+)(?![\w.])", re.IGNORECASE),
        "the # before its letter",
        r"\2\1\3",
    ),
    (re.compile(r"(?<![\w#>])([A-Z])=([-+]?(?:\d+\.?\d*|\.\d+))(?![\w.])", re.IGNORECASE), _NO_EQUALS, r"\1\2"),
    (re.compile(r"(#)[lI](\d*)(?!\w)"), "a letter in a number", r"\g<1>1\2"),
    (re.compile(r"(?<=[\[ =+*/-])()[lI]()(?=[ \t]*\])"), "a letter in a number", "1"),
    (re.compile(r"(?<![A-Z_])([A-HJ-Z][-+]?)I(\d+\.?\d*)(?![\w.])", re.IGNORECASE), _I_IN_NUMBER, r"\g<1>1\2"),
    (
        re.compile(r"(?<![A-Z_])([A-HJ-Z#][-+]?\d+\.?\d*)I()(?![ \t]*[-+.\d#\[=])", re.IGNORECASE),
        _I_IN_NUMBER,
        r"\g<1>1",
    ),
    (
        re.compile(r"(?<![A-Z_])([A-HJ-Z][-+]?)I()(?=[ \t]*(?:[A-Z][-+.\d#]|[(;]|$))", re.IGNORECASE),
        _I_IN_NUMBER,
        r"\g<1>1",
    ),
    (re.compile(r"(#\d+)[lI](\d*)(?=[ \t]*(?:[-+*/\]]|=(?!=)))"), "a letter in a number", r"\g<1>1\2"),
    (
        re.compile(r"(?<![\w\]=\[*/+-])([-+])([A-Z])(\d+\.?\d*|\.\d+)(?![\w.])", re.IGNORECASE),
        "the sign before its letter",
        r"\2\1\3",
    ),
    (re.compile(r"(?<![A-Za-z_])([A-Z][-+]?\d+)I(\.)(?![\w.])"), "a letter in a number", r"\g<1>1\2"),
    (re.compile(r"(?<=[-+*/=])(\d+),(?=[ \t]*(?:[(;\]]|$))"), COMMA_BEHIND, r"\1."),
)
#: What follows a program number is read as a word of RS274/NGC.
_OF_RS274: Final = re.compile(r"(o\d+): expected sub, .*?(?:as in O\d+ \((\w+)\))?$")
_COMPARISONS: Final = ("EQ", "NE", "GT", "GE", "LT", "LE", "OR")
#: Words in capitals before a ``)``, in a line that has no ``(`` before them.
_REMARK: Final = re.compile(r"[^()]*?((?<![A-Z])[A-Z]{2}[^()]*)\)", re.IGNORECASE)
#: The letter of a number beside a code.
_LETTER_OF_CODE: Final = {"4": "P", "41": "D", "42": "D", "43": "H", "43.4": "H", "43.5": "H", "54.1": "P", "65": "P"}
#: A whole number at the beginning of a line.
_FIRST_WORD: Final = re.compile(r"[ \t]*([ABHM](\d+))(?![\d.])(?=[ \t]*[A-Z])", re.IGNORECASE)
#: A G code, and a number behind a blank.
_WITHOUT_LETTER: Final = re.compile(r"(G[ \t]*\d+(?:\.\d)?)[ \t]+(\d+\.?\d*|\.\d+)(?![A-Z\d.])", re.IGNORECASE)
_CHANGED_BEHIND_CODE: Final = re.compile(r"[GM]\d+(?:\.\d)?[ \t]+(\d)([A-Z])(\d*+\.?\d*+)(?!\w)", re.IGNORECASE)
_NUMBER_WITH_I: Final = re.compile(r"N\d*I\d+(?!\S)", re.IGNORECASE)
_BLOCKS: Final = ("", "rs274", "fanuc")
#: Characters of such a word, so that long lines of digits take no time.
_LONGEST: Final = 40
#: Letters after which an O alone is a zero: GO, XO. After others it is a word, such as DO and TO.
_BEFORE_ZERO: Final = (*"ABCFGHIJKMPQRSXYZ", "SPA", "SPB", "SPC", "ROT")
#: A small L for 1 in the number of a variable, before a sign: with what follows it is taken for a word L.
_VARIABLE_WITH_L: Final = re.compile(r"#\d+l(?=[ \t]*[-+])")
_FOR: Final = re.compile(r"\bFOR\b.*=", re.IGNORECASE)
#: A text that is closed.
_TEXT: Final = re.compile(r'"[^"]*"')
#: A text that another quote closes.
_OTHER_QUOTE: Final = re.compile(r"(\"[^\"']*)'+")
#: The next word begins: behind a blank, or a letter behind a number.
_NEXT_WORD: Final = re.compile(r"[ \t]\S|[\d.][A-Za-z]")
#: A call that a remark cuts off: ; in place of a comma.
_OPEN_BRACKET: Final = "the bracket is not closed on its line"
#: ``9PART A)``; the keys of % and beside it, with shift or without.
_KEY_OF_BRACKET: Final = re.compile(r"[ \t]*([89][A-Z]{2}[^()]*\))", re.IGNORECASE)
_WORDS_ALONE: Final = re.compile(r"[ \t]*([A-Z]{3,}(?:[ \t]+[A-Z]+)*)[ \t\r]*", re.IGNORECASE)
_KEYS_BESIDE_PERCENT: Final = ("5", "$", "^")
#: A semicolon up to the next bracket; group 1 where that closes.
_CLOSED_IN_REMARK: Final = re.compile(r";[^()]*+(\))?")
#: A rotary axis of a compensated contour, its number, and the linear axis whose key is beside its own.
_TURN_ON_CONTOUR: Final = re.compile(r"^[ABC] turns under|turn of the table under cutter compensation")
#: A turn in a program without TRAORI, and angles of a program but for 0.
_LONE_TURN: Final = "turn at a feed rate without TRAORI:"
_ANGLE: Final = re.compile(rb"(?<![A-Z_$])[ABC][ \t]*=?[ \t]*[-+]?[0.]*[1-9]|(?<![A-Z_])TRAORI(?![A-Z])", re.IGNORECASE)
_ROTARY_WORD: Final = re.compile(r"(?<![A-Z_#<])([AC])([-+]?(?:\d+\.?\d*|\.\d+))(?![\w.])", re.IGNORECASE)
_KEYS_OF_ROTARY: Final = {"A": "Z", "C": "X"}
#: Slips of one line that are corrected.
_MOST_SLIPS: Final = 20
#: Errors of text that cannot be read.
UNREADABLE: Final = ("VP001", "VP002")


def explain_unknown(message: str, word: str, *known_words: Iterable[str]) -> str:
    """What is wrong with a word that a language does not know: ``message``, or what is meant.

    That is a word of ``known_words`` which is a slip away; of those, words that are likelier come first.
    """
    near = find_meant(word, *known_words, slip_alone=True)
    return f"{word}: no meaning in this language; did you mean {near}?" if near else message


def correct_line(text: str, error: ProgramError) -> str | None:
    """A line with the word or number that is meant in place of the mistyped one; None for other errors.

    A language executes it, so that nothing is reported that only follows from the mistake.
    """
    if error.column is None or error.line is not None:
        return None
    if find_correction(error.message) is None:
        return correct_number(text, error, "siemens")  # whose remarks are those of Klartext, too
    return correct_word(text, error)


def drop_letter(message: str) -> str:
    """What is meant by M8O where M80, which its message says, has no meaning: M8."""
    match = _M_AND_LETTER.fullmatch(message)
    return message if match is None else f"{match[1]}O: {_BEHIND_M}; did you mean {match[1]}?"


def correct_word(text: str, error: ProgramError) -> str | None:
    """A line with the word that the error says is meant; None where it says none."""
    correction = find_correction(error.message)
    if correction is None or error.column is None or error.column < 1 or correction[0].upper() == correction[1].upper():
        return None
    begin = error.column - 1
    end = begin + len(correction[0])
    return text[:begin] + correction[1] + text[end:] if text[begin:end].upper() == correction[0].upper() else None


def execute_as_meant(
    text: str,
    give_up: Callable[[], None],
    execute: Callable[[str], None],
    correct: Callable[[str, ProgramError], str | None],
) -> tuple[list[ProgramError], str | None]:
    """Execute a line; where a word of it is mistyped, again with the one that is meant.

    Returns its errors, with the columns of the line as it stands, and the line whose last error was raised and could
    not be corrected; None where it was executed. No line is tried twice: two words may each be taken for the other.
    Nor is one of many slips tried for each of them.
    Before any error is looked at, ``give_up`` is called.
    """
    errors: list[ProgramError] = []
    earlier_texts = [text.upper()]
    rest: str | None = None
    while True:
        try:
            execute(text)
            break
        except ProgramError as error:
            give_up()
            errors.append(error)
            corrected_text = correct(text, error)
            if corrected_text is None or corrected_text.upper() in earlier_texts or len(errors) > _MOST_SLIPS:
                rest = text
                break
            text = corrected_text
            earlier_texts.append(text.upper())
    for number in reversed(range(len(earlier_texts) - 1)):
        shift_back(errors[number], errors[number + 1 :])
    return errors, rest


def shift_back(corrected_error: ProgramError, later_errors: Iterable[ProgramError]) -> None:
    """Put columns of a corrected line where they are in the line as it stands."""
    correction = find_correction(corrected_error.message)
    if correction is None or corrected_error.column is None:
        return
    for error in later_errors:
        if error.line is None and error.column is not None and error.column > corrected_error.column:
            error.column -= len(correction[1]) - len(correction[0])


def say_what_is_meant(
    source: Text, errors: Sequence[Finding], dialect: str, called_texts: Mapping[str, Text]
) -> list[Finding]:
    """Errors, of which those about a letter O or a comma in a number, or a letter twice, say what is meant, once.

    Where a message knows what is meant by the word at its column, that is an edit of the error.
    """
    found = [_say_what_is_meant(source, item, dialect) for item in errors]
    for at, item in enumerate(found):
        text = None if item.called is None else called_texts.get(item.called.file)
        if text is not None and (correction := find_correction(item.message)):
            text = b"\n".join((text[:], source[:]))
            found[at] = replace(item, message=_add_point(text, item.message, correction[1], dialect))
    return list(dict.fromkeys(found))


def _find_pasted(text: str, error: ProgramError | Finding, dialect: str) -> tuple[str, int] | None:
    """A character of mail or PDF at or beside the word that cannot be read, and where it stands."""
    if error.code not in UNREADABLE or error.column is None or text.isascii():
        return None
    begin = max(error.column - 2, 0)
    paste = OF_PROGRAMS.search(remove_remarks(text, dialect), begin)
    if paste is None or _NEXT_WORD.search(text, begin + 1, paste.start() + 1):
        return None
    return paste[0], paste.start()


def _name_linear_axis(item: Finding, text: str) -> Finding:
    """A turn on a compensated contour: the linear axis whose key is beside may be meant, and G40 is a choice too."""
    words = [(*match.groups(), _KEYS_OF_ROTARY[match[1].upper()]) for match in _ROTARY_WORD.finditer(text)]
    rights = {f"{near}{number}": f"{letter}{number}" for letter, number, near in words if near not in text.upper()}
    if not rights:
        return item
    edits = [edit for one, wrong in rights.items() for edit in propose_words(item, wrong, [one])]
    edits += [replace(one, is_choice=True) for one in item.edits]
    return replace(
        item, message=f"{item.message}; or {' or '.join(rights)}, if the key beside is meant", edits=tuple(edits)
    )


def _name_slip_of_mark(source: Text, item: Finding, text: str) -> Finding | None:
    """A bracket of a comment that is there twice, or is the digit of its key; another key for the % of line 1."""
    at, wrong, right = (item.column or 1) - 1, "", ""
    if (bracket_pair := text[at - 1 : at + 1]) in ("((", "))") and at:
        at, wrong, right, why = at - 1, bracket_pair, bracket_pair[0], f"the {bracket_pair[0]} is there twice"
    elif (key := _KEY_OF_BRACKET.match(text)) is not None and at == key.start(1):
        wrong, right, why = key[1], f"({key[1][1:]}", "the digit on the key of the ("
    elif item.line == 1 and text.strip() in _KEYS_BESIDE_PERCENT and bytes(source).rstrip().endswith(b"\n%"):
        wrong, right, why = text.strip(), "%", "a program that ends with % begins with one"
    elif " needs a number, found" in item.message and (words := _WORDS_ALONE.fullmatch(text)) is not None:
        message = f"{words[1]}: words without numbers; write ({words[1]}) if they are a comment"
        edit = Remedy(f"write ({words[1]})", f"({words[1]})", line=item.line or 0, misspelt=words[1], is_choice=True)
        return replace(item, message=message, column=words.start(1) + 1, edits=(edit,))
    if not wrong:
        return None
    edits = (Remedy(f"write {right}", right, line=item.line or 0, misspelt=wrong),)
    return replace(item, message=f"{wrong}: {why}; did you mean {right}?", column=at + 1, edits=edits)


def _has_lone_turn(source: Text) -> bool:
    """Whether one word alone turns a rotary axis of a program without TRAORI."""
    return sum(1 for _one in islice(_ANGLE.finditer(source), 2)) == 1


def _say_what_is_meant(source: Text, item: Finding, dialect: str) -> Finding:
    raw = None if item.line is None else take_line(source, item.line)
    text = "" if raw is None else decode_line(raw)
    if (item.code in ("VP017", "VP026") and dialect in _BLOCKS and _TURN_ON_CONTOUR.search(item.message)) or (
        item.code == "VP017" and dialect == "siemens" and _LONE_TURN in item.message and _has_lone_turn(source)
    ):
        return _name_linear_axis(item, remove_remarks(text, dialect))
    if item.code == "VP002" and (function := explain_function(source, text, item)) is not None:
        return function
    slip = explain_slip(source, text, item, dialect) if dialect in _BLOCKS and text else None
    if slip is not None and slip.edits:
        return slip
    item = slip or item
    if item.line is None or item.column is None:
        return item
    if item.code == "VP001" and dialect in _BLOCKS and (mark := _name_slip_of_mark(source, item, text)) is not None:
        return mark
    if (paste := _find_pasted(text, item, dialect)) is not None:
        character, begin = paste
        code = remove_remarks(text, dialect)[begin:]
        wrong = code[: max((one.end() for one in OF_PROGRAMS.finditer(code)), default=0)]
        title = f"write {name_meant(character)} in place of {name_pasted(character)}"
        edit = Remedy(title, translate_pasted(wrong), line=item.line, misspelt=wrong)
        return replace(
            item, code="VP001", message=explain_pasted(character), column=begin + 1, edits=(edit,) if wrong else ()
        )
    if item.code == "VP002" and dialect in _BLOCKS and (match := _CHANGED_BEHIND_CODE.match(text, item.column - 1)):
        right = f"{match[2]}{match[1]}{match[3]}"
        wrong, column = f"{match[1]}{match[2]}{match[3]}", match.start(1) + 1
        edits = propose_words(item, wrong, [right])
        message = f"{wrong}: a digit before its letter; {right}{MAY_BE_MEANT}"
        return replace(item, code="VP001", message=message, column=column, edits=edits, settled_by=())
    if item.code == "VP002" and dialect in _BLOCKS and (match := _WITHOUT_LETTER.match(text, item.column - 1)):
        code, number = match[1].upper(), match[2]
        is_dwell = code.lstrip("G 0") == "4"
        letter = _LETTER_OF_CODE.get(code.lstrip("G 0"), "G" if number.isdigit() else "X")
        right = f"{match[1]} {letter}{number}"
        message = (
            f"{match[0]}: blanks mean nothing in a number, so that this is {''.join(match[0].split())}; "
            f"{number} may lack its letter, such as {letter}{number}{', the time of G4' if is_dwell else ''}"
        )
        edits = propose_words(item, match[0], [right])
        return replace(item, code="VP001", message=message, edits=edits, settled_by=())
    if item.message.startswith(_OPEN_BRACKET):
        remarks = _CLOSED_IN_REMARK.finditer(text, item.column)
        if (remark := next((one for one in remarks if one[1]), None)) is not None:
            edit = Remedy("write ,", ",", line=item.line, misspelt=";")
            message = "; begins a remark, and the bracket before it is open; write , in its place"
            return replace(item, message=message, column=remark.start() + 1, edits=(edit,))
    is_remark = ")" in text and item.code in ("VP001", "VP023") and dialect in _BLOCKS  # else it takes long
    if is_remark and (match := _REMARK.match(text)) and item.column <= match.end():
        wrong = match[0][match.start(1) - match.start() :]
        edit = Remedy(f"write ({wrong}", f"({wrong}", line=item.line, misspelt=wrong)
        message = f"a comment is closed that no '(' begins; write ({wrong}"
        return replace(item, message=message, column=match.start(1) + 1, edits=(edit,))
    if (
        item.code in ("VP002", "VP011", "VP012")
        and dialect == "fanuc"
        and (match := _FIRST_WORD.match(text))
        and match.start(1) + 1 == item.column
        and _is_numbered(source, item.line)
    ):
        edit = Remedy(f"write N{match[2]}", f"N{match[2]}", line=item.line, misspelt=match[1], is_choice=True)
        message = f"{match[1]}: N{match[2]}{MAY_BE_MEANT}, a block number; as it stands: {item.message}"
        others = (replace(one, is_choice=True) for one in item.edits)
        return replace(item, message=message, edits=(edit, *others))
    is_unread = item.code in UNREADABLE or _is_value(text, item.column, item.code)
    correction = find_correction(item.message)
    is_explained = slip is not None or (correction is not None and " " in correction[1])
    is_explained |= any(one in item.message for one in (_BEHIND_M, _BEFORE_LETTER, _NO_MACRO_WORD))
    if is_unread and not is_explained:
        found = _find_number(text, item.column, dialect)
        if found is not None:
            found = (_add_point(source, found[0], found[3], dialect), *found[1:])
            rights = [found[3], *([found[3][:-1]] if f" or {found[3][:-1]} " in found[0] else [])]
            edits = propose_words(item, found[2], rights if found[0].endswith(MAY_BE_MEANT) else [])
            item = replace(item, code="VP001", message=found[0], column=found[1] + 1, edits=edits)
            if _is_sign_or_none(found[2], dialect):  # the keys of = and - are neighbours
                signs = (found[3], f"{found[3][0]}-{found[3][1:]}")
                edits = propose_words(item, found[2], signs)
                return replace(item, message=f"{found[2]}: {_NO_EQUALS}; write {' or '.join(signs)}", edits=edits)
    elif item.code == "VP006" and (match := _NUMBER_WITH_I.match(text.strip())) and "I" in item.message:
        message, _begin, *_words = _report(match, _I_IN_NUMBER, match[0].upper().replace("I", "1"))
        item = replace(item, code="VP001", message=message, column=text.index(match[0]) + 1, edits=())
    elif item.code == "VP006" and dialect in _BLOCKS and (match := _find_divided(text, item.column)):
        right = re.sub("[lI]", "1", match[0])
        message, begin, *_words = _report(match, f"the letter {match[1]} in a number", right)
        item = replace(item, code="VP001", message=message, column=begin + 1, edits=())
    elif item.code == "VP006":
        for match in _VARIABLE_WITH_L.finditer(text):
            if match.end() == item.column:
                message, begin, *_words = _report(match, "the letter l in a number", f"{match[0][:-1]}1")
                item = replace(item, code="VP001", message=message, column=begin + 1)
    correction, begin = find_correction(item.message), (item.column or 1) - 1
    if correction is None or item.edits:
        return (
            replace(item, edits=item.edits or _close_quote(text, begin, item.line or 0))
            if item.code == "VP001"
            else item
        )
    wrong_word = text[begin : begin + len(correction[0])]
    if wrong_word.upper() != correction[0].upper():
        return item
    edit = Remedy(f"write {correction[1]}", correction[1], line=item.line or 0, misspelt=wrong_word)
    return replace(item, edits=(edit,))


def _close_quote(text: str, begin: int, line: int) -> tuple[Remedy, ...]:
    """The edits of an error at a quote that its line does not close: behind its first word, or at the end."""
    rest = text[begin:].rstrip()
    if not rest.startswith('"') or '"' in rest[1:]:
        return ()
    if other := _OTHER_QUOTE.match(rest):
        return (Remedy('write "', f'{other[1]}"', line=line, misspelt=other[0]),)
    head = _TEXT.sub("", text[:begin])
    ends = [len(re.split(r"[\s,)]", rest, maxsplit=1)[0]), rest.rindex(")") if ")" in rest else len(rest)]
    closing = ")" * (head.count("(") - head.count(")") - rest.count(")"))
    new = dict.fromkeys(f'{rest[:end]}"{rest[end:]}{closing if end == len(rest) else ""}' for end in ends)
    return tuple(
        Remedy('write "', one, line=line, misspelt=rest, is_choice=True) for one in new if not one.startswith('""')
    )


def correct_number(text: str, error: ProgramError, dialect: str = "") -> str | None:
    """A line that cannot be read, with the number that is meant, which the error says; None where there is none."""
    if (paste := _find_pasted(text, error, dialect)) is not None:
        error.code, error.message, error.column, error.edits = "VP001", explain_pasted(paste[0]), paste[1] + 1, ()
        return translate_pasted(text)
    if error.column is None or not (error.code in UNREADABLE or _is_value(text, error.column, error.code)):
        return None
    found = _find_number(text, error.column, dialect)
    if found is None or found[0].endswith(MAY_BE_MEANT) or _is_sign_or_none(found[2], dialect):
        return None
    error.message, begin, wrong_word, right_word = found
    error.code, error.column, error.edits = "VP001", begin + 1, ()  # a bracket is not what is missing
    return text[:begin] + right_word + text[begin + len(wrong_word) :]


def _find_number(line: str, column: int, dialect: str) -> tuple[str, int, str, str] | None:
    """The message about a number at a column, where its word begins, the word, and what is meant."""
    at = column - 1
    for pattern in _ALIKE:
        for match in pattern.finditer(line, max(at - _LONGEST, 0), at + _LONGEST):
            # a letter behind a number is found where the next word begins
            is_end = match[2][-1:] in ("l", "O", "o")
            n_blanks = len(line[match.end() :]) - len(line[match.end() :].lstrip()) if is_end else 0
            if match.start() <= at <= match.end() + n_blanks and _is_number(pattern, match, line):
                word = "".join(match[0].split())
                if pattern is _LETTER_O and dialect != "siemens" and _LETTER_TOO_MANY.fullmatch(word):
                    return _report(match, _AFTER_CODE, word[:-1])
                number = "".join(match[1].split()) + match[2].translate(MEANT_CHARACTERS)
                if match[1].strip().upper() in _COMPARISONS:
                    wrong, right = match[2], match[2].translate(MEANT_CHARACTERS)
                    what = f"{_name_character(wrong)} in a number"
                    return f"{wrong}: {what}; did you mean {right}?", match.start(2), wrong, right
                if pattern is _LETTER_L and match[1].strip().upper() in ("F", "S") and match[2][:-1].isdigit():
                    rights = f"{number} or {number[:-1]}"  # ten times as fast, or a letter too many
                    return (
                        f"{match[0]}: the letter l in a number; {rights}{MAY_BE_MEANT}",
                        match.start(),
                        match[0],
                        number,
                    )
                return _report(match, f"{_name_character(match[2])} in a number", number)
    for pattern, what in _TOO_MANY:
        for match in pattern.finditer(line, max(at - _LONGEST, 0), at + _LONGEST):
            is_word = match[1].strip().upper() not in _COMPARISONS
            if match.start() <= at <= match.end() and is_word:
                return _report(match, what, "".join(match[1].split()) + match[2] + match[3])
    for match in _LETTER_BEFORE_POINT.finditer(line, max(at - _LONGEST, 0), at + _LONGEST):
        if match.start() <= at <= match.end():
            right = f"{''.join(match[1].split())}{match[2]}{match[3].translate(DIGITS_ALIKE)}."
            return _report(match, f"the letter {match[3]} in a number", right)
    if dialect == "fanuc" and (block := _NUMBER_OF_BLOCK.match(line)) and block.start(2) <= at <= block.end():
        right = block.expand(r"\1\2 \3")
        return (
            f"{block[0].strip()}: the blank is at a wrong place; did you mean {right}?",
            block.start(1),
            block[0].strip(),
            right,
        )
    for pattern, what, right in _WRONG_ORDER if dialect in _BLOCKS else ():
        for match in pattern.finditer(line, max(at - _LONGEST, 0), at + _LONGEST):
            # in 1G1X5, without blanks, a letter may be lost
            is_sure = what != _BEFORE_LETTER or " " in line.strip() or match[0] == line.strip()
            # a letter behind a number is found where the next word begins
            end = len(line) - len(line[match.end() :].lstrip()) if match[0][-1].isalpha() else match.end()
            if match.start() <= at <= end and is_sure:
                return _report(match, what, match.expand(right))
    for match in _TWICE.finditer(line, max(at - 1, 0), at + _LONGEST):
        if match.start() <= at <= match.start() + 1:
            return _report(match, "the letter is there twice", match[1] + match[2])
    return None


def _find_divided(text: str, column: int | None) -> re.Match[str] | None:
    """The word with a small L or an I after a digit, at a column, and more of its number behind it."""
    return next((one for one in _DIVIDED_NUMBER.finditer(text) if one.start(1) + 1 == column), None)


def _is_sign_or_none(word: str, dialect: str) -> bool:
    """Whether the = of a word that has none may stand for a minus sign."""
    return dialect in _BLOCKS and _SIGNED_WORD.fullmatch(word) is not None


def _is_numbered(source: Text, line: int) -> bool:
    """Whether the line before or after one begins with a block number."""
    beside = [take_line(source, at) for at in (line - 1, line + 1) if at]
    return any(raw is not None and re.match(rb"[ \t/]*N[ \t]*\d", raw, re.IGNORECASE) for raw in beside)


def _add_point(source: Text, message: str, word: str, dialect: str) -> str:
    """The message about a comma, which stands for a point where the numbers of its address have one in a program."""
    address = re.match(r"[A-Z]+", word, re.IGNORECASE)
    if f": {COMMA_BEHIND};" not in message or address is None or "." in word:
        return message
    head = rf"(?<![A-Z_]){address[0]}[ \t]*[-+]?[ \t]*".encode()
    pointed_word, bare_word = (re.compile(head + end, re.IGNORECASE) for end in (rb"\d*\.", rb"\d++(?![.,])"))
    is_usual = dialect == "fanuc" and _WITH_POINT.fullmatch(word) and _NUMBER_WITH_POINT.search(source)
    has_point = (is_usual or pointed_word.search(source)) and bare_word.search(source) is None
    return f"{message.removesuffix('?')}.?" if has_point else message


def _is_value(text: str, column: int, code: str) -> bool:
    """Whether the name without a value (VP025) at a column looks like a number."""
    return code == "VP025" and column > 1 and _VALUE.match(text, column - 1) is not None


def _report(match: re.Match[str], what: str, right_word: str) -> tuple[str, int, str, str]:
    meaning = f"{right_word}{MAY_BE_MEANT}" if _is_choice(match[0], what, right_word) else f"did you mean {right_word}?"
    return f"{match[0]}: {what}; {meaning}", match.start(), match[0], right_word


def _is_choice(word: str, what: str, right_word: str) -> bool:
    """Whether something else is as likely to be meant: nothing is executed then.

    That is another code, of all the moves behind it too, the other sign, or two words: ZI0 is Z with its number lost.
    """
    if what == _BEFORE_LETTER:
        return right_word[0].upper() in "GM"
    if what == _I_IN_NUMBER:
        return word[:1].upper() != "N"
    if what == _AFTER_CODE:
        return right_word.upper() in OF_ALL_MOVES
    return what == _TWO_SIGNS and "-+" in word


def _name_character(number: str) -> str:
    if "," in number:
        return "a decimal comma"
    return (
        "the letters l and O"
        if "l" in number and "O" in number.upper()
        else f"the letter {'l' if 'l' in number else 'O'}"
    )


def _is_number(pattern: re.Pattern[str], match: re.Match[str], line: str) -> bool:
    """Whether what such a pattern finds can only be a number."""
    if pattern is _VALUE:
        return _BEFORE_VALUE.search(line[: match.start()]) is not None
    if pattern is not _LETTER_O:
        return True
    head, number = match[1].strip().upper(), match[2].lstrip("-+").upper()
    if any(sign.isdigit() for sign in number):
        if head == "D" and re.match(r"O[1-9]$", match[2]) and "[" in line[: match.start()]:  # DO1 of a loop
            return False
        if head == "T" and _FOR.search(line[: match.start()]):  # TO4 of a loop
            return False
        return bool(head) or number[0] != "O"
    if len(number.rstrip(".")) > 1 and head not in ("G", "M"):  # FOO is a name, GOO is G00
        return False
    is_before_zero = head in _BEFORE_ZERO or re.fullmatch(r"Q[LR]?\d+[ \t]*=", head) is not None
    return is_before_zero and re.match(r"[^\W\d]|[(\[/]", line[match.end() :]) is None  # no PO[X], FOO(1), GO/
