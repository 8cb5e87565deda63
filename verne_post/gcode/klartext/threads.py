"""Thread milling cycles of Klartext, 262 to 265 and 267: from Q parameters to strokes, and their moves."""

from collections.abc import Iterator
from typing import Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.klartext.cycle_words import FMAX_VALUE
from verne_post.gcode.klartext.milling import KlartextMilling
from verne_post.gcode.klartext.vocabulary import Q
from verne_post.gcode.lengths import measure_helix
from verne_post.gcode.machining.holes import MAX_PECKS
from verne_post.gcode.machining.strokes import Stroke
from verne_post.gcode.machining.threads import MilledThread, list_helices, mill_countersink, mill_thread
from verne_post.gcode.program_error import ProgramError

_Q = dict[int, float]
#: The cycles.
THREADS: Final = (262, 263, 264, 265, 267)
#: A hole is so many pitches deeper than its thread, as manuals of cycles 263 and 264 ask for.
_PITCHES_BELOW: Final = 1.0 / 3.0


class KlartextThreads:
    """Plans and mills a thread where the tool stands."""

    def __init__(self, milling: KlartextMilling) -> None:
        self.milling, self.frames, self.contour, self.state = milling, milling.frames, milling.contour, milling.state

    def plan(self, number: int, q: _Q, holes: int) -> tuple[list[Stroke], dict[str, float]]:
        """Strokes of a cycle in coordinates of the frame, above where the tool stands; feed rates by pace.

        Raises
        ------
        ProgramError
            Before the first move.
        """
        self._check_values(number, q)
        outside = number == 267
        unit, wall, tool = (
            self.frames.unit,
            0.5 * q[Q.HOLE_DIAMETER] * self.frames.unit,
            self.contour.find_tool_radius(),
        )
        radius = wall + tool if outside else wall - tool
        if radius <= ZERO_LENGTH_MM:
            raise ProgramError(
                "VP007", f"cycle {number}: Q335={q[Q.HOLE_DIAMETER]:g}: the tool has no room in the thread"
            )
        pitch = abs(q[Q.PITCH]) * unit
        away = radius + pitch if outside else 0.0
        if number == 265:  # from the surface down, whatever the hand
            sense = -1 if q[Q.PITCH] > 0 else 1
        else:
            sense = round(q[Q.CLIMB]) * (-1 if outside else 1) * (-1 if self.state.spindle_reversed else 1)
        lead = sense * q[Q.PITCH] * unit
        thread = MilledThread(radius, away, lead, sense, goes_deeper=number != 265)
        top, bottom = (self.frames.find_height(q[Q.SURFACE] + depth) for depth in (0.0, q[Q.DEPTH]))
        count = {263: 0.0, 264: 0.0, 265: 1.0}.get(number, q.get(Q.TURNS, 0.0))
        if (top - bottom) * holes > MAX_PECKS * pitch:
            raise ProgramError("VP007", f"cycle {number}: more than {MAX_PECKS} turns in the holes of one block")
        helices = list_helices(top, bottom, lead, None if count == 1 else count * pitch)
        strokes = list(mill_thread(thread, helices)) if q[Q.DEPTH] else []
        front = list(self._mill_front(number, q, thread))
        clear = self.frames.find_height(q[Q.SURFACE] + q[Q.CLEARANCE])
        begin = [Stroke((away, 0.0), clear, "rapid")] if outside else []
        whole = [*begin, *strokes, *front] if q.get(Q.SINKS_AFTER) else [*begin, *front, *strokes]
        return list(self.milling.place(whole, 0.0)), _find_feeds(q, thread, wall)

    def _mill_front(self, number: int, q: _Q, thread: MilledThread) -> Iterator[Stroke]:
        """At the depth Q358 a circle of the tool's middle with the radius Q359, from the place beside the helix."""
        if not q.get(Q.FRONT_DEPTH):
            return
        radius, height = q[Q.FRONT_OFFSET] * self.frames.unit, self.frames.find_height(q[Q.SURFACE] + q[Q.FRONT_DEPTH])
        if radius <= ZERO_LENGTH_MM or abs(radius - thread.away) <= ZERO_LENGTH_MM:
            raise ProgramError(
                "VP007",
                f"cycle {number}: Q359={q[Q.FRONT_OFFSET]:g}: the tool's middle goes round the axis at this distance; "
                "it is greater than 0, and not that of the place where the tool goes down",
            )
        yield Stroke((thread.away, 0.0), height, "sink" if number == 265 and not q[Q.SINKS_AFTER] else "plunge")
        yield from mill_countersink(radius, thread.away, height, thread.sense)

    def _check_values(self, number: int, q: _Q) -> None:
        def refuse(name: int, why: str, code: str = "VP007") -> None:
            raise ProgramError(code, f"cycle {number}: Q{name}={q[name]:g}: {why}")

        if not q[Q.PITCH]:
            refuse(Q.PITCH, "a pitch is not 0; below 0 it is left-hand")
        if q.get(Q.CLIMB, 1.0) not in (1.0, -1.0):
            refuse(Q.CLIMB, "1 for climb milling, -1 for up-cut")
        if not (count := q.get(Q.TURNS, 0.0)) >= 0 or count != round(count):
            refuse(Q.TURNS, "the threads a step are whole, and not below 0")
        for name in (Q.MILLING_FEED, Q.APPROACH_FEED, Q.BORE_FEED):
            value = q.get(name, 1.0) or (q[Q.MILLING_FEED] if name == Q.APPROACH_FEED else 0.0)
            if not 0 < value < FMAX_VALUE and (name != Q.BORE_FEED or q[Q.FRONT_DEPTH]):
                refuse(name, "the tool cuts at this feed rate; it is greater than 0, and not FMAX", "VP009")
        for name in (Q.SINKING_DEPTH, Q.FRONT_DEPTH):
            if q.get(name, 0.0) > 0:
                refuse(name, "a depth is negative, below Q203")
        if number == 263 and q[Q.SINKING_DEPTH]:
            refuse(
                Q.SINKING_DEPTH,
                "countersinking with the flank is not executed: no manual gives the radius of its circle; write "
                "Q356=0, and Q358 and Q359 for the front",
                "VP002",
            )
        if number == 264:
            if q[Q.FRONT_DEPTH]:
                refuse(
                    Q.FRONT_DEPTH,
                    "countersinking is not executed: the cycle has no feed rate for it; write Q358=0, and cycle 263 "
                    "with Q201=0 for the front",
                    "VP002",
                )
            if q[Q.DEPTH] - q[Q.SINKING_DEPTH] < _PITCHES_BELOW * abs(q[Q.PITCH]) - ZERO_LENGTH_MM:
                refuse(Q.SINKING_DEPTH, "the hole is deeper than the thread Q201 by at least a third of the pitch")
        if q.get(Q.SINKS_AFTER, 0.0) not in (0.0, 1.0):
            refuse(Q.SINKS_AFTER, "the countersink is milled before the thread (0) or after it (1)")


def _find_feeds(q: _Q, thread: MilledThread, wall: float) -> dict[str, float]:
    """Feed rates of the tool's middle by pace: on helices the teeth go at Q207 along the wall.

    On half circles the middle goes at Q207, but no faster than on the helices.
    """
    share = measure_helix(thread.radius, 360.0, thread.lead) / measure_helix(wall, 360.0, thread.lead)
    mill = q[Q.MILLING_FEED]
    return {
        "plunge": q[Q.POSITIONING_FEED] or FMAX_VALUE,
        "approach": q.get(Q.APPROACH_FEED, 0.0) or mill * min(share, 1.0),
        "thread": mill * share,
        "mill": mill * min(share, 1.0),
        "sink": q.get(Q.BORE_FEED, 0.0),
    }
