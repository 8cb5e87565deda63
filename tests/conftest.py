"""Fixtures that several folders share: the machine, and the command line in this process or in its own."""

import gc
import io
import os
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.util import cache_from_source
from pathlib import Path
from typing import Any

from verne_post.cli import arithmetic

os.environ.update(
    arithmetic.choose_settings()
)  # before numpy is imported: rows of this process are those of a command's own

import pytest
from hypothesis import settings

import verne_post
from verne_post.__main__ import GARBAGE_AFTER
from verne_post.app.assemble import Program, assemble
from verne_post.cli.files import RunFiles
from verne_post.cli.options import build_options

#: What a shell may set and a test must not see.
_FROM_A_SHELL = (
    "NO_COLOR",
    "FORCE_COLOR",
    "CLICOLOR",
    "CLICOLOR_FORCE",
    "COLUMNS",
    "LINES",
    "PYTHONIOENCODING",
    "PYTHONWARNINGS",
    "PYTHONSTARTUP",
    "PYTHONOPTIMIZE",
    "MPLBACKEND",
    "MPLCONFIGDIR",
)
for _name in list(os.environ):
    # the schema is meant for tests/output/test_sarif_schema.py
    if _name in _FROM_A_SHELL or (_name.startswith("VERNE_POST_") and _name != "VERNE_POST_SARIF_SCHEMA"):
        del os.environ[_name]

# the same examples in every run: a suite that judges a change must not depend on chance
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.load_profile("repeatable")

ROOT = Path(__file__).resolve().parents[1]
SAMPLES = ROOT / "gcode_samples"


@dataclass(frozen=True)
class Answer:
    """What a command did: exit status and both streams."""

    code: int
    out: str
    err: str


def read_smoke_set() -> tuple[str, ...]:
    """How the names of the tests of tests/smoke.txt begin."""
    lines = (ROOT / "tests" / "smoke.txt").read_text(encoding="utf-8").splitlines()
    return tuple(line.strip() for line in lines if line.strip() and not line.startswith("#"))


SMOKE = read_smoke_set()
SMOKE_FILES = tuple(name.partition("::")[0] for name in SMOKE)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """``-m smoke`` imports no file without a test of it: to read all of them takes longer than the set."""
    if config.getoption("markexpr") != "smoke" or collection_path.suffix != ".py":
        return None
    return True if not collection_path.relative_to(ROOT / "tests").as_posix().startswith(SMOKE_FILES) else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that tests/smoke.txt names, by the beginning of their names."""
    for item in items:
        if item.nodeid.removeprefix("tests/").startswith(SMOKE):
            item.add_marker(pytest.mark.smoke)


def pytest_collectstart() -> None:
    """Fifteen thousand tests are built, and nothing of them is garbage."""
    gc.disable()


def pytest_collection_finish() -> None:
    """From here on garbage is looked for as in a command, not among what was built until now and stays to the end."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(GARBAGE_AFTER)
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def no_settings_from_outside(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """No settings file outside the folder of a test is read: neither of the checkout nor of a folder above either."""
    ceilings = (ROOT, Path(tempfile.gettempdir()), tmp_path_factory.getbasetemp())
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("VERNE_POST_CEILING", os.pathsep.join(map(str, ceilings)))
        yield


@pytest.fixture(scope="session")
def machine() -> verne_post.Machine:
    """The default machine."""
    return verne_post.load_machine()


@pytest.fixture(scope="session")
def sample_words() -> Callable[[str], list[str]]:
    """``sample_words("inch.nc")``: the set-up beside a sample, as words of the command line."""

    def words(name: str) -> list[str]:
        setup = tomllib.loads((SAMPLES / f"{name}.toml").read_text(encoding="utf-8"))
        found: list[str] = []
        for key, value in setup.items():
            if key == "wcs":
                for system, numbers in value.items():
                    found += ["--wcs", f"{system}={','.join(map(str, numbers))}"]
            else:
                found += [f"--{key.replace('_', '-')}", str(SAMPLES / value if key == "tool_table" else value)]
        return found

    return words


@pytest.fixture(scope="session")
def laid_out(machine: verne_post.Machine, sample_words: Callable[[str], list[str]]) -> Callable[..., Program]:
    """``laid_out("inch.nc", smoothing="off")``: the path and contour of a sample with the options of its set-up, and
    more.
    """

    def program(name: str, **more: Any) -> Program:
        words = sample_words(name)
        given: dict[str, Any] = {"wcs": []}
        for option, value in zip(words[::2], words[1::2], strict=True):
            match option:
                case "--wcs":
                    given["wcs"].append(value)
                case "--tool-length":
                    given["tool_length"] = float(value)
                case "--tool-table":
                    given["tool_table"] = Path(value)
                case _:
                    raise AssertionError(f"{name}: {option} is new here")
        return assemble((SAMPLES / name).read_bytes(), machine, build_options(RunFiles(), name, **given, **more))

    return program


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Callable[..., Answer]:
    """Run the command line in this process: ``run("check", path, stdin=b"...")``."""
    from verne_post.cli.main import main

    def call(*arguments: object, stdin: bytes = b"") -> Answer:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin), encoding="utf-8"))
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return Answer(code, captured.out, captured.err)

    return call


@pytest.fixture
def without_remedies(monkeypatch: pytest.MonkeyPatch) -> None:
    """Programs are refused without a search for what would cure them: it takes longer than the verdict."""
    monkeypatch.setattr("verne_post.app.remedies.refused.add_remedies", lambda _source, _program, findings: findings)


@pytest.fixture(scope="session", autouse=True)
def compiled_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Modules that new interpreters import are compiled once a session, for all workers, beside no source file.

    What is installed is compiled already, and would be once more: numpy and all others with it.
    """
    if Path(cache_from_source(verne_post.__file__)).exists():
        yield
        return
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("PYTHONDONTWRITEBYTECODE", raising=False)
        patch.setenv("PYTHONPYCACHEPREFIX", str(shared / "compiled"))
        yield


@pytest.fixture(scope="session")
def environment(compiled_once: None) -> dict[str, str]:
    """Environment in which a new interpreter finds the package under test from any folder."""
    return {**os.environ, "PYTHONPATH": str(Path(verne_post.__file__).parents[1])}


@pytest.fixture
def spawn(environment: dict[str, str]) -> Callable[..., "subprocess.CompletedProcess[bytes]"]:
    """Run the command line as a process of its own; streams as bytes."""

    def call(*arguments: object, stdin: bytes = b"", cwd: Path = ROOT) -> "subprocess.CompletedProcess[bytes]":
        command = [sys.executable, "-P", "-m", "verne_post", *map(str, arguments)]
        return subprocess.run(command, input=stdin, capture_output=True, cwd=cwd, env=environment, check=False)

    return call
