"""Random Fanuc programs: no traceback, findings with a line of the text, the same answer with and without a machine's help.

``python -m tests.gcode.test_fanuc_fuzz 10000 5000`` tries 10000 programs from seed 5000 on.
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
    {"fanuc": {"motion": "G1", "units": "inch"}},
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
    good = sum(
        try_program(make_program(random.Random(seed)), make_options(seed)) for seed in range(first, first + many)
    )
    sys.stdout.write(f"{many} programs from {first} on, {good} without a finding\n")
