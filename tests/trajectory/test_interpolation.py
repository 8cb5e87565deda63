"""Splines and sliding windows of the planner against scipy's."""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline
from scipy.ndimage import minimum_filter1d, uniform_filter1d

from verne_post.trajectory.interpolation import average_around, find_lowest_around, interpolate


@pytest.mark.parametrize("count", [3, 4, 5, 6, 7, 8, 40])
@pytest.mark.parametrize("even", [True, False])
def test_splines_are_those_of_scipy(count: int, even: bool) -> None:
    rng = np.random.default_rng(count)
    x = 7.0 + (np.arange(count, dtype=float) if even else np.cumsum(rng.uniform(0.2, 2.0, count)))
    y = np.cumsum(rng.uniform(0.0, 1.0, count))
    at = np.concatenate([x, rng.uniform(x[0] - 0.3, x[-1] + 0.3, 100)])
    expected = make_interp_spline(x, y, k=min(5, count - 1))(at)
    np.testing.assert_allclose(interpolate(x, y, at), expected, rtol=1e-10)
    np.testing.assert_allclose(interpolate(x, y, x), y, rtol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 9, 50])
@pytest.mark.parametrize("reach", [0, 1, 2, 7, 60])
def test_windows_are_those_of_scipy(count: int, reach: int) -> None:
    values = np.random.default_rng(count).normal(size=count)
    width = 2 * reach + 1
    np.testing.assert_array_equal(find_lowest_around(values, reach), minimum_filter1d(values, width, mode="nearest"))
    np.testing.assert_allclose(
        average_around(values, reach), uniform_filter1d(values, width, mode="nearest"), rtol=0, atol=1e-14
    )
