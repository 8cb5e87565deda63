"""Strokes of milling cycles: the moves of one cycle before a language executes them, and their places in the plane."""

import math
from collections.abc import Iterable, Iterator
from typing import Literal

from msgspec import Struct

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.machining.plane_geometry import Point

Pace = Literal["rapid", "plunge", "mill", "finish", "return", "approach", "thread", "sink"]


class Stroke(Struct, frozen=True):
    """One move: its end in the plane, mm, and height; an arc turns about ``center`` by ``sweep`` degrees."""

    end: Point
    height: float
    pace: Pace
    center: Point | None = None
    sweep: float = 0.0


class Placement(Struct, frozen=True):
    """Where local coordinates are in the plane: their zero (mm), and the directions of u and v there."""

    origin: Point
    along: Point = (1.0, 0.0)
    across: Point = (0.0, 1.0)

    def place(self, point: Point) -> Point:
        """A local point in the plane."""
        (x, y), (a, b), (c, d) = self.origin, self.along, self.across
        return x + point[0] * a + point[1] * c, y + point[0] * b + point[1] * d


def turn_about(origin: Point, degrees: float, middle: Point = (0.0, 0.0)) -> Placement:
    """Local coordinates turned about a place of the plane, in which ``middle`` is their zero, mm."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    placement = Placement(origin, (c, s), (-s, c))
    return Placement(placement.place(middle), placement.along, placement.across)


def place_strokes(strokes: Iterable[Stroke], placement: Placement) -> Iterator[Stroke]:
    """Strokes in coordinates of the plane."""
    for stroke in strokes:
        center = None if stroke.center is None else placement.place(stroke.center)
        yield Stroke(placement.place(stroke.end), stroke.height, stroke.pace, center, stroke.sweep)


def list_stops(here: Point, height: float, stroke: Stroke) -> list[tuple[Point, float]]:
    """Where a straight stroke from a place ends: rapid traverse goes up before it goes sideways, and down after it.

    Stops that are no more than rounding away from where the tool stands are left out.
    """
    stops = [(stroke.end, stroke.height)]
    if stroke.pace == "rapid":
        stops.insert(0, (here, stroke.height) if stroke.height > height else (stroke.end, height))
    found = []
    for point, level in stops:
        if max(abs(point[0] - here[0]), abs(point[1] - here[1]), abs(level - height)) > ZERO_LENGTH_MM:
            found.append((point, level))
            here, height = point, level
    return found
