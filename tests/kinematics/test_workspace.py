"""Verdicts on tips of a slice, and the curves of equal tilt."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from verne_post.base.rotations import find_axis_of_angles
from verne_post.kinematics.workspace import BELOW_TABLE, OUT_OF_REACH, classify

from ..builders import MACHINE, orientations

MODULE = MACHINE.module


@settings(max_examples=25)
@given(a=st.floats(-90, 90), c=st.floats(-170, 170), length=st.floats(0, 300), seed=st.integers(0, 2**32 - 1))
def test_classification_agrees_with_the_inverse_and_the_limits(a, c, length, seed):
    """Reached is: solved, inside every travel, drops above their least value, tip and nose not below the face."""
    tip = np.random.default_rng(seed).uniform([-700, -700, -400], [700, 700, 800], (40, 3))
    angles = np.radians([a, c])
    reach = classify(MACHINE, tip, angles, length)
    axis = np.broadcast_to(find_axis_of_angles(*angles), tip.shape)
    q, platform, ok = MACHINE.five_axis.solve(tip, np.broadcast_to(angles, (40, 2)), length)
    position, alpha = platform.position, platform.alpha
    if a > 1:  # the inverse answers with the table solution of positive tilt, at the pole with a C of its own
        other, solved = MACHINE.inverse(tip, axis, length)
        assert (solved == ok).all()
        assert other[ok][:, :3] == pytest.approx(q[ok][:, :3], abs=1e-6)
    limits = MACHINE.limits
    with np.errstate(invalid="ignore"):
        travel = ((q >= limits.lower) & (q <= limits.upper)).all(axis=1)
        drops = (MODULE.find_geometry_margins(position, alpha)[:, :3] >= limits.serial_singularity).all(axis=1)
    nose = tip + length * axis
    under = [(point[:, 2] < 0) & (np.hypot(point[:, 0], point[:, 1]) < MACHINE.table_radius) for point in (tip, nose)]
    assert reach.reached.tolist() == (ok & travel & drops & ~under[0] & ~under[1]).tolist()
    # random points are never so close to a limit that its slack of a nanometre decides
    named = np.array(reach.limits)[reach.broken]
    assert ((named == OUT_OF_REACH) == (~ok & ~reach.reached)).all()
    below = reach.broken == reach.limits.index(BELOW_TABLE)
    assert (under[0] | under[1])[below].all()
    for row in np.flatnonzero(reach.reached):
        rooms = np.minimum(q[row] - limits.lower, limits.upper - q[row]) * [1, 1, 1, 573.0, 573.0]
        drop = MODULE.find_geometry_margins(position, alpha)[row, :3].min() - limits.serial_singularity
        assert reach.margin[row] == pytest.approx(min(rooms.min(), drop), rel=1e-3)


def test_names_of_limits_follow_the_travel_of_the_axis():
    """Over the upper end of the sliders the spindle is low, z down; a tip lifted up leaves at the lower end."""
    high = classify(MACHINE, np.array([[0.0, 0.0, 800.0]]), np.zeros(2), 100.0)
    assert high.limits[high.broken[0]].endswith("at its lower end")
    assert high.margin[0] < 0
    low = classify(MACHINE, np.array([[0.0, 0.0, -5.0]]), np.zeros(2), 100.0)
    assert low.limits[low.broken[0]] == BELOW_TABLE
    far = classify(MACHINE, np.array([[2000.0, 0.0, 0.0]]), np.zeros(2), 100.0)
    assert far.limits[far.broken[0]] == OUT_OF_REACH
    assert np.isnan(far.margin[0])


# --- equation (8) --------------------------------------------------------------------------------


@given(alpha=st.floats(0.01, 3.13), turn=st.floats(0.02, 3.12))
def test_every_point_of_an_ellipse_may_tilt_by_its_alpha(alpha, turn):
    """Against the roots of (9), which are found another way; both signs, as Table I has them."""
    for angle in (turn, -turn):
        ((x, y),) = MODULE.trace_iso_alpha(alpha, np.array([angle]))
        tilts = np.array(orientations(x, y))
        for tilt in (alpha, -alpha):  # two of four roots may nearly be one, of which a root can tell 1e-7
            assert np.abs(tilts - tilt).min() < 1e-6


@given(alpha=st.floats(0.01, 0.75), turn=st.floats(0.5, 2.6))
def test_the_working_mode_tilts_towards_the_other_side(alpha, turn):
    """Every point that the machine solves tilts by +alpha for y < 0 and by -alpha for y > 0."""
    for angle, tilt in ((turn, -alpha), (-turn, alpha)):
        ((x, y),) = MODULE.trace_iso_alpha(alpha, np.array([angle]))
        _rho, found, ok = MODULE.inverse(np.array([x, y, 1000.0]))
        if ok:
            assert found == pytest.approx(tilt, abs=1e-9)


def test_ellipse_of_the_middle_is_solved_by_the_machine():
    """So that the test above cannot pass by never solving."""
    x, y = MODULE.trace_iso_alpha(0.3, np.linspace(2.0, 2.3, 5)).T
    _rho, alpha, ok = MODULE.inverse(np.stack([x, y, np.full(5, 1000.0)], axis=-1))
    assert ok.all()
    assert alpha == pytest.approx(-0.3, abs=1e-9)


def test_shapes_of_the_ellipses():
    """Without tilt it is the line y = 0, and where R1 cos(alpha) = r1 it is a circle (the paper, section VI)."""
    turn = np.linspace(0, 2 * np.pi, 9)
    assert MODULE.trace_iso_alpha(0.0, turn)[:, 1] == pytest.approx(0.0, abs=1e-12)
    circle = MODULE.trace_iso_alpha(MODULE.crossing_angle, turn) - [-MODULE.leg1_x_offset, 0.0]
    radius = np.sqrt(850.0**2 - (130.0**2 - 80.0**2))  # L1^2 - (R1^2 + r1^2 - 2 r1^2)
    assert np.hypot(*circle.T) == pytest.approx(radius, rel=1e-12)
