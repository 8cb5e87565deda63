"""A program that is in inches by mistake: the cause is said first, because the same program in mm was tried."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

PLACE = ("--tool-length", "80", "--wcs", "G54=0,0,0")
#: Name -> text with places for the unit and for X; the words for inch and mm; where the former stands.
PROGRAMS = {
    "p.ngc": ("(G20)\nG90 G94 {}\nG0 X0 Y0 Z60 A0 C0\nG1 X{} Z50 F600\nG0 Z80\nM2\n", "G20", "G21", 2, 9),
    "p.nc": (
        "%\nO1\nG90 G94 {}\nG43.4 H1\nG0 X0. Y0. Z60. A0. C0.\nG1 X{}. Z50. F600.\nM30\n%\n",
        *("G20", "G21", 3, 9),
    ),
    "p.mpf": ("G90 G94 {} ; G71\nG0 X0 Y0 Z60 A0 C0\nG1 X{} Z50 F600\nM30\n", "G70", "G71", 1, 9),
    "p.h": (
        "BEGIN PGM INCH {}\nTOOL CALL 1 Z S900\nL X0 Y0 Z60 A0 C0 R0 FMAX M3\nL X{} Z50 F600\nEND PGM INCH {}\n",
        *("INCH", "MM", 1, 16),
    ),
    "p.apt": (
        "PARTNO INCHES\nUNITS/{}\nLOADTL/1\nSPINDL/900,CLW\nFEDRAT/600,MMPM\nGOTO/0,0,60,0,0,1\nGOTO/{},0,50\nFINI\n",
        *("INCHES", "MM", 2, 7),
    ),
}


def check(run: Callable[..., Any], tmp_path: Path, name: str, unit: str, end: int) -> tuple[list[str], str]:
    """The lines of the findings of a program in a unit that goes to X ``end``, without its name; and the whole text."""
    path = tmp_path / name
    words = (unit, end, unit) if name == "p.h" else (unit, end)
    path.write_text(PROGRAMS[name][0].format(*words))
    answer = run("check", path, *PLACE)
    head = f"{path}:"
    lines = [line.removeprefix(head) for line in answer.out.splitlines() if line.startswith(head)]
    return [line for line in lines if ": VP" in line], answer.out


@pytest.mark.parametrize("name", PROGRAMS)
def test_inches_in_place_of_mm_are_named_first(run: Callable[..., Any], tmp_path: Path, name: str) -> None:
    _text, inch, mm, line, column = PROGRAMS[name]
    found, _out = check(run, tmp_path, name, mm, 30)
    assert not [one for one in found if "error" in one or "VP505" in one]
    found, text = check(run, tmp_path, name, inch, 30)
    rows = PROGRAMS[name][0].splitlines()
    first = next(number for number, row in enumerate(rows, 1) if "50" in row and "{}" in row)  # where it leaves
    said = f"{inch}: read in inches, the program spans 762 mm and leaves the machine, first in line {first}; read in "
    assert found[0] == f"{line}:{column}: VP505 error: {said}mm, no pose of it is refused; did you mean {mm}?"
    assert not [one for one in found if ": VP1" in one or ": VP2" in one]  # they follow from the unit
    assert "refused: 1 error" in text


@pytest.mark.parametrize(
    ("end", "z", "said"),
    [
        (
            *(30, -2),
            "the tip goes below the table face, and no more is refused; did you mean G21, and a higher work offset?",
        ),
        (1, -1, ""),  # a small part in inches, and only its place is wrong
        (30, 50, "no pose of it is refused; did you mean G21?"),
    ],
)
def test_inches_in_place_of_mm_are_named_where_the_part_is_too_low_too(
    run: Callable[..., Any], tmp_path: Path, end: int, z: int, said: str
) -> None:
    """In mm the tip went below the table face; the finding was VP110 with no place that helps."""
    path = tmp_path / "p.ngc"
    path.write_text(f"G90 G94 G20\nG0 X-{end} Y0 Z5 A0 C0\nG1 X{end} Z{z} F600\nG0 Z5\nM2\n")
    out = run("check", path, *PLACE).out
    assert (f"read in mm, {said}" in out) == bool(said)
    assert ("VP505 error" in out) == bool(said)


def test_a_feed_rate_without_a_unit_names_the_lines_that_differ(run: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "p.apt"
    path.write_text(
        "PARTNO A\nUNITS/INCHES\nLOADTL/1\nSPINDL/900,CLW\nFEDRAT/600,MMPM\nGOTO/0,0,3\nFEDRAT/9\nGOTO/1,0,3\nFINI\n"
    )
    said = "FEDRAT without a unit, after MMPM of line 5, in a program in inches (UNITS/INCHES of line 2): CAM systems"
    assert f":7: VP005 error: {said}" in run("check", path, *PLACE).out


def test_g700_is_named_as_g70_is(run: Callable[..., Any], tmp_path: Path) -> None:
    """F counts in inches too; a vector of the tool axis and the name of a tool stand in the program."""
    text = (
        'N10 G40 G17 {} G90 G94\nN20 T="EM10"\nN30 M6\nN40 D1\nN50 S6000 M3\nN60 G54\nN80 TRAORI\n'
        "N90 G0 X0 Y0 Z60 A3=0 B3=0 C3=1\nN100 G0 Z10\nN110 G1 Z2 F800\nN120 X10 Y2\nN130 X20 Y4\n"
        "N140 G0 Z60\nN150 TRAFOOF\nN160 M30\n"
    )
    path = tmp_path / "p.mpf"
    path.with_suffix(".mpf.toml").write_text("[tools.EM10]\nlength = 120\n[wcs]\nG54 = [0, 0, 40]\n")
    path.write_text(text.format("G710"))
    assert run("check", path).code == 0
    path.write_text(text.format("G700"))
    answer = run("check", path)
    assert ":1:13: VP505 error: G700: read in inches, the program spans 1473 mm" in answer.out
    assert "did you mean G710?" in answer.out
    assert "refused: 1 error, 0 warnings" in answer.out
    assert ": VP101" not in answer.out
    assert ": VP210" not in answer.out


def test_a_program_in_inches_that_only_stands_in_a_wrong_place(run: Callable[..., Any], tmp_path: Path) -> None:
    """In mm it would fit too; but it fits as it is, a little higher, and that is what is proposed."""
    path = tmp_path / "p.ngc"
    path.write_text("G20 G90 G94\nG0 X0 Y0 Z3 A0 C0\nG1 X1 Z-5 F60\nM2\n")
    answer = run("check", path, *PLACE)
    assert "VP505" not in answer.out
    assert "within limits if the part is moved by 0, 0, 127.1 mm" in answer.out


def test_a_program_that_fits_in_neither_unit(run: Callable[..., Any], tmp_path: Path) -> None:
    found, text = check(run, tmp_path, "p.ngc", "G20", 3000)
    assert not [one for one in found if "VP505" in one]
    assert "no work offset near this one" in text
    answer = run("check", tmp_path / "p.ngc", *PLACE, "--output-format", "json")
    assert '"remedies"' in answer.out
    assert "no work offset near this one" not in answer.out  # which is no remedy


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        (
            "p.nc",
            "G20 G90 G17\nG0 X1 Y1 Z1 A0 C0\nG1 X1.5 F9\nG2 X2.5 Y1 R0.4\nM30\n",
            "p.nc:4:12: VP008 error: the radius 0.4 inch is too small to reach the end point from X1.5 Y1; it takes at "
            "least 0.5 inch",
        ),
        (
            "p.nc",
            "G20 G90 G17\nG0 X1 Y1 Z1 A0 C0\nG1 X1.5 F9\nG2 X2.5 Y1 I0.4\nM30\n",
            "radius 0.4 inch at the start (X1.5 Y1), 0.6 inch at the end, difference 0.2 inch",
        ),
        (
            "p.mpf",
            "G70 G90 G17\nG0 X1 Y1 Z1 A0 C0\nG1 X1.5 F9\nG2 X2.5 Y1 CR=0.4\nM30\n",
            ":4:12: VP008 error: the radius 0.4",
        ),
        ("p.mpf", "G70 G90 G17\nG0 X1 Y1 Z1 A0 C0\nG1 X1.5 F9\nG2 X2.5 Y1 I0.4\nM30\n", "radius 0.4 inch at the start"),
        (
            "p.h",
            "BEGIN PGM A INCH\nL X+1 Y+1 Z+1 A+0 C+0 R0 FMAX\nL X+1.5 F9\nCR X+2.5 Y+1 R0.4 DR-\nEND PGM A INCH\n",
            ":4:14: VP008 error: the radius 0.4 inch is",
        ),
    ],
)
def test_an_arc_that_does_not_fit_is_told_in_the_unit_of_the_program(
    name: str, text: str, said: str, tmp_path: Path, run: Callable[..., Any]
) -> None:
    (tmp_path / name).write_text(text)
    answer = run("check", tmp_path / name, "--tool-length", 80, "--wcs", "G54=0,0,60")
    assert said in answer.out + answer.err


def test_the_unit_is_told_once_and_before_the_stock_is_cut(
    run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A part of INCH was cut out of its stock for minutes; END PGM with the other unit is of the same cause."""
    blank = "BLK FORM 0.1 Z X-20 Y-20 Z+20\nBLK FORM 0.2 X+20 Y+20 Z+40\n"
    circles = "CC X+0 Y+0\n" + "C X+10 Y+0 DR+ F600\n" * 5
    path = tmp_path / "p.h"
    text = (
        "BEGIN PGM P {}\n{}TOOL CALL 1 Z S900\nL X+{end} Y+0 Z+60 A+0 C+0 R0 FMAX M3\n{}L X+10 Z+35 FMAX\nL Z+60\n"
        "END PGM P MM\n"
    )
    path.write_text(text.format("INCH", blank, circles, end=10))
    monkeypatch.setattr("verne_post.app.stock_check.cut_stock", lambda *_given: pytest.fail("the stock was cut"))
    answer = run("check", path, *PLACE, "--stock", "program")
    found = [line for line in answer.out.splitlines() if ": VP" in line]
    assert [line.partition(": ")[2][:19] for line in found] == ["VP505 error: INCH: "]
    # one that fits in neither unit, and is long: what is left undecided is told
    path.write_text(text.format("MM", blank, circles.replace("X+10", "X+2000"), end=2000))
    answer = run("check", path, *PLACE, "--stock", "program", "--machine", "serial")
    assert "VP216 warning: contact with the stock of the program is not computed: line " in answer.out
