"""A pair of rotary joints at right angles as polar angles of the tool axis: today's nominal A and C in a frame of their own.

With u1 the direction of the rotary joint nearest the part, u2 that of the other, w0 the tool axis at home, and phi the motions of
the tool against the part, the tool axis in directions of the part at home is ``R(u1, phi1) R(u2, phi2) w0``, wherever the joints
are. Where u1, u2 and u2, w0 are at right angles, these are polar angles about u1: in the *polar frame* with z along u1 and x along
u2 the axis is ``(sin A sin C, sin A cos C, cos A)`` with ``A = A0 - phi2`` and ``C = -phi1``.
"""

import math
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array

#: Directions whose angle differs from a right one by less (rad) are at right angles: digits of a file.
RIGHT_ANGLE: Final = math.radians(1e-6)
#: Directions nearer to a right angle than this (rad), but not at one, are a typing error, or were measured.
NEARLY_RIGHT: Final = math.radians(0.5)
#: Directions are parallel where the sine of their angle is smaller.
PARALLEL: Final = 1e-9


class PolarPair(Struct, frozen=True, eq=False):
    """The polar frame of a rotary pair.

    Attributes
    ----------
    directions : ndarray, shape (3, 3)
        Rows: x, y, z of the polar frame, in the part frame at home.
    tilt_sign, turn_sign : float
        Joint values inside per motion of the tool about u2 and u1: ``q = sign * phi``; A is ``A0 + q``, C is q.
    home_tilt : float
        A0: nominal A of the tool axis with both joints at 0, rad.
    """

    directions: Array
    tilt_sign: float
    turn_sign: float
    home_tilt: float


def build_pair(turn: Array, tilt: Array, axis: Array, preferred: float) -> PolarPair:
    """The polar frame of a pair; all directions in the part frame at home.

    Parameters
    ----------
    turn, tilt : ndarray, shape (3,)
        u1, of the rotary joint nearest the part, and u2, of the other; unit vectors.
    axis : ndarray, shape (3,)
        w0, from tip to spindle; a unit vector.
    preferred : float
        Sign of phi2 on the side of the pole that programs with tool vectors take first, where both are alike: nominal A > 0.

    Raises
    ------
    ValueError
        In a sentence: the pair cannot point the tool, or is not at right angles.
    """
    for one, other, names in (
        (turn, tilt, "the two rotary joints are"),
        (tilt, axis, "the rotary joint farther from the part and the tool axis are"),
    ):
        sine = float(np.linalg.norm(np.cross(one, other)))
        if sine < PARALLEL:
            raise ValueError(f"{names} parallel: the pair cannot point the tool")
        away = abs(math.asin(min(1.0, abs(float(one @ other)))))
        if away > RIGHT_ANGLE:
            why = (
                "give them as drawn, not as measured" if away < NEARLY_RIGHT else "nutating pairs are not executed yet"
            )
            angle = math.degrees(math.atan2(sine, float(one @ other)))
            raise ValueError(f"{names} at {angle:.6g} degrees, not at a right angle: {why}")
    # the pole to the side of z of the part, else of x, else of y
    turn_side = math.copysign(1.0, next(size for size in turn[[2, 0, 1]].tolist() if abs(size) > PARALLEL))
    z = turn_side * turn
    x = -preferred * tilt
    home_tilt = math.atan2(float(axis @ np.cross(z, x)), float(axis @ z))
    if abs(home_tilt) <= RIGHT_ANGLE:  # digits of directions that are not exact in binary
        home_tilt = 0.0
    elif home_tilt < 0.0:  # all joints at 0 is the side that is taken first
        preferred, x, home_tilt = -preferred, -x, -home_tilt
    return PolarPair(np.stack([x, np.cross(z, x), z]) + 0.0, preferred, -turn_side, home_tilt)
