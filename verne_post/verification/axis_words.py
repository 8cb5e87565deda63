"""Which words a measured tool axis stands for, on a machine whose joints tell the axis alone."""

import numpy as np

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.model.toolpath import ToolPath
from verne_post.verification.programmed import RADIAN_MM, find_on_circles, find_programmed_pose
from verne_post.verification.projection import Measured, project_onto_straight, project_tips

#: A tool axis this near to the pole (sine of its tilt) says nothing about C.
_UPRIGHT = 1e-12


def name_poses(path: ToolPath, segment: Ints, pose: Measured, bound: float, before: tuple[Mask, float]) -> Measured:
    """The same poses (n,), with the angles that their segments hold; see :func:`_name_angles`."""
    folded = np.abs(pose.angles[:, 0]), pose.angles[:, 1] + np.where(pose.angles[:, 0] < 0, np.pi, 0.0)
    measured, tips = np.stack(folded, axis=1), project_tips(path, segment, pose, *before)
    angles = _name_angles(path, segment, measured, tips, bound, before)
    on_circle = find_on_circles(path, segment)
    if len(on_circle):
        u = project_onto_straight(path, segment[on_circle], pose.select(on_circle), RADIAN_MM)
        angles[on_circle] = _name_on_circles(path, segment[on_circle], measured[on_circle], u, bound)
    return Measured(pose.q, pose.tip, angles, by_axis=True, told=pose.axis)


def _name_on_circles(path: ToolPath, segment: Ints, angles: Array, u: Array, bound: float) -> Array:
    """As :func:`_name_angles`, at u (n,) of great circles, along which A keeps its sign but goes by no line."""
    wanted = find_programmed_pose(path, segment, np.clip(u, 0.0, 1.0))[1]
    negative = path.start[segment, 3] < 0
    off = angles[:, 1] + np.where(negative, np.pi, 0.0) - wanted[:, 1]
    off -= 2 * np.pi * np.round(off / (2 * np.pi))
    slack = find_slack(angles, bound)
    return np.stack(
        [np.where(negative, -1.0, 1.0) * angles[:, 0], wanted[:, 1] + np.where(np.abs(off) <= slack, 0.0, off)], axis=1
    )


def find_slack(angles: Array, bound: float) -> Array:
    """How far C (n,) may be turned while the tool axis stays within the bound (rad): by any angle near the pole."""
    share = bound / np.maximum(np.abs(np.sin(angles[:, 0])), _UPRIGHT)
    return np.where(share < 1.0, np.arcsin(np.minimum(share, 1.0)), np.pi)


def _name_angles(
    path: ToolPath, segment: Ints, angles: Array, tip: tuple[Array, Array], bound: float, before: tuple[Mask, float]
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
    bound : float
        How far (rad) the words may be from the tool axis, as rounding of the joints turns it. Near the pole this is any
        C. C is that of the segment, as far as this is the same axis within the bound.
    """
    start, turn = path.start[segment, 3:], path.end[segment, 3:] - path.start[segment, 3:]
    along, way = tip
    # where only C moves, too far for the axis to tell, whole turns are counted from the first row of the segment
    fresh, u_before = before[0] | (np.arange(len(angles)) == 0), np.where(before[0], 0.0, before[1])
    first = np.maximum.accumulate(np.where(fresh, np.arange(len(angles)), 0))
    expected = (start[:, 1] + u_before * turn[:, 1])[first]
    slack = find_slack(angles, bound)
    # along a spline C goes by no line: there only the pole leaves it open
    slack[(path.spline[segment] >= 0) & (slack < np.pi)] = 0.0
    found, least = angles.copy(), np.full(len(angles), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for side in (1.0, -1.0):
            tilt, c = side * angles[:, 0], angles[:, 1] + (0.0 if side > 0 else np.pi)
            # A and the tip tell where on the segment the row is, each by its way; without both, the middle is taken
            by_tilt = np.where(np.abs(turn[:, 0]) > bound, (RADIAN_MM * turn[:, 0]) ** 2, 0.0)
            both = np.where(by_tilt > 0, by_tilt * np.clip((tilt - start[:, 0]) / turn[:, 0], 0.0, 1.0), 0.0)
            both += way**2 * np.clip(along, 0.0, 1.0)
            unknown = by_tilt + way**2 == 0.0
            share = np.where(unknown, 0.5, both / (by_tilt + way**2))
            wanted = start[:, 1] + share * turn[:, 1]
            wide = np.abs(turn[:, 1]) >= np.pi
            off = c - wanted - 2 * np.pi * np.round((c - wanted) / (2 * np.pi))
            counted = c - 2 * np.pi * np.round((c[first] - expected) / (2 * np.pi))
            # a C that nothing tells the place of is as good anywhere on the segment
            half = np.where(unknown, 0.5 * np.abs(turn[:, 1]), 0.0)
            aside = np.where(wide & unknown, np.abs(counted - wanted), np.maximum(np.abs(off) - slack, 0.0))
            away = np.maximum(aside - half, 0.0) + np.abs(tilt - start[:, 0] - share * turn[:, 0])
            # C tells the place too, by the way of the tool axis: away from the pole more than a tip that hardly moves
            by_turn = (RADIAN_MM * np.sin(angles[:, 0]) * turn[:, 1]) ** 2
            on = np.where(by_turn > 0, np.clip((wanted + off - start[:, 1]) / turn[:, 1], 0.0, 1.0), 0.0)
            share = np.where(unknown, on, (both + by_turn * on) / (by_tilt + way**2 + by_turn))
            beside = wanted + off - start[:, 1] - share * turn[:, 1]
            named = wanted + off - np.where(np.abs(beside) <= slack, beside, 0.0)
            named = np.where(wide & unknown, counted, named)
            better = away < least
            found[better] = np.stack([tilt, named], axis=1)[better]
            least = np.minimum(least, away)
    return found
