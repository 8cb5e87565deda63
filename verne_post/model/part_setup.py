"""What stands on the machine for one part: tools, work offsets, fixtures and stock. Plain data, cheap to import."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import wraps
from itertools import pairwise
from typing import Any, Final, TypeVar

from verne_post.model.findings import UsageError

_T = TypeVar("_T")
Vector9 = tuple[float, float, float, float, float, float, float, float, float]

#: Number of the work system that Siemens' G500 selects: machine zero, unless $P_UIFR[0] moves it. No set-up places it.
MACHINE_SYSTEM: Final = 0
#: Number of the work system before G54.1 P1: those of G54 to G59.3 are 1 to 9.
ADDITIONAL_SYSTEMS: Final = 100
#: Number -> how it is written in options and reports.
SYSTEM_NAMES: Final = {
    **dict(enumerate(("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"), start=1)),
    **{ADDITIONAL_SYSTEMS + number: f"G54.1P{number}" for number in range(1, 49)},
}
#: Their numbers: G54 to G59.3, then G54.1 P1 to P48.
WORK_SYSTEMS: Final = tuple(SYSTEM_NAMES)
#: The same the other way round.
SYSTEM_NUMBERS: Final = {name: number for number, name in SYSTEM_NAMES.items()}


def name_system(number: int) -> str:
    """How options and reports write a work system; G500 names that of the machine."""
    return "G500" if number == MACHINE_SYSTEM else SYSTEM_NAMES[number]


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
#: mm of the units that a mesh may be in.
UNITS: Final = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "inch": 25.4}


def explain_call(example: str) -> Callable[[type[_T]], type[_T]]:
    """Let a class say how it is made where its arguments have other names, or another number.

    Parameters
    ----------
    example : str
        The right call, with units.
    """

    def decorate(made: type[_T]) -> type[_T]:
        make: Callable[..., None] = made.__init__

        @wraps(make)
        def check(self: _T, *given: Any, **named: Any) -> None:
            try:
                make(self, *given, **named)
            except TypeError:
                import inspect  # only for calls that fail: the module is read by every command

                try:
                    inspect.signature(make).bind(self, *given, **named)
                except TypeError as error:
                    raise UsageError(made.__name__, f"{error}; expected {example}") from None
                raise

        made.__init__ = check  # type: ignore[method-assign, assignment]
        return made

    return decorate


@explain_call(
    "Tool(number, pocket, offset, diameter) with nine numbers in offset, along X Y Z A B C U V W (mm and degrees; Z is "
    "the length); of a tool with a length alone Options takes the length, tools={1: 80}, or length and diameter, "
    "tools={1: (80, 10)}, mm"
)
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
        Source that names the tool without a length: file and line of a table, or line of the program; else empty.
    key : str
        Where the set-up of the one program gives the tool; empty for those of other tables.
    row : str
        File and line of the table that gives the tool; empty for others.
    corner_radius : float or None
        mm, of the lower edge of the cutter: half the diameter makes a ball, 0 a flat end. None: not known.

    Raises
    ------
    UsageError
        ``offset`` has not nine numbers. Of a tool that has a length alone, ``Options`` takes the length.
    """

    number: int
    pocket: int
    offset: Vector9
    diameter: float = 0.0
    unmeasured: str = ""
    key: str = field(default="", compare=False)
    row: str = field(default="", compare=False)
    corner_radius: float | None = None

    def __post_init__(self) -> None:
        """Refuse a length in place of the offsets here, where it is written, and not where the tool is used."""
        if not hasattr(self.offset, "__len__") or isinstance(self.offset, str) or len(self.offset) != 9:
            name = '"NAME"' if self.number >= FIRST_NAMED_TOOL else self.number
            raise UsageError(
                "offset",
                f"{self.offset!r}: expected nine numbers, along X Y Z A B C U V W (Z is the length); of a tool with a "
                f"length alone Options takes the length: tools={{{name}: 80}}, mm",
            )

    @property
    def ends_at_gauge_line(self) -> bool:
        """The tool table gives the length 0, which is meant."""
        return not self.unmeasured and self.offset[2] == 0.0


def describe_tool_number(number: int, names: Mapping[int, str]) -> str:
    """A tool as a person knows it: by its number, and by the name that the program gives it."""
    if number not in names:
        return f"tool {number}"
    return f'tool "{names[number]}"' if number >= FIRST_NAMED_TOOL else f'tool {number} "{names[number]}"'


def choose_number_or_name(number: int, names: Mapping[int, str]) -> int | str:
    """What a machine asks for: the number of a tool, or the name of one that has no number."""
    return names.get(number, number) if number >= FIRST_NAMED_TOOL else number


def list_setup_names(control: Mapping[str, Mapping[str, Any]]) -> dict[int, str]:
    """Number -> name of the tools that a set-up, or a settings file, gives by name; ``control`` is that of Options."""
    tables = (keys.get("tools") for keys in control.values())
    return {number: name for table in tables if isinstance(table, Mapping) for name, number in table.items()}


def spell_tool_word(number: int, names: Mapping[int, str]) -> str:
    """The same as a program writes it: its T word, or its name."""
    return describe_tool_number(number, names).removeprefix("tool ") if number in names else f"T{number}"


@explain_call("WorkOffset(origin_mm=(x, y, z), turn_deg=0)")
@dataclass(frozen=True)
class WorkOffset:
    """Where the part zero is on the table (mm, table frame) and how far the part is turned about C (deg)."""

    origin_mm: tuple[float, float, float]
    turn_deg: float = 0.0
    #: The file or the option that gives it; two offsets are equal whoever gives them.
    source: str = field(default="", compare=False, repr=False)


@explain_call("Box(name, low=(x, y, z), high=(x, y, z)), mm")
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
        Smallest distance of other bodies, mm.
    """

    name: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]
    system: int | None = None
    distance: float = 0.0


@explain_call("FixtureMesh(name, raw), of which raw has the bytes of an STL file, Path(...).read_bytes()")
@dataclass(frozen=True)
class FixtureMesh:
    """A fixture as a mesh; or the stock, as a mesh or as another set-up has left it.

    Attributes
    ----------
    name : str
    raw : bytes
        An STL file: closed, of a fixture nowhere through itself. Of a stock also what ``--stock-left`` wrote as npz.
    system : int or None
        As of :class:`Box`.
    distance : float
        Smallest distance of other bodies, mm.
    unit : str
        One of ``UNITS``: an STL does not say its unit.
    file : str
        Its name, in messages.
    """

    name: str
    raw: bytes
    system: int | None = None
    distance: float = 0.0
    unit: str = "mm"
    file: str = ""

    @property
    def shown(self) -> str:
        """How messages about the mesh call it."""
        return f"{self.name} ({self.file})" if self.file else self.name


#: The grid of a comparison where none is asked for and the part is not too large, mm.
GRID_MM: Final = 0.2


@explain_call("Wanted(gouge=0.05, excess=0.2, grid=0.2, search=2.0), mm")
@dataclass(frozen=True)
class Wanted:
    """Limits of a comparison with the nominal part, mm.

    Attributes
    ----------
    gouge, excess : float
        Depths along the normal that count.
    grid : float or None
        Largest distance of a point of the surface from an examined one. None: 0.2, or for a large part the finest that
        has not too many places.
    search : float
        Depth below and height above the surface that are examined; less than the thinnest wall.
    """

    gouge: float = 0.05
    excess: float = 0.2
    grid: float | None = None
    search: float = 2.0


#: In place of a file or a box of the stock.
OWN_STOCK: Final = "program"


@dataclass(frozen=True)
class OwnStock:
    """The stock that the program itself defines (BLK FORM, WORKPIECE)."""

    name: str = "the stock of the program"
    system: int | None = None
    distance: float = 0.0


@explain_call("NominalPart(name, raw), of which raw has the bytes of an STL file, Path(...).read_bytes()")
@dataclass(frozen=True)
class NominalPart:
    """The nominal part, with which rows are compared.

    Attributes
    ----------
    name : str
        In messages.
    raw : bytes
        An STL file.
    system : int or None
        Number of the work system (1 = G54) that it is in, as ``--wcs`` gives it; None: the table frame.
    unit : str
        One of ``UNITS``: an STL does not say its unit.
    wanted : Wanted
    """

    name: str
    raw: bytes
    system: int | None = None
    unit: str = "mm"
    wanted: Wanted = Wanted()


@dataclass(frozen=True)
class Cylinder:
    """A part of a tool, one of ``TOOL_PARTS``: a cylinder, or another body of revolution by the optional values.

    Attributes
    ----------
    part : str
    diameter : float
        mm; of a tapered cutter that of its nose, of a form that of its widest place.
    length : float or None
        mm; None: up to the gauge line.
    corner_radius : float
        mm; half the diameter makes a ball.
    taper : float
        Degrees a side, from the corner upwards: above 0 wider, below narrower.
    point_angle : float
        Degrees, both sides together: the point of a drill or chamfer cutter; 0: none.
    tip_diameter : float
        mm, where such a point is cut off.
    neck_diameter : float
        mm, of the neck above a ball (lollipop cutter); 0: none.
    profile : tuple of (float, float)
        Radius and height above the part's lower end, mm, upwards: a form.
    assumed_flat : bool
        Only the diameter of the cutter is known: it counts as flat.
    """

    part: str
    diameter: float
    length: float | None = None
    corner_radius: float = 0.0
    taper: float = 0.0
    point_angle: float = 0.0
    tip_diameter: float = 0.0
    neck_diameter: float = 0.0
    profile: tuple[tuple[float, float], ...] = ()
    assumed_flat: bool = False

    @property
    def top_diameter(self) -> float:
        """Where a taper ends, mm: it is tangent to the corner. Without one the diameter."""
        if not self.taper or self.length is None:
            return self.diameter
        slope, corner = math.radians(self.taper), self.corner_radius
        rise = self.length - corner * (1.0 - math.sin(slope))
        return self.diameter - 2.0 * (corner * (1.0 - math.cos(slope)) - rise * math.tan(slope))

    @property
    def widest(self) -> float:
        """The largest diameter, mm."""
        return max(self.diameter, self.top_diameter)


def describe_mistake(part: Cylinder) -> str:
    """What is impossible in the shape of a part of a tool; empty where nothing is."""
    half, length = 0.5 * part.diameter, math.inf if part.length is None else part.length
    if part.profile:
        return _describe_wrong_profile(part)
    if (part.taper or part.corner_radius) and (part.point_angle or (part.neck_diameter and part.taper)):
        return "a point_angle goes with neither taper nor corner_radius, a neck_diameter not with taper"
    if not 0 <= part.corner_radius <= min(half, length):
        return (
            f"corner_radius {part.corner_radius:g} must be from 0 to half the diameter, {half:g}, and no more than the "
            "length"
        )
    if part.taper and part.length is None:
        return "a taper needs a length"
    if not -80 <= part.taper <= 80 or part.top_diameter < 0:
        return f"taper {part.taper:g} must be from -80 to 80 degrees a side, and leave the part a diameter"
    if part.point_angle and not 10 <= part.point_angle < 180:
        return f"point_angle {part.point_angle:g} must be from 10 to below 180 degrees"
    if part.tip_diameter and not (part.point_angle and 0 < part.tip_diameter < part.diameter):
        return "a tip_diameter goes with a point_angle, and is smaller than the diameter"
    if part.point_angle:
        point = (half - 0.5 * part.tip_diameter) / math.tan(math.radians(0.5 * part.point_angle))
        if point > length:
            return f"its point is {point:g} mm long, longer than the part"
    if part.neck_diameter and not (part.corner_radius == half and 0 < part.neck_diameter < part.diameter):
        return "a neck_diameter goes with a ball (corner_radius half the diameter), and is smaller than it"
    if part.neck_diameter and length < part.diameter:
        return "a ball with a neck must be at least as long as its diameter"
    return ""


def _describe_wrong_profile(part: Cylinder) -> str:
    if part.corner_radius or part.taper or part.point_angle or part.tip_diameter or part.neck_diameter:
        return "a profile allows no other key: it says everything about the shape"
    radius, height = zip(*part.profile, strict=True)
    if min(radius) < 0 or max(radius) <= 0:
        return "the radii of a profile must be 0 or more, and one above 0"
    if height[0] != 0 or any(high < low for low, high in pairwise(height)) or height[-1] <= 0:
        return "the heights of a profile must begin at 0 and rise, or stay where the radius steps"
    if max(radius) > 0.5 * part.diameter or part.length not in (None, height[-1]):
        return "diameter and length must be those of the profile"
    return ""


#: Parts of a tool from the tip upwards.
ToolShape = tuple[Cylinder, ...]
