"""Work offsets, G92 and tool offsets as frames, and what they mean to a plain Cartesian interpreter."""

import math

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.tolerances import POLE_SINE
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.moves import Frame
from verne_post.model.part_setup import Vector9


def make_vector9(values: object) -> Vector9:
    """Nine floats as the tuple that a Frame holds."""
    return tuple(float(value) for value in values)  # type: ignore[return-value, attr-defined]


class CartesianCoordinates(Struct, frozen=True):
    """LinuxCNC's view: ``machine = R (program + G92) + G5x + tool offset``, axis by axis."""

    def turn_displacement(self, vector: Array, frame: Frame) -> Array:
        """Turn displacements (..., 3) of the program into machine directions."""
        inner = np.array(vector, dtype=float)
        if frame.feature is not None:
            inner = frame.feature.turn_outside(inner)
        return _rotate(inner, frame.turn)

    def turn_to_axis(self, program: list[float], vector: Array, frame: Frame) -> list[float]:
        """A plain interpreter does not know which angles hold a tool axis: the point as it is."""
        return program

    def turn_to_axes(self, words: tuple[float, float], vectors: Array, frame: Frame) -> list[tuple[float, float]]:
        """As :meth:`turn_to_axis`, for one tool axis (n, 3) after the other: the words of A and C as they are."""
        return [words] * len(vectors)

    def find_tool_axis(self, program: list[float], frame: Frame) -> Array | None:
        """A plain interpreter does not know how rotary axes turn the tool."""
        return None

    def find_other_side(self, machine: Array) -> Array | None:
        """A plain interpreter knows no other side."""
        return None

    def is_upright(self, machine: Array) -> bool:
        """Whether A stands at 0."""
        tilt = RAD_PER_DEG * float(machine[3])
        return abs(math.sin(tilt)) <= POLE_SINE and math.cos(tilt) > 0

    @property
    def nutation(self) -> None:
        """A plain interpreter knows no pair."""

    @property
    def head(self) -> tuple[int, ...]:
        """A plain interpreter has no head."""
        return ()

    @property
    def zero_point(self) -> str:
        """A plain interpreter has no table."""
        return "machine zero"

    def map_to_machine(self, program: Array, frame: Frame) -> Array:
        """Program coordinates (..., 9) -> machine coordinates."""
        machine = np.array(program, dtype=float)
        if frame.feature is not None:
            machine[..., :3] = frame.feature.map_outside(machine[..., :3])
        machine += np.asarray(frame.g92)
        if frame.turn:
            machine[..., :3] = _rotate(machine[..., :3], frame.turn)
        return machine + np.asarray(frame.origin) + np.asarray(frame.tool)

    def map_to_program(self, machine: Array, frame: Frame) -> Array:
        """Machine coordinates (..., 9) -> program coordinates."""
        program = machine - np.asarray(frame.origin) - np.asarray(frame.tool)
        if frame.turn:
            program[..., :3] = _rotate(program[..., :3], -frame.turn)
        program = program - np.asarray(frame.g92)
        if frame.feature is not None:
            program[..., :3] = frame.feature.map_inside(program[..., :3])
        return program


def _rotate(vector: Array, angle_deg: float) -> Array:
    """Turn vectors (..., 3) about Z."""
    if not angle_deg:
        return vector
    c, s = math.cos(RAD_PER_DEG * angle_deg), math.sin(RAD_PER_DEG * angle_deg)
    vectors = np.array(vector)
    vectors[..., 0] = c * vector[..., 0] - s * vector[..., 1]
    vectors[..., 1] = s * vector[..., 0] + c * vector[..., 1]
    return vectors
