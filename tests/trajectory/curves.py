"""Runs with joints in closed form, and a judge of rows that shares nothing with the code under test."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from verne_post.model.machine import Limits

Array = np.ndarray
#: What rows may reach: velocity, acceleration, jerk, feed. The last digit is for the rounding of the quotients.
ACCEPTED = np.array([1.0003, 1.002, 1.008, 1.0003]) + 1e-9


@dataclass(frozen=True)
class Curve:
    """A section given by its joints as functions of s."""

    length: float
    joints: Callable[[Array], list[Array]]
    feed: float | Callable[[Array], Array] = np.inf
    elements: int = 10

    @property
    def breaks(self) -> Array:
        return np.linspace(0.0, self.length, self.elements + 1)

    def find_joints(self, s: Array) -> Array:
        return np.stack(np.broadcast_arrays(*self.joints(s)), axis=1).astype(float)

    def find_speed(self, s: Array) -> Array:
        return self.feed(s) if callable(self.feed) else np.full(len(s), self.feed)

    def measure_hidden(self, s: Array) -> Array:
        return np.zeros(len(s) - 1)

    def find_joints_and_hidden(self, s: Array) -> tuple[Array, Array]:
        return self.find_joints(s), self.measure_hidden(s)


def limits(n: int, velocity: float = 833.0, acceleration: float = 5000.0, jerk: float = 1e5) -> Limits:
    """The same dynamics for every joint; sliders of the default machine, mm and s."""
    full = np.full(n, 1.0)
    return Limits(-np.inf * full, np.inf * full, velocity * full, acceleration * full, jerk * full, 0.0)


def straight(length: float, feed: float = np.inf) -> Curve:
    """One joint that moves with s, one at half its speed, one at rest."""
    return Curve(length, lambda s: [s, 0.5 * s, np.zeros_like(s)], feed)


def wavy(length: float, waves: float, feed: float = np.inf) -> Curve:
    """Joints that speed up and slow down along s, and never turn back."""
    k = 2 * np.pi * waves / length
    return Curve(
        length,
        lambda s: [
            s + 0.6 / k * np.sin(k * s),
            0.7 * s - 0.5 / k * np.cos(1.3 * k * s),
            0.4 * s + 0.2 / k * np.sin(k * s),
        ],
        feed,
        max(int(8 * waves), 1),
    )


def bump(w: Array) -> Array:
    """Integral of the smooth step from 0 to 1 over 0..1, whose third derivative jumps at both ends."""
    w = np.clip(w, 0.0, None)
    inner = np.minimum(w, 1.0)
    return inner**4 * (2.5 - 3 * inner + inner**2) + np.maximum(w - 1.0, 0.0)


def cornered(pitch: float, corners: int, blend: float, feed: float) -> Curve:
    """A zigzag of right angles, each rounded over a length ``blend`` of s, with resting third joint."""

    def side(s: Array) -> Array:
        total = np.zeros_like(s)
        for i in range(corners):
            at = (i + 1) * pitch - 0.5 * blend
            total += (-1.0) ** i * blend * bump((s - at) / blend)
        return total

    return Curve((corners + 1) * pitch, lambda s: [s - 0.3 * side(s), side(s), np.ones_like(s)], feed, corners * 4)


def worst(section: Curve, s: Array, limits: Limits, cycle: float) -> Array:
    """Largest ratios of velocity, acceleration, jerk and feed over the rows, with rest before and after."""
    rows = np.concatenate([[s[0]] * 3, s, [s[-1]] * 3])
    q = section.find_joints(rows)
    found = []
    for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), start=1):
        difference = q
        for _ in range(order):
            difference = difference[1:] - difference[:-1]
        found.append(float((np.abs(difference) / cycle**order / limit).max()))
    caps = np.minimum(section.find_speed(rows[1:]), section.find_speed(rows[:-1]))
    found.append(float(((rows[1:] - rows[:-1]) / cycle / caps).max()))
    return np.array(found)


def assert_legal(section: Curve, s: Array, limits: Limits, cycle: float) -> None:
    """From 0 to the length, never backwards, inside every limit."""
    assert s[0] == 0.0
    assert s[-1] == section.length
    assert (np.diff(s) >= 0).all()
    ratios = worst(section, s, limits, cycle)
    assert (ratios <= ACCEPTED).all(), ratios
