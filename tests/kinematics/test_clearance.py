"""Distances between bodies against brute force, and verdicts along whole motions against dense sampling."""

import numpy as np
import pytest

from verne_post.app.assemble import assemble
from verne_post.app.constraints import check_program
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.segments import measure_between_segments, measure_point_to_segment
from verne_post.kinematics.checks.bodies import _bound_flat_end_to_table, _measure_to_table
from verne_post.kinematics.checks.clearance import check_clearance, find_straight
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.model.poses import Platform, Pose
from verne_post.model.toolpath import SegmentKind
from verne_post.toolpath.contour_pose import find_contour_pose

BODIES = {
    "rods.diameter_mm": 40.0, "rods.leg1_slider_x": 480.0, "rods.leg23_slider_x": -400.0, "rods.leg23_spacing": 120.0,
    "rods.slider_cone_deg": 60.0, "rods.platform_cone_deg": 60.0, "rods.cone_centre": [0.0, 0.0, 1400.0],
    "clearance.minimum_mm": 1.0, "clearance.spindle_diameter_mm": 90.0, "clearance.spindle_top_mm": 200.0,
    "clearance.tool_diameter_mm": 20.0, "provenance.rods": "assumed", "provenance.clearance": "assumed",
}  # fmt: skip
#: A helix-like move with much rotation: nearest approaches lie inside it.
SOURCE = b"G21 G90 G94\nG0 X60 Y-40 Z40 A-40 C-60\nG1 X-70 Y50 Z55 A50 C100 F4000\nM2\n"


@pytest.fixture(scope="module")
def bodied(machine_with):
    """Function: the VERNE with bodies, single keys changed."""
    return lambda changes=None: machine_with({**BODIES, **(changes or {})})


def program_on(machine, source=SOURCE):
    return assemble(source, machine, Options(tool_length=120.0))


def dense_margins(program, n=20001):
    """Margins along the last element by plain sampling."""
    joints = program.build_joint_path()
    last = len(program.contour) - 1
    element = np.full(n, last)
    solved = joints.solve(element, np.linspace(0.0, 1.0, n))
    return program.machine.clearance.evaluate(joints.place_bodies(element, solved))[0]


def tilted(position, alpha):
    """A platform that tilts about x alone."""
    return Platform(position, np.stack([alpha, 0 * alpha, 0 * alpha], axis=-1))


def pose_of(position, alpha, rho, tip, angles, tool):
    """A pose of the machine's own tool and platform; the clearances do not read the table's joints."""
    q = np.concatenate([rho, angles], axis=-1)
    return Pose(q, tilted(position, alpha), tip, find_axis_of_angles(angles[:, 0], angles[:, 1]), tool)


# --- distances ------------------------------------------------------------------------------------


def brute_distance(a0, a1, b0, b1, n=401):
    s = np.linspace(0.0, 1.0, n)[:, None]
    a, b = a0 + s * (a1 - a0), b0 + s * (b1 - b0)
    return np.sqrt(((a[:, None] - b[None]) ** 2).sum(-1).min())


def test_segment_distance_against_brute_force():
    rng = np.random.default_rng(1)
    ends = rng.uniform(-1, 1, (4, 60, 3))
    ends[1, :5] = ends[0, :5]  # points
    ends[3, 5:10] = ends[2, 5:10] + 0.5 * (ends[1, 5:10] - ends[0, 5:10])  # parallel
    ends[:, 10:15, 2] = 0.0  # crossing in a plane
    found = measure_between_segments(*ends)
    for k in range(60):
        brute = brute_distance(*ends[:, k])
        assert found[k] <= brute + 1e-12
        assert found[k] > brute - 0.02  # the brute grid is 0.009 wide


def test_segment_distance_of_known_pairs():
    o, x, y = np.zeros((1, 3)), np.array([[1.0, 0, 0]]), np.array([[0, 1.0, 0]])
    up = np.array([[0, 0, 1.0]])
    assert measure_between_segments(o - x, x, up - y, up + y) == pytest.approx(1.0)
    assert measure_between_segments(o, x, 3 * x + up, 4 * x + up) == pytest.approx(np.sqrt(5.0))
    assert measure_point_to_segment(2 * x, o, x) == pytest.approx(1.0)
    assert measure_between_segments(o, o, x, x) == pytest.approx(1.0)


def test_distance_from_the_table_against_brute_force():
    rng = np.random.default_rng(2)
    start, end = rng.uniform(-400, 400, (2, 200, 3))
    start[:, 2] = np.abs(start[:, 2])
    found = _measure_to_table(start, end, 250.0)
    s = np.linspace(0.0, 1.0, 4001)[:, None]
    for k in range(200):
        p = start[k] + s * (end[k] - start[k])
        brute = np.hypot(np.maximum(np.hypot(p[:, 0], p[:, 1]) - 250.0, 0.0), np.maximum(p[:, 2], 0.0)).min()
        assert brute - 0.3 < found[k] <= brute + 1e-9


def test_a_flat_end_touches_with_its_rim():
    """A tool of radius 10 tilted by 30 degrees: its lowest rim point is 5 mm below the tip."""
    axis = np.array([[0.0, 0.5, np.sqrt(0.75)]])
    assert _bound_flat_end_to_table(np.array([[0.0, 0.0, 7.0]]), axis, 10.0, 250.0) == pytest.approx(2.0)
    assert _bound_flat_end_to_table(np.array([[0.0, 0.0, 3.0]]), axis, 10.0, 250.0) == pytest.approx(-2.0)
    assert _bound_flat_end_to_table(np.array([[300.0, 0.0, -5.0]]), axis, 10.0, 250.0) == pytest.approx(40.0)


# --- the machine's bodies ---------------------------------------------------------------------------


def test_rods_have_their_lengths_and_parallelograms_stay_parallel(bodied):
    machine = bodied()
    rng = np.random.default_rng(3)
    position = np.stack([rng.uniform(-200, 200, 50), rng.uniform(-200, 200, 50), rng.uniform(900, 1400, 50)], axis=-1)
    rho, alpha, ok = machine.module.inverse(position)
    assert ok.all()
    start, end = machine.clearance.module.find_rod_ends(rho, tilted(position, alpha))
    lengths = np.linalg.norm(end - start, axis=-1)
    assert np.abs(lengths - [850, 850, 950, 950, 950, 950]).max() < 1e-9
    assert start[:, :2, 0] == pytest.approx(480.0, abs=1e-12)  # leg I hangs at d1
    assert start[:, :2, 1] == pytest.approx(np.tile([80.0, -80.0], (50, 1)))
    assert start[:, [2, 4], 2] == pytest.approx(rho[:, 1:])
    for a, b in ((2, 3), (4, 5)):
        assert np.abs((end - start)[:, a] - (end - start)[:, b]).max() < 1e-9
        assert start[:, a, 0] - start[:, b, 0] == pytest.approx(120.0)


def test_clearances_of_many_poses_against_brute_force(bodied):
    """10^4 random poses; the reference samples each capsule's axis and takes the smallest of all distances."""
    machine = bodied()
    rng = np.random.default_rng(4)
    n = 10_000
    tip = np.stack([rng.uniform(-150, 150, n), rng.uniform(-150, 150, n), rng.uniform(0, 150, n)], axis=-1)
    angles = np.stack([rng.uniform(-1.5, 1.5, n), rng.uniform(-3, 3, n)], axis=-1)
    tool = np.full(n, 120.0)
    q, platform, ok = machine.five_axis.solve(tip, angles, tool)
    position, alpha = platform.position, platform.alpha
    assert ok.all()
    margins, _points = machine.clearance.evaluate(pose_of(position, alpha, q[:, :3], tip, angles, tool))
    names = [margin.name for margin in machine.clearance.names]
    start, end = machine.clearance.module.find_rod_ends(q[:, :3], platform)
    share = np.linspace(0.0, 1.0, 17)[:, None]
    tilt = np.stack([np.zeros(n), -np.sin(alpha), np.cos(alpha)], axis=-1)
    top = position - 200.0 * tilt

    def between(a0, a1, b0, b1):
        a, b = a0[:, None] + share * (a1 - a0)[:, None], b0[:, None] + share * (b1 - b0)[:, None]
        return np.sqrt(((a[:, :, None] - b[:, None]) ** 2).sum(-1).min(axis=(1, 2)))

    rods = {"I": (0, 1), "II": (2, 3), "III": (4, 5)}
    for a, b in (("I", "II"), ("II", "III")):
        brute = np.min(
            [between(start[:, i], end[:, i], start[:, j], end[:, j]) for i in rods[a] for j in rods[b]], axis=0
        )
        found = margins[:, names.index(f"distance of the rods of legs {a} and {b}")] + 40.0
        # sampling sees too much by at most the square of half a step over twice the distance, and half a step at a
        # touch
        assert (found <= brute + 1e-9).all()
        assert (brute - found).max() < 30.0
        assert np.median(brute - found) < 1.0
    brute = np.min([between(start[:, i], end[:, i], position, top) for i in (0, 1)], axis=0)
    found = margins[:, names.index("distance of leg I from the spindle")] + 20.0 + 45.0
    assert (found <= brute + 1e-9).all()
    assert (brute - found).max() < 30.0


@pytest.mark.parametrize("tilt", [0.0, 30.0])
@pytest.mark.parametrize("y", [0.0, 200.0])  # where the platform is tilted, too
def test_cones_measure_the_angle_from_the_middle(bodied, tilt, y):
    machine = bodied({"rods.cone_centre": [0.0, y, 1400.0]})
    centre = np.array([[0.0, y, 1400.0]])
    rho, alpha, _ok = machine.module.inverse(centre)
    alpha_centre = alpha
    tool, angles = np.array([120.0]), np.array([[np.radians(tilt), 0.0]])
    margins, _p = machine.clearance.evaluate(pose_of(centre, alpha, rho, np.zeros((1, 3)), angles, tool))
    cones = [k for k, margin in enumerate(machine.clearance.names) if margin.code == "VP214"]
    assert margins[0, cones] == pytest.approx(60.0, abs=1e-9)
    moved = centre + [0.0, 50.0, 0.0]
    rho, alpha, _ok = machine.module.inverse(moved)
    margins, _p = machine.clearance.evaluate(pose_of(moved, alpha, rho, np.zeros((1, 3)), angles, tool))
    start, end = machine.clearance.module.find_rod_ends(rho, tilted(moved, alpha))
    start0, end0 = machine.clearance.module.find_rod_ends(
        machine.module.inverse(centre)[0], tilted(centre, alpha_centre)
    )
    turned = [
        np.degrees(np.arccos(((end - start)[0, k] @ (end0 - start0)[0, k]) / np.linalg.norm((end - start)[0, k]) ** 2))
        for k in range(6)
    ]
    expected = [60.0 - max(turned[0], turned[1]), 60.0 - turned[2], 60.0 - turned[4]]
    assert margins[0, cones[:3]] == pytest.approx(expected, abs=1e-6)


# --- whole motions ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def inside(bodied):
    """Checks whose smallest margin lies well inside the motion: (index, smallest)."""
    margins = dense_margins(program_on(bodied()))
    n = len(margins)
    where = margins.argmin(axis=0)
    return [(k, float(margins[where[k], k])) for k in range(margins.shape[1]) if 0.02 * n < where[k] < 0.98 * n]


#: Motions along which a distance is smallest well inside, and varies by more than a millimetre.
INSIDE = {
    "distance of the two rods of leg I": b"G0 X-147 Y-45 Z44 A45 C-15\nG1 X-167 Y171 Z64 A-46 C-70 F1000\nM2\n",
    "distance of the spindle from the table": b"G0 X-46 Y24 Z63 A-30 C-18\nG1 X179 Y60 Z61 A-52 C-81 F1000\nM2\n",
}


@pytest.mark.parametrize("name", INSIDE)
def test_a_touch_inside_a_motion_is_found_by_0_01_mm_and_none_is_invented(bodied, name):
    source = b"G21 G90 G94\n" + INSIDE[name]
    machine = bodied()
    index = [margin.name for margin in machine.clearance.names].index(name)
    margin = dense_margins(program_on(machine, source))[:, index]
    smallest, where = float(margin.min()), int(margin.argmin())
    assert 0.02 * len(margin) < where < 0.98 * len(margin)
    assert np.ptp(margin) > 1.0
    for excess in (0.01, -0.01):
        machine = bodied({"clearance.minimum_mm": smallest + excess})
        found = check_clearance(program_on(machine, source).build_joint_path(), machine.clearance)
        mine = [item for item in found if item.message.startswith(name + " ") and item.line == 3]
        assert len(mine) == (1 if excess > 0 else 0)
        for item in mine:
            assert (item.code, item.severity, item.unit) == (machine.clearance.names[index].code, "error", "mm")
            assert item.value == pytest.approx(smallest, abs=1e-3)
            assert item.limit == pytest.approx(smallest + excess)


def test_a_cone_left_inside_a_motion_is_found(bodied, inside):
    names = bodied().clearance.names
    cones = [(k, low) for k, low in inside if names[k].unit == "deg"]
    assert cones
    for k, smallest in cones:
        key = "rods.slider_cone_deg" if "slider" in names[k].name else "rods.platform_cone_deg"
        for excess, count in ((1e-3, 1), (-1e-3, 0)):
            machine = bodied({key: 60.0 - smallest - excess})
            found = check_clearance(program_on(machine).build_joint_path(), machine.clearance)
            assert len([item for item in found if item.message.startswith(names[k].name + " ")]) == count


def test_clearances_are_part_of_the_verdict_on_a_program(bodied):
    machine = bodied({"clearance.minimum_mm": 500.0})
    codes = {item.code for item in check_program(program_on(machine))[1]}
    assert {"VP211", "VP212", "VP213"} <= codes


# --- the machine file -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"rods.diameter_mm": -1.0}, ["rods.diameter_mm", "-1.0", "above 0"]),
        ({"rods.weight": 1.0}, ["rods.weight", "not a key"]),
        ({"clearance.minimum_mm": "wide"}, ["clearance.minimum_mm", "number"]),
        ({"rods.cone_centre": None}, ["cone_centre", "belong together"]),
        ({"provenance.rods": None}, ["provenance.rods", "missing"]),
    ],
)
def test_mistakes_name_key_value_and_bound(bodied, changes, words):
    with pytest.raises(InputError) as caught:
        bodied(changes)
    text = "; ".join(item.message for item in caught.value.findings)
    for word in words:
        assert word in text


def test_only_what_goes_straight_without_turning_is_bound_as_convex(machine):
    """Lines that keep the tool's direction; not arcs, not lines with A or C, not blended corners, not curves."""
    source = (
        b"G21 G90 G17 G64 P0.05 F3000\nG0 X0 Y0 Z60 A0 C0\n"  # line 2
        b"G1 X10\nX10 Y10\nG3 X0 Y20 I-10 J0\nG1 X-10 A5\nX-20\nX-30 C9\nX-40\nM2\n"
    )
    options = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 20.0))})
    joints = assemble(source, machine, options).build_joint_path()
    straight = find_straight(joints)
    contour, path = joints.contour, joints.contour.path
    assert set(contour.find_lines()[straight].tolist()) <= {3, 4, 7, 9}
    assert straight[contour.find_lines() == 4].any()
    # by the poses themselves: the middle of a straight element is the mean of its ends, and so is its tool
    every = np.arange(len(contour))
    at = [find_contour_pose(contour, every, np.full(len(every), w)) for w in (0.0, 0.5, 1.0)]
    bent = np.linalg.norm(at[1][0] - 0.5 * (at[0][0] + at[2][0]), axis=1)
    turned = np.abs(at[2][1] - at[0][1]).max(axis=1)
    assert (bent[straight] < 1e-9).all()
    assert (turned[straight] < 1e-12).all()
    assert ((bent > 1e-6) | (turned > 1e-9))[~straight & (path.kind[contour.segment] == SegmentKind.LINE)].any()
