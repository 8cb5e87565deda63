"""A judge of milled pockets, studs and faces: samples of the tip's path against the shape. It shares nothing with the
generator.

Lengths in mm. A shape is a function of points (n, 2) -> signed distance to its outline, negative inside.
"""

import math

import numpy as np
from scipy.spatial import cKDTree

from verne_post.model.moves import MoveKind

#: Distance of samples along the path; every tenth one cuts the simulated material.
SAMPLE = 0.1
CUTTING = 10
#: More than what cuts that far apart leave between them beside the tool.
CUSP = 0.1
#: Distance of places at which the material is looked at.
GRID = 0.7
#: What rounding and the sampling of arcs leave.
NOISE = 1e-6


def rectangle(length, width, corner, angle=0.0, middle=(0.0, 0.0)):
    """A rectangle with round corners."""
    turn = math.radians(angle)

    def distance(points):
        x, y = (points - middle).T
        u, v = np.abs(math.cos(turn) * x + math.sin(turn) * y), np.abs(math.cos(turn) * y - math.sin(turn) * x)
        du, dv = u - 0.5 * length + corner, v - 0.5 * width + corner
        return np.hypot(np.maximum(du, 0), np.maximum(dv, 0)) + np.minimum(np.maximum(du, dv), 0) - corner

    return distance


def circle(radius, middle=(0.0, 0.0)):
    """A circle."""
    return lambda points: np.hypot(*(points - middle).T) - radius


def polygon(count, inradius, corner, angle, middle=(0.0, 0.0)):
    """A regular polygon with round corners, one of them at an angle; ``inradius`` of its inscribed circle."""
    half = math.pi / count

    def distance(points):
        x, y = (points - middle).T
        beside = (np.arctan2(y, x) - math.radians(angle)) % (2 * half) - half  # from the middle of the nearest side
        size = np.hypot(x, y)
        along = np.abs(size * np.sin(beside)) - (inradius - corner) * math.tan(half)
        out = size * np.cos(beside) - inradius + corner
        return np.where(out > 0, np.hypot(np.maximum(along, 0), out), out) - corner

    return distance


def curved_slot(radius, first, sweep, width, middle=(0.0, 0.0)):
    """A slot along a circle."""

    def distance(points):
        x, y = (points - middle).T
        beside = (np.degrees(np.arctan2(y, x)) - first - 0.5 * sweep + 180.0) % 360.0 - 180.0
        angle = np.radians(first + 0.5 * sweep + np.clip(beside, -0.5 * sweep, 0.5 * sweep))
        return np.hypot(x - radius * np.cos(angle), y - radius * np.sin(angle)) - 0.5 * width

    return distance


def sample_path(moves):
    """Whether it is rapid traverse, and places (n, 3) along it, of each move; the end is the last of them."""
    for row in range(1, len(moves)):
        begin, end = moves.end[row - 1][:3], moves.end[row][:3]
        if moves.kind[row] == MoveKind.ARC:
            center, sweep = moves.arcs.center[moves.arc[row]][:2], math.radians(moves.arcs.sweep[moves.arc[row]])
            radius = math.dist(begin[:2], center)
            share = np.linspace(0, 1, max(math.ceil(abs(sweep) * radius / SAMPLE), 1) + 1)
            angle = math.atan2(begin[1] - center[1], begin[0] - center[0]) + share * sweep
            xy = center + radius * np.column_stack([np.cos(angle), np.sin(angle)])
            places = np.column_stack([xy, begin[2] + share * (end[2] - begin[2])])
            assert np.abs(places[-1] - end).max() < NOISE
        else:
            share = np.linspace(0, 1, max(math.ceil(math.dist(begin, end) / SAMPLE), 1) + 1)[:, None]
            places = begin + share * (end - begin)
        yield moves.kind[row] == MoveKind.RAPID, places


def judge(moves, radius, shape, top, bottom, *, blank=None, allowance=0.0, floor_allowance=0.0):
    """Refuse (AssertionError) a pocket, or a stud in its ``blank``, that is not milled as its shape says.

    ``allowance`` and ``floor_allowance`` are what was to be left; without a shape the whole blank goes.
    """
    path = list(sample_path(moves))
    places, sign = np.concatenate([part for _rapid, part in path]), 1.0 if blank is None else -1.0
    cutting = places[places[:, 2] < top - NOISE]
    bottom += floor_allowance
    deep = cutting[np.abs(cutting[:, 2] - bottom) < NOISE, :2]
    # depth and wall are exact, and nothing beyond them is touched
    assert abs(cutting[:, 2].min() - bottom) < NOISE
    if shape is not None:
        wall = sign * shape(cutting[:, :2]).min() if sign < 0 else shape(cutting[:, :2]).max()
        assert wall <= -radius - allowance + NOISE
        assert (sign * shape(deep)).max() >= -radius - allowance - NOISE
    # every place of the floor is reached
    x, y = (
        np.arange(low - radius, high + radius, GRID)
        for low, high in zip(deep.min(axis=0), deep.max(axis=0), strict=True)
    )
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    stock = np.ones(len(points), dtype=bool) if blank is None else blank(points) < 0
    wanted = points[stock if shape is None else stock & (sign * shape(points) < -allowance - 0.02)]
    # nothing is wanted where the blank has the size of the stud
    assert cKDTree(deep).query(wanted)[0].max(initial=0.0) <= radius + 0.5 * SAMPLE**2
    # rapid traverse meets no material
    tree, height = cKDTree(points), np.where(stock, top, -np.inf)
    for is_rapid, part in path:
        if part[:, 2].min() < top - NOISE:
            if blank is not None and part[-1, 2] < part[0, 2]:  # down beside it
                assert blank(part[:1, :2])[0] >= radius - NOISE
            for place in (*part[:-1:CUTTING], part[-1]):
                under = tree.query_ball_point(place[:2], radius - (CUSP if is_rapid else 0.0))
                if is_rapid:
                    assert height[under].max(initial=-np.inf) <= place[2] + NOISE, place
                height[under] = np.minimum(height[under], place[2])


def judge_open_slot(moves, radius, slot, stock, bottom, allowance):
    """Refuse (AssertionError) an open slot that is not milled whole, whose walls are touched, or that is entered from
    above.
    """
    height = {}
    for is_rapid, part in sample_path(moves):
        below = part[part[:, 2] < -NOISE]
        if len(below):
            assert slot(below[:, :2]).max() <= -radius - allowance + NOISE
            assert below[:, 2].min() >= bottom - NOISE
        if is_rapid or part[0, 2] != part[-1, 2]:  # up and down: beside the stock
            assert not len(below) or stock(below[:, :2]).min() >= radius - NOISE
        else:
            height.setdefault(round(part[0, 2], 6), []).append(part[:, :2])
    deep = np.concatenate(height[round(bottom, 6)])
    x, y = (np.arange(low - radius, high + radius, GRID) for low, high in zip(deep.min(0), deep.max(0), strict=True))
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    wanted = points[(stock(points) < 0) & (slot(points) < -allowance - 0.02)]
    assert cKDTree(deep).query(wanted)[0].max() <= radius + 0.5 * SAMPLE**2
