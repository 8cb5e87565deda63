"""What modules have in common: margins of rods, positions of a platform that never tilts."""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.model.protocols import Margin


def place_upright(pivot: Array, gauge: Array) -> Array:
    """Platform point (..., 3) of a module that never tilts, base frame: ``pivot + F gauge``, F = diag(1, -1, -1)."""
    return np.asarray(gauge, dtype=float) * [1.0, -1.0, -1.0] + np.asarray(pivot, dtype=float)


def make_triple(values: Array) -> tuple[float, float, float]:
    """Three numbers of an array (3,)."""
    a, b, c = (float(value) for value in values)
    return a, b, c


def drop_margins(actuators: tuple[str, ...], smallest: float) -> tuple[Margin, ...]:
    """Margins of the vertical drops of the rods, one for each actuator: an error below ``smallest`` (mm)."""
    return tuple(Margin("vertical drop of a rod", "VP202", joint, "mm", smallest, 2 * smallest) for joint in actuators)


def build_determinant_margin(smallest: float) -> Margin:
    """Margin of the scaled parallel determinant: an error below ``smallest``, without a unit; 0 at the singularity."""
    return Margin("distance from the parallel singularity", "VP203", None, "", smallest, 2 * smallest)
