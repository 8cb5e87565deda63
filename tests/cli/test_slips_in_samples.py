"""Mistakes in the samples of the repository: where they are found, and the edits that an editor has for them."""

from pathlib import Path

import pytest

pytest.importorskip("pygls", reason="needs the extra lsp")

from tests.cli.test_quick_fixes import NEVER, check, inspector, look
from verne_post.cli.lsp.fixes import find_fixes
from verne_post.cli.lsp.inspector import Inspector

__all__ = ["inspector"]

SAMPLES = Path(__file__).parents[2] / "gcode_samples"


def read_sample(name: str, wrong: str, right: str) -> tuple[str, str]:
    """A sample with a mistake, and its set-up; ``right`` is what the sample has."""
    text = (SAMPLES / name).read_text("utf-8")
    assert right in text
    return text.replace(right, wrong), (SAMPLES / f"{name}.toml").read_text("utf-8")


@pytest.mark.parametrize(
    ("name", "right", "wrong", "said", "word", "title"),
    [
        ("two_faces.mpf", "DEPTH = DEPTH - 1.5", "DEPTH 8.5", "DEPTH is a variable (DEF); an = is missing", "DEPTH",
         "Write DEPTH=8.5 in place of DEPTH 8.5"),
        ("two_faces.mpf", "N100 Z12\n", "N100 Z=AC 12\n", "write Z=AC(12)", "AC", "Write AC(12) in place of AC 12"),
        ("two_faces.mpf", "N100 Z12\n", "N100 A=DC 0\n", "write A=DC(0)", "DC", "Write DC(0) in place of DC 0"),
        ("two_faces.mpf", "N100 Z12\n", "MSG(GROOVE)\nN100 Z12\n", 'did you mean MSG("GROOVE")?', "GROOVE",
         'Write "GROOVE" in place of GROOVE'),
        ("two_faces.mpf", '"END_MILL_6"', "'END_MILL_6'", 'write "END_MILL_6"', "'",
         "Write \"END_MILL_6\" in place of 'END_MILL_6'"),
        ("two_faces.mpf", "PROC FACE", "FACE", "PROC is missing before the name", "FACE",
         "Write PROC FACE in place of FACE"),
        ("two_faces.mpf", "PROC FACE", "PRC FACE", "did you mean PROC?", "PRC", "Write PROC in place of PRC"),
        ("two_faces.mpf", "PROC FACE", "PROCFACE", "a blank is missing", "PROCFACE",
         "Write PROC FACE in place of PROCFACE"),
        ("two_faces.mpf", "%_N_FACE_SPF", "%_N_FCE_SPF", "the PROC line below it begins FACE", "%_N_FCE_SPF",
         "Write %_N_FACE_SPF in place of %_N_FCE_SPF"),
        ("two_faces.mpf", "%_N_FACE_SPF", "%_N_FACE_SFP", "no program begins with this line", "%_N_FACE_SFP",
         "Write %_N_FACE_SPF in place of %_N_FACE_SFP"),
        ("two_faces.mpf", "%_N_FACE_SPF\n", "", "no subprogram begins here without the line %_N_FACE_SPF", "PROC",
         "Write %_N_FACE_SPF before line 49"),
        ("two_faces.h", "BEGIN PGM TWO_FACES MM", "BEGIN PGM TWO_FACES M", "the unit of BEGIN PGM is MM or INCH", "M",
         "Write MM in place of M"),
        ("two_faces_fanuc.nc", "O1302 (", "O1301 (", "O1301 appears twice, in lines 40 and 47", "P1302",
         "Write O1302 in place of O1301 in line 47"),
        ("two_faces.cls", "FEDRAT/1200, MMPM", "FEDRAT/1200, MMPR", "write MMPM", "MMPR",
         "Write MMPM in place of MMPR"),
    ],
)  # fmt: skip
def test_a_slip_is_named_where_it_is_and_its_edit_settles_it(
    inspector: Inspector, tmp_path: Path, name: str, right: str, wrong: str, said: str, word: str, title: str
) -> None:
    text, setup = read_sample(name, wrong, right)
    message, marked, made = look(inspector, tmp_path / name, text, setup)
    assert said in message
    assert marked.startswith(word)
    assert "P1300" not in str(made.keys())
    assert title in made
    assert [one for one in check(inspector, tmp_path / name, made[title][1], setup).findings if one.line] == []


@pytest.mark.parametrize(
    "wrong",
    [
        *(f"{begin}TWO_FACES_MPF" for begin in ("5_N_", "_N_", "%%_N_")),
        *(f"%_N_TWO_FACES{end}" for end in ("_MFP", "MPF", "_NPF", "_MPFF", "_MMPF", "_MP", "_PF")),
    ],
)
def test_a_slip_in_the_first_line_is_one_finding(inspector: Inspector, tmp_path: Path, wrong: str) -> None:
    right = "%_N_TWO_FACES_MPF"
    text, setup = read_sample("two_faces.mpf", wrong, right)
    message, marked, made = look(inspector, tmp_path / "a.nc", text, setup)
    assert (message, marked) == (f"{wrong}: no program begins with this line; did you mean {right}?", wrong)
    assert made[f"Write {right} in place of {wrong}"][1:] == (text.replace(wrong, right), True)


@pytest.mark.parametrize(
    ("name", "right", "wrong", "code", "line", "said"),
    [
        ("two_faces.mpf", "N180 CYCLE800()\n", "", "VP043", 37, "the plane of CYCLE800 in line 32"),
        ("two_faces_fanuc.nc", "%\nO1300", "5\nO1300", "VP001", 1, "a program that ends with % begins with one"),
        ("two_faces_fanuc.nc", "N200 G69\n", "", "VP043", 30, "the plane of G68.2 in line 25"),
        ("two_faces.h", "49 M129\n", "", "", 0, ""),
        ("two_faces.h", "38 PLANE RESET MOVE DIST0 FMAX\n", "", "VP017", 58,
         "PLANE RESET where it is over, before line"),
        ("two_faces.mpf", "FOR PASS = 1 TO 4", "FOR PASS = 4 TO 1", "VP051", 18, "its lines are not executed"),
        ("two_faces.mpf", "BOTTOM,,0.3", "BOTTOM,,300", "VP505", 53, "a dwell of 300 s"),
        ("two_faces.h", "Q211=+0,3", "Q211=+300", "VP505", 65, "a dwell of 300 s"),
        ("two_faces.mpf", "N100 Z12\n", "N100 Z12 G4 F0.5\n", "VP003", 17, "write G4 in a separate line"),
        ("two_faces.h", "12 Q1 = 10\n", "12 Q1 = 10\n12 FN 9: IF +Q5 EQU +0 GOTO LBL 1\n", "VP025", 14,
         "Q5 has no value"),
    ],
)  # fmt: skip
def test_a_mistake_has_one_finding_at_its_line(
    inspector: Inspector, tmp_path: Path, name: str, right: str, wrong: str, code: str, line: int, said: str
) -> None:
    text, setup = read_sample(name, wrong, right)
    told = [one for one in check(inspector, tmp_path / name, text, setup).findings if one.severity != "note"]
    assert [(one.code, one.line) for one in told] == ([(code, line)] if code else [])
    assert all(said in one.message for one in told)
    if code == "VP025":
        assert text.split("\n")[line - 1][(told[0].column or 0) - 1 :].startswith("Q5")


def test_a_plane_is_reset_before_what_follows_it(inspector: Inspector, tmp_path: Path) -> None:
    """The edit stood before the last motion, so that the pass before it stayed in the old plane."""
    path = tmp_path / "two_faces.h"
    text, setup = read_sample("two_faces.h", "", "38 PLANE RESET MOVE DIST0 FMAX\n")
    found = check(inspector, path, text, setup)
    item = next(one for one in found.findings if one.code == "VP017")
    made = [
        f"{text[: fix.begin]}{fix.new}{text[fix.end :]}"
        for fix in find_fixes(inspector, found, item, {path: text}, NEVER)
    ]
    assert made == [text.replace("41 M128\n", "PLANE RESET STAY\n41 M128\n")]


def test_all_places_of_a_word_are_edits_of_the_word(inspector: Inspector, tmp_path: Path) -> None:
    path = tmp_path / "two_faces.mpf"
    text, setup = read_sample("two_faces.mpf", "FCAE(30", "FACE(30")
    found = check(inspector, path, text, setup)
    item = next(one for one in found.findings if one.severity == "error")
    fixes = find_fixes(inspector, found, item, {path: text}, NEVER)
    words = next(fix.list_edits() for fix in fixes if "in all 2 places" in fix.title)
    assert [(text[begin:end], new) for begin, end, new in words] == [("FCAE", "FACE")] * 2
