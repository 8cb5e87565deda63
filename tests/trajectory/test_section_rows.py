"""Rows of a retimed profile against the profile itself: none is left out but those that creep."""

import numpy as np
import pytest

from verne_post.trajectory import tuning
from verne_post.trajectory.section_path import SectionTask
from verne_post.trajectory.section_rows import sample_rows
from verne_post.trajectory.spline_profile import Profile, Times

from .curves import limits, straight

CYCLE = 1e-3


def smooth(n: int) -> np.ndarray:
    w = np.linspace(0.0, 1.0, n)
    return w**4 * (35 - 84 * w + 70 * w**2 - 20 * w**3)


@pytest.mark.parametrize("slower", [1.0, 1.37])
@pytest.mark.parametrize("length", [0.5, 20.0])
@pytest.mark.parametrize(("samples", "step"), [(80, 2e-3), (20, 1e-3)])  # the second moves far in its first cycle
def test_rows_are_the_profile_at_whole_cycles(length: float, slower: float, samples: int, step: float) -> None:
    section, top = straight(length), limits(3)
    profile = Profile.of_samples(length * smooth(samples), step)
    knots = int(np.ceil(profile.duration / 4e-3))
    # dsigma/dt = 1: time is pseudo-time
    times = Times.of_coefficients(np.ones(knots + 3), profile.duration / knots)
    rows = sample_rows(SectionTask(section, top, CYCLE, CYCLE), profile, times, slower)
    cycles = int(np.ceil(times.total * slower / CYCLE - 1e-9))
    expected = profile.s(np.linspace(0.0, profile.duration, cycles + 1))
    assert (rows[0], rows[-1]) == (0.0, length)
    # each row in between is one of the profile's, in their order, none left out
    first = int(np.argmin(np.abs(expected - rows[1])))
    assert np.allclose(rows[1:-1], expected[first : first + len(rows) - 2], atol=1e-9 * length)
    # those left out at both ends stay within a share of what the joints can move in a cycle from rest
    least = tuning.CREEPING_MOTION * min(1e5 * CYCLE**3, 5000 * CYCLE**2)
    left = expected[1:first], expected[first + len(rows) - 2 : -1]
    assert (left[0] < least).all()
    assert (length - left[1] < least).all()
    assert expected[first] >= least or first == 1
