"""Lines of Klartext that begin with no word of the language: what is meant by their first words."""

import re
from itertools import dropwhile, pairwise
from typing import Final

from verne_post.base.suggestions import DIGITS_OF_KEYS, drop_doubles, find_meant
from verne_post.gcode.klartext.vocabulary import PLANES, REFUSED_STATEMENTS, STATEMENTS
from verne_post.gcode.program_error import ProgramError, write_words

#: What a statement begins with.
KEYWORD: Final = re.compile(
    "|".join(
        re.escape(word).replace(r"\ ", r"[ \t]+")
        + (
            ""
            if len(word) == 1 and word != "C"
            else r"(?![A-Z])"
            if word in ("CYCL DEF", "TOOL CALL", "TOOL DEF")
            else r"(?![A-Z0-9])"
        )
        for word in sorted(STATEMENTS, key=len, reverse=True)
        if word not in (*"LCMQFS", "FN", "QL", "QR", "QS")
    )
    + r"|FN(?=[ \t]*\d)|[LC](?=[ \t]|$)|[LC](?=I?[XYZABCUVW][ \t]*[+\-0-9.,Q])|Q[LRS]?(?=[ \t]*\d)"
    r"|M(?=[ \t]*\d)|F(?=[ \t]*(?:[\d.,Q]|MAX|AUTO)|[UZ][ \t]*[\d.,Q])|S(?=[ \t]*[\d.,Q])"
)
#: A coordinate, where a keyword is to stand.
_COORDINATE: Final = re.compile(
    r"I?(?:[XYZABCUVW]|P[AR])[ \t]*[-+]?(?:\d++[.,]?\d*+|[.,]\d++|Q[LR]?\d++(?![ \t]*=))(?!\w)"
)
#: N4- before a statement.
_N_AND_SIGN: Final = re.compile(r"[ \t]*(N(\d++)[-+])(?=[ \t])[ \t]*+")
#: What a coordinate begins with, one with a slip in its number too.
_AXIS: Final = re.compile(r"I?(?:[XYZABCUVW]|P[AR])[-+.,\dQ=]")
#: Statements that coordinates follow.
_PATH: Final = re.compile(r"L[NP]?|C[CPRT]?|CTP")
#: A coordinate with = before its number.
_WITH_EQUALS: Final = re.compile(r"(I?(?:[XYZABCUVW]|P[AR]))[ \t]*+=[ \t]*+([-+]?)(\d++[.,]?\d*+|[.,]\d++)(?!\w)")
#: The sense of an arc.
_DIRECTION: Final = re.compile(r"(?<!\w)DR[ \t]*[-+]")
LETTERS_AS_DIGITS: Final = str.maketrans("OIL", "011")
#: The number of a block in which letters stand for digits.
_BLOCK_NUMBER: Final = re.compile(r"[ \t]*((?=[OIL\d]*[OIL])[OIL\d]+)[ \t]+")
#: A text of several words, none of which is a coordinate.
_TEXT_OF_REMARK: Final = re.compile(r"(?!.*[ \t]I?[XYZABCUVWF][-+]?\d).*[ \t]\S")
_THREE_WORDS: Final = re.compile(r"(\S+)(?:[ \t]+(\S+))?(?:[ \t]+(\S+))?")
#: Statements of one word that another one follows.
_FIRST_WORDS: Final = ("PLANE", "FUNCTION", "TRANS", "APPR", "DEP")
#: Words of path functions, of one or two letters: what stands behind a misspelt one tells which is meant.
_OF_PATHS: Final = re.compile(r"([LC][A-Z]?|[A-Z][LC])[ \t]+(?:I?[XYZABCUVW]|P[AR]|[NT][XYZ])[ \t]*[-+.,\dQ]")
#: Of each of these words the first that stands there decides.
_TOLD_BY: Final = (
    (re.compile(r"(?<!\w)[NT][XYZ]"), {"L": "LN"}),
    (re.compile(r"(?<!\w)I?P[AR]"), {"L": "LP", "C": "CP"}),
    (re.compile(r"(?<!\w)R[ \t]*[-+]?[1-9Q]"), {"C": "CR"}),
)
#: LBL1 or CALL LBL1, without the blank before the number.
_JOINED_LABEL: Final = re.compile(r"(?:CALL[ \t]+)?LBL\d+(?![^ \t])")
_SHORT_LABEL: Final = re.compile(r"(?:LL|LB|BL)[ \t]+(?:\d+|\"[^\"]*\")[ \t]*")
_HALF_FN: Final = re.compile(r"[FN][ \t]*\d{1,2}[ \t]*:")
#: Statements of two words, and one of them, or a number of FN with a slip, before what follows both.
_LOST_WORD: Final = {
    "CYCL DEF": re.compile(r"(?:CYCL|DEF)(?=[ \t]+(?:\d{1,2}\.\d|\d{3})(?!\d))"),
    "TOOL CALL": re.compile(r"(?:TOOL|CALL)(?=[ \t]+(?:\d+|\"[^\"]*\")[ \t]+Z)"),
    "CALL LBL": re.compile(r"CALL(?=[ \t]+(?:\d+|\"[^\"]*\")[ \t]*(?:REP|$))"),
    "BLK FORM": re.compile(r"(?:BLK|FORM)(?=[ \t]+0[.,][12][ \t])"),
    "PLANE SPATIAL": re.compile(r"SPATIAL(?=[ \t]+SP[ABC])"),
    "FUNCTION TCPM": re.compile(r"TCPM(?=[ \t]+F[ \t])"),
    "LBL": re.compile(r"LABEL(?=[ \t]+(?:\d+|\"[^\"]*\")[ \t]*$)"),
    "FN 0:": re.compile(r"FN(?:[ \t]*[OP])?[ \t]*:(?=[ \t]*Q[LR]?\d+[ \t]*=[ \t]*[-+]?[\d.,Q]+[ \t]*$)"),
    "FN": re.compile(r"(?:F[BHJM]|[DGRTCV]N)(?=[ \t]*\d{1,2}[ \t]*:)"),
}
#: The number of a block with a letter, and the statement.
_NUMBER_AND_LETTER: Final = re.compile(r"[ \t]*(?:(\d+)[A-Z]|N(\d+))[ \t]+(?![MFSQ]|R[0LR])")
#: Characters of a line in which its first words are sought.
_LONGEST: Final = 200
_PARTS: Final = frozenset(word for name in (*STATEMENTS, *PLANES) for word in name.split())


def is_half_keyword(text: str, keyword: re.Match[str]) -> bool:
    """Whether what looks like a keyword is a part of another one, or the letter of a block number: F 9: or 28L LBL."""
    begin = keyword.start()
    if _SHORT_LABEL.fullmatch(text, begin):
        return True
    if keyword.group() == "LBL":
        return re.match(r"LBL[ \t]+CALL\b", text[begin:]) is not None
    if keyword.group() in ("L", "C") and text[begin - 1 : begin].isdigit():
        number = _NUMBER_AND_LETTER.match(text)
        return number is not None and KEYWORD.match(text, number.end()) is not None
    return keyword.group() == "F" and _HALF_FN.match(text, begin) is not None


def refuse_unread(text: str, number: re.Match[str], line: int) -> ProgramError:
    """The error of a line in capitals, behind whose block ``number`` no word of the language stands."""
    begin = number.end()
    if _HALF_FN.match(text, begin):
        return ProgramError("VP001", f"{text[begin]}: a letter of FN is missing; did you mean FN?", begin + 1)
    word = re.match(r"[^\s+\-=]*", text[begin:])
    shown_word = (word.group() if word else "") or text[begin : begin + 10]
    if shown_word in REFUSED_STATEMENTS:
        why = f"executed ({REFUSED_STATEMENTS[shown_word]}); docs/heidenhain.md lists them"
        return ProgramError("VP002", f"{shown_word[:20]} is not {why}", begin + 1)
    if (block_number := _N_AND_SIGN.match(text)) is not None and KEYWORD.match(text, block_number.end()):
        what = f"{block_number[1]}: a block number has digits alone; did you mean {block_number[2]}?"
        return ProgramError("VP001", what, block_number.start(1) + 1)
    if coordinate := _COORDINATE.match(text, begin):
        place = coordinate[0]
        if re.match(r"[A-Z]\d+[ \t]*=", text[begin:]):
            return ProgramError("VP001", f"{place}: no parameter; did you mean Q{place[1:]}?", begin + 1)
        if swapped_words := _find_swapped(text, begin):
            return swapped_words
        if path := _find_late_path(text, begin):
            what = (
                f"{place}: {path} stands after the coordinates; write {path} before {place}, at the start of the block"
            )
            late = re.compile(rf"[ \t]{path}(?![^ \t])").search(text, begin)
            wrong = text[begin : late.end()] if late is not None else ""
            edits = write_words(wrong, f"{path} {wrong.removesuffix(path).rstrip()}", line=line)
            return ProgramError("VP001", what, begin + 1, edits=edits)
        right = f"{_choose_path(text[begin:])} {place}"
        what = f"{place}: coordinates without a path function before them; write {right}"
        return ProgramError("VP001", what, begin + 1, edits=write_words(place, right, line=line))
    if equal := _WITH_EQUALS.match(text, begin):
        rights = [f"{_choose_path(text[begin:])} {equal[1]}{sign}{equal[3]}" for sign in equal[2] or "+-"]
        either = " or ".join(rights)
        what = f"{equal[0]}: a coordinate has no =, and no path function stands before it; write {either}"
        edits = write_words(equal[0], *rights, line=line, is_choice=len(rights) > 1)
        return ProgramError("VP001", what, begin + 1, edits=edits)
    if joined_label := _JOINED_LABEL.match(text, begin):
        return refuse_joined(joined_label.group(), begin + 1, line)
    wrong_number = _BLOCK_NUMBER.match(text)
    if wrong_number is not None and KEYWORD.match(text, wrong_number.end()):
        wrong = wrong_number[1]
        right = wrong.translate(LETTERS_AS_DIGITS)
        rights = (
            [right, wrong[:-1]] if re.fullmatch(r"\d+L", wrong) else [right]
        )  # 31L: 311, or L of the next word twice
        what = f"{wrong}: a letter in the number of the block; "
        if len(rights) == 1:
            return ProgramError("VP001", f"{what}did you mean {right}?", wrong_number.start(1) + 1)
        edits = write_words(wrong, *rights, line=line)
        return ProgramError("VP001", f"{what}write {' or '.join(rights)}", wrong_number.start(1) + 1, edits=edits)
    with_letter = _NUMBER_AND_LETTER.match(text)
    if with_letter is not None and KEYWORD.match(text, with_letter.end()):
        right = with_letter[1] or with_letter[2]
        what = f"{with_letter[0].strip()}: a letter in the number of the block; did you mean {right}?"
        return ProgramError("VP001", what, with_letter.start() + 1 + len(text) - len(text.lstrip()))
    if swapped_words := _find_swapped(text, begin):
        return swapped_words
    if (
        number[2]
        and (match := re.match(r"(\d+)([A-Z]+)(?=[ \t])", text[begin:]))
        and _fits(match[2], text[begin:][match.end() :])
    ):
        wrong = text[number.start(2) : begin + match.end()]
        what = f"{wrong}: the blank is at a wrong place; did you mean {number[2]}{match[1]} {match[2]}?"
        return ProgramError("VP001", what, number.start(2) + 1)
    if number[2] and (digits := re.match(r"\d+(?=[ \t])", text[begin:])) is not None:
        if re.match(r"\d+[ \t]*=", text[begin:]):
            what = f"{digits[0]}: the Q before the number is missing; did you mean Q{digits[0]}?"
            return ProgramError("VP001", what, begin + 1)
        right = f"{number[2]}{digits[0]}"
        edits = write_words(text[number.start(2) : begin + digits.end()], right)
        what = f"{number[2]} {digits[0]}: a blank is in the number of the block; write {right}"
        return ProgramError("VP001", what, number.start(2) + 1, edits=edits)
    why = "not a statement that is executed here; docs/heidenhain.md lists them"
    return _refuse_unknown_statement(f"{shown_word[:20]} is {why}", shown_word, text, begin)


def _find_swapped(text: str, begin: int) -> ProgramError | None:
    """The error of two words in the wrong order, one of which begins a statement, as X+5 L or CYCL 7.0 DEF."""
    words = [text[one.start() : one.end()] for one in re.finditer(r"\S+", text[:_LONGEST]) if one.start() >= begin]
    for at, (first, second) in enumerate(pairwise(words[:3])):
        if first.isdigit() and second != "LBL":
            continue
        if _AXIS.match(first) and not _PATH.fullmatch(second):  # L before both is lost: Z+2 R0
            continue
        keyword = KEYWORD.match(" ".join([*words[:at], second, first, *words[at + 2 : at + 3]]))
        found = [] if keyword is None else keyword.group().split()
        is_whole = found[at : at + 1] == [second] or (first == "=" and found == ["Q"])
        if is_whole and (first in _PARTS or re.search(r"[\d=\"]", first)):
            place = text.index(first, begin + sum(map(len, words[:at])))
            what = f"{first} {second}: two words in the wrong order; did you mean {second} {first}?"
            return ProgramError("VP001", what, place + 1)
    return None


def _find_late_path(text: str, begin: int) -> str:
    """The path function that stands behind two coordinates or more, as in X+5 Y+5 L R0; empty where none does."""
    words = text[begin:_LONGEST].split()
    late_words = dropwhile(_AXIS.match, words)
    path = next(late_words, "")
    return path if _PATH.fullmatch(path) else ""


def _find_path(text: str) -> str:
    """The path function that a misspelt one is meant for, as LN for LM before a normal; empty where none is told."""
    match = _OF_PATHS.match(text)
    if match is None:
        return ""
    kind = "L" if "L" in match[1] else "C"
    # of arcs C, CT and CTP have the same words
    return _name_path(kind, text) or (kind if kind == "L" or match[1] == "CC" else "")


def _name_path(kind: str, text: str) -> str:
    """The path function, a line (L) or an arc (C), that the words of a block tell apart from others; empty if none."""
    return next((paths[kind] for word, paths in _TOLD_BY if kind in paths and word.search(text)), "")


def _choose_path(text: str) -> str:
    """The path function of words without one: an arc where they have DR+ or DR-, else a line."""
    kind = "C" if _DIRECTION.search(text) else "L"
    return _name_path(kind, text) or kind


def refuse_joined(text: str, column: int, line: int) -> ProgramError:
    """The error of LBL1 or CALL LBL1: the same where LBL1 is executed, and where its label is called."""
    right = " ".join(text.replace("LBL", "LBL ").split())
    edits = write_words(text, right, line=line)
    return ProgramError("VP001", f"{text}: a blank is missing; write {right}", column, line=line, edits=edits)


def _fits(word: str, rest: str) -> bool:
    """Whether a statement begins with a word and what follows it."""
    keyword = KEYWORD.match(word + rest)
    return keyword is not None and keyword.group().split()[0] == word


def _refuse_unknown_statement(message: str, first: str, text: str, begin: int) -> ProgramError:
    """The error of a statement whose first word, or the word after a right one, is in no statement."""
    rest = text[begin + len(first) :]
    for right, pattern in _LOST_WORD.items():
        if (half := pattern.match(text, begin)) is not None:
            if " " not in right:
                message = f"{half[0]}: no meaning in this language; did you mean {right}?"
                return ProgramError("VP002", message, begin + 1)
            following = re.match(r"[ \t]*\S+", text[half.end() :])[0]  # type: ignore[index]
            edits = write_words(half[0] + following, right + following, is_choice=True)
            what = "the number of the function" if right == "FN 0:" else "a word"
            message = f"{half[0]}{following}: {what} is missing; write {right}{following}"
            return ProgramError("VP002", message, begin + 1, edits=edits)
    phrases = [name.split() for name in STATEMENTS]
    phrases.sort(key=lambda one: (KEYWORD.match(one[0] + rest) or [""])[0].split()[:1] != one[:1])  # what fits is meant
    words = _THREE_WORDS.match(text, begin)
    given_words = [] if words is None else [one for one in words.groups() if one]
    for phrase in phrases:
        known_words = " ".join(phrase)
        for count in range(1, len(given_words) + 1):
            if (
                len(known_words) > 2
                and "".join(given_words[:count]) == known_words.replace(" ", "")
                and words is not None
            ):
                written_text, what = text[begin : words.end(count)], "missing" if count == 1 else "in the word"
                return ProgramError(
                    "VP001", f"{written_text}: a blank is {what}; did you mean {known_words}?", begin + 1
                )
        if len(phrase) > 1 and phrase[1:] == given_words[1:2] and all(first != one[0] for one in phrases):
            is_near = len(first) == len(phrase[0]) and sum(a != b for a, b in zip(first, phrase[0], strict=True)) == 1
            if is_near or first == phrase[0][1:]:
                text = f"{first}: no meaning in this language; did you mean {phrase[0]}?"
                return ProgramError("VP002", text, begin + 1)
    if _SHORT_LABEL.fullmatch(text, begin):
        return ProgramError("VP001", f"{first}: a letter is missing; did you mean LBL?", begin + 1)
    for once in drop_doubles(first):
        if _fits(once, rest):
            message = f"{first}: the letter is there twice; did you mean {once}?"
            return ProgramError("VP001", message, begin + 1)
    seconds = [phrase[1] for phrase in phrases if phrase[0] == first and len(phrase) > 1]
    after = re.match(r"[ \t]+(([A-Z]+)\S*)", text[begin + len(first) : begin + _LONGEST])
    if seconds and after is not None:
        column = begin + len(first) + after.start(1) + 1
        for one in seconds:
            if re.match(rf"{one}(?:\d|\w\w)", after[1]):
                right = f"{one} {after[1][len(one) :]}"
                return ProgramError("VP001", f"{after[1]}: a blank is missing; did you mean {right}?", column)
        fit = [one for one in dict.fromkeys(seconds) if find_meant(after[2], [one], least=3) or one[1:] == after[2]]
        if len(fit) == 1:
            message = f"{after[2]}: no meaning in this language; did you mean {fit[0]}?"
        else:
            message = f"{after[2]}: no word that follows {first}; write {' or '.join(dict.fromkeys(seconds))}"
        return ProgramError("VP002", message, column)
    if re.match(r"\d+[ \t]*$", text[begin:]):
        edits = write_words(first, f"M{first}", is_choice=True)
        message = f"{first}: the letter before this number is missing, as in M{first}"
        return ProgramError("VP001", message, begin + 1, edits=edits)
    if parameter := re.fullmatch(r"(Q[LRS]?)([LO\d]*[LO][LO\d]*)", first):
        right = parameter[1] + parameter[2].translate(str.maketrans("LO", "10"))
        return ProgramError("VP001", f"{first}: a letter in the number; did you mean {right}?", begin + 1)
    if first_word := next((one for one in _FIRST_WORDS if first.startswith(one)), ""):
        right = f"{first_word} {first[len(first_word) :]}"
        return ProgramError("VP001", f"{first}: a blank is missing; did you mean {right}?", begin + 1)
    if (joined_text := re.match(r"([A-Z]{2,})(?=[-+]?[\d.])", first)) and joined_text[1] in STATEMENTS:
        right = f"{joined_text[1]} {first[joined_text.end() :]}"
        return ProgramError("VP001", f"{first}: a blank is missing; did you mean {right}?", begin + 1)
    # LX +5, LM 8 and LI Y+2; before a whole word, the first one is a path function with a slip, as LM X-30
    if moved_blank := re.match(
        r"([LC])(I?[XYZABC](?=[ \t]+[-+\d])|M(?=[ \t]+\d)|I(?=[ \t]+[XYZABC]))[ \t]+([XYZABC]?[-+]?\d[\d.,]*)",
        text[begin:],
    ):
        right = f"{moved_blank[1]} {moved_blank[2]}{moved_blank[3]}"
        return ProgramError(
            "VP001", f"{moved_blank[0]}: the blank is at a wrong place; did you mean {right}?", begin + 1
        )
    if digit := re.fullmatch(r"(\d)M(\d{0,2})", text[begin:].rstrip()):
        right = f"M{digit[1]}{digit[2]}"
        return ProgramError("VP001", f"{digit[0]}: a digit before its letter; did you mean {right}?", begin + 1)
    if text[begin:].strip() == "M":
        return ProgramError("VP001", "M: the number of the M function is missing, as in M8", begin + 1)
    if re.fullmatch("Q[LRS]?", first) and re.match(r"[ \t]*=", rest):
        return ProgramError("VP001", f"{first}: the number of the parameter is missing, as in {first}1 =", begin + 1)
    if first in ("K", "O", "P") and re.match(r"[ \t]+I?[XYZABC][-+]?[\d.]", rest):  # keys beside L
        return ProgramError("VP002", f"{first}: no path function; did you mean L?", begin + 1)
    if re.fullmatch(r"[NJK]\d{1,3}|M\d?[QWERTYU]\d?", first):  # keys beside M, and above digits
        right, word = f"M{first[1:].translate(DIGITS_OF_KEYS)}", first + rest[: rest.strip() in ("-", "+")]
        edits = write_words(word, right, is_choice=True)
        message = f"{word}: no meaning in this language; write {right} if the M function is meant"
        return ProgramError("VP001", message, begin + 1, edits=edits)
    if path := _find_path(text[begin:]):
        return ProgramError("VP002", f"{first}: no meaning in this language; did you mean {path}?", begin + 1)
    before_number = ("LBL",) if re.fullmatch(r"[ \t]*(?:\d+|\"[^\"]*\")[ \t]*", rest) else ()
    near = find_meant(first, before_number, (phrase[0] for phrase in phrases), slip_alone=True, least=3)
    ends = [
        phrase[0]
        for phrase in phrases
        if len(phrase[0]) > 2 and len(first) == len(phrase[0]) and first[1:] == phrase[0][1:] and first != phrase[0]
    ]
    ends += [phrase[0] for phrase in phrases if len(first) > 1 and first == phrase[0][1:]]
    near = near or next(iter(ends), "")
    if not near and "=" not in first and _TEXT_OF_REMARK.match(text, begin):
        edits = write_words(text[begin : begin + len(first)], f"; {first}", is_choice=True)
        message = f"{first[:20]} begins no statement that is executed here; write ; before it if it is a remark"
        return ProgramError("VP002", message, begin + 1, edits=edits)
    message = f"{first}: no meaning in this language; did you mean {near}?" if near else message
    return ProgramError("VP002", message, begin + 1)
