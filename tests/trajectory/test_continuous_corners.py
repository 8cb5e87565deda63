"""Rounding corners must pay: no program may take longer for it."""

import numpy as np
import pytest

import verne_post
from verne_post.model.options import Options

from ..builders import MACHINE


@pytest.mark.parametrize("corner_deg", [90, 30])
def test_sharp_corners_at_a_feed_far_out_of_reach(corner_deg):
    """The first profile is far too fast there, and the first pass has much to slow down."""
    half, k = np.radians(corner_deg) / 2, np.arange(1, 31)
    corners = zip(np.cos(half) * k, np.sin(half) * (k % 2), strict=True)
    lines = [f"G1 X{x:.5f} Y{y:.5f} F12000" for x, y in corners]
    source = "\n".join(["G21 G90 G94 G64 P0.01", "G0 X0 Y0 Z60 A0 C0", *lines, "M2\n"]).encode()
    seconds = {}
    for smoothing in ("spline", "off"):
        result = verne_post.check(source, MACHINE, Options(tool_length=50.0, smoothing=smoothing))
        assert result.ok, result.findings
        seconds[smoothing] = result.summary.cycle_time
    # corners of 90 degrees gain a sixth, of 30 degrees a quarter
    assert seconds["spline"] < 0.9 * seconds["off"]


def corner_times(lead: float, feed: int, angle_deg: float, machine: str, cycle: float) -> tuple[float, float]:
    """Seconds of one corner between two lines, blended and with a stop."""
    turn = np.radians(angle_deg)
    end = f"X{20 * np.cos(turn):.5f} Y{20 * np.sin(turn):.5f}"
    lines = [f"G21 G90 G94 G64 P0.01 F{feed}", f"G0 X{-lead} Y0 Z60 A0 C0", "G1 X0", f"G1 {end}", "M2\n"]
    seconds = []
    for smoothing in ("spline", "off"):
        options = Options(tool_length=50.0, smoothing=smoothing, cycle=cycle)
        result = verne_post.check("\n".join(lines).encode(), verne_post.load_machine(machine), options)
        assert result.summary is not None, result.findings
        seconds.append(result.summary.cycle_time)
    return seconds[0], seconds[1]


@pytest.mark.parametrize("seed", [17, 39])
def test_a_corner_every_13_um_at_a_feed_far_out_of_reach(seed: int) -> None:
    """At the feed rate hundreds of corners would share a span of the first grid, and some of them stayed unseen."""
    random, heading, x, y = np.random.default_rng(seed), 0.0, 0.0, 0.0
    lines = ["G21 G90 G64 P0.0136", "G0 X0 Y0 Z50 A0 C0", "G1 F13317"]
    for k in range(600):
        heading += random.uniform(0.1, 2.0) * (1 if k % 2 else -1)
        x, y = x + 0.0126 * np.cos(heading), y + 0.0126 * np.sin(heading)
        lines.append(f"X{x:.4f} Y{y:.4f}")
    result = verne_post.convert("\n".join([*lines, "M2", ""]).encode(), MACHINE, Options(tool_length=80.0))
    assert result.ok, result.findings


@pytest.mark.parametrize("feed", [3000, 6000])
def test_a_corner_costs_the_same_wherever_it_is_and_less_than_a_stop(feed: int) -> None:
    """Between lines of any length; a solution that has not settled depends on where its knots are."""
    leads = [8, 12, 20, 22, 26, 30]
    times = np.array([corner_times(lead, feed, 90.0, "serial", 1e-3) for lead in leads])
    assert (times[:, 0] < times[:, 1]).all()
    lost = times[:, 0] - (np.array(leads) + 20) / (feed / 60)
    assert np.ptp(lost) <= 0.002 + 1e-9


@pytest.mark.parametrize(
    ("lead", "feed", "angle_deg", "machine", "cycle"),
    [
        (10.37, 6000, 84.1, "serial", 0.001), (26.0, 12000, 88.1, "serial", 0.004),
        (21.95, 1500, 83.1, "linear_delta", 0.0005),
        (0.77, 3000, 71.9, "verne", 0.00025), (5.0, 3000, 150.0, "verne", 0.002),
    ],
)  # fmt: skip
def test_corners_that_were_slower_than_a_stop(
    lead: float, feed: int, angle_deg: float, machine: str, cycle: float
) -> None:
    blended, stopped = corner_times(lead, feed, angle_deg, machine, cycle)
    assert blended <= stopped
