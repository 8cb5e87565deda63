"""`verne-post machined` with a stock: what rows cut, what they touch, and what is left for the next set-up."""

import re
from contextlib import nullcontext
from pathlib import Path

import pytest

#: A slot of 60 mm, a rapid back through it (line 7), and one through uncut stock (line 11).
SLOT = (
    "G21 G90 G61.1\nT1 M6 G43 H1\nG0 X-45 Y-20 Z20 A0 C0\n(first slot)\nG0 Z-6\nG1 X45 F6000\nG0 X-45\nG0 Z20\nG0 Y20\n"
    "G0 Z-6\nG0 X45\nM2\n"
)
PLACE = ("--tool-table", "t.tbl", "--tool-shapes", "s.toml", "--wcs", "G54=0,0,60")
BOX = ("--stock", "G54=-30,-40,-60,30,40,0")


@pytest.fixture
def slot(tmp_path, monkeypatch, run):
    """A folder with the program and its rows."""
    monkeypatch.chdir(tmp_path)
    Path("slot.nc").write_text(SLOT, encoding="utf-8")
    Path("t.tbl").write_text("T1 P1 Z100 D12 ;\n", encoding="utf-8")
    Path("s.toml").write_text(
        "[tool.1]\ncutter = { diameter = 12.0, length = 25.0 }\nholder = { diameter = 40.0 }\n", encoding="utf-8"
    )
    assert run("convert", "slot.nc", *PLACE, "-o", "a.csv", "--quiet").code == 0

    def machined(*words):
        return run("machined", "a.csv", "--against", "slot.nc", *PLACE, *words)

    return machined


def test_rows_cut_the_stock_line_by_line_and_leave_the_rest_for_the_next_run(slot, run):
    done = slot(*BOX, "--stock-left", "left.npz@G54")
    assert done.code == 1
    assert "slot.nc:11: VP216 error: the cutter runs into the stock in a rapid traverse: the contact begins" in done.err
    assert re.search(r"material lies up to 5\.9\d\d mm inside it", done.err)
    assert "slot.nc:7:" not in done.err
    # 12 mm wide, 6 mm deep, 60 mm long
    for text in (
        "8640.0 of 288000.0 mm3 cut, 279360.0 left; 0.000 of 0.9",
        "tool 1: 8640.0 mm3",
        "6: 4320.0 mm3, 11: 4320.0 mm3",
    ):
        assert text in done.err + done.out
    # the same program again finds its way: nothing to cut; walls are as near as they are
    for name, left in (("left.npz", "left.stl"), ("left.stl", "last.npz")):
        again = slot("--stock-from", f"{name}@G54", "--stock-left", f"{left}@G54")
        assert "0.0 of 279360.0 mm3 cut" in again.err + again.out
        assert " error: " not in again.err
        assert again.code == 0
    assert Path("left.stl").stat().st_size < 20_000  # boxes of equal height are one
    # the same stock in check
    checked = run("check", "slot.nc", *PLACE, *BOX)
    assert [
        line.split(":")[1]
        for line in (checked.out + checked.err).splitlines()
        if "VP216" in line and line.startswith("slot.nc:")
    ] == ["11"]


def test_a_check_says_how_far_the_stock_is_cut(slot, run, monkeypatch):
    told = []
    monkeypatch.setattr(
        "verne_post.cli.check.show_progress", lambda *_words, **_flags: nullcontext(lambda *now: told.append(now))
    )
    assert run("check", "slot.nc", *PLACE, *BOX).code == 1
    done, total = zip(*((now[1], now[2]) for now in told if now[0] == "cutting the stock"), strict=True)
    assert list(done) == sorted(done)
    assert len(set(done)) > 3
    assert done[0] == 0
    assert set(total) == {max(done) + 1}


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ((), "a stock (--stock, --stock-from), or several"),
        (("--stock-from", "left.npz"), "expected a file and its system, as in part.stl@G54"),
        (("--stock-from", "program"), "the program defines no stock"),
        ((*BOX, "--stock-from", "program"), "--stock and --stock-from exclude each other"),
        ((*BOX, "--stock-left", "left.ply@G54"), "expected a name that ends in .stl or .npz"),
        ((*BOX, "--csv", "worst.csv"), "name it with --nominal"),
    ],
)
def test_what_cannot_be_meant_is_refused(slot, words, text):
    done = slot(*words)
    assert done.code == 2
    assert text in done.err


def test_the_stock_of_the_program_itself_is_cut(slot, run):
    """BLK FORM in Klartext: the same slot."""
    Path("slot.h").write_text(
        "BEGIN PGM S MM\nBLK FORM 0.1 Z X-30 Y-40 Z-60\nBLK FORM 0.2 X+30 Y+40 Z+0\nTOOL CALL 1 Z S1000\n"
        "L X-45 Y-20 Z+20 R0 FMAX\nL Z-6 FMAX\nL X+45 F6000\nL Z+20 FMAX\nEND PGM S MM\n",
        encoding="utf-8",
    )
    assert run("convert", "slot.h", *PLACE, "-o", "h.csv", "--quiet").code == 0
    done = run("machined", "h.csv", "--against", "slot.h", *PLACE, "--stock-from", "program")
    assert "4320.0 of 288000.0 mm3 cut" in done.err + done.out
    assert done.code == 0


def test_a_rapid_out_of_a_rounded_corner_is_clear_in_rows_too(slot, run):
    """The corner at X0 leaves 0.03 mm of the cut, through which the rapid begins; `check` allows it."""
    Path("slot.nc").write_text(
        "G21 G17 G90 G94 G64 P0.02\nT1 M6 G43 H1\nG0 A0 C0\nG0 X-50 Y0\nG0 Z20\nG1 Z-2 F1500\nG1 X0\nG0 Z20\nX-20\n"
        "Z-1\nZ40\nM2\n",
        encoding="utf-8",
    )
    assert run("convert", "slot.nc", *PLACE, "-o", "a.csv", "--quiet").code == 0
    assert run("check", "slot.nc", *PLACE, *BOX).code == 0
    done = slot(*BOX)
    assert "VP216" not in done.err
    assert done.code == 0


@pytest.mark.parametrize("command", [("check",), ("convert", "-o", "b.csv")])
def test_a_refused_program_says_that_its_cutter_was_a_line(slot, run, command):
    """A rapid through solid stock had a depth of 0.15 mm, and nothing said that no diameter was known."""
    words = (*command, "slot.nc", "--wcs", "G54=0,0,60", *BOX)
    thin = "the width of tool 1: without a diameter it is a line"
    bare = "shank and holder of tool 1: not among the tool shapes"
    depth = r"material lies up to ([\d.]+) mm inside it(.*)"
    Path("t.tbl").write_text("T1 P1 Z100 ;\n", encoding="utf-8")
    done = run(*words, "--tool-table", "t.tbl")
    said = done.out + done.err
    assert done.code == 1
    assert re.search(rf"refused: .*\n  NOT CHECKED: contact with fixtures: .*; {thin}; {bare}\n", said)
    found = re.search(depth, said)
    assert float(found[1]) < 0.2
    assert found[2] == " (tool 1 has no diameter: part of this material is 40.2 mm away from the cuts before)"
    Path("t.tbl").write_text("T1 P1 Z100 D12 ;\n", encoding="utf-8")
    done = run(*words, "--tool-table", "t.tbl")
    said = done.out + done.err
    assert "  NOT CHECKED: contact with fixtures: " in said
    assert thin not in said
    found = re.search(depth, said)
    assert float(found[1]) > 5.9
    assert found[2] == ""


def test_a_program_that_cannot_be_read_has_no_line_of_what_was_not_checked(slot, run):
    """Nothing of it was checked: the line would say that the rest was."""
    Path("bad.nc").write_text("G21 G90\nG0 X\nM2\n", encoding="utf-8")
    done = run("check", "bad.nc", *PLACE)
    assert done.code != 0
    assert "NOT CHECKED" not in done.out + done.err
