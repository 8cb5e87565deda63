"""What holds from one operation of the machining core to the next."""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Final, Protocol

from msgspec import Struct, field

from verne_post.gcode.first_places import FirstPlaces
from verne_post.gcode.machining.compensation import Compensation
from verne_post.model.moves import ArcFeed, FeedMode, Frame, PathControl, PathMode
from verne_post.model.part_setup import FIRST_NAMED_TOOL, Tool

#: Override switches at the start of a program.
OVERRIDES: Final = {"speed": True, "feed": True, "adaptive": False, "hold": True}


class ParameterStore(Struct):
    """Parameters that programs have set: numbered values, global names, and names of each call, the last in force."""

    numbered_values: dict[int, float] = field(default_factory=lambda: {5599: 1.0})
    named_values: dict[str, float] = field(default_factory=dict)
    local: list[dict[str, float]] = field(default_factory=lambda: [{}])

    def look_up(self, name: str) -> float | None:
        """What ``#5`` or ``#<name>`` has been set to; None for one that has not, and for a vacant one."""
        if name[1:].isdecimal():
            value = self.numbered_values.get(int(name[1:]))
        else:
            key = "".join(name[2:-1].lower().split())
            value = (self.named_values if key.startswith("_") else self.local[-1]).get(key)
        return None if value is None or math.isnan(value) else value


class Variables(Protocol):
    """The variables of a language."""

    def look_up(self, name: str) -> float | str | None:
        """What a variable has, as the program spells it; None for one without a value."""


class State(Struct):
    """State of the machining core. Positions in program coordinates, mm and degrees."""

    position: list[float]
    #: Axes whose position is known.
    known_axes: list[bool]
    systems: dict[int, Frame]
    frame: Frame
    tools: dict[int, Tool] | None
    #: What holds in the language at hand, of its own type: only the language reads and writes it. Others ask for
    #: ``inch``, and for ``show`` (feed mode, path mode): motion, unit and how F and corners are meant, in its words.
    modes: Any = None
    #: Axes that the program has named.
    named_axes: list[bool] = field(default_factory=lambda: [False] * 9)
    #: Programmed values from before a change of tool length, until the next motion.
    values_before_length: list[float] | None = None
    plane: int = 0
    feed_mode: FeedMode = FeedMode.PER_MINUTE
    control: PathControl = field(default_factory=PathControl)
    feed: float = 0.0  # mm/min, mm/rev or 1/min, as the mode has it
    feed_angular: float = 0.0  # the same number, never scaled by units
    g92_stored: tuple[float, ...] = (0.0,) * 9
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
    overrides: dict[str, bool] = field(default_factory=lambda: dict(OVERRIDES))
    compensation: Compensation | None = None
    arc_feed: ArcFeed = field(default_factory=ArcFeed)
    #: Where the tool's centre is while compensation holds, and until the next motion after it.
    centre: list[float] | None = None
    #: False after G40, until a straight move has led back to the programmed contour.
    arc_may_follow: bool = True
    #: A user-defined code has ended tool-centre-point control; None before one has ended or begun it.
    tcp_off: bool | None = None
    store: ParameterStore = field(default_factory=ParameterStore)
    #: Those of a language that keeps them itself.
    own_variables: Variables | None = None
    selected_tool: int | None = None
    loaded_tool: int | None = None
    #: The tool in the spindle as it was when its offset was called, while the program has changed its data since.
    called_tool: Tool | None = None
    #: An axis has been given a position, in program or in machine coordinates.
    has_position: bool = False
    has_tool_length: bool = False
    #: What has cancelled the tool length of a code that is still active, as "G53 of line 34"; empty where it holds.
    #: The frame keeps the length: the tool is in the spindle, and until the next length no word names its Z.
    length_end: str = ""
    #: The tool axis that holds (unit, program directions); None where A and C words hold.
    tool_axis: tuple[float, float, float] | None = None
    #: Number -> name, of tools that the program has named.
    tool_names: dict[int, str] = field(default_factory=dict)
    #: Rigid tapping has been refused once, or is meant (--tapping feed): it is executed.
    taps_rigidly: bool = False
    #: The tool whose length is --tool-length, once one is loaded or named by H.
    only_tool: int | None = None
    #: What the first naming of each axis says, while the start of the program is sought.
    first_places: FirstPlaces | None = None

    def show_variables(self, variables: Variables) -> None:
        """Those that a language keeps itself are to be looked up."""
        self.own_variables = variables

    def look_up(self, name: str) -> float | str | None:
        """What a variable of the program has; None for one without a value."""
        return (self.own_variables or self.store).look_up(name)

    def is_known(self, axis: int) -> bool:
        """True where the position of an axis is known: it has been named, or the program never names it."""
        return self.known_axes[axis] or (self.first_places is not None and self.first_places.is_named(axis))

    @contextmanager
    def follow_exactly(self) -> Iterator[None]:
        """Corners of canned cycles are not blended, whatever G64 allows for the rest of the program."""
        control = self.control
        if control.mode == PathMode.BLEND:
            self.control = PathControl(PathMode.EXACT_PATH)
        try:
            yield
        finally:
            self.control = control


def describe_tool_event(state: State, number: int) -> dict[str, object]:
    """What an event says of a tool: its number, None where it has only a name, and its name where it has one."""
    shown_number = None if number >= FIRST_NAMED_TOOL else number
    return {"number": shown_number} | ({"name": state.tool_names[number]} if number in state.tool_names else {})


def name_unit_of_speed(state: State) -> dict[str, object]:
    """What an event says of the unit of S where that is not 1/min."""
    return {"unit": "ft/min" if state.modes.inch else "m/min"} if state.surface_speed else {}
