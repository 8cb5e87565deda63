"""Vertices of finely divided curves that move: the tolerance is kept, and what they join stays smooth."""

import numpy as np
import pytest
from scipy.interpolate import make_smoothing_spline

import verne_post
from verne_post.app.assemble import assemble
from verne_post.model.options import Options
from verne_post.toolpath import fairing

from ..builders import MACHINE

OPTIONS = Options(tool_length=50.0)
TOLERANCE_MM = 0.01


def zigzag(corner_deg, moves=30):
    half, k = np.radians(corner_deg) / 2, np.arange(1, moves + 1)
    corners = zip(np.cos(half) * k, np.sin(half) * (k % 2), strict=True)
    lines = [f"G1 X{x:.5f} Y{y:.5f}" for x, y in corners]
    return "\n".join(["G21 G90 G94 G64 P0.01 F3000", "G0 X0 Y0 Z60 A0 C0", *lines, "M2\n"]).encode()


def wavy(*end):
    """Moves of 0.3 mm whose points are shaken by two micrometres, and what comes after them."""
    x = np.arange(0, 12.01, 0.3)
    y = 2 * np.sin(x / 6) + np.random.default_rng(1).normal(0, 0.002, len(x))
    lines = [f"X{a:.4f} Y{b:.4f}" for a, b in zip(x, y, strict=True)]
    head = ["G21 G90 G94 G64 P0.01 F3000", f"G0 Z60 A0 C0 {lines[0]}"]
    return "\n".join([*head, *(f"G1 {line}" for line in lines[1:]), *end, "M2\n"]).encode()


@pytest.mark.parametrize("corner_deg", [14, 5])
def test_zigzags_of_flat_corners_use_their_tolerance_and_no_more(corner_deg):
    result = verne_post.convert(zigzag(corner_deg), MACHINE, OPTIONS)
    assert result.ok, result.findings
    assert 0.5 * TOLERANCE_MM < result.summary.verification.tip_deviation_mm <= TOLERANCE_MM


def test_a_faired_curve_continues_into_the_blend_of_an_arc():
    """The blend matches the segment before it as programmed, so that segment must stay where it is."""
    source = wavy("G3 X12 Y9.8161 R4", "G1 X0")
    contour = assemble(source, MACHINE, OPTIONS).contour
    assert np.abs(contour.shape.end - contour.path.end).max() > 1e-4
    result = verne_post.convert(source, MACHINE, OPTIONS)
    assert result.ok, result.findings
    assert result.summary.n_stops == 0


def test_points_move_to_the_smoothing_spline_that_scipy_finds():
    rng = np.random.default_rng(5)
    s = np.cumsum(rng.uniform(0.05, 0.5, 60))
    values = rng.normal(size=(60, 5))
    held = rng.random(60) < 0.1
    held[[0, -1]] = True
    change = fairing._smooth(values, s, held, 0.01)
    spline = make_smoothing_spline(s, values, np.where(held, 1e9, 1.0), 0.01)
    assert (change[held] == 0).all()
    # theirs holds by a weight of 1e9, so values of size 1 move by its reciprocal times what bends them
    np.testing.assert_allclose(values + change, spline(s), atol=1e-6)
    assert np.abs(change).max() > 0.5


def test_long_stretches_are_faired_in_parts_that_meet(monkeypatch):
    n = 3000
    s = 0.2 * np.arange(n + 1)
    vertex = np.random.default_rng(3).normal(0, 0.002, (n + 1, 5)) + np.sin(s / 20)[:, None]
    soft = np.ones(n + 1, dtype=bool)
    soft[[0, 900, -1]] = False
    bound = np.full(n + 1, 1.0)
    whole = fairing.fair_vertices(vertex, s, soft, bound, bound)
    assert np.abs(whole - vertex).max() > 1e-3
    monkeypatch.setattr(fairing, "LONGEST", 700)
    parts = fairing.fair_vertices(vertex, s, soft, bound, bound)
    assert np.array_equal(parts[~soft], vertex[~soft])
    assert np.abs(parts - whole).max() < 1e-12
    monkeypatch.setattr(fairing, "OVERLAP", 6)
    assert np.abs(fairing.fair_vertices(vertex, s, soft, bound, bound) - whole).max() > 1e-6
