"""Random Fanuc programs: no traceback, findings with a line of the text, the same answer with and without a machine's
help.

``python -m tests.gcode.test_fanuc_fuzz 10000 5000`` tries 10000 programs from seed 5000 on, with ``planes`` behind it
only such with G68.2 P4 in each.
"""

import random
import sys

import pytest

from tests.gcode.fanuc_lines import make_program
from verne_post.app.assemble import build_interpreter_setup, view_moves_plainly
from verne_post.gcode.read import interpret_program
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

TOOLS = {number: Tool(number, number, (0.0, 0.0, 60.0, *(0.0,) * 6), 6.0) for number in (1, 2)}
KEYS = (
    {},
    {
        "fanuc": {
            "decimal_point": "conventional",
            "bore_shift": "-Y",
            "roll_pitch_yaw": "moving",
            "projection_angles": "turned",
        }
    },
    {
        "fanuc": {
            "motion": "G1",
            "units": "inch",
            "directions": "machine",
            "bare_arcs": "lines",
            "cutter_offsets": "wear",
        }
    },
)


def make_options(seed: int) -> Options:
    """The settings of one seed."""
    return Options(
        dialect="fanuc",
        tools=TOOLS,
        max_repeats=300,
        tapping=("feed", "refuse")[seed % 2],
        control=KEYS[seed // 2 % 3],
    )


def try_program(text: str, options: Options) -> bool:
    """Whether a program has no finding; what holds for any is asserted."""
    moves, findings = view_moves_plainly(text.encode(), options)
    lines = text.count("\n") + 1
    assert all(item.line is None or 1 <= item.line <= lines for item in findings), text
    assert not findings or len(findings[0].message) < 600
    assert (moves.line <= lines).all()
    return not findings


#: Values of words of G68.2: usual, at the edge, none, and beyond everything.
ANGLES = ("0", "10.", "-25.", "30.5", "89.5", "90.", "-90.", "180.", "720.", "1e5", "", "#1", "[5+5]", "0.001")


def make_planes(rng: random.Random) -> str:
    """A program with planes by projected angles."""
    words = [
        f"{letter}{rng.choice(ANGLES)}" for letter in rng.choice(("IJK", "IJ", "J", "XYZIJK", "XYZJ", "IJKQ", "IJKR"))
    ]
    rng.shuffle(words)
    turn = rng.choice(("G53.1", "G53.1", "G53.1 P1", "G53.6", "G53.6 H1", ""))
    after = rng.choice(
        ("G1 X5. Y5. Z9.", "G81 X1. Y1. Z-2. R3.", "G68.2 P4 J5.", "G69", "G54", "G2 X5. R9.", "G52 X1.")
    )
    head = "%\nO1\nG21 G90 G17 G40 G80\nG0 X0 Y0 Z30. A0 C0 F500 S1000 M3\nG43 H1\n#1=15.\n"
    return f"{head}G68.2 P4 {' '.join(words)}\n{turn}\n{after}\nG69\nM30\n%"


def test_planes_at_random():
    assert sum(try_program(make_planes(random.Random(seed)), make_options(seed)) for seed in range(100)) > 10


@pytest.mark.parametrize("seed", range(6))
def test_random_programs(machine, seed):
    rng = random.Random(seed)
    options = make_options(seed)
    ran = 0
    for _ in range(40):
        text = make_program(rng)
        ran += try_program(text, options)
        try:
            interpret_program(text.encode(), build_interpreter_setup(machine, options))
        except InputError as error:
            lines = text.count("\n") + 1
            assert all(1 <= (item.line or 1) <= lines for item in error.findings), text
    assert ran  # or the programs would test refusals alone


if __name__ == "__main__":
    many, first = int(sys.argv[1]), int(sys.argv[2])
    make = make_planes if sys.argv[3:] == ["planes"] else make_program
    good = sum(try_program(make(random.Random(seed)), make_options(seed)) for seed in range(first, first + many))
    sys.stdout.write(f"{many} programs from {first} on, {good} without a finding\n")
