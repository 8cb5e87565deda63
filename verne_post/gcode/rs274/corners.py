"""Corners of Fanuc, ``,R`` and ``,C``: a rounding or a chamfer between a line or an arc and the next one."""

from typing import Final

from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.arcs import Arc
from verne_post.gcode.block import Block
from verne_post.gcode.machining.contour_queue import ContourQueue, Corner, draw_element
from verne_post.gcode.machining.elements import Element
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.rs274.modes import Modes
from verne_post.model.moves import FeedMode, MoveKind

#: Codes of blocks beside a corner.
_MOTIONS: Final = (("G", 1.0), ("G", 2.0), ("G", 3.0))
_DISTANCES: Final = (("G", 90.0), ("G", 91.0))


class FanucCorners:
    """Lines and arcs on their way to the core; those before a corner wait for the next."""

    def __init__(self, core: Machining) -> None:
        self.core = core
        self.corner: Corner | None = None  #: The corner at the end of the block at hand.
        self.queue = ContourQueue()  #: What waits: its corner needs the next block.

    def add_line(self, at: At, kind: MoveKind, end: list[float], axes: list[int], *, absolute: bool = True) -> None:
        """Move straight, as :meth:`~verne_post.gcode.machining.machining.Machining.go_straight`."""
        if self.corner is None and self.queue.corner is None:
            self.core.go_straight(at, kind, end, axes, absolute=absolute)
            return
        state, line = self.core.state, self.core.recorder.lines.find_own(at.line)
        self._add(Element(line, list(state.position), end, kind, state.feed, tuple(axes), absolute=absolute))

    def add_arc(
        self, at: At, start: list[float], end: list[float], arc: Arc, axes: list[int], *, absolute: bool = True
    ) -> None:
        """Move on an arc, as :meth:`~verne_post.gcode.machining.machining.Machining.go_on_arc`."""
        if self.corner is None and self.queue.corner is None:
            self.core.go_on_arc(at, start, end, arc, axes, absolute=absolute)
            return
        feed, line = self.core.state.feed, self.core.recorder.lines.find_own(at.line)
        self._add(Element(line, list(start), end, MoveKind.FEED, feed, tuple(axes), arc, absolute=absolute))

    def prepare(self, block: Block, modes: Modes) -> None:
        """Take the corner that ends a block; refuse (VP017) anything but a line or an arc after one."""
        self.corner = None
        if self.queue.corner is None and block.corner is None:
            return
        codes, moves = [code[:2] for code in block.codes], bool(set(block.words) & set("XYZIJK"))
        if self.queue.corner is not None and (codes or block.words):
            alone = not block.settings and not set(block.words) - set("XYZIJKRF")
            if not (moves and alone and set(codes) <= {*_MOTIONS, *_DISTANCES}):
                self._refuse_waiting()
        if block.corner is not None:
            letter, size = block.corner
            if not moves or not (set(codes) & set(_MOTIONS) or modes.motion in (10, 20, 30)):
                raise ProgramError("VP017", f",{letter} must follow a feed move (G1, G2, G3)")
            if set(block.words) & set("ABC") and modes.length_code not in (434, 435):
                raise ProgramError(
                    "VP017", f",{letter} beside a turn of rotary axes needs tool-centre-point control (G43.4)"
                )
            inch = ("G", 20.0) in codes or (modes.inch and ("G", 21.0) not in codes)
            name, unit = f",{letter}", MM_PER_INCH if inch else 1.0
            self.corner = Corner(name, size * unit, name, unit, "legs" if letter == "C" else None)

    def _refuse_waiting(self) -> None:
        element, corner = self.queue.release()
        if element is not None and corner is not None:
            raise ProgramError(
                "VP017",
                f"{corner.name} of line {element.line} needs a line or an arc (G1, G2, G3) alone in the next block",
            )

    def _add(self, element: Element) -> None:
        corner, self.corner = self.corner, None
        first, before = self.queue.first, self.queue.corner
        if first is not None and before is not None:
            self.core.stand(list(first.start))
            if element.kind != MoveKind.FEED:
                self.queue.release()
                raise ProgramError(
                    "VP017", f"{before.name} of line {first.line} must be between feed moves (G1, G2, G3)"
                )
            element = self.queue.join(element, self._draw)
        if corner is None:
            self._draw(element)
            return
        if element.kind != MoveKind.FEED or self.core.state.feed_mode == FeedMode.INVERSE:
            raise ProgramError("VP017", f"{corner.name} must follow a feed move (G1, G2, G3) in G94 or G95")
        self.queue.hold(element, corner)
        self.core.stand(list(element.end))

    def _draw(self, element: Element) -> None:
        draw_element(self.core, element)
