"""Our interpreter against stored answers of LinuxCNC's rs274 to generated programs: expressions, cycles, flow, corners, modes."""

import importlib.util
import json
from pathlib import Path

import pytest

REFERENCE = Path(__file__).parents[1] / "reference"
ROWS = [json.loads(line) for line in (REFERENCE / "rs274_generated.jsonl").read_text("utf-8").splitlines()]


@pytest.fixture(scope="module")
def compare():
    """The comparison that also runs against an installed rs274."""
    spec = importlib.util.spec_from_file_location("compare_rs274", REFERENCE / "compare_rs274.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_answers_are_worth_comparing_with():
    assert len(ROWS) >= 100
    kinds = {move[0] for row in ROWS for move in row["moves"]}
    assert kinds == {"rapid", "feed", "arc", "dwell"}
    assert sum(len(row["moves"]) for row in ROWS) > 400
    assert sum(bool(row["messages"]) for row in ROWS) > 30
    assert sum(bool(row["error"]) for row in ROWS) > 5


@pytest.mark.parametrize("row", ROWS, ids=range(len(ROWS)))
def test_agrees(compare, row):
    moves = [tuple(move) for move in row["moves"]]
    assert compare.disagreements(row["program"], (moves, row["messages"], row["error"])) == []


def test_the_comparison_can_fail(compare):
    row = next(row for row in ROWS if len(row["moves"]) > 3 and not row["error"])
    moves = [tuple(move) for move in row["moves"]]
    moves[2] = (moves[2][0], [value + 0.5 for value in moves[2][1]], *moves[2][2:])
    assert compare.disagreements(row["program"], (moves, row["messages"], "")) != []
    assert compare.disagreements(row["program"], (moves[:1], row["messages"], "")) != []
    assert compare.disagreements(row["program"], ([tuple(m) for m in row["moves"]], ["x"], "")) != []
    assert compare.disagreements(row["program"], (moves[:0], [], "an error")) != []
