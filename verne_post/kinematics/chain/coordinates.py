"""What program coordinates mean on a machine of one chain."""

import math

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.rotations import find_axis_of_angles, rotate_x, rotate_y, rotate_z
from verne_post.base.tolerances import POLE_SINE
from verne_post.kinematics.chain.machine import ChainMachine
from verne_post.kinematics.tables.places import find_work_origin, place_in_program, place_on_part, turn_of, turn_to_part
from verne_post.kinematics.tables.words import RotaryWords
from verne_post.model.moves import AXES, Frame
from verne_post.model.nutation import Nutation
from verne_post.model.toolpath import TurnSegments


class ChainCoordinates(Struct, frozen=True, eq=False):
    """Maps between program, part and machine coordinates; implements ``TableCoordinates``.

    Machine coordinates are the values of the joints, degrees in the sense of the machine file. Work offsets count from
    the gauge point with all joints at 0, in directions of the part frame. "Table" is the pair's polar frame.
    """

    machine: ChainMachine
    words: RotaryWords  #: The words of the rotary joints.
    machine_zero: Array  #: (3,): The gauge point with all joints at 0, part frame, mm.
    #: The chain is a wrist on a carrier that turns: words are those of the nominal one, on linear axes.
    joints_by_axis: bool = False

    @property
    def rotary(self) -> tuple[int, int]:
        """Which of ``AXES`` tilt the tool and turn about its pole."""
        return self.words.axes

    @property
    def axes(self) -> str:
        """Letters of the axes that a program may name."""
        return "XYZ" + "".join(AXES[axis] for axis in sorted(self.rotary))

    @property
    def head(self) -> tuple[int, ...]:
        """Which of ``AXES`` turn the tool's end of the machine."""
        joints = zip(self.rotary, (self.machine.tilt, self.machine.turn), strict=True)
        return tuple(axis for axis, joint in joints if joint.on_tool)

    @property
    def nutation(self) -> Nutation | None:
        """Of the rotary pair, where it is not at right angles."""
        return self.words.nutation

    @property
    def zero_point(self) -> str:
        """The point that work offsets count from, in words: what turns the part need not go through it, nor along z."""
        turn = self.machine.turn
        is_centre = not turn.on_tool and abs(self.part_frame[2, 2]) == 1.0 and not turn.through[:2].any()
        return f"part_zero of the machine file{f', on the axis of {AXES[self.rotary[1]]}' if is_centre else ''}"

    @property
    def part_frame(self) -> Array:
        """Rows: x, y, z of the polar frame in directions of the part."""
        return self.machine.pair.directions

    @property
    def home_tilt(self) -> float:
        """Nominal A with all joints at 0, rad."""
        return self.machine.pair.home_tilt

    @property
    def turns_with_part(self) -> bool:
        """Whether a part that stands turned about z is the same as another angle of a joint that carries it."""
        upright = bool(abs(self.part_frame[2, 2]) > 1.0 - POLE_SINE)
        return upright and not self.machine.turn.on_tool

    # --- the nominal machine -------------------------------------------------------------------------------

    @property
    def rotary_offset(self) -> Array:
        """From the axis of the tilting joint to the turning one (3,), where both are on the part's side; else 0."""
        both = not (self.machine.tilt.on_tool or self.machine.turn.on_tool)
        return float(both) * (self.machine.turn.through - self.machine.tilt.through)

    @property
    def pivot(self) -> Array:
        """A point of the axis of the joint nearest the base on the part's side, base frame with z down."""
        joint = self.machine.turn if self.machine.tilt.on_tool else self.machine.tilt
        return joint.through * [1.0, -1.0, -1.0]

    @property
    def part_offset(self) -> Array:
        """From the axis of the turning joint to the part zero (3,)."""
        return -self.machine.turn.through

    def carry_tips(self, start: Array, end: Array, tool_length: Array) -> TurnSegments:
        """Moves from pose to pose (n, 5) along which all joints go linearly, with tool lengths (n,)."""
        machine, home, nutation = self.machine, self.machine.pair.home_tilt, self.nutation
        tilt, turn = machine.tilt.through, machine.turn.through
        at_home = machine.place_tip(tool_length)
        first, last = (machine.find_platform_gauge(pose[:, :3], pose[:, 3:], tool_length) for pose in (start, end))
        still = np.zeros_like(first)
        # the tip is the sum of what tilts and turns, of what only turns, and of what goes straight
        tilts, turns, straight = [at_home - tilt] * 2, [still + tilt - turn] * 2, [still + turn] * 2
        carried = tilts if not machine.tilt.on_tool else turns if not machine.turn.on_tool else straight
        carried[:] = [carried[0] + first, carried[1] + last]
        lean, angles = self.machine.pair.lean, (start[:, 3:], end[:, 3:])
        if nutation is not None:
            tilts = [rotate_y(place, lean) for place in tilts]
            angles, home = (nutation.find_turns(angles[0]), nutation.find_turns(angles[1])), nutation.home
        return TurnSegments(
            rotate_x(tilts[0], home),
            rotate_x(tilts[1], home),
            *angles,
            -turns[0],
            straight[0],
            turns[1] - turns[0],
            straight[1] - straight[0],
            np.full(len(start), lean),
        )

    # --- program and part -------------------------------------------------------------------------------------

    def work_origin(self, offset_mm: tuple[float, float, float]) -> tuple[float, float, float]:
        """Origin of a work offset in the part frame, counted from machine zero."""
        return find_work_origin(offset_mm, self.machine_zero)

    def map_to_table(self, program: Array, frame: Frame) -> tuple[Array, Array]:
        """Program coordinates (..., 9) -> tip in the polar frame (..., 3), nominal angles (..., 2)."""
        tip, shifted, origin = place_on_part(program, frame, self.machine_zero)
        return tip @ self.part_frame.T, self.words.find_angles(shifted + origin, frame.part_turn)

    def map_from_table(self, tip: Array, angles: Array, frame: Frame) -> Array:
        """Inverse of :meth:`map_to_table`; the axes that the machine lacks are 0."""
        words = self.words.find_words(angles, frame.part_turn)
        return place_in_program(np.asarray(tip) @ self.part_frame, words, self.rotary, frame, self.machine_zero)

    def turn_to_axis(self, program: list[float], vector: Array, frame: Frame) -> list[float]:
        """A program point (9) with rotary words that hold a tool axis (3,) given in program directions."""
        tilt, turn = self.rotary
        end = list(program)
        [(end[tilt], end[turn])] = self.turn_to_axes((end[tilt], end[turn]), np.asarray(vector)[None], frame)
        return end

    def turn_to_axes(self, words: tuple[float, float], vectors: Array, frame: Frame) -> list[tuple[float, float]]:
        """Rotary words that hold one tool axis (n, 3) after the other, from a pair of words on."""
        return self.words.follow(words, self.turn_displacement(vectors, frame), frame)

    def find_tool_axis(self, program: list[float], frame: Frame) -> Array:
        """Tool axis (3,) at a program point, program directions."""
        _tip, angles = self.map_to_table(np.array(program), frame)
        axis = rotate_z(find_axis_of_angles(angles[0], angles[1]) @ self.part_frame, -turn_of(frame))
        return axis if frame.feature is None else frame.feature.turn_inside(axis)

    def turn_displacement(self, vector: Array, frame: Frame) -> Array:
        """Turn displacements (..., 3) of the program into the polar frame."""
        return np.asarray(turn_to_part(vector, frame) @ self.part_frame.T)

    def map_to_work(self, point: Array, axis: Array, frame: Frame) -> tuple[Array, Array]:
        """A point and a direction (..., 3) of the polar frame in the work frame of ``frame``."""
        turn, origin = -turn_of(frame), self.machine_zero + np.asarray(frame.origin)[:3]
        return rotate_z(point @ self.part_frame - origin, turn), rotate_z(axis @ self.part_frame, turn)

    # --- program and machine ------------------------------------------------------------------------------------

    def map_to_machine(self, program: Array, frame: Frame) -> Array:
        """Machine coordinates (..., 9): the joints, for the gauge line."""
        tip, angles = self.map_to_table(program, frame)
        machine = np.zeros(np.shape(program))
        machine[..., :3] = self.machine.find_joints(tip, angles, frame.tool_length)[..., :3]
        for axis, word in zip(self.rotary, self.words.find_words(angles, 0.0), strict=True):
            machine[..., axis] = word
        return machine

    def map_to_program(self, machine: Array, frame: Frame) -> Array:
        """Program coordinates in ``frame`` of a machine position."""
        machine = np.asarray(machine, dtype=float)
        angles = self.words.find_angles(machine, 0.0)
        q = np.concatenate([machine[..., :3], self.machine.pair.find_joints(angles)], axis=-1)
        return self.map_from_table(self.machine.find_nominal_pose(q, frame.tool_length)[0], angles, frame)

    def find_other_side(self, machine: Array) -> Array | None:
        """Machine coordinates (9,) of the same tool axis with the tilt beyond the pole; None at the pole."""
        return self.words.find_other_side(machine)

    def is_upright(self, machine: Array) -> bool:
        """Whether the tool points along z of the part at machine coordinates (9,)."""
        a, c = self.words.find_angles(machine, 0.0)
        x, y, z = find_axis_of_angles(a, c) @ self.part_frame
        return math.hypot(x, y) <= POLE_SINE and z > 0
