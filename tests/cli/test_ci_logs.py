"""A program, its set-up and names of files give an agent of a CI server no command: neither in a log nor in a file that
a job prints.
"""

import io
import json
import random
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from tests.agents import commands_in
from verne_post.base.printable import break_commands, format_json, make_printable, make_printable_in_place
from verne_post.cli.streams import TextStream

#: What begins a command of one agent or another, and what only nearly does.
HOSTILE = (
    "##vso[task.setvariable variable=PATH]x", "a ##[error]x", "##teamcity[testFailed name='x']",
    "::set-output name=a::b",
    " \t::error file=a.nc,line=1::x", "\u00a0::warning::x", "\u2003::notice::x", "###[group]x", "##VSO[task.complete]x",
    ":\u034f:error::x", "#\ufe0f#vso[task.complete]x", "##vs\u034fo[task.complete]x", "\u034f::error::x",
    "x\r::error::x",
    "x\x85::error::x", "x\u2028##[command]x", "::add-mask::::x", "##[[error]x",
    "##vso-x[y]", "#1=2 ##2[3]", "::x",
)  # fmt: skip
#: Those of them that no agent reads today.
ALIKE = HOSTILE[-3:]
HARMLESS = (
    "## [x]",
    "a::b::c",
    "12 | ::error::x",
    "#[x]",
    "G1 X#<a> (##)",
    "C:\\a",
    "std::sort",
    ": :x",
)
WORDS = ("--tool-length", "60", "--wcs", "G54=0,0,0")
PROGRAMS = {
    "rs.nc": "G21 G90 G94 G49\n"
    "(MSG, ##vso[task.complete result=Succeeded;] ::error::x)\n"
    "G0 X0 Y0 Z50 A0 C0\n"
    "G1 ##[error]boo X1\n"
    "##vso[task.setvariable variable=PATH]/tmp\n"
    "::error file=a.nc,line=1::bad\n"
    "G1 Z20 F2000\n"
    "M2\n",
    "fanuc.nc": "%\nO1 (##vso[task.complete]x)\nG21 G90\n::error::x\nG65 ##[error]x\n#1=##vso[1]\nM30\n%\n",
    "siemens.mpf": "N10 G90 G71\n"
    "::error::x\n"
    "R1=##vso[task.complete]x\n"
    'MSG("##[error]x")\n'
    "G0 X0 Y0 ##teamcity[a]\n"
    "M30\n",
    "klartext.h": "0 BEGIN PGM A MM\n1 ##vso[task.complete]x\n::error::x\n2 L X+1 ##[error]x\n3 END PGM A MM\n",
    "apt.cls": "PARTNO ##vso[task.complete]x\nGOTO/##[error]x,1,2\n::error::x\nPPRINT ##teamcity[a]\nFINI\n",
    "json.nc": '{"##vso[a]": 1}\n::error::x\n',
}


@pytest.mark.parametrize("text", HOSTILE)
def test_no_agent_finds_a_command(text: str) -> None:
    assert bool(commands_in(text)) == (text not in ALIKE)
    for shown in (
        break_commands(text),
        make_printable(text),
        make_printable_in_place(text),
        f"a\n{break_commands(text)}",
    ):
        assert commands_in(shown) == []
    assert len(make_printable_in_place(text)) == len(text)
    assert json.loads(format_json({text: text})) == {text: text}
    assert commands_in(format_json([text], 2)) == commands_in(format_json(text, ensure_ascii=False)) == []
    # how often a text is broken does not matter
    assert break_commands(break_commands(text)) == break_commands(text)


@pytest.mark.parametrize("text", HARMLESS)
def test_other_texts_stay_as_they_are(text: str) -> None:
    assert break_commands(text) == make_printable(text) == make_printable_in_place(text) == text


def test_commands_in_pieces() -> None:
    """However a text is cut, the stream writes what the whole would be, and nothing of another text is lost."""
    chance = random.Random(5)
    for _ in range(2000):
        text = "".join(
            chance.choice((*HOSTILE, *HARMLESS, "\n", "a", " ", ":", "#")) for _ in range(chance.randint(1, 5))
        )
        raw = io.BytesIO()
        stream = TextStream(raw, "utf-8", newline="\n")
        at = 0
        while at < len(text):
            size = chance.randint(1, 6)
            assert stream.write(text[at : at + size]) == len(text[at : at + size])
            at += size
        stream.flush()
        shown = raw.getvalue().decode()
        assert commands_in(shown) == []
        assert re.sub(r"\\u00(3a|5b)", lambda found: chr(int(found[1], 16)), shown) == text


@pytest.fixture
def hostile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The current folder with hostile programs under hostile names; their names."""
    monkeypatch.chdir(tmp_path)
    folder = Path("##[group]d")
    folder.mkdir()
    for name, text in PROGRAMS.items():
        Path(f"::error::{name}").write_text(text)
        (folder / f"##vso[task.complete]{name}").write_text(text)
    return sorted(map(str, [*Path().glob("::*"), *folder.iterdir()]))


def _own_commands(log: str) -> None:
    """Every command is an annotation of ours, whose file is one of the programs."""
    for line in log.splitlines():
        if commands_in(line):
            assert re.match(r"::(error|warning|notice) (file=[^:]*,|title=verne-post)", line), line


@pytest.mark.parametrize("output_format", ["text", "json", "jsonl", "sarif", "junit", "github", "markdown"])
def test_findings_in_every_format(hostile: list[str], run: Callable[..., Any], output_format: str) -> None:
    """The commands of the format github are those that it means; what programs read from the others is what the files
    say.
    """
    answer = run("check", *hostile, *WORDS, "--output-format", output_format)
    assert answer.code == 2
    assert answer.out
    if output_format == "github":
        _own_commands(answer.out)
        assert all(found.startswith("github") for found in commands_in(answer.out))
        assert len(commands_in(answer.out)) >= 10
        return
    assert commands_in(answer.out) == commands_in(answer.err) == []
    run("check", *hostile, *WORDS, "--output-format", output_format, "--output-file", "findings")
    assert commands_in(Path("findings").read_text()) == []
    if output_format == "json":
        assert [one["program"] for one in json.loads(answer.out)["programs"]] == hostile
    if output_format == "junit":
        assert len(list(ElementTree.fromstring(answer.out).iter("testcase"))) == len(hostile)


def test_a_failure_in_every_format(hostile: list[str], run: Callable[..., Any]) -> None:
    Path("bad.toml").write_text("[options]\n'##vso[task.complete]x' = 1\n['::error::x']\n")
    for output_format in ("json", "jsonl", "sarif", "junit", "github"):
        answer = run("check", hostile[0], "--settings", "bad.toml", "--output-format", output_format)
        assert answer.code == 2
        _own_commands(answer.out)
        assert commands_in(answer.err) == []
        assert output_format == "github" or commands_in(answer.out) == []


@pytest.mark.parametrize("words", [
    ("convert", "::ok.nc", *WORDS, "--events", "events.csv", "--meta", "-", "-o", "##[a].csv"),
    ("explain", "::ok.nc:5", *WORDS), ("explain", "::error::rs.nc:4", *WORDS), ("dump", "moves", "::ok.nc"),
    ("fit", "::ok.nc", "--tool-length", "60"), ("verify", "::error::none.csv", "--against", "::ok.nc"),
    ("::error::no such.nc",), ("::ok.nc", "--##vso[task.complete]x"),
    ("::ok.nc", "--tool-table", "::error::x.tbl", "--smoothing", "##[a]"),
    ("::ok.nc", "--machine", "##[a].toml"), ("machine", "show", "##[a].toml"), ("machine", "validate", "##[a].toml"),
    ("::ok.nc", *WORDS[:2], "--parameters", "::error::p.var"), ("::ok.nc", "--tool-table", "##vso[a].tbl"),
    ("::ok.nc", "--setup", "##vso[a].toml"), ("batch", ".", "-o", "##[out]", "--github", *WORDS),
])  # fmt: skip
def test_every_command_in_a_process_of_its_own(
    hostile: list[str], spawn: Callable[..., "subprocess.CompletedProcess[bytes]"], words: tuple[str, ...]
) -> None:
    Path("::ok.nc").write_text(
        "G21 G90\n(MSG, ##vso[task.complete]x)\n(MSG, ::error::x)\nG0 X0 Y0 Z50 A0 C0\nG1 Z20 F2000\nM2\n"
    )
    text = (Path(__file__).resolve().parents[2] / "machine_configs" / "verne.toml").read_text()
    Path("##[a].toml").write_text(
        re.sub('name = "[^"]*"', 'name = "##vso[task.complete]x \\\\u001b[31m\\\\n::error::x"', text, count=1)
    )
    Path("::error::p.var").write_text("##vso[task.complete]x\n::error::x\n")
    Path("##vso[a].tbl").write_text("T1 P1 Z60 ;##vso[task.complete]x\n::error::x\n")
    Path("##vso[a].toml").write_text("'##vso[task.complete]x' = 1\n['::error::x']\n")
    answer = spawn(*words, cwd=Path.cwd())
    log = answer.stdout.decode() + answer.stderr.decode()
    assert log
    assert "\x1b" not in log
    if words[0] == "batch":
        _own_commands(log)
        log = "".join(line for line in log.splitlines(keepends=True) if not line.startswith("::"))
    assert commands_in(log) == []
    for path in [*Path().glob("*.csv"), *Path("##[out]").rglob("*.json")]:
        assert commands_in(path.read_text()) == []


def test_the_caret_stays_under_its_column(hostile: list[str], run: Callable[..., Any]) -> None:
    said = run("check", "::error::rs.nc", *WORDS).out.splitlines()
    at = said.index("  4 | G1 ##?error]boo X1")
    assert said[at + 1].index("^") - len("  4 | ") == 6


def expand_words(command: str, **variables: str) -> list[str]:
    """The words that verne-post gets of a command in bash."""
    text = f'verne-post() {{ printf "%s\\0" "$@"; }}\n{command}'
    done = subprocess.run(["bash", "-uc", text], env=variables, capture_output=True, text=True, check=True)
    return done.stdout.split("\0")[:-1]


@pytest.mark.skipif(shutil.which("bash") is None, reason="the workflow runs in bash")
def test_the_commands_of_the_workflow_in_the_docs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any]
) -> None:
    """The workflow is valid YAML, nothing of its inputs is pasted into a shell, and its commands write what its other
    steps read.
    """
    yaml = pytest.importorskip("yaml")
    page = (Path(__file__).parents[2] / "docs" / "ci.md").read_text("utf-8")
    called, caller = [yaml.safe_load(text) for text in re.findall(r"```yaml\n(name: .*?)```", page, re.DOTALL)]
    given = caller["jobs"]["programs"]["with"]
    # a called workflow may ask for no more than the caller gives it
    assert called["permissions"] == caller["jobs"]["programs"]["permissions"]
    # YAML reads the key "on" as true
    assert set(given) <= set(called[True]["workflow_call"]["inputs"])
    monkeypatch.chdir(tmp_path)
    Path("programs").mkdir()
    Path("programs/part.nc").write_text("G21 G90\nG0 X0 Y0 Z20 A0 C0\nG12\nM2\n")
    steps = called["jobs"]["check"]["steps"]
    install, check = [step["run"] for step in steps if "run" in step]
    assert "${{" not in install + check
    assert install == 'pip install "$PACKAGE"'
    rest = expand_words(check, PROGRAMS=given["programs"], MACHINE="", GITHUB_STEP_SUMMARY="summary.md")
    assert "--machine" not in rest  # the settings of the repository decide
    named = expand_words(check, PROGRAMS=given["programs"], MACHINE="my machine.toml", GITHUB_STEP_SUMMARY="summary.md")
    assert [word for word in named if word not in rest] == ["--machine", "my machine.toml"]
    answer = run(*rest)
    assert answer.code == 2
    assert answer.out.startswith("::error file=programs/part.nc,line=3")
    assert "| programs/part.nc | refused" in Path("summary.md").read_text()
    assert steps[-1]["if"].startswith("${{ inputs.sarif && !github.event.pull_request.head.repo.fork && ")
    assert called[True]["workflow_call"]["inputs"]["sarif"]["default"] is True
    assert steps[-1]["with"]["sarif_file"] == "findings.sarif"
    assert json.loads(Path("findings.sarif").read_text())["runs"][0]["results"]


def test_other_servers_read_what_the_commands_in_the_docs_write(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any]
) -> None:
    yaml = pytest.importorskip("yaml")
    page = (Path(__file__).parents[2] / "docs" / "ci.md").read_text("utf-8")
    job = yaml.safe_load(re.findall(r"```yaml\n(verne-post:.*?)```", page, re.DOTALL)[0])["verne-post"]
    stages = re.findall(r"```groovy\n(.*?)```", page, re.DOTALL)[0]
    jenkins = re.findall(r"sh '\.venv/bin/(verne-post check .*)'", stages)
    read = [[job["artifacts"]["reports"]["junit"]], re.findall(r"(?:junit |pattern: )'(.*?)'", stages)]
    assert job["artifacts"]["when"] == "always"
    assert [len(files) for files in read] == [1, 2]
    for number, (command, files) in enumerate(zip([job["script"][-1], *jenkins], read, strict=True)):
        (folder := tmp_path / str(number)).mkdir()
        monkeypatch.chdir(folder)
        Path("programs").mkdir()
        Path("programs/part.nc").write_text("G21 G90\nG0 X0 Y0 Z20 A0 C0\nG12\nM2\n")
        assert run(*command.split()[1:]).code == 2  # the job fails, and its files are there
        assert all("G12" in Path(file).read_text() for file in files)


@pytest.mark.parametrize(
    ("command", "words", "status"),
    [
        ("check", ("part.nc", *WORDS), 1),
        ("check", ("part.nc", *WORDS, "-q"), 1),
        ("check", ("part.nc", "--machine", "nowhere.toml"), 2),
        ("check", ("part.nc", "--cycle", "-1"), 2),
        ("batch", ("part.nc", *WORDS, "-o", "out", "-j", "1"), 1),
    ],
)
def test_one_check_writes_every_format(
    command: str,
    words: tuple[str, ...],
    status: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    run: Callable[..., Any],
) -> None:
    """The files are those that --output-format writes, also where the check cannot begin."""
    monkeypatch.chdir(tmp_path)
    Path("part.nc").write_text("G21 G90\nG0 X0 Y0 Z20 A0 C0\nG1 X9000 F600\nM2\n")
    formats = ("junit", "sarif", "markdown")
    answer = run(command, *words, *(word for name in formats for word in (f"--{name}", name)))
    assert answer.code == status
    for name in formats:
        if command == "check":
            told = run("check", *(word for word in words if word != "-q"), "--output-format", name).out
            # two runs take two times
            texts = [re.sub(r' time="[^"]*"', "", text) for text in (Path(name).read_text(), told)]
            assert texts[0] == texts[1]
        assert ("part.nc" in Path(name).read_text()) is (status == 1)
