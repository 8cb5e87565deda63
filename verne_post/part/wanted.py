"""What a comparison with the nominal part is asked for, and units of meshes; without numpy, as the help of commands needs it."""

from typing import Final

from msgspec import Struct

#: mm of the units that a mesh may be in.
UNITS: Final = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "inch": 25.4}


class Wanted(Struct, frozen=True):
    """What is asked for, mm.

    Attributes
    ----------
    gouge, excess : float
        Depths along the normal that count.
    grid : float
        No place of the surface is farther than this from one that is looked at.
    search : float
        How deep below and how high above the surface is looked; less than the thinnest wall.
    """

    gouge: float = 0.05
    excess: float = 0.2
    grid: float = 0.2
    search: float = 2.0
