"""The instructions beside the files of `machine axis-check`."""

import textwrap
from collections.abc import Sequence
from typing import Protocol

from verne_post.model.machine import Machine
from verne_post.model.setpoints import SetpointBlock


class Move(Protocol):
    """One file and what must be seen."""

    @property
    def name(self) -> str:
        """Name of the file, without its ending."""

    @property
    def block(self) -> SetpointBlock:
        """Its rows."""

    @property
    def expected_motion(self) -> str:
        """What must be seen."""


def instructions(machine: Machine, moves: Sequence[Move]) -> str:
    """What to do with the files, and what one must see at each."""
    head = (
        f"Axis check of {machine.name}: run the files one by one, in this order, without a tool, one hand on the stop. Each moves one "
        "actuator to its positive side, back, to its negative side and back, as at an override of 2 %, and stands for a second at each end. "
        "Before every file all drives must read what the first row says. x, y and up are directions of the machine with z up: those of the table at A = C = 0. "
        "Stop at the first difference, correct sign, zero or scale, and begin again with new files. Only when all small motions were right, run the large ones."
    )
    parts = [textwrap.fill(head, width=100)]
    for move in moves:
        seconds = (len(move.block.values) - 1) * move.block.format.cycle
        text = f"{move.name}.csv ({seconds:.1f} s): {move.expected_motion}"
        parts.append(textwrap.fill(text, width=100, initial_indent="[ ] ", subsequent_indent="    "))
    return "\n\n".join(parts) + "\n"
