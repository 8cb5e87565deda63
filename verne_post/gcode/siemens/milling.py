"""Milling cycles of Siemens programs: the strokes of pockets, slots, spigots and faces, and the moves of these."""

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.machining.holes import MAX_HOLES
from verne_post.gcode.machining.outlines import Circle, CurvedSlot, Outline, Polygon, Rectangle, measure_reach
from verne_post.gcode.machining.plane_geometry import Point
from verne_post.gcode.machining.pockets import (
    MAX_STROKES,
    Face,
    Milling,
    MillingError,
    mill_face,
    mill_open_slot,
    mill_pocket,
    mill_stud,
    spread_levels,
)
from verne_post.gcode.machining.strokes import Placement, Stroke, list_stops, place_strokes, turn_about
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.siemens.arguments import OF_EDITOR, read_cycle
from verne_post.gcode.siemens.interpreter import SiemensInterpreter
from verne_post.gcode.siemens.milling_values import PARAMETERS, MillingValues
from verne_post.gcode.siemens.thread_milling import list_thread_strokes
from verne_post.gcode.siemens.variables import Variables
from verne_post.gcode.siemens.words import Call
from verne_post.model.moves import MoveKind

#: Values without effect here: what is milled already (all is milled as solid), the way between slots, the editor's.
_HARMLESS: Final = ("AD", "FFCP", "_UMODE", "FS", "ZFS")
#: Cycles that MCALL may call: at each place, which is their reference point.
MODAL_MILLING: Final = ("POCKET3", "POCKET4", "CYCLE76", "CYCLE77", "CYCLE79", "CYCLE70", "CYCLE899")
_STUDS: Final = ("CYCLE76", "CYCLE77", "CYCLE79")
_FACES: Final = ("CYCLE61", "CYCLE71")
_THREADS: Final = ("CYCLE70", "CYCLE90")
#: More sides are a wrong number.
_MOST_SIDES: Final = 1000
#: Thousands of _GMODE: where PA and PO are, in halves of the sides from the middle.
_CORNERS: Final = ((0.0, 0.0), (0.0, 0.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0))


class SiemensMilling:
    """Executes milling cycles on an interpreter."""

    def __init__(self, interpreter: SiemensInterpreter, variables: Variables) -> None:
        self.to, self.variables = interpreter, variables
        self._strokes_left = MAX_STROKES

    def begin_block(self) -> None:
        """A block begins, whose cycles may have so many strokes together."""
        self._strokes_left = MAX_STROKES

    def run(self, call: Call, line: int, *, is_modal: bool = False) -> None:
        """Execute one cycle; a modal one where the tool stands."""
        given, at, to = read_cycle(call, PARAMETERS[call.name], self.variables), At(line), self.to
        with to.core.keep_feed(), to.state.follow_exactly():
            work = _Work(MillingValues(to, given, at), is_modal=is_modal)
            try:
                strokes = [list(one) for one in work.list_strokes()]
            except MillingError as error:
                unknown = to.core.tools.report_stand_in(At(line, {"D": call.column}))
                raise unknown or ProgramError("VP007", f"{call.name}: {error}", call.column) from None
            given.refuse_rest(_find_harmless(call.name))
            self._strokes_left -= sum(map(len, strokes))
            if self._strokes_left < 0:
                raise ProgramError("VP007", f"{call.name}: more than {MAX_STROKES} strokes in this block", call.column)
            work.execute(strokes)


def _find_harmless(name: str) -> tuple[str, ...]:
    """Values of a cycle that have no effect."""
    if name in _THREADS:
        return OF_EDITOR
    return _HARMLESS if name in (*_STUDS, *_FACES) else (*_HARMLESS, "AP1", "AP2")


class _Work:
    """What one call mills, and its moves."""

    def __init__(self, values: MillingValues, *, is_modal: bool) -> None:
        self.values, self.given, self.at, self.to = values, values.given, values.at, values.to
        self.is_modal = is_modal

    # --- cycles -------------------------------------------------------------------------------------------

    def list_strokes(self) -> Iterator[Iterator[Stroke]]:
        """Strokes of each pocket, in programmed places of the plane."""
        if self.values.name in _FACES:
            yield self._mill_face()
        elif self.values.name in ("SLOT1", "SLOT2", "LONGHOLE"):
            yield from self._mill_slots()
        elif self.values.name in _THREADS:
            yield self._mill_thread()
        elif self.values.name == "CYCLE899":
            yield self._mill_open_slot()
        else:
            yield self._mill_one()

    def _mill_one(self) -> Iterator[Stroke]:
        """A pocket or spigot about its reference point."""
        given, is_stud = self.given, self.values.name in _STUDS
        mode = given.read_whole("_GMODE") if "_GMODE" in given.names else 0
        is_polygon = self.values.name == "CYCLE79"
        round_one = "PRAD" in given.names or is_polygon
        corner = mode // 1000 % 10
        rest = mode // 10_000 * 1000 + mode // 100 % 10 * 100 + mode % 100
        refuse, corners = self.values.refuse_digits, (0, 1) if round_one else range(len(_CORNERS))
        refuse("_GMODE", rest, (0, 100, 1000, 1100), "all is machined, from the point that its thousands name")
        refuse("_GMODE", corner, corners, "the thousands name the middle (1) or a corner (2 to 5)")
        center = self._find_center()
        if is_polygon:
            polygon, angle = self._read_polygon()
            beside = 0.5 * self.values.measure("AP1", positive=True)
            return self._mill_stud(polygon, beside - polygon.inradius, beside, center, angle)
        shape: Outline
        if round_one:
            shape, middle, angle = Circle(self.values.measure("PRAD", positive=True)), (0.0, 0.0), 0.0
        else:
            length, width = self.values.measure("LENG", positive=True), self.values.measure("WID", positive=True)
            shape, angle = Rectangle(length, width, self.values.measure("CRAD")), given.number("STA")
            if shape.corner > shape.inradius + ZERO_LENGTH_MM:
                raise given.error("VP007", f"CRAD {given.number('CRAD'):g}: it is no more than half a side", "CRAD")
            middle = (-0.5 * length * _CORNERS[corner][0], -0.5 * width * _CORNERS[corner][1])
        if not is_stud:
            return self._put(mill_pocket(shape, self.values.plan()), center, angle, middle)
        if isinstance(shape, Circle):
            blank = self.values.measure("AP1", positive=True)
            reach, beside = blank - shape.radius, blank
        else:
            # the tool comes from the side of the first axis, which is below where the sides are exchanged
            whole = Rectangle(self.values.measure("AP2", positive=True), self.values.measure("AP1", positive=True), 0.0)
            shape, middle, angle = (
                Rectangle(shape.width, shape.length, shape.corner),
                (middle[1], -middle[0]),
                angle + 90.0,
            )
            reach, beside = measure_reach(shape, whole), 0.5 * whole.width
            if whole.length < shape.length or whole.width < shape.width:
                reach = -1.0
        return self._mill_stud(shape, reach, beside, center, angle, middle)

    def _mill_stud(
        self, shape: Outline, reach: float, beside: float, center: Point, angle: float, middle: Point = (0.0, 0.0)
    ) -> Iterator[Stroke]:
        """From ``beside`` the middle of the blank, which stands out from the spigot by ``reach``, mm."""
        if reach < 0:
            raise self.given.error("VP007", "the blank, AP1 or AP1 and AP2, is smaller than the spigot", "AP1")
        return self._put(mill_stud(shape, self.values.plan(inside=False), reach, beside), center, angle, middle)

    def _find_center(self) -> Point:
        """The reference point: PA and PO, or under MCALL the place where the tool is."""
        center = self.values.measure("PA"), self.values.measure("PO")
        if not self.is_modal:
            return center
        if any(center):
            raise self.given.error(
                "VP002", "PA and PO beside MCALL are not executed: the cycle is at each place; leave them out", "PA"
            )
        self.to.core.require_known(self.at, list(self.values.plane[:2]), f"MCALL {self.values.name}")
        u, v = (self.to.motion.find_programmed(axis) for axis in self.values.plane[:2])
        return u, v

    def _mill_thread(self) -> Iterator[Stroke]:
        """CYCLE70 and CYCLE90."""
        if "_GMODE" in self.given.names:
            self.values.refuse_digits("_GMODE", self.given.read_whole("_GMODE"), (0, 100), "all is machined")
        return place_strokes(list_thread_strokes(self.values), Placement(self._find_center()))

    def _read_polygon(self) -> tuple[Polygon, float]:
        """CYCLE79: the polygon, and by how many degrees it is turned from one that has a side below its middle."""
        given, sides = self.given, self.given.read_whole("NUM")
        if sides < 4 or sides % 2:
            raise given.error(
                "VP002",
                f"NUM {sides} is not executed: an even number of sides from 4 on; write the sides with G41",
                "NUM",
            )
        if sides > _MOST_SIDES:
            raise given.error("VP007", f"NUM {sides}: a polygon has at most {_MOST_SIDES} sides", "NUM")
        self.values.refuse_digits("VARI", given.read_whole("VARI"), (1, 2), "1 is roughing, 2 finishing")
        meaning = self.to.keys.polygon_angle
        if not meaning:
            raise ProgramError(
                "VP002",
                'CYCLE79 is not executed without [siemens] polygon_angle in the settings file: "side" if STA is the '
                'direction of the middle of a side, "corner" if that of a corner',
                given.call.column,
            )
        shape = Polygon(sides, 0.5 * self.values.measure("SWL", positive=True), self.values.measure("RC"))
        if shape.corner > shape.inradius:
            raise given.error("VP007", f"RC {given.number('RC'):g}: it is no more than half of SWL", "RC")
        return shape, given.number("STA") + 90.0 + (180.0 / sides if meaning == "corner" else 0.0)

    def _mill_open_slot(self) -> Iterator[Stroke]:
        """CYCLE899: vortex milling, and finishing."""
        given, values = self.given, self.values
        kind = given.read_whole("VARI")
        say = "1001 is roughing by vortex milling, 2 (or 1002, 2002) finishing"
        values.refuse_digits("VARI", kind, (1001, 2, 1002, 2002), say)
        values.refuse_digits("_GMODE", given.read_whole("_GMODE"), (0, 100, 1000, 1100), "PA and PO are the middle")
        length, width = values.measure("LENG", positive=True), values.measure("WID", positive=True)
        side, floor, most = values.measure("FAL"), values.measure("FALD"), values.measure("MID")
        levels, walls = list[float](), list[float]()
        if kind == 1001:
            if not given.number("MIDA"):
                raise given.error("VP007", "MIDA, how far a circle is from the one before, is greater than 0", "MIDA")
            if values.top - values.bottom - floor > ZERO_LENGTH_MM:
                levels = spread_levels(values.top, values.bottom + floor, most)
        else:
            walls = spread_levels(values.top, values.bottom, most)
        plan = Milling(
            values.radius,
            values.clear,
            levels,
            values.bottom,
            values.read_step(),
            values.read_sense(inside=True),
            side,
            walls=walls,
            floor=bool(walls) and floor > 0,
            near=values.clear - values.top,
        )
        return self._put(mill_open_slot(length, width, plan), self._find_center(), given.number("STA"))

    def _mill_slots(self) -> Iterator[Iterator[Stroke]]:
        """Slots on a circle: along its rays, from RAD outwards, or along itself."""
        given, plan = self.given, self.values.plan()
        if given.read_whole("_GMODE"):
            raise given.error(
                "VP002",
                f"_GMODE {given.read_whole('_GMODE')} is not executed: a slot begins at RAD; write _GMODE 0",
                "_GMODE",
            )
        if "SSF" in given.names and given.number("SSF") not in (0.0, self.to.state.spindle_speed):
            raise given.error(
                "VP002", "SSF is not executed: the speed stays; write S and a separate call for finishing", "SSF"
            )
        count, radius, first = given.read_whole("NUM"), self.values.measure("RAD"), given.number("STA1")
        if not 1 <= count <= MAX_HOLES:
            raise given.error("VP007", f"NUM {count}: there are 1 to {MAX_HOLES} slots", "NUM")
        step, center = given.number("INDA") or 360.0 / count, (self.values.measure("PA"), self.values.measure("PO"))
        width = self.values.measure("WID", positive=True) if "WID" in given.names else 2.0 * plan.radius
        for number in range(count):
            angle = first + number * step
            if "AFSL" in given.names:
                sweep = given.number("AFSL")
                if (
                    not 0 < sweep < 360
                    or radius <= 0.5 * width
                    or 2 * radius * math.sin(math.radians(min(360 - sweep, 180)) / 2) <= width
                ):
                    raise given.error("VP007", f"AFSL {sweep:g}: the ends of the slot would meet", "AFSL")
                yield self._put(mill_pocket(CurvedSlot(radius, angle, sweep, width), plan), center, 0.0)
                continue
            length = self.values.measure("LENG", positive=True)
            if length < width - ZERO_LENGTH_MM:
                raise given.error(
                    "VP007",
                    f"LENG {given.number('LENG'):g}: a slot is no shorter than it is wide, {width:g} mm",
                    "LENG",
                )
            slot = Rectangle(max(length, width), width, 0.5 * width)
            yield self._put(mill_pocket(slot, plan), center, angle, (radius + 0.5 * length, 0.0))

    def _mill_face(self) -> Iterator[Stroke]:
        """CYCLE61 and CYCLE71: strokes from the corner PA, PO."""
        given, kind = self.given, self.given.read_whole("VARI")
        if "LIM" in given.names and given.read_whole("LIM"):
            raise given.error(
                "VP002", f"LIM {given.read_whole('LIM')} is not executed: the strokes go beyond all edges", "LIM"
            )
        work = self.values.refuse_digits("VARI", kind % 10, (1, 2), "the last digit is 1 roughing, 2 finishing")
        way = self.values.refuse_digits(
            "VARI",
            kind // 10,
            (1, 2, 3, 4),
            "the tens are 1 and 3 along the first axis, 2 and 4 along the second; 1 and 2 one way, 3 and 4 to and fro",
        )
        length, width, floor = self.values.measure("LENG"), self.values.measure("WID"), self.values.measure("FALD")
        if not length or not width:
            raise given.error("VP007", "LENG and WID, the sides of the face, must not be 0", "LENG")
        most = self.values.measure("MID")
        levels = [self.values.bottom] if work == 2 else spread_levels(self.values.top, self.values.bottom + floor, most)
        beyond = max(
            [
                self.values.clear - self.values.top,
                *(self.values.measure(name) for name in ("FDP", "FDP1") if name in given.names),
            ]
        )
        turned_placement = turn_about(
            (self.values.measure("PA"), self.values.measure("PO")), given.number("STA") if "STA" in given.names else 0.0
        )
        (a, b), (c, d) = turned_placement.along, turned_placement.across
        along, across = (
            (math.copysign(1.0, length) * a, math.copysign(1.0, length) * b),
            (math.copysign(1.0, width) * c, math.copysign(1.0, width) * d),
        )
        if way in (2, 4):
            length, width, along, across = width, length, across, along
        radius = self.values.radius
        self.values.feeds["plunge"] = self.values.feeds["mill"]
        face = Face(abs(length), abs(width), radius + beyond, zigzag=way >= 3)
        plan = Milling(radius, self.values.clear, levels, self.values.bottom, self.values.read_step())
        return place_strokes(mill_face(face, plan), Placement(turned_placement.origin, along, across))

    def _put(
        self, strokes: Iterable[Stroke], center: Point, angle: float, middle: Point = (0.0, 0.0)
    ) -> Iterator[Stroke]:
        """Strokes turned about a place by an angle, and at the end the middle of the pocket at the clearance."""
        placement = turn_about(center, angle, middle)
        yield from place_strokes(strokes, placement)
        if self.values.name not in (*_STUDS, "CYCLE899"):
            yield Stroke(placement.origin, self.values.clear, "rapid")

    def execute(self, pockets: list[list[Stroke]]) -> None:
        """Make the strokes, and go to the retract plane after each pocket."""
        values = self.values
        self.to.core.set_feed(values.feeds["mill"])
        self.to.motion.check_feed(values.name)
        follower = StrokeFollower(self.to, values.plane, values.feeds, self.at)
        follower.begin(pockets[0][0].end, values.retract)
        for strokes in pockets:
            for stroke in (*strokes, Stroke(strokes[-1].end, values.retract, "rapid")):
                follower.follow(stroke)


class StrokeFollower:
    """Makes the moves of strokes.

    Attributes
    ----------
    plane : sequence of int
        First, second and third axis of the strokes.
    feeds : mapping
        Feed rates by the pace of a stroke.
    """

    def __init__(
        self, interpreter: SiemensInterpreter, plane: tuple[int, int, int], feeds: Mapping[str, float], at: At
    ) -> None:
        self.to, self.plane, self.feeds, self.at = interpreter, plane, feeds, at

    def begin(self, place: Point, retract: float) -> None:
        """Go up to the retract plane if the tool is lower; axes that nothing has named stand over the first place."""
        motion, (u, v, w) = self.to.motion, self.plane
        places = zip(self.plane, (*place, retract), strict=True)
        self.to.core.frames.stand_at({axis: motion.convert_to_core(axis, value) for axis, value in places})
        here = motion.find_programmed(u), motion.find_programmed(v)
        self.follow(Stroke(here, max(motion.find_programmed(w), retract), "rapid"))

    def follow(self, stroke: Stroke) -> None:
        """Make the moves of one stroke."""
        motion, (u, v, w) = self.to.motion, self.plane
        here = motion.find_programmed(u), motion.find_programmed(v)
        if stroke.pace != "rapid":
            self.to.core.set_feed(self.feeds[stroke.pace])
        if stroke.center is not None:
            places = {u: stroke.end[0], v: stroke.end[1], w: stroke.height}
            motion.run_arc(
                self.at, stroke.sweep < 0, places, (stroke.center[0] - here[0], stroke.center[1] - here[1]), 0.0, 0
            )
            return
        kind = MoveKind.RAPID if stroke.pace == "rapid" else MoveKind.FEED
        for point, height in list_stops(here, motion.find_programmed(w), stroke):
            motion.run_line(self.at, kind, {u: point[0], v: point[1], w: height})
