"""The tilting rotary table: a tilt A about x that carries a rotary C about z, which carries the part.

Everything here is the *nominal trunnion machine*: the same table under a spindle that never tilts.
Its gauge-line point is the bridge to the parallel module, and its coordinates are what G53, G28,
G30 and G10 L2 speak of (docs/conventions.md). mm and rad, workpiece sense, unless a name says deg.
"""

import math
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.rotations import find_axis_of_angles, rotate_x, rotate_z
from verne_post.base.tolerances import POLE_SINE
from verne_post.base.units import DEG_PER_RAD, RAD_PER_DEG
from verne_post.kinematics.tables.places import find_work_origin, place_in_program, place_on_part, turn_of, turn_to_part
from verne_post.kinematics.tables.words import RotaryWords
from verne_post.model.moves import AXES, Frame
from verne_post.model.toolpath import TurnSegments

#: A tilts the tool, C turns it about its pole.
_AXES: Final = (AXES.index("A"), AXES.index("C"))


class TiltingTable(Struct, frozen=True, eq=False):
    """Geometry and senses of the table; implements ``TableCoordinates``."""

    pivot: Array  #: (3,): A point on the tilt axis, base frame.
    rotary_offset: Array  #: (3,): From there to the rotary centre, tilt frame at A = 0 (z up).
    machine_zero: Array  #: (3,): Origin of machine coordinates over the rotary centre, at A = 0 (z up).
    #: a_sign, c_sign: +1 where the machine file names the workpiece's motion, -1 where it names the tool's (ISO
    #: 841).
    a_sign: float
    c_sign: float

    @property
    def axes(self) -> str:
        """Letters of the axes that a program may name."""
        return "XYZAC"

    @property
    def rotary(self) -> tuple[int, int]:
        """Which of ``AXES`` tilt the tool and turn about its pole."""
        return _AXES

    @property
    def head(self) -> tuple[int, ...]:
        """Which of ``AXES`` turn the tool's end of the machine: none."""
        return ()

    @property
    def nutation(self) -> None:
        """The table's axes are at right angles."""

    @property
    def joints_by_axis(self) -> bool:
        """The table's joints have words of their own."""
        return False

    @property
    def part_offset(self) -> Array:
        """From the rotary axis to the part zero (3,): none."""
        return np.zeros(3)

    @property
    def part_frame(self) -> Array:
        """Rows: x, y, z of the table frame in directions of the part frame, which is the same."""
        return np.eye(3)

    @property
    def home_tilt(self) -> float:
        """Nominal A with A at 0: 0."""
        return 0.0

    @property
    def turns_with_part(self) -> bool:
        """A part that stands turned about z is the same as another C."""
        return True

    @property
    def _words(self) -> RotaryWords:
        return RotaryWords(_AXES, self.a_sign, self.c_sign)

    # --- the nominal machine ---------------------------------------------------------------

    def find_gauge_point(self, tip: Array, angles: Array, tool_length: Array | float) -> Array:
        """Gauge-line point of the nominal machine, seen from the pivot in the upright frame.

        Parameters
        ----------
        tip : ndarray, shape (..., 3)
            Table frame.
        angles : ndarray, shape (..., 2)
            Nominal A and C.
        tool_length : ndarray, shape (...) or float

        Returns
        -------
        ndarray, shape (..., 3)
            ``Rx(A) (rotary_offset + Rz(C) tip) + (0, 0, tool_length)``.
        """
        turned = rotate_x(self.rotary_offset + rotate_z(tip, angles[..., 1]), angles[..., 0])
        turned[..., 2] += tool_length
        return turned

    def find_tip_of_gauge(self, gauge: Array, angles: Array, tool_length: Array | float) -> Array:
        """Inverse of :meth:`find_gauge_point`: tip in the table frame."""
        turned = np.array(gauge, dtype=float)
        turned[..., 2] -= tool_length
        return rotate_z(rotate_x(turned, -angles[..., 0]) - self.rotary_offset, -angles[..., 1])

    def carry_tips(self, start: Array, end: Array, tool_length: Array) -> TurnSegments:
        """Moves from pose to pose (n, 5) along which the gauge-line point and the angles go linearly."""
        first, last = (self.find_gauge_point(pose[:, :3], pose[:, 3:], 0.0) for pose in (start, end))
        shift, slide, drift = np.zeros((3, *first.shape))
        offset = np.tile(self.rotary_offset, (len(first), 1))
        return TurnSegments(first, last, start[:, 3:], end[:, 3:], offset, shift, slide, drift, np.zeros(len(first)))

    # --- program, table and machine coordinates ------------------------------------------------

    def work_origin(self, offset_mm: tuple[float, float, float]) -> tuple[float, float, float]:
        """Origin in machine coordinates of a work offset given in the table frame: o - machine_zero."""
        return find_work_origin(offset_mm, self.machine_zero)

    def map_to_table(self, program: Array, frame: Frame) -> tuple[Array, Array]:
        """Program coordinates (..., 9) -> tip in the table frame (..., 3), nominal angles (..., 2)."""
        tip, shifted, origin = place_on_part(program, frame, self.machine_zero)
        a = self.a_sign * RAD_PER_DEG * (shifted[..., 3] + origin[3])
        c = self.c_sign * RAD_PER_DEG * (shifted[..., 5] + origin[5]) - RAD_PER_DEG * frame.part_turn
        return tip, np.stack([a, c], axis=-1)

    def map_from_table(self, tip: Array, angles: Array, frame: Frame) -> Array:
        """Inverse of :meth:`map_to_table`; the axes that the table lacks are 0."""
        words = self._words.find_words(angles, frame.part_turn)
        return place_in_program(tip, words, _AXES, frame, self.machine_zero)

    def turn_to_axis(self, program: list[float], vector: Array, frame: Frame) -> list[float]:
        """A program point (9) with A and C words that hold a tool axis (3,) of program directions, as in ``follow``."""
        [[a, c]] = self.turn_to_axes((program[3], program[5]), np.asarray(vector)[None], frame)
        return [*program[:3], a, program[4], c, *program[6:]]

    def turn_to_axes(self, words: tuple[float, float], vectors: Array, frame: Frame) -> list[tuple[float, float]]:
        """A and C words that hold tool axes (n, 3) in turn, beginning at a pair of words; see :meth:`turn_to_axis`."""
        if frame.feature is None:
            axes = self.turn_displacement(vectors, frame)
        else:  # a product of matrices may round in another way for many rows than for one
            axes = np.array([self.turn_displacement(vector, frame) for vector in vectors])
        return self._words.follow(words, axes, frame)

    def find_tool_axis(self, program: list[float], frame: Frame) -> Array:
        """Tool axis (3,) of the nominal machine at a program point, program directions."""
        _tip, angles = self.map_to_table(np.array(program), frame)
        axis = rotate_z(find_axis_of_angles(angles[0], angles[1]), -turn_of(frame))
        return axis if frame.feature is None else frame.feature.turn_inside(axis)

    @property
    def zero_point(self) -> str:
        """The point that work offsets count from, in words."""
        return "the rotary centre on the table face"

    def turn_displacement(self, vector: Array, frame: Frame) -> Array:
        """Turn displacements (..., 3) of the program into the table frame."""
        return turn_to_part(vector, frame)

    def map_to_work(self, point: Array, axis: Array, frame: Frame) -> tuple[Array, Array]:
        """A point and a direction (..., 3) of the table frame in the work frame of ``frame``."""
        turn = -turn_of(frame)
        return rotate_z(point - self.machine_zero - np.asarray(frame.origin)[:3], turn), rotate_z(axis, turn)

    def map_to_machine(self, program: Array, frame: Frame) -> Array:
        """Machine coordinates: gauge line over machine zero, nominal angles in the file's sense."""
        tip, angles = self.map_to_table(program, frame)
        machine = np.zeros(np.shape(program))
        machine[..., :3] = (
            self.find_gauge_point(tip, angles, frame.tool_length) - self.rotary_offset - self.machine_zero
        )
        machine[..., 3] = self.a_sign * DEG_PER_RAD * angles[..., 0]
        machine[..., 5] = self.c_sign * DEG_PER_RAD * angles[..., 1]
        return machine

    def map_to_program(self, machine: Array, frame: Frame) -> Array:
        """Program coordinates in ``frame`` of a machine position."""
        machine = np.asarray(machine, dtype=float)
        angles = RAD_PER_DEG * np.stack([self.a_sign * machine[..., 3], self.c_sign * machine[..., 5]], axis=-1)
        gauge = machine[..., :3] + self.rotary_offset + self.machine_zero
        return self.map_from_table(self.find_tip_of_gauge(gauge, angles, frame.tool_length), angles, frame)

    def find_other_side(self, machine: Array) -> Array | None:
        """Machine coordinates (9,) of the same tool axis with A beyond upright; None where the tool is vertical."""
        return self._words.find_other_side(machine)

    def is_upright(self, machine: Array) -> bool:
        """Whether the tool points along z of the table at machine coordinates (9,)."""
        tilt = RAD_PER_DEG * float(machine[3])
        return abs(math.sin(tilt)) <= POLE_SINE and math.cos(tilt) > 0
