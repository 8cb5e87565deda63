"""Metric length: tip path and table rotation together, in mm."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array

#: Millimetres of path that one radian of rotation counts for: a typical distance of the tip from the axes of the table,
#: so that pure rotations have a length too.
ROTARY_METRIC_MM: Final = 50.0


def metric_length(delta: Array) -> Array:
    """Metric length (...) of differences (..., k) whose last two entries are table angles (rad), in mm."""
    return np.hypot(
        np.linalg.norm(delta[..., :-2], axis=-1), ROTARY_METRIC_MM * np.linalg.norm(delta[..., -2:], axis=-1)
    )
