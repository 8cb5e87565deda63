"""Ends of programs with tool axes: places of the machine, while only the whole program says on which side the table
stands.

On the serial machine the joints are X, Y, Z, A and C themselves: what a block does not name must stay to the last
digit.
"""

import re
from pathlib import Path

import numpy as np
import pytest

from verne_post import convert
from verne_post.app.assemble import assemble, find_modal_state
from verne_post.config.load import build_machine
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset

SERIAL = (Path(__file__).parents[2] / "machine_configs" / "serial.toml").read_text(encoding="utf-8")
SIEMENS = (
    "TRAORI\nG0 X30 Y10 Z50 A3=0.1 B3=0.15 C3=1\nG1 X10 A3=0.3 B3=0.1 C3=1 F500\nX-20 A3=0.3 B3=-0.2 C3=1\nTRAFOOF\n"
)
FANUC = "G21 G90 G54\nG0 X30. Y10. Z50. G43.5 H0 I0.6 J0. K0.8\nG1 X-20. I0.48 J-0.36 K0.8 F500.\nG49\n"
KLARTEXT = (
    "BEGIN PGM A MM\n"
    "TOOL CALL 1 Z S5000\n"
    "FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR\n"
    "L X+30 Y+10 Z+50 A+0 C+0 R0 FMAX\n"
    "LN X+10 Y+10 Z+50 TX+0.6 TY+0 TZ+0.8 F500\n"
    "LN X-20 Y+10 Z+50 TX+0.48 TY-0.36 TZ+0.8\n"
    "FUNCTION RESET TCPM\n"
)
#: Joints that each block sends to 0; the others stay.
TAILS = {
    "siemens": [["SUPA Z0 D0", "Z"], ["SUPA X0 Y0", "XY"], ["SUPA A0 C0", "AC"]],
    "both at once": [["SUPA Z0 D0", "Z"], ["SUPA A0 C0", "AC"], ["SUPA X0 Y0", "XY"]],
    "one after the other": [["SUPA Z0 D0", "Z"], ["SUPA A0", "A"], ["SUPA C0", "C"], ["SUPA X0", "X"],
                            ["SUPA Y0", "Y"]], "one block": [["SUPA Z0 D0", "Z"], ["G0 SUPA X0 Y0 A0 C0", "XYAC"]],
    "G75": [["G75 Z0", "Z"], ["G75 X0 Y0", "XY"], ["G75 A0 C0", "AC"]],
    "without SUPA": [["G0 SUPA Z0 D0", "Z"], ["G0 A0 C0", "AC"], ["SUPA X0 Y0", "XY"]],
    "A alone": [["G0 SUPA Z0 D0", "Z"], ["G0 A0", "A"], ["G0 C0", "C"]],
}  # fmt: skip


def joints_of_lines(program):
    """Joints at the end of the last motion of each line."""
    path = program.path
    q = program.machine.five_axis.solve(path.end[:, :3], path.end[:, 3:], path.tool_length)[0]
    return {int(line): q[row] for row, line in enumerate(path.line)}


def machine_with(a_deg):
    """The serial machine with another travel of A: of the two sides of the table only one fits."""
    text = re.sub(r"^a_deg = .*$", f"a_deg = {a_deg}", SERIAL, count=1, flags=re.MULTILINE)
    text = re.sub(r"^g28 = .*$", "g28 = [0.0, 0.0, 0.0, 0.0, 0.0]", text, count=1, flags=re.MULTILINE)
    return build_machine(text.encode(), "serial.toml")


def check_tail(program, first, tail):
    at = joints_of_lines(program)
    before, last = at[first], first
    for number, (_block, sent) in enumerate(tail, start=1):
        line = first + number
        now = at.get(line, at[last])  # a block that moves nothing has no motion
        stays = [axis for axis in range(5) if "XYZAC"[axis] not in sent]
        assert now[stays] == pytest.approx(before[stays], abs=1e-8), tail[number - 1]
        assert now[["XYZAC".index(letter) for letter in sent]] == pytest.approx(0.0, abs=1e-8), tail[number - 1]
        before, last = now, line if line in at else last


@pytest.mark.parametrize("a_deg", ["[-95.0, 95.0]", "[-95.0, 1.0]", "[-1.0, 95.0]"])
@pytest.mark.parametrize("tail", TAILS)
def test_siemens(tail, a_deg):
    blocks = TAILS[tail]
    text = SIEMENS + "\n".join(block for block, _sent in blocks) + "\nM30"
    options = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 60.0))}, dialect="siemens", smoothing="off")
    program = assemble(text.encode(), machine_with(a_deg), options)
    assert [item for item in program.findings if item.severity == "error"] == []
    first = np.flatnonzero([line.startswith("TRAFOOF") for line in text.splitlines()])[0]
    check_tail(program, int(first), [["TRAFOOF", ""], *blocks])


@pytest.mark.parametrize("a_deg", ["[-95.0, 95.0]", "[-95.0, 1.0]", "[-1.0, 95.0]"])
@pytest.mark.parametrize("dialect", ["fanuc", "rs274", "heidenhain"])
def test_other_dialects(dialect, a_deg):
    if dialect == "heidenhain":
        text, first = KLARTEXT, 6
        blocks = [["L Z+0 R0 FMAX M91", "Z"], ["L X+0 Y+0 R0 FMAX M91", "XY"], ["L A+0 C+0 R0 FMAX M91", "AC"]]
        end = "END PGM A MM"
    else:
        text, first, end = FANUC, 3, "M30"
        blocks = [["G53 G0 Z0.", "Z"], ["G53 G0 X0. Y0.", "XY"], ["G53 G0 A0. C0.", "AC"]]
    body = text + "\n".join(block for block, _sent in blocks) + f"\n{end}\n"
    options = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 60.0))}, dialect=dialect, smoothing="off")
    program = assemble(body.encode(), machine_with(a_deg), options)
    assert [item for item in program.findings if item.severity == "error"] == []
    check_tail(program, first, [["", ""], *blocks])


def test_the_rows_and_the_modal_state_are_those_of_the_side_that_was_chosen():
    text = (SIEMENS + "G0 SUPA Z0 D0\nSUPA X0 Y0\nSUPA A0 C0\nM30").encode()
    machine = machine_with("[-95.0, 1.0]")
    options = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 60.0))}, dialect="siemens")
    result = convert(text, machine, options)
    assert result.ok  # convert verifies its rows
    assert result.setpoints.values[-1] == pytest.approx([0.0] * 5, abs=1e-6)
    program = assemble(text, machine, options)
    state = find_modal_state(text, program, 7)[0]
    place = machine.coordinates.map_to_machine(np.array(state.position), state.frame)
    assert place[[0, 1]] == pytest.approx([0, 0], abs=1e-8)
    assert place[3] < 0
