"""Custom macros of Fanuc: values, statements, calls. Expected values follow the operator's manual of series 30i (custom
macro).
"""

import pytest

from verne_post import check
from verne_post.app.assemble import build_interpreter_setup
from verne_post.gcode.read import interpret_program
from verne_post.model.findings import InputError
from verne_post.model.moves import ZERO9
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool


def program(*lines):
    return "\n".join(["%", "O1", "G21 G90 G17 G0 X0 Y0 Z0", "F100", *lines, "M30", "%"])


@pytest.fixture
def run(view):
    """X of every move of some lines, and the findings."""

    def read(*lines, **options):
        moves, findings = view(program(*lines), dialect="fanuc", **options)
        return [float(x) for x in moves.end[1:, 0].round(9)], [item.code for item in findings]

    return read


@pytest.mark.parametrize(("expression", "value"), [
    # priority: functions, then * / AND MOD, then + - OR XOR, then comparisons
    ("1+2*3", 7), ("[1+2]*3", 9), ("2*3 GT 5", 1), ("8-3-2", 3), ("12/3/2", 2), ("5 AND 3", 1), ("5 OR 3", 7),
    ("6 XOR 3", 5),
    ("[[1 EQ 1] AND [2 EQ 2]]", 1), ("[[1 EQ 2] OR [2 EQ 2]]", 1), ("7 MOD 3", 1), ("-7 MOD 3", -1),
    # FIX cuts, FUP rounds up in size, ROUND to the nearest; angles in degrees; ATAN 0 to 360, ASIN 270 to 90
    ("FIX[-1.7]", -1), ("FUP[-1.2]", -2), ("ROUND[1.5]", 2), ("RND[-1.5]", -2), ("SIN[90]", 1), ("COS[180]", -1),
    ("TAN[45]", 1),
    ("ATAN[1]/[1]", 45), ("ATAN[-1]/[1]", 315), ("ATAN[1,-1]", 135), ("ATAN[-1]", -45), ("ASIN[-1]", 270),
    ("ACOS[-1]", 180),
    ("SQRT[9]", 3), ("SQ[16]", 4), ("ABS[-3]", 3), ("POW[2,3]", 8), ("LN[EXP[2]]", 2),
    # what follows the comma of a function is no corner (,C and ,R)
    ("POW[2,COS[0]]", 2), ("ATAN[1,COS[0]]", 45), ("POW[2,ROUND[2.2]]", 4),
    # digits in four bits each: 18 is 12 hexadecimal
    ("BIN[18]", 12), ("BCD[12]", 18),
    # variables by number, and computed numbers
    ("#2", 3), ("##2", 7), ("#[#2]", 7), ("#[1+1]*2", 6),
    # a vacant variable: 0 in sums, equal to another alone in EQ and NE, 0 in LT and the like
    ("#1+5", 5), ("5*#1", 0), ("#1 EQ #0", 1), ("#1 EQ 0", 0), ("#1 NE 0", 1), ("#1 NE #0", 0), ("#1 GE 0", 1),
    ("#1 LT 1", 1), ("-#1+2", 2),
    # the control's own: G code groups, F S T, positions, origins, tools
    ("#4001", 0), ("#4002", 17), ("#4003", 90), ("#4005", 94), ("#4006", 21), ("#4007", 40), ("#4009", 80),
    ("#4010", 98), ("#4014", 54),
    ("#4109", 100), ("#4119", 800), ("#4120", 2), ("#5001", 4), ("#5042", 6), ("#5022", 6), ("#5221", 0), ("#7003", 0),
    ("#11001", 10), ("#13002", 3),
])  # fmt: skip
def test_values(run, expression, value):
    assert run("#2=3", "#3=7", "S800 T2", "G0 X4 Y6", f"#33={expression}", "G0 X#33") == (
        [4.0, pytest.approx(value)],
        [],
    )


def test_a_variable_gets_no_value_from_a_vacant_one_and_its_word_is_passed_over(view):
    moves, findings = view(
        program("#1=5", "#1=#0", "#2=#1", "IF [#2 NE #0] GOTO 9", "G1 X#1 Y7", "N9"), dialect="fanuc"
    )
    assert findings == ()
    assert moves.end[-1][:2].tolist() == [0.0, 7.0]
    assert [(item.code, item.line) for item in moves.findings] == [("VP039", 9)]
    assert moves.findings[0].message.startswith("X has #1 (A of G65) without a value: the word is passed over")


@pytest.mark.parametrize(("lines", "ends"), [
    (("IF [1 LT 2] GOTO 20", "G0 X1", "N20 G0 X2"), [2]), (("IF [1 GT 2] GOTO 20", "G0 X1", "N20 G0 X2"), [1, 2]),
    (("IF [1 GT 2] GOTO #1", "G0 X1"), [1]), (("IF [1 GT 2] THEN #1=1/0", "G0 X1"), [1]),
    (("#1=0", "N5 #1=#1+1", "G0 X#1", "IF [#1 LT 3] GOTO 5"), [1, 2, 3]),
    (("GOTO [10*2]", "N10 G0 X1", "N20 G0 X2"), [2]),
    # the search goes forwards first, then from the beginning
    (("#1=0", "N7 G0 X[1+#1]", "IF [#1 EQ 1] GOTO 9", "#1=1", "GOTO 7", "N9 G0 X9"), [1, 2, 9]),
    (("#1=1", "IF [#1 EQ 1] THEN #2=8", "IF [#1 EQ 2] THEN #2=1/0", "G0 X#2"), [8]),
    (("IF[1EQ1]THEN GOTO20", "G0 X1", "N20 G0 X2"), [2]),
    (("#1=0", "WHILE [#1 LT 3] DO1", "G0 X[10*#1+1]", "#1=#1+1", "END1"), [1, 11, 21]),
    (("WHILE [1 EQ 2] DO2", "G0 X1", "END2", "G0 X2"), [2]),
    (("#1=0", "WHILE [#1 LT 2] DO1", "#2=0", "WHILE [#2 LT 2] DO2", "G0 X[10*#1+#2+1]", "#2=#2+1", "END2 (inner)",
      "#1=#1+1", "END 1"), [1, 2, 11, 12]),
    (("#1=0", "N1 (AGAIN) DO1", "#1=#1+1", "G0 X#1", "IF [#1 GE 2] GOTO 30", "END1", "N30 G0 X9"), [1, 2, 9]),
    (("/IF [1 EQ 1] GOTO 20", "G0 X1", "N20 G0 X2"), [2]), (("(GOTO 20)", "G0 X1"), [1]),
    # the same number of a loop may be used again
    (("WHILE [1 EQ 2] DO1", "END1", "#1=0", "WHILE [#1 LT 1] DO1", "#1=1", "G0 X5", "END1"), [5]),
])  # fmt: skip
def test_statements(run, lines, ends):
    assert run(*lines) == ([float(x) for x in ends], [])


@pytest.mark.parametrize(("call", "body", "ends"), [
    ("G65 P9000 A1 B2 C3 D4", "G0 X#1 / X#2 / X#3 / X#7", [1, 2, 3, 4]),
    ("G65 P9000 X24. Y25 Z26. Q17", "G0 X#24 / X#25 / X#26 / X#17", [24, 25, 26, 17]),
    # letters of argument specification I; M and T are arguments too
    ("G65 P9000 E8 F9 H11 M13 R18 S19 T20 U21 V22 W23",
     "G0 X#8 / X#9 / X#11 / X#13 / X#18 / X#19 / X#20 / X#21 / X#22 / X#23", [8, 9, 11, 13, 18, 19, 20, 21, 22, 23]),
    # specification II: sets of I J K, a new one where the order begins again; the last of two for one variable counts
    ("G65 P9000 I1 J2 K3 I4 J5 K6 I7", "G0 X#4 / X#5 / X#6 / X#7 / X#8 / X#9 / X#10", [1, 2, 3, 4, 5, 6, 7]),
    ("G65 P9000 J2 I4", "G0 X#5 / X#7", [2, 4]),
    ("G65 P9000 A1 B2 I-3 I4 D5", "G0 X#1 / X#2 / X#4 / X#7", [1, 2, -3, 5]),
    # variables of its own, those of the caller come back; L repeats with the same arguments
    ("#1=7 / G65 P9000 A1 / G0 X#1", "G0 X#1 / #1=99", [1, 7]),
    ("G65 P9000 L3 A1", "G0 X#1 / #1=#1+1 / G0 X#1", [1, 2, 1, 2, 1, 2]),
    ("G65 P9000 A#0 B2", "IF [#1 EQ #0] GOTO 3 / G0 X1 / N3 G0 X#2", [2]),
    # M98 shares them
    ("#1=7 / M98 P9000 / G0 X#1", "G0 X#1 / #1=8", [7, 8]),
    # G66: after every block that moves, with variables that are kept from call to call
    ("G66 P9000 A1 / G0 X10 / G4 P1 / X20 / G67 / X30", "#1=#1+1 / G0 X#1", [10, 2, 2, 20, 3, 30]),
    ("G66 P9000 A1 / G52 X0 / G92 Y0 / G0 X10 / G67", "#1=#1+1 / G0 X#1", [10, 2]),
    ("G90 G65 P9000 A[1+2] (WORDS) B4", "G0 X#1 / X#2", [3, 4]),
])  # fmt: skip
def test_calls(run, call, body, ends):
    assert run(*call.split(" / "), "M30", "O9000", *body.split(" / "), "M99") == ([float(x) for x in ends], [])


@pytest.mark.parametrize(("lines", "ends"), [
    (("M97 P100 L2", "G0 X9", "M30", "N100 G91 G0 X1", "G90 M99"), [1, 2, 9]),
    (("M98 P2000", "G0 X1", "N50 G0 X2", "M30", "O2000", "G0 X5", "M99 P50"), [5, 2]),
    (("G0 X1", "M99 P30", "G0 X2", "N30 G0 X3"), [1, 3]),
    (("G65 P2000 A5", "N40 G0 X1", "N50 G0 X#1", "G0 X2", "M30", "O2000", "N50 G0 X#1", "M99 P50"), [5, 5, 2]),
])  # fmt: skip
def test_returns_and_local_subprograms(run, lines, ends):
    assert run(*lines) == ([float(x) for x in ends], [])


@pytest.mark.parametrize("key", [5041, 5042, 5021, 5023])
def test_where_the_tool_is_beside_the_contour_is_not_known(view, key):
    """#5041 and #5021 include the compensation, and #5001 does not; after G40 until a motion they still do."""
    lines = ["G41 D1 G1 X5 Y0 F100", "X20", f"#1=#{key}", "G40", f"#2=#{key}", "G1 Y9", f"G0 X#{key}"]
    tools = {1: Tool(1, 1, ZERO9, 10.0)}
    for kept, line in ((lines, 7), (lines[:2] + lines[3:], 8)):
        findings = view(program(*kept), dialect="fanuc", tools=tools)[1]
        assert [(item.code, item.line) for item in findings] == [("VP025", line)]
        assert f"read #{5000 + key % 10}" in findings[0].message
    lines = [line.replace(str(key), str(5000 + key % 10)) for line in lines]
    moves, findings = view(program(*lines), dialect="fanuc", tools=tools)
    assert findings == ()
    assert moves.end[-1][0] == {1: 20.0, 2: 9.0, 3: 0.0}[key % 10]


def test_f_beside_a_code_of_units_has_that_unit(view):
    """G20 and G21 hold for all words of their block."""
    text = "G20 G1 X1. F10.", "X2.", "G21 X60. F100.", "X70.", "G20 F5.", "X3."
    moves, findings = view(program(*text), dialect="fanuc")
    assert findings == ()
    assert moves.feed[-5:] == pytest.approx([254.0, 254.0, 100.0, 100.0, 127.0])
    assert moves.end[-5:, 0] == pytest.approx([25.4, 50.8, 60.0, 70.0, 76.2])
    moves, _findings = view("G21 G90 F1\nG0 X0\nG20 G1 X1. F10.\nG21 X60. F100.\nM2", dialect="rs274")
    assert moves.feed[-2:] == pytest.approx([10.0, 2540.0])  # LinuxCNC reads F before the unit


@pytest.mark.parametrize(("lines", "code", "part", "line"), [
    (("GOTO 20",), "VP023", "N20", 5), (("WHILE [1 EQ 1] DO1", "M30"), "VP023", "END1", 5),
    (("END1",), "VP023", "DO1", 5),
    (("GOTO 30", "DO1", "N30", "END1"), "VP023", "into the loop", 5), (("IF [1 EQ 1]",), "VP001", "GOTO or THEN", 5),
    (("IF [1/0 EQ 1] GOTO 3", "N3"), "VP007", "zero", 5), (("GOTO 1.5",), "VP007", "whole", 5),
    (("GOTO 20 X1", "N20"), "VP001", "follow", 5),
    # also where the condition is false
    (("IF [1 GT 2] GOTTO 20", "N20"), "VP001", "GOTO", 5), (("IF [1 GT 2] THEN G1", "N20"), "VP002", "THEN", 5),
    (("IF [1 EQ 1] THEN G0 X1",), "VP002", "THEN", 5), (("#1=[1 AND 2+3]",), "VP002", "brackets", 5),
    (("#1=-1 AND 3",), "VP007", "bit operations", 5),
    (("#1=BIN[26]",), "VP007", "digits", 5), (("#1=POW[2]",), "VP001", "two", 5), (("#1=SIN[1,2]",), "VP001", "one", 5),
    (("#1=#[#2]",), "VP025", "index", 5),
    (("G0 X#100",), "VP025", "--parameters", 5), (("#3001=0", "G0 X#3001"), "VP025", "machine", 6),
    (("#5001=3",), "VP025", "control", 5),
    (("G65 A1",), "VP005", "P", 5), (("G65 P9000 A1 A2",), "VP004", "A", 5), (("G65 P9000",), "VP023", "O9000", 5),
    (("G65 P9000 G1",), "VP006", "G", 5),
    (("G65 P9000 " + "I1" * 11,), "VP004", "sets", 5), (("G66 P1 A1", "G66 P1"), "VP002", "G67", 6),
    (("M97",), "VP005", "M97", 5), (("M97 P5",), "VP023", "N5", 5),
    (("IF [1 EQ 1] THEN #3000=12(DRILL TOO SHORT)",), "VP027", "DRILL TOO SHORT", 5), (("G12.1",), "VP002", "G12.1", 5),
    (("N1 GOTO 1",), "VP024", "repeated", 5), (("M99",), "VP024", "M99", 5),
])  # fmt: skip
def test_what_is_wrong_has_its_line(view, lines, code, part, line):
    findings = view(program(*lines), dialect="fanuc", max_repeats=500)[1]
    assert [(item.code, item.line) for item in findings] == [(code, line)]
    assert part in findings[0].message


_MISSING = "{0} calls O9010: not in the program, and in no file beside it whose name has the number"


def test_a_program_behind_the_closing_percent_is_told(view):
    """The text ends at that %; without the % the program is found."""
    source = "%\nO1\nG21 G90\nG0 X0 Y0 Z50.\nG65 P9100\nM30\n%\nO9100\nX5.\nM99\n%\n"
    (finding,) = view(source, dialect="fanuc")[1]
    assert finding.message.endswith("; line 8 has O9100, but the % of line 7 ends the text before it; take this % out")
    assert view(source.replace("M30\n%", "M30"), dialect="fanuc")[1] == ()


def test_a_subprogram_without_its_end_is_named(view):
    (finding,) = view("%\nO1\nG21 G90\nG0 X0 Y0 Z9.\nM98 P10\nM30\nO10\nX1.\n%\n", dialect="fanuc")[1]
    assert finding.message == "O10, which has been called, runs on to the end of the text; expected M99"


@pytest.mark.parametrize(
    ("lines", "found"),
    [
        # what is wrong with a line by itself is told; values, modes and positions may be those of the macro
        (
            ("G65 P9010 A1", "G0 X#100", "G91 G1 X1", "G12.1", "G17 G18", "M98 P9010", "G0 P3"),
            [("VP023", 5), ("VP002", 8), ("VP003", 9), ("VP023", 10), ("VP006", 11)],
        ),
        (("G65 P9010", "IF [#100 EQ #0] THEN #3000=1(NO PROBE)", "G12.1"), [("VP023", 5), ("VP002", 7)]),
        # a macro that G66 calls is missing once
        (("G66 P9010", "G0 X1", "X2", "G67", "G12.1"), [("VP023", 6), ("VP002", 9)]),
        # a loop whose end the macro would have set ends the search
        (("G65 P9010", "WHILE [#100 LT 5] DO1", "G0 X3", "END1", "G12.1"), [("VP023", 5)]),
        (("G65 P9010", "N1 G0 X1", *("X2",) * 60, "GOTO 1", "G12.1"), [("VP023", 5)]),
        (("M98 P39010", "G12.1"), [("VP023", 5), ("VP002", 6)]),
        (("M97 P5", "G12.1"), [("VP023", 5), ("VP002", 6)]),
    ],
)
def test_a_program_without_its_macro_is_read_on(machine, lines, found):
    with pytest.raises(InputError) as refusal:
        setup = build_interpreter_setup(machine, Options(dialect="fanuc", max_repeats=500))
        interpret_program(program(*lines).encode(), setup)
    findings = refusal.value.findings
    assert [(item.code, item.line) for item in findings] == found
    word = lines[0].split(" A")[0]
    assert findings[0].message.startswith(_MISSING.format(word.split(" ")[0])) or word[0] == "M"


def test_macros_that_are_missing_are_one_finding(machine):
    """A probing cycle is four calls; a program below O9000 is no macro of the builder."""
    lines = "G65 P9832", "G65 P9810 Z10. F1000.", "G65 P9811 Z0.", "G65 P9833", "M98 P200"
    with pytest.raises(InputError) as refusal:
        interpret_program(program(*lines).encode(), build_interpreter_setup(machine, Options(dialect="fanuc")))
    first, other = refusal.value.findings
    assert (first.code, first.line, first.last_line, first.count) == ("VP023", 5, 8, 4)
    assert first.message.startswith("G65 calls O9832, O9810, O9811 and O9833: not in the program")
    assert first.message.endswith("take calls of a probe out")
    assert other.message.startswith("M98 calls O200: not in the program")
    assert "probe" not in other.message


def test_a_computed_jump_is_no_cl_file(view):
    """It is told what is wrong with it, not that the text looks like APT, whose word is GOTO too."""
    lines = "#1=#4/#2", "GOTO [8+3]", "O2000", "IF [#1 EQ 1] THEN #1=5"
    assert [(item.code, item.line) for item in view(program(*lines), dialect="fanuc")[1]] == [("VP007", 5)]


def test_an_error_of_a_modal_call_has_no_column_of_another_line(view):
    """G66 stands in another line than the block after which the macro is called."""
    findings = view(program("G65 P2000", "M30", "O2000", "G66 P2000 Z-1.", "X1.", "M99"), dialect="fanuc")[1]
    assert [(item.code, item.line, item.column) for item in findings] == [("VP024", 9, None)]


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (("G65 P10", "M30", "O10", "X1.", "O20", "X2.", "M99"), "O10 runs on into O20; write M99 before it"),
        (("M98 P10", "O10", "X1.", "M99"), "the program runs on into O10; write M30 or M2 before it"),
        (("M98 P10 L2", "M30", "O10", "X1.", "M99"), None),
    ],
)
def test_a_program_that_runs_on_into_the_next_is_refused(view, lines, told):
    """Each O number begins another program, for a control that reads the text."""
    findings = view(program(*lines), dialect="fanuc")[1]
    place = 5 + max(number for number, line in enumerate(lines) if line[0] == "O")
    assert [(item.code, item.line, item.message) for item in findings] == ([("VP024", place, told)] if told else [])


def test_a_statement_is_found_where_it_stands(machine):
    source = program("IF [#1 GT] GOTO 3", "N3 G0 X1 Y1 Z1")
    found = check(source.encode(), machine, Options(dialect="fanuc", tool_length=50.0)).findings
    assert [(item.code, item.line, item.column) for item in found if item.code < "VP033"] == [("VP001", 5, 10)]


def test_parameters_give_common_variables(view, run):
    assert run("G0 X#500", parameters={500: 4.0}) == ([4.0], [])


def test_a_loop_costs_what_its_moves_cost(run):
    ends, codes = run("#1=0", "WHILE [#1 LT 2000] DO1", "#1=#1+1", "G1 X#1", "END1")
    assert codes == []
    assert ends == [float(x) for x in range(1, 2001)]
