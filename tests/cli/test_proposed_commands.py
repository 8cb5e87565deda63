"""Commands that messages propose: each is run as it is printed, and has the options of its run."""

import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

HEAD = "G21 G90 G54\nT5 M6\nG0 X0 Y0 Z50\nG43 H5\nS8000 M3\nG0 B0 C0\n"


def lines(*texts: str) -> str:
    return "".join(f"{text}\n" for text in ("G21 G90 G54", *texts))


def find_commands(text: str) -> list[list[str]]:
    """Words of each command in a text; those in a sentence end before its verb."""
    found = re.findall(r"verne-post (.*?)(?:`| writes| shows all|$)", text, re.MULTILINE)
    return [shlex.split(command) for command in dict.fromkeys(found)]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_setup_of_a_hint_writes_the_form_of_this_machine(run: Callable[..., Any]) -> None:
    Path("B 5.nc").write_text(f"{HEAD}G1 X20 F500\nM30\n", "utf-8")
    given = ["--machine", "bc_trunnion", "--dialect", "fanuc"]
    said = run("check", "B 5.nc", *given).out
    (command,) = find_commands(said)
    assert command == ["setup", "B 5.nc", *given]
    assert run(*command).code == 0
    form = Path("B 5.nc.toml").read_text("utf-8")
    assert "--machine bc_trunnion" in form and '"measure"' in form


def test_a_hint_about_a_named_set_up_extends_it(run: Callable[..., Any]) -> None:
    Path("B5.nc").write_text(f"{HEAD}G1 X20 F500\nM30\n", "utf-8")
    Path("ours.toml").write_text("[wcs]\nG54 = [0, 0, 20]\n", "utf-8")
    (command,) = find_commands(run("check", "B5.nc", "--machine", "bc_trunnion", "--setup", "ours.toml").out)
    assert run(*command).code == 0
    assert "measure" in Path("ours.toml").read_text("utf-8") and not Path("B5.nc.toml").exists()


@pytest.mark.parametrize(
    ("program", "given"),
    [
        (lines("G0 X0 Y0 Z50 A0 C0", "G1 Z20 F500", "X9000", "M2"), ("--tool-length", "60", "--wcs", "G54=0,0,40")),
        (
            lines("G0 X0 Y0 Z50 B0 C0", "G1 Z20 F500", "X9000", "M2"),
            ("--machine", "bc_trunnion", "--tool-length", "60", "--wcs", "G54=0,0,40", "--tolerance", "0.02"),
        ),
    ],
)
def test_explain_and_fit_of_a_hint_take_the_options_of_the_run(
    run: Callable[..., Any], program: str, given: tuple[str, ...]
) -> None:
    Path("far.nc").write_text(program, "utf-8")
    commands = find_commands(run("check", "far.nc", *given).out)
    assert {command[0] for command in commands} >= {"explain"}
    for command in commands:
        assert set(given) <= set(command)
        if command[0] == "explain":
            shown = run(*command)
            assert shown.code == 0 and "X9000" in shown.out and "part zero not given" not in shown.out


def test_standard_input_is_named_as_a_command_takes_it(run: Callable[..., Any]) -> None:
    program = lines("G0 X0 Y0 Z50 A0 C0", "G1 Z20 F500", "X9000", "M2")
    said = run("check", "-", "--tool-length", "60", stdin=program.encode()).out
    commands = [command for command in find_commands(said) if command[0] == "explain"]
    assert commands and commands[0][1] == "-:4"
