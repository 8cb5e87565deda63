"""Wrong invocations: each is refused with what is wrong, and before anything heavy is loaded."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARK = Path(__file__).resolve().parents[1] / "benchmarks" / "refusals.py"
_SPEC = importlib.util.spec_from_file_location("refusals", BENCHMARK)
assert _SPEC is not None and _SPEC.loader is not None
refusals = importlib.util.module_from_spec(_SPEC)
_SPEC.loader.exec_module(refusals)

#: Runs every line of standard input as a command line; a module that must not be loaded is named in its answer.
SCRIPT = """
import contextlib, io, json, sys
HEAVY = ("numpy", "scipy", "ruckig")
class Heavy:
    def find_spec(self, name, path=None, target=None):
        if name in HEAVY:
            raise AssertionError("loads " + name)
sys.meta_path.insert(0, Heavy())
from verne_post.cli.main import main
answers = []
for line in sys.stdin.read().splitlines():
    error = io.StringIO()
    with contextlib.redirect_stderr(error):
        code = main(line.split())
    answers.append([int(code), error.getvalue()])
print(json.dumps(answers))
"""


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[int, str]]:
    """Exit status and message of every wrong invocation, in a process that cannot load numpy."""
    folder = tmp_path_factory.mktemp("wrong")
    refusals.make_files(folder)
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        input="\n".join(refusals.WRONG),
        capture_output=True,
        text=True,
        cwd=folder,
        check=True,
    )
    return dict(zip(refusals.WRONG, json.loads(done.stdout), strict=True))


@pytest.mark.parametrize("wrong", refusals.WRONG)
def test_a_wrong_invocation_is_refused_without_numpy(answers: dict[str, tuple[int, str]], wrong: str) -> None:
    code, message = answers[wrong]
    assert code == 2, message
    assert refusals.WRONG[wrong] in message
    assert "loads" not in message
