"""What a setpoint file that is read should hold: its reader compares it."""

from msgspec import Struct

from verne_post.model.drives import Drive
from verne_post.model.machine import Column


class Expected(Struct, frozen=True):
    """What a setpoint file that is read should hold."""

    name: str  #: Of the file, in messages.
    columns: tuple[Column, ...]  #: Of the machine.
    cycle: float  #: s; row k stands at k cycles.
    drives: tuple[Drive, ...]  #: How the numbers count; empty for mm and degrees.

    @property
    def driven(self) -> int:
        """How many joints a file for a control has: those that no drive follows are the last ones."""
        return sum(column.driven for column in self.columns)
