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
    prior : Prior
        What is known before.
    lengths : sequence of float
        Tools, gauge line to tip, mm.
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
    prior : Prior
        What is known before.
    candidates : WorkspacePoses
        Each may be chosen once.
    workspace : WorkspacePoses
        Where the tip error counts.
    count : int
        Poses to choose, no more than there are candidates.

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
    gains = _Gains(design, covariance, weight)
    while len(chosen) < count:
        chosen.append(gains.find_best(chosen))
        gains.update(covariance, design[chosen[-1]], 1)
        covariance = _update_covariance(covariance, design[chosen[-1]])
    error = float(np.einsum("pq,pq->", weight, covariance))
    for _ in range(ROUNDS):
        before = error
        gains = _Gains(design, covariance, weight)  # afresh: rounding adds up in what is updated
        for place in range(count):
            gains.update(covariance, design[chosen[place]], -1)
            rest = [other for k, other in enumerate(chosen) if k != place]
            rows = design[rest].reshape(-1, weight.shape[0])
            without = np.asarray(np.linalg.inv(np.eye(weight.shape[0]) + rows.T @ rows), dtype=np.float64)
            chosen[place] = gains.find_best(rest)
            gains.update(without, design[chosen[place]], 1)
            covariance = _update_covariance(without, design[chosen[place]])
        error = float(np.einsum("pq,pq->", weight, covariance))
        if error > (1.0 - GAIN) * before:
            break
    return chosen, np.sqrt(np.einsum("nkp,pq,nkq->n", seen, covariance, seen))


class _Gains:
    """What a reading of each candidate would take away from the mean square error.

    A reading that comes or goes changes the covariance by a product of three columns: to follow it takes a tenth of the
    time of all products with the new covariance.

    Parameters
    ----------
    design : ndarray, shape (n, 3, p)
    covariance, weight : ndarray, shape (p, p)
    """

    def __init__(self, design: Array, covariance: Array, weight: Array) -> None:
        self.flat, self.weight = design.reshape(-1, len(weight)), weight  # one product in place of n small ones
        moved = self.flat @ covariance
        weighed = (moved @ weight).reshape(design.shape)
        moved = moved.reshape(design.shape)
        self.known = np.einsum("nip,njp->nij", moved, design)  #: (n, 3, 3): Covariance of each reading.
        self.gained = np.einsum("nip,njp->nij", weighed, moved)  #: (n, 3, 3): The same by what the weight counts of it.

    def find_best(self, chosen: list[int]) -> int:
        """The candidate whose reading takes most away, but for those that are chosen."""
        gain = np.trace(np.linalg.solve(self.known + np.eye(3), self.gained), axis1=1, axis2=2)
        gain[chosen] = -np.inf
        return int(np.argmax(gain))

    def update(self, covariance: Array, rows: Array, sign: int) -> None:
        """Add a reading of derivatives (3, p) to those that led to a covariance; with a ``sign`` of -1 take it away."""
        moved = covariance @ rows.T
        inverse = np.linalg.inv(sign * np.eye(len(rows)) + rows @ moved)
        weighed = self.weight @ moved
        seen = (self.flat @ moved).reshape(self.known.shape)
        crossed = (self.flat @ (covariance @ weighed)).reshape(self.known.shape)
        share = seen @ inverse
        lost = share @ crossed.transpose(0, 2, 1)
        self.known -= share @ seen.transpose(0, 2, 1)
        self.gained += share @ (moved.T @ weighed) @ share.transpose(0, 2, 1) - lost - lost.transpose(0, 2, 1)


def _update_covariance(covariance: Array, rows: Array) -> Array:
    """The covariance (p, p) once a reading with these derivatives (3, p), in its uncertainties, is known."""
    moved = covariance @ rows.T
    spread = np.eye(len(rows)) + rows @ moved
    return np.asarray(covariance - moved @ np.linalg.solve(spread, moved.T))
