"""Rows of a retimed profile against the profile itself: none is left out but those that creep."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from verne_post.trajectory import tuning
from verne_post.trajectory.continuous import _is_too_far, sample_rows
from verne_post.trajectory.section_path import SectionTask
from verne_post.trajectory.spline_profile import Profile, Times

from .curves import Curve, limits, straight

CYCLE = 1e-3


def smooth(n: int) -> np.ndarray:
    w = np.linspace(0.0, 1.0, n)
    return w**4 * (35 - 84 * w + 70 * w**2 - 20 * w**3)


@pytest.mark.parametrize("rate", [1.0, 9.0])  # dsigma/dt; the faster one moves far in its last cycle too
@pytest.mark.parametrize("slower", [1.0, 1.37])
@pytest.mark.parametrize("length", [0.5, 20.0])
# the second moves far in its first cycle, the third has too few rows to leave one out
@pytest.mark.parametrize(("samples", "step"), [(80, 2e-3), (20, 1e-3), (2, 1e-3)])
def test_rows_are_the_profile_at_whole_cycles(
    length: float, slower: float, samples: int, step: float, rate: float
) -> None:
    section, top = straight(length), limits(3)
    profile = Profile.build_from_samples(length * smooth(samples), step)
    knots = int(np.ceil(profile.duration / 4e-3))
    times = Times.build_from_coefficients(np.full(knots + 3, rate**2), profile.duration / knots)
    rows = sample_rows(SectionTask(section, top, CYCLE, CYCLE), profile, times, slower)
    cycles = int(np.ceil(times.total * slower / CYCLE - 1e-9))
    expected = profile.find_s(np.linspace(0.0, profile.duration, cycles + 1))
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


@dataclass(frozen=True)
class Hiding(Curve):
    """Steps of which the last one is so many times too long to show the path."""

    times_too_long: float = 0.0

    def measure_hidden(self, s: np.ndarray) -> np.ndarray:
        return np.append(np.zeros(len(s) - 2), self.times_too_long)


def ending(feed: float | Callable[[np.ndarray], np.ndarray] = np.inf, times_too_long: float = 0.0) -> Hiding:
    return Hiding(10.0, lambda s: [s], feed, times_too_long=times_too_long)


def test_a_step_that_hides_the_path_is_too_far() -> None:
    rows = np.array([0.0, 1.0, 2.0])
    assert not _is_too_far(ending(times_too_long=1.0), rows, CYCLE)
    assert _is_too_far(ending(times_too_long=1.01), rows, CYCLE)


@pytest.mark.parametrize("slow", [3.0, 3.5, 4.0])
def test_a_step_is_too_far_for_the_slowest_feed_along_it(slow: float) -> None:
    """At its begin, in its middle or at its end; what may be left out at either end of it is allowed besides."""
    section = ending(lambda s: np.where(np.abs(s - slow) < 0.01, 500.0, 5000.0))
    for share in (0.99, 1.01):  # of the longest step at that feed, by cycles that are shorter
        cycle = 1.0 / (500.0 * (1.0 + 2 * tuning.CREEPING_MOTION) * share)
        assert _is_too_far(section, np.array([0.0, 3.0, 4.0]), cycle) == (share > 1.0)


@pytest.mark.parametrize("samples", [7, 30])  # the fewest of which some may be left out, and many
def test_all_rows_that_creep_are_left_out_where_the_next_ones_may_follow_the_ends(samples: int) -> None:
    """The first row of the profile creeps, the second may follow the start, the third is too far; the same
    backwards.
    """
    profile = Profile.build_from_samples(20.0 * smooth(samples), CYCLE)
    cycles = int(np.ceil(profile.duration / CYCLE - 1e-9))
    expected = profile.find_s(CYCLE * np.arange(cycles + 1.0))
    moving = int(np.argmax(expected > 1e-9))
    first = next(k for k in range(moving, cycles) if expected[k + 1] > 9 * expected[k] > 0)
    feed = expected[first + 1] / (0.9 * CYCLE)  # a step from the start to the row after it takes 0.9 of it
    assert expected[first] < tuning.CREEPING_MOTION * feed * CYCLE
    assert expected[first + 2] > 1.2 * feed * CYCLE
    wide = limits(3, velocity=1e9, acceleration=1e12, jerk=1e15)
    times = Times.build_from_coefficients(np.ones(cycles + 3), profile.duration / cycles)
    rows = sample_rows(SectionTask(straight(20.0, feed), wide, CYCLE, CYCLE), profile, times)
    assert rows[1] == pytest.approx(expected[first + 1])
    assert 20.0 - rows[-2] == pytest.approx(20.0 - expected[cycles - first - 1])
