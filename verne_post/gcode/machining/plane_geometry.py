"""Points, directions and angles in a plane, for contours of every language. mm, and degrees unless said otherwise."""

import math

from verne_post.base.tolerances import CORNER_ANGLE, CORNER_REACH_MM

Point = tuple[float, float]
#: Between tangents as a program rounds them: about a degree.
_NEARLY_TANGENT = 0.02


def turn_left(t: Point) -> Point:
    """The direction to the left of another one."""
    return -t[1], t[0]


def cross(a: Point, b: Point) -> float:
    """Sine of the angle from one direction to another, times their lengths."""
    return a[0] * b[1] - a[1] * b[0]


def step_left(point: Point, t: Point, distance: float) -> Point:
    """A point beside another one, to the left of direction t; a distance below 0 is to the right."""
    return point[0] - distance * t[1], point[1] + distance * t[0]


def find_tangent(point: Point, center: Point, sense: float) -> Point:
    """Direction of travel at a point of a circle, counter-clockwise for sense 1, clockwise for -1."""
    du, dv = point[0] - center[0], point[1] - center[1]
    size = math.hypot(du, dv)
    return -sense * dv / size, sense * du / size


def is_sense_doubtful(arc: tuple[Point, Point, Point, int], place: Point, direction: Point) -> bool:
    """Whether an arc (start, end, centre, sense) is tangent to a direction at one of its ends in the other sense alone.

    The other sense has the same centre, or the same radius and its centre beyond the chord.
    """
    start, end, center, sense = arc
    beyond = start[0] + end[0] - center[0], start[1] + end[1] - center[1]
    tangents = [find_tangent(place, *other) for other in ((center, sense), (center, -sense), (beyond, -sense))]
    is_tangent = [math.dist(tangent, direction) < _NEARLY_TANGENT for tangent in tangents]
    return not is_tangent[0] and any(is_tangent[1:])


def measure_turn(start: Point, end: Point, center: Point, sense: float) -> float:
    """Angle (rad) from point to point about a centre, in [0, 2 pi)."""
    first = math.atan2(start[1] - center[1], start[0] - center[0])
    last = math.atan2(end[1] - center[1], end[0] - center[0])
    return (sense * (last - first)) % (2.0 * math.pi)


def measure_sweep(start: Point, end: Point, center: Point, sense: float) -> float:
    """Signed sweep from point to point about a centre."""
    return sense * math.degrees(measure_turn(start, end, center, sense))


def turn_point(point: Point, center: Point, angle: float) -> Point:
    """A point turned about a centre by an angle in degrees."""
    return turn_way(center, (point[0] - center[0], point[1] - center[1]), angle)


def turn_way(center: Point, way: Point, angle: float) -> Point:
    """Where a way from a centre leads that is turned by an angle in degrees."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    return center[0] + c * way[0] - s * way[1], center[1] + s * way[0] + c * way[1]


def find_tangent_sweep(t: Point, chord: Point) -> float:
    """Sweep in degrees of the arc that leaves in direction t and ends at the end of a chord; 0 for a straight line."""
    angle = math.atan2(cross(t, chord), t[0] * chord[0] + t[1] * chord[1])
    return 0.0 if abs(angle) < CORNER_ANGLE else math.degrees(2 * angle)


def find_center_of_sweep(start: Point, end: Point, sweep: float) -> Point:
    """Centre of the arc between two points with a sweep in degrees."""
    half = 0.5 / math.tan(math.radians(sweep) / 2)
    du, dv = end[0] - start[0], end[1] - start[1]
    return 0.5 * (start[0] + end[0]) - half * dv, 0.5 * (start[1] + end[1]) + half * du


def meet_line_and_circle(line: tuple[Point, Point], center: Point, radius: float) -> list[Point]:
    """Points that a line (a point and a unit direction) and a circle share."""
    (u, v), (du, dv) = line
    wu, wv = u - center[0], v - center[1]
    half = wu * du + wv * dv
    root = half * half - (wu * wu + wv * wv - radius * radius)
    if root < -2.0 * radius * CORNER_REACH_MM:  # farther apart than rounding moves a line that touches the circle
        return []
    root = math.sqrt(max(root, 0.0))
    return [(u + s * du, v + s * dv) for s in (-half - root, -half + root)]


def meet_two_circles(c1: Point, r1: float, c2: Point, r2: float) -> list[Point]:
    """Points that two circles share."""
    distance = math.dist(c1, c2)
    if not abs(r1 - r2) - CORNER_REACH_MM <= distance <= r1 + r2 + CORNER_REACH_MM or distance == 0.0:
        return []
    along = (distance**2 + r1**2 - r2**2) / (2 * distance)
    height = math.sqrt(max(r1**2 - along**2, 0.0))
    du, dv = (c2[0] - c1[0]) / distance, (c2[1] - c1[1]) / distance
    return [(c1[0] + along * du - s * height * dv, c1[1] + along * dv + s * height * du) for s in (-1, 1)]
