"""Modes of RS274/NGC: what its words mean, and what its codes keep, from one block to the next."""

from typing import Any, Final

from msgspec import Struct, field

from verne_post.gcode.codes import spell_g_code
from verne_post.gcode.machining.settings import Settings
from verne_post.gcode.splines import SplineDraft
from verne_post.model.moves import FeedMode, PathMode
from verne_post.model.part_setup import Vector9

_FEED_CODES: Final = {FeedMode.PER_MINUTE: "G94", FeedMode.INVERSE: "G93", FeedMode.PER_REVOLUTION: "G95"}
_PATH_CODES: Final = {PathMode.EXACT_PATH: "G61", PathMode.EXACT_STOP: "G61.1", PathMode.BLEND: "G64"}

#: G43.4 and G43.5, times ten: tool-centre-point control.
TCP_CODES: Final = (434, 435)


class Saved(Struct, frozen=True):
    """What M72, or the return from a call after M73 (``automatic``), brings back."""

    values: dict[str, object]
    settings: Settings
    system: int
    g92_on: bool
    tool: Vector9
    automatic: bool


class Cycle(Struct, frozen=True):
    """What is kept while canned cycles follow each other. mm, s."""

    normal: int  #: The drill axis.
    start: float  #: Its place before the first cycle.
    start_inch: bool  #: G20 was active there.
    #: clear, bottom: Heights of R and of the bottom.
    clear: float
    bottom: float
    numbers: tuple[float, float]  #: The words R and bottom as they were given.
    of_g90: tuple[bool, bool]  #: For each of the two whether it was given in G90.
    #: absolute, inch: G90 and G20 in the last block.
    absolute: bool
    inch: bool
    #: step, dwell: Q and P.
    step: float | None = None
    dwell: float | None = None
    shift: tuple[float, ...] | None = None  #: I J K of G87.
    #: I J K of pecks: the first, by how much each is smaller than the one before, and the least; None: all are of
    #: Q.
    falling: tuple[float, float, float] | None = None
    dwells: bool = False  #: P stood in a block of a pecking cycle, which then dwells at the bottom.
    line: int = 0  #: Where its code stands.
    change: int = 0  #: The line of a change of tools after its last block.


class AxisMaps(Struct, frozen=True):
    """Fanuc's scaling, mirror images and polar coordinates: where words of X, Y, Z lead. mm."""

    #: factors, centers: Of G51.
    factors: tuple[float, ...] = (1.0,) * 3
    centers: tuple[float, ...] = (0.0,) * 3
    mirrors: tuple[float | None, ...] = (None,) * 3  #: Of G51.1: where each axis is mirrored; None where it is not.
    polar: bool = False  #: G16 holds.

    def find_map(self, axis: int) -> tuple[float, float]:
        """Factor and shift (mm) that make a word of an axis a place: the mirror image first, then the scaling."""
        mirror, factor, center = self.mirrors[axis], self.factors[axis], self.centers[axis]
        sign, shift = (1.0, 0.0) if mirror is None else (-1.0, 2.0 * mirror)
        return factor * sign, factor * (shift - center) + center

    def flips(self, u: int, v: int) -> bool:
        """True where figures in the plane of two axes are mirror images."""
        return self.find_map(u)[0] * self.find_map(v)[0] < 0


#: Words are places of the work system.
NO_MAPS: Final = AxisMaps()


class Modes(Struct):
    """What holds in RS274/NGC. mm, degrees."""

    motion: int | None = None
    absolute: bool = True
    absolute_centers: bool = False
    #: Seconds of P1 of G4 and of cycles.
    dwell_unit: float = 1.0
    inch: bool = False
    #: What of it is Fanuc's G52, which has a store of its own there.
    local_shift: tuple[float, ...] = (0.0,) * 9
    #: G7: a lathe's X words are diameters.
    diameter_mode: bool = False
    #: G98: canned cycles retract to where they began.
    initial_level: bool = False
    cycle: Cycle | None = None
    #: The motion code from before the cycle that holds.
    motion_before: int | None = None
    #: Fanuc's M29: the spindle stands still after each hole that G84 or G74 taps.
    stops_after_tapping: bool = False
    #: Fanuc's G66: the macro that is called after every block with a motion.
    macro: Any = None  # Call
    #: Fanuc's wear of tools by number: what G10 L11 and L13 have added to length and radius, mm.
    wear: dict[int, tuple[float, float]] = field(default_factory=dict)
    #: G254 of Haas holds.
    follows_table: bool = False
    #: Fanuc's G51, G51.1, G16.
    maps: AxisMaps = NO_MAPS
    #: Fanuc's G68: the number of its turns; axes that must be named next, all together, and after which code.
    turns: int = 0
    turned_axes: tuple[int, ...] = ()
    after_turn: str = ""
    #: The last D since the tool change; only Fanuc controls keep it.
    cutter_number: int | None = None
    #: The line of a D since the tool change that no G41 or G42 has used; 0 without one.
    idle_cutter: int = 0
    #: The last H since the tool change, with the tool in the spindle; likewise.
    length_number: float | None = None
    #: A spline whose control points are being read.
    spline: SplineDraft | None = None
    #: After G5: the number of motions so far, and where a G5 that follows goes on (I and J, mm).
    spline_leg: tuple[int, float, float] | None = None
    #: M66 has read an input, whose value is not known here.
    inputs_read: bool = False
    #: What M70 and M73 have saved, one place a level of calls.
    saved_states: list[Saved | None] = field(default_factory=lambda: [None])
    #: The last code of tool length, times ten; G49 counts only after another: what a head cancels never held.
    length_code: int | None = None
    #: Fanuc's: by how much the tool length has changed since Z was named, mm.
    length_travel: float = 0.0
    #: G43.5 is active: I, J, K of straight moves are the tool axis.
    vectors: bool = False

    def show(self, feed: FeedMode, path: PathMode) -> list[str]:
        """The codes that hold."""
        return [
            "no motion (G80)" if self.motion is None else spell_g_code(self.motion),
            "G20 (inch)" if self.inch else "G21 (mm)",
            "G90 (absolute)" if self.absolute else "G91 (incremental)",
            _FEED_CODES[feed],
            _PATH_CODES[path],
            *(spell_g_code(code) for code in TCP_CODES if code == self.length_code),
        ]
