"""Five jobs with five axes, each as programs of three controls write it: set-up as `setup` asks for it, and places.

The programs are ours (tests/corpus): each has the head, the words and the end that posts of CAM systems, or people,
give such programs. What must come out is computed here, without matrices.
"""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from tests.gcode.test_siemens_frames import about
from verne_post import load_machine
from verne_post.app.assemble import read_draft
from verne_post.model.options import Options

CORPUS = Path(__file__).parents[1] / "corpus"
HEIGHT = 60.0  # of G54 above the table face
NAMES = {"BALL_MILL_8": 5, "DRILL_6.8": 2, "TAP_M8": 4}


def tilt(plane, u, v, w):
    """A place of a plane on the table, and its normal: ``plane`` lists turns, the outermost first, and X."""
    *turns, x = plane
    place, axis = (u, v, w), (0.0, 0.0, 1.0)
    for letter, angle in reversed(turns):
        place, axis = about(letter, angle, place), about(letter, angle, axis)
    return (place[0] + x, place[1], place[2] + HEIGHT, *axis)


def turn(x, y, z, a, c):
    """A place of the part with the table at A and C, and the direction of the tool there."""
    return (x, y, z + HEIGHT, *about("Z", -c, about("X", -a, (0.0, 0.0, 1.0))))


def point(x, y, z, i, j, k):
    """A place of the part, and a direction."""
    size = math.sqrt(i * i + j * j + k * k)
    return (x, y, z + HEIGHT, i / size, j / size, k / size)


CORNER, TURNED = (("X", 20.0), ("Z", 90.0), 10.0), (("X", 20.0), 5.0)
CIRCLE = ((10, 0), (0, 10), (-10, 0), (0, -10))
#: Job -> where the tool is after each cut: tip on the table, mm, and direction. Of holes the bottoms, then the taps.
PLACES = {
    "blade": [
        point(-20, 0, 2, 0, 0, 1),
        point(-18, 0, 2, 0.05, 0.02, 0.998549),
        point(-14, 0, 1.5, 0.1, 0.04, 0.994183),
        point(-10, 0, 1.2, 0.15, 0.05, 0.987421),
        point(-5, 0, 1.2, 0.2, 0.06, 0.977957),
        point(-5, 0, 20, 0.2, 0.06, 0.977957),
    ],
    "rib": [
        turn(-15, -15, 1, 0, 0),
        turn(-12, -12, 1, 2, 5),
        turn(-8, -10, 0.5, 4, 12),
        turn(-4, -8, 0.2, 6, 20),
        turn(0, -6, 0.2, 8, 30),
        turn(0, -6, 20, 8, 30),
    ],
    "swarf": [
        turn(0, -20, 0, 5, 10),
        turn(2, -18, 0, 6, 12),
        turn(4, -15, 0, 7, 15),
        turn(6, -11, 0, 8, 20),
        turn(7, -6, 0, 8, 28),
        turn(7, -6, 10, 8, 28),
    ],
    "pocket": [tilt(CORNER, 0, 0, -2), tilt(CORNER, 10, 10, -2), tilt(CORNER, 0, 0, -2)],
    "holes": [
        *(tilt(TURNED, u, v, -12) for u, v in CIRCLE),
        *(tilt(TURNED, u, v, w) for u, v in CIRCLE for w in (-10, 5)),
    ],
}
PROGRAMS = [(job, name.format(job)) for job in PLACES for name in ("siemens/{}.mpf", "fanuc/{}.nc", "heidenhain/{}.h")]


@pytest.fixture(scope="module")
def serial():
    return load_machine("serial")


@pytest.mark.parametrize(("job", "name"), PROGRAMS)
def test_the_tool_goes_where_the_job_says(serial, job, name):
    options = Options(
        source_name=name,
        tools={number: make_tool(number, 80.0, 6.8) for number in range(1, 9)},
        wcs={"G54": (0.0, 0.0, HEIGHT)},
        tapping="feed",
        remap=dict.fromkeys(("M10", "M11", "M12", "M13", "M68", "M69"), "event"),
        control={"siemens": {"tools": NAMES}, "heidenhain": {"tools": NAMES}},
    )
    path = read_draft((CORPUS / name).read_bytes(), serial, options).path
    ends = path.end[path.feed_time > 0]
    found = np.array(
        [(*tip, *turn(0, 0, 0, *np.degrees(angles))[3:]) for tip, angles in ((e[:3], e[3:]) for e in ends)]
    )
    if job == "holes":  # pecks count from the surface or from R: the bottoms are the same
        expected = np.array(PLACES[job])
        reached = [np.abs(found - place).max(axis=1).min() for place in expected]
        assert max(reached) < 1e-9
        down = found[:, :3] @ expected[0, 3:]
        assert down.min() == pytest.approx(expected[0, :3] @ expected[0, 3:], abs=1e-9)
        return
    assert found.shape == (len(PLACES[job]), 6)
    assert np.abs(found - PLACES[job]).max() < 1e-9


@pytest.mark.parametrize("name", [name for _job, name in PROGRAMS])
def test_what_setup_asks_for_is_all_that_a_program_needs(run, tmp_path, name):
    program = tmp_path / Path(name).name
    program.write_bytes((CORPUS / name).read_bytes())
    assert run("setup", program, "--machine", "serial").code == 0
    filled = Path(f"{program}.toml")
    text = filled.read_text(encoding="utf-8").replace('tapping = "refuse"', 'tapping = "feed"')
    text = text.replace('length = "measure"', "length = 80.0").replace('diameter = "measure"', "diameter = 6.8")
    text = re.sub(r'= "measure"', f"= [0.0, 0.0, {HEIGHT}]", text).replace('"decide"', '"event"')
    filled.write_text(text, encoding="utf-8")
    outcome = run("check", program, "--machine", "serial", "--split-at-stops")
    assert outcome.code == 0, outcome.err
