"""Approach and departure of a contour: APPR and DEP with LT, LN, CT, LCT."""

import math

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.klartext.contour import KlartextContour
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.klartext.paths import KlartextPaths
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.waiting import Approach
from verne_post.gcode.klartext.words import Words
from verne_post.gcode.machining.elements import Element, make_arc
from verne_post.gcode.machining.plane_geometry import Point, measure_sweep, step_left, turn_point
from verne_post.gcode.program_error import At, ProgramError
from verne_post.model.moves import MoveKind


class KlartextApproach:
    """The contour, and how the tool comes to it and leaves it."""

    def __init__(self, frames: KlartextFrames, paths: KlartextPaths, contour: KlartextContour) -> None:
        self.frames = frames
        self.paths = paths
        self.contour = contour
        self.core = frames.core
        self.state = frames.state
        self.waiting = frames.waiting

    def add_element(self, element: Element, *, wait: bool) -> None:
        """The next element of the contour; the first one after APPR is approached."""
        if self.waiting.approach is not None:
            self._approach_contour(self.waiting.approach, element)
        self.contour.take_element(element, wait=wait)

    @property
    def _side_sign(self) -> float:
        """1 where the tool is left of the contour."""
        if self.contour.offset:
            return math.copysign(1.0, self.contour.offset)
        return 1.0 if (self.contour.side == "RL") != self.frames.flips else -1.0

    def start_approach(self, statement: Statement, words: Words, kind: str, point: list[float]) -> None:
        """APPR LT, LN, CT, LCT: waits for the first element of the contour."""
        self.waiting.refuse("APPR")
        if self.contour.side is not None:
            raise statement.error("VP017", f"APPR while {self.contour.side} is in force")
        length, turn = self._approach_size(statement, words, kind)
        self.contour.set_side(statement, words.compensation)
        if self.contour.side is None and kind != "LT":
            raise statement.error(
                "VP005", f"APPR {kind} needs RL or RR, for the side of the contour from which it comes"
            )
        if self.contour.side is None:
            self._warn_of_side(f"APPR {kind} without RL or RR", "write RL or RR")
        before = self.state.feed
        self.contour.set_feed(statement, words)
        words.check_used(statement, "side M")
        feed = self.state.feed
        self.waiting.approach = Approach(
            kind, point, length, turn, feed, before, self.contour.last_rapid, self.frames.block.line
        )

    def _warn_of_side(self, what: str, remedy: str) -> None:
        """VP026, as a warning once a program: the contour of an approach or a departure has no radius compensation."""
        if not any(item.code == "VP026" for item in self.core.recorder.warnings.values()):
            text = f"{what}: the path has no radius compensation, and the centre of the tool follows the contour"
            text += f"; {remedy} if the tool is to go beside it"
            self.core.recorder.warn("VP026", text, self.frames.block.line, None, "warning")

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
        return size * self.frames.unit, turn

    def _approach_contour(self, approach: Approach, element: Element) -> None:
        """From where the tool stands to beside the first point of the contour, on the path of the tool's centre."""
        self.waiting.approach = None
        t = element.find_direction(at_end=False)
        if element.plane or t is None:
            raise ProgramError("VP008", "APPR needs a contour that begins in X and Y")
        kind, point = approach.kind, approach.point
        rapid = MoveKind.RAPID if approach.rapid and kind != "LCT" else MoveKind.FEED
        beside, side = step_left((point[0], point[1]), t, self.contour.offset), self._side_sign
        center = step_left(beside, t, side * approach.length)
        sense = side * math.copysign(1.0, approach.length)
        compensation = self.core.suspend_compensation()
        if kind == "LT":
            self._go_to(approach, (beside[0] - approach.length * t[0], beside[1] - approach.length * t[1]), rapid)
        elif kind == "LN":
            self._go_to(approach, center, rapid)
        elif kind == "CT":
            self._go_to(approach, turn_point(beside, center, -sense * approach.turn), rapid)
        else:
            self._go_to(approach, _touch(self.state.position, center, approach.length, sense, leaving=False), rapid)
        if kind in ("LT", "LN"):
            self._add_line(approach.line, beside, approach.feed)
        else:
            here = (self.state.position[0], self.state.position[1])
            sweep = sense * approach.turn if kind == "CT" else _measure_sweep(here, beside, center, sense)
            self._add_arc(approach.line, beside, center, sweep, approach.feed)
        if compensation is not None:
            self.core.enter_beside(At(approach.line), compensation, point)

    def _go_to(self, approach: Approach, place: Point, kind: MoveKind) -> None:
        """To the auxiliary point: first in X and Y, then in Z."""
        here, feed = self.state.position, approach.feed if approach.kind == "LCT" else approach.before or approach.feed
        end = [place[0], place[1], *here[2:]]
        self.contour.emit(Element(approach.line, here, end, kind, feed, (0, 1)))
        if approach.point[2] != here[2]:
            end = [*end[:2], *approach.point[2:]]
            self.contour.emit(Element(approach.line, self.state.position, end, kind, feed, (2,)))

    def _add_line(self, line: int, place: Point, feed: float) -> None:
        end = [place[0], place[1], *self.state.position[2:]]
        self.contour.emit(Element(line, self.state.position, end, MoveKind.FEED, feed, (0, 1)))

    def _add_arc(self, line: int, place: Point, center: Point, sweep: float, feed: float) -> None:
        if sweep:
            start = list(self.state.position)
            end = [place[0], place[1], *start[2:]]
            self.contour.emit(Element(line, start, end, MoveKind.FEED, feed, (0, 1), make_arc(start, 0, center, sweep)))

    def depart(
        self, statement: Statement, words: Words, kind: str, point: list[float] | None, height: float | None
    ) -> None:
        """DEP LT, LN, CT, LCT: away from the end of the contour, and compensation ends.

        ``point``: where LCT ends; ``height``: Z of the frame, to which the tool goes last.
        """
        self.waiting.refuse("DEP")
        t, line = self.paths.direction, self.frames.block.line
        if t is None:
            raise statement.error("VP017", "DEP needs a line or an arc in X and Y right before it")
        length, turn = self._approach_size(statement, words, kind)
        if self.contour.side is None and kind != "LT":
            raise statement.error("VP017", f"DEP {kind} needs RL or RR in force, for the side to which it goes")
        if self.contour.side is None:
            self._warn_of_side(f"DEP {kind} where neither RL nor RR is in force", "write RL or RR in APPR or L before")
        self.contour.set_feed(statement, words)
        feed = self.state.feed
        words.check_used(statement, "side M")
        side = self._side_sign
        here = step_left((self.state.position[0], self.state.position[1]), t, self.contour.offset)
        center = step_left(here, t, side * length)
        sense = side * math.copysign(1.0, length)
        self._end_side()
        if kind == "LT":
            self._add_line(line, (here[0] + length * t[0], here[1] + length * t[1]), feed)
        elif kind == "LN":
            self._add_line(line, center, feed)
        elif kind == "CT":
            self._add_arc(line, turn_point(here, center, sense * turn), center, sense * turn, feed)
        else:
            assert point is not None
            place = _touch(point, center, length, sense, leaving=True)
            self._add_arc(line, place, center, _measure_sweep(here, place, center, sense), feed)
            self._add_line(line, (point[0], point[1]), feed)
        if height is not None:
            end = [*self.state.position[:2], height, *self.state.position[3:]]
            self.contour.emit(Element(line, self.state.position, end, MoveKind.FEED, feed, (2,)))
        self.paths.direction = None

    def _end_side(self) -> None:
        """Compensation ends; the tool stays beside the contour."""
        self.core.leave_beside()
        self.contour.side = None


def _touch(position: list[float], center: Point, radius: float, sense: float, *, leaving: bool) -> Point:
    """Where the tangent between a place and a circle touches it, for an arc that arrives there or leaves from there.

    Raises
    ------
    ProgramError
        VP008: the place lies inside the circle.
    """
    dx, dy = position[0] - center[0], position[1] - center[1]
    distance = math.hypot(dx, dy)
    if distance < radius:
        what = "the end point of the departure lies" if leaving else "the tool is"
        way = "from" if leaving else "to"
        raise ProgramError("VP008", f"{what} inside the arc of radius {radius:.6g} mm; no tangent leads {way} it there")
    angle = math.atan2(dy, dx) + (-1 if leaving else 1) * sense * math.acos(min(radius / distance, 1.0))
    return center[0] + radius * math.cos(angle), center[1] + radius * math.sin(angle)


def _measure_sweep(start: Point, end: Point, center: Point, sense: float) -> float:
    """Signed sweep in degrees between two points of a circle; 0 where they are one."""
    return 0.0 if math.dist(start, end) < ZERO_LENGTH_MM else measure_sweep(start, end, center, sense)
