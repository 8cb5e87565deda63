"""Canned cycles where rs274 gives no answer: on a tilted table, in fanuc's words, and how their corners are taken."""

import pytest

from verne_post import check
from verne_post.app.assemble import machine_setup
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
        "3 rapid Z6", "3 rapid X5 Z6", "3 feed X5 Z-1 F9", "3 rapid X5 Z6",
    ]  # fmt: skip


def test_g98_stays_at_the_initial_level_between_holes(moves_text):
    assert moves_text("F9 G0 Z9\nG99 G81 Z-1 R2\nG98 X5\nM2", dialect="rs274")[5:] == [
        "3 rapid Z9", "3 rapid X5 Z9", "3 rapid X5 Z2", "3 feed X5 Z-1 F9", "3 rapid X5 Z9",
    ]  # fmt: skip


@pytest.mark.parametrize(("program", "code"), [
    ("G0 Z60 A20\nG81 X1 Z20 R40", "VP017"), ("G0 Z60 A0 C40\nG81 X1 Z20 R40", None), ("G0 A180 Z60\nG81 X1 Z20 R40", "VP017"),
    ("G0 Z60 A90\nG18 G81 X1 Y-5 R9", None), ("G0 Z60 A-90\nG18 G81 X1 Y-5 R9", "VP017"), ("G0 Z60 A.05\nG81 X1 Z20 R40", None), ("G0 Z60 A.1\nG81 X1 Z20 R40", "VP017"),
])  # fmt: skip
def test_a_drill_must_point_along_its_hole(machine, program, code):
    source = f"G49 F200 G0 X0 Y0 Z100 A0 C0\n{program}\nG80\nM2".encode()
    try:
        interpret_program(source, machine_setup(machine, Options(dialect="rs274")))
        found = None
    except Exception as error:
        found = error.findings[0]
        assert found.line == 3
    assert (found.code if found else None) == code


def test_a_hole_converts(machine):
    program = b"G49 F600 G0 X0 Y0 Z60 A0 C0\nG98 G83 X5 Y5 Z20 R30 Q6\nX-5\nG80\nM2"
    result = check(program, machine, Options(dialect="rs274"))
    assert result.ok, result.findings
    assert result.summary.n_stops > 10


@pytest.mark.parametrize(("line", "code"), [
    ("G81 X1 R2", "VP005"), ("G81 X1 Z-1", "VP005"), ("G81 Z-1 R-2", "VP007"), ("G82 Z-1 R2", "VP005"), ("G83 Z-1 R2", "VP005"),
    ("G83 Z-1 R2 Q0", "VP007"), ("G83 Z-1 R2 Q.000001", "VP007"), ("G73 Z-1 R2 Q-1", "VP007"), ("G81 Z-1 R2 L0", "VP007"),
    ("G81 Z-1 R2 L99999", "VP007"), ("G81 Z-1 R2 A5", "VP017"), ("G93 G81 Z-1 R2", "VP017"), ("G84 Z-1 R2", "VP017"),
    ("S9 M4 G84 Z-1 R2", "VP017"), ("S9 M3 G74 Z-1 R2", "VP017"), ("S9 M3 G87 Z-1 R2 I1 J1", "VP005"), ("G81", "VP005"),
    ("G82 Z-1 R2 P-1", "VP007"), ("G81 Z-1 R2 Q1", "VP006"),
])  # fmt: skip
def test_refused(view, line, code):
    found = view(f"F9\n{line}\nM2", dialect="rs274")[1]
    assert [(item.code, item.line) for item in found] == [(code, 2)]
