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
