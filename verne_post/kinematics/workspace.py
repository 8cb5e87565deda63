"""Which tips the whole machine reaches with a given tool axis, and which limit ends the reach."""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.kinematics.checks.violations import Check, list_machine_checks
from verne_post.model.machine import Machine

#: Margins of different units are compared as lengths: one degree of the table counts 10 mm, about what it moves a part
#: half a metre away.
MM_PER_RAD: Final = 10.0 * 180.0 / np.pi

#: The limits that every machine has; those of its joints and of its module stand between them.
OUT_OF_REACH: Final = "out of reach of the rods"
BELOW_TABLE: Final = "tip or nose below the table face"


class Reach(Struct, frozen=True, eq=False):
    """What limits n tips."""

    limits: tuple[str, ...]  #: Names of all limits.
    broken: Ints  #: (n,): The limit that is violated most, by its place in ``limits``; -1 where the tip is reached.
    #: (n,): Where reached, the smallest margin of a joint's travel or of a rod's drop; else minus the worst
    #: violation. mm (a degree counts 10 mm); NaN out of reach.
    margin: Array

    @property
    def reached(self) -> Mask:
        """Tips inside all travel and margins."""
        return self.broken < 0


def classify(machine: Machine, tip: Array, angles: Array, tool_length: float) -> Reach:
    """Compare tips with every geometric limit: rods, travel of every joint, margins, table face.

    Parameters
    ----------
    tip : ndarray, shape (n, 3)
        Table frame, mm.
    angles : ndarray, shape (2,)
        Nominal A and C, workpiece sense, rad; the same for all tips.
    tool_length : float
        Gauge line to tip, mm.
    """
    tip = np.asarray(tip, dtype=float)
    pairs = np.broadcast_to(angles, (len(tip), 2))
    q, platform, ok = machine.five_axis.solve(tip, pairs, tool_length)
    checks = list_machine_checks(machine)
    with np.errstate(invalid="ignore"):
        quantities = np.concatenate([q, machine.five_axis.find_geometry_margins(q, pairs, platform)], axis=1)
    margins = [np.where(ok, np.inf, -np.inf)]
    for check in checks:
        margin = check.sign * (quantities[:, check.quantity] - check.limit)
        # a value on its limit counts as reached, whatever its last bits are; a margin that belongs to no joint is no
        # distance that others compare with, so it can only end the reach
        inside = np.maximum(margin, 0.0) if check.axis else np.inf
        margin = np.where(margin >= -check.slack, inside, margin)
        margins.append(np.where(ok, margin * (1.0 if check.unit == "mm" else MM_PER_RAD), np.inf))
    nose = tip + tool_length * find_axis_of_angles(angles[0], angles[1])
    heights = [
        np.maximum(point[:, 2], np.hypot(point[:, 0], point[:, 1]) - machine.table_radius) for point in (tip, nose)
    ]
    height = np.minimum(*heights)
    margins.append(np.where(height >= -LIMIT_SLACK_MM, np.inf, height))  # work goes down to the face
    every = np.stack(margins, axis=1)
    worst = every.argmin(axis=1)
    smallest = every[np.arange(len(tip)), worst]
    limits = (OUT_OF_REACH, *(_name(check) for check in checks), BELOW_TABLE)
    return Reach(limits, np.where(smallest < 0, worst, -1), np.where(ok, smallest, np.nan))


def _name(check: Check) -> str:
    """What a check stands for, in a legend."""
    if check.code.startswith("VP10"):
        end = "lower" if check.sign * check.factor > 0 else "upper"
        return f"{check.axis} at its {end} end"
    return f"{check.name}" + (f" ({check.axis})" if check.axis else "")
