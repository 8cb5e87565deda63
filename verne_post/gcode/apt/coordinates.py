"""TRACUT: a matrix from the coordinates of the statements to those of the part."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.gcode.apt.statements import Statement, read_numbers
from verne_post.gcode.program_error import ProgramError

#: How far the rows of a rotation may be off unit length and right angles: matrices are printed with few decimals.
_ROTATION: Final = 1e-5

#: Statements are in the coordinates of the part.
IDENTITY: Final[Array] = np.eye(3, 4)


def read_matrix(statement: Statement) -> Array:
    """The 3x4 matrix of ``TRACUT/a1,b1,c1,d1,a2,...``, rotation and shift; the identity for ``TRACUT/NOMORE``.

    Raises
    ------
    ProgramError
        For another number of words, for a scale, a mirror image or a shear.
    """
    if [word.upper() for word in statement.words] == ["NOMORE"]:
        return IDENTITY
    numbers = read_numbers(statement, statement.words)
    if len(numbers) != IDENTITY.size:
        raise ProgramError(
            "VP005", f"TRACUT takes the 12 numbers of a matrix, row by row, or NOMORE; here are {len(numbers)}"
        )
    matrix = np.array(numbers).reshape(IDENTITY.shape)
    rotation = matrix[:, :3]
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > _ROTATION or np.linalg.det(rotation) < 0:
        raise ProgramError(
            "VP002",
            "TRACUT is executed for rotations and shifts; this matrix scales, mirrors or shears, let APT compute it",
        )
    left, _sizes, right = np.linalg.svd(rotation)
    return np.column_stack([left @ right, matrix[:, 3]])


def apply(matrix: Array, values: list[float], *, shift: bool) -> list[float]:
    """A point (``shift``) or a direction of the statements in the coordinates of the part."""
    if matrix is IDENTITY:
        return values
    moved = matrix[:, :3] @ np.array(values)
    return [float(value) for value in (moved + matrix[:, 3] if shift else moved)]
