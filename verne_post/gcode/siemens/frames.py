"""Programmable frames: TRANS, ROT, SCALE, MIRROR and their additive forms, and the plane of CYCLE800, as one chain."""

import math
from typing import Final

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.gcode.program_error import ProgramError
from verne_post.model.moves import Feature

#: Columns of a frame's matrix that are less square to each other than this are skewed, which no motion here can follow.
_SQUARE: Final = 1e-9
#: Differences of a rotation from none that are rounding.
_NOTHING: Final = 1e-12


def build_rotation_about(axis: int, degrees: float) -> Array:
    """Matrix (3, 3) of a turn about X (0), Y (1) or Z (2); exact for quarter turns."""
    c, s = _take_cosine(degrees), _take_cosine(degrees - 90.0)
    matrix = np.eye(3)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    matrix[u, u], matrix[u, v], matrix[v, u], matrix[v, v] = c, -s, s, c
    return matrix


def _take_cosine(degrees: float) -> float:
    quarter = degrees / 90.0
    if quarter == round(quarter):
        return (1.0, 0.0, -1.0, 0.0)[round(quarter) % 4]
    return math.cos(math.radians(degrees))


class Affine(Struct, frozen=True):
    """A map of points: ``matrix @ point + shift``; tuples, so that two can be compared."""

    shift: tuple[float, ...] = (0.0, 0.0, 0.0)
    matrix: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)

    @property
    def linear(self) -> Array:
        """The matrix (3, 3)."""
        return np.array(self.matrix).reshape(3, 3)

    def put_inside(self, shift: Array, linear: Array) -> "Affine":
        """The map with another one inside of it: additive frames refer to the frame in force."""
        outer = self.linear
        moved = outer @ shift + np.array(self.shift)
        return Affine(tuple(map(float, moved)), tuple(map(float, (outer @ linear).ravel())))

    def apply_after(self, feature: Feature | None) -> "Affine":
        """The map of a plane after this one."""
        if feature is None:
            return self
        plane = Affine(feature.origin, feature.rotation)
        return plane.put_inside(np.array(self.shift), self.linear)

    @property
    def is_identity(self) -> bool:
        """True for the map that changes nothing."""
        return self == Affine()


class Split(Struct, frozen=True):
    """A map as a plane (rotation and origin), and signed scales of X, Y, Z inside of it."""

    feature: Feature | None
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


def split(frame: Affine, mirrored: int) -> Split:
    """Take a frame apart.

    Parameters
    ----------
    frame : Affine
    mirrored : int
        The axis that carries the sign where the frame mirrors.

    Raises
    ------
    ProgramError
        VP017: after a turn of axes of unequal scales circles are no circles and directions are skewed.
    """
    linear = frame.linear
    scale = np.sqrt((linear**2).sum(axis=0))
    if scale.min() <= 0.0:
        raise ProgramError("VP007", "a scale must not be 0")
    scale[np.abs(scale - 1.0) < _NOTHING] = 1.0
    rotation = linear / scale
    if np.abs(rotation.T @ rotation - np.eye(3)).max() > _SQUARE:
        raise ProgramError(
            "VP017", "a rotation after unequal scales skews the axes; scale after the rotation, or all axes alike"
        )
    if np.linalg.det(rotation) < 0:
        scale[mirrored] *= -1.0
        rotation[:, mirrored] *= -1.0
    feature: Feature | None = None
    if np.abs(rotation - np.eye(3)).max() > _NOTHING or any(frame.shift):
        x, y, z = frame.shift
        feature = Feature((x, y, z), tuple(float(value) + 0.0 for value in rotation.ravel()))
    return Split(feature, (float(scale[0]), float(scale[1]), float(scale[2])))


class Frames(Struct, frozen=True):
    """The chain: plane of CYCLE800, then programmable frame; offsets of rotary axes; the last axis that mirrors.

    ``rotary`` are degrees that TRANS adds to A and C.
    """

    swivel: Affine = field(default_factory=Affine)
    program: Affine = field(default_factory=Affine)
    rotary: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mirrored: int = 0

    # --- TRANS, ROT, SCALE, MIRROR: each deletes the programmable frame, its additive form goes on from it ------

    def begin(self, word: str) -> "Frames":
        """The chain that a frame word refers to."""
        if word.startswith("A"):
            return self
        return replace(self, program=Affine(), rotary=(0.0, 0.0, 0.0), mirrored=0)

    def move(self, shift: list[float], rotary: list[float]) -> "Frames":
        """TRANS, ATRANS."""
        a, b, c = (old + new for old, new in zip(self.rotary, rotary, strict=True))
        return replace(self, program=self.program.put_inside(np.array(shift), np.eye(3)), rotary=(a, b, c))

    def turn(self, rotation: Array) -> "Frames":
        """ROT, AROT."""
        return replace(self, program=self.program.put_inside(np.zeros(3), rotation))

    def scale_axes(self, factors: list[float]) -> "Frames":
        """SCALE, ASCALE."""
        return replace(self, program=self.program.put_inside(np.zeros(3), np.diag(factors)))

    def mirror(self, axes: list[int]) -> "Frames":
        """MIRROR, AMIRROR."""
        signs = [-1.0 if axis in axes else 1.0 for axis in range(3)]
        chain = replace(self, program=self.program.put_inside(np.zeros(3), np.diag(signs)))
        return replace(chain, mirrored=axes[-1]) if axes else chain

    def put_inside(self, other: "Frames") -> "Frames":
        """The programmable frame of another chain inside of this one."""
        program = self.program.put_inside(np.array(other.program.shift), other.program.linear)
        a, b, c = (old + new for old, new in zip(self.rotary, other.rotary, strict=True))
        mirrors = np.linalg.det(other.program.linear) < 0
        mirrored = other.mirrored if mirrors else self.mirrored
        return replace(self, program=program, rotary=(a, b, c), mirrored=mirrored)

    @property
    def total(self) -> Affine:
        """Everything after the work offset."""
        return self.swivel.put_inside(np.array(self.program.shift), self.program.linear)
