"""The same bytes on every platform and by any number of processes, nothing read from outside the folder, toppra
missing.
"""

import importlib.util
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import verne_post
from tests.conftest import SAMPLES
from verne_post.base.team import can_fork
from verne_post.model import options

PROGRAM = "G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X0.2 F900 (gr\u00fcn)\nM2\n"
OPTIONS = ("--tool-length", "60", "--wcs", "G54=0,0,20")
HOSTILE = '[options]\nsmoothing = "bogus"\n[check]\nignore = ["VP"]\nunknown = 1\n'


@pytest.mark.parametrize("command", [("dump", "moves"), ("dump", "poses"), ("convert",), ("check",)])
def test_standard_output_is_utf_8_whatever_the_console_is(
    command: tuple[str, ...], tmp_path: Path, environment: dict[str, str]
) -> None:
    (tmp_path / "gr\u00fcn.nc").write_text(
        PROGRAM.replace("X0.2", "X0.2 Z690") if command == ("check",) else PROGRAM, "utf-8"
    )
    words = [sys.executable, "-P", "-m", "verne_post", *command, "gr\u00fcn.nc", *OPTIONS]

    def out(**more: str) -> bytes:
        done = subprocess.run(words, capture_output=True, cwd=tmp_path, env={**environment, **more}, check=False)
        return done.stdout

    plain = out(PYTHONUTF8="1")
    assert plain
    assert plain == out(PYTHONUTF8="0", PYTHONIOENCODING="cp1252") == out(PYTHONIOENCODING="ascii")
    assert b"\r" not in plain
    plain.decode("utf-8")
    assert command != ("check",) or "gr\u00fcn.nc".encode() in plain


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
def test_utf_16_is_refused_by_name(encoding: str, tmp_path: Path, run: Callable[..., Any]) -> None:
    path, good = tmp_path / "part.nc", tmp_path / "good.nc"
    path.write_bytes(PROGRAM.encode(encoding))
    good.write_text(PROGRAM, "utf-8")
    for command in (("check",), ("convert",), ("dump", "moves"), ("dump", "poses")):
        answer = run(*command, path, *OPTIONS)
        assert answer.code == 2
        assert "VP022" in answer.out + answer.err
        assert "is text in UTF-16" in answer.out + answer.err
        assert "-o" in answer.out + answer.err
    result = verne_post.check(path.read_bytes(), "verne")
    assert [item.code for item in result.findings] == ["VP022"]
    if encoding == "utf-16":
        path.write_bytes("t_s,rho1_mm\n".encode(encoding))
        answer = run("verify", path, "--against", good, *OPTIONS)
        assert answer.code == 2
        assert "is text in UTF-16" in answer.err


def test_a_byte_order_mark_is_passed_over(tmp_path: Path, run: Callable[..., Any]) -> None:
    path = tmp_path / "part.nc"
    path.write_text(PROGRAM, "utf-8-sig")
    marked = run(path, *OPTIONS)
    path.write_text(PROGRAM, "utf-8")
    assert (marked.code, marked.out) == (0, run(path, *OPTIONS).out)


@pytest.mark.parametrize("solver", ["toppra", "both"])
def test_without_toppra_the_solver_says_what_is_missing(
    solver: str, tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "part.nc"
    path.write_text(PROGRAM, "utf-8")
    real = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *more: None if name == "toppra" else real(name, *more)
    )
    answer = run("check", path, *OPTIONS, "--solver", solver)
    assert (answer.code, answer.out) == (2, "")
    assert f"--solver {solver} needs toppra, which is not installed" in answer.err
    assert "pip install toppra" in answer.err
    assert run("check", path, *OPTIONS).code == 0
    with pytest.raises(verne_post.UsageError, match="needs toppra"):
        verne_post.Options(solver=solver)


def test_a_format_whose_package_does_not_load_is_refused_before_the_work(
    tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """As pyarrow beside an older numpy than it was made for."""
    package = tmp_path / "packages" / "pyarrow"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("raise ImportError('pyarrow requires NumPy 2.0 or newer, found 1.26.4')\n")
    path = tmp_path / "part.nc"
    path.write_text(PROGRAM, "utf-8")
    for name in [name for name in sys.modules if name.partition(".")[0] == "pyarrow"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.syspath_prepend(str(package.parent))
    answer = run(path, *OPTIONS, "--format", "parquet", "-o", tmp_path / "axes.parquet")
    assert (answer.code, answer.out) == (2, "")
    assert "--format parquet needs pyarrow, which does not load: pyarrow requires NumPy 2.0 or newer" in answer.err


@pytest.mark.parametrize("name", ["verne-post.toml", "pyproject.toml"])
def test_a_ceiling_hides_settings_above_it(
    name: str, tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    inner = tmp_path / "job"
    inner.mkdir()
    (inner / "part.nc").write_text(PROGRAM, "utf-8")
    text = HOSTILE if name == "verne-post.toml" else HOSTILE.replace("[", "[tool.verne-post.", 1)
    (tmp_path / name).write_text(text, "utf-8")
    monkeypatch.chdir(inner)
    words = ("check", "part.nc", *OPTIONS)
    assert run(*words).code == 2  # found one folder up
    for hidden in (tmp_path, inner):
        monkeypatch.setenv("VERNE_POST_CEILING", str(hidden))
        assert run(*words).code == 0
    (inner / "below").mkdir()
    monkeypatch.chdir(inner / "below")
    monkeypatch.setenv("VERNE_POST_CEILING", str(tmp_path.parent))
    assert run("check", "../part.nc", *OPTIONS).code == 2


@pytest.mark.skipif(not can_fork(), reason="a process of this system cannot be forked")
@pytest.mark.parametrize("file_format", ["csv", "linuxcnc"])
def test_files_are_the_same_whatever_the_number_of_processes(
    file_format: str, run: Callable[..., Any], tmp_path: Path
) -> None:
    made = []
    for jobs in (1, 2):
        rows, meta = tmp_path / f"{jobs}", tmp_path / f"{jobs}.json"
        answer = run("convert", SAMPLES / "posted.nc", "-j", jobs, "-o", rows, "--meta", meta, "--format", file_format)
        assert answer.code == 0, answer.err
        made.append((rows.read_bytes(), meta.read_bytes()))
    assert made[0] == made[1]


def test_several_processes_are_refused_where_none_can_be_forked(
    run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(options, "can_fork", lambda: False)
    answer = run("check", SAMPLES / "posted.nc", "-j", 2)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.endswith(
        "Error: --jobs 2: several processes work on a program only on Linux; batch -j runs anywhere\n"
    )
    assert run("check", SAMPLES / "posted.nc", "-j", 1).code == 0
