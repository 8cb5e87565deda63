"""[options] of the settings file: taken as meant, behind the command line, and refused with file and key."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import verne_post as vp

PROGRAM = "G21 G90 F1500\nG0 X0 Y0 Z20\nG1 X20\nY20\nM2\n"
PLACE = ("--tool-length", 60, "--wcs", "G54=0,0,40", "--cycle", 0.004)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.nc").write_text(PROGRAM)
    return tmp_path


def test_the_file_sets_what_the_command_line_does_not(folder: Path, run: Callable[..., Any]) -> None:
    asked = {
        name: run("a.nc", *PLACE, *words).out
        for name, words in (("off", ("--smoothing", "off")), ("wide", ("--tolerance", 0.2)))
    }
    plain = run("a.nc", *PLACE).out
    (folder / "verne-post.toml").write_text('[options]\nsmoothing = "off"\n')
    assert run("a.nc", *PLACE).out == asked["off"] != plain
    assert run("a.nc", *PLACE, "--smoothing", "spline").out == plain
    (folder / "verne-post.toml").write_text("[options]\ntolerance = 0.2\n")
    assert run("a.nc", *PLACE).out == asked["wide"] != plain


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("tolerance = -1", "options.tolerance = -1: expected 1e-06 to 10 mm"),
        ("tolerence = 0.1", "options.tolerence: this is no option of a settings file; did you mean tolerance?"),
        ('smoothing = "bogus"', "options.smoothing = 'bogus': expected one of spline, blend, off"),
        ("from_line = 3", "options.from_line: this is no option of a settings file"),
        # beside a mistake in another table, it was not told
        ("tolerance = -1\n[check]\nignor = []", "options.tolerance = -1: expected 1e-06 to 10 mm"),
        ("tolerance = -1\n[check]\nignor = []", "check.ignor is not a key of a settings file; did you mean ignore?"),
        ("wcs = {G54 = [0, 0, 1]}", "options.wcs: this is no option of a settings file"),
    ],
)
def test_mistakes_name_file_and_key(folder: Path, run: Callable[..., Any], text: str, sentence: str) -> None:
    (folder / "verne-post.toml").write_text(f"[options]\n{text}\n")
    answer = run("check", "a.nc", *PLACE)
    assert answer.code == 2
    assert f"VP503 error: {sentence}" in answer.err


def test_the_api_reads_no_settings_file(folder: Path) -> None:
    """Python has its options in the call alone."""
    (folder / "verne-post.toml").write_text('[options]\nsmoothing = "off"\n')
    options = vp.Options(tool_length=60, wcs={"G54": (0, 0, 40)}, cycle=0.004)
    result = vp.convert(Path("a.nc"), "verne", options)
    assert result.summary is not None
    assert result.summary.n_blended == 1
