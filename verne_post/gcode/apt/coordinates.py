"""What moves the coordinates of statements: TRACUT, MSYS, CSYS, and shifts that only a post-processor could make."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.gcode.affine import Affine, find_nearest_rotation, make_affine
from verne_post.gcode.apt.statements import Statement, is_number, read_numbers
from verne_post.gcode.program_error import ProgramError

#: How far the rows of a rotation may be off unit length and right angles: matrices are printed with few decimals.
_ROTATION: Final = 1e-5
#: Matrices of one frame, each rebuilt from printed decimals, differ by less than this (1 and mm).
_SAME_FRAME: Final = 1e-9

#: Numbers of a matrix: rotation and shift, row by row.
NUMBERS: Final = 12


def read_matrix(statement: Statement) -> Affine:
    """The map of ``TRACUT/a1,b1,c1,d1,a2,...``, rotation and shift; the identity for ``TRACUT/NOMORE``.

    Raises
    ------
    ProgramError
        For another number of words, for a scale, a mirror image or a shear.
    """
    name = statement.major
    if name == "TRACUT" and [word.upper() for word in statement.words] == ["NOMORE"]:
        return Affine()
    numbers = read_numbers(statement, statement.words)
    if len(numbers) != NUMBERS:
        or_none = ", or NOMORE" if name == "TRACUT" else ""
        raise ProgramError(
            "VP005", f"{name} takes the 12 numbers of a matrix, row by row{or_none}; here are {len(numbers)}"
        )
    return _make_rigid(name, np.array(numbers).reshape(3, 4))


def read_machine_system(statement: Statement) -> Affine:
    """The map of ``MSYS/x,y,z,i,j,k,i,j,k``: origin, X and Y of the system of points, in those of the model.

    Raises
    ------
    ProgramError
        For another number of words; where X and Y are no unit vectors at a right angle.
    """
    numbers = read_numbers(statement, statement.words)
    if len(numbers) != 9:
        raise ProgramError("VP005", f"MSYS takes an origin, X and Y: 9 numbers; here are {len(numbers)}")
    x, y = np.array(numbers[3:6]), np.array(numbers[6:])
    return _make_rigid("MSYS", np.column_stack([x, y, np.cross(x, y), numbers[:3]]))


def _make_rigid(name: str, matrix: Array) -> Affine:
    """The map of a printed matrix (3, 4) with an exact rotation; refuses (VP002) what is none."""
    rotation = matrix[:, :3]
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > _ROTATION or np.linalg.det(rotation) < 0:
        raise ProgramError(
            "VP002",
            f"{name} is executed for rotations and shifts; this matrix scales, mirrors or shears; let APT compute it",
        )
    return make_affine(find_nearest_rotation(rotation), matrix[:, 3])


def join_maps(outer: Affine, inner: Affine) -> Affine:
    """The map that turns and shifts by ``inner``, then by ``outer``; the identity itself where it does nothing."""
    both = outer.put_inside(inner)
    return Affine() if both.is_near(Affine(), _SAME_FRAME) else both


def check_no_shift(s: Statement) -> None:
    """Refuse ORIGIN and TRANS, unless they shift by 0, 0, 0: each post-processor has its own meaning of them.

    Raises
    ------
    ProgramError
        For any other.
    """
    if [word.upper() for word in s.words] not in (["OFF"], ["NOMORE"]) and (
        not all(map(is_number, s.words)) or any(read_numbers(s, s.words))
    ):
        raise ProgramError(
            "VP002",
            f"{s.major} shifts what a post-processor writes, and each does it in its own way: give the place of the "
            "part as its work offset (--wcs), or write TRACUT with a matrix",
        )
