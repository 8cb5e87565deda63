"""Newton from home: rows that cannot be solved do no harm to the others, and no row depends on those beside it."""

import numpy as np
import pytest

import verne_post
from verne_post.kinematics.modules.newton import BLOCK, find_poses, settle


class Root:
    """Held by one actuator at its square: pose x, rate 2 x, which is singular at 0; home is 2."""

    def find_first(self):
        return np.array([2.0]), np.array([4.0])

    def differentiate(self, pose, values):
        return 2.0 * pose[:, :, None], pose**2 - values

    def move_back(self, pose, step):
        return pose - step, np.abs(step[:, 0])

    def is_closed(self, pose, values):
        return np.abs(pose**2 - values)[:, 0] < 1e-12


def test_a_singular_row_stays_and_the_others_are_solved():
    poses = settle(Root(), np.array([[3.0], [0.0], [np.nan], [-1.0]]), np.array([[9.5], [1.0], [1.0], [4.0]]))
    assert poses[[0, 1, 3], 0] == pytest.approx([np.sqrt(9.5), 0.0, -2.0], rel=1e-15)
    assert np.isnan(poses[2])


def test_actuators_without_a_pose_are_not_ok():
    poses, ok = find_poses(Root(), np.array([[9.0], [-1.0], [np.nan], [np.inf]]))
    assert ok.tolist() == [True, False, False, False]
    assert poses[0] == 3.0
    assert np.isnan(poses[1:]).all()


@pytest.mark.parametrize("name", ["hexapod", "hexaglide", "tricept", "verne_by_rods"])
def test_rows_do_not_depend_on_those_beside_them(name):
    """More rows than are solved together; some of them are far out of reach, or no numbers."""
    machine = verne_post.load_machine(name)
    k = 6 if name.startswith("hexa") else 3
    held = machine.module or getattr(machine.five_axis, "legs", None) or machine.five_axis.leg
    random = np.random.default_rng(11)
    start = held.find_first()[1]
    values = start + random.uniform(-60.0, 60.0, (BLOCK + 700, k))
    values[::97, 0] = 1e5
    values[::89, 1] = np.nan
    poses, ok = find_poses(held, values)
    assert not ok[::97].any()
    assert not ok[::89].any()
    assert 0.5 < ok.mean() < 0.98
    rows = np.concatenate([np.flatnonzero(ok)[::400], [0, BLOCK - 1, BLOCK, len(values) - 1]])
    for row in rows:
        alone, reached = find_poses(held, values[row : row + 1])
        assert reached[0] == ok[row]
        if ok[row]:
            assert np.abs(alone[0] - poses[row]).max() < 1e-9
