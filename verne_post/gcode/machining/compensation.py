"""Cutter compensation, G41 and G42: programmed contour -> path of the tool's centre, in one plane.

The centre runs beside the contour at the tool's radius. Round an outside corner it goes on an arc about
the corner; in an inside corner the two offset path segments end where they meet. So a segment is settled only when
the next one is known: it is recorded at once and its end amended, so that everything keeps its order.
"""

import math
from collections.abc import Mapping
from typing import Final, Self, TypeAlias

from msgspec import Struct, field

from verne_post.base.tolerances import CORNER_ANGLE, CORNER_REACH_MM
from verne_post.gcode.arcs import PLANES, Arc
from verne_post.gcode.codes import spell_g_code
from verne_post.gcode.lengths import measure_helix
from verne_post.gcode.machining.plane_geometry import (
    Point,
    find_tangent,
    is_sense_doubtful,
    measure_turn,
    meet_line_and_circle,
    meet_two_circles,
    step_left,
    turn_left,
)
from verne_post.gcode.program_error import ProgramError, write_before, write_words
from verne_post.gcode.recorder import Recorder
from verne_post.model.findings import Remedy
from verne_post.model.part_setup import describe_tool_number

_FULL: Final = 2 * math.pi
#: An entry arc that bends towards its centre by less than this share of its chord is none: LinuxCNC has the same bound.
_LEAST_BEND: Final = 1e-4
#: The words of either side.
_SIDES: Final = {
    "G41": "G42",
    "G42": "G41",
    "RL": "RR",
    "RR": "RL",
    "G41.1": "G42.1",
    "G42.1": "G41.1",
}
_LEFT: Final = ("G41", "RL", "RL 41")
#: The sine of the angle to the contour above which an entry move comes from one side of it.
_FROM_SIDE: Final = 0.1
#: An arc as it is programmed: start, end, centre and sense.
_Sense: TypeAlias = tuple[Point, Point, Point, int]


class Offset(Struct, frozen=True):
    """One offset path segment: ``start`` and ``end`` of the centre's path, and the direction in which it ends.

    ``center`` is None for a straight one; an arc turns by ``sweep`` (rad) about it, counter-clockwise for ``sense`` +1.
    """

    start: Point
    end: Point
    direction: Point
    entry: bool = False
    center: Point | None = None
    sense: int = 0
    sweep: float = 0.0


class Compensation(Struct):
    """Compensation in force."""

    code: int  #: 410, 411, 420 or 421.
    plane: int
    radius: float  #: mm, positive to the left of the contour; 0: on it.
    start_line: int  #: The line that has put it in force, counted in its own file.
    word: str = ""  #: What that line says, as RL; empty where the code says it.
    end_word: str = "G40"  #: What would end it.
    offset: int = 0  #: D that gives the radius; 0 without one.
    segment: Offset | None = None  #: The path segment whose end may still be amended; None before the entry move.
    rows: list[int] = field(default_factory=list)  #: Rows of the recorder that end where it ends.
    corner: list[float] = field(default_factory=list)  #: End of the segment as programmed, nine axes.
    before: list[float] = field(default_factory=list)  #: ... and its start; empty where that is not known.
    line: int = 0  #: Source line of the segment.
    plane_line: int = 0  #: Source line of the last move in the plane after the first one.
    tool: str = "the tool"  #: As messages name it.
    #: The entry move ends beside the start of the first segment of the contour, however long it is; else beside
    #: its own end.
    perpendicular: bool = False
    #: Such a compensation begins with its first block, even without motion in the plane; else with its first
    #: motion.
    at_once: bool = True
    has_cut: bool = False  #: A move at feed rate has followed the contour.
    rapid_line: int = 0  #: Source line of the first rapid in the plane after that: the contour may have ended there.
    is_assumed: bool = False  #: The tool has no diameter, which has been reported, and ``radius`` is any.
    enters_on_side: bool = False  #: The entry move comes from the side of the contour on which the centre runs.

    def take_tool(self, number: int | None, names: Mapping[int, str]) -> Self:
        """The same with the tool in the spindle, for messages."""
        self.tool = describe_tool_number(number, names) if number else "the tool"
        return self

    # --- the three things that may come ---------------------------------------------------------

    def follow_line(self, recorder: Recorder, start: list[float], end: list[float], feed: float) -> list[float]:
        """A straight move between programmed points; returns the centre's end. ``feed``: of an arc about a corner."""
        u, v, *_ = PLANES[self.plane]
        p, q = (start[u], start[v]), (end[u], end[v])
        length = math.dist(p, q)
        if length == 0.0:
            if self.segment is None and self.perpendicular and self.at_once:
                self._begin(Offset(p, p, (1.0, 0.0), entry=True))
            return self._find_point(end, self.segment.end if self.segment else p)
        t = ((q[0] - p[0]) / length, (q[1] - p[1]) / length)
        target = step_left(q, t, self.radius)
        if self.segment is None:
            self._check_entry(length)
            self._begin(Offset(p, target, t, entry=True))
            return self._find_point(end, target)
        start_uv = self._join(recorder, feed, p, t)
        if (target[0] - start_uv[0]) * t[0] + (target[1] - start_uv[1]) * t[1] < -CORNER_REACH_MM:
            raise self._report_gouge(t)
        self._begin(Offset(start_uv, target, t))
        return self._find_point(end, target)

    def follow_arc(
        self, recorder: Recorder, start: list[float], end: list[float], arc: Arc, feed: float
    ) -> tuple[list[float], Arc]:
        """An arc between programmed points; returns where the centre ends and its arc."""
        u, v, *_ = PLANES[self.plane]
        if self.segment is None and self.perpendicular:
            raise ProgramError("VP026", "the entry move of the cutter compensation must be straight, not an arc")
        p, q, c = (start[u], start[v]), (end[u], end[v]), (arc.center[u], arc.center[v])
        sense = 1 if arc.sweep > 0 else -1
        radius = math.dist(p, c) - sense * self.radius
        if radius <= 0:
            text = f"{self._name_tool()} is too wide for this arc, whose radius is {math.dist(p, c):.6g} mm"
            raise self._name_alternative(text, None, (p, q, c, sense))
        if self.segment is None:
            entry = self._enter_on_arc(p, q, c, sense, abs(arc.turns))
            center = list(arc.center)
            assert entry.center is not None
            center[u], center[v] = entry.center
            self._begin(entry)
            sweep = math.degrees(sense * entry.sweep)
            return self._find_point(end, entry.end), Arc(arc.plane, (center[0], center[1], center[2]), arc.turns, sweep)
        first, last = find_tangent(p, c, sense), find_tangent(q, c, sense)
        start_uv = self._join(recorder, feed, p, first, (p, q, c, sense), radius)
        target = step_left(q, last, self.radius)
        programmed_sweep, sweep = abs(math.radians(arc.sweep)), measure_turn(start_uv, target, c, sense)
        sweep += _FULL * round((programmed_sweep - sweep) / _FULL)
        if abs(programmed_sweep - sweep) > math.pi / 2 or sweep * radius < -CORNER_REACH_MM:
            raise self._report_gouge(None, (p, q, c, sense))
        self._begin(Offset(start_uv, target, last, center=c, sense=sense, sweep=sweep))
        return self._find_point(end, target), Arc(arc.plane, arc.center, arc.turns, math.degrees(sense * sweep))

    def compare_arc_lengths(self, start: list[float], end: list[float], arc: Arc) -> float:
        """Length of the centre's arc over that of the programmed one, as helices; arcs about corners do not count."""
        u, v, normal, *_ = PLANES[self.plane]
        radius, height = math.dist((start[u], start[v]), (arc.center[u], arc.center[v])), end[normal] - start[normal]
        centre = radius - (self.radius if arc.sweep > 0 else -self.radius)
        return measure_helix(centre, arc.sweep, height) / measure_helix(radius, arc.sweep, height)

    def _enter_on_arc(self, p: Point, q: Point, c: Point, sense: int, turns: int) -> Offset:
        """An arc as entry move: it ends beside the end of the programmed arc, in the same direction as that."""
        self._check_entry(math.dist(p, q))
        last = find_tangent(q, c, sense)
        target, normal = step_left(q, last, self.radius), turn_left(last)
        inwards = sense * normal[0], sense * normal[1]  # from the end of the arc towards its centre
        du, dv = p[0] - target[0], p[1] - target[1]
        length, depth = math.hypot(du, dv), du * inwards[0] + dv * inwards[1]
        if depth <= _LEAST_BEND * length:
            raise ProgramError(
                "VP026",
                f"the entry arc of the cutter compensation is too short for {self._name_tool()}: no arc leads to its "
                "end in its direction",
            )
        radius = length * length / (2.0 * depth)
        center = target[0] + radius * inwards[0], target[1] + radius * inwards[1]
        sweep = measure_turn(p, target, center, sense) + _FULL * (turns - 1)
        return Offset(p, target, last, entry=True, center=center, sense=sense, sweep=sweep)

    def _check_entry(self, length: float) -> None:
        if length <= abs(self.radius) and not self.perpendicular:
            raise ProgramError(
                "VP026",
                f"the entry move of the cutter compensation is {length:.6g} mm long; it must be longer than the "
                f"radius, {abs(self.radius):.6g} mm, of {self._name_tool()}",
            )

    def enter_beside(self, corner: Point, row: int, centre: list[float], line: int) -> None:
        """The centre stands beside the first point of the contour already, at the end of the recorder's ``row``."""
        u, v, *_ = PLANES[self.plane]
        place = (centre[u], centre[v])
        self._begin(Offset(place, place, (1.0, 0.0), entry=True))
        self.perpendicular = True
        point = list(centre)
        point[u], point[v] = corner
        self.settle(row, line, point)

    def settle(self, row: int, line: int, corner: list[float], *, is_rapid: bool = False) -> None:
        """Note the row in which the last move was recorded."""
        if not is_rapid:
            self.has_cut = True
        elif self.has_cut and not self.rapid_line:
            self.rapid_line = line
        self.rows.append(row)
        u, v, *_ = PLANES[self.plane]
        if self.corner and (corner[u], corner[v]) != (self.corner[u], self.corner[v]):
            self.plane_line = line
        self.before, self.corner, self.line = self.corner, corner, line

    # --- corners ----------------------------------------------------------------------------------

    def _join(
        self,
        recorder: Recorder,
        feed: float,
        corner: Point,
        t2: Point,
        arc: _Sense | None = None,
        radius: float = 0.0,
    ) -> Point:
        """Settle the corner between the last segment and one that leaves in direction t2; returns where that starts."""
        segment = self.segment
        assert segment is not None
        if segment.entry and segment.start != segment.end:
            way = segment.start[0] - corner[0], segment.start[1] - corner[1]
            sine = (t2[0] * way[1] - t2[1] * way[0]) / max(math.hypot(*way), CORNER_REACH_MM)
            self.enters_on_side = math.copysign(sine, sine * self.radius) > _FROM_SIDE
        if segment.entry and self.perpendicular:
            target = step_left(corner, t2, self.radius)
            self._end_at(recorder, target)
            return target
        t1 = segment.direction
        cross, dot = t1[0] * t2[1] - t1[1] * t2[0], t1[0] * t2[0] + t1[1] * t2[1]
        turn = math.atan2(cross, dot)
        target = step_left(corner, t2, self.radius)
        if abs(turn) <= CORNER_ANGLE or self.radius == 0.0:
            return target
        if turn * self.radius < 0 or abs(turn) >= math.pi - CORNER_ANGLE:
            self._round_corner(recorder, feed, corner, target, turn)
            return target
        meeting = self._meet(segment, corner, t2, arc, radius)
        if meeting is None or not self._shorten(recorder, segment, meeting):
            raise self._report_gouge(t2, arc)
        return meeting

    def _round_corner(self, recorder: Recorder, feed: float, corner: Point, target: Point, turn: float) -> None:
        """An arc about an outside corner."""
        if feed == 0.0:
            raise ProgramError("VP009", "the arc about an outside corner needs a feed rate; give F")
        sense = -1 if self.radius > 0 else 1
        sweep = (sense * turn) % _FULL  # half a turn has either sign
        end = self._find_point(self.corner, target)
        center = self._find_point(self.corner, corner)
        arc = Arc(self.plane, (center[0], center[1], center[2]), sense, math.degrees(sense * sweep))
        recorder.repeat_as_arc(self.rows[-1], self.line, end, feed, arc)

    def _meet(self, segment: Offset, corner: Point, t2: Point, arc: _Sense | None, radius: float) -> Point | None:
        """Where two offset segments meet in an inside corner; None where they do not."""
        center = None if arc is None else arc[2]
        line1 = (segment.end, segment.direction)
        line2 = (step_left(corner, t2, self.radius), t2)
        if segment.center is None and center is None:
            n1, n2 = turn_left(segment.direction), turn_left(t2)
            share = self.radius / (1 + n1[0] * n2[0] + n1[1] * n2[1])
            return corner[0] + share * (n1[0] + n2[0]), corner[1] + share * (n1[1] + n2[1])
        if segment.center is None:
            assert center is not None
            meetings = meet_line_and_circle(line1, center, radius)
        elif center is None:
            meetings = meet_line_and_circle(line2, segment.center, math.dist(segment.center, segment.end))
        else:
            meetings = meet_two_circles(segment.center, math.dist(segment.center, segment.end), center, radius)
        return min(meetings, key=lambda point: math.dist(point, corner)) if meetings else None

    def _shorten(self, recorder: Recorder, segment: Offset, end: Point) -> bool:
        """Let the last segment end earlier; False where it would end before it begins."""
        if segment.center is None:
            along = (end[0] - segment.start[0]) * segment.direction[0] + (
                end[1] - segment.start[1]
            ) * segment.direction[1]
            if not segment.entry and along < -CORNER_REACH_MM:
                return False
            sweep = None
        else:
            taken_sweep = measure_turn(end, segment.end, segment.center, segment.sense)
            taken_sweep -= _FULL if _FULL - taken_sweep < CORNER_ANGLE else 0.0
            if (taken_sweep - segment.sweep) * math.dist(segment.end, segment.center) > CORNER_REACH_MM:
                return False
            sweep = math.degrees(-segment.sense * min(taken_sweep, segment.sweep))
        self._end_at(recorder, end, sweep)
        return True

    def _end_at(self, recorder: Recorder, end: Point, sweep: float | None = None) -> None:
        """Let what has been recorded of the last segment end elsewhere; an arc turns so many degrees more."""
        u, v, *_ = PLANES[self.plane]
        for row in self.rows:
            recorder.amend(row, u, v, end, sweep if row == self.rows[0] else None)

    @property
    def has_side(self) -> bool:
        """Whether a word says the side: a cycle chooses its own."""
        return (self.word or spell_g_code(self.code)) in _SIDES

    def describe(self) -> str:
        """What holds, and since where: G41 of line 6."""
        return f"{self.word or spell_g_code(self.code)} of line {self.start_line}"

    def describe_side(self) -> str:
        """Where the centre runs: 5 mm left of the contour."""
        if not self.radius:
            return "on the contour"
        if self.is_assumed:
            return f"{'left' if self.radius > 0 else 'right'} of the contour, no diameter is known"
        return f"{abs(self.radius):.6g} mm {'left' if self.radius > 0 else 'right'} of the contour"

    def describe_offset(self) -> str:
        """The word, and where the centre runs by the radius of which offset and tool."""
        by = [*([f"D{self.offset}"] if self.offset else []), *([self.tool] if self.tool != "the tool" else [])]
        word = self.word or spell_g_code(self.code)
        return f"{word} (tool centre {self.describe_side()}{': ' if by else ''}{', '.join(by)})"

    def explain_end(self) -> str:
        """What ends it: R0 takes effect in a move in the plane alone, so that a line before would not."""
        if self.end_word == "R0" and self.plane_line:
            return f"write R0 in line {self.plane_line}, the last move in X and Y"
        return f"write {self.end_word} first"

    def list_ends(self) -> tuple[Remedy, ...]:
        """The same as edits."""
        if self.end_word == "R0" and self.plane_line:
            return (Remedy("write R0", " R0", line=self.plane_line, way="here"),)
        return write_before(self.end_word)

    def _name_tool(self) -> str:
        return f"{self.tool} (diameter {2 * abs(self.radius):.6g} mm)"

    def _report_gouge(self, t2: Point | None, arc: _Sense | None = None) -> ProgramError:
        """VP026 in the corner before a segment that leaves in direction ``t2``, or on its arc."""
        text = f"{self._name_tool()} cannot reach into this inside corner without cutting into the contour"
        if self.rapid_line:
            text += (
                f"; {self.describe()} is still in force after the rapid of line {self.rapid_line}: if its contour ends "
                f"before that, write {self.end_word} there"
            )
            return ProgramError("VP026", text)
        return self._name_alternative(text, t2, arc)

    def _name_alternative(self, text: str, t2: Point | None, arc: _Sense | None) -> ProgramError:
        """The error with the other sense of an arc if only that is tangent to its neighbour, else the other side.

        Every inside corner is an outside one of the other side, and every arc has room there; the rest of the contour
        need not: the program is to be tried with it. An entry move that comes from the side of the centre says that
        the side is right: from the other one, it would cross the contour.
        """
        word = self.word or spell_g_code(self.code)
        names = ("DR-", "DR+") if self.end_word == "R0" else ("G2", "G3")
        if self.word and (self.radius > 0) != (word in _LEFT):  # mirrored: the program's arcs turn the other way
            names = names[::-1]
        last = self.segment if self.segment is not None and not self.segment.entry else None
        if arc is not None and last is not None and is_sense_doubtful(arc, arc[0], last.direction):
            wrong, right = names[arc[3] >= 0], names[arc[3] < 0]
            return ProgramError("VP026", f"{text}: is {right} meant?", edits=_write_code(wrong, right))
        if last is not None and last.center is not None and t2 is not None and self.before:
            u, v, *_ = PLANES[self.plane]
            end = (self.corner[u], self.corner[v])
            before = ((self.before[u], self.before[v]), end, last.center, last.sense)
            if is_sense_doubtful(before, end, t2):
                wrong, right = names[last.sense >= 0], names[last.sense < 0]
                edits = _write_code(wrong, right, self.line)
                return ProgramError("VP026", f"{text}: is {right} meant in line {self.line}?", edits=edits)
        other = _SIDES.get(word)
        if other is None or self.enters_on_side:  # None: that of a cycle
            return ProgramError("VP026", text)
        return ProgramError("VP026", text, edits=_write_code(word, other, self.start_line))

    # --- small geometry -----------------------------------------------------------------------------

    def _begin(self, segment: Offset) -> None:
        self.segment = segment
        self.rows = []

    def _find_point(self, point: list[float], uv: Point) -> list[float]:
        u, v, *_ = PLANES[self.plane]
        end = list(point)
        end[u], end[v] = uv
        return end


def _write_code(wrong: str, right: str, line: int = 0) -> tuple[Remedy, ...]:
    """The edit of an error that another code may settle, in a line; 0 is that of the error."""
    if wrong[0] != "G":
        return write_words(wrong, right, line=line, is_choice=True)
    return (Remedy(f"write {right}", right[1:], line=line, word=("G", float(wrong[1:])), is_choice=True),)
