"""CALL PGM finds files beside the program, by the name that a control would use; structure is told."""

import re

import pytest


def test_called_programs_come_from_the_folder(run, tmp_path):
    (tmp_path / "main.h").write_text(
        "BEGIN PGM M MM\nL X+1 F100\nCALL PGM TNC:\\jobs\\SIDE.H ; COMMENT\nEND PGM M MM\n"
    )
    (tmp_path / "side.h").write_text("BEGIN PGM S MM\nL Y+7\nEND PGM S MM\n")
    answer = run("dump", "moves", tmp_path / "main.h")
    assert (answer.code, answer.err) == (0, "")
    assert '"end": [1.0, 7.0,' in answer.out
    (tmp_path / "side.h").write_text("BEGIN PGM S MM\nL Y+7 Q\nEND PGM S MM\n")
    assert "main.h:3: VP001 error: side.h, line 2: " in run("dump", "moves", tmp_path / "main.h").err


HOLE = """BEGIN PGM P MM
TOOL CALL 1 Z S8000 F1200
L A+0 C+0 R0 FMAX M3
L X-30 Y-20 Z+40 FMAX
CYCL DEF 200 DRILLING ~
    Q200=+3 ;SET-UP CLEARANCE ~
    Q201=-8 ;DEPTH ~
    Q206=+250 ;FEED RATE ~
    Q202=+9 ;PLUNGING DEPTH ~
    Q210=+0 ;DWELL TIME AT TOP ~
    Q203=+0 ;SURFACE ~
    Q204=+3 ;2ND CLEARANCE
L X+10 Y+10 FMAX M99
CYCL DEF 7.0 DATUM SHIFT
CYCL DEF 7.1 X+1
CYCL DEF 7.2 Y+1
L Z+40 FMAX
M30
END PGM P MM
"""
_DRILLING = "CYCL DEF 200 DRILLING ~\n    Q200=+3 ;SET-UP CLEARANCE ~\n"


@pytest.mark.parametrize(
    ("old", "new", "code", "told"),
    [
        (
            "CYCL DEF 200 DRILLING ~\n",
            "",
            2,
            "5:5: VP005 error: Q200 = ... ~ is a parameter of a cycle",
        ),
        (
            "2ND CLEARANCE",
            "2ND CLEARANCE ~",
            2,
            "12: VP001 error: ~ at its end continues the cycle in line 13",
        ),
        (
            ";DEPTH ~",
            ";DEPTH",
            0,
            "7: VP001 warning: line 7 has no ~ at its end: a control ends CYCL DEF there",
        ),
        (
            "200 DRILLING ~",
            "200 DRILLING",
            0,
            "5: VP001 warning: line 5 has no ~ at its end: a control ends CYCL DEF there",
        ),
        (
            f"{_DRILLING}    Q201=-8 ;DEPTH ~",
            "CYCL DEF 200 DRILLING Q200=+3 ~\n    Q201=-8 ;DEPTH",
            2,
            "5: VP005 error: CYCL DEF 200 needs Q206 (the plunge feed), Q202 (the infeed), Q210 (the dwell above), ",
        ),
        (
            "END PGM P MM\n",
            "",
            0,
            "18: VP010 warning: END PGM is missing, which ends the file on the control; ",
        ),
        (
            "END PGM P",
            "END PGM Q",
            0,
            "19: VP010 warning: END PGM differs from BEGIN PGM in line 1; write END PGM P MM",
        ),
        (
            "END PGM P MM",
            "END PGM P INCH",
            0,
            "19: VP010 warning: END PGM differs from BEGIN PGM in line 1; BEGIN has MM and END "
            "has INCH; write in both the unit of the numbers",
        ),
        ("BEGIN PGM P MM\n", "", 0, "1: VP010 warning: BEGIN PGM is missing, and lengths are taken as mm; "),
        ("CYCL DEF 7.0 DATUM SHIFT\n", "", 0, "14:10: VP005 warning: CYCL DEF 7.0, which names the cycle"),
        ("~", "", 0, ""),  # older files have none
        ("END PGM P MM", "99 end pgm p mm ; END", 0, ""),
        ("END PGM P MM", "END PGM P", 0, ""),
        ("BEGIN PGM P MM", "; HEAD\n\n0 BEGIN PGM P MM", 0, ""),
        ("CYCL DEF 7.1", "; SHIFT\nCYCL DEF 7.1", 0, ""),
    ],
)
def test_a_mistake_of_structure_is_one_finding_that_says_what_is_right(run, tmp_path, old, new, code, told):
    """Of these some were silent, and others told something of the line after."""
    program = tmp_path / "p.h"
    (tmp_path / "p.h.toml").write_text("[tools]\n1 = {length = 80}\n[wcs]\nG54 = [0, 0, 40]\n")
    program.write_text(HOLE)
    whole = run("check", program)
    assert (whole.code, "VP" in whole.out) == (0, False), whole.out
    assert old in HOLE
    program.write_text(HOLE.replace(old, new))
    answer = run("check", program, "--dialect", "heidenhain")
    findings = [line for line in answer.out.splitlines() if ": VP" in line]
    assert (answer.code, len(findings)) == (code, 1 if told else 0), answer.out
    if told:
        assert findings[0].startswith(f"{program}:{told}")
    if code == 0:  # it is executed as it is meant
        assert re.findall(r", ([\d.]+ s)$", answer.out, re.MULTILINE) == re.findall(
            r", ([\d.]+ s)$", whole.out, re.MULTILINE
        )
