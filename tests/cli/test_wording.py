"""What a machinist reads on the console: what helps in this case, numbers with their units, one order of findings."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

HEAD = "G21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54\nS3000 M3\nG0 X0. Y0.\nG43 H1 Z150.\n"
SETUP = "[tools]\n1 = { length = 80 }\n[wcs]\nG54 = [0, 0, 60]\n"


@pytest.fixture
def make_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Path]:
    """A program with its set-up, in a folder of its own, which is the current one."""
    monkeypatch.chdir(tmp_path)

    def make(body: str, name: str = "part.nc", setup: str = SETUP) -> Path:
        path = Path(name)
        path.write_text(f"%\nO1\n{HEAD}{body}\nM30\n%\n", encoding="utf-8")
        if setup:
            Path(f"{name}.toml").write_text(setup, encoding="utf-8")
        return path

    return make


def test_a_third_reference_position_is_not_sent_to_the_machine_file(make_program: Any, run: Any) -> None:
    answer = run("check", make_program("G91 G30 P3 Z0."))
    assert "Write G53 G0 with the machine coordinates of this position (parameter 1242 of the control)" in answer.out
    assert "[home]" not in answer.out


def test_a_fixed_point_beyond_the_second_is_not_sent_to_the_machine_file(tmp_path: Path, run: Any) -> None:
    part = tmp_path / "part.mpf"
    part.write_text("G54 G90 G710 D1\nG0 X0 Y0 Z50\nG75 FP=3 Z=0\nM30\n", encoding="utf-8")
    answer = run("check", part, "--tool-length", 80, "--wcs", "G54=0,0,60")
    assert "Write SUPA G0 with the machine coordinates of this point (MD30600" in answer.out


def test_times_have_no_exponent(make_program: Any, run: Any) -> None:
    answer = run("check", make_program("G4 X60000.\nG4 X60000.\nG1 Z120. F500."))
    assert "the program takes 1 day 9 h, in rows of 0.001 s; --max-rows allows 100000000 rows, 1 day 4 h" in answer.out
    assert "the longest line takes 16 h 40 min" in answer.out
    assert "a dwell of 104 days 4 h: more than a day is a mistake" in run("check", make_program("G4 X9000000.")).out


def test_findings_stand_by_their_lines_everywhere(tmp_path: Path, run: Any) -> None:
    part = tmp_path / "part.mpf"
    part.write_text(
        'G54 G90 G710\nT="MILL"\nM6 D1\nG0 X0 Y0 Z90\nT="DRILL"\nM6\nFOO=3\nG55\nG0 Z91\nM30\n', encoding="utf-8"
    )
    text = [
        int(line.split(":")[1])
        for line in run("check", part).out.splitlines()
        if line.startswith(f"{part}:") and line.split(":")[1].isdecimal()
    ]
    found = json.loads(run("check", part, "--output-format", "json").out)["programs"][0]["findings"]
    sarif = json.loads(run("check", part, "--output-format", "sarif").out)["runs"][0]["results"]
    places = [one["locations"][0]["physicalLocation"]["region"]["startLine"] for one in sarif]
    lines = [one["line"] for one in found]
    assert {one["severity"] for one in found} == {"error", "warning"}
    for order in (text, lines, places):
        assert len(order) > 3 and order == sorted(order)


def test_verify_names_the_file_that_is_wrong(make_program: Any, run: Any) -> None:
    good, wrong = make_program("G1 Z120. F500."), make_program("G1 Z120. F500. K[", "wrong.nc")
    assert run("convert", good, "-o", "axes.csv").code == 0
    assert run("verify", "axes.csv", "--against", wrong).err.startswith("wrong.nc:9")
    swapped = run("verify", good, "--against", "axes.csv").err
    assert swapped.startswith("axes.csv: VP022 error: axes.csv is a setpoint file, not a program; verify reads it:")
    Path("note.pdf").write_text("")
    assert run("verify", "axes.csv", "--against", "note.pdf").err.startswith("note.pdf: VP022")
