"""The contour of Klartext: elements in order, corners (RND, CHF), radius compensation."""

from typing import Final

from msgspec import Struct
from msgspec.structs import replace

from verne_post.gcode.block import Block
from verne_post.gcode.compensation import Compensation
from verne_post.gcode.expressions import BlockError
from verne_post.gcode.klartext.elements import Element, chamfered_corner, rounded_corner
from verne_post.gcode.klartext.paths import KlartextPaths
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.words import Words
from verne_post.model.moves import FeedMode, MoveKind

_ROTARY: Final = (3, 4, 5)
_CODES: Final = {"RL": 410, "RR": 420}


class Corner(Struct, frozen=True):
    """RND or CHF, waiting for the element after it: its length (mm), its feed rate (0: as before), its line."""

    name: str
    size: float
    feed: float
    line: int


class KlartextContour(KlartextPaths):
    """Path functions, and how their elements follow each other."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(*arguments)
        self.pending: Element | None = None
        self.corner: Corner | None = None
        self.side: str | None = None  # RL or RR, also where the radius is 0
        self.last_rapid = False
        self.delta_radius = 0.0
        self.call_feed = 0.0  # F of TOOL CALL, which F AUTO takes
        self.per_turn = False  # M136

    def now(self) -> list[float]:
        """The programmed position (9) at which the next element begins."""
        return self.pending.end if self.pending is not None else self.state.position

    # --- elements in order ---------------------------------------------------------------------------

    def add_element(self, element: Element, *, wait: bool) -> None:
        """The next element of the contour; with ``wait`` a corner follows, which may shorten it."""
        element = self._finish_corner(element)
        self.direction = element.direction(at_end=True) if element.plane == 0 else None
        if wait:
            self.pending = element
        else:
            self._emit(element)

    def _finish_corner(self, element: Element) -> Element:
        """Emit what has waited for this element; returns what is left of it."""
        first, corner = self.pending, self.corner
        self.pending = self.corner = None
        if first is None:
            return element
        if corner is None:
            self._emit(first)
            return element
        if corner.name == "CHF":
            before, between, after = chamfered_corner(first, element, corner.size)
        else:
            rounded = rounded_corner(first, element, corner.size)
            if rounded is None:
                self._emit(first)
                return element
            before, between, after = rounded
        self._emit(before)
        self._emit(replace(between, line=corner.line, feed=corner.feed or before.feed))
        return after

    def check_nothing_waits(self, what: str) -> None:
        """Refuse what would come between a corner or an approach and its element."""
        if self.corner is not None or self.pending is not None:
            raise BlockError(
                "VP017", f"{what} where {self.corner.name if self.corner else 'RND or CHF'} needs the next line or arc"
            )

    def _emit(self, element: Element) -> None:
        """Record one element."""
        state = self.state
        if element.kind == MoveKind.FEED:
            kept = state.feed, state.arc_feed
            state.feed, state.arc_feed = element.feed, element.arc_feed
            try:
                self._check_feed(self.block, 10 if element.arc is None else 20)
                self._record_element(element)
            finally:
                state.feed, state.arc_feed = kept
        else:
            self._record_element(element)
        self.last_rapid = element.kind == MoveKind.RAPID

    def _check_feed(self, block: Block, motion: int) -> None:
        state = self.state
        if state.feed == 0.0:
            raise BlockError("VP009", "a line or an arc with feed rate zero; give F, or FMAX")
        turning = state.spindle_on and state.spindle_speed > 0
        if state.feed_mode == FeedMode.PER_REVOLUTION and self.setup.machine and not turning:
            raise BlockError("VP009", "a feed rate per turn (FU, M136) needs a turning spindle; give S and M3")
        if self.setup.machine and not state.length_given:
            raise BlockError(
                "VP012", "no tool before the first feed move; write TOOL CALL with --tool-table or TOOL DEF, or use --tool-length MM"
            )  # fmt: skip

    def _record_element(self, element: Element) -> None:
        if self.tcp is False and any(axis < 3 for axis in element.axes):
            self.check_upright("a motion")
        self._motion_start(element.kind, absolute=True, machine=False)
        axes = list(element.axes)
        if any(axis == 5 for axis in axes):
            self.recorder.fix_c(element.line)
        if element.arc is None:
            self._record(element.line, element.kind, element.end, axes, absolute=True)
        else:
            self._record_arc(element.line, element.start, element.end, element.arc, axes, absolute=True)

    # --- corners ---------------------------------------------------------------------------------------

    def set_corner(self, statement: Statement, words: Words) -> None:
        """RND R5, CHF 2: between the element before and the next one."""
        if self.pending is None or self.corner is not None:
            raise statement.error("VP017", f"{statement.keyword} needs a line or an arc right before it")
        size = words.take("R") if statement.keyword == "RND" else words.take("LEN")
        feed = self.feed_value(words)
        words.check_used(statement)
        if size is None or size <= 0:
            raise statement.error(
                "VP007" if size is not None else "VP005", f"{statement.keyword} needs a length greater than 0"
            )
        self.corner = Corner(statement.keyword, size * self.unit, feed, statement.line)

    def feed_value(self, words: Words) -> float:
        """F of a block as the feed mode has it, for this block alone; 0 where it has none."""
        value = words.take("F")
        return 0.0 if value is None else self._feed_in_force(value)

    def _feed_in_force(self, value: float) -> float:
        """A number after F as the feed mode has it: mm per turn under M136, else mm/min."""
        return self._length(value) if self.per_turn and value > 0 else self.feed_of_word(value)

    def feed_of_word(self, value: float) -> float:
        """A number after F: mm/min, or 0.1 inch/min in a program in inches."""
        if value <= 0:
            raise BlockError("VP007", f"F{value:g}: a feed rate is greater than 0")
        return value * 2.54 if self.state.inch else value

    # --- feed ---------------------------------------------------------------------------------------------

    def set_feed(self, statement: Statement, words: Words) -> None:
        """F, F AUTO, FU."""
        state = self.state
        if words.automatic:
            if not self.call_feed:
                raise statement.error("VP009", "F AUTO, and TOOL CALL has given no F")
            self._change_feed_mode(FeedMode.PER_MINUTE)
            state.feed, words.automatic = self.call_feed, False
            words.take_no_other_feed(statement)
        per_turn, per_tooth, value = words.take("FU"), words.take("FZ"), words.take("F")
        if per_tooth is not None:
            raise statement.error(
                "VP002", "FZ is not executed: the number of teeth is not known; write FU or F", words.columns["FZ"]
            )
        if per_turn is not None:
            if value is not None or words.rapid:
                raise statement.error("VP004", "FU and another F in one block", words.columns["FU"])
            if per_turn <= 0:
                raise statement.error("VP007", "FU must be greater than 0", words.columns["FU"])
            self._change_feed_mode(FeedMode.PER_REVOLUTION)
            state.feed = self._length(per_turn)
        if value is not None:
            self._change_feed_mode(FeedMode.PER_REVOLUTION if self.per_turn else FeedMode.PER_MINUTE)
            state.feed = self._feed_in_force(value)

    def _change_feed_mode(self, mode: FeedMode) -> None:
        if mode != self.state.feed_mode:
            self._refuse_compensation("a change of feed mode")
        self.state.feed_mode = mode

    # --- compensation -------------------------------------------------------------------------------------

    def set_side(self, statement: Statement, side: str | None) -> None:
        """R0, RL, RR; None: as before."""
        state = self.state
        if side is None or (side if side != "R0" else None) == self.side:
            return
        if side in ("R+", "R-"):
            raise statement.error("VP002", f"{side} lengthens single axes by the radius; it is not executed")
        if side == "R0":
            state.arc_may_follow = state.arc_may_follow and (
                state.compensation is None or state.compensation.segment is None
            )
            state.compensation, self.side = None, None
            return
        if self.side is not None:
            raise statement.error("VP017", f"{side} while {self.side} is in force; write R0 between them")
        radius = self.tool_radius()
        if self.tcp and state.tool_axis is not None:
            raise statement.error("VP017", f"{side} while a tool vector holds")
        self.side = side
        sign = (1.0 if side == "RL" else -1.0) * (-1.0 if self.flips else 1.0)
        if radius:
            state.compensation = Compensation(_CODES[side], 0, sign * radius, perpendicular=True)

    def tool_radius(self) -> float:
        """Radius of the tool in the spindle with DR of its call, mm.

        Raises
        ------
        BlockError
            VP012 where it is not known.
        """
        state = self.state
        number = state.loaded_tool or 0
        if number == 0 or state.tools is None or number not in state.tools:
            text = f"the radius of tool {number} is not known; give --tool-table FILE, or TOOL DEF with L and R"
            raise BlockError("VP012", text, about=f"tool {number}")
        radius = 0.5 * state.tools[number].diameter + self.delta_radius
        if radius < 0:
            raise BlockError("VP007", f"tool {number} has the radius {radius:g} mm with DR of its call")
        return radius

    @property
    def offset(self) -> float:
        """Radius to the left of the contour that is in force, mm."""
        return self.state.compensation.radius if self.state.compensation is not None else 0.0
