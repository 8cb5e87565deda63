"""What a machine can do, in seconds: a wrong unit in [limits] shows at once."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.model.machine import Machine
from verne_post.trajectory.ruckig_backend import plan_rest_to_rest

#: Distances from rest to rest, by the unit of a joint.
DISTANCES: Final = {"mm": (1.0, 100.0), "deg": (1.0, 90.0)}


def describe_moves(machine: Machine) -> Iterator[str]:
    """One line a joint: how long single moves from rest to rest take, and its greatest speed."""
    limits = machine.limits.bound_jerk(machine.cycle)
    for k, column in enumerate(machine.columns):
        if not column.driven:
            continue
        factor = abs(column.factor)
        velocity, acceleration, jerk = (
            float(part[k]) * factor for part in (limits.velocity, limits.acceleration, limits.jerk)
        )
        distances = np.array(DISTANCES[column.unit])
        phases, _jerks = plan_rest_to_rest(distances, *(np.full(2, limit) for limit in (velocity, acceleration, jerk)))
        seconds = phases.sum(axis=1)
        moves = ", ".join(f"{d:g} {column.unit} in {t:.3f} s" for d, t in zip(distances, seconds, strict=True))
        yield f"{column.joint}: {moves}; {60.0 * velocity:g} {column.unit}/min at most"
