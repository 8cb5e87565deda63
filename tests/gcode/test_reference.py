"""Our interpreter against the answers of LinuxCNC's rs274 (tests/reference/rs274_semantics.jsonl,
rs274_found.jsonl).
"""

import json
from pathlib import Path

import numpy as np
import pytest

from verne_post.app.assemble import view_moves_plainly
from verne_post.model.moves import ZERO9, MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

FOLDER = Path(__file__).parents[1] / "reference"
FILES = {"rs274_semantics.jsonl": 112, "rs274_found.jsonl": 41}
CASES = {
    row["name"]: row for name in FILES for row in map(json.loads, (FOLDER / name).read_text("utf-8").splitlines()[1:])
}
TOOLS = {1: Tool(1, 1, (0.0, 0.0, 10.0, *ZERO9[3:]), 6.0)}
PLANES = ("XY", "XZ", "YZ")  # the reference names the ZX plane of G18 "XZ"

#: Where we mean to differ.
DELIBERATE = {
    "G93 clamp": "2.9.0~pre1 clamps slow inverse-time moves to 0.1 unit/min; later versions and we do not",
    "G43.5": "2.9.0~pre1 does not know tool vectors; we read I J K as the tool axis",
    "long line 256": "CAM comments exceed 255 characters; there is no reason to refuse them",
    "G38.2": "where a probe touches is only known at the machine; rs274 goes to the target",
    "G20 between repeats of a G91 cycle": "refused: rs274 reads even the level where the cycles began in the new unit",
    "polar in a cycle from X0 Y0": "refused as in every other motion: there is no angle to go on from",
    "#<_value> inside the next subroutine": "the value of a call does not reach into the next one",
    "#<_value> handed on by a nested call": "the same",
    "endsub value while the definition is passed": "a subroutine that is passed over returns nothing",
    "return out of repeat, called twice": "rs274 keeps the counter of the loop over calls",
    "break of inner while ends outer do": "rs274 keeps the break for the next loop",
    "G10 L2 R with G92 in force, one axis": "rs274 turns the shift of G92 when the "
    "system is turned, and not when it is set",
    "G10 L2 R with G52 in force": "the same",
    "G10 L10 with no tool loaded": "rs274 alone gives the offset of T1 to the empty spindle",
    "#5420 under compensation": "positions are those of the program, not of the tool beside it",
    "EXISTS in its own assignment": "the name is set when the block is executed",
    "G49 in G20 behind G43 in G21": "rs274 reads the stored offset in the new unit",
    "contour shorter than the radius in an inside corner": "refused: the tool would cut into "
    "the contour; rs274 goes on backwards",
    "concave corner, arc tangent to tool": "both refuse: we at the corner's own block, rs274 at the next",
    "G41 without D and tool": "refused: a forgotten tool would leave the contour too small by its radius",
    "G93 under compensation": "refused: the time of a block belongs to a length that the next corner changes",
    "continue in repeat": "there is only one thing it can mean",
    "break in repeat": "the same",
}

#: rs274 prints compensated moves when it reads the next line, and gives them that number.
LATE = {"G41.1", "negative compensation diameter"}


def answer(name):
    """Moves and findings of one program."""
    # rs274 alone keeps its parameters in inches
    return view_moves_plainly(
        CASES[name]["program"].encode(), Options(tools=TOOLS, parameter_units="inch", dialect="rs274")
    )


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
        if name in LATE:
            got.pop("line")
        found += [f"move {i}: {key} {got[key]}, wanted {wanted[key]}" for key in got if got[key] != wanted[key]]
        found += [
            f"move {i}: {key} {close[key]}, wanted {wanted[key]}"
            for key in close
            if not np.allclose(close[key], wanted[key], rtol=0, atol=1e-4)
        ]
        if moves.end[i, 6:].any():
            found.append(f"move {i}: U, V, W are not 0")
    return found


def test_the_files_are_whole():
    assert {name: len((FOLDER / name).read_text("utf-8").splitlines()) - 1 for name in FILES} == FILES
    assert len(CASES) == sum(FILES.values())


@pytest.mark.parametrize("name", [name for name in CASES if name not in DELIBERATE])
def test_agrees_with_the_reference(name):
    assert differences(name) == []


@pytest.mark.parametrize("name", sorted(DELIBERATE))
def test_differences_are_still_there(name):
    assert differences(name) != []


def test_the_list_has_no_stale_names():
    assert set(CASES) >= set(DELIBERATE)
    assert len(DELIBERATE) < 25


def test_deliberate_differences_give_the_right_moves():
    moves, _findings = answer("G93 clamp")
    assert moves.feed.tolist() == [0.01]  # 1 mm at F 0.01/min
    moves, _findings = answer("long line 256")
    assert moves.end[0, 0] == 1.0
