"""Numbers that stand without their letter, and so would be read as part of the number before them."""

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

import numpy as np

from verne_post.base.arrays import Ints
from verne_post.base.program_lines import remove_remarks
from verne_post.gcode.program_error import ProgramError, write_words
from verne_post.model.findings import Remedy

#: What may be such a number: it stands behind a blank that follows another number, or N has a point.
_CANDIDATES: Final = (re.compile(rb"[0-9.][ \t]+[-+]?[0-9.]"), re.compile(rb"[Nn][ \t]*[0-9]+\."))
_WORD: Final = re.compile(
    r"\([^()]*\)?|;.*|(?P<letter>[A-Z])[ \t]*[-+]?(?P<own>[0-9.]+)(?:[ \t]+(?P<number>[-+]?[0-9.]+))?", re.IGNORECASE
)
_PROGRAM_NUMBER: Final = re.compile(r"[ \t]*([0-9][0-9 \t]*)(?:\(|\r?$)")
_DIGITS_OF_CODES: Final = 2
#: A word, the name of a parameter or what it becomes, and a number behind a blank.
_WORD_AND_NUMBER: Final = re.compile(
    r"\([^()]*\)?|;.*|(?P<letter>[A-Z]|[A-Z]?#|#(?:[0-9]++|<[^<>]*+>)[ \t]*+=)"
    r"[ \t]*+(?P<own>[-+]?+[ \t]*+[0-9.]++)[ \t]++"
    r"(?P<number>(?:[-+][ \t]*+)?[0-9.]++)(?P<more>(?:[ \t]++[0-9.]++)*+)(?![ \t]*+\])",
    re.IGNORECASE,
)
#: Words whose numbers have two digits as a rule: a letter may be missing between any two.
_WORDS_OF_CODES: Final = "GMNTHD"
#: Words of a motion in the order in which they are written.
_ORDER: Final = "XYZACF"
_POINT_IN_NUMBER: Final = re.compile(r"[ \t/]*(N[ \t]*[0-9]+[ \t]*\.[0-9 \t.]*)", re.IGNORECASE)
#: What follows a digit that stands before its letter.
_LETTER_AND_DIGITS: Final = re.compile(r"([A-Z])(\d+)(?![\w.])", re.IGNORECASE)
_AS_NUMBER: Final = (
    "all of it is read as the number of the block, as LinuxCNC does, and moves nothing; if a word has lost its letter, "
    "write it"
)
_LEAST_FEED: Final = 100.0
#: Characters behind a number that say which letter it may have lost, so that a long line takes no time.
_LOOKED_AT: Final = 200
#: M codes of two digits at the end of programs.
_ENDS: Final = ("30", "99")


def find_candidates(text: bytes) -> Ints:
    """Lines of a text, from 0, that may have such a number."""
    signs = np.frombuffer(text, dtype=np.uint8)
    behind_blank = signs[1:][(signs[:-1] == ord(" ")) | (signs[:-1] == ord("\t"))]
    # most programs have neither, and a look at each byte is ten times as fast as the pattern
    may_match = (np.isin(behind_blank, list(b"+-.0123456789")).any(), b"N" in text or b"n" in text)
    patterns = (one for one, may_be in zip(_CANDIDATES, may_match, strict=True) if may_be)
    found = np.array([match.start() for one in patterns for match in one.finditer(text)], dtype=np.int64)
    if not len(found):
        return np.empty(0, dtype=np.int32)
    ends = np.flatnonzero(signs == ord("\n"))
    return np.searchsorted(ends, np.sort(found)).astype(np.int32)


def refuse_letterless(text: str) -> None:
    """Refuse (VP001) a number behind another one, and a point in a block number, in a line of a Fanuc program.

    Blanks mean nothing in a line, so ``N520 50.`` would be block 52050, and the Z that is missing would be lost.
    Digits alone, as in ``X 2 0``, are one number but behind N.
    """
    if match := _PROGRAM_NUMBER.match(text):
        digits = match[1].rstrip()
        if len(digits) <= _DIGITS_OF_CODES and digits.strip("0"):
            letters = "MO" if len(digits.lstrip("0")) == 1 else "MG" if digits in _ENDS else "GO"
            words = [f"{letter}{digits}" for letter in letters]
            text = f"{digits}: a number without a letter before it; write its letter, such as {' or '.join(words)}"
            raise ProgramError("VP001", text, match.start(1) + 1, edits=write_words(digits, *words))
        meaning = f"did you mean O{digits.removeprefix('0').strip()}?"
        raise ProgramError("VP001", f"{digits}: a number without a letter before it; {meaning}", match.start(1) + 1)
    for match in _WORD.finditer(text):
        if match["letter"] is None:
            continue
        letter, number, rest = match["letter"].upper(), match["number"], text[match.end() :]
        if number and (letter == "N" or not f"{match['own']}{number}".isdigit()):
            if letter == "N" and number.isdigit():
                right = f"{_find_letter_of_code(number, rest) if len(number) <= _DIGITS_OF_CODES else 'S'}{number}"
                text = (
                    f"{number}: a number without a letter before it, or a blank in N{match['own']}{number}; write "
                    f"{right} or N{match['own']}{number}"
                )
                edits = write_words(number, right, is_choice=True)
                raise ProgramError("VP001", text, match.start("number") + 1, edits=edits)
            if letter == "G" and match["own"].lstrip("0") == "4":
                text = f"{number}: the time of G4 has no letter before it; write X{number} for seconds, or P"
                raise ProgramError("VP001", text, match.start("number") + 1)
            column = match.start("number") + 1
            if not number.strip(".") or (letter == "G" and match["own"].endswith(".")):
                wrong, right = match[0], f"{match['letter']}{match['own']}{number.strip('.') or '.'}"
                raise ProgramError("VP001", f"{wrong}: a blank in a number; did you mean {right}?", match.start() + 1)
            if number.count(".") > 1:
                raise ProgramError("VP001", f"{number}: two points in a number, and no letter before it", column)
            axes = _list_axes(letter, rest)
            unused_axes = [one for one in axes if not re.search(one, text, re.IGNORECASE)]
            if (not unused_axes or letter in "ZABC") and axes != "IJK":
                unused_axes = _list_unused_turns(text)
            is_divided = match["own"].isdigit() or number.isdigit()
            if not unused_axes and axes != "IJK" and is_divided and number[0] not in "+-":
                wrong, right = match[0], "".join(match[0].split())
                raise ProgramError("VP001", f"{wrong}: a blank in a number; did you mean {right}?", match.start() + 1)
            others = [f"{axis}{number}" for axis in unused_axes or axes]
            if float(number) >= _LEAST_FEED and not rest.strip() and "F" not in text.upper():
                others.append(f"F{number}")
            edits = write_words(number, *others) if others[1:] else ()
            *others, last = others
            if is_divided and number[0] not in "+-" and letter in "XYZABCIJKRFS":
                such = f"{', '.join(others)} or {last}" if others else last
                right = "".join(match[0].split())
                meaning = f"write its letter, such as {such}; or {right} without the blank"
                edits = write_words(match[0], right, is_choice=True)
                edits += write_words(number, *others, last, is_choice=True)
            else:
                meaning = (
                    f"write its letter, such as {', '.join(others)} or {last}" if others else f"did you mean {last}?"
                )
            text = f"{number}: a number without a letter before it; {meaning}"
            raise ProgramError("VP001", text, column, edits=edits)
        if letter == "N" and "." in match[0]:
            is_alone = not match[0].endswith(".") or not rest.strip() or rest.lstrip()[0] in "(;"
            meaning = ", and a letter may be missing in it" if is_alone else f"; did you mean {match[0][:-1]}?"
            raise ProgramError("VP001", f"{match[0]}: a block number has no decimal point{meaning}", match.start() + 1)


def _find_letter_of_code(number: str, rest: str) -> str:
    """M of a number of one digit alone in its block, and of an end; else G."""
    is_alone = len(number.lstrip("0")) <= 1 and not remove_remarks(rest).strip()
    return "M" if is_alone or number in _ENDS else "G"


class Divided(NamedTuple):
    """A number that a blank divides: the letter of its word, its first and last column, and what may be meant."""

    letter: str
    begin: int
    end: int
    error: ProgramError


def find_divided(text: str, line: int = 0) -> Iterator[Divided]:
    """Numbers that a blank divides, as in X15 28.

    LinuxCNC reads one number, X1528.
    """
    if (point := _POINT_IN_NUMBER.match(text)) is not None:
        error = ProgramError("VP001", f"{point[1].rstrip()}: {_AS_NUMBER}", point.start(1) + 1)
        yield Divided("N", point.start(1) + 1, point.end(1), error)
        return
    depth = counted_to = 0
    for match in _WORD_AND_NUMBER.finditer(text):
        if match["letter"] is None or match["letter"].upper() == "O":
            continue
        depth += text.count("[", counted_to, match.start()) - text.count("]", counted_to, match.start())
        counted_to, rest = match.start(), text[match.end() : match.end() + _LOOKED_AT]
        if depth > 0:
            continue
        word, number = f"{match['letter']}{''.join(match['own'].split())}", match["number"]
        letter, begin, end = match["letter"].upper(), match.start() + 1, match.end("number")
        is_of_block = letter == "N"
        is_sum = number[0] in "+-" and re.match(r"[-+][ \t]", match["own"]) is not None  # X- 5 + 3 lacks its brackets
        if is_sum or (letter[0] == "#" and not number.isdigit()):
            continue
        behind = _LETTER_AND_DIGITS.match(rest) if len(number) == 1 and number.isdigit() else None
        # of Z6 0I0 the blank is one place too early
        is_one = behind is not None and number == "0"
        if letter not in _WORDS_OF_CODES and (match["more"] or is_one):
            right = "".join(match[0].split())
            message = (
                f"{match[0]}: blanks mean nothing in a number, so that this is {right}; write {right} without them"
            )
            edits = write_words(match[0], right, line=line, is_choice=True)
            yield Divided(letter, begin, match.end(), ProgramError("VP001", message, begin, edits=edits))
            continue
        if behind is not None and not is_one:
            wrong, right = f"{number}{behind[0]}", f"{behind[1]}{number}{behind[2]}"
            message = f"{wrong}: a digit before its letter, which is read as {word}{number}; {right} may be meant"
            if behind[1] in "Hh" and f"{word}{number}".upper() in ("G43", "G44"):
                wrong, right = f"{match[0]}{behind[0]}", f"{word}{number} {behind[0]}"
                message = f"{wrong}: a blank in a number, which is read as {word}{number}; write {right}"
            edit = Remedy(f"write {right}", right, line=line, misspelt=wrong, is_choice=True)
            error = ProgramError("VP001", message, text.index(wrong, match.start()) + 1, edits=(edit,))
            yield Divided(letter, begin, match.end() + behind.end(), error)
            continue
        if number == ".":
            message = f"{match[0]}: a blank in a number, which is read as {word}.; write {word}"
            edits = write_words(match[0], word, line=line)
            yield Divided(letter, begin, end, ProgramError("VP001", message, begin, edits=edits))
            continue
        if is_of_block:
            message = f"{match[0].strip()}: {_AS_NUMBER}"
        elif number[0] in "+-" or ("." in word and "." in number):
            message = f"{number}: a number without a letter before it"
        else:
            message = f"{match[0].strip()}: blanks mean nothing in a number, so that this is {word}{number}"
        letters = [] if letter[0] == "#" else list_letters(letter[0], "".join(match["own"].split()), number, rest)
        # codes have a zero before their digit, and places have none
        is_code = letters[:1] in (["G"], ["M"]) and re.fullmatch("0[1-9]", number) is not None
        is_one = number.isdigit() and (not letters or (number[0] == "0" and len(number) > 1 and not is_code))
        if is_one:
            edits = write_words(match[0], f"{word}{number}", line=line, is_choice=True)
            message += f"; write {word}{number} without the blank"
            yield Divided(letter, begin, end, ProgramError("VP001", message, begin, edits=edits))
            continue
        words = [f"{one}{number}" for one in letters or ["F"]]
        edits = tuple(Remedy(f"write {one}", one, line=line, misspelt=number, is_choice=True) for one in words)
        such = " or ".join(filter(None, (", ".join(words[:-1]), words[-1])))
        such += ", the time of G4" if re.fullmatch("G0*4", word, re.IGNORECASE) else ""
        message += (
            f", such as {such}; else write {word}{number} without the blank"
            if is_of_block
            else f"; {number} may lack its letter, such as {such}"
        )
        yield Divided(letter, begin, end, ProgramError("VP001", message, match.start("number") + 1, edits=edits))


def list_letters(before: str, own: str, number: str, rest: str) -> list[str]:
    """Letters that a number may have lost: it stands after the word ``before`` ``own``, before the rest of a line."""
    own = own.lstrip("+0").rstrip(".")
    after = next((one for one in _ORDER if re.search(rf"{one}[ \t]*[-+.\d#\[]", rest, re.IGNORECASE)), "")
    if before == "G" and own in ("4", "64"):
        return ["P"]
    if before == "G" and own.startswith("43"):
        return ["H"]
    if before == "G" and len(own) > 1 and number.isdigit():
        return ["G"]
    if before in "TS":
        return ["M"]
    if before == "M" or (before == "F" and number.isdigit()):
        return ["M" if len(number) <= _DIGITS_OF_CODES else "S"]
    is_code = number.isdigit() and len(number) <= _DIGITS_OF_CODES
    if before == "N":
        return (
            [_find_letter_of_code(number, rest)]
            if is_code and (not after or re.match(r"[ \t]*G", rest, re.IGNORECASE))
            else ["X", "Y", "Z"]
        )
    order = "IJKF" if before in "IJK" else _ORDER
    begin = order.find(before) + 1
    if after and order.find(after) == begin > 0:
        return []  # no word has its place between the two
    possible = order[begin : order.find(after)] if after and order.find(after) > begin else order[begin:]
    if before == "G":
        return list(possible.removesuffix("F") if after in tuple("YZAC") else "XYZ")
    return list(dict.fromkeys((possible[:1] or "F", possible[-1:] or "F")))


def _list_unused_turns(text: str) -> list[str]:
    """The rotary axes that a line may lack: no machine has three."""
    unused_axes = [one for one in "ABC" if not re.search(one, text, re.IGNORECASE)]
    return unused_axes if len(unused_axes) > 1 else []


def _list_axes(before: str, rest: str) -> str:
    """The axes that a number between a word with the letter ``before`` and the ``rest`` of a line may be of."""
    family = "IJK" if before in "IJK" and before else "XYZ"
    possible = family[family.find(before) + 1 :]
    later = min((letter for letter in "XYZ" if letter in rest.upper()), default="")
    return (possible[: possible.find(later)] if later in possible else "") or possible or family
