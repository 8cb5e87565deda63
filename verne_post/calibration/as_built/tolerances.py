"""What the tolerance of each part does to the tool over the workspace, on a machine that nobody calibrates."""

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.calibration.as_built.model import AsBuiltModel
from verne_post.calibration.as_built.workspace import WorkspacePoses
from verne_post.model.deviations import PARAMETERS


class Sensitivity(Struct, frozen=True):
    """What one parameter, off by its tolerance, does to the tool.

    ``tolerance`` in mm or rad; tip errors in mm (root mean square and largest over the workspace), axis errors in rad.
    """

    name: str
    angle: bool
    tolerance: float
    tip: float
    tip_max: float
    axis: float
    axis_max: float


class ToleranceStudy(Struct, frozen=True, eq=False):
    """All parameters, worst first, and all together: root mean squares at each pose (n,), mm and rad."""

    parameters: tuple[Sensitivity, ...]
    tip: Array
    axis: Array


def study_tolerances(
    model: AsBuiltModel, deviations: Array, tolerances: Array, poses: WorkspacePoses, angle: Array
) -> ToleranceStudy:
    """Rank the parameters by the tip error that their tolerances (58,) make at joints held as they are.

    Parameters
    ----------
    deviations : ndarray, shape (58,)
        About which the machine is differentiated.
    tolerances : ndarray, shape (58,)
        Standard deviations, mm and rad.
    angle : ndarray of bool, shape (58,)
        Which parameters are angles.
    """
    _found, rates = model.differentiate(deviations, poses.joints, poses.length)
    tip = np.linalg.norm(rates.tip, axis=1) * tolerances  # (n, 58)
    axis = np.linalg.norm(rates.axis, axis=1) * tolerances
    tip_rms, axis_rms = (np.sqrt((values**2).mean(axis=0)) for values in (tip, axis))
    order = np.argsort(-tip_rms, kind="stable")
    ranked = tuple(
        Sensitivity(
            PARAMETERS[k],
            bool(angle[k]),
            float(tolerances[k]),
            float(tip_rms[k]),
            float(tip[:, k].max()),
            float(axis_rms[k]),
            float(axis[:, k].max()),
        )
        for k in order
    )
    return ToleranceStudy(ranked, np.sqrt((tip**2).sum(axis=1)), np.sqrt((axis**2).sum(axis=1)))
