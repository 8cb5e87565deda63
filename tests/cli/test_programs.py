"""Options that concern the program's text: dialects, subroutine files, parameter files, codes of the shop, quoted
errors.
"""

import json
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import verne_post
from verne_post.config import list_machine_files

PLACE = ("--tool-length", "80", "--wcs", "G54=0,0,50")
HEAD = "G0 X0 Y0 Z20 A0 C0\n"


@pytest.fixture
def program(tmp_path: Path) -> Callable[[str], Path]:
    def write(text: str) -> Path:
        file = tmp_path / "job" / "main.ngc"
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
        return file

    return write


def moves(answer: Any) -> list[dict[str, Any]]:
    """Motion of `dump moves`."""
    assert answer.code == 0, answer.err
    return [row for row in map(json.loads, answer.out.splitlines()) if "end" in row]


# --- subroutine files ---------------------------------------------------------------------------


def test_subroutines_are_found_beside_the_program_and_on_the_path(run: Callable[..., Any], program: Any) -> None:
    file = program("o<Side> call [3]\nM98 P20\no[1+1] call\nM2\n")
    (file.parent / "side.ngc").write_text("o<side> sub\nG0 X#1\no<side> endsub\n")
    (file.parent / "lib").mkdir()
    (file.parent / "lib" / "O0020.NC").write_text("O20\nG0 Y2\nM99\n")
    (file.parent / "lib" / "2.ngc").write_text("o2 sub\nG0 Z2\no2 endsub\n")
    found = moves(run("dump", "moves", file, "--subroutine-path", "lib"))
    assert [row["end"][:3] for row in found] == [[3, 0, 0], [3, 2, 0], [3, 2, 2]]
    assert [row["line"] for row in found] == [1, 2, 3]
    refused = run("dump", "moves", file)
    assert refused.code == 2
    assert "main.ngc:2:5: VP023 error" in refused.err


@pytest.mark.parametrize(
    ("main", "text", "file", "inside"),
    [
        ("part.ngc", "o<side> call\nM2\n", "Side.NC", "o<side> sub\nG0 Q3\no<side> endsub\n"),
        ("part.nc", "%\nO1\nG65 P9010\nM30\n%\n", "lib/O9010.nc", "O9010\nG0 Q3\nM99\n"),
        ("part.mpf", "G90\nBORE\nM30\n", "Bore.MPF", "G90\nG0 NOWORD\nM17\n"),
        (
            "part.h",
            "BEGIN PGM P MM\nCALL PGM bore\nEND PGM P MM\n",
            "BORE.H",
            "BEGIN PGM BORE MM\nL NOWORD\nEND PGM BORE MM\n",
        ),
    ],
)
def test_errors_name_the_file_that_is_there(run: Callable[..., Any], tmp_path, main, text, file, inside) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / main).write_text(text)
    (tmp_path / file).write_text(inside)
    answer = run("dump", "moves", tmp_path / main, "--subroutine-path", "lib")
    assert answer.code == 2
    assert f" error: {file}, line 2: " in answer.err
    if "/" not in file:
        (item,) = verne_post.check(tmp_path / main, "verne").findings
        assert item.full_message.startswith(f"{file}, line 2: ")


def test_macros_of_g65_are_found_beside_the_program(run: Callable[..., Any], program: Any) -> None:
    file = program("%\nO1\nG65 P9010 X3.\nM30\n%\n")
    (file.parent / "O9010.nc").write_text("O9010\nG0 X#24\nM99\n")
    assert [row["end"][:3] for row in moves(run("dump", "moves", file))] == [[3, 0, 0]]


def test_nothing_outside_the_folder_is_read(run: Callable[..., Any], program: Any, tmp_path: Path) -> None:
    file = program("o<secret> call\nM2\n")
    (tmp_path / "secret.ngc").write_text("o<secret> sub\nG0 X1\no<secret> endsub\n")
    for path in ("..", str(tmp_path), "missing"):
        answer = run("dump", "moves", file, "--subroutine-path", path)
        assert answer.code == 2
        assert "--subroutine-path" in answer.err
    (file.parent / "secret.ngc").symlink_to(tmp_path / "secret.ngc")
    answer = run("dump", "moves", file)
    assert answer.code == 2
    assert "VP023" in answer.err
    named = program("o<../secret> call\nM2\n")
    assert run("dump", "moves", named).code == 2


def test_every_command_reads_them(run: Callable[..., Any], program: Any, tmp_path: Path) -> None:
    file = program(HEAD + "o<side> call\nM2\n")
    (file.parent / "side.ngc").write_text("o<side> sub\nG1 X4 F900\no<side> endsub\n")
    assert run("check", file, *PLACE).code == 0
    assert run("convert", file, *PLACE, "-o", tmp_path / "a.csv", "--meta", tmp_path / "a.json").code == 0
    assert run("verify", tmp_path / "a.csv", "--against", file, *PLACE).code == 0
    assert run("explain", f"{file}:2", "--all", *PLACE).code == 0
    options = json.loads((tmp_path / "a.json").read_text())["options"]
    assert list(options["subroutines"]) == ["side"]


# --- parameters, budget, dialects ------------------------------------------------------------------


def test_parameter_files(run: Callable[..., Any], program: Any, tmp_path: Path) -> None:
    file = program("G49 " + HEAD + "G1 X#500 F900\n#500=[#500+1]\nM2\n")
    (tmp_path / "v.var").write_text("500 3\n5221 0.1\n")
    answer = run(
        "convert",
        file,
        "--parameters",
        tmp_path / "v.var",
        "--write-parameters",
        tmp_path / "w.var",
        "-o",
        tmp_path / "a.csv",
        "--wcs",
        "G54=0,0,130",
    )
    assert answer.code == 0, answer.err
    left = dict(line.split() for line in (tmp_path / "w.var").read_text().splitlines())
    assert float(left["500"]) == 4.0
    assert float(left["5220"]) == 1.0
    (tmp_path / "v.var").write_text("500 x\n")
    answer = run("check", file, "--parameters", tmp_path / "v.var")
    assert answer.code == 2
    assert "VP028" in answer.err
    inch = moves(
        run(
            "dump",
            "moves",
            program("G55 G0 X0\nG53 G0 X0\nM2"),
            "--parameters",
            _file(tmp_path, "5241 1\n"),
            "--parameter-units",
            "inch",
        )
    )
    assert inch[1]["end"][0] == -25.4


def _file(folder: Path, text: str) -> Path:
    file = folder / "p.var"
    file.write_text(text)
    return file


def test_repeats_have_a_budget(run: Callable[..., Any], program: Any) -> None:
    file = program("#1=0\no1 while [#1 LT 500]\n#1=[#1+1]\no1 endwhile\nG0 X1\nM2\n")
    assert run("dump", "moves", file).code == 0
    answer = run("dump", "moves", file, "--max-repeats", "100")
    assert answer.code == 2
    assert "VP024" in answer.err
    assert "--max-repeats" in answer.err


def test_dialects_by_name(run: Callable[..., Any], program: Any) -> None:
    file = program("G4 P500\nG0 X1\nM30\n")
    assert json.loads(run("dump", "moves", file).out.splitlines()[0])["seconds"] == 500.0
    assert json.loads(run("dump", "moves", file, "--dialect", "fanuc").out.splitlines()[0])["seconds"] == 0.5
    assert run("dump", "moves", file, "--dialect", "siemens").code == 2


def test_additional_work_offsets(run: Callable[..., Any], program: Any) -> None:
    file = program("%\nO1\nG54.1 P2 G0 X0 Y0 Z20 A0 C0\nG1 X2 F900\nM30\n%")
    answer = run("check", file, "--tool-length", "80", "--wcs", "G54.1P2=0,0,50", "--dialect", "fanuc")
    assert answer.code == 0, answer.out
    assert run("check", file, "--tool-length", "80", "--wcs", "G54.1P49=0,0,50").code == 2


# --- codes of the shop -------------------------------------------------------------------------------


def test_settings_say_what_user_defined_codes_mean(
    run: Callable[..., Any], program: Any, tmp_path: Path, monkeypatch: Any
) -> None:
    settings = tmp_path / "s.toml"
    settings.write_text('[remap]\nM428 = "tcp on"\nM429 = "tcp off"\nM150 = "ignore"\n"G68.3" = "event"\n')
    file = program("M428\nM150 P3 Q2\nG68.3 R5\nG0 X1\nM2\n")
    assert run("dump", "moves", file).code == 2
    answer = run("dump", "moves", file, "--settings", settings)
    rows = [json.loads(line) for line in answer.out.splitlines()]
    assert answer.code == 0, answer.err
    assert [row.get("code", row.get("word")) for row in rows[:3]] == ["M428", "M150", "G68.3"]
    assert rows[2] == {"line": 3, "kind": "remapped", "code": "G68.3", "meaning": "event", "R": 5.0}
    (file.parent / "verne-post.toml").write_text(settings.read_text())
    (file.parent / "below").mkdir()
    monkeypatch.chdir(file.parent / "below")
    assert run("dump", "moves", file).code == 0


def test_without_tool_centre_point_control_nothing_moves_over_a_turned_table(
    run: Callable[..., Any], program: Any, tmp_path: Path
) -> None:
    settings = tmp_path / "s.toml"
    settings.write_text('[remap]\nM428 = "tcp on"\nM429 = "tcp off"\n')
    good = program(
        HEAD + "M429\nG1 X5 F900\nG53 G0 Z0\nM428\nG0 X0 Y0 Z40 A10\nM429\nG53 G0 Z0 A0 C0\nG0 X0 Y0 Z40\nM2\n"
    )
    assert run("check", good, *PLACE, "--settings", settings).code == 0
    bad = program(HEAD + "A10\nM429\nX5\nM2\n")
    answer = run("check", bad, *PLACE, "--settings", settings)
    assert answer.code == 2
    assert "main.ngc:4: VP017 error" in answer.out
    turning = program(HEAD + "M429\nG0 A10\nM2\n")
    assert "main.ngc:3: VP017 error" in run("check", turning, *PLACE, "--settings", settings).out


def test_codes_that_switch_kinematics_are_given_that_meaning(run: Callable[..., Any], program: Any) -> None:
    """M428 was said to be settled by "ignore" or "event", under which a turned table is read otherwise than the control
    does.
    """
    answer = run("check", program(HEAD + "M429\nM428\nM430\nM431\nM2\n"), *PLACE)
    assert answer.code == 2
    for code, example in (("M428", "on"), ("M429", "off"), ("M430", "off")):
        assert f'says to which: {code} = "tcp on" or "tcp off" (in its examples "tcp {example}")' in answer.out
    assert "M431: no meaning in this language" in answer.out


POSITIONAL = "G21 G90 F600\n{code}\nG0 X0 Y0 Z60 A0 C0\nG1 X10\nG0 Z90\n{turn}\nG1 Z50\n{more}G1 X20\nM2\n"


@pytest.mark.parametrize(
    ("code", "turn", "more", "warned"),
    [
        ("G43", "G0 A30 C60", "", "A30 C60"),
        ("G49", "G0 A30 C60", "", "A30 C60"),
        ("G43", "G1 A-30", "", "A-30 C0"),  # a turn alone at a feed rate is positional too
        ("G43", "G0 C60", "", "A0 C60"),  # X and Y are other places of the part than on a control
        ("G43", "G0 X0 C60", "G1 X15\n", "A0 C60"),  # but not in the centre, where Z moves
        ("G43", "G0 A0 C360", "", None),
        ("G43", "G0 A0 C0", "", None),
        ("G43.4", "G0 A30 C60", "", None),
        ("G43.5\nG43", "G0 A30 C60", "", "A30 C60"),  # what counts is what holds at the cut
        ("M428", "G0 A30 C60", "", None),
        ("G43", "G0 A30 C60", "G1 X15 A31\n", None),  # it turns while it cuts: no positional program
    ],
)
def test_a_positional_program_that_does_not_say_tool_centre_point_control(
    run: Callable[..., Any], program: Any, tmp_path: Path, code: str, turn: str, more: str, warned: str | None
) -> None:
    """A control without it would cut elsewhere; one warning a program, at the first cut under the turned table."""
    settings = tmp_path / "s.toml"
    settings.write_text('[remap]\nM428 = "tcp on"\n')
    answer = run("check", program(POSITIONAL.format(code=code, turn=turn, more=more)), *PLACE, "--settings", settings)
    assert answer.code == 0, answer.out
    assert answer.out.count("VP037 warning") == (warned is not None)
    if warned is not None:
        line = 7 + bool(more) + code.count("\n")
        assert f"main.ngc:{line}: VP037 warning: X Y Z cut with the table at {warned}, " in answer.out
        assert "if its kinematics keep the tip (ignore VP037 then); otherwise write G43.4 before the cut" in answer.out


@pytest.mark.parametrize(
    ("head", "warned"),
    [("G43 H1", True), ("G43.4 H1", False), ("G68.2 X0 Y0 Z0 I0 J30 K0\nG53.1\nG69\nG43 H1", True)],
)
def test_a_positional_fanuc_program(run: Callable[..., Any], tmp_path: Path, head: str, warned: bool) -> None:
    path = tmp_path / "p.nc"
    path.write_text(
        f"%\nO1\nG21 G90 F600.\nG0 X0 Y0 Z60. A0 C0\n{head}\nG0 A30. C60.\nG0 X5. Y0 Z50.\nG1 X20.\nM30\n%\n"
    )
    answer = run("check", path, *PLACE)
    assert answer.code == 0, answer.out
    assert ("VP037 warning" in answer.out) == warned


SIMULTANEOUS = "%\nO1\nG21 G90 G94 F600.\nG0 X{x}. Y0. Z60. A{a}. C0.\n{head}\nG0 Z50.\n{cut}\nM30\n%\n"


@pytest.mark.parametrize(
    ("head", "cut", "a", "x", "turned"),
    [
        ("G43 H1", "G1 X10. Y2. A6. C12.", 0, 5, "A6 C12"),  # as CAM systems write it, but for .4
        ("G43 H1", "G1 X10. C12.", 0, 5, "A0 C12"),
        ("G43 H1", "G1 Z45. A0.", 6, 0, "A0 C0"),  # it ends upright, and has cut under a turned table
        ("G43 H1", "G1 Z45. C12.", 0, 0, None),  # in the centre of the table both readings agree
        ("G43 H1", "G93 G1 X10. Y2. A6. C12. F30.", 0, 5, "A6 C12"),
        ("G43.4 H1", "G1 X10. Y2. A6. C12.", 0, 5, None),
        ("G43.4 H1\nG43 H1", "G1 X10. Y2. Z50. A6. C12.", 0, 5, "A6 C12"),
        ("G43.4 H1\nG49", "G1 A6. C12. F600.", 0, 5, None),  # axes of the machine: so it is on a control
    ],
)
def test_a_fanuc_program_that_turns_while_it_cuts_needs_a_code(
    run: Callable[..., Any], tmp_path: Path, head: str, cut: str, a: int, x: int, turned: str | None
) -> None:
    """Without G43.4 a Fanuc control cuts elsewhere; what a post has computed for the machine (G93) is named, too."""
    path = tmp_path / "p.nc"
    path.write_text(SIMULTANEOUS.format(head=head, cut=cut, a=a, x=x))
    answer = run("check", path, *PLACE, "--dialect", "fanuc")
    assert answer.code == 0, answer.out
    assert answer.out.count("VP037 warning") == (turned is not None)
    if turned is not None:
        line = 7 + head.count("\n")
        said = f"X Y Z cut in a turn of the table to {turned}, and no code turns on tool-centre-point control: "
        assert f"p.nc:{line}: VP037 warning: {said}" in answer.out
    assert ("post again" in answer.out) == ("G93" in cut)


def test_a_fanuc_block_of_machine_axes_that_tilts_while_it_cuts(run: Callable[..., Any], tmp_path: Path) -> None:
    """The program knows G43.4, and G43 holds: a block without Z is executed as on a control, along a curve."""
    path = tmp_path / "p.nc"
    path.write_text(SIMULTANEOUS.format(head="G43.4 H1\nG43 H1", cut="G1 X10. Y2. A6. C12.", a=0, x=5))
    answer = run("check", path, *PLACE, "--dialect", "fanuc")
    assert answer.code == 0, answer.out
    assert answer.out.count("VP037") == 1
    assert "p.nc:8: VP037 warning: X Y Z cut during a tilt of the table to A6, without G43.4: the axes" in answer.out


@pytest.mark.parametrize(
    ("mode", "cut", "warned"),
    [
        ("M129", "L X+10 Y+2 A+6 C+12 F600", True),
        ("M128", "L X+10 Y+2 A+6 C+12 F600", False),
        ("M129", "L X+10 C+12 F600", False),  # polar milling
        ("M129", "L A+6 C+12 F600", False),  # a turn of the table alone
        ("M129", "L X+10 Y+2 A+6 C+12 FMAX", False),
    ],
)
def test_klartext_that_tilts_while_it_cuts_without_m128(
    run: Callable[..., Any], tmp_path: Path, mode: str, cut: str, warned: bool
) -> None:
    path = tmp_path / "p.h"
    path.write_text(
        f"BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+60 A+0 C+0 R0 FMAX M3\n{mode}\n{cut}\n{cut}\n"
        "M30\nEND PGM P MM\n"
    )
    answer = run("check", path, *PLACE)
    assert answer.code == 0, answer.out
    assert answer.out.count("p.h:5: VP037 warning: X Y Z cut during a tilt of the table to A6, without M128") == warned
    assert answer.out.count("VP037") == warned


@pytest.mark.parametrize(
    ("words", "warned"),
    [
        ("G43.4 H1\nG0 A30. C60. X5. Y0. Z50.\nG1 X20.\nG0 Z90.\nG43 H1\nG0 Z50.\nG1 X0.\n", 11),
        ("G43.4 H1\nG0 A30. C60. X5. Y0. Z50.\nG1 X20. A31.\nG0 Z90.\nG43 H1\nG0 Z50.\nG1 X0.\n", 11),
        ("G43 H1\nG0 A30. C60. X5. Y0. Z50.\nG1 X20.\nG43.4 H1\nG0 X0. Y0. Z50.\nG1 X9.\n", 7),
        ("G43.4 H1\nG0 A30. C60. X5. Y0. Z50.\nM98 P2\nG0 X0. Y0. Z50.\nG1 X9.\n", None),
        ("G68.2 X0 Y0 Z0 I0 J30. K0\nG53.1\nG43 H1\nG0 X5. Y0. Z50.\nG1 X20.\nG0 Z99.\nG69\n", None),
        ("G68.2 X0 Y0 Z0 I0 J30. K0\nG53.1\nG43 H1\nG1 X5. Y0. Z50.\nG69\nG0 Z60.\nA0 C0\nG1 X9.\n", 10),
        ("G43.4 H1\nG0 A30. C60. X5. Y0. Z50.\nG1 X9.\nG43 H1\nG0 Z60.\n", 9),
        ("G43 H1\nG0 A30. C60.\nX5. Y0. Z60.\nG43.4 H1\nG0 Z50.\nG1 X9.\nG0 A0. C0.\n", None),
        ("G68.2 X0 Y0 Z0 I0 J30. K0\nG53.1\nG43 H1\nG1 X5. Y0. Z50.\nG69\nG0 A0 C0\nG0 X5. Y0. Z60.\n", None),
    ],
)
def test_each_cut_is_judged_by_what_holds_there(
    run: Callable[..., Any], tmp_path: Path, words: str, warned: int | None
) -> None:
    """G43.4 or a plane elsewhere in the program says nothing of a cut under G43."""
    path = tmp_path / "p.nc"
    path.write_text(f"%\nO1\nG21 G90 F600.\nG0 X0 Y0 Z60. A0 C0\n{words}M30\nO2\nG1 X9.\nM99\n%\n")
    answer = run("check", path, *PLACE, "--dialect", "fanuc")
    assert answer.code == 0, answer.out
    assert [line for line in answer.out.splitlines() if "VP037 warning" in line][:1] == [
        line for line in answer.out.splitlines() if f"p.nc:{warned}: VP037" in line
    ]
    assert answer.out.count("VP037 warning") == (warned is not None)


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ('[remap]\nM3 = "ignore"', "already has a meaning"),
        ('[remap]\nG1 = "event"', "already has a meaning"),
        ('[remap]\nCYCLE83 = "ignore"', "already has a meaning"),
        ('[remap]\nCYCLE8OO = "ignore"', "2:1: VP503 error: remap.CYCLE8OO: did you mean CYCLE800? Write CYCLE800"),
        ('[remap]\nCYCLE63 = "ignore"', "already has a meaning"),  # refused by name
        ('[remap]\nTRAORI = "ignore"', "already has a meaning"),
        ('[remap]\nTraoof = "ignore"', "in capitals the name of a subprogram"),
        ('[remap]\nM428 = "tcp"', "remap.M428"),
        ('[remap]\nM0428 = "ignore"', "without leading zeros"),
        ('[map]\nM428 = "ignore"', "map"),
        ("[remap", "not a TOML file"),
        ('remap = "x"', "remap"),
    ],
)
def test_bad_settings(run: Callable[..., Any], program: Any, tmp_path: Path, text: str, part: str) -> None:
    settings = tmp_path / "s.toml"
    settings.write_text(text)
    answer = run("dump", "moves", program("G0 X1\nM2"), "--settings", settings)
    assert answer.code == 2
    assert "VP503" in answer.err
    assert part in answer.err
    assert run("dump", "moves", program("G0 X1\nM2"), "--settings", tmp_path / "none.toml").code == 2


# --- what other commands make of such lines -----------------------------------------------------------


def test_explain_works_lines_that_compute_and_other_dialects(
    run: Callable[..., Any], program: Any, tmp_path: Path
) -> None:
    file = program(HEAD + "#1=3\no1 repeat [2]\nG1 X[2*#1] F900\n#1=[#1+1]\no1 endrepeat\nM2\n")
    answer = run("explain", f"{file}:4", "--all", *PLACE)
    assert answer.code == 0, answer.err
    assert "X 8 mm (as the line says)" in answer.out or "X 6 mm (as the line says)" in answer.out
    apt = tmp_path / "a.cls"
    apt.write_text("UNITS/MM\nMULTAX/ON\nLOADTL/1\nFROM/0,0,20,0,0,1\nFEDRAT/900\nGOTO/5,0,20,0,0,1\nFINI\n")
    answer = run("explain", f"{apt}:6", "--all", *PLACE)
    assert answer.code == 0, answer.err
    assert "X 5 mm (as the line says)" in answer.out


def test_setpoints_cannot_wait_for_an_input(run: Callable[..., Any], program: Any) -> None:
    assert run("check", program(HEAD + "G1 X1 F900\nM66 P0 L0\nX2\nM2\n"), *PLACE).code == 0
    answer = run("check", program(HEAD + "G1 X1 F900\nM66 P0 L3 Q5\nX2\nM2\n"), *PLACE)
    assert answer.code == 2
    assert "VP014 error: M66" in answer.out
    answer = run("convert", program("M66 P2 L3 Q5\n" + HEAD + "G1 X1 F900\nM2\n"), *PLACE)
    assert answer.code == 0
    assert "before the start: wait for input 2 (line 1)" in " ".join(answer.err.split())


# --- errors ----------------------------------------------------------------------------------------------


def test_check_quotes_the_line_of_an_error(run: Callable[..., Any], program: Any) -> None:
    file = program(HEAD + "\tG1 X3 Q5 F3000\n(" + "a" * 200 + ") G1 X2 Q7\nG12\nM2\n")
    lines = run("check", file, *PLACE).out.splitlines()
    assert lines[0].endswith("main.ngc:2:8: VP006 error: nothing in the block uses Q5")
    assert lines[1] == "  2 |  G1 X3 Q5 F3000"
    assert lines[2] == "    |        ^"
    assert lines[1][lines[2].index("^") :].startswith("Q5")
    assert lines[3].startswith("    = word without a use: ")
    assert lines[5].startswith("  3 | ...aaa")
    assert lines[5][lines[6].index("^") :].startswith("Q7")
    lines[-1] += "; nothing was written"
    assert run("convert", file, *PLACE).err.splitlines() == lines, "convert says what check says"


# --- completion --------------------------------------------------------------------------------


def completed(*words: str) -> list[str]:
    """What bash is offered for the last word, as lines of kind and value."""
    environment = {
        **os.environ,
        "COMP_WORDS": shlex.join(["verne-post", *words[:-1]]) + " " + words[-1],
        "COMP_CWORD": str(len(words)),
        "_VERNE_POST_COMPLETE": "bash_complete",
    }
    command = [
        sys.executable,
        "-c",
        "import sys; sys.argv[0] = 'verne-post'; from verne_post.cli.main import run; run()",
    ]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert not done.stderr
    return done.stdout.splitlines()


def test_completion_knows_commands_choices_machines_and_files() -> None:
    """A program may stand where a command does, and options before it."""
    assert completed("ch") == ["file,ch", "plain,check"]
    assert "plain,fanuc" in completed("check", "--dialect", "fa")
    names = ["file,", *(f"plain,{name}" for name in list_machine_files())]
    for words in (["--machine"], ["check", "--machine"], ["part.nc", "--machine"], ["machine", "show"]):
        assert completed(*words, "") == names, words
    assert completed("check", "--machine", "se") == ["file,se", "plain,serial"]
    assert completed("--machine", "serial", "pa") == ["file,pa"]
    assert "plain,--tool-length" in completed("--tool")
    assert completed("explain", "pa") == ["file,pa"]


#: Coordinates under G500 are those of the machine: machine zero of the VERNE is 550 mm above the table face.
AT_MACHINE_ZERO = (
    "G17 G54 G64 G90 G94 G710\nG500\nT1 D1\nM6\nM3 S5000\nG0 A0 C0\nG0 X0 Y0 Z50\nG1 Z10 F500\nG0 Z50\nM30\n"
)


def test_moves_under_g500_are_named_by_every_command(run: Callable[..., Any], tmp_path: Path) -> None:
    """No set-up places that system: nobody misses an offset, and none is proposed."""
    program, rows, page = tmp_path / "g.mpf", tmp_path / "g.csv", tmp_path / "g.html"
    program.write_text(AT_MACHINE_ZERO)
    (tmp_path / "g.mpf.toml").write_text("tool_length = 80\n[wcs]\nG54 = [0, 0, 40]\n")
    checked = run("check", program)
    assert checked.code == 0
    assert "work offset: G500 is machine zero, (0, 0, 550) mm on the table\n" in checked.out
    assert run(program, "-o", rows).code == 0
    assert run("verify", rows, "--against", program).code == 0
    explained = run("explain", f"{program}:8", "--all")
    assert "G500, tool length 80 mm" in explained.out
    assert "tip on the table     (0.000000, 0.000000, 560.000000) mm" in explained.out
    assert "work offset          G500: o = (0.000000, 0.000000, 550.000000) mm" in explained.out
    assert run("report", program, "-o", page).code == 0
    assert "machine zero" in page.read_text("utf-8")
    assert run("dump", "moves", program).code == 0
    assert "all moves of this program are in machine coordinates (G500)" in run("fit", program).err
    options = verne_post.Options(tool_length=80, wcs={"G54": (0, 0, 40)}, dialect="siemens")
    done = verne_post.convert(program.read_text(), "verne", options)
    assert "5.055 s" in str(done)

    program.write_text(AT_MACHINE_ZERO.replace("Z10", "Z-560"))
    refused = run("check", program)
    assert refused.code == 1
    assert "line 8 is in machine coordinates" in refused.out and "no work offset moves" in refused.out
    explained = run("explain", f"{program}:8")
    assert "the line ended elsewhere: Z " in explained.out and "the part moved" not in explained.out

    program.write_text(AT_MACHINE_ZERO.replace("G500\n", "$P_UIFR[0,Z,TR]=-40\nG500\n"))
    assert "work offset: G500 at (0, 0, 510) mm on the table\n" in run("check", program).out


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        (
            "p.h",
            "BEGIN PGM P MM\nTOOL DEF 1 L+120\nTOOL CALL 1 Z S900\nL X+0 Y+0 Z+60 A+0 C+0 R0 FMAX M3\n"
            "TOOL CALL 1 Z S800\nL Z+40 R0 F600 M3\nM30\nEND PGM P MM\n",
            3,
        ),
        (
            "p.nc",
            "%\nO1\nG21 G90 G54\nT1 M6\nG10 L10 P1 R120.\nG0 X0 Y0 A0 C0 S900 M3\nG43 H1 Z60.\nG1 Z40. F600.\n"
            "G43 H1\nM30\n%\n",
            7,
        ),
        (
            "p.mpf",
            "G17 G90 G94 G710 G54\n$TC_DP3[1,1]=120\nT1 D1\nM6\nS900 M3\nG0 X0 Y0 Z60 A0 C0\nD1\nG1 Z40 F600\nM30\n",
            4,
        ),
    ],
)
def test_a_length_of_the_program_beside_tool_length_is_told_once(
    run: Callable[..., Any], tmp_path: Path, name: str, text: str, line: int
) -> None:
    path = tmp_path / name
    path.write_text(text)
    for length in (80, 120):
        answer = run("check", path, "--tool-length", length, "--wcs", "G54=0,0,40")
        assert answer.code == 0, answer.out
        assert answer.out.count("VP018") == (length == 80), answer.out
        said = f"{name}:{line}: VP018 warning: --tool-length gives 80 mm to the whole program, and the length that the"
        assert (said in answer.out) == (length == 80)


@pytest.mark.parametrize("given", ["lengths", "table", "set-up"])
@pytest.mark.parametrize(
    ("name", "text", "line", "held"),
    [
        ("p.h", "TOOL DEF 1 L{}\nTOOL CALL 1 Z S900\nL Z+60 R0 FMAX M3\nL Z+40 F600 M30\n", 1, 80),
        ("p.nc", "%\nO1\nG10 L10 P1 R{}\nT1 M6\nS900 M3\nG0 G43 H1 Z60.\nG1 Z40. F600.\nM30\n%\n", 6, 95),
        ("p.ngc", "G21 G90\nG10 L1 P1 Z{}\nT1 M6\nS900 M3\nG43 H1\nG0 X0 Y0 Z60\nG1 Z40 F600\nM2\n", 5, 95),
        ("p.mpf", "$TC_DP3[1,1]={}\nT1 D1\nM6\nS900 M3\nG0 X0 Y0 Z60 A0 C0\nG1 Z40 F600\nM30\n", 3, 95),
    ],
)
def test_two_lengths_of_one_tool_are_told(
    run: Callable[..., Any], tmp_path: Path, given: str, name: str, text: str, line: int, held: float
) -> None:
    """TOOL DEF gives way to a measured length; G10 and $TC_DP3 write the table of a control, and hold."""
    path, words = tmp_path / name, ["--wcs", "G54=0,0,100"]
    if given == "lengths":
        (tmp_path / "l.csv").write_text("tool,length_mm\n1,80\n")
        words += ["--tool-lengths", str(tmp_path / "l.csv")]
    elif given == "table":
        (tmp_path / "t.tbl").write_text("T1 P1 Z80 D6\n")
        words += ["--tool-table", str(tmp_path / "t.tbl")]
    else:
        path.with_name(f"{name}.toml").write_text("[tools]\n1 = { length = 80 }\n")
    for length in (95, 80):
        path.write_text(text.format(f"{length:.1f}"))
        answer = run("check", path, *words)
        assert answer.code == 0, answer.out
        assert f"tool length: tool 1: {held if length == 95 else 80} mm" in answer.out
        assert answer.out.count("VP018") == (length == 95), answer.out
        word = {"p.h": "TOOL DEF", "p.mpf": "$TC_DP3"}.get(name, "G10")
        said = f"{name}:{line}: VP018 warning: {word} gives tool 1 the length 95 mm, but the set-up or the tool table "
        said += "gives the length 80 mm"
        assert (said in answer.out) == (length == 95), answer.out


def test_wear_of_the_program_is_no_other_length(run: Callable[..., Any], tmp_path: Path) -> None:
    """G10 L11 is added to the measured length on purpose."""
    path = tmp_path / "p.nc"
    path.write_text("%\nO1\nG10 L11 P1 R-.05\nT1 M6\nS900 M3\nG0 G43 H1 Z60.\nG1 Z40. F600.\nM30\n%\n")
    (tmp_path / "t.tbl").write_text("T1 P1 Z80 D6\n")
    answer = run("check", path, "--tool-table", tmp_path / "t.tbl", "--wcs", "G54=0,0,100")
    assert "tool length: tool 1: 79.95 mm" in answer.out
    assert "VP018" not in answer.out


OF_FANUC = (
    "%\nO0001\nG21 G90 G94 G17\nG54\nT1 M6\nS8000 M3\nG0 A0. C0.\nG43 H1 Z160.\nX0. Y0.\nM98 P2000\nG0 Z160.\nM30\n%\n"
)
OF_SIEMENS = "G710 G90 G54\nT1 D1\nM6\nS9 M3\nG0 X0 Y0 Z150 A0 C0\nSLOT(3)\nG0 Z160\nM30\n"
OF_RS274 = "G21 G90\nT1 M6\nG43 H1\nS9 M3\nG0 X0 Y0 Z150 A0 C0\no100 call\nG0 Z160\nM2\n"
KLARTEXT_CALL = (
    "0 BEGIN PGM A MM\n1 TOOL CALL {} Z S9000 F1200\n2 L X+0 Y+0 Z+40 R0 FMAX\n3 CALL PGM SUB\n4 L X+10 F500\n"
    "5 L Z+50 FMAX\n6 END PGM A MM\n"
)


@pytest.mark.parametrize(
    ("name", "main", "file", "text"),
    [
        ("a.nc", "T1 M6\nM98 P2000\nG43 H1\nG0 X0. Y0. Z40.\nG1 X10. F500\nM30\n", "O2000.nc", "S8000 M3\nM99\n"),
        ("a.ngc", "T1 M6 S9 M3\no9 call\nG43 H1\nG0 X0 Y0 Z40\nG1 X10 F500\nM2\n", "9.ngc", "o9 sub\nM8\no9 endsub\n"),
        ("a.h", KLARTEXT_CALL.format(1), "sub.h", "0 BEGIN PGM SUB MM\n1 M3\n2 END PGM SUB MM\n"),
        ("a.mpf", "T1 D1\nM6\nSUB1\nG0 X0 Y0 Z40\nG1 X10 F500\nM30\n", "SUB1.SPF", "M3 S8000\nRET\n"),
    ],
)  # fmt: skip
def test_a_called_file_need_not_move(
    run: Callable[..., Any], tmp_path: Path, name: str, main: str, file: str, text: str
) -> None:
    (tmp_path / name).write_text(main)
    (tmp_path / file).write_text(text)
    answer = run("check", tmp_path / name, "--tool-length", 80, "--wcs", "G54=0,0,60")
    assert answer.code == 0, answer.out
    assert "0 errors, 0 warnings" in answer.out


FANUC_CALL = "%\nO1\nT1 M6\nG21 G17 G90 G94 G40 G80 G54 {}\nG43 H1 G0 X0. Y0. Z40.\nM98 P2001\n{}G0 Z60.\nM30\n{}%\n"


@pytest.mark.parametrize(
    ("name", "main", "file", "text", "said", "edit"),
    [
        # a line that is kept has the number of one in the file, or of the one that calls it
        ("a.h", KLARTEXT_CALL.format("1").replace("F1200", "F1200 DR+5"), "sub.h",
         "0 BEGIN PGM SUB MM\n1 L X+10 Y+5 RL F500 M3\n2 L X+30\n3 L Y+20 R0\n4 END PGM SUB MM\n",
         (2, 2, "VP505", "DR+5 of tool 1"), ()),
        ("a.ngc", "G21 G90\nT1 M6 S9 M3\nG43 H1\nT2\nG0 X0 Y0 Z40\no20 call\nG1 X10 F500\nM2\n", "20.ngc",
         "o20 sub\nG0 X1\nX2\nG43 H2\nG1 X3 Z20 F500\no20 endsub\n",
         (4, 4, "VP041", "T2 only selects the tool, and no M6 loads it: H2 in 20.ngc, line 4"), ("M6", 4)),
        ("a.nc", FANUC_CALL.format("S9 M3", "T2 M98 P2001\n", ""), "O2001.nc", "O2001\nG1 X3. F500.\nG43 H2\nM99\n",
         (7, 7, "VP041", "T2 only selects the tool, and no M6 loads it: H2 in O2001.nc, line 3"), ("M6", 7)),
        # a system of the file, of which a later cut of the program is the first
        ("a.nc", FANUC_CALL.format("S9 M3", "G1 X10. F500.\n", ""), "O2001.nc", "O2001\nG0 X3. Y1.\nG55\nM99\n",
         (6, 6, "VP033", "O2001.nc, line 3: G55 has no place on the table"), ()),
        # the line of the program has the number of one in the file
        ("a.mpf", OF_SIEMENS.replace("SLOT", "TRAORI\nG1 X1 A3=0 B3=0.1 C3=999 F500\nSLOT"), "SLOT.SPF",
         "PROC SLOT(REAL L)\n;\n;\n;\n;\n;\nX2 A3=0 B3=0.1 C3=1\nRET\n",
         (7, 7, "VP505", "A3= B3= C3= have the length 999 here and 1.00499 in SLOT.SPF, line 7: is a"), ()),
        # what is to be written stands in the program
        ("a.nc", FANUC_CALL.format("", "", ""), "O2001.nc", "O2001\nG1 Z4. F500.\nX5.\nM99\n",
         (6, 6, "VP050", "O2001.nc, line 2: the spindle does not turn in 2 moves"), ("M3", 3)),
        ("a.nc", FANUC_CALL.format("S9 M3", "M98 P2001\n", "").replace("Z40.", "Z4."), "O2001.nc",
         "O2001\nG1 X1. F300.\nM5\nG1 Z3.\nX5.\nM3\nM99\n",
         (6, 7, "VP050", "O2001.nc, line 4: the spindle does not turn in 3 moves"), ()),
        ("a.nc", FANUC_CALL.format("S9 M3", "G41 D2\n", ""), "O2001.nc", "O2001\nG41 D2 G1 X9. F500.\nX5.\nM99\n",
         (7, 7, "VP017", "G41 under cutter compensation: G41 of O2001.nc, line 2 is still"), ("G40", 7)),
        # the file calls a subprogram of the program
        ("a.nc", FANUC_CALL.format("S9 M3", "", "O3000\nG41 D2 G1 X5. F500.\nX10.\nG40 X20.\nM99\n"), "O2001.nc",
         "O2001\nM98 P3000\nG1 X1.\nM99\n", (10, 10, "VP049", "the diameter number 2, 10 mm"), ("1", 10)),
    ],
)  # fmt: skip
def test_a_finding_beside_a_called_file_has_the_line_of_its_own_text(
    tmp_path: Path, name: str, main: str, file: str, text: str, said: tuple[int, int, str, str], edit: tuple[str, int]
) -> None:
    (tmp_path / name).write_text(main)
    (tmp_path / file).write_text(text)
    (tmp_path / f"{name}.toml").write_text(
        "[tools]\n1 = { length = 80, diameter = 8 }\n2 = { length = 95, diameter = 10 }\n[wcs]\nG54 = [0, 0, 60]\n"
    )
    found = verne_post.check(tmp_path / name, machine="verne").findings
    [one] = [item for item in found if item.code == said[2] and item.line]
    assert (one.line, one.last_line, one.code, one.full_message[: len(said[3])]) == said
    assert [(each.value, each.line) for each in one.edits] == [edit] * bool(edit)


@pytest.mark.parametrize(
    ("main", "file", "text", "said"),
    [
        # all moves of the file have the line of the call, and so had M5: none of them counted
        (
            OF_FANUC,
            "O2000.nc",
            "%\nO2000\nM5\nG1 Z110. F500.\nX20.\nM99\n%\n",
            {"VP050": "line 4: the spindle does not turn in 2 moves at feed rate: O2000.nc, line 3 stops it"},
        ),
        (
            OF_SIEMENS,
            "SLOT.SPF",
            "PROC SLOT(REAL L)\nM5\nG1 Z=110 F500\nX=L\nRET\n",
            {"VP050": "line 3: the spindle does not turn in 2 moves at feed rate: SLOT.SPF, line 2 stops it"},
        ),
        (
            OF_RS274,
            "100.ngc",
            "o100 sub\nM5\nG1 Z110 F500\nX20\no100 endsub\n",
            {"VP050": "line 3: the spindle does not turn in 2 moves at feed rate: 100.ngc, line 2 stops it"},
        ),
        (
            OF_FANUC.replace("M98", "M5 M98"),
            "O2000.nc",
            "%\nO2000\nG1 Z110. F500.\nX20.\nM99\n%\n",
            {"VP050": "line 3: the spindle does not turn in 2 moves at feed rate: line 10 stops it"},
        ),
        # what is found in the moves stood at the call, as if the line of the program had it, or was not found at all
        (
            OF_FANUC,
            "O2000.nc",
            "%\nO2000\nG1 Z110. F500.\nX20.\nT2 M6\nS9 M3\nG0 G43 H2 Z160.\nG1 Z110.\nX0.\n"
            "T1\nG0 X5.\nG1 X20.\nM99\n%\n",
            {
                "VP009": "line 8: the tool cuts at the feed rate of the tool before: no block gives F after the change "
                "to tool 2 in O2000.nc, line 5; write F",
                "VP041": "line 10: T1 only selects the tool, and no M6 loads it: O2000.nc, line 12 cuts with the tool",
            },
        ),
        (
            OF_FANUC,
            "O2000.nc",
            "%\nO2000\nG1 Z110. F5000.\nX10.\nX15. F2.5\nX20. F500.\nG2 X30. Y10. J10.\nG1 Y20.\nM99\n%\n",
            {"VP056": "line 7: the arc of 270 deg goes back", "VP505": "line 5: F is 2.5 mm/min here"},
        ),
        (
            OF_SIEMENS,
            "SLOT.SPF",
            "PROC SLOT(REAL L)\nG1 Z=110 F5000\nX=L\nX=IC(9) F2.5\nRET\n",
            {"VP505": "line 4: F is 2.5 mm/min here"},
        ),
        # a word that lasts stood at such a word of the program, and the length of a tool axis beside another line
        (
            OF_RS274.replace("o100 call\n", "G64 P0.01\no100 call\nG1 X3 F500\nY9\n"),
            "100.ngc",
            "o100 sub\nG64 P50\no100 endsub\n",
            {"VP505": "line 2: corners may be off by 50 mm from line 8 on"},
        ),
        (
            OF_SIEMENS.replace("SLOT", "TRAORI\nG1 X1 A3=0 B3=0.1 C3=1 F500\nSLOT"),
            "SLOT.SPF",
            "PROC SLOT(REAL L)\n;\n;\n;\n;\nG1 X2 A3=0 B3=0.1 C3=999\nG1 X2 A3=0 B3=0.1 C3=1\nRET\n",
            {"VP505": "line 6: A3= B3= C3= have the length 999 here and 1.00499 in line 7: is"},
        ),
        # the element before a corner is drawn when the next line is executed
        (
            OF_SIEMENS,
            "SLOT.SPF",
            "PROC SLOT(REAL L)\nG1 Z=110 F5000\nX=L F2.5 RND=1\nY=9 F5000\nX0\nRET\n",
            {"VP505": "line 3: F is 2.5 mm/min here"},
        ),
        # M5 acts at the end of its block, and one move is not a cut without it
        (OF_FANUC, "O2000.nc", "%\nO2000\nG1 Z110. F500.\nX20. M5\nG0 Z160.\nM99\n%\n", {}),
        # an empty word, told at the line of the file as if it were one of the program; and twice of one code
        (
            OF_FANUC,
            "O2000.nc",
            "%\nO2000\nG1 Z110. F500.\nG1 X10. Y#3\nG1 X20. Z#4\nG0 Z160.\nM99\n%\n",
            {"VP039": "line 4: Y has #3", "VP039 ": "line 5: Z has #4"},
        ),
        # the lost point: of the file, and of the file alone beside points of the program
        (OF_FANUC, "O2000.nc", "%\nO2000\nG1 Z110. F500.\nG0 Z160\nM99\n%\n", {"VP038": "line 4: Z160 has no decimal"}),
        (
            OF_FANUC,
            "O2000.nc",
            "%\nO2000\nG1 Z110 F500\nG0 Z160\nM99\n%\n",
            {"VP038": "line 3: 2 words (Z110 first; lines 3 to 4) have no decimal point, and words of line 7 of the "},
        ),
    ],
)
def test_a_warning_in_a_called_file_names_the_file_and_its_line(
    run: Callable[..., Any], tmp_path: Path, main: str, file: str, text: str, said: dict[str, str]
) -> None:
    """Some stood at the line of the file in the program, and others were lost."""
    ending = {"O": "nc", "S": "mpf"}.get(file[0], "ngc")
    program = tmp_path / f"plate.{ending}"
    program.write_text(main, "utf-8")
    (tmp_path / f"plate.{ending}.toml").write_text(
        "split_at_stops = true\n[tools]\n1 = { length = 90 }\n2 = { length = 90 }\n[wcs]\nG54 = [0, 0, 60]\n", "utf-8"
    )
    (tmp_path / file).write_text(text, "utf-8")
    found = json.loads(run("check", program, "--output-format", "json").out)["programs"][0]["findings"]
    call = next(k for k, line in enumerate(main.split("\n"), 1) if re.search("P2000|SLOT|o100", line))
    codes = ("VP009", "VP038", "VP039", "VP041", "VP050", "VP056", "VP505")
    there = [one for one in found if one["code"] in codes and one["line"]]
    assert [one["code"] for one in there] == sorted(code.strip() for code in said)
    assert {one["line"] for one in there} <= {call}
    for one, part in zip(there, said.values(), strict=True):
        assert one["message"].startswith(f"{file}, {part}")
        own_line = int(part[len("line ") :].partition(":")[0])
        assert (one["column"], one["file"], one["file_line"]) == (None, str(tmp_path / file), own_line)


def test_a_limit_and_a_contact_in_a_called_file_name_the_file_and_its_line(
    run: Callable[..., Any], tmp_path: Path
) -> None:
    """They stood at the call alone."""
    program = tmp_path / "plate.nc"
    program.write_text(OF_FANUC.replace("M98 P2000\n", "M98 P2000\nG0 X0.\nM98 P2000\n"))
    (tmp_path / "plate.nc.toml").write_text(
        "[tools]\n1 = { length = 90, diameter = 10 }\n[wcs]\nG54 = [0, 0, 60]\n"
        '[stock]\nsystem = "G54"\nmin = [30, -10, 0]\nmax = [60, 10, 20]\n'
    )
    other = tmp_path / "O2000.nc"
    for text, code, own_line, worst in (
        ("G1 X5. F500.\nX900.\nX20.\n", "VP101", 3, "joint x reaches 900.000 mm"),
        ("G1 X5. F500.\nG0 Z10.\nX40.\nZ160.\n", "VP216", 4, "the cutter runs into the stock in a rapid traverse"),
    ):
        other.write_text(f"O2000\n{text}M99\n")
        found = json.loads(run("check", program, "--machine", "ac_trunnion", "--output-format", "json").out)
        first, *others = (one for one in found["programs"][0]["findings"] if one["code"] == code)
        calls = ((10, 12), (10,))[code == "VP216"]  # the second cuts no stock
        assert [(one["line"], one["file"], one["file_line"]) for one in (first, *others)] == [
            (call, str(other), own_line) for call in calls
        ]
        assert first["message"].startswith(f"O2000.nc, line {own_line}: {worst}")
        shown = run("check", program, "--machine", "ac_trunnion").out
        caret = "    | ^\n" if code == "VP101" else ""
        assert f"  {own_line} | {text.splitlines()[own_line - 2]}\n{caret}" in shown
        told = run("check", program, "--machine", "ac_trunnion", "--output-format", "sarif").out
        results = (one for one in json.loads(told)["runs"][0]["results"] if one["ruleId"] == code)
        there = next(results)["relatedLocations"][-1]["physicalLocation"]  # it was the line of the call
        assert there["artifactLocation"]["uri"].endswith("/O2000.nc")
        assert there["region"] == {"startLine": own_line}
        assert "line 10" not in first["message"]


def test_an_error_in_a_called_file_that_the_program_has_caused_stands_in_the_program(
    run: Callable[..., Any], tmp_path: Path
) -> None:
    """A line of the program was named as one of the file."""
    head = "G710 G90 G54\nT1 D1\nM6\nS9 M3\nG0 X0 Y0 Z150 A0 C0\nF500\nMCALL CYCLE81(140,110,2,100)\nX10\n"
    program = tmp_path / "flange.mpf"
    program.write_text(f"{head}G0 Z160\nSLOT(3)\nG0 Z160\nM30\n", "utf-8")
    (tmp_path / "flange.mpf.toml").write_text("[tools]\n1 = { length = 90 }\n[wcs]\nG54 = [0, 0, 60]\n", "utf-8")
    (tmp_path / "SLOT.SPF").write_text("PROC SLOT(REAL L)\nG1 Z=110 F500\nX=IC(L)\nRET\n", "utf-8")
    (error,) = json.loads(run("check", program, "--output-format", "json").out)["programs"][0]["findings"]
    assert (error["code"], error["line"]) == ("VP017", 9)
    assert error["message"].startswith("MCALL of line 7 still calls CYCLE81; write MCALL alone before line 9 (SLOT.SPF")
    assert "(SLOT.SPF, line 2: CYCLE81: the tool is at 110 mm" in error["message"]


def test_one_cause_in_a_called_file_is_one_error(run: Callable[..., Any], tmp_path: Path) -> None:
    """Each line of the file was an error of the same plane."""
    program = tmp_path / "main.h"
    lines = "TOOL CALL 1 Z S3000\nL X+0 Y+0 Z+150 A+0 C+0 R0 FMAX M3\nPLANE SPATIAL SPA+20 SPB+0 SPC+0 STAY\n"
    program.write_text(f"BEGIN PGM main MM\n{lines}CALL PGM sub.h\nPLANE RESET STAY\nM30\nEND PGM main MM\n")
    (tmp_path / "sub.h").write_text("BEGIN PGM sub MM\nL X+5 Y+5 R0 FMAX\nL Z+140 F200\nL X+10\nEND PGM sub MM\n")
    told = run("check", program, "--tool-length", 80, "--wcs", "G54=0,0,60", "--output-format", "json").out
    (error,) = json.loads(told)["programs"][0]["findings"]
    assert (error["code"], error["line"], error["count"]) == ("VP017", 5, 3)
    assert error["message"].startswith("sub.h, line 2: a motion in a tilted plane that the tool is not normal to")


@pytest.mark.parametrize(("before", "meant"), [("G0 X1.\n", "X45."), ("", "X45."), ("G0 X1\n", "X45")])
def test_a_comma_in_a_called_file_stands_for_a_point_where_numbers_have_one(
    tmp_path: Path, before: str, meant: str
) -> None:
    """X45 was proposed, and VP038 followed; in the program it was X45. already."""
    (tmp_path / "O2000.nc").write_text("O2000\nG1 X45, F900.\nM99\n")
    (tmp_path / "plate.nc").write_text(OF_FANUC.replace("M98", f"{before}M98"))
    found = verne_post.check(tmp_path / "plate.nc", machine="verne").findings
    (error,) = (item for item in found if item.code == "VP001")
    assert error.message == f"X45,: a comma after a number; did you mean {meant}?"


def test_an_axis_beyond_its_travel_at_the_start_stands_at_its_word(run: Callable[..., Any], tmp_path: Path) -> None:
    """The first naming of A says where it stands before, and the first line of all was blamed."""
    program = tmp_path / "part.nc"
    program.write_text("G21 G90\nG54 G0 X0 Y0\nG0 Z150\nG1 A120 F500\nG0 Z180\nM2\n")
    told = run("check", program, "--machine", "serial", "--tool-length", 80, "--wcs", "G54=0,0,60")
    assert "part.nc:4: VP102 error: " in told.out
