"""Rotary words of a program: the map to the nominal angles A and C, and the words that hold a tool axis."""

import math

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.numbers import format_fixed
from verne_post.base.rotations import solve_angles_of_axis
from verne_post.base.tolerances import POLE_CROSSING, POLE_SINE
from verne_post.base.units import DEG_PER_RAD, RAD_PER_DEG
from verne_post.model.findings import ProgramError
from verne_post.model.moves import AXES, Frame
from verne_post.model.nutation import Nutation


class RotaryWords(Struct, frozen=True):
    """``A = home + a_sign word``, ``C = c_sign word``; on a nutating pair those are its joint angles."""

    #: Which of ``AXES`` the words are: of the joint that tilts the tool, and of the one that turns about its
    #: pole.
    axes: tuple[int, int]
    #: a_sign, c_sign: +1 where the machine file names the workpiece's motion, -1 where it names the tool's (ISO
    #: 841).
    a_sign: float
    c_sign: float
    home: float = 0.0  #: Nominal A where the tilting joint stands at 0, rad.
    nutation: Nutation | None = None  #: Of a pair that is not at right angles.

    def find_angles(self, machine: Array, part_turn: float) -> Array:
        """Nominal angles (..., 2) of machine coordinates (..., 9); the part stands turned by ``part_turn`` degrees."""
        tilt, turn = self.axes
        if self.nutation is not None:
            joints = RAD_PER_DEG * machine[..., [tilt, turn]] * [self.a_sign, self.c_sign]
            return self.nutation.find_angles(joints - [0.0, RAD_PER_DEG * part_turn])
        a = self.a_sign * RAD_PER_DEG * machine[..., tilt] + self.home
        c = self.c_sign * RAD_PER_DEG * machine[..., turn] - RAD_PER_DEG * part_turn
        return np.stack([a, c], axis=-1)

    def find_words(self, angles: Array, part_turn: float) -> tuple[Array, Array]:
        """The words (...), degrees, of nominal angles (..., 2)."""
        if self.nutation is not None:
            joints = DEG_PER_RAD * self.nutation.find_joints(angles)
            return self.a_sign * joints[..., 0], self.c_sign * (joints[..., 1] + part_turn)
        a = self.a_sign * DEG_PER_RAD * (angles[..., 0] - self.home)
        return a, self.c_sign * (DEG_PER_RAD * angles[..., 1] + part_turn)

    def follow(self, words: tuple[float, float], axes: Array, frame: Frame) -> list[tuple[float, float]]:
        """Words that hold one tool axis (n, 3) of the table frame after the other, from a pair of words on.

        The pair goes on from the words before: the tilt stays on its side of the pole and leaves the pole to the
        positive side; C moves less than half a turn. Nearer to the pole than POLE_CROSSING the tool stands at it, with
        the C before: the same axis a hair away would ask for any C.

        Raises
        ------
        ProgramError
            VP110: the pair does not reach an axis.
        """
        a_word, c_word = words
        a_shift, c_shift = (frame.g92[axis] for axis in self.axes)
        a_origin, c_origin = (frame.origin[axis] for axis in self.axes)
        pairs: list[tuple[float, float]] = []
        for tilt, turn in zip(*(angle.tolist() for angle in solve_angles_of_axis(axes)), strict=True):
            a = self.a_sign * RAD_PER_DEG * (a_word + a_shift + a_origin) + self.home
            c = self.c_sign * RAD_PER_DEG * (c_word + c_shift + c_origin) - RAD_PER_DEG * frame.part_turn
            if self.nutation is not None:
                a, c = self.nutation.find_angles(np.array([a - self.home, c])).tolist()
                self._check_reach(tilt)
            if math.sin(tilt) <= POLE_CROSSING:
                tilt, turn = (0.0 if tilt < 1.0 else math.pi), c
            elif math.sin(a) < -POLE_SINE:
                tilt, turn = -tilt, turn + math.pi
            tilt += 2 * math.pi * round((a - tilt) / (2 * math.pi))
            turn = c + (math.pi - (math.pi - (turn - c)) % (2 * math.pi))
            if self.nutation is not None:
                tilt, turn = self.nutation.find_joints(np.array([tilt, turn])).tolist()
                tilt += self.home
            a_word = self.a_sign * DEG_PER_RAD * (tilt - self.home) - a_origin - a_shift
            c_word = self.c_sign * (DEG_PER_RAD * turn + frame.part_turn) - c_origin - c_shift
            pairs.append((a_word, c_word))
        return pairs

    def _check_reach(self, tilt: float) -> None:
        """Refuse a tool axis at an angle to that of the turning joint, rad, which the tilting joint does not reach."""
        if self.nutation is None or not (miss := float(self.nutation.measure_miss(np.array(tilt)))):
            return
        low, high = (DEG_PER_RAD * end for end in self.nutation.reach)
        tilting, turning = (AXES[axis] for axis in self.axes)
        raise ProgramError(
            "VP110",
            f"the tool axis is at {format_fixed(DEG_PER_RAD * tilt, 4)} degrees to the axis of {turning}, "
            f"{format_fixed(DEG_PER_RAD * miss, 4)} outside what "
            f"{tilting} reaches: {format_fixed(low, 4)} to {format_fixed(high, 4)}",
        )

    def find_other_side(self, machine: Array) -> Array | None:
        """Machine coordinates (9,) of the same tool axis with the tilt beyond the pole; None at the pole."""
        tilt, turn = self.axes
        if self.nutation is not None:
            a, c = self.find_angles(machine, 0.0).tolist()
            if abs(math.sin(a)) <= POLE_SINE:
                return None
            other = machine.copy()
            other[[tilt, turn]] = self.find_words(np.array([-a, c + math.pi]), 0.0)
            return other
        pole = -2.0 * self.a_sign * DEG_PER_RAD * self.home
        if abs(math.sin(self.a_sign * RAD_PER_DEG * machine[tilt] + self.home)) <= POLE_SINE:
            return None
        other = machine.copy()
        other[tilt], other[turn] = pole - machine[tilt], machine[turn] + 180.0
        return other
