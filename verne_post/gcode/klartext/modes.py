"""What holds from statement to statement in a Klartext program, for those who show it."""

from typing import Final

from msgspec import Struct

from verne_post.model.moves import FeedMode, PathMode

_FEEDS: Final = {
    FeedMode.PER_MINUTE: "F in mm/min",
    FeedMode.INVERSE: "F in 1/min",
    FeedMode.PER_REVOLUTION: "F in mm per turn",
}


class Modes(Struct):
    """Modes."""

    inch: bool = False  #: Unit of BEGIN PGM.
    tcp: bool = False  #: M128 or FUNCTION TCPM: the tool centre point is controlled.
    tcp_line: int = 0  #: Source line that has switched that on.
    as_spatial: bool = False  #: AXIS SPAT: A, B, C are spatial angles.
    along_vectors: bool = False  #: PATHCTRL VECTOR: the tool axis goes along the great circle.
    called_preset: int | None = None  #: The preset that the program calls for G54: 0, the one set by hand, or 1.

    def show(self, feed: FeedMode, path: PathMode) -> list[str]:
        """Every statement says itself how it moves; this is what holds beside it."""
        corners = "corners blended" if path == PathMode.BLEND else "exact stop"
        return ["inch" if self.inch else "mm", "M128" if self.tcp else "M129", _FEEDS[feed], corners]
