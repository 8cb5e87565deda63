"""No command writes over a file that it reads, or that it makes in the same run: whatever the file is called, by name
or by link.
"""

import ast
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import verne_post
from verne_post.cli.files import FileError, RunFiles
from verne_post.config import list_machine_files

PROGRAM = "G21 G90 G64\nT1 M6\nG43 H1\nG0 X0 Y0 Z80 A0 C0\no<subx> call\nG1 X5\nM2\n"
SUBPROGRAM = "o<subx> sub\nG1 X9 F3000\no<subx> endsub\n"
#: What a run may read: file -> content and the option that names it.
INPUTS = {
    "p.nc": (PROGRAM, None),
    "subx.ngc": (SUBPROGRAM, None),
    "verne-post.toml": ('[check]\nbaseline = "known.json"\n', None),
    "known.json": ('{"schema": 1, "known": {}}\n', None),
    "m.toml": (list_machine_files()["verne"].read_text("utf-8"), "--machine"),
    "t.tbl": ("T1 P1 Z60 D6\n", "--tool-table"),
    "lengths.csv": ("tool,length_mm\n1,60\n", "--tool-lengths"),
    "offsets.csv": ("system,x_mm,y_mm,z_mm\nG54,0,0,20\n", "--measured-offset"),
    "shapes.toml": ("[tool.1]\ncutter = {diameter = 6.0, length = 20.0}\n", "--tool-shapes"),
    "v.var": ("5220\t1\n", "--parameters"),
}
OPTIONS = tuple(word for name, (_text, option) in INPUTS.items() if option for word in (option, name))
#: Every option that names a file to write, with what comes before it and how its name must end.
WRITERS = {
    "convert -o": (("convert", "p.nc", *OPTIONS, "-o"), ""),
    "convert --meta": (("convert", "p.nc", *OPTIONS, "-o", "rows.csv", "--meta"), ""),
    "convert --events": (("convert", "p.nc", *OPTIONS, "-o", "rows.csv", "--events"), ".csv"),
    "convert --write-parameters": (("convert", "p.nc", *OPTIONS, "-o", "rows.csv", "--write-parameters"), ""),
    "check --output-file": (("check", "p.nc", *OPTIONS, "--output-file"), ""),
    "check --write-baseline": (("check", "p.nc", *OPTIONS, "--write-baseline"), ""),
    **{f"check --{name}": (("check", "p.nc", *OPTIONS, f"--{name}"), "") for name in ("junit", "sarif", "markdown")},
    "report -o": (("report", "p.nc", *OPTIONS, "-o"), ""),
    "report --static": (("report", "p.nc", *OPTIONS, "--static"), ".svg"),
    "batch --junit": (("batch", "p.nc", *OPTIONS, "-j", "1", "-o", "out", "--junit"), ""),
    "batch --sarif": (("batch", "p.nc", *OPTIONS, "-j", "1", "-o", "out", "--sarif"), ""),
    "batch --markdown": (("batch", "p.nc", *OPTIONS, "-j", "1", "-o", "out", "--markdown"), ""),
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A program with everything that it may be read with."""
    monkeypatch.chdir(tmp_path)
    for name, (text, _option) in INPUTS.items():
        Path(name).write_text(text, encoding="utf-8")
    return tmp_path


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def names_of(name: str, ending: str) -> Iterator[str]:
    """A file under the names that lead to it: its own, in other words, absolute, and by both kinds of links."""
    if name.endswith(ending):
        yield from (name, f"./{name}", f"sub/../{name}", str(Path(name).absolute()))
    yield from (f"soft{ending}", f"hard{ending}")


@pytest.mark.parametrize("writer", WRITERS)
def test_a_free_name_is_written(folder: Path, run: Callable[..., Any], writer: str) -> None:
    """The commands of the next test are good but for the name."""
    words, ending = WRITERS[writer]
    answer = run(*words, f"free{ending}")
    assert answer.code == 0, answer.err
    assert Path(f"free{ending}").stat().st_size > 0
    after = contents(folder)
    assert all(after[name].decode() == text for name, (text, _option) in INPUTS.items())


@pytest.mark.parametrize(
    ("writer", "name"),
    [
        (writer, name)
        for writer in WRITERS
        for name in INPUTS
        if name != "known.json" or (writer.startswith("check") and writer != "check --write-baseline")
    ],
)
def test_no_option_names_a_file_that_is_read(folder: Path, run: Callable[..., Any], writer: str, name: str) -> None:
    words, ending = WRITERS[writer]
    Path("sub").mkdir()
    Path(f"soft{ending}").symlink_to(name)
    os.link(name, f"hard{ending}")
    before = contents(folder)
    for written in names_of(name, ending):
        answer = run(*words, written)
        assert answer.code == 2, written
        assert "this is the file of" in answer.err
        assert Path(written).name in answer.err
        assert contents(folder) == before, written


@pytest.mark.parametrize(
    "words",
    [
        ("check", "p.nc", "--output-file", "x", "--write-baseline", "x"),
        ("check", "p.nc", "--output-file", "link", "--write-baseline", "old"),
        ("report", "p.nc", "-o", "x.svg", "--static", "./x.svg"),
        ("convert", "p.nc", "-o", "link", "--meta", "old"),
        ("batch", "p.nc", "-o", "out", "--junit", "x", "--sarif", "x"),
        ("batch", "p.nc", "-o", ".", "--junit", "p.csv"),
        ("batch", "p.nc", "-o", ".", "--junit", "p.csv.meta.json"),
        ("batch", "p.nc", "-o", ".", "--sarif", "batch.json"),
        ("batch", "p.nc", "-o", ".", "--split-at-stops", "--sarif", "p.7.csv"),
        ("batch", "p.txt", "-o", ".", "--format", "linuxcnc"),
        ("batch", "p.nc", "p.csv.meta.json", "-o", "."),
        ("convert", "p.1.nc", "--split-at-stops", "-o", "p.nc"),
        ("convert", "caller.nc", "--split-at-stops", "-o", "sub.nc"),
        ("machine", "show", "m.svg", "--plot", "m.svg"),
        ("machine", "show", "m.toml", "--plot", "m.svg"),
    ],
)
def test_no_run_meets_its_own_files(folder: Path, run: Callable[..., Any], words: tuple[str, ...]) -> None:
    for name in ("batch.nc", "p.txt", "p.1.nc", "p.csv.meta.json"):
        Path(name).write_text(PROGRAM)
    Path("caller.nc").write_text(PROGRAM.replace("<subx>", "<sub.1>"))
    Path("sub.1.nc").write_text(SUBPROGRAM.replace("<subx>", "<sub.1>"))
    Path("old").write_text("old")
    Path("link").symlink_to("old")
    Path("m.svg").symlink_to("m.toml")
    before = contents(folder)
    place = () if words[0] == "machine" else ("--tool-length", 60, "--wcs", "G54=0,0,20")
    answer = run(*words, *place)
    assert answer.code == 2, answer.err
    assert "choose another" in answer.err
    assert contents(folder) == before


def redirected(folder: Path, environment: dict[str, str], words: str) -> "subprocess.CompletedProcess[str]":
    """A command line of a shell."""
    line = words.replace("verne-post", f"{sys.executable} -P -m verne_post", 1)
    return subprocess.run(
        ["sh", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=120
    )


PLACE = "--tool-length 60 --wcs G54=0,0,20"


@pytest.mark.parametrize(
    "words",
    [
        f"verne-post p.nc {PLACE} >> p.nc",
        f"verne-post p.nc {PLACE} >> subx.ngc",
        f"verne-post p.nc {PLACE} -o log 2>> log",
        f"verne-post - --subroutine-path . {PLACE} -o p.nc < p.nc",
        "verne-post machine show m.toml >> m.toml",
        f"verne-post batch p.nc {PLACE} -o . > batch.json",
    ],
)
def test_redirected_streams_are_files_too(folder: Path, environment: dict[str, str], words: str) -> None:
    Path("log").write_text("before\n")
    before = contents(folder)
    answer = redirected(folder, environment, words)
    assert answer.returncode == 2
    after = contents(folder)
    assert after.pop("log").startswith(before.pop("log"))
    assert {name: raw for name, raw in after.items() if raw} == before


def test_streams_and_devices_are_written_through(folder: Path, environment: dict[str, str]) -> None:
    plain = redirected(folder, environment, f"verne-post p.nc {PLACE} > plain.csv")
    assert plain.returncode == 0, plain.stderr
    rows = Path("plain.csv").read_bytes()
    assert rows.startswith(b"t_s,")
    # a file behind the name of a stream is not replaced: what is in it stays
    assert redirected(folder, environment, f"verne-post p.nc {PLACE} -o /dev/stdout > rows.csv").returncode == 0
    assert Path("rows.csv").read_bytes() == rows
    Path("log").write_text("before\n")
    assert (
        redirected(folder, environment, f"verne-post p.nc {PLACE} -o a.csv --meta /dev/stdout >> log").returncode == 0
    )
    assert Path("log").read_text().startswith('before\n{\n  "schema"')
    # a device serves twice, a pipe takes what it is given
    both = redirected(folder, environment, f"verne-post p.nc {PLACE} -o /dev/null --meta /dev/null")
    assert both.returncode == 0, both.stderr
    piped = redirected(
        folder, environment, f"verne-post p.nc {PLACE} -o /dev/stdout --meta /dev/null | cat > piped.csv"
    )
    assert piped.returncode == 0
    assert Path("piped.csv").read_bytes() == rows


def test_the_parameter_file_that_was_read_is_not_written_back(folder: Path, run: Callable[..., Any]) -> None:
    """A control keeps one file; here the next program starts from what somebody has looked at."""
    words = ("p.nc", "--tool-length", 60, "--wcs", "G54=0,0,20", "-o", "a.csv", "--parameters", "v.var")
    before = contents(folder)
    answer = run(*words, "--write-parameters", "v.var")
    assert answer.code == 2
    assert "--write-parameters v.var: this is the file of --parameters" in answer.err
    assert contents(folder) == before
    assert run(*words, "--write-parameters", "w.var").code == 0


def test_the_baseline_of_a_settings_file_lies_beside_it(
    folder: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And not wherever the command is started: another folder may have a file of that name."""
    Path("far.nc").write_text("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 Z680 F3000\nM2\n")
    far, place = Path("far.nc").absolute(), ("--tool-length", 60, "--wcs", "G54=0,0,20")
    assert run("check", far, *place).code == 1
    assert run("check", far, *place, "--write-baseline", "new.json").code == 1
    Path("new.json").replace("known.json")
    assert run("check", far, *place).code == 0
    Path("deep").mkdir()
    Path("deep/known.json").write_text(INPUTS["known.json"][0])
    monkeypatch.chdir("deep")
    assert run("check", far, *place).code == 0


def test_commands_touch_files_in_one_place_only() -> None:
    """Whoever opens a file elsewhere in the room of the commands goes past the rule."""
    touching = {
        "open",
        "open_file",
        "read_bytes",
        "read_text",
        "write_bytes",
        "write_text",
        "mkstemp",
        "NamedTemporaryFile",
        "rename",
        "unlink",
        "remove",
        "rmtree",
        "copyfile",
        "move",
    }
    #: batch reads its records and removes its own rows; parts of an older run are removed; streams opens the null
    #: device and standard streams; temporary makes and removes what :mod:`files` writes to
    allowed = {
        "arithmetic.py": {"read_text"},  # the release of numpy
        "called_files.py": {"read_bytes"},  # whether a file is only a subprogram
        "callers.py": {"read_bytes"},  # which program calls it
        "streams.py": {"open"},
        "jobs.py": {"open", "unlink"},
        "conversion.py": {"unlink"},
        "temporary.py": {"open", "mkstemp", "unlink", "rmtree"},
    }
    for path in Path(verne_post.__file__).with_name("cli").glob("*.py"):
        tree = ast.parse(path.read_text("utf-8"))
        if path.name == "files.py":
            assert "click" not in path.read_text("utf-8")
            continue
        calls = [node.func for node in ast.walk(tree) if isinstance(node, ast.Call)]
        called = {one.attr for one in calls if isinstance(one, ast.Attribute)}
        called |= {one.id for one in calls if isinstance(one, ast.Name)}
        assert called & touching <= allowed.get(path.name, set()), path.name


def test_an_inode_that_was_given_up_is_nobodys(tmp_path: Path) -> None:
    """Writing puts a new file in the place of the old one; the system may give the old number to any other file."""
    old, other = tmp_path / "old", tmp_path / "other"
    old.write_text("old")
    os.link(old, other)
    files = RunFiles()
    files.claim(old, "-o")
    with pytest.raises(FileError, match=r"--meta .*: this is the file of -o"):
        files.claim(other, "--meta")
    files.write(old, "-o", ["new"])
    files.claim(other, "--meta")
    with pytest.raises(FileError, match=r"--events .*: this is the file of -o"):
        files.claim(tmp_path / "sub" / ".." / "old", "--events")


@pytest.mark.parametrize("first", ["reads", "claims"])
def test_the_order_in_which_files_are_named_does_not_matter(tmp_path: Path, first: str) -> None:
    files, path = RunFiles(), tmp_path / "a"
    calls = [lambda: files.note_read(path, "INPUT"), lambda: files.claim(path, "-o")]
    one, two = calls if first == "reads" else calls[::-1]
    one()
    one()
    with pytest.raises(FileError, match=r"-o .*: this is the file of INPUT"):
        two()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
@pytest.mark.parametrize("command", ["convert", "check", "report"])
def test_a_named_pipe_is_read_once(tmp_path: Path, run: Callable[..., Any], command: str) -> None:
    pipe, source = tmp_path / "part.nc", b"G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG1 X5 F1000\nM2\n"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_bytes, args=(source,), daemon=True)
    writer.start()
    place = () if command == "check" else ("-o", tmp_path / "out")
    assert run(command, pipe, "--tool-length", "60", *place).code == 0
    writer.join(timeout=10)
    assert not writer.is_alive()
