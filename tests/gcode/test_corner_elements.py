"""Roundings between two elements of a contour, at corners of any angle: the arc touches both, by its own geometry."""

import math

import numpy as np
import pytest

from verne_post.gcode.machining.elements import Element, make_arc, round_corner
from verne_post.model.moves import MoveKind

CORNER = (3.0, -2.0)
RADIUS = 1.5


def make_element(begins: tuple[float, float], ends: tuple[float, float], sweep: float) -> Element:
    """A line, or an arc with a sweep in degrees."""
    start, end = ([*place, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0] for place in (begins, ends))
    arc = None
    if sweep:
        (u, v), (du, dv) = begins, np.subtract(ends, begins)
        half = 0.5 / math.tan(math.radians(sweep) / 2)
        arc = make_arc(start, 0, (u + 0.5 * du - half * dv, v + 0.5 * dv + half * du), sweep)
    return Element(1, start, end, MoveKind.FEED, 100.0, (0, 1), arc)


def measure_off(element: Element, point: list[float]) -> float:
    """How far a point is from the line or circle of an element."""
    off = np.subtract(point[:2], element.start[:2])
    if element.arc is None:
        du, dv = np.subtract(element.end[:2], element.start[:2])
        return float(abs(du * off[1] - dv * off[0]) / math.hypot(du, dv))
    center = element.arc.center[:2]
    return abs(math.dist(center, point[:2]) - math.dist(center, element.start[:2]))


#: How far the second chord is turned from the first, degrees, and the sweeps of both elements; where these bend at a
#: corner.
CASES = [
    (turned, sweeps)
    for turned in (20.0, 75.0, 110.0, 150.0, -40.0, -90.0, -130.0)
    for sweeps in ((0.0, 0.0), (50.0, 0.0), (0.0, -60.0), (40.0, 70.0), (-50.0, 30.0))
    if 10.0 <= abs(turned - 0.5 * sum(sweeps)) <= 160.0
]


@pytest.mark.parametrize(("turned", "sweeps"), CASES)
@pytest.mark.parametrize("along", [0.0, 35.0, 200.0])
def test_a_rounding_touches_both_elements(turned: float, sweeps: tuple[float, float], along: float) -> None:
    """No corner lies at the origin, and few directions along an axis."""
    first, second = (
        (CORNER[0] + 20 * math.cos(math.radians(way)), CORNER[1] + 20 * math.sin(math.radians(way)))
        for way in (along + 180.0, along + turned)
    )
    before, after = make_element(first, CORNER, sweeps[0]), make_element(CORNER, second, sweeps[1])
    # the directions at the corner decide to which side the contour turns
    bend = turned - 0.5 * sum(sweeps)
    made = round_corner(before, after, RADIUS, "RND")
    assert made is not None
    shorter, arc, later = made
    assert arc.arc is not None
    center = arc.arc.center[:2]
    assert math.copysign(1.0, arc.arc.sweep) == math.copysign(1.0, bend)
    assert abs(arc.arc.sweep) < 180.0
    for element, place in ((before, arc.start), (after, arc.end)):
        assert math.dist(place[:2], center) == pytest.approx(RADIUS, abs=1e-9)
        assert measure_off(element, place) < 1e-9
    # nothing jumps, and no direction changes where they meet
    assert (shorter.end, arc.end) == (arc.start, later.start)
    for one, other in ((shorter, arc), (arc, later)):
        assert one.find_direction(at_end=True) == pytest.approx(other.find_direction(at_end=False), abs=1e-8)
    assert math.dist(shorter.end[:2], CORNER) < 20.0
