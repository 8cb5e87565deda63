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
        machine, frame = self.machine, Frame(tool=(0.0, 0.0, tool_length, *ZERO9[3:]))
        tip, angles = machine.coordinates.map_to_table(machine.coordinates.map_to_program(place[None], frame), frame)
        q, _platform, ok = machine.five_axis.solve(tip, angles, tool_length)
        table = q[0, -2:] if ok[0] else angles[0]
        limits = machine.limits
        out = (table < limits.lower[-2:] - LIMIT_SLACK) | (table > limits.upper[-2:] + LIMIT_SLACK)
        return "".join(letter for letter, beyond in zip(machine.rotary_letters, out, strict=True) if beyond)


def check_travel_of(machine: Machine) -> Callable[[Array, Array], Mask]:
    """Whether poses (n, 5) with tool lengths (n,) keep the travel of every joint; those out of reach break none."""
    solve, limits = machine.five_axis.solve, machine.limits
    slack = np.append(np.full(len(limits.lower) - 2, LIMIT_SLACK_MM), [LIMIT_SLACK, LIMIT_SLACK])

    def check_travel(pose: Array, tool_length: Array) -> Mask:
        q = solve(pose[:, :3], pose[:, 3:], tool_length)[0]
        return np.asarray(~((q < limits.lower - slack) | (q > limits.upper + slack)).any(axis=1))

    return check_travel
