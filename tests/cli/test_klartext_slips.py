"""Slips of typing in a Klartext program: one finding names each, and an edit gives the program back."""

import re
from pathlib import Path

import pytest

pytest.importorskip("pygls", reason="needs the extra lsp")

from tests.cli.test_quick_fixes import NEVER, apply_places, check, inspector, look
from verne_post.cli.lsp.fixes import find_fixes
from verne_post.cli.lsp.inspector import Inspector

__all__ = ["inspector"]

SETUP = "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 80, diameter = 6 }\n"
PROGRAM = """0 BEGIN PGM T MM
1 BLK FORM 0.1 Z X-40 Y-30 Z-20
2 BLK FORM 0.2 X+40 Y+30 Z+0
3 TOOL CALL 1 Z S8000 F1200
4 FN 0: Q1 = +5
5 L X-30 Y-20 Z+20 A+0 C+0 R0 FMAX M3
6 LBL 1
7 L X+20.25 F600
8 L IY+2 X+30.5
9 CALL LBL 1 REP 2
10 PLANE SPATIAL SPA+20 SPB+0 SPC+0 STAY
11 PLANE RESET STAY
12 CYCL DEF 200 DRILLING ~
    Q200=+2 ~
    Q201=-5 ~
    Q206=+250 ~
    Q202=+3 ~
    Q210=+0 ~
    Q203=+0 ~
    Q204=+10 ~
    Q211=+0.2
13 L X+Q1 FMAX M99
14 CYCL DEF 7.0 DATUM SHIFT
15 CYCL DEF 7.1 X+1
15 CYCL DEF 7.2 Y+0
16 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
17 L X+5 Y+5 Z+30 A-5 FMAX
18 L X+6 Y+2.5 Z+30 A-6 F500
19 M129
20 L Z+60 A+0 R0 FMAX
21 M30
22 END PGM T MM
"""


def test_the_program_without_a_slip_has_no_finding(inspector: Inspector, tmp_path: Path) -> None:
    found = check(inspector, tmp_path / "a.h", PROGRAM, SETUP)
    assert [one.message for one in found.findings if one.severity != "note"] == []


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("0.1 Z X", "0.1 Z20 X", "Z20: no axis of the tool"),
        ("0.1 Z X", "0.1 X", "the axis of the tool is missing"),
        ("0.1 Z X", "0.2 Z X", "write 0.1"),
        ("0.1 Z X", "0 1 Z X", "write BLK FORM 0.1"),
        ("0.2 X", "0.1 X", "write 0.2"),
        ("X-40 Y-30", "X-40 -30", "write Y-30"),
        ("BLK FORM 0.2", "FORM 0.2", "write BLK FORM 0.2"),
        ("TOOL CALL 1 Z", "TOOL 1 Z", "write TOOL CALL 1"),
        ("TOOL CALL 1 Z", "TOOL CALL 1Z", "write 1 Z"),
        ("S8000 F1200", "8000 F1200", "write S8000"),
        ("S8000 F1200", "S8000 1200", "write S8000 F1200 or S80001200"),
        ("FN 0: Q1", "FN O: Q1", "write FN 0: Q1"),
        ("FN 0: Q1", "FM 0: Q1", "did you mean FN?"),
        ("Q1 = +5", "Q1 +5", "expected =, found +5"),
        ("C+0 R0 FMAX", "C+0 R 0 FMAX", "did you mean R0?"),
        ("FMAX M3", "FMAX ,3", "M3 may be meant"),
        ("Y-20 Z+20", "-20 Z+20", "write Y-20"),
        ("6 LBL 1", "6 LABEL 1", "did you mean LBL?"),
        ("6 LBL 1", "6 LBL", "write LBL 1"),
        ("CALL LBL 1 REP", "CALL 1 REP", "write CALL LBL 1"),
        ("CALL LBL 1 REP", "CALL LBL REP", "write CALL LBL 1"),
        ("CALL LBL 1 REP", "LBL 1 REP", "a label has no REP"),
        ("L IY+2", "LI Y+2", "LI Y+2: the blank is at a wrong place; did you mean L IY+2?"),
        ("18 L X", "1 8L X", "1 8L: the blank is at a wrong place; did you mean 18 L?"),
        ("    Q203=", "    2Q03=", "2Q03: no parameter; did you mean Q203?"),
        ("    Q203=", "    1203=", "1203: no parameter; did you mean Q203?"),
        ("CYCL DEF 200", "CYCL DEF 2 00", "2 00: a blank is in the number; did you mean 200?"),
        ("21 M30", "21 ME0", "write M30 if the M function is meant"),
        ("19 M129", "19 J129", "write M129 if the M function is meant"),
        ("FN 0: Q1", "FN 0; Q1", "write FN 0: and the assignment"),
        ("SPA+20", "SPA=20", "write SPA+20 or SPA-20"),
        ("SPA+20", "SP+20", "did you mean SPA?"),
        ("CYCL DEF 200", "CYCL DEF 20", "did you mean 200?"),
        ("CYCL DEF 7.2", "DEF 7.2", "write CYCL DEF 7.2"),
        ("FUNCTION TCPM F", "TCPM F", "write FUNCTION TCPM F"),
        ("TCPM", "TCMP", "did you mean TCPM?"),
        ("21 M30", "21 30", "as in M30"),
    ],
)
def test_an_edit_gives_the_program_back(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str
) -> None:
    path = tmp_path / "a.h"
    message, _word, made = look(inspector, path, PROGRAM.replace(right, wrong, 1), SETUP)
    assert said in message
    assert PROGRAM in [text for file, text, _settles in made.values() if file == path]
    assert [text for _file, text, settles in made.values() if settles and text != PROGRAM] == []


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("    Q203=+0 ~\n", "", "CYCL DEF 200 needs Q203, the surface"),
        ("Q204=+10 ~\n    Q211=+0.2\n", "Q204=+10 ~\n", "write Q211, the dwell below or Q395"),
        ("16 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS", "16 M12", "M12: no meaning in this language"),
        ("9 CALL LBL", "9 M28\n9 TOOL CALL S8000\n9 CALL LBL", "M28: no meaning in this language"),
        ("1 REP 2", "1 REP", "REP needs the number of repeats"),
        ("TOOL CALL 1 Z", "TOOL CALL Z", "write TOOL CALL 1 Z S with its speed before it"),
        ("18 L X+6 Y+2.5 Z", "18 L X+6 Y-=2.5 Z", "Y-=2.5"),
    ],
)
def test_what_no_edit_settles_is_one_finding(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str
) -> None:
    message, _word, _made = look(inspector, tmp_path / "a.h", PROGRAM.replace(right, wrong, 1), SETUP)
    assert said in message


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("CALL LBL 5", "LBL 5", "LBL 5 appears twice, first in line 29; write CALL LBL 5"),
        ("CALL LBL 5", "CALL LBL", "write CALL LBL 5"),
        ("23 LBL 5", "23 LBL", "write LBL 5"),
        ("25 LBL 0", "25 LBL", "write LBL 0"),
    ],
)
def test_the_lost_word_of_a_subprogram_is_written(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str
) -> None:
    path = tmp_path / "a.h"
    program = PROGRAM.replace("19 M129\n", "19 CALL LBL 5\n", 1)
    program = program.replace("22 END", "23 LBL 5\n24 M129\n25 LBL 0\n26 END")
    found = check(inspector, path, program, SETUP)
    assert [one.message for one in found.findings if one.severity != "note"] == []
    message, _word, made = look(inspector, path, program.replace(right, wrong, 1), SETUP)
    assert said in message
    assert program in [text for file, text, _settles in made.values() if file == path]


@pytest.mark.parametrize("point", [".", ","])
def test_a_lost_point_is_put_back_where_the_place_is_between_its_neighbours(
    inspector: Inspector, tmp_path: Path, point: str
) -> None:
    """Klartext may have commas for the points of a program."""
    right = re.sub(r"(?<=[XYZ][+-])(\d+)\.(?=\d)", rf"\1{point}", PROGRAM)
    path, text = tmp_path / "a.h", right.replace(f"X+20{point}25", "X+2025", 1)
    found = check(inspector, path, text, SETUP)
    first = next(one for one in found.findings if one.severity == "error")
    assert f"X20{point}25 may be meant in line 8, its point is missing" in first.remedies[0]
    (fix, *_others) = find_fixes(inspector, found, first, {path: text}, NEVER)
    assert (apply_places(fix), fix.settles) == (right, False)


def test_m136_is_named_where_f_is_no_feed_of_a_turn(inspector: Inspector, tmp_path: Path) -> None:
    text = PROGRAM.replace("6 LBL 1", "6 M136\n6 LBL 1", 1).replace("FMAX M99", "FMAX", 1)
    found = check(inspector, tmp_path / "a.h", text, SETUP)
    (said,) = (one.message for one in found.findings if one.code == "VP505")
    assert "M136 of line 7 is active: if mm/min were meant, write M137 in its place" in said


@pytest.mark.parametrize("number", ["", "18 ", "/18 "])
@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("L", "Z+2 R0 FMAX"),
        ("L", "Z+100 R0 FMAX M3"),
        ("L", "Y-10 R0 FMAX M99"),
        ("L", "IZ+2 R0 FMAX"),
        ("L", "X+Q1 R0"),
        ("L", "X+Q1 Y-Q1 FMAX"),
        ("L", "A+0 C+0 R0 FMAX"),
        ("LP", "PR+5 R0"),
        ("LP", "IPA+30 PR+5 R0 F500"),
        ("CP", "IPA+30 DR+ R0"),
        ("CR", "X+5 Y+5 R+10 DR-"),
        ("LN", "X+1 Y+1 Z+30 NX+0 NY+0 NZ+1"),
    ],
)
def test_a_lost_path_function_is_put_before_its_coordinates(
    inspector: Inspector, tmp_path: Path, number: str, path: str, words: str
) -> None:
    """Z+2 R0 was read as R0 Z+2 in the wrong order, and R0 told to have no Z."""
    file = tmp_path / "a.h"
    right = PROGRAM.replace("19 M129\n", f"19 M129\n20 CC X+0 Y+0\n{number}{path} {words}\n", 1)
    message, _word, made = look(inspector, file, right.replace(f"{path} {words}", words, 1), SETUP)
    first = words.split()[0]
    assert message == f"{first}: coordinates without a path function before them; write {path} {first}"
    assert right in [text for _file, text, _settles in made.values()]


@pytest.mark.parametrize("words", ["Z+2 RL", "X+0 RR F200", "Z+22 STOP"])
def test_coordinates_are_not_of_the_word_behind_them(inspector: Inspector, tmp_path: Path, words: str) -> None:
    program = PROGRAM.replace("19 M129\n", f"19 M129\n20 {words}\n", 1)
    assert look(inspector, tmp_path / "a.h", program, SETUP)[0].endswith(f"; write L {words.split()[0]}")


def test_a_path_function_behind_its_coordinate_is_in_the_wrong_order(inspector: Inspector, tmp_path: Path) -> None:
    right = PROGRAM.replace("19 M129\n", "19 M129\n20 CC X+0 Y+0\n20 LP PR+5 PA+30 R0\n", 1)
    file = tmp_path / "a.h"
    message, _word, made = look(inspector, file, right.replace("LP PR+5", "PR+5 LP", 1), SETUP)
    assert message == "PR+5 LP: two words in the wrong order; did you mean LP PR+5?"
    assert right in [text for _file, text, _settles in made.values()]
