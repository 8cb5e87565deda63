"""How the tool on the table moves with each deviation of the parts, at fixed joints, and with each joint.

The six rods stay closed: with f_i half the miss of the squared length of rod i, the platform follows a change of the
parts by ``-J^-1 df``, J having the rows ``(v_i, (R a_i) x v_i)``. The table's axes then carry the tip along.

Arrays keep poses first and what is differentiated by last: (n, 3, 58).
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.kinematics.as_built.forward import PlatformPose, find_rod_vectors
from verne_post.kinematics.as_built.geometry import LEG, MIRROR, AsBuiltGeometry
from verne_post.model.deviations import ENTRIES


def _index_parameters() -> dict[str, slice]:
    places, first = {}, 0
    for name, (_key, shape, _angle) in ENTRIES.items():
        places[name] = slice(first, first + int(np.prod(shape)))
        first = places[name].stop
    return places


#: Where each entry of the deviations stands among all 58 parameters.
PLACES: Final = _index_parameters()
#: Number of parameters.
COUNT: Final = max(place.stop for place in PLACES.values())


class ToolRates(Struct, frozen=True, eq=False):
    """Tip (mm) and tool axis in the table frame: derivatives by the parts and by the joints."""

    #: tip, axis (n, 3, 58): By the deviations of :data:`verne_post.model.deviations.PARAMETERS`, mm and rad.
    tip: Array
    axis: Array
    #: tip_by_joint, axis_by_joint (n, 3, 5): By rho1, rho2, rho3 (mm), A and C (rad).
    tip_by_joint: Array
    axis_by_joint: Array


def differentiate_tool(
    geometry: AsBuiltGeometry, pose: PlatformPose, rho: Array, angles: Array, length: Array
) -> ToolRates:
    """Differentiate tip and tool axis.

    Parameters
    ----------
    pose : PlatformPose
        The solution of :func:`solve_rods` for ``rho``.
    rho : ndarray, shape (3, n)
    angles : ndarray, shape (2, n)
        Joints A and C, rad.
    length : ndarray, shape (n,)
        From P to the tip, mm.
    """
    spindle = np.einsum("kjn,j->nk", pose.rotation, geometry.spindle)
    moved = _compute_pose_rates(geometry, pose, rho)  # (n, 6, 58 + 5)
    by_turn = np.cross(moved[:, 3:], spindle[:, :, None], axis=1)
    # the spindle's own direction, in the platform
    own = np.einsum("kjn,jp->nkp", pose.rotation, _compute_unit_rates(geometry.spindle, (0, 1)))
    by_turn[:, :, PLACES["spindle"]] += own
    tip = MIRROR[:, None] * (moved[:, :3] + length[:, None, None] * by_turn)
    axis = -MIRROR[:, None] * by_turn
    upright = MIRROR[:, None] * (pose.position + length * spindle.T - geometry.pivot[:, None])
    return _carry_over(geometry, upright.T, -MIRROR * spindle, angles, tip, axis)


def _compute_unit_rates(unit: Array, free: tuple[int, int]) -> Array:
    """Derivatives (3, 2) of the unit vector along (x, y, 1), or (1, y, z), by its two free components."""
    fixed = ({0, 1, 2} - set(free)).pop()
    return np.stack([(np.eye(3)[k] - unit * unit[k]) * unit[fixed] for k in free], axis=1)


def _compute_pose_rates(geometry: AsBuiltGeometry, pose: PlatformPose, rho: Array) -> Array:
    """P (mm) and the turn of the platform (rad), (n, 6), by the 58 parameters and the five joints: (n, 6, 63)."""
    rods, arms = find_rod_vectors(geometry, rho, pose.position, pose.rotation)
    moments = np.cross(arms, rods, axis=0)
    matrix = np.concatenate([rods, moments]).transpose(2, 1, 0)  # (n, rods, 6)
    n = len(matrix)
    follow = -np.linalg.inv(matrix)  # (n, 6, rods)
    rates = np.zeros((n, 6, COUNT + 5))
    rods = rods.transpose(2, 1, 0)  # (n, rods, 3)
    in_platform = np.einsum("kjn,nik->nij", pose.rotation, rods)
    rates[:, :, PLACES["platform_ends"]] = (follow[..., None] * in_platform[:, None]).reshape(n, 6, 18)
    rates[:, :, PLACES["slider_ends"]] = -(follow[..., None] * rods[:, None]).reshape(n, 6, 18)
    rates[:, :, PLACES["rod_lengths"]] = -follow * geometry.rods
    for rod, leg in enumerate(LEG):
        tangent = _compute_unit_rates(geometry.guides[rod], (0, 1))
        by_guide = -rho[leg][:, None] * (rods[:, rod] @ tangent)
        by_slider = -(rods[:, rod] @ geometry.guides[rod])
        first = PLACES["guides"].start + 2 * leg
        rates[:, :, first : first + 2] += follow[:, :, rod, None] * by_guide[:, None]
        rates[:, :, COUNT + leg] += follow[:, :, rod] * by_slider[:, None]
    return rates


def _carry_over(
    geometry: AsBuiltGeometry, upright: Array, direction: Array, angles: Array, tip: Array, axis: Array
) -> ToolRates:
    """Rates in the upright frame (n, 3, 63) in the table frame, with those of the table's own axes.

    ``upright`` and ``direction`` (n, 3) are tip and tool axis in the upright frame.
    """
    n = len(upright)
    a, c = angles
    tilted, turned = _make_rotations(geometry.tilt_axis, -a), _make_rotations(geometry.rotary_axis, -c)
    both = turned @ tilted
    tip, axis = both @ tip, both @ axis
    from_tilt = upright - geometry.tilt_origin
    on_tilt = (tilted @ from_tilt[..., None])[..., 0] + geometry.tilt_origin - geometry.rotary_origin
    axis_on_tilt = (tilted @ direction[..., None])[..., 0]
    free_y_z, free_x_y = np.eye(3)[:, 1:], np.eye(3)[:, :2]
    tip[:, :, PLACES["tilt_place"]] += turned @ (free_y_z - tilted @ free_y_z)
    tip[:, :, PLACES["rotary_place"]] -= turned @ free_x_y
    for name, unit, free, angle, point, vector, after in (
        ("tilt_direction", geometry.tilt_axis, (1, 2), -a, from_tilt, direction, turned),
        ("rotary_direction", geometry.rotary_axis, (0, 1), -c, on_tilt, axis_on_tilt, np.eye(3)),
    ):
        tangent = _compute_unit_rates(unit, free)
        tip[:, :, PLACES[name]] += after @ _compute_turned_rates(unit, tangent, point, angle)
        axis[:, :, PLACES[name]] += after @ _compute_turned_rates(unit, tangent, vector, angle)
    for column, unit, point, vector, after in (
        (COUNT + 3, geometry.tilt_axis, (tilted @ from_tilt[..., None])[..., 0], axis_on_tilt, turned),
        (
            COUNT + 4,
            geometry.rotary_axis,
            (turned @ on_tilt[..., None])[..., 0],
            (turned @ axis_on_tilt[..., None])[..., 0],
            np.broadcast_to(np.eye(3), (n, 3, 3)),
        ),
    ):
        tip[:, :, column] -= (after @ np.cross(unit, point)[..., None])[..., 0]
        axis[:, :, column] -= (after @ np.cross(unit, vector)[..., None])[..., 0]
    return ToolRates(tip[:, :, :COUNT], axis[:, :, :COUNT], tip[:, :, COUNT:], axis[:, :, COUNT:])


def _make_rotations(unit: Array, angle: Array) -> Array:
    """Rotations (n, 3, 3) about a unit vector by angles (n,)."""
    skew = np.cross(unit, np.eye(3)).T  # skew @ w = unit x w
    outer = np.outer(unit, unit)
    c, s = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    return np.asarray(outer + (np.eye(3) - outer) * c + skew * s)


def _compute_turned_rates(unit: Array, tangent: Array, vector: Array, angle: Array) -> Array:
    """Derivatives (n, 3, 2) of vectors (n, 3) turned about ``unit``, where that changes by ``tangent`` (3, 2)."""
    less, s = (1.0 - np.cos(angle))[:, None, None], np.sin(angle)[:, None, None]
    along = vector @ unit
    across = np.einsum("k,np->nkp", unit, vector @ tangent)
    return np.asarray(
        (tangent * along[:, None, None] + across) * less + np.cross(tangent.T, vector[:, None]).transpose(0, 2, 1) * s
    )
