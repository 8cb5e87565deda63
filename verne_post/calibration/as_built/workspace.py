"""Poses all over the workspace, and what deviations do to the tool there."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.base.rotations import axis_of_angles
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.calibration.as_built.model import AsBuiltModel
from verne_post.kinematics.checks.violations import machine_checks
from verne_post.model.machine import Machine
from verne_post.model.protocols import Pose

#: Tips are taken up to this many times the table's radius above its face.
HEIGHT: Final = 1.0
#: Poses tried at a time; about a quarter of them is legal on the VERNE.
BATCH: Final = 2048
#: So many batches without enough legal poses mean that the machine reaches next to nothing.
MOST_BATCHES: Final = 100


@dataclass(frozen=True, eq=False)
class WorkspacePoses:
    """Legal poses: tip (n, 3) in mm and nominal angles (n, 2) in rad on the table, tool length (n,), joints (n, 5)."""

    tip: Array
    angles: Array
    length: Array
    joints: Array

    def take(self, chosen: Array | list[int] | Mask) -> "WorkspacePoses":
        """Some of the poses."""
        return WorkspacePoses(self.tip[chosen], self.angles[chosen], self.length[chosen], self.joints[chosen])


def solve_legal(machine: Machine, tip: Array, angles: Array, length: Array) -> tuple[Array, Mask]:
    """Joints (n, 5) of poses, and which poses keep every limit and clearance of the machine file."""
    joints, position, alpha, ok = machine.five_axis.solve(tip, angles, length)
    with np.errstate(invalid="ignore"):
        quantities = np.concatenate([joints, machine.module.geometry_margins(position, alpha)], axis=1)
        for check in machine_checks(machine):
            ok = ok & (check.sign * (quantities[:, check.quantity] - check.limit) >= -check.slack)
        nose = tip + length[:, None] * axis_of_angles(angles[:, 0], angles[:, 1])
        for point in (tip, nose):
            height = np.maximum(point[:, 2], np.hypot(point[:, 0], point[:, 1]) - machine.table_radius)
            ok = ok & (height >= -LIMIT_SLACK_MM)
    if machine.clearance is not None and ok.any():
        pose = Pose(position[ok], alpha[ok], joints[ok, :3], tip[ok], angles[ok], length[ok])
        margins = machine.clearance.evaluate(pose)[0]
        low = np.array([margin.error_below for margin in machine.clearance.names])
        ok[np.flatnonzero(ok)] = (margins >= low).all(axis=1)
    return joints, ok


def sample_workspace(
    machine: Machine, count: int, lengths: Sequence[float], rng: np.random.Generator, places: Array | None = None
) -> WorkspacePoses:
    """Draw legal poses: tips over the table's face, every A within its travel, every C.

    Parameters
    ----------
    machine : Machine
    count : int
    lengths : sequence of float
        Tool lengths, mm; each pose has one of them.
    rng : numpy.random.Generator
    places : ndarray, shape (k, 3), optional
        Tips stand at these places of the table frame only.

    Raises
    ------
    ValueError
        The machine reaches hardly any pose.
    """
    parts: list[WorkspacePoses] = []
    found = 0
    low, high = (max(-np.pi, machine.limits.lower[3]), min(np.pi, machine.limits.upper[3]))
    for _ in range(MOST_BATCHES):
        if places is None:
            radius = machine.table_radius * np.sqrt(rng.uniform(size=BATCH))
            around = rng.uniform(-np.pi, np.pi, BATCH)
            height = HEIGHT * machine.table_radius * rng.uniform(size=BATCH)
            tip = np.stack([radius * np.cos(around), radius * np.sin(around), height], axis=1)
        else:
            tip = places[rng.integers(len(places), size=BATCH)]
        turn = (max(-np.pi, machine.limits.lower[4]), min(np.pi, machine.limits.upper[4]))
        angles = np.stack([rng.uniform(low, high, BATCH), rng.uniform(*turn, BATCH)], axis=1)
        length = np.asarray(lengths, dtype=float)[rng.integers(len(lengths), size=BATCH)]
        joints, ok = solve_legal(machine, tip, angles, length)
        parts.append(WorkspacePoses(tip[ok], angles[ok], length[ok], joints[ok]))
        found += int(ok.sum())
        if found >= count:
            break
    else:
        raise ValueError(f"only {found} of {MOST_BATCHES * BATCH} poses tried keep every limit")
    names = ("tip", "angles", "length", "joints")
    return WorkspacePoses(*(np.concatenate([getattr(part, name) for part in parts])[:count] for name in names))


@dataclass(frozen=True, eq=False)
class ToolErrors:
    """Distances of tips (n,) in mm and angles of tool axes (n,) in rad from where they should be."""

    tip: Array
    axis: Array


def tool_errors(model: AsBuiltModel, deviations: Array, joints: Array, poses: WorkspacePoses) -> ToolErrors:
    """How far a machine with these deviations is from programmed poses when it stands at ``joints`` (n, 5)."""
    found = model.predict(deviations, joints, poses.length)
    wanted = axis_of_angles(poses.angles[:, 0], poses.angles[:, 1])
    across = np.linalg.norm(np.cross(found.axis, wanted), axis=1)
    tip = np.linalg.norm(found.tip - poses.tip, axis=1)
    return ToolErrors(np.where(found.ok, tip, np.nan), np.where(found.ok, across, np.nan))


def quantiles(values: Array) -> tuple[float, float, float]:
    """Median, 95 % and maximum."""
    return float(np.median(values)), float(np.quantile(values, 0.95)), float(values.max())
