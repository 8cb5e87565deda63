"""Settings are those of the folder of a program, wherever a command is run, and of each program by itself."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

PROGRAM = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM428\nG1 X9 F900\nM2\n"
SETTINGS = '[remap]\nM428 = "ignore"\n'


@pytest.fixture
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two folders with a program each; the current folder is another one, with settings of its own."""
    for name in ("one", "two", "here"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "part.nc").write_text(PROGRAM)
    (tmp_path / "one" / "verne-post.toml").write_text(SETTINGS)
    (tmp_path / "two" / "verne-post.toml").write_text('machine = "ac_trunnion"\n' + SETTINGS)
    (tmp_path / "here" / "verne-post.toml").write_text("[options]\ntolerance = 0.3\n")
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path


def test_settings_are_looked_for_from_the_folder_of_the_program(folders: Path, run: Callable[..., Any]) -> None:
    words = ("--tool-length", 60, "--wcs", "G54=0,0,60")
    answer = run("check", "../one/part.nc", *words)
    assert answer.code == 0, answer.out
    assert f"settings of {folders / 'one' / 'verne-post.toml'}" in answer.err
    assert "from ../one/verne-post.toml" in answer.out
    # a folder below the settings, and standard input: the current folder
    (folders / "one" / "deep").mkdir()
    (folders / "one" / "deep" / "part.nc").write_text(PROGRAM)
    assert run("check", "../one/deep/part.nc", *words).code == 0
    refused = run("check", "-", *words, stdin=PROGRAM.encode())
    assert (refused.code, "M428" in refused.out) == (2, True)
    assert run("check", "part.nc", *words).code == 2
    assert run("check", "part.nc", *words, "--settings", "../one/verne-post.toml").code == 0


def test_each_of_several_programs_has_its_own_settings(folders: Path, run: Callable[..., Any]) -> None:
    """Another machine, other codes, another policy."""
    words = ("--tool-length", 60, "--wcs", "G54=0,0,60")
    answer = run("check", "../one/part.nc", "../two/part.nc", "part.nc", *words, "--output-format", "json")
    one, two, here = json.loads(answer.out)["programs"]
    assert [program["machine"]["name"] for program in (one, two, here)] == [
        "VERNE",
        "AC trunnion, y on the part side",
        "VERNE",
    ]
    assert {item["code"] for item in here["findings"]} == {"VP002"}
    assert not any(item["code"] == "VP002" for item in one["findings"] + two["findings"])
    out = folders / "out"
    Path("other.nc").write_text(PROGRAM)
    run("batch", "../one", "other.nc", "-o", out, *words)
    listed = json.loads((out / "batch.json").read_text())["programs"]
    assert {item["program"]: item["status"] for item in listed} == {"../one/part.nc": 0, "other.nc": 2}
