"""Elements of a contour in order: one before a corner waits for the next, which says how much of both is left."""

import math
from collections.abc import Callable
from typing import Final

from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.machining.elements import Element, chamfer_corner, round_corner
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.machining.plane_geometry import cross
from verne_post.gcode.program_error import At, ProgramError
from verne_post.model.findings import Remedy
from verne_post.model.moves import MoveKind

#: In these steps the largest size of a corner is sought.
_STEP_MM: Final = 1e-3
_STEP_INCH: Final = 1e-4


class Corner(Struct, frozen=True):
    """A corner between two elements."""

    name: str  #: The word of the program, for messages.
    size: float  #: mm: the radius of a rounding, or of a chamfer what ``chamfer`` says.
    word: str  #: What stands before the size in the program: "RND R", ",R", "RND=".
    unit: float  #: mm that 1 is in the program.
    #: {"legs", "edge"}: Whether each line loses ``size``, or the chamfer is ``size`` long; None for a rounding.
    chamfer: str | None = None
    feed: float = 0.0  #: Feed rate of the corner, 0: that of the element before it.
    line: int = 0  #: Source line, 0: that of the element before it.


class ContourQueue(Struct):
    """An element that waits for the one that follows, and the corner between them."""

    first: Element | None = None  #: The element that waits.
    corner: Corner | None = None  #: The corner at its end; without one it is drawn as it is.

    def hold(self, element: Element, corner: Corner | None = None) -> None:
        """Let an element wait for the one that follows."""
        self.first, self.corner = element, corner

    def release(self) -> tuple[Element | None, Corner | None]:
        """What has waited; nothing waits any more."""
        waiting = self.first, self.corner
        self.first = self.corner = None
        return waiting

    def join(self, second: Element, draw: Callable[[Element], None]) -> Element:
        """Draw what has waited, and its corner; returns what is left of the element that follows.

        Raises
        ------
        ProgramError
            VP008: the corner does not fit between them; at the line of the corner.
        """
        first, corner = self.release()
        if first is None:
            return second
        try:
            parts = None if corner is None else _make_corner(first, second, corner)
        except ProgramError as error:
            error.line, error.of_program = (corner.line if corner is not None else 0) or first.line, True
            if corner is not None:
                _name_largest_size(first, second, corner, error)
            raise
        if parts is None or corner is None:
            draw(first)
            return second
        before, between, after = parts
        draw(before)
        between = replace(between, line=corner.line or first.line, feed=corner.feed or before.feed)
        try:
            draw(between)
        except ProgramError as error:  # the tool may be too wide for a rounding
            error.line, error.of_program = error.line or between.line, True
            raise
        return after


def _name_largest_size(first: Element, second: Element, corner: Corner, error: ProgramError) -> None:
    """Say the largest size that fits, in the unit of the program, rounded down; with its edit."""
    step = _STEP_INCH if corner.unit == MM_PER_INCH else _STEP_MM
    fits, fails = 0, max(math.ceil(corner.size / corner.unit / step), 1)
    while fails - fits > 1:
        middle = (fits + fails) // 2
        try:
            _make_corner(first, second, replace(corner, size=middle * step * corner.unit))
            fits = middle
        except ProgramError:
            fails = middle
    error.advise("")  # that of the code is about the numbers of an arc
    if fits:
        right, word = f"{fits * step:.4f}".rstrip("0").rstrip("."), corner.word.split()[-1].rstrip("=")
        error.message += f"; write {corner.word}{right} or less"
        now = (word, corner.size / corner.unit)
        edit = Remedy(f"write {corner.word}{right}", right, word=now, is_above=corner.name == "RNDM", is_choice=True)
        error.edits = (edit,)


def _make_corner(first: Element, second: Element, corner: Corner) -> tuple[Element, Element, Element] | None:
    """Both elements shortened, with the corner between them; None where they continue each other."""
    if corner.chamfer is None:
        return round_corner(first, second, corner.size, corner.name)
    size, t1, t2 = corner.size, first.find_direction(at_end=True), second.find_direction(at_end=False)
    if corner.chamfer == "edge" and t1 is not None and t2 is not None:
        half = 0.5 * (math.pi - abs(math.atan2(cross(t1, t2), t1[0] * t2[0] + t1[1] * t2[1])))
        size = 0.5 * size / math.sin(half) if half > 0 else size
    return chamfer_corner(first, second, size, corner.name)


def draw_element(core: Machining, element: Element) -> None:
    """Record an element on the machining core, at its own feed rate."""
    at, axes = At(element.line), list(element.axes)
    with core.keep_feed():
        if element.kind == MoveKind.FEED and element.feed != core.state.feed:
            core.set_feed(element.feed, is_given=False)
        if element.arc is None:
            core.go_straight(at, element.kind, list(element.end), axes, absolute=element.absolute)
        else:
            core.go_on_arc(at, list(element.start), list(element.end), element.arc, axes, absolute=element.absolute)
