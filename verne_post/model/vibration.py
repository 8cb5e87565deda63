"""Vibration modes of a machine, and the input shapers that leave them at rest: plain data."""

from typing import Literal

from msgspec import Struct

#: Input shapers: zero vibration, zero vibration and derivative, extra insensitive. More robustness against a wrong
#: frequency costs time.
Shaper = Literal["zv", "zvd", "ei"]


class Mode(Struct, frozen=True):
    """A vibration mode: natural frequency of the undamped mode, Hz, and damping ratio, 0 to below 1."""

    frequency: float
    damping: float


class Shaped(Struct, frozen=True):
    """What an input shaper does to a program."""

    shaper: Shaper
    rest: float  #: Rest before and after every motion between two standstills, s.
    #: float): Of every mode its frequency, Hz, and the share of its vibration that is left.
    left: tuple[tuple[float, float], ...]


class Vibration(Struct, frozen=True):
    """[vibration] of a machine file: modes, and the shaper that is used where nobody asks for another; None: none."""

    modes: tuple[Mode, ...]
    shaper: Shaper | None
