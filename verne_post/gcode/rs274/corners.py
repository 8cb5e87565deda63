"""Corners of Fanuc, ``,R`` and ``,C``: a line or an arc waits for the next one, and a rounding or a chamfer comes between them."""

from typing import Final

from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.arcs import Arc
from verne_post.gcode.block import Block
from verne_post.gcode.machining.elements import Element, chamfered_corner, rounded_corner
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.rs274.modes import Modes
from verne_post.model.moves import FeedMode, MoveKind

#: Codes of blocks beside a corner.
_MOTIONS: Final = (("G", 1.0), ("G", 2.0), ("G", 3.0))
_DISTANCES: Final = (("G", 90.0), ("G", 91.0))


class Waiting(Struct, frozen=True):
    """An element that a corner follows: its letter, R or C, and size (mm)."""

    element: Element
    letter: str
    size: float
    absolute: bool


class CornerQueue:
    """Lines and arcs on their way to the core; those before a corner wait for the next.

    Attributes
    ----------
    corner : tuple or None
        Letter and size (mm) of the corner at the end of the block at hand.
    waiting : Waiting or None
    """

    def __init__(self, core: Machining) -> None:
        self.core = core
        self.corner: tuple[str, float] | None = None
        self.waiting: Waiting | None = None

    def add_line(self, at: At, kind: MoveKind, end: list[float], axes: list[int], *, absolute: bool = True) -> None:
        """Move straight, as :meth:`~verne_post.gcode.machining.machining.Machining.line`."""
        if self.corner is None and self.waiting is None:
            self.core.line(at, kind, end, axes, absolute=absolute)
            return
        state = self.core.state
        self._add(Element(at.line, list(state.position), end, kind, state.feed, tuple(axes)), absolute)

    def add_arc(
        self, at: At, start: list[float], end: list[float], arc: Arc, axes: list[int], *, absolute: bool = True
    ) -> None:
        """Move on an arc, as :meth:`~verne_post.gcode.machining.machining.Machining.arc`."""
        if self.corner is None and self.waiting is None:
            self.core.arc(at, start, end, arc, axes, absolute=absolute)
            return
        feed = self.core.state.feed
        self._add(Element(at.line, list(start), end, MoveKind.FEED, feed, tuple(axes), arc), absolute)

    def prepare(self, block: Block, modes: Modes) -> None:
        """Take the corner that ends a block; refuse (VP017) anything but a line or an arc after one."""
        self.corner = None
        if self.waiting is None and block.corner is None:
            return
        codes, moves = [code[:2] for code in block.codes], bool(set(block.words) & set("XYZIJK"))
        if self.waiting is not None and (codes or block.words):
            alone = not block.settings and not set(block.words) - set("XYZIJKRF")
            if not (moves and alone and set(codes) <= {*_MOTIONS, *_DISTANCES}):
                self._refuse_waiting()
        if block.corner is not None:
            letter, size = block.corner
            if not moves or not (set(codes) & set(_MOTIONS) or modes.motion in (10, 20, 30)):
                raise ProgramError("VP017", f",{letter} stands after a feed move (G1, G2, G3)")
            if set(block.words) & set("ABC") and modes.length_code not in (434, 435):
                raise ProgramError(
                    "VP017", f",{letter} beside a turn of the table needs tool-centre-point control (G43.4)"
                )
            inch = ("G", 20.0) in codes or (modes.inch and ("G", 21.0) not in codes)
            self.corner = letter, size * (MM_PER_INCH if inch else 1.0)

    def _refuse_waiting(self) -> None:
        if self.waiting is not None:
            letter, element, self.waiting = self.waiting.letter, self.waiting.element, None
            raise ProgramError(
                "VP017", f",{letter} of line {element.line} needs a line or an arc (G1, G2, G3) alone in the next block"
            )

    def _add(self, element: Element, absolute: bool) -> None:
        first, corner = self.waiting, self.corner
        self.waiting = self.corner = None
        if first is not None:
            element = self._join(first, element)
        if corner is None:
            self._emit(element, absolute)
            return
        if element.kind != MoveKind.FEED or self.core.state.feed_mode == FeedMode.INVERSE:
            raise ProgramError("VP017", f",{corner[0]} stands after a feed move (G1, G2, G3) in G94 or G95")
        self.waiting = Waiting(element, *corner, absolute)
        self.core.stand(list(element.end))

    def _join(self, first: Waiting, second: Element) -> Element:
        """Emit the element that has waited, shortened, and the corner; returns what is left of the second."""
        self.core.stand(list(first.element.start))
        if second.kind != MoveKind.FEED:
            raise ProgramError(
                "VP017", f",{first.letter} of line {first.element.line} stands between feed moves (G1, G2, G3)"
            )
        make = chamfered_corner if first.letter == "C" else rounded_corner
        parts = make(first.element, second, first.size, f",{first.letter}")
        if parts is None:  # they go on in one direction
            self._emit(first.element, first.absolute)
            return second
        self._emit(parts[0], first.absolute)
        self._emit(replace(parts[1], line=first.element.line), first.absolute)
        return parts[2]

    def _emit(self, element: Element, absolute: bool) -> None:
        at, axes, core = At(element.line), list(element.axes), self.core
        with core.keep_feed():
            core.set_feed(element.feed)
            if element.arc is None:
                core.line(at, element.kind, list(element.end), axes, absolute=absolute)
            else:
                core.arc(at, list(element.start), list(element.end), element.arc, axes, absolute=absolute)
