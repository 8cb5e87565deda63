"""`explain INPUT:LINE`: the pose, the table's two solutions, the module's sixteen, and why each is refused."""

from pathlib import Path

import pytest

from verne_post.cli.main import main

PROGRAM = "G49 G0 X0 Y0 Z120 A0 C0\nG1 Z100 A60 F2000\nG1 A101\nM2\n"


def explained(tmp_path: Path, capsys: pytest.CaptureFixture[str], line: int) -> tuple[int, str]:
    program = tmp_path / "a.nc"
    program.write_text(PROGRAM, encoding="utf-8")
    status = main(["explain", f"{program}:{line}", "--tool-length", "120", "--wcs", "G54=0,0,60"])
    answer = capsys.readouterr()
    return status, answer.out + answer.err


def test_a_legal_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, text = explained(tmp_path, capsys, 2)
    assert status == 0
    assert "tip on the table     (0.000000, 0.000000, 160.000000) mm" in text
    assert "as programmed: possible" in text
    assert text.count("in use") == 1
    assert text.count("\n  alpha ") == 16
    assert text.count("refused: ") >= 15


def test_a_line_beyond_the_tilt_names_the_joint(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, text = explained(tmp_path, capsys, 3)
    assert status == 0
    assert "as programmed: refused: beyond the travel of a" in text


def test_a_line_without_motion_is_a_usage_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, text = explained(tmp_path, capsys, 4)
    assert status == 2
    assert "line 4 has no motion" in text
