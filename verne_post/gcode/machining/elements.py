"""Elements of a contour, lines and arcs, and the corners between two of them: roundings and chamfers."""

import math
from typing import Final

from msgspec import Struct, field
from msgspec.structs import replace

from verne_post.base.tolerances import CORNER_ANGLE, CORNER_REACH_MM, ZERO_LENGTH_MM
from verne_post.gcode.arcs import PLANES, Arc
from verne_post.gcode.machining.plane_geometry import (
    Point,
    cross,
    find_tangent,
    measure_sweep,
    meet_line_and_circle,
    meet_two_circles,
    step_left,
)
from verne_post.gcode.program_error import ProgramError
from verne_post.model.moves import ArcFeed, MoveKind

_FULL_TURN: Final = 360.0


class Element(Struct, frozen=True):
    """One line or arc in coordinates of the frame, mm; nine axes."""

    line: int  #: Source line.
    start: list[float]
    end: list[float]
    kind: MoveKind  #: RAPID or FEED.
    feed: float  #: Feed rate, as the feed mode has it.
    axes: tuple[int, ...]  #: Axes that the block names.
    arc: Arc | None = field(default=None)  #: None for a line.
    arc_feed: ArcFeed = field(default_factory=ArcFeed)  #: Where F holds on an arc, as it was in its block.
    absolute: bool = True  #: Whether its end was named in absolute coordinates.

    def find_direction(self, *, at_end: bool) -> Point | None:
        """Direction of travel in the plane at one end; None for a line without length there."""
        u, v, *_ = PLANES[self.arc.plane if self.arc is not None else 0]
        if self.arc is not None:
            point, center = self.end if at_end else self.start, self.arc.center
            return find_tangent((point[u], point[v]), (center[u], center[v]), math.copysign(1.0, self.arc.sweep))
        du, dv = self.end[u] - self.start[u], self.end[v] - self.start[v]
        size = math.hypot(du, dv)
        return None if size < ZERO_LENGTH_MM else (du / size, dv / size)

    @property
    def plane(self) -> int:
        """Plane of the arc, XY for a line."""
        return 0 if self.arc is None else self.arc.plane


def make_arc(start: list[float], plane: int, center: Point, sweep: float) -> Arc:
    """An arc by its centre in the plane, mm, and its sweep in degrees."""
    u, v, w, *_ = PLANES[plane]
    place = [0.0, 0.0, 0.0]
    place[u], place[v], place[w] = center[0], center[1], start[w]
    turns = max(math.ceil(abs(sweep) / _FULL_TURN - 1e-9), 1)
    return Arc(plane, (place[0], place[1], place[2]), turns if sweep > 0 else -turns, sweep)


def round_corner(first: Element, second: Element, radius: float, name: str) -> tuple[Element, Element, Element] | None:
    """Both elements shortened, with the arc between them; None where they continue each other.

    Raises
    ------
    ProgramError
        VP008: the radius does not fit between them.
    """
    t1, t2 = _find_corner_directions(first, second, name)
    side = math.copysign(1.0, cross(t1, t2))
    if abs(cross(t1, t2)) < CORNER_ANGLE and t1[0] * t2[0] + t1[1] * t2[1] > 0:
        return None
    corner = (first.end[0], first.end[1])
    centers = _meet_elements(first, t1, second, t2, corner, side * radius)
    for center in sorted(centers, key=lambda point: math.dist(point, corner)):
        touch1, touch2 = (_find_foot(element, t, center) for element, t in ((first, t1), (second, t2)))
        before, after = _cut_end(first, touch1), _cut_start(second, touch2)
        if before is None or after is None:
            continue
        sweep = measure_sweep(touch1, touch2, center, side)
        arc = make_arc(before.end, 0, center, sweep)
        return (
            before,
            replace(before, start=before.end, end=after.start, kind=MoveKind.FEED, axes=(0, 1), arc=arc),
            after,
        )
    raise ProgramError("VP008", f"{name}: no arc of radius {radius:g} mm fits between these elements")


def chamfer_corner(first: Element, second: Element, length: float, name: str) -> tuple[Element, Element, Element]:
    """Both lines shortened by a length, and the line between them.

    Raises
    ------
    ProgramError
        VP008 where one of them is an arc, or too short.
    """
    if first.arc is not None or second.arc is not None:
        raise ProgramError("VP008", f"{name} is between elements of which one is an arc; it needs two lines")
    t1, t2 = _find_corner_directions(first, second, name)
    corner = first.end
    before = _cut_end(first, (corner[0] - length * t1[0], corner[1] - length * t1[1]))
    after = _cut_start(second, (corner[0] + length * t2[0], corner[1] + length * t2[1]))
    if before is None or after is None:
        raise ProgramError("VP008", f"{name} {length:g} mm is longer than one of the lines beside it")
    return before, replace(before, start=before.end, end=after.start, kind=MoveKind.FEED, axes=(0, 1)), after


def _find_corner_directions(first: Element, second: Element, name: str) -> tuple[Point, Point]:
    t1, t2 = first.find_direction(at_end=True), second.find_direction(at_end=False)
    if first.plane or second.plane or t1 is None or t2 is None:
        raise ProgramError("VP008", f"{name} needs an element before and after it that moves in X and Y")
    if any(
        abs(a - b) > ZERO_LENGTH_MM
        for element in (first, second)
        for a, b in zip(element.start[2:], element.end[2:], strict=True)
    ):
        raise ProgramError("VP008", f"{name} between elements that move out of the plane")
    return t1, t2


def _meet_elements(first: Element, t1: Point, second: Element, t2: Point, corner: Point, offset: float) -> list[Point]:
    """Where both elements meet when each is moved to its left by an offset."""
    lines, circles = [], []
    for element, t in ((first, t1), (second, t2)):
        if element.arc is None:
            lines.append((step_left(corner, t, offset), t))
        else:
            center = (element.arc.center[0], element.arc.center[1])
            radius = math.dist(center, corner) - math.copysign(offset, offset * element.arc.sweep)
            circles.append((center, radius))
    if any(radius <= 0 for _center, radius in circles):
        return []
    if len(lines) == 2:
        (p, d), (q, e) = lines
        share = cross((q[0] - p[0], q[1] - p[1]), e) / (cross(d, e) or math.inf)
        return [(p[0] + share * d[0], p[1] + share * d[1])] if cross(d, e) else []
    if len(lines) == 1:
        return meet_line_and_circle(lines[0], *circles[0])
    return meet_two_circles(*circles[0], *circles[1])


def _find_foot(element: Element, t: Point, center: Point) -> Point:
    """The point of an element's line or circle nearest to a centre."""
    if element.arc is None:
        q = (element.start[0], element.start[1])
        along = (center[0] - q[0]) * t[0] + (center[1] - q[1]) * t[1]
        return q[0] + along * t[0], q[1] + along * t[1]
    c = (element.arc.center[0], element.arc.center[1])
    radius, away = math.dist(c, (element.start[0], element.start[1])), math.dist(c, center)
    if away == 0.0:
        return element.end[0], element.end[1]
    return c[0] + radius * (center[0] - c[0]) / away, c[1] + radius * (center[1] - c[1]) / away


def _cut_end(element: Element, point: Point) -> Element | None:
    """The element up to a point of it; None where it does not hold the point."""
    end = [point[0], point[1], *element.end[2:]]
    if element.arc is None:
        t = element.find_direction(at_end=True) or (0.0, 0.0)
        along = (point[0] - element.start[0]) * t[0] + (point[1] - element.start[1]) * t[1]
        return None if along < -CORNER_REACH_MM else replace(element, end=end)
    return _cut_arc(element, element.start, end)


def _cut_start(element: Element, point: Point) -> Element | None:
    """The element from a point of it on; None where it does not hold the point."""
    start = [point[0], point[1], *element.start[2:]]
    if element.arc is None:
        t = element.find_direction(at_end=True) or (0.0, 0.0)
        along = (element.end[0] - point[0]) * t[0] + (element.end[1] - point[1]) * t[1]
        return None if along < -CORNER_REACH_MM else replace(element, start=start)
    return _cut_arc(element, start, element.end)


def _cut_arc(element: Element, start: list[float], end: list[float]) -> Element | None:
    assert element.arc is not None
    center, sweep = (element.arc.center[0], element.arc.center[1]), element.arc.sweep
    kept_sweep = measure_sweep((start[0], start[1]), (end[0], end[1]), center, math.copysign(1.0, sweep))
    if abs(kept_sweep) > abs(sweep) + math.degrees(CORNER_ANGLE):
        return None
    return replace(element, start=start, end=end, arc=make_arc(start, 0, center, kept_sweep))
