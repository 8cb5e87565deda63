"""Every code of the table of docs/gcode.md is executed; docs/make_words.py makes that table of the same vocabulary."""

import pytest

from verne_post.gcode.codes import RS274, spell_g_code

HEAD = "G21 G90 G94 G0 X9 Y9 Z50 A0 C0\nT1 M6\nG43\nS500 M3 F100\n"
#: A program for each code that needs more than its name.
EXAMPLES = {
    **{f"G{code}": f"G{code} X5 R30" for code in (2, 3)},
    "G5": "G5 X20 Y9 I3 J3 P-3 Q3",
    "G5.1": "G5.1 X20 Y9 I3 J3",
    **dict.fromkeys(("G5.2", "G5.3"), "G5.2 X10 Y20 P1 L3\nX20 Y10 P1\nX30 Y9 P1\nG5.3"),
    **{f"G{code}": f"G{code} X5 Y5 Z40 R45 Q2" for code in (73, 83)},
    **{f"G{code}": f"G{code} X5 Y5 Z40 R45" for code in (81, 84, 85)},
    **{f"G{code}": f"G{code} X5 Y5 Z40 R45 P1" for code in (82, 86, 88, 89)},
    "G74": "M4\nG74 X5 Y5 Z40 R45",
    "G87": "G87 X5 Y5 Z40 R45 I1 J1 K5",
    **{f"G{code}": f"G1 Z20\nG{code} G1 X40\nG40" for code in (41, 42)},
    **{f"G{code}": f"G1 Z20\nG{code} D8 G1 X40\nG40" for code in (41.1, 42.1)},
    "G43.1": "G43.1 Z30",
    "G43.2": "G43.2 H1",
    "G4": "G4 P1",
    "G10": "G10 L2 P2 X5",
    "G28": "G91 G28 Z0\nG90",
    "G30": "G91 G30 Z0\nG90",
    "G52": "G52 X5",
    "G53": "G53 G0 Z40",
    "G92": "G92 X5",
    "G93": "G93 G1 X20 F5",
    "G95": "G95 F0.1",
    "G96": "G96 S50 D900",
    "G1": "G1 X20",
    "M61": "M61 Q1",
    "M19": "M5\nM19 R5",
    "M62": "M62 P1",
    "M63": "M63 P1",
    "M64": "M64 P1",
    "M65": "M65 P1",
    "M66": "M66 P1 L0",
    "M67": "M67 E1 Q2",
    "M68": "M68 E1 Q2",
    **dict.fromkeys(("M98", "M99"), "M98 P5\nM30\nO5\nX3\nM99"),
    **dict.fromkeys(("M70", "M72"), "M70\nG91\nM72"),
    "M71": "M70\nM71",
    "M73": "O5 sub\nM73\nO5 endsub\nO5 call",
}
CODES = [
    *(spell_g_code(code) for codes in RS274.g_groups.values() for code in codes),
    *(f"M{code}" for codes in RS274.m_groups.values() for code in codes),
]


@pytest.mark.parametrize("code", CODES)
def test_executed_codes_are_executed(view, code):
    moves, errors = view(f"{HEAD}{EXAMPLES.get(code, code)}\nG0 Z60\nM30", dialect="rs274", tapping="feed")
    assert errors == ()
    assert len(moves) >= 1


def test_examples_are_of_codes_that_are_executed():
    assert set(EXAMPLES) <= set(CODES)
