"""The docs are true: tests that are named as proof exist, links lead somewhere, and commands say what the pages print."""

import ast
import math
import re
import shlex
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from verne_post.model.codes import CODES

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*(ROOT / "docs").rglob("*.md"), ROOT / "README.md"])
#: Numbers of a transcript may differ so much: another processor, another last digit; a stale page is farther off.
RELATIVE, ABSOLUTE = 1e-4, 0.005


def test_every_promise_names_tests_that_exist() -> None:
    page = (ROOT / "docs" / "promises.md").read_text(encoding="utf-8")
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", page)
    assert len(named) >= 20
    rows = [line for line in page.splitlines() if re.match(r"\| \d+ \|", line)]
    assert len(rows) == 10
    assert all("::" in row for row in rows)
    for file, name in named:
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        functions = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
        assert name in functions, f"{file}::{name}"


def test_the_smoke_set_names_tests_that_exist() -> None:
    lines = (ROOT / "tests" / "smoke.txt").read_text(encoding="utf-8").splitlines()
    named = [line for line in lines if line and not line.startswith("#")]
    assert len(named) > 40
    for line in named:
        file, _colons, name = line.partition("::")
        assert (ROOT / "tests" / file).exists(), line
        if name:
            tree = ast.parse((ROOT / "tests" / file).read_text(encoding="utf-8"))
            functions = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
            assert name.split("[")[0] in functions, line


def test_every_finding_code_stands_in_its_table() -> None:
    page = (ROOT / "docs" / "findings.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if re.match(r"\| VP\d{3} \|", line)]
    assert rows == [
        f"| {code} | {item.severity} | {item.title} | {item.meaning} | {item.remedy} |" for code, item in CODES.items()
    ]


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(ROOT)) for page in PAGES])
def test_links_between_pages_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
        if not target.startswith(("http", "mailto")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def transcripts() -> Iterator[tuple[str, str, str]]:
    """Page, command and what the page says it prints, of every command on files that are in the repository."""
    for page in PAGES:
        for block in re.findall(r"```\w*\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
                command, _newline, printed = part.partition("\n")
                words = command.split()
                samples = [word for word in words if word.endswith((".nc", ".tbl"))]
                there = all((ROOT / word).exists() or (ROOT / "gcode_samples" / word).exists() for word in samples)
                # not what is planned or sought: on another processor it ends in other digits
                named = words[:2] in (["verne-post", "check"], ["verne-post", "explain"])
                if named and there and printed.strip() and not {"|", ">", "2>"} & set(words):
                    yield str(page.relative_to(ROOT)), command, printed


def matches(printed: str, said: list[str]) -> bool:
    """Whether what was said begins with the words of a transcript, numbers within the tolerances; ``...`` stands for anything."""
    at = 0
    for segment in printed.split("..."):
        words = re.findall(r"[-+]?\d+(?:\.\d+)?|[^\W\d]+|[^\w\s]", segment)
        starts = range(len(said) - len(words) + 1) if at else [0]
        found = [k for k in starts if k >= at and all(map(same, words, said[k : k + len(words)]))]
        if not found:
            return False
        at = found[0] + len(words)
    return True


def same(one: str, other: str) -> bool:
    try:
        return math.isclose(float(one), float(other), rel_tol=RELATIVE, abs_tol=ABSOLUTE)
    except ValueError:
        return one == other


@pytest.mark.parametrize(("page", "command", "printed"), list(transcripts()))
def test_commands_print_what_the_page_says(
    page: str, command: str, printed: str, run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for sample in (ROOT / "gcode_samples").iterdir():
        shutil.copy(sample, tmp_path)
    monkeypatch.chdir(tmp_path)
    answer = run(*shlex.split(command)[1:])
    said = re.findall(r"[-+]?\d+(?:\.\d+)?|[^\W\d]+|[^\w\s]", answer.out + answer.err)
    assert matches(printed, said), f"{page}: {command}\n{answer.out}{answer.err}"


def test_transcripts_are_found() -> None:
    assert len(list(transcripts())) >= 4
