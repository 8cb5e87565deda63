"""Moves -> segments in the table frame: geometry, feed times, what joins to a section, tool length changes."""

import math

import numpy as np
import pytest

from verne_post.app.assemble import assemble
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.toolpath.evaluate import evaluate_pose

from ..builders import axis_of

#: Positions in mm and angles in rad: the transformations cost 1e-13.
EXACT = 1e-9
HEAD = "G21 G90 G94 G17 G61 F1200\n"
#: Opening rapid of no length: the program starts where it first names its axes.
START = "G0 X40 Y10 Z30 A20 C-15\n"
START_POSE = (40.0, 10.0, 30.0, math.radians(20.0), math.radians(-15.0))


@pytest.fixture
def path_of(machine):
    """Function: the tool path of a program's body, with a tool of 50 mm unless options say otherwise."""

    def build(body: str, head: str = HEAD + START, **options) -> ToolPath:
        options.setdefault("tool_length", 50.0)
        return assemble(f"{head}{body}\nM2\n".encode(), machine, Options(**options)).path

    return build


def at(path, segment, u):
    """Tip and angles of one segment at parameters u, (n, 5)."""
    u = np.asarray(u, dtype=float)
    return np.concatenate(evaluate_pose(path, np.full(len(u), segment), u), axis=-1)


# --- straight segments ------------------------------------------------------------------------------


def test_a_straight_move_sections_from_pose_to_pose(path_of):
    path = path_of("G1 X70 Y-30 Z10 A50 C75")
    assert len(path) == 1
    assert (path.line[0], path.kind[0], path.arc[0], path.joint[0], path.section[0]) == (3, SegmentKind.LINE, -1, -1, 0)
    end = [70.0, -30.0, 10.0, math.radians(50.0), math.radians(75.0)]
    assert path.start[0] == pytest.approx(START_POSE, abs=EXACT)
    assert path.end[0] == pytest.approx(end, abs=EXACT)
    assert path.first_pose == pytest.approx(START_POSE, abs=EXACT)
    assert path.tool_length[0] == path.first_tool_length == 50.0
    u = np.linspace(0.0, 1.0, 7)
    expected = np.array(START_POSE) + u[:, None] * (np.array(end) - START_POSE)
    assert at(path, 0, u) == pytest.approx(expected, abs=EXACT)


def test_segments_meet_exactly(path_of):
    path = path_of("G1 X70 Y-30 Z10 A50 C75\nG0 X0 Y0\nG2 X10 Y-10 I10 J0\nG1 C90")
    assert len(path) == 4
    np.testing.assert_array_equal(path.start[1:], path.end[:-1])
    for segment in range(4):
        assert at(path, segment, [0.0, 1.0]) == pytest.approx(
            np.stack([path.start[segment], path.end[segment]]), abs=EXACT
        )


def test_c_stays_unwrapped_as_programmed(path_of):
    path = path_of("G1 C345\nG1 C1000\nG1 C-800")
    assert np.degrees(path.end[:, 4]) == pytest.approx([345.0, 1000.0, -800.0])


def test_work_offset_and_turned_part(path_of):
    """p_table = o + Rz(c) p_work, C = C_programmed - c."""
    path = path_of("G1 X70 Y-30 Z10 A50 C75", wcs={1: WorkOffset((100.0, -20.0, 7.0), 30.0)})
    c, s = math.cos(math.radians(30.0)), math.sin(math.radians(30.0))
    for found, (x, y, z, a, rotary) in ((path.start[0], (40, 10, 30, 20, -15)), (path.end[0], (70, -30, 10, 50, 75))):
        expected = [100 + c * x - s * y, -20 + s * x + c * y, 7 + z, math.radians(a), math.radians(rotary - 30)]
        assert found == pytest.approx(expected, abs=EXACT)


def test_another_work_system_changes_where_words_lead(path_of):
    wcs = {1: WorkOffset((0.0, 0.0, 0.0)), 2: WorkOffset((10.0, 20.0, 30.0), 90.0)}
    path = path_of("G1 X50\nG55 G1 X5 Y6 Z7\nG54 G1 X50 Y6 Z7", wcs=wcs)
    assert path.end[0, :3] == pytest.approx([50.0, 10.0, 30.0], abs=EXACT)
    assert path.end[1, :3] == pytest.approx([10.0 - 6.0, 20.0 + 5.0, 37.0], abs=EXACT)
    assert path.start[2] == pytest.approx(path.end[1], abs=0)
    assert path.end[2, :3] == pytest.approx([50.0, 6.0, 7.0], abs=EXACT)


def test_moves_of_no_length_are_dropped(path_of):
    path = path_of("G1 X40\nG1 X41\nG1 X41 Y10 Z30\nG0 X41 A20\nF500\nG1 X42")
    assert path.line.tolist() == [4, 8]
    np.testing.assert_array_equal(path.start[1], path.end[0])


def test_dropping_tiny_moves_leaves_no_gap(path_of):
    """1e-7 mm is no move; what was dropped is made up by the next segment."""
    path = path_of("G1 X41\n" + "".join(f"G1 X{41 + 1e-7 * k:.7f}\n" for k in range(1, 9)) + "G1 X42")
    assert path.line.tolist() == [3, 12]
    np.testing.assert_array_equal(path.start[1], path.end[0])
    assert path.end[1, 0] == pytest.approx(42.0, abs=EXACT)


def test_a_small_move_is_a_move(path_of):
    path = path_of("G1 X40.00001\nG1 A20.000001\nG1 C-15.000001")
    assert path.line.tolist() == [3, 4, 5]


# --- arcs -----------------------------------------------------------------------------------------

#: plane word, axes (first, second, normal) in the order in which counter-clockwise turns, centre words
PLANES = {"G17": ("XY", "Z", "IJ"), "G18": ("ZX", "Y", "KI"), "G19": ("YZ", "X", "JK")}


@pytest.mark.parametrize("turned", [0.0, 35.0], ids=["part straight", "part turned"])
@pytest.mark.parametrize("lift", [0.0, 12.0], ids=["flat", "helix"])
@pytest.mark.parametrize("turns", [1, 3])
@pytest.mark.parametrize("code", ["G2", "G3"])
@pytest.mark.parametrize("plane", PLANES)
def test_arcs_in_every_plane(path_of, plane, code, turns, lift, turned):
    """Points of the arc against the circle written out in program coordinates and then carried to the table."""
    (first, second), normal, (i_word, j_word) = PLANES[plane]
    radius, begin = 25.0, math.radians(30.0)
    sweep = math.radians(110.0) + 2 * math.pi * (turns - 1)
    if code == "G2":
        sweep = -sweep
    start = {"X": 40.0, "Y": 10.0, "Z": 30.0}
    center = {first: start[first] - radius * math.cos(begin), second: start[second] - radius * math.sin(begin)}
    end = {
        first: center[first] + radius * math.cos(begin + sweep),
        second: center[second] + radius * math.sin(begin + sweep),
        normal: start[normal] + lift,
    }
    words = " ".join(f"{letter}{value:.10f}" for letter, value in end.items())
    to_center = f"{i_word}{center[first] - start[first]:.10f} {j_word}{center[second] - start[second]:.10f}"
    body = f"{plane} {code} {words} {to_center} P{turns} A20 C25"
    path = path_of(body, wcs={1: WorkOffset((5.0, -6.0, 7.0), turned)})
    assert (len(path), path.kind[0], path.arc[0]) == (1, SegmentKind.ARC, 0)

    u = np.linspace(0.0, 1.0, 41)
    program = {
        first: center[first] + radius * np.cos(begin + u * sweep),
        second: center[second] + radius * np.sin(begin + u * sweep),
        normal: start[normal] + u * lift,
    }
    c, s = math.cos(math.radians(turned)), math.sin(math.radians(turned))
    expected = np.column_stack(
        [
            5 + c * program["X"] - s * program["Y"],
            -6 + s * program["X"] + c * program["Y"],
            7 + program["Z"],
            np.full_like(u, math.radians(20.0)),
            np.radians(-15.0 + 40.0 * u - turned),
        ]
    )
    found = at(path, 0, u)
    assert np.abs(found - expected).max() < 1e-8  # ten decimals in the program, two of them lost to three turns
    length = math.hypot(radius * abs(sweep), lift)
    assert path.feed_time[0] == pytest.approx(60.0 * length / 1200.0, rel=1e-9)


def test_a_full_circle_is_a_segment_though_its_ends_are_one_point(path_of):
    path = path_of("G3 X40 Y10 I-20 J0")
    assert len(path) == 1
    assert path.arcs.sweep[0] == pytest.approx(2 * math.pi)
    assert at(path, 0, [0.5])[0, :3] == pytest.approx([0.0, 10.0, 30.0], abs=EXACT)
    assert path.feed_time[0] == pytest.approx(60.0 * 2 * math.pi * 20.0 / 1200.0, rel=1e-9)


def test_radius_arcs(path_of):
    """R > 0 the short arc, R < 0 the long one."""
    short, long = path_of("G3 X20 Y30 R20"), path_of("G3 X20 Y30 R-20")
    assert np.degrees(short.arcs.sweep[0]) == pytest.approx(90.0, abs=1e-7)  # R leaves the root of 1e-15
    assert np.degrees(long.arcs.sweep[0]) == pytest.approx(270.0, abs=1e-7)
    assert at(long, 0, [1.0])[0, :3] == pytest.approx([20.0, 30.0, 30.0], abs=EXACT)


@pytest.mark.parametrize("turned", [0.0, -50.0])
def test_unequal_radii_end_at_the_programmed_end(path_of, turned):
    """Three decimals of I and J leave 0.01 mm between the radii: the arc becomes a spiral, not a gap."""
    path = path_of("G2 X60.008 Y-10 I20 J0\nG1 X70", wcs={1: WorkOffset((0.0, 0.0, 0.0), turned)})
    straight = path_of("G1 X60.008 Y-10\nG1 X70", wcs={1: WorkOffset((0.0, 0.0, 0.0), turned)})
    assert path.arcs.r0[0] == pytest.approx(20.0, abs=EXACT)
    assert path.arcs.r1[0] == pytest.approx(math.hypot(0.008, 20.0), abs=EXACT)
    np.testing.assert_allclose(path.end[0], straight.end[0], rtol=0, atol=EXACT)
    np.testing.assert_allclose(at(path, 0, [0.0])[0], path.start[0], rtol=0, atol=EXACT)
    np.testing.assert_allclose(at(path, 0, [1.0])[0], path.end[0], rtol=0, atol=EXACT)
    middle = at(path, 0, np.linspace(0, 1, 11))[:, :3] - path.arcs.center[0]
    radii = np.linalg.norm(middle, axis=1)
    assert radii == pytest.approx(np.linspace(path.arcs.r0[0], path.arcs.r1[0], 11), abs=EXACT)


# --- feed -----------------------------------------------------------------------------------------


def test_feed_per_minute_counts_the_tip(path_of):
    """mm/min along the tip's path, whatever the table does meanwhile."""
    path = path_of("G1 X43 Y14 A30 C60 F600\nG1 X43 Y14 Z42 F100")
    assert path.feed_time == pytest.approx([60.0 * 5.0 / 600.0, 60.0 * 12.0 / 100.0], rel=1e-9)


def test_rotary_only_moves_have_degrees_per_minute(path_of):
    path = path_of("G1 A50 F300\nG1 C75 F900\nG1 A20 C35 F50")
    expected = [60 * 30 / 300, 60 * 90 / 900, 60 * 50 / 50]
    assert path.feed_time == pytest.approx(expected, rel=1e-9)


def test_inverse_time_says_how_long_a_block_takes(path_of):
    """1/F minutes for lines, arcs, rotary moves, all of them together, whatever the unit."""
    body = "G93 G1 X50 F2\nG1 A30 C40 F5\nG1 X55 A35 F0.5\nG2 X65 Y0 I10 J0 Z20 F4\nG20 G1 X1 F10"
    path = path_of(body)
    assert path.feed_time == pytest.approx([30.0, 12.0, 120.0, 15.0, 6.0], rel=1e-9)


def test_feed_per_revolution(path_of):
    """G95: mm per revolution of the spindle in force."""
    path = path_of("M3 S3000\nG95 G1 X50 F0.1\nS1500 G1 X60\nG1 A30 F0.2")
    expected = [10 / 0.1 / 3000 * 60, 10 / 0.1 / 1500 * 60, 10 / 0.2 / 1500 * 60]
    assert path.feed_time == pytest.approx(expected, rel=1e-9)


def test_inches_scale_lengths_and_feeds_but_not_angles(path_of):
    head = "G20 G90 G94 G61 F10\nG0 X1 Y0 Z1 A20 C-15\n"
    path = path_of("G1 X2 F20\nG1 A50 F300\nG3 X0 Y0 I-1 J0 F30", head=head)
    assert path.start[0, :3] == pytest.approx([25.4, 0.0, 25.4], abs=EXACT)
    assert path.end[0, :3] == pytest.approx([50.8, 0.0, 25.4], abs=EXACT)
    assert path.arcs.r0[0] == pytest.approx(25.4, abs=EXACT)
    assert np.degrees(path.end[1, 3]) == pytest.approx(50.0)
    expected = [60 * 1 / 20, 60 * 30 / 300, 60 * math.pi / 30]
    assert path.feed_time == pytest.approx(expected, rel=1e-9)


def test_rapids_have_no_feed_time(path_of):
    path = path_of("G0 X50 A30\nG1 X60\nG0 C20")
    assert path.feed_time[0] == path.feed_time[2] == 0.0
    assert path.feed_time[1] > 0.0


# --- sections -----------------------------------------------------------------------------------------


def joints_of(path):
    """True for each segment that continues the one before without a stop."""
    return (path.section[1:] == path.section[:-1]).tolist()


STRAIGHT = "G1 X41 Y12 Z33\nG1 X43 Y16 Z39\nG1 X43.5 Y17 Z40.5"
FIVE_AXES = "G1 X41 Y12 Z33 A22 C-20\nG1 X43 Y16 Z39 A26 C-30\nG1 X43.5 Y17 Z40.5 A27 C-32.5"


@pytest.mark.parametrize("body", [STRAIGHT, FIVE_AXES], ids=["tip only", "with A and C"])
def test_proportional_lines_are_one_section(path_of, body):
    path = path_of(body)
    assert joints_of(path) == [True, True]
    assert path.section.tolist() == [0, 0, 0]


def test_rotary_only_moves_join_when_they_are_proportional(path_of):
    assert joints_of(path_of("G1 A22 C-10\nG1 A26 C0\nG1 A27 C0")) == [True, False]


@pytest.mark.parametrize(
    "second",
    ["G1 X43 Y16.00001 Z39", "G1 X43 Y16 Z39 A20.0001", "G1 X43 Y16 Z39 C-15.0001", "G1 X40 Y10 Z30"],
    ids=["kink of 1e-6", "A begins to turn", "C begins to turn", "back"],
)
def test_a_small_kink_stops(path_of, second):
    """Y 1e-5 over a length of 7.5 is a kink of 1e-6: 8e-4 mm/s at full speed would be a jump of 800 mm/s3 at 1 ms."""
    assert joints_of(path_of("G1 X41 Y12 Z33\n" + second)) == [False]


def test_proportional_tips_with_unproportional_angles_stop(path_of):
    assert joints_of(path_of("G1 X41 Y12 Z33 A22 C-20\nG1 X43 Y16 Z39 A26 C-29.999")) == [False]


def test_rounding_of_the_programs_decimals_is_no_kink_of_its_own(path_of):
    """A line cut into steps of 0.1, 0.2, 0.3 mm, as decimals allow exactly: all one section, part turned or not."""
    xs = np.cumsum([0.1, 0.2, 0.3] * 40) + 40
    body = "\n".join(f"G1 X{x:.4f} Y{10 + 2 * (x - 40):.4f}" for x in xs)
    for turned in (0.0, 33.3):
        path = path_of(body, wcs={1: WorkOffset((100.0, 3.0, 0.0), turned)})
        assert all(joints_of(path))


def test_arcs_of_one_circle_join(path_of):
    body = "G3 X20 Y30 I-20 J0\nG3 X0 Y10 I0 J-20\nG3 X40 Y10 I20 J0"
    assert joints_of(path_of(body)) == [True, True]
    assert joints_of(path_of(body, wcs={1: WorkOffset((100.0, 3.0, 0.0), 33.3)})) == [True, True]


def test_helices_of_one_pitch_join_and_of_two_pitches_do_not(path_of):
    body = "G3 X20 Y30 Z32 I-20 J0\nG3 X0 Y10 Z34 I0 J-20\nG3 X20 Y-10 Z35 I20 J0"
    assert joints_of(path_of(body)) == [True, False]


@pytest.mark.parametrize(
    "body",
    [
        "G1 X40 Y20\nG3 X20 Y40 I-20 J0",
        "G3 X20 Y30 I-20 J0\nG1 X10",
        "G3 X20 Y30 I-20 J0\nG3 X10 Y20 I0 J-10",
        "G3 X20 Y30 I-20 J0\nG2 X40 Y10 I0 J-20",
        "G3 X20 Y30 I-20 J0\nG2 X0 Y50 I0 J20",
    ],
    ids=["line to tangent arc", "arc to tangent line", "smaller radius", "back", "S"],
)
def test_what_jumps_in_curvature_does_not_join(path_of, body):
    assert joints_of(path_of(body)) == [False]


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("F1200", "F1201"),
        ("G0", "G1"),
        ("G1", "G0"),
    ],
)
def test_another_feed_does_not_join(path_of, first, second):
    words = [word if word.startswith("G") else f"G1 {word}" for word in (first, second)]
    path = path_of(f"{words[0]} X41 Y12 Z33\n{words[1]} X43 Y16 Z39")
    assert joints_of(path) == [False]


def test_rapids_in_one_direction_join(path_of):
    assert joints_of(path_of("G0 X41 Y12 Z33\nG0 X43 Y16 Z39")) == [True]


def test_inverse_time_joins_at_one_speed(path_of):
    assert joints_of(path_of("G93 G1 X41 Y12 Z33 F6\nG1 X43 Y16 Z39 F3\nG1 X45 Y20 Z45 F6")) == [True, False]


def test_exact_stop_mode_stops_at_every_joint(path_of):
    """G61.1 in force at the end of a segment; G61 and G64 leave proportional segments together."""
    assert joints_of(path_of("G61.1\n" + STRAIGHT)) == [False, False]
    assert joints_of(path_of("G1 X41 Y12 Z33\nG61.1 G1 X43 Y16 Z39\nG61 G1 X43.5 Y17 Z40.5")) == [True, False]
    assert joints_of(path_of("G64\n" + STRAIGHT)) == [True, True]


def test_a_dwell_splits_a_section(path_of):
    path = path_of("G1 X41 Y12 Z33\nG4 P0.5\nG1 X43 Y16 Z39\nG1 X43.5 Y17 Z40.5\nG4 P0.25")
    assert path.section.tolist() == [0, 1, 1]
    assert path.dwell_section.tolist() == [1, 2]
    assert path.dwell_seconds.tolist() == [0.5, 0.25]
    assert path.dwell_line.tolist() == [4, 7]


def test_dwells_before_and_between(path_of):
    path = path_of("G4 P1\nG1 X41\nG4 P2\nG1 X41\nG4 P3\nG1 X42")
    assert path.line.tolist() == [4, 8]
    assert path.dwell_section.tolist() == [0, 1, 1]
    assert path.dwell_seconds.tolist() == [1.0, 2.0, 3.0]


def test_a_dwell_of_no_time_is_a_stop(path_of):
    path = path_of("G1 X41 Y12 Z33\nG4 P0\nG1 X43 Y16 Z39")
    assert joints_of(path) == [False]
    assert path.dwell_section.tolist() == [1]
    assert path.dwell_seconds.tolist() == [0.0]


def test_sections_are_numbered_in_order(path_of):
    path = path_of("G1 X41\nG1 X42\nG1 Y20\nG1 Y21\nG1 X0")
    assert path.section.tolist() == [0, 0, 1, 1, 2]
    assert path.n_sections == 3


# --- tool length changes --------------------------------------------------------------------------


def test_a_new_tool_length_moves_the_tip_along_the_tool_axis(path_of, machine):
    """The machine stands still when the length changes; the next segment starts from where it really is."""
    head = "G21 G90 G94 G61 F1200\nG43.1 Z60\nG0 X40 Y10 Z30 A20 C-15\n"
    path = path_of("G1 X70 A40 C50\nG43.1 Z95.5\nG0 X70 Y10 Z80\nG1 X60", head=head, tool_length=None)
    assert path.tool_length.tolist() == [60.0, 95.5, 95.5]
    shift = path.start[1] - path.end[0]
    # a longer tool: the tip is that much further down the axis
    expected = -35.5 * axis_of(math.radians(40.0), math.radians(50.0))
    assert shift[:3] == pytest.approx(expected, abs=EXACT)
    assert shift[3:] == pytest.approx([0.0, 0.0], abs=0)
    q_before = machine.five_axis.solve(path.end[0, :3], path.end[0, 3:], 60.0)[0]
    q_after = machine.five_axis.solve(path.start[1, :3], path.start[1, 3:], 95.5)[0]
    assert q_after == pytest.approx(q_before, abs=EXACT)
    assert path.end[1, :3] == pytest.approx([70.0, 10.0, 80.0], abs=EXACT)
    assert joints_of(path) == [False, False]


def test_a_length_said_before_the_first_motion_counts_from_the_start(path_of):
    """A rapid before any length counts length 0: there the gauge line stands, and the longer tool hangs below."""
    head = "G21 G90 G94 G61 F1200\n"
    path = path_of("G0 X40 Y10 Z30 A20 C-15\nG43.1 Z60\nG0 X41 Y10 Z90\nG1 X60", head=head, tool_length=None)
    along = axis_of(math.radians(20.0), math.radians(-15.0))
    gauge_line = path.first_pose[:3] + path.first_tool_length * along
    assert gauge_line == pytest.approx([40.0, 10.0, 30.0], abs=EXACT)
    assert path.tool_length.tolist() == [60.0, 60.0]
    assert path.start[0, :3] == pytest.approx(np.array([40.0, 10.0, 30.0]) - 60.0 * along, abs=EXACT)
    assert path.end[0, :3] == pytest.approx([41.0, 10.0, 90.0], abs=EXACT)


def test_the_option_overrides_the_programs_lengths(path_of):
    head = "G21 G90 G94 G61 F1200\nG43.1 Z60\nG0 X40 Y10 Z30 A20 C-15\n"
    path = path_of("G1 X70\nG49\nG1 X60", head=head, tool_length=33.0)
    assert path.tool_length.tolist() == [33.0, 33.0]
    np.testing.assert_array_equal(path.start[1], path.end[0])


# --- nothing to do --------------------------------------------------------------------------------


def test_lines_of_segments_are_source_lines(path_of):
    path = path_of("(remark)\nG1 X41\n\nN100 G1 X42\nG1 X42\nG1 X43 (end)")
    assert path.line.tolist() == [4, 6, 8]
    assert (path.move >= 0).all()
