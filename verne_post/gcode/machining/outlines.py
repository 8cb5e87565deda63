"""Outlines of pockets, slots and studs in their plane, and the closed paths beside them.

Local coordinates (u, v), mm: a pocket or stud has its middle at 0 and its first side along u. A path begins in the
middle of a side (v below 0, except for the slot on a circle) and goes round counter-clockwise.
"""

import math
from collections.abc import Iterator
from typing import Final, Protocol

from msgspec import Struct

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.machining.plane_geometry import Point, turn_way

#: A share of a step that is rounding: quotients of programmed lengths that are whole differ from it by less.
ROUNDING_SHARE: Final = 1e-9
_QUARTER: Final = 90.0
_HALF: Final = 180.0


class Leg(Struct, frozen=True):
    """A line or arc to ``end``; an arc turns about ``center`` by ``sweep`` degrees, counter-clockwise positive."""

    end: Point
    center: Point | None = None
    sweep: float = 0.0


class Path(Struct, frozen=True):
    """Lines and arcs that follow each other."""

    start: Point
    legs: tuple[Leg, ...]

    @property
    def end(self) -> Point:
        """Where it ends."""
        return self.legs[-1].end if self.legs else self.start

    @property
    def length(self) -> float:
        """Mm."""
        starts = [self.start, *(leg.end for leg in self.legs)]
        return sum(
            math.dist(start, leg.end)
            if leg.center is None
            else math.dist(start, leg.center) * math.radians(abs(leg.sweep))
            for start, leg in zip(starts, self.legs, strict=False)
        )

    def turn_round(self) -> "Path":
        """The same path the other way round."""
        ends = [self.start, *(leg.end for leg in self.legs)]
        legs = [Leg(end, leg.center, -leg.sweep) for end, leg in zip(ends, self.legs, strict=False)]
        return Path(self.end, tuple(reversed(legs)))


class Outline(Protocol):
    """What a cycle leaves standing, or mills."""

    def lead_beside(self, inward: float) -> Path:
        """The closed path so many mm inside of the outline; outside where that is negative."""


class PocketOutline(Outline, Protocol):
    """What a tool plunges into."""

    @property
    def inradius(self) -> float:
        """Radius of the largest circle inside, mm."""

    def lead_along(self, room: float) -> Path:
        """The path to and fro along which a tool may plunge; ``room`` (mm) is how far it may leave the middle line."""


def _join(start: Point, legs: list[Leg]) -> Path:
    """A path without legs of no length; consecutive arcs about one centre are one arc, up to a half circle."""
    kept_legs, place = list[Leg](), start
    for leg in legs:
        if math.dist(place, leg.end if leg.center is None else leg.center) <= ZERO_LENGTH_MM:
            continue
        last, place = kept_legs[-1] if kept_legs else None, leg.end
        goes_on = (
            last is not None and last.center is not None and last.center == leg.center and last.sweep * leg.sweep > 0
        )
        if last is not None and goes_on and abs(last.sweep + leg.sweep) <= _HALF:
            kept_legs[-1] = Leg(leg.end, leg.center, last.sweep + leg.sweep)
        else:
            kept_legs.append(leg)
    return Path(start, tuple(kept_legs))


class Rectangle(Struct, frozen=True):
    """A rectangle, ``length`` along u and ``width`` along v, with round corners; a slot where they are half circles."""

    length: float
    width: float
    corner: float

    @property
    def inradius(self) -> float:
        """Half the shorter side."""
        return 0.5 * min(self.length, self.width)

    def lead_beside(self, inward: float) -> Path:
        """Outside of it the corners are round, also where the rectangle has sharp ones."""
        u, v = max(0.5 * self.length - inward, 0.0), max(0.5 * self.width - inward, 0.0)
        r = min(max(self.corner - inward, 0.0), u, v)
        return _join(
            (0.0, -v),
            [
                Leg((u - r, -v)),
                Leg((u, r - v), (u - r, r - v), _QUARTER),
                Leg((u, v - r)),
                Leg((u - r, v), (u - r, v - r), _QUARTER),
                Leg((r - u, v)),
                Leg((-u, v - r), (r - u, v - r), _QUARTER),
                Leg((-u, r - v)),
                Leg((r - u, -v), (r - u, r - v), _QUARTER),
                Leg((0.0, -v)),
            ],
        )

    def lead_along(self, room: float) -> Path:
        """Along the longer side."""
        half = 0.5 * abs(self.length - self.width) + room
        end = (half, 0.0) if self.length >= self.width else (0.0, half)
        return Path((-end[0], -end[1]), (Leg(end),))


class Circle(Struct, frozen=True):
    """A circle about 0."""

    radius: float

    @property
    def inradius(self) -> float:
        """Its radius."""
        return self.radius

    def lead_beside(self, inward: float) -> Path:
        """Two half circles."""
        r = max(self.radius - inward, 0.0)
        return _join((0.0, -r), [Leg((0.0, r), (0.0, 0.0), _HALF), Leg((0.0, -r), (0.0, 0.0), _HALF)])

    def lead_along(self, room: float) -> Path:
        """Along u."""
        return Path((-room, 0.0), (Leg((room, 0.0)),))


class Polygon(Struct, frozen=True):
    """A regular polygon about 0 with round corners, whose inscribed circle has ``inradius``; one side is below 0."""

    count: int
    inradius: float
    corner: float

    @property
    def half_step(self) -> float:
        """Angle from the middle of a side to the next corner, degrees."""
        return _HALF / self.count

    def lead_beside(self, inward: float) -> Path:
        """Outside of it the corners are round, also where the polygon has sharp ones."""
        r = max(self.corner - inward, 0.0)
        v = max(self.inradius - inward - r, 0.0)  # of the polygon of the middles of the corners
        u, zero = v * math.tan(math.radians(self.half_step)), (0.0, 0.0)
        legs = list[Leg]()
        for number in range(self.count):
            here, after = 2 * self.half_step * number, 2 * self.half_step * (number + 1)
            legs += [
                Leg(turn_way(zero, (u, -v - r), here)),
                Leg(turn_way(zero, (-u, -v - r), after), turn_way(zero, (u, -v), here), 2 * self.half_step),
            ]
        return _join((0.0, -v - r), [*legs, Leg((0.0, -v - r))])


class CurvedSlot(Struct, frozen=True):
    """A slot with round ends along a circle of ``radius`` about 0, from angle ``first`` by ``sweep`` degrees."""

    radius: float
    first: float
    sweep: float
    width: float

    @property
    def inradius(self) -> float:
        """Half its width."""
        return 0.5 * self.width

    def _place(self, radius: float, share: float) -> Point:
        angle = math.radians(self.first + share * self.sweep)
        return radius * math.cos(angle), radius * math.sin(angle)

    def lead_beside(self, inward: float) -> Path:
        """From the middle of the outer side."""
        half, zero = max(0.5 * self.width - inward, 0.0), (0.0, 0.0)
        outer, inner, place = self.radius + half, self.radius - half, self._place
        return _join(
            place(outer, 0.5),
            [
                Leg(place(outer, 1.0), zero, 0.5 * self.sweep),
                Leg(place(inner, 1.0), place(self.radius, 1.0), _HALF),
                Leg(place(inner, 0.0), zero, -self.sweep),
                Leg(place(outer, 0.0), place(self.radius, 0.0), _HALF),
                Leg(place(outer, 0.5), zero, 0.5 * self.sweep),
            ],
        )

    def lead_along(self, room: float) -> Path:
        """Along the middle line."""
        place = self._place
        return Path(place(self.radius, 0.0), (Leg(place(self.radius, 1.0), (0.0, 0.0), self.sweep),))


def measure_reach(stud: Rectangle, blank: Rectangle) -> float:
    """How far the corners of a rectangular blank stand out from the stud in its middle, mm."""
    u, v = 0.5 * (blank.length - stud.length) + stud.corner, 0.5 * (blank.width - stud.width) + stud.corner
    return math.hypot(max(u, 0.0), max(v, 0.0)) - stud.corner


def spread_offsets(first: float, last: float, step: float) -> Iterator[float]:
    """Even distances from one to another, no further apart than ``step`` (mm); the last one exactly."""
    count = math.ceil(abs(last - first) / step - ROUNDING_SHARE)
    for number in range(count):
        yield first + (last - first) * number / count
    yield last
