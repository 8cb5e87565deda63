"""Tip errors before and after a calibration over planes of the table, for a picture."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.calibration.as_built.model import AsBuiltModel
from verne_post.calibration.as_built.prediction import expect_tip_error, predict_errors_before
from verne_post.calibration.as_built.workspace import WorkspacePoses, solve_legal
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.model.machine import Machine
from verne_post.model.protocols import FiveAxis
from verne_post.output.error_plots import ErrorField

#: Tilts of the planes, degrees, and their height over the table's face as a share of its radius.
TILTS_DEG: Final = (0.0, 45.0)
HEIGHT: Final = 0.4
#: Points along each side of a plane.
RESOLUTION: Final = 61


def compute_error_fields(
    machine: Machine, present: FiveAxis, as_built: AsBuiltMachine, found: Array, factor: Array, length: float
) -> list[ErrorField]:
    """Errors on planes parallel to the table's face; for arguments see :func:`predict_errors_before` and ``_after``."""
    side = np.linspace(-machine.table_radius, machine.table_radius, RESOLUTION)
    x, y = (values.ravel() for values in np.meshgrid(side, side))
    height = HEIGHT * machine.table_radius
    fields = []
    for tilt in TILTS_DEG:
        tip = np.stack([x, y, np.full_like(x, height)], axis=1)
        angles = np.broadcast_to([np.radians(tilt), 0.0], (len(tip), 2))
        tools = np.full(len(tip), length)
        joints, ok = solve_legal(machine, tip, angles, tools)
        ok &= np.hypot(x, y) <= machine.table_radius
        shown = np.flatnonzero(ok)
        poses = WorkspacePoses(tip, angles, tools, joints).take(shown)
        before, after = np.full(len(tip), np.nan), np.full(len(tip), np.nan)
        if len(shown):
            before[shown] = predict_errors_before(AsBuiltModel(as_built), found, present, poses).tip
            after[shown] = expect_tip_error(as_built, found, factor, poses)
        shape = (RESOLUTION, RESOLUTION)
        fields.append(ErrorField(tilt, height, side, before.reshape(shape), after.reshape(shape)))
    return fields
