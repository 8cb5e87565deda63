"""Options of a conversion: plain data, picklable, no files."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from verne_post.model.keep_out import Box, ToolShape
from verne_post.model.moves import Vector9

#: Blocks that loops and calls may repeat, unless the user says otherwise.
MAX_REPEATS = 100_000


@dataclass(frozen=True)
class Tool:
    """One line of a tool table: offsets in mm and degrees, diameter in mm."""

    number: int
    pocket: int
    offset: Vector9
    diameter: float = 0.0


@dataclass(frozen=True)
class WorkOffset:
    """Where the part's zero sits on the table (mm, table frame) and how far the part is turned (deg)."""

    origin_mm: tuple[float, float, float]
    turn_deg: float = 0.0


@dataclass(frozen=True, kw_only=True)
class TextOptions:
    """What concerns the text of a program alone.

    Attributes
    ----------
    block_delete : bool
        Skip blocks that begin with a slash.
    subroutines : mapping
        Text of the files that calls may name, by name without ending, in lower case.
    parameters : mapping
        Numbered parameters that the program finds (a parameter file).
    parameter_mm : float
        Unit of the lengths among them, in mm.
    remap : mapping
        What codes of the shop mean: code ("M428") -> "tcp on", "tcp off", "ignore" or "event".
    max_repeats : int
        So many blocks, and moves of such blocks, may loops and calls repeat.
    dialect : str
        Name of the program's dialect; "auto" recognises it.
    """

    block_delete: bool = False
    subroutines: Mapping[str, bytes] = field(default_factory=dict)
    parameters: Mapping[int, float] = field(default_factory=dict)
    parameter_mm: float = 1.0
    remap: Mapping[str, str] = field(default_factory=dict)
    max_repeats: int = MAX_REPEATS
    dialect: str = "auto"

    def of_text(self) -> dict[str, Any]:
        """These options alone, by name."""
        return {one.name: getattr(self, one.name) for one in fields(TextOptions)}


@dataclass(frozen=True, kw_only=True)
class Options(TextOptions):
    """What a user may choose for one program.

    Attributes
    ----------
    tool_length : float or None
        mm; holds throughout when given, the program's words do not change it.
    tools : mapping or None
        Tool table by number; None when there is none.
    wcs : mapping
        Work offsets by system number (1 = G54).
    cycle : float or None
        Control cycle in s, in place of the machine file's.
    decimals : int or None
        Decimals of every column; None chooses them per column.
    keep_out : tuple of Box
        Fixtures.
    stock : Box or None
    tool_shapes : mapping
        Shapes of tools by number, from the tip upwards.
    units : {"joint", "drive"}
        Numbers of the rows are mm and degrees, or what the drives count.
    accept_rounding : bool
        Write even where the rounding noise of the given decimals exceeds a limit.
    approach : None, "home" or tuple of float
        Where the machine stands before the program: home, or joint values in file units.
    departure : None, "home" or "park"
        Where the machine goes behind the program.
    from_line : int or None
        The program is taken up at this source line.
    air : float
        The whole program is lifted by so many mm, along ``air_along``: "tool" or "table" (its normal).
    override, slow_start : float
        Share of the planned speed; seconds in which it is reached from a tenth of it.
    smoothing : {"spline", "blend", "off"}
        Corners of finely divided curves reach over each other, every corner is rounded by itself, or is a stop.
    tolerance, orientation_tolerance : float or None
        Default of G64 in mm and rad, in place of the machine file's.
    solver : {"scan", "toppra", "both"}
        Of the second-order problem.
    quality : bool
        Plan finely and without margin, at many times the cost.
    rapids : {"line", "joint"}
        Straight for the tip, or linear in the joints.
    orientation : str
        How the tool axis goes between poses of a feed move: "auto", "vector" or "angles".
    allow_rewind : bool
        The table may rewind or change sides between feed moves, with a retract.
    free_c : bool
        Under a tool that is vertical throughout, turn the part to where the smallest margin is largest.
    optional_stop : bool
        M1 stops.
    split_at_stops : bool
        Stops for a person after the first motion are standstills at which the file is cut.
    source_name : str
        Name of the program in messages.
    """

    tool_length: float | None = None
    tools: Mapping[int, Tool] | None = None
    wcs: Mapping[int, WorkOffset] = field(default_factory=dict)
    cycle: float | None = None
    decimals: int | None = None
    keep_out: tuple[Box, ...] = ()
    stock: Box | None = None
    tool_shapes: Mapping[int, ToolShape] = field(default_factory=dict)
    units: str = "joint"
    accept_rounding: bool = False
    approach: str | tuple[float, ...] | None = None
    departure: str | None = None
    from_line: int | None = None
    air: float = 0.0
    air_along: str = "tool"
    override: float = 1.0
    slow_start: float = 0.0
    smoothing: str = "spline"
    tolerance: float | None = None
    orientation_tolerance: float | None = None
    solver: str = "scan"
    quality: bool = False
    rapids: str = "line"
    orientation: str = "auto"
    allow_rewind: bool = False
    free_c: bool = False
    optional_stop: bool = False
    split_at_stops: bool = False
    source_name: str = "program"

    @property
    def lift(self) -> float:
        """How much shorter the real tool is than the one that a dry run along the tool axis is solved with, mm."""
        return self.air if self.air_along == "tool" else 0.0
