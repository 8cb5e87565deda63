"""Maps of points, by which every language holds its frames: rotations, shifts, scales, mirror images, the turned table.

Rotations by whole quarter turns are exact.
"""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.gcode.program_error import ProgramError
from verne_post.model.moves import Feature, Frame
from verne_post.model.protocols import Coordinates

#: Columns of a map that are less square to each other than this are skewed, which no motion here can follow.
_SQUARE: Final = 1e-9
#: Differences from no rotation, no scale and no shift (mm) that are rounding.
_NOTHING: Final = 1e-12
#: A turned table that moves points by less than this (mm, at 1 mm) stands: rounding of machine coordinates.
_STANDS: Final = 1e-9


class Affine(Struct, frozen=True):
    """A map of points: ``matrix @ point + shift``; tuples, row by row, so that two can be compared."""

    shift: tuple[float, ...] = (0.0, 0.0, 0.0)
    matrix: tuple[float, ...] = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)

    @property
    def linear(self) -> Array:
        """The matrix (3, 3)."""
        return np.array(self.matrix).reshape(3, 3)

    @property
    def is_identity(self) -> bool:
        """True for the map that changes nothing."""
        return self == Affine()

    def is_near(self, other: "Affine", tolerance: float) -> bool:
        """True where no number (1 and mm) differs by as much as a tolerance."""
        ours, theirs = (*self.shift, *self.matrix), (*other.shift, *other.matrix)
        return max(abs(a - b) for a, b in zip(ours, theirs, strict=True)) < tolerance

    @property
    def feature(self) -> Feature | None:
        """A rotation with a shift as the plane of a frame; None for the map that changes nothing."""
        if self.is_near(Affine(), _NOTHING):
            return None
        x, y, z = self.shift
        return Feature((x, y, z), self.matrix)

    def put_inside(self, inner: "Affine") -> "Affine":
        """The map that first does another one, then this."""
        return make_affine(self.linear @ inner.linear, self.map_point(inner.shift))

    def lay(self, inner: "Affine") -> Feature | None:
        """The plane of places that do not turn with a table, whose map this is; a map of the program stands inside.

        The plane is programmed where that map tilts it, or where the table stands at 0.
        """
        feature, own = self.put_inside(inner).feature, inner.feature
        if feature is None or self.is_identity or (own is not None and not own.is_level):
            return feature
        return replace(feature, is_programmed=False)

    def invert(self) -> "Affine":
        """The map back, of a rotation with a shift."""
        back = self.linear.T
        return make_affine(back, -back @ np.array(self.shift))

    def map_point(self, point: Sequence[float] | Array) -> list[float]:
        """Where a point (3) goes."""
        return [value + shift for value, shift in zip(self.turn(point), self.shift, strict=True)]

    def turn(self, direction: Sequence[float] | Array) -> list[float]:
        """Where a direction (3) points."""
        x, y, z = map(float, direction)
        m = self.matrix
        return [m[row] * x + m[row + 1] * y + m[row + 2] * z for row in (0, 3, 6)]


def make_affine(linear: Array, shift: Sequence[float] | Array = (0.0, 0.0, 0.0)) -> Affine:
    """A map of a matrix (3, 3) and a shift (3); no number is -0."""
    return Affine(tuple(float(value) + 0.0 for value in shift), tuple(float(value) + 0.0 for value in linear.ravel()))


# --- rotations --------------------------------------------------------------------------------------------------


def find_cosine(degrees: float) -> float:
    """Cosine; exact at quarter turns."""
    quarter = degrees / 90.0
    if quarter == round(quarter):
        return (1.0, 0.0, -1.0, 0.0)[round(quarter) % 4]
    return math.cos(math.radians(degrees))


def find_sine(degrees: float) -> float:
    """Sine; exact at quarter turns."""
    quarter = degrees / 90.0
    if quarter == round(quarter):
        return (0.0, 1.0, 0.0, -1.0)[round(quarter) % 4]
    return math.sin(math.radians(degrees))


def build_rotation(axis: int, degrees: float) -> Array:
    """Matrix (3, 3) of a turn about X (0), Y (1) or Z (2)."""
    c, s = find_cosine(degrees), find_sine(degrees)
    matrix = np.eye(3)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    matrix[u, u], matrix[u, v], matrix[v, u], matrix[v, v] = c, -s, s, c
    return matrix


def build_rotation_about(direction: Array, degrees: float) -> Array:
    """Matrix (3, 3) of a turn about a unit direction (3,), by the formula of Rodrigues."""
    c, s = find_cosine(degrees), find_sine(degrees)
    x, y, z = direction
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return c * np.eye(3) + s * cross + (1.0 - c) * np.outer(direction, direction)


def find_nearest_rotation(matrix: Array) -> Array:
    """The rotation (3, 3) beside a matrix that is one but for rounding."""
    u, _sizes, v = np.linalg.svd(matrix)
    return np.asarray(u @ v)


# --- a map taken apart ------------------------------------------------------------------------------------------


class Split(Struct, frozen=True):
    """A map as a rotation with a shift, and signed scales of X, Y, Z inside of it."""

    rigid: Affine = field(default_factory=Affine)
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)


def split(whole: Affine, mirrored_axis: int = 0) -> Split:
    """Take a map apart.

    Parameters
    ----------
    whole : Affine
    mirrored_axis : int
        The axis that carries the sign where the map mirrors.

    Raises
    ------
    ProgramError
        VP017: after a turn of axes of unequal scales circles are no circles and directions are skewed.
    """
    linear = whole.linear
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
        scale[mirrored_axis] *= -1.0
        rotation[:, mirrored_axis] *= -1.0
    x, y, z = (float(value) for value in scale)
    return Split(make_affine(rotation, whole.shift), (x, y, z))


# --- the turned table -------------------------------------------------------------------------------------------


def find_table_map(coordinates: Coordinates, frame: Frame, program: Sequence[float]) -> Affine:
    """Where X, Y, Z of a program without tool-centre-point control are on the part, while the table stands turned.

    They are coordinates of the machine, shifted by the work offset: those of the part as it would stand with A and C
    at 0. While the table stands, they are coordinates of the part in another position.

    Parameters
    ----------
    coordinates : Coordinates
    frame : Frame
        Its tilted plane does not count.
    program : sequence of float
        A program point (9), of which only A, B, C count, degrees.

    Returns
    -------
    Affine
        A rotation with a shift, in program coordinates without a plane.
    """
    bare = replace(frame, feature=None)
    upright, rotary_point = np.zeros((4, 9)), np.zeros((1, 9))
    upright[1:, :3] = np.eye(3)
    rotary_point[0, 3:6] = program[3:6]
    machine = coordinates.map_to_machine(upright, bare)
    machine[:, 3:6] = coordinates.map_to_machine(rotary_point, bare)[0, 3:6]
    place = coordinates.map_to_program(machine, bare)[:, :3]
    if np.abs(place - upright[:, :3]).max() < _STANDS:
        return Affine()
    return make_affine(find_nearest_rotation((place[1:] - place[0]).T), place[0])
