"""What an editor underlines of a program, and the edits that it offers there, without the protocol."""

import asyncio
import re
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("pygls", reason="needs the extra lsp")

from lsprotocol import types as lsp

from verne_post.app.convert import Inspection
from verne_post.app.result import refuse_program
from verne_post.cli.callers import Callers
from verne_post.cli.lsp import server
from verne_post.cli.lsp.command import command
from verne_post.cli.lsp.completion import complete_word
from verne_post.cli.lsp.edits import Fix
from verne_post.cli.lsp.fixes import find_fixes, find_fixes_of_its_file
from verne_post.cli.lsp.inspector import Inspected, Inspector
from verne_post.cli.lsp.outline import Named, Outline
from verne_post.cli.lsp.places import find_range
from verne_post.model.findings import InputError

from ..builders import SAMPLES

SETUP = "tool_length = 80\n[wcs]\nG54 = [0, 0, 60]\n"
TOOLS = "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 80 }\n"
NGC = "G21 G90 G94 G17 G54\nG0 X0 Y0 Z50 A0 C0\nM3 S1000\n"
FANUC = f"%\nO1\n{NGC}"
SIEMENS = "DEF INT PASS\nG71 G90 G94 G54\nG0 X0 Y0 Z50 A0 C0\nM3 S1000\n"
KLARTEXT = "0 BEGIN PGM T MM\n1 TOOL CALL 1 Z S1000\n2 L X+0 Y+0 Z+50 A+0 C+0 R0 FMAX M3\n"
#: The first lines of a program by the ending of its file, with a motion of known feed rate, and its last ones.
HEADS = {
    ".mpf": (f"{SIEMENS}G1 X1 F500\n", "M30\n"),
    ".h": (f"{KLARTEXT}2 L X+1 F500\n", "9 M30\n10 END PGM T MM\n"),
    ".nc": (f"{FANUC}G1 X1 F500\n", "M30\n%\n"),
    ".ngc": (f"{NGC}G1 X1 F500\n", "M2\n"),
    ".cls": ("PARTNO T\nUNITS/MM\nFEDRAT/500,MMPM\nGOTO/0,0,60\n", "FINI\n"),
}


@pytest.fixture(scope="module")
def inspector() -> Inspector:
    given = dict(command.make_context("lsp", [], help_option_names=["-h", "--help"]).params)
    del given["extension"]
    return Inspector(given)


NEVER = threading.Event()


def check(inspector: Inspector, path: Path, text: str, setup: str = SETUP) -> Inspected:
    """A program with its set-up, as an editor has it."""
    path.write_text(text, "utf-8")
    Path(f"{path}.toml").write_text(setup, "utf-8")
    return inspector.check(path, {path: text}, NEVER)


def apply_places(fix: Fix) -> str:
    """The text after the single changes of an edit, as an editor makes them: none of them spans lines that stay."""
    text = fix.text or ""
    for begin, end, new in reversed(fix.list_edits()):
        assert "\n" not in text[begin:end].removesuffix("\n")
        text = text[:begin] + new + text[end:]
    return text


def look(
    inspector: Inspector, path: Path, text: str, setup: str = SETUP
) -> tuple[str, str, dict[str, tuple[Path, str, bool]]]:
    """The message of the only finding, what is underlined of it, and the files that its edits make, by their titles."""
    found = check(inspector, path, text, setup)
    (item,) = (one for one in found.findings if one.severity != "note")
    place = find_range(item, text.split("\n"))
    word = text.split("\n")[place.start.line][place.start.character : place.end.character]
    made = {
        fix.title.partition(" (")[0]: (fix.path, apply_places(fix), fix.settles)
        for fix in find_fixes(inspector, found, item, {path: text}, NEVER)
        if fix.text is not None
    }
    return item.message, word, made


@pytest.mark.parametrize(
    ("name", "text", "said", "word", "title", "change"),
    [
        (
            "a.mpf",
            f"{SIEMENS}TRAORI\nG0 A=DC(-20)\nM30\n",
            "write A=DC(340)",
            "A=DC(-20)",
            "Write A=DC(340) in place of A=DC(-20)",
            ("-20", "340"),
        ),
        (
            "a.h",
            f"{KLARTEXT}3 CALL LBL 20\n4 M30\n5 LBL 10\n6 L X+5 F600\n7 LBL 0\n8 END PGM T MM\n",
            "it has LBL 10, which is nearly this number",
            "20",
            "Write LBL 10 in place of LBL 20 in line 4",
            ("LBL 20", "LBL 10"),
        ),
        (
            "a.nc",
            f"{FANUC}M98 P41310\nM30\nO1301\nG1 X5 F600\nM99\n%\n",
            "put it there; the program has O1301, which is nearly this number",
            "P41310",
            "Write P41301 in place of P41310",
            ("P41310", "P41301"),
        ),
        (
            "b.nc",
            f"{FANUC}M98 P1312\nM30\nO1302\nG1 X5 F600\nM99\n%\n",
            "the program has O1302",
            "P1312",
            "Write P1302 in place of P1312",
            ("P1312", "P1302"),
        ),
        (
            "a.ngc",
            f"{NGC}o20 repeat [2]\nG1 X5 F500\nX0\no21 endrepeat\nM2\n",
            "o20 repeat (line 4) is open",
            "o21",
            "Write o20 in place of o21",
            ("o21", "o20"),
        ),
        (
            "b.mpf",
            f"{SIEMENS}FOR PASS=1 TO 3\nG1 X=PASS F500\n  ENDWHILE\nM30\n",
            "FOR of line 5 is open",
            "ENDWHILE",
            "Write ENDFOR in place of ENDWHILE",
            ("ENDWHILE", "ENDFOR"),
        ),
        (
            "c.nc",
            f"{FANUC}#1=1\nWHILE [#1 LT 3] DO1\nG1 X#1 F500\n#1=#1+1\nEND2\nM30\n%\n",
            "DO1 of line 7 is open",
            "END2",
            "Write END1 in place of END2",
            ("END2", "END1"),
        ),
        (
            "d.nc",
            f"{FANUC}#1=1\nWHILE [#1 LT 3] D01\nG1 X#1 F500\n#1=#1+1\nEND1\nM30\n%\n",
            "did you mean DO1?",
            "D01",
            "Write DO1 in place of D01",
            ("D01", "DO1"),
        ),
        (
            "d.mpf",
            f"{SIEMENS}FOR PASS = 1 T0 4\nG1 X=PASS F500\nENDFOR\nM30\n",
            "did you mean TO?",
            "T0",
            "Write TO in place of T0",
            ("T0", "TO"),
        ),
        (
            "b.h",
            f"{KLARTEXT}3 PLANE SPATIAL SPA+10 SPB+0 SPC+0 TURN DIST0 FMAX\n4 L X+3 F500\n5 M30\n6 END PGM T MM\n",
            "DIST belongs to MOVE",
            "DIST0",
            "Remove DIST0",
            ("DIST0", ""),
        ),
        (
            "b.ngc",
            f"{NGC}G1 X5 F500\nG4 S2\nM30\n",
            "S2: G4 needs P, the time; did you mean P2?",
            "S2",
            "Write P2 in place of S2",
            ("S2", "P2"),
        ),
        (
            "b.ngc",
            f"{NGC}G1 X5 F500\nG4 X0.3\nM30\n",
            "G4 needs P, the time; did you mean P0.3?",
            "X0.3",
            "Write P0.3 in place of X0.3",
            ("X0.3", "P0.3"),
        ),
        (
            "e.mpf",
            "DEF INTEGER NUM\nG71 G90\n" + "G0 X0 Y0 Z50 A0 C0\nM3 S1\nNUM=3\nG1 X=NUM F500\nM30\n",
            "did you mean INT?",
            "INTEGER",
            "Write INT in place of INTEGER",
            ("INTEGER", "INT"),
        ),
        (
            "f.mpf",
            f"{SIEMENS}UP(2)\nM30\n%_N_UP_SPF\nPROC UP(REAL A1)\nG1 X=A1 F500\nREF\n",
            "did you mean RET?",
            "REF",
            "Write RET in place of REF",
            ("REF", "RET"),
        ),
        (
            "e.nc",
            f"{FANUC}#101=10\nIF [#101 > 4] GOTO 10\nG1 X3 F500\nN10 G1 X#101 F500\nM30\n%\n",
            "did you mean GT?",
            ">",
            "Write GT in place of >",
            (">", "GT"),
        ),
        (
            "p.ngc",
            f"{NGC}#<n>=12\no2 if [#<n> > 10]\nG1 X3 F500\no2 endif\nM2\n",
            "did you mean GT?",
            ">",
            "Write GT in place of >",
            ("> > 10", "> GT 10"),
        ),
        (
            "q.ngc",
            f"{NGC}#<n>=3\no1 while [#<n>>0]\nG1 X#<n> F500\n#<n>=[#<n>-1]\no1 endwhile\nM2\n",
            "did you mean GT?",
            ">",
            "Write GT in place of >",
            (">>0", ">GT0"),
        ),
        (
            "f.nc",
            f"{FANUC}#101=1\nWHILE [#101 LE 3]\nG1 X#101 F500\n#101=#101+1\nEND1\nM30\n%\n",
            "DO1, which END1 of line 10 would end, is missing",
            "WHILE",
            "Write WHILE [#101 LE 3] DO1 in place of WHILE [#101 LE 3]",
            ("LE 3]", "LE 3] DO1"),
        ),
        (
            "g.nc",
            f"{FANUC}#101=1\nWHILE [#101 LE 3] DO1\nG1 X#101 F500\n#101=#101+1\nEND 2\nM30\n%\n",
            "DO1 of line 7 is open",
            "END 2",
            "Write END1 in place of END 2",
            ("END 2", "END1"),
        ),
        (
            "h.nc",
            f"{FANUC}#101==3\nG1 X#101 F500\nM30\n%\n",
            "did you mean =?",
            "==",
            "Write = in place of ==",
            ("==", "="),
        ),
        (
            "i.nc",
            f"{FANUC}#101=3\nIF [#101 LT 4] GOTO 101\nG1 X3 F500\nN100 G1 X#101 F500\nM30\n%\n",
            "it has N100",
            "101",
            "Write 100 in place of 101",
            ("GOTO 101", "GOTO 100"),
        ),
        (
            "j.nc",
            f"{FANUC}#101=3\nG1 X[#101+1 F500\nM30\n%\n",
            "expected an operator or ']'",
            "F500",
            "Write ] after X[#101+1 in line 7",
            ("+1 F", "+1] F"),
        ),
        (
            "d.ngc",
            f"{NGC}o20 repeat [2]\nG1 X3 F500\nO20 ENDWHILE\nM2\n",
            "o20 repeat (line 4) is open",
            "O20",
            "Write endrepeat in place of ENDWHILE in line 6",
            ("ENDWHILE", "endrepeat"),
        ),
        (
            "g.mpf",
            f"{SIEMENS}PASS == PASS + 1\nG1 X=PASS F500\nM30\n",
            "did you mean =?",
            "==",
            "Write = in place of ==",
            ("==", "="),
        ),
        (
            "h.mpf",
            f"{SIEMENS}FOR PASS=1 TILL 3\nG1 X=PASS F500\nENDFOR\nM30\n",
            "did you mean TO?",
            "TILL",
            "Write TO in place of TILL",
            ("TILL", "TO"),
        ),
        (
            "i.mpf",
            f"{SIEMENS}UP(2,3)\nM30\n%_N_UP_SPF\nPROC UP(REAL A1 REAL A2)\nG1 X=A1 F500\nRET\n",
            "A1 REAL: a comma is missing",
            "REAL",
            "Write A1, REAL in place of A1 REAL in line 8",
            ("A1 REAL", "A1, REAL"),
        ),
        (
            "j.mpf",
            f"{SIEMENS}G1 X=(PASS+2 F500\nM30\n",
            "expected ')' after an expression",
            "F500",
            "Write ) after X=(PASS+2 in line 5",
            ("+2 F", "+2) F"),
        ),
        (
            "c.h",
            f"{KLARTEXT}3 Q1 == 2\n4 L X+Q1 F500\n5 M30\n6 END PGM T MM\n",
            "did you mean =?",
            "==",
            "Write = in place of ==",
            ("==", "="),
        ),
        (
            "e.h",
            f"{KLARTEXT}3 L X+3 F500\n4 L Z+60 FMAXM3\n5 M30\n6 END PGM T MM\n",
            "a blank is missing",
            "FMAXM3",
            "Write FMAX M3 in place of FMAXM3",
            ("FMAXM3", "FMAX M3"),
        ),
        (
            "c.mpf",
            f"{SIEMENS}FOR PASS=1 TO 3\nG1 X=PASS F500\nEND FOR\nM30\n",
            "which line 7 writes as END FOR",
            "FOR",
            "Write ENDFOR in place of END FOR in line 7",
            ("END FOR", "ENDFOR"),
        ),
    ],
)
def test_a_slip_is_underlined_and_its_edit_settles_it(
    inspector: Inspector,
    tmp_path: Path,
    name: str,
    text: str,
    said: str,
    word: str,
    title: str,
    change: tuple[str, str],
) -> None:
    message, underlined, made = look(inspector, tmp_path / name, text)
    assert said in message
    assert underlined == word
    assert made[title] == (
        tmp_path / name,
        text.replace(*change, 1),
        not title.startswith(("Remove", "Write ]", "Write )", "Write P1302", "Write = in place of ==")),
    )


@pytest.mark.parametrize(
    ("name", "text", "said", "word"),
    [
        ("a.nc", f"{FANUC}#1=1\nIF [#1 EQ 1] GOTO 911\nG1 X5 F500\nN110 X10\nM30\n%\n", "no block N911", "911"),
        ("b.nc", f"{FANUC}G1 X#110 F500\nM30\n%\n", "#110 may have a value", "#110"),
        ("a.ngc", f"{NGC}G1 X#<y> F500\nM2\n", "#<y> has no value", "#<y>"),
        ("b.ngc", f"{NGC}G1 X5 F500\nG4\nM2\n", "G4 needs P", "G4"),
    ],
)
def test_a_finding_without_an_edit_is_underlined_at_its_word(
    inspector: Inspector, tmp_path: Path, name: str, text: str, said: str, word: str
) -> None:
    message, underlined, made = look(inspector, tmp_path / name, text)
    assert said in message
    assert (underlined, made) == (word, {})


@pytest.mark.parametrize(
    ("ending", "line", "wrong", "right", "is_sure"),
    [
        (".ngc", "X1l5", "X1l5", "X115", False),  # or X15, X1.5
        (".ngc", "X1O0", "X1O0", "X100", False),  # or X10
        (".ngc", "X1O", "X1O", "X10", True),
        (".ngc", "#5==-1", "==", "=", False),  # or =-
        (".ngc", "#5=2\nX[#5=2]", "#5=2]", "#5EQ2]", False),  # or +, -
        (".ngc", "#5=2\nX[#5==2]", "==", "EQ", True),
        (".ngc", "2X1", "2X1", "X21", False),  # or X1
        (".ngc", "X1,500", "X1,500", "X1.500", False),
        (".ngc", "X1,5", "X1,5", "X1.5", True),
        (".ngc", "X-,5", "X-,5", "X-.5", False),  # or X-5
        (".ngc", "M088", "M088", "M08", True),
        (".mpf", "T1 D1\nN30 M66", "M66", "M6", False),  # or a code of the builder
        (".mpf", "R103.5", "R103.5", "R103=.5", False),  # or R10=3.5
        (".mpf", "R1==5", "==", "=", False),
        (".mpf", "G7l0", "G7l0", "G710", False),  # or G70
        (".mpf", "YX=5", "YX", "Y", False),
        (".h", "2 L X+-5", "X+-5", "X-5", False),
        (".h", "2 X+5 Y+5 L R0", "X+5 Y+5 L", "L X+5 Y+5", True),
        (".h", "2 X=5 R0", "X=5", "L X-5", False),
        (".h", "2 X=-5 R0", "X=-5", "L X-5", True),
        (".h", "N2- L X+5", "N2-", "2", True),
        (".h", "2 N4-", "N4-", "M4", False),
        (".h", '2 LBL "EIN"\n2 L X+3\n2 CALL LBL "EIB" REP 2', '"EIB"', '"EIN"', True),
    ],
)
def test_an_edit_is_preferred_if_no_other_slip_leads_to_a_legal_program(
    inspector: Inspector, tmp_path: Path, ending: str, line: str, wrong: str, right: str, is_sure: bool
) -> None:
    head, end = HEADS[ending]
    path, text = tmp_path / f"a{ending}", f"{head}{line}\n{end}"
    found = check(inspector, path, text)
    item = next(one for one in found.findings if one.severity == "error")
    made = {apply_places(fix): fix.settles for fix in find_fixes(inspector, found, item, {path: text}, NEVER)}
    assert made[f"{head}{line.replace(wrong, right)}\n{end}"] is is_sure


def test_an_end_before_the_first_motion_is_named(inspector: Inspector, tmp_path: Path) -> None:
    """M30 for M03 was "no motion" in the first line."""
    text = "%\nO1\nG21 G90 G94 G17 G54\nS8000 M30\nG0 X0 Y0 Z50 A0 C0\nG1 X5 F500\nM30\n%\n"
    path = tmp_path / "a.nc"
    message, underlined, made = look(inspector, path, text)
    assert message.startswith("M30 ends the program before its first motion: lines 5 to 6 move axes after it")
    assert underlined == "M30"
    assert made == {"Write M3 in place of M30 in line 4": (path, text.replace("M30", "M3", 1), False)}


@pytest.mark.parametrize(("wrong", "right"), [("-90", "90"), ("-100.0", "100")])
def test_a_wrong_sign_of_a_work_offset_is_mended_in_the_set_up(
    inspector: Inspector, tmp_path: Path, wrong: str, right: str
) -> None:
    """Below the table face, no edit moved the part: a depth with a digit too many is likelier there."""
    path, text = tmp_path / "a.ngc", f"{NGC}G1 X5 Z5 F500\nG0 Z50\nM2\n"
    setup = SETUP.replace("0, 60", f"0, {wrong}")
    found = check(inspector, path, text, setup)
    (item,) = found.findings
    assert item.code == "VP210"
    (fix,) = (one for one in find_fixes(inspector, found, item, {path: text}, NEVER) if one.path != path)
    assert (apply_places(fix), fix.settles) == (SETUP.replace("0, 60", f"0, {right}"), False)
    assert fix.title == f"Set wcs.G54 = [0, 0, {right}] in a.ngc.toml (no errors then)"
    assert check(inspector, path, text, apply_places(fix)).findings == ()


@pytest.mark.parametrize(
    ("unit", "body", "title", "new"),
    [
        ("G21", "G0 Z5\nG1 Z-5\n", "Write G43 H2 after Z5 in line 9", "T2 M6\nM3\nG0 Z5 G43 H2\n"),
        ("G20", "G0 Z.5\nG1 Z-.2\n", "Write G43 H2 after Z.5 in line 9", "T2 M6\nM3\nG0 Z.5 G43 H2\n"),
        ("G21", "#1=5\nG0 Z#1\nG1 Z-5\n", "Write G43 H2 below line 7", "T2 M6\nG43 H2\nM3\n"),
        ("G21", "G98 G81 Z-5 R2\nG80\n", "Write G43 H2 below line 7", "T2 M6\nG43 H2\nM3\n"),
        # a subprogram of tool 1, too, and one in a file that others may call
        ("G21", "M98 P200\n", "Write G43 H2 below line 7", "T2 M6\nG43 H2\nM3\n"),
        ("G21", "M98 P300\n", "Write G43 H2 below line 7", "T2 M6\nG43 H2\nM3\n"),
    ],
)
def test_a_length_is_activated_where_no_other_tool_has_it(
    inspector: Inspector, tmp_path: Path, unit: str, body: str, title: str, new: str
) -> None:
    sub = "G0 Z2\nG1 Z-5\nG0 Z3\nM99\n"
    (tmp_path / "O0300.nc").write_text(f"%\nO300\n{sub}%\n", encoding="utf-8")
    head = f"%\nO1\n{unit} G90 G94 G17 G54 F50\nT1 M6\nM3 S1000 G43 H1 G0 X0 Y0 Z4 A0 C0\n"
    of_tool_1 = body if "M98" in body else "G1 Z0\n"
    text = f"{head}{of_tool_1}T2 M6\nM3\n{body}G0 Z4\nM30\nO200\n{sub}%\n"
    path, setup = tmp_path / "a.nc", f"split_at_stops = true\n{TOOLS}2 = {{ length = 90 }}\n"
    found = check(inspector, path, text, setup)
    (item,) = (one for one in found.findings if one.code == "VP034")
    (fix,) = find_fixes(inspector, found, item, {path: text}, NEVER)
    assert fix.title.startswith(f"{title} (no errors then") and fix.settles
    assert new in apply_places(fix)
    where = re.search(r"in line \d+, with the first Z|after line \d+", item.message)
    assert (where is not None and where[0][:2] == "in") == (" Z" in title or "#" in body)


def test_a_line_that_is_added_to_a_set_up_ends_as_its_lines_do(inspector: Inspector, tmp_path: Path) -> None:
    path, text = tmp_path / "a.ngc", f"{NGC}T7 M6\nG43 H7\nG1 X5 Z5 F500\nM2\n"
    found = check(inspector, path, text, TOOLS.replace("\n", "\r\n"))
    fixes = [fix for item in found.findings for fix in find_fixes(inspector, found, item, {path: text}, NEVER)]
    added = next(apply_places(fix) for fix in fixes if fix.path != path)
    assert added == f'{TOOLS}7 = {{ length = "measure" }}\n'.replace("\n", "\r\n")


COMPENSATED = "G43 H1 Z50\nG41 D1 X10 Y10 F500 G1\nX20\nX30 Y20\nG40 X40\nM2\n"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.nc", f"{FANUC}T1 M6\n{COMPENSATED}%\n".replace("M2", "M30")),
        ("a.ngc", f"{NGC}T1 M6\n{COMPENSATED}"),
        ("a.h", f"{KLARTEXT}3 L X+10 Y+10 RL F500\n4 L X+20\n5 L X+30 Y+20\n6 L X+40 R0\n7 M30\n8 END PGM T MM\n"),
        ("a.mpf", f"{SIEMENS}T1 D1\nM6\nG1 G41 X10 Y10 F500\nX20\nX30 Y20\nG40 X40\nM30\n"),
    ],
)
def test_a_diameter_that_the_set_up_lacks_is_added_to_be_filled_in(
    inspector: Inspector, tmp_path: Path, name: str, text: str
) -> None:
    """Beside the length of its tool; a length of the whole program becomes that of the tool."""
    setup = tmp_path / f"{name}.toml"
    message, _word, made = look(inspector, tmp_path / name, text, TOOLS)
    assert "tools.1.diameter, mm" in message
    ((path, new, settles),) = made.values()
    assert (path, settles) == (setup, False)
    assert new == TOOLS.replace("80", '80, diameter = "measure"')
    message, _word, made = look(inspector, tmp_path / name, text, SETUP)
    assert "write [tools] 1 = { length = MM, diameter = MM } into the set-up (which has no tool_length then)" in message
    ((path, new, settles),) = made.values()
    assert (path, settles) == (setup, False)
    assert new == '[wcs]\nG54 = [0, 0, 60]\n\n[tools]\n1 = { length = 80, diameter = "measure" }\n'
    found = check(inspector, tmp_path / name, text, new.replace('"measure"', "6"))
    assert [one for one in found.findings if one.severity == "error"] == []


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.mpf", "DEF REAL DEPTH=10\nG1 Z=DE|\nM30\n", ["DEPTH"]),
        ("b.mpf", "G0 X0\nFA|\nM30\n%_N_FACE_SPF\nPROC FACE(REAL SAFE)\nG1 X5\nRET\n", ["FACE"]),
        ("c.mpf", "G0 X0\nGOTOF LA|\nLAST:\nM30\n", ["LAST"]),
        ("a.ngc", "#<depth>=5\n#<width>=2\nG1 X[#<d|\nM2\n", ["#<depth>"]),
        ("b.ngc", "o<hole> sub\nG1 X5\no<hole> endsub\no<h|\nM2\n", ["o<hole>"]),
        ("a.nc", "%\nO1\nM98 P|\nM30\nO2000\nM99\nO1302\nM99\n%\n", ["2000", "1302"]),
        ("b.nc", "%\nO1\n#101=5.\nG1 X#1|\nM30\n%\n", ["#101"]),
        ("a.h", '0 BEGIN PGM A MM\n1 CALL LBL |\n2 M30\n3 LBL 10\n4 LBL 0\n5 LBL "SIDE"\n6 LBL 0\n', ["10", '"SIDE"']),
        ("b.h", "0 BEGIN PGM A MM\n1 Q12 = 5\n2 L Z+Q|\n3 M30\n", ["Q12"]),
        ("c.ngc", "#<depth>=5\n(#<d|)\nM2\n", []),
    ],
)
def test_names_of_the_program_are_completed(name: str, text: str, words: list[str]) -> None:
    above = text.partition("|")[0]
    line, column = above.count("\n"), len(above.rpartition("\n")[2])
    whole = text.replace("|", "")
    outline = Outline(whole.split("\n"), "auto", whole.encode(), name)
    own = [one for one in complete_word(outline, line, column, {}) if one.meaning.startswith("line ")]
    assert [one.word for one in own] == words
    for one in own:  # what stands there already is the beginning of the word
        assert one.word.startswith(whole.split("\n")[line][one.begin : column])


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("a.mpf", "DEF REAL DEPTH=10\nDEPTH=DEPTH-1\nG1 Z=DE|PTH\nM30\n", 0),
        ("a.ngc", "#<y>=5\n#<y>=6\nG1 X[#<|y>]\nM2\n", 0),
        ("b.ngc", "o20 repeat [2]\nG1 X5\no|20 endrepeat\no20 if [1]\no20 endif\nM2\n", 0),
        ("c.ngc", "o20 repeat [2]\nG1 X5\no20 endrepeat\no20 if [1]\no2|0 endif\nM2\n", 3),
        ("a.nc", "%\nO1\n#101=5.\nG1 X#1|01\nM30\n%\n", 2),
        ("a.h", "0 BEGIN PGM A MM\n1 Q12 = 5\n2 Q12 = Q12 + 1\n3 L Z+Q1|2\n4 M30\n", 1),
    ],
)
def test_a_variable_leads_to_its_first_value_and_an_o_word_to_its_loop(
    inspector: Inspector, tmp_path: Path, name: str, text: str, line: int
) -> None:
    above, whole = text.partition("|")[0], text.replace("|", "")
    found = Inspected(tmp_path / name, whole, (), Inspection(refuse_program(InputError())))
    there = inspector.find_definition(found, above.count("\n"), len(above.rpartition("\n")[2]))
    assert isinstance(there, Named)
    assert there.line == line


def test_a_refusal_is_shown_before_its_remedies_are_found(
    inspector: Inspector, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The search may take seconds; a number with a digit too many is mended, however far it leads."""
    path = tmp_path / "a.nc"
    text = f"{NGC}G1 X5 F500\nG0 Z2000\nM30\n"
    path.write_text(text, "utf-8")
    Path(f"{path}.toml").write_text(SETUP, "utf-8")
    monkeypatch.setattr(server, "_PATIENCE_S", 0.0)
    shown: list[lsp.PublishDiagnosticsParams] = []
    document = SimpleNamespace(version=3, source=text)
    workspace = SimpleNamespace(
        get_text_document=lambda _uri: document,
        text_documents={path.as_uri(): document},
        position_codec=SimpleNamespace(range_to_client_units=lambda _lines, place: place),
    )
    capabilities = SimpleNamespace(text_document=None, workspace=None)
    editor: Any = SimpleNamespace(
        workspace=workspace, client_capabilities=capabilities, text_document_publish_diagnostics=shown.append
    )
    session = server.Session(editor, inspector.given | inspector.asked)
    asyncio.run(session.run_check(path.as_uri(), NEVER))
    session.worker.shutdown()
    early, late = ([one for one in each.diagnostics if one.severity == 1] for each in shown)
    assert [one.code for one in early] == [one.code for one in late] == ["VP101"]
    assert "tried: nothing yet; remedies are being sought" in early[0].message
    assert re.search(r"tried: within limits if line 5 ends at Z 5\d\d\.\d instead of 2000", late[0].message)


@pytest.mark.parametrize(
    ("name", "text", "wrong", "right"),
    [
        ("a.ngc", f"{NGC}G1 X5 F500\nG0 Z-80.\nM30\n", "Z-80.", "Z80."),
        ("a.h", f"{KLARTEXT}3 L X+5 F500\n4 L Z-80 FMAX\n5 M30\n6 END PGM T MM\n", "Z-80", "Z+80"),
    ],
)
def test_a_minus_too_many_is_a_choice_beside_the_nearest_place(
    inspector: Inspector, tmp_path: Path, name: str, text: str, wrong: str, right: str
) -> None:
    """Only the place next to the limit was offered."""
    _message, _word, made = look(inspector, tmp_path / name, text)
    path, new, settles = next(one for title, one in made.items() if title.startswith(f"Write {right} in place"))
    assert (path, new, settles) == (tmp_path / name, text.replace(wrong, right), False)
    assert any(title.startswith("Write Z-59.9") for title in made)


def test_a_rapid_below_the_cuts_has_the_other_sign_as_a_choice(inspector: Inspector, tmp_path: Path) -> None:
    text = f"{NGC}G0 Z40\nG1 Z5 F500\nX10\nG0 Z-40\nZ40\nM30\n"
    _message, underlined, made = look(inspector, tmp_path / "a.nc", text)
    line = text[: text.index("Z-40")].count("\n") + 1
    path, new, settles = made[f"Write Z40 in place of Z-40 in line {line}"]
    assert (underlined, path, settles) == ("Z-40", tmp_path / "a.nc", False)
    assert new == text.replace("Z-40", "Z40")


def test_a_centre_with_the_wrong_sign_has_its_edit(inspector: Inspector, tmp_path: Path) -> None:
    text = f"{NGC}G1 X10 F500\nG3 X20 Y10 I0 J-10\nM30\n"
    _message, underlined, made = look(inspector, tmp_path / "a.nc", text)
    path, new, settles = made["Write J10 in place of J-10 in line 5"]
    assert (underlined, path, settles) == ("J-10", tmp_path / "a.nc", False)
    assert new == text.replace("J-10", "J10")
    # an arc of 270 deg is no edit
    assert not any("J10" in title for title in look(inspector, tmp_path / "a.nc", text.replace("G3", "G2"))[2])


@pytest.mark.parametrize(
    "text",
    [
        "#<y>=[2*COS[20]\n#<_at_x>=[1+#<y>]\n#<_at_z>=3\nG1 X#<_at_x> F500\n",
        "#<y=2\n#<_at_x>=[1+#<y>]\n#<_at_z>=3\nG1 X#<_at_x> F500\n",
        "#101=10,\nG1 X[#101+1] F500\n",
    ],
)
def test_a_variable_whose_line_cannot_be_read_is_no_second_error(
    inspector: Inspector, tmp_path: Path, text: str
) -> None:
    """It was called unset, or a slip of another name, in each line that uses it."""
    head = FANUC if "#101" in text else NGC
    message, _word, _made = look(inspector, tmp_path / "a.nc", f"{head}{text}M30\n")
    assert "value" not in message


@pytest.mark.parametrize(
    ("wrong", "right"),
    [('1 = { length = "80" }', "1 = { length = 80 }"), ("1 = { length = 80,5 }", "1 = { length = 80.5 }")],
)
def test_a_number_of_a_set_up_in_quotes_or_with_a_comma_has_its_edit(
    inspector: Inspector, tmp_path: Path, wrong: str, right: str
) -> None:
    path = tmp_path / "a.nc"
    text, wrong = f"{FANUC}G1 X5 F500\nM30\n%\n", f"[wcs]\nG54 = [0, 0, 60]\n[tools]\n{wrong}\n"
    found = check(inspector, path, text, wrong)
    (item,) = found.findings
    (fix,) = find_fixes_of_its_file(inspector, found, item, {path: text}, NEVER)
    assert f"{wrong[: fix.begin]}{fix.new}{wrong[fix.end :]}".split("\n")[3] == right


CYCLE = """3 L Z+20 FMAX
4 CYCL DEF 200 DRILLING ~
Q200=2 ~
Q201=-3 ~
Q206=150 ~
Q202=3 ~
Q210=0 ~
Q203=+0 ~
Q204=10 ~
Q211=0
5 L X+5 FMAX M99
6 M30
7 END PGM T MM
"""


@pytest.mark.parametrize(
    ("wrong", "right", "message", "title"),
    [
        ("Q201=-3\n", "Q201=-3 ~\n", "line 7 has no ~", "Write ~ after Q201=-3 in line 7"),
        ("Q207=150", "Q206=150", "Q206, the plunge feed, is missing", "Write Q206 in place of Q207"),
    ],
)
def test_a_slip_in_a_cycle_of_klartext_has_its_edit(
    inspector: Inspector, tmp_path: Path, wrong: str, right: str, message: str, title: str
) -> None:
    text = KLARTEXT + CYCLE
    told, _word, made = look(inspector, tmp_path / "a.h", text.replace(right, wrong))
    assert message in told and made[title][1] == text


def test_an_error_of_a_proc_line_stands_in_that_line(inspector: Inspector, tmp_path: Path) -> None:
    """It was shown at each call."""
    path = tmp_path / "a.mpf"
    text = f"{SIEMENS}UP(2,3)\nUP(4,5)\nM30\n%_N_UP_SPF\nPROC UP(REAL A1, REEL A2)\nG1 X=A1 F500\nRET\n"
    (item,) = check(inspector, path, text).findings
    assert (item.line, item.column, item.code) == (9, 18, "VP001")


FACE = "M30\n%_N_FACE_SPF\nPROC FACE(REAL SAFE, REAL LOW, REAL SPEED)\n"


@pytest.mark.parametrize(
    ("calls", "body", "lacking", "why"),
    [
        ("FACE(30)", "G1 X=SAFE Y1 F=SPEED\nX9\nRET", "LOW (REAL) and SPEED (REAL) are", "line 9: G1 with feed rate"),
        ("FACE(30)", "F=SPEED\nG1 X=SAFE\nRET", "LOW (REAL) and SPEED (REAL) are", "line 10: G1 with feed rate"),
        ("FACE(30,,9)", "F=SPEED\nCYCLE83(9,0,2,-9,,,LOW)\nRET", "LOW (REAL) is", "line 10: CYCLE83: the first"),
        ("FACE(30,,9)\nFACE(3,4,9)", "F=SPEED\nG1 X=SAFE/LOW\nRET", "LOW (REAL) is", "line 11: 30 / 0 has no"),
        ("FACE(30,,9)", "G1 X0 Y0 F9\nG2 X=SAFE Y0 CR=LOW\nRET", "LOW (REAL) is", "line 10: "),
    ],
)
def test_a_value_that_a_call_lacks_is_an_error_of_the_call(
    inspector: Inspector, tmp_path: Path, calls: str, body: str, lacking: str, why: str
) -> None:
    """It was one of each line of the subprogram that reads it."""
    message, underlined, _made = look(inspector, tmp_path / "a.mpf", f"{SIEMENS}{calls}\n{FACE}{body}\n")
    assert f" of the 3 values of its PROC line: {lacking} missing" in message and f"({why}" in message
    assert underlined == "FACE"
    found = check(inspector, tmp_path / "a.mpf", f"{SIEMENS}{calls}\n{FACE}{body}\n")
    assert [(one.code, one.line) for one in found.findings] == [("VP005", 5)]


@pytest.mark.parametrize(
    ("calls", "body", "code", "line"),
    [
        ("FACE(30)", "G1 X=SAFE Y=LOW\nRET", "VP009", 9),  # nothing gives F
        ("FACE(30,2,3)", "G1 X=SAFE/(LOW-2) F9\nRET", "VP007", 9),
        ("FACE(30)", "LOW=2\nG1 X=SAFE/(LOW-2) F9\nRET", "VP007", 10),
        ("FACE(30)", "G1 X=LOW F9 FOO\nRET", "VP002", 9),
        ("FACE(30)", "G1 X0 Y0 F9\nG2 X=SAFE Y0 CR=1 H=LOW\nRET", "VP008", 10),
        ("FACE(30)", "G1 X=SAFE/(30-SAFE) Y=LOW F9\nRET", "VP007", 9),
    ],
)
def test_an_error_that_no_missing_value_leads_to_stays_in_its_line(
    inspector: Inspector, tmp_path: Path, calls: str, body: str, code: str, line: int
) -> None:
    found = check(inspector, tmp_path / "a.mpf", f"{SIEMENS}{calls}\n{FACE}{body}\n")
    assert [(one.code, one.line) for one in found.findings] == [(code, line)]


def test_an_open_bracket_of_a_formula_has_its_edit(inspector: Inspector, tmp_path: Path) -> None:
    text = f"{KLARTEXT}3 Q1 = 2*(2+1)\n4 L X+Q1 F500\n5 M30\n6 END PGM T MM\n"
    _message, underlined, made = look(inspector, tmp_path / "a.h", text.replace("+1)", "+1"))
    assert underlined == "(" and [new for _path, new, _settles in made.values()] == [text]


@pytest.mark.parametrize(
    ("written", "edits"), [("#10l-1.5", [f"{FANUC}#101=2.\n#101=#101-1.5\nM30\n"]), ("#10L-1.5", [])]
)
def test_the_rest_of_an_expression_is_not_to_be_removed(
    inspector: Inspector, tmp_path: Path, written: str, edits: list[str]
) -> None:
    """#101=#10 is a value that the program does not mean."""
    _told, _word, made = look(inspector, tmp_path / "a.nc", f"{FANUC}#101=2.\n#101={written}\nM30\n")
    assert [new for _path, new, _settles in made.values()] == edits


TILTED = "G68.2 X0 Y0 Z0 I0 J20 K0\nG53.1\nG0 X0 Y0 Z30\n"
HOLES = "MCALL CYCLE81(30,0,2,-5)\nX1\n"


@pytest.mark.parametrize(
    ("name", "body", "said", "word"),
    [
        (
            "a.nc",
            f"T1 M6\nG43 H1\nM3\nG0 Z90\n{TILTED}G1 Z20\nG0 Z60\n(M6) T2 M6\nM3\nG0 Z60\nG1 Z20\n",
            "is still in",
            "M6",
        ),
        (
            "a.nc",
            f"T1 M6\nM3\nG43.4 H1 Z90\nG0 A-20\nN5 {TILTED[:-20]}\nG0 X0 Y0 Z30\nG1 Z20\nG0 Z60\nN7 G49\n"
            "G43.4 H1 G0 A0 C0\nX0\nG1 Z20\nG0 Z60\n",
            "after G49",
            "G49",
        ),
        (
            "a.mpf",
            f'{HOLES}CYCLE800(0,"",0,57,0,0,0,20,0,0,0,0,0,1)\nX2\nMCALL\n',
            "in the new plane of line 8",
            "CYCLE800",
        ),
        ("a.nc", f"G81 X1 Z-5 R2\n N7 {TILTED[:-13]}X5\nG80\n", "in the new plane of line 8", "G68.2"),
    ],
)
def test_a_plane_that_is_kept_is_underlined_at_its_word(
    inspector: Inspector, tmp_path: Path, name: str, body: str, said: str, word: str
) -> None:
    """The whole line was."""
    head, end = HEADS[Path(name).suffix]
    found = check(inspector, tmp_path / name, f"{head}{body}{end}", f"{TOOLS}2 = {{ length = 80 }}\n")
    (item,) = (one for one in found.findings if one.code == "VP043")
    assert said in item.message and item.line is not None and item.column is not None
    assert found.text.split("\n")[item.line - 1][item.column - 1 :].startswith(word)


@pytest.mark.parametrize(
    ("name", "line", "right"),
    [
        ("a.mpf", "R1=l0", "R1=10"),
        ("a.mpf", "R1=2*lO", "R1=2*10"),
        ("a.mpf", "R1=(2+l)*3", "R1=(2+1)*3"),
        ("a.mpf", "R1=O", "R1=0"),
        ("a.mpf", "R1=10l", "R1=101"),
        ("a.mpf", "R1=2*1,5", "R1=2*1.5"),
        ("a.mpf", "PASS=3 X PASS", "PASS=3 X=PASS"),
        ("a.mpf", "G0 X PASS", "G0 X=PASS"),
        ("a.mpf", "G0 Z (PASS+9)", None),
        ("a.mpf", "R1=lO(3)", None),
        ("a.h", "3 Q1 = l0", "3 Q1=10"),
        ("a.h", "3 Q1 = 2*l0", "3 Q1 = 2*10"),
        ("a.h", "3 Q1 = SIN lO", "3 Q1 = SIN 10"),
        ("a.h", "3 Q1 = l,5", "3 Q1 = 1,5"),
        ("a.nc", "#101=l0", "#101=10"),
        ("a.nc", "#101=[2*O5]", "#101=[2*05]"),
        ("a.nc", "#101=10l", "#101=101"),
        ("a.ngc", "#101=lO", "#101=10"),
        ("a.ngc", "#101=[2+1O]", "#101=[2+10]"),
        ("a.ngc", "#101=[2*1,5]", "#101=[2*1.5]"),
        ("a.ngc", "o10 whale", None),
        ("a.cls", "GOTO/1,O,60", "GOTO/1,0,60"),
        ("a.cls", "GOTO/1,l0,60", "GOTO/1,10,60"),
        ("a.cls", "FEDRAT/5OO,MMPM", "FEDRAT/500,MMPM"),
        ("a.cls", "FEDRAT/MMPM,50o", "FEDRAT/MMPM,500"),
        ("a.cls", "SPINDL/30O0,CLW", "SPINDL/3000,CLW"),
        ("a.cls", "LOADTL/1,ADJUST,1O", "LOADTL/1,ADJUST,10"),
        ("a.cls", "GO/1,0,60", None),
        *(
            ("a.cls", wrong, right)
            for wrong, right in (
                ("LOADTL5", "LOADTL/5"),
                ("LOADTL5,ADJUST,5", "LOADTL/5,ADJUST,5"),
                ("LOADTL/1,2", None),
                ("GOTO-1.0,20.0,5.0", "GOTO/-1.0,20.0,5.0"),
                ("GOTO/1.0,20,0000,-2.5000", "GOTO/1.0,20.0000,-2.5000"),
                ("GOTO/1,2,0,60", None),
                ("GOTO/1.,0.,60.,0,0000,.6,.8", "GOTO/1.,0.,60.,0.0000,.6,.8"),
                ("DELAY/2,5", "DELAY/2.5"),
                ("SPINDL/400,5,CLW", "SPINDL/400.5,CLW"),
                ("GODLTA/1,5", "GODLTA/1.5"),
                ("GODLTA/1,5,0,0", None),
                ("GOTO/1.0,2.0;60", "GOTO/1.0,2.0,60"),
                ("GOTO/1,0,,60", "GOTO/1,0,60"),
                ("GOTO//1,0,60", "GOTO/1,0,60"),
                ("GOTO/1,0,6..5", "GOTO/1,0,6.5"),
                ("FEDRATMMPM,400", "FEDRAT/MMPM,400"),
                ("FEDRAT/MMPM.400.0000", "FEDRAT/MMPM,400.0000"),
                ("SPINDL RPM,900,CLW", "SPINDL/RPM,900,CLW"),
                ("SPINDL/RPM900,CLW", "SPINDL/RPM,900,CLW"),
                ("COOLNTON", "COOLNT/ON"),
                ("COOLNT/ONN", "COOLNT/ON"),
                ("MULTAX/OON", "MULTAX/ON"),
                ("CYCLE/DRILLDEPTH,9,CLEAR,3,MMPM,250", "CYCLE/DRILL,DEPTH,9,CLEAR,3,MMPM,250"),
                ("DEFSUB7\nGOTO/1,0,60\nENDSUB\nCALSUB/7", "DEFSUB/7\nGOTO/1,0,60\nENDSUB\nCALSUB/7"),
            )
        ),
    ],
)
def test_what_looks_like_a_digit_or_sign_has_its_edit_in_every_language(
    inspector: Inspector, tmp_path: Path, name: str, line: str, right: str | None
) -> None:
    """In expressions it was a name without a value, or no number at all; behind it, a bracket was missing."""
    head, end = HEADS[Path(name).suffix]
    found = check(inspector, tmp_path / name, f"{head}{line}\n{end}")
    item = next(one for one in found.findings if one.severity == "error")
    fixes = find_fixes(inspector, found, item, {found.path: found.text}, NEVER)
    made = [f"{found.text[: fix.begin]}{fix.new}{found.text[fix.end :]}" for fix in fixes]
    assert made == ([] if right is None else [f"{head}{right}\n{end}"])


@pytest.mark.parametrize(
    ("name", "line", "rights"),
    [
        ("a.mpf", 'MSG("hello', ['MSG("hello")']),
        ("a.mpf", 'MSG("hello world', ['MSG("hello world")']),
        ("a.mpf", 'MSG("hello)', ['MSG("hello")']),
        ("a.mpf", 'MSG("hello world)', ['MSG("hello world")']),
        ("a.mpf", 'CYCLE800(0,"TC1,0,57)', ['CYCLE800(0,"TC1",0,57)', 'CYCLE800(0,"TC1,0,57")']),
        ("a.mpf", 'T="D8', ['T="D8"']),
        ("a.mpf", 'T="D8 M6', ['T="D8" M6', 'T="D8 M6"']),
        ("a.h", '3 CALL LBL "SIDE\n4 M30\n5 LBL "SIDE"\n6 LBL 0', ['3 CALL LBL "SIDE"\n4 M30\n5 LBL "SIDE"\n6 LBL 0']),
    ],
)
def test_a_quote_that_is_not_closed_has_its_edit(
    inspector: Inspector, tmp_path: Path, name: str, line: str, rights: list[str]
) -> None:
    head, end = HEADS[Path(name).suffix]
    found = check(inspector, tmp_path / name, f"{head}{line}\n{end}")
    item = next(one for one in found.findings if one.code == "VP001")
    fixes = find_fixes(inspector, found, item, {found.path: found.text}, NEVER)
    made = [f"{found.text[: fix.begin]}{fix.new}{found.text[fix.end :]}" for fix in fixes]
    assert made == [f"{head}{right}\n{end}" for right in rights]
    assert not any(fix.settles for fix in fixes)  # where the text was to end, nobody knows


def ask(inspector: Inspector, path: Path, text: str, place: str, setup: str = SETUP) -> str:
    """What is shown of the word at the | of a place of a text."""
    return ask_all(inspector, path, text, place, setup).split("\n")[0].partition("**: ")[2]


def ask_all(inspector: Inspector, path: Path, text: str, place: str, setup: str = SETUP) -> str:
    found = check(inspector, path, text, setup)
    at = text.index(place.replace("|", "")) + place.index("|")
    line = text.count("\n", 0, at) + 1
    said = inspector.describe_line(found, line, at - text.rfind("\n", 0, at) - 1)
    assert said is not None
    return said


@pytest.mark.parametrize(
    ("name", "text", "place", "values"),
    [
        (
            "a.mpf",
            "CYCLE81(30,,2,-5)\n",
            "CYC|LE81",
            ["RTP = 30: retraction plane, absolute", "RFP: reference", "SDIS = 2:"],
        ),
        ("a.mpf", "R1=-5\nCYCLE81(30,0,2,R1)\nX9\nCYCLE81(9,0)\n", "CYCLE|81(30", ["RTP = 30", "DP = R1: final depth"]),
        ("a.mpf", 'CYCLE800(0,"",0,57,0,0,0,0,20)\n', "CYCLE|800", ['_TC = "":', "_B = 20: second angle", "_C: third"]),
        ("a.mpf", "CYCLE800()\n", "CYCLE|800", ["_FR: retract before the turn"]),
        (
            "a.h",
            CYCLE.partition("6 M30")[0],
            "CYCL DEF |200",
            ["Q201 = -3: depth, in the unit", "Q206 = 150: plunge feed, per minute", "Q395: depth of shank, the depth"],
        ),
        (
            "a.h",
            "3 CYCL DEF 251 RECTANGULAR POCKET ~\nQ218=60\n",
            "CYCL DEF |251",
            [
                "Q218 = 60: length, first side",
                "Q219: width, second side",
                "Q366: plunging, 0 straight down, 1 on a helix",
            ],
        ),
    ],
)
def test_hover_of_a_cycle_shows_the_values_of_its_call(
    inspector: Inspector, tmp_path: Path, name: str, text: str, place: str, values: list[str]
) -> None:
    """It named what the cycle takes, and left the reader to count commas."""
    head, end = HEADS[Path(name).suffix]
    told = ask_all(inspector, tmp_path / name, f"{head}{text}{end}", place)
    assert all(f"\n- {value}" in told for value in values)


def test_hover_of_a_value_of_a_call_names_its_parameter(inspector: Inspector, tmp_path: Path) -> None:
    text = f"{SIEMENS}FACE(30,-9)\nM30\n%_N_FACE_SPF\nPROC FACE(REAL SAFE, REAL LOW)\nG1 X=SAFE Y=LOW F500\nRET\n"
    assert ask(inspector, tmp_path / "a.mpf", text, "FACE(|30") == "REAL SAFE of FACE"
    assert ask(inspector, tmp_path / "a.mpf", text, "30,|-9") == "REAL LOW of FACE"
    told = ask(inspector, tmp_path / "a.mpf", text.replace("30,-9", "30 -9"), "FACE(|30")  # a comma is missing
    assert told == "REAL SAFE of FACE; the call gives 1 of 2 values"


O_CALL = f"{NGC}G1 X5 F500\no7 sub\nX#1 Y#2\no7 endsub\no7 call [15] [[1+2]*2] (x, y)\nM2\n"
O_LOOPS = (
    f"{NGC}G1 X5 F500\n#1=0\no1 while [#1 LT 3]\nX#1\n#1=[#1+1]\no1 endwhile\n"
    "o2 do\n#1=[#1-1]\no2 while [#1 GT 1]\no3 if [#1 GT 2]\nX3\no3 endif\nM2\n"
)


@pytest.mark.parametrize(
    ("text", "place", "said"),
    [
        (O_CALL, "[1|5]", "becomes #1 of o7"),
        (O_CALL, "[[1+2]*|2]", "becomes #2 of o7"),
        (O_LOOPS, "|o1 while", "mark of a loop, in the first of 3 passes"),
        (O_LOOPS, "|o1 endwhile", "mark of a loop, in the first of 3 passes"),
        (O_LOOPS, "|o2 while", "mark of a loop, in the first of 2 passes"),
        (O_LOOPS, "|o3 if", "mark of a branch"),
        (O_CALL, "|o7 sub", "number or name of the subprogram"),
    ],
)
def test_hover_of_o_words(inspector: Inspector, tmp_path: Path, text: str, place: str, said: str) -> None:
    assert ask(inspector, tmp_path / "a.ngc", text, place) == said


def test_a_loop_leads_not_to_itself(inspector: Inspector, tmp_path: Path) -> None:
    for place, leads in (
        ("|o1 while", False),
        ("|o7 sub", False),
        ("|o1 endwhile", True),
        ("|o2 while", True),
        ("|o7 call", True),
    ):
        text = O_CALL if "o7" in place else O_LOOPS
        assert ("leads to line" in ask_all(inspector, tmp_path / "a.ngc", text, place)) == leads


LOOP = f"{SIEMENS}G1 X5 F500\nR1=1\nFOR PASS=1 TO 4\nR1=R1+1\nENDFOR\nR2=R1\nM30\n"
CALLS = f"{FANUC}G1 X5. F500.\n#1=10.\nM98 P40002\nM30\nO2\n#1=#1-2.\nM99\n%\n"
REPEATS = f"{KLARTEXT}3 L X+5 F500\n4 Q1=1\n5 LBL 1\n6 Q1=Q1+1\n7 CALL LBL 1 REP 3\n8 M30\n9 END PGM T MM\n"


@pytest.mark.parametrize(
    ("name", "text", "place", "said"),
    [
        ("a.mpf", LOOP, "|R1=R1+1", "2 after this line, in the first of 4 passes"),
        ("a.mpf", LOOP, "|PASS=1", "1 after this line, in the first of 4 passes"),
        ("a.mpf", LOOP, "|R1=1", "1 after this line"),
        ("a.nc", CALLS, "|#1=#1", "8 after this line, in the first of 4 passes"),
        ("a.h", REPEATS, "|Q1=Q1", "2 after this line, in the first of 4 passes"),
    ],
)
def test_a_value_of_a_line_without_motion_names_the_passes(
    inspector: Inspector, tmp_path: Path, name: str, text: str, place: str, said: str
) -> None:
    told = ask(inspector, tmp_path / name, text, place)
    assert told == f"variable; {said}"


def test_unlike_passes_are_counted(inspector: Inspector, tmp_path: Path) -> None:
    """The moves alone did not tell how many: a cycle in another plane begins with other moves."""
    holes = "O2\nG0 Z30.\nG82 X-15. Y5. Z-9. R3. P300 F250.\nX0.\nG80 G0 Z30.\nM99\n%\n"
    text = f"{FANUC}M98 P2\nG0 Z50. A-25.\nG68.2 X0. Y0. Z0. I0. J25. K0.\nM98 P2\nG69\nM30\n{holes}"
    assert ask(inspector, tmp_path / "a.nc", text, "|X0.\nG80").endswith(", in the first of 2 passes")


@pytest.mark.parametrize("place", ["|Q201=-1", "Q201=|-1", "Q206= |MAX"])
@pytest.mark.parametrize("unit", ["MM", "INCH"])
def test_hover_of_a_cycle_value_names_its_unit(inspector: Inspector, tmp_path: Path, place: str, unit: str) -> None:
    cycle = "CYCL DEF 200 N ~\n Q200=2 ~\n Q201=-1 ~\n Q206= MAX ~\n Q202=5 ~\n Q210=0 ~\n Q203=0 ~\n Q204=3"
    text = f"{KLARTEXT.replace(' MM', f' {unit}')}{cycle}\n3 M30\n4 END PGM T {unit}\n"
    said = "plunge feed, in {}/min; here MAX" if "MAX" in place else "depth, in {}; here -1"
    assert ask(inspector, tmp_path / "a.h", text, place) == said.format(unit.lower())


def test_hover_of_s_beside_tool_call_does_not_say_that_the_spindle_stands(inspector: Inspector, tmp_path: Path) -> None:
    """M3 cannot stand in that line."""
    text = f"{KLARTEXT}3 M30\n4 END PGM T MM\n"
    assert ask(inspector, tmp_path / "a.h", text, "Z |S1000").endswith("1000 1/min")


def test_a_misspelt_value_of_a_proc_line_is_corrected_there(inspector: Inspector, tmp_path: Path) -> None:
    body = "G1 X=BOTTOM F500\nX=BOTTOM+1\nRET\n"
    text = f"{SIEMENS}UP(2)\nM30\n%_N_UP_SPF\nPROC UP(REAL BOTTOM)\n{body}"
    wrong = text.replace("REAL BOTTOM", "REAL BOTOM")
    _message, _word, made = look(inspector, tmp_path / "a.mpf", wrong)
    assert made["Write BOTTOM in place of BOTOM in the PROC line 8"][1:] == (text, True)


SPLINES = (
    f"{NGC}G1 X1 F500\nG5.2 X2 Y0 P1 L3\nX4 Y5 P2\nX6 Y0 P1\nG5.3\nG3 X10 Y4 R6\nX1 Y2 I-3 J4\n"
    "G5 X9 Y3 I2 J3 P-4 Q-5\nG90.1 G2 X5 Y1 I3 J2\n#1=#5420\nM2\n"
)


@pytest.mark.parametrize(
    ("name", "text", "place", "said"),
    [
        ("a.ngc", SPLINES, "|P1 L3", "weight of this control point: 1"),
        ("a.ngc", SPLINES, "P1 |L3", "order of the NURBS: 3"),
        ("a.ngc", SPLINES, "|P2", "weight of this control point: 2"),
        ("a.ngc", SPLINES, "|R6", "radius of the arc: 6; a negative one takes the long way"),
        ("a.ngc", SPLINES, "|I-3", "centre of the arc, from its start in X: -3"),
        ("a.ngc", SPLINES, "|J4", "centre of the arc, from its start in Y: 4"),
        ("a.ngc", SPLINES, "|I2 J3", "first control point of the spline, from the start: 2"),
        ("a.ngc", SPLINES, "|Q-5", "second control point of the spline, from the end: -5"),
        ("a.ngc", SPLINES, "I3 |J2", "centre of the arc in Y: 2"),
        ("a.ngc", SPLINES, "|#5420", "X of the program; 5 after this line"),
        ("a.nc", f"{FANUC}G41 D1 X3 F500\nG3 X9 R6\nG40 X20\nM30\n%\n", "|R6", "radius of the arc: 6"),
        ("a.nc", f"{FANUC}G1 X3 F500,R2\nY9\nM30\n%\n", ",|R2", "rounding of the corner, radius 2"),
        ("a.nc", f"{FANUC}G1 X3 F500\nG67\nM30\n%\n", "|G67", "ends the calls of the macro of G66"),
        ("a.h", f"{KLARTEXT}3 CR X+9 Y+0 R+8 DR- F500\n4 M30\n5 END PGM T MM\n", "|R+8", "radius of the arc: 8"),
        ("a.h", f"{KLARTEXT}3 TRANS DATUM AXIS X+9\n4 M30\n5 END PGM T MM\n", "|AXIS", "shifts the datum to X Y Z"),
        ("a.h", "BEGIN PGM T MM\nBLK FORM 0.2 X+9 Y+9 Z+0\nEND PGM T MM\n", "0|.2", "the stock, a box: the corner"),
        (
            "a.mpf",
            f"{SIEMENS}UP(2)\nM30\n%_N_UP_SPF\nPROC UP(REAL A1, VAR INT LAST)\nG1 X=A1 F500\nRET\n",
            "|LAST)",
            "value of the subprogram, INT: its call gives it",
        ),
    ],
)
def test_a_word_is_told_as_its_block_has_it(
    inspector: Inspector, tmp_path: Path, name: str, text: str, place: str, said: str
) -> None:
    """All meanings of a letter in its language were listed, or none was told."""
    assert ask(inspector, tmp_path / name, text, place).startswith(said)


def test_a_word_that_fits_the_place_is_completed_alone() -> None:
    """FUNCTION and FN stood before F of a feed rate; no tool was offered behind H."""
    offered = {}
    for name, text in (("a.h", f"{KLARTEXT}L X+10 F"), ("a.nc", f"{FANUC}G43 Z9 H")):
        outline, last = Outline(lines := text.split("\n"), "auto", text.encode(), name), len(lines) - 1
        offered[name] = [one.word for one in complete_word(outline, last, len(lines[-1]), {"1": "", "12": ""})]
    assert offered == {"a.h": ["F", "FMAX", "F AUTO", "FU"], "a.nc": ["1", "12"]}


@pytest.mark.parametrize(
    ("name", "text", "offered"),
    [
        (
            "a.h",
            f"{KLARTEXT}3 FUNCTION ",
            ["FUNCTION TCPM", "FUNCTION DWELL", "FUNCTION MODE MILL", "FUNCTION RESET TCPM"],
        ),
        ("a.nc", f"{FANUC}T", []),
        ("a.nc", f"{FANUC}#1=T", ["TAN"]),
        ("a.ngc", f"{NGC}o100 c", ["CALL", "CONTINUE"]),
        ("a.h", f'{KLARTEXT}LBL "HOLE"\nLBL 0\nCALL LBL ', ['"HOLE"']),
        ("a.h", f'{KLARTEXT}LBL "HOLE"\nLBL 0\nCALL LBL "H', ['"HOLE"']),
        ("a.h", f"{KLARTEXT}LBL 7\nLBL 0\nFN 9: IF +Q1 EQU +1 GOTO LBL ", ["7"]),
        ("a.h", f"{KLARTEXT}CYCL CALL ", []),
        ("a.mpf", f"{SIEMENS}DEF REAL DEPTH=2\nR1=3\nG1 Z=", ["DEPTH", "R1", "AC(", "IC("]),
        ("a.mpf", f"{SIEMENS}G0 C=", ["AC(", "IC(", "DC("]),
        ("a.mpf", f'{SIEMENS}R1=3\nMSG("Z=', []),
        ("a.mpf", f"{SIEMENS}R1=3 ; R1=", []),
    ],
)
def test_what_may_follow_is_completed(name: str, text: str, offered: list[str]) -> None:
    """Nothing was offered behind FUNCTION, and TAN for the number of a tool."""
    lines = text.split("\n")
    outline = Outline(lines, "auto", text.encode(), name)
    found = {one.word for one in complete_word(outline, len(lines) - 1, len(lines[-1]), {})}
    assert set(offered) <= found and bool(found) == bool(offered)


@pytest.mark.parametrize("name", ["two_faces.h", "two_faces.mpf", "two_faces_fanuc.nc"])
def test_no_operation_of_a_tool_begins_behind_the_end(name: str) -> None:
    """The remark above LBL 10 was an operation of tool 1."""
    text = (Path(__file__).parents[2] / "gcode_samples" / name).read_text("utf-8")
    lines = text.split("\n")
    end = next(k for k, line in enumerate(lines) if "M30" in line)
    symbols = Outline(lines, "auto", text.encode(), name).list_symbols()
    tools = [one for top in symbols for one in (top, *(top.children or ())) if one.kind == lsp.SymbolKind.Class]
    assert tools
    for tool in tools:
        assert tool.children and all(one.range.start.line <= end for one in tool.children)


@pytest.mark.parametrize(
    ("name", "head", "lines", "end"),
    [
        ("a.ngc", NGC, ("#1=[2+3]*2", "o1 if [#1 GT 2]"), "M2\n"),
        ("a.nc", FANUC, ("#101=[2.+3.]*2.", "IF[#1GT2]GOTO5"), "M30\n%\n"),
        ("a.mpf", SIEMENS, ('CYCLE800(0,"",10,57)', "FOR PASS = 1 TO 4"), "M30\n"),
        ("a.h", KLARTEXT, ("PLANE SPATIAL SPA+0", "CALL LBL 1 REP 3"), "4 M30\n5 END PGM T MM\n"),
        ("a.apt", "PARTNO T\nUNITS/MM\n", ("CYCLE/DRILL,DEPTH,5", "GOTO/1,0,60"), "FINI\n"),
    ],
)
def test_every_beginning_of_a_line_is_checked(
    inspector: Inspector, tmp_path: Path, name: str, head: str, lines: tuple[str, ...], end: str
) -> None:
    """An editor checks what is typed: each answer comes, and each place that it names is one of the text."""
    path, n_found = tmp_path / name, 0
    check(inspector, path, "")
    for line in lines:
        for length in range(1, len(line) + 1):
            text = f"{head}{line[:length]}\n{end}"
            rows = text.split("\n")
            for item in inspector.check(path, {path: text}, NEVER, only_cause=True).findings:
                assert item.column is None or item.column >= 1, (text, item)
                assert item.line is None or item.file or 1 <= item.line <= len(rows), (text, item)
                place = find_range(item, rows)
                begin, last = place.start, place.end
                assert (begin.line, begin.character) <= (last.line, last.character), (text, item)
                assert last.line < len(rows) and last.character <= len(rows[last.line]), (text, item)
                n_found += 1
    assert n_found > sum(map(len, lines)) // 2


def test_a_call_is_not_led_to_a_label_that_is_wrong_there(inspector: Inspector, tmp_path: Path) -> None:
    """LBL 10 stands behind a remark: LBL 1, which is nearly its number, shifts the datum in the tilted plane."""
    text = (SAMPLES / "two_faces.h").read_text("utf-8").replace("MM ABOVE IT\n53 LBL 10", "MM ABOVE IT 53 LBL 10")
    setup = (SAMPLES / "two_faces.h.toml").read_text("utf-8")
    found = check(inspector, tmp_path / "two_faces.h", text, setup)
    (item,) = (one for one in found.findings if one.severity == "error")
    assert (item.code, item.line) == ("VP023", 37)
    assert not find_fixes(inspector, found, item, {found.path: text}, NEVER)


@pytest.mark.parametrize(
    ("name", "text", "said", "right"),
    [
        ("a.h", f"{KLARTEXT}3 L X+20 F500\n4 RND R30\n5 L Y+12\n6 M30\n7 END PGM T MM\n", "RND R12", ("R30", "R12")),
        ("b.h", f"{KLARTEXT}3 L X+20 F500\n4 CHF 30\n5 L Y+12\n6 M30\n7 END PGM T MM\n", "CHF 12", ("F 30", "F 12")),
        ("a.mpf", f"{SIEMENS}G1 X20 RND=30 F500\nY12\nM30\n", "RND=12", ("RND=30", "RND=12")),
        ("b.mpf", f"{SIEMENS}RNDM=30\nG1 X20 F500\nY12\nM30\n", "RNDM=12", ("RNDM=30", "RNDM=12")),
        ("a.nc", f"{FANUC}G20\nG1 X1.,R9. F5.\nY.5\nM30\n%\n", ",R0.5", (",R9.", ",R0.5")),
    ],
)
def test_a_corner_that_does_not_fit_names_the_largest_that_does(
    inspector: Inspector, tmp_path: Path, name: str, text: str, said: str, right: tuple[str, str]
) -> None:
    found = check(inspector, tmp_path / name, text)
    (item,) = (one for one in found.findings if one.severity == "error")
    assert item.code == "VP008"
    assert item.message.endswith(f"; write {said} or less")
    assert item.advice == ""
    fixes = find_fixes(inspector, found, item, {tmp_path / name: text}, NEVER)
    made = [f"{fix.text[: fix.begin]}{fix.new}{fix.text[fix.end :]}" for fix in fixes if fix.text is not None]
    assert made == [text.replace(*right)]


@pytest.mark.parametrize(
    ("start", "cut", "said", "word"),
    [
        ("", "3 L X+10 Y+2 A+6 C+12 F600\n", "write M128 before", "3 L X+10 Y+2 A+6 C+12 F600"),
        (
            "",
            "3 LN X+10 Y+2 TX+0 TY+0.6 TZ+0.8 F600\n3 LN X+9 TX+0 TY+0.6 TZ+0.8\n",
            "LN with TX TY TZ needs M128",
            "TX",
        ),
        ("3 L A+10 FMAX\n", "3 LN X+10 Y+2 TX+0 TY+0.6 TZ+0.8 F600\n", "", "TX"),  # M128 before the tilt may be meant
    ],
)
def test_a_cut_that_needs_m128_is_offered_it(
    inspector: Inspector, tmp_path: Path, start: str, cut: str, said: str, word: str
) -> None:
    text = f"{KLARTEXT}{start}{cut}4 M30\n5 END PGM T MM\n"
    message, marked, made = look(inspector, tmp_path / "a.h", text, SETUP.replace("60", "160"))
    assert said in message and marked.startswith(word)
    assert [new for _path, new, _settles in made.values()] == [text.replace(cut, f"M128\n{cut}")] * bool(said)


@pytest.mark.parametrize("place", ["A=DC({})", "A=AC( {} )", "A={}"])
def test_a_lost_point_of_a_rotary_word_has_its_edit(inspector: Inspector, tmp_path: Path, place: str) -> None:
    """None was offered within DC() and AC()."""
    cuts = "".join(f"G1 X{at} {place.format(80 if at == 3 else 8)} F500\n" for at in range(6))
    text, wrong, right = f"{SIEMENS}TRAORI\n{cuts}M30\n", place.format(80), place.format(8)
    message, word, made = look(inspector, tmp_path / "a.mpf", text)
    assert "is A8 meant?" in message and word == wrong
    assert made == {
        f"Write {right} in place of {wrong} in line 9": (tmp_path / "a.mpf", text.replace(wrong, right), False)
    }


@pytest.mark.parametrize(
    ("before", "meant"), [("G0 X0. Y0. Z50. A0. C0.", "X24."), ("G0 X0 Y0 Z50 A0 C0", "X24"), ("G0 X0. Y0.\nX5", "X24")]
)
def test_a_comma_behind_a_number_is_a_point_where_its_address_has_points(
    inspector: Inspector, tmp_path: Path, before: str, meant: str
) -> None:
    text = f"%\nO1\nG21 G90 G94 G17 G54\n{before}\nG1 X24, F500.\nM30\n%\n"
    found = check(inspector, tmp_path / "a.nc", text)
    item = next(one for one in found.findings if one.line == text[: text.index("24,")].count("\n") + 1)
    assert item.message == f"X24,: a comma after a number; did you mean {meant}?"


def test_files_that_call_each_other_are_searched_once(tmp_path: Path) -> None:
    """All ways through 12 files would take longer than anybody waits."""
    names = [tmp_path / f"s{number}.ngc" for number in range(12)]
    calls = "".join(f"o<{name.stem}> call\n" for name in names)
    texts = {name: f"o<{name.stem}> sub\n{calls}o<{name.stem}> endsub\n" for name in names}
    assert Callers().find(names[0], texts) is None
    main = tmp_path / "z.ngc"
    assert Callers().find(names[0], {**texts, main: "o<s11> call\nM2\n"}) == main


@pytest.mark.parametrize(
    ("out", "title"),
    [("G0 Z60\nTRAFOOF", "Write G0 A0 C0 before line 12"), ("TRAFOOF", ""), ("TRAFOOF\nG0 X0", "")],
)
def test_the_table_is_turned_back_only_with_the_tool_out_of_the_part(
    inspector: Inspector, tmp_path: Path, out: str, title: str
) -> None:
    """And no key that applies the preferred edit turns it."""
    head = "G17 G54 G90 G94 G710\nT1 D1\nM6\nS1000 M3\nG0 A0 C0\nTRAORI\nG0 X0 Y0 Z40\nG0 X10 Y0 Z20 A-25 C0\n"
    text = f"{head}G1 Z-8 F300\n{out}\nG1 X-150 Y-100 Z-8\nG0 Z60\nM30\n"
    found = check(inspector, tmp_path / "a.mpf", text, SETUP.replace("60", "40"))
    fixes = [fix for item in found.findings for fix in find_fixes(inspector, found, item, {found.path: text}, NEVER)]
    turning = {fix.title.partition(" (")[0]: fix.settles for fix in fixes if "A0 C0" in fix.title}
    assert turning == ({title: False} if title else {})


def test_less_tilt_of_a_vector_is_one_edit_of_its_components(inspector: Inspector, tmp_path: Path) -> None:
    """The remedy was an angle, which no line of the program has: there was no edit."""
    words = "A3=0.3 B3=0.15 C3=-0.942072"
    text = (
        "G17 G71 G90\nT1 D1\nM6\nTRAORI\nG54\nS8000 M3\nG0 X0 Y0 Z60 A3=0 B3=0 C3=1\nG1 Z20 F500\n"
        f"X10 Y4 Z8 {words}\nX10 Y4 Z50 A3=0 B3=0 C3=1\nM30\n"
    )
    setup = "[wcs]\nG54 = [0, -12, 80]\n[tools]\n1 = { length = 80, diameter = 8 }\n"
    path = tmp_path / "a.mpf"
    found = check(inspector, path, text, setup)
    (item,) = found.findings
    (fix,) = (one for one in find_fixes(inspector, found, item, {path: text}, NEVER) if words in one.title)
    assert "another tool axis" in fix.title
    assert not fix.settles, "the tool cuts another side"
    begin, end = text.split(words)
    changed = apply_places(fix)
    assert changed.startswith(begin)
    assert changed.endswith(end)
    assert [one for one in check(inspector, path, changed, setup).findings if one.severity == "error"] == []


@pytest.mark.parametrize("rest", ["G0 Z60\n", 'CYCLE800(0,"",0,57,0,10,5,25,0,0,0,0,0,-1)\nG0 X5\n'])
@pytest.mark.parametrize("beside", ["", "FOR PASS=1 TO 3\nG0 X=PASS*10 Y10\nCYCLE82(5,0,2,-3,,0.5)\nENDFOR\n"])
def test_mcall_is_not_ended_behind_lines_that_may_be_no_places(
    inspector: Inspector, tmp_path: Path, beside: str, rest: str
) -> None:
    begin = f"{SIEMENS}F200\nMCALL CYCLE82(5,0,2,-6,,0.5)\nHOLES1(0,0,0,10,10,4)\n"
    message, _marked, made = look(inspector, tmp_path / "a.mpf", f"{begin}{beside}{rest}MCALL\nCYCLE800()\nM30\n")
    assert ("before line 8 if line 9 is no place of it" in message) == bool(beside)
    assert (f"{begin}MCALL\n{beside}{rest}MCALL\nCYCLE800()\nM30\n", not beside) in [one[1:] for one in made.values()]
    assert any(preferred for _path, _text, preferred in made.values()) == (not beside)


@pytest.mark.parametrize(
    ("name", "lines", "changes"),
    [
        ("a.nc", "G1 X10. Y0 Z5. F500\nG3 X5. Y5. I5. J0.", {"Write I-5": ("I5.", "I-5."),
                                                             "Exchange I and J": ("I5. J0.", "I0. J5.")}),
        ("a.mpf", "G1 X10 Y0 Z5 F500\nG3 X5 Y5 I5", {"Write I-5": ("I5", "I-5"), "Exchange": ("I5", "J5")}),
        ("a.mpf", "G1 Z5 F500\nCYCLE83(10,0,2,22,,-5,,2,0,0,1,0)", {"Write -22": ("22", "-22")}),
        # not RTP, which has the same number; all digits
        ("a.mpf", "G1 Z5 F500\nMCALL CYCLE82(5.0,0,2,5,,0)\nX9\nMCALL", {"Write -5": (",5", ",-5")}),
        ("a.mpf", "G1 Z5 F500\nMCALL CYCLE81(22,0,2, 22)\nX9\nMCALL", {"Write -22": (" 22", " -22")}),
        ("a.mpf", "R1=5 G1 Z5 F500\nMCALL CYCLE81(5,0,2,R1)\nX9\nMCALL", {}),
        ("a.mpf", "G1 Z5 F500\nCYCLE81(10,0,2,12.34567)", {"Write -12.34567": ("12.3", "-12.3")}),
        ("a.h", "3 CYCL DEF 200 D Q200=2 Q201=12.34567 Q206=9 Q202=5 Q210=0 Q203=0 Q204=2 Q211=0\n4 CYCL CALL",
         {"Write Q201=-12.34567": ("=12", "=-12")}),
        ("a.nc", "G98 G81 X5. Y5. Z12.34567 R3. F100.\nG80", {"Write Z-12.34567": ("Z12", "Z-12")}),
        ("a.nc", "G99 G83 X5. Y5. Z22. R3. Q4. F100.\nG80", {"Write Z-22": ("Z22.", "Z-22.")}),
        ("a.h", "3 L X+0 Y+0 F500\n4 CR X+10 Y+0 R+5 F500", {"Write R+5 DR+": ("R+5", "R+5 DR+"),
                                                              "Write R+5 DR-": ("R+5", "R+5 DR-")}),
        ("a.h", "3 L X+0 F500\n4 CC X+5 Y+0\n5 C X+10 Y+0 F500", {"Write Y+0 DR+": ("10 Y+0", "10 Y+0 DR+"),
                                                     "Write Y+0 DR-": ("10 Y+0", "10 Y+0 DR-")}),
        ("a.nc", "G55 G0 X1. Y1.\nG1 Z5. F500", {"Write G54": ("G55", "G54")}),
    ],
)  # fmt: skip
def test_an_answer_in_a_message_is_an_edit(
    inspector: Inspector, tmp_path: Path, name: str, lines: str, changes: dict[str, tuple[str, str]]
) -> None:
    """It had to be typed."""
    head, end = HEADS[f".{name.partition('.')[2]}"]
    text = f"{head}{lines}\n{end}"
    found = check(inspector, tmp_path / name, text, SETUP)
    item = next(one for one in found.findings if one.severity == "error")
    made = {
        fix.title: (apply_places(fix), fix.settles)
        for fix in find_fixes(inspector, found, item, {tmp_path / name: text}, NEVER)
        if fix.path == tmp_path / name
    }
    assert len(made) == len(changes)
    for (title, change), (each, (new, settles)) in zip(changes.items(), made.items(), strict=True):
        assert each.startswith(title)
        assert new == text.replace(lines, lines.replace(*change, 1))
        assert settles == (len(changes) == 1 and title.startswith(("Write -", "Write Q")))
