"""Milling along a contour in Siemens programs: CYCLE62 names contours, CYCLE72 mills along one of them.

The contour is executed once on a state of its own, as a subprogram or as the lines between two labels. Its lines and
arcs are recorded. The cycle goes beside them level by level, with the cutter compensation of every contour.
"""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Final

from msgspec import Struct

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.calls import CallStack
from verne_post.gcode.machining.compensation import Compensation
from verne_post.gcode.machining.outlines import Leg, Path
from verne_post.gcode.machining.plane_geometry import Point, turn_way
from verne_post.gcode.machining.pockets import MAX_STROKES, MillingError, spread_levels
from verne_post.gcode.machining.strokes import Pace, Stroke, list_stops
from verne_post.gcode.program_error import GIVE_FILE, At, ProgramError
from verne_post.gcode.recorder import Recorder, Row
from verne_post.gcode.siemens.arguments import Arguments, read_cycle
from verne_post.gcode.siemens.calls import Frame, Library
from verne_post.gcode.siemens.executor import Executor
from verne_post.gcode.siemens.milling import StrokeFollower
from verne_post.gcode.siemens.milling_values import MillingValues
from verne_post.gcode.siemens.program import Section, SiemensText
from verne_post.gcode.siemens.words import Call
from verne_post.model.moves import AXES, MoveKind

#: Values of each cycle, in order.
PARAMETERS: Final = {
    "CYCLE62": ("KNAME", "TYPE", "LAB1", "LAB2"),
    "CYCLE72": (
        "KNAME", "RTP", "RFP", "SDIS", "DP", "MID", "FAL", "FALD", "FFP1", "FFD", "VARI", "RL", "AS1", "LP1", "FF3",
        "AS2", "LP2",
        "_UMODE", "FS", "ZFS", "_GMODE", "_DMODE", "_AMODE",
    ),
}  # fmt: skip
#: The chamfer that VARI 5 makes, and what only the editor reads.
_HARMLESS: Final = ("_UMODE", "FS", "ZFS")
#: Labels between which an editor of contours writes them, before their name.
_EDITOR: Final = ("E_LAB_A_", "E_LAB_E_")
#: What a contour may do besides moving, as the recorder shows it.
_EVENTS: Final = ("without effect", "call", "return", "end")
#: Executes a contour from its first line on, on a state whose feed rate is given; returns what it has recorded.
ContourRunner = Callable[[Section, float, Call], tuple[Recorder, Executor]]


class Piece(Struct, frozen=True):
    """A line or arc of a contour in programmed coordinates, mm: source line, feed rate, and turns beyond the first."""

    line: int
    leg: Leg
    feed: float
    turns: int = 0


class ContourMilling:
    """Executes CYCLE62 and CYCLE72."""

    def __init__(
        self, executor: Executor, library: Library, calls: CallStack[SiemensText, Frame], run_contour: ContourRunner
    ) -> None:
        self.executor, self.library, self.calls, self.run_contour = executor, library, calls, run_contour
        self._named_sections: list[Section] = []
        #: A cycle has taken what CYCLE62 has named: the next CYCLE62 begins anew.
        self._is_taken = False

    def run(self, call: Call, line: int) -> None:
        """Execute one of them.

        ProgramError: Before the first move, but for a contour that the tool cannot follow (VP026).
        """
        given = read_cycle(call, PARAMETERS[call.name], self.executor.variables)
        if call.name == "CYCLE62":
            self._name_contour(given)
            return
        section = self._find_contour(given)
        _Work(MillingValues(self.executor.interpreter, given, At(line)), self.is_of_program(section)).mill(
            section, self.run_contour
        )

    def is_of_program(self, section: Section) -> bool:
        """True where lines of the contour are lines of the program itself."""
        return section.text is self.calls.main and self.calls.shown_line is None

    # --- which contour ------------------------------------------------------------------------------------

    def _name_contour(self, given: Arguments) -> None:
        kind, name = given.read_whole("TYPE"), given.read_text("KNAME")
        labels = given.read_text("LAB1"), given.read_text("LAB2")
        if kind not in (0, 1, 2, 3):
            raise given.error(
                "VP002",
                f"TYPE {kind} is not executed: 0 is a subprogram, 1 the name of a contour, 2 labels, 3 labels in a "
                "subprogram",
                "TYPE",
            )
        if kind == 0:
            section = self._find_subprogram(given, name)
        elif kind == 1:
            section = self._find_between(given, self.calls.text, _EDITOR[0] + name, _EDITOR[1] + name)
        else:
            text = self.calls.text if kind == 2 else self._find_subprogram(given, name).text
            section = self._find_between(given, text, *labels)
        if self._is_taken:
            self._named_sections.clear()
            self._is_taken = False
        self._named_sections.append(section)

    def _find_contour(self, given: Arguments) -> Section:
        """The contour of KNAME, or without it that of CYCLE62."""
        name = given.read_text("KNAME").strip()
        if not name:
            self._is_taken = True
            if len(self._named_sections) != 1:
                raise given.error(
                    "VP005",
                    "KNAME, the name of the contour, is needed, or one CYCLE62 before; here are "
                    f"{len(self._named_sections)}",
                    "KNAME",
                )
            return self._named_sections[0]
        if ":" in name:
            first, _colon, last = name.partition(":")
            return self._find_between(given, self.calls.text, first.strip(), last.strip())
        return self._find_subprogram(given, name)

    def _find_subprogram(self, given: Arguments, path: str) -> Section:
        """The subprogram of the last part of a path."""
        name = path.replace("\\", "/").rpartition("/")[2].partition(".")[0].upper().removeprefix("_N_")
        for ending in ("_SPF", "_MPF"):
            name = name.removesuffix(ending)
        if not name:
            raise given.error("VP005", "KNAME, the name of the contour, is needed", "KNAME")
        section = self.library.find(name, self.calls.text)
        if section is None:
            raise given.error(
                "VP023",
                f"the contour {name} is defined neither in the program nor in a file {name}.SPF",
                "KNAME",
            ).advise(GIVE_FILE)
        return section

    def _find_between(self, given: Arguments, text: SiemensText, first: str, last: str) -> Section:
        """The lines from one label to another one, both included."""
        places = []
        for label in (first, last):
            found = text.labels.get(label.upper(), [])
            if len(found) != 1:
                how_often = "twice" if found else "nowhere"
                raise given.error("VP023", f"the label {label.upper()} of the contour occurs {how_often}", "KNAME")
            places.append(found[0])
        if places[1] < places[0]:
            raise given.error("VP023", f"the contour ends with {last.upper()} before it begins", "KNAME")
        return Section(text, f"{first.upper()}:{last.upper()}", places[0], places[1], False, is_whole=False)


class _Work:
    """What one call mills."""

    def __init__(self, values: MillingValues, is_of_program: bool) -> None:
        self.values, self.given, self.at, self.to = values, values.given, values.at, values.to
        self.is_of_program = is_of_program
        self.follower = StrokeFollower(self.to, values.plane, values.feeds, self.at)

    def mill(self, section: Section, run_contour: ContourRunner) -> None:
        """Read all values, then the contour, then make the moves."""
        given, to, values = self.given, self.to, self.values
        if to.state.plane != 0:
            raise given.error("VP017", "it is executed in the XY plane (G17)", "RTP")
        self._read_values()
        given.refuse_rest(_HARMLESS)
        with to.core.keep_feed(), to.state.follow_exactly():
            to.core.set_feed(values.feeds["mill"])
            to.motion.check_feed(values.name)
            self.start, self.pieces = self._read_contour(
                section, *run_contour(section, values.feeds["mill"], given.call)
            )
            if (len(self.pieces) + 8) * len(self.levels) > MAX_STROKES:
                raise given.error("VP007", f"more than {MAX_STROKES} strokes", "MID")
            self._mill_levels()

    def _read_values(self) -> None:
        given, values = self.given, self.values
        kind = given.read_whole("VARI")
        work = values.refuse_digits(
            "VARI", kind % 10, (1, 2), "the last digit is 1 roughing, 2 finishing; chamfers are not executed"
        )
        way = values.refuse_digits("VARI", kind // 10 % 10, (0, 1), "the tens are 0 between levels with G0, 1 with G1")
        self.retraction = values.refuse_digits(
            "VARI",
            kind // 100,
            (0, 1, 2, 3),
            "the hundreds say how far the tool goes up between levels, and no digit comes before them",
        )
        self.side = values.refuse_digits(
            "RL", given.read_whole("RL"), (40, 41, 42), "it is 40, 41 or 42: on the contour, left or right of it"
        )
        mode = given.read_whole("_GMODE")
        values.refuse_digits("_GMODE", mode, (0, 1, 100, 101), "the contour is machined whole")
        self.lead_in = self._read_lead("AS1", "LP1")
        self.lead_out = self.lead_in if not given.is_given("AS2") else self._read_lead("AS2", "LP2")
        given.is_given("LP2")  # says nothing without AS2
        values.feeds["return"] = given.number("FF3") * self.to.modes.feed or values.feeds["mill"]
        if values.feeds["return"] < 0:
            raise given.error("VP009", f"FF3 {given.number('FF3'):g}: a feed rate is not negative", "FF3")
        self.pace: Pace = "return" if way else "rapid"
        allowance, floor = (values.measure(name) if work == 1 else 0.0 for name in ("FAL", "FALD"))
        for name in ("FAL", "FALD"):
            given.is_given(name)  # finishing leaves nothing
        self.offset = 0.0 if self.side == 40 else values.radius + allowance
        if values.top - values.bottom - floor <= ZERO_LENGTH_MM:
            raise given.error("VP007", "FALD, the allowance of the floor, is the whole depth", "FALD")
        try:
            self.levels = spread_levels(values.top, values.bottom + floor, values.measure("MID"))
        except MillingError as error:
            raise given.error("VP007", str(error), "MID") from None

    def _read_lead(self, kind: str, size: str) -> tuple[int, float]:
        """Approach or departure: 1 straight, 2 a quarter circle, 3 a half circle; its length or radius, mm."""
        values, given = self.values, self.given
        shape = given.read_whole(kind)
        values.refuse_digits(kind, shape // 10, (0,), "the tool goes to the contour in the plane: 1, 2 or 3")
        values.refuse_digits(
            kind,
            shape,
            (1,) if self.side == 40 else (1, 2, 3),
            "1 is a straight line; 2 a quarter circle, 3 a half circle, both beside a contour (RL 41 or 42)",
        )
        return shape, values.measure(size, positive=True)

    # --- the contour --------------------------------------------------------------------------------------

    def _read_contour(self, section: Section, recorder: Recorder, executor: Executor) -> tuple[Point, list[Piece]]:
        """The first point, and the lines and arcs from there on, in programmed coordinates."""
        state, motion = self.to.state, self.to.motion
        signs = motion.scale(0), motion.scale(1)
        if executor.has_ended:
            raise self._refuse(section, section.last, "a contour does not end the program")
        strange = next((event for event in recorder.events if event.kind not in _EVENTS), None)
        if strange is not None:
            raise self._refuse(
                section, strange.line, f"a contour has lines and arcs alone, and this is more ({strange.kind})"
            )
        rows = [row for row in recorder.rows if row.kind != MoveKind.RAPID or row is recorder.rows[0]]
        for event in recorder.events:
            if event.kind == "without effect":
                self.to.recorder.record_event(
                    event.line if self.is_of_program else self.at.line, event.kind, **event.data
                )
        if len(rows) != len(recorder.rows) or recorder.count > len(recorder.rows):
            raise self._refuse(
                section, section.last, "a contour has G0 in its first block alone, and no more than 50000 blocks"
            )
        if len(rows) < 2:
            raise self._refuse(section, section.first, "a contour has a first point and at least one line or arc")
        if executor.interpreter.state.frame != state.frame or len(recorder.frames) > 1:
            raise self._refuse(section, section.last, "a contour does not change frames, offsets or tools")
        begin, pieces = rows[0], list[Piece]()
        start = begin.end[0] / signs[0], begin.end[1] / signs[1]
        for before, row in pairwise(rows):
            self._check_row(section, row)
            point = row.end[0] / signs[0], row.end[1] / signs[1]
            arc = None if row.arc < 0 else recorder.arcs[row.arc]
            if arc is None and math.dist(before.end[:2], row.end[:2]) <= ZERO_LENGTH_MM:
                continue
            leg = Leg(point)
            if arc is not None:
                center = arc.center[0] / signs[0], arc.center[1] / signs[1]
                leg = Leg(point, center, arc.sweep * signs[0] * signs[1])
            turns = 0 if arc is None else max(abs(arc.turns) - 1, 0)
            pieces.append(Piece(row.line if self.is_of_program else self.at.line, leg, row.feed, turns))
        if not pieces:
            raise self._refuse(section, section.first, "a contour has a first point and at least one line or arc")
        return start, pieces

    def _check_row(self, section: Section, row: Row) -> None:
        here = self.to.state.position
        away = [axis for axis in range(2, len(AXES)) if abs(row.end[axis] - here[axis]) > ZERO_LENGTH_MM]
        if row.kind not in (MoveKind.FEED, MoveKind.ARC):
            raise self._refuse(section, row.line, "a contour has lines and arcs (G1, G2, G3) after its first block")
        if away:
            raise self._refuse(section, row.line, f"a contour moves in X and Y; {AXES[away[0]]} goes with the cycle")

    def _refuse(self, section: Section, line: int, text: str) -> ProgramError:
        return build_contour_error(ProgramError("VP017", text), section, line, self.given.call, self.is_of_program)

    # --- moves --------------------------------------------------------------------------------------------

    def _mill_levels(self) -> None:
        values, follower = self.values, self.follower
        path = Path(self.start, tuple(piece.leg for piece in self.pieces))
        come, leave = self._place_lead_in(path), self._place_lead_out(path)
        follower.begin(come.start, values.retract)
        top = values.clear
        for number, level in enumerate(self.levels):
            if number:
                before = self.levels[number - 1]
                top = before if self.retraction == 3 else min(before + values.clear - values.top, values.clear)
            self._go(come.start, top)
            follower.follow(Stroke(come.start, level, "plunge"))
            self._follow(come, level)
            self._follow_contour()
            self._follow(leave, level)
            self._go(leave.end, self._find_height(number))
        self._go(leave.end, values.retract)

    def _find_height(self, number: int) -> float:
        """Where the tool goes up after a level."""
        values, level = self.values, self.levels[number]
        near = min(level + values.clear - values.top, values.clear)
        return (values.retract, values.clear, near, level)[self.retraction]

    def _go(self, point: Point, height: float) -> None:
        """Between levels: up, aside, down, as VARI says."""
        here, (u, v, w) = self.to.motion.find_programmed, self.values.plane
        for stop, level in list_stops((here(u), here(v)), here(w), Stroke(point, height, "rapid")):
            self.follower.follow(Stroke(stop, level, self.pace))

    def _follow(self, path: Path, level: float) -> None:
        for leg in path.legs:
            self.follower.follow(Stroke(leg.end, level, "mill", leg.center, leg.sweep))

    def _follow_contour(self) -> None:
        """Along all pieces, beside them where the tool has a side."""
        to, motion, (u, v, _w) = self.to, self.to.motion, self.values.plane
        if self.offset:
            side, is_mirrored = (1 if self.side == 41 else -1), motion.scale(u) * motion.scale(v) < 0
            goes_left = (side > 0) != is_mirrored
            code, radius = (410, self.offset) if goes_left else (420, -self.offset)
            corner = list(to.state.position)
            corner[u], corner[v] = (
                motion.convert_to_core(axis, value) for axis, value in zip((u, v), self.start, strict=True)
            )
            to.core.enter_beside(
                self.at,
                Compensation(code, to.state.plane, radius, self.at.line, f"RL {self.side}", perpendicular=True),
                corner,
            )
        for piece in self.pieces:
            to.core.set_feed(piece.feed)
            places, at = {u: piece.leg.end[0], v: piece.leg.end[1]}, At(piece.line)
            try:
                if piece.leg.center is None:
                    motion.run_line(at, MoveKind.FEED, places)
                else:
                    center = (
                        piece.leg.center[0] - motion.find_programmed(u),
                        piece.leg.center[1] - motion.find_programmed(v),
                    )
                    motion.run_arc(at, piece.leg.sweep < 0, places, center, 0.0, piece.turns)
            except ProgramError as error:
                if error.line is None and self.is_of_program:
                    error.line, error.column = piece.line, None
                raise
        if self.offset:
            to.core.leave_beside()

    # --- to the contour and away --------------------------------------------------------------------------

    def _place_lead_in(self, path: Path) -> Path:
        """From where the tool goes down to beside the first point of the contour."""
        t = _find_direction(path.start, path.legs[0], at_end=False)
        return self._place_lead(path.start, t, self.lead_in, forward=-1.0)

    def _place_lead_out(self, path: Path) -> Path:
        """The same at the end, turned round: from beside the last point away."""
        begin = path.legs[-2].end if len(path.legs) > 1 else path.start
        t = _find_direction(begin, path.legs[-1], at_end=True)
        return self._place_lead(path.end, t, self.lead_out, forward=1.0).turn_round()

    def _place_lead(self, point: Point, t: Point, lead: tuple[int, float], *, forward: float) -> Path:
        """A path that ends beside a point of the contour; ``forward``: 1 begins ahead of it, -1 before it."""
        shape, size = lead
        side = 0.0 if self.side == 40 else 1.0 if self.side == 41 else -1.0
        n = -side * t[1], side * t[0]
        beside = point[0] + self.offset * n[0], point[1] + self.offset * n[1]
        if shape == 1:
            away = forward * (size + (self.values.radius if self.offset else 0.0))
            return Path((beside[0] + away * t[0], beside[1] + away * t[1]), (Leg(beside),))
        center = beside[0] + size * n[0], beside[1] + size * n[1]
        sweep = -forward * side * (90.0 if shape == 2 else 180.0)
        from_center = turn_way((0.0, 0.0), (beside[0] - center[0], beside[1] - center[1]), -sweep)
        return Path((center[0] + from_center[0], center[1] + from_center[1]), (Leg(beside, center, sweep),))


def _find_direction(start: Point, leg: Leg, *, at_end: bool) -> Point:
    """Direction of travel (unit) where a leg from ``start`` begins or ends."""
    if leg.center is None:
        du, dv = leg.end[0] - start[0], leg.end[1] - start[1]
    else:
        at, sign = (leg.end if at_end else start), math.copysign(1.0, leg.sweep)
        du, dv = -sign * (at[1] - leg.center[1]), sign * (at[0] - leg.center[0])
    size = math.hypot(du, dv)
    return du / size, dv / size


def check_first_block(executor: Executor) -> None:
    """Refuse (VP017) a contour whose first motion is an arc, or leaves open where it begins."""
    if executor.interpreter.recorder.rows[0].kind == MoveKind.ARC or not all(executor.interpreter.state.known_axes[:2]):
        raise ProgramError("VP017", "the first block of a contour is straight, and names X and Y in G90")


def build_contour_error(
    error: ProgramError, section: Section, line: int, call: Call, is_of_program: bool
) -> ProgramError:
    """An error in a line of a contour: at that line where it is one of the program, else at the call."""
    if is_of_program:
        return ProgramError(error.code, error.message, error.column, line=error.line or line, edits=error.edits).advise(
            error.advice
        )
    where = section.text.name or f"contour {section.name}"
    return ProgramError(error.code, f"{where}, line {error.line or line}: {error.message}", call.column).advise(
        error.advice
    )
