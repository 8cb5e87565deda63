"""The least distance of points from a moving tool: both paths agree with poses 64 times as dense, and with answers by
hand.
"""

import numpy as np
import pytest

from verne_post.model.part_setup import Cylinder
from verne_post.part.bodies import build_pieces, measure_phi
from verne_post.part.motion import Motion, build_motion
from verne_post.part.sweep import find_nearest, load_accelerator, look_between

LENGTH = 60.0
SHAPES = {
    "ball": (Cylinder("cutter", 8, 30, corner_radius=4),),
    "flat": (Cylinder("cutter", 8, 30),),
    "bull": (Cylinder("cutter", 10, 30, corner_radius=1.5),),
    "drill and holder": (Cylinder("cutter", 8, 30, point_angle=118), Cylinder("holder", 40)),
    "tapered": (Cylinder("cutter", 6, 30, corner_radius=3, taper=5),),
    "form": (Cylinder("cutter", 16, profile=((3, 0), (5, 2), (5, 6), (2, 9), (2, 12), (8, 15), (8, 20), (4, 20),
                                             (4, 30))),),
}  # fmt: skip
#: Without numba the compiled path is not there; the other one is always tested.
PATHS = [False] if load_accelerator() is None else [False, True]


def wander(seed: int, n: int = 300, step: float = 0.1, turn: float = 0.002, shape: str = "ball") -> Motion:
    """A tool that wanders about, as in rows a millisecond apart; in the middle another tool comes between."""
    pick = np.random.default_rng(seed)
    tip = np.cumsum(pick.normal(size=(n, 3)) * [step, step, step / 4], axis=0)
    axis = np.cumsum(pick.normal(size=(n, 3)) * turn, axis=0) + [0, 0, 1]
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    linked = np.ones(n, dtype=bool)
    linked[n // 2] = False
    return build_motion("tool 1", build_pieces(SHAPES[shape], LENGTH), tip, axis, np.arange(n), linked)


def points_near(motion: Motion, seed: int, n: int) -> np.ndarray:
    pick = np.random.default_rng(seed)
    return pick.uniform(motion.tip.min(0) - [9, 9, 3], motion.tip.max(0) + [9, 9, 40], (n, 3))


def brute_force(motion: Motion, point: np.ndarray, cap: float) -> np.ndarray:
    """Poses 64 times as dense, each with all points."""
    share = np.arange(64) / 64
    tips, axes = [motion.tip], [motion.axis]
    for k in np.flatnonzero(motion.linked):
        tips.append(motion.tip[k] + share[:, None] * (motion.tip[k + 1] - motion.tip[k]))
        axes.append(motion.axis[k] + share[:, None] * (motion.axis[k + 1] - motion.axis[k]))
    tip, axis = np.vstack(tips), np.vstack(axes)
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    return np.array([min(cap, measure_phi(motion.pieces, one, tip, axis).min()) for one in point])


@pytest.mark.parametrize("accelerate", PATHS)
@pytest.mark.parametrize("shape", SHAPES)
def test_distances_are_those_of_poses_64_times_as_dense(shape, accelerate):
    motion = wander(3, shape=shape)
    point = points_near(motion, 4, 150)
    found = find_nearest((motion,), point, 30.0, accelerate=accelerate)
    exact = brute_force(motion, point, 30.0)
    # between two dense poses the tool moves by 0.3 / 64 mm at most: they miss a sharp edge by half of that
    assert (found.distance <= exact + motion.bow).all()
    assert (exact - found.distance).max() < 0.5 * np.linalg.norm(np.diff(motion.tip, axis=0), axis=1).max() / 64 + 1e-5
    assert (found.row >= 0).sum() == (found.distance < 30.0).sum()


@pytest.mark.skipif(len(PATHS) == 1, reason="numba is not installed")
@pytest.mark.parametrize("shape", SHAPES)
def test_the_compiled_path_has_the_same_answers(shape):
    motion = wander(5, n=2000, shape=shape)
    point = points_near(motion, 6, 2000)
    plain, fast = (find_nearest((motion,), point, 8.0, accelerate=how) for how in PATHS)
    np.testing.assert_allclose(fast.distance, plain.distance, rtol=0, atol=2e-9)  # each is searched to 1e-9
    same = (fast.row == plain.row) & (fast.piece == plain.piece)
    assert same.mean() > 0.999  # two rows may be equally near


@pytest.mark.parametrize("accelerate", PATHS)
def test_rows_far_apart_lose_nothing(accelerate):
    """A ball of 4 mm on rows 5 mm apart, along a plane: the scallop between two strips 1 mm apart."""
    x = np.arange(0, 41, 5.0)
    tip = np.array([[one, y, 0.0] for y in (0.0, 1.0) for one in (x if y == 0 else x[::-1])])
    motion = build_motion(
        "tool 1",
        build_pieces(SHAPES["ball"], LENGTH),
        tip,
        np.tile([0, 0, 1.0], (18, 1)),
        np.zeros(18),
        np.ones(18, bool),
    )
    across = np.linspace(0, 0.5, 6)
    point = np.array([[at, y, 0.0] for at in np.linspace(2, 38, 37) for y in across])
    found = find_nearest((motion,), point, 2.0, accelerate=accelerate)
    np.testing.assert_allclose(found.distance, np.tile(np.hypot(4, across) - 4, 37), rtol=0, atol=1e-9)


@pytest.mark.parametrize("accelerate", PATHS)
def test_another_tool_between_two_rows_splits_the_motion(accelerate):
    tip, axis = np.array([[0.0, 0, 0], [40.0, 0, 0]]), np.tile([0, 0, 1.0], (2, 1))
    pieces = build_pieces(SHAPES["flat"], LENGTH)
    middle = np.array([[20.0, 0.0, 5.0]])
    for linked, distance in ((True, -4.0), (False, 16.0)):
        motion = build_motion("tool 1", pieces, tip, axis, np.zeros(2), np.array([linked, False]))
        assert find_nearest((motion,), middle, 50.0, accelerate=accelerate).distance == pytest.approx(distance)


@pytest.mark.parametrize("accelerate", PATHS)
def test_a_cap_leaves_no_row(accelerate):
    found = find_nearest((wander(7),), np.array([[1000.0, 0, 0]]), 3.0, accelerate=accelerate)
    assert (found.distance.tolist(), found.row.tolist(), found.motion.tolist()) == ([3.0], [-1], [-1])


def test_parts_are_looked_at_apart():
    motion = wander(8, shape="drill and holder")
    point = motion.tip[:1] + 40 * motion.axis[:1] + [15.0, 0, 0]
    assert find_nearest((motion,), point, 50.0, ("holder",)).distance[0] < -4
    assert find_nearest((motion,), point, 50.0, ("cutter",)).distance[0] > 8


@pytest.mark.parametrize("turn", [0.7, 0.2])
@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_the_axis_turns_as_fast_as_its_derivative_says(turn: float, share: float) -> None:
    """Rows up to 40 degrees apart, and rows that lean: the unit axis slows down towards both ends."""
    axis = np.array([[np.sin(-turn / 2), 0.1, np.cos(turn / 2)], [np.sin(turn / 2), -0.2, np.cos(turn / 2)]])
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    tip, linked = np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]), np.array([True, False])
    motion = build_motion("tool 1", build_pieces(SHAPES["ball"], LENGTH), tip, axis, np.arange(2), linked)
    shares, many = share + 1e-6 * np.array([-1.0, 0.0, 1.0]), np.ones((3, 1))
    seen, speed = look_between(
        motion,
        motion.pieces[0],
        many * [5.0, 5.0, 5.0],
        np.zeros(3, dtype=int),
        many * np.diff(tip, axis=0),
        many * np.diff(axis, axis=0),
        shares,
    )
    assert speed[1] == pytest.approx((seen.u[2] - seen.u[0]) / 2e-6, abs=1e-9)
