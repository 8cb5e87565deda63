"""Threads that a mill cuts: helices about the axis of a hole or stud, from and to a place beside on half circles.

For every language: it turns its parameters into a :class:`MilledThread`, and executes the strokes. Local coordinates
(u, v), mm, have the axis at 0.
"""

import math
from collections.abc import Iterator

from msgspec import Struct

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.machining.plane_geometry import Point, turn_way
from verne_post.gcode.machining.pockets import count_infeeds
from verne_post.gcode.machining.strokes import Pace, Stroke

_FULL_TURN = 360.0
_HALF_TURN = 180.0


class MilledThread(Struct, frozen=True):
    """A thread and how a mill goes round."""

    radius: float  #: Of the path of the tool's middle about the axis, mm.
    #: Distance from the axis from which a half circle leads onto the helix, and to which one leads back, mm: 0 in
    #: a hole, more than ``radius`` beside a stud.
    away: float
    lead: float  #: Mm upwards in a turn; below 0 the tool goes down.
    sense: int  #: 1: counter-clockwise, -1: clockwise.
    #: A tool that goes down leaves its helix on the way to the side, below its end. If not, it leaves at that
    #: height.
    goes_deeper: bool = True
    first: float = 0.0  #: Angle at which each helix begins, degrees.
    #: How far the tool goes along the axis on a half circle, mm, as the control has it; None: at the slope of the
    #: helix.
    overrun: float | None = None

    @property
    def ramp(self) -> float:
        """Mm upwards on a half circle; at the slope of the helix a quarter of the lead from the middle of a hole."""
        if self.overrun is not None:
            return math.copysign(self.overrun, self.lead)
        return 0.25 * self.lead * abs(self.away - self.radius) / self.radius

    def find_place(self, away: float, turns: float = 0.0) -> Point:
        """Where the tool is so far from the axis (mm), so many turns after the beginning of a helix."""
        return turn_way((0.0, 0.0), (away, 0.0), self.first + self.sense * _FULL_TURN * turns)


def list_helices(top: float, bottom: float, lead: float, apart: float | None) -> list[tuple[float, float]]:
    """Helices of a thread in their order: the height at which each begins, mm, and its turns.

    Parameters
    ----------
    top, bottom : float
        Heights of the ends of the thread, mm.
    lead : float
        Mm upwards in a turn.
    apart : float or None
        None: one helix from end to end. Else helices of one turn each so many mm, the lowest one at the bottom; 0:
        that one alone.
    """
    depth, pitch = top - bottom, abs(lead)
    if apart is None:
        return [(bottom if lead > 0 else top, depth / pitch)]
    count = count_infeeds(depth, apart)
    lows = [bottom + apart * number for number in range(count)]
    return [(low, 1.0) for low in lows] if lead > 0 else [(low + pitch, 1.0) for low in reversed(lows)]


def mill_thread(thread: MilledThread, helices: list[tuple[float, float]]) -> Iterator[Stroke]:
    """Strokes of the helices, each from and to the distance ``away``; a thread that lacks a turn ends at another angle.

    Parameters
    ----------
    thread : MilledThread
    helices : list of tuple
        As of :func:`list_helices`.

    Yields
    ------
    Stroke
        Local coordinates, mm. "plunge" leads along the axis to where a half circle begins, "approach" are half circles
        onto the helix, "thread" are the helices, whose feed rate may be that of the wall, "mill" leads away from them.
    """
    beside, begin = thread.find_place(thread.away), thread.find_place(thread.radius)
    for height, turns in helices:
        yield Stroke(beside, height - thread.ramp, "plunge")
        yield _lead_on_half_circle(beside, begin, height, "approach", thread)
        whole, rest = divmod(turns, 1.0)
        for number in range(round(whole)):
            yield Stroke(begin, height + thread.lead * (number + 1), "thread", (0.0, 0.0), thread.sense * _FULL_TURN)
        last, end, sweep = height + thread.lead * turns, thread.find_place(thread.radius, rest), _FULL_TURN * rest
        if thread.radius * math.radians(sweep) > ZERO_LENGTH_MM:
            yield Stroke(end, last, "thread", (0.0, 0.0), thread.sense * sweep)
        if thread.lead > 0 or thread.goes_deeper:
            last += thread.ramp
        yield _lead_on_half_circle(end, thread.find_place(thread.away, rest), last, "mill", thread)


def mill_countersink(radius: float, away: float, height: float, sense: int) -> Iterator[Stroke]:
    """A full circle about the axis at a height, from and to u = ``away`` on half circles."""
    thread, begin, beside = MilledThread(radius, away, 0.0, sense), (radius, 0.0), (away, 0.0)
    yield _lead_on_half_circle(beside, begin, height, "sink", thread)
    yield Stroke(begin, height, "sink", (0.0, 0.0), sense * _FULL_TURN)
    yield _lead_on_half_circle(begin, beside, height, "sink", thread)


def _lead_on_half_circle(start: Point, end: Point, height: float, pace: Pace, thread: MilledThread) -> Stroke:
    """Onto a circle about the axis, or away from it, in its own direction."""
    center = 0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])
    turn = thread.sense if thread.away < thread.radius else -thread.sense
    return Stroke(end, height, pace, center, turn * _HALF_TURN)
