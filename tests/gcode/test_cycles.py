"""Canned cycles where rs274 gives no answer: on a tilted table, in fanuc's words, and how their corners are taken."""

import numpy as np
import pytest

from verne_post import check
from verne_post.app.assemble import build_interpreter_setup
from verne_post.gcode import interpret_program
from verne_post.model.moves import PathMode
from verne_post.model.options import Options


def test_cycles_take_no_corner(view):
    moves, findings = view("G64 P.1 F9 G0 Z5\nG81 X1 Z-1 R1\nX2\nG80 G0 X3\nM2", dialect="rs274")
    assert findings == ()
    modes = [moves.controls[index].mode for index in moves.control]
    assert modes == [PathMode.BLEND] + [PathMode.EXACT_PATH] * 7 + [PathMode.BLEND]
    exact, _ = view("G61.1 F9 G0 Z5\nG81 X1 Z-1 R1\nM2", dialect="rs274")
    assert {exact.controls[index].mode for index in exact.control} == {PathMode.EXACT_STOP}


def test_a_raised_r_is_risen_to_before_anything_goes_sideways(moves_text):
    assert moves_text("F9 G0 Z9\nG81 Z-1 R2\nX5 R6\nM2", dialect="rs274")[5:] == [
        "3 rapid Z6",
        "3 rapid X5 Z6",
        "3 feed X5 Z-1 F9",
        "3 rapid X5 Z6",
    ]


def test_g98_stays_at_the_initial_level_between_holes(moves_text):
    assert moves_text("F9 G0 Z9\nG99 G81 Z-1 R2\nG98 X5\nM2", dialect="rs274")[5:] == [
        "3 rapid Z9",
        "3 rapid X5 Z9",
        "3 rapid X5 Z2",
        "3 feed X5 Z-1 F9",
        "3 rapid X5 Z9",
    ]


@pytest.mark.parametrize(
    ("program", "code"),
    [
        ("G0 Z60 A20\nG81 X1 Z20 R40", "VP017"),
        ("G0 Z60 A0 C40\nG81 X1 Z20 R40", None),
        ("G0 A180 Z60\nG81 X1 Z20 R40", "VP017"),
        ("G0 Z60 A90\nG18 G81 X1 Y-5 R9", None),
        ("G0 Z60 A-90\nG18 G81 X1 Y-5 R9", "VP017"),
        ("G0 Z60 A.05\nG81 X1 Z20 R40", None),
        ("G0 Z60 A.1\nG81 X1 Z20 R40", "VP017"),
    ],
)
def test_a_drill_must_point_along_its_hole(machine, program, code):
    source = f"G49 F200 G0 X0 Y0 Z100 A0 C0\n{program}\nG80\nM2".encode()
    try:
        interpret_program(source, build_interpreter_setup(machine, Options(dialect="rs274")))
        found = None
    except Exception as error:
        (found,) = [item for item in error.findings if item.severity == "error"]
        assert found.line == 3
    assert (found.code if found else None) == code


def test_a_hole_converts(machine):
    program = b"G49 F600 G0 X0 Y0 Z60 A0 C0\nG98 G83 X5 Y5 Z20 R30 Q6\nX-5\nG80\nM2"
    result = check(program, machine, Options(dialect="rs274"))
    assert result.ok, result.findings
    assert result.summary.n_stops > 10


def test_the_tool_axis_is_named_where_it_is_not_along_the_hole(machine):
    """A 20 C 30: sin 20 sin 30, sin 20 cos 30, cos 20."""
    program = b"G49 F600 G0 X0 Y0 Z60 A20 C30\nG81 X5 Y5 Z20 R30\nM2"
    (found,) = check(program, machine, Options(dialect="rs274")).findings
    assert (found.code, found.line) == ("VP017", 2)
    assert (
        "G81 drills along Z, but the tool points along (0.1710, 0.2962, 0.9397), at A20 C30 of the machine:"
        in found.message
    )


@pytest.mark.parametrize(("line", "code"), [
    ("G81 X1 R2", "VP005"), ("G81 X1 Z-1", "VP005"), ("G81 Z-1 R-2", "VP007"), ("G82 Z-1 R2", "VP005"),
    ("G83 Z-1 R2", "VP005"),
    ("G83 Z-1 R2 Q0", "VP007"), ("G83 Z-1 R2 Q.000001", "VP007"), ("G73 Z-1 R2 Q-1", "VP007"),
    ("G81 Z-1 R2 L0", "VP007"),
    ("G81 Z-1 R2 L99999", "VP007"), ("G81 Z-1 R2 A5", "VP017"), ("G93 G81 Z-1 R2", "VP017"), ("G84 Z-1 R2", "VP017"),
    ("S9 M4 G84 Z-1 R2", "VP017"), ("S9 M3 G74 Z-1 R2", "VP017"), ("S9 M3 G87 Z-1 R2 I1 J1", "VP005"), ("G81", "VP005"),
    ("G82 Z-1 R2 P-1", "VP007"), ("G81 Z-1 R2 Q1", "VP006"),
])  # fmt: skip
def test_refused(view, line, code):
    found = view(f"F9\n{line}\nM2", dialect="rs274")[1]
    assert [(item.code, item.line) for item in found] == [(code, 2)]


# --- G90 and G91 between the blocks of a series -----------------------------------------------------------

CHANGE = "F9 G0 Z6\nG81 X1 Z-3 R2\nG91\nX5 L2\nG90\nX0 R4"


def test_kept_numbers_are_read_in_the_new_mode_with_a_warning(moves_text, view):
    moves, findings = view(f"{CHANGE}\nM2", dialect="rs274")
    assert findings == ()
    assert sorted({(int(line), z) for line, z in zip(moves.line, moves.end[:, 2], strict=True)}) == [
        (1, 6.0),
        (2, -3.0),
        (2, 2.0),
        (2, 6.0),
        (4, 5.0),
        (4, 8.0),
        (6, -3.0),
        (6, 4.0),
        (6, 8.0),
    ]
    assert [(item.code, item.severity, item.line, item.count) for item in moves.findings] == [
        ("VP030", "warning", 4, 1),
        ("VP030", "warning", 6, 1),
    ]
    first, second = (item.message for item in moves.findings)
    assert "keeps R and Z of G90 in G91: the hole goes from Z 8 to 5 mm" in first
    assert "at the earlier heights it would go from 2 to -3 mm" in first
    assert "keeps Z of G91 in G90: the hole goes from Z 4 to -3 mm" in second
    assert "at the earlier heights it would go from 4 to 5 mm" in second


def test_fanuc_controls_keep_the_heights_with_a_warning(view):
    moves, findings = view(f"{CHANGE.replace('L2', 'K2')}\nM2", dialect="fanuc")
    assert findings == ()
    assert sorted({z for line, z in zip(moves.line, moves.end[:, 2], strict=True) if line == 4}) == [-3.0, 2.0, 6.0]
    assert [item.line for item in moves.findings] == [4]
    assert "the hole goes from Z 2 to -3 mm; read in G91 it would go from 8 to 5 mm" in moves.findings[0].message


@pytest.mark.parametrize(
    ("lines", "warnings"),
    [
        ("G81 X1 Z-3 R2\nG91 X5 Z-5 R-4", 0),  # all given again
        ("G81 X1 Z-3 R2\nG91 G90 X5", None),  # two of one group
        ("G81 X1 Z-3 R2\nG91\nG90\nX5", 0),  # nothing was drilled between
        ("G81 X1 Z-3 R2\nG91\nX5\nX5\nX5", 1),  # once for each change
        ("G81 X1 Z-3 R2\nG91\nG80\nG0 X5", 0),
        ("G0 Z0\nG91 G81 X1 Z-1 R1\nG90 R1 X5", 1),  # from R1 to 0, or to -1
        ("G0 Z0\nG91 G81 X1 Z-1 R0\nG90 X5", 0),  # the same hole either way
    ],
)
def test_when_a_change_is_warned_about(view, lines, warnings):
    moves, findings = view(f"F9 G0 Z6\n{lines}\nM2", dialect="rs274")
    assert (len(moves.findings) if findings == () else None) == warnings


def test_a_line_that_comes_again_is_one_warning(view):
    program = "F9 G0 Z6\no1 repeat [3]\nG90 G81 X1 Z-3 R2\nG91 X5\no1 endrepeat\nM2"
    moves, findings = view(program, dialect="rs274")
    assert findings == ()
    assert [(item.line, item.count) for item in moves.findings] == [(4, 3)]


def test_check_shows_the_warning_also_beside_an_error(machine):
    program = "G49 F600 G0 X0 Y0 Z60 A0 C0\nG81 X5 Y5 Z50 R55\nG91\nX-5 {}\nG80\nM2"
    options = Options(dialect="rs274", tool_length=100, wcs={"G54": (0, 0, 0)})
    result = check(program.format("Z-3").encode(), machine, options)
    assert [(item.code, item.line) for item in result.findings if item.severity == "warning"] == [("VP030", 4)]
    # the number of R alone now lies 60 mm higher, that of Z below it
    refused = check(program.format("").encode(), machine, Options(dialect="rs274"))
    assert [(item.code, item.line) for item in refused.findings] == [("VP007", 4), ("VP030", 4)]


@pytest.mark.parametrize(
    "words", ["X5", "X5 Z-1", "X5 R1", "G98 X5 Z-1 R1", "G91 X5 Z-1 R1", "G83 X5 Z-1 R1 Q1\n{0}\nX3 R1 Z-1"]
)
@pytest.mark.parametrize("units", [("G21", "G20"), ("G20", "G21")])
def test_a_series_does_not_go_on_in_another_unit(view, units, words):
    first, then = units
    lines = f"{first} F9 G0 Z2\nG81 Z-1 R1\n{then}\n{words.format(first)}".split("\n")
    found = view("\n".join([*lines, "M2"]), dialect="rs274")[1]
    assert [(item.code, item.line) for item in found] == [("VP017", len(lines))]
    assert view(f"{first} F9 G0 Z2\nG81 Z-1 R1\n{then}\nG99 X5 Z-1 R1\nM2", dialect="rs274")[1] == ()
    assert view(f"{first} F9 G0 Z2\nG81 Z-1 R1\nG80\n{then}\nG81 X1 Z-1 R1\nM2", dialect="rs274")[1] == ()
    assert view(f"{first} F9 G0 Z2\nG81 Z-1 R1\n{then}\n{first}\n{words.format(first)}\nM2", dialect="rs274")[1] == ()


@pytest.mark.parametrize(
    ("words", "legal"),
    [("G91 X1 Z-2 R1", False), ("G98 X1 Z-2 R1", False), ("X1", True), ("X1 R2", True), ("X1 R.5 Z-1", False)],
)
def test_the_level_of_another_unit_stays_unknown_when_lengths_are_given_again(view, words, legal):
    found = view(f"F9 G0 Z6\nG81 Z-3 R1\nG20\nG99 Z-2 R1 X0\n{words}\nM2", dialect="rs274")[1]
    assert [(item.code, item.line) for item in found] == ([] if legal else [("VP017", 5)])


def test_a_back_bore_says_its_shift_again(view):
    program = "S9 M3 F9 G0 Z9\nG87 Z-1 R2 X1 I1 J1 K1\nG91 X1 {}\nM2"
    assert [(item.code, item.line) for item in view(program.format(""), dialect="rs274")[1]] == [("VP005", 3)]
    assert view(program.format("I1 J1 K1"), dialect="rs274")[1] == ()


# --- polar words ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("unit", ["G21", "G20"])
def test_polar_words_turn_on_with_every_repeat(view, unit):
    moves, findings = view(f"{unit} F9 G0 X10 Y0 Z5\nG91 G81 ^[360/12] Z-3 R-2 L12\nM2", dialect="rs274")
    assert findings == ()
    holes = moves.end[moves.kind == 1, :2] / (25.4 if unit == "G20" else 1.0)
    angle = np.radians(30 * np.arange(1, 13))
    assert np.allclose(holes, 10 * np.stack([np.cos(angle), np.sin(angle)], axis=-1), rtol=0, atol=1e-9)


def test_polar_distance_and_angle_grow_with_every_repeat(view):
    moves, _ = view("F9 G0 X10 Y0 Z5\nG91 G81 @2 ^90 Z-3 R-2 L3\nM2", dialect="rs274")
    assert np.allclose(moves.end[moves.kind == 1, :2], [[0, 12], [-14, 0], [0, -16]], rtol=0, atol=1e-9)


def test_a_row_of_polar_repeats_does_not_guess_its_way_through_zero(view):
    # 10 mm towards zero from 8.66, 5: what is left of the distance is rounding, and has no angle
    found = view("F9 G0 @10 ^30 Z5\nG91 G81 @-10 Z-3 R-2 L2\nM2", dialect="rs274")[1]
    assert [(item.code, item.line) for item in found] == [("VP017", 2)]


@pytest.mark.parametrize(
    ("code", "spindle", "words"),
    [
        ("G74", "M3", "left-hand thread; it needs M4"),
        ("G84", "M4", "right-hand thread; it needs M3"),
    ],
)
def test_a_tap_that_turns_the_wrong_way_is_told_which_one_is_right(view, code, spindle, words):
    _moves, findings = view(f"G0 X0 Y0 Z5\nS100 {spindle} F100\n{code} Z-5 R2\nM2", dialect="rs274")
    assert [(one.code, one.line) for one in findings] == [("VP017", 3)]
    assert words in findings[0].message


@pytest.mark.parametrize("before", ["G0", "G1"])
def test_axis_words_beside_g80_are_a_motion_of_fanuc(moves_text, before):
    text = f"G21 G90 G17 G49 F600 G0 X0. Y0. Z60.\n{before} X1.\nG98 G81 X5. Z20. R30.\n{{}}\nX9.\nM30"
    beside, alone = (
        [move.split(maxsplit=1)[1] for move in moves_text(text.format(end), dialect="fanuc")]
        for end in ("G80 Z80.", "G80\nZ80.")
    )
    assert beside == alone
    assert "Z80" in beside[-2]


def test_axis_words_beside_g80_have_no_use_in_rs274(view):
    _moves, findings = view("F9 G0 Z2\nG81 X1 Z-1 R1\nG80 Z5\nM2", dialect="rs274")
    assert [item.code for item in findings] == ["VP006"]
