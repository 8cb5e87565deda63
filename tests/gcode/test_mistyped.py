"""Words and numbers that somebody has mistyped: what is meant is said, once, in every language."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from verne_post import check
from verne_post.app.assemble import view_moves_plainly
from verne_post.base.suggestions import find_correction
from verne_post.gcode.mistyped import correct_line, execute_as_meant, explain_unknown
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.siemens.vocabulary import GROUP_OF, NO_EFFECT
from verne_post.model.findings import Finding
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

PLACE = ("--tool-length", "80", "--wcs", "G54=0,0,0")
#: Language -> a program with a place for lines, and the number of the first of them.
PROGRAMS = {
    "p.ngc": ("G21 G90 G94 G17\nG0 X0 Y0 Z60 A0 C0\nG1 F600 Z50\n{}\nM2\n", 4),
    "p.nc": ("%\nO1\nG21 G90 G94 G17\nG43.4 H1\nG0 X0. Y0. Z60. A0. C0.\nG1 F600. Z50.\n{}\nM30\n%\n", 7),
    "p.mpf": ("G17 G90 G94 G71 G54\nG0 A0 C0\nG0 X0 Y0 Z60\nG1 F600 Z50\n{}\nM30\n", 5),
    "p.h": ("BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X0 Y0 Z60 A0 C0 R0 FMAX M3\nL Z+50 F600\n{}\nEND PGM P MM\n", 5),
    "p.apt": ("PARTNO P\nUNITS/MM\nLOADTL/1\nFEDRAT/600,MMPM\nGOTO/0,0,60,0,0,1\n{}\nFINI\n", 6),
}


def find_errors(run: Callable[..., Any], tmp_path: Path, name: str, lines: str) -> list[str]:
    """The first lines of all findings of a program, without its name."""
    path = tmp_path / name
    path.write_text(PROGRAMS[name][0].format(lines))
    answer = run("check", path, *PLACE)
    head = f"{path}:"
    return [line.removeprefix(head) for line in answer.out.splitlines() if line.startswith(head) and ": VP" in line]


@pytest.mark.parametrize(
    ("name", "line", "written", "meant", "column"),
    [
        ("p.nc", "G1 X10. Y1O.", "Y1O.", "Y10.", 9),
        ("p.nc", "G1X1O.5Y2.", "X1O.5", "X10.5", 3),
        ("p.nc", "GO X1.", "GO", "G0", 1),
        ("p.nc", "G1 X-O.5", "X-O.5", "X-0.5", 4),
        ("p.nc", "N5 GO1 X10. F300.", "GO1", "G01", 4),  # no jump to N1: nothing follows the number of one
        ("p.nc", "GO X9.\nX5. F300.", "GO", "G0", 1),  # F without use (VP009) only follows from it
        ("p.nc", "MO5", "MO5", "M05", 1),
        ("p.nc", "GO X42. Y0. I0. J6.", "GO", "G0", 1),  # it may be an arc: nothing is told about I and J
        ("p.ngc", "GO X20 Y12 I0 J6", "GO", "G0", 1),
        ("p.mpf", "G1O X3", "G1O", "G10", 1),
        ("p.nc", "G1 X18,794 Y2.", "X18,794", "X18.794", 4),
        ("p.ngc", "G1 X10 Y1O", "Y1O", "Y10", 8),
        ("p.ngc", "G1 X18,794 Y2", "X18,794", "X18.794", 4),
        ("p.mpf", "G1 X10 Y1O", "Y1O", "Y10", 8),
        ("p.mpf", "G1 X18,794 Y2", "X18,794", "X18.794", 4),
        ("p.mpf", "G1 X=1O", "X=1O", "X=10", 4),
        ("p.h", "L X+5 Y+1O", "Y+1O", "Y+10", 7),
        ("p.apt", "GOTO/1O,0,60", "1O", "10", 6),
        ("p.nc", "G1 X 1O. Y2.", "X 1O.", "X10.", 4),
        ("p.nc", "GOO Z12.", "GOO", "G00", 1),
        ("p.nc", "G4 PO", "PO", "P0", 4),
        ("p.h", "PLANE SPATIAL SPA+0 SPB+0 SPCO MOVE", "SPCO", "SPC0", 27),
        *((name, "G1 X4S. Y2.", "X4S.", "X45.", 4) for name in ("p.nc", "p.ngc", "p.mpf")),
        *((name, "G1 X-3l. Y2.", "X-3l.", "X-31.", 4) for name in ("p.nc", "p.ngc", "p.mpf")),
        ("p.h", "L X+4S. Y+2", "X+4S.", "X+45.", 3),
        ("p.apt", "GOTO/4S.5,0,60", "4S.5", "45.5", 6),
        ("p.apt", "GOTO/-3l.,0,60", "-3l.", "-31.", 6),
    ],
)
def test_a_number_with_another_character(
    run: Callable[..., Any], tmp_path: Path, name: str, line: str, written: str, meant: str, column: int
) -> None:
    """One finding, at the word; no other one about the same word, such as that it has no point (VP038)."""
    letter = next(one for one, digit in zip(written.replace(" ", ""), meant, strict=True) if one != digit)
    what = "a decimal comma" if letter == "," else f"the letter {letter}"
    text = f"VP001 error: {written}: {what} in a number; did you mean {meant}?"
    assert find_errors(run, tmp_path, name, line) == [f"{PROGRAMS[name][1]}:{column}: {text}"]


@pytest.mark.parametrize(
    ("name", "line", "written", "meant", "column"),
    [
        ("p.nc", "G1 XlO. Y2.", "XlO", "X10", 4),
        ("p.ngc", "G1 X-lO Y2", "X-lO", "X-10", 4),
        ("p.mpf", "G1 XlO", "XlO", "X10", 4),
        ("p.mpf", "G1 XlOO", "XlOO", "X100", 4),
        ("p.h", "L X+lO Y+2", "X+lO", "X+10", 3),
    ],
)
def test_a_number_of_letters_alone(
    run: Callable[..., Any], tmp_path: Path, name: str, line: str, written: str, meant: str, column: int
) -> None:
    text = f"VP001 error: {written}: the letters l and O in a number; did you mean {meant}?"
    assert find_errors(run, tmp_path, name, line) == [f"{PROGRAMS[name][1]}:{column}: {text}"]


@pytest.mark.parametrize(("written", "meant"), [("CYCLE80", "CYCLE800"), ("CYCLE38", "CYCLE83"), ("CYCLE97", "")])
def test_a_mistyped_cycle(run: Callable[..., Any], tmp_path: Path, written: str, meant: str) -> None:
    """CYCLE97 is a cycle of lathes, and no slip of CYCLE79."""
    (found,) = find_errors(run, tmp_path, "p.mpf", f"{written}(1,2,3)")
    assert f"VP002 error: {written} is not executed" in found
    assert re.findall(r"did you mean (\w+)\?", found) == [meant] * bool(meant)


def test_nothing_is_told_that_only_follows_from_a_mistyped_number(run: Callable[..., Any], tmp_path: Path) -> None:
    """After G8O the cycle was taken to go on, and the retract had a second error (VP007)."""
    cycle = "G98 G81 X0. Y0. Z40. R50. F200.\nX5.\nG8O\nZ60.\nX1O."
    text = "VP001 error: {}: the letter O in a number; did you mean {}?"
    expected = [f"9:1: {text.format('G8O', 'G80')}", f"11:1: {text.format('X1O.', 'X10.')}"]
    assert find_errors(run, tmp_path, "p.nc", cycle) == expected


@pytest.mark.parametrize(
    ("name", "line", "meant"),
    [
        ("p.nc", "M9O", "M9"),
        ("p.mpf", "M9O", "M9"),
        ("p.mpf", "M06O", "M06"),
        ("p.h", "L Z+80 FMAX M8O", "M8"),
    ],
)
def test_a_mistyped_code_is_told_once(
    run: Callable[..., Any], tmp_path: Path, name: str, line: str, meant: str
) -> None:
    """M80 has no meaning, so that M8 is meant."""
    (found,) = find_errors(run, tmp_path, name, line)
    assert found.endswith(f"VP001 error: {line.split()[-1]}: the letter O after the M code; did you mean {meant}?")


@pytest.mark.parametrize("code", ["M3O", "M0O"])
def test_a_letter_o_is_a_zero_where_that_code_has_a_meaning(run: Callable[..., Any], tmp_path: Path, code: str) -> None:
    (found,) = find_errors(run, tmp_path, "p.nc", code)
    assert found.endswith(f"VP001 error: {code}: the letter O in a number; did you mean {code.replace('O', '0')}?")


@pytest.mark.parametrize("line", ["G45", "G34 H1", "G38 X1 Y1", "G31", "G35", "M89 P2"])
def test_codes_whose_digits_changed_places_are_not_proposed(run: Callable[..., Any], tmp_path: Path, line: str) -> None:
    """G38 probes: nobody who writes it means G83, which pecks."""
    (found,) = find_errors(run, tmp_path, "p.nc", line)
    assert "VP002 error" in found
    assert "did you mean" not in found


@pytest.mark.parametrize(
    ("name", "line", "columns"),
    [("p.mpf", "TRAOR SUPAA X1 Q7=3", [1, 7, 16]), ("p.h", "L Z+80 FMA MM9 X+1 Y+1O", [8, 12, 20])],
)
def test_columns_are_those_of_the_line_as_it_stands(
    run: Callable[..., Any], tmp_path: Path, name: str, line: str, columns: list[int]
) -> None:
    """Words before it are corrected before a further error is found."""
    found = find_errors(run, tmp_path, name, line)
    assert [int(one.split(":")[1]) for one in found] == columns


QUOTED, EDGE = (
    "the name of a tool is written in quotation marks",
    "the set-up gives tool 1 one cutting edge, D1; enter edge 3 in",
)


@pytest.mark.parametrize(
    ("name", "lines", "text"),
    [
        # the arc begins where the mistyped line ends
        ("p.mpf", "G1 X50 Y1O\nG3 X60 Y20 CR=10", "VP001 error: Y1O: the letter O in a number; did you mean Y10?"),
        ("p.mpf", "G1 X50,5 Y0\nG3 X50.5 Y20 CR=10", "VP001 error: X50,5: a decimal comma in a number"),
        ("p.h", "L X+50 Y+1O\nCR X+60 Y+20 R+10 DR+", "VP001 error: Y+1O: the letter O in a number"),
        ("p.mpf", "T=EM10 M6\nD1", f'VP001 error: T=EM10: {QUOTED}; did you mean T="EM10"?'),
        ("p.mpf", "T = EM10\nM6 D1", f'VP001 error: T = EM10: {QUOTED}; did you mean T="EM10"?'),
        ("p.mpf", "T1 M6\nD3\nG1 X5", f"VP012 error: D3: {EDGE} [tools]"),
    ],
)
def test_what_follows_from_a_mistake_is_not_told(
    run: Callable[..., Any], tmp_path: Path, name: str, lines: str, text: str
) -> None:
    """The line is executed with what is meant in its place."""
    (found,) = find_errors(run, tmp_path, name, lines)
    assert found.partition(": ")[2].startswith(text)


@pytest.mark.parametrize("name", ["p.ngc", "p.nc"])
def test_a_letter_that_is_there_twice(run: Callable[..., Any], tmp_path: Path, name: str) -> None:
    (found,) = find_errors(run, tmp_path, name, "G1 GG94. X1.")
    text = "VP001 error: GG94.: the letter is there twice; did you mean G94.?"
    assert found == f"{PROGRAMS[name][1]}:4: {text}"


@pytest.mark.parametrize("line", ["R1=_F_ENGAG", "_F_ENGAG=3"])
def test_a_misspelt_variable(run: Callable[..., Any], tmp_path: Path, line: str) -> None:
    (found,) = find_errors(run, tmp_path, "p.mpf", f"DEF REAL _F_ENGAGE=2\n{line}")
    assert "; did you mean _F_ENGAGE?" in found


def test_a_misspelt_named_parameter(run: Callable[..., Any], tmp_path: Path) -> None:
    found = find_errors(run, tmp_path, "p.ngc", "#<depth>=5\nG1 X#<dept>")
    assert found == ["5:5: VP025 error: #<dept>: it has no value; did you mean #<depth>?"]
    Path(tmp_path, "latin.ngc").write_bytes("G0 X0 Y0 Z50\nG1 X[#<l\xe4nge>+1] F100\nM2\n".encode("latin-1"))
    assert "#<l\xe4nge> has no value" in run("check", tmp_path / "latin.ngc").out
    slip = "G0 X0 Y0 Z50\n#<l\xe4enge>=5\nG1 X#<l\xe4nge> F100\nY#<l\xe4nge>\nM2\n"
    Path(tmp_path, "latin.ngc").write_bytes(slip.encode("latin-1"))
    assert "#<l\xe4nge> has no value, and line 2 sets #<l\xe4enge>" in run("check", tmp_path / "latin.ngc").out


def test_cycles_of_two_digits_are_not_taken_for_each_other(run: Callable[..., Any], tmp_path: Path) -> None:
    (found,) = find_errors(run, tmp_path, "p.mpf", "CYCLE97(1)")
    assert "did you mean" not in found


@pytest.mark.parametrize(
    ("name", "line", "written", "meant", "code"),
    [
        ("p.nc", "G68.2 X0. Y0. Z0. I0. J0. K0.\nG35.1\nG69", "G35.1", "G53.1", "VP002"),
        ("p.mpf", "TRAOIR", "TRAOIR", "TRAORI", "VP002"),
        ("p.mpf", "SUAP G0 Z0", "SUAP", "SUPA", "VP002"),
        ("p.mpf", "CYCEL832(0.01,1)", "CYCEL832", "CYCLE832", "VP002"),
        ("p.mpf", "CYCLE823(0.01,1)", "CYCLE823", "CYCLE832", "VP002"),
        ("p.mpf", "CYCLE80O()", "CYCLE80O", "CYCLE800", "VP002"),
        ("p.mpf", "TRAF0OF", "TRAF0OF", "TRAFOOF", "VP002"),
        ("p.h", "PLANE SPACIAL SPA+0 SPB+0 SPC+0 STAY", "SPACIAL", "SPATIAL", "VP002"),
        ("p.h", "L Z+80 FMXA M9", "FMXA", "FMAX", "VP001"),
        ("p.h", "TOLO CALL 1", "TOLO", "TOOL", "VP002"),
        ("p.h", "TOOL CLAL 1", "CLAL", "CALL", "VP002"),
        ("p.apt", "RAPDI", "RAPDI", "RAPID", "VP002"),
        ("p.mpf", "G3 X10 Y10 CR10", "CR10", "CR=10", "VP002"),
        ("p.mpf", "_ORI_FINSH\nM30\n%_N__ORI_FINISH_SPF\nRET", "_ORI_FINSH", "_ORI_FINISH", "VP002"),
    ],
)
def test_a_misspelt_word(
    run: Callable[..., Any], tmp_path: Path, name: str, line: str, written: str, meant: str, code: str
) -> None:
    """What is meant is all that the message proposes: no meaning for a word that nobody has meant."""
    text = f"{code} error: {written}: no meaning in this language; did you mean {meant}?"
    (found,) = find_errors(run, tmp_path, name, line)
    before, at = line[: line.index(written)], PROGRAMS[name][1]
    assert found == f"{at + before.count(chr(10))}:{len(before) - before.rfind(chr(10))}: {text}"


DRILLING = "CYCL DEF 200 DRILLING ~\nQ20=2 ~\nQ201=-10 ~\nQ206=250 ~\nQ202=5 ~\nQ210=0 ~\nQ203=0 ~\nQ204=50 ~\nQ211=0"


@pytest.mark.parametrize(
    ("name", "lines", "text"),
    [
        (
            "p.h",
            DRILLING,
            "Q20: CYCL DEF 200 has no such parameter; Q200, the clearance, is missing; did you mean Q200?",
        ),
        ("p.h", "PLANE SPATIAL SPA+0 SPB+0 SPD+0 STAY", "SPD: no word of PLANE SPATIAL; did you mean SPC?"),
        (
            "p.nc",
            "G8l Z40. R50. F200.\nG80",
            "7:1: VP001 error: G8l: the letter l in a number; did you mean G81?",
        ),
        ("p.ngc", "G98 G8l Z40 R50 F200\nG80", "G8l: the letter l in a number; did you mean G81?"),
        ("p.ngc", "G1 Xl0", "Xl0: the letter l in a number; did you mean X10?"),
        # no meaning that hides a motion is offered
        (
            "p.mpf",
            "FANCY X10",
            "FANCY: no meaning in this language beside other words of a block; write the intended word",
        ),
        ("p.mpf", "FANCY", "; if it moves no axis, [remap] of the set-up"),
        (
            "p.nc",
            "G53.2 X1.",
            "G53.2 is not a code of this language, and its block names axes; write the code that is meant",
        ),
        ("p.h", "L X+5 F", "7: VP001 error: F without a number; write the feed rate, F AUTO or FMAX\n"),
        # all that a cycle lacks is one finding
        (
            "p.h",
            DRILLING.replace("Q20=2", "Q200=2").replace("Q202=5 ~\nQ210=0 ~\n", ""),
            "VP005 error: CYCL DEF 200 needs Q202 (the infeed) and Q210 (the dwell above)\n",
        ),
        (
            "p.nc",
            "G83 X1. F90.",
            "G83 needs R (the height from which it feeds), Z (the bottom of the hole) and Q (the depth of one peck)\n",
        ),
        ("p.nc", "G83 X1. R5. Z-3. F90.", "VP005 error: G83 needs Q, the depth of one peck\n"),
        ("p.mpf", "CYCLE81()", "VP005 error: CYCLE81: RTP, RFP and DP or DPR are needed\n"),
        ("p.mpf", "POCKET3(9,,1)", "VP005 error: POCKET3: RFP and DP are needed\n"),
        ("p.mpf", "CYCLE81(9,5,1)", "VP005 error: CYCLE81: DP or DPR is needed (value 4 of the call)\n"),
        ("p.nc", "G38 X1.", "its block names axes; write the code that is meant\n"),
        ("p.nc", "G31", "only known at the machine; take it out)\n"),
        ("p.h", "L X+5 M218", 'can give one: "ignore" or "event"\n'),
        ("p.nc", "G53.2", 'can give it a meaning: "G53.2" = "ignore"'),
    ],
)
def test_what_is_proposed_for_an_unknown_word(
    run: Callable[..., Any], tmp_path: Path, name: str, lines: str, text: str
) -> None:
    """One finding, which never offers to ignore what may move the axes."""
    (found,) = find_errors(run, tmp_path, name, lines)
    assert text in f"{found}\n"


def test_the_first_statement_of_klartext(run: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "p.h"
    path.write_text(PROGRAMS["p.h"][0].replace("BEGIN", "BEGN").format("M30"))
    answer = run("check", path, *PLACE)
    assert "p.h:1:1: VP002 error: BEGN: no meaning in this language; did you mean BEGIN?" in answer.out


@pytest.mark.parametrize(
    ("word", "known"),
    [
        ("CYCLE833", "CYCLE832"),  # another cycle
        ("M80", "M81"),
        ("G34", "G35"),
        ("G12", "G21"),
        ("G142", "G124"),
        ("M218", "M128"),
        ("KX_CLAMP", "KX_RELEASE"),
        ("ON", "NO"),  # too short to tell
        ("SOFTB", "XOFT"),
    ],
)
def test_words_that_are_not_near(word: str, known: str) -> None:
    assert explain_unknown("as it was", word, [known]) == "as it was"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("WHILE [1 EQ 1] DO", "DO"),  # the letter O of a word
        ("G1 X1,234.5", "does not begin a word"),  # a comma of thousands: two readings
        ("G1 X10. ,R2", ""),  # a corner
    ],
)
def test_what_only_looks_like_a_mistyped_number(run: Callable[..., Any], tmp_path: Path, line: str, said: str) -> None:
    found = find_errors(run, tmp_path, "p.nc", line)
    assert "did you mean" not in " ".join(found)
    assert said in " ".join(found)


def test_the_words_of_a_lathe_cycle_are_no_slips_of_keys(run: Callable[..., Any], tmp_path: Path) -> None:
    (said,) = find_errors(run, tmp_path, "p.nc", "G71 U2. R1.")
    assert "G71 with U is a cycle of lathes" in said and "key is beside" not in said
    assert any("Y2 may be meant, whose key" in one for one in find_errors(run, tmp_path, "p.nc", "G1 U2."))


def test_a_number_without_a_point_beside_a_corner_is_still_seen(run: Callable[..., Any], tmp_path: Path) -> None:
    found = find_errors(run, tmp_path, "p.nc", "G1 X10,R2.\nY5.")
    assert [one for one in found if "VP038 warning: X10 has no decimal point" in one]


def test_words_without_a_point_are_told_also_where_the_first_stands_beside_an_error(
    run: Callable[..., Any], tmp_path: Path
) -> None:
    found = find_errors(run, tmp_path, "p.nc", "G1 X10 Y2.Y3.\nX5 Y3.\nX6 Y4.")
    assert [one for one in found if "VP038 warning: 2 words (X5 first; lines" in one]


@pytest.mark.parametrize(
    ("name", "lines", "written"),
    [
        ("p.mpf", "TRAOIR\nG1 X5 Y0 Z50 A3=0 B3=0.1 C3=1", "TRAOIR"),
        ("p.mpf", "TRAOIR\nG1 X5 A5 C10", "TRAOIR"),
        ("p.h", "L X+10 R0 FMXA M128\nLN X+10 Y+0 Z+50 TX+0 TY+0.6 TZ+0.8 F500", "FMXA"),
        ("p.h", "PLNAE SPATIAL SPA+10 SPB+0 SPC+0 TURN FMAX\nL X+0 Y+0 F500", "PLNAE"),
        ("p.nc", "G4.34 H1\nG1 X5. A5. C10.", "G4.34"),
        ("p.apt", "FEDRTA/600,MMPM\nGOTO/10,0,60,0,0,1", "FEDRTA"),
    ],
)
def test_a_misspelt_word_is_one_finding(
    run: Callable[..., Any], tmp_path: Path, name: str, lines: str, written: str
) -> None:
    """What follows is read as if the word were right."""
    (found,) = find_errors(run, tmp_path, name, lines)
    assert f"error: {written}: no meaning in this language; did you mean " in found


def test_errors_beside_a_misspelt_word_are_found_too(run: Callable[..., Any], tmp_path: Path) -> None:
    """The line is executed again with the word that is meant: two words, and a mistake that is none of spelling."""
    found = find_errors(run, tmp_path, "p.mpf", "SUAP G0 Z0 D0 CYCEL800()\nG1 X5 X6")
    assert [one.split(":")[3].strip() for one in found] == ["SUAP", "CYCEL800", "X appears twice in the block"]


def test_what_an_unknown_name_may_have_switched_on_is_not_reported(run: Callable[..., Any], tmp_path: Path) -> None:
    """A name of the machine's builder may stand for TRAORI; once it has a meaning, the rest is said."""
    (found,) = find_errors(run, tmp_path, "p.mpf", "MY_FIVE_AXES(1)\nG1 X5 Y0 Z50 A3=0 B3=0.1 C3=1")
    assert "VP002 error: MY_FIVE_AXES: no meaning in this language" in found
    (found,) = find_errors(run, tmp_path, "p.mpf", "G1 X5 Y0 Z50 A3=0 B3=0.1 C3=1")
    assert "VP017 error: A3= B3= C3= without TRAORI; write TRAORI before line" in found


def test_a_misspelt_word_of_a_loop_is_not_executed(run: Callable[..., Any], tmp_path: Path) -> None:
    """Its partner is found by the text as it is written, which lacks it."""
    found = find_errors(run, tmp_path, "p.mpf", "ENDFRO")
    assert len(found) == 1
    assert "VP002 error: ENDFRO: no meaning in this language; did you mean ENDFOR?" in found[0]
    found = find_errors(run, tmp_path, "p.mpf", "LOOP\nX5\nENDLOP")
    assert found == ["5:1: VP023 error: LOOP is never closed; expected ENDLOOP, which line 7 writes as ENDLOP"]


@pytest.mark.parametrize("name", ["p.nc", "p.ngc"])
def test_a_letter_behind_a_code_is_too_many(run: Callable[..., Any], tmp_path: Path, name: str) -> None:
    """G830 is no code: it was told twice, and its fix led to a further error."""
    cycle = "{} X5. Y0. Z45. R50. Q1. F100.\nG80"
    text = "VP001 error: G83O: the letter O after the code; did you mean G83?"
    assert find_errors(run, tmp_path, name, cycle.format("G98 G83O")) == [f"{PROGRAMS[name][1]}:5: {text}"]
    assert find_errors(run, tmp_path, name, cycle.format("G98 G83")) == []


def test_a_line_with_a_letter_twice_has_the_columns_as_it_stands(run: Callable[..., Any], tmp_path: Path) -> None:
    """The second error is found in the corrected line, which is shorter by one."""
    found = find_errors(run, tmp_path, "p.ngc", "G1 XX20 B5")
    assert [one.split(" error")[0] for one in found] == ["4:4: VP001", "4:9: VP011"]


@pytest.mark.parametrize(
    ("line", "column", "text"),
    [
        ("N520 50.", 6, "50.: a number without a letter before it; write its letter, such as X50., Y50. or Z50."),
        ("N520 -50", 6, "-50: a number without a letter before it; write its letter, such as X-50, Y-50 or Z-50"),
        ("/N49 10. Y21.", 6, "10.: a number without a letter before it; did you mean X10.?"),
        ("X10. 21. Z4.", 6, "21.: a number without a letter before it; did you mean Y21.?"),
        ("X10. 1.1.", 6, "1.1.: two points in a number, and no letter before it"),
        ("X10. .5.5", 6, ".5.5: two points in a number, and no letter before it"),
        ("X10. 2", 6, "2: a number without a letter before it; write its letter, such as Y2 or Z2"),
        ("X[9] 2. Y9. F9.", 6, "2.: a number without a letter before it; write its letter, such as Z2."),
        ("G1 9.5 F300.", 4, "9.5: a number without a letter before it; write its letter, such as X9.5, Y9.5 or Z9.5"),
        ("N150. X35.", 1, "N150.: a block number has no decimal point; did you mean N150?"),
        ("N52050. (UP)", 1, "N52050.: a block number has no decimal point, and a letter may be missing in it"),
    ],
)
def test_a_letter_is_lost(run: Callable[..., Any], tmp_path: Path, line: str, column: int, text: str) -> None:
    """N520 50. was read as block 52050, and the retract of N520 Z50. was gone, without a word."""
    lines = "\n".join(["X1. Y1. S12 (1 2)"] * 20 + [line] + ["X 1. Y2. (3. 4)"] * 20)
    found = find_errors(run, tmp_path, "p.nc", lines)
    assert found[0].startswith(f"{PROGRAMS['p.nc'][1] + 20}:{column}: VP001 error: {text}")
    assert len(found) == 1


def test_a_letter_is_lost_where_linuxcnc_reads_on(run: Callable[..., Any], tmp_path: Path) -> None:
    """LinuxCNC reads blanks in numbers and a point in a block number: the program runs, and is warned of."""
    lines = "\n".join(["N10 X1 Y1 (N1 2)"] * 20 + ["N520 50.", "N15. X35", "X 1 0"] + ["N10 X1 Y2"] * 20)
    found = find_errors(run, tmp_path, "p.ngc", lines)
    assert [re.split(": (?:all of it|blanks)", one)[0] for one in found] == [
        "24:6: VP001 warning: N520 50.",
        "25:1: VP001 warning: N15.",
        "26:5: VP001 warning: X 1 0",
    ]


@pytest.mark.parametrize(
    ("lines", "line", "code", "text"),
    [
        (
            "G1 X5 F500\nG1 -25 C0",
            1,
            "VP001 error",
            "-25: a number without a letter before it; -25 may lack its letter",
        ),
        ("G1 X5 F500\nG64 0.01", 1, "VP001 error", "0.01 may lack its letter, such as P0.01"),
        ("G1 X5 F500\nN9 4G9 X5", 1, "VP001 error", "4G9: a digit before its letter, which"),
        ("N20 53 G0 Z0.", 0, "VP001 warning", "write it, such as G53"),
        ("T2 06", 0, "VP001 warning", "this is T206; 06 may lack its letter, such as M06"),
        ("G4 3H1", 0, "VP001 warning", "G4 3H1: a blank in a number, which is read as G43; write G43 H1"),
        ("g43 .h1", 0, "VP001 warning", "g43 .: a blank in a number, which is read as g43.; write g43"),
        ("#5=1 2\nG1 X#5 F500", 0, "VP001 warning", "this is #5=12; write #5=12 without the blank"),
        ("#52=3\nG1 X#5 2 F500", 1, "VP001 warning", "this is X#52; 2 may lack its letter, such as Y2"),
        ("G43.4 5", 0, "VP001 error", "5 may lack its letter, such as H5"),
        ("M330", 0, "VP002 error", "did you mean M30? Else [remap]"),
        ("#<z> 1\nG1 X#<z> F500", 0, "VP001 error", "an = is missing"),
        ("#<>z=1\nG1 X#<z> F500", 0, "VP001 error", "#<>z: the name of a parameter is missing; did you mean #<z>?"),
        ("#<<z>=1\nG1 X#<z> F500", 0, "VP001 error", "#<<z>: the < is there twice; did you mean #<z>?"),
        ("#<z>>=1\nG1 X#<z> F500", 0, "VP001 error", "#<z>>: the > is there twice; did you mean #<z>?"),
        (
            "#<z = 1\nG1 X#<z> F500",
            0,
            "error",
            "#<z: the name of a parameter is not closed; expected '>'; did you mean",
        ),
        ("#<z>=1\nG1 X#z> F500", 1, "VP001 error", "#z>: the < of the name is missing; did you mean #<z>?"),
        ("#<z>=1\nG1 X<#z> F500", 1, "VP001 error", "<#z>: the # stands before the <; did you mean #<z>?"),
        ("#<y>=1\n#<z>=[#<y> > -1]\nG1 X#<z> F500", 1, "VP001 error", ">: no operator here; did you mean GT?"),
        ("#<y>=1\n#<z>=[#<y>>=ABS[1]]\nG1 X#<z> F500", 1, "VP001 error", ">=: no operator here; did you mean GE?"),
        ("#<y>=1\n#<z>=[#<y>> GT 2]\nG1 X#<z> F500", 1, "VP001 error", "#<y>>: the > is there twice; did you mean"),
        ("#<z>=[#<_a>>*2]\nG1 X#<z> F500", 0, "VP001 error", "#<_a>>: the > is there twice; did you mean #<_a>?"),
        (
            "oh<ole> sub\nG1 X#<q> F500\no<hole> endsub",
            0,
            "VP001 error",
            "a letter before the <; did you mean o<hole>?",
        ),
        ("o<a> sub\no<a> endsub\no<a> call [[1] [2]", 2, "VP001 error", "the [ is there twice, or one is not closed"),
        ("o<a> sub\no<a> endsub\no<a> call [1 [2]", 2, "VP001 error", "the [ before it is open"),
        ("o1 ddo\nG0 X1\no1 while [0]", 0, "VP023 error", "ddo: no word after o1; did you mean do?"),
        ("G1 X5 Y0 F500\nG3 X15 Y5 R.5\nG1 Y9\nG3 X5 Y9 I-3", 1, "VP008 error", "the radius 0.5 mm is too small"),
    ],
)
def test_a_slip_has_one_finding_and_what_follows_has_none(
    run: Callable[..., Any], tmp_path: Path, lines: str, line: int, code: str, text: str
) -> None:
    """Such as an arc that no longer closes, a travel, a variable without a value."""
    (found,) = find_errors(run, tmp_path, "p.ngc", lines)
    assert found.startswith(f"{PROGRAMS['p.ngc'][1] + line}:") and f" {code}: " in found and text in found


@pytest.mark.parametrize(
    ("lines", "wanted"),
    [
        (
            "G1 X1 F1 0 0\nX2 Z6 0\nX5 7\nX15 28 F500\nX3",
            [*(f"{at}: VP001 warning" for at in ("4:7", "5:7", "6:4", "7:5")), "7: VP110 error"],
        ),
        ("G1 X1 F1 0 0\nX2 Y1 0\nX9000", ["4:7: VP001 warning", "5:7: VP001 warning", "6: VP110 error"]),
        ("G1 F1 500\nX9000\nX0", ["4:7: VP001 warning", "5: VP110 error"]),
        ("G1 X5 7000 F500\nY5", ["4:7: VP001 warning", "4: VP110 error"]),  # line 5 begins there too
        ("G1 Y1 20 F500\nY0\nX9000", ["4:7: VP001 warning", "6: VP110 error"]),
        ("G1 Y1 20 F500\nX9000", ["4:7: VP001 warning", "5: VP110 error"]),
        ("F500\nG1 X1 20\nG2 X9 Y9 I3", ["5:7: VP001 warning", "6: VP008 error"]),
        ("F500\nG1 X12 0\nX0\nG2 X9 Y9 I3", ["5:8: VP001 warning", "7: VP008 error"]),
        (
            "G0 Z3 0\nG1 X1 F1 0 0 Y 2 0\nX12 5\nG1 7 X3",
            [f"{at}: VP001 warning" for at in ("4:7", "5:7", "6:5", "7:4")],
        ),
        ("G0 0 Y0", ["4:4: VP001 warning"]),
        ("N0.5 G1 X5 Q4 F500", ["4:12: VP006 error", "4:1: VP001 warning"]),
        ("G1 X1 05 F500\nX2 0", [f"{at}: VP001 warning" for at in ("4:4", "5:4")]),
    ],
)
def test_a_number_with_a_blank_hides_no_error(
    run: Callable[..., Any], tmp_path: Path, lines: str, wanted: list[str]
) -> None:
    """It is named where it stands, whatever fails because of it; one for each line."""
    found = find_errors(run, tmp_path, "p.ngc", lines)
    assert [re.match(r"[\d:]+ VP\d+ \w+", one)[0] for one in found] == wanted


def test_a_blank_does_not_stand_for_another_error(machine: Any) -> None:
    program = b"g21 g90 g17 g94\nt1 m6\ns1000 m3\ng1 z20 f1 0 0\ng1 x1 y2\nm2"
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 10.0)}
    findings = check(program, machine, Options(dialect="rs274", tools=tools, wcs={"G54": (0, 0, 0)})).findings
    assert [(one.code, one.line) for one in findings if one.severity == "error"] == [("VP012", 4)]


@pytest.mark.parametrize(
    ("name", "lines", "wanted"),
    [
        ("p.nc", "G53.1\nG1 X5. Y5.\nG2 X10. Y0 I9. J0", ["7: VP017", "9: VP008"]),
        ("p.nc", "G53.1\nG1 X5.\nG2 X10. Y0 I9. J0\nG1 X5.\nG2 X10. Y0 I9. J0", ["7: VP017", "11: VP008"]),
        ("p.nc", "G53.1\n#1=#5041\nG91 X5.\nG2 X3. I9. J1.\nG90 G1 X5. Y5.", ["7: VP017"]),
        ("p.ngc", "g77\ng2 x9 i3 j3\ng1 x5 y5\ng2 x10 y0 i9 j0", ["4:1: VP002", "7: VP008"]),
    ],
)
def test_errors_are_held_back_until_the_place_is_known(
    run: Callable[..., Any], tmp_path: Path, name: str, lines: str, wanted: list[str]
) -> None:
    """They may follow from a plane, or a code, that is not there; not once X and Y have been named again."""
    assert [one.split(" error")[0] for one in find_errors(run, tmp_path, name, lines)] == wanted


@pytest.mark.parametrize("name", ["p.nc", "p.ngc"])
@pytest.mark.parametrize(
    ("lines", "line", "column", "text"),
    [
        ("G81 X0. Y0. Z48. R45. F200.", 0, 13, "error: Z 48 mm, the bottom of the hole, lies above R 45 mm"),
        ("G81 X0. Y0. Z-5. R-12. F200.", 0, 18, "error: R -12 mm lies below the bottom of the hole, Z -5 mm"),
        ("G81 X0. Y0. Z40. R45. F200.\nX9. R30.", 1, 5, "error: R 30 mm lies below the bottom of the hole, Z 40 mm"),
        ("G81 X0. Y0. Z40. R45. F200.\nX9.\nZ60.", 2, 1, "error: Z 60 mm, the bottom of the hole, lies above R 45 mm"),
        ("G81 X0. Y0. Z40. R45. F200.\nX9. Z45.\nX20.", 1, 0, "warning: the hole has no depth: Z 45 mm is R"),
        ("G81 X0. Y0. Z45. R45. F200.\nX9.\nX20.", 0, 0, "warning: the hole has no depth: Z 45 mm is R"),
    ],
)
def test_heights_of_a_hole(
    run: Callable[..., Any], tmp_path: Path, name: str, lines: str, line: int, column: int, text: str
) -> None:
    """The word that is wrong has the caret; a height in a later block may be a retract that lacks G80."""
    (found,) = find_errors(run, tmp_path, name, f"G98 {lines.replace(chr(10), chr(10) + ' ' * 4)}\nG80")
    first = PROGRAMS[name][1]
    place = f"{first + line}:{column + 4}" if column else f"{first + line}"
    assert found.startswith(f"{place}: VP007 {text}")
    still = f"; G81 of line {first} is still active: if no hole is meant, write G80 first"
    assert found.endswith(still) == (line > 0 and "Z" in lines.splitlines()[line])


@pytest.mark.parametrize(
    ("lines", "place", "text"),
    [
        # G53.1 and the cycle had a finding each
        (
            "G53.1\nG68.2 X0. Y0. Z10. I0. J20. K0.\nG81 X0. Y0. Z2. R12. F300.\nG80\nG69",
            "7",
            "VP017 error: G53.1 without G68.2: there is no plane to turn to; write it after G68.2",
        ),
        (
            "G68 X0. Y0. Z10. I0. J20. K0.\nG53.1\nG0 X0. Y0.\nG69",
            "7:1",
            "VP002 error: G68: I J K without R are angles of a tilted plane; did you mean G68.2?",
        ),
        (
            "G18\nG2 X10. Y0. I5. J0. F500.\nG81 X0. Y0. Z40. R45. F200.\nG80",
            "8",
            "VP006 error: J does not belong to an arc in the ZX plane; G18 of line 7 is active; the words fit an arc "
            "in the plane of G17: write G17 before, if that is meant (lines 8 to 9, 2 times)",
        ),
    ],
)
def test_one_cause_in_a_plane(run: Callable[..., Any], tmp_path: Path, lines: str, place: str, text: str) -> None:
    assert find_errors(run, tmp_path, "p.nc", lines) == [f"{place}: {text}"]


@pytest.mark.parametrize(("number", "meant"), [("02001", "O2001"), ("0 2001", "O2001"), ("2001", "O2001")])
def test_a_program_number_without_its_letter(run: Callable[..., Any], tmp_path: Path, number: str, meant: str) -> None:
    """The language was taken to be RS274/NGC, which does not have G68.2: those were further findings."""
    path = tmp_path / "p.nc"
    lines = "G68.2 X0. Y0. Z10. I0. J20. K0.\nG53.1\nG0 X0. Y0.\nG69"
    path.write_text(PROGRAMS["p.nc"][0].format(lines).replace("O1", f"{number} (PLATE)", 1))
    answer = run("check", path, *PLACE)
    (found,) = [line for line in answer.out.splitlines() if ": VP" in line]
    text = f"VP001 error: {number}: a number without a letter before it; did you mean {meant}?"
    assert found == f"{path}:2:1: {text}"


def test_two_words_that_are_each_taken_for_the_other_end() -> None:
    """The guard of Klartext counted, and the other languages had none; columns are those of the line as it stands."""
    meant = {"SUAP": "SUPA", "SUPA": "SUAP", "FOOO": "FOO"}

    def execute(text: str) -> None:
        for word, right_word in meant.items():
            if (at := text.find(word)) >= 0:
                raise ProgramError("VP001", f"{word}: no meaning in this language; did you mean {right_word}?", at + 1)

    errors, rest = execute_as_meant("FOOO SUAP", lambda: None, execute, correct_line)
    assert [(one.message[:4], one.column) for one in errors] == [("SUAP", 6), ("SUPA", 6)]
    assert rest == "FOOO SUPA"
    del meant["SUPA"]
    errors, rest = execute_as_meant("FOOO SUAP FOOO", lambda: None, execute, correct_line)
    assert [(one.message[:4], one.column) for one in errors] == [("SUAP", 6), ("FOOO", 1), ("FOOO", 11)]
    assert rest is None


def list_slips(word: str, characters: str) -> list[str]:
    """All words that one character makes of a word: lost, twice, one too many, another one, or at another place."""
    places = range(len(word))
    lost = [word[:at] + word[at + 1 :] for at in places]
    swapped = [word[:at] + word[at + 1 : at + 2] + word[at] + word[at + 2 :] for at in places]
    more = [word[:at] + one + word[end:] for at in places for one in (*characters, word[at]) for end in (at, at + 1)]
    return [one for one in dict.fromkeys((*lost, *swapped, *more, *(word + one for one in characters))) if one != word]


@pytest.mark.parametrize("line", ["G0Z.", "G90Z.", "X5 Y3Z.", "T1S.", "M3S.", "N10Z.", "X5 Y3B."])
@pytest.mark.parametrize("dialect", ["rs274", "fanuc", "siemens"])
def test_a_word_without_its_number_is_no_digit(dialect: str, line: str) -> None:
    """Z of X5 Y3Z. had no number, and Y32. was proposed."""
    options = Options(dialect=dialect, tool_length=80.0, wcs={"G54": (0, 0, 60)})
    text = f"G17 G90 G54 G94\nG0 X1 Y1 Z50 A0 C0\nG1 F500 X2\n{line}\nM30\n"
    found = view_moves_plainly(text.encode(), options)[1]
    assert not [pair for item in found for pair in list_automatic(item)]


@pytest.mark.parametrize("slip", ["COMPO", "FFWO", "ORIKS", "TOWCS", "WALIMO"])
def test_a_slip_of_two_words_is_taken_for_neither(slip: str) -> None:
    assert explain_unknown("", slip, map(str, GROUP_OF), map(str, NO_EFFECT)) == ""


def list_automatic(item: Finding) -> list[tuple[str, str]]:
    """What is executed, or preferred by an editor, in place of what is written."""
    correction = find_correction(item.message)
    edits = [(one.misspelt, one.value) for one in item.edits if one.misspelt and not one.is_choice]
    return edits if correction is None else [correction, *edits]


OF_ALL_MOVES = ("G10", "G17", "G18", "G19", "G20", "G21", "G50", "G70", "G71", "G90", "G91")
LIKE_DIGITS = str.maketrans("OI", "01")


@pytest.mark.parametrize("dialect", ["rs274", "fanuc", "siemens"])
@pytest.mark.parametrize("word", [*OF_ALL_MOVES, "G2", "G3", "M3", "M4", "X5", "X-5", "Y+12.5", "A-30", "Z0", "C10"])
def test_no_correction_changes_units_plane_distance_axis_or_sense(dialect: str, word: str) -> None:
    options = Options(dialect=dialect, tool_length=80.0, wcs={"G54": (0, 0, 60)})
    for slip in list_slips(word, "O1I0,.-+ GX9"):
        text = f"G17 G90 G54 G94\nG0 X1 Y1 Z50 A0 C0\nG1 F500 X2\n{slip}\nM30\n"
        for item in view_moves_plainly(text.encode(), options)[1]:  # what comes after reading corrects no word
            for wrong, right in list_automatic(item):
                told = f"{slip}: {item.message}"
                characters = re.sub(r"[\s=]", "", wrong.upper().translate(LIKE_DIGITS))
                letters, right_letters = (re.sub(r"[^A-Z]", "", one.upper()) for one in (wrong, right))
                assert right_letters in letters or (not letters and right_letters in "NO"), told
                assert "-+" not in wrong and ("-" in wrong) >= ("-" in right), told
                if right.upper() in OF_ALL_MOVES and (dialect == "siemens" or right.upper() not in ("G70", "G71")):
                    assert re.sub(r"(.)(?=\1)", "", characters.replace(",", "").replace(".", "")) == right.upper(), told
