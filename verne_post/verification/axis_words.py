"""Which words a measured tool axis stands for, on a machine whose joints tell the axis alone."""

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.model.toolpath import ToolPath

#: A tool axis this near to the pole (sine of its tilt) says nothing about C.
_UPRIGHT = 1e-12


def name_angles(path: ToolPath, segment: Ints, angles: Array, along: Array, noise: float) -> Array:
    """Nominal angles (n, 2) of the same tool axes, on the side of the pole and the turn of their programmed segments.

    Parameters
    ----------
    segment : ndarray of int, shape (n,)
        Segment of each row.
    angles : ndarray, shape (n, 2)
        Measured, with A in [0, pi], rad.
    along : ndarray, shape (n,)
        Where on their segments the tips are, 0 to 1; NaN where they do not say.
    noise : float
        What rounding of the joints may turn the tool axis by, rad. Near the pole that turns C by any angle: C is what the segment
        has, as far as that is the same axis but for this noise.
    """
    start, turn = path.start[segment, 3:], path.end[segment, 3:] - path.start[segment, 3:]
    found, least = angles.copy(), np.full(len(angles), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for side in (1.0, -1.0):
            tilt, c = side * angles[:, 0], angles[:, 1] + (0.0 if side > 0 else np.pi)
            # where A turns it says where on the segment the row is; where it stands, the tip; without both the middle
            share = np.where(np.abs(turn[:, 0]) > noise, (tilt - start[:, 0]) / turn[:, 0], along)
            unknown = np.isnan(share)
            share = np.clip(np.where(unknown, 0.5, share), 0.0, 1.0)
            wanted = start[:, 1] + share * turn[:, 1]
            wide = np.abs(turn[:, 1]) >= np.pi
            off = c - wanted - 2 * np.pi * np.round((c - wanted) / (2 * np.pi))
            slack = np.minimum(noise / np.maximum(np.sin(angles[:, 0]), _UPRIGHT), np.pi)
            off = np.where(wide & unknown, c - wanted, off - np.clip(off, -slack, slack))
            away = np.abs(off) + np.maximum(np.abs(tilt - start[:, 0] - share * turn[:, 0]) - noise, 0.0)
            better = away < least
            found[better] = np.stack([tilt, wanted + off], axis=1)[better]
            least = np.minimum(least, away)
    return found
