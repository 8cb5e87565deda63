"""What moves the coordinates of statements: TRACUT, MSYS, CSYS, and shifts that only a post-processor could make."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.gcode.apt.statements import Statement, is_number, read_numbers
from verne_post.gcode.program_error import ProgramError

#: How far the rows of a rotation may be off unit length and right angles: matrices are printed with few decimals.
_ROTATION: Final = 1e-5
#: Matrices of one frame, each rebuilt from printed decimals, differ by less than this (1 and mm).
_SAME_FRAME: Final = 1e-9

#: Statements are in the coordinates of the part.
IDENTITY: Final[Array] = np.eye(3, 4)


def read_matrix(statement: Statement) -> Array:
    """The 3x4 matrix of ``TRACUT/a1,b1,c1,d1,a2,...``, rotation and shift; the identity for ``TRACUT/NOMORE``.

    Raises
    ------
    ProgramError
        For another number of words, for a scale, a mirror image or a shear.
    """
    name = statement.major
    if name == "TRACUT" and [word.upper() for word in statement.words] == ["NOMORE"]:
        return IDENTITY
    numbers = read_numbers(statement, statement.words)
    if len(numbers) != IDENTITY.size:
        or_none = ", or NOMORE" if name == "TRACUT" else ""
        raise ProgramError(
            "VP005", f"{name} takes the 12 numbers of a matrix, row by row{or_none}; here are {len(numbers)}"
        )
    return _make_rigid(name, np.array(numbers).reshape(IDENTITY.shape))


def read_machine_system(statement: Statement) -> Array:
    """The 3x4 matrix of ``MSYS/x,y,z,i,j,k,i,j,k``: origin, X and Y of the system of points, in those of the model.

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


def _make_rigid(name: str, matrix: Array) -> Array:
    """A printed matrix with an exact rotation; refuses (VP002) what is none."""
    rotation = matrix[:, :3]
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > _ROTATION or np.linalg.det(rotation) < 0:
        raise ProgramError(
            "VP002",
            f"{name} is executed for rotations and shifts; this matrix scales, mirrors or shears; let APT compute it",
        )
    left, _sizes, right = np.linalg.svd(rotation)
    return np.column_stack([left @ right, matrix[:, 3]])


def join_matrices(outer: Array, inner: Array) -> Array:
    """The matrix (3x4) that turns and shifts by ``inner``, then by ``outer``; IDENTITY itself where it does nothing."""
    if outer is IDENTITY:
        return inner
    rotation = outer[:, :3]
    matrix = np.column_stack([rotation @ inner[:, :3], rotation @ inner[:, 3] + outer[:, 3]])
    return IDENTITY if np.abs(matrix - IDENTITY).max() < _SAME_FRAME else matrix


def find_relation(system: Array, first: Array) -> Array:
    """The matrix (3x4) from one machine system to another, both given in the model."""
    back = first[:, :3].T
    return join_matrices(np.column_stack([back, -back @ first[:, 3]]), system)


def apply(matrix: Array, values: list[float], *, shift: bool) -> list[float]:
    """A point (``shift``) or a direction of the statements in the coordinates of the part."""
    if matrix is IDENTITY:
        return values
    moved = matrix[:, :3] @ np.array(values)
    return [float(value) for value in (moved + matrix[:, 3] if shift else moved)]


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
