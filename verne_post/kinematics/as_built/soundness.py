"""Whether the as-built machine works where the nominal one does, and if not, which parameter is at fault."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.model.deviations import IS_ANGLE, PARAMETERS, Deviations

#: Only places are tried whose drops are at least this share of the shortest rod, and twice what the machine file asks
#: for. Nearer to a serial singularity a deviation of some tenths may cost a solution: a finding of the pose.
WORKING_SHARE: Final = 0.25
#: Slider positions are tried at so many places of each travel, and A and C at these angles (rad).
PLACES: Final = 5
_ANGLES: Final = np.radians([[0.0, 0.0], [60.0, 30.0], [-60.0, 200.0]])
#: Sizes by which places (mm) and directions (rad) are compared when the largest deviation is sought.
_SIZE_MM, _SIZE_RAD = 0.05, 1e-4
#: Joints closer together than this (mm, rad) are the same: another working mode is tens of millimetres away.
SAME_JOINTS: Final = 1e-6


def find_fault(machine: AsBuiltMachine, travel: Array, smallest_drop: float) -> str | None:
    """The parameter that keeps a machine from working where its nominal one does; None where it works.

    The sliders take places of their travel (3, 2), mm, at which the nominal machine closes with drops (mm) well above
    ``smallest_drop``; there the as-built one has to close too, and its inverse has to lead back to the same sliders.

    Returns
    -------
    str or None
        The largest deviation without which the machine works, or where none alone is enough the largest, with its size.
    """
    q = _sample_joints(machine, travel, smallest_drop)
    if _can_close(machine, q):
        return None
    size = machine.deviations.pack_vector() / np.where(IS_ANGLE, _SIZE_RAD, _SIZE_MM)
    order = [int(k) for k in np.argsort(-np.abs(size)) if size[k] != 0.0]
    for k in order:
        vector = machine.deviations.pack_vector()
        vector[k] = 0.0
        if _can_close(machine.replace_deviations(Deviations.build_from_vector(vector)), q):
            return _name(machine.deviations, k)
    return _name(machine.deviations, order[0])


def _name(deviations: Deviations, index: int) -> str:
    value = float(deviations.pack_vector()[index])
    shown, unit = (value * 1e3, "mrad") if IS_ANGLE[index] else (value, "mm")
    return f"{PARAMETERS[index]} = {shown:g} {unit}"


def _sample_joints(machine: AsBuiltMachine, travel: Array, smallest_drop: float) -> Array:
    """Joint values (n, 5) at which the nominal machine closes."""
    each = [np.linspace(low, high, PLACES) for low, high in travel]
    rho = np.stack(np.meshgrid(*each, indexing="ij"), axis=-1).reshape(-1, 3)
    module = machine.nominal_machine.module
    least = max(2.0 * smallest_drop, WORKING_SHARE * float(machine.geometry.rods.min()))
    position, alpha, ok = module.forward(rho)
    with np.errstate(invalid="ignore"):
        ok &= (module.find_geometry_margins(position, alpha)[:, :3] > least).all(axis=1)
    return np.concatenate([np.column_stack([rho[ok], np.tile(pair, (int(ok.sum()), 1))]) for pair in _ANGLES])


def _can_close(machine: AsBuiltMachine, q: Array) -> bool:
    """Whether the rods close at joint values (n, 5), and the inverse leads back to them."""
    tip, angles, ok = machine.find_nominal_pose(q, 0.0)
    if not ok.all():
        return False
    back = machine.find_joints(tip, angles, 0.0)
    with np.errstate(invalid="ignore"):
        return bool((np.abs(back - q).max(axis=1) < SAME_JOINTS).all())
