"""Commands and programs that README and docs show without their output do what the page says: they are run in the order
of the page.

What is shown with its output is run by test_transcripts.py.
"""

import re
import runpy
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import pytest

from .builders import ROOT, load_maker
from .cli.test_machined import FLOOR, SHAPES, TABLE, plate
from .config.test_linuxcnc_import import write_ini
from .config.test_sinumerik_import import write_data

MAKER = load_maker("make_transcripts")
TEXTS: Final = {str(page.relative_to(ROOT)): page.read_text(encoding="utf-8") for page in MAKER.PAGES}
BLOCK: Final = re.compile(r"^```(?P<kind>\w*)\n(?P<text>.*?)^```$", re.DOTALL | re.MULTILINE)
#: The signature of a command: its optional words stand in brackets.
SYNOPSIS: Final = re.compile(r" \[[^\]]*\]")
SETUP: Final = 'tool_table = "tools.tbl"\nwcs.G54 = [0, 0, 60]\n'
#: The readings of the paper contradict the uncertainties that hold without options: the command says so, with status 1.
CONTRADICTED: Final = "verne-post machine identify MEASURED.csv"
DRIVES: Final = "[drives]\n" + "".join(
    f"{joint} = {{ unit = 'counts', scale = {10_000_000 if joint.startswith('rho') else 1000}, sign = "
    f"{-1 if joint == 'rho1' else 1} }}\n"
    for joint in ("rho1", "rho2", "rho3", "a", "c")
)


def list_commands(text: str) -> Iterator[tuple[str, str]]:
    """Kind and text: commands of verne-post, and whole programs in Python."""
    for block in BLOCK.finditer(text):
        if block["kind"] == "python":
            if re.match(r"(from|import) ", block["text"]):
                yield "python", block["text"]
            continue
        if block["kind"] not in ("sh", ""):
            continue
        for line in re.sub(r"\\?\n {2,}", " ", block["text"]).splitlines():
            if line.startswith("verne-post "):
                yield "verne-post", SYNOPSIS.sub("", re.sub(r" +#.*", "", line))


SHOWN: Final = {page: list(list_commands(text)) for page, text in TEXTS.items()}


def fill(folder: Path, page: str) -> None:
    """What the pages take as given: programs with their set-ups, tools, parts, machines."""
    for name in MAKER.FOLDERS:
        shutil.copytree(ROOT / name, folder / name)
    shutil.copytree(ROOT / "gcode_samples", folder, dirs_exist_ok=True)
    for name in (".", "programs", "before", "after"):
        (folder / name).mkdir(exist_ok=True)
        (folder / name / "part.nc").write_text(FLOOR, encoding="utf-8")
        (folder / name / "tools.tbl").write_text(TABLE, encoding="utf-8")
        if name != "." or page != "README.md":  # there the set-up is written
            (folder / name / "part.nc.toml").write_text(SETUP, encoding="utf-8")
    (folder / "shapes.toml").write_text(SHAPES, encoding="utf-8")
    (folder / "part.stl").write_bytes(plate())
    maker = runpy.run_path(str(ROOT / "gcode_samples" / "make_vise_sample.py"))
    for name, low in (("vise.stl", (-40.0, 20.0, -40.0)), ("clamp.stl", (60.0, 60.0, 1.0))):
        box = (low, tuple(one + 20.0 for one in low))
        (folder / name).write_bytes(maker["pack_stl"](maker["unite_boxes"]([box])))
    verne = (ROOT / "machine_configs" / "verne.toml").read_text(encoding="utf-8")
    (folder / "my-machine.toml").write_text(
        verne.replace("[provenance]", f'{DRIVES}\n[provenance]\ndrives = "measured"'), encoding="utf-8"
    )
    (folder / "mymill.ini").write_text(write_ini("xyzac-trt-kins"), encoding="utf-8")
    (folder / "initial.ini").write_text(write_data("P"), encoding="utf-8")
    shutil.copy(ROOT / "tests" / "reference" / "table_iii.csv", folder / "MEASURED.csv")
    (folder / "lean.nc").write_text(FLOOR, encoding="utf-8")
    (folder / "lean.nc.toml").write_text(SETUP, encoding="utf-8")


@pytest.fixture
def folder(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder as the page has it, with rows of its program where the page does not make them."""
    fill(tmp_path, request.node.callspec.params["page"])
    monkeypatch.chdir(tmp_path)
    return tmp_path


def fill_in_setup(path: Path) -> None:
    """What a person does after `setup`: a value in place of every mark."""
    text = path.read_text(encoding="utf-8")
    path.write_text(
        text.replace('length = "measure"', "length = 80").replace('"measure"', "[0, 0, 60]"), encoding="utf-8"
    )


@pytest.mark.parametrize("page", [page for page, shown in SHOWN.items() if shown])
def test_what_a_page_shows_without_its_output_runs(page: str, folder: Path, run: Callable[..., Any]) -> None:
    """Every command ends with status 0, and every program without an error."""
    for kind, text in SHOWN[page]:
        if kind == "python":
            done = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr
            continue
        words = shlex.split(text)[1:]
        if "axes.csv" in words and "-o" not in words and not Path("axes.csv").exists():
            assert run("part.nc", "-q", "-o", "axes.csv").code == 0
        answer = run(*words)
        assert answer.code == (1 if text == CONTRADICTED else 0), f"{text}\n{answer.err}{answer.out}"
        if words[0] == "setup":
            fill_in_setup(folder / f"{words[1]}.toml")


@pytest.mark.parametrize("name", [name for name, _one in load_maker("make_reference").commands()])
def test_the_example_of_help_runs(name: str, tmp_path: Path, run: Callable[..., Any], monkeypatch: Any) -> None:
    """Each command has one, and it ends with status 0."""
    fill(tmp_path, "help")
    monkeypatch.chdir(tmp_path)
    helped = run(*name.split(), "--help").out
    (example,) = re.findall(r"^  Example:\n  verne-post (.*)$", helped, re.MULTILINE)
    assert example.startswith(name)
    if "axes.csv --against" in example:
        assert run("part.nc", "-q", "-o", "axes.csv").code == 0
    few = example.partition(" > ")[0].replace("--plan 40", "--plan 20")  # the page of as-built machines plans more
    answer = run(*shlex.split(few))
    assert answer.code == 0, f"{example}\n{answer.err}{answer.out}"


def test_few_commands_are_not_run() -> None:
    """Those of other programs: pip, docker, a browser, LinuxCNC."""
    shown = [text for page in SHOWN.values() for kind, text in page if kind == "verne-post"]
    assert len(shown) >= 19
    assert not [text for text in shown if re.search(r"[\[\]]", text)]
