"""Whether the travel of the table allows a place: asked before one of two positions of the table is chosen.

Likewise of all joints, before a corner may swing out.
"""

from collections.abc import Callable

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.base.tolerances import LIMIT_SLACK, LIMIT_SLACK_MM
from verne_post.model.machine import Machine
from verne_post.model.moves import ZERO9, Frame


class MachineTravel(Struct, frozen=True, eq=False):
    """The travel of a machine's table; implements ``TableTravel``."""

    machine: Machine

    def find_beyond(self, place: Array, tool_length: float) -> str:
        """Letters of rotary axes beyond their travel at a place of the nominal machine (9,), mm and degrees.

        Where no sliders reach the place, the nominal angles are compared.
        """
        machine = self.machine
        q, angles, ok = self._solve(place, tool_length)
        table = q[-2:] if ok else angles
        limits = machine.limits
        out = (table < limits.lower[-2:] - LIMIT_SLACK) | (table > limits.upper[-2:] + LIMIT_SLACK)
        return "".join(letter for letter, beyond in zip(machine.rotary_letters, out, strict=True) if beyond)

    def describe_tilt(self, tilts: list[float]) -> str:
        """The travel of the axis that tilts the tool, in words, and the least excess of some angles; degrees."""
        factor = self.machine.columns[-2].factor
        low, high = sorted(
            float(limit[-2]) * factor for limit in (self.machine.limits.lower, self.machine.limits.upper)
        )
        excess = min(max(low - tilt, tilt - high) for tilt in tilts)
        return f"{self.machine.rotary_letters[0]} goes from {low:g} to {high:g}, exceeded by {excess:.3f} deg"

    def is_reached(self, place: Array, tool_length: float) -> bool:
        """Whether every joint is within its travel at a place of the nominal machine (9,), mm and degrees."""
        q, _angles, ok = self._solve(place, tool_length)
        limits = self.machine.limits
        slack = np.append(np.full(len(q) - 2, LIMIT_SLACK_MM), [LIMIT_SLACK, LIMIT_SLACK])
        return bool(ok and ((q >= limits.lower - slack) & (q <= limits.upper + slack)).all())

    def _solve(self, place: Array, tool_length: float) -> tuple[Array, Array, bool]:
        """Joints and nominal angles at a place, and whether it is reached."""
        machine, frame = self.machine, Frame(tool=(0.0, 0.0, tool_length, *ZERO9[3:]))
        tip, angles = machine.coordinates.map_to_table(machine.coordinates.map_to_program(place[None], frame), frame)
        q, _platform, ok = machine.five_axis.solve(tip, angles, tool_length)
        return q[0], angles[0], bool(ok[0])


def check_travel_of(machine: Machine) -> Callable[[Array, Array], Mask]:
    """Whether poses (n, 5) with tool lengths (n,) keep the travel of every joint; those out of reach break none."""
    solve, limits = machine.five_axis.solve, machine.limits
    slack = np.append(np.full(len(limits.lower) - 2, LIMIT_SLACK_MM), [LIMIT_SLACK, LIMIT_SLACK])

    def check_travel(pose: Array, tool_length: Array) -> Mask:
        q = solve(pose[:, :3], pose[:, 3:], tool_length)[0]
        return np.asarray(~((q < limits.lower - slack) | (q > limits.upper + slack)).any(axis=1))

    return check_travel
