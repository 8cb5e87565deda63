"""Places of a program and on the part: work offset, turned part, shifts, planes; the same on tables and chains."""

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.rotations import rotate_z
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.moves import Frame


def turn_of(frame: Frame) -> float:
    """How far the program's X is turned from that of the part frame, rad."""
    return RAD_PER_DEG * (frame.turn + frame.part_turn)


def find_work_origin(offset_mm: tuple[float, float, float], machine_zero: Array) -> tuple[float, float, float]:
    """Origin of a work offset that is given in the part frame, counted from machine zero (3,), mm."""
    x, y, z = (float(v) for v in np.asarray(offset_mm) - machine_zero)
    return x, y, z


def place_on_part(program: Array, frame: Frame, machine_zero: Array) -> tuple[Array, Array, Array]:
    """Map program coordinates (..., 9) to the tip (..., 3) in the part frame.

    Returns also the program coordinates (..., 9) without planes and shifts, and what the work offset adds to them (9,).
    """
    shifted = np.array(program, dtype=float)
    if frame.feature is not None:
        shifted[..., :3] = frame.feature.map_outside(shifted[..., :3])
    shifted += np.asarray(frame.g92)
    origin = np.asarray(frame.origin)
    return machine_zero + origin[:3] + rotate_z(shifted[..., :3], turn_of(frame)), shifted, origin


def place_in_program(
    tip: Array, words: tuple[Array, Array], axes: tuple[int, int], frame: Frame, machine_zero: Array
) -> Array:
    """Inverse of :func:`place_on_part`: program coordinates (..., 9) of a tip and of words (...) of two rotary axes."""
    origin = np.asarray(frame.origin)
    program = np.zeros((*np.shape(tip)[:-1], 9))
    program[..., :3] = rotate_z(tip - machine_zero - origin[:3], -turn_of(frame))
    for axis, word in zip(axes, words, strict=True):
        program[..., axis] = word - origin[axis]
    program -= np.asarray(frame.g92)
    if frame.feature is not None:
        program[..., :3] = frame.feature.map_inside(program[..., :3])
    return program


def turn_to_part(vector: Array, frame: Frame) -> Array:
    """Displacements (..., 3) of the program in directions of the part."""
    inner = np.asarray(vector, dtype=float)
    if frame.feature is not None:
        inner = frame.feature.turn_outside(inner)
    return rotate_z(inner, turn_of(frame))
