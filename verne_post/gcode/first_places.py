"""While the start of a program is sought: how far each axis stands from where its first naming puts it."""

from collections.abc import Callable, Iterable
from typing import Final

import numpy as np
from msgspec import Struct, field

from verne_post.base.arrays import Array
from verne_post.model.moves import AXES

_LINEAR: Final = (0, 1, 2)
_ROTARY: Final = (3, 4, 5)


class FirstPlaces(Struct):
    """What the first naming of each axis says about the start.

    A place of the machine is one in machine coordinates. A place of the program is meant in the work system: its first
    naming does not move the axis. Where a block also takes an axis away from a place of the machine (X Y Z after a
    retract), the start is over the place in machine coordinates, so that the spindle comes down on it.

    With ``waits`` that holds for X, Y and Z of several blocks too, as long as neither the table turns between them nor
    one of them is named again: on a table that stands upright, X and Y of the part and Z of the machine are no three
    directions.
    """

    #: Axes that the program never names: they stand at 0 in the work system of the first move to a program's
    #: place.
    unnamed_axes: tuple[int, ...]
    start: Array  #: The place from which the program is executed, machine coordinates (9).
    #: The first place after one of the machine is complete where X, Y and Z have been named, in whatever blocks.
    waits: bool = False
    #: What is missing at each axis (9) from there to the start, mm and degrees; 0 while nothing has named it.
    misses: list[float] = field(default_factory=lambda: [0.0] * len(AXES))
    at_machine: set[int] = field(default_factory=set)  #: Those of X, Y, Z whose last place was one of the machine.
    waiting: set[int] = field(default_factory=set)  #: Those that have been named, and wait until the place is complete.
    is_open: bool = False  #: A place of the machine has been named, and no complete place of the program since.

    def is_named(self, axis: int) -> bool:
        """True where the position of an axis counts as known, though it is not settled."""
        return axis in self.waiting or axis in self.unnamed_axes

    def note(
        self,
        known_axes: list[bool],
        begin: list[float],
        end: list[float],
        axes: list[int],
        to_machine: Callable[[Array], Array],
        *,
        machine: bool,
    ) -> None:
        """Note a motion that names axes.

        Parameters
        ----------
        known_axes : list of bool
            Which axes (9) are settled; changed.
        begin, end : list of float
            Program positions (9), mm and degrees, in one frame.
        axes : list of int
        to_machine : callable
            A program position (9) of that frame -> machine coordinates.
        machine : bool
            The place is one of the machine.
        """
        turns = any(known_axes[axis] and end[axis] != begin[axis] for axis in _ROTARY)
        if self.waiting & set(axes) or (self.waiting and turns):
            self._settle(known_axes)
        fresh = [axis for axis in axes if not known_axes[axis] and axis not in self.waiting]
        for axis in fresh:
            self.misses[axis] = end[axis] - begin[axis]
        linear = set(fresh) & set(_LINEAR)
        if machine:
            self._take_machine(linear, to_machine(np.array(end)))
            self.at_machine |= set(axes) & set(_LINEAR)
            self.is_open = self.is_open or bool(self.at_machine)
        elif axes:
            if self.is_open and (self.waits or self.at_machine & set(axes)):
                self.waiting |= linear
            self.at_machine -= set(axes)
            self._place_unnamed(known_axes, begin)
        for axis in fresh:
            known_axes[axis] = axis not in self.waiting
        if self.waiting and not self.at_machine and all(known_axes[axis] or axis in self.waiting for axis in _LINEAR):
            self._take_machine(self.waiting, to_machine(np.array(end)))
            self._settle(known_axes)

    def note_step(self, known_axes: list[bool], axes: Iterable[int]) -> None:
        """Note an incremental motion of axes: one that waits for others has stood where it was named."""
        if self.waiting.intersection(axes):
            self._settle(known_axes)

    def _take_machine(self, axes: set[int], place: Array) -> None:
        for axis in axes:
            self.misses[axis] = float(place[axis] - self.start[axis])

    def _place_unnamed(self, known_axes: list[bool], begin: list[float]) -> None:
        for axis in self.unnamed_axes:
            if not known_axes[axis]:
                self.misses[axis], known_axes[axis] = -begin[axis], True

    def _settle(self, known_axes: list[bool]) -> None:
        for axis in self.waiting:
            known_axes[axis] = True
        self.waiting, self.is_open = set(), False
