"""What a machine can do, in seconds: a wrong unit in [limits] shows at once."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.config.load import solve_stored
from verne_post.kinematics.chain.carried import CarriedMachine
from verne_post.kinematics.chain.hexapod import HexapodMachine
from verne_post.kinematics.chain.sliding import SlidingMachine
from verne_post.kinematics.modules.rods import RodsModule
from verne_post.kinematics.modules.serial import SerialModule
from verne_post.model.machine import Machine
from verne_post.trajectory.ruckig_backend import plan_rest_to_rest

#: Distances from rest to rest, by the unit of a joint.
DISTANCES: Final = {"mm": (1.0, 100.0), "deg": (1.0, 90.0)}


def describe_home(machine: Machine) -> Iterator[str]:
    """One line a strut or slider: its value at home, and how far it may go from there; none for a chain of joints.

    Home is that of the carrier or of the rods, of a module without one the place of g28.
    """
    where, q = _find_home(machine)
    for column, value, low, high in zip(machine.columns, q, machine.limits.lower, machine.limits.upper, strict=False):
        if column.unit == "mm":
            yield (
                f"{column.joint}: {value:.3f} mm at {where}; its travel of {low:g} to {high:g} mm goes from there by "
                f"{low - value:+.3f} and {high - value:+.3f} mm"
            )


def _find_home(machine: Machine) -> tuple[str, list[float]]:
    """The name of a place, and the legs and sliders there, mm; none where they are not known."""
    if isinstance(machine.five_axis, CarriedMachine | SlidingMachine | HexapodMachine):
        return "home", machine.five_axis.home.tolist()
    if isinstance(machine.module, RodsModule):
        return "home", machine.module.inverse(np.array(machine.module.home))[0].tolist()
    if machine.module is None or isinstance(machine.module, SerialModule):
        return "", []
    return next(((name, q[:3].tolist()) for name, _home, ok, q in solve_stored(machine) if ok), ("", []))


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
