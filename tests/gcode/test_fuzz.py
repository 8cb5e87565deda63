"""Whatever the bytes are: findings or moves, never another exception, never a number that is not finite."""

import re

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from verne_post import check
from verne_post.app.assemble import view_moves_plainly
from verne_post.gcode import interpret_plainly
from verne_post.model.findings import InputError
from verne_post.model.moves import ZERO9, MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool, WorkOffset

SETTINGS = settings(max_examples=150, deadline=None, database=None, derandomize=True)
TOOLS = {1: Tool(1, 1, (0.0, 0.0, 60.0, *ZERO9[3:]), 6.0)}
OPTIONS = st.sampled_from([
    Options(), Options(tool_length=60.0), Options(tools=TOOLS),
    Options(tools=TOOLS, block_delete=True, optional_stop=True, max_repeats=500), Options(tools=TOOLS, dialect="fanuc"),
    Options(tools=TOOLS, dialect="aptcl"),
    Options(tool_length=60.0, wcs={1: WorkOffset((10.0, -20.0, 30.0), 25.0)}),
])  # fmt: skip

numbers = st.one_of(
    st.integers(-300, 300).map(str),
    st.decimals(-300, 300, places=3).map(str),
    st.sampled_from(
        ["", ".", "-", "1.2.3", "+-1", "1e9", "#1", "[1+2]", "00001", "0.00000000000000000001", "1 0", ".5"]
    ),
)
tokens = st.one_of(
    st.builds("{}{}".format, st.sampled_from("XYZABCUVWIJKRPQFSTHDLENGMO"), numbers),
    st.sampled_from([
        "G0", "G1", "G2", "G3", "G4", "G10", "G17", "G18", "G19", "G20", "G21", "G28", "G30", "G43", "G43.1", "G49",
        "G52", "G53", "G54", "G55", "G59.3", "G61", "G64", "G80", "G90", "G91", "G90.1", "G92", "G92.1", "G92.3",
        "G93", "G94", "G95", "L2", "L20", "L1", "P1", "P0", "H1", "T1", "F100", "S500", "M0", "M2", "M3", "M5",
        "M6", "M8", "M30", "M60", "(c)", "(MSG,x)", "; c", "/", "%", "(", ")", "#", "[", "o1", "\t", "\r", "\x00",
        "\u00e9", "\ufeff", "A0 C0", "X0 Y0 Z50", "A30", "R20", "I5", "#1=5", "#1=[#1+1]", "X#1", "#<a>=2", "X[#1*2]",
        "Y#<a>",
        "\no1 while [#1 LT 9]\n", "\no1 endwhile\n", "\no2 if [#1]\n", "\no2 else\n", "\no2 endif\n",
        "\no3 repeat [3]\n",
        "\no3 endrepeat\n", "\no4 sub\n", "\no4 endsub\n", "\no4 call [1] [2]\n", "\nO5\n", "M98 P5", "M99", "M70",
        "M72", "M73",
        "G81 R5", "G83 R9 Q1", "G98", "G41.1 D2", "G42", "G40", "(DEBUG,#1)", "G43.5", "I0 J0 K1", "@5", "^30",
        "M66 P0 L1 Q1",
    ]),
)  # fmt: skip
soups = st.lists(tokens | st.just("\n") | st.just("\n"), max_size=40).map(" ".join)
heads = st.sampled_from(
    ["", "G49 G0 X0 Y0 Z200 A0 C0\n", "%\n", "G43 H1 G0 X0 Y0 Z200 A30 C10\nF500\n", "G28 G91 Z0\nG90\n"]
)
programs = st.builds("{}{}{}".format, heads, soups, st.sampled_from(["\nM2", "\n%", "", "\nM30\n"])).map(str.encode)


def well_formed(findings):
    assert all(item.code.startswith("VP") and item.message for item in findings)
    return True


def all_at_once(source, options):
    """Kinds of the moves, or None, and every finding."""
    names = ("tools", "tool_length", "block_delete", "max_repeats", "dialect")
    given_options = {name: getattr(options, name) for name in names}
    try:
        return interpret_plainly(source, **given_options).kind, ()
    except InputError as error:
        return None, error.findings


def try_everything(source, machine, options):
    """Both doors of the front end, and the whole check."""
    moves, findings = view_moves_plainly(source, options)
    assert well_formed(findings)
    assert len(findings) <= 1
    assert np.isfinite(moves.end).all()
    assert np.isfinite(moves.feed[moves.kind != MoveKind.RAPID]).all()
    kinds, all_findings = all_at_once(source, options)
    assert well_formed(all_findings)
    first = [(item.code, item.line, item.column, item.message) for item in all_findings[:1]]
    assert first == [(item.code, item.line, item.column, item.message) for item in findings]
    assert kinds is None or np.array_equal(kinds, moves.kind)
    result = check(source, machine, options)
    assert well_formed(result.findings)
    assert result.ok == (result.exit_code == 0)
    if findings and findings[0].line:  # what no interpreter can read, no machine can
        assert not result.ok


@SETTINGS
@given(st.binary(max_size=200), OPTIONS)
def test_bytes(machine, source, options):
    try_everything(source, machine, options)


@SETTINGS
@given(st.text("GXYZACFMN0123456789.-+ \n\t\r()/%;#", max_size=60).map(str.encode), OPTIONS)
def test_characters(machine, source, options):
    source = b"\n".join(line for line in source.split(b"\n") if not has_long_number(line))
    try_everything(source, machine, options)


def has_long_number(line):
    """Numbers of six digits and more are the business of other tests."""
    return re.search(rb"[0-9]{6}", re.sub(rb"[ \t\r]", b"", line)) is not None


@SETTINGS
@example(b"G10\nM2", Options())  # its column was found by one of the two doors alone
@given(programs, OPTIONS)
def test_token_soups(machine, source, options):
    try_everything(source, machine, options)


NINES = "9" * 400  # infinite as a double


@pytest.mark.parametrize(
    "program",
    [
        f"G{NINES}",
        f"M{NINES}",
        f"T{NINES}",
        f"G43 H{NINES}",
        f"G10 L{NINES} P1",
        f"G10 L2 P{NINES}",
        f"G0 X{NINES}",
        f"G4 P{NINES}",
        f"F{NINES}\nG1 X1",
        f"G92 X{NINES}",
        f"F100 G2 I{NINES}",
        f"F100 G2 X1 R{NINES}",
        f"G20 G0 X{'9' * 308}",
        f"S{NINES} M3",
        f"F100 G2 I1 P{NINES}",
        "F100 G2 I1 P1000000000000",
        f"G10 L2 P1 R{NINES}",
        f"G64 P{NINES}",
        f"G43.1 Z{NINES}",
        f"G1 A{NINES} F1",
    ],
)
def test_numbers_beyond_all_bounds_are_findings(machine, program):
    for head in ("", "G49 G0 X0 Y0 Z200 A0 C0\n"):
        source = f"{head}{program}\nM2".encode()
        _moves, findings = view_moves_plainly(source, Options(tools=TOOLS))
        assert [item.severity for item in findings] == ["error"]
        assert not check(source, machine, Options()).ok


@pytest.mark.parametrize(
    "word",
    [
        "X1000000000000000000",
        "Z-9000000000000000000",
        "C1000000000000000000",
        f"Y{'9' * 300}",
        "F9 G2 I1000000000000000",
        "F9 G2 X1 R-1000000000000000",
    ],
)
def test_coordinates_out_of_this_world_are_findings(machine, word):
    result = check(f"G49 G0 X0 Y0 Z200 A0 C0\n{word}\nM2".encode(), machine)
    assert not result.ok
    assert {item.line for item in result.findings} == {2}
