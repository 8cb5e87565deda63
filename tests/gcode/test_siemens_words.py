"""Every word of docs/siemens.md does what its table says; docs/make_words.py makes the tables of the same
vocabulary.
"""

import re
from pathlib import Path

import pytest

import verne_post as vp
from verne_post.gcode.siemens import drilling, flow, patterns
from verne_post.gcode.siemens.vocabulary import CONSTANTS, NO_EFFECT, REFUSED_WORDS, STATEMENTS
from verne_post.model.control_keys import SiemensKeys, read_keys

from ..builders import load_maker

PAGE = Path(__file__).parents[2] / "docs" / "siemens.md"
HEAD = "G0 X9 Y9 Z50 A0 C0 F100 S500 M3\n"
MAKER = load_maker("make_words")
#: Programs of each executed word; any other word stands alone.
EXAMPLES = MAKER.read_examples("siemens") | {"CUTMOD": ["CUTMOD=0"]}
EXECUTED = sorted({word for word, _does in MAKER.list_siemens_words()})
#: Refused words that stand alone in their block; the others are tried as NAME=1, NAME(1) and NAME too.
FORMS = ("{}", "{}=1", "{}(1)", "{}[X]=1")


def test_every_statement_that_is_executed_is_in_the_vocabulary():
    assert {*flow.HANDLERS, "M17"} == set(STATEMENTS)  # M17 is read as an M function


def test_no_word_is_in_two_tables():
    assert not set(EXECUTED) & set(NO_EFFECT)
    assert not set(EXECUTED) & set(REFUSED_WORDS)
    assert not set(NO_EFFECT) & set(REFUSED_WORDS)


@pytest.mark.parametrize("word", [word for word in EXECUTED if not re.fullmatch("G5[1-9].", word) or word < "G558"])
def test_executed_words_are_executed(view, word):
    # of ORIWKS and its like, and of ORIAXES and its like, one group has an effect
    by_group = word in ("ORIAXES", "ORIVECT", "ORIPLANE")
    control = {"siemens": {"polygon_angle": "side", "orientation_by_group": by_group}}
    for program in EXAMPLES.get(word, [word]):
        text = HEAD + program.replace(" / ", "\n") + "\nM30"
        moves, errors = view(text, dialect="siemens", tapping="feed", control=control)
        assert errors == ()
        idle = [event for event in moves.events if event.kind == "without effect"]
        assert not idle or word in ("CYCLE832", "CUTMOD", "M40")


@pytest.mark.parametrize("word", sorted(NO_EFFECT))
def test_words_without_effect_are_shown_and_change_nothing(view, word):
    plain = view(f"{HEAD}X1 Y2\nG1 Z5\nX3", dialect="siemens")[0]
    for form in FORMS:
        moves, errors = view(f"{HEAD}{form.format(word)}\nX1 Y2\nG1 Z5\nX3", dialect="siemens")
        assert errors == ()
        assert [event.data["word"] for event in moves.events if event.kind == "without effect"] == [word]
        assert moves.end.tolist() == plain.end.tolist()
        assert moves.controls == plain.controls


@pytest.mark.parametrize("word", sorted(REFUSED_WORDS))
def test_refused_words_are_refused_by_name(view, word):
    refused = []
    for form in FORMS if not re.fullmatch("[ABC][0-9]", word) else ("{}=1",):  # A4 alone is a place of A
        _moves, errors = view(f"{HEAD}{form.format(word)}\nX1", dialect="siemens")
        assert len(errors) == 1, form
        refused.append(
            errors[0].code == "VP002" and word in errors[0].message and REFUSED_WORDS[word] in errors[0].message
        )
    assert any(refused), refused


def test_the_page_has_the_values_of_every_drilling_cycle_in_their_order():
    shown = dict(re.findall(r"^(\w+) +\(([^)]*)\)$", PAGE.read_text(encoding="utf-8"), re.MULTILINE))
    shown = {name: " ".join(values.split()) for name, values in shown.items()}  # a long one goes on in the next line
    for name, values in (drilling.PARAMETERS | patterns.PARAMETERS).items():
        assert shown.get(name) == ", ".join(values), name


def test_keys(view):
    text = PAGE.read_text(encoding="utf-8").split("## Keys of the settings file", 1)[1]
    named = re.findall(r"^\| `(\w+)` \| `(.+?)` \|", text, re.MULTILINE)
    keys = SiemensKeys()
    shown = {name: {"false": False, "{}": {}}.get(value, value.strip('"')) for name, value in named}
    assert shown == {name: getattr(keys, name) for name in keys.__struct_fields__}
    moves, errors = view("X5", dialect="siemens", control={"siemens": {"start": "G0 G54 G90"}})
    assert errors == ()
    assert len(moves) == 1
    moves, errors = view(
        'T="DRILL" M6\nG0 C350\nC10',
        dialect="siemens",
        control={"siemens": {"tools": {"DRILL": 2}, "modulo_axes": "C"}},
    )
    assert errors == ()
    assert (moves.frames[0].tool_length, moves.end[-1][5]) == (25.0, 10.0)


@pytest.mark.parametrize(("given", "part"), [
    ({"rotations": 1}, "no such key"), ({"rotation": "xyz"}, "rpy or euler"), ({"start": 5}, "text"),
    ({"orientation_by_group": 1}, "true"), ({"tools": {"A": "B"}}, "numbers"),
    ({"tools": {"A": -1}}, "numbers"), ({"modulo_axes": "B"}, "A and C"), ({"offsets_in_g91": "yes"}, "travelled"),
    ({"d_numbers": "flat"}, "edges or tools"), ({"length_axis": 17}, "Z or plane"),
])  # fmt: skip
def test_wrong_keys(given, part):
    with pytest.raises(ValueError, match=part):
        read_keys(SiemensKeys, given)


@pytest.mark.parametrize(
    ("lines", "line"),
    [
        ("G18\nG4 F1\nG1 X10 F500", 5),
        ("G19\nG1 Y10 F500\nG2 Y20 Z40 CR=10\nX5", 4),
        ("G18\n" + "\n".join(f"G1 X{one} F500" for one in range(1, 40)), 4),  # executed as an array
        ("G18 G0 Y60\nCYCLE82(60,50,2,45)", 3),
        ("G18\nG17\nG1 X10 F500", None),
        ("G18\nG0 A5", None),
    ],
)
def test_a_tool_length_in_g18_and_g19_is_an_assumption(lines, line):
    """SD42940 is not in the program: it is told once, accepted with the key, and refused with the other value."""
    text, codes = f"G17 G54 G90 G94 G710 S1000 M3\nG0 X0 Y0 Z50 A0 C0\n{lines}\nM30\n", {}
    for key in ("", "Z", "plane"):
        options = vp.Options(
            tool_length=80.0,
            wcs={"G54": (0.0, 0.0, 60.0)},
            dialect="siemens",
            control={"siemens": {"length_axis": key}},
        )
        found = vp.check(text, "verne", options).findings
        codes[key] = [(item.code, item.line) for item in found if item.code in ("VP053", "VP017")]
    assert codes[""] == ([] if line is None else [("VP053", line)])
    assert codes["Z"] == []
    assert codes["plane"][:1] == ([] if line is None else [("VP017", line)])


def test_names_of_tolerances(view):
    for name, number in CONSTANTS.items():
        moves, errors = view(f"G0 X={name}", dialect="siemens")
        assert errors == ()
        assert moves.end[0][0] == number


def test_an_arc_that_refuses_g18_leaves_no_doubt_of_the_tool_length():
    """One cause, two findings: VP053 for the lines in G18 before the arc in I and J, and after it."""
    text = "G17 G54 G90 G94 G710 S1000 M3\nG0 X0 Y0 Z50 A0 C0\nG18\nG1 X10 F500\nG2 X20 Y10 I10 J0\nG1 X30\nM30\n"
    options = vp.Options(tool_length=80.0, wcs={"G54": (0.0, 0.0, 60.0)}, dialect="siemens")
    found = vp.check(text, "verne", options).findings
    assert [(item.code, item.line) for item in found] == [("VP006", 5)]
    assert "G18 of line 3 is active" in found[0].message
