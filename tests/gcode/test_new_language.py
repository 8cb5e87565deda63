"""One more language costs less than 200 lines on the machining core: a sketch of DIN/ISO gives what its Klartext twin
gives.
"""

from pathlib import Path

import numpy as np
import pytest

from tests.gcode import din_iso
from tests.gcode.conftest import make_tool
from verne_post import gcode
from verne_post.gcode.dialects import DIALECTS
from verne_post.gcode.execution import StopConditions

TOOLS = {5: make_tool(5, 60.0, 8.0)}
ISO = """%FACE G71 *
N10 T5 G17 S2500 *
N20 G00 G40 G90 Z+50 M3 *
N30 G00 X-20 Y+10 *
N40 G00 Z+2 *
N50 G01 Z-3 F300 *
N60 G01 G41 X+0 Y+10 F500 *
N70 G01 Y+40 *
N80 I+20 J+40 *
N90 G02 X+20 Y+60 *
N100 G01 X+50 *
N110 G91 G01 Y-20 *
N120 G90 G01 Y+0 *
N130 G40 G01 X+70 *
N140 G00 Z+50 M30 *
N150 %FACE G71 *
"""
KLARTEXT = """BEGIN PGM FACE MM
TOOL CALL 5 Z S2500
L Z+50 R0 FMAX M3
L X-20 Y+10 FMAX
L Z+2 FMAX
L Z-3 F300
L X+0 Y+10 RL F500
L Y+40
CC X+20 Y+40
C X+20 Y+60 DR-
L X+50
L IY-20
L Y+0
L X+70 R0
L Z+50 FMAX M30
END PGM FACE MM
"""


def read(text, dialect=din_iso.DIALECT):
    """The moves and the errors of a text in a dialect."""
    setup = gcode.build_plain_setup(tools=TOOLS)
    state = dialect.initial_state(setup)
    start, frame = list(state.position), state.frame
    done = dialect.execute(text.encode(), setup, state, StopConditions(first_error=True))
    return done.recorder.freeze(start, frame, {}), done.errors


def test_moves_of_the_sketch_are_those_of_klartext():
    (iso, wrong), (klartext, _none) = read(ISO), read(KLARTEXT, DIALECTS["heidenhain"])
    assert not wrong
    for name in ("line", "kind", "end", "feed", "arc"):
        assert np.array_equal(getattr(iso, name), getattr(klartext, name), equal_nan=True), name
    assert [event.kind for event in iso.events] == [event.kind for event in klartext.events]


@pytest.mark.parametrize(("old", "new", "code", "line", "column"), [
    ("G01 Y+40", "G01 Y+40 ?", "VP001", 8, 14), ("G01 X+50", "G27 X+50", "VP002", 11, 6),
    ("Y+60", "Y+61", "VP008", 10, None),
    ("N150 %FACE G71 *\n", "", None, None, None), (" F300", "", "VP009", 6, 5),
    ("N140 G00 Z+50 M30 *\nN150 %FACE G71 *\n", "", "VP010", 14, None),
])  # fmt: skip
def test_mistakes_have_their_line_and_column(old, new, code, line, column):
    text = ISO.replace(old, new, 1)
    assert text != ISO
    if code is None:
        assert not read(text)[1]
        return
    (first,) = read(text)[1]
    assert (first.code, first.line, first.column) == (code, line, column)


def test_the_sketch_is_short():
    assert len(Path(din_iso.__file__).read_text(encoding="utf-8").splitlines()) < 200
