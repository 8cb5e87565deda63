"""Which words a measured tool axis stands for, on a machine whose joints tell the axis alone."""

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.model.toolpath import ToolPath
from verne_post.verification.programmed import RADIAN_MM
from verne_post.verification.projection import Measured, project_tips

#: A tool axis this near to the pole (sine of its tilt) says nothing about C.
_UPRIGHT = 1e-12


def name_poses(path: ToolPath, segment: Ints, pose: Measured, noise: float, before: tuple[Mask, float]) -> Measured:
    """The same poses (n,), with the angles that their segments hold; see :func:`name_angles`."""
    folded = np.abs(pose.angles[:, 0]), pose.angles[:, 1] + np.where(pose.angles[:, 0] < 0, np.pi, 0.0)
    tips = project_tips(path, segment, pose, *before)
    angles = name_angles(path, segment, np.stack(folded, axis=1), tips, noise, before)
    return Measured(pose.q, pose.tip, angles, by_axis=True)


def name_angles(
    path: ToolPath, segment: Ints, angles: Array, tip: tuple[Array, Array], noise: float, before: tuple[Mask, float]
) -> Array:
    """Nominal angles (n, 2) of the same tool axes, on the side of the pole and the turn of their programmed segments.

    Parameters
    ----------
    segment : ndarray of int, shape (n,)
        Segment of each row.
    angles : ndarray, shape (n, 2)
        Measured, with A in [0, pi], rad.
    tip : tuple of ndarray, shape (n,)
        Where on their segments the tips are, 0 to 1, and their ways along these, mm; see ``project_tips``.
    before : tuple of ndarray of bool, shape (n,), and float
        Which rows are the first ones of their segments, and where on its segment the row before all of them is.
    noise : float
        Rad by which rounding of the joints may turn the tool axis. Near the pole that turns C by any angle. C is then
        that of the segment, as far as this is the same axis within the noise.
    """
    start, turn = path.start[segment, 3:], path.end[segment, 3:] - path.start[segment, 3:]
    along, way = tip
    # where only C moves, too far for the axis to tell, whole turns are counted from the first row of the segment
    fresh, u_before = before[0] | (np.arange(len(angles)) == 0), np.where(before[0], 0.0, before[1])
    first = np.maximum.accumulate(np.where(fresh, np.arange(len(angles)), 0))
    expected = (start[:, 1] + u_before * turn[:, 1])[first]
    found, least = angles.copy(), np.full(len(angles), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for side in (1.0, -1.0):
            tilt, c = side * angles[:, 0], angles[:, 1] + (0.0 if side > 0 else np.pi)
            # A and the tip tell where on the segment the row is, each by its way; without both, the middle is taken
            by_tilt = np.where(np.abs(turn[:, 0]) > noise, (RADIAN_MM * turn[:, 0]) ** 2, 0.0)
            both = np.where(by_tilt > 0, by_tilt * np.clip((tilt - start[:, 0]) / turn[:, 0], 0.0, 1.0), 0.0)
            both += way**2 * np.clip(along, 0.0, 1.0)
            unknown = by_tilt + way**2 == 0.0
            share = np.where(unknown, 0.5, both / (by_tilt + way**2))
            wanted = start[:, 1] + share * turn[:, 1]
            wide = np.abs(turn[:, 1]) >= np.pi
            off = c - wanted - 2 * np.pi * np.round((c - wanted) / (2 * np.pi))
            slack = np.minimum(noise / np.maximum(np.sin(angles[:, 0]), _UPRIGHT), np.pi)
            counted = c - 2 * np.pi * np.round((c[first] - expected) / (2 * np.pi))
            off = np.where(wide & unknown, counted - wanted, off - np.clip(off, -slack, slack))
            # a C that nothing tells the place of is as good anywhere on the segment
            aside = np.where(unknown, np.maximum(np.abs(off) - 0.5 * np.abs(turn[:, 1]), 0.0), np.abs(off))
            away = aside + np.maximum(np.abs(tilt - start[:, 0] - share * turn[:, 0]) - noise, 0.0)
            better = away < least
            found[better] = np.stack([tilt, wanted + off], axis=1)[better]
            least = np.minimum(least, away)
    return found
