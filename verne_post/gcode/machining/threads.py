"""Threads that a mill cuts: helices about the axis of a hole or stud, from and to a place beside on half circles.

For every language: it turns its parameters into a :class:`MilledThread`, and executes the strokes. Local coordinates
(u, v), mm, have the axis at 0.
"""

import math
from collections.abc import Iterable, Iterator

from msgspec import Struct

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.machining.plane_geometry import Point, turn_way
from verne_post.gcode.machining.pockets import count_infeeds
from verne_post.gcode.machining.strokes import Pace, Stroke

_FULL_TURN = 360.0
_HALF_TURN = 180.0


class MilledThread(Struct, frozen=True):
    """A thread and how a mill goes round.

    Attributes
    ----------
    radius : float
        Of the path of the tool's middle about the axis, mm.
    away : float
        Distance from the axis from which a half circle leads onto the helix, and to which one leads back, mm: 0 in a
        hole, more than ``radius`` beside a stud.
    lead : float
        Mm upwards in a turn; below 0 the tool goes down.
    sense : int
        1: counter-clockwise, -1: clockwise.
    first : float
        Angle at which the helices begin, degrees.
    goes_deeper : bool
        A tool that goes down leaves its helix on the way to the side, below its end. If not, it leaves at that height.
    """

    radius: float
    away: float
    lead: float
    sense: int
    first: float = 0.0
    goes_deeper: bool = True

    @property
    def ramp(self) -> float:
        """Mm upwards on a half circle with the slope of the helix; from the middle of a hole a quarter of the lead."""
        return 0.25 * self.lead * abs(self.away - self.radius) / self.radius

    def find_place(self, distance: float, turns: float = 0.0) -> Point:
        """Where the tool is so far from the axis (mm), so many turns after the beginning of a helix."""
        return turn_way((0.0, 0.0), (distance, 0.0), self.first + self.sense * _FULL_TURN * turns)


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


def mill_thread(thread: MilledThread, helices: Iterable[tuple[float, float]]) -> Iterator[Stroke]:
    """Strokes of the helices, each from and to ``away`` beside the axis; a part of a turn ends at another angle.

    Parameters
    ----------
    thread : MilledThread
    helices : iterable of tuple
        As of :func:`list_helices`.

    Yields
    ------
    Stroke
        Local coordinates, mm. "plunge" leads along the axis to where a half circle begins, "approach" are half circles
        onto the helix, "thread" are the helices, whose feed rate may be that of the wall, "mill" leads away from them.
    """
    begin, zero = thread.find_place(thread.radius), (0.0, 0.0)
    for height, turns in helices:
        yield Stroke(thread.find_place(thread.away), height - thread.ramp, "plunge")
        yield _lead_on_half_circle(thread.find_place(thread.away), begin, height, "approach", thread)
        whole, rest = divmod(turns, 1.0)
        for number in range(round(whole)):
            yield Stroke(begin, height + thread.lead * (number + 1), "thread", zero, thread.sense * _FULL_TURN)
        last = height + thread.lead * turns
        if thread.radius * math.radians(_FULL_TURN * rest) > ZERO_LENGTH_MM:
            yield Stroke(thread.find_place(thread.radius, rest), last, "thread", zero, thread.sense * _FULL_TURN * rest)
        end, beside = (thread.find_place(distance, rest) for distance in (thread.radius, thread.away))
        if thread.lead > 0 or thread.goes_deeper:
            last += thread.ramp
        yield _lead_on_half_circle(end, beside, last, "mill", thread)


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
