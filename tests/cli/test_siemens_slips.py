"""Slips of typing in a Siemens program: the word that is marked, what is named, and the edit that mends it."""

import time
from pathlib import Path

import pytest

pytest.importorskip("pygls", reason="needs the extra lsp")

from tests.cli.test_quick_fixes import NEVER, apply_places, check, inspector, look
from verne_post.cli.lsp.fixes import find_fixes
from verne_post.cli.lsp.inspector import Inspector

__all__ = ["inspector"]

SETUP = "tool_length = 80\n[wcs]\nG54 = [0, 0, 60]\n"
PROGRAM = """N10 G17 G54 G90 G94 G710
N20 T="MILL" D1
N30 M6
N40 S12000 M3
N50 TRAORI
N60 G0 A3=0 B3=0 C3=1
N70 X-20 Y-15 Z40
N80 G1 Z6.1 F800
N90 X-10 A3=0.08 B3=-0.05 C3=0.99554
N100 G0 A3=0 B3=0 C3=1
N110 Z40
N120 TRAFOOF
N130 R1=2
N140 WHILE R1>0
N150 SLOT(12.5,R1)
N160 R1=R1-1
N170 ENDWHILE
N180 F200
N190 MCALL CYCLE83(20,0,2,-3,,-1,,0.5,0.5,0.5,1,0)
N200 X-10
N210 MCALL
N220 MSG("END")
N230 M30
%_N_SLOT_SPF
PROC SLOT(REAL LEN, REAL NR)
G0 Z12
X=-LEN Y=NR*3
RET
"""


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("CYCLE83(20", "CYCLE8320", "a ( is missing"),
        ("SLOT(REAL", "SLOTREAL", "a ( is missing"),
        ("SLOT(12.5", "SLOT12.5", "a ( is missing"),
        ("N40 S12000", "N4 0S12000", "a blank and a digit have changed places"),
        ("N90 X-10", "J90 X-10", "a block number begins with N"),
        ("N170 ENDWHILE", "M170 ENDWHILE", "a block number begins with N"),
        ("N220 MSG", "B220 MSG", "a block number begins with N"),
        ("N230 M30", "M230 M30", "a block number begins with N"),
        ("R1=R1-1", "Rl=R1-1", "a letter in the number"),
        ("B3=-0.05", "B3-=0.05", "the = stands before the sign"),
        ("X-20 Y-15", "X-2 0Y-15", "a blank and a digit have changed places"),
    ],
)
def test_a_slip_is_marked_and_its_edit_gives_the_program_back(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str
) -> None:
    assert PROGRAM.count(right) == 1
    text = PROGRAM.replace(right, wrong)
    message, marked, made = look(inspector, tmp_path / "a.mpf", text, SETUP)
    assert said in message
    assert wrong.startswith(marked.split()[0]) or marked.split()[0] in wrong
    assert (PROGRAM, True) in [made_text[1:] for made_text in made.values()]


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("N140 WHILE", "N140W HILE", "a blank is in the word; did you mean WHILE?"),
        ('N20 T="MILL"', 'N2 0T="MILL"', "a blank and a digit have changed places"),
        ("WHILE R1", "WHIKE R1", "did you mean WHILE?"),
    ],
)
def test_a_slip_that_can_mean_one_thing_alone_is_one_finding(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str
) -> None:
    message, _marked, made = look(inspector, tmp_path / "a.mpf", PROGRAM.replace(right, wrong), SETUP)
    assert said in message
    ((_path, mended, settles),) = made.values()
    assert (mended.replace(" ", ""), settles) == (PROGRAM.replace(" ", ""), True)


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("X-10 A3", "X-q0 A3", "the letter q in a number"),
        ("Y-15 Z40", "Y-15 Z4p", "the letter p in a number"),
        ("N180 F200", "N180 R200", "an = and its new value are missing"),
        ("Z6.1 F800", "Z6.1 R800", "an = and its new value are missing"),
        ("G54 G90", "Y54 G90", "Y54: G54 may be meant"),
    ],
)
def test_the_key_beside_is_offered_and_not_preferred(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str
) -> None:
    assert PROGRAM.count(right) == 1
    path = tmp_path / "a.mpf"
    text = PROGRAM.replace(right, wrong)
    found = inspector.check(path, {path: text, Path(f"{path}.toml"): SETUP}, NEVER)
    item = next(one for one in found.findings if one.severity == "error")
    assert said in item.message
    made = find_fixes(inspector, found, item, {path: text, Path(f"{path}.toml"): SETUP}, NEVER)
    texts = [(f"{fix.text[: fix.begin]}{fix.new}{fix.text[fix.end :]}", fix.settles) for fix in made if fix.text]
    assert texts == [(PROGRAM, False)]


def test_call_without_a_path_may_be_mcall(inspector: Inspector, tmp_path: Path) -> None:
    path = tmp_path / "a.mpf"
    for wrong in (FLOW.replace("MCALL CYCLE81", "CALL CYCLE81"), FLOW.replace("\nMCALL\n", "\nCALL\n")):
        found = check(inspector, path, wrong, SETUP)
        (item,) = (one for one in found.findings if one.severity == "error")
        assert item.message == "CALL needs the path of a subprogram; MCALL may be meant"
        (fix,) = find_fixes(inspector, found, item, {path: wrong}, NEVER)
        assert (apply_places(fix), fix.is_choice) == (FLOW, True)


@pytest.mark.parametrize(("wrong", "said"), [("FPR", "did you mean FOR?"), ("F OR", "a blank is in the word")])
def test_a_misspelt_for_leaves_no_end_without_partner(
    inspector: Inspector, tmp_path: Path, wrong: str, said: str
) -> None:
    program = PROGRAM.replace("N130 R1=2", "DEF INT NR\nN130 R1=2\nFOR NR=1 TO 2\nENDFOR")
    message, _marked, made = look(inspector, tmp_path / "a.mpf", program.replace("FOR NR=1", f"{wrong} NR = 1"), SETUP)
    assert said in message
    ((_path, mended, settles),) = made.values()
    assert (mended, settles) == (program.replace("NR=1", "NR = 1"), True)


def test_the_cycle_whose_key_is_beside_is_named(inspector: Inspector, tmp_path: Path) -> None:
    message, _marked, made = look(inspector, tmp_path / "a.mpf", PROGRAM.replace("N120 TRAFOOF", "CYCLE809()"), SETUP)
    assert message.endswith("; CYCLE800 may be meant, whose key is beside")
    right = PROGRAM.replace("N120 TRAFOOF", "CYCLE800()")
    assert [made_text[1:] for made_text in made.values()] == [(right, False)]


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        ("G3 X-4 Y-15 R5", ["G3 X-4 Y-15 CR=5"]),
        ("G3 X-4 Y-15 R-5.5", ["G3 X-4 Y-15 CR=-5.5"]),
        ("G3X-4Y-15R5F300", ["G3X-4Y-15 CR=5F300"]),
        ("G3 X-4 Y-15 R7", ["G3 X-4 Y-15 CR=7", "G3 X-4 Y-15 CR=R7"]),
    ],
)
def test_the_radius_of_an_arc_is_cr_also_in_a_loop(
    inspector: Inspector, tmp_path: Path, wrong: str, right: list[str]
) -> None:
    """F5 was named, and in a loop the parameter was told again."""
    program = PROGRAM.replace("N130 R1=2", "N130 R7=9 R1=4").replace(
        "N150 SLOT(12.5,R1)", f"G0 Z12\nG1 X-10 Y-15 F500\n{wrong}\nG1 X-10"
    )
    message, _marked, made = look(inspector, tmp_path / "a.mpf", program, SETUP)
    assert "the radius of an arc is CR= in this language" in message and "F5" not in message.partition("radius")[2]
    assert [text for _path, text, _settles in made.values()] == [program.replace(wrong, one) for one in right]
    assert [settles for _path, _text, settles in made.values()] == [len(right) == 1] * len(right)


def test_a_tool_that_cannot_be_read_leaves_no_empty_spindle_behind(inspector: Inspector, tmp_path: Path) -> None:
    contour = "TRAFOOF\nG41 G1 X-10 Y-15 F500\nX0\nG40 X10\nM30\n"
    program = PROGRAM.partition("N50")[0] + "G0 X-20 Y-15 Z40\nZ12\n" + contour
    setup = SETUP.partition("\n")[2] + "[tools]\nMILL = { length = 80, diameter = 6 }\n"
    message, _marked, _made = look(inspector, tmp_path / "a.mpf", program.replace('L" D1', "L D1"), setup)
    assert message.startswith("the text is not closed on its line")
    emptied = program.replace('T="MILL" D1', "T0")
    assert "no tool is in the spindle" in look(inspector, tmp_path / "b.mpf", emptied, setup)[0]


DRILLING = """N10 G17 G54 G90 G94 G710
N20 T="MILL" D1
N30 M6
N40 S1200 M3
N50 G0 X0 Y0 Z40
N60 G1 Z20 F300
N70 X25
N80 Y10
N90 M30
"""


def test_the_only_turn_of_a_program_without_traori_may_be_the_key_beside(inspector: Inspector, tmp_path: Path) -> None:
    message, _marked, made = look(inspector, tmp_path / "a.mpf", DRILLING.replace("X25", "C25"), SETUP)
    assert message.endswith("; or X25, if the key beside is meant")
    assert (DRILLING, False) in [made_text[1:] for made_text in made.values()]
    assert not any(settles for _path, _text, settles in made.values())


def test_several_turns_without_traori_lack_it(inspector: Inspector, tmp_path: Path) -> None:
    text = DRILLING.replace("X25", "C25").replace("N80 Y10", "N80 C10")
    found = inspector.check(path := tmp_path / "a.mpf", {path: text, Path(f"{path}.toml"): SETUP}, NEVER)
    item = next(one for one in found.findings if one.severity == "error")
    assert "key beside" not in item.message
    fixes = find_fixes(inspector, found, item, {path: text, Path(f"{path}.toml"): SETUP}, NEVER)
    assert any(fix.settles for fix in fixes)


def test_a_zero_before_m3_is_that_of_the_speed_or_of_the_code(inspector: Inspector, tmp_path: Path) -> None:
    text = PROGRAM.replace("S12000 M3", "S1200 0M3")
    message, _marked, made = look(inspector, tmp_path / "a.mpf", text, SETUP)
    assert message.endswith("S12000 M3 or S1200 M03 may be meant")
    assert sorted((made_text == PROGRAM, settles) for _path, made_text, settles in made.values()) == [
        (False, False),
        (True, False),
    ]


def test_a_name_of_one_letter_has_no_edit(inspector: Inspector, tmp_path: Path) -> None:
    """NR*R3 was written for N*R3, which NR*3 was: a legal program that goes elsewhere."""
    message, marked, made = look(inspector, tmp_path / "a.mpf", PROGRAM.replace("NR*3", "N*R3"), SETUP)
    assert message.endswith("; NR may be meant")
    assert (marked, made) == ("N", {})


def test_a_lost_proc_line_is_told_where_it_was(inspector: Inspector, tmp_path: Path) -> None:
    text = PROGRAM.replace("PROC SLOT(REAL LEN, REAL NR)\n", "")
    found = inspector.check(path := tmp_path / "a.mpf", {path: text, Path(f"{path}.toml"): SETUP}, NEVER)
    (item,) = (one for one in found.findings if one.severity == "error")
    assert (item.code, item.line) == ("VP023", text.split("\n").index("G0 Z12") + 1)
    assert "SLOT has no PROC line" in item.message


def test_a_wrong_block_number_of_an_end_leaves_its_loop_closed(inspector: Inspector, tmp_path: Path) -> None:
    message, _marked, _made = look(inspector, tmp_path / "a.mpf", PROGRAM.replace("N170 END", "N17p END"), SETUP)
    assert "WHILE is never closed" not in message


def test_a_long_number_before_a_word_takes_no_time(inspector: Inspector, tmp_path: Path) -> None:
    """Every digit was a place from which the rest of the line was read again: 40 s."""
    path = tmp_path / "a.mpf"
    text = PROGRAM.replace("N170 ENDWHILE", f"N1{'2' * 30_000}p ENDIF")
    begin = time.perf_counter()
    assert inspector.check(path, {path: text, Path(f"{path}.toml"): SETUP}, NEVER).findings
    assert time.perf_counter() - begin < 5.0


FLOW = """DEF INT PASS
G17 G54 G90 G94 G710
T1 D1 M6
S9000 M3
G0 A0 C0 X0 Y0 Z40
G1 Z6 F800
G2 X10 Y0 CR=5
X20 Y0 CR=5
R1=0
FOR PASS=1 TO 3
WHILE R1<3
R1=R1+1
IF R1>7
G1 X0
ELSE
G1 X6
ENDIF
ENDWHILE
LOOP
R1=R1+1
IF R1>6 GOTOF MARK
ENDLOOP
MARK:
REPEAT
R1=R1-1
UNTIL R1<2
ENDFOR
MCALL CYCLE81(20,0,2,-3)
G0 X-10
MCALL
M30
"""


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("X20 Y0 CR=5", "X20 Y0 R5", "the radius of an arc is CR= in this language"),
        ("X20 Y0 CR=5", "X20 Y0 R=5", "the radius of an arc is CR= in this language"),
        ("X10 Y0 CR=5", "X10 Y0 R 5", "the radius of an arc is CR= in this language"),
        ("MCALL CYCLE81", "MCAL LCYCLE81", "the blank is in the wrong place"),
        ("INT PASS", "INTP ASS", "the blank is in the wrong place"),
        ("DEF INT", "DEFI NT", "the blank is in the wrong place"),
        ("WHILE R1", "WHILER1", "a blank is missing"),
        ("WHILE R1", "WHIL ER1", "the blank is in the wrong place"),
        ("FOR PASS", "FO RPASS", "the blank is in the wrong place"),
        ("1 TO 3", "1 T O3", "the blank is in the wrong place"),
        ("IF R1>7", "I FR1>7", "the blank is in the wrong place"),
        ("UNTIL R1", "UNTI LR1", "which line 26 writes as UNTI LR1"),
        ("GOTOF MARK", "GOTOFMARK", "a blank is missing"),
        ("GOTOF MARK", "GOTO FMARK", "the blank is in the wrong place"),
        ("GOTOF MARK", "GOTOFM ARK", "the blank is in the wrong place"),
        ("ELSE", "ELES", "did you mean ELSE?"),  # the lines of a false condition, which nothing executed
        ("ENDIF", "ENDFI", "IF is never closed; expected ENDIF, which line 17 writes as ENDFI"),
        ("ENDIF", "ENDFI", "ELSE is never closed"),
        ("ENDWHILE", "ENDWHIEL", "which line 18 writes as ENDWHIEL"),
        ("ENDLOOP", "ENDLOP", "which line 22 writes as ENDLOP"),
        ("UNTIL R1", "UNTILL R1", "which line 26 writes as UNTILL"),
    ],
)
def test_a_slip_of_a_statement_is_one_finding_whose_edit_gives_the_program_back(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str
) -> None:
    program = FLOW if "ELSE" in said or right == "ELSE" else FLOW.replace("ELSE\n", "\n")
    assert program.count(right) == 1
    message, _marked, made = look(inspector, tmp_path / "a.mpf", program.replace(right, wrong), SETUP)
    assert said in message
    assert [made_text[1:] for made_text in made.values()] == [(program, True)]


@pytest.mark.parametrize("wrong", ["800", "R800", "G800", "F", "F(800", "800F"])
def test_a_lost_feed_rate_is_one_finding(inspector: Inspector, tmp_path: Path, wrong: str) -> None:
    path = tmp_path / "a.mpf"
    found = inspector.check(path, {path: FLOW.replace("F800", wrong), Path(f"{path}.toml"): SETUP}, NEVER)
    assert [item.line for item in found.findings if item.severity == "error"] == [6]


def test_many_slips_in_one_line_take_no_time(inspector: Inspector, tmp_path: Path) -> None:
    """For each the line was executed again: 12 s."""
    path = tmp_path / "a.mpf"
    begin = time.process_time()
    found = inspector.check(
        path, {path: FLOW.replace("F800", f"F800{'=' * 8_000}"), Path(f"{path}.toml"): SETUP}, NEVER
    )
    assert time.process_time() - begin < 3.0
    assert [item.line for item in found.findings if item.severity == "error"] == [6]


NUMBERED = """N10 G17 G54 G90 G94 G710
N20 T1 D1 M6
N30 S9000 M3
N40 G0 A0 C0 X0 Y0 Z40
N50 G1 Z6 F800
N60 G3 X10 Y0 CR=5
N70 G1 X-2 Y-8
N80 IF R1>2 GOTOF NEXT
N90 X5
N100 NEXT:
N110 Y6.5
N120 TRAORI
N130 X0 A3=0 B3=0 C3=1
N140 TRAFOOF
N150 M30
"""


@pytest.mark.parametrize(
    ("right", "wrong", "said", "is_sure"),
    [
        ("N70 G1", "N70 G11", "G11 is not a code of this language; it has G1", False),  # and no arc of N60 behind it
        ("A3=0", "A33=0", "a digit is there twice", True),
        ("Y-8", "Y8-", "the sign stands after its number", False),
        ("N140 TRAFOOF", "NI40 TRAFOOF", "the letter I in a number", True),
        ("N100 NEXT:", "N10 0NEXT:", "a blank and a digit have changed places", True),
        ("Y6.5", "U6.5", "Y6.5 may be meant, whose key is beside", False),
    ],
)
def test_a_slip_in_a_numbered_program_is_one_finding(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str, is_sure: bool
) -> None:
    assert NUMBERED.count(right) == 1
    program = NUMBERED.replace("R1>2", "1>2")
    message, _marked, made = look(inspector, tmp_path / "a.mpf", program.replace(right, wrong), SETUP)
    assert said in message
    assert (program, is_sure) in [made_text[1:] for made_text in made.values()]


def test_a_jump_does_not_end_at_a_longer_label(inspector: Inspector, tmp_path: Path) -> None:
    text = NUMBERED.replace("NEXT:", "MYNEXT:").replace("R1>2", "1<2")
    message, _marked, _made = look(inspector, tmp_path / "a.mpf", text, SETUP)
    assert message == "GOTOF NEXT: there is no such label or block number after this line"
