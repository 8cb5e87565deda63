"""What a message names settles what it says: tables, edges, fixtures that move with the part."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

MILLED = "G21 G90 G17 G94\nT1 M6\nS3000 M3\nG43 H1\nG54\nG0 X0 Y0 Z20\nG1 Z5 F600\nG0 X60\nG1 X90\nG0 Z50\nM30\n"
SETUP = "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = {{ length = 80, diameter = {} }}\n"
JAW = '[keep_out.left]\nmin = [20, -10, 0]\nmax = [40, 10, 36]\nsystem = "G54"\n'
EDGED = 'G17 G90 G94 G71\nT="MILL" D2\nM6\nS3000 M3\nG54\nG0 X0 Y0 Z20\nG1 Z5 F{}\nG1 X30\nG0 Z50\nM30\n'


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Write a program and its set-up into the current folder."""
    monkeypatch.chdir(tmp_path)

    def write_both(name: str, program: str, setup: str) -> None:
        Path(name).write_text(program)
        Path(f"{name}.toml").write_text(setup)

    return write_both


def test_a_second_edge_is_entered_as_a_tool_of_its_own(write: Callable[..., None], run: Callable[..., Any]) -> None:
    write("d.mpf", EDGED.format(300), SETUP.format(10).replace("1 =", '"MILL" ='))
    refused = run("check", "d.mpf")
    way = 'write T="MILL_D2", and M6, where edge 2 is meant; or write D1'
    assert refused.code == 2
    assert way in refused.err + refused.out
    assert way in run("setup", "d.mpf", "--setup", "none", "-o", "-").out.splitlines()[1]
    write("d.mpf", EDGED.format(300).replace('MILL" D2', 'MILL_D2"'), SETUP.format(10).replace("1 =", '"MILL_D2" ='))
    assert run("check", "d.mpf").code == 0


def test_explain_has_the_finding_of_a_line_that_takes_too_long(
    write: Callable[..., None], run: Callable[..., Any]
) -> None:
    write("f.mpf", EDGED.format(0.001).replace(" D2", ""), SETUP.format(10).replace("1 =", '"MILL" ='))
    shown = run("explain", "f.mpf:8").out
    assert "VP035 error: at its feed rates the program takes" in shown
    assert "VP035, remedy: Correct F or the dwell." in shown
    assert "VP035" not in run("explain", "f.mpf:7").out  # not the longest line


def test_no_place_parts_what_moves_together(write: Callable[..., None], run: Callable[..., Any]) -> None:
    write("c.nc", MILLED, SETUP.format(10) + JAW)
    told = run("fit", "c.nc")
    assert told.code == 1
    assert "in line 8 the tool touches what moves with the part, and no work offset helps" in told.out
    assert "Searched:" not in told.out
    assert json.loads(run("fit", "c.nc", "--json").out)["carried_lines"] == [8]
    write("c.nc", MILLED, SETUP.format(10) + JAW.replace('"G54"', '"table"').replace("36", "96"))
    assert run("fit", "c.nc").code == 0  # as the text says, where the fixture stays


@pytest.mark.parametrize(("distance", "asked"), [(0, ""), (2, "; it must stay 2 mm away")])
def test_a_contact_is_told_with_the_height_that_clears_it(
    write: Callable[..., None], run: Callable[..., Any], distance: int, asked: str
) -> None:
    write("c.nc", MILLED, SETUP.format(10) + f"{JAW}distance_mm = {distance}\n")
    refused = run("check", "c.nc").out
    height = f"{36.2 + distance:g}"
    assert f"VP215 error: the cutter goes 14.988 mm into fixture 'left'{asked}\n" in refused
    assert f"a retract before it: the line begun at Z {height} and ended at Z {height} mm" in refused
    write(
        "c.nc",
        MILLED.replace("G0 X60", f"G0 Z{height}\nG0 X60\nG1 Z5"),
        SETUP.format(10) + JAW + f"distance_mm = {distance}\n",
    )
    assert run("check", "c.nc").code == 0


@pytest.mark.parametrize("moves", ["G0 Z40\nX30\nZ6", "G0 X60\nG0 X30 Z20\nG0 X28"])
def test_a_retract_is_not_offered_where_the_contact_would_stay(
    moves: str, write: Callable[..., None], run: Callable[..., Any]
) -> None:
    """Of a plunge into the jaw, and of a contact that goes on in the next line."""
    write("c.nc", MILLED.replace("G0 X60", moves).replace("G1 X90", ""), SETUP.format(10) + JAW)
    refused = run("check", "c.nc").out
    assert "VP215 error: the cutter" in refused
    assert "a retract before it" not in refused


def test_a_diameter_that_is_not_known_is_not_invented(write: Callable[..., None], run: Callable[..., Any]) -> None:
    """Nor is anything told that would follow from its width, such as a slot that is too narrow."""
    slot = MILLED.replace("G0 X60\n", "G41 D1 G1 X0 Y20\nX30\nY20.4\nX0\nG40 Y60\n")
    write("n.nc", slot, SETUP.format(0))
    assert "G41 (tool centre left of the contour, no diameter is known: D1, tool 1)" in run("explain", "n.nc:9").out
    refused = run("check", "n.nc").out
    assert "refused: 1 error" in refused
    assert "VP026" not in refused


@pytest.mark.parametrize(
    ("setup", "told"),
    [
        ("[fixtures]\nleft = 3\n", "fixtures: this is no option of a set-up; a fixture is a table [keep_out.NAME]"),
        ("[clamp.left]\nmin = 1\n", "clamp: this is no option of a set-up; a fixture is a table [keep_out.NAME]"),
        ("holder = 40\n", "holder: this is no option of a set-up; shank and holder are in a file of their own: write"),
        ("[tools]\n1 = { length = 80, holder = 40 }\n", "tools.1.holder is not a key of a set-up; shank and holder"),
    ],
)
def test_other_names_of_fixtures_and_holders_are_known(
    write: Callable[..., None], run: Callable[..., Any], setup: str, told: str
) -> None:
    write("c.nc", MILLED, setup)
    refused = run("check", "c.nc")
    assert told in refused.out + refused.err


def test_a_place_is_written_where_the_message_says(write: Callable[..., None], run: Callable[..., Any]) -> None:
    """Under [wcs], which is there: a second wcs.G55 on top would be no TOML."""
    write("g.nc", MILLED.replace("G54", "G55"), SETUP.format(10))
    assert "Write G55 = [x, y, z] under [wcs] of g.nc.toml" in run("check", "g.nc").out
    write("g.nc", MILLED.replace("G54", "G55"), SETUP.format(10).replace("[wcs]", "[wcs]\nG55 = [0, 0, 60]"))
    assert run("check", "g.nc").code == 0


def test_a_tool_that_is_only_selected_is_called_by_its_name(
    write: Callable[..., None], run: Callable[..., Any]
) -> None:
    """The set-up counts tools without a number from 100001 on, which nobody has written."""
    named = (
        'split_at_stops = true\n[wcs]\nG54 = [0, 0, 60]\n[tools]\n"FACE" = { length = 60 }\n"DRILL" = { length = 80 }\n'
    )
    cut = "G1 X10 F200 D0\nZ100\nG0 Z150\n"
    write("f.mpf", f'G17 G90 G54 G71\nT="FACE"\nS3000 M3\nG0 X0 Y0 Z150 A0 C0\n{cut}M30\n', named)
    told = run("check", "f.mpf").out
    assert 'T="FACE" only selects the tool' in told
    assert 'the set-up gives tool "FACE" 60 mm' in told
    write("g.mpf", f'G17 G90 G54 G71\nS3000 M3\nG0 X0 Y0 Z150 A0 C0 D1\n{cut}T="DRILL" M6\nS900 M3\n{cut}M30\n', named)
    assert "10000" not in told + run("check", "g.mpf").out


@pytest.mark.parametrize("line", ["G43 H1 Z50. T2", "T2 G43 H1 Z50.", "G43 H1 Z50.\nT2"])
def test_the_next_tool_beside_g43_lacks_its_length_too(
    line: str, write: Callable[..., None], run: Callable[..., Any]
) -> None:
    second = "T2 M6\nG0 X10. Y0\nG43 H2 Z50.\nG1 Z-1. F200.\nG0 Z50.\nM30\n"
    program = f"G90 G54 G17 G21 G49\nT1 M6\nG0 X0 Y0 A0 C0 S3000 M3\n{line}\nG1 Z-1. F200.\nG0 Z50.\n{second}"
    for set_up in ("", "[tools]\n3 = { length = 80 }\n"):
        write("t.nc", program, set_up)
        told = run("check", "t.nc", "--wcs", "G54=0,0,60").out
        assert "VP012 error: tool 1 and tool 2:" in told
        assert "--tool-length" not in told


def test_a_retract_is_not_cured_by_a_retract(write: Callable[..., None], run: Callable[..., Any]) -> None:
    """Of a tilted tool: along Z of the part it goes back through the wall of its slot, and so would one before it."""
    head = "G21 G17 G90 G94\nT1 M6\nG43.4 H1\nG0 X40 Y0 Z60 A-30 C0\nS900 M3\nG1 Z-10 F600\nX0\n{}\nM2\n"
    setup = SETUP.format(10) + '[stock]\nmin = [-30, -30, -20]\nmax = [30, 30, 0]\nsystem = "G54"\n'
    write("r.nc", head.format("G0 Z60"), setup)
    shown = run("explain", "r.nc:8").out
    assert "VP216 error: the cutter runs into the stock in a rapid traverse" in shown
    assert "a retract before it" not in shown
    write("r.nc", head.format("G0 X-40"), setup)
    assert "a retract before it" in run("explain", "r.nc:8").out


WING = "UNITS/MM\nMULTAX/ON\nLOADTL/5\nSPINDL/9000,RPM,CLW\nRAPID\nGOTO/-30,0,5,0,0,1\nFEDRAT/600,MMPM\n"
BLADE = 'G17 G54 G90 G94 G710\nT="B" D1\nM6\nS900 M3\nTRAORI\nG0 X-30 Y0 Z30 A0 C0\nG1 X0 Y2.5 Z6.2 A10 C4 F800\n'


@pytest.mark.parametrize(
    ("name", "machine", "program", "said"),
    [
        ("w.cls", "hexapod", f"{WING}GOTO/-15,1,0.5,0.087156,0,-0.996195\nFINI\n", "k 0.996195 in line 8"),
        (
            "p.cls",
            "ac_trunnion",
            f"{WING}GOTO/20,0,0,0,0.173648,-0.984808\nGOTO/0,0,0,0,0,1\nGOTO/20,20,60,0,0.173648,-0.984808\nFINI\n",
            "k 0.984808 in lines 8 and 10",
        ),
        ("b.mpf", "verne", f"{BLADE}X10 Y2 Z6 A3=0.2 B3=0 C3=-0.98\nG0 Z40\nM30\n", "C3 0.98 in line 8"),
        # tilts that the machine has not: 70 degrees, and 100 degrees, which the other sign makes 80
        ("f.cls", "hexapod", f"{WING}GOTO/-15,1,0.5,0.939693,0,0.342020\nFINI\n", ""),
        ("g.cls", "hexapod", f"{WING}GOTO/-15,1,0.5,0.984808,0,-0.173648\nFINI\n", ""),
    ],
)
def test_a_flipped_tool_axis_is_named_first(
    name: str, machine: str, program: str, said: str, write: Callable[..., None], run: Callable[..., Any]
) -> None:
    """Less tilt, or four angles of struts, hid it."""
    write(name, program, '[wcs]\nG54 = [0, 0, 100]\n[tools]\n5 = { length = 80 }\n"B" = { length = 85 }\n')
    told = run("check", name, "--machine", machine).out
    assert "refused: 1 error" in told
    tried = [line.strip() for line in told.splitlines() if "tried:" in line]
    assert (tried == [f"= tried: within limits with {said}: is the sign wrong?"]) == bool(said)
    assert ("is the sign wrong?" in told) == bool(said)
    line = next(number for number, text in enumerate(program.splitlines(), start=1) if f"{name}:{number}: " in told)
    shown = run("explain", f"{name}:{line}", "--machine", machine).out
    assert (f"within limits with {said}: is the sign wrong?" in shown) == bool(said)


def test_no_branch_is_offered_that_turns_an_axis_far_within_a_feed_line(
    write: Callable[..., None], run: Callable[..., Any]
) -> None:
    """With B40 C-165 before and B-15 C-170 there, C turned by 175 degrees within one feed line."""
    moves = "L X-10 Y+0 Z+0.5 B+5 C+0 F1200\nL X+0 Y+1 Z+1 B+10 C+5\nL X+10 Y+2 Z+0.5 B+15 C+10"
    head = "BEGIN PGM P MM\nTOOL CALL 5 Z S9000\nM3\nL Z+80 R0 FMAX\nL B+0 C+0 R0 FMAX\nM128\nL X-20 Y+0 Z+0 FMAX"
    end = "L X+20 Y+3 Z+0 B-40 C+15\nL Z+60 FMAX\nL B+0 C+0 FMAX\nM129\nM30\nEND PGM P MM\n"
    write("p.h", f"{head}\n{moves}\n{end}", SETUP.format(6).replace("1 =", "5 ="))
    refused = run("check", "p.h", "--machine", "b_head_c_table").out
    assert "instead of B -40, tip and C as they are" in refused
    assert "the other rotary solution" not in refused
