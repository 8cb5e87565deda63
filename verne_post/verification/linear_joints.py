"""Segments of a nutating pair whose joints are linear: the joints that measured angles stand for, and the angles at u.

Independent of the tool path's evaluation: by the tool axis itself, turned about both directions.
"""

import numpy as np

from verne_post.base.arrays import Array, Ints
from verne_post.model.toolpath import ToolPath


def find_rows(path: ToolPath, segment: Ints) -> Ints:
    """Which of segments (n,) they are; -1 is none."""
    if not len(path.circles.angle):
        return np.empty(0, dtype=np.intp)
    return np.flatnonzero(
        (segment >= 0) & (path.circle[segment] >= 0) & np.isfinite(path.circles.joints[path.circle[segment], 0])
    )


def find_lines(path: ToolPath, segment: Ints, angles: Array) -> tuple[Array, Array, Array]:
    """Coordinates (n, 2) in which segments (n,) turn linearly: those of angles (n, 2), of the starts, and changes.

    Nominal A and C, or the joint angles d and t of a nutating pair.
    """
    start, now = path.start[segment, 3:], angles
    delta = path.end[segment, 3:] - start
    if len(rows := find_rows(path, segment)):
        d0, t0, d1, t1, near, far = path.circles.joints[path.circle[segment[rows]]].T
        tilt, c = angles[rows].T
        cosine = (np.cos(tilt) - np.cos(near) * np.cos(far)) / (np.sin(near) * np.sin(far))
        d = np.copysign(np.arccos(np.clip(cosine, -1.0, 1.0)), tilt)
        now = angles.copy()
        now[rows] = np.stack([d, c - _find_shift(_find_axis(d, near, far), d)], axis=1)
        start[rows], delta[rows] = np.stack([d0, t0], axis=1), np.stack([d1 - d0, t1 - t0], axis=1)
    return now, start, delta


def find_angles(path: ToolPath, segment: Ints, u: Array) -> Array:
    """Nominal angles (n, 2) at u (n,) of segments whose joints are linear."""
    d0, t0, d1, t1, near, far = path.circles.joints[path.circle[segment]].T
    d = d0 + u * (d1 - d0)
    axis = _find_axis(d, near, far)
    tilt = np.copysign(np.arctan2(np.hypot(axis[0], axis[1]), axis[2]), d)
    return np.stack([tilt, t0 + u * (t1 - t0) + _find_shift(axis, d)], axis=1)


def _find_axis(d: Array, near: Array, far: Array) -> Array:
    """The tool axis (3, n) at d with t = 0, turned about (sin a, 0, cos a)."""
    along, across = np.cos(far), np.sin(far)
    return np.stack(
        [
            along * np.sin(near) - across * np.cos(near) * np.cos(d),
            across * np.sin(d),
            along * np.cos(near) + across * np.sin(near) * np.cos(d),
        ]
    )


def _find_shift(axis: Array, d: Array) -> Array:
    """C - t (n,) of tool axes (3, n); at a pole, which has none, 0."""
    side = np.copysign(1.0, d)
    upright = np.hypot(axis[0], axis[1]) < _UPRIGHT
    return np.where(upright, 0.0, np.arctan2(side * axis[0], side * axis[1]))


#: Below this sine of the tilt the direction of the tool axis across z is rounding.
_UPRIGHT = 1e-12
