"""`explain` of words as programs write them, and of whole lines; a command that stands without its group."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from verne_post.gcode.known_words import describe_word, list_words
from verne_post.gcode.line_words import UnreadWord
from verne_post.gcode.pasted_line import describe_pasted
from verne_post.gcode.siemens import vocabulary as siemens

_NUMBERED = re.compile(r"([GM]|FN |CYCL DEF )(\d+(?:\.\d+)?)")


def test_a_zero_before_the_number_changes_no_answer() -> None:
    codes = {(match[1], match[2]) for _language, name, *_ in list_words() if (match := _NUMBERED.fullmatch(name))}
    assert {("M", "3"), ("G", "5.1"), ("CYCL DEF ", "7"), ("FN ", "9")} <= codes
    for head, number in sorted(codes):
        for zeros in ("0", "00"):
            assert describe_word(f"{head}{zeros}{number}".lower()) == describe_word(f"{head}{number}") != []


@pytest.mark.parametrize(
    ("written", "word"),
    [
        ("N0010", "N10"),
        ("T01", "T1"),
        ("h01", "H1"),
        ("d01", "D1"),
        ("CYCL DEF 200 DRILLING", "CYCL DEF 200"),
        ("CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 7"),
    ],
)
def test_a_word_as_programs_write_it_is_the_word(written: str, word: str) -> None:
    assert describe_word(written) == describe_word(word) != []


def read(line: str) -> dict[str, dict[str, str]]:
    """Word of a line -> language -> what it does there."""
    found: dict[str, dict[str, str]] = {}
    for text in describe_pasted(line):
        if not text.startswith(" "):
            own = found.setdefault(text, {})
            continue
        languages, _, said = text.strip().partition(": ")
        own |= dict.fromkeys(languages.split(", "), said)
    return found


MACRO = ("RS274/NGC", "Fanuc")
OF_G = (*MACRO, "Siemens")


@pytest.mark.parametrize(
    ("line", "languages", "words"),
    [
        ("G1 X10 F500", OF_G, ["G1", "X10", "F500"]),
        ("N10G01X-10.5F500 ; to the edge", OF_G, ["N10", "G01", "X-10.5", "F500", "; to the edge"]),
        ("M128 F1000", (*OF_G, "Klartext"), ["M128", "F1000"]),
        ("X10 Y20", OF_G, ["X10", "Y20"]),
        ("GOTO 100", ("Fanuc",), ["GOTO"]),
        ("G1 X[#1+2] F100", MACRO, ["G1", "X[#1+2]", "#1", "F100"]),
        ("G1 X#1", MACRO, ["G1", "X#1", "#1"]),
        ("G53 G0 Z0.", OF_G, ["G53", "G0", "Z0."]),
        ("G5.2 X1 P1 L3", ("RS274/NGC",), ["G5.2", "X1", "P1", "L3"]),
        ("o100 sub", ("RS274/NGC",), ["o100", "sub"]),
        ("o<probe> call [1] [#2]", ("RS274/NGC",), ["o<probe>", "call", "[1]", "[#2]", "#2"]),
        ("#<depth>=5", MACRO, ["#<depth>"]),
        ("#101=#102+5", ("Fanuc",), ["#101", "#102"]),
        ("IF [#1 LT 10] GOTO 20", ("Fanuc",), ["IF", "#1", "LT", "GOTO"]),
        ("WHILE [#1 LE 10] DO1", ("Fanuc",), ["WHILE", "#1", "LE", "DO"]),
        ("G68.2 X0 I45. J30.", MACRO, ["G68.2", "X0", "I45.", "J30."]),
        ("G65 P9010 A1. B2.5", ("Fanuc",), ["G65", "P9010", "A1.", "B2.5"]),
        ("G1 X10 ,R2", ("Fanuc",), ["G1", "X10", ",R2"]),
        ("IF R1<=30 GOTOB NEXT", ("Siemens",), ["IF", "R1", "GOTOB", "NEXT"]),
        ("R1=R1+1", ("Siemens",), ["R1"]),
        ("G1 X=R1*2 F=R3", ("Siemens",), ["G1", "X=R1*2", "R1", "F=R3", "R3"]),
        ("CYCLE81(10,0,2,-5)", ("Siemens",), ["CYCLE81", "10", "0", "2", "-5"]),
        ("G0 SUPA Z=0 D0", ("Siemens",), ["G0", "SUPA", "Z=0", "D0"]),
        ("G1 X=IC(5) A3=0 B3=0 C3=1", ("Siemens",), ["G1", "X=IC(5)", "IC", "A3=0", "B3=0", "C3=1"]),
        ('T="BALL 6" D1', ("Siemens",), ['T="BALL 6"', "D1"]),
        ("REPEAT A_L B_L P=3", ("Siemens",), ["REPEAT", "A_L", "B_L", "P=3"]),
        ("L M128 F1000", ("Klartext",), ["L", "M128", "F1000"]),
        ("M140 MB50", ("Klartext",), ["M140", "MB50"]),
        ("L X+10 R0 FMAX M3", ("Klartext",), ["L", "X+10", "R0", "FMAX", "M3"]),
        ("L X+Q1 FMAX", ("Klartext",), ["L", "X+Q1", "Q1", "FMAX"]),
        ("L IX+5", ("Klartext",), ["L", "IX+5"]),
        ('TOOL CALL "BALL 6" Z S3000', ("Klartext",), ["TOOL CALL", '"BALL 6"', "Z", "S3000"]),
        (
            "PLANE SPATIAL SPA+20 SPB+0 SPC+0 TURN FMAX SEQ-",
            ("Klartext",),
            ["PLANE SPATIAL", "SPA+20", "SPB+0", "SPC+0", "TURN", "FMAX", "SEQ-"],
        ),
        ("FN 12: IF +Q1 LT +10 GOTO LBL 5", ("Klartext",), ["FN 12", "IF", "+Q1", "LT", "GOTO", "LBL"]),
        ("9 CYCL DEF 7.1 X+10", ("Klartext",), ["9", "CYCL DEF 7.1", "X+10"]),
        ("CALL LBL 5 REP 3", ("Klartext",), ["CALL LBL", "5", "REP 3"]),
        ("Q1 = Q2 * SIN(Q3) + 1,5", ("Klartext",), ["Q1", "Q2", "SIN", "Q3"]),
        ("GOTO/0,0,50", ("APT",), ["GOTO", "0,0,50"]),
        ("FEDRAT/600,MMPM", ("APT",), ["FEDRAT", "600", "MMPM"]),
        ("SPINDL/RPM,2000,CLW", ("APT",), ["SPINDL", "RPM", "2000", "CLW"]),
        ("COOLNT/ON", ("APT",), ["COOLNT", "ON"]),
        (
            "CYCLE/DRILL,RAPTO,3,FEDTO,-20,MMPM,250",
            ("APT",),
            ["CYCLE", "DRILL", "RAPTO", "3", "FEDTO", "-20", "MMPM", "250"],
        ),
    ],
)
def test_a_line_is_told_word_by_word(line: str, languages: tuple[str, ...], words: list[str]) -> None:
    """In all languages that read the whole line, and in no other."""
    found = read(line)
    assert [word for word in found if word not in ("100",)] == words
    told = {language for texts in found.values() for language in texts}
    assert told - {"Siemens"} == {*languages} - {"Siemens"}
    assert line == "GOTO 100" or ("Siemens" in told) == ("Siemens" in languages)
    assert all(texts for texts in found.values())


def test_a_word_that_controls_understand_differently_has_each_meaning() -> None:
    tcp = read("M128 F1000")
    assert tcp["M128"]["RS274/NGC"].startswith("not executed: external programs")
    assert tcp["M128"]["Fanuc"] == tcp["M128"]["Siemens"]
    assert "not known, and refused (VP002)" in tcp["M128"]["Fanuc"]
    assert tcp["M128"]["Klartext"].startswith("tool-centre-point control on")
    assert "has no effect" in tcp["F1000"]["Klartext"]
    assert "mm/min" in tcp["F1000"]["Fanuc"]


@pytest.mark.parametrize(
    ("line", "word", "said"),
    [
        ("X1 Y2", "X1", "axis X goes to 1 mm"),
        ("L IX+5", "IX+5", "axis X goes on by 5 mm"),
        ("G1 X=IC(5)", "X=IC(5)", "axis X goes on by 5 mm"),
        ("G0 A-.5 C1", "A-.5", "axis A goes to -0.5 degrees"),
        ("G53 G0 Z0.", "Z0.", "axis Z goes to 0 mm (inch under G20), in machine coordinates"),
        ("L Z-1 FMAX M91", "Z-1", "in machine coordinates"),
        ("G1 X#1", "X#1", "computed: the value is known only in the program (explain FILE:LINE)"),
        ("TRANS DATUM AXIS X+10", "X+10", "shifts the datum to 10"),
        ("BLK FORM 0.1 Z X-50 Y-50 Z-30", "X-50", "corner, of the stock"),
        ("G65 P9010 A1. B2.5", "B2.5", "argument #2 of the macro"),
        ("RND R2 F100", "F100", "of this rounding alone"),
        ("CYCLE81(10,0,2,-5)", "-5", "DP of CYCLE81: final depth"),
        ("M98 P1000 L3", "L3", "how often"),
        ("G96 S200", "S200", "speed of the surface"),
        ("M140 MB5 F300", "F300", "of the retract of M140 alone"),
        ("PLANE RESET TURN F500", "F500", "of the turn of the rotary axes"),
        ("CYCL DEF 8.1 X", "X", "mirror image of this axis"),
        ("REPEAT A_L P=3", "P=3", "how often the lines run"),
    ],
)
def test_a_value_is_told_as_what_it_is_in_its_line(line: str, word: str, said: str) -> None:
    assert any(said in text for text in read(line)[word].values()), read(line)[word]


@pytest.mark.parametrize(
    ("line", "column", "said"),
    [
        ("CYCL DEFF 208", 6, "DEFF is not read here; Klartext: DEF or CALL after CYCL"),
        ("G1 FOO", 4, "FOO is not read here; RS274/NGC, Fanuc: a letter with a value"),
        ("G1 X[#1+FOO]", 9, "FOO is not read here; RS274/NGC, Fanuc: a variable, a number or a function"),
        ("FUNCTION FOO", 10, "FOO is not read here; Klartext: a word of FUNCTION"),
        ("FEDRAT/600,MMPS", 12, "MMPS is not read here; APT: MMPM, IPM"),
        ("IF [#1 LT 10] 20", 15, "20 is not read here; Fanuc: GOTO or THEN"),
        ("L X+5 Y", 7, "Y is not read here; Klartext: a word of L"),
    ],
)
def test_a_line_that_nothing_reads_names_the_word_that_stopped_it(
    run: Callable[..., Any], line: str, column: int, said: str
) -> None:
    with pytest.raises(UnreadWord, match=re.escape(f"column {column}: {said}")):
        describe_pasted(line)
    answer = run("explain", line)
    assert answer.code == 2
    assert f"column {column}: {said}" in " ".join(answer.err.split())


@pytest.mark.parametrize(
    ("written", "name"),
    [
        *(("SPA+20", "SPA"), ("spb-10", "SPB"), ("LEN5", "LEN"), ("PR+5", "PR"), ("IPA+30", "IPA"), ("TX+0.1", "TX")),
        *(("IPR+2", "IPR"), ("CCA90", "CCA"), ("DR-0.1", "DR"), ("MB50", "MB"), ("REP3", "REP"), ("SCL0.5", "SCL")),
        *(("TA0.5", "TA"), ("NUMX3", "NUMX"), ("RI10", "RI"), ("DX+5", "DX"), ("TIME 3", "TIME"), ("LA5", "LA")),
        *(("CR=-5", "CR"), ("TURN=2", "TURN"), ("SPOS=90", "SPOS"), ("ADIS=0.1", "ADIS"), ("CHF=1", "CHF")),
        *(("RAPTO,3", "RAPTO"), ("RPM,2000", "RPM"), ("SQRT[4]", "SQRT"), ("P1X+0", "P1X"), ("R[1]=5", "R1")),
    ],
)
def test_a_word_with_its_value_is_told_as_its_name(run: Callable[..., Any], written: str, name: str) -> None:
    """It was unknown, and another word was proposed: SUPA for SPA+20."""
    answer = run("explain", written)
    assert answer.code == 0
    head, *rows = answer.out.splitlines()
    assert head == written.upper() and head not in [row.strip() for row in rows]
    said = [row.strip() for row in rows]
    shown = [text for text in describe_word(name) if any(row.endswith(text.split(": ", 1)[-1]) for row in said)]
    assert shown, (said, describe_word(name))


@pytest.mark.parametrize(
    ("word", "rows"),
    [
        ("IX-3.5", ["  Klartext: axis X goes on by -3.5 mm (inch, where BEGIN PGM says so)"]),
        ("IC+90", ["  Klartext: axis C goes on by 90 degrees"]),
        ("Z-5,2", ["  Klartext: axis Z goes to -5,2 mm (inch, where BEGIN PGM says so)"]),
        ("FAUTO", ["  Klartext: the feed rate of TOOL CALL"]),
        ("MB MAX", ["  Klartext: retracts to the end of the travel"]),
        ("Q200=AUTO", ["  Klartext: clearance, in the unit of the program"]),
        (
            "DIST+50",
            [
                "  Klartext: how far before the tip the point is that stays on the part, mm",
                "  Klartext, in BLK: height of the datum over its upper face",
            ],
        ),
        (
            "X=IC(5)",
            [
                "  Siemens: axis X goes on by 5 mm (inch under G70)",
                "  IC",
                "    Siemens: this value is incremental: X=IC(5)",
            ],
        ),
    ],
)
def test_one_word_is_told_below_its_heading(run: Callable[..., Any], word: str, rows: list[str]) -> None:
    assert run("explain", word).out.splitlines() == [word, *rows]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("G64 P", "RS274/NGC, Fanuc: how far corners may be rounded"),
        ("G68.2 I", "RS274/NGC, Fanuc: angle of the tilted plane: I degrees; under P3 a direction"),
        ("M98 P", "RS274/NGC, Fanuc: number of the subprogram"),
        ("G4 F", "Siemens: dwell: F s"),
        ("BLK", "Klartext, BLK FORM: the stock, a box or a cylinder"),
        ("TCOFR", "Siemens: not executed: frames of tool carriers"),
        ("C+Q122", "Klartext: the angle of C that PLANE or cycle 19 has computed"),
        ("SPA+20 SPB+0 TURN FMAX", "Klartext: angle of the plane about Y, degrees"),
    ],
)
def test_parts_of_lines_are_told(run: Callable[..., Any], words: str, said: str) -> None:
    answer = run("explain", words)
    assert answer.code == 0 and said in answer.out


@pytest.mark.parametrize("words", ["SPAA+20", "DISTT50", "RL5", "5", "G1 M", "FOO P", "L X", "X+10 5", "G1 X10 Y"])
def test_what_no_language_has_stays_unknown(run: Callable[..., Any], words: str) -> None:
    answer = run("explain", words)
    assert answer.code == 2 and not answer.out


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("=" * 4000, "is neither INPUT:LINE"),
        ("7" * 4000, "is neither INPUT:LINE"),
        ("G1 X" + "=" * 3996, "no language reads the whole line"),
        ("7" * 4001, "the line has 4001 characters; at most 4000 are read"),
    ],
    ids=["equal signs", "digits", "after a word", "too long"],
)
def test_a_long_line_is_refused_in_words(run: Callable[..., Any], line: str, said: str) -> None:
    answer = run("explain", line)
    assert answer.code == 2
    assert said in answer.err


def test_lines_of_samples_are_read_in_their_own_language() -> None:
    samples = Path(__file__).resolve().parents[2] / "gcode_samples"
    names = {
        "two_faces.nc": "RS274/NGC",
        "fanuc_tilted.nc": "Fanuc",
        "two_faces.mpf": "Siemens",
        "two_faces.h": "Klartext",
        "two_faces.cls": "APT",
    }
    for name, language in names.items():
        lines = [line for line in (samples / name).read_text("utf-8").splitlines() if line.strip()]
        for line in lines[::4]:
            assert any(language in texts for texts in read(line).values()), (name, line)


def test_a_code_of_remap_is_told_as_such(run: Callable[..., Any], tmp_path: Path) -> None:
    """It was not known, and refused (VP002)."""
    program = tmp_path / "clamp.nc"
    program.write_text("%\nO1\nG21 G90 G94 G54\nM428 M13\nM30\n%\n")
    (tmp_path / "clamp.nc.toml").write_text('[remap]\nM13 = "ignore"\nM428 = "tcp on"\n')
    told = run("explain", f"{program}:4").out
    assert re.search(r'\n  M428 +"tcp on", says \[remap\]\n  M13 +"ignore", says \[remap\]\n', told), told


def test_a_continued_line_with_an_unread_word_is_told(run: Callable[..., Any], tmp_path: Path) -> None:
    """An M code in it was taken for a statement, or for none: IndexError."""
    program = tmp_path / "drill.h"
    program.write_text("0 BEGIN PGM A MM\n1 CYCL DEF 200 ~\n  Q200=2 ~\n  M8 = M9 Q201=-5\n2 M30\n3 END PGM A MM\n")
    told = run("explain", f"{program}:4").out
    assert re.search(r"\n  M8 +flood coolant on\n.*\n  Q201=-5 +depth", told)


@pytest.mark.parametrize("words", [["calibrate"], ["validate", "x.toml"], ["show"], ["list"], ["tolerances", "--help"]])
def test_a_command_of_machine_is_named_where_it_stands_alone(run: Callable[..., Any], words: list[str]) -> None:
    assert f"did you mean `verne-post machine {' '.join(words)}`?" in run(*words).err


def test_the_short_answer_and_all_agree_on_the_other_solution(run: Callable[..., Any], tmp_path: Path) -> None:
    """C of the other solution, half a turn away, was beyond its travel, although a whole turn brings it back."""
    program = tmp_path / "turned.nc"
    program.write_text("G90 G21\nG0 X0 Y0 Z80 A10 C240\nG1 X10 F300\nM30\n")
    options = ("--machine", "ca_fork_head", "--tool-length", "100", "--wcs", "G54=200,200,100")
    short, whole = (run("explain", f"{program}:3", *options, *more).out for more in ((), ("--all",)))
    assert "other head solution: possible" in short
    assert "other head solution: possible" in whole
    assert "of which 2 possible" in whole


def test_axes_of_the_machine_are_told_as_such(run: Callable[..., Any]) -> None:
    """B was one of other machines, also where the machine has B."""
    for machine, said in (
        ("nutating_table", "axis B goes to 20 degrees"),
        ("verne", "axis B, which this machine lacks: refused (VP011)"),
    ):
        assert f"Siemens: {said}\n" in run("explain", "N150 G1 X45 B=DC(20)", "--machine", machine).out
    assert describe_word("B")[0] == describe_word("A")[0] == "Siemens: " + siemens.ADDRESSES["A"]


def test_words_of_siemens_say_how_the_tool_axis_moves() -> None:
    """With the key and without it, as Motion.has_linear_axes executes them."""
    (axes,), (vector,) = describe_word("ORIAXES"), describe_word("ORIVECT")
    assert "the rotary axes go linearly, where orientation_by_group" in axes
    assert "ORIWKS ORIAXES is a great circle" in axes
    assert "the tool axis goes along a great circle, where orientation_by_group" in vector
