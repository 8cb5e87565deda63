"""Cycles so long, and moves so short, that rows say little: what is converted passes, and what rows do not show fails.

The judge of the turns of a circle shares nothing with planning or verification but the forward kinematics.
"""

import numpy as np
import pytest

import verne_post
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset

from ..builders import MACHINE
from .test_verifier import codes, made, program, verify_rows

OPTIONS = Options(tool_length=80.0, wcs={1: WorkOffset((-10.0, 15.0, 60.0))})
#: From far below a common control cycle to far above it.
CYCLES = [0.000125, 0.001, 0.002, 0.01, 0.05, 0.1, 0.2, 0.5, 1.0]
COARSE = [0.05, 0.1, 0.2, 0.5, 1.0]


def source(body: str, head: str = "G21 G90 G94 G17") -> bytes:
    """A program that starts at X0 Y0 Z5; its body begins on line 3."""
    return program(f"G0 X0 Y0 Z5 A0 C0\n{body}", head)


def tips(values: np.ndarray) -> np.ndarray:
    """Tips of rows in program coordinates; A and C stand at 0."""
    factor = np.array([column.factor for column in MACHINE.columns])
    tip, _axis, ok = MACHINE.forward(values / factor, 80.0)
    assert ok.all()
    return tip - [-10.0, 15.0, 60.0]


def turned(points: np.ndarray, center: tuple[float, float]) -> np.ndarray:
    """Turns (n - 1,) about a centre from row to row, each less than half a one."""
    at = points[:, :2] - center
    angle = np.arctan2(at[:, 1], at[:, 0])
    return (np.diff(angle) / (2 * np.pi) + 0.5) % 1.0 - 0.5


@pytest.mark.parametrize("mode", ["off", "blend", "spline"])
@pytest.mark.parametrize("cycle", CYCLES)
def test_circles_pass_at_any_cycle(cycle: float, mode: str) -> None:
    """A full circle, half of its feed's second long, a line along its diameter and half a circle as short as a
    cycle.
    """
    options = OPTIONS.changed(cycle=cycle, smoothing=mode)
    values, _line = made(source("F2000\nG2 I5\nG1 X5\nG2 X7 I1"), options)
    assert np.abs(tips(values)[-1] - [7.0, 0.0, 5.0]).max() < 1e-4


@pytest.mark.parametrize("cycle", CYCLES)
@pytest.mark.parametrize(("words", "center", "turns"), [
    ("G2 I5", (5, 0), -1), ("G3 I-1 J1 P3", (-1, 1), 3), ("G3 I.02", (0.02, 0), 1), ("G2 J.1 P7 Z5.2", (0, 0.1), -7),
])  # fmt: skip
def test_rows_show_every_turn(words: str, center: tuple[float, float], turns: int, cycle: float) -> None:
    """Whoever adds up the angles from row to row finds the turns of the program: fewer rows could be fewer turns."""
    values, line = made(source(f"F6000 {words}"), OPTIONS.changed(cycle=cycle, smoothing="off"))
    points = tips(values)
    steps = turned(points[line == 3], center)
    assert np.sum(steps) == pytest.approx(turns, abs=1e-3)  # a radius of 0.02 mm is written to 1e-5 mm
    assert (np.abs(steps) < 0.45).all()


@pytest.mark.parametrize("cycle", COARSE)
def test_turns_that_rows_do_not_show_are_refused(cycle: float) -> None:
    """The same places with fewer turns between them: the rows of a program without the circle, under its lines."""
    whole, short = source("F2000 G1 X5\nG2 J3\nG1 X9", "G21 G90 G94 G17 G61.1"), source("F2000 G1 X5\nX9")
    for mode in ("off", "blend"):
        options = OPTIONS.changed(cycle=cycle, smoothing=mode)
        values, line = made(short, options)
        assert {"VP412", "VP413"} & codes(verify_rows(whole, values, np.where(line == 4, 5, line), options))
        standing = np.where(line == 4, 4, line)
        assert {"VP411", "VP412", "VP413"} & codes(verify_rows(whole, values, standing, options))


@pytest.mark.parametrize(
    ("places", "shown"), [((0.1, 0.55, 0.95), True), ((0.1, 0.7, 0.95), False), ((0.6, 0.95), False)]
)
def test_more_than_half_a_turn_in_a_step_is_not_accepted(places: tuple[float, ...], shown: bool) -> None:
    """Some rows of a circle, as a file of half a second a row: each is on the path, and none is early."""
    asked = source("F2000\nG2 I1.5\nG1 X9", "G21 G90 G94 G17 G61.1")
    fine, coarse = (OPTIONS.changed(cycle=cycle, smoothing="off") for cycle in (0.001, 0.5))
    values, line = made(asked, fine)
    circle = np.flatnonzero(line == 4)
    done = -np.cumsum(turned(tips(values)[: circle[-1] + 2], (1.5, 0.0)))
    rows = np.concatenate(
        [[0], np.searchsorted(done, places) + 1, [circle[-1] + 1], np.flatnonzero(line == 5)[::100], [-1]]
    )
    found = codes(verify_rows(asked, values[rows], line[rows], coarse))
    assert not found if shown else {"VP412", "VP413"} & found


def test_half_a_turn_in_one_step() -> None:
    """The last row stands at the end of half a circle, the one before on the line that leads to it: neither sense is
    behind.
    """
    asked = source("F2000\nG1 X5\nG2 X5.2 I.1", "G21 G90 G94 G17 G64 P.02")
    values, line = made(asked, OPTIONS)
    rows = np.append(np.flatnonzero(line <= 4)[::60], len(line) - 1)
    assert line[rows[-2]] == 4
    assert verify_rows(asked, values[rows], line[rows], OPTIONS.changed(cycle=0.5)).findings == []


TEETH = "F6000\n" + "\n".join(f"G1 X{6 * k} Y{10.4 * (k % 2):.1f}" for k in range(1, 12))


@pytest.mark.parametrize("block", [1, 2, 7, 10**6])
def test_the_step_before_counts_beside_sharp_corners(block: int) -> None:
    """Corners of 120 degrees, rows 12 mm apart: what two rows beside a corner leave out is farther than they
    are apart.
    """
    for cycle in (0.1, 0.11, 0.12, 0.13):
        options = OPTIONS.changed(cycle=cycle)
        values, line = made(source(TEETH), options)
        assert verify_rows(source(TEETH), values, line, options, block).findings == []


@pytest.mark.parametrize(("before", "after"), [("G0 X0", "G0 X.01"), ("G61.1 X5", "G61.1 X5.01")])
def test_stops_are_exact_beside_rounded_corners(before: str, after: str) -> None:
    """The first row, and rows at stops, lie within 0.001 mm along the path too, however wide the corners behind them
    are.
    """
    text, options = (
        "G21 G90 G94 G17 G64 P.05\nG0 X0 Y0 Z5 A0 C0\nF2000 G1 X3\nG61.1 X5\nG64 P.05 X9\nY5\nX12\nM2\n",
        OPTIONS.changed(cycle=0.01),
    )
    text = text if "X5" in before else text.replace("X3\nG61.1 X5\nG64 P.05 ", "")
    assert before in text
    values, line = made(text.encode(), options)
    assert "VP412" in codes(verify_rows(text.replace(before, after).encode(), values, line, options))


# --- moves as short as rounding ---------------------------------------------------------------------------------

SHORT = {
    "steps of 1e-6 mm": "\n".join(f"G1 X{k * 1e-6:.6f}" for k in range(1, 51)),
    "a staircase of 1e-6 mm": "\n".join(f"G1 X{k * 1e-6:.6f} Y{(k // 2) * 1e-6:.6f}" for k in range(1, 51)),
    "to and fro by 1e-6 mm": "\n".join(f"G1 X{(k % 2) * 1e-6:.6f} Y{k * 1e-6:.6f}" for k in range(1, 51)),
    "steps of 2e-5 mm behind a line": "G1 X3\n"
    + "\n".join(f"X{3 + k * 2e-5:.6f} Y{(k % 3) * 1e-5:.6f}" for k in range(1, 51)),
    "circles of 0.0015 mm": "\n".join(["G2 I.0015"] * 5 + ["G1 X1"]),
}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("mode", ["off", "blend", "spline"])
@pytest.mark.parametrize("cycle", [0.001, 0.002, 0.01, 0.05, 0.5])
@pytest.mark.parametrize("what", SHORT)
def test_moves_as_short_as_rounding_pass(what: str, cycle: float, mode: str) -> None:
    made(source(f"F1000\n{SHORT[what]}"), OPTIONS.changed(cycle=cycle, smoothing=mode))


@pytest.mark.parametrize("step", [3e-7, 9e-7, 1e-6])
def test_moves_below_the_shortest_add_up(step: float) -> None:
    """Each is no motion by itself; all of them together are, and end where the program says."""
    n = 3000
    body = "\n".join(f"G1 X{k * step:.9f}" for k in range(1, n + 1))
    result = verne_post.convert(source(f"F100\n{body}"), MACHINE, OPTIONS)
    assert result.ok, [item.message for item in result.findings]
    assert result.setpoints is not None
    # what is left is one move too short at the end (1e-6 mm), and the rounding of the rows (7 decimals)
    assert tips(result.setpoints.values)[-1, 0] == pytest.approx(n * step, abs=2e-6)


# --- feed beside rounding ---------------------------------------------------------------------------------------

SLOW = {
    "5 axes at F4": (
        "F3.983\nG1 X0.0947 Y0.0641 A1.763 C4.077\nA-1.242 C5.0445\nA-1.439 C4.626\nX0.062 Y0.07 A-.569 C7.363",
        0.01,
    ),
    "rotation with 0.003 mm of motion": (
        "F500\nG64 P0.85\nG93 G1 X.003 A-.64 C5.7 F2.53\nA-.895 C3.52 F44\nG94 F500 X1",
        0.005,
    ),
    "a minute of rotation with 0.003 mm of motion": ("G64 P.5\nG93 G1 X.003 A-6 C20 F1\nX1 Y1 F5\nG94", 0.005),
    "F5 in corners": ("F5\n" + "\n".join(f"G1 X{0.05 * k:.3f} Y{0.03 * (k % 2):.3f}" for k in range(1, 12)), 0.02),
}


@pytest.mark.parametrize("what", SLOW)
def test_rounding_is_no_feed(what: str) -> None:
    """Rows that are nearer to each other than a few units of the last decimal say little about the speed."""
    body, cycle = SLOW[what]
    made(source(body), OPTIONS.changed(cycle=cycle))


#: Feed rate, cycle, and an excess over the feed rate that must be found.
FEEDS_IN_CORNERS = {
    "F20 at 2 ms: 7e-4 mm a row, of which rounding to 1e-5 mm and 1e-6 deg leaves 0.1 % over 256 rows": (
        20,
        0.002,
        1.004,
    ),
    "F5 at 10 ms: 8e-4 mm a row; a tip may be off by 5e-5 mm, whose mean square takes 0.03 % off, 3 % would hide "
    "the excess": (
        5,
        0.01,
        1.01,
    ),
}


@pytest.mark.parametrize("faster", [False, True])
@pytest.mark.parametrize("what", FEEDS_IN_CORNERS)
def test_feed_in_corners_is_checked_at_slow_feeds(what: str, faster: bool) -> None:
    feed, cycle, excess = FEEDS_IN_CORNERS[what]
    angle = np.linspace(0, np.pi, 40)
    points = "\n".join(f"G1 X{np.sin(a):.4f} Y{1 - np.cos(a):.4f}" for a in angle[1:])
    options = OPTIONS.changed(cycle=cycle)
    values, line = made(source(f"F{feed}\n{points}"), options)
    programmed = feed / excess if faster else feed
    found = codes(verify_rows(source(f"F{programmed:.9f}\n{points}"), values, line, options))
    assert found == ({"VP404"} if faster else set())


# --- rounded corners among small shapes ------------------------------------------------------------------------

SHAPES = {
    "spirals by their decimals": "\n".join(
        f"G3 X{0.06 * k + 0.015:.4f} I.03\nG2 X{0.06 * k + 0.06:.4f} I.022" for k in range(4)
    ),
    "a thread narrower than the tolerance": "G64 P0.25\n"
    "G2 I.03 J.02 P2\n"
    "G1 X.02 "
    "Y.09\n"
    "G3 I.0056 P5 Z5.1\n"
    "G2 I.02 A.4 C14",
    "teeth": "\n".join(f"X{k * 0.1:.1f} Y{2 * (k % 2)}" for k in range(1, 40)),
    "small circles in a fast path": "X20\nG2 I.3\nG1 X40\nG3 J.2 P3\nG1 X41\nG2 I2\nG1 Y5",
    "a slow move behind a rapid": "F52\nG0 X-8\nG1 X-12 Y-1\nG0 X-16 Y-16\nG1 X-23 Y-19 A-1.5 C-13\nA-1.55 C-14",
}


@pytest.mark.parametrize("mode", ["off", "blend", "spline"])
@pytest.mark.parametrize("cycle", [0.002, 0.02, *COARSE])
@pytest.mark.parametrize("what", SHAPES)
def test_small_shapes_pass_at_any_cycle(what: str, cycle: float, mode: str) -> None:
    made(source(f"F3000 G1\n{SHAPES[what]}"), OPTIONS.changed(cycle=cycle, smoothing=mode))


@pytest.mark.parametrize("feed", [29, 100])
@pytest.mark.parametrize("cycle", [0.001, 0.002, 0.01])
def test_a_corner_may_cut_turns_that_are_narrower_than_its_tolerance(cycle: float, feed: int) -> None:
    """Between a line and five turns of 0.0056 mm, within 0.26 mm: the way that is made is shorter than the turns."""
    body = "G64 P.2562\nG1 X.0202305 Y.0943991\nG3 I.005559 P5 Z5.1\nG2 I.02 A.38 C14"
    made(source(f"F{feed}\n{body}"), OPTIONS.changed(cycle=cycle))


def test_rounding_beyond_the_end_of_a_tiny_move_is_no_progress() -> None:
    """4e-6 mm in 14 s, written to 1e-5 mm: one step leads far beyond the end, and counts as no more than the move."""
    body = "G93\nG0 X1.025873 Y-2.808695\nG1 X1.025869240 Y-2.808695156 F4.3702\nG0 Z6"
    made(source(body), OPTIONS.changed(cycle=1.0, smoothing="off"))


@pytest.mark.parametrize(("cycle", "cause"), [(0.001, "jerk of "), (0.25, "control cycle")])
def test_what_keeps_the_tool_below_its_feed_may_be_the_cycle(cycle: float, cause: str) -> None:
    """5 mm at 3000 mm/min with two stops take about 0.15 s."""
    result = verne_post.convert(source("F3000\nG1 X5"), MACHINE, OPTIONS.changed(cycle=cycle, smoothing="off"))
    assert result.summary is not None
    assert result.summary.verification is not None
    slow = result.summary.verification.slow
    assert max(slow, key=lambda name: slow[name]).startswith(cause)
