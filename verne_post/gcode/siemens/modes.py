"""What holds from block to block in a Siemens program, beside what the interpreter of all dialects keeps."""

import math
from collections.abc import Mapping
from typing import Final

from msgspec import Struct, field
from msgspec.structs import replace

from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.siemens.frames import Frames
from verne_post.model.moves import ArcFeed, FeedMode, Frame, PathMode

#: Group 16: on the contour, at the tool's centre, on the contour of inside arcs alone.
ARC_FEEDS: Final[Mapping[str, ArcFeed]] = {
    "CFC": ArcFeed("CFC", 0.0, math.inf),
    "CFTCP": ArcFeed("CFTCP"),
    "CFIN": ArcFeed("CFIN", 0.0, 1.0),
}
#: What F means.
FEED_CODES: Final = {FeedMode.PER_MINUTE: "G94", FeedMode.INVERSE: "G93", FeedMode.PER_REVOLUTION: "G95"}


class Modes(Struct):
    """Modal G functions and values. mm and degrees."""

    motion: str = "G1"  #: G0, G1, G2, G3, CIP or CT.
    absolute: bool = True
    units: str = "G710"  #: G70, G71, G700, G710.
    exact: str = "G60"  #: G60, G64, G641 to G645.
    #: adis, ctol, otol: Tolerances of corners: mm, mm, degrees.
    adis: float | None = None
    ctol: float | None = None
    otol: float | None = None
    pole: tuple[float, float] = (0.0, 0.0)  #: Of polar words, in the plane.
    #: radius, angle: RP and AP.
    radius: float | None = None
    angle: float | None = None
    #: reference, path: ORIWKS or ORIMKS; ORIAXES, ORIVECT or ORIPLANE. None: not programmed.
    reference: str | None = None
    path: str | None = None
    tcp: bool = False  #: TRAORI is active.
    frames: Frames = field(default_factory=Frames)
    system: int = 1  #: Number of the work offset; 0: G500.
    #: The work offset as it was when its G54 was executed; None before the first change of an offset.
    offset: Frame | None = None
    edge: bool = True  #: D1: the tool length counts in places of the machine.
    plane: int = 0  #: 0 XY, 1 ZX, 2 YZ, as the interpreter of all dialects has it too.
    cycle: str = ""  #: That of MCALL, which each motion executes at its end; for messages.
    feed_mode: FeedMode = FeedMode.PER_MINUTE  #: Likewise.
    arc_feed: ArcFeed = ArcFeed("CFC", 0.0, math.inf, assumed=True)  #: CFC, CFTCP, CFIN; likewise.

    @property
    def inch(self) -> bool:
        """Lengths are inches."""
        return self.units in ("G70", "G700")

    def show(self, feed: FeedMode, _path: PathMode) -> list[str]:
        """The G functions that hold."""
        unit = f"{self.units} ({'inch' if self.inch else 'mm'})"
        way = "G90 (absolute)" if self.absolute else "G91 (incremental)"
        tcp = "TRAORI" if self.tcp else "TRAFOOF"
        modal = [f"MCALL {self.cycle}"] if self.cycle else []
        return [self.motion, unit, way, FEED_CODES[feed], self.exact, tcp, *modal]

    @property
    def length(self) -> float:
        """Mm of a unit of lengths."""
        return MM_PER_INCH if self.inch else 1.0

    @property
    def feed(self) -> float:
        """Mm of a unit of feed rates."""
        return MM_PER_INCH if self.units == "G700" else 1.0

    def copy(self) -> "Modes":
        """What SAVE keeps of them."""
        return replace(self)
