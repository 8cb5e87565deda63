"""Legal poses all over the workspace, drawn at random."""

from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.kinematics.checks.violations import list_machine_checks
from verne_post.model.machine import Machine
from verne_post.model.poses import Platform, Pose

#: Parts that are cut are up to this many times the table's radius high.
HEIGHT: Final = 1.0
#: Poses tried at a time; about a quarter of them is within limits on the VERNE.
BATCH: Final = 2048
#: So many batches without any pose within limits, and nothing is within reach at all.
EMPTY_BATCHES: Final = 3
#: So many batches without enough poses within limits mean that the machine reaches next to nothing.
MOST_BATCHES: Final = 100


class WorkspacePoses(Struct, frozen=True, eq=False):
    """Legal poses: tip (n, 3) in mm and nominal angles (n, 2) in rad on the table, tool length (n,), joints (n, 5)."""

    tip: Array
    angles: Array
    length: Array
    joints: Array

    def take(self, chosen: Ints | Mask) -> "WorkspacePoses":
        """Some of the poses."""
        return WorkspacePoses(self.tip[chosen], self.angles[chosen], self.length[chosen], self.joints[chosen])


def solve_legal(machine: Machine, tip: Array, angles: Array, length: Array) -> tuple[Array, Mask]:
    """Joints (n, 5) of poses, and which poses keep every limit and clearance of the machine file."""
    joints, platform, ok = machine.five_axis.solve(tip, angles, length)
    with np.errstate(invalid="ignore"):
        margins = machine.five_axis.find_geometry_margins(joints, angles, platform)
        quantities = np.concatenate([joints, margins], axis=1)
        for check in list_machine_checks(machine):
            ok = ok & (check.sign * (quantities[:, check.quantity] - check.limit) >= -check.slack)
        axis = machine.five_axis.find_tool_axis(joints, angles, platform)
        for point in (tip, tip + length[:, None] * axis):
            height = np.maximum(point[:, 2], np.hypot(point[:, 0], point[:, 1]) - machine.table_radius)
            ok = ok & (height >= -LIMIT_SLACK_MM)
    if machine.clearance is not None and ok.any():
        held = Platform(platform.position[ok], platform.angles[ok])
        distances = machine.clearance.evaluate(Pose(joints[ok], held, tip[ok], axis[ok], length[ok]))[0]
        low = np.array([margin.error_below for margin in machine.clearance.names])
        ok[np.flatnonzero(ok)] = (distances >= low).all(axis=1)
    return joints, ok


def sample_workspace(
    machine: Machine,
    count: int,
    lengths: Sequence[float],
    rng: np.random.Generator,
    places: Array | None = None,
    height: float = HEIGHT,
    lowest: float = 0.0,
) -> WorkspacePoses:
    """Draw poses within limits: tips over the table's face, every A within its travel, every C.

    Parameters
    ----------
    lengths : sequence of float
        Tool lengths, mm; each pose has one of them.
    places : ndarray, shape (k, 3), optional
        Tips stand at these places of the table frame only.
    height : float
        Tips stand up to this many times the table's radius above its face ...
    lowest : float
        ... and no nearer to it than this, mm.

    Raises
    ------
    ValueError
        The machine reaches hardly any pose.
    """
    parts: list[WorkspacePoses] = []
    found = 0
    low, high = (max(-np.pi, machine.limits.lower[3]), min(np.pi, machine.limits.upper[3]))
    for batch in range(1, MOST_BATCHES + 1):
        if places is None:
            radius = machine.table_radius * np.sqrt(rng.uniform(size=BATCH))
            around = rng.uniform(-np.pi, np.pi, BATCH)
            above = rng.uniform(lowest, height * machine.table_radius, BATCH)
            tip = np.stack([radius * np.cos(around), radius * np.sin(around), above], axis=1)
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
        if batch == MOST_BATCHES or (batch == EMPTY_BATCHES and not found):
            raise ValueError(f"only {found} of {batch * BATCH} poses tried keep every limit")
    names = ("tip", "angles", "length", "joints")
    return WorkspacePoses(*(np.concatenate([getattr(part, name) for part in parts])[:count] for name in names))
