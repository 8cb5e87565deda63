"""Fixtures that several folders share: the machine, and the command line in this process or in its own."""

import io
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import settings

import verne_post

# the same examples in every run: a suite that judges a change must not depend on chance
settings.register_profile("repeatable", derandomize=True, deadline=None, database=None)
settings.load_profile("repeatable")

ROOT = Path(__file__).resolve().parents[1]


@dataclass(frozen=True)
class Answer:
    """What a command did: exit status and both streams."""

    code: int
    out: str
    err: str


@pytest.fixture(scope="session")
def machine() -> verne_post.Machine:
    """The default machine."""
    return verne_post.load_machine()


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Callable[..., Answer]:
    """Run the command line in this process: ``run("check", path, stdin=b"...")``."""
    from verne_post.cli.main import main

    monkeypatch.delenv("VERNE_POST_TRACEBACK", raising=False)

    def call(*arguments: object, stdin: bytes = b"") -> Answer:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin), encoding="utf-8"))
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        captured = capsys.readouterr()
        return Answer(code, captured.out, captured.err)

    return call


@pytest.fixture
def environment() -> dict[str, str]:
    """Environment in which a new interpreter finds the package under test from any folder."""
    package = str(Path(verne_post.__file__).parents[1])
    return {**os.environ, "PYTHONPATH": package, "VERNE_POST_TRACEBACK": ""}


@pytest.fixture
def spawn(environment: dict[str, str]) -> Callable[..., "subprocess.CompletedProcess[bytes]"]:
    """Run the command line as a process of its own; streams as bytes."""

    def call(*arguments: object, stdin: bytes = b"", cwd: Path = ROOT) -> "subprocess.CompletedProcess[bytes]":
        command = [sys.executable, "-P", "-m", "verne_post", *map(str, arguments)]
        return subprocess.run(command, input=stdin, capture_output=True, cwd=cwd, env=environment, check=False)

    return call
