"""Every word of docs/siemens.md does what its table says; docs/make_words.py makes the tables of the same
vocabulary.
"""

import re
from pathlib import Path

import pytest

import verne_post as vp
from verne_post.gcode.siemens import flow
from verne_post.gcode.siemens.vocabulary import CONSTANTS, NO_EFFECT, REFUSED_WORDS, STATEMENTS
from verne_post.model.control_keys import SiemensKeys, read_keys

from ..builders import load_maker

PAGE = Path(__file__).parents[2] / "docs" / "siemens.md"
HEAD = "G0 X9 Y9 Z50 A0 C0 F100 S500 M3\n"
#: A program for each executed word that its own G function or name alone does not show.
EXAMPLES = {
    "G2": "G2 X5 CR=30",
    "G3": "G3 X5 CR=30",
    "CIP": "CIP X5 I1=6 J1=5",
    "CT": "G1 X10\nCT X20 Y20",
    "G4": "G4 F1",
    "G75": "G75 Z0",
    "FP": "G75 Z0 FP=2",
    "G110": "G110 X1",
    "G111": "G111 X1",
    "G112": "G112 X1",
    "AP": "AP=30 RP=5",
    "RP": "AP=30 RP=5",
    "RPL": "ROT RPL=5",
    "TRANS": "TRANS X1",
    "ATRANS": "ATRANS X1",
    "ROT": "ROT Z9",
    "AROT": "AROT Z9",
    "SCALE": "SCALE X2",
    "ASCALE": "ASCALE X2",
    "MIRROR": "MIRROR X0",
    "AMIRROR": "AMIRROR X0",
    "AC": "X=AC(5)",
    "IC": "X=IC(5)",
    "DC": "C=DC(5)",
    "ACP": "C=ACP(5)",
    "ACN": "C=ACN(5)",
    "A3": "TRAORI\nA3=1 C3=5",
    "B3": "TRAORI\nB3=1 C3=5",
    "C3": "TRAORI\nC3=5",
    "ADIS": "ADIS=0.1",
    "CTOL": "CTOL=0.1",
    "OTOL": "OTOL=1",
    "X": "X1",
    "Y": "Y1",
    "Z": "Z1",
    "A": "A1",
    "B": "B1",
    "C": "C1",
    "U": "U1",
    "V": "V1",
    "W": "W1",
    "I": "G2 I5",
    "J": "G2 J5",
    "K": "G18 G2 K5",
    "I1": "CIP X5 I1=6 J1=5",
    "J1": "CIP X5 I1=6 J1=5",
    "K1": "CIP X5 I1=6 K1=5",
    "CR": "G2 X5 CR=30",
    "AR": "G2 I5 AR=30",
    "TURN": "G2 I5 TURN=1",
    **dict.fromkeys(("BSPLINE", "SD", "PW", "PL"), "BSPLINE X10 Y10 SD=2 PL=0\nX20 Y5 PW=2 PL=1\nX30 PL=2\nG1 X40"),
    "F": "F5",
    "S": "S5",
    "S1": "S1=5",
    "M": "M8",
    "M1": "M1=4",
    "T": "T1",
    "T1": "T1=1",
    "D": "D1",
    "CUTMOD": "CUTMOD=0",
    "H": "H5",
    "SPOS": "SPOS=5",
    "N": "N5 X1",
    "L": "L5\nM30\n%_N_L5_SPF\nX1",
    "P": "L5 P2\nM30\n%_N_L5_SPF\nX1",
    "G": "G=1",
    "X1": "G75 X1=0",
    "Y1": "G75 Y1=0",
    "Z1": "G75 Z1=0",
    "A1": "G75 A1=0",
    "C1": "G75 C1=0",
    "G41": "T1 M6\nG41 G1 X50\nG40",
    "G42": "T1 M6\nG42 G1 X50\nG40",
    "IF": "IF 1\nENDIF",
    "ELSE": "IF 1\nELSE\nENDIF",
    "ENDIF": "IF 1\nENDIF",
    "GOTO": "GOTO A9\nA9:",
    "GOTOF": "GOTOF A9\nA9:",
    "GOTOB": "R1=R1+1\nA9: R1=R1+1\nIF R1<4 GOTOB A9",
    "GOTOC": "GOTOC A9",
    "CASE": "CASE(1) OF 1 GOTOF A9\nA9:",
    "FOR": "FOR R1=1 TO 2\nENDFOR",
    "ENDFOR": "FOR R1=1 TO 2\nENDFOR",
    "WHILE": "WHILE 0\nENDWHILE",
    "ENDWHILE": "WHILE R1<2\nR1=R1+1\nENDWHILE",
    "LOOP": "LOOP\nGOTOF A9\nENDLOOP\nA9:",
    "ENDLOOP": "LOOP\nR1=R1+1\nIF R1>2 GOTOF A9\nENDLOOP\nA9:",
    "REPEAT": "REPEAT\nUNTIL 1",
    "UNTIL": "REPEAT\nUNTIL 1",
    "REPEATB": "A9: X=IC(1)\nREPEATB A9",
    "DEF": "DEF REAL A9",
    "RET": "RET",
    "M17": "M17",
    "PROC": "L5\nM30\n%_N_L5_SPF\nPROC L5\nX1",
    "CALL": 'CALL "L5"\nM30\n%_N_L5_SPF\nX1',
    "EXTCALL": 'EXTCALL "L5"\nM30\n%_N_L5_SPF\nX1',
    "MCALL": "MCALL CYCLE81(20,0,2,-5)\nX1\nMCALL",
    "MSG": 'MSG("a")',
    "SETAL": "SETAL(62000)",
    "CYCLE840": "CYCLE840(20,0,2,-5)",
    "CYCLE84": "CYCLE84(20,0,2,-5,,,5,,1,0,300)",
    "CYCLE85": "CYCLE85(20,0,2,-5,,0,50,50)",
    "HOLES1": "HOLES1(0,0,0,1,1,2)",
    "HOLES2": "HOLES2(0,0,5,0,0,2)",
    "CYCLE801": "CYCLE801(0,0,0,1,1,2,2)",
    "RND": "G1 X20 RND=2\nY30",
    "RNDM": "G1 X20 RNDM=2\nY30",
    "CHF": "G1 X20 CHF=2\nY30",
    "CHR": "G1 X20 CHR=2\nY30",
    "FRC": "G1 X20 CHR=2 FRC=50\nY30",
    "POCKET1": "T1 M6\nPOCKET1(20,0,2,-5,,40,24,6,0,0,0,99,500,5)",
    "POCKET2": "T1 M6\nPOCKET2(20,0,2,-5,,20,0,0,99,500,5)",
    "POCKET3": "T1 M6\nPOCKET3(20,0,2,-5,40,24,6,0,0,0,5,0,0,500,99,0,11)",
    "POCKET4": "T1 M6\nPOCKET4(20,0,2,-5,20,0,0,5,0,0,500,99,0,11)",
    "SLOT1": "T1 M6\nSLOT1(20,0,2,-5,,1,40,10,0,0,9,0,0,99,500,5)",
    "SLOT2": "T1 M6\nSLOT2(20,0,2,-5,,1,40,8,0,0,29,0,0,99,500,5)",
    "LONGHOLE": "T1 M6\nLONGHOLE(20,0,2,-5,,1,40,0,0,9,0,0,99,500,5)",
    "CYCLE61": "T1 M6\nCYCLE61(20,0,2,-5,0,0,40,30,5,0,0,500,31)",
    "CYCLE71": "T1 M6\nCYCLE71(20,0,2,-5,0,0,40,30,0,5,0,0,0,500,31)",
    "CYCLE76": "T1 M6\nCYCLE76(20,0,2,-5,,40,30,5,0,0,0,5,0,0,500,99,0,1,50,40)",
    "CYCLE77": "T1 M6\nCYCLE77(20,0,2,-5,,20,0,0,5,0,0,500,99,0,1,30)",
    "CYCLE70": "T1 M6\nCYCLE70(20,0,2,-5,20,1.2,0,2,1,0,500,0,10,20,0,11)",
    "CYCLE90": "T1 M6\nCYCLE90(20,0,2,-4,,20,16,2,500,3,0,10,20)",
    "CYCLE79": "T1 M6\nCYCLE79(20,0,2,-5,6,30,0,0,0,2,50,4,5,0,0,500,0,1)",
    "CYCLE899": "T1 M6\nCYCLE899(20,0,2,-5,40,14,0,0,0,5,1,0,0,500,0,1001)",
    "CYCLE62": 'T1 M6\nCYCLE62("A9",0)\nM30\n%_N_A9_SPF\nX1',
    "CYCLE72": 'T1 M6\nCYCLE72("A9",20,0,2,-5,,,,500,99,1,40,1,5)\nM30\n%_N_A9_SPF\nG0 X1 Y1\nG1 X9\nM17',
    "WORKPIECE": 'WORKPIECE(,"",,"BOX",112,0,-20,-80,-50,-35,100,100)',
    "CYCLE800": "CYCLE800()",
    "CYCLE832": "CYCLE832(0.1,1)",
    **{name: f"{name}(20,0,2,-5)" for name in ("CYCLE81", "CYCLE82", "CYCLE83", "CYCLE86", "CYCLE89")},
}
EXECUTED = sorted({word for word, _does in load_maker("make_words").list_siemens_words()})
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
    program = EXAMPLES.get(word, word)
    # of ORIWKS and its like, and of ORIAXES and its like, one group has an effect
    by_group = word in ("ORIAXES", "ORIVECT", "ORIPLANE")
    control = {"siemens": {"polygon_angle": "side", "orientation_by_group": by_group}}
    moves, errors = view(f"{HEAD}{program}\nM30", dialect="siemens", tapping="feed", control=control)
    assert errors == ()
    assert not [
        event for event in moves.events if event.kind == "without effect" and word not in ("CYCLE832", "CUTMOD", "M40")
    ]


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
