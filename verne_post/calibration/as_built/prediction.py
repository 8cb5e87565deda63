"""What the tool is off over the workspace before and after a calibration, as far as the readings tell."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.rotations import find_axis_of_angles
from verne_post.calibration.as_built.model import AsBuiltModel
from verne_post.calibration.as_built.workspace import WorkspacePoses
from verne_post.kinematics.as_built.machine import AsBuiltMachine
from verne_post.kinematics.as_built.parameter_rates import COUNT
from verne_post.model.deviations import Deviations
from verne_post.model.protocols import FiveAxis

#: Machines drawn from what the readings leave open; at every pose each has its own error.
DRAWS: Final = 64


class ToolErrors(Struct, frozen=True, eq=False):
    """Distances of tips (mm) and angles of tool axes (rad) from where they should be; NaN out of reach."""

    tip: Array
    axis: Array


def compute_tool_errors(model: AsBuiltModel, deviations: Array, joints: Array, poses: WorkspacePoses) -> ToolErrors:
    """How far a machine with these deviations (58,) is from poses (n,) when it stands at ``joints`` (n, 5)."""
    found = model.predict(deviations, joints, poses.length)
    wanted = find_axis_of_angles(poses.angles[:, 0], poses.angles[:, 1])
    return ToolErrors(np.linalg.norm(found.tip - poses.tip, axis=1), _compute_angles(found.axis, wanted))


def _compute_angles(one: Array, other: Array) -> Array:
    """Small angles between unit vectors (..., 3), rad."""
    return np.asarray(2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(one - other, axis=-1), 1.0)))


def predict_errors_before(model: AsBuiltModel, found: Array, present: FiveAxis, poses: WorkspacePoses) -> ToolErrors:
    """Errors (n,) of the machine as found (58,) when the machine file in use makes its joints."""
    return compute_tool_errors(model, found, present.find_joints(poses.tip, poses.angles, poses.length), poses)


class ErrorsAfter(Struct, frozen=True, eq=False):
    """Errors that are left after a calibration, of :data:`DRAWS` machines that the readings allow, each (n, DRAWS)."""

    #: The tip is off by what is not known; the axis also by what A cannot correct while C stays as programmed.
    errors: ToolErrors
    unknown_axis: Array  #: The part of the axis error that is not known, rad.
    shape: Array  #: Tip errors without the shift and turn of the whole part that each machine makes, mm.


def predict_errors_after(machine: AsBuiltMachine, found: Array, factor: Array, poses: WorkspacePoses) -> ErrorsAfter:
    """Errors that are left when the found deviations make the joints.

    Parameters
    ----------
    found : ndarray, shape (58,)
    factor : ndarray, shape (p, p)
        What is left open: see :attr:`Fit.factor`.
    poses : WorkspacePoses
        n poses.
    """
    calibrated = machine.replace_deviations(Deviations.build_from_vector(found))
    joints = calibrated.find_joints(poses.tip, poses.angles, poses.length)
    at, rates = AsBuiltModel(machine).differentiate(found, joints, poses.length)
    drawn = factor[:COUNT] @ np.random.default_rng(0).standard_normal((len(factor), DRAWS))
    tip = np.einsum("nkp,pd->nkd", rates.tip, drawn)
    axis = np.einsum("nkp,pd->nkd", rates.axis, drawn)
    wanted = find_axis_of_angles(poses.angles[:, 0], poses.angles[:, 1])
    left = at.axis - wanted
    errors = ToolErrors(np.linalg.norm(tip, axis=1), np.linalg.norm(left[:, :, None] + axis, axis=1))
    return ErrorsAfter(
        errors, np.linalg.norm(axis, axis=1), np.linalg.norm(_remove_rigid_motion(tip, poses.tip), axis=1)
    )


def _remove_rigid_motion(moved: Array, point: Array) -> Array:
    """Small displacements (n, 3, d) of points (n, 3) without the shift and turn that comes nearest to each of the d."""
    turned = -np.cross(point[:, None, :], np.eye(3)[None]).transpose(0, 2, 1)  # by turns about x, y, z
    basis = np.concatenate([np.broadcast_to(np.eye(3), turned.shape), turned], axis=2).reshape(-1, 6)
    flat = moved.reshape(len(basis), -1)
    share = np.linalg.lstsq(basis, flat, rcond=None)[0]
    return np.asarray((flat - basis @ share).reshape(moved.shape))


def expect_tip_error(machine: AsBuiltMachine, found: Array, factor: Array, poses: WorkspacePoses) -> Array:
    """Root mean square (n,) of the tip error that is left, mm."""
    joints = machine.replace_deviations(Deviations.build_from_vector(found)).find_joints(
        poses.tip, poses.angles, poses.length
    )
    rates = AsBuiltModel(machine).differentiate(found, joints, poses.length)[1]
    return np.asarray(np.sqrt(((rates.tip @ factor[:COUNT]) ** 2).sum(axis=(1, 2))))


def find_quantiles(values: Array) -> tuple[float, float, float]:
    """Median, 95 % and maximum of what is reached."""
    reached = values[np.isfinite(values)]
    return float(np.median(reached)), float(np.quantile(reached, 0.95)), float(reached.max())
