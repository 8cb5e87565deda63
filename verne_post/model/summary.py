"""The facts of one conversion: the summary paragraph and `--meta` are made from them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from msgspec import Struct

from verne_post.base.long_text import Text
from verne_post.base.suggestions import explain_names
from verne_post.base.text_tables import format_html_text
from verne_post.model.machine import Machine
from verne_post.model.moves import ArcFeedUse, Event, Frame, Stock
from verne_post.model.options import Options
from verne_post.model.setpoints import SetpointFormat
from verne_post.model.verification import Verification
from verne_post.model.vibration import Shaped


class FreeTurn(Struct, frozen=True):
    """Result of `--free-c`: C in rad (nominal, workpiece sense), and the smallest margin at the old and the new C.

    A margin is 0 at its limit and 1 in the middle of a travel, or where a warning begins (toolpath.free_turn); minus
    infinity where the program cannot be reached. ``nearest`` names the smallest one at the new C.
    """

    before: float
    chosen: float
    margin_before: float
    margin: float
    nearest: str


class Part(Struct, frozen=True):
    """Rows between two stops for the operator, both ends at rest, and the events after them."""

    first_row: int
    last_row: int
    then: tuple[Event, ...]


class TimedEvent(Struct, frozen=True):
    """An event with the row at which it happens, and the joints' numbers as written there."""

    row: int
    numbers: tuple[float, ...]
    event: Event


class StopsWithin(Struct, frozen=True):
    """Stops between two motions of one line: their number, the line with most, and its number; all 0 for none."""

    count: int
    line: int
    most: int


@explain_names(**dict.fromkeys(("time", "duration", "seconds", "machining_time"), "cycle_time"), cycle="format.cycle")
@dataclass(frozen=True, eq=False, repr=False)
class Summary:
    """Facts of one conversion.

    Attributes
    ----------
    cycle_time : float
        Machining time, the duration of the file, s; ``time_s`` is the same. The control cycle is ``format.cycle``.
    n_stops : int
        Standstills between the first and the last motion.
    stops_within : StopsWithin
        Those of them between two motions of one line.
    feed_segments, feed_reached : int
        Segments with a feed rate, and those that reach it.
    feed_missed : int
        Line of the first that does not; 0 where all do.
    n_blended : int
        Corners that are rounded.
    dwell_time, stop_time : float
        Time of the dwells, and of standstills without one: a cycle at each stop of the program, and what the input
        shaper rests, s. All other time is motion.
    continuous_time, second_order_bound_s : float
        Time of the sections with rounded corners, and their second-order bound, s. No motion profile inside the limits
        on velocity and acceleration is faster than the bound.
    toppra_bound_s : float or None
        The bound by the other solver, where both were asked for.
    tolerance : tuple of float
        Largest tip (mm) and axis (rad) tolerance of rounded corners, 0 where there are none.
    start : tuple of float
        The first row as written: the machine must already be there.
    frames : tuple of Frame
        Work systems in use.
    placed_systems : frozenset of int
        Numbers of those that the program sets.
    verification : Verification or None
        None when nothing was written (`check`).
    free_turn : FreeTurn or None
        None without `--free-c`.
    parameters : mapping
        Values that a parameter file would keep.
    before : tuple of Event
        Events before the first motion.
    parts : tuple of Part
        One where the file is not split.
    switched : tuple of Event
        Auxiliary functions that the blocks before a restart have switched on.
    tools : tuple of (int or str, float)
        Number and length, mm, of the tools in use, in order. A tool that has only a name has it in place of the number;
        number 0 where the program names none.
    carried : tuple of (int or str, float)
        Tools with the length of the tool before, mm, which rapids have until the tool's own length is active.
    carried_lines : tuple of int
        The lines of these rapids.
    bare_lines : tuple of int
        The lines of rapids that have no tool length, although their tool has one in other moves.
    axis_error_deg : float or None
        Largest tool axis error of the motion that the as-built machine cannot correct; None for a nominal machine.
    stock : Stock or None
        The stock that the program defines.
    bodies : tuple of str
        The fixtures and the stock that are kept out of, each with its size and place on the table.
    compared : tuple of str
        What was found of the nominal part, a sentence for each comparison; the first one counts.
    arc_feeds : tuple of ArcFeedUse
        Arcs beside the contour whose feed rate is not F.
    shaped : Shaped or None
        What the input shaper does; None without one.
    language : str
        The dialect in which the program was read, as `--dialect` names it.
    language_is_assumed : bool
        Nothing names it, and neither the text nor the file's ending shows another one.
    timed : tuple of TimedEvent
        All events and dwells with their rows; empty where nothing was written.
    """

    source: Text
    machine: Machine
    options: Options
    cycle_time: float
    n_rows: int
    n_segments: int
    n_stops: int
    stops_within: StopsWithin
    feed_segments: int
    feed_reached: int
    feed_missed: int
    n_blended: int
    dwell_time: float
    stop_time: float
    continuous_time: float
    second_order_bound_s: float
    toppra_bound_s: float | None
    tolerance: tuple[float, float]
    start: tuple[float, ...]
    frames: tuple[Frame, ...]
    events: tuple[Event, ...]
    format: SetpointFormat
    verification: Verification | None
    free_turn: FreeTurn | None = None
    parameters: Mapping[int, float] = field(default_factory=dict)
    before: tuple[Event, ...] = ()
    parts: tuple[Part, ...] = ()
    switched: tuple[Event, ...] = ()
    tools: tuple[tuple[int | str, float], ...] = ()
    carried: tuple[tuple[int | str, float], ...] = ()
    carried_lines: tuple[int, ...] = ()
    bare_lines: tuple[int, ...] = ()
    axis_error_deg: float | None = None
    stock: Stock | None = None
    bodies: tuple[str, ...] = ()
    compared: tuple[str, ...] = ()
    shaped: Shaped | None = None
    placed_systems: frozenset[int] = frozenset()
    arc_feeds: tuple[ArcFeedUse, ...] = ()
    language: str = ""
    language_is_assumed: bool = False
    timed: tuple[TimedEvent, ...] = ()
    describe: Callable[["Summary"], str] = field(kw_only=True)

    @property
    def time_s(self) -> float:
        """Duration of the file, s: ``cycle_time``, by the name that rows and reports have for times."""
        return self.cycle_time

    @property
    def motion_time(self) -> float:
        """All of the machining time but dwells and stops, s."""
        return self.cycle_time - self.dwell_time - self.stop_time

    def __repr__(self) -> str:
        return self.describe(self).rstrip("\n")

    def _repr_html_(self) -> str:
        return format_html_text(repr(self))
