"""A nominal surface against moving tools: known scallops, gouges and what is certain about them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from verne_post.model.findings import InputError
from verne_post.model.part_setup import Cylinder, Wanted
from verne_post.part.bodies import build_pieces, measure_phi
from verne_post.part.bound import find_clear, find_limit
from verne_post.part.compare import (
    CLEAR,
    GOUGE,
    UNDECIDED,
    Cells,
    _make_rotation,
    choose_grid,
    compare,
    divide,
    is_inside,
    move_mesh,
)
from verne_post.part.motion import Motion, build_motion
from verne_post.part.stl import Mesh, build_mesh
from verne_post.part.sweep import find_nearest, load_accelerator

PATHS = [False] if load_accelerator() is None else [False, True]
LENGTH = 60.0
UPRIGHT = np.array([0.0, 0.0, 1.0])


def rectangle(low, high, turn=None, shift=(0, 0, 0)) -> Mesh:
    """A rectangle in z = 0, turned and shifted; its normal is up."""
    corner = np.array(
        [[low[0], low[1], 0], [high[0], low[1], 0], [high[0], high[1], 0], [low[0], high[1], 0]], dtype=float
    )
    corner = corner @ (np.eye(3) if turn is None else turn).T + shift
    return build_mesh("part.stl", corner[[[0, 1, 2], [0, 2, 3]]])


def tilt(degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])


def strips(shape, pitch: float, step: float = 1.0, height=lambda x, y: 0.0, x=(-10.0, 30.0), y=(-10.0, 20.0)) -> Motion:
    """An upright tool in strips along x; the source line of a row is that of its strip, from 10 on."""
    along = np.linspace(*x, round((x[1] - x[0]) / step) + 1)
    across = np.arange(y[0], y[1] + 1e-9, pitch)
    tip = np.array([[a, b, height(a, b)] for k, b in enumerate(across) for a in (along if k % 2 == 0 else along[::-1])])
    line = 10 + np.repeat(np.arange(len(across)), len(along))
    axis = np.tile(UPRIGHT, (len(tip), 1))
    return build_motion("tool 1", build_pieces(shape, LENGTH), tip, axis, line, np.ones(len(tip), bool))


def ball(radius: float):
    return (Cylinder("cutter", 2.0 * radius, 30.0, corner_radius=float(radius)),)


def flat(radius: float):
    return (Cylinder("cutter", 2.0 * radius, 30.0),)


@pytest.mark.parametrize("step", [1.0, 5.0])  # rows far apart lose nothing
@pytest.mark.parametrize(
    ("radius", "pitch", "along_normal", "distance"),
    [(4, 1.0, 0.031373, 0.031129), (4, 0.5, 0.007820, 0.007805), (3, 1.2, 0.060612, 0.059412)],
)
@pytest.mark.parametrize("accelerate", PATHS)
def test_scallops(radius, pitch, along_normal, distance, step, accelerate):
    motion = strips(ball(radius), pitch, step, x=(-10.0, 15.0), y=(-5 * pitch, 5 * pitch))
    mesh = rectangle((0, -pitch / 2), (4, pitch / 2))
    found = compare(mesh, (motion,), Wanted(grid=0.2), accelerate=accelerate)
    assert (found.state == CLEAR).all()
    top = np.array([[2.0, pitch / 2, 0.0]])
    assert find_nearest((motion,), top, 2.0, accelerate=accelerate).distance == pytest.approx(distance, abs=1e-6)
    traced = compare(mesh, (motion,), Wanted(grid=0.05, excess=0.001), accelerate=accelerate)
    # the middle of a cell lies beside the ridge by up to 0.05 / sqrt(2) mm; the trace ends within 1e-4
    slope = pitch / 2 / radius * 0.05
    assert along_normal - slope * 0.75 - 1e-4 < traced.deviation.max() < along_normal + 1e-6


@pytest.mark.parametrize("accelerate", PATHS)
def test_a_flat_cutter_on_a_tilted_plane(accelerate):
    """Upright, downhill, strips 4 mm apart: its edge leaves 0.072485 mm along the normal in the middle between two
    strips.
    """
    slope = np.tan(np.radians(10))
    motion = strips(flat(5), 4.0, 1.0, lambda x, _y: -slope * x + 5 * slope)
    c, s = np.cos(np.radians(10)), np.sin(np.radians(10))
    mesh = rectangle((0, -2.025), (0.5, 2.025), np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]))
    found = compare(mesh, (motion,), Wanted(grid=0.05, excess=0.01), accelerate=accelerate)
    assert (found.state == CLEAR).all()
    expected = (5 - np.sqrt(25 - 4)) * s
    assert expected == pytest.approx(0.072485, abs=1e-6)
    # the middle of a cell may lie beside the ridge by 0.035 mm, where a side falls by 2 / sqrt(21) sin(10 degrees)
    assert expected - 0.035 * 2 / np.sqrt(21) * s - 1e-4 < found.deviation.max() < expected + 1e-6


@pytest.mark.parametrize("accelerate", PATHS)
def test_a_flat_cutter_leaves_nothing_on_its_plane(accelerate):
    found = compare(rectangle((0, 0), (15, 8)), (strips(flat(5), 4.0),), Wanted(grid=0.5), accelerate=accelerate)
    assert (found.state == CLEAR).all()
    np.testing.assert_allclose(found.deviation, 0, atol=1e-12)


@pytest.mark.parametrize("accelerate", PATHS)
def test_a_drill_deep_in_the_part_has_its_depth_along_the_normal(accelerate):
    """The distance to the swept volume is no more than the radius of the drill: -1; the depth is 10."""
    tip = np.array([[0.03, 0.02, z] for z in np.linspace(5, -10, 16)])
    motion = build_motion(
        "tool 1", build_pieces(flat(1), LENGTH), tip, np.tile(UPRIGHT, (16, 1)), np.full(16, 7), np.ones(16, bool)
    )
    found = compare(rectangle((-4, -4), (4, 4)), (motion,), Wanted(grid=0.2, search=12.0), accelerate=accelerate)
    assert (found.state == GOUGE).all()
    on_its_axis = find_nearest((motion,), np.array([[0.03, 0.02, 0.0]]), 1.0, accelerate=accelerate)
    assert on_its_axis.distance == pytest.approx(-1.0, abs=1e-12)
    assert found.gouges.depth.max() == pytest.approx(10.0, abs=1e-4)
    assert np.nanmin(found.deviation) == pytest.approx(-10.0, abs=1e-4)


@pytest.mark.parametrize("accelerate", PATHS)
def test_a_dip_is_found_with_its_line(accelerate):
    def dip(x, y):
        return -0.1 if (x, y) == (15.0, 12.0) else 0.0

    motion = strips(ball(4), 1.0, 1.0, dip)
    found = compare(rectangle((5, 5), (20, 15)), (motion,), Wanted(grid=0.2), accelerate=accelerate)
    worst = found.gouges.depth.argmax()
    assert found.gouges.depth[worst] == pytest.approx(0.1, abs=0.002)
    np.testing.assert_allclose(found.gouges.place[worst], [15, 12, 0], atol=0.15)
    assert motion.line[found.gouges.nearest.row[worst]] == 10 + 22


@pytest.mark.parametrize("accelerate", PATHS)
def test_a_shift_shows_where_the_normal_faces_it(accelerate):
    for shift in np.eye(3) * 0.1:
        for turn in (np.eye(3), tilt(90)):  # a floor, and a wall along x that the side of the cutter makes
            normal = turn @ UPRIGHT
            start = np.array([-9.0, 2.0, -5.0]) + (4 * normal if turn[2, 2] < 0.5 else [0, 0, 5.0])
            tip = start + np.linspace(0, 24, 25)[:, None] * [1, 0, 0] + shift
            motion = build_motion(
                "tool 1",
                build_pieces(flat(4), LENGTH),
                tip,
                np.tile(UPRIGHT, (25, 1)),
                np.arange(25),
                np.ones(25, bool),
            )
            mesh = rectangle((0, 1), (4, 2), turn, (0, 2.0, 0) if turn[2, 2] < 0.5 else (0, 0, 0))
            found = compare(mesh, (motion,), Wanted(gouge=0.2, grid=0.5, excess=0.02), accelerate=accelerate)
            np.testing.assert_allclose(found.deviation, shift @ normal, atol=2e-4)


@pytest.mark.parametrize("accelerate", PATHS)
def test_a_flat_gouge_on_a_coarse_grid_is_never_clear(accelerate):
    """One pose of a flat cutter, any attitude, 0.05 deep: samples alone miss some."""
    pick = np.random.default_rng(16)
    missed_by_samples = 0
    for _case in range(15):
        axis = pick.normal(size=3)
        axis /= np.linalg.norm(axis)
        axis[2] = abs(axis[2])
        down = axis[2] * axis - UPRIGHT  # the lowest point of the rim
        lowest = 5 * down / np.linalg.norm(down)
        tip = np.array([*pick.uniform(-0.2, 0.2, 2), -0.05]) - lowest
        motion = build_motion(
            "tool 1", build_pieces(flat(5), LENGTH), tip[None], axis[None], np.zeros(1), np.zeros(1, bool)
        )
        found = compare(rectangle((-2, -2), (2, 2)), (motion,), Wanted(gouge=0.0499, grid=0.4), accelerate=accelerate)
        middle, _delta = found.cells.find_circles()
        missed_by_samples += not (measure_phi(motion.pieces, middle, tip, axis) < 0).any()
        assert (found.state != CLEAR).any()
        assert (found.deepest[found.state == UNDECIDED] > 0.0499).all()
    assert missed_by_samples


@pytest.mark.parametrize("shape", ["flat", "ball", "bull", "drill"])
@pytest.mark.parametrize("accelerate", PATHS)
def test_what_is_clear_is_clear_all_over_the_facet(shape, accelerate):
    shapes = {
        "flat": flat(4),
        "ball": ball(4),
        "bull": (Cylinder("cutter", 10.0, 30.0, corner_radius=1.5),),
        "drill": (Cylinder("cutter", 8.0, 30.0, point_angle=118.0),),
    }
    pick = np.random.default_rng(11)
    n = 120
    tip = np.cumsum(pick.normal(size=(n, 3)) * [0.2, 0.2, 0.03], axis=0)
    axis = np.cumsum(pick.normal(size=(n, 3)) * 0.004, axis=0) + UPRIGHT
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    motion = build_motion("tool 1", build_pieces(shapes[shape], LENGTH), tip, axis, np.arange(n), np.ones(n, bool))
    point = pick.uniform(tip.min(0) - [5, 5, 1], tip.max(0) + [5, 5, 4], (6000, 3))
    point = point[np.abs(find_nearest((motion,), point, 5.0).distance) < 0.2][:400]
    normal = pick.normal(size=point.shape)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    delta = pick.uniform(0.01, 0.2, len(point))
    clear = find_clear((motion,), point, normal, delta, 0.05, ("cutter",), accelerate=accelerate)
    crude = find_nearest((motion,), point, 5.0).distance - delta > find_limit(motion.pieces[0], 0.05)
    assert (clear & ~crude).mean() > 0.03  # convexity says more than the distance alone
    first = np.cross(normal, pick.normal(size=point.shape))
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(normal, first)
    for angle in np.linspace(0, 2 * np.pi, 12, endpoint=False):
        for share in (0.4, 0.7, 1.0):
            off = share * delta[:, None] * (np.cos(angle) * first + np.sin(angle) * second)
            assert (
                find_nearest((motion,), (point + off)[clear], 5.0).distance > find_limit(motion.pieces[0], 0.05)
            ).all()


@pytest.mark.skipif(len(PATHS) == 1, reason="numba is not installed")
def test_both_paths_decide_alike():
    motion = strips(flat(5), 4.0, 0.5, lambda x, y: -0.04 - 0.001 * x + 0.0005 * y)
    results = [compare(rectangle((0, 0), (15, 8)), (motion,), Wanted(grid=1.0), accelerate=how) for how in PATHS]
    assert (results[0].state == results[1].state).all()
    np.testing.assert_allclose(results[0].deviation, results[1].deviation, rtol=0, atol=2e-4)
    np.testing.assert_allclose(results[0].deepest, results[1].deepest, rtol=0, atol=1e-6)


def test_how_deep_a_gouge_reaches_into_a_tool():
    (sharp,), (round_one,), (point,) = (
        build_pieces(one, LENGTH) for one in (flat(5), ball(4), (Cylinder("cutter", 8.0, 30.0, point_angle=90.0),))
    )
    assert find_limit(sharp, 0.05) == pytest.approx(-0.05 * np.sqrt(0.5))
    assert find_limit(round_one, 0.05) == pytest.approx(-0.05)
    assert find_limit(point, 0.05) == pytest.approx(-0.05 * np.sqrt(0.5))
    assert (
        find_limit(build_pieces(flat(1), LENGTH)[0], 10.0) >= -0.5
    )  # a drill of 1 mm is never farther inside than that


@pytest.mark.parametrize("accelerate", PATHS)
def test_split_and_turned_meshes_say_the_same(accelerate):
    """Each facet in four, all of it turned together with the motion."""
    motion = strips(ball(4), 1.0, 1.0, lambda x, y: -0.003 * x)
    mesh = rectangle((0, 0), (8, 6))
    turn, shift = tilt(37), np.array([100.0, -30.0, 12.0])
    corner = divide(mesh, 3.0).corner @ turn.T + shift
    other = build_motion(
        "tool 1", motion.pieces, motion.tip @ turn.T + shift, motion.axis @ turn.T, motion.line, motion.linked
    )
    point = pick_points(mesh)
    first = find_nearest((motion,), point, 2.0, accelerate=accelerate).distance
    second = find_nearest((other,), point @ turn.T + shift, 2.0, accelerate=accelerate).distance
    np.testing.assert_allclose(first, second, atol=1e-9)
    one = compare(mesh, (motion,), Wanted(gouge=0.01), accelerate=accelerate)
    two = compare(build_mesh("part.stl", corner), (other,), Wanted(gouge=0.01), accelerate=accelerate)
    assert one.gouges.depth.max() == pytest.approx(two.gouges.depth.max(), abs=1e-3)  # samples lie elsewhere


def pick_points(mesh: Mesh) -> np.ndarray:
    return divide(mesh, 1.0).find_circles()[0]


def test_the_holder_counts_as_a_gouge():
    shape = (Cylinder("cutter", 8.0, 10.0), Cylinder("holder", 40.0))
    motion = build_motion(
        "tool 1",
        build_pieces(shape, LENGTH),
        np.array([[0.0, 15, -10.5]]),
        UPRIGHT[None],
        np.array([4]),
        np.zeros(1, bool),
    )
    found = compare(rectangle((-5, -5), (5, 5)), (motion,), Wanted(grid=1.0))
    assert found.gouges.depth.max() == pytest.approx(0.5, abs=1e-4)
    pieces = {motion.pieces[k].part for k in found.gouges.nearest.piece}
    assert pieces == {"holder"}


def test_where_no_cutter_comes_nothing_is_said():
    found = compare(rectangle((0, 0), (5, 5), shift=(200, 0, 0)), (strips(ball(4), 1.0),), Wanted())
    assert np.isnan(found.deviation).all()
    assert (found.state == CLEAR).all()


def test_a_fitted_datum_takes_a_shift_away():
    motion = strips(ball(4), 0.5, 1.0, lambda _x, _y: -0.08)
    found = compare(rectangle((0, 0), (15, 8)), (motion,), Wanted())
    assert found.gouges.depth.max() == pytest.approx(0.08, abs=1e-3)
    again = compare(move_mesh(found), (motion,), Wanted())
    assert (again.state == CLEAR).all()
    assert np.abs(again.deviation).max() < 0.01  # the scallops of 0.0078 mm stay


def test_a_tool_that_begins_inside_the_part():
    cube = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], dtype=float) * 10
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    mesh = build_mesh("cube.stl", np.array([cube[[a, *pair]] for a, b, c, d in quads for pair in ((b, c), (c, d))]))
    assert is_inside(mesh, np.array([[5, 5, 5], [5, 5, 11], [-1, 5, 5], [0.1, 9.9, 0.1]])).tolist() == [
        True,
        False,
        False,
        True,
    ]


def test_a_grid_is_chosen_where_none_is_given():
    """The finest of one digit: 0.2 mm has 1.6 million places on a square of 250 mm, and 0.3 mm 0.7 million."""
    large, small = (rectangle((0, 0), (side, side)) for side in (250.0, 15.0))
    assert [choose_grid(small, None), choose_grid(large, None), choose_grid(large, 0.4)] == [0.2, 0.3, 0.4]
    with pytest.raises(InputError, match=r"a grid of 0.2 mm has too many places; give 0.3"):
        choose_grid(large, 0.2)


def test_a_grid_that_is_too_fine_is_refused_with_one_that_will_do():
    with pytest.raises(InputError, match=r"part.stl: a grid of 0.001 mm has too many places; give 0.0"):
        divide(rectangle((0, 0), (15, 8)), 0.001)


def test_circles_about_facets_are_the_least_ones():
    """Obtuse and right triangles: about the longest side, wherever it stands; acute ones: through the three corners."""
    wide = np.array([[0.0, 0, 0], [6, 0, 0], [2, 1, 0]])
    right = np.array([[0.0, 0, 0], [0, 8, 0], [0, 0, 6]])
    acute = np.array([[0.0, 0, 1], [4, 0, 1], [2, 3, 1]])
    for corner, middle, radius in ((wide, (3, 0, 0), 3.0), (right, (0, 4, 3), 5.0), (acute, (2, 5 / 6, 1), 13 / 6)):
        turned = np.stack([np.roll(corner, k, axis=0) for k in range(3)])
        found = Cells(turned, np.arange(3)).find_circles()
        assert found[0] == pytest.approx(np.tile(middle, (3, 1)), abs=1e-12)
        assert found[1] == pytest.approx([radius] * 3, rel=1e-6)


@pytest.mark.parametrize("angle", [30.0, 60.0, 90.0, 118.0, 140.0])
def test_the_point_of_a_drill_is_no_deeper_than_half_its_angle_says(angle):
    """It goes 0.05 mm into a flat face, at every lean: somewhere there phi is as far below 0 as the limit says."""
    (piece,) = build_pieces((Cylinder("cutter", 8, 30, point_angle=angle),), 30.0)
    limit, depth = find_limit(piece, 0.05), 0.05
    side = np.linspace(-0.2, 0.2, 401)
    face = np.stack([*np.meshgrid(side, side, indexing="ij"), np.zeros((401, 401))], axis=-1).reshape(-1, 3)
    # upright, and leaning until the flank lies on the face, which it may not pass
    for lean in np.linspace(0.0, 0.8 * np.radians(90 - angle / 2), 5):
        axis = np.array([np.sin(lean), 0.0, np.cos(lean)])
        least = measure_phi((piece,), face, np.array([0.0, 0.0, -depth]), axis).min()
        assert least <= limit + 1e-3  # places stand 0.001 mm apart
    upright = measure_phi((piece,), face, np.array([0.0, 0.0, -depth]), np.array([0.0, 0.0, 1.0])).min()
    assert upright == pytest.approx(-depth * np.sin(np.radians(angle / 2)), abs=1e-4)


def test_the_rotation_of_the_best_fit_is_one():
    """To second order too: a part that was clamped 3 degrees askew is turned back, not squeezed."""
    for vector in np.random.default_rng(4).normal(size=(20, 3)):
        assert _make_rotation(vector) == pytest.approx(Rotation.from_rotvec(vector).as_matrix(), abs=1e-14)
