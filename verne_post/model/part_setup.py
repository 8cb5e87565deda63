"""What stands on the machine for one part: tools, work offsets, fixtures and stock. Plain data, cheap to import."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

Vector9 = tuple[float, float, float, float, float, float, float, float, float]

#: Number of the work system before G54.1 P1: those of G54 to G59.3 are 1 to 9.
ADDITIONAL_SYSTEMS: Final = 100
#: G54 to G59.3, then G54.1 P1 to P48.
WORK_SYSTEMS: Final = (*range(1, 10), *range(ADDITIONAL_SYSTEMS + 1, ADDITIONAL_SYSTEMS + 49))
#: Number -> how it is written in options and reports.
SYSTEM_NAMES: Final = dict(zip(WORK_SYSTEMS, (
    "G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3", *(f"G54.1P{number}" for number in range(1, 49)),
), strict=True))  # fmt: skip
#: The same the other way round.
SYSTEM_NUMBERS: Final = {name: number for number, name in SYSTEM_NAMES.items()}
#: Parts of a tool, from the tip upwards.
TOOL_PARTS: Final = ("cutter", "shank", "holder")
#: Numbers that tools get which a program names and no table numbers: from here on.
FIRST_NAMED_TOOL: Final = 100_001
#: Letters of a work offset: its place, and the turn of the part.
COORDINATES: Final = "xyzc"
#: Places beyond this are mistakes, mm and degrees.
MAX_PLACE: Final = 1e5
#: Lengths and diameters of tools beyond this are mistakes, mm.
MAX_TOOL: Final = 1e4


@dataclass(frozen=True)
class Tool:
    """One line of a tool table.

    Attributes
    ----------
    number, pocket : int
    offset : tuple of nine float
        Tool offset along X Y Z A B C U V W, mm and degrees; Z is the length.
    diameter : float
        mm.
    unmeasured : str
        What names the tool without a length: file and line of a table, or line of the program. Empty: the length is known.
    """

    number: int
    pocket: int
    offset: Vector9
    diameter: float = 0.0
    unmeasured: str = ""


def tool_text(number: int, names: Mapping[int, str]) -> str:
    """A tool as a person knows it: by its number, and by the name that the program gives it."""
    if number not in names:
        return f"tool {number}"
    return f'tool "{names[number]}"' if number >= FIRST_NAMED_TOOL else f'tool {number} "{names[number]}"'


def tool_word(number: int, names: Mapping[int, str]) -> str:
    """The same as a program writes it: its T word, or its name."""
    return tool_text(number, names).removeprefix("tool ") if number in names else f"T{number}"


@dataclass(frozen=True)
class WorkOffset:
    """Where the part's zero is on the table (mm, table frame) and how far the part is turned about C (deg)."""

    origin_mm: tuple[float, float, float]
    turn_deg: float = 0.0


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
