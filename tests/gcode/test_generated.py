"""Our interpreter against stored answers of LinuxCNC's rs274 to generated programs of every kind
(tests/reference/programs.py).
"""

import json
from collections import Counter
from pathlib import Path

import pytest

REFERENCE = Path(__file__).parents[1] / "reference"
ROWS = [json.loads(line) for line in (REFERENCE / "rs274_generated.jsonl").read_text("utf-8").splitlines()]
#: What one side refuses and the other does not (docs/gcode.md).
KNOWN = {
    "an arc with R",
    "a change of units among the cycles",
    "zero spindle speed in feed per rev mode",
    "polar coordinates",
    "at X0 Y0",
}


@pytest.fixture(scope="module")
def compare():
    """The comparison that compare_rs274.py also makes with an installed rs274."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(REFERENCE))
        import comparison

        yield comparison


@pytest.mark.usefixtures("compare")
def test_the_answers_are_worth_comparing_with():
    from programs import KINDS

    kinds = Counter(row["kind"] for row in ROWS)
    assert set(kinds) == set(KINDS)
    assert min(kinds.values()) >= 20
    steps = Counter(step[0] for row in ROWS for step in row["steps"])
    moves = {"rapid", "feed", "arc", "dwell"}
    assert set(steps) == moves | {"spindle", "coolant", "switches", "signal", "stop", "tool", "tool number", "orient"}
    assert min(steps["rapid"], steps["feed"]) > 500
    assert sum(bool(row["messages"]) for row in ROWS) > 60
    # most programs run to their end: after an error nothing is compared
    assert sum(not row["error"] for row in ROWS) > 0.7 * len(ROWS)


@pytest.mark.parametrize("row", ROWS, ids=[f"{row['kind']}-{i}" for i, row in enumerate(ROWS)])
def test_agrees(compare, row):
    """What was done before an error is the same, and what is refused there is refused here."""
    answer = compare.Answer([tuple(step) for step in row["steps"]], row["messages"], row["error"])
    ours = compare.interpret_here(row["program"])
    assert compare.find_silent_differences(row["program"], ours, answer) == []
    error = ours.error
    assert bool(error) == bool(row["error"]) or any(reason in (error or row["error"]) for reason in KNOWN)


@pytest.mark.parametrize("wrong", ["place", "speed", "order", "fewer", "message"])
def test_the_comparison_can_fail(compare, wrong):
    row = next(row for row in ROWS if [step[0] for step in row["steps"][1:3]] == ["rapid", "feed"] and not row["error"])
    steps, messages = [tuple(step) for step in row["steps"]], list(row["messages"])
    if wrong == "place":
        steps[2] = ("feed", [value + 2e-6 for value in steps[2][1]], steps[2][2])
    elif wrong == "speed":
        steps[2] = ("feed", steps[2][1], 1.001 * steps[2][2])
    elif wrong == "order":
        steps[1], steps[2] = steps[2], steps[1]
    elif wrong == "fewer":
        steps.pop()
    else:
        messages.append("x")
    assert (
        compare.find_silent_differences(
            row["program"], compare.interpret_here(row["program"]), compare.Answer(steps, messages, "")
        )
        != []
    )
