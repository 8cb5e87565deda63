"""The contour of Klartext: elements in order, corners (RND, CHF), approach and departure (APPR, DEP), compensation."""

import math
from dataclasses import dataclass, replace
from typing import Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.compensation import Compensation
from verne_post.gcode.expressions import BlockError
from verne_post.gcode.klartext.elements import Element, Point, chamfered_corner, left, make_arc, rounded_corner
from verne_post.gcode.klartext.paths import KlartextPaths
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.words import Words
from verne_post.model.moves import MoveKind

_ROTARY: Final = (3, 4, 5)
_CODES: Final = {"RL": 410, "RR": 420}


@dataclass(frozen=True)
class Corner:
    """RND or CHF, waiting for the element after it: its length (mm), its feed rate (0: as before), its line."""

    name: str
    size: float
    feed: float
    line: int


@dataclass(frozen=True)
class Approach:
    """APPR, waiting for the contour: the first point of the contour, and what leads to it.

    ``turn`` is the centre angle of CT in degrees, ``length`` LEN or R in mm, ``rapid`` whether the way to it is.
    """

    kind: str
    point: list[float]
    length: float
    turn: float
    feed: float
    rapid: bool
    line: int


class KlartextContour(KlartextPaths):
    """Path functions, and how their elements follow each other."""

    def __init__(self, *arguments: object) -> None:
        super().__init__(*arguments)
        self.pending: Element | None = None
        self.corner: Corner | None = None
        self.approach: Approach | None = None
        self.side: str | None = None  # RL or RR, also where the radius is 0
        self.last_rapid = False
        self.delta_radius = 0.0

    def now(self) -> list[float]:
        """The programmed position (9) at which the next element begins."""
        if self.approach is not None:
            return self.approach.point
        return self.pending.end if self.pending is not None else self.state.position

    # --- elements in order ---------------------------------------------------------------------------

    def add_element(self, element: Element, *, wait: bool) -> None:
        """The next element of the contour; with ``wait`` a corner follows, which may shorten it."""
        if self.approach is not None:
            self._approach_contour(self.approach, element)
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
        if self.approach is not None:
            raise BlockError("VP017", f"{what} after APPR, which needs the first line or arc of the contour")

    def _emit(self, element: Element) -> None:
        """Record one element."""
        state = self.state
        if element.kind == MoveKind.FEED:
            kept, state.feed = state.feed, element.feed
            try:
                self._check_feed(self.block, 10 if element.arc is None else 20)
                self._record_element(element)
            finally:
                state.feed = kept
        else:
            self._record_element(element)
        self.last_rapid = element.kind == MoveKind.RAPID

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
        return 0.0 if value is None else self.feed_of_word(value)

    def feed_of_word(self, value: float) -> float:
        """A number after F: mm/min, or 0.1 inch/min in a program in inches."""
        if value <= 0:
            raise BlockError("VP007", f"F{value:g}: a feed rate is greater than 0")
        return value * 2.54 if self.state.inch else value

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
        if self.tcp and state.vector is not None:
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
            raise BlockError(
                "VP012", f"the radius of tool {number} is not known; give --tool-table FILE, or TOOL DEF {number} L R"
            )
        radius = 0.5 * state.tools[number].diameter + self.delta_radius
        if radius < 0:
            raise BlockError("VP007", f"tool {number} has the radius {radius:g} mm with DR of its call")
        return radius

    @property
    def offset(self) -> float:
        """Radius to the left of the contour that is in force, mm."""
        return self.state.compensation.radius if self.state.compensation is not None else 0.0

    # --- APPR, DEP ----------------------------------------------------------------------------------------

    def start_approach(self, statement: Statement, words: Words, kind: str, point: list[float]) -> None:
        """APPR LT, LN, CT, LCT: waits for the first element of the contour."""
        self.check_nothing_waits("APPR")
        if self.side is not None:
            raise statement.error("VP017", f"APPR while {self.side} is in force")
        length, turn = self._approach_size(statement, words, kind)
        self.set_side(statement, words.compensation)
        if self.side is None and kind != "LT":
            raise statement.error(
                "VP005", f"APPR {kind} needs RL or RR, which say on which side of the contour it comes from"
            )
        feed = self.feed_value(words) or self.state.feed
        words.check_used(statement)
        self.approach = Approach(kind, point, length, turn, feed, self.last_rapid, self.block.line)

    def _approach_size(self, statement: Statement, words: Words, kind: str) -> tuple[float, float]:
        """LEN or R in mm, and CCA."""
        name = "LEN" if kind in ("LT", "LN") else "R"
        size = words.take(name)
        if size is None or size == 0 or (size < 0 and kind != "CT"):
            raise statement.error(
                "VP005" if size is None else "VP007", f"{statement.keyword} {kind} needs {name}, greater than 0"
            )
        turn = 0.0
        if kind == "CT":
            angle = words.take("CCA")
            if angle is None or not 0 < angle <= 360:
                raise statement.error(
                    "VP005" if angle is None else "VP007", f"{statement.keyword} CT needs CCA, up to 360 degrees"
                )
            turn = angle
        return size * self.unit, turn

    def _approach_contour(self, approach: Approach, element: Element) -> None:
        """From where the tool stands to the first point of the contour."""
        self.approach = None
        t = element.direction(at_end=False)
        if element.plane or t is None:
            raise BlockError("VP008", "APPR needs a contour that begins in X and Y")
        point = approach.point
        p, rapid = (point[0], point[1]), MoveKind.RAPID if approach.rapid else MoveKind.FEED
        side = math.copysign(1.0, self.offset) if self.offset else (1.0 if (self.side == "RL") != self.flips else -1.0)
        feed = approach.feed
        if approach.kind == "LT":
            before = (p[0] - approach.length * t[0], p[1] - approach.length * t[1])
            self._go_to(approach, before, rapid)
            self._line_to(approach, p, feed)
        elif approach.kind == "LN":
            n = left(t)
            away = side * (approach.length + abs(self.offset))
            held, self.state.compensation = self.state.compensation, None
            self._go_to(approach, (p[0] + away * n[0], p[1] + away * n[1]), rapid)
            self.state.compensation = held
            self._line_to(approach, p, feed)
        else:
            n = left(t)
            center = (p[0] + side * approach.length * n[0], p[1] + side * approach.length * n[1])
            sense = side * math.copysign(1.0, approach.length)
            if approach.kind == "CT":
                before = _turned(p, center, -sense * approach.turn)
            else:
                before = self._touch(self.state.position, center, abs(approach.length), sense, leaving=False)
                rapid = MoveKind.FEED
            self._go_to(approach, before, rapid)
            sweep = sense * approach.turn if approach.kind == "CT" else _sweep_to(before, p, center, sense)
            if abs(sweep) > 0:
                self._arc_to(approach.line, p, make_arc(list(self.state.position), 0, center, sweep), feed)

    def _touch(self, position: list[float], center: Point, radius: float, sense: float, *, leaving: bool) -> Point:
        """Where the tangent between the tool's place and a circle about a centre touches the circle, of the contour."""
        reach = radius - sense * self.offset
        dx, dy = position[0] - center[0], position[1] - center[1]
        distance = math.hypot(dx, dy)
        if reach <= 0:
            raise BlockError(
                "VP026", f"the radius {radius:g} mm of the approach or departure is not greater than that of the tool"
            )
        if distance < reach:
            raise BlockError(
                "VP008", "the tool stands inside the arc of the approach or departure; no tangent leads to it"
            )
        angle = math.atan2(dy, dx) + (-1 if leaving else 1) * sense * math.acos(min(reach / distance, 1.0))
        return center[0] + radius * math.cos(angle), center[1] + radius * math.sin(angle)

    def _go_to(self, approach: Approach, place: Point, kind: MoveKind) -> None:
        """To the auxiliary point: first in X and Y, then in Z."""
        here = self.state.position
        end = [place[0], place[1], *here[2:]]
        self._emit(Element(approach.line, here, end, kind, approach.feed, (0, 1)))
        if approach.point[2] != here[2]:
            end = [*end[:2], *approach.point[2:]]
            self._emit(Element(approach.line, self.state.position, end, kind, approach.feed, (2,)))

    def _line_to(self, approach: Approach, place: Point, feed: float) -> None:
        end = [place[0], place[1], *self.state.position[2:]]
        self._emit(Element(approach.line, self.state.position, end, MoveKind.FEED, feed))

    def _arc_to(self, line: int, place: Point, arc: object, feed: float) -> None:
        end = [place[0], place[1], *self.state.position[2:]]
        self._emit(Element(line, self.state.position, end, MoveKind.FEED, feed, (0, 1), arc))  # type: ignore[arg-type]

    def depart(
        self, statement: Statement, words: Words, kind: str, point: list[float] | None, height: float | None
    ) -> None:
        """DEP LT, LN, CT, LCT: away from the end of the contour, and compensation ends.

        ``point``: where LCT ends; ``height``: Z of the frame, to which the tool goes last.
        """
        self.check_nothing_waits("DEP")
        t, line = self.direction, self.block.line
        if t is None:
            raise statement.error("VP017", "DEP needs a line or an arc in X and Y right before it")
        length, turn = self._approach_size(statement, words, kind)
        if self.side is None and kind != "LT":
            raise statement.error("VP017", f"DEP {kind} needs RL or RR in force, which say to which side it goes")
        feed = self.feed_value(words) or self.state.feed
        words.check_used(statement)
        side = math.copysign(1.0, self.offset) if self.offset else (1.0 if (self.side == "RL") != self.flips else -1.0)
        end = self.state.position
        p, n = (end[0], end[1]), left(t)
        if kind == "LT":
            self._emit(Element(line, end, [p[0] + length * t[0], p[1] + length * t[1], *end[2:]], MoveKind.FEED, feed))
        elif kind in ("CT", "LCT"):
            center = (p[0] + side * length * n[0], p[1] + side * length * n[1])
            sense = side * math.copysign(1.0, length)
            if kind == "CT":
                place, sweep = _turned(p, center, sense * turn), sense * turn
            else:
                assert point is not None
                place = self._touch(point, center, length, sense, leaving=True)
                sweep = _sweep_to(p, place, center, sense)
            if abs(sweep) > 0:
                self._arc_to(line, place, make_arc(list(end), 0, center, sweep), feed)
        offset = self.offset
        self._end_side()
        if kind == "LN":
            away = side * length + offset
            self._emit(
                Element(
                    line, self.state.position, [p[0] + away * n[0], p[1] + away * n[1], *end[2:]], MoveKind.FEED, feed
                )
            )
        elif kind == "LCT":
            assert point is not None
            self._emit(Element(line, self.state.position, point, MoveKind.FEED, feed))
        if height is not None:
            self._emit(
                Element(
                    line, self.state.position, [*self.state.position[:2], height, *end[3:]], MoveKind.FEED, feed, (2,)
                )
            )
        self.direction = None

    def _end_side(self) -> None:
        """Compensation ends; the tool stays beside the contour."""
        state = self.state
        state.compensation, self.side = None, None
        if state.centre is not None:
            state.position, state.centre = state.centre, None
        state.arc_may_follow = True

    def needs_wait(self, element: Element) -> bool:
        """True for an element at which a corner can begin."""
        return all(abs(element.end[axis] - element.start[axis]) < ZERO_LENGTH_MM for axis in _ROTARY)


def _turned(point: Point, center: Point, angle: float) -> Point:
    """A point turned about a centre by degrees."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    dx, dy = point[0] - center[0], point[1] - center[1]
    return center[0] + c * dx - s * dy, center[1] + s * dx + c * dy


def _sweep_to(start: Point, end: Point, center: Point, sense: float) -> float:
    """Signed sweep in degrees between two points of a circle; 0 where they are one."""
    if math.dist(start, end) < ZERO_LENGTH_MM:
        return 0.0
    first = math.atan2(start[1] - center[1], start[0] - center[0])
    last = math.atan2(end[1] - center[1], end[0] - center[0])
    return sense * math.degrees((sense * (last - first)) % (2 * math.pi))
