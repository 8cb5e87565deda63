"""The modal state of the interpreter."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

from msgspec import Struct, field

from verne_post.gcode.compensation import Compensation
from verne_post.gcode.first_places import FirstPlaces
from verne_post.gcode.splines import SplineDraft
from verne_post.model.moves import ArcFeed, FeedMode, Frame, PathControl, PathMode
from verne_post.model.part_setup import Tool, Vector9

#: Override switches at the start of a program.
_OVERRIDES: Final = {"speed": True, "feed": True, "adaptive": False, "hold": True}


class ParameterStore(Struct):
    """Parameters that programs have set: numbered ones, global names, and the names of each call (the last is in force)."""

    numbered: dict[int, float] = field(default_factory=lambda: {5599: 1.0})
    named: dict[str, float] = field(default_factory=dict)
    local: list[dict[str, float]] = field(default_factory=lambda: [{}])


class Saved(Struct, frozen=True):
    """Modal state that M72, or the return from a call after M73 (``automatic``), brings back."""

    values: dict[str, object]
    overrides: dict[str, bool]
    system: int
    g92_on: bool
    tool: Vector9
    automatic: bool


class Cycle(Struct, frozen=True):
    """What is kept while canned cycles follow each other. mm, s.

    Attributes
    ----------
    normal : int
        The drill axis.
    start : float
        Its place before the first cycle.
    start_inch : bool
        G20 was active there.
    clear, bottom : float
        Heights of R and of the bottom.
    numbers : tuple of float
        The words R and bottom as they were given.
    of_g90 : tuple of bool
        For each of the two whether it was given in G90.
    absolute, inch : bool
        G90 and G20 in the last block.
    step, dwell : float or None
        Q and P.
    shift : tuple of float or None
        I J K of G87.
    """

    normal: int
    start: float
    start_inch: bool
    clear: float
    bottom: float
    numbers: tuple[float, float]
    of_g90: tuple[bool, bool]
    absolute: bool
    inch: bool
    step: float | None = None
    dwell: float | None = None
    shift: tuple[float, ...] | None = None


class State(Struct):
    """Everything modal. Positions in program coordinates, mm and degrees."""

    position: list[float]
    known: list[bool]
    systems: dict[int, Frame]
    frame: Frame
    tools: dict[int, Tool] | None
    named: list[bool] = field(default_factory=lambda: [False] * 9)
    #: Programmed values from before a change of tool length, until the next motion.
    held: list[float] | None = None
    motion: int | None = None
    plane: int = 0
    absolute: bool = True
    absolute_centers: bool = False
    feed_mode: FeedMode = FeedMode.PER_MINUTE
    inch: bool = False
    control: PathControl = field(default_factory=PathControl)
    feed: float = 0.0  # mm/min, mm/rev or 1/min, as the mode has it
    feed_angular: float = 0.0  # the same number, never scaled by units
    g92_stored: tuple[float, ...] = (0.0,) * 9
    #: What of it is Fanuc's G52, which has a store of its own there.
    local_shift: tuple[float, ...] = (0.0,) * 9
    #: G92, G52 or G92.3 came last, not G92.1 or G92.2.
    g92_on: bool = False
    home: tuple[float, ...] | None = None
    home2: tuple[float, ...] | None = None
    spindle_speed: float = 0.0
    #: G96: S is a speed of the surface, in m/min or ft/min, and the spindle follows the distance of the tool from X0.
    surface_speed: bool = False
    spindle_on: bool = False
    spindle_reversed: bool = False
    mist: bool = False
    flood: bool = False
    overrides: dict[str, bool] = field(default_factory=lambda: dict(_OVERRIDES))
    #: G7: a lathe's X words are diameters.
    diameter_mode: bool = False
    #: G98: canned cycles retract to where they began.
    initial_level: bool = False
    cycle: Cycle | None = None
    compensation: Compensation | None = None
    arc_feed: ArcFeed = field(default_factory=ArcFeed)
    #: The last D since the tool change; only Fanuc controls keep it.
    cutter_number: int | None = None
    #: A spline whose control points are being read.
    spline: SplineDraft | None = None
    #: After G5: the number of motions so far, and where a G5 that follows goes on (I and J, mm).
    spline_leg: tuple[int, float, float] | None = None
    #: Where the tool's centre is while compensation holds, and until the next motion after it.
    centre: list[float] | None = None
    #: False after G40, until a straight move has led back to the programmed contour.
    arc_may_follow: bool = True
    #: A user-defined code has ended tool-centre-point control.
    tcp_off: bool = False
    #: M66 has read an input, whose value is not known here.
    inputs_read: bool = False
    store: ParameterStore = field(default_factory=ParameterStore)
    #: What M70 and M73 have saved, one place a level of calls.
    saved: list[Saved | None] = field(default_factory=lambda: [None])
    selected_tool: int | None = None
    loaded_tool: int | None = None
    #: An axis has been given a position, in program or in machine coordinates.
    placed: bool = False
    length_given: bool = False
    #: G43.5 is active: I, J, K of straight moves are the tool axis.
    vectors: bool = False
    #: The tool axis that holds (unit, program directions); None where A and C words hold.
    tool_axis: tuple[float, float, float] | None = None
    #: Number -> name, of tools that the program has named.
    tool_names: dict[int, str] = field(default_factory=dict)
    #: The tool whose length is --tool-length, once one is loaded or named by H.
    only_tool: int | None = None
    #: What the first naming of each axis says, while the start of the program is sought.
    first_places: FirstPlaces | None = None

    def is_known(self, axis: int) -> bool:
        """True where the position of an axis is known: it has been named, or the program never names it."""
        return self.known[axis] or (self.first_places is not None and self.first_places.is_named(axis))

    @contextmanager
    def exact_path(self) -> Iterator[None]:
        """Corners of canned cycles are not blended, whatever G64 allows for the rest of the program."""
        control = self.control
        if control.mode == PathMode.BLEND:
            self.control = PathControl(PathMode.EXACT_PATH)
        try:
            yield
        finally:
            self.control = control


def tool_facts(state: State, number: int) -> dict[str, object]:
    """What an event says of a tool: its number, and its name where the program has given one."""
    return {"number": number} | ({"name": state.tool_names[number]} if number in state.tool_names else {})


def unit_of_speed(state: State) -> dict[str, object]:
    """What an event says of the unit of S where that is not 1/min."""
    return {"unit": "ft/min" if state.inch else "m/min"} if state.surface_speed else {}
