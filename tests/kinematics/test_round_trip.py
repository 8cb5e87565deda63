"""A million poses of the whole machine: the product's inverse, then a forward solution that shares no code with it."""

import numpy as np
from newton_raphson import forward_machine, inverse, numbers_of, pose_without_tilt

from verne_post.base.rotations import find_axis_of_angles

#: Blocks of poses: the memory of the test stays small.
BLOCKS, BLOCK = 10, 100_000
#: Round trip in mm and of the unit axis. Measured 8e-13 and 4e-16; the rest is room for another platform's rounding.
ROUND_TRIP_MM = 1e-9
ROUND_TRIP_AXIS = 1e-12
#: Smallest vertical drop of a rod that the shipped machine file allows.
SMALLEST_DROP_MM = 100.0


def test_a_million_poses_return(machine):
    """Tips within +-150 mm and 0 to 150 mm high, tilts up to 90 degrees, tools of 50 to 250 mm."""
    rng = np.random.default_rng(20)
    lengths, table = numbers_of(machine.five_axis)
    for _ in range(BLOCKS):
        tip = rng.uniform([-150.0, -150.0, 0.0], [150.0, 150.0, 150.0], (BLOCK, 3))
        axis = find_axis_of_angles(rng.uniform(0.0, np.pi / 2, BLOCK), rng.uniform(-np.pi, np.pi, BLOCK))
        tool = rng.uniform(50.0, 250.0, BLOCK)
        q, ok = machine.inverse(tip, axis, tool)
        assert ok.all()
        assert np.isfinite(q).all()
        solved, tip_back, axis_back = forward_machine(lengths, table, q, tool)
        assert solved.ok.all()
        assert np.abs(tip_back - tip).max() < ROUND_TRIP_MM
        assert np.abs(axis_back - axis).max() < ROUND_TRIP_AXIS


def test_beyond_reach_every_pose_is_refused_with_its_reason(machine):
    """Poses around the workspace: what the product refuses, Newton-Raphson cannot solve either; what it solves is
    right.
    """
    rng = np.random.default_rng(21)
    n = 6000
    lengths, table = numbers_of(machine.five_axis)
    tip = rng.uniform(-1200.0, 1200.0, (n, 3))
    angles = np.column_stack([rng.uniform(0.0, np.pi, n), rng.uniform(-np.pi, np.pi, n)])
    axis = find_axis_of_angles(angles[:, 0], angles[:, 1])
    tool = rng.uniform(0.0, 300.0, n)
    q, ok = machine.inverse(tip, axis, tool)
    out = np.flatnonzero(~ok)
    assert 0.3 * n < len(out) < 0.9 * n
    assert np.isnan(q[out]).all()
    assert np.isfinite(q[ok]).all()

    codes = machine.five_axis.explain_unreachable(tip[out[:500]], angles[out[:500]], tool[out[:500]])
    assert len(codes) == 500
    assert set(codes) <= {"VP110", "VP201"}

    start = pose_without_tilt(lengths, table, tip[out], axis[out], tool[out])
    for tilt in (0.0, -0.8, -0.4, 0.4, 0.8):  # rods of leg I cross at 0.908
        start[:, 3] = tilt
        start[:, 7] = angles[out, 0] + tilt
        solved, _q = inverse(lengths, table, tip[out], axis[out], tool[out], start)
        assert not solved.ok.any()

    # Of what is solved, the poses that the machine file allows: towards the serial singularity digits are lost.
    ok[ok] = machine.module.find_geometry_margins(*_platform(machine, q[ok]))[:, :3].min(axis=1) > SMALLEST_DROP_MM
    solved, tip_back, axis_back = forward_machine(lengths, table, q[ok], tool[ok])
    assert solved.ok.all()
    assert np.abs(tip_back - tip[ok]).max() < ROUND_TRIP_MM
    assert np.abs(axis_back - axis[ok]).max() < ROUND_TRIP_AXIS


def _platform(machine, q):
    position, alpha, _ok = machine.module.forward(q[:, :3])
    return position, alpha
