"""Slips of typing in blocks of letters and numbers, of RS274/NGC and Fanuc, that the rest of a program gives away."""

import re
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Final, Literal, NamedTuple

from verne_post.base.long_text import Text, count_line, take_line
from verne_post.base.program_lines import remove_remarks
from verne_post.base.suggestions import (
    DIGITS_OF_KEYS,
    MAY_BE_MEANT,
    find_correction,
    find_meant,
    has_one_more,
    list_near_numbers,
)
from verne_post.gcode.codes import make_unknown_function
from verne_post.gcode.program_error import write_words
from verne_post.gcode.text import count_name, decode_line
from verne_post.model.findings import Finding, Remedy

#: Characters of a line that are looked at on both sides of a column.
_LONGEST: Final = 40
_LONGEST_NAME: Final = 90
#: A word with a letter in its number whose key is beside that of a digit.
_LETTER_OF_DIGIT: Final = re.compile(
    r"(?<![A-Z_#<])([A-FH-LNQ-Z][-+]?)(\d{0,9}\.?\d{0,9})([EPQRTUW])(\d{0,9}\.?\d{0,9})(?![\w#\[<.])", re.IGNORECASE
)
_LIKE_END: Final = re.compile(r"[ \t]*(?:N\d+[ \t]+)?(N30|M0?3|M3O|M39|M40)[ \t\r]*$", re.IGNORECASE)
_CHANGE_OR_NO_AXIS: Final = re.compile(r"[^(]*M0*6(?!\d)|[^(XYZAC]*(?:\(|$)", re.IGNORECASE)
#: An M code without its zeros, and what M6 and M30 become by a key that is struck twice or beside.
_FUNCTION: Final = re.compile(r"M0*(\d{2,3})(?!\d)", re.IGNORECASE)
_DOUBLED_DIGIT: Final = re.compile(r"([GM])0([1-9])\2(?![\d.])", re.IGNORECASE)
_LIKE_CHANGE: Final = ("66", "56", "65", "67", "76")
_BESIDE_END: Final = ("20", "33", "39", "40")
_WITH_T: Final = re.compile(r"^[^;(]*(?<![A-Z_#<])T[ \t]*[\d=#]", re.IGNORECASE)
_FUNCTIONS_ALONE: Final = re.compile(r"[ \t/]*(?:N?\d+[ \t]*)?(?:M\d+[ \t]*)+(?:[;(].*)?\r?", re.IGNORECASE)
_NEXT_PROGRAM: Final = re.compile(rb"\s*(?:%|O[ \t]*\d|\d*[ \t]*END[ \t]+PGM)", re.IGNORECASE)
_BLANK_LINES: Final = 5
#: A variable, and one that is given a value; two names that only tell two axes apart are no slip of each other.
_VARIABLE: Final = re.compile(rb"#(?:<[^<>\n]{1,80}>|\d{1,5}(?!\d))")
_SET: Final = re.compile(_VARIABLE.pattern + rb"(?=[ \t]*=(?!=))")
_OF_AXIS: Final = re.compile(r"_[a-cu-z]>", re.IGNORECASE)
_NEXT_HEAD: Final = re.compile(rb"[ \t]*(?:O[ \t]*\d|%)")
_BEFORE_HEAD: Final = re.compile(rb"\s*(?:%|(?:N\s*\d+\s*)?M\s*0*(?:2|30|99)\b)", re.IGNORECASE)


class _Case(NamedTuple):
    """An error, and what a row of the table fits in its line."""

    source: Text
    text: str
    item: Finding
    match: re.Match[str]

    def has_beside(self, pattern: re.Pattern[bytes], step: int) -> bool:
        """Whether a line before (-1) or behind (1) that of the error begins so."""
        line = (self.item.line or 1) + step
        raw = take_line(self.source, line) if line else None
        return raw is not None and pattern.match(raw) is not None

    def names(self, template: str) -> bool:
        """Whether the program has such a name."""
        return bool(count_name(self.source, self.match.expand(template)))

    def has(self, pattern: str) -> bool:
        return re.search(pattern, self.text, re.IGNORECASE) is not None

    def follows_word(self) -> bool:
        """Whether the match stands behind a letter or an operator, where no word begins."""
        return re.search(r"[A-Z\[=+*/-]$", self.text[: self.match.start()].rstrip(), re.IGNORECASE) is not None


class _Slip(NamedTuple):
    """A row of the table: the word that is looked for in the line of an error, what is meant and the message."""

    codes: str  #: Of the errors.
    #: The wrong word, or its group ``wrong``. It is looked for at the column of the error, from the beginning of the
    #: line ("line") or about that column ("around"), where it has the column, or in the whole line ("any").
    pattern: re.Pattern[str]
    #: Templates of the match.
    rights: tuple[str | Callable[[re.Match[str]], str], ...]
    #: What is wrong, where no other word can be meant; else, for a choice, the whole message, with the groups of the
    #: pattern, {wrong}, {right}, and that of the error: {message}, or {fact} without what it suggests.
    sentence: str
    place: Literal["here", "line", "around", "any"] = "here"
    applies: Callable[[_Case], bool] = lambda case: True
    code: str = ""  #: Of the finding, where another mistake is the cause.
    dialects: tuple[str, ...] = ("", "rs274", "fanuc")
    keeps_edits: bool = False  #: Those of the error are choices too.

    def find(self, text: str, item: Finding, dialect: str) -> re.Match[str] | None:
        """The match in a line; None where the row does not fit."""
        if item.code not in self.codes or dialect not in self.dialects:
            return None
        at = (item.column or 1) - 1
        if self.place == "here":
            return self.pattern.match(text, at)
        if self.place == "any":
            return self.pattern.search(remove_remarks(text, dialect))
        near = self.pattern.finditer(text, max(at - _LONGEST, 0), at + _LONGEST)
        found = [self.pattern.match(text)] if self.place == "line" else near
        return next((one for one in found if one and _is_at(one, item, self._group)), None)

    @property
    def _group(self) -> str | int:
        return "wrong" if "wrong" in self.pattern.groupindex else 0

    def explain(self, item: Finding, match: re.Match[str]) -> Finding:
        """The finding of the slip, with the edits that settle it."""
        wrong, rights = (
            match[self._group],
            [match.expand(one) if isinstance(one, str) else one(match) for one in self.rights],
        )
        words = {**match.groupdict(), "wrong": wrong, "right": rights[0]}
        fact = item.message.split("; did you mean ")[0]
        is_choice = "{" in self.sentence
        sentence = self.sentence if is_choice else f"{{wrong}}: {self.sentence}; did you mean {{right}}?"
        edits = write_words(wrong, *rights, line=item.line or 0, is_choice=is_choice)
        return replace(
            item,
            code=self.code or item.code,
            message=sentence.format(**words, message=item.message, fact=fact),
            column=item.column if self.place == "here" else match.start(self._group) + 1,
            edits=(*edits, *(replace(one, is_choice=True) for one in item.edits if self.keeps_edits)),
            settled_by=() if self.code else item.settled_by,
        )


_compile: Final = partial(re.compile, flags=re.IGNORECASE)
_LINE: Final = r"[ \t]*(?:N\d+[ \t]*)?"
#: What follows a label, and a name of one.
_KEYWORD: Final = r"[ \t]*(?=(?:(?:END)?(?:SUB|IF|WHILE|REPEAT)|CALL|RETURN|DO|ELSE(?:IF)?|BREAK|CONTINUE)(?![A-Z]))"
_OF_NAME: Final = r"[ \t]*(?=(?:(?:END)?(?:SUB|IF|WHILE|REPEAT)|CALL|RETURN)(?![A-Z]))"
_BESIDE: Final = "{right} may be meant, whose key is beside"
_NO_BLANKS: Final = "{wrong}: blanks mean nothing in a number, so that this is "
_LESS_BEHIND: Final = _compile(r"#([A-Z_])<(\w{0,40})>")
#: The first row that fits says what is meant.
_SLIPS: Final = (
    # labels and names of RS274/NGC
    _Slip(
        "VP001 VP023",
        _compile(rf"{_LINE}(?P<wrong>O(?P<label>O\d{{1,8}})){_KEYWORD}"),
        (r"\g<label>",),
        "the letter is there twice",
        "line",
        code="VP001",
    ),
    _Slip(
        "VP001 VP023",
        _compile(rf"{_LINE}(?P<wrong>O(?=\d*[EOPLQRTUWY])[\dEOPLQRTUWY]{{1,9}}){_KEYWORD}"),
        (lambda match: match["wrong"][0] + match["wrong"][1:].upper().translate(DIGITS_OF_KEYS),),
        "a letter in a number",
        "line",
        code="VP001",
    ),
    _Slip(
        "VP001 VP023",
        _compile(rf"{_LINE}(?P<wrong>(?P<digit>\d)(?P<o>O)(?P<rest>\d{{1,9}})){_KEYWORD}"),
        (r"\g<o>\g<digit>\g<rest>",),
        "a digit before its letter",
        "line",
        code="VP001",
    ),
    _Slip(
        "VP001 VP023",
        _compile(rf"{_LINE}(?P<wrong>[IKLP](?P<rest><[^<>]*>|\d{{1,9}}(?=[ \t]+[A-Z]{{2}}))){_KEYWORD}"),
        (r"o\g<rest>",),
        "a label begins with O",
        "line",
        code="VP001",
    ),
    _Slip(
        "VP001",
        _compile(rf"{_LINE}(?P<wrong>O(?P<name>[A-Z_]\w{{0,40}})>){_OF_NAME}"),
        (r"o<\g<name>>",),
        "the < of the name is missing",
        "line",
    ),
    _Slip(
        "VP001",
        _compile(rf"{_LINE}(?P<wrong><O(?P<name>[A-Z_]\w{{0,40}})>){_OF_NAME}"),
        (r"o<\g<name>>",),
        "the < of the name is before the o",
        "line",
        lambda case: case.names(r"o<\g<name>>") and not case.names(r"o\g<wrong>"),
    ),
    # characters in another order
    _Slip(
        "VP001",
        _compile(r"(?<![A-Z_#<\d.])([A-Z])(\d)-(\.\d{1,9})(?![\w.])"),
        (r"\1-\2\3",),
        "the sign after a digit",
        "around",
    ),
    _Slip(
        "VP001",
        _LESS_BEHIND,
        (r"#<\2>",),
        "a letter before the <",
        "around",
        lambda case: case.names(r"#<\2>") and case.follows_word(),
    ),
    _Slip("VP001", _LESS_BEHIND, (r"\1#<\2>",), "the # before its letter", "around", lambda case: case.names(r"#<\2>")),
    _Slip("VP001", _LESS_BEHIND, (r"#<\1\2>",), "the < after a letter", "around"),
    _Slip(
        "VP001", _compile(r"[ \t]*(?P<wrong><[^<>=]+>)[ \t]*="), (r"#\g<wrong>",), "a name without # before it", "line"
    ),
    # a word without its letter, its M or its point
    _Slip(
        "VP025",
        _compile(r"#(?P<variable>\d{1,3})[ \t]+(?P<number>\d{1,6}(?:\.\d{0,6})?)(?![\w.])"),
        tuple(rf"#\g<variable> {letter}\g<number>" for letter in "FXYZ"),
        f"{_NO_BLANKS}#{{variable}}{{number}}; {{number}} may lack its letter, such as F{{number}}",
        code="VP001",
    ),
    _Slip(
        "VP012",
        _compile(r"(?P<tool>T\d{1,4})[ \t]+(?P<code>0?6)(?![\d.])"),
        (r"\g<tool> M\g<code>",),
        f"{_NO_BLANKS}{{tool}}{{code}}; {{right}} may be meant",
        code="VP001",
    ),
    _Slip(
        "VP005 VP017",
        _compile(r"((?<![A-Z_#<])[XYZ][-+]?\d{1,9}),[ \t]*([RC]\d{0,9}\.?\d{0,9})"),
        (r"\1. \2",),
        "a comma in place of the point",
        "any",
        lambda case: re.match(r",[RC] must follow|G\d\d needs R,", case.item.message) is not None,
        code="VP001",
    ),
    # the key beside
    _Slip(
        "VP006",
        _compile(r"E(\d{1,3})(?![\d.])"),
        (r"D\1",),
        f"{{message}}; {_BESIDE}",
        applies=lambda case: case.has(r"G4[12](?![\d.])"),
    ),
    _Slip(
        "VP012",
        _compile(r"T(\d{1,4}\.\d{0,4})(?![\d.])"),
        (r"Y\1",),
        f"{{wrong}}: {_BESIDE}; as it stands: {{fact}}",
        applies=lambda case: not case.has(r"(?<![A-Z_#<])Y[ \t]*[-+.\d#\[]"),
        keeps_edits=True,
    ),
    _Slip(
        "VP012",  # G codes that stand beside axes as a rule
        _compile(r"T(4[0139]|49|80|9[01])(?![\d.])"),
        (r"G\1",),
        f"{{wrong}}: {_BESIDE}; as it stands: {{message}}",
        applies=lambda case: not _CHANGE_OR_NO_AXIS.match(case.text),
        keeps_edits=True,
    ),
    _Slip(
        "VP017",
        _compile(r"(?<![A-Z_#<])H(0*[0-3])(?![\d.])"),
        (r"G\1",),
        f"{{wrong}}: {_BESIDE}; as it stands: {{message}}",
        "any",
        lambda case: any(one.value == "G40" for one in case.item.edits) and not case.has(r"G[ \t]*0*4[39]"),
    ),
    _Slip(
        "VP002",
        _compile(rf"{_LINE}(?P<wrong>(?-i:M89))[ \t]*\Z"),
        ("M99",),
        "{wrong}: no meaning in this language; {right}, the end of a subprogram, may be meant",
        "line",
        lambda case: case.has_beside(_NEXT_HEAD, 1),
        dialects=("fanuc",),
    ),
    _Slip(
        "VP002",
        _compile(r"M89(?=[ \t]*P[ \t]*\d)"),
        ("M98",),
        "{wrong}: no meaning in this language; {right}, which calls P may be meant",
    ),
    _Slip(
        "VP006",
        _compile(r"[ \t]*(?P<wrong>[IKL](?P<number>\d{2,9}))[ \t]*(?:\(|$)"),
        (r"O\g<number>",),
        "nothing in the block uses it",
        "line",
        lambda case: case.has_beside(_BEFORE_HEAD, -1),
        code="VP006",
        dialects=("fanuc",),
    ),
)


def explain_slip(source: Text, text: str, item: Finding, dialect: str) -> Finding | None:
    """What a slip in the line of an error is, and the edits that settle it; None where it is none of these."""
    for slip in _SLIPS:
        match = slip.find(text, item, dialect)
        if match is not None and slip.applies(_Case(source, text, item, match)):
            return slip.explain(item, match)
    if item.code == "VP001" and text.strip() == "%":
        return replace(item, edits=(Remedy("take % out", misspelt="%", line=item.line or 0),))
    is_useless_p = item.code == "VP006" and item.column is not None and text[item.column - 1 :][:1] in ("P", "p")
    if item.code == "VP001" or is_useless_p:
        return None if item.message.endswith(MAY_BE_MEANT) else _find_letter_of_digit(text, item)
    if item.code == "VP025" and (unset := _VARIABLE.match(text[(item.column or 1) - 1 :][:_LONGEST_NAME].encode())):
        return _find_misspelt_setting(source, item, unset[0].decode())
    if item.code == "VP024" and any((one.value, one.way) == ("M30", "before") for one in item.edits):
        return _find_mistyped_end(source, item, dialect)
    return None


def explain_function(source: Text, text: str, item: Finding) -> Finding | None:
    """A code without a meaning that is a slip of M6 beside T, M30 in the last block, or M08 (M088); None for others."""
    at = (item.column or 1) - 1
    if (match := _DOUBLED_DIGIT.match(text, at)) is not None:  # nobody writes the zero before a number of two digits
        right_word = f"{match[1]}0{match[2]}"
        message = f"{match[0]}: the digit is there twice; did you mean {right_word}?"
        return replace(
            item, message=message, edits=write_words(match[0], right_word, line=item.line or 0), settled_by=()
        )
    match = _FUNCTION.match(text, at)
    if match is None or ("remap", f"M{match[1]}") not in item.settled_by:
        return None
    code, line = match[1], item.line or 0
    after = (take_line(source, number) for number in range(line + 1, line + _BLANK_LINES))
    following = next((one for one in after if one is None or one.strip()), None)
    above = take_line(source, line - 1) if line > 1 and _FUNCTIONS_ALONE.fullmatch(text) else None
    has_tool = any(_WITH_T.search(one) for one in (text, (above or b"").decode("utf-8", "replace")))
    if has_tool and code in _LIKE_CHANGE and not item.edits:
        right = 6
    elif (
        (following is None or _NEXT_PROGRAM.match(following))
        and (has_one_more(code, "30") or code in _BESIDE_END)
        and _FUNCTIONS_ALONE.fullmatch(text)
    ):
        right = 30
    else:
        return None
    edit = Remedy(f"write M{right}", f"M{right}", line=line, misspelt=match[0], is_choice=not has_one_more(code, "30"))
    return replace(item, message=make_unknown_function(int(code), None, [right]).message, edits=(edit,))


def _find_misspelt_setting(source: Text, item: Finding, unset: str) -> Finding | None:
    """What a variable without a value is meant for: the rarer spelling is wrong, as a rule.

    The line that sets a variable which nothing uses, and which is nearly this one, is told before any other name.
    """
    code, right = bytes(source), unset.lower()
    count = Counter(decode_line(one).lower() for one in _VARIABLE.findall(code))
    places = {decode_line(one[0]).lower(): one for one in _SET.finditer(code)}
    unused_names = [one for one in places if count[one] == 1 and ("<" in one) == ("<" in right)]
    slip = find_meant(right, unused_names, slip_alone=True) if "<" in right else ""
    numbers = list_near_numbers(right[1:], [one[1:] for one in unused_names])
    near = slip or (find_meant(right, unused_names) if "<" in right else "#".join(["", *numbers]))
    suggested_name = (find_correction(item.message) or ("", ""))[1].lower()
    is_other = _OF_AXIS.sub("", near) == _OF_AXIS.sub("", right)
    if near in places and right not in places and not is_other and (near != suggested_name or count[right] > 1):
        line, wrong = count_line(code, places[near].start()), decode_line(places[near][0])
        message = f"{unset} has no value, and line {line} sets {wrong}, which nothing uses; write {unset} there"
        edit = Remedy(f"write {unset}", unset, line=line, misspelt=wrong, is_choice=not slip)
        return replace(item, message=message, edits=(edit,))
    is_other = _OF_AXIS.sub("", suggested_name) == _OF_AXIS.sub("", right)
    if count[suggested_name] > 1 and (
        count[right] > 1 or is_other
    ):  # both are in use: a line that sets the one is missing
        return replace(item, message=f"{unset} has no value; set it first with {unset}=...", edits=())
    return None


def _find_mistyped_end(source: Text, item: Finding, dialect: str) -> Finding | None:
    """The word before the next program that may be a mistyped M30, where the program runs on."""
    line = (item.line or 1) - 1
    raw = take_line(source, line) if line else None
    match = None if raw is None else _LIKE_END.match(remove_remarks(raw.decode("utf-8", "replace"), dialect))
    if match is None:
        return None
    wrong = match[1]
    edit = Remedy("write M30", "M30", line=line, misspelt=wrong, is_choice=True)
    others = (replace(one, is_choice=True) for one in item.edits)
    return replace(item, message=f"{item.message}, or in place of {wrong} in line {line}", edits=(edit, *others))


def _is_at(match: re.Match[str], item: Finding, group: str | int = 0) -> bool:
    """Whether a finding stands in a word."""
    return match.start(group) < (item.column or 0) <= match.end(group) + 1


def _find_letter_of_digit(text: str, item: Finding) -> Finding | None:
    """The word at a column, with the digit whose key is beside in place of a letter; 0 alone looks like its P."""
    at = (item.column or 1) - 1
    for match in _LETTER_OF_DIGIT.finditer(text, max(at - _LONGEST, 0), at + _LONGEST):
        if match[3].upper() == match[1][0].upper():  # there twice
            continue
        is_zero, has_digit = match[3] in "Pp", bool(match[2].strip("."))
        if not _is_at(match, item) or not (has_digit or match[4][:1] == "." or not is_zero):
            continue
        right = f"{match[1]}{match[2]}{match[3].upper().translate(DIGITS_OF_KEYS)}{match[4]}"
        is_sure = item.code == "VP001" and is_zero
        meaning = f"did you mean {right}?" if is_sure else f"{right}{MAY_BE_MEANT}"
        meaning += "" if is_zero else ", whose key is beside"
        edit = Remedy(f"write {right}", right, line=item.line or 0, misspelt=match[0], is_choice=not is_sure)
        message = f"{match[0]}: the letter {match[3].upper()} in a number; {meaning}"
        return replace(item, code="VP001", message=message, column=match.start() + 1, edits=(edit,))
    return None


def propose_words(item: Finding, wrong: str, rights: Iterable[str]) -> tuple[Remedy, ...]:
    """The words of which one may be meant by a wrong one in the line of a finding, each as a choice."""
    return write_words(wrong, *rights, line=item.line or 0, is_choice=True)
