"""Edits of slips in blocks of letters and numbers give the program back that was meant."""

from pathlib import Path

import pytest

import verne_post as vp

pytest.importorskip("pygls", reason="needs the extra lsp")

from tests.cli.test_quick_fixes import NEVER, SETUP, check, inspector, look
from verne_post.cli.lsp.fixes import find_fixes
from verne_post.cli.lsp.inspector import Inspector
from verne_post.cli.lsp.outline import Outline

__all__ = ["inspector"]

FANUC = """%
O1300 (FACES)
N30 G21 G17 G90 G40 G94
#101=10.
G54 G0 X0. Y0. Z50. A0. C0.
M3 S1000
M98 P1302
M98 P21302
M98 P1303
G01 Z#101 F500.
M30
O1302 (HOLES)
N30 G01 X5. F600.
X0.
M99
O1303 (LINE)
N30 G01 Y5. F600.
Y0.
M99
%
"""
RS274 = """#<_tilt> = 5
#<top> = 20
o<place> sub
  G0 Z20
  G1 X[#1 + #<_tilt>] Y#<_tilt> F500
o<place> endsub
o200 sub
  G1 Y2 F500
o200 endsub
G21 G17 G90 G94 G54
G0 X0 Y0 Z50 A0 C0
M3 S1000
o<place> call [3]
o<place> call [4]
o210 repeat [2]
  o200 call
o210 endrepeat
G0 Z#<top>
M2
"""


@pytest.mark.parametrize(
    ("name", "right", "wrong", "said"),
    [
        *(
            ("a.nc", "O1302 (", f"{wrong} (", "write O1302 there")
            for wrong in ("1302", "01302", "I1302", "P1302", "1O302")
        ),
        *(("a.nc", "O1302 (", f"{wrong} (", "in line 12, and which nothing calls") for wrong in ("O1392", "O132")),
        ("a.nc", "O1300 (", "I1300 (", "did you mean O1300?"),
        ("a.nc", "M98 P1302", "M89 P1302", "M98, which calls P may be meant"),
        ("a.nc", "M98 P1302", "M9 P1302", "M98 may be meant by M9"),
        ("a.nc", "M98 P1302", "M99 P1302", "M98 P1302 would call O1302"),
        ("a.nc", "F500.", "F5P0.", "the letter P in a number"),
        ("a.nc", "Z50.", "Z5P.", "did you mean Z50.?"),
        ("a.nc", "A0.", "AP.", "did you mean A0.?"),
        ("a.nc", "#101=10.", "101=10.", "did you mean #101?"),
        ("a.nc", "A0. C0.", "0. C0.", "such as A0. or B0."),
        ("a.nc", "X5. F600.", "X5. R600.", "F600 may be meant"),
        ("a.nc", "#101=10.", "#10=10.", "line 4 sets #10, which nothing uses"),
        ("a.nc", "M30\n", "N30\n", "or in place of N30 in line 11"),
        ("a.nc", "M30\n", "M03\n", "or in place of M03 in line 11"),
        ("a.nc", "Y0.\nM99", "Y0.\nM89", "M99, the end of a subprogram"),
        ("a.nc", "F500.", "R500.", "F500 may be meant, whose key is beside"),
        ("a.nc", "S1000", "W1000", "S1000 may be meant, whose key is beside"),
        ("a.nc", "Y0. Z50.", "Y0. Z5 0.", "did you mean Z50.?"),
        ("a.nc", "Y0. Z50.", "Y0. Z50/", "a / in place of the point; did you mean Z50.?"),
        ("a.nc", "#101=10.", "#10l=10.", "did you mean #101?"),
        ("a.nc", "N30 G21", "N3 0G21", "N3 0G: the blank is at a wrong place; did you mean N30 G?"),
        ("a.ngc", "#<_tilt> =", "#<_tit> =", "line 1 sets #<_tit>, which nothing uses"),
        ("a.ngc", "#<top> =", "<top> =", "did you mean #<top>?"),
        ("a.ngc", "o<place> sub", "o<plaxe> sub", "line 3 has o<plaxe>, which nothing else names"),
        ("a.ngc", "o200 sub", "o2O0 sub", "did you mean o200?"),
        ("a.ngc", "repeat [2]", "repeat 2]", "the bracket before it is missing"),
        ("a.ngc", "Y#<_tilt>", "Y#_<tilt>", "the < after a letter"),
        ("a.ngc", "o<place> call [3]", "p<place> call [3]", "a label begins with O"),
        ("a.ngc", "o210 repeat", "o2l0 repeat", "did you mean o210?"),
        ("a.ngc", "o<place> call [3]", "<oplace> call [3]", "<oplace>: the < of the name is before the o"),
        ("a.ngc", "o<place> sub", "oplace> sub", "oplace>: the < of the name is missing"),
        ("a.nc", "G01 Z#101 F500.", "G01 Z#101 500.", "500. may lack its letter, such as F500."),
    ],
)
def test_an_edit_gives_back_what_was_meant(
    inspector: Inspector, tmp_path: Path, name: str, right: str, wrong: str, said: str
) -> None:
    """The first error says it; no edit makes another program without errors, but the first is the right one."""
    path, meant = tmp_path / name, {"a.nc": FANUC, "a.ngc": RS274}[name]
    assert not [one for one in check(inspector, path, meant, SETUP).findings if one.severity == "error"]
    text = meant.replace(right, wrong, 1)
    found = check(inspector, path, text, SETUP)
    item = next(one for one in found.findings if one.severity == "error")
    assert said in item.message
    fixes = [one for one in find_fixes(inspector, found, item, {path: text}, NEVER) if one.path == path]
    assert text[: fixes[0].begin] + fixes[0].new + text[fixes[0].end :] == meant
    assert not any("places" in one.title for one in fixes)


@pytest.mark.parametrize(
    ("right", "wrong", "said"),
    [
        ("Y0. Z50.", "Y0. X50.", "X appears twice in the block"),
        ("Y0. Z50.", "Y5-0. Z50.", "5-0.: a sign after a digit; write -50., or [5-0.] for an expression"),
    ],
)
def test_what_may_be_two_words_is_a_choice(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str
) -> None:
    path, meant = tmp_path / "a.nc", FANUC.replace("Y0. Z50.", "Y-50. Z50.") if "-" in wrong else FANUC
    text = FANUC.replace(right, wrong, 1)
    found = check(inspector, path, text, SETUP)
    (item,) = (one for one in found.findings if one.severity == "error")
    assert item.message == said
    fixes = find_fixes(inspector, found, item, {path: text}, NEVER)
    assert meant in [text[: one.begin] + one.new + text[one.end :] for one in fixes]
    assert len(fixes) > 1 and not any(one.settles for one in fixes)


@pytest.mark.parametrize(
    ("wrong", "right", "said"),
    [
        ("ED1", "END1", "DO1 is never ended; expected END1; line 15 has ED1: write END1 there"),
        ("EN1D", "END1", "line 15 has EN1D: write END1 there"),
        ("X0.\nM999", "X0.\nM99", "did you mean M99?"),
        ("X0.\n9M9", "X0.\nM99", "M99 may be meant"),
    ],
)
def test_a_mistyped_end_is_one_error(inspector: Inspector, tmp_path: Path, wrong: str, right: str, said: str) -> None:
    meant = FANUC[: FANUC.index("O1303")].replace("M98 P1303\n", "").replace("P21302", "P1302")
    meant = meant.replace("N30 G01 X5.", "#102=2\nWHILE [#102 GT 0] DO1\n#102=#102-1\nEND1\nN30 G01 X5.") + "%\n"
    path, text = tmp_path / "a.nc", meant.replace(right, wrong, 1)
    found = check(inspector, path, text, SETUP)
    (item,) = (one for one in found.findings if one.severity == "error")
    assert said in item.message
    fixes = find_fixes(inspector, found, item, {path: text}, NEVER)
    assert text[: fixes[0].begin] + fixes[0].new + text[fixes[0].end :] == meant


def test_a_subprogram_that_is_called_is_not_preferred_for_another_one(inspector: Inspector, tmp_path: Path) -> None:
    path, text = tmp_path / "a.nc", FANUC.replace("O1303 (LINE)\n", "")
    found = check(inspector, path, text, SETUP)
    item = next(one for one in found.findings if "O1303" in one.message)
    fixes = find_fixes(inspector, found, item, {path: text}, NEVER)
    assert [(one.new, one.settles) for one in fixes] == [("P1302", False)]


def test_a_word_that_is_right_elsewhere_is_changed_once(inspector: Inspector, tmp_path: Path) -> None:
    """N30 of subprograms are block numbers, whatever the N30 at the end of the program is."""
    path, text = tmp_path / "a.nc", FANUC.replace("M30\n", "N20 M9 N30\n")
    found = check(inspector, path, text, SETUP)
    item = next(one for one in found.findings if one.severity == "error")
    fixes = find_fixes(inspector, found, item, {path: text}, NEVER)
    assert [one.title.split(" (")[0] for one in fixes] == ["Write M30 in place of N30"]


def test_a_name_that_both_sides_use_is_no_slip(inspector: Inspector, tmp_path: Path) -> None:
    """The line that sets the one is lost: the other is not meant."""
    lines = "#<_at_x> = 1\nG0 X0 Y0 Z50 A0 C0\nG0 X#<_at_x> Z#<_at_z>\nG0 X#<_at_x> Z#<_at_z>\nM2\n"
    found = check(inspector, tmp_path / "a.ngc", f"G21 G90 G54\n{lines}", SETUP)
    item = next(one for one in found.findings if one.code == "VP025")
    assert item.message == "#<_at_z> has no value; set it first with #<_at_z>=..."


@pytest.mark.parametrize("wrong", ["_ar_y", "_St_y", "_at_yy"])
def test_a_name_that_nothing_uses_is_the_misspelt_one(inspector: Inspector, tmp_path: Path, wrong: str) -> None:
    """Names of other axes, which are in use, are nearer; none of them is offered."""
    path = tmp_path / "a.ngc"
    lines = "#<_at_x> = 1\n#<_at_z> = 9\n#<_at_y> = 2\nG0 X0 Y0 Z50 A0 C0\nG0 X#<_at_x> Y#<_at_y> Z#<_at_z>\nM2\n"
    text = f"G21 G90 G54\n{lines}".replace("_at_y", wrong, 1)
    found = check(inspector, path, text, SETUP)
    item = next(one for one in found.findings if one.code == "VP025")
    assert item.message.endswith(f"value, and line 4 sets #<{wrong}>, which nothing uses; write #<_at_y> there")
    (fix,) = find_fixes(inspector, found, item, {path: text}, NEVER)
    assert (text[: fix.begin] + fix.new + text[fix.end :], fix.settles) == (text.replace(wrong, "_at_y"), True)


TWO = """%
O1
G21 G90 G94 G17 G54
T1 M06
G0 X0 Y0 A0 C0
G43 H1 Z50
M3 S1000
G1 X1 F500
T2 M06
M3 S1000
G0 G43 H2 Z50
G1 X20 F500
G41 D2 X30 Y10
X50
G40 X60 Y0
M30
%
"""
TWO_TOOLS = """split_at_stops = true
[wcs]
G54 = [0, 0, 60]
[tools]
1 = { length = 80, diameter = 6 }
2 = { length = 90, diameter = 8 }
3 = { length = 100, diameter = 10 }
"""


@pytest.mark.parametrize(
    ("right", "wrong", "said", "offered"),
    [
        (
            "T2",
            "T3",
            "call T2 M6 before, else write H3",
            ["T2 in place of T3 in line 9", "H3 in place of H2 in line 11"],
        ),
        (
            "M06\nM3",
            "M60\nM3",
            "write M6 in place of M60 beside T2",
            ["M6 in place of M60 in line 9", "M6 after T2 in"],
        ),
        ("T2 M06", "T2 06", "this is T206; T2 M06 may be meant", ["T2 M06 in place of T2 06"]),
        ("M06\nM3", "M66\nM3", "did you mean M6?", ["M6 in place of M66"]),
        ("M30", "M300", "did you mean M30?", ["M30 in place of M300"]),
        ("M30", "M20", "did you mean M30?", ["M30 in place of M20"]),
        ("G40 X60", "M20 G40 X60", "M20: no meaning in this language; [remap]", []),
        ("G40 X60", "T40 X60", "T40: G40 may be meant, whose key is beside", ["G40 in place of T40"]),
        ("M30", "G8 Z0\nM30", "or G28 in place of G8", ["G28 in place of G8 in line 16"]),
        ("X50\n", "X50\nM300\n", "M300: no meaning in this language; [remap]", []),
    ],
)
def test_tools_and_ends_that_the_rest_gives_away(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str, offered: list[str]
) -> None:
    """H and D agree on a tool; M60 or M66 beside T is M6; what stands in place of the end is M30."""
    path, text = tmp_path / "a.nc", TWO.replace(right, wrong, 1)
    found = check(inspector, path, text, TWO_TOOLS)
    item = next(one for one in found.findings if one.message.find(said) >= 0)
    fixes = [one for one in find_fixes(inspector, found, item, {path: text}, NEVER) if one.path == path]
    titles = [one.title for one in fixes]
    assert [one[: len(f"Write {title}")] for one, title in zip(titles, offered, strict=True)] == [
        f"Write {title}" for title in offered
    ]
    assert [one.settles for one in fixes] == [wrong.startswith(("M60", "M300")), False][: len(fixes)]


@pytest.mark.parametrize(("number", "wrong"), [("0020", "P0200"), ("0020", "P002"), ("2001", "P2002")])
def test_a_file_beside_the_program_has_nearly_the_number(
    inspector: Inspector, tmp_path: Path, number: str, wrong: str
) -> None:
    (tmp_path / f"O{number}.nc").write_text(f"O{number}\nG1 X5 F500\nM99\n")
    path, text = tmp_path / "a.nc", FANUC.replace("P1302", wrong, 1)
    found = check(inspector, path, text, SETUP)
    item = next(one for one in found.findings if one.severity == "error")
    assert item.message.endswith(f"a file beside it has O{int(number)}, which is nearly this number")
    (fix,) = find_fixes(inspector, found, item, {path: text}, NEVER)
    assert text[: fix.begin] + fix.new + text[fix.end :] == FANUC.replace("P1302", f"P{number}", 1)


@pytest.mark.parametrize(
    ("files", "near"),
    [
        ({"O1000.nc": "O1000\nM98 P1001\nM30\n"}, ""),
        ({"O1000.nc": "G90\nM98 P1001\nM30\n"}, ""),
        ({"O2000.nc": "O2000\nM98 P3000\nM30\n", "O3000.nc": "O3000\nM98 P3001\nM99\n"}, ""),
        ({"O2000.nc": "O2000\nM98 P3000\nM30\n", "O3000.nc": "O3000\nM98 P3001\nM99\n", "O3002.nc": "M99\n"},
         "O3002, which is nearly this number"),
        ({"a.ngc": "o<bore> call\nM2\n", "bore.ngc": "o<bore> sub\no<bord> call\no<bore> endsub\n"}, ""),
        ({"a.ngc": "o<bora> sub\no<bora> endsub\no<bore> call\nM2\n",
          "bore.ngc": "o<bore> sub\no<bord> call\no<bore> endsub\n"}, "did you mean o<bora>?"),
        ({"a.h": "BEGIN PGM A MM\nCALL LBL 1\nM30\nLBL 1\nCALL LBL 11\nLBL 0\nEND PGM A MM\n"}, ""),
        ({"a.h": "BEGIN PGM A MM\nCALL LBL 1\nM30\nLBL 1\nCALL LBL 11\nLBL 0\nLBL 111\nLBL 0\nEND PGM A MM\n"},
         "did you mean LBL 111?"),
        ({"a.h": "BEGIN PGM A MM\nCALL LBL 1\nM30\nLBL 1\nFN 9: IF +0 EQU +0 GOTO LBL 11\nLBL 0\nEND PGM A MM\n"},
         "LBL 1, which is nearly this number"),
    ],
)  # fmt: skip
def test_a_program_that_runs_already_is_not_what_a_call_means(tmp_path: Path, files: dict[str, str], near: str) -> None:
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    findings = vp.check(tmp_path / next(iter(files)), "verne", vp.Options(tool_length=80.0)).findings
    item = next(one for one in findings if one.code == "VP023")
    assert item.message.endswith(near) if near else "nearly" not in item.message
    assert near or ("did you mean" not in item.message and not item.edits)


@pytest.mark.parametrize("column", [4, 5, 6, 10])
def test_a_variable_is_found_from_its_sign(column: int) -> None:
    lines = ["#<top> = 20", "G0 Z#<top>"]
    found = Outline(lines, "rs274", b"", "a.ngc").find_assignment(1, column)
    assert found is not None
    assert found.line == 0


LOOP = """o100 sub
#<depth> = #1
G1 Z#<depth> F250
o100 endsub
G21 G90 G94 G17 G54
G0 X0 Y0 Z60 A0 C0
M3 S1000
#101 = 0
o110 while [#101 LT 3]
#101 = [#101 + 1]
o100 call [2.5]
G0 Z30
o110 endwhile
G1 X40.5 F600
X5
Y12
M2
"""


@pytest.mark.parametrize(
    ("right", "wrong", "said", "is_sure"),
    [
        ("X5\n", "XT\n", "the letter T in a number; X5 may be meant", False),
        ("Y12", "Y1W", "the letter W in a number; Y12 may be meant", False),
        ("Z30", "ZE0", "the letter E in a number; Z30 may be meant", False),
        ("G0 Z30", "G9 Z30", "such as G0", False),
        ("LT 3", "FT 3", "FT: no operator; GT or LT may be meant", False),
        ("Z#<depth>", "#Z<depth>", "the # before its letter; did you mean Z#<depth>?", True),
        ("Z#<depth>", "Z#V<depth>", "a letter before the <; did you mean #<depth>?", True),
        ("o100 endsub", "oo100 endsub", "the letter is there twice; did you mean o100?", True),
        ("o100 sub", "oQ00 sub", "a letter in a number; did you mean o100?", True),
        ("[2.5]", "[2.]5", "the ] is too far left; did you mean [2.5]?", True),
    ],
)
def test_a_slip_is_one_finding_of_which_an_edit_gives_the_program_back(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str, is_sure: bool
) -> None:
    assert LOOP.count(right) == 1
    message, _marked, made = look(inspector, tmp_path / "a.ngc", LOOP.replace(right, wrong), SETUP)
    assert said in message
    assert (LOOP, is_sure) in [made_text[1:] for made_text in made.values()]


def test_an_arc_without_a_centre_is_one_finding_with_the_places_behind_it(inspector: Inspector, tmp_path: Path) -> None:
    message, _marked, _made = look(inspector, tmp_path / "a.ngc", LOOP.replace("X5", "G2 X5"), SETUP)
    assert message.startswith("an arc needs its centre")


MILLED = """%
O1
G21 G90 G94 G54 G17
T1 M6
G43 H1
G0 X0 Y0 Z50. A0 C0
M3 S1000
G1 X20. Y15. F100
G2 X30. Y15. I5. J0
G98 G81 X10. Y5. Z15. R22. F100
G80
G1 Y25.
M30
%
"""


@pytest.mark.parametrize(
    ("right", "wrong", "said", "is_sure"),
    [
        ("G2 X30.", "G12 X30.", "G12: a round pocket takes no place and no J or R; did you mean G2?", True),
        ("Z15. R22.", "Z15, R22.", "Z15, R22.: a comma in place of the point; did you mean Z15. R22.?", True),
        ("G1 Y25.", "G1 T25.", "T25.: Y25. may be meant, whose key is beside", False),
    ],
)
def test_a_slip_of_fanuc_gives_the_program_back(
    inspector: Inspector, tmp_path: Path, right: str, wrong: str, said: str, is_sure: bool
) -> None:
    assert MILLED.count(right) == 1
    setup = "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 80, diameter = 10 }\n"
    message, _marked, made = look(inspector, tmp_path / "a.nc", MILLED.replace(right, wrong), setup)
    assert said in message
    assert "did you mean 1?" not in message
    assert (MILLED, is_sure) in [made_text[1:] for made_text in made.values()]
    assert not any(preferred and text != MILLED for _path, text, preferred in made.values())
