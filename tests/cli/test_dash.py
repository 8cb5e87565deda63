"""``-`` in the place of a file: standard input or standard output, for one file of a run, and never a file of this
name.
"""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import pytest

from verne_post.cli.main import COMMANDS, cli

ROOT = Path(__file__).resolve().parents[2]
VERNE = (ROOT / "machine_configs" / "verne.toml").read_bytes()
PROGRAM = "G21 G90 G94 G17\nT1 M6\nG43 H1\nG0 X0 Y0 Z20 A0 C0\nG1 X3 F3000\nY2 A3 C5\nM2\n"
TABLE = b"T1 P1 Z80 D10\n"
SETUP = "tool_length = 80\nwcs.G54 = [0, 0, 50]\n"
Run = Callable[..., Any]

#: Parameters that name files and do not take "-": what a refusal says. (Folders, and names whose ending is the format.)
REFUSED = {
    ("convert", "--events"): "expected a name that ends in", ("report", "--static"): "expected a name that ends in",
    ("machine show", "--plot"): "expected a name that ends in",
    ("machine calibrate", "--plot"): "expected a name that ends in",
    ("machine calibrate", "--output"): "a second file is written", ("batch", "--output"): "a folder is needed",
    ("machine axis-check", "--output"): "a folder is needed",
}  # fmt: skip


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with a program and its set-up."""
    monkeypatch.chdir(tmp_path)
    Path("part.nc").write_text(PROGRAM)
    Path("part.nc.toml").write_text(SETUP)


def _commands(group: click.Group, prefix: str = "") -> list[tuple[str, click.Command]]:
    context = click.Context(group)
    found: list[tuple[str, click.Command]] = []
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        assert command is not None
        found += _commands(command, f"{name} ") if isinstance(command, click.Group) else [(prefix + name, command)]
    return found


def test_every_parameter_that_names_a_file_to_write_takes_a_dash_or_refuses_it(run: Run) -> None:
    assert {"convert", "machine"} <= set(COMMANDS)
    words = {
        "batch": ("part.nc",),
        "machine show": (),
        "machine calibrate": ("x.csv", "-o", "m.toml"),
        "report": ("part.nc", "-o", "r.html"),
        "machine axis-check": ("--at", "0,0,0,0,0"),
        "convert": ("part.nc",),
    }
    seen = set()
    for name, command in _commands(cli):
        for parameter in command.params:
            if not isinstance(parameter.type, click.Path) or not isinstance(parameter, click.Option):
                continue
            flag = next(one for one in parameter.opts if one.startswith("--"))
            if (name, flag) in REFUSED:
                seen.add((name, flag))
                others = [word for word in words[name] if not (flag == "--output" and word in ("-o", "m.toml"))]
                answer = run(*name.split(), *others, flag, "-")
                assert answer.code == 2, (name, flag)
                assert REFUSED[name, flag] in answer.err, (name, flag, answer.err)
    assert seen == set(REFUSED)
    assert not Path("-").exists()


@pytest.mark.parametrize(("words", "stdin"), [
    (("check", "part.nc", "--setup", "-"), SETUP.encode()),
    (("check", "part.nc", "--machine", "-"), VERNE),
    (("check", "part.nc", "--settings", "-"), b"[options]\ntolerance = 0.02\n"),
    (("check", "part.nc", "--tool-table", "-"), TABLE),
    (("check", "part.nc", "--tool-lengths", "-"), b"tool,length_mm\n1,80\n"),
    (("check", "part.nc", "--measured-offset", "-"), b"system,x_mm,y_mm,z_mm\nG54,0,0,50\n"),
    (("check", "part.nc", "--parameters", "-"), b"5221\t0\n"),
    (("check", "part.nc", "--tool-shapes", "-"), b"[tool.1]\ncutter = { diameter = 8.0, length = 20.0 }\n"),
    (("check", "part.nc", "--baseline", "-"), b'{"schema": 1, "known": {}}'),
    (("check", "-", "--setup", "part.nc.toml"), PROGRAM.encode()),
    (("explain", "-:5", "--setup", "part.nc.toml"), PROGRAM.encode()),
    (("fit", "part.nc", "--free", "z", "--machine", "-"), VERNE),
    (("machine", "validate", "-"), VERNE),
    (("machine", "show", "-"), VERNE),
])  # fmt: skip
def test_input_is_read_from_standard_input(run: Run, words: tuple[str, ...], stdin: bytes) -> None:
    answer = run(*words, stdin=stdin)
    assert answer.code == 0, answer.out + answer.err


def test_what_stands_in_standard_input_counts(run: Run) -> None:
    """The set-up and the machine file of standard input are those of the run, for every program of it."""
    Path("other.nc").write_text(PROGRAM)
    answer = run("check", "part.nc", "other.nc", "--setup", "-", stdin=b"tool_length = 81\nwcs.G54 = [1, 2, 53]\n")
    assert "in 2 programs: G54 at (1, 2, 53)" in answer.out and "in 2 programs: tool 1: 81 mm" in answer.out
    shown = [run("machine", "validate", "-", stdin=raw).out for raw in (VERNE, VERNE + b"\n# another file\n")]
    assert shown[0] != shown[1] and shown[0].startswith("<stdin>: VERNE")


def test_verify_reads_any_of_its_files_from_standard_input(run: Run) -> None:
    run("part.nc", "-o", "axes.csv", "--meta", "meta.json", "-q")
    rows, meta = Path("axes.csv").read_bytes(), Path("meta.json").read_bytes()
    assert run("verify", "-", "--against", "part.nc", stdin=rows).code == 0
    placed = ("--setup", "part.nc.toml")
    assert run("verify", "axes.csv", "--against", "-", *placed, stdin=PROGRAM.encode()).code == 0
    assert run("verify", "axes.csv", "--against", "part.nc", "--meta", "-", stdin=meta).code == 0
    log = run("verify", "axes.csv", "--against", "part.nc", "--measured", "-", stdin=rows)
    assert log.code == 0 and "<stdin>" in log.err


@pytest.mark.parametrize(("words", "begins"), [
    (("part.nc", "-o", "-"), "t_s,"),
    (("part.nc", "-o", "axes.csv", "--meta", "-"), "{"),
    (("part.nc", "-o", "axes.csv", "--write-parameters", "-"), "5161"),
    (("check", "part.nc", "--output-file", "-", "--output-format", "json"), "{"),
    (("check", "part.nc", "--output-file", "found.txt", "--write-baseline", "-"), "{"),
    (("batch", ".", "-o", "out", "-q", "--junit", "-"), "<?xml"),
    (("batch", ".", "-o", "out", "-q", "--sarif", "-"), "{"),
    (("machine", "perturb", "--seed", "1", "-o", "-"), "# The VERNE"),
])  # fmt: skip
def test_output_is_written_to_standard_output_and_nothing_else_is(
    run: Run, words: tuple[str, ...], begins: str
) -> None:
    answer = run(*words)
    assert answer.code == 0, answer.err
    assert answer.out.startswith(begins)
    if begins == "{":
        json.loads(answer.out)
    assert not Path("-").exists()


@pytest.mark.parametrize(("words", "why"), [
    (("-", "--machine", "-"), "INPUT and --machine: only one of them can be standard input"),
    (("check", "-", "--tool-table", "-"), "--tool-table and INPUT: only one of them can be standard input"),
    (("verify", "-", "--against", "-"), "AXES.CSV and INPUT: only one of them can be standard input"),
    (("check", "part.nc", "--settings", "-", "--tool-table", "-"), "only one of them can be standard input"),
    (("check", "-", "-"), "standard input can be read once"),
    (("batch", "-", "-o", "out"), "batch takes files and folders"),
    (("part.nc", "--meta", "-"), "only one of them can be standard output"),
    (("part.nc", "-o", "a.csv", "--meta", "-", "--write-parameters", "-"), "only one of them can be standard output"),
    (("check", "part.nc", "--write-baseline", "-"), "only one of them can be standard output"),
    (("batch", ".", "-o", "out", "--junit", "-"), "none with --quiet"),
    (("batch", ".", "-o", "out", "-q", "--junit", "-", "--sarif", "-"), "only one of them can be standard output"),
])  # fmt: skip
def test_a_stream_serves_one_file(run: Run, words: tuple[str, ...], why: str) -> None:
    answer = run(*words, stdin=PROGRAM.encode())
    assert answer.code == 2
    assert why in answer.err.replace("INPUT and --tool-table", "--tool-table and INPUT")
    assert answer.out == ""


def test_a_file_of_this_name_is_a_file(run: Run) -> None:
    Path("-").write_bytes(TABLE)
    assert run("check", "part.nc", "--tool-table", "./-", stdin=b"T9 Z1\n").code == 0
    assert run("part.nc", "-o", "./-").code == 0
    assert Path("-").read_bytes().startswith(b"t_s,")


def test_a_file_that_is_missing_is_named_with_its_option(run: Run) -> None:
    assert run("check", "part.nc", "--settings", "no.toml").err.endswith(
        "--settings no.toml: No such file or directory\n"
    )
    answer = run("part.nc", "--tool-table", "no.tbl")
    assert answer.err == "Error: --tool-table no.tbl: No such file or directory\n"
