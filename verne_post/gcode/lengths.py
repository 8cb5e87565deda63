"""Lengths of moves, and the feed rates that follow from them; for one move and for many alike."""

import math

import numpy as np

from verne_post.base.arrays import Array, Mask
from verne_post.gcode.arcs import PLANES, Arc
from verne_post.model.moves import FeedMode


def measure_length(vector: Array) -> Array:
    """Lengths (...) of vectors (..., 3), rounded alike for one and for many."""
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def measure_lengths(delta: Array) -> tuple[Array, Mask]:
    """Length of a straight move by LinuxCNC's rule, and whether the tip moves.

    XYZ if they move, else UVW, else the norm of ABC; ``delta`` has shape (..., 9).
    """
    linear = np.sqrt(delta[..., 0] ** 2 + delta[..., 1] ** 2 + delta[..., 2] ** 2)
    second = np.sqrt(delta[..., 6] ** 2 + delta[..., 7] ** 2 + delta[..., 8] ** 2)
    angular = np.sqrt(delta[..., 3] ** 2 + delta[..., 4] ** 2 + delta[..., 5] ** 2)
    length = np.where(linear > 0, linear, np.where(second > 0, second, angular))
    return length, (linear > 0) | (second > 0)


def measure_arc(arc: Arc, start: list[float], end: list[float]) -> float:
    """Length of a helical arc, mm."""
    first, second, normal, *_letters = PLANES[arc.plane]
    radius = math.hypot(start[first] - arc.center[first], start[second] - arc.center[second])
    return measure_helix(radius, arc.sweep, end[normal] - start[normal])


def measure_helix(radius: float, sweep: float, height: float) -> float:
    """Length of a helix, mm, that turns by ``sweep`` degrees and rises by ``height`` mm."""
    return math.hypot(radius * math.radians(sweep), height)


def find_effective_feed(mode: FeedMode, feed: object, angular: object, length: object, tip_moves: object) -> Array:
    """Feed in mm/min, deg/min for rotary-only moves, mm or deg per revolution for G95.

    Inverse time (F in 1/min) becomes the speed that results, length times F.
    """
    if mode == FeedMode.INVERSE:
        return np.asarray(length) * np.asarray(feed)
    return np.where(np.asarray(tip_moves), np.asarray(feed), np.asarray(angular))
