"""What stands on the table, and what the tool looks like: boxes and cylinders, plain data."""

from dataclasses import dataclass

#: Parts of a tool, from the tip upwards.
TOOL_PARTS = ("cutter", "shank", "holder")


@dataclass(frozen=True)
class Box:
    """A box on the table: a fixture, or the stock.

    Attributes
    ----------
    name : str
    low, high : tuple of float
        Corners, mm, in the table frame or in a work system.
    system : int or None
        Number of the work system (1 = G54) as ``--wcs`` gives it; None: the table frame.
    distance : float
        How near other bodies may come, mm.
    """

    name: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    system: int | None = None
    distance: float = 0.0


@dataclass(frozen=True)
class Cylinder:
    """A part of a tool: one of ``TOOL_PARTS``; its length, None up to the gauge line. mm."""

    part: str
    diameter: float
    length: float | None = None


#: Parts of a tool from the tip upwards.
ToolShape = tuple[Cylinder, ...]
