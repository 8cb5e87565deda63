"""Forward kinematics without closed form: the pose at which a platform's actuators hold it, by Newton from home.

Where Newton from home does not close, the actuators are led there from home in steps, which keeps the assembly. Poses
are rows of numbers, whose meaning is the mechanism's own.
"""

from typing import Final, Protocol

import numpy as np

from verne_post.base.arrays import Array, Mask

#: Newton steps at most.
STEPS: Final = 30
#: Newton ends with a step of this share of the mechanism's size: the next one would be its square, beyond all digits.
STILL: Final = 1e-9
#: Steps of the actuators from home.
WALK: Final = 16
#: Rows solved together: their arrays stay in the cache.
BLOCK: Final = 2048


class Held(Protocol):
    """A platform that actuators hold."""

    def find_first(self) -> tuple[Array, Array]:
        """The pose (k,) of home, and its actuators (m,)."""

    def differentiate(self, pose: Array, values: Array) -> tuple[Array, Array]:
        """Square matrices (n, r, r) and misfits (n, r): Newton's equations at poses (n, k) and actuators (n, m)."""

    def move_back(self, pose: Array, step: Array) -> tuple[Array, Array]:
        """Poses (n, k) less steps (n, r), which may be shortened, and sizes (n,) of these over the mechanism's."""

    def is_closed(self, pose: Array, values: Array) -> Mask:
        """Whether poses (n, k) belong to actuators (n, m), and are the machine's."""


@np.errstate(all="ignore")
def find_poses(held: Held, values: Array) -> tuple[Array, Mask]:
    """Poses (n, k) at actuators (n, m), in the assembly of home, NaN if not ok; and ok (n,)."""
    first = held.find_first()[0]
    poses, ok = np.tile(first, (len(values), 1)), np.zeros(len(values), dtype=bool)
    for begin in range(0, len(values), BLOCK):
        part = slice(begin, begin + BLOCK)
        poses[part] = settle(held, poses[part], values[part])
        ok[part] = held.is_closed(poses[part], values[part])
    far = np.flatnonzero(~ok & np.isfinite(values).all(axis=-1))
    if len(far):
        poses[far] = follow_from_home(held, values[far])
        ok[far] = held.is_closed(poses[far], values[far])
    poses[~ok] = np.nan
    return poses, ok


def follow_from_home(held: Held, end: Array) -> Array:
    """Poses (n, k) at actuators (n, m), led there from home in steps of the actuators."""
    first, start = held.find_first()
    poses = np.tile(first, (len(end), 1))
    for share in np.arange(1, WALK + 1) / WALK:
        poses = settle(held, poses, start + share * (end - start))
    return poses


@np.errstate(all="ignore")
def settle(held: Held, poses: Array, values: Array) -> Array:
    """Newton from poses (n, k) on at actuators (n, m); rows that cannot move on stay."""
    going, poses = np.arange(len(poses)), poses.copy()
    for _ in range(STEPS):
        step = _solve(*held.differentiate(poses[going], values[going]))
        sound = np.isfinite(step).all(axis=-1)
        if not sound.all():
            going, step = going[sound], step[sound]
        poses[going], size = held.move_back(poses[going], step)
        going = going[size > STILL]
        if not len(going):
            break
    return poses


def _solve(matrix: Array, right: Array) -> Array:
    """Solutions (n, r); NaN where the matrix is singular."""
    try:
        return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
    except np.linalg.LinAlgError:  # one of them
        determinant = np.linalg.det(matrix)
        sound = np.isfinite(determinant) & (determinant != 0.0)
        step = np.full_like(right, np.nan)
        step[sound] = np.linalg.solve(matrix[sound], right[sound, :, None])[..., 0]
        return step
