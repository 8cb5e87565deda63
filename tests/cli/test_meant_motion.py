"""A motion that is refused because the table was left turned: the words that turn it back, and no other place."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

SETUP = ("--machine", "ac_trunnion", "--tool-length", "80", "--wcs", "G54=0,0,60")
SWIVELLED = """N10 G17 G90 G54 G71
N20 T="DRILL" M6
N30 S3000 M3
N40 CYCLE800(1,"TC1",0,57,0,-30,-10,90,0,0,0,0,0,-1,100,1)
N50 G0 X0 Y0
N60 Z20 D1
N70 G1 Z-1 F200
N80 G0 Z50
N90 CYCLE800()
N100 G0 X-20 Y-20
N110 Z10
N120 MCALL CYCLE81(5,0,2,-10)
N130 X-20 Y-20
N140 MCALL
N150 G0 Z50
N160 M30
"""
PLANE = """0 BEGIN PGM P MM
1 TOOL CALL 1 Z S3000
2 L X0 Y0 Z+200 A0 C0 R0 FMAX M3
3 CYCL DEF 7.0 DATUM SHIFT
4 CYCL DEF 7.1 Y-30
5 CYCL DEF 7.2 Z-10
6 PLANE SPATIAL SPA+90 SPB+0 SPC+0 TURN FMAX
7 L X0 Y0 R0 FMAX
8 L Z20 R0 FMAX
9 L Z-1 R0 F200
10 L Z+50 R0 FMAX
11 PLANE RESET STAY
12 L X-20 Y-20 R0 FMAX
13 L Z+10 R0 FMAX
14 L Z-10 R0 F200
15 L Z+50 R0 FMAX
16 M30
17 END PGM P MM
"""
G69 = """G90 G54 G17 G21
T1 M6
S3000 M3
G0 G43 H1 X0 Y0 Z200 A0 C0
G68.2 X0 Y-30 Z-10 I0 J90 K0
G53.1
G0 X0 Y0
G1 Z-1 F200
G0 Z50
G69
G0 X-20 Y-20
Z10
G1 Z-10
G0 Z50
M30
"""


def _check(
    run: Callable[..., Any], name: str, program: str, *options: str, setup: tuple[str, ...] = SETUP
) -> list[Any]:
    Path(name).write_text(program)
    shown = json.loads(run("check", name, *setup, *options, "--output-format", "json").out)
    return [item for item in shown["programs"][0]["findings"] if item["severity"] == "error"]


@pytest.fixture(autouse=True)
def _work_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("name", "program", "words", "line", "left"),
    [
        ("s.mpf", SWIVELLED, "G0 A0 C0", 10, "CYCLE800() in line 9"),
        ("p.h", PLANE, "L A0 C0 R0 FMAX", 13, "PLANE RESET in line 12"),
        ("g.nc", G69, "G0 A0 C0", 11, "G69 in line 10"),
    ],
)
def test_the_table_is_turned_back_before_the_part_is_moved(
    name: str, program: str, words: str, line: int, left: str, run: Callable[..., Any]
) -> None:
    options = ("--dialect", "fanuc") if name == "g.nc" else ()
    Path("g.nc.toml").write_text('[fanuc]\ndirections = "machine"\n')
    refused = _check(run, name, program, *options)
    told = f"within limits with A0 C0 before line {line}: the table stands at A-90 C-180, where {left} has left it"
    assert refused
    assert {text for item in refused for text in item["remedies"]} == {told}
    shown = run("explain", f"{name}:{refused[0]['line']}", *SETUP, *options).out
    assert told in shown
    assert "the part moved" not in shown
    assert "ended elsewhere" not in shown
    fit = run("fit", name, *SETUP, *options)
    assert fit.code == 1
    assert "no work offset was sought, because another motion is meant" in fit.out
    assert json.loads(run("fit", name, *SETUP, *options, "--json").out)["cause"] == told
    lines = program.split("\n")
    mended = "\n".join([*lines[: line - 1], words, *lines[line - 1 :]])
    assert not _check(run, name, mended, *options)


def test_a_named_place_of_the_table_is_meant(run: Callable[..., Any]) -> None:
    Path("s.mpf").write_text(SWIVELLED.replace("G0 X-20 Y-20", "G0 A-90 C-180 X-20 Y-20"))
    told = run("check", "s.mpf", *SETUP).out
    assert "A0 C0" not in told
    assert "tried: no work offset near this one" in told


def test_what_the_turn_leaves_is_said(run: Callable[..., Any]) -> None:
    (refused,) = _check(run, "s.mpf", SWIVELLED.replace("CYCLE81(5,0,2,-10)", "CYCLE81(5,0,2,-90)"))
    (told,) = refused["remedies"]
    assert told.startswith("A0 C0 before line 10 comes first, because the table stands at A-90 C-180")
    assert told.endswith("with it VP210 of line 13 is left")


PLANE_LOW = """%
O1
G00 G17 G21 G40 G49 G69 G80 G90 G94
T1 M06
S8000 M03
G00 A0. C0.
G43 H1 G0 X0. Y250. Z100.
G68.2 X0. Y0. Z0. I0. J30. K0.
G53.1
G0 X0 Y0
G1 Z30. F500.
G0 Z100.
X5. Y500.
G69
M98 P100 L2
M30
O100
G0 X-20. Y300.
M99
%
"""


@pytest.mark.parametrize(
    ("program", "first", "last"),
    [
        (PLANE_LOW, "A0 C0 before line 18 comes first, because the head stands at A30 C0", 0),
        (PLANE_LOW.replace("X5. Y500.\n", ""), "not tried: correct VP037 of line 17 first: the program may mean", 17),
    ],
)
def test_an_error_before_the_doubted_motion_is_given_an_offset(
    program: str, first: str, last: int, run: Callable[..., Any]
) -> None:
    """The words that turn the head back did not help the plane before it, and nothing else was said there."""
    setup = ("--machine", "ca_fork_head", "--tool-length", "80")
    errors = _check(run, "f.nc", program, "--wcs", "G54=0,0,100", setup=setup)
    meant, offset = next(item["remedies"] for item in errors if item["line"] == 10)
    assert meant.startswith(first)
    assert "move of the part" not in meant
    place = re.search(r"within limits if the part is moved by .* \(then (G54 = [^)]*)\)", offset)
    assert place
    assert not _check(run, "f.nc", program, "--wcs", place[1].replace(" ", ""), setup=setup)
    fit = run("fit", "f.nc", "--wcs", "G54=0,0,100", *setup).out
    assert f"  {place[1].replace('= ', '= [')}]  " in fit
    assert f"Before the part is moved: {first.removeprefix('not tried: ')}" in fit
    if last:  # the same error goes on to the line that is doubted
        assert f"\n  {offset}\n" in run("explain", f"f.nc:{last}", "--wcs", "G54=0,0,100", *setup).out


TRAORI = """G17 G54 G90 G94 G710
T1 D1
M6
S1000 M3
G0 A0 C0
TRAORI
G0 X0 Y0 Z40
G0 X10 Y0 Z20 A-25 C0
G1 Z-8 F300
TRAFOOF
X-150 Y-100
X0
G0 Z60
M30
"""
RESET = """0 BEGIN PGM K MM
1 TOOL CALL 1 Z S1000
2 M3
3 L A0 C0 R0 FMAX
4 L X0 Y0 Z+40 R0 FMAX
5 PLANE SPATIAL SPA+25 SPB+0 SPC+0 TURN FMAX
6 L X10 Y0 R0 FMAX
7 L Z+20 R0 FMAX
8 L Z-8 R0 F300
9 PLANE RESET STAY
10 L X-150 Y-100 R0 F300
11 L X0 R0
12 L Z+60 R0 FMAX
13 M30
14 END PGM K MM
"""
VERNE = ("--tool-length", "80", "--wcs", "G54=0,0,40")
RETRACT, NAME_CODE = "retract the tool first, then ", "name G0 or G1 in line {}, then "


@pytest.mark.parametrize(
    ("name", "program", "old", "new", "line", "first"),
    [
        ("k.mpf", TRAORI, "", "", 11, RETRACT + NAME_CODE),
        ("k.mpf", TRAORI, "X-150", "G1 X-150", 11, RETRACT),
        (
            "k.mpf",
            TRAORI,
            "TRAFOOF\nX-150",
            "G1 Z60\nG0 Z55\nTRAFOOF\nG0 Z-8 X-150",
            13,
            RETRACT,
        ),  # the rapid goes back
        ("k.mpf", TRAORI, "TRAFOOF\nX-150", "G0 Z60\nG1\nTRAFOOF\nZ-8 X-150", 13, NAME_CODE),
        ("k.mpf", TRAORI, "TRAFOOF", "TRAFOOF\nG0 SUPA X0 Y0\nG1", 13, RETRACT + NAME_CODE),
        ("s.mpf", SWIVELLED, "N80 G0 Z50\n", "", 9, RETRACT),
        ("k.h", RESET, "", "", 11, RETRACT),
    ],
)
def test_the_table_is_not_turned_with_the_tool_in_the_part(
    name: str, program: str, old: str, new: str, line: int, first: str, run: Callable[..., Any]
) -> None:
    refused = _check(run, name, program.replace(old, new, 1), setup=VERNE if name[0] == "k" else SETUP)
    told = {text for item in refused for text in item["remedies"]}
    assert len(told) == 1
    begin = f"not tried: {first.format(line)}A0 C0 before line {line}, because the table stands at "
    assert told.pop().startswith(begin)
    assert not [edit for item in refused for edit in item.get("edits", ())]


@pytest.mark.parametrize("out", ["G0 Z60\nTRAFOOF\nG1 Z-8", "TRAFOOF\nG0 SUPA Z0\nG1 Z-8"])
def test_the_table_is_turned_back_after_a_retract(out: str, run: Callable[..., Any]) -> None:
    program = TRAORI.replace("TRAFOOF\n", f"{out} ")
    refused = _check(run, "k.mpf", program, setup=VERNE)
    told = {text for item in refused for text in item["remedies"]}
    assert len(told) == 1
    assert told.pop().startswith(("within limits with A0 C0 before line ", "A0 C0 before line "))
