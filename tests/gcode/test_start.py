"""Cuts before the program has said how the table stands: VP036 at the first of them, and the angles that hold there."""

import pytest

from verne_post.app.assemble import assemble
from verne_post.model.options import Options

RS274 = """G21 G90 G0 X0 Y0
G43 H1 Z30
G1 Z3 F600
X20
{end}
M2"""


def warned(source, machine, **options):
    """Line and text of every VP036."""
    options = {"tool_length": 60.0, "wcs": {"G54": (0.0, 0.0, 60.0)}} | options
    findings = assemble(source.encode(), machine, Options(**options)).moves.findings
    return [(item.line, item.message) for item in findings if item.code == "VP036"]


@pytest.mark.parametrize(
    ("end", "words"),
    [
        ("G0 Z60\nG0 A30 C45", "A and C: the table is taken to start at A30 C45, where line 6 puts it"),
        ("G0 Z60\nG0 A0 C45", "C: the table is taken to start at C45, where line 6 puts it"),
        ("G0 Z60\nG0 A-10\nG0 C0", "A: the table is taken to start at A-10, where line 7 puts it"),
        ("G1 A12 C0", "A: the table is taken to start at A12, where line 5 puts it"),
    ],
)
def test_the_first_cut_before_a_or_c_is_named(machine, end, words):
    ((line, text),) = warned(RS274.format(end=end), machine)
    assert line == 3
    assert words in text


@pytest.mark.parametrize("end", ["G0 Z60", "G0 Z60\nG0 A0 C0", "G0 Z60\nG0 A0 C0\nG0 A30 C45"])
def test_a_table_that_stands_at_0_needs_no_words(machine, end):
    assert warned(RS274.format(end=end), machine) == []


@pytest.mark.parametrize(
    "head", ["G21 G90 G0 X0 Y0 A30 C45\nG0 Z30\nG1 Z3 F600", "G21 G90 G0 X0 Y0 Z30\nG0 A30 C45\nG1 Z3 F600",
             "G21 G90 G0 X0 Y0 Z30\nG1 A30 C45 F600\nZ3"],
)  # fmt: skip
def test_a_cut_after_both_are_named_is_what_was_written(machine, head):
    assert warned(f"{head}\nX20\nM2", machine) == []


def test_a_cut_in_a_subprogram_counts(machine):
    source = "G21 G90 G0 X0 Y0 Z30\no1 sub\nG1 Z3 F600\nX20\no1 endsub\no1 call\nG0 Z60\nA30 C45\nM2"
    assert [line for line, _text in warned(source, machine)] == [3]


@pytest.mark.parametrize(
    ("dialect", "source", "line"),
    [
        ("fanuc", "O1\nG21 G90 G0 X0. Y0. Z30.\nG1 Z3. F600.\nX20.\nG0 Z60.\nG68.2 X0 Y0 Z0 I0 J20. K0\nG53.1\nM30", 3),
        ("siemens", "G71 G90 G0 X0 Y0 Z30\nG1 Z3 F600\nX20\nG0 Z60\nCYCLE800(1,\"\",0,57,0,0,0,30,0,0,0,0,0,-1)\nM30", 2),
        ("heidenhain", "BEGIN PGM T MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+30 R0 FMAX\nL Z+3 R0 F600\nL Z+60 FMAX\n"
         "PLANE SPATIAL SPA+20 SPB+0 SPC+0 TURN FMAX\nL X+0 Y+0 Z+60 R0 FMAX\nM30\nEND PGM T MM", 4),
    ],
)  # fmt: skip
def test_a_plane_that_is_tilted_later(machine, dialect, source, line):
    ((first, text),) = warned(source, machine, dialect=dialect)
    assert first == line
    assert "names A" in text
