"""A pair of rotary joints as polar angles of the tool axis: nominal A and C in a frame of their own.

Let u1 be the direction of the rotary joint nearest the part, u2 that of the other, w0 the tool axis at home, and phi
the motions of the tool against the part. The tool axis in directions of the part at home is ``R(u1, phi1) R(u2, phi2)
w0``, wherever the joints are. Where u1, u2 and u2, w0 are at right angles, these are polar angles about u1: in the
*polar frame* with z along u1 and x along u2 the axis is ``(sin A sin C, sin A cos C, cos A)`` with ``A = A0 - phi2``
and ``C = -phi1``. Where they are not, the pair nutates: x lies under u2, and
:class:`~verne_post.model.nutation.Nutation` has A and C of the joints.
"""

import math
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.model.nutation import Nutation

#: Directions whose angle differs from a right one by less (rad) are at right angles: digits of a file.
RIGHT_ANGLE: Final = math.radians(1e-6)
#: Directions nearer to a right angle than this (rad), but not at one, are a typing error, or were measured.
NEARLY_RIGHT: Final = math.radians(0.5)
#: Directions are parallel where the sine of their angle is smaller.
PARALLEL: Final = 1e-9


class PolarPair(Struct, frozen=True, eq=False):
    """The polar frame of a rotary pair."""

    directions: Array  #: (3, 3): Rows: x, y, z of the polar frame, in the part frame at home.
    #: tilt_sign, turn_sign: Signs of joint values against the tool's motion about u2, u1: ``q = sign * phi``. At
    #: right angles A = A0 + q, C = q.
    tilt_sign: float
    turn_sign: float
    home_tilt: float  #: A0: nominal A of the tool axis with both joints at 0, rad.
    nutation: Nutation | None = None  #: What A and C have to do with the joints where the pair is not at right angles.

    @property
    def lean(self) -> float:
        """Angle of the tilting joint's direction over x of the polar frame, rad: 0 at right angles."""
        return 0.0 if self.nutation is None else 0.5 * math.pi - self.nutation.near

    def find_joints(self, angles: Array) -> Array:
        """Rotary joints inside (..., 2) of nominal angles (..., 2)."""
        if self.nutation is None:
            return angles - [self.home_tilt, 0.0]
        return self.nutation.find_joints(angles)

    def find_angles(self, joints: Array) -> Array:
        """Inverse of :meth:`find_joints`."""
        if self.nutation is not None:
            return self.nutation.find_angles(joints)
        angles = np.array(joints)
        angles[..., 0] += self.home_tilt
        return angles


def build_pair(turn: Array, tilt: Array, axis: Array, preferred: float) -> PolarPair:
    """The polar frame of a pair; all directions in the part frame at home.

    Parameters
    ----------
    turn, tilt : ndarray, shape (3,)
        u1, of the rotary joint nearest the part, and u2, of the other; unit vectors.
    axis : ndarray, shape (3,)
        w0, from tip to spindle; a unit vector.
    preferred : float
        Sign of phi2 on the side of the pole that tool vectors take first, where both are alike: nominal A > 0.

    Raises
    ------
    ValueError
        In a sentence: the pair cannot point the tool, or its directions look measured.
    """
    nutates = False
    for one, other, names in (
        (turn, tilt, "the two rotary joints are"),
        (tilt, axis, "the rotary joint farther from the part and the tool axis are"),
    ):
        sine, cosine = float(np.linalg.norm(np.cross(one, other))), float(one @ other)
        if sine < PARALLEL:
            raise ValueError(f"{names} parallel: the pair cannot point the tool")
        away = abs(math.atan2(cosine, sine))
        if RIGHT_ANGLE < away < NEARLY_RIGHT:
            angle = math.degrees(math.atan2(sine, cosine))
            raise ValueError(
                f"{names} at {angle:.6g} degrees, not at a right angle: give them as drawn, not as measured"
            )
        nutates |= away > RIGHT_ANGLE
    # the pole to the side of z of the part, else of x, else of y
    turn_side = math.copysign(1.0, next(size for size in turn[[2, 0, 1]].tolist() if abs(size) > PARALLEL))
    if nutates:
        return _build_nutating_pair(turn, tilt, axis, preferred)
    z = turn_side * turn
    x = -preferred * tilt
    home_tilt = math.atan2(float(axis @ np.cross(z, x)), float(axis @ z))
    if abs(home_tilt) <= RIGHT_ANGLE:  # digits of directions that are not exact in binary
        home_tilt = 0.0
    elif home_tilt < 0.0:  # all joints at 0 is the side that is taken first
        preferred, x, home_tilt = -preferred, -x, -home_tilt
    return PolarPair(np.stack([x, np.cross(z, x), z]) + 0.0, preferred, -turn_side, home_tilt)


def _build_nutating_pair(turn: Array, tilt: Array, axis: Array, preferred: float) -> PolarPair:
    """The same for a pair that is not at right angles: z on the side where the tool axis comes nearest to u1."""
    apart = (
        abs(_measure_angle(turn, tilt) - _measure_angle(tilt, axis)),
        abs(math.pi - _measure_angle(turn, tilt) - _measure_angle(tilt, axis)),
    )
    turn_side = 1.0 if apart[0] <= apart[1] else -1.0
    z, lean = turn_side * turn, -preferred * tilt
    x = lean - (lean @ z) * z
    x /= np.linalg.norm(x)
    y = np.cross(z, x)
    near, far = _measure_angle(z, lean), _measure_angle(lean, axis)
    if abs(near - far) <= RIGHT_ANGLE:
        far = near
    elif abs(near - far) < NEARLY_RIGHT:
        raise ValueError(
            f"the rotary joints are at {math.degrees(near):.6g} degrees, and the farther one and the tool axis at "
            f"{math.degrees(far):.6g}: the tool just misses the direction of the nearer joint; give them as drawn, not "
            "as measured"
        )
    upward = np.sin(near) * z - np.cos(near) * x  # across the direction of the tilting joint, towards z
    home = math.atan2(float(axis @ y), float(axis @ upward))
    if abs(home) <= RIGHT_ANGLE:
        home = 0.0
    elif home < 0.0 and home > RIGHT_ANGLE - math.pi:
        return _build_nutating_pair(turn, tilt, axis, -preferred)
    nutation = Nutation(near, far, home)
    home_tilt = float(nutation.find_angles(np.zeros(2))[0])
    return PolarPair(np.stack([x, y, z]) + 0.0, preferred, -turn_side, home_tilt, nutation)


def _measure_angle(one: Array, other: Array) -> float:
    """The angle between two directions, rad."""
    return math.atan2(float(np.linalg.norm(np.cross(one, other))), float(one @ other))
