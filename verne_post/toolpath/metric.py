"""Metric length: tip path and table rotation together, in mm."""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.units import ROTARY_METRIC_MM


def measure_metric(delta: Array) -> Array:
    """Metric length (...) of differences (..., k) whose last two entries are table angles (rad), in mm."""
    return np.hypot(
        np.linalg.norm(delta[..., :-2], axis=-1), ROTARY_METRIC_MM * np.linalg.norm(delta[..., -2:], axis=-1)
    )
