"""Datum shift, mirror image, rotation, scaling and tilted planes as one map from input coordinates to the workpiece.

What is programmed before a plane is tilted acts outside it, what comes after it inside. In one system the maps act in
the order in which the program has set them; one that is set again keeps its place.
"""

from typing import Literal

import numpy as np
from msgspec import Struct, field

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ZERO_ANGLE
from verne_post.gcode.affine import Affine, build_rotation, make_affine

Kind = Literal["shift", "mirror", "rotation", "scale"]


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

    def map(self) -> Affine:
        """What they do together."""
        result = Affine()
        for kind in self.order:
            result = result.put_inside(self._make_map(kind))
        return result

    def _make_map(self, kind: Kind) -> Affine:
        if kind == "shift":
            return Affine(self.shift)
        if kind == "mirror":
            return make_affine(
                np.diag([-1.0 if self.mirrored_axes[0] else 1.0, -1.0 if self.mirrored_axes[1] else 1.0, 1.0])
            )
        if kind == "rotation":
            return make_affine(build_rotation(2, self.angle))
        return make_affine(self.scale * np.eye(3))

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

    def map(self) -> Affine:
        """From input coordinates to the workpiece."""
        result = self.outer.map()
        if self.tilt is not None:
            result = result.put_inside(make_affine(self.tilt))
        return result.put_inside(self.inner.map())

    def reset(self) -> None:
        """No shift, mirror image, rotation or scaling; the plane stays."""
        self.outer, self.inner = Layer(), Layer()


def build_spatial_plane(a: float, b: float, c: float) -> Array:
    """PLANE SPATIAL: turned about X by SPA, then about Y by SPB, then about Z by SPC, all of the untilted system."""
    return build_rotation(2, c) @ build_rotation(1, b) @ build_rotation(0, a)


def build_euler_plane(precession: float, nutation: float, turn: float) -> Array:
    """PLANE EULER: about Z, about the new X, about the new Z."""
    return build_rotation(2, precession) @ build_rotation(0, nutation) @ build_rotation(2, turn)


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
