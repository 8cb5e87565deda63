"""Corners of contours in Siemens programs: RND=, RNDM=, CHF=, CHR= and FRC= between two lines or arcs of the XY plane.

A line or arc with a corner at its end waits for the next one, which decides how much of both is left. Meanwhile the
tool counts as standing at its programmed end.
"""

from typing import Final

from verne_post.gcode.arcs import Arc
from verne_post.gcode.machining.contour_queue import ContourQueue, Corner, draw_element
from verne_post.gcode.machining.elements import Element
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.siemens.modes import Modes
from verne_post.gcode.siemens.words import Words
from verne_post.model.moves import MoveKind

#: Words of a corner at the end of the block, and what their length is.
_OF_BLOCK: Final = {"RND": None, "CHF": "edge", "CHR": "legs"}
WORDS: Final = (*_OF_BLOCK, "RNDM", "FRC")
_CONTOUR: Final = ("G1", "G2", "G3")
#: What the block after a corner may have: its motion, and F.
_OF_MOTION: Final = frozenset(("motion",))
_IN_PLANE: Final = frozenset(("X", "Y", "I", "J", "AR", "AP", "RP"))
_AXES: Final = frozenset("XYZABC")
#: M functions that end a program.
_ENDS: Final = (2, 17, 30)
_PLACES: Final = frozenset(("X", "Y", "Z", "I", "J", "CR", "AR", "AP", "RP", "TURN", "F", *WORDS))


class SiemensCorners:
    """Records lines and arcs on the machining core, with the corners between them.

    ``radius`` is that of RNDM, mm; 0: it is off.
    """

    def __init__(self, core: Machining) -> None:
        self.core, self.state = core, core.state
        self.radius = 0.0
        self._corner: Corner | None = None
        self._queue = ContourQueue()

    @property
    def is_idle(self) -> bool:
        """True where lines and arcs are recorded as they come."""
        return self._queue.first is None and not self.radius

    # --- words --------------------------------------------------------------------------------------------

    def begin_block(self, words: Words, modes: Modes) -> None:
        """A block after a waiting one continues the contour, or the corner is left out, as on the control.

        ProgramError VP017: it goes on with the contour, and does something else as well.
        """
        calls = words.calls or words.user_names
        if (
            self._queue.corner is None
            or words.is_empty
            or (words.words.keys() <= {"RNDM"} and not (words.groups or words.m or calls))
        ):
            return
        motion = words.find_code("motion") or modes.motion
        goes_on = motion in (*_CONTOUR, "CT") and not words.words.keys().isdisjoint(_IN_PLANE)
        more = words.m or calls or not words.groups.keys() <= _OF_MOTION or not words.words.keys() <= _PLACES
        ends = not words.words.keys().isdisjoint(_AXES) or any(number in _ENDS for number, _column in words.m)
        if goes_on and not more and motion != "CT":
            return
        if goes_on or not ends:
            name = self._queue.corner.name
            raise ProgramError(
                "VP017",
                f"{name} before a block with more than a line or an arc of the contour and F; write the rest before "
                f"the block of {name}",
            )
        self.finish()

    def read(self, words: Words, modes: Modes) -> None:
        """Take the words of a corner at the end of the block."""
        if (modal := words.take("RNDM")) is not None:
            if modal.value < 0:
                raise modal.error("VP007", f"RNDM={modal.value:g}: a radius is not negative; 0 ends it")
            self.radius = modal.value * modes.length
        given = [word for name in _OF_BLOCK if (word := words.take(name)) is not None]
        feed = words.take("FRC")
        self._corner = Corner("RNDM", self.radius, "RNDM=", modes.length) if self.radius else None
        if not given:
            if feed is not None:
                raise feed.error("VP006", "FRC= is the feed rate of RND=, CHF= or CHR= in its block")
            return
        if len(given) > 1:
            raise given[1].error("VP003", f"{given[0].name} and {given[1].name} in one block")
        word = given[0]
        if (words.find_code("motion") or modes.motion) not in _CONTOUR or words.find_code("exact stop of the block"):
            raise word.error(
                "VP017", f"{word.name}= belongs to a line or an arc at a feed rate (G1, G2, G3), without G9"
            )
        if word.value < 0 or (feed is not None and feed.value < 0):
            raise word.error("VP007", f"{word.name}={word.value:g}: a length is not negative")
        self._corner = (
            Corner(
                word.name,
                word.value * modes.length,
                f"{word.name}=",
                modes.length,
                _OF_BLOCK[word.name],
                0.0 if feed is None else feed.value * modes.feed,
            )
            if word.value
            else None
        )

    def pass_turn(self) -> None:
        """The table turns beside the contour, where there is no corner to round.

        ProgramError VP017: the block has one.
        """
        corner, self._corner = self._corner, None
        if corner is not None and corner.name != "RNDM":
            raise ProgramError("VP017", f"{corner.name}= beside a turn of rotary axes without TRAORI; write TRAORI")

    # --- lines and arcs -----------------------------------------------------------------------------------

    def add_line(self, at: At, kind: MoveKind, end: list[float], axes: list[int]) -> None:
        """A straight move from where the tool stands to an end (9) of the frame."""
        if self._queue.first is None and self._corner is None:
            self.core.go_straight(at, kind, end, axes)
        else:
            self._add(at, kind, end, axes, None)

    def add_arc(self, at: At, end: list[float], arc: Arc, axes: list[int]) -> None:
        """An arc from where the tool stands."""
        if self._queue.first is None and self._corner is None:
            self.core.go_on_arc(at, list(self.state.position), end, arc, axes)
        else:
            self._add(at, MoveKind.FEED, end, axes, arc)

    def _add(self, at: At, kind: MoveKind, end: list[float], axes: list[int], arc: Arc | None) -> None:
        state = self.state
        start = list(state.position)
        element = Element(
            self.core.recorder.lines.find_own(at.line), start, end, kind, state.feed, tuple(axes), arc, state.arc_feed
        )
        corner, self._corner = self._corner, None
        if self._queue.first is not None:
            if kind == MoveKind.RAPID or element.find_direction(at_end=False) is None:
                self.finish()
            else:
                self.core.stand(self._queue.first.start)
                element = self._queue.join(element, self._draw)
        if corner is None or kind == MoveKind.RAPID or element.find_direction(at_end=True) is None:
            self._draw(element)
            return
        if state.plane != 0:
            raise ProgramError("VP002", f"{corner.name} is executed in the XY plane (G17)")
        self._queue.hold(element, corner)
        self.core.arrive(end, axes)

    def _draw(self, element: Element) -> None:
        draw_element(self.core, element)

    def finish(self) -> None:
        """No line or arc of the contour follows: what has waited is recorded without a corner."""
        element, _corner = self._queue.release()
        if element is not None:
            self.core.stand(element.start)
            self._draw(element)
