"""Commands that messages propose: each is run as it is printed, and has the options of its run."""

import os
import re
import shlex
import subprocess
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


def test_explain_says_where_the_reach_ends_as_check_promises(run: Callable[..., Any]) -> None:
    """A line that ends where it says is within limits, and one that ends 1 mm farther is not."""
    program = lines("G0 X0 Y0 Z50 A0 C0", "G1 Z20 F500", "X{}", "M2")
    given = ("--tool-length", "60", "--wcs", "G54=0,0,100")
    Path("far.nc").write_text(program.format(2000), "utf-8")
    assert "says where the reach ends" in run("check", "far.nc", *given).out
    shown = run("explain", "far.nc:4", *given).out
    end = float(re.findall(r"the machine reaches the line up to about X([\d.]+) Y0 Z20, ", shown)[0])
    for more, is_refused in ((-0.01, False), (1.0, True)):
        Path("near.nc").write_text(program.format(end + more), "utf-8")
        assert ("VP110" in run("check", "near.nc", *given).out) == is_refused


def test_check_says_once_what_was_not_checked_in_several_programs(run: Callable[..., Any]) -> None:
    for name in ("a.nc", "b.nc"):
        Path(name).write_text(lines("G0 X0 Y0 Z50 A0 C0", "G1 Z20 F500", "M2"), "utf-8")
    given = ("--tool-length", "60", "--wcs", "G54=0,0,100")
    shown = run("check", ".", *given).out
    assert shown.count("NOT CHECKED") == 1 and "\nNOT CHECKED in 2 programs: contact with fixtures" in shown
    assert shown.count("work offset") == 1 and "\nwork offset in 2 programs: G54 at (0, 0, 100) mm" in shown
    assert "\n  NOT CHECKED: contact with" in run("check", "a.nc", *given).out


def test_a_missing_program_is_told_in_one_way(run: Callable[..., Any]) -> None:
    """Alone, and beside another one."""
    Path("a.nc").write_text(lines("G0 X0 Y0 Z50 A0 C0", "G1 Z20 F500", "M2"), "utf-8")
    alone, beside = run("check", "nope.nc"), run("check", "a.nc", "nope.nc", "--tool-length", "60")
    assert alone.code == beside.code == 2
    assert alone.out in beside.out and alone.out.startswith("nope.nc: VP022 error: ")


def test_a_spindle_that_turns_backwards_has_one_remedy(run: Callable[..., Any]) -> None:
    Path("a.nc").write_text(lines("T1 M6", "G43 H1", "S900 M4", "G0 X0 Y0 Z50 A0 C0", "G1 Z20 F500", "M2"), "utf-8")
    shown = run("check", "a.nc", "--tool-length", "60", "--wcs", "G54=0,0,100").out
    assert "write M3 unless it is a left-hand tool" in shown
    assert "Start the spindle before the cut" not in shown


def test_a_program_without_motion_says_what_it_reads_unset(run: Callable[..., Any]) -> None:
    """The condition that the unset parameter decides is why nothing moves."""
    Path("s.mpf").write_text("IF R1 > 2\nG1 X5 F100\nENDIF\nM30\n", "utf-8")
    shown = run("check", "s.mpf").out
    assert "VP021 error" in shown and "VP025 warning" in shown


@pytest.mark.skipif(os.name == "nt", reason="such names are none there")
@pytest.mark.parametrize("name", ["-dash.nc", "t\tb.nc", "t\x01'é.nc", r"t\tb.nc"])
def test_a_shell_takes_the_name_of_a_program(run: Callable[..., Any], name: str) -> None:
    Path(name).write_text(f"{HEAD}G1 X20 F500\nM30\n", "utf-8")
    said = run("check", "--machine", "bc_trunnion", "--", name).out
    (command,) = dict.fromkeys(re.findall(r"(verne-post setup .*?) writes", said))
    words = subprocess.run(
        ["bash", "-c", f"printf '%s\\0' {command}"],
        capture_output=True,
        check=True,
        env={**os.environ, "LC_ALL": "C.UTF-8"},
    )
    assert run(*words.stdout.decode("utf-8").split("\0")[1:-1]).code == 0
    assert Path(f"{name}.toml").exists()


def test_setup_of_a_hint_completes_the_set_up_that_none_leaves_out(run: Callable[..., Any]) -> None:
    Path("B5.nc").write_text(f"{HEAD}G1 X20 F500\nM30\n", "utf-8")
    Path("B5.nc.toml").write_text("[wcs]\nG54 = [0, 0, 20]\n", "utf-8")
    (command,) = find_commands(run("check", "B5.nc", "--machine", "bc_trunnion", "--setup", "none").out)
    assert command == ["setup", "B5.nc", "--machine", "bc_trunnion"]
    assert run(*command).code == 0
    assert "measure" in Path("B5.nc.toml").read_text("utf-8")
