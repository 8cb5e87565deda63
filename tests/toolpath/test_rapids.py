"""Rapids linear in the joints: rows on a straight line of joint space, standstills at both ends, and honest checks."""

import numpy as np
import pytest

import verne_post
from verne_post.app.assemble import assemble
from verne_post.app.constraints import check_program

from ..builders import MACHINE, OPTIONS, setpoints_of

JOINT = OPTIONS.changed(rapids="joint")
SOURCE = (
    b"G21 G90 G94\nG0 X0 Y0 Z60 A0 C0\nG0 X60 Y-40 Z90 A35 C80\nG1 X50 F2000\nY-20\nG0 Z100\nG4 P0.05\nG0 A0 C0\nM2\n"
)


def test_rows_of_a_rapid_lie_on_a_straight_line_of_the_joints():
    rows = setpoints_of(SOURCE, options=JOINT)
    for line in (3, 6, 8):
        q = rows.values[rows.line == line]
        delta = q[-1] - q[0]
        u = (q - q[0]) @ delta / (delta @ delta)
        assert (np.diff(u) >= -1e-9).all()
        # rounding to seven and eight decimals
        assert np.abs(q - q[0] - u[:, None] * delta).max() < 2e-7
    straight = setpoints_of(SOURCE, options=OPTIONS)
    q = straight.values[straight.line == 3]
    delta = q[-1] - q[0]
    off = q - q[0] - ((q - q[0]) @ delta / (delta @ delta))[:, None] * delta
    assert np.abs(off).max() > 0.5  # the straight tip line is another path


def test_rapids_stand_still_at_both_ends_and_feed_moves_flow():
    rows = setpoints_of(SOURCE, options=JOINT)
    still = np.flatnonzero((np.diff(rows.values, axis=0) == 0).all(axis=1))
    for line in (3, 6):
        last = np.flatnonzero(rows.line == line)[-1]
        assert any(abs(row - last) <= 3 for row in still)
    corner = np.flatnonzero(rows.line == 5)[0]
    assert not any(abs(row - corner) <= 3 for row in still)


def test_checks_are_made_on_the_delta_that_the_tool_really_takes():
    """From one side of the table to the other with A through 180 degrees of C: the straight line is legal."""
    source = b"G21 G90 G94\nG0 X90 Y0 Z25 A0 C0\nG0 X-90 Y0 Z25 A0 C179\nM2\n"
    line, joint = (check_program(assemble(source, MACHINE, options))[1] for options in (OPTIONS, JOINT))
    assert line == []
    program = assemble(source, MACHINE, JOINT)
    joints = program.build_joint_path()
    solved = joints.solve(np.full(2001, len(program.contour) - 1), np.linspace(0.0, 1.0, 2001))
    lowest = solved.tip[:, 2].min()
    assert [item.code for item in joint] == (["VP210"] if lowest < 0 else [])


@pytest.mark.parametrize("name", ["serial", "linear_delta"])
def test_other_machines(name):
    result = verne_post.convert(SOURCE, verne_post.load_machine(name), JOINT)
    assert result.ok, result.findings
