"""Stretches of plain lines of Siemens programs are executed as arrays, and give what single lines give."""

import random

import numpy as np
import pytest

from verne_post.app.assemble import interpreter_view
from verne_post.gcode import plain
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
    return interpreter_view(text.encode(), Options(dialect="siemens", tools={1: Tool(1, 1, (0.0,) * 9)}, **options))


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
    for name in ("line", "kind", "end", "feed", "frame", "control", "spindle"):
        assert np.array_equal(getattr(fast, name), getattr(slow, name), equal_nan=True), name
    assert np.array_equal(fast.tool_axis, slow.tool_axis, equal_nan=True)
    assert fast.frames == slow.frames
    assert np.array_equal(fast.arcs.center, slow.arcs.center)


def test_stretches_are_executed_as_arrays(monkeypatch):
    done = []
    execute = plain.execute
    monkeypatch.setattr(
        plain,
        "execute",
        lambda lines, first, last, *rest: done.append(last - first) or execute(lines, first, last, *rest),
    )
    for head, count in (("TRAORI", [40]), ("", [])):
        done.clear()
        view("\n".join(["G1 X0 Y0 Z0 A0 C0 F100", head, *(f"X{number} A{number}" for number in range(40))]))
        assert done == count, head
    done.clear()
    view("\n".join(["G1 X0 Y0 Z0 F100", *(f"N{number} X{number} Y5.5 ; note" for number in range(40))]))
    assert done == [41]
