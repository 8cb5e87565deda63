"""Numbers that stand without their letter, and so would be read as part of the number before them."""

import re
from typing import Final

import numpy as np

from verne_post.base.arrays import Ints
from verne_post.gcode.program_error import ProgramError

#: What may be such a number: it stands behind a blank that follows another number, or N has a point.
_CANDIDATE: Final = re.compile(rb"[0-9.][ \t]+[-+]?[0-9.]|[Nn][ \t]*[0-9]+\.")
_WORD: Final = re.compile(
    r"\([^()]*\)?|;.*|(?P<letter>[A-Z])[ \t]*[-+]?(?P<own>[0-9.]+)(?:[ \t]+(?P<number>[-+]?[0-9.]+))?", re.IGNORECASE
)
_PROGRAM_NUMBER: Final = re.compile(r"[ \t]*([0-9][0-9 \t]*)(?:\(|\r?$)")
_DIGITS_OF_CODES: Final = 2
_LEAST_FEED: Final = 100.0
#: M codes of two digits at the end of programs.
_ENDS: Final = ("30", "99")
_BLOCK_NUMBER: Final = re.compile(r"[ \t/]*(N[ \t]*[0-9]+(?:[ \t]+[0-9]|[ \t]*\.)[0-9 \t.]*)", re.IGNORECASE)


def find_candidates(text: bytes) -> Ints:
    """Lines of a text, from 0, that may have such a number."""
    found = np.array([match.start() for match in _CANDIDATE.finditer(text)], dtype=np.int64)
    if not len(found):
        return np.empty(0, dtype=np.int32)
    ends = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n"))
    return np.searchsorted(ends, found).astype(np.int32)


def refuse_letterless(text: str) -> None:
    """Refuse (VP001) a number behind another one, and a point in a block number, in a line of a Fanuc program.

    Blanks mean nothing in a line, so ``N520 50.`` would be block 52050, and the Z that is missing would be lost.
    Digits alone, as in ``X 2 0``, are one number but behind N.
    """
    if match := _PROGRAM_NUMBER.match(text):
        digits = match[1].rstrip()
        if len(digits) <= _DIGITS_OF_CODES and digits.strip("0"):
            letters = "MO" if len(digits.lstrip("0")) == 1 else "MG" if digits in _ENDS else "GO"
            such = " or ".join(f"{letter}{digits}" for letter in letters)
            text = f"{digits}: a number without a letter before it; write its letter, such as {such}"
            raise ProgramError("VP001", text, match.start(1) + 1)
        meaning = f"did you mean O{digits.removeprefix('0').strip()}?"
        raise ProgramError("VP001", f"{digits}: a number without a letter before it; {meaning}", match.start(1) + 1)
    for match in _WORD.finditer(text):
        letter, number, rest = (match["letter"] or "").upper(), match["number"], text[match.end() :]
        if number and (letter == "N" or not f"{match['own']}{number}".isdigit()):
            if letter == "N" and number.isdigit():
                code = ("M" if number in _ENDS else "G") if len(number) <= _DIGITS_OF_CODES else "S"
                text = (
                    f"{number}: a number without a letter before it, or a blank in N{match['own']}{number}; write "
                    f"{code}{number} or N{match['own']}{number}"
                )
                raise ProgramError("VP001", text, match.start("number") + 1)
            if letter == "G" and match["own"].lstrip("0") == "4":
                text = f"{number}: the time of G4 has no letter before it; write X{number} for seconds, or P"
                raise ProgramError("VP001", text, match.start("number") + 1)
            column = match.start("number") + 1
            if not number.strip("."):
                wrong, right = match[0], f"{match['letter']}{match['own']}."
                raise ProgramError("VP001", f"{wrong}: a blank in a number; did you mean {right}?", match.start() + 1)
            axes = _list_axes(letter, rest)
            unused_axes = [one for one in axes if not re.search(one, text, re.IGNORECASE)]
            if not unused_axes and axes != "IJK":
                unused_axes = [one for one in "ABC" if not re.search(one, text, re.IGNORECASE)]
            others = [f"{axis}{number}" for axis in unused_axes or axes]
            if float(number) >= _LEAST_FEED and not rest.strip() and "F" not in text.upper():
                others.append(f"F{number}")
            *others, last = others
            has_no_point = match["own"].isdigit() or number.isdigit()
            if has_no_point and number[0] not in "+-" and letter in "XYZABCIJKRFS":
                such = f"{', '.join(others)} or {last}" if others else last
                meaning = f"write its letter, such as {such}; or {letter}{match['own']}{number} without the blank"
            else:
                meaning = (
                    f"write its letter, such as {', '.join(others)} or {last}" if others else f"did you mean {last}?"
                )
            raise ProgramError("VP001", f"{number}: a number without a letter before it; {meaning}", column)
        if letter == "N" and "." in match[0]:
            is_alone = not match[0].endswith(".") or not rest.strip() or rest.lstrip()[0] in "(;"
            meaning = ", and a letter may be missing in it" if is_alone else f"; did you mean {match[0][:-1]}?"
            raise ProgramError("VP001", f"{match[0]}: a block number has no decimal point{meaning}", match.start() + 1)


def describe_block_number(text: str) -> str:
    """What LinuxCNC reads as one block number, and may be a word that has lost its letter; empty where nothing is."""
    match = _BLOCK_NUMBER.match(text)
    if match is None:
        return ""
    number = match[1].rstrip()
    return (
        f"{number}: all of it is read as the number of the block, as LinuxCNC does, and moves nothing; if a word "
        "has lost its letter, write it"
    )


def _list_axes(before: str, rest: str) -> str:
    """The axes that a number between a word with the letter ``before`` and the ``rest`` of a line may be of."""
    family = "IJK" if before in "IJK" and before else "XYZ"
    possible = family[family.find(before) + 1 :]
    later = min((letter for letter in "XYZ" if letter in rest.upper()), default="")
    return (possible[: possible.find(later)] if later in possible else "") or possible or family
