"""Pose of the platform, and of the tool on the table, for joint values of the as-built machine.

All six rod equations at once, with the six unknowns of the platform: another formulation than the inverse solution,
which is checked with it. Newton's rows are ``(v_i, (R a_i) x v_i)`` with v_i the rod. The rods of one end of each leg
hold P for a given rotation; what the other three miss gives the rotation (block elimination).

Arrays keep components first and poses last, (3, n) and (3, 6, n).
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.base.tolerances import NEWTON_STEP, ROD_RESIDUAL_MM2
from verne_post.kinematics.as_built.geometry import FIRST_ROD, LEG, MIRROR, SECOND_ROD, AsBuiltGeometry
from verne_post.kinematics.as_built.inverse import cross, solve_three, sum_products, turn_about, turn_rotation

#: Newton's steps from the nominal machine's pose; three where the machine works.
STEPS: Final = 12


class PlatformPose(Struct, frozen=True, eq=False):
    """Where the platform is: P (3, n) in the base frame (mm), R (3, 3, n), and whether the rods close (n,)."""

    position: Array
    rotation: Array
    ok: Mask


def find_rod_vectors(geometry: AsBuiltGeometry, rho: Array, position: Array, rotation: Array) -> tuple[Array, Array]:
    """Rods from slider to platform, and the arms R a_i, both (3, 6, n), mm."""
    arms = np.matmul(geometry.platform_ends, rotation)
    sliders = geometry.slider_ends.T[:, :, None] + geometry.guides.T[:, :, None] * rho[LEG]
    return position[:, None] + arms - sliders, arms


def solve_rods(geometry: AsBuiltGeometry, rho: Array, position: Array, rotation: Array) -> PlatformPose:
    """The platform's pose for sliders (3, n) by Newton's method from a pose near it."""
    longest = float(geometry.rods.max())
    reach = float(np.linalg.norm(geometry.platform_ends, axis=1).max())
    converged = np.zeros(rho.shape[1], dtype=bool)
    for _ in range(STEPS):
        rods, arms = find_rod_vectors(geometry, rho, position, rotation)
        move, turn = _step(rods, cross(arms, rods), 0.5 * ((geometry.rods**2)[:, None] - sum_products(rods, rods)))
        position, rotation = position + move, turn_rotation(rotation, turn)
        # the equations are quadratic: the square of this step over a rod is what the next one would be
        moved = np.sqrt(sum_products(move, move)) / longest + np.sqrt(sum_products(turn, turn)) * reach / longest
        converged = moved < NEWTON_STEP
        if bool(converged.all()):
            break
    rods, _arms = find_rod_vectors(geometry, rho, position, rotation)
    miss = np.abs(sum_products(rods, rods) - (geometry.rods**2)[:, None]).max(axis=0)
    ok = converged & (miss < ROD_RESIDUAL_MM2 * max(longest / 850.0, 1.0) ** 2)
    return PlatformPose(position, rotation, ok)


def _step(rods: Array, moments: Array, miss: Array) -> tuple[Array, Array]:
    """Displacement and turn (3, n) with which six linear equations ``rods . move + moments . turn = miss`` hold."""
    rows, others = rods[:, FIRST_ROD], rods[:, SECOND_ROD]
    first, second, third = rows[:, 0], rows[:, 1], rows[:, 2]
    inverse = np.stack([cross(second, third), cross(third, first), cross(first, second)], axis=1)
    inverse = inverse / sum_products(first, inverse[:, 0])  # columns (3, 3, n): move for a unit miss of each first rod
    # of the second rods in terms of the first: others . inverse
    share = np.einsum("kin,kjn->ijn", others, inverse)
    rest = moments[:, SECOND_ROD] - np.einsum("ijn,kjn->kin", share, moments[:, FIRST_ROD])
    left = miss[SECOND_ROD] - np.einsum("ijn,jn->in", share, miss[FIRST_ROD])
    turn = solve_three(rest, left)
    held = miss[FIRST_ROD] - np.einsum("kin,kn->in", moments[:, FIRST_ROD], turn)
    return np.einsum("kjn,jn->kn", inverse, held), turn


def map_tool_to_table(
    geometry: AsBuiltGeometry, pose: PlatformPose, angles: Array, length: Array
) -> tuple[Array, Array]:
    """Tip and tool axis (tip to spindle) in the table frame, each (3, n).

    Parameters
    ----------
    angles : ndarray, shape (2, n)
        Joints A and C, rad.
    length : ndarray, shape (n,)
        From P to the tip, mm.
    """
    spindle = np.einsum("kjn,j->kn", pose.rotation, geometry.spindle)
    tip = MIRROR[:, None] * (pose.position + length * spindle - geometry.pivot[:, None])
    return map_point_to_table(geometry, tip, angles), map_direction_to_table(
        geometry, -MIRROR[:, None] * spindle, angles
    )


def map_point_to_table(geometry: AsBuiltGeometry, point: Array, angles: Array) -> Array:
    """Points (3, n) of the upright frame in the table frame, with joints A and C at ``angles`` (2, n)."""
    on_tilt = map_direction_to_tilt(geometry, point - geometry.tilt_origin[:, None], angles[0])
    seen = on_tilt + (geometry.tilt_origin - geometry.rotary_origin)[:, None]
    return turn_about(geometry.rotary_axis, seen, np.cos(angles[1]), -np.sin(angles[1]))


def map_direction_to_table(geometry: AsBuiltGeometry, direction: Array, angles: Array) -> Array:
    """Directions (3, n) of the upright frame in the table frame."""
    seen = map_direction_to_tilt(geometry, direction, angles[0])
    return turn_about(geometry.rotary_axis, seen, np.cos(angles[1]), -np.sin(angles[1]))


def map_direction_to_tilt(geometry: AsBuiltGeometry, direction: Array, tilt: Array) -> Array:
    """Directions (3, n) of the upright frame in the tilt frame, with joint A at ``tilt`` (n,)."""
    return turn_about(geometry.tilt_axis, direction, np.cos(tilt), -np.sin(tilt))
