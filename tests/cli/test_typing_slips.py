"""Edits of an editor for words, numbers and characters that are mistyped or pasted."""

from pathlib import Path

import pytest

pytest.importorskip("pygls", reason="needs the extra lsp")

from tests.cli.test_quick_fixes import HEADS, inspector, look
from verne_post.cli.lsp.inspector import Inspector

__all__ = ["inspector"]

DRILLING = "CYCL DEF 200 DRILLING ~\n Q200=2 ~\n Q201=-1 ~\n Q206=9 ~\n Q202=5 ~\n Q210=0 ~\n {} ~\n Q211=0"
LOOP = "R1=3\n{}\nR1=R1-1\n{}"


def embed(ending: str, lines: str) -> str:
    """A program with these lines."""
    return f"{lines}\n".join(HEADS[ending])


@pytest.mark.parametrize(
    ("ending", "wrong", "right", "said", "title"),
    [
        (
            ".h",
            DRILLING.format("Q203=+O     Q204=+3"),
            ("+O", "+0"),
            "the letter O",
            "Write Q203=+0 in place of Q203=+O",
        ),
        (".h", "PLANE SPATIAL SPA+0 SPB+0 SPC+0 TURM FMAX", ("TURM", "TURN"), "", "Write TURN in place of TURM"),
        (".h", "CYCL DEF 7.0 N\nCYCL DEF 7,1 X+5", ("7,1", "7.1"), "a decimal comma", "Write 7.1 in place of 7,1"),
        (
            ".h",
            "PLANE SPATIAL SPA=25 SPB+0 SPC+0 STAY",
            ("SPA=", "SPA+"),
            "have no =",
            "Write SPA+25 in place of SPA=25",
        ),
        (".h", "L X=-2", ("X=", "X"), "have no =", "Write X-2 in place of X=-2"),
        (
            ".h",
            "CALL LBL 1\nM30\nLBL1\nL X+5\nLBL 0\nLBL 10\nL X+6\nLBL 0",
            ("LBL1\n", "LBL 1\n"),
            "a blank is missing",
            "Write LBL 1 in place of LBL1",
        ),
        (".mpf", "FOR PASS = 1 TO4\nX3\nENDFOR", ("TO4", "TO 4"), "a blank is missing", "Write TO 4 in place of TO4"),
        (".mpf", "FRO PASS = 1 TO 4\nX3\nENDFOR", ("FRO", "FOR"), "", "Write FOR in place of FRO"),
        (".mpf", LOOP.format("WHIEL R1 > 1", "ENDWHILE"), ("WHIEL", "WHILE"), "", "Write WHILE in place of WHIEL"),
        (".mpf", LOOP.format("WHILE R1 > 1 DO", "ENDWHILE"), ("DO", ""), "has none", "Take DO out"),
        (".mpf", "GOTOF DONE\nX5\nDONE\nX3", ("\nDONE", "\nDONE:"), "with a colon", "Write DONE: in place of DONE"),
        (
            ".mpf",
            LOOP.format("TOP", "IF R1>1 GOTOB TOP"),
            ("TOP", "TOP:"),
            "with a colon",
            "Write TOP: in place of TOP",
        ),
    ],
)
def test_a_slip_has_one_finding_and_its_edit(
    inspector: Inspector, tmp_path: Path, ending: str, wrong: str, right: tuple[str, str], said: str, title: str
) -> None:
    text = embed(ending, wrong)
    message, _word, made = look(inspector, tmp_path / f"a{ending}", text)
    assert said in message
    assert made[title] == (tmp_path / f"a{ending}", text.replace(wrong, wrong.replace(*right, 1)), True)


def test_a_jump_in_the_wrong_direction(inspector: Inspector, tmp_path: Path) -> None:
    """That the label stands there does not say that the program means it so."""
    text = embed(".mpf", "GOTOB DONE\nX5\nDONE:\nX3")
    message, word, made = look(inspector, tmp_path / "a.mpf", text)
    assert "GOTOB DONE: the label is after this line, in line 8; write GOTOF" in message
    assert word == "GOTOB"
    assert made["Write GOTOF in place of GOTOB"][1:] == (text.replace("GOTOB", "GOTOF"), False)


@pytest.mark.parametrize(
    ("line", "said", "word"),
    [
        ("L X+5 FAUT0", "FAUT0: no meaning in this language; did you mean FAUTO?", "FAUT0"),
        ("L X+5 F AUT0", "AUT0: no meaning in this language; did you mean AUTO?", "AUT0"),
    ],
)
def test_a_misspelt_feed_rate_of_klartext(
    inspector: Inspector, tmp_path: Path, line: str, said: str, word: str
) -> None:
    text = embed(".h", line).replace("Z S1000", "Z S1000 F900")
    message, underlined, made = look(inspector, tmp_path / "a.h", text)
    assert (message, underlined) == (said, word)
    assert any(fixed == text.replace("AUT0", "AUTO") for _path, fixed, _settles in made.values())


def test_a_loop_that_is_not_closed_is_marked_at_its_word(inspector: Inspector, tmp_path: Path) -> None:
    text = embed(".mpf", "R1=3\nN70 WHILE R1 > 1\nR1=R1-1")
    assert look(inspector, tmp_path / "a.mpf", text)[1] == "WHILE"


def test_a_subprogram_that_is_nearly_that_of_a_file(inspector: Inspector, tmp_path: Path) -> None:
    """The file is read too, so that nothing else is said of the call."""
    (tmp_path / "SLOT.SPF").write_text("PROC SLOT(REAL A)\nG1 X=A\nRET\n")
    text = embed(".mpf", "SLOTT(3)")
    message, _word, made = look(inspector, tmp_path / "a.mpf", text)
    assert message == "SLOTT: no meaning in this language; did you mean SLOT?"
    assert made["Write SLOT in place of SLOTT"][1:] == (text.replace("SLOTT", "SLOT"), True)


@pytest.mark.parametrize(
    ("ending", "lines", "said"),
    [
        (
            ".ngc",
            "X5\u00a0Y6\u00a0Z49\nX7\u00a0Y8",
            "a no-break space (U+00A0), as mail and PDF have it; write a blank",
        ),
        (".mpf", "X5\u00a0Y6\nX7\u00a0Y8", "a no-break space (U+00A0), as mail and PDF have it; write a blank"),
        (".h", "L X+5\u00a0Y+6\nL X+7\u00a0Y+8", "a no-break space (U+00A0), as mail and PDF have it; write a blank"),
        (".ngc", "X5 Y\u20136\nX\u20137", "an en dash (U+2013), as mail and PDF have it; write a minus (-)"),
        (".mpf", "X5 Y\u20136\nX=\u20137", "an en dash (U+2013), as mail and PDF have it; write a minus (-)"),
        (".h", "L X+5 Y\u22126\nL X\u22127", "a minus sign (U+2212), as mail and PDF have it; write a minus (-)"),
        (
            ".mpf",
            "MSG(\u201ca\u201d)\nMSG(\u201cb\u201d)",
            'a left double quotation mark (U+201C), as mail and PDF have it; write a straight quote (")',
        ),
    ],
)
def test_characters_of_mail_and_pdf(inspector: Inspector, tmp_path: Path, ending: str, lines: str, said: str) -> None:
    """One finding, an edit of its line, and one of all lines; remarks stay as they are."""
    marks = str.maketrans("\u00a0\u2013\u2212\u201c\u201d", ' --""')
    remark = "(a \u2013 b)" if ending == ".ngc" else "; a \u2013 b"
    first, second = lines.split("\n")
    text = embed(ending, f"{first} {remark}\n{second}")
    message, _word, made = look(inspector, tmp_path / f"a{ending}", text)
    assert message == said
    files = [fixed for _path, fixed, _settles in made.values()]
    assert files == [
        embed(ending, f"{first.translate(marks)} {remark}\n{second}"),
        embed(ending, f"{first.translate(marks)} {remark}\n{second.translate(marks)}"),
    ]
