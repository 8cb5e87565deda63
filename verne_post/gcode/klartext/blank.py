"""BLK FORM: the two corners of a box, or a cylinder."""

import re
from typing import Final

from msgspec.structs import replace

from verne_post.gcode.klartext.first_words import LETTERS_AS_DIGITS
from verne_post.gcode.klartext.formulas import VALUE, Numbers, read_value
from verne_post.gcode.klartext.slips import find_slip
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.program_error import write_words
from verne_post.model.moves import ZERO9, Frame, Stock

#: ``0.1 Z X-40 Y-30 Z-10``, ``0.2 X+40 IY+60 Z+5``, ``CYLINDER Z R50 L105 DIST+5 RI10``.
_FORM: Final = re.compile(r"[ \t]+(?:(0[.,]1)[ \t]+([XYZ])|(0[.,]2)|(CYLINDER)[ \t]+([XYZ]))(?=[ \t])")
_CORNER_WORD: Final = re.compile(rf"[ \t]*(I?[XYZ])[ \t]*({VALUE})")
_CYLINDER_WORD: Final = re.compile(rf"[ \t]*(DIST|RI|DI|R|D|L)[ \t]*({VALUE})")


class Blank:
    """What BLK FORM statements have defined so far."""

    def __init__(self) -> None:
        #: X, Y and Z of the first corner; empty after one that was refused, None before any.
        self._low: dict[str, float] | None = None
        self.open_line = 0  #: Of a first corner without a second one so far.

    def read(self, statement: Statement, numbers: Numbers, unit: float, frame: Frame) -> Stock | None:
        """The stock that a statement completes; None for a first corner, a line of both corners, and text-only forms.

        Parameters
        ----------
        unit : float
            Mm of a unit of the program.
        frame : Frame
            The frame in force.

        Raises
        ------
        ProgramError
            For a corner without a coordinate, and for a stock without a size.
        """
        form = _FORM.match(statement.rest)
        slip = re.match(
            r"[ \t]+(?!0[.,][12][ \t])(?=[\dOLI]*[-:.,]|0 ?[12][ \t])[O\d]?[-:., ]{0,2}([12LI])(?=[ \t])",
            statement.rest,
        )
        if slip is not None:
            self._low = {}
            written_text, right = slip[0].strip(), f"0.{slip[1].translate(LETTERS_AS_DIGITS)}"
            edits = write_words(written_text, right)
            what = "the point is missing" if written_text.isdigit() else "no number of a corner"
            text = f"BLK FORM {written_text}: {what}; write BLK FORM {right}"
            raise statement.error("VP001", text, 0, edits)
        joined_words = re.match(r"[ \t]+0[.,]1[ \t]+(([XYZ])([XYZ][-+\d]\S*))", statement.rest)
        if form is None and joined_words is not None:
            self._low = {}
            text = f"{joined_words[1]}: a blank is missing; did you mean {joined_words[2]} {joined_words[3]}?"
            raise statement.error("VP001", text, joined_words.start(1))
        axis = re.match(r"[ \t]+0[.,]1[ \t]+([A-Z]\d*)(?=[ \t])", statement.rest)
        if form is None and axis is not None:
            self._low = {}
            raise statement.error("VP001", f"{axis[1]}: no axis of the tool; did you mean Z?", axis.start(1))
        without_axis = re.match(r"[ \t]+(0[.,]1)[ \t]+[XYZ][-+]", statement.rest)
        if form is None and without_axis is not None:
            wrong = without_axis[1]
            what, right = "the axis of the tool is missing after it", f"{wrong} Z"
            if self._low is None:
                self._low = {}
            else:
                what, right = "the first corner, which is given already", f"{wrong[:-1]}2"
            raise statement.refuse_word(wrong, what, right, at=without_axis.start(1))
        if re.match(r"[ \t]+0[.,]2[ \t]+[XYZ][ \t]+[XYZ]", statement.rest) and self._low is None:
            self._low = {}
            what = "the second corner, and an axis of the tool as for the first one"
            raise statement.refuse_word("0.2", what, "0.1", at=0)
        if form is None:
            return None
        pattern = _CYLINDER_WORD if form[4] else _CORNER_WORD
        words = _read_words(statement, form.end(), pattern, numbers, unit)
        outside = replace(frame, tool=ZERO9, feature=None)
        if form[4]:
            return _make_cylinder(statement, words, form[5], outside)
        missing = [letter for letter in "XYZ" if letter not in words and (form[1] or "I" + letter not in words)]
        if form[1]:
            self._low = {} if missing else words
        self.open_line = statement.line if form[1] else 0
        if missing:
            raise statement.error("VP005", f"BLK FORM needs X, Y and Z; {missing[0]} is missing")
        if form[1]:
            return None
        if self._low is None:
            raise statement.error("VP017", "BLK FORM 0.2 needs BLK FORM 0.1 before it")
        if not self._low:
            return None
        low = [self._low[letter] for letter in "XYZ"]
        high = [
            words.get(letter, start + words.get("I" + letter, 0.0)) for letter, start in zip("XYZ", low, strict=True)
        ]
        if low == high:  # as CAM systems write it where nobody has given a stock
            return None
        return _check_size(statement, Stock(statement.line, _read_triple(low), _read_triple(high), outside))


def _read_words(
    statement: Statement, at: int, pattern: re.Pattern[str], numbers: Numbers, unit: float
) -> dict[str, float]:
    words: dict[str, float] = {}
    text = statement.rest.rstrip()
    while at < len(text):
        word = pattern.match(text, at)
        if word is None:
            begin = at + len(text[at:]) - len(text[at:].lstrip())
            if slip := find_slip(pattern, statement, text, begin):
                raise slip
            raise statement.error("VP001", f"{text[at:].strip()[:15]!r} is not a word of BLK FORM", at)
        if word[1] in words:
            raise statement.error("VP004", f"{word[1]} appears twice in the block", at)
        words[word[1]] = unit * read_value(word[2], numbers)
        at = word.end()
    return words


def _make_cylinder(statement: Statement, words: dict[str, float], axis: str, frame: Frame) -> Stock:
    """DIST is the height of the upper end."""
    if axis != "Z":
        raise statement.error("VP002", f"BLK FORM CYLINDER {axis} is not read; only a cylinder along Z")
    if ("R" in words) == ("D" in words) or "L" not in words:
        raise statement.error("VP005", "BLK FORM CYLINDER needs R or D, and L")
    radius, top = words.get("R", 0.5 * words.get("D", 0.0)), words.get("DIST", 0.0)
    bore = words.get("DI", 2.0 * words.get("RI", 0.0))
    low, high = (-radius, -radius, top - words["L"]), (radius, radius, top)
    if not 0.0 <= bore < 2.0 * radius:
        raise statement.error("VP007", f"BLK FORM CYLINDER: a bore of {bore:g} mm in a diameter of {2 * radius:g} mm")
    return _check_size(statement, Stock(statement.line, low, high, frame, round=True, bore=bore))


def _check_size(statement: Statement, stock: Stock) -> Stock:
    for letter, size in zip("XYZ", stock.size, strict=True):
        if not size > 0.0:
            raise statement.error(
                "VP007", f"BLK FORM: the stock is {size:g} mm long in {letter}; it must be more than 0"
            )
    return stock


def _read_triple(values: list[float]) -> tuple[float, float, float]:
    x, y, z = values
    return x, y, z
