"""Random Fanuc programs: no traceback, findings with a line of the text, the same answer with and without a machine's help."""

import random

import pytest

from tests.gcode.fanuc_lines import make_program
from verne_post.app.assemble import build_interpreter_setup, view_moves_plainly
from verne_post.gcode.read import interpret_program
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

TOOLS = {number: Tool(number, number, (0.0, 0.0, 60.0, *(0.0,) * 6), 6.0) for number in (1, 2)}
KEYS = ({}, {"fanuc": {"decimal_point": "conventional", "bore_shift": "-Y", "roll_pitch_yaw": "moving"}})


@pytest.mark.parametrize("seed", range(4))
def test_random_programs(machine, seed):
    rng = random.Random(seed)
    options = Options(
        dialect="fanuc", tools=TOOLS, max_repeats=300, tapping=("feed", "refuse")[seed % 2], control=KEYS[seed // 2]
    )
    ran = 0
    for _ in range(60):
        text = make_program(rng)
        moves, findings = view_moves_plainly(text.encode(), options)
        lines = text.count("\n") + 1
        assert all(item.line is None or 1 <= item.line <= lines for item in findings), text
        assert not findings or len(findings[0].message) < 600
        ran += not findings
        assert (moves.line <= lines).all()
        try:
            interpret_program(text.encode(), build_interpreter_setup(machine, options))
        except InputError as error:
            assert all(1 <= (item.line or 1) <= lines for item in error.findings), text
    assert ran  # or the programs would test refusals alone
