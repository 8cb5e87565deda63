"""Datum shift, mirror image, rotation, scaling and tilted planes as one map from input coordinates to the workpiece.

What is programmed before a plane is tilted acts outside it, what comes after it inside. In one system the maps act in
the order in which the program has set them; one that is set again keeps its place.
"""

from typing import Final, Literal

import numpy as np
from msgspec import Struct, field

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ZERO_ANGLE
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.moves import Feature

Kind = Literal["shift", "mirror", "rotation", "scale"]
_IDENTITY: Final = np.eye(3)
#: A map that is nearer to none than this is none: noise of sums of angles and numbers with many decimals.
_NO_MAP: Final = 1e-12


class Map(Struct, frozen=True, eq=False):
    """``p -> matrix p + origin``; the matrix may mirror and scale evenly."""

    matrix: Array = field(default_factory=lambda: np.eye(3))
    origin: Array = field(default_factory=lambda: np.zeros(3))

    def apply_after(self, inner: "Map") -> "Map":
        """The map that first does another one, then this."""
        return Map(self.matrix @ inner.matrix, self.matrix @ inner.origin + self.origin)

    def split(self) -> tuple[Feature | None, Array]:
        """A feature (rotation and origin), and what is left: a factor (3,) for each coordinate inside it."""
        scale = float(np.cbrt(abs(np.linalg.det(self.matrix))))
        turn, factors = self.matrix / scale, np.full(3, scale)
        if np.linalg.det(turn) < 0:
            turn, factors = turn * np.array([-1.0, 1.0, 1.0]), factors * np.array([-1.0, 1.0, 1.0])
        if np.abs(turn - _IDENTITY).max() < _NO_MAP and np.abs(self.origin).max() < _NO_MAP:
            return None, factors
        x, y, z = (float(value) for value in self.origin)
        return Feature((x, y, z), tuple(float(value) for value in turn.ravel())), factors


def make_rotation(axis: int, angle: float) -> Array:
    """Rotation matrix about X, Y or Z by degrees."""
    c, s = np.cos(RAD_PER_DEG * angle), np.sin(RAD_PER_DEG * angle)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[u, u] = matrix[v, v] = c
    matrix[u, v], matrix[v, u] = -s, s
    return matrix


class Layer(Struct):
    """Maps of one coordinate system by kind, in the order in which they act from outside."""

    shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mirrored_axes: tuple[bool, bool] = (False, False)
    angle: float = 0.0
    scale: float = 1.0
    order: list[Kind] = field(default_factory=list)

    def set(self, kind: Kind, *, active: bool) -> None:
        """A kind has been set anew."""
        if not active and kind in self.order:
            self.order.remove(kind)
        elif active and kind not in self.order:
            self.order.append(kind)

    def map(self) -> Map:
        """What they do together."""
        result = Map()
        for kind in self.order:
            result = result.apply_after(self._make_map(kind))
        return result

    def _make_map(self, kind: Kind) -> Map:
        if kind == "shift":
            return Map(origin=np.array(self.shift))
        if kind == "mirror":
            return Map(np.diag([-1.0 if self.mirrored_axes[0] else 1.0, -1.0 if self.mirrored_axes[1] else 1.0, 1.0]))
        if kind == "rotation":
            return Map(make_rotation(2, self.angle))
        return Map(self.scale * np.eye(3))

    @property
    def factor(self) -> float:
        """The scaling in force."""
        return self.scale if "scale" in self.order else 1.0


class Transformations(Struct):
    """All maps in force: outside the tilted plane, the plane, inside it."""

    outer: Layer = field(default_factory=Layer)
    tilt: Array | None = None
    inner: Layer = field(default_factory=Layer)

    @property
    def current(self) -> Layer:
        """Where the next map goes."""
        return self.outer if self.tilt is None else self.inner

    @property
    def factor(self) -> float:
        """Scaling of lengths."""
        return self.outer.factor * self.inner.factor

    def map(self) -> Map:
        """From input coordinates to the workpiece."""
        result = self.outer.map()
        if self.tilt is not None:
            result = result.apply_after(Map(self.tilt))
        return result.apply_after(self.inner.map())

    def reset(self) -> None:
        """No shift, mirror image, rotation or scaling; the plane stays."""
        self.outer, self.inner = Layer(), Layer()


def build_spatial_plane(a: float, b: float, c: float) -> Array:
    """PLANE SPATIAL: turned about X by SPA, then about Y by SPB, then about Z by SPC, all of the untilted system."""
    return make_rotation(2, c) @ make_rotation(1, b) @ make_rotation(0, a)


def build_euler_plane(precession: float, nutation: float, turn: float) -> Array:
    """PLANE EULER: about Z, about the new X, about the new Z."""
    return make_rotation(2, precession) @ make_rotation(0, nutation) @ make_rotation(2, turn)


def turn_to_vectors(base: Array, normal: Array) -> Array | None:
    """PLANE VECTOR: Z along the normal, X along the base vector's part in the plane; None if it has none."""
    if np.linalg.norm(normal) < ZERO_ANGLE:
        return None
    z = normal / np.linalg.norm(normal)
    x = base - (base @ z) * z
    if np.linalg.norm(x) < ZERO_ANGLE:
        return None
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def turn_to_points(first: Array, second: Array, third: Array) -> Array | None:
    """PLANE POINTS: X from first to second point, the third on the side of +Y; None if they lie on a line."""
    x, y = second - first, third - first
    return turn_to_vectors(x, np.cross(x, y))
