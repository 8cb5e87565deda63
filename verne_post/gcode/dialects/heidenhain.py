"""Heidenhain Klartext (iTNC 530, TNC 640): straight lines, circles, contours, planes, cycles, Q parameters.

Each statement is executed on the interpreter's own state: the same frames, checks and moves as in any other program.
docs/heidenhain.md lists the statements.
"""

import re
from itertools import islice
from typing import Final

from verne_post.base.long_text import Text
from verne_post.gcode.dialect import Dialect
from verne_post.gcode.execution import Execution, StopConditions
from verne_post.gcode.initial_state import make_initial_state
from verne_post.gcode.machining.state import State
from verne_post.gcode.setup import Setup
from verne_post.gcode.words import read_whole_lines

_HEADER: Final = re.compile(
    rb"(?:[ \t\r]*+(?:;[^\n]*+)?\n)*+[ \t]*+\d*+[ \t]*+BEGIN[ \t]+PGM(?![A-Z0-9])", re.IGNORECASE
)
#: Lines of no other control: two show a text whose BEGIN PGM is missing or misspelt, where one may be a stray one.
_OWN: Final = re.compile(
    rb"^[ \t]*+\d*+[ \t]*+(?:END[ \t]+PGM(?![A-Z0-9])|TOOL[ \t]+CALL[ \t]|CYCL[ \t]+DEF[ \t]|TRANS[ \t]+DATUM"
    rb"|L[ \t][^;(\n]*FMAX(?![A-Z0-9]))",
    re.IGNORECASE | re.MULTILINE,
)
_COMMENT: Final = re.compile(rb";[^\n]*")
_VALUE: Final = rb"[ \t]*[+-]?[ \t]*(?:[0-9.,]|Q[LR]?[0-9])"
#: What gives A and C a position without naming them.
_TURNS: Final = re.compile(rb"PLANE|CYCL[ \t]+DEF[ \t]+19|(?<![A-Z])LN[ \t]")
#: What gives X and Y a position without naming them.
_PLACES: Final = re.compile(rb"(?<![A-Z])I?P[RA][ \t]*[+-]?[0-9Q.,]|CYCL[ \t]+DEF[ \t]+22[01]")


_INCH: Final = (r"^[ \t]*\d*[ \t]*(?:BEGIN|END)[ \t]+PGM[ \t][^;\n]*?[ \t](INCH)(?![^ \t\r\n])", "MM")


def _recognise(source: Text) -> bool:
    """BEGIN PGM is the first statement, or lines are those that only these controls have."""
    head = source[: 1 << 16]
    return _HEADER.match(head) is not None or len(list(islice(_OWN.finditer(head), 2))) > 1


def _names_axis(source: Text, letter: str, setup: Setup) -> bool:
    """True when the letter with a value stands anywhere outside comments: it may give the axis a position."""
    pattern = re.compile(rb"(?<![A-Z])I?" + letter.encode() + _VALUE)
    other = _TURNS if letter in setup.rotary_letters else _PLACES if letter in "XY" else None
    for whole in (source, *setup.subroutines.values()):
        for part in read_whole_lines(whole):
            text = _COMMENT.sub(b"", part).upper()
            if pattern.search(text) or (other is not None and other.search(text)):
                return True
    return False


def _execute(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    # most programs speak another language, and every run loads all dialects
    from verne_post.gcode.klartext.flow import execute_klartext

    return execute_klartext(source, setup, state, stop)


DIALECT: Final[Dialect] = Dialect(_recognise, make_initial_state, _execute, _names_axis, (".h",), inch=_INCH)
