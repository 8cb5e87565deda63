"""Milling cycles of Klartext: 232, 233, 251 to 254, 256 and 257, from their Q parameters to strokes, and the moves of these."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.klartext.contour import KlartextContour
from verne_post.gcode.klartext.cycle_words import FMAX_VALUE
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.machining.elements import Point, make_arc
from verne_post.gcode.machining.outlines import Circle, CurvedSlot, Rectangle, measure_reach
from verne_post.gcode.machining.pockets import (
    MAX_STROKES,
    Entry,
    Face,
    Milling,
    MillingError,
    list_levels,
    mill_face,
    mill_pocket,
    mill_stud,
    spread_levels,
)
from verne_post.gcode.machining.strokes import Placement, Stroke, list_stops, place_strokes, turn_about
from verne_post.gcode.program_error import At, ProgramError
from verne_post.model.control_keys import HeidenhainKeys, read_keys
from verne_post.model.moves import FeedMode, MoveKind

_Q = dict[int, float]
_FULL_TURN: Final = 360.0
#: Largest path overlap factor Q370: paths are less than a diameter of the tool apart.
_MOST_OVERLAP: Final = 1.9999
#: Q366: how the tool plunges.
_ENTRIES: Final[Mapping[float, Entry]] = {0.0: "straight", 1.0: "helix", 2.0: "swing"}
#: Where the tool stands on call: in halves of the sides from the middle, by Q367.
_CORNERS: Final = {0.0: (0.0, 0.0), 1.0: (1.0, 1.0), 2.0: (-1.0, 1.0), 3.0: (-1.0, -1.0), 4.0: (1.0, -1.0)}
#: Cycles that give the height of the surface as Q227.
FACES: Final = (232, 233)


class KlartextMilling:
    """Executes milling cycles where the tool stands."""

    def __init__(self, frames: KlartextFrames, contour: KlartextContour) -> None:
        self.frames, self.contour, self.core, self.state = frames, contour, frames.core, frames.state
        self.keys = read_keys(HeidenhainKeys, frames.setup.control.get("heidenhain", {}))
        self._block, self._count = At(0), 0

    def run(self, number: int, q: _Q) -> None:
        """Execute a cycle, and lift the tool to the second set-up clearance over the place where it began.

        Raises
        ------
        ProgramError
            Before the first move.
        """
        self._check_values(number, q)
        start, clear = (self.state.position[0], self.state.position[1]), self._find_height(q[203] + q[200])
        second = max(self._find_height(q[203] + q[204]), clear)
        try:
            pockets = [list(strokes) for strokes in CYCLES[number](self, q)] if q.get(201) != 0 else []
        except MillingError as error:
            raise ProgramError("VP007", f"cycle {number}: {error}") from None
        self._count_strokes(number, sum(map(len, pockets)))
        feeds = {"plunge": q[253] if number in FACES else q[206], "mill": q[207], "finish": q.get(385, q[207])}
        if any(
            stroke.center is not None and feeds[stroke.pace] >= FMAX_VALUE for strokes in pockets for stroke in strokes
        ):
            raise ProgramError("VP009", f"cycle {number}: the tool plunges on arcs at Q206; it is not FMAX")
        self._follow_stroke(Stroke(start, max(self.state.position[2], clear), "rapid"), feeds)
        for strokes in pockets:
            for stroke in strokes:
                self._follow_stroke(stroke, feeds)
            self._follow_stroke(Stroke((self.state.position[0], self.state.position[1]), second, "rapid"), feeds)
        self._follow_stroke(Stroke(start, second, "rapid"), feeds)

    def _count_strokes(self, number: int, count: int) -> None:
        if self._block is not self.frames.block:
            self._block, self._count = self.frames.block, 0
        self._count += count
        if self._count > MAX_STROKES:
            raise ProgramError("VP007", f"cycle {number}: the calls of this block have more than {MAX_STROKES} strokes")

    # --- parameters ---------------------------------------------------------------------------------------

    def _check_values(self, number: int, q: _Q) -> None:
        def refuse(name: int, why: str, code: str = "VP007") -> None:
            raise ProgramError(code, f"cycle {number}: Q{name}={q[name]:g}: {why}")

        for name in (215, 366, 367, 439):
            if q.get(name, 0.0) not in (
                (0.0, 1.0, 2.0, 3.0, 4.0) if name == 367 else (0.0, 1.0, 2.0, 3.0) if name == 439 else (0.0, 1.0, 2.0)
            ):
                refuse(name, "no such choice")
        if q.get(351, 1.0) not in (0.0, 1.0, -1.0):
            refuse(351, "1 for climb milling, -1 for up-cut")
        if q.get(439, 0.0) not in (0.0, 3.0):
            refuse(439, "F is always the speed of the tool's centre here; write Q439=0", "VP002")
        for name in (207, 385, 206, 253):
            if not 0 < q.get(name, 1.0) <= FMAX_VALUE or (q.get(name) == FMAX_VALUE and name in (207, 385)):
                refuse(name, "a feed rate greater than 0 is needed, and not FMAX where the tool cuts", "VP009")
        for name in (202, 370):
            if q.get(name, 1.0) <= 0:
                refuse(name, "an infeed is greater than 0")
        for name in (200, 204, 338, 357, 368, 369, 220):
            if q.get(name, 0.0) < 0:
                refuse(name, "it is not negative")
        if q.get(370, 1.0) > _MOST_OVERLAP:
            refuse(370, f"the overlap of paths is at most {_MOST_OVERLAP}")
        for name in (218, 219, 222, 223, 375, 424, 425):
            if number not in FACES and q.get(name, 1.0) <= 0:
                refuse(name, "a length is greater than 0")
        for name in (347, 348, 349, 437) + ((220, 338, 367, 368) if number == 233 else ()):
            if q.get(name):
                refuse(name, "only 0 is executed", "VP002")

    def _find_height(self, height: float) -> float:
        """A height of the program as Z of the frame, mm."""
        return height * float(self.frames.factors[2]) * self.frames.length(1.0)

    def _plan(self, q: _Q, *, inside: bool = True, even: bool = False) -> Milling:
        """How the parameters of a cycle mill, heights and lengths in mm of the frame."""
        unit = self.frames.unit
        top, clear = self._find_height(q[203]), self._find_height(q[203] + q[200])
        bottom = self._find_height(q[203] + q[201])
        side, floor = q.get(368, 0.0) * unit, q.get(369, 0.0) * unit
        kind = q.get(215, 0.0)
        if kind == 2.0 and not side and not floor:
            raise ProgramError("VP007", "Q215=2 finishes the allowances Q368 and Q369, and both are 0")
        rough, fine = kind != 2.0, kind != 1.0
        levels: list[float] = []
        if rough and top - bottom - floor > ZERO_LENGTH_MM:
            levels = (spread_levels if even else list_levels)(top, bottom + floor, q[202] * unit)
        climb = -1 if q.get(351) == -1.0 else 1
        sense = climb * (1 if inside else -1) * (-1 if self.state.spindle_reversed else 1)
        radius = self.contour.tool_radius()
        if radius <= 0:
            raise ProgramError("VP012", "milling cycles need the radius of the tool, and it is 0")
        return Milling(
            radius, clear, levels, bottom, radius * q.get(370, 1.0), sense, side,
            walls=list_levels(top, bottom, q.get(338, 0.0) * unit) if fine and side else (), floor=bool(fine and floor),
            entry=_ENTRIES[q.get(366, 0.0)], slope=math.tan(math.radians(self.keys.plunge_angle)), helix=radius, near=q[200] * unit,
        )  # fmt: skip

    # --- cycles -------------------------------------------------------------------------------------------

    def _mill_pocket(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """251: a rectangle."""
        length, width, corner = (q[name] * self.frames.unit for name in (218, 219, 220))
        yield self._place(
            mill_pocket(_check_corner(Rectangle(length, width, corner)), self._plan(q)), q[224], self._find_middle(q)
        )

    def _mill_round_pocket(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """252: a circle."""
        if q[366] == 2.0:
            raise ProgramError("VP007", "cycle 252: Q366=2: it plunges straight (0) or on a helix (1)")
        yield self._place(mill_pocket(Circle(0.5 * q[223] * self.frames.unit), self._plan(q)), 0.0)

    def _mill_slot(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """253: a straight slot."""
        length, width = (q[name] * self.frames.unit for name in (218, 219))
        if length < width:
            raise ProgramError(
                "VP007",
                f"cycle 253: the slot is {q[218]:g} long and {q[219]:g} wide; its length Q218 is no less than its width",
            )
        shift = {
            0.0: 0.0,
            1.0: 0.5 * length,
            2.0: 0.5 * (length - width),
            3.0: 0.5 * (width - length),
            4.0: -0.5 * length,
        }[q[367]]
        yield self._place(mill_pocket(Rectangle(length, width, 0.5 * width), self._plan_slot(q)), q[374], (shift, 0.0))

    def _plan_slot(self, q: _Q) -> Milling:
        """A slot has room to and fro alone, and is roughed up to two diameters of the tool wide."""
        plan = self._plan({**q, 366: 2.0 if q[366] else 0.0})
        if plan.levels and q[219] * self.frames.unit > 4.0 * plan.radius + ZERO_LENGTH_MM:
            raise MillingError(
                f"Q219={q[219]:g}: a slot is roughed up to two diameters of the tool wide; write cycle 251"
            )
        return plan

    def _mill_curved_slots(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """254: slots along a circle, one after the other."""
        if q[367]:
            raise ProgramError(
                "VP002", f"cycle 254: Q367={q[367]:g} is not executed; give the centre with Q216 and Q217, and Q367=0"
            )
        count, radius, width = q[377], 0.5 * q[375] * self.frames.unit, q[219] * self.frames.unit
        if count != round(count) or not 1 <= count <= MAX_STROKES:
            raise ProgramError("VP007", f"cycle 254: Q377={count:g}: a number of slots is whole, and at least 1")
        if width >= 2 * radius:
            raise ProgramError("VP007", f"cycle 254: the slot is {q[219]:g} wide on a circle of diameter {q[375]:g}")
        if (
            not 0 < q[248] < _FULL_TURN
            or 2 * radius * math.sin(math.radians(min(_FULL_TURN - q[248], 180.0)) / 2) <= width
        ):
            raise ProgramError(
                "VP007", f"cycle 254: Q248={q[248]:g}: the ends of the slot meet; write cycle 252 and 257 for a ring"
            )
        x, y, _z = self.frames.place([q[216], q[217], 0.0])  # type: ignore[arg-type]
        for number in range(round(count)):
            slot = CurvedSlot(radius, q[376] + number * q[378], q[248], width)
            yield self._place(mill_pocket(slot, self._plan_slot(q)), 0.0, origin=(x, y))

    def _mill_stud(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """256: a rectangle; the tool comes from the right, which is below where the sides are exchanged."""
        stud, blank = (
            Rectangle(q[v] * self.frames.unit, q[u] * self.frames.unit, 0.0) for u, v in ((218, 219), (424, 425))
        )
        stud = _check_corner(Rectangle(stud.length, stud.width, q[220] * self.frames.unit))
        if blank.length < stud.length or blank.width < stud.width:
            raise ProgramError("VP007", "cycle 256: the blank, Q424 and Q425, is smaller than the stud, Q218 and Q219")
        strokes = mill_stud(stud, self._plan(q, inside=False), measure_reach(stud, blank), 0.5 * blank.width)
        u, v = self._find_middle(q)
        yield self._place(strokes, q[224] + 90.0, (v, -u))

    def _mill_round_stud(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """257: a circle; the tool comes from the angle Q376."""
        radius, blank = (0.5 * q[name] * self.frames.unit for name in (223, 222))
        if blank < radius:
            raise ProgramError("VP007", "cycle 257: the blank, Q222, is smaller than the stud, Q223")
        angle = 0.0 if q[376] == -1.0 else q[376]
        yield self._place(mill_stud(Circle(radius), self._plan(q, inside=False), blank - radius, blank), angle + 90.0)

    def _mill_face(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """232 and 233: strokes over a face from one of its corners."""
        if q[389] not in (0.0, 2.0):
            raise ProgramError(
                "VP002", f"Q389={q[389]:g} is not executed: strokes go beyond the edges, to and fro (0) or one way (2)"
            )
        if q.get(350, 1.0) not in (1.0, 2.0):
            raise ProgramError("VP007", f"Q350={q[350]:g}: strokes go along the axis 1 or 2")
        plan = self._plan({**q, 201: q[386] - q[227], 206: q[253]}, even=True)
        corner = (self.state.position[0], self.state.position[1])
        if 225 in q:
            x, y, _z = self.frames.place([q[225], q[226], 0.0])  # type: ignore[arg-type]
            corner = (x, y)
        if q[386] > q[227]:
            raise ProgramError("VP007", f"Q386={q[386]:g} lies above the surface Q227={q[227]:g}")
        length, width = q[218] * self.frames.unit, q[219] * self.frames.unit
        if not length or not width:
            raise ProgramError("VP007", "Q218 and Q219, the sides of the face, must not be 0")
        signs = math.copysign(1.0, length), math.copysign(1.0, width)
        first, second = (signs[0], 0.0), (0.0, signs[1])
        if q.get(350, 1.0) == 2.0:
            length, width, first, second = width, length, second, first
        face = Face(abs(length), abs(width), plan.radius + q[357] * self.frames.unit, zigzag=q[389] == 0.0)
        yield self._put_in_frame(mill_face(face, plan), Placement(corner, first, second))

    # --- places -------------------------------------------------------------------------------------------

    def _find_middle(self, q: _Q) -> Point:
        """The middle of a rectangle from where the tool stands, in its own directions, mm (Q367)."""
        u, v = _CORNERS[q[367]]
        return 0.5 * u * q[218] * self.frames.unit, 0.5 * v * q[219] * self.frames.unit

    def _place(
        self, strokes: Iterable[Stroke], angle: float, middle: Point = (0.0, 0.0), origin: Point | None = None
    ) -> Iterator[Stroke]:
        """Strokes turned by an angle about where the tool stands, or about ``origin`` (mm)."""
        here = (self.state.position[0], self.state.position[1]) if origin is None else origin
        return self._put_in_frame(strokes, turn_about(here, angle, middle))

    def _put_in_frame(self, strokes: Iterable[Stroke], placement: Placement) -> Iterator[Stroke]:
        """Strokes in the frame, where mirror images hold."""
        signs = [math.copysign(1.0, float(factor)) for factor in self.frames.factors]
        (x, y), along, across = placement.origin, placement.along, placement.across
        placed = Placement(
            (x, y), (signs[0] * along[0], signs[1] * along[1]), (signs[0] * across[0], signs[1] * across[1])
        )
        return place_strokes(strokes, placed)

    # --- moves --------------------------------------------------------------------------------------------

    def _follow_stroke(self, stroke: Stroke, feeds: Mapping[str, float]) -> None:
        feed, start = feeds.get(stroke.pace), list(self.state.position)
        if stroke.center is None:
            is_rapid = feed is None or feed >= FMAX_VALUE
            for point, height in list_stops((start[0], start[1]), start[2], stroke):
                self._go_straight([*point, height, *start[3:]], None if is_rapid else feed)
            return
        self._set_feed(feed or 0.0)
        sweep = -stroke.sweep if self.frames.flips else stroke.sweep
        end = [*stroke.end, stroke.height, *start[3:]]
        self.core.arc(self.frames.block, start, end, make_arc(start, 0, stroke.center, sweep), [0, 1, 2])

    def _set_feed(self, feed: float) -> None:
        self.core.set_feed(self.contour.read_feed_word(feed))
        self.contour.change_feed_mode(FeedMode.PER_MINUTE)
        self.contour.check_feed()

    def _go_straight(self, end: list[float], feed: float | None) -> None:
        """Straight to a place (9) of the frame; without a feed rate in rapid traverse."""
        kind = MoveKind.RAPID if feed is None else MoveKind.FEED
        if feed is not None:
            self._set_feed(feed)
        self.core.start_of_motion(kind, absolute=True, machine=False)
        self.frames.run_line(self.frames.block, kind, end, [0, 1, 2])


def _check_corner(shape: Rectangle) -> Rectangle:
    if shape.corner > shape.inradius + ZERO_LENGTH_MM:
        raise MillingError(f"the corner radius {shape.corner:g} mm is more than half a side")
    return shape


#: Strokes of each milling cycle, one iterator for each of its pockets.
CYCLES: Final[Mapping[int, Callable[[KlartextMilling, _Q], Iterator[Iterator[Stroke]]]]] = {
    232: KlartextMilling._mill_face, 233: KlartextMilling._mill_face, 251: KlartextMilling._mill_pocket, 252: KlartextMilling._mill_round_pocket,
    253: KlartextMilling._mill_slot, 254: KlartextMilling._mill_curved_slots, 256: KlartextMilling._mill_stud, 257: KlartextMilling._mill_round_stud,
}  # fmt: skip
