"""Threads that a mill cuts, for every language: helices of a pitch, each from and to a place beside the wall."""

import math
from collections.abc import Iterable, Iterator
from typing import Final

from msgspec import Struct

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.machining.outlines import ROUNDING_SHARE
from verne_post.gcode.machining.plane_geometry import Point
from verne_post.gcode.machining.strokes import Stroke

_FULL_TURN: Final = 360.0


class MilledThread(Struct, frozen=True):
    """A thread about 0 as the tool's centre mills it.

    Attributes
    ----------
    radius : float
        Of the helix, mm.
    wait : float
        Distance from the axis of the thread at which the tool goes up and down, mm: 0 in the middle of an inside
        thread; outside of the blank of an outside one.
    lead : float
        What the helix rises in a turn, in the unit of the heights; negative: it goes down.
    sense : int
        1: counter-clockwise, -1: clockwise.
    first : float
        Angle at which the helix begins, degrees.
    """

    radius: float
    wait: float
    lead: float
    sense: int
    first: float = 0.0

    def find_place(self, away: float, turns: float) -> Point:
        """Where the tool is so far from the axis (mm), so many turns after the beginning."""
        angle = math.radians(self.first + self.sense * _FULL_TURN * turns)
        return away * math.cos(angle), away * math.sin(angle)


def list_helices(bottom: float, depth: float, lead: float, teeth: int) -> tuple[list[float], float]:
    """Heights at which the helices of a thread begin, in their order, and how many turns each has.

    Parameters
    ----------
    bottom : float
        Height of the deepest turn.
    depth : float
        From there to the surface, positive.
    lead : float
        What a helix rises in a turn; negative: the helices go down, and the highest is the first.
    teeth : int
        1: one helix over the whole depth; more: one turn each so many pitches, as a tool with so many teeth needs; 0:
        one turn at the bottom.
    """
    pitch = abs(lead)
    turns = depth / pitch if teeth == 1 else 1.0
    count = math.ceil(depth / (pitch * teeth) - ROUNDING_SHARE) if teeth > 1 else 1
    bottoms = [bottom + pitch * teeth * number for number in range(max(count, 1))]
    return (bottoms, turns) if lead > 0 else ([one + turns * pitch for one in reversed(bottoms)], turns)


def mill_thread(thread: MilledThread, heights: Iterable[float], turns: float) -> Iterator[Stroke]:
    """Helices from these heights on; along the half circles before and after each it goes on at its pitch.

    So the tool goes half a pitch further than the thread on both ends.

    Yields
    ------
    Stroke
        Local coordinates, mm, heights in the unit of the lead. Down to each helix, and on the half circle to it, the
        pace is "plunge". The helix alone has its centre at 0.
    """
    zero, away = (0.0, 0.0), 0.5 * (thread.radius + thread.wait)
    # inside, the half circles turn as the helix; outside of a bolt they curve the other way
    half = math.copysign(180.0, thread.sense * (thread.radius - thread.wait))
    begin = thread.find_place(thread.radius, 0.0)
    whole, rest = divmod(turns, 1.0)
    for height in heights:
        yield Stroke(thread.find_place(thread.wait, 0.0), height - 0.5 * thread.lead, "plunge")
        yield Stroke(begin, height, "plunge", thread.find_place(away, 0.0), half)
        for number in range(round(whole)):
            yield Stroke(begin, height + thread.lead * (number + 1), "mill", zero, thread.sense * _FULL_TURN)
        last, end = height + thread.lead * turns, begin
        if thread.radius * math.radians(_FULL_TURN * rest) > ZERO_LENGTH_MM:
            end = thread.find_place(thread.radius, rest)
            yield Stroke(end, last, "mill", zero, thread.sense * _FULL_TURN * rest)
        part = rest if end is not begin else 0.0
        center = thread.find_place(away, part)
        yield Stroke(thread.find_place(thread.wait, part), last + 0.5 * thread.lead, "mill", center, half)
