"""Poses to measure next: those that leave the least tip error over the workspace (I-optimal, greedy, exchanged)."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.calibration.as_built.data import COMMANDED_EXACTLY, JointUncertainty, Prior
from verne_post.calibration.as_built.model import AsBuiltModel
from verne_post.calibration.as_built.program import find_middle, order_poses, reach_from, round_poses
from verne_post.calibration.as_built.workspace import WorkspacePoses, sample_workspace
from verne_post.model.machine import Machine

#: Legal poses among which a plan chooses. Tips of readings may stand higher than parts do: they then tell more.
CANDIDATES: Final = 4000
CANDIDATES_HEIGHT: Final = 2.0
#: ... and no lower than this over the table's face, mm: the machine is still off by tenths, and a probe has a ball.
LOWEST_MM: Final = 20.0
#: Poses over the workspace at which the tip error counts.
WORKSPACE_POSES: Final = 500

#: Exchanges of planned poses against better ones end when a whole round gains less than this share of the error.
GAIN: Final = 1e-3
#: ... and after so many rounds.
ROUNDS: Final = 8


class Plan(Struct, frozen=True, eq=False):
    """Poses in the order in which they are visited."""

    poses: WorkspacePoses
    over: list[bool]  #: Ways to each pose that go over the middle pose.
    middle: Array  #: (3,): Tip of the middle pose, upright, mm.
    errors: Array  #: (m,): Expected tip error over the workspace once they are measured, mm.


def plan_poses(
    machine: Machine,
    model: AsBuiltModel,
    prior: Prior,
    lengths: Sequence[float],
    count: int,
    sigma_tip: float,
    joint_sigma: JointUncertainty = COMMANDED_EXACTLY,
    places: Array | None = None,
) -> Plan:
    """Plan ``count`` readings of tips, each coordinate to ``sigma_tip`` (mm), at joints known to ``joint_sigma``.

    Parameters
    ----------
    machine : Machine
        Whose limits and clearances hold.
    model : AsBuiltModel
    prior : Prior
        What is known before.
    lengths : sequence of float
        Tools, gauge line to tip, mm.
    count : int
    sigma_tip : float
    joint_sigma : JointUncertainty
    places : ndarray, shape (k, 3), optional
        Tips stand at these places of the table frame only, mm.

    Raises
    ------
    ValueError
        The machine reaches too few poses.
    """
    rng = np.random.default_rng(0)
    middle = find_middle(machine, lengths)
    drawn = sample_workspace(machine, CANDIDATES, lengths, rng, places, CANDIDATES_HEIGHT, LOWEST_MM)
    candidates, legal = round_poses(machine, drawn)
    candidates = candidates.take(legal & reach_from(machine, middle, candidates))
    if len(candidates.length) < count:
        raise ValueError(f"only {len(candidates.length)} of {CANDIDATES} poses tried can be visited")
    workspace = sample_workspace(machine, WORKSPACE_POSES, lengths, rng)
    chosen, errors = choose_poses(model, prior, candidates, workspace, count, sigma_tip, joint_sigma)
    poses = candidates.take(np.array(chosen))
    order, over = order_poses(machine, poses)
    return Plan(poses.take(np.array(order)), over, middle, errors)


def choose_poses(
    model: AsBuiltModel,
    prior: Prior,
    candidates: WorkspacePoses,
    workspace: WorkspacePoses,
    count: int,
    sigma_tip: float,
    joint_sigma: JointUncertainty = COMMANDED_EXACTLY,
) -> tuple[list[int], Array]:
    """Choose poses whose tips, measured to ``sigma_tip`` (mm), leave the smallest mean square tip error.

    Parameters
    ----------
    model : AsBuiltModel
    prior : Prior
        What is known before.
    candidates : WorkspacePoses
        Each may be chosen once.
    workspace : WorkspacePoses
        Where the tip error counts.
    count : int
        Poses to choose, no more than there are candidates.
    sigma_tip : float
    joint_sigma : JointUncertainty

    Returns
    -------
    chosen : list of int
        Candidates.
    errors : ndarray, shape (m,)
        Expected tip error (root mean square) at the workspace poses, mm.
    """
    rates = model.differentiate(prior.mean, candidates.joints, candidates.length)[1]
    noise = np.linalg.cholesky(sigma_tip**2 * np.eye(3) + joint_sigma.propagate_covariance(rates.tip_by_joint))
    design = np.linalg.solve(noise, rates.tip @ prior.factor)
    seen = model.differentiate(prior.mean, workspace.joints, workspace.length)[1].tip @ prior.factor
    weight = np.einsum("nkp,nkq->pq", seen, seen) / len(seen)
    covariance = np.eye(weight.shape[0])
    chosen: list[int] = []
    while len(chosen) < count:
        best = _find_best_candidate(design, covariance, weight, chosen)
        chosen.append(best)
        covariance = _update_covariance(covariance, design[best])
    error = float(np.einsum("pq,pq->", weight, covariance))
    for _ in range(ROUNDS):
        before = error
        for place in range(count):
            rest = [other for k, other in enumerate(chosen) if k != place]
            rows = design[rest].reshape(-1, weight.shape[0])
            without = np.asarray(np.linalg.inv(np.eye(weight.shape[0]) + rows.T @ rows), dtype=np.float64)
            chosen[place] = _find_best_candidate(design, without, weight, rest)
            covariance = _update_covariance(without, design[chosen[place]])
        error = float(np.einsum("pq,pq->", weight, covariance))
        if error > (1.0 - GAIN) * before:
            break
    return chosen, np.sqrt(np.einsum("nkp,pq,nkq->n", seen, covariance, seen))


def _find_best_candidate(design: Array, covariance: Array, weight: Array, chosen: list[int]) -> int:
    """The candidate whose reading takes most away from the mean square error."""
    flat = design.reshape(-1, len(covariance)) @ covariance  # (3n, p): one product in place of n small ones
    moved, weighed = flat.reshape(design.shape), (flat @ weight).reshape(design.shape)
    spread = np.einsum("nip,njp->nij", moved, design) + np.eye(design.shape[1])
    gained = np.einsum("nip,njp->nij", weighed, moved)
    gain = np.trace(np.linalg.solve(spread, gained), axis1=1, axis2=2)
    gain[chosen] = -np.inf
    return int(np.argmax(gain))


def _update_covariance(covariance: Array, rows: Array) -> Array:
    """The covariance (p, p) once a reading with these derivatives (3, p), in its uncertainties, is known."""
    moved = covariance @ rows.T
    spread = np.eye(len(rows)) + rows @ moved
    return np.asarray(covariance - moved @ np.linalg.solve(spread, moved.T))
