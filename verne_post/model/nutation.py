"""A rotary pair that is not at right angles: how its joints hold the nominal angles of a tool axis.

In the polar frame (z along u1, the direction of the joint nearest the part) the other joint turns about ``(sin a, 0,
cos a)``, and the tool axis is at the angle b to that direction. With d the angle of that joint, 0 where the tool axis
is nearest z, and t that of the joint about z, the tool axis is (sin A sin C, sin A cos C, cos A) with

    sin^2(A/2) = sin^2((a-b)/2) + sin a sin b sin^2(d/2),      A has the sign of d,
    C = t + atan2(e / s + cos a s, cos(d/2)),       s = sin(d/2),       e = sin(a-b) / (2 sin b).

So (-A, C + 180) is the other solution, as on every pair, and A is bounded: |a - b| <= |A| <= pi - |pi - a - b|. At the
upper bound, d = 180 degrees, both solutions meet: the *fold*. Where a = b, d = 0 is a pole; else it is a fold too. All
angles in rad.
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array

#: A tilt may be beyond the reach by this, rad: tilts are kept to 1e-12, vectors of a program to six decimals at best.
REACH_SLACK: Final = 1e-10
#: A joint this near to the fold, rad, is at it. Its tilt is then put beyond the reach by a tenth of the slack, so that
#: rounding the tilt does not move the joint: there 1e-12 of tilt are 1e-6 of the joint.
_AT_FOLD: Final = 1e-9


class Nutation(Struct, frozen=True):
    """Joint angles and nominal angles of a nutating pair."""

    near: float  #: a: from z of the polar frame to the direction of the tilting joint.
    far: float  #: b: from there to the tool axis; equal to a where the pair has a pole.
    home: float  #: d with the tilting joint at 0.

    @property
    def reach(self) -> tuple[float, float]:
        """The smallest and the largest tilt of the tool axis against z."""
        return abs(self.near - self.far), np.pi - abs(np.pi - self.near - self.far)

    def measure_miss(self, tilt: Array) -> Array:
        """How far tilts (...) are outside the reach; 0 within it and its slack."""
        low, high = self.reach
        size = np.abs(tilt)
        miss = np.maximum(size - high, low - size)
        return np.where(miss > REACH_SLACK, miss, 0.0)

    def find_joints(self, angles: Array) -> Array:
        """Joint angles (..., 2) that hold nominal angles (..., 2): the tilting one from its 0, and t.

        Beyond the fold the joint goes on as far as A is beyond the reach: a travel that ends before says no.
        """
        return self.find_turns(angles) - [self.home, 0.0]

    def find_turns(self, angles: Array) -> Array:
        """The same, d and t: the tilting one from where the tool axis is nearest z."""
        joint = self._find_joint(angles[..., 0])
        shift = find_shift(np.clip(joint, -np.pi, np.pi), self.near, self.far)
        return np.stack([joint, angles[..., 1] - shift], axis=-1)

    def _find_joint(self, tilt: Array) -> Array:
        """The angle d (...) of tilts (...)."""
        low, high = self.reach
        size = np.abs(tilt)
        inside, apart, both = np.clip(size, low, high), self.near - self.far, self.near + self.far
        rise = np.sin(0.5 * (inside + apart)) * np.sin(0.5 * (inside - apart))
        rest = np.sin(0.5 * (both + inside)) * np.sin(0.5 * (both - inside))
        joint = 2.0 * np.arctan2(np.sqrt(np.maximum(rise, 0.0)), np.sqrt(np.maximum(rest, 0.0)))
        joint = np.where(size >= high, np.pi, np.where(size <= low, 0.0, joint))  # not by the root of a rounding
        beyond = size - high
        return np.copysign(joint + np.where(beyond > REACH_SLACK, beyond, 0.0), tilt)

    def find_angles(self, joints: Array) -> Array:
        """Nominal angles (..., 2) of joint angles (..., 2); inverse of :meth:`find_joints`."""
        joint = joints[..., 0] + self.home
        beyond = np.abs(joint) - np.pi
        tilt = find_tilt(np.clip(joint, -np.pi, np.pi), self.near, self.far)
        more = np.where(beyond > _AT_FOLD, beyond, np.where(beyond > -_AT_FOLD, 0.1 * REACH_SLACK, 0.0))
        if self.near != self.far:
            more = np.where(np.abs(joint) < _AT_FOLD, -0.1 * REACH_SLACK, more)
        shift = find_shift(np.clip(joint, -np.pi, np.pi), self.near, self.far)
        return np.stack([tilt + np.copysign(more, joint), joints[..., 1] + shift], axis=-1)

    def find_rates(self, angles: Array) -> tuple[Array, Array]:
        """Derivatives (...) of both joint angles by the nominal tilt of angles (..., 2). Infinite at folds.

        By C they are 0 and 1.
        """
        tilt, joint = angles[..., 0], self._find_joint(angles[..., 0])
        s, c = np.sin(0.5 * joint), np.cos(0.5 * joint)
        k, e = np.cos(self.near), _find_rise(self.near, self.far)
        with np.errstate(divide="ignore", invalid="ignore"):
            inner = e / s if e else np.zeros_like(s)
            grows = 0.5 * (k + (e - (inner * c) ** 2 / e if e else 0.0)) / ((inner + k * s) ** 2 + c**2)
            # sin A / (sin a sin b sin d), where both sines vanish at a pole
            rate = (
                np.cos(0.5 * tilt) / (np.sin(self.near) * c)
                if not e
                else (np.sin(tilt) / (2.0 * np.sin(self.near) * np.sin(self.far) * s * c))
            )
        return rate, -grows * rate

    def measure_fold(self, tilting: Array) -> Array:
        """How far the tilting joint (...), from its 0, is from the next fold; negative beyond it."""
        size = np.abs(tilting + self.home)
        return np.pi - size if self.near == self.far else np.minimum(np.pi - size, size)


def find_tilt(joint: Array, near: Array | float, far: Array | float) -> Array:
    """A (...) of joint angles d (...), with its sign; beyond the fold as the tool axis goes."""
    s, c = np.sin(0.5 * joint), np.cos(0.5 * joint)
    size = np.sin(near) * np.sin(far)
    rise = np.sin(0.5 * (near - far)) ** 2 + size * s**2
    rest = np.cos(0.5 * (near + far)) ** 2 + size * c**2
    return np.copysign(2.0 * np.arctan2(np.sqrt(rise), np.sqrt(rest)), joint)


def find_shift(joint: Array, near: Array | float, far: Array | float) -> Array:
    """C - t (...) of joint angles d (...)."""
    s, c = np.sin(0.5 * joint), np.cos(0.5 * joint)
    rise = _find_rise(near, far)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.arctan2(np.where(rise == 0.0, 0.0, rise / s) + np.cos(near) * s, c)


def _find_rise(near: Array | float, far: Array | float) -> Array:
    """e; exactly 0 at a pole."""
    return np.asarray(np.sin(near - far) / (2.0 * np.sin(far)))
