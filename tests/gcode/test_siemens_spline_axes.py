"""A3= B3= C3= in blocks of BSPLINE: A and C of the control points are coordinates of the curve, as if they were
written.
"""

import math

import numpy as np
import pytest

from verne_post.app.assemble import build_interpreter_setup
from verne_post.gcode import interpret_program
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options

ANGLES = [(20, 30), (22, 34), (25, 40), (24, 44), (21, 41), (18, 36)]
PLACES = [(40, 0, 50), (38, 3, 50), (35, 9, 49), (30, 8, 48), (26, 2, 48), (20, 0, 47)]


def axis_of(a, c):
    """The tool axis with the table at A and C, degrees: docs/conventions.md."""
    a, c = math.radians(a), math.radians(c)
    return math.sin(a) * math.sin(c), math.sin(a) * math.cos(c), math.cos(a)


def program(words, *, orientation="ORIWKS", frame=""):
    """A spline whose blocks have the words that a function makes of A and C."""
    head = f"TRAORI\n{orientation}\n{frame}\nG0 X40 Y0 Z50 A20 C30\nG1 F500"
    points = [f"X{x} Y{y} Z{z} {words(a, c)}" for (x, y, z), (a, c) in zip(PLACES, ANGLES, strict=True)]
    return "\n".join([head, f"BSPLINE {points[1]}", *points[2:], "G1 X0\nM30"]).encode()


def vector_words(a, c, size=2.0):
    """A3= B3= C3=, of any length."""
    return " ".join(f"{name}3={size * value:.12f}" for name, value in zip("ABC", axis_of(a, c), strict=True))


@pytest.fixture(scope="module")
def moves_of(machine):
    """Moves on the machine."""
    setup = build_interpreter_setup(machine, Options(tool_length=60.0, dialect="siemens"))
    return lambda source: interpret_program(source, setup)


@pytest.mark.parametrize("orientation", ["ORIWKS", "ORIMKS", "ORIAXES"])
def test_axes_of_control_points_are_their_angles(moves_of, orientation):
    by_vectors = moves_of(program(vector_words, orientation=orientation))
    by_words = moves_of(program(lambda a, c: f"A{a} C{c}", orientation="ORIMKS"))
    assert (by_vectors.kind == MoveKind.SPLINE).sum() == len(PLACES) - 3
    assert by_vectors.splines.points == pytest.approx(by_words.splines.points, abs=1e-8)
    assert np.isnan(by_vectors.tool_axis[by_vectors.kind == MoveKind.SPLINE]).all()


def test_a_block_without_axis_keeps_it(moves_of):
    kept = moves_of(program(lambda a, c: vector_words(a, c) if c != 44 else ""))
    assert kept.splines.points[:, [3, 5]].tolist().count(pytest.approx([25, 40])) > 1
    assert not np.isclose(kept.splines.points[:, 5], 44).any()


def test_without_a_machine_the_axes_are_shown(view):
    moves, errors = view(program(vector_words), dialect="siemens")
    assert errors == ()
    curve = moves.kind == MoveKind.SPLINE
    assert np.linalg.norm(moves.tool_axis[curve], axis=1) == pytest.approx(1.0)
    assert moves.tool_axis[curve][-1] == pytest.approx(axis_of(*ANGLES[-1]))


@pytest.mark.parametrize(
    ("block", "code", "what"),
    [
        ("BSPLINE A3=1", "VP005", "A3= needs the axes"),
        ("BSPLINE X1 C3=1 A5", "VP003", "one BSPLINE"),
        ("BSPLINE X1\nX2 A3=1 C3=3", "VP031", "first block"),
        ("TRAFOOF\nBSPLINE X1 C3=1", "VP017", "TRAORI"),
        ("BSPLINE X1 A3=0", "VP007", "length 0"),
    ],
)
def test_refusals(view, block, code, what):
    _moves, errors = view(
        f"TRAORI\nG0 X0 Y0 Z9 A0 C0\nG1 F500\n{block}\nX2 Y5\nX3\nX4 Y2\nG1 X0\nM30", dialect="siemens"
    )
    assert [(error.code, what in error.message) for error in errors] == [(code, True)]


def test_other_blocks_between_two_splines(view):
    spline = "X5 Y5\nX10 Y0\nX15 Y5"
    moves, errors = view(
        f"G0 X0 Y0 Z9\nG1 F500\nBSPLINE {spline}\nM8\nF200\n{spline}\nM9\nG1 X0\nM30", dialect="siemens"
    )
    assert errors == ()
    assert moves.kind.tolist() == [MoveKind.RAPID, MoveKind.SPLINE, MoveKind.SPLINE, MoveKind.FEED]
    assert moves.feed[1:3].tolist() == [500, 200]


def test_axes_too_far_apart_for_angles(machine):
    setup = build_interpreter_setup(machine, Options(tool_length=60.0, dialect="siemens"))
    text = program(lambda a, c: vector_words(a, 30 + 8 * (c - 30)))
    with pytest.raises(Exception, match="too far apart") as caught:
        interpret_program(text, setup)
    assert [(item.code, item.line) for item in caught.value.findings] == [("VP031", 6)]
