"""Turns of the table under a standing spindle (Klartext without M128), and about a point before the tip (PLANE MOVE
DIST).

Each is one segment on the exact curve. An earlier version cut such a block into chords, which stopped at each.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import verne_post
from verne_post.app.assemble import assemble
from verne_post.app.verify import verify_setpoints
from verne_post.base.rotations import find_axis_of_angles
from verne_post.model.moves import Frame
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.output.rounding import choose_setpoint_format
from verne_post.toolpath.evaluate import differentiate_pose, evaluate_pose
from verne_post.verification.programmed import find_programmed_pose, measure_lengths_to, measure_metric_lengths

from ..builders import MACHINE, two_machines, with_ranges

LENGTH = 80.0
OPTIONS = Options(tool_length=LENGTH, wcs={1: WorkOffset((10.0, -5.0, 60.0), 25.0)}, dialect="heidenhain")
#: Line 4 is a straight move, line 5 what is tested, line 6 another straight move.
HEAD = "BEGIN PGM P MM\nTOOL CALL 1 Z S9000 F2000\nL A+5 C-10 FMAX\nL X+40 Y+30 Z+60 FMAX\n"
#: Motions of one block, and how many millimetres and degrees of them F counts.
BLOCKS = {
    "turn": "L A+25 C+80",
    "turn of C alone": "L C+200",
    "several turns": "L C+1000",
    "turn home": "L A+0 C+0 R0 M91",
    "all axes": "L X-30 Y+5 Z+50 A-20 C+100",
    "all axes of the machine": "L X+0 Y+0 Z-300 A+20 C-40 M91",
    "plane": "PLANE SPATIAL SPA+25 SPB+20 SPC+0 TURN",
    "about a point": "PLANE SPATIAL SPA+25 SPB+20 SPC+40 MOVE DIST50",
    "about a point, and round": "PLANE AXIAL A+20 IC+360 MOVE DIST50",
}
TURNS = [name for name in BLOCKS if not name.startswith("about")]


def program(block: str, feed: str = "FMAX", after: str = "L IZ+10 F1000") -> bytes:
    words = block.split()
    at = words.index("M91") if "M91" in words else len(words)
    return (HEAD + " ".join([*words[:at], feed, *words[at:]]) + f"\n{after}\nEND PGM P MM\n").encode()


def path_of(source: bytes, options: Options = OPTIONS) -> ToolPath:
    return assemble(source, MACHINE, options).path


def machine_places(tip: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """X Y Z A C of the nominal machine (mm, degrees) where the tip and the table stand."""
    frame = Frame(tool=(0.0, 0.0, LENGTH, *(0.0,) * 6))
    coordinates = MACHINE.coordinates
    return coordinates.map_to_machine(coordinates.map_from_table(tip, angles, frame), frame)[:, [0, 1, 2, 3, 5]]


@pytest.mark.parametrize("feed", ["FMAX", "F3000"])
@pytest.mark.parametrize("block", BLOCKS)
def test_a_block_is_one_segment_that_nothing_stops(block: str, feed: str) -> None:
    """Its neighbours are rounded into it, like any other moves of two lines."""
    contour = assemble(program(BLOCKS[block], feed), MACHINE, OPTIONS).contour
    assert np.count_nonzero(contour.path.line == 5) == 1
    assert contour.path.kind[contour.path.line == 5] == SegmentKind.TURN
    assert len(np.unique(contour.section[contour.find_lines() == 5])) == 1


@pytest.mark.parametrize("block", TURNS)
def test_the_axes_of_the_machine_go_straight(block: str) -> None:
    path = path_of(program(BLOCKS[block]))
    segment = int(np.flatnonzero(path.line == 5)[0])
    u = np.linspace(0.0, 1.0, 41)
    place = machine_places(*evaluate_pose(path, np.full(len(u), segment), u))
    np.testing.assert_allclose(
        place, place[0] + u[:, None] * (place[-1] - place[0]), atol=1e-7
    )  # ends are rounded to 1e-9 mm
    for end, u_end in ((path.start, 0), (path.end, -1)):
        np.testing.assert_allclose(
            end[segment, :3], evaluate_pose(path, np.full(len(u), segment), u)[0][u_end], atol=1e-9
        )


@pytest.mark.parametrize("block", [name for name in BLOCKS if name not in TURNS])
def test_a_point_before_the_tip_keeps_its_place(block: str) -> None:
    path = path_of(program(BLOCKS[block]))
    segment = int(np.flatnonzero(path.line == 5)[0])
    tip, angles = evaluate_pose(path, np.full(41, segment), np.linspace(0.0, 1.0, 41))
    held = tip - 50.0 * find_axis_of_angles(angles[:, 0], angles[:, 1])
    np.testing.assert_allclose(held, np.tile(held[0], (41, 1)), atol=1e-8)
    assert np.ptp(angles[:, 1]) > 0.5


@pytest.mark.parametrize("block", BLOCKS)
def test_planning_and_verification_have_the_same_curve(block: str) -> None:
    """Two evaluations that share no formula; derivatives and lengths against differences of them."""
    path = path_of(program(BLOCKS[block]))
    segment = np.full(2001, int(np.flatnonzero(path.line == 5)[0]))
    u = np.linspace(0.0, 1.0, len(segment))
    tip, angles = evaluate_pose(path, segment, u)
    for one, other in zip((tip, angles), find_programmed_pose(path, segment, u), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)
    step = u[1]
    derived = [np.concatenate([tip, angles], axis=1), *differentiate_pose(path, segment, u)]
    for values, rates in pairwise(derived):
        differences = (values[2:] - values[:-2]) / (2 * step)
        # the error of central differences: third derivative times step squared, over 6; the sharpest turn has 1000
        # degrees in u
        np.testing.assert_allclose(rates[1:-1], differences, atol=2e-5 * max(float(np.abs(rates).max()), 1.0))
    way = np.hypot(*(np.linalg.norm(np.diff(part, axis=0), axis=1) for part in (tip, 50.0 * angles)))
    metric = measure_metric_lengths(path)
    np.testing.assert_allclose(measure_lengths_to(path, segment, u, metric)[1:], np.cumsum(way), rtol=1e-5)
    # what planning takes for the length is nowhere shorter than the way
    assert (way <= path.length[segment[0]] * step * 1.001).all()


@pytest.mark.parametrize("machine", two_machines(0.004).values(), ids=lambda machine: machine.name)
@pytest.mark.parametrize("block", BLOCKS)
def test_files_pass_their_verification(machine, block: str) -> None:
    """Convert judges the rows it has made; the feed of the block is reached where no joint stands against it."""
    result = verne_post.convert(program(BLOCKS[block], "F1500"), machine, OPTIONS)
    assert result.ok, result.findings
    rows = np.count_nonzero(result.setpoints.line == 5)
    path = path_of(program(BLOCKS[block], "F1500"))
    feed_time = float(path.feed_time[path.line == 5].sum())
    # the ramps at both ends, and half of what the corners cut off, take no second more
    assert feed_time - 0.1 <= rows * machine.cycle <= feed_time + 1.0


def test_the_sliders_stand_while_the_table_turns() -> None:
    machine = two_machines(0.01)["verne"]
    result = verne_post.convert(program(BLOCKS["turn"]), machine, replace(OPTIONS, smoothing="off"))
    assert result.ok
    rows = result.setpoints.values[result.setpoints.line == 5]
    assert np.ptp(rows[:, 3:], axis=0).min() > 15.0
    assert np.ptp(rows[:, :3], axis=0).max() < 1e-6  # decimals of the rows


def test_a_turn_takes_no_longer_than_its_table() -> None:
    """With M128 the sliders follow the part: that takes 1.1 s. Cut into chords it took 9 s."""
    seconds = [
        verne_post.convert(
            HEAD.replace("L X", f"{tcp}\nL X").encode() + b"L A+25 C+80 FMAX\nEND PGM P MM\n", MACHINE, OPTIONS
        )
        for tcp in ("M129", "M128")
    ]
    without, with_tcp = (result.summary.cycle_time for result in seconds)
    assert without < with_tcp + 0.3


def test_a_file_along_the_chord_is_refused() -> None:
    """Its ends are right; the tip goes straight on the part, 9 mm beside the curve."""
    machine = two_machines(0.01)["verne"]
    options = replace(OPTIONS, smoothing="off")
    source = program(BLOCKS["turn"], "F3000")
    path = path_of(source)
    x, y, z = MACHINE.coordinates.map_from_table(
        path.end[1:2, :3], path.end[1:2, 3:], assemble(source, MACHINE, options).moves.frames[0]
    )[0, :3]
    straight = HEAD + f"M128\nL X{x:+.6f} Y{y:+.6f} Z{z:+.6f} A+25 C+80 F3000\nM129\nL IZ+10 F1000\nEND PGM P MM\n"
    result = verne_post.convert(straight.encode(), machine, options)
    assert result.ok, result.findings
    asked = assemble(source, machine, options)
    line = np.where(result.setpoints.line >= 6, result.setpoints.line - 1, result.setpoints.line)
    line = np.where(line == 7, 6, line)
    fmt = choose_setpoint_format(machine, asked.cycle, options.decimals, accept_rounding=True)
    block = verne_post.model.setpoints.SetpointBlock(0, result.setpoints.values, line, fmt)
    assert {item.code for item in verify_setpoints(asked, [block]).findings} & {"VP411", "VP412"}


def test_another_branch_holds_the_same_tip() -> None:
    """A may not go below 0: the table takes A25 C260 for A-25 C80, and the tip its programmed curve."""
    source = program("L A-25 C+80").replace(b"A+5 C-10", b"A+0 C+0")
    machine = with_ranges(MACHINE, a=(-1.0, 95.0))
    result = verne_post.convert(source, machine, replace(OPTIONS, allow_rewind=True))
    assert result.ok, result.findings
    flipped = assemble(source, machine, replace(OPTIONS, allow_rewind=True)).path
    there = np.flatnonzero((flipped.line == 5) & (flipped.kind == SegmentKind.TURN))
    assert len(there) == 1
    assert flipped.end[there[0], 3] > 0
    plain = path_of(source)
    u = np.linspace(0.0, 1.0, 9)
    here = np.flatnonzero(plain.line == 5)
    np.testing.assert_allclose(
        evaluate_pose(flipped, np.repeat(there, 9), u)[0], evaluate_pose(plain, np.repeat(here, 9), u)[0], atol=1e-9
    )


def test_in_the_air_every_tip_is_higher() -> None:
    source = program(BLOCKS["all axes"])
    low, high = path_of(source), path_of(source, replace(OPTIONS, air=30.0, air_along="table"))
    for segment in range(len(low)):
        u = np.linspace(0.0, 1.0, 5)
        lifted = evaluate_pose(high, np.full(5, segment), u)[0] - evaluate_pose(low, np.full(5, segment), u)[0]
        np.testing.assert_allclose(lifted, np.tile([0.0, 0.0, 30.0], (5, 1)), atol=1e-9)
