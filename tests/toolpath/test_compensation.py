"""Coarsely divided curves: the blends of their facets follow the curve, within the tolerance, as fast as fine ones."""

import numpy as np
import pytest

import verne_post
from verne_post.base.rows import measure_rows
from verne_post.model.options import Options
from verne_post.toolpath import compensation
from verne_post.toolpath.contour_pose import find_contour_pose
from verne_post.toolpath.corners import find_bends, find_slopes
from verne_post.toolpath.deviations import Chords

from ..builders import MACHINE
from .polylines import contour_of, flat, program_of, shares_of_tolerance

TOLERANCE_MM = 0.01
RADIUS_MM, STEP_MM = 3.2, 0.5  # chords are off by 0.0098


def circle(turns: float = 0.95) -> np.ndarray:
    angle = np.arange(0.0, 2 * np.pi * turns, 2 * np.arcsin(0.5 * STEP_MM / RADIUS_MM))
    return RADIUS_MM * np.column_stack([np.sin(angle), 1.0 - np.cos(angle)])


def test_facets_of_a_circle_become_a_circle_again() -> None:
    contour = contour_of(program_of(flat(circle()), TOLERANCE_MM))
    assert shares_of_tolerance(contour, 21).max() <= 0.98
    n = len(contour.path)
    middle = np.flatnonzero((contour.segment > 2 * n // 5) & (contour.segment < 3 * n // 5))
    element, w = np.repeat(middle, 21), np.tile(np.linspace(0, 1, 21), len(middle))
    tip = find_contour_pose(contour, element, w)[0][:, :2]
    off = np.hypot(tip[:, 0], tip[:, 1] - RADIUS_MM) - RADIUS_MM
    chord = STEP_MM**2 / (8 * RADIUS_MM)
    # near the share of the chord error inside the vertices, with no more than a fiftieth of it left of the facets
    assert off.mean() == pytest.approx(-compensation.CUT * chord, abs=0.25 * chord)
    assert np.ptp(off) < 0.02 * chord


def test_coarse_steps_take_no_longer_than_fine_ones() -> None:
    seconds = {}
    for step in (0.25, 0.5):
        x = np.arange(0, 64.01, step)
        lines = [f"G1 X{a:.3f} Z{60 + 2 * np.sin(np.pi * a / 8):.3f}" for a in x]
        source = "\n".join(["G21 G90 G94 G64 P0.01 F12000", "G0 X-1 Y0 Z60 A0 C0", *lines, "M2\n"]).encode()
        result = verne_post.check(source, MACHINE, Options(tool_length=50.0))
        assert result.summary is not None, result.findings
        seconds[step] = result.summary.cycle_time
    assert seconds[0.5] <= 1.06 * seconds[0.25]  # 1.35 without compensation


def compensate(xy: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices (n, 5) of a path, where they are moved, and which are compensated."""
    vertex = np.column_stack([xy, np.zeros((len(xy), 3))])
    s = np.append(0.0, np.cumsum(measure_rows(np.diff(vertex, axis=0))))
    soft = np.ones(len(xy), dtype=bool)
    soft[[0, -1]] = False
    bound = np.full(len(xy), TOLERANCE_MM)
    chords = Chords(np.zeros((len(s) - 1, 3)), np.ones(len(s) - 1))
    moved, chain = compensation.compensate_blends(vertex, vertex, s, soft, chords, bound, bound)
    return vertex, moved, chain


def test_vertices_of_a_curve_move_outward_and_evenly() -> None:
    vertex, moved, chain = compensate(circle())
    assert chain.mean() > 0.7
    outward = measure_rows(moved[:, :2] - [0.0, RADIUS_MM]) - RADIUS_MM
    inner = slice(2 * len(vertex) // 5, 3 * len(vertex) // 5)
    assert np.ptp(outward[inner]) < 1e-9
    assert outward[inner].min() > 0.01
    assert (moved[~chain] == vertex[~chain]).all()


@pytest.mark.parametrize("what", ["zigzag", "random walk", "fine circle", "facets far beyond the tolerance"])
def test_what_is_no_coarse_curve_stays(what: str) -> None:
    rng = np.random.default_rng(3)
    k = np.arange(60)
    heading = np.cumsum(rng.normal(size=60) * 0.1)
    xy = {
        "zigzag": np.column_stack([0.3 * k, 0.02 * (k % 2)]),
        "random walk": np.cumsum(0.3 * np.column_stack([np.cos(heading), np.sin(heading)]), axis=0),
        "fine circle": 10.0 * np.column_stack([np.sin(k / 100), 1 - np.cos(k / 100)]),
        "facets far beyond the tolerance": 5.0 * np.column_stack([np.sin(k / 6), 1 - np.cos(k / 6)]),
    }[what]
    vertex, moved, chain = compensate(xy)
    assert not chain.any()
    assert (moved == vertex).all()


def test_a_feature_in_a_curve_ends_what_is_compensated() -> None:
    """A corner of 40 degrees: its neighbours are left alone, and the whole stays within the tolerance."""
    half = circle(0.3)
    end = half[-1] - half[-2]
    turn = np.arctan2(end[1], end[0]) + np.radians(40)
    other = half[1:] @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) + half[-1]
    contour = contour_of(program_of(flat(np.vstack([half, other])), TOLERANCE_MM))
    assert contour.n_sections == 1
    assert shares_of_tolerance(contour, 21).max() <= 0.98
    corner = len(half) - 1
    shift = measure_rows(contour.shape.end - contour.path.end)
    assert shift[corner - 1] == 0
    assert shift.max() > 0.005


def test_parts_meet(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is compensated depends on near corners alone: the same whether a path is taken whole or in parts."""
    x = np.arange(0, 300, 0.5)
    wave = np.column_stack([x, 2 * np.sin(np.pi * x / 8) * (1 + 0.2 * np.sin(x / 40))])
    _vertex, whole, chain = compensate(wave)
    assert 0.2 < chain.mean() < 1.0
    monkeypatch.setattr(compensation, "COMPENSATED_VERTICES", 100)
    _vertex, parts, in_parts = compensate(wave)
    assert np.array_equal(chain, in_parts)
    np.testing.assert_allclose(parts, whole, atol=1e-12)


def test_both_directions_are_alike() -> None:
    """Neighbouring passes run to and fro: the vertices of one are those of the other."""
    x = np.arange(0, 100, 0.5)
    wave = np.column_stack([x, 2 * np.sin(np.pi * x / 8)])
    _vertex, there, _chain = compensate(wave)
    _vertex, back, _chain = compensate(wave[::-1])
    np.testing.assert_allclose(back[::-1], there, atol=1e-12)
    bend = find_bends(find_slopes(there[:-1], there[1:], measure_rows(np.diff(there, axis=0))))
    assert np.isfinite(bend).all()
