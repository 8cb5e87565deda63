"""Slips of typing in blocks of letters and numbers, of RS274/NGC and Fanuc, that the rest of a program gives away."""

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from verne_post.base.long_text import Text, take_line
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
from verne_post.gcode.text import count_name
from verne_post.model.findings import Finding, Remedy

#: Characters of a line that are looked at on both sides of a column.
_LONGEST: Final = 40
_LONGEST_NAME: Final = 90
#: The label of an O word with a letter in its number, its O one place too far, or a key beside O.
_LABEL: Final = re.compile(
    r"[ \t]*(?:N\d+[ \t]*)?"
    r"(O(?=\d*[EOPLQRTUWY])[\dEOPLQRTUWY]{1,9}|\dO\d{1,9}|[IKLP](?:<[^<>]*>|\d{1,9}(?=[ \t]+[A-Z]{2})))[ \t]*"
    r"(?=(?:(?:END)?(?:SUB|IF|WHILE|REPEAT)|CALL|RETURN|DO|ELSE(?:IF)?|BREAK|CONTINUE)(?![A-Z]))",
    re.IGNORECASE,
)
#: A name between an O word and its keyword whose < is one place too far, or missing.
_NAME_OF_LABEL: Final = re.compile(
    r"[ \t]*(?:N\d+[ \t]*)?(<?O([A-Z_]\w{0,40})>)[ \t]*(?=(?:(?:END)?(?:SUB|IF|WHILE|REPEAT)|CALL|RETURN)(?![A-Z]))",
    re.IGNORECASE,
)
#: A word with a letter in its number whose key is beside that of a digit.
_LETTER_OF_DIGIT: Final = re.compile(
    r"(?<![A-Z_#<])([A-FH-LNQ-Z][-+]?)(\d{0,9}\.?\d{0,9})([EPQRTUW])(\d{0,9}\.?\d{0,9})(?![\w#\[<.])", re.IGNORECASE
)
_LIKE_END: Final = re.compile(r"[ \t]*(?:N\d+[ \t]+)?(N30|M0?3|M3O|M39|M40)[ \t\r]*$", re.IGNORECASE)
#: T beside axes in place of G, whose key is beside: codes that stand there as a rule.
_T_FOR_G: Final = re.compile(r"T(4[0139]|49|80|9[01])(?![\d.])", re.IGNORECASE)
#: T and a number with a point, in place of Y, whose key is beside; a word of Y.
_T_FOR_Y: Final = re.compile(r"T(\d{1,4}\.\d{0,4})(?![\d.])", re.IGNORECASE)
_Y: Final = re.compile(r"(?<![A-Z_#<])Y[ \t]*[-+.\d#\[]", re.IGNORECASE)
#: What is said of a corner where none can be, or of a cycle whose R is taken for one; the column is none of it.
_LIKE_COMMA: Final = re.compile(r",[RC] must follow|G\d\d needs R,")
#: A whole number and a comma that stands for its point, before a word that would be the corner of a contour.
_COMMA: Final = re.compile(r"((?<![A-Z_#<])[XYZ][-+]?\d{1,9}),[ \t]*([RC]\d{0,9}\.?\d{0,9})", re.IGNORECASE)
_CHANGE_OR_NO_AXIS: Final = re.compile(r"[^(]*M0*6(?!\d)|[^(XYZAC]*(?:\(|$)", re.IGNORECASE)
#: A tool, and a 6 that has lost its M.
_CHANGE_WITHOUT_M: Final = re.compile(r"(T\d{1,4})[ \t]+(0?6)(?![\d.])", re.IGNORECASE)
#: A variable, and a number behind a blank.
_NUMBER_BEHIND: Final = re.compile(r"#(\d{1,3})[ \t]+(\d{1,6}(?:\.\d{0,6})?)(?![\w.])")
#: An M code without its zeros, and what M6 and M30 become by a key that is struck twice or beside.
_FUNCTION: Final = re.compile(r"M0*(\d{2,3})(?!\d)", re.IGNORECASE)
_LIKE_CHANGE: Final = ("66", "56", "65", "67", "76")
_BESIDE_END: Final = ("20", "33", "39", "40")
_WITH_T: Final = re.compile(r"(?<![A-Z_#<])T[ \t]*[\d=#]", re.IGNORECASE)
_FUNCTIONS_ALONE: Final = re.compile(r"[ \t/]*(?:N?\d+[ \t]*)?(?:M\d+[ \t]*)+(?:[;(].*)?\r?", re.IGNORECASE)
_NEXT_PROGRAM: Final = re.compile(rb"\s*(?:%|O[ \t]*\d|\d*[ \t]*END[ \t]+PGM)", re.IGNORECASE)
_BLANK_LINES: Final = 5
_SIGN_BEHIND: Final = re.compile(r"(?<![A-Z_#<\d.])([A-Z])(\d)-(\.\d{1,9})(?![\w.])", re.IGNORECASE)
_LESS_BEHIND: Final = re.compile(r"#([A-Z_])<(\w{0,40})>", re.IGNORECASE)
_BARE_NAME: Final = re.compile(r"[ \t]*(<[^<>=]+>)[ \t]*=")
#: A variable, and one that is given a value; two names that only tell two axes apart are no slip of each other.
_VARIABLE: Final = re.compile(rb"#(?:<[^<>\n]{1,80}>|\d{1,5}(?!\d))")
_SET: Final = re.compile(_VARIABLE.pattern + rb"(?=[ \t]*=(?!=))")
_OF_AXIS: Final = re.compile(r"_[a-cu-z]>", re.IGNORECASE)
#: A program number with the key beside O; what ends a program or stands before the first.
_HEAD: Final = re.compile(r"[ \t]*([IKLP](\d{2,9}))[ \t]*(?:\(|$)", re.IGNORECASE)
_BEFORE_HEAD: Final = re.compile(rb"\s*(?:%|(?:N\s*\d+\s*)?M\s*0*(?:2|30|99)\b)", re.IGNORECASE)
_LENGTH_OR_MOVE: Final = re.compile(r"(?<![A-Z_#<])(H0*([0-3]))(?![\d.])", re.IGNORECASE)
#: E beside G41 or G42, whose D has the key beside.
_EDGE: Final = re.compile(r"E(\d{1,3})(?![\d.])", re.IGNORECASE)
_OF_CONTOUR: Final = re.compile(r"G4[12](?![\d.])", re.IGNORECASE)
_CALL_SWAPPED: Final = re.compile(r"M89(?=[ \t]*P[ \t]*\d)", re.IGNORECASE)


def explain_slip(source: Text, text: str, item: Finding, dialect: str) -> Finding | None:
    """What a slip in the line of an error is, and the edits that settle it; None where it is none of these."""
    if item.code in ("VP001", "VP023") and (match := _LABEL.match(text)) and _is_at(match, item, 1):
        wrong = match[1]
        right, what = f"{wrong[0]}{wrong[1:].upper().translate(DIGITS_OF_KEYS)}", "a letter in a number"
        if wrong[1:2] in "Oo" and wrong[0] in "Oo" and wrong[2:].isdecimal():
            right, what = wrong[1:], "the letter is there twice"
        if wrong[1] in "Oo" and wrong[0].isdigit():
            right, what = f"{wrong[1]}{wrong[0]}{wrong[2:]}", "a digit before its letter"
        elif wrong[0] not in "Oo":
            right, what = f"o{wrong[1:]}", "a label begins with O"
        message = f"{wrong}: {what}; did you mean {right}?"
        return replace(item, code="VP001", message=message, column=match.start(1) + 1, edits=(), settled_by=())
    if item.code == "VP001" and (match := _NAME_OF_LABEL.match(text)) and _is_at(match, item, 1):
        wrong, right = match[1], f"o<{match[2]}>"
        if wrong[0] != "<" or (count_name(source, right) and not count_name(source, f"o{wrong}")):
            message = f"{wrong}: the < of the name is {'missing' if wrong[0] != '<' else 'before the o'}"
            message += f"; did you mean {right}?"
            return replace(item, message=message, column=match.start(1) + 1, edits=())
    if item.code == "VP001" and (found := _find_written_so(source, text, item)):
        wrong, right, column, what = found
        edit = Remedy(f"write {right}", right, line=item.line or 0, misspelt=wrong)
        return replace(item, message=f"{wrong}: {what}; did you mean {right}?", column=column, edits=(edit,))
    if item.code == "VP001" and (match := _BARE_NAME.match(text)) and _is_at(match, item, 1):
        message = f"{match[1]}: a name without # before it; did you mean #{match[1]}?"
        return replace(item, message=message, column=match.start(1) + 1)
    if item.code == "VP001" and text.strip() == "%":
        return replace(item, edits=(Remedy("take % out", misspelt="%", line=item.line or 0),))
    if item.code == "VP006" and (match := _EDGE.match(text, (item.column or 1) - 1)) and _OF_CONTOUR.search(text):
        right = f"D{match[1]}"
        message = f"{item.message}; {right}{MAY_BE_MEANT}, whose key is beside"
        return replace(item, message=message, edits=propose_words(item, match[0], [right]))
    is_useless_p = item.code == "VP006" and item.column is not None and text[item.column - 1 :][:1] in ("P", "p")
    if item.code == "VP001" or is_useless_p:
        if item.message.endswith(MAY_BE_MEANT):
            return None
        return _find_letter_of_digit(text, item)
    if item.code == "VP025" and (match := _NUMBER_BEHIND.match(text, (item.column or 1) - 1)):
        rights = [f"#{match[1]} {letter}{match[2]}" for letter in ("F", "X", "Y", "Z")]
        message = (
            f"{match[0]}: blanks mean nothing in a number, so that this is #{match[1]}{match[2]}; {match[2]} may lack "
            f"its letter, such as F{match[2]}"
        )
        edits = propose_words(item, match[0], rights)
        return replace(item, code="VP001", message=message, edits=edits, settled_by=())
    if item.code == "VP012" and (match := _CHANGE_WITHOUT_M.match(text, (item.column or 1) - 1)):
        right = f"{match[1]} M{match[2]}"
        message = f"{match[0]}: blanks mean nothing in a number, so that this is {match[1]}{match[2]}"
        message += f"; {right}{MAY_BE_MEANT}"
        edits = propose_words(item, match[0], [right])
        return replace(item, code="VP001", message=message, edits=edits, settled_by=())
    if item.code == "VP012" and (match := _T_FOR_Y.match(text, (item.column or 1) - 1)) and not _Y.search(text):
        right = f"Y{match[1]}"
        message = f"{match[0]}: {right}{MAY_BE_MEANT}, whose key is beside; as it stands: {item.message}"
        message = message.split("; did you mean ")[0]  # another tool
        others = (replace(one, is_choice=True) for one in item.edits)
        return replace(item, message=message, edits=(*propose_words(item, match[0], [right]), *others))
    if _LIKE_COMMA.match(item.message) and (match := _COMMA.search(text)):
        right = f"{match[1]}. {match[2]}"
        message = f"{match[0]}: a comma in place of the point; did you mean {right}?"
        edit = Remedy(f"write {right}", right, line=item.line or 0, misspelt=match[0])
        return replace(item, code="VP001", message=message, column=match.start() + 1, edits=(edit,))
    if item.code == "VP012" and (match := _T_FOR_G.match(text, (item.column or 1) - 1)):
        if _CHANGE_OR_NO_AXIS.match(text):
            return None
        right = f"G{match[1]}"
        edits = propose_words(item, match[0], [right])
        others = (replace(one, is_choice=True) for one in item.edits)
        return replace(
            item,
            message=f"{match[0]}: {right}{MAY_BE_MEANT}, whose key is beside; as it stands: {item.message}",
            edits=(*edits, *others),
        )
    if item.code == "VP025" and (unset := _VARIABLE.match(text[(item.column or 1) - 1 :][:_LONGEST_NAME].encode())):
        return _find_misspelt_setting(source, item, unset[0].decode())
    if item.code == "VP024" and any((one.value, one.way) == ("M30", "before") for one in item.edits):
        return _find_mistyped_end(source, item, dialect)
    if (
        item.code == "VP002"
        and (match := re.fullmatch(r"[ \t]*(?:N\d+[ \t]*)?(M89)[ \t]*", text))
        and dialect == "fanuc"
    ):
        after = take_line(source, (item.line or 0) + 1)
        if after is None or not re.match(rb"[ \t]*(?:O[ \t]*\d|%)", after):
            return None
        edit = Remedy("write M99", "M99", line=item.line or 0, misspelt="M89", is_choice=True)
        message = f"M89: no meaning in this language; M99, the end of a subprogram, {MAY_BE_MEANT.strip()}"
        return replace(item, message=message, edits=(edit,))
    if item.code == "VP006" and dialect == "fanuc" and (match := _HEAD.match(text)) and _is_at(match, item, 1):
        before = take_line(source, (item.line or 1) - 1) if (item.line or 1) > 1 else None
        if before is None or not _BEFORE_HEAD.match(before):
            return None
        message = f"{match[1]}: nothing in the block uses it; did you mean O{match[2]}?"
        return replace(item, message=message, edits=(), settled_by=())
    if item.code == "VP017" and any(one.value == "G40" for one in item.edits):
        match = _LENGTH_OR_MOVE.search(remove_remarks(text, dialect))
        if match is None or re.search(r"G[ \t]*0*4[39]", text, re.IGNORECASE):
            return None
        right = f"G{match[1][1:]}"
        edits = propose_words(item, match[1], [right])
        message = f"{match[1]}: {right}{MAY_BE_MEANT}, whose key is beside; as it stands: {item.message}"
        return replace(item, message=message, column=match.start(1) + 1, edits=edits)
    if item.code == "VP002" and item.column and (match := _CALL_SWAPPED.match(text, item.column - 1)):
        edit = Remedy("write M98", "M98", line=item.line or 0, misspelt=match[0], is_choice=True)
        message = f"{match[0]}: no meaning in this language; M98, which calls P{MAY_BE_MEANT}"
        return replace(item, message=message, edits=(edit,))
    return None


def _find_written_so(source: Text, text: str, item: Finding) -> tuple[str, str, int, str] | None:
    """What is written and meant, the column and the cause: a sign or < is one place too far."""
    at = (item.column or 1) - 1
    begin, end = max(at - _LONGEST, 0), at + _LONGEST
    for pattern, right, what in (
        (_SIGN_BEHIND, r"\1-\2\3", "the sign after a digit"),
        (_LESS_BEHIND, r"#<\1\2>", "the < after a letter"),
    ):
        for match in pattern.finditer(text, begin, end):
            if pattern is _LESS_BEHIND and count_name(source, f"#<{match[2]}>"):
                right, what = r"\1#<\2>", "the # before its letter"
                if re.search(r"[A-Z\[=+*/-]$", text[: match.start()].rstrip(), re.IGNORECASE):  # no word begins there
                    right, what = r"#<\2>", "a letter before the <"
            if _is_at(match, item):
                return match[0], match.expand(right), match.start() + 1, what
    return None


def explain_function(source: Text, text: str, item: Finding) -> Finding | None:
    """An M code without a meaning, of which M6 beside T, or M30 in the last block, is a slip; None for others."""
    match = _FUNCTION.match(text, (item.column or 1) - 1)
    if match is None or ("remap", f"M{match[1]}") not in item.settled_by:
        return None
    code, line = match[1], item.line or 0
    after = (take_line(source, number) for number in range(line + 1, line + _BLANK_LINES))
    following = next((one for one in after if one is None or one.strip()), None)
    if _WITH_T.search(text) and code in _LIKE_CHANGE and not item.edits:
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
    count = Counter(one.decode().lower() for one in _VARIABLE.findall(code))
    places = {one[0].decode().lower(): one for one in _SET.finditer(code)}
    unused_names = [one for one in places if count[one] == 1 and ("<" in one) == ("<" in right)]
    slip = find_meant(right, unused_names, slip_alone=True) if "<" in right else ""
    numbers = list_near_numbers(right[1:], [one[1:] for one in unused_names])
    near = slip or (find_meant(right, unused_names) if "<" in right else "#".join(["", *numbers]))
    suggested_name = (find_correction(item.message) or ("", ""))[1].lower()
    is_other = _OF_AXIS.sub("", near) == _OF_AXIS.sub("", right)
    if near in places and right not in places and not is_other and (near != suggested_name or count[right] > 1):
        line, wrong = code.count(b"\n", 0, places[near].start()) + 1, places[near][0].decode()
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


def _is_at(match: re.Match[str], item: Finding, group: int = 0) -> bool:
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
