"""Cutter location text as CAM systems write it: one part by four writers, every statement, arcs about any axis, moved
systems.
"""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from verne_post import convert
from verne_post.app.assemble import read_draft
from verne_post.gcode.apt.translator import STATEMENTS
from verne_post.gcode.apt.words import REFUSED_WORDS, REMARKS, WITHOUT_EFFECT
from verne_post.gcode.dialects import DIALECTS, choose_dialect
from verne_post.model.control_keys import AptKeys, read_keys
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

CORPUS = Path(__file__).parents[1] / "corpus" / "apt"
#: Per writer what its text does not say.
WRITERS = {
    "bracket.ncl": {},
    "bracket.cls": {},
    "bracket.aptsource": {},
    "bracket.apt": {"insert": "message", "cutcom": "centre"},
}
USED = ("tool", "spindle", "coolant")


def read(view, name, **keys):
    moves, findings = view(
        (CORPUS / name).read_bytes(), dialect="auto", source_name=name, control={"aptcl": keys} if keys else {}
    )
    assert findings == ()
    return moves


@pytest.mark.parametrize("name", WRITERS)
def test_one_part_of_four_writers_is_that_of_its_twin(view, name):
    """Every writer's text has the moves of bracket.ngc, written by hand: to the last bit, but for an arc's computed
    sweep.
    """
    moves, twin = read(view, name, **WRITERS[name]), read(view, "bracket.ngc")
    assert moves.kind.tolist() == twin.kind.tolist()
    np.testing.assert_allclose(moves.end, twin.end, atol=1e-12)
    np.testing.assert_allclose(moves.feed, twin.feed, atol=1e-12)
    np.testing.assert_allclose(moves.tool_axis, twin.tool_axis, atol=1e-12)
    np.testing.assert_allclose(moves.arcs.center, twin.arcs.center, atol=1e-12)
    np.testing.assert_allclose(moves.arcs.sweep, twin.arcs.sweep, atol=1e-12)
    used = [sorted(event.kind for event in each.events if event.kind in USED) for each in (moves, twin)]
    assert used[0] == used[1]


@pytest.mark.parametrize("ending", ["ncl", "cls", "aptsource"])
def test_a_thread_of_each_writer_is_that_of_its_twin(view, ending):
    """TPI, a feed per turn, and CATIA's two numbers with the pitch of the set-up; upright and along a tilted axis."""
    control = {"aptcl": {"pitches": {"1": 1.25}}} if ending == "aptsource" else {}
    given = {"dialect": "auto", "tapping": "feed", "control": control}
    (moves, findings), (twin, _none) = (
        view((CORPUS / f"thread.{each}").read_bytes(), source_name=f"thread.{each}", **given)
        for each in (ending, "ngc")
    )
    assert findings == ()
    assert moves.kind.tolist() == twin.kind.tolist()
    for name in ("end", "feed", "tool_axis"):
        np.testing.assert_allclose(getattr(moves, name), getattr(twin, name), atol=1e-12)
    turns = [
        [(event.before, event.data["direction"]) for event in each.events if event.kind == "spindle"]
        for each in (moves, twin)
    ]
    assert turns[0] == turns[1]


def test_setpoints_of_four_writers_are_those_of_their_twin(machine):
    """On the machine too, whatever a writer leaves to be computed."""
    given = {"tools": {1: make_tool(1, 80.0)}, "wcs": {"G54": (0.0, 0.0, 40.0)}, "cycle": 0.01, "smoothing": "off"}
    values = []
    for name, keys in {"bracket.ngc": {}, **WRITERS}.items():
        options = Options(source_name=name, control={"aptcl": keys} if keys else {}, **given)
        result = convert((CORPUS / name).read_bytes(), machine, options)
        assert result.ok, result.findings
        values.append(result.setpoints.values)
    assert max(np.abs(each - values[0]).max() for each in values[1:]) < 1e-6


def test_words_without_effect_are_told_once(view):
    events = [
        (event.line, event.data["word"]) for event in read(view, "bracket.cls").events if event.kind == "without effect"
    ]
    assert events == [(2, "TLDATA"), (5, "PAINT"), (8, "RANGE of SPINDL")]


@pytest.mark.parametrize("ending", ["cls", "CLSF", "apt", "aptsource", "ncl", "cl", "ncl.3"])
def test_endings_of_writers(ending):
    assert choose_dialect("auto", b"RAPID\nGOTO/0,0,0\n", f"part.{ending}") is DIALECTS["aptcl"]


# --- every statement --------------------------------------------------------------------------------------------

HEAD = "FEDRAT/90\nGOTO/0,0,9\n"
#: A statement of each row of the table of docs/apt.md, and what it leaves: kinds of events, or moves (kind, x, y, z)
#: after HEAD.
EXECUTED = {
    "GOTO": ("GOTO/1,2,3", [(1, 1, 2, 3)]), "FROM": ("FROM/1,2,3", [(0, 1, 2, 3)]),
    "GODLTA": ("GODLTA/1,0,0\nGODLTA/-4", [(1, 1, 0, 9), (1, 1, 0, 5)]),
    "RAPID": ("RAPID\nGOTO/1,0,9\nGOTO/2,0,9", [(0, 1, 0, 9), (1, 2, 0, 9)]),
    "FEDRAT": ("FEDRAT/50,MMPM\nGOTO/1,0,9", [(1, 1, 0, 9)]),
    "MULTAX": ("MULTAX/ON\nGOTO/1,0,9,0,.6,.8", [(1, 1, 0, 9)]),
    "TLAXIS": ("TLAXIS/0,.6,.8\nGODLTA/10", [(1, 0, 6, 17)]),
    "CIRCLE": ("CIRCLE/5,0,9,0,0,1,5\nGOTO/10,0,9", [(2, 10, 0, 9)]),
    "INDIRV": ("INDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/5,0,9,5),ON,(LINE/5,0,9,5,5,9)", [(2, 5, 5, 9)]),
    "TLON": ("INDIRV/0,-1,0\nTLON,GOFWD/(CIRCLE/5,0,9,5),ON,2,INTOF,(LINE/5,0,9,5,5,9)", [(2, 5, 5, 9)]),
    "CYCLE": ("CYCLE/DRILL,DEPTH,5,CLEAR,1\nGOTO/4,0,0\nCYCLE/OFF",
              [(0, 4, 0, 9), (0, 4, 0, 1), (1, 4, 0, -5), (0, 4, 0, 1)]),
    "TRACUT": ("TRACUT/1,0,0,5,0,1,0,0,0,0,1,0\nGOTO/1,2,3", [(1, 6, 2, 3)]), "MSYS": ("GOTO/1,2,3", [(1, 1, 2, 3)]),
    "ROTABL": ("ROTABL/0,AAXIS,0,CAXIS", [(0, 0, 0, 9)]), "TOOL PATH": ("TOOL PATH/A,TOOL,B", ["message"]),
    "END-OF-PATH": ("END-OF-PATH", []),
    "LOADTL": ("LOADTL/1,ADJUST,1", ["tool"]), "LOAD": ("LOAD/TOOL,1,ADJUST,1", ["tool"]),
    "TOOLNO": ("TOOLNO/1", ["tool"]),
    "SPINDL": ("SPINDL/RPM,900,CLW", ["spindle"]), "COOLNT": ("COOLNT/MIST", ["coolant"]),
    "DELAY": ("DELAY/1.5", [(3, 0, 0, 9)]),
    "DWELL": ("SPINDL/60,CLW\nDWELL/2,REV", [(3, 0, 0, 9)]), "STOP": ("STOP", ["stop"]), "OPSTOP": ("OPSTOP", ["stop"]),
    "FINI": ("FINI", ["end"]), "END": ("END", ["end"]), "PPRINT": ("PPRINT a", ["message"]),
    "AUXFUN": ("AUXFUN/8", ["coolant"]),
    "UNITS": ("UNITS/INCHES\nGOTO/1,0,0", [(1, 25.4, 0, 0)]), "UNIT": ("UNIT/INCH\nGOTO/1,0,0", [(1, 25.4, 0, 0)]),
    "CUTCOM": ("CUTCOM/OFF", []),
    **dict.fromkeys(("DEFSUB", "ENDSUB", "CALSUB"),
                    ("DEFSUB/A\nGODLTA/0,0,-2\nENDSUB\nGOTO/1,2,9\nCALSUB/A", [(1, 1, 2, 9), (1, 1, 2, 7)])),
}  # fmt: skip
#: Executed where they do nothing, or as the set-up says; else refused.
WITH_CONDITIONS = {
    "GOHOME": "GOHOME/1,2,3", "TRNTYP": "TRNTYP/LOCAL,0,0,0", "CSYS": "CSYS/1,0,0,5,0,1,0,0,0,0,1,0",
    "ORIGIN": "ORIGIN/1,0,0",
    "TRANS": "TRANS/COORD,1,0,0", "SELECT": "SELECT/HEAD,1", "INSERT": "INSERT G0 X5", "MODE": "MODE/TURN",
    "SET": "SET/MODE,INCR",
    "$$*CATIA0": "$$*CATIA0\n$$ A\n$$ 1 0 0 0\n$$ 0 1 0 0\n$$ 0 0 1 0\n$$ 0 0 1 0\n$$*CATIA0\n$$ B\n$$ 1 0 0 0\n$$ 0 "
                 "1 0 0\n$$ 0 0 1 60.",
    "$$-> CSYS": "$$-> CSYS / 1,0,0,0,0,1,0,0,0,0,1,0\n$$-> CSYS / 1,0,0,0,0,1,0,0,0,0,1,7",
}  # fmt: skip


def test_every_statement_stands_in_a_table_and_in_the_documentation():
    assert set(STATEMENTS) == set(EXECUTED) | set(WITH_CONDITIONS)
    page = (Path(__file__).parents[2] / "docs" / "apt.md").read_text(encoding="utf-8")
    rows = "\n".join(line for line in page.split("\n") if line.startswith("|"))
    for word in (*STATEMENTS, *REMARKS, *WITHOUT_EFFECT, *REFUSED_WORDS):
        assert re.search(rf"(?<![A-Z_]){re.escape(word)}(?![A-Z_])", rows), word


@pytest.mark.parametrize("name", EXECUTED)
def test_statements_that_are_executed(view, name):
    statement, left = EXECUTED[name]
    before = "MSYS/1,2,3,0,1,0,-1,0,0\n" if name == "MSYS" else ""
    moves, findings = view(f"{before}{HEAD}{statement}\nFINI", dialect="aptcl")
    assert findings == ()
    found = [(int(kind), *end.round(9)) for kind, end in zip(moves.kind[1:], moves.end[1:, :3], strict=True)]
    events = [event.kind for event in moves.events if event.kind in (*USED, "stop", "message", "end")]
    if all(isinstance(each, str) for each in left):
        assert (found, events) == ([], left if "end" in left else [*left, "end"])
    else:
        assert found == left


@pytest.mark.parametrize(
    ("wrong", "right", "line"), [("DEFUSB", "DEFSUB", 3), ("ENDSBU", "ENDSUB", 5), ("CALSU", "CALSUB", 7)]
)
def test_a_mistyped_word_of_subprograms_is_one_finding(view, wrong, right, line):
    text = f"{HEAD}{EXECUTED[right][0]}\nFINI".replace(right, wrong)
    found = view(text, dialect="aptcl")[1]
    assert [(item.code, item.line, item.column) for item in found] == [("VP002", line, 1)]
    assert f"did you mean {right}?" in found[0].message


@pytest.mark.parametrize("name", WITH_CONDITIONS)
def test_statements_that_are_refused_where_they_do_something(view, name):
    found = view(f"{WITH_CONDITIONS[name]}\nFINI", dialect="aptcl")[1]
    assert [item.code for item in found] in (["VP002"], ["VP005"], ["VP017"])


@pytest.mark.parametrize("name", [*REMARKS, *WITHOUT_EFFECT])
def test_statements_without_effect(view, name):
    moves, findings = view(f"{HEAD}{name}/1,,2\n{name}/1\nGOTO/1,2,3\nFINI", dialect="aptcl")
    assert findings == ()
    assert moves.end[:, :3].tolist() == [[0, 0, 9], [1, 2, 3]]
    told = [event.line for event in moves.events if event.kind == "without effect"]
    assert told == ([3] if name in WITHOUT_EFFECT else [])


@pytest.mark.parametrize("name", REFUSED_WORDS)
def test_statements_that_are_refused_by_name(view, name):
    found = view(f"{HEAD}{name}/1\nFINI", dialect="aptcl")[1]
    assert [(item.code, item.line) for item in found] == [("VP002", 3)]
    assert found[0].message == f"{name}: {REFUSED_WORDS[name]}"


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("GOTO/1,2,3", "VP009"),
        ("FEDRAT/9\nGOTO/1,2,3", "VP012"),
        ("FEDRAT/.1,MMPR\nGOTO/1,2,3", "VP009"),
        ("FEDRAT/9\nGODLTA/1,0,0", "VP013"),
        ("FEDRAT/9\nCIRCLE/5,0,0,0,0,1,5\nGOTO/10,0,0", "VP013"),
        ("LOADTL/7", "VP012"),
    ],
)
def test_remedies_are_in_words_of_the_language(text, code, machine):
    """No G code, and no word of another language."""
    with pytest.raises(InputError) as caught:
        read_draft(f"PARTNO A\n{text}\nFINI\n".encode(), machine, Options(tools={1: Tool(1, 1, (0.0,) * 9)}))
    found = [item for item in caught.value.findings if item.code == code]
    assert found
    said = [
        item.message for item in caught.value.findings if item.code != "VP033"
    ]  # work offsets are called G54 everywhere
    assert not [message for message in said if re.search(r"\b[GMTSF]\d", message)]


# --- how texts go on ---------------------------------------------------------------------------------------------


def places(view, text, **keys):
    moves, findings = view(f"FEDRAT/90\n{text}\nFINI", dialect="aptcl", control={"aptcl": keys})
    assert findings == ()
    return moves.end[:, :3].round(9).tolist()


def refusals(view, text, **keys):
    return [(item.code, item.line) for item in view(f"{text}\nFINI", dialect="aptcl", control={"aptcl": keys})[1]]


def test_a_remark_of_the_system_takes_numbers_alone_along(view):
    assert places(view, "$$-> CUTTER / 1.0, $\n  2.0, -3.E1 $\n  4.\nGOTO/1,2,3") == [[1, 2, 3]]
    assert places(view, "$$-> CUTTER / 1.0, $\nGOTO/1,2,3\n$$ other $\nGOTO/4,5,6") == [[1, 2, 3], [4, 5, 6]]
    assert refusals(view, "$$-> CUTTER / 1.0\n 2.0, 3.0") == [("VP001", 2)]


def test_what_follows_a_dollar_is_a_remark(view):
    assert places(view, "GOTO/1,$ PT 1\n 2,3") == [[1, 2, 3]]


def test_a_text_may_end_with_its_last_path(view):
    text = "TOOL PATH/A,TOOL,B\nFEDRAT/9\nGOTO/1,2,3\nEND-OF-PATH\n"
    assert view(text, dialect="aptcl")[1] == ()
    assert [item.code for item in view(text + "GOTO/1,2,4\n", dialect="aptcl")[1]] == ["VP010"]


@pytest.mark.parametrize(("feed", "refused"), [("IPM", True), ("IPR", True), ("MMPM", False)])
def test_feed_in_inches_asks_for_the_unit_of_points(view, feed, refused):
    text = f"SPINDL/100,CLW\nFEDRAT/5,{feed}\nGOTO/1,0,0"
    assert refusals(view, text) == ([("VP005", 2)] if refused else [])
    assert refusals(view, f"UNITS/MM\n{text}") == []
    for units, x in (("inch", 25.4), ("mm", 1.0)):
        assert view(f"{text}\nFINI", dialect="aptcl", control={"aptcl": {"units": units}})[0].end[-1, 0] == x


# --- tools ---------------------------------------------------------------------------------------------------------

TWO_TOOLS = "FEDRAT/9\nTOOL PATH/A,TOOL,MILL\nGOTO/1,0,0\nEND-OF-PATH\nTOOL PATH/B,TOOL,{}\n{}GOTO/2,0,0\nEND-OF-PATH"


def test_a_path_for_another_tool_needs_it(view):
    assert refusals(view, TWO_TOOLS.format("MILL", "")) == []
    assert refusals(view, TWO_TOOLS.format("DRILL", "")) == [("VP012", 6)]
    assert refusals(view, TWO_TOOLS.format("DRILL", "LOAD/TOOL,2\n")) == []
    moves, findings = view(
        TWO_TOOLS.format("DRILL", "") + "\nFINI", dialect="aptcl", control={"aptcl": {"tools": {"MILL": 1, "DRILL": 2}}}
    )
    assert findings == ()
    assert [event.data["number"] for event in moves.events if event.kind == "tool"] == [1, 2]


def test_a_described_tool_must_be_loaded(view):
    assert refusals(view, "FEDRAT/9\nTOOLNO/1,MILL,10,,\nGOTO/1,0,0") == [("VP017", 3)]
    assert refusals(view, "FEDRAT/9\nTOOLNO/1,MILL,10,,\nLOADTL/1\nGOTO/1,0,0") == []


def test_registers_of_lengths(view):
    """Which of two numbers is the register is not known; with ADJUST it is, and the set-up may say that tools have
    their own.
    """
    assert refusals(view, "LOADTL/1,2") == [("VP002", 1)]
    for text, keys, length in (
        ("LOADTL/1,ADJUST,2", {}, 25.0),
        ("LOADTL/1,2", {"lengths": "tools"}, 10.0),
        ("LOADTL/1,ADJUST,2", {"lengths": "tools"}, 10.0),
    ):
        moves = view(f"{text}\nFEDRAT/9\nGOTO/1,0,0\nFINI", dialect="aptcl", control={"aptcl": keys})[0]
        assert moves.frames[moves.frame[-1]].tool[2] == length


# --- systems of points ---------------------------------------------------------------------------------------------

FIRST, SECOND = "MSYS/5,0,0,1,0,0,0,1,0\n", "MSYS/5,20,0,0,1,0,0,0,1\n"


def test_another_msys_is_refused_or_executed_against_the_first(view):
    """The second system lies 20 mm along Y of the first; its X is Y of the first, its Y is Z, its Z is X."""
    text = f"{FIRST}GOTO/1,2,3,0,0,1\nEND-OF-PATH\nTOOL PATH/B\n{SECOND}GOTO/1,2,3,0,0,1"
    assert refusals(view, f"FEDRAT/9\n{text}") == [("VP017", 6)]
    assert places(view, text, msys="one clamping") == [[1, 2, 3], [3, 21, 2]]
    moves = view(f"FEDRAT/9\n{text}\nFINI", dialect="aptcl", control={"aptcl": {"msys": "one clamping"}})[0]
    assert moves.tool_axis.tolist() == [[0, 0, 1], [1, 0, 0]]
    assert places(view, f"{FIRST}GOTO/1,2,3\n{FIRST}GOTO/4,5,6") == [[1, 2, 3], [4, 5, 6]]


def test_msys_after_points_or_of_no_system_is_refused(view):
    assert refusals(view, f"FEDRAT/9\nGOTO/1,2,3\n{FIRST}") == [("VP017", 3)]
    assert refusals(view, "MSYS/0,0,0,1,0,0,.5,.5,0") == [("VP002", 1)]
    assert refusals(view, "MSYS/0,0,0") == [("VP005", 1)]


def test_a_path_without_a_tool_axis_is_upright_or_refused(view):
    path = "TOOL PATH/A\nGOTO/0,0,9{}\nEND-OF-PATH\nTOOL PATH/B\nGOTO/1,0,9\nEND-OF-PATH"
    assert refusals(view, "FEDRAT/9\n" + path.format("")) == []
    assert refusals(view, "FEDRAT/9\n" + path.format(",0,.6,.8")) == [("VP005", 6)]


def test_csys_does_nothing_in_one_world(view):
    system = "CSYS/0,-1,0,5,1,0,0,0,0,0,1,0\n"
    assert places(view, f"TRNTYP/WORLD,0,0,0\n{system}GOTO/1,2,3") == [[1, 2, 3]]
    assert refusals(view, system) == [("VP017", 1)]
    assert refusals(view, "CSYS/1,0,0,0,0,1,0,0,0,0,1,0") == []


# --- arcs
# --------------------------------------------------------------------------------------------------------------

CIP = "G54 G90 G94 G71\nT1 D1 M6\nS900 M3\nG1 F90 X{} Y{} Z{}\nCIP X{} Y{} Z{} I1=AC({}) J1=AC({}) K1=AC({})\nM30"


def place_on(center, u, v, angle, radius=10.0):
    angle = np.radians(angle)
    return np.array(center) + radius * (np.cos(angle) * np.array(u) + np.sin(angle) * np.array(v))


@pytest.mark.parametrize("sweep", [50.0, 180.0, 300.0])
def test_an_arc_about_a_tilted_axis_is_that_of_cip(view, sweep):
    """The circle through three points of a Siemens program: centre, axis and sweep are computed there from the
    points.
    """
    center, u, v = [3.0, -2.0, 15.0], [0.8, 0.0, -0.6], [0.0, 1.0, 0.0]  # about u x v = (0.6, 0, 0.8)
    start, middle, end = (place_on(center, u, v, 20 + share * sweep) for share in (0.0, 0.4, 1.0))
    shown = ["{:.9f},{:.9f},{:.9f}".format(*place) for place in (start, end)]
    circle = "CIRCLE/{},{},{},.6,0,.8,10".format(*center)
    moves = view(f"LOADTL/1\nFEDRAT/90\nGOTO/{shown[0]}\n{circle}\nGOTO/{shown[1]}\nFINI", dialect="aptcl")[0]
    twin, findings = view(
        CIP.format(*(f"{value:.9f}" for place in (start, end, middle) for value in place)), dialect="siemens"
    )
    assert findings == ()
    assert moves.arcs.sweep == pytest.approx([sweep], abs=1e-6)
    assert moves.arcs.sweep == pytest.approx(twin.arcs.sweep, abs=1e-6)
    feature, other = (each.frames[each.frame[-1]].feature for each in (moves, twin))
    assert feature.origin == pytest.approx(center, abs=1e-6)
    assert feature.origin == pytest.approx(other.origin, abs=1e-6)
    assert feature.rotation == pytest.approx(other.rotation, abs=1e-7)
    assert moves.end[-1, :3] == pytest.approx(twin.end[-1, :3], abs=1e-6)


def test_setpoints_of_a_tilted_arc_are_those_of_cip(machine):
    """Under a tool axis that is not the arc's: every row of both files, as far as they are rounded."""
    center, u, v = [3.0, -2.0, 35.0], [0.8, 0.0, -0.6], [0.0, 1.0, 0.0]
    start, middle, end = (place_on(center, u, v, angle) for angle in (20, 100, 260))
    comma, words = "{:.9f},{:.9f},{:.9f}".format, "X{:.9f} Y{:.9f} Z{:.9f}".format
    apt = (
        "PARTNO A\n"
        "LOADTL/1\n"
        "SPINDL/900,CLW\n"
        "RAPID\n"
        f"GOTO/{comma(*start)},.1,0,.994987437\n"
        "FEDRAT/900\n"
        "CIRCLE/3,-2,35,.6,0,.8,10\n"
        f"GOTO/{comma(*end)}\n"
        "FINI\n"
    )
    over = "I1=AC({:.9f}) J1=AC({:.9f}) K1=AC({:.9f})".format(*middle)
    siemens = (
        "TRAORI\n"
        "G54 G90 G94 G71\n"
        "T1 D1 M6\n"
        "S900 M3\n"
        "ORIVECT\n"
        f"G0 {words(*start)} A3=.1 B3=0 C3=.994987437\n"
        "G1 F900\n"
        f"CIP {words(*end)} {over}\n"
        "M30\n"
    )
    options = Options(tool_length=80.0, wcs={"G54": (0.0, 0.0, 40.0)})
    values = []
    for text in (apt, siemens):
        result = convert(text.encode(), machine, options)
        assert result.ok, result.findings
        values.append(result.setpoints.values)
    assert values[0].shape == values[1].shape
    assert np.abs(values[0] - values[1]).max() < 1e-6


def test_a_cylinder_of_tlon_is_the_circle_about_its_axis(view):
    center, u, v = [0.0, 0.0, 0.0], [0.8, 0.0, -0.6], [0.0, 1.0, 0.0]
    start, end = place_on(center, u, v, 0), place_on(center, u, v, 90)
    text = "FEDRAT/90\nGOTO/{},{},{}\n".format(*start)
    cylinder = "TLON,GOFWD/(CYLNDR/0,0,0,.6,0,.8,10),ON,$\n(PLANE/PERPTO,(PLANE/(POINT/0,0,0),PERPTO,(VECTOR/.6,0,.8)),"
    cylinder += "(POINT/0,0,0),(POINT/{:.6f},{:.6f},{:.6f}))"
    for way, sweep in (("", 90.0), ("-", 270.0)):
        moves, findings = view(
            f"{text}PSIS/(PLANE/1)\nINDIRV/0,{way}1,0\n{cylinder.format(*end)}\nFINI", dialect="aptcl"
        )
        assert findings == ()
        assert moves.arcs.sweep == pytest.approx([sweep], abs=1e-9)


@pytest.mark.parametrize(("text", "code", "line"), [
    ("CIRCLE/5,0,9,0,.6,.8,7\nGOTO/10,0,9", "VP008", 4), ("CIRCLE/5,0,9,0,.6,.8,5\nGOTO/11,0,9", "VP008", 4),
    ("CIRCLE/5,0,9,0,.6,.9,5\nGOTO/10,0,9", "VP008", 3),
    ("TLON,GOFWD/(CIRCLE/5,0,9,5),ON,(LINE/5,0,9,5,5,9)", "VP005", 3),
    ("INDIRV/1,0,0\nTLON,GOFWD/(CIRCLE/5,0,9,5),ON,(LINE/5,0,9,5,5,9)", "VP008", 4),
    ("INDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/5,0,9,5),ON,(PLANE/1,0,0,5)", "VP005", 4),
    ("INDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/5,0,9,5),ON,(LINE/5,0,9,5,6,9)", "VP008", 4),
    ("INDIRV/0,1,0\nTLON,GOFWD/(CIRCLE/5,0,9,5),PAST,(LINE/5,0,9,5,5,9)", "VP005", 4), ("INDIRV/0,0,0", "VP005", 3),
    ("CIRCLE/5,0,9,0,0,1,5,TIMES,2\nGOTO/5,5,9", "VP002", 3),
    ("CIRCLE/5,0,9,0,.6,.8,5,TIMES,1.5\nGOTO/10,0,9", "VP007", 3),
])  # fmt: skip
def test_arcs_that_are_refused(view, text, code, line):
    assert (code, line) in refusals(view, HEAD + text)


def test_times_counts_as_the_set_up_says(view):
    text = HEAD + "CIRCLE/5,0,9,0,0,-1,5,TIMES,{}\nGOTO/5,5,4\nFINI"
    for times, number, sweep in (("", 1, -90.0), ("begun", 3, -810.0), ("whole", 3, -1170.0)):
        moves, findings = view(text.format(number), dialect="aptcl", control={"aptcl": {"times": times}})
        assert findings == ()
        assert moves.arcs.sweep.tolist() == pytest.approx([sweep])


def test_creo_lists_points_of_an_arc(view):
    """All points of one GOTO after CIRCLE are on it; a point after it that is on the circle may be one more, or a
    straight move.
    """
    arc = "$$-> FEATNO / 1\n" + HEAD + "CIRCLE/5,0,9,0,0,1,5\nGOTO/{}\n"
    moves, findings = view(arc.format("5,-5,9,10,0,9,$\n5,5,9") + "FINI", dialect="aptcl")
    assert findings == ()
    assert moves.arcs.sweep.tolist() == pytest.approx([90.0] * 3)
    assert moves.end[1:, :3].tolist() == [[5, -5, 9], [10, 0, 9], [5, 5, 9]]
    assert refusals(view, arc.format("10,0,9") + "GOTO/5,5,9") == [("VP008", 6)]
    assert refusals(view, arc.format("10,0,9") + "GOTO/11,5,9\nGOTO/5,5,9") == []
    assert refusals(view, arc.format("10,0,9") + "RAPID\nGOTO/5,5,9") == []


# --- spindle, coolant --------------------------


def test_the_spindle_keeps_its_way_until_another_one_is_written(view):
    """A speed alone, and ON, after OFF too."""
    text = "SPINDL/20,RPM,CCLW\nSPINDL/30,RPM\nSPINDL/OFF\nSPINDL/ON\nSPINDL/OFF\nSPINDL/40,RPM\nSPINDL/50,CLW"
    moves, findings = view(f"{text}\nSPINDL/60,RPM\nRAPID\nGOTO/0,0,9\nFINI", dialect="aptcl")
    assert findings == ()
    ways = [event.data["direction"] for event in moves.events if event.kind == "spindle"]
    back, on = "counterclockwise", "clockwise"
    assert ways[:8] == [back, back, "stop", back, "stop", back, on, on]


def test_coolant_on_is_that_from_before(view):
    """ON alone is flood; after OFF it is what MIST or FLOOD was."""
    words = ("ON", "MIST", "OFF", "ON", "FLOOD", "OFF", "ON")
    moves, findings = view("\n".join(f"COOLNT/{word}" for word in words) + "\nRAPID\nGOTO/0,0,9\nFINI", dialect="aptcl")
    assert findings == ()
    codes = [event.data for event in moves.events if event.kind == "coolant"]
    assert [code["state"] for code in codes] == ["flood", "mist", "off", "mist", "flood", "off", "flood"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("CYCLE/DRILL,DEPTH,5,CLEAR,1,MMPM,100\nGOTO/0,0,9\nEND-OF-PATH", "under CYCLE; write CYCLE/OFF before it"),
        ("CIRCLE/5,0,9,0,0,1,5\nEND-OF-PATH", "after CIRCLE; write the GOTO that ends its arc before it"),
    ],
)
def test_the_end_of_a_path_says_what_has_no_end(view, text, said):
    found = view(f"TOOL PATH/A,TOOL,B\nGOTO/0,0,9\n{text}\nFINI".replace("GOTO", "RAPID\nGOTO", 1), dialect="aptcl")[1]
    assert [said in item.message for item in found if item.code == "VP017"] == [True]


def test_a_feed_rate_a_turn_that_no_cut_has_is_one_error(view):
    found = view("FEDRAT/MMPR,800\nGOTO/0,0,9\nFEDRAT/1500\nGOTO/1,0,9\nFINI", dialect="aptcl")[1]
    assert [item.line for item in found if item.code in ("VP005", "VP007")] == [1]


def test_a_feed_rate_after_one_in_another_unit_names_the_units(view):
    found = view("UNITS/MM\nFEDRAT/2,IPM\nFEDRAT/2\nGOTO/0,0,9\nFINI", dialect="aptcl")[1]
    assert [(item.code, item.line) for item in found] == [("VP005", 3)]
    assert "write one of MMPM, PERMIN, IPM, MMPR, PERREV, IPR" in found[0].message


# --- holes ------------------------------------------------------------------------------------------------------------


def test_holes_go_back_to_where_the_tool_stood(view):
    """RTRCTO,AUTO: 9 mm above the first hole, 12 mm above the second one, which is 3 mm deeper."""
    heights = [
        z
        for _x, _y, z in places(
            view, "GOTO/0,0,9\nCYCLE/DRILL,RAPTO,1,FEDTO,-2,RTRCTO,AUTO\nGOTO/1,0,0\nGOTO/2,0,-3\nCYCLE/OFF"
        )
    ]
    assert heights == [9, 9, 1, -2, 1, 9, 9, -2, -5, -2, 9]
    axis = "GOTO/0,0,9\nCYCLE/DRILL,RAPTO,1,FEDTO,-2,RTRCTO,AUTO\nGOTO/1,0,0,0,.6,.8\nCYCLE/OFF"
    assert refusals(view, f"FEDRAT/9\n{axis}") == [("VP005", 4)]


#: From 20 mm to three holes with CLEAR 2 and RETURN 4: one at 0, one 20 mm deeper, one at 0 again.
WAYS = [
    (10, 0, 20), (10, 0, 2), (10, 0, -10), (10, 0, 2), (10, 0, 4),
    (30, 0, 4), (30, 0, -18), (30, 0, -30), (30, 0, -18), (30, 0, -16),
    (30, 0, 4), (40, 5, 4), (40, 5, 2), (40, 5, -10), (40, 5, 2), (40, 5, 4),
]  # fmt: skip


@pytest.mark.parametrize("height", [2, 4])
def test_the_way_to_a_hole_is_across_and_then_down(view, height):
    """Across at the height of the tool, also to a deeper hole; up first to a higher one. Without RETURN up to CLEAR."""
    words = f"CLEAR,2,RETURN,{height}" if height > 2 else "CLEAR,2"
    text = f"GOTO/0,0,20\nCYCLE/DRILL,DEPTH,10,{words}\nGOTO/10,0,0\nGOTO/30,0,-20\nGOTO/40,5,0\nCYCLE/OFF"
    heights = {4: height, -16: height - 20}
    wanted = [[x, y, heights.get(z, z)] for x, y, z in WAYS]
    found, wanted = places(view, text)[1:], [wanted[0], *(b for a, b in pairwise(wanted) if a != b)]
    assert [found[0], *(b for a, b in pairwise(found) if a != b)] == wanted


@pytest.mark.parametrize("words", ["DRILL,DEPTH,-10,CLEAR,2", "DRILL,-10,CLEAR,2", "TAP,-10,2"])
def test_a_depth_is_not_negative(view, words):
    """Writers that print heights name them FEDTO."""
    found = view(f"FEDRAT/9\nGOTO/0,0,20\nCYCLE/{words}\nGOTO/10,0,0\nFINI", dialect="aptcl")[1]
    assert [(item.code, item.line, item.column) for item in found] == [("VP007", 3, words.index("-10") + 7)]
    assert "write DEPTH,10, or FEDTO,-10" in found[0].message


def test_the_way_to_a_hole_is_normal_to_a_leaning_axis(view):
    """By 20 mm along 0, .6, .8 the tool stands above the second hole, which is 10 mm deeper along that axis."""
    text = "GOTO/0,0,9,0,.6,.8\nCYCLE/DRILL,DEPTH,5,CLEAR,2\nGOTO/0,0,0\nGOTO/9,-6,-8\nCYCLE/OFF"
    assert places(view, text)[5:7] == [[9, 1.2, 1.6], [9, -4.8, -6.4]]


def test_the_tool_axis_turns_between_two_holes_only_after_a_retract(view):
    """The rapid would go from CLEAR to CLEAR while the table turns."""
    text = "FEDRAT/9\nGOTO/0,0,9\nCYCLE/DRILL,DEPTH,5,CLEAR,2{}\nGOTO/0,0,0\n{}GOTO/9,0,0,0,.6,.8\nCYCLE/OFF"
    again = "CYCLE/DRILL,DEPTH,4,CLEAR,2\n"
    assert refusals(view, text.format("", "")) == refusals(view, text.format(",RETURN,2", "")) == [("VP017", 5)]
    assert refusals(view, text.format("", again)) == [("VP017", 6)]
    for words, between in ((",RETURN,9", ""), ("", f"CYCLE/OFF\nRAPID\nGOTO/0,0,9\n{again}")):
        assert refusals(view, text.format(words, between)) == []


def test_steps_of_a_deep_hole_may_begin_with_another_one(view):
    """CLEAR 1, first step 4, then 2, to 8: bottoms at -3, -5, -7, -8."""
    text = "GOTO/0,0,9\nCYCLE/{},FEDTO,8,1STPECK,4,SUBPECK,2,RAPTO,1\nGOTO/1,0,0\nCYCLE/OFF"
    moves = view(f"FEDRAT/9\n{text.format('DEEP2')}\nFINI", dialect="aptcl")[0]
    assert moves.end[moves.kind == 1, 2].tolist() == [9, -3, -5, -7, -8]
    assert places(view, text.format("DRILL,DEEP")) == places(view, text.format("DEEP"))


@pytest.mark.parametrize("keys", [{"cutcom": "wear"}, {"msys": 1}, {"tools": {"A": 0}}, {"unit": "mm"}])
def test_keys_of_the_set_up_are_checked(keys):
    with pytest.raises(ValueError, match=next(iter(keys))):
        read_keys(AptKeys, keys)


def test_home_of_a_path_is_a_point_of_the_part(view):
    moves, findings = view("TOOL PATH/A\nFEDRAT/9\nGOTO/1,2,3\nGOHOME/1,2,30\nEND-OF-PATH\n", dialect="aptcl")
    assert findings == ()
    assert moves.end[:, 2].tolist() == [3, 30]
    assert moves.kind.tolist() == [1, 0]


@pytest.mark.parametrize("text", ["ORIGIN/1,0,0", "TRANS/1,0,0", "TRANS/COORD,X"])
def test_shifts_are_refused_as_what_they_are(view, text):
    """Not as words of another language."""
    found = view(f"$$ remark\n{text}\nFINI", dialect="aptcl")[1]
    assert [(item.code, item.line) for item in found] == [("VP002", 2)]


@pytest.mark.parametrize("turn", ["TLAXIS/0,.6,.8", "TRACUT/1,0,0,0,0,0,1,0,0,-1,0,0"])
def test_an_arc_keeps_the_axis_and_says_so(view, turn):
    """It would be milled with the axis of the point before; a point with the new axis may stand before it."""
    text = f"FEDRAT/90\nGOTO/0,0,9,0,0,1\n{turn}\n{{}}CIRCLE/5,0,9,0,0,1,5\nGOTO/10,0,9"
    assert refusals(view, text.format("")) == [("VP002", 5)]
    if turn.startswith("TLAXIS"):
        assert refusals(view, text.format("GOTO/0,0,9\n")) == []
