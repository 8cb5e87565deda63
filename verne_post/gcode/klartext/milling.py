"""Milling cycles of Klartext (232, 233, 251 to 254, 256 to 258): from Q parameters to strokes, and their moves."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Final, TypeVar

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.klartext.contour import KlartextContour
from verne_post.gcode.klartext.cycle_words import FMAX_VALUE
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.klartext.vocabulary import Q
from verne_post.gcode.machining.elements import make_arc
from verne_post.gcode.machining.outlines import Circle, CurvedSlot, Polygon, Rectangle, measure_reach
from verne_post.gcode.machining.plane_geometry import Point
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
from verne_post.gcode.program_error import At, ProgramError, write_parameter
from verne_post.model.control_keys import HeidenhainKeys, read_keys
from verne_post.model.findings import Remedy

_Q = dict[int, float]
_Shape = TypeVar("_Shape", Rectangle, Polygon)
_FULL_TURN: Final = 360.0
#: Largest path overlap factor Q370: paths are less than a diameter of the tool apart.
_MOST_OVERLAP: Final = 1.9999
#: Q572 of cycle 258, as the control bounds it.
_MOST_CORNERS: Final = 30
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

        ProgramError: Before the first move.
        """
        self._check_values(number, q)
        start, clear = (
            (self.state.position[0], self.state.position[1]),
            self.frames.find_height(q[Q.SURFACE] + q[Q.CLEARANCE]),
        )
        second = max(self.frames.find_height(q[Q.SURFACE] + q[Q.SECOND_CLEARANCE]), clear)
        try:
            pockets = [list(strokes) for strokes in CYCLES[number](self, q)] if q.get(Q.DEPTH) != 0 else []
        except MillingError as error:
            unknown = self.core.tools.report_stand_in(self.frames.block)
            raise unknown or ProgramError("VP007", f"cycle {number}: {error}") from None
        self._count_strokes(number, sum(map(len, pockets)))
        feeds = {
            "plunge": q[Q.POSITIONING_FEED] if number in FACES else q[Q.PLUNGE_FEED],
            "mill": q[Q.MILLING_FEED],
            "finish": q.get(Q.FINISHING_FEED, q[Q.MILLING_FEED]),
        }
        if any(
            stroke.center is not None and feeds[stroke.pace] >= FMAX_VALUE for strokes in pockets for stroke in strokes
        ):
            raise ProgramError("VP009", f"cycle {number}: the tool plunges on arcs at Q206; it is not FMAX")
        self.follow_stroke(Stroke(start, max(self.state.position[2], clear), "rapid"), feeds)
        for strokes in pockets:
            for stroke in strokes:
                self.follow_stroke(stroke, feeds)
            self.follow_stroke(Stroke((self.state.position[0], self.state.position[1]), second, "rapid"), feeds)
        self.follow_stroke(Stroke(start, second, "rapid"), feeds)

    def _count_strokes(self, number: int, count: int) -> None:
        if self._block is not self.frames.block:
            self._block, self._count = self.frames.block, 0
        self._count += count
        if self._count > MAX_STROKES:
            raise ProgramError("VP007", f"cycle {number}: the calls of this block have more than {MAX_STROKES} strokes")

    # --- parameters ---------------------------------------------------------------------------------------

    def _check_values(self, number: int, q: _Q) -> None:
        def refuse(name: int, why: str, code: str = "VP007", edits: tuple[Remedy, ...] = ()) -> None:
            raise ProgramError(code, f"cycle {number}: Q{name}={q[name]:g}: {why}", edits=edits)

        for name in (Q.OPERATION, Q.PLUNGING, Q.POSITION, Q.FEED_REFERENCE):
            if q.get(name, 0.0) not in (
                (0.0, 1.0, 2.0, 3.0, 4.0)
                if name == Q.POSITION
                else (0.0, 1.0, 2.0, 3.0)
                if name == Q.FEED_REFERENCE
                else (0.0, 1.0, 2.0)
            ):
                refuse(name, "no such choice")
        if q.get(Q.CLIMB, 1.0) not in (0.0, 1.0, -1.0):
            refuse(Q.CLIMB, "1 for climb milling, -1 for up-cut")
        if q.get(Q.FEED_REFERENCE, 0.0) not in (0.0, 3.0):
            edits = write_parameter(Q.FEED_REFERENCE, q[Q.FEED_REFERENCE], 0.0)
            refuse(Q.FEED_REFERENCE, "F is always the speed of the tool's centre here; write Q439=0", "VP002", edits)
        for name in (Q.MILLING_FEED, Q.FINISHING_FEED, Q.PLUNGE_FEED, Q.POSITIONING_FEED):
            if not 0 < q.get(name, 1.0) <= FMAX_VALUE or (
                q.get(name) == FMAX_VALUE and name in (Q.MILLING_FEED, Q.FINISHING_FEED)
            ):
                refuse(name, "a feed rate greater than 0 is needed, and not FMAX where the tool cuts", "VP009")
        if number == 258 and q[Q.CORNER] < 0:
            refuse(
                Q.CORNER,
                "chamfers of corners are not executed; write 0 or a radius, and the chamfers with RL or RR",
                "VP002",
            )
        for name in (Q.INFEED, Q.OVERLAP):
            if q.get(name, 1.0) <= 0:
                refuse(name, "an infeed is greater than 0")
        for name in (
            Q.CLEARANCE,
            Q.SECOND_CLEARANCE,
            Q.FINISHING_INFEED,
            Q.SIDE_CLEARANCE,
            Q.SIDE_ALLOWANCE,
            Q.FLOOR_ALLOWANCE,
            Q.CORNER,
        ):
            if q.get(name, 0.0) < 0:
                refuse(name, "it is not negative")
        if q.get(Q.OVERLAP, 1.0) > _MOST_OVERLAP:
            refuse(Q.OVERLAP, f"the overlap of paths is at most {_MOST_OVERLAP}")
        for name in (
            Q.LENGTH,
            Q.WIDTH,
            Q.BLANK_DIAMETER,
            Q.DIAMETER,
            Q.PITCH_DIAMETER,
            Q.BLANK_LENGTH,
            Q.BLANK_WIDTH,
            Q.REFERENCE_DIAMETER,
        ):
            if number not in FACES and q.get(name, 1.0) <= 0:
                refuse(name, "a length is greater than 0")
        for name in (Q.FIRST_LIMIT, Q.SECOND_LIMIT, Q.THIRD_LIMIT, Q.APPROACH) + (
            (Q.CORNER, Q.FINISHING_INFEED, Q.POSITION, Q.SIDE_ALLOWANCE) if number == 233 else ()
        ):
            if q.get(name):
                refuse(name, "only 0 is executed", "VP002")

    def _plan(self, q: _Q, *, inside: bool = True, even: bool = False) -> Milling:
        """How the parameters of a cycle mill, heights and lengths in mm of the frame."""
        unit = self.frames.unit
        top, clear = self.frames.find_height(q[Q.SURFACE]), self.frames.find_height(q[Q.SURFACE] + q[Q.CLEARANCE])
        bottom = self.frames.find_height(q[Q.SURFACE] + q[Q.DEPTH])
        side, floor = q.get(Q.SIDE_ALLOWANCE, 0.0) * unit, q.get(Q.FLOOR_ALLOWANCE, 0.0) * unit
        kind = q.get(Q.OPERATION, 0.0)
        if kind == 2.0 and not side and not floor:
            raise ProgramError("VP007", "Q215=2 finishes the allowances Q368 and Q369, and both are 0")
        rough, fine = kind != 2.0, kind != 1.0
        levels: list[float] = []
        if rough and top - bottom - floor > ZERO_LENGTH_MM:
            levels = (spread_levels if even else list_levels)(top, bottom + floor, q[Q.INFEED] * unit)
        climb = -1 if q.get(Q.CLIMB) == -1.0 else 1
        sense = climb * (1 if inside else -1) * (-1 if self.state.spindle_reversed else 1)
        radius = self.contour.find_tool_radius()
        return Milling(
            radius,
            clear,
            levels,
            bottom,
            radius * q.get(Q.OVERLAP, 1.0),
            sense,
            side,
            walls=list_levels(top, bottom, q.get(Q.FINISHING_INFEED, 0.0) * unit) if fine and side else (),
            floor=bool(fine and floor),
            entry=_ENTRIES[q.get(Q.PLUNGING, 0.0)],
            slope=math.tan(math.radians(self.keys.plunge_angle)),
            helix=radius,
            near=q[Q.CLEARANCE] * unit,
        )

    # --- cycles -------------------------------------------------------------------------------------------

    def _mill_pocket(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """251: a rectangle."""
        length, width, corner = (q[name] * self.frames.unit for name in (Q.LENGTH, Q.WIDTH, Q.CORNER))
        yield self.place(
            mill_pocket(_check_corner(Rectangle(length, width, corner)), self._plan(q)),
            q[Q.ROTATION],
            self._find_middle(q),
        )

    def _mill_round_pocket(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """252: a circle."""
        if q[Q.PLUNGING] == 2.0:
            raise ProgramError("VP007", "cycle 252: Q366=2: it plunges straight (0) or on a helix (1)")
        yield self.place(mill_pocket(Circle(0.5 * q[Q.DIAMETER] * self.frames.unit), self._plan(q)), 0.0)

    def _mill_slot(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """253: a straight slot."""
        length, width = (q[name] * self.frames.unit for name in (Q.LENGTH, Q.WIDTH))
        if length < width:
            raise ProgramError(
                "VP007",
                f"cycle 253: the slot is {q[Q.LENGTH]:g} long and {q[Q.WIDTH]:g} wide; its length Q218 is no less "
                "than its width",
            )
        shift = {
            0.0: 0.0,
            1.0: 0.5 * length,
            2.0: 0.5 * (length - width),
            3.0: 0.5 * (width - length),
            4.0: -0.5 * length,
        }[q[Q.POSITION]]
        yield self.place(
            mill_pocket(Rectangle(length, width, 0.5 * width), self._plan_slot(q)), q[Q.SLOT_ROTATION], (shift, 0.0)
        )

    def _plan_slot(self, q: _Q) -> Milling:
        """A slot has room to and fro alone, and is roughed up to two diameters of the tool wide."""
        plan = self._plan({**q, Q.PLUNGING: 2.0 if q[Q.PLUNGING] else 0.0})
        if plan.levels and q[Q.WIDTH] * self.frames.unit > 4.0 * plan.radius + ZERO_LENGTH_MM:
            raise MillingError(
                f"Q219={q[Q.WIDTH]:g}: a slot is roughed up to two diameters of the tool wide; write cycle 251"
            )
        return plan

    def _mill_curved_slots(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """254: slots along a circle, one after the other."""
        if q[Q.POSITION]:
            raise ProgramError(
                "VP002",
                f"cycle 254: Q367={q[Q.POSITION]:g} is not executed; give the centre with Q216 and Q217, and Q367=0",
            )
        count, radius, width = q[Q.SLOTS], 0.5 * q[Q.PITCH_DIAMETER] * self.frames.unit, q[Q.WIDTH] * self.frames.unit
        if count != round(count) or not 1 <= count <= MAX_STROKES:
            raise ProgramError("VP007", f"cycle 254: Q377={count:g}: a number of slots is whole, and at least 1")
        if width >= 2 * radius:
            raise ProgramError(
                "VP007", f"cycle 254: the slot is {q[Q.WIDTH]:g} wide on a circle of diameter {q[Q.PITCH_DIAMETER]:g}"
            )
        if (
            not 0 < q[Q.OPENING] < _FULL_TURN
            or 2 * radius * math.sin(math.radians(min(_FULL_TURN - q[Q.OPENING], 180.0)) / 2) <= width
        ):
            raise ProgramError(
                "VP007",
                f"cycle 254: Q248={q[Q.OPENING]:g}: the ends of the slot meet; write cycle 252 and 257 for a ring",
            )
        x, y, _z = self.frames.place([q[Q.CENTER_X], q[Q.CENTER_Y], 0.0])
        for number in range(round(count)):
            slot = CurvedSlot(radius, q[Q.FIRST_ANGLE] + number * q[Q.SLOT_STEP], q[Q.OPENING], width)
            yield self.place(mill_pocket(slot, self._plan_slot(q)), 0.0, origin=(x, y))

    def _mill_stud(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """256: a rectangle; the tool comes from the right, which is below where the sides are exchanged."""
        stud, blank = (
            Rectangle(q[v] * self.frames.unit, q[u] * self.frames.unit, 0.0)
            for u, v in ((Q.LENGTH, Q.WIDTH), (Q.BLANK_LENGTH, Q.BLANK_WIDTH))
        )
        stud = _check_corner(Rectangle(stud.length, stud.width, q[Q.CORNER] * self.frames.unit))
        if blank.length < stud.length or blank.width < stud.width:
            raise ProgramError("VP007", "cycle 256: the blank, Q424 and Q425, is smaller than the stud, Q218 and Q219")
        strokes = mill_stud(stud, self._plan(q, inside=False), measure_reach(stud, blank), 0.5 * blank.width)
        u, v = self._find_middle(q)
        yield self.place(strokes, q[Q.ROTATION] + 90.0, (v, -u))

    def _mill_round_stud(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """257: a circle; the tool comes from the angle Q376."""
        radius, blank = (0.5 * q[name] * self.frames.unit for name in (Q.DIAMETER, Q.BLANK_DIAMETER))
        if blank < radius:
            raise ProgramError("VP007", "cycle 257: the blank, Q222, is smaller than the stud, Q223")
        angle = 0.0 if q[Q.FIRST_ANGLE] == -1.0 else q[Q.FIRST_ANGLE]
        yield self.place(mill_stud(Circle(radius), self._plan(q, inside=False), blank - radius, blank), angle + 90.0)

    def _mill_polygon(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """258: one corner is at the angle Q224; the tool comes from the side before it, counter-clockwise."""
        count = q[Q.CORNERS]
        if count != round(count) or not 3 <= count <= _MOST_CORNERS:
            raise ProgramError(
                "VP007", f"cycle 258: Q572={count:g}: a number of corners is whole, 3 to {_MOST_CORNERS}"
            )
        if q[Q.REFERENCE] not in (0.0, 1.0):
            raise ProgramError(
                "VP007",
                f"cycle 258: Q573={q[Q.REFERENCE]:g}: Q571 is the inscribed circle (0) or the one through the corners "
                "(1)",
            )
        blank, reference, corner = (
            q[name] * self.frames.unit for name in (Q.BLANK_DIAMETER, Q.REFERENCE_DIAMETER, Q.CORNER)
        )
        if blank < reference:
            raise ProgramError("VP007", "cycle 258: the blank, Q222, is smaller than the circle of the stud, Q571")
        inradius = 0.5 * reference * (math.cos(math.pi / count) if q[Q.REFERENCE] else 1.0)
        stud = _check_corner(Polygon(round(count), inradius, corner))
        strokes = mill_stud(stud, self._plan(q, inside=False), 0.5 * blank - inradius, 0.5 * blank)
        yield self.place(strokes, q[Q.ROTATION] + 90.0 - stud.half_step)

    def _mill_face(self, q: _Q) -> Iterator[Iterator[Stroke]]:
        """232 and 233: strokes over a face from one of its corners."""
        if q[Q.STRATEGY] not in (0.0, 2.0):
            raise ProgramError(
                "VP002",
                f"Q389={q[Q.STRATEGY]:g} is not executed: strokes go beyond the edges, to and fro (0) or one way (2)",
            )
        if q.get(Q.AXIS, 1.0) not in (1.0, 2.0):
            raise ProgramError("VP007", f"Q350={q[Q.AXIS]:g}: strokes go along the axis 1 or 2")
        plan = self._plan({**q, Q.DEPTH: q[Q.END_Z] - q[Q.START_Z], Q.PLUNGE_FEED: q[Q.POSITIONING_FEED]}, even=True)
        corner = (self.state.position[0], self.state.position[1])
        if Q.START_X in q:
            x, y, _z = self.frames.place([q[Q.START_X], q[Q.START_Y], 0.0])
            corner = (x, y)
        if q[Q.END_Z] > q[Q.START_Z]:
            raise ProgramError("VP007", f"Q386={q[Q.END_Z]:g} lies above the surface Q227={q[Q.START_Z]:g}")
        length, width = q[Q.LENGTH] * self.frames.unit, q[Q.WIDTH] * self.frames.unit
        if not length or not width:
            raise ProgramError("VP007", "Q218 and Q219, the sides of the face, must not be 0")
        signs = math.copysign(1.0, length), math.copysign(1.0, width)
        first, second = (signs[0], 0.0), (0.0, signs[1])
        if q.get(Q.AXIS, 1.0) == 2.0:
            length, width, first, second = width, length, second, first
        face = Face(
            abs(length), abs(width), plan.radius + q[Q.SIDE_CLEARANCE] * self.frames.unit, zigzag=q[Q.STRATEGY] == 0.0
        )
        yield self._put_in_frame(mill_face(face, plan), Placement(corner, first, second))

    # --- places -------------------------------------------------------------------------------------------

    def _find_middle(self, q: _Q) -> Point:
        """The middle of a rectangle from where the tool stands, in its own directions, mm (Q367)."""
        u, v = _CORNERS[q[Q.POSITION]]
        return 0.5 * u * q[Q.LENGTH] * self.frames.unit, 0.5 * v * q[Q.WIDTH] * self.frames.unit

    def place(
        self, strokes: Iterable[Stroke], angle: float, middle: Point = (0.0, 0.0), origin: Point | None = None
    ) -> Iterator[Stroke]:
        """Strokes turned by an angle about where the tool stands, or about ``origin`` (mm)."""
        here = (self.state.position[0], self.state.position[1]) if origin is None else origin
        return self._put_in_frame(strokes, turn_about(here, angle, middle))

    def _put_in_frame(self, strokes: Iterable[Stroke], placement: Placement) -> Iterator[Stroke]:
        """Strokes in the frame, where mirror images hold."""
        signs = [math.copysign(1.0, factor) for factor in self.frames.factors]
        (x, y), along, across = placement.origin, placement.along, placement.across
        placement_in_frame = Placement(
            (x, y), (signs[0] * along[0], signs[1] * along[1]), (signs[0] * across[0], signs[1] * across[1])
        )
        return place_strokes(strokes, placement_in_frame)

    # --- moves --------------------------------------------------------------------------------------------

    def follow_stroke(self, stroke: Stroke, feeds: Mapping[str, float]) -> None:
        """Execute a stroke at the feed rate of its pace."""
        feed, start = feeds.get(stroke.pace), list(self.state.position)
        if stroke.center is None:
            is_rapid = feed is None or feed >= FMAX_VALUE
            for point, height in list_stops((start[0], start[1]), start[2], stroke):
                self.contour.go_straight([*point, height, *start[3:]], is_rapid, feed)
            return
        self.contour.set_cycle_feed(feed or 0.0)
        sweep = -stroke.sweep if self.frames.flips else stroke.sweep
        end = [*stroke.end, stroke.height, *start[3:]]
        self.core.go_on_arc(self.frames.block, start, end, make_arc(start, 0, stroke.center, sweep), [0, 1, 2])


def _check_corner(shape: _Shape) -> _Shape:
    if shape.corner > shape.inradius + ZERO_LENGTH_MM:
        raise MillingError(
            f"the corner radius {shape.corner:g} mm is more than that of the largest circle inside, {shape.inradius:g} "
            "mm"
        )
    return shape


#: Strokes of each milling cycle, one iterator for each of its pockets.
CYCLES: Final[Mapping[int, Callable[[KlartextMilling, _Q], Iterator[Iterator[Stroke]]]]] = {
    232: KlartextMilling._mill_face,
    233: KlartextMilling._mill_face,
    251: KlartextMilling._mill_pocket,
    252: KlartextMilling._mill_round_pocket,
    253: KlartextMilling._mill_slot,
    254: KlartextMilling._mill_curved_slots,
    256: KlartextMilling._mill_stud,
    257: KlartextMilling._mill_round_stud,
    258: KlartextMilling._mill_polygon,
}
