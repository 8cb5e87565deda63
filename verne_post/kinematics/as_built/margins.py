"""Geometric margins of the as-built machine, from all six rods: drops, crossing, singularities, axis error."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.units import DEG_PER_RAD
from verne_post.kinematics.as_built.forward import find_rod_vectors
from verne_post.kinematics.as_built.geometry import FIRST_ROD, SECOND_ROD, AsBuiltGeometry
from verne_post.kinematics.as_built.inverse import cross, sum_products
from verne_post.kinematics.modules.solutions import build_determinant_margin, drop_margins
from verne_post.model.protocols import Margin

#: What is left of the tool axis error, once in either direction: both must be above minus the threshold.
_AXIS_ERROR: Final = ("tool axis error left over (+)", "tool axis error left over (-)")


def name_margins(
    actuators: tuple[str, ...], serial_singularity: float, parallel_singularity: float, axis_error_deg: float
) -> tuple[Margin, ...]:
    """What :func:`measure_margins` measures; an axis error beyond ``axis_error_deg`` is VP217, infinite: never."""
    crossing = Margin("R1 cos(alpha) - r1", "VP201", None, "mm", 0.0, 0.0)
    holds = Margin("hold of legs II and III against turning", "VP203", None, "", *([parallel_singularity] * 2))
    axis = (Margin(name, "VP217", None, "deg", -axis_error_deg, -axis_error_deg) for name in _AXIS_ERROR)
    return (
        *drop_margins(actuators, serial_singularity),
        crossing,
        build_determinant_margin(parallel_singularity),
        holds,
        *axis,
    )


def measure_margins(
    geometry: AsBuiltGeometry, rho: Array, position: Array, rotation: Array, across: Array, side: tuple[float, float]
) -> Array:
    """Margins of solved poses, shape (n, 8), in the order of :func:`name_margins`.

    The drop of each leg along its guide, the mean of both rods (mm); half of how much farther apart the rods of leg I
    are across at the platform than at the sliders (mm), which is R1 cos(alpha) - r1 of the nominal machine; the scaled
    determinant of the parallel Jacobian; how well legs II and III hold the platform against turns about y and z; and
    the axis error ``across`` (n,) of either sign, degrees.

    Parameters
    ----------
    rho : ndarray, shape (3, n)
    position : ndarray, shape (3, n)
    rotation : ndarray, shape (3, 3, n)
    across : ndarray, shape (n,)
        rad.
    side : tuple of 2 floats
        Signs of :func:`compute_scaled_determinants` in the middle of the workspace.
    """
    rods, arms = find_rod_vectors(geometry, rho, position, rotation)
    drop = sum_products(geometry.guides.T[:, :, None], rods)
    drop = 0.5 * (drop[FIRST_ROD] + drop[SECOND_ROD])
    sliders = geometry.slider_ends[0, 1] - geometry.slider_ends[1, 1]
    apart = 0.5 * (arms[1, 0] - arms[1, 1] - sliders)
    whole, hold = compute_scaled_determinants(geometry, rods, arms)
    left = DEG_PER_RAD * across
    return np.stack([*drop, apart, side[0] * whole, side[1] * hold, left, -left], axis=-1)


def compute_scaled_determinants(geometry: AsBuiltGeometry, rods: Array, arms: Array) -> tuple[Array, Array]:
    """Determinant of the nominal machine's four equations within the six-rod Jacobian, and that of the rest; (n,).

    The rows are (v_i, (R a_i) x v_i). With equal and parallel rods the determinant is the product of the one of the
    four equations (3) to (6) and of what holds the platform against turns about y and z; the latter is the second
    value, over rods and spacings, and the first is the quotient.
    """
    moments = cross(arms, rods)
    rows, others = rods[:, FIRST_ROD], rods[:, SECOND_ROD]
    first, second, third = rows[:, 0], rows[:, 1], rows[:, 2]
    block = np.stack([cross(second, third), cross(third, first), cross(first, second)], axis=1)
    volume = sum_products(first, block[:, 0])
    share = np.einsum("kin,kjn->ijn", others, block / volume)
    rest = moments[:, SECOND_ROD] - np.einsum("ijn,kjn->kin", share, moments[:, FIRST_ROD])
    whole = volume * sum_products(rest[:, 0], cross(rest[:, 1], rest[:, 2]))
    ends = geometry.platform_ends
    spacing = [float(np.linalg.norm(ends[k] - ends[k + 1])) for k in (2, 4)]
    turn2, turn3 = (cross(arms[:, k] - arms[:, k + 1], 0.5 * (rods[:, k] + rods[:, k + 1])) for k in (2, 4))
    hold = (turn2[1] * turn3[2] - turn2[2] * turn3[1]) / (spacing[0] * spacing[1])
    length = geometry.rods
    arm = float(np.abs(ends[:, 1]).max())
    scale = length[0] * length[1] * length[2] * length[4] * arm
    with np.errstate(divide="ignore", invalid="ignore"):
        quotient = whole / (hold * spacing[0] * spacing[1] * scale)
    return quotient, hold / (length[2] * length[4])
