"""Programmable frames: TRANS, ROT, SCALE, MIRROR and their additive forms, and the plane of CYCLE800, as one chain."""

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.gcode.affine import Affine, make_affine


class Frames(Struct, frozen=True):
    """The chain: plane of CYCLE800, then programmable frame; offsets of rotary axes; the last axis that mirrors.

    ``rotary`` are degrees that TRANS adds to A and C.
    """

    swivel: Affine = field(default_factory=Affine)
    program: Affine = field(default_factory=Affine)
    rotary: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mirrored_axis: int = 0

    # --- TRANS, ROT, SCALE, MIRROR: each deletes the programmable frame, its additive form goes on from it ------

    def begin(self, word: str) -> "Frames":
        """The chain that a frame word refers to."""
        if word.startswith("A"):
            return self
        return replace(self, program=Affine(), rotary=(0.0, 0.0, 0.0), mirrored_axis=0)

    def move(self, shift: list[float], rotary: list[float]) -> "Frames":
        """TRANS, ATRANS."""
        a, b, c = (old + new for old, new in zip(self.rotary, rotary, strict=True))
        return replace(self, program=self.program.put_inside(Affine(tuple(shift))), rotary=(a, b, c))

    def turn(self, rotation: Array) -> "Frames":
        """ROT, AROT."""
        return replace(self, program=self.program.put_inside(make_affine(rotation)))

    def scale_axes(self, factors: list[float]) -> "Frames":
        """SCALE, ASCALE."""
        return replace(self, program=self.program.put_inside(make_affine(np.diag(factors))))

    def mirror(self, axes: list[int]) -> "Frames":
        """MIRROR, AMIRROR."""
        signs = [-1.0 if axis in axes else 1.0 for axis in range(3)]
        chain = replace(self, program=self.program.put_inside(make_affine(np.diag(signs))))
        return replace(chain, mirrored_axis=axes[-1]) if axes else chain

    def put_inside(self, other: "Frames") -> "Frames":
        """The programmable frame of another chain inside of this one."""
        program = self.program.put_inside(other.program)
        a, b, c = (old + new for old, new in zip(self.rotary, other.rotary, strict=True))
        mirrors = np.linalg.det(other.program.linear) < 0
        mirrored_axis = other.mirrored_axis if mirrors else self.mirrored_axis
        return replace(self, program=program, rotary=(a, b, c), mirrored_axis=mirrored_axis)

    @property
    def total(self) -> Affine:
        """Everything after the work offset."""
        return self.swivel.put_inside(self.program)
