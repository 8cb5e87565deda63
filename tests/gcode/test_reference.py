"""Our interpreter against the answers of LinuxCNC's rs274 (tests/reference/rs274_semantics.jsonl)."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from verne_post.model.moves import ZERO9, MoveKind
from verne_post.model.options import Options, Tool
from verne_post.pipeline import interpreter_view

FILE = Path(__file__).parents[1] / "reference" / "rs274_semantics.jsonl"
CASES = {row["name"]: row for row in map(json.loads, FILE.read_text("utf-8").splitlines()[1:])}
TOOLS = {1: Tool(1, 1, (0.0, 0.0, 10.0, *ZERO9[3:]), 6.0)}
PLANES = ("XY", "XZ", "YZ")  # the reference names the ZX plane of G18 "XZ"

#: Programs with words that this version refuses. When a feature comes, its names go.
NOT_YET = {
    # parameters and expressions
    "unary minus vs **", "** left assoc", "2*-3", "MOD neg", "div 0", "FIX FUP neg", "ATAN one arg", "LN 0",
    "neg base frac pow", "AND/OR prec", "AND vs EQ", "two sets one line", "#1+2", "uninit named", "param 0",
    "param frac idx", "G28 no axes", "debug %d", "EXISTS", "unknown func",
    # O words and subprograms
    "while", "repeat", "named sub", "call before def", "recursion", "M98 L",
    # canned cycles
    "G81 modal", "G81 L", "G83", "G73", "G87", "cycle w rotary", "rot after cycle",
    # single codes
    "G28.1", "G43.2 axes", "G41.1", "M61", "M62", "G7", "G38.2", "polar", "G54.1",
}  # fmt: skip

#: Where we mean to differ.
DELIBERATE = {
    "G93 clamp": "2.9.0~pre1 clamps slow inverse-time moves to 0.1 unit/min; later versions and we do not",
    "G43.5": "2.9.0~pre1 does not know tool vectors; we read I J K as the tool axis",
    "long line 256": "CAM comments exceed 255 characters; there is no reason to refuse them",
}

#: How a refusal of NOT_YET may read; O words are met as program numbers with something behind them.
REFUSALS = re.compile(r"not supported by this version|program number O|^O needs a number")


def answer(name):
    """Moves and findings of one program."""
    return interpreter_view(CASES[name]["program"].encode(), Options(tools=TOOLS))


def differences(name):
    """Every disagreement with the reference, in words."""
    case, (moves, findings) = CASES[name], answer(name)
    found = []
    wanted_error = case["error"] and case["error"]["line"]
    error = findings[0].line if findings else None
    if error != wanted_error:
        found.append(f"error on line {error}, wanted {wanted_error}")
    messages = [{"line": e.line, "text": e.data["text"]} for e in moves.events if e.kind == "message"]
    if messages != case["messages"]:
        found.append(f"messages {messages}, wanted {case['messages']}")
    if len(moves) != len(case["moves"]):
        return [*found, f"{len(moves)} moves, wanted {len(case['moves'])}"]
    for i, wanted in enumerate(case["moves"]):
        got = {"line": int(moves.line[i]), "kind": MoveKind(int(moves.kind[i])).name.lower()}
        close = {"end": moves.end[i, :6]} if "end" in wanted else {}
        close["feed"] = moves.feed[i]
        if moves.arc[i] >= 0:
            row = moves.arc[i]
            got |= {"plane": PLANES[moves.arcs.plane[row]], "turns": int(moves.arcs.turns[row])}
            close |= {"center": moves.arcs.center[row], "sweep": moves.arcs.sweep[row]}
        if wanted["kind"] == "rapid":
            assert "feed" not in wanted
            if not np.isnan(close.pop("feed")):
                found.append(f"move {i}: a rapid with a feed")
        assert set(wanted) == {*got, *close}, f"fields of {name}"
        found += [f"move {i}: {key} {got[key]}, wanted {wanted[key]}" for key in got if got[key] != wanted[key]]
        found += [
            f"move {i}: {key} {close[key]}, wanted {wanted[key]}"
            for key in close if not np.allclose(close[key], wanted[key], rtol=0, atol=1e-4)
        ]  # fmt: skip
        if moves.end[i, 6:].any():
            found.append(f"move {i}: U, V, W are not 0")
    return found


def test_the_file_is_whole():
    assert len(CASES) == 112


@pytest.mark.parametrize("name", [name for name in CASES if name not in NOT_YET and name not in DELIBERATE])
def test_agrees_with_the_reference(name):
    assert differences(name) == []


@pytest.mark.parametrize("name", sorted(NOT_YET))
def test_unsupported_words_are_refused(name):
    _moves, findings = answer(name)
    assert findings
    assert findings[0].severity == "error"
    assert findings[0].code in ("VP001", "VP002")
    # something else is said as soon as the feature exists: then the name has no business in NOT_YET
    assert REFUSALS.search(findings[0].message)


@pytest.mark.parametrize("name", sorted(DELIBERATE))
def test_deliberate_differences_are_still_there(name):
    assert differences(name) != []
    assert answer(name)[1] == ()


def test_the_lists_have_no_stale_names():
    assert set(CASES) >= NOT_YET
    assert set(CASES) >= set(DELIBERATE)
    assert NOT_YET.isdisjoint(DELIBERATE)
    assert len(DELIBERATE) < 5


def test_deliberate_differences_give_the_right_moves():
    moves, _findings = answer("G93 clamp")
    assert moves.feed.tolist() == [0.01]  # 1 mm at F 0.01/min
    moves, _findings = answer("long line 256")
    assert moves.end[0, 0] == 1.0
