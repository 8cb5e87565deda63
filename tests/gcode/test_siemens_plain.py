"""Stretches of plain lines of Siemens programs are executed as arrays, and give what single lines give."""

import math
import random

import numpy as np
import pytest

from tests.gcode.conftest import assert_same_moves
from verne_post import gcode
from verne_post.app.assemble import build_interpreter_setup, view_moves_plainly
from verne_post.gcode import plain
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

HEADS = [
    "",
    "TRAORI",
    "G70",
    "G700 F5",
    "G91",
    "TRANS X1 C5",
    "SCALE X2 Y2 Z2",
    "ROT Z30",
    "MIRROR X0",
    "G64\nG2 X3 Y4 CR=50",
    "ORIWKS\nTRAORI",
    "CT X9 Y9",
    "G93 F2",
    "MCALL CYCLE81(90,0,2,-5)",
    "T1 M6",
]
TAILS = ["", "CT X3 Y4", "G2 I5 J0", "X=IC(1)", "C=DC(5)"]


def lines(pick):
    """A stretch of about 30 lines, most of them plain."""
    found = []
    for number in range(30):
        words = [f"N{number}"] if pick.random() < 0.5 else []
        words += [pick.choice(["G0", "G1", "G01", "g00"])] if pick.random() < 0.3 else []
        words += [f"{letter}{pick.uniform(-20, 20):.3f}" for letter in "XYZ" if pick.random() < 0.6]
        words += [f"{letter}{pick.uniform(-20, 20):.2f}" for letter in "AC" if pick.random() < 0.1]
        words += [f"F{pick.randint(1, 900)}"] if pick.random() < 0.2 else []
        words += (
            [
                pick.choice(
                    [
                        "; note",
                        "X 1",
                        "Y - 2",
                        "Z1EX0",
                        "G1.",
                        "X1 2",
                        "X1  2",
                        "(note)",
                        "Z=1",
                        "M8",
                        "/1 X5",
                        "X1.5.2",
                        "SOFT",
                        "X5\t",
                        "  ",
                    ]
                )
            ]
            if pick.random() < 0.04
            else []
        )
        found.append(pick.choice([" ", "", "  "]).join(words))
    return found


def view(text, **options):
    return view_moves_plainly(text.encode(), Options(dialect="siemens", tools={1: Tool(1, 1, (0.0,) * 9)}, **options))


@pytest.mark.parametrize("seed", range(120))
def test_stretches_are_their_lines(monkeypatch, seed):
    pick = random.Random(seed)
    text = "\n".join(
        ["G0 X1 Y2 Z3 A0 C0 F100 S100 M3", pick.choice(HEADS), *lines(pick), pick.choice(TAILS), *lines(pick)]
    )
    fast, fast_errors = view(text)
    monkeypatch.setattr(plain, "MIN_LINES", 10**9)
    slow, slow_errors = view(text)
    assert fast_errors == slow_errors
    assert_same_moves(fast, slow)
    assert np.array_equal(fast.arcs.center, slow.arcs.center)


def test_stretches_are_executed_as_arrays(stretches):
    for head, count in (("TRAORI", [40]), ("", [])):
        stretches.clear()
        view("\n".join(["G1 X0 Y0 Z0 A0 C0 F100", head, *(f"X{number} A{number}" for number in range(40))]))
        assert stretches == count, head
    stretches.clear()
    view("\n".join(["G1 X0 Y0 Z0 F100", *(f"N{number} X{number} Y5.5 ; note" for number in range(40))]))
    assert stretches == [41]


# --- tool axes -------------------------------------------------------------------------------------------

#: What stands before lines with tool axes; MIRROR and ROT turn the axes with the frame.
VECTOR_HEADS = [
    "TRAORI",
    "TRAORI",
    "TRAORI",
    "TRAORI\nORIAXES",
    "TRAORI\nORIWKS\nORIVECT",
    "TRAORI\nTRANS X5 Z3",
    "TRAORI\nROT Z20",
    "TRAORI\nMIRROR X0",
    "TRAORI\nORIMKS\nROT Z10",
    "",
    "TRAORI\nG91",
    "TRAORI\nG93 F5",
    "TRAORI\nA3=0.1 C3=1",
]
ODD = [
    "A3=0 B3=0 C3=0",
    "A3=IC(1) C3=1",
    "I5",
    "A3=1EX-1 C3=1",
    "A10 C20",
    "X1 A3=1 A3=2 C3=3",
    "X5",
    "A3 = 0.2 C3=1",
    "B3=R1 C3=1",
    "a3=.3 c3= 1",
]


def vector_lines(pick, wrong):
    """Lines of which most have a tool axis: on both sides of the pole, near it and at it."""
    found, tilt, turn = [], pick.uniform(-30, 30), pick.uniform(-180, 180)
    for number in range(40):
        tilt, turn = tilt + pick.uniform(-6, 6), turn + pick.uniform(-40, 60)
        tilt = pick.choice([tilt] * 9 + [0.0, 1e-9])
        a, c, size = np.radians(tilt), np.radians(turn), pick.choice([1.0, 1.0, 2.5])
        axis = size * np.sin(a) * np.sin(c), size * np.sin(a) * np.cos(c), size * np.cos(a)
        words = [f"N{number}"] if pick.random() < 0.3 else []
        words += [pick.choice(["G0", "G1"])] if pick.random() < 0.2 else []
        words += [f"{letter}{pick.uniform(-9, 9):.3f}" for letter in "XYZ" if pick.random() < 0.7]
        words += [f"F{pick.randint(1, 900)}"] if pick.random() < 0.1 else []
        words += [f"{name}3={value:.{pick.choice([4, 9])}f}" for name, value in zip("ABC", axis, strict=True)]
        found.append(" ".join(words))
        if pick.random() < wrong:
            found.append(pick.choice(ODD))
    return found


@pytest.mark.parametrize("seed", range(60))
def test_stretches_with_tool_axes_are_their_lines(monkeypatch, machine, seed):
    pick = random.Random(seed)
    head = ["G0 X1 Y2 Z50 A0 C0 F100 S100 M3", pick.choice(VECTOR_HEADS)]
    text = "\n".join([*head, *vector_lines(pick, pick.choice([0, 0, 0.05])), "CT X3 Y4" if seed % 7 == 0 else "M30"])
    answers = []
    for least in (plain.MIN_LINES, 10**9):
        monkeypatch.setattr(plain, "MIN_LINES", least)
        options = Options(dialect="siemens", tool_length=60.0, wcs={"G54": (0.0, 0.0, 40.0)})
        try:
            on_machine = gcode.interpret_program(text.encode(), build_interpreter_setup(machine, options))
        except InputError as error:
            on_machine = error.findings
        answers.append((view(text), on_machine))
    (fast, fast_errors), fast_machine = answers[0]
    (slow, slow_errors), slow_machine = answers[1]
    assert fast_errors == slow_errors
    if isinstance(slow_machine, tuple):
        assert fast_machine == slow_machine
    tables = [(fast, slow)] + ([] if isinstance(slow_machine, tuple) else [(fast_machine, slow_machine)])
    for one, other in tables:
        assert_same_moves(one, other)
        assert (one.frames, one.fixes_c) == (other.frames, other.fixes_c)


@pytest.mark.parametrize("word", ["TRAFOOF", "TRAO.I", "A5 C5", "G1 X1 A=5"])
@pytest.mark.parametrize("head", ["", "G1 X0 Y0 Z0 F100\nTRAORI\nTRAFOOF\n"])
def test_tool_axes_without_traori_are_told_of_any_number_of_lines(monkeypatch, word, head):
    """A rotary word behind eight lines of them was an internal error, where they begin the program."""
    text = head + "G1 X1 A3=0.1 B3=0 C3=0.99 F100\n" * (plain.MIN_LINES + 1) + f"{word}\nM30\n"
    fast = view(text)[1]
    monkeypatch.setattr(plain, "MIN_LINES", 10**9)
    assert fast == view(text)[1]
    assert any("without TRAORI" in item.message for item in fast)


@pytest.mark.parametrize("least", [plain.MIN_LINES, 10**9])
@pytest.mark.parametrize(
    ("wrong", "size", "at"),
    [
        ("A3=0173648 B3=0 C3=0.98", 1.0, 11),
        ("A3=0173648 B3=0 C3=0.98", 1.0, 0),
        ("A3=0173648 B3=0 C3=0.98", 1.0, 39),
        ("A3=0 B3=100 C3=09", 1.0, 11),  # two points
        ("A3=0 B3=100 C3=95", 1.0, 39),
        ("A3=1 B3=0 C3=3", 1.0, None),
        ("A3=50 B3=0 C3=70", 1.0, None),
        ("A3=1 B3=0 C3=-1730.5", 2000.0, None),  # such a post
        ("A3=0 B3=0 C3=1000", 1.0, None),  # the same direction with a point
        ("A3=0 B3=100 C3=900", 1.0, None),  # the same direction
        ("A3=0 B3=300 C3=90", 1.0, None),  # two long numbers
        ("TRAFOOF\nTRAORI\nX1 A3=0 B3=1 C3=1000\nTRAFOOF\nTRAORI", 1.0, None),  # an operation of its own
    ],
)
def test_a_tool_axis_that_has_lost_a_point_is_told(monkeypatch, least, wrong, size, at):
    """The tool lay flat within one move, and nothing was said."""
    monkeypatch.setattr(plain, "MIN_LINES", least)
    rows = [f"X{number} A3=0 B3={0.1 * size:g} C3={0.9 * size:g}" for number in range(40)]
    rows[11 if at is None else at] = f"X5 {wrong}"
    moves, _errors = view("\n".join(["G1 X0 Y0 Z0 A0 C0 F100", "TRAORI", *rows, "M30"]))
    told = [(item.line, item.message) for item in moves.findings if item.code == "VP505"]
    assert [line for line, _text in told] == ([] if at is None else [at + 3])
    length = math.hypot(*(float(word[3:]) for word in wrong.split()[-3:] if "=" in word))
    assert all(f"have the length {length:.6g} here and 0.905539 in line " in text for _line, text in told)


@pytest.mark.parametrize(("line", "code"), [("G.0 X{}", "VP001"), ("N.5 X{}", "VP006")])
def test_words_that_begin_with_a_point_are_told_in_stretches_too(line, code):
    text = "\n".join(["G1 X0 Y0 Z0 F100", *(line.format(number) for number in range(20)), "M30"])
    assert [(item.code, item.line) for item in view(text)[1]] == [(code, 2)]


def test_lines_with_tool_axes_are_executed_as_arrays(stretches):
    rows = [f"X{number} A3=0.{number:02d} B3=-.1 C3=0.9" for number in range(40)]
    moves, errors = view("\n".join(["G1 X0 Y0 Z0 A0 C0 F100", "TRAORI", *rows, *(f"X{k} A1 C1" for k in range(9))]))
    assert errors == ()
    assert stretches == [40, 8]  # the first line with A and C words ends the tool axis, by itself
    assert moves.tool_axis[5] == pytest.approx(np.array([0.04, -0.1, 0.9]) / np.sqrt(0.04**2 + 0.01 + 0.81))


# --- arcs ------------------------------------------------------------------------------------------------

ARC_HEADS = [
    "",
    "TRAORI",
    "TRAORI\nORIAXES",
    "G18",
    "G19",
    "TRANS X1 Y2",
    "ROT Z30",
    "MIRROR X0",
    "SCALE X2 Y2 Z2",
    "G91",
    "G93 F2",
    "G95 F0.1",
    "G70",
    "G41 D1",
    "CT X9 Y9",
    "CIP X5 Y5 I1=2 J1=3",
    "G642 CTOL=0.1",
    "F0",
]
ODD_ARCS = [
    "R5",
    "CR5",
    "I=3",
    "G2 X1 Y2",
    "G2 X5 I1 CR=3",
    "K2",
    "G3 I0 J0",
    "CR=0",
    "TURN=2",
    "I5",
    "CR = 80 ; note",
    "A10",
    "G1",
    "X1 I=AC(3)",
    "AR=20",
]


def arc_lines(pick, wrong):
    """Lines of which about half are arcs, by centre or by radius, with rounded words and without."""
    found, here, straight = [], [0.0, 0.0], True
    for _ in range(40):
        there = [pick.uniform(-20, 20) for _ in range(2)]
        kind = pick.choice(["line", "line", "center", "radius", "full", "again"])
        code = pick.choice(["G2", "G3", "G02", "g3"])
        x, y = (f"{letter}{value:.3f}" for letter, value in zip("XY", there, strict=True))
        if kind == "line":
            words = [pick.choice(["G1", "G1", "G0", *[""] * 3 * straight]), x, y]
        elif kind == "radius":
            words = [
                code,
                x,
                y,
                f"{pick.choice(['CR=', 'cr=', 'CR ='])}{pick.choice([-1, 1]) * pick.uniform(30, 60):.3f}",
            ]
        elif kind == "full":
            words, there = [code, f"I{pick.uniform(1, 9):.3f}", f"J{pick.uniform(-9, 9):.2f}"], here
        else:
            turn = pick.uniform(0.1, 3)
            i, j = pick.uniform(2, 9), pick.uniform(-9, 9)
            there = [
                here[0] + i - i * np.cos(turn) + j * np.sin(turn),
                here[1] + j - i * np.sin(turn) - j * np.cos(turn),
            ]
            x, y = (f"{letter}{value:.6f}" for letter, value in zip("XY", there, strict=True))
            words = [code if kind == "center" or straight else "", x, y, f"I{i:.6f}", f"J{j:.6f}"]
        straight = kind == "line"
        if pick.random() < 0.1:
            words.append(f"Z{pick.uniform(-3, 3):.2f}")
        if pick.random() < 0.05:
            words.append(f"F{pick.randint(10, 900)}")
        if pick.random() < wrong:
            words = [pick.choice(ODD_ARCS)] if pick.random() < 0.5 else [*words, pick.choice(ODD_ARCS)]
        found.append(" ".join(word for word in words if word))
        here = there
    return found


@pytest.mark.parametrize("seed", range(120))
def test_stretches_with_arcs_are_their_lines(monkeypatch, seed):
    pick = random.Random(seed)
    wrong = pick.choice([0.0, 0.0, 0.05])
    text = "\n".join(
        [
            "G71 G0 X0 Y0 Z3 A0 C0 F100 S100 M3",
            pick.choice(ARC_HEADS),
            "G1 X0 Y0",
            *arc_lines(pick, wrong),
            pick.choice(TAILS),
            "G1 X0 Y0",
            *arc_lines(pick, wrong),
            pick.choice(TAILS),
        ]
    )
    fast, fast_errors = view(text)
    monkeypatch.setattr(plain, "MIN_LINES", 10**9)
    slow, slow_errors = view(text)
    assert fast_errors == slow_errors
    assert_same_moves(fast, slow)
    for name in ("center", "sweep", "turns", "plane"):
        assert np.array_equal(getattr(fast.arcs, name), getattr(slow.arcs, name)), name


def test_arcs_are_executed_as_arrays(stretches):
    view("\n".join(["G0 X0 Y0 Z0 A0 C0 F100", "G64", *(["G2 X10 CR=8", "G3 X0 I-5 J0"] * 20), "CT X5 Y9", "M30"]))
    assert 40 in stretches
